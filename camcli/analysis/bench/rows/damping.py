"""Rows 5 to 7: critical and heavy damping.

How exact heights can be where a damper hardly lets the follower move; derived, not fitted:

* Heights are below 0.5 m, so one rounding is at most h = 2^-55 m (half an ulp), and c comes within
  1.5 ulp of the cam: CAM = 4 h with the rounding of q itself.
* A step of a flight rounds the height at most twice, q = c + gap and q + (w B - F P); the gap is
  the difference of two close numbers and exact. Roundings of a flight add up: the equation is
  linear, its response to a disturbance of the height is at most 1 and with such dampers nearly 1.
  A rebound starts on the cam again, so nothing is carried through a contact.
* N steps therefore make at most 2 N h. That worst case needs every rounding to fall the same way;
  independent ones, uniform within h, have a standard deviation of h sqrt(2 N/3), and SIGMAS of
  these is the limit. Evaluations of the gap stand for N: a step takes at least one.

So the limit depends on how many steps the search needs, not on the error that is seen. With
b = 1e12 the certificate of a step allows but short ones near the cam, N is large, and that is where
the digits go.
"""

from __future__ import annotations

from decimal import Decimal
from functools import partial
from math import nextafter, sqrt

from camcli.analysis.bench.machine import Bench, Event, events, reference, run, settings
from camcli.analysis.bench.row import Row, need
from camcli.analysis.integrate import Orbit
from camcli.errors import OK

CRITICAL = 2.0 * sqrt(1430.8 * 1.221)  # N s/m, 83.594...
SAME = 1e-9  # rad: phases beside critical damping, relative change 1e-12 of the damping
TIGHT = 1e-13  # chatter tolerance, turns
SAME_DEPARTURE = 2e-15  # rad, 4 roundings of an angle below 4 rad
HALF_ULP = 2.0**-55  # m, of heights from 0.25 to 0.5 m
CAM = 4.0 * HALF_ULP
SIGMAS = 6.0


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


def height_limit(steps: int) -> float:
    """What roundings of so many steps may do to a height (see the module), m."""
    return CAM + SIGMAS * HALF_ULP * sqrt(2.0 * steps / 3.0)


def heavy(bench: Bench, names: tuple[str, ...]) -> str:
    """Heights at the end, departures and landings against the stored values of the oracle.

    Every height must be within `height_limit` of the steps of its own run.
    """
    seen, share = [], 0.0
    for name in names:
        height, phase, steps = _against_oracle(bench, name)
        share = max(share, height / height_limit(steps))
        seen.append(f"{height:.1e} m in {steps} steps")
        need(phase < SAME_DEPARTURE, f"{name} rpm: departures {phase:.1e} rad off")
    told = f"{share:.2f} of the limit at most: {'; '.join(seen)}"
    need(share <= 1.0, told)
    return told


def _against_oracle(bench: Bench, name: str) -> tuple[float, float, int]:
    """(worst height, m; worst departure, rad; steps) of a stored run.

    A landing is compared in height: its difference of phase times the speed of the gap there.
    """
    stored = reference("stability")["heavy"][name]
    system, rpm, turns = bench.chapter(damping=stored["damping"]), stored["rpm"], stored["turns"]
    tape = run(system, rpm, record=turns, tolerance=TIGHT)
    need(tape.status == OK, f"status {tape.status} with b = {stored['damping']:g}")
    found, wanted = leading(events(tape)), stored["events"]
    need([e[:2] for e in found] == [tuple(e[:2]) for e in wanted], f"{len(found)} events")
    orbit = Orbit(system, rpm, settings(turns, tolerance=TIGHT))
    orbit.run(events=False)
    height, phase = abs(float(Decimal(orbit.position()[0]) - Decimal(stored["q"]))), 0.0
    for (kind, _, theta, _, u), (_, _, exact) in zip(found, wanted, strict=True):
        off = abs(float(Decimal(theta) - Decimal(exact)))
        if kind == "impact":
            height = max(height, off * abs(u))
        else:
            phase = max(phase, off)
    return height, phase, tape.cost.evaluations


ROWS = (
    Row("5: b critical +- 1 ulp and +- 1e-12", "continuous; same digits on both sides", critical),
    Row(
        "6: b > 6.6e3 at 115 rpm; > 4e4 at 700 rpm",
        "the oracle's stored value",
        partial(heavy, names=("6.7e3 at 115", "4.1e4 at 700")),
    ),
    Row(
        "7: b = 1e9 and 1e12",
        "against the oracle within the rounding of its steps",
        partial(heavy, names=("1e9 at 115", "1e12 at 115")),
    ),
)
