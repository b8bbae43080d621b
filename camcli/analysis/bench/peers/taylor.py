"""heyoka's Taylor integrator with terminal events, one event for each form of region of the cam.

The machine enters by parameters, so an integrator is compiled once per cam and tolerance.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

from camcli.analysis.bench.peers.legs import At, Leg, Legs
from camcli.analysis.bench.peers.lifts import FLANK, NOSE, ROUND, TWO_PI, WAVE
from camcli.analysis.bench.peers.world import Trace, World, follow

POSITION, GAP = "position", "gap"
CLEAR = 0.02  # m above the top of the cam: no contact up there
STOPPED = -1  # outcome of a propagation that its terminal event ended
SHORT = 1e-4  # turns flown without events where the follower is pulled off the cam
SKY = "sky"
OMEGA, ANGLE, K, B, LOAD, FIRST, SECOND, OFFSET = range(8)  # parameters


def _symbolic(hy: Any, form: str, coordinates: str):
    """Equations of motion and gap of a flight over one form of region."""
    z, w, x = hy.make_vars("z", "w", "x")
    par = hy.par
    angle = par[OMEGA] * hy.time + par[ANGLE]
    if form in (FLANK, NOSE):
        sin = par[FIRST] * hy.sin(x)
        c = par[FIRST] * hy.cos(x) + hy.sqrt(par[SECOND] * par[SECOND] - sin * sin) - par[OFFSET]
    elif form == WAVE:
        c = par[FIRST] - par[SECOND] * hy.cos(x)
    else:
        c = par[FIRST] + 0.0 * x
    force = -par[K] * z - par[B] * w - par[LOAD]
    if coordinates == POSITION:
        height = par[FIRST] if form in (ROUND, SKY) else hy.subs(c, {x: angle})
        return [(z, w), (w, force)], z - height
    if form == ROUND:
        return [(z, w), (w, force - par[K] * par[FIRST])], z
    slope = hy.diff(c, x)
    bend = hy.diff(slope, x)
    pushed = -par[K] * c - par[B] * par[OMEGA] * slope - par[OMEGA] * par[OMEGA] * bend
    return [(z, w), (w, force + hy.subs(pushed, {x: angle}))], z


@cache
def compiled(form: str, coordinates: str, armed: bool, tolerance: float) -> tuple:
    """An integrator with views of its state and parameters."""
    import heyoka as hy

    system, gap = _symbolic(hy, form, coordinates)
    event = hy.t_event(gap, direction=hy.event_direction.negative)
    ta = hy.taylor_adaptive(system, [0.0, 0.0], tol=tolerance, t_events=[event] * armed)
    return ta, ta.state, ta.pars


class Flights(Legs):
    """Flights region by region of the cam."""

    def __init__(self, world: World, tolerance: float):
        super().__init__(world)
        self.tolerance = tolerance
        self.ceiling = world.lift.top + CLEAR

    def _in_position(self, at: At) -> Leg:
        """Integrate (q, v) to the contact, to the end of the turn or over the top."""
        lift, turn, theta = self.world.lift, at.turn, at.theta
        (z, w), hit = self.absolute(at), False
        if at.y <= 0.0:
            part = at.fall / 16.0
            theta, z, w, hit = self._run(
                POSITION, False, lift.region(theta), turn, theta, (z, w), part
            )
        last = min(TWO_PI, self.end(turn))
        while not hit and z <= self.ceiling and theta < last:
            index = lift.region(theta)
            theta, z, w, hit = self._run(POSITION, True, index, turn, theta, (z, w), math.inf)
        if not hit and z > self.ceiling and theta < last:
            return self._in_sky(turn, theta, z, w)
        y, u = self.relative(theta, z, w)
        return Leg(theta, 0.0 if hit else y, u, hit)

    def _in_sky(self, turn: int, theta: float, z: float, w: float) -> Leg:
        """Integrate above the whole cam, for a turn at most."""
        world = self.world
        ta, state, pars = compiled(SKY, POSITION, True, self.tolerance)
        self._set(ta, state, pars, (z, w), 0.0, (self.ceiling, 0.0))
        left = world.seconds_left(turn, theta)
        outcome = ta.propagate_until(min(world.period, left))
        world.trace.evaluations += int(outcome[3])
        theta = self.end(turn) if ta.time >= left else theta + world.omega * ta.time
        return Leg(theta, *self.relative(theta, float(state[0]), float(state[1])), False)

    def _in_gap(self, at: At) -> Leg:
        """Integrate (y, u) to the contact or the next breakpoint."""
        index, end, _ = self.stretch(at)
        turn, theta, y, u = at[:4]
        if y <= 0.0:
            theta, y, u, _ = self._run(GAP, False, index, turn, theta, (y, u), at.fall / 16.0)
        if theta >= end:
            return Leg(theta, y, u, False)
        return Leg(*self._run(GAP, True, index, turn, theta, (y, u), math.inf))

    def _run(self, coordinates, armed, index, turn, theta, start, limit):
        """One integration inside a region, for `limit` seconds at most."""
        world, region = self.world, self.world.lift.regions[index]
        end = min(region.end, theta + TWO_PI, self.end(turn))
        ta, state, pars = compiled(region.form, coordinates, armed, self.tolerance)
        self._set(ta, state, pars, start, theta - region.centre, region.numbers)
        if not armed and limit == math.inf:  # pulled off: any short stretch is free of contact
            limit = SHORT * world.period
        span = (end - theta) / world.omega
        outcome = ta.propagate_until(min(span, limit))
        world.trace.evaluations += int(outcome[3])
        hit = int(outcome[0]) == STOPPED
        stop = end if span <= limit and not hit else theta + world.omega * ta.time
        return stop, float(state[0]), float(state[1]), hit

    def _set(self, ta, state, pars, start, angle: float, numbers: tuple) -> None:
        """Time, state and parameters of the next integration."""
        world = self.world
        ta.time = 0.0
        state[:] = start
        first, second = (*numbers, 0.0)[:2]
        values = (world.omega, angle, world.w2, world.b, world.load, first, second)
        pars[:] = (*values, world.lift.offset)[: len(pars)]
        if ta.with_events:
            ta.reset_cooldowns()


def available() -> bool:
    """Whether heyoka is installed; it is not imported."""
    from importlib.util import find_spec

    return find_spec("heyoka") is not None


def run(world: World, start: tuple, tolerance: float) -> Trace:
    """One run at a tolerance of the Taylor series."""
    return follow(world, Flights(world, tolerance), start)
