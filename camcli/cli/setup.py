"""From a request to a validated scene, and from the scene to the plain values of the analyses."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

from camcli.analysis.integrate import Settings, Start
from camcli.cli.exit_codes import note
from camcli.cli.lift_words import cautions, fit_line
from camcli.cli.options import Request
from camcli.errors import Fault, SceneError, shown
from camcli.kernel.backend import Stopwatch, stopwatch
from camcli.scene import Scene, load_scene, parse_rpm
from camcli.system import Follower, System


@dataclass(frozen=True)
class Setup:
    """A validated scene with what the kernel needs of it."""

    scene: Scene
    system: System
    settings: Settings


def timed(request: Request) -> AbstractContextManager[Stopwatch]:
    """Time a run without compiling, which is said on stderr."""
    text = "compiling the kernel for this machine: some 20 to 60 s, once ..."
    return stopwatch(None if request.quiet else lambda: note(text))


def one_speed(request: Request) -> dict[str, tuple[Any, str]]:
    """Scene values of --rpm and --points where a command takes one speed."""
    values: dict[str, tuple[Any, str]] = {}
    if request.rpm is not None:
        rpm = parse_rpm(request.rpm)
        if isinstance(rpm, tuple):
            found = f"found the range '{request.rpm}'"
            raise SceneError(Fault("--rpm", "", found, "expected one speed", "use cam sweep"))
        values["run.rpm"] = (rpm, "--rpm")
    if request.points is not None:
        values["simulate.samples"] = (request.points, "--points")
    return values


def speed_range(request: Request, section: str) -> dict[str, tuple[Any, str]]:
    """Scene values of --rpm and --points where a command takes a range."""
    values: dict[str, tuple[Any, str]] = {}
    if request.rpm is not None:
        rpm = parse_rpm(request.rpm)
        low, high = rpm if isinstance(rpm, tuple) else (rpm, rpm)
        values[f"{section}.rpm.start"] = (low, "--rpm")
        values[f"{section}.rpm.stop"] = (high, "--rpm")
        if low == high:
            values[f"{section}.rpm.num"] = (1, "--rpm")
    if request.points is not None:
        values[f"{section}.rpm.num"] = (request.points, "--points")
    return values


def set_up(request: Request, options: dict[str, tuple[Any, str]]) -> Setup:
    """Load and validate the scene and compile its cam; raises SceneError with every fault."""
    if request.scene is not None:
        scene = load_scene(request.scene, folder=request.home)
    else:
        scene = load_scene(request.config, request.sets, options)
    follower = Follower(**scene.follower.model_dump())
    system = System.build(follower, scene.cam.parts(), scene.run.strobe_deg, scene.cam)
    run = scene.run
    settings = Settings(
        transient=run.transient,
        record=run.record,
        chatter_tolerance=run.chatter_tolerance,
        impact_budget=run.impact_budget,
        start=Start(run.start.q, run.start.v, run.start.theta_deg),
    )
    if not request.quiet:
        _notes(follower, scene)
    return Setup(scene, system, settings)


def _notes(follower: Follower, scene: Scene) -> None:
    if scene.cam.kind == "table":
        if scene.cam.outside:
            note(
                f"note: cam.file: reads {shown(scene.cam.outside, 500)}, outside the scene's folder"
            )
        note(fit_line(scene.cam.accuracy, shown(scene.cam.file, 500)))
        for text in cautions(scene.cam.accuracy):
            note(text)
    if follower.restitution == 1.0 and follower.damping == 0.0:
        note("warning: restitution 1 and no damping: nothing dissipates, no orbit attracts another")
