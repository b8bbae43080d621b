"""CSV text: numbers as the shortest text that reads back to the same double."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import repeat

from camcli.analysis.contact_loss.study import ContactLoss
from camcli.analysis.simulate import Simulation
from camcli.analysis.sweep import Speed, Sweep, status_name
from camcli.system import omega_of

TRAJECTORY = ("t_s", "theta_deg", "q_m", "v_m_per_s", "c_m", "c_dot_m_per_s", "contact")
EVENTS = ("t_s", "period", "theta_deg", "event", "q_m", "u_minus_m_per_s", "u_plus_m_per_s")
IMPACTS = ("rpm", "period", "theta_deg", "q_m", "u_minus_m_per_s")
STROBE = ("rpm", "period", "q_m", "v_m_per_s", "impacts", "chatter")
SPEEDS = ("rpm", "label", "impacts", "lyapunov_per_period", "status")

DETACH = ("quantity", "region", "theta_deg", "rpm", "omega_rad_per_s")
ACCUMULATION = ("rpm", "theta_deg")
CORNER_HITS = ("impact", "corner", "rpm")
FORCE = ("rpm", "theta_deg", "force_n")


def header(columns: Sequence[str]) -> str:
    """The first line."""
    return ",".join(columns) + "\n"


def mixed_rows(rows: Iterable[Sequence]) -> Iterator[str]:
    """Lines of rows that hold text beside numbers; no text here contains a comma or a quote."""
    for row in rows:
        yield ",".join([repr(v) if isinstance(v, float) else str(v) for v in row]) + "\n"


def number_rows(first: str, columns: Sequence[Iterable]) -> str:
    """Lines that begin with `first`, then numeric columns; equal numbers are formatted once."""
    texts = [repeat(first), *map(_texts, columns)]
    lines = "\n".join(map(",".join, zip(*texts, strict=False)))
    return lines + "\n" if lines else ""


def _texts(column: Iterable) -> list[str]:
    """repr of every value; a periodic orbit repeats few values, so each is formatted once."""
    values = column.tolist() if hasattr(column, "tolist") else list(column)
    distinct = set(values)
    if len(distinct) * 2 > len(values):
        return repr(values)[1:-1].split(", ") if values else []
    known = {value: repr(value) for value in distinct}
    return [known[value] for value in values]


def trajectory_csv(simulation: Simulation) -> Iterator[str]:
    """trajectory.csv"""
    yield header(TRAJECTORY)
    yield from mixed_rows(simulation.trajectory)


def events_csv(simulation: Simulation) -> Iterator[str]:
    """events.csv"""
    yield header(EVENTS)
    yield from mixed_rows(simulation.events)


def impacts_csv(sweep: Sweep) -> Iterator[str]:
    """impacts.csv, a speed at a time."""
    yield header(IMPACTS)
    for speed in sweep.speeds:
        yield _of_speed(speed, speed.impacts)


def strobe_csv(sweep: Sweep) -> Iterator[str]:
    """strobe.csv: the state at the start of each recorded period, and what happened in it."""
    yield header(STROBE)
    for speed in sweep.speeds:
        yield _of_speed(speed, speed.strobe)


def section_rows(sweep: Sweep, section: str) -> Iterator[tuple[Sequence, ...]]:
    """The columns of impacts.csv or strobe.csv, the speed first, a speed at a time."""
    for speed in sweep.speeds:
        columns = getattr(speed, section)
        yield [speed.rpm] * len(columns[0]), *columns


def speeds_csv(sweep: Sweep) -> Iterator[str]:
    """speeds.csv"""
    yield header(SPEEDS)
    for speed in sweep.speeds:
        exponent = "" if speed.exponent is None else speed.exponent
        row = (speed.rpm, speed.label, speed.impact_count, exponent, status_name(speed.status))
        yield from mixed_rows([row])


def detach_csv(study: ContactLoss) -> Iterator[str]:
    """detach.csv: critical speeds; a speed that does not exist is inf, without a phase."""
    yield header(DETACH)
    for c in study.critical_speeds:
        theta = c.theta_deg if c.finite else ""
        yield from mixed_rows([(c.quantity, c.region, theta, c.rpm, omega_of(c.rpm))])
    for hold in study.holds:
        if hold.detaches_rpm is not None:
            theta = "" if hold.theta_deg is None else hold.theta_deg
            omega = omega_of(hold.detaches_rpm)
            row = (hold.quantity, hold.region, theta, hold.detaches_rpm, omega)
            yield from mixed_rows([row])


def accumulation_csv(study: ContactLoss) -> Iterator[str]:
    """accumulation.csv"""
    yield header(ACCUMULATION)
    yield from mixed_rows((speed.rpm, end) for speed in study.speeds for end in speed.ends)


def corner_hits_csv(study: ContactLoss) -> Iterator[str]:
    """corner_hits.csv"""
    yield header(CORNER_HITS)
    yield from mixed_rows((hit.impact, hit.corner, hit.rpm) for hit in study.hits)


def force_csv(study: ContactLoss) -> Iterator[str]:
    """force.csv: two rows at a corner, one for each side."""
    yield header(FORCE)
    for curve in study.forces:
        yield number_rows(repr(curve.rpm), (curve.theta_deg, curve.force_n))


def _of_speed(speed: Speed, columns) -> str:
    return number_rows(repr(speed.rpm), columns)
