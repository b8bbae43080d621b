"""Picture of bifurcation curves in two parameters."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.orbits.curves import Curve
from camcli.plots import style
from camcli.plots.orbits import axis_name

LEFT, RIGHT, TOP, BOTTOM, HEIGHT = 125, 50, 60, 95, 800  # px
STYLES = ("-", "--", ":", "-.")


@style.look()
def draw_curves(curves: Sequence[Curve], second: str) -> Figure:
    """Picture of bifurcation curves; an open circle is an end."""
    lines = style.LINE * max(1, len(curves) + any(_early(c) for c in curves))
    figure = style.page(TOP + lines + 20 + HEIGHT + BOTTOM)
    style.write(figure, 20, 14, "Bifurcations in two parameters", size=9, weight="bold")
    wide = style.WIDTH - LEFT - RIGHT
    axes = style.place(figure, LEFT, TOP + lines + 20, wide, HEIGHT)
    for curve, look in zip(curves, _looks(curves), strict=True):
        _draw(axes, curve, *look)
    if not curves:
        style.note(axes, "no bifurcation of this kind was located")
        axes.set(xticks=[], yticks=[])
        return figure
    if any(_early(curve) for curve in curves):
        axes.plot([], [], "o", color=style.CAM, mfc="white", label="the curve ends within range")
    _legend(figure)
    axes.set_xlabel(axis_name("rpm"))
    axes.set_ylabel(axis_name(second))
    return figure


def _looks(curves: Sequence[Curve]) -> list[tuple[str, str]]:
    """Colour of each curve, that of its orbit, and dashes where colours repeat."""
    colours = style.apart([style.label_colour(curve.label) for curve in curves])
    turns = [colours[:k].count(colour) for k, colour in enumerate(colours)]
    return [(c, STYLES[k % len(STYLES)]) for c, k in zip(colours, turns, strict=True)]


def _early(curve: Curve) -> bool:
    return any(end != "end-of-range" for end in curve.ends)


def _draw(axes: Axes, curve: Curve, colour: str, line: str) -> None:
    x, y = [p.first for p in curve.points], [p.second for p in curve.points]
    corner = f" at {curve.corner}" if curve.corner else ""
    name = f"{curve.kind.replace('-', ' ')}{corner} of {style.motion(curve.label)}"
    ends = {end for end in curve.ends if end != "end-of-range"}
    name += f" (ends: {'; '.join(sorted(ends))})" if ends else ""
    axes.plot(x, y, color=colour, linestyle=line, label=name)
    for place, end in zip((0, -1), curve.ends, strict=True):
        if curve.points and end != "end-of-range":
            axes.plot([x[place]], [y[place]], "o", color=colour, mfc="white", zorder=5)


def _legend(figure: Figure) -> None:
    whole = figure.get_figheight() * style.DPI
    figure.legend(
        loc="upper left", bbox_to_anchor=(20 / style.WIDTH, 1.0 - (TOP - 6) / whole),
        borderpad=0.0, borderaxespad=0.0, handletextpad=0.6,
    )  # fmt: skip
