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
from camcli.exact.machine import BallMachine
from camcli.exact.shooting import BallFlight, NotProvedError, Shooting

LARGEST = 1.0  # rad, of an ellipse that is tried
SHRINKING = 0.8  # from one size that is tried to the next
SIZES = 60  # tried
Axes = tuple[tuple[float, float, float, float], ...]


def attraction(evidence: Evidence) -> Axes | None:
    """The axes [[a, b], [c, d]] of ellipses next to the largest that hold; None where none does.

    The precision in use is that of the evidence.
    """
    shooting = evidence.shooting
    z = evidence.boxes[0].hull()
    flights = shooting.flights(shooting.machine(z[-1]), z[:-1])
    axes = _axes([_in_floats(flight_map(flight)) for flight in flights])
    size = LARGEST / max(float(np.hypot(*matrix[0])) for matrix in axes)
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


def _in_floats(matrix: arb_mat) -> np.ndarray:
    """The middles of a matrix of balls."""
    return np.array([[float(x) for x in row] for row in matrix.tolist()])


def _rounded(matrix: np.ndarray) -> tuple[float, float, float, float]:
    """The entries a, b, c, d of a matrix [[a, b], [c, d]], to six digits."""
    a, b, c, d = (float(f"{x:.6g}") for x in matrix.ravel())
    return a, b, c, d


def _axes(maps: list[np.ndarray]) -> list[np.ndarray]:
    """A matrix M for each impact, all to one scale; over a period the first one shrinks."""
    whole = np.linalg.multi_dot([*maps[::-1], np.eye(2)]) if len(maps) > 1 else maps[0]
    values, vectors = np.linalg.eig(whole)
    if abs(values[0].imag) > 0.0:
        first = np.column_stack([vectors[:, 0].real, vectors[:, 0].imag])
    else:
        first = vectors.real
    least = max(abs(values)) ** (1.0 / len(maps))
    axes = [first]
    for one in maps[:-1]:
        axes.append(one @ axes[-1] / least)
    return axes


def flight_map(flight: BallFlight) -> arb_mat:
    """How (dtheta, dv) of a flight's first impact moves those of the next."""
    slopes = flight.slopes()
    return arb_mat([[slopes.theta_by_theta, slopes.theta_by_v], [slopes.v_by_theta, slopes.v_by_v]])


def _holds(shooting: Shooting, z: list[arb], axes: list[np.ndarray]) -> bool:
    """True where every motion from an ellipse lands nearer to the middle of the next one.

    In units of the two ellipses a flight has the derivatives S; it brings all motions nearer where
    I - S^T S is positive definite.
    """
    wide = list(z)
    for k, one in enumerate(axes):
        wide[2 * k] += arb(0, float(np.hypot(*one[0])))
        wide[2 * k + 1] += arb(0, float(np.hypot(*one[1])))
    shooting.admissible(wide)
    machine = shooting.machine(z[-1])
    for k, flight in enumerate(shooting.flights(machine, wide[:-1])):
        after = (k + 1) % shooting.n
        here, there = (arb_mat([[arb(float(x)) for x in row] for row in one.tolist()])
                       for one in (axes[k], axes[after]))  # fmt: skip
        step = there.inv() * flight_map(flight) * here
        left = arb_mat([[1, 0], [0, 1]]) - step.transpose() * step
        if not (left[0, 0] > 0 and left.det() > 0):
            return False
        if not all(_passes(shooting, machine, z, wide, axes, k, side) for side in (-1, 1)):
            return False
    return True


def _passes(
    shooting: Shooting,
    machine: BallMachine,
    z: list[arb],
    wide: list[arb],
    axes: list[np.ndarray],
    k: int,
    side: int,
) -> bool:
    """Whether flight k is above the cam before the next ellipse (side -1), and below behind it.

    The gap there is that of the orbit's own flight, off by its slopes by theta and v.
    """
    after = (k + 1) % shooting.n
    lands = shooting.landing(k)
    reach = side * float(np.hypot(*axes[after][0]))
    gap = shooting.gap(machine, z, k, lands)(shooting.span(z, k) + reach)[0]
    c, c1, c2 = shooting.lift(machine, shooting.places[k], wide[2 * k])
    v = wide[2 * k + 1]
    b, _, p = machine.flow(shooting.span(z, k) + reach + z[2 * k] - wide[2 * k])
    accel = -(machine.G + machine.W2 * c + 2 * machine.Z * (c1 + v)) - c2
    by_theta, by_v = -(v * (1 - machine.W2 * p) + b * accel), b
    along = [by_theta * float(one[0]) + by_v * float(one[1]) for one in axes[k].T]
    spread = (along[0] * along[0] + along[1] * along[1]).sqrt()
    return bool(-side * gap > spread)
