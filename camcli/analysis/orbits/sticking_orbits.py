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
    """What a run from the orbit's own state settles on at another value of the parameter.

    A state below the cam there is replaced by one at rest on it.
    """
    system, rpm = with_machine(shooter.system, shooter.at(value))
    state = orbit.states[0]
    cam_at_strobe = system.cam.stretches[system.cam.strobe].start_c
    start = Start.at_strobe(system, rpm, state if state[0] > cam_at_strobe else None)
    longest = max(LONGEST_RESTING, orbit.turns)
    run = with_turns(settings, RESTING_SETTLE, 2 * longest + 2)
    record = shooter.simulate(system, rpm, run, start)
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
    """Bracket the value at which the motion is no longer the `same`, and name the change.

    last: the orbit before it; beyond: a value of the parameter behind it.
    """
    up = beyond > last.value
    # Places are the way from `last` plus this, so that no bracket ends at zero.
    offset = abs(beyond - last.value) + shooter.scale
    orbits: dict[float, PeriodicOrbit | None] = {last.value: last}  # by the parameter

    def value_at(place: float) -> float:
        """The value of the parameter at a place."""
        way = place - offset
        return last.value + way if up else last.value - way

    def lost(place: float) -> float:
        """-1 where the motion is the same at a place, 1 where it is not."""
        value = value_at(place)
        orbits[value] = _orbit_at(shooter, settings, last, value)
        return -1.0 if same(last, orbits[value]) else 1.0

    end = offset + abs(beyond - last.value)
    low, high, *_ = bracket(lost, offset, end, -1.0, 1.0)
    value = value_at(low)
    before = orbits[value] or last
    after = orbits.get(value_at(high))
    if after is None:
        after = _settled_on(shooter, settings, last, value_at(high))
    error = max(abs(high - low), 4.0 * ulp(abs(value) + offset))
    return MotionChange(_kind(before, after), value, error, before, after)


def _kind(last: PeriodicOrbit, after: PeriodicOrbit | None) -> Kind:
    """What happens where the orbit `last` goes over into `after`, None where none follows.

    A chatter that is completed less often behind is CHATTER_COMPLETION, what is left ITINERARY.
    """
    if last.free:
        return Kind.GRAZING
    label_after = "" if after is None else after.label
    if CONTACT in (last.label, label_after):
        return Kind.DETACHMENT
    chatters_before = last.symbols.count(inf) / last.turns  # a turn
    chatters_after = 0.0 if after is None else after.symbols.count(inf) / after.turns
    return Kind.CHATTER_COMPLETION if chatters_after < chatters_before else Kind.ITINERARY
