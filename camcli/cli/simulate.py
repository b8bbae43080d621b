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

    def told(name: str, theta: float) -> str:
        """The event; with a seat where it is."""
        if not system.has_seat:
            return name
        return f"{name}, {'seat' if system.is_seat(radians(theta)) else 'lobe'}"

    rows = [
        [told(name, theta), str(period), f"{theta:.4f}", f"{u:.4g}", f"{after:.4g}"]
        for _, period, theta, name, _, u, after in last
    ]
    heads = ["event", "period", THETA.heading, U_MINUS.heading, U_PLUS.heading]
    table(record_title(found, len(last), result.scene.cam.kind), heads, rows)


def _show_profile(result: Any) -> None:
    """Print the extremes of the cam, where contact is lost first, and what followers need.

    Values are in the units of the machine, each with the angle at which it occurs.
    """
    from camcli.system import is_measured, units_of
    from camcli.words.in_print import written_out
    from camcli.words.machine import digits_of
    from camcli.words.speeds import range_words

    found = result.values
    units = units_of(result.system)
    digits = digits_of(result.scene)
    measured = result.scene.cam.kind == "table"
    deserved = dict.fromkeys(found.ranges, digits)
    if measured:
        deserved["c_thetathetatheta"] = DIGITS_OF_A_FITTED_JERK
    rows = []

    def row(what: str, value: float, theta: float, significant: int = digits) -> None:
        """Add a line: what it is, its value in the unit shown, and the angle in rad."""
        rows.append([what, written_out(value, significant), f"{degrees(theta):.{digits}g}"])

    for name, (low, high) in found.ranges.items():
        for word, extreme in (("least", low), ("largest", high)):
            if measured and name == "c" and _on_base_circle(result.scene.cam, extreme.value):
                what = headed(f"{word} c", units.shown(LIFT_RANGES[name].unit)[0])
                rows.append([what, "base circle", ""])
                continue
            value = extreme.value if abs(extreme.value) > NOTHING else 0.0
            unit, scale = units.shown(LIFT_RANGES[name].unit)
            row(headed(f"{word} {name}", unit), value * scale, extreme.theta, deserved[name])
    for order, (name, quantity) in enumerate(zip(LIFT_RANGES, PER_DEGREE, strict=True)):
        if order == 0:
            continue
        for word, extreme in zip(("least", "largest"), found.ranges[name], strict=True):
            value = MM * extreme.value * radians(1.0) ** order
            row(
                headed(f"{word} {quantity.name}", quantity.unit),
                value,
                extreme.theta,
                deserved[name],
            )
    force = found.force
    bent = found.curvature
    first = found.first
    what = headed(f"least {FORCE.name} at {force.rpm:.10g} rpm", FORCE.unit)
    row(what, force.lowest_n, force.lowest_theta)
    if first is not None and first.finite:
        row(headed("first detachment", RPM.unit), first.rpm, first.theta)
        if is_measured(result.system):
            left = range_words(first.low, first.high).removesuffix(" rpm")
            rows.append([headed("left open by the table", RPM.unit), left, ""])
    if found.lobe is not None:
        rows += _lobe_rows(found.lobe, units, digits, result.system.rocker_ratio)
        _print_cam(found, rows, measured)
        return
    ratio = result.system.rocker_ratio
    lobe = "" if ratio == 1.0 else f" of the lobe (rocker {ratio:.6g})"
    if bent.base_radius is not None:
        least = bent.flat_least
        what = f"least radius of curvature{lobe}, flat face ({units.length})"
        row(what, least.value * units.per_m, least.theta)
    needed = f"{bent.least_base_radius * units.per_m:.{digits}g}"
    rows.append([f"base radius a flat face needs ({units.length})", needed, ""])
    if bent.roller is not None:
        what = f"largest roller radius ({units.length})"
        row(what, bent.roller.value * units.per_m, bent.roller.theta)
    _print_cam(found, rows, measured)


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


def _lobe_rows(lobe: Any, units: Any, digits: int, ratio: float) -> list[list[str]]:
    """What a cam sheet says of the lobe, each with the angle at which it occurs."""
    from camcli.words.simulate import closing_words, lobe_title

    flat = lobe.face == "flat"
    rows = []

    def row(what: str, found: Any, scale: float = units.per_m) -> None:
        rows.append(
            [what, f"{found.value * scale:.{digits}g}", f"{degrees(found.theta):.{digits}g}"]
        )

    rocker = "" if ratio == 1.0 else f", rocker {ratio:.6g}"
    base = f"{lobe.base * units.per_m:.{digits}g}"
    rows.append(
        [f"base radius of the lobe, {lobe_title(lobe, units)}{rocker} ({units.length})", base, ""]
    )
    row(f"least radius of curvature where convex ({units.length})", lobe.least)
    if lobe.hollow is not None:
        row(f"radius of the sharpest hollow ({units.length})", lobe.hollow)
    if lobe.largest_roller is not None:
        row(f"largest roller on this base circle ({units.length})", lobe.largest_roller)
    if lobe.least_base is not None:
        needed = f"{lobe.least_base * units.per_m:.{digits}g}"
        rows.append([f"base radius a flat face needs ({units.length})", needed, ""])
    unit, scale = (units.length, units.per_m) if flat else ("deg", degrees(1.0))
    for word, extreme in zip(("least", "largest"), lobe.beside, strict=True):
        name = "eccentricity of the contact" if flat else "pressure angle"
        row(f"{word} {name} ({unit})", extreme, scale)
    rows.append(["outline", closing_words(lobe, units), ""])
    return rows
