"""Tests run in a copy of the project by processes that begin with all libraries imported.

A `Copy` is a folder with the project's files, whose package may be changed while the worktree stays
as it is. Each run of tests is a fork of this process, which has the libraries in memory but nothing
of `camcli`: the fork imports the package from the copy, as it stands there at that moment.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LIBRARIES = (
    "flint", "hypothesis", "matplotlib.backends.backend_agg", "matplotlib.pyplot", "mpmath",
    "numba", "numpy", "pydantic", "rich.console", "rich.table", "scipy.integrate", "scipy.optimize",
    "typer", "typer.testing", "yaml",
)  # fmt: skip
START = """import os
import coverage
coverage.process_startup()
"""
SETTINGS = """[run]
data_file = {data}
parallel = true
context = ${{CAMCLI_TEST-}}
include = {package}/*
disable_warnings = no-data-collected, module-not-imported, module-not-measured
"""


@dataclass(frozen=True)
class Ran:
    """What a run of tests came to: how each test ended, in order, and how long it took."""

    ended: dict[str, str]
    seconds: dict[str, float]
    running: str | None  # the test that the limit of time interrupted
    running_for: float
    in_time: bool
    output: str

    @property
    def failed(self) -> list[str]:
        """The tests that failed."""
        return [test for test, how in self.ended.items() if how == "failed"]


class Recorder:
    """A plugin of pytest: writes a line when a test begins and when it ends."""

    def __init__(self, report: Path, measure=None) -> None:
        self.report, self.measure = report, measure
        self.report.write_text("")

    def _write(self, *entry: object) -> None:
        with open(self.report, "a") as file:
            file.write(json.dumps(entry) + "\n")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, bool, bool]:
        os.environ["CAMCLI_TEST"] = item.nodeid
        if self.measure is not None:
            self.measure.switch_context(item.nodeid)
        self._write("begin", item.nodeid, time.time())
        return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._write(report.when, report.nodeid, report.outcome, report.duration)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self._write("call", report.nodeid, "failed", 0.0)


def read_report(report: Path, in_time: bool, output: str) -> Ran:
    """What a recorder wrote."""
    ended: dict[str, str] = {}
    seconds: dict[str, float] = {}
    running, since = None, 0.0
    for line in report.read_text().splitlines() if report.exists() else []:
        when, test, *rest = json.loads(line)
        if when == "begin":
            running, since = test, rest[0]
            continue
        outcome, duration = rest
        seconds[test] = seconds.get(test, 0.0) + duration
        if outcome != "passed" or test not in ended:
            ended[test] = outcome
        if when == "teardown":
            running = None
    return Ran(ended, seconds, running, time.time() - since, in_time, output)


class Chosen:
    """A plugin of pytest: runs these tests alone, in this order; one without its case has all."""

    def __init__(self, tests: list[str]) -> None:
        self.place = {test: n for n, test in enumerate(tests)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        chosen = [item for item in items if self._place_of(item) is not None]
        items[:] = sorted(chosen, key=self._place_of)

    def _place_of(self, item: pytest.Item) -> int | None:
        """The place of a test; all cases of one that is named without a case have its place."""
        return self.place.get(item.nodeid, self.place.get(item.nodeid.split("[")[0]))


class Copy:
    """A copy of the project in `folder`, with a folder beside it for what its runs leave.

    cache: where compiled kernels are kept, also for the next copy.
    """

    def __init__(self, folder: Path, cache: Path) -> None:
        self.folder, self.scratch, self.cache = folder / "project", folder / "scratch", cache
        shutil.rmtree(self.folder, ignore_errors=True)
        self.scratch.mkdir(parents=True, exist_ok=True)
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout  # fmt: skip
        for name in listed.split("\0"):
            if name and (ROOT / name).is_file():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, self.folder / name)
        for name in LIBRARIES:
            importlib.import_module(name)
        if "camcli" in sys.modules:
            raise SystemExit("camcli is imported already: a change of it would not be seen")

    def run_chosen(self, tests: list[str], limit: float) -> Ran:
        """Run tests file by file until one fails, at most `limit` seconds."""
        files = list(dict.fromkeys(test.split("::")[0] for test in tests))
        in_order = sorted(tests, key=lambda test: files.index(test.split("::")[0]))
        return self._run([*files, "-x"], limit, [Chosen(in_order)], None)

    def run_file(self, file: str, limit: float, lines: Path) -> Ran:
        """Run a file of tests and measure which test executes which line.

        lines: where the data of coverage go; those of other processes get a suffix.
        """
        return self._run([file], limit, [], lines)

    def run_words(self, words: list[str], limit: float) -> Ran:
        """Run what words of pytest's command line name until one fails, at most `limit` seconds."""
        return self._run([*words, "-x"], limit, [], None)

    def _run(self, words: list[str], limit: float, plugins: list, lines: Path | None) -> Ran:
        """Run pytest in a fork of this process."""
        report, output = self.scratch / "report.jsonl", self.scratch / "output.txt"
        report.unlink(missing_ok=True)
        child = os.fork()
        if child == 0:
            self._become_pytest(words, report, output, plugins, lines)
        in_time = _ends_within(child, limit)
        return read_report(report, in_time, output.read_text(errors="replace"))

    def _become_pytest(
        self, words: list[str], report: Path, output: Path, plugins: list, lines: Path | None
    ) -> None:
        """Run pytest in this process, which a fork has made, and end it."""
        code = 70
        try:
            os.setsid()
            os.chdir(self.folder)
            to = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(to, 1)
            os.dup2(to, 2)
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            sys.path[:] = [place for place in sys.path if place not in ("", str(ROOT))]
            for name in [name for name in sys.modules if name.split(".")[0] == "tests"]:
                del sys.modules[name]
            os.environ["PYTHONPATH"] = str(self.folder)
            os.environ["XDG_CACHE_HOME"] = str(self.cache)
            os.environ["CAMCLI_NO_SKIPS"] = "1"  # with the tests marked `ci`
            os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
            sys.dont_write_bytecode = True
            os.environ.pop("COLUMNS", None)
            sys.argv = ["pytest"]
            measure = self._measure(lines) if lines else None
            usual = ["-p", "no:cacheprovider", "-n", "0", "--basetemp", str(self.scratch / "tmp")]
            code = int(pytest.main([*usual, *words], plugins=[*plugins, Recorder(report, measure)]))
            if measure is not None:
                measure.stop()
                measure.save()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)

    def _measure(self, lines: Path):
        """Coverage of the copy's package, begun here and in every process that a test starts."""
        import coverage

        settings, start = self.scratch / "coveragerc", self.scratch / "site"
        start.mkdir(exist_ok=True)
        (start / "sitecustomize.py").write_text(START)
        package = self.folder / "camcli"
        settings.write_text(SETTINGS.format(data=lines, package=package))
        os.environ["COVERAGE_PROCESS_START"] = str(settings)
        site = str(Path(coverage.__file__).parents[1])
        os.environ["PYTHONPATH"] = os.pathsep.join((str(self.folder), str(start), site))
        measure = coverage.Coverage(
            data_file=str(lines), data_suffix=True, config_file=False, include=[f"{package}/*"]
        )
        measure.start()
        return measure


def _ends_within(child: int, limit: float) -> bool:
    """Wait for a process; whatever belongs to its session is killed at the end."""
    end = time.monotonic() + limit
    done = 0
    while not done and time.monotonic() < end:
        done, _ = os.waitpid(child, os.WNOHANG)
        time.sleep(0.02)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(child, signal.SIGKILL)
    if not done:
        os.waitpid(child, 0)
    return bool(done)
