"""Shared by all tests: the chapter's machine, and the command line as a user runs it."""

from __future__ import annotations

import contextlib
import csv
import gc
import io
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Container, Generator, Iterable, Iterator
from functools import partial
from importlib.metadata import version
from math import radians
from pathlib import Path

import pytest
from mpmath import mp

from camcli.analysis.integrate import Orbit, Settings, Start, with_turns
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.analysis.orbits.identify import identify
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.cams.compile import phase_of
from camcli.scene import load_scene
from camcli.system import Follower, System

os.environ.pop("COLUMNS", None)  # tables are as wide as where no person watches
# Some hundred processes of the command are started: each would compile the whole package anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
mp.dps = 40  # of every reference, also of those that a module computes when it is imported
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # a shell starts what it runs in the background (`pytest &`) with interrupts ignored, and `cam`
    # keeps them so
    signal.signal(signal.SIGINT, signal.default_int_handler)
NUMBA = tuple(int(part) for part in version("numba").split(".")[:2])
own_way = pytest.mark.skipif(
    NUMBA < (0, 62), reason="this numba compiles the kernel by its public functions"
)


@pytest.fixture(autouse=True)
def forty_digits() -> Iterator[None]:
    """Each test begins with 40 digits in mpmath, whatever the one before it left."""
    with mp.workdps(40):
        yield


def chapter_system(strobe_deg: float = 0.0, **follower) -> System:
    """The chapter's machine with some constants of the follower replaced."""
    scene = load_scene(None)
    values = {**scene.follower.model_dump(), **follower}
    return System.build(Follower(**values), scene.cam, phase_of(strobe_deg))


def solve_from(
    system: System,
    rpm: float,
    run: Settings,
    start: Start | None = None,
    longest: int = LONGEST_PERIOD,
) -> PeriodicOrbit | None:
    """The stable orbit a motion from `start` has come close to after run.transient turns."""
    long_enough = with_turns(run, run.transient, 2 * longest + 2)
    return identify(system, rpm, Orbit(system, rpm, long_enough, start).run(), longest)


def settings(transient=0, record=1, tolerance=1e-9, budget=1_000_000, **start) -> Settings:
    """Settings of a run with a start given as q, v, theta_deg."""
    if "theta_deg" in start:
        start["theta"] = radians(start.pop("theta_deg"))
    return Settings(transient, record, tolerance, budget, Start(**start))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Soaks are asked for by CAMCLI_SOAK, whatever other tests are chosen, those of `ci` by CI.

    The types come first: they keep one processor busy while the other one compiles the kernel.
    """
    if "CAMCLI_SOAK" not in os.environ:
        items[:] = [item for item in items if not item.get_closest_marker("soak")]
    if not {"CAMCLI_NO_SKIPS", "CAMCLI_SOAK"} & os.environ.keys():
        items[:] = [item for item in items if not item.get_closest_marker("ci")]
    items.sort(key=lambda item: not item.name.endswith("[types]"))


def pytest_collection_finish() -> None:
    """What stands in memory by now stays: it is not searched for garbage again and again."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test that is left out is a failure where CAMCLI_NO_SKIPS asks for all of them."""
    report = yield
    if report.skipped and "CAMCLI_NO_SKIPS" in os.environ:
        report.outcome = "failed"
        report.longrepr = f"left out: {report.longrepr}"
    return report


def some_in_ci(cases: Iterable, quick: Container) -> list:
    """Cases as parameters: those of `quick` are run everywhere, the others, more of it, by CI."""
    return [one if one in quick else pytest.param(one, marks=pytest.mark.ci) for one in cases]


def rows(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV, by column."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def refused(done: subprocess.CompletedProcess, *said: str) -> None:
    """Exit code 2, in words that are not too many."""
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert "internal fault" not in done.stderr
    assert len(done.stderr) < 3000
    assert all(words in done.stderr for words in said), done.stderr


@pytest.fixture(scope="session")
def chapter() -> System:
    return chapter_system()


def cam_in(folder: Path, *line: str, code: int | None = None) -> subprocess.CompletedProcess:
    """Run `cam` in a folder, in this process; returns exit code, stdout and stderr.

    Each argument is a part of the command's line, split as a shell does. code: what the exit code
    must be.
    """
    from camcli.cli.app import app
    from camcli.cli.exit_codes import guarded

    words = [word for part in line for word in shlex.split(part)]
    out, said = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(said)
    ):  # fmt: skip
        ended = guarded(lambda: app(words, standalone_mode=False), "--json" in words)
    assert code in (None, ended), said.getvalue()
    return subprocess.CompletedProcess(words, ended, out.getvalue(), said.getvalue())


@pytest.fixture
def cam(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess]:
    """`cam` in an empty folder."""
    return partial(cam_in, tmp_path)


@pytest.fixture
def short_samples(monkeypatch):
    """--dry-run runs its smallest sample alone: for tests of something else than its numbers."""
    monkeypatch.setattr("camcli.cli.forecast.ENOUGH", 0.0)
