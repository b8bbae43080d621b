"""Sudden changes of chaotic attractors: the solved tangency beside runs on either side of it."""

import re
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.explain import crisis, tangency
from camcli.analysis.explain.attractor import CarriedAttractor, states_of
from camcli.analysis.explain.changes import (
    CriticalEvent,
    Events,
    _change,
    _concerns,
    _persists,
    changes_between,
)
from camcli.analysis.explain.crisis import CrisisKind, find_crisis
from camcli.analysis.explain.saddles import LostError, Saddle, find_saddles, monodromy
from camcli.analysis.explain.tangency import FEW, RANK, UNSAMPLED, Sampling, width
from camcli.analysis.integrate import Cost, Orbit, Start, with_turns
from camcli.analysis.orbits.study import Bifurcation
from camcli.kernel.orbit_loop import IMPACT
from camcli.scene import load_scene
from camcli.system import Follower, System
from camcli.words.explanations import crisis_sentences
from tests.conftest import chapter_system, settings

RUN = settings(300, 1)


def leaves(system, rpm, start, box, turns=400_000):
    """True where a run from the start has a height at the strobe outside the box."""
    q = np.asarray(Orbit(system, rpm, with_turns(RUN, 0, turns), start).run(events=False).strobe_q)
    return bool(((q < box[0]) | (q > box[1])).any())


def reads_well(found):
    """Sentences for people: no tuples, no repr of a float, no text of an error."""
    for said in crisis_sentences(found):
        assert re.fullmatch(r"[A-Z].*\.", said)
        assert not re.search(r"\d\.\d{7}|None|inf\b|run\.start|found|\(\(", said)


@pytest.mark.parametrize(("damping", "strobe_deg"), [(0.0, 0.0), (1.0, 155.0)])
def test_trace_and_determinant_of_the_map_are_those_of_the_orbit(damping, strobe_deg):
    """The product of saltation matrices at the strobe, beside the solved orbit's own."""
    system = chapter_system(strobe_deg, damping=damping)
    carried = CarriedAttractor(system, RUN, 750.0, 750.3, 500)
    saddles = find_saddles(system, 750.0, carried.run(750.0, True), carried.size)
    assert len(saddles) >= 10
    for orbit in saddles:
        matrix = monodromy(carried, 750.0, np.array(orbit.states[0]), orbit.turns)
        assert np.trace(matrix) == pytest.approx(orbit.trace, rel=1e-9)
        assert np.linalg.det(matrix) == pytest.approx(orbit.det, rel=1e-7)


@pytest.mark.parametrize(("flown", "known"), [(3, True), (2, False)])
def test_a_motion_that_ends_early_has_no_map(monkeypatch, flown, known):
    """Three turns are asked for, and the record has so many."""
    carried = CarriedAttractor(chapter_system(), RUN, 750.0, 750.3, 100)
    x = states_of(carried.ends[0])[0]
    record = carried.motion(750.0, x, flown - 1, True)  # one turn more than is asked for
    assert record.periods == flown
    monkeypatch.setattr(carried, "motion", lambda *_, **__: record)
    if known:
        assert monodromy(carried, 750.0, x, 3).shape == (2, 2)
    else:
        with pytest.raises(LostError):
            monodromy(carried, 750.0, x, 3)


def small_system(times):
    """The chapter's machine with all lengths times a power of two."""
    lengths = (
        "base_radius",
        "flank_center",
        "flank_radius",
        "nose_center",
        "nose_radius",
        "offset",
    )
    cam = load_scene(None).cam.model_dump()
    changes = {f"cam.{name}": cam[name] * times for name in lengths}
    scene = load_scene(None, changes)
    return System.build(Follower(**scene.follower.model_dump()), scene.cam, 0.0)


def test_a_saddle_has_its_directions_in_any_unit_of_length():
    found = []
    for times in (1.0, 2.0**-20):  # m and some um
        carried = CarriedAttractor(small_system(times), RUN, 750.0, 750.3, 500)
        saddles = find_saddles(carried.system, 750.0, carried.run(750.0, True), carried.size)
        own = [Saddle(carried, 750.01, orbit) for orbit in saddles[:12]]
        found.append([(x.orbit.label, x.mu, *(x.x / times), *x.leaf(0.5) / times) for x in own])
    large, small = found
    assert len(large) == len(small) == 12
    for one, other in zip(large, small, strict=True):
        assert one[0] == other[0]
        assert one[1:] == pytest.approx(other[1:], rel=1e-9)


@pytest.mark.soak
def test_a_crisis_is_at_the_same_speed_in_any_unit_of_length():
    large, small = (find_crisis(small_system(x), RUN, 361.0, 361.4, 4000) for x in (1.0, 2.0**-7))
    assert large.kind is small.kind is CrisisKind.INTERIOR
    assert (large.rpm, large.error, *large.bracket) == pytest.approx(
        (small.rpm, small.error, *small.bracket)
    )
    assert (large.inside, large.beyond, large.lost) == (small.inside, small.beyond, small.lost)
    assert [x.orbit.label for x in large.met] == [x.orbit.label for x in small.met]


@pytest.mark.soak
def test_runs_leave_beyond_the_solved_speed_and_not_before_it():
    system = chapter_system(restitution=0.75)
    found = find_crisis(system, RUN, 740.0, 741.0)
    assert (found.kind, found.met[0].orbit.label) == (CrisisKind.INTERIOR, "P(5;1:1:1:1:1)")
    orbit = Orbit(system, 740.0, with_turns(RUN, 1000, 20_000))
    q = np.asarray(orbit.run(events=False).strobe_q)
    box, start = (1.1 * q.min() - 0.1 * q.max(), 1.1 * q.max() - 0.1 * q.min()), orbit.as_start()
    nudged = [Start(start.q * (1.0 + k * 1e-7), start.v, start.theta) for k in range(3)]
    assert not any(leaves(system, found.rpm - 2e-3, s, box) for s in nudged)
    assert all(leaves(system, 740.12, s, box) for s in nudged)


def test_where_nothing_leaves_it_is_said_which_attractor_was_carried(chapter):
    """The large attractor beyond the crisis holds the small one: carried back, nothing leaves."""
    found = find_crisis(chapter, RUN, 740.3, 740.0, turns=20_000)
    assert (found.kind, found.rpm, found.error) == (CrisisKind.STAYS, 740.0, inf)
    assert crisis_sentences(found)[0].startswith("Nothing leaves the attractor carried from 740.3")
    reads_well(found)
    found = find_crisis(chapter, RUN, 730.0, 731.0, turns=2000)
    assert (found.kind, found.met) == (CrisisKind.NOT_CHAOTIC, ())


def motion(rpm, label, widest=0.0):
    """A motion that is nothing but its label and the range of its impact phases."""
    theta = np.linspace(1.0, 1.0 + widest, 20)
    record = SimpleNamespace(kind=np.full(20, IMPACT), theta=theta, u=-theta, period=np.arange(20))
    return SimpleNamespace(
        rpm=rpm, label=label, chatter="none", record=record, orbit=None, period=0, status=0
    )


def test_chaos_that_is_half_as_wide_again_is_another_attractor():
    narrow, wide = motion(700.0, "aperiodic", 0.2), motion(710.0, "aperiodic", 0.3)
    assert changes_between(narrow, wide)
    assert not changes_between(narrow, motion(710.0, "aperiodic", 0.22))


def named(rpm, label, **more):
    return SimpleNamespace(**{**vars(motion(rpm, label)), **more})


@pytest.mark.parametrize(("near", "far"), [(700.0, 710.0), (710.0, 700.0)])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_the_first_meeting_from_the_near_end_is_the_crisis(monkeypatch, near, far, order):
    """Whatever the order in which the saddles were found; each is told with its own numbers."""
    rpms = [near + share * (far - near) for share in (0.3, 0.5, 0.7)]
    parts = ["first", "second", "third", "unmet", "lost"]
    bracket = near + 0.2 * (far - near), near + 0.25 * (far - near)

    class Carried:
        ends, cost, stays, leaves, size, turns = ((1, 2), Cost(), near, far, (1.0, 1.0), 10)
        has_left = staticmethod(bool)

        def __init__(self, *_):
            pass

        def narrow(self):
            """Runs at speeds between show where the attractor stays, and where it leaves."""
            self.stays, self.leaves = bracket

        def run(self, *_, **__):
            return None

        def measure(self, *_):
            pass

        def way(self, rpm):
            return abs(rpm - near)

    def folds(carried, base, orbit, *_):
        saddle = SimpleNamespace(orbit=orbit.name)
        return SimpleNamespace(
            name=orbit.name, at=lambda rpm: (None, saddle), corner=lambda fold: f"{orbit.name} b"
        )

    def touch(folds, rpm):
        if folds.name == "lost":
            raise LostError
        if folds.name == "unmet":
            return None
        k = parts.index(folds.name)
        return tangency.FirstTouch(SimpleNamespace(rpm=rpms[k]), 0.1 * (k + 1))

    named = [SimpleNamespace(name=name, multipliers=(2.0 + 0j, 0.1 + 0j)) for name in parts]
    found = [named[3], *(named[k] for k in order), named[4]]
    for name, stub in {
        "CarriedAttractor": Carried, "Folds": folds, "first_touch": touch,
        "label": lambda record: "aperiodic", "inner_side": lambda *_: 1.0,
        "find_saddles": lambda *_: found, "same_orbit": lambda a, b: a is b,
        "_kind": lambda folds, rpm: CrisisKind.BOUNDARY,
    }.items():  # fmt: skip
        monkeypatch.setattr(crisis, name, stub)
    result = find_crisis(None, RUN, near, far)
    told = [(one.orbit, one.rpm, one.error) for one in result.met]
    assert told == [(parts[k], rpms[k], 0.1 * (k + 1)) for k in range(3)]
    assert (result.rpm, result.error, result.corner) == (rpms[0], 0.1, "first b")
    assert ([one.name for one in result.unmet], result.lost) == (["unmet"], 1)
    assert (result.inside, result.beyond, result.bracket) == (5, 5, bracket)


@pytest.mark.parametrize(
    ("before", "after", "changes"),
    [
        ({"chatter": "complete", "period": 1}, {"chatter": "complete", "period": 1}, False),
        ({"chatter": "complete", "period": 1}, {"chatter": "complete", "period": 2}, True),
        ({"chatter": "complete", "period": 2}, {"chatter": "incomplete", "period": 2}, True),
        ({"chatter": "none", "period": 1}, {"chatter": "none", "period": 1}, True),
    ],
)
def test_impacts_before_a_rest_are_no_change(before, after, changes):
    """Motions of other labels: where both rest, only the period counts."""
    one, other = named(700.0, "P(1;2)", **before), named(710.0, "P(1;3)", **after)
    assert changes_between(one, other) == changes_between(other, one) == changes


@pytest.mark.parametrize(
    ("rows", "persists"),
    [
        ([(700.0, True), (705.0, True), (710.0, True)], True),
        ([(690.0, True), (720.0, True)], True),
        ([(700.0, True), (705.0, True), (710.0, False)], False),
        ([(700.0, False), (705.0, True), (710.0, True)], False),
        ([(701.0, True), (709.0, True)], False),
        ([], False),
    ],
)
def test_an_orbit_persists_where_it_attracts_on_both_sides(rows, persists):
    a, b = named(700.0, "P(1;1)", orbit="one"), named(710.0, "aperiodic")
    points = [SimpleNamespace(value=x, label="P(1;1)", stable=stable) for x, stable in rows]
    points += [SimpleNamespace(value=x, label="P(2;1:1)", stable=True) for x in (600.0, 800.0)]
    found = Events([], [], [SimpleNamespace(points=points)], Cost())
    assert _persists(found, a, a, b) == persists


@pytest.mark.parametrize(
    ("turns", "of_motions", "concerns"), [(1, (2, 4), True), (2, (4, 3), True), (2, (1, 3), False),
                                          (2, (1, 1), False), (3, (2, 6), True)],
)  # fmt: skip
def test_an_event_concerns_what_doubles_from_its_orbit(turns, of_motions, concerns):
    """The turns of a motion are a multiple of those of the orbit, not the other way round."""
    a, b = (
        named(rpm, f"P({n};...)", orbit=SimpleNamespace(turns=n))
        for rpm, n in zip((700.0, 710.0), of_motions, strict=True)
    )
    source = Bifurcation.__new__(Bifurcation)
    object.__setattr__(source, "orbit", SimpleNamespace(turns=turns, stable=False))
    assert _concerns(CriticalEvent(705.0, 0.0, "fold", "another", source=source), a, b) == concerns


@pytest.mark.parametrize(
    ("stays", "leaves", "change", "solved", "error"),
    [
        (704.9, 705.2, 0.0, (), 0.6),  # three lifetimes of the farther of the two runs
        (705.0, 705.0, 0.0, (), 705.0 * UNSAMPLED),
        (704.9, 705.2, 0.0, (705.01, 705.02), 0.01),  # too few tangencies to tell
        (704.9, 705.2, 0.0, (705.01, 705.02, 705.05), 0.05 * (16 ** (1 / 3) - 1)),
        (704.9, 705.2, 0.0, (705.01, 705.02, 705.03, 705.06), 0.06),  # x of (1 + x)^-4 is 1
        (704.9, 705.2, 0.0, (705.09, 705.06, 705.03, 705.02, 705.01), 0.06),  # the earliest five
        (704.9, 705.2, 0.0, (705.0000001, 705.01, 705.02), 0.01),  # one fold, solved twice
        (704.9, 705.2, 0.3, (705.01, 705.02, 705.03, 705.06), 0.3),  # the last period moved it
        (704.3, 704.6, 0.0, (705.01, 705.02, 705.03, 705.06), 0.4),  # a run has left so early
    ],
)
def test_the_error_of_a_tangency_is_the_largest_of_what_is_known(
    stays, leaves, change, solved, error
):
    way = lambda rpm: abs(rpm - 700.0)  # noqa: E731
    carried = SimpleNamespace(stays=stays, leaves=leaves, way=way, crowding=1.0)
    assert width(carried, 705.0, change, [705.0, *solved]) == pytest.approx(error, rel=1e-9)


@pytest.mark.parametrize("alpha", [1.0, 0.5, 0.3])
def test_the_error_of_a_tangency_holds_as_often_as_is_said(alpha):
    """Tangencies at random beyond 700 rpm, d^alpha of them nearer than d: 15 of 16 errors hold."""
    rng, way = np.random.default_rng(1), lambda rpm: abs(rpm - 650.0)
    carried = SimpleNamespace(stays=-1e9, leaves=1e9, way=way, crowding=alpha)
    for count in (FEW, RANK, 8):
        off = np.sort(rng.random((4000, 40)), axis=1)[:, :count] ** (1.0 / alpha)
        speeds = 700.0 + 1e4 * off
        errors = np.array([width(carried, own[0], 0.0, own.tolist()) for own in speeds])
        held = np.mean(speeds[:, 0] - 700.0 <= errors)
        assert held == pytest.approx(15 / 16, abs=0.015)


@pytest.mark.soak
@pytest.mark.parametrize("starts", [2000, 1000, 500, 250])
def test_coarser_samples_of_folds_find_the_crisis_within_their_error(chapter, starts):
    """682.2046 rpm, by runs of millions of turns; and the error is no more than ten of 1e-4."""
    found = find_crisis(chapter, RUN, 682.0, 694.0, sampling=Sampling(starts))
    assert found.kind is CrisisKind.BOUNDARY
    assert abs(found.rpm - 682.2046) < found.error < 1e-3


def test_an_event_belongs_to_an_interval_that_its_error_reaches():
    before, after = motion(700.0, "P(1;1)"), motion(710.0, "P(2;1:1)")
    for place, inside in ((710.5, True), (711.5, False), (699.5, True)):
        event = CriticalEvent(place, 1.0, "period-doubling", "P(1;1)")
        events = Events([event], [], [], Cost())
        change = _change(chapter_system(), RUN, events, before, after, False)
        assert (event in change.events) == inside


def test_a_later_search_tries_only_folds_that_have_touched_before_the_best_speed(monkeypatch):
    """Seen from 12 rpm down: a fold that lies lower at the best speed touched earlier, at 9 rpm."""
    early, known, above = (
        SimpleNamespace(rpm=rpm, eta=eta) for rpm, eta in ((9.0, -0.5), (8.0, 0.0), (11.0, 0.5))
    )
    samples = iter([[known], [above, early], []])
    asked = []
    folds = SimpleNamespace(
        carried=SimpleNamespace(way=lambda rpm: 12.0 - rpm),
        sampling=SimpleNamespace(searches=3, solved=5),
        sample=lambda rpm, shift: asked.append((rpm, shift)) or next(samples),
    )
    monkeypatch.setattr(tangency, "touch", lambda _, fold: tangency.Tangency(fold, 0.125))
    monkeypatch.setattr(tangency, "width", lambda _, rpm, change, solved: (rpm, change, solved))
    found = tangency.first_touch(folds, 7.0)
    assert found == (early, (9.0, 0.125, [8.0, 9.0]))
    assert asked == [(7.0, 0.0), (8.0, 1.0 / 3.0), (9.0, 2.0 / 3.0)]
    samples = iter([[]])
    assert tangency.first_touch(folds, 7.0) is None
