"""The panel of largest Lyapunov exponents below a picture over speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from matplotlib.axes import Axes

from camcli.analysis.exponents import Exponents
from camcli.plots import style
from camcli.plots.density import padded

BELOW = 0.16  # of the panel, for -inf
FORGETS = "−∞: the follower rests on the cam, which forgets every difference"


@dataclass(frozen=True)
class Growth:
    """The exponents of a motion, where they are drawn, and in which colour."""

    x: float
    exponents: Exponents
    colour: str

    @property
    def largest(self) -> float:
        """Exponent in 1/turn."""
        return self.exponents.largest

    @property
    def spread(self) -> float:
        """Its standard error, 0 where none is known."""
        return self.exponents.spread if isfinite(self.exponents.spread) else 0.0


def draw_growth(axes: Axes, known: Sequence[Growth]) -> None:
    """Exponents with their error bars; those that are -inf on a band at the bottom."""
    finite = [one for one in known if isfinite(one.largest)]
    minus = [one for one in known if one.largest == -inf]
    ends = [one.largest + sign * one.spread for one in finite for sign in (-1.0, 1.0)]
    low, high = padded(np.array([0.0, *ends]), 0.5)
    floor = low - BELOW * (high - low) / (1.0 - BELOW) if minus else low
    axes.set_ylim(floor, high)
    axes.axhline(0.0, color=style.CAM, linewidth=0.8, zorder=1)
    for one in finite:
        dot = {"markersize": 2.6, "markeredgewidth": 0.0}
        axes.plot([one.x], [one.largest], "o", color=one.colour, zorder=4, **dot)
        bar = [one.largest - one.spread, one.largest + one.spread]
        axes.plot([one.x, one.x], bar, color=one.colour, linewidth=0.8, zorder=4)
    ticks = [tick for tick in axes.get_yticks() if low <= tick <= high] if finite else [0.0]
    names = [f"{tick:.6g}".replace("-", "−") for tick in ticks]
    if minus:
        place = 0.5 * (floor + low)
        _forgetful(axes, minus, floor, low)
        ticks, names = [place, *ticks], ["−∞", *names]
    axes.set_yticks(ticks, names)
    axes.set_ylabel("largest exponent (1/turn)")
    axes.tick_params(labelbottom=False)


def _forgetful(axes: Axes, minus: Sequence[Growth], floor: float, low: float) -> None:
    """The band of those that are -inf, with the reason."""
    axes.axhspan(floor, low, color=style.CAM_BODY, linewidth=0, zorder=0)
    for colour in dict.fromkeys(one.colour for one in minus):
        at = [one.x for one in minus if one.colour == colour]
        look = {"color": colour, "zorder": 4, "markersize": 3.2, "markeredgewidth": 0.0}
        axes.plot(at, [floor + 0.25 * (low - floor)] * len(at), "v", **look)
    patch = {"facecolor": style.CAM_BODY, "edgecolor": "none", "pad": 0.5}
    look = {"ha": "center", "va": "center", "size": 7, "color": style.CAM, "bbox": patch}
    at = {"transform": axes.get_yaxis_transform(), "zorder": 5}
    axes.text(0.5, floor + 0.72 * (low - floor), FORGETS, **at, **look)


def remark(known: Sequence[Growth], motions: int) -> str:
    """What the bars are, and for how many motions nothing is known."""
    said = ["bars: ± one standard error"] if any(one.spread > 0.0 for one in known) else []
    if len(known) < motions:
        said.append(f"not known for {motions - len(known)} of {motions} motions")
    return "; ".join(said)
