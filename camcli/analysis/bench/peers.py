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
from functools import cache, partial
from itertools import pairwise
from time import process_time
from typing import Any, NamedTuple

from camcli.system import Follower

TWO_PI = 2.0 * math.pi
# A flight that has just left the cam is integrated for this part of its ballistic duration without
# looking for contacts: the contact that it leaves must not be found again.
PART = 1.0 / 16.0
SHORT = 1e-4  # turns integrated that way where the follower is pulled off, and no fall is foreseen
CLEAR = 0.02  # m above the top of the cam, from where on no contact is looked for
GRID = 16  # parts of a region in which the end of a sticking is looked for
PER_HOP = 8  # fixed steps that a short flight has at least
CHECKED = 256  # evaluations of solve_ivp after which the clock is looked at again


class LiftAt(NamedTuple):
    """The lift of a cam at one angle and its derivatives by the angle."""

    c: float  # m
    slope: float  # dc/dtheta, m/rad
    bend: float  # d2c/dtheta2, m/rad2


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
    are one piece. `sky` is the index of one more region, a level clear of the whole cam.
    """

    def __init__(self, section: Mapping[str, Any]):
        """Take the cam of a scene: its section `cam` as a mapping."""
        if section["kind"] == "arcs":
            self.regions = _arcs(section)
        else:  # c = base + lift (1 - cos theta)/2: one region, of two turns
            half = 0.5 * section["lift"]
            harmonic = PeerPiece(
                a=-half, b=section["base"] + half, d=0.0, offset=0.0, centre=0.0, end=2.0 * TWO_PI
            )
            self.regions = [harmonic]
        self.breaks = [region.end for region in self.regions[:-1]]
        self.top = self.at(math.pi).c
        self.sky = len(self.regions)  # index of the region above the cam
        level = self.top + CLEAR
        self.regions.append(PeerPiece(a=0.0, b=level, d=0.0, offset=0.0, centre=0.0, end=math.inf))

    def law(self, index: int, theta: float) -> LiftAt:
        """The lift by the formula of a region, which may be continued beyond the region's ends."""
        a, b, d, offset, centre, _ = self.regions[index]
        sin = math.sin(theta - centre)
        cos = math.cos(theta - centre)
        root = math.sqrt(b * b - (d * sin) ** 2)
        slope = -d * d * sin * cos / root
        bend = (-d * d * (cos * cos - sin * sin) - slope * slope) / root
        return LiftAt(a * cos + root - offset, slope - a * sin, bend - a * cos)

    def region(self, theta: float) -> int:
        """Index of the region at theta in [0, 2 pi); a breakpoint belongs to the right."""
        return bisect_right(self.breaks, theta)

    def at(self, theta: float) -> LiftAt:
        """The lift at any angle (rad)."""
        theta %= TWO_PI
        return self.law(self.region(theta), theta)


def _arcs(section: Mapping[str, Any]) -> list[PeerPiece]:
    """The pieces of a cam of three tangent circles: base, flanks and nose, and its top dwell.

    Neighbouring circles touch on the line through their centres; the angles at which they touch
    are the corners a, b, c on the way up and d, e, f on the way down. The follower's face touches
    a circle of radius b about a point at distance d from the axis at c = d cos x + sqrt(...).
    """
    flank_centre, flank_radius = section["flank_center"], section["flank_radius"]
    nose_centre, nose_radius = section["nose_center"], section["nose_radius"]
    cos_centres = (
        flank_centre * flank_centre + nose_centre * nose_centre - (flank_radius - nose_radius) ** 2
    ) / (2.0 * flank_centre * nose_centre)
    a_to_c = math.pi - math.acos(cos_centres)
    nose_x = nose_centre * math.cos(a_to_c)
    nose_y = nose_centre * math.sin(a_to_c)
    scale = flank_radius / (flank_radius - nose_radius)
    c = math.radians(180.0 - 0.5 * section["top_dwell_deg"])
    a = c - a_to_c
    b = a + math.atan2(scale * nose_y, scale * (nose_x + flank_centre) - flank_centre)
    d = TWO_PI - c
    e = TWO_PI - b
    f = TWO_PI - a
    base = flank_radius - flank_centre
    top = nose_centre + nose_radius
    offset = section["offset"]

    def dwell(radius: float, end: float) -> PeerPiece:
        return PeerPiece(a=0.0, b=radius, d=0.0, offset=offset, centre=0.0, end=end)

    def flank(centre: float, end: float) -> PeerPiece:
        return PeerPiece(
            a=-flank_centre, b=flank_radius, d=flank_centre, offset=offset, centre=centre, end=end
        )

    def nose(centre: float, end: float) -> PeerPiece:
        return PeerPiece(
            a=nose_centre, b=nose_radius, d=nose_centre, offset=offset, centre=centre, end=end
        )

    return [
        dwell(base, end=a),
        flank(centre=a, end=b),
        nose(centre=c, end=c),
        dwell(top, end=d),
        nose(centre=d, end=e),
        flank(centre=f, end=f),
        dwell(base, end=TWO_PI + a),
    ]


class BudgetError(Exception):
    """The budget of time or impacts is used up."""


class PeerImpact(NamedTuple):
    """An impact: the turn and the angle in it (rad), and the velocity relative to the cam (m/s)."""

    turn: int
    theta: float
    u: float


class PeerRest(NamedTuple):
    """The end of a complete chatter, from which the follower rests: turn and angle in it (rad)."""

    turn: int
    theta: float


@dataclass
class PeerTrace:
    """What a method found; final: position q (m) and velocity v (m/s) at the end of the run."""

    hits: list[PeerImpact] = field(default_factory=list)
    rests: list[PeerRest] = field(default_factory=list)
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
    """A follower on a cam at one speed, the budget of one run, and the trace that it leaves."""

    def __init__(
        self,
        follower: Follower,
        lift: Lift,
        *,
        omega: float,
        turns: float,
        chatter: float,
        seconds: float = math.inf,
        most_impacts: int = 10**9,
    ):
        """Prepare one run.

        omega: the cam's angular velocity (rad/s); turns: the length of the run; chatter: tolerance
        (turns) below which a chatter is closed by its map; seconds and most_impacts: the budget.
        Seconds are those of the processor, so that a busy machine changes nothing.
        """
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
        """Seconds until the gap closes at the present relative acceleration.

        It is inf where nothing pulls the gap shut, and where the follower leaves a rest.
        """
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
                return PeerState(turn, theta, y=0.0, u=0.0) if turn < self.turns else None
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
        """State after an impact with relative velocity u (m/s).

        The follower is thrown up; or, where what is left of a chatter is shorter than the
        tolerance, this is where the rest ends that the chatter leads to (None: it does not).
        """
        self.check()
        self.trace.hits.append(PeerImpact(turn, theta, u))
        a = self.pushed(self.lift.region(theta), theta)
        if a < 0.0 and self.r < 1.0:
            left = 2.0 * self.r * u / ((1.0 - self.r) * a)
            if left <= self.chatter_s:
                turn, theta = wrapped(turn, theta + self.omega * left)
                self.trace.rests.append(PeerRest(turn, theta))
                return self.rest(turn, theta)
        return PeerState(turn, theta, y=0.0, u=-self.r * u)


@dataclass(frozen=True)
class PeerFlight:
    """A flight over one region of the cam, in seconds from the angle theta (rad).

    fall: how long a ballistic flight would last, s; no step is longer.
    """

    machine: PeerMachine
    region: int
    theta: float
    fall: float

    def accel(self, t: float, y: float, u: float) -> float:
        """y'' in m/s2, at t seconds, for a gap y (m) and its rate u (m/s)."""
        m = self.machine
        return m.pushed(self.region, self.theta + m.omega * t) - m.k * y - m.b * u


class FlightState(NamedTuple):
    """A moment of a flight: seconds since it began, the gap y (m) and its rate u (m/s)."""

    t: float
    y: float
    u: float


class FlightEnd(NamedTuple):
    """Where an integration ended, and whether it ended with a contact."""

    t: float
    y: float
    u: float
    contact: bool


# A method integrates a flight from a state to a last t. With the last argument it looks for a
# contact, at which it stops, and the gap it begins with is then above zero.
Method = Callable[[PeerFlight, FlightState, float, bool], FlightEnd]


def follow(machine: PeerMachine, method: Method, q: float | None, v: float | None) -> PeerTrace:
    """Run the machine from position q (m) and velocity v (m/s) at theta = 0; None: at rest.

    Returns the machine's trace: impacts, rests and the last state, or that it was given up.
    """
    c, slope, _ = machine.lift.law(0, 0.0)
    if q is None or v is None:
        state = machine.rest(0, 0.0)
    else:
        state = PeerState(turn=0, theta=0.0, y=q - c, u=v - machine.omega * slope)
    try:
        machine.trace.final = _last_state(machine, method, state)
    except BudgetError:
        machine.trace.given_up = True
    return machine.trace


def _last_state(
    machine: PeerMachine, method: Method, state: PeerState | None
) -> tuple[float, float]:
    """Position (m) and velocity (m/s) at the end of the run; state: None for a rest to the end."""
    while state is not None:
        landing = next_landing(machine, method, state)
        if not landing.contact:
            c, slope, _ = machine.lift.at(landing.state.theta)
            return c + landing.state.y, machine.omega * slope + landing.state.u
        turn, theta, _, u = landing.state
        state = machine.rebound(turn, theta, u)
    c, slope, _ = machine.lift.law(0, 0.0)  # runs have whole turns: they end where a turn begins
    return c, machine.omega * slope


class Landing(NamedTuple):
    """Where flights ended: the state there, and whether it is a contact or the end of the run."""

    contact: bool
    state: PeerState


def next_landing(machine: PeerMachine, method: Method, at: PeerState) -> Landing:
    """Fly from a state, region after region of the cam, to the next contact or the run's end."""
    while at.theta < machine.end(at.turn):
        machine.check()
        landing = _over_region(machine, method, at)
        if landing.contact:
            return landing
        at = landing.state
    return Landing(contact=False, state=at)


def _over_region(machine: PeerMachine, method: Method, at: PeerState) -> Landing:
    """Fly to a contact, or to the end of the region of the cam that the flight begins over.

    High above the cam, where there can be no contact, the gap is counted from a level instead, so
    that no region of the cam cuts the flight; it ends where it comes down to that level.
    """
    lift = machine.lift
    omega = machine.omega
    turn, theta, y, u = at
    fall = machine.fall_time(at)
    c, slope, _ = lift.at(theta)
    is_above = c + y > lift.top + 2.0 * CLEAR
    region = lift.sky if is_above else lift.region(theta)
    stop = min(lift.regions[region].end, theta + TWO_PI, machine.end(turn))
    if is_above:
        y = y + c - lift.top - CLEAR
        u = u + omega * slope
    flight = PeerFlight(machine, region, theta, fall)
    span = (stop - theta) / omega
    t = 0.0
    hit = False
    if y <= 0.0:
        step = SHORT * machine.period if fall == math.inf else PART * fall
        t, y, u, _ = method(flight, FlightState(t, y, u), min(step, span), False)
    if t < span:
        t, y, u, hit = method(flight, FlightState(t, y, u), span, True)
    theta = theta + omega * t if hit else stop
    y = 0.0 if hit else max(y, 0.0)
    if is_above:
        c, slope, _ = lift.at(theta)
        y = y + lift.top + CLEAR - c
        u = u - omega * slope
    return Landing(contact=hit and not is_above, state=PeerState(*wrapped(turn, theta), y, u))


def wrapped(turn: int, theta: float) -> tuple[int, float]:
    """(turn, theta) of the same angle with theta in [0, 2 pi)."""
    whole = math.floor(theta / TWO_PI)
    return turn + whole, theta - whole * TWO_PI


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """The zero between two numbers with values of different signs, to the last bits."""
    from scipy.optimize import brentq

    # rtol: four ulp of 2^-52, the least that brentq takes
    return brentq(function, low, high, xtol=1e-300, rtol=2.0**-50)


def runge_kutta_4(steps: int) -> Method:
    """The classical method of order four: so many fixed steps per turn, contacts inside a step."""

    def step(flight: PeerFlight, t: float, y: float, u: float, h: float) -> tuple[float, float]:
        """(y, u) one step of h seconds later."""
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

    def height_after(flight: PeerFlight, t: float, y: float, u: float, h: float) -> float:
        """The gap one step of h seconds later."""
        y_after, _ = step(flight, t, y, u, h)
        return y_after

    def integrate(
        flight: PeerFlight, begin: FlightState, until: float, contacts: bool
    ) -> FlightEnd:
        """Step on; a step that ends below zero is cut where the gap closes (a `Method`)."""
        t, y, u = begin
        h = min(flight.machine.period / steps, flight.fall / PER_HOP)
        while t < until:
            flight.machine.check()
            left = until - t
            size = left if left < (1.0 + 1e-9) * h else h  # no step of rounding errors at the end
            y_after, u_after = step(flight, t, y, u, size)
            if contacts and y_after < 0.0:
                size = root(partial(height_after, flight, t, y, u), 0.0, size)
                y_after, u_after = step(flight, t, y, u, size)
                return FlightEnd(t + size, y_after, u_after, contact=True)
            t = until if size == left else t + size
            y = y_after
            u = u_after
        return FlightEnd(t, y, u, contact=False)

    return integrate


def solve_ivp(name: str, tolerance: float, max_turn: float = math.inf) -> Method:
    """scipy's solve_ivp with rtol = atol, contact events and steps of at most max_turn turns."""
    import scipy.integrate

    method = "Radau" if name == "radau" else name.upper()

    def contact(t, state):
        """Event: the gap falls through zero."""
        return state[0]

    def dip(t, state):
        """Event: the gap has a minimum."""
        return state[1]

    contact.terminal = True  # type: ignore[attr-defined]
    contact.direction = -1  # type: ignore[attr-defined]
    dip.direction = 1  # type: ignore[attr-defined]

    def integrate(
        flight: PeerFlight, begin: FlightState, until: float, contacts: bool
    ) -> FlightEnd:
        """Integrate once, and again up to a minimum below zero that a step has passed (a `Method`).

        Raises ArithmeticError where scipy gives up.
        """
        machine = flight.machine
        calls = 0

        def derivative(t, state):
            nonlocal calls
            calls += 1
            if not calls % CHECKED:
                machine.check()
            return state[1], flight.accel(t, state[0], state[1])

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = scipy.integrate.solve_ivp(
                derivative,
                (begin.t, until),
                (begin.y, begin.u),
                method,
                events=[contact, dip] if contacts else None,
                max_step=min(max_turn * machine.period, flight.fall),
                rtol=tolerance,
                atol=tolerance,
            )
        machine.trace.evaluations += solution.nfev
        if solution.status < 0:
            raise ArithmeticError(solution.message)
        if contacts:  # a step that passed through the cam: look again, up to its lowest point
            for t, (y, _) in zip(solution.t_events[1], solution.y_events[1], strict=True):
                if y < 0.0 and t < until:
                    return integrate(flight, begin, t, True)
        y, u = solution.y[:, -1]
        stopped_at_contact = solution.status == 1
        return FlightEnd(float(solution.t[-1]), float(y), float(u), stopped_at_contact)

    return integrate


def heyoka_taylor(tolerance: float) -> Method:
    """heyoka's Taylor series with a terminal event."""

    def integrate(
        flight: PeerFlight, begin: FlightState, until: float, contacts: bool
    ) -> FlightEnd:
        """Propagate to the contact or to the last t (a `Method`)."""
        machine = flight.machine
        taylor, state, pars = _taylor_integrator(tolerance, contacts)
        a, b, d, offset, centre, _ = machine.lift.regions[flight.region]
        values = (machine.k, machine.b, machine.load, machine.omega, flight.theta - centre)
        pars[:] = (*values, a, b, d, offset)
        taylor.time = begin.t
        state[:] = (begin.y, begin.u)
        if contacts:
            taylor.reset_cooldowns()
        outcome, _, _, steps, *_ = taylor.propagate_until(until)
        machine.trace.evaluations += int(steps)
        hit = int(outcome) == -1  # stopped by its first terminal event
        t = taylor.time if hit else until
        return FlightEnd(t, float(state[0]), float(state[1]), contact=hit)

    return integrate


@cache
def _taylor_integrator(tolerance: float, contacts: bool) -> tuple[Any, ...]:
    """heyoka's integrator with views of its state and parameters; each is compiled once.

    The equation is that of the module, y'' = a(theta) - (k y + b y')/m, on a piece of the cam whose
    constants are parameters: k/m, b/m, load, omega, the angle from the piece's centre at which the
    flight begins, and a, b, d, offset of `PeerPiece`.
    """
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
