"""A motion computed once more: closed-form flights in 30 digits, contacts from dense samples.

It is slow, and meant for machines whose flights are not grazes: a contact is looked for at every
half degree, and a short hop where its parabola lands. Nothing comes from the package.
"""

from __future__ import annotations

from bisect import bisect, bisect_left
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf
from scipy.optimize import brentq

from tests.support.mechanics import EDGE, TURN, Flight, Machine

DIGITS = 30
SHORT, CLOSED = 2e-3, 1e-12  # rad: hops whose parabola is a guess; shorter ones are a chatter's end
STEP = TURN / 720


class Event(NamedTuple):
    """at: rad since the strobe that begins turn 0; theta: cam angle, rad; u: relative, m/s."""

    kind: str
    at: float
    theta: float
    q: float
    u_minus: float
    u_plus: float


class Part(NamedTuple):
    """A flight or a rest from `at` on: cam angle (rad), position and velocity there."""

    at: float
    theta: float
    q: float
    v: float
    rests: bool


class Motion:
    """The motion of a machine over so many turns after the strobe, from rest at begin_deg.

    Or from (q, v) there. `events` in order, `parts` as the state goes on from each.
    """

    def __init__(self, machine: Machine, turns: int, begin_deg: float = 0.0, q=None, v=None):
        """Follow a machine for some turns, from rest on the cam where q (m) or v is None."""
        self.machine, self.turns = machine, turns
        with mp.workdps(DIGITS):
            self.omega = mpf(machine.rpm) * mp.pi / 30
            self.parts: list[Part] = []
            self._last = (None, None)  # (theta, what `_cam` gave for it)
            self.events = list(self._run(begin_deg, q, v))

    def state(self, at: float, before: bool = False) -> tuple[float, float, bool]:
        """(q, v, whether it rests) so many rad after the strobe; at an event just after it."""
        begins = [one.at for one in self.parts]
        part = self.parts[max((bisect_left if before else bisect)(begins, at) - 1, 0)]
        theta, t = part.theta + at - part.at, (at - part.at) / self.machine.omega
        if part.rests:
            c, c1, _ = self.machine.cam(theta)[:, 0]
            return c, c1, True
        q, v = self.machine.flow(t, part.q, part.v)
        return float(q), float(v), False

    def _run(self, begin_deg, q, v) -> Iterator[Event]:
        """The events in order; the parts between them are gathered in `parts`.

        A motion rests on the cam until the force falls to zero, or flies until the gap closes. A
        chatter whose next hop is shorter than CLOSED is ended by its geometric series. All of it is
        in radians; the time `at` counts from the first strobe, below zero before it.
        """
        machine, r = self.machine, mpf(self.machine.restitution)
        theta = mpf(begin_deg) * mp.pi / 180
        at = -((mpf(machine.strobe) - theta) % (2 * mp.pi))
        c, c1, _ = self._cam(theta)
        gap = mpf(0) if q is None else mpf(q) - c
        u = mpf(0) if v is None else mpf(v) - c1
        rests = gap == 0 and u == 0 and self._pressed(theta)
        while at < TURN * self.turns:
            c, c1, _ = self._cam(theta)
            self.parts.append(
                Part(float(at), float(theta), float(c + gap), float(c1 + u), bool(rests))
            )
            if rests:
                s = self._released(theta)
                if s is None:
                    return
                kind, rests, before, gap, u = "detachment", False, mpf(0), mpf(0), mpf(0)
            else:
                s, before = self._landing(theta, gap, u, TURN * self.turns - at)
                if s is None:
                    return
                kind, gap, u = "impact", mpf(0), -r * before
            at, theta = at + s, (theta + s) % (2 * mp.pi)
            theta = self._at_edge(theta)
            if at >= TURN * self.turns:
                return
            yield self._event(kind, at, theta, before, u)
            if kind == "impact" and self._pressed(theta):
                accel = self.machine.force(float(theta))[0] / machine.mass
                hop = 2 * u * self.omega / accel
                if u == 0:
                    rests = True
                elif r < 1 and hop < CLOSED:
                    at, theta = at + hop / (1 - r), (theta + hop / (1 - r)) % (2 * mp.pi)
                    yield self._event("chatter", at, theta, mpf(0), mpf(0))
                    u, rests = mpf(0), True

    def _event(self, kind, at, theta, before, after) -> Event:
        q = self._cam(theta)[0]
        return Event(kind, *map(float, (at, theta, q, before, after)))

    def _cam(self, theta):
        """(lift, velocity, acceleration) of the cam; the last one is kept, as it is asked again."""
        if theta != self._last[0]:
            c, c1, c2 = self.machine.lift.exactly(theta)
            self._last = theta, (c, c1 * self.omega, c2 * self.omega**2)
        return self._last[1]

    def _at_edge(self, theta):
        """The phase, or the cam's edge within rounding of it."""
        edges = np.asarray(self.machine.lift.edges)
        near = edges[np.abs(edges - float(theta)).argmin()]
        return mpf(near % TURN) if abs(near - float(theta)) < EDGE else theta

    def _pressed(self, theta) -> bool:
        """Whether the cam presses on a follower at rest."""
        return bool(self.machine.force(float(theta))[0] > 0.0)

    def _released(self, theta):
        """rad until the contact force falls to zero, None if it does not within a turn."""
        begin = float(theta)
        for a, b in pairwise(self.machine.lift.cuts(begin, begin + TURN)):
            if a > begin + EDGE and self.machine.force(a)[0] < 0.0:
                return mpf(a) - theta
            x = np.linspace(a, b, 3 + int(2000 * (b - a)))
            values = np.r_[self.machine.force(x[:-1]), self.machine.force(x[-1:], -1)]
            below = np.flatnonzero(values < 0.0)
            if below.size and below[0] > 0:
                low, high = x[below[0] - 1], x[below[0]]
                force = lambda y: self.machine.force(y, -1)[0]  # noqa: E731
                root = brentq(force, low, high, xtol=1e-15, rtol=1e-15)
                exact = mp.findroot(self._force, (mpf(root) - 1e-6, mpf(root) + 1e-6), tol=1e-20)
                return exact - theta
        return None

    def _force(self, theta):
        """The contact force at an angle of a follower that rests on the cam, N."""
        own = self.machine
        c, c1, c2 = self._cam(theta)
        load = mpf(own.mass) * mpf(own.gravity) + mpf(own.preload)
        return mpf(own.stiffness) * c + mpf(own.damping) * c1 + load + mpf(own.mass) * c2

    def _landing(self, theta, gap, u, left):
        """(rad, relative velocity) of the first contact of a flight; (None, None) without one."""
        own = self.machine
        c, c1, _ = self._cam(theta)
        q, v = c + gap, c1 + u

        def exact(s):
            """(gap, its rate) after s rad of flight."""
            there, speed = own._exact.flow(s / self.omega, q, v)
            lift, slope, _ = self._cam(theta + s)
            return there - lift, speed - slope

        def polished(s):
            """Newton's method from s: (rad of flight, relative velocity at the contact)."""
            s = mpf(s)
            for _ in range(12):
                g, rate = exact(s)
                step = -g * self.omega / rate
                s += step
                if abs(step) < 1e-11:  # its square is what is left
                    break
            return s, exact(s)[1]

        begin = STEP / 20
        if gap == 0:
            accel = -own.force(float(theta))[0] / own.mass
            hop = float(-2 * u * self.omega / accel) if u > 0 > accel else SHORT
            room = own.lift.cuts(float(theta), float(theta) + 3 * hop)
            if hop < SHORT and len(room) == 2:
                return polished(hop)
            begin = hop / 50 if u > 0 else STEP / 5
        gaps = own.gap_of(Flight(float(theta), float(left), float(gap), float(u)))
        s = np.r_[np.geomspace(begin, STEP, 60)[:-1], np.arange(STEP, TURN, STEP)]
        low = 0.0
        while low < left:
            below = np.flatnonzero(gaps(s) < 0.0)
            if below.size:
                k = below[0]
                low = s[k - 1] if k else low
                break
            low, s = s[-1], s[-1] + np.arange(STEP, TURN, STEP)
        else:
            return None, None
        root = brentq(lambda x: gaps(np.array([x]))[0], low, s[k], xtol=1e-9)
        return polished(root)
