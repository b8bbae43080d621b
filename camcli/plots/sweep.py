"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import MaxNLocator

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import FIXED, Speed, Sweep, status_name
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import (
    NARROW_DEG,
    TURN_DEG,
    at_strobe,
    corners_upwards,
    lift_curves,
    numbers_height,
    padded,
    phase_axis,
    phase_range,
    trouble_ticks,
)
from camcli.plots.density import Batches, Cloud, Columns, Pixels, Take, draw_shares, shading
from camcli.plots.event_list import Numbered, draw_events, draw_list, list_height, numbered
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.explain.events import Event

LEFT, RIGHT = 130, 50  # px, margins of the diagrams
CAM, CAM_GAP = 72, 18  # px, width of the three curves of the cam beside them
GAP, BOTTOM = 36, 90  # px, between panels and below the last
LIST_GAP = 14  # px above a list of events
SMALL = 0.02  # m: a cam that is smaller throughout is drawn in mm
KEY = 140  # px, height of the scales above the panels; half is enough without the cam
CHARS = 108  # in a line of the subtitle
ENLARGED_SHARE = 0.4  # of the speeds, for a panel of their own
CURVES = (("$c$", "m"), (r"$c_\theta$", "m/rad"), (r"$c_{\theta\theta}$", "m/rad²"))


@dataclass(frozen=True)
class Survey:
    """Speeds in their own order, what their points come to; None for what was not recorded."""

    rpm: np.ndarray
    status: np.ndarray
    impacts: Cloud | None
    strobe: Cloud | None

    @classmethod
    def of(cls, speeds: Sequence[Speed]) -> Survey:
        """Pass over all speeds once."""
        clouds = Cloud.empty(len(speeds)), Cloud.empty(len(speeds))
        kinds = [("rpm", "f8"), ("status", "i8"), ("impacts", "?"), ("strobe", "?")]
        rows = np.fromiter(_read(speeds, clouds[0].take, clouds[1].take), kinds)
        impacts, strobe = (
            cloud if rows[name].any() else None
            for cloud, name in zip(clouds, ("impacts", "strobe"), strict=True)
        )
        return cls(rows["rpm"], rows["status"], impacts, strobe)

    @property
    def troubled(self) -> np.ndarray:
        """Speeds (rpm) whose status is not ok, ascending."""
        return np.sort(self.rpm[self.status != Status.OK])

    def troubles(self) -> Counter[str]:
        """How many speeds have each status that is not ok."""
        return Counter(status_name(code) for code in self.status[self.status != Status.OK].tolist())


def _read(
    speeds: Sequence[Speed], impacts: Take, strobe: Take
) -> Iterator[tuple[float, int, bool, bool]]:
    """One pass over speeds that may come from a disk: rpm, status and what was recorded of each.

    `impacts` gets the phases of all in batches, and `strobe` the positions.
    """
    phases, positions = Batches(impacts), Batches(strobe)
    for owner, speed in enumerate(speeds):
        if speed.impacts is not None:
            phases.add(owner, speed.impacts[1])
        if speed.strobe is not None:
            positions.add(owner, speed.strobe[1])
        yield speed.rpm, speed.status, speed.impacts is not None, speed.strobe is not None
    phases.flush()
    positions.flush()


@dataclass(frozen=True)
class _Panel:
    """One diagram: its points, the range of its vertical axis and its height in pixels."""

    cloud: Cloud
    low: float
    high: float
    height: int
    phases: bool
    enlarged: tuple[float, float] | None = None  # shown again in the next panel


@style.look()
def draw_sweep(
    sweep: Sweep, system: System, settings: Settings, events: Sequence[Event] = ()
) -> Figure:
    """Picture of a sweep; `settings` tell how its orbits were started.

    `events` are listed below the title and numbered above the panels. The speeds are read twice,
    and no more than a batch of their points is held.
    """
    found = numbered(events)
    survey = Survey.of(sweep.speeds)
    panels = _panels(survey)
    subtitle = _subtitle(survey, _started(sweep, settings))
    lines = textwrap.wrap(subtitle, CHARS, break_on_hyphens=False)
    head = 54 + style.LINE * len(lines) + (LIST_GAP if found else 0)
    top = head + list_height(found) + numbers_height(len(found))
    top += KEY if panels and panels[0].phases else KEY // 2
    heights = [panel.height for panel in panels] or [200]
    height = top + sum(heights) + GAP * (len(heights) - 1) + BOTTOM
    figure = style.page(height, _title(survey), "\n".join(lines))
    draw_list(figure, head, found)
    if panels:
        _draw_panels(figure, panels, sweep, survey, system, top, found)
    else:
        wide = style.WIDTH - LEFT - RIGHT
        empty = style.place(figure, LEFT, top, wide, heights[0], xticks=[], yticks=[])
        style.note(empty, "nothing was recorded")
    return figure


def _title(survey: Survey) -> str:
    rpm = survey.rpm
    if not len(rpm):
        return "Bifurcation diagram"
    ends = dict.fromkeys(style.number(float(end)) for end in (rpm.min(), rpm.max()))
    return f"Bifurcation diagram, {' to '.join(ends)} rpm"


def _started(sweep: Sweep, settings: Settings) -> str:
    """How the orbits were started."""
    start, turns = settings.start, settings.transient
    if start.q is None and start.v is None:
        place = "at rest on the cam"
    else:
        q = "on the cam" if start.q is None else f"q = {start.q:g} m"
        v = "the cam's v" if start.v is None else f"v = {start.v:g} m/s"
        place = f"at {q}, {v}"
    if sweep.direction == FIXED or not sweep.speeds:
        return f"each speed started {place}, {turns} turns of transient"
    return (
        f"carried {sweep.direction} from {sweep.speeds[0].rpm:g} rpm, started there {place}; "
        f"{turns} turns of transient at each speed"
    )


def _subtitle(survey: Survey, started: str) -> str:
    many, troubles = len(survey.rpm), survey.troubles()
    parts = [started, f"{many} speed" + ("s" if many != 1 else "")]
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        parts.append(f"{troubles.total()} not ok, marked at the bottom edge ({kinds})")
    return "; ".join(parts)


def _panels(survey: Survey) -> list[_Panel]:
    """What there is to show, from top to bottom."""
    panels = []
    if (cloud := survey.impacts) is not None:
        enlarged = enlarged_range(cloud)
        height = 640 if enlarged is None else 430
        panels.append(_Panel(cloud, *phase_range(cloud.extremes()), height, True, enlarged))
        if enlarged is not None:
            panels.append(_Panel(cloud, *enlarged, 520, True))
    if (cloud := survey.strobe) is not None:
        largest = float(np.abs(cloud.extremes()).max(initial=0.0))
        panels.append(_Panel(cloud, *padded(cloud.extremes(), 0.1 * largest or 1.0), 430, False))
    return panels


def enlarged_range(cloud: Cloud) -> tuple[float, float] | None:
    """Phases that deserve an enlarged panel: many speeds impact there and nowhere else."""
    if phase_range(cloud.extremes()) != (0.0, TURN_DEG):
        return None
    low, high = cloud.ends()
    narrow = high - low <= NARROW_DEG / 2.0
    if not len(low) or narrow.mean() < ENLARGED_SHARE:
        return None
    first, last = padded(np.concatenate([low[narrow], high[narrow]]), 5.0)
    return (max(first, 0.0), min(last, TURN_DEG)) if last - first <= NARROW_DEG else None


def _count(panels: Sequence[_Panel], columns: Columns, sweep: Sweep) -> list[Pixels]:
    """The points of every panel, by one pass over the speeds."""
    pixels = [Pixels(columns, panel.low, panel.high, panel.height) for panel in panels]

    def take(phases: bool) -> Take:
        mine = [one for one, panel in zip(pixels, panels, strict=True) if panel.phases == phases]

        def count(owner: np.ndarray, values: np.ndarray) -> None:
            for one in mine:
                one.take(owner, values)

        return count

    for _ in _read(sweep.speeds, take(True), take(False)):
        pass
    return pixels


def _draw_panels(
    figure: Figure,
    panels: Sequence[_Panel],
    sweep: Sweep,
    survey: Survey,
    system: System,
    top: int,
    events: Sequence[Numbered],
) -> None:
    left = LEFT + (len(CURVES) * (CAM + CAM_GAP) + CAM_GAP if panels[0].phases else 0)
    wide = style.WIDTH - left - RIGHT
    columns = Columns.of(survey.rpm, wide)
    norm = shading([panel.cloud for panel in panels], columns)
    corners = list(style.corner_names(system.corners_deg).items())
    image, key = None, top - 60 - numbers_height(len(events))
    for panel, pixels in zip(panels, _count(panels, columns, sweep), strict=True):
        first = panel is panels[0]
        axes = style.place(figure, left, top, wide, panel.height)
        axes.set(xlim=(columns.low, columns.high), ylim=(panel.low, panel.high))
        axes.tick_params(labelbottom=panel is panels[-1])
        if panel.cloud.count.any():
            image = draw_shares(axes, pixels, panel.cloud, style.DENSITY, norm)
        else:
            what = "no impact" if panel.phases else "no whole turn recorded"
            style.note(axes, f"{what} at any of these speeds")
        if panel.enlarged is not None:
            axes.axhspan(*panel.enlarged, color=style.BAND, linewidth=0, zorder=0)
        draw_events(axes, events, numbers=first)
        trouble_ticks(axes, survey.troubled)
        if panel.phases:
            axes.tick_params(left=False, labelleft=False)
            corners_upwards(axes, corners)
            _draw_cam(figure, panel, system, corners, top, first)
        else:
            axes.set_ylabel(f"stroboscopic $q$ (m), {at_strobe(system)}")
        if panel is panels[-1]:
            axes.set_xlabel("cam speed (rpm)")
        top += panel.height + GAP
    if image is not None:
        _draw_key(figure, image, key)


def _draw_cam(
    figure: Figure,
    panel: _Panel,
    system: System,
    corners: Sequence[tuple[str, float]],
    top: int,
    first: bool,
) -> None:
    """The cam's lift and its derivatives beside a panel, over the same phases."""
    theta, orders = lift_curves(system.cam, len(CURVES))
    milli = bool(np.nanmax(np.abs(orders)) < SMALL)
    for k, (name, unit) in enumerate(CURVES):
        left = LEFT + k * (CAM + CAM_GAP)
        axes = style.place(figure, left, top, CAM, panel.height)
        axes.plot(orders[k] * (1e3 if milli else 1.0), theta, color=style.CAM, linewidth=0.9)
        phase_axis(axes, panel.low, panel.high)
        corners_upwards(axes, corners, named=False)
        axes.tick_params(left=k == 0, labelleft=k == 0, bottom=False, labelbottom=False)
        if k == 0:
            axes.set_ylabel(r"impact phase $\theta$ (deg)" + ("" if first else ", enlarged"))
        if first:
            axes.xaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 5, 10], min_n_ticks=2))
            axes.tick_params(axis="x", top=True, labeltop=True, labelrotation=90)
            words, spaced = f"{name}\n{'m' * milli}{unit}", {"linespacing": 1.0, "fontsize": 7}
            style.write(figure, left + CAM / 2, top - 124, words, ha="center", **spaced)


def _draw_key(figure: Figure, image: AxesImage, top: int) -> None:
    """What the shades mean, above the right end of the first panel."""
    left = style.WIDTH - RIGHT - 260
    key = style.place(figure, left, top, 260, 14)
    figure.colorbar(image, cax=key, orientation="horizontal", extend="max")
    key.xaxis.set_major_formatter(lambda share, _: f"{100.0 * share:g} %")
    key.minorticks_off()
    words = "share of a column's points per pixel"
    style.write(figure, left - 14, top - 8, words, ha="right")
