"""A small difference between two motions, carried along a recorded one (`kernel.variational`).

A matrix is (qq, qw, wq, ww): its columns are differences (dq m, dw m/rad) at equal phase. A single
difference is the first column of a matrix whose second one is zero.
"""

from camcli.kernel.cam_table import TURN, lift_at, restitution_at, stretch_at
from camcli.kernel.flow import Constants
from camcli.kernel.variational import after_flight, after_impact
from camcli.system import System

Matrix = tuple[float, float, float, float]
IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0)


def since_first_strobe(system: System, period: int, theta: float) -> float:
    """Angle (rad) from the first strobe of a record to an event at the phase theta of a period."""
    strobe = system.strobe
    return theta - strobe + (TURN if theta < strobe else 0.0) + TURN * period


def flown(const: Constants, angle: float, matrix: Matrix) -> Matrix:
    """The differences after a flight over an angle (rad)."""
    return after_flight(const, angle, *matrix)


def struck(system: System, const: Constants, theta: float, u: float, matrix: Matrix) -> Matrix:
    """The differences after an impact at the phase theta with the incoming rate u (m/rad)."""
    i = stretch_at(system.cam, theta)
    lifts = lift_at(system.cam, i, theta)
    return after_impact(const, restitution_at(system.cam, const, i), lifts, u, *matrix)
