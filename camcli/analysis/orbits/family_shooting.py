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
from camcli.kernel.bordered import BLOCK, RESIDUAL, RIGHT, put_pair, solve_bordered, tables_for
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
ROUNDINGS, EPSILON = 8.0, 2.0**-53  # of the terms of a residual; and one of them
REMEMBERED = 12  # cams used last, among which the two are chosen


class Place(NamedTuple):
    """A value of the number: the kernel's table with the family's values behind it, and the cam."""

    value: float
    machine: tuple[float, ...]
    constants: Constants
    cam: Cam


@dataclass(frozen=True)
class Solved:
    """A root as `shooter.Root` has it."""

    x: list[float]
    machine: tuple[float, ...]
    rates: list[float]
    tangent: list[float]
    trace: float
    step: float
    steps: int


class Sides(NamedTuple):
    """Two machines near a value of the number."""

    low: Place
    high: Place

    @property
    def width(self) -> float:
        return self.high.value - self.low.value


LastEquation = Callable[[Sequence[float], Place, Sides], tuple[Sequence[float], float]]


class FamilyShooting:
    """The equations over one number of a family.

    machine: where the other numbers and the constants are; place: of the number in it; scale and
    rate: sizes of the number and of a rate below which changes count as absolute.
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
        self._near: list[Place] = []  # the last ones used

    def at(self, value: float) -> Place:
        """The machine at a value of the number; raises NoMachineError where there is none."""
        machine = list(self.machine)
        machine[self.place] = value
        before = self.family.compiled
        try:
            moved = self.family.moved(machine, machine[CONSTANTS:])
        finally:
            spend(COMPILING * (self.family.compiled - before))
        return Place(value, moved, constants_of(moved, 0.0, 0), self.system.at(moved).cam)

    def reach(self, end: float) -> tuple[float, str]:
        """How far from its own value towards `end` there is a machine, and what ends it, or ""."""
        before = self.family.compiled
        values = self.machine[CONSTANTS:]
        try:
            return self.family.reach(self.place - CONSTANTS, values, end)
        finally:
            spend(COMPILING * (self.family.compiled - before))

    def sides(self, here: Place) -> Sides | None:
        """Two machines near one another, for a derivative; None where there is only one."""
        least = APART * self.range
        far = [one for one in self._near if abs(one.value - here.value) >= least]
        other = min(far, key=lambda one: abs(one.value - here.value), default=None)
        if other is None or abs(other.value - here.value) > STEERS * self.range:
            other = self._beside(here.value)
        self._near = [here, *(one for one in self._near if one.value != here.value)][:REMEMBERED]
        if other is None:
            return None
        return Sides(*sorted((here, other), key=lambda one: one.value))

    def _beside(self, value: float) -> Place | None:
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

        last: factors and right side of the last equation for a step from x; see `border`.
        """
        n = len(whole) // 2
        x = [float(value) for value in guess]
        t = tables_for(n, lambda count: [0.0] * count)
        before = 1e300
        try:
            for count in range(1, MOST_STEPS + 1):
                here = self.at(x[-1])
                if not within_reach(here.cam, n, whole, x):
                    return None
                sides = self.sides(here)
                if sides is None:
                    return None
                self._fill(here, sides, x, whole, turns, n, t)
                row, right = last(x, here, sides)
                if not solve_bordered(n, t, row, right):
                    return None
                size = take_step(n, x, t, Border(row, x, right, self.scale, self.rate))
                if not size < LONGEST_STEP:
                    return None
                if abs(x[-1] - here.value) <= EPSILON * max(abs(here.value), self.scale):
                    x[-1] = here.value  # no other cam for a rounding
                if size <= CONVERGED or (size <= STALLED and size > 0.5 * before):
                    return self._solved(x, whole, turns, n, t.tangent, size, count)
                before = size
        except NoMachineError:
            pass
        return None

    def rounding(
        self, x: Sequence[float], whole: Sequence[int], turns: int, row: Sequence[float]
    ) -> float:
        """By how much rounding may have moved the number at a root, across the direction `row`.

        Every residual is a sum of lifts and rates, known to some roundings of the largest of them;
        Newton's step says what each of these is in the number.
        """
        n = len(whole) // 2
        here = self.at(x[-1])
        sides = self.sides(here)
        t = tables_for(n, lambda count: [0.0] * count)
        if sides is None:
            return 0.0
        self._fill(here, sides, x, whole, turns, n, t)
        sizes = [here.cam.top, *(stretch.c_min for stretch in here.cam.stretches), *x[1:-1:2]]
        sizes += [t.blocks[BLOCK * k + RIGHT] for k in range(n)]  # incoming rates
        noise = ROUNDINGS * EPSILON * max(map(abs, sizes))
        total = 0.0
        for k in range(2 * n):
            for j in range(n):
                put_pair(t.blocks, BLOCK * j + RESIDUAL, 0.0, 0.0)
            t.blocks[BLOCK * (k // 2) + RESIDUAL + k % 2] = noise
            if solve_bordered(n, t, row, 0.0):
                total += abs(t.step[-1])
        return total

    def _fill(self, here: Place, sides: Sides, x, whole, turns: int, n: int, t) -> None:
        """The blocks of every flight at x, and its column of the number."""
        low, high = sides.low, sides.high
        for k in range(n):
            fill_block(here.cam, here.constants, x, whole, turns, k, n, t.blocks)
            gap, u = arrival(high.cam, high.constants, x, whole, turns, k, n)
            other, rate = arrival(low.cam, low.constants, x, whole, turns, k, n)
            i = whole[2 * ((k + 1) % n)]
            rebound = restitution_at(high.cam, high.constants, i) * u
            rebound -= restitution_at(low.cam, low.constants, i) * rate
            t.columns[2 * k] = (gap - other) / sides.width
            t.columns[2 * k + 1] = rebound / sides.width

    def _solved(
        self, x: list[float], whole, turns: int, n: int, tangent, size: float, count: int
    ) -> Solved | None:
        """What a root has beside its unknowns; None where an impact has no rate."""
        here = self.at(x[-1])
        rates = [0.0] * n
        trace = rates_and_trace(here.cam, here.machine, n, turns, whole, x, rates)
        if not trace < NO_TRACE:
            return None
        return Solved(x, here.machine, rates, list(tangent), trace, size, count)


def border(row: Sequence[float], origin: Sequence[float], right: float) -> LastEquation:
    """The last equation row (x - origin) = right."""

    def equation(x: Sequence[float], here: Place, sides: Sides) -> tuple[Sequence[float], float]:
        rest = right
        for factor, value, start in zip(row, x, origin, strict=True):
            rest -= factor * (value - start)
        return row, rest

    return equation


def on_edge(k: int, stretch: int, side: int) -> LastEquation:
    """Impact k is at the end (side 1) or the start (-1) of a stretch, wherever the cam has it."""

    def edge(place: Place) -> float:
        one = place.cam.stretches[stretch]
        return one.end if side > 0 else one.start

    def equation(x: Sequence[float], here: Place, sides: Sides) -> tuple[Sequence[float], float]:
        row = [0.0] * len(x)
        row[2 * k] = 1.0
        row[-1] = -(edge(sides.high) - edge(sides.low)) / sides.width
        return row, edge(here) - x[2 * k]

    return equation
