"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from camcli.analysis.integrate import Settings
from camcli.analysis.speeds import Speed
from camcli.analysis.sweep import BOTH, Sweep
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import (
    ENLARGED_SHARE,
    LIFT_PANELS,
    NARROW_DEG,
    TURN_DEG,
    axis_name,
    corner_lines,
    gathered,
    lift_curves,
    number_events,
    padded,
    phase_axis,
    phase_range,
    say,
    strobe_axis,
    trouble_ticks,
)
from camcli.plots.critical_speeds import event_lists, numbered
from camcli.plots.density import PER_MM, THICKNESS, WIDE, Cloud, Columns, Image, is_free
from camcli.plots.picture import COMPACT, Panel, Picture
from camcli.quantities import EXPONENT, drawn
from camcli.system import System, kind_of_cam, units_of
from camcli.words.sweep import NO_STROBE, diagram_title, diagram_words

if TYPE_CHECKING:
    from camcli.analysis.explain.changes import CriticalEvent

ENLARGED_PART, FEW = 0.3, 10  # of the positions, where most of more speeds than a few are
SECTIONS = ("impacts", "strobe")
Limits = Mapping[str, tuple[float, float] | None]  # of a section's panel: deg, m; None: all
NO_LIMITS: Limits = {}
STRIP = 26.0  # mm, height of the strip of exponents
BESIDE = 28  # letters of a line below the cam beside the phases
CONSTANT = 1e-6  # of the lift: positions this close are one, and no panel shows it
UNKNOWN = "undecided after rests"
WIDER, PALER = 7, 0.3  # cells thick and opacity, what is carried down where it is carried up too
WAYS: dict[str, dict[str, Any]] = {  # what the legend shows of both ways
    "up": {"lw": 1.0},
    "down": {"lw": 3.0, "alpha": PALER},
}
KINDS = {**style.KINDS, UNKNOWN: style.UNDECIDED}  # colours, see `kind_of`


@dataclass(frozen=True)
class DrawnSpeeds:
    """Speeds in their own order, what their points come to; None for what was not recorded."""

    values: np.ndarray
    status: np.ndarray
    kinds: list[str]  # of the motions, see `kind_of`
    exponents: np.ndarray  # nan where not known
    impacts: Cloud | None
    strobe: Cloud | None

    @classmethod
    def of(cls, speeds: Sequence[Speed]) -> DrawnSpeeds:
        """Pass over all speeds once."""
        clouds = {name: Cloud(len(speeds)) for name in SECTIONS}
        found = set()
        rows = []
        kinds = []
        for k, speed in enumerate(speeds):
            rows.append((speed.value, speed.status, speed.exponent))
            kinds.append(kind_of(speed))
            for name, values in recorded(speed).items():
                clouds[name].take(k, values)
                found.add(name)
        some = [clouds[name] if name in found else None for name in SECTIONS]
        values, status, exponents = np.array(rows, dtype=float).reshape(-1, 3).T
        return cls(values, status.astype(int), kinds, exponents, *some)

    @property
    def troubled(self) -> np.ndarray:
        """Values whose status is not ok, ascending."""
        return np.sort(self.values[self.status != Status.OK])


def kind_of(speed: Speed) -> str:
    """What its motion is, in a few words that have a colour each."""
    return style.kind_of_label(speed.label) if speed.known else UNKNOWN


def colour_of(kind: str) -> str:
    """The colour of a kind of motion, that of its basin."""
    return KINDS[kind]


def in_order(kinds: Iterable[str]) -> list[str]:
    """Each kind once: what stays on the cam, periods from the shortest, then what has none."""
    return sorted(set(kinds), key=list(KINDS).index)


def recorded(speed: Speed) -> dict[str, np.ndarray]:
    """The finite phases (impacts) and positions (strobe) of a speed that may come from a disk."""
    columns = {name: getattr(speed, name) for name in SECTIONS}
    values = {k: np.asarray(v[1], dtype=float) for k, v in columns.items() if v is not None}
    return {name: own[np.isfinite(own)] for name, own in values.items()}


def draw_sweep(
    sweep: Sweep,
    system: System,
    settings: Settings,
    events: Sequence[CriticalEvent] = (),
    branches: Sequence[Any] = (),
    zooms: Sequence[tuple[float, float]] = (),
    limits: Limits = NO_LIMITS,
    shown_cam: str = "",
) -> Picture:
    """Picture of a sweep; `settings` tell how its orbits were started.

    `events` are listed below the title and numbered above the panels; `branches` are solved orbits
    with values, stable, phases and q; `zooms` are parts of the range, enlarged; `limits` are the
    phases (deg) and positions (m) to show. `shown_cam` says at which value the cam beside the
    phases is drawn, where it varies. The speeds are read twice, one at a time.
    """
    survey = DrawnSpeeds.of(sweep.speeds)
    found = numbered(events)
    panels = cloud_panels(survey, sweep, system, zooms, branches, limits, shown_cam)
    if np.isfinite(survey.exponents).any():
        draw_strip = partial(_draw_exponents, survey, axis_name(sweep.key))
        panels["exponents"] = Panel(draw_strip, STRIP, sweep.key, asked=True)
        panels = dict(sorted(panels.items(), key=lambda item: item[1].across))  # zooms last
    order = list(panels)

    def draw(axes: Axes, name: str) -> None:
        panels[name].draw(axes)
        if name != "exponents":
            for branch in branches:
                _draw_branch(axes, branch, [branch.q] if "strobe" in name else branch.phases)
        pairs = [(number, event.rpm) for number, event in found]
        number_events(axes, pairs, named=name == order[0])
        low, high = axes.get_xlim()
        trouble_ticks(axes, survey.troubled[(survey.troubled >= low) & (survey.troubled <= high)])

    many = {name: replace(panel, draw=partial(draw, name=name)) for name, panel in panels.items()}
    if not panels:
        many = {"speeds": Panel(lambda axes: say(axes, "nothing was recorded"), 30.0)}
    unknown = survey.kinds.count(UNKNOWN)
    values = survey.values.tolist()
    kind = kind_of_cam(system)
    words = diagram_words(sweep, settings, values, survey.status.tolist(), unknown, kind)
    if "strobe" in many and not many["strobe"].usual:
        words += f"; {NO_STROBE}"
    title = diagram_title(sweep, values, kind)
    return Picture(title, many, caption=words, lists=event_lists(found), tall=COMPACT)


def _draw_branch(axes: Axes, branch: Any, columns: Sequence[Sequence[float]]) -> None:
    """Solved orbits, stable ones solid and unstable ones dashed; the range stays as it is."""
    low, high = axes.get_xlim()
    stable = np.asarray(branch.stable)
    x = np.where((np.asarray(branch.values) >= low) & (np.asarray(branch.values) <= high),
                 branch.values, np.nan)  # fmt: skip
    for column in columns:
        for own, dashes, what in ((stable, "-", "stable"), (~stable, (0, (3, 1.5)), "unstable")):
            y = np.where(own, column, np.nan)
            axes.plot(x, y, color="white", lw=1.8, ls="-", zorder=4, scaley=False, scalex=False)
            axes.plot(x, y, color=style.TROUBLE, lw=0.8, ls=dashes, zorder=5, scaley=False,
                      scalex=False, label=f"solved, {what}")  # fmt: skip


def _draw_exponents(survey: DrawnSpeeds, name: str, axes: Axes) -> None:
    """The largest exponent over what is varied, in the colour of the motion; none at rest."""
    columns = Columns.of(survey.values)
    axes.axhline(0.0, color=style.GUIDE, lw=0.6)
    colours = [colour_of(kind) for kind in survey.kinds]
    known = np.isfinite(survey.exponents)
    shades = [colour for colour, seen in zip(colours, known, strict=True) if seen]
    axes.scatter(survey.values[known], survey.exponents[known], s=2.0, c=shades, lw=0, zorder=3)
    words = f"{EXPONENT.head}\n({drawn(EXPONENT.unit)})"  # the strip is too low for one line
    axes.set(xlim=(columns.low, columns.high), xlabel=name, ylabel=words)


# --- clouds of points


@dataclass(frozen=True)
class _View:
    """What a panel of points shows: a section within a range, over some columns; mm."""

    section: str
    limits: tuple[float, float]
    columns: Columns
    height: float
    across: int = 1


def _views(
    survey: DrawnSpeeds,
    zooms: Sequence[tuple[float, float]],
    lift: float,
    branches: Sequence[Any],
    given: Limits,
) -> dict[str, _View]:
    """The whole range; phases enlarged where most have few; parts of the range.

    The ranges hold the points and the solved branches, where no range is given.
    """
    if survey.impacts is None and survey.strobe is None:
        return {}
    views = {}
    every = Columns.of(survey.values)
    positions = partial(padded, zero=lift)
    chosen = {name: own for name, own in given.items() if own is not None}
    for name in SECTIONS:
        if name in chosen and getattr(survey, name) is not None:
            views[name] = _View(name, chosen[name], every, 72.0)
    if (cloud := survey.impacts) is not None and "impacts" not in chosen:
        solved = _solved(branches, "impacts", every)
        shown = np.append(cloud.extremes(), solved)
        enlarged = enlarged_range(cloud, solved)
        height = 72.0 if enlarged is None else 48.0
        views["impacts"] = _View("impacts", phase_range(shown), every, height)
        if enlarged is not None:
            views["enlarged"] = _View("impacts", enlarged, every, 60.0)
    if (cloud := survey.strobe) is not None and "strobe" not in chosen:
        shown = np.append(cloud.extremes(), _solved(branches, "strobe", every))
        views["strobe"] = _View("strobe", positions(shown), every, 50.0)
        low, high = cloud.ends()
        if len(low) > FEW:
            inner = positions([np.quantile(low, 0.1), np.quantile(high, 0.9)])
            if np.ptp(inner) < ENLARGED_PART * np.ptp(views["strobe"].limits):
                views["strobe enlarged"] = _View("strobe", inner, every, 60.0)
    for section, limits in (("impacts", phase_range), ("strobe", positions)):
        for k, span in enumerate(zooms if section in views else (), 1):
            columns = Columns.of(survey.values, WIDE // 2, span)
            low, high = getattr(survey, section).ends(columns.bin_of_speed >= 0)
            seen = gathered(low, high) if section == "impacts" else np.append(low, high)
            seen = np.append(seen, _solved(branches, section, columns))
            views[f"{section} zoom {k}"] = _View(section, limits(seen), columns, 50.0, 2)
    return views


def _solved(branches: Sequence[Any], section: str, columns: Columns) -> np.ndarray:
    """Phases or positions of solved orbits whose parameter lies in the columns."""
    found = [np.empty(0)]
    for branch in branches:
        values = np.asarray(branch.values)
        inside = (values >= columns.low) & (values <= columns.high)
        lines = branch.phases if section == "impacts" else [branch.q]
        found += [np.asarray(line, dtype=float)[inside] for line in lines]
    every = np.concatenate(found)
    return every[np.isfinite(every)]


def cloud_panels(
    survey: DrawnSpeeds,
    sweep: Sweep,
    system: System,
    zooms: Sequence[tuple[float, float]] = (),
    branches: Sequence[Any] = (),
    limits: Limits = NO_LIMITS,
    shown_cam: str = "",
) -> dict[str, Panel]:
    """Panels of impacts and strobe positions over the speeds, whole, enlarged and in parts.

    The points of a panel are an image for each kind of motion and each way in which the speeds were
    carried: all images are filled in one pass over the speeds. shown_cam: what stands below the
    cam beside them.
    """
    views = _views(survey, zooms, system.lift, branches, limits)
    kinds = in_order(survey.kinds)
    ways = [str(way[0]) if sweep.direction == BOTH else "up" for way in sweep.ways]
    ways = ways or ["up"] * len(survey.kinds)
    images = {
        (name, kind, way): Image(
            view.columns,
            *view.limits,
            round(view.height * PER_MM),
            WIDER if way == "down" else THICKNESS,
        )
        for name, view in views.items()
        for kind in kinds
        for way in sorted(set(ways))
    }

    if views:  # reading the speeds once more takes time
        for k, speed in enumerate(sweep.speeds):
            seen = recorded(speed)
            for name, view in views.items():
                if view.section in seen:
                    images[name, survey.kinds[k], ways[k]].take(k, seen[view.section])

    def draw(axes: Axes, name: str) -> None:
        view = views[name]
        for way in sorted(set(ways)):  # down first: it is the wider one
            for kind in kinds:
                images[name, kind, way].draw(axes, colour_of(kind), PALER if way == "down" else 1.0)
        for kind in kinds:
            axes.plot([], [], "s", color=colour_of(kind), ms=4, label=kind)
        if sweep.direction == BOTH:
            for way in sorted(set(ways), reverse=True):
                axes.plot([], [], color=style.CAM, label=f"carried {way}", **WAYS[way])
        axes.set_xlabel(axis_name(sweep.key))
        if view.section == "strobe":
            enlarged = ", enlarged" if name.endswith("enlarged") else ""
            strobe_axis(axes.yaxis, system, enlarged)
        else:
            phase_axis(axes, *view.limits)
            corner_lines(axes, style.corner_names(system.corners).items(), "y")
        if not getattr(survey, view.section).count.any():
            what = "whole turn recorded" if view.section == "strobe" else "impact"
            say(axes, f"no {what} at any of these speeds")

    panels = {}
    for name, view in views.items():
        words = ", enlarged" if name == "enlarged" else ""
        whole = view.across == 1 and view.section == "impacts"
        beside = cam_beside(system, *view.limits, words, shown_cam) if whole else ()
        one_point = name == "strobe" and "impacts" in views and _is_one(survey, system)
        panels[name] = Panel(
            partial(draw, name=name),
            view.height,
            sweep.key if view.across == 1 else "",
            view.across,
            usual=not one_point,
            beside=beside,
            shown_in=_shown_in(name, view, views),
        )
    return panels


def _is_one(survey: DrawnSpeeds, system: System) -> bool:
    """Whether several values have one stroboscopic position, as a valve that is shut then."""
    if survey.strobe is None:
        return False
    low, high = survey.strobe.ends()
    return len(low) > 1 and high.max() - low.min() <= CONSTANT * system.lift


def _shown_in(
    name: str, view: _View, views: Mapping[str, _View]
) -> dict[str, Callable[[Axes, str], None]]:
    """The bands in other panels that mark which part of them this panel shows."""
    if name.endswith("enlarged"):
        return {view.section: partial(_band, way="y", span=view.limits)}
    if view.across == 1:
        return {}
    wider = [other for other in (view.section, "enlarged", "strobe enlarged") if other in views]
    ends = view.columns.low, view.columns.high
    return {
        other: partial(_band, way="x", span=ends)
        for other in wider
        if views[other].section == view.section
    }


def _band(axes: Axes, letter: str, way: str, span: tuple[float, float]) -> None:
    """A range of an axis that another panel shows enlarged, with the letter of that panel."""
    look: dict[str, Any] = {"color": style.BAND, "linewidth": 0, "zorder": 0}
    low, high = span
    if way == "x":
        axes.axvspan(*span, **look)
        beside = axes.get_xaxis_transform()
        ends = [(high, "left"), (low, "right")]
        places = [(x, y, ha, va) for y, va in ((0.98, "top"), (0.02, "bottom")) for x, ha in ends]
    else:
        axes.axhspan(*span, **look)
        beside = axes.get_yaxis_transform()
        ends = [(high, "bottom"), (low, "top")]
        places = [(x, y, ha, va) for x, ha in ((0.99, "right"), (0.01, "left")) for y, va in ends]
    _write_beside_points(axes, letter, places, beside)


def _write_beside_points(axes: Axes, letter: str, places: Sequence[Any], system: Any) -> None:
    """Write a letter at the first of some places where no points are, else at the first.

    places: x, y, ha and va of each, in a system of matplotlib's.
    """
    look: dict[str, Any] = {"size": style.NOTE, "color": style.CAM, "zorder": 4}
    look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8}
    text = axes.text(0.0, 0.0, letter, transform=system, **look)
    panel = axes.get_window_extent().padded(1.0)
    for x, y, ha, va in (*places, places[0]):
        text.set(x=x, y=y, ha=ha, va=va)
        box = text.get_window_extent()
        inside = panel.containsx(box.x0) and panel.containsx(box.x1)
        if inside and panel.containsy(box.y0) and panel.containsy(box.y1) and is_free(axes, box):
            return


def enlarged_range(
    cloud: Cloud, solved: np.ndarray | Sequence[float] = ()
) -> tuple[float, float] | None:
    """Phases that deserve an enlarged panel: many speeds impact there and nowhere else.

    None where the usual panel of these points and solved phases shows no more.
    """
    if phase_range(np.append(cloud.extremes(), solved)) != (0.0, TURN_DEG):
        return None
    low, high = cloud.ends()
    narrow = high - low <= NARROW_DEG / 2.0
    if not len(low) or narrow.mean() < ENLARGED_SHARE:
        return None
    first, last = padded(np.concatenate([low[narrow], high[narrow]]), 5.0)
    return (max(first, 0.0), min(last, TURN_DEG)) if last - first <= NARROW_DEG else None


def cam_beside(
    system: System, low: float, high: float, what: str, below: str = ""
) -> list[Callable]:
    """What draws the cam's lift and its two derivatives beside a panel, over the same phases.

    low, high: the panel's phases, deg. what: words behind the name of its axis where the panel
    enlarges another one; empty for the panel of all phases.
    below: words below all three.
    Returns a function of the axes for each of the three.
    """
    theta, orders = lift_curves(system.cam, len(LIFT_PANELS))
    units = units_of(system)
    corners = style.corner_names(system.corners).items()

    def draw(axes: Axes, k: int) -> None:
        """The lift (k = 0) or its k-th derivative; the phase axis is named beside the first."""
        quantity = list(LIFT_PANELS.values())[k]
        axes.plot(orders[k] * units.per_m, theta, color=style.CAM, linewidth=0.9)
        phase_axis(axes, low, high)
        axes.set_ylabel(axes.get_ylabel() + what if k == 0 else "")
        axes.tick_params(left=k == 0, labelleft=k == 0, bottom=False, labelbottom=False)
        corner_lines(axes, corners, "y", named=False)
        axes.xaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 4, 5, 10], min_n_ticks=2))
        axes.tick_params(axis="x", top=True, labeltop=True, labelrotation=90, labelsize=7)
        axes.set_title(quantity.name, loc="center", size=style.WITH_INDEX)
        axes.xaxis.set_label_position("top")
        axes.set_xlabel(drawn(units.shown(quantity.unit)[0]), size=style.NOTE)
        if below and k == len(LIFT_PANELS) // 2:
            lines = textwrap.fill(below, BESIDE)
            note = axes.annotate(
                lines, (0.5, 0.0), (0, -3), xycoords="axes fraction", textcoords="offset points",
                ha="center", va="top", size=style.NOTE,
            )  # fmt: skip
            note.set_in_layout(False)  # it is wider than the curve, and has room under all three

    return [partial(draw, k=k) for k in range(len(LIFT_PANELS))]
