"""What `cam basins` says of the starts it followed."""

from camcli.analysis.basins.study import Basins, Study
from camcli.errors import shown
from camcli.words.after_rest import decided_notes
from camcli.words.speeds import at_speed
from camcli.words.statuses import trouble

LONGEST_LABEL = 30  # characters

CRITERION = (
    "a cell belongs to a periodic attractor when one whole period leads from ellipse to "
    "ellipse about its section points, with the attractor's impacts turn by turn, and the form of "
    "the ellipses shrinks by the factor given; to an aperiodic one when as many turns in a row as "
    "given lie in the boxes it visits; undecided when neither happens within the budget"
)


def basins_notes(found: Study, budget: int) -> list[str]:
    """What stayed undecided, and a sentence for each kind of trouble."""
    notes = []
    if not any(speed.computed for speed in found.speeds):
        notes.append("no start of this window lies above the cam: raise basins.q")
    ends = (end.holds_for for speed in found.speeds for _, end in speed.rests)
    notes += decided_notes(ends, "departures")
    if cells := sum(speed.undecided for speed in found.speeds):
        total = sum(speed.cells for speed in found.speeds)
        notes.append(
            f"undecided: {cells} of {total} cells met no attractor within {budget} turns; "
            "raise basins.budget, or the motion is a long transient or has no attractor"
        )
    for code in sorted({code for speed in found.speeds for code in speed.troubled}):
        cells = sum(speed.troubled.get(code, 0) for speed in found.speeds)
        notes += trouble(code, f" in {cells} cells")
    return notes


def grid_title(speed: Basins) -> str:
    """The title of the attractors of one speed."""
    return f"{speed.rpm:.10g} rpm, orbit mapping"


def grids_title(found: Study, key: str) -> str:
    """The title of the attractors of several speeds, or values of another number."""
    title = f"{len(found.speeds)} {'speeds' if key == 'rpm' else 'values'}"
    return title + at_speed([key], found.speeds[0].rpm)


def share_words(branch: int, label: str, share: float) -> str:
    """An attractor, by its number, and its share of the window."""
    return f"{branch}: {shown(label, LONGEST_LABEL)} {100.0 * share:.3g} %"


def grid_lines(speed: Basins, verbose: bool) -> list[str]:
    """What the grid of one speed says beside its attractors; verbose: the entropies too."""
    entropies, doubt = speed.entropies, speed.uncertainty
    median, most99, most = speed.turns
    lines = [
        f"cells {speed.cells}, computed {speed.computed} "
        f"({100.0 * speed.computed / speed.cells:.3g} %); turns per cell: median {median}, 99 % "
        f"{most99}, most {most}"
    ]
    if verbose:
        lines.append(
            f"basin entropy {entropies['basin_entropy']:.4g}, boundary entropy "
            f"{entropies['boundary_entropy']:.4g} ({entropies['boundary_boxes']} of "
            f"{entropies['boxes']} boxes of 5 x 5 cells)"
        )
    lines += [
        f"saddle {shown(s.orbit.label, LONGEST_LABEL)} on the boundary: {s.led} of {s.tried} "
        "motions there are led to it"
        for s in speed.saddles or ()
    ]
    if doubt is not None:
        lines.append(
            f"uncertainty exponent {doubt.exponent:.3f} +- {doubt.error:.3f}, "
            f"boundary dimension {doubt.dimension:.3f}"
        )
    return lines
