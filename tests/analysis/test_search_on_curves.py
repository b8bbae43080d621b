"""Where on a curve points of codimension two are looked for, and from which guess.

The roots of the curves are written by hand; what is solved from a guess is only noted here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from types import SimpleNamespace as Stub

import pytest
from conftest import chapter_system
from flint import arb

from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.codim2 import Condition, Meeting, _CurveSearch, _on_curve, _solvable
from camcli.analysis.orbits.codim2 import Test as What
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.shooter import Root
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.regions import corner_list
from camcli.exact.shooting import NotProvedError
from camcli.kernel.certify import Verdict

PLANE = Stub(names=("rpm", "restitution"), ranges=((600.0, 800.0), (0.5, 0.9)), steps=20)
STEP = pytest.approx((10.0, 0.02))  # of the plane, in either parameter
FOLD, FLIP, FADE = Condition(What.FOLD), Condition(What.FLIP), Condition(What.FADE, 0)
CORNER, GRAZE = Condition(What.CORNER, 0, 1), Condition(What.GRAZE, 0, angle=1.0)


def root(x, whole=(0, 0), rates=(-1.0,), turns=1, values=(700.0, 0.8)):
    """A root by its phases, rates and parameter; its `machine` holds both values of the plane."""
    return Root(list(x), tuple(whole), turns, values, 0, list(rates), [0.5] * len(x), 0.0, 0.0, 1)


class Search(_CurveSearch):
    """It notes what it is to solve, and solves those conditions that are told to be met."""

    def __init__(self, own, tests=None, met=(), located=None, **curve):
        located = located or Stub(impact=0, kind=Kind.FOLD, fading=None)
        super().__init__(chapter_system(), Stub(located=located, **curve), 7, PLANE)
        self.is_own, self.tests, self.met, self.asked = own, tests or {}, met, []

    def own(self, root):
        return self.is_own

    def _tests(self, root):
        return self.tests[id(root)]

    def values(self, root):
        return root.machine

    def _solved(self, guess, values, room, condition, own=None):
        self.asked.append((guess, tuple(values), tuple(room), condition, own))
        if condition in self.met:
            yield condition


def at(root, crossing=None, det=0.5, **values):
    """A point of a curve."""
    return Stub(orbit=Stub(root=root, det=det), crossing=crossing, **values)


def test_between_two_points_a_guess_is_where_a_test_function_would_be_zero_if_linear():
    """Of functions that change their sign; a zero counts as not negative."""
    first = root([1.0, 2.0, 700.0], values=(700.0, 0.8))
    second = root([3.0, 6.0, 704.0], values=(704.0, 0.7))
    names = [Condition(What.CORNER, k) for k in range(7)]
    here = dict(zip(names, (-1.0, 2.0, 2.0, 0.0, -1.0, 5.0, 0.0), strict=True))
    there = dict(zip(names[:5], (3.0, 4.0, -6.0, -1.0, 0.0), strict=True)) | {names[6]: 1.0}
    search = Search(FOLD, {id(first): here, id(second): there}, met=[names[0], names[2]])
    found = list(search.between(at(first), at(second)))
    assert found == [names[0], names[2]]
    shares = {0: 0.25, 2: 0.25, 3: 0.0, 4: 1.0}
    assert [names.index(asked[3]) for asked in search.asked] == list(shares)
    for (guess, values, room, _, own), share in zip(search.asked, shares.values(), strict=True):
        assert guess.x == pytest.approx([1.0 + 2.0 * share, 2.0 + 4.0 * share, 700.0 + 4 * share])
        assert guess.machine == second.machine
        assert values == pytest.approx((700.0 + 4.0 * share, 0.8 - 0.1 * share))
        assert room == pytest.approx((4.0, 0.1))
        assert own is None


@pytest.mark.parametrize("own", [FOLD, GRAZE])
def test_a_corner_that_a_flight_touches_is_looked_for_on_a_curve_of_grazing(monkeypatch, own):
    first = root([1.0, 2.0, 700.0])
    second = root([1.1, 2.1, 704.0], values=(704.0, 0.7))
    search = Search(own, {id(first): {}, id(second): {}})
    looked = []
    monkeypatch.setattr(search, "_corner_passed", lambda *points: iter([points]))
    monkeypatch.setattr(
        search, "_corner_grazing", lambda *roots: looked.append(roots) or iter(["touched"])
    )
    before, behind = at(first), at(second)
    found = list(search.between(before, behind))
    assert found == [(before, behind), *(["touched"] if own is GRAZE else [])]
    assert looked == ([(first, second, pytest.approx((4.0, 0.1)))] if own is GRAZE else [])


def test_pairs_are_of_one_smooth_map_on_each_side_of_a_corner():
    a, b, c, d = (root([float(k), 2.0, 700.0]) for k in range(4))
    other = root([1.0, 2.0, 700.0], whole=(1, 0))
    search = Search(FOLD)
    left_right = Stub(left=c, right=other), Stub(left=d, right=other)
    assert list(search._pairs(at(a), at(b))) == [(a, b)]
    assert list(search._pairs(at(a), at(other))) == []
    assert list(search._pairs(at(None), at(b))) == list(search._pairs(at(a), at(None))) == []
    crossed = [at(root, crossing) for root, crossing in zip((a, b), left_right, strict=True)]
    assert list(search._pairs(*crossed)) == [(c, d), (other, other)]
    assert list(search._pairs(crossed[0], at(b))) == list(search._pairs(at(a), crossed[1])) == [
        (a, b)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("before", "behind", "impact", "side"),
    [
        ((1, 0, 2, 0), (1, 0, 3, 0), 1, 1),
        ((1, 0, 3, 0), (1, 0, 2, 0), 1, -1),
        ((5, 0, 2, 1), (0, 1, 2, 1), 0, 1),  # through the start of a turn
        ((0, 1, 2, 1), (5, 0, 2, 1), 0, -1),
    ],
)
def test_an_impact_that_passes_a_corner_is_looked_for_there(
    monkeypatch, before, behind, impact, side
):
    """Which way it goes, by its turn and then by its stretch; a smooth boundary is none."""
    x = [1.0, 2.0, 1.5, 2.5, 700.0]
    first, second = (root(x, whole, (-1.0, -2.0)) for whole in (before, behind))
    for name, wanted in (("c", [(first, (700.0, 0.8), STEP, Condition(What.CORNER, impact, side),
                                 None)]), ("", [])):  # fmt: skip
        search = Search(FOLD)
        monkeypatch.setattr(search, "_corner", lambda *of, name=name: of == (first, impact, side)
                            and name)  # fmt: skip
        list(search._corner_passed(at(first), at(second)))
        assert search.asked == wanted
    for points in ((at(first), at(first)), (at(None), at(second)), (at(first), at(None))):
        search = Search(FOLD)
        list(search._corner_passed(*points))
        assert search.asked == []


def test_a_corner_is_that_at_the_end_of_a_stretch_or_at_its_start():
    search, stretches = Search(FOLD), chapter_system().cam.stretches
    named = {corner.name: corner.theta for corner in corner_list(chapter_system().cam)}
    assert len(named) == 6
    names = set()
    for i, stretch in enumerate(stretches):
        for side, phase in ((1, stretch.end), (-1, stretch.start)):
            name = search._corner(root([1.0, 2.0, 700.0], (i, 0)), 0, side)
            names.add(name)
            beside = [abs((named[n] - phase + pi) % (2 * pi) - pi) for n in named if n == name]
            assert beside == pytest.approx([0.0] * bool(name), abs=1e-12)
            is_one = any(abs((x - phase + pi) % (2 * pi) - pi) < 1e-9 for x in named.values())
            assert bool(name) is is_one
    assert names - {""} == set(named)


def test_a_flight_touches_a_corner_where_its_graze_goes_to_another_stretch(monkeypatch):
    first, second = root([1.0, 2.0, 700.0]), root([1.2, 2.0, 700.0])
    places = {2.0: (3, 1), 2.2: (3, 1)}
    asked = []

    def place(theta, turn):
        asked.append((float(theta), turn))
        stretch, turn = places[round(float(theta), 6)]
        return Stub(stretch=stretch, turn=turn)

    shooting = Stub(place=place, places=[Stub(turn=1)])
    monkeypatch.setattr(codim2, "exact_shooting", lambda system, root: shooting)
    for there, side in (((3, 1), 0), ((4, 1), 1), ((2, 1), -1), ((0, 2), 1), ((5, 0), -1)):
        places[2.2] = there
        search = Search(GRAZE)
        list(search._corner_grazing(first, second, (4.0, 0.1)))
        wanted = Condition(What.GRAZE_AT_CORNER, 0, side)
        assert search.asked == ([(first, (700.0, 0.8), (4.0, 0.1), wanted, None)] if side else [])
    assert set(asked) == {(2.0, 1), (2.2, 1)}


@pytest.mark.parametrize(("own", "wanted"), [
    (FOLD, [What.CUSP]), (FLIP, []), (CORNER, [What.FOLD, What.FLIP]),
    (GRAZE, [What.FOLD, What.FLIP]), (FADE, [What.FOLD, What.FLIP]),
])  # fmt: skip
def test_the_functions_whose_zeros_are_points_on_a_curve(monkeypatch, own, wanted):
    """One that cannot be computed is left out; each is the last equation of its meeting."""

    class Made:
        def __init__(self, system, plane, root, conditions):
            (self.condition,) = conditions

        def start(self, root, values):
            return root, values

        def equations(self, u):
            if self.condition.test == What.FLIP:
                raise ZeroDivisionError
            return [arb(9), arb(3), arb(-5)]

    work = []
    monkeypatch.setattr(codim2, "Meeting", Made)
    monkeypatch.setattr(codim2, "spend", work.append)
    search = Search(own)
    one = root([1.0, 2.0, 1.5, 2.5, 700.0], (0, 0, 1, 0), (-1.0, -2.0))
    found = _CurveSearch._tests(search, one)
    assert found == {Condition(test): -5.0 for test in wanted if test != What.FLIP}
    assert work == [500 * 2] * len(wanted)  # impacts


def conserving(*dets):
    return [at(root([1.0, 2.0, 700.0]), det=det, first=700.0, second=0.8) for det in dets]


@pytest.mark.parametrize(
    ("ends", "met", "asked"),
    [
        ((Kind.END_OF_RANGE, Kind.END_OF_RANGE), [], []),
        ((Kind.LOST, Kind.LOST), [], ["first", "second", "collapse"]),
        ((Kind.LOST, Kind.LOST), ["first"], ["first"]),
        ((Kind.LOST, Kind.LOST), ["second"], ["first", "second"]),
        ((Kind.SHORTER_ORBIT, Kind.SHORTER_ORBIT), ["collapse"], ["collapse"]),
        ((Kind.SHORTER_ORBIT, Kind.SHORTER_ORBIT), [],
         ["collapse", "first", "second", "collapse"]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("end", [0, 1])
def test_at_an_end_its_causes_are_tried_until_one_is_met(monkeypatch, ends, met, asked, end):
    mixed = [Kind.END_OF_RANGE, Kind.END_OF_RANGE]
    mixed[end] = ends[end]
    points = conserving(0.5, 0.6)
    search = Search(FOLD, met=met, points=points, ends=mixed, beyond=("before", "behind"))
    tried = []

    def causes(one, beyond):
        assert one is (points[0], points[-1])[end].orbit.root
        assert beyond == ("before", "behind")[end]
        return iter(["first", "second"])

    def solved(one, values, room, condition):
        assert (one, values, room) == ((points[0], points[-1])[end].orbit.root, (700.0, 0.8), STEP)
        tried.append(condition)
        return iter([condition] if condition in met else [])

    monkeypatch.setattr(search, "_causes", causes)
    monkeypatch.setattr(search, "_solved", solved)
    monkeypatch.setattr(
        search, "_collapse", lambda one, room: solved(one, (700.0, 0.8), room, "collapse")
    )
    assert list(search.at_end(end)) == met
    assert tried == asked


@pytest.mark.parametrize(
    ("dets", "end", "told"),
    [((1.0, 0.9), 0, True), ((1.0, 0.9), 1, False), ((0.9, 1.0), 1, True), ((1.0, 1.0), 1, False)],
)
def test_an_end_at_which_nothing_is_lost_is_told_where_others_lose(dets, end, told):
    ends = (Kind.END_OF_RANGE, Kind.END_OF_RANGE)
    search = Search(FLIP, points=conserving(*dets), ends=ends, beyond=(None, None))
    found = list(search.at_end(end))
    assert [point.kind for point in found] == [codim2.PointKind.CONSERVATIVE] * told
    for point in found:
        assert point.conditions == (FLIP, FLIP)
        assert (point.curves, point.corners, point.status) == ((7,), (), Bracket.OK)
        assert (point.first, point.second, point.before, point.behind) == (700.0, 0.8, 0.0, 0.0)
        assert point.orbit is search.curve.points[0 if end == 0 else -1].orbit
        assert point.errors == (2.0 * 2.0**-43, 2.0 * 2.0**-53)
        search.is_own, search._corner = CORNER, lambda *of: of[1:]
        (there,) = search.at_end(end)
        assert (there.conditions, there.corners) == ((CORNER, CORNER), ((0, 1),))
    gone = Search(FLIP, points=[at(None)], ends=(Kind.LOST,) * 2, beyond=(None, None))
    assert list(gone.at_end(0)) == []


@pytest.mark.parametrize("own", [CORNER, FADE, GRAZE, FOLD, FLIP])
@pytest.mark.parametrize(
    ("apart", "turns", "impacts", "collapses"),
    [(0.29, 2, 4, True), (0.31, 2, 4, False), (-0.29, 2, 4, True), (-0.31, 2, 4, False),
     (0.1, 1, 4, False), (0.1, 2, 3, False)],
)  # fmt: skip
def test_a_doubled_orbit_becomes_the_one_of_the_means_of_both_halves(
    own, apart, turns, impacts, collapses
):
    """Its own condition then is of an impact of the single orbit. Rates may differ by more."""
    x = [1.0, 2.0, 1.5, 2.5, 1.0 + apart, 4.0, 1.5, 3.5][: 2 * impacts]
    whole, rates = (0, 0, 1, 0, 0, 1, 1, 1), [-1.0, -2.0, -3.0, -4.0]
    one = root([*x, 700.0], whole[: 2 * impacts], rates[:impacts], turns)
    own = codim2.replace(own, impact=own.impact + 3) if own.impact == 0 else own
    search = Search(own)
    list(search._collapse(one, (4.0, 0.1)))
    if not collapses or own.test in (What.FOLD, What.FLIP):
        assert search.asked == []
        return
    ((single, values, room, condition, of_single),) = search.asked
    assert single.x == pytest.approx([1.0 + apart / 2.0, 3.0, 1.5, 3.0, 700.0])
    assert (single.whole, single.turns, single.rates) == ((0, 0, 1, 0), 1, [-1.0, -2.0])
    assert single.tangent == [0.5] * 5
    assert (values, room, condition) == ((700.0, 0.8), (4.0, 0.1), FLIP)
    assert of_single == codim2.replace(own, impact=1)  # the fourth impact is the second one


def causes_of(own, beyond=None, verdict=(Verdict.ADMISSIBLE, 0, 0.0), dips=()):
    one = root([1.0, 2.0, 1.5, 2.5, 2.0, 3.0, 700.0], (0, 0, 1, 0, 2, 0), [-3.0, 0.5, -2.0])
    search = Search(own)
    search._shooter = lambda root: Stub(
        beyond=lambda root: [(0.1, 0, 1), (0.1, 1, -1), (0.3, 2, 1), (0.2, 1, 1)],
        verdict=lambda root: verdict,
    )
    search._corner = lambda root, k, side: "" if (k, side) == (1, 1) else "b"
    search._dips = lambda root, flights: [(k, dip) for k, dip in enumerate(dips)
                                          if list(flights) == [0, 1, 2]]  # fmt: skip
    return list(search._causes(one, beyond and one))


def test_what_may_have_ended_a_curve_is_tried_from_the_likeliest_on():
    """The furthest beyond a corner first, of impacts other than the curve's; then what is slow."""
    slow, cusp = Condition(What.FADE, 1), Condition(What.CUSP)
    dips = [Condition(What.GRAZE, k, angle=0.9 + 0.5 * k) for k in range(5)]
    assert causes_of(FLIP) == [slow]
    assert causes_of(FOLD) == [slow, cusp]
    assert causes_of(FOLD, dips=dips) == [slow, cusp, *dips[:3]]
    own = Condition(What.GRAZE, 1, angle=1.4 + 0.29)
    assert causes_of(own, dips=dips) == [slow, FOLD, FLIP, dips[0], dips[2]]
    for away in (Condition(What.GRAZE, 1, angle=1.4 + 0.31), Condition(What.GRAZE, 2, angle=1.4)):
        assert causes_of(away, dips=dips) == [slow, FOLD, FLIP, *dips[:3]]
    at_corners = [Condition(What.CORNER, 2, 1), Condition(What.CORNER, 1, -1)]
    assert causes_of(FLIP, beyond=True) == [*at_corners, slow]
    early = causes_of(FLIP, True, (Verdict.EARLY, 2, 1.75))
    touches = Condition(What.GRAZE, 2, angle=(1.75 - 2.0) % (2.0 * pi))
    assert early == [*at_corners, touches, slow]


@pytest.mark.parametrize(
    ("given", "condition", "solution", "is_near", "asked"),
    [
        (None, CORNER, "u", True, [FOLD, CORNER]),
        (FADE, CORNER, "u", True, [FADE, CORNER]),
        (FADE, FOLD, "u", True, [FADE, FOLD]),
        (None, FOLD, "u", True, None),  # a condition does not meet itself
        (FADE, FADE, "u", True, None),
        (None, CORNER, None, True, []),
        (None, CORNER, "u", False, []),
        (None, CORNER, ZeroDivisionError, True, []),
    ],
)
def test_what_is_solved_from_a_guess_is_a_point_where_it_is_near(
    monkeypatch, given, condition, solution, is_near, asked
):
    guess, made = root([1.0, 2.0, 700.0]), []

    class Made:
        def __init__(self, *of):
            made.append(of)

        def start(self, *of):
            return of

        def solve(self, start):
            assert start == (guess, "values")
            if solution is ZeroDivisionError:
                raise solution
            return solution

    monkeypatch.setattr(codim2, "Meeting", Made)
    search = Search(FOLD)
    near = []
    search._near = lambda meeting, *of: near.append(of) or is_near
    search._point = lambda meeting, u: (made[-1][3], u)
    found = list(_CurveSearch._solved(search, guess, "values", "room", condition, given))
    assert found == ([(asked, "u")] if asked else [])
    assert made == ([] if asked is None else [
        (search.system, PLANE, guess, [given or FOLD, condition])])  # fmt: skip
    assert near == [("u", guess, "values", "room")] * (len(made) and solution == "u")


POINTS = [
    ((FOLD, GRAZE), "fold-grazing"), ((FOLD, FADE), "fold-grazing"),
    ((FLIP, GRAZE), "period-doubling-grazing"), ((FADE, FLIP), "period-doubling-grazing"),
    ((CORNER, FOLD), "corner-impact-fold"), ((FLIP, CORNER), "corner-impact-period-doubling"),
    ((CORNER, Condition(What.CORNER, 1, -1)), "double-corner-impact"),
    ((CORNER, GRAZE), "corner-impact-grazing"),
    ((CORNER, Condition(What.FADE, 1)), "corner-impact-grazing"),
    ((FADE, CORNER), "corner-grazing"), ((CORNER, FADE), "corner-grazing"),
    ((GRAZE, Condition(What.GRAZE, 1)), "double-grazing"),
    ((FADE, Condition(What.FADE, 1)), "double-grazing"), ((GRAZE, FADE), "double-grazing"),
    ((GRAZE, Condition(What.GRAZE_AT_CORNER, 0, 1)), "corner-grazing"),
    ((FOLD, Condition(What.CUSP)), "cusp"),
]  # fmt: skip


@pytest.mark.parametrize(("conditions", "kind"), POINTS)
def test_a_point_is_of_the_kind_of_its_two_conditions(monkeypatch, conditions, kind):
    """An impact that fades at a corner grazes it; where another one is at the corner, both meet."""
    monkeypatch.setattr(codim2, "from_root", lambda system, root: f"orbit of {root}")
    meeting = Stub(
        conditions=conditions, root_at=lambda u: f"root at {u}", values=lambda u: (700.0, 0.8),
        bracketed=lambda u: ((1e-9, 2e-9), 0.5, Bracket.UNRESOLVED),
    )  # fmt: skip
    search = Search(conditions[0])
    search._corner = lambda root, k, side: f"{k} {side} of {root}"
    found = search._point(meeting, "u")
    at_corners = [c for c in conditions if c.test == What.CORNER]
    assert found == codim2.CodimTwo(
        codim2.PointKind(kind), 700.0, 0.8, (1e-9, 2e-9), -0.5, 0.5, Bracket.UNRESOLVED,
        "orbit of root at u", conditions,
        tuple(f"{c.impact} {c.side} of root at u" for c in at_corners), (7,), (), (meeting, "u"),
    )  # fmt: skip


@pytest.mark.parametrize(("off", "near"), [
    ({}, True), ({"first": 4.0}, True), ({"first": -4.01}, False), ({"second": 0.1}, True),
    ({"second": -0.101}, False), ({"phase": 0.29}, True), ({"phase": -0.31}, False),
    ({"first": 3.0, "low": 701.0}, True), ({"first": 0.0, "low": 701.0}, False),
    ({"second": 0.05, "high": 0.849}, False), ({"second": 0.05, "high": 0.851}, True),
    ({"second": 0.0, "high": 0.8}, True), ({"first": 0.0, "low": 700.0}, True),
])  # fmt: skip
def test_a_solution_is_the_one_looked_for_where_it_is_near_and_in_the_plane(off, near):
    search = Search(FOLD)
    low, high = off.get("low", 600.0), off.get("high", 0.95)
    search.plane = Stub(ranges=((low, 800.0), (0.5, high)))
    values = 700.0 + off.get("first", 0.0), 0.8 + off.get("second", 0.0)
    u = [arb(x) for x in (1.0, 2.0, 1.5 + off.get("phase", 0.0), 9.0, *values)]
    guess = root([1.0, 2.0, 1.5, 2.5, 700.0], (0, 0, 1, 0), (-1.0, -2.0))
    meeting = Stub(n=2, values=lambda u: tuple(map(float, u[4:6])))
    assert search._near(meeting, u, guess, (700.0, 0.8), (4.0, 0.1)) is near


def test_the_points_of_a_curve_are_those_of_its_first_end_between_and_of_its_last(monkeypatch):
    """What fails at one place costs the rest of that place alone."""

    @dataclass(frozen=True)
    class Point:
        name: str
        ends: tuple = ()

    class Found:
        def __init__(self, system, curve, number, plane):
            assert (system, number, plane) == ("system", 7, "plane")

        def at_end(self, end):
            yield Point(f"end {end}")
            raise NotProvedError(codim2.ProofStep.MODEL)

        def between(self, before, behind):
            yield Point(f"{before}{behind}")
            if before == "a":
                raise UndecidedError
            yield Point(f"{before}{behind} too")

    monkeypatch.setattr(codim2, "_CurveSearch", Found)
    curve = Stub(located=True, points=("a", "b", "c"))
    assert list(_on_curve("system", curve, 7, "plane")) == [
        Point("end 0", ((7, 0),)), Point("ab"), Point("bc"), Point("bc too"),
        Point("end 1", ((7, 1),)),
    ]  # fmt: skip
    for nothing in (Stub(located=None, points=("a",)), Stub(located=True, points=())):
        assert list(_on_curve("system", nothing, 7, "plane")) == []


@pytest.mark.parametrize("fault", [ZeroDivisionError, ValueError, UndecidedError, KeyError])
def test_points_are_solved_up_to_one_that_cannot_be(fault):
    def points():
        yield 1
        raise fault

    if fault is KeyError:  # a fault of the program
        with pytest.raises(KeyError):
            _solvable(points)
    else:
        assert _solvable(points) == [1]


def test_the_condition_of_a_curve_is_that_of_its_event_at_a_root(monkeypatch):
    one = root([1.0, 2.0, 3.0, 2.5, 700.0], (0, 0, 1, 0), (-1.0, -2.0))
    system = Stub(cam=Stub(stretches=[Stub(start=0.0, end=2.0), Stub(start=2.0, end=4.1)]))

    def condition(theta=3.0, dips=(), **located):
        event = Stub(**{"fading": None, "impact": 1, **located})
        search = _CurveSearch(system, Stub(located=event), 7, PLANE)
        monkeypatch.setattr(search, "_dips", lambda root, flights: dips if flights == [1] else None)
        return search.own(codim2.replace(one, x=[1.0, 2.0, theta, 2.5, 700.0]))

    for k in (0, 1):
        assert condition(kind=Kind.GRAZING, fading=k) == Condition(What.FADE, k)
    assert condition(kind=Kind.FOLD) == FOLD
    assert condition(kind=Kind.PERIOD_DOUBLING) == FLIP
    for theta, side in ((3.06, 1), (3.04, -1), (4.2, 1), (1.9, -1)):
        assert condition(theta, kind=Kind.CORNER_IMPACT) == Condition(What.CORNER, 1, side)
    dips = [(-3.0, FOLD), (-0.1, GRAZE), (0.2, FLIP)]
    assert condition(kind=Kind.GRAZING, dips=dips) == GRAZE
    with pytest.raises(NotProvedError):
        condition(kind=Kind.GRAZING)


def test_the_four_lowest_samples_of_flights_are_refined(monkeypatch):
    """Of 3/4 of a turn, 135 intervals and six dips; of 1/40, at least 8 intervals, three flights.

    These dip at their second sample, at their last but one, and not at all: the gap only rises.
    """
    spans, asked, work = [1.5 * pi, 0.05 * pi, 0.05 * pi, 0.05 * pi], [], []
    centres, depths = [0.3, 1.0, 1.7, 2.4, 3.1, 3.8], [0.5, 0.1, 0.4, 0.25, 0.6, 0.3]
    step = 0.05 * pi / 8

    def gap(machine, x, k, place):
        assert place == (k, 10 + k)

        def at(s):
            s = float(s)
            asked.append((k, s))
            least = (depth + 9.0 * (s - c) ** 2 for c, depth in zip(centres, depths, strict=True))
            return [
                arb([min(least), (s - 2.1 * step) ** 2, 0.2 + (s - 5.9 * step) ** 2, s - 1.0][k])
            ]

        return at

    shooting = Stub(
        rpm=700.0, machine=lambda rpm: None, places=[Stub(turn=10 + k) for k in range(4)],
        place=lambda theta, turn: (int(float(theta) / 10.0), turn), gap=gap,
        span=lambda x, k: arb(spans[k]),
    )  # fmt: skip
    monkeypatch.setattr(codim2, "exact_shooting", lambda system, root: shooting)
    monkeypatch.setattr(codim2, "spend", work.append)
    phases = [x for k in range(4) for x in (1.0 + 10.0 * k, 2.0)]
    one = root([*phases, 700.0], (0, 0) * 4, (-1.0,) * 4)
    dips = _CurveSearch(chapter_system(), Stub(located=True), 7, PLANE)._dips(one, range(4))
    assert work == [100 * 135, *[100 * 8] * 3]
    first = [s for k, s in asked if k == 0][:134]
    assert first == pytest.approx([1.5 * pi / 135 * j for j in range(1, 135)])
    assert [s for k, s in asked if k == 3] == pytest.approx([step * j for j in range(1, 8)])
    wanted = [(0.0, 1, 2.1 * step), (0.1, 0, 1.0), (0.2, 2, 5.9 * step), (0.25, 0, 2.4)]
    for (least, condition), (depth, flight, angle) in zip(dips, wanted, strict=True):
        assert least == pytest.approx(depth, abs=1e-4)
        assert (condition.test, condition.impact) == (What.GRAZE, flight)
        assert condition.angle == pytest.approx(angle, abs=1e-3)


class Written(Meeting):
    """Equations that are written here, of the two parameters alone."""

    def __init__(self, equations, in_doubles=()):
        self.n, self.in_doubles, self.written = 0, list(in_doubles), equations
        self.plane = PLANE
        self.evaluated = 0

    def equations(self, u):
        self.evaluated += 1
        return self.written(*u)


def test_a_difference_is_wide_by_a_number_that_is_a_double():
    """Of two impacts, both parameters, and the angle of a graze; the ranges are 200 and 0.4."""
    narrow = arb(10) ** -25
    for in_doubles, wide in (((), {}), (("restitution",), {5: 0.4}), (("rpm",), {4: 200.0}),
                             (("rpm", "restitution"), {4: 200.0, 5: 0.4})):  # fmt: skip
        meeting = Written(None, in_doubles)
        meeting.n = 2
        widths = [meeting._width(j) for j in range(7)]
        for j, width in enumerate(widths):
            wanted = 1e-6 * wide[j] if j in wide else float(narrow)
            assert float(width) == pytest.approx(wanted, rel=1e-12)


def test_newtons_method_goes_on_to_thirty_digits_and_refuses_a_long_first_step(monkeypatch):
    """The work of a step is that of as many equations in balls as there are impacts."""
    work = []
    monkeypatch.setattr(codim2, "spend", work.append)
    with precision(80):
        roots = Written(lambda x, y: [x * x - 2, x * y - 6])
        roots.n = 3
        x, y = roots.solve([arb(1.4), arb(4.2)])
        assert 4 <= len(work) <= 7
        assert set(work) == {3 * codim2.BOXED}
        assert abs(x - arb(2).sqrt()) < arb(10) ** -40
        assert abs(y - 3 * arb(2).sqrt()) < arb(10) ** -40
        moved = roots.solve([arb(1.4), arb(4.2)], arb("0.1"))
        assert abs(moved[1] - arb("6.1") / arb(2).sqrt()) < arb(10) ** -40
        # steps are relative where an unknown is more than 1
        for start, found in ((0.69, True), (0.71, False), (-0.69, True), (-0.71, False)):
            line = Written(lambda x, y: [x, y - 500])
            assert (line.solve([arb(start), arb(500)]) is not None) is found
        for start, found in ((400.0, True), (294.5, True), (293.8, False)):
            line = Written(lambda x, y: [x, y - 500])
            assert (line.solve([arb(0), arb(start)]) is not None) is found
        slow = Written(lambda x, y: [x * x, y])  # each step halves it: no 30 digits within 20
        assert slow.solve([arb(1), arb(0)]) is None
        assert slow.evaluated == 20 * 4


def test_a_zero_is_enclosed_where_exactly_one_is_shown_to_be_near():
    with precision(80):
        roots = Written(lambda x, y: [x * x - 2, x * y - 6])
        near = roots.solve([arb(1.4), arb(4.2)])
        x, y = roots.enclosed(near)
        assert 0 < x.rad() < arb(10) ** -60
        assert 0 < y.rad() < arb(10) ** -60
        assert x.overlaps(arb(2).sqrt())
        assert y.overlaps(3 * arb(2).sqrt())
        off = arb(10) ** -50  # a start beside it: the box grows until it holds the zero
        x, y = roots.enclosed([near[0] + off, near[1] - off])
        assert x.overlaps(arb(2).sqrt())
        assert y.overlaps(3 * arb(2).sqrt())
        assert max(x.rad(), y.rad()) < 10 * off
        for twice in (lambda x, y: [x * x, y], lambda x, y: [x - y, 2 * (x - y)],
                      lambda x, y: [x * x + arb(10) ** -30, y]):  # fmt: skip
            with pytest.raises(NotProvedError) as refused:
                Written(twice).enclosed([arb(0), arb(0)])
            assert refused.value.step == codim2.ProofStep.SINGULAR
        slopes = roots.derivatives([arb(3), arb(5)])
        assert [float(slope) for slope in slopes.entries()] == [6.0, 0.0, 5.0, 3.0]


@pytest.mark.parametrize(
    ("tests", "corners", "touch", "fades"),
    [
        ((What.CORNER, What.CORNER), [1, 2], None, None),
        ((What.FADE, What.CORNER), [2], None, 1),
        ((What.GRAZE, What.CORNER), [2], (1, 0.3), None),
        ((What.GRAZE, What.FOLD), [], (1, 0.3), None),
        ((What.GRAZE, What.GRAZE), None, None, None),
        ((What.FADE, What.FADE), None, None, None),
        ((What.FADE, What.GRAZE), None, None, None),
    ],
)
def test_a_motion_is_shown_but_for_one_touch_or_one_impact_that_fades(tests, corners, touch, fades):
    asked = []
    meeting = Written(None)
    meeting.n = 2
    meeting.conditions = [Condition(test, k) for k, test in enumerate(tests, 1)]
    meeting.grazes = [codim2.Grazed(c, None) for c in meeting.conditions if c.test == What.GRAZE]
    meeting.shooting = lambda parameters: (
        asked.append(parameters) or Stub(rpm="speed", admissible=lambda *of: asked.append(of))
    )
    hull = [1.0, 2.0, 3.0, 4.0, 700.0, 0.8, 0.3, 0.4][: 6 + len(meeting.grazes)]
    if corners is None:
        with pytest.raises(NotProvedError) as refused:
            meeting.admit(hull)
        assert refused.value.step == codim2.ProofStep.MODEL
        return
    meeting.admit(hull)
    parameters, (whole, at_corners, touched, fading) = asked
    assert parameters == [700.0, 0.8]
    assert whole == [1.0, 2.0, 3.0, 4.0, "speed"]
    assert (at_corners, fading) == (corners, fades)
    assert (touched and (touched.flight, touched.angle)) == touch


@pytest.mark.parametrize(
    ("test", "kind", "corner", "more"),
    [
        (What.FOLD, Kind.FOLD, "", {}),
        (What.FLIP, Kind.PERIOD_DOUBLING, "", {}),
        (What.CORNER, Kind.CORNER_IMPACT, "b", {}),
        (What.GRAZE, Kind.GRAZING, "", {"phase": 4.0 + 3.0 - 2.0 * pi}),
        (What.FADE, Kind.GRAZING, "", {"phase": 4.0, "fading": 1}),
        (What.CUSP, None, "", {}),
        (What.GRAZE_AT_CORNER, None, "", {}),
    ],
)
def test_the_event_of_a_condition_is_one_whose_curve_can_be_followed(test, kind, corner, more):
    """Corners are named in the order of those conditions that are at one."""
    one = root([1.0, 2.0, 4.0, 2.5, 700.0], (0, 0, 1, 0), (-1.0, -2.0))
    at_corner, mine = Condition(What.CORNER, 0, 1), Condition(test, 1, -1, 3.0)
    of_point = {"orbit": Stub(root=one), "errors": (1e-9, 3e-9), "status": Bracket.UNRESOLVED}
    wanted = (None, "") if kind is None else (
        Located(kind, one, 0.0, 3e-9, Bracket.UNRESOLVED, **{"impact": 1, "side": -1, **more}),
        corner,
    )  # fmt: skip
    for conditions, k, corners in (
        ((at_corner, mine), 1, ("a", corner)), ((mine, at_corner), 0, (corner, "a"))
    ):  # fmt: skip
        there = Stub(conditions=conditions, corners=tuple(filter(None, corners)), solution=1,
                     **of_point)  # fmt: skip
        located, name = codim2.event_at(there, k)
        assert (located, name) == wanted
        for nothing in ({"solution": None}, {"orbit": Stub(root=None)}):
            assert codim2.event_at(Stub(**{**vars(there), **nothing}), k) == (None, "")


@pytest.mark.parametrize(
    ("fault", "step"),
    [
        (None, None),
        (NotProvedError(codim2.ProofStep.SINGULAR), codim2.ProofStep.SINGULAR),
        (codim2.BudgetSpentError(), codim2.ProofStep.WORK_BUDGET),
    ],
)
def test_a_proof_is_of_both_parameters_or_names_the_step_that_failed(monkeypatch, fault, step):
    """The ends are doubles below and above the enclosures; a cusp and a double are not enclosed."""
    work = []
    monkeypatch.setattr(codim2, "spend", work.append)

    def admit(hull):
        assert hull[:1] == ["first unknown"]
        if fault is not None:
            raise fault

    hull = ["first unknown", 0, 0, 0, arb(700, 2.0**-30), arb(0.75, 2.0**-40), arb(9)]
    meeting = Stub(n=2, in_doubles=[], enclosed=lambda u: hull * (u == "u"), admit=admit)
    point = Stub(solution=(meeting, "u"), conditions=(FOLD, CORNER))
    proof = codim2.prove(point)
    assert (proof.step, proof.proved) == (step, fault is None)
    assert work == [2 * codim2.BOXED]
    if fault is None:
        for (low, high), middle, radius in (
            (proof.first, 700.0, 2.0**-30), (proof.second, 0.75, 2.0**-40)
        ):  # fmt: skip
            assert middle - 1.001 * radius < low < middle - radius
            assert middle + radius < high < middle + 1.001 * radius
    else:
        assert (proof.first, proof.second) == (None, None)
    for change, step in (
        ({"solution": None}, codim2.ProofStep.MODEL),
        ({"conditions": (FOLD, Condition(What.CUSP))}, codim2.ProofStep.MODEL),
        ({"solution": (Stub(in_doubles=["cam.lash"]), "u")}, codim2.ProofStep.CAM),
    ):
        assert codim2.prove(Stub(**{**vars(point), **change})) == codim2.PointProof(step)


@dataclass(frozen=True)
class Orbit:
    """What of a root is another one at a point; its determinant is 1/4."""

    x: tuple = ()
    machine: tuple = (1.0, 2.0, 3.0)
    parameter: int = 2
    rates: tuple = ()
    trace: float = 0.0
    det: float = 0.25


@pytest.mark.parametrize(
    ("tests", "trace"),
    [((What.FOLD, What.FADE), 1.25), ((What.CORNER, What.FLIP), -1.25),
     ((What.CORNER, What.FADE), inf), ((What.CORNER, What.GRAZE), -3.5)],
)  # fmt: skip
def test_the_orbit_of_a_point_has_the_multipliers_of_its_conditions(monkeypatch, tests, trace):
    """Both parameters are numbers 0 and 2 of its machine; the latter is the branch's."""
    meeting = Written(None)
    meeting.n, meeting.root, meeting.system = 2, Orbit(), "system"
    meeting.conditions = [Condition(test) for test in tests]
    places = {"rpm": 0, "restitution": 2}

    def machine_at(system, machine, name, value):
        assert system == "system"
        return tuple(value if k == places[name] else x for k, x in enumerate(machine))

    monkeypatch.setattr(codim2, "machine_at", machine_at)
    flights = [Stub(rate=arb(-1)), Stub(rate=arb(-2))]  # the rate at which a flight ends
    u = [arb(x) for x in (1.0, 2.0, 3.0, 4.0, 700.0, 0.8, 0.3)]
    meeting.shooting = lambda values: Stub(
        rpm=arb(9), machine=lambda rpm: (rpm, values),
        flights=lambda machine, x: flights * (machine == (arb(9), u[4:6]) and x == u[:4]),
        trace_det=lambda z: (arb(-3.5) if z == [*u[:4], arb(9)] else arb(7), None),
    )  # fmt: skip
    found = meeting.root_at(u)
    assert found == Orbit([1.0, 2.0, 3.0, 4.0, 0.8], (700.0, 2.0, 0.8), 2, [-2.0, -1.0], trace)


@pytest.mark.parametrize(
    ("in_doubles", "beside"), [((), 1e-14), (("restitution",), 1e-11)]
)  # fmt: skip
def test_beside_a_point_the_second_function_is_taken_on_the_curve_of_the_first(in_doubles, beside):
    """f1 = y - 0.8 - (x - 700)/100, f2 = 3 (x - 700): x changes by 1/3, relative 1/2100."""
    with precision(80):
        curve = Written(lambda x, y: [y - arb("0.8") - (x - 700) / 100, 3 * (x - 700)], in_doubles)
        u = [arb(700), arb("0.8")]
        (first, second), value, status = curve.bracketed(u)
        changes = max(1.0 / 3.0 / 700.0, 1.0 / 300.0)
        assert value == pytest.approx(beside / changes)
        assert status == Bracket.OK
        assert first == pytest.approx(max(2.0 * 2.0**-43, value / 3.0), rel=1e-6)
        assert second == pytest.approx(max(2.0 * 2.0**-53, value / 300.0), rel=1e-6)
        # a function with no such value on the one side
        half = Written(lambda x, y: [y, x if x < 10.0**-17 else x * x - 1])
        assert half.bracketed([arb(0), arb(0)])[2] == Bracket.UNRESOLVED
