"""Pictures of the bench: error against time, extreme cases, published numbers beside ours."""

import textwrap
from collections.abc import Sequence
from decimal import Decimal
from functools import partial
from math import isfinite
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator

from camcli.analysis.bench.precision import GIVEN_UP, INVENTED, MISSED, OK, OVER, Measured, case
from camcli.analysis.bench.stability import RowOutcome
from camcli.analysis.bench.validation import FAILED, MISPRINT, ValidationRow
from camcli.plots import style
from camcli.plots.axes import DASHED, DOTTED, say
from camcli.plots.picture import Panel, Picture
from camcli.quantities import TIME, labelled
from camcli.words.bench import cases_title, in_seconds, validation_title

ACROSS, HIGH = 3, 36.0  # panels side by side, mm of a panel
SLIM, SLIM_TITLE = 35.0, 15  # mm of a panel of three in a journal's column, letters of a line there
NARROW, MOST_TITLE = 55.0, 26  # mm of a panel that is as wide as so many letters of its title
FLOOR = 1e-17  # error drawn for none at all
PER_CASE = 4.6  # mm of an extreme case
LONGEST_NAME, SMALLER = 30, 6.0  # letters of its name on a narrow page; pt, of a name in two lines
SHORTEST, AFTER = 1e-5, 12.0  # s, of a case; the axis of time ends so many times after the longest
NEW_LINE = "\n"
VERDICTS = {  # whether a case came out as expected: mark, colour, words
    True: ("o", style.PERIODS[0], "as expected"),
    False: ("X", style.TROUBLE, "not as expected"),
}
METHODS = {  # name, colour and mark
    "core": ("camcli", "black", "o"),
    "rk45": ("RK45", style.PERIODS[1], "s"),
    "dop853": ("DOP853", style.PERIODS[0], "D"),
    "lsoda": ("LSODA", style.MEASURED, "^"),
    "radau": ("Radau", style.LONGER, "v"),
    "heyoka": ("heyoka", style.PERIODS[2], "P"),
    "rk4": ("RK4, fixed steps", style.DETACHMENT, "h"),
}
MARKS = (  # statuses, mark, its size, and what it says
    ((MISSED, INVENTED), "x", 7.0, "missed or invented impacts"),
    ((GIVEN_UP,), "|", 9.0, "given up, error until then"),
    ((OVER,), "*", 9.0, "beyond the bound promised"),
)
PER_NUMBER, LEAST = 1.9, 40.0  # mm of a published number, of all of them
LIMITED = "max_step"  # in a setting: drawn hollow
Look = dict[str, Any]


def draw_precision(found: Sequence[Measured]) -> Picture:
    """Picture of the points, a panel per case."""
    drawn = [m for m in found if isfinite(m.seconds) and isfinite(m.error)]
    panels = {
        name: Panel(
            partial(_draw_case, name=name, drawn=drawn), HIGH, "time", across=ACROSS, y="error"
        )
        for name in dict.fromkeys(m.case for m in found)
    }
    return Picture("Work and precision: error against time, lower left is better", panels)


def draw_stability(found: Sequence[RowOutcome]) -> Picture:
    """Picture of the extreme cases: a mark each, at how long it took."""
    failed = sum(row.status != OK for row in found)
    panel = Panel(partial(_draw_rows, found=found), PER_CASE * max(3, len(found)))
    return Picture(cases_title(len(found), failed), {"cases": panel})


def _draw_rows(axes: Axes, found: Sequence[RowOutcome]) -> None:
    """Marks from the first case down with the time beside them, every other row shaded."""
    axes.set(xscale="log", xlabel=TIME.label, ylim=(len(found) - 0.4, -0.6))
    seconds = [max(row.seconds, SHORTEST) for row in found]
    axes.set_xlim(0.4 * min(seconds), AFTER * max(seconds))
    for k in range(1, len(found), 2):
        axes.axhspan(k - 0.5, k + 0.5, color=style.CAM_BODY, linewidth=0.0, zorder=0)
    for passed, (mark, colour, words) in VERDICTS.items():
        some = [k for k, row in enumerate(found) if (row.status == OK) == passed]
        if some:
            look: Look = {"ls": "", "marker": mark, "color": colour, "ms": 4.5, "mew": 0.0}
            axes.plot([seconds[k] for k in some], some, label=words, zorder=4, **look)
    for k, value in enumerate(seconds):
        axes.annotate(
            in_seconds(value), (value, k), (5, 0), textcoords="offset points", va="center_baseline",
            size=style.NOTE, color=style.CAM,
        )  # fmt: skip
    narrow = axes.get_window_extent().width < 1.5 * NARROW / 25.4 * style.DPI
    names = [_case_name(row.case, narrow) for row in found]
    axes.set_yticks(range(len(found)), names, size=style.NOTE)
    for name, text in zip(names, axes.get_yticklabels(), strict=True):
        text.set(linespacing=0.9, size=SMALLER if NEW_LINE in name else style.NOTE)
    axes.tick_params(axis="y", length=0.0)
    axes.xaxis.set_major_locator(LogLocator(base=10.0 ** (2 if narrow else 1), numticks=12))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.grid(True, axis="x", color=style.GUIDE, linewidth=0.4, linestyle=DOTTED, zorder=1)


def _case_name(case: str, narrow: bool) -> str:
    """The name of an extreme case, in two lines where it takes too much of a narrow page."""
    name = case.replace("+-", "±").replace("^n", "ⁿ")
    return textwrap.fill(name, len(name) // 2 + 4) if narrow and len(name) > LONGEST_NAME else name


def draw_validation(found: Sequence[ValidationRow]) -> Picture:
    """Picture of the published numbers: a line each, by problem."""
    failed = sum(row.status == FAILED for row in found)
    panel = Panel(partial(_draw_numbers, found=found), max(LEAST, PER_NUMBER * len(found)))
    return Picture(validation_title(found, failed), {"numbers": panel})


def _draw_numbers(axes: Axes, found: Sequence[ValidationRow]) -> None:
    """For every number its bound, a bar's end, and how far ours is off, a mark; problems named."""
    rows = sorted(enumerate(found), key=lambda pair: (_first(found, pair[1].problem), pair[0]))
    ordered = [row for _, row in rows]
    sizes = [max(abs(float(row.published)), 1e-300) for row in ordered]
    at = range(len(ordered))
    bounds = [max(row.bound / size, FLOOR) for row, size in zip(ordered, sizes, strict=True)]
    bars = axes.barh(at, bounds, 0.75, left=FLOOR, color=style.CAM_BODY, zorder=1)
    for bar in bars.patches[:1]:  # one for all in the legend
        bar.set_label("half a last published digit and our error")
    looks = (
        (OK, "o", style.PERIODS[0], "ours less published"),
        (MISPRINT, "D", style.MEASURED, "the same, published less exactly than printed"),
        (FAILED, "x", style.TROUBLE, "the same, not reproduced"),
    )
    for status, mark, colour, words in looks:
        some = [k for k in at if ordered[k].status == status]
        if some:
            x = [max(abs(ordered[k].difference) / sizes[k], FLOOR) for k in some]
            axes.plot(x, some, ls="", marker=mark, color=colour, ms=3.0, zorder=4, label=words)
    wrong = [k for k in at if ordered[k].status == MISPRINT]
    if wrong:
        x = [max(abs(_off(ordered[k])) / sizes[k], FLOOR) for k in wrong]
        look: Look = {"ls": "", "marker": "D", "ms": 3.0, "mew": 0.7, "zorder": 4}
        axes.plot(
            x, wrong, color=style.MEASURED, mfc="white", label="ours less independent", **look
        )
    names = list(dict.fromkeys(row.problem for row in ordered))
    spans = [[k for k in at if ordered[k].problem == name] for name in names]
    for span in spans[1:]:
        axes.axhline(span[0] - 0.5, color=style.GUIDE, linewidth=0.4, zorder=0)
    axes.set_yticks([0.5 * (span[0] + span[-1]) for span in spans], names)
    axes.tick_params(axis="y", length=0)
    axes.set(xscale="log", xlabel="off, as a share of the number")
    axes.set(xlim=(FLOOR, 10.0), ylim=(len(ordered) - 0.4, -0.6))
    axes.xaxis.set_major_locator(LogLocator(base=1e4, numticks=12))
    axes.xaxis.set_minor_locator(NullLocator())


def _first(found: Sequence[ValidationRow], problem: str) -> int:
    """The place of the first row of a problem."""
    return next(k for k, row in enumerate(found) if row.problem == problem)


def _off(row: ValidationRow) -> float:
    """Ours less the independent value."""
    return float(Decimal(row.ours) - Decimal(row.independent))


def _draw_case(axes: Axes, name: str, drawn: Sequence[Measured]) -> None:
    """The settings of each method joined, and a mark on those that are not to be trusted."""
    times = [m.seconds for m in drawn] or [1e-4, 1.0]
    errors = [max(m.error, FLOOR) for m in drawn] or [FLOOR, 1.0]
    axes.set(xscale="log", yscale="log", xlim=(min(times) / 2.0, max(times) * 2.0))
    axes.set_ylim(min(errors) / 4.0, max(1.0, *errors) * 3.0)
    title = case(name).title
    time = "time of a run"
    if axes.get_window_extent().width < SLIM / 25.4 * style.DPI:
        letter = "(a) "  # stands before it
        title = textwrap.fill(letter + title, SLIM_TITLE).removeprefix(letter)
        time = TIME.name
    elif len(title) > MOST_TITLE and axes.get_window_extent().width < NARROW / 25.4 * style.DPI:
        title = title.replace(" at ", "\n")
    axes.set_title(title, loc="left")
    axes.set(xlabel=labelled(time, TIME.unit), ylabel=labelled("error", "turns"))
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
            line.set(markerfacecolor="white", linestyle=DASHED, label="_")
    if any(LIMITED in m.setting for m in found):
        look = {"marker": "o", "ms": 4.0, "mew": 0.7, "lw": 0.7, "mfc": "white", "ls": DASHED}
        axes.plot([], [], color=style.CAM, label="hollow: steps of at most 1/16 turn", **look)
    for statuses, sign, size, words in MARKS:  # after the methods, in the legend too
        bad = [m for m in found if m.status in statuses]
        if bad:
            at = [m.seconds for m in bad], [max(m.error, FLOOR) for m in bad]
            look = {"color": style.TROUBLE, "ls": "", "mew": 0.9, "ms": size, "zorder": 8}
            axes.plot(*at, marker=sign, label=words, **look)
