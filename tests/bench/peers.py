"""General-purpose integrators on the cam-follower problem, as a careful user would drive them.

A rigid cam of three tangent circles turns at ``omega = rpm * pi / 30``; a spring presses a
follower (position ``q``, velocity ``v``) on its law ``c(theta)``:

* flight, ``q > c``:  ``q'' = -omega0**2 q - 2 zeta q' - g - F0/m``;
* impact, ``u = q' - c' < 0``:  the relative velocity becomes ``-r u``;
* rest on the cam, while ``a = -omega0**2 c - 2 zeta c' - g - F0/m - c''`` is negative.

Three peers share everything but the integration of a flight:

``rk45``    ``solve_ivp``, RK45, rtol = atol = 1e-12, steps of at most 1 ms: the method of the
            literature on this cam;
``dop853``  ``solve_ivp``, DOP853, at its best tolerance and step limit;
``heyoka``  Taylor series with terminal events, one event for each circle of the cam.

What care means here, for all three alike:

* A flight long enough is integrated in ``(q, v)``: its right-hand side has no breakpoints.
  One that falls back within ``GAP_BELOW`` of a turn is integrated in the gap ``y = q - c`` and
  ``u = y'``, up to the next breakpoint of the cam, because ``q - c`` of a late chatter bounce
  (1e-16 m and less) is below the rounding of ``q``.
* A step may enter the cam and leave it again, with no change of sign of the gap at its ends
  (a chatter that does not complete).  ``rk45`` and ``dop853`` therefore also stop where the gap
  has a minimum; ``heyoka`` finds such roots by itself.
* A contact must not fire again as the flight it starts leaves: the first step ends at half the
  ballistic time of the flight (``rk45``, ``dop853``), or 1/16 of it is flown by an integrator
  without events (``heyoka``, whose detection may miss a contact when the gap starts at zero).
* Chatter is closed by its first-order map: after an impact at ``u < 0`` with ``a < 0`` the
  bounces still to come take ``2 r u / ((1 - r) a)``; it is used once this is below
  ``chatter_tol`` turns.  The follower then rests until ``a`` becomes positive.
"""

from __future__ import annotations

import math
import time
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

METHODS = ("rk45", "dop853", "heyoka")
GAP_BELOW = 1e-3  # ballistic time of a flight, in turns, below which the gap is integrated
TWO_PI = 2.0 * math.pi

State = tuple[int, float, float, float]  # whole turns, theta, gap y, relative velocity u


# ---------------------------------------------------------------------------------- the cam

RHO1, KAPPA1 = 0.85, 0.45  # flank circle: radius, distance of its centre from the axis
RHO2, KAPPA2 = 0.15, 0.40393320723821  # nose circle
OFFSET = 0.3
BASE, TOP = RHO1 - KAPPA1 - OFFSET, KAPPA2 + RHO2 - OFFSET
CEILING = TOP + 0.02  # no contact above; clear of the top, so that no gap is zero there


def _breaks() -> tuple[float, ...]:
    """Angles a to f: circles touch on the line through their centres; top dwell 160-200 deg."""
    cos_centres = (KAPPA1**2 + KAPPA2**2 - (RHO1 - RHO2) ** 2) / (2.0 * KAPPA1 * KAPPA2)
    flank_and_nose = math.pi - math.acos(cos_centres)  # angle from a to c
    x, y = KAPPA2 * math.cos(flank_and_nose), KAPPA2 * math.sin(flank_and_nose)
    scale = RHO1 / (RHO1 - RHO2)
    flank_alone = math.atan2(scale * y, scale * (x + KAPPA1) - KAPPA1)  # from a to b
    c = math.radians(160.0)
    a = c - flank_and_nose
    b = a + flank_alone
    return a, b, c, TWO_PI - c, TWO_PI - b, TWO_PI - a


BREAKS = _A, _, _C, _D, _, _F = _breaks()
# Region i lies before BREAKS[i]; region 6 = 0 runs on past 2 pi to the next a.
ENDS = (*BREAKS, TWO_PI + _A)
FLANK, NOSE, ROUND, SKY = "flank", "nose", "round", "sky"
KINDS = (ROUND, FLANK, NOSE, ROUND, NOSE, FLANK, ROUND)
CENTRES = (BASE, _A, _C, TOP, _D, _F, BASE)  # the angle the arc is symmetric about, or its c


def region(theta: float) -> int:
    """Index of the smooth piece at ``theta`` in [0, 2 pi); a breakpoint belongs to the right."""
    return bisect_right(BREAKS, theta)


def _circle(x: float, kappa: float, rho: float) -> tuple[float, float, float]:
    """``kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x) - OFFSET`` and its two derivatives."""
    sin, cos = math.sin(x), math.cos(x)
    root = math.sqrt(rho * rho - (kappa * sin) ** 2)
    slope = -kappa * kappa * sin * cos / root
    bend = (-kappa * kappa * (cos * cos - sin * sin) - slope * slope) / root
    return kappa * cos + root - OFFSET, slope - kappa * sin, bend - kappa * cos


def arc(index: int, theta: float) -> tuple[float, float, float]:
    """``c``, ``dc/dtheta``, ``d2c/dtheta2`` of region ``index``, its formula continued."""
    kind, centre = KINDS[index], CENTRES[index]
    if kind == ROUND:
        return centre, 0.0, 0.0
    if kind == FLANK:
        return _circle(theta - centre, -KAPPA1, RHO1)
    return _circle(theta - centre, KAPPA2, RHO2)


def height(theta: float) -> float:
    """``c`` at any angle; the only cam value a contact event in ``q`` needs."""
    theta %= TWO_PI
    index = region(theta)
    kind, centre = KINDS[index], CENTRES[index]
    if kind == ROUND:
        return centre
    kappa, rho = (-KAPPA1, RHO1) if kind == FLANK else (KAPPA2, RHO2)
    sin = kappa * math.sin(theta - centre)
    return kappa * math.cos(theta - centre) + math.sqrt(rho * rho - sin * sin) - OFFSET


# -------------------------------------------------------------------------------- the model


@dataclass(frozen=True)
class Follower:
    """Physical parameters, SI units."""

    mass: float = 1.221
    stiffness: float = 1430.8
    damping: float = 0.0
    gravity: float = 0.0
    preload: float = 0.0
    restitution: float = 0.8

    @property
    def omega0_sq(self) -> float:
        """Square of the undamped frequency."""
        return self.stiffness / self.mass

    @property
    def two_zeta(self) -> float:
        """Damping per unit mass."""
        return self.damping / self.mass

    @property
    def load(self) -> float:
        """Constant acceleration towards the cam."""
        return self.gravity + self.preload / self.mass


@dataclass(frozen=True)
class World:
    """A follower on the cam at one speed, and the rules that are not integration."""

    follower: Follower
    omega: float
    last_turn: int

    @property
    def period(self) -> float:
        """Seconds per turn."""
        return TWO_PI / self.omega

    def push(self, index: int, theta: float) -> float:
        """Relative acceleration ``a`` of a follower on the cam, by the formula of a region."""
        f, omega = self.follower, self.omega
        c, slope, bend = arc(index, theta)
        inertia = omega * omega * bend
        return -f.omega0_sq * c - f.two_zeta * omega * slope - f.load - inertia

    def fall_time(self, theta: float, y: float, u: float) -> float:
        """Seconds until the gap closes at the present relative acceleration."""
        f = self.follower
        a = self.push(region(theta), theta) - f.omega0_sq * y - f.two_zeta * u
        if a >= 0.0:
            return math.inf
        return (u + math.sqrt(u * u - 2.0 * a * y)) / -a

    def advance(self, turn: int, theta: float) -> tuple[int, float]:
        """Bring an unwrapped angle back to [0, 2 pi)."""
        whole = math.floor(theta / TWO_PI)
        return turn + whole, theta - whole * TWO_PI

    def detachment(self, turn: int, theta: float) -> State | None:
        """State in which a follower at rest on the cam from ``theta`` on leaves it."""
        start = turn
        while turn <= start + 1:
            index = region(theta)
            leave = self._leaves(index, theta)
            if leave is not None:
                return (*self.advance(turn, leave), 0.0, 0.0)
            turn, theta = self.advance(turn, ENDS[index])
        return None

    def _leaves(self, index: int, theta: float) -> float | None:
        """First angle of a region, from ``theta`` on, at which ``a`` is positive."""
        if self.push(index, theta) > 0.0:
            return theta
        grid = np.linspace(theta, ENDS[index], 17)
        for left, right in pairwise(grid):
            if self.push(index, right) > 0.0:
                return brentq(lambda x: self.push(index, x), left, right, xtol=1e-15)
        return None

    def rebound(self, turn: int, theta: float, u: float, chatter_tol: float) -> State | None:
        """State after an impact: thrown up, or at rest where chatter is closed."""
        r = self.follower.restitution
        a = self.push(region(theta), theta)
        if a < 0.0:
            left = 2.0 * r * u / ((1.0 - r) * a) if r < 1.0 else math.inf
            if left <= chatter_tol * self.period:
                return self.detachment(*self.advance(turn, theta + self.omega * left))
        return turn, theta, 0.0, -r * u


# ----------------------------------------------------------------------------- scipy flights

POSITION, GAP = "position", "gap"
Leg = tuple[float, float, float, bool]  # unwrapped theta, y, u, contact?


CONTACT, TURNING = 0, 1  # events of a flight


@dataclass(frozen=True)
class Flight:
    """One call of ``solve_ivp``: equations, gap and its rate, initial values and limits."""

    rhs: Callable
    gap: Callable
    rate: Callable | None
    start: tuple[float, float]
    y: float
    u: float
    span: float
    fall: float
    max_step: float

    def events(self) -> list[Callable]:
        """Contact, and the bottom of a dip of the gap.

        Without the second a step that enters the cam and leaves it again, as in a chatter that
        does not complete, would show no change of sign and lose the impact.
        """

        def contact(t: float, z: np.ndarray) -> float:
            return self.gap(t, z)

        def turning(t: float, z: np.ndarray) -> float:
            return 1.0 if t == 0.0 and self.u >= 0.0 else self.rate(t, z)

        contact.terminal = turning.terminal = True
        contact.direction, turning.direction = -1, 1
        return [contact] if self.rate is None else [contact, turning]


class ScipyFlight:
    """Flights by ``solve_ivp`` with a terminal contact event."""

    def __init__(
        self,
        world: World,
        method: str,
        *,
        rtol: float,
        atol: float,
        gap_below: float,
        max_step: float = math.inf,
        max_turn: float = math.inf,
    ) -> None:
        """Steps are at most ``max_step`` seconds and ``max_turn`` turns."""
        self.world = world
        self.options = {"method": method, "rtol": rtol, "atol": atol}
        self.max_step = min(max_step, max_turn * world.period)
        self.gap_below = gap_below * world.period

    def __call__(self, turn: int, theta: float, y: float, u: float) -> tuple | None:
        """Turn, angle and relative velocity at the next contact; None past the last turn."""
        contact = False
        while not contact:
            if turn > self.world.last_turn:
                return None
            fall = self.world.fall_time(theta, y, u)
            leg = self._in_gap if fall < self.gap_below else self._in_position
            theta, y, u, contact = leg(theta, y, u, fall)
            turn, theta = self.world.advance(turn, theta)
        return turn, theta, u

    def _in_position(self, theta: float, y: float, u: float, fall: float) -> Leg:
        """Integrate ``(q, v)`` for a turn at most."""
        f, omega = self.world.follower, self.world.omega
        k, b, load = f.omega0_sq, f.two_zeta, f.load
        c, slope, _ = arc(region(theta), theta)

        def rhs(_t: float, z: np.ndarray) -> tuple[float, float]:
            return z[1], -k * z[0] - b * z[1] - load

        def gap(t: float, z: np.ndarray) -> float:
            return z[0] - height(theta + omega * t)

        def rate(t: float, z: np.ndarray) -> float:
            angle = (theta + omega * t) % TWO_PI
            return z[1] - omega * arc(region(angle), angle)[1]

        start, span = (c + y, u + omega * slope), self.world.period
        flight = Flight(rhs, gap, rate, start, y, u, span, fall, self.max_step)
        t, q, v, event = self._integrate(flight)
        theta += omega * t
        angle = theta % TWO_PI
        c, slope, _ = arc(region(angle), angle)
        y, u = q - c, v - omega * slope
        return self._leg(theta, y, u, event)

    def _in_gap(self, theta: float, y: float, u: float, fall: float) -> Leg:
        """Integrate ``(y, u)`` to the next breakpoint at most."""
        world, f, index = self.world, self.world.follower, region(theta)
        omega, k, b, end = world.omega, f.omega0_sq, f.two_zeta, ENDS[index]

        def rhs(t: float, z: np.ndarray) -> tuple[float, float]:
            return z[1], world.push(index, theta + omega * t) - k * z[0] - b * z[1]

        def gap(_t: float, z: np.ndarray) -> float:
            return z[0]

        def rate(_t: float, z: np.ndarray) -> float:
            return z[1]

        span, max_step = (end - theta) / omega, min(self.max_step, fall)
        flight = Flight(rhs, gap, rate, (y, u), y, u, span, fall, max_step)
        t, y, u, event = self._integrate(flight)
        return self._leg(theta + omega * t if t < span else end, y, u, event)

    @staticmethod
    def _leg(theta: float, y: float, u: float, event: int | None) -> Leg:
        """What an event makes exact: the gap at a contact, its rate at a turning point."""
        if event == CONTACT:
            return theta, 0.0, u, True
        return theta, max(y, 0.0), 0.0 if event == TURNING else u, False

    def _integrate(self, flight: Flight) -> tuple[float, float, float, int | None]:
        """Time, state and event at the end of a flight; no contact at its own start."""
        first = min(0.5 * flight.fall, flight.max_step, flight.span, self.world.period / 64.0)
        for _ in range(20):
            t, z, gap, event = self._solve(flight, first)
            if event == TURNING and gap < 0.0:  # a dip inside one step: end it at the bottom
                t, z, gap, event = self._solve(replace(flight, rate=None, span=t), first)
            if event != CONTACT or t > 0.0:
                return t, z[0], z[1], event
            first /= 8.0  # the first step jumped over the whole flight
        raise RuntimeError("the contact event cannot leave its starting point")

    def _solve(self, flight: Flight, first: float) -> tuple[float, np.ndarray, float, int | None]:
        """Time, state, gap and the event that stopped ``solve_ivp``."""
        sol = solve_ivp(
            flight.rhs,
            (0.0, flight.span),
            flight.start,
            events=flight.events(),
            first_step=min(first, flight.span),
            max_step=flight.max_step,
            **self.options,
        )
        t, z = sol.t[-1], sol.y[:, -1]
        event = None
        if sol.status == 1:
            event = CONTACT if sol.t_events[CONTACT].size else TURNING
        return t, z, flight.gap(t, z), event


# ---------------------------------------------------------------------------- heyoka flights


STOPPED = -1  # outcome of a propagation that its terminal event ended


@lru_cache(maxsize=8)
def _compiled(follower: Follower, tol: float) -> dict[tuple, tuple]:
    """Integrators, each with views of its state and parameters.

    They are keyed by the circle of the cam (or SKY), the coordinates and the presence of the
    event.  Parameters, as many as a system uses: omega, the angle at time 0 from the symmetry
    axis of the arc, c of a round part.
    """
    import heyoka as hy

    def build(system: list, events: list) -> tuple:
        ta = hy.taylor_adaptive(system, [0.0, 0.0], tol=tol, t_events=events)
        return ta, ta.state, ta.pars

    made = {}
    for kind in (FLANK, NOSE, ROUND):
        for coordinates in (POSITION, GAP):
            system, gap = _symbolic(hy, follower, kind, coordinates)
            event = hy.t_event(gap, direction=hy.event_direction.negative)
            for armed in (False, True):
                made[kind, coordinates, armed] = build(system, [event] * armed)
    system, height_over_top = _symbolic(hy, follower, SKY, POSITION)
    event = hy.t_event(height_over_top, direction=hy.event_direction.negative)
    made[SKY, POSITION, True] = build(system, [event])
    return made


def _symbolic(hy: object, f: Follower, kind: str, coordinates: str) -> tuple[list, object]:
    """Equations of motion and gap of a flight over one circle of the cam."""
    z, w, x = hy.make_vars("z", "w", "x")
    omega, angle = hy.par[0], hy.par[0] * hy.time + hy.par[1]
    c = hy.par[2] if kind == ROUND else hy.expression(CEILING)
    if kind in (FLANK, NOSE):
        kappa, rho = (-KAPPA1, RHO1) if kind == FLANK else (KAPPA2, RHO2)
        c = kappa * hy.cos(x) + hy.sqrt(rho * rho - kappa * kappa * hy.sin(x) ** 2) - OFFSET
    force = -f.omega0_sq * z - f.two_zeta * w - f.load
    if coordinates == POSITION:
        return [(z, w), (w, force)], z - hy.subs(c, {x: angle})
    slope = hy.diff(c, x)
    a = -f.omega0_sq * c - f.two_zeta * omega * slope - omega**2 * hy.diff(slope, x)
    return [(z, w), (w, force + hy.subs(a, {x: angle}))], z


class HeyokaFlight:
    """Flights by Taylor series, region by region of the cam, with a terminal contact event."""

    def __init__(self, world: World, tol: float, gap_below: float) -> None:
        self.world = world
        self.gap_below = gap_below * world.period
        self.made = _compiled(world.follower, tol)

    def __call__(self, turn: int, theta: float, y: float, u: float) -> tuple | None:
        """Turn, angle and relative velocity at the next contact; None past the last turn."""
        contact = False
        while not contact:
            if turn > self.world.last_turn:
                return None
            index = region(theta)
            fall = self.world.fall_time(theta, y, u)
            legs = self._in_gap if fall < self.gap_below else self._in_position
            theta, y, u, contact = legs(index, theta, y, u, fall)
            turn, theta = self.world.advance(turn, theta)
        return turn, theta, u

    def _in_position(self, index: int, theta: float, y: float, u: float, fall: float) -> Leg:
        """Integrate ``(q, v)`` to the contact, to the end of the turn or over the top."""
        omega = self.world.omega
        c, slope, _ = arc(index, theta)
        z, w, hit = c + y, u + omega * slope, False
        if z > CEILING:
            return self._in_sky(theta, z, w)
        if y <= 0.0:
            theta, z, w, hit = self._run(POSITION, False, index, theta, (z, w), fall / 16.0)
        while not hit and z <= CEILING:
            index += theta >= ENDS[index]
            if index > 6:
                break
            theta, z, w, hit = self._run(POSITION, True, index, theta, (z, w), math.inf)
        if not hit and z > CEILING:
            return self._in_sky(theta, z, w)
        c, slope, _ = arc(min(index, 6), theta)
        return theta, 0.0 if hit else z - c, w - omega * slope, hit

    def _in_sky(self, theta: float, z: float, w: float) -> Leg:
        """Integrate above the whole cam, whatever part of it passes below, for a turn at most."""
        ta, state, _ = self.made[SKY, POSITION, True]
        ta.time = 0.0
        state[:] = z, w
        ta.reset_cooldowns()
        ta.propagate_until(self.world.period)
        theta += self.world.omega * ta.time
        wrapped = theta % TWO_PI
        c, slope, _ = arc(region(wrapped), wrapped)
        return theta, float(state[0]) - c, float(state[1]) - self.world.omega * slope, False

    def _in_gap(self, index: int, theta: float, y: float, u: float, fall: float) -> Leg:
        """Integrate ``(y, u)`` to the contact or the next breakpoint."""
        if y <= 0.0:
            theta, y, u, _ = self._run(GAP, False, index, theta, (y, u), fall / 16.0)
        if theta >= ENDS[index]:
            return theta, y, u, False
        return self._run(GAP, True, index, theta, (y, u), math.inf)

    def _run(
        self,
        coordinates: str,
        armed: bool,
        index: int,
        theta: float,
        start: tuple[float, float],
        limit: float,
    ) -> Leg:
        """One integration inside a region, for ``limit`` seconds at most."""
        omega, kind, centre, end = self.world.omega, KINDS[index], CENTRES[index], ENDS[index]
        ta, state, pars = self.made[kind, coordinates, armed]
        ta.time = 0.0
        state[:] = start
        if len(pars):
            pars[:] = (omega, 0.0 if kind == ROUND else theta - centre, centre)[: len(pars)]
        if armed:
            ta.reset_cooldowns()
        elif limit == math.inf:  # a > 0: any short stretch is free of contact
            limit = 1e-4 * self.world.period
        span = (end - theta) / omega
        hit = int(ta.propagate_until(min(span, limit))[0]) == STOPPED
        stop = end if span <= limit and not hit else theta + omega * ta.time
        return stop, float(state[0]), float(state[1]), hit


# -------------------------------------------------------------------------------- interface

# dop853: as accurate as rk45 at 190 and 700 rpm (1e-11 and 5e-14 of a turn); looser tolerances
# gain at most 60 % in speed and lose up to five digits; the step limit costs nothing there.
# heyoka: 1e-16 is no more accurate than 1e-13, and a few per cent slower.
DEFAULTS = {
    "rk45": {"rtol": 1e-12, "atol": 1e-12, "max_step": 1e-3},
    "dop853": {"rtol": 1e-12, "atol": 1e-14, "max_turn": 1.0 / 16.0},
    "heyoka": {"tol": 1e-13},
}


def available(method: str) -> bool:
    """Whether the packages a method needs are installed."""
    if method != "heyoka":
        return True
    try:
        import heyoka  # noqa: F401
    except ImportError:
        return False
    return True


def _flight(method: str, world: World, settings: dict) -> Callable:
    """The integrator of flights of a method; unknown settings raise TypeError."""
    merged = {"gap_below": GAP_BELOW, **DEFAULTS[method], **settings}
    if method == "heyoka":
        return HeyokaFlight(world, **merged)
    return ScipyFlight(world, {"rk45": "RK45", "dop853": "DOP853"}[method], **merged)


def launch(world: World, start: tuple[float, float] | None) -> State | None:
    """First state of a run: at rest on the cam at theta = 0, or at a given ``(q, v)``."""
    if start is None:
        return world.detachment(0, 0.0)
    c, slope, _ = arc(0, 0.0)
    return 0, 0.0, start[0] - c, start[1] - world.omega * slope


def simulate(
    method: str,
    rpm: float,
    impacts: int,
    *,
    start: tuple[float, float] | None = None,
    chatter_tol: float = 1e-9,
    follower: Follower | None = None,
    **settings: float,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Follow the follower from theta = 0 until a number of impacts.

    ``start`` is ``(q, v)`` at theta = 0, or None for rest on the cam; ``settings`` replace
    those of ``DEFAULTS[method]`` (and ``gap_below``).  Returns the impact phases as an array of
    rows (whole turns since the start, theta in rad), the relative velocities before the impacts
    and the seconds spent, compilation excluded.  A follower that never leaves the cam, or does
    not come back to it, gives fewer impacts.
    """
    world = World(follower or Follower(), rpm * math.pi / 30.0, 50 + 10 * impacts)
    fly = _flight(method, world, settings)
    phases, speeds = [], []
    begun = time.perf_counter()
    state = launch(world, start)
    while state is not None and len(phases) < impacts:
        contact = fly(*state)
        if contact is None:
            break
        turn, theta, u = contact
        phases.append((turn, theta))
        speeds.append(u)
        state = world.rebound(turn, theta, u, chatter_tol)
    seconds = time.perf_counter() - begun
    return np.array(phases).reshape(-1, 2), np.array(speeds), seconds
