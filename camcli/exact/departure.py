"""Where a resting follower leaves the cam, in decimals from the double that the kernel found.

It leaves where its relative acceleration on the cam, a = -(G + W^2 c + 2 Z c_theta) - c_thetatheta,
rises through zero: on a smooth part by Newton's method, at a corner where a jumps from below zero
to above. An edge of c_theta throws it off with the rate -jump where it falls away, and strikes it,
u+ = r jump, where it rises.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from camcli.cams.compile import SMALLEST_KICK
from camcli.exact.drive import Drive
from camcli.exact.lifts import Lifts
from camcli.kernel.cam_table import ROW, START
from camcli.kernel.sticking import contact_accel

AT_CORNER = 1e-12  # rad
CLEAR = 1e-9  # of the size of its terms: an acceleration nearer to zero has no sign
STEPS = 24
ENOUGH = Decimal("1e-70")  # rad


@dataclass(frozen=True)
class Departure:
    """Leaving the cam: stretch, phase (rad), relative rate (m/rad, 0 at a lift-off)."""

    i: int
    theta: Decimal
    rate: Decimal


def departure(drive: Drive, lane, cam, lifts: Lifts, i: int, theta: float) -> Departure | None:
    """The departure near theta on stretch i; None where its kind is not certain."""
    begins, _ = lifts.edges(i)
    if abs(float(begins) - theta) > AT_CORNER or float(cam.rows[i * ROW + START]) != theta:
        return _lift_off(drive, lane, cam, lifts, i, theta)
    before = i - 1 if i else len(lifts.parts) - 1
    last = lifts.edges(before)[1]
    jump = lifts.c1(i, begins) - lifts.c1(before, last)
    if abs(jump) > 2 * Decimal(SMALLEST_KICK):
        return Departure(i, begins, -jump if jump < 0 else drive.r * jump)
    after, size = _accel(drive, lifts, i, begins)
    held, _ = _accel(drive, lifts, before, last)
    certain = abs(jump) < Decimal(SMALLEST_KICK) / 2 and after > Decimal(CLEAR) * size and held < 0
    return Departure(i, begins, Decimal(0)) if certain else None


def _lift_off(drive, lane, cam, lifts, i, theta) -> Departure | None:
    _, slope, size = contact_accel(cam, lane, i, theta)
    if not slope > CLEAR * size:
        return None
    rise, at = Decimal(slope), Decimal(theta)
    for _ in range(STEPS):
        step = _accel(drive, lifts, i, at)[0] / rise
        at -= step
        if abs(step) < ENOUGH:
            low, high = lifts.edges(i)
            return Departure(i, at, Decimal(0)) if low < at < high else None
    return None


def _accel(drive: Drive, lifts: Lifts, i: int, theta: Decimal) -> tuple[Decimal, Decimal]:
    """(relative acceleration at rest, size of its terms)."""
    c, c1, c2 = lifts.c(i, theta), lifts.c1(i, theta), lifts.c2(i, theta)
    size = abs(drive.G) + abs(drive.W2 * c) + abs(2 * drive.Z * c1) + abs(c2)
    return drive.contact(c, c1, c2), size
