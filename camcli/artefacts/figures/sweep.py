"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from camcli.analysis.sweep import Speed, Sweep, status_name
from camcli.artefacts.figures import style
from camcli.artefacts.figures.density import (
    TURN_DEG,
    Cloud,
    Columns,
    enlarged_range,
    one_point,
    padded,
    phase_range,
    shares,
)
from camcli.kernel.profile import ORDERS, PIECE, TERMS
from camcli.profiles.table import column
from camcli.system import System

LEFT, WIDE, RIGHT = 365, 925, 50  # px, of the diagrams
CAM_LEFT, CAM_WIDE, CAM_GAP = 105, 68, 16  # px, of the three cam curves beside them
GAP, BOTTOM = 36, 90  # px, between panels and below the last
CHARS = 118  # in a line of the subtitle
FULLEST = 0.1  # share of a speed's points in a pixel from which it is darkest
CURVES = (("$c$", "m"), (r"$c_\theta$", "m/rad"), (r"$c_{\theta\theta}$", "m/rad²"))


@dataclass(frozen=True)
class _Panel:
    """One diagram: its points, the range of its vertical axis and its height in pixels."""

    cloud: Cloud
    low: float
    high: float
    height: int
    phases: bool
    enlarged: tuple[float, float] | None = None  # shown again in the next panel


def draw_sweep(sweep: Sweep, system: System, path_or_buffer, *, start_text: str) -> None:
    """Write the PNG of a sweep to a path or a binary buffer.

    `start_text` says how the orbits were started; it stands below the title.
    """
    speeds = sorted(sweep.speeds, key=lambda speed: speed.rpm)
    panels = _panels(speeds)
    lines = textwrap.wrap(_subtitle(speeds, start_text), CHARS)
    top = 70 + style.LINE * len(lines) + 20
    heights = [panel.height for panel in panels] or [200]
    height = top + sum(heights) + GAP * (len(heights) - 1) + BOTTOM
    with style.page(path_or_buffer, height) as figure:
        style.write(figure, 20, 16, _title(speeds), size=9, weight="bold")
        style.write(figure, 20, 66, "\n".join(lines), linespacing=1.25)
        if not panels:
            empty = style.place(figure, LEFT, top, WIDE, heights[0], xticks=[], yticks=[])
            style.note(empty, "nothing was recorded")
            return
        _draw_panels(figure, panels, speeds, system, top)


def _title(speeds: Sequence[Speed]) -> str:
    if not speeds:
        return "Bifurcation diagram"
    low, high = style.number(speeds[0].rpm), style.number(speeds[-1].rpm)
    return f"Bifurcation diagram, {low} rpm" if low == high else (
        f"Bifurcation diagram, {low} to {high} rpm"
    )


def _subtitle(speeds: Sequence[Speed], start_text: str) -> str:
    text = f"{start_text}; {len(speeds)} speed" + ("s" if len(speeds) != 1 else "")
    troubles = Counter(status_name(speed.status) for speed in _troubled(speeds))
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        text += f"; {troubles.total()} not ok, red ticks below the diagrams ({kinds})"
    return text


def _troubled(speeds: Sequence[Speed]) -> list[Speed]:
    return Sweep(list(speeds), "", None).troubled


def _panels(speeds: Sequence[Speed]) -> list[_Panel]:
    """What there is to show, from top to bottom."""
    panels = []
    if any(speed.impacts is not None for speed in speeds):
        cloud = Cloud.of([() if s.impacts is None else s.impacts[1] for s in speeds])
        enlarged = enlarged_range(cloud)
        height = 640 if enlarged is None else 430
        panels.append(_Panel(cloud, *phase_range(cloud), height, True, enlarged))
        if enlarged is not None:
            panels.append(_Panel(cloud, *enlarged, 520, True))
    if any(speed.strobe is not None for speed in speeds):
        cloud = Cloud.of([() if s.strobe is None else s.strobe[1] for s in speeds])
        largest = float(np.abs(cloud.values).max(initial=0.0))
        panels.append(_Panel(cloud, *padded(cloud.values, 0.1 * largest or 1.0), 430, False))
    return panels
