"""The strip of labels below a picture over speed: coloured by period, named where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise

from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from camcli.analysis.classify import APERIODIC, Motion
from camcli.plots import style

KEY, ROW = 46, 120  # px: the key above the strip, the strip
OTHERS = {APERIODIC: style.APERIODIC, "undecided": style.UNDECIDED, "contact": style.CONTACT}
LOWEST, EDGE = 26.0, 12.0  # px: a rectangle that holds text, room left beside the text
BRIGHT = 0.45  # luminance from which text is black


def strip_colour(motion: Motion) -> str:
    """By period, or by what is not periodic."""
    if motion.label in OTHERS:
        return OTHERS[motion.label]
    return style.period_colour(motion.period)


def rests(motion: Motion) -> bool:
    """True for a solved orbit that leaves the cam and rests on it."""
    return motion.orbit is not None and motion.orbit.resting and bool(motion.orbit.theta)


def swatches(figure: Figure, left: float, top: float, entries: Sequence[tuple]) -> None:
    """A row of coloured squares (hatched or not), each with its words: (colour, hatch, words)."""
    axes = style.place(figure, 0, top, style.WIDTH, style.LINE, frame_on=False)
    axes.set(xlim=(0, style.WIDTH), ylim=(0, style.LINE), xticks=[], yticks=[])
    for colour, hatch, words in entries:
        look = {"facecolor": colour, "linewidth": 0.4, "edgecolor": style.CAM}
        axes.add_patch(Rectangle((left, 6), 18, 18, **look))
        if hatch:
            _hatch(axes, (left, 6, 18, 18))
        text = axes.text(left + 28, 0.5 * style.LINE, words, va="center_baseline")
        left += 28 + text.get_window_extent().width + 30


def draw_key(figure: Figure, left: float, top: float, motions: Sequence[Motion]) -> None:
    """What the colours of the strip mean, those that are there."""
    periods = sorted({m.period for m in motions if m.period and m.label not in OTHERS})
    own = [m for m in periods if m <= len(style.PERIODS)]
    entries = [(style.period_colour(m), False, f"period {m}") for m in own]
    entries += [(style.LONGER, False, "longer")] if len(own) < len(periods) else []
    entries = [(c, h, w.removeprefix("period ") if k else w) for k, (c, h, w) in enumerate(entries)]
    labels = {m.label for m in motions}
    entries += [(colour, False, name) for name, colour in OTHERS.items() if name in labels]
    if any(map(rests, motions)):
        entries.append((style.CAM, True, "hatched: rests on the cam"))
    swatches(figure, left, top, entries)


def draw_strip(axes: Axes, motions: Sequence[Motion], x: Sequence[float]) -> None:
    """Rectangles over the range that the axes have; several motions of a speed on one another."""
    low, high = axes.get_xlim()
    axes.set(ylim=(0.0, 1.0), yticks=[])
    axes.set_ylabel("label")
    scale = axes.get_window_extent().width / (high - low)
    at = sorted(set(x))
    edges = [low, *((a + b) / 2.0 for a, b in pairwise(at)), high]
    groups = [[m for m, place in zip(motions, x, strict=True) if place == here] for here in at]
    index = 0
    for _, run in groupby(groups, lambda group: [_same(m) for m in group]):
        run = list(run)
        begin, end = edges[index], edges[index + len(run)]
        index += len(run)
        for row, motion in enumerate(run[0]):
            height = 1.0 / len(run[0])
            box = (begin, 1.0 - (row + 1) * height, end - begin, height)
            _rectangle(axes, motion, box)
            _name(axes, motion, box, scale)


def _same(motion: Motion) -> tuple:
    return motion.label, rests(motion)


def _rectangle(axes: Axes, motion: Motion, box) -> None:
    look = {"facecolor": strip_colour(motion), "linewidth": 0.0}
    axes.add_patch(Rectangle(box[:2], *box[2:], **look))
    if rests(motion):
        _hatch(axes, box)


def _hatch(axes: Axes, box) -> None:
    look = {"facecolor": "none", "edgecolor": "white", "linewidth": 0.0, "hatch": "////"}
    axes.add_patch(Rectangle(box[:2], *box[2:], **look))


def _name(axes: Axes, motion: Motion, box, scale: float) -> None:
    """The label, else the period, in the middle of a rectangle where there is room."""
    left, bottom, width, height = box
    if height * axes.get_window_extent().height < LOWEST:
        return
    colour = strip_colour(motion)
    light = sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), to_rgb(colour), strict=True))
    names = [motion.label.replace("inf", "∞")]
    if motion.label not in OTHERS:
        names += [f"period {motion.period}", str(motion.period)]
    patch = {"facecolor": colour, "edgecolor": "none", "pad": 1.0} if rests(motion) else None
    look = {"size": 7, "ha": "center", "va": "center_baseline", "bbox": patch}
    look["color"] = "black" if light > BRIGHT else "white"
    text = axes.text(left + 0.5 * width, bottom + 0.5 * height, "", **look)
    for name in names:
        text.set_text(name)
        if text.get_window_extent().width + EDGE <= width * scale:
            return
    text.remove()
