"""Picture of the extreme cases: what is expected, what was observed, and the time of each row."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from textwrap import shorten

from matplotlib.figure import Figure

from camcli.analysis.bench.row import OK, Outcome
from camcli.plots import style

TOP, BOTTOM, ROW = 120, 95, 62  # px
LEFT, WIDE = 860, 400  # px, of the bars
TEXT = 42  # px, where the words begin
LONGEST = 74  # letters of a line
SHORTEST = 1e-4  # s, where the axis begins


@style.look()
def draw_stability(outcomes: Sequence[Outcome]) -> Figure:
    """Picture of the rows."""
    height = TOP + ROW * len(outcomes) + BOTTOM
    figure = style.page(height)
    good = sum(o.status == OK for o in outcomes)
    title = f"Extreme cases: {good} of {len(outcomes)} as expected"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    style.write(figure, 20, 54, "case and what is expected; below it what was observed")
    for k, outcome in enumerate(outcomes):
        _words(figure, TOP + ROW * k, outcome)
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
    axes = style.place(figure, LEFT, TOP, WIDE, ROW * len(outcomes))
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
        look = {"textcoords": "offset points", "xytext": (3, 0), "va": "center", "size": 6}
        axes.annotate(f"{value:.2g}", at, **look)
