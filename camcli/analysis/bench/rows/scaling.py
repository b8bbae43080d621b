"""Rows 10 to 14: powers of two, a thousandth and a million turns per minute, a stiff spring."""

from __future__ import annotations

from camcli.analysis.bench.cases import case
from camcli.analysis.bench.compare import compare
from camcli.analysis.bench.machine import Bench, phases, run
from camcli.analysis.bench.peers import core
from camcli.analysis.bench.row import Row, need
from camcli.analysis.labels import label
from camcli.errors import OK

STIFFNESS = 1430.8


def faster(bench: Bench) -> str:
    """k times 4^n, b, rpm and v times 2^n, g times 4^n: time runs 2^n times as fast."""
    compared = 0
    for damping in (0.0, 20.0):
        machine = bench.chapter(damping=damping, gravity=1.0)
        plain = run(machine, 358.5, record=40, q=0.3, v=2.0)
        for n in (-20, 20):
            f = 2.0**n
            more = {"stiffness": STIFFNESS * f * f, "damping": damping * f, "gravity": f * f}
            scaled = run(bench.chapter(**more), 358.5 * f, record=40, q=0.3, v=2.0 * f)
            need(list(plain.theta) == list(scaled.theta), f"other phases with n = {n}")
            need(list(plain.strobe_w) == list(scaled.strobe_w), f"other states with n = {n}")
            compared += len(scaled.theta)
    return f"{compared} phases identical"


def heavier(bench: Bench) -> str:
    """m, k, b and the preload times 2^n: every acceleration stays."""
    base = {"mass": 1.221, "stiffness": STIFFNESS, "damping": 3.0, "preload": 5.0}
    plain = list(run(bench.chapter(**base), 700.0, record=60).theta)
    for n in (-40, -1, 7, 40):
        scaled = bench.chapter(**{key: value * 2.0**n for key, value in base.items()})
        need(plain == list(run(scaled, 700.0, record=60).theta), f"other phases with n = {n}")
    return f"{4 * len(plain)} phases identical"


def slow(bench: Bench) -> str:
    """1e-3 rpm sticks; at 150 rpm a late turn has the bits of an early one."""
    tape = run(bench.chapter(), 1e-3, record=2000)
    need(tape.status == OK and label(tape) == "contact", f"{label(tape)}; status {tape.status}")
    early, late = (run(bench.chapter(), 150.0, record=1, transient=n) for n in (10, 2000))
    need(phases(early) == phases(late), "phases drift with the turns")
    return f"contact for {tape.periods} turns; phases of turn 2000 those of turn 10"


def fast(bench: Bench) -> str:
    """1e6 rpm: flights of thousands of turns cost little, and the command warns of the height."""
    tape = run(bench.chapter(), 1e6, record=20_000)
    cost = tape.cost
    seen = f"{cost.impacts} impacts; {cost.evaluations} evaluations; {cost.crossings} crossings"
    need(tape.status == OK and 5 < cost.impacts < 100, seen)
    need(cost.evaluations < 20 * cost.impacts and cost.crossings < 40_000, seen)
    words = ["simulate", "--no-plot", "--rpm", "1e6", "--set", "simulate.samples=1"]
    done = bench.command([*words, "--set", "run.transient=0", "--set", "run.record=2000"])
    need("rises to" in done.said, f"said: {done.said.strip() or 'nothing'}")
    return f"{seen} in 20000 turns; warning said"


def stiff(bench: Bench) -> str:
    """k = 1e8 at 50000 rpm against the oracle's stored motion, as exact as the others."""
    stored, tolerance = case("stiff"), 1e-13
    tape = core.run(stored.system(bench), stored.rpm, stored.start, stored.turns, tolerance)
    found = compare(stored, tape, tolerance)
    seen = f"{len(tape.hits)} impacts; {found.missed} missed; error {found.error:.1e} turns"
    need(found.missed == found.extra == 0 and found.excess <= 1.0, seen)
    return f"{seen}; {found.excess:.2f} of the bound at most"


ROWS = (
    Row("10: k 4^n; rpm and v 2^n; n = +-20", "bit-identical phases", faster),
    Row("11: m; k; b times 2^n", "bit-identical phases", heavier),
    Row("12: 1e-3 rpm; many turns", "sticks throughout; phases exact after many turns", slow),
    Row("13: 1e6 rpm", "bounded cost; warning", fast),
    Row("14: k = 1e8 N/m at 50000 rpm", "as exact as the chapter's machine", stiff),
)
