"""Which program made a result: a hash of its sources."""

import hashlib
from functools import cache
from pathlib import Path

# What can change a number or a word of a table: not the command line and its help texts, nor the
# pictures.
RESULTS = (
    "errors.py", "piece_faults.py", "quantities.py", "system.py", "kernel", "cams", "exact",
    "analysis", "parallel", "scene", "words", "api",
)  # fmt: skip
PICTURES = ("plots", "output")


@cache
def program_hash(pictures: bool = False) -> str:
    """SHA-256 of the sources that decide the numbers, or those and how they are drawn."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for name in (*RESULTS, *(PICTURES if pictures else ())):
        path = package / name
        found = (file for file in path.rglob("*") if file.suffix in (".py", ".mplstyle"))
        for source in sorted(found) if path.is_dir() else [path]:
            name = source.relative_to(package).as_posix()
            digest.update(name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()
