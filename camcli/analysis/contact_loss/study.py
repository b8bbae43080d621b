"""Everything `cam detach` answers for one machine and one range of speeds, in one result."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import NamedTuple

from camcli.analysis.contact_loss.accumulation import (
    CornerHit,
    completion_loss,
    corner_hits,
    corners_ahead,
    reaching,
    scan_speeds,
)
from camcli.analysis.contact_loss.bursts import (
    BURST_TURNS,
    Bursts,
    LiftOff,
    SettledMotion,
    lift_off,
    settled_motions,
)
from camcli.analysis.contact_loss.detachment import (
    CriticalSpeed,
    Detachment,
    Loss,
    SpeedStatus,
    detachment,
)
from camcli.analysis.contact_loss.force import Force, ForceCurve, Hertz
from camcli.analysis.contact_loss.hold import (
    Hold,
    hold_to,
    replaced,
    usual_margin,
    usual_precompression,
)
from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import BudgetSpentError, Cost, Orbit, Settings, with_turns
from camcli.analysis.labels import UNDECIDED
from camcli.analysis.loads import loads_of
from camcli.analysis.patience import cost_beyond, named_on
from camcli.analysis.speeds import Speed
from camcli.errors import Status
from camcli.kernel import backend
from camcli.piece_faults import piece
from camcli.system import System

FEWEST = 41  # speeds of the scan for changes
STANDSTILL = 0.0  # rpm: the limit of slow speeds, with the force of the spring alone
PAST = 16  # speeds past the first loss of contact at which the motion is measured
PAST_TURNS = 20  # of each from rest, and as many that are measured
LITTLE_WORK = 4000  # turns in all that plain Python does before the kernel would be compiled


@dataclass(frozen=True)
class ContactLoss:
    """The answers of `detach`.

    ends: speeds at which the end of a chatter reaches a corner, or jumps over it; completion:
    where it is complete no longer; landings: of single impacts on a corner. holds: springs;
    springs: the force at the speed of hold_to with the present spring (None) and with each of them;
    margin: what they leave, N. past: motions past the first loss of contact, without sections.
    at_work: the motion at the working speed, at_asked: that at a single speed of the range which
    is not past the loss; where they were asked for.
    """

    detachment: Detachment
    lift_offs: tuple[LiftOff, ...]
    ends: tuple[CriticalSpeed, ...]
    completion: tuple[CriticalSpeed, ...]
    landings: tuple[CornerHit, ...]
    speeds: tuple[SettledMotion, ...]
    forces: tuple[ForceCurve, ...]
    holds: tuple[Hold, ...]
    springs: tuple[tuple[Hold | None, ForceCurve], ...]
    margin: float
    past: tuple[Speed, ...]
    cost: Cost
    at_work: Speed | None = None
    at_asked: Speed | None = None

    @property
    def accumulation(self) -> list[CriticalSpeed]:
        """Speeds at which a chatter ends exactly at a corner."""
        return [c for c in self.ends if c.status is not SpeedStatus.JUMP]

    @property
    def jumps(self) -> list[CriticalSpeed]:
        """Changes of the burst's end that pass a corner without reaching it."""
        return [c for c in self.ends if c.status is SpeedStatus.JUMP]

    @property
    def hits(self) -> list[CornerHit]:
        """Landings on a corner."""
        return [hit for hit in self.landings if hit.status is SpeedStatus.OK]

    @property
    def ended(self) -> list[CornerHit]:
        """Where curves of landings end in a graze."""
        return [hit for hit in self.landings if hit.status is not SpeedStatus.OK]

    @property
    def critical_speeds(self) -> list[CriticalSpeed]:
        """Critical speeds in the order of detach.csv; standstill is no speed."""
        speeds = []
        if self.detachment.first:
            speeds.append(self.detachment.first)
        for loss in self.detachment.losses:
            speeds += [loss.opens, loss.fills]
        speeds += [*self.accumulation, *self.completion]
        return [speed for speed in speeds if speed.status is not SpeedStatus.STANDSTILL]

    @property
    def troubled(self) -> list[tuple[float, int]]:
        """(rpm, status) of the speeds whose simulation could not be finished."""
        both = [(s.rpm, s.status) for s in self.speeds] + [(s.rpm, s.status) for s in self.past]
        return [(rpm, status) for rpm, status in both if status != Status.OK]


def detach(
    system: System,
    rpms: Sequence[float],
    settings: Settings,
    *,
    settle: int = 3,
    impacts: int = 8,
    force_speeds: Sequence[float] | None = None,
    hold_speed: float | None = None,
    margin: float | None = None,
    precompression: float | None = None,
    accel_error: Sequence[float] = (0.0,),
    solid: float = inf,
    hertz: Hertz | None = None,
    working_speed: float | None = None,
    on_speed: Callable[[], None] = lambda: None,
) -> ContactLoss:
    """Where contact is lost, where chatter ends, and which spring would hold.

    rpms: the range; changes of the chatter are looked for between its speeds, each from rest and
    after `settle` turns; of `settings` the chatter tolerance and the impact budget are used.
    impacts: landings on corners are followed up to this number. force_speeds: speeds of the force
    curves. hold_speed: find the springs that press with `margin` (N) up to this speed, one of them
    with so much precompression (m), whatever the error of a measured c_thetatheta in its bounds;
    None: as usual (`hold`). solid: height (m) at which the present spring is solid. hertz: the
    contact, for the pressure along the force curves. working_speed: rpm at which the machine runs,
    where that is known, for a force curve of it, as there is one of hold_speed.
    """
    turns = len(rpms) * (settle + BURST_TURNS)
    backend.for_work(turns, LITTLE_WORK)
    lost = detachment(system)
    speeds = settled_motions(system, rpms, settings, settle, on_speed)
    cost = sum((speed.cost for speed in speeds), Cost())
    scan = speeds
    if 1 < len(rpms) < FEWEST:
        scan = settled_motions(system, rpm_grid(min(rpms), max(rpms), FEWEST), settings, settle)
        cost = sum((speed.cost for speed in scan), cost)
    chatter = _ChatterChanges(scan, impacts)
    cost = cost + chatter.follow_all(system, lost, settings.impact_budget)
    past = _motions_past(system, _past_speeds(lost, rpms), settings)
    cost = sum((speed.cost for speed in past), cost)
    springs = _Springs((), (), margin or 0.0)
    if hold_speed is not None:
        springs = _springs_to(
            system, hold_speed, margin, precompression, accel_error=accel_error, solid=solid
        )
    curve_speeds = _force_speeds(
        lost, rpms, force_speeds, hertz is not None, working_speed, hold_speed
    )
    return ContactLoss(
        detachment=lost,
        lift_offs=tuple(chatter.lift_offs),
        ends=tuple(chatter.ends),
        completion=tuple(chatter.completion),
        landings=tuple(chatter.landings),
        speeds=tuple(speeds),
        forces=_force_curves(system, curve_speeds, hertz),
        holds=springs.holds,
        springs=springs.curves,
        margin=springs.margin,
        past=past,
        cost=cost,
    )


def _force_curves(
    system: System, rpms: Sequence[float], hertz: Hertz | None
) -> tuple[ForceCurve, ...]:
    """The contact force over a turn at each speed; each curve is a piece that may fail alone."""
    force = Force(system)
    curves = [
        piece(f"the contact force at {rpm:.10g} rpm", partial(force.curve, rpm, hertz=hertz))
        for rpm in rpms
    ]
    return tuple(curve for curve in curves if curve is not None)


class _Springs(NamedTuple):
    """Springs that hold to a speed, see `ContactLoss`, and the margin that they leave, N."""

    holds: tuple[Hold, ...]
    curves: tuple[tuple[Hold | None, ForceCurve], ...]
    margin: float


def _springs_to(
    system: System,
    rpm: float,
    margin: float | None,
    precompression: float | None,
    *,
    accel_error: Sequence[float],
    solid: float,
) -> _Springs:
    """The springs that hold to a speed, and the contact force with each of them at that speed.

    margin (N) and precompression (m): None: as usual. Search and curves are two pieces, each of
    which may fail alone.
    """
    if margin is None:
        margin = usual_margin(system, rpm, accel_error)
    if precompression is None:
        precompression = usual_precompression(system)
    search = partial(hold_to, system, rpm, margin, precompression, accel_error, solid)
    holds = piece(f"the springs that hold to {rpm:.10g} rpm", search, [])
    curves = piece(
        "the contact force with other springs", lambda: list(_springs(system, rpm, holds)), []
    )
    return _Springs(tuple(holds), tuple(curves), margin)


class _ChatterChanges:
    """Where a lost contact lifts off, how far its bursts reach, and where they complete.

    The results are collected in lists, so that they stay when the budget is spent on the way; see
    `ContactLoss` for what is in them. scan: settled motions, in which the speeds stand at which a
    burst changes; impacts: landings on corners are followed up to this number.
    """

    def __init__(self, scan: Sequence[SettledMotion], impacts: int):
        self.scan = scan
        self.impacts = impacts
        self.lift_offs: list[LiftOff] = []
        self.ends: list[CriticalSpeed] = []
        self.completion: list[CriticalSpeed] = []
        self.landings: list[CornerHit] = []

    def follow_all(self, system: System, lost: Detachment, impact_budget: int) -> Cost:
        """Collect what happens to the bursts of every region in which contact is lost.

        Each region is a piece that may fail alone. Nothing is followed where contact is lost at any
        speed. Returns what it cost.
        """
        cost = Cost()
        for loss in lost.losses:
            if lost.first is None or not loss.opens.finite:
                continue
            bursts = Bursts(system, loss.region.name, loss.opens.theta, impact_budget)
            with suppress(BudgetSpentError):
                name = f"the chatter from region {loss.region.name}"
                piece(name, partial(self.follow, bursts, loss))
            cost = cost + bursts.cost
        return cost

    def follow(self, bursts: Bursts, loss: Loss) -> None:
        """Collect what happens to the bursts that begin where this contact is lost.

        `goal` is the phase of a corner in rad, counted on into the next turn where the follower
        meets it only there.
        """
        self.lift_offs.append(lift_off(bursts, loss))
        speeds_above = scan_speeds(loss.opens.rpm, loss.region.name, self.scan)  # rpm, rising
        for corner, goal in corners_ahead(bursts):
            ends_before = len(self.ends)
            self.ends.extend(reaching(bursts, corner, goal, speeds_above))
            if len(self.ends) > ends_before:
                # Single impacts meet a corner only above the speed at which the chatter's end does:
                # at the lower end of its bracket the whole burst lies before the corner.
                low = self.ends[ends_before].low
                high = speeds_above[-1]
                self.landings.extend(corner_hits(bursts, corner, goal, low, high, self.impacts))
        self.completion.extend(completion_loss(bursts, speeds_above))


def _springs(
    system: System, rpm: float, holds: Sequence[Hold]
) -> Iterator[tuple[Hold | None, ForceCurve]]:
    """The contact force's curve of the machine as it is (None), and with each spring that holds."""
    yield None, Force(system).curve(rpm)
    for hold in holds:
        if hold.stiffness is not None and hold.preload is not None:
            yield hold, Force(replaced(system, hold.stiffness, hold.preload)).curve(rpm)


def past_motions(
    system: System, rpms: Sequence[float], settings: Settings, count: int
) -> tuple[Speed, ...]:
    """The motions at some speeds past the first loss of contact, up to the end of the range."""
    backend.for_work(2 * PAST_TURNS * count, LITTLE_WORK)
    return _motions_past(system, _past_speeds(detachment(system), rpms, count), settings)


def _motions_past(system: System, rpms: Sequence[float], settings: Settings) -> tuple[Speed, ...]:
    """`motion_past` of these speeds, as far as the budget of work goes."""
    motions: list[Speed] = []
    with suppress(BudgetSpentError):
        motions.extend(motion_past(system, rpm, settings) for rpm in rpms)
    return tuple(motions)


def _past_speeds(lost: Detachment, rpms: Sequence[float], count: int = PAST) -> list[float]:
    """Speeds from the first loss of contact, without it, to the end of the range, rpm.

    They are equally spaced. Where contact is lost below the range already, or at every speed, the
    lowest speed of the range is one of them; where it holds all over the range there are none.
    """
    low = min(rpms)
    high = max(rpms)
    if lost.never:
        return []
    first = lost.first.rpm if lost.first else -inf  # lost at every speed, however low
    if first > high:
        return []
    low = max(low, first)
    speeds = rpm_grid(low, high, count if low < high else 1)
    return speeds[1:] if low == first else speeds


def motion_past(system: System, rpm: float, settings: Settings) -> Speed:
    """The motion at a speed, from rest, and what it loads; without its impacts and strobes.

    It is a piece of a run: where it fails, its status is FAULT, and nothing is known of it.
    """
    turns = with_turns(settings, PAST_TURNS, PAST_TURNS)

    def measured() -> Speed:
        """Simulate the speed, and measure the loads of its motion."""
        orbit = Orbit(system, rpm, turns)
        record = orbit.run()
        label, _, named_by = named_on(orbit, rpm, record)
        return Speed(
            value=rpm,
            rpm=rpm,
            label=label,
            impact_count=int(sum(record.impacts[: record.periods])),
            status=record.status,
            impacts=None,
            strobe=None,
            cost=record.cost + cost_beyond(record, named_by),
            loads=loads_of(system, rpm, record),
        )

    failed = Speed(rpm, rpm, UNDECIDED, None, Status.FAULT, None, None, Cost())
    return piece(f"the motion at {rpm!r} rpm, past the loss of contact", measured, failed)


def _force_speeds(
    lost: Detachment,
    rpms: Sequence[float],
    asked: Sequence[float] | None,
    with_pressure: bool,
    working: float | None,
    hold_speed: float | None,
) -> list[float]:
    """The speeds (rpm) of the force curves: those asked for, else those that tell most.

    These are the ends of the range `rpms`; the speeds within it at which contact is first lost and
    at which it is lost all over that region; and `working`, that of the machine, unless it is
    faster than the range. `hold_speed`, to which a spring shall hold, is one of them in any case.

    For the pressure standstill is one more: where the cam's acceleration lifts the follower off,
    as at the nose, inertia takes from the spring's force, so that the slowest cam presses hardest.
    """
    to_hold = [] if hold_speed is None else [hold_speed]
    if asked is not None:
        return list(dict.fromkeys([*asked, *to_hold]))
    low = min(rpms)
    high = max(rpms)
    speeds = {low, high, *to_hold}
    for loss in lost.losses:
        if lost.first and loss.region.name == lost.first.region:
            speeds.update(rpm for rpm in (loss.opens.rpm, loss.fills.rpm) if low < rpm < high)
    if with_pressure:
        speeds.add(STANDSTILL)
    if working is not None and working <= high:  # a faster one would dwarf the other curves
        speeds.add(working)
    return sorted(speeds)
