"""Speed and accuracy of the core against general-purpose integrators, side by side.

    python tests/bench/bench_core.py [--repeats 5] [--scale 1.0] [--methods core rk45 ...]

Every repeat runs all methods in turn, so that a ratio compares neighbours in time; the table
quotes medians over the repeats.  A method is called once beforehand on a few impacts, which is
where compilation goes ("first call").  Errors and missed impacts are against the oracle in
multiple precision.  The peers and their settings are described in ``peers.py``.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from statistics import median

import numpy as np
import peers  # next to this script

from camcli.analysis.engine import IMPACT, Orbit, Settings, Start, compile_for
from camcli.scene import load_scene
from camcli.system import Follower, System

State = tuple[float, float] | None
Run = tuple[np.ndarray, np.ndarray, float]

SAME_PHASE = 1e-6  # turns: an impact further from the reference than this is another impact
SAME_SPEED = 1.1  # ratio: bounces of a chatter differ by 1/r = 1.25 from one to the next
CHATTER_TOLERANCE = 1e-9  # turns, ours
FOLDED = 1e-3  # turns: most of a chatter that a closing map may replace


# ------------------------------------------------------------------------------- our own core


@cache
def chapter() -> System:
    """The chapter's machine, compiled."""
    scene = load_scene(None)
    system = System.build(Follower(**scene.follower.model_dump()), scene.cam.parts())
    compile_for(system)
    return system


def core(rpm: float, impacts: int, start: State) -> Run:
    """The package's own kernel on the chapter's follower, from theta = 0, on one thread.

    ``start`` is ``(q, v)`` or None for rest on the cam.  Runs the whole turns that hold about the
    impacts asked for, logging every event.  Returns rows (whole turns since the start, theta in
    rad), the relative velocities of the impacts, and the seconds without compilation.
    """
    system = chapter()
    begin = Start(*start) if start is not None else Start()
    probe = Orbit(system, rpm, Settings(0, 20, CHATTER_TOLERANCE, 10**6, begin)).run()
    turns = max(1, round(impacts * 20 / probe.cost.impacts))
    orbit = Orbit(system, rpm, Settings(0, turns, CHATTER_TOLERANCE, 10**6, begin))
    begun = time.perf_counter()
    tape = orbit.run(strobes=False)
    seconds = time.perf_counter() - begun
    hit = np.asarray(tape.kind) == IMPACT
    phases = np.column_stack([np.asarray(tape.period)[hit], np.asarray(tape.theta)[hit]])
    return phases, np.asarray(tape.u)[hit] * orbit.omega, seconds


def reference(rpm: float, impacts: int, start: State, chatter_tol: float) -> Run:
    """The same by the oracle; its chatter is closed at ``chatter_tol`` turns."""
    sys.path.append(str(Path(__file__).parents[1]))
    from oracle import ArcsCam, Oracle

    begun = time.perf_counter()
    data = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}
    oracle = Oracle(ArcsCam(), rpm=rpm, digits=40, **data)
    q, v = start if start is not None else (None, None)
    events = oracle.run(q=q, v=v, impacts=impacts, chatter_cut=2.0 * np.pi * chatter_tol)
    hits = [e for e in events if e.kind == "impact"]
    phases = np.array([(e.turn, float(e.theta)) for e in hits])
    speeds = np.array([float(e.u_minus) for e in hits])
    return phases, speeds, time.perf_counter() - begun


# ------------------------------------------------------------------------------------- cases


@dataclass(frozen=True)
class Case:
    """A motion, and about how many turns of it each method follows."""

    title: str
    rpm: float
    start: State
    checked: int  # impacts compared with the reference
    per_turn: int  # impacts, for a peer at the default chatter tolerance
    turns: dict[str, int]

    def impacts(self, method: str, scale: float) -> int:
        """Impacts to ask of a method: those of whole turns."""
        return self.per_turn * max(1, round(self.turns[method] * scale))


# The stable P(1;1) at 700 rpm passes theta = 0 with q = 2.355530525660, v = -16.453423363171.
CASES = (
    Case(
        "700 rpm, towards the stable P(1;1): one impact per turn",
        700.0,
        (2.355530525660, -16.6),
        100,
        1,
        {"core": 400_000, "heyoka": 20_000, "dop853": 600, "rk45": 120},
    ),
    Case(
        "190 rpm, from rest: complete chatter and sticking in every turn",
        190.0,
        None,
        400,
        93,
        {"core": 10_000, "heyoka": 200, "dop853": 11, "rk45": 7},
    ),
)
METHODS = ("core", "heyoka", "dop853", "rk45")


def runner(method: str, case: Case, chatter_tol: float) -> Callable[[int], Run]:
    """A function of the number of impacts."""
    if method == "core":
        return lambda impacts: core(case.rpm, impacts, case.start)
    run = partial(peers.simulate, method, case.rpm, start=case.start, chatter_tol=chatter_tol)
    return lambda impacts: run(impacts)


# -------------------------------------------------------------------------------- comparison


@dataclass
class Agreement:
    """How the impacts of a method agree with those of the reference."""

    error: float = 0.0  # largest difference of phase, turns
    missed: int = 0
    folded: int = 0  # of the reference, but in the tail of a chatter a method has closed
    extra: int = 0


def align(ref: Run, got: Run) -> tuple[list[tuple[int, int]], int]:
    """Pairs of impacts that are the same one, in order, and how many of ``got`` have none."""
    pairs, extra, i, j = [], 0, 0, 0
    while i < len(ref[0]) and j < len(got[0]):
        late = phase_error(ref, got, i, j)
        ratio = got[1][j] / ref[1][i]
        if late > SAME_PHASE or (abs(late) <= SAME_PHASE and ratio < 1.0 / SAME_SPEED):
            i += 1
        elif late < -SAME_PHASE or ratio > SAME_SPEED:
            j, extra = j + 1, extra + 1
        else:
            pairs.append((i, j))
            i, j = i + 1, j + 1
    return pairs, extra


def phase_error(ref: Run, got: Run, i: int, j: int) -> float:
    """Turns by which impact ``j`` comes after impact ``i`` of the reference."""
    turns, angle = got[0][j] - ref[0][i]
    return turns + angle / (2.0 * np.pi)


def compare(case: Case, ref: Run, got: Run) -> Agreement:
    """Errors over the stretch of motion that both have followed."""
    pairs, extra = align(ref, got)
    if not pairs:
        return Agreement(float("nan"), len(ref[0]), 0, extra)
    common = len(ref[0]) if len(got[0]) > pairs[-1][1] + 1 else pairs[-1][0] + 1
    error = max(abs(phase_error(ref, got, i, j)) for i, j in pairs)
    result = Agreement(float(error), extra=extra)
    found, tail = {i for i, _ in pairs}, True
    for i in reversed(range(common)):
        if i + 1 < common and ref[1][i + 1] < ref[1][i]:
            tail = True  # the next impact is harder: a chatter may end here
        tail = tail and i not in found and left_of_chatter(case, ref, i) < FOLDED
        if i not in found:
            result.folded += tail
            result.missed += not tail
    return result


def left_of_chatter(case: Case, ref: Run, i: int) -> float:
    """Turns that the chatter after an impact still takes, to first order."""
    follower = peers.Follower()
    world = peers.World(follower, case.rpm * np.pi / 30.0, 0)
    theta, r = ref[0][i, 1], follower.restitution
    a = world.push(peers.region(theta), theta)
    left = 2.0 * r * ref[1][i] / ((1.0 - r) * a) if a < 0.0 else np.inf
    return float(left) / world.period


# ----------------------------------------------------------------------------------- running


@dataclass
class Row:
    """Measurements of a method in a case, or why there are none."""

    method: str
    first: float = 0.0
    run: Run | None = None
    seconds: list[float] | None = None
    note: str = ""

    @property
    def turns(self) -> float:
        """Whole turns followed in a repeat."""
        return max(1, int(self.run[0][-1, 0]))


def warm(method: str, call: Callable[[int], Run]) -> Row:
    """First call of a method, compilation included."""
    begun = time.perf_counter()
    if method != "core" and not peers.available(method):
        return Row(method, note="not installed: pip install camcli[bench]")
    call(3)
    return Row(method, time.perf_counter() - begun, seconds=[])


def measure(case: Case, options: argparse.Namespace) -> list[Row]:
    """All methods, repeat by repeat, starting from another one each time."""
    calls = {m: runner(m, case, options.chatter_tol) for m in options.methods}
    rows = [warm(m, call) for m, call in calls.items()]
    live = [row for row in rows if row.seconds is not None]
    for repeat in range(options.repeats):
        cut = repeat % len(live) if live else 0
        for row in live[cut:] + live[:cut]:
            row.run = calls[row.method](case.impacts(row.method, options.scale))
            row.seconds.append(row.run[2])
    return rows


def cells(case: Case, row: Row, base: Row | None, ref: Run | None) -> list[str]:
    """One line of the table."""
    if row.run is None:
        return [row.method, row.note]
    n, seconds = len(row.run[0]), median(row.seconds)
    out = [row.method, f"{row.first:.2f}", f"{n}", f"{seconds:.4f}", f"{n / seconds:.0f}"]
    out.append(f"{row.turns / seconds:.0f}")
    out.append(f"{ratio(row, base):.2f}" if base and base.run is not None else "-")
    if ref is None:
        return [*out, "-", "-", "-", "-"]
    fit = compare(case, ref, row.run)
    return [*out, f"{fit.error:.1e}", f"{fit.missed}", f"{fit.extra}", f"{fit.folded}"]


def ratio(row: Row, base: Row) -> float:
    """Time per turn over that of the core, the median of the repeats' own ratios."""
    scale = base.turns / row.turns
    return median(a / b * scale for a, b in zip(row.seconds, base.seconds, strict=True))


HEAD = ["method", "first call s", "impacts", "seconds", "impacts/s", "turns/s", "x core"]
HEAD += ["max error", "missed", "extra", "folded"]


def show(case: Case, rows: list[Row], ref: Run | None) -> None:
    """Print the table of a case."""
    base = next((row for row in rows if row.method == "core"), None)
    lines = [HEAD, *(cells(case, row, base, ref) for row in rows)]
    widths = [max(len(line[k]) for line in lines if len(line) > 2) for k in range(len(HEAD))]
    print(f"\n{case.title}")
    for line in lines:
        if len(line) == 2:
            print(f"{line[0]:<{widths[0]}}  {line[1]}")
            continue
        padded = [f"{x:>{w}}" for x, w in zip(line[1:], widths[1:], strict=True)]
        print("  ".join([f"{line[0]:<{widths[0]}}", *padded]))


LEGEND = """
first call s  a few impacts, imports and compilation included
x core        seconds per turn over those of the core (median over interleaved repeats)
max error     of the impact phases against the reference, in turns
missed/extra  impacts of the reference not found / found but not there
folded        impacts not followed because a chatter had been closed by then"""


def try_reference(case: Case, options: argparse.Namespace) -> Run | None:
    """The reference solution, or None where the oracle cannot be had."""
    try:
        return reference(case.rpm, case.checked, case.start, options.chatter_tol)
    except ImportError as missing:
        print(f"no reference solution: {missing}")
        return None


def parse(argv: list[str] | None) -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--scale", type=float, default=1.0, help="multiplies all numbers of turns")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument(
        "--chatter-tol", type=float, default=1e-9, help="peers close chatter below this, turns"
    )
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> None:
    """Measure and print all cases."""
    options = parse(argv)
    print(f"Python {platform.python_version()}, {platform.machine()}, {options.repeats} repeats")
    for case in CASES:
        ref = try_reference(case, options)
        show(case, measure(case, options), ref)
    print(LEGEND)


if __name__ == "__main__":
    main()
