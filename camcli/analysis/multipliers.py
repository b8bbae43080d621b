"""The eigenvalues of a map of the plane, from its trace and determinant."""

from math import sqrt


def multipliers(trace: float, det: float) -> tuple[complex, complex]:
    """Roots of z^2 - trace z + det: the larger first (upper half plane first), no cancellation."""
    disc = 0.25 * trace * trace - det
    if disc < 0.0:
        return complex(0.5 * trace, sqrt(-disc)), complex(0.5 * trace, -sqrt(-disc))
    half = 0.5 * trace
    large = half + sqrt(disc) if half >= 0.0 else half - sqrt(disc)
    return complex(large), complex(det / large if large != 0.0 else 0.0)


def attracts(trace: float, det: float) -> bool:
    """Whether both roots of z^2 - trace z + det lie inside the unit circle (Jury's conditions)."""
    return det < 1.0 and abs(trace) < 1.0 + det
