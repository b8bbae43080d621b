"""What a step of a branch ends at, and how an event on it is located, with stand-in solvers."""

from __future__ import annotations

from dataclasses import replace
from math import isnan, pi, ulp
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.orbits import arclength, branch_segment, locate
from camcli.analysis.orbits.arclength import BranchStep, Metric, Span
from camcli.analysis.orbits.branch_segment import BranchSegment
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Crossing, Located
from camcli.analysis.orbits.shooter import Root
from tests.analysis.test_steps_of_branches import root_of

TURN = 2.0 * pi
SPAN = Span(700.0, 750.0, 5.0)
METRIC = Metric(np.array([0.0, 0.0, 0.0, 0.0, 1.0]))
UNIT = np.array([0.0, 0.0, 0.0, 0.0, 1.0])


def at_value(value: float, impacts=((1.0, 0.5, 2, 0), (4.0, 0.25, 3, 1)), **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    return root_of(impacts, value, **more)


def step_to(value: float, before=720.0) -> BranchStep:
    way = 1.0 if value >= before else -1.0
    return BranchStep(at_value(before), way * UNIT, at_value(value), abs(value - before), METRIC)


def event_at(value: float, kind=Kind.FOLD, status=Bracket.OK, **more) -> Located:
    return Located(kind, at_value(value), 0.5, 1e-9, status, **more)


def crossing_at(value: float, corner="b", kink=False, back=False) -> Crossing:
    right = at_value(value, tangent=[0.0] * 4 + [-2.0 if back else 2.0])
    return Crossing(at_value(value), right, 1, True, corner, kink, [0.5, 1.5, 2.5, 3.5, -1.0])


# -- what a step ends at


def advance(monkeypatch, after=725.0, corner=None, graze=None, short=(), goes_on=True):
    """The segment, what `_advance` returns, and the parts of the step that were asked about."""
    asked = Stub(graze=[], smooth=[], passed=[], born=[])
    segment = BranchSegment([at_value(720.0)])

    def graze_on(shooter, step):
        asked.graze.append(step.after.value)
        return graze

    def smooth(shooter, of, step, grazes):
        asked.smooth.append((step.after.value, grazes))
        return goes_on

    monkeypatch.setattr(branch_segment, "collapses", lambda of, root: root.value in short)
    monkeypatch.setattr(branch_segment, "corner_on", lambda of, step: corner)
    monkeypatch.setattr(branch_segment, "graze_on", graze_on)
    monkeypatch.setattr(branch_segment, "_take_smooth_events", smooth)
    monkeypatch.setattr(
        branch_segment, "_pass_corner",
        lambda shooter, of, event: (asked.passed.append(event), "crossing")[1],
    )  # fmt: skip
    monkeypatch.setattr(
        branch_segment, "_born", lambda shooter, of, step: asked.born.append(step.after.value)
    )
    found = branch_segment._advance("shooter", segment, step_to(after), SPAN)
    return segment, found, asked


def values(segment):
    return [root.value for root in segment.points]


def test_a_step_on_which_nothing_happens_is_taken(monkeypatch):
    segment, found, asked = advance(monkeypatch)
    assert (values(segment), segment.end, segment.events) == ([720.0, 725.0], Kind.LOST, [])
    assert found is None
    assert (asked.graze, asked.smooth) == ([725.0], [(725.0, False)])
    for bound in (750.0, 700.0):
        segment, found, _ = advance(monkeypatch, bound)
        assert (values(segment), segment.end, found) == ([720.0, bound], Kind.END_OF_RANGE, None)


@pytest.mark.parametrize("after", [725.0, 750.0])
def test_a_step_ends_at_a_corner_or_before_it_at_a_graze(monkeypatch, after):
    """Where it is cut it does not reach the end of the range."""
    corner, graze = event_at(723.0, Kind.CORNER_IMPACT), event_at(722.0, Kind.GRAZING)
    segment, found, asked = advance(monkeypatch, after, corner)
    assert (values(segment), segment.end) == ([720.0, 723.0], Kind.LOST)
    assert (found, asked.passed) == ("crossing", [corner])
    assert (asked.graze, asked.smooth) == ([723.0], [(723.0, False)])
    for beyond in (corner, None):
        segment, found, asked = advance(monkeypatch, after, beyond, graze)
        assert (values(segment), segment.end) == ([720.0, 722.0], Kind.GRAZING)
        assert segment.events == [(graze, None)]
        assert (found, asked.passed, asked.smooth) == (None, [], [(722.0, True)])


def test_a_step_without_a_length_adds_no_point(monkeypatch):
    corner = event_at(720.0, Kind.CORNER_IMPACT)
    segment, found, _ = advance(monkeypatch, corner=corner)
    assert (values(segment), found) == ([720.0], "crossing")


def test_a_branch_ends_where_its_orbit_is_a_shorter_one(monkeypatch):
    """At a period doubling, or where it shrinks to the corner impact of the single orbit."""
    segment, found, asked = advance(monkeypatch, short=[725.0])
    assert (values(segment), found, asked.born, asked.graze) == ([720.0], None, [725.0], [])
    corner = event_at(723.0, Kind.CORNER_IMPACT)
    segment, found, asked = advance(monkeypatch, corner=corner, short=[723.0])
    assert (values(segment), segment.end, segment.events) == ([720.0], Kind.CORNER_IMPACT, [])
    assert (found, asked.graze, asked.smooth) == (None, [], [])
    segment, found, asked = advance(monkeypatch, goes_on=False)
    assert (values(segment), segment.end, found) == ([720.0], Kind.LOST, None)


@pytest.mark.parametrize("grazes", [False, True])
@pytest.mark.parametrize("begins", [False, True])
@pytest.mark.parametrize(("headings", "turned"), [
    ((1.0, 1.0), False), ((1.0, -1.0), True), ((-1.0, 1.0), True), ((-1.0, -1.0), False),
    ((1.0, 0.0), False), ((-1.0, 0.0), True), ((0.0, -1.0), True),
])  # fmt: skip
def test_doublings_and_folds_on_a_step_are_events_of_its_segment(
    monkeypatch, grazes, begins, headings, turned
):
    """A fold that the parameter shows by turning round; the first doubling is told elsewhere."""
    first = at_value(720.0)
    unit = np.array([0.0, 0.0, 0.0, 0.0, headings[0]])
    metric = Stub(oriented=lambda root, along: np.array([9.0, 9.0, 9.0, 9.0, headings[1]])
                  if (root.value, along is unit) == (725.0, True) else None)  # fmt: skip
    events = [event_at(722.0, Kind.PERIOD_DOUBLING), event_at(723.0), event_at(724.0)]
    asked, told, short = [], list(events), []
    monkeypatch.setattr(
        branch_segment, "smooth_events", lambda *of: (asked.append(of), list(told))[1]
    )
    monkeypatch.setattr(branch_segment, "collapses", lambda of, root: root.value in short)
    monkeypatch.setattr(
        branch_segment, "_born", lambda shooter, of, step: of.close(Kind.PERIOD_DOUBLING)
    )
    parents = {}
    monkeypatch.setattr(
        branch_segment, "parent_of", lambda of, event: parents.get(event.root.value)
    )

    def take(before=first):
        segment = BranchSegment([first], begins_doubling=begins)
        step = BranchStep(before, unit, at_value(725.0), 5.0, metric)
        goes_on = branch_segment._take_smooth_events("shooter", segment, step, grazes)
        assert asked.pop() == ("shooter", step, turned, begins and before is first)
        return goes_on, segment

    goes_on, segment = take()
    assert goes_on
    assert segment.events == [(event, None) for event in events]
    assert values(segment) == [720.0, 722.0, 723.0, 724.0]
    take(at_value(720.0))
    parents[723.0] = event_at(723.5, Kind.PERIOD_DOUBLING)
    parents[722.0] = "no fold"
    goes_on, segment = take()
    assert (goes_on, values(segment)) == (False, [720.0, 722.0, 723.0])
    assert segment.events == [(events[0], None), (parents[723.0], None)]
    assert segment.end == Kind.PERIOD_DOUBLING
    short.append(723.0)
    goes_on, segment = take()
    assert (goes_on, values(segment), segment.events) == (False, [720.0], [])
    assert segment.end == Kind.PERIOD_DOUBLING
    short[:] = [722.0]
    parents.clear()
    assert take()[0]
    told[1] = event_at(723.0, status=Bracket.UNRESOLVED)
    goes_on, segment = take()
    assert goes_on is grazes
    assert values(segment) == ([720.0, 722.0, 723.0, 724.0] if grazes else [720.0])


@pytest.mark.parametrize("found", [True, False])
def test_a_branch_is_born_at_a_doubling_near_the_step_that_passed_it(monkeypatch, found):
    """It is looked for up to two steps away, as if the step's end were a fold."""
    asked = []
    parent = event_at(721.0, Kind.PERIOD_DOUBLING) if found else None
    monkeypatch.setattr(
        branch_segment, "parent_of", lambda *of, within: (asked.append((*of, within)), parent)[1]
    )
    segment, step = BranchSegment([at_value(720.0)]), step_to(717.0)
    branch_segment._born("shooter", segment, step)
    as_fold = Located(Kind.FOLD, step.after, 3.0, 0.0, Bracket.OK)
    assert asked == [("shooter", as_fold, 6.0)]
    assert segment.end == Kind.PERIOD_DOUBLING
    assert segment.events == ([(parent, None)] if found else [])


@pytest.mark.parametrize(("corner", "kink", "back", "goes_on", "turned"), [
    ("b", False, False, True, False), ("b", False, True, False, True),
    ("b", True, False, False, False), ("b", True, True, False, False),
    ("", False, False, True, False), ("", False, True, True, False),
    (None, False, False, False, False),
])  # fmt: skip
def test_a_branch_goes_on_behind_a_corner_unless_it_turns_back_or_is_thrown(
    monkeypatch, corner, kink, back, goes_on, turned
):
    """Where the cam is smooth nothing is told."""
    crossing = None if corner is None else crossing_at(723.0, corner, kink, back)
    event = event_at(723.0, Kind.CORNER_IMPACT)
    monkeypatch.setattr(branch_segment, "cross", lambda *of: crossing)
    segment = BranchSegment([at_value(720.0)])
    found = branch_segment._pass_corner("shooter", segment, event)
    assert found is (crossing if goes_on else None)
    assert segment.end == (Kind.LOST if goes_on else Kind.CORNER_IMPACT)
    assert segment.events == ([] if corner == "" else [(event, crossing)])
    assert segment.points[1:] == ([crossing.far] if goes_on and corner else [])
    assert segment.turned is (crossing if turned else None)


# -- events on a step


class Line:
    """A solver whose roots along a step of 10 from 720 on have the parameter on a line.

    lost: lengths (low, high) on which nothing is solved.
    """

    scale = 0.5

    def __init__(self, lost=(), **more):
        self.lost = lost
        self.__dict__.update(more)

    def correct(self, guess, whole, turns, row, origin, length):
        if any(low <= length <= high for low, high in self.lost):
            return None
        return at_value(720.0 + length, trace=self.trace(720.0 + length))

    def trace(self, value):
        return 0.0

    def moved(self, root, value):
        return at_value(value, trace=self.trace(value))


def test_an_event_is_on_a_step_up_to_its_end():
    step = step_to(730.0)
    for value, is_on in ((720.0, True), (730.0, True), (725.0, True), (730.0 + 1e-6, False),
                         (720.0 - 0.9e-8, True), (720.0 - 1.1e-8, False)):  # fmt: skip
        assert locate._on(step, at_value(value)) is is_on


@pytest.mark.parametrize("side", [1, -1])
def test_the_last_root_before_a_corner_is_one_with_its_impact_inside(side):
    """Where no root is found the corner has been passed; nothing is before a step begun there."""
    edge = 4.0

    def solver(lost=(), corner_at=726.0):
        made = Line(lost)

        def moves(root):
            x = list(root.x)
            x[2] = edge + side * (root.value - corner_at) / 100.0
            return replace(root, x=x)

        of_line = made.correct
        made.correct = lambda *of: (lambda root: root and moves(root))(of_line(*of))
        made.edge = lambda root, k, of: edge if (k, of) == (1, side) else None
        step = step_to(730.0)
        return made, replace(step, before=moves(step.before), after=moves(step.after))

    made, step = solver()
    assert locate._before_corner(made, step, 1, side).value == pytest.approx(726.0, abs=1e-8)
    made, step = solver([(4.0, 5.0)])
    assert locate._before_corner(made, step, 1, side).value <= 724.0
    for corner_at in (720.0, 719.0):
        made, step = solver(corner_at=corner_at)
        assert locate._before_corner(made, step, 1, side) is step.before


@pytest.mark.parametrize("told", [False, True])
@pytest.mark.parametrize(("before", "after", "doubles"), [
    (0.5, -0.5, "yes"), (-0.5, 0.5, "yes"), (0.5, 0.25, "no"), (-0.5, -0.25, "no"),
    (0.9e-10, -0.5, "if not told"), (-0.9e-10, 0.5, "if not told"), (1.1e-10, -0.5, "yes"),
    (0.0, -0.5, "if not told"), (-0.5, 0.0, "yes"), (0.5, 0.0, "no"), (0.0, 0.5, "no"),
])  # fmt: skip
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("way", [1.0, 0.0, -1.0])
def test_doublings_and_folds_come_in_the_order_of_the_step(
    monkeypatch, told, before, after, doubles, turned, way
):
    """A doubling at the beginning that has been told is not told again."""
    monkeypatch.setattr(locate, "flip_test", lambda root: {720.0: before, 730.0: after}[root.value])

    def located(shooter, step, kind, test, at_before, at_after):
        if kind == Kind.FOLD:
            assert (at_before, at_after) == (1.0, -1.0)
            rises = 1.0 if way >= 0.0 else -1.0
            assert test(at_value(725.0, tangent=[0.0] * 4 + [3.0])) == 3.0 * rises
            return Stub(kind=kind, reach=2.0)
        assert (test, at_before, at_after) == (locate.flip_test, before, after)
        return Stub(kind=kind, reach=5.0)

    monkeypatch.setattr(locate, "_root_of", located)
    step = replace(step_to(730.0), unit=np.array([0.0, 0.0, 0.0, 0.0, way]))
    found = locate.smooth_events("shooter", step, turned, told)
    is_there = doubles == "yes" or (doubles == "if not told" and not told)
    assert [event.kind for event in found] == [
        *([Kind.FOLD] if turned else []), *([Kind.PERIOD_DOUBLING] if is_there else [])
    ]  # fmt: skip


@pytest.mark.parametrize("rises", [True, False])
@pytest.mark.parametrize("rounding", [0.0, 1e-3])
@pytest.mark.parametrize("kind", [Kind.FOLD, Kind.PERIOD_DOUBLING])
def test_an_event_is_where_its_function_changes_sign_on_a_step(monkeypatch, rises, rounding, kind):
    """A fold is as certain as the parameter is there; others are bracketed in it."""
    monkeypatch.setattr(
        locate, "_bracket", lambda of, root, test: locate.Certainty(0.125, Bracket.OK)
    )
    sign = 1.0 if rises else -1.0
    test = lambda root: sign * (root.value - 723.75)  # noqa: E731
    solver = Line(rounding=lambda root: rounding)
    found = locate._root_of(solver, step_to(730.0), kind, test, -3.75 * sign, 6.25 * sign)
    assert (found.kind, found.status) == (kind, Bracket.OK)
    assert found.root.value == pytest.approx(723.75, abs=1e-9)
    assert found.reach == pytest.approx(3.75, abs=1e-9)
    if kind == Kind.PERIOD_DOUBLING:
        assert found.error == 0.125
    elif rounding:
        assert found.error == rounding
    else:
        assert 8.0 * ulp(723.75) <= found.error < 1e-9


def test_an_event_at_which_no_orbit_is_solved_is_unresolved():
    """The last root before it is told, and how much of the step is left."""
    solver = Line([(3.0, 6.0)])
    test = lambda root: root.value - 724.0  # noqa: E731
    for kind in (Kind.FOLD, Kind.PERIOD_DOUBLING):
        found = locate._root_of(solver, step_to(730.0), kind, test, -4.0, 6.0)
        assert (found.kind, found.status) == (kind, Bracket.UNRESOLVED)
        assert found.root.value <= 723.0
        assert found.error == pytest.approx(730.0 - found.root.value)
        assert found.root.value == pytest.approx(720.0 + found.reach)


@pytest.mark.parametrize(("off", "least", "width", "status"), [
    (0.5e-13, 0.0, 1e-13, Bracket.OK), (5e-12, 0.0, 1e-11, Bracket.OK),
    (0.5e-13, 3e-10, 1e-12, Bracket.OK), (0.0, 2e-10, 1e-12, Bracket.OK),
    (1.5e-8, 0.0, 1e-8, Bracket.UNRESOLVED), (0.0, 1e-3, 1e-8, Bracket.UNRESOLVED),
])  # fmt: skip
@pytest.mark.parametrize("value", [700.0, -700.0])
def test_a_bracket_is_the_narrowest_at_whose_ends_the_signs_differ(
    off, least, width, status, value
):
    """Beside the root by a share `off`; at both ends the function is more than rounding."""
    solver = Stub(moved=lambda root, at: at_value(at))
    zero = value + abs(value) * off
    test = lambda root: root.value - zero  # noqa: E731
    found = locate._bracket(solver, at_value(value), test, least)
    assert found == (pytest.approx(width * 700.0), status)
    refuses = {value - 700.0 * 1e-13, value + 700.0 * 1e-12}
    solver.moved = lambda root, at: None if at in refuses else at_value(at)
    assert locate._bracket(solver, at_value(value), test, least).error >= 1e-11 * 700.0


def test_a_doubling_is_looked_for_from_a_step_of_a_share_of_the_parameter(monkeypatch):
    asked = []

    def secant(at, *of):
        asked.append(of)
        return [at(value)[0] for value in (725.0, 800.0)]

    monkeypatch.setattr(locate, "secant", secant)
    monkeypatch.setattr(locate, "flip_test", lambda root: root.value - 700.0)
    solver = Stub(scale=0.5, moved=lambda root, at: at_value(at) if at < 750.0 else None)
    for value in (720.0, -720.0):
        assert locate.doubling_near(solver, at_value(value), 1e-3) == [25.0, 0.0]
        assert asked.pop() == (value, pytest.approx(0.7205), 720.5)


PAIR = ((1.0, 0.5, 2, 0), (4.0, 0.25, 3, 1), (1.02, 0.75, 2, 2), (3.98, 0.5, 3, 3))


@pytest.mark.parametrize(("impacts", "turns", "within", "away", "born"), [
    (PAIR, 4, 0.0, 0.0, True), (PAIR, 3, 0.0, 0.0, False), (PAIR[:3], 4, 0.0, 0.0, False),
    (PAIR, 4, 0.0, 7.2e-4, True), (PAIR, 4, 0.0, 7.3e-4, False), (PAIR, 4, 5.0, 4.9, True),
    (PAIR, 4, 5.0, 5.0001, False), (PAIR, 4, 1e-5, 7.2e-4, True), (PAIR, 4, 0.0, None, False),
    ((*PAIR[:2], (1.06, 0.5, 2, 2), PAIR[3]), 4, 0.0, 0.0, False),  # 0.06 rad apart
    ((*PAIR[:2], (0.94, 0.5, 2, 2), PAIR[3]), 4, 0.0, 0.0, False),
    ((*PAIR[:2], (1.06, 0.5, 2, 2), PAIR[3]), 4, 5.0, 0.0, True),
])  # fmt: skip
def test_a_branch_was_born_where_both_halves_of_its_orbit_are_one(
    monkeypatch, impacts, turns, within, away, born
):
    """The single orbit has the means of both halves; its doubling lies near in the parameter."""
    event = Located(Kind.FOLD, at_value(720.0, impacts, turns=turns), 2.5, 1e-9, Bracket.OK)
    solver = Stub(scale=0.5)
    asked = []

    def near(shooter, single, width):
        asked.append((single.x, single.whole, single.turns, width))
        return None if away is None else at_value(720.0 + away)

    monkeypatch.setattr(locate, "doubling_near", near)
    monkeypatch.setattr(
        locate, "_bracket", lambda of, root, test: locate.Certainty(0.125, Bracket.UNRESOLVED)
        if test is locate.flip_test else None,
    )  # fmt: skip
    found = locate.parent_of(solver, event, within)
    if born:
        assert found == Located(
            Kind.PERIOD_DOUBLING, at_value(720.0 + away), 2.5, 0.125, Bracket.UNRESOLVED
        )
        means = [0.5 * (a + b) for one, other in zip(impacts[:2], impacts[2:], strict=True)
                 for a, b in zip(one[:2], other[:2], strict=True)]  # fmt: skip
        assert asked == [(pytest.approx([*means, 720.0]), (2, 0, 3, 1), 2, 1e-7)]
    else:
        assert found is None


@pytest.mark.parametrize("slow", [True, False])
def test_a_motion_ends_at_a_graze_or_where_an_impact_fades(monkeypatch, slow):
    """By the slowest impact where the motion is one for the last time."""
    rates = [-0.5, 0.9e-3 if slow else -1.1e-3]
    solver = Line(
        admits=lambda root: root.value < 723.5, zero_rate=1e-3,
        verdict=lambda root: (7, 1, 2.25) if root.value >= 723.5 else None,
    )  # fmt: skip
    of_line = solver.correct
    solver.correct = lambda *of: replace(of_line(*of), rates=rates)
    step = step_to(730.0)
    monkeypatch.setattr(locate, "_fade", lambda *of: of)
    found = locate.graze_on(solver, step)
    if slow:
        assert (found[0], found[1], found[2]) == (solver, step, 1)
        assert found[3] == pytest.approx(3.5, abs=1e-9)
        assert found[4].value == pytest.approx(723.5, abs=1e-9)
    else:
        assert (found.kind, found.status, found.impact) == (Kind.GRAZING, Bracket.OK, 1)
        assert (found.phase, found.fading) == (2.25, None)
        assert found.root.value == pytest.approx(723.5, abs=1e-9)
        assert found.root.value < 723.5
        assert 8.0 * ulp(723.5) <= found.error < 1e-9
    assert locate.graze_on(solver, step_to(723.0)) is None


@pytest.mark.parametrize(("at", "status"), [
    (725.0, Bracket.OK), (738.0, Bracket.OK), (775.0, Bracket.UNRESOLVED),
])  # fmt: skip
def test_an_impact_fades_where_its_rate_is_zero_on_a_step_or_behind_it(monkeypatch, at, status):
    """It is looked for up to four steps on; its certainty is beyond the rounding of a rate."""
    asked = []

    def bracketed(shooter, root, test, least):
        asked.append((test(root), least))
        assert isnan(test(None))
        return locate.Certainty(0.125, Bracket.OK)

    monkeypatch.setattr(locate, "_bracket", bracketed)
    solver = Line(zero_rate=2e-3)
    of_line = solver.correct

    def moving(root):
        impacts = ((1.0, 0.5, 2, 0), (4.0 + root.value / 1e4, 0.25, 3, 1))
        return at_value(root.value, impacts, rates=[-0.5, (root.value - at) / 100.0])

    solver.correct = lambda *of: moving(of_line(*of))
    step = step_to(730.0)
    step = replace(step, after=moving(step.after))
    last = moving(at_value(722.0))
    found = locate._fade(solver, step, 1, 2.0, last)
    assert (found.kind, found.impact, found.fading, found.status) == (Kind.GRAZING, 1, 1, status)
    assert found.phase == found.root.theta[1]
    if status == Bracket.OK:
        assert found.root.value == pytest.approx(at, abs=1e-8)
        assert found.root.rates[1] < 0.0
        assert found.error == 0.125
        ((rate, least),) = asked
        assert rate == found.root.rates[1]
        assert least == pytest.approx(4e-15 * 2.0, abs=0.0)  # the lift is a thousand times the rate
    else:
        assert found.root is last
        assert found.reach == 2.0
        assert found.error == pytest.approx(720.0 + 10.0 * 1.5**4 - 722.0)


def test_a_secant_ends_with_a_small_step_or_a_zero():
    def at(place):
        tried.append(place)
        value = (place - 3.0) * (1.0 + 0.01 * (place - 3.0))
        return value, None if place in gone else f"at {place!r}"

    gone, tried = set(), []
    found = locate.secant(at, 1.0, 0.5, 1e3)
    assert found == f"at {tried[-1]!r}"
    assert tried[:2] == [1.0, 1.5]
    assert tried[-1] == pytest.approx(3.0, abs=1e-9)
    assert abs(tried[-1] - tried[-2]) <= 1e-10 < abs(tried[-2] - tried[-3])
    for place in (1.0, 1.5):
        gone.add(place)
        assert locate.secant(at, 1.0, 0.5, 1e3) is None
        gone.clear()
    gone.add(tried[2])
    assert locate.secant(at, 1.0, 0.5, 1e3) is None
    assert locate.secant(lambda place: (2.0, place), 1.0, 0.5, 1e3) == 1.5  # it does not change
    wild = iter(range(1, 100))
    assert locate.secant(lambda place: ((-1.0) ** next(wild) * 2.0, "root"), 1.0, 0.5, 1.0) is None


@pytest.mark.parametrize("good", [0, 2, None])
@pytest.mark.parametrize("bad", ["lost", "virtual", "single", "unsettled"])
def test_a_doubled_orbit_leaves_along_the_eigenvector_and_against_it(monkeypatch, good, bad):
    """Some amplitudes are tried until one gives a motion of twice the period."""
    vector = [1.0, -0.5, 0.25, 2.0]
    monkeypatch.setattr(locate, "_flip_vector", lambda *of: vector)
    root = at_value(720.0)
    asked = []

    def correct(*of):
        asked.append(of)
        is_good = good is not None and len(asked) > good
        return Stub(good=is_good) if is_good or bad != "lost" else None

    solver = Stub(correct=correct, admits=lambda one: one.good or bad != "virtual")
    monkeypatch.setattr(locate, "collapses", lambda of, one: not one.good and bad == "single")
    monkeypatch.setattr(
        locate, "settled",
        lambda of, one: None if one is None or (not one.good and bad == "unsettled")
        else Stub(good=one.good, settled=True),
    )  # fmt: skip
    found = locate.doubled(solver, Located(Kind.PERIOD_DOUBLING, root, 0.0, 0.0, Bracket.OK))
    direction = [*vector, *[-d for d in vector], 0.0]
    if good is None:
        assert found is None
    else:
        orbit, along = found
        assert (orbit.good, orbit.settled, along) == (True, True, direction)
    amplitudes = (1e-3, 1e-4, 1e-5, 1e-2)[: 4 if good is None else good + 1]
    origin = [1.0, 0.5, 4.0, 0.25, 1.0, 0.5, 4.0, 0.25, 720.0]
    assert len(asked) == len(amplitudes)
    for amplitude, (guess, whole, turns, row, start, distance) in zip(
        amplitudes, asked, strict=True
    ):
        wanted = [x + amplitude * d for x, d in zip(origin, direction, strict=True)]
        assert guess == pytest.approx(wanted, rel=1e-14)
        assert (list(whole), turns) == ([2, 0, 3, 1, 2, 2, 3, 3], 4)
        assert (row, start) == (direction, origin)
        assert distance == pytest.approx(amplitude * 2.0 * (1.0 + 0.25 + 0.0625 + 4.0))
    monkeypatch.setattr(locate, "_flip_vector", lambda *of: None)
    event = Located(Kind.PERIOD_DOUBLING, root, 0.0, 0.0, Bracket.OK)
    assert locate.doubled(solver, event) is None


def test_an_orbit_that_is_another_one_gone_through_again_has_collapsed(monkeypatch):
    monkeypatch.setattr(
        locate, "section_states",
        lambda *of: (of[1].theta, "symbols") if of[0] == "system" else None,
    )  # fmt: skip
    root = at_value(720.0, turns=6)
    for shortest in range(1, 7):
        monkeypatch.setattr(
            locate, "shortest_period", lambda of, n=shortest: n if of == root.theta else None
        )
        assert locate.collapses(Stub(system="system"), root) is (shortest < 6)


# -- which steps resolve a branch


@pytest.mark.parametrize(("more", "accepted"), [
    ({}, True), ({"steps": 7}, True), ({"steps": 8}, False), ({"length": 0.0}, False),
    ({"length": -1.0}, False), ({"turned": 0.91}, True), ({"turned": 0.89}, False),
    ({"turned": -0.95}, True),  # a tangent has no direction of its own
    ({"beyond": [0.019, 0.0]}, True), ({"beyond": [0.0, 0.021]}, False),
    ({"before": 2.0, "after": 2.89}, True), ({"before": 2.0, "after": 2.91}, False),
    ({"before": -2.0, "after": -1.11}, True), ({"before": -2.0, "after": -1.09}, False),
    ({"before": 5.0, "after": 3.19}, False), ({"before": 5.0, "after": 3.21}, True),
    ({"before": 100.0, "after": 900.0}, True), ({"before": -100.0, "after": 900.0}, True),
    ({"before": 99.0, "after": 900.0}, False),
])  # fmt: skip
def test_a_step_resolves_a_branch_where_little_changes_on_it(more, accepted):
    """Newton's method is quick, the tangent hardly turns, impacts stay near, so does the trace.

    The trace may change by 0.3 (1 + |trace|), but where it is beyond 100.
    """
    given = {"steps": 2, "length": 5.0, "turned": 1.0, "beyond": [], "before": 0.5, "after": 0.5}
    told = {**given, **more}
    across = (1.0 - told["turned"] ** 2) ** 0.5
    before = at_value(720.0, trace=told["before"], tangent=[0.0, 0.0, 0.0, 2.0, 0.0], steps=9)
    after = at_value(
        725.0, trace=told["after"], tangent=[0.0, 0.0, 0.0, 3.0 * across, 3.0 * told["turned"]],
        steps=told["steps"],
    )  # fmt: skip
    metric = Metric(np.array([0.0, 0.0, 0.0, 1.0, 1.0]))
    step = BranchStep(before, UNIT, after, told["length"], metric)
    solver = Stub(beyond=lambda root: [(far, 0, 1) for far in told["beyond"]]
                  if root is after else [(9.0, 0, 1)])  # fmt: skip
    assert arclength._acceptable(solver, step) is accepted
