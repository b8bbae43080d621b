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
    """m + Q e; `middle` and `frame` are exact."""

    middle: arb_mat
    frame: arb_mat
    error: arb_mat

    @classmethod
    def around(cls, x: arb, y: arb) -> Parallelogram:
        """Two independent balls."""
        middle = arb_mat([[x.mid()], [y.mid()]])
        return cls(middle, arb_mat([[1, 0], [0, 1]]), arb_mat([[x], [y]]) - middle)

    def hull(self) -> tuple[arb, arb]:
        """The balls that hold each number."""
        x, y = (self.middle + self.frame * self.error).entries()
        return x, y

    def image(self, of_middle: arb_mat, jacobian: arb_mat, unit: arb_mat) -> Parallelogram:
        """F(m) + J Q e, where J holds the derivatives of F at all its points (mean value form).

        The new Q is orthonormal in numbers y = x / unit.
        """
        middle = of_middle.mid()
        spread = jacobian * self.frame
        a, b, c, d = (unit.inv() * spread).mid().entries()
        first, second = (x.rad() for x in self.error.entries())
        if (a * a + c * c) * first**2 < (b * b + d * d) * second**2:
            a, c = b, d  # the longer side keeps its direction
        frame = (unit * arb_mat([[a, -c], [c, a]]) / (a * a + c * c).sqrt()).mid()
        try:
            error = frame.inv() * (spread * self.error + (of_middle - middle))
        except ZeroDivisionError:  # its columns are known too badly to tell them apart
            raise UndecidedError from None
        return Parallelogram(middle, frame, error)
