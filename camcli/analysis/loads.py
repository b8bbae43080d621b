"""What an engineer reads off a record: lift-off, hardest impact, contact force."""

from math import pi
from typing import NamedTuple

from camcli.analysis.integrate import Record
from camcli.interrupts import look
from camcli.kernel import backend, loads
from camcli.kernel.cam_table import TURN
from camcli.system import System, omega_of

EVENTS = 20_000  # of a call of the kernel: less than half a second
DEG = 180.0 / pi


class Loads(NamedTuple):
    """Of the recorded whole turns; None where it does not apply.

    max_gap_m: the largest q - c; airborne_fraction: share of the time off the cam;
    max_impact_m_per_s: the largest |u|; contact forces over the time at rest on the cam, N;
    contact_lost_deg, contact_regained_deg: the first phase after the strobe at which the follower
    leaves from rest, and the last at which it comes to rest; landing_deg, landing_lift_m: phase of
    the hardest impact, and lift above the lowest there; shut_bounces_per_turn: impacts, a
    tenth as hard as any before or harder, where the cam is within a hundredth of its lift above its
    lowest.
    """

    max_gap_m: float | None = None
    airborne_fraction: float | None = None
    max_impact_m_per_s: float | None = None
    min_contact_force_n: float | None = None
    max_contact_force_n: float | None = None
    contact_lost_deg: float | None = None
    contact_regained_deg: float | None = None
    landing_deg: float | None = None
    landing_lift_m: float | None = None
    shut_bounces_per_turn: float | None = None


def loads_of(system: System, rpm: float, record: Record) -> Loads:
    """Of a record with events and strobes; the kernel is the one in use."""
    turns = record.periods
    if turns == 0:
        return Loads()
    kernel, const = backend.current(), system.constants(rpm, 1.0, 1)
    strobe = system.cam.stretches[system.cam.strobe]
    q, w = float(record.strobe_q[0]), float(record.strobe_w[0])
    still = int((q, w) == (strobe.start_c, strobe.start_c1))
    begin = loads.Loads(phase=strobe.start, q=q, w=w, still=still)
    cam, table, count = system.cam_for(kernel), kernel.table(loads.Loads, [begin]), len(record.kind)
    for first in range(0, max(count, 1), EVENTS):
        look()
        part, last = slice(first, first + EVENTS), first + EVENTS >= count
        kernel.measure_loads(
            cam, const,
            kernel.numbers(record.kind[part], int), kernel.numbers(record.period[part], int),
            kernel.numbers(record.theta[part]), kernel.numbers(record.u[part]),
            turns, int(record.resting) if last else loads.GOES_ON, table,
        )  # fmt: skip
    found, omega = backend.row_of(loads.Loads, table[0]), omega_of(rpm)
    force = system.follower.mass * omega * omega
    rested, landed = found.min_force <= found.max_force, found.landing >= 0.0

    def phase(since: float) -> float | None:
        theta = system.strobe + since
        return None if since < 0.0 else (theta - TURN * (theta >= TURN)) * DEG

    return Loads(
        max_gap_m=found.max_gap,
        airborne_fraction=found.airborne / (TURN * turns),
        max_impact_m_per_s=found.max_impact * omega,
        min_contact_force_n=max(found.min_force, 0.0) * force if rested else None,
        max_contact_force_n=found.max_force * force if rested else None,
        contact_lost_deg=phase(found.lost),
        contact_regained_deg=phase(found.regained),
        landing_deg=found.landing * DEG if landed else None,
        landing_lift_m=found.landing_lift if landed else None,
        shut_bounces_per_turn=found.shut_bounces / turns,
    )
