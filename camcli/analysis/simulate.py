"""One orbit in time: exact events, and a trajectory sampled from the closed-form flow."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace
from math import degrees
from typing import NamedTuple

from camcli.analysis.classify import ClassifiedMotion, classify_at
from camcli.analysis.integrate import Cost, Orbit, Record, Settings, with_turns
from camcli.analysis.labels import APERIODIC, period_of
from camcli.analysis.orbits.identify import TOO_LARGE, named
from camcli.analysis.patience import forgets_too_much, named_on
from camcli.errors import Status
from camcli.interrupts import raise_if_interrupted
from camcli.kernel import backend
from camcli.kernel.arithmetic import natural_log
from camcli.kernel.cam_table import TURN, Cam, lift, restitution_at, stretch_at
from camcli.kernel.flow import Constants, move
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT, EventKind
from camcli.kernel.sticking import contact_accel
from camcli.kernel.variational import Growth, Pair
from camcli.system import System

FLIGHT, STICKING = "flight", "sticking"


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


@dataclass(frozen=True)
class _Node:
    """Where a segment begins: phase after the strobe (rad), state (m, m/rad) and contact."""

    s: float
    q: float
    w: float
    sticking: bool
    # (u m/rad, length rad, restitution) of hops that follow unlogged
    chatter: tuple[float, float, float] | None = None


def simulate(
    system: System, rpm: float, settings: Settings, samples: int, follow: bool = True
) -> Simulation:
    """Run one orbit; `samples` per turn in the trajectory, besides the events (0: none).

    follow: find out what a record that looks aperiodic leads to, and what a short one shows.
    """
    orbit = Orbit(system, rpm, settings)
    backend.for_work(0)
    first = orbit.position(), orbit.state.theta
    record = orbit.run()
    sampler = _Sampler(system, orbit, record, samples)
    if follow:
        name, ends = _named(system, rpm, settings, orbit, record)
    else:
        (name, _), ends = named(system, rpm, record), None
    return Simulation(
        rpm=rpm,
        trajectory=list(sampler.rows(first)) if samples else [],
        events=list(_events(record, orbit, sampler.strobe)),
        label=name,
        status=record.status,
        periods=record.periods,
        corners=system.corners,
        cost=record.cost,
        one_of_many=one_of_many_from(
            system, rpm, settings, record, name if ends is None else APERIODIC
        ),
        ends=ends,
    )


def _named(
    system: System, rpm: float, settings: Settings, orbit: Orbit, record: Record
) -> tuple[str, ClassifiedMotion | None]:
    """The label, and what `classify` finds where the record alone cannot tell.

    It cannot where it looks aperiodic, nor where rounding decides what follows a rest.
    """
    name, _, told = named_on(orbit, rpm, record)
    if name != APERIODIC and not forgets_too_much(told):
        return name, None
    ends = classify_at(system, rpm, settings)
    return ends.label, ends


def one_of_many_from(
    system: System, rpm: float, settings: Settings, record: Record, name: str
) -> int | None:
    """The turn in which an error of rounding has grown TOO_LARGE, negative in the transient.

    From there on the record is one of many motions that rounding allows. Saltation matrices carry
    a difference from impact to impact (`kernel.variational`), a rest ends it. None where that does
    not happen, and for a record on an orbit without rests: it attracts.
    """
    if period_of(name) and not any(record.chatter):
        return None
    turns = settings.transient + record.periods
    whole = Orbit(system, rpm, with_turns(settings, 0, turns)).run(strobes=False)
    const = system.constants(rpm, 1.0, 1)
    kernel = backend.current()
    cam = system.cam_for(kernel)
    pairs = kernel.table(Pair, [Pair()])
    growths = kernel.table(Growth, [Growth()])
    columns = [kernel.numbers(x, int) for x in (whole.kind, whole.period)]
    columns += [kernel.numbers(x) for x in (whole.theta, whole.u)]
    for k, kind in enumerate(whole.kind):
        raise_if_interrupted()
        if kind == CHATTER:
            growths = kernel.table(Growth, [Growth()])
        kernel.stretch_events(cam, const, *(x[k : k + 1] for x in columns), pairs, growths)
        if growths[0].first_log > natural_log(TOO_LARGE):
            return int(whole.period[k]) - settings.transient
    return None


def _events(record: Record, orbit: Orbit, strobe: float) -> Iterator[Happening]:
    """The events of a record.

    strobe: the phase (rad) at which a turn is counted to begin.
    """
    omega = orbit.omega
    for kind, period, theta, q, u in record.events():
        after = 0.0
        if kind == IMPACT and u != 0.0:
            after = -restitution(orbit.system.cam, orbit.const, theta) * u
        if kind == DETACHMENT:
            after = thrown_off(orbit.system.cam, theta)
        yield Happening(
            (TURN * period + _since(theta, strobe)) / omega,
            period,
            degrees(theta),
            EventKind(kind).text,
            q,
            u * omega,
            after * omega,
        )


def restitution(cam: Cam, const: Constants, theta: float) -> float:
    """The coefficient of restitution of an impact at a phase (rad)."""
    return restitution_at(cam, const, stretch_at(cam, theta))


def thrown_off(cam: Cam, theta: float) -> float:
    """Rate of the gap just after a detachment, m/rad: at a downward kink the jump of the slope."""
    stretch = cam.stretches[stretch_at(cam, theta)]
    return max(-stretch.slope_jump, 0.0) if theta == stretch.start else 0.0


def _since(theta: float, strobe: float) -> float:
    """Phase after the strobe, rad in [0, 2 pi)."""
    s = theta - strobe
    return s if s >= 0.0 else s + TURN


def _hopping(u: float, length: float, r: float, s: float) -> tuple[float, float]:
    """(gap, gap_rate) at s in a chatter closed by the map: hops that shrink by r, m and m/rad.

    The first begins with u and lasts (1 - r) length, so hop n has u r^n and (1 - r) length r^n; at
    the share y of a hop the gap is u p y (1 - y). Exact up to what the chatter map neglects.
    """
    left = 1.0 - s / length
    if left <= 0.0:
        return 0.0, 0.0
    shrink = 1.0
    while shrink * r > left:
        shrink *= r
    y = (shrink - left) / ((1.0 - r) * shrink)
    u *= shrink
    return u * (1.0 - r) * length * shrink * y * (1.0 - y), u * (1.0 - 2.0 * y)


class _Sampler:
    """Samples a record period by period; cam values at the fixed phases are computed once."""

    def __init__(self, system: System, orbit: Orbit, record: Record, samples: int):
        self.cam = system.cam
        self.const = orbit.const
        self.record = record
        self.omega = orbit.omega
        self.strobe = system.strobe
        self.grid = [(j / samples) * TURN for j in range(samples)]
        self.lifts = [self._lift(s) for s in self.grid]
        self.by_period: dict[int, list] = {}
        for row in record.events():
            self.by_period.setdefault(row[1], []).append(row)

    def _lift(self, s: float) -> tuple[float, float, float]:
        """(theta, c, c_theta) at the phase s after the strobe."""
        theta = self.strobe + s
        theta = theta - TURN if theta >= TURN else theta
        c, c1, _ = lift(self.cam, stretch_at(self.cam, theta), theta)
        return theta, c, c1

    def rows(self, first) -> Iterator[tuple]:
        """All rows of the record; `first` is ((q, w), theta) of the very start."""
        (q, w), theta = first
        node = _Node(_since(theta, self.strobe), q, w, False)
        if -1 in self.by_period:
            node = self._rested(node)
            yield from self._period(-1, node, TURN)
        sticking = None
        strobes = zip(self.record.strobe_q.tolist(), self.record.strobe_w.tolist(), strict=True)
        for p, (q, w) in enumerate(strobes):
            whole = p < self.record.periods
            events = self.by_period.get(p, [])
            if not whole and (self.record.status == Status.OK or not events):
                break
            node = _Node(0.0, q, w, bool(sticking))
            node = self._rested(node) if sticking is None else node
            stop = TURN if whole else _since(events[-1][2], self.strobe)
            sticking = yield from self._period(p, node, stop)

    def _period(self, p: int, node: _Node, stop: float) -> Generator[tuple, None, bool]:
        """Yield the rows of one turn from `node` to `stop`; return whether it ends sticking.

        p: number of the turn. node: the state that the motion goes on from, at node.s rad after the
        strobe. stop: rad after the strobe. The rows are those of the grid, and at each event one
        before it, for an impact, and one after it. The kernel records a complete chatter as its
        last impact and the CHATTER at which it ends: the hops between these are made up from the
        chatter map (`_hopping`).
        """
        raise_if_interrupted()
        j = 0
        while j < len(self.grid) and self.grid[j] < node.s:
            j += 1
        events = self.by_period.get(p, [])
        for n, (kind, _, theta, q, u) in enumerate(events):
            s = _since(theta, self.strobe)
            while j < len(self.grid) and self.grid[j] < s:
                yield self._sample(p, node, j)
                j += 1
            _, _, c1 = self._lift(s)
            at = (TURN * p + s) / self.omega, degrees(theta), q
            cam_now = q, c1 * self.omega
            if kind == IMPACT:
                yield (*at, (c1 + u) * self.omega, *cam_now, FLIGHT)
            r = restitution(self.cam, self.const, theta)
            w = c1 - r * u if kind == IMPACT else c1
            if kind == DETACHMENT:
                w += thrown_off(self.cam, theta)
            node = _Node(s, q, w, kind == CHATTER)
            if kind == IMPACT and n + 1 < len(events) and events[n + 1][0] == CHATTER:
                length = _since(events[n + 1][2], self.strobe) - s
                node = replace(node, chatter=(-r * u, length, r))
            elif kind == IMPACT and r * u == 0.0:
                node = self._rested(node)
            yield (*at, w * self.omega, *cam_now, STICKING if node.sticking else FLIGHT)
        while j < len(self.grid) and self.grid[j] < stop:
            yield self._sample(p, node, j)
            j += 1
        return node.sticking

    def _sample(self, p: int, node: _Node, j: int) -> tuple:
        """A row of trajectory.csv: point j of the grid in period p.

        node: where the present motion (a flight, a chatter or a rest) begins; s is the phase since
        the strobe, q the follower's position and w its velocity in m/rad.
        """
        theta, c, c1 = self.lifts[j]
        q, w = c, c1
        if node.chatter is not None:
            gap, rate = _hopping(*node.chatter, self.grid[j] - node.s)
            q, w = c + gap, c1 + rate
        elif not node.sticking:
            q, w = move(self.const, node.q, node.w, self.grid[j] - node.s)
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
        """The node with its contact decided: on the cam, at its velocity and pressed to it."""
        theta, c, c1 = self._lift(node.s)
        pressed = contact_accel(self.cam, self.const, stretch_at(self.cam, theta), theta)[0] < 0.0
        return _Node(node.s, node.q, node.w, node.q == c and node.w == c1 and pressed)
