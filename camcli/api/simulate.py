"""camcli.simulate: one orbit in time, or only the cam it moves on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import degrees, isfinite, pi
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

from camcli.analysis.cam_profile import Extreme
from camcli.analysis.integrate import Cost
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, sample
from camcli.api.lift_table import lost_between
from camcli.api.machine import Machine, machine_of, with_arguments
from camcli.api.result import Progress, Result, drawn_by
from camcli.errors import Fault, SceneError, Status, plural
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.quantities import (
    FORCE,
    JERK,
    LIFT_RANGES,
    LIFTS,
    MM,
    PER_DEGREE,
    THETA,
    TIME,
    TURN,
    U_MINUS,
    U_PLUS,
    Head,
    Q,
    Quantity,
    V,
)
from camcli.scene import Scene
from camcli.system import System, omega_of, units_of
from camcli.words import plan
from camcli.words.machine import height_notes
from camcli.words.simulate import (
    ASSUMED,
    JERK_OF_A_FIT,
    end_notes,
    lobe_notes,
    rounding_notes,
    undercut_notes,
)
from camcli.words.statuses import trouble

if TYPE_CHECKING:
    from camcli.analysis.cam_profile import Profile, Runner
    from camcli.analysis.lobe import Found, Lobe, Touch
    from camcli.analysis.simulate import Simulation
    from camcli.plots.picture import Picture

RAD_PER_DEG = pi / 180.0
TRAJECTORY = Head(
    "trajectory",
    "the motion; an impact has two rows, just before and just after",
    (
        TIME, THETA, Q, V, LIFTS["c"],
        Quantity("c_dot_m_per_s", "m/s", r"$\dot c$", "velocity of the cam under the follower"),
        Quantity("contact", "", "contact", "where the follower is", "flight, sticking"),
    ),
)  # fmt: skip
EVENTS = Head(
    "events",
    "impacts, complete chatters and detachments",
    (
        TIME, TURN, THETA,
        Quantity(
            "event", "", "event", "what happens",
            "impact; chatter: impacts have accumulated, the follower now sticks; detachment",
        ),
        Q, U_MINUS, U_PLUS,
    ),
)  # fmt: skip
PRESSURE_ANGLE = Quantity(
    "pressure_angle_deg", "deg", "pressure angle",
    "between the force on the follower and the line on which it moves, positive on the rise",
)  # fmt: skip
ECCENTRICITY = Quantity(
    "eccentricity_m", "m", "eccentricity",
    "of the contact on a flat face, from the line on which it moves",
)  # fmt: skip
PROFILE = Head(
    "profile",
    "with profile_only: the cam over a turn, two rows at a corner and where the third derivative "
    "jumps, left side first; profile_2 and profile_3 of the cams in simulate.beside; under a "
    "rocker all of them are the valve's, but for the radius, the pressure angle and the "
    "eccentricity, and the curvature in the summary and the picture, which are the lobe's",
    (THETA, *LIFTS.values(), FORCE, JERK, *PER_DEGREE),
    {
        "with contact.face": (
            Quantity(
                "lobe_radius_m", "m", "radius of curvature",
                "radius of curvature of the lobe where it is touched, negative in a hollow and "
                "where it is undercut", "inf where it is straight",
            ),
        ),
        "with contact.face: knife or roller": (PRESSURE_ANGLE,),
        "with contact.face: flat": (ECCENTRICITY,),
    },
)  # fmt: skip
OUTLINE = Head(
    "outline",
    "with profile_only and contact.face: the lobe, not turned, where it is touched; x_m to the "
    "right, y_m towards the follower, phases clockwise from it; the last row closes the curve",
    (
        THETA,
        Quantity("x_m", "m", "$x$", "to the right"),
        Quantity("y_m", "m", "$y$", "towards the follower"),
        Quantity(
            "contact_angle_deg", "deg", "contact angle",
            "direction of the point from the axis, counted as theta_deg is",
        ),
    ),
)  # fmt: skip


def simulate(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    profile_only: bool = False,
    base_radius: float | None = None,
    animate: bool = False,
) -> Result:
    """Time response of one orbit: exact events, and a trajectory from the closed-form flow.

    Free flight obeys m q'' + b q' + k q = -m g - F0, an impact the reset map u+ = -r u-, and a
    complete chatter ends in sticking until the contact force falls to zero.

    Parameters
    ----------
    scene : Scene, optional
        The machine, the speed ``run.rpm``, the start and the number of turns; the default scene if
        left out. ``simulate.samples`` points a turn are sampled beside the events.
        ``simulate.profile_only``, ``base_radius`` and ``animate`` ask for what the arguments of
        these names do.
    progress : callable, optional
        Not called: one orbit is one piece.
    profile_only : bool
        Only the cam: lift, derivatives, contact force and curvature over one turn, no motion.
    base_radius : float, optional
        With ``profile_only``: radius of the base circle, m, for the curvature.
    animate : bool
        Save the machine in motion too, ``simulate.gif``, and ``simulate.mp4`` where ffmpeg is
        found: the last ``simulate.plot_turns`` turns, or one period where that is shorter.

    Returns
    -------
    Result
        Tables ``trajectory`` and ``events``, or with ``profile_only`` ``profile``, and ``outline``
        where ``contact.face`` says what runs on the lobe; their columns are in the guide
        (`cam guide simulate`).

    Raises
    ------
    SceneError
        If the start lies below the cam.

    Examples
    --------
    >>> import camcli
    >>> turns = {"run.transient": 0, "run.record": 2}
    >>> result = camcli.simulate(camcli.load_scene(None, {"run.rpm": 100.0, **turns}))
    >>> result.summary["label"]
    'contact'
    >>> sorted(result.tables)
    ['events', 'trajectory']

    References
    ----------
    Closing a chatter by its map: A. B. Nordmark and P. T. Piiroinen, Nonlinear Dynamics 58 (2009)
    85-106.
    """
    machine = machine_of(
        with_arguments(
            scene,
            "simulate",
            profile_only=profile_only,
            base_radius=base_radius,
            animate=animate,
        )
    )
    if machine.scene.simulate.profile_only:
        return _profile(machine)
    from camcli.analysis.simulate import simulate as run

    scene = machine.scene
    system = machine.system
    with stopwatch() as watch:
        found = run(system, scene.run.rpm, machine.settings, scene.simulate.samples)

    draw = drawn_by("simulate.draw_simulation", found, system, scene.simulate.plot_turns)
    return Result(
        command="simulate",
        scene=scene,
        system=system,
        values=found,
        tables={
            "trajectory": Table.of_rows(TRAJECTORY.names(), lambda: found.trajectory),
            "events": Table.of_rows(EVENTS.names(), lambda: found.events),
        },
        summary={
            "rpm": found.rpm,
            "label": found.label,
            "status": Status(found.status).text,
            "periods": found.periods,
            "events": len(found.events),
            "corners_deg": [degrees(corner) for corner in found.corners],
        },
        pictures={"simulate": draw},
        files=_films(machine, found) if scene.simulate.animate and found.trajectory else {},
        cost=found.cost,
        seconds=watch.seconds,
        notes=(
            *height_notes(throw(system, found.rpm)),
            *rounding_notes(found.one_of_many),
            *end_notes(found),
            *trouble(found.status),
        ),
        complete=found.status == Status.OK,
    )


def _films(machine: Machine, found: Simulation) -> dict[str, Callable[[BinaryIO], None]]:
    """Functions that write the motion as animated files, by the names of these."""
    from camcli.output.pictures import animation_kinds

    return {
        f"simulate.{kind}": partial(_write_film, machine, found, kind) for kind in animation_kinds()
    }


def _write_film(machine: Machine, found: Simulation, kind: str, file: BinaryIO) -> None:
    """Write the last turns of the motion into a file, as a GIF or as an MP4."""
    from camcli.output.pictures import write_animation
    from camcli.plots.mechanism import Outline
    from camcli.plots.simulate import draw_frames

    cam = machine.scene.cam
    turns = machine.scene.simulate.plot_turns
    outline = Outline.of_lift(machine.system, getattr(cam, "base_radius", None), cam)
    write_animation(draw_frames(found, machine.system, outline, turns), file, kind)


def _profile(machine: Machine) -> Result:
    """The cam of a scene over one turn, and what a flat face or a roller needs of it.

    The cams of simulate.beside are drawn and tabulated too; the summary is of the scene's own.
    """
    scene = machine.scene
    profiles = []
    with stopwatch() as watch:
        for cam in _cams_side_by_side(machine):
            runner = _runner(scene, cam.base_radius) if cam.machine is machine else None
            profiles.append(_profile_of(cam, scene, runner))

    result = profiles[0].profile
    tables = {}
    for number, of_cam in enumerate(profiles, 1):
        name = "profile" if number == 1 else f"profile_{number}"
        rows = partial(_profile_rows, of_cam.profile, of_cam.machine.system, scene.run.rpm)
        tables[name] = Table.of_rows(_profile_names(of_cam.profile), rows)
    lobe = result.lobe
    if lobe is None:
        notes = undercut_notes(result, machine.system)
    else:
        notes = lobe_notes(lobe, units_of(machine.system))
        points = [
            (degrees(touch.theta), *touch.place, degrees(touch.direction)) for touch in lobe.touches
        ]
        tables["outline"] = Table.of_rows(OUTLINE.names(), lambda: points)
    return Result(
        command="simulate",
        scene=scene,
        system=machine.system,
        values=result,
        tables=tables,
        summary=_profile_summary(result, machine.system.rocker_ratio, scene.cam),
        pictures={"profile": partial(_draw_profiles, profiles)},
        cost=Cost(),
        seconds=watch.seconds,
        notes=tuple(notes),
    )


class _CamBeside(NamedTuple):
    """A machine whose cam is drawn, and the radius of its base circle, m; None where not known."""

    machine: Machine
    base_radius: float | None


class _CamProfile(NamedTuple):
    """One of the cams that are drawn, with its profile; base_radius: as in `_CamBeside`."""

    machine: Machine
    base_radius: float | None
    profile: Profile


def _cams_side_by_side(machine: Machine) -> list[_CamBeside]:
    """The machine of the scene, then the same with each of the cams in simulate.beside.

    --base-radius is that of the scene's own cam. A cam that does not say its base radius has the
    first one that is known.
    """
    scene = machine.scene
    others = [scene.model_copy(update={"cam": cam}) for cam in scene.simulate.beside]
    machines = [machine, *map(machine_of, others)]
    radii = [getattr(each.scene.cam, "base_radius", None) for each in machines]
    radii[0] = scene.simulate.base_radius or radii[0]
    first_known = next(filter(None, radii), None)
    return [
        _CamBeside(each, radius or first_known)
        for each, radius in zip(machines, radii, strict=True)
    ]


def _profile_of(cam: _CamBeside, scene: Scene, runner: Runner | None) -> _CamProfile:
    """The profile of a cam; runner: what runs on its lobe, where that is known.

    The first detachment of a measured cam has the range that the error of its table leaves.
    """
    from camcli.analysis.cam_profile import profile

    system = cam.machine.system
    result = profile(system, scene.run.rpm, scene.simulate.samples, cam.base_radius, runner)
    first_loss_range = lost_between(system)
    if first_loss_range is not None and result.first is not None:
        low, high = first_loss_range
        result = replace(result, first=replace(result.first, low=low, high=high))
    return _CamProfile(cam.machine, cam.base_radius, result)


def _runner(scene: Scene, base: float | None) -> Runner | None:
    """What runs on the lobe; None where the scene does not say.

    The radius of its base circle is that of --base-radius, else of the section contact, else
    `base`, that of the cam (m). Raises SceneError where none of them has one.
    """
    from camcli.analysis.cam_profile import Runner
    from camcli.analysis.lobe import Face

    contact = scene.contact
    if contact is None or contact.face is None:
        return None
    base = scene.simulate.base_radius or contact.base_radius or base
    if base is None:
        found, expected = "found no radius of the base circle", "expected it here or in the cam"
        raise SceneError(Fault("", "contact.base_radius", found, expected, "give it in m"))
    return Runner(Face(contact.face), base, contact.follower_radius or 0.0)


def _profile_rows(profile: Profile, system: System, rpm: float) -> Iterator[tuple]:
    """The rows of profile.csv of a cam, with the force (N) of a follower that stays on it.

    On a cam with lash the follower stays on the cam less the lash, or on its seat above that.
    """
    follower = system.follower
    omega = omega_of(rpm)
    lowest = profile.ranges["c"][0].value
    seat = system.lift_range[0]  # its height, m, where there is a lash
    for k, theta in enumerate(profile.theta):
        c, c1, c2, c3 = profile.c[k], profile.c1[k], profile.c2[k], profile.c3[k]
        q, q1, q2 = c, c1, c2  # position of the follower, and its derivatives by theta
        if system.lash:
            q = c - system.lash
            if q < seat:
                q, q1, q2 = seat, 0.0, 0.0
        preload = follower.mass * follower.gravity + follower.preload
        at_standstill = preload + follower.stiffness * q
        force = at_standstill + omega * (follower.damping * q1 + follower.mass * (omega * q2))
        of_lobe: tuple[float, ...] = ()
        if profile.lobe is not None:
            of_lobe = _of_lobe(profile.lobe.face, profile.lobe.touches[k])
        yield (
            degrees(theta),
            c,
            c1,
            c2,
            force,
            c3,
            *_per_degree(c - lowest, c1, c2, c3),
            *of_lobe,
        )


def _profile_names(profile: Profile) -> list[str]:
    """The columns of profile.csv."""
    if profile.lobe is None:
        return list(PROFILE.names())
    beside = ECCENTRICITY if profile.lobe.face == "flat" else PRESSURE_ANGLE
    return [*PROFILE.names(), "lobe_radius_m", beside.column]


def _per_degree(lift: float, c1: float, c2: float, c3: float) -> Iterator[float]:
    """Lift (m) and its three derivatives by rad, in mm and degrees."""
    for order, value in enumerate((lift, c1, c2, c3)):
        yield MM * value * RAD_PER_DEG**order


def _of_lobe(face: str, touch: Touch) -> tuple[float, float]:
    """Radius of curvature (m), and pressure angle (deg) or of a flat face the eccentricity (m)."""
    return touch.radius, touch.beside if face == "flat" else degrees(touch.angle)


def _draw_profiles(profiles: Sequence[_CamProfile]) -> Picture:
    """The cams side by side."""
    from camcli.plots.cam_profile import CamDrawing, draw_profiles
    from camcli.plots.mechanism import Outline

    units = units_of(profiles[0].machine.system)
    drawings = []
    for machine, base_radius, profile in profiles:
        cam = machine.scene.cam
        lobe = profile.lobe
        drawn = machine.system.as_drawn
        if lobe is None:
            outline = Outline.of_lift(drawn, base_radius, cam)
        else:
            outline = Outline.of_lobe(drawn, lobe)
        drawings.append(CamDrawing(profile, outline, cam, units))
    return draw_profiles(drawings)


def _extreme(extreme: Extreme) -> dict[str, float]:
    """An entry of run.json: the value, and the angle at which it occurs (deg)."""
    return {"value": extreme.value, "theta_deg": degrees(extreme.theta)}


def _profile_summary(profile: Profile, ratio: float, cam: Any) -> dict[str, Any]:
    """What run.json says of a cam: extremes, least force, first detachment, curvature.

    ratio: of the rocker, 1 without one; cam: the scene's.
    """
    measured = cam.kind == "table"
    curvature = profile.curvature
    first = profile.first
    summary: dict[str, Any] = {
        "rpm": profile.force.rpm,
        "corners_deg": {name: degrees(theta) for name, theta in profile.corners.items()},
        "ranges": {
            f"{name} ({LIFT_RANGES[name].unit})": [_extreme(low), _extreme(high)]
            for name, (low, high) in profile.ranges.items()
        },
        "least_force_n": {
            "value": profile.force.lowest_n,
            "theta_deg": degrees(profile.force.lowest_theta),
        },
        "first_detachment_rpm": first.rpm if first is not None and first.finite else None,
        "first_detachment_between_rpm": None if first is None else [first.low, first.high],
        "base_radius_m": curvature.base_radius,
        "flat_faced": {
            "least_radius_m": _extreme(curvature.flat_least) if curvature.base_radius else None,
            "undercut": curvature.undercut if curvature.base_radius else None,
            "least_base_radius_m": curvature.least_base_radius,
        },
        "largest_roller_radius_m": curvature.roller and _extreme(curvature.roller),
        "rocker_ratio": ratio,
        "assumed": ASSUMED,
    }
    if measured:
        summary["jerk_infinite_deg"] = None
        summary["jerk_unknown"] = JERK_OF_A_FIT
        summary["jerk_error_m_per_rad3"] = max(cam.errors.jerk.bounds)
    else:  # at a corner c_thetatheta jumps, or c_theta
        summary["jerk_infinite_deg"] = [degrees(theta) for theta in profile.corners.values()]
        summary["jerk_unknown"] = None
        summary["jerk_error_m_per_rad3"] = None
    if profile.lobe is not None:
        summary["lobe"] = _lobe_summary(profile.lobe)
    return summary


def _lobe_summary(lobe: Lobe) -> dict[str, Any]:
    """What run.json says of the lobe; lengths in m, angles in deg; null: none, or no limit."""
    least, largest = lobe.beside
    if lobe.face == "flat":
        beside = {
            "least_eccentricity_m": _at_phase(least),
            "largest_eccentricity_m": _at_phase(largest),
        }
    else:
        beside = {
            "least_pressure_angle_deg": _at_phase(least, is_angle=True),
            "largest_pressure_angle_deg": _at_phase(largest, is_angle=True),
        }
    return {
        "face": lobe.face,
        "base_radius_m": lobe.base,
        "roller_radius_m": lobe.roller if lobe.face == "roller" else None,
        "least_radius_m": _at_phase(lobe.least),
        "undercut": lobe.undercut,
        "sharpest_hollow_m": _at_phase(lobe.hollow),
        "largest_roller_m": _at_phase(lobe.largest_roller),
        "least_base_radius_m": lobe.least_base,
        **beside,
        "closing_m": lobe.closing,
    }


def _at_phase(found: Found | None, is_angle: bool = False) -> dict[str, float | None] | None:
    """An entry of run.json: a value (m), and the angle of the cam at which it is taken (deg).

    is_angle: the value is in rad, and given in deg. A radius that is infinite, of a lobe that is
    nowhere convex, is null.
    """
    if found is None:
        return None
    value = degrees(found.value) if is_angle else found.value
    return {"value": value if isfinite(value) else None, "theta_deg": degrees(found.theta)}


# --- the command


SAMPLED_ROWS = 9000  # of a trajectory in a sample, for each of its pieces
BYTES_A_POINT = 1000.0  # of memory, for a point on a drawn curve
# points on a drawn curve (plots/simulate.py): so many for each row, but no more than that in all
POINTS_A_ROW = 8
MOST_POINTS = 400_000
FILM = 1.2e6  # bytes of the animations, about


def _size(scene: Scene) -> Size:
    """A motion has samples in every recorded turn; a profile in one turn of each cam.

    Bytes are measured.
    """
    samples = scene.simulate.samples
    run = scene.run
    if scene.simulate.profile_only:
        cams = 1 + len(scene.simulate.beside)
        rows = samples * cams
        return Size(
            what=plural(rows, "sample"),
            pieces=1,
            orbits=0,
            turns=0.0,
            rows=rows,
            memory=350.0 * rows,
            tables=80.0 * rows,
            kept=0.0,
        )
    rows = samples * run.record
    return Size(
        what=plan.turns_of_a_motion(run.record, samples),
        pieces=run.record,
        orbits=1,
        turns=run.transient + run.record,
        rows=0,
        memory=240.0 * rows,
        tables=100.0 * rows,
        kept=0.0,
    )


def _drawing(scene: Scene) -> Drawing:
    """A picture of a motion takes memory for the points of its curves beside that of its pixels."""
    points = 0
    if not scene.simulate.profile_only:
        rows = scene.simulate.samples * min(scene.simulate.plot_turns, scene.run.record)
        points = min(POINTS_A_ROW * rows, max(2 * rows, MOST_POINTS))
    return Drawing(file=290e3, memory=70e6 + BYTES_A_POINT * points, per_pixel=5.0)


def _sample(scene: Scene, n: int) -> Scene:
    """The scene with n times as many turns as fill SAMPLED_ROWS rows."""
    turns = max(1, SAMPLED_ROWS * n // scene.simulate.samples)
    return sample(scene, None, record=turns)


COMMAND = Command(
    run=simulate,
    tables=(TRAJECTORY, EVENTS, PROFILE, OUTLINE),
    files=(
        "profile_2.csv", "profile_3.csv", "simulate.png", "profile.png", "simulate.gif",
        "simulate.mp4",
    ),
    size=_size,
    drawing=_drawing,
    beside=lambda scene: FILM if scene.simulate.animate else 0.0,
    sample=_sample,
    not_foreseen=plan.simulate,
)  # fmt: skip
