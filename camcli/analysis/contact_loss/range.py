"""Between which speeds contact is first lost when c_thetatheta is known up to a bound only."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi

from camcli.analysis.contact_loss.force import DEG, Force
from camcli.system import System


class _Shifted(Force):
    """The contact force with c_thetatheta moved by a bound that depends on the phase."""

    def __init__(self, system: System, bounds: Sequence[float], sign: float):
        super().__init__(system)
        self.bounds, self.sign = bounds, sign

    def terms(self, i: int, theta: float) -> tuple[float, float, float]:
        """A, B, C of the force with the moved c_thetatheta."""
        a, b, c = super().terms(i, theta)
        k = min(int(theta * DEG / 360.0 * len(self.bounds)), len(self.bounds) - 1)
        return a, b, c + self.sign * self.bounds[k]


def first_loss_range(system: System, bounds: Sequence[float]) -> tuple[float, float]:
    """(lowest, highest) speed of the first detachment in rpm; inf: never, 0: at standstill.

    `bounds` are bounds on the error of c_thetatheta, m/rad2, of equal shares of the turn.
    """
    speeds = []
    for sign in (-1.0, 1.0):
        force = _Shifted(system, bounds, sign)
        omega = force.lowest(lambda i, x, f=force: f.lost(i, x)[0], range(system.cam.stretches))[0]
        speeds.append(omega * (30.0 / pi) if omega < inf else inf)
    return speeds[0], speeds[1]
