"""Picture of basins: the window of starts coloured by attractor, the attractors drawn on it."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from camcli.analysis.basins.attractor import CONTACT, Attractor
from camcli.analysis.basins.mapping import BELOW_CODE, SIMPLE, UNDECIDED_CODE, Basins, Question
from camcli.analysis.basins.study import Speed, Study
from camcli.analysis.sweep import status_name
from camcli.kernel.cam_table import ROW, START0
from camcli.plots import style
from camcli.system import System, omega_of

LEFT, RIGHT, BOTTOM = 125, 45, 95  # px, margins
HIGH = 900  # px, of the window
HEAD = 130  # px, above the legend
MOST_NAMED = 12  # attractors in the legend

UNDECIDED, TROUBLE, BELOW = style.UNDECIDED, style.TROUBLE, style.CAM_BODY
SHAPES = ("o", "s", "^", "D", "v", "P", "X")
DOTS = 3000  # states of an aperiodic attractor drawn
CHARS = 60  # of a label in the legend


def area_colours(labels: Sequence[str]) -> list[str]:
    """Colours of the basins of attractors by their labels, apart where two want the same."""
    return style.apart([_wanted(label) for label in labels])


def _wanted(label: str) -> str:
    colour = style.label_colour(label)
    return style.APERIODIC_AREA if colour == style.APERIODIC else colour


def draw_basins(study: Study, question: Question, system: System) -> Figure:
    """Picture of the basins of one speed, or of fractions and attractors over a range of them."""
    if study.grid is None:
        from camcli.plots.basins_range import draw_range

        return draw_range(study, question)
    return _draw_window(study.speeds[0], study.grid, system)


@style.look()
def _draw_window(speed: Speed, grid: Basins, system: System) -> Figure:
    """The basins of one speed."""
    entries = _entries(speed)
    top = HEAD + style.LINE * (len(entries) + 1)
    wide = style.WIDTH - LEFT - RIGHT
    figure = style.page(top + HIGH + BOTTOM)
    _heading(figure, speed, grid, system)
    axes = style.place(figure, LEFT, top, wide, HIGH)
    window = grid.window
    axes.imshow(
        _pixels(grid, speed, wide, HIGH),
        extent=(*window.q, *window.v),
        origin="lower",
        aspect="auto",
        interpolation="none",
    )
    outside = _draw_attractors(axes, speed, grid)
    cam = _draw_cam(axes, grid, system)
    axes.set(xlim=window.q, ylim=window.v)
    axes.set_xlabel("position $q$ of the start (m)")
    axes.set_ylabel("velocity $v$ of the start (m/s)")
    _legend(figure, entries, _colours(speed), outside, cam, bool((grid.codes == BELOW_CODE).any()))
    return figure


def _heading(figure: Figure, speed: Speed, grid: Basins, system: System) -> None:
    title = f"Basins of attraction, {style.number(speed.rpm)} rpm"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    phase = style.number(round(degrees(system.strobe), 9))
    window = grid.window
    how = "simple cell mapping" if grid.method == SIMPLE else "orbit mapping"
    text = f"{window.nq} × {window.nv} starts at θ = {phase} deg, {how}"
    if grid.level is not None:
        share = 100.0 * speed.computed / speed.cells
        text += f", {share:.3g} % of the cells computed (boundaries refined)"
    entropies = speed.entropies
    lines = [text, f"basin entropy {entropies['basin_entropy']:.3g}"]
    if entropies["boundary_boxes"]:
        lines[1] += f", boundary entropy {entropies['boundary_entropy']:.3g}"
    if speed.uncertainty is not None:
        doubt = speed.uncertainty
        lines[1] += f", boundary dimension {doubt.dimension:.3f} ± {doubt.error:.3f}"
    style.write(figure, 20, 54, "\n".join(lines), linespacing=1.25)


def _entries(speed: Speed) -> list[tuple[int, str]]:
    """(code, words) of the legend: attractors, then what belongs to none."""
    found = []
    for k, attractor in enumerate(speed.attractors[:MOST_NAMED]):
        name = style.motion(attractor.label, CHARS)
        found.append((k + 1, f"{name}   {percent(speed.fractions[k + 1])}"))
    rest = len(speed.attractors) - MOST_NAMED
    if rest > 0:
        share = sum(speed.fractions[k + 1][0] for k in range(MOST_NAMED, len(speed.attractors)))
        found.append((MOST_NAMED + 1, f"and {rest} more, together {100.0 * share:.3g} %"))
    for code, share in speed.fractions.items():
        if code <= 0:
            name = "undecided" if code == UNDECIDED_CODE else status_name(-code)
            found.append((code, f"{name}   {percent(share)}"))
    return found


def percent(share: tuple[float, float]) -> str:
    """A fraction and its standard error, to the digits the error leaves."""
    value, error = 100.0 * share[0], 100.0 * share[1]
    if error == 0.0:
        return f"{value:g} %"
    digits = 1 + next(n for n in range(1, 8) if error >= 0.95 * 10.0**-n or n == 7)
    return f"({value:.{digits}f} ± {error:.{digits}f}) %"


def _colours(speed: Speed) -> dict[int, tuple[float, float, float]]:
    colours = {UNDECIDED_CODE: to_rgb(UNDECIDED), BELOW_CODE: to_rgb(BELOW)}
    areas = area_colours([attractor.label for attractor in speed.attractors])
    return colours | {k: to_rgb(area) for k, area in enumerate(areas, 1)}


def _pixels(grid: Basins, speed: Speed, wide: int, high: int) -> np.ndarray:
    """(rows, columns, 3) colours; cells smaller than a pixel are averaged."""
    colours = _colours(speed)
    columns = _bins(grid.codes.shape[1], wide)
    rows = _bins(grid.codes.shape[0], high)
    size = np.diff(np.append(rows, grid.codes.shape[0]))[:, None] * np.diff(
        np.append(columns, grid.codes.shape[1])
    )
    picture = np.zeros((len(rows), len(columns), 3))
    for code in np.unique(grid.codes).tolist():
        mask = (grid.codes == code).astype(np.uint16)
        share = np.add.reduceat(np.add.reduceat(mask, rows, axis=0), columns, axis=1) / size
        picture += share[:, :, None] * np.array(colours.get(code, to_rgb(TROUBLE)))
    return np.rint(255.0 * picture).astype(np.uint8)


def _bins(cells: int, pixels: int) -> np.ndarray:
    """First cell of every pixel; a pixel per cell where there are fewer cells."""
    count = min(cells, pixels)
    return np.arange(count) * cells // count


def _draw_attractors(axes: Axes, speed: Speed, grid: Basins) -> set[int]:
    """Section points of every attractor; returns the numbers of those outside the window."""
    omega, window = omega_of(speed.rpm), grid.window
    outside = set()
    for k, attractor in enumerate(speed.attractors):
        q, w = attractor.shown().T
        v = w * omega
        inside = (window.q[0] <= q) & (q <= window.q[1])
        inside &= (window.v[0] <= v) & (v <= window.v[1])
        if not inside.any():
            outside.add(k + 1)
        _draw_points(axes, attractor, k + 1, q, v)
    return outside


def _draw_points(axes: Axes, attractor: Attractor, number: int, q, v) -> None:
    if attractor.periodic:
        axes.plot(q, v, **_marker(number), zorder=5, clip_on=True)
        return
    step = max(1, len(q) // DOTS)
    dots = {"marker": ".", "markersize": 1.2, "markeredgewidth": 0.0, "linestyle": ""}
    axes.plot(q[::step], v[::step], color="black", zorder=4, **dots)


def _marker(number: int) -> dict:
    shape = SHAPES[(number - 1) % len(SHAPES)]
    return {
        "marker": shape, "markersize": 6.0, "markerfacecolor": "white",
        "markeredgecolor": "black", "markeredgewidth": 1.1, "linestyle": "",
    }  # fmt: skip


def _draw_cam(axes: Axes, grid: Basins, system: System) -> bool:
    """The line q = c at the strobe; True where it lies in the window."""
    c = system.cam.rows[system.cam.strobe * ROW + START0]
    low, high = grid.window.q
    if not low <= c <= high:
        return False
    axes.axvspan(low, c, color=BELOW, linewidth=0.0, zorder=2)  # over cells that the cam cuts
    axes.axvline(c, color="black", linewidth=1.6, zorder=3, clip_on=False)
    return True


def _legend(figure: Figure, entries, colours, outside: set[int], cam: bool, below: bool) -> None:
    """Areas with the markers of their attractors and their fractions; the cam's line."""
    handles, names = [], []
    for code, words in entries:
        area = Patch(facecolor=colours.get(code, TROUBLE), edgecolor="black", linewidth=0.5)
        periodic = code > 0 and words.startswith(("P", CONTACT))
        marker = (Line2D([], [], **_marker(code)),) if periodic and code not in outside else ()
        handles.append((area, *marker))
        names.append(words + (", attractor outside the window" if code in outside else ""))
    if cam:
        handles.append(Line2D([], [], color="black", linewidth=1.6))
        names.append("cam, $q = c$" + ("; grey: below it" if below else ""))
    top = 1.0 - (HEAD - 8) / round(figure.get_figheight() * style.DPI)
    figure.legend(
        handles, names, loc="upper left", bbox_to_anchor=(20 / style.WIDTH, top),
        borderaxespad=0.0, borderpad=0.0, handletextpad=0.6, labelspacing=0.45, handleheight=1.0,
    )  # fmt: skip
