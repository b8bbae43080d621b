"""How many starts at the strobe certainly tend to a stable orbit: an area, and a share of a window.

A motion that leaves the cam from an ellipse about an impact (`attraction`) tends to the orbit. It
flies to the next ellipse without a contact, and where it passes the strobe on the way its state
there is a start that ends at the orbit. A patch dtheta dv of impacts, v the outgoing relative rate,
becomes the area v exp(-2 Z s) dtheta dv of states (q, dq/dtheta) after s rad. The integral of v
over the ellipse is that of its middle times the area of the ellipse. Different impacts lead to
different states: the flight back from a state leads to one last impact.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Context
from math import hypot
from typing import NamedTuple

from flint import arb

from camcli.analysis.orbits.attraction import Axes
from camcli.analysis.orbits.evidence import Evidence
from camcli.exact.machine import BallMachine
from camcli.exact.shooting import Shooting, StateSlopes

DIGITS = 6  # of an area and a share, rounded down
CERTAIN = 1.0 - 1e-14  # times a double that was rounded is less than the number it is of


class Starts(NamedTuple):
    """Starts at the strobe that certainly tend to an orbit.

    area: least area, m * m/s; share: of the window of starts, None where they may reach beyond it.
    """

    area: float
    share: float | None


class StrobeStates(NamedTuple):
    """States at the strobe that come from an ellipse: their area (m * m/s), and balls of them.

    q: m; v: m/s.
    """

    area: arb
    q: arb
    v: arb


def starts(
    evidence: Evidence,
    axes: Axes,
    rpm: float,
    strobe: float,
    q: tuple[float, float],
    v: tuple[float, float],
) -> Starts | None:
    """The starts that come from ellipses about an orbit's impacts; None where no flight shows any.

    axes: of the ellipses, proved; strobe: its phase, rad; q, v: the window of starts, m and m/s.
    The precision in use is that of the evidence.
    """
    shooting = evidence.shooting
    z = evidence.boxes[0].hull()
    wide = list(z)  # of all motions from the ellipses
    for k, (a, b, c, d) in enumerate(axes):
        wide[2 * k] += arb(0, hypot(a, b))
        wide[2 * k + 1] += arb(0, hypot(c, d))
    machine = shooting.machine(z[-1])
    omega = arb(rpm) * arb.pi() / 30
    at_strobes = []
    for k in range(shooting.n):
        landing = wide[2 * k] + shooting.span(wide, k)
        for turn in range(shooting.landing(k).turn - shooting.places[k].turn + 1):
            phase = arb(strobe) + turn * machine.turn
            if wide[2 * k] < phase and phase < landing:
                ellipse = Ellipse(k, z, wide, axes[k])
                at_strobes.append(_states_at(shooting, machine, ellipse, phase, omega))
    area = sum((states.area for states in at_strobes), arb(0))
    if not area > 0:
        return None
    in_window = all(
        q[0] < states.q and states.q < q[1] and v[0] < states.v and states.v < v[1]
        for states in at_strobes
    )
    window = (arb(q[1]) - arb(q[0])) * (arb(v[1]) - arb(v[0]))
    return Starts(_down(area), _down(area / window) if in_window else None)


class Ellipse(NamedTuple):
    """The ellipse about impact k of an orbit.

    z: balls of the orbit's unknowns; wide: of those of all motions from ellipses; axes: a, b, c, d
    of M = [[a, b], [c, d]], rad and m/rad.
    """

    k: int
    z: list[arb]
    wide: list[arb]
    axes: tuple[float, float, float, float]


def _states_at(
    shooting: Shooting, machine: BallMachine, ellipse: Ellipse, phase: arb, omega: arb
) -> StrobeStates:
    """The states at a phase after flights from an ellipse; omega: of the cam, rad/s.

    phase: rad, counted from the turn of the ellipse's impact. They are off the state of the orbit
    by at most the slopes by theta and v, along the ellipse's axes.
    """
    a, b, c, d = (arb(x) for x in ellipse.axes)
    place = shooting.places[ellipse.k]
    theta = ellipse.z[2 * ellipse.k]
    v = ellipse.z[2 * ellipse.k + 1]
    lift, lift1, _ = shooting.lift(machine, place, theta)
    q, w, _ = machine.move(lift, lift1 + v, phase - theta, 2)  # of the orbit
    wide_theta = ellipse.wide[2 * ellipse.k]
    wide_v = ellipse.wide[2 * ellipse.k + 1]
    decay = (-2 * machine.Z * (phase - wide_theta)).exp()
    area = v * arb.pi() * abs(a * d - b * c) * decay * omega

    lift, lift1, lift2 = shooting.lift(machine, place, wide_theta)
    accel = -(machine.G + machine.W2 * lift + 2 * machine.Z * (lift1 + wide_v)) - lift2
    by = StateSlopes.after(machine, phase - wide_theta, wide_v, accel)
    q_off = _length(by.q_by_theta * a + by.q_by_v * c, by.q_by_theta * b + by.q_by_v * d)
    w_off = _length(by.w_by_theta * a + by.w_by_v * c, by.w_by_theta * b + by.w_by_v * d)
    return StrobeStates(area, _about(q, q_off), _about(w, w_off) * omega)


def _length(x: arb, y: arb) -> arb:
    """The length of a vector."""
    return (x * x + y * y).sqrt()


def _about(middle: arb, off: arb) -> arb:
    """The ball of all numbers at most `off` away from `middle`."""
    return middle + arb(0, 1) * off.abs_upper()


def _down(x: arb) -> float:
    """A lower bound of a positive number, with few digits."""
    return rounded_down(float(x.abs_lower()) * CERTAIN, DIGITS)


def rounded_down(x: float, digits: int) -> float:
    """A number with so many digits, not above x."""
    return float(Context(prec=digits, rounding=ROUND_FLOOR).create_decimal_from_float(x))
