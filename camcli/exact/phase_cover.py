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
from camcli.exact.machine import BallMachine, BallStretch, identity

PARTS = 8  # of a flight, between which it is compared with the cam
SHORT = 0.6  # rad: the acceleration of so short a flight is looked at too
ENERGY_DEPTH = 5  # halvings of a stretch for the bounds of the cam
WIDER = 1e-6  # share of a cell by which it is taken wider, for a checker's larger roundings
ROUNDS = 2  # times that rates and their derivatives sharpen each other


class Key(NamedTuple):
    """One of the 2^depth equal parts of a stretch, which is counted on from turn to turn."""

    stretch: int
    depth: int
    part: int


class Exclusion(StrEnum):
    """Why a box of phases holds no orbit."""

    ORDER = "order"  # the first flight is not the longest
    FLIGHT = "flight"  # a flight is too long or too fast, meets the cam, or would pull
    IMPACT = "impact"  # the rates of an impact do not agree
    NEWTON = "newton"  # an interval Newton step leads out of the box


class CellPoint(NamedTuple):
    """The middle of a cell: its phase (rad), counted on, and lift and slope of the cam there."""

    phase: arb
    c: arb
    c1: arb


class Cell:
    """A part of a stretch in one of the turns: balls of phases (rad) and of the lift (m).

    index: of the stretch, counted on from turn to turn; in_turn: the phases within the turn; x: the
    same counted on likewise; c, c1, c2: lift and derivatives on all of them; middle: one point of
    it; h: what the phases may differ from that point's.
    """

    def __init__(self, stretches: Sequence[BallStretch], index: int, in_turn: arb):
        turn, number = divmod(index, len(stretches))
        self.index = index
        self.stretch = stretches[number]
        self.in_turn = in_turn
        middle = in_turn.mid()
        self.h = in_turn - middle
        c, c1 = self.stretch.derivatives(middle, 1)
        wide_c, wide_c1, self.c2 = self.stretch.derivatives(in_turn, 2)
        # the mean value theorem may be sharper
        self.c1 = wide_c1.intersection(c1 + self.c2 * self.h)
        self.c = wide_c.intersection(c + self.c1 * self.h)
        shift = 2 * arb.pi() * turn
        self.x = in_turn + shift
        self.middle = CellPoint(middle + shift, c, c1)


class RateSlopes(NamedTuple):
    """Derivatives of the rates of a flight by the phases at which it starts and lands."""

    out_by_start: arb
    out_by_landing: arb
    into_by_start: arb
    into_by_landing: arb


class Rates(NamedTuple):
    """The rates of a flight relative to the cam where it starts, and where it lands; m/rad."""

    out: arb
    into: arb


class Detail(NamedTuple):
    """What is known of flights from cell to cell beside their rates.

    slopes: derivatives of these, on all of the cells; middle: the rates from middle to middle.
    """

    slopes: RateSlopes
    middle: Rates


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


FlightBounds = CellFlight | type[Impossible] | type[Unknown]


class ImpactEquations(NamedTuple):
    """E of each impact at the cells' middles, (n, 1), and its derivatives on all of them, (n, n).

    E = out + r into, with the rates of the flight after the impact and of the one before.
    """

    values: arb_mat
    slopes: arb_mat


class CheckedCells(NamedTuple):
    """The equations in some cells, and the rate at which each impact leaves the cam, m/rad."""

    equations: ImpactEquations
    rates: list[arb]


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
        self._flights: dict[tuple[Key, Key], FlightBounds] = {}
        self.longest: arb | None = None  # rad, of a flight
        self.least = arb(0)  # of B, where it falls
        if machine.sprung and not (machine.over or machine.near_critical):
            self._bound()

    def _bound(self) -> None:
        """Set the longest flight, and the least B, of a follower that swings; see the file's head.

        The bounds of the cam are those of its cells at the depth ENERGY_DEPTH.
        """
        machine = self.machine
        cells = [
            self.cell(Key(stretch, ENERGY_DEPTH, part))
            for stretch in range(self.count)
            for part in range(2**ENERGY_DEPTH)
        ]
        heights = [cell.c + machine.G / machine.W2 for cell in cells]  # above the spring's rest
        low = arb(min(x.lower() for x in heights))
        high = arb(max(x.upper() for x in heights))
        steepest = arb(max(abs(cell.c1).upper() for cell in cells))
        if not low > 0:
            raise UndecidedError
        self.longest = arb.pi() / machine.frequency
        r = machine.r
        if r < 1:
            fastest = 2 * steepest + (machine.W2 * (high * high - low * low)).sqrt()
            self.least = low / (fastest * r / (1 - r) + steepest)

    def cell(self, key: Key) -> Cell:
        """The cell of a key, made once; a little wider than its part of the stretch."""
        if key not in self._cells:
            stretch = self.machine.stretches[key.stretch % self.count]
            width = (stretch.end - stretch.start) / 2**key.depth
            start = stretch.start + width * key.part
            end = stretch.start + width * (key.part + 1)
            in_turn = start.union(end) + arb(0, WIDER) * width
            self._cells[key] = Cell(self.machine.stretches, key.stretch, in_turn)
        return self._cells[key]

    def later(self, key: Key, turns: int) -> Key:
        """The same part some turns later."""
        return key._replace(stretch=key.stretch + turns * self.count)

    def between(self, a: Key, b: Key) -> FlightBounds:
        """The flights from one part to another, worked out once."""
        if (a, b) not in self._flights:
            self._flights[a, b] = self.flight(self.cell(a), self.cell(b))
        return self._flights[a, b]

    def flight(self, a: Cell, b: Cell) -> FlightBounds:
        """The flights from one cell to another; the equations stand at the head of the file.

        The rates are bounded over both cells, by the acceleration where the flight is short, and by
        the mean value theorem about the cells' middles, ROUNDS times with sharper slopes.
        """
        machine = self.machine
        s = b.x - a.x
        if s <= 0 or (self.longest is not None and s >= self.longest):
            return Impossible
        by_acceleration = self._short(a, b, s) if b.index - a.index <= 1 else Unknown
        if by_acceleration is Impossible or not s > 0:
            return by_acceleration
        big, rate, p = machine.flow(s)  # B, B', P
        keeps = 1 - machine.W2 * p  # K
        if keeps < 0 and big < self.least:
            return Impossible
        if not big > 0:
            return by_acceleration
        decay = arb(1) if machine.undamped else (-machine.Z2 * s).exp()  # D
        w = (b.c - a.c * keeps + machine.G * p) / big
        w_end = (b.c * rate - a.c * decay + machine.G * (p * rate - big * big)) / big
        out = w - a.c1
        into = w_end - b.c1
        if isinstance(by_acceleration, CellFlight):
            out = out.intersection(by_acceleration.out)
            into = into.intersection(by_acceleration.into)
        w_middle, middle = self._between_middles(a, b)
        for _ in range(ROUNDS):
            leaves = a.c2 - self._acceleration(a.c, a.c1 + out)
            lands = self._acceleration(b.c, b.c1 + into) - b.c2
            slopes = RateSlopes(
                out_by_start=out * keeps / big - leaves,
                out_by_landing=-into / big,
                into_by_start=out * decay / big,
                into_by_landing=lands - into * rate / big,
            )
            out = out.intersection(
                middle.out + slopes.out_by_start * a.h + slopes.out_by_landing * b.h
            )
            into = into.intersection(
                middle.into + slopes.into_by_start * a.h + slopes.into_by_landing * b.h
            )
        if out <= 0 or into >= 0 or self._pierces(a, b, w_middle, Rates(out, into), big):
            return Impossible
        return CellFlight(out, into, Detail(slopes, middle))

    def _acceleration(self, q: arb, w: arb) -> arb:
        """q'' in flight at a height q (m) with the rate w (m/rad)."""
        machine = self.machine
        return -(machine.G + machine.W2 * q + machine.Z2 * w)

    def _between_middles(self, a: Cell, b: Cell) -> tuple[arb, Rates]:
        """(w, rates) of the flight from the middle of a to that of b; w: its q' there, m/rad."""
        machine = self.machine
        start = a.middle
        end = b.middle
        big, rate, p = machine.flow(end.phase - start.phase)
        w = (end.c - start.c * (1 - machine.W2 * p) + machine.G * p) / big
        w_end = w * rate - (machine.G + machine.W2 * start.c) * big
        return w, Rates(w - start.c1, w_end - end.c1)

    def _pierces(self, a: Cell, b: Cell, w: arb, rates: Rates, big: arb) -> bool:
        """Whether every flight from a to b is below the cam at one phase on its way.

        w: q' of the flight between the middles; big: B over the whole way. Started da and landed db
        beside these, a flight is higher at a phase x by
        -out B(b - x) exp(-2 Z (x - a))/B da - into B(x - a)/B db.
        """
        machine = self.machine
        start = a.middle
        end = b.middle
        for k in range(1, PARTS):
            phase = (start.phase + (end.phase - start.phase) * k / PARTS).mid()
            lift = self._lift(phase)
            if lift is None or not (a.x < phase and phase < b.x):
                continue
            big_to_phase, _, p = machine.flow(phase - start.phase)
            q = start.c + w * big_to_phase - (machine.G + machine.W2 * start.c) * p
            since = phase - a.x
            decay = arb(1) if machine.undamped else (-machine.Z2 * since).exp()
            by_start = -rates.out * machine.flow(b.x - phase)[0] * decay / big
            by_landing = -rates.into * machine.flow(since)[0] / big
            if q + by_start * a.h + by_landing * b.h < lift:
                return True
        return False

    def _lift(self, phase: arb) -> arb | None:
        """The lift (m) at a phase; None beside a corner."""
        turn = 2 * arb.pi()
        in_turn = phase - turn * (phase / turn).floor()
        for stretch in self.machine.stretches:
            if in_turn > stretch.start and in_turn < stretch.end:
                return stretch.derivatives(in_turn, 0)[0]
        return None

    def _short(self, a: Cell, b: Cell, s: arb) -> FlightBounds:
        """Flights of s rad on one stretch, or from one to the next, by their acceleration.

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
            _, c1, c2 = a.stretch.derivatives(a.in_turn.union(b.in_turn), 2)
        else:
            _, c1, c2 = a.stretch.derivatives(a.in_turn.union(a.stretch.end), 2)
            _, c1_next, c2_next = b.stretch.derivatives(b.in_turn.union(b.stretch.start), 2)
            c1 = c1.union(c1_next)
            c2 = c2.union(c2_next)
        time = arb(0).union(most)
        # Below `longest` B' changes its sign once at most, so B is concave up to `most`:
        # 1 < s/B < most/B(most), and s/2 < P/B < s
        w = c1 * arb(1).union(most / big) + (machine.G + machine.W2 * a.c) * time
        bend = machine.move(a.c, w, time, 2)[2] - c2
        if bend >= 0:
            return Impossible
        half = s / 2 if s > 0 else time / 2
        return CellFlight(out=-half * bend, into=half * bend)

    def excluded(self, keys: Sequence[Key], turns: int) -> Exclusion | None:
        """Why no orbit of so many turns has one impact in each of these cells, or None.

        Its first flight is its longest, or one of them.
        """
        closed = [*keys, self.later(keys[0], turns)]
        cells = [self.cell(key) for key in closed]
        if len(keys) > 1:
            lengths = [b.x - a.x for a, b in pairwise(cells)]
            shorter_than_mean = len(keys) * lengths[0] < 2 * turns * arb.pi()
            if shorter_than_mean or any(length > lengths[0] for length in lengths):
                return Exclusion.ORDER
        flights = []
        for a, b in pairwise(closed):
            flight = self.between(a, b)
            if flight is Impossible:
                return Exclusion.FLIGHT
            flights.append(flight)
        for k, after in enumerate(flights):
            before = flights[k - 1]
            if not (isinstance(after, CellFlight) and isinstance(before, CellFlight)):
                continue
            if not (after.out + self.machine.r * before.into).contains(0):
                return Exclusion.IMPACT
        equations = self.newton(flights, cells[:-1])
        if equations is None:
            return None
        return _no_zero(equations, arb_mat([[cell.h] for cell in cells[:-1]]))

    def newton(
        self, flights: Sequence[FlightBounds], cells: Sequence[Cell]
    ) -> ImpactEquations | None:
        """The equations of the impacts in some cells, None where they are not known.

        flights: flight k leads from cell k to the next one, the last to the first again.
        """
        n = len(cells)
        values = arb_mat(n, 1)
        slopes = arb_mat(n, n)
        r = self.machine.r
        for k, after in enumerate(flights):
            before = flights[k - 1]
            if not (isinstance(after, CellFlight) and isinstance(before, CellFlight)):
                return None
            if after.detail is None or before.detail is None:
                return None
            after_slopes = after.detail.slopes
            before_slopes = before.detail.slopes
            values[k, 0] = after.detail.middle.out + r * before.detail.middle.into
            slopes[k, (k - 1) % n] += r * before_slopes.into_by_start
            slopes[k, k] += r * before_slopes.into_by_landing + after_slopes.out_by_start
            slopes[k, (k + 1) % n] += after_slopes.out_by_landing
        return ImpactEquations(values, slopes)

    def at(self, cells: Sequence[Cell], turns: int) -> CheckedCells | None:
        """The equations in some cells, of an orbit of so many turns; None where not known."""
        later = cells[0].index + turns * self.count
        closed = [*cells, Cell(self.machine.stretches, later, cells[0].in_turn)]
        flights = [self.flight(a, b) for a, b in pairwise(closed)]
        equations = self.newton(flights, cells)
        if equations is None:
            return None
        rates = [flight.out for flight in flights if isinstance(flight, CellFlight)]
        return CheckedCells(equations, rates)

    def alone(self, keys: Sequence[Key], turns: int, phases: Sequence[arb]) -> bool:
        """Whether E has at most one zero in some cells together with phases near them.

        phases: within the turn, one for each cell. There is at most one where the sums of the rows
        of |Y E' - 1| are below one, with Y near the inverse of E'.
        """
        wide = [
            Cell(self.machine.stretches, key.stretch, self.cell(key).in_turn.union(phase))
            for key, phase in zip(keys, phases, strict=True)
        ]
        checked = self.at(wide, turns)
        if checked is None:
            return False
        slopes = checked.equations.slopes
        try:
            off = slopes.mid().inv().mid() * slopes - identity(len(keys))
        except ZeroDivisionError:
            return False
        columns = range(len(keys))
        sums = [sum((abs(off[row, j]) for j in columns), arb(0)) for row in range(len(keys))]
        return all(total < 1 for total in sums)


def _no_zero(equations: ImpactEquations, off: arb_mat) -> Exclusion | None:
    """Why the equations have no zero in the cells, or None.

    off: column of what the phases may differ from the cells' middles. By the mean value theorem E
    may not be zero there, or an interval Newton step leads out of the cells.
    """
    values, slopes = equations
    if not all(x.contains(0) for x in (values + slopes * off).entries()):
        return Exclusion.IMPACT
    try:
        inverse = slopes.mid().inv().mid()
    except ZeroDivisionError:
        return None
    image = (identity(values.nrows()) - inverse * slopes) * off - inverse * values
    pairs = zip(image.entries(), off.entries(), strict=True)
    return None if all(x.overlaps(y) for x, y in pairs) else Exclusion.NEWTON
