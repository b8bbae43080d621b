"""Picture of detachment: impacts with accumulation curve and corner hits, and the contact force."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import degrees, inf, isfinite, sqrt
from statistics import median
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

from camcli.analysis.contact_loss.detachment import CriticalSpeed, Loss
from camcli.analysis.contact_loss.force import ForceCurve
from camcli.analysis.contact_loss.spread import Spread
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.analysis.speeds import Speed
from camcli.analysis.surge import LIMIT, Surge
from camcli.plots import style
from camcli.plots.axes import (
    DASHED,
    DOTTED,
    TURN_DEG,
    corner_lines,
    draw_forces,
    mark,
    mark_look,
    number_events,
    say,
    turn_axis,
)
from camcli.plots.mechanism import Outline, machine_panels
from camcli.plots.picture import Panel, Picture
from camcli.quantities import LOADS, MM_PER_INCH, RPM, THETA, labelled
from camcli.system import System, is_measured, units_of
from camcli.words.detach import (
    BURSTS_OF_THE_LOBE,
    OTHER_ENDS,
    first_loss,
    force_name,
    picture_title,
    spring_name,
)
from camcli.words.in_print import number_text
from camcli.words.loads import load
from camcli.words.surge import NOT_SIMULATED, surge_title
from camcli.words.tolerance import spread_title, worst_name

PHASES, FORCE, MACHINE = 62.0, 46.0, 50.0  # mm
WORDS = 26.0  # mm at the right above a panel, where its words would meet names of corners
TWO_COLUMNS = 110.0  # mm: in a wider panel the names of its curves stand in two
FOLD = 1e-6  # deg, before the leading lift-off, where the axis of phases begins
SAME_PHASE = 1e-3  # deg, so near to the leading lift-off an end is at it
FLAT = 36.0  # deg, less than this is shown enlarged even where all speeds are
MOST_SPEEDS = 0.6  # of all, in an enlarged part of them
BELOW_OPENING, ABOVE_CORNER, BESIDE_CORNERS = 0.06, 0.15, 0.12  # of what it shows, the room beyond
PROVED_AT = 1e-9  # relative: a speed is that of a proof so near to its range
PROVED_WIDER = 3.4  # pt, by which the disk below the mark of a proved speed is wider than it
CORNER_END, LOSS_END = "the chatter ends on a corner", "the chatter ends where contact is lost"
LONE_END = 2.6  # pt, the mark of the end of a chatter that no line goes through
JUMP = 20.0  # deg, between speeds, breaks the accumulation curve
MOST_MISSING = 1  # speeds without an end of its burst over which the curve goes on
ROOM = 0.03  # of an axis, beyond what it shows
TICKS = (1, 2, 5, 10, 20, 60)  # deg, from one tick to the next
MOST_TICKS = 9.0  # of these on an axis
NAME, NAMES_BELOW = 3.4, 4.0  # mm: a name in the legend above a panel, from it to the panel
SURGE_ROOM = 1.25  # of the fastest speed: harmonics that meet the spring beyond are not drawn
SURGE_NUMBER = 5.0  # mm, between numbers of harmonics
HIT_BELOW = 16.0  # pt, from the bottom of a panel to a mark whose number has room below it
HIT_ROOM = 4.0  # mm, between numbered hits of one corner
EMPTY, EMPTY_DEG = 0.15, 90.0  # share of the speeds, and phases, without anything: they are cut off
LEAST_ROOM = 4.0  # deg, beyond the phases that are left


@dataclass(frozen=True)
class _View:
    """Ranges of a diagram of phases (deg, counted on from `fold`) over speeds."""

    low: float
    high: float
    fold: float
    rpm: tuple[float, float]

    def phase(self, degrees: float | Sequence[float]) -> np.ndarray:
        """Phases counted on from the fold."""
        return self.fold + (np.asarray(degrees, dtype=float) - self.fold) % TURN_DEG


def draw_detach(
    study: ContactLoss,
    system: System,
    surge: Surge | None = None,
    spread: Spread | None = None,
    proved: Sequence[float] = (),
) -> Picture:
    """Picture of where contact is lost: phases over speed, forces over the turn.

    With a spring's mass its surge, with tolerances the spread of machines. proved: the speeds of
    which a proof says what happens there, rpm.
    """
    measured = is_measured(system)
    corners = style.corner_names(system.corners)
    *enlarged, whole = _views(study)
    whole = _without_empty(whole, study, system)
    if enlarged and not _is_small_part(enlarged[0], whole):
        enlarged = []
    more: dict[str, Any] = {
        "study": study,
        "corners": corners,
        "seat": system.has_seat,
        "proved": proved,
    }
    panels = {"phases": Panel(partial(_draw_phases, view=whole, **more), PHASES)}
    if enlarged:
        zoom = Panel(partial(_draw_phases, view=enlarged[0], **more), PHASES)
        panels = {"enlarged": zoom, **panels}
    full = surge is not None or spread is not None  # so that forces and springs stand abreast
    beside = 2 if full and study.forces and study.springs else 1
    if study.forces:
        names = [force_name(curve, measured) for curve in study.forces]
        draw = partial(_draw_forces, curves=study.forces, names=names, corners=corners)
        panels["forces"] = _named(Panel(draw, FORCE), len(names), beside)
    if study.springs:
        curves = [curve for _, curve in study.springs]
        names = [spring_name(*spring, units_of(system)) for spring in study.springs]
        where = f"at {number_text(curves[0].rpm)} rpm"
        draw = partial(_draw_forces, curves=curves, names=names, corners=corners, where=where)
        panels["springs"] = _named(Panel(draw, FORCE), len(names), beside)
    if surge is not None:
        wide = 1 if spread is None else 3
        panels["surge"] = Panel(partial(_draw_surge, surge=surge, study=study), FORCE, across=wide)
    if spread is not None:
        wide = 2 if surge is None else 3
        nominal = study.detachment.first
        draw = partial(
            _draw_machines, spread=spread, nominal=None if nominal is None else nominal.rpm
        )
        panels["machines"] = Panel(draw, FORCE, across=wide)
        panels["shares"] = Panel(partial(_draw_shares, spread=spread), FORCE, across=wide)
    words = first_loss(study, measured)
    if system.has_seat:
        words += f". {BURSTS_OF_THE_LOBE}"
    if surge is not None:
        words += f". {NOT_SIMULATED.capitalize()}"
    return Picture(picture_title(study), panels, caption=words)


def _named(panel: Panel, names: int, across: int) -> Panel:
    """A panel of so many named curves, with room for their names where another stands beside it."""
    if across == 1:
        return panel
    return replace(panel, across=across, above=_room_for(names))


def _room_for(names: int) -> float:
    """What a legend of so many names takes above its panel, mm."""
    return NAMES_BELOW + NAME * names if names else 0.0


def report_panels(
    study: ContactLoss,
    system: System,
    outline: Outline,
    past: Sequence[Speed],
    surge: Surge | None = None,
    spread: Spread | None = None,
) -> dict[str, Panel]:
    """The panels of a page of one machine, two abreast.

    The cam and its forces, loft and landing speed, the springs, their surge, and the machines
    within their tolerances.

    past: motions past the loss of contact, of which loft and landing speed are drawn.
    """
    drawn = draw_detach(study, system, surge, spread).panels
    units = units_of(system)
    machine = machine_panels(outline, {})["outline"]
    panels = {"outline": replace(machine, usual=True, across=2, height=MACHINE)}
    if "forces" in drawn:
        panels["forces"] = _named(drawn["forces"], len(study.forces), 2)
    first = study.detachment.first
    for name in ("max_gap_m", "max_impact_m_per_s"):
        unit, scale = units.shown(LOADS[name].unit)
        said = labelled(LOADS[name].name, unit)
        points = [(first.rpm, 0.0)] if first and past and not system.has_seat else []
        points += [(s.rpm, scale * (load(s.loads, name) or 0.0)) for s in past]
        draw = partial(_draw_load, points=points, said=said)
        panels[name] = Panel(draw, FORCE, across=2)
    abreast = 2 if "springs" in drawn and "surge" in drawn else 1
    for name in ("springs", "surge"):
        if name in drawn:
            names = len(study.springs) if name == "springs" else 0
            panels[name] = replace(drawn[name], across=abreast, above=_room_for(names))
    for name in ("machines", "shares"):
        if name in drawn:
            panels[name] = replace(drawn[name], across=2)
    return panels


def _draw_load(axes: Axes, points: Sequence[tuple[float, float]], said: str) -> None:
    axes.set_ylabel(said)
    if not points:
        say(axes, "contact holds over the whole range")
        return
    axes.plot(*zip(*points, strict=True), "o-", color=style.IMPACT, ms=0.8, lw=0.6)
    axes.set(xlabel=RPM.label, ylim=(0.0, None))


def _draw_surge(axes: Axes, surge: Surge, study: ContactLoss) -> None:
    """The harmonics where they meet the spring, by speed; those over the limit stand out."""
    first = study.detachment.first
    fastest = max(speed.rpm for speed in study.speeds)
    if first is not None and first.finite:
        fastest = max(fastest, first.rpm)
        axes.axvline(first.rpm, color=style.DETACHMENT, lw=0.8, zorder=1, label="first detachment")
    shown = [one for one in surge.harmonics if one.rpm <= SURGE_ROOM * fastest]
    look: dict[str, Any] = {"color": style.TROUBLE, "lw": 0.8, "ls": DASHED, "zorder": 1}
    axes.axhline(LIMIT, label="usual limit of resonance", **look)
    for one in shown:
        colour = style.TROUBLE if one.strong else style.CAM
        axes.plot([one.rpm, one.rpm], [0.0, one.factor], color=colour, lw=1.2)
        axes.plot([one.rpm], [one.factor], "o", color=colour, ms=3.0)
    top = max([LIMIT, *(one.factor for one in shown)])
    axes.set(xlabel=RPM.label, ylabel="resonance factor", ylim=(0.0, 1.2 * top))
    wide = axes.get_window_extent().width / style.DPI * MM_PER_INCH
    low, high = axes.get_xlim()
    room = SURGE_NUMBER / wide * (high - low)
    named = list[float]()
    for one in sorted(shown, key=lambda one: -one.factor):  # the strong ones in any case
        if all(abs(one.rpm - other) > room for other in named):
            axes.annotate(
                str(one.number), (one.rpm, one.factor), xytext=(0, 3), ha="center",
                textcoords="offset points", size=style.NOTE,
            )  # fmt: skip
            named.append(one.rpm)
    axes.set_title(surge_title(surge))


def _draw_machines(axes: Axes, spread: Spread, nominal: float | None) -> None:
    """How many machines hold up to which speed, the machine of the scene, and the worst of all.

    nominal: the speed up to which the machine of the scene holds, rpm.
    """
    known = [rpm for rpm in spread.speeds if isfinite(rpm)]
    if not known or not isfinite(spread.worst):
        say(axes, "contact is never lost")
        return
    bins = max(5, min(30, round(sqrt(len(known)))))
    axes.hist(known, bins=bins, color=style.SIMULATED, edgecolor="white", linewidth=0.4)
    axes.axvline(median(known), color=style.CAM, lw=1.0, label="half of the machines")
    if nominal is not None and isfinite(nominal):
        look: dict[str, Any] = {"color": style.DETACHMENT, "lw": 1.4, "ls": DASHED}
        axes.axvline(nominal, label="the machine as given", **look)
    axes.axvline(spread.worst, color=style.TROUBLE, lw=1.4, ls=DOTTED, label="the worst machine")
    axes.set(xlabel=labelled("holds up to", RPM.unit), ylabel="machines")
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.set_title(spread_title(spread.worst))


def _draw_shares(axes: Axes, spread: Spread) -> None:
    """Which number explains how much of the variance, the most at the top."""
    if not spread.shares:
        say(axes, "too few machines to tell\nwhich number matters")
        return
    rows = sorted(spread.shares.items(), key=lambda row: row[1])
    axes.barh(
        range(len(rows)), [100.0 * share for _, share in rows], color=style.SIMULATED, height=0.5
    )
    axes.set(xlim=(0.0, 100.0), xlabel=labelled("share of the variance", "%"))
    axes.set_yticks(range(len(rows)), [worst_name(key, spread.numbers[key]) for key, _ in rows])
    axes.tick_params(axis="y", labelsize=style.NOTE, length=0.0)


# --- phases over speed


def _views(study: ContactLoss) -> list[_View]:
    """The whole range; before it, enlarged, the speeds up to the last corner first reached."""
    span = _span(study)
    lead = _leading(study)
    if lead is None:
        return [_View(0.0, TURN_DEG, 0.0, span)]
    opening = degrees(lead.opens.theta)
    room = TURN_DEG * ROOM
    whole = _View(opening - room, opening + TURN_DEG + room, opening - FOLD, span)
    enlarged = _enlarged(study, lead, whole)
    return [whole] if enlarged is None else [enlarged, whole]


def _span(study: ContactLoss) -> tuple[float, float]:
    """The speeds of the study with some room beside them, rpm."""
    speeds = [speed.rpm for speed in study.speeds]
    slowest, fastest = min(speeds), max(speeds)
    room = ROOM * (fastest - slowest) or 0.01 * fastest
    return slowest - room, fastest + room


def _enlarged(study: ContactLoss, lead: Loss, whole: _View) -> _View | None:
    """The part of `whole` from an opening to the last corner first reached.

    Its phases begin where the region `lead` opens. It has all speeds where this part fills most of
    them, and is None where it would show hardly more than `whole`, or no corner is reached.
    """
    reached = _first_reached(study, lead.region.name)
    if not reached:
        return None
    low, high = _phases_reached(study, lead, reached, whole)
    slow, fast = _speeds_reached(study, lead, reached, whole.rpm)
    if fast - slow < MOST_SPEEDS * (whole.rpm[1] - whole.rpm[0]):
        return replace(whole, low=low, high=high, rpm=(slow, fast))
    if high - low < FLAT:
        return replace(whole, low=low, high=high)
    return None


def _is_small_part(view: _View, whole: _View) -> bool:
    """Whether a view shows so few of the speeds, or of the phases, that it is worth a panel."""
    wide = view.rpm[1] - view.rpm[0]
    return wide < MOST_SPEEDS * (whole.rpm[1] - whole.rpm[0]) or view.high - view.low < FLAT


def _phases_reached(
    study: ContactLoss, lead: Loss, reached: Sequence[CriticalSpeed], whole: _View
) -> tuple[float, float]:
    """From the opening to the last of the corners, with room on both sides; deg.

    What happens beyond the only corner belongs to it.
    """
    phases = [degrees(corner.theta) for corner in reached]
    if len(reached) == 1:
        phases += [end for name, end, _ in _ends(study) if name == lead.region.name]
    opening = degrees(lead.opens.theta)
    highest = float(whole.phase(phases).max())
    tall = highest - opening
    return opening - BELOW_OPENING * tall, highest + ABOVE_CORNER * tall


def _speeds_reached(
    study: ContactLoss,
    lead: Loss,
    reached: Sequence[CriticalSpeed],
    span: tuple[float, float],
) -> tuple[float, float]:
    """From the opening to the last of the corners and the hits of the first, with room; rpm."""
    rpms = [corner.rpm for corner in reached]
    rpms += [hit.rpm for hit in study.hits if hit.corner == reached[0].region]
    last = max(rpms)
    room = BESIDE_CORNERS * (last - lead.opens.rpm)
    return max(span[0], lead.opens.rpm - room), min(span[1], last + room)


def _first_reached(study: ContactLoss, region: str) -> list[CriticalSpeed]:
    """The lowest speeds at which chatters from a region reach a corner, one each, of two corners.

    Of `study.accumulation`, in the order of their speeds.
    """
    reached: dict[str, CriticalSpeed] = {}
    for critical in sorted(study.accumulation, key=lambda critical: critical.rpm):
        if critical.burst == region and critical.region not in reached:
            reached[critical.region] = critical
    return list(reached.values())[:2]


def _without_empty(view: _View, study: ContactLoss, system: System) -> _View:
    """The range without the speeds below all that is shown, and a wide gap between its phases."""
    slow, fast = view.rpm
    shown = [(rpm, theta) for rpm, theta in _places(study, system) if slow < rpm < fast]
    if not shown:
        return view
    least = min(rpm for rpm, _ in shown)
    if least - slow > EMPTY * (fast - slow):
        slow = least - 2.0 * ROOM * (fast - least)

    # gaps[k]: from phase k to the next one, from the last one to the first of the next turn
    phases = np.unique([theta % TURN_DEG for _, theta in shown])
    gaps = np.diff(np.append(phases, phases[0] + TURN_DEG))
    k = int(np.argmax(gaps))
    gap = float(gaps[k])
    if gap < EMPTY_DEG or study.completion:
        return replace(view, rpm=(slow, fast))
    low = float(phases[(k + 1) % len(phases)])
    wide = TURN_DEG - gap
    room = max(2.0 * ROOM * wide, LEAST_ROOM)
    return _View(low - room, low + wide + room, low - 0.5 * gap, (slow, fast))


def _places(study: ContactLoss, system: System) -> Iterator[tuple[float, float]]:
    """Speed and phase (deg) of all that the panel of phases shows."""
    for speed in study.speeds:
        for theta in speed.impacts:
            yield speed.rpm, degrees(theta)
    for _, end, rpm in _ends(study):
        yield rpm, end
    for critical in (*study.accumulation, *study.completion):
        yield critical.rpm, degrees(critical.theta)
    corners = style.corner_names(system.corners)
    for hit in study.hits:
        if hit.corner in corners:
            yield hit.rpm, corners[hit.corner]
    first = study.detachment.first
    if first is not None:
        yield first.rpm, degrees(first.theta)


def _leading(study: ContactLoss) -> Loss | None:
    """The region whose bursts have most to show: the axis of phases begins where they do."""
    first = study.detachment.first
    if first is None:
        return None
    marks = Counter(c.burst for c in study.accumulation)
    name = marks.most_common(1)[0][0] if marks else first.region
    return next(loss for loss in study.detachment.losses if loss.region.name == name)


def _ends(study: ContactLoss) -> Iterator[tuple[str, float, float]]:
    """Region, end (deg) and speed of every complete burst."""
    for speed in study.speeds:
        for burst in speed.bursts:
            if burst.end is not None:
                yield burst.region, degrees(burst.end), speed.rpm


def _draw_phases(
    axes: Axes,
    view: _View,
    study: ContactLoss,
    corners: dict[str, float],
    seat: bool,
    proved: Sequence[float],
) -> None:
    """The panel of phases against speed: impacts, ends of chatter, critical speeds, corner hits.

    corners: phase (deg) of each corner of the cam by its name. A chatter ends, or accumulates, at
    the phase where the follower comes to rest on the cam again. seat: whether the follower comes to
    a seat, so that chatters begin without a loss of contact too. proved: as of `draw_detach`.
    """
    _phase_axes(axes, view, corners)
    rpm = [speed.rpm for speed in study.speeds for _ in speed.impacts]
    impacts = view.phase([degrees(x) for speed in study.speeds for x in speed.impacts])
    axes.plot(rpm, impacts, "o", color=style.SIMULATED, ms=1.8, mew=0.0, label="impacts, simulated")
    _draw_ends(axes, view, study)
    first = study.detachment.first
    if first is not None:
        at = view.phase([degrees(first.theta)])
        mark(axes, "detachment", [first.rpm], at, label="first detachment", zorder=5)
    if seat:
        _draw_other_ends(axes, view, study)
    _draw_critical_ends(axes, view, study, corners)
    _draw_hits(axes, view, study, corners)
    _draw_proved(axes, view, study, corners, proved)


def _draw_proved(
    axes: Axes,
    view: _View,
    study: ContactLoss,
    corners: dict[str, float],
    proved: Sequence[float],
) -> None:
    """A disk below the marks of the first detachment and of the corner hits that are proved."""
    asked = [(hit.rpm, corners[hit.corner]) for hit in study.hits if hit.corner in corners]
    first = study.detachment.first
    if first is not None:
        asked.append((first.rpm, degrees(first.theta)))
    shown = [
        (rpm, phase)
        for rpm, phase in asked
        if any(abs(rpm - speed) <= PROVED_AT * speed for speed in proved)
    ]
    if shown:
        rpms, phases = zip(*shown, strict=True)
        size = mark_look("detachment")["ms"] + PROVED_WIDER
        look: dict[str, Any] = {"color": style.PROVED, "ms": size, "mew": 0.0, "zorder": 3.5}
        axes.plot(rpms, view.phase(phases), "o", label="proved", **look)


def _phase_axes(axes: Axes, view: _View, corners: dict[str, float]) -> None:
    """The ranges of a view, ticks in degrees of the turn, and the corners in both turns."""
    axes.set(xlim=view.rpm, ylim=(view.low, view.high))
    further = ",\non into the next turn" if view.high > TURN_DEG else ""
    axes.set(xlabel=RPM.label, ylabel=labelled(r"phase $\theta$", THETA.unit) + further)
    wide = view.high - view.low
    step = next(step for step in TICKS if wide <= MOST_TICKS * step)
    axes.yaxis.set_major_locator(MultipleLocator(step))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value % TURN_DEG:g}"))
    lines = []
    for name, corner in corners.items():
        phase = float(view.phase(corner))
        lines += [(name, phase), (name, phase + TURN_DEG)]
    corner_lines(axes, lines, "y")


def _draw_ends(axes: Axes, view: _View, study: ContactLoss) -> None:
    """Where the chatters that follow a loss of contact end: a line for each that goes on."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for region, end, speed in _ends(study):
        curves.setdefault(region, []).append((speed, float(view.phase(end))))
    speeds = [speed.rpm for speed in study.speeds]
    lines = [line for region in sorted(curves) for line in joined(curves[region], speeds)]
    longer = [line for line in lines if len(line) > 1]
    alone = [line for line in lines if len(line) == 1]
    for some, size in ((longer, 1.4), (alone, LONE_END)):
        places: list[tuple[float, float]] = []
        for line in some:
            places += [*line, (np.nan, np.nan)]  # a gap before the next line
        if places:
            x, y = np.array(places[:-1]).T
            look: dict[str, Any] = {"color": style.CHATTER, "lw": 1.4, "ms": size, "mew": 0.0}
            axes.plot(x, y, "o-", label="end of the chatter, computed", **look)


def _draw_other_ends(axes: Axes, view: _View, study: ContactLoss) -> None:
    """Where the chatters end that the opening blow or the seat begins."""
    others = [(speed.rpm, degrees(x)) for speed in study.speeds for x in speed.other_rests]
    if others:
        x, y = np.array(others).T
        look: dict[str, Any] = {"color": style.CHATTER, "ms": 3.0, "mew": 0.7, "zorder": 3}
        axes.plot(x, view.phase(y), "x", label=OTHER_ENDS, **look)


def _draw_critical_ends(
    axes: Axes, view: _View, study: ContactLoss, corners: dict[str, float]
) -> None:
    """The critical speeds at which a chatter ends on a corner, or where contact is lost again.

    At the speed of `study.completion` it needs a whole turn to end. Where contact is lost at the
    same phase at every speed, at which the axis begins, this end is drawn a turn later.
    """
    on_corner = [(one.rpm, float(view.phase(degrees(one.theta)))) for one in study.accumulation]
    at_loss: list[tuple[float, float]] = []
    for one in study.completion:
        theta = degrees(one.theta)
        phase = float(view.phase(theta))
        if phase - view.fold < SAME_PHASE:
            phase += TURN_DEG
        is_on_corner = any(abs(theta - corner) < SAME_PHASE for corner in corners.values())
        (on_corner if is_on_corner else at_loss).append((one.rpm, phase))
    for ends, label in ((on_corner, CORNER_END), (at_loss, LOSS_END)):
        if ends:
            x, y = np.array(ends).T
            mark(axes, "chatter", x, y, label=label, zorder=4)


def joined(
    ends: Sequence[tuple[float, float]], speeds: Sequence[float] = ()
) -> list[list[tuple[float, float]]]:
    """Ends of bursts (speed, phase in deg) as lines, for a turn may have several of a region.

    A line goes on, from speed to speed, to the phase next to its last one, if it is within JUMP.
    It ends where more than MOST_MISSING speeds have no such end.

    speeds: all that were looked at; without them, those of the ends.
    """
    rising = sorted(set(speeds) | {speed for speed, _ in ends})
    rank = {speed: k for k, speed in enumerate(rising)}
    lines: list[list[tuple[float, float]]] = []
    for speed, phase in sorted(ends):
        before = []
        for line in lines:
            last_speed, last_phase = line[-1]
            skipped = rank[speed] - rank[last_speed] - 1
            if 0 <= skipped <= MOST_MISSING and abs(last_phase - phase) <= JUMP:
                before.append(line)
        if before:
            latest = max(line[-1][0] for line in before)
            there = [line for line in before if line[-1][0] == latest]
            min(there, key=lambda line: abs(line[-1][1] - phase)).append((speed, phase))
        else:
            lines.append([(speed, phase)])
    return lines


def _draw_hits(axes: Axes, view: _View, study: ContactLoss, corners: dict[str, float]) -> None:
    """Speeds at which the n-th impact lands on a corner, with their numbers n.

    Above the panel where they are those of one corner; else beside the marks, the first ones.
    """
    hits = [hit for hit in study.hits if hit.corner in corners]
    at = view.phase([corners[hit.corner] for hit in hits])
    if hits:
        mark(axes, "corner-impact", [hit.rpm for hit in hits], at, label="n-th impact on a corner")
    seen = [
        hit
        for hit, y in zip(hits, at, strict=True)
        if view.rpm[0] < hit.rpm < view.rpm[1] and view.low < y < view.high
    ]
    if len({hit.corner for hit in seen}) == 1:
        number_events(axes, [(hit.impact, hit.rpm) for hit in seen], named=True)
        return
    last: dict[str, float] = {}
    wide = axes.get_window_extent().width / style.DPI * MM_PER_INCH
    room = HIT_ROOM / wide * (view.rpm[1] - view.rpm[0])
    high = axes.get_window_extent().height / style.DPI * 72.0
    lowest = HIT_BELOW / high * (view.high - view.low)
    for hit, y in zip(hits, at, strict=True):
        inside = view.rpm[0] < hit.rpm < view.rpm[1] and view.low < y < view.high
        away = abs(last.get(hit.corner, inf) - hit.rpm)
        if inside and away > room:
            last[hit.corner] = hit.rpm
            below = y - view.low > lowest
            look: dict[str, Any] = {
                "textcoords": "offset points",
                "xytext": (3, -4 if below else 4),
            }
            look["va"] = "top" if below else "bottom"
            look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
            axes.annotate(str(hit.impact), (hit.rpm, y), size=style.NOTE, **look)


# --- forces over the turn


def _draw_forces(
    axes: Axes,
    curves: Sequence[ForceCurve],
    names: Sequence[str],
    corners: dict[str, float],
    where: str = "",
) -> None:
    draw_forces(axes, curves, names)
    wide = axes.get_window_extent().width / style.DPI * MM_PER_INCH
    words_from = 360.0 * (1.0 - WORDS / wide)  # deg
    meet = bool(where) and any(corner > words_from for corner in corners.values())
    turn_axis(axes, corners, named=not meet)
    axes.set_title(where)
    columns = 2 if wide > TWO_COLUMNS else 1
    axes.legend(
        fontsize=style.NOTE, ncols=columns, loc="lower left", bbox_to_anchor=(0.0, 1.1)
    )  # above the corners
