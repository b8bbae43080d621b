"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import FIXED, Speed, Sweep, status_name
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import (
    NARROW_DEG,
    TURN_DEG,
    corner_lines,
    lift_curves,
    number_events,
    padded,
    phase_axis,
    phase_range,
    say,
    strobe_name,
    trouble_ticks,
)
from camcli.plots.critical_speeds import event_lists, numbered
from camcli.plots.density import PER_MM, Cloud, Columns, Image
from camcli.plots.picture import Panel, Picture
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.explain.events import Event

SMALL = 0.02  # m: a cam that is smaller throughout is drawn in mm
ENLARGED_SHARE = 0.4  # of the speeds, for a panel of their own
CURVES = (("$c$", "m"), (r"$c_\theta$", "m/rad"), (r"$c_{\theta\theta}$", "m/rad²"))
SECTIONS = ("impacts", "strobe")
UNKNOWN = "undecided after rests"
KINDS = {
    "contact": style.CONTACT,
    "with rests": style.STICKING,
    "longer periods": style.LONGER,
    "aperiodic": style.APERIODIC,
    "undecided": style.UNDECIDED,
    UNKNOWN: style.UNDECIDED,
}

Take = Callable[[int, np.ndarray], None]  # index of a speed, and its values


@dataclass(frozen=True)
class Survey:
    """Speeds in their own order, what their points come to; None for what was not recorded."""

    values: np.ndarray
    status: np.ndarray
    kinds: list[str]  # of the motions, see `kind_of`
    impacts: Cloud | None
    strobe: Cloud | None

    @classmethod
    def of(cls, speeds: Sequence[Speed]) -> Survey:
        """Pass over all speeds once."""
        clouds = {name: Cloud(len(speeds)) for name in SECTIONS}
        rows = list(read(speeds, {name: [cloud.take] for name, cloud in clouds.items()}))
        values, status = np.array([row[:2] for row in rows]).reshape(-1, 2).T
        found = {name: any(name in row[3] for row in rows) for name in SECTIONS}
        some = [cloud if found[name] else None for name, cloud in clouds.items()]
        return cls(values, status.astype(int), [row[2] for row in rows], *some)

    @property
    def troubled(self) -> np.ndarray:
        """Values whose status is not ok, ascending."""
        return np.sort(self.values[self.status != Status.OK])


def kind_of(speed: Speed) -> str:
    """What its motion is, in a few words that have a colour each."""
    if not speed.known:
        return UNKNOWN
    if not speed.label.startswith("P("):
        return speed.label
    if "inf" in speed.label:
        return "with rests"
    period = int(speed.label[2:].partition(";")[0])
    return f"period {period}" if period <= len(style.PERIODS) else "longer periods"


def colour_of(kind: str) -> str:
    """The colour of a kind of motion, that of its basin."""
    if kind.startswith("period "):
        return style.period_colour(int(kind[7:]))
    return KINDS[kind]


def read(
    speeds: Iterable[Speed], takes: dict[str, list[Take]]
) -> Iterable[tuple[float, int, str, list[str]]]:
    """One pass over speeds that may come from a disk: value, status, kind, what was recorded.

    `takes` get the finite phases (impacts) and positions (strobe).
    """
    for k, speed in enumerate(speeds):
        recorded = []
        for name in takes:
            columns = getattr(speed, name)
            if columns is not None:
                recorded.append(name)
                values = np.asarray(columns[1], dtype=float)
                for take in takes[name]:
                    take(k, values[np.isfinite(values)])
        yield speed.value, speed.status, kind_of(speed), recorded


def draw_sweep(
    sweep: Sweep, system: System, settings: Settings, events: Sequence[Event] = ()
) -> Picture:
    """Picture of a sweep; `settings` tell how its orbits were started.

    `events` are listed below the title and numbered above the panels. The speeds are read twice,
    one at a time.
    """
    survey, found = Survey.of(sweep.speeds), numbered(events)
    panels = cloud_panels(survey, sweep, system)
    order = list(panels)

    def draw(axes: Axes, name: str) -> None:
        panels[name].draw(axes)
        pairs = [(number, event.rpm) for number, event in found]
        number_events(axes, pairs, named=name == order[0])
        trouble_ticks(axes, survey.troubled)

    many = {name: replace(panel, draw=partial(draw, name=name)) for name, panel in panels.items()}
    if not panels:
        many = {"speeds": Panel(lambda axes: say(axes, "nothing was recorded"), 30.0)}
    words = _words(survey, _started(sweep, settings))
    return Picture(_title(survey, sweep.key), many, words, lists=event_lists(found))


def _title(survey: Survey, key: str) -> str:
    if not len(survey.values):
        return "Bifurcation diagram"
    ends = dict.fromkeys(style.number(end) for end in (survey.values.min(), survey.values.max()))
    return f"Bifurcation diagram, {valued(key, ' to '.join(ends))}"


def valued(key: str, value: str) -> str:
    """A value of what is varied: 700 rpm, follower.restitution 0.8."""
    return f"{value} rpm" if key == "rpm" else f"{key} {value}"


def axis_name(key: str) -> str:
    """The name of an axis over what is varied."""
    return "cam speed (rpm)" if key == "rpm" else key


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
    first = valued(sweep.key, f"{sweep.speeds[0].value:g}")
    return (
        f"carried {sweep.direction} from {first}, started there {place}; "
        f"{turns} turns of transient at each speed"
    )


def _words(survey: Survey, started: str) -> str:
    many = len(survey.values)
    parts = [started, f"{many} speed" + ("s" if many != 1 else "")]
    troubles = Counter(map(status_name, survey.status[survey.status != Status.OK].tolist()))
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        parts.append(f"{troubles.total()} not ok, marked at the bottom edge ({kinds})")
    if unknown := survey.kinds.count(UNKNOWN):
        parts.append(f"{unknown} undecided after rests, grey")
    return "; ".join([*parts, "darker where more points fall"])


# --- clouds of points


def cloud_panels(survey: Survey, sweep: Sweep, system: System) -> dict[str, Panel]:
    """Panels of what was recorded, from one pass over the speeds."""
    ranges: dict[str, tuple[str, tuple[float, float], float]] = {}  # section, range, height
    enlarged = None
    if (cloud := survey.impacts) is not None:
        enlarged = enlarged_range(cloud)
        height = 72.0 if enlarged is None else 48.0
        ranges["impacts"] = "impacts", phase_range(cloud.extremes()), height
        if enlarged is not None:
            ranges["enlarged"] = "impacts", enlarged, 60.0
    if (cloud := survey.strobe) is not None:
        ranges["strobe"] = "strobe", padded(cloud.extremes()), 50.0
    if not ranges:
        return {}
    columns = Columns.of(survey.values)
    images = {
        name: Image(columns, low, high, round(height * PER_MM))
        for name, (_, (low, high), height) in ranges.items()
    }
    takes: dict[str, list[Take]] = {
        s: [images[n].take for n in ranges if ranges[n][0] == s] for s in SECTIONS
    }
    for _ in read(sweep.speeds, takes):
        pass

    def draw(axes: Axes, name: str) -> None:
        images[name].draw(axes, [colour_of(kind) for kind in survey.kinds])
        for kind in sorted(set(survey.kinds)) if name == next(iter(ranges)) else ():
            axes.plot([], [], "s", color=colour_of(kind), ms=4, label=kind)
        axes.set_xlabel(axis_name(sweep.key))
        if ranges[name][0] == "strobe":
            axes.set_ylabel(strobe_name(system))
        else:
            axes.tick_params(left=False, labelleft=False)
            corner_lines(axes, style.corner_names(system.corners_deg).items(), "y")
        if name == "impacts" and enlarged is not None:
            axes.axhspan(*enlarged, color=style.BAND, linewidth=0, zorder=0)
        cloud = getattr(survey, ranges[name][0])
        if not cloud.count.any():
            what = "whole turn recorded" if name == "strobe" else "impact"
            say(axes, f"no {what} at any of these speeds")

    panels = {}
    for name, (section, (low, high), height) in ranges.items():
        words = ", enlarged" * (name == "enlarged")
        beside = cam_beside(system, low, high, words) if section == "impacts" else ()
        panels[name] = Panel(partial(draw, name=name), height, sweep.key, beside=beside)
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


def cam_beside(system: System, low: float, high: float, what: str) -> list[Callable]:
    """The cam's lift and its derivatives beside a panel, over the same phases."""
    theta, orders = lift_curves(system.cam, len(CURVES))
    milli = bool(np.nanmax(np.abs(orders)) < SMALL)
    corners = style.corner_names(system.corners_deg).items()

    def draw(axes: Axes, k: int) -> None:
        name, unit = CURVES[k]
        axes.plot(orders[k] * (1e3 if milli else 1.0), theta, color=style.CAM, linewidth=0.9)
        phase_axis(axes, low, high)
        axes.set_ylabel(axes.get_ylabel() + what if k == 0 else "")
        axes.tick_params(left=k == 0, labelleft=k == 0, bottom=False, labelbottom=False)
        corner_lines(axes, corners, "y", named=False)
        axes.xaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 5, 10], min_n_ticks=2))
        if not what:
            axes.tick_params(axis="x", top=True, labeltop=True, labelrotation=90, labelsize=7)
            axes.set_title(f"{name}\n{'m' * milli}{unit}", loc="center")

    return [partial(draw, k=k) for k in range(len(CURVES))]
