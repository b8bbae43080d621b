"""Pictures of the bench: error against time of every method, and the extreme cases."""

from collections.abc import Sequence
from functools import partial
from math import isfinite
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator

from camcli.analysis.bench.precision import GIVEN_UP, INVENTED, MISSED, OK, OVER, Measured, case
from camcli.analysis.bench.stability import RowOutcome
from camcli.plots import style
from camcli.plots.axes import DASHED, say
from camcli.plots.picture import Panel, Picture
from camcli.quantities import TIME, labelled
from camcli.words.bench import cases_title

ACROSS, HIGH = 3, 36.0  # panels side by side, mm of a panel
FLOOR = 1e-17  # error drawn for none at all
PER_CASE = 4.0  # mm of an extreme case
METHODS = {  # name, colour and mark
    "core": ("camcli", "black", "o"),
    "rk45": ("RK45", style.PERIODS[1], "s"),
    "dop853": ("DOP853", style.PERIODS[0], "D"),
    "lsoda": ("LSODA", style.MEASURED, "^"),
    "radau": ("Radau", style.LONGER, "v"),
    "heyoka": ("heyoka", style.PERIODS[2], "P"),
    "rk4": ("RK4, fixed steps", style.PERIODS[3], "h"),
}
MARKS = (  # statuses, mark, its size, and what it says
    ((MISSED, INVENTED), "x", 7.0, "missed or invented impacts"),
    ((GIVEN_UP,), "|", 9.0, "given up, error until then"),
    ((OVER,), "*", 9.0, "beyond the bound promised"),
)
LIMITED = "max_step"  # in a setting: drawn hollow
Look = dict[str, Any]


def draw_precision(found: Sequence[Measured]) -> Picture:
    """Picture of the points, a panel per case."""
    drawn = [m for m in found if isfinite(m.seconds) and isfinite(m.error)]
    panels = {
        name: Panel(partial(_draw_case, name=name, drawn=drawn), HIGH, across=ACROSS)
        for name in dict.fromkeys(m.case for m in found)
    }
    return Picture("Work and precision: error against time, lower left is better", panels)


def draw_stability(found: Sequence[RowOutcome]) -> Picture:
    """Picture of the extreme cases: a bar each, as long as it took."""
    failed = sum(row.status != OK for row in found)
    panel = Panel(partial(_draw_rows, found=found), PER_CASE * max(3, len(found)))
    return Picture(cases_title(len(found), failed), {"cases": panel})


def _draw_rows(axes: Axes, found: Sequence[RowOutcome]) -> None:
    """Bars from the first case down, those that failed in their own colour."""
    colours = [style.PERIODS[0] if row.status == OK else style.TROUBLE for row in found]
    axes.barh(range(len(found)), [row.seconds for row in found], 0.6, color=colours)
    axes.set_yticks(range(len(found)), [row.case for row in found])
    axes.set(xscale="log", xlabel=TIME.label, ylim=(len(found) - 0.4, -0.6))
    axes.grid(True, axis="x", color=style.CAM_BODY, linewidth=0.5, zorder=0)
    axes.set_axisbelow(True)


def _draw_case(axes: Axes, name: str, drawn: Sequence[Measured]) -> None:
    """The settings of each method joined, and a mark on those that are not to be trusted."""
    times = [m.seconds for m in drawn] or [1e-4, 1.0]
    errors = [max(m.error, FLOOR) for m in drawn] or [FLOOR, 1.0]
    axes.set(xscale="log", yscale="log", xlim=(min(times) / 2.0, max(times) * 2.0))
    axes.set_ylim(min(errors) / 4.0, max(1.0, *errors) * 3.0)
    axes.set_title(case(name).title, loc="left")
    axes.set(xlabel=labelled("time of a run", TIME.unit), ylabel=labelled("largest error", "turns"))
    axes.xaxis.set_major_locator(LogLocator(base=100.0, numticks=8))
    axes.yaxis.set_major_locator(LogLocator(base=1e4, numticks=8))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.grid(True, color=style.CAM_BODY, linewidth=0.5, zorder=0)
    found = [m for m in drawn if m.case == name]
    if not found:
        say(axes, "no point measured")
    for method, limited in dict.fromkeys((m.method, LIMITED in m.setting) for m in found):
        some = [m for m in found if (m.method, LIMITED in m.setting) == (method, limited)]
        name, colour, shape = METHODS[method]
        x, y = [m.seconds for m in some], [max(m.error, FLOOR) for m in some]
        order = 6 if method == "core" else 3
        look: Look = {"ms": 4.0, "mew": 0.7, "lw": 0.7, "zorder": order}
        (line,) = axes.plot(x, y, color=colour, marker=shape, label=name, **look)
        if limited:
            line.set(markerfacecolor="white", linestyle=DASHED)
            line.set_label(f"{name}, steps of at most 1/16 turn")
        for statuses, sign, size, words in MARKS:
            bad = [k for k, m in enumerate(some) if m.status in statuses]
            if bad:
                at = [x[k] for k in bad], [y[k] for k in bad]
                look = {"color": style.TROUBLE, "ls": "", "mew": 0.9, "ms": size, "zorder": 8}
                axes.plot(*at, marker=sign, label=words, **look)
