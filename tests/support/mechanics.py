"""A machine of its own to judge tables with: cam, flow and contact force in closed form, in NumPy.

Nothing comes from the package: lifts are the formulas of circles and laws of motion, the flow is
that of `tests.support.oracle`, extremes are sampled densely and then refined.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import pi
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf
from scipy.optimize import minimize_scalar

from tests.support import oracle

TURN = 2 * pi
RAD = pi / 180
EDGE = 1e-12  # rad: so near to an edge of the cam a phase is that edge


def polynomial(terms: dict[int, float]):
    """(s, s', s'') of a law given by its powers of x."""

    def law(x, lib):
        """(s, ds/dx, d2s/dx2) of the polynomial at x, in numbers of any library."""
        s = sum(a * x**n for n, a in terms.items())
        first = sum(a * n * x ** (n - 1) for n, a in terms.items())
        second = sum(a * n * (n - 1) * x ** (n - 2) for n, a in terms.items() if n > 1)
        return s, first, second + 0 * x

    return law


def cycloidal(x, lib):
    y = 2 * lib.pi * x
    return x - lib.sin(y) / (2 * lib.pi), 1 - lib.cos(y), 2 * lib.pi * lib.sin(y)


def harmonic(x, lib):
    y = lib.pi * x
    return (1 - lib.cos(y)) / 2, lib.pi * lib.sin(y) / 2, lib.pi**2 * lib.cos(y) / 2


LAWS = {
    "harmonic": harmonic,
    "cycloidal": cycloidal,
    "3-4-5": polynomial({3: 10, 4: -15, 5: 6}),
    "4-5-6-7": polynomial({4: 35, 5: -84, 6: 70, 7: -20}),
    "constant-velocity": polynomial({1: 1}),
}


@dataclass(frozen=True)
class Lift:
    """A cam: c, c_theta, c_thetatheta of smooth parts between `edges` (rad, from 0 to 2 pi).

    parts[k](theta, lib) holds from edges[k] to edges[k + 1]; lib is numpy or mpmath's mp.
    """

    edges: Sequence[float]
    parts: Sequence[Callable]

    def at(self, theta: np.ndarray, side: int = 1) -> np.ndarray:
        """(3, n): c and its derivatives; at an edge from the right (1) or the left (-1)."""
        theta = np.atleast_1d(np.asarray(theta, float)) % TURN
        edges = np.asarray(self.edges)
        near = edges[np.abs(edges[:, None] - theta).argmin(0)]
        theta = np.where(np.abs(near - theta) < EDGE, near, theta)
        k = (np.searchsorted(edges, theta, "right" if side > 0 else "left") - 1) % len(self.parts)
        theta = np.where(theta == (TURN if side > 0 else 0.0), TURN - theta, theta)
        found = np.empty((3, len(theta)))
        for n, part in enumerate(self.parts):
            own = k == n
            if own.any():
                for row, value in zip(found, part(theta[own], np), strict=True):
                    row[own] = value
        return found

    def exactly(self, theta, side: int = 1) -> tuple:
        """(c, c', c'') at a phase (rad) in mpmath's digits; side of a corner: 1 right, -1 left."""
        x = mpf(theta) - (2 * mp.pi) * mp.floor(mpf(theta) / (2 * mp.pi))
        edges = np.asarray(self.edges)
        near = edges[np.abs(edges - float(x)).argmin()]
        place = near if abs(near - float(x)) < EDGE else float(x)
        k = int(np.searchsorted(edges, place, "right" if side > 0 else "left")) - 1
        return self.parts[k % len(self.parts)](x, mp)

    @cached_property
    def range(self) -> tuple[float, float]:
        """(lowest, highest) c in m: minima and maxima between samples, polished."""
        low, high = np.inf, -np.inf
        for a, b in pairwise(self.edges):
            x = np.linspace(a, b, 2001)[:-1]
            c = self.at(x)[0]
            for sign, best in ((1, c.argmin()), (-1, c.argmax())):
                ends = max(x[best] - x[1] + x[0], a), min(x[best] + x[1] - x[0], b)
                found = minimize_scalar(
                    lambda y, sign=sign: sign * self.at(y)[0][0], bounds=ends, method="bounded",
                    options={"xatol": 1e-10},
                )  # fmt: skip
                low, high = (
                    min(low, c.min(), found.fun * sign),
                    max(high, c.max(), found.fun * sign),
                )
        return low, high

    def cuts(self, begin: float, end: float) -> list[float]:
        """begin, end and the edges between, all on from 0 without end (rad).

        An end that is an edge but for rounding is that edge.
        """
        turns = range(int(begin // TURN) - 1, int(end // TURN) + 2)
        edges = np.array([edge + TURN * n for n in turns for edge in self.edges[:-1]])
        near = [edges[np.abs(edges - x).argmin()] for x in (begin, end)]
        begin, end = (
            edge if abs(edge - x) < EDGE else x for edge, x in zip(near, (begin, end), strict=True)
        )
        return [begin, *edges[(edges > begin + EDGE) & (edges < end - EDGE)], end]


def arcs(**geometry) -> Lift:
    """The cam of three circles from the lengths and angles of a scene's section."""
    cam = oracle.ArcsCam(**geometry)
    with mp.workdps(60):
        own = [(cam.arcs[k], cam.breakpoints[k]) for k in range(6)]
        zero = (cam.arcs[5]._replace(origin=cam.arcs[5].origin - 2 * mp.pi), mpf(0))
    edges, parts = [], []
    for arc, start in [zero, *own]:
        edges.append(float(start))
        rough = type(arc)(*(None if x is None else float(x) for x in arc))

        def part(theta, lib, arc=arc, rough=rough):
            of = arc if lib is mp else rough
            return of.laws(lib, theta - of.origin)

        parts.append(part)
    return Lift([*edges, TURN], parts)


def eccentric(base: float, lift: float) -> Lift:
    """c = base + lift (1 - cos theta)/2."""

    def part(theta, lib):
        """(c, dc/dtheta, d2c/dtheta2) at an angle."""
        half = lift / 2
        return (
            base + half * (1 - lib.cos(theta)), half * lib.sin(theta), half * lib.cos(theta)
        )  # fmt: skip

    return Lift([0.0, TURN], [part])


def motions(base, lift, start_deg, rise_deg, top_deg, fall_deg, rise, fall) -> Lift:
    """Base dwell, rise, top dwell and fall; the rise may begin anywhere."""
    rows = []  # begin, end in deg, function of deg since the rise began

    def moving(law, begin, length, low, step):
        """The part of a rise or fall by `step` m in `length` deg from `begin` deg, by a law."""

        def part(since, lib):
            """(c, dc/dtheta, d2c/dtheta2), since: deg."""
            beta = length * (lib.pi / 180)
            s, first, second = LAWS[law]((since - begin) / length, lib)
            return low + step * s, step / beta * first, step / beta**2 * second

        return part

    def still(level):
        return lambda since, lib: (level + 0 * since, 0 * since, 0 * since)

    top, down = rise_deg + top_deg, rise_deg + top_deg + fall_deg
    for begin, end, part in (
        (0, rise_deg, moving(rise, 0, rise_deg, base, lift)),
        (rise_deg, top, still(base + lift)),
        (top, down, moving(fall, top, fall_deg, base + lift, -lift)),
        (down, 360, still(base)),
    ):
        if end > begin:
            rows.append((begin, end, part))
    edges, parts = [], []
    for turn in (-1, 0, 1):
        for begin, end, part in rows:
            low, high = (max(0.0, min(360.0, x + start_deg + 360 * turn)) for x in (begin, end))
            if high > low:

                def shifted(theta, lib, part=part, turn=turn):
                    return part(theta * (180 / lib.pi) - start_deg - 360 * turn, lib)

                edges.append(low * RAD)
                parts.append(shifted)
    order = np.argsort(edges)
    return Lift([*(edges[k] for k in order), TURN], [parts[k] for k in order])


def lift_of(cam: dict) -> Lift:
    """The lift of a cam from the section of a scene."""
    own = {key: value for key, value in cam.items() if value is not None}  # no lash
    kind = own.pop("kind")
    if kind == "law":
        return motions(
            own["base"], own["lift"], own["rise"]["start_deg"], own["rise"]["length_deg"],
            own.get("top_dwell_deg", 0), own["fall"]["length_deg"], own["rise"]["law"],
            own["fall"]["law"],
        )  # fmt: skip
    return arcs(**own) if kind == "arcs" else eccentric(**own)


class Flight(NamedTuple):
    """A flight of `span` rad from theta (rad): gap (m), and rate of the gap (m/s)."""

    theta: float
    span: float
    gap: float
    u: float


@dataclass(frozen=True)
class Machine:
    """A follower on a cam at one speed; SI, angles in rad."""

    lift: Lift
    rpm: float
    mass: float
    stiffness: float
    damping: float = 0.0
    gravity: float = 0.0
    preload: float = 0.0
    restitution: float = 0.8
    strobe: float = 0.0

    @classmethod
    def of(cls, scene: dict, rpm: float | None = None) -> Machine:
        """From the sections of a scene."""
        speed = scene["run"]["rpm"] if rpm is None else rpm
        strobe = scene["run"].get("strobe_deg", 0.0) * RAD
        return cls(lift_of(scene["cam"]), speed, **scene["follower"], strobe=strobe)

    @property
    def omega(self) -> float:
        return self.rpm * pi / 30

    @cached_property
    def _exact(self) -> oracle.Follower:
        """The same follower with exact constants, whose free flight is known in closed form."""
        with mp.workdps(40):
            return oracle.Follower.make(
                self.mass, self.stiffness, self.damping, self.gravity, self.preload
            )

    def is_edge(self, theta: float) -> bool:
        """Whether a smooth part of the cam begins at this phase."""
        return bool(np.min(np.abs(np.asarray(self.lift.edges) - theta % TURN)) < EDGE)

    def corners(self) -> list[float]:
        """Phases (rad) at which c_theta or c_thetatheta jumps."""
        sides = (
            (x, self.lift.at(x, -1)[1:, 0], self.lift.at(x, 1)[1:, 0]) for x in self.lift.edges[:-1]
        )
        size = np.abs(self.lift.at(np.linspace(0, TURN, 1000))[2]).max()
        return [x for x, left, right in sides if np.abs(left - right).max() > 1e-6 * size]

    def phase_deg(self, since: float) -> float:
        """The cam angle so many rad after the strobe, deg."""
        return (self.strobe + since) % TURN / RAD

    def flow(self, t, q, v):
        """(q, v) after t seconds of free flight; t may be an array."""
        return self._exact.rough()._replace(lib=np).flow(np.asarray(t, float), q, v)

    def cam(self, theta, side: int = 1) -> np.ndarray:
        """(3, n): c, its velocity and acceleration in time."""
        return self.lift.at(theta, side) * np.array([[1.0], [self.omega], [self.omega**2]])

    def force(self, theta, side: int = 1) -> np.ndarray:
        """Contact force of a follower kept on the cam, N."""
        c, c1, c2 = self.cam(theta, side)
        load = self.mass * self.gravity + self.preload
        return self.stiffness * c + self.damping * c1 + load + self.mass * c2

    def extreme_force(self, begin: float, end: float, sign: int) -> tuple[float, float]:
        """(force, phase) where sign times the force is largest between two phases (rad)."""
        best = (-np.inf, 0.0)
        for a, b in pairwise(self.lift.cuts(begin, end)):
            x = np.linspace(a, b, 2 + int(2000 * (b - a)))
            values = sign * np.r_[
                self.force(x[:1], 1), self.force(x[1:-1]), self.force(x[-1:], -1)
            ]  # fmt: skip
            k = int(values.argmax())
            best = max(best, (values[k], x[k]))
            if 0 < k < len(x) - 1:
                found = minimize_scalar(
                    lambda y: -sign * self.force(y)[0], bounds=(x[k - 1], x[k + 1]),
                    method="bounded", options={"xatol": 1e-11},
                )  # fmt: skip
                best = max(best, (-found.fun, found.x))
        return sign * best[0], best[1]

    def gap_of(self, flight: Flight) -> Callable[[np.ndarray], np.ndarray]:
        """The gap q - c of a flight as a function of the rad since it began."""
        c, c1, _ = self.lift.at(flight.theta)[:, 0]
        q, v = c + flight.gap, c1 * self.omega + flight.u
        return lambda s: self.flow(s / self.omega, q, v)[0] - self.lift.at(flight.theta + s)[0]

    def highest_gap(self, flight: Flight) -> float:
        """The largest q - c of a flight; 30 digits are more than a hop lower than a rounding."""
        found = []
        gaps = self.gap_of(flight)
        for a, b in pairwise(self.lift.cuts(flight.theta, flight.theta + flight.span)):
            s = np.linspace(a - flight.theta, b - flight.theta, 200 + int(400 * (b - a)))
            values = gaps(s)
            k = int(values.argmax())
            # of a low hop the samples are as much rounding as gap: the highest is near k
            found.append((values[k], s[max(k - 12, 0)], s[min(k + 12, len(s) - 1)]))
        best = max(value for value, *_ in found)
        near = [ends for value, *ends in found if value >= best * (1.0 - 1e-2)]
        with mp.workdps(30):
            theta, omega = mpf(flight.theta), mpf(self.rpm) * mp.pi / 30
            c, c1, _ = self.lift.exactly(theta)
            q, v = c + flight.gap, c1 * omega + flight.u

            def gap(s):
                return self._exact.flow(s / omega, q, v)[0] - self.lift.exactly(theta + s)[0]

            def highest(low, high):
                """The largest gap between two times, by golden section: it has one maximum."""
                ratio = (mp.sqrt(5) - 1) / 2
                for _ in range(60):
                    a, b = high - ratio * (high - low), low + ratio * (high - low)
                    if gap(a) > gap(b):
                        high = b
                    else:
                        low = a
                return gap((low + high) / 2)

            return float(max(highest(mpf(low), mpf(high)) for low, high in near))

    def loss(
        self, begin: float = 0.0, end: float = TURN, last: bool = False
    ) -> tuple[float, float]:
        """(rpm, phase) of the first speed at which the force is zero between two phases (rad).

        With `last` the speed from which on it is zero or less at all of them; inf without one.
        """
        sign, best = (-1, (-np.inf, 0.0)) if last else (1, (np.inf, 0.0))
        best = (sign * best[0], best[1])
        for a, b in pairwise(self.lift.cuts(begin, end)):
            x = np.linspace(a, b, 3 + int(1000 * (b - a)))
            speeds = sign * np.r_[
                self.zero_force(x[:1]), self.zero_force(x[1:-1]), self.zero_force(x[-1:], -1)
            ]  # fmt: skip
            k = int(speeds.argmin())
            best = min(best, (speeds[k], x[k]))
            if 0 < k < len(x) - 1 and np.isfinite(speeds[k]):
                found = minimize_scalar(
                    lambda y: sign * self.zero_force(np.array([y]))[0], bounds=(x[k - 1], x[k + 1]),
                    method="bounded", options={"xatol": 1e-11},
                )  # fmt: skip
                best = min(best, (found.fun, found.x))
        return sign * best[0] * 30 / pi, best[1] % TURN

    def zero_force(self, theta: np.ndarray, side: int = 1) -> np.ndarray:
        """Least omega at which a follower kept on the cam is not pressed to it at a phase."""
        c, c1, c2 = self.lift.at(theta, side)
        still = self.stiffness * c + self.mass * self.gravity + self.preload
        a, b = self.mass * c2, self.damping * c1
        with np.errstate(divide="ignore", invalid="ignore"):
            under = 2 * still / (-b + np.sqrt(b * b - 4 * a * still))  # the other form would cancel
        return np.where(under > 0.0, under, np.inf)

    def first_loss(self) -> float:
        """Speed (rpm) at which contact is first lost, inf where it never is."""
        return self.loss()[0]
