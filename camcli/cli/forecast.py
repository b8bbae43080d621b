"""What a run will cost: a few of its real pieces are run for a moment and extrapolated."""

from __future__ import annotations

import json
from io import BytesIO
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.api.command import Command, Page, command_of
from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.cli.sizes import PROGRAM, drawing_of, in_words
from camcli.interrupts import CutOffError, until
from camcli.kernel.backend import LITTLE_WORK, Stopwatch, for_work, stopwatch
from camcli.parallel import Shard, Work
from camcli.parallel.checkpoint import Checkpoint, pack
from camcli.scene import Scene
from camcli.words import plan

if TYPE_CHECKING:
    from camcli.api.result import Result

RECORD = 5e3  # bytes of run.json
MOST = 10.0  # s of all samples, then nothing more is foreseen
ENOUGH = 1.0  # s after which no larger sample is run
PER_WORK = 2e-7  # s, for one of it, measured: 1e-7 to 4e-7
LARGEST = 32  # the largest sample; each is twice the one before
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


def forecast(command: Command, scene: Scene, request: Request, shard: Shard | None) -> None:
    """Print what the run would do and cost; nothing is written, and it takes a few seconds."""
    command.check(scene)
    size, share = command.size(scene), 1 if shard is None else shard.total
    notes = [plan.of_a_shard(shard.number, shard.total)] if shard else []
    notes += command.not_foreseen(scene)
    cost = None
    if size.orbits == 0:
        cost = Cost(0.0, 0.0, 0.0, size.tables, 0.0)
    elif command.sample is not None:
        with stopwatch() as watch, until(lambda: watch.passed() > MOST):
            try:
                cost = _sampled(command, scene, request, watch)
            except CutOffError:
                notes.append(plan.cut_off(MOST))
    explained = getattr(getattr(scene, command.name, None), "explain", False)
    if explained or (cost is None and command.has_budget):
        most = scene.run.work_budget
        notes.append(plan.budget_ends(most, PER_WORK * most))
    drawn = not request.no_plot and shard is None
    drawing, pictures = drawing_of(command, scene) if drawn else (0.0, 0.0)
    more = command.beside(scene)
    files = kept = None
    if cost is not None:
        files = 0 if shard else ceil(cost.recorded + cost.rows + RECORD + pictures + more)
        kept = ceil(cost.kept / share) if command.keeps_pieces(scene) else 0
    planned = {
        "orbits": ceil(size.orbits / share),
        "periods": ceil(size.turns / share) or None,
        "impacts": None if cost is None else ceil(cost.impacts / share),
        "seconds": None if cost is None else cost.seconds / share,
        "bytes": files,
        "disk": None if files is None or kept is None else files + kept,
        "memory": round(PROGRAM + drawing + size.memory),
    }
    if request.json:
        print(json.dumps({"command": command.name, "plan": {**planned, "notes": notes}}, indent=2))
        return
    rows = [[name, _cell(name, value)] for name, value in planned.items()]
    table(f"cam {command.name}, planned", ["what", "estimate"], rows)
    for text in notes:
        print(text)


def _cell(name: str, value: Any) -> str:
    """An estimate with its unit, as a cell of the table."""
    if value is None:
        return "not known before"
    if name in ("bytes", "disk", "memory"):
        return in_words(value)
    return f"{value:.2g} s" if name == "seconds" else f"{value:.6g}"


def _sampled(command: Command, scene: Scene, request: Request, watch: Stopwatch) -> Cost:
    """The cost of a command from samples of it, or of the commands that it is made of."""
    if command.page is not None:
        return _of_page(command.page, scene, request, watch)
    one, times = command.repeated(scene)
    cost, _ = _extrapolated(command, one, request, watch)
    if times > 1 and command.size(scene).rows == 0:  # what grows is not written then
        cost = cost._replace(recorded=0.0)
    return Cost(*(times * part for part in cost))


def _of_page(page: Page, scene: Scene, request: Request, watch: Stopwatch) -> Cost:
    """The cost of all parts of a page that have samples, and its length."""
    from camcli.api.machine import machine_of

    machine = machine_of(scene)
    samples = {}
    for name, (part, own) in page.parts(machine.scene).items():
        command = command_of(part)
        if command.sample is not None:
            samples[name] = _extrapolated(command, own, request, watch)
    costs = [cost for cost, _ in samples.values()]
    results = {name: result for name, (_, result) in samples.items()}
    length = page.size(machine, results)
    return Cost(sum(c.impacts for c in costs), sum(c.seconds for c in costs), 0.0, length, 0.0)


def _extrapolated(
    command: Command, scene: Scene, request: Request, watch: Stopwatch
) -> tuple[Cost, Result]:
    """The cost, from samples of growing size, and the result of the largest of them.

    In proportion to the turns, recorded turns and rows where their number is known, else fixed +
    pieces * each, from the two largest samples: a cost that comes once must be told from the rest.
    """
    assert command.sample is not None
    size = command.size(scene)
    for_work(size.turns or LITTLE_WORK + 1)  # a sample runs as the whole will
    samples: list[tuple[Scene, Cost]] = []

    def tick(*_: object) -> None:
        """End the sample where all samples together have taken too long."""
        if watch.passed() > MOST:
            raise CutOffError

    n, enough = (8, 1) if size.turns else (2, 2)
    with stopwatch() as own:
        while n <= LARGEST and (len(samples) < enough or own.passed() < ENOUGH):
            small, weighed = command.sample(scene, n), _Weighed()
            pieces = command.size(small).pieces
            result = command.in_pieces(Work(request.threads, weighed))(small, tick)
            samples.append((small, _cost_of(result, weighed.bytes)))
            if pieces == size.pieces:
                break
            n *= 2
    small, last = samples[-1]
    part = command.size(small)
    if size.turns:
        turns, rows = size.turns / part.turns, size.rows / max(1, part.rows)
        recorded = size.orbits * scene.run.record / (part.orbits * small.run.record)
        kept = recorded if last.recorded else rows
        scales = Cost(turns, turns, recorded, rows, kept)
        return Cost(*(cost * scale for cost, scale in zip(last, scales, strict=True))), result
    fixed = Cost(0.0, 0.0, 0.0, 0.0, 0.0)
    if len(samples) > 1:
        before, earlier = samples[-2]
        share = part.pieces / (part.pieces - command.size(before).pieces)
        pairs = zip(earlier, last, strict=True)
        fixed = Cost(*(min(b, max(0.0, b - share * (b - a))) for a, b in pairs))
    scale = size.pieces / part.pieces
    return Cost(*(f + (c - f) * scale for f, c in zip(fixed, last, strict=True))), result


def _cost_of(result: Result, kept: int) -> Cost:
    """What a sample has taken."""
    section = getattr(result.scene, result.command, None)
    binary = getattr(section, "tables", "csv") == "npz"
    sizes = {}
    for name, one in result.tables.items():
        file = BytesIO()
        (one.npz if binary and name != "speeds" else one.write_csv)(file)
        sizes[name] = file.tell()
    large = sum(sizes[name] for name in sizes if name in LARGE)
    rows = sum(sizes.values()) - large + len(json.dumps(result.summary))
    return Cost(result.cost.impacts, result.seconds, large, rows, kept)
