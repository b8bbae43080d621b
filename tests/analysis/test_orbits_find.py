"""Which orbits are found at one speed, and when a record is one of them."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import solve_from

from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label
from camcli.analysis.orbits.identify import identify, largest_growth
from camcli.analysis.orbits.same_orbit import same_orbit, same_states, shortest_period
from camcli.analysis.orbits.search import find
from camcli.cams.eccentric import EccentricCam
from camcli.kernel.orbit_loop import DETACHMENT, IMPACT
from camcli.system import Follower, System, omega_of
from tests.conftest import chapter_system, settings


@cache
def found(rpm, name=None, strobe=0.0):
    wanted = None if name is None else Label.parse(name)
    return find(chapter_system(strobe), rpm, settings(transient=300), 2, wanted)


def labels(result):
    return [orbit.label for orbit in result.orbits]


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [
        (358.5, "P(3;3:3:2)"),
        (360.0, "P(6;3:3:2:3:3:2)"),
        (739.35, "P(2;1:1)"),
        (190.0, "P(1;inf)"),
        (100.0, "contact"),
    ],
)
def test_what_the_machine_settles_on(rpm, expected):
    orbit = solve_from(chapter_system(), rpm, settings(transient=300))
    assert orbit.label == expected
    assert orbit.stable
    assert orbit.admissible
    assert orbit.primitive
    assert not orbit.resting or orbit.multipliers == (0, 0)
    assert same_orbit(found(rpm).orbits[0], orbit)


def test_chaos_is_no_orbit_and_what_is_left_is_unstable():
    assert solve_from(chapter_system(), 745.0, settings(transient=300)) is None
    assert labels(found(745.0)) == ["P(1;1)", "P(1;1)"]
    assert not any(orbit.stable for orbit in found(745.0).orbits)


@pytest.mark.parametrize(
    ("rpm", "name"), [(358.5, "P(1;2)"), (745.0, "P(2;1:1)"), (745.0, "P(3;1:1:1)")]
)
def test_an_orbit_is_found_by_its_label(rpm, name):
    """At 745 rpm they are unstable, and not P(1;1) gone through twice or thrice."""
    result = found(rpm, name)
    assert set(labels(result)) == {name}
    for orbit in result.orbits:
        assert orbit.admissible
        assert orbit.primitive
        assert orbit.stable == (rpm == 358.5)
        assert orbit.impacts == sum(Label.parse(name).symbols)
        assert len({round(q, 6) for q, _ in orbit.states}) == orbit.turns


@pytest.mark.parametrize("rpm", [358.5, 739.35, 190.0])
def test_another_strobe_phase_rotates_the_label_only(rpm):
    """The same impacts; a turn that begins elsewhere holds other ones of them."""
    one, two = found(rpm).orbits[0], found(rpm, strobe=155.0).orbits[0]
    assert (two.turns, sum(two.symbols)) == (one.turns, sum(one.symbols))
    assert two.trace == pytest.approx(one.trace, rel=1e-10, abs=1e-10)
    assert sorted(two.theta) == pytest.approx(sorted(one.theta), abs=1e-12)


def test_states_that_differ_by_more_than_rounding_are_two():
    states = [(0.2, 1.0), (0.3, -1.0)]
    assert same_states(states, [(q * (1 + 1e-9), w) for q, w in states])
    assert not same_states(states, [(q * (1 + 1e-6), w) for q, w in states])
    assert shortest_period(states[:1] * 4) == 1
    assert shortest_period(states * 2) == 2
    assert shortest_period([*states, states[0], (0.3 + 1e-6, -1.0)]) == 4


def test_a_record_that_does_not_come_near_the_orbit_is_not_on_it():
    """Its passages close, and Newton's method finds an orbit, but another one."""
    system = chapter_system()
    tape = Orbit(system, 700.0, settings(transient=300, record=10)).run()
    assert identify(system, 700.0, tape) is not None
    elsewhere = tape._replace(strobe_q=tape.strobe_q + 1e-3)
    assert identify(system, 700.0, elsewhere) is None


def test_a_cycle_through_a_rest_closes_to_rounding_or_is_none():
    system = chapter_system()
    tape = Orbit(system, 190.0, settings(transient=20, record=10)).run()
    assert identify(system, 190.0, tape).label == "P(1;inf)"
    ends = tape.strobe_w + 1e-9 * (-1) ** np.arange(10)
    assert identify(system, 190.0, tape._replace(strobe_w=ends), longest=1) is None


def test_a_phase_error_grows_from_hop_to_hop_as_by_hand():
    """On a dwell without a spring, gap'' = -G: everything about an error is elementary.

    Half a hop after lift-off a phase error d is a difference (u, u/s) d of gap and rate. It lands
    -dq/u later, and leaves with -r dq, -r dw - (1 + r) G dq/u.
    """
    follower = Follower(mass=2.0, stiffness=0.0, gravity=9.81, preload=5.0, restitution=0.6)
    cam = EccentricCam(kind="eccentric", base=0.1, lift=1e-300)
    system, rpm = System.build(follower, cam), 300.0
    theta, u = np.array([1.0, 1.05, 1.17, 1.40, 1.5]), np.array([0.0, -0.03, -0.02, -0.05, -0.01])
    kind = np.array([DETACHMENT, *[IMPACT] * 4])
    record = SimpleNamespace(kind=kind, period=np.zeros(5, int), theta=theta, u=u)
    pull = (9.81 + 5.0 / 2.0) / omega_of(rpm) ** 2
    (dq, dw), grown = (-u[1], -u[1] / (theta[1] - theta[0])), [1.0]
    for k in (2, 3, 4):
        dq, dw = -0.6 * dq, -0.6 * dw - 1.6 * pull * dq / u[k - 1]
        dq += (theta[k] - theta[k - 1]) * dw
        grown.append(abs(dq / u[k]))
    for count in (2, 3, 4, 5):
        cut = SimpleNamespace(**{name: values[:count] for name, values in vars(record).items()})
        found = largest_growth(system, rpm, cut, range(1))
        assert found == pytest.approx(max(grown[: count - 1]), rel=1e-9)
    assert max(grown) > 4.0


@pytest.mark.parametrize(
    ("rpm", "turns", "label"), [(358.5, 3, "P(3;3:3:2)"), (739.35, 2, "P(2;1:1)")]
)
def test_an_orbit_of_the_longest_period_that_is_looked_for_is_found(rpm, turns, label):
    run = settings(transient=300)
    assert solve_from(chapter_system(), rpm, run, longest=turns).label == label
    assert solve_from(chapter_system(), rpm, run, longest=turns - 1) is None
