"""The family of machines over the numbers of a scene that a branch or a curve follows in the cam.

A branch follows any number of the machine that a motion depends on: the speed, the constants of the
follower and, through a `system.Family`, every number of the cam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from camcli.api.machine import Machine, Varied, closed
from camcli.cams import AnyCam
from camcli.cams.compile import phase_of
from camcli.cams.lift_table import TableCam
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import Fault, NoMachineError, SceneError
from camcli.scene import MORE_THAN_THE_LIFT, Axis, Scene, resolved
from camcli.system import Family, System, rpm_of
from camcli.words.followed import NO_SEAT, cure_of, why_not_followed


def check_followed(scene: Scene, axis: Axis) -> None:
    """Raise SceneError where a key of the cam or the run names no number that can be followed."""
    value = _value(scene, axis.path)
    reason = why_not(scene, axis)
    if reason:
        raise _refusal(
            f"found {axis.key}", f"expected a number to follow: {reason}", cure_of(reason)
        )
    if not isinstance(value, float | int):
        return  # an unknown key: the scene says so where the range is checked
    low, high = sorted((axis.start, axis.stop))
    found = f"found {low!r} to {high!r}"
    if low == high:
        raise _refusal(found, "expected two different ends", "give a range LO:HI")
    if not low <= value <= high:
        expected = f"expected a range that holds {axis.key} = {value!r} of the scene"
        raise _refusal(found, expected, "choose another range")


def why_not(scene: Scene, axis: Axis) -> str:
    """Why a number of the cam or the run cannot be followed; empty where it can."""
    known = axis.path.removeprefix("cam.") in type(scene.cam).model_fields
    return why_not_followed(axis.path, scene.cam.kind, _value(scene, axis.path), known)


def why_no_constant(scene: Scene, name: str) -> str:
    """Why a constant of the follower cannot be followed; empty where it can."""
    if name == "seat_restitution" and getattr(scene.cam, "lash", None) is None:
        return NO_SEAT
    value = getattr(scene.follower, name)
    return why_not_followed(f"follower.{name}", scene.cam.kind, value, known=True)


def check_ends(machine: Machine, axis: Axis) -> None:
    """Raise SceneError where an end of the range is beyond the limits of its own key.

    An end at which the numbers make no cam together is no fault, nor one at which the lash is more
    than the lift: the branch then ends before it comes there.
    """
    machines = Varied(machine, [axis], "orbits.vary", whole=False)
    for end in (axis.start, axis.stop):
        try:
            machines.loaded({axis.path: end})
        except SceneError as error:
            of_this_key = [
                fault
                for fault in error.faults
                if fault.path == axis.path and fault.expected != MORE_THAN_THE_LIFT
            ]
            if of_this_key:
                raise SceneError(*of_this_key) from None


def in_family(machine: Machine, axes: Sequence[Axis]) -> System:
    """The machine as a member of the family over these numbers of its cam; itself without any."""
    if not axes:
        return machine.system
    machines = Varied(machine, list(axes), whole=False)
    strobe = phase_of(machine.scene.run.strobe_deg)

    def build(values: tuple[float, ...]) -> tuple[System, float]:
        """The machine and its speed at values of the numbers.

        Where the cam alone tells that there is one, the scene is not read again.
        """
        paths = [axis.path for axis in axes]
        cam = _changed(machine.scene.cam, dict(zip(paths, values, strict=True)))
        if cam is not None:
            return _on(machine, cam, strobe)
        try:
            system, rpm, _ = machines(*values)
        except SceneError as error:
            raise NoMachineError(_reason(error)) from None
        return system, rpm

    names = tuple(axis.key for axis in axes)
    ranges = tuple((min(axis.start, axis.stop), max(axis.start, axis.stop)) for axis in axes)
    values = tuple(float(_value(machine.scene, axis.path)) for axis in axes)
    return Family(names, ranges, values, build).home.system


def _changed(cam: AnyCam, changes: dict[str, float]) -> AnyCam | None:
    """The cam with some of its numbers changed, by path.

    None where the new numbers make no cam, and where the whole scene is needed to tell: a lift
    table is read from its file, and a lash has to be smaller than the lift.
    """
    if isinstance(cam, TableCam) or getattr(cam, "lash", None) is not None or "cam.lash" in changes:
        return None
    values = cam.model_dump()
    for path, value in closed(cam, changes).items():
        *sections, name = path.removeprefix("cam.").split(".")
        holder = values  # the section that has the number
        for section in sections:
            holder = holder[section]
        holder[name] = value
    try:
        return type(cam).model_validate(values)
    except ValidationError:
        return None


def _on(machine: Machine, cam: AnyCam, strobe: float) -> tuple[System, float]:
    """The follower of a machine on another cam, and its speed, rpm; an oscillator makes both."""
    follower = machine.system.follower
    rpm = machine.scene.run.rpm
    if isinstance(cam, OscillatorCam):
        follower = replace(
            follower, mass=cam.mass, stiffness=cam.stiffness, damping=cam.follower_damping
        )
        rpm = rpm_of(cam.frequency)
    return System.build(follower, cam, strobe), rpm


def _value(scene: Scene, path: str) -> Any:
    """What the scene has at a path; None where there is nothing."""
    value: Any = resolved(scene) if path.startswith("cam.") else {}
    for name in path.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _reason(error: SceneError) -> str:
    """The first fault of a scene as the reason why there is no machine."""
    fault = error.faults[0]
    return ", ".join(part for part in (fault.found, fault.expected) if part)


def _refusal(found: str, expected: str, cure: str) -> SceneError:
    """A fault of the key orbits.vary."""
    return SceneError(Fault("", "orbits.vary", found, expected, cure))
