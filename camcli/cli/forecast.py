"""What a run will cost: a few of its real pieces are run for a moment and extrapolated."""

from __future__ import annotations

import json
from io import BytesIO
from math import ceil
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.api.command import Command, Page, command_of
from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.cli.sizes import NOT_DRAWN, PROGRAM, drawing_of, in_words
from camcli.interrupts import CutOffError, cut_off_when
from camcli.kernel.backend import LITTLE_WORK, Stopwatch, for_work, stopwatch
from camcli.parallel import Shard, Work
from camcli.parallel.checkpoint import Checkpoint, pack
from camcli.parallel.rows import Rows
from camcli.scene import Scene
from camcli.words import plan
from camcli.words.in_print import written_out

if TYPE_CHECKING:
    from camcli.api.result import Result

RECORD = 5e3  # bytes of run.json
MOST = 10.0  # s of all samples, then nothing more is foreseen
ENOUGH = 1.0  # s after which no larger sample is run
PER_WORK = 2e-7  # s for one unit of run.work_budget, measured: 1e-7 to 4e-7
# A sample has so many pieces: first FIRST, then twice as many each time, LARGEST at most. Where the
# turns of the whole are known one sample can be enough; else two are compared.
FIRST, FIRST_OF_TWO = 8, 2
LARGEST = 32
# tables that grow with the record, or the cells
LARGE = ("impacts", "strobe", "trajectory", "events", "basins")


class Cost(NamedTuple):
    """What a sample, or a whole run, takes."""

    impacts: float
    seconds: float
    recorded: float  # bytes of LARGE tables
    rows: float  # bytes of other tables, and of the summary
    kept: float  # bytes of finished pieces on disk

    def times(self, count: float) -> Cost:
        """The cost of a number of equal runs."""
        return Cost(*(count * value for value in self))


class Sample(NamedTuple):
    """A sample that was run: its scene, its cost, its result."""

    scene: Scene
    cost: Cost
    result: Result


class Plan(NamedTuple):
    """What a run will take, as `--dry-run --json` names it; None: not known before."""

    orbits: int
    periods: int | None
    impacts: int | None
    seconds: float | None
    bytes: int | None  # of the files that are left
    disk: int | None  # the same with the finished pieces, while the run goes on
    memory: int  # bytes


class Foreseen(NamedTuple):
    """The cost of a whole run, and the result of the largest sample of it."""

    cost: Cost
    result: Result


class _Weighed(Checkpoint):
    """A checkpoint that keeps nothing, and counts the bytes of what it is given."""

    def __init__(self) -> None:
        self.bytes = 0

    def __contains__(self, name: tuple[str, int]) -> bool:
        """No piece is there: all are computed."""
        return False

    def put(self, place: str, number: int, value: Any) -> None:
        """Count the bytes that a piece would take on disk."""
        text, arrays = pack(value)
        self.bytes += len(text) + len(arrays)

    def expected_size(self, pieces: int, beside: int) -> float:
        """Nothing is on disk: the results stay in memory, a sample has few."""
        return 0.0

    def rows(self, width: int) -> Rows:
        """Rows in memory: a sample has few."""
        return Rows(width)


def forecast(command: Command, scene: Scene, request: Request, shard: Shard | None) -> None:
    """Print what the run would do and cost; nothing is written, and it takes a few seconds."""
    command.check(scene)
    notes = [plan.of_a_shard(shard.number, shard.total)] if shard else []
    notes += command.not_foreseen(scene)
    cost = None
    try:
        cost = _cost_of_all(command, scene, request)
    except CutOffError:
        notes.append(plan.cut_off(MOST))
    explained = getattr(getattr(scene, command.name, None), "explain", False)
    if explained or (cost is None and command.has_budget):
        most = scene.run.work_budget
        notes.append(plan.budget_ends(most, PER_WORK * most))
    planned = _plan(command, scene, request, shard, cost)._asdict()
    if request.json:
        print(json.dumps({"command": command.name, "plan": {**planned, "notes": notes}}, indent=2))
        return
    rows = [[name, _cell(name, value)] for name, value in planned.items()]
    table(f"cam {command.name}, planned", ["what", "estimate"], rows)
    for text in notes:
        print(text)


def _cost_of_all(command: Command, scene: Scene, request: Request) -> Cost | None:
    """The cost of the whole run; None where the command has no samples.

    Raises CutOffError where the samples take longer than MOST.
    """
    size = command.size(scene)
    if size.orbits == 0:  # nothing is run: the files that are left are all of it
        return Cost(impacts=0.0, seconds=0.0, recorded=0.0, rows=size.tables, kept=0.0)
    if command.sample is None:
        return None
    with stopwatch() as watch, cut_off_when(lambda: watch.passed() > MOST):
        return _sampled(command, scene, request, watch)


def _plan(
    command: Command, scene: Scene, request: Request, shard: Shard | None, cost: Cost | None
) -> Plan:
    """The plan of a run or of one shard of it; cost: of the whole run, None where unknown.

    A shard does its part of the work. It draws nothing and leaves no tables, only its pieces.
    """
    size = command.size(scene)
    shards = 1 if shard is None else shard.total
    drawn = not request.no_plot and shard is None
    pictures = drawing_of(command, scene) if drawn else NOT_DRAWN
    of_all = Plan(
        orbits=ceil(size.orbits / shards),
        periods=ceil(size.turns / shards) or None,
        impacts=None,
        seconds=None,
        bytes=None,
        disk=None,
        memory=round(PROGRAM + pictures.memory + size.memory),
    )
    if cost is None:
        return of_all
    left = 0
    if shard is None:
        tables = cost.recorded + cost.rows
        left = ceil(tables + RECORD + pictures.files + command.beside(scene))
    kept = ceil(cost.kept / shards) if command.keeps_pieces(scene) else 0
    return of_all._replace(
        impacts=ceil(cost.impacts / shards),
        seconds=cost.seconds / shards,
        bytes=left,
        disk=left + kept,
    )


def _cell(name: str, value: Any) -> str:
    """An estimate with its unit, as a cell of the table."""
    if value is None:
        return "not known before"
    if name in ("bytes", "disk", "memory"):
        return in_words(value)
    return f"{written_out(value, 2)} s" if name == "seconds" else written_out(value, 6)


def _sampled(command: Command, scene: Scene, request: Request, watch: Stopwatch) -> Cost:
    """The cost of a command from samples of it, or of the commands that it is made of.

    A command that repeats another one on many machines, and has no rows of its own, keeps a summary
    of each run and writes none of their tables: what these would take is not counted.
    """
    if command.page is not None:
        return _of_page(command.page, scene, request, watch)
    repeated = command.repeated(scene)
    cost = _extrapolated(command, repeated.scene, request, watch).cost
    if repeated.times > 1 and command.size(scene).rows == 0:
        cost = cost._replace(recorded=0.0)
    return cost.times(repeated.times)


def _of_page(page: Page, scene: Scene, request: Request, watch: Stopwatch) -> Cost:
    """The cost of all parts of a page that have samples, and its length."""
    from camcli.api.machine import machine_of

    machine = machine_of(scene)
    foreseen = {}
    for name, part in page.parts(machine.scene).items():
        command = command_of(part.command)
        if command.sample is not None:
            foreseen[name] = _extrapolated(command, part.scene, request, watch)
    results = {name: part.result for name, part in foreseen.items()}
    length = page.size(machine, results)
    return Cost(
        impacts=sum(part.cost.impacts for part in foreseen.values()),
        seconds=sum(part.cost.seconds for part in foreseen.values()),
        recorded=0.0,
        rows=length,
        kept=0.0,
    )


def _extrapolated(command: Command, scene: Scene, request: Request, watch: Stopwatch) -> Foreseen:
    """The cost of a run, from samples of growing size.

    watch: the time of all samples of the forecast, which must not take longer than MOST.
    """
    samples = _samples(command, scene, request, watch)
    if command.size(scene).turns:
        cost = _by_turns(command, scene, samples[-1])
    else:
        cost = _by_pieces(command, scene, samples)
    return Foreseen(cost, samples[-1].result)


def _samples(command: Command, scene: Scene, request: Request, watch: Stopwatch) -> list[Sample]:
    """Samples, each of twice the pieces of the one before, until they have taken ENOUGH time."""
    assert command.sample is not None
    size = command.size(scene)
    for_work(size.turns or LITTLE_WORK + 1)  # a sample runs as the whole will
    samples: list[Sample] = []

    def tick(*_: object) -> None:
        """End the sample where all samples together have taken too long."""
        if watch.passed() > MOST:
            raise CutOffError

    pieces = FIRST if size.turns else FIRST_OF_TWO
    least_samples = 1 if size.turns else 2
    with stopwatch() as of_these:
        while pieces <= LARGEST:
            if len(samples) >= least_samples and of_these.passed() >= ENOUGH:
                break
            small = command.sample(scene, pieces)
            weighed = _Weighed()
            is_all = command.size(small).pieces == size.pieces
            result = command.in_pieces(Work(request.threads, weighed))(small, tick)
            samples.append(Sample(small, _cost_of(result, weighed.bytes), result))
            if is_all:
                break
            pieces *= 2
    return samples


def _by_turns(command: Command, scene: Scene, sample: Sample) -> Cost:
    """The cost of the whole, from that of a sample: so many times its turns, records and rows.

    Pieces on disk (`kept`) hold what the tables will: where the tables grow with the recorded
    turns, so do the pieces, else they grow with the rows.
    """
    size = command.size(scene)
    part = command.size(sample.scene)
    times_turns = size.turns / part.turns
    times_rows = size.rows / max(1, part.rows)
    times_recorded = size.orbits * scene.run.record / (part.orbits * sample.scene.run.record)
    cost = sample.cost
    return Cost(
        impacts=cost.impacts * times_turns,
        seconds=cost.seconds * times_turns,
        recorded=cost.recorded * times_recorded,
        rows=cost.rows * times_rows,
        kept=cost.kept * (times_recorded if cost.recorded else times_rows),
    )


def _by_pieces(command: Command, scene: Scene, samples: list[Sample]) -> Cost:
    """The cost of the whole, from the two largest samples: cost = fixed + each * pieces.

    What comes once in a run, `fixed`, is where the straight line through both samples begins, at
    no pieces. It lies between 0 and the cost of the larger sample. With one sample it is 0.
    """
    larger = samples[-1].cost
    pieces = command.size(samples[-1].scene).pieces
    times = command.size(scene).pieces / pieces
    if len(samples) == 1:
        return larger.times(times)
    smaller = samples[-2].cost
    pieces_before = command.size(samples[-2].scene).pieces
    share = pieces / (pieces - pieces_before)
    of_whole = []
    for before, cost in zip(smaller, larger, strict=True):
        fixed = min(cost, max(0.0, cost - share * (cost - before)))
        of_whole.append(fixed + (cost - fixed) * times)
    return Cost(*of_whole)


def _cost_of(result: Result, kept: int) -> Cost:
    """The cost of a run that was made as a sample; kept: bytes of its pieces."""
    section = getattr(result.scene, result.command, None)
    as_npz = getattr(section, "tables", "csv") == "npz"
    recorded = 0
    rows = len(json.dumps(result.summary))
    for name, table_ in result.tables.items():
        file = BytesIO()
        if as_npz and name != "speeds":
            table_.npz(file)
        else:
            table_.write_csv(file)
        if name in LARGE:
            recorded += file.tell()
        else:
            rows += file.tell()
    return Cost(result.cost.impacts, result.seconds, recorded, rows, kept)
