"""What the page of `cam explore` says beside its pictures."""

from collections.abc import Iterable

from camcli.errors import plural
from camcli.quantities import Q, V, labelled

BASINS, MAP = "Basins of attraction", "Map of motions"
BASIN_AXES = [
    labelled("position q at the strobe", Q.unit),
    labelled("velocity v at the strobe", V.unit),
]
NO_MOTION = "no whole turn of any motion was recorded: there is no page to show"


def basin_shares(rpm: float, shares: Iterable[tuple[str, float]]) -> str:
    """How much of the window each attractor takes; shares: (label, fraction)."""
    parts = [f"{label} takes {100.0 * share:.3g} %" for label, share in shares]
    return f"At {rpm:.10g} rpm: {', '.join(parts)} of the starts."


def page_line(motions: int, speeds: int, bifurcations: int, written: bool) -> str:
    """What is on the page, and how to look at it."""
    shown = f"{plural(motions, 'motion')} at {plural(speeds, 'speed')}"
    solved = f"{plural(bifurcations, 'bifurcation')} of solved branches"
    return f"{shown}, {solved}" + ("; open explore.html in a browser" if written else "")
