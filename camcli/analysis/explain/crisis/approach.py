"""What the motion reaches first towards the change: a corner of the cam, or a new contact.

The least distance of impacts to each corner, and the lowest gap inside a flight, are measured at
two speeds before the change. One that shrinks to nothing there, on a straight line, is the cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from camcli.analysis.explain.crisis.runs import Carried, impacts_of
from camcli.analysis.integrate import Tape
from camcli.cams.regions import Corner, corner_list
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.flow import move

CORNER_IMPACT, GRAZING = "corner-impact", "grazing"
SPEEDS = (0.5, 0.9)  # of the way to the change: where distances are measured
REACHED = 1e-3  # rad, or of the attractor's size: a distance that counts as none
FADED = 1e-3  # of the strongest impact: one that has already faded
SLACK = 0.1  # of the way: between the change and where a distance would vanish
FLIGHTS = 400  # looked at for low gaps
POINTS = 48  # samples of the gap in each flight


class Fact(NamedTuple):
    """Something measured at two speeds, the one farther before the change first."""

    name: str
    before: float
    after: float


@dataclass(frozen=True)
class Approach:
    """Distances at two speeds before the change, and what is reached at `rpm`, if anything is.

    kind: corner-impact, grazing or ""; corners: (corner, distance rad at the first and second
    speed); gap: lowest gap inside a flight at both, m; low: a gap that would count as none, m.
    """

    kind: str
    rpm: float
    corner: Corner | None
    corners: tuple[tuple[Corner, float, float], ...]
    gap: tuple[float, float]
    low: float

    @property
    def facts(self) -> tuple[Fact, ...]:
        """The distances by name."""
        rows = [Fact(f"distance to corner {c.name}, rad", a, b) for c, a, b in self.corners]
        return (*rows, Fact("lowest gap in a flight, m", *self.gap))


def approach(carried: Carried) -> Approach:
    """Measure before the bracket of `carried`, and extrapolate every distance on a line to zero."""
    stays, leaves = carried.bracket
    way = stays - carried.near
    speeds = [carried.near + share * way for share in SPEEDS]
    tapes = [carried.run(rpm, True) for rpm in speeds]
    pairs = [(c, *(_distance(tape, c) for tape in tapes)) for c in corner_list(carried.system.cam)]
    gap = tuple(low_gap(carried, rpm, tape) for rpm, tape in zip(speeds, tapes, strict=True))
    low = REACHED * float(carried.size[0])
    kind, at, corner = "", leaves, None
    tests = [(CORNER_IMPACT, c, a, b, REACHED) for c, a, b in pairs]
    for name, place, a, b, least in [*tests, (GRAZING, None, *gap, low)]:
        if not inf > a > b > least:
            continue
        zero = speeds[1] + b * (speeds[1] - speeds[0]) / (a - b)
        if min(abs(zero - stays), abs(zero - leaves)) < SLACK * abs(way):
            kind, at, corner = name, zero, place
    return Approach(kind, at, corner, tuple(pairs), gap, low)


def _distance(tape: Tape, corner: Corner) -> float:
    """Least distance of the impacts of a record to a corner, rad."""
    theta = impacts_of(tape)[0]
    return float(np.abs((theta - corner.theta + TURN / 2) % TURN - TURN / 2).min(initial=inf))


def low_gap(carried: Carried, rpm: float, tape: Tape) -> float:
    """The lowest minimum of the gap inside a flight (m), of the first FLIGHTS flights.

    0 where impacts already fade, inf where no flight has a minimum.
    """
    cam, strobe = carried.system.cam, carried.system.strobe
    lane = carried.system.lane(rpm, 1e-9, 1)
    theta, u, period = (column[: FLIGHTS + 1] for column in impacts_of(tape))
    at = (theta - strobe) % TURN + TURN * period + strobe
    lows = [inf if min(abs(u)) > FADED * max(abs(u)) else 0.0]
    for k, span in enumerate(np.diff(at).tolist()):
        gap = _gaps(cam, lane, float(at[k]), float(u[k]), span)
        for before, here, after in zip(gap, gap[1:], gap[2:], strict=False):
            if before > here < after and here > 0.0:
                lows.append(here)
    return min(lows)


def _gaps(cam, lane, theta: float, u: float, span: float) -> list[float]:
    """Samples of the gap (m) in the flight that an impact of incoming rate u (m/rad) begins."""
    steps = [span * j / POINTS for j in range(POINTS)]
    lifts = [lift(cam, stretch_at(cam, x % TURN), x % TURN) for x in (theta + s for s in steps)]
    q, w = lifts[0][0], lifts[0][1] - lane.r * u
    return [move(lane, q, w, s)[0] - c[0] for s, c in zip(steps, lifts, strict=True)]
