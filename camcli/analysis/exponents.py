"""Lyapunov exponents of a recorded orbit, with an error bar and the sum rule as a check.

Saltation matrices carry a difference through the impacts (P. C. Mueller, Calculation of Lyapunov
exponents for dynamic systems with discontinuities, Chaos, Solitons & Fractals 5, 1995, 1671).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import fsum, inf, sqrt

from camcli.analysis.integrate import Record
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.kernel import backend
from camcli.kernel.arithmetic import natural_log
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.kernel.forms import rows_of
from camcli.kernel.orbit_loop import IMPACT
from camcli.kernel.variational import Growth, Pair
from camcli.system import System

BATCHES = 20  # for the error bar: the exponents of equal parts of the record
FEWEST = 4  # impacts in a batch


@dataclass(frozen=True)
class Exponents:
    """Both exponents in 1/period of the cam; -inf after sticking.

    spread: standard error of the largest from batches, 0 for a solved periodic orbit; rule: what
    the sum must be, 2 ln r for each impact per period (r that of the cam or of its seat) - b T/m;
    impacts: per period.
    """

    largest: float
    second: float
    spread: float
    rule: float
    impacts: float

    @property
    def defect(self) -> float:
        """Sum minus rule; nan where it is infinite."""
        return self.largest + self.second - self.rule if self.largest > -inf else float("nan")

    @property
    def chaotic(self) -> bool:
        """Positive by three standard errors."""
        return self.largest > 3.0 * self.spread


def of_orbit(system: System, orbit: PeriodicOrbit) -> Exponents:
    """ln |multiplier| per period of the cam, of a solved periodic orbit."""
    const = system.constants(orbit.rpm, 1.0, 1)
    if orbit.resting:
        return Exponents(-inf, -inf, 0.0, -inf, inf)
    per_turn = orbit.impacts / orbit.turns
    on_seat = _on_seat(system, orbit.theta) / orbit.turns
    large, small = (of_multiplier(z, orbit.turns) for z in orbit.multipliers)
    return Exponents(large, small, 0.0, sum_rule(const, per_turn, on_seat), per_turn)


def of_multiplier(z: complex, turns: int) -> float:
    """ln |z| per period of the cam, by IEEE arithmetic; -inf for zero."""
    size = abs(z.real) if z.imag == 0.0 else sqrt(z.real * z.real + z.imag * z.imag)
    return natural_log(size) / turns if size > 0.0 else -inf


def sum_rule(const, impacts_per_turn: float, on_seat: float = 0.0) -> float:
    """2 ln r per impact and -2 Z per rad; -inf for r = 0 with impacts.

    on_seat: how many of the impacts per turn are on the seat, with its own r.
    """
    rule = -2.0 * const.Z * TURN
    on_cam = impacts_per_turn - on_seat
    if on_cam > 0.0:
        if const.r == 0.0:
            return -inf
        rule = 2.0 * natural_log(const.r) * on_cam - 2.0 * const.Z * TURN
    if on_seat > 0.0:
        if const.r_seat == 0.0:
            return -inf
        rule += 2.0 * natural_log(const.r_seat) * on_seat
    return rule


def _on_seat(system: System, phases: Iterable[float]) -> int:
    """How many impacts at these phases (rad) are on the seat."""
    if not system.has_seat:
        return 0
    stretches = system.cam.stretches
    return sum(stretches[stretch_at(system.cam, theta)].seat for theta in phases)


def of_record(system: System, rpm: float, record: Record) -> Exponents | None:
    """The exponents of a record, in the mean over its logged impacts; None where these are too few.

    A difference and the area between two are carried along the record (`kernel.variational`), in
    BATCHES parts: the largest exponent is the growth of the difference per turn, the sum of both
    that of the area, the spread the standard error over the parts.
    """
    const = system.constants(rpm, 1.0, 1)
    kernel = backend.current()
    cam = system.cam_for(kernel)
    rows = len(record.kind)
    if rows // BATCHES < FEWEST or const.r == 0.0 or (system.has_seat and const.r_seat == 0.0):
        return None
    growths = kernel.copies(Growth, Growth(), BATCHES)
    kernel.stretch_events(
        cam,
        const,
        kernel.numbers(record.kind, int),
        kernel.numbers(record.period, int),
        kernel.numbers(record.theta),
        kernel.numbers(record.u),
        kernel.table(Pair, [Pair()]),
        growths,
    )
    parts = rows_of(Growth, growths)
    if any(part.chatters for part in parts):
        return Exponents(-inf, -inf, 0.0, -inf, inf)
    growing = [
        part for part in parts if part.length > 0.0 and part.first != 0.0 and part.area != 0.0
    ]
    # One by one from the left: `sum` rounds otherwise from Python 3.12 on.
    first = area = impacts = length = 0.0
    for part in growing:
        first += part.first_log  # logarithm of the growth of a difference, and of an area
        area += part.area_log
        impacts += part.impacts
        length += part.length  # rad
    if length == 0.0:
        return None
    turns = length / TURN
    largest = first / turns
    per_turn = impacts / turns
    on_seat = 0.0
    if system.has_seat:
        carried = record.theta[record.kind == IMPACT][1:]  # the first one begins the pair
        on_seat = _on_seat(system, carried) / turns
    return Exponents(
        largest=largest,
        second=area / turns - largest,
        spread=_standard_error(
            [part.first_log / part.length * TURN for part in growing],
            [part.length for part in growing],
        ),
        rule=sum_rule(const, per_turn, on_seat),
        impacts=per_turn,
    )


def _standard_error(rates: list[float], weights: list[float]) -> float:
    """Standard error of the mean of batches, which count by their lengths."""
    n = len(rates)
    total = fsum(weights)
    if n < 2:
        return inf
    pairs = list(zip(rates, weights, strict=True))
    mean = fsum([r * w for r, w in pairs]) / total
    square = fsum([w * w * (r - mean) ** 2 for r, w in pairs])
    return sqrt(square * n / (n - 1.0)) / total
