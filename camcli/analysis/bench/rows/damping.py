"""Rows 5 to 7: critical and heavy damping."""

from __future__ import annotations

from math import nextafter, sqrt

from camcli.analysis.bench.machine import Bench, Event, events, reference, run, settings
from camcli.analysis.bench.row import Row, need
from camcli.analysis.engine import Orbit
from camcli.errors import OK

CRITICAL = 2.0 * sqrt(1430.8 * 1.221)  # N s/m, 83.594...
SAME = 1e-9  # rad: phases beside critical damping, relative change 1e-12 of the damping
TIGHT = 1e-13  # chatter tolerance, turns
SAME_DEPARTURE = 2e-15  # rad


def critical(bench: Bench) -> str:
    """One ulp and 1e-12 beside critical damping: the same events, the same digits."""
    beside = [CRITICAL, nextafter(CRITICAL, 99.0), nextafter(CRITICAL, 0.0)]
    beside += [CRITICAL * (1.0 + 1e-12), CRITICAL * (1.0 - 1e-12)]
    worst = 0.0
    for rpm in (190.0, 300.0, 700.0):
        rows = [events(run(bench.chapter(damping=b), rpm)) for b in beside]
        for other in rows[1:]:
            need([e[:2] for e in other] == [e[:2] for e in rows[0]], f"other events at {rpm} rpm")
            pairs = zip(rows[0][:10], other[:10], strict=True)
            worst = max([worst, *(abs(a[2] - b[2]) for a, b in pairs)])
    need(worst < SAME, f"phases {worst:.1e} rad apart")
    return f"phases within {worst:.1e} rad on both sides"


def leading(rows: list[Event]) -> list[Event]:
    """Departures, and the landing that follows each."""
    before = [None, *rows]
    pairs = zip(before, rows, strict=False)
    return [e for b, e in pairs if e[0] == "detachment" or (b and b[0] == "detachment")]


def heavy(bench: Bench, names: tuple[str, ...], limit: float) -> str:
    """Heights at the end, departures and landings against the stored values of the oracle.

    A landing is compared in height, its difference of phase times the speed of the gap there.
    """
    height = phase = 0.0
    for name in names:
        stored = reference("stability")["heavy"][name]
        system, rpm, turns = (
            bench.chapter(damping=stored["damping"]),
            stored["rpm"],
            stored["turns"],
        )
        tape = run(system, rpm, record=turns, tolerance=TIGHT)
        need(tape.status == OK, f"status {tape.status} with b = {stored['damping']:g}")
        found, wanted = leading(events(tape)), stored["events"]
        need([e[:2] for e in found] == [tuple(e[:2]) for e in wanted], f"{len(found)} events")
        orbit = Orbit(system, rpm, settings(turns, tolerance=TIGHT))
        orbit.run(events=False)
        height = max(height, abs(orbit.position()[0] - float(stored["q"])))
        for (kind, _, theta, _, u), (_, _, exact) in zip(found, wanted, strict=True):
            off = abs(theta - float(exact))
            if kind == "impact":
                height = max(height, off * abs(u))
            else:
                phase = max(phase, off)
    seen = f"heights within {height:.1e} m; departures within {phase:.1e} rad"
    need(height < limit and phase < SAME_DEPARTURE, seen)
    return seen


ROWS = (
    Row("5: b critical +- 1 ulp and +- 1e-12", "continuous; same digits on both sides", critical),
    Row(
        "6: b > 6.6e3 at 115 rpm; > 4e4 at 700 rpm",
        "the oracle's stored value",
        lambda bench: heavy(bench, ("6.7e3 at 115", "4.1e4 at 700"), 5e-16),
    ),
    Row(
        "7: b = 1e9 and 1e12",
        "full precision against the oracle",
        lambda bench: heavy(bench, ("1e9 at 115", "1e12 at 115"), 2e-14),
    ),
)
