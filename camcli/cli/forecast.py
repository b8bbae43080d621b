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
from typing import Any, NamedTuple

from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.cli.run import analysis
from camcli.errors import Fault, SceneError
from camcli.kernel.backend import LITTLE_WORK, for_work, stopwatch
from camcli.parallel import Shard, Work
from camcli.scene import Scene

SHARE_OF_MEMORY = 0.8
PROGRAM = 45e6  # bytes of memory of the program itself, measured
COMPILED, DRAWING = 130e6, 125e6  # and with the compiled kernel, and with a picture
PICTURE, RECORD = 250e3, 5e3  # bytes of a PNG and of run.json
MUCH = 200e6  # bytes of files that are worth a word
MOST = 10.0  # s of a sample, then nothing is foreseen
ENOUGH = 1.0  # s after which no larger sample is run
SHORT = 1000  # turns of transient and of record in a sample; the rest is taken to be like them
BOUNDED = ("detach", "orbits")  # have a budget
PER_WORK = 2e-7  # s, for one of it, measured: 1e-7 to 4e-7
LARGEST = 32  # the largest sample; each is twice the one before


class Size(NamedTuple):
    """How much a scene asks for, and the least bytes that takes."""

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
            rows = scene.simulate.samples * run.record
            what = f"{run.record} recorded turns x {scene.simulate.samples} samples"
            return Size(what, run.record, 1, turns, 280.0 * rows, 102.0 * rows)
        case "sweep":
            section, what = scene.sweep, f"speeds of {turns} turns, {run.record} recorded"
            n = section.count + sum(part.num for part in section.zoom)
            n *= 1 + len(section.also)
            rows = n * run.record * len(section.sections)
            if len(section.vary) == 2:
                n, rows = section.vary[0].num * section.vary[1].num, 0
            memory = 32.0 * rows / max(1, n) + 1e3 * n
            disk = 43.0 * rows * (1 if section.tables == "none" else 2) + 600.0 * n
            return Size(f"{n} {what}", n, n, n * turns, memory, disk)
        case "classify":
            speeds, starts = scene.classify.count, scene.classify.starts + 1
            what = f"{speeds} speeds x {starts} starts x {run.record} recorded turns"
            orbits, memory = speeds * starts, 45.0 * speeds * run.record
            return Size(what, orbits, orbits, orbits * turns, memory, 790.0 * speeds)
        case "basins":
            (nq, nv), levels = scene.basins.cells, scene.basins.refine
            what, orbits = (
                f"{nq} x {nv} cells, refined {levels} times",
                nq * nv * scene.basins.count,
            )
            memory = 70.0 * nq * nv + (14.0 * nq * nv * 4**levels + 20e6 if levels else 0.0)
            return Size(what, orbits, orbits, 0.0, memory, 54.0 * orbits)
        case "explore":
            n = scene.sweep.rpm.num
            return Size(f"{n} speeds", n, 3 * n, 3 * n * turns, 1e6 * n, 8e6)
        case _:
            n = scene.detach.rpm.num if command == "detach" else scene.orbits.starts + 1
            return Size(f"{n} runs", n, n, 0.0, 300.0 * n, 300.0 * n)


def sample_of(command: str, scene: Scene, n: int) -> Scene:
    """The scene with few of its pieces, of few turns each."""
    from camcli.api.machine import with_values

    run, few, section = scene.run, dict[str, Any](), getattr(scene, command)
    record = min(25 * n if command == "simulate" else SHORT, run.record)
    match command:
        case "sweep":
            few = {"zoom": (), "also": (), **_fewer(section, n)}
        case "classify":
            few = {"starts": 0, "explain": False, **_fewer(section, n)}
        case "basins":
            cells = tuple(min(8 * n, side) for side in section.cells)
            few = {"refine": 0, "cells": cells, **_fewer(section, 1)}
        case "detach":
            few = {"rpm": _fewer(section, 25 * n)["rpm"], "tolerance": ()}
    scene = with_values(scene, "run", transient=min(SHORT, run.transient), record=record)
    return with_values(scene, command, **few)


def _fewer(section: Any, n: int) -> dict[str, Any]:
    """At most n values of each number that is varied, none at an end: what is there is special."""

    def few(axis: Any) -> Any:
        aside = 0.5 * (axis.stop - axis.start) / n
        inside = {"start": axis.start + aside, "stop": axis.stop - aside, "num": n}
        return axis.model_copy(update=inside) if n < axis.num else axis

    return {"rpm": few(section.rpm), "vary": tuple(map(few, getattr(section, "vary", ())))}


def refuse_too_large(command: str, scene: Scene, folder: Path, shard: Shard | None) -> None:
    """Raise SceneError for a run whose least need is more than this machine has."""
    need, share = size_of(command, scene), 1 if shard is None else shard.total
    faults = []
    for have, needed, of, where, cure in (
        (SHARE_OF_MEMORY * memory(), need.memory, "memory", "80% of this machine's", ""),
        (free_disk(folder), need.disk / share, "files", f"free on the disk of {folder}",
         ", or choose another -o"),
    ):  # fmt: skip
        if needed > have:
            found = f"found {need.what}, at least {in_words(needed)} of {of}"
            limit = f"expected at most {in_words(have)}, {where}"
            faults.append(Fault("", command, found, limit, f"ask for fewer{cure}"))
    if faults:
        raise SceneError(*faults)


def forecast(
    command: str, scene: Scene, request: Request, shard: Shard | None, options: Mapping[str, Any]
) -> None:
    """Print what the run would do and cost; nothing is written."""
    size, share = size_of(command, scene), 1 if shard is None else shard.total
    notes = [f"shard {shard.number} of {shard.total}: pieces only, no tables"] if shard else []
    explains = getattr(getattr(scene, command, None), "explain", False)
    if explains:
        notes.append("what --explain takes is not known before: 5 to 15 s for many a change")
    if command == "detach" and scene.detach.tolerance:
        notes.append(f"{scene.detach.machines} machines of --tolerance come on top, 0.1 s each")
    if command == "orbits":
        notes.append("how many branches there are, and so the time, is not known before")
    if command == "explore":
        notes.append("the orbits come on top: how many are solved is not known before")
    impacts = seconds = tables = None
    if options.get("profile_only"):
        impacts, tables = 0.0, 100.0 * scene.simulate.samples
    else:
        try:
            sampled = [_extrapolated(*part, request) for part in _parts(command, scene, options)]
            if sampled:
                impacts, seconds, tables = map(sum, zip(*sampled, strict=True))
        except TimeoutError:
            notes.append(f"a small part took {MOST:g} s: how long it takes is not known before")
    if explains or (seconds is None and command in BOUNDED):
        most = scene.run.work_budget
        notes.append(f"run.work_budget = {most} ends it after some {PER_WORK * most:.0f} s")
    files = None if tables is None else ceil(tables + RECORD + (0 if request.no_plot else PICTURE))
    plan = {
        "orbits": ceil(size.orbits / share),
        "periods": ceil(size.turns / share) or None,
        "impacts": None if impacts is None else ceil(impacts / share),
        "seconds": None if seconds is None else seconds / share,
        "bytes": 0 if shard else files,
        "disk": ceil(size.disk / share) if shard else files and files + ceil(size.disk / 2),
        "memory": round(PROGRAM + COMPILED + (0 if request.no_plot else DRAWING) + size.memory),
    }
    if request.json:
        print(json.dumps({"command": command, "plan": {**plan, "notes": notes}}, indent=2))
        return
    rows = [[name, _cell(name, value)] for name, value in plan.items()]
    table(f"cam {command}, planned", ["what", "estimate"], rows)
    for text in notes:
        print(text)


def _cell(name: str, value: Any) -> str:
    if value is None:
        return "not known before"
    if name in ("bytes", "disk", "memory"):
        return in_words(value)
    return f"{value:.2g} s" if name == "seconds" else f"{value:.6g}"


def _parts(command: str, scene: Scene, options: Mapping[str, Any]) -> list[tuple[str, Scene]]:
    """The commands, and their scenes, that a command is made of and whose cost can be known."""
    parts = {"": (command, scene)}
    if command == "explore":
        from camcli.api.explore import parts_of
        from camcli.api.machine import machine_of

        parts = parts_of(machine_of(scene).scene, options["with_basins"], options["with_map"])
    return [(name, own) for name, own in parts.values() if name != "orbits"]


def _extrapolated(command: str, scene: Scene, request: Request) -> list[float]:
    """Impacts, seconds and bytes of the tables, from samples of growing size.

    In proportion to the turns where their number is known, else fixed + pieces * each, from the
    two largest samples: a cost that comes once must be told from the rest.
    """
    size = size_of(command, scene)
    for_work(size.turns or LITTLE_WORK + 1)  # a sample runs as the whole will
    samples: list[tuple[Scene, list[float]]] = []

    def tick(*_: object) -> None:
        if watch.passed() > MOST:
            raise TimeoutError

    n, enough = (8, 1) if size.turns else (2, 2)
    with stopwatch() as watch:
        while n <= LARGEST and (len(samples) < enough or watch.passed() < ENOUGH):
            small = sample_of(command, scene, n)
            result = analysis(command, Work(request.threads))(small, tick)
            text = sum(len(line) for t in result.tables.values() for line in t.csv())
            costs = [result.cost.impacts, result.seconds, text + len(json.dumps(result.summary))]
            samples.append((small, costs))
            if size_of(command, small).pieces == size.pieces:
                break
            n *= 2
    small, last = samples[-1]
    part = size_of(command, small)
    if size.turns:
        recorded = size.orbits * scene.run.record / (part.orbits * small.run.record)
        scales = [size.turns / part.turns, size.turns / part.turns, recorded]
        return [cost * scale for cost, scale in zip(last, scales, strict=True)]
    fixed = [0.0] * len(last)
    if len(samples) > 1:
        before, earlier = samples[-2]
        share = part.pieces / (part.pieces - size_of(command, before).pieces)
        fixed = [min(b, max(0.0, b - share * (b - a))) for a, b in zip(earlier, last, strict=True)]
    return [f + (c - f) * size.pieces / part.pieces for f, c in zip(fixed, last, strict=True)]


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
