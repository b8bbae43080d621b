"""Tables on the loss of contact: titles, heads and rows of text."""

from math import degrees, inf, isclose
from typing import Any, NamedTuple

from camcli.analysis.speeds import Speed
from camcli.quantities import FOLLOWER, FORCE, LOADS, PRESSURE, RPM, SEAT, THETA, headed
from camcli.system import decimals, units_of
from camcli.words.detach import short_way
from camcli.words.in_print import with_minus_signs, written_out
from camcli.words.loads import load, struck
from camcli.words.machine import crank_of, digits_of
from camcli.words.speeds import spacing


class TextTable(NamedTuple):
    """A table of texts for the screen or a page."""

    title: str
    heads: list[str]
    rows: list[list[str]]


SEAT_DIGITS = {  # of what is shown of the seat
    "seat_velocity_m_per_s": 3,
    "seat_opening_velocity_m_per_s": 3,
    "seat_bounces_per_turn": 3,
    "seat_bounce_height_m": 3,
    "seat_open_deg": 4,
}
ROUNDING = 1e-9  # N
WORKING = "*"  # marks the working speed among others
MOST_DECIMALS = 6
DIGITS = {  # of the loads that are shown
    "max_gap_m": 3,
    "max_impact_m_per_s": 3,
    "landing_deg": 4,
    "landing_lift_m": 3,
    "shut_bounces_per_turn": 3,
}


def answers(result: Any) -> list[TextTable]:
    """The tables that have rows: past the loss of contact, seat, contact force, springs."""
    tables = [_past_loss(result), _on_seat(result), _kept_on_cam(result), _springs(result)]
    return [table for table in tables if table.rows]


def lists_of_motions(result: Any, most: int) -> list[list[list[str]]]:
    """The tables past the loss of contact as lists of a page, with so many rows at most.

    Their titles say where rows are left out. The working speed keeps its row.
    """
    lists = []
    for title, heads, rows in (_past_loss(result), _on_seat(result)):
        if not rows:
            continue
        kept = _spread_out(rows, most)
        if len(kept) < len(rows):
            title += f": {len(kept)} of {len(rows)} rows; more in speeds.csv"
        lists.append([[title], heads, *kept])
    return lists


def lists_of_forces(result: Any) -> list[list[list[str]]]:
    """The tables of the contact force and of the springs as lists of a page."""
    tables = (_kept_on_cam(result), _springs(result))
    lists = []
    for table in tables:
        if table.rows:
            rows = [[with_minus_signs(cell) for cell in row] for row in table.rows]
            lists.append([[table.title], table.heads, *rows])
    return lists


def _spread_out(rows: list[list[str]], most: int) -> list[list[str]]:
    """At most so many of the rows, the first and the last among them, and the marked one."""
    if len(rows) <= most:
        return rows
    kept = {round(k * (len(rows) - 1) / (most - 1)) for k in range(most)}
    kept |= {k for k, row in enumerate(rows) if row[0].endswith(WORKING)}
    return [rows[k] for k in sorted(kept)]


def _speed_heads(result: Any) -> list[str]:
    """The heads of the columns of speeds: of the cam, and of the crank where there is one."""
    names = ["cam", "crank"] if crank_of(result.scene) else ["cam"]
    return [headed(name, RPM.unit) for name in names]


def _speeds(result: Any, rpm: float) -> list[float]:
    """A speed of the cam, and that of the crank where there is one, rpm."""
    crank = crank_of(result.scene)
    return [rpm, crank * rpm] if crank else [rpm]


def _past_speeds(result: Any, rpm: float) -> list[str]:
    """A speed past the loss of contact (rpm of the cam), and that of the crank where there is one.

    They have the decimals that tell them from the next ones.
    """
    past = result.values.past
    if len(past) < 2:
        return [written_out(speed, 6) for speed in _speeds(result, rpm)]
    places = decimals(spacing([motion.rpm for motion in past]))
    return [f"{speed:.{places}f}" for speed in _speeds(result, rpm)]


def _past_loss(result: Any) -> TextTable:
    """The loads of the motions past the loss of contact, a row each."""
    units = units_of(result.system)
    _, per_newton = units.shown(FORCE.unit)
    heads = _speed_heads(result)
    rows = []
    for motion in result.values.past:
        loads = motion.loads
        row = _past_speeds(result, motion.rpm)
        for column, digits in DIGITS.items():
            _, scale = units.shown(LOADS[column].unit)
            row.append(_cell(load(loads, column), scale, digits))
        if loads.landing is not None:  # of seat and opening blow the lift says nothing
            lift_at = len(heads) + list(DIGITS).index("landing_lift_m")
            row[lift_at] = struck(result.system, loads.landing) or row[lift_at]
        least = loads.min_contact_force_n
        largest = loads.max_contact_force_n
        forces = ""
        if least is not None and largest is not None:
            forces = f"{_zero(least) * per_newton:.4g} to {largest * per_newton:.4g}"
        rows.append([*row, forces])
    heads += [units.head(LOADS[column]) for column in (*DIGITS, "max_contact_force_n")]
    return TextTable("Past the loss of contact", heads, rows)


def _on_seat(result: Any) -> TextTable:
    """How the follower comes to its seat past the loss of contact, and at the working speed.

    Also at a single speed that was asked for. No rows without a seat.
    """
    title = "On the seat"
    units = units_of(result.system)
    heads = [*_speed_heads(result), *(units.head(SEAT[column]) for column in SEAT_DIGITS)]
    if not result.system.has_seat:
        return TextTable(title, heads, [])
    at_work = result.values.at_work
    motions = list(result.values.past)
    for motion in (result.values.at_asked, at_work):
        if motion is not None and not any(isclose(motion.rpm, other.rpm) for other in motions):
            motions.append(motion)
    motions.sort(key=lambda motion: motion.rpm)
    rows = [_seat_row(result, motion) for motion in motions]
    if at_work is None:
        return TextTable(title, heads, rows)
    # a speed next to the working speed may read alike: then only the marked row stays
    marked = [row[0] for row in rows if row[0].endswith(WORKING)]
    rows = [row for row in rows if row[0] + WORKING not in marked]
    return TextTable(f"{title} ({WORKING}: the working speed)", heads, rows)


def _seat_row(result: Any, motion: Speed) -> list[str]:
    """A row of the table of the seat; the working speed has a mark."""
    units = units_of(result.system)
    work = result.values.at_work
    row = _past_speeds(result, motion.rpm)
    if work is not None and isclose(motion.rpm, work.rpm):
        row[0] += WORKING
    for column, digits in SEAT_DIGITS.items():
        _, scale = units.shown(SEAT[column].unit)
        row.append(_cell(load(motion.loads, column), scale, digits))
    return row


def _kept_on_cam(result: Any) -> TextTable:
    """The force, and the pressure if known, of a follower kept on the cam, a row for each speed."""
    units = units_of(result.system)
    newtons, per_newton = units.shown(FORCE.unit)
    _, per_pascal = units.shown(PRESSURE.unit)
    digits = digits_of(result.scene)
    curves = result.values.forces
    with_pressure = bool(curves and curves[0].pressure_pa)
    rows = []
    for curve in curves:
        largest, _ = curve.highest(curve.force_n)
        row = [written_out(speed, digits) for speed in _speeds(result, curve.rpm)]
        row.append(_cell(_zero(curve.lowest_n), per_newton, 4))
        row.append(_cell(degrees(curve.lowest_theta), digits=4))
        row.append(_cell(largest, per_newton, 4))
        if with_pressure:
            pressure, theta = curve.highest(curve.pressure_pa)
            row.append(_cell(pressure, per_pascal))
            row.append(_cell(degrees(theta), digits=4))
        rows.append(row)
    heads = [headed("least", newtons), headed("at", THETA.unit), headed("largest", newtons)]
    if with_pressure:
        heads += [units.head(PRESSURE), headed("at", THETA.unit)]
    title = "Contact force if the follower is kept on the cam"
    ratio = result.system.rocker_ratio
    if ratio != 1.0:
        title = f"Contact force at the valve, kept on the cam (lobe: {ratio:.6g} times)"
    return TextTable(title, [*_speed_heads(result), *heads], rows)


def _springs(result: Any) -> TextTable:
    """The springs that hold contact up to the speed asked for, a row each."""
    units = units_of(result.system)
    newtons, per_newton = units.shown(FORCE.unit)
    digits = digits_of(result.scene)
    rows = []
    for hold in result.values.holds:
        if hold.stiffness is None:
            continue
        holds_to = "never" if hold.detaches == inf else _cell(hold.detaches, digits=digits)
        rows.append(
            [
                short_way(hold),
                _cell(hold.stiffness, 1.0 / units.per_m, 4),
                _cell(hold.preload, per_newton, 4),
                _cell(hold.nose_n, per_newton, 4),
                holds_to,
                hold.status,
            ]
        )
    heads = [
        "spring",
        units.head(FOLLOWER["stiffness"]),
        units.head(FOLLOWER["preload"]),
        headed("at full lift", newtons),
        headed("holds to", RPM.unit),
        "status",
    ]
    return TextTable("Springs that hold contact", heads, rows)


def _cell(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    """A number times `scale`, of so many digits; empty for None.

    It has no more than MOST_DECIMALS decimals, unless it would be zero then.
    """
    if value is None:
        return ""
    scaled = value * scale
    return written_out(round(scaled, MOST_DECIMALS) or scaled, digits)


def _zero(force: float) -> float:
    """A force that is zero up to rounding is printed as zero."""
    return force if abs(force) > ROUNDING else 0.0
