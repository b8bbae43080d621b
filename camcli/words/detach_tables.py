"""Tables on the loss of contact: titles, heads and rows of text."""

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from math import degrees, inf
from typing import Any

from camcli.analysis.loads import Loads
from camcli.quantities import FOLLOWER, FORCE, LOADS, PRESSURE, RPM, SEAT, THETA, headed
from camcli.system import decimals, units_of
from camcli.words.detach import short_way
from camcli.words.in_print import written_out
from camcli.words.loads import load
from camcli.words.machine import crank_of, digits_of

SEAT_DIGITS = {  # of what is shown of the seat
    "seat_velocity_m_per_s": 3,
    "seat_opening_velocity_m_per_s": 3,
    "seat_bounces_per_turn": 3,
    "seat_bounce_height_m": 3,
    "seat_open_deg": 4,
}
ROUNDING = 1e-9  # N
MOST_DECIMALS = 6
DIGITS = {  # of the loads that are shown
    "max_gap_m": 3,
    "max_impact_m_per_s": 3,
    "landing_deg": 4,
    "landing_lift_m": 3,
    "shut_bounces_per_turn": 3,
}


def spacing(speeds: Sequence[float]) -> float:
    """The least between neighbouring speeds, rpm."""
    return min((b - a for a, b in pairwise(sorted(set(speeds)))), default=0.1)


def answers(result: Any) -> list[tuple[str, list[str], list[list[str]]]]:
    """Tables (title, heads, rows): past the loss of contact; contact force; springs that hold."""
    found, units = result.values, units_of(result.system)
    crank = crank_of(result.scene)
    names = [headed(what, RPM.unit) for what in (["cam", "crank"] if crank else ["cam"])]
    exact, seen = digits_of(result.scene), decimals(spacing([s.rpm for s in found.past]))

    def speed(rpm: float, form: str) -> list[str]:
        if form.endswith("g"):
            return [written_out(x * rpm, exact) for x in (1.0, crank) if x]
        return [f"{x * rpm:{form}}" for x in (1.0, crank) if x]

    def shown(loads: Loads, column: str) -> str:
        _, scale = units.shown(LOADS[column].unit)
        return _cell(load(loads, column), scale, DIGITS[column])

    def between(low: float | None, high: float | None) -> str:
        """Two forces (N) as a range in the unit shown; empty where they are not known."""
        if low is None or high is None:
            return ""
        return f"{_zero(low) * per_newton:.4g} to {high * per_newton:.4g}"

    newtons, per_newton = units.shown(FORCE.unit)

    past = [
        [*speed(s.rpm, f".{seen}f"), *map(partial(shown, s.loads), DIGITS),
         between(s.loads.min_contact_force_n, s.loads.max_contact_force_n)]
        for s in found.past
    ]  # fmt: skip
    loads = [units.head(LOADS[column]) for column in (*DIGITS, "max_contact_force_n")]
    seat = [
        [*speed(s.rpm, f".{seen}f"),
         *(_cell(load(s.loads, column), units.shown(SEAT[column].unit)[1], digits)
           for column, digits in SEAT_DIGITS.items())]
        for s in (found.past if result.system.has_seat else ())
    ]  # fmt: skip
    _, pressures = units.shown(PRESSURE.unit)
    forces = [
        [*speed(f.rpm, f".{exact}g"), _cell(_zero(f.lowest_n), per_newton, 4),
         _cell(degrees(f.lowest_theta), digits=4), _cell(f.highest(f.force_n)[0], per_newton, 4),
         *([_cell(f.highest(f.pressure_pa)[0], pressures)] if f.pressure_pa else [])]
        for f in found.forces
    ]  # fmt: skip
    kept = [headed("least", newtons), headed("at", THETA.unit), headed("largest", newtons)]
    if found.forces and found.forces[0].pressure_pa:
        kept.append(units.head(PRESSURE))
    ratio = result.system.rocker_ratio
    kept_on = "Contact force if the follower is kept on the cam"
    if ratio != 1.0:
        kept_on = f"Contact force at the valve, kept on the cam (lobe: {ratio:.6g} times)"
    springs = [
        [short_way(h), _cell(h.stiffness, 1.0 / units.per_m, 4), _cell(h.preload, per_newton, 4),
         _cell(h.nose_n, per_newton, 4),
         "never" if h.detaches == inf else _cell(h.detaches, digits=exact), h.status]
        for h in found.holds
        if h.stiffness is not None
    ]  # fmt: skip
    tables = [
        ("Past the loss of contact", [*names, *loads], past),
        ("On the seat", [*names, *(units.head(SEAT[column]) for column in SEAT_DIGITS)], seat),
        (kept_on,
         [*names, *kept], forces),
        ("Springs that hold contact",
         ["spring", units.head(FOLLOWER["stiffness"]), units.head(FOLLOWER["preload"]),
          headed("at full lift", newtons), headed("holds to", RPM.unit), "status"], springs),
    ]  # fmt: skip
    return [(title, heads, rows) for title, heads, rows in tables if rows]


def _cell(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    """A number of so many digits, and of no more than MOST_DECIMALS unless it is smaller."""
    if value is None:
        return ""
    shown = value * scale
    return written_out(round(shown, MOST_DECIMALS) or shown, digits)


def _zero(force: float) -> float:
    """A force that is zero up to rounding is printed as zero."""
    return force if abs(force) > ROUNDING else 0.0
