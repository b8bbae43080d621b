"""Everything `cam orbits` asks: find orbits, follow them, classify what happens to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from camcli.analysis.integrate import Cost, Settings, compile_for
from camcli.analysis.orbits.absence import Absence, look_around
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch import Bifurcation, Branch, Writer
from camcli.analysis.orbits.branch_segment import Leg, both_ways, follow
from camcli.analysis.orbits.crossing import Crossing, doubled
from camcli.analysis.orbits.find import MOST_STARTS, RECORD, Found, find
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.analysis.orbits.sticking_orbits import BRACKETS, RUN, follow_resting
from camcli.analysis.sweep import LITTLE_WORK
from camcli.kernel import backend
from camcli.system import System

SAME_PHASE = 1e-8  # rad
LEAST_WORK = 500  # turns in all that plain Python does where a compiled kernel only has to be read


@dataclass(frozen=True)
class Question:
    """What to find and follow.

    rpm: where orbits are looked for; parameter and span: what is varied (None: nothing); label:
    only this one; branches: how many that leave from events to follow; starts: motions simulated;
    stable: only those that are (True) or are not (False).
    """

    rpm: float
    parameter: str = "rpm"
    span: Span | None = None
    label: str | None = None
    branches: int = 3
    starts: int = 24
    curve: str | None = None  # kind of bifurcation that is to be continued in two parameters
    stable: bool | None = None


@dataclass(frozen=True)
class Study:
    """The orbits at question.rpm, and the branches through them."""

    question: Question
    value: float
    orbits: list[PeriodicOrbit]
    virtual: list[PeriodicOrbit]
    branches: list[Branch]
    bifurcations: list[Bifurcation]
    cost: Cost
    absent: Absence | None = None  # the label asked for does not exist at the speed asked for


def study(
    system: System,
    settings: Settings,
    question: Question,
    on_branch: Callable[[], None] = lambda: None,
) -> Study:
    """Find, follow and classify; `on_branch` is called after each branch."""
    starts = question.starts if question.label is None else max(question.starts, MOST_STARTS)
    turns = (starts + 1) * (settings.transient + RECORD)
    if backend.must_compile() or (backend.may_compile() and turns > 2 * LITTLE_WORK):
        compile_for(system)
    found = find(system, question.rpm, settings, question.starts, question.label)
    absent = None
    if question.stable is not None:
        found.orbits = [orbit for orbit in found.orbits if orbit.stable == question.stable]
    elif question.label is not None and not found.orbits:
        span = question.span if question.parameter == "rpm" else None
        ends = None if span is None else (span.low, span.high)
        absent = look_around(system, settings, question.rpm, question.label, ends)
        if span is not None and absent.orbit is not None:
            found.orbits, question = [absent.orbit], replace(question, rpm=absent.orbit.rpm)
    shooter = Shooter(system, question.rpm, question.parameter)
    if question.span is not None and not question.span.width > 0.0:
        raise ValueError("a range needs two different ends; leave the span out for one value")
    if question.span is not None and not question.span.holds(shooter.machine[shooter.parameter]):
        raise ValueError(f"{question.parameter} where orbits are found lies outside the range")
    value = shooter.machine[shooter.parameter]
    writer = Writer(shooter, settings)
    if question.span is not None:
        _prepare(system, found, question.span)
        _follow_all(shooter, settings, question, found, writer, on_branch)
    return Study(
        question, value, found.orbits, found.virtual, writer.branches, writer.bifurcations,
        found.cost + shooter.cost, absent,
    )  # fmt: skip


def _prepare(system: System, found: Found, span: Span) -> None:
    """Compile for branches of resting orbits: each of their points is a simulation."""
    resting = sum(orbit.resting for orbit in found.orbits)
    turns = resting * RUN * (span.width / span.spacing + BRACKETS)
    if backend.may_compile() and turns > (LEAST_WORK if backend.is_cached() else LITTLE_WORK):
        compile_for(system)


def _follow_all(shooter, settings, question: Question, found: Found, writer: Writer, tick) -> None:
    """Branches through the orbits found, then those that leave from events on them."""
    span = question.span
    for orbit in found.orbits:
        if orbit.root is None:
            start = replace(orbit, value=shooter.machine[shooter.parameter])
            legs = [follow_resting(shooter, settings, start, span, up) for up in (False, True)]
            writer.resting(*legs, "found")
        else:
            root = in_parameter(shooter, orbit.root)
            if root is None or on_branches(shooter, writer.branches, root):
                continue
            writer.bouncing(list(both_ways(shooter, root, span)), "found")
        tick()
    for index, event in _first(writer, question.branches):
        continue_from(shooter, writer, index, event, span)
        tick()


def _first(writer: Writer, most: int):
    """Events from which a branch leaves, in the order of discovery, until `most` have been used."""
    known, done = len(writer.branches), 0
    while done < len(writer.shoots) and len(writer.branches) < known + most:
        yield writer.shoots[done]
        done += 1


def in_parameter(shooter: Shooter, root: Root) -> Root | None:
    """The same root with its tangent in the shooter's parameter."""
    value = shooter.machine[shooter.parameter]
    return shooter.at_value([*root.x[:-1], value], root.whole, root.turns, value)


def continue_from(shooter: Shooter, writer: Writer, index: int, event, span: Span) -> None:
    """Follow the branch that leaves from an event, unless it is one already followed."""
    leg = _leaving(shooter, event, span)
    if leg is None or len(leg.points) < 2:
        return
    if on_branches(shooter, writer.branches, leg.points[len(leg.points) // 2]):
        return
    source = writer.bifurcations[index]
    writer.bouncing([leg], source.kind)
    writer.bifurcations[index] = replace(source, continues=len(writer.branches))


def _leaving(shooter: Shooter, event, span: Span) -> Leg | None:
    """The branch that leaves from a nonsmooth fold or a period doubling, if there is one."""
    if isinstance(event, Crossing):
        root, along = event.far, event.ahead
    else:
        start = doubled(shooter, event)
        if start is None:
            return None
        root, along = start
    return follow(shooter, root, along, span)


def on_branches(shooter: Shooter, branches: list[Branch], root: Root) -> bool:
    """True where some branch passes through the root."""
    orbit = from_root(shooter.system, root)
    return any(_passes(shooter, branch, orbit, root.value) for branch in branches)


def _passes(shooter: Shooter, branch: Branch, orbit: PeriodicOrbit, value: float) -> bool:
    for a, b in zip(branch.points, branch.points[1:], strict=False):
        if not min(a.value, b.value) <= value <= max(a.value, b.value):
            continue
        for point in (a, b):
            if point.root is None or point.root.count != orbit.impacts:
                continue
            r = point.root
            near = shooter.at_value(r.x, r.whole, r.turns, value)
            if near is None:
                continue
            other = from_root(shooter.system, near)
            if other.symbols == orbit.symbols and all(
                abs(s - t) <= SAME_PHASE for s, t in zip(other.theta, orbit.theta, strict=True)
            ):
                return True
    return False
