"""What `cam detach` and `cam orbits` cost: some short runs, and their own equations on top."""

from __future__ import annotations

from collections.abc import Sequence

from camcli.analysis.integrate import Settings
from camcli.cli import plan_costs as costs
from camcli.cli.options import Request
from camcli.cli.plan import Need, Plan, planned
from camcli.cli.plan_probe import STEPS, glance, picked
from camcli.cli.setup import Setup
from camcli.kernel import backend
from camcli.kernel.backend import LITTLE_WORK

OWN = {"detach": (0.5, 50_000), "orbits": (0.7, 0)}  # s and impacts of solving, chapter's machine
ROW = 300  # bytes of artefacts for each run, and of memory
EVENT = 45  # bytes of memory per recorded impact
PICTURE = 400_000  # bytes


def starts_planned(
    name: str, request: Request, setup: Setup, rpms: Sequence[float], settings: Settings, path: str
) -> bool:
    """Show the plan of one run at each speed if asked (True); refuse what cannot fit.

    path: the key that asks for so many. Raises SceneError.
    """
    least = Need(
        path=path,
        what=f"{len(rpms)} runs",
        memory=float(ROW * len(rpms)),
        disk=float(ROW * len(rpms)),
        cure="ask for fewer",
    )
    return planned(name, request, least, lambda: _estimate(name, request, setup, rpms, settings))


def _estimate(name: str, request: Request, setup: Setup, rpms, settings: Settings) -> Plan:
    turns = settings.transient + settings.record
    picks = picked(rpms)
    seen = [glance(setup.system, rpm, settings, turns, STEPS // len(picks)) for rpm in picks]
    pace, each = costs.Pace.of(seen), len(rpms) / len(seen)
    impacts = sum(one.impacts_of(turns) for one in seen) * each
    recorded = impacts - sum(one.impacts_of(settings.transient) for one in seen) * each
    own, more = OWN[name]
    compiles = name == "detach" or backend.must_compile()  # orbits are solved in plain Python
    compiled = compiles and costs.compiles(len(rpms) * turns + more, LITTLE_WORK, 0.0)
    picture = not request.no_plot
    turning = sum(one.turn for one in seen) * turns * each
    seconds = costs.START + costs.KERNEL * compiled + costs.DRAWING * picture + own
    seconds += turning / (costs.COMPILED if compiled else 1.0)
    size = costs.RECORD + ROW * len(rpms) + PICTURE * picture
    fixed = costs.PROCESS + costs.COMPILER * compiled + costs.PICTURE * picture
    return Plan(
        orbits=len(rpms),
        periods=len(rpms) * turns,
        impacts=round(impacts) + more,
        seconds=seconds * pace.slow,
        bytes=round(size),
        disk=round(size),
        memory=round(fixed + EVENT * recorded),
        notes=costs.compile_note(compiled),
    )
