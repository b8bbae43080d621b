"""Change one line of the program's meaning at a time and see whether a test notices.

    python -m tests.support.mutants [--only kernel] [--first 3] [--list]

Each mutant is made in a copy of the package; the tests named for its file run against the copy
until one fails. What no test notices is printed, and so are tests that fail without the change too;
either is a reason for exit code 1. A line here that no longer stands in the program is an error:
whoever moves the line moves its mutant.
"""

from __future__ import annotations

import argparse
import tempfile
import tomllib
from functools import cache
from pathlib import Path

from tests.support.forked_tests import ROOT, Copy

HERE = Path(__file__).parent
LIMIT = 3600.0  # seconds for the tests of a mutant
NOT_NOTICED = "NOT NOTICED"
FAILS_ANYWAY = "FAILS ANYWAY"  # the tests are red without the change, too


def passes(tests: str, copy: Copy) -> bool:
    """Whether tests, as words of pytest's command line, pass in a copy of the project."""
    ran = copy.run_words(tests.split(), LIMIT)
    if not ran.ended:
        raise SystemExit(ran.output[-3000:])
    return ran.in_time and not ran.failed


def survives(mutant: dict, copy: Copy) -> bool:
    """True where the tests pass on a copy of the project with the mutant's line."""
    target = copy.folder / "camcli" / mutant["file"]
    text = target.read_text(encoding="utf-8")
    target.write_text(text.replace(mutant["line"], mutant["to"]), encoding="utf-8")
    try:
        return passes(mutant["tests"], copy)
    finally:
        target.write_text(text, encoding="utf-8")


@cache
def pass_unchanged(tests: str, copy: Copy) -> bool:
    """Whether the tests pass without any change: only then does a failure notice a mutant."""
    return passes(tests, copy)


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


def verdict(mutant: dict, copy: Copy) -> str:
    """What the tests say of a mutant."""
    if survives(mutant, copy):
        return NOT_NOTICED
    return "noticed" if pass_unchanged(mutant["tests"], copy) else FAILS_ANYWAY


def main() -> int:
    """Try every mutant; the number of those that no test noticed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="files that begin so")
    parser.add_argument("--first", type=int, default=0, help="number of the mutant to begin with")
    parser.add_argument("--list", action="store_true", help="only list them")
    asked = parser.parse_args()
    unnoticed = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = None if asked.list else Copy(Path(folder), Path(folder) / "cache")
        for n, mutant in enumerate(mutants(asked.only)):
            if n < asked.first:
                continue
            said = "" if copy is None else verdict(mutant, copy)
            unnoticed += said in (NOT_NOTICED, FAILS_ANYWAY)
            print(f"{n:3} {said:12} {mutant['file']}: {mutant['line']}", flush=True)
    return min(unnoticed, 1)


if __name__ == "__main__":
    raise SystemExit(main())
