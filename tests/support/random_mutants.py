"""Change lines drawn at random, one at a time, and see whether a test notices.

    python -m tests.support.random_mutants --map FOLDER [--number 40] [--seed 1] [words api/rows.py]

FOLDER has a map of which tests execute which line (`tests/support/line_map.py`). Each change is
made in a copy of the project; of the tests that execute the changed line the quick ones that
execute little else come first, and the first failure ends the run. A test that fails without the
change as well says nothing: it is left out from then on. A change is `undecided` when the limit of
time came before the last of its tests. Files of the kernel are left out unless they are named: a
change of them is compiled for half a minute.

The changes and what became of them stand in `--results FILE`, a JSON line each; a file that
stands there already is gone on with. `--again` tries those of the file again that were not noticed.
`--changes FILE` judges changes written by hand in place of drawn ones: JSON lines with `file`,
`line` and `to`, as in mutants.toml.
"""

from __future__ import annotations

import argparse
import ast
import json
import random
import re
import tempfile
import time
from collections import Counter
from dataclasses import asdict
from functools import cache
from pathlib import Path

from tests.support.changes import Change, changes_meaning, changes_of
from tests.support.forked_tests import ROOT, Copy, Ran
from tests.support.line_map import LineMap

PACKAGE = ROOT / "camcli"
LARGE = 5000  # lines executed by a test, which count as much as a second of its time
QUICK = 1.5  # seconds that the tests of the first run take together; ten times that the second
HANGS = 20.0  # times as long as it took is too long for a test
SHARED = re.compile(
    r"scope=\"|@cache|lru_cache"
)  # a file whose tests share what the first one made
SHEETS = {  # tests that compare what is written from the program with it, and their seconds
    "tests/test_house.py::test_schema_beside_the_configs_is_current": 1.0,
    "tests/guide/test_guide.py::test_the_reference_is_what_the_program_says": 2.0,
}
NOTICED, UNNOTICED, UNDECIDED, UNTESTED = "noticed", "not noticed", "undecided", "no test"


def python_files(asked: list[str]) -> list[Path]:
    """The files of the package that are asked for by folder or name; all but the kernel."""
    every = sorted(PACKAGE.rglob("*.py"))
    if not asked:
        return [file for file in every if file.relative_to(PACKAGE).parts[0] != "kernel"]
    return [
        file for file in every if any(PACKAGE / name in (file, *file.parents) for name in asked)
    ]


def drawn(files: list[Path], number: int, seed: int) -> list[tuple[str, Change]]:
    """Changes on lines of the files, all lines alike, one change a line."""
    chance = random.Random(seed)
    allowed = {file: changes_of(file.read_text(encoding="utf-8")) for file in files}
    lines = [(file, line) for file, found in allowed.items() for line in found]
    chance.shuffle(lines)
    changes: list[tuple[str, Change]] = []
    for file, line in lines:
        change = chance.choice(allowed[file][line])
        if len(changes) < number and changes_meaning(change, file.read_text(encoding="utf-8")):
            changes.append((str(file.relative_to(PACKAGE)), change))
    return changes


def by_hand(file: str, line: str, to: str) -> Change:
    """A change written by hand: `line`, which stands once in a file of the package, becomes `to`.

    Of the names to which an import gives a value, the last one before the change is taken.
    """
    text = (PACKAGE / file).read_text(encoding="utf-8")
    if text.count(line) != 1:
        raise SystemExit(f"{file}: stands {text.count(line)} times in it: {line}")
    begin = text.index(line)
    first = text.count("\n", 0, begin) + 1
    last = first + line.rstrip("\n").count("\n")
    function: str | None = None
    names: tuple[str, ...] = ()
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.stmt) or not node.lineno <= first <= node.end_lineno:
            continue
        if isinstance(node, ast.FunctionDef) and node.body[0].lineno <= last:
            function = node.name
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = tuple(target.id for target in targets if isinstance(target, ast.Name))
    return Change(first, last, begin, line, to, "by hand", function, () if function else names)


class Judge:
    """Runs tests on changes in a copy of the project."""

    def __init__(self, lines: LineMap, copy: Copy, limit: float) -> None:
        self.lines, self.copy, self.limit = lines, copy, limit
        self.red = set(lines.red)
        lines.seconds.update(SHEETS)

    def judge(self, file: str, change: Change) -> dict:
        """What the tests say of a change: verdict, by which test, and after how many."""
        executing = self.tests_for(file, change)
        tests = self.ranked(self.with_shared(executing), executing)
        end = time.monotonic() + self.limit
        said = {"verdict": UNNOTICED if tests else UNTESTED, "tests": len(tests), "run": 0}
        place = self.copy.folder / "camcli" / file
        text = place.read_text(encoding="utf-8")
        place.write_text(change.made_in(text), encoding="utf-8")
        try:
            quick = QUICK
            while tests and said["verdict"] == UNNOTICED:
                now, tests = self._first(tests, quick)
                quick *= 10.0
                ran = self.copy.run_chosen(now, max(1.0, end - time.monotonic()))
                said["run"] += len(ran.ended)
                if self._take(ran, said, place, text, change):
                    rest = [test for test in now if test not in ran.ended]
                    tests = [test for test in (*rest, *tests) if test not in self.red]
        finally:
            place.write_text(text, encoding="utf-8")
        return said

    def _take(self, ran: Ran, said: dict, place: Path, text: str, change: Change) -> bool:
        """Judge a run; whether a test ended it that is red, so that the rest has yet to run.

        A failure notices the change where the test passes without it.
        """
        failed = [test for test in ran.failed if test not in self.red]
        if failed:
            known = self._known(failed[0])
            place.write_text(text, encoding="utf-8")
            without = self.copy.run_chosen(known, self.limit)
            place.write_text(change.made_in(text), encoding="utf-8")
            if without.failed or not without.in_time:
                self.red |= set(known)
                return True
            said |= {"verdict": NOTICED, "by": failed[0]}
        elif not ran.ended and ran.in_time:
            said |= {"verdict": UNDECIDED, "by": "no test was run"}
        elif not ran.in_time:
            usual = self.lines.seconds.get(ran.running or "", 0.0)
            hangs = ran.running is not None and ran.running_for > HANGS * (1.0 + usual)
            said |= {"verdict": NOTICED if hangs else UNDECIDED, "by": f"{ran.running} (time)"}
        return False

    def _known(self, test: str) -> list[str]:
        """A test alone, or all of a file that could not be imported."""
        return [test] if "::" in test else self.lines.tests_in(test)

    def _first(self, tests: list[str], quick: float) -> tuple[list[str], list[str]]:
        """The tests of the next run, which take so many seconds together, and the rest."""
        total = 0.0
        for n, test in enumerate(tests):
            total += self.lines.seconds[test]
            if total > quick:
                return tests[: n + 1], tests[n + 1 :]
        return tests, []

    def ranked(self, tests: set[str], executing: set[str]) -> list[str]:
        """Tests, the quickest and most specific first; those that do not execute the line last."""
        sizes, seconds = self.lines.sizes(), self.lines.seconds

        def rank(test: str) -> tuple[bool, float, str]:
            return test not in executing, seconds[test] + sizes.get(test, 0) / LARGE, test

        return sorted(tests, key=rank)

    def tests_for(self, file: str, change: Change) -> set[str]:
        """The green tests that execute a changed line, or what its value is named in."""
        found = self.lines.tests_of(file, range(change.line, change.last_line + 1))
        if change.function is None:
            found = set()
            for name in change.names:
                for other, numbers in lines_with(name).items():
                    for number in numbers:
                        found |= self.lines.tests_of(other, range(number, number + 1))
            if not found:
                found = self.lines.tests_of(file, range(1, 10_000))
            found |= set(SHEETS) | self._naming(change.names)
        return {test for test in found if test in self.lines.seconds} - self.red

    def _naming(self, names: tuple[str, ...]) -> set[str]:
        """The tests of each file of tests in which a name stands, such as that of a table."""
        found: set[str] = set()
        for tests in {file_of(test) for test in self.lines.seconds}:
            text = (ROOT / tests).read_text(encoding="utf-8")
            if any(re.search(rf"\b{re.escape(name)}\b", text) for name in names):
                found |= set(self.lines.tests_in(tests))
        return found

    def with_shared(self, executing: set[str]) -> set[str]:
        """With the other tests of a file whose tests share what the first one made."""
        found = set(executing)
        for tests in {file_of(test) for test in executing}:
            if SHARED.search((ROOT / tests).read_text(encoding="utf-8")):
                found |= set(self.lines.tests_in(tests)) - self.red
        return found


def file_of(test: str) -> str:
    """The file of a test."""
    return test.split("::")[0]


@cache
def lines_with(name: str) -> dict[str, list[int]]:
    """The lines of the package in which a name stands, by file."""
    word = re.compile(rf"\b{re.escape(name)}\b")
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        lines = file.read_text(encoding="utf-8").splitlines()
        numbers = [n for n, line in enumerate(lines, 1) if word.search(line)]
        if numbers:
            found[str(file.relative_to(PACKAGE))] = numbers
    return found


def shown(entry: dict) -> None:
    """Print a change and what became of it."""
    change = entry["change"]
    print(f"{entry['verdict']:11} {entry['file']}:{change['line']} [{change['kind']}]", end=" ")
    print(f"{entry['run']} of {entry['tests']} tests, {entry['seconds']} s")
    print(f"    {change['old']}\n    {change['new']}", flush=True)


def told(entries: list[dict]) -> None:
    """Print the count of each verdict by area, and what was not noticed."""
    areas: dict[str, Counter] = {}
    for entry in entries:
        areas.setdefault(entry["file"].split("/")[0], Counter())[entry["verdict"]] += 1
    for area, count in sorted(areas.items()):
        words = ", ".join(f"{count[verdict]} {verdict}" for verdict in sorted(count))
        print(f"{area:16} {count[NOTICED]} of {count.total()}: {words}")
    noticed = sum(count[NOTICED] for count in areas.values())
    print(f"{'all':16} {noticed} of {len(entries)}")


def main() -> int:
    """Draw changes, judge each, and say what was noticed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", help="folders or files of the package")
    parser.add_argument("--map", type=Path, required=True, help="folder of the map")
    parser.add_argument("--number", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds for a change")
    parser.add_argument("--results", type=Path, default=Path("random_mutants.jsonl"))
    parser.add_argument("--again", action="store_true", help="only those that were not noticed")
    parser.add_argument("--changes", type=Path, help="changes written by hand, JSON lines")
    asked = parser.parse_args()
    old = []
    if asked.results.exists():
        old = [json.loads(line) for line in asked.results.read_text().splitlines()]
    if asked.again:
        changes = [
            (entry["file"], Change(**entry["change"]))
            for entry in old
            if entry["verdict"] != NOTICED
        ]
        asked.results = asked.results.with_suffix(".again.jsonl")
        old = []
    elif asked.changes:
        written = [json.loads(line) for line in asked.changes.read_text().splitlines()]
        changes = [
            (entry["file"], by_hand(entry["file"], entry["line"], entry["to"])) for entry in written
        ][len(old) :]
    else:
        changes = drawn(python_files(asked.files), asked.number, asked.seed)[len(old) :]
    with tempfile.TemporaryDirectory() as folder:
        lines = LineMap(asked.map.resolve())
        copy = Copy(Path(folder), lines.folder / "cache")
        judge = Judge(lines, copy, asked.limit)
        for file, change in changes:
            begun = time.monotonic()
            said = judge.judge(file, change)
            entry = {
                "file": file,
                "change": asdict(change),
                **said,
                "seconds": round(time.monotonic() - begun, 1),
            }
            old.append(entry)
            with open(asked.results, "a") as results:
                results.write(json.dumps(entry) + "\n")
            shown(entry)
    told(old)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
