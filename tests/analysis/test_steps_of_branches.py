"""How branches are followed, joined and searched for, step by step, with solvers that are stubs."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from math import inf, pi
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.integrate import BudgetSpentError, Cost
from camcli.analysis.labels import CONTACT, Label
from camcli.analysis.orbits import (
    all_orbits,
    arclength,
    branch_segment,
    locate,
    search,
    single_impact,
    sticking_orbits,
    study,
)
from camcli.analysis.orbits.arclength import BranchStep, Metric, Span
from camcli.analysis.orbits.branch_segment import BranchSegment
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Crossing, Located
from camcli.analysis.orbits.shooter import Root
from camcli.analysis.orbits.sticking_orbits import MotionChange, StickingSegment
from camcli.analysis.orbits.study import Absence, Branch, Diagram, OrbitsQuestion
from camcli.errors import NoMachineError
from camcli.kernel.bordered import BLOCK, LEFT, RIGHT
from camcli.piece_faults import gathering

TURN = 2.0 * pi
SPAN = Span(700.0, 750.0, 5.0)


def root_of(impacts, value=700.0, **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    given = {
        "whole": whole, "turns": 2, "machine": (value,), "parameter": 0,
        "rates": [-2.0 * v for _, v, _, _ in impacts],
        "tangent": [0.0] * len(x) + [1.0], "trace": 0.5, "step": 0.0, "steps": 2,
    }  # fmt: skip
    return Root([*x, value], **{**given, **more})


def at_value(value: float, **more) -> Root:
    return root_of([(1.0, 0.5, 2, 0), (4.0, 0.25, 3, 1)], value, **more)


def event_at(value: float, kind=Kind.FOLD, **more) -> Located:
    return Located(kind, at_value(value), 0.5, 1e-9, Bracket.OK, **more)


def crossing_at(value: float, upward=True, corner="b", kink=False) -> Crossing:
    left, right = at_value(value), at_value(value, tangent=[0.0] * 4 + [2.0])
    return Crossing(left, right, 1, upward, corner, kink, [0.5, 1.5, 2.5, 3.5, -1.0])


@pytest.fixture
def diagram(monkeypatch) -> Diagram:
    """A diagram without branches; orbits are named by their roots."""
    monkeypatch.setattr(study, "from_root", lambda system, root: Stub(
        value=root.value, root=root, of=system, label="P", turns=root.turns
    ))  # fmt: skip
    return Diagram(Stub(system="system"), "settings", [study.Limit(745.0, "why")])


# -- diagrams


def test_both_ways_of_a_branch_are_one_from_the_lowest_point_up(diagram):
    """The root that both begin with is one point; an end at a limit is one of the machine."""
    down = BranchSegment([at_value(x) for x in (720.0, 710.0, 705.0)], end=Kind.FOLD)
    up = BranchSegment([at_value(x) for x in (720.0, 730.0, 745.0)], end=Kind.END_OF_RANGE)
    doubling, fold, corner = (
        event_at(710.0, Kind.PERIOD_DOUBLING), event_at(705.0), event_at(730.0, Kind.CORNER_IMPACT)
    )  # fmt: skip
    turned, passed = crossing_at(730.0), crossing_at(735.0, corner="c")
    down.events = [(doubling, None), (fold, None)]
    up.events = [(corner, turned), (event_at(735.0, Kind.CORNER_IMPACT), passed)]
    up.turned = turned
    impacts = []
    diagram._corner_impact = lambda crossing: impacts.append(crossing) or f"at {crossing.corner}"
    diagram.add_bouncing((down, up), "found")
    (branch,) = diagram.branches
    assert [point.value for point in branch.points] == [705.0, 710.0, 720.0, 730.0, 745.0]
    assert (branch.number, branch.origin, branch.ends) == (
        1, "found", (Kind.FOLD, Kind.NO_MACHINE),
    )  # fmt: skip
    told = [(e.branch, e.kind, e.value, e.corner, e.corner_impact) for e in diagram.bifurcations]
    assert told == [
        (1, Kind.PERIOD_DOUBLING, 710.0, "", None), (1, Kind.FOLD, 705.0, "", None),
        (1, Kind.CORNER_IMPACT, 730.0, "b", "at b"), (1, Kind.CORNER_IMPACT, 735.0, "c", "at c"),
    ]  # fmt: skip
    assert [event.located for event in diagram.bifurcations][:3] == [doubling, fold, corner]
    assert diagram.branch_points == [(0, doubling), (2, turned)]
    single = BranchSegment([at_value(745.0), at_value(741.0)], end=Kind.GRAZING)
    single.events = [(event_at(741.0, Kind.PERIOD_DOUBLING), None)]
    diagram.add_bouncing([single], "period-doubling")
    second = diagram.branches[1]
    assert [point.value for point in second.points] == [745.0, 741.0]
    assert (second.number, second.origin) == (2, "period-doubling")
    assert second.ends == ("period-doubling", Kind.GRAZING)
    assert diagram.bifurcations[4].branch == 2
    assert diagram.branch_points[2][0] == 4


def test_a_branch_that_rests_is_joined_from_both_ways_with_the_labels_beyond(monkeypatch, diagram):
    start = Stub(value=720.0, theta=(1.0,), label="P(1;2)")
    beyond = Stub(label="P(2;1:1)", theta=(2.0,))

    def follow_sticking(shooter, settings, orbit, span, up):
        assert (shooter, settings, orbit, span) == (diagram.shooter, "settings", start, SPAN)
        sign = 1.0 if up else -1.0
        points = [start, Stub(value=720.0 + 10.0 * sign), Stub(value=720.0 + 25.0 * sign)]
        change = MotionChange(
            Kind.DETACHMENT if up else Kind.ITINERARY, 720.0 + 21.0 * sign, 0.5 + sign / 4.0,
            points[1], beyond if up else None,
        )  # fmt: skip
        end = Kind.END_OF_RANGE if up else Kind.ITINERARY
        return StickingSegment(points, [change], end)

    monkeypatch.setattr(study, "follow_sticking", follow_sticking)
    monkeypatch.setattr(study, "_corner_of", lambda system, change: f"{system}, {change.value}")
    diagram._system_at = lambda value: f"machine at {value}"
    diagram.branches.append("another")
    diagram.add_sticking(start, SPAN)
    branch = diagram.branches[1]
    assert [point.value for point in branch.points] == [695.0, 710.0, 720.0, 730.0, 745.0]
    assert (branch.number, branch.origin) == (2, "found")
    assert branch.ends == (Kind.ITINERARY, Kind.NO_MACHINE)
    rows = [
        (e.branch, e.kind, e.value, e.error, e.status, e.orbit.value, e.corner, e.beyond)
        for e in diagram.bifurcations
    ]
    assert rows == [
        (2, Kind.ITINERARY, 699.0, 0.25, Bracket.OK, 710.0, "machine at 699.0, 699.0", ""),
        (2, Kind.DETACHMENT, 741.0, 0.75, Bracket.OK, 730.0, "machine at 741.0, 741.0", "P(2;1:1)"),
    ]  # fmt: skip


def test_the_corner_of_a_change_is_where_the_cam_is_left_on_one_side_only(monkeypatch):
    corners = [Stub(theta=x, name=name) for name, x in (("a", 1.0), ("b", 2.0), ("c", 3.0))]
    monkeypatch.setattr(study, "corner_list", lambda cam: corners if cam == "cam" else [])
    for here, there, name in (
        ((1.0, 2.0), (1.0, 5.0), "b"),
        ((1.0, 5.0), (1.0, 3.0), "c"),
        ((3.0, 1.0), (1.0 + 0.9e-6, 3.0), "a"),  # on both sides alike: the first one
        ((1.0, 2.0), (1.0 + 1.1e-6, 2.0), "a"),
        ((3.0 + 0.9e-6, 5.0), None, "c"),
        ((3.0 + 1.1e-6, 5.0), None, ""),
        ((2.0, 5.0), (2.0, 6.0), ""),
        ((2.0, 3.0), (), "b"),
    ):
        beyond = None if there is None else Stub(theta=there)
        change = MotionChange(Kind.DEPARTURE, 700.0, 0.1, Stub(theta=here), beyond)
        assert study._corner_of(Stub(cam="cam"), change) == name, (here, there)


def test_a_branch_holds_a_root_that_one_of_its_points_leads_to(monkeypatch, diagram):
    """Between two points of the branch, from either of them, if it has as many impacts."""
    answers = {}
    diagram.shooter.moved = lambda root, value: answers.get((root.value, value))
    monkeypatch.setattr(study, "same_orbit", lambda one, other: one.root.trace == other.root.trace)
    single = root_of([(1.0, 0.5, 2, 0)], 730.0)
    points = [Stub(value=x, root=at_value(x)) for x in (710.0, 720.0)]
    points += [Stub(value=730.0, root=single), Stub(value=740.0, root=None)]
    diagram.branches += [
        Branch(1, "found", (), ("", "")),
        Branch(2, "found", tuple(points), ("", "")),
    ]
    inside, same, other = at_value(715.0), at_value(715.0), at_value(715.0, trace=0.75)
    assert diagram.holds(inside) is False
    for first, second, holds in (
        (same, None, True), (other, same, True), (None, same, True), (other, other, False),
    ):  # fmt: skip
        answers.update({(710.0, 715.0): first, (720.0, 715.0): second})
        assert diagram.holds(inside) is holds
    answers.update({(720.0, 705.0): same, (720.0, 725.0): same, (730.0, 725.0): same})
    assert diagram.holds(at_value(705.0)) is False
    assert diagram.holds(at_value(725.0)) is True
    answers[720.0, 725.0] = None
    assert diagram.holds(at_value(725.0)) is False  # the other point has one impact
    answers[710.0, 710.0] = same
    assert diagram.holds(at_value(710.0)) is True


@pytest.mark.parametrize("case", ["new", "known", "no orbit", "one point", "spent"])
def test_a_branch_that_leaves_from_an_event_is_followed_once(monkeypatch, diagram, case):
    doubling, crossing = event_at(710.0, Kind.PERIOD_DOUBLING), crossing_at(730.0, upward=False)
    departures = {
        "event": (at_value(711.0), [1.0, 2.0]), "crossing": (crossing.left, crossing.ahead)
    }  # fmt: skip
    monkeypatch.setattr(
        study, "doubled", lambda of, at: departures["event"] if case != "no orbit" else None
    )
    roots = [at_value(x) for x in (711.0, 712.0, 713.0, 714.0, 716.0)]
    asked = []

    def follow(shooter, root, along, span):
        asked.append((root, along, span))
        return BranchSegment(roots[:1] if case == "one point" else roots, end=Kind.FOLD)

    def holds(root):
        assert root is roots[2]
        if case == "spent":
            raise BudgetSpentError
        return case == "known"

    monkeypatch.setattr(study, "follow", follow)
    diagram.holds = holds
    for kind in (Kind.FOLD, Kind.PERIOD_DOUBLING, Kind.CORNER_IMPACT):
        diagram._add_bifurcation(1, event_at(700.0, kind), None, False)
    diagram.branches += ["another", "and one more"]
    diagram.switch(1, doubling, SPAN)
    is_new = case in ("new", "spent")
    assert asked == ([] if case == "no orbit" else [(*departures["event"], SPAN)])
    assert len(diagram.branches) == 2 + is_new
    assert [event.continues for event in diagram.bifurcations] == [0, 3 if is_new else 0, 0]
    diagram.switch(2, crossing, SPAN)
    assert asked[-1] == (*departures["crossing"], SPAN)
    if is_new:
        assert diagram.branches[2].origin == Kind.PERIOD_DOUBLING
        assert diagram.branches[3].origin == Kind.CORNER_IMPACT
        assert [event.continues for event in diagram.bifurcations] == [0, 3, 4]


def test_a_corner_impact_is_studied_once_for_both_branches_that_end_in_it(monkeypatch, diagram):
    studied = []

    def corner_impact(shooter, crossing, settings):
        assert (shooter, settings) == (diagram.shooter, "settings")
        studied.append(crossing)
        if crossing.corner == "spent":
            raise BudgetSpentError
        if crossing.corner == "none":
            raise NoMachineError("none")
        return f"study {len(studied)}"

    monkeypatch.setattr(study, "corner_impact", corner_impact)
    first = crossing_at(730.0)
    single = replace(first, left=root_of([(1.0, 0.5, 2, 0)], 730.0))
    told = [diagram._corner_impact(one) for one in (
        first, crossing_at(730.0 + 1e-9), crossing_at(730.0 + 1e-7), crossing_at(730.0, corner="c"),
        single, first,
    )]  # fmt: skip
    assert told == ["study 1", "study 1", "study 2", "study 3", "study 4", "study 1"]
    assert diagram._corner_impact(crossing_at(730.0, corner="spent")) is None
    assert diagram._corner_impact(crossing_at(730.0, corner="none")) is None


def test_the_branch_through_an_orbit_is_followed_unless_it_is_there(monkeypatch):
    added = []
    shooter = Stub(
        value=715.0, moved=lambda root, value: answers.get(root.value) and at_value(value)
    )
    one = Stub(
        shooter=shooter, holds=lambda root: held, add_bouncing=lambda *of: added.append(of),
        add_sticking=lambda *of: added.append(of),
    )  # fmt: skip
    monkeypatch.setattr(study, "both_ways", lambda *of: ("both ways", *of))
    answers, held = {700.0: True}, False
    study._follow_one(one, Stub(root=at_value(700.0)), SPAN)
    assert added == [(("both ways", shooter, at_value(715.0), SPAN), "found")]
    study._follow_one(one, Stub(root=at_value(701.0)), SPAN)  # it is not solved there
    held = True
    study._follow_one(one, Stub(root=at_value(700.0)), SPAN)
    assert len(added) == 1
    resting = study.PeriodicOrbit(
        700.0, 3.0, 1, (inf,), (1.0,), (), ((0.1, 0.2),), (), 0.0, 0.0, 0, None
    )
    study._follow_one(one, resting, SPAN)
    assert added[1:] == [(replace(resting, value=715.0), SPAN)]


# -- studies


def test_curves_are_followed_from_the_events_that_no_other_curve_leads_through(monkeypatch):
    """Of the kind asked for; a curve that leads through an event may have been followed later."""
    followed = []
    through = {}  # events by the curve that leads through them

    def curve(system, located, plane, label, corner):
        assert (system, plane) == ("system", "plane")
        followed.append((located.root.value, label, corner))
        if located.root.value == 704.0:
            raise BudgetSpentError
        if located.root.value == 705.0:
            raise NoMachineError("none")
        points = () if located.root.value == 702.0 else ("point",)
        return Stub(located=located, points=points, value=located.root.value)

    def passes(system, known, located, plane):
        assert (system, plane) == ("system", "plane")
        if located.root.value == 709.0:
            raise BudgetSpentError
        return located.root.value in through.get(known.value, ())

    monkeypatch.setattr(study, "curve", curve)
    monkeypatch.setattr(study, "passes", passes)

    def event(value, kind=Kind.FOLD, label="P(1;1)", corner=""):
        located = None if value == 708.0 else event_at(value, kind)
        return Stub(kind=kind, located=located, label=label, corner=corner, value=value)

    events = [
        event(701.0), event(702.0), event(703.0), event(703.0, Kind.GRAZING), event(704.0),
        event(705.0), event(701.0 + 1e-8), event(706.0), event(708.0), event(709.0),
        event(701.0, label="P(1;2)"), event(701.0, corner="b"),
    ]  # fmt: skip
    question = OrbitsQuestion(700.0, curve="fold", plane="plane")
    through[703.0] = [706.0, 702.0]
    found = study._curves("system", events, question)
    assert followed == [
        (701.0, "P(1;1)", ""), (702.0, "P(1;1)", ""), (703.0, "P(1;1)", ""), (704.0, "P(1;1)", ""),
        (705.0, "P(1;1)", ""), (709.0, "P(1;1)", ""), (701.0, "P(1;2)", ""), (701.0, "P(1;1)", "b"),
    ]  # fmt: skip
    assert [one.value for one in found] == [701.0, 703.0, 709.0, 701.0, 701.0]
    through[703.0] = []
    kept = [one.value for one in study._curves("system", events, question)]
    assert kept == [701.0, 702.0, 703.0, 706.0, 709.0, 701.0, 701.0]
    assert study._curves("system", events, replace(question, plane=None)) == []


def test_what_is_asked_of_all_orbits_is_told_of_all_orbits(monkeypatch):
    def every(shooter, rpm, impacts, turns, tick):
        assert (rpm, impacts, turns, tick) == (745.0, 3, 2, "tick")
        return Stub(orbits=["one", "two"], of=shooter)

    monkeypatch.setattr(study, "Shooter", lambda *of: Stub(value=of[1], cost=Cost(5, 6, 7)))
    monkeypatch.setattr(all_orbits, "all_orbits", every)
    question = OrbitsQuestion(745.0, all_of=(3, 2))
    for found in (
        study._every("system", question, (3, 2), "tick"),
        study.orbits("system", None, question, "tick"),
    ):
        assert (found.question, found.value, found.orbits) == (question, 745.0, ["one", "two"])
        assert found.every.orbits is found.orbits
        assert found.cost == Cost(5, 6, 7)
        nothing = found.virtual, found.branches, found.bifurcations, found.curves, found.continua
        assert nothing == ([],) * 5


def test_a_label_is_looked_for_at_the_nearest_speeds_first(monkeypatch):
    """Of 24 over the range asked for, or a fifth around; its branch is followed to the speed."""
    tried, reached = [], []
    settles_at = 0.0
    label = Label((1.0, 1.0))

    def find(system, speed, settings, starts, of_label, most):
        assert (system, settings, starts, of_label, most) == ("system", "settings", 8, label, 8)
        tried.append(speed)
        return Stub(orbits=["orbit", "other"] if speed >= settles_at else [])

    def reach(system, settings, orbit, rpm):
        assert (system, settings, orbit) == ("system", "settings", "orbit")
        return Stub(value=rpm if reached else 707.5), "fold"

    monkeypatch.setattr(study, "find", find)
    monkeypatch.setattr(study, "_reach", reach)
    monkeypatch.setattr(study, "spend", lambda work: None)
    settles_at = 790.0
    asked = OrbitsQuestion(705.0, span=Span(690.0, 805.0, 5.0))
    found = study._absence("system", "settings", asked, label)
    assert found == Absence(705.0, 690.0, 805.0, "orbit", (707.5, "fold"), None)
    assert tried[:5] == pytest.approx([705.0, 700.0, 710.0, 695.0, 715.0])
    assert tried[-1] == pytest.approx(790.0)
    reached.append(True)
    found = study._absence("system", "settings", asked, label)
    assert found.nearest == (705.0, "fold")
    assert found.reached.value == 705.0
    settles_at = inf
    tried.clear()
    for other in (replace(asked, parameter="mass"), replace(asked, span=None)):
        around = study._absence("system", "settings", other, label)
        assert around == Absence(705.0, pytest.approx(564.0), pytest.approx(846.0))
    assert len(tried) == 48
    assert min(tried) == pytest.approx(564.0)
    assert max(tried) == pytest.approx(846.0)

    def spent(work):
        raise BudgetSpentError

    monkeypatch.setattr(study, "spend", spent)
    assert study._absence("system", "settings", asked, label) is None


@pytest.mark.parametrize("rpm", [690.0, 730.0])
@pytest.mark.parametrize("rests", [False, True])
def test_of_a_branch_the_orbit_of_the_label_nearest_to_a_speed_is_taken(monkeypatch, rpm, rests):
    up = rpm > 710.0
    ways = [0.0, 5.0, 12.0, 16.0]
    values = [710.0 + way if up else 710.0 - way for way in ways]
    labels = ["P(1;1)", "P(1;1)", "P(1;1)", "P(1;2)"]
    span = Span(min(rpm, 710.0), max(rpm, 710.0), 20.0 / 24)
    monkeypatch.setattr(study, "Shooter", lambda *of: of)
    orbits = [Stub(value=x, label=label) for x, label in zip(values, labels, strict=True)]
    monkeypatch.setattr(study, "from_root", lambda system, root: orbits[root])

    def follow(shooter, root, ahead, of_span):
        assert (shooter, root.value, of_span) == (("system", 710.0), 710.0, span)
        assert (ahead[-1] > 0.0) is up
        assert [abs(x) for x in ahead] == [1.0, 2.0, 3.0, 4.0, 0.5]
        return Stub(points=range(4), end="fold")

    def follow_sticking(shooter, settings, orbit, of_span, upward):
        assert (shooter, settings, of_span) == (("system", 710.0), "settings", span)
        assert upward is up
        return Stub(points=orbits, end="fold")

    monkeypatch.setattr(study, "follow", follow)
    monkeypatch.setattr(study, "follow_sticking", follow_sticking)
    for sign in (1.0, -1.0):
        tangent = [sign * x for x in (1.0, -2.0, 3.0, 4.0, 0.5)]
        root = None if rests else at_value(710.0, tangent=tangent)
        orbit = Stub(rpm=710.0, label="P(1;1)", root=root)
        assert study._reach("system", "settings", orbit, rpm) == (orbits[2], "fold")


# -- events on steps


@pytest.mark.parametrize("side", [1, -1])
def test_a_crossing_has_the_same_orbit_on_both_sides_of_a_corner(monkeypatch, side):
    """Through the end of the turn: the last of three stretches is followed by the first one."""
    stretch, behind = (2, 0) if side > 0 else (0, 2)
    before = root_of([(1.0, 0.5, 1, 0), (0.0, 0.25, stretch, 1)])
    asked = []

    def at_corner(root, k, of_side):
        asked.append((root, k, of_side))
        return replace(root, tangent=[1.0, -2.0, 3.0, 4.0, -5.0])

    jumps = [0.0, 0.0, 0.0]
    cam = Stub(stretches=[Stub(slope_jump=jump) for jump in jumps])
    monkeypatch.setattr(
        locate, "corner_list", lambda cam: [Stub(stretch=1, name="b"), Stub(stretch=0, name="a")]
    )
    shooter = Stub(system_of=lambda root: Stub(cam=cam), at_corner=at_corner)
    event = Located(Kind.CORNER_IMPACT, before, 0.0, 0.0, Bracket.OK, 1, side)
    found = locate.cross(shooter, event)
    assert asked == [(before.landing_on(1, behind, 1 + side), 1, -side)]
    far = replace(asked[0][0], tangent=[1.0, -2.0, 3.0, 4.0, -5.0])
    assert (found.left, found.right) == ((before, far) if side > 0 else (far, before))
    assert (found.impact, found.upward, found.corner, found.kink) == (1, side > 0, "a", False)
    assert found.ahead == [side * x for x in far.tangent]
    assert found.far == far
    assert found.turns_back  # the parameter's parts of the tangents have different signs
    cam.stretches[0].slope_jump = 0.5
    assert locate.cross(shooter, event).kink
    shooter.at_corner = lambda *of: None
    assert locate.cross(shooter, event) is None


@pytest.mark.parametrize("vector", [(1.0, 0.5), (-0.25, 3.0), (2.0, 0.0)])
def test_the_direction_of_a_doubling_is_turned_round_by_one_period(monkeypatch, vector):
    """Three flights by any L and R whose product has the eigenvector given, of -1."""
    generator = np.random.default_rng(4)
    lefts = list(generator.normal(size=(3, 2, 2)))
    rights = [np.array([[a, 0.0], [b, 1.0]]) for a, b in ((0.5, -2.0), (-1.5, 0.25), (0.75, 3.0))]
    maps = [-np.linalg.inv(r) @ left for left, r in zip(lefts, rights, strict=True)]
    across = np.array([-vector[1], vector[0]])
    basis = np.column_stack([vector, across])
    period = basis @ np.array([[-1.0, 0.75], [0.0, 0.3]]) @ np.linalg.inv(basis)
    maps[2] = period @ np.linalg.inv(maps[1] @ maps[0])
    lefts[2] = -rights[2] @ maps[2]

    def fill_block(cam, const, x, whole, turns, k, n, blocks):
        assert (cam, x, whole, turns, n) == ("cam", root.x, root.whole, 2, 3)
        blocks[BLOCK * k + LEFT : BLOCK * k + RIGHT] = list(lefts[k].ravel())
        blocks[BLOCK * k + RIGHT : BLOCK * k + RIGHT + 4] = list(rights[k].ravel())

    root = Stub(
        count=3, const="const", x=[1.0, 2.0], whole=(1, 0), turns=2, stretch=None, turn=None
    )
    monkeypatch.setattr(locate, "fill_block", fill_block)
    shooter = Stub(system_of=lambda of: Stub(cam="cam"))
    expected = [np.array(vector)]
    for one in maps[:2]:
        expected.append(one @ expected[-1])
    flat = np.concatenate(expected)
    largest = max(abs(flat[::2]))
    found = np.array(locate._flip_vector(shooter, root))
    sign = np.sign(found[0] * flat[0])
    assert found == pytest.approx(sign * flat / largest)


@pytest.mark.parametrize("found", ["at once", "from before", "not at all"])
def test_the_first_corner_on_a_step_is_where_its_impact_is_at_the_end(monkeypatch, found):
    """Impact 1 is beyond its end, impact 0 before its start: the nearer one counts."""
    before, after = at_value(700.0), at_value(710.0)
    metric = Metric(np.array([0.0, 0.0, 0.0, 0.0, 1.0]))
    step = BranchStep(before, np.array([0.0, 0.0, 0.0, 0.0, 1.0]), after, 10.0, metric)
    places = {(1, 1): 706.0, (0, -1): 703.0}
    beside = at_value(702.0)

    def at_corner(root, k, side):
        if found == "at once" or (found == "from before" and root is beside):
            return at_value(places[k, side])
        return at_value(715.0) if (k, side) == (1, 1) else None  # none, or not on the step

    monkeypatch.setattr(locate, "_before_corner", lambda of, at, k, side: beside)
    tested = []

    def bracketed(shooter, root, test):
        tested.append(test(replace(root, x=[1.25, 0.5, 4.5, 0.25, root.value])))
        return locate.Certainty(0.125 * len(tested), Bracket.OK)

    monkeypatch.setattr(locate, "_bracket", bracketed)
    shooter = Stub(
        at_corner=at_corner, beyond=lambda root: [(0.1, 1, 1), (0.2, 0, -1)],
        edge=lambda root, k, side: {(1, 1): 4.0, (0, -1): 1.5}[k, side],
    )  # fmt: skip
    event = locate.corner_on(shooter, step)
    if found == "not at all":
        assert event == Located(Kind.CORNER_IMPACT, beside, 2.0, 8.0, Bracket.UNRESOLVED, 1, 1)
        return
    assert event == Located(Kind.CORNER_IMPACT, at_value(703.0), 3.0, 0.25, Bracket.OK, 0, -1)
    assert tested == [0.5, -0.25]
    shooter.beyond = lambda root: []
    assert locate.corner_on(shooter, step) is None


# -- branches of orbits that rest


def test_what_happens_where_an_orbit_that_rests_goes_over_into_another():
    def orbit(symbols, label="P", free=False):
        return Stub(symbols=symbols, turns=len(symbols), label=label, free=free)

    chatters, twice, rests = orbit((inf, 1.0)), orbit((inf, inf, 1.0)), orbit((0.0,), CONTACT)
    for last, after, kind in (
        (orbit((0.0,), free=True), chatters, Kind.GRAZING),
        (orbit((0.0,), CONTACT, free=True), None, Kind.GRAZING),
        (rests, chatters, Kind.DETACHMENT),
        (chatters, rests, Kind.DETACHMENT),
        (rests, None, Kind.DETACHMENT),
        (chatters, orbit((2.0, 1.0)), Kind.CHATTER_COMPLETION),
        (chatters, None, Kind.CHATTER_COMPLETION),
        (orbit((1.0,)), None, Kind.ITINERARY),
        (chatters, twice, Kind.ITINERARY),  # more often, per turn
        (twice, chatters, Kind.CHATTER_COMPLETION),  # once in two turns for twice in three
        (chatters, orbit((inf, 3.0)), Kind.ITINERARY),
    ):
        assert sticking_orbits._kind(last, after) == kind, (last, after)


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("beyond", ["another", None])
def test_a_change_is_bracketed_between_the_last_orbit_and_what_is_behind_it(
    monkeypatch, up, beyond
):
    """The motion changes 1/3 of the way from 0 to 2, or to -2; its place is known to rounding."""
    sign = 1.0 if up else -1.0
    last = Stub(value=0.0, name="last", free=False)

    def orbit_at(shooter, settings, orbit, value):
        assert orbit is last
        if sign * value < 2.0 / 3.0:
            return Stub(value=value, name="same")
        return None if beyond is None else Stub(value=value, name=beyond)

    monkeypatch.setattr(sticking_orbits, "_orbit_at", orbit_at)
    monkeypatch.setattr(
        sticking_orbits, "_settled_on", lambda *of: Stub(value=of[3], name="settled")
    )
    monkeypatch.setattr(sticking_orbits, "_kind", lambda one, other: (one.name, other.name))
    same = lambda one, other: other is not None and other.name == "same"  # noqa: E731
    change = sticking_orbits._change(Stub(scale=0.5), "settings", last, sign * 2.0, same)
    assert change.value == pytest.approx(sign * 2.0 / 3.0, abs=1e-11)
    assert sign * change.value <= 2.0 / 3.0
    assert 0.0 < change.error < 1e-11
    assert change.orbit.value == change.value
    assert 0.0 < sign * (change.beyond.value - change.value) <= change.error
    assert change.kind == ("same", beyond or "settled")


@pytest.mark.parametrize("free", [True, False])
def test_an_orbit_at_another_value_is_that_of_the_machine_there(monkeypatch, free):
    monkeypatch.setattr(
        sticking_orbits, "with_machine", lambda system, machine: (machine, machine[1] * 10.0)
    )
    orbit = Stub(free=free, states=[(0.3, 0.1)], turns=3)
    found = []

    def free_orbit(system, rpm):
        assert (system, rpm) == (("at", 7.0), 70.0)
        return found[0]

    monkeypatch.setattr(sticking_orbits, "free_orbit", free_orbit)
    monkeypatch.setattr(sticking_orbits, "_settled_on", lambda *of: ("settled", *of))
    shooter = Stub(system="system", at=lambda value: ("at", value))
    if not free:
        told = sticking_orbits._orbit_at(shooter, "settings", orbit, 7.0)
        assert told == ("settled", shooter, "settings", orbit, 7.0)
        return
    found[:] = [study.PeriodicOrbit(70.0, 1.0, 1, (0.0,), (), (), ((0.1, 0.2),), (), 0.0, 0.0, 0)]
    told = sticking_orbits._orbit_at(shooter, "settings", orbit, 7.0)
    assert told == replace(found[0], value=7.0)
    found[:] = [None]
    assert sticking_orbits._orbit_at(shooter, "settings", orbit, 7.0) is None


@pytest.mark.parametrize(("turns", "longest"), [(3, 8), (11, 11)])
@pytest.mark.parametrize("above", [True, False])
def test_what_a_run_settles_on_begins_with_the_state_of_the_orbit_nearby(
    monkeypatch, turns, longest, above
):
    """If that lies above the cam of the machine there, else at rest on it."""
    cam = Stub(strobe=1, stretches=[Stub(start_c=9.0), Stub(start_c=0.25)])
    system = Stub(cam=cam)
    monkeypatch.setattr(sticking_orbits, "with_machine", lambda *of: (system, 70.0))
    monkeypatch.setattr(sticking_orbits, "Start", Stub(at_strobe=lambda *of: of[1:]))
    monkeypatch.setattr(sticking_orbits, "with_turns", lambda *of: of)
    simulated = []
    orbit = study.PeriodicOrbit(1.0, 1.0, 1, (inf,), (), (), ((0.1, 0.2),), (), 0.0, 0.0, 0)
    answer = [orbit]

    def identify(of_system, rpm, record, most):
        assert (of_system, rpm, record, most) == (system, 70.0, "record", longest)
        return answer[0]

    monkeypatch.setattr(sticking_orbits, "identify", identify)
    shooter = Stub(
        system="system", at=lambda value: value,
        simulate=lambda *of: simulated.append(of) or "record",
    )  # fmt: skip
    state = (0.26 if above else 0.25, 0.1)
    near = Stub(states=[state, (0.1, 9.0)], turns=turns)
    found = sticking_orbits._settled_on(shooter, "settings", near, 7.0)
    assert found == replace(orbit, rpm=70.0, value=7.0)
    run = ("settings", 40, 2 * longest + 2)
    assert simulated == [(system, 70.0, run, (70.0, state if above else None))]
    answer[0] = None
    assert sticking_orbits._settled_on(shooter, "settings", near, 7.0) is None


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize(
    ("leaves", "ends", "values"),
    [
        (None, None, [2, 4, 6, 8, 10]),
        (5.0, None, [2, 4, "departs", 6, 8, 10]),
        (None, 7.0, [2, 4, 6, "ends"]),
        (3.0, 7.0, [2, "departs", 4, 6, "ends"]),
    ],
)
def test_a_branch_that_rests_is_followed_until_its_motion_changes(
    monkeypatch, up, leaves, ends, values
):
    """In steps of 2 to the end of the range; where only departures change it goes on."""
    sign = 1.0 if up else -1.0
    behind_bracket = [None]

    def orbit_at(shooter, settings, last, value):
        way = sign * (value - 710.0)
        motion = "other" if ends is not None and way > ends else "own"
        departures = 2 if leaves is not None and way > leaves else 1
        return Stub(value=value, symbols=motion, resting=True, theta=range(departures))

    def change(shooter, settings, last, value, same):
        is_motion = same is sticking_orbits._same_motion
        word = "ends" if is_motion else "departs"
        kind = Kind.DETACHMENT if is_motion else Kind.ITINERARY
        orbit = Stub(value=word, symbols="own", resting=True, theta=last.theta)
        return MotionChange(kind, value, 0.1, orbit, behind_bracket[0])

    monkeypatch.setattr(sticking_orbits, "_orbit_at", orbit_at)
    monkeypatch.setattr(sticking_orbits, "_change", change)
    start = Stub(value=710.0, symbols="own", resting=True, theta=range(1), label="P")
    span = Span(700.0, 720.0, 2.1)
    found = sticking_orbits.follow_sticking("shooter", "settings", start, span, up)
    told = [point.value for point in found.points]
    expected = [x if isinstance(x, str) else pytest.approx(710.0 + sign * x) for x in values]
    assert told == [710.0, *expected]
    assert found.end == (Kind.DETACHMENT if ends is not None else Kind.END_OF_RANGE)
    kinds = [Kind.DEPARTURE] * (leaves is not None) + [Kind.DETACHMENT] * (ends is not None)
    assert [one.kind for one in found.changes] == kinds
    if leaves is not None:  # what is behind it is the next orbit where the bracket tells none
        behind = sign * (found.changes[0].beyond.value - 710.0)
        assert behind == pytest.approx(leaves + 1.0)
    behind_bracket[0] = "told"
    again = sticking_orbits.follow_sticking("shooter", "settings", start, span, up)
    assert [one.beyond for one in again.changes] == ["told"] * len(kinds)
    for error, end in (
        (BudgetSpentError, Kind.WORK_BUDGET),
        (NoMachineError("x"), Kind.NO_MACHINE),
    ):

        def refused(*of, error=error):
            raise error

        monkeypatch.setattr(sticking_orbits, "_orbit_at", refused)
        stopped = sticking_orbits.follow_sticking("shooter", "settings", start, span, up)
        assert (stopped.points, stopped.end) == ([start], end)


# -- steps along a branch

METRIC = Metric(np.array([0.25, 0.5, 2.0]))


def one_impact(theta, v, value, **more) -> Root:
    return root_of([(theta, v, 2, 0)], value, **more)


def test_a_step_is_solved_across_its_direction_from_the_line_between_its_ends():
    before, after = one_impact(1.0, 2.0, 3.0), one_impact(3.0, 1.0, 7.0, whole=(2, 0))
    unit = np.array([0.5, -0.25, 1.0])
    asked = []
    shooter = Stub(correct=lambda *of: asked.append(of) or "root")
    assert BranchStep(before, unit, after, 4.0, METRIC).at(shooter, 1.0) == "root"
    ((guess, whole, turns, row, origin, length),) = asked
    assert list(guess) == [1.5, 1.75, 4.0]
    assert (whole, turns, origin, length) == ((2, 0), 2, before.x, 1.0)
    assert list(row) == [0.125, -0.125, 2.0]
    BranchStep(before, unit, after, 0.0, METRIC).at(shooter, 0.0)
    assert list(asked[1][0]) == before.x


@pytest.mark.parametrize(("value", "length", "share", "per"), [
    (704.0, 2.0, 1.0, 1.0), (709.0, 2.0, 0.5, 1.0), (701.0, -2.0, 0.5, 1.0),
    (709.0, 8.0, 0.25, 0.5), (701.0, 0.25, 0.5, -8.0),
])  # fmt: skip
def test_a_step_that_would_leave_the_range_ends_at_its_bound(value, length, share, per):
    """The parameter changes by `per` for each unit of length; the range is from 700 to 710."""
    span = Span(700.0, 710.0, 1.0)
    unit = np.array([0.5, -0.25, per])
    root = one_impact(1.0, 2.0, value)
    asked = []

    def answer(x):
        return one_impact(x[0] + 0.25, x[1], x[2])

    shooter = Stub(
        correct=lambda *of: asked.append(of) or answer(of[0]),
        at_value=lambda *of: asked.append(of) or answer(of[0]),
    )
    step = arclength._corrected(shooter, root, unit, METRIC, length, span)
    guess = root.x + share * length * unit
    assert list(asked[0][0]) == pytest.approx(list(guess))
    assert asked[0][1:3] == ((2, 0), 2)
    assert step.after.x == pytest.approx([guess[0] + 0.25, guess[1], guess[2]])
    assert (step.before, step.metric) == (root, METRIC)
    if share == 1.0:
        assert list(asked[0][3]) == [0.125, -0.125, 2.0]
        assert (asked[0][4], asked[0][5], step.length) == (root.x, length, length)
        beyond = Stub(correct=lambda *of: one_impact(1.0, 2.0, 710.5))
        assert arclength._corrected(beyond, root, unit, METRIC, length, span) is None
    else:
        assert asked[0][3] == (700.0 if length * per < 0.0 else 710.0)
        # along the direction: 0.25 * 0.5 * dtheta + ...
        moved = np.subtract(step.after.x, root.x)
        along = 0.125 * moved[0] - 0.125 * moved[1] + 2.0 * per * moved[2]
        assert step.length == pytest.approx(along)
    none = Stub(correct=lambda *of: None, at_value=lambda *of: None)
    assert arclength._corrected(none, root, unit, METRIC, length, span) is None


def test_steps_grow_where_they_are_solved_quickly_and_are_halved_where_not(monkeypatch):
    """None is longer than the spacing, a tenth of the range."""
    metric = Metric(np.array([0.0, 0.0, 1.0]))
    start = one_impact(1.0, 2.0, 0.0)
    tried = []
    too_long, slow, share = [0.03], [False], [1.0]

    def corrected(shooter, root, unit, of_metric, length, span):
        tried.append((root.value, length, unit[-1]))
        if length > too_long[0]:
            return None
        length = share[0] * length  # what a bound leaves of it
        after = one_impact(1.0, 2.0, root.value + length * unit[-1], steps=5 if slow[0] else 4)
        return BranchStep(root, unit, after, length, of_metric)

    monkeypatch.setattr(arclength, "_corrected", corrected)
    monkeypatch.setattr(arclength, "_acceptable", lambda shooter, step: step.length != 0.025)
    along = np.array([0.0, 0.0, -3.0])
    made = arclength.steps("shooter", start, along, metric, Span(0.0, 20.0, 2.0))
    first = next(made)
    assert [length for _, length, _ in tried] == [0.1, 0.05, 0.025, 0.0125]
    assert {way for *_, way in tried} == {-1.0}
    too_long[0] = 1.0
    second = next(made)  # the first step was quick
    assert (second.before, second.length) == (first.after, 0.0125 * 1.6)
    slow[0] = True
    lengths = [step.length for step in islice(made, 3)]
    assert lengths[:2] == pytest.approx([0.0125 * 1.6**2, 0.0125 * 1.6**2])
    slow[0] = False
    lengths = [step.length for step in islice(made, 6)]
    assert max(lengths) == lengths[-1] == 0.1
    share[0] = 0.5
    lengths = [step.length for step in islice(made, 3)]
    assert lengths == pytest.approx([0.05, 0.8 * 0.05, 0.8**2 * 0.05])
    too_long[0] = 0.0
    tried.clear()
    assert list(made) == [None]
    assert 0.5e-10 < tried[-1][1] / 2.0 < 1e-10 <= tried[-1][1]


def test_a_branch_goes_on_the_way_it_came_where_it_turns_round(monkeypatch):
    """Its direction turns by 1 rad from point to point, and the tangents have any sign."""
    ways = []

    def corrected(shooter, root, unit, metric, length, span):
        ways.append(tuple(unit))
        angle = float(len(ways))
        sign = (-1.0) ** len(ways)
        tangent = [sign * 3.0 * np.cos(angle), 0.0, sign * 3.0 * np.sin(angle)]
        return BranchStep(root, unit, one_impact(1.0, 2.0, 5.0, tangent=tangent), length, metric)

    monkeypatch.setattr(arclength, "_corrected", corrected)
    monkeypatch.setattr(arclength, "_acceptable", lambda shooter, step: True)
    start = one_impact(1.0, 2.0, 5.0, tangent=[-2.0, 0.0, 0.0])
    metric = Metric(np.array([1.0, 1.0, 1.0]))
    made = arclength.steps("shooter", start, np.array([1.0, 0.0, 0.0]), metric, SPAN)
    assert len(list(islice(made, 7))) == 7
    assert ways == [pytest.approx((np.cos(k), 0.0, np.sin(k))) for k in range(7)]


@pytest.mark.parametrize("begins", [True, False])
@pytest.mark.parametrize("rising", [1.0, -1.0])
def test_a_branch_is_followed_down_and_up_from_a_root(monkeypatch, rising, begins):
    root = one_impact(1.0, 2.0, 700.0, tangent=[3.0 * rising, 4.0 * rising, 5.0 * rising])
    doubling = event_at(700.0, Kind.PERIOD_DOUBLING) if begins else None
    other = (event_at(710.0), None)
    monkeypatch.setattr(branch_segment, "doubling_at", lambda shooter, of: doubling)

    def follow(shooter, of, along, span, begins_doubling):
        assert (shooter, of, span, begins_doubling) == ("shooter", root, SPAN, begins)
        return BranchSegment([of], [other], end=tuple(along))

    monkeypatch.setattr(branch_segment, "follow", follow)
    down, up = branch_segment.both_ways("shooter", root, SPAN)
    assert (down.end, up.end) == ((-3.0, -4.0, -5.0), (3.0, 4.0, 5.0))
    assert down.events == [other]
    assert up.events == ([(doubling, None), other] if begins else [other])


def test_a_branch_closes_where_a_step_passes_its_first_point_again():
    """Ahead, no farther than the step, and nearer than a tenth of it to the line along the step."""
    metric = Metric(np.array([1.0, 1.0, 1.0]))
    unit = np.array([1.0, 0.0, 0.0])
    for along, across, points, whole, closes in (
        (0.25, 0.0, 5, (2, 0), True),
        (0.5, 0.0, 5, (2, 0), True),
        (0.5001, 0.0, 5, (2, 0), False),
        (0.0, 0.0, 5, (2, 0), False),
        (-0.25, 0.0, 5, (2, 0), False),
        (0.25, 0.0, 4, (2, 0), False),
        (0.25, 0.0, 5, (3, 0), False),
        (0.25, 0.049, 5, (2, 0), True),
        (0.25, -0.049, 5, (2, 0), True),
        (0.25, 0.051, 5, (2, 0), False),
    ):
        first = one_impact(1.0 + along, 2.0 + across, 3.0)
        before = one_impact(1.0, 2.0, 3.0)
        after = one_impact(1.5, 2.0, 3.0, whole=whole)
        segment = BranchSegment([first, *[after] * (points - 1)])
        step = BranchStep(before, unit, after, 0.5, metric)
        assert branch_segment._closes(segment, step) is closes, (along, across, points, whole)


# -- orbits of one impact, and close returns


@pytest.mark.parametrize(("rate", "admits"), [(0.5, True), (0.5, False), (-0.5, True)])
def test_of_a_dwell_of_orbits_the_one_in_its_middle_is_asked(monkeypatch, rate, admits):
    """From 6 rad to 1 rad in the next turn, and from 3 to 4 rad."""
    dwells = [single_impact.Continuum(3, 6.0, TURN + 1.0, rate),
              single_impact.Continuum(3, 3.0, 4.0, 0.25)]  # fmt: skip
    equation = Stub(dwells=lambda: dwells, of_stretch=lambda i: Stub(r=0.5 + i / 8.0))
    monkeypatch.setattr(single_impact, "_Equation", lambda *of: equation)
    monkeypatch.setattr(single_impact, "stretch_at", lambda cam, theta: 1 if theta > 2.75 else 2)
    asked = []

    def is_motion(root):
        asked.append(root)
        return admits

    shooter = Stub(
        system=Stub(cam="cam"), at=lambda value: ("machine", value), parameter=4,
        seat=frozenset({2}), admits=is_motion,
    )  # fmt: skip
    found = list(single_impact.continua(shooter, 7.0, 3))
    assert found == [dwell for dwell in dwells if dwell.rate > 0.0 and admits]
    middle = (7.0 - TURN) / 2.0
    assert len(asked) == (2 if rate > 0.0 else 1)
    wanted = [(middle, 2, rate, 0.75), (3.5, 1, 0.25, 0.625)][-len(asked) :]
    for root, (theta, stretch, v, r) in zip(asked, wanted, strict=True):
        assert root.x == pytest.approx([theta, v, 7.0])
        assert (root.whole, root.turns, root.machine) == ((stretch, 0), 3, ("machine", 7.0))
        assert root.rates == pytest.approx([-v / r])
        assert (root.parameter, root.trace, root.seat) == (4, 2.0, frozenset({2}))


def test_a_dwell_of_orbits_is_a_region_at_one_level_on_which_their_equation_holds(monkeypatch):
    """A region that rises, or has any acceleration, is none; h is zero but for rounding."""
    level = {"start_c1": 0.0, "accel_min": 0.0, "accel_max": 0.0}
    changed = [{}, {}, {"start_c1": 0.5}, {"accel_min": -1.0}, {"accel_max": 1.0}, {}, {}, {}]
    stretches = [Stub(start=k + 0.5, **{**level, **other}) for k, other in enumerate(changed)]
    groups = [(1,), (0, 2), (2,), (3,), (4,), (5,), (6,), (7, 0)]
    ends = [Stub(start=k + 0.25, end=k + 0.75, stretches=group) for k, group in enumerate(groups)]
    monkeypatch.setattr(single_impact, "regions", lambda cam: ends if cam is equation.cam else [])
    # one by rounding, one of either sign that is not
    heights = {1: 1.9e-15, 5: 2.1e-15, 6: -2.1e-15, 7: -1.9e-15}
    equation = Stub(
        focused=False, cam=Stub(stretches=stretches), turns=3,
        _terms=lambda i, theta: Stub(h=heights.get(i, 0.0) if theta == i + 0.5 else 1.0, size=2.0),
        rate=lambda i, theta: 8.0 * i + theta,
    )  # fmt: skip
    dwells = single_impact._Equation.dwells
    assert dwells(equation) == [
        single_impact.Continuum(3, 0.25, 0.75, 9.5),
        single_impact.Continuum(3, 7.25, 7.75, 63.5),
    ]
    equation.focused = True
    assert dwells(equation) == []


def test_orbits_of_one_impact_are_those_solved_at_the_zeros_of_their_equation(monkeypatch):
    """On two stretches; left out is what a dwell holds, and what is not solved, or elsewhere."""
    zeros = [[0.5, 1.0, 1.5], [2.0, 2.5, 3.0, 3.5, 4.0]]
    off = {0.5: 9e-7, 1.5: -9e-7, 2.0: 1.1e-6, 2.5: None, 3.0: -1.1e-6, 3.5: 0.5, 4.0: 0.0}
    dwells = [single_impact.Continuum(3, 6.0, 6.1, 0.5), single_impact.Continuum(3, 0.9, 1.1, 0.5)]
    equation = Stub(
        dwells=lambda: dwells, roots=lambda i: iter(zeros[i]),
        rate=lambda i, theta: 8.0 * i + theta,
    )  # fmt: skip
    of = []
    monkeypatch.setattr(single_impact, "_Equation", lambda *given: (of.append(given), equation)[1])
    solved = []

    def at_value(guess, whole, turns, value):
        theta = guess[0]
        i = whole[0]
        assert (guess, whole) == ([theta, 8.0 * i + theta, 7.0], (i, 0))
        assert (turns, value, theta in zeros[i]) == (3, 7.0, True)
        if off[theta] is None:
            return None
        solved.append(one_impact(theta + off[theta], 2.0, value))
        return solved[-1]

    shooter = Stub(system=Stub(cam=Stub(stretches=zeros)), at_value=at_value, value=8.0)
    found = single_impact.single_impact_roots(shooter, 7.0, 3)
    assert of == [(shooter, 7.0, 3)]
    assert [root.theta[0] for root in found] == [0.5 + 9e-7, 1.5 - 9e-7, 4.0]


def test_orbits_of_one_impact_are_added_with_their_verdicts(monkeypatch):
    monkeypatch.setattr(search, "continua", lambda *of: [("continuum", *of[1:])])
    monkeypatch.setattr(search, "single_impact_roots", lambda *of: [("root", *of[1:]), "other"])
    monkeypatch.setattr(search, "from_root", lambda *of: of)
    added = []
    result = Stub(continua=["known"], add=added.append)
    shooter = Stub(system="system", verdict=lambda root: (len(root), 7, 8.0))
    search._add_single_impacts(result, shooter, 745.0, 3)
    assert result.continua == ["known", ("continuum", 745.0, 3)]
    assert added == [("system", ("root", 745.0, 3), 3), ("system", "other", 5)]


def test_close_returns_have_the_symbols_of_the_label_in_any_turn_first(monkeypatch):
    """Of a record of six turns; each window has its own impacts and its distance."""
    states = np.array([(k, 0.5) for k in range(6)])
    symbols = [1.0, 2.0, 1.0, 1.0, 2.0, 3.0]
    monkeypatch.setattr(search, "sections", lambda record: (states, symbols))
    impacts = [search.RecordedImpact(k, 0.1 * k, -0.2) for k in (0, 1, 1, 2, 3, 4, 4, 5)]

    def impacts_of(record, turns):
        assert turns == range(6)
        return impacts

    def close_returns(of, turns, size, within):
        assert (of is states, turns, size, within) == (True, 2, "size", 0.3)
        return np.array([0, 1, 2, 3]), np.array([0.1, 0.2, 0.25, 0.3])

    monkeypatch.setattr(search, "impacts_of", impacts_of)
    monkeypatch.setattr(search, "size_of", lambda of: "size" if of == states.tolist() else None)
    monkeypatch.setattr(search, "close_returns", close_returns)
    record = Stub(periods=6)
    found = list(search._close_returns(record, Label((2.0, 1.0))))
    assert found == [
        (0.1, impacts[0:3]), (0.2, impacts[1:4]), (0.3, impacts[4:7]),
    ]  # fmt: skip
    assert list(search._close_returns(record, Label((1.0,) * 6))) == []


class Way:
    """A branch of steps with names: what `_advance` and `twice_on` say of each is given."""

    def __init__(self, monkeypatch, walks, **answers):
        self.walks = iter(walks)  # the names of the steps from each root on, None for no step
        self.begun, self.taken = [], []
        self.answers = answers  # by the name of a step or of a part of it: a crossing, or an end
        self.twice: set[str] = set()
        self.closing: set[str] = set()
        monkeypatch.setattr(branch_segment, "steps", self.steps)
        monkeypatch.setattr(branch_segment, "twice_on", lambda of, step: self.between(step))
        monkeypatch.setattr(branch_segment, "_advance", self.advance)
        monkeypatch.setattr(branch_segment, "_closes", lambda to, step: step.name in self.closing)

    def between(self, step):
        return f"root on {step.name}" if step.name in self.twice else None

    def steps(self, shooter, root, along, metric, span):
        self.begun.append((root.value, list(along)))
        for name in next(self.walks):
            yield (
                None
                if name is None
                else Stub(
                    name=name,
                    cut=lambda root, name=name: Stub(name=f"{name} up to the {root}"),
                    rest=lambda root, name=name: Stub(name=f"{name} from the {root}"),
                )
            )

    def advance(self, shooter, segment, step, span):
        self.taken.append(step.name)
        answer = self.answers.get(step.name.replace(" ", "_"))
        if isinstance(answer, Kind):
            segment.close(answer)
            return None
        return answer


def test_a_branch_is_followed_step_by_step_until_it_ends(monkeypatch):
    """A step on which an event happens twice is taken in two parts, as far as the first leads."""
    start, along = at_value(720.0), [0.0, 0.0, 0.0, 0.0, 1.0]

    def followed(walks, twice=(), closing=(), root=start, heading=1.0, points=1, **answers):
        way = Way(monkeypatch, walks, **answers)
        way.twice.update(twice)
        way.closing.update(closing)
        segment = BranchSegment([root] * points)
        direction = [heading * x for x in along]
        branch_segment._follow(segment, "shooter", root, direction, SPAN)
        return way.begun, way.taken, segment.end

    here = [(720.0, along)]
    assert followed([["a", "b", None]]) == (here, ["a", "b"], Kind.LOST)
    assert followed([["a", "b", "c"]], b=Kind.GRAZING) == (here, ["a", "b"], Kind.GRAZING)
    assert followed([["a", "b", "c"]], closing="b") == (here, ["a", "b"], Kind.CLOSED)
    parts = ["b up to the root on b", "b from the root on b"]
    assert followed([["a", "b", None]], twice="b") == (here, ["a", *parts], Kind.LOST)
    ends = {"b_up_to_the_root_on_b": Kind.FOLD}
    assert followed([["a", "b", None]], twice="b", **ends) == (here, ["a", parts[0]], Kind.FOLD)
    crossing = replace(crossing_at(735.0, upward=False), right=at_value(736.0))
    again = [*here, (735.0, crossing.ahead)]
    for twice, of, taken in (("", "b", ["b"]), ("b", parts[0], parts[:1]), ("b", parts[1], parts)):
        answers = {of.replace(" ", "_"): crossing}
        found = followed([["b", "c"], ["d", None]], twice=twice, **answers)
        assert found == (again, [*taken, "d"], Kind.LOST)
    # at an end of the range it goes inwards only
    for value, heading, stops in (
        (750.0, 1.0, True), (750.0, -1.0, False), (700.0, -1.0, True), (700.0, 1.0, False),
    ):  # fmt: skip
        found = followed([["a", None]], root=at_value(value), heading=heading)
        assert found[2] == (Kind.END_OF_RANGE if stops else Kind.LOST)
        assert found[1] == ([] if stops else ["a"])
    # 30 points for each of the ten spacings of the range
    assert followed([["a", None]], points=300)[1] == ["a"]
    assert followed([["a", None]], points=301)[1] == []


def test_a_branch_that_is_not_followed_to_its_end_says_why(monkeypatch):
    root = at_value(720.0)
    for error, end in ((BudgetSpentError, Kind.WORK_BUDGET), (ValueError, Kind.FAULT)):

        def refused(segment, *of, error=error):
            segment.points.append("a point before")
            assert of == ("shooter", root, "along", SPAN)
            raise error

        monkeypatch.setattr(branch_segment, "_follow", refused)
        with gathering() as faults:
            segment = branch_segment.follow("shooter", root, "along", SPAN, True)
        assert (segment.points, segment.end) == ([root, "a point before"], end)
        assert segment.begins_doubling
        names = ["the branch of 2 impacts in 2 turns from 720 on"] * (end == Kind.FAULT)
        assert [fault.piece for fault in faults] == names
