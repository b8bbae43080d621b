"""Pictures of basins: the window of starts coloured by attractor; their fractions over speed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from camcli.analysis.basins.study import BELOW_CODE, SIMPLE, UNDECIDED_CODE, Basins, Question, Study
from camcli.analysis.sweep import status_name
from camcli.plots import style
from camcli.plots.axes import axis_name, valued
from camcli.plots.picture import Panel, Picture
from camcli.system import System, omega_of

MOST_NAMED = 12  # attractors in the list
CHARS, RANGE_CHARS = 60, 24  # of a label in the list
LABELS = 3  # of a branch of attractors in the list
PALE = (0.8, 0.3)  # white in the colour of a basin: of the largest, of the others
SHAPES = ("o", "s", "^", "D", "v", "P", "X")
DOTS, RANGE_DOTS = 3000, 150  # states of an aperiodic attractor drawn


def draw_basins(study: Study, question: Question, system: System, key: str = "rpm") -> Picture:
    """Picture of the basins of one speed, or of fractions and attractors over a range of them.

    key: what is varied, where that is another number.
    """
    if study.grid is None:
        return _range(study, question, key)
    return _window(study.grid, system, key)


def area_colours(labels: Sequence[str], largest: int = 0) -> list[str]:
    """Colours of the motions with these labels, mixed with white, most in that of the largest."""
    own = enumerate(style.apart([style.label_colour(label) for label in labels]))
    return [style.mixed(colour, PALE[k != largest]) for k, colour in own]


def _swatch(colour: str) -> dict[str, Any]:
    return {"ls": "None", "marker": "s", "ms": 7, "mfc": colour, "mec": style.CAM, "mew": 0.4}


# --- one speed


def _window(basins: Basins, system: System, key: str) -> Picture:
    """The basins of one speed."""
    colours = _colours(basins)
    entries = _entries(basins)
    outside = {k for k, a in enumerate(basins.attractors, 1) if not _inside(basins, a).any()}
    rows: list[list[Any]] = [["", "", "basin of", "share of the window"]]
    for code, name, share in entries:
        marked = 0 < code <= MOST_NAMED and basins.attractors[code - 1].periodic
        shape = _marker(code) if marked and code not in outside else ""
        away = "attractor outside the window" if code in outside else ""
        rows.append([_swatch(colours.get(code, style.TROUBLE)), shape, name, share, away])
    if (basins.codes == BELOW_CODE).any():
        rows.append([_swatch(style.CAM_BODY), "", "none: below the cam"])
    panel = Panel(partial(_draw_window, basins=basins, system=system, colours=colours), 120.0)
    title = f"Basins of attraction, {valued(key, style.number(basins.value))}"
    return Picture(title, {"basins": panel}, _words(basins, system), lists=[rows])


def _words(basins: Basins, system: System) -> str:
    window, phase = basins.window, style.number(round(system.strobe_deg, 9))
    how = "simple cell mapping" if basins.method == SIMPLE else "orbit mapping"
    text = f"{window.nq} × {window.nv} starts at θ = {phase} deg, {how}"
    if basins.level is not None:
        share = 100.0 * basins.computed / basins.cells
        text += f", {share:.3g} % of the cells computed (boundaries refined)"
    entropies = basins.entropies
    text += f"; basin entropy {entropies['basin_entropy']:.3g}"
    if entropies["boundary_boxes"]:
        text += f", boundary entropy {entropies['boundary_entropy']:.3g}"
    if basins.uncertainty is not None:
        doubt = basins.uncertainty
        text += f", boundary dimension {doubt.dimension:.3f} ± {doubt.error:.3f}"
    return text


def _entries(basins: Basins) -> list[tuple[int, str, str]]:
    """(code, name, share) of the list: attractors, then what belongs to none."""
    found = [
        (k, style.motion(attractor.label, CHARS), percent(basins.fractions[k]))
        for k, attractor in enumerate(basins.attractors[:MOST_NAMED], 1)
    ]
    rest = range(MOST_NAMED + 1, len(basins.attractors) + 1)
    if rest:
        share = 100.0 * sum(basins.fractions[k][0] for k in rest)
        found.append((rest[0], f"and {len(rest)} more, together", f"{share:.3g} %"))
    for code, fraction in basins.fractions.items():
        if code <= 0:
            name = "undecided" if code == UNDECIDED_CODE else status_name(-code)
            found.append((code, name, percent(fraction)))
    return found


def percent(share: tuple[float, float]) -> str:
    """A fraction and its standard error, to the digits the error leaves."""
    value, error = 100.0 * share[0], 100.0 * share[1]
    if error == 0.0:
        return f"{value:g} %"
    digits = 1 + next(n for n in range(1, 8) if error >= 0.95 * 10.0**-n or n == 7)
    return f"({value:.{digits}f} ± {error:.{digits}f}) %"


def _colours(basins: Basins) -> dict[int, str]:
    shares = [basins.fractions[k][0] for k, _ in enumerate(basins.attractors, 1)]
    largest = int(np.argmax(shares)) if shares else 0
    areas = area_colours([attractor.label for attractor in basins.attractors], largest)
    none = {UNDECIDED_CODE: style.UNDECIDED, BELOW_CODE: style.CAM_BODY}
    return {**none, **dict(enumerate(areas, 1))}


def _draw_window(axes: Axes, basins: Basins, system: System, colours: dict[int, str]) -> None:
    window = basins.window
    codes, index = np.unique(basins.codes, return_inverse=True)
    table = np.array([to_rgb(colours.get(code, style.TROUBLE)) for code in codes.tolist()])
    pixels = np.rint(255.0 * table).astype(np.uint8)[index.reshape(basins.codes.shape)]
    axes.imshow(pixels, extent=(*window.q, *window.v), origin="lower", aspect="auto")
    for number, attractor in enumerate(basins.attractors, 1):
        q, w = attractor.shown().T
        v = w * omega_of(basins.rpm)
        if attractor.periodic:
            axes.plot(q, v, zorder=5, **_marker(number))
        else:
            step = max(1, len(q) // DOTS)
            axes.plot(q[::step], v[::step], ".", color=style.APERIODIC, ms=1.2, mew=0.0, zorder=4)
    c = system.cam.stretches[system.cam.strobe].start_c
    low, high = window.q
    if low <= c <= high:
        axes.axvspan(low, c, color=style.CAM_BODY, linewidth=0.0, zorder=2)  # over cells it cuts
        axes.axvline(c, color=style.CAM, linewidth=1.6, zorder=3, label="cam, $q = c$")
    axes.set(xlim=window.q, ylim=window.v)
    axes.set(xlabel="position $q$ of the start (m)", ylabel="velocity $v$ of the start (m/s)")


def _inside(basins: Basins, attractor: Any) -> np.ndarray:
    """Which section points of an attractor lie in the window."""
    q, w = attractor.shown().T
    v, window = w * omega_of(basins.rpm), basins.window
    inside = (window.q[0] <= q) & (q <= window.q[1])
    return inside & (window.v[0] <= v) & (v <= window.v[1])


def _marker(number: int) -> dict[str, Any]:
    shape = SHAPES[(number - 1) % len(SHAPES)]
    return {"marker": shape, "ms": 6.0, "mfc": "white", "mec": "black", "mew": 1.1, "ls": "None"}


# --- a range of speeds


def _range(study: Study, question: Question, key: str) -> Picture:
    """Fractions stacked over what is varied, and where the attractors are."""
    colours, edges = branch_colours(study), _edges(np.array([s.value for s in study.speeds]))
    areas = {**colours, UNDECIDED_CODE: style.UNDECIDED, -1: "white"}
    rows: list[list[Any]] = [[_swatch(areas[code]), words] for code, words in _range_entries(study)]
    half = (len(rows) + 1) // 2
    head: list[list[Any]] = [["", "branch of attractors"]]
    window, ends = question.window, [style.number(study.speeds[k].value) for k in (0, -1)]
    what = "speeds" if key == "rpm" else "values"
    words = (
        f"{len(study.speeds)} {what}, {window.nq} × {window.nv} starts each, "
        f"q from {window.q[0]:g} to {window.q[1]:g} m, "
        f"v from {window.v[0]:g} to {window.v[1]:g} m/s, {question.method} mapping"
    ).replace("-", "−")
    more: dict[str, Any] = {"study": study, "edges": edges, "colours": colours, "key": key}
    panels = {
        "fractions": Panel(partial(_draw_stack, **more), 70.0, key),
        "attractors": Panel(partial(_draw_states, **more), 52.0, key),
    }
    title = f"Basin fractions, {valued(key, ' to '.join(ends))}"
    return Picture(title, panels, words, lists=[head + rows[:half], head + rows[half:]])


def _range_entries(study: Study) -> list[tuple[int, str]]:
    """(branch, words) of the list: the largest branches by number, then what is undecided."""
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


def _edges(values: np.ndarray) -> np.ndarray:
    """Limits of the bar of each value, halfway to its neighbours."""
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middle[0], 2.0 * values[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def _draw_stack(
    axes: Axes, study: Study, edges: np.ndarray, colours: dict[int, str], key: str
) -> None:
    """The fractions of the branches on one another, then what is undecided."""
    height = np.zeros(len(study.speeds))
    bars: dict[str, Any] = {"width": np.diff(edges), "align": "edge", "lw": 0.0}
    for branch in sorted(colours):
        share = np.array([_fraction(speed, branch) for speed in study.speeds])
        axes.bar(edges[:-1], share, bottom=height, color=colours[branch], **bars)
        height = height + share
    rest = np.where(1.0 - height > 1e-12, 1.0 - height, 0.0)
    axes.bar(edges[:-1], rest, bottom=height, color=style.UNDECIDED, **bars)
    axes.set(xlim=(edges.min(), edges.max()), xlabel=axis_name(key))
    axes.set(ylim=(0.0, 1.0), ylabel="fraction of the window")


def _fraction(speed: Basins, branch: int) -> float:
    numbers = (k for k, own in enumerate(speed.branches, 1) if own == branch)
    return sum(speed.fractions[number][0] for number in numbers)


def _draw_states(
    axes: Axes, study: Study, edges: np.ndarray, colours: dict[int, str], key: str
) -> None:
    """The attractors' stroboscopic positions."""
    for speed in study.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            q = attractor.shown()[:, 0]
            size, edge = 3.0, 0.25
            if not attractor.periodic:
                q, size, edge = q[:: max(1, len(q) // RANGE_DOTS)], 1.6, 0.0
            x = np.full(len(q), speed.value)
            axes.plot(x, q, "o", mfc=colours[branch], mec="black", ms=size, mew=edge, zorder=3)
    axes.set(xlim=(edges.min(), edges.max()), xlabel=axis_name(key))
    axes.set_ylabel("attractors' stroboscopic $q$ (m)")
