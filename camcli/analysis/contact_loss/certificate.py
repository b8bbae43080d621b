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
    known = no_statement(system, detachment, cam) not in OF_THE_CAM
    asked: list[CriticalSpeed | CornerHit] = []
    if detachment.first is not None and detachment.first.finite:
        asked.append(detachment.first)
    lift_offs = {loss.region.name: loss.opens.theta for loss in detachment.losses}
    asked += [hit for hit in hits if hit.status is SpeedStatus.OK and hit.burst in lift_offs]
    statements = []
    uncovered = []
    for one in asked:
        statement = None
        if known and isinstance(one, CornerHit):
            statement = corner_statement(system, one, lift_offs[one.burst])
        elif known and isinstance(one, CriticalSpeed):
            statement = detachment_statement(system, one)
        if statement is None:
            uncovered.append(name_of(one))
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
    """Why the first detachment has no statement, None where it can have one; cam: as there."""
    if cam is None or any(one["seat"] for one in cam["stretches"]):
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
    m omega^2 c'' + omega b c' + k c + m g + F0 = 0.
    """
    with precision(DIGITS):
        machine = BallMachine(system.shape, system.follower, 1.0)
        after = _at_start(machine.stretches, first.theta)
        if after is None:
            return None
        before = (after - 1) % len(machine.stretches)
        sides = [(speed, k, at_end) for k, at_end in ((after, False), (before, True))
                 if (speed := _force_ends(machine, k, at_end)) is not None]  # fmt: skip
        if not sides:
            return None
        rpm, stretch, at_end = min(sides, key=lambda side: float(side[0]))
        low, high = (_end(rpm, side) for side in (-1, 1))
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

    machine: at 1 rpm.
    """
    there = machine.stretches[stretch]
    c, c1, c2 = there.derivatives(there.end if at_end else there.start, 2)
    level = machine.G + machine.W2 * c
    slowing = machine.Z2 * c1
    root = slowing * slowing - 4 * c2 * level
    if not (c2 < 0 and root > 0):
        return None
    rpm = -(slowing + root.sqrt()) / (2 * c2)
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
    """`corner_statement` of a follower that leaves the cam at the start of a stretch."""
    theta = float(stretches[start].start)

    def impacts(rpm: arb) -> Hits:
        """The impacts up to that number, at one speed."""
        machine = BallMachine(stretches, system.follower, rpm)
        motion = BallMotion(machine, system.strobe, theta)
        while len(motion.trail.impacts) < hit.impact:
            motion.step()
        rows = motion.trail.impacts[: hit.impact]
        return Hits([phase for phase, _ in rows], [-machine.r * u for _, u in rows])

    landed = float(impacts(arb(hit.rpm)).theta[-1])
    corner = _nearest_end(stretches, landed)
    goal = _phase(stretches, corner)
    before, rpm = arb(hit.rpm) * (1 - FIRST_CHANGE), arb(hit.rpm)
    late = impacts(before).theta[-1] - goal
    for _ in range(SECANT_STEPS):
        try:
            now = impacts(rpm).theta[-1] - goal
        except UndecidedError:  # so near to the corner that these digits see it on no side
            break
        step = (now * (rpm - before) / (now - late)).mid()
        before, late, rpm = rpm, now, (rpm - step).mid()
        if abs(step) < SETTLED * rpm:
            break
    low, high = (_end(rpm, side) for side in (-1, 1))
    ends = impacts(low), impacts(high)
    places = [Place(start, 0)]
    hull = [stretches[start].start, arb(0)]
    for k in range(hit.impact - 1):
        room = arb(0, ROOM)
        phase = (ends[0].theta[k] + room).union(ends[1].theta[k] + room)
        place = _place(stretches, phase)
        places.append(place)
        hull += [
            phase - 2 * arb.pi() * place.turn,
            (ends[0].v[k] + room).union(ends[1].v[k] + room),
        ]
    places.append(corner)
    hull += [stretches[corner.stretch].end, arb(0), low.union(high)]
    turns = 1 + max(place.turn for place in places)
    shooting = Shooting(system.shape, system.follower, None, "rpm", tuple(places), turns)
    flights = [divided_flight(shooting, hull, k, lifts=k == 0) for k in range(hit.impact)]
    return {
        "kind": "corner-hit",
        "constants": _constants(system),
        "low": exactly(low),
        "high": exactly(high),
        "start": start,
        "impacts": [
            {"stretch": place.stretch, "turn": place.turn, "low": _text(x.lower()),
             "high": _text(x.upper())}
            for place, x in zip(places[1:-1], hull[2:-3:2], strict=True)
        ],
        "corner": {"stretch": corner.stretch, "turn": corner.turn},
        "flights": flights,
    }  # fmt: skip


def _is_smooth(system: System) -> bool:
    """Whether the slope of the cam jumps nowhere."""
    with precision(DIGITS):
        stretches = BallMachine(system.shape, system.follower, 1.0).stretches
        pairs = zip([stretches[-1], *stretches[:-1]], stretches, strict=True)
        return all(
            one.derivatives(one.end, 1)[1].overlaps(after.derivatives(after.start, 1)[1])
            for one, after in pairs
        )


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


def _nearest_end(stretches: Sequence[BallStretch], phi: float) -> Place:
    """The end of a stretch that lies next to a phase, counted on from turn to turn."""
    turn = int(phi // float(2 * arb.pi()))
    places = [Place(k, turn + more) for k in range(len(stretches)) for more in (-1, 0, 1)]
    return min(places, key=lambda one: abs(float(_phase(stretches, one)) - phi))


def _phase(stretches: Sequence[BallStretch], end: Place) -> arb:
    """Where a stretch ends, counted on from turn to turn, rad."""
    return stretches[end.stretch].end + 2 * arb.pi() * end.turn


def _place(stretches: Sequence[BallStretch], phi: arb) -> Place:
    """The stretch that holds a phase, counted on from turn to turn."""
    turn = int(float((phi / (2 * arb.pi())).mid().floor()))
    within = phi - 2 * arb.pi() * turn
    for k, one in enumerate(stretches):
        if one.start < within and within < one.end:
            return Place(k, turn)
    raise UndecidedError


def _force_cuts(machine: BallMachine, one: BallStretch) -> list[str]:
    """The phases that cut a stretch into parts on which the force is shown to be above zero."""

    def force(c: Sequence[arb]) -> arb:
        """The force by m omega^2, from the lift and its derivatives."""
        return c[2] + machine.Z2 * c[1] + machine.W2 * c[0] + machine.G

    def holds(a: arb, b: arb) -> bool:
        """Whether the force is shown to be above zero at every phase from a to b.

        It is where it rises throughout from a force above zero at a, where it falls throughout to
        one above zero at b, or where the mean value theorem says so.
        """
        phase = a.union(b)
        _, c1, c2, c3 = one.derivatives(phase, 3)
        slope = c3 + machine.Z2 * c2 + machine.W2 * c1
        begin = force(one.derivatives(a, 2))
        if slope > 0 and begin > 0:
            return True
        if slope < 0 and force(one.derivatives(b, 2)) > 0:
            return True
        return bool(begin + (phase - a) * slope > 0)

    cuts: list[str] = []
    todo = [(one.start, one.end, 0)]
    while todo:
        a, b, depth = todo.pop()
        if holds(a, b):
            cuts.append(_text(b))
            continue
        if depth == DEEPEST:
            raise UndecidedError
        middle = arb(round(float(a + b) / 2, 12))
        todo += [(middle, b, depth + 1), (a, middle, depth + 1)]
    return cuts[:-1]
