"""What a crisis and its tangencies are told by, with saddles and folds written down here."""

from __future__ import annotations

from dataclasses import replace
from math import inf, log
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.explain import changes, crisis, saddles, tangency
from camcli.analysis.explain.changes import CriticalEvent, _change, _concerns, changes_between
from camcli.analysis.explain.crisis import Crisis, CrisisKind, find_crisis
from camcli.analysis.explain.tangency import FirstTouch, Fold, FoldPoint, Folds, Sampling, Tangency
from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.study import Bifurcation
from camcli.kernel.orbit_loop import IMPACT


def orbit_of(name, multiplier=2.0, turns=1):
    return Stub(name=name, multipliers=(complex(multiplier), 0.1 + 0j), turns=turns)


@pytest.mark.parametrize(
    ("multipliers", "base"),
    [((3.0, -2.0, -5.0), 1), ((3.0, 2.0, -0.9), 0), ((-1.5, 2.0, 3.0), 0)],
)
@pytest.mark.parametrize(("near", "far"), [(700.0, 710.0), (710.0, 700.0)])
def test_where_the_saddles_of_a_crisis_are_looked_for(monkeypatch, near, far, multipliers, base):
    """All at the calm speed; the edge is that of one whose unstable manifold goes both ways."""
    stays, leaves = near + 0.4 * (far - near), near + 0.5 * (far - near)
    calm = near + 0.8 * (stays - near)
    inside = [orbit_of(name, z) for name, z in zip("abc", multipliers, strict=True)]
    again, new = orbit_of("b"), orbit_of("d")
    asked, given = [], []

    class Carried:
        ends, cost, size = ("near run", "far run"), Cost(1, 2, 3), (1.0, 2.0)
        stays, leaves = near, far

        def __init__(self, *machine):
            assert machine == ("system", "settings", near, far, 77)

        def has_left(self, record):
            return record == "far run"

        def narrow(self):
            self.stays, self.leaves = stays, leaves

        def run(self, rpm, events=False):
            return rpm, events

        def measure(self, *at):
            asked.append(at)

    def find(system, rpm, record, size):
        asked.append((system, rpm, record, size))
        return inside if record == (calm, True) else [again, new]

    def tangencies(carried, *at):
        given.append(at)
        return crisis.Tangencies()

    for name, stub in {
        "CarriedAttractor": Carried, "find_saddles": find, "_tangencies": tangencies,
        "label": lambda record: "aperiodic",
        "same_orbit": lambda one, other: one.name == other.name,
    }.items():  # fmt: skip
        monkeypatch.setattr(crisis, name, stub)
    found = find_crisis("system", "settings", near, far, 77, "sampling")
    assert asked == [
        (calm, (calm, True)), ("system", calm, (calm, True), (1.0, 2.0)),
        ("system", calm, (leaves, True), (1.0, 2.0)),
    ]  # fmt: skip
    assert given == [(calm, inside[base], [*inside, new], "sampling")]
    assert (found.kind, found.rpm, found.bracket) == (
        CrisisKind.UNEXPLAINED, leaves, (stays, leaves),
    )  # fmt: skip
    assert found.error == pytest.approx(1.0)
    assert (found.near, found.turns) == (near, 77)
    assert (found.inside, found.beyond, found.cost) == (3, 2, Cost(1, 2, 3))


def test_a_saddle_is_met_from_the_calm_speed_or_from_the_last_that_stays(monkeypatch):
    """Those that lead out on neither side are passed over; the others in order of their speeds."""
    touches = {
        ("b", 703.0): 706.0, ("c", 704.0): 705.0, ("d", 703.0): None, ("d", 704.0): None,
        ("c", 703.0): None,
    }  # fmt: skip
    sides = {"a": 0.0, "b": -1.0, "c": 1.0, "d": 1.0, "lost": None, "gone": 1.0}

    def side(carried, rpm, saddle):
        assert rpm == 703.0
        if saddle.name == "lost":
            raise saddles.LostError
        return sides[saddle.name]

    def touch(folds, rpm):
        if folds.saddle.name == "gone":
            raise saddles.LostError
        at = touches[folds.saddle.name, rpm]
        return None if at is None else FirstTouch(Stub(rpm=at), at / 1000.0)

    monkeypatch.setattr(crisis, "inner_side", side)
    monkeypatch.setattr(crisis, "first_touch", touch)
    carried = Stub(stays=704.0, way=lambda rpm: rpm - 700.0)
    orbits = [orbit_of(name) for name in sides]
    found = crisis._tangencies(carried, 703.0, "base", orbits, "sampling")
    assert [(one.folds.saddle.name, one.folds.side, one.fold.rpm) for one in found.touched] == [
        ("c", 1.0, 705.0), ("b", -1.0, 706.0),
    ]  # fmt: skip
    assert [one.error for one in found.touched] == [0.705, 0.706]
    assert {(one.folds.base, one.folds.sampling) for one in found.touched} == {("base", "sampling")}
    assert ([one.name for one in found.unmet], found.lost) == (["d"], 2)


# -- changes


def motion(rpm, label, widest=0.5, **more):
    theta = np.array([1.0, 1.0 + widest])
    record = Stub(kind=np.full(2, IMPACT), theta=theta, u=-theta, period=np.arange(2))
    known = {"rpm": rpm, "label": label, "chatter": "none", "period": 1, "orbit": None}
    return Stub(**{**known, **more}, record=record)


@pytest.mark.parametrize(
    ("labels", "widths", "differ"),
    [
        (("aperiodic",) * 2, (1.0, 1.26), True), (("aperiodic",) * 2, (1.26, 1.0), True),
        (("aperiodic",) * 2, (1.0, 1.24), False),
        (("aperiodic",) * 2, (0.05, 0.08), False),  # by less than two degrees
        (("P(1;1)",) * 2, (0.5, 1.5), False), (("contact",) * 2, (0.5, 1.5), False),
        (("P(1;1)", "P(2;1:1)"), (0.5, 0.5), True),
    ],
)  # fmt: skip
def test_only_chaos_changes_by_its_size(labels, widths, differ):
    a, b = (motion(700.0, *one) for one in zip(labels, widths, strict=True))
    assert changes_between(a, b) is differ


def branch_event(label, stable, turns=3, rpm=705.0):
    source = Bifurcation.__new__(Bifurcation)
    object.__setattr__(source, "orbit", Stub(turns=turns, stable=stable))
    return CriticalEvent(rpm, 0.0, "fold", label, source=source)


@pytest.mark.parametrize(
    ("event", "labels", "does"),
    [
        (branch_event("P(3;1:1:1)", False), ("P(3;1:1:1)", "P(5;...)"), True),
        (branch_event("P(3;1:1:1)", True), ("P(5;...)", "P(7;...)"), False),
        (branch_event("P(3;1:1:1)", True), ("P(5;...)", "aperiodic"), True),
        (branch_event("P(3;1:1:1)", False), ("P(5;...)", "aperiodic"), False),  # it is no attractor
        (CriticalEvent(705.0, 0.0, "corner-hit", "P(1;inf)"), ("P(5;...)", "P(7;...)"), True),
    ],
)
def test_which_events_are_of_a_change(event, labels, does):
    a, b = (
        motion(rpm, label, orbit=None if label == "aperiodic" else Stub(turns=5))
        for rpm, label in zip((700.0, 710.0), labels, strict=True)
    )
    assert _concerns(event, a, b) is does


def test_the_cause_names_each_kind_of_event_once():
    a, b = motion(700.0, "P(3;1:1:1)"), motion(710.0, "P(6;1:1:1:1:1:1)")
    told = [branch_event(a.label, True, rpm=702.0), branch_event(b.label, True, rpm=708.0)]
    told.insert(1, replace(told[0], kind="period-doubling", rpm=705.0))
    outside = replace(told[0], rpm=711.0)
    found = _change(
        "system", "settings", changes.Events([*told, outside], [], [], Cost()), a, b, True
    )
    assert (found.cause, found.events) == ("fold+period-doubling", tuple(told))
    assert (found.low, found.high, found.before, found.after) == (700.0, 710.0, a.label, b.label)


def test_the_event_of_a_crisis_is_of_the_first_saddle_that_is_met():
    met = tuple(
        crisis.MetSaddle(Stub(label=label), 700.0, 0.1) for label in ("P(3;1:1:1)", "P(1;1)")
    )
    one = Crisis(CrisisKind.BOUNDARY, 705.0, 0.25, (704.0, 706.0), 700.0, 9, Cost(), None, met=met)
    event = changes._event_of(one)
    assert (event.rpm, event.error, event.kind) == (705.0, 0.25, "boundary-crisis")
    assert (event.label, event.corner, event.source) == ("chaos, P(3;1:1:1)", "", one)
    assert changes._event_of(replace(one, corner=Stub(name="c"))).corner == "c"


# -- saddles


@pytest.mark.parametrize(
    ("above", "below", "side"),
    [
        (0, 17, 1.0), (17, 0, -1.0), (0, 16, 0.0), (16, 0, 0.0),  # few may be a transient
        (3, 31, 1.0), (3, 30, 0.0), (31, 3, -1.0), (30, 3, 0.0), (40, 40, 0.0),
    ],
)  # fmt: skip
def test_the_inner_side_is_the_one_that_clearly_stays(monkeypatch, above, below, side):
    """Sixty starts on each side, over one turn of the multiplier, and so many states outside."""
    starts = []

    class Leaving:
        mu = 4.0

        def __init__(self, carried, rpm, orbit):
            assert (carried, rpm, orbit.turns) == ("carried", 703.0, 3)

        def leaf(self, t, first):
            return t, first

    def outside(carried, rpm, x, turns):
        starts.append((*x, turns))
        count = sum(1 for one in starts if (one[1] > 0.0) == (x[1] > 0.0))
        return int(count == 7) * (above if x[1] > 0.0 else below)

    monkeypatch.setattr(saddles, "Saddle", Leaving)
    monkeypatch.setattr(saddles, "_outside", outside)
    assert saddles.inner_side("carried", 703.0, orbit_of("a", 4.0, 3)) == side
    turns = 55 + int(3 * log(1e6) / log(4.0))
    assert len(starts) == 120
    for sign in (1.0, -1.0):
        own = [(t, many) for t, first, many in starts if first == sign * 1e-6]
        assert [t for t, _ in own] == pytest.approx([k / 60 * log(4.0) for k in range(60)])
        assert {many for _, many in own} == {turns}


@pytest.mark.parametrize("z", [0.999, -2.0, 2.0 + 1e-9j])
def test_a_saddle_has_an_inner_side_where_its_sides_keep_to_themselves(z):
    orbit = Stub(multipliers=(complex(z), 0.1 + 0j), turns=1)
    assert saddles.inner_side("carried", 703.0, orbit) == 0.0


@pytest.mark.parametrize(("root", "admissible"), [(None, True), ("root", False)])
def test_a_saddle_that_is_no_motion_any_more_is_lost(monkeypatch, root, admissible):
    shooter = Stub(at_value=lambda *_: root, verdict=lambda root: ("verdict", 0, 0.0))
    monkeypatch.setattr(saddles, "Shooter", lambda system, rpm: shooter)
    monkeypatch.setattr(saddles, "from_root", lambda *_: Stub(admissible=admissible))
    orbit = Stub(root=Stub(x=[], whole=(), turns=1))
    with pytest.raises(saddles.LostError):
        saddles.Saddle(Stub(system=None), 700.0, orbit)
    with pytest.raises(saddles.LostError):
        saddles.Saddle(Stub(system=None), 700.0, Stub(root=None))


# -- folds


@pytest.mark.parametrize(("mu", "periods"), [(4.0, 1), (-4.0, 2)])
def test_the_lowest_folds_of_motions_along_the_manifold(monkeypatch, mu, periods):
    """Heights by start and turn; a fold is lower than the starts on both sides, or as low."""
    starts, turns = 6, 55 + int(3 * log(1e4) / log(4.0))
    spacing = log(4.0) * periods / starts
    grid = spacing * (np.arange(starts) + 0.25)
    table = np.full((starts, turns + 1, 2), 0.01)
    heights = {
        2: [0.03, 0.01, 0.02, 0.02, 0.04, 0.01], 5: [0.03, 0.035, 0.04, 0.03, -0.02, 0.03],
        9: [0.03, 0.04, 0.049, 0.051, 0.049, 0.04], 11: [0.02, 0.01, 0.03, 0.01, 0.02, 0.01],
    }  # fmt: skip
    table[:, :, 0] = np.linspace(0.045, 0.04, starts)[:, None]
    for turn, column in heights.items():
        table[:, turn, 0] = column
    table[3, 11, 1] = 0.06  # far along the other manifold
    asked = []

    class Made(Folds):
        def at(self, rpm):
            return Stub(mu=mu), "saddle"

        def places(self, rpm, pair, t, n):
            assert (rpm, pair[1], n) == (703.0, "saddle", turns)
            return table[int(np.argmin(abs(grid - t)))]

        def lowest(self, rpm, n, t, half, samples):
            asked.append((rpm, n, t, half, samples))
            eta = {2: 0.005, 5: -0.02, 11: 0.06}[n]
            return FoldPoint(eta, t + 0.001, 0.5)

    folds = Made(None, orbit_of("base", mu, 3), orbit_of("p"), 1.0, Sampling(starts))
    found = folds.sample(703.0, 0.25)
    lowest_first = [(5, 4), (2, 1), (11, 1), (2, 3)]
    assert [(n, pytest.approx(grid[k])) for n, k in lowest_first] == [
        (n, t) for _, n, t, *_ in asked
    ]
    assert {(rpm, samples) for rpm, *_, samples in asked} == {(703.0, 2)}
    assert [half for *_, half, _ in asked] == pytest.approx([spacing] * 4)
    assert [(one.n, one.eta, one.rpm) for one in found] == [
        (5, -0.02, 703.0), (2, 0.005, 703.0), (2, 0.005, 703.0),
    ]  # fmt: skip
    assert [one.t for one in found] == pytest.approx([grid[k] + 0.001 for k in (4, 1, 3)])
    assert [one.half for one in found] == pytest.approx([0.5 * spacing] * 3)


def test_searches_go_on_until_all_are_made(monkeypatch):
    """One that finds no earlier tangency is none of the end; a fold that hardly touches is none."""
    folds_seen = {
        0: [(709.0, 0.01), (708.0, 0.02), (None, 0.03), (700.0, 0.04)],  # three are solved
        1: [(None, -0.5), (704.0, 0.1)], 2: [(701.0, -5e-8), (706.0, -1e-3)],
        3: [(707.0, -1.0)], 4: [(705.0, -2e-7)],
    }  # fmt: skip
    asked = []

    def sample(rpm, shift):
        asked.append((rpm, shift))
        return [Stub(rpm=at, eta=eta) for at, eta in folds_seen[len(asked) - 1]]

    def touch(folds, fold):
        return None if fold.rpm is None else Tangency(fold, fold.rpm / 1e4)

    monkeypatch.setattr(tangency, "touch", touch)
    monkeypatch.setattr(tangency, "width", lambda carried, *given: given)
    carried = Stub(way=lambda rpm: rpm - 700.0)
    folds = Stub(carried=carried, sampling=Sampling(searches=5, solved=3), sample=sample)
    found = tangency.first_touch(folds, 703.0)
    assert asked == [
        (703.0, 0.0), (708.0, 0.2), (708.0, 0.4), (706.0, 0.6), (706.0, 0.8),
    ]  # fmt: skip
    assert found.fold.rpm == 705.0
    assert found.error == (705.0, 0.0705, [709.0, 708.0, 706.0, 707.0, 705.0])


@pytest.mark.parametrize(
    ("runs", "error"), [((704.9, 705.1), 0.3), ((704.999, 705.001), 0.003), ((704.0, 705.0), 3.0)]
)
def test_an_error_is_no_more_than_three_lifetimes(runs, error):
    """Of the farther run; by the distances of four tangencies it would be 1.52 x 2."""
    stays, leaves = runs
    carried = Stub(stays=stays, leaves=leaves, way=lambda rpm: rpm - 700.0, crowding=1.0)
    solved = [705.0, 705.5, 706.0, 707.0]
    assert tangency.width(carried, 705.0, 0.0, solved) == pytest.approx(error, rel=1e-9)


def test_the_next_step_is_at_most_five_times_the_last():
    """The height falls by the cube: a secant would go far beyond the range."""
    asked = []

    class Cubic(Folds):
        def lowest(self, rpm, n, t, half):
            asked.append((rpm, t))
            noise = 1e-12 * (-1.0) ** len(asked)  # of the place
            return FoldPoint((705.0 - rpm) ** 3, 0.25 - 3e-4 * rpm + noise, 0.5)

    carried = Stub(near=704.9, far=710.0)
    fold = Fold(704.99, 7, 0.25 - 3e-4 * 704.99, 0.01, 0.0)
    tangency._secants(Cubic(carried, None, None, 1.0), fold)
    rpms = np.array([rpm for rpm, _ in asked])
    steps = np.diff(rpms)
    assert steps[0] == pytest.approx(1e-9 * 704.99)
    assert (steps[1:] <= 5.0 * steps[:-1] * (1.0 + 1e-6)).all()
    assert steps.max() > 100.0 * steps[0]
    straight = []

    class Line(Folds):
        def lowest(self, rpm, n, t, half):
            straight.append((rpm, t))
            return FoldPoint(
                0.01 * (705.0 - rpm), 0.25 - 3e-4 * rpm + noise * (-1) ** len(straight), 0.5
            )

    noise = 1e-12
    found = tangency._secants(Line(carried, None, None, 1.0), fold)
    assert found.rpm == pytest.approx(705.0, abs=2e-4)
    # a slope is not taken from steps so small that noise is as large as the drift
    assert found.slope == pytest.approx(-3e-4, rel=0.05)


@pytest.mark.parametrize(
    ("phases", "name"),
    [([], None), ([1.5], None), ([1.5, 2.0 + 0.9e-6], "b"), ([2.0 + 1.1e-6], None),
     ([3.0 - 1e-7, 1.0], "a")],
)  # fmt: skip
def test_a_fold_is_the_image_of_a_corner_that_its_motion_meets(monkeypatch, phases, name):
    corners = [
        Stub(name=letter, theta=at) for letter, at in zip("abc", (1.0, 2.0, 3.0), strict=True)
    ]
    theta = np.array(phases)
    record = Stub(
        kind=np.full(len(theta), IMPACT), theta=theta, u=-theta, period=np.zeros(len(theta))
    )
    asked = []

    def motion_of(rpm, x, turns, events):
        asked.append((rpm, x, turns, events))
        return record

    class Made(Folds):
        def at(self, rpm):
            return Stub(leaf=lambda t: ("leaf", t)), "saddle"

    monkeypatch.setattr(tangency, "corner_list", lambda cam: corners)
    carried = Stub(motion=motion_of, system=Stub(cam="cam"))
    found = Made(carried, None, None, 1.0).corner(Fold(703.0, 7, 0.25, 0.01, 0.0, inf))
    assert (found and found.name) == name
    assert asked == [(703.0, ("leaf", 0.25), 7, True)]
