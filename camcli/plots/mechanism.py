"""The machine drawn: the cam's outline, its circles and corners, and the follower on it.

The follower moves along a line through the cam's axis, at R(theta) = base radius + c - lowest c
from it, with a knife edge; an eccentric is a circle under a flat face. The cam turns
counterclockwise; the follower stands above it. With a rocker the drawing is that of the lobe, and
of what runs on it: lifts and gaps are rocker_ratio times smaller than the valve's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees, hypot
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from camcli.analysis.lobe import Face, Lobe
from camcli.cams import ArcsCam, EccentricCam
from camcli.plots import style
from camcli.plots.axes import lift
from camcli.plots.picture import Panel
from camcli.quantities import Units
from camcli.system import System, units_of
from camcli.words.simulate import lobe_title

NARROW = 35.0  # mm, of a panel without room for the names of corners
GUESSED = 1.5  # lifts, a base radius that is not known
TALL = 1.27  # height to width of the machine
COILS, STEM, WIDE = 6, 0.15, 0.09  # of the spring; its length and half width in largest radii


@dataclass(frozen=True)
class Outline:
    """Radii of a cam (m) over the turn (rad), and what its circles are."""

    theta: np.ndarray
    radius: np.ndarray
    corners: dict[str, float]  # deg
    circles: Sequence[tuple[str, float, float, float]]  # centre's name, distance, direction, radius
    guessed: bool
    flat: bool  # the follower's face
    units: Units
    sprung: bool  # without a spring the follower is drawn as a ball on a table, if its face is flat
    ratio: float = 1.0  # lift of the follower per lift of the cam
    lobe: Lobe | None = None  # where what runs on it is known

    @classmethod
    def of(
        cls, system: System, base_radius: float | None, cam: Any = None, lobe: Lobe | None = None
    ) -> Outline:
        """From the lift; `cam` is the scene's, whose circles are shown if it is made of arcs.

        With a lobe its outline is drawn, and radius is the distance of the follower from the axis:
        of a roller that of its centre.
        """
        theta = np.linspace(0.0, 2.0 * np.pi, 1441)
        c = lift(system.cam, theta)[0]
        ratio = system.rocker_ratio
        c = c / ratio
        base = base_radius or GUESSED * max(float(np.ptp(c)), 1e-9)
        radius = base + c - c.min()
        if lobe is not None:
            return cls(
                theta,
                radius + lobe.roller,
                style.corner_names(system.corners),
                [("O", 0.0, 0.0, lobe.base)],
                guessed=False,
                flat=lobe.face is Face.FLAT,
                units=units_of(system),
                sprung=system.follower.stiffness > 0.0,
                ratio=ratio,
                lobe=lobe,
            )
        circles = [("O", 0.0, 0.0, float(radius.min()))]
        if isinstance(cam, ArcsCam):
            circles += [
                ("O", 0.0, 0.0, float(radius.max())),
                ("O₁", cam.flank_center, degrees(min(system.corners)) - 180.0, cam.flank_radius),
                ("O₂", cam.nose_center, 180.0 - cam.top_dwell_deg / 2.0, cam.nose_radius),
            ]
        corners = style.corner_names(system.corners)
        flat = isinstance(cam, EccentricCam)
        sprung, guessed = system.follower.stiffness > 0.0, base_radius is None
        units = units_of(system)
        return cls(theta, radius, corners, circles, guessed, flat, units, sprung, ratio)

    @property
    def body(self) -> tuple[np.ndarray, np.ndarray]:
        """The body when it has not turned, m: x to the right, y towards the follower."""
        if self.lobe is not None:
            places = np.array([touch.place for touch in self.lobe.touches])
            return places[:, 0], places[:, 1]
        if not self.flat:
            return self.place(np.degrees(self.theta), self.radius, 0.0)
        beside, low = np.ptp(self.radius) / 2.0, self.radius.min()
        reach = low + beside  # of the circle, whose centre is opposite to the lowest lift
        return reach * np.sin(self.theta), reach * np.cos(self.theta) - beside

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

    def at(self, theta_deg: float) -> float:
        """Radius under the follower at a phase, m."""
        return float(np.interp(np.radians(theta_deg % 360.0), self.theta, self.radius))


def machine_panels(
    outline: Outline, moments: dict[str, tuple[float, float]], among: str = ""
) -> dict[str, Panel]:
    """Panels `outline`, `turned` by 180 degrees, `mechanism`; moments: phase (deg), gap (m).

    among: the name of the cam where it stands among others, with less room for words.
    """
    panels = {}
    for name, turned in (("outline", 0.0), ("turned", 180.0)):
        draw = partial(_draw_outline, outline=outline, turned=turned, among=among)
        panels[name] = Panel(draw, 66.0, across=2, usual=False, shape=TALL)
    draw = partial(_draw_mechanism, outline=outline, moments=moments)
    panels["mechanism"] = Panel(draw, 52.0, usual=False)
    return panels


def _body(axes: Axes, outline: Outline, turned: float, left: float = 0.0) -> None:
    """The cam, and its axis."""
    x, y = outline.body
    turn = np.radians(turned)
    x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
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
    tip, wide, top = outline.at(turned) + gap, WIDE * size, (2.0 + STEM) * size
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
    stem = 1.5 * size + (tip - outline.radius.min()) * 0.999
    stem = min(max(stem, tip + 2.0 * wide), top - 2.0 * wide)
    axes.plot([left, left], [tip + wide, stem], color=style.CAM, lw=2.0, zorder=4)
    if not outline.sprung:
        return top
    y = np.linspace(stem, top, 2 * COILS + 1)
    x = left + wide * np.array([0.0, *[(-1.0) ** k for k in range(2 * COILS - 1)], 0.0])
    axes.plot(x, y, color=style.CAM, lw=0.8, zorder=4)
    axes.plot([left - 2.0 * wide, left + 2.0 * wide], [top, top], color=style.CAM, lw=1.6)
    return top


def draw_machine(axes: Axes, outline: Outline, gap: float, turned: float, highest: float) -> None:
    """The machine at one moment, in axes that fit the highest place of the tip."""
    size = float(outline.radius.max())
    _body(axes, outline, turned)
    top = _follower(axes, outline, gap, turned, highest=highest)
    _bare(axes)
    axes.set(xlim=(-1.3 * size, 1.3 * size), ylim=(-1.1 * size, 1.02 * top))


def _bare(axes: Axes) -> None:
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.autoscale_view()


def _draw_outline(axes: Axes, outline: Outline, turned: float, among: str) -> None:
    """The cam with its circles, their centres and radii, and its corners by name."""
    _body(axes, outline, turned)
    size = float(outline.radius.max())
    small: dict[str, Any] = {"size": style.NOTE, "zorder": 6}
    for name, distance, direction, radius in outline.circles[: 1 if among else None]:
        x, y = outline.place(direction, distance, turned)
        ring: dict[str, Any] = {"ec": style.GUIDE, "lw": 0.6, "ls": (0, (4, 2)), "zorder": 3}
        axes.add_patch(Circle((x, y), radius, fill=False, **ring))
        axes.plot([x], [y], ".", color=style.CAM, ms=4.0, zorder=6)
        left = x < -0.5 * size  # away from the corners
        ha, aside = ("right", -0.02) if left else ("left", 0.02)
        axes.text(x + aside * size, y, name, ha=ha, va="top", color=style.CAM, **small)
    narrow = axes.get_window_extent().width < NARROW / 25.4 * style.DPI
    for name, phase in outline.corners.items():
        direction, at = outline.touched(phase)
        x, y = outline.place(direction, np.array([0.0, at, 1.08 * at]), turned)
        axes.plot(x[:2], y[:2], color=style.GUIDE, lw=0.5, zorder=3)
        axes.plot(x[1:2], y[1:2], "o", color=style.CAM, ms=2.5, zorder=6)
        words = name if turned or among else rf"{name} {phase:.5g}$\degree$"
        side = "left" if x[2] > 0.0 else "right"
        va = "center" if abs(y[2]) > 0.1 * size else "bottom"
        axes.text(x[2], y[2], "" if narrow else words, ha=side, va=va, **small)
    _follower(axes, outline, 0.0, turned)
    each = dict.fromkeys(
        f"{name} {outline.units.lengths(radius, 4)}" for name, _, _, radius in outline.circles
    )
    radii = "base radius not given: 1.5 lifts" if outline.guessed else f"radii: {', '.join(each)}"
    said = rf"$\theta$ = {turned:g} deg"
    if outline.lobe is not None:
        said += f", {lobe_title(outline.lobe, outline.units)}"
    if turned == 0.0:
        said += f"\n{radii}"
    axes.set_title(among or said, loc="center")
    room = 1.4 * size
    _bare(axes)
    axes.set(xlim=(-room, room), ylim=(-room, (2.1 + STEM) * size))


def _draw_mechanism(axes: Axes, outline: Outline, moments: dict[str, tuple[float, float]]) -> None:
    """The follower at several moments, each named, side by side."""
    size = float(outline.radius.max())
    for k, (name, (phase, gap)) in enumerate(moments.items()):
        left = 3.2 * size * k
        _body(axes, outline, phase, left)
        _follower(axes, outline, gap, phase, left)
        words = rf"{name}, $\theta$ = {phase % 360.0:.4g} deg"
        axes.text(left, -1.35 * size, words, ha="center", va="top", size=style.NOTE)
        for corner, place in outline.corners.items():
            direction, distance = outline.touched(place)
            x, y = outline.place(direction, 0.87 * distance, phase)
            middle: dict[str, Any] = {"ha": "center", "va": "center", "color": style.CAM}
            axes.text(x + left, y, corner, size=6.5, zorder=6, **middle)
    named = {"cam": (0.0, -0.5), "follower": (0.1, 1.3), "spring": (0.14, 1.9)}
    for part, (x, y) in named.items():
        ha = "center" if x == 0.0 else "left"
        axes.text(x * size, y * size, part, size=style.NOTE, zorder=6, ha=ha, va="center")
    turning = {"arrowstyle": "->", "color": style.CAM, "connectionstyle": "arc3,rad=0.4", "lw": 0.8}
    begin, end = (0.3 * size, -0.12 * size), (0.2 * size, 0.25 * size)
    axes.annotate("", end, begin, arrowprops=turning, zorder=6)
    axes.text(0.36 * size, 0.05 * size, r"$\omega$", size=8, zorder=6)
    _bare(axes)
