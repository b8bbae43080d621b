"""What a run will cost: a few of its real pieces are run for a moment and extrapolated."""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import BytesIO
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.cli.run import IN_PIECES, analysis
from camcli.cli.sizes import PROGRAM, drawing_of, in_words, size_of
from camcli.interrupts import CutOffError, until
from camcli.kernel.backend import LITTLE_WORK, Stopwatch, for_work, stopwatch
from camcli.parallel import Shard, Work
from camcli.parallel.checkpoint import Checkpoint, pack
from camcli.scene import Scene

if TYPE_CHECKING:
    from camcli.api.result import Result

RECORD, REPORT, FILM = 5e3, 130e3, 400e3  # bytes of run.json, and of what --report, --animate add
MOST = 10.0  # s of all samples, then nothing more is foreseen
ENOUGH = 1.0  # s after which no larger sample is run
SHORT = 1000  # turns of transient and of record in a sample; the rest is taken to be like them
FEW_ROWS = 9000  # of a trajectory in a sample, for each of its pieces
FEW_STARTS = 5  # of classify at each speed of a sample: more find hardly more attractors
BOUNDED = ("detach", "orbits")  # have a budget
PER_WORK = 2e-7  # s, for one of it, measured: 1e-7 to 4e-7
LARGEST = 32  # the largest sample; each is twice the one before
MOST_GRIDS = 3  # speeds whose cells become a table
# tables that grow with the record, or the cells
LARGE = ("impacts", "strobe", "trajectory", "events", "basins")


class Cost(NamedTuple):
    """What a sample, or a whole run, takes: bytes of LARGE tables, of others, and of pieces."""

    impacts: float
    seconds: float
    recorded: float
    rows: float
    kept: float


class _Weighed(Checkpoint):
    """A checkpoint that keeps nothing, and counts the bytes of what it is given."""

    def __init__(self) -> None:
        self.size, self.bytes = 0, 0

    def __contains__(self, name: tuple[str, int]) -> bool:
        return False

    def put(self, place: str, number: int, value: Any) -> None:
        self.bytes += len(pack(value))


def sample_of(command: str, scene: Scene, n: int) -> Scene:
    """The scene with few of its pieces, of few turns each."""
    from camcli.api.machine import with_values

    run, few = scene.run, dict[str, Any]()
    section: Any = getattr(scene, command, None)
    record = min(SHORT, run.record)
    if command == "simulate":
        record = min(max(1, FEW_ROWS * n // section.samples), run.record)
    match command:
        case "sweep":
            few = {"zoom": (), "also": (), "explain": False, "adaptive": False}
            few |= _fewer(section, n)
        case "classify":
            few = {"starts": min(FEW_STARTS, section.starts), "explain": False}
            few |= _fewer(section, n)
        case "basins":
            cells = tuple(min(8 * n, side) for side in section.cells)
            few = {"refine": 0, "cells": cells, **_fewer(section, 1)}
        case "detach":
            few = {"rpm": _fewer(section, 25 * n)["rpm"], "tolerance": ()}
    scene = with_values(scene, "run", transient=min(SHORT, run.transient), record=record)
    return with_values(scene, command, **few) if few else scene


def _fewer(section: Any, n: int) -> dict[str, Any]:
    """At most n values of each number that is varied, none at an end: what is there is special."""

    def few(axis: Any) -> Any:
        aside = 0.5 * (axis.stop - axis.start) / n
        inside = {"start": axis.start + aside, "stop": axis.stop - aside, "num": n}
        return axis.model_copy(update=inside) if n < axis.num else axis

    return {"rpm": few(section.rpm), "vary": tuple(map(few, getattr(section, "vary", ())))}


def forecast(
    command: str, scene: Scene, request: Request, shard: Shard | None, options: Mapping[str, Any]
) -> None:
    """Print what the run would do and cost; nothing is written, and it takes a few seconds."""
    size, share = size_of(command, scene, options), 1 if shard is None else shard.total
    notes = [f"shard {shard.number} of {shard.total}: pieces only, no tables"] if shard else []
    if command == "detach" and scene.detach.tolerance:
        from camcli.api.machine import machine_of
        from camcli.api.tolerances import tolerated

        tolerated(machine_of(scene))  # a plan refuses what the run would
    notes += _not_foreseen(command, scene, options)
    cost = None
    if options.get("profile_only"):
        cost = Cost(0.0, 0.0, 0.0, size.tables, 0.0)
    elif command != "orbits":
        with stopwatch() as watch, until(lambda: watch.passed() > MOST):
            try:
                cost = _sampled(command, scene, request, options, watch)
            except CutOffError:
                notes.append(f"a small part took {MOST:g} s: how long it takes is not known before")
    if getattr(getattr(scene, command, None), "explain", False) or (
        cost is None and command in BOUNDED
    ):
        most = scene.run.work_budget
        notes.append(f"run.work_budget = {most} ends it after some {PER_WORK * most:.0f} s")
    drawn = not request.no_plot and shard is None
    drawing, pictures = drawing_of(command, scene, options) if drawn else (0.0, 0.0)
    more = REPORT * bool(options.get("report")) + FILM * bool(options.get("animate"))
    files = kept = None
    if cost is not None:
        files = 0 if shard else ceil(cost.recorded + cost.rows + RECORD + pictures + more)
        kept = ceil(cost.kept / share) if command in IN_PIECES else 0
    plan = {
        "orbits": ceil(size.orbits / share),
        "periods": ceil(size.turns / share) or None,
        "impacts": None if cost is None else ceil(cost.impacts / share),
        "seconds": None if cost is None else cost.seconds / share,
        "bytes": files,
        "disk": None if files is None or kept is None else files + kept,
        "memory": round(PROGRAM + drawing + size.memory),
    }
    if request.json:
        print(json.dumps({"command": command, "plan": {**plan, "notes": notes}}, indent=2))
        return
    rows = [[name, _cell(name, value)] for name, value in plan.items()]
    table(f"cam {command}, planned", ["what", "estimate"], rows)
    for text in notes:
        print(text)


def _not_foreseen(command: str, scene: Scene, options: Mapping[str, Any]) -> list[str]:
    """Sentences on what no sample shows."""
    said = {
        "what --explain takes is not known before: 5 to 15 s for many a change": getattr(
            getattr(scene, command, None), "explain", False
        ),
        f"{scene.detach.machines} machines of --tolerance come on top, 0.1 s each": (
            command == "detach" and scene.detach.tolerance
        ),
        "how many branches there are, and so the time, is not known before": command == "orbits",
        "the orbits come on top: how many are solved is not known before": command == "explore",
        "how many speeds --adaptive adds is not known before": (
            command == "sweep" and scene.sweep.adaptive
        ),
        "what --refine adds at boundaries is not known before": (
            command == "basins" and scene.basins.refine
        ),
        "a speed in the middle stands for all, though those with chaos take many times as long": (
            command == "basins" and scene.basins.count > 1
        ),
        "drawing the animation comes on top, some 10 to 20 s": options.get("animate"),
    }
    return [text for text, holds in said.items() if holds]


def _cell(name: str, value: Any) -> str:
    if value is None:
        return "not known before"
    if name in ("bytes", "disk", "memory"):
        return in_words(value)
    return f"{value:.2g} s" if name == "seconds" else f"{value:.6g}"


def _sampled(
    command: str, scene: Scene, request: Request, options: Mapping[str, Any], watch: Stopwatch
) -> Cost:
    """The cost of a command from samples of it, or of the commands that it is made of."""
    if command == "basins":
        return _at_each_speed(scene, request, watch)
    if command != "explore":
        return _extrapolated(command, scene, request, watch)[0]
    from camcli.api.explore import page_bytes, parts_of
    from camcli.api.machine import machine_of

    machine = machine_of(scene)
    asked = {"with_basins": options["with_basins"], "with_map": options["with_map"]}
    samples = {
        name: _extrapolated(part, own, request, watch)
        for name, (part, own) in parts_of(machine.scene, **asked).items()
        if part != "orbits"
    }
    costs = [cost for cost, _ in samples.values()]
    page = page_bytes(machine, {name: result for name, (_, result) in samples.items()}, **asked)
    return Cost(sum(c.impacts for c in costs), sum(c.seconds for c in costs), 0.0, page, 0.0)


def _at_each_speed(scene: Scene, request: Request, watch: Stopwatch) -> Cost:
    """The cost of basins: every speed, or value, has attractors to be found, and cells."""
    from camcli.api.machine import with_values

    count = scene.basins.count
    middle = with_values(scene, "basins", **_fewer(scene.basins, 1))
    cost, _ = _extrapolated("basins", middle if count > 1 else scene, request, watch)
    if count > MOST_GRIDS:
        cost = cost._replace(recorded=0.0)
    return Cost(*(count * one for one in cost))


def _extrapolated(
    command: str, scene: Scene, request: Request, watch: Stopwatch
) -> tuple[Cost, Result]:
    """The cost, from samples of growing size, and the result of the largest of them.

    In proportion to the turns, recorded turns and rows where their number is known, else fixed +
    pieces * each, from the two largest samples: a cost that comes once must be told from the rest.
    """
    size = size_of(command, scene, {})
    for_work(size.turns or LITTLE_WORK + 1)  # a sample runs as the whole will
    samples: list[tuple[Scene, Cost]] = []

    def tick(*_: object) -> None:
        if watch.passed() > MOST:
            raise CutOffError

    n, enough = (8, 1) if size.turns else (2, 2)
    with stopwatch() as own:
        while n <= LARGEST and (len(samples) < enough or own.passed() < ENOUGH):
            small, weighed = sample_of(command, scene, n), _Weighed()
            pieces = size_of(command, small, {}).pieces
            result = analysis(command, Work(request.threads, weighed))(small, tick)
            samples.append((small, _cost_of(result, weighed.bytes)))
            if pieces == size.pieces:
                break
            n *= 2
    small, last = samples[-1]
    part = size_of(command, small, {})
    if size.turns:
        turns, rows = size.turns / part.turns, size.rows / max(1, part.rows)
        recorded = size.orbits * scene.run.record / (part.orbits * small.run.record)
        kept = recorded if last.recorded else rows
        scales = Cost(turns, turns, recorded, rows, kept)
        return Cost(*(cost * scale for cost, scale in zip(last, scales, strict=True))), result
    fixed = Cost(0.0, 0.0, 0.0, 0.0, 0.0)
    if len(samples) > 1:
        before, earlier = samples[-2]
        share = part.pieces / (part.pieces - size_of(command, before, {}).pieces)
        pairs = zip(earlier, last, strict=True)
        fixed = Cost(*(min(b, max(0.0, b - share * (b - a))) for a, b in pairs))
    scale = size.pieces / part.pieces
    return Cost(*(f + (c - f) * scale for f, c in zip(fixed, last, strict=True))), result


def _cost_of(result: Result, kept: int) -> Cost:
    """What a sample has taken."""
    binary = result.command == "sweep" and result.scene.sweep.tables == "npz"
    sizes = {}
    for name, one in result.tables.items():
        file = BytesIO()
        (one.npz if binary and name != "speeds" else one.write_csv)(file)
        sizes[name] = file.tell()
    large = sum(sizes[name] for name in sizes if name in LARGE)
    rows = sum(sizes.values()) - large + len(json.dumps(result.summary))
    return Cost(result.cost.impacts, result.seconds, large, rows, kept)
