"""Rows 1 to 3, 8, 9, 24 and 25: restitution, no spring, no force."""

from __future__ import annotations

import json
from math import pi, sqrt

from camcli.analysis.bench.machine import Bench, events, phases, run, settings
from camcli.analysis.bench.row import Row, need
from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import label
from camcli.errors import IMPACT_BUDGET, NO_RETURN, OK, STATUSES

GRAVITY, HEIGHT, BOUNCE = 9.81, 1.0, 0.8  # of the dropped ball: m/s2, m, restitution


def kinds(tape) -> list[str]:
    """Kinds of the logged events, in order."""
    return [event[0] for event in events(tape)]


def plastic(bench: Bench) -> str:
    """r = 0: sticks after one impact where a < 0, leaves at once where a > 0."""
    tape = run(bench.chapter(restitution=0.0), 190.0, record=4)
    need(kinds(tape)[:3] == ["detachment", "impact", "detachment"], f"events {kinds(tape)[:3]}")
    need(list(tape.impacts) == [2] * 4, f"impacts per turn {list(tape.impacts)}")
    need(not any(tape.chatter), "a chatter was recorded")
    pushed = run(bench.chapter(restitution=0.0), 700.0, record=20)
    order = [event[1:3] for event in events(pushed)]
    need(pushed.status == OK and order == sorted(order), f"status {pushed.status} at 700 rpm")
    return f"{label(tape)}; {len(order)} events in order at 700 rpm; no chatter"


def elastic(bench: Bench) -> str:
    """r = 1 runs, keeps the speed of its bounces, and the command warns."""
    bouncing = bench.chapter(restitution=1.0, stiffness=0.0, gravity=9.81)
    tape = run(bouncing, 0.05, record=1, q=0.11, v=0.0)
    speeds = [u for kind, _, theta, _, u in events(tape) if kind == "impact" and theta < 1.5]
    drift = max(abs(u / speeds[0] - 1.0) for u in speeds)
    need(len(speeds) > 1000 and drift < 1e-11, f"{len(speeds)} bounces; drift {drift:.1e}")
    tape = run(bench.chapter(restitution=1.0), 130.0, record=1)
    need(tape.status == OK and "chatter" not in kinds(tape), f"status {tape.status} at 130 rpm")
    words = ["simulate", "--no-plot", "--rpm", "190", "--set", "follower.restitution=1"]
    done = bench.command([*words, "--set", "run.transient=0", "--set", "run.record=1"])
    need("warning: restitution 1" in done.said, f"said: {done.said.strip() or 'nothing'}")
    return f"{len(speeds)} bounces; speeds equal to {drift:.1e}; warning said"


def nearly_elastic(bench: Bench) -> str:
    """r = 0.999999: the budget of impacts ends the run, or the chatter map may be used."""
    system = bench.chapter(restitution=0.999999, gravity=9.81)
    tape = run(system, 2.0, record=2, budget=5000, q=0.1001, v=0.0)
    name = STATUSES[tape.status].name
    ended = tape.status == IMPACT_BUDGET and tape.cost.impacts == 5000
    need(ended or (tape.status == OK and any(tape.chatter)), f"{name}; {tape.cost.impacts} impacts")
    return f"{name} after {tape.cost.impacts} impacts"


def dropped_ball(bench: Bench) -> str:
    """k = 0: dropped from h at rest after sqrt(2 h/g) (1 + r)/(1 - r), whatever the tolerance."""
    system = bench.chapter(stiffness=0.0, gravity=GRAVITY, restitution=BOUNCE)
    height = Orbit(system, 1.0, settings()).position()[0] + HEIGHT
    exact = sqrt(2.0 * HEIGHT / GRAVITY) * (1.0 + BOUNCE) / (1.0 - BOUNCE)
    worst, rest = 0.0, 0.0
    for tolerance in (1e-3, 1e-9, 1e-15, 1e-18):
        tape = run(system, 1.0, record=1, tolerance=tolerance, q=height, v=0.0)
        rest = phases(tape, "chatter")[0] / (pi / 30.0)
        worst = max(worst, abs(rest / exact - 1.0))
        need(kinds(tape).count("impact") == 1, "a hop was followed that the map gives exactly")
    need(abs(rest - 4.06371277) < 5e-9 and worst < 1e-13, f"rests at {rest!r} s")
    return f"rests at {rest:.10f} s; relative error {worst:.1e}"


def flown_off(bench: Bench) -> str:
    """k = b = g = preload = 0 and leaving: status no-return; the same with a damper."""
    for damping in (0.0, 5.0):
        system = bench.chapter(stiffness=0.0, damping=damping)
        tape = run(system, 500.0, record=50, q=0.5, v=30.0)
        name = STATUSES[tape.status].name
        need(tape.status == NO_RETURN and not kinds(tape), f"{name}; {len(kinds(tape))} events")
    thrown = run(bench.chapter(stiffness=0.0), 500.0, record=50)
    need(thrown.status == NO_RETURN, f"from rest: {STATUSES[thrown.status].name}")
    return "no-return; no event invented"


def no_spring_needed(bench: Bench) -> str:
    """A cam below zero: no stiffness holds without gravity, none is needed with enough of it.

    `cam detach` says both in words: k c <= 0 pulls away, so only a preload helps; a weight that
    presses harder than the cam falls away needs no spring.
    """
    words = ["detach", "--no-plot", "--json", "--points", "2", "--set", "cam.offset=0.7"]
    light = _answer(bench, [*words, "--rpm", "110:120", "--hold-to", "120"])
    said = [line for line in light["words"] if "not held even at standstill" in line]
    need(bool(said), f"said: {'; '.join(light['words'])}")
    alone, preload, _ = light["hold"]
    need("a spring does not press" in alone["words"], f"of stiffness: {alone['words']}")
    need(preload["status"] == "ok" and preload["preload"] > 0.0, f"preload {preload['status']}")
    heavy = ["--set", "follower.gravity=1000", "--set", "follower.stiffness=0"]
    held = _answer(bench, [*words, "--rpm", "20:30", "--hold-to", "30", *heavy])["hold"]
    told = [answer["words"] for answer in held]
    needless = all(answer["status"] == "not-needed" for answer in held)
    need(needless and "no spring is needed" in told, f"with a weight: {'; '.join(told)}")
    return f"'not held even at standstill'; 'a spring does not press'; '{told[-1]}'"


def _answer(bench: Bench, words: list[str]) -> dict:
    """The result that a command gives with --json."""
    done = bench.command(words)
    need(done.code == 0, f"exit {done.code}: {done.said.strip()}")
    return json.loads(done.out)["result"]


def tiny_restitution(bench: Bench) -> str:
    """r down to 5e-324: speeds whose products underflow; the run is that of r = 0."""
    zero = phases(run(bench.chapter(restitution=0.0), 190.0))
    for r in (1e-200, 1e-300, 5e-324):
        tape = run(bench.chapter(restitution=r), 190.0)
        need(tape.status == OK and phases(tape) == zero, f"r = {r}: {len(phases(tape))} impacts")
    tape = run(bench.chapter(), 130.0, record=1, tolerance=0.0)
    slow = [u for kind, _, _, _, u in events(tape) if kind == "impact" and abs(u) < 1e-100]
    need(bool(slow) and max(slow) < 0.0, f"{len(slow)} impacts below 1e-100 m/rad")
    return f"as r = 0; {len(slow)} impacts down to {-max(slow):.0e} m/rad; all with u < 0"


ROWS = (
    Row("1: r = 0", "one impact then sticking if a < 0; no chatter test", plastic),
    Row("2: r = 1", "runs; warning", elastic),
    Row("3: r = 0.999999", "impact budget with status or chatter map in tolerance", nearly_elastic),
    Row("8: k = 0; ball dropped from 1 m", "rests at 4.06371277 s", dropped_ball),
    Row("9: k = b = g = preload = 0", "separating follower: no-return", flown_off),
    Row("24: cam below zero; no spring needed", "said in words", no_spring_needed),
    Row("25: chatter at 1e-300 m/s", "signs compared; not products", tiny_restitution),
)
