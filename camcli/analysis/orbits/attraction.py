"""How far a stable orbit certainly attracts: ellipses about its impacts, one mapped into the next.

Ellipse k holds (theta, v) + M u with |u| <= 1, where (theta, v) is impact k. The map of a flight
has a matrix J there, and M^-1 J M of the next and this ellipse is shorter than 1 where M turns the
product of all J into rotation and shrinking: its columns are the real and imaginary part of an
eigenvector, or the two real ones. The ellipses are made smaller until that, and all else that is
asked of them (see the guide on proofs), holds for every motion that starts in them.
"""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat

from camcli.analysis.orbits.evidence import Evidence
from camcli.cams.balls import UndecidedError
from camcli.exact.machine import BallMachine, identity
from camcli.exact.shooting import BallFlight, NotProvedError, Shooting, StateSlopes

LARGEST = 1.0  # rad, of an ellipse that is tried
SHRINKING = 0.8  # from one size that is tried to the next
SIZES = 60  # tried
Axes = tuple[tuple[float, float, float, float], ...]  # a, b, c, d of each M = [[a, b], [c, d]]


def attraction(evidence: Evidence) -> Axes | None:
    """The axes M = [[a, b], [c, d]] of ellipses next to the largest that hold; None for none.

    One ellipse for each impact, in rad and m/rad. The precision in use is that of the evidence.
    """
    shooting = evidence.shooting
    z = evidence.boxes[0].hull()
    flights = shooting.flights(shooting.machine(z[-1]), z[:-1])
    axes = _axes([_in_floats(flight_map(flight)) for flight in flights])
    reach_in_theta = max(_reach(matrix)[0] for matrix in axes)
    size = LARGEST / reach_in_theta
    for _ in range(SIZES):
        scaled = [matrix * size for matrix in axes]
        try:
            holds = _holds(shooting, z, scaled)
        except (NotProvedError, UndecidedError, ZeroDivisionError):
            holds = False
        if holds:  # a checker may round more coarsely: it gets ellipses of the next smaller size
            return tuple(_rounded(matrix * SHRINKING) for matrix in scaled)
        size *= SHRINKING
    return None


def _reach(matrix: np.ndarray) -> tuple[float, float]:
    """How far an ellipse M u, |u| <= 1, goes in theta (rad) and in v (m/rad)."""
    of_theta, of_v = matrix
    return float(np.hypot(*of_theta)), float(np.hypot(*of_v))


def _in_floats(matrix: arb_mat) -> np.ndarray:
    """The middles of a matrix of balls."""
    return np.array([[float(x) for x in row] for row in matrix.tolist()])


def _rounded(matrix: np.ndarray) -> tuple[float, float, float, float]:
    """The entries a, b, c, d of a matrix [[a, b], [c, d]], to six digits."""
    a, b, c, d = (float(f"{x:.6g}") for x in matrix.ravel())
    return a, b, c, d


def _axes(maps: list[np.ndarray]) -> list[np.ndarray]:
    """A matrix M for each impact, all to one scale, in whose units every flight's map shrinks.

    maps: J of each flight. The columns of the first M are the real and the imaginary part of an
    eigenvector of the product of all J, or its two real eigenvectors; each further one is J M of
    the one before, over the geometric mean of what the larger multiplier shrinks by in a flight.
    """
    whole = np.linalg.multi_dot([*maps[::-1], np.eye(2)]) if len(maps) > 1 else maps[0]
    multipliers, vectors = np.linalg.eig(whole)
    if abs(multipliers[0].imag) > 0.0:
        first = np.column_stack([vectors[:, 0].real, vectors[:, 0].imag])
    else:
        first = vectors.real
    shrinks_by = max(abs(multipliers)) ** (1.0 / len(maps))  # from one impact to the next
    axes = [first]
    for jacobian in maps[:-1]:
        axes.append(jacobian @ axes[-1] / shrinks_by)
    return axes


def flight_map(flight: BallFlight) -> arb_mat:
    """How (dtheta, dv) of a flight's first impact moves those of the next."""
    slopes = flight.slopes()
    return arb_mat([[slopes.theta_by_theta, slopes.theta_by_v], [slopes.v_by_theta, slopes.v_by_v]])


def _holds(shooting: Shooting, z: list[arb], axes: list[np.ndarray]) -> bool:
    """True where every motion from an ellipse lands nearer to the middle of the next one.

    In units of the two ellipses a flight has the derivatives S; it brings all motions nearer where
    I - S^T S is positive definite. z: balls of the orbit's unknowns; axes: M of each impact.
    """
    wide = list(z)  # of all motions that start in the ellipses
    for k, matrix in enumerate(axes):
        in_theta, in_v = _reach(matrix)
        wide[2 * k] += arb(0, in_theta)
        wide[2 * k + 1] += arb(0, in_v)
    shooting.admissible(wide)
    machine = shooting.machine(z[-1])
    for k, flight in enumerate(shooting.flights(machine, wide[:-1])):
        after = (k + 1) % shooting.n
        here = _in_balls(axes[k])
        there = _in_balls(axes[after])
        slopes = there.inv() * flight_map(flight) * here  # S
        left = identity(2) - slopes.transpose() * slopes
        if not (left[0, 0] > 0 and left.det() > 0):
            return False
        for side in (-1, 1):
            if not _passes(shooting, machine, z, wide, axes, k, side):
                return False
    return True


def _in_balls(matrix: np.ndarray) -> arb_mat:
    """A matrix of doubles as one of exact numbers."""
    return arb_mat([[arb(float(x)) for x in row] for row in matrix.tolist()])


def _passes(
    shooting: Shooting,
    machine: BallMachine,
    z: list[arb],
    wide: list[arb],
    axes: list[np.ndarray],
    k: int,
    side: int,
) -> bool:
    """Whether flights from ellipse k land where the next ellipse lies, in phase.

    side -1: none has landed yet where that begins; side 1: all have landed where it ends, so that
    the gap is below zero there. The gap is that of the orbit's flight, changed by its slopes by
    theta and v times M u: by at most the length of M^T times these slopes. z: balls of the orbit's
    unknowns; wide: of all motions from the ellipses; axes: M of each ellipse.
    """
    after = (k + 1) % shooting.n
    beyond = side * _reach(axes[after])[0]  # rad behind the orbit's own landing
    place = shooting.places[k]
    gap = shooting.gap(machine, z, k, shooting.landing(k))(shooting.span(z, k) + beyond)[0]
    c, c1, c2 = shooting.lift(machine, place, wide[2 * k])
    v = wide[2 * k + 1]
    accel = -(machine.G + machine.W2 * c + 2 * machine.Z * (c1 + v)) - c2
    flown = shooting.span(z, k) + beyond + z[2 * k] - wide[2 * k]
    slopes = StateSlopes.after(machine, flown, v, accel)
    along_axes = [
        slopes.q_by_theta * float(theta) + slopes.q_by_v * float(rate) for theta, rate in axes[k].T
    ]
    spread = (along_axes[0] * along_axes[0] + along_axes[1] * along_axes[1]).sqrt()
    return bool(-side * gap > spread)
