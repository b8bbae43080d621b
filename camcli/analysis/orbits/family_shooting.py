"""Newton's method for an orbit and a number that the cam depends on.

The equations are those of `kernel.shooting`, and so are their residuals and matrices, always on the
cam that is compiled at the number's current value: what converges is exact for that cam. The column
of the number is the difference of the residuals on two cams near it, at the same phases and rates.
It only steers, so the cams that Newton's method comes by do for it, as in the secant method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from camcli.analysis.integrate import spend
from camcli.errors import NoMachineError
from camcli.kernel.bordered import (
    BLOCK,
    RESIDUAL,
    RIGHT,
    Tables,
    put_pair,
    solve_bordered,
    tables_for,
)
from camcli.kernel.cam_table import Cam, restitution_at
from camcli.kernel.flow import Constants, constants_of
from camcli.kernel.shooting import (
    CONVERGED,
    LONGEST_STEP,
    MOST_STEPS,
    NO_TRACE,
    STALLED,
    Border,
    arrival,
    fill_block,
    rates_and_trace,
    take_step,
    within_reach,
)
from camcli.system import CONSTANTS, System

COMPILING = 50_000  # evaluations of the gap that take as long as compiling a cam: 5 to 15 ms
DIFFERENCE = 1e-5  # distance of a second cam where there is none near, of the number's range
APART = (
    1e-7  # least distance of the two cams, of the number's range: nearer ones differ by rounding
)
STEERS = 0.02  # of the range: so far away a cam still gives the direction
EPSILON = 2.0**-53  # relative, one rounding
ROUNDINGS = 8.0  # of the terms of a residual
REMEMBERED = 12  # cams used last, among which the two are chosen


class FamilyMachine(NamedTuple):
    """The machine at a value of the number.

    machine: the kernel's table with the family's values behind it; constants, cam: what follows.
    """

    value: float
    machine: tuple[float, ...]
    constants: Constants
    cam: Cam


@dataclass(frozen=True)
class Solved:
    """A root; its numbers mean what those of `shooter.Root` of the same name mean."""

    x: list[float]
    machine: tuple[float, ...]
    rates: list[float]
    tangent: list[float]
    trace: float
    step: float
    steps: int


class Sides(NamedTuple):
    """Two machines near a value of the number."""

    low: FamilyMachine
    high: FamilyMachine

    @property
    def width(self) -> float:
        """By how much the number differs."""
        return self.high.value - self.low.value


# The last equation of a Newton step from x, at a machine and between two near it: its (factors of
# the step, right side).
LastEquation = Callable[[Sequence[float], FamilyMachine, Sides], tuple[Sequence[float], float]]


class FamilyShooting:
    """The equations over one number of a family.

    machine: where the other numbers and the constants are; place: index of the number in it; scale
    and rate: sizes of the number and of a rate below which changes count as absolute.
    """

    def __init__(
        self, system: System, machine: Sequence[float], place: int, scale: float, rate: float
    ):
        assert system.member is not None
        self.system = system
        self.family = system.member.family
        self.machine = tuple(machine)
        self.place = place
        self.scale = scale
        self.rate = rate
        low, high = self.family.ranges[place - CONSTANTS]
        self.range = high - low
        self._recent: list[FamilyMachine] = []  # the last ones used

    def at(self, value: float) -> FamilyMachine:
        """The machine at a value of the number; raises NoMachineError where there is none."""
        machine = list(self.machine)
        machine[self.place] = value
        before = self.family.compiled
        try:
            moved = self.family.moved(machine, machine[CONSTANTS:])
        finally:
            spend(COMPILING * (self.family.compiled - before))
        return FamilyMachine(value, moved, constants_of(moved, 0.0, 0), self.system.at(moved).cam)

    def reach(self, end: float) -> tuple[float, str]:
        """How far from its own value towards `end` there is a machine, and what ends it, or ""."""
        before = self.family.compiled
        values = self.machine[CONSTANTS:]
        try:
            return self.family.reach(self.place - CONSTANTS, values, end)
        finally:
            spend(COMPILING * (self.family.compiled - before))

    def sides(self, here: FamilyMachine) -> Sides | None:
        """Two machines near one another, for a derivative; None where there is only one.

        One is `here`, which is remembered; the other the nearest of those used last if it is near
        enough to give the direction, else a new one.
        """
        least = APART * self.range
        apart = [one for one in self._recent if abs(one.value - here.value) >= least]
        other = min(apart, key=lambda one: abs(one.value - here.value), default=None)
        if other is None or abs(other.value - here.value) > STEERS * self.range:
            other = self._beside(here.value)
        others = [one for one in self._recent if one.value != here.value]
        self._recent = [here, *others][:REMEMBERED]
        if other is None:
            return None
        low, high = sorted((here, other), key=lambda one: one.value)
        return Sides(low, high)

    def _beside(self, value: float) -> FamilyMachine | None:
        """A machine beside a value, above it where there is one."""
        for width in (DIFFERENCE * self.range, -DIFFERENCE * self.range):
            try:
                return self.at(value + width)
            except NoMachineError:
                continue
        return None

    def correct(
        self, guess: Sequence[float], whole: Sequence[int], turns: int, last: LastEquation
    ) -> Solved | None:
        """The root near `guess`, or None where Newton fails or leaves the family.

        guess: phases, rates and the number; whole: stretch and turn of each impact; last: what
        fixes the number, see `border`.
        """
        n = len(whole) // 2
        x = [float(value) for value in guess]
        tables = tables_for(n, lambda count: [0.0] * count)
        size_before = 1e300
        try:
            for steps in range(1, MOST_STEPS + 1):
                here = self.at(x[-1])
                if not within_reach(here.cam, n, whole, x):
                    return None
                sides = self.sides(here)
                if sides is None:
                    return None
                self._fill(here, sides, x, whole, turns, tables)
                row, right = last(x, here, sides)
                if not solve_bordered(n, tables, row, right):
                    return None
                size = take_step(n, x, tables, Border(row, x, right, self.scale, self.rate))
                if not size < LONGEST_STEP:
                    return None
                if abs(x[-1] - here.value) <= EPSILON * max(abs(here.value), self.scale):
                    x[-1] = here.value  # no other cam for a rounding
                stalled = size <= STALLED and size > 0.5 * size_before
                if size <= CONVERGED or stalled:
                    return self._solved(x, whole, turns, tables, size, steps)
                size_before = size
        except NoMachineError:
            pass
        return None

    def rounding(
        self, x: Sequence[float], whole: Sequence[int], turns: int, row: Sequence[float]
    ) -> float:
        """By how much rounding may have moved the number at a root, across the direction `row`."""
        here = self.at(x[-1])
        sides = self.sides(here)
        if sides is None:
            return 0.0
        tables = tables_for(len(whole) // 2, lambda count: [0.0] * count)
        self._fill(here, sides, x, whole, turns, tables)
        return rounding_of_last(here.cam, x, tables, row)

    def _fill(
        self,
        here: FamilyMachine,
        sides: Sides,
        x: Sequence[float],
        whole: Sequence[int],
        turns: int,
        tables: Tables,
    ) -> None:
        """Fill in the blocks of every flight at x, and the column of the number.

        The column is the difference of the residuals on the two sides: gap where the flight ends,
        and rate times restitution.
        """
        n = len(whole) // 2
        low = sides.low
        high = sides.high
        for k in range(n):
            fill_block(here.cam, here.constants, x, whole, turns, k, n, tables.blocks)
            gap_high, rate_high = arrival(high.cam, high.constants, x, whole, turns, k, n)
            gap_low, rate_low = arrival(low.cam, low.constants, x, whole, turns, k, n)
            landed_on = whole[2 * ((k + 1) % n)]
            rebound = restitution_at(high.cam, high.constants, landed_on) * rate_high
            rebound -= restitution_at(low.cam, low.constants, landed_on) * rate_low
            tables.columns[2 * k] = (gap_high - gap_low) / sides.width
            tables.columns[2 * k + 1] = rebound / sides.width

    def _solved(
        self,
        x: list[float],
        whole: Sequence[int],
        turns: int,
        tables: Tables,
        step: float,
        steps: int,
    ) -> Solved | None:
        """What a root has beside its unknowns; None where an impact has no rate.

        step: size of the last Newton step; steps: how many were taken.
        """
        n = len(whole) // 2
        here = self.at(x[-1])
        rates = [0.0] * n
        trace = rates_and_trace(here.cam, here.machine, n, turns, whole, x, rates)
        if not trace < NO_TRACE:
            return None
        return Solved(x, here.machine, rates, list(tables.tangent), trace, step, steps)


def rounding_of_last(cam: Cam, x: Sequence[float], tables: Tables, row: Sequence[float]) -> float:
    """By how much rounding may have moved the last unknown at a root, across the direction `row`.

    tables: those of Newton's step at the root. Every residual is a sum of lifts and rates, known to
    some roundings of the largest of them: `noise`. Newton's step is solved for each residual on its
    own, with that noise for its value and zero for the others, and their last entries are added.
    """
    n = len(x) // 2
    lifts = [cam.top, *(stretch.c_min for stretch in cam.stretches)]
    outgoing = x[1:-1:2]
    # the slope of the gap at a landing by its phase is the rate there
    incoming = [tables.blocks[BLOCK * k + RIGHT] for k in range(n)]
    noise = ROUNDINGS * EPSILON * max(map(abs, [*lifts, *outgoing, *incoming]))
    total = 0.0
    for flight in range(n):
        for residuals in ((noise, 0.0), (0.0, noise)):  # of the gap, and of the rate
            for k in range(n):
                values = residuals if k == flight else (0.0, 0.0)
                put_pair(tables.blocks, BLOCK * k + RESIDUAL, *values)
            if solve_bordered(n, tables, row, 0.0):
                total += abs(tables.step[-1])
    return total


def border(row: Sequence[float], origin: Sequence[float], right: float) -> LastEquation:
    """The last equation row (x - origin) = right, as one for a step from x."""

    def equation(
        x: Sequence[float], here: FamilyMachine, sides: Sides
    ) -> tuple[Sequence[float], float]:
        rest = right
        for factor, value, start in zip(row, x, origin, strict=True):
            rest -= factor * (value - start)
        return row, rest

    return equation


def on_edge(k: int, stretch: int, side: int) -> LastEquation:
    """The last equation that puts impact k at an end of a stretch, wherever the cam has it.

    side: 1 at the end, -1 at the start.
    """

    def edge(member: FamilyMachine) -> float:
        """The phase of that end, rad."""
        on_cam = member.cam.stretches[stretch]
        return on_cam.end if side > 0 else on_cam.start

    def equation(
        x: Sequence[float], here: FamilyMachine, sides: Sides
    ) -> tuple[Sequence[float], float]:
        row = [0.0] * len(x)
        row[2 * k] = 1.0
        row[-1] = -(edge(sides.high) - edge(sides.low)) / sides.width
        return row, edge(here) - x[2 * k]

    return equation
