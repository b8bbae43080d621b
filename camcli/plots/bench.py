"""Pictures of the bench: error against time of every method, and the extreme cases."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite, isnan
from textwrap import shorten
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from camcli.analysis.bench.pieces import OK
from camcli.analysis.bench.precision import GIVEN_UP, INVENTED, MISSED, OVER, Measured
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
MARKS = (((MISSED, INVENTED), "x", 7.0), ((GIVEN_UP,), "|", 9.0), ((OVER,), "*", 9.0))
LIMITED = "max_step"  # in a setting: drawn hollow
Look = dict[str, Any]


@style.look()
def draw_precision(found: Sequence[Measured], titles: dict[str, str]) -> Figure:
    """Picture of the points; `titles` by case, in order."""
    rows = ceil(len(titles) / COLUMNS)
    height = TOP + rows * HIGH + (rows - 1) * DOWN + BOTTOM
    wide = (style.WIDTH - LEFT - RIGHT - (COLUMNS - 1) * ACROSS) // COLUMNS
    drawn = [m for m in found if isfinite(m.seconds) and isfinite(m.error)]
    figure = style.page(height)
    title = "Work and precision: error against time, lower left is better"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    limits = _limits(drawn)
    for k, (name, words) in enumerate(titles.items()):
        row, column = divmod(k, COLUMNS)
        left, top = LEFT + column * (wide + ACROSS), TOP + row * (HIGH + DOWN)
        axes = style.place(figure, left, top, wide, HIGH)
        _panel(axes, [m for m in drawn if m.case == name], words, limits)
        axes.set_xlabel("time of a run (s)" if k + COLUMNS >= len(titles) else "")
        axes.set_ylabel("largest error (turns)" if column == 0 else "")
        if column:
            axes.set_yticklabels([])
    _legend(figure, drawn, height)
    return figure


def _limits(drawn: Sequence[Measured]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ranges of time and error that all panels share."""
    times = [m.seconds for m in drawn] or [1e-4, 1.0]
    errors = [max(m.error, FLOOR) for m in drawn] or [FLOOR, 1.0]
    return (min(times) / 2.0, max(times) * 2.0), (min(errors) / 4.0, max(1.0, max(errors)) * 3.0)


def _panel(axes: Axes, found: Sequence[Measured], title: str, limits) -> None:
    axes.set(xscale="log", yscale="log", xlim=limits[0], ylim=limits[1])
    axes.set_title(title, size=8, loc="left", pad=4)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_major_locator(LogLocator(base=1e4, numticks=8))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.grid(True, color=style.CAM_BODY, linewidth=0.5, zorder=0)
    for method in dict.fromkeys(m.method for m in found):
        own = [m for m in found if m.method == method]
        for limited in (False, True):
            some = [m for m in own if (LIMITED in m.setting) == limited]
            _points(axes, method, some, limited)
    if not found:
        style.note(axes, "no point measured")


def _points(axes: Axes, method: str, some: Sequence[Measured], limited: bool) -> None:
    """The settings of a method joined, and a mark on those that are not to be trusted."""
    if not some:
        return
    _, colour, shape = METHODS[method]
    order = 6 if method == "core" else 3
    x, y = [m.seconds for m in some], [max(m.error, FLOOR) for m in some]
    look: Look = {"marker": shape, "markersize": 4.0, "markeredgewidth": 0.7, "linewidth": 0.7}
    face = "white" if limited else colour
    dashes = (0, (3, 2)) if limited else "-"
    axes.plot(x, y, color=colour, markerfacecolor=face, linestyle=dashes, zorder=order, **look)
    for statuses, shape, size in MARKS:
        bad = [k for k, m in enumerate(some) if m.status in statuses]
        mark: Look = {"color": style.TROUBLE, "linestyle": "", "marker": shape, "markersize": size}
        axes.plot([x[k] for k in bad], [y[k] for k in bad], markeredgewidth=0.9, zorder=8, **mark)


def _legend(figure: Figure, drawn: Sequence[Measured], height: int) -> None:
    handles = []
    for method, (name, colour, shape) in METHODS.items():
        if any(m.method == method for m in drawn):
            look: Look = {"color": colour, "marker": shape, "markersize": 4.0}
            handles.append(Line2D([], [], linewidth=0.7, label=name, **look))
    hollow: Look = {
        "color": style.CAM,
        "marker": "s",
        "markersize": 4.0,
        "markerfacecolor": "white",
    }
    dashed = Line2D([], [], linewidth=0.7, linestyle=(0, (3, 2)), **hollow)
    dashed.set_label("steps of at most 1/16 turn")
    handles.append(dashed)
    told = [("x", "missed or invented impacts"), ("|", "given up, error until then")]
    if any(m.status == OVER for m in drawn):
        told.append(("*", "beyond the bound promised"))
    for shape, words in told:
        look = {"color": style.TROUBLE, "marker": shape, "markersize": 7.0, "linestyle": ""}
        handles.append(Line2D([], [], label=words, **look))
    at = (LEFT / style.WIDTH, 1.0 - 58 / height)
    layout = {"ncols": 4, "columnspacing": 1.6, "handletextpad": 0.6, "borderaxespad": 0.0}
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=at, **layout)


# --- extreme cases

FIRST, LAST, ROW = 120, 95, 62  # px: above the rows, below them, of one
BARS, WIDE = 860, 400  # px, left edge and width of the bars
TEXT = 42  # px, where the words begin
LONGEST = 74  # letters of a line
SHORTEST = 1e-4  # s, where the axis begins


@style.look()
def draw_stability(outcomes: Sequence[Outcome]) -> Figure:
    """Picture of the rows."""
    height = FIRST + ROW * len(outcomes) + LAST
    figure = style.page(height)
    good = sum(o.status == OK for o in outcomes)
    title = f"Extreme cases: {good} of {len(outcomes)} as expected"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    style.write(figure, 20, 54, "case and what is expected; below it what was observed")
    for k, outcome in enumerate(outcomes):
        _words(figure, FIRST + ROW * k, outcome)
    _bars(figure, outcomes)
    return figure


def _words(figure: Figure, top: int, outcome: Outcome) -> None:
    """Two lines: the case with what is expected, and what was observed."""
    colour = style.CAM if outcome.status == OK else style.TROUBLE
    mark = "●" if outcome.status == OK else "✗"
    style.write(figure, 18, top + 4, mark, size=7, color=colour)
    first = shorten(f"{outcome.case}: {outcome.expected}", LONGEST, placeholder=" …")
    style.write(figure, TEXT, top + 4, first, size=6.5)
    seen = shorten(outcome.observed or outcome.status, LONGEST + 6, placeholder=" …")
    style.write(figure, TEXT, top + 30, seen, size=6, color=style.CAM)


def _bars(figure: Figure, outcomes: Sequence[Outcome]) -> None:
    axes = style.place(figure, BARS, FIRST, WIDE, ROW * len(outcomes))
    times = [0.0 if isnan(o.seconds) else o.seconds for o in outcomes]  # nan: not reached
    seconds = [max(t, SHORTEST) for t in times]
    colours = [style.CAM if o.status == OK else style.TROUBLE for o in outcomes]
    axes.barh(range(len(outcomes)), seconds, height=0.55, color=colours, left=0.0)
    axes.set_xscale("log")
    axes.set(ylim=(len(outcomes) - 0.5, -0.5), xlim=(SHORTEST, 3.0 * max(seconds)))
    axes.set_yticks([])
    axes.set_xlabel("time of the row (s)")
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for k, value in enumerate(times):
        at = (max(value, SHORTEST), k)
        look: Look = {"textcoords": "offset points", "xytext": (3, 0), "va": "center", "size": 6}
        axes.annotate(f"{value:.2g}", at, **look)
