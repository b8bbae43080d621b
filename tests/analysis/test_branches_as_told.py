"""What a branch says of itself: turning points, stable ranges, and the ranges of a study.

A branch is written down as its points: values of the parameter, `s` or `u` behind each for stable
and unstable.
"""

from __future__ import annotations

from types import SimpleNamespace as Stub

import pytest

from camcli.analysis.integrate import BudgetSpentError, Cost
from camcli.analysis.orbits import atlas, branch_segment, study
from camcli.analysis.orbits.branch_segment import Span
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.study import (
    Absence,
    Branch,
    Limit,
    OrbitsQuestion,
    OrbitsResult,
    _follow_all,
    _speeds_asked,
    _with_machines,
)
from camcli.errors import NoMachineError


def branch_of(points: str, number: int = 2) -> Branch:
    made = [Stub(value=float(word[:-1]), stable=word[-1] == "s", label="P") for word in
            points.split()]  # fmt: skip
    return Branch(number, "found", tuple(made), ("lost", "lost"))


@pytest.mark.parametrize(
    ("points", "turns"),
    [
        ("1s 2s 3s", []),
        ("1s 3s 2s", [3.0]),
        ("3s 1s 2s", [1.0]),
        ("1s 3s 2s 4s", [3.0, 2.0]),
        ("1s 3s 3u 2s", [3.0]),  # an orbit on each side of a corner
        ("1s 2s 2u 3s", []),
        ("1s 3s", []),
        ("1s 3s 2s 3.000000001s 1s", [3.0, 2.0, 3.000000001]),
    ],
)
def test_where_a_branch_turns_round(points, turns):
    assert branch_of(points).turning_points == turns


def test_two_turns_at_one_value_are_none():
    """At a corner whose two orbits differ in the last digits; a billionth is the limit."""
    assert branch_of("1s 3s 2.999999999s 4s").turning_points == []
    assert len(branch_of("1s 3s 2.99999999s 4s").turning_points) == 2


RANGES = [  # points, events of the branch, values at which it is the other branch, what is told
    ("1s 2s 3s", [], [], [(1.0, 3.0)]),
    ("1u 2u", [], [], []),
    ("1u 2s 3s 4u", [], [], [(2.0, 3.0)]),
    ("1u 2u 3s 4s 5u", [2.0, 5.0], [], [(2.0, 5.0)]),  # up to the events beside it
    ("1u 2s 3u 4s 5u", [2.0, 4.0], [], [(2.0, 2.0), (4.0, 4.0)]),
    ("1s 2u 3s", [2.0], [], [(1.0, 3.0)]),  # rounding decided at the event
    ("1s 2u 3u", [2.0], [], [(1.0, 2.0)]),
    ("1u 2u 3s", [2.0], [], [(2.0, 3.0)]),
    ("1s 2u 3s", [], [], [(1.0, 1.0), (3.0, 3.0)]),
    ("1s 2s 3u", [], [0.5], [(0.5, 2.0)]),  # from where it was born
    ("1u 2s 3s", [], [0.5], [(2.0, 3.0)]),
    ("3s 2s 1u", [1.0], [3.5], [(1.0, 3.5)]),
    ("1s 2.000000001u 3u", [2.0], [], [(1.0, 2.0)]),  # the event's own value
    ("1s 2.00000001u 3u", [2.0], [], [(1.0, 1.0)]),
    ("1u 2s", [1.0], [], [(1.0, 2.0)]),
    ("2s 1u", [1.0], [], [(1.0, 2.0)]),
]


@pytest.mark.parametrize(("points", "events", "births", "told"), RANGES)
def test_where_a_branch_is_stable(points, events, births, told):
    """Events of other branches do not count."""
    happened = [Stub(branch=2, value=value, continues=0) for value in events]
    happened += [Stub(branch=1, value=value, continues=2) for value in births]
    happened += [Stub(branch=3, value=value, continues=3) for value in (1.0, 2.0, 3.0)]
    branch = branch_of(points)
    assert branch.stable_ranges(happened) == told
    for indices, ends in branch.stable_stretches(happened):
        values = [branch.points[k].value for k in indices]
        assert ends[0] <= min(values) + 1e-8
        assert max(values) - 1e-8 <= ends[1]


def result_of(limits: list[float], value: float = 5.0) -> OrbitsResult:
    question = OrbitsQuestion(rpm=700.0, span=Span(1.0, 9.0, 0.1))
    return OrbitsResult(question, value, [], [], [], [], [], Cost(),
                        limits=tuple(Limit(x, "because") for x in limits))  # fmt: skip


@pytest.mark.parametrize(
    ("limits", "reach"),
    [([], (1.0, 9.0)), ([2.0], (2.0, 9.0)), ([8.0], (1.0, 8.0)), ([2.0, 8.0], (2.0, 8.0)),
     ([5.0], (5.0, 9.0)), ([3.0, 2.0, 7.0, 8.0], (3.0, 7.0))],
)  # fmt: skip
def test_how_far_there_are_machines(limits, reach):
    assert result_of(limits).reach == reach


@pytest.mark.parametrize(
    ("why", "limits"),
    [(("", ""), []), (("a", ""), [(2.0, "a")]), (("", "b"), [(8.0, "b")]),
     (("a", "b"), [(2.0, "a"), (8.0, "b")])],
)  # fmt: skip
def test_a_range_is_cut_to_where_there_are_machines(why, limits):
    ends = {1.0: (2.0 if why[0] else 1.0, why[0]), 9.0: (8.0 if why[1] else 9.0, why[1])}
    family = Stub(reach=ends.__getitem__)
    span, found = _with_machines(Stub(family=family), Span(1.0, 9.0, 0.1))
    assert (span.low, span.high, span.spacing) == (ends[1.0][0], ends[9.0][0], 0.1)
    assert [(limit.value, limit.reason) for limit in found] == limits


def test_a_range_stays_whole_where_nothing_is_known_of_its_machines():
    def spent(value):
        raise BudgetSpentError

    span = Span(1.0, 9.0, 0.1)
    for family in (None, Stub(reach=spent)):
        assert _with_machines(Stub(family=family), span) == (span, ())


@pytest.mark.parametrize(
    ("span", "parameter", "asked"),
    [(Span(1.0, 9.0, 0.1), "rpm", (1.0, 9.0)), (Span(1.0, 9.0, 0.1), "mass", None),
     (None, "rpm", None)],
)  # fmt: skip
def test_which_speeds_were_asked_for(span, parameter, asked):
    assert _speeds_asked(OrbitsQuestion(rpm=5.0, span=span, parameter=parameter)) == asked


@pytest.mark.parametrize(("most", "switched"), [(0, 0), (1, 2), (2, 4), (9, 5)])
def test_so_many_branches_are_followed_beside_those_through_orbits(monkeypatch, most, switched):
    """An event whose branch is known already adds none, but is told all the same."""
    done: list[tuple] = []
    orbits = [Stub(resting=False, label=name) for name in "ab"]

    def follow(diagram, orbit, span):
        diagram.branches.append(orbit.label)

    def switch(index, event, span):
        done.append((index, event))
        if index % 2:  # every second one leads to another branch
            diagram.branches.append(event)

    events = [Stub(kind="fold", value=float(k)) for k in range(5)]
    diagram = Stub(branches=[], bifurcations=events, switch=switch,
                   branch_points=[(k, f"e{k}") for k in range(5)])  # fmt: skip
    monkeypatch.setattr(study, "_follow_one", follow)
    monkeypatch.setattr(study, "piece", lambda name, work: work())
    ticks: list[int] = []
    _follow_all(diagram, orbits, Span(1.0, 9.0, 0.1), most, lambda: ticks.append(1))
    assert done == [(k, f"e{k}") for k in range(switched)]
    assert len(ticks) == 2 + switched


ABSENT = Absence(5.0, 1.0, 9.0)
NEAR_BY = Stub(rpm=6.0, stable=True)


@pytest.mark.parametrize(
    ("absent", "span", "orbits", "rpm", "told"),
    [
        (ABSENT, True, [], 5.0, True),
        (Absence(5.0, 1.0, 9.0, NEAR_BY), True, [NEAR_BY], 6.0, True),
        (Absence(5.0, 1.0, 9.0, NEAR_BY), False, [], 5.0, True),  # no range: nothing is followed
        (Absence(5.0, 1.0, 9.0, NEAR_BY, None, "it"), True, ["it"], 5.0, False),
        (None, True, [], 5.0, False),
    ],
)
def test_a_label_that_is_elsewhere_is_followed_from_there(
    monkeypatch, chapter, absent, span, orbits, rpm, told
):
    """Where a range of speeds was asked for; what the search alone had missed is there."""
    followed: list = []
    found = Stub(orbits=[], continua=[], virtual=[], cost=Cost())
    stubs = {
        "find": lambda *given: found, "_absence": lambda *given: absent,
        "_follow_all": lambda diagram, orbits, span, *more: followed.append((list(orbits), span)),
        "_curves": lambda *given: [], "piece": lambda name, work: work(),
    }  # fmt: skip
    for name, stub in stubs.items():
        monkeypatch.setattr(study, name, stub)
    asked = Span(1.0, 9.0, 0.1) if span else None
    question = OrbitsQuestion(rpm=5.0, span=asked, label="P(1;1)")
    result = study.orbits(chapter, Stub(transient=10), question)
    assert (result.orbits, result.question.rpm, result.value) == (orbits, rpm, rpm)
    assert (result.absent is not None) == told
    assert followed == ([(orbits, asked)] if span else [])


@pytest.mark.parametrize(("stable", "kept"), [(True, ["s"]), (False, ["u"]), (None, ["s", "u"])])
def test_orbits_are_kept_by_their_stability(monkeypatch, chapter, stable, kept):
    some = [Stub(stable=True, name="s"), Stub(stable=False, name="u")]
    found = Stub(orbits=list(some), continua=[], virtual=[], cost=Cost())
    monkeypatch.setattr(study, "find", lambda *given: found)
    question = OrbitsQuestion(rpm=5.0, stable=stable)
    result = study.orbits(chapter, Stub(transient=10), question)
    assert [one.name for one in result.orbits] == kept


@pytest.mark.parametrize("parent", ["the doubling", None])
def test_a_branch_that_goes_back_beyond_its_birth_ends_there(monkeypatch, parent):
    """At the doubling where it was born, which is looked for within two steps, or at none."""
    asked: list[tuple] = []

    def parent_of(shooter, event, within):
        asked.append((event.root.value, event.reach, within))
        return parent

    monkeypatch.setattr(branch_segment, "parent_of", parent_of)
    step = Stub(before=Stub(value=740.0), after=Stub(value=739.0), length=0.3)
    segment = branch_segment.BranchSegment()
    branch_segment._born(None, segment, step)
    assert asked == [(739.0, 0.3, 2.0)]
    assert segment.end == Kind.PERIOD_DOUBLING
    assert segment.events == ([(parent, None)] if parent else [])


@pytest.mark.parametrize(
    ("failing", "followed"),
    [((), [0, 1, 2, 3, 4]), ((0, 3), [1, 2, 4]), ((0, 1, 2, 3, 4), [])],
    ids=["none", "two", "all"],
)
@pytest.mark.parametrize("without", [(), (2,), (0, 1, 2, 3, 4)], ids=["all", "four", "no machine"])
def test_an_edge_of_a_map_is_searched_where_it_can_be(monkeypatch, failing, followed, without):
    """At five places of a range from 0 to 100; a place that fails, or has no machine, is left."""
    places = [2.0, 27.0, 50.0, 73.0, 98.0]
    branches: list[float] = []
    ends: list[int] = []

    def at(first, second):
        assert second == 7.0
        if places.index(pytest.approx(first)) in without:
            raise NoMachineError("no machine")
        return Stub(value=first), 700.0

    def find(system, *more):
        return Stub(orbits=[Stub(label="P(1;1)", at=system.value)], cost=Cost(1, 0, 0))

    def piece(name, work):
        failed = name.startswith("the orbits") and any(
            name.endswith(f"= {places[k]:.6g}") for k in failing)  # fmt: skip
        return None if failed else work()

    stubs = {
        "Shooter": lambda *given: Stub(cost=Cost(0, 1, 0)), "find": find, "piece": piece,
        "_EdgeDiagram": lambda *given: Stub(bifurcations=["an event"]),
        "_follow_branch": lambda diagram, orbit, span: branches.append(orbit.at),
        "_follow_from_events": lambda diagram, branches, span: ends.append(branches),
    }  # fmt: skip
    for name, stub in stubs.items():
        monkeypatch.setattr(atlas, name, stub)
    plane = Stub(ranges=((0.0, 100.0), (0.0, 7.0)), names=("a", "b"))
    drawn = Stub(plane=plane, cost=Cost())
    found = atlas._events_on(at, None, drawn, atlas.Edge(0, 7.0), 3)
    here = [k for k in followed if k not in without]
    assert branches == pytest.approx([places[k] for k in here])
    assert drawn.cost == (len(here), len(here), 0)
    assert (found, ends) == ((["an event"], [3]) if len(without) < 5 else ([], []))
