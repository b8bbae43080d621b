"""High-precision reference for a follower bouncing on a cam made of circular arcs.

Only the standard library and mpmath are used, and nothing of the package under test, so that an
agreement between the two means something.  Lengths in m, SI units, angles in rad.

    free flight   q > c(theta):   m q'' + b q' + k q = -m g - F0,     theta = theta0 + omega t
    impact        q = c, u < 0:   u+ = -r u,       u = v - omega c_theta
    sticking      q = c, u = 0, a <= 0;   the follower leaves where a turns positive:
                  a = -omega0^2 c - 2 zeta omega c_theta - g - F0/m - omega^2 c_thetatheta

with omega0^2 = k/m and zeta = b/(2m).  Flights use the closed-form flow.  A contact is looked for
cell by cell: in doubles where the gap is clearly positive, otherwise with mpmath by subdivision
into convex, concave or monotone cells, which is what finds the first of two close contacts.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from typing import Any, NamedTuple

from mpmath import mp, mpf

PERTURBATION = "1e-25"  # relative size of the perturbations behind `Event.stretching`
CELLS_PER_TURN = 720
IDLE_TURNS = 200  # a run gives up on a flight longer than this (and 20 spring periods)
CAM_DPS = 150
HELPER_DPS = 60


def _num(x) -> mpf:
    """An mpf as it is, anything else as the IEEE double a user would give."""
    return x if isinstance(x, mpf) else mpf(float(x))


def _root(f: Callable[[mpf], mpf], lo: mpf, hi: mpf) -> mpf:
    """Root of f in [lo, hi], a sign change, to the working precision (Illinois method)."""
    flo, fhi = f(lo), f(hi)
    tol = mp.ldexp(max(abs(lo), abs(hi)), 6 - mp.prec)
    x, side = lo, 0
    for i in range(mp.prec + 60):
        if flo == 0 or fhi == 0:
            return lo if flo == 0 else hi
        x = (lo * fhi - hi * flo) / (fhi - flo) if i < 60 else (lo + hi) / 2
        fx = f(x)
        if (fx > 0) == (fhi > 0):
            hi, fhi = x, fx
            flo, side = (flo / 2 if side == 1 else flo), 1
        else:
            lo, flo = x, fx
            fhi, side = (fhi / 2 if side == -1 else fhi), -1
        if hi - lo < tol:
            break
    return x


class Arc(NamedTuple):
    """One cam piece: radius K cos x + sqrt(rho^2 - K^2 sin^2 x), with x = theta - origin."""

    K: Any
    rho: Any
    origin: Any
    offset: Any
    end: Any = None

    def laws(self, lib, x):
        """Lift c and its first two derivatives in the angle, x measured from the origin."""
        K = self.K
        if K == 0:
            return self.rho - self.offset, K, K
        cos, sin = lib.cos(x), lib.sin(x)
        R = lib.sqrt(self.rho**2 - (K * sin) ** 2)
        sc = K * K * sin * cos / R
        bend = K * K * (cos * cos - sin * sin) / R
        return K * cos + R - self.offset, -K * sin - sc, -K * cos - bend - sc * sc / R


class ArcsCam:
    """Cam of three tangent circles, symmetric about 180 degrees, in exact closed form.

    With O1 and O2 the centres of flank and nose, |O1 O2| = flank_radius - nose_radius, so the law
    of cosines gives O1-O-O2 and the flank begins at a = c - (pi - O1OO2); b is on the ray O1 O2.
    The base circle is flank_radius - flank_center: base_radius must agree within rounding, and is
    not used otherwise (a cam built on it would jump at a by the last bit of a double). Lengths are
    taken as doubles unless they are mpf: `flank_radius` may be the exact sum of the two others.
    """

    def __init__(
        self, base_radius=0.4, flank_center=0.45, flank_radius=0.85,
        nose_center=0.40393320723821, nose_radius=0.15, top_dwell_deg=40.0, offset=0.3,
        digits=CAM_DPS,
    ):  # fmt: skip
        """Three tangent circles; lengths in m. Raises ValueError where they do not touch.

        digits: decimal ones of its corners.

        The breakpoints are the corners a to f; each arc is a circle (centre, radius) about its own
        origin.
        """
        with mp.workdps(digits):
            lengths = flank_center, flank_radius, nose_center, nose_radius, offset
            k1, R1, k2, R2, off = map(_num, lengths)
            if abs(R1 - k1 - mpf(float(base_radius))) > 1e-12:
                raise ValueError("the base circle does not touch the flank circle")
            aoc = mp.pi - mp.acos((k1**2 + k2**2 - (R1 - R2) ** 2) / (2 * k1 * k2))
            ratio = R1 / (R1 - R2)
            dx, dy = k1 + k2 * mp.cos(aoc), k2 * mp.sin(aoc)
            c = mp.pi - mp.radians(mpf(float(top_dwell_deg))) / 2
            a = c - aoc
            b = a + mp.atan2(ratio * dy, ratio * dx - k1)
            self.breakpoints = [a, b, c, *(2 * mp.pi - x for x in (c, b, a))]
            flank, nose = (-k1, R1), (k2, R2)
            parts = [(flank, a), (nose, c), ((mpf(0), k2 + R2), c)]
            parts += [(nose, 2 * mp.pi - c), (flank, 2 * mp.pi - a), ((mpf(0), R1 - k1), a)]
            self.arcs = [Arc(K, rho, origin, off) for (K, rho), origin in parts]

    def segments(self, psi: mpf, side: int = 1) -> Iterator[Arc]:
        """The pieces met from the unbounded angle psi on, with absolute origin and end."""
        turn = mp.floor(psi / (2 * mp.pi))
        x, tol = psi - 2 * mp.pi * turn, side * mp.eps * 1e8
        bps = self.breakpoints
        first = next((i for i, bp in enumerate(bps) if x + tol < bp), 6) - 1
        for i in count(first):
            arc, base = self.arcs[i % 6], 2 * mp.pi * (turn + i // 6)
            end = 2 * mp.pi * (turn + (i + 1) // 6) + bps[(i + 1) % 6]
            yield arc._replace(origin=base + arc.origin, end=end)

    def laws(self, theta, side: int = 1) -> tuple[mpf, mpf, mpf]:
        """(c, c_theta, c_thetatheta); side=+1 from the right at a corner, -1 from the left."""
        with mp.workdps(max(mp.dps, HELPER_DPS)):
            psi = _num(theta)
            arc = next(self.segments(psi, side))
            return arc.laws(mp, psi - arc.origin)

    def c(self, theta, side: int = 1) -> mpf:
        """Lift of the cam."""
        return self.laws(theta, side)[0]

    def c1(self, theta, side: int = 1) -> mpf:
        """First derivative of the lift in the angle."""
        return self.laws(theta, side)[1]

    def c2(self, theta, side: int = 1) -> mpf:
        """Second derivative of the lift in the angle."""
        return self.laws(theta, side)[2]


class Follower(NamedTuple):
    """Linear follower q'' + 2 zeta q' + w2 q = -load; `lib` is mpmath's mp or the math module."""

    lib: Any
    zeta: Any
    w2: Any
    load: Any
    disc: Any  # zeta^2 - w2
    sigma: Any  # sqrt(|disc|)

    @classmethod
    def make(cls, mass, stiffness, damping=0, gravity=0, preload=0) -> "Follower":
        """From the physical data, at the working precision."""
        m, k, b = _num(mass), _num(stiffness), _num(damping)
        zeta, w2 = b / (2 * m), k / m
        disc = zeta**2 - w2
        load = _num(gravity) + _num(preload) / m
        return cls(mp, zeta, w2, load, disc, mp.sqrt(abs(disc)))

    def rough(self) -> "Follower":
        """This follower in doubles."""
        return Follower(math, *(float(x) for x in self[1:]))

    def flow(self, t, q, v):
        """Exact position and velocity after t.

        C, S = cos(s t), sin(s t)/s (underdamped), 1, t (critical), cosh, sinh/s (overdamped), and
        q = q0 A + v0 e S - load (1 - A)/w2,  v = v0 e (C - zeta S) - (w2 q0 + load) e S,
        where e = exp(-zeta t) and A = e (C + zeta S); the limit w2 -> 0 is written out.
        """
        lib, zeta, sigma = self.lib, self.zeta, self.sigma
        if self.disc > 0:
            e, fall = lib.exp((sigma - zeta) * t), -lib.expm1(-2 * sigma * t)
            C, S = e * (1 - fall / 2), e * fall / (2 * sigma)
        else:
            e = lib.exp(-zeta * t) if zeta else 1
            C = e * lib.cos(sigma * t) if sigma else e
            S = e * lib.sin(sigma * t) / sigma if sigma else e * t
        if self.w2:
            A = C + zeta * S
            P = (1 - A) / self.w2
        else:
            A, P = 1, (t - S) / (2 * zeta) if zeta else t * t / 2
        return q * A + v * S - self.load * P, v * (C - zeta * S) - (self.w2 * q + self.load) * S

    def rest_acceleration(self, omega, laws):
        """Relative acceleration a in contact with u = 0; the contact force is -m a."""
        c, c1, c2 = laws
        return -self.w2 * c - 2 * self.zeta * omega * c1 - self.load - omega**2 * c2


class Sample(NamedTuple):
    """Gap, its first two time derivatives, and a bound on the size of the second one's terms."""

    t: Any
    g: Any
    g1: Any
    g2: Any
    size: Any


class Flight:
    """One free flight from the angle psi with position q and velocity v at t = 0."""

    def __init__(self, cam: ArcsCam, follower: Follower, omega, psi, q, v):
        self.cam, self.follower, self.omega = cam, follower, omega
        self.psi, self.q, self.v = psi, q, v
        self.double = (follower.rough(), float(omega), float(q), float(v))

    def _sample(self, follower, omega, q0, v0, arc: Arc, x0, t) -> Sample:
        """The gap, its rate and its acceleration t seconds after the flight began.

        size: the sum of the terms of the acceleration without their signs, which its rounding is a
        share of.
        """
        c, c1, c2 = arc.laws(follower.lib, x0 + omega * t)
        q, v = follower.flow(t, q0, v0)
        drag, pull, push = 2 * follower.zeta * v, follower.w2 * q + follower.load, omega**2 * c2
        size = abs(drag) + abs(pull) + abs(push)
        return Sample(t, q - c, v - omega * c1, -drag - pull - push, size)

    def at(self, t: mpf, arc: Arc) -> Sample:
        """The gap and its derivatives at t, the cam being on `arc`."""
        x0 = self.psi - arc.origin
        return self._sample(self.follower, self.omega, self.q, self.v, arc, x0, t)

    def hop(self, arc: Arc) -> Sample | None:
        """The next contact after a short bounce, by Newton's method; None where that is not sure.

        It begins with the ballistic time 2 u/|a| and gives up where the bounce is not nearly
        ballistic.
        """
        start = self.at(mpf(0), arc)
        if start.g1 <= 0 or start.g2 >= 0:
            return None
        t = guess = -2 * start.g1 / start.g2
        room = min((arc.end - self.psi) / self.omega, 2 * mp.pi / self.omega / CELLS_PER_TURN)
        for _ in range(12 if 2 * guess < room else 0):
            now = self.at(t, arc)
            step = now.g / now.g1 if now.g1 else guess
            t -= step
            if now.g2 >= 0 or not guess / 2 < t < 2 * guess:
                return None
            if abs(step) < t * mpf(10) ** -(mp.dps // 3):
                return self.at(t, arc)
        return None

    def first_contact(self, t_max: mpf, contact: bool) -> Sample | None:
        """First time in (0, t_max] at which the gap closes; `contact`: it is zero at t = 0."""
        lo, omega = mpf(0), self.omega
        for arc in self.cam.segments(self.psi) if t_max > 0 else ():
            if contact and lo == 0 and (hit := self.hop(arc)):
                return hit if hit.t <= t_max else None
            hi = min((arc.end - self.psi) / omega, t_max)
            hit = self._scan(arc, lo, hi, contact and lo == 0)
            if hit is not None or hi >= t_max:
                return hit
            lo = hi
        return None

    def _width(self) -> mpf:
        """Cell width: a small part of the turn, of the spring period and of the decay time."""
        f = self.follower
        rate = f.zeta + f.sigma
        turn = 2 * mp.pi / self.omega / CELLS_PER_TURN
        return min(turn, 1 / (10 * rate)) if rate else turn

    def _scan(self, arc: Arc, lo: mpf, hi: mpf, contact: bool) -> Sample | None:
        """First contact on one cam piece: cells in doubles, the doubtful ones in mpmath."""
        n = int((hi - lo) / self._width()) + 1
        rough = type(arc)(*(float(x) for x in arc))
        x0, t0, dt = float(self.psi - arc.origin), float(lo), float((hi - lo) / n)
        f, _, q, v = self.double
        lever = 1 / f.w2 if f.w2 else float(hi) / (2 * f.zeta) if f.zeta else float(hi) ** 2
        noise = 1e-9 + 1e-13 * (abs(q) + abs(v) * float(hi) + abs(f.load) * lever)
        left = self._sample(*self.double, rough, x0, t0)
        for i in range(n):
            right = self._sample(*self.double, rough, x0, t0 + (i + 1) * dt)
            sag = max(left.size, right.size) * dt * dt / 4
            if min(left.g, right.g) < noise + sag:
                t1, t2 = lo + (hi - lo) * i / n, lo + (hi - lo) * (i + 1) / n
                hit = self._cell(t1, t2, arc, contact and i == 0)
                if hit is not None:
                    return hit
            left = right
        return None

    def _cell(self, t1: mpf, t2: mpf, arc: Arc, contact: bool) -> Sample | None:
        """First contact in a cell; after a contact, skip the rise that follows it."""
        step = t2 - t1
        while contact:
            step /= 2
            rise = [self.at(t1 + step * i / 5, arc) for i in range(1, 6)]
            if all(s.g1 > 0 for s in rise) and rise[0].g > 0:
                t1, contact = t1 + step, False
            elif step < mp.eps * t2:
                raise ArithmeticError("a flight that does not leave the cam")
        return self._subdivide(self.at(t1, arc), self.at(t2, arc), arc)

    def _subdivide(self, lo: Sample, hi: Sample, arc: Arc, depth: int = 0) -> Sample | None:
        """First root of the gap in a cell whose left end has a positive gap."""
        w, bend = hi.t - lo.t, 2 * max(lo.size, hi.size)
        if min(lo.g, hi.g) > bend * w * w / 8:
            return None
        mid = self.at((lo.t + hi.t) / 2, arc)
        curved = [s.g2 > 0 for s in (lo, mid, hi)]
        simple = all(curved) or not any(curved)
        if hi.g <= 0 and (simple or max(lo.g1, hi.g1) < -bend * w or depth > 90):
            return self._polish(lo.t, hi.t, arc)
        if hi.g > 0 and (simple or depth > 90):
            if not all(curved) or lo.g1 >= 0 or hi.g1 <= 0:
                return None
            t = _root(lambda t: self.at(t, arc).g1, lo.t, hi.t)
            return None if self.at(t, arc).g > 0 else self._polish(lo.t, t, arc)
        hit = self._subdivide(lo, mid, arc, depth + 1)
        return hit if hit is not None else self._subdivide(mid, hi, arc, depth + 1)

    def _polish(self, lo: mpf, hi: mpf, arc: Arc) -> Sample:
        return self.at(_root(lambda t: self.at(t, arc).g, lo, hi), arc)


@dataclass(frozen=True)
class Event:
    """What happened at the angle theta of the given turn.

    Velocities are relative to the cam.  `stretching` is the largest |change of phase, in turns| per
    relative change of the data (at least 1), or inf once a perturbed run has other events.
    """

    kind: str  # "impact", "chatter" (its accumulation) or "detachment" (the end of a sticking)
    turn: int
    theta: mpf
    q: mpf
    u_minus: mpf
    u_plus: mpf
    stretching: mpf


class _Raw(NamedTuple):
    kind: str
    psi: mpf
    q: mpf
    u_minus: mpf
    u_plus: mpf


@dataclass
class _Orbit:
    """One orbit for one set of data, as a stream of raw events; angles count on past 2 pi."""

    cam: ArcsCam
    follower: Follower
    r: mpf
    omega: mpf
    psi: mpf
    end: mpf | None
    cut: mpf

    def acceleration(self, psi: mpf) -> mpf:
        """Relative acceleration of a follower at rest on the cam, from the right at a corner."""
        arc = next(self.cam.segments(psi))
        return self.follower.rest_acceleration(self.omega, arc.laws(mp, psi - arc.origin))

    def detachment(self, psi: mpf) -> mpf | None:
        """Where a sticking that holds at psi ends, None if not within one turn."""
        start = psi
        for arc in self.cam.segments(psi):

            def a(x, arc=arc):
                return self.follower.rest_acceleration(self.omega, arc.laws(mp, x - arc.origin))

            if psi > start and a(psi) > 0:
                return psi
            n = int((arc.end - psi) / (2 * mp.pi) * CELLS_PER_TURN) + 2
            grid = [psi + (arc.end - psi) * i / n for i in range(n + 1)]
            found = _first_rise(a, grid)
            if found is not None or arc.end > start + 2 * mp.pi:
                return found
            psi = arc.end
        return None

    def events(self, q: mpf | None, v: mpf | None) -> Iterator[_Raw]:
        """All events from the initial state on; q=None is on the cam, v=None is u = 0."""
        c, c1, _ = self.cam.laws(self.psi)
        psi, speed = self.psi, self.omega * c1
        u = mpf(0) if v is None else v - speed
        contact = q is None
        while True:
            if contact and u < 0:
                yield _Raw("impact", psi, c, u, -self.r * u)
                u = -self.r * u
            if contact:
                a = self.acceleration(psi)
                if u > 0 > a and 2 * u * self.omega < self.cut * (1 - self.r) * -a:
                    yield _Raw("chatter", psi, c, mpf(0), mpf(0))
                    u = mpf(0)
                if u == 0 and a <= 0:
                    psi = self.detachment(psi)
                    if psi is None:
                        return
                    c, c1, _ = self.cam.laws(psi)
                    yield _Raw("detachment", psi, c, mpf(0), mpf(0))
                    psi = self.departs(psi)
                    c, c1, _ = self.cam.laws(psi)
                q, speed = c, self.omega * c1
            flight = Flight(self.cam, self.follower, self.omega, psi, q, speed + u)
            hit = flight.first_contact(self.patience(psi), contact)
            if hit is None:
                return
            psi, u = self.lands(psi + self.omega * hit.t, min(hit.g1, mpf(0)), u, hit.t)
            c, c1, _ = self.cam.laws(psi)
            contact = True

    def departs(self, psi: mpf) -> mpf:
        """Where a sticking is left that ends at psi: there, unless a subclass disturbs it."""
        return psi

    def lands(self, psi: mpf, u: mpf, rise: mpf, time: mpf) -> tuple[mpf, mpf]:
        """(psi, u) of a landing after a flight that began with u = rise: as they are found."""
        return psi, u

    def patience(self, psi: mpf) -> mpf:
        """How long a flight is followed at most, s: to the end, or for so many turns or swings."""
        if self.end is not None:
            return (self.end - psi) / self.omega
        spring = 40 * mp.pi / mp.sqrt(self.follower.w2) if self.follower.w2 else 0
        return max(2 * mp.pi * IDLE_TURNS / self.omega, spring)


def _first_rise(a: Callable[[mpf], mpf], grid: list[mpf]) -> mpf | None:
    """First crossing of zero from below by a smooth function, local maxima of the grid checked."""
    values = [a(x) for x in grid]
    for i in range(1, len(grid)):
        if values[i] > 0:
            return _root(a, grid[i - 1], grid[i])
        if i + 1 < len(grid) and values[i - 1] < values[i] > values[i + 1]:
            lo, hi = grid[i - 1], grid[i + 1]
            for _ in range(100):
                p, q = (2 * lo + hi) / 3, (lo + 2 * hi) / 3
                lo, hi = (p, hi) if a(p) < a(q) else (lo, q)
            if a(lo) > 0:
                return _root(a, grid[i - 1], lo)
    return None


class Oracle:
    """The oscillator with its data; numbers are taken as IEEE doubles unless they are mpf."""

    def __init__(
        self, cam: ArcsCam, *, mass, stiffness, damping=0, gravity=0, preload=0,
        restitution, rpm, digits=50,
    ):  # fmt: skip
        """A machine in SI, at a speed in rpm, to be followed with so many digits."""
        self.cam, self.digits = cam, max(int(digits), 40)
        self.data = tuple(map(_num, (mass, stiffness, damping, gravity, preload)))
        self.r, self.rpm = _num(restitution), _num(rpm)
        self.work = self.digits + 30

    def flow(self, t, q, v) -> tuple[mpf, mpf]:
        """Position and velocity after a free flight of duration t from (q, v)."""
        with mp.workdps(self.work):
            return Follower.make(*self.data).flow(_num(t), _num(q), _num(v))

    def run(
        self, *, q=None, v=None, theta=0, impacts=20, turns=None, chatter_cut=None
    ) -> list[Event]:
        """Events from a start at theta (rad), in order.

        q=None starts on the cam, v=None with the velocity of the cam.  A q within 1e-15 of the cam
        is on it.  No event is reported for the start itself.  With `turns` the run ends that many
        turns after theta and `impacts` is not looked at; otherwise it ends with the n-th impact
        (hops of a chatter count), at a rest for ever, or at a flight that never lands.
        """
        cut = _num("1e-22" if chatter_cut is None else chatter_cut)
        digits = int(max(self.work, 45 - 2 * mp.log10(cut)))
        with mp.workdps(digits):
            psi = _num(theta)
            end = None if turns is None else psi + 2 * mp.pi * _num(turns)
            height = self.cam.c(psi)
            q = None if q is None or abs(_num(q) - height) < 1e-15 else _num(q)
            v = None if v is None else _num(v)
            if q is not None and q < height:
                raise ValueError("the follower starts inside the cam")
            if q is not None and v is None:
                v = self.rpm * mp.pi / 30 * self.cam.c1(psi)
            runs = [self._run(psi, end, cut, impacts, *x) for x in self._variants(q, v)]
            return _with_stretching(runs[0], runs[1:])

    def _variants(self, q, v):
        """(rpm, r, q, v) of the orbit itself, then of the perturbed ones."""
        base = (self.rpm, self.r, q, v)
        yield base
        for i, sign in enumerate((1, -1, 1, 1)):
            if base[i]:
                yield (*base[:i], base[i] * (1 + sign * mpf(PERTURBATION)), *base[i + 1 :])

    def _run(self, psi, end, cut, impacts, rpm, r, q, v) -> list[_Raw]:
        """Events until an angle `end`, or without one until so many impacts.

        psi: the angle at the start; cut: where a chatter is ended by its series.
        """
        follower = Follower.make(*self.data)
        orbit = _Orbit(self.cam, follower, r, rpm * mp.pi / 30, psi, end, cut)
        out, hits = [], 0
        if end is None and impacts < 1:
            return out
        for event in orbit.events(q, v):
            if end is not None and event.psi > end:
                break
            out.append(event)
            hits += event.kind == "impact"
            if end is None and hits >= impacts:
                break
        return out


def _with_stretching(base: list[_Raw], others: list[list[_Raw]]) -> list[Event]:
    """Attach to every event the largest change of phase among the perturbed orbits."""
    out, same, size = [], True, 2 * mp.pi * mpf(PERTURBATION)
    for i, (kind, psi, *rest) in enumerate(base):
        same = same and all(len(o) > i and o[i].kind == kind for o in others)
        stretch = max([mpf(1), *(abs(o[i].psi - psi) / size for o in others)]) if same else mp.inf
        turn = int(mp.floor(psi / (2 * mp.pi)))
        out.append(Event(kind, turn, psi - 2 * mp.pi * turn, *rest, stretch))
    return out


# Closed forms for the follower without damping, gravity and preload.


def _detachment_rpm(cam: ArcsCam, mass, stiffness, corner: int, side: int) -> mpf:
    """Speed at which -omega0^2 c - omega^2 c_thetatheta = 0 on one side of a corner."""
    with mp.workdps(HELPER_DPS):
        c, _, c2 = cam.laws(cam.breakpoints[corner], side)
        return mp.sqrt(-_num(stiffness) / _num(mass) * c / c2) * 30 / mp.pi


def first_detachment_rpm(cam: ArcsCam, mass, stiffness) -> mpf:
    """Lowest speed at which the follower leaves the cam, at b+."""
    return _detachment_rpm(cam, mass, stiffness, 1, 1)


def region_filling_rpm(cam: ArcsCam, mass, stiffness) -> mpf:
    """Speed from which the contact force would be negative all over the nose, at c-."""
    return _detachment_rpm(cam, mass, stiffness, 2, -1)
