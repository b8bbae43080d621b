"""cam simulate"""

from __future__ import annotations

from functools import partial

from camcli.analysis.simulate import Simulation, simulate
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request
from camcli.cli.plan_simulate import simulate_planned
from camcli.cli.report import finish, table, warn_of_height
from camcli.cli.setup import Setup, one_speed, set_up, timed
from camcli.errors import Status
from camcli.output.run_folder import RunFolder, run_folder
from camcli.output.tables import events_csv, trajectory_csv

NAME = "simulate"
SHOWN = 12  # events in the table on stdout


def run(request: Request) -> int:
    """Simulate one orbit and write its artefacts; returns the exit code."""
    setup = set_up(request, one_speed(request))
    if request.extra.get("profile_only"):
        from camcli.cli.cam_profile import run_profile

        return run_profile(request, setup)
    rpm, samples = setup.scene.run.rpm, setup.scene.simulate.samples
    if simulate_planned(request, setup):
        return DONE
    with run_folder(request.folder(NAME)) as store:
        with timed(request) as watch:
            result = simulate(setup.system, rpm, setup.settings, samples)
        seconds = watch.seconds
        store.write_text("trajectory.csv", trajectory_csv(result))
        store.write_text("events.csv", events_csv(result))
        _draw(request, setup, store, result)
        if not request.json:
            _show(result)
        finish(NAME, request, setup, store, result.cost, seconds, _summary(result))
        if not request.quiet:
            highest = max((row[2] for row in result.trajectory), default=0.0)
            warn_of_height([(rpm, highest)], setup.system.cam.top)
        if result.status != Status.OK:
            status = Status(result.status)
            note(f"{status.text}: {status.cause}; {status.cure}")
            return NUMERICS
        return DONE


def _draw(request: Request, setup: Setup, store: RunFolder, result: Simulation) -> None:
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.simulate import draw_simulation

    figure = draw_simulation(result, setup.scene.simulate.plot_turns)
    store.write("simulate.png", partial(write_png, figure))


def _summary(result: Simulation) -> dict:
    return {
        "rpm": result.rpm,
        "label": result.label,
        "status": Status(result.status).text,
        "periods": result.periods,
        "events": len(result.events),
        "corners_deg": result.corners_deg,
    }


def _show(result: Simulation) -> None:
    rows = [
        [name, str(period), f"{theta:.10f}", f"{u:.6g}", f"{after:.6g}"]
        for _, period, theta, name, _, u, after in result.events[-SHOWN:]
    ]
    title = f"{result.rpm:.10g} rpm: {result.label}, {len(result.events)} events recorded"
    if len(result.events) > SHOWN:
        title += f", the last {SHOWN}"
    table(title, ["event", "period", "theta (deg)", "u- (m/s)", "u+ (m/s)"], rows)
