"""What follows a rest: the phase at which the follower leaves, in closed form, and what is learned.

On c = base + lift (1 - cos theta)/2 the force k c + m g + F0 + b omega c' + m omega^2 c'' is a sum
of a constant, a sine and a cosine: its zero is an arc cosine.
"""

from __future__ import annotations

from math import acos, atan2, cos, hypot, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.after_rest import CYCLE, SETTLED, UNKNOWN, WANDERS, After
from camcli.analysis.basins import rest_outcomes
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches
from camcli.analysis.basins.rest_outcomes import RestOutcomes, departure, record_of
from camcli.cams.eccentric import EccentricCam
from camcli.kernel.cells import FORGOTTEN, GOES_ON, NEW_REST, UNDECIDED, Rest
from camcli.kernel.flight import FREE
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, RESTING
from camcli.system import Follower, System
from tests.conftest import settings

FOLLOWER = Follower(
    mass=2.0, stiffness=800.0, damping=3.0, gravity=9.81, preload=5.0, restitution=0.3
)
BASE, LIFT, STROBE, RPM = 0.02, 0.01, 0.5, 700.0
OMEGA = RPM * pi / 30.0


@pytest.fixture(scope="module")
def batches() -> CellBatches:
    cam = EccentricCam(kind="eccentric", base=BASE, lift=LIFT)
    return CellBatches(System.build(FOLLOWER, cam, STROBE), RPM, settings())


def leaves() -> float:
    """The phase (rad) at which the force falls to zero."""
    f, half = FOLLOWER, 0.5 * LIFT
    constant = f.stiffness * (BASE + half) + f.mass * f.gravity + f.preload
    of_cosine = half * (f.mass * OMEGA**2 - f.stiffness)
    of_sine = half * f.damping * OMEGA
    # constant + R cos(theta - phi) = 0, falling
    size, phi = hypot(of_cosine, of_sine), atan2(of_sine, of_cosine)
    return (phi + acos(-constant / size)) % (2.0 * pi)


def force(theta: float) -> float:
    f, half = FOLLOWER, 0.5 * LIFT
    lift = f.stiffness * (BASE + half * (1.0 - cos(theta))) + f.mass * f.gravity + f.preload
    return lift + half * OMEGA * (f.damping * sin(theta) + f.mass * OMEGA * cos(theta))


def test_a_rest_ends_where_the_force_is_zero(batches):
    """From 1 mm above the cam, and from rest; turns count from 1, from the strobe on."""
    assert abs(force(leaves())) < 1e-10
    assert force(leaves() - 1e-3) > 0.0 > force(leaves() + 1e-3)
    start = (1e-3, 0.0, FREE)
    record = record_of(batches, start, 0, 12)
    events = record.events()
    chatters = [turn for kind, turn, *_ in events if kind == CHATTER]
    assert len(chatters) >= 3
    for turn in range(1, 10):
        found = departure(batches, start, turn)
        if turn - 1 in chatters:
            assert found == pytest.approx(leaves(), abs=1e-9)
        else:
            assert found is None


def test_a_record_begins_at_the_state_to_the_last_bit(batches):
    """Other than a start by position and velocity, which rounds its gap."""
    gap, rate = 1e-3 * (1.0 + 2.0**-50), 0.1
    record = record_of(batches, (gap, rate, FREE), 0, 2)
    assert record.strobe_q[0] - batches.lift[0] == pytest.approx(gap, rel=1e-12)
    later = record_of(batches, (gap, rate, FREE), 1, 1)
    assert later.strobe_q[0] == record.strobe_q[1]
    resting = record_of(batches, (0.0, 0.0, RESTING), 0, 2).events()
    kind, turn, theta, *_ = resting[0]
    assert (kind, turn) == (DETACHMENT, 0)
    assert theta == pytest.approx(leaves(), abs=1e-9)


def test_what_does_not_leave_for_three_turns_has_no_departure(monkeypatch, batches):
    """The event after the last chatter of the turn counts, and only a departure or a blow."""
    asked = []

    def events(*rows):
        def record(_, start, transient, turns):
            asked.append((start, transient, turns))
            return SimpleNamespace(events=lambda: list(rows))

        monkeypatch.setattr(rest_outcomes, "record_of", record)
        return departure(batches, (0.0, 0.1, FREE), 5)

    one, other = (CHATTER, 0, 1.0), (CHATTER, 0, 2.0)
    assert events(one, (DETACHMENT, 0, 1.5), other, (DETACHMENT, 2, 2.5)) == 2.5
    assert asked[-1] == ((0.0, 0.1, FREE), 4, 4)
    assert events((0, 0, 0.1), one, (rest_outcomes.IMPACT, 1, 2.25)) == 2.25
    assert events(one, other) is None
    assert events((CHATTER, 1, 1.0), (DETACHMENT, 1, 1.5)) is None
    assert events(one, (CHATTER, 1, 1.5)) is None
    assert events() is None


class Finder:
    """`AttractorFinder` as the rests ask it."""

    def __init__(self, batches, outcomes=()):
        self.batches, self.targets, self.budget = batches, NOTHING, 50
        self.attractors, self.admitted, self.identified = [], [], []
        self.outcomes, self.asked = list(outcomes), []

    def admit(self, attractor):
        self.admitted.append(attractor)
        self.attractors.append(attractor)

    def identify(self, *state):
        self.identified.append(state)


def running(monkeypatch, finder, *ends):
    """`CellBatches.run` that ends so, one after the other: (gap, rate, mode, outcome, turns)."""
    left = list(ends)

    def run(self, gap, rate, targets, budget, mode=None, share=False):
        finder.asked.append((list(gap), list(rate), targets, budget, mode))
        columns = (np.array([x]) for x in left.pop(0))
        return SimpleNamespace(
            **dict(zip(("gap", "rate", "mode", "outcome", "turns"), columns, strict=True))
        )

    monkeypatch.setattr(CellBatches, "run", run)


def test_a_state_is_learned_once(monkeypatch, batches):
    """Within 1e-9 of the cam's top; what doubles remember is followed on by them."""
    finder = Finder(batches)
    rests = RestOutcomes(finder)
    near = 1e-9 * (BASE + LIFT)
    assert rests.near == pytest.approx(near)
    asked = []
    hold = {"hold": True}
    monkeypatch.setattr(RestOutcomes, "_doubles_hold", lambda *given: hold["hold"])
    monkeypatch.setattr(RestOutcomes, "_after", lambda self, *given: asked.append(given) or "after")
    monkeypatch.setattr(RestOutcomes, "_end_of", lambda self, after: 7)
    start = (1e-3, 0.0, FREE)
    rests.learn(start, (2e-3, 0.5, FREE), 4)
    assert (rests.states, rests.ends, asked) == ([(2e-3, 0.5)], [GOES_ON], [])
    hold["hold"] = False
    rests.learn(start, (2e-3 + 0.9 * near, 0.5 - 0.9 * near, FREE), 4)
    assert len(rests.states) == 1
    rests.learn(start, (2e-3 + 1.1 * near, 0.5, FREE), 6)
    rests.learn(start, (2e-3, 0.5 - 1.1 * near, FREE), 5)
    assert rests.ends == [GOES_ON, 7, 7]
    assert asked == [(start, 6), (start, 5)]
    known = finder.targets
    pairs = zip(rests.states, rests.ends, strict=True)
    assert known.rests == [Rest(*state, end) for state, end in pairs]
    assert (known.watch_rests, known.near) == (1, pytest.approx(near))
    for k in range(60):
        rests.learn(start, (1.0 + k, 0.5, FREE), 4)
    assert (len(finder.targets.rests), finder.targets.watch_rests) == (63, 1)
    rests.learn(start, (1.0 + 60, 0.5, FREE), 4)
    assert (len(finder.targets.rests), finder.targets.watch_rests) == (64, 0)
    assert finder.targets.rests[0].end == GOES_ON


def test_a_low_cam_has_a_least_nearness(batches):
    low = System.build(FOLLOWER, EccentricCam(kind="eccentric", base=-1e-5, lift=2e-5), STROBE)
    assert RestOutcomes(Finder(CellBatches(low, RPM, settings()))).near == pytest.approx(1e-12)


@pytest.mark.parametrize(("growth", "hold"), [(7e10, True), (7e10 * 1.01, False)])
def test_doubles_hold_where_errors_grow_little_until_the_next_rest(
    monkeypatch, batches, growth, hold
):
    """Of a start whose first chatter ends in turn 3: counted from that turn to three behind the
    next chatter, or to the attractor."""
    finder = Finder(batches)
    rests = RestOutcomes(finder)
    asked, windows = [], []

    def growth_of(system, rpm, record, window):
        windows.append(window)
        return growth

    monkeypatch.setattr(rest_outcomes, "largest_growth", growth_of)
    events = [(CHATTER, 2, 1.0), (DETACHMENT, 2, 2.0), (0, 4, 1.0), (CHATTER, 9, 1.0)]

    def record(batches, start, transient, turns):
        asked.append((start, transient, turns))
        return SimpleNamespace(events=lambda: events)

    monkeypatch.setattr(rest_outcomes, "record_of", record)
    running(monkeypatch, finder, *[(0.0, 0.0, FREE, 0, 20)] * 4)
    start, state = (1e-3, 0.0, FREE), (2e-3, 0.5, FREE)
    finder.targets = NOTHING._replace(rests=[Rest(1.0, 1.0, 3)], watch_rests=0, columns=4)
    assert rests._doubles_hold(start, state, 3) is hold
    assert asked == [(start, 0, 23)]
    ((gap, rate, targets, budget, mode),) = finder.asked
    assert (gap, rate, budget, mode) == ([1e-3], [0.0], 53, [FREE])
    assert targets.rests == [Rest(2e-3, 0.5, GOES_ON)]
    assert (targets.watch_rests, targets.near, targets.columns) == (1, rests.near, 4)
    del events[3:]
    rests._doubles_hold(start, state, 3)
    events.append((CHATTER, 3, 1.0))
    rests._doubles_hold(start, state, 3)
    assert windows == [range(2, 12), range(2, 23), range(2, 6)]


def test_a_departure_is_followed_once(monkeypatch, batches):
    """Phases that round to one multiple of 1e-9 rad are one."""
    rests = RestOutcomes(Finder(batches))
    phases = iter([2.0, 2.0 + 0.4e-9, 2.0 + 1e-9, 1.5, None])
    asked = []

    def departure_of(*given):
        assert given == (batches, (0.0, 0.0, FREE), 3)
        return next(phases)

    monkeypatch.setattr(rest_outcomes, "departure", departure_of)
    monkeypatch.setattr(
        rest_outcomes,
        "after_rest",
        lambda system, rpm, theta: asked.append(theta) or After(WANDERS),
    )
    found = [rests._after((0.0, 0.0, FREE), 3) for _ in range(5)]
    assert asked == [2.0, 2.0 + 1e-9, 1.5]
    assert [one.kind for one in found] == [WANDERS] * 4 + [UNKNOWN]
    decided = [theta for theta, _ in rests.decided]
    assert decided == pytest.approx([1.5, 2.0, 2.0 + 1e-9], abs=1e-12)


def test_where_a_motion_after_a_rest_ends(monkeypatch, batches):
    """A cycle is an attractor itself; another motion is followed on, twice where it is new."""
    c, c1 = batches.lift
    state = (c + 2e-3, c1 + 0.5)
    finder = Finder(batches)
    rests = RestOutcomes(finder)
    assert rests._end_of(After(UNKNOWN)) == FORGOTTEN
    states = ((0.03, 1.0), (0.04, 2.0))
    other = Attractor.periodic_of("P(1;1)", ((0.5, 0.5),), (1.0,), (0j, 0j))
    finder.attractors = [other]
    assert rests._end_of(After(CYCLE, 2, states, (1.0, 2.0))) == 1
    (cycle,) = finder.admitted
    assert dict(zip(cycle.states, cycle.symbols, strict=True)) == {states[0]: 1.0, states[1]: 2.0}
    monkeypatch.setattr(finder, "admit", finder.admitted.append)
    finder.attractors = [other]
    assert rests._end_of(After(CYCLE, 2, states, (1.0, 2.0))) == FORGOTTEN
    for kind, ends, index, watch in (
        (SETTLED, [(0.0, 0.0, FREE, 0, 9)], 0, 0),
        (WANDERS, [(0.0, 0.0, FREE, 3, 9)], 3, 1),
        (WANDERS, [(0.0, 0.0, FREE, NEW_REST, 9)], FORGOTTEN, 1),
        (SETTLED, [(0.0, 0.0, FREE, FORGOTTEN, 9)], FORGOTTEN, 0),
        (SETTLED, [(0.25, 0.5, FREE, UNDECIDED, 9), (0.0, 0.0, FREE, 2, 9)], 2, 0),
        (SETTLED, [(0.25, 0.5, FREE, UNDECIDED, 9)] * 2, FORGOTTEN, 0),
    ):
        finder.asked.clear()
        finder.identified.clear()
        running(monkeypatch, finder, *ends)
        assert rests._end_of(After(kind, 5, (states[0], state), (1.0,))) == index
        assert len(finder.asked) == len(ends)
        for gap, rate, targets, budget, _ in finder.asked:
            assert (gap, rate) == (pytest.approx([2e-3]), pytest.approx([0.5]))
            assert (targets.watch_rests, budget) == (watch, 50)
        unknown = [end for end in ends if end[3] == UNDECIDED]
        assert finder.identified == [end[:3] for end in unknown]
