"""Random flights: contacts missed or invented, by ours and by solve_ivp, against brute force.

A flight counts where brute force can decide it: it has a contact within TURNS that no graze closer
than rounding precedes. Flights come in blocks of BLOCK, each with random numbers of its own, so
that a flight is the same however many are asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from math import pi
from time import perf_counter, process_time

import numpy as np

from camcli.analysis.bench import dense
from camcli.analysis.bench.clock import Clock
from camcli.analysis.bench.kept import one_by_one
from camcli.analysis.bench.machine import Bench, events, reference
from camcli.analysis.bench.peers import solve_ivp
from camcli.analysis.bench.peers.lifts import TWO_PI, Lift, lift_of
from camcli.analysis.bench.peers.world import BudgetError, World
from camcli.analysis.integrate import Orbit, Settings, Start, compile_for
from camcli.kernel import backend
from camcli.parallel import Codec, Work
from camcli.system import Follower, System

TURNS = 2.5
EDGE = 1e-6  # rad: a contact this close to the end is not asked of anybody
BLOCK = 1000  # flights
BLOCKS_OF_PEERS = 2  # blocks that solve_ivp is asked to fly too
MOST_OF_PEERS = BLOCKS_OF_PEERS * BLOCK
APART = 1e-3  # rad: a peer's contact further off is another one
TOLERANCE = 1e-9  # of the peers, rtol = atol
MAX_TURN = 1.0 / 16.0  # largest step of the careful one
SLOWEST = 5.0  # s, for one flight of a peer
COMPILE_FROM = 500  # flights
OURS, PLAIN = "core", "rk45 with a contact event"
CAREFUL = "dop853 careful; max_step 1/16 turn"


@dataclass(frozen=True)
class Random:
    """A flight: machine, speed, start phase, gap (m) and relative velocity (m/rad) there."""

    system: System
    rpm: float
    theta_deg: float
    gap: float
    u: float
    contact: bool


@dataclass(frozen=True)
class Block:
    """Flights to fly: the first `count` of block `number`; whether they are worth compiling for."""

    number: int
    count: int
    compiled: bool = False


@dataclass
class Flights:
    """What a method made of the flights: asked for in all, flown by it, and decided."""

    method: str
    asked: int = 0
    flights: int = 0
    compared: int = 0
    missed: int = 0
    invented: int = 0
    seconds: float = 0.0


def random_flight(rng: np.random.Generator, cam) -> Random:
    """Any damping and frequency, a fifth of the starts on a corner, three tenths on the cam."""
    rpm, W = 10 ** rng.uniform(1.5, 4), 10 ** rng.uniform(-2, 1.3)
    omega = rpm * pi / 30
    Z = rng.choice([0, W, W * (1 + 1e-15), 1.0, 10.0]) * 10 ** (rng.uniform(-3, 0))
    gravity = rng.choice([0, 1]) * 10 ** rng.uniform(-2, 2)
    system = System(Follower(1.0, (W * omega) ** 2, 2 * Z * omega, gravity, 0.0, 0.5), cam)
    corners = [0.0, *system.corners_deg]
    theta = rng.choice(corners) if rng.random() < 0.2 else rng.uniform(0, 360)
    contact = bool(rng.random() < 0.3)
    gap = 0.0 if contact else 10 ** rng.uniform(-6, 0.3)
    u = 10 ** rng.uniform(-4, 1) * (1 if contact else rng.choice([-1, 1]))
    return Random(system, float(rpm), float(theta), float(gap), float(u), contact)


def ours(lift: Lift, f: Random) -> tuple[float | None, dense.Flight]:
    """Phase of our first impact from the start, None if there is none; and the flight."""
    theta, omega = f.theta_deg * (pi / 180), f.rpm * (pi / 30)
    c, c1 = (float(x[0]) for x in dense.lift_at(lift, np.array([theta])))
    start = Start(None if f.contact else c + f.gap, (c1 + f.u) * omega, f.theta_deg)
    orbit = Orbit(f.system, f.rpm, Settings(0, 3, 1e-16, 1, start))
    q, w = orbit.position()
    rows = events(orbit.run(), 0 if theta == 0 else 1)
    phases = [row[2] + 2 * pi * row[1] - theta for row in rows if row[0] == "impact"]
    lane = f.system.lane(f.rpm, 1e-9, 1)
    return (phases[0] if phases else None), dense.Flight(lane.W, lane.Z, lane.G, theta, q, w)


def verdict(
    lift: Lift, f: Random, found: float | None, flight: dense.Flight
) -> tuple[str, float | None]:
    """(right, missed, invented or undecided) of a contact, and the one by brute force."""
    expected, doubtful = dense.first_contact(lift, flight, TURNS, f.contact)
    far = TURNS * TWO_PI - EDGE
    if doubtful or (found is not None and found > far) or (expected or 0.0) > far - 10.0 * EDGE:
        return "undecided", None
    if found is None or expected is None:
        if found is None and expected is None:
            return "undecided", None
        return ("missed" if found is None else "invented"), expected
    _, slope = dense.flow(flight, expected)
    u = abs(slope - dense.lift_at(lift, np.array([flight.theta + expected]))[1][0])
    size = abs(flight.q) + abs(flight.w) + flight.G * expected**2 + flight.G / flight.W**2
    room = 1e-12 * size / max(u, 1e-7) + 2e-12
    if abs(found - expected) <= room:
        return "right", expected
    return ("missed" if found > expected else "invented"), expected


def plain(lift: Lift, f: Random, flight: dense.Flight) -> float | None:
    """RK45 with a terminal contact event and nothing else; phase of the contact."""
    from scipy.integrate import solve_ivp as solve

    W2, Z2, G = flight.W**2, 2.0 * flight.Z, flight.G

    def rhs(_s, z):
        return z[1], -W2 * z[0] - Z2 * z[1] - G

    def contact(s, z):
        return z[0] - lift.height(flight.theta + s)

    contact.terminal, contact.direction = True, -1
    start, span = (flight.q, flight.w), (0.0, TURNS * TWO_PI)
    sol = solve(rhs, span, start, events=contact, rtol=TOLERANCE, atol=TOLERANCE)
    hits = sol.t_events[0]
    return float(hits[0]) if hits.size else None


def careful(lift: Lift, f: Random, flight: dense.Flight) -> float | None:
    """DOP853 as in the precision part; phase of the contact."""
    theta, omega = flight.theta, f.rpm * pi / 30
    c, c1, _ = lift.law(lift.region(theta), theta)
    world = World(f.system.follower, lift, omega, TURNS + 1.0, 0.0, process_time() + SLOWEST)
    fly = solve_ivp.Flights(world, "dop853", TOLERANCE, MAX_TURN)
    try:
        hit, turn, at, _, _ = fly(0, theta, max(flight.q - c, 0.0), (flight.w - c1) * omega)
    except (BudgetError, ArithmeticError, ValueError):
        return None
    return turn * TWO_PI + at - theta if hit else None


PEERS: tuple[tuple[str, Callable], ...] = ((PLAIN, plain), (CAREFUL, careful))


def blocks(count: int) -> list[Block]:
    """The blocks of so many flights; only the last one may be cut short."""
    compiled = count >= COMPILE_FROM
    firsts = range(0, count, BLOCK)
    return [Block(k, min(BLOCK, count - first), compiled) for k, first in enumerate(firsts)]


def flights(
    bench: Bench,
    work: Iterable[Block],
    clock: Clock | None = None,
    on_block: Callable[[], None] = lambda: None,
    keeping: Work | None = None,
) -> Iterator[list[Flights]]:
    """Fly the blocks in order; `on_block` is called after each."""
    fly = partial(fly_block, bench=bench, clock=clock or Clock())
    return one_by_one(fly, work, CODEC, keeping, on_block)


def _store(rows: list[Flights]) -> list | None:
    """Nothing of a block that the clock has cut short."""
    whole = rows[0].flights == rows[0].asked
    return [list(vars(row).values()) for row in rows] if whole else None


CODEC = Codec(_store, lambda stored: [Flights(*row) for row in stored])


def fly_block(block: Block, bench: Bench, clock: Clock) -> list[Flights]:
    """Fly the flights of a block by ours, those of the first blocks by the peers too.

    Where the clock is over the rest is left out: fewer flights than asked.
    """
    section = reference("stability")["cam"]
    lift, cam = lift_of(section), bench.cam(section)
    peers = PEERS if block.number < BLOCKS_OF_PEERS else ()
    if peers:
        solve_ivp.load()
    table = [Flights(name, block.count) for name in (OURS, *(name for name, _ in PEERS))]
    rng = np.random.default_rng([block.number])
    for k in range(block.count):
        if clock.over:
            break
        f = random_flight(rng, cam)
        if k == 0 and block.compiled and backend.may_compile():
            compile_for(f.system)
        began = perf_counter()
        found, flight = ours(lift, f)
        seconds = perf_counter() - began
        outcome, expected = verdict(lift, f, found, flight)
        _count(table[0], outcome, seconds)
        for row, (_, fly) in zip(table[1:], peers, strict=False):
            _count(row, *_peer(lift, f, flight, fly, outcome, expected))
    return table


def totals(flown: Iterable[list[Flights]]) -> list[Flights]:
    """What each method made of all blocks."""
    sums: dict[str, Flights] = {}
    for row in (row for rows in flown for row in rows):
        total = sums.setdefault(row.method, Flights(row.method))
        for name, value in vars(row).items():
            if name != "method":
                setattr(total, name, getattr(total, name) + value)
    return list(sums.values())


def _peer(lift: Lift, f: Random, flight: dense.Flight, fly: Callable, outcome: str, expected):
    """(outcome, seconds) of a peer; where brute force cannot decide, neither is it asked."""
    if outcome == "undecided":
        return outcome, 0.0
    began = perf_counter()
    found = fly(lift, f, flight)
    seconds = perf_counter() - began
    if expected is None:
        return "invented" if found is not None else "right", seconds
    if found is None or found > expected + APART:
        return "missed", seconds
    return ("invented" if found < expected - APART else "right"), seconds


def _count(row: Flights, outcome: str, seconds: float) -> None:
    row.flights += 1
    row.seconds += seconds
    row.compared += outcome != "undecided"
    row.missed += outcome == "missed"
    row.invented += outcome == "invented"
