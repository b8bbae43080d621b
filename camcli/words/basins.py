"""What `cam basins` says of the starts it followed."""

from camcli.analysis.basins.study import Study
from camcli.words.after_rest import decided_notes
from camcli.words.statuses import trouble

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
