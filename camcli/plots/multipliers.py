"""Multipliers of periodic orbits: in the complex plane, and their real part over the parameter."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from camcli.analysis.orbits.shooter import multipliers
from camcli.plots import style
from camcli.plots.orbit_lines import Strand, draw_strands, line_look

FURTHEST = 2.0  # multipliers beyond are not drawn in the plane
LINEAR = 4.0  # real parts up to this are drawn on a linear axis
LEAST = 1.2  # half width of the plane around the unit circle
SHORT = 0.08  # of an axis, a path without an arrow
TINY = 0.03  # a path that is drawn as a point


def draw_plane(axes: Axes, largest: float) -> None:
    """The unit circle and equal axes."""
    half = min(max(LEAST, 1.06 * largest), FURTHEST)
    around = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.fill(np.cos(around), np.sin(around), color=style.CAM_BODY, linewidth=0, zorder=0)
    axes.plot(np.cos(around), np.sin(around), color=style.CAM, linewidth=0.8, zorder=1)
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    ticks = [-1.0, 0.0, 1.0] if half < FURTHEST else [-2.0, -1.0, 0.0, 1.0, 2.0]
    axes.set(xlim=(-half, half), ylim=(-half, half), xticks=ticks, yticks=ticks)
    beyond = f" (beyond ±{half:g} not drawn)" if largest > half else ""
    axes.set_xlabel(r"Re $\mu$" + beyond)
    axes.set_ylabel(r"Im $\mu$", labelpad=0)


def draw_paths(axes: Axes, lines: Sequence[Strand], colour: str, share: float) -> None:
    """Paths in the plane with an arrow each, at a share of its length, for a rising parameter."""
    half = axes.get_xlim()[1]
    for line in lines:
        mu = np.asarray(line.y)
        if np.abs(mu - mu[0]).max() < TINY:
            face = colour if line.stable else "white"
            axes.plot(mu.real[:1], mu.imag[:1], "o", color=colour, ms=4.0, mfc=face, zorder=4)
            continue
        axes.plot(mu.real, mu.imag, color=colour, zorder=3, **line_look(line.stable))
        _draw_arrow(axes, np.asarray(line.x), mu, colour, half, share)


def _draw_arrow(
    axes: Axes, x: np.ndarray, mu: np.ndarray, colour: str, half: float, share: float
) -> None:
    seen = (abs(mu.real) < half) & (abs(mu.imag) < half)
    inside = seen[:-1] & seen[1:]
    way = np.concatenate([[0.0], np.cumsum(np.where(inside, np.abs(np.diff(mu)), 0.0))])
    if way[-1] < SHORT * 2.0 * half:
        return
    k = min(int(np.searchsorted(way, share * way[-1])), len(mu) - 1)
    ahead = (mu[k] - mu[k - 1]) * (1.0 if x[k] >= x[k - 1] else -1.0)
    step = ahead / abs(ahead) * 0.035 * half
    tip, tail = mu[k] + step, mu[k] - step
    look: dict[str, Any] = {"arrowstyle": "-|>,head_width=0.26,head_length=0.5"}
    look |= {"color": colour, "linewidth": 0.0, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", (tip.real, tip.imag), (tail.real, tail.imag), arrowprops=look, zorder=5)


def draw_real(axes: Axes, every: Sequence[Sequence[Strand]], colours: Sequence[str]) -> None:
    """Real parts over the parameter; where they are large the axis is one of asinh."""
    for level in (-1.0, 1.0):
        axes.axhline(level, color=style.CAM, linewidth=0.8, zorder=1)
    axes.axhspan(-1.0, 1.0, color=style.CAM_BODY, linewidth=0, zorder=0)
    for lines, colour in zip(every, colours, strict=True):
        draw_strands(axes, lines, colour, np.real)
    values = [mu.real for lines in every for line in lines for mu in line.y]
    low, high = min([-1.2, *values]), max([1.2, *values])
    axes.set_ylabel(r"Re $\mu$")
    if max(-low, high) <= LINEAR:
        room = 0.04 * (high - low)
        axes.set_ylim(low - room, high + room)
        return
    axes.set_yscale("asinh", linear_width=1.0)
    axes.set_ylim(1.3 * low, 1.3 * high)
    axes.set_yticks(_ticks(low, high))
    axes.yaxis.set_major_formatter(lambda value, _: _power(value))
    axes.minorticks_off()
    axes.set_ylabel(r"Re $\mu$ (asinh scale: logarithmic where large)")


def _ticks(low: float, high: float) -> list[float]:
    if max(-low, high) < 20.0:
        return [x for x in (-10.0, -5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 5.0, 10.0) if low <= x <= high]
    up = [10.0**k for k in range(1, 1 + floor(log10(max(high, 1.0))))]
    down = [-(10.0**k) for k in range(1, 1 + floor(log10(max(-low, 1.0))))]
    step = max(1, (max(len(up), len(down)) + 2) // 3)
    return [*down[step - 1 :: step], -1.0, 0.0, 1.0, *up[step - 1 :: step]]


def _power(value: float) -> str:
    if abs(value) < 1000.0:
        return f"{value:g}".replace("-", "−")
    sign = "−" if value < 0.0 else ""
    return f"${sign}10^{{{round(log10(abs(value)))}}}$"


def pair(trace: float, det: float) -> str:
    """The two multipliers as numbers."""
    upper, lower = multipliers(trace, det)
    if upper.imag:
        text = f"{upper.real:.4g} ± {upper.imag:.4g}i"
    else:
        text = f"{upper.real:.4g}, {lower.real:.4g}" if upper != lower else f"{upper.real:.4g}"
    return text.replace("-", "−")
