"""Change one line of the program's meaning at a time and see whether a test notices.

    python tests/support/mutants.py [--only kernel] [--first 3] [--list]

Each mutant is made in a copy of the package; the tests named for its file run against the copy
until one fails. What no test notices is printed, and so are tests that fail without the change too;
either is a reason for exit code 1. A line here that no longer stands in the program is an error:
whoever moves the line moves its mutant.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
NOT_NOTICED = "NOT NOTICED"
FAILS_ANYWAY = "FAILS ANYWAY"  # the tests are red without the change, too


def copied(folder: Path) -> None:
    """A copy of what the tests need, in `folder`."""
    shutil.rmtree(folder, ignore_errors=True)
    for part in ("camcli", "tests", "configs"):
        shutil.copytree(ROOT / part, folder / part, ignore=lambda *_: ["__pycache__"])
    shutil.copy(ROOT / "pyproject.toml", folder)


def passes(tests: str, folder: Path) -> bool:
    """Whether tests, as words of pytest's command line, pass in a copy of the project."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-n", "0"]
    done = subprocess.run(
        [*command, *tests.split()], cwd=folder, env=environment, capture_output=True, check=False
    )
    if done.returncode not in (0, 1):
        raise SystemExit(done.stdout.decode()[-3000:])
    return done.returncode == 0


def survives(mutant: dict, folder: Path) -> bool:
    """True where the tests pass on a copy of the project in `folder` with the mutant's line."""
    copied(folder)
    target = folder / "camcli" / mutant["file"]
    text = target.read_text(encoding="utf-8")
    target.write_text(text.replace(mutant["line"], mutant["to"]), encoding="utf-8")
    return passes(mutant["tests"], folder)


@cache
def pass_unchanged(tests: str, folder: Path) -> bool:
    """Whether the tests pass without any change: only then does a failure notice a mutant."""
    copied(folder)
    return passes(tests, folder)


def mutants(only: str) -> list[dict]:
    """The list in mutants.toml; each line must stand in its file exactly once."""
    listed = tomllib.loads((HERE / "mutants.toml").read_text(encoding="utf-8"))["mutant"]
    wrong = [
        f"{m['file']}: {m['line']}"
        for m in listed
        if (ROOT / "camcli" / m["file"]).read_text(encoding="utf-8").count(m["line"]) != 1
    ]
    if wrong:
        raise SystemExit("not exactly once in the program:\n" + "\n".join(wrong))
    return [m for m in listed if m["file"].startswith(only)]


def verdict(mutant: dict, folder: Path) -> str:
    """What the tests say of a mutant."""
    if survives(mutant, folder):
        return NOT_NOTICED
    return "noticed" if pass_unchanged(mutant["tests"], folder) else FAILS_ANYWAY


def main() -> int:
    """Try every mutant; the number of those that no test noticed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="files that begin so")
    parser.add_argument("--first", type=int, default=0, help="number of the mutant to begin with")
    parser.add_argument("--list", action="store_true", help="only list them")
    asked = parser.parse_args()
    unnoticed = 0
    with tempfile.TemporaryDirectory() as folder:
        for n, mutant in enumerate(mutants(asked.only)):
            if n < asked.first:
                continue
            said = "" if asked.list else verdict(mutant, Path(folder) / "copy")
            unnoticed += said in (NOT_NOTICED, FAILS_ANYWAY)
            print(f"{n:3} {said:12} {mutant['file']}: {mutant['line']}", flush=True)
    return min(unnoticed, 1)


if __name__ == "__main__":
    raise SystemExit(main())
