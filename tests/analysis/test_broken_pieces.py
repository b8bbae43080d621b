"""A speed or a motion that broke has the columns of a whole one, of the same kinds, but no rows."""

from __future__ import annotations

import numpy as np
import pytest

from camcli.analysis import classify
from camcli.analysis.integrate import Cost, Orbit, Settings, Start
from camcli.analysis.labels import UNDECIDED
from camcli.analysis.motion_at_speed import SpeedTask
from camcli.errors import Status
from camcli.piece_faults import PieceFault
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
