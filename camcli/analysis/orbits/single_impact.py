"""All orbits with one impact, in every region of the cam, by one scalar equation.

As in Shaw & Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983) 129.

A flight of s = 2 pi m rad from theta with q = c, w = c_theta + v comes back to q = c and meets the
reset map v = -r u where, with F = G + W^2 c and the flow's B, B', P over s,
    w = F P/B,    h(theta) = K F - (1 + r) B c_theta = 0,    K = P (1 + r B') - r B^2.
Undamped and without load that is c = (1 + r)/(1 - r) cot(m pi W) c_theta/W. On a stretch h is as
smooth as the cam, so bounds of c_thetatheta and c''' isolate every root: none is missed.
"""

from __future__ import annotations

from collections.abc import Iterator

from camcli.analysis.bracketing import bracket
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.kernel.cam_table import TURN, lift
from camcli.kernel.flow import constants_of, flow

ROUNDING = 1e-15
FOCUS = 1e-6  # B over the flight's length below which v is not taken from it
NARROWEST = 1e-13  # rad: closer roots count as one, on the verge of a fold


def single_impact_roots(shooter: Shooter, value: float, turns: int) -> list[Root]:
    """Every orbit of `turns` turns with one impact at this parameter value, virtual ones too."""
    equation = _Equation(shooter, value, turns)
    found = []
    for i in range(len(shooter.system.cam.stretches)):
        for theta in equation.roots(i):
            v = equation.rate(i, theta)
            root = shooter.at_value([theta, v, value], (i, 0), turns, value)
            if root is not None and abs(root.theta[0] - theta) < 1e-6:
                found.append(root)
    return found


class _Equation:
    """h(theta) at one value of the parameter."""

    def __init__(self, shooter: Shooter, value: float, turns: int):
        self.cam = shooter.system.cam
        self.const = const = constants_of(shooter.at(value), 0.0, 0)
        self.r, self.reach = const.r, TURN * turns
        self.B, self.slope_b, self.P = flow(const, self.reach)
        self.K = self.P * (1.0 + const.r * self.slope_b) - const.r * self.B * self.B
        self.turn = (1.0 + const.r) * self.B

    def rate(self, i: int, theta: float) -> float:
        """Outgoing relative rate of the orbit that impacts at theta, m/rad."""
        c, c1, _ = lift(self.cam, i, theta)
        force = self.const.G + self.const.W2 * c
        if abs(self.B) > FOCUS * self.reach:
            return force * self.P / self.B - c1
        # after half a natural period every flight is back, whatever its v: the reset map tells
        return self.r * (c1 * (1.0 - self.slope_b) + force * self.B) / (1.0 + self.r * self.slope_b)

    def h(self, i: int, theta: float) -> float:
        c, c1, _ = lift(self.cam, i, theta)
        return self.K * (self.const.G + self.const.W2 * c) - self.turn * c1

    def roots(self, i: int) -> Iterator[float]:
        """Every zero of h on stretch i, ends included, in ascending order."""
        if self.B == 0.0 and 1.0 + self.r * self.slope_b == 0.0:
            return
        stretch = self.cam.stretches[i]
        accel = max(abs(stretch.accel_min), abs(stretch.accel_max))
        bend = abs(self.K) * self.const.W2 * accel + abs(self.turn) * stretch.jerk_max
        yield from self._within(i, stretch.start, stretch.end, bend)

    def _within(self, i: int, low: float, high: float, bend: float) -> Iterator[float]:
        """The zeros between two angles; `bend` bounds |h''|."""
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        c, c1, c2 = lift(self.cam, i, middle)
        h, slope = self.h(i, middle), self.K * self.const.W2 * c1 - self.turn * c2
        force = abs(self.const.G) + abs(self.const.W2 * c)
        size = (abs(self.P) + self.B * self.B) * force + abs(self.turn * c1)  # of the terms of h
        change = abs(slope) * half + 0.5 * bend * half * half
        if abs(h) > change or abs(h) + change <= ROUNDING * size:
            return  # no zero, or nothing but zeros: a dwell on which any phase would do
        if abs(slope) <= bend * half and half >= NARROWEST:
            yield from self._within(i, low, middle, bend)
            yield from self._within(i, middle, high, bend)
        elif abs(slope) <= bend * half:
            yield middle
        else:  # h is monotone; a zero at the upper end is the next interval's
            before, after = self.h(i, low), self.h(i, high)
            if before == 0.0:
                yield low
            elif (before < 0.0) != (after < 0.0) and after != 0.0:
                sign = 1.0 if before < 0.0 else -1.0
                ends = bracket(
                    lambda x: sign * self.h(i, x), low, high, sign * before, sign * after
                )
                yield 0.5 * (ends[0] + ends[1])
