"""What `cam simulate` costs."""

from __future__ import annotations

from camcli.cli import plan_costs as costs
from camcli.cli.options import Request
from camcli.cli.plan import Need, Plan, planned
from camcli.cli.plan_probe import STEPS, glance
from camcli.cli.setup import Setup

ROW = 3.6e-6  # s per row of the trajectory: sampled, and written in text
ROW_TEXT, EVENT_TEXT = 102, 106  # bytes of a row
ROW_MEMORY = 280  # bytes of a row, and of an event, until they are written
DRAWN, DRAWING = 60 * costs.MB, 0.65  # bytes of memory and s of the picture
PICTURE = 215_000  # bytes


def simulate_planned(request: Request, setup: Setup) -> bool:
    """Show the plan of one orbit if asked (True); raise SceneError for one that cannot fit."""
    samples, record = setup.scene.simulate.samples, setup.settings.record
    least = Need(
        path="simulate.samples" if samples > record else "run.record",
        what=f"{record} recorded turns x {samples} samples",
        memory=float(samples * record * ROW_MEMORY),
        disk=float(samples * record * ROW_TEXT),
        cure="ask for fewer turns or samples",
    )
    return planned("simulate", request, least, lambda: estimate(request, setup))


def estimate(request: Request, setup: Setup) -> Plan:
    """Cost from a look at the first turns."""
    settings = setup.settings
    turns = settings.transient + settings.record
    seen = glance(setup.system, setup.scene.run.rpm, settings, turns, STEPS)
    pace, all_turns = costs.Pace.of([seen]), seen.turns if seen.ended else turns
    impacts = seen.impacts_of(turns)
    recorded = impacts - seen.impacts_of(settings.transient)
    record = max(0, all_turns - settings.transient)
    events = recorded * (1.0 + 2.0 * seen.chatter)
    rows = setup.scene.simulate.samples * record + 2.0 * recorded
    steps = (impacts / max(1, all_turns) + 3.0) * all_turns
    compiled = costs.compiles(0, 1, steps)
    picture = not request.no_plot
    seconds = costs.START + costs.KERNEL * compiled + ROW * (rows + events) + DRAWING * picture
    seconds += pace.kernel(all_turns, 1, compiled)
    size = costs.RECORD + ROW_TEXT * rows + EVENT_TEXT * events + PICTURE * picture
    fixed = costs.PROCESS + costs.COMPILER * compiled + DRAWN * picture
    return Plan(
        orbits=1,
        periods=all_turns,
        impacts=round(impacts),
        seconds=seconds * pace.slow,
        bytes=round(size),
        disk=round(size),
        memory=round(fixed + ROW_MEMORY * (rows + events)),
        notes=costs.compile_note(compiled),
    )
