"""What is told of a change between two speeds: its cause, what lives on, the search for a crisis.

The events of the branches and the search for a crisis are written down here; all fields of what is
told of a change are compared.
"""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.explain import changes
from camcli.analysis.explain.changes import CriticalEvent, Events, Limits, explain
from camcli.analysis.explain.crisis import Crisis, CrisisKind, MetSaddle
from camcli.analysis.integrate import BudgetSpentError, Cost
from camcli.analysis.orbits.locate import Crossing
from camcli.cams.regions import Corner
from camcli.errors import Status
from camcli.kernel.orbit_loop import DETACHMENT, IMPACT
from camcli.piece_faults import gathering

CHAOS, UNKNOWN = "aperiodic", "undecided"
OWN = Cost(impacts=3, evaluations=5, crossings=7)  # of the events
OF_SEARCH = Cost(impacts=20, evaluations=30, crossings=40)
EVENT = CriticalEvent(790.0, 0.25, "fold", "P(9;1)")  # beyond all changes


def motion(rpm: float, label: str, width: float = 0.5, status=Status.OK):
    """A motion of a label, whose impacts lie in a range of phases; periodic ones have an orbit."""
    theta = np.linspace(1.0, 1.0 + width, 20)
    record = SimpleNamespace(
        kind=np.full(20, IMPACT), theta=theta, u=-(theta**3), period=np.arange(20)
    )
    periodic = label not in (CHAOS, UNKNOWN)
    orbit = SimpleNamespace(label=label, resting=False, theta=(1.0,)) if periodic else None
    return SimpleNamespace(rpm=rpm, label=label, chatter="none", record=record, orbit=orbit,
                           period=1, status=status)  # fmt: skip


def branch(label: str, low: float, high: float, stable: bool = True):
    """Orbits of a label at every rpm of a range."""
    rpms = np.arange(low, high + 1.0)
    points = [SimpleNamespace(value=rpm, label=label, stable=stable) for rpm in rpms]
    return SimpleNamespace(points=points)


def crisis_of(kind: CrisisKind, near: float, met=(), corner=None) -> Crisis:
    return Crisis(kind, 704.0, 0.125, (703.0, 705.0), near, 1000, OF_SEARCH, corner, met=met)


@pytest.fixture
def told(monkeypatch):
    """What is told of some motions, with these branches, and searches that find this."""
    searched: list[tuple[float, float]] = []

    def of(motions, branches=(), found=None, limits=changes.USUAL_LIMITS):
        searched.clear()

        def search(system, settings, near, far):
            searched.append((near, far))
            if isinstance(found, Exception):
                raise found
            return crisis_of(*found) if isinstance(found, tuple) else found

        events = Events([EVENT], [], list(branches), OWN)
        monkeypatch.setattr(changes, "find_events", lambda *asked: events)
        monkeypatch.setattr(changes, "find_crisis", search)
        return explain(None, None, motions, limits=limits), searched

    return of


def every_field(one, **wanted) -> None:
    """All fields of the only change; what is not given is as it is usually."""
    usual = {"low": 700.0, "high": 710.0, "events": (), "persists": (), "crisis": None,
             "may_search": True, "status": Status.OK}  # fmt: skip
    wanted = {**usual, **wanted}
    assert sorted(wanted) == sorted(field.name for field in fields(one))
    assert {name: getattr(one, name) for name in wanted} == wanted


@pytest.mark.parametrize(
    ("branches", "persists", "cause"),
    [
        ([branch("P(1;1)", 690.0, 720.0), branch("P(1;2)", 690.0, 720.0)],
         ("P(1;1)", "P(1;2)"), "basin"),
        ([branch("P(1;1)", 700.0, 710.0)], ("P(1;1)",), "basin"),
        ([branch("P(1;1)", 700.0, 709.0)], (), "unexplained"),
        ([branch("P(1;1)", 701.0, 720.0)], (), "unexplained"),
        ([branch("P(1;1)", 690.0, 720.0, stable=False)], (), "unexplained"),
        ([branch("P(1;2)", 690.0, 720.0)], ("P(1;2)",), "basin"),
        ([], (), "unexplained"),
    ],
)  # fmt: skip
def test_an_orbit_that_attracts_on_both_sides_leaves_the_start_to_its_basin(
    told, branches, persists, cause
):
    found, searched = told([motion(700.0, "P(1;1)"), motion(710.0, "P(1;2)")], branches)
    (change,) = found.changes
    every_field(change, before="P(1;1)", after="P(1;2)", cause=cause, persists=persists)
    assert searched == []
    assert (found.events, found.bifurcations, found.cost) == ([EVENT], [], OWN)
    assert found.status == Status.OK


@pytest.mark.parametrize(
    ("after", "far"), [(motion(710.0, CHAOS, 0.2), 700.0), (motion(710.0, "P(1;1)"), 710.0)]
)
def test_chaos_is_carried_from_where_it_is_alone_or_narrower(told, after, far):
    """To the other speed; a crisis that met something is the cause."""
    met = (MetSaddle(SimpleNamespace(label="P(3;1:1:1)"), 704.0, 0.125),)
    near = 710.0 if far == 700.0 else 700.0
    corner = Corner("b", 2.5, 3)
    crisis = crisis_of(CrisisKind.BOUNDARY, near, met, corner)
    always = [branch("P(1;1)", 690.0, 720.0)]
    found, searched = told([motion(700.0, CHAOS, 0.6), after], always, crisis)
    event = CriticalEvent(704.0, 0.125, CrisisKind.BOUNDARY, "chaos, P(3;1:1:1)", "b",
                          source=crisis)  # fmt: skip
    (change,) = found.changes
    persists = () if after.label == CHAOS else ("P(1;1)",)
    every_field(change, before=CHAOS, after=after.label, cause="boundary-crisis", events=(event,),
                persists=persists, crisis=crisis)  # fmt: skip
    assert searched == [(near, far)]
    assert found.events == [event, EVENT]
    assert found.cost == OWN + OF_SEARCH


@pytest.mark.parametrize(
    ("kind", "cause"),
    [
        (CrisisKind.STAYS, "basin"),
        (CrisisKind.NOT_CHAOTIC, "unexplained"),
        (CrisisKind.UNEXPLAINED, "unexplained"),
    ],
)
def test_a_search_that_met_nothing(told, kind, cause):
    """Chaos that ends beside a stable orbit is no change of basins, unless it is seen to live."""
    always = [branch("P(1;1)", 690.0, 720.0)]
    found, _ = told([motion(700.0, CHAOS), motion(710.0, "P(1;1)")], always, (kind, 700.0))
    (change,) = found.changes
    every_field(change, before=CHAOS, after="P(1;1)", cause=cause, persists=("P(1;1)",),
                crisis=crisis_of(kind, 700.0))  # fmt: skip
    assert found.events == [EVENT]


@pytest.mark.parametrize(
    ("kind", "searches"),
    [(CrisisKind.UNEXPLAINED, 2), (CrisisKind.STAYS, 4), (CrisisKind.NOT_CHAOTIC, 4)],
)
def test_so_many_searches_are_made_that_find_a_change(told, kind, searches):
    """Of four changes; those in which nothing leaves do not count."""
    labels = [CHAOS, "P(1;1)", CHAOS, "P(1;1)", CHAOS]
    motions = [motion(700.0 + 10.0 * k, label) for k, label in enumerate(labels)]
    found, searched = told(motions, (), (kind, 700.0), Limits(crises=2))
    assert len(searched) == searches
    assert [change.may_search for change in found.changes] == [k < searches for k in range(4)]
    assert found.cost.impacts == OWN.impacts + searches * OF_SEARCH.impacts


def test_what_is_undecided_is_left_out_between_two_that_are_known(told):
    """At an end of the range, or with trouble of its own, it is one of the two."""
    unknown, bad = motion(705.0, UNKNOWN), motion(705.0, UNKNOWN, status=Status.IMPACT_BUDGET)
    one, other = motion(700.0, "P(1;1)"), motion(710.0, "P(1;2)")
    always = [branch("P(1;1)", 690.0, 720.0)]
    for motions, pairs in (
        ([other, unknown, one], [("P(1;1)", "P(1;2)")]),
        ([one, bad, other], [("P(1;1)", UNKNOWN), (UNKNOWN, "P(1;2)")]),
        ([one, motion(710.0, UNKNOWN)], [("P(1;1)", UNKNOWN)]),
        ([one, motion(705.0, "P(1;1)"), other], [("P(1;1)", "P(1;2)")]),
    ):
        found, _ = told(motions, always)
        assert [(change.before, change.after) for change in found.changes] == pairs
        causes = ["unexplained" if UNKNOWN in pair else "basin" for pair in pairs]
        assert [change.cause for change in found.changes] == causes


@pytest.mark.parametrize(
    ("error", "status"),
    [(BudgetSpentError(), Status.WORK_BUDGET), (ZeroDivisionError("none"), Status.FAULT)],
)
def test_a_search_that_does_not_end(told, error, status):
    with gathering() as faults:
        found, _ = told([motion(700.0, CHAOS), motion(710.0, "P(1;1)")], (), error)
    (change,) = found.changes
    every_field(change, before=CHAOS, after="P(1;1)", cause="unexplained", status=status)
    told_of = [one.piece for one in faults]
    assert told_of == (["the change from 700.0 to 710.0 rpm"] if status == Status.FAULT else [])


def test_each_change_is_ticked(told, monkeypatch):
    told([motion(700.0, "P(1;1)"), motion(710.0, "P(1;2)")])
    ticks = []
    motions = [motion(700.0 + k, f"P(1;{k})") for k in (1, 2, 2, 3)]
    explain(None, None, motions, on_change=lambda: ticks.append(1))
    assert len(ticks) == 2


class Followed:
    """A diagram that notes which branches are asked for."""

    shooter = "shooter"

    def __init__(self, *events, known=()):
        """events: (turns, event, of an attractor); known: roots that it has branches of."""
        self.bifurcations, self.branch_points = [None], []  # the first one has no branch point
        for turns, event, attracts in events:
            orbit = SimpleNamespace(turns=turns, stable=attracts)
            kind = SimpleNamespace(orbit=orbit, kind="graze", value=700.0, left=None, right=None)
            self.bifurcations.append(kind)
            self.branch_points.append((len(self.bifurcations) - 1, event))
        self.known, self.spans, self.left = known, [], []

    def holds(self, root):
        return root in self.known

    def switch(self, index, event, span):
        self.left.append((index, event, span))


def motion_of(rpm, impacts, root):
    orbit = root and SimpleNamespace(root=root, impacts=impacts, rpm=rpm, label="P")
    return SimpleNamespace(rpm=rpm, impacts=impacts, orbit=orbit)


def test_branches_are_followed_from_orbits_of_few_impacts_first(monkeypatch):
    """Through the whole range up to four impacts, four spacings to either side with more."""
    diagram = Followed(known=("known",))
    monkeypatch.setattr(
        changes, "_add_branch", lambda _, root, span: diagram.spans.append((root, span))
    )
    motions = [
        motion_of(690.0, 5, "five"), motion_of(680.0, 1, None), motion_of(670.0, 4, "four"),
        motion_of(661.0, 5, "at the end"), motion_of(675.0, 2, "known"),
        motion_of(660.0, 4, "first of four"), motion_of(700.0, 6, "too many"),
    ]  # fmt: skip
    span = changes.Span(660.0, 760.0, 2.0)
    changes._follow(diagram, motions, span, Limits(seeds=4, leaving=9))
    assert diagram.spans == [
        ("first of four", span),
        ("four", span),
        ("at the end", changes.Span(660.0, 669.0, 9.0 / 40.0)),
        ("five", changes.Span(682.0, 698.0, 16.0 / 40.0)),
    ]


def test_branches_leave_at_events_of_attractors_that_have_a_label_beyond():
    """What doubles from 32 turns has 64, as many as a label may have."""
    crossing = Crossing("left", "right", 0, True, "", False, [])
    diagram = Followed(
        (1, "a", True), (32, "b", True), (33, "c", True), (1, crossing, True), (1, "d", False),
        (2, "e", True), (3, "f", True),
    )  # fmt: skip
    changes._follow(diagram, [], "span", Limits(seeds=4, leaving=3))
    assert diagram.left == [(1, "a", "span"), (2, "b", "span"), (6, "e", "span")]


def resting(rpm: float, label: str, theta=(1.0,), rests: bool = True):
    """A motion of an orbit that rests, and leaves the cam at these phases."""
    one = motion(rpm, label)
    one.orbit = SimpleNamespace(label=label, resting=rests, theta=theta, turns=1)
    return one


@pytest.mark.parametrize("order", [1, -1])
def test_the_end_of_a_rest_explains_a_change_from_either_side(told, monkeypatch, order):
    """The orbit that rests is followed to the other speed; what it comes to last is told.

    Where both rest, the slower one is followed first. Contact without an end, an orbit of impacts
    alone and chaos are not followed. Each orbit has a speed of its own.
    """
    asked = []
    ends: dict[str, list] = {}

    def follow(shooter, settings, orbit, span, up):
        asked.append((shooter, orbit.label, (span.low, span.high, span.spacing), up))
        return SimpleNamespace(changes=ends.get(orbit.label, []))

    monkeypatch.setattr(changes, "follow_sticking", follow)
    monkeypatch.setattr(changes, "Shooter", lambda system, rpm: rpm)
    first, last = (SimpleNamespace(kind=kind, value=value, error=error) for kind, value, error in (
        ("departure", 702.0, 0.5), ("itinerary", 706.0, 0.25),
    ))  # fmt: skip
    whole = (700.0, 710.0, 10.0)

    def explained(slow, fast):
        asked.clear()
        (change,) = told([slow, fast][::order])[0].changes
        return change, list(asked)

    def event_of(source, label):
        return CriticalEvent(source.value, source.error, source.kind, label, source=source)

    ends["P(1;inf)"] = [first, last]
    free = motion(710.0, "P(1;1)")
    change, followed = explained(resting(700.0, "P(1;inf)"), free)
    assert followed == [(700.0, "P(1;inf)", whole, True)]
    every_field(change, before="P(1;inf)", after="P(1;1)", cause="itinerary",
                events=(event_of(last, "P(1;inf)"),))  # fmt: skip
    change, followed = explained(motion(700.0, CHAOS), resting(710.0, "P(1;inf)"))
    assert followed == [(710.0, "P(1;inf)", whole, False)]
    every_field(change, before=CHAOS, after="P(1;inf)", cause="itinerary",
                events=(event_of(last, "P(1;inf)"),))  # fmt: skip
    both = resting(700.0, "P(2;inf:1)"), resting(710.0, "P(1;inf)")
    change, followed = explained(*both)
    assert [row[1] for row in followed] == ["P(2;inf:1)", "P(1;inf)"]
    assert change.events == (event_of(last, "P(1;inf)"),)
    ends["P(2;inf:1)"] = [first]
    change, followed = explained(*both)
    assert followed == [(700.0, "P(2;inf:1)", whole, True)]
    assert (change.cause, change.events) == ("departure", (event_of(first, "P(2;inf:1)"),))
    ends.clear()
    change, followed = explained(*both)
    assert len(followed) == 2
    every_field(change, before="P(2;inf:1)", after="P(1;inf)", cause="unexplained")
    for other in (resting(700.0, "contact", theta=()), resting(700.0, "P(2;1:1)", rests=False)):
        change, followed = explained(other, free)
        assert followed == []
        assert change.cause == "unexplained"


def test_the_width_of_a_motion_is_that_of_the_phases_of_its_recorded_impacts():
    record = SimpleNamespace(
        kind=np.array([IMPACT, DETACHMENT, IMPACT, IMPACT, IMPACT]),
        period=np.array([-1, 0, 0, 1, 2]),
        theta=np.array([6.0, 0.1, 1.25, 4.0, 2.5]), u=np.array([-9.0, 0.0, -1.0, -8.0, -0.5]),
    )  # fmt: skip
    assert changes._width(SimpleNamespace(record=record)) == 4.0 - 1.25
    record.period -= 9
    assert changes._width(SimpleNamespace(record=record)) == 0.0
