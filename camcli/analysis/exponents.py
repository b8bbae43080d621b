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
        """Positive by three standard errors, and by more than its convergence could feign."""
        return self.largest > 3.0 * self.spread and self.largest > 0.0


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
    """From the logged impacts of a record; None where there are too few to say anything."""
    const = system.constants(rpm, 1.0, 1)
    kernel = backend.current()
    cam = system.cam_for(kernel)
    rows = len(record.kind)
    if rows // BATCHES < FEWEST or const.r == 0.0 or (system.has_seat and const.r_seat == 0.0):
        return None
    pairs = kernel.table(Pair, [Pair()])
    growths = kernel.copies(Growth, Growth(), BATCHES)
    columns = [kernel.numbers(x, int) for x in (record.kind, record.period)]
    columns += [kernel.numbers(x) for x in (record.theta, record.u)]
    kernel.stretch_events(cam, const, *columns, pairs, growths)
    parts = rows_of(Growth, growths)
    logs = []  # (logarithm of the first difference's growth, length) of each part
    first = area = impacts = length = 0.0
    for part in parts:
        if not part.length > 0.0 or part.first == 0.0 or part.area == 0.0:
            continue
        logs.append((part.first_log, part.length))
        first += part.first_log
        area += part.area_log
        impacts += part.impacts
        length += part.length
    if any(part.chatters for part in parts):
        return Exponents(-inf, -inf, 0.0, -inf, inf)
    if length == 0.0:
        return None
    turns = length / TURN
    largest = first / turns
    rates = [one / span * TURN for one, span in logs]
    spread = _standard_error(rates, [span for _, span in logs])
    per_turn = impacts / turns
    on_seat = 0.0
    if system.has_seat:
        carried = record.theta[record.kind == IMPACT][1:]  # the first one begins the pair
        on_seat = _on_seat(system, carried) / turns
    return Exponents(
        largest, area / turns - largest, spread, sum_rule(const, per_turn, on_seat), per_turn
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
