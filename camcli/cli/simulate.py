"""cam simulate"""

from __future__ import annotations

from math import degrees, radians
from typing import TYPE_CHECKING, Any

from camcli.cli.options import Request, flag, given, option
from camcli.cli.report import say, table
from camcli.quantities import (
    FORCE,
    LIFT_RANGES,
    MM,
    PER_DEGREE,
    RPM,
    THETA,
    U_MINUS,
    U_PLUS,
    headed,
)

if TYPE_CHECKING:
    from camcli.api.result import Result
    from camcli.quantities import Units

WITHOUT = ("verbose",)  # shared options that mean nothing here
SHOWN = 12  # events in the table on stdout
NOTHING = 1e-18  # m, rounding of a lift
DIGITS_OF_A_FITTED_JERK = 2  # of a measured cam, whose third derivative is an estimate


def simulate(
    request: Request,
    profile_only: bool = flag("Write and draw the cam, simulate nothing."),
    base_radius: float | None = option("Radius of the base circle, m.", "M"),
    animate: bool = flag("Also write the machine in motion, simulate.gif and .mp4."),
) -> int:
    """One orbit in time: its events and its trajectory.

    Examples:
      cam simulate --rpm 190                   from rest, at 190 rpm
      cam simulate --rpm 190 --animate         the machine in motion, as a GIF
      cam simulate --profile-only              the cam alone, its curvature

    Files:
      trajectory.csv   position, velocity and cam, sampled and at every event
      events.csv       impacts, ends of chatter, detachments
      profile.csv      the cam alone; profile_2.csv and profile_3.csv: others
      outline.csv      the lobe (contact.face)
      simulate.png     position, gap and phase plane of the last turns
      profile.png      the cam (--profile-only)
      simulate.gif     the machine in motion (--animate); simulate.mp4 with ffmpeg

    \b
    simulate.png    panels motion, gap, phase: position, relative position and relative phase plane
                    of the last turns; where asked for by --panels: section, the states at the
                    strobe, and passage, a zoom on the last detachment
    simulate.gif    with --animate the machine in motion, simulate.plot_turns turns at the end or
                    one period; simulate.mp4 too where ffmpeg is found

    \b
    t_s counts from the first recorded turn (run.transient), period from the strobe phase; a start
    off the strobe phase without transient records the rest of that turn as period -1.

    \b
    Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a
    complete chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64
    turns fits, none is being approached, and in run.patience further turns the motion neither
    settles nor rests; undecided: too few impacts, or a rest after the record. The label of a record
    that is a transient is that of what it settles on, as a note says; near 358 rpm a long cycle
    through inf may be an accident of rounding: cam classify tells.
    Status: ok; impact-budget, no-return, unresolved: the record ends early, exit code 3.

    \b
    --profile-only writes and draws the cam instead, profile.csv:
    profile.png  panels lift, velocity, acceleration, jerk, force, curvature; where asked for by
                 --panels: mechanism, the cam with its follower at rest, lifting and landing, and
                 outline and turned, the cam with its circles and corners at 0 and at 180 deg
    jerk is the third derivative by the cam angle. At a corner it is infinite, and where it jumps
    it has a value on either side. That of a measured cam is that of its fit, an estimate.

    \b
    contact.face says what runs on the lobe: knife, roller (of contact.follower_radius) or flat; the
    base circle is that of --base-radius, contact or the cam. Then there is the cam sheet:
    outline.csv    the lobe where it is touched, x and y when the cam has not turned, m
    profile.csv    also lobe_radius_m, and pressure_angle_deg or of a flat face eccentricity_m
    profile.png    outline with that follower, angle (or eccentricity) and radius for curvature
    and the least radius, undercut, sharpest hollow and largest roller stand on the screen.
    Curvature assumes a follower that moves along a line through the axis, base_radius + c minus
    the lowest c away from it; the radius is the cam's, or that of --base-radius. Under a rocker
    (cam.rocker_ratio) the cam drawn and its curvature are those of the lobe, which lifts
    rocker_ratio times less; lift, velocity, acceleration and force are those of the valve.
    """
    from camcli.cli.run import one_speed, run

    values = one_speed(request)
    values |= given("simulate", profile_only=profile_only, base_radius=base_radius, animate=animate)
    return run("simulate", request, values, show)


def show(result: Result, _: bool) -> None:
    """Print the events of the last period, or what a follower needs of the cam."""
    if result.scene.simulate.profile_only:
        _show_profile(result)
        return
    from camcli.words.simulate import record_title

    found = result.values
    last = found.last_period[-SHOWN:]
    system: Any = result.system
    rows = []
    for _time, period, theta_deg, name, _q, u_minus, u_plus in last:  # as in events.csv
        event = name
        if system.has_seat:
            event += ", seat" if system.is_seat(radians(theta_deg)) else ", lobe"
        rows.append([event, str(period), f"{theta_deg:.4f}", f"{u_minus:.4g}", f"{u_plus:.4g}"])
    heads = ["event", "period", THETA.heading, U_MINUS.heading, U_PLUS.heading]
    table(record_title(found, len(last), result.scene.cam.kind), heads, rows)


def _show_profile(result: Any) -> None:
    """Print the extremes of the cam, where contact is lost first, and what followers need.

    Values are in the units of the machine, each with the angle at which it occurs.
    """
    from camcli.system import is_measured, units_of
    from camcli.words.machine import digits_of
    from camcli.words.speeds import range_words

    profile = result.values
    units = units_of(result.system)
    measured = result.scene.cam.kind == "table"
    rows = _Rows(digits_of(result.scene))
    _add_extremes(rows, profile, result.scene.cam, units)
    force = profile.force
    what = headed(f"least {FORCE.name} at {force.rpm:.10g} rpm", FORCE.unit)
    rows.add(what, force.lowest_n, force.lowest_theta)
    first = profile.first
    if first is not None and first.finite:
        rows.add(headed("first detachment", RPM.unit), first.rpm, first.theta)
        if is_measured(result.system):
            left_open = range_words(first.low, first.high).removesuffix(" rpm")
            rows.add_text(headed("left open by the table", RPM.unit), left_open)
    ratio = result.system.rocker_ratio
    if profile.lobe is not None:
        _add_lobe(rows, profile.lobe, units, ratio)
    else:
        _add_curvature(rows, profile.curvature, units, ratio)
    _print_cam(profile, rows.cells, measured)


class _Rows:
    """The rows of the table of a cam: what it is, a value, and the angle at which it occurs."""

    def __init__(self, digits: int):
        """digits: of a value, unless more or fewer are known."""
        self.digits = digits
        self.cells: list[list[str]] = []

    def add(self, what: str, value: float, theta: float, digits: int | None = None) -> None:
        """Add a value, in the unit that `what` names, and its angle (rad)."""
        from camcli.words.in_print import written_out

        text = written_out(value, self.digits if digits is None else digits)
        self.cells.append([what, text, f"{degrees(theta):.{self.digits}g}"])

    def add_text(self, what: str, text: str) -> None:
        """Add what has no angle."""
        self.cells.append([what, text, ""])


def _add_extremes(rows: _Rows, profile: Any, cam: Any, units: Units) -> None:
    """Least and largest lift and derivatives: by rad in the unit of the machine, by deg in mm."""
    measured = cam.kind == "table"
    digits_of_value = dict.fromkeys(profile.ranges, rows.digits)
    if measured:
        digits_of_value["c_thetathetatheta"] = DIGITS_OF_A_FITTED_JERK
    for name, extremes in profile.ranges.items():
        unit, scale = units.shown(LIFT_RANGES[name].unit)
        for word, extreme in zip(("least", "largest"), extremes, strict=True):
            what = headed(f"{word} {name}", unit)
            if measured and name == "c" and _on_base_circle(cam, extreme.value):
                rows.add_text(what, "base circle")
                continue
            value = extreme.value if abs(extreme.value) > NOTHING else 0.0
            rows.add(what, value * scale, extreme.theta, digits_of_value[name])
    derivatives = list(zip(LIFT_RANGES, PER_DEGREE, strict=True))[1:]  # without the lift itself
    for order, (name, quantity) in enumerate(derivatives, 1):
        for word, extreme in zip(("least", "largest"), profile.ranges[name], strict=True):
            what = headed(f"{word} {quantity.name}", quantity.unit)
            value = MM * extreme.value * radians(1.0) ** order
            rows.add(what, value, extreme.theta, digits_of_value[name])


def _add_curvature(rows: _Rows, curvature: Any, units: Units, ratio: float) -> None:
    """What a flat face and a roller need of a cam whose follower is not known.

    ratio: of the rocker, 1 without one.
    """
    lobe = "" if ratio == 1.0 else f" of the lobe (rocker {ratio:.6g})"
    if curvature.base_radius is not None:
        least = curvature.flat_least
        what = f"least radius of curvature{lobe}, flat face ({units.length})"
        rows.add(what, least.value * units.per_m, least.theta)
    needed = f"{curvature.least_base_radius * units.per_m:.{rows.digits}g}"
    rows.add_text(f"base radius a flat face needs ({units.length})", needed)
    if curvature.roller is not None:
        what = f"largest roller radius ({units.length})"
        rows.add(what, curvature.roller.value * units.per_m, curvature.roller.theta)


def _on_base_circle(cam: Any, height: float) -> bool:
    """Whether a measured cam at this height (m) cannot be told from its base circle."""
    return bool(abs(height - cam.base) < cam.least_lift)


def _print_cam(found: Any, rows: list[list[str]], measured: bool) -> None:
    """The table of a cam, and where its jerk is infinite, or what it is worth."""
    from camcli.words.simulate import JERK_OF_A_FIT

    corners = ", ".join(f"{name} {degrees(theta):.8g}" for name, theta in found.corners.items())
    table(f"Cam, corners (deg): {corners or 'none'}", ["what", "value", THETA.heading], rows)
    if measured:
        say(JERK_OF_A_FIT, "- ")
    elif found.corners:
        say("the jerk is infinite at the corners; least and largest are those between them", "- ")


def _add_lobe(rows: _Rows, lobe: Any, units: Units, ratio: float) -> None:
    """What a cam sheet says of the lobe; ratio: of the rocker, 1 without one."""
    from camcli.words.simulate import closing_words, lobe_title

    def add(what: str, extreme: Any, scale: float) -> None:
        """Add a value of the lobe, m or rad times a scale, with its angle."""
        text = f"{extreme.value * scale:.{rows.digits}g}"
        rows.cells.append([what, text, f"{degrees(extreme.theta):.{rows.digits}g}"])

    in_length = units.per_m
    rocker = "" if ratio == 1.0 else f", rocker {ratio:.6g}"
    rows.add_text(
        f"base radius of the lobe, {lobe_title(lobe, units)}{rocker} ({units.length})",
        f"{lobe.base * in_length:.{rows.digits}g}",
    )
    add(f"least radius of curvature where convex ({units.length})", lobe.least, in_length)
    if lobe.hollow is not None:
        add(f"radius of the sharpest hollow ({units.length})", lobe.hollow, in_length)
    if lobe.largest_roller is not None:
        what = f"largest roller on this base circle ({units.length})"
        add(what, lobe.largest_roller, in_length)
    if lobe.least_base is not None:
        needed = f"{lobe.least_base * in_length:.{rows.digits}g}"
        rows.add_text(f"base radius a flat face needs ({units.length})", needed)
    for word, extreme in zip(("least", "largest"), lobe.beside, strict=True):
        if lobe.face == "flat":
            add(f"{word} eccentricity of the contact ({units.length})", extreme, in_length)
        else:
            add(f"{word} pressure angle (deg)", extreme, degrees(1.0))
    rows.add_text("outline", closing_words(lobe, units))
