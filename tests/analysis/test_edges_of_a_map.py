"""Which curves of a map are followed, and from where: each part beside stand-ins for the others."""

from __future__ import annotations

from types import SimpleNamespace as Stub

import pytest
from conftest import settings

from camcli.analysis.integrate import Cost
from camcli.analysis.orbits import atlas as module
from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.atlas import FOLLOWED, MOST_CURVES, MOST_TURNS, Atlas, Edge
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.sweep_map import sweep_map
from camcli.errors import Fault, NoMachineError
from camcli.piece_faults import gathering

PLANE = Stub(names=("rpm", "follower.mass"), ranges=((600.0, 800.0), (1.0, 2.0)), steps=60)
NO_MACHINE = NoMachineError(Fault("", "cam", "found", "expected", "cure"))


def curve(first, last, kind=Kind.FOLD, corner="", label="P(1;1)", points=3):
    middle = [Stub(first=700.0, second=1.5)] * (points - 2)
    ends = [Stub(first=one[0], second=one[1]) for one in (first, last)]
    return Stub(kind=kind, corner=corner, label=label, points=[ends[0], *middle, ends[1]])


def event(value=650.0, kind=Kind.FOLD, corner="", turns=1, located="located"):
    return Stub(value=value, kind=kind, corner=corner, located=located, label="P(1;1)",
                orbit=Stub(turns=turns))  # fmt: skip


@pytest.fixture
def followed(monkeypatch):
    """What is followed, as (machine, event located, label, corner); each curve has three points."""
    asked = []

    def follow(system, located, plane, label, corner):
        assert plane is PLANE
        asked.append((system, located, label, corner))
        return Stub(points=[1, 2, 3])

    monkeypatch.setattr(module, "curve", follow)
    return asked


def machine_at(first, second):
    return f"{first} {second}", 0.0


@pytest.mark.parametrize(
    ("edge", "place", "known"),
    [
        (Edge(0, 2.0), "650.0 2.0", (650.0, 2.0)),
        (Edge(1, 800.0), "800.0 1.25", (800.0, 1.25)),
    ],
)
def test_the_curve_of_an_event_begins_at_its_place_of_the_edge(followed, edge, place, known):
    """It is followed unless a curve of its kind and corner begins or ends there already."""
    found = event(known[edge.varied], corner="b", kind=Kind.CORNER_IMPACT)
    elsewhere = (710.0, 1.0)
    near = (known[0] + 1.9e-4, known[1] - 0.9e-6)  # within a millionth of the ranges
    for others, is_new in (
        ([], True),
        ([curve(known, elsewhere, Kind.CORNER_IMPACT, "b")], False),
        ([curve(elsewhere, known, Kind.CORNER_IMPACT, "b")], False),
        ([curve(elsewhere, near, Kind.CORNER_IMPACT, "b")], False),
        ([curve(elsewhere, (near[0] + 2e-5, near[1]), Kind.CORNER_IMPACT, "b")], True),
        ([curve(elsewhere, (near[0], near[1] - 2e-7), Kind.CORNER_IMPACT, "b")], True),
        ([curve(known, elsewhere, Kind.CORNER_IMPACT, "c")], True),
        ([curve(known, elsewhere, Kind.GRAZING, "b")], True),
        ([curve(elsewhere, elsewhere, Kind.CORNER_IMPACT, "b")], True),
    ):
        followed.clear()
        atlas = Atlas(PLANE, curves=list(others))
        module._follow(machine_at, atlas, edge, found)
        assert followed == [(place, "located", "P(1;1)", "b")] * is_new
        assert len(atlas.curves) == len(others) + is_new


@pytest.mark.parametrize("kind", Kind)
def test_of_which_events_curves_are_followed(followed, kind):
    module._follow(machine_at, Atlas(PLANE), Edge(0, 2.0), event(kind=kind))
    assert bool(followed) is (kind in FOLLOWED)
    assert set(FOLLOWED) == {Kind.PERIOD_DOUBLING, Kind.FOLD, Kind.CORNER_IMPACT, Kind.GRAZING}


def test_what_makes_no_curve(followed, monkeypatch):
    atlas = Atlas(PLANE)
    module._follow(machine_at, atlas, Edge(0, 2.0), event(located=None))
    full = Atlas(PLANE, curves=[curve((601.0, 1.1), (602.0, 1.2))] * MOST_CURVES)
    module._follow(machine_at, full, Edge(0, 2.0), event())
    assert not followed

    def none(first, second):
        raise NO_MACHINE

    module._follow(none, atlas, Edge(0, 2.0), event())
    for points, is_curve in ((None, False), ([1], False), ([1, 2], True)):
        made = None if points is None else Stub(points=points)
        monkeypatch.setattr(module, "curve", lambda *_, made=made: made)
        atlas.curves.clear()
        module._follow(machine_at, atlas, Edge(0, 2.0), event())
        assert atlas.curves == [made] * is_curve


@pytest.mark.parametrize(
    ("change", "others", "is_new"),
    [
        ({}, [], True),
        ({"turns": MOST_TURNS}, [], True),
        ({"turns": MOST_TURNS + 1}, [], False),
        ({"located": None}, [], False),
        ({}, [curve((1.0, 1.0), (2.0, 2.0), Kind.GRAZING)] * MOST_CURVES, False),
        ({"curves": (1,)}, [curve((1.0, 1.0), (2.0, 2.0), Kind.GRAZING)], False),  # on it
        ({"curves": (2,)}, [curve((1.0, 1.0), (2.0, 2.0), Kind.GRAZING)] * 2, False),
        ({"curves": (1,)}, [curve((1.0, 1.0), (2.0, 2.0), Kind.FOLD)], True),
        ({"curves": (1,)}, [curve((1.0, 1.0), (2.0, 2.0), Kind.GRAZING, "b")], True),
        ({}, [curve((700.0, 1.5), (2.0, 2.0), Kind.GRAZING)], False),  # it ends there
        ({}, [curve((700.0, 1.5), (2.0, 2.0), Kind.GRAZING, label="P(2;1:1)")], True),
        ({}, [curve((700.0, 1.5), (2.0, 2.0), Kind.FOLD)], True),
    ],
)
@pytest.mark.parametrize("condition", [0, 1])
def test_the_other_curve_of_a_point(followed, monkeypatch, change, others, is_new, condition):
    """From where two bifurcations meet the curve of either is followed, of few turns only."""
    point = Stub(first=700.0, second=1.5, curves=change.get("curves", ()), label="P(1;1)",
                 orbit=Stub(turns=change.get("turns", 1)))  # fmt: skip
    located = change.get("located", Stub(kind=Kind.GRAZING))
    monkeypatch.setattr(
        codim2, "event_at", lambda one, k: (located, "") if k == condition else ("other", "x")
    )
    atlas = Atlas(PLANE, curves=list(others))
    module._follow_from(machine_at, atlas, point, condition)
    assert followed == [("700.0 1.5", located, "P(1;1)", "")] * is_new
    assert len(atlas.curves) == len(others) + is_new
    monkeypatch.setattr(module, "curve", lambda *_: Stub(points=[1, 2]))  # no more than its begin
    atlas = Atlas(PLANE, curves=list(others))
    module._follow_from(machine_at, atlas, point, condition)
    assert len(atlas.curves) == len(others)


def test_the_edges_of_a_map_and_what_is_followed_from_each(monkeypatch):
    """Low and high of one number, then of the other; events of few turns come first.

    An edge that breaks costs itself. The third curve has a point, whose two curves come next, the
    second of these has one more.
    """
    log, stages = [], []
    turns = {(0, 1.0): [3, 1], (0, 2.0): [2], (1, 800.0): [1]}

    def events_on(at, settings, atlas, edge, branches):
        log.append((edge.varied, edge.end, branches))
        if edge == Edge(1, 600.0):
            raise ZeroDivisionError
        return [event(turns=n, value=k) for k, n in enumerate(turns[edge])]

    def follow(at, atlas, edge, found):
        log.append((edge.end, found.orbit.turns))
        atlas.curves.append("curve")

    def points(at, atlas, known):
        log.append(("points behind", known))
        if len(atlas.curves) in (3, 5):
            atlas.points.append(f"point {len(atlas.points)}")

    def follow_from(at, atlas, point, condition):
        log.append((point, condition))
        atlas.curves.append("curve")

    for name, stand_in in (("_events_on", events_on), ("_follow", follow),
                           ("_add_points", points), ("_follow_from", follow_from)):  # fmt: skip
        monkeypatch.setattr(module, name, stand_in)
    with gathering() as faults:
        module.add_curves(None, None, Atlas(PLANE), 7, lambda: stages.append(len(log)))
    assert [fault.piece for fault in faults] == ["the edge of the map at rpm = 600.0"]
    assert log == [
        (0, 1.0, 7), (0, 2.0, 7), (1, 600.0, 7), (1, 800.0, 7),
        (1.0, 1), ("points behind", 0),
        (800.0, 1), ("points behind", 1),
        (2.0, 2), ("points behind", 2),
        ("point 0", 0), ("points behind", 3), ("point 0", 1), ("points behind", 4),
        (1.0, 3), ("points behind", 5),
        ("point 1", 0), ("points behind", 6), ("point 1", 1), ("points behind", 7),
    ]  # fmt: skip
    assert stages == [1, 2, 3, 4, len(log)]


def test_where_on_an_edge_orbits_are_looked_for(monkeypatch):
    """At five places, those without a machine left out, and at a fault that costs its own place.

    The work of the search and of the branches counts. Then branches leave from events.
    """
    log = []

    def at(first, second):
        if second > 1.9:
            raise NO_MACHINE
        return f"machine {first} {second:.3f}", 650.0

    def find(system, rpm, settings, starts):
        if "1.730" in system:
            raise ZeroDivisionError
        log.append((system, rpm, settings, starts))
        return Stub(cost=Cost(1, 0, 0), orbits=[Stub(label="A"), Stub(label="B")])

    def branch(diagram, orbit, span):
        log.append((orbit.label, diagram.shooter.system, span))

    class Diagram:
        def __init__(self, shooter, settings):
            self.shooter = shooter
            self.bifurcations = ["event"]

    monkeypatch.setattr(module, "find", find)
    monkeypatch.setattr(module, "Shooter", lambda system, rpm, name: Stub(
        system=(system, name), cost=Cost(10, 0, 0)))  # fmt: skip
    monkeypatch.setattr(module, "_EdgeDiagram", Diagram)
    monkeypatch.setattr(module, "_follow_branch", branch)
    monkeypatch.setattr(module, "_follow_from_events", lambda *args: log.append(args[1:]))
    atlas = Atlas(PLANE)
    with gathering() as faults:
        found = module._events_on(at, "settings", atlas, Edge(1, 800.0), 3)
    assert found == ["event"]
    assert [fault.piece for fault in faults] == ["the orbits at follower.mass = 1.73"]
    span = Span(1.0, 2.0, 1.0 / 60)
    expected = []
    for mass in ("1.020", "1.270", "1.500"):
        system = f"machine 800.0 {mass}"
        expected.append((system, 650.0, "settings", 6))
        expected += [(label, (system, "follower.mass"), span) for label in "AB"]
    assert log == [*expected, (3, span)]
    assert atlas.cost == Cost(33, 0, 0)

    def nowhere(first, second):
        raise NO_MACHINE

    log.clear()
    assert module._events_on(nowhere, "settings", Atlas(PLANE), Edge(1, 800.0), 3) == []
    assert not log


@pytest.mark.parametrize(
    ("root", "moved", "known", "is_added"),
    [("root", "moved", False, True), (None, "moved", False, False), ("root", None, False, False),
     ("root", "moved", True, False)],
)  # fmt: skip
def test_which_branches_of_an_edge_are_new(monkeypatch, root, moved, known, is_added):
    added = []
    shooter = Stub(value=650.0, moved=lambda one, value: moved if (one, value) == (root, 650.0)
                   else "elsewhere")  # fmt: skip
    diagram = Stub(shooter=shooter, holds=lambda one: known,
                   add_bouncing=lambda *args: added.append(args))  # fmt: skip
    monkeypatch.setattr(module, "both_ways", lambda *args: args)
    module._follow_branch(diagram, Stub(root=root), "span")
    assert added == [((shooter, "moved", "span"), "found")] * is_added


def test_a_map_costs_what_all_of_its_points_do(chapter):
    def setup(rpm, restitution):
        return chapter.with_follower(restitution=restitution), rpm, settings(4, 3)

    lines = []
    keys = ("rpm", "follower.restitution")
    found = sweep_map(keys, [690.0, 700.0], [0.6, 0.7, 0.8], setup, on_line=lines.append)
    points = [speed for line in lines for speed in line]
    assert len(points) == 6
    assert found.cost.impacts == sum(speed.cost.impacts for speed in points)
    assert found.cost.evaluations == sum(speed.cost.evaluations for speed in points)
