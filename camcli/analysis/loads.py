"""What an engineer reads off a record: lift-off, hardest impact, contact force."""

from typing import NamedTuple

from camcli.analysis.integrate import Record, shut_lift
from camcli.interrupts import look
from camcli.kernel import backend, loads
from camcli.kernel.cam_table import TURN
from camcli.kernel.forms import row_of
from camcli.kernel.orbit_loop import Log
from camcli.system import System, omega_of

EVENTS = 20_000  # of a call of the kernel: less than half a second


class Loads(NamedTuple):
    """Of the recorded whole turns; None where it does not apply.

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


def loads_of(system: System, rpm: float, record: Record) -> Loads:
    """Of a record with events and strobes; the kernel is the one in use."""
    turns = record.periods
    if turns == 0:
        return Loads()
    found = _measured(system, rpm, record) if record.loads is None else record.loads
    omega, lowest = omega_of(rpm), system.lift_range[0]
    force = system.follower.mass * omega * omega
    rested, landed = found.min_force <= found.max_force, found.landing >= 0.0

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
    )


def _measured(system: System, rpm: float, record: Record) -> loads.Loads:
    """The loads of a record that were not measured when it was made."""
    kernel, const = backend.current(), system.constants(rpm, 1.0, 1)
    strobe, rows = system.cam.stretches[system.cam.strobe], len(record.kind)
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
        look()
        last = min(first + EVENTS, rows)
        kernel.measure_loads(system.cam_for(kernel), const, log, first, last, rows, table)
    return row_of(loads.Loads, table[0])
