"""General-purpose integrators on the cam and follower, driven as a careful user would.

The gap y = q - c obeys y'' = a(theta) - (k y + b y')/m, with a the relative acceleration at rest on
the cam: from one breakpoint of the cam to the next its right-hand side is smooth, and a late bounce
of a chatter is not below the rounding of q. The loop over regions and contacts (`follow`) is
shared; a method brings `integrate to the next contact`. Nothing of the kernel is used. Care means:

* A contact must not fire again as the flight it starts leaves: a small part of the flight is
  integrated without events. No step is longer than a ballistic flight would be.
* A step may enter the cam and leave it again: solve_ivp looks at every minimum of the gap, too.
* Chatter is closed by its first-order map, 2 r u / ((1 - r) a) after an impact at u < 0 with a < 0,
  once that is below the chatter tolerance; the follower then rests until a becomes positive.
* Every run has a budget of seconds and impacts: Radau at 1e-6 makes tens of thousands of impacts
  at 190 rpm where there are some fifty in a turn.
"""

import math
import warnings
from bisect import bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from time import process_time
from typing import Any, NamedTuple

from camcli.system import Follower

TWO_PI = 2.0 * math.pi
PART = 1.0 / 16.0  # of the ballistic flight, integrated without events where it leaves the cam
SHORT = 1e-4  # turns of it where the follower is pulled off
CLEAR = 0.02  # m above the top of the cam: no contact up there
GRID = 16  # cells of a region in the search for the end of a sticking
PER_HOP = 8  # fixed steps of a short flight, at least
CHECKED = 256  # evaluations of solve_ivp from one look at the clock to the next


class PeerPiece(NamedTuple):
    """A smooth piece: c = a cos x + sqrt(b^2 - d^2 sin^2 x) - offset, x = theta - centre.

    A circle of radius b about a point at distance a = d, a dwell (a = d = 0), a harmonic (d = 0).
    """

    a: float
    b: float
    d: float
    offset: float  # m
    centre: float  # rad
    end: float  # rad, of the region


class Lift:
    """Law of motion of a cam (scene section, kind arcs or eccentric) in closed form, in doubles.

    Region 0 begins at theta = 0; the last one runs on past 2 pi to the end of the first, since they
    are one piece. `sky` is one more, a level clear of the whole cam.
    """

    def __init__(self, section: Mapping[str, Any]):
        if section["kind"] == "arcs":
            self.regions = _arcs(section)
        else:  # c = base + lift (1 - cos theta)/2: one region, of two turns
            half = 0.5 * section["lift"]
            self.regions = [PeerPiece(-half, section["base"] + half, 0.0, 0.0, 0.0, 2.0 * TWO_PI)]
        self.breaks = [region.end for region in self.regions[:-1]]
        self.top = self.at(math.pi)[0]
        self.sky = len(self.regions)  # index of the region above the cam
        self.regions.append(PeerPiece(0.0, self.top + CLEAR, 0.0, 0.0, 0.0, math.inf))

    def law(self, index: int, theta: float) -> tuple[float, float, float]:
        """(c, dc/dtheta, d2c/dtheta2) of a region, its formula continued."""
        a, b, d, offset, centre, _ = self.regions[index]
        sin = math.sin(theta - centre)
        cos = math.cos(theta - centre)
        root = math.sqrt(b * b - (d * sin) ** 2)
        slope = -d * d * sin * cos / root
        bend = (-d * d * (cos * cos - sin * sin) - slope * slope) / root
        return a * cos + root - offset, slope - a * sin, bend - a * cos

    def region(self, theta: float) -> int:
        """Index of the region at theta in [0, 2 pi); a breakpoint belongs to the right."""
        return bisect_right(self.breaks, theta)

    def at(self, theta: float) -> tuple[float, float, float]:
        """(c, dc/dtheta, d2c/dtheta2) at any angle."""
        theta %= TWO_PI
        return self.law(self.region(theta), theta)


def _arcs(s: Mapping[str, Any]) -> list[PeerPiece]:
    """Three tangent circles; neighbours touch on the line through their centres."""
    k1, r1, k2, r2 = (s[x] for x in ("flank_center", "flank_radius", "nose_center", "nose_radius"))
    cos_centres = (k1 * k1 + k2 * k2 - (r1 - r2) ** 2) / (2.0 * k1 * k2)
    both = math.pi - math.acos(cos_centres)  # angle from a to c
    x = k2 * math.cos(both)
    y = k2 * math.sin(both)
    scale = r1 / (r1 - r2)
    c = math.radians(180.0 - 0.5 * s["top_dwell_deg"])
    a = c - both
    b = a + math.atan2(scale * y, scale * (x + k1) - k1)
    d = TWO_PI - c
    e = TWO_PI - b
    f = TWO_PI - a
    base = r1 - k1
    offset = s["offset"]
    return [
        PeerPiece(0.0, base, 0.0, offset, 0.0, a),
        PeerPiece(-k1, r1, k1, offset, a, b),
        PeerPiece(k2, r2, k2, offset, c, c),
        PeerPiece(0.0, k2 + r2, 0.0, offset, 0.0, d),
        PeerPiece(k2, r2, k2, offset, d, e),
        PeerPiece(-k1, r1, k1, offset, f, f),
        PeerPiece(0.0, base, 0.0, offset, 0.0, TWO_PI + a),
    ]


class BudgetError(Exception):
    """The budget of time or impacts is used up."""


@dataclass
class PeerTrace:
    """What a method found: impacts (turn, theta, u), rests (turn, theta), the end (q, v)."""

    hits: list[tuple[int, float, float]] = field(default_factory=list)
    rests: list[tuple[int, float]] = field(default_factory=list)
    final: tuple[float, float] | None = None
    evaluations: int = 0
    given_up: bool = False


class PeerState(NamedTuple):
    """Whole turns and theta in [0, 2 pi), gap y (m), its rate u (m/s)."""

    turn: int
    theta: float
    y: float
    u: float


class PeerMachine:
    """A follower on a cam at one speed (rad/s) over `turns`, and the budget of one run.

    chatter: its tolerance, turns; seconds: of the processor (a busy machine changes nothing).
    """

    def __init__(
        self,
        follower: Follower,
        lift: Lift,
        omega: float,
        turns: float,
        chatter: float,
        seconds: float = math.inf,
        most_impacts: int = 10**9,
    ):
        self.r = follower.restitution
        self.lift = lift
        self.omega = omega
        self.turns = turns
        self.k = follower.stiffness / follower.mass
        self.b = follower.damping / follower.mass
        self.load = follower.gravity + follower.preload / follower.mass
        self.period = TWO_PI / omega
        self.chatter_s = chatter * self.period
        self.deadline = process_time() + seconds
        self.most_impacts = most_impacts
        self.trace = PeerTrace()

    def check(self) -> None:
        """Raise BudgetError where the budget is used up."""
        if process_time() > self.deadline or len(self.trace.hits) > self.most_impacts:
            raise BudgetError

    def pushed(self, region: int, theta: float) -> float:
        """Relative acceleration of a follower at rest on a region of the cam, m/s2."""
        c, slope, bend = self.lift.law(region, theta)
        omega = self.omega
        return -self.k * c - self.b * omega * slope - self.load - omega * omega * bend

    def fall_time(self, at: PeerState) -> float:
        """Seconds until the gap closes at the present relative acceleration, inf at a departure."""
        a = self.pushed(self.lift.region(at.theta), at.theta) - self.k * at.y - self.b * at.u
        if a >= 0.0 or at.y == at.u == 0.0:
            return math.inf
        swing = math.sqrt(at.u * at.u - 2.0 * a * at.y)
        return (at.u + swing) / -a if at.u >= 0.0 else 2.0 * at.y / (swing - at.u)

    def end(self, turn: int) -> float:
        """Where the run ends, as an angle counted from the beginning of a turn."""
        return (self.turns - turn) * TWO_PI

    def rest(self, turn: int, theta: float) -> PeerState | None:
        """State in which a follower at rest on the cam leaves it; None: it rests to the end."""
        while turn < self.turns:
            region = self.lift.region(theta)
            high = min(self.lift.regions[region].end, theta + TWO_PI)
            leave = self._pulled_off(region, theta, high)
            turn, theta = wrapped(turn, high if leave is None else leave)
            if leave is not None:
                return PeerState(turn, theta, 0.0, 0.0) if turn < self.turns else None
        return None

    def _pulled_off(self, region: int, low: float, high: float) -> float | None:
        """First angle from low to high, on one region, at which the follower is pulled off."""
        if self.pushed(region, low) > 0.0:
            return low
        for left, right in pairwise(low + (high - low) * k / GRID for k in range(GRID + 1)):
            if self.pushed(region, right) > 0.0:
                return root(lambda theta: self.pushed(region, theta), left, right)
        return None

    def rebound(self, turn: int, theta: float, u: float) -> PeerState | None:
        """State after an impact: thrown up, or where the rest ends that closes a chatter."""
        self.check()
        self.trace.hits.append((turn, theta, u))
        a = self.pushed(self.lift.region(theta), theta)
        if a < 0.0 and self.r < 1.0:
            left = 2.0 * self.r * u / ((1.0 - self.r) * a)
            if left <= self.chatter_s:
                turn, theta = wrapped(turn, theta + self.omega * left)
                self.trace.rests.append((turn, theta))
                return self.rest(turn, theta)
        return PeerState(turn, theta, 0.0, -self.r * u)


@dataclass(frozen=True)
class PeerFlight:
    """A flight over one region from theta; fall: s, of a ballistic flight."""

    machine: PeerMachine
    region: int
    theta: float
    fall: float

    def accel(self, t: float, y: float, u: float) -> float:
        """y'' in m/s2."""
        m = self.machine
        return m.pushed(self.region, self.theta + m.omega * t) - m.k * y - m.b * u


Result = tuple[float, float, float, bool]  # t, y, u at the end, and whether it is a contact
# (flight, (t, y, u) to begin with, last t, whether to look for a contact): y > 0 where it is looked
# for
Method = Callable[[PeerFlight, tuple[float, float, float], float, bool], Result]


def follow(machine: PeerMachine, method: Method, q: float | None, v: float | None) -> PeerTrace:
    """Follow the follower from (q, v) at theta = 0; None: at rest on the cam."""
    trace = machine.trace
    c, slope, _ = machine.lift.law(0, 0.0)
    state: PeerState | None = (
        machine.rest(0, 0.0)
        if q is None or v is None
        else PeerState(0, 0.0, q - c, v - machine.omega * slope)
    )
    try:
        while state is not None:
            hit, (turn, theta, y, u) = fly(machine, method, state)
            if not hit:
                c, slope, _ = machine.lift.at(theta)
                break
            state = machine.rebound(turn, theta, u)
        else:
            y = u = 0.0
        trace.final = (c + y, machine.omega * slope + u)
    except BudgetError:
        trace.given_up = True
    return trace


def fly(machine: PeerMachine, method: Method, at: PeerState) -> tuple[bool, PeerState]:
    """(whether on the cam, state) at the next contact or at the end of the run."""
    lift = machine.lift
    omega = machine.omega
    while at.theta < machine.end(at.turn):
        machine.check()
        turn, theta, y, u = at
        fall = machine.fall_time(at)
        c, slope, _ = lift.at(theta)
        above = c + y > lift.top + 2.0 * CLEAR
        region = lift.sky if above else lift.region(theta)
        stop = min(lift.regions[region].end, theta + TWO_PI, machine.end(turn))
        if above:
            y = y + c - lift.top - CLEAR
            u = u + omega * slope
        flight = PeerFlight(machine, region, theta, fall)
        span = (stop - theta) / omega
        t = 0.0
        hit = False
        if y <= 0.0:
            step = SHORT * machine.period if fall == math.inf else PART * fall
            t, y, u, _ = method(flight, (t, y, u), min(step, span), False)
        if t < span:
            t, y, u, hit = method(flight, (t, y, u), span, True)
        theta = theta + omega * t if hit else stop
        y = 0.0 if hit else max(y, 0.0)
        if above:
            c, slope, _ = lift.at(theta)
            y = y + lift.top + CLEAR - c
            u = u - omega * slope
        at = PeerState(*wrapped(turn, theta), y, u)
        if hit and not above:
            return True, at
    return False, at


def wrapped(turn: int, theta: float) -> tuple[int, float]:
    """The same angle with theta in [0, 2 pi)."""
    whole = math.floor(theta / TWO_PI)
    return turn + whole, theta - whole * TWO_PI


def root(function: Callable[..., float], low: float, high: float, *args: tuple) -> float:
    """The zero between two numbers with values of different signs, to the last bits."""
    from scipy.optimize import brentq

    return brentq(function, low, high, *args, xtol=1e-300, rtol=2.0**-50)


def runge_kutta_4(steps: int) -> Method:
    """The classical method of order four: so many fixed steps per turn, contacts inside a step."""

    def step(flight: PeerFlight, t: float, y: float, u: float, h: float) -> tuple[float, float]:
        flight.machine.trace.evaluations += 4
        k1 = flight.accel(t, y, u)
        u2 = u + 0.5 * h * k1
        k2 = flight.accel(t + 0.5 * h, y + 0.5 * h * u, u2)
        u3 = u + 0.5 * h * k2
        k3 = flight.accel(t + 0.5 * h, y + 0.5 * h * u2, u3)
        u4 = u + h * k3
        k4 = flight.accel(t + h, y + h * u3, u4)
        y_after = y + h / 6.0 * (u + 2.0 * (u2 + u3) + u4)
        return y_after, u + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)

    def integrate(flight: PeerFlight, begin, until: float, contacts: bool) -> Result:
        t, y, u = begin
        h = min(flight.machine.period / steps, flight.fall / PER_HOP)
        while t < until:
            flight.machine.check()
            left = until - t
            size = left if left < (1.0 + 1e-9) * h else h
            after = step(flight, t, y, u, size)
            if contacts and after[0] < 0.0:
                height = lambda h, t, y, u: step(flight, t, y, u, h)[0]  # noqa: E731
                size = root(height, 0.0, size, (t, y, u))
                return t + size, *step(flight, t, y, u, size), True
            t, (y, u) = (until if size == left else t + size), after
        return t, y, u, False

    return integrate


def solve_ivp(name: str, tolerance: float, max_turn: float = math.inf) -> Method:
    """scipy's solve_ivp with rtol = atol, contact events and steps of at most max_turn turns."""
    import scipy.integrate

    method = "Radau" if name == "radau" else name.upper()

    def contact(t, state):
        return state[0]

    def dip(t, state):
        return state[1]

    contact.terminal = True  # type: ignore[attr-defined]
    contact.direction = -1  # type: ignore[attr-defined]
    dip.direction = 1  # type: ignore[attr-defined]

    def integrate(flight: PeerFlight, begin, until: float, contacts: bool) -> Result:
        machine = flight.machine
        calls = 0

        def rhs(t, state):
            nonlocal calls
            calls += 1
            if not calls % CHECKED:
                machine.check()
            return state[1], flight.accel(t, state[0], state[1])

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sol = scipy.integrate.solve_ivp(
                rhs,
                (begin[0], until),
                begin[1:],
                method,
                events=[contact, dip] if contacts else None,
                max_step=min(max_turn * machine.period, flight.fall),
                rtol=tolerance,
                atol=tolerance,
            )
        machine.trace.evaluations += sol.nfev
        if sol.status < 0:
            raise ArithmeticError(sol.message)
        if contacts:  # a step that passed through the cam: look again, up to its lowest point
            for t, (y, _) in zip(sol.t_events[1], sol.y_events[1], strict=True):
                if y < 0.0 and t < until:
                    return integrate(flight, begin, t, True)
        return float(sol.t[-1]), *map(float, sol.y[:, -1]), sol.status == 1

    return integrate


def heyoka_taylor(tolerance: float) -> Method:
    """heyoka's Taylor series with a terminal event."""

    def integrate(flight: PeerFlight, begin, until: float, contacts: bool) -> Result:
        machine = flight.machine
        taylor, state, pars = _taylor_integrator(tolerance, contacts)
        a, b, d, offset, centre, _ = machine.lift.regions[flight.region]
        values = (machine.k, machine.b, machine.load, machine.omega, flight.theta - centre)
        pars[:] = (*values, a, b, d, offset)
        taylor.time = begin[0]
        state[:] = begin[1:]
        if contacts:
            taylor.reset_cooldowns()
        outcome = taylor.propagate_until(until)
        machine.trace.evaluations += int(outcome[3])  # steps
        hit = int(outcome[0]) == -1  # stopped by its first terminal event
        return (taylor.time if hit else until), float(state[0]), float(state[1]), hit

    return integrate


@cache
def _taylor_integrator(tolerance: float, contacts: bool) -> tuple[Any, ...]:
    """heyoka's integrator with views of its state and parameters; each is compiled once."""
    import heyoka as hy

    y, u, x = hy.make_vars("y", "u", "x")
    k, damping, load, omega, angle, a, b, d, offset = (hy.par[n] for n in range(9))
    c = a * hy.cos(x) + hy.sqrt(b * b - d * d * hy.sin(x) * hy.sin(x)) - offset
    slope = hy.diff(c, x)
    pushed = -k * c - damping * omega * slope - omega * omega * hy.diff(slope, x) - load
    accel = hy.subs(pushed, {x: omega * hy.time + angle}) - k * y - damping * u
    event = hy.t_event(y, direction=hy.event_direction.negative)
    system = [(y, u), (u, accel)]
    events = [event] if contacts else []
    taylor = hy.taylor_adaptive(system, [0.0, 0.0], tol=tolerance, t_events=events)
    return taylor, taylor.state, taylor.pars
