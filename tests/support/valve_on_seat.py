"""A valve with lash between two things that may hold it up, in mpmath: its lobe and its seat.

Nothing here comes from the package, and nothing is clipped: there are two unilateral constraints,

    lobe:  q >= c(theta) - lash   with the restitution r,
    seat:  q >= seat              with the restitution r_seat,

each with its own gap. In flight m q'' + b q' + k q = -m g - F0; whichever gap reaches zero first is
struck, by its own law of impact. After a chatter the valve rests: on the seat until the lobe comes,
on the lobe until the force on it is gone or the seat comes. theta in rad is the variable.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from mpmath import findroot, mp, mpc, mpf

from tests.support.law_oracle import LAWS

STEP = 0.01  # rad of the search for a contact
SOFTEST = mpf(10) ** -12  # of a hop, rad: what is left of a chatter is a geometric series


class Struck(NamedTuple):
    """An event: theta counted on from the start (rad), what is hit, incoming rate (m/rad)."""

    kind: str  # impact, chatter, detachment
    theta: mpf
    surface: str  # lobe, seat
    u: mpf


@dataclass
class Lobe:
    """Base dwell, rise, top dwell, fall; angles in deg, lengths in m."""

    base: float
    lift: float
    start: float
    rise: float
    dwell: float
    fall: float
    law: str
    lash: float

    def __post_init__(self) -> None:
        self.s = LAWS[self.law]
        ends = [self.start, self.rise, self.dwell, self.fall]
        a, b, c, d = (mp.radians(mpf(repr(x))) for x in ends)
        self.edges = a, a + b, a + b + c, a + b + c + d
        self.opens, self.shuts = (
            self._meets(*edges) for edges in (self.edges[:2], self.edges[:1:-1])
        )

    def at(self, theta: mpf, orders: int = 3) -> tuple[mpf, ...]:
        """c - lash and its two derivatives, or as many of the three as are asked for."""
        x = theta - 2 * mp.pi * mp.floor(theta / (2 * mp.pi))
        a, b, c, d = self.edges
        base, lift = mpf(self.base) - mpf(self.lash), mpf(self.lift)
        if a < x < b:
            s = [self.s.derivative((x - a) / (b - a), n) / (b - a) ** n for n in range(orders)]
            return base + lift * s[0], *(lift * value for value in s[1:])
        if c < x < d:
            s = [self.s.derivative((x - c) / (d - c), n) / (d - c) ** n for n in range(orders)]
            return base + lift * (1 - s[0]), *(-lift * value for value in s[1:])
        return base + (lift if b <= x <= c else 0), mpf(0), mpf(0)

    def _meets(self, low: mpf, high: mpf) -> mpf:
        """Where c - lash is the height of the seat on a flank, from its foot to its top."""
        for _ in range(mp.prec + 8):
            middle = (low + high) / 2
            if self.at(middle, 1)[0] > mpf(self.base):
                high = middle
            else:
                low = middle
        return (low + high) / 2


class Valve:
    """The motion; all constants are doubles in SI units."""

    def __init__(
        self, lobe: Lobe, rpm: float, mass: float, stiffness: float, restitution: float,
        seat_restitution: float, damping: float = 0.0, gravity: float = 0.0, preload: float = 0.0,
    ):  # fmt: skip
        omega = mpf(rpm) * mp.pi / 30
        m, k, b = mpf(mass), mpf(stiffness), mpf(damping)
        self.lobe = lobe
        self.seat = mpf(lobe.base)
        self.r = {"lobe": mpf(restitution), "seat": mpf(seat_restitution)}
        self.w2 = k / m / omega**2
        self.z = b / (2 * m) / omega
        self.load = (mpf(gravity) + mpf(preload) / m) / omega**2
        root = mp.sqrt(mpc(self.z**2 - self.w2))
        self.roots = root - self.z, -root - self.z
        self.level = -self.load / self.w2

    def flight(self, q: mpf, w: mpf, s: mpf) -> tuple[mpf, mpf]:
        """(q, dq/dtheta) after s rad, by the two complex exponentials."""
        one, two = self.roots
        y = q - self.level
        first = (w - two * y) / (one - two)
        second = y - first
        e1, e2 = mp.exp(one * s), mp.exp(two * s)
        return (
            self.level + mp.re(first * e1 + second * e2),
            mp.re(one * first * e1 + two * second * e2),
        )

    def surface(self, name: str, theta: mpf) -> tuple[mpf, mpf, mpf]:
        """Height, slope and curvature of the lobe (with its lash) or of the seat."""
        return self.lobe.at(theta) if name == "lobe" else (self.seat, mpf(0), mpf(0))

    def pull(self, q: mpf, w: mpf) -> mpf:
        """-q'' in flight, m/rad^2."""
        return self.load + self.w2 * q + 2 * self.z * w

    def events(self) -> Iterator[Struck]:
        """From a rest on the seat at theta = 0 on."""
        theta, on = mpf(0), "seat"
        while True:
            theta, surface, u = yield from self._rest(theta, on)
            while True:  # impacts up to the next rest
                height, slope, _ = self.surface(surface, theta)
                if u < 0:
                    yield Struck("impact", theta, surface, u)
                v = -self.r[surface] * u
                end = self._chatter(theta, surface, v)
                if end is not None:
                    yield Struck("chatter", end, surface, mpf(0))
                    theta, on = end, surface
                    break
                q, w = height, slope + v
                theta, surface, u = self._next(theta, q, w, surface)

    def _rest(self, theta: mpf, on: str) -> Iterator:
        """From a rest to what ends it: (theta, surface that strikes, incoming rate)."""
        turn = 2 * mp.pi
        if on == "seat":
            assert self.pull(self.seat, mpf(0)) > 0
            strikes = self.lobe.opens
            strikes += turn * mp.ceil((theta - strikes) / turn)
            return strikes, "lobe", -self.lobe.at(strikes)[1]
        shuts = self.lobe.shuts
        shuts += turn * mp.ceil((theta - shuts) / turn)
        at = theta
        while at < shuts:
            q, slope, bend = self.lobe.at(at)
            if not self.pull(q, slope) + bend > 0:
                low, high = at - STEP, at
                for _ in range(mp.prec):
                    middle = (low + high) / 2
                    q, slope, bend = self.lobe.at(middle)
                    if self.pull(q, slope) + bend > 0:
                        low = middle
                    else:
                        high = middle
                yield Struck("detachment", high, "lobe", mpf(0))
                q, slope, _ = self.lobe.at(high)
                return self._next(high, q, slope, "lobe", mpf(STEP))
            at += STEP
        return shuts, "seat", self.lobe.at(shuts)[1]

    def _chatter(self, theta: mpf, surface: str, v: mpf) -> mpf | None:
        """Where hops too short to follow end; None where they are not."""
        height, slope, bend = self.surface(surface, theta)
        fall = self.pull(height, slope + v) + bend
        if v <= SOFTEST and fall > 0:
            return theta + 2 * v / fall / (1 - self.r[surface])
        return None

    def _next(self, theta: mpf, q: mpf, w: mpf, left: str, skip: mpf | None = None):
        """The next contact of a flight: (theta, surface, incoming rate)."""

        def gap(name: str, s: mpf) -> mpf:
            level = self.lobe.at(theta + s, 1)[0] if name == "lobe" else self.seat
            return self.flight(q, w, s)[0] - level

        slope, bend = self.surface(left, theta)[1:]
        v, fall = w - slope, self.pull(q, w) + bend
        s = mpf(0) if skip is None else skip
        step = mpf(STEP)
        if skip is None and fall > 0:
            step = min(step, v / fall / 4)
        while True:
            below = [name for name in ("lobe", "seat") if gap(name, s + step) < 0]
            if below:
                found = [(self._zero(partial(gap, name), s, s + step), name) for name in below]
                s, name = min(found)
                rate = self.flight(q, w, s)[1]
                return theta + s, name, rate - self.surface(name, theta + s)[1]
            s += step
            step = min(step * 2, mpf(STEP))

    @staticmethod
    def _zero(gap: Callable[[mpf], mpf], low: mpf, high: mpf) -> mpf:
        """The zero of a gap that is below zero at `high` and, where low > 0, above at `low`."""
        if low == 0:  # the flight begins on this surface
            low = high / 2**20
        for _ in range(6):
            middle = (low + high) / 2
            if gap(middle) > 0:
                low = middle
            else:
                high = middle
        return findroot(gap, (low, high), solver="anderson", tol=mp.eps**2, verify=False)
