"""What `cam sweep` costs."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import FIXED
from camcli.cli import plan_costs as costs
from camcli.cli.long_run import shard_of
from camcli.cli.options import Request
from camcli.cli.plan import Need, Plan, planned
from camcli.cli.plan_probe import STEPS, Glance, glance, grid_picks
from camcli.cli.setup import Setup
from camcli.kernel.backend import LITTLE_WORK
from camcli.parallel.threads import AHEAD

PER_SPEED = 500  # bytes of memory: what is known of each, and where its piece is
WAITING = 390  # bytes of memory per row of a speed whose turn has not come
WRITTEN = 900  # and of the one that is written
EXPONENT = 6e-3  # s per speed


@dataclass(frozen=True)
class _Work:
    """Speeds of this run (all, or a shard's), and how many at a time."""

    speeds: int
    lanes: int


@dataclass(frozen=True)
class _Rows:
    """Of one speed, in the mean: impacts in all, recorded ones, bytes as text and as pieces."""

    impacts: float
    recorded: float
    text: float
    binary: float
    pieces: float
    distinct: float


def sweep_planned(request: Request, setup: Setup) -> bool:
    """Show the plan of a sweep if asked (True); raise SceneError for one that cannot fit."""
    section, record = setup.scene.sweep, setup.settings.record
    work = _work(request, setup)
    wide = 32 * len(section.sections)  # bytes of a turn with one impact
    least = Need(
        path="run.record" if record > section.rpm.num else "sweep.rpm.num",
        what=f"{section.rpm.num} speeds x {record} recorded turns",
        memory=PER_SPEED * section.rpm.num + wide * record * min(work.speeds, work.lanes),
        disk=float(wide * record * work.speeds * (2 if section.tables != "none" else 1)),
        cure="ask for fewer speeds or recorded turns",
    )
    return planned("sweep", request, least, lambda: estimate(request, setup))


def estimate(request: Request, setup: Setup) -> Plan:
    """Cost from a look at some of the speeds."""
    section, settings = setup.scene.sweep, setup.settings
    work, turns = _work(request, setup), settings.transient + settings.record
    speeds = grid_picks(section.rpm)
    seen = [glance(setup.system, rpm, settings, turns, STEPS // len(speeds)) for rpm in speeds]
    rows, pace = _rows(seen, settings, section.sections), costs.Pace.of(seen)
    steps = turns * max(sum(one.impacts) / max(1, one.turns) + 3.0 for one in seen)
    compiled = costs.compiles(section.rpm.num * turns, LITTLE_WORK, steps)
    whole = shard_of(request) is None
    tables = _tables(section.tables, rows) * work.speeds if whole else 0.0
    points = (rows.recorded + settings.record) * work.speeds
    picture = _picture(rows.distinct * work.speeds) if whole and not request.no_plot else 0.0
    pieces = (150 + rows.pieces) * work.speeds
    seconds = costs.START + pace.kernel(work.speeds * turns, work.lanes, compiled)
    new = rows.distinct / rows.recorded if rows.recorded else 1.0
    text = costs.AGAIN + new * (costs.TEXT - costs.AGAIN)
    seconds += costs.KERNEL * compiled + costs.PIECE * pieces + text * tables
    seconds += (costs.DRAWING + costs.POINT * points) * bool(picture)
    seconds += EXPONENT * work.speeds / work.lanes * section.lyapunov
    own = costs.RECORD + (60 * work.speeds) if whole else 0.0
    artefacts = tables + picture + own
    return Plan(
        orbits=work.speeds,
        periods=round(sum(_turns(one, turns) for one in seen) / len(seen) * work.speeds),
        impacts=round(rows.impacts * work.speeds),
        seconds=seconds * pace.slow,
        bytes=round(artefacts),
        disk=round(artefacts + pieces),
        memory=_memory(work, rows, settings, compiled, bool(picture)),
        notes=_notes(request, setup, compiled),
    )


def _work(request: Request, setup: Setup) -> _Work:
    section, shard = setup.scene.sweep, shard_of(request)
    count = section.rpm.num if shard is None else ceil(section.rpm.num / shard.total)
    lanes = costs.lanes_of(request.threads, count) if section.direction == FIXED else 1
    return _Work(count, lanes)


def _turns(one: Glance, turns: int) -> int:
    """Turns of the whole orbit."""
    return one.turns if one.ended else turns


def _rows(seen: list[Glance], settings: Settings, sections) -> _Rows:
    """What a speed leaves behind."""
    count, record = len(seen), settings.record
    turns = settings.transient + record
    impacts = [one.impacts_of(turns) for one in seen]
    recorded = [
        max(0.0, n - one.impacts_of(settings.transient))
        for n, one in zip(impacts, seen, strict=True)
    ]
    strobes = [min(record, max(0, _turns(one, turns) - settings.transient)) for one in seen]
    wide, text, distinct = costs.digits(record) + 1, 0.0, 0.0
    for one, n, turn in zip(seen, recorded, strobes, strict=True):
        if "impacts" in sections:
            text += n * (wide + len(repr(one.rpm)) + _mean(one.rows) + 1)
        if "strobe" in sections:
            state = _mean([(q, w * one.rpm * 0.1047) for q, w in one.states[-50:]])
            text += turn * (wide + len(repr(one.rpm)) + state + 5)
        if one.rows:
            distinct += n * len(set(one.rows)) / len(one.rows)
    kept = sum(recorded) * ("impacts" in sections), sum(strobes) * ("strobe" in sections)
    return _Rows(
        impacts=sum(impacts) / count,
        recorded=kept[0] / count,
        text=text / count,
        binary=(40 * kept[0] + 48 * kept[1]) / count,
        pieces=32 * sum(kept) / count,
        distinct=distinct / count,
    )


def _mean(rows) -> float:
    """Characters of a row of numbers with its commas, in the mean."""
    if not rows:
        return 0.0
    return sum(len(repr(x)) + 1 for row in rows for x in row) / len(rows)


def _tables(form: str, rows: _Rows) -> float:
    return {"csv": rows.text, "npz": rows.binary, "none": 0.0}[form]


def _picture(distinct: float) -> float:
    """Bytes of a picture of so many different points: shades compress badly."""
    return 140_000.0 + min(350_000.0, 3.0 * distinct)


def _memory(work: _Work, rows: _Rows, settings: Settings, compiled: bool, picture: bool) -> int:
    waiting = min(work.speeds, AHEAD * work.lanes) if work.lanes > 1 else 1
    each = (rows.recorded + settings.record) * (WAITING * waiting + WRITTEN)
    fixed = costs.PROCESS + costs.COMPILER * compiled + costs.PICTURE * picture
    return round(fixed + each + PER_SPEED * work.speeds)


def _notes(request: Request, setup: Setup, compiled: bool) -> tuple[str, ...]:
    section, notes = setup.scene.sweep, list(costs.compile_note(compiled))
    shard = shard_of(request)
    if shard is not None:
        notes.append(f"shard {shard.number} of {shard.total}: pieces only, no tables, no picture")
    if section.explain:
        changes = section.rpm.num - 1
        notes.append(f"changes explained come on top: up to {changes} searches of 5 to 15 s each")
    if section.lyapunov:
        notes.append("exponents are in the seconds, roughly: some milliseconds a speed")
    return tuple(notes)
