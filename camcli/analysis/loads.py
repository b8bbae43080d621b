"""What an engineer reads off a record: lift-off, hardest impact, contact force."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from camcli.analysis.integrate import Record, shut_lift
from camcli.cams.compile import build, lift_range
from camcli.interrupts import raise_if_interrupted
from camcli.kernel import backend, loads
from camcli.kernel.cam_table import TURN, Cam, stretch_at
from camcli.kernel.flow import move
from camcli.kernel.forms import row_of
from camcli.kernel.orbit_loop import IMPACT, Log
from camcli.system import REMEMBERED, System, is_measured, omega_of

SAME_LEVEL = 1e-6  # of the lift: a dwell no higher is the base circle
EVENTS = 20_000  # of a call of the kernel: less than half a second


class Loads(NamedTuple):
    """What loads a motion puts on the machine in its whole recorded turns; None: does not apply.

    max_gap_m: the largest q - c; airborne_fraction: share of the time off the cam;
    max_impact_m_per_s: the largest |u|; contact forces over the time at rest on the cam, N;
    contact_lost, contact_regained: the first phase (rad) after the strobe at which the follower
    leaves from rest, and the last at which it comes to rest; landing, landing_lift_m: phase (rad)
    of the hardest impact, and lift above the lowest there; shut_bounces_per_turn: impacts, a
    tenth as hard as the hardest or harder, where the cam is within a hundredth of its lift above
    its lowest.
    """

    max_gap_m: float | None = None
    airborne_fraction: float | None = None
    max_impact_m_per_s: float | None = None
    min_contact_force_n: float | None = None
    max_contact_force_n: float | None = None
    contact_lost: float | None = None
    contact_regained: float | None = None
    landing: float | None = None
    landing_lift_m: float | None = None
    shut_bounces_per_turn: float | None = None
    # of a cam with lash, as `quantities.SEAT` says them; angles in rad
    seat_velocity_m_per_s: float | None = None
    seat_ramp_velocity_m_per_s: float | None = None
    seat_opening_velocity_m_per_s: float | None = None
    seat_bounces_per_turn: float | None = None
    seat_bounce_height_m: float | None = None
    seat_lift_lost_m: float | None = None
    seat_open: float | None = None
    seat_open_lash: float | None = None
    seat_open_drawn: float | None = None
    seat_lobe_fraction: float | None = None


def loads_of(system: System, rpm: float, record: Record) -> Loads:
    """The loads of a record that has its events and strobes, by the kernel that is in use."""
    turns = record.periods
    if turns == 0:
        return Loads()
    found = _measured(system, rpm, record) if record.loads is None else record.loads
    omega = omega_of(rpm)
    lowest = system.lift_range[0]
    force = system.follower.mass * omega * omega
    rested = found.min_force <= found.max_force
    landed = found.landing >= 0.0

    def phase(since: float) -> float | None:
        if since < 0.0:
            return None
        theta = system.strobe + since
        return theta - TURN if theta >= TURN else theta

    return Loads(
        max_gap_m=found.max_gap,
        airborne_fraction=found.airborne / (TURN * turns),
        max_impact_m_per_s=found.max_impact * omega,
        min_contact_force_n=max(found.min_force, 0.0) * force if rested else None,
        max_contact_force_n=found.max_force * force if rested else None,
        contact_lost=phase(found.lost),
        contact_regained=phase(found.regained),
        landing=found.landing if landed else None,
        landing_lift_m=found.landing_c - lowest if landed else None,
        shut_bounces_per_turn=found.shut_bounces / turns,
        **(seat_loads(system, rpm, record, found) if system.has_seat else {}),
    )


def seat_loads(
    system: System, rpm: float, record: Record, found: loads.Loads
) -> dict[str, float | None]:
    """The fields of `Loads` that are of the seat, by their names."""
    cam = system.cam
    omega = omega_of(rpm)
    turns = record.periods
    on_seat: list[float] = []  # rates of impacts, m/rad
    openings: list[float] = []
    flights: list[tuple[float, float]] = []  # (rate after an impact on the seat, rad to the next)
    came_from_seat = False
    left: tuple[float, float] | None = None  # (place, rate) of the last impact on the seat
    for kind, period, theta, _, u in record.events():
        if not 0 <= period < turns:
            continue
        place = TURN * period + (theta - system.strobe) % TURN
        if left is not None:
            flights.append((left[1], place - left[0]))
            left = None
        i = stretch_at(cam, theta)
        seat = bool(cam.stretches[i].seat)
        if kind == IMPACT and seat:
            on_seat.append(-u)
            left = place, -system.restitution(i) * u
        elif kind == IMPACT and (came_from_seat or _takes_over(cam, i, theta)):
            openings.append(-u)
        came_from_seat = seat
    hardest = max(on_seat, default=0.0)
    bounces = sum(u >= loads.BOUNCE * hardest for u in on_seat)
    whole = TURN * turns
    return {
        "seat_velocity_m_per_s": hardest * omega if on_seat else None,
        "seat_ramp_velocity_m_per_s": _closing_slope(cam) * omega,
        "seat_opening_velocity_m_per_s": max(openings) * omega if openings else None,
        "seat_bounces_per_turn": bounces / turns,
        "seat_bounce_height_m": _highest(system, rpm, flights),
        "seat_lift_lost_m": system.lash,
        "seat_open": (whole - found.seated) / turns,
        "seat_open_lash": TURN - _on_seat(cam),
        "seat_open_drawn": _open_as_drawn(system),
        "seat_lobe_fraction": max(whole - found.airborne - found.seated, 0.0) / whole,
    }


def _takes_over(cam: Cam, i: int, theta: float) -> bool:
    """Whether stretch i begins at theta (rad), and with it the lobe behind the seat."""
    return theta == cam.stretches[i].start and bool(cam.stretches[i - 1].seat)


def _closing_slope(cam: Cam) -> float:
    """The steepest fall of the cam where it lets the follower down on its seat, m/rad."""
    stretches = cam.stretches
    closing = [i for i, one in enumerate(stretches) if one.seat and not stretches[i - 1].seat]
    return max([0.0, *(-stretches[i - 1].end_c1 for i in closing)])


def _flat(cam: Cam) -> float:
    """How much of a turn lies on the base circle, rad."""
    low, high = lift_range(cam)
    level = low + SAME_LEVEL * (high - low)
    return sum(one.end - one.start for one in cam.stretches if one.dwell and one.start_c <= level)


def _open_as_drawn(system: System) -> float:
    """How much of a turn the lobe as it is drawn is above its base circle, rad.

    A measured lobe is that where its table tells it from the base circle: a fit of rounded lifts is
    exactly flat nowhere near its flanks.
    """
    drawn = system.as_drawn
    if is_measured(drawn):
        table: Any = drawn.shape
        return _above(table, table.least_lift)
    return TURN - _flat(drawn.cam)


@lru_cache(maxsize=REMEMBERED)
def _above(shape: Any, height: float) -> float:
    """How much of a turn a lobe is higher than this above its base circle (m), rad."""
    cam = build(shape.model_copy(update={"lash": height}))
    return TURN - _on_seat(cam)


def _on_seat(cam: Cam) -> float:
    """How much of a turn is the seat, rad."""
    return sum(one.end - one.start for one in cam.stretches if one.seat)


def _highest(system: System, rpm: float, flights: Sequence[tuple[float, float]]) -> float | None:
    """The highest of flights from the seat, each of a rate (m/rad) and a length (rad); m above it.

    Of two flights that both come to their tops the faster one is higher, so that the slower flights
    matter only as long as the lobe has cut the faster ones short.
    """
    if not flights:
        return None
    const = system.constants(rpm, 1.0, 1)
    seat = system.lift_range[0]
    highest = 0.0
    for rate, length in sorted(flights, reverse=True):
        cut_short = move(const, seat, rate, length)[1] > 0.0
        low, high = (length, length) if cut_short else (0.0, length)
        while low < (middle := 0.5 * (low + high)) < high:
            if move(const, seat, rate, middle)[1] > 0.0:
                low = middle
            else:
                high = middle
        highest = max(highest, move(const, seat, rate, low)[0] - seat)
        if not cut_short:
            break
    return highest


def _measured(system: System, rpm: float, record: Record) -> loads.Loads:
    """The loads of a record that were not measured when it was made."""
    kernel = backend.current()
    const = system.constants(rpm, 1.0, 1)
    strobe = system.cam.stretches[system.cam.strobe]
    rows = len(record.kind)
    begin = loads.Loads(
        turns=record.periods,
        resting=int(record.resting),
        shut=shut_lift(system),
        gap=float(record.strobe_q[0]) - strobe.start_c,
        rate=float(record.strobe_w[0]) - strobe.start_c1,
    )
    table = kernel.table(loads.Loads, [begin])
    log = Log(
        kernel.numbers(record.kind, int), kernel.numbers(record.period, int),
        kernel.numbers(record.theta), kernel.numbers(record.q), kernel.numbers(record.u), rows,
    )  # fmt: skip
    for first in range(0, max(rows, 1), EVENTS):
        raise_if_interrupted()
        last = min(first + EVENTS, rows)
        kernel.measure_loads(system.cam_for(kernel), const, log, first, last, rows, table)
    return row_of(loads.Loads, table[0])
