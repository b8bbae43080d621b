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
from camcli.exact.shooting import Shooting

DIGITS = 6  # of an area and a share, rounded down
CERTAIN = 1.0 - 1e-14  # times a double that was rounded is less than the number it is of


class Starts(NamedTuple):
    """Starts at the strobe that certainly tend to an orbit.

    area: least area, m * m/s; share: of the window of starts, None where they may reach beyond it.
    """

    area: float
    share: float | None


class Image(NamedTuple):
    """States at the strobe that come from an ellipse: their area and what holds them, m and s."""

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
    wide = list(z)
    for k, (a, b, c, d) in enumerate(axes):
        wide[2 * k] += arb(0, hypot(a, b))
        wide[2 * k + 1] += arb(0, hypot(c, d))
    machine = shooting.machine(z[-1])
    omega = arb(rpm) * arb.pi() / 30
    images = []
    for k in range(shooting.n):
        after = wide[2 * k] + shooting.span(wide, k)  # not before any flight's own start
        for turn in range(shooting.landing(k).turn - shooting.places[k].turn + 1):
            at = arb(strobe) + turn * machine.turn
            if wide[2 * k] < at and at < after:
                images.append(_image(shooting, machine, z, wide, axes[k], k, at, omega))
    area = sum((image.area for image in images), arb(0))
    if not area > 0:
        return None
    inside = all(
        q[0] < image.q and image.q < q[1] and v[0] < image.v and image.v < v[1] for image in images
    )
    window = (arb(q[1]) - arb(q[0])) * (arb(v[1]) - arb(v[0]))
    return Starts(_down(area), _down(area / window) if inside else None)


def _image(
    shooting: Shooting,
    machine: BallMachine,
    z: list[arb],
    wide: list[arb],
    axes: tuple[float, float, float, float],
    k: int,
    at: arb,
    omega: arb,
) -> Image:
    """The states at a phase (rad, counted from the turn of impact k) after flights from ellipse k.

    They are off that of the orbit by at most the slopes by theta and v, along the ellipse's axes.
    """
    a, b, c, d = (arb(x) for x in axes)
    lift, lift1, _ = shooting.lift(machine, shooting.places[k], z[2 * k])
    q, w, _ = machine.move(lift, lift1 + z[2 * k + 1], at - z[2 * k], 2)
    decay = (-2 * machine.Z * (at - wide[2 * k])).exp()
    area = z[2 * k + 1] * arb.pi() * abs(a * d - b * c) * decay * omega

    lift, lift1, lift2 = shooting.lift(machine, shooting.places[k], wide[2 * k])
    v = wide[2 * k + 1]
    accel = -(machine.G + machine.W2 * lift + 2 * machine.Z * (lift1 + v)) - lift2
    f, f1, p = machine.flow(at - wide[2 * k])
    q_by_theta, q_by_v = -(v * (1 - machine.W2 * p) + f * accel), f
    w_by_theta, w_by_v = machine.W2 * f * v - f1 * accel, f1
    q_off = _length(q_by_theta * a + q_by_v * c, q_by_theta * b + q_by_v * d)
    w_off = _length(w_by_theta * a + w_by_v * c, w_by_theta * b + w_by_v * d)
    return Image(area, _about(q, q_off), _about(w, w_off) * omega)


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
