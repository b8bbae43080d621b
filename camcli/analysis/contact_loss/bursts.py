"""Bursts of impacts by simulation: from rest on the cam, over lift-off, to the end of the chatter.

A burst is the impacts after one departure; complete: they end in a rest; incomplete: they do not in
the turns followed. A rest: the follower stays on the cam for a while (sticking), after a complete
chatter or an impact from which it does not bounce.

A chatter is complete where infinitely many impacts accumulate in finite time and the follower rests
again (Budd & Dux, Phil. Trans. R. Soc. A 347 (1994) 365); the kernel closes the series with the map
of Nordmark & Piiroinen, Nonlinear Dynamics 58 (2009) 85.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from math import inf, radians
from typing import NamedTuple

from camcli.analysis.contact_loss.detachment import Loss
from camcli.analysis.contact_loss.force import Force
from camcli.analysis.integrate import BudgetSpentError, Cost, Orbit, Record, Settings, Start
from camcli.cams.regions import SAME_PHASE
from camcli.errors import Status
from camcli.kernel.cam_table import TURN, restitution_at, stretch_at
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.kernel.sticking import contact_accel
from camcli.piece_faults import piece
from camcli.system import System, omega_of

FINEST = 1e-13  # fraction of a turn, error of the accumulation phase: what doubles still resolve
STEP_BACK = radians(0.5)  # any rest before the lost set will do
TURNS = (0, 2)  # strobes passed by a burst: most end in the turn they began
BURST_TURNS = 2  # turns of a settled motion: bursts begin in the first, may end in the second
ROUNDED = 1e-9  # rad: phases of one event, counted on from two origins, are as close
JUST_ABOVE = 1e-6  # relative: beyond the speed at which a region opens, for its burst


@dataclass
class Burst:
    """Phases in rad: `release` within the turn (inf: the burst goes on from before the record).

    begin, impacts and end are counted on from one origin. `end` is where the chatter accumulates,
    inf where it does not within the record.
    """

    release: float
    begin: float
    impacts: list[float] = field(default_factory=list)
    end: float = inf
    status: int = Status.OK

    def from_release(self) -> Burst:
        """The burst with all its phases counted on from `release`, none below it."""
        impacts = [self.release + (x - self.begin) for x in self.impacts]
        end = self.release + (self.end - self.begin)
        return Burst(self.release, self.release, impacts, end, self.status)


class _Seen(NamedTuple):
    """What a record shows: its bursts; of its first turn the impacts and the rests (rad).

    A rest begins where a chatter ends, whatever began that chatter: also the blow of a lobe that
    opens a valve, and the bounces of a valve on its seat.
    """

    bursts: list[Burst]
    impacts: list[float]
    rests: list[float]


def _bursts(system: System, orbit: Orbit, record: Record) -> _Seen:
    """The bursts of a record, and the impacts and rests of its first turn.

    Phases of bursts are counted on from the record's first strobe. With restitution 0 the follower
    rests where it lands, if it is pressed on: such an impact ends a burst as a chatter does.
    """
    bursts: list[Burst] = []
    impacts: list[float] = []
    rests: list[float] = []
    for kind, period, theta, _, u in record.events():
        phase = TURN * period + (theta - system.strobe) % TURN
        begins_rest = kind == CHATTER
        if kind == DETACHMENT:
            if bursts and bursts[-1].end == inf:  # it rested unseen, below the kernel's resolution
                last = bursts[-1]
                last.end = last.impacts[-1] if last.impacts else last.begin
            bursts.append(Burst(theta, phase))
        elif kind == IMPACT:
            if phase < TURN:
                impacts.append(theta)
            if not bursts:  # it was released before the record
                bursts.append(Burst(inf, phase))
            bursts[-1].impacts.append(phase)
            begins_rest = _stays(system, orbit, theta, u)
        if begins_rest and phase < TURN:
            rests.append(theta)
        if begins_rest and bursts and bursts[-1].end == inf:
            bursts[-1].end = phase
    return _Seen(bursts, impacts, rests)


def _stays(system: System, orbit: Orbit, theta: float, u: float) -> bool:
    """Whether the follower stays on the cam after an impact at theta with the rate u (m/rad).

    It does where it does not bounce, and the force presses it on.
    """
    i = stretch_at(system.cam, theta)
    if restitution_at(system.cam, orbit.const, i) * u != 0.0:
        return False
    accel, _, _ = contact_accel(system.cam, orbit.const, i, theta)
    return accel < 0.0


class Bursts:
    """Bursts of one machine that begin where contact is lost around the phase `theta`.

    `name` is the region they begin in.
    """

    def __init__(self, system: System, name: str, theta: float, impact_budget: int):
        self.system = system
        self.force = Force(system)
        self.name = name
        self.theta = theta
        self.impact_budget = impact_budget
        self.cost = Cost()
        self._known: dict[tuple[float, int], Burst] = {}

    def at(self, rpm: float, impacts: int = 0) -> Burst:
        """The burst at one speed, or its first `impacts` impacts; each simulated once.

        Phases are counted on from the release; one that never begins has release and end inf.
        """
        key = rpm, impacts
        if key not in self._known:
            self._known[key] = self._simulated(rpm, impacts)
        return self._known[key]

    def _simulated(self, rpm: float, impacts: int) -> Burst:
        """The first burst after a rest, simulated over more and more turns until it has ended.

        impacts: the most that are followed, 0 for the usual budget. A burst whose release is
        infinite says that the follower rests nowhere, or never leaves the cam.
        """
        burst = Burst(inf, inf)
        start = self._rest_before(omega_of(rpm))
        if start is None:
            return burst
        budget = impacts or self.impact_budget  # the kernel stops where it is used up
        for turns in TURNS:
            settings = Settings(0, turns, FINEST, budget, Start(theta=start))
            orbit = Orbit(self.system, rpm, settings)
            record = orbit.run(strobes=False)
            self.cost = self.cost + record.cost
            seen = _bursts(self.system, orbit, record)
            released = [one for one in seen.bursts if one.release < inf]
            burst = released[0].from_release() if released else Burst(inf, inf)
            burst.status = record.status
            if burst.end < inf or burst.status != Status.OK:
                break
        return burst

    def _rest_before(self, omega: float) -> float | None:
        """A phase (rad) shortly before the lost set where the follower rests; None: nowhere."""
        for k in range(1, int(TURN / STEP_BACK)):
            theta = (self.theta - k * STEP_BACK) % TURN
            if self.force.newton(stretch_at(self.system.cam, theta), theta, omega) > 0.0:
                return theta
        return None


class LiftOffKind(StrEnum):
    """How contact is lost just above the speed at which a region opens.

    FLIES_OFF: at the corner where the region begins, since the force drops there. CAUGHT: before
    the corner where it ends, since the force fades; caught behind it. WITHIN: inside the region.
    UNSEEN: there is no rest before it.
    """

    FLIES_OFF = "flies-off"
    CAUGHT = "released-and-caught"
    WITHIN = "within-region"
    UNSEEN = "unseen"


@dataclass(frozen=True)
class LiftOff:
    """Release, first landing and end of the chatter of one burst (rad, unrolled; inf: not seen)."""

    region: str
    kind: LiftOffKind
    corner: str
    rpm: float
    release: float
    landing: float
    rest: float


def lift_off(bursts: Bursts, loss: Loss) -> LiftOff:
    """One burst simulated just above loss.opens: how it begins and where it is caught."""
    region = loss.region
    theta = loss.opens.theta
    rpm = loss.opens.rpm * (1.0 + JUST_ABOVE)
    burst = bursts.at(rpm)
    from_end = min(abs(theta - region.end), abs(theta - region.end + TURN))
    kind = LiftOffKind.WITHIN
    corner = ""
    if burst.release == inf:
        kind = LiftOffKind.UNSEEN
    elif region.begins and abs(theta - region.start) < SAME_PHASE:
        kind = LiftOffKind.FLIES_OFF
        corner = region.begins
    elif region.ends and from_end < SAME_PHASE:
        kind = LiftOffKind.CAUGHT
        corner = region.ends
    landing = burst.impacts[0] if burst.impacts else burst.end
    return LiftOff(region.name, kind, corner, rpm, burst.release, landing, burst.end)


@dataclass(frozen=True)
class SettledBurst:
    """A burst of one turn: the region it begins in ("": it goes on from before), its end in rad.

    `end` lies within the turn; None where the chatter is incomplete.
    """

    region: str
    end: float | None


@dataclass(frozen=True)
class SettledMotion:
    """The motion at one speed after its settling turns; `impacts` and `rests` of one turn, rad.

    rests: where a chatter ends, also one that the opening blow or the seat began.
    """

    rpm: float
    bursts: tuple[SettledBurst, ...]
    impacts: tuple[float, ...]
    status: int
    cost: Cost
    rests: tuple[float, ...] = ()

    @property
    def ends(self) -> list[float]:
        """Where its complete chatters end, rad within the turn."""
        return [burst.end for burst in self.bursts if burst.end is not None]

    @property
    def other_rests(self) -> list[float]:
        """Where chatters end that no loss of contact began, rad within the turn."""
        return [x for x in self.rests if all(abs(x - end) > ROUNDED for end in self.ends)]


def settled_motions(
    system: System,
    rpms: Sequence[float],
    settings: Settings,
    settle: int,
    on_speed: Callable[[], None] = lambda: None,
) -> list[SettledMotion]:
    """The motion at each speed (rpm), from rest: after `settle` turns, one turn is looked at.

    on_speed: called after each. A speed whose piece fails has the status FAULT, one for which no
    work is left in the budget WORK_BUDGET; nothing is known of their motions.
    """
    force = Force(system)
    turns = Settings(
        settle, BURST_TURNS, settings.chatter_tolerance, settings.impact_budget, Start()
    )
    motions = []
    for rpm in rpms:
        failed = SettledMotion(rpm, (), (), Status.FAULT, Cost())
        try:
            simulate = partial(_settled_motion, force, rpm, turns)
            motions.append(piece(f"rpm = {rpm!r}", simulate, failed))
        except BudgetSpentError:
            motions.append(SettledMotion(rpm, (), (), Status.WORK_BUDGET, Cost()))
            continue
        on_speed()
    return motions


def _settled_motion(force: Force, rpm: float, turns: Settings) -> SettledMotion:
    """Simulate a speed from rest, and take the bursts of the turn that is looked at.

    Those are the bursts that begin in the turn; where none does, one that goes on from before it.
    """
    system = force.system
    orbit = Orbit(system, rpm, turns)
    record = orbit.run(strobes=False)
    seen = _bursts(system, orbit, record)
    bursts = seen.bursts
    if record.status == Status.OK:
        begun = [burst for burst in bursts if burst.release < inf and burst.begin < TURN]
        earlier = [burst for burst in bursts[:1] if not _begins_at_rest(system, burst)]
        bursts = begun or earlier
    return SettledMotion(
        rpm=rpm,
        bursts=tuple(_settled_burst(force, system.strobe, burst) for burst in bursts),
        impacts=tuple(seen.impacts),
        status=record.status,
        cost=record.cost,
        rests=tuple(seen.rests),
    )


def _begins_at_rest(system: System, burst: Burst) -> bool:
    """Whether no lost contact began a burst, but a lobe or a seat that struck a resting follower.

    With lash the slope of what holds the follower up jumps at two corners: there the opening lobe
    meets it, and the closing lobe sets it down.
    """
    if not system.has_seat or burst.release < inf or not burst.impacts:
        return False
    first = (burst.impacts[0] + system.strobe) % TURN
    return any(abs(first - corner) < SAME_PHASE for corner in system.corners)


def _settled_burst(force: Force, strobe: float, burst: Burst) -> SettledBurst:
    """A burst with its region, and its end as a phase of the turn; strobe: its phase, rad."""
    region = ""
    if burst.release < inf:
        region = force.region_of(stretch_at(force.cam, burst.release)).name
    end = (burst.end + strobe) % TURN if burst.end < inf else None
    return SettledBurst(region, end)
