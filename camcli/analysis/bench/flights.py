"""Random flights: contacts that the kernel misses or invents, against a dense search.

The search samples the gap finely, the cam in closed form and the flight by textbook formulas, and
looks into every dip: nothing of the kernel, and no proof, since a dip narrower than a cell between
two corners stays unseen. A flight counts where it can be decided: it has a contact within TURNS
that no graze closer than rounding precedes. Flights come in blocks of BLOCK, each with random
numbers of its own, so that a flight is the same however many are asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf, pi
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.bench.lifts import TWO_PI, Lift, lift_of
from camcli.analysis.bench.machine import Machines, events, reference
from camcli.analysis.bench.pieces import NOT_REACHED, OK
from camcli.analysis.integrate import Orbit, Settings, Start
from camcli.kernel import backend
from camcli.kernel.cam_table import Cam
from camcli.system import Follower, System

TURNS = 2.5
EDGE = 1e-5  # rad: a contact this close to the end is not asked of anybody
BLOCK = 1000  # flights
COMPILE_FROM = 500  # flights
CORE = "core"
RIGHT, MISSED, INVENTED, UNDECIDED = "right", "missed", "invented", "undecided"


class Flight(NamedTuple):
    """A flight over a cam: the machine, and in rad of cam angle its constants and its start."""

    system: System
    rpm: float
    W: float  # omega0/omega
    Z: float  # zeta/omega
    G: float  # (g + F0/m)/omega^2
    theta_deg: float
    q: float
    w: float  # m/rad
    contact: bool  # it starts on the cam

    @property
    def theta(self) -> float:
        """Phase of the start, rad."""
        return self.theta_deg * (pi / 180.0)


@dataclass
class Flights:
    """A row of flights.csv: flights asked for, flown by a method, and decided."""

    method: str
    asked: int = 0
    flights: int = 0
    compared: int = 0
    missed: int = 0
    invented: int = 0
    seconds: float = 0.0

    @property
    def status(self) -> str:
        """Whether the clock has cut the block short."""
        return NOT_REACHED if self.flights < self.asked else OK


def random_flight(rng: np.random.Generator, cam: Cam, lift: Lift) -> Flight:
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
    c, c1, _ = lift.at(theta * (pi / 180))
    start = (float(theta), c + float(gap), c1 + float(u), contact)
    return Flight(system, float(rpm), W, Z, gravity / omega**2, *start)


def first_impact(f: Flight) -> float | None:
    """Phase of our first impact from the start, None if there is none."""
    omega = f.rpm * (pi / 30)
    start = Start(None if f.contact else f.q, f.w * omega, f.theta_deg)
    tape = Orbit(f.system, f.rpm, Settings(0, 3, 1e-16, 1, start)).run()
    found = (e for e in events(tape, 0 if f.theta == 0 else 1) if e.kind == "impact")
    return next((e.theta + TWO_PI * e.turn - f.theta for e in found), None)


# --- the dense search

CELLS = 3000  # per turn
DOUBT = 1e-13  # m: a gap this small may count either way
FINER = 16  # cells of a cell


def flow(f: Flight, s: Any) -> tuple[Any, Any]:
    """(q, w) after s of flight, with the equilibrium subtracted (W > 0)."""
    rest = -f.G / f.W**2
    d = np.sqrt(complex(f.Z * f.Z - f.W * f.W))
    cosh, sinh = np.cosh(d * s), np.sinh(d * s) / d if d else s + 0j
    decay = np.exp(-f.Z * s)
    x, y = f.q - rest, f.w + f.Z * (f.q - rest)
    position = decay * (x * cosh + y * sinh).real
    slope = decay * (x * d * d * sinh + y * cosh).real - f.Z * position
    return rest + position, slope


def gap(lift: Lift, f: Flight, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gap and its rate after s of flight; m, m/rad."""
    theta = np.mod(f.theta + s, TWO_PI)
    region = np.searchsorted(np.array(lift.breaks), theta, side="right")
    c, c1 = np.empty_like(theta), np.empty_like(theta)
    for k in np.unique(region):
        here = region == k
        c[here], c1[here], _ = lift.law(int(k), theta[here], np)
    q, w = flow(f, s)
    return q - c, w - c1


def dense_contact(lift: Lift, f: Flight) -> tuple[float | None, bool]:
    """(s, doubtful): phase of the first contact within TURNS, None if there is none.

    doubtful: a graze closer than DOUBT comes first.
    """
    cell = TWO_PI / CELLS
    first = np.geomspace(1e-7, cell, 400) if f.contact else np.zeros(1)
    turns = TWO_PI * np.arange(int(TURNS) + 2)[:, None]
    corners = (np.array([0.0, *lift.breaks]) + turns).ravel() - f.theta
    corners = corners[(corners > first[-1]) & (corners < TURNS * TWO_PI)]
    s = np.sort(np.concatenate([first, cell * np.arange(2, int(CELLS * TURNS) + 1), corners]))
    g, u = gap(lift, f, s)
    below = np.flatnonzero(g <= 0)
    stop = below[0] if len(below) else len(s) - 1
    for j in np.flatnonzero((u[:stop] < 0) & (u[1 : stop + 1] >= 0) & (g[:stop] > 0)):
        low = _crossing(lambda at: -gap(lift, f, at)[1], s[j], s[j + 1])
        least = float(gap(lift, f, np.array([low]))[0][0])
        if abs(least) < DOUBT:
            return low, True
        if least < 0:
            return _crossing(lambda at: gap(lift, f, at)[0], s[j], low), False
    if not len(below):
        return None, False
    if stop == 0:
        return None, True
    return _crossing(lambda at: gap(lift, f, at)[0], s[stop - 1], s[stop]), False


def _crossing(function: Callable, low: float, high: float) -> float:
    """Where a function, positive at low, becomes negative: cells of cells, to the last bit."""
    for _ in range(15):
        at = np.linspace(low, high, FINER + 1)
        crossed = np.flatnonzero(function(at[1:]) <= 0)
        k = crossed[0] if len(crossed) else FINER - 1
        low, high = at[k], at[k + 1]
    return float(0.5 * (low + high))


def verdict(lift: Lift, f: Flight, found: float | None) -> tuple[str, float | None]:
    """What our contact is, and the contact by the dense search."""
    expected, doubtful = dense_contact(lift, f)
    far = TURNS * TWO_PI - EDGE
    none = found is None and expected is None
    if doubtful or none or (found or 0.0) > far or (expected or 0.0) > far:
        return UNDECIDED, None
    if found is None or expected is None:
        return (MISSED if found is None else INVENTED), expected
    u = abs(float(gap(lift, f, np.array([expected]))[1][0]))
    size = abs(f.q) + abs(f.w) + f.G * expected**2 + f.G / f.W**2
    if abs(found - expected) <= 1e-12 * size / max(u, 1e-7) + 2e-12:
        return RIGHT, expected
    return (MISSED if found > expected else INVENTED), expected


# --- blocks


class Block(NamedTuple):
    """So many flights of the random numbers with a seed; whether they are worth compiling for."""

    seed: int
    flights: int
    compiled: bool = False


def blocks(flights: int) -> list[Block]:
    """The blocks of so many flights; only the last one may be cut short."""
    firsts = range(0, flights, BLOCK)
    compiled = flights >= COMPILE_FROM
    return [Block(k, min(BLOCK, flights - first), compiled) for k, first in enumerate(firsts)]


def fly_block(block: Block, machines: Machines, seconds: float = inf) -> list[Flights]:
    """Fly the flights of a block; what the seconds do not suffice for is left out."""
    section = reference("stability")["cam"]
    lift, cam = lift_of(section), machines.cam(section)
    flown = Flights(CORE, block.flights)
    rng = np.random.default_rng([block.seed])
    until = perf_counter() + seconds
    for k in range(block.flights):
        if perf_counter() >= until:
            break
        f = random_flight(rng, cam, lift)
        if k == 0 and block.compiled:
            backend.compiled()
        began = perf_counter()
        found = first_impact(f)
        flown.seconds += perf_counter() - began
        outcome, _ = verdict(lift, f, found)
        flown.flights += 1
        flown.compared += outcome != UNDECIDED
        flown.missed += outcome == MISSED
        flown.invented += outcome == INVENTED
    return [flown]


def total(flown: Iterable[Flights]) -> Flights:
    """All blocks together."""
    whole = Flights(CORE)
    for row in flown:
        for name in ("asked", "flights", "compared", "missed", "invented", "seconds"):
            setattr(whole, name, getattr(whole, name) + getattr(row, name))
    return whole
