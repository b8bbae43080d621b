"""Writes configs/valve-lift.csv, a valve lift as one is handed on: 0.0001 inch, every 2 deg crank.

    python tests/support/valve_lift.py > configs/valve-lift.csv

The law is a polynomial in x = angle from the nose over the flank's length, symmetric about it,
    lift = h (1 + sum C_k x^k), k = 2, 6, 8, 10, 12,
with C_k such that the lift and its first four derivatives vanish at x = 1.
Fractions throughout: the same bytes on every machine.
"""

from fractions import Fraction

LIFT = Fraction(4, 10)  # inch
FLANK = 136  # deg of crank from the nose to zero lift
STEP = 2  # deg of crank
EXPONENTS = (2, 6, 8, 10, 12)


def coefficient(k: int) -> Fraction:
    """C_k of the law."""
    value = Fraction(-1)
    for j in EXPONENTS:
        if j != k:
            value *= Fraction(j, j - k)
    return value


def lift(angle: Fraction) -> Fraction:
    """Lift in inch at an angle from the nose, deg of crank; exact."""
    x = abs(angle) / FLANK
    if x >= 1:
        return Fraction(0)
    return LIFT * (1 + sum(coefficient(k) * x**k for k in EXPONENTS))


def main() -> None:
    """Print the table."""
    print("# valve lift, measured at the valve; zero at the nose")
    print("crank_deg,lift_inch")
    for angle in range(-FLANK - 4 * STEP, FLANK + 4 * STEP + 1, STEP):
        print(f"{angle},{float(round(lift(Fraction(angle)), 4)):.4f}")


if __name__ == "__main__":
    main()
