"""The peer of heyoka: its legs over steps of our own, and heyoka itself where it is installed."""

from math import cos, sin

import pytest

from camcli.analysis.bench import methods
from camcli.analysis.bench.cases import case
from camcli.analysis.bench.compare import compare
from camcli.analysis.bench.peers import rk4, taylor
from camcli.analysis.bench.peers.lifts import circle


class Stepped:
    """Stands for heyoka's integrator: fixed steps, and a terminal event by bisection."""

    def __init__(self, form, coordinates, armed, tolerance):
        self.form, self.coordinates, self.with_events = form, coordinates, armed
        self.time, self.state, self.pars = 0.0, [0.0, 0.0], [0.0] * 8
        self.steps = 400 if form == taylor.WAVE else 40  # a wave lasts a turn

    def _law(self, t):
        omega, angle, *_, first, second, offset = self.pars
        x = omega * t + angle
        if self.form in (taylor.FLANK, taylor.NOSE):
            return circle(x, first, second, offset)
        if self.form == taylor.WAVE:
            return first - second * cos(x), second * sin(x), second * cos(x)
        return first, 0.0, 0.0

    def _rhs(self, t, z, w):
        omega, _, k, b, load = self.pars[:5]
        force = -k * z - b * w - load
        if self.coordinates == taylor.POSITION:
            return w, force
        c, slope, bend = self._law(t)
        return w, force - k * c - b * omega * slope - omega * omega * bend

    def _gap(self, t, z):
        return z[0] - (self._law(t)[0] if self.coordinates == taylor.POSITION else 0.0)

    def reset_cooldowns(self):
        pass

    def propagate_until(self, end):
        t, z, h = self.time, tuple(self.state), (end - self.time) / self.steps
        outcome = 0
        for _ in range(self.steps):
            after = rk4.step(self._rhs, t, z, h)
            if self.with_events and self._gap(t + h, after) < 0.0:
                low, high = 0.0, h
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    above = self._gap(t + middle, rk4.step(self._rhs, t, z, middle)) > 0.0
                    low, high = (middle, high) if above else (low, middle)
                t, z, outcome = t + high, rk4.step(self._rhs, t, z, high), taylor.STOPPED
                break
            t, z = t + h, after
        self.time = t
        self.state[:] = z
        return outcome, 0.0, 0.0, self.steps


@pytest.mark.parametrize("name", ["chatter", "eccentric", "p3", "critical"])
def test_the_legs_of_the_taylor_integrator_are_right(name, monkeypatch):
    made = {}

    def compiled(*key):
        ta = made.setdefault(key, Stepped(*key))
        return ta, ta.state, ta.pars

    monkeypatch.setattr(taylor, "compiled", compiled)
    some = case(name)
    trace = taylor.run(methods.world_of(some, 60.0, 1e-9), some.start, 1e-13)
    found = compare(some, trace)
    assert found.missed == found.extra == 0
    assert found.error < 1e-5
    assert {key[1] for key in made} >= {taylor.POSITION}


@pytest.mark.skipif(not taylor.available(), reason="heyoka is not installed")
def test_the_taylor_integrator_is_exact():
    for name in ("chatter", "eccentric"):
        some = case(name)
        trace = taylor.run(methods.world_of(some, 60.0, 1e-9), some.start, 1e-13)
        assert compare(some, trace).error < 1e-11
