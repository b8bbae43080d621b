"""How much a scene asks for, known without any work, and the refusal of what can never fit."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from camcli.errors import Fault, SceneError
from camcli.parallel import Shard, memory
from camcli.parallel.work import IN_MEMORY
from camcli.scene import Scene
from camcli.scene.schema import Plot

SHARE_OF_MEMORY = 0.8
PROGRAM = 110e6  # bytes of memory of the program with the compiled kernel, measured
MUCH = 200e6  # bytes of files that are worth a word
SHOWN_WITH = {  # of a picture of PAGE: bytes of its PNG, of memory to draw it, and per pixel beyond
    "simulate": (290e3, 70e6, 5.0),
    "sweep": (360e3, 230e6, 15.0),
    "map": (80e3, 130e6, 30.0),
    "detach": (400e3, 90e6, 5.0),
    "orbits": (400e3, 120e6, 5.0),
    "basins": (110e3, 270e6, 75.0),
    "classify": (130e3, 230e6, 24.0),
    "explore": (0.0, 60e6, 0.0),
}
OTHERS = (200e3, 100e6, 5.0)
PAGE, PER_INCH = (170.0, 230.0), 300.0  # mm; dots
PER_PIXEL = 0.01  # bytes of a PNG for each pixel more
PER_POINT = 1000.0  # bytes of memory of a point on a curve of simulate,
FINER, MOST_POINTS = 8, 400_000  # which has so many a row, but no more in all (plots/simulate.py)
MOTIONS = 256  # of a page of explore: starts in a window, or points of a map
ROWS = 48  # of a turn on a page of explore, at least


class Size(NamedTuple):
    """How much a scene asks for, and the least bytes that takes."""

    what: str
    pieces: int  # of equal work
    orbits: int
    turns: float  # of all orbits; 0 where it is not known before
    rows: int  # of the tables that do not grow with the recorded turns
    memory: float  # beside the program and its pictures
    tables: float  # of the files that are left
    kept: float  # of the pieces on disk until those are written


def size_of(command: str, scene: Scene, options: Mapping[str, Any]) -> Size:
    """The size of a command's work; options: further arguments of its API function."""
    run, turns = scene.run, scene.run.transient + scene.run.record
    match command:
        case "simulate" if options.get("profile_only"):
            n = scene.simulate.samples * (1 + len(scene.simulate.beside))
            return Size(f"{n} samples", 1, 0, 0.0, n, 350.0 * n, 80.0 * n, 0.0)
        case "simulate":
            rows = scene.simulate.samples * run.record
            what = f"{run.record} recorded turns x {scene.simulate.samples} samples"
            return Size(what, run.record, 1, turns, 0, 240.0 * rows, 100.0 * rows, 0.0)
        case "sweep":
            section, what = scene.sweep, f"speeds of {turns} turns, {run.record} recorded"
            n = section.count + sum(part.num for part in section.zoom)
            n *= (1 + len(section.also)) * (1 + (section.direction == "both"))
            recorded = n * run.record * len(section.sections)
            if len(section.vary) == 2:
                n, recorded = section.vary[0].num * section.vary[1].num, 0
            kept = 43.0 * recorded + 400.0 * n
            memory = 32.0 * recorded / max(1, n) + 1e3 * n + min(IN_MEMORY, kept)
            tables = 43.0 * recorded * (section.tables != "none") + 140.0 * n
            return Size(f"{n} {what}", n, n, n * turns, n, memory, tables, kept)
        case "classify":
            speeds, starts = scene.classify.count, scene.classify.starts + 1
            what = f"{speeds} speeds x {starts} starts x {run.record} recorded turns"
            orbits, memory = speeds * starts, 45.0 * speeds * run.record
            return Size(what, orbits, orbits, orbits * turns, speeds, memory, 160.0 * speeds, 0.0)
        case "basins":
            (nq, nv), levels = scene.basins.cells, scene.basins.refine
            what, orbits = (
                f"{nq} x {nv} cells, refined {levels} times",
                nq * nv * scene.basins.count,
            )
            memory = 70.0 * nq * nv + (14.0 * nq * nv * 4**levels + 20e6 if levels else 0.0)
            shown = orbits if scene.basins.count <= 3 else 0
            return Size(what, orbits, orbits, 0.0, shown, memory, 18.0 * shown, 27.0 * orbits)
        case "explore":
            return _of_explore(scene, options)
        case "detach" | "orbits":
            n = scene.detach.rpm.num if command == "detach" else scene.orbits.starts + 1
            return Size(f"{n} runs", n, n, 0.0, n, 300.0 * n, 100.0 * n, 0.0)
        case _:
            return Size("one run", 1, 1, 0.0, 1, 0.0, 0.0, 0.0)


def _of_explore(scene: Scene, options: Mapping[str, Any]) -> Size:
    """Three sweeps whose records are all in memory, the motions of the page, and what is beside."""
    run, n = scene.run, scene.sweep.rpm.num
    turns, orbits, what = run.transient + run.record, 3 * n, f"{n} speeds of 3 sweeps"
    shown, memory = 2.0 * n, 3.0 * n * (64.0 * run.record + 1e3)
    whole = float(orbits * turns)
    if options.get("with_basins"):
        cells = scene.basins.cells[0] * scene.basins.cells[1]
        orbits, shown, memory = orbits + cells, shown + 8.0 * MOTIONS, memory + 70.0 * cells
        what += f", {cells} cells"
    if options.get("with_map"):
        axes = scene.sweep.vary
        points = axes[0].num * (axes[1].num if len(axes) == 2 else n) if axes else 0
        orbits, shown, memory = orbits + points, shown + 8.0 * MOTIONS, memory + 1e3 * points
        whole += points * turns
        what += f", {points} points of a map"
    rows = ROWS * shown  # each takes 280 bytes until the page is written, 17 in it
    return Size(what, n, orbits, whole, n, memory + 280.0 * rows, 90e3 + 17.0 * rows, 0.0)


def drawing_of(command: str, scene: Scene, options: Mapping[str, Any]) -> tuple[float, float]:
    """(bytes of memory to draw the pictures of a command, bytes of their files)."""
    name = "map" if command == "sweep" and len(scene.sweep.vary) == 2 else command
    file, needed, each = SHOWN_WITH.get(name, OTHERS)
    more = max(0.0, _pixels(scene.plot) - _pixels(Plot()))
    needed += each * more
    if command == "simulate" and not options.get("profile_only"):
        rows = scene.simulate.samples * min(scene.simulate.plot_turns, scene.run.record)
        needed += PER_POINT * min(FINER * rows, max(2 * rows, MOST_POINTS))
    return needed, len(scene.plot.formats) * (file + PER_PIXEL * more)


def _pixels(plot: Plot) -> float:
    per_inch = PER_INCH
    if plot.style is not None:
        from camcli.plots.style import dpi_of

        per_inch = dpi_of(plot.style)
    return plot.width * (plot.height or PAGE[1]) * (per_inch / 25.4) ** 2


def refuse_too_large(
    command: str,
    scene: Scene,
    folder: Path,
    options: Mapping[str, Any],
    *,
    drawn: bool = True,
    shard: Shard | None = None,
) -> None:
    """Raise SceneError for a run whose least need is more than this machine has."""
    need, share = size_of(command, scene, options), 1 if shard is None else shard.total
    drawing = drawing_of(command, scene, options)[0] if drawn and shard is None else 0.0
    faults = []
    for have, needed, of, where, cure in (
        (SHARE_OF_MEMORY * memory(), need.memory, "memory", "80% of this machine's",
         "ask for fewer"),
        (SHARE_OF_MEMORY * memory(), drawing, "memory to draw", "80% of this machine's",
         "draw smaller: plot.width, plot.height, or the dpi of plot.style"),
        (free_disk(folder), (need.kept + need.tables * (shard is None)) / share, "files",
         f"free on the disk of {folder}", "ask for fewer, or choose another -o"),
    ):  # fmt: skip
        if needed > have:
            found = f"found {need.what}, at least {in_words(needed)} of {of}"
            limit = f"expected at most {in_words(have)}, {where}"
            faults.append(Fault("", command, found, limit, cure))
    if faults:
        raise SceneError(*faults)


def in_words(count: float) -> str:
    """Bytes in words: MB, from a thousand of them on GB."""
    return f"{count / 1e9:.3g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


def free_disk(folder: Path) -> float:
    """Bytes free where the folder is or will be."""
    place = folder.absolute()
    while not os.path.exists(place) and place != place.parent:  # a name too long is no error
        place = place.parent
    try:
        return float(shutil.disk_usage(place).free)
    except OSError:
        return float("inf")
