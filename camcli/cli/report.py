"""The end of every run: artefact list, one line of cost and error, run.json."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from camcli.analysis.integrate import Cost
from camcli.cli.exit_codes import note
from camcli.cli.lift_words import bound_line, table_record
from camcli.cli.options import Request
from camcli.cli.setup import Setup
from camcli.output.run_folder import RunFolder
from camcli.output.run_record import cost_record, error_record, run_record, to_text
from camcli.scene import resolved, scene_hash

FILE_WIDTH = 140  # columns of a table that no person watches
ABSURD_HEIGHT = 1000.0  # times the cam's lift


def finish(
    command: str,
    request: Request,
    setup: Setup,
    store: RunFolder,
    cost: Cost,
    seconds: float,
    result: Mapping[str, Any],
    moved: bool = True,
    from_disk: int = 0,
) -> None:
    """Write run.json and print the closing lines, or the record itself with --json.

    `moved`: whether anything was simulated, so that impacts and their errors mean something;
    `from_disk`: pieces that another run had computed, so that the time is not that of all impacts.
    """
    costs = cost_record(cost, seconds, from_disk)
    errors = error_record(setup.settings.chatter_tolerance, setup.system.cam.top)
    measured = table_record(setup)
    if measured:
        errors["lift_table"] = measured
    record = run_record(
        command,
        resolved(setup.scene),
        scene_hash(setup.scene),
        request.as_options(),
        costs,
        errors,
        result,
        store.hashes,
    )
    text = to_text(record)
    store.write_text("run.json", [text])
    store.commit()
    if request.json:
        print(text, end="")
        return
    print(f"{store.folder}/: {', '.join([*store.hashes])}")
    if moved:
        print(closing_line(costs, errors))
    if measured:
        print(bound_line(measured))


def closing_line(costs: Mapping[str, Any], errors: Mapping[str, Any]) -> str:
    """One line of cost and error."""
    took = f" in {costs['seconds']:.3g} s ({costs['impacts_per_s'] or 0.0:.3g}/s, "
    if costs["pieces_from_disk"]:
        from_disk = costs["pieces_from_disk"]
        took = f", {from_disk} pieces from disk, the rest in {costs['seconds']:.3g} s ("
    per_impact = costs["gap_evaluations"] / max(1, costs["impacts"])
    return (
        f"{costs['impacts']} impacts{took}{per_impact:.2g} gap evaluations each); "
        f"error per event: contact within {errors['contact_gap_m']:.1g} m, "
        f"accumulation within {errors['accumulation_phase_turns']:.1g} turn"
    )


def warn_of_height(heights: Iterable[tuple[float, float]], top: float) -> None:
    """Note speeds at which the follower flies absurdly high; heights are (rpm, largest q in m)."""
    absurd = [(rpm, q) for rpm, q in heights if q > ABSURD_HEIGHT * abs(top)]
    if absurd:
        rpm, q = max(absurd, key=lambda pair: pair[1])
        note(
            f"warning: at {rpm:.10g} rpm the follower rises to {q:.3g} m, {q / abs(top):.3g} times "
            "the cam's lift: a model of rigid bodies means little there"
        )


def table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """A table for people on stdout."""
    from rich.console import Console
    from rich.table import Table

    grid = Table(title=title, title_justify="left")
    for k, column in enumerate(columns):
        grid.add_column(column, justify="left" if k == 0 else "right", overflow="fold")
    for row in rows:
        grid.add_row(*row)
    person = Console().is_terminal
    Console(width=None if person else FILE_WIDTH).print(grid)
