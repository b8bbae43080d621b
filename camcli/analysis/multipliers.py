"""The eigenvalues of a map of the plane, from its trace and determinant."""

from math import sqrt


def multipliers(trace: float, det: float) -> tuple[complex, complex]:
    """Roots of z^2 - trace z + det: the larger first (upper half plane first), no cancellation."""
    half = 0.5 * trace
    discriminant = 0.25 * trace * trace - det
    if discriminant < 0.0:
        return complex(half, sqrt(-discriminant)), complex(half, -sqrt(-discriminant))
    large = half + sqrt(discriminant) if half >= 0.0 else half - sqrt(discriminant)
    small = det / large if large != 0.0 else 0.0  # as their product is det
    return complex(large), complex(small)


def attracts(trace: float, det: float) -> bool:
    """Whether both roots of z^2 - trace z + det lie inside the unit circle (Jury's conditions)."""
    return det < 1.0 and abs(trace) < 1.0 + det
