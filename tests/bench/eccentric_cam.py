"""The eccentric cam as the multiple-precision oracle wants a cam: c = base + lift (1 - cos)/2."""

from __future__ import annotations

from typing import Any, NamedTuple

from mpmath import mp, mpf


class Harmonic(NamedTuple):
    """A turn of the eccentric cam: c = middle - half cos x, x = theta - origin."""

    middle: Any
    half: Any
    origin: Any
    end: Any

    def laws(self, lib, x):
        """Lift and its first two derivatives in the angle."""
        cos, sin = lib.cos(x), lib.sin(x)
        return self.middle - self.half * cos, self.half * sin, self.half * cos


class EccentricCam:
    """c = base + lift (1 - cos theta)/2, with what the oracle asks of a cam."""

    def __init__(self, base: float, lift: float):
        self.half = mpf(lift) / 2
        self.middle = mpf(base) + self.half

    def segments(self, psi, side=1):
        """One piece per turn, from the unbounded angle psi on."""
        turn = mp.floor(psi / (2 * mp.pi))
        while True:
            origin = 2 * mp.pi * turn
            yield Harmonic(self.middle, self.half, origin, origin + 2 * mp.pi)
            turn += 1

    def laws(self, theta, side=1):
        """(c, c_theta, c_thetatheta)."""
        return Harmonic(self.middle, self.half, mpf(0), None).laws(mp, mpf(theta))

    def c(self, theta):
        """Lift."""
        return self.laws(theta)[0]

    def c1(self, theta):
        """Slope."""
        return self.laws(theta)[1]
