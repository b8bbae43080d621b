"""Rows 1 to 3, 8, 9, 24 and 25 of the extreme cases: restitution, no spring, no force."""

from math import pi

import pytest

from camcli.analysis.engine import Orbit
from camcli.analysis.labels import label
from camcli.errors import IMPACT_BUDGET, NO_RETURN, OK
from tests.kernel.helpers import events, run, settings, system


def kinds(tape):
    return [row[0] for row in events(tape)]


def test_row_1_without_restitution_one_impact_then_sticking():
    tape = run(190.0, system(restitution=0.0), record=4)
    assert kinds(tape)[:3] == ["detachment", "impact", "detachment"]
    assert list(tape.impacts) == [2, 2, 2, 2]
    assert not any(tape.chatter)
    assert label(tape) == "P(1;2)"


def test_row_1_without_restitution_and_pushed_off_by_the_cam():
    """Landing where the relative acceleration is positive: an impact, and it leaves at once."""
    tape = run(700.0, system(restitution=0.0), record=20)
    assert tape.status == OK
    for before, after in zip(events(tape), events(tape)[1:], strict=False):
        assert (before[1], before[2]) <= (after[1], after[2])


def test_row_2_full_restitution_bounces_at_the_same_speed():
    tape = run(130.0, system(restitution=1.0), record=1)
    first, second = [row for row in events(tape) if row[0] == "impact"][:2]
    assert first[4] == pytest.approx(second[4], rel=1e-13)  # both on the top dwell
    assert tape.status == OK
    assert "chatter" not in kinds(tape)


def test_row_2_full_restitution_keeps_the_energy_on_a_dwell():
    """A ball on a dwell with k = 0: the speed stays for hundreds of bounces."""
    machine = system(restitution=1.0, stiffness=0.0, gravity=9.81)
    rows = events(run(0.05, machine, record=1, q=0.11, v=0.0))
    speeds = [row[4] for row in rows if row[0] == "impact" and row[2] < 1.5]
    assert len(speeds) > 1000
    assert max(speeds) - min(speeds) < 1e-11 * -speeds[0]


def test_row_3_nearly_full_restitution_ends_by_the_budget():
    machine = system(restitution=0.999999, gravity=9.81)
    tape = run(2.0, machine, record=2, budget=5000, q=0.1001, v=0.0)
    assert tape.status == IMPACT_BUDGET
    assert tape.cost.impacts == 5000


def test_row_8_a_ball_comes_to_rest_at_its_zeno_time():
    rpm = 1.0
    machine = system(stiffness=0.0, gravity=9.81)
    height = Orbit(machine, rpm, settings()).position()[0] + 1.0
    rows = events(run(rpm, machine, record=1, q=height, v=0.0))
    chatter = next(row for row in rows if row[0] == "chatter")
    assert chatter[2] / (rpm * pi / 30) == pytest.approx(4.06371277, abs=5e-9)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-15, 1e-18])
def test_row_8_the_zeno_time_needs_no_tolerance(tolerance):
    rpm, g, h, r = 1.0, 9.81, 1.0, 0.8
    machine = system(stiffness=0.0, gravity=g)
    height = Orbit(machine, rpm, settings()).position()[0] + h
    rows = events(run(rpm, machine, record=1, tolerance=tolerance, q=height, v=0.0))
    exact = (2 * h / g) ** 0.5 * (1 + r) / (1 - r)
    last = max(row[2] for row in rows if row[0] == "chatter")
    assert last / (rpm * pi / 30) == pytest.approx(exact, rel=1e-13)
    assert [row[0] for row in rows].count("impact") == 1


@pytest.mark.parametrize("damping", [0.0, 5.0])
def test_row_9_a_follower_that_flew_off_does_not_return(damping):
    machine = system(stiffness=0.0, damping=damping)
    tape = run(500.0, machine, record=50, q=0.5, v=30.0)
    assert tape.status == NO_RETURN
    assert kinds(tape) == []


@pytest.mark.parametrize("damping", [0.0, 1.0])
@pytest.mark.parametrize("rpm", [1.0, 500.0])
def test_rows_9_and_24_no_force_holds_the_follower(rpm, damping):
    """k = g = preload = 0 from rest on the dwell: the lobe throws it off, once and for good."""
    tape = run(rpm, system(stiffness=0.0, damping=damping), record=50)
    assert len(kinds(tape)) < 100
    assert tape.status in ((NO_RETURN,) if damping == 0.0 else (OK, NO_RETURN))


@pytest.mark.parametrize("r", [1e-200, 1e-300, 1e-320, 5e-324])
def test_row_25_restitution_below_resolution(r):
    """Products of such speeds underflow; their signs do not."""
    tape, plastic = (run(190.0, system(restitution=x), record=3) for x in (r, 0.0))
    assert tape.status == OK
    assert list(tape.impacts) == list(plastic.impacts)
    assert [row[2] for row in events(tape) if row[0] == "impact"] == [
        row[2] for row in events(plastic) if row[0] == "impact"
    ]


def test_row_25_hops_below_any_product():
    """Without a tolerance hops shrink until even the map's error underflows."""
    tape = run(130.0, system(), record=1, tolerance=0.0)
    slow = [row for row in events(tape) if row[0] == "impact" and -row[4] < 1e-100]
    assert slow
    assert all(row[4] < 0 for row in slow)
    assert tape.status == OK
