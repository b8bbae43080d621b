"""The numbers of a scene that an analysis varies, and the machine at each of their values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import rpm_grid
from camcli.api.result import Machine, machine_of
from camcli.errors import Fault, SceneError
from camcli.scene import Axis, Scene, Varying, load_scene, resolved
from camcli.system import System

MOST_COMPILED = 256  # cams kept


def span_of(machine: Machine, section: Varying) -> tuple[str, list[float], Varied | None]:
    """(key, values, setup) of what a section goes over; setup is None where it is the speed."""
    axis = section.axis
    values = rpm_grid(axis.start, axis.stop, section.count)
    return section.key, values, Varied(machine, section.vary) if section.vary else None


def refuse_to_explain(section: Varying, name: str) -> None:
    """Raise SceneError where a section has no changes over the speed to explain."""
    if section.vary:
        found, cure = f"found {section.key}", "leave --explain out, or vary the speed (--rpm LO:HI)"
        fault = f"{name}.vary", found, "expected none", cure
    elif section.rpm.num < 2:
        found, cure = f"found one speed, {section.rpm.start!r}", "give --rpm LO:HI and --points"
        fault = f"{name}.rpm", found, "expected a range", cure
    else:
        return
    raise SceneError(Fault("--explain", *fault))


@dataclass
class Varied:
    """The machine of a scene at values of some of its numbers.

    Raises SceneError with every fault where an axis names no number of the scene, or one of its
    ends is none that the scene allows.
    """

    machine: Machine
    axes: Sequence[Axis]
    option: str = "--vary"
    compiled: dict[tuple, Machine] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        for axis in self.axes:
            for value in (axis.start, axis.stop):
                self._loaded({axis.path: value})

    def __call__(self, *values: float) -> tuple[System, float, Settings]:
        """(system, rpm, settings) at a value of each axis."""
        changes = dict(zip((axis.path for axis in self.axes), values, strict=True))
        rpm = changes.pop("run.rpm", None)
        quick = {k: changes.pop(k) for k in list(changes) if k.startswith("follower.")}
        key = tuple(changes.items())
        machine = self.compiled.get(key)
        if machine is None:
            machine = machine_of(self._loaded(changes)) if changes else self.machine
            if len(self.compiled) >= MOST_COMPILED:
                self.compiled.clear()
            self.compiled[key] = machine
        system, speed = machine.system, machine.scene.run.rpm if rpm is None else rpm
        if quick:
            named = {path.partition(".")[2]: value for path, value in quick.items()}
            system = system.with_follower(**named)
        return system, speed, machine.settings

    def _loaded(self, changes: dict[str, Any]) -> Scene:
        scene = self.machine.scene
        named = {path: (value, self.option) for path, value in changes.items()}
        if getattr(scene.cam, "outside", ""):
            named["cam.allow_outside"] = (True, self.option)
        return load_scene(resolved(scene), (), named, folder=getattr(scene.cam, "folder", ""))
