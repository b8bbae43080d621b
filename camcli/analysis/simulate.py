"""One orbit in time: exact events, and a trajectory sampled from the closed-form flow."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from math import degrees, inf
from typing import NamedTuple

from camcli.analysis.classify import ClassifiedMotion, classify_at
from camcli.analysis.integrate import Cost, Orbit, Record, Settings, with_turns
from camcli.analysis.labels import APERIODIC, period_of
from camcli.analysis.orbits.identify import TOO_LARGE, named
from camcli.analysis.patience import cost_beyond, forgets_too_much, named_on
from camcli.errors import Status
from camcli.interrupts import raise_if_interrupted
from camcli.kernel import backend
from camcli.kernel.arithmetic import natural_log
from camcli.kernel.cam_table import TURN, Cam, lift, restitution_at, stretch_at
from camcli.kernel.flow import Constants, move
from camcli.kernel.forms import rows_of
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT, EventKind
from camcli.kernel.sticking import contact_accel
from camcli.kernel.variational import Growth, Pair
from camcli.system import System

FLIGHT, STICKING = "flight", "sticking"
EVENTS_AT_ONCE = 500  # that `one_of_many_from` gives to the kernel: it ends soon in chaos
LOG_TOO_LARGE = natural_log(TOO_LARGE)


class Happening(NamedTuple):
    """An event of a motion, a row of events.csv."""

    seconds: float  # since the first strobe
    turn: int
    phase: float  # deg
    kind: str  # as `EventKind.text` says it
    q: float  # lift, m
    u_before: float  # rate relative to the cam, m/s
    u_after: float


@dataclass(frozen=True)
class Simulation:
    """Rows as in the artefacts: s, deg, m, m/s. The rows of `trajectory` are tuples.

    trajectory: t_s, theta_deg, q_m, v_m_per_s, c_m, c_dot_m_per_s, contact
    """

    rpm: float
    trajectory: list[tuple]
    events: list[Happening]
    label: str
    status: int
    periods: int
    corners: list[float]
    cost: Cost
    one_of_many: int | None  # turn of the record, see `one_of_many_from`
    ends: ClassifiedMotion | None = None  # where the record alone looks aperiodic: what it leads to

    @property
    def repeats(self) -> int:
        """Turns after which the record repeats; 0 where it does not, or not yet."""
        return period_of(self.label) if self.ends is None else 0

    @property
    def last_period(self) -> list[Happening]:
        """The events of the last turns that repeat; all events where the record does not."""
        first = self.periods - self.repeats if self.repeats else 0
        return [event for event in self.events if event.turn >= first]


class Chatter(NamedTuple):
    """Hops that follow unlogged, until the chatter's end."""

    u: float  # rate of the gap after the impact that begins them, m/rad
    length: float  # from there to the end, rad
    r: float  # restitution


@dataclass(frozen=True)
class _Node:
    """Where a segment begins: s rad after the strobe, with q in m and w = dq/dtheta in m/rad.

    sticking: whether the follower rests on the cam from there on. chatter: the hops that follow,
    None where a flight or a rest does.
    """

    s: float
    q: float
    w: float
    sticking: bool
    chatter: Chatter | None = None


def simulate(
    system: System, rpm: float, settings: Settings, samples: int, follow: bool = True
) -> Simulation:
    """Run one orbit; `samples` per turn in the trajectory, besides the events (0: none).

    follow: find out what a record that looks aperiodic leads to, and what a short one shows.
    """
    orbit = Orbit(system, rpm, settings)
    backend.for_work(0)
    q, w = orbit.position()
    sampler_start = _Start(orbit.state.theta, q, w)
    record = orbit.run()
    sampler = _Sampler(system, orbit, record, samples)
    ends = None
    cost = record.cost
    if follow:
        label, ends, further = _named(system, rpm, settings, orbit, record)
        cost = cost + further
    else:
        label, _ = named(system, rpm, record)
    one_of_many, computed = one_of_many_from(
        system, rpm, settings, record, label if ends is None else APERIODIC
    )
    return Simulation(
        rpm=rpm,
        trajectory=list(sampler.rows(sampler_start)) if samples else [],
        events=list(_events(record, orbit, sampler.strobe)),
        label=label,
        status=record.status,
        periods=record.periods,
        corners=system.corners,
        cost=cost + computed,
        one_of_many=one_of_many,
        ends=ends,
    )


class _Start(NamedTuple):
    """The state in which an orbit starts: phase in rad, q in m, w = dq/dtheta in m/rad."""

    theta: float
    q: float
    w: float


def _named(
    system: System, rpm: float, settings: Settings, orbit: Orbit, record: Record
) -> tuple[str, ClassifiedMotion | None, Cost]:
    """(the label, what `classify` finds, what it cost to find them).

    None where the record alone tells: it does not where it looks aperiodic, nor where rounding
    decides what follows a rest.
    """
    label, _, last_record = named_on(orbit, rpm, record)
    cost = cost_beyond(record, last_record)
    if label != APERIODIC and not forgets_too_much(last_record):
        return label, None, cost
    ends = classify_at(system, rpm, settings)
    return ends.label, ends, cost + ends.cost


def one_of_many_from(
    system: System, rpm: float, settings: Settings, record: Record, label: str
) -> tuple[int | None, Cost]:
    """(the turn in which an error of rounding has grown TOO_LARGE, what it cost to know).

    The turn is negative in the transient. From there on the record is one of many motions that
    rounding allows. Saltation matrices carry a difference from impact to impact
    (`kernel.variational`), a rest ends it. None where that does not happen, and for a record on an
    orbit without rests: it attracts.
    """
    if period_of(label) and not any(record.chatter):
        return None, Cost()
    turns = settings.transient + record.periods
    whole = Orbit(system, rpm, with_turns(settings, 0, turns)).run(strobes=False)
    const = system.constants(rpm, 1.0, 1)
    kernel = backend.current()
    cam = system.cam_for(kernel)
    pairs = kernel.table(Pair, [Pair()])
    kinds = kernel.numbers(whole.kind, int)
    periods = kernel.numbers(whole.period, int)
    thetas = kernel.numbers(whole.theta)
    rates = kernel.numbers(whole.u)
    grown = 0.0  # logarithm of what a difference was multiplied by since the last rest
    for first in range(0, len(whole.kind), EVENTS_AT_ONCE):
        raise_if_interrupted()
        some = slice(first, first + EVENTS_AT_ONCE)
        growths = kernel.copies(Growth, Growth(), len(kinds[some]))  # one of each event
        kernel.stretch_events(
            cam, const, kinds[some], periods[some], thetas[some], rates[some], pairs, growths
        )
        for k, growth in enumerate(rows_of(Growth, growths), first):
            if whole.kind[k] == CHATTER:
                grown = 0.0
            else:
                grown += growth.first_log if growth.first != 0.0 else -inf
            if grown > LOG_TOO_LARGE:
                return int(whole.period[k]) - settings.transient, whole.cost
    return None, whole.cost


def _events(record: Record, orbit: Orbit, strobe: float) -> Iterator[Happening]:
    """The events of a record.

    strobe: the phase (rad) at which a turn is counted to begin.
    """
    omega = orbit.omega
    for kind, period, theta, q, u in record.events():
        u_after = 0.0
        if kind == IMPACT and u != 0.0:
            u_after = -restitution(orbit.system.cam, orbit.const, theta) * u
        if kind == DETACHMENT:
            u_after = thrown_off(orbit.system.cam, theta)
        yield Happening(
            seconds=(TURN * period + _since(theta, strobe)) / omega,
            turn=period,
            phase=degrees(theta),
            kind=EventKind(kind).text,
            q=q,
            u_before=u * omega,
            u_after=u_after * omega,
        )


def restitution(cam: Cam, const: Constants, theta: float) -> float:
    """The coefficient of restitution of an impact at a phase (rad)."""
    return restitution_at(cam, const, stretch_at(cam, theta))


def thrown_off(cam: Cam, theta: float) -> float:
    """Rate of the gap just after a detachment, m/rad: at a downward kink the jump of the slope."""
    stretch = cam.stretches[stretch_at(cam, theta)]
    # of two equal numbers max takes the first one: 0, not the -0 of a slope without a jump
    return max(0.0, -stretch.slope_jump) if theta == stretch.start else 0.0


def _since(theta: float, strobe: float) -> float:
    """Phase after the strobe, rad in [0, 2 pi)."""
    s = theta - strobe
    return s if s >= 0.0 else s + TURN


def _hopping(chatter: Chatter, s: float) -> tuple[float, float]:
    """(gap, gap_rate) at s rad in a chatter closed by the map: hops that shrink by r, m and m/rad.

    The first begins with u and lasts (1 - r) length, so hop n has u r^n and (1 - r) length r^n, and
    begins where r^n of the length is left; at the share y of a hop the gap is u p y (1 - y), p its
    duration. Exact up to what the chatter map neglects.
    """
    u, length, r = chatter
    left = 1.0 - s / length
    if left <= 0.0:
        return 0.0, 0.0
    shrink = 1.0  # r^n of the hop at s
    while shrink * r > left:
        shrink *= r
    y = (shrink - left) / ((1.0 - r) * shrink)
    u *= shrink
    gap = u * (1.0 - r) * length * shrink * y * (1.0 - y)
    return gap, u * (1.0 - 2.0 * y)


class _Sampler:
    """Samples a record period by period; cam values at the fixed phases are computed once.

    grid: phases after the strobe at which every turn has a row, rad; lifts: (theta, c, c_theta) at
    each; by_period: the events of each turn, as of `Record.events`.
    """

    def __init__(self, system: System, orbit: Orbit, record: Record, samples: int):
        self.cam = system.cam
        self.const = orbit.const
        self.record = record
        self.omega = orbit.omega
        self.strobe = system.strobe
        self.grid = [(j / samples) * TURN for j in range(samples)]
        self.lifts = [self._lift(s) for s in self.grid]
        self.by_period: dict[int, list] = {}
        for event in record.events():
            _, period, *_ = event
            self.by_period.setdefault(period, []).append(event)

    def _lift(self, s: float) -> tuple[float, float, float]:
        """(theta, c, c_theta) at the phase s after the strobe."""
        theta = self.strobe + s
        theta = theta - TURN if theta >= TURN else theta
        c, c1, _ = lift(self.cam, stretch_at(self.cam, theta), theta)
        return theta, c, c1

    def rows(self, start: _Start) -> Iterator[tuple]:
        """All rows of the record, turn by turn, from the state in which the orbit starts.

        Turn -1 is the part of a turn before the first strobe. Where the last turn is not whole its
        rows go up to its last event, unless the run just ended there.
        """
        node = _Node(_since(start.theta, self.strobe), start.q, start.w, False)
        if -1 in self.by_period:
            node = self._rested(node)
            yield from self._period(-1, node, TURN)
        is_sticking = None  # whether the turn before ends so; None: there is none
        strobes = zip(self.record.strobe_q.tolist(), self.record.strobe_w.tolist(), strict=True)
        for p, (q, w) in enumerate(strobes):
            is_whole = p < self.record.periods
            events = self.by_period.get(p, [])
            if not is_whole and (self.record.status == Status.OK or not events):
                break
            node = _Node(0.0, q, w, bool(is_sticking))
            if is_sticking is None:
                node = self._rested(node)
            stop = TURN
            if not is_whole:
                _, _, last_theta, _, _ = events[-1]
                stop = _since(last_theta, self.strobe)
            is_sticking = yield from self._period(p, node, stop)

    def _period(self, p: int, node: _Node, stop: float) -> Generator[tuple, None, bool]:
        """Yield the rows of one turn from `node` to `stop`; return whether it ends sticking.

        p: number of the turn. node: the state that the motion goes on from, at node.s rad after the
        strobe. stop: rad after the strobe. The rows are those of the grid, and at each event one
        before it, for an impact, and one after it.
        """
        raise_if_interrupted()
        j = 0  # the next row of the grid
        while j < len(self.grid) and self.grid[j] < node.s:
            j += 1
        events = self.by_period.get(p, [])
        for n, event in enumerate(events):
            kind, _, theta, q, u = event
            s = _since(theta, self.strobe)
            while j < len(self.grid) and self.grid[j] < s:
                yield self._sample(p, node, j)
                j += 1
            following = events[n + 1] if n + 1 < len(events) else None
            node = self._after(event, following)
            _, _, c1 = self._lift(s)
            at = (TURN * p + s) / self.omega, degrees(theta), q
            cam_now = q, c1 * self.omega
            if kind == IMPACT:
                yield (*at, (c1 + u) * self.omega, *cam_now, FLIGHT)
            yield (*at, node.w * self.omega, *cam_now, STICKING if node.sticking else FLIGHT)
        while j < len(self.grid) and self.grid[j] < stop:
            yield self._sample(p, node, j)
            j += 1
        return node.sticking

    def _after(self, event: tuple, following: tuple | None) -> _Node:
        """The node that an event begins; both events as of `Record.events`.

        The kernel records a complete chatter as its last impact and the CHATTER at which it ends:
        the hops between these are made up from the chatter map (`_hopping`).
        """
        kind, _, theta, q, u = event
        s = _since(theta, self.strobe)
        _, _, c1 = self._lift(s)
        if kind == CHATTER:
            return _Node(s, q, c1, sticking=True)
        if kind == DETACHMENT:
            return _Node(s, q, c1 + thrown_off(self.cam, theta), sticking=False)
        r = restitution(self.cam, self.const, theta)
        node = _Node(s, q, c1 - r * u, sticking=False)
        if following is not None and following[0] == CHATTER:
            _, _, end, _, _ = following
            return replace(node, chatter=Chatter(-r * u, _since(end, self.strobe) - s, r))
        return self._rested(node) if r * u == 0.0 else node

    def _sample(self, p: int, node: _Node, j: int) -> tuple:
        """A row of trajectory.csv: point j of the grid in period p.

        node: where the present motion (a flight, a chatter or a rest) begins.
        """
        theta, c, c1 = self.lifts[j]
        s = self.grid[j] - node.s
        q = c
        w = c1
        if node.chatter is not None:
            gap, rate = _hopping(node.chatter, s)
            q = c + gap
            w = c1 + rate
        elif not node.sticking:
            q, w = move(self.const, node.q, node.w, s)
        return (
            (TURN * p + self.grid[j]) / self.omega,
            degrees(theta),
            q,
            w * self.omega,
            c,
            c1 * self.omega,
            STICKING if node.sticking else FLIGHT,
        )

    def _rested(self, node: _Node) -> _Node:
        """The node with its contact decided: it rests on the cam where it has the cam's position
        and velocity, and is pressed to it.
        """
        theta, c, c1 = self._lift(node.s)
        accel, _, _ = contact_accel(self.cam, self.const, stretch_at(self.cam, theta), theta)
        rests = node.q == c and node.w == c1 and accel < 0.0
        return _Node(node.s, node.q, node.w, rests)
