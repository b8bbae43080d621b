"""Picture of the cam: lift, derivatives, contact force and curvature over one turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import degrees, nan
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from camcli.analysis.cam_profile import Profile
from camcli.analysis.lobe import Face
from camcli.cams import cam_name
from camcli.plots import style
from camcli.plots.axes import (
    draw_forces,
    lift_axis,
    padded,
    per_degree_axis,
    say,
    turn_axis,
    unit_axis,
)
from camcli.plots.mechanism import Outline, machine_panels
from camcli.plots.picture import Panel, Picture
from camcli.quantities import MILLIMETRES, THETA, Units, labelled
from camcli.words.simulate import (
    beside_title,
    cam_title,
    cam_words,
    fitted_jerk_title,
    flat_face_title,
    force_title,
    jerk_title,
    radius_title,
    roller_title,
)

SHEET, SHEET_OUTLINE = 28.0, 52.0  # mm: heights on a cam sheet, where all fits on a page
MOST_RADII = 10.0  # of the base circle: radii of curvature beyond are as good as straight


@dataclass(frozen=True)
class CamDrawing:
    """A cam to draw; `cam` is the scene's, of which a measured one shows its rows."""

    profile: Profile
    outline: Outline
    cam: Any
    units: Units
    beside: bool = False  # one of several cams side by side

    @property
    def measured(self) -> bool:
        """Whether it is a table."""
        return self.cam.kind == "table"


def draw_profiles(cams: Sequence[CamDrawing]) -> Picture:
    """Picture of a cam, others beside it; outline and follower on it where they are asked for."""
    profile = cams[0].profile
    units = cams[0].units
    low, high = profile.ranges["c"]
    said = cam_words(profile.first, cams[0].measured, cams[0].outline.ratio)
    many = len(cams) > 1
    cams = [replace(cam, beside=many) for cam in cams]
    each = [_panels(cam, cams if many else ()) for cam in cams]
    panels = {
        name if k == 1 else f"{name} {k}": own[name]
        for name in each[0]
        for k, own in enumerate(each, 1)
        if k == 1 or name in COMPARED
    }
    if not many:
        title = cam_title(high.value - low.value, units)
        return Picture(title, panels, caption=said)
    return Picture(f"Cams side by side: {', '.join(cam_name(cam.cam) for cam in cams)}", panels)


Draw = Callable[[Axes, CamDrawing], None]


def _panels(cam: CamDrawing, among: Sequence[CamDrawing]) -> dict[str, Panel]:
    """The panels of a cam; among others those that are compared are a column."""
    profile = cam.profile
    outline = cam.outline
    theta = np.degrees(profile.theta)
    slope = np.asarray(profile.c1)
    rise, fall = theta[np.argmax(slope)], theta[np.argmin(slope)]
    room = 0.4 * float(np.ptp(outline.radius))
    flying = 0.5 * (rise + (fall if fall > rise else fall + 360.0)) % 360.0
    moments = {"at rest": (0.0, 0.0), "in flight": (flying, room), "landing": (fall, 0.0)}
    panels = machine_panels(outline, moments, cam_name(cam.cam) if among else "")
    sheet = profile.lobe is not None and not among
    if sheet:
        panels["outline"] = replace(panels["outline"], usual=True, height=SHEET_OUTLINE)
        beside = partial(_draw, draw=_draw_beside, cam=cam, among=among)
        panels["angle"] = Panel(beside, SHEET_OUTLINE, across=2)
        panels["turned"] = panels.pop("turned")
    for name, draw in DRAW.items():
        half = name.startswith("curvature")
        do = partial(_draw, draw=draw, cam=cam, among=among)
        no_jerk = name == "jerk" and bool(among)
        unknown = name == "curvature of the pitch curve" and profile.curvature.knife is None
        usual = not (half and sheet) and not no_jerk and not unknown
        panels[name] = Panel(do, SHEET if sheet else 34.0, "" if half else "theta", 1 + half, usual)
    if sheet:
        radius = partial(_draw, draw=_draw_radius, cam=cam, among=among)
        panels["radius"] = Panel(radius, SHEET, "theta")
    if among:
        column = next(f"cam {k}" for k, one in enumerate(among) if one is cam)
        for name in COMPARED:
            panels[name] = replace(panels[name], across=len(among), y=name, column=column)
    return panels


def _draw(axes: Axes, draw: Draw, cam: CamDrawing, among: Sequence[CamDrawing]) -> None:
    draw(axes, cam)
    corners = {name: degrees(theta) for name, theta in cam.profile.corners.items()}
    few = len(corners) <= style.MOST_CORNERS
    turn_axis(axes, corners if few else {}, named=draw in (_draw_lift, _draw_force))
    if among and (values := VALUES.get(draw)):
        axes.set_ylim(*padded([x for other in among for x in values(other.profile)]))
        axes.set_xlabel(labelled(r"$\theta$", THETA.unit))
        axes.xaxis.set_major_locator(MultipleLocator(180))


def _curve(axes: Axes, profile: Profile, values: Sequence[float], colour: str = style.CAM) -> None:
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.plot(np.degrees(profile.theta), values, color=colour)


def _name(axes: Axes, drawn: CamDrawing, panel: str) -> None:
    """The axis of a panel, and of a cam of mm a second one in mm and degrees."""
    lift_axis(axes.yaxis, panel, drawn.units)
    if drawn.units == MILLIMETRES and panel != "lift" and not drawn.beside:
        per_degree_axis(axes, panel)


def _draw_lift(axes: Axes, drawn: CamDrawing) -> None:
    profile = drawn.profile
    cam = drawn.cam
    name = "cam" if drawn.measured else None
    axes.plot(np.degrees(profile.theta), profile.c, color=style.CAM, label=name)
    _name(axes, drawn, "lift")
    if drawn.measured:
        in_the_file = cam.measured.line > 0  # line 0: a row that fills a dwell
        theta = cam.measured.theta[in_the_file]
        c = cam.base + cam.measured.lift[in_the_file]
        rows = "rows of the table"
        axes.plot(theta, c, ".", color=style.MEASURED, ms=2.0, zorder=3, label=rows)


def _draw_slope(axes: Axes, drawn: CamDrawing) -> None:
    _curve(axes, drawn.profile, drawn.profile.c1)
    _name(axes, drawn, "velocity")


def _draw_acceleration(axes: Axes, drawn: CamDrawing) -> None:
    profile = drawn.profile
    _curve(axes, profile, profile.c2)
    _name(axes, drawn, "acceleration")
    if not drawn.measured:
        return
    axes.set_title(f"error below {drawn.units.lengths(drawn.cam.accuracy.bound, 2)}/rad²")
    _doubt(axes, profile, profile.c2, drawn.cam.errors.bounds, "bound on its error")


def _doubt(
    axes: Axes,
    profile: Profile,
    values: Sequence[float],
    bounds: Sequence[float],
    words: str | None,
) -> None:
    """A band about the values of a measured cam; bounds: in equal shares of the turn.

    words: its entry in the legend.
    """
    angle = np.degrees(profile.theta)
    middle = np.asarray(values)
    share = (angle / 360.0 * len(bounds)).astype(int)
    bound = np.asarray(bounds)[np.minimum(share, len(bounds) - 1)]
    band = (angle, middle - bound, middle + bound)
    axes.fill_between(*band, color=style.DOUBT, lw=0, label=words, zorder=0.4)


def _draw_jerk(axes: Axes, drawn: CamDrawing) -> None:
    """The third derivative; at the corners it is infinite. Of a measured cam it is the fit's."""
    profile = drawn.profile
    _curve(axes, profile, profile.c3)
    _name(axes, drawn, "jerk")
    if not drawn.measured:
        axes.set_title(jerk_title(profile.corners))
        return
    errors = drawn.cam.errors.jerk.bounds
    axes.set_title(fitted_jerk_title(max(errors), drawn.units))
    _doubt(axes, profile, profile.c3, errors, None)


def _draw_beside(axes: Axes, drawn: CamDrawing) -> None:
    """The pressure angle of a knife edge or a roller, the eccentricity of a flat face."""
    lobe = drawn.profile.lobe
    assert lobe is not None
    if lobe.face is Face.FLAT:
        _curve(axes, drawn.profile, [touch.beside for touch in lobe.touches])
        unit_axis(axes.yaxis, "eccentricity", drawn.units)
    else:
        _curve(axes, drawn.profile, [degrees(touch.angle) for touch in lobe.touches])
        axes.set_ylabel(labelled("pressure angle", "deg"))
    axes.set_title(beside_title(lobe, drawn.units))


def _draw_radius(axes: Axes, drawn: CamDrawing) -> None:
    """The radius of curvature of the lobe where it is touched, less what is nearly straight."""
    lobe = drawn.profile.lobe
    assert lobe is not None
    colour = style.TROUBLE if lobe.undercut else style.CAM
    most = MOST_RADII * lobe.base
    radii = [touch.radius if abs(touch.radius) < most else nan for touch in lobe.touches]
    _curve(axes, drawn.profile, radii, colour)
    unit_axis(axes.yaxis, "radius", drawn.units)
    axes.set_title(radius_title(lobe, drawn.units), color=colour)


def _draw_force(axes: Axes, drawn: CamDrawing) -> None:
    force = drawn.profile.force
    draw_forces(axes, [force])
    named = 0 < len(drawn.profile.corners) <= style.MOST_CORNERS
    names_below = "\n" if named else ""  # a line for the names of corners
    axes.set_title(force_title(force) + names_below)


def _draw_flat(axes: Axes, drawn: CamDrawing) -> None:
    """What a flat face sees of the cam."""
    bent = drawn.profile.curvature
    colour = style.TROUBLE if bent.undercut else style.CAM
    _curve(axes, drawn.profile, bent.flat, colour)
    less = "" if bent.base_radius is not None else "\nless the base radius"
    unit_axis(axes.yaxis, f"radius of curvature{less}", drawn.units)
    axes.set_title(flat_face_title(bent, drawn.units), color=colour)


def _draw_knife(axes: Axes, drawn: CamDrawing) -> None:
    """What a knife edge or a roller sees of the cam."""
    bent = drawn.profile.curvature
    if bent.knife is None:
        say(axes, "unknown without the base radius\n(--base-radius)")
    else:
        _curve(axes, drawn.profile, bent.knife)
    axes.set_title(roller_title(bent, drawn.units))
    axes.set_ylabel(labelled("curvature", "1/m"))


DRAW: dict[str, Draw] = {
    "lift": _draw_lift,
    "velocity": _draw_slope,
    "acceleration": _draw_acceleration,
    "jerk": _draw_jerk,
    "force": _draw_force,
    "curvature": _draw_flat,
    "curvature of the pitch curve": _draw_knife,
}
COMPARED = ("outline", "lift", "velocity", "acceleration", "force")
VALUES: dict[Draw, Callable[[Profile], Sequence[float]]] = {
    _draw_lift: lambda profile: profile.c,
    _draw_slope: lambda profile: profile.c1,
    _draw_acceleration: lambda profile: profile.c2,
    _draw_force: lambda profile: profile.force.force_n,
}
