"""Which tests execute which line of the package.

    python -m tests.support.line_map FOLDER [tests/truth tests/cli/test_map.py ...]

Each file of tests is run once, in a process of its own, with coverage (`pip install coverage`);
what stands in FOLDER already is kept, so that an interrupted run goes on. FOLDER also keeps the
package as it was when each file was run: lines that have moved since are found by comparing them.
"""

from __future__ import annotations

import argparse
import difflib
import hashlib
import json
import shutil
import sqlite3
from functools import cache
from pathlib import Path

from tests.support.forked_tests import ROOT, Copy

LIMIT = 1800.0  # seconds for a file of tests


def collect(folder: Path, tests: list[str]) -> None:
    """Run files of tests and write `NAME.json` and the data of coverage of each."""
    import coverage

    folder.mkdir(parents=True, exist_ok=True)
    copy = Copy(folder / "copy", folder / "cache")
    package = state_of(copy.folder / "camcli")
    if not (folder / package).exists():
        shutil.copytree(copy.folder / "camcli", folder / package)
    for file in tests:
        name = file.removeprefix("tests/").removesuffix(".py").replace("/", ".")
        if (folder / f"{name}.json").exists():
            continue
        parts = folder / "parts"
        shutil.rmtree(parts, ignore_errors=True)
        parts.mkdir()
        ran = copy.run_file(file, LIMIT, parts / "lines")
        data = coverage.CoverageData(str(folder / f"{name}.lines"))
        data.erase()
        for part in parts.iterdir():
            piece = coverage.CoverageData(str(part))
            try:
                piece.read()
                data.update(piece)
            except coverage.CoverageException as unreadable:  # a process that a test killed
                print(f"  {part.name}: {unreadable}", flush=True)
        data.write()
        data.close()
        told = {"seconds": ran.seconds, "ended": ran.ended, "in_time": ran.in_time,
                "package": package}  # fmt: skip
        (folder / f"{name}.json").write_text(json.dumps(told, indent=1))
        late = "" if ran.in_time else ", not ended in time"
        count, seconds = len(ran.ended), sum(ran.seconds.values())
        print(f"{name}: {count} tests, {seconds:.0f} s, failed {ran.failed}{late}", flush=True)


def state_of(package: Path) -> str:
    """The name of a state of the package: of all its files."""
    digest = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        digest.update(f"{file.relative_to(package)}\n".encode() + file.read_bytes())
    return f"package-{digest.hexdigest()[:12]}"


class LineMap:
    """The map in a folder, asked about the lines of the package as it stands now."""

    def __init__(self, folder: Path, root: Path = ROOT) -> None:
        self.folder, self.root = folder, root
        self.seconds: dict[str, float] = {}
        self.red: set[str] = set()  # failed, or were left out, when the map was made
        self.package: dict[str, str] = {}  # of each file of data, the state that was measured
        for file in sorted(folder.glob("*.json")):
            told = json.loads(file.read_text())
            self.seconds |= told["seconds"]
            self.red |= {test for test, how in told["ended"].items() if how != "passed"}
            self.package[file.stem] = told["package"]

    @cache  # noqa: B019
    def executed(self, file: str) -> dict[str, dict[int, set[str]]]:
        """The tests that execute each line of a file (`words/orbits.py`), by state measured."""
        found: dict[str, dict[int, set[str]]] = {}
        for name, package in self.package.items():
            lines = found.setdefault(package, {})
            data = self.folder / f"{name}.lines"
            with sqlite3.connect(f"file:{data}?mode=ro", uri=True) as base:
                rows = base.execute(
                    "select context.context, line_bits.numbits from line_bits"
                    " join file on file.id = line_bits.file_id"
                    " join context on context.id = line_bits.context_id where file.path like ?",
                    (f"%/project/camcli/{file}",),
                )
                for test, bits in rows:
                    if test:
                        for line in _numbers(bits):
                            lines.setdefault(line, set()).add(test)
        return found

    @cache  # noqa: B019
    def sizes(self) -> dict[str, int]:
        """How many lines of the package each test executes: a specific test executes few."""
        count: dict[str, int] = {}
        for data in sorted(self.folder.glob("*.lines")):
            with sqlite3.connect(f"file:{data}?mode=ro", uri=True) as base:
                rows = base.execute(
                    "select context.context, line_bits.numbits from line_bits"
                    " join context on context.id = line_bits.context_id"
                )
                for test, bits in rows:
                    count[test] = count.get(test, 0) + sum(byte.bit_count() for byte in bits)
        return count

    @cache  # noqa: B019
    def _was(self, file: str, package: str) -> dict[int, int]:
        """Which line of the measured file a line of today's is; none for a new one."""
        then = self.folder / package / file
        now = self.root / "camcli" / file
        if not then.exists():
            return {}
        match = difflib.SequenceMatcher(
            None, then.read_text().splitlines(), now.read_text().splitlines(), autojunk=False
        )
        return {
            b + n + 1: a + n + 1 for a, b, size in match.get_matching_blocks() for n in range(size)
        }

    def tests_of(self, file: str, lines: range) -> set[str]:
        """The tests that execute one of these lines of a file as it stands now."""
        found: set[str] = set()
        for package, executed in self.executed(file).items():
            was = self._was(file, package)
            for line in lines:
                if line in was:
                    found |= executed.get(was[line], set())
        return found

    def tests_in(self, file: str) -> list[str]:
        """All tests of a file of tests (`tests/cli/test_map.py`)."""
        return [test for test in self.seconds if test.split("::")[0] == file]


def _numbers(bits: bytes) -> list[int]:
    """The numbers whose bits are set."""
    return [8 * k + n for k, byte in enumerate(bits) for n in range(8) if byte >> n & 1]


def main() -> int:
    """Make the map, or go on with it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("tests", nargs="*", default=["tests"])
    asked = parser.parse_args()
    files = []
    for name in asked.tests:
        place = ROOT / name
        found = sorted(place.rglob("test_*.py")) if place.is_dir() else [place]
        files += [str(file.relative_to(ROOT)) for file in found]
    collect(asked.folder.resolve(), [file for file in files if file not in LEFT_OUT])
    return 0


LEFT_OUT = (
    "tests/test_house.py",
    "tests/test_installed.py",
    "tests/test_recipes.py",
)  # execute none


if __name__ == "__main__":
    raise SystemExit(main())
