"""Rows 17 to 20: grazes and hostile starts."""

from __future__ import annotations

from math import nextafter, pi

from camcli.analysis.bench.machine import Bench, events, reference, run, settings
from camcli.analysis.bench.row import Row, need
from camcli.analysis.integrate import Orbit, StartError
from camcli.errors import IMPACT_BUDGET, OK

AT_THE_GRAZE, FARTHEST = 1e-4, 1e-6  # rad; m/rad, of a contact that may count or not


def graze(bench: Bench) -> str:
    """Flights tangent to the cam within an ulp: at most one contact, without speed."""
    found = []
    flights = reference("stability")["grazes"]
    for flight in flights:
        start = {key: flight[key] for key in ("theta_deg", "q", "v")}
        tape = run(bench.chapter(), flight["rpm"], record=1, tolerance=1e-16, budget=4, **start)
        near = [
            abs(u)
            for kind, _, theta, _, u in events(tape, 1)
            if kind == "impact" and abs(theta - flight["at"]) < AT_THE_GRAZE
        ]
        need(len(near) <= 1 and tape.status in (OK, IMPACT_BUDGET), f"{len(near)} contacts")
        found += near
    need(max(found, default=0.0) < FARTHEST, f"a contact with {max(found):.1e} m/rad")
    fastest = f"; fastest {max(found):.1e} m/rad" if found else ""
    return f"{len(flights)} grazes; {len(found)} contacts{fastest}"


def at_rest(bench: Bench) -> str:
    """On the cam at its velocity: sticks where pressed, leaves where pulled."""
    for degrees in (0.0, 100.0, 150.17, 170.0, 250.0):
        tape = run(bench.chapter(), 100.0, record=1, theta_deg=degrees)
        need(not events(tape) and tape.resting, f"does not stick at {degrees} deg")
    for degrees in (151.0, 155.0, 159.0):
        rows = events(run(bench.chapter(), 190.0, record=1, theta_deg=degrees), 1)
        kind, _, theta, _, u = rows[0]
        later = kind == "impact" and theta > degrees * pi / 180.0 + 0.01 and u < 0.0
        need(later, f"{kind} at {theta * 180.0 / pi} deg from {degrees} deg")
    off = _at_zero_force(bench)
    need(off < 1e-7, f"from zero force the first impact is {off:.1e} rad off")
    return f"5 starts stick; 3 leave; no impact recorded; zero force: as if stuck to {off:.0e} rad"


def _at_zero_force(bench: Bench) -> float:
    """Started where a sticking ends (a = 0, a' > 0): difference of the next impact, rad."""
    machine = bench.chapter(damping=40.0)
    rows = events(run(machine, 160.0, record=1))
    leave = next(e[2] for e in rows if e[0] == "detachment")
    again = events(run(machine, 160.0, record=1, theta_deg=leave * 180.0 / pi), 1)
    first, second = (next(e[2] for e in some if e[0] == "impact") for some in (rows, again))
    return abs(first - second)


def into_the_cam(bench: Bench) -> str:
    """On the cam with u < 0: one impact at t = 0, then something else."""
    for degrees in (0.0, 100.0, 155.0, 300.0):
        tape = run(bench.chapter(), 190.0, record=1, theta_deg=degrees, v=-20.0)
        rows = events(tape, 0 if degrees == 0.0 else 1)
        first = rows[0][0] == "impact" and rows[0][2] == degrees * (pi / 180.0)
        need(first and rows[1][1:3] > rows[0][1:3], f"{rows[:2]} from {degrees} deg")
    return "one impact at t = 0 from each of 4 phases"


def below_the_cam(bench: Bench) -> str:
    """Refused with the depth, one ulp below too; the command exits with 2."""
    machine = bench.chapter()
    c = Orbit(machine, 190.0, settings(1)).position()[0]
    try:
        Orbit(machine, 190.0, settings(1, q=nextafter(c, 0.0), v=0.0))
        need(False, "one ulp below the cam is accepted")
    except StartError:
        pass
    need(run(machine, 190.0, record=1, q=nextafter(c, 1.0), v=0.0).status == OK, "one ulp above")
    words = ["simulate", "--no-plot", "--rpm", "190", "--set", "run.start.q=0.05"]
    done = bench.command(words)
    need(done.code == 2 and "0.05 m below" in done.said, f"exit {done.code}: {done.said.strip()}")
    return "exit 2; 'found q = 0.05 m; 0.05 m below the cam'; one ulp below is below"


ROWS = (
    Row("17: exact graze +- 1 ulp", "at most one contact of near-zero speed", graze),
    Row("18: start with q = c; u = 0", "leaves or sticks; no impact recorded", at_rest),
    Row("19: start with q = c; u < 0", "one impact at t = 0", into_the_cam),
    Row("20: start below the cam", "exit 2 with the depth", below_the_cam),
)
