"""The contact force over the turn, with one look in every picture."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from camcli.analysis.contact_loss.force import ForceCurve
from camcli.plots import style

DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1)), (0, (5, 1.2, 1.2, 1.2)))


def draw_forces(axes: Axes, curves: Sequence[ForceCurve], names: Sequence[str] = ()) -> None:
    """N over the turn, darker from curve to curve; below zero a follower would leave."""
    colours = style.FORCES if len(curves) > 1 else (style.FORCE,)
    for k, curve in enumerate(curves):
        turn, place = divmod(k, len(colours))
        look = {"color": colours[place], "linestyle": DASHES[turn % len(DASHES)]}
        name = names[k] if names else None
        axes.plot(curve.theta_deg, curve.force_n, label=name, zorder=2 + 0.01 * k, **look)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    low, high = axes.get_ylim()
    if low < 0.0 and any(min(curve.force_n) < 0.0 for curve in curves):
        axes.axhspan(low, 0.0, color=style.PULL, linewidth=0, zorder=0)
    axes.set_ylim(low, high)
    axes.set_ylabel("contact force (N)")


def newtons(value: float, digits: int) -> str:
    """A force for print, with a minus sign and no negative zero."""
    return f"{round(value, 6) + 0.0:.{digits}g} N".replace("-", "−")
