"""Picture of chaos proved: boxes of impacts, and how the image of one covers another."""

from __future__ import annotations

from functools import partial
from math import degrees

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle
from matplotlib.patheffects import withStroke

from camcli.analysis.chaos.section import Chaos, ChaosView
from camcli.plots import style
from camcli.plots.axes import padded, say
from camcli.plots.picture import Panel, Picture
from camcli.quantities import THETA, U_PLUS
from camcli.system import omega_of
from camcli.words.chaos import chaos_caption, chaos_title

SECTION, COVERINGS = 95.0, 55.0  # mm, heights of the panels
NEAR = 3.0  # half widths of a covered box, beyond which its image is not drawn
PALER = 0.75  # share of white in the colour that fills a box
APART = 2.0 * NEAR + 1.0  # between two of them


def draw_chaos(chaos: Chaos, view: ChaosView) -> Picture:
    """Boxes in the section of phase and outgoing velocity, and each covering in coordinates.

    view: impacts of a simulation, the outlines of the boxes and their images.
    """
    panels = {
        "boxes": Panel(partial(_draw_boxes, chaos=chaos, view=view), SECTION),
        "coverings": Panel(partial(_draw_coverings, chaos=chaos, view=view), COVERINGS),
    }
    return Picture(chaos_title(chaos), panels, caption=chaos_caption(chaos))


def _shades(chaos: Chaos) -> list[str]:
    """A colour for each box."""
    return style.apart([style.period_colour(k % 4 + 1) for k in range(len(chaos.boxes))])


def _shown(points: np.ndarray, rpm: float) -> tuple[np.ndarray, np.ndarray]:
    """(phases in deg, rates in m/s) of points (theta, v)."""
    return np.degrees(points[0]), points[1] * omega_of(rpm)


def _draw_boxes(axes: Axes, chaos: Chaos, view: ChaosView) -> None:
    """The boxes with their numbers, their images as outlines, and simulated impacts over them."""
    x, y = _shown(view.impacts, chaos.rpm)
    axes.plot(x, y, ".", color=style.CAM, ms=3.0, mew=0.0, zorder=4, label="simulated impacts")
    if not chaos.boxes:
        say(axes, "no boxes were found")
    for number, (box, colour) in enumerate(zip(chaos.boxes, _shades(chaos), strict=True)):
        outline = np.column_stack(_shown(view.outlines[number], chaos.rpm))
        paler = style.mixed(colour, PALER)
        axes.add_patch(Polygon(outline, fc=paler, ec=paler, linewidth=0.8, zorder=2))
        axes.plot(*_shown(view.images[number], chaos.rpm), color=colour, linewidth=0.8, zorder=3)
        at = degrees(box.middle[0]), box.middle[1] * omega_of(chaos.rpm)
        axes.annotate(
            str(number + 1), at, ha="center", va="center", fontsize=style.NOTE, zorder=5,
            path_effects=[withStroke(linewidth=2.0, foreground="white")],
        )  # fmt: skip
    if chaos.boxes:
        _name(axes)
    places = [*view.outlines, *view.images] or [view.impacts]
    every = np.concatenate([np.array(_shown(points, chaos.rpm)) for points in places], axis=1)
    axes.set(xlabel=THETA.label, ylabel=U_PLUS.label)
    axes.set(xlim=padded(every[0]), ylim=padded(every[1]))


def _name(axes: Axes) -> None:
    """The legend's words for boxes and images, in a grey that stands for the colours of all."""
    axes.plot([], [], "s", color=style.mixed(style.CAM, PALER), ms=5, label="boxes (filled)")
    axes.plot([], [], color=style.CAM, linewidth=0.8, label="images: where flights land (outline)")


def _draw_coverings(axes: Axes, chaos: Chaos, view: ChaosView) -> None:
    """The image of a box in the coordinates of each box that it covers, which is a square there."""
    shades = _shades(chaos)
    for k, (i, j) in enumerate(chaos.coverings):
        middle = k * APART
        left, right = middle - 1.0, middle + 1.0
        square = [(left, -1.0), (right, -1.0), (right, 1.0), (left, 1.0)]
        axes.add_patch(Polygon(square, fc=style.mixed(shades[j], PALER), ec=shades[j], zorder=2))
        x, y = chaos.boxes[j].inside(view.images[i])
        (image,) = axes.plot(x + middle, y, color=shades[i], linewidth=0.8, zorder=3)
        near = Rectangle((middle - NEAR, -1.5), 2.0 * NEAR, 3.0, transform=axes.transData)
        image.set_clip_path(near)
        axes.text(middle, 1.15, f"{i + 1} to {j + 1}", ha="center", fontsize=style.NOTE)
    last = max(len(chaos.coverings) - 1, 0) * APART
    axes.set(xlim=(-NEAR - 0.5, last + NEAR + 0.5), ylim=(-1.5, 1.5), xticks=[],
             xlabel="x (expanding) from −1 to 1 in each box", ylabel="y (contracting)")  # fmt: skip
    axes.set_title(f"each covering, in the coordinates of the covered box, cut at x = ±{NEAR:g}")
