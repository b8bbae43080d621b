"""How much of its start an orbit remembers: the largest growth of a phase error between two rests.

An orbit that rests on the cam leaves it at a phase known to rounding. If an error of that phase
grows by more than doubles have digits, the next impacts are an accident of rounding, and that such
a run closes on itself says nothing about the machine. An error dtheta at the first impact, a hop of
s rad and incoming rate u after lift-off, is a difference (u, u/s) dtheta of position and velocity;
flights and impacts carry it on, and at an impact it is an error of its phase again, |dq/u|.
"""

from __future__ import annotations

from camcli.analysis.integrate import DETACHMENT, IMPACT, Tape
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.flow import Lane
from camcli.kernel.variational import after_flight, after_impact
from camcli.system import System

FORGOTTEN = 7e10  # growth of a phase error that leaves five digits of a turn


def forgets(system: System, rpm: float, tape: Tape, turns: int) -> bool:
    """True where a cycle of `turns` turns at the end of a record is an accident of rounding."""
    window = range(max(0, tape.periods - 2 * turns), tape.periods)
    return largest_growth(system, rpm, tape, window) > FORGOTTEN


def largest_growth(system: System, rpm: float, tape: Tape, window: range) -> float:
    """Largest factor between a phase error after a rest and one before the next, in these turns."""
    follower = _Difference(system, system.lane(rpm, 1.0, 1))
    for event in zip(tape.kind, tape.period, tape.theta, tape.u, strict=True):
        if event[1] in window:
            follower.take(*event)
    return follower.largest


class _Difference:
    """One difference between two orbits, from lift-off to lift-off."""

    def __init__(self, system: System, lane: Lane):
        self.cam, self.lane, self.strobe = system.cam, lane, system.strobe
        self.place: float | None = None  # rad since period 0, of the last event
        self.pair: tuple[float, float] | None = None
        self.largest = 0.0

    def take(self, kind, period, theta, u) -> None:
        """Go on to the next logged event."""
        since = float(theta) - self.strobe + (TURN if theta < self.strobe else 0.0)
        place = since + TURN * int(period)
        if kind == DETACHMENT:
            self.place, self.pair = place, None
        elif kind == IMPACT and self.place is not None:
            self._impact(place - self.place, float(theta), float(u))
            self.place = place
        else:
            self.place, self.pair = None, None

    def _impact(self, s: float, theta: float, u: float) -> None:
        if self.pair is None:
            dq, dw = -u, -u / s if s > 0.0 else 0.0
        else:
            dq, _, dw, _ = after_flight(self.lane, s, self.pair[0], 0.0, self.pair[1], 0.0)
        self.largest = max(self.largest, abs(dq / u))
        lifts = lift_at(self.cam, stretch_at(self.cam, theta), theta)
        dq, _, dw, _ = after_impact(self.lane, lifts, u, dq, 0.0, dw, 0.0)
        self.pair = (dq, dw)
