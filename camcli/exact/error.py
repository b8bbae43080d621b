"""The error of a motion followed in decimals: the covariance of independent errors, carried along.

A flight or an impact with the matrix M (`kernel.tangent`) takes the covariance C of an error
(dq, dw) at equal phase to M C M^T; every event adds an error of its own. The machine itself is
exact: doubles, and the parts of the cam with the decimals they were made with.
"""

from __future__ import annotations

from math import sqrt

from camcli.kernel.variational import after_flight, after_impact

NOISE = 1e-86  # of the lift: error added at an event, m and m/rad


class Doubt:
    """Standard error of a motion, in lifts."""

    def __init__(self, lane, size: float):
        self.lane, self.noise = lane, (NOISE * size) * (NOISE * size)
        self.size = size
        self.reset()

    def reset(self) -> None:
        """Begin anew at a departure, whose phase is known."""
        self.cov = (self.noise, 0.0, self.noise)

    def flight(self, s: float) -> None:
        """A flight of s rad."""
        self._carry(lambda pair: after_flight(self.lane, s, *pair))

    def impact(self, lifts: tuple[float, float, float], u: float) -> None:
        """An impact with the rate u < 0 on a cam with (c, c_theta, c_thetatheta) = lifts."""
        self._carry(lambda pair: after_impact(self.lane, lifts, u, *pair))
        qq, qw, ww = self.cov
        self.cov = (qq + self.noise, qw, ww + self.noise)

    @property
    def error(self) -> float:
        """Standard error of position (m) and velocity (m/rad) over the lift."""
        return sqrt(self.cov[0] + self.cov[2]) / self.size

    def _carry(self, times) -> None:
        qq, qw, ww = self.cov
        a, b, c, d = times((qq, qw, qw, ww))
        qq, mixed, other, ww = times((a, c, b, d))
        self.cov = (qq, 0.5 * (mixed + other), ww)
