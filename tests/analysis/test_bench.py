"""The bench: our own bounds, the peers' care, the comparison, and the rows."""

from dataclasses import replace
from math import pi

import pytest

import camcli
from camcli.analysis.bench import stability
from camcli.analysis.bench.peers import (
    Lift,
    PeerImpact,
    PeerMachine,
    PeerTrace,
    heyoka_taylor,
    runge_kutta_4,
    solve_ivp,
)
from camcli.analysis.bench.precision import (
    CORE,
    FAILED,
    MISSED,
    OK,
    CaseVerdict,
    Measured,
    MethodSetting,
    Point,
    case,
    compare,
    run_core,
    run_peer,
    verdicts,
)
from camcli.api.bench import machines
from camcli.scene.schema import CASES
from camcli.system import Follower


def ours(name, tolerance=1e-13):
    some = case(name)
    return some, run_core(machines().system(some.follower, some.cam), some, tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8, 1e-13])
@pytest.mark.parametrize("name", CASES)
def test_our_errors_stay_within_their_bounds(name, tolerance):
    found = compare(*ours(name, tolerance), tolerance)
    assert found.missed == found.extra == 0
    assert found.excess <= 1.0, found


# Errors of heyoka's Taylor integrator at 1e-13, in turns: the most exact of all peers.
HEYOKA = {
    "periodic": 6.3e-14, "chatter": 3.8e-15, "incomplete": 5.3e-13, "p3": 3.6e-15,
    "chaotic": 2.5e-11, "critical": 1.7e-16, "overdamped": 1.6e-16, "stiff": 3.3e-15,
    "eccentric": 6.1e-13,
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_no_peer_is_more_exact(name):
    assert compare(*ours(name, 1e-15), 1e-15).error <= HEYOKA[name]


@pytest.mark.parametrize("name", ["periodic", "p3", "eccentric", "critical"])
def test_a_careful_peer_agrees_with_the_reference(name):
    some = case(name)
    found = compare(some, run_peer(solve_ivp("dop853", 1e-11, 1.0 / 16.0), some, 1e-9, 60.0))
    assert found.missed == found.extra == 0
    assert found.error < 1e-8


def test_fixed_steps_converge_at_least_with_the_fourth_power():
    some = case("periodic")
    errors = [compare(some, run_peer(runge_kutta_4(n), some, 1e-9)).error for n in (100, 800)]
    assert errors[0] / errors[1] > 8.0**4


@pytest.mark.parametrize("name", ["chatter", "eccentric", "overdamped"])
def test_the_taylor_integrator_is_exact(name):
    pytest.importorskip("heyoka")
    some = case(name)
    assert compare(some, run_peer(heyoka_taylor(1e-13), some, 1e-9)).error < 1e-11


@pytest.mark.parametrize(("omega", "leaves"), [(10.0, 2 * pi / 3), (7.0, None)])
def test_where_a_peer_leaves_a_rest(omega, leaves):
    """Without a spring on c = lift (1 - cos theta)/2 where omega^2 lift/2 cos theta < -g."""
    lift = Lift({"kind": "eccentric", "base": 0.0, "lift": 0.2})
    follower = Follower(mass=2.0, stiffness=0.0, damping=0.0, gravity=5.0, preload=0.0,
                        restitution=0.5)  # fmt: skip
    machine = PeerMachine(follower, lift, omega=omega, turns=2.5, chatter=1e-9)
    if leaves is None:  # 49 * 0.1 < 5
        assert machine.rest(0, 0.3) is None
        return
    assert machine.rest(0, 0.3) == pytest.approx((0, leaves, 0.0, 0.0), rel=1e-12)
    assert machine.rest(0, 2.5) == (0, 2.5, 0.0, 0.0)  # it does not rest there at all
    assert machine.rest(0, 4.5) == pytest.approx((1, leaves, 0.0, 0.0), rel=1e-12)
    assert machine.rest(2, 4.5) is None  # two turns and a half have ended by then


def test_a_run_ends_with_its_budget():
    some = case("chatter")
    assert run_peer(runge_kutta_4(100), some, 1e-9, 0.0).given_up
    trace = run_peer(solve_ivp("rk45", 1e-3), replace(some, hits=[], turns=40), 1e-9)
    assert trace.given_up
    assert len(trace.hits) == 201


def test_missed_and_invented_impacts_are_counted():
    some, trace = ours("periodic")
    less = replace(trace, hits=trace.hits[:7] + trace.hits[9:])
    more = replace(trace, hits=sorted([*trace.hits, PeerImpact(3, 0.1, -1.0)]))
    late = replace(trace, hits=[PeerImpact(p, x + 2e-6 * pi, u) for p, x, u in trace.hits])
    assert compare(some, less).missed == 2
    assert compare(some, more).extra == 1
    assert compare(some, PeerTrace()).missed == len(some.hits)
    assert compare(some, late).error == pytest.approx(1e-6, rel=1e-6)
    assert compare(some, late).excess > 1.0


def test_impacts_that_a_chatter_map_replaces_are_not_missed():
    some, trace = ours("chatter", 1e-3)
    assert len(trace.hits) < len(some.hits)
    assert compare(some, trace, 1e-3).missed == 0
    lost = replace(trace, hits=trace.hits[:3] + trace.hits[4:])
    assert compare(some, lost, 1e-3).missed == 1


def test_a_height_beyond_the_rounding_of_its_steps_fails_the_row(monkeypatch):
    monkeypatch.setattr(stability, "HALF_ULP", stability.HALF_ULP / 50.0)
    assert stability.measure(stability.ROWS[7], machines()).status != OK


def row(method, setting, **values):
    """A row of the case one; what is not given is not known."""
    return Point("one", MethodSetting(method, setting, 0.0, None)).row(**values)


def test_a_row_that_was_not_measured_knows_nothing():
    empty = row(CORE, "1e-9")
    for value in (empty.seconds, empty.error, empty.bound, empty.of_bound):
        assert value != value  # not a number
    assert (empty.impacts, empty.evaluations, empty.missed, empty.extra) == (0, 0, 0, 0)
    assert empty.status not in (OK, FAILED)


def test_the_verdict_of_a_case_compares_what_came_out_right():
    """Our tightest setting, the fastest peer that is exact enough, and the most exact one."""
    ours = [
        row(CORE, "loose", seconds=0.5, error=1e-7, of_bound=0.2, status=OK),
        row(CORE, "tight", seconds=0.25, error=2e-13, of_bound=0.4, status=OK),
        row(CORE, "broken", status=FAILED),
    ]
    peers = [
        row("RK45", "fast", seconds=0.1, error=2e-9, status=OK),  # not exact enough
        row("RK45", "exact", seconds=1.0, error=1e-9, status=OK),
        row("DOP853", "most exact", seconds=3.0, error=1e-11, status=OK),
        row("DOP853", "misses", seconds=0.01, error=1e-12, status=MISSED),
        row("Radau", "failed", status=FAILED),
        row("heyoka", "absent"),
    ]
    alone = CaseVerdict("one", 0.25, 2e-13, 0.4)
    best = replace(alone, most_exact_other="DOP853 most exact", its_error_turns=1e-11)
    found = replace(best, fastest_other="RK45 exact", ratio=4.0)
    other = Measured("two", "RK45", "fast", 1.0, 1e-10, status=OK)
    assert verdicts([*ours, *peers, other]) == [found]
    assert verdicts(ours + peers[3:]) == [alone]
    assert verdicts([*ours, peers[0]]) == [
        replace(alone, most_exact_other="RK45 fast", its_error_turns=2e-9)
    ]
    assert verdicts([ours[-1], *peers]) == []


@pytest.mark.ci
def test_a_row_that_compares_phases_says_how_many():
    """In other units of mass, four times those of sixty turns from rest."""
    values = {"follower.damping": 3.0, "follower.preload": 5.0, "run.rpm": 700.0,
              "run.transient": 0, "run.record": 60}  # fmt: skip
    events = camcli.simulate(camcli.load_scene(None, values)).tables["events"].rows
    assert stability._heavier(machines()) == f"{4 * events} phases identical"
