"""What `cam classify` costs."""

from __future__ import annotations

from math import ceil

from camcli.analysis.classify import LONGER
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.cli import plan_costs as costs
from camcli.cli.options import Request
from camcli.cli.plan import Need, Plan, planned
from camcli.cli.plan_probe import STEPS, Glance, glance, grid_picks
from camcli.cli.setup import Setup
from camcli.kernel.backend import LITTLE_WORK

NAMING, NAMING_PLAIN = 4e-3, 0.05  # s per start: Newton's method, multipliers and exponents
KEPT = 45  # bytes of memory per event of a record, all of which are kept until the end
SOLVER = 35 * costs.MB  # bytes of memory
ROW, ENTRY = 50, 740  # bytes of a motion in classify.csv and in run.json
PICTURE = 85_000  # bytes
CERTAIN = 0.6  # share of the impacts' phases that do not come again, of an aperiodic motion


def classify_planned(request: Request, setup: Setup) -> bool:
    """Show the plan if asked (True); raise SceneError for motions that cannot fit."""
    section, record = setup.scene.classify, _record(setup)
    starts = section.starts + 1
    least = Need(
        path="run.record" if record > section.rpm.num else "classify.rpm.num",
        what=f"{section.rpm.num} speeds x {starts} starts x {record} recorded turns",
        memory=float(KEPT * section.rpm.num * record),
        disk=float((ROW + ENTRY) * section.rpm.num),
        cure="ask for fewer speeds or recorded turns",
    )
    return planned("classify", request, least, lambda: estimate(request, setup))


def estimate(request: Request, setup: Setup) -> Plan:
    """Cost from a look at some of the speeds; every start is taken to be like the scene's."""
    section, settings = setup.scene.classify, setup.settings
    speeds = grid_picks(section.rpm)
    runs, record = settings.transient, _record(setup)
    seen = [
        glance(setup.system, rpm, settings, runs + record, STEPS // len(speeds)) for rpm in speeds
    ]
    pace, starts = costs.Pace.of(seen), section.rpm.num * (section.starts + 1)
    periods = impacts = events = turning = 0.0
    for one in seen:
        again = 0 if _aperiodic(one) else runs + 2 * LONGEST_PERIOD
        periods += (runs + record) * (section.starts + 1) + again
        impacts += one.impacts_of(runs + record) * (section.starts + 1) + one.impacts_of(again)
        events += one.impacts_of(runs + record) - one.impacts_of(runs)
        turning += one.turn * ((runs + record) * (section.starts + 1) + again)
    each = section.rpm.num / len(seen)
    turns = section.rpm.num * (section.starts + 1) * (runs + settings.record)
    compiled = costs.compiles(turns, LITTLE_WORK, 0.0)
    lanes = costs.lanes_of(request.threads, section.rpm.num)
    picture = not request.no_plot
    seconds = costs.START + costs.KERNEL * compiled + costs.DRAWING * picture
    seconds += starts * (NAMING if compiled else NAMING_PLAIN)
    seconds += turning * each / (costs.COMPILED * lanes if compiled else 1.0)
    size = costs.RECORD + (ROW + ENTRY) * section.rpm.num + PICTURE * picture
    fixed = costs.PROCESS + SOLVER + costs.COMPILER * compiled + costs.PICTURE * picture
    return Plan(
        orbits=starts,
        periods=round(periods * each),
        impacts=round(impacts * each),
        seconds=seconds * pace.slow,
        bytes=round(size),
        disk=round(size),
        memory=round(fixed + KEPT * events * each),
        notes=_notes(setup, compiled),
    )


def _record(setup: Setup) -> int:
    return max(setup.settings.record, 2 * LONGEST_PERIOD + 2)


def _aperiodic(one: Glance) -> bool:
    """Whether the last impacts that were seen hardly come again."""
    return bool(one.rows) and len({round(row[0], 6) for row in one.rows}) > CERTAIN * len(one.rows)


def _notes(setup: Setup, compiled: bool) -> tuple[str, ...]:
    section, notes = setup.scene.classify, list(costs.compile_note(compiled))
    notes.append(
        f"where neither a period nor chaos is certain, {LONGER} more records and some seconds of "
        "search come on top"
    )
    if section.explain:
        changes = ceil(section.rpm.num - 1)
        notes.append(f"changes explained come on top: up to {changes} searches of 5 to 15 s each")
    return tuple(notes)
