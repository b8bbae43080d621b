"""Two unknown numbers in a parallelogram: errors that turn and stretch are not made boxes of.

R. J. Lohner, Enclosing the solutions of ordinary initial and boundary value problems, 1987: the
points m + Q e, where m is exact, Q nearly orthonormal and e in two balls. Boxes instead lose 0.9
digits at every impact of a motion whose errors grow by 0.1.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb, arb_mat

from camcli.exact.balls import UndecidedError


@dataclass(frozen=True)
class Parallelogram:
    """m + p t + Q e, where m, p and Q are exact and |t| <= 1 is the same all along a motion."""

    middle: arb_mat
    lean: arb_mat  # p
    frame: arb_mat
    error: arb_mat

    @classmethod
    def around(cls, x: arb, y: arb) -> Parallelogram:
        """Two independent balls."""
        middle = arb_mat([[x.mid()], [y.mid()]])
        frame = arb_mat([[1, 0], [0, 1]])
        return cls(middle, arb_mat(2, 1), frame, arb_mat([[x], [y]]) - middle)

    def hull(self) -> tuple[arb, arb]:
        """The balls that hold each number."""
        x, y = (self.middle + self.lean * arb(0, 1) + self.frame * self.error).entries()
        return x, y

    def image(
        self, of_middle: arb_mat, jacobian: arb_mat, drift: arb_mat, unit: arb_mat
    ) -> Parallelogram:
        """F(m) + (J p + d) t + J Q e: J, d hold the derivatives of F at all its points and all t.

        The new Q is orthonormal in numbers y = x / unit.
        """
        middle, leans = of_middle.mid(), jacobian * self.lean + drift
        lean = leans.mid()
        spread = jacobian * self.frame
        a, b, c, d = (unit.inv() * spread).mid().entries()
        first, second = (x.rad() for x in self.error.entries())
        if (a * a + c * c) * first**2 <= (b * b + d * d) * second**2:
            a, c = b, d  # the longer side keeps its direction
        frame = (unit * arb_mat([[a, -c], [c, a]]) / (a * a + c * c).sqrt()).mid()
        try:
            rest = of_middle - middle + (leans - lean) * arb(0, 1)
            error = frame.inv() * (spread * self.error + rest)
        except ZeroDivisionError:  # its columns are known too badly to tell them apart
            raise UndecidedError from None
        return Parallelogram(middle, lean, frame, error)
