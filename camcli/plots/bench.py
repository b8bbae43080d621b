"""Pictures of the bench: error against time of every method, and the extreme cases."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, isfinite
from textwrap import shorten
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from camcli.analysis.bench.precision import GIVEN_UP, INVENTED, MISSED, OK, OVER, Measured, case
from camcli.analysis.bench.stability import Outcome
from camcli.plots import style

COLUMNS = 3
LEFT, TOP, RIGHT, BOTTOM = 150, 220, 30, 110  # px
ACROSS, DOWN = 45, 110  # px, between panels
HIGH = 330  # px, of a panel
FLOOR = 1e-17  # error drawn for none at all
METHODS = {  # name, colour and mark
    "core": ("camcli", "black", "o"),
    "rk45": ("RK45", style.SERIES[1], "s"),
    "dop853": ("DOP853", style.SERIES[0], "D"),
    "lsoda": ("LSODA", style.SERIES[5], "^"),
    "radau": ("Radau", style.SERIES[4], "v"),
    "heyoka": ("heyoka", style.SERIES[2], "P"),
    "rk4": ("RK4, fixed steps", style.SERIES[3], "h"),
}
MARKS = (  # statuses, mark, its size, and what it says
    ((MISSED, INVENTED), "x", 7.0, "missed or invented impacts"),
    ((GIVEN_UP,), "|", 9.0, "given up, error until then"),
    ((OVER,), "*", 9.0, "beyond the bound promised"),
)
LIMITED = "max_step"  # in a setting: drawn hollow
Look = dict[str, Any]


@style.look()
def draw_precision(found: Sequence[Measured]) -> Figure:
    """Picture of the points, a panel per case."""
    names = list(dict.fromkeys(m.case for m in found))
    rows = ceil(len(names) / COLUMNS)
    height = TOP + rows * HIGH + (rows - 1) * DOWN + BOTTOM
    wide = (style.WIDTH - LEFT - RIGHT - (COLUMNS - 1) * ACROSS) // COLUMNS
    drawn = [m for m in found if isfinite(m.seconds) and isfinite(m.error)]
    figure = style.page(height, "Work and precision: error against time, lower left is better")
    times = [m.seconds for m in drawn] or [1e-4, 1.0]
    errors = [max(m.error, FLOOR) for m in drawn] or [FLOOR, 1.0]
    for k, name in enumerate(names):
        row, column = divmod(k, COLUMNS)
        left, top = LEFT + column * (wide + ACROSS), TOP + row * (HIGH + DOWN)
        axes = style.place(figure, left, top, wide, HIGH)
        axes.set(xscale="log", yscale="log", xlim=(min(times) / 2.0, max(times) * 2.0))
        axes.set_ylim(min(errors) / 4.0, max(1.0, *errors) * 3.0)
        _panel(axes, [m for m in drawn if m.case == name], case(name).title)
        axes.set_xlabel("time of a run (s)" if k + COLUMNS >= len(names) else "")
        axes.set_ylabel("largest error (turns)" if column == 0 else "")
        if column:
            axes.set_yticklabels([])
    _legend(figure, drawn)
    return figure


def _panel(axes: Axes, found: Sequence[Measured], title: str) -> None:
    """The settings of each method joined, and a mark on those that are not to be trusted."""
    axes.set_title(title, size=8, loc="left", pad=4)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_major_locator(LogLocator(base=1e4, numticks=8))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.grid(True, color=style.CAM_BODY, linewidth=0.5, zorder=0)
    for method, limited in dict.fromkeys((m.method, LIMITED in m.setting) for m in found):
        some = [m for m in found if (m.method, LIMITED in m.setting) == (method, limited)]
        _, colour, shape = METHODS[method]
        x, y = [m.seconds for m in some], [max(m.error, FLOOR) for m in some]
        line = axes.plot(x, y, color=colour, zorder=6 if method == "core" else 3, **_mark(shape))
        if limited:
            line[0].set(markerfacecolor="white", linestyle=(0, (3, 2)))
        for statuses, sign, size, _ in MARKS:
            bad = [k for k, m in enumerate(some) if m.status in statuses]
            axes.plot([x[k] for k in bad], [y[k] for k in bad], zorder=8, **_sign(sign, size))
    if not found:
        style.note(axes, "no point measured")


def _mark(shape: str) -> Look:
    return {"marker": shape, "markersize": 4.0, "markeredgewidth": 0.7, "linewidth": 0.7}


def _sign(shape: str, size: float) -> Look:
    look: Look = {"color": style.TROUBLE, "linestyle": "", "markeredgewidth": 0.9}
    return {**look, "marker": shape, "markersize": size}


def _legend(figure: Figure, drawn: Sequence[Measured]) -> None:
    methods = {m.method for m in drawn}
    handles = [
        Line2D([], [], label=name, color=colour, **_mark(shape))
        for method, (name, colour, shape) in METHODS.items()
        if method in methods
    ]
    hollow: Look = {**_mark("s"), "markerfacecolor": "white", "linestyle": (0, (3, 2))}
    handles.append(Line2D([], [], color=style.CAM, label="steps of at most 1/16 turn", **hollow))
    handles += [
        Line2D([], [], label=words, **_sign(shape, size))
        for statuses, shape, size, words in MARKS
        if OVER not in statuses or any(m.status == OVER for m in drawn)
    ]
    layout = {"ncols": 4, "columnspacing": 1.6, "handletextpad": 0.6, "borderaxespad": 0.0}
    at = style.share(figure, LEFT, 58)
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=at, **layout)


# --- extreme cases

FIRST, LAST, ROW = 120, 95, 62  # px: above the rows, below them, of one
BARS, WIDE = 860, 400  # px, left edge and width of the bars
TEXT = 42  # px, where the words begin
LONGEST = 74  # letters of a line
SHORTEST = 1e-4  # s, where the axis begins


@style.look()
def draw_stability(outcomes: Sequence[Outcome]) -> Figure:
    """Picture of the rows: the case with what is expected, what was observed, and the time."""
    good = sum(o.status == OK for o in outcomes)
    figure = style.page(
        FIRST + ROW * len(outcomes) + LAST,
        f"Extreme cases: {good} of {len(outcomes)} as expected",
        "case and what is expected; below it what was observed",
    )
    axes = style.place(figure, BARS, FIRST, WIDE, ROW * len(outcomes))
    for k, o in enumerate(outcomes):
        colour, mark = (style.CAM, "●") if o.status == OK else (style.TROUBLE, "✗")
        top = FIRST + ROW * k + 4
        style.write(figure, 18, top, mark, size=7, color=colour)
        first = shorten(f"{o.case}: {o.expected}", LONGEST, placeholder=" …")
        style.write(figure, TEXT, top, first, size=6.5)
        seen = shorten(o.observed or o.status, LONGEST + 6, placeholder=" …")
        style.write(figure, TEXT, top + 26, seen, size=6, color=style.CAM)
        bar = axes.barh(k, max(o.seconds, SHORTEST), height=0.55, color=colour)
        axes.bar_label(bar, [f"{o.seconds:.2g}"], padding=3, size=6)
    longest = max(SHORTEST, *(o.seconds for o in outcomes))
    axes.set(ylim=(len(outcomes) - 0.5, -0.5), xscale="log", xlim=(SHORTEST, 3.0 * longest))
    axes.set_yticks([])
    axes.set_xlabel("time of the row (s)")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


DRAWN: dict[str, Callable] = {"precision": draw_precision, "stability": draw_stability}
