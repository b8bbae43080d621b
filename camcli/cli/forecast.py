"""What a run will cost: a few of its real pieces are run for a moment and extrapolated.

And the refusal, before any work, of what can never fit into the memory or on the disk.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from math import ceil
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from camcli.api.result import Result
from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.cli.run import analysis
from camcli.errors import Fault, SceneError
from camcli.kernel.backend import LITTLE_WORK, for_work
from camcli.parallel import Shard, Work
from camcli.scene import Scene

SHARE_OF_MEMORY = 0.8
PROGRAM = 45e6  # bytes of memory of the program itself, measured
COMPILED, DRAWING = 130e6, 125e6  # and with the compiled kernel, and with a picture
PICTURE, RECORD = 250e3, 5e3  # bytes of a PNG and of run.json
ENOUGH = 1.0  # s after which no larger sample is run
SHORT = 100  # turns of transient and of record in a sample; the rest is taken to be like them
LINEAR = ("simulate", "sweep", "classify")  # one piece costs what another costs
FIRST, LAST = 2, 32  # pieces of the first sample, each is twice the one before; the most


class Size(NamedTuple):
    """How much a scene asks for, and the least bytes that takes."""

    key: str  # what asks for so much
    what: str
    pieces: int  # of equal work
    orbits: int
    turns: float  # of all orbits; 0 where it is not known before
    memory: float
    disk: float


def size_of(command: str, scene: Scene) -> Size:
    """The size of a command's work."""
    run, turns = scene.run, scene.run.transient + scene.run.record
    match command:
        case "simulate":
            samples = scene.simulate.samples
            key = "simulate.samples" if samples > run.record else "run.record"
            what, rows = f"{run.record} recorded turns x {samples} samples", samples * run.record
            return Size(key, what, run.record, 1, turns, 280.0 * rows, 102.0 * rows)
        case "sweep":
            speeds, rows = scene.sweep.rpm.num, run.record * len(scene.sweep.sections)
            key = "run.record" if run.record > speeds else "sweep.rpm.num"
            what = f"{speeds} speeds x {run.record} recorded turns"
            memory, disk = 500.0 * speeds + 32.0 * rows, 32.0 * rows * speeds
            disk *= 1 if scene.sweep.tables == "none" else 2
            return Size(key, what, speeds, speeds, speeds * turns, memory, disk)
        case "classify":
            speeds, starts = scene.classify.rpm.num, scene.classify.starts + 1
            key = "run.record" if run.record > speeds else "classify.rpm.num"
            what = f"{speeds} speeds x {starts} starts x {run.record} recorded turns"
            orbits, memory = speeds * starts, 45.0 * speeds * run.record
            return Size(key, what, orbits, orbits, orbits * turns, memory, 790.0 * speeds)
        case "basins":
            (nq, nv), levels, span = scene.basins.cells, scene.basins.refine, scene.basins.rpm
            cells, speeds = nq * nv, 1 if span.start == span.stop else span.num
            key = "basins.refine" if levels else "basins.cells"
            what, orbits = f"{nq} x {nv} cells, refined {levels} times", cells * speeds
            memory = 70.0 * cells + (14.0 * cells * 4**levels + 20e6 if levels else 0.0)
            return Size(key, what, orbits, orbits, 0.0, memory, 54.0 * orbits)
        case _:
            key = "detach.rpm.num" if command == "detach" else "orbits.starts"
            runs = scene.detach.rpm.num if command == "detach" else scene.orbits.starts + 1
            return Size(key, f"{runs} runs", runs, runs, 0.0, 300.0 * runs, 300.0 * runs)


def sample_of(command: str, scene: Scene, n: int, whole: int) -> tuple[int, dict[str, Any]]:
    """(pieces, values of the scene) of a sample: some of the pieces, few turns each."""
    run = scene.run
    few = {"run.transient": min(SHORT, run.transient), "run.record": min(SHORT, run.record)}
    match command:
        case "simulate":
            return min(25 * n, whole), few | {"run.record": min(25 * n, whole)}
        case "sweep":
            return min(n, whole), few | {"sweep.rpm.num": min(n, whole)}
        case "classify":
            speeds = min(n, scene.classify.rpm.num)
            values = {"classify.starts": 0, "classify.explain": False}
            return speeds, values | {"classify.rpm.num": speeds}
        case "basins":
            sides = tuple(min(8 * n, side) for side in scene.basins.cells)
            one = {"basins.rpm.num": 1, "basins.rpm.stop": scene.basins.rpm.start}
            return sides[0] * sides[1], one | {"basins.cells": sides, "basins.refine": 0}
        case _:
            return min(25 * n, whole), {"detach.rpm.num": min(25 * n, whole)}


def refuse_too_large(command: str, scene: Scene, folder: Path, shard: Shard | None) -> None:
    """Raise SceneError for a run whose least need is more than this machine has."""
    need, share = size_of(command, scene), 1 if shard is None else shard.total
    room, free = SHARE_OF_MEMORY * memory(), free_disk(folder)
    found, cure, faults = f"found {need.what}, at least", "ask for fewer", []
    if need.memory > room:
        limit = f"expected at most {in_words(room)}, {SHARE_OF_MEMORY:.0%} of this machine's"
        text = f"{found} {in_words(need.memory)} of memory"
        faults.append(Fault("", need.key, text, limit, cure))
    if need.disk / share > free:
        limit = f"expected at most {in_words(free)}, free on the disk of {folder}"
        text = f"{found} {in_words(need.disk / share)} of files"
        faults.append(Fault("", need.key, text, limit, f"{cure}, or choose another -o"))
    if faults:
        raise SceneError(*faults)


def forecast(
    command: str, scene: Scene, request: Request, shard: Shard | None, options: Mapping[str, Any]
) -> None:
    """Print what the run would do and cost; nothing is written."""
    size, share = size_of(command, scene), 1 if shard is None else shard.total
    notes = [f"shard {shard.number} of {shard.total}: pieces only, no tables"] if shard else []
    section = getattr(scene, command)
    if getattr(section, "explain", False):
        notes.append("what --explain takes is not known before: 5 to 15 s for many a change")
    costs: dict[str, float | None] = {"impacts": None, "seconds": None, "tables": None}
    if command == "orbits":
        notes.append("how many branches there are, and so the time, is not known before")
    elif options.get("profile_only"):
        costs = {"impacts": 0.0, "seconds": None, "tables": 100.0 * scene.simulate.samples}
    else:
        costs = _extrapolated(command, scene, request, size)
    artefacts = None if costs["tables"] is None else costs["tables"] + RECORD
    if artefacts is not None and not request.no_plot:
        artefacts += PICTURE
    plan = {
        "orbits": ceil(size.orbits / share),
        "periods": ceil(size.turns / share) or None,
        "impacts": _shared(costs["impacts"], share),
        "seconds": None if costs["seconds"] is None else costs["seconds"] / share,
        "bytes": 0 if shard else _shared(artefacts, 1),
        "disk": ceil(size.disk / share) if shard else _shared(artefacts, 1, size.disk / 2),
        "memory": round(PROGRAM + COMPILED + (0 if request.no_plot else DRAWING) + size.memory),
        "notes": notes,
    }
    if request.json:
        print(json.dumps({"command": command, "plan": plan}, indent=2))
        return
    rows = [[name, _cell(name, value)] for name, value in plan.items() if name != "notes"]
    table(f"cam {command}, planned", ["what", "estimate"], rows)
    for text in notes:
        print(text)


def _shared(value: float | None, share: int, more: float = 0.0) -> int | None:
    return None if value is None else ceil((value + more) / share)


def _cell(name: str, value: Any) -> str:
    if value is None:
        return "not known before"
    if name in ("bytes", "disk", "memory"):
        return in_words(value)
    return f"{value:.2g} s" if name == "seconds" else f"{value:.6g}"


def _extrapolated(
    command: str, scene: Scene, request: Request, size: Size
) -> dict[str, float | None]:
    """Impacts, seconds and bytes of the tables from samples of growing size.

    cost = fixed + pieces * each, from the two largest samples; a piece with few turns stands for
    one with all of its turns.
    """
    for_work(size.turns if size.turns else LITTLE_WORK + 1)  # a sample runs as the whole will
    samples: list[dict[str, float]] = []
    began, n, pieces = perf_counter(), FIRST, 0
    enough = 1 if command in LINEAR else 2  # a cost that comes once must be told from the rest
    while n <= LAST and pieces < size.pieces:
        if len(samples) >= enough and perf_counter() - began > ENOUGH:
            break
        pieces, values = sample_of(command, scene, n, size.pieces)
        small = _with(scene, values)
        result = _run(command, small, request)
        text = sum(len(line) for t in result.tables.values() for line in t.csv())
        text += len(json.dumps(result.summary))
        cost = {"impacts": result.cost.impacts, "seconds": result.seconds, "tables": text}
        samples.append({"pieces": pieces, **cost})
        n *= 2
    last, before = samples[-1], samples[-2] if len(samples) > 1 else None
    longer = (scene.run.transient + scene.run.record) / (small.run.transient + small.run.record)
    recorded = scene.run.record / small.run.record
    costs: dict[str, float | None] = {}
    for name in ("impacts", "seconds", "tables"):
        scale, fixed = size.pieces / last["pieces"], 0.0
        if command in ("sweep", "simulate"):
            one = 1.0 if command == "sweep" else 1.0 / scale  # a simulation is made shorter only
            scale *= one * (recorded if name == "tables" else longer)
        elif before is not None and command not in LINEAR:
            each = (last[name] - before[name]) / max(1, last["pieces"] - before["pieces"])
            fixed = min(last[name], max(0.0, last[name] - each * last["pieces"]))
        costs[name] = fixed + (last[name] - fixed) * scale
    return costs


def _run(command: str, scene: Scene, request: Request) -> Result:
    if command in ("sweep", "basins", "classify"):
        return analysis(command)(scene, work=Work(request.threads))
    return analysis(command)(scene)


def _with(scene: Any, values: Mapping[str, Any]) -> Any:
    """The scene with some values replaced; a path that it does not have is left out."""
    for path, value in values.items():
        scene = _replaced(scene, path.split("."), value)
    return scene


def _replaced(model: Any, keys: list[str], value: Any) -> Any:
    first, *rest = keys
    return model.model_copy(
        update={first: _replaced(getattr(model, first), rest, value) if rest else value}
    )


def in_words(count: float) -> str:
    """Bytes in words: MB, from a thousand of them on GB."""
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


def memory() -> float:
    """Bytes of memory of this machine."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return 4e9


def free_disk(folder: Path) -> float:
    """Bytes free where the folder is or will be."""
    place = folder.absolute()
    while not os.path.exists(place) and place != place.parent:  # a name too long is no error
        place = place.parent
    try:
        return float(shutil.disk_usage(place).free)
    except OSError:
        return float("inf")
