"""Brute-force bifurcation diagram: one orbit per speed, impact and stroboscopic sections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi

from camcli.analysis.engine import Cost, Orbit, Settings, Tape, compile_for
from camcli.analysis.labels import label
from camcli.errors import OK, STATUSES
from camcli.kernel import backend
from camcli.kernel.orbit import IMPACT
from camcli.parallel import run_pieces
from camcli.system import System

FIXED, UP, DOWN = "fixed", "up", "down"
LITTLE_WORK = 10_000  # turns in all that plain Python does before a compiler would be loaded


@dataclass(frozen=True)
class Speed:
    """Result at one speed. Columns are arrays or lists: rad -> deg, m, m/s already converted.

    impacts: (period, theta_deg, q_m, u_minus_m_per_s); strobe: (period, q_m, v_m_per_s, impacts,
    chatter). Either is None where it was not asked for. `impact_count` is of the recorded turns;
    exponent: the largest one per turn, None where it was not asked for or is not known.
    """

    rpm: float
    label: str
    impact_count: int
    status: int
    impacts: tuple | None
    strobe: tuple | None
    cost: Cost
    exponent: float | None = None


@dataclass(frozen=True)
class Sweep:
    """All speeds in the order they were run."""

    speeds: list[Speed]
    direction: str
    cost: Cost

    @property
    def troubled(self) -> list[Speed]:
        """Speeds whose status is not ok."""
        return [speed for speed in self.speeds if speed.status != OK]


def rpm_grid(start: float, stop: float, num: int) -> list[float]:
    """num speeds from start to stop, both exact; descending where start > stop."""
    if num == 1:
        return [start]
    return [stop if k == num - 1 else start + (stop - start) * (k / (num - 1)) for k in range(num)]


def sweep(
    system: System,
    rpms: Sequence[float],
    settings: Settings,
    *,
    direction: str = FIXED,
    impacts: bool = True,
    strobe: bool = True,
    lyapunov: bool = False,
    threads: int | None = None,
    on_speed: Callable[[Speed], None] = lambda speed: None,
) -> Sweep:
    """Run every speed; `up` and `down` carry the state from each speed to the next.

    `on_speed` is called with each finished speed, in order. Raises StartError before any work if
    the start lies below the cam.
    """
    if rpms:
        Orbit(system, rpms[0], settings)
    turns = len(rpms) * (settings.transient + settings.record)
    if backend.must_compile() or (backend.may_compile() and turns > LITTLE_WORK):
        compile_for(system)  # before the threads start
    exponent = _exponents(system) if lyapunov else None
    speeds: list[Speed] = []
    if direction == FIXED:

        def piece(rpm: float) -> Speed:
            return _at(system, rpm, settings, impacts, strobe, exponent)[0]

        results = run_pieces(piece, rpms, threads)
    else:
        results = _carried(
            system, sorted(rpms, reverse=direction == DOWN), settings, impacts, strobe, exponent
        )
    cost = Cost()
    for speed in results:
        speeds.append(speed)
        cost = cost + speed.cost
        on_speed(speed)
    return Sweep(speeds, direction, cost)


def _carried(system, rpms, settings, impacts, strobe, exponent):
    """Speeds one after the other, each starting where the one before ended."""
    start = settings.start
    for rpm in rpms:
        speed, orbit = _at(system, rpm, settings, impacts, strobe, exponent, start)
        start = orbit.here() if speed.status == OK else settings.start
        yield speed


def _exponents(system: System) -> Callable[[float, Tape], float | None]:
    """What measures the largest exponent of a record: of its solved orbit, else of its impacts."""
    from camcli.analysis.exponents import of_orbit, of_tape
    from camcli.analysis.orbits.identify import identify

    def exponent(rpm: float, tape: Tape) -> float | None:
        if tape.status != OK:
            return None
        orbit = identify(system, rpm, tape)
        found = of_tape(system, rpm, tape) if orbit is None else of_orbit(system, orbit)
        return None if found is None else found.largest

    return exponent


def _at(system: System, rpm, settings, impacts: bool, strobe: bool, exponent, start=None):
    orbit = Orbit(system, rpm, settings, start)
    tape = orbit.run(events=impacts or exponent is not None)
    n = tape.periods
    to_mps = orbit.omega
    rows = None
    if impacts:
        rows = _impact_rows(tape, to_mps)
    strobes = None
    if strobe:
        strobes = (
            range(n),
            tape.strobe_q[:n],
            _scaled(tape.strobe_w[:n], to_mps),
            tape.impacts[:n],
            tape.chatter[:n],
        )
    speed = Speed(
        rpm=rpm,
        label=label(tape),
        impact_count=int(sum(tape.impacts[:n])),
        status=tape.status,
        impacts=rows,
        strobe=strobes,
        cost=tape.cost,
        exponent=None if exponent is None else exponent(rpm, tape),
    )
    return speed, orbit


def _impact_rows(tape, omega: float) -> tuple:
    """(period, theta_deg, q_m, u_minus_m_per_s) of the impacts of whole recorded periods."""
    if isinstance(tape.kind, list):
        keep = [
            k
            for k, (kind, period) in enumerate(zip(tape.kind, tape.period, strict=True))
            if kind == IMPACT and period >= 0
        ]
        return (
            [tape.period[k] for k in keep],
            [tape.theta[k] * (180.0 / pi) for k in keep],
            [tape.q[k] for k in keep],
            [tape.u[k] * omega for k in keep],
        )
    keep = (tape.kind == IMPACT) & (tape.period >= 0)
    return (
        tape.period[keep],
        tape.theta[keep] * (180.0 / pi),
        tape.q[keep],
        tape.u[keep] * omega,
    )


def _scaled(values, factor: float):
    if isinstance(values, list):
        return [value * factor for value in values]
    return values * factor


def status_name(status: int) -> str:
    """The status as it stands in a CSV."""
    return STATUSES[status].name
