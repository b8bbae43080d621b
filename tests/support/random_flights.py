"""Random flights, and contacts that a program misses or invents, judged in ball arithmetic.

The judge (`exact.first_root`) shows every interval of a flight to be free of contacts, or to hold
exactly one; it shares the formulas of the cam with the kernel, neither its table nor its search.
"""

from __future__ import annotations

from functools import cache, partial
from math import inf, pi, radians
from typing import NamedTuple

import numpy as np
from flint import arb

from camcli.analysis.bench.machine import events, orbit
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import column
from camcli.exact.first_root import first_root
from camcli.exact.machine import BallMachine
from camcli.kernel.sticking import contact_accel
from camcli.scene import load_scene
from camcli.system import Follower, System

TURNS = 2.5
EDGE = 1e-5  # rad: a contact this close to the end is not asked of anybody
DIGITS = 30  # of the judge, where 64 bits do not suffice
CAMS = ["chapter", "law-cycloidal", "law-harmonic", "law-smooth", "eccentric", "valve-train"]
RIGHT, MISSED, INVENTED, UNDECIDED = "right", "missed", "invented", "undecided"


class Flight(NamedTuple):
    """A flight over a cam, from theta = theta_deg pi/180 as a double."""

    system: System
    rpm: float
    theta_deg: float
    q: float  # m
    w: float  # m/rad
    contact: bool  # it starts on the cam

    @property
    def theta(self) -> float:
        return self.theta_deg * (pi / 180.0)


@cache
def cam_of(name: str) -> System:
    cam = load_scene(f"configs/{name}.yaml").cam
    return System.build(Follower(1, 1), cam)


def machine_on(name: str, rng: np.random.Generator) -> tuple[System, float, float]:
    """(machine on the cam of this name, its speed in rpm, the cam's rise in m), drawn at random.

    W: natural frequency of the follower over omega; Z: its decay over omega, from no damping over
    critical, to the last bit, to ten times as much. gravity: up to a hundred times the rise times
    omega^2.
    """
    machine, rpm, W = cam_of(name), 10 ** rng.uniform(1.5, 4), 10 ** rng.uniform(-2, 1.3)
    omega = rpm * pi / 30
    lift = machine.cam.top - min(column(machine.cam, "c_min"))
    Z = rng.choice([0, W, W * (1 + 1e-15), 1.0, 10.0]) * 10 ** rng.uniform(-3, 0)
    gravity = rng.choice([0, 1]) * lift * 10 ** rng.uniform(-2, 2) * omega**2
    follower = Follower(1.0, (W * omega) ** 2, 2 * Z * omega, gravity, 0.0, 0.5)
    return System(follower, machine.cam, machine.shape), rpm, lift


def random_flight(name: str, rng: np.random.Generator) -> Flight:
    """A flight from the cam, or from near or far above it; a fifth begins on a corner."""
    machine, rpm, lift = machine_on(name, rng)
    corner = float(rng.choice([0.0, *np.degrees(machine.corners)]))
    theta = corner if rng.random() < 0.2 else float(rng.uniform(0, 360))
    contact = bool(rng.random() < 0.3)
    q, w = orbit(machine, rpm, 1, theta=radians(theta)).position()
    gap = 0.0 if contact else lift * 10 ** rng.uniform(-6, 1)
    u = lift * 10 ** rng.uniform(-4, 1.5) * (1 if contact else rng.choice([-1, 1]))
    return Flight(machine, rpm, theta, q + gap, w + u, contact)


def near_graze(name: str, rng: np.random.Generator) -> Flight | None:
    """A flight whose gap has a minimum near zero: 1e-12 to 1e-6 of the rise above or below it.

    Flown backwards from there, often across corners; None where the gap has a maximum instead, or
    the flight would begin in the cam.
    """
    system, rpm, lift = machine_on(name, rng)
    corner = rng.choice([0.0, *system.corners]) + rng.choice([-1, 1]) * 1e-9
    theta = float(corner if rng.random() < 0.2 else rng.uniform(0, 2 * pi)) % (2 * pi)
    offset = lift * 10 ** rng.uniform(-12, -6) * rng.choice([-1, 1])
    back = 10 ** rng.uniform(-2, 0.2) / (1 + system.constants(rpm, 0.0, 1).Z)
    begin = theta - back + (2 * pi if theta < back else 0)
    with precision(40):
        machine = BallMachine(system.shape, system.follower, rpm)
        c = machine.stretches[part_of(machine, theta)].derivatives(arb(theta), 2)
        q, w, accel, _ = machine.move(c[0] + offset, c[1], arb(0))
        if not accel > c[2]:
            return None
        degrees = begin * 180 / pi
        begin = arb(degrees * (pi / 180))
        back = theta - begin + (2 * arb.pi() if theta < back else 0)
        q, w, _, _ = machine.move(q, w, -back)
        here = machine.stretches[part_of(machine, float(begin))].derivatives(begin, 0)[0]
        return Flight(system, rpm, degrees, float(q), float(w), False) if q > here else None


def low_hop(name: str, rng: np.random.Generator) -> Flight | None:
    """A slow start from the cam near a phase where the contact force changes its sign."""
    system, rpm, lift = machine_on(name, rng)
    cam, const = system.cam, system.constants(rpm, 0.0, 1)
    k = int(rng.integers(len(cam.stretches)))
    grid = np.linspace(cam.stretches[k].start, cam.stretches[k].end, 40)[1:-1]
    accel = [contact_accel(cam, const, k, float(theta))[0] for theta in grid]
    changes = np.flatnonzero(np.diff(np.sign(accel)))
    if not changes.size:
        return None
    theta = grid[rng.choice(changes)] + (grid[1] - grid[0]) * rng.uniform(-1, 2)
    degrees = float(theta * 180 / pi)
    q, w = orbit(system, rpm, 1, theta=radians(degrees)).position()
    return Flight(system, rpm, degrees, q, w + lift * 10 ** rng.uniform(-9, -1), True)


def part_of(machine: BallMachine, theta: float) -> int:
    """Index of the machine's stretch that holds theta."""
    return next(k for k, part in enumerate(machine.stretches) if part.end > theta)


def landing(f: Flight) -> tuple[float, float] | None:
    """Phase (rad from the start) and rate (m/rad) of our first impact, chatter never closed."""
    q, v = (None if f.contact else f.q), f.w * f.rpm * (pi / 30)
    record = orbit(f.system, f.rpm, tolerance=-1.0, budget=1, q=q, v=v, theta=f.theta)
    found = (e for e in events(record.run(), 0 if f.theta == 0 else 1) if e.kind == "impact")
    return next(((e.theta + 2.0 * pi * e.turn - f.theta, e.u) for e in found), None)


def true_contact(f: Flight) -> tuple[arb, arb] | None:
    """(phase from the start, rate of the gap in m/rad) of the first contact within TURNS, or None.

    Raises UndecidedError near a double zero of the gap.
    """
    machine = BallMachine(f.system.shape, f.system.follower, f.rpm)
    theta, w, end = arb(f.theta), arb(f.w), TURNS * machine.turn
    i = next(k for k, part in enumerate(machine.stretches) if part.end > theta)
    begin, low = machine.stretches[i].end, arb(0)
    q = machine.stretches[i].derivatives(theta, 0)[0] if f.contact else arb(f.q)

    def gap(s: arb, i: int, turn: arb) -> list[arb]:
        cam = machine.stretches[i].derivatives(theta + s - turn, 2)
        return [x - y for x, y in zip(machine.move(q, w, s), cam, strict=False)]

    turn, high = arb(0), begin - theta
    while low < end:
        here = partial(gap, i=i, turn=turn)
        if f.contact and low == 0:  # the gap opens: to where its rate is shown to be positive
            low = high.upper()
            while not here(arb(0).union(low))[1] > 0:
                low = (low / 2).mid()
        elif not here(low)[0] > 0:
            raise UndecidedError
        s = first_root(here, low, high.upper()) if low < high else None
        if s is not None and s < high:
            return s, here(s)[1]
        low, i = high, (i + 1) % len(machine.stretches)
        turn += machine.turn if i == 0 else 0
        high = machine.stretches[i].end + turn - theta
    return None


def verdict(f: Flight, found: float | None) -> tuple[str, float | None]:
    """What a contact is, and the true one; near the end of the time, or without any, undecided."""
    try:
        with precision(DIGITS):
            true = true_contact(f)
            late = 0.0 if found is None or true is None else float(found - true[0])
    except UndecidedError:
        return UNDECIDED, None
    at, u = (inf, 0.0) if true is None else (float(true[0]), abs(float(true[1])))
    if min(at, inf if found is None else found) > TURNS * 2.0 * pi - EDGE:
        return UNDECIDED, None
    if found is None:
        return MISSED, at
    if true is None:
        return INVENTED, None
    const = f.system.constants(f.rpm, 0.0, 1)
    size = abs(f.q) + abs(f.w) + const.G * at**2 + const.G / const.W2
    if abs(late) <= 1e-12 * size / max(u, 1e-7) + 2e-12:
        return RIGHT, at
    return (MISSED if late > 0.0 else INVENTED), at
