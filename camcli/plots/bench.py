"""Pictures of the bench: error against time, extreme cases, published numbers beside ours."""

import textwrap
from collections.abc import Sequence
from decimal import Decimal
from functools import partial
from itertools import accumulate, pairwise
from math import isfinite
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, NullLocator

from camcli.analysis.bench.precision import GIVEN_UP, INVENTED, MISSED, OK, OVER, Measured, case
from camcli.analysis.bench.stability import RowOutcome
from camcli.analysis.bench.validation import FAILED, MISPRINT, ValidationRow
from camcli.plots import style
from camcli.plots.axes import DASHED, DOTTED, say
from camcli.plots.picture import Panel, Picture
from camcli.quantities import MM_PER_INCH, TIME, labelled
from camcli.words.bench import cases_title, in_seconds, validation_title

ACROSS, HIGH = 3, 36.0  # panels side by side, mm of a panel
SLIM, SLIM_TITLE = 35.0, 15  # mm of a panel of three in a journal's column, letters of a line there
NARROW, MOST_TITLE = 55.0, 26  # mm of a panel that is as wide as so many letters of its title
FLOOR = 1e-17  # error drawn for none at all
LEAST_SIZE = 1e-300  # of a published number, so that a share of zero can be told
PER_CASE, FOLDED = 4.6, 1.6  # mm of an extreme case; times as high, with a name in two lines
LONGEST_NAME = 30  # letters of its name in one line of a narrow page
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
    """Marks from the first case down with the time beside them, every other row shaded.

    A row is 1 high, or FOLDED where its name takes two lines.
    """
    narrow = axes.get_window_extent().width < 1.5 * NARROW / MM_PER_INCH * style.DPI
    names = [_case_name(row.case, narrow) for row in found]
    heights = [FOLDED if NEW_LINE in name else 1.0 for name in names]
    ends = list(accumulate(heights, initial=-0.5))
    rows = list(pairwise(ends))
    middles = [0.5 * (top + bottom) for top, bottom in rows]
    axes.set(xscale="log", xlabel=TIME.label, ylim=(ends[-1] + 0.1, -0.6))
    seconds = [max(row.seconds, SHORTEST) for row in found]
    axes.set_xlim(0.4 * min(seconds), AFTER * max(seconds))
    for top, bottom in rows[1::2]:
        axes.axhspan(top, bottom, color=style.CAM_BODY, linewidth=0.0, zorder=0)
    for passed, (mark, colour, words) in VERDICTS.items():
        some = [k for k, row in enumerate(found) if (row.status == OK) == passed]
        if some:
            look: Look = {"ls": "", "marker": mark, "color": colour, "ms": 4.5, "mew": 0.0}
            places = [middles[k] for k in some]
            name = words if len(some) < len(found) else None  # of all the title says it
            axes.plot([seconds[k] for k in some], places, label=name, zorder=4, **look)
    for k, (value, middle) in enumerate(zip(seconds, middles, strict=True)):
        shade = style.CAM_BODY if k % 2 else "white"
        axes.annotate(
            in_seconds(value), (value, middle), (5, 0), textcoords="offset points",
            va="center_baseline", size=style.NOTE, color=style.CAM,
            path_effects=[withStroke(linewidth=2.0, foreground=shade)],
        )  # fmt: skip
    axes.set_yticks(middles, names, size=style.NOTE)
    for text in axes.get_yticklabels():
        text.set_linespacing(1.0)
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
    """For every number its bound, a bar's end, and how far ours is off, a mark; problems named.

    All are shares of the published number, and at least FLOOR, where the axis begins.
    """
    problems = list(dict.fromkeys(row.problem for row in found))
    ordered = [row for name in problems for row in found if row.problem == name]
    bounds = [_share(row.bound, row) for row in ordered]
    bars = axes.barh(range(len(ordered)), bounds, 0.75, left=FLOOR, color=style.CAM_BODY, zorder=1)
    for bar in bars.patches[:1]:  # one for all in the legend
        bar.set_label("half a last published digit and our error")
    looks = (
        (OK, "o", style.PERIODS[0], "ours less published"),
        (MISPRINT, "D", style.MEASURED, "the same, published less exactly than printed"),
        (FAILED, "x", style.TROUBLE, "the same, not reproduced"),
    )
    mark: Look = {"ls": "", "ms": 3.0, "zorder": 4}
    for status, shape, colour, words in looks:
        some = [k for k, row in enumerate(ordered) if row.status == status]
        if some:
            x = [_share(ordered[k].difference, ordered[k]) for k in some]
            axes.plot(x, some, marker=shape, color=colour, label=words, **mark)
    misprints = [k for k, row in enumerate(ordered) if row.status == MISPRINT]
    if misprints:
        x = [_share(_off(ordered[k]), ordered[k]) for k in misprints]
        hollow: Look = {**mark, "marker": "D", "mew": 0.7, "mfc": "white", "color": style.MEASURED}
        axes.plot(x, misprints, label="ours less independent", **hollow)
    middles = []
    for name in problems:
        rows = [k for k, row in enumerate(ordered) if row.problem == name]
        middles.append(0.5 * (rows[0] + rows[-1]))
        if rows[0] > 0:
            axes.axhline(rows[0] - 0.5, color=style.GUIDE, linewidth=0.4, zorder=0)
    axes.set_yticks(middles, problems)
    axes.tick_params(axis="y", length=0)
    axes.set(xscale="log", xlabel="off, as a share of the number\n(left edge: not at all)")
    axes.set(xlim=(FLOOR, 10.0), ylim=(len(ordered) - 0.4, -0.6))
    axes.xaxis.set_major_locator(LogLocator(base=1e4, numticks=12))
    axes.xaxis.set_minor_locator(NullLocator())


def _share(difference: float, row: ValidationRow) -> float:
    """The size of a difference as a share of the published number, at least FLOOR."""
    size = max(abs(float(row.published)), LEAST_SIZE)
    return max(abs(difference) / size, FLOOR)


def _off(row: ValidationRow) -> float:
    """Ours less the independent value."""
    return float(Decimal(row.ours) - Decimal(row.independent))


def _draw_case(axes: Axes, name: str, drawn: Sequence[Measured]) -> None:
    """The settings of each method joined, and a mark on those that are not to be trusted."""
    _ranges(axes, drawn)
    _name_case(axes, name)
    found = [point for point in drawn if point.case == name]
    if not found:
        say(axes, "no point measured")
    lines: dict[tuple[str, bool], list[Measured]] = {}
    for point in found:
        lines.setdefault((point.method, LIMITED in point.setting), []).append(point)
    for (method, limited), points in lines.items():
        words, colour, shape = METHODS[method]
        look: Look = {"color": colour, "marker": shape, "ms": 4.0, "mew": 0.7, "lw": 0.7}
        look["zorder"] = 6 if method == "core" else 3
        look["label"] = words
        if limited:
            look |= {"mfc": "white", "ls": DASHED, "label": "_"}
        axes.plot(*_times_and_errors(points), **look)
    if any(limited for _, limited in lines):
        look = {"marker": "o", "ms": 4.0, "mew": 0.7, "lw": 0.7, "mfc": "white", "ls": DASHED}
        axes.plot([], [], color=style.CAM, label="hollow: steps of at most 1/16 turn", **look)
    for statuses, sign, size, words in MARKS:  # after the methods, in the legend too
        bad = [point for point in found if point.status in statuses]
        if bad:
            look = {"color": style.TROUBLE, "ls": "", "mew": 0.9, "ms": size, "zorder": 8}
            axes.plot(*_times_and_errors(bad), marker=sign, label=words, **look)


def _times_and_errors(points: Sequence[Measured]) -> tuple[list[float], list[float]]:
    """(s, turns) of points; an error of none at all is drawn as FLOOR."""
    times = [point.seconds for point in points]
    errors = [max(point.error, FLOOR) for point in points]
    return times, errors


def _ranges(axes: Axes, drawn: Sequence[Measured]) -> None:
    """Logarithmic axes of time and error that hold the points of all cases."""
    times, errors = _times_and_errors(drawn)
    if not drawn:
        times, errors = [1e-4, 1.0], [FLOOR, 1.0]
    axes.set(xscale="log", yscale="log", xlim=(min(times) / 2.0, max(times) * 2.0))
    axes.set_ylim(min(errors) / 4.0, max(1.0, *errors) * 3.0)
    axes.xaxis.set_major_locator(LogLocator(base=100.0, numticks=8))
    axes.yaxis.set_major_locator(LogLocator(base=1e4, numticks=8))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
    axes.grid(True, color=style.CAM_BODY, linewidth=0.5, zorder=0)


def _name_case(axes: Axes, name: str) -> None:
    """The title of a case and the names of both axes, shorter in a narrow panel."""
    wide = axes.get_window_extent().width / style.DPI * MM_PER_INCH  # mm
    title = case(name).title
    time = "time of a run"
    if wide < SLIM:
        letter = "(a) "  # stands before it
        title = textwrap.fill(letter + title, SLIM_TITLE).removeprefix(letter)
        time = TIME.name
    elif len(title) > MOST_TITLE and wide < NARROW:
        title = title.replace(" at ", "," + NEW_LINE)
    axes.set_title(title, loc="left")
    axes.set(xlabel=labelled(time, TIME.unit), ylabel=labelled("error", "turns"))
