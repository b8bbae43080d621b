"""The machine drawn: the cam's outline, its circles and corners, and the follower on it.

The follower moves along a line through the cam's axis, at R(theta) = base radius + c - lowest c
from it, with a knife edge; an eccentric is a circle under a flat face. The cam turns
counterclockwise; the follower stands above it. With a rocker the drawing is that of the lobe, and
of what runs on it: lifts and gaps are rocker_ratio times smaller than the valve's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import asin, degrees, hypot
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon
from matplotlib.patheffects import withStroke

from camcli.analysis.lobe import Face, Lobe
from camcli.cams import ArcsCam, EccentricCam
from camcli.plots import style
from camcli.plots.axes import lift, spread
from camcli.plots.picture import Panel
from camcli.quantities import MM_PER_INCH, Units
from camcli.system import System, units_of
from camcli.words.simulate import lobe_title

NARROW = 30.0  # mm, of a panel without room for the names of corners
HIDDEN = 0.008  # of the largest radius: a circle this close to the outline is not drawn upon it
NARROW_MACHINES = 110.0  # mm, of a panel of machines with symbols alone
APART, NARROW_APART = 3.2, 2.65  # largest radii, from one machine to the next
NARROW_ARC = 15.0  # deg, of an arc whose name is as wide as itself
NEW_LINE = "\n"
BEYOND = 14.0  # deg, of a circle that is drawn on both sides of its arc
ROW = 0.072  # of the height of a panel, a line of words
GUESSED = 1.5  # lifts, a base radius that is not known
LEAST_LIFT = 1e-9  # m, of a cam without a lift, so that it is drawn
TURN = np.linspace(0.0, 2.0 * np.pi, 1441)  # phases at which the outline is known, rad
SEEN = 0.08  # of the largest radius: a gap that shows in a small drawing too
THIN = 0.02  # of the largest radius: a gap below it does not show
TALL = 1.27  # height to width of the machine
HALF_ZERO = 0.13  # of the largest radius, half as wide as the mark of theta = 0 with room beside it
NAME_AWAY = 0.115  # of the largest radius, from a corner to the middle of its name
NAME_AWAY_ON_SHEET = 0.16  # the same on a sheet, whose cams are drawn smaller
NAMES_APART = 6.0  # deg, the least angle between the names of two corners
NAMES_APART_ON_SHEET = 15.0  # deg, the same on a sheet
BESIDE_BODY = 0.2  # of the largest radius, room for the names of corners beside the body
BESIDE_NARROW_BODY = 0.06  # the same of a narrow panel, where the corners have no names
BESIDE_ARCS, ABOVE_BODY = 0.35, 0.25  # the same for the names of arcs, and for theta = 0 above it
BESIDE_CENTRES = 0.1  # of the largest radius: a name so near to the height of the axis moves up
KEPT_AROUND = 1.051  # of its data, what matplotlib keeps in the axes: its 1.05, and rounding
COILS, STEM, WIDE = 6, 0.15, 0.09  # of the spring; its length and half width in largest radii


@dataclass(frozen=True)
class Ring:
    """A circle of which arcs of the outline are parts; m, deg for the direction of its centre."""

    centre: str
    distance: float
    direction: float
    radius: float
    symbol: str  # of the radius
    words: str


@dataclass(frozen=True)
class Outline:
    """Radii of a cam (m) over the turn (rad), and what its circles are."""

    theta: np.ndarray
    radius: np.ndarray
    corners: dict[str, float]  # deg
    rings: Sequence[Ring]  # the base circle first
    guessed: bool
    flat: bool  # the follower's face
    units: Units
    sprung: bool  # without a spring the follower is drawn as a ball on a table, if its face is flat
    ratio: float = 1.0  # lift of the follower per lift of the cam
    zero: float = 0.0  # distance from the axis of the plane in which q and c are zero, m
    lobe: Lobe | None = None  # where what runs on it is known
    lowered: np.ndarray | None = None  # radii of the cam behind its lash, m
    lash: float = 0.0  # at the lobe, m
    widened: float = 1.0  # how many times as wide the lash is drawn
    at_rest_deg: float = 0.0  # how far the cam has turned where its lash is drawn

    @classmethod
    def of_lift(cls, system: System, base_radius: float | None, cam: Any = None) -> Outline:
        """The outline that a knife edge touches: its radius is base radius + c - lowest c.

        base_radius: m, None where it is not known. cam: the scene's, whose circles are shown if it
        is made of arcs. Behind its lash the lobe is lower than where the follower runs.
        """
        ratio = system.rocker_ratio
        c = _lift_at_the_cam(system)
        base = base_radius or GUESSED * max(float(np.ptp(c)), LEAST_LIFT)
        radius = base + c - c.min()
        zero = float(radius.min() - c.min())
        rings = [_base_circle(float(radius.min()))]
        if isinstance(cam, ArcsCam):
            rings += _circles_of_arcs(cam, system, float(radius.max()))
        lowered = None
        if system.lash:
            lowered = zero + (lift(system.as_drawn.cam, TURN)[0] - system.lash) / ratio
        return cls(
            TURN,
            radius,
            style.corner_names(system.corners),
            rings,
            guessed=base_radius is None,
            flat=isinstance(cam, EccentricCam),
            units=units_of(system),
            sprung=system.follower.stiffness > 0.0,
            ratio=ratio,
            zero=zero,
            lowered=lowered,
            lash=system.lash / ratio,
        )

    @classmethod
    def of_lobe(cls, system: System, lobe: Lobe) -> Outline:
        """The outline of a lobe on which a flat face or a roller runs.

        Its radius is the distance of the follower from the axis: of a roller that of its centre.
        """
        c = _lift_at_the_cam(system)
        return cls(
            TURN,
            lobe.base + c - c.min() + lobe.roller,
            style.corner_names(system.corners),
            [_base_circle(lobe.base)],
            guessed=False,
            flat=lobe.face is Face.FLAT,
            units=units_of(system),
            sprung=system.follower.stiffness > 0.0,
            ratio=system.rocker_ratio,
            lobe=lobe,
        )

    def with_lash_seen(self) -> Outline:
        """With the lobe drawn lower where its lash would be too thin to see.

        It is true of a follower on its seat alone: on the lobe there would be a gap.
        """
        wide = SEEN * float(self.radius.max())
        if self.lowered is None or self.flat or self.lash >= wide:
            return self
        lower = self.lowered - (wide - self.lash)
        return replace(self, lowered=lower, widened=wide / self.lash)

    def over_lash(self, lash: float, lobe_below: Callable[[float], Lobe]) -> Outline:
        """With the lobe of a follower on its seat drawn lower by its lash, or so that it is seen.

        lash: at the follower, m. lobe_below: the lobe on a base circle smaller by so much, m.
        """
        own = lash / self.ratio
        if own == 0.0 or self.lobe is None:
            return self
        seen = max(own, min(SEEN * float(self.radius.max()), 0.5 * self.lobe.base))
        lobe = lobe_below(seen)
        rings = [replace(self.rings[0], radius=lobe.base)]
        return replace(self, lobe=lobe, rings=rings, lash=own, widened=seen / own)

    @property
    def body(self) -> tuple[np.ndarray, np.ndarray]:
        """The body when it has not turned, m: x to the right, y towards the follower."""
        if self.lobe is not None:
            places = np.array([touch.place for touch in self.lobe.touches])
            return places[:, 0], places[:, 1]
        if not self.flat:
            radius = self.radius if self.lowered is None else self.lowered
            return self.place(np.degrees(self.theta), radius, 0.0)
        beside = np.ptp(self.radius) / 2.0
        low = self.radius.min()
        reach = low + beside  # of the circle, whose centre is opposite to the lowest lift
        return reach * np.sin(self.theta), reach * np.cos(self.theta) - beside

    def turned_body(self, turned_deg: float) -> tuple[np.ndarray, np.ndarray]:
        """The body when it has turned counterclockwise, m."""
        x, y = self.body
        turn = np.radians(turned_deg)
        return x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)

    def place(self, theta_deg: Any, radius: Any, turned_deg: float) -> tuple[Any, Any]:
        """Where a point of the cam is when it has turned: phase and distance from the axis."""
        angle = np.radians(np.subtract(theta_deg, turned_deg))
        return radius * np.sin(angle), radius * np.cos(angle)

    def touched(self, theta_deg: float) -> tuple[float, float]:
        """Direction (deg, counted as theta) and distance (m) of the point touched at a phase."""
        if self.lobe is None:
            return theta_deg, self.at(theta_deg)
        near = min(self.lobe.touches, key=lambda one: abs(degrees(one.theta) - theta_deg))
        return degrees(near.direction), hypot(near.along, near.beside)

    def rim(self, theta_deg: Any) -> Any:
        """Distance of the body's edge from the axis in a direction that is counted as theta, m.

        theta_deg: one direction, or an array of them.
        """
        if self.lobe is None and not self.flat:
            return self.at(theta_deg)
        x, y = self.body
        around = np.arctan2(x, y)
        order = np.argsort(around)
        return np.interp(
            np.radians(theta_deg), around[order], np.hypot(x, y)[order], period=2.0 * np.pi
        )

    def at(self, theta_deg: Any) -> Any:
        """Radius under the follower at a phase, or at an array of them, m."""
        return np.interp(np.radians(theta_deg % 360.0), self.theta, self.radius)


def _lift_at_the_cam(system: System) -> np.ndarray:
    """c over the turn, on the cam's side of a rocker, m."""
    return lift(system.cam, TURN)[0] / system.rocker_ratio


def _base_circle(radius: float) -> Ring:
    return Ring("O", 0.0, 0.0, radius, r"$\rho_0$", "base circle")


def _circles_of_arcs(cam: ArcsCam, system: System, largest: float) -> list[Ring]:
    """The circles of a cam of arcs beside its base circle; largest: its largest radius, m."""
    to_flank = degrees(min(system.as_drawn.corners)) - 180.0
    to_nose = 180.0 - cam.top_dwell_deg / 2.0
    return [
        Ring("O", 0.0, 0.0, largest, r"$\rho_3$", "top dwell"),
        Ring("O₁", cam.flank_center, to_flank, cam.flank_radius, r"$\rho_1$", "flanks"),
        Ring("O₂", cam.nose_center, to_nose, cam.nose_radius, r"$\rho_2$", "nose"),
    ]


def machine_panels(
    outline: Outline, moments: dict[str, tuple[float, float]], among: str = ""
) -> dict[str, Panel]:
    """Panels `outline`, `turned` by 180 degrees, `geometry`, `mechanism`.

    moments: phase (deg) and gap (m) of those that `mechanism` shows, by name.

    among: the name of the cam where it stands among others, with less room for words.
    """
    panels = {}
    for name, turned in (("outline", outline.at_rest_deg), ("turned", 180.0)):
        draw = partial(_draw_outline, outline=outline, turned=turned, among=among)
        panels[name] = Panel(draw, 66.0, across=2, usual=False, shape=TALL, y="machine")
    if not outline.flat and outline.lobe is None:
        draw = partial(_draw_geometry, outline=outline)
        panels["geometry"] = Panel(draw, 74.0, across=2, usual=False, shape=0.9)
        draw = partial(_write_geometry, outline=outline)
        panels["geometry in words"] = Panel(draw, 74.0, across=2, usual=False, shape=0.6)
    draw = partial(_draw_mechanism, outline=outline, moments=moments)
    panels["mechanism"] = Panel(draw, 60.0, usual=False, shape=0.58)
    return panels


def _body(axes: Axes, outline: Outline, turned: float, left: float = 0.0) -> None:
    """The cam, and its axis."""
    x, y = outline.turned_body(turned)
    look: dict[str, Any] = {"facecolor": style.CAM_BODY, "edgecolor": style.CAM, "linewidth": 1.2}
    axes.add_patch(Polygon(np.column_stack([x + left, y]), closed=True, zorder=2, **look))
    axes.plot([left], [0.0], "o", color=style.CAM, ms=3.0, zorder=4)


def _follower(
    axes: Axes, outline: Outline, gap: float, turned: float, left: float = 0.0, highest: float = 0.0
) -> float:
    """A follower on its stem, its tip `gap` above the cam; returns where its spring ends, or would.

    gap: on the cam's side of a rocker, m. highest: that the tip ever is.
    """
    size = float(outline.radius.max())
    tip = outline.at(turned) + gap
    wide = WIDE * size
    top = (2.0 + STEM) * size
    top = max(top, highest + (1.0 + STEM) * size)
    colour = style.FLIGHT if gap > 0.0 else style.STICKING
    look: dict[str, Any] = {"facecolor": colour, "edgecolor": style.CAM, "lw": 0.8, "zorder": 5}
    if outline.flat and not outline.sprung:
        axes.add_patch(Circle((left, tip + 3.0 * wide), 3.0 * wide, **look))
        table = [left - 5.0 * wide, left + 5.0 * wide]
        axes.plot(table, [outline.at(turned)] * 2, color=style.CAM, lw=1.6)
        return top
    roller = 0.0 if outline.lobe is None else outline.lobe.roller
    foot = 3.0 * wide if outline.flat else 0.0  # beside the tip
    if outline.lobe is not None and outline.flat:
        foot = max(foot, *(abs(found.value) for found in outline.lobe.beside))
    edge = [(left - foot, tip), (left + foot, tip), (left + wide / 2.0, tip + wide)]
    edge.append((left - wide / 2.0, tip + wide))
    if roller > 0.0:
        axes.add_patch(Circle((left, tip), roller, **look))
        axes.plot([left], [tip], "o", color=style.CAM, ms=2.0, zorder=6)
    else:
        axes.add_patch(Polygon(edge, closed=True, **look))
    stem = _stem_end(outline, tip, top)
    axes.plot([left, left], [tip + wide, stem], color=style.CAM, lw=2.0, zorder=4)
    if not outline.sprung:
        return top
    y = np.linspace(stem, top, 2 * COILS + 1)
    x = left + wide * np.array([0.0, *[(-1.0) ** k for k in range(2 * COILS - 1)], 0.0])
    axes.plot(x, y, color=style.CAM, lw=0.8, zorder=4)
    axes.plot([left - 2.0 * wide, left + 2.0 * wide], [top, top], color=style.CAM, lw=1.6)
    return top


def _stem_end(outline: Outline, tip: float, top: float) -> float:
    """Where the stem of a follower ends and its spring begins, the frame being at `top`."""
    size = float(outline.radius.max())
    stem = 1.5 * size + (tip - outline.radius.min()) * 0.999
    return min(max(stem, tip + 2.0 * WIDE * size), top - 2.0 * WIDE * size)


def draw_machine(axes: Axes, outline: Outline, gap: float, turned: float, highest: float) -> None:
    """The machine at one moment, in axes that fit the highest place of the tip."""
    size = float(outline.radius.max())
    _body(axes, outline, turned)
    top = _follower(axes, outline, gap, turned, highest=highest)
    _bare(axes)
    _show(axes, (-1.05 * size, 1.05 * size), (-1.05 * size, 1.02 * top))


def _bare(axes: Axes) -> None:
    axes.set_aspect("equal", adjustable="datalim")  # so that its letter is where others are
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.autoscale_view()


def _show(axes: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    """The places to show; one way more of them where the panel is wider or higher.

    With equal scales matplotlib changes one of the two ranges whenever the layout changes the
    panel, and keeps its data, with KEPT_AROUND of it, within both: the places count as data.
    """
    (left, right), (low, high) = x, y
    room = 0.5 * (1.0 - 1.0 / KEPT_AROUND)
    beside, below = room * (right - left), room * (high - low)
    axes.update_datalim([(left + beside, low + below), (right - beside, high - below)])
    axes.set_xlim(x, auto=True)
    axes.set_ylim(y, auto=True)


def _circle(outline: Outline, ring: Ring, turned: float) -> tuple[np.ndarray, np.ndarray]:
    """Places on a circle that are not on the outline; of a large one those beside its arc."""
    middle = outline.place(ring.direction, ring.distance, 0.0)
    around = np.radians(np.arange(0.0, 360.5, 0.5))
    x, y = middle[0] + ring.radius * np.sin(around), middle[1] + ring.radius * np.cos(around)
    phase, away = np.degrees(np.arctan2(x, y)), np.hypot(x, y)
    size = float(outline.radius.max())
    on = np.abs(away - outline.rim(phase)) < HIDDEN * size
    shown = ~on
    if ring.radius >= size:
        step = round(BEYOND / 0.5)
        near = np.convolve(on, np.ones(2 * step + 1), "same") > 0
        shown &= near
    at = outline.place(phase, away, turned)
    return np.where(shown, at[0], np.nan), np.where(shown, at[1], np.nan)


def _draw_circles(axes: Axes, outline: Outline, rings: Sequence[Ring], turned: float) -> None:
    """Circles beside the outline, and their centres."""
    for ring in rings:
        line: dict[str, Any] = {"color": style.GUIDE, "lw": 0.6, "ls": (0, (4, 2)), "zorder": 3}
        axes.plot(*_circle(outline, ring, turned), **line)
        x, y = outline.place(ring.direction, ring.distance, turned)
        axes.plot([x], [y], ".", color=style.CAM, ms=4.0, zorder=6)


def _draw_corners(axes: Axes, outline: Outline, turned: float, named: bool = True) -> None:
    """A ray and a dot for each corner of the cam, and its name outside."""
    largest = outline.radius.max()
    away = NAME_AWAY if outline.lobe is None else NAME_AWAY_ON_SHEET
    apart = NAMES_APART if outline.lobe is None else NAMES_APART_ON_SHEET
    aside = away * largest
    touched = sorted((*outline.touched(phase), name) for name, phase in outline.corners.items())
    places = spread([direction for direction, *_ in touched], apart, -360.0, 720.0)
    for (direction, radius, name), name_direction in zip(touched, places, strict=True):
        x, y = outline.place([direction, direction], np.array([0.0, radius]), turned)
        axes.plot(x, y, color=style.GUIDE, lw=0.5, zorder=3)
        axes.plot(x[1:], y[1:], "o", color=style.CAM, ms=2.5, zorder=6)
        name_x, name_y = outline.place(name_direction, radius + aside, turned)
        if abs(name_y) < BESIDE_CENTRES * largest:
            name_x = 0.5 * (x[1] + name_x)
            name_y += 0.95 * aside
        _label(axes, name_x, name_y, name if named else "")


def _label(axes: Axes, x: float, y: float, words: str, **more: Any) -> None:
    """Words in the middle of a place."""
    look: dict[str, Any] = {"ha": "center", "va": "center", "size": style.NOTE, "zorder": 6}
    axes.text(x, y, words, **{**look, **more})


def _symbol(axes: Axes, x: float, y: float, symbol: str, **more: Any) -> None:
    """A symbol with an index upon the cam's body; lines behind it end before its letters."""
    free = [withStroke(linewidth=2.0, foreground=style.CAM_BODY)]
    _label(axes, x, y, symbol, size=style.WITH_INDEX, path_effects=free, **more)


def _draw_outline(axes: Axes, outline: Outline, turned: float, among: str) -> None:
    """The cam with the centres of its circles and its corners by name, and the follower on it."""
    _body(axes, outline, turned)
    size = float(outline.radius.max())
    _draw_circles(axes, outline, outline.rings[:1], turned)
    narrow = axes.get_window_extent().width < NARROW / MM_PER_INCH * style.DPI
    _draw_corners(axes, outline, turned, not narrow)
    circles = [] if among else outline.rings[2:]
    for ring in circles:
        x, y = outline.place(ring.direction, ring.distance, turned)
        axes.plot([0.0, x], [0.0, y], color=style.GUIDE, lw=0.5, zorder=3)
        axes.plot([x], [y], ".", color=style.CAM, ms=4.0, zorder=6)
        _label(axes, x, y - 0.1 * size, ring.centre, color=style.CAM)
    _label(axes, 0.09 * size, 0.09 * size, outline.rings[0].centre, color=style.CAM)
    _follower(axes, outline, 0.0, turned)
    if among:
        axes.set_title(among, loc="left")
    else:
        said = rf"$\theta$ = {turned:g} deg"
        if outline.lobe is not None:
            said += f", {lobe_title(outline.lobe, outline.units)}"
        first = turned == outline.at_rest_deg  # others beside it do not say it again
        guessed = "base radius not given: 1.5 lifts\n" if outline.guessed and first else ""
        sheet = outline.lobe is not None  # it has other panels, hence a letter at the left
        if outline.lash and first:
            guessed += f"lash {outline.units.lengths(outline.lash * outline.ratio, 3)}"
            if outline.widened > 1.0:
                guessed += f", drawn {outline.widened:.2g} times as wide"
            elif outline.lash < THIN * size:
                guessed += "; too thin to see"
            guessed += "\n"
        axes.set_title(guessed + said, loc="left" if sheet or outline.lash else "center")
    names = (BESIDE_NARROW_BODY if narrow else BESIDE_BODY) * size
    wide = float(np.abs(outline.turned_body(turned)[0]).max()) + names
    _bare(axes)
    _show(axes, (-wide, wide), (-1.2 * size, (2.1 + STEM) * size))


# --- how the cam is made


def _draw_geometry(axes: Axes, outline: Outline) -> None:
    """Circles with their centres and radii, arcs and corners by name, and the angles of the arcs.

    The lobe is the same on both sides: what belongs to the arcs of one side is drawn on it.
    """
    size = float(outline.radius.max())
    _body(axes, outline, 0.0)
    _draw_circles(axes, outline, outline.rings, 0.0)
    _draw_corners(axes, outline, 0.0)
    for number, (begin, end) in enumerate(_arcs(outline), 1):
        middle = 0.5 * (begin + end)
        if begin < 360.0 < end:  # beside the mark of theta = 0
            middle -= 0.25 * (end - begin)
        away = 0.13 if end - begin > NARROW_ARC else 0.19  # beyond the names of the corners
        x, y = outline.place(middle, outline.at(middle) + away * size, 0.0)
        _label(axes, x, y, f"A{number}", color=style.FLIGHT)
    _label(axes, 0.07 * size, 0.07 * size, outline.rings[0].centre, color=style.CAM)
    _radius(axes, (0.0, 0.0), outline.place(315.0, outline.rings[0].radius, 0.0), r"$\rho_0$", 1)
    if len(outline.rings) > 1:
        _draw_arcs(axes, outline)
    _label(axes, 0.0, 1.04 * outline.at(0.0), r"$\theta$ = 0", va="bottom")
    beside = asin(min(HALF_ZERO * size / (1.1 * outline.at(0.0)), 0.9))
    way = degrees(beside) + np.linspace(0.0, 28.0, 20)
    x, y = outline.place(way, 1.1 * outline.at(0.0), 0.0)
    axes.plot(x, y, color=style.CAM, lw=0.8)
    _arrow(axes, (x[-2], y[-2]), (x[-1], y[-1]), "-|>")
    _bare(axes)
    wide = float(np.abs(outline.body[0]).max()) + BESIDE_ARCS * size
    _show(axes, (-wide, wide), (-1.25 * size, outline.at(0.0) + ABOVE_BODY * size))


def _arcs(outline: Outline) -> list[tuple[float, float]]:
    """Where the arcs from corner to corner begin and end, deg, the last one beyond the turn."""
    at = list(outline.corners.values())
    return [(x, y if y > x else y + 360.0) for x, y in zip(at, [*at[1:], *at[:1]], strict=True)]


def _draw_arcs(axes: Axes, outline: Outline) -> None:
    """Centres, radii and angles of a cam of circular arcs.

    A radius is drawn from the centre of its circle to the outline. Numbers are the places of
    symbols, of the largest radius, chosen so that none lies on another.
    """
    size = float(outline.radius.max())
    _, top, flank, nose = outline.rings
    flank_centre = outline.place(flank.direction, flank.distance, 0.0)
    nose_centre = outline.place(nose.direction, nose.distance, 0.0)
    _, corner_b, corner_c, *_ = outline.corners.values()

    for x, y in (flank_centre, nose_centre):
        axes.plot([0.0, x], [0.0, y], color=style.CAM, lw=0.9, zorder=4)
    x, y = flank_centre
    _symbol(axes, 0.45 * x, 0.45 * y + 0.07 * size, r"$\kappa_1$")
    _label(axes, x - 0.02 * size, y - 0.09 * size, flank.centre, color=style.CAM)
    x, y = nose_centre
    _symbol(axes, 0.67 * x - 0.09 * size, 0.67 * y, r"$\kappa_2$")
    _label(axes, x + 0.1 * size, y + 0.06 * size, nose.centre, color=style.CAM)

    on_flank = outline.place(corner_b, outline.at(corner_b), 0.0)
    _radius(axes, flank_centre, on_flank, flank.symbol, -1, 0.3)
    middle = 0.5 * (corner_b + corner_c)
    on_nose = outline.place(middle, outline.at(middle), 0.0)
    _radius(axes, nose_centre, on_nose, nose.symbol, -1)
    on_top = outline.place(180.0, top.radius, 0.0)
    _radius(axes, (0.0, 0.0), on_top, top.symbol, -1, 0.89)
    _draw_angles(axes, outline)


def _draw_angles(axes: Axes, outline: Outline) -> None:
    """The angles of flank, nose and top dwell as arcs about the axis, and their names."""
    size = float(outline.radius.max())
    flank, nose, top = _arcs(outline)[:3]
    named = (  # arc, its radius, where its name stands: deg and of the largest radius
        (flank, 0.2, flank[0] + 0.5 * (flank[1] - flank[0]), 0.29),
        (nose, 0.44, nose[0] - 11.0, 0.44),  # beside the arc, which is too narrow for it
        (top, 0.26, top[0] + 0.75 * (top[1] - top[0]), 0.35),  # beside the arrow in the middle
    )
    for number, ((begin, end), reach, name_deg, name_reach) in enumerate(named, 1):
        x, y = outline.place(np.linspace(begin, end, 40), reach * size, 0.0)
        axes.plot(x, y, color=style.DETACHMENT, lw=0.9, zorder=4)
        x, y = outline.place(name_deg, name_reach * size, 0.0)
        _symbol(axes, x, y, rf"$\theta_{number}$", color=style.DETACHMENT)


def _radius(axes: Axes, begin: Any, end: Any, symbol: str, side: int, place: float = 0.5) -> None:
    """An arrow from a centre to its circle, with its symbol to the left (1) or right (-1)."""
    _arrow(axes, begin, end, "-|>")
    way = np.subtract(end, begin)
    aside = np.array([-way[1], way[0]]) / np.hypot(*way) * side
    size = np.ptp(axes.get_ylim())
    x, y = np.add(begin, place * way) + 0.035 * size * aside
    _symbol(axes, x, y, symbol)


def _arrow(axes: Axes, begin: Any, end: Any, kind: str, **more: Any) -> None:
    """A straight arrow between two places."""
    head = f"{kind},head_width=0.18,head_length=0.4"
    look: dict[str, Any] = {"arrowstyle": head, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    look |= {"color": style.CAM, **more}
    axes.annotate("", end, begin, arrowprops=look, zorder=5)


def _write_geometry(axes: Axes, outline: Outline) -> None:
    """What the symbols of the drawing are, with their lengths and angles; then the corners."""
    rows = _geometry_rows(outline)
    axes.axis("off")
    for k, row in enumerate(rows):
        height = 0.94 - ROW * k
        for x, cell in zip((0.06, 0.16, 0.44), row, strict=True):
            axes.text(x, height, cell, va="center_baseline", size=8)
    corners = [rf"{name} {phase:.5g}$\degree$" for name, phase in outline.corners.items()]
    half = (len(corners) + 1) // 2
    lines = [", ".join(part) for part in (corners[:half], corners[half:]) if part]
    for k, line in enumerate(lines):
        words = f"corners: {line}" if k == 0 else line
        height = 0.94 - ROW * (len(rows) + 0.6 + k)
        axes.text(0.06, height, words, va="center_baseline", size=8)


def _geometry_rows(outline: Outline) -> list[tuple[str, str, str]]:
    """Symbol, value and words of each radius, distance and angle in the drawing of a cam."""
    base = outline.rings[0]
    lengths = outline.units.lengths
    value = "1.5 lifts" if outline.guessed else lengths(base.radius, 4)
    guessed = "; not given" if outline.guessed else ""
    if len(outline.rings) == 1:
        return [(base.symbol, value, f"{base.words}, around O{guessed}")]
    _, top, flank, nose = outline.rings
    arcs = _arcs(outline)
    rows = [
        (base.symbol, value, f"{base.words}, A{len(arcs)}, around O{guessed}"),
        (flank.symbol, lengths(flank.radius, 4), "flanks A1, A5"),
        (r"$\kappa_1$", lengths(flank.distance, 4), "from O to O₁"),
        (nose.symbol, lengths(nose.radius, 4), "nose A2, A4"),
        (r"$\kappa_2$", lengths(nose.distance, 4), "from O to O₂"),
        (top.symbol, lengths(top.radius, 4), "top dwell A3, around O"),
    ]
    for number, names in enumerate(("A1, A5", "A2, A4", "A3"), 1):
        begin, end = arcs[number - 1]
        angle = rf"{end - begin:.5g}$\degree$"
        rows.append((rf"$\theta_{number}$", angle, f"of {names}, at O"))
    return rows


# --- the machine at several moments


def _draw_mechanism(axes: Axes, outline: Outline, moments: dict[str, tuple[float, float]]) -> None:
    """The follower at several moments, each named, side by side, with the symbols of its motion.

    Mass, spring and damper are named at the first of them, the positions where the follower flies.
    """
    size = float(outline.radius.max())
    plain = outline.lobe is None and not outline.flat
    narrow = axes.get_window_extent().width < NARROW_MACHINES / MM_PER_INCH * style.DPI
    apart = (NARROW_APART if narrow else APART) * size
    for k, (name, (phase, gap)) in enumerate(moments.items()):
        left = apart * k
        _body(axes, outline, phase, left)
        top = _follower(axes, outline, gap, phase, left)
        if outline.sprung:
            tip = outline.at(phase) + gap
            _draw_damper(axes, size, left, _stem_end(outline, tip, top), top)
        words = rf"{name},{NEW_LINE if narrow else ' '}$\theta$ = {phase % 360.0:.4g} deg"
        axes.text(left, -1.35 * size, words, ha="center", va="top", size=style.NOTE)
        named = {} if narrow else outline.corners
        for corner, place in named.items():
            direction, distance = outline.touched(place)
            x, y = outline.place(direction, 0.87 * distance, phase)
            _label(axes, x + left, y, corner, size=6.5, color=style.CAM)
        if gap > 0.0 and plain:
            _draw_positions(axes, outline, phase, gap, left)
    _name_parts(axes, outline, narrow, apart * (len(moments) - 1))
    _bare(axes)
    words_end = -2.6 * size if narrow else -1.85 * size
    axes.update_datalim([(0.0, words_end)])  # else the panel might be cut to what is drawn
    axes.autoscale_view()


def _draw_damper(axes: Axes, size: float, left: float, low: float, top: float) -> None:
    """A damper to the left of the spring: a cup that hangs on the frame, and a piston in it."""
    x = left - 2.6 * WIDE * size
    wide = 0.55 * WIDE * size
    middle = 0.5 * (low + top)
    line: dict[str, Any] = {"color": style.CAM, "lw": 0.8, "zorder": 4}
    axes.plot([x, x, left], [middle, low, low], **line)  # from the stem to the piston
    axes.plot([x - 0.7 * wide, x + 0.7 * wide], [middle, middle], **{**line, "lw": 1.6})
    rim = middle - 0.6 * wide
    axes.plot(
        [x - wide, x - wide, x + wide, x + wide], [rim, *[middle + 1.2 * wide] * 2, rim], **line
    )
    axes.plot([x, x], [middle + 1.2 * wide, top], **line)
    axes.plot([x - wide, left], [top, top], color=style.CAM, lw=1.6)


def _draw_positions(axes: Axes, outline: Outline, phase: float, gap: float, left: float) -> None:
    """q(t) and c(t), from the plane in which both are zero up to the follower and to the cam."""
    size = float(outline.radius.max())
    cam = outline.at(phase)
    zero = outline.zero
    scale = "" if outline.ratio == 1.0 else f"/{outline.ratio:g}"
    reach = 0.74 * size
    look: dict[str, Any] = {"color": style.CAM, "lw": 0.6, "ls": (0, (2, 2)), "zorder": 6}
    axes.plot([left - reach, left + reach], [zero, zero], **look)
    _label(axes, left + reach + 0.1 * size, zero, "0")
    for side, height, name in ((-1.0, cam, "c"), (1.0, cam + gap, "q")):
        x = left + 0.5 * side * size
        axes.plot([left, x + 0.06 * side * size], [height, height], **look)
        _arrow(axes, (x, zero), (x, height), "<|-|>", zorder=7)
        _label(axes, x + 0.09 * side * size, zero + 0.75 * (height - zero), f"${name}(t)$" + scale,
               ha="left" if side > 0.0 else "right", size=style.WITH_INDEX)  # fmt: skip


def _name_parts(axes: Axes, outline: Outline, narrow: bool, last: float) -> None:
    """Names and symbols at the first machine, the law of impacts at the last; narrow: symbols."""
    size = float(outline.radius.max())
    parts = [(0.1, 1.36, "follower", "$m$")]
    if outline.sprung:
        parts += [(0.16, 1.9, "spring", "$k$"), (-0.36, 1.9, "damper", "$b$")]
    for x, y, name, symbol in parts:
        words = symbol if narrow else f"{name}, {symbol}"
        _label(axes, x * size, y * size, words, ha="left" if x > 0.0 else "right")
    _label(axes, 0.0, -0.5 * size, "cam")
    law = r"$u^+ = -r\,u^-$"
    words = law if narrow else f"impact: {law}"
    _label(axes, last, -1.62 * size - 0.6 * size * narrow, words, va="top")
    turning = {"arrowstyle": "->", "color": style.CAM, "connectionstyle": "arc3,rad=0.4", "lw": 0.8}
    begin, end = (0.3 * size, -0.12 * size), (0.2 * size, 0.25 * size)
    axes.annotate("", end, begin, arrowprops=turning, zorder=6)
    axes.text(0.4 * size, 0.0, r"$\omega$", size=8, zorder=6)
