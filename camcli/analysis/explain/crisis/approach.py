"""What the motion reaches first towards the change: a corner of the cam, or a new contact.

The least distance of impacts to each corner, and the lowest gap inside a flight, are measured at
two speeds before the change. One that shrinks to nothing there, on a straight line, is the cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from camcli.analysis.explain.crisis.attractor import Carried, impacts_of
from camcli.analysis.integrate import Record
from camcli.cams.regions import Corner, corner_list
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.flow import move

SPEEDS = (0.5, 0.9)  # of the way to the change: where distances are measured
REACHED = 1e-3  # rad, or of the attractor's size: a distance that counts as none
FADED = 1e-3  # of the strongest impact: one that has already faded
SLACK = 0.1  # of the way: between the change and where a distance would vanish
FLIGHTS = 400  # looked at for low gaps
POINTS = 48  # samples of the gap in each flight


@dataclass(frozen=True)
class Approach:
    """Least distances at two speeds before the change, the farther one first.

    corners: (corner, distance, distance), rad; gap: the lowest inside a flight, m (inf: no flight
    has one, 0: impacts already fade); low: a gap that counts as none, m. reached: the corner that
    an extrapolated distance reaches at `rpm`; grazes: True where it is the gap.
    """

    corners: tuple[tuple[Corner, float, float], ...]
    gap: tuple[float, float]
    low: float
    rpm: float | None = None
    reached: Corner | None = None

    @property
    def grazes(self) -> bool:
        """True where flights come down to a new contact at `rpm`."""
        return self.rpm is not None and self.reached is None


def approach(carried: Carried) -> Approach:
    """Measure before the bracket of `carried`, and extrapolate every distance on a line to zero."""
    way = carried.stays - carried.near
    speeds = [carried.near + share * way for share in SPEEDS]
    records = [carried.run(rpm, True) for rpm in speeds]
    near, close = (
        (
            [_distance(record, c) for c in corner_list(carried.system.cam)],
            low_gap(carried, rpm, record),
        )
        for rpm, record in zip(speeds, records, strict=True)
    )
    rows = tuple(zip(corner_list(carried.system.cam), near[0], close[0], strict=True))
    low = REACHED * float(carried.size[0])
    rpm, reached = None, None
    for corner, a, b, least in [*((*r, REACHED) for r in rows), (None, near[1], close[1], low)]:
        if inf > a > b > least:
            zero = speeds[1] + b * (speeds[1] - speeds[0]) / (a - b)
            if min(abs(zero - end) for end in carried.bracket) < SLACK * abs(way):
                rpm, reached = zero, corner
    return Approach(rows, (near[1], close[1]), low, rpm, reached)


def _distance(record: Record, corner: Corner) -> float:
    """Least distance of the impacts of a record to a corner, rad."""
    theta = impacts_of(record)[0]
    return float(np.abs((theta - corner.theta + TURN / 2) % TURN - TURN / 2).min(initial=inf))


def low_gap(carried: Carried, rpm: float, record: Record) -> float:
    """The lowest minimum of the gap inside a flight (m), of the first FLIGHTS flights.

    0 where impacts already fade, inf where no flight has a minimum.
    """
    cam, strobe = carried.system.cam, carried.system.strobe
    const = carried.system.constants(rpm, 1e-9, 1)
    theta, u, period = (column[: FLIGHTS + 1] for column in impacts_of(record))
    if min(abs(u)) <= FADED * max(abs(u)):
        return 0.0
    at = (theta - strobe) % TURN + TURN * period + strobe
    lows = [inf]
    for begin, rate, span in zip(at.tolist(), u.tolist(), np.diff(at).tolist(), strict=False):
        steps = [span * j / POINTS for j in range(POINTS)]
        lifts = [lift(cam, stretch_at(cam, x % TURN), x % TURN) for x in (begin + s for s in steps)]
        q, w = lifts[0][0], lifts[0][1] - const.r * rate
        gap = [move(const, q, w, s)[0] - c[0] for s, c in zip(steps, lifts, strict=True)]
        inner = zip(gap, gap[1:], gap[2:], strict=False)
        lows += [here for before, here, after in inner if before > here < after and here > 0.0]
    return min(lows)
