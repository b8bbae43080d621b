"""Picture of basins against speed: fractions stacked, and where the attractors are."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from camcli.analysis.basins.mapping import UNDECIDED_CODE, Question
from camcli.analysis.basins.study import Study
from camcli.plots import style
from camcli.plots.basins import MOST_NAMED, UNDECIDED, area_colours

LEFT, RIGHT, BOTTOM = 125, 45, 95  # px, margins
STACK, STATES, GAP = 560, 420, 40  # px
HEAD = 100  # px, above the legend
CHARS = 24  # of a label in the legend
LABELS = 3  # of a branch in the legend
DOTS = 150  # states of an aperiodic attractor drawn at a speed


@style.look()
def draw_range(result: Study, question: Question) -> Figure:
    """Picture of a range of speeds."""
    entries = _entries(result)
    top = HEAD + style.LINE * len(entries)
    wide = style.WIDTH - LEFT - RIGHT
    figure = style.page(top + STACK + GAP + STATES + BOTTOM)
    _heading(figure, result, question)
    upper = style.place(figure, LEFT, top, wide, STACK)
    lower = style.place(figure, LEFT, top + STACK + GAP, wide, STATES)
    colours = branch_colours(result)
    edges = _edges(np.array([speed.rpm for speed in result.speeds]))
    _draw_stack(upper, result, edges, colours)
    _draw_states(lower, result, colours)
    for axes in (upper, lower):
        axes.set_xlim(edges.min(), edges.max())
    upper.tick_params(labelbottom=False)
    lower.set_xlabel("cam speed (rpm)")
    lower.set_ylabel("attractors' stroboscopic $q$ (m)")
    _legend(figure, entries, colours)
    return figure


def _heading(figure: Figure, result: Study, question: Question) -> None:
    rpms = [style.number(speed.rpm) for speed in (result.speeds[0], result.speeds[-1])]
    title = f"Basin fractions, {rpms[0]} to {rpms[1]} rpm"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    q, v = question.window.q, question.window.v
    text = (
        f"{len(result.speeds)} speeds, {question.window.nq} × {question.window.nv} starts each, "
        f"q from {q[0]:g} to {q[1]:g} m, v from {v[0]:g} to {v[1]:g} m/s, {question.method} mapping"
    ).replace("-", "−")
    style.write(figure, 20, 54, text)


def _entries(result: Study) -> list[tuple[int, str]]:
    """(branch, words) of the legend: the largest branches by number, then what is undecided."""
    labels: dict[int, list[str]] = {}
    weight: dict[int, float] = {}
    for speed in result.speeds:
        for k, (branch, attractor) in enumerate(zip(speed.branches, speed.attractors, strict=True)):
            labels.setdefault(branch, []).append(attractor.label)
            weight[branch] = weight.get(branch, 0.0) + speed.fractions[k + 1][0]
    named = sorted(sorted(weight, key=lambda b: (-weight[b], b))[:MOST_NAMED])
    found = [(branch, f"{branch}: {_words(labels[branch])}") for branch in named]
    if len(weight) > len(named):
        found.append((-1, f"{len(weight) - len(named)} further attractors, in repeated colours"))
    if any(speed.undecided or speed.troubled for speed in result.speeds):
        found.append((UNDECIDED_CODE, "undecided, or numerical trouble"))
    return found


def branch_colours(result: Study) -> dict[int, str]:
    """Colour of every branch of attractors: that of its first label."""
    first: dict[int, str] = {}
    for speed in result.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            first.setdefault(branch, attractor.label)
    numbers = sorted(first)
    areas = area_colours([first[number] for number in numbers])
    return dict(zip(numbers, areas, strict=True))


def _words(labels: list[str]) -> str:
    """The first label, and the others where it changes along the branch."""
    kinds = list(dict.fromkeys(labels))
    shown = ", ".join(style.motion(kind, CHARS) for kind in kinds[:LABELS])
    return shown if len(kinds) <= LABELS else f"{shown} and {len(kinds) - LABELS} more labels"


def _edges(rpms: np.ndarray) -> np.ndarray:
    """Limits of the bar of each speed, halfway to its neighbours."""
    middle = 0.5 * (rpms[1:] + rpms[:-1])
    first, last = 2.0 * rpms[0] - middle[0], 2.0 * rpms[-1] - middle[-1]
    return np.concatenate(([first], middle, [last]))


def _draw_stack(axes: Axes, result: Study, edges: np.ndarray, colours: dict[int, str]) -> None:
    low = np.zeros(len(result.speeds))
    branches = sorted({branch for speed in result.speeds for branch in speed.branches})
    left, width = np.minimum(edges[:-1], edges[1:]), np.abs(np.diff(edges))
    for branch in branches:
        share = np.array([_share(speed, branch) for speed in result.speeds])
        look = {"color": colours[branch], "linewidth": 0.0, "align": "edge"}
        axes.bar(left, share, width, low, **look)
        low = low + share
    rest = np.where(1.0 - low > 1e-12, 1.0 - low, 0.0)
    axes.bar(left, rest, width, low, color=UNDECIDED, align="edge", linewidth=0.0)
    axes.set_ylim(0.0, 1.0)
    axes.set_ylabel("fraction of the window")


def _share(speed, branch: int) -> float:
    pairs = enumerate(speed.branches)
    return sum(speed.fractions[k + 1][0] for k, own in pairs if own == branch)


def _draw_states(axes: Axes, result: Study, colours: dict[int, str]) -> None:
    dot = {"linestyle": "", "markeredgecolor": "black", "zorder": 3}
    for speed in result.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            q = attractor.shown()[:, 0]
            few = attractor.periodic
            q = q if few else q[:: max(1, len(q) // DOTS)]
            look = {"marker": "o", "markersize": 3.0 if few else 1.6}
            look["markeredgewidth"] = 0.25 if few else 0.0
            axes.plot(np.full(len(q), speed.rpm), q, color=colours[branch], **look, **dot)


def _legend(figure: Figure, entries: list[tuple[int, str]], colours: dict[int, str]) -> None:
    colours = {**colours, UNDECIDED_CODE: UNDECIDED, -1: "white"}
    handles = [
        Patch(
            facecolor=colours[code],
            edgecolor="black",
            linewidth=0.5,
        )
        for code, _ in entries
    ]
    height = round(figure.get_figheight() * style.DPI)
    at = (20 / style.WIDTH, 1.0 - (HEAD - 8) / height)
    look = {"borderaxespad": 0.0, "borderpad": 0.0, "handletextpad": 0.6, "labelspacing": 0.45}
    names = [words for _, words in entries]
    figure.legend(handles, names, loc="upper left", bbox_to_anchor=at, **look)
