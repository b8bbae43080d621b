"""Branches of the kernel that runs seldom take, each led to on purpose and in plain Python.

What is expected does not come from the branch: a cut run from an uncut one, a refusal from what
no machine or no orbit can be, a bound from the definition.
"""

import random
from dataclasses import replace
from math import cos, hypot, pi, sin, sqrt

import pytest

from camcli.analysis import integrate as engine
from camcli.analysis.orbits.shooter import Shooter
from camcli.kernel import backend
from camcli.kernel.arithmetic import sincos, sine_versine
from camcli.kernel.cam_table import lift, stretch_at
from camcli.kernel.certify import DOUBTFUL, LATE
from camcli.kernel.forms import PLAIN
from camcli.kernel.returns import find_return
from tests.conftest import chapter_system, settings
from tests.kernel.test_cells import STARTS, batches, ends
from tests.support.kernel_runs import CHAPTER, system


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """All of it in plain Python, where coverage sees it."""
    monkeypatch.setattr(backend, "for_work", lambda *_: PLAIN)
    monkeypatch.setattr(backend, "may_compile", lambda: False)


@pytest.mark.parametrize("size", [1e7, 1e9, 3e15, 1e18, 1e200])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_phases_that_mean_nothing_are_bounded(size, sign):
    """Beyond 1.6e6 rad the sine of a double means little, far beyond nothing: it stays a sine."""
    for k in range(40):
        x = sign * size * (1.0 + 0.01 * k)
        assert hypot(*sincos(x)) == pytest.approx(1.0, abs=1e-14)
        sine, sine_rest, versine, versine_rest = sine_versine(abs(x), 0.0)
        assert abs(sine + sine_rest) <= 1.0 + 1e-6
        assert -1e-6 <= versine + versine_rest <= 2.0 + 1e-6


@pytest.mark.parametrize("rpm", [190.0, 358.5])
@pytest.mark.parametrize("steps", [1, 7])
def test_an_orbit_in_short_calls_is_the_same(rpm, steps):
    """A call that is cut after so many steps goes on from there."""
    whole = engine.Orbit(system(), rpm, settings(record=4)).run()
    portions = engine.Portions(compiled_steps=steps)
    cut = engine.Orbit(system(), rpm, settings(record=4)).run(portions=portions)
    for name in ("kind", "period", "theta", "q", "u", "strobe_q", "strobe_w", "impacts"):
        assert getattr(cut, name).tolist() == getattr(whole, name).tolist(), name
    assert len(whole.theta) > 4


@pytest.mark.parametrize("steps", [7, 13])
def test_cells_in_short_calls_are_the_same(steps):
    """A cell that is at work when a call is cut is not begun again."""
    whole = ends(batches(), 5)
    cut = ends(replace(batches(), steps=steps), 5)
    for name in ("gap", "rate", "outcome", "turns", "symbol"):
        assert getattr(cut, name).tolist() == getattr(whole, name).tolist(), name
    assert cut.turns.tolist() == [5] * len(STARTS)


def one_impact(machine=None, parameter="rpm"):
    """The shooter at 700 rpm and its root P(1;1)."""
    machine = machine or chapter_system()
    shooter = Shooter(machine, 700.0, parameter)
    value = 700.0 if parameter == "rpm" else getattr(machine.follower, parameter)
    whole = (stretch_at(machine.cam, 2.71), 0)
    root = shooter.at_value([2.7105, 0.85, value], whole, 1, value)
    assert root is not None
    return shooter, root


def test_an_impact_far_beyond_its_stretch_is_no_root():
    """The pieces of a cam reach a little beyond their ends; a guess farther out is refused."""
    shooter, root = one_impact()
    far = [root.x[0] + 2.0, *root.x[1:]]
    assert shooter.at_value(far, root.whole, 1, 700.0) is None


@pytest.mark.parametrize(
    ("parameter", "value"),
    [("rpm", 0.0), ("rpm", -700.0), ("mass", -1.0), ("stiffness", -1.0), ("damping", -1.0)],
)
def test_constants_that_no_machine_has_are_no_root(parameter, value):
    shooter, root = one_impact(parameter=parameter)
    assert shooter.at_value(root.x, root.whole, 1, value) is None


def test_the_first_damping_is_none_at_all():
    """The derivative by the damping is one-sided at 0, and that of the branch beside it."""
    shooter, root = one_impact(chapter_system(damping=0.0), "damping")
    step = 1e-4
    beside = shooter.at_value(root.x, root.whole, 1, step)
    for j in range(2):
        slope = (beside.x[j] - root.x[j]) / step
        assert root.tangent[j] / root.tangent[-1] == pytest.approx(slope, rel=1e-3)


def random_guesses(cam, count):
    """Guesses of one to three impacts in a turn or two, of which hardly one leads to an orbit."""
    draw = random.Random(1)
    for _ in range(count):
        phases = sorted(draw.uniform(0.0, 6.28) for _ in range(draw.choice([1, 2, 3])))
        x = [number for phase in phases for number in (phase, 10.0 ** draw.uniform(-3.0, 0.5))]
        whole = [place for phase in phases for place in (stretch_at(cam, phase), 0)]
        yield x, whole, draw.choice([1, 2]), draw.uniform(100.0, 900.0)


def test_what_comes_of_bad_guesses_solves_the_equations():
    """Steps that leave the cam's pieces or meet a singular system are given up; what is left are
    impacts on the cam, with Newton's law, as the flow in closed form has them."""
    machine, solved = chapter_system(), 0
    for x, whole, turns, rpm in random_guesses(machine.cam, 1500):
        shooter = Shooter(machine, rpm)
        root = shooter.at_value([*x, rpm], whole, turns, rpm)
        if root is None:
            continue
        solved += 1
        omega = rpm * pi / 30.0
        wave = sqrt(CHAPTER["stiffness"] / CHAPTER["mass"]) / omega
        for k in range(root.count):
            after = (k + 1) % root.count
            c, slope, _ = lift(machine.cam, root.stretch(k), root.theta[k])
            there, there_slope, _ = lift(machine.cam, root.stretch(after), root.theta[after])
            s, w = root.flight_length(k), slope + root.x[2 * k + 1]
            q = c * cos(wave * s) + w / wave * sin(wave * s)
            rate = -c * wave * sin(wave * s) + w * cos(wave * s) - there_slope
            assert q == pytest.approx(there, abs=1e-11)
            assert root.x[2 * after + 1] == pytest.approx(-0.8 * rate, abs=1e-10)
    assert solved > 30


def test_a_flight_that_goes_on_for_turns_is_late():
    """An impact rate a hundred times that of the orbit: the follower is in the air for turns."""
    shooter, root = one_impact()
    x = [root.x[0], 100.0 * root.x[1], root.x[2]]
    code, impact, _ = shooter.verdict(replace(root, x=x))
    assert (code, impact) == (LATE, 0)


def test_a_state_that_is_no_number_is_in_doubt():
    """No flight can be certified from it, and none is said to be a motion."""
    shooter, root = one_impact()
    x = [root.x[0], float("nan"), root.x[2]]
    assert shooter.verdict(replace(root, x=x))[0] == DOUBTFUL


def test_a_motion_at_zero_repeats_after_a_turn():
    """Distances are relative to the sizes of a record, and one without a size repeats as it is."""
    assert find_return(PLAIN.strobe(40), 40) == (1, 0)
