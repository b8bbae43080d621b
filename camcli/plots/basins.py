"""Pictures of basins: the window of starts coloured by attractor; their fractions over speed."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.ticker import MaxNLocator

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.study import BELOW_CODE, UNDECIDED_CODE, Basins, BasinsQuestion, Study
from camcli.analysis.sweep import status_name
from camcli.errors import plural
from camcli.plots import style
from camcli.plots.axes import DASHED, axis_name, unit_axis
from camcli.plots.picture import Panel, Picture
from camcli.quantities import MM_PER_INCH, Q, Units, V
from camcli.system import System, kind_of_cam, omega_of, units_of
from camcli.words.basins import (
    further_words,
    picture_title,
    saddle_words,
    window_words,
    windows_words,
)
from camcli.words.in_print import label_text, number_text, valued

MOST_NAMED = 12  # attractors in the list
CHARS, RANGE_CHARS = 60, 24  # of a label in the list
LABELS, ABREAST = 3, 2  # of a branch of attractors in the list, and in a row of it
NARROW = 40.0  # mm, of a window with few numbers
PALE = (0.8, 0.3)  # white in the colour of a basin: of the largest, of the others
SHAPES = ("o", "s", "^", "D", "v", "P", "X")
DOTS, RANGE_DOTS = 3000, 150  # states of an aperiodic attractor drawn
MOST_MARKS = 12  # states of a periodic one that have a mark each; of a longer one they are dots
BOUNDARY = "black"
ELLIPSE: dict[str, Any] = {"color": BOUNDARY, "lw": 0.6, "ls": DASHED}
IN_ELLIPSE = "ellipse: starts in it were seen to settle there"
OUTLINE = 121  # points of an ellipse
SADDLE: dict[str, Any] = {"marker": "x", "ms": 5.0, "mec": BOUNDARY, "mew": 1.2, "ls": "None"}


def draw_basins(
    study: Study, question: BasinsQuestion, system: System, key: str = "rpm"
) -> Picture:
    """Picture of the basins of a few speeds; of fractions and attractors over a range of them.

    key: what is varied, where that is another number.
    """
    return (_windows if study.grids else _range)(study, question, system, key)


def area_colours(labels: Sequence[str], largest: int | None = None) -> list[str]:
    """Colours of the motions with these labels, mixed with white, most in that of the largest.

    largest: which of them is so wide that a pale shade shows; without it all are strong.
    """
    own = enumerate(style.apart([style.label_colour(label) for label in labels]))
    return [style.mixed(colour, PALE[k != largest]) for k, colour in own]


def _swatch(colour: str) -> dict[str, Any]:
    return {"ls": "None", "marker": "s", "ms": 7, "mfc": colour, "mec": style.CAM, "mew": 0.4}


# --- the windows of a few speeds


def _windows(study: Study, _: BasinsQuestion, system: System, key: str) -> Picture:
    """The basins of the speeds side by side; their attractors by branch."""
    grids = study.grids
    labels = _labels(grids)
    order = sorted(labels)
    weight = [sum(_fraction(speed, branch) for speed in grids) for branch in order]
    largest = int(np.argmax(weight)) if order else 0
    areas = area_colours([labels[branch][0] for branch in order], largest)
    none = {UNDECIDED_CODE: style.UNDECIDED, BELOW_CODE: style.CAM_BODY}
    colours = {**none, **dict(zip(order, areas, strict=True))}
    shared = "v" if len(grids) > 1 else ""
    panels = {}
    for speed in grids:
        own = valued(key, number_text(speed.value))
        above = own if len(grids) > 1 else ""  # of one alone the title says it
        draw = partial(_draw_window, basins=speed, colours=colours, named=above, system=system)
        name, height = ("basins", 120.0) if len(grids) == 1 else (f"basins {own}", 66.0)
        panels[name] = Panel(draw, height, across=len(grids), y=shared)
    title = picture_title("Basins of attraction", grids, key, kind_of_cam(system))
    words = window_words(grids, system)
    lists = [_attractor_rows(grids, labels, colours, key), *_saddle_rows(grids)]
    return Picture(title, panels, caption=words, lists=lists)


def _attractor_rows(
    grids: Sequence[Basins], labels: dict[int, list[str]], colours: dict[int, str], key: str
) -> list[list[Any]]:
    """Attractors by branch, then what belongs to none, with shares of each window."""
    if len(grids) == 1:
        heads = ["share of the window"]
    else:
        heads = [valued(key, number_text(speed.value)) for speed in grids]
    rows = [_row(grids, "", "", "basin of", heads)]
    branches = sorted(labels)
    rows += [
        _attractor_row(grids, branch, labels[branch], colours[branch])
        for branch in branches[:MOST_NAMED]
    ]
    rest = branches[MOST_NAMED:]
    if rest:
        sums = [100.0 * sum(_fraction(speed, branch) for branch in rest) for speed in grids]
        shares = [_percent(share) for share in sums]
        name = f"and {len(rest)} more, together"
        rows.append(_row(grids, _swatch(colours[rest[0]]), "", name, shares))
    no_attractor = {code for speed in grids for code in speed.fractions if code <= 0}
    for code in sorted(no_attractor, reverse=True):
        name = "undecided" if code == UNDECIDED_CODE else status_name(-code)
        colour = colours.get(code, style.TROUBLE)
        shares = _shares(grids, [code] * len(grids))
        rows.append(_row(grids, _swatch(colour), "", name, shares))
    none = [""] * len(grids)
    if any((speed.codes == BELOW_CODE).any() for speed in grids):
        rows.append(_row(grids, _swatch(style.CAM_BODY), "", "none: below the cam", none))
    return rows


def _row(
    grids: Sequence[Basins], swatch: Any, marker: Any, name: str, shares: Sequence[str]
) -> list[Any]:
    """A row of the list: the name before the share of a single window, behind those of several.

    A narrow page cuts off the ends of rows, and the shares tell more than the end of a long name.
    """
    if len(grids) == 1:
        return [swatch, marker, name, *shares]
    return [swatch, marker, *shares, name]


def _attractor_row(
    grids: Sequence[Basins], branch: int, labels: Sequence[str], colour: str
) -> list[Any]:
    """The row of a branch of attractors; a marker where its states are drawn in a window."""
    codes = [_code(speed, branch) for speed in grids]
    inside = False
    marked = False
    for speed, code in zip(grids, codes, strict=True):
        if code is not None:
            attractor = speed.attractors[code - 1]
            marked = marked or _has_marks(attractor)
            inside = inside or bool(_inside(speed, attractor).any())
    marker = _marker(branch) if inside and marked else ""
    name = label_text(labels[0], CHARS) if len(grids) == 1 else _branch_labels(labels)
    row = _row(grids, _swatch(colour), marker, name, _shares(grids, codes))
    return [*row, "" if inside else "attractor outside the window"]


def _code(speed: Basins, branch: int) -> int | None:
    """The code of the cells that end on the attractor of a branch, None where it has none there."""
    return speed.branches.index(branch) + 1 if branch in speed.branches else None


def _shares(grids: Sequence[Basins], codes: Sequence[int | None]) -> list[str]:
    """The share of each window with the code given for it; with its error if it is alone."""
    say = percent if len(grids) == 1 else _short
    shares = []
    for speed, code in zip(grids, codes, strict=True):
        share = None if code is None else speed.fractions.get(code)
        shares.append("" if share is None else say(share))
    return shares


def _saddle_rows(grids: Sequence[Basins]) -> list[list[list[Any]]]:
    """The saddles on the boundaries, and how many motions there were led to them."""
    led: dict[str, list[int]] = {}
    for saddle in (saddle for speed in grids for saddle in speed.saddles or ()):
        counts = led.setdefault(saddle.orbit.label, [0, 0])
        counts[0], counts[1] = counts[0] + saddle.led, counts[1] + saddle.tried
    rows: list[list[Any]] = [["", "", "boundary: stable manifold of"]]
    for label, (some, tried) in led.items():
        words = saddle_words(label_text(label, RANGE_CHARS), some, tried)
        rows.append([{"color": BOUNDARY, "lw": 0.8}, SADDLE, words])
    return [rows] if led else []


def percent(share: tuple[float, float]) -> str:
    """A fraction and its standard error, to the digits the error leaves."""
    value = 100.0 * share[0]
    error = 100.0 * share[1]
    if error == 0.0:
        return f"{value:g} %"
    digits = 1 + next(n for n in range(1, 8) if error >= 0.95 * 10.0**-n or n == 7)
    return f"({value:.{digits}f} ± {error:.{digits}f}) %"


def _draw_window(
    axes: Axes, basins: Basins, colours: dict[int, str], named: str, system: System
) -> None:
    window = basins.window
    codes, index = np.unique(basins.codes, return_inverse=True)
    names = [basins.branches[code - 1] if code > 0 else code for code in codes.tolist()]
    table = np.array([to_rgb(colours.get(name, style.TROUBLE)) for name in names])
    pixels = np.rint(255.0 * table).astype(np.uint8)[index.reshape(basins.codes.shape)]
    axes.imshow(pixels, extent=(*window.q, *window.v), origin="lower", aspect="auto")
    if basins.saddles:
        _draw_boundary(axes, basins)
    for branch, attractor in zip(basins.branches, basins.attractors, strict=True):
        inside = _inside(basins, attractor)
        q, w = attractor.shown()[inside].T
        if not inside.any():
            continue  # its row of the list says so
        v = w * omega_of(basins.rpm)
        if _has_marks(attractor):
            axes.plot(q, v, zorder=5, clip_on=False, **_marker(branch))
        else:
            step = max(1, len(q) // DOTS)
            axes.plot(q[::step], v[::step], ".", color=style.APERIODIC, ms=1.2, mew=0.0, zorder=4)
    drawn = [(q, v) for q, v in _ellipses(basins) if _in_window(basins, q, v).any()]
    for number, (q, v) in enumerate(drawn):
        axes.plot(q, v, zorder=1.8, label=None if number else IN_ELLIPSE, **ELLIPSE)
    c = basins.cam_q
    low, high = window.q
    if low <= c <= high:
        axes.axvspan(low, c, color=style.CAM_BODY, linewidth=0.0, zorder=2)  # over cells it cuts
        axes.axvline(c, color=style.CAM, linewidth=1.6, zorder=3, label="cam, $q = c$")
    axes.set(xlim=window.q, ylim=window.v)
    unit_axis(axes.xaxis, Q.name, units_of(system))
    axes.set_ylabel(V.label)
    axes.set_title(named)
    if axes.get_window_extent().width < NARROW / MM_PER_INCH * style.DPI:
        axes.xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 4, 5, 10]))


def _draw_boundary(axes: Axes, basins: Basins) -> None:
    """The boundaries between basins, and the saddles whose stable manifolds they are."""
    window = basins.window
    codes = np.ma.masked_less_equal(basins.codes, UNDECIDED_CODE)
    q, v = window.q_of(np.arange(window.nq)), window.v_of(np.arange(window.nv))
    for code in range(1, len(basins.attractors)):  # the last one has no other boundary
        axes.contour(q, v, codes == code, [0.5], colors=BOUNDARY, linewidths=0.5, zorder=1.5)
    for saddle in basins.saddles or ():
        states = [(at, w * omega_of(basins.rpm)) for at, w in saddle.orbit.states]
        axes.plot(*zip(*states, strict=True), zorder=5, **SADDLE)


def _has_marks(attractor: Attractor) -> bool:
    """Whether each of an attractor's states has a mark: where they are few."""
    return attractor.periodic and len(attractor.states) <= MOST_MARKS


def _ellipses(basins: Basins) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Positions (m) and velocities (m/s) of the outlines of ellipses about attractors' states.

    Those from which starts were seen to come back. About each state (q, w) an ellipse holds all
    (q + x, w + y) with A x^2 + B x y + C y^2 <= 1.
    """
    around = np.linspace(0.0, 2.0 * np.pi, OUTLINE)
    circle = np.array([np.cos(around), np.sin(around)])
    for attractor, region in zip(basins.attractors, basins.regions, strict=False):
        if region is None or not region.returns or not _has_marks(attractor):
            continue
        for (q, w), (a, b, c) in zip(attractor.states, region.forms, strict=True):
            form = np.array([[a, 0.5 * b], [0.5 * b, c]])
            x, y = np.linalg.solve(np.linalg.cholesky(form).T, circle)
            yield q + x, (w + y) * omega_of(basins.rpm)


def _inside(basins: Basins, attractor: Any) -> np.ndarray:
    """Which section points of an attractor lie in the window."""
    q, w = attractor.shown().T
    return _in_window(basins, q, w * omega_of(basins.rpm))


def _in_window(basins: Basins, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Which states (m, m/s) lie in the window."""
    window = basins.window
    inside = (window.q[0] <= q) & (q <= window.q[1])
    return inside & (window.v[0] <= v) & (v <= window.v[1])


def _marker(number: int) -> dict[str, Any]:
    shape = SHAPES[(number - 1) % len(SHAPES)]
    return {"marker": shape, "ms": 6.0, "mfc": "white", "mec": "black", "mew": 1.1, "ls": "None"}


# --- a range of speeds


def _range(study: Study, question: BasinsQuestion, system: System, key: str) -> Picture:
    """Fractions stacked over what is varied, and where the attractors are."""
    colours = branch_colours(study)
    values = np.array([s.value for s in study.speeds])
    middle = 0.5 * (values[1:] + values[:-1])  # edges: halfway from each value to the next
    edges = np.array([2.0 * values[0] - middle[0], *middle, 2.0 * values[-1] - middle[-1]])
    areas = {**colours, UNDECIDED_CODE: style.UNDECIDED, -1: "white"}
    rows: list[list[Any]] = []
    for code, lines in _range_entries(study):
        rows += [[_swatch(areas[code]), lines[0]], *([["", line] for line in lines[1:]])]
    units = units_of(system)
    words = windows_words(study, question.window, units, key)
    more: dict[str, Any] = {"study": study, "edges": edges, "colours": colours, "key": key}
    states = partial(_draw_states, units=units, **more)
    panels = {
        "fractions": Panel(partial(_draw_stack, **more), 70.0, key),
        "attractors": Panel(states, 52.0, key),
    }
    title = picture_title("Basin fractions", study.speeds, key, kind_of_cam(system))
    return Picture(title, panels, caption=words, lists=[[["", "branch of attractors"], *rows]])


def _labels(speeds: Sequence[Basins]) -> dict[int, list[str]]:
    """The labels of the branches of attractors, from speed to speed."""
    labels: dict[int, list[str]] = {}
    for speed in speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            labels.setdefault(branch, []).append(attractor.label)
    return labels


def _range_entries(study: Study) -> list[tuple[int, list[str]]]:
    """(branch, lines) of the list: the largest branches by number, then what is undecided."""
    labels = _labels(study.speeds)
    weight = {branch: sum(_fraction(speed, branch) for speed in study.speeds) for branch in labels}
    named = sorted(sorted(weight, key=lambda b: (-weight[b], b))[:MOST_NAMED])
    found = [(branch, _in_lines(branch, labels[branch])) for branch in named]
    if len(weight) > len(named):
        found.append((-1, [further_words(len(weight) - len(named))]))
    if any(speed.undecided or speed.troubled for speed in study.speeds):
        found.append((UNDECIDED_CODE, ["undecided, or numerical trouble"]))
    return found


def _in_lines(branch: int, labels: Sequence[str]) -> list[str]:
    """The number and the labels of a branch, in lines that a journal's column has room for."""
    kinds = list(dict.fromkeys(labels))
    shown = [label_text(kind, RANGE_CHARS) for kind in kinds[:LABELS]]
    lines = [", ".join(shown[k : k + ABREAST]) for k in range(0, len(shown), ABREAST)]
    if (more := len(kinds) - LABELS) > 0:
        lines[-1] += f" and {plural(more, 'more label')}"
    return [f"{branch}: {lines[0]}", *lines[1:]]


def _branch_labels(labels: Sequence[str]) -> str:
    """The first label, and the others where it changes along the branch."""
    kinds = list(dict.fromkeys(labels))
    shown = ", ".join(label_text(kind, RANGE_CHARS) for kind in kinds[:LABELS])
    more = len(kinds) - LABELS
    return shown if more <= 0 else f"{shown} and {plural(more, 'more label')}"


def branch_colours(study: Study) -> dict[int, str]:
    """Colour of every branch of attractors: that of its first label."""
    labels = _labels(study.speeds)
    numbers = sorted(labels)
    return dict(zip(numbers, area_colours([labels[n][0] for n in numbers]), strict=True))


def _short(share: tuple[float, float]) -> str:
    return _percent(100.0 * share[0])


def _percent(share: float) -> str:
    """A share in percent with three digits, so that those of a row have as many: 18.0 %."""
    return f"{share:#.3g}".rstrip(".") + " %"


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
    axes: Axes, study: Study, edges: np.ndarray, colours: dict[int, str], key: str, units: Units
) -> None:
    """The attractors' stroboscopic positions."""
    for speed in study.speeds:
        for branch, attractor in zip(speed.branches, speed.attractors, strict=True):
            q = attractor.shown()[:, 0]
            size = 3.0
            edge = 0.25
            if not _has_marks(attractor):
                q = q[:: max(1, len(q) // RANGE_DOTS)]
                size = 1.6
                edge = 0.0
            x = np.full(len(q), speed.value)
            axes.plot(x, q, "o", mfc=colours[branch], mec="black", ms=size, mew=edge, zorder=3)
    axes.set(xlim=(edges.min(), edges.max()), xlabel=axis_name(key))
    unit_axis(axes.yaxis, "attractors' stroboscopic $q$", units)
