"""The certificate of a run, checked by the checker that shares nothing with the rest."""

import subprocess
import sys
from importlib.resources import as_file, files
from pathlib import Path
from time import perf_counter

from pydantic import BaseModel

PROOF = "proof.json"
CONFIRMED = 0  # the checker's exit code where it confirms every statement


class CheckedCertificate(BaseModel):
    """What the checker said of a certificate: a line for each statement, then how many it confirms.

    bytes: of the file; seconds: of the checker's whole process.
    """

    bytes: int
    seconds: float
    confirmed: bool
    lines: list[str]


def check_certificate(folder: Path) -> CheckedCertificate | None:
    """Run the checker on the certificate in a folder, as its reader would; None if there is none.

    It runs in a process of its own, in which nothing of this program is at work.
    """
    path = folder / PROOF
    if not path.is_file():
        return None
    began = perf_counter()
    with as_file(files("camcli") / "check.py") as checker:
        words = [sys.executable, "-P", str(checker), str(path)]
        done = subprocess.run(words, capture_output=True, encoding="utf-8", check=False)
    return CheckedCertificate(
        bytes=path.stat().st_size,
        seconds=round(perf_counter() - began, 3),
        confirmed=done.returncode == CONFIRMED,
        lines=(done.stdout + done.stderr).splitlines(),
    )
