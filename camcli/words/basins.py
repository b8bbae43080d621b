"""What `cam basins` says of the starts it followed."""

from collections import Counter
from collections.abc import Sequence
from math import degrees

from camcli.analysis.basins.study import Basins, Study
from camcli.analysis.basins.window import Window
from camcli.errors import is_or_are, plural, shown
from camcli.quantities import Units
from camcli.system import System
from camcli.words.after_rest import decided_notes
from camcli.words.in_print import number_text, one_of, range_of, valued, with_error
from camcli.words.speeds import at_speed, number_range, run_speed
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
    holds_for = [end.holds_for for speed in found.speeds for _, end in speed.rests]
    notes += decided_notes(holds_for, "departure")
    cells = sum(speed.undecided for speed in found.speeds)
    if cells:
        total = sum(speed.cells for speed in found.speeds)
        notes.append(
            f"{cells} of {plural(total, 'cell')} {is_or_are(cells)} undecided: "
            f"{'it' if cells == 1 else 'they'} met no attractor within {plural(budget, 'turn')}; "
            "raise basins.budget, unless the motion has no attractor"
        )
    troubled: Counter[int] = Counter()  # cells by status
    for speed in found.speeds:
        troubled.update(speed.troubled)
    for code, cells in sorted(troubled.items()):
        notes += trouble(code, f" in {plural(cells, 'cell')}")
    return notes


def grid_title(speed: Basins, kind: str = "") -> str:
    """The title of the attractors of one speed; kind: of the cam."""
    return run_speed(speed.rpm, kind)


def grids_title(found: Study, key: str, kind: str = "") -> str:
    """The title of the attractors of several speeds, or values of another number.

    kind: of the cam.
    """
    title = plural(len(found.speeds), one_of(key))
    return title + at_speed([key], found.speeds[0].rpm, kind)


def fraction_text(fraction: float, error: float) -> str:
    """A fraction of the window and its standard error, in percent."""
    return f"{with_error(100.0 * fraction, 100.0 * error)} %"


def share_words(branch: int, label: str, share: float) -> str:
    """An attractor, by its number, and its share of the window."""
    return f"{branch}: {shown(label, LONGEST_LABEL)} {100.0 * share:.3g} %"


def grid_lines(speed: Basins, verbose: bool) -> list[str]:
    """What the grid of one speed says beside its attractors; verbose: the entropies too."""
    entropies = speed.entropies
    uncertainty = speed.uncertainty
    median, percentile_99, most = speed.turns
    lines = [
        f"cells {speed.cells}, computed {speed.computed} "
        f"({100.0 * speed.computed / speed.cells:.3g} %); turns per cell: median {median}, 99 % "
        f"{percentile_99}, most {most}"
    ]
    if verbose:
        lines.append(
            f"basin entropy {entropies['basin_entropy']:.4g}, boundary entropy "
            f"{entropies['boundary_entropy']:.4g} ({entropies['boundary_boxes']} of "
            f"{plural(int(entropies['boxes']), 'box')} of 5 x 5 cells)"
        )
    for saddle in speed.saddles or ():
        label = shown(saddle.orbit.label, LONGEST_LABEL)
        lines.append(
            f"saddle {label} on the boundary: {saddle.led} of {plural(saddle.tried, 'motion')} "
            f"there {is_or_are(saddle.led)} led to it"
        )
    if uncertainty is not None:
        lines.append(
            f"uncertainty exponent {uncertainty.exponent:.3f} +- {uncertainty.error:.3f}, "
            f"boundary dimension {uncertainty.dimension:.3f}"
        )
    return lines


# --- beside the pictures


def picture_title(what: str, speeds: Sequence[Basins], key: str, kind: str = "") -> str:
    """The title of a picture, with the range of what is varied; kind: of the cam."""
    values = [speed.value for speed in speeds]
    ends = range_of(min(values), max(values))
    return f"{what}, {valued(key, ends, speeds[0].rpm, kind)}"


def window_words(grids: Sequence[Basins], system: System) -> str:
    """The starts of a window, and of one speed the measures of its boundaries."""
    window = grids[0].window
    phase = number_text(round(degrees(system.strobe), 9))
    text = f"{window.nq} × {window.nv} starts (q, v) at θ = {phase} deg"
    if grids[0].level is not None:
        computed = sum(grid.computed for grid in grids)
        share = 100.0 * computed / sum(grid.cells for grid in grids)
        text += f", {share:.3g} % of the cells computed (boundaries refined)"
    if len(grids) > 1:
        return text
    (basins,) = grids
    entropies = basins.entropies
    text += f"; basin entropy {entropies['basin_entropy']:.3g}"
    if entropies["boundary_boxes"]:
        text += f", boundary entropy {entropies['boundary_entropy']:.3g}"
    if basins.uncertainty is not None:
        uncertainty = basins.uncertainty
        text += f", boundary dimension {uncertainty.dimension:.3f} ± {uncertainty.error:.3f}"
    return text


def windows_words(study: Study, window: Window, units: Units, key: str) -> str:
    """The starts of each window where something is varied."""
    low, high = (q * units.per_m for q in window.q)
    return (
        f"{plural(len(study.speeds), one_of(key))}, {window.nq} × {window.nv} starts each, "
        f"q from {number_range(low, high, 6)} {units.length}, "
        f"v from {number_range(*window.v, 6)} m/s"
    ).replace("-", "−")


def saddle_words(label: str, led: int, tried: int) -> str:
    """A saddle on a boundary; where not all motions on it were led there, how many were."""
    if led == tried:
        return f"saddle {label}"
    return f"saddle {label}: {led} of {plural(tried, 'motion')} led to it"


def further_words(count: int) -> str:
    """The attractors that the list leaves out."""
    return f"{plural(count, 'further attractor')}, in repeated colours"
