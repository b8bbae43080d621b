"""camcli.simulate: one orbit in time, or only the cam it moves on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import degrees, isfinite, pi
from typing import TYPE_CHECKING, Any, BinaryIO

from camcli.analysis.cam_profile import Extreme
from camcli.analysis.integrate import Cost
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, sample
from camcli.api.lift_table import lost_between
from camcli.api.machine import Machine, machine_of, with_arguments
from camcli.api.result import Progress, Result, drawn_by
from camcli.errors import Fault, SceneError, Status
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
    outline = Outline.of(machine.system, getattr(cam, "base_radius", None), cam)
    write_animation(draw_frames(found, machine.system, outline, turns), file, kind)


def _profile(machine: Machine) -> Result:
    """The cam of a scene over one turn, and what a flat face or a roller needs of it."""
    from camcli.analysis.cam_profile import profile

    scene = machine.scene
    others = [scene.model_copy(update={"cam": cam}) for cam in scene.simulate.beside]
    machines = [machine, *map(machine_of, others)]
    bases = [getattr(one.scene.cam, "base_radius", None) for one in machines]
    bases[0] = scene.simulate.base_radius or bases[0]
    alike = next(filter(None, bases), None)  # cams side by side, where one does not say
    bases = [base or alike for base in bases]
    runner = _runner(scene, bases[0])
    rpm = scene.run.rpm
    samples = scene.simulate.samples
    with stopwatch() as watch:
        results = [
            _with_range(
                profile(one.system, rpm, samples, base, runner if one is machine else None),
                one.system,
            )
            for one, base in zip(machines, bases, strict=True)
        ]
    result = results[0]
    tables = {
        "profile" if k == 1 else f"profile_{k}": Table.of_rows(
            _profile_names(one), partial(_profile_rows, one, machines[k - 1].system, rpm)
        )
        for k, one in enumerate(results, 1)
    }
    lobe = result.lobe
    if lobe is not None:
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
        pictures={"profile": partial(_draw_profiles, machines, results, bases)},
        cost=Cost(),
        seconds=watch.seconds,
        notes=tuple(
            undercut_notes(result, machine.system)
            if lobe is None
            else lobe_notes(lobe, units_of(machine.system))
        ),
    )


def _runner(scene: Scene, base: float | None) -> Runner | None:
    """What runs on the lobe; None where the scene does not say.

    base: radius of the base circle, m, of the cam or of --base-radius; without it that of the
    section contact. Raises SceneError where none of them has one.
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


def _profile_rows(one: Profile, system: System, rpm: float) -> Iterator[tuple]:
    """The rows of profile.csv of a cam, with the force (N) of a follower that stays on it.

    On a cam with lash the follower stays on the cam less the lash, or on its seat above that.
    """
    f = system.follower
    omega = omega_of(rpm)
    lowest = one.ranges["c"][0].value
    lash = system.lash
    seat = system.lift_range[0]
    for k, (theta, c, c1, c2) in enumerate(zip(one.theta, one.c, one.c1, one.c2, strict=True)):
        q, q1, q2 = c, c1, c2
        if lash:
            q = c - lash
            if q < seat:
                q, q1, q2 = seat, 0.0, 0.0
        at_standstill = f.mass * f.gravity + f.preload + f.stiffness * q
        yield (
            degrees(theta),
            c,
            c1,
            c2,
            at_standstill + omega * (f.damping * q1 + f.mass * (omega * q2)),
            one.c3[k],
            *_per_degree(c - lowest, c1, c2, one.c3[k]),
            *(_of_lobe(one.lobe.face, one.lobe.touches[k]) if one.lobe else ()),
        )


def _profile_names(one: Profile) -> list[str]:
    """The columns of profile.csv."""
    if one.lobe is None:
        return list(PROFILE.names())
    beside = ECCENTRICITY if one.lobe.face == "flat" else PRESSURE_ANGLE
    return [*PROFILE.names(), "lobe_radius_m", beside.column]


def _per_degree(lift: float, c1: float, c2: float, c3: float) -> Iterator[float]:
    """Lift (m) and its derivatives by rad, in mm and degrees."""
    for order, value in enumerate((lift, c1, c2, c3)):
        yield MM * value * RAD_PER_DEG**order


def _of_lobe(face: str, touch: Touch) -> tuple[float, float]:
    """Radius of curvature (m), and pressure angle (deg) or eccentricity (m)."""
    return touch.radius, touch.beside if face == "flat" else degrees(touch.angle)


def _draw_profiles(
    machines: Sequence[Machine], results: Sequence[Profile], bases: Sequence[float | None]
) -> Picture:
    """The cams side by side; bases: radii of their base circles, m."""
    from camcli.plots.cam_profile import CamDrawing, draw_profiles
    from camcli.plots.mechanism import Outline

    units = units_of(machines[0].system)
    drawn = []
    for machine, found, base in zip(machines, results, bases, strict=True):
        cam = machine.scene.cam
        lobe = found.lobe
        outline = Outline.of(
            machine.system.as_drawn, base if lobe is None else lobe.base, cam, lobe
        )
        drawn.append(CamDrawing(found, outline, cam, units))
    return draw_profiles(drawn)


def _with_range(found: Profile, system: System) -> Profile:
    """The profile with the bracket of its first detachment.

    Of a measured cam that is what the error of its table leaves; else it stays.
    """
    between = lost_between(system)
    if between is None or found.first is None:
        return found
    return replace(found, first=replace(found.first, low=between[0], high=between[1]))


def _extreme(extreme: Extreme) -> dict[str, float]:
    """An entry of run.json: the value, and the angle at which it occurs (deg)."""
    return {"value": extreme.value, "theta_deg": degrees(extreme.theta)}


def _profile_summary(result: Profile, ratio: float, cam: Any) -> dict[str, Any]:
    """What run.json says of a cam: extremes, least force, first detachment, curvature.

    ratio: of the rocker, 1 without one; cam: the scene's.
    """
    measured = cam.kind == "table"
    bent = result.curvature
    first = result.first
    lobe = {} if result.lobe is None else {"lobe": _lobe_summary(result.lobe)}
    infinite = result.corners.values()  # there c_thetatheta jumps, or c_theta
    return {
        "rpm": result.force.rpm,
        "corners_deg": {name: degrees(theta) for name, theta in result.corners.items()},
        "ranges": {
            f"{name} ({LIFT_RANGES[name].unit})": [_extreme(low), _extreme(high)]
            for name, (low, high) in result.ranges.items()
        },
        "least_force_n": {
            "value": result.force.lowest_n,
            "theta_deg": degrees(result.force.lowest_theta),
        },
        "first_detachment_rpm": first.rpm if first is not None and first.finite else None,
        "first_detachment_between_rpm": None if first is None else [first.low, first.high],
        "base_radius_m": bent.base_radius,
        "flat_faced": {
            "least_radius_m": _extreme(bent.flat_least) if bent.base_radius else None,
            "undercut": bent.undercut if bent.base_radius else None,
            "least_base_radius_m": bent.least_base_radius,
        },
        "largest_roller_radius_m": bent.roller and _extreme(bent.roller),
        "rocker_ratio": ratio,
        "assumed": ASSUMED,
        "jerk_infinite_deg": None if measured else [*map(degrees, infinite)],
        "jerk_unknown": JERK_OF_A_FIT if measured else None,
        "jerk_error_m_per_rad3": max(cam.errors.jerk.bounds) if measured else None,
        **lobe,
    }


def _lobe_summary(lobe: Lobe) -> dict[str, Any]:
    """What run.json says of the lobe; lengths in m, angles in deg; null: none, or no limit."""
    flat = lobe.face == "flat"
    names = ("least", "largest")
    beside = {
        f"{name}_{'eccentricity_m' if flat else 'pressure_angle_deg'}": _found(one, not flat)
        for name, one in zip(names, lobe.beside, strict=True)
    }
    return {
        "face": lobe.face,
        "base_radius_m": lobe.base,
        "roller_radius_m": lobe.roller if lobe.face == "roller" else None,
        "least_radius_m": _found(lobe.least),
        "undercut": lobe.undercut,
        "sharpest_hollow_m": _found(lobe.hollow),
        "largest_roller_m": _found(lobe.largest_roller),
        "least_base_radius_m": lobe.least_base,
        **beside,
        "closing_m": lobe.closing,
    }


def _found(found: Found | None, angle: bool = False) -> dict[str, float | None] | None:
    """An entry of run.json: the value, and the angle of the cam (deg); angle: the value is in rad.

    A radius that is infinite, of a lobe that is nowhere convex, is null.
    """
    if found is None:
        return None
    value = degrees(found.value) if angle else found.value
    return {"value": value if isfinite(value) else None, "theta_deg": degrees(found.theta)}


# --- the command


SAMPLED_ROWS = 9000  # of a trajectory in a sample, for each of its pieces
PER_POINT = 1000.0  # bytes of memory of a point on a drawn curve,
FINER, MOST_POINTS = 8, 400_000  # which has so many a row, but no more in all (plots/simulate.py)


FILM = 1.2e6  # bytes of the animations, about


def _size(scene: Scene) -> Size:
    """A motion has samples in every recorded turn; a profile in one turn of each cam.

    Bytes are measured.
    """
    samples = scene.simulate.samples
    run = scene.run
    if scene.simulate.profile_only:
        n = samples * (1 + len(scene.simulate.beside))
        return Size(
            what=f"{n} samples",
            pieces=1,
            orbits=0,
            turns=0.0,
            rows=n,
            memory=350.0 * n,
            tables=80.0 * n,
            kept=0.0,
        )
    rows = samples * run.record
    turns = run.transient + run.record
    what = plan.turns_of_a_motion(run.record, samples)
    return Size(
        what=what,
        pieces=run.record,
        orbits=1,
        turns=turns,
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
        points = min(FINER * rows, max(2 * rows, MOST_POINTS))
    return Drawing(file=290e3, memory=70e6 + PER_POINT * points, per_pixel=5.0)


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
