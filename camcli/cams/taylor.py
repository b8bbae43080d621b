"""Power series in the cam's angle whose coefficients may be series in another number themselves.

`lift(Taylor.variable(theta, order))` has the derivatives by the angle of a cam whose numbers vary:
each is a ball, or, where a number of the cam is a series, a series in that number.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import Any

from flint import arb


class Taylor:
    """sum terms[k] x^k, cut behind the last of the terms."""

    __slots__ = ("terms",)

    def __init__(self, terms: Sequence[Any]):
        self.terms = list(terms)

    @classmethod
    def variable(cls, theta: Any, order: int) -> Taylor:
        """theta + x, up to x^order."""
        return cls([theta, *[arb(int(k == 0)) for k in range(order)]])

    def derivatives(self) -> list[Any]:
        """The value and the derivatives by x, where x = 0."""
        return [term * factorial(k) for k, term in enumerate(self.terms)]

    def __add__(self, other: Any) -> Taylor:
        if not isinstance(other, Taylor):
            return Taylor([self.terms[0] + other, *self.terms[1:]])
        return Taylor([a + b for a, b in zip(self.terms, other.terms, strict=True)])

    def __neg__(self) -> Taylor:
        return Taylor([-a for a in self.terms])

    def __sub__(self, other: Any) -> Taylor:
        return self + -other

    def __rsub__(self, other: Any) -> Taylor:
        return -self + other

    def __mul__(self, other: Any) -> Taylor:
        if not isinstance(other, Taylor):
            return Taylor([a * other for a in self.terms])
        return Taylor([self._product(other, k) for k in range(len(self.terms))])

    def __truediv__(self, other: Any) -> Taylor:
        return Taylor([a / other for a in self.terms])

    __radd__, __rmul__ = __add__, __mul__

    def _product(self, other: Taylor, k: int) -> Any:
        """Coefficient k of the product: sum over i of terms[i] other.terms[k - i]."""
        total = self.terms[0] * other.terms[k]
        for i in range(1, k + 1):
            total = total + self.terms[i] * other.terms[k - i]
        return total

    def sqrt(self) -> Taylor:
        """The square root y of this series s, from coefficient k of y^2 = s.

        2 y_0 y_k + sum over 0 < i < k of y_i y_(k-i) = s_k.
        """
        root = [self.terms[0].sqrt()]
        for k in range(1, len(self.terms)):
            left = self.terms[k]
            for i in range(1, k):
                left = left - root[i] * root[k - i]
            root.append(left / (2 * root[0]))
        return Taylor(root)

    def sin_cos(self) -> tuple[Taylor, Taylor]:
        """Sine s and cosine c of this series a, from coefficient k - 1 of s' = c a', c' = -s a'.

        k s_k = sum over 0 < i <= k of i a_i c_(k-i), and k c_k = -sum of i a_i s_(k-i).
        """
        sine, cosine = self.terms[0].sin_cos()
        sines = [sine]
        cosines = [cosine]
        for k in range(1, len(self.terms)):
            sine_sum = self.terms[1] * cosines[k - 1]
            cosine_sum = self.terms[1] * sines[k - 1]
            for i in range(2, k + 1):
                sine_sum = sine_sum + self.terms[i] * cosines[k - i] * i
                cosine_sum = cosine_sum + self.terms[i] * sines[k - i] * i
            sines.append(sine_sum / k)
            cosines.append(-cosine_sum / k)
        return Taylor(sines), Taylor(cosines)

    def sin(self) -> Taylor:
        """Sine."""
        return self.sin_cos()[0]

    def cos(self) -> Taylor:
        """Cosine."""
        return self.sin_cos()[1]
