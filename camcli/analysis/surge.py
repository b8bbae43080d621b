"""Spring surge: which harmonics of the cam meet the spring's own frequency, and how strongly.

A coil spring of mass m_s and rate k between two ends that are held has the frequency
1/2 sqrt(k/m_s), in Hz, as the wave equation of a uniform rod says (a textbook's result: A. M. Wahl,
Mechanical Springs). Its upper end moves as the lift does,

    c(theta) = A_0 + sum A_n cos(n theta + phase_n),

so harmonic n meets it where n turns of the cam take one of its periods. The harmonic-resonance
factor is n^2 A_n, the amplitude of the n-th harmonic of c_thetatheta, in inches. Its usual limit is
0.12 for trains with pushrods and a higher one, near 0.15, where the cam is direct. H. A. Rothbart
(editor), Cam Design Handbook, McGraw-Hill 2004, page 539, has the chart (figure 16.7: Z N^2 over
the synchronous engine speed, with a pushrod limit and a direct limit) and the number: 0.16
"exceeds the allowable coefficient limit of 0.12". Its speeds are those of harmonics of the cam's
turn: a spring of 24 000 cycles a minute meets N = 9 at 5333 rpm of an engine, 2667 of its cam. The
direct limit was read off the chart.

The unit of the limit is inferred, not published: the page gives none with its factors, but its lash
in inches, and its values of 0.33 and more of the fourth harmonic are those of lobes of some 9 mm
where A_n is in inches. So 0.12 is taken as 3.05 mm/rad2. In mm the limit would be 25.4 times as
strict, and those lobes would exceed it 70 times. What follows: amplitudes, frequency and the speeds
at which harmonics meet the spring do not hang on the unit; which harmonic is called strong does.

The waves in the spring are not simulated: the follower's motion knows nothing of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial, sqrt
from typing import NamedTuple

from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS
from camcli.kernel.cam_table import LIFT, LIFT_REST, PIECE, SLOPE_REST, TERMS, TURN, Cam
from camcli.quantities import LENGTHS
from camcli.system import System, rpm_of

LIMIT, DIRECT_LIMIT = 0.12, 0.15
HARMONICS = 40
A_THIRD = 1.0 / 3.0  # of a spring whose one end is held moves with the other


@dataclass(frozen=True)
class Harmonic:
    """A harmonic of the lift, m."""

    number: int
    amplitude: float
    rpm: float  # of the cam, at which it meets the spring
    factor: float

    @property
    def strong(self) -> bool:
        """Whether the factor is above its usual limit."""
        return self.factor > LIMIT


@dataclass(frozen=True)
class Surge:
    """A spring of a mass (kg) and its own frequency (Hz), and the harmonics of the cam."""

    mass: float
    hertz: float
    harmonics: tuple[Harmonic, ...]

    def strong_below(self, rpm: float) -> list[Harmonic]:
        """The harmonics above the limit that meet the spring up to a speed, the slowest first."""
        strong = [
            harmonic for harmonic in self.harmonics if harmonic.strong and harmonic.rpm <= rpm
        ]
        return sorted(strong, key=lambda harmonic: harmonic.rpm)


def own_frequency(stiffness: float, mass: float) -> float:
    """Hz of a spring (N/m, kg) whose two ends are held."""
    return 0.5 * sqrt(stiffness / mass)


def surge(system: System, mass: float) -> Surge:
    """The first HARMONICS harmonics of the cam, and where they meet a spring of a mass (kg)."""
    hertz = own_frequency(system.follower.stiffness, mass)
    numbers = range(1, HARMONICS + 1)
    harmonics = []
    for n, (a, b) in zip(numbers, fourier(system.cam, numbers), strict=True):
        amplitude = sqrt(a * a + b * b)
        harmonics.append(
            Harmonic(
                number=n,
                amplitude=amplitude,
                rpm=rpm_of(TURN * hertz / n),
                factor=n * n * amplitude / LENGTHS["inch"],
            )
        )
    return Surge(mass, hertz, tuple(harmonics))


def fourier(cam: Cam, numbers: Sequence[int]) -> list[tuple[float, float]]:
    """(a_n, b_n) of c = sum a_n cos n theta + b_n sin n theta, m, for some n >= 1.

    Each piece is a polynomial p, of which
        integral p e^(-i n x) dx = - sum p^(j)(x) e^(-i n x)/(i n)^(j + 1)
    between its ends. The terms nearly cancel in a short piece, so that balls take them.
    """
    with precision(DIGITS):
        pieces = _pieces(cam)
        return [_coefficients(pieces, n) for n in numbers]


class _Ends(NamedTuple):
    """Both ends of a polynomial piece, rad, and c with all its derivatives there, m and rad."""

    start: arb
    end: arb
    at_start: list[arb]
    at_end: list[arb]


def _pieces(cam: Cam) -> list[_Ends]:
    """All pieces of a turn in order."""
    pieces = []
    count_of_stretches = len(cam.stretches)
    for i, stretch in enumerate(cam.stretches):
        # the exact phases of the corners are those in doubles and what these leave out
        low = arb(stretch.start) + stretch.rest
        if stretch.end == TURN:
            high = 2 * arb.pi()
        else:
            high = arb(stretch.end) + cam.stretches[(i + 1) % count_of_stretches].rest
        count = int(stretch.piece_count)
        edges = [low + (high - low) * k / count for k in range(count + 1)]
        for k in range(count):
            row = (int(stretch.first_piece) + k) * PIECE
            centre = arb(cam.pieces[row])
            terms = [arb(cam.pieces[row + LIFT + j]) for j in range(TERMS)]
            terms[0] += cam.pieces[row + LIFT_REST]
            terms[1] += cam.pieces[row + SLOPE_REST]
            if stretch.dwell:
                terms = terms[:1]
            start = edges[k]
            end = edges[k + 1]
            at_start = _derivatives(terms, start - centre)
            at_end = _derivatives(terms, end - centre)
            pieces.append(_Ends(start, end, at_start, at_end))
    return pieces


def _derivatives(terms: Sequence[arb], x: arb) -> list[arb]:
    """sum terms[j] x^j and all its derivatives, in their order."""
    values = []
    for order in range(len(terms)):
        total = arb(0)
        for j in range(len(terms) - 1, order - 1, -1):  # Horner's scheme
            total = total * x + terms[j] * (factorial(j) // factorial(j - order))
        values.append(total)
    return values


def _coefficients(pieces: Sequence[_Ends], n: int) -> tuple[float, float]:
    """(a_n, b_n) of the whole turn, m; see `fourier`.

    pi (a_n - i b_n) is the integral of c e^(-i n x), whose antiderivative in a piece is
    -(sum p^(j)/(i n)^(j + 1)) e^(-i n x).
    """
    real = arb(0)
    imaginary = arb(0)
    for piece in pieces:
        for sign, x, derivatives in (
            (1, piece.end, piece.at_end),
            (-1, piece.start, piece.at_start),
        ):
            sum_real, sum_imaginary = _antiderivative(derivatives, n)
            cosine = (n * x).cos()
            sine = (n * x).sin()
            real += sign * (sum_real * cosine + sum_imaginary * sine)
            imaginary += sign * (sum_imaginary * cosine - sum_real * sine)
    return float(real / arb.pi()), float(-imaginary / arb.pi())


def _antiderivative(derivatives: Sequence[arb], n: int) -> tuple[arb, arb]:
    """Real and imaginary part of -sum derivatives[j]/(i n)^(j + 1).

    -1/i^(j + 1) is i, 1, -i, -1 for j = 0, 1, 2, 3, and so on.
    """
    real = arb(0)
    imaginary = arb(0)
    power = arb(1) / n
    for j, value in enumerate(derivatives):
        term = value * power
        if j % 4 == 0:
            imaginary += term
        elif j % 4 == 1:
            real += term
        elif j % 4 == 2:
            imaginary -= term
        else:
            real -= term
        power /= n
    return real, imaginary
