"""Where there is no periodic orbit: boxes of impact phases, each shown to hold none, in balls.

From the cam at phase a to the cam at phase b, s = b - a rad later, exactly one solution of the
flight's equation leads, as long as B(s) > 0 (`kernel.flow`). It starts at the rate
w = (c(b) - c(a) + (G + W^2 c(a)) P)/B, so an orbit is its phases alone: those at which the rate
`out` = w - c'(a) of the flight after each impact, and the rate `into` = w' - c'(b) of the flight
before it, make E = out + r into = 0. Rates are m/rad relative to the cam.

A follower in flight is above the level at which its spring rests, if all of the cam is. So it flies
for less than pi/f rad, f being its own frequency by the angle of the cam, and B is positive. Its
energy w^2/2 + W^2 x^2/2, with x the height above that level, does not grow in flight. With the
steepest slope S of the cam, the rate at which an impact leaves is therefore at most
r (2 S + W sqrt(max x^2 - min x^2))/(1 - r), and B is not smaller than `least` where it falls.

The derivatives by both phases, with K = 1 - W^2 P and D = exp(-2 Z s):
    of out:  out K/B - (c''(a) - q''(a)),  -into/B
    of into: out D/B,                      q''(b) - c''(b) - into B'/B
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import NamedTuple

from flint import arb, arb_mat

from camcli.cams.balls import UndecidedError
from camcli.exact.machine import BallMachine, BallStretch

PARTS = 8  # of a flight, between which it is compared with the cam
SHORT = 0.6  # rad: the acceleration of so short a flight is looked at too
ENERGY_DEPTH = 5  # halvings of a stretch for the bounds of the cam
WIDER = 1e-6  # share of a cell by which it is taken wider, for a checker's larger roundings
ROUNDS = 2  # times that rates and their derivatives sharpen each other

Key = tuple[int, int, int]  # stretch counted on from turn to turn; halvings of it; number of part


class Reason(StrEnum):
    """Why a box of phases holds no orbit."""

    ORDER = "order"  # the first flight is not the longest
    FLIGHT = "flight"  # a flight is too long or too fast, meets the cam, or would pull
    IMPACT = "impact"  # the rates of an impact do not agree
    NEWTON = "newton"  # an interval Newton step leads out of the box


class Cell:
    """A part of a stretch in one of the turns: balls of phases (rad) and of the lift (m).

    own: the phases within the turn; x: counted on from turn to turn; c, c1, c2: lift and
    derivatives on all of them; start, at: phase, and lift and slope there, of one point of it;
    h: own less that point.
    """

    def __init__(self, stretches: Sequence[BallStretch], index: int, own: arb):
        turn, place = divmod(index, len(stretches))
        self.index = index
        self.stretch = stretches[place]
        self.own = own
        middle = own.mid()
        self.h = own - middle
        self.at = self.stretch.derivatives(middle, 1)
        lifts = self.stretch.derivatives(own, 2)
        self.c2 = lifts[2]
        self.c1 = lifts[1].intersection(self.at[1] + self.c2 * self.h)
        self.c = lifts[0].intersection(self.at[0] + self.c1 * self.h)
        shift = 2 * arb.pi() * turn
        self.x = own + shift
        self.start = middle + shift


class Slopes(NamedTuple):
    """Derivatives of the rates of a flight by the phases at which it starts and lands."""

    out_by_start: arb
    out_by_landing: arb
    into_by_start: arb
    into_by_landing: arb


class Detail(NamedTuple):
    """The derivatives of the rates, and the rates of the flight from one point to the other."""

    slopes: Slopes
    out: arb
    into: arb


@dataclass(frozen=True)
class CellFlight:
    """Bounds that hold for all flights from one cell to another.

    out, into: their rates; detail: more, None where it is not known.
    """

    out: arb
    into: arb
    detail: Detail | None = None


class Impossible:
    """In the place of flights where there is none."""


class Unknown:
    """In the place of flights of which nothing is known."""


Found = CellFlight | type[Impossible] | type[Unknown]


class PhaseCover:
    """Flights between cells of the cam, and what they say of boxes of cells.

    Use it at one precision only. A machine that is nearly critical has to be critical, or free.
    Raises UndecidedError for one whose flights may be long: the spring's rest does not lie below
    all of the cam.
    """

    def __init__(self, machine: BallMachine):
        self.machine = machine
        self.count = len(machine.stretches)
        self._cells: dict[Key, Cell] = {}
        self._flights: dict[tuple[Key, Key], Found] = {}
        self.longest: arb | None = None  # rad, of a flight
        self.least = arb(0)  # of B, where it falls
        if machine.sprung and not (machine.over or machine.near_critical):
            self._bound()

    def _bound(self) -> None:
        """The longest flight, and the least B, of a follower that swings."""
        machine = self.machine
        keys = range(self.count), range(2**ENERGY_DEPTH)
        cells = [self.cell((k, ENERGY_DEPTH, i)) for k in keys[0] for i in keys[1]]
        heights = [one.c + machine.G / machine.W2 for one in cells]
        low = arb(min(x.lower() for x in heights))
        high = arb(max(x.upper() for x in heights))
        steepest = arb(max(abs(one.c1).upper() for one in cells))
        if not low > 0:
            raise UndecidedError
        self.longest = arb.pi() / machine.frequency
        r = machine.r
        if r < 1:
            fastest = 2 * steepest + (machine.W2 * (high * high - low * low)).sqrt()
            self.least = low / (fastest * r / (1 - r) + steepest)

    def cell(self, key: Key) -> Cell:
        """One of the 2^k equal parts of a stretch."""
        if key not in self._cells:
            index, depth, i = key
            one = self.machine.stretches[index % self.count]
            width = (one.end - one.start) / 2**depth
            own = (one.start + width * i).union(one.start + width * (i + 1))
            own += arb(0, WIDER) * width
            self._cells[key] = Cell(self.machine.stretches, index, own)
        return self._cells[key]

    def later(self, key: Key, turns: int) -> Key:
        """The same part some turns later."""
        return key[0] + turns * self.count, key[1], key[2]

    def between(self, a: Key, b: Key) -> Found:
        """The flights from one part to another."""
        if (a, b) not in self._flights:
            self._flights[a, b] = self.flight(self.cell(a), self.cell(b))
        return self._flights[a, b]

    def flight(self, a: Cell, b: Cell) -> Found:
        """The flights from one cell to another."""
        machine = self.machine
        s = b.x - a.x
        if s <= 0 or (self.longest is not None and s >= self.longest):
            return Impossible
        short = self._short(a, b, s) if b.index - a.index <= 1 else Unknown
        if short is Impossible or not s > 0:
            return short
        big, rate, p = machine.flow(s)
        keeps = 1 - machine.W2 * p
        if keeps < 0 and big < self.least:
            return Impossible
        if not big > 0:
            return short
        decay = arb(1) if machine.undamped else (-machine.Z2 * s).exp()
        w = (b.c - a.c * keeps + machine.G * p) / big
        landing = (b.c * rate - a.c * decay + machine.G * (p * rate - big * big)) / big
        out = w - a.c1
        into = landing - b.c1
        if isinstance(short, CellFlight):
            out = out.intersection(short.out)
            into = into.intersection(short.into)
        begin, middle = self._middle(a, b)
        for _ in range(ROUNDS):
            leaves = a.c2 - self._acceleration(a.c, a.c1 + out)
            lands = self._acceleration(b.c, b.c1 + into) - b.c2
            slopes = Slopes(
                out * keeps / big - leaves,
                -into / big,
                out * decay / big,
                lands - into * rate / big,
            )
            out = out.intersection(
                middle[0] + slopes.out_by_start * a.h + slopes.out_by_landing * b.h
            )
            into = into.intersection(
                middle[1] + slopes.into_by_start * a.h + slopes.into_by_landing * b.h
            )
        if out <= 0 or into >= 0 or self._pierces(a, b, begin, out, into, big):
            return Impossible
        return CellFlight(out, into, Detail(slopes, *middle))

    def _acceleration(self, q: arb, w: arb) -> arb:
        """q'' in flight."""
        machine = self.machine
        return -(machine.G + machine.W2 * q + machine.Z2 * w)

    def _middle(self, a: Cell, b: Cell) -> tuple[arb, tuple[arb, arb]]:
        """(w, (out, into)) of the flight from the one point of a to that of b."""
        machine = self.machine
        (c, c1), (end, end1) = a.at, b.at
        big, rate, p = machine.flow(b.start - a.start)
        w = (end - c * (1 - machine.W2 * p) + machine.G * p) / big
        landing = w * rate - (machine.G + machine.W2 * c) * big
        return w, (w - c1, landing - end1)

    def _pierces(self, a: Cell, b: Cell, w: arb, out: arb, into: arb, big: arb) -> bool:
        """Whether every flight is below the cam at one phase on its way."""
        machine = self.machine
        c = a.at[0]
        for k in range(1, PARTS):
            phase = (a.start + (b.start - a.start) * k / PARTS).mid()
            lift = self._lift(phase)
            if lift is None or not (a.x < phase and phase < b.x):
                continue
            first, _, p = machine.flow(phase - a.start)
            q = c + w * first - (machine.G + machine.W2 * c) * p
            since = phase - a.x
            decay = arb(1) if machine.undamped else (-machine.Z2 * since).exp()
            by_start = -out * machine.flow(b.x - phase)[0] * decay / big
            by_landing = -into * machine.flow(since)[0] / big
            if q + by_start * a.h + by_landing * b.h < lift:
                return True
        return False

    def _lift(self, phase: arb) -> arb | None:
        """The lift at a phase; None beside a corner."""
        turn = 2 * arb.pi()
        phase -= turn * (phase / turn).floor()
        for one in self.machine.stretches:
            if phase > one.start and phase < one.end:
                return one.derivatives(phase, 0)[0]
        return None

    def _short(self, a: Cell, b: Cell, s: arb) -> Found:
        """Flights on one stretch, or from one to the next, by their acceleration.

        The gap is zero at both ends: `out` is -s/2 times a mean of its second derivative, `into`
        s/2 times another, and where that is nowhere negative the gap is nowhere positive.
        """
        machine = self.machine
        most = arb(s.upper())
        if most > SHORT or not (self.longest is None or most < self.longest):
            return Unknown
        big, rate, _ = machine.flow(most)
        if not (big > 0 and rate > 0):
            return Unknown
        if a.index == b.index:
            _, c1, c2 = a.stretch.derivatives(a.own.union(b.own), 2)
        else:
            _, c1, c2 = a.stretch.derivatives(a.own.union(a.stretch.end), 2)
            _, next1, next2 = b.stretch.derivatives(b.own.union(b.stretch.start), 2)
            c1, c2 = c1.union(next1), c2.union(next2)
        time = arb(0).union(most)
        # Below `longest` B' changes its sign once at most, so B is concave up to `most`:
        # 1 < s/B < most/B(most), and s/2 < P/B < s
        w = c1 * arb(1).union(most / big) + (machine.G + machine.W2 * a.c) * time
        bend = machine.move(a.c, w, time, 2)[2] - c2
        if bend >= 0:
            return Impossible
        half = s / 2 if s > 0 else time / 2
        return CellFlight(-half * bend, half * bend)

    def excluded(self, keys: Sequence[Key], turns: int) -> Reason | None:
        """Why no orbit of so many turns has one impact in each of these cells, or None.

        Its first flight is its longest, or one of them.
        """
        closed = [*keys, self.later(keys[0], turns)]
        cells = [self.cell(key) for key in closed]
        if len(keys) > 1:
            lengths = [b.x - a.x for a, b in pairwise(cells)]
            shorter = len(keys) * lengths[0] < 2 * turns * arb.pi()
            if shorter or any(one > lengths[0] for one in lengths):
                return Reason.ORDER
        flights = []
        for a, b in pairwise(closed):
            flight = self.between(a, b)
            if flight is Impossible:
                return Reason.FLIGHT
            flights.append(flight)
        for k, here in enumerate(flights):
            before = flights[k - 1]
            if not (isinstance(here, CellFlight) and isinstance(before, CellFlight)):
                continue
            if not (here.out + self.machine.r * before.into).contains(0):
                return Reason.IMPACT
        found = self.newton(flights, cells[:-1])
        if found is None:
            return None
        values, slopes = found
        off = arb_mat([[one.h] for one in cells[:-1]])
        if not all(x.contains(0) for x in (values + slopes * off).entries()):
            return Reason.IMPACT
        try:
            inverse = slopes.mid().inv().mid()
        except ZeroDivisionError:
            return None
        image = (_identity(len(keys)) - inverse * slopes) * off - inverse * values
        pairs = zip(image.entries(), off.entries(), strict=True)
        return None if all(x.overlaps(y) for x, y in pairs) else Reason.NEWTON

    def newton(
        self, flights: Sequence[Found], cells: Sequence[Cell]
    ) -> tuple[arb_mat, arb_mat] | None:
        """(E at the cells' points, its derivatives on all of them), None where they are unknown."""
        n = len(cells)
        values = arb_mat(n, 1)
        slopes = arb_mat(n, n)
        r = self.machine.r
        for k, here in enumerate(flights):
            before = flights[k - 1]
            if not (isinstance(here, CellFlight) and isinstance(before, CellFlight)):
                return None
            if here.detail is None or before.detail is None:
                return None
            own = here.detail.slopes
            other = before.detail.slopes
            values[k, 0] = here.detail.out + r * before.detail.into
            slopes[k, (k - 1) % n] += r * other.into_by_start
            slopes[k, k] += r * other.into_by_landing + own.out_by_start
            slopes[k, (k + 1) % n] += own.out_by_landing
        return values, slopes

    def at(self, cells: Sequence[Cell], turns: int) -> tuple[arb_mat, arb_mat, list[arb]] | None:
        """E, its derivatives, and the rates `out`, in some cells; None where they are unknown."""
        later = cells[0].index + turns * self.count
        closed = [*cells, Cell(self.machine.stretches, later, cells[0].own)]
        flights = [self.flight(a, b) for a, b in pairwise(closed)]
        found = self.newton(flights, cells)
        if found is None:
            return None
        return *found, [one.out for one in flights if isinstance(one, CellFlight)]

    def alone(self, keys: Sequence[Key], turns: int, phases: Sequence[arb]) -> bool:
        """Whether E has at most one zero in some cells together with phases near them.

        phases: within the turn, one for each cell.
        """
        wide = [
            Cell(self.machine.stretches, key[0], self.cell(key).own.union(phase))
            for key, phase in zip(keys, phases, strict=True)
        ]
        found = self.at(wide, turns)
        if found is None:
            return False
        slopes = found[1]
        try:
            off = slopes.mid().inv().mid() * slopes - _identity(len(keys))
        except ZeroDivisionError:
            return False
        across = range(len(keys))
        return all(sum((abs(off[i, j]) for j in across), arb(0)) < 1 for i in across)


def _identity(n: int) -> arb_mat:
    """The matrix with ones on its diagonal."""
    return arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
