"""How much a scene asks for, known without any work, and the refusal of what can never fit."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import NamedTuple

from camcli.api.command import Command
from camcli.errors import Fault, SceneError
from camcli.parallel import Shard, memory
from camcli.quantities import MM_PER_INCH
from camcli.scene import Scene
from camcli.scene.schema import Plot
from camcli.words.in_print import written_out

SHARE_OF_MEMORY = 0.8  # that a run may need; the words of `refuse_too_large` say 80%
PROGRAM = 110e6  # bytes of memory of the program with the compiled kernel, measured
MUCH = 200e6  # bytes of files that are worth a word
PAGE_HEIGHT = 230.0  # mm
DOTS_PER_INCH = 300.0
PER_PIXEL = 0.01  # bytes of a PNG for each pixel more


class Drawn(NamedTuple):
    """Bytes of memory to draw the pictures of a command, and bytes of their files."""

    memory: float
    files: float


NOT_DRAWN = Drawn(0.0, 0.0)


def drawing_of(command: Command, scene: Scene) -> Drawn:
    """The memory and bytes that drawing takes: of a picture of usual size, more for more pixels."""
    usual = command.drawing(scene)
    more_pixels = max(0.0, _pixels(scene.plot) - _pixels(Plot()))
    file = usual.file + PER_PIXEL * more_pixels
    memory_to_draw = usual.memory + usual.per_pixel * more_pixels
    return Drawn(memory_to_draw, files=len(scene.plot.formats) * file)


def _pixels(plot: Plot) -> float:
    """The pixels of a picture of this size and style; one without a height is as high as a page."""
    per_inch = DOTS_PER_INCH
    if plot.style is not None:
        from camcli.plots.style import dpi_of

        per_inch = dpi_of(plot.style)
    return plot.width * (plot.height or PAGE_HEIGHT) * (per_inch / MM_PER_INCH) ** 2


class Limit(NamedTuple):
    """How many bytes there may be, and why, in words."""

    bytes: float
    words: str


def refuse_too_large(
    command: Command,
    scene: Scene,
    folder: Path,
    *,
    drawn: bool = True,
    shard: Shard | None = None,
) -> None:
    """Raise SceneError for a run whose least need is more than this machine has."""
    size = command.size(scene)
    share = 1 if shard is None else shard.total
    drawing = drawing_of(command, scene) if drawn and shard is None else NOT_DRAWN
    files = size.kept if shard is not None else size.kept + size.tables
    of_memory = Limit(SHARE_OF_MEMORY * memory(), "80% of this machine's")
    of_disk = Limit(free_disk(folder), f"free on the disk of {folder}")
    smaller = "draw smaller: plot.width, plot.height, or the dpi of plot.style"
    faults = []
    for needed, limit, what, cure in (
        (size.memory, of_memory, "memory", "ask for fewer"),
        (drawing.memory, of_memory, "memory to draw", smaller),
        (files / share, of_disk, "files", "ask for fewer, or choose another -o"),
    ):
        if needed > limit.bytes:
            found = f"found {size.what}, at least {in_words(needed)} of {what}"
            expected = f"expected at most {in_words(limit.bytes)}, {limit.words}"
            faults.append(Fault("", command.name, found, expected, cure))
    if faults:
        raise SceneError(*faults)


def in_words(count: float) -> str:
    """Bytes in words: MB, from a thousand of them on GB."""
    if count >= 1e9:
        return f"{written_out(count / 1e9, 3)} GB"
    return f"{written_out(count / 1e6, 3)} MB"


def free_disk(folder: Path) -> float:
    """Bytes free where the folder is or will be."""
    nearest = folder.absolute()  # the folder itself, or the nearest above it that is there
    while not os.path.exists(nearest) and nearest != nearest.parent:  # a name too long is no error
        nearest = nearest.parent
    try:
        return float(shutil.disk_usage(nearest).free)
    except OSError:
        return float("inf")
