"""Rows 5 to 7 and 17 to 20: critical and heavy damping in whole orbits, and hostile starts."""

from math import nextafter, pi, sqrt

import pytest

from camcli.analysis.engine import Orbit, StartError
from camcli.analysis.simulate import simulate
from camcli.analysis.sweep import sweep
from camcli.errors import OK
from tests.kernel.helpers import ORACLE_CAM, events, run, settings, system

CRITICAL = 2 * sqrt(1430.8 * 1.221)


@pytest.mark.parametrize("rpm", [190.0, 300.0, 700.0])
def test_row_5_critical_damping_is_continuous(rpm):
    """One ulp and 1e-12 beside critical: the same digits on both sides."""
    beside = [CRITICAL, nextafter(CRITICAL, 99), nextafter(CRITICAL, 0)]
    beside += [CRITICAL * (1 + 1e-12), CRITICAL * (1 - 1e-12)]
    tapes = [run(rpm, system(damping=b), record=3) for b in beside]
    for tape in tapes[1:]:
        assert list(tape.kind) == list(tapes[0].kind)
        for a, b in zip(tape.theta[:10], tapes[0].theta[:10], strict=True):
            assert a == pytest.approx(b, abs=1e-9)


@pytest.mark.parametrize("rpm", [115.0, 700.0])
@pytest.mark.parametrize("b", [6.7e3, 4.1e4, 1e6, 1e9, 1e12])
def test_rows_6_and_7_heavy_damping(b, rpm):
    """The follower hangs above the cam and creeps; nothing overflows, the cost is bounded."""
    tape = run(rpm, system(damping=b), record=3)
    assert tape.status == OK
    assert all(0.0999 < q < 0.26 for q in tape.strobe_q)
    assert all(abs(u) < 1.0 for u in tape.u)
    assert tape.cost.evaluations < 20_000 * max(1, tape.cost.impacts)


@pytest.mark.parametrize("b", [6.7e3, 4.1e4, 1e6, 1e9, 1e12])
def test_row_7_creep_from_the_top(b):
    """Without inertia: q decays as exp(-k t/b) from the end of the top dwell."""
    rpm, k = 115.0, 146 * 9.8
    tape = run(rpm, system(damping=b), record=1)
    leave = next(row for row in events(tape) if row[0] == "detachment" and row[2] > 3.4)
    end = tape.strobe_q[-1] if len(tape.strobe_q) > 1 else None
    orbit = Orbit(system(damping=b), rpm, settings(1))
    orbit.run(events=False)
    end = orbit.position()[0]
    t = (2 * pi - leave[2]) / (rpm * pi / 30)
    slow = 2 * (k / 1.221) / (b / 1.221 + sqrt((b / 1.221) ** 2 - 4 * k / 1.221))
    assert end == pytest.approx(leave[3] * 2.718281828459045 ** (-slow * t), rel=2e-3)


@pytest.mark.parametrize("degrees", [0.0, 100.0, 150.17, 170.0, 250.0])
def test_row_18_a_start_on_the_cam_where_it_is_pressed_sticks(degrees):
    tape = run(100.0, record=1, theta_deg=degrees)
    assert not events(tape)
    assert tape.resting


@pytest.mark.parametrize("degrees", [151.0, 155.0, 159.0])
def test_row_18_a_start_on_the_cam_where_it_is_pulled_leaves(degrees):
    tape = run(190.0, record=1, theta_deg=degrees)
    kind, _, theta, _, u = events(tape, 1)[0]
    assert kind == "impact"
    assert theta > degrees * pi / 180 + 0.01
    assert u < 0


def test_row_18_the_next_derivative_decides_where_the_force_is_zero():
    """At the detachment phase of 125 rpm with damping, started there: as if it had stuck before."""
    machine = system(damping=40.0)
    rows = events(run(160.0, machine, record=1))
    leave = next(row[2] for row in rows if row[0] == "detachment")
    again = events(run(160.0, machine, record=1, theta_deg=leave * 180 / pi), 1)
    first = next(row[2] for row in rows if row[0] == "impact")
    assert next(row[2] for row in again if row[0] == "impact") == pytest.approx(first, abs=1e-7)


@pytest.mark.parametrize("degrees", [0.0, 100.0, 155.0, 300.0])
def test_row_19_a_start_into_the_cam_is_one_impact(degrees):
    rows = events(run(190.0, record=1, theta_deg=degrees, v=-20.0), 0 if degrees == 0 else 1)
    assert rows[0][0] == "impact"
    assert rows[0][2] == degrees * (pi / 180)
    assert rows[1][1:3] > rows[0][1:3]


def test_row_20_a_start_below_the_cam_is_refused_with_its_depth():
    for call in (
        lambda s: Orbit(system(), 190.0, s),
        lambda s: simulate(system(), 190.0, s, 10),
        lambda s: sweep(system(), [190.0], s),
    ):
        with pytest.raises(StartError, match=r"0\.05 m below"):
            call(settings(1, q=0.05, v=0.0))


def test_row_20_one_ulp_below_is_below():
    c = Orbit(system(), 190.0, settings(1)).position()[0]
    with pytest.raises(StartError):
        Orbit(system(), 190.0, settings(1, q=nextafter(c, 0), v=0.0))
    assert Orbit(system(), 190.0, settings(1, q=nextafter(c, 1), v=0.0)).run().status == OK


def test_row_17_the_start_on_the_nose_is_the_oracles_lift():
    """Starts given in m hit the cam they mean: c of the package within an ulp or two."""
    for degrees in (100.0, 155.0, 205.0, 250.0):
        q = Orbit(system(), 190.0, settings(1, theta_deg=degrees)).position()[0]
        assert q == pytest.approx(float(ORACLE_CAM.c(degrees * (pi / 180))), rel=4e-16)
