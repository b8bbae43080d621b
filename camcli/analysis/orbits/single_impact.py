"""All orbits with one impact, in every region of the cam, by one scalar equation.

As in Shaw & Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983) 129.

A flight of s = 2 pi m rad from theta with q = c, w = c_theta + v comes back to q = c and meets the
reset map v = -r u where, with F = G + W^2 c and the flow's B, B', P over s,
    w = F P/B,    h(theta) = K F - (1 + r) B c_theta = 0,    K = P (1 + r B') - r B^2.
Undamped and without load that is c = (1 + r)/(1 - r) cot(m pi W) c_theta/W. On a stretch h is as
smooth as the cam, so bounds of c_thetatheta and c''' isolate every root: none is missed. Where h
vanishes all over a dwell (r = 1 without damping) every phase of it is a root: a continuum.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from camcli.analysis.bracketing import bracket
from camcli.analysis.labels import Label
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.cams.regions import regions
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.flow import constants_of, flow

EQUATION_ROUNDING = 1e-15  # of the terms of h: some five ulp, below which it is zero
FOCUS = 1e-6  # B over the flight's length below which v is not taken from it
END = 1e-9  # rad from the end of a dwell at which a root of the next stretch is the dwell's own
SAME_ROOT = 1e-13  # rad: closer roots count as one, on the verge of a fold


@dataclass(frozen=True)
class Continuum:
    """Orbits of `turns` turns with one impact, at any phase from start to end (rad) of a dwell.

    None attracts: both multipliers are 1. rate: of the impact, outgoing, m/rad.
    """

    turns: int
    start: float
    end: float
    rate: float

    @property
    def label(self) -> Label:
        return Label((1.0, *[0.0] * (self.turns - 1)))

    def holds(self, theta: float) -> bool:
        """True for a phase of the dwell, its ends included."""
        return any(self.start - END <= x <= self.end + END for x in (theta, theta + TURN))


def single_impact_roots(shooter: Shooter, value: float, turns: int) -> list[Root]:
    """Every isolated orbit of `turns` turns with one impact at this value, virtual ones too.

    value: of the parameter. Zeros of h on a dwell of orbits are left out.
    """
    equation = _Equation(shooter, value, turns)
    dwells = equation.dwells()
    solved = []
    for i in range(len(shooter.system.cam.stretches)):
        for theta in equation.roots(i):
            if any(dwell.holds(theta) for dwell in dwells):
                continue
            v = equation.rate(i, theta)
            root = shooter.at_value([theta, v, value], (i, 0), turns, value)
            if root is not None and abs(root.theta[0] - theta) < 1e-6:
                solved.append(root)
    return solved


def continua(shooter: Shooter, value: float, turns: int) -> Iterator[Continuum]:
    """The dwells on which every phase is an orbit: the one in the middle is a motion.

    value: of the parameter.
    """
    equation = _Equation(shooter, value, turns)
    for dwell in equation.dwells():
        theta = 0.5 * (dwell.start + dwell.end) % TURN
        i = stretch_at(shooter.system.cam, theta)
        middle = Root(
            x=[theta, dwell.rate, value],
            whole=(i, 0),
            turns=turns,
            machine=shooter.at(value),
            parameter=shooter.parameter,
            rates=[-dwell.rate / equation.of_stretch(i).r],
            tangent=[1.0, 0.0, 0.0],
            trace=2.0,
            step=0.0,
            steps=0,
            seat=shooter.seat,
        )
        if dwell.rate > 0.0 and shooter.admits(middle):
            yield dwell


class _Factors(NamedTuple):
    """Of the equation h = by_force F - by_slope c_theta, where a stretch with restitution r is hit.

    by_force: K; by_slope: (1 + r) B.
    """

    r: float
    by_force: float
    by_slope: float


class _Terms(NamedTuple):
    """h at a phase, its slope by the phase, and the size of the terms that h is the sum of."""

    h: float
    slope: float
    size: float


class _Equation:
    """h(theta) at one value of the parameter, for orbits of so many turns; see the file's head."""

    def __init__(self, shooter: Shooter, value: float, turns: int):
        self.cam = shooter.system.cam
        self.const = constants_of(shooter.at(value), 0.0, 0)
        self.turns = turns
        self.flight_length = TURN * turns
        self.B, self.B1, self.P = flow(self.const, self.flight_length)
        self.on_cam = self._factors(self.const.r)
        self.on_seat = self._factors(self.const.r_seat)

    def _factors(self, r: float) -> _Factors:
        """The factors for a restitution."""
        by_force = self.P * (1.0 + r * self.B1) - r * self.B * self.B
        return _Factors(r, by_force, by_slope=(1.0 + r) * self.B)

    @property
    def focused(self) -> bool:
        """Whether B is zero but for rounding: every flight from a phase comes back to one place."""
        return not abs(self.B) > FOCUS * self.flight_length

    def of_stretch(self, i: int) -> _Factors:
        """The factors where stretch i is hit."""
        return self.on_seat if self.cam.stretches[i].seat else self.on_cam

    def rate(self, i: int, theta: float) -> float:
        """Outgoing relative rate of the orbit that impacts at theta on stretch i, m/rad."""
        c, c1, _ = lift(self.cam, i, theta)
        force = self.const.G + self.const.W2 * c
        if not self.focused:
            return force * self.P / self.B - c1
        # after half a natural period every flight is back, whatever its v: the reset map tells
        r = self.of_stretch(i).r
        return r * (c1 * (1.0 - self.B1) + force * self.B) / (1.0 + r * self.B1)

    def h(self, i: int, theta: float) -> float:
        """h at a phase on stretch i."""
        c, c1, _ = lift(self.cam, i, theta)
        factors = self.of_stretch(i)
        force = self.const.G + self.const.W2 * c
        return factors.by_force * force - factors.by_slope * c1

    def _terms(self, i: int, theta: float) -> _Terms:
        """h and what tells a zero of it, at a phase on stretch i."""
        factors = self.of_stretch(i)
        c, c1, c2 = lift(self.cam, i, theta)
        force_size = abs(self.const.G) + abs(self.const.W2 * c)
        return _Terms(
            h=self.h(i, theta),
            slope=factors.by_force * self.const.W2 * c1 - factors.by_slope * c2,
            size=(abs(self.P) + self.B * self.B) * force_size + abs(factors.by_slope * c1),
        )

    def dwells(self) -> list[Continuum]:
        """The regions of the cam at one level on which h vanishes to rounding."""
        if self.focused:
            return []
        dwells = []
        for region in regions(self.cam):
            stretches = [self.cam.stretches[i] for i in region.stretches]
            level = all(
                stretch.start_c1 == stretch.accel_min == stretch.accel_max == 0.0
                for stretch in stretches
            )
            first = region.stretches[0]
            begin = stretches[0].start
            terms = self._terms(first, begin)
            if level and abs(terms.h) <= EQUATION_ROUNDING * terms.size:
                rate = self.rate(first, begin)
                dwells.append(Continuum(self.turns, region.start, region.end, rate))
        return dwells

    def roots(self, i: int) -> Iterator[float]:
        """Every zero of h on stretch i, ends included, in ascending order."""
        factors = self.of_stretch(i)
        if self.focused and 1.0 + factors.r * self.B1 == 0.0:
            return  # no finite rate of impact repeats: r = 1 after half a natural period
        stretch = self.cam.stretches[i]
        accel = max(abs(stretch.accel_min), abs(stretch.accel_max))  # |c''|
        bend = abs(factors.by_force) * self.const.W2 * accel
        bend += abs(factors.by_slope) * stretch.jerk_max
        yield from self._within(i, stretch.start, stretch.end, bend)

    def _within(self, i: int, low: float, high: float, bend: float) -> Iterator[float]:
        """The zeros between two angles; `bend` bounds |h''|.

        Halves are searched until h is known to have no zero, or to be monotonic.
        """
        middle = 0.5 * (low + high)
        half = 0.5 * (high - low)
        h, slope, size = self._terms(i, middle)
        change = abs(slope) * half + 0.5 * bend * half * half
        if abs(h) > change or abs(h) + change <= EQUATION_ROUNDING * size:
            return  # no zero, or nothing but zeros: a dwell on which any phase would do
        monotonic = not abs(slope) <= bend * half
        if not monotonic and half >= SAME_ROOT:
            yield from self._within(i, low, middle, bend)
            yield from self._within(i, middle, high, bend)
        elif not monotonic:
            yield middle
        else:  # a zero at the upper end is the next interval's
            at_low = self.h(i, low)
            at_high = self.h(i, high)
            if at_low == 0.0:
                yield low
            elif (at_low < 0.0) != (at_high < 0.0) and at_high != 0.0:
                sign = 1.0 if at_low < 0.0 else -1.0
                below, above, *_ = bracket(
                    lambda x: sign * self.h(i, x), low, high, sign * at_low, sign * at_high
                )
                yield 0.5 * (below + above)
