"""Cams in closed form, in doubles, for the peers; nothing of the kernel."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from typing import Any, NamedTuple

TWO_PI = 2.0 * math.pi
CIRCLE, DWELL, WAVE = "circle", "dwell", "wave"  # forms of a region

Law = tuple[float, float, float]  # c, dc/dtheta, d2c/dtheta2


class Region(NamedTuple):
    """A smooth piece of the cam: its form, its two numbers, the angle of its symmetry, its end.

    circle: c = kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x) - offset with (kappa, rho);
    wave: c = middle - half cos x with (middle, half); dwell: c = height with (height, 0).
    """

    form: str
    first: float
    second: float
    centre: float  # rad, x = theta - centre
    end: float  # rad


class Lift:
    """Law of motion of a cam by regions.

    Region 0 begins at theta = 0 and the last one runs on past 2 pi to the end of the first, since
    they are one piece.
    """

    def __init__(self, regions: list[Region], offset: float, top: float):
        self.regions, self.offset, self.top = regions, offset, top
        self.breaks = [region.end for region in regions[:-1]]

    def region(self, theta: float) -> int:
        """Index of the region at theta in [0, 2 pi); a breakpoint belongs to the right."""
        return bisect_right(self.breaks, theta)

    def law(self, index: int, theta: float) -> Law:
        """(c, c', c'') of a region, its formula continued."""
        form, first, second, centre, _ = self.regions[index]
        if form == DWELL:
            return first, 0.0, 0.0
        sin, cos = math.sin(theta - centre), math.cos(theta - centre)
        if form == WAVE:
            return first - second * cos, second * sin, second * cos
        root = math.sqrt(second * second - (first * sin) ** 2)
        slope = -first * first * sin * cos / root
        bend = (-first * first * (cos * cos - sin * sin) - slope * slope) / root
        return first * cos + root - self.offset, slope - first * sin, bend - first * cos

    def at(self, theta: float) -> Law:
        """(c, c', c'') at any angle."""
        theta %= TWO_PI
        return self.law(self.region(theta), theta)


def lift_of(section: Mapping[str, Any]) -> Lift:
    """The lift of a scene's section `cam`, of kind arcs or eccentric."""
    return {"arcs": _arcs, "eccentric": _eccentric}[section["kind"]](section)


def _arcs(s: Mapping[str, Any]) -> Lift:
    """Three tangent circles; neighbours touch on the line through their centres."""
    k1, r1, k2, r2 = (s[x] for x in ("flank_center", "flank_radius", "nose_center", "nose_radius"))
    cos_centres = (k1 * k1 + k2 * k2 - (r1 - r2) ** 2) / (2.0 * k1 * k2)
    both = math.pi - math.acos(cos_centres)  # angle from a to c
    x, y, scale = k2 * math.cos(both), k2 * math.sin(both), r1 / (r1 - r2)
    c = math.radians(180.0 - 0.5 * s["top_dwell_deg"])
    a = c - both
    b = a + math.atan2(scale * y, scale * (x + k1) - k1)
    d, e, f = TWO_PI - c, TWO_PI - b, TWO_PI - a
    base, top = r1 - k1 - s["offset"], k2 + r2 - s["offset"]
    regions = [
        Region(DWELL, base, 0.0, 0.0, a),
        Region(CIRCLE, -k1, r1, a, b),
        Region(CIRCLE, k2, r2, c, c),
        Region(DWELL, top, 0.0, 0.0, d),
        Region(CIRCLE, k2, r2, d, e),
        Region(CIRCLE, -k1, r1, f, f),
        Region(DWELL, base, 0.0, 0.0, TWO_PI + a),
    ]
    return Lift(regions, s["offset"], top)


def _eccentric(s: Mapping[str, Any]) -> Lift:
    """c = base + lift (1 - cos theta)/2: one region, of two turns."""
    half = 0.5 * s["lift"]
    region = Region(WAVE, s["base"] + half, half, 0.0, 2.0 * TWO_PI)
    return Lift([region], 0.0, s["base"] + s["lift"])
