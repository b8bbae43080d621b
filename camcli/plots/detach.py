"""Picture of detachment: impacts with accumulation curve and corner hits, and the contact force."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator

from camcli.analysis.contact_loss.detachment import Loss
from camcli.analysis.contact_loss.force import ForceCurve
from camcli.analysis.contact_loss.hold import Hold
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.plots import style
from camcli.plots.force import draw_forces, newtons
from camcli.system import System

LEFT, RIGHT, TOP, BOTTOM = 125, 60, 160, 95  # px, margins
GAP = 120  # px, between panels
ZOOM, WHOLE, FORCE = 520, 520, 430  # px, heights of the panels
FOLD = 1e-6  # deg, before the leading lift-off, where the axis of phases begins
LINES = 34  # px, of a legend above a panel of forces
FLAT = 36.0  # deg, less than this is shown enlarged even where all speeds are
JUMP = 20.0  # deg, between speeds, breaks the accumulation curve
ROOM = 0.03  # of an axis, beyond what it shows
LEGEND = {"borderaxespad": 0.0, "columnspacing": 1.5, "handletextpad": 0.5, "handlelength": 1.6}


@dataclass(frozen=True)
class _View:
    """Ranges of a diagram of phases (deg, counted on from `fold`) over speeds."""

    low: float
    high: float
    fold: float
    rpm: tuple[float, float]
    height: int

    def phase(self, theta_deg):
        """Phases counted on from the fold."""
        return self.fold + (np.asarray(theta_deg, dtype=float) - self.fold) % 360.0


@style.look()
def draw_detach(study: ContactLoss, system: System) -> Figure:
    """Picture of a study."""
    views = _views(study)
    forces = [study.forces, [curve for _, curve in study.springs]]
    heights = [view.height for view in views]
    heights += [FORCE + LINES * len(curves) for curves in forces if curves]
    height = TOP + sum(heights) + GAP * (len(heights) - 1) + BOTTOM
    wide = style.WIDTH - LEFT - RIGHT
    figure = style.page(height)
    _heading(figure, study)
    top, first = TOP, None
    for view in views:
        axes = style.place(figure, LEFT, top, wide, view.height)
        _draw_phases(axes, view, study, system)
        first = first or axes
        top += view.height + GAP
    _legend(figure, first, height)
    if study.forces:
        names = [_least(f"{style.number(round(c.rpm, 6))} rpm", c) for c in study.forces]
        axes = style.place(figure, LEFT, top + LINES * len(names), wide, FORCE)
        _draw_forces(axes, study.forces, names, system)
        top += LINES * len(names) + FORCE + GAP
    if study.springs:
        rpm = style.number(study.springs[0][1].rpm)
        names = [_least(_spring(hold), curve) for hold, curve in study.springs]
        axes = style.place(figure, LEFT, top + LINES * len(names), wide, FORCE)
        _draw_forces(axes, forces[1], names, system)
        axes.set_ylabel(f"contact force at {rpm} rpm (N)")
    return figure


def _heading(figure: Figure, study: ContactLoss) -> None:
    rpms = dict.fromkeys(style.number(f(s.rpm for s in study.speeds)) for f in (min, max))
    title = f"Detachment and chattering, {' to '.join(rpms)} rpm"
    style.write(figure, 20, 14, title, size=9, weight="bold")
    first = study.detachment.first
    if first is None:
        never = study.detachment.never
        text = "contact is never lost" if never else "contact is lost at every speed"
    else:
        text = f"contact is first lost at {first.rpm:.9f} rpm, {first.theta_deg:.6f} deg"
        if study.completion:
            text += f"; chatter stops being complete at {study.completion[0].rpm:.4f} rpm"
    style.write(figure, 20, 54, text)


def _views(study: ContactLoss) -> list[_View]:
    """The whole range; before it, enlarged, the speeds up to the last corner first reached."""
    rpms = [speed.rpm for speed in study.speeds]
    span = _padded(min(rpms), max(rpms))
    if study.detachment.first is None:
        return [_View(0.0, 360.0, 0.0, span, WHOLE)]
    lead = _leading(study)
    start, room = lead.opens.theta_deg, 360.0 * ROOM
    views = [_View(start - room, start + 360.0 + room, start - FOLD, span, WHOLE)]
    marks = [c for c in study.accumulation if c.burst == lead.region.name]
    early = {c.region: c for c in sorted(marks, key=lambda c: -c.rpm)}  # the first of each corner
    reached = sorted(early.values(), key=lambda c: c.rpm)[:2]
    if not reached:
        return views
    ends = [c.theta_deg for c in reached]
    if len(reached) < 2:  # what happens beyond the only corner belongs to it
        ends += [end for name, end, _ in _ends(study) if name == lead.region.name]
    highest = views[0].phase(ends).max()
    bottom, top = start - 0.06 * (highest - start), highest + 0.2 * (highest - start)
    hits = [h.rpm for h in study.hits if h.corner == reached[0].region]
    low, high = lead.opens.rpm, max([*[c.rpm for c in reached], *hits])
    rpm = max(span[0], low - 0.12 * (high - low)), min(span[1], high + 0.12 * (high - low))
    if rpm[1] - rpm[0] < 0.6 * (span[1] - span[0]):
        views.insert(0, _View(bottom, top, start - FOLD, rpm, ZOOM))
    elif top - bottom < FLAT:
        views.insert(0, _View(bottom, top, start - FOLD, span, ZOOM))
    return views


def _ends(study: ContactLoss) -> list[tuple[str, float, float]]:
    """Region, end and speed of every complete burst."""
    return [
        (burst.region, burst.end_deg, speed.rpm)
        for speed in study.speeds
        for burst in speed.bursts
        if burst.end_deg is not None
    ]


def _leading(study: ContactLoss) -> Loss:
    """The region whose bursts have most to show: the axis of phases begins where they do."""
    losses = {loss.region.name: loss for loss in study.detachment.losses}
    marks = Counter(c.burst for c in study.accumulation)
    name = marks.most_common(1)[0][0] if marks else study.detachment.first.region
    return losses[name]


def _padded(low: float, high: float) -> tuple[float, float]:
    room = ROOM * (high - low) or 0.01 * abs(high)
    return low - room, high + room


def _draw_phases(axes: Axes, view: _View, study: ContactLoss, system: System) -> None:
    """Impacts in the background; the computed curve and points on top."""
    _corners(axes, view, system)
    rpm = [speed.rpm for speed in study.speeds for _ in speed.impacts]
    impacts = view.phase([x for speed in study.speeds for x in speed.impacts])
    dots = {"linestyle": "", "marker": "o", "markeredgewidth": 0.0}
    axes.plot(
        rpm, impacts, color=style.SIMULATED, markersize=1.8, label="impacts, simulated", **dots
    )
    _curves(axes, view, study)
    first = study.detachment.first
    if first is not None:
        look = {"color": style.DETACHMENT, "linestyle": "", "marker": "D", "markersize": 4.5}
        at = view.phase([first.theta_deg])
        axes.plot([first.rpm], at, label="first detachment", zorder=5, **look)
    marks = [*study.accumulation, *study.completion]
    look = {"color": style.CHATTER, "linestyle": "", "marker": "^", "markersize": 5.0}
    late = [360.0 * (c.quantity == "completion_loss") for c in marks]  # a turn after lift-off
    at = view.phase([c.theta_deg for c in marks]) + np.array(late)
    name = "on a corner, completion lost"
    axes.plot([c.rpm for c in marks], at, label=name, zorder=4, **look)
    _hits(axes, view, study, system)
    axes.set(xlim=view.rpm, ylim=(view.low, view.high))
    axes.set_xlabel("cam speed (rpm)")
    axes.set_ylabel(r"phase $\theta$ (deg)")
    axes.yaxis.set_major_locator(MultipleLocator(60 if view.high - view.low > 120.0 else 10))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value % 360.0:g}"))


def _curves(axes: Axes, view: _View, study: ContactLoss) -> None:
    """Where each region's bursts end, a line per region, broken at jumps."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for region, end, rpm in _ends(study):
        curves.setdefault(region, []).append((rpm, float(view.phase(end))))
    label = "end of the chatter, computed"
    for region in sorted(curves):
        points = np.array(curves[region])
        breaks = np.flatnonzero(abs(np.diff(points[:, 1])) > JUMP) + 1
        points = np.insert(points, breaks, np.nan, axis=0)
        dot = {"marker": "o", "markersize": 1.6, "markeredgewidth": 0.0, "linewidth": 1.2}
        axes.plot(*points.T, color=style.CHATTER, label=label, zorder=3, **dot)
        label = None


def _hits(axes: Axes, view: _View, study: ContactLoss, system: System) -> None:
    """Speeds at which the n-th impact lands on a corner; the first ones numbered."""
    phases = style.corner_names(system.corners_deg)
    hits = [hit for hit in study.hits if hit.corner in phases]
    at = view.phase([phases[hit.corner] for hit in hits])
    look = {"marker": "o", "markersize": 4.0, "markerfacecolor": "white", "markeredgewidth": 0.8}
    rpm = [hit.rpm for hit in hits]
    label = "n-th impact on a corner"
    axes.plot(rpm, at, color=style.IMPACT, linestyle="", label=label, zorder=6, **look)
    apart = 0.02 * (view.rpm[1] - view.rpm[0])
    last: dict[str, float] = {}
    for hit, y in zip(hits, at, strict=True):
        inside = view.rpm[0] < hit.rpm < view.rpm[1] and view.low < y < view.high
        if inside and abs(last.get(hit.corner, inf) - hit.rpm) > apart:
            last[hit.corner] = hit.rpm
            above = {"textcoords": "offset points", "xytext": (0, 4), "ha": "center", "size": 7}
            axes.annotate(str(hit.impact), (hit.rpm, y), annotation_clip=True, **above)


def _corners(axes: Axes, view: _View, system: System) -> None:
    """Corners as lines named at the right edge."""
    names = {n: float(view.phase(x)) for n, x in style.corner_names(system.corners_deg).items()}
    turns = [(place + turn, name) for name, place in names.items() for turn in (0.0, 360.0)]
    seen = sorted(pair for pair in turns if pair[0] <= view.high)
    gap = 24.0 * (view.high - view.low) / view.height
    places = style.spread([place for place, _ in seen], gap, view.low, view.high)
    for (line, name), place in zip(seen, places, strict=True):
        axes.axhline(line, color=style.GUIDE, linewidth=0.5, zorder=1)
        at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
        axes.text(1.012, place, name, color=style.CAM, **at)


def _draw_forces(axes: Axes, curves: Sequence[ForceCurve], names, system: System) -> None:
    """N over the turn with its corners."""
    draw_forces(axes, curves, names)
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 30))
    axes.set_xlabel(r"cam angle $\theta$ (deg)")
    for name, phase in style.corner_names(system.corners_deg).items():
        axes.axvline(phase, color=style.GUIDE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
        text = {"ha": "center", "va": "bottom", "color": style.CAM}
        axes.text(phase, 1.01, name, transform=axes.get_xaxis_transform(), **text)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.075), borderpad=0.0, **LEGEND)


def _least(name: str, curve: ForceCurve) -> str:
    return f"{name}: least {newtons(curve.lowest_n, 6)} at {curve.lowest_deg:.6g} deg"


def _spring(hold: Hold | None) -> str:
    """The name of a spring in a legend."""
    if hold is None:
        return "present spring"
    return f"{hold.stiffness:.6g} N/m, preload {hold.preload:.6g} N"


def _legend(figure: Figure, axes: Axes, height: int) -> None:
    handles, names = axes.get_legend_handles_labels()
    above = (20 / style.WIDTH, 1.0 - 96 / height)
    figure.legend(
        handles, names, loc="upper left", bbox_to_anchor=above, ncol=3, borderpad=0.0, **LEGEND
    )
