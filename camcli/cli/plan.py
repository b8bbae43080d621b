"""--dry-run: what a run would do and cost; and the refusal, before any work, of what cannot fit.

`planned` is called by every long command. The estimates of each are in plan_COMMAND.py, from a look
at some of the work (plan_probe.py) and the constants of plan_costs.py.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.errors import Fault, SceneError

SHARE_OF_MEMORY = 0.8
SLIGHT = 1 / 64  # share of the room below which the least that is needed cannot become too much


@dataclass(frozen=True)
class Plan:
    """Estimated cost of a run: seconds of the whole command, bytes, and what comes on top.

    bytes: of the artefacts; disk: with the finished pieces, just before these are deleted.
    """

    orbits: int
    periods: int
    impacts: int
    seconds: float
    bytes: int
    disk: int
    memory: int
    notes: tuple[str, ...] = ()

    def show(self, name: str, as_json: bool) -> None:
        """Print the plan of `cam NAME`, as a table or as one JSON object."""
        if as_json:
            print(json.dumps({"command": name, "plan": asdict(self)}, indent=2))
            return
        table(f"cam {name}, planned", ["what", "how much"], self._lines())
        for text in self.notes:
            print(text)

    def _lines(self) -> list[list[str]]:
        return [
            ["orbits", f"{self.orbits}"],
            ["periods", f"{self.periods}"],
            ["impacts (estimated)", f"{self.impacts:.3g}"],
            ["seconds (estimated)", f"{self.seconds:.2g}"],
            ["artefacts (estimated)", size(self.bytes)],
            ["disk while it runs (estimated)", size(self.disk)],
            ["memory (estimated)", size(self.memory)],
        ]


@dataclass(frozen=True)
class Need:
    """The least bytes a run takes, known without a look, and what asks for them, in words."""

    path: str
    what: str
    memory: float
    disk: float
    cure: str


def planned(name: str, request: Request, need: Need, estimate: Callable[[], Plan]) -> bool:
    """Show the plan where it was asked for (True); raise SceneError where it cannot fit.

    What is far from too large is not looked at, and what cannot fit by far is not either.
    """
    room, free = SHARE_OF_MEMORY * memory(), free_disk(request.folder(name))
    near = need.memory > SLIGHT * room or need.disk > SLIGHT * free
    if need.memory > room or need.disk > free:
        least = ("at least ", need.memory, need.disk)
        if request.dry_run:
            _show_least(name, request, need)
        _refuse(name, request, need, least, room, free)
    if request.dry_run or near:
        cost = estimate()
        if request.dry_run:
            cost.show(name, request.json)
        _refuse(name, request, need, ("", cost.memory, cost.disk), room, free)
    return request.dry_run


def _show_least(name: str, request: Request, need: Need) -> None:
    """The figures of what is not even looked at."""
    if request.json:
        least = {"memory": round(need.memory), "disk": round(need.disk)}
        print(json.dumps({"command": name, "at_least": least}, indent=2))
        return
    lines = [["memory", size(need.memory)], ["disk while it runs", size(need.disk)]]
    table(f"cam {name}, planned", ["what", "at least"], lines)


def _refuse(name: str, request: Request, need: Need, figures, room: float, free: float) -> None:
    """Raise SceneError for the memory and for the disk, whichever is too small."""
    least, memory_needed, disk_needed = figures
    faults = []
    if memory_needed > room:
        found = f"found {need.what}, {least}{size(memory_needed)} of memory"
        expected = f"expected at most {size(room)}, {SHARE_OF_MEMORY:.0%} of this machine's"
        faults.append(Fault("", need.path, found, expected, need.cure))
    if disk_needed > free:
        found = f"found {need.what}, {least}{size(disk_needed)} of files"
        expected = f"expected at most {size(free)}, free on the disk of {request.folder(name)}"
        faults.append(Fault("", need.path, found, expected, f"{need.cure}, or choose another -o"))
    if faults:
        raise SceneError(*faults)


def size(count: float) -> str:
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
