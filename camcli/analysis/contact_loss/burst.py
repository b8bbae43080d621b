"""One burst of impacts: from rest on the cam, over lift-off, to the end of the chatter."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from camcli.analysis.contact_loss.force import DEG, Force
from camcli.analysis.integrate import Cost, Orbit, Settings, Start
from camcli.errors import OK
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.kernel.sticking import contact_accel
from camcli.system import System, omega_of

FINEST = 1e-13  # fraction of a turn, error of the accumulation phase
STEP_BACK = 0.5 / DEG  # rad
TURNS = (0, 2)  # strobes passed by a burst: most end in the turn they began


@dataclass(frozen=True)
class Burst:
    """Unrolled phases in rad: `release` within the turn, all others counted on from it.

    `end` is where the chatter accumulates, inf where it does not within two turns; a burst that
    never began has release inf.
    """

    release: float
    impacts: list[float]
    end: float
    status: int = OK


class Bursts:
    """Bursts of one machine that begin where contact is lost around the phase `theta`.

    `name` is the region they begin in.
    """

    def __init__(self, system: System, name: str, theta: float, impact_budget: int):
        self.system, self.force, self.name, self.theta = system, Force(system), name, theta
        self.impact_budget = impact_budget
        self.cost, self.count = Cost(), 0
        self._known: dict[tuple[float, int], Burst] = {}

    def at(self, rpm: float, impacts: int = 0) -> Burst:
        """The burst at one speed, or its first `impacts` impacts; each simulated once."""
        key = rpm, impacts
        if key not in self._known:
            self._known[key] = self._simulated(rpm, impacts)
        return self._known[key]

    def _simulated(self, rpm: float, impacts: int) -> Burst:
        start = self._held_before(omega_of(rpm))
        if start is None:
            return Burst(inf, [], inf)
        budget = impacts or self.impact_budget  # the kernel stops where it is used up
        for turns in TURNS:
            settings = Settings(0, turns, FINEST, budget, Start(None, None, start))
            orbit = Orbit(self.system, rpm, settings)
            tape = orbit.run(strobes=False)
            self.cost, self.count = self.cost + tape.cost, self.count + 1
            found = first_burst(self.system, orbit, tape)
            if found.end < inf or found.status != OK:
                break
        return found

    def _held_before(self, omega: float) -> float | None:
        """A phase (deg) shortly before the lost set where the follower rests; None: nowhere."""
        steps = int(TURN / STEP_BACK)
        for k in range(1, steps):
            theta = (self.theta - k * STEP_BACK) % TURN
            if self.force.at_phase(theta, omega) > 0.0:
                return theta * DEG
        return None


def timeline(system: System, orbit: Orbit, tape) -> list[tuple[int, float, float]]:
    """(kind, theta, phase counted on from the first recorded strobe) of every event, in rad."""
    strobe = system.strobe
    rows = []
    for kind, period, theta, u in zip(tape.kind, tape.period, tape.theta, tape.u, strict=True):
        kind, theta = int(kind), float(theta)
        since = theta - strobe if theta >= strobe else theta - strobe + TURN
        rows.append((kind, theta, TURN * int(period) + since))
        if kind == IMPACT and orbit.lane.r * u == 0.0 and _pressed(system, orbit, theta):
            rows.append((CHATTER, *rows[-1][1:]))  # restitution 0: rests where it lands
    return rows


def _pressed(system: System, orbit: Orbit, theta: float) -> bool:
    return contact_accel(system.cam, orbit.lane, stretch_at(system.cam, theta), theta)[0] < 0.0


def first_burst(system: System, orbit: Orbit, tape) -> Burst:
    """The first burst of a record that begins at rest."""
    release = origin = inf
    impacts: list[float] = []
    for kind, theta, phase in timeline(system, orbit, tape):
        if kind == DETACHMENT and origin < inf:  # it rested unseen, below the kernel's resolution
            return Burst(release, impacts, impacts[-1] if impacts else release, tape.status)
        if kind == DETACHMENT:
            release, origin = theta, phase
        elif origin < inf and kind == IMPACT:
            impacts.append(release + (phase - origin))
        elif origin < inf and kind == CHATTER:
            return Burst(release, impacts, release + (phase - origin), tape.status)
    return Burst(release, impacts, inf, tape.status)
