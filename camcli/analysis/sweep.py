"""Brute-force bifurcation diagram: one orbit per speed, impact and stroboscopic sections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi

from camcli.analysis.integrate import Cost, Orbit, Record, Settings, Start
from camcli.analysis.labels import label
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.orbit_loop import IMPACT
from camcli.parallel import Codec, Work
from camcli.system import System

FIXED, UP, DOWN = "fixed", "up", "down"


@dataclass(frozen=True)
class Speed:
    """Result at one speed. Columns are arrays or lists: rad -> deg, m, m/s already converted.

    impacts: (period, theta_deg, q_m, u_minus_m_per_s); strobe: (period, q_m, v_m_per_s, impacts,
    chatter). Either is None where it was not asked for. `impact_count` is of the recorded turns;
    exponent: the largest one per turn, None where it was not asked for or is not known; end: where
    the next speed starts, of a sweep that carries its state.
    """

    rpm: float
    label: str
    impact_count: int
    status: int
    impacts: tuple | None
    strobe: tuple | None
    cost: Cost
    exponent: float | None = None
    end: Start | None = None


@dataclass(frozen=True)
class Sweep:
    """All speeds in the order they were run."""

    speeds: Sequence[Speed]
    direction: str
    cost: Cost

    @property
    def troubled(self) -> list[Speed]:
        """Speeds whose status is not ok, without their sections."""
        return [bare(speed) for speed in self.speeds if speed.status != Status.OK]


def bare(speed: Speed) -> Speed:
    """The speed without its sections: what a summary keeps of it."""
    return replace(speed, impacts=None, strobe=None)


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
    work: Work | None = None,
    on_speed: Callable[[Speed], None] = lambda speed: None,
) -> Sweep:
    """Run every speed; `up` and `down` carry the state from each speed to the next.

    Where `work` has a checkpoint, the speeds are kept in it and read from it. `on_speed` is called
    with each finished speed, in order. Raises StartError before any work if the start lies below
    the cam.
    """
    if rpms:
        Orbit(system, rpms[0], settings)
    turns = len(rpms) * (settings.transient + settings.record)
    task = _Task(system, settings, impacts, strobe, lyapunov, turns)
    work, cost = work or Work(), Cost()

    def count(speed: Speed) -> None:
        nonlocal cost
        cost = cost + speed.cost
        on_speed(speed)

    if direction == FIXED:
        speeds = work.collect(task, rpms, CODEC, count)
    else:
        ordered = sorted(rpms, reverse=direction == DOWN)
        speeds = work.collect_chain(task.after, None, ordered, CODEC, count)
    return Sweep(speeds, direction, cost)


@dataclass(frozen=True)
class _Task:
    """One speed, wherever it is computed."""

    system: System
    settings: Settings
    impacts: bool
    strobe: bool
    lyapunov: bool
    turns: int  # of all speeds

    def __call__(self, rpm: float) -> Speed:
        """The speed, from the start of the scene."""
        return self._at(rpm, None)[0]

    def after(self, before: Speed | None, rpm: float) -> Speed:
        """The speed, from where the one before ended."""
        start = self.settings.start
        speed, orbit = self._at(rpm, start if before is None else before.end)
        return replace(speed, end=orbit.as_start() if speed.status == Status.OK else start)

    def _at(self, rpm: float, start: Start | None) -> tuple[Speed, Orbit]:
        backend.for_work(self.turns)
        orbit = Orbit(self.system, rpm, self.settings, start)
        record = orbit.run(events=self.impacts or self.lyapunov)
        n, to_mps = record.periods, orbit.omega
        strobe = (range(n), record.strobe_q[:n], _scaled(record.strobe_w[:n], to_mps))
        speed = Speed(
            rpm=rpm,
            label=label(record),
            impact_count=int(sum(record.impacts[:n])),
            status=record.status,
            impacts=_impact_rows(record, to_mps) if self.impacts else None,
            strobe=(*strobe, record.impacts[:n], record.chatter[:n]) if self.strobe else None,
            cost=record.cost,
            exponent=_exponent(self.system, rpm, record) if self.lyapunov else None,
        )
        return speed, orbit


def _store(speed: Speed) -> list:
    cost, end = speed.cost, speed.end
    return [
        speed.rpm,
        speed.label,
        speed.impact_count,
        speed.status,
        speed.impacts,
        None if speed.strobe is None else speed.strobe[1:],
        [cost.impacts, cost.evaluations, cost.crossings],
        speed.exponent,
        None if end is None else [end.q, end.v, end.theta_deg],
    ]


def _load(stored: list) -> Speed:
    rpm, label, count, status, impacts, strobe, cost, exponent, end = stored
    return Speed(
        rpm,
        label,
        count,
        status,
        None if impacts is None else tuple(impacts),
        None if strobe is None else (range(len(strobe[0])), *strobe),
        Cost(*cost),
        exponent,
        None if end is None else Start(*end),
    )


CODEC = Codec(_store, _load)


def _exponent(system: System, rpm: float, record: Record) -> float | None:
    """Largest exponent of a record: of its solved orbit, else of its impacts."""
    from camcli.analysis.exponents import of_orbit, of_record
    from camcli.analysis.orbits.identify import identify

    if record.status != Status.OK:
        return None
    orbit = identify(system, rpm, record)
    found = of_record(system, rpm, record) if orbit is None else of_orbit(system, orbit)
    return None if found is None else found.largest


def _impact_rows(record, omega: float) -> tuple:
    """(period, theta_deg, q_m, u_minus_m_per_s) of the impacts of whole recorded periods."""
    if isinstance(record.kind, list):
        keep = [
            k
            for k, (kind, period) in enumerate(zip(record.kind, record.period, strict=True))
            if kind == IMPACT and period >= 0
        ]
        return (
            [record.period[k] for k in keep],
            [record.theta[k] * (180.0 / pi) for k in keep],
            [record.q[k] for k in keep],
            [record.u[k] * omega for k in keep],
        )
    keep = (record.kind == IMPACT) & (record.period >= 0)
    return (
        record.period[keep],
        record.theta[keep] * (180.0 / pi),
        record.q[keep],
        record.u[keep] * omega,
    )


def _scaled(values, factor: float):
    if isinstance(values, list):
        return [value * factor for value in values]
    return values * factor


def status_name(status: int) -> str:
    """The status as it stands in a CSV."""
    return Status(status).text
