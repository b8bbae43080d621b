"""The process that draws what a command line asks for, started before anything else is imported."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from camcli.api import ANALYSES

if TYPE_CHECKING:
    from camcli.api.command import Command
    from camcli.output.drawing_process import DrawingProcess
    from camcli.scene import Scene

WHAT_DRAWS = "camcli.plots.picture"  # what all pictures import, matplotlib with it
WITHOUT_PICTURES = ("explore",)
# Options with which a command draws nothing, or shall leave other processors alone.
DRAWN_HERE = ("--no-plot", "--dry-run", "--shard", "--threads", "--help", "-h")

_started: list[tuple[str, DrawingProcess]] = []  # name of the command, process; one at most


def start(words: Sequence[str]) -> None:
    """Start the process for a command line `cam WORDS` that will probably draw.

    Only where a second processor is free for it.
    """
    name = words[0] if words else ""
    if name not in ANALYSES or name in WITHOUT_PICTURES:
        return
    if any(word.startswith(DRAWN_HERE) for word in words):
        return
    from camcli.output.drawing_process import DrawingProcess
    from camcli.parallel.threads import thread_count

    if thread_count(None) < 2:
        return
    modules = (WHAT_DRAWS, f"camcli.plots.{name}", f"camcli.api.{name}")
    _started.append((name, DrawingProcess(modules)))


def process_for(command: Command, scene: Scene) -> DrawingProcess | None:
    """The process that was started for a command; None where there is none.

    One whose result will be too large to be sent is ended.
    """
    from camcli.output.drawing_process import MOST_SENT

    for name, process in _started:
        if name == command.name:
            if command.size(scene).memory <= MOST_SENT:
                return process
            process.end()
    return None


def let_go() -> None:
    """Let the process end, if there is one: this one ends."""
    for _, process in _started:
        process.let_go()
    _started.clear()
