"""The curves of bifurcations over a map, as `cam sweep --curves auto` asks for them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits.atlas import (
    STAGES,
    STEPS_OF_A_CURVE,
    At,
    Atlas,
    add_curves,
    prove_atlas,
)
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.shooter import machine_at, table_of, with_machine
from camcli.api.family import in_family, why_not
from camcli.api.machine import Machine, Varied
from camcli.api.result import Progress, budget_of, ticks
from camcli.errors import Fault, SceneError, Status
from camcli.quantities import PARAMETERS
from camcli.scene import Axis, Scene
from camcli.system import System


def plane_of(scene: Scene, axes: Sequence[Axis]) -> Plane:
    """The plane of a map: its two numbers and their ranges.

    Raises SceneError for a number that no curve can follow.
    """
    names = []
    for axis in axes:
        name = "rpm" if axis.path == "run.rpm" else axis.path.removeprefix("follower.")
        reason = "" if name in PARAMETERS else why_not(scene, axis)
        if reason:
            expected = f"expected a number to follow: {reason}"
            cure = "leave --curves out, or give it a curve.csv"
            fault = Fault("--curves auto", "sweep.vary", f"found {axis.key}", expected, cure)
            raise SceneError(fault)
        if axis.start == axis.stop or axis.num < 2:
            found, expected = f"found one value of {axis.key}", "expected a range"
            raise SceneError(Fault("--curves auto", "sweep.vary", found, expected, "give LO:HI"))
        names.append(name)
    first, second = axes
    ranges = (
        (min(first.start, first.stop), max(first.start, first.stop)),
        (min(second.start, second.stop), max(second.start, second.stop)),
    )
    return Plane((names[0], names[1]), ranges, STEPS_OF_A_CURVE)


def atlas_of(
    machine: Machine, axes: Sequence[Axis], plane: Plane, progress: Progress | None
) -> tuple[Atlas, Status]:
    """The curves over a map, with sweep.prove their proofs, and whether the budget lasted."""
    atlas = Atlas(plane)
    machine_at_point = _machines(machine, axes, plane)
    section = machine.scene.sweep
    branches = machine.scene.orbits.branches
    on_stage = ticks(progress, "curves", STAGES)
    with budget_of(machine.scene, progress) as budget:
        with suppress(BudgetSpentError):  # the curves that were added until then stay
            add_curves(machine_at_point, machine.settings, atlas, branches, on_stage)
        if section.prove:
            on_curve = ticks(progress, "proofs", len(atlas.curves))
            prove_atlas(machine_at_point, atlas, section.prove_turns, on_curve)
    return atlas, budget.status


def _machines(machine: Machine, axes: Sequence[Axis], plane: Plane) -> At:
    """A function that gives the machine, and its speed (rpm), at a point of the map.

    Where numbers of the cam vary it gives a member of their family, or raises NoMachineError.
    """
    of_the_cam = [axis for axis in axes if axis.path.startswith("cam.")]
    setup = Varied(machine, axes)
    if not of_the_cam:

        def with_constants(first: float, second: float) -> tuple[System, float]:
            """The machine with other constants of the follower, and its speed."""
            system, rpm, _ = setup(first, second)
            return system, rpm

        return with_constants
    system = in_family(machine, of_the_cam)
    table_of_scene = table_of(system, machine.scene.run.rpm)

    def member(first: float, second: float) -> tuple[System, float]:
        """A member of the family, and its speed; raises NoMachineError where there is none."""
        table = table_of_scene
        for name, value in zip(plane.names, (first, second), strict=True):
            table = machine_at(system, table, name, value)
        return with_machine(system, table)

    return member
