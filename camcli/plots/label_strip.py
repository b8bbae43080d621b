"""The strip of labels below a picture over speed: coloured by period, named where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise

from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from camcli.analysis.classify import Motion
from camcli.analysis.labels import APERIODIC, CONTACT, UNDECIDED
from camcli.plots import style
from camcli.plots.axes import text_rows

KEY, ROW = 46, 120  # px: the key above the strip, the strip
OTHERS = {APERIODIC: style.APERIODIC, UNDECIDED: style.UNDECIDED, CONTACT: style.CONTACT}
LOWEST, EDGE = 26.0, 12.0  # px: a rectangle that holds text, room left beside the text
BRIGHT = 0.45  # luminance from which text is black

Box = tuple[float, float, float, float]  # left, bottom, width, height


def strip_colour(motion: Motion) -> str:
    """By period, or by what is not periodic."""
    return OTHERS.get(motion.label) or style.period_colour(motion.period)


def rests(motion: Motion) -> bool:
    """True for a solved orbit that leaves the cam and rests on it."""
    return motion.orbit is not None and motion.orbit.resting and bool(motion.orbit.theta)


def draw_swatches(
    figure: Figure, left: float, top: float, entries: Sequence[tuple[str, bool, str]]
) -> None:
    """A row of coloured squares, hatched or not, each with its words: (colour, hatched, words)."""
    axes = text_rows(figure, top, 1)
    for colour, hatched, words in entries:
        _rectangle(axes, (left, 6.0, 18.0, 18.0), colour, hatched, 0.4)
        text = axes.text(left + 28, 0.5 * style.LINE, words, va="center_baseline")
        left += 28 + text.get_window_extent().width + 30


def draw_strip_key(figure: Figure, left: float, top: float, motions: Sequence[Motion]) -> None:
    """What the colours of the strip mean, those that are there."""
    periods = sorted({m.period for m in motions if m.period and m.label not in OTHERS})
    own = [m for m in periods if m <= len(style.PERIODS)]
    entries = [
        (style.period_colour(m), False, f"period {m}" if m == own[0] else str(m)) for m in own
    ]
    if len(own) < len(periods):
        entries.append((style.LONGER, False, "longer" if own else "longer period"))
    labels = {motion.label for motion in motions}
    entries += [(colour, False, name) for name, colour in OTHERS.items() if name in labels]
    if any(map(rests, motions)):
        entries.append((style.CAM, True, "hatched: rests on the cam"))
    draw_swatches(figure, left, top, entries)


def draw_strip(axes: Axes, motions: Sequence[Motion], x: Sequence[float]) -> None:
    """Rectangles over the range that the axes have; several motions of a speed on one another."""
    low, high = axes.get_xlim()
    axes.set(ylim=(0.0, 1.0), yticks=[], ylabel="label")
    at = sorted(set(x))
    edges = [low, *((a + b) / 2.0 for a, b in pairwise(at)), high]
    groups = [[m for m, place in zip(motions, x, strict=True) if place == here] for here in at]
    index = 0
    for _, alike in groupby(groups, lambda group: [(m.label, rests(m)) for m in group]):
        members = list(alike)
        begin, end = edges[index], edges[index + len(members)]
        index += len(members)
        height = 1.0 / len(members[0])
        for row, motion in enumerate(members[0]):
            box = (begin, 1.0 - (row + 1) * height, end - begin, height)
            _rectangle(axes, box, strip_colour(motion), rests(motion))
            _name(axes, motion, box)


def _rectangle(axes: Axes, box: Box, colour: str, hatched: bool, edge: float = 0.0) -> None:
    place = box[:2], box[2], box[3]
    axes.add_patch(Rectangle(*place, facecolor=colour, edgecolor=style.CAM, linewidth=edge))
    if hatched:
        lines = Rectangle(*place, facecolor="none", edgecolor="white", linewidth=0.0, hatch="////")
        axes.add_patch(lines)


def _name(axes: Axes, motion: Motion, box: Box) -> None:
    """The label, else the period, in the middle of a rectangle where there is room."""
    (left, bottom, width, height), frame = box, axes.get_window_extent()
    low, high = axes.get_xlim()
    if height * frame.height < LOWEST:
        return
    colour = strip_colour(motion)
    light = sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), to_rgb(colour), strict=True))
    names = [motion.label.replace("inf", "∞")]
    if motion.label not in OTHERS:
        names += [f"period {motion.period}", str(motion.period)]
    text = axes.text(
        left + 0.5 * width,
        bottom + 0.5 * height,
        "",
        size=7,
        ha="center",
        va="center_baseline",
        color="black" if light > BRIGHT else "white",
        bbox={"facecolor": colour, "edgecolor": "none", "pad": 1.0} if rests(motion) else None,
    )
    for name in names:
        text.set_text(name)
        if text.get_window_extent().width + EDGE <= width * frame.width / (high - low):
            return
    text.remove()
