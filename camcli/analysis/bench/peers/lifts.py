"""Cams in closed form, in doubles, for the peers and the dense search; nothing of the kernel.

A region is a smooth piece; region 0 begins at theta = 0 and the last one runs on past 2 pi to the
end of the first, since they are one piece.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

TWO_PI = 2.0 * math.pi
FLANK, NOSE, ROUND, WAVE = "flank", "nose", "round", "wave"  # forms of a region

Law = tuple[float, float, float]  # c, dc/dtheta, d2c/dtheta2


@dataclass(frozen=True)
class Region:
    """A form, the angle it is symmetric about, and its numbers: circle (kappa, rho) or height."""

    form: str
    centre: float
    numbers: tuple[float, ...]
    end: float  # rad, where the region ends


def circle(x: float, kappa: float, rho: float, offset: float) -> Law:
    """kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x) - offset and its two derivatives."""
    sin, cos = math.sin(x), math.cos(x)
    root = math.sqrt(rho * rho - (kappa * sin) ** 2)
    slope = -kappa * kappa * sin * cos / root
    bend = (-kappa * kappa * (cos * cos - sin * sin) - slope * slope) / root
    return kappa * cos + root - offset, slope - kappa * sin, bend - kappa * cos


class Lift:
    """Law of motion of a cam by regions."""

    def __init__(self, regions: list[Region], offset: float, top: float):
        self.regions, self.offset, self.top = regions, offset, top
        self.breaks = [region.end for region in regions[:-1]]

    def region(self, theta: float) -> int:
        """Index of the region at theta in [0, 2 pi); a breakpoint belongs to the right."""
        return bisect_right(self.breaks, theta)

    def law(self, index: int, theta: float) -> Law:
        """(c, c', c'') of a region, its formula continued."""
        region = self.regions[index]
        if region.form == ROUND:
            return region.numbers[0], 0.0, 0.0
        if region.form == WAVE:
            middle, half = region.numbers
            x = theta - region.centre
            cos = half * math.cos(x)
            return middle - cos, half * math.sin(x), cos
        return circle(theta - region.centre, *region.numbers, self.offset)

    def height(self, theta: float) -> float:
        """c at any angle."""
        theta %= TWO_PI
        return self.law(self.region(theta), theta)[0]


def _angles(s: Mapping[str, Any]) -> tuple[float, float]:
    """Corners a and b of three tangent circles: they touch on the line through their centres."""
    k1, r1, k2, r2 = (s[x] for x in ("flank_center", "flank_radius", "nose_center", "nose_radius"))
    cos_centres = (k1 * k1 + k2 * k2 - (r1 - r2) ** 2) / (2.0 * k1 * k2)
    both = math.pi - math.acos(cos_centres)  # angle from a to c
    x, y, scale = k2 * math.cos(both), k2 * math.sin(both), r1 / (r1 - r2)
    a = math.radians(180.0 - 0.5 * s["top_dwell_deg"]) - both
    return a, a + math.atan2(scale * y, scale * (x + k1) - k1)


def arcs(s: Mapping[str, Any]) -> Lift:
    """Three tangent circles, corners a to f."""
    k1, r1, k2, r2 = (s[x] for x in ("flank_center", "flank_radius", "nose_center", "nose_radius"))
    offset = s["offset"]
    a, b = _angles(s)
    c = math.radians(180.0 - 0.5 * s["top_dwell_deg"])
    d, e, f = TWO_PI - c, TWO_PI - b, TWO_PI - a
    base, top = r1 - k1 - offset, k2 + r2 - offset
    flank, nose = (-k1, r1), (k2, r2)
    regions = [
        Region(ROUND, 0.0, (base,), a),
        Region(FLANK, a, flank, b),
        Region(NOSE, c, nose, c),
        Region(ROUND, 0.0, (top,), d),
        Region(NOSE, d, nose, e),
        Region(FLANK, f, flank, f),
        Region(ROUND, 0.0, (base,), TWO_PI + a),
    ]
    return Lift(regions, offset, top)


def eccentric(s: Mapping[str, Any]) -> Lift:
    """c = base + lift (1 - cos theta)/2: one region, of two turns."""
    half = 0.5 * s["lift"]
    region = Region(WAVE, 0.0, (s["base"] + half, half), 2.0 * TWO_PI)
    return Lift([region], 0.0, s["base"] + s["lift"])


KINDS = {"arcs": arcs, "eccentric": eccentric}


def lift_of(section: Mapping[str, Any]) -> Lift:
    """The lift of a cam section; a further kind of cam is a further entry of KINDS."""
    return KINDS[section["kind"]](section)
