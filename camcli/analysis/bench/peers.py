"""General-purpose integrators on the cam and follower, driven as a careful user would.

They share the loop over events (`follow`) and bring nothing but `integrate this until an event`: no
line of the kernel is used. What care means:

* A flight long enough is integrated in (q, v), whose right-hand side has no breakpoints. One that
  falls back within GAP_BELOW of a turn is integrated in the gap y = q - c and u = y' up to the next
  breakpoint of the cam, because q - c of a late chatter bounce is below the rounding of q.
* A step may enter the cam and leave it again without a change of sign of the gap at its ends;
  solve_ivp therefore also stops where the gap has a minimum.
* A contact must not fire again as the flight it starts leaves: the first step ends at half the
  ballistic time of the flight, or a part of it is flown by an integrator without events (heyoka,
  whose detection may miss a contact when the gap starts at zero).
* Chatter is closed by its first-order map, 2 r u / ((1 - r) a) after an impact at u < 0 with a < 0,
  once that is below the chatter tolerance; the follower then rests until a becomes positive.
* Every run has a budget of seconds and impacts: Radau at 1e-6 makes tens of thousands of impacts
  at 190 rpm where there are some fifty in a turn.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from time import process_time
from typing import Any, NamedTuple

from camcli.analysis.bench.lifts import CIRCLE, DWELL, TWO_PI, WAVE, Lift
from camcli.system import Follower

CONTACT, TURNING = 0, 1  # events: the gap closes; it has a minimum
CLEAR = 0.02  # m above the top of the cam: no contact up there; from twice that on `above`
GAP_BELOW = 1e-3  # turns: a flight that falls back sooner is integrated in the gap
GRID = 16  # cells of a region in the search for the end of a sticking
HALVINGS = 80  # of an interval: down to the last bit


class BudgetError(Exception):
    """The budget of time or impacts is used up."""


@dataclass
class Trace:
    """What a method found: impacts (turn, theta, u), rests (turn, theta), the end (q, v)."""

    hits: list[tuple[int, float, float]] = field(default_factory=list)
    rests: list[tuple[int, float]] = field(default_factory=list)
    final: tuple[float, float] | None = None
    evaluations: int = 0
    given_up: bool = False


class State(NamedTuple):
    """Whole turns and theta in [0, 2 pi), gap y (m), relative velocity u (m/s)."""

    turn: int
    theta: float
    y: float
    u: float


class Machine:
    """A follower on a cam at one speed, from theta = 0 to `turns`, and the budget of one run."""

    def __init__(
        self,
        follower: Follower,
        lift: Lift,
        omega: float,
        turns: float,
        chatter_tolerance: float,
        seconds: float = math.inf,
        most_impacts: int = 10**9,
    ):
        f = follower
        self.r, self.lift, self.omega, self.turns = f.restitution, lift, omega, turns
        self.k, self.b = f.stiffness / f.mass, f.damping / f.mass
        self.load = f.gravity + f.preload / f.mass
        self.period = TWO_PI / omega
        self.chatter_s = chatter_tolerance * self.period
        self.deadline = process_time() + seconds  # a busy machine changes nothing
        self.most_impacts = most_impacts
        self.trace = Trace()

    def check(self) -> None:
        """Raise BudgetError where the budget is used up."""
        if process_time() > self.deadline or len(self.trace.hits) > self.most_impacts:
            raise BudgetError

    def pushed(self, region: int, theta: float) -> float:
        """Relative acceleration of a follower at rest on a region of the cam, m/s2."""
        c, slope, bend = self.lift.law(region, theta)
        omega = self.omega
        return -self.k * c - self.b * omega * slope - self.load - omega * omega * bend

    def fall_time(self, at: State) -> float:
        """Seconds until the gap closes at the present relative acceleration."""
        a = self.pushed(self.lift.region(at.theta), at.theta) - self.k * at.y - self.b * at.u
        return math.inf if a >= 0.0 else (at.u + math.sqrt(at.u * at.u - 2.0 * a * at.y)) / -a

    def end(self, turn: int) -> float:
        """Where the run ends, as an angle counted from the beginning of a turn."""
        return (self.turns - turn) * TWO_PI

    def rest(self, turn: int, theta: float) -> State | None:
        """State in which a follower at rest on the cam leaves it; None: it rests to the end."""
        while turn < self.turns:
            region = self.lift.region(theta)
            high = min(self.lift.regions[region].end, theta + TWO_PI)
            leave = self._pulled_off(region, theta, high)
            turn, theta = wrapped(turn, high if leave is None else leave)
            if leave is not None:
                return State(turn, theta, 0.0, 0.0) if turn < self.turns else None
        return None

    def _pulled_off(self, region: int, low: float, high: float) -> float | None:
        """First angle from low to high, on one region, at which the follower is pulled off."""

        def pulled(theta: float) -> bool:
            return self.pushed(region, theta) > 0.0

        if pulled(low):
            return low
        for left, right in pairwise(low + (high - low) * k / GRID for k in range(GRID + 1)):
            if pulled(right):
                return bisected(pulled, left, right)
        return None

    def rebound(self, turn: int, theta: float, u: float) -> State | None:
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
        return State(turn, theta, 0.0, -self.r * u)


Result = tuple[float, float, float, int | None]  # t, z, z' where it ended, and the event there


class Segment:
    """One integration of z'' = accel(t, z, z') from (z, z') = start, over `span` seconds.

    z is the gap where the flight falls back soon (`in_gap`), else the position; `above`: it starts
    clear of the whole cam. In the gap, and `by_region` unless it is above, it ends with its region.
    """

    def __init__(self, machine: Machine, at: State, by_region: bool):
        lift = machine.lift
        self.machine, self.at, self.region = machine, at, lift.region(at.theta)
        self.fall = machine.fall_time(at)
        self.in_gap = self.fall < GAP_BELOW * machine.period
        c, slope, _ = lift.law(self.region, at.theta)
        self.above = not self.in_gap and c + at.y > lift.top + 2.0 * CLEAR
        self.stop = min(at.theta + TWO_PI, machine.end(at.turn))
        if self.in_gap or (by_region and not self.above):
            self.stop = min(self.stop, lift.regions[self.region].end)
        self.span = (self.stop - at.theta) / machine.omega
        self.start = (at.y, at.u) if self.in_gap else (c + at.y, at.u + machine.omega * slope)

    def theta(self, t: float) -> float:
        """Phase after t seconds, counted on beyond a turn."""
        return self.stop if t >= self.span else self.at.theta + self.machine.omega * t

    def accel(self, t: float, z: float, w: float) -> float:
        """z'' in m/s2."""
        m = self.machine
        push = m.pushed(self.region, self.at.theta + m.omega * t) if self.in_gap else -m.load
        return push - m.k * z - m.b * w

    def gap(self, t: float, z: float) -> float:
        """Gap in m."""
        return z if self.in_gap else z - self.machine.lift.at(self.theta(t))[0]

    def rate(self, t: float, w: float) -> float:
        """Rate of the gap in m/s."""
        m = self.machine
        return w if self.in_gap else w - m.omega * m.lift.at(self.theta(t))[1]

    def end(self, t: float, z: float, w: float, event: int | None) -> State:
        """The state there; an event makes the gap exact at a contact, its rate at a minimum."""
        y = 0.0 if event == CONTACT else max(self.gap(t, z), 0.0)
        u = 0.0 if event == TURNING else self.rate(t, w)
        return State(*wrapped(self.at.turn, self.theta(t)), y, u)


class Method:
    """A method of integration; `by_region`: it knows the cam by one region at a time."""

    by_region = False

    def integrate(self, segment: Segment) -> Result:
        """Integrate a segment to its first event or its end."""
        raise NotImplementedError


def follow(machine: Machine, method: Method, q: float | None, v: float | None) -> Trace:
    """Follow the follower from (q, v) at theta = 0; None: at rest on the cam."""
    trace = machine.trace
    c, slope, _ = machine.lift.law(0, 0.0)
    state: State | None = (
        machine.rest(0, 0.0)
        if q is None or v is None
        else State(0, 0.0, q - c, v - machine.omega * slope)
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


def fly(machine: Machine, method: Method, at: State) -> tuple[bool, State]:
    """(whether on the cam, state) at the next contact or at the end of the run."""
    while at.theta < machine.end(at.turn):
        machine.check()
        segment = Segment(machine, at, method.by_region)
        t, z, w, event = method.integrate(segment)
        at = segment.end(t, z, w, event)
        if event == CONTACT:
            return True, at
    return False, at


def wrapped(turn: int, theta: float) -> tuple[int, float]:
    """The same angle with theta in [0, 2 pi)."""
    whole = math.floor(theta / TWO_PI)
    return turn + whole, theta - whole * TWO_PI


def bisected(above: Callable[[float], bool], low: float, high: float) -> float:
    """Where a condition that is false at low and true at high begins to hold."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (low, middle) if above(middle) else (middle, high)
    return high


class RungeKutta4(Method):
    """Fixed steps of the classical method of order four; contacts by bisection of a step."""

    PER_HOP = 8  # steps of a short flight, at least

    def __init__(self, steps: int):
        self.steps = steps  # per turn

    def integrate(self, segment: Segment) -> Result:
        """Steps of h until the gap is negative or the span is over."""
        machine, accel = segment.machine, segment.accel
        h = min(machine.period / self.steps, segment.fall / self.PER_HOP)
        t, (z, w) = 0.0, segment.start
        while t < segment.span:
            machine.check()
            left = segment.span - t
            size = left if left < (1.0 + 1e-9) * h else h
            after = runge_kutta_step(accel, t, z, w, size)
            machine.trace.evaluations += 4
            if segment.gap(t + size, after[0]) < 0.0:
                return self._landing(segment, t, z, w, size)
            t, (z, w) = (segment.span if size == left else t + size), after
        return t, z, w, None

    def _landing(self, segment: Segment, t: float, z: float, w: float, size: float) -> Result:
        """The contact inside a step: where a shorter one would end on the cam."""

        def inside(s: float) -> bool:
            segment.machine.trace.evaluations += 4
            return segment.gap(t + s, runge_kutta_step(segment.accel, t, z, w, s)[0]) <= 0.0

        size = bisected(inside, 0.0, size)
        return t + size, *runge_kutta_step(segment.accel, t, z, w, size), CONTACT


def runge_kutta_step(
    accel: Callable[[float, float, float], float], t: float, z: float, w: float, h: float
) -> tuple[float, float]:
    """(z, w) after one step of the classical fourth-order method."""
    k1 = accel(t, z, w)
    w2 = w + 0.5 * h * k1
    k2 = accel(t + 0.5 * h, z + 0.5 * h * w, w2)
    w3 = w + 0.5 * h * k2
    k3 = accel(t + 0.5 * h, z + 0.5 * h * w2, w3)
    w4 = w + h * k3
    k4 = accel(t + h, z + h * w3, w4)
    return (
        z + h / 6.0 * (w + 2.0 * (w2 + w3) + w4),
        w + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4),
    )


class SolveIvp(Method):
    """scipy's solve_ivp with rtol = atol, terminal events and steps of at most max_turn turns."""

    RETRIES = 20
    TINY = 1e-300  # m, an open gap
    CHECKED = 256  # evaluations from one look at the clock to the next

    def __init__(self, name: str, tolerance: float, max_turn: float = math.inf):
        method = "Radau" if name == "radau" else name.upper()
        self.options = {"method": method, "rtol": tolerance, "atol": tolerance}
        self.max_turn = max_turn

    def integrate(self, segment: Segment) -> Result:
        """To a contact, or the bottom of a dip of the gap; no contact at its own start."""
        period = segment.machine.period
        max_step = self.max_turn * period
        if segment.in_gap:
            max_step = min(max_step, segment.fall)
        first = min(0.5 * segment.fall, max_step, segment.span, period / 64.0)
        for _ in range(self.RETRIES):
            try:
                t, z, w, event = self._solve(segment, segment.span, first, max_step, True)
            except ValueError:  # LSODA's interpolant does not meet its steps: no root between them
                first *= 0.7
                continue
            if event == TURNING and segment.gap(t, z) < 0.0:  # a dip inside one step: end there
                t, z, w, event = self._solve(segment, t, first, max_step, False)
            if event != CONTACT or t > 0.0:
                return t, z, w, event
            first /= 8.0  # the first step jumped over the whole flight
        raise ArithmeticError("the contact event cannot leave its starting point")

    def _solve(
        self, segment: Segment, span: float, first: float, max_step: float, dips: bool
    ) -> Result:
        """One call; with `dips` the bottom of a dip is an event too."""
        from scipy.integrate import solve_ivp

        first = min(first, span)
        calls = 0

        def rhs(t, z):
            nonlocal calls
            calls += 1
            if not calls % self.CHECKED:
                segment.machine.check()
            return z[1], segment.accel(t, z[0], z[1])

        # LSODA begins with steps much shorter than the one it is given, where a gap that opens with
        # the cube of time is below the rounding of q - c: before `first` a leaving flight is open
        leaves = segment.at.u >= 0.0

        def contact(t, z):
            gap = segment.gap(t, z[0])
            return max(gap, self.TINY) if leaves and t < first else gap

        def turning(t, z):
            return 1.0 if leaves and t < first else segment.rate(t, z[1])

        contact.terminal = turning.terminal = True  # type: ignore[attr-defined]
        contact.direction, turning.direction = -1, 1  # type: ignore[attr-defined]
        events = [contact, turning] if dips else [contact]
        steps = {"first_step": first, "max_step": max_step}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sol = solve_ivp(rhs, (0.0, span), segment.start, events=events, **steps, **self.options)
        segment.machine.trace.evaluations += sol.nfev
        if sol.status < 0:
            raise ArithmeticError(sol.message)
        event = None
        if sol.status == 1:
            event = CONTACT if sol.t_events[CONTACT].size else TURNING
        return float(sol.t[-1]), float(sol.y[0, -1]), float(sol.y[1, -1]), event


SKY = "sky"  # form of a segment above the whole cam; its event is falling below
OMEGA, ANGLE, K, B, LOAD, FIRST, SECOND, OFFSET = range(8)  # parameters of heyoka's equations


class Heyoka(Method):
    """Taylor series with a terminal event, whose equations need one region of the cam at a time."""

    by_region = True
    PART = 1.0 / 16.0  # of the fall, flown without events where a flight leaves the cam
    SHORT = 1e-4  # turns of it where the follower is pulled off

    def __init__(self, tolerance: float):
        self.tolerance = tolerance

    def integrate(self, segment: Segment) -> Result:
        """One propagation; one that leaves the cam begins with a part without events."""
        t, (z, w) = 0.0, segment.start
        if segment.at.y <= 0.0:
            short = segment.fall == math.inf
            part = self.SHORT * segment.machine.period if short else self.PART * segment.fall
            t, z, w, _ = self._propagate(segment, (0.0, z, w), min(part, segment.span), False)
        if t >= segment.span:
            return t, z, w, None
        return self._propagate(segment, (t, z, w), segment.span, True)

    def _propagate(
        self, segment: Segment, begin: tuple[float, ...], until: float, armed: bool
    ) -> Result:
        machine, lift = segment.machine, segment.machine.lift
        form, first, second, angle = SKY, lift.top + CLEAR, 0.0, 0.0
        if not segment.above:
            form, first, second, centre, _ = lift.regions[segment.region]
            angle = segment.at.theta - centre
        ta, state, pars = taylor_integrator(form, segment.in_gap, armed, self.tolerance)
        ta.time = begin[0]
        state[:] = begin[1:]
        values = (machine.omega, angle, machine.k, machine.b, machine.load, first, second)
        pars[:] = (*values, lift.offset)[: len(pars)]
        if ta.with_events:
            ta.reset_cooldowns()
        outcome = ta.propagate_until(until)
        machine.trace.evaluations += int(outcome[3])  # steps
        stopped = int(outcome[0]) == -1  # by its first terminal event
        event = CONTACT if stopped and form != SKY else None
        return (ta.time if stopped else until), float(state[0]), float(state[1]), event


@cache
def taylor_integrator(form: str, in_gap: bool, armed: bool, tolerance: float) -> tuple[Any, ...]:
    """heyoka's integrator with views of its state and parameters; each is compiled once."""
    import heyoka as hy

    z, w, x = hy.make_vars("z", "w", "x")
    par = hy.par
    angle = par[OMEGA] * hy.time + par[ANGLE]
    if form == CIRCLE:
        sin = par[FIRST] * hy.sin(x)
        c = par[FIRST] * hy.cos(x) + hy.sqrt(par[SECOND] * par[SECOND] - sin * sin) - par[OFFSET]
    elif form == WAVE:
        c = par[FIRST] - par[SECOND] * hy.cos(x)
    force = -par[K] * z - par[B] * w - par[LOAD]
    if form in (DWELL, SKY):
        gap, accel = (z, force - par[K] * par[FIRST]) if in_gap else (z - par[FIRST], force)
    elif in_gap:
        slope = hy.diff(c, x)
        pushed = -par[K] * c - par[B] * par[OMEGA] * slope
        pushed -= par[OMEGA] * par[OMEGA] * hy.diff(slope, x)
        gap, accel = z, force + hy.subs(pushed, {x: angle})
    else:
        gap, accel = z - hy.subs(c, {x: angle}), force
    event = hy.t_event(gap, direction=hy.event_direction.negative)
    system = [(z, w), (w, accel)]
    ta = hy.taylor_adaptive(system, [0.0, 0.0], tol=tolerance, t_events=[event] * armed)
    return ta, ta.state, ta.pars
