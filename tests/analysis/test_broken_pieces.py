"""A speed or a motion that broke has the columns of a whole one, of the same kinds, but no rows."""

from __future__ import annotations

from functools import partial
from importlib import import_module

import numpy as np
import pytest

import camcli
from camcli.analysis import classify, motion_at_speed
from camcli.analysis.integrate import Cost, Orbit, Settings, Start
from camcli.analysis.labels import UNDECIDED
from camcli.analysis.motion_at_speed import SpeedTask
from camcli.errors import Status
from camcli.piece_faults import PieceFault, piece
from camcli.system import omega_of
from tests.conftest import chapter_system

FAULT = PieceFault("rpm = 700.0", "ZeroDivisionError", "camcli/x.py:1, f", "Traceback")
SETTINGS = Settings(3, 4, 1e-9, 1000)


def same_kinds(broken, whole) -> None:
    for ours, other in zip(broken, whole, strict=True):
        assert (len(ours), type(ours)) == (0, type(other))
        assert len(other) > 0
        assert getattr(ours, "dtype", None) == getattr(other, "dtype", None)


@pytest.mark.parametrize("wanted", [("impacts", "strobe"), ("impacts",), ("strobe",), ()])
def test_a_speed_that_broke(wanted):
    def setup(rpm):
        if rpm == 650.0:
            raise ZeroDivisionError
        return chapter_system(), rpm, SETTINGS

    kept = {name: name in wanted for name in ("impacts", "strobe")}
    task = SpeedTask("rpm", setup, **kept, lyapunov=False, turns=14.0, turns_each=7.0)
    whole, broken = task(700.0), task(650.0)
    assert (broken.value, broken.label, broken.status) == (650.0, UNDECIDED, Status.FAULT)
    assert (broken.impact_count, broken.cost) == (None, Cost())
    assert np.isnan(broken.rpm)  # it is the machine that could not be made
    assert task._failed(0.8, 700.0, FAULT).rpm == 700.0
    assert broken.fault.piece == "rpm = 650.0"
    for name in ("impacts", "strobe"):
        ours, other = getattr(broken, name), getattr(whole, name)
        assert (ours is None, other is None) == (name not in wanted, name not in wanted)
        if name in wanted:
            same_kinds(ours, other)


@pytest.mark.parametrize("stage", ["setup", "Orbit", "run_all", "loads_of"])
@pytest.mark.parametrize("start", [None, Start(0.12, 0.0, place="row 2")])
def test_a_speed_that_breaks_at_any_stage_costs_itself_alone(monkeypatch, stage, start):
    """Alone, among others in one call of the kernel, and where the one before has ended."""
    broken = 650.0
    omega = omega_of(broken)

    def breaking(real, breaks):
        def call(*given, **more):
            if breaks(*given):
                raise ZeroDivisionError
            return real(*given, **more)

        return call

    setup = breaking(lambda rpm: (chapter_system(), rpm, SETTINGS), lambda rpm: (
        stage == "setup" and rpm == broken
    ))  # fmt: skip
    if stage != "setup":
        breaks = {
            "Orbit": lambda system, rpm, *_: rpm == broken,
            "run_all": lambda orbits: any(orbit.omega == omega for orbit in orbits),
            "loads_of": lambda system, rpm, record: rpm == broken,
        }[stage]
        real = getattr(motion_at_speed, stage)
        monkeypatch.setattr(motion_at_speed, stage, breaking(real, breaks))
    task = SpeedTask("rpm", setup, True, True, False, turns=21.0, turns_each=7.0, start=start,
                     keeps_ends=True)  # fmt: skip
    alone = task(broken)
    name = "rpm = 650.0" if start is None else f"rpm = 650.0 from {start.place}"
    assert (alone.fault.piece, alone.fault.error) == (name, "ZeroDivisionError")
    assert (alone.status, alone.label, alone.impact_count) == (Status.FAULT, UNDECIDED, None)
    assert alone.end is None
    assert alone.value == broken
    assert alone.rpm == broken if stage != "setup" else np.isnan(alone.rpm)
    assert [len(rows) for rows in (*alone.impacts, *alone.strobe)] == [0] * 9
    sizes = []
    for values in ([broken], [700.0, broken, 710.0], [broken, 700.0]):
        found = task.many(values)
        assert [speed.value for speed in found] == values
        for value, speed in zip(values, found, strict=True):
            if value == broken:
                assert (speed.fault.piece, speed.status) == (name, Status.FAULT)
                continue
            single = task(value)
            assert (speed.fault, speed.label, speed.status) == (None, single.label, Status.OK)
            assert speed.impacts[1].tolist() == single.impacts[1].tolist()
            sizes.append(len(speed.impacts[1]))
    assert min(sizes) > 0
    after_none = task.after(None, 700.0)
    assert after_none.strobe[1].tolist() == task(700.0).strobe[1].tolist()
    ahead = task.after(after_none, broken)  # from the end of that: no start of the task's own
    assert ahead.fault.piece == "rpm = 650.0"
    again = task.after(ahead, 700.0)
    assert again.fault is None
    scene_start = task.started_at(700.0, None)
    assert again.strobe[1].tolist() == scene_start.strobe[1].tolist()


def test_a_motion_that_broke():
    broken = classify._failed(0.8, 700.0, Start(), FAULT)
    assert (broken.fault, broken.label, broken.status) == (FAULT, UNDECIDED, Status.FAULT)
    assert (broken.record.status, broken.record.cost) == (Status.FAULT, Cost())
    assert (broken.record.periods, broken.record.detachments) == (0, 0)
    assert not broken.record.resting
    whole = Orbit(chapter_system(), 700.0, SETTINGS, Start()).run()
    same_kinds(broken.record[:9], whole[:9])


@pytest.mark.parametrize("start", [None, Start(q=0.25, v=-1.0)])
def test_several_speeds_begin_where_each_of_them_would(start):
    """From the start of the scene, and from another one; 700 rpm is far from settled by then."""
    system = chapter_system()
    task = SpeedTask("rpm", lambda rpm: (system, rpm, SETTINGS), impacts=True, strobe=True,
                     lyapunov=False, turns=14.0, turns_each=7.0, start=start)  # fmt: skip
    speeds = (650.0, 700.0, 745.0)
    for found, alone in zip(task.many(speeds), map(task, speeds), strict=True):
        orbit = Orbit(system, alone.rpm, SETTINGS, start)
        last = orbit.run()
        assert found.strobe[1].tolist() == alone.strobe[1].tolist()
        assert found.strobe[1][0] == last.strobe_q[0]
        assert (found.label, found.impact_count) == (alone.label, alone.impact_count)


def test_a_report_adds_its_faults_to_those_of_the_study(monkeypatch):
    """One piece of the study fails, one of the motions of the report, and all others are there."""
    module = import_module("camcli.api.detach")

    def broken(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(module, "_undercut", broken)
    motions = partial(piece, "a motion of the report", broken, ())
    monkeypatch.setattr(module, "past_motions", lambda *_: motions())
    few = {"detach.rpm": {"start": 100.0, "stop": 101.0, "num": 2}, "detach.impacts": 0,
           "detach.settle": 0}  # fmt: skip
    result = camcli.detach(camcli.load_scene(None, few), report=True)
    assert [fault.piece for fault in result.faults] == [
        "whether the lobe is undercut", "a motion of the report",
    ]  # fmt: skip
    assert "report.pdf" in result.files
