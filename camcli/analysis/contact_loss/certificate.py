"""Certificates of the loss of contact: where the force ends, and which impact then meets a corner.

The statements, and what a checker does with them, stand in the guide (`proofs`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from flint import arb

from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import (
    CriticalSpeed,
    Detachment,
    NoStatement,
    SpeedStatus,
)
from camcli.analysis.orbits.certificate import CONSTANTS, FORMAT, divided_flight
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.decimals import exact, exactly
from camcli.exact.machine import BallMachine, BallStretch
from camcli.exact.motion import BallMotion, EndlessError
from camcli.exact.shooting import NotProvedError, Place, Shooting
from camcli.system import System

DIGITS = 60  # decimal digits of the balls
HALF = 1e-27  # of the speed: half of the range in which it is shown to lie
SECANT_STEPS = 30
SETTLED = 1e-40  # of the speed: a step of the secant method after which it is at its goal
FIRST_CHANGE = 1e-9  # of the speed: between the first two speeds
ROOM = 1e-12  # rad and m/rad: about an impact, much more than the range of the speed moves it
DEEPEST = 60  # times that a part of a stretch is halved
OF_THE_CAM = {NoStatement.LASH, NoStatement.FITTED, NoStatement.KINKED}  # of any statement
AT_CORNER = 1e-9  # rad: an impact so near to a corner, in doubles, is on it


class Hits(NamedTuple):
    """The impacts from a lift-off on, at one speed: their phases and the rates they leave at."""

    theta: list[arb]
    v: list[arb]


def certificate(
    system: System,
    detachment: Detachment,
    hits: Sequence[CornerHit],
    cam: dict[str, Any] | None,
    name_of: Callable[[CriticalSpeed | CornerHit], str],
) -> dict[str, Any]:
    """The content of proof.json: a statement of the first detachment, and of each corner hit.

    cam: the numbers of its closed formula, None for a cam that no certificate can have; name_of:
    the name, in words, of what was not proved, which is listed as uncovered.
    """
    cam_is_known = no_statement(system, detachment, cam) not in OF_THE_CAM
    lift_offs = {loss.region.name: loss.opens.theta for loss in detachment.losses}
    asked: list[CriticalSpeed | CornerHit] = []
    if detachment.first is not None and detachment.first.finite:
        asked.append(detachment.first)
    asked += [hit for hit in hits if hit.status is SpeedStatus.OK and hit.burst in lift_offs]
    statements = []
    uncovered = []
    for speed in asked:
        statement = None
        if cam_is_known and isinstance(speed, CornerHit):
            statement = corner_statement(system, speed, lift_offs[speed.burst])
        elif cam_is_known and isinstance(speed, CriticalSpeed):
            statement = detachment_statement(system, speed)
        if statement is None:
            uncovered.append(name_of(speed))
        else:
            statements.append(statement)
    return {
        "format": FORMAT,
        "cam": cam,
        "statements": statements,
        "uncovered": uncovered,
    }


def no_statement(
    system: System, detachment: Detachment, cam: dict[str, Any] | None
) -> NoStatement | None:
    """Why the first detachment has no statement, None where it can have one.

    cam: as of `certificate`.
    """
    if cam is None or any(stretch["seat"] for stretch in cam["stretches"]):
        return NoStatement.LASH
    if cam["kind"] == "pieces":
        return NoStatement.FITTED
    if not _is_smooth(system):
        return NoStatement.KINKED
    first = detachment.first
    if first is None or not first.finite:
        return NoStatement.NO_SPEED
    with precision(DIGITS):
        stretches = BallMachine(system.shape, system.follower, 1.0).stretches
        return NoStatement.INSIDE if _at_start(stretches, first.theta) is None else None


def detachment_statement(system: System, first: CriticalSpeed) -> dict[str, Any] | None:
    """The statement that contact holds up to a speed and not beyond; None where none is shown.

    It is lost at the end of a stretch or its start, where the curvature of the cam jumps: there
    m omega^2 c'' + omega b c' + k c + m g + F0 = 0. Of both sides of the corner the one counts
    where this is so at the lower speed.
    """
    with precision(DIGITS):
        machine = BallMachine(system.shape, system.follower, 1.0)
        after = _at_start(machine.stretches, first.theta)
        if after is None:
            return None
        before = (after - 1) % len(machine.stretches)
        sides = []  # (rpm, stretch, whether it is at its end)
        for stretch, at_end in ((after, False), (before, True)):
            rpm = _force_ends(machine, stretch, at_end)
            if rpm is not None:
                sides.append((rpm, stretch, at_end))
        if not sides:
            return None
        rpm, stretch, at_end = min(sides, key=lambda side: float(side[0]))
        low = _end(rpm, -1)
        high = _end(rpm, 1)
        at_low = BallMachine(machine.stretches, system.follower, low)
        try:
            cuts = [_force_cuts(at_low, one) for one in machine.stretches]
        except UndecidedError:
            return None
        return {
            "kind": "first-detachment",
            "constants": _constants(system),
            "low": exactly(low),
            "high": exactly(high),
            "stretch": stretch,
            "at_end": at_end,
            "cuts": cuts,
        }


def _force_ends(machine: BallMachine, stretch: int, at_end: bool) -> arb | None:
    """The speed (rpm) at which the force ends at an end of a stretch; None where there is none.

    machine: at 1 rpm. With n the speed in rpm the force is a quadratic in n, c'' n^2 + 2 Z c' n +
    W^2 c + G; its positive root is returned where c'' < 0.
    """
    there = machine.stretches[stretch]
    c, c1, c2 = there.derivatives(there.end if at_end else there.start, 2)
    standing = machine.G + machine.W2 * c
    damping = machine.Z2 * c1
    discriminant = damping * damping - 4 * c2 * standing
    if not (c2 < 0 and discriminant > 0):
        return None
    rpm = -(damping + discriminant.sqrt()) / (2 * c2)
    return rpm if rpm > 0 else None


def corner_statement(system: System, hit: CornerHit, lift_off: float) -> dict[str, Any] | None:
    """The statement that an impact lands on a corner at one speed; None where none is shown.

    lift_off: the phase at which the follower leaves the cam, rad.
    """
    with precision(DIGITS):
        stretches = BallMachine(system.shape, system.follower, 1.0).stretches
        start = _at_start(stretches, lift_off)
        if start is None or system.follower.seat_restitution is not None:
            return None
        try:
            return _corner_statement(system, stretches, start, hit)
        except (UndecidedError, NotProvedError, EndlessError, ZeroDivisionError):
            return None


def _corner_statement(
    system: System, stretches: list[BallStretch], start: int, hit: CornerHit
) -> dict[str, Any] | None:
    """`corner_statement` of a follower that leaves the cam at the start of a stretch.

    The range of speeds is a little about the speed found by `_speed_of_hit`. The impacts up to the
    hit lie in balls that hold those at both ends of the range, with room; the checker shows that
    the flights between them are motions for every speed of the range.
    """

    def impacts(rpm: arb) -> Hits:
        return _impacts(system, stretches, start, rpm, hit.impact)

    corner, rpm = _speed_of_hit(stretches, impacts, hit)
    low = _end(rpm, -1)
    high = _end(rpm, 1)
    before = _ranges(stretches, impacts(low), impacts(high), hit.impact - 1)
    places = (Place(start, 0), *(impact.place for impact in before), corner)
    # The unknowns of `Shooting`: phase and rate of each impact, the lift-off first, and the speed.
    # It lifts off with no rate. The rate at the corner is never used: no flight begins there.
    hull = [stretches[start].start, arb(0)]
    for impact in before:
        hull += [impact.phase, impact.rate]
    hull += [stretches[corner.stretch].end, arb(0), low.union(high)]
    shooting = Shooting(
        shape=system.shape,
        follower=system.follower,
        rpm=None,  # it is an unknown
        parameter="rpm",
        places=places,
        turns=1 + max(place.turn for place in places),
    )
    flights = [divided_flight(shooting, hull, k, lifts=k == 0) for k in range(hit.impact)]
    return {
        "kind": "corner-hit",
        "constants": _constants(system),
        "low": exactly(low),
        "high": exactly(high),
        "start": start,
        "impacts": [
            {
                "stretch": impact.place.stretch,
                "turn": impact.place.turn,
                "low": _text(impact.phase.lower()),
                "high": _text(impact.phase.upper()),
            }
            for impact in before
        ],
        "corner": {"stretch": corner.stretch, "turn": corner.turn},
        "flights": flights,
    }


class _ImpactRange(NamedTuple):
    """An impact over a range of speeds: its phase within the turn (rad) and the rate after it."""

    place: Place
    phase: arb
    rate: arb


def _ranges(
    stretches: list[BallStretch], at_low: Hits, at_high: Hits, count: int
) -> list[_ImpactRange]:
    """The first `count` impacts between those at both ends of a range of speeds, with ROOM."""
    ranges = []
    room = arb(0, ROOM)
    for k in range(count):
        phase = (at_low.theta[k] + room).union(at_high.theta[k] + room)
        rate = (at_low.v[k] + room).union(at_high.v[k] + room)
        place = _place(stretches, phase)
        ranges.append(_ImpactRange(place, phase - 2 * arb.pi() * place.turn, rate))
    return ranges


def _impacts(
    system: System, stretches: list[BallStretch], start: int, rpm: arb, count: int
) -> Hits:
    """The first `count` impacts of the follower that leaves the cam at the start of a stretch."""
    machine = BallMachine(stretches, system.follower, rpm)
    motion = BallMotion(machine, system.strobe, float(stretches[start].start))
    while len(motion.trail.impacts) < count:
        motion.step()
    theta = []
    v = []
    for phase, u in motion.trail.impacts[:count]:
        theta.append(phase)
        v.append(-machine.r * u)
    return Hits(theta, v)


def _speed_of_hit(
    stretches: list[BallStretch], impacts: Callable[[arb], Hits], hit: CornerHit
) -> tuple[Place, arb]:
    """(the end of a stretch that the last impact meets, the speed in rpm at which it does).

    The speed is found by the secant method from that of the hit, in doubles. impacts: gives the
    impacts up to that one at a speed.
    """
    landed = float(impacts(arb(hit.rpm)).theta[-1])
    corner = _nearest_end(stretches, landed)
    goal = _phase(stretches, corner)
    rpm_before = arb(hit.rpm) * (1 - FIRST_CHANGE)
    rpm = arb(hit.rpm)
    late_before = impacts(rpm_before).theta[-1] - goal
    for _ in range(SECANT_STEPS):
        try:
            late = impacts(rpm).theta[-1] - goal
        except UndecidedError:  # so near to the corner that these digits see it on no side
            break
        step = (late * (rpm - rpm_before) / (late - late_before)).mid()
        rpm_before = rpm
        late_before = late
        rpm = (rpm - step).mid()
        if abs(step) < SETTLED * rpm:
            break
    return corner, rpm


def _is_smooth(system: System) -> bool:
    """Whether the slope of the cam jumps nowhere: at no end of a stretch, as far as balls tell."""
    with precision(DIGITS):
        stretches = BallMachine(system.shape, system.follower, 1.0).stretches
        for k, after in enumerate(stretches):
            before = stretches[k - 1]
            slope_before = before.derivatives(before.end, 1)[1]
            slope_after = after.derivatives(after.start, 1)[1]
            if not slope_before.overlaps(slope_after):
                return False
    return True


def _constants(system: System) -> dict[str, str | None]:
    """The constants of the machine, without its speed."""
    known = vars(system.follower)
    return {key: None if key == "rpm" else exact(known[key]) for key in CONSTANTS}


def _end(rpm: arb, side: int) -> arb:
    """An end of the range about a speed, with few digits."""
    return arb(_text(rpm.mid() * (1 + side * arb(HALF)))).mid()


def _text(x: arb) -> str:
    """A number to fewer digits than are known."""
    return x.str(DIGITS - 10, radius=False).replace("e+", "e")


def _at_start(stretches: Sequence[BallStretch], theta: float) -> int | None:
    """The stretch that starts at a phase known as a double; None where none does."""
    for k, one in enumerate(stretches):
        if abs(one.start - theta) < AT_CORNER:
            return k
    return None


def _nearest_end(stretches: Sequence[BallStretch], phase: float) -> Place:
    """The end of a stretch that lies next to a phase (rad), counted on from turn to turn."""
    turn = int(phase // float(2 * arb.pi()))
    ends = [
        Place(k, turn + more) for k in range(len(stretches)) for more in (-1, 0, 1)
    ]  # of this turn and its neighbours
    return min(ends, key=lambda end: abs(float(_phase(stretches, end)) - phase))


def _phase(stretches: Sequence[BallStretch], end: Place) -> arb:
    """Where a stretch ends, counted on from turn to turn, rad."""
    return stretches[end.stretch].end + 2 * arb.pi() * end.turn


def _place(stretches: Sequence[BallStretch], phase: arb) -> Place:
    """The stretch that holds a phase (rad), counted on from turn to turn.

    Raises UndecidedError where the ball of the phase reaches an end of a stretch.
    """
    turn = int(float((phase / (2 * arb.pi())).mid().floor()))
    within = phase - 2 * arb.pi() * turn
    for k, stretch in enumerate(stretches):
        if stretch.start < within and within < stretch.end:
            return Place(k, turn)
    raise UndecidedError


def _force_cuts(machine: BallMachine, stretch: BallStretch) -> list[str]:
    """The phases that cut a stretch into parts on which the force is shown to be above zero.

    As text, rad, ascending. A part is halved until it is shown; raises UndecidedError where one is
    not after DEEPEST halvings.
    """

    def force(c: Sequence[arb]) -> arb:
        """The force by m omega^2, from the lift and its derivatives."""
        return c[2] + machine.Z2 * c[1] + machine.W2 * c[0] + machine.G

    def holds(low: arb, high: arb) -> bool:
        """Whether the force is shown to be above zero at every phase from low to high.

        It is where it rises throughout from a force above zero at low, where it falls throughout to
        one above zero at high, or where the mean value theorem says so.
        """
        phase = low.union(high)
        _, c1, c2, c3 = stretch.derivatives(phase, 3)
        slope = c3 + machine.Z2 * c2 + machine.W2 * c1
        at_low = force(stretch.derivatives(low, 2))
        if slope > 0 and at_low > 0:
            return True
        if slope < 0 and force(stretch.derivatives(high, 2)) > 0:
            return True
        return bool(at_low + (phase - low) * slope > 0)

    cuts: list[str] = []
    parts = [(stretch.start, stretch.end, 0)]  # to be shown: the next one last; times halved
    while parts:
        low, high, depth = parts.pop()
        if holds(low, high):
            cuts.append(_text(high))
            continue
        if depth == DEEPEST:
            raise UndecidedError
        middle = arb(round(float(low + high) / 2, 12))
        parts += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return cuts[:-1]  # the last one is the end of the stretch
