"""Branches of orbits that need no Newton iteration: those that rest on the cam, or never meet it.

At rest the state is the cam's own: a run from the orbit nearby closes on itself exactly, and its
multipliers are zero. Such a branch ends where its turns change: a chatter is no longer completed,
contact is kept or lost, or the itinerary: an impact appears, fades, or moves to another turn. The
orbit without impacts is known in closed form, and its branch ends where the cam reaches it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import inf, ulp

from camcli.analysis.bracketing import bracket
from camcli.analysis.integrate import BudgetSpentError, Settings, Start, with_turns
from camcli.analysis.labels import CONTACT
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.identify import identify
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.orbit import PeriodicOrbit, free_orbit
from camcli.analysis.orbits.shooter import Shooter, with_machine
from camcli.errors import NoMachineError
from camcli.piece_faults import piece

RESTING_SETTLE = 40  # turns from the orbit at the neighbouring speed
LONGEST_RESTING = 8  # periods longer than the orbit's own are not looked for
RUN = RESTING_SETTLE + 2 * LONGEST_RESTING + 2  # turns simulated for one point, at least
BRACKETS = 80  # runs in which the changes of a branch are bracketed, about

Same = Callable[[PeriodicOrbit, PeriodicOrbit | None], bool]


@dataclass(frozen=True)
class MotionChange:
    """Where the motion changes: kind of event, bracket of the parameter.

    orbit: the last one before; beyond: what a run settles on behind it.
    """

    kind: Kind
    value: float
    error: float
    orbit: PeriodicOrbit
    beyond: PeriodicOrbit | None


@dataclass
class StickingSegment:
    """Points in order, changes in order; `end`: what ends the branch."""

    points: list[PeriodicOrbit]
    changes: list[MotionChange] = field(default_factory=list)
    end: Kind = Kind.END_OF_RANGE


def follow_sticking(
    shooter: Shooter, settings: Settings, orbit: PeriodicOrbit, span: Span, up: bool
) -> StickingSegment:
    """Follow an orbit that rests on the cam, or never meets it, towards one end of the range."""
    segment = StickingSegment([orbit])
    name = f"the branch of {orbit.label} from {orbit.value:.10g} {'up' if up else 'down'}"
    try:
        failed = piece(
            name, lambda: _follow(segment, shooter, settings, orbit, span, up), instead=True
        )
    except BudgetSpentError:
        segment.end = Kind.WORK_BUDGET
    except NoMachineError:
        segment.end = Kind.NO_MACHINE
    else:
        if failed:
            segment.end = Kind.FAULT
    return segment


def _follow(
    segment: StickingSegment, shooter: Shooter, settings: Settings, orbit: PeriodicOrbit,
    span: Span, up: bool,
) -> None:  # fmt: skip
    """Add points to a segment, value by value, until the orbit's motion changes or the range ends.

    up: to the upper end of the range. Where only the departures change, that is noted and the
    branch goes on.
    """
    start = orbit.value
    end = span.high if up else span.low
    count = max(1, round(abs(end - start) / span.spacing)) if end != start else 0
    for k in range(1, count + 1):
        value = end if k == count else start + (end - start) * (k / count)
        last = segment.points[-1]
        after = _orbit_at(shooter, settings, last, value)
        if not _same_motion(last, after):
            change = _change(shooter, settings, last, value, _same_motion)
            segment.changes.append(change)
            segment.points.append(change.orbit)
            segment.end = change.kind
            return
        if not _same_departures(last, after):
            change = _change(shooter, settings, last, value, _same_departures)
            change = replace(change, kind=Kind.DEPARTURE, beyond=change.beyond or after)
            segment.changes.append(change)
            segment.points.append(change.orbit)
        segment.points.append(after)  # type: ignore[arg-type]  # the same motion is one


def _orbit_at(
    shooter: Shooter, settings: Settings, orbit: PeriodicOrbit, value: float
) -> PeriodicOrbit | None:
    """The orbit at another value of the parameter; if it rests, what a run from it settles on."""
    system, rpm = with_machine(shooter.system, shooter.at(value))
    if orbit.free:
        airborne = free_orbit(system, rpm)
        return None if airborne is None else replace(airborne, value=value)
    return _settled_on(shooter, settings, orbit, value)


def _settled_on(
    shooter: Shooter, settings: Settings, orbit: PeriodicOrbit, value: float
) -> PeriodicOrbit | None:
    """What a run from the orbit's own state settles on at another value of the parameter."""
    system, rpm = with_machine(shooter.system, shooter.at(value))
    state = orbit.states[0]
    lifted = state[0] > system.cam.stretches[system.cam.strobe].start_c
    start = Start.at_strobe(system, rpm, state if lifted else None)
    longest = max(LONGEST_RESTING, orbit.turns)
    record = shooter.simulate(
        system, rpm, with_turns(settings, RESTING_SETTLE, 2 * longest + 2), start
    )
    ends_on = identify(system, rpm, record, longest)
    return None if ends_on is None else replace(ends_on, rpm=rpm, value=value)


def _same_motion(orbit: PeriodicOrbit, other: PeriodicOrbit | None) -> bool:
    """True where the other rests too, or not, and has the same impacts in the same turns."""
    return other is not None and (other.resting, other.symbols) == (orbit.resting, orbit.symbols)


def _same_departures(orbit: PeriodicOrbit, other: PeriodicOrbit | None) -> bool:
    """`_same_motion`, and the same number of departures from rest."""
    return other is not None and _same_motion(orbit, other) and len(other.theta) == len(orbit.theta)


def _change(
    shooter: Shooter, settings: Settings, last: PeriodicOrbit, beyond: float, same: Same
) -> MotionChange:
    """Bracket the value at which the motion is no longer the `same`, and name the change."""
    up = beyond > last.value
    size = abs(beyond - last.value) + shooter.scale
    kept: dict[float, PeriodicOrbit | None] = {last.value: last}

    def at(x: float) -> float:  # x - size is the way towards `beyond`: no bracket ends at zero
        way = x - size
        return last.value + way if up else last.value - way

    def lost(x: float) -> float:
        kept[at(x)] = _orbit_at(shooter, settings, last, at(x))
        return -1.0 if same(last, kept[at(x)]) else 1.0

    low, high, *_ = bracket(lost, size, size + abs(beyond - last.value), -1.0, 1.0)
    before = kept[at(low)] or last
    after = kept.get(at(high))
    if after is None:
        after = _settled_on(shooter, settings, last, at(high))
    error = max(abs(high - low), 4.0 * ulp(abs(at(low)) + size))
    return MotionChange(_kind(before, after), at(low), error, before, after)


def _kind(last: PeriodicOrbit, after: PeriodicOrbit | None) -> Kind:
    """What happens where the orbit `last` goes over into `after`, None where none follows."""
    if last.free:
        return Kind.GRAZING
    if CONTACT in (last.label, "" if after is None else after.label):
        return Kind.DETACHMENT
    left = 0.0 if after is None else after.symbols.count(inf) / after.turns
    complete = last.symbols.count(inf) / last.turns
    return Kind.CHATTER_COMPLETION if left < complete else Kind.ITINERARY
