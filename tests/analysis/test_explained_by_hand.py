"""Events of a range, saddles of a record, springs, maps and ends of rests, from stand-ins."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace as Stub
from typing import ClassVar

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import after_rest as after_module
from camcli.analysis import sweep as sweep_module
from camcli.analysis import sweep_map as map_module
from camcli.analysis.after_rest import CYCLE, SETTLED, UNKNOWN, WANDERS, After, HoldsFor
from camcli.analysis.contact_loss import study as contact
from camcli.analysis.explain import changes as module
from camcli.analysis.explain import saddles
from camcli.analysis.explain.changes import CriticalEvent, _events_of_detachment, find_events
from camcli.analysis.integrate import BudgetSpentError, Cost, Start
from camcli.analysis.sweep import BOTH, DOWN, FIXED, UP, Sweep, _Joined, _sections_of
from camcli.analysis.sweep_map import sweep_map
from camcli.piece_faults import PieceFault, gathering

FAULT = PieceFault("rpm = 700.0", "ZeroDivisionError", "camcli/x.py:1, f", "Traceback")


def critical(rpm, region="", corner="", status="ok"):
    return Stub(rpm=rpm, low=rpm - 1.0, high=rpm + 3.0, status=status, region=region, corner=corner)


def study_of(first=None):
    return Stub(
        detachment=Stub(first=first), accumulation=[critical(20.0, "A1"), critical(30.0, "A2")],
        completion=[critical(40.0, "A3", status="jump")], hits=[critical(50.0, "no", "B1")],
        cost=Cost(1, 2, 4),
    )  # fmt: skip


def test_the_events_of_a_study_of_detachment():
    """The first loss is of contact, all others of the chatter; a landing has its own corner."""
    first = critical(10.0, "R")
    study = study_of(first)
    found = _events_of_detachment(study)
    assert [(one.rpm, one.error, one.kind, one.label, one.corner, one.status) for one in found] == [
        (10.0, 2.0, "first-detachment", "contact", "", "ok"),
        (20.0, 2.0, "accumulation-at-corner", "P(1;inf)", "A1", "ok"),
        (30.0, 2.0, "accumulation-at-corner", "P(1;inf)", "A2", "ok"),
        (40.0, 2.0, "chatter-completion", "P(1;inf)", "A3", "jump"),
        (50.0, 2.0, "corner-hit", "P(1;inf)", "B1", "ok"),
    ]
    sources = [first, *study.accumulation, *study.completion, *study.hits]
    assert [one.source for one in found] == sources
    assert len(_events_of_detachment(study_of())) == 4


def motion(rpm, label="P(1;1)", chatter="none"):
    return Stub(rpm=rpm, label=label, chatter=chatter)


class Range:
    """Stand-ins for what `find_events` asks of other parts."""

    def __init__(self, monkeypatch, bifurcations=(), study=None, spent=False):
        self.asked = []
        self.diagram = Stub(bifurcations=list(bifurcations), branches=["branch"])

        def follow(diagram, motions, span, limits):
            self.asked.append((diagram, len(motions), (span.low, span.high, span.spacing), limits))
            if spent:
                raise BudgetSpentError

        def detach(system, rpms, runs):
            self.asked.append((system, rpms, runs))
            return study

        monkeypatch.setattr(
            module, "Shooter", lambda system, rpm: Stub(rpm=rpm, cost=Cost(8, 8, 8))
        )
        monkeypatch.setattr(module, "Diagram", self.make_diagram)
        monkeypatch.setattr(module, "_follow", follow)
        monkeypatch.setattr(module, "detach", detach)

    def make_diagram(self, shooter, runs):
        self.asked.append((shooter.rpm, runs))
        return self.diagram


def bifurcation(value, kind="fold", stable=True, corner="", label="P(1;1)"):
    return Stub(value=value, error=0.25, kind=kind, label=label, corner=corner, left=None,
                right=None, classification="class", status="sure",
                orbit=Stub(stable=stable, det=0.5 if stable else 1.5))  # fmt: skip


@pytest.mark.parametrize("spent", [True, False])
def test_events_are_those_of_attractors_in_ascending_speed_each_once(monkeypatch, spent):
    """Of two events alike to ten digits the first one counts, also where the budget was spent."""
    found = [
        bifurcation(150.0), bifurcation(120.0, corner="A1"), bifurcation(130.0, stable=False),
        bifurcation(150.0 + 1e-9), bifurcation(150.0, "grazing"), bifurcation(150.0, corner="A1"),
        bifurcation(150.0, label="P(2;1:1)"), bifurcation(150.0 + 1e-6),
    ]  # fmt: skip
    seen = Range(monkeypatch, found, spent=spent)
    motions = [motion(170.0), motion(100.0), motion(110.0)]
    events = find_events("system", "runs", motions, "limits")
    assert seen.asked[0] == (135.0, "runs")
    diagram, count, (low, high, step), limits = seen.asked[1]
    assert (diagram, count, low, high, step, limits) == (
        seen.diagram,
        3,
        100.0,
        170.0,
        35.0,
        "limits",
    )
    assert len(seen.asked) == 2  # nothing rests
    assert [one.source for one in events.events] == [found[k] for k in (1, 0, 4, 5, 6, 7)]
    first = events.events[0]
    assert first == CriticalEvent(120.0, 0.25, "fold", "P(1;1)", "A1", "class", "sure", found[1])
    assert (events.cost, events.branches) == (Cost(8, 8, 8), ["branch"])
    assert events.bifurcations == found


@pytest.mark.parametrize("rests", [motion(30.0, "contact"), motion(30.0, "P(1;2)", "complete")])
@pytest.mark.parametrize("count", [3, 60])
def test_where_a_motion_rests_its_detachment_is_studied(monkeypatch, rests, count):
    """At 41 speeds or more; an event outside the range is left out, one at its end is not."""
    seen = Range(monkeypatch, study=study_of(critical(10.0)))
    motions = [rests, *(motion(20.0 + 20.0 * k / (count - 2)) for k in range(count - 1))]
    events = find_events("system", "runs", motions)
    system, rpms, runs = seen.asked[-1]
    assert (system, runs, len(rpms)) == ("system", "runs", max(41, count))
    assert (rpms[0], rpms[-1]) == (20.0, 40.0)
    assert [one.rpm for one in events.events] == [20.0, 30.0, 40.0]
    assert events.cost == Cost(9, 10, 12)
    _, _, (_, _, step), limits = seen.asked[1]
    assert step == pytest.approx(20.0 / (count - 1))
    assert limits is module.USUAL_LIMITS
    broken = Range(monkeypatch)
    monkeypatch.setattr(module, "detach", lambda *given: {}["unforeseen"])
    with gathering() as faults:
        assert find_events("system", "runs", motions).cost == Cost(8, 8, 8)
    assert [one.piece for one in faults] == ["the study of detachment"]
    assert len(broken.asked) == 2


def test_the_step_along_branches_is_a_share_of_a_range_of_many_motions(monkeypatch):
    seen = Range(monkeypatch)
    find_events("system", "runs", [motion(100.0 + k / 10.0) for k in range(801)])
    _, _, (low, high, step), _ = seen.asked[1]
    assert (low, high, step) == (100.0, 180.0, pytest.approx(80.0 / 400.0))


# -- saddles of a record


def test_the_saddles_of_a_record_are_solved_from_its_close_returns(monkeypatch):
    """Each once, unstable, of motions that are; in the order of their turns and multipliers."""

    @dataclass(frozen=True)
    class Orbit:
        name: str
        turns: int
        multipliers: tuple
        admissible: bool = True
        stable: bool = False
        primitive: bool = True

    found = {
        (1, 4): Orbit("a", 1, (-3.0, 0.1)), (1, 7): Orbit("b", 1, (2.0, 0.1)),
        (2, 0): Orbit("stable", 2, (0.5, 0.1), stable=True),
        (2, 1): Orbit("no motion", 2, (5.0, 0.1), admissible=False),
        (2, 2): Orbit("twice", 2, (5.0, 0.1), primitive=False),
        (2, 3): Orbit("c", 2, (1.5, 0.1)), (2, 5): Orbit("c", 2, (1.5, 0.1)),
        (8, 0): Orbit("d", 8, (-9.0, 0.1)), (9, 0): Orbit("long", 9, (9.0, 0.1)),
    }  # fmt: skip
    states = np.array([[2.0, 12.0], [4.0, 18.0]])
    shown = []

    def returns(scaled, turns):
        shown.append(scaled.tolist())
        return np.array([first for count, first in [*found, (1, 9)] if count == turns], int)

    monkeypatch.setattr(saddles, "states_of", lambda record: states)
    monkeypatch.setattr(saddles, "_closest_returns", returns)
    monkeypatch.setattr(saddles, "Shooter", lambda *machine: Stub(
        machine=machine, verdict=lambda root: (f"verdict {root}", 0, 0)))  # fmt: skip
    monkeypatch.setattr(saddles.identify, "impacts_of", lambda record, window: (record, window))
    monkeypatch.setattr(
        saddles.identify, "newton_from",
        lambda shooter, impacts, turns: (turns, impacts[1].start)
        if impacts == ("record", range(impacts[1].start, impacts[1].start + turns))
        and (turns, impacts[1].start) in found else None,
    )  # fmt: skip

    def from_root(system, root, verdict):
        assert verdict == f"verdict {root}"
        return found[root]

    monkeypatch.setattr(saddles, "from_root", from_root)
    monkeypatch.setattr(saddles, "same_orbit", lambda one, other: one.name == other.name)
    met = saddles.find_saddles("system", 700.0, "record", np.array([2.0, 6.0]))
    assert [one.name for one in met] == ["b", "a", "c", "d"]
    assert shown == [[[1.0, 2.0], [2.0, 3.0]]] * 8


# -- springs


def test_the_force_with_each_spring_that_holds(monkeypatch):
    monkeypatch.setattr(contact, "Force", lambda of: Stub(curve=lambda rpm: (of, rpm)))
    monkeypatch.setattr(contact, "replaced", lambda *spring: spring)
    none, half = Stub(stiffness=None, preload=3.0), Stub(stiffness=4.0, preload=None)
    zero, both = Stub(stiffness=0.0, preload=0.0), Stub(stiffness=5.0, preload=6.0)
    assert list(contact._springs("system", 700.0, [none, both, half, zero])) == [
        (None, ("system", 700.0)), (both, (("system", 5.0, 6.0), 700.0)),
        (zero, (("system", 0.0, 0.0), 700.0)),
    ]  # fmt: skip


@pytest.mark.parametrize("margin", [None, 0.0, 7.0])
@pytest.mark.parametrize("precompression", [None, 0.0, 0.25])
def test_springs_are_sought_with_what_is_usual_where_nothing_is_stated(
    monkeypatch, margin, precompression
):
    asked = []
    monkeypatch.setattr(contact, "usual_margin", lambda *given: 9.0 if given == (1, 2, "e") else 0)
    monkeypatch.setattr(contact, "usual_precompression", lambda system: 0.5 * system)
    monkeypatch.setattr(contact, "hold_to", lambda *given: asked.append(given) or ["one", "two"])
    monkeypatch.setattr(contact, "_springs", lambda *given: iter([given]))
    found = contact._springs_to(1, 2, margin, precompression, accel_error="e", solid=0.75)
    margin = 9.0 if margin is None else margin
    precompression = 0.5 if precompression is None else precompression
    assert asked == [(1, 2, margin, precompression, "e", 0.75)]
    assert tuple(found) == (("one", "two"), ((1, 2, ["one", "two"]),), margin)


# -- behind a rest


@pytest.mark.parametrize(
    ("of_all", "holds_for"),
    [
        ({}, HoldsFor.LAST_DIGIT),
        ({"kind": UNKNOWN}, HoldsFor.EXACT_DATA),
        ({"symbols": (1, 3)}, HoldsFor.EXACT_DATA),
        ({"states": ((0.5, 1.0), (0.3, 2.0 + 1e-3))}, HoldsFor.EXACT_DATA),
        ({"states": ((0.3, 2.0), (0.5, 1.0))}, HoldsFor.LAST_DIGIT),  # begun at the other one
        ({"states": ((0.3, 2.0),)}, HoldsFor.EXACT_DATA),
    ],
)
def test_an_end_holds_for_every_speed_that_reads_alike_where_they_end_alike(
    monkeypatch, of_all, holds_for
):
    end = After(SETTLED, 9, ((0.5, 1.0), (0.3, 2.0)), (1, 2))
    asked = []

    def of_machine(system, rpm, theta, all_that_read_alike=False):
        asked.append((system, rpm, theta, all_that_read_alike))
        return replace(end, **of_all) if all_that_read_alike else end

    monkeypatch.setattr(after_module, "of_machine", of_machine)
    assert after_module.after_rest("system", 700.0, 1.5) == replace(end, holds_for=holds_for)
    assert asked == [("system", 700.0, 1.5, False), ("system", 700.0, 1.5, True)]


@pytest.mark.parametrize("kind", [CYCLE, SETTLED, WANDERS, UNKNOWN])
def test_which_ends_are_asked_of_every_speed_that_reads_alike(monkeypatch, kind):
    """None that is not known, and none where too many bits were lost on the way."""
    for lost in (0, after_module.HOPELESS, after_module.HOPELESS + 1):
        asked = []
        end = After(kind, 9, ((0.5, 1.0),), (1,), lost=lost)
        monkeypatch.setattr(
            after_module, "of_machine", lambda *given, end=end, asked=asked, **more: (
                asked.append(more) or end
            ),
        )  # fmt: skip
        found = after_module.after_rest("system", 700.0, 1.5)
        if kind in (WANDERS, UNKNOWN):
            assert (found.holds_for, len(asked)) == (None, 1)
        elif lost > after_module.HOPELESS:
            assert (found.holds_for, len(asked)) == (HoldsFor.EXACT_DATA, 1)
        else:
            assert (found.holds_for, len(asked)) == (HoldsFor.LAST_DIGIT, 2)


def test_a_cycle_is_the_same_as_a_cycle_alone():
    cycle, settled = After(CYCLE, 2, ((0.5, 1.0),)), After(SETTLED, 2, ((0.5, 1.0),))
    assert after_module._same(cycle, After(CYCLE, 3, ((9.0, 9.0),)))
    assert not after_module._same(cycle, settled)
    assert not after_module._same(settled, cycle)
    assert after_module._same(settled, settled)


# -- sweeps and maps


def test_what_tells_the_rows_of_a_sweep_apart():
    for direction, also, names in (
        (FIXED, (), ()), (UP, (), ()), (DOWN, (), ()), (BOTH, (), ("direction",)),
        (FIXED, (Start(),), ("start",)), (BOTH, (Start(),), ("direction", "start")),
    ):  # fmt: skip
        assert Sweep((), direction, Cost(), also=also).way_names == names


def test_sections_of_speeds_that_are_put_together_are_read_at_their_places(monkeypatch):
    """Out of an inner order into the parts; of a part on disk no speed is made."""

    class Disk(list):
        unkept = frozenset({1})

        def part(self, k, of, names):
            return of({name: f"{name} {self[k]} on disk" for name in names})

    monkeypatch.setattr(sweep_module, "Kept", Disk)
    monkeypatch.setattr(sweep_module, "load_section", lambda name, stored: stored[name])

    def made(number):
        return Stub(impacts=f"impacts {number}", strobe=f"strobe {number}")

    inner = _Joined([[made(0), made(1)], Disk(["two", made(3)])], [3, 0, 2, 1])
    outer = _Joined([[made(9)], inner], [2, 0, 3, 4, 1])
    assert [_sections_of(outer, k, ("strobe", "impacts")) for k in range(5)] == [
        ["strobe 0", "impacts 0"], ["strobe 9", "impacts 9"],
        ["strobe two on disk", "impacts two on disk"], ["strobe 1", "impacts 1"],
        ["strobe 3", "impacts 3"],
    ]  # fmt: skip
    assert _sections_of(outer, 1, ("impacts",)) == ["impacts 9"]


class LineTask:
    """Instead of `SpeedTask`: a speed tells where it began."""

    made: ClassVar[list] = []

    def __init__(self, **given):
        self.given = given
        self.at_once = 2
        LineTask.made.append(self)

    def after(self, before, value):
        number = value + (0 if before is None else 0.5 * before.value)
        return Stub(value=value, cost=Cost(1, 2, 4), began=number, fault=None)

    def many(self, values):
        assert len(values) <= 2
        return [Stub(value=value, cost=Cost(1, 2, 4), began=value,
                     fault=FAULT if value == 3.0 else None) for value in values]  # fmt: skip


@pytest.mark.parametrize("direction", [FIXED, UP, DOWN])
def test_a_map_is_made_line_by_line(monkeypatch, direction):
    """Fixed in the order of the values given; else along them, each from the end of the last."""
    LineTask.made.clear()
    monkeypatch.setattr(map_module, "SpeedTask", LineTask)
    refused = []
    monkeypatch.setattr(map_module, "refuse_below", lambda setup, values: refused.append(values))

    def setup(first, second):
        return f"machine {first} {second}", first, settings(5, 7)

    told = []
    found = sweep_map(("rpm", "mass"), [3.0, 1.0, 2.0], [0.5, 0.25], setup, direction=direction,
                      lyapunov=True, decide=direction == UP, on_line=told.append)  # fmt: skip
    order = {FIXED: [3.0, 1.0, 2.0], UP: [1.0, 2.0, 3.0], DOWN: [3.0, 2.0, 1.0]}[direction]
    began = {FIXED: order, UP: [1.0, 2.5, 4.0], DOWN: [3.0, 3.5, 2.0]}[direction]
    assert refused == [(3.0, 0.5)]
    assert (found.keys, list(found.first), list(found.second), found.direction) == (
        ("rpm", "mass"), order, [0.5, 0.25], direction,
    )  # fmt: skip
    assert [[one.value for one in line] for line in found.lines] == [order, order]
    assert [one.began for one in found.speeds] == began * 2
    assert [len(line) for line in told] == [3, 3]
    assert found.cost == Cost(6, 12, 24)
    assert found.faults == ([FAULT, FAULT] if direction == FIXED else [])
    for task, second in zip(LineTask.made, (0.5, 0.25), strict=True):
        given = dict(task.given)
        assert given.pop("setup")(9.0)[:2] == (f"machine 9.0 {second}", 9.0)
        assert given == {
            "key": f"mass = {second}, rpm", "impacts": False, "strobe": False, "lyapunov": True,
            "turns": 72, "turns_each": 12, "follow": direction == UP, "keeps_ends": True,
        }  # fmt: skip


def test_a_map_whose_first_machine_cannot_be_made_is_run_all_the_same(monkeypatch):
    LineTask.made.clear()
    monkeypatch.setattr(map_module, "SpeedTask", LineTask)

    def setup(first, second):
        raise ZeroDivisionError

    found = sweep_map(("rpm", "mass"), [1.0, 2.0], [0.5], setup)
    assert [one.value for one in found.speeds] == [1.0, 2.0]
    assert (LineTask.made[0].given["turns"], LineTask.made[0].given["turns_each"]) == (0, 0)
