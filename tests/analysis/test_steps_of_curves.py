"""Steps of the curves in two numbers, and of Newton's method over a number of the cam, one by one.

What is solved by other files of the package is stood in for by equations with known solutions.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp, pi, sqrt
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from flint import arb, arb_mat

from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits import atlas, codim2, curves, family_shooting, shooter
from camcli.analysis.orbits.curves import CurvePoint, Plane, _Tracer
from camcli.analysis.orbits.family_shooting import FamilyMachine, FamilyShooting, Sides, Solved
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.errors import NoMachineError
from camcli.exact.shooting import ImpactSlopes
from camcli.kernel.bordered import BLOCK, RESIDUAL, RIGHT, tables_for
from camcli.system import CONSTANTS

TURN = 2.0 * pi
PLANE = Plane(("rpm", "restitution"), ((600.0, 800.0), (0.5, 0.9)), 50)
NAMES = "rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution"


def root_of(impacts, value=700.0, restitution=0.75, parameter=0, **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    given = {
        "turns": 2, "machine": (value, 1.0, 2.0, 3.0, 4.0, 5.0, restitution),
        "rates": [-2.0 * v for _, v, _, _ in impacts],
        "tangent": [0.0] * len(x) + [1.0], "trace": 0.5, "step": 0.0, "steps": 2,
    }  # fmt: skip
    return Root([*x, value], whole, parameter=parameter, **{**given, **more})


@pytest.fixture(autouse=True)
def places(monkeypatch):
    """Both numbers stand in the machine where `NAMES` has them."""
    monkeypatch.setattr(curves, "place_of", lambda system, name: NAMES.index(name))


def event(kind=Kind.FOLD, root=None, **more) -> Located:
    return Located(kind, root, 0.0, 1e-9, Bracket.OK, **more)


def tracer(kind=Kind.FOLD, **more) -> _Tracer:
    return _Tracer("system", event(kind, **more), PLANE)


# -- an event solved for one number


def test_a_direction_has_the_length_one_or_none():
    assert curves._unit([3.0, 0.0, -4.0]) == [0.6, 0.0, -0.8]
    assert curves._unit([1.0, 2.0, 3.0, 4.0]) == pytest.approx(
        [k / sqrt(30.0) for k in range(1, 5)]
    )
    assert curves._unit([0.0, 0.0]) is None


@pytest.mark.parametrize("found", [True, False])
def test_a_fold_is_where_the_number_turns_round_across_the_branch_without_it(found):
    """x = (1 + 0.6 s, 2 - 0.8 s, 700 + 3 (s - 0.25)^2) at s from the root beside it."""
    beside = root_of([(1.0, 2.0, 3, 0)], 700.1875, tangent=[1.5, -2.0, -3.75])
    asked = []

    def correct(guess, whole, turns, row, origin, right):
        asked.append((guess, whole, turns, row, origin))
        s = right
        if not found and s > 0.0:
            return None
        x = [1.0 + 0.6 * s, 2.0 - 0.8 * s, 700.0 + 3.0 * (s - 0.25) ** 2]
        return replace(beside, x=x, tangent=[0.6, -0.8, 6.0 * (s - 0.25)])

    root = curves._fold(Stub(correct=correct), beside)
    assert asked[0] == (beside.x, (3, 0), 2, [0.6, -0.8, 0.0], beside.x)
    assert all(one == asked[0] for one in asked)
    if not found:
        assert root is None
        return
    assert root.x == pytest.approx([1.15, 1.8, 700.0], abs=1e-12)
    assert curves._fold(Stub(correct=correct), replace(beside, tangent=[0.0, 0.0, 2.0])) is None


@pytest.mark.parametrize("fading", [None, 0, 1])
@pytest.mark.parametrize("moved", [True, False])
def test_a_graze_is_where_the_gap_or_the_rate_of_an_impact_is_zero(monkeypatch, moved, fading):
    """Along the tangent of the root at the number given; where that is none, of the one beside."""
    beside = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)], 700.0, tangent=[1.0, 2.0, 2.0, 0.0, 4.0])
    there = replace(beside, x=[1.5, 2.5, 4.5, 5.5, 700.0], tangent=[4.0, 2.0, 2.0, 1.0, 0.0])
    here = there if moved else beside
    asked = []

    def rates_at(right):
        return [-9.0, 0.125 - right] if fading != 0 else [0.125 - right, -9.0]

    def correct(guess, whole, turns, row, origin, right):
        asked.append((guess, whole, turns, tuple(row), origin))
        return replace(here, x=[*here.x[:-1], 700.0 + right], rates=rates_at(right))

    def touch_near(of, root, graze):
        assert graze.impact == 0
        return 3.0 * (root.value - 700.125), 0.5

    monkeypatch.setattr(curves, "touch_near", touch_near)
    solver = Stub(correct=correct, moved=lambda root, value: there if moved else None)
    graze = event(Kind.GRAZING, impact=0, phase=2.0, fading=fading)
    root = curves._graze(solver, beside, graze)
    row = (0.8, 0.4, 0.4, 0.2, 0.0) if moved else (0.2, 0.4, 0.4, 0.0, 0.8)
    assert asked[0][:3] == (here.x, here.whole, 2)
    assert asked[0][3] == pytest.approx(row)
    assert asked[0][4] == here.x
    assert root.value == pytest.approx(700.125, abs=1e-12)


def test_an_impact_that_has_faded_is_taken_where_nothing_is_solved_behind_it():
    """Its rate is 1e-13 of the largest one at the second place, and no root is solved after it."""
    beside = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)], tangent=[3.0, 0.0, 0.0, 4.0, 0.0])
    for rate, is_taken in ((-0.9e-12, True), (0.9e-12, True), (-1.1e-12, False)):
        answers = [[10.0, -1.0], [10.0, rate], None]
        for rates in (answers, [rates and rates[::-1] for rates in answers]):
            waiting = [rates and replace(beside, rates=rates) for rates in rates]
            solver = Stub(correct=lambda *of, left=waiting: left.pop(0), moved=lambda *of: None)
            expected = waiting[1] if is_taken else None
            graze = event(Kind.GRAZING, fading=rates[0].index(-1.0))
            assert curves._graze(solver, beside, graze) == expected


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize(
    "kind", [Kind.CORNER_IMPACT, Kind.PERIOD_DOUBLING, Kind.FOLD, Kind.GRAZING]
)
def test_an_event_is_solved_for_one_number_with_the_other_one_given(monkeypatch, kind, free):
    beside = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)])
    made = []

    def machine_at(system, machine, name, value):
        assert (system, machine) == ("system", beside.machine)
        return name, value

    class Solver:
        def __init__(self, system, rpm, name):
            made.append((system, rpm, name))
            self.parameter = 6 if free else 0

        def at_corner(self, root, impact, side):
            return "corner", root, impact, side

    monkeypatch.setattr(curves, "machine_at", machine_at)
    monkeypatch.setattr(curves, "with_machine", lambda system, machine: (machine, 712.0))
    monkeypatch.setattr(curves, "Shooter", Solver)
    monkeypatch.setattr(curves, "doubling_near", lambda of, root, width: ("flip", root, width))
    monkeypatch.setattr(curves, "_fold", lambda of, root: ("fold", root))
    monkeypatch.setattr(curves, "_graze", lambda of, root, graze: ("graze", root, graze))
    one = tracer(kind, impact=1, side=-1)
    guess = [1.5, 2.5, 4.5, 5.5, 0.8]
    wanted = replace(beside, x=guess, parameter=6 if free else 0)
    assert (
        one.solve(beside, guess, free, 0.625)
        == {
            Kind.CORNER_IMPACT: ("corner", wanted, 1, -1),
            Kind.PERIOD_DOUBLING: ("flip", wanted, 1e-6),
            Kind.FOLD: ("fold", wanted),
            Kind.GRAZING: ("graze", wanted, one.located),
        }[kind]
    )
    assert made == [((PLANE.names[1 - free], 0.625), 712.0, PLANE.names[free])]
    assert one.values(beside) == (700.0, 0.75)


@pytest.mark.parametrize("parameter", [0, 6])
def test_a_point_of_a_curve_has_the_crossing_of_its_own_corner(monkeypatch, parameter):
    root = root_of([(1.0, 2.0, 3, 0)], parameter=parameter)
    monkeypatch.setattr(curves, "from_root", lambda system, root: ("orbit", system, root))
    monkeypatch.setattr(_Tracer, "shooter", lambda self, *of: of)
    monkeypatch.setattr(curves, "cross", lambda of, at: (of, at.root, at.impact))
    point = tracer(Kind.CORNER_IMPACT, impact=2).point(root)
    free, given = (0, 0.75) if parameter == 0 else (1, 700.0)
    assert point == CurvePoint(
        700.0, 0.75, ("orbit", "system", root), ((root, free, given), root, 2)
    )
    assert tracer(Kind.FOLD).point(root).crossing is None
    for error in (BudgetSpentError, NoMachineError("none")):

        def refused(of, at, error=error):
            raise error

        monkeypatch.setattr(curves, "cross", refused)
        assert tracer(Kind.CORNER_IMPACT, impact=2).point(root) == replace(point, crossing=None)


# -- the next point of a curve


def judge(beyond=(), admitted=(), fails_to_move=(), scale=0.5):
    """What a shooter says of roots: which impacts are beyond, which values are motions."""
    return Stub(
        beyond=lambda root: [(0.1, *pair) for pair in beyond], scale=scale,
        admits=lambda root: root.value in admitted,
        moved=lambda root, value: None if value in fails_to_move else replace(
            root, x=[*root.x[:-1], value]
        ),
    )  # fmt: skip


def test_why_a_root_is_no_point_of_a_curve(monkeypatch):
    root = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)])
    collapsed = []
    monkeypatch.setattr(curves, "collapses", lambda of, one: one in collapsed)
    fold, corner = tracer(Kind.FOLD), tracer(Kind.CORNER_IMPACT, impact=1, side=1)
    graze = tracer(Kind.GRAZING, impact=1)
    fades = tracer(Kind.GRAZING, impact=1, fading=1)
    assert fold._refusal(root, judge(admitted=[700.0])) is None
    assert fold._refusal(root, judge()) == Kind.NO_MOTION
    both = judge([(1, 1)], [700.0])
    assert fold._refusal(root, both) == Kind.ANOTHER_CORNER
    assert corner._refusal(root, both) is None
    assert graze._refusal(root, both) == Kind.ANOTHER_CORNER
    assert corner._refusal(root, judge([(0, -1)], [700.0])) == Kind.ANOTHER_CORNER
    assert corner._others_beyond(root, judge([(0, -1), (1, 1), (2, 1)])) == [(0, -1), (2, 1)]
    # a motion on either side of a graze, near to it, is enough
    size = 700.5
    first_fades = tracer(Kind.GRAZING, impact=0, fading=0)
    far = (1e-7, 1e-5)
    for one, widths in ((graze, (1e-9, 1e-7)), (fades, far), (first_fades, far)):
        for width in widths:
            for side in (-1.0, 1.0):
                near = 700.0 + side * width * size
                assert one._refusal(root, judge(admitted=[near])) is None
                assert fold._refusal(root, judge(admitted=[near])) == Kind.NO_MOTION
                found = one._refusal(root, judge(admitted=[near], fails_to_move=[near]))
                assert found == Kind.NO_MOTION
    assert graze._refusal(root, judge(admitted=[700.0 + 1e-5 * size])) == Kind.NO_MOTION
    collapsed.append(root)
    assert fold._refusal(root, judge(admitted=[700.0])) == Kind.SHORTER_ORBIT
    assert graze._refusal(root, judge()) == Kind.SHORTER_ORBIT
    assert fold._refusal(root, judge([(0, 1)])) == Kind.ANOTHER_CORNER


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize("case", ["solved", "lost", "refused", "beyond", "elsewhere"])
def test_where_a_curve_leaves_its_range_it_is_solved_at_the_bound(monkeypatch, free, case):
    """The guess is a share of a quarter on the way from the last point to the one beyond."""
    given = 1 - free
    last = root_of([(1.0, 2.0, 3, 0)], 780.0, 0.8)
    after = root_of([(1.4, 2.8, 3 if case != "elsewhere" else 4, 0)], 860.0, 1.2)
    bound = (800.0, 0.9)[given]
    outside = {"beyond": (500.0, 0.95)}.get(case, (790.0, 0.85))
    answer = root_of([(1.1, 2.2, 3, 0)], *[outside, (800.0, 0.9)][0])
    asked = []

    def solve(self, *of):
        asked.append(of)
        return None if case == "lost" else answer

    monkeypatch.setattr(_Tracer, "solve", solve)
    monkeypatch.setattr(_Tracer, "shooter", lambda self, *of: of)

    def refusal(self, root, of):
        assert (root, of) == (answer, (answer, free, bound))
        return Kind.NO_MOTION if case == "refused" else None

    monkeypatch.setattr(_Tracer, "_refusal", refusal)
    found = tracer()._at_bound(last, after, free, bound)
    assert found == (answer if case == "solved" else None)
    if case == "elsewhere":
        assert asked == []
        return
    ((root, guess, of_free, value),) = asked
    assert (root, of_free, value) == (after, free, bound)
    assert guess == pytest.approx([1.1, 2.2, (800.0, 0.9)[free]])


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("corner", [False, True])
def test_behind_a_corner_another_impact_is_in_the_next_stretch(monkeypatch, side, corner):
    """The last of three stretches is followed by the first one, a turn later, and the other way."""
    stretch, behind = (2, 0) if side > 0 else (0, 2)
    phase = TURN + 0.01 if side > 0 else -0.01
    root = root_of([(1.0, 2.0, 1, 0), (phase, 5.0, stretch, 1)], 700.0, 0.75)
    boundary = 0  # both ways: the stretch that begins there
    corners = [Stub(stretch=boundary if corner else 1)]
    monkeypatch.setattr(curves, "corner_list", lambda cam: corners)
    cam = Stub(stretches=[None] * 3)
    beyond = [(1, side)]
    solver = Stub(
        beyond=lambda one: [(0.1, *pair) for pair in beyond], system_of=lambda one: Stub(cam=cam)
    )
    asked = []

    def solve(self, beside, x, free, value):
        asked.append((beside.whole, x, free, value))
        return None if value == 1.0 else replace(beside, x=[*x[:-1], value])

    refused = {2.0}
    monkeypatch.setattr(_Tracer, "solve", solve)
    monkeypatch.setattr(_Tracer, "shooter", lambda self, *of: solver)
    monkeypatch.setattr(
        _Tracer, "_refusal", lambda self, one, of: "none" if one.value in refused else None
    )
    for kind, share, goes_on in (
        (Kind.GRAZING, 0.019, True),
        (Kind.GRAZING, 0.02, not corner),
        (Kind.CORNER_IMPACT, 0.019, True),
        (Kind.FOLD, 0.019, not corner),
        (Kind.PERIOD_DOUBLING, 1.0, not corner),
    ):
        asked.clear()
        one = tracer(kind, impact=0)
        found = one._behind_corner(root, 1, (1.0, 2.0, 3.0, 4.0), share)
        assert (found is not None) is goes_on
        if goes_on:
            x = [1.0, 2.0, 0.01 if side > 0 else TURN - 0.01, 5.0, 0.75]
            assert [(*of[:1], *of[2:]) for of in asked] == [
                ((1, 0, behind, 1 + side), 1, value) for value in (1.0, 2.0, 3.0)
            ]
            assert all(of[1] == pytest.approx(x) for of in asked)
            assert found.value == 3.0
    assert tracer(Kind.GRAZING, impact=0)._behind_corner(root, 1, (1.0, 2.0), 0.01) is None
    for others in ([], [(0, 1), (1, 1)]):
        beyond[:] = others
        assert tracer(Kind.FOLD)._behind_corner(root, 1, (3.0,), 0.01) is None


@pytest.mark.parametrize("given", [0, 1])
@pytest.mark.parametrize("share", [0.019, 0.02])
@pytest.mark.parametrize("case", ["a point", "lost", "a corner", "behind", "nothing behind"])
def test_a_step_that_an_impact_ends_at_a_corner_goes_on_behind_it(monkeypatch, given, share, case):
    """Near the corner a value a step back is tried as well; way: a tenth of the range."""
    roots = [root_of([(1.0, 2.0, 3, 0)], 650.0, 0.6), root_of([(1.1, 2.0, 3, 0)], 700.0, 0.7)]
    after, other = root_of([(1.2, 2.0, 3, 0)]), root_of([(1.3, 2.0, 4, 0)])
    advance = {
        "a point": curves._Advance(after, None),
        "lost": curves._Advance(None, Kind.ANOTHER_CORNER),
        "a corner": curves._Advance(after, Kind.NO_MOTION),
    }.get(case, curves._Advance(after, Kind.ANOTHER_CORNER))
    target = curves._Target(given, (720.0, 0.74)[given], 0.1, at_end=False)
    asked = []

    def behind(self, root, free, values, of_share):
        asked.append((root, free, of_share, *values))
        return other if case == "behind" else None

    def step(self, *of):
        assert of == (roots, 1 - given, target.value)
        return advance

    monkeypatch.setattr(_Tracer, "_advance", step)
    monkeypatch.setattr(_Tracer, "_behind_corner", behind)
    found = tracer()._next(roots, target, share)
    assert found == (curves._Advance(other, None) if case == "behind" else advance)
    if "behind" not in case:
        assert asked == []
        return
    back = [pytest.approx((680.0, 0.66)[given])] if share < 0.02 else []
    assert asked == [(after, 1 - given, share, target.value, *back)]


# -- a curve as a whole


@pytest.mark.parametrize("parameter", [0, 6])
@pytest.mark.parametrize("case", ["both ways", "closed", "nothing"])
def test_a_curve_is_traced_both_ways_from_its_event(monkeypatch, parameter, case):
    """The event is solved for its own number; towards smaller second numbers first."""
    root = root_of([(1.0, 2.0, 3, 0)], parameter=parameter)
    located = event(Kind.FOLD, root)
    asked = []
    end = Kind.CLOSED if case == "closed" else Kind.NO_MOTION
    down = curves._Side(["d1", "d2"], end, "rpm", "below")
    up = curves._Side(["u1", "u2"], Kind.LOST, "restitution", "above")

    class Tracer:
        def __init__(self, *of):
            assert of == ("system", located, PLANE)

        def values(self, one):
            assert one is root
            return 700.0, 0.75

        def solve(self, *of):
            asked.append(of)
            return None if case == "nothing" else "start"

        def trace(self, start, sign):
            asked.append((start, sign))
            return down if sign < 0.0 else up

        def point(self, one):
            return ("point", one)

    monkeypatch.setattr(curves, "_Tracer", Tracer)
    found = curves.curve("system", located, PLANE, "P(1;1)", "b")
    free, given = (0, 0.75) if parameter == 0 else (1, 700.0)
    assert asked[0] == (root, root.x, free, given)
    assert (found.kind, found.label, found.corner) == (Kind.FOLD, "P(1;1)", "b")
    assert (found.first, found.second, found.located) == ("rpm", "restitution", located)
    if case == "nothing":
        assert (found.points, found.ends) == ((), (Kind.LOST, Kind.LOST))
        return
    assert asked[1:] == [("start", -1.0), ("start", 1.0)][: 1 if case == "closed" else 2]
    names = ["d2", "d1", "start", *([] if case == "closed" else ["u1", "u2"])]
    assert found.points == tuple(("point", name) for name in names)
    assert found.ends == (end, Kind.CLOSED if case == "closed" else Kind.LOST)
    assert found.limits == ("rpm", "" if case == "closed" else "restitution")
    assert found.beyond == ("below", None if case == "closed" else "above")


class Scripted(_Tracer):
    """A tracer whose roots are their own two numbers, and whose attempts are written by a test."""

    def __init__(self, *attempts, steps=50, target=None, closes=()):
        super().__init__("system", event(), replace(PLANE, steps=steps))
        self.attempts, self.target, self.closes = list(attempts), target, closes
        self.asked = []

    def values(self, root):
        return root

    def _target(self, here, slope, share):
        made = self.target or curves._Target(1, here[1] + 0.001, 0.5, at_end=False)
        self.asked.append((here, slope, share))
        return made

    def _attempt(self, roots, target, share, refused):
        self.asked[-1] += (list(roots), refused)
        if not self.attempts:
            return curves._Attempt((roots[-1][0] + 1.0, roots[-1][1] + 0.001))
        return self.attempts.pop(0)

    def _closes(self, roots):
        return roots[-1] in self.closes


START, SECOND, THIRD = (700.0, 0.75), (710.0, 0.74), (705.0, 0.75)


def to(root):
    return curves._Attempt(root)


def end_of(beyond=None, shorter=True, kind=Kind.LOST):
    return curves._Attempt(end=curves._Side(["roots"], kind, beyond=beyond), shorter_may_do=shorter)


def test_a_step_that_fails_is_halved_and_one_that_does_not_lets_the_next_one_grow():
    """Each goes on the way of the last one, in shares of the ranges of 200 rpm and 0.4."""
    last = end_of("beyond", shorter=False, kind=Kind.NO_MOTION)
    one = Scripted(
        end_of("a"), end_of(), end_of(), to(SECOND), end_of(), to(THIRD), to(START), last
    )  # fmt: skip
    assert one.trace(START, -1.0) is last.end
    approx = pytest.approx
    on, back = approx((0.05, -0.025)), approx((-0.025, 0.025))
    at_start, at_second = [START], [START, SECOND]
    assert one.asked == [
        (START, (0.0, -1.0), 1.0, at_start, None),
        (START, (0.0, -1.0), 0.5, at_start, "a"),
        (START, (0.0, -1.0), 0.25, at_start, "a"),
        (START, (0.0, -1.0), 0.125, at_start, "a"),
        (SECOND, on, 0.1875, at_second, None),
        (SECOND, on, 0.09375, at_second, None),
        (THIRD, back, 0.140625, [*at_second, THIRD], None),
        (START, approx((-0.025, 0.0), abs=1e-12), 0.2109375, [*at_second, THIRD, START], None),
    ]
    grown = Scripted(*[to((700.0 + k, 0.75)) for k in range(3)], last)
    grown.trace(START, 1.0)
    assert [share for _, _, share, *_ in grown.asked] == [1.0] * 4


def test_a_curve_ends_where_no_step_is_short_enough():
    """Below 1e-4 of a whole one, that is after 14 halvings."""
    refusals = [end_of(k) for k in range(20)]
    one = Scripted(*refusals)
    assert one.trace(START, 1.0) is refusals[13].end
    assert [of[-1] for of in one.asked] == [None, *[k or None for k in range(13)]]


@pytest.mark.parametrize(("given", "name"), [(0, "rpm"), (1, "restitution")])
def test_a_curve_ends_at_the_end_of_a_range(given, name):
    """Where it is there already, or comes there; also where what is solved is another value."""
    value = SECOND[given]
    target = curves._Target(given, value, 0.5, at_end=True)
    there = Scripted(to(THIRD), to(SECOND), target=target)
    assert there.trace(START, 1.0) == curves._Side([THIRD, SECOND], Kind.END_OF_RANGE, name)
    assert len(there.asked) == 2
    at_once = Scripted(target=target)
    assert at_once.trace(SECOND, 1.0) == curves._Side([], Kind.END_OF_RANGE, name)
    assert len(at_once.asked[0]) == 3  # nothing was attempted
    no_end = Scripted(to(SECOND), end_of(shorter=False), target=target._replace(at_end=False))
    assert no_end.trace(START, 1.0) == curves._Side(["roots"], Kind.LOST)


def test_a_curve_that_comes_back_is_joined_to_its_first_point():
    one = Scripted(to(SECOND), to(THIRD), closes=[THIRD])
    assert one.trace(START, 1.0) == curves._Side([SECOND, THIRD, START], Kind.CLOSED)


def test_a_curve_of_forty_ranges_is_given_up():
    found = Scripted(steps=2).trace(START, 1.0)
    assert (found.end, len(found.roots)) == (Kind.LOST, 79)


@pytest.mark.parametrize(("slope", "share", "here", "target"), [
    ((0.1, 0.2), 1.0, (700.0, 0.75), (1, 0.758, 0.02, False)),
    ((0.1, -0.2), 1.0, (700.0, 0.75), (1, 0.742, -0.02, False)),
    ((0.2, -0.2), 0.5, (700.0, 0.75), (1, 0.746, -0.01, False)),
    ((0.2, -0.1), 0.5, (700.0, 0.75), (0, 702.0, 0.01, False)),
    ((-0.2, 0.1), 1.0, (700.0, 0.75), (0, 696.0, -0.02, False)),
    ((0.0, 0.0), 1.0, (700.0, 0.75), (1, 0.758, 0.02, False)),
    ((0.2, 0.1), 1.0, (797.0, 0.75), (0, 800.0, 0.02, True)),
    ((-0.2, 0.1), 1.0, (603.0, 0.75), (0, 600.0, -0.02, True)),
    ((0.1, 0.2), 1.0, (700.0, 0.9), (1, 0.9, 0.02, True)),
    ((0.1, -0.2), 1.0, (700.0, 0.505), (1, 0.5, -0.02, True)),
])  # fmt: skip
def test_the_number_that_changes_more_is_given_a_step_ahead(slope, share, here, target):
    """A fiftieth of its range, or less; it stops at the end of the range."""
    found = tracer()._target(here, slope, share)
    assert found == (target[0], pytest.approx(target[1]), pytest.approx(target[2]), target[3])


@pytest.mark.parametrize("refused", [None, "refused"])
def test_an_attempt_that_is_refused_says_why_and_whether_less_may_do(monkeypatch, refused):
    roots = ["first", "second", "third"]
    target = curves._Target(1, 0.76, 0.5, at_end=False)
    answers = []

    def next_root(self, *of):
        assert of == (roots, target, 0.25)
        answer = answers[0]
        if isinstance(answer, Exception):
            raise answer
        return curves._Advance(*answer)

    monkeypatch.setattr(_Tracer, "_next", next_root)
    monkeypatch.setattr(_Tracer, "_within_range", lambda self, *of: ("within", *of))

    def attempt(answer):
        answers[:] = [answer]
        return tracer()._attempt(roots, target, 0.25, refused)

    behind = roots[1:]
    assert attempt(("root", None)) == ("within", roots, "root", 1)
    assert attempt(("root", Kind.NO_MOTION)) == curves._Attempt(
        end=curves._Side(behind, Kind.NO_MOTION, beyond="root"), shorter_may_do=True
    )
    assert attempt((None, None)) == curves._Attempt(
        end=curves._Side(behind, Kind.LOST, beyond=refused), shorter_may_do=True
    )
    assert attempt(NoMachineError("why")) == curves._Attempt(
        end=curves._Side(behind, Kind.NO_MACHINE), shorter_may_do=True
    )
    assert attempt(BudgetSpentError()) == curves._Attempt(
        end=curves._Side(behind, Kind.WORK_BUDGET)
    )


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize("upper", [False, True])
def test_a_root_beyond_the_range_is_solved_again_at_its_bound(monkeypatch, free, upper):
    """Where the last point is there already the curve ends; else a shorter step may do."""
    low, high = PLANE.ranges[free]
    bound = high if upper else low
    beyond = bound + (0.25 if upper else -0.25)
    inside = 0.5 * (low + high)

    def at(value):
        return root_of([(1.0, 2.0, 3, 0)], *((value, 0.75) if free == 0 else (700.0, value)))

    asked, edges = [], [None]
    monkeypatch.setattr(_Tracer, "_at_bound", lambda self, *of: (asked.append(of), edges[0])[1])
    first, last, there = at(bound), at(inside), at(beyond)
    name = PLANE.names[free]
    for value in (low, inside, high):
        root = at(value)
        assert tracer()._within_range([first, last], root, 1 - free) == curves._Attempt(root)
    assert asked == []
    end = curves._Side([last], Kind.END_OF_RANGE, name)
    assert tracer()._within_range([first, last], there, 1 - free) == curves._Attempt(
        end=end, shorter_may_do=True
    )
    edges[:] = ["edge"]
    assert tracer()._within_range([first, last], there, 1 - free) == curves._Attempt(
        end=replace(end, roots=[last, "edge"])
    )
    assert asked == [(last, there, 1 - free, bound)] * 2
    asked.clear()
    assert tracer()._within_range([last, first], there, 1 - free) == curves._Attempt(
        end=replace(end, roots=[first])
    )
    assert asked == []


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize(("share", "whole", "extrapolated"), [
    (0.5, 3, True), (2.0, 3, True), (-2.0, 3, True), (2.1, 3, False), (-2.1, 3, False),
    (0.5, 4, False), (None, 3, False),
])  # fmt: skip
def test_the_next_root_is_looked_for_on_the_line_through_the_last_two(
    monkeypatch, free, share, whole, extrapolated
):
    """No farther than two of their steps, and only where their impacts are on one stretch."""
    given = 1 - free
    before, last = (698.0, 0.74), (700.0, 0.75)
    if share is None:  # the given number has not changed: it tells nothing
        before = (700.0, 0.74) if given == 0 else (698.0, 0.75)
    value = last[given] + (share or 0.5) * (last[given] - before[given])
    roots = [root_of([(9.0, 9.0, 3, 0)]), root_of([(1.0, 2.0, whole, 0)], *before),
             root_of([(1.25, 2.5, 3, 0)], *last)]  # fmt: skip
    asked = []

    def solve(self, *of):
        asked.append(of)

    monkeypatch.setattr(_Tracer, "solve", solve)
    assert tracer()._advance(roots, free, value) == (None, Kind.LOST)
    ((root, guess, of_free, of_value),) = asked
    assert (root, of_free, of_value) == (roots[-1], free, value)
    ahead = share if extrapolated else 0.0
    assert guess == pytest.approx([
        1.25 + 0.25 * ahead, 2.5 + 0.5 * ahead, last[free] + ahead * (last[free] - before[free])
    ])  # fmt: skip
    asked.clear()
    tracer()._advance(roots[-1:], free, value)
    assert asked[0][1] == [1.25, 2.5, last[free]]


@pytest.mark.parametrize("free", [0, 1])
@pytest.mark.parametrize(("moved", "turned", "far"), [
    (0.199, 0.49, False), (-0.199, -0.49, False), (0.201, 0.0, True), (-0.201, 0.0, True),
    (0.0, 0.51, True), (0.0, -0.51, True),
])  # fmt: skip
def test_a_step_that_is_too_large_is_none(monkeypatch, free, moved, turned, far):
    """Ten steps of the number solved for, half a radian of any impact."""
    impacts = [(1.0, 2.0, 3, 0), (4.0, 2.0, 3, 1)]
    last = root_of(impacts)
    span = (200.0, 0.4)[free]
    there = [700.0, 0.75]
    there[free] += moved * span
    for k in (0, 1):
        theta = list(impacts)
        theta[k] = (impacts[k][0] + turned, *impacts[k][1:])
        after = root_of(theta, *there)
        monkeypatch.setattr(_Tracer, "solve", lambda self, *of, after=after: after)
        monkeypatch.setattr(_Tracer, "shooter", lambda self, *of: of)
        monkeypatch.setattr(_Tracer, "_refusal", lambda self, root, of: ("asked", root, of))
        found = tracer()._advance([last], free, 9.0)
        refusal = ("asked", after, (after, free, 9.0))
        assert found == ((None, Kind.LOST) if far else (after, refusal))


def test_a_curve_closes_where_the_same_motion_comes_back():
    """Near its first point in both numbers, on the same stretches, its impacts near by, too."""
    start = root_of([(1.0, 2.0, 3, 0), (4.0, 2.0, 3, 1)], 700.0, 0.75)
    away = root_of([(1.0, 2.0, 3, 0), (4.0, 2.0, 3, 1)], 700.0, 0.75 + 0.4 * 0.07)

    def closes(*last, between=away, first=start):
        return tracer()._closes([first, between, root_of(*last)])

    near = [(1.0, 2.0, 3, 0), (4.0, 2.0, 3, 1)]
    assert closes(near, 700.0 + 200.0 * 0.019, 0.75 - 0.4 * 0.019)
    assert not closes(near, 700.0 + 200.0 * 0.021, 0.75)
    assert not closes(near, 700.0, 0.75 - 0.4 * 0.021)
    assert not closes([(1.0, 2.0, 3, 0), (4.0, 2.0, 2, 1)], 701.0, 0.75)
    barely = root_of(near, 700.0 + 200.0 * 0.059, 0.75)
    assert not closes(near, 701.0, 0.75, between=barely)
    # an impact half as fast as 0.5 rad a step would be, or as fast as the last step moved it
    turned = [(1.0, 2.0, 3, 0), (4.02, 2.0, 3, 1)]
    still = root_of(turned, 700.0, 0.75 + 0.4 * 0.07)
    assert closes([(1.0, 2.0, 3, 0), (4.009, 2.0, 3, 1)], 701.0, 0.75)
    assert not closes(turned, 701.0, 0.75, between=still)
    moves = root_of([(1.0, 2.0, 3, 0), (4.04, 2.0, 3, 1)], 700.0, 0.75 + 0.4 * 0.07)
    assert closes(turned, 701.0, 0.75, between=moves)
    elsewhere = replace(moves, whole=(3, 0, 2, 1))
    assert not closes(turned, 701.0, 0.75, between=elsewhere)


@pytest.mark.parametrize("turns", [1, 3])
def test_a_flight_is_nearest_to_the_cam_at_one_of_its_passages(monkeypatch, turns):
    """It passes the phase of the graze once a turn; the nearest passage counts, above or below.

    The flight is above the cam by `gap` at its lowest place in each turn, where a parabola in s is
    lowest; the stretch below it is another one than that of the impact.
    """
    gaps = (0.5, -0.25, 0.375, 9.0)

    def lift(cam, i, theta):
        if i == 5:  # at the impact
            assert theta == 1.0
            return 8.0, 2.0, 0.0
        assert i == ("stretch", pytest.approx(theta))
        return 0.5 * theta, 0.125, 7.0

    def move(const, q, w, s):
        assert (const, q, w) == ("const", 8.0, 2.5)
        number = int(s // TURN)
        off = s - TURN * number - 3.1
        phase = (1.0 + s) % TURN
        return gaps[number] + 2.0 * off * off + 0.5 * phase, 4.0 * off + 0.125

    monkeypatch.setattr(curves, "lift", lift)
    monkeypatch.setattr(curves, "move", move)
    monkeypatch.setattr(curves, "stretch_at", lambda cam, theta: ("stretch", theta))
    monkeypatch.setattr(curves, "gap_accel", lambda const, q, w, c2: 4.0 if c2 == 7.0 else None)
    root = Stub(
        x=[9.0, 9.0, 1.0, 0.5, 700.0], const="const", stretch=lambda k: (9, 5)[k],
        flight_length=lambda k: TURN * turns - 0.5 if k == 1 else None,
    )  # fmt: skip
    of_cam = Stub(system_of=lambda one: Stub(cam="cam"))
    located = Stub(impact=1, phase=4.0)
    number = 0 if turns == 1 else 1
    found = curves.touch_near(of_cam, root, located)
    assert found == (pytest.approx(gaps[number]), pytest.approx(TURN * number + 3.1))
    # a flight that ends before is followed on to the phase, which may lie behind the angle zero
    short = Stub(**{**vars(root), "flight_length": lambda k: 2.0})
    assert curves.touch_near(of_cam, short, located) == (
        pytest.approx(0.5 + 2.0 * 0.1**2), pytest.approx(3.0)
    )  # fmt: skip
    behind = Stub(impact=1, phase=0.25)
    s = TURN - 0.75
    assert curves.touch_near(of_cam, short, behind)[1] == pytest.approx(s)


# -- an atlas


def test_points_are_looked_for_on_the_curves_behind_those_known(monkeypatch):
    asked = []
    monkeypatch.setattr(codim2, "add_points", lambda *of: asked.append(of))
    line = [
        Stub(points=[Stub(first=k, second=10 + k), Stub(first=-1, second=-1)]) for k in (1, 2, 3)
    ]
    book = atlas.Atlas(PLANE, curves=line, points=["a point"])
    at = lambda first, second: (("system", first, second), 700.0)  # noqa: E731
    for known in (3, 1, 0):
        atlas._add_points(at, book, known)
    assert asked == [
        (("system", 2, 12), line, PLANE, ["a point"], 1),
        (("system", 1, 11), line, PLANE, ["a point"], 0),
    ]


# -- Newton's method over a number of the cam


def machine_at(value, **more) -> FamilyMachine:
    return FamilyMachine(value, (value,), **{"constants": f"at {value}", "cam": Stub(), **more})


def test_the_last_equation_keeps_the_distance_or_puts_an_impact_at_an_end():
    row, right = family_shooting.border([2.0, -3.0, 0.5], [1.0, 1.5, 4.0], 0.75)(
        [1.25, 2.5, 8.0], None, None
    )
    assert (row, right) == ([2.0, -3.0, 0.5], 0.75 - (0.5 - 3.0 + 2.0))

    def cam_at(value):  # its edges move with the number, by 2 and by -3
        ends = Stub(start=9.0, end=9.0), Stub(start=1.0 + 2.0 * value, end=5.0 - 3.0 * value)
        return machine_at(value, cam=Stub(stretches=ends))

    sides = Sides(cam_at(0.5), cam_at(0.75))
    x = [9.0, 9.0, 3.25, 0.5, 0.625]
    at_end = family_shooting.on_edge(1, 1, 1)(x, cam_at(0.625), sides)
    assert at_end == ([0.0, 0.0, 1.0, 0.0, 3.0], 5.0 - 1.875 - 3.25)
    at_start = family_shooting.on_edge(1, 1, -1)(x, cam_at(0.625), sides)
    assert at_start == ([0.0, 0.0, 1.0, 0.0, -2.0], 1.0 + 1.25 - 3.25)


def family_of(monkeypatch, spent, **more) -> FamilyShooting:
    """Over the second number of a cam, from 2 to 10."""
    monkeypatch.setattr(family_shooting, "spend", spent.append)
    monkeypatch.setattr(family_shooting, "constants_of", lambda *of: ("constants", *of))

    class Family:
        ranges = ((100.0, 101.0), (2.0, 10.0))
        compiled = 3

        def moved(self, machine, values):
            self.compiled += 2
            if values[1] > 9.0:
                raise NoMachineError("too far")
            return (*machine, *values)

        def reach(self, index, values, end):
            self.compiled += 4
            return index, values, end

    system = Stub(member=Stub(family=Family()), at=lambda machine: Stub(cam=("cam", machine)))
    machine = [*range(CONSTANTS), 100.5, 4.0]
    return FamilyShooting(system, machine, CONSTANTS + 1, 0.125, 0.25)


def test_the_machine_at_a_value_is_compiled_there_and_its_work_is_counted(monkeypatch):
    spent = []
    shooting = family_of(monkeypatch, spent)
    assert (shooting.range, shooting.scale, shooting.rate, shooting.place) == (
        8.0, 0.125, 0.25, CONSTANTS + 1,
    )  # fmt: skip
    there = shooting.at(5.0)
    moved = (*range(CONSTANTS), 100.5, 5.0, 100.5, 5.0)
    assert there == FamilyMachine(5.0, moved, ("constants", moved, 0.0, 0), ("cam", moved))
    assert shooting.machine == (*range(CONSTANTS), 100.5, 4.0)
    assert spent == [100_000]
    with pytest.raises(NoMachineError):
        shooting.at(9.5)
    assert spent == [100_000] * 2
    assert shooting.reach(7.0) == (1, (100.5, 4.0), 7.0)
    assert spent[2:] == [200_000]


def test_a_derivative_is_taken_between_the_nearest_machines_that_are_apart(monkeypatch):
    """Nearer ones than 8e-7 differ by rounding, those farther away than 0.16 tell no direction."""
    shooting = family_of(monkeypatch, [])
    beside = lambda: [one.value for one in shooting._recent]  # noqa: E731
    first = shooting.sides(machine_at(5.0))
    assert [one.value for one in first] == [5.0, 5.0 + 8e-5]
    assert first.width == pytest.approx(8e-5)
    second = shooting.sides(machine_at(4.9))
    assert [one.value for one in second] == [4.9, 5.0]
    third = shooting.sides(machine_at(5.0 + 5e-7))  # 5.0 is too near
    assert [one.value for one in third] == [4.9, 5.0 + 5e-7]
    assert beside() == [5.0 + 5e-7, 4.9, 5.0]
    assert [one.value for one in shooting.sides(machine_at(4.9))] == [4.9, 5.0]
    assert beside() == [4.9, 5.0 + 5e-7, 5.0]  # each value once
    far = shooting.sides(machine_at(5.2))
    assert [one.value for one in far] == [5.2, 5.2 + 8e-5]
    last = shooting.sides(machine_at(8.99995))  # above 9 there is none
    assert [one.value for one in last] == pytest.approx([8.99995 - 8e-5, 8.99995], abs=1e-12)
    for k in range(20):
        shooting.sides(machine_at(3.0 + 0.01 * k))
    assert beside() == [3.0 + 0.01 * k for k in range(19, 7, -1)]
    assert shooting.sides(machine_at(9.5)) is None


def test_the_column_of_a_number_is_the_difference_of_what_two_cams_leave(monkeypatch):
    """Gap, and restitution times rate, where the next impact lands; after the last the first."""
    whole = (4, 0, 5, 0, 6, 1)
    x = [1.0, 0.1, 2.0, 0.2, 3.0, 0.3, 7.0]
    filled = []
    monkeypatch.setattr(family_shooting, "fill_block", lambda *of: filled.append(of))

    def arrival(cam, constants, at, of_whole, turns, k, n):
        assert (at, of_whole, turns, n) == (x, whole, 2, 3)
        assert constants == f"of {cam}"
        value = {"low": 2.0, "high": 3.0}[cam]
        return value**2 * (k + 1), value**3 + k

    def restitution_at(cam, constants, stretch):
        assert constants == f"of {cam}"
        return {"low": 0.5, "high": 0.75}[cam] + 0.125 * stretch

    monkeypatch.setattr(family_shooting, "arrival", arrival)
    monkeypatch.setattr(family_shooting, "restitution_at", restitution_at)
    here, low, high = (
        FamilyMachine(value, (), f"of {cam}", cam)
        for value, cam in ((7.0, "here"), (6.75, "low"), (7.25, "high"))
    )
    tables = tables_for(3, lambda count: [0.0] * count)
    FamilyShooting._fill(Stub(), here, Sides(low, high), x, whole, 2, tables)
    assert filled == [("here", "of here", x, whole, 2, k, 3, tables.blocks) for k in range(3)]
    expected = []
    for k, stretch in ((0, 5), (1, 6), (2, 4)):
        rise = (0.75 + 0.125 * stretch) * (27.0 + k) - (0.5 + 0.125 * stretch) * (8.0 + k)
        expected += [(9.0 - 4.0) * (k + 1) / 0.5, rise / 0.5]
    assert tables.columns == expected


@pytest.mark.parametrize("trace", [-3.5, family_shooting.NO_TRACE])
def test_a_root_of_a_family_has_the_rates_on_its_own_cam(monkeypatch, trace):
    def rates_and_trace(cam, machine, n, turns, whole, x, rates):
        assert (cam, machine, n, turns, whole) == ("cam", "machine at 7.0", 2, 3, (1, 0, 2, 1))
        rates[:] = [-0.5, -0.25]
        return trace

    monkeypatch.setattr(family_shooting, "rates_and_trace", rates_and_trace)
    shooting = Stub(at=lambda value: FamilyMachine(value, f"machine at {value}", None, "cam"))
    x = [1.0, 0.1, 2.0, 0.2, 7.0]
    tables = Stub(tangent=(1.0, 2.0, 3.0, 4.0, 5.0))
    root = FamilyShooting._solved(shooting, x, (1, 0, 2, 1), 3, tables, 1e-16, 4)
    expected = Solved(
        x, "machine at 7.0", [-0.5, -0.25], [1.0, 2.0, 3.0, 4.0, 5.0], trace, 1e-16, 4
    )
    assert root == (expected if trace < 0.0 else None)


def newton(monkeypatch, change, no_machine=(), reach=True, sides=True, regular=True, start=3):
    """`FamilyShooting.correct` with steps of (phase, rate, number) that a test says."""
    numbers = []

    def at(value):
        numbers.append(value)
        if value in no_machine:
            raise NoMachineError("none")
        return machine_at(value)

    def take_step(n, x, tables, border):
        assert n == 1
        assert (border.row, border.right, border.scale, border.rate) == (
            "row",
            "right",
            0.125,
            0.25,
        )
        assert border.origin is x
        step, size = change(x)
        x[:] = [a + b for a, b in zip(x, step, strict=True)]
        return size

    shooting = Stub(
        at=at, sides=lambda here: "sides" if sides else None, scale=0.125, rate=0.25,
        _fill=lambda *of: None, _solved=lambda x, *of: (list(x), of[0], of[1], *of[-2:]),
    )  # fmt: skip
    monkeypatch.setattr(family_shooting, "within_reach", lambda *of: reach)
    monkeypatch.setattr(
        family_shooting,
        "solve_bordered",
        lambda n, tables, row, right: regular and right == "right",
    )
    monkeypatch.setattr(family_shooting, "take_step", take_step)
    last = lambda x, here, both: ("row", "right")  # noqa: E731
    found = FamilyShooting.correct(shooting, (1, 2, start), (5, 0), 2, last)
    return found, numbers


def test_steps_are_taken_until_they_are_roundings_or_no_longer_shrink(monkeypatch):
    sizes = []

    def halving(least):
        sizes[:] = [0.25]

        def change(x):
            sizes.append(max(least, sizes[-1] ** 2))
            return (sizes[-1], 0.0, 0.5), sizes[-1]

        return change

    found, numbers = newton(monkeypatch, halving(1e-20))
    steps = len(sizes) - 1
    assert sizes[-1] <= 4e-15 < sizes[-2]
    assert found == ([pytest.approx(1.0 + sum(sizes[1:])), 2.0, 3.0 + 0.5 * steps], (5, 0), 2,
                     sizes[-1], steps)  # fmt: skip
    assert numbers == [3.0 + 0.5 * k for k in range(steps)]
    found, _ = newton(monkeypatch, halving(1e-9))  # it no longer shrinks, but is a rounding
    assert found[-2:] == (1e-9, len(sizes) - 1)
    assert sizes[-2] == 1e-9 == sizes[-1]
    at_once, _ = newton(monkeypatch, lambda x: ((0.0, 0.0, 0.0), 1e-9))
    assert at_once[-2:] == (1e-9, 2)  # the first step has none to be compared with
    assert newton(monkeypatch, halving(1e-7))[0] is None  # nor does this, which is none
    assert len(sizes) == 1 + family_shooting.MOST_STEPS
    for long in (0.5, family_shooting.LONGEST_STEP, float("nan")):  # one step, and no more
        found, numbers = newton(monkeypatch, lambda x, by=long: ((0.0, 0.0, 1.0), by))
        assert (found, numbers) == (None, [3.0])
    assert newton(monkeypatch, halving(1e-20), no_machine=[3.5])[0] is None
    for refused in ({"reach": False}, {"sides": False}, {"regular": False}):
        assert newton(monkeypatch, halving(1e-20), **refused)[0] is None
    # a change of the number by a rounding, of itself or of its scale, asks for no other cam
    for start, off, kept in ((4, 4e-16, True), (4, 9e-16, False), (0, 1.3e-17, True),
                             (0, 1.5e-17, False)):  # fmt: skip
        found, _ = newton(monkeypatch, lambda x, by=-off: ((0.0, 0.0, by), 1e-16), start=start)
        assert (found[0][-1] == start) is kept


def test_a_rounding_is_that_of_the_largest_term_through_every_equation(monkeypatch):
    """Of two flights, whose four residuals move the number by so much each."""
    weights = [2.0, -3.0, 0.5, 7.0]
    tables = tables_for(2, lambda count: [0.0] * count)
    tables.blocks[RIGHT], tables.blocks[BLOCK + RIGHT] = -4.0, -6.0

    def solve(n, of, row, right):
        assert (n, row, right) == (2, "row", 0.0)
        residuals = [of.blocks[BLOCK * k + RESIDUAL + j] for k in (0, 1) for j in (0, 1)]
        of.step[-1] = sum(w * r for w, r in zip(weights, residuals, strict=True))
        return weights[3] != 0.0 or residuals[3] == 0.0

    monkeypatch.setattr(family_shooting, "solve_bordered", solve)
    cam = Stub(top=0.25, stretches=[Stub(c_min=-0.5), Stub(c_min=0.125)])
    x = [99.0, 3.0, 99.0, -5.0, 99.0]

    def found():
        return family_shooting.rounding_of_last(cam, x, tables, "row")

    for change, largest in (
        (lambda: None, 6.0),
        (lambda: x.__setitem__(3, -8.0), 8.0),
        (lambda: x.__setitem__(1, 9.0), 9.0),
        (lambda: setattr(cam.stretches[0], "c_min", -12.0), 12.0),
        (lambda: setattr(cam, "top", 13.0), 13.0),
        (lambda: tables.blocks.__setitem__(RIGHT, -14.0), 14.0),
    ):
        change()
        assert found() == pytest.approx(12.5 * 8.0 * 2.0**-53 * largest, abs=0.0)
    weights[3] = 0.0
    assert found() == pytest.approx(5.5 * 8.0 * 2.0**-53 * 14.0, abs=0.0)


def test_the_rounding_of_a_family_is_that_on_the_cam_at_the_root(monkeypatch):
    seen = []
    shooting = Stub(
        at=machine_at, sides=lambda here: Sides(here, machine_at(9.0)),
        _fill=lambda *of: seen.append(of),
    )  # fmt: skip
    monkeypatch.setattr(family_shooting, "rounding_of_last", lambda *of: seen.append(of) or 0.375)
    x = [1.0, 0.1, 2.0, 0.2, 7.0]
    assert FamilyShooting.rounding(shooting, x, (1, 0, 2, 1), 3, "row") == 0.375
    filled, last = seen
    assert filled[0].value == 7.0
    assert filled[1] == Sides(filled[0], filled[1].high)
    assert filled[2:5] == (x, (1, 0, 2, 1), 3)
    assert last == (filled[0].cam, x, filled[5], "row")
    assert len(filled[5].step) == 5
    shooting.sides = lambda here: None
    assert FamilyShooting.rounding(shooting, x, (1, 0, 2, 1), 3, "row") == 0.0


def test_what_is_solved_in_a_family_is_a_root_of_the_shooter():
    solved = Solved([1.0, 2.0, 3.0], (4.0, 5.0), [6.0], [7.0, 8.0, 9.0], 10.0, 11.0, 12)
    asked = []
    family = Stub(
        correct=lambda *of: asked.append(of) or solved, rounding=lambda *of: ("rounding", *of)
    )
    own = Stub(parameter=9, seat=frozenset({2}), family=family, edge=lambda *of: 20.0 + of[1])
    root = Shooter._as_root(own, solved, [3, 1], 2)
    assert root == Root(
        [1.0, 2.0, 3.0], (3, 1), 2, (4.0, 5.0), 9, [6.0], [7.0, 8.0, 9.0], 10.0, 11.0, 12,
        frozenset({2}),
    )  # fmt: skip
    assert Shooter._as_root(own, None, [3, 1], 2) is None
    own._as_root = lambda *of: of
    assert Shooter.rounding(own, root) == ("rounding", root.x, (3, 1), 2, root.tangent)
    guess = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)])
    assert Shooter.at_corner(own, guess, 1, -1) == (solved, guess.whole, 2)
    ((x, whole, turns, last),) = asked
    assert (x, whole, turns) == ([1.0, 2.0, 21.0, 5.0, 700.0], guess.whole, 2)
    ends = Stub(cam=Stub(stretches=[Stub(start=k, end=-k) for k in range(8)]), value=0.0)
    row, right = last(x, ends, Sides(ends, Stub(cam=ends.cam, value=1.0)))
    assert (row[2], right) == (1.0, 6 - 21.0)
    assert Shooter.correct(own, guess.x, guess.whole, 2, [1.0] * 5, guess.x, 0.5) == (
        solved, guess.whole, 2,
    )  # fmt: skip
    assert asked[-1][:3] == (guess.x, guess.whole, 2)
    assert asked[-1][3](guess.x, None, None) == ([1.0] * 5, 0.5)


def test_the_rounding_of_a_constant_is_that_of_the_equations_at_the_root(monkeypatch):
    root = root_of([(1.0, 2.0, 3, 0), (4.0, 5.0, 6, 1)], parameter=4, turns=3)
    seen = []
    monkeypatch.setattr(shooter, "fill_tables", lambda *of: seen.append(of))
    monkeypatch.setattr(shooter, "rounding_of_last", lambda *of: seen.append(of) or 0.375)
    own = Stub(
        family=None, parameter=4, scale=0.125, system_of=lambda of: Stub(cam=("cam at", of.value))
    )
    assert Shooter.rounding(own, root) == 0.375
    filled, last = seen
    cam, tables = ("cam at", 700.0), filled[8]
    assert filled[:8] == (cam, list(root.machine), 4, 2, 3, root.whole, root.x, 0.125)
    assert (len(tables.blocks), len(tables.step)) == (2 * BLOCK, 5)
    assert last == (cam, root.x, tables, root.tangent)


def test_a_constant_that_is_zero_has_a_size_that_matters():
    sizes = {"stiffness": 12.0 * 49.0, "damping": 84.0, "gravity": 49.0, "preload": 588.0,
             "restitution": 1.0, "seat_restitution": 1.0, "rpm": 0.0, "mass": 0.0}  # fmt: skip
    for name, size in sizes.items():
        assert shooter._natural(shooter.PLACES[name], 12.0, 7.0) == size


# -- points of codimension two


def direction_of(rows, along) -> list[float]:
    """What `_kernel` returns for these slopes of the equations."""
    size = len(along)
    slopes = arb_mat([[arb(float(x)) for x in row] for row in rows])
    meeting = Stub(n=size // 2, branch_direction=[arb(float(x)) for x in along])
    asked = []
    at = Stub(rpm=700.0, equations=lambda z: asked.append(z) or (None, slopes))
    found = codim2.Meeting._kernel(meeting, at, [arb(k) for k in range(size)])
    assert [float(x) for x in asked[0]] == [*map(float, range(size)), 700.0]
    return [float(x) for x in found]


@pytest.mark.parametrize("kernel", [(3.0, -2.0), (1.0, 4.0, -2.0, 5.0)])
def test_the_kernel_of_the_equations_has_the_length_one_along_the_branch(kernel):
    """Singular: each row is at right angles to it. Else it goes with E^-1 E^-T a."""
    size = len(kernel)
    rows = np.random.default_rng(size).normal(size=(size, size))
    along = np.arange(1.0, size + 1.0)
    inverse = np.linalg.inv(rows)
    regular = inverse @ inverse.T @ along
    assert direction_of(rows, along) == pytest.approx(list(regular / (along @ regular)))
    unit = np.array(kernel) / np.linalg.norm(kernel)
    singular = rows - np.outer(rows @ unit, unit)
    expected = np.array(kernel) / (along @ kernel)
    assert direction_of(singular, along) == pytest.approx(list(expected))


def test_the_bend_of_a_fold_is_its_slope_along_the_kernel(monkeypatch):
    """f = x^2 y + 3 y at (2, 5), along (0.5, -2): 2 x y 0.5 + (x^2 + 3)(-2) = -4."""

    def function(at, machine, x, sign):
        assert (at, machine, sign) == ("at", "machine", -1)
        return x[0] * x[0] * x[1] + 3 * x[1]

    monkeypatch.setattr(codim2, "_multiplier_test", function)
    meeting = Stub(_kernel=lambda at, x: [arb(0.5), arb(-2)])
    with codim2.precision(codim2.DIGITS):
        found = codim2.Meeting._bend(meeting, "at", "machine", [arb(2), arb(5)])
    assert float(found) == pytest.approx(-4.0, rel=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_function_of_a_multiplier_is_regular_where_a_rate_is_zero(sign):
    """Of three flights with different restitutions; it is the test times the rates."""
    slopes = [np.array([[0.5, 2.0], [-1.0, 0.25]]), np.array([[-3.0, 0.75], [1.5, 4.0]]),
              np.array([[1.0, -2.0], [0.125, 3.0]])]  # fmt: skip
    for rates in ((-0.5, 1.5, 2.0), (-0.5, 0.0, 2.0)):
        flights = [
            Stub(slopes_times_rate=lambda of=of: ImpactSlopes(*map(arb, of.ravel().tolist())),
                 r=arb(r), rate=arb(rate))
            for of, r, rate in zip(slopes, (0.5, 0.75, 0.625), rates, strict=True)
        ]  # fmt: skip
        asked = []
        at = Stub(turns=3, flights=lambda *of, made=flights, told=asked: told.append(of) or made)
        machine = Stub(Z=arb(0.125), turn=arb(2))
        found = codim2._multiplier_test(at, machine, "x", sign)
        det = exp(-2.0 * 0.125 * 2.0 * 3.0) * (0.5 * 0.75 * 0.625) ** 2
        trace = np.trace(slopes[2] @ slopes[1] @ slopes[0])
        assert float(found) == pytest.approx((1.0 + det) * np.prod(rates) + sign * trace)
        assert asked == [(machine, "x")]
