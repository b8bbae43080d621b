"""camcli.simulate: one orbit in time, or only the cam it moves on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import degrees
from typing import TYPE_CHECKING, Any, BinaryIO

from camcli.analysis.cam_profile import Extreme
from camcli.analysis.integrate import Cost
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, sample
from camcli.api.lift_table import lost_between
from camcli.api.machine import Machine, machine_of, with_arguments
from camcli.api.result import Progress, Result, drawn_by
from camcli.errors import Status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.quantities import FORCE, LIFTS, THETA, TIME, TURN, U_MINUS, U_PLUS, Head, Q, Quantity, V
from camcli.scene import Scene
from camcli.system import System, omega_of, units_of
from camcli.words import plan
from camcli.words.machine import height_notes
from camcli.words.simulate import ASSUMED, end_notes, rounding_notes, undercut_notes
from camcli.words.statuses import trouble

if TYPE_CHECKING:
    from camcli.analysis.cam_profile import Profile
    from camcli.analysis.simulate import Simulation
    from camcli.plots.picture import Picture

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
PROFILE = Head(
    "profile",
    "with profile_only the only table: the cam over a turn, two rows at a corner, left side first; "
    "profile_2 and profile_3 of the cams in simulate.beside; under a rocker all of them are the "
    "valve's, and the curvature in the summary and the picture is the lobe's",
    (THETA, *LIFTS.values(), FORCE),
)


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
        Tables ``trajectory`` and ``events``, or with ``profile_only`` ``profile``; their columns
        are in the guide (`cam guide simulate`).

    Raises
    ------
    SceneError
        If the start lies below the cam.

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

    scene, system = machine.scene, machine.system
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

    cam, turns = machine.scene.cam, machine.scene.simulate.plot_turns
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
    rpm, samples = scene.run.rpm, scene.simulate.samples
    with stopwatch() as watch:
        results = [
            _with_range(profile(one.system, rpm, samples, base), one.system)
            for one, base in zip(machines, bases, strict=True)
        ]
    result = results[0]
    f = machine.system.follower
    omega = omega_of(rpm)

    def rows(one: Profile) -> Iterator[tuple]:
        """The rows of profile.csv of a cam, with the force of a follower that stays on it."""
        for theta, c, c1, c2 in zip(one.theta, one.c, one.c1, one.c2, strict=True):
            spring = f.mass * f.gravity + f.preload + f.stiffness * c
            yield (
                degrees(theta),
                c,
                c1,
                c2,
                spring + omega * (f.damping * c1 + f.mass * (omega * c2)),
            )

    return Result(
        command="simulate",
        scene=scene,
        system=machine.system,
        values=result,
        tables={
            "profile" if k == 1 else f"profile_{k}": Table.of_rows(
                PROFILE.names(), partial(rows, one)
            )
            for k, one in enumerate(results, 1)
        },
        summary=_profile_summary(result, machine.system.rocker_ratio),
        pictures={"profile": partial(_draw_profiles, machines, results, bases)},
        cost=Cost(),
        seconds=watch.seconds,
        notes=tuple(undercut_notes(result, machine.system)),
    )


def _draw_profiles(
    machines: Sequence[Machine], results: Sequence[Profile], bases: Sequence[float | None]
) -> Picture:
    """The cams side by side; bases: radii of their base circles, m."""
    from camcli.plots.cam_profile import CamDrawing, draw_profiles
    from camcli.plots.mechanism import Outline

    units, drawn = units_of(machines[0].system), []
    for machine, found, base in zip(machines, results, bases, strict=True):
        cam = machine.scene.cam
        drawn.append(CamDrawing(found, Outline.of(machine.system, base, cam), cam, units))
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


def _profile_summary(result: Profile, ratio: float) -> dict[str, Any]:
    """What run.json says of a cam: extremes, least force, first detachment, curvature.

    ratio: of the rocker, 1 without one.
    """
    bent, first = result.curvature, result.first
    return {
        "rpm": result.force.rpm,
        "corners_deg": {name: degrees(theta) for name, theta in result.corners.items()},
        "ranges": {
            f"{name} ({LIFTS[name].unit})": [_extreme(low), _extreme(high)]
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
    }


# --- the command


SAMPLED_ROWS = 9000  # of a trajectory in a sample, for each of its pieces
PER_POINT = 1000.0  # bytes of memory of a point on a drawn curve,
FINER, MOST_POINTS = 8, 400_000  # which has so many a row, but no more in all (plots/simulate.py)


FILM = 400e3  # bytes of the animations, about


def _size(scene: Scene) -> Size:
    """A motion has samples in every recorded turn; a profile in one turn of each cam.

    Bytes are measured.
    """
    samples, run = scene.simulate.samples, scene.run
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
    rows, turns = samples * run.record, run.transient + run.record
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
    """As many turns as fill SAMPLED_ROWS rows, n times."""
    turns = max(1, SAMPLED_ROWS * n // scene.simulate.samples)
    return sample(scene, None, record=turns)


COMMAND = Command(
    run=simulate,
    tables=(TRAJECTORY, EVENTS, PROFILE),
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
