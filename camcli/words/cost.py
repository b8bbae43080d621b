"""What a run cost and how exact it is, in one line."""

from collections.abc import Mapping
from typing import Any

from camcli.quantities import UM

BOUND = "bound for each event; a chaotic orbit multiplies it by its own stretching"


def plain(number: float, digits: int) -> str:
    """A number with so many digits that count, never with a power of ten where it is large."""
    rounded = float(f"{number:.{digits}g}")
    return f"{rounded:.0f}" if rounded >= 10.0**digits else f"{number:.{digits}g}"


def cost_line(costs: Mapping[str, Any], errors: Mapping[str, Any]) -> str:
    """How many impacts a run computed in what time, and how exact they are, in a line."""
    rate = plain(costs["impacts_per_s"] or 0.0, 3)
    took = f" in {costs['seconds']:.3g} s ({rate}/s, "
    if costs["pieces_from_disk"]:
        from_disk = costs["pieces_from_disk"]
        took = f", {from_disk} pieces from disk, the rest in {costs['seconds']:.3g} s ("
    per_impact = costs["gap_evaluations"] / max(1, costs["impacts"])
    contact = f"contact within {errors['contact_gap_m']:.1g} m"
    if table := errors.get("lift_table"):
        off = f"{table['rms'] * UM:.2g} um rms"
        contact += f" of the fitted cam, which is within {off} of its measured table"
    return (
        f"{costs['impacts']} impacts{took}{plain(per_impact, 2)} gap evaluations each); "
        f"error per event: {contact}, "
        f"accumulation within {errors['accumulation_phase_turns']:.1g} turn"
    )
