"""What `cam basins` costs."""

from __future__ import annotations

from camcli.analysis.basins.attractor_finder import SCOUT_TURNS, SCOUTS
from camcli.analysis.basins.mapping import SIMPLE, Question
from camcli.analysis.basins.uncertainty import COARSEST, FINEST, STARTS
from camcli.cli import plan_costs as costs
from camcli.cli.long_run import shard_of
from camcli.cli.options import Request
from camcli.cli.plan import Need, Plan, planned
from camcli.cli.plan_cells import Look, look
from camcli.cli.plan_probe import grid_picks
from camcli.cli.setup import Setup
from camcli.kernel import backend

PROBES, LOOK = 4, 0.45  # speeds looked at; s for all of them, in plain Python
PER_CELL, PER_FINEST = 70, 14  # bytes of memory; of a refined grid the second for its finest cells
REFINED = 20 * costs.MB  # bytes of memory while the rows of a refined grid are written
REGION, RECURRENCE = 8_000, 1_500_000  # turns around each point of a period, and for chaos
SETTLING = 0.25  # s per speed: attractors are solved and tried
OPENING = 0.15  # s: the compiled entry of the cells, read from its cache
PIECE = 36  # bytes of a cell among the finished pieces
PICTURE, RANGE_PICTURE = 72_000, 79_000  # bytes
RUN, SPEED = 2_500, 2_500  # bytes of run.json, beside the scene, and for each speed
ATTRACTOR = 65  # bytes of a row
LIGHTER = 75 * costs.MB  # bytes of memory that the picture of a range takes less


def basins_planned(request: Request, setup: Setup, question: Question) -> bool:
    """Show the plan of basins if asked (True); raise SceneError for those that cannot fit."""
    window = question.window
    cells = window.count
    least = Need(
        path="basins.refine" if question.refine else "basins.cells",
        what=f"{window.nq} x {window.nv} cells, refined {question.refine} times",
        memory=float(_memory(question)),
        disk=float((18 + PIECE) * cells),
        cure="ask for fewer cells or levels",
    )
    return planned("basins", request, least, lambda: estimate(request, setup, question))


def estimate(request: Request, setup: Setup, question: Question) -> Plan:
    """Cost from a coarse grid of cells at some of the speeds."""
    speeds, picks = _speeds(setup)
    seen = [
        look(setup.system, rpm, setup.settings, question.window, LOOK / len(picks)) for rpm in picks
    ]
    each, shard = speeds / len(seen), shard_of(request)
    pace = costs.Pace.of([one for at in seen for one in at.seen])
    part = 1.0 if shard is None else 1.0 / shard.total
    turns = [_turns(setup, question, at, part) for at in seen]
    work = sum(n * pace_of(at) for n, at in zip(turns, seen, strict=True)) * each
    compiled, lanes = backend.may_compile(), costs.lanes_of(request.threads, 1 << 20)
    orbits = sum(_cells(question, at) for at in seen) * each * part
    rows = _rows(question, seen[0]) if speeds == 1 else 0.0
    picture = shard is None and not request.no_plot
    size = _size(question, rows, speeds, seen, picture) if shard is None else 0.0
    pieces = PIECE * orbits
    seconds = costs.START + (costs.KERNEL + OPENING) * compiled + SETTLING * speeds
    seconds += work / (costs.COMPILED * lanes if compiled else 1.0)
    seconds += costs.DRAWING * picture + 1e-6 * rows + costs.PIECE * pieces
    fixed = costs.PROCESS + costs.COMPILER * compiled + costs.PICTURE * picture
    return Plan(
        orbits=round(orbits),
        periods=round(sum(turns) * each),
        impacts=round(sum(n * at.impacts() for n, at in zip(turns, seen, strict=True)) * each),
        seconds=seconds * pace.slow,
        bytes=round(size),
        disk=round(size + pieces),
        memory=round(fixed + _memory(question) - LIGHTER * (picture and speeds > 1)),
        notes=_notes(request, setup, compiled),
    )


def _speeds(setup: Setup) -> tuple[int, list[float]]:
    """(number of speeds, those that are looked at)."""
    rpm = setup.scene.basins.rpm
    if rpm.start == rpm.stop:
        return 1, [rpm.start]
    return rpm.num, grid_picks(rpm, PROBES)


def pace_of(at: Look) -> float:
    """Seconds of a turn in plain Python, on the machine of all constants."""
    turns = sum(one.turns for one in at.seen)
    return sum(one.turn * one.turns for one in at.seen) / max(1, turns)


def _cells(question: Question, at: Look) -> float:
    """Cells that are followed, those of all levels."""
    window, share = question.window, 1.0 - at.below
    total = float(window.count) * share
    for level in range(question.refine):
        fine = window.halved(level)
        along = max(fine.nq, fine.nv)
        total += 4.0 * fine.count * share * at.at_boundary(along)
    return total


def _turns(setup: Setup, question: Question, at: Look, part: float) -> float:
    """Turns of all cells at one speed, of the search for attractors before, and of its trials."""
    follower = setup.system.follower
    if follower.restitution == 1.0 and follower.damping == 0.0:
        return _cells(question, at) * part + SCOUTS * SCOUTS * SCOUT_TURNS
    scouting = SCOUTS * SCOUTS * SCOUT_TURNS + REGION * at.periods
    scouting += RECURRENCE * (at.aperiodic > 0.0)
    if setup.scene.basins.boundary:
        starts = STARTS * (1 + 2 * (FINEST - COARSEST + 1)) * (1.0 - at.below)
        scouting += starts * at.turns(question.budget)
    if question.method == SIMPLE:
        return _cells(question, at) * part + scouting
    return _cells(question, at) * part * at.turns(question.budget) + scouting


def _rows(question: Question, at: Look) -> float:
    """Rows of basins.csv: each cut cell gives four in the place of one."""
    cut = _cells(question, at) - _cells(Question(question.window), at)
    return question.window.count + 0.75 * cut


def _size(question: Question, rows: float, speeds: int, seen: list[Look], picture: bool) -> float:
    """Bytes of the artefacts."""
    window = question.window
    text = sum(
        sum(len(repr(x)) for x in side.tolist()) / len(side)
        for side in (window.q_of(range(window.nq)), window.v_of(range(window.nv)))
    )
    ends = sum(len({cell.end for cell in at.cells}) + 1 for at in seen) / len(seen)
    drawn = (PICTURE if speeds == 1 else RANGE_PICTURE) * picture
    return drawn + (text + 4) * rows + costs.RECORD + RUN + (SPEED + ATTRACTOR * ends) * speeds


def _memory(question: Question) -> int:
    """Bytes the grid takes."""
    cells = question.window.count
    if not question.refine:
        return cells * PER_CELL
    return cells * PER_CELL + (cells << 2 * question.refine) * PER_FINEST + REFINED


def _notes(request: Request, setup: Setup, compiled: bool) -> tuple[str, ...]:
    section = setup.scene.basins
    notes = list(costs.compile_note(compiled, ("advance", "settle_cells")))
    shard = shard_of(request)
    if shard is not None:
        notes.append(f"shard {shard.number} of {shard.total}: pieces only, no tables, no picture")
    if section.boundary:
        starts = STARTS * (1 + 2 * (FINEST - COARSEST + 1))
        notes.append(f"the boundary's dimension is in it: {starts} further starts at each speed")
    if section.exponents:
        notes.append("exponents come on top: some milliseconds for each attractor")
    return tuple(notes)
