"""What an engineer reads off a record: lift-off, hardest impact, contact force."""

from math import pi
from typing import NamedTuple

from camcli.analysis.integrate import Record
from camcli.interrupts import look
from camcli.kernel import backend, loads
from camcli.kernel.cam_table import TURN
from camcli.kernel.forms import row_of
from camcli.kernel.orbit_loop import DETACHMENT, IMPACT
from camcli.system import System, omega_of

EVENTS = 20_000  # of a call of the kernel: less than half a second
DEG = 180.0 / pi
SHUT = 0.01  # of the whole lift: a cam that is lifted by no more counts as shut
BOUNCE = 0.1  # of the hardest impact of the record: a softer one is no bounce that counts


class Loads(NamedTuple):
    """Of the recorded whole turns; None where it does not apply.

    max_gap_m: the largest q - c; airborne_fraction: share of the time off the cam;
    max_impact_m_per_s: the largest |u|; contact forces over the time at rest on the cam, N;
    contact_lost_deg, contact_regained_deg: the first phase after the strobe at which the follower
    leaves from rest, and the last at which it comes to rest; landing_deg, landing_lift_m: phase of
    the hardest impact, and lift above the lowest there; shut_bounces_per_turn: impacts, a
    tenth as hard as the hardest or harder, where the cam is within a hundredth of its lift above
    its lowest.
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
    lowest, highest = system.lift_range
    recorded = (record.period >= 0) & (record.period < turns)
    rates = -record.u[recorded & (record.kind == IMPACT)]
    strobe = system.cam.stretches[system.cam.strobe]
    q, w = float(record.strobe_q[0]), float(record.strobe_w[0])
    begin = loads.Loads(
        phase=strobe.start,
        gap=q - strobe.start_c,
        rate=w - strobe.start_c1,
        still=int(_begins_at_rest(system, record)),
        shut=lowest + SHUT * (highest - lowest),
        bounce=BOUNCE * float(rates.max(initial=0.0)),
    )
    cam, table, count = system.cam_for(kernel), kernel.table(loads.Loads, [begin]), len(record.kind)
    for first in range(0, max(count, 1), EVENTS):
        look()
        part, last = slice(first, first + EVENTS), first + EVENTS >= count
        kernel.measure_loads(
            cam, const,
            kernel.numbers(record.kind[part], int), kernel.numbers(record.period[part], int),
            kernel.numbers(record.theta[part]), kernel.numbers(record.u[part]),
            turns, int(_ends_at_rest(record)) if last else loads.GOES_ON, table,
        )  # fmt: skip
    found, omega = row_of(loads.Loads, table[0]), omega_of(rpm)
    force = system.follower.mass * omega * omega
    rested, landed = found.min_force <= found.max_force, found.landing >= 0.0

    def phase(since: float) -> float | None:
        if since < 0.0:
            return None
        theta = system.strobe + since
        return (theta - TURN if theta >= TURN else theta) * DEG

    return Loads(
        max_gap_m=found.max_gap,
        airborne_fraction=found.airborne / (TURN * turns),
        max_impact_m_per_s=found.max_impact * omega,
        min_contact_force_n=max(found.min_force, 0.0) * force if rested else None,
        max_contact_force_n=found.max_force * force if rested else None,
        contact_lost_deg=phase(found.lost),
        contact_regained_deg=phase(found.regained),
        landing_deg=found.landing * DEG if landed else None,
        landing_lift_m=found.landing_c - lowest if landed else None,
        shut_bounces_per_turn=found.shut_bounces / turns,
    )


def _begins_at_rest(system: System, record: Record) -> bool:
    """Whether the follower rests on the cam at the first strobe, unless a detachment says so.

    On the cam at its velocity, to the last bit, it may still be in a hop lower than that: then the
    next event is a chatter, or an impact elsewhere than at an upward kink.
    """
    strobe = system.cam.stretches[system.cam.strobe]
    if (record.strobe_q[0], record.strobe_w[0]) != (strobe.start_c, strobe.start_c1):
        return False
    later = (record.period >= 0).nonzero()[0]
    if not len(later) or record.kind[later[0]] == DETACHMENT:
        return True
    theta = float(record.theta[later[0]])
    kinks = [stretch.start for stretch in system.cam.stretches if stretch.slope_jump > 0.0]
    return record.kind[later[0]] == IMPACT and theta in kinks


def _ends_at_rest(record: Record) -> bool:
    """Whether the follower rests at the end of the last whole turn.

    Where the run broke off later, the next event tells.
    """
    later = (record.period >= record.periods).nonzero()[0]
    return bool(record.kind[later[0]] == DETACHMENT if len(later) else record.resting)
