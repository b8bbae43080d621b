"""Which program made a result: a hash of its sources."""

import hashlib
import os
from collections.abc import Iterator
from functools import cache

# What can change a number or a word of a table: not the command line and its help texts, nor the
# pictures.
RESULTS = (
    "errors.py", "piece_faults.py", "quantities.py", "system.py", "kernel", "cams", "exact",
    "analysis", "parallel", "scene", "words", "api",
)  # fmt: skip
PICTURES = ("plots", "output")
SOURCES = (".py", ".mplstyle")  # endings


@cache
def program_hash(pictures: bool = False) -> str:
    """SHA-256 of the sources that decide the numbers, or those and how they are drawn."""
    package = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    digest = hashlib.sha256()
    for name in (*RESULTS, *(PICTURES if pictures else ())):
        for source in sorted(_sources(package, name)):
            with open(os.path.join(package, source), "rb") as file:
                digest.update(source.encode() + b"\0" + file.read())
    return digest.hexdigest()


def _sources(package: str, name: str) -> Iterator[str]:
    """The sources in a file or folder of the package, by their paths from there with a `/`."""
    if name.endswith(SOURCES):
        yield name
        return
    with os.scandir(os.path.join(package, name)) as entries:
        for entry in entries:
            if entry.name == "__pycache__":
                continue
            if entry.is_dir():
                yield from _sources(package, f"{name}/{entry.name}")
            elif entry.name.endswith(SOURCES):
                yield f"{name}/{entry.name}"
