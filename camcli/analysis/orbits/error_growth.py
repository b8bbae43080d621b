"""How much of its start an orbit remembers: the largest growth of a phase error between two rests.

An orbit that rests on the cam leaves it at a phase known to rounding. If an error of that phase
grows by more than doubles have digits, the next impacts are an accident of rounding, and that such
a run closes on itself says nothing about the machine. An error dtheta at the first impact, a hop of
s rad and incoming rate u after lift-off, is a difference (u, u/s) dtheta of position and velocity;
flights and impacts carry it on (saltation matrices: Leine & Nijmeijer, Dynamics and Bifurcations of
Non-Smooth Mechanical Systems, 2004, ch. 7), and at an impact it is a phase error again, |dq/u|.
"""

from __future__ import annotations

from camcli.analysis.integrate import Record
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.orbit_loop import DETACHMENT, IMPACT
from camcli.kernel.variational import after_flight, after_impact
from camcli.system import System

TOO_LARGE = 7e10  # growth of a phase error that leaves five digits of a turn


def largest_growth(system: System, rpm: float, record: Record, window: range) -> float:
    """Largest factor between a phase error after a rest and one before the next, in these turns."""
    cam, const, strobe = system.cam, system.constants(rpm, 1.0, 1), system.strobe
    largest = 0.0
    last: float | None = None  # rad since period 0, of the last event of a motion from rest
    pair: tuple[float, float] | None = None  # its difference; none before the first impact
    for kind, period, phase, rate in zip(
        record.kind, record.period, record.theta, record.u, strict=True
    ):
        if period not in window:
            continue
        theta, u = float(phase), float(rate)
        place = theta - strobe + (TURN if theta < strobe else 0.0) + TURN * int(period)
        if kind != IMPACT or last is None:
            last, pair = place if kind == DETACHMENT else None, None
            continue
        s = place - last
        if pair is None:
            dq, dw = -u, -u / s if s > 0.0 else 0.0
        else:
            dq, _, dw, _ = after_flight(const, s, pair[0], 0.0, pair[1], 0.0)
        largest = max(largest, abs(dq / u))
        lifts = lift_at(cam, stretch_at(cam, theta), theta)
        dq, _, dw, _ = after_impact(const, lifts, u, dq, 0.0, dw, 0.0)
        last, pair = place, (dq, dw)
    return largest
