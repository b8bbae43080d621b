"""The same bytes however the kernel runs and however the work is cut."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from camcli.analysis import integrate as engine
from camcli.analysis.sweep import sweep
from camcli.kernel import backend
from camcli.kernel.forms import PLAIN
from camcli.parallel import Work
from tests.conftest import settings
from tests.support import digest
from tests.support.kernel_runs import run, system
from tests.support.long_runs import but_record, files

ROOT = Path(__file__).resolve().parents[2]
VARIANTS = {
    "compiled": ({"CAMCLI_KERNEL": "compiled"}, True),
    "numba without its compiler": (
        {"CAMCLI_KERNEL": "compiled", "NUMBA_DISABLE_JIT": "1"}, False,
    ),
    # a contraction of a product and a sum would be seen between the first and plain Python too
    "compiled for any processor": (
        {"CAMCLI_KERNEL": "compiled", "NUMBA_CPU_NAME": "generic"}, True,
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def plain():
    """The hash of the orbits and roots, by plain Python."""
    state = hashlib.sha256()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CAMCLI_KERNEL", "python")
        patch.setattr(backend, "_compiled", None)
        assert not backend.for_work(0).compiled
        digest.digest(state.update)
        digest.digest_roots(state.update)
    return state.hexdigest()


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.soak] * ("any" in n)) for n in VARIANTS]
)
def test_every_way_to_run_gives_the_same_bytes(plain, tmp_path, name):
    """As plain Python does, in a process of its own."""
    inherited = ("CAMCLI_KERNEL", "NUMBA_CPU_NAME", "NUMBA_DISABLE_JIT")
    base = {key: value for key, value in os.environ.items() if key not in inherited}
    changes, compiled = VARIANTS[name]
    environment = {**base, **changes, "PYTHONPATH": str(ROOT)}
    if "NUMBA_CPU_NAME" in changes:
        environment["XDG_CACHE_HOME"] = str(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.digest"],
        cwd=ROOT, env=environment, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(compiled), plain]


@pytest.mark.parametrize(
    "line",
    [
        "basins --rpm 700 --cells 4,3",
        "classify --rpm 738:746 --points 3 --set run.record=150",
        "detach --rpm 112:128 --points 3 --set detach.settle=1",
    ],
)
def test_a_command_writes_the_same_by_either_kernel_and_on_two_threads(
    cam, tmp_path, monkeypatch, line
):
    for name, threads, kernel in (("one", 1, "python"), ("two", 2, "compiled")):
        monkeypatch.setenv("CAMCLI_KERNEL", kernel)
        cam(line, f"--no-plot --threads {threads} -o {name}", code=0)
    one, two = (but_record(files(tmp_path / name)) for name in ("one", "two"))
    assert one == two


def parts_of(tape):
    columns = (tape.kind, tape.period, tape.theta, tape.u, tape.strobe_q, tape.strobe_w)
    counts = tape.impacts, tape.chatter
    rows = [[float(x) for x in column] for column in columns + counts]
    return rows, tape.status, tape.cost, tape.detachments, tape.periods


def always_plain(monkeypatch):
    """The first steps in plain Python, and the next ones too: nothing is ever compiled."""
    monkeypatch.setattr(backend, "current", lambda: PLAIN)
    monkeypatch.setattr(backend, "compiled", lambda: PLAIN)
    monkeypatch.setattr(backend, "may_compile", lambda: True)


@pytest.mark.parametrize(("rpm", "damping"), [(745.0, 0.0), (190.0, 0.0), (520.0, 3.0)])
@pytest.mark.parametrize("steps", [1, 7, 100])
def test_slices_do_not_change_an_orbit(monkeypatch, rpm, damping, steps):
    whole = run(rpm, system(damping=damping), record=20, transient=3)
    always_plain(monkeypatch)
    orbit = engine.Orbit(system(damping=damping), rpm, settings(3, 20))
    assert parts_of(orbit.run(portions=engine.Portions(plain_steps=steps))) == parts_of(whole)


@pytest.mark.parametrize("capacity", [1, 3, 64])
def test_the_room_for_the_log_does_not_change_an_orbit(capacity):
    whole = run(190.0, record=12)
    orbit = engine.Orbit(system(), 190.0, settings(record=12))
    portions = engine.Portions(first_rows=capacity, most_rows=capacity)
    assert parts_of(orbit.run(portions=portions)) == parts_of(whole)


def test_what_is_logged_does_not_change_an_orbit():
    orbits = [engine.Orbit(system(), 745.0, settings(record=30)) for _ in range(3)]
    records = [o.run(events=e, strobes=s) for o, (e, s) in zip(
        orbits, [(True, True), (False, True), (True, False)], strict=True
    )]  # fmt: skip
    assert list(records[0].strobe_w) == list(records[1].strobe_w)
    assert list(records[0].theta) == list(records[2].theta)
    first, *others = (replace(orbit.state, logged=0) for orbit in orbits)
    assert others == [first, first]


def test_lanes_do_not_know_of_each_other():
    """Order of speeds and number of threads change no digit."""
    rpms = [745.0, 190.0, 361.0, 682.0, 100.0, 520.0]
    wanted = settings(20, 30)
    first = sweep(system(), rpms, wanted, work=Work(threads=1)).speeds
    second = sweep(system(), rpms[::-1], wanted, work=Work(threads=2)).speeds[::-1]
    for a, b in zip(first, second, strict=True):
        assert a.rpm == b.rpm
        assert a.label == b.label
        assert [list(x) for x in a.impacts] == [list(x) for x in b.impacts]
        assert [list(x) for x in a.strobe] == [list(x) for x in b.strobe]


def test_the_digest_sees_one_bit():
    """A check of the check: another last bit of one speed changes the hash."""
    one, two = bytearray(), bytearray()
    digest.digest(one.extend, [(745.0, {}, {}, 100)])
    digest.digest(two.extend, [(745.0000000000001, {}, {}, 100)])
    assert one != two


@pytest.mark.parametrize(("steps", "capacity"), [(200_000, 256), (1000, 256), (200_000, 3)])
def test_orbits_that_are_run_together_are_those_of_each_alone(steps, capacity):
    """Their records, loads and states at the end, also in slices and where the log grows."""
    machine, speeds = system(), (745.0, 190.0, 100.0, 345.0, 700.0)
    runs = [settings(record=30 + k, transient=k % 3) for k in range(len(speeds))]
    pairs = list(zip(speeds, runs, strict=True))
    backend.compiled()
    alone = [engine.Orbit(machine, rpm, run) for rpm, run in pairs]
    wanted = [engine.run_all([orbit], loads=True)[0] for orbit in alone]
    portions = engine.Portions(compiled_steps=steps, first_rows=capacity, most_rows=capacity)
    together = [engine.Orbit(machine, rpm, run) for rpm, run in pairs]
    found = engine.run_all(together, loads=True, portions=portions)
    assert [parts_of(one) for one in found] == [parts_of(one) for one in wanted]
    assert [(one.loads, one.repeats, one.near) for one in found] == [
        (one.loads, one.repeats, one.near) for one in wanted
    ]
    assert [orbit.state for orbit in together] == [orbit.state for orbit in alone]
    assert len({one.repeats for one in found}) > 1
