"""A curve in two numbers that comes back to its first point is drawn once, and only then closed.

The curves are circles and figures of eight: a stand-in for the solver returns their points, and the
phases of their one impact move as fast as a test says.
"""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, pi, sin

import pytest
from conftest import chapter_system

from camcli.analysis.orbits import curves
from camcli.analysis.orbits.curves import CurvePoint, Plane, curve
from camcli.analysis.orbits.locate import Bracket, Kind, Located
from camcli.analysis.orbits.shooter import Root, Shooter

MIDDLE, RADIUS = (710.0, 0.75), (30.0, 0.1)  # rpm, restitution
PLANE = Plane(("rpm", "restitution"), ((660.0, 760.0), (0.5, 1.0)), 50)


def circle(angle):
    return cos(angle), sin(angle)


def eight(angle):
    return cos(angle), sin(2.0 * angle)


PIECES = 2_000
AROUND = {
    shape: [shape(2.0 * pi * k / PIECES) for k in range(PIECES + 1)] for shape in (circle, eight)
}


def apart(tracer, one, here, root):
    """How far a point is from the last one, in both numbers and in its phase."""
    there = tracer.values(one)
    across, up = ((a - b) / r for a, b, r in zip(there, here, RADIUS, strict=True))
    return hypot(across, up, one.theta[0] - root.theta[0])


def closed_tracer(shape, speed):
    """A tracer whose curve is `shape`, the places of an angle; its impact moves by rad per rad."""

    class Tracer(curves._Tracer):
        def at(self, angle):
            across, up = shape(angle)
            place = [MIDDLE[0] + RADIUS[0] * across, MIDDLE[1] + RADIUS[1] * up]
            machine = list(Shooter(self.system, 700.0, "rpm").at(700.0))
            for name, value in zip(PLANE.names, place, strict=True):
                machine[curves.place_of(self.system, name)] = value
            # the impact's phase tells the angle, and is the same after a whole way round
            theta = 1.5 + 0.5 * speed * sin(angle)
            x = [theta, 1.0, place[0]]
            return Root(x, (0, 0), 1, tuple(machine), curves.place_of(self.system, "rpm"),
                        [-1.0], [0.0, 0.0, 1.0], 0.0, 1e-15, 1)  # fmt: skip

        def solve(self, root, guess, free, value):
            """The point with one number at `value` that is nearest to the last one on the way."""
            wanted = (value - MIDDLE[1 - free]) / RADIUS[1 - free]
            here = self.values(root)
            points = []
            for k in range(PIECES):
                a, b = AROUND[shape][k][1 - free], AROUND[shape][k + 1][1 - free]
                if min(a, b) <= wanted <= max(a, b) and a != b:
                    points.append(self.at(2.0 * pi / PIECES * (k + (wanted - a) / (b - a))))
            return min(points, key=lambda one: apart(self, one, here, root), default=None)

        def shooter(self, root, free, value):
            return None

        def _refusal(self, root, shooter):
            return None

        def point(self, root):
            return CurvePoint(*self.values(root), root)

    return Tracer


@pytest.mark.parametrize("start", [0.3, 0.5 * pi])  # there the figure of eight crosses itself
@pytest.mark.parametrize(("shape", "speed"), [(circle, 0.0), (circle, 0.5), (circle, 2.0),
                                              (circle, 5.0), (eight, 1.0)])  # fmt: skip
def test_a_curve_goes_round_once(monkeypatch, shape, speed, start):
    tracer = closed_tracer(shape, speed)
    monkeypatch.setattr(curves, "_Tracer", tracer)
    system = chapter_system()
    root = tracer(system, None, PLANE).at(start)
    located = Located(Kind.PERIOD_DOUBLING, root, 0.0, 0.0, next(iter(Bracket)))
    found = curve(system, located, PLANE, "P(1;1)", "")
    assert found.ends == (Kind.CLOSED, Kind.CLOSED)
    places = [point.values for point in found.points]
    assert places[0] == places[-1]
    shares = [((a - MIDDLE[0]) / RADIUS[0], (b - MIDDLE[1]) / RADIUS[1]) for a, b in places]
    whole = length(AROUND[shape])
    assert whole * 0.9 < length(shares) <= whole


def length(places):
    """Of the line through places."""
    return sum(hypot(c - a, d - b) for (a, b), (c, d) in pairwise(places))
