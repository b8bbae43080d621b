"""Pictures of basins: the window of starts coloured by attractor; their fractions over speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from camcli.analysis.basins.study import BELOW_CODE, SIMPLE, UNDECIDED_CODE, Basins, Question, Study
from camcli.analysis.sweep import status_name
from camcli.plots import style
from camcli.plots.axes import legend
from camcli.plots.style import BOTTOM, LEFT, WIDE
from camcli.system import System, omega_of

HIGH = 900  # px, of the window
STACK, STATES, GAP = 560, 420, 40  # px, of the panels over speed
HEAD, RANGE_HEAD = 130, 100  # px, above the legend
MOST_NAMED = 12  # attractors in the legend
CHARS, RANGE_CHARS = 60, 24  # of a label in the legend
LABELS = 3  # of a branch of attractors in the legend
UNDECIDED, TROUBLE, BELOW = style.UNDECIDED, style.TROUBLE, style.CAM_BODY
SHAPES = ("o", "s", "^", "D", "v", "P", "X")
DOTS, RANGE_DOTS = 3000, 150  # states of an aperiodic attractor drawn


def draw_basins(study: Study, question: Question, system: System) -> Figure:
    """Picture of the basins of one speed, or of fractions and attractors over a range of them."""
    if study.grid is None:
        return _draw_range(study, question)
    return _draw_window(study.grid, system)


def area_colours(labels: Sequence[str]) -> list[str]:
    """Colours of the basins of attractors by their labels, apart where two want the same."""
    wanted = [style.label_colour(label) for label in labels]
    return style.apart([style.APERIODIC_AREA if c == style.APERIODIC else c for c in wanted])


# --- one speed


@style.look()
def _draw_window(basins: Basins, system: System) -> Figure:
    """The basins of one speed."""
    entries = _entries(basins)
    top = HEAD + style.LINE * (len(entries) + 1)
    title = f"Basins of attraction, {style.number(basins.rpm)} rpm"
    figure = style.page(top + HIGH + BOTTOM, title, _below_title(basins, system))
    window = basins.window
    axes = style.place(figure, LEFT, top, WIDE, HIGH)
    axes.imshow(
        _pixels(basins, WIDE, HIGH),
        extent=(*window.q, *window.v),
        origin="lower",
        aspect="auto",
        interpolation="none",
    )
    outside = _draw_attractors(axes, basins)
    cam_shown = _draw_cam(axes, basins, system)
    axes.set(xlim=window.q, ylim=window.v)
    axes.set_xlabel("position $q$ of the start (m)")
    axes.set_ylabel("velocity $v$ of the start (m/s)")
    handles: list[Any] = []
    names, colours = [], _colours(basins)
    for code, words in entries:
        area = Patch(facecolor=colours.get(code, TROUBLE), ec="black", lw=0.5)
        marked = 0 < code <= MOST_NAMED and basins.attractors[code - 1].periodic
        shape = (Line2D([], [], **_marker(code)),) if marked and code not in outside else ()
        handles.append((area, *shape))
        names.append(words + (", attractor outside the window" if code in outside else ""))
    if cam_shown:
        handles.append(Line2D([], [], color="black", linewidth=1.6))
        below = bool((basins.codes == BELOW_CODE).any())
        names.append("cam, $q = c$" + ("; grey: below it" if below else ""))
    legend(figure, HEAD - 8, handles, names)
    return figure


def _below_title(basins: Basins, system: System) -> str:
    window, phase = basins.window, style.number(round(system.strobe_deg, 9))
    how = "simple cell mapping" if basins.method == SIMPLE else "orbit mapping"
    text = f"{window.nq} × {window.nv} starts at θ = {phase} deg, {how}"
    if basins.level is not None:
        share = 100.0 * basins.computed / basins.cells
        text += f", {share:.3g} % of the cells computed (boundaries refined)"
    entropies = basins.entropies
    text += f"\nbasin entropy {entropies['basin_entropy']:.3g}"
    if entropies["boundary_boxes"]:
        text += f", boundary entropy {entropies['boundary_entropy']:.3g}"
    if basins.uncertainty is not None:
        doubt = basins.uncertainty
        text += f", boundary dimension {doubt.dimension:.3f} ± {doubt.error:.3f}"
    return text


def _entries(basins: Basins) -> list[tuple[int, str]]:
    """(code, words) of the legend: attractors, then what belongs to none."""
    found = []
    for k, attractor in enumerate(basins.attractors[:MOST_NAMED], 1):
        name = style.motion(attractor.label, CHARS)
        found.append((k, f"{name}   {percent(basins.fractions[k])}"))
    rest = range(MOST_NAMED + 1, len(basins.attractors) + 1)
    if rest:
        share = sum(basins.fractions[k][0] for k in rest)
        found.append((rest[0], f"and {len(rest)} more, together {100.0 * share:.3g} %"))
    for code, fraction in basins.fractions.items():
        if code <= 0:
            name = "undecided" if code == UNDECIDED_CODE else status_name(-code)
            found.append((code, f"{name}   {percent(fraction)}"))
    return found


def percent(share: tuple[float, float]) -> str:
    """A fraction and its standard error, to the digits the error leaves."""
    value, error = 100.0 * share[0], 100.0 * share[1]
    if error == 0.0:
        return f"{value:g} %"
    digits = 1 + next(n for n in range(1, 8) if error >= 0.95 * 10.0**-n or n == 7)
    return f"({value:.{digits}f} ± {error:.{digits}f}) %"


def _colours(basins: Basins) -> dict[int, str]:
    areas = area_colours([attractor.label for attractor in basins.attractors])
    return {UNDECIDED_CODE: UNDECIDED, BELOW_CODE: BELOW, **dict(enumerate(areas, 1))}


def _pixels(basins: Basins, wide: int, high: int) -> np.ndarray:
    """(rows, columns, 3) colours; cells smaller than a pixel are averaged."""
    colours = _colours(basins)
    first = [_first_cells(*pair) for pair in zip(basins.codes.shape, (high, wide), strict=True)]
    sizes = [
        np.diff(cells, append=count) for cells, count in zip(first, basins.codes.shape, strict=True)
    ]
    area = np.outer(*sizes)
    picture = np.zeros((*area.shape, 3))
    for code in np.unique(basins.codes).tolist():
        mask = (basins.codes == code).astype(np.uint16)
        share = np.add.reduceat(np.add.reduceat(mask, first[0], axis=0), first[1], axis=1) / area
        picture += share[:, :, None] * np.array(to_rgb(colours.get(code, TROUBLE)))
    return np.rint(255.0 * picture).astype(np.uint8)


def _first_cells(cells: int, pixels: int) -> np.ndarray:
    """First cell of every pixel; a pixel per cell where there are fewer cells."""
    count = min(cells, pixels)
    return np.arange(count) * cells // count


def _draw_attractors(axes: Axes, basins: Basins) -> set[int]:
    """Section points of every attractor; returns the numbers of those outside the window."""
    window, outside = basins.window, set()
    for number, attractor in enumerate(basins.attractors, 1):
        q, w = attractor.shown().T
        v = w * omega_of(basins.rpm)
        inside = (window.q[0] <= q) & (q <= window.q[1])
        inside &= (window.v[0] <= v) & (v <= window.v[1])
        if not inside.any():
            outside.add(number)
        if attractor.periodic:
            axes.plot(q, v, **_marker(number), zorder=5)
            continue
        step = max(1, len(q) // DOTS)
        axes.plot(q[::step], v[::step], ".", color=style.APERIODIC, ms=1.2, mew=0.0, zorder=4)
    return outside


def _marker(number: int) -> dict[str, Any]:
    shape = SHAPES[(number - 1) % len(SHAPES)]
    return {"marker": shape, "ms": 6.0, "mfc": "white", "mec": "black", "mew": 1.1, "ls": ""}


def _draw_cam(axes: Axes, basins: Basins, system: System) -> bool:
    """The line q = c at the strobe; True where it lies in the window."""
    c = system.cam.stretches[system.cam.strobe].start_c
    low, high = basins.window.q
    if not low <= c <= high:
        return False
    axes.axvspan(low, c, color=BELOW, linewidth=0.0, zorder=2)  # over cells that the cam cuts
    axes.axvline(c, color="black", linewidth=1.6, zorder=3, clip_on=False)
    return True


# --- a range of speeds


@style.look()
def _draw_range(study: Study, question: Question) -> Figure:
    """Fractions stacked over speed, and where the attractors are."""
    entries = _range_entries(study)
    top = RANGE_HEAD + style.LINE * len(entries)
    rpms = [style.number(study.speeds[k].rpm) for k in (0, -1)]
    title = f"Basin fractions, {rpms[0]} to {rpms[1]} rpm"
    height = top + STACK + GAP + STATES + BOTTOM
    figure = style.page(height, title, _below_range_title(study, question))
    upper = style.place(figure, LEFT, top, WIDE, STACK)
    lower = style.place(figure, LEFT, top + STACK + GAP, WIDE, STATES)
    colours = branch_colours(study)
    edges = _edges(np.array([speed.rpm for speed in study.speeds]))
    _draw_stack(upper, study, edges, colours)
    _draw_states(lower, study, colours)
    for axes in (upper, lower):
        axes.set_xlim(edges.min(), edges.max())
    upper.tick_params(labelbottom=False)
    lower.set_xlabel("cam speed (rpm)")
    lower.set_ylabel("attractors' stroboscopic $q$ (m)")
    areas = {**colours, UNDECIDED_CODE: UNDECIDED, -1: "white"}
    handles = [Patch(facecolor=areas[code], ec="black", lw=0.5) for code, _ in entries]
    legend(figure, RANGE_HEAD - 8, handles, [words for _, words in entries])
    return figure


def _below_range_title(study: Study, question: Question) -> str:
    window = question.window
    return (
        f"{len(study.speeds)} speeds, {window.nq} × {window.nv} starts each, "
        f"q from {window.q[0]:g} to {window.q[1]:g} m, "
        f"v from {window.v[0]:g} to {window.v[1]:g} m/s, {question.method} mapping"
    ).replace("-", "−")


def _range_entries(study: Study) -> list[tuple[int, str]]:
    """(branch, words) of the legend: the largest branches by number, then what is undecided."""
    labels: dict[int, list[str]] = {}
    weight: dict[int, float] = {}
    for speed in study.speeds:
        pairs = zip(speed.branches, speed.attractors, strict=True)
        for number, (branch, attractor) in enumerate(pairs, 1):
            labels.setdefault(branch, []).append(attractor.label)
            weight[branch] = weight.get(branch, 0.0) + speed.fractions[number][0]
    named = sorted(sorted(weight, key=lambda b: (-weight[b], b))[:MOST_NAMED])
    found = [(branch, f"{branch}: {_branch_labels(labels[branch])}") for branch in named]
    if len(weight) > len(named):
        found.append((-1, f"{len(weight) - len(named)} further attractors, in repeated colours"))
    if any(speed.undecided or speed.troubled for speed in study.speeds):
        found.append((UNDECIDED_CODE, "undecided, or numerical trouble"))
    return found


def _branch_labels(labels: Sequence[str]) -> str:
    """The first label, and the others where it changes along the branch."""
    kinds = list(dict.fromkeys(labels))
    shown = ", ".join(style.motion(kind, RANGE_CHARS) for kind in kinds[:LABELS])
    return shown if len(kinds) <= LABELS else f"{shown} and {len(kinds) - LABELS} more labels"


def branch_colours(study: Study) -> dict[int, str]:
    """Colour of every branch of attractors: that of its first label."""
    first: dict[int, str] = {}
    for speed in study.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            first.setdefault(branch, attractor.label)
    numbers = sorted(first)
    areas = area_colours([first[number] for number in numbers])
    return dict(zip(numbers, areas, strict=True))


def _edges(rpms: np.ndarray) -> np.ndarray:
    """Limits of the bar of each speed, halfway to its neighbours."""
    middle = 0.5 * (rpms[1:] + rpms[:-1])
    first, last = 2.0 * rpms[0] - middle[0], 2.0 * rpms[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def _draw_stack(axes: Axes, study: Study, edges: np.ndarray, colours: dict[int, str]) -> None:
    """The fractions of the branches on one another, then what is undecided."""
    height = np.zeros(len(study.speeds))
    bars: dict[str, Any] = {"width": np.abs(np.diff(edges)), "align": "edge", "lw": 0.0}
    left = np.minimum(edges[:-1], edges[1:])
    for branch in sorted(colours):
        share = np.array([_fraction(speed, branch) for speed in study.speeds])
        axes.bar(left, share, bottom=height, color=colours[branch], **bars)
        height = height + share
    rest = np.where(1.0 - height > 1e-12, 1.0 - height, 0.0)
    axes.bar(left, rest, bottom=height, color=UNDECIDED, **bars)
    axes.set_ylim(0.0, 1.0)
    axes.set_ylabel("fraction of the window")


def _fraction(speed: Basins, branch: int) -> float:
    numbers = (k for k, own in enumerate(speed.branches, 1) if own == branch)
    return sum(speed.fractions[number][0] for number in numbers)


def _draw_states(axes: Axes, study: Study, colours: dict[int, str]) -> None:
    """The attractors' stroboscopic positions."""
    for speed in study.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            q = attractor.shown()[:, 0]
            size, edge = 3.0, 0.25
            if not attractor.periodic:
                q, size, edge = q[:: max(1, len(q) // RANGE_DOTS)], 1.6, 0.0
            x = np.full(len(q), speed.rpm)
            axes.plot(x, q, "o", mfc=colours[branch], mec="black", ms=size, mew=edge, zorder=3)
