"""Fixed steps of the classical Runge-Kutta method, contacts by bisection of the last step."""

from __future__ import annotations

from collections.abc import Callable

from camcli.analysis.bench.peers.legs import At, Leg, Legs
from camcli.analysis.bench.peers.world import Trace, World, follow

HALVINGS = 60
PER_HOP = 8  # steps of a short flight, at least

Pair = tuple[float, float]


def step(rhs: Callable, t: float, z: Pair, h: float) -> Pair:
    """One step of the classical fourth-order method."""
    a0, a1 = rhs(t, z[0], z[1])
    b0, b1 = rhs(t + 0.5 * h, z[0] + 0.5 * h * a0, z[1] + 0.5 * h * a1)
    c0, c1 = rhs(t + 0.5 * h, z[0] + 0.5 * h * b0, z[1] + 0.5 * h * b1)
    d0, d1 = rhs(t + h, z[0] + h * c0, z[1] + h * c1)
    return (
        z[0] + h / 6.0 * (a0 + 2.0 * (b0 + c0) + d0),
        z[1] + h / 6.0 * (a1 + 2.0 * (b1 + c1) + d1),
    )


class Flights(Legs):
    """Flights of one run with a fixed number of steps per turn."""

    def __init__(self, world: World, steps: int):
        super().__init__(world)
        self.h = world.period / steps

    def _in_position(self, at: At) -> Leg:
        world, lift, omega = self.world, self.world.lift, self.world.omega
        k, b, load = world.w2, world.b, world.load

        def rhs(_t, q, v):
            return v, -k * q - b * v - load

        def gap(t, z):
            return z[0] - lift.height(at.theta + omega * t)

        span, left = self.turn_at_most(at)
        h = min(self.h, at.fall / PER_HOP)
        t, z, contact = self._advance(rhs, gap, self.absolute(at), span, h)
        theta = self.after(at, t, left, self.end(at.turn))
        y, u = self.relative(theta, *z)
        return Leg(theta, 0.0 if contact else max(y, 0.0), u, contact)

    def _in_gap(self, at: At) -> Leg:
        world, omega = self.world, self.world.omega
        k, b = world.w2, world.b
        index, stop, span = self.stretch(at)

        def rhs(t, gap, rate):
            return rate, world.pushed(index, at.theta + omega * t) - k * gap - b * rate

        h = min(self.h, at.fall / PER_HOP)
        t, z, contact = self._advance(rhs, lambda _t, z: z[0], (at.y, at.u), span, h)
        y = 0.0 if contact else max(z[0], 0.0)
        return Leg(self.after(at, t, span, stop), y, z[1], contact)

    def _advance(self, rhs: Callable, gap: Callable, z: Pair, span: float, h: float):
        """(t, z, contact): steps of h until the gap is negative or the span is over."""
        t = 0.0
        while t < span:
            self.world.check()
            size = min(h, span - t)
            if span - t - size < 1e-9 * h:
                size = span - t
            after = step(rhs, t, z, size)
            self.world.trace.evaluations += 4
            if gap(t + size, after) < 0.0:
                return (*self._landed(rhs, gap, t, z, size), True)
            t, z = (span if size == span - t else t + size), after
        return t, z, False

    def _landed(self, rhs: Callable, gap: Callable, t: float, z: Pair, size: float):
        """(t, z) where the gap closes inside a step, by bisection of its length."""
        low, high = 0.0, size
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if gap(t + middle, step(rhs, t, z, middle)) > 0.0:
                low = middle
            else:
                high = middle
        self.world.trace.evaluations += 4 * HALVINGS
        return t + high, step(rhs, t, z, high)


def run(world: World, start: tuple, steps: int) -> Trace:
    """One run with so many steps per turn."""
    return follow(world, Flights(world, steps), start)
