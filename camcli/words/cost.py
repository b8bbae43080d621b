"""What a run cost and how exact it is, in one line."""

from collections.abc import Mapping
from typing import Any

from camcli.errors import plural
from camcli.quantities import UM
from camcli.words.in_print import written_out

BOUND = "bound for each event; a chaotic orbit multiplies it by its own stretching"


def cost_line(costs: Mapping[str, Any], errors: Mapping[str, Any]) -> str:
    """One line: how many impacts a run computed, in what time, and how exact they are.

    costs, errors: as in run.json. A run that found pieces on disk has no rate of its own.
    """
    seconds = f"{costs['seconds']:.3g} s"
    rate = written_out(costs["impacts_per_s"] or 0.0, 3)
    took = f" in {seconds} ({rate}/s, "
    if costs["pieces_from_disk"]:
        took = (
            f", {plural(costs['pieces_from_disk'], 'piece')} from disk, this run took {seconds} ("
        )
    per_impact = costs["gap_evaluations"] / max(1, costs["impacts"])
    contact = f"contact within {errors['contact_gap_m']:.1g} m"
    table = errors.get("lift_table")
    if table is not None:
        off = f"{table['rms'] * UM:.2g} um rms"
        contact += f" of the fitted cam, which is within {off} of its measured table"
    impacts = plural(costs["impacts"], "impact")
    evaluations = f"{written_out(per_impact, 2)} gap evaluations"
    if evaluations.startswith("1 "):
        evaluations = "1 gap evaluation"
    return (
        f"{impacts}{took}{evaluations} each); "
        f"error of each event: {contact}, "
        f"end of a chatter within {errors['accumulation_phase_turns']:.1g} turn"
    )
