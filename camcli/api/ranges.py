"""Speeds and windows that a scene leaves open, from its machine."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

from camcli.analysis.contact_loss.detachment import detachment
from camcli.scene import Scene
from camcli.system import System, omega_of

RANGES = {  # of the first loss of contact; of the natural frequency where contact is never lost
    "sweep": (0.9, 1.5, 0.5, 2.0),
    "detach": (0.9, 1.3, 0.5, 2.0),
    "orbits": (1.0, 1.4, 0.5, 2.0),
    "classify": (1.0, 1.4, 0.5, 2.0),
}
PAST = 1.05  # one speed, of the first loss of contact
HIGH, FAST = 2.0, 4.0  # of the lift above it, and of lift times omega: windows of starts


def is_open(scene: Scene, section: str) -> bool:
    """Whether the scene leaves the speeds of a section open."""
    ranges = getattr(getattr(scene, section, None), "rpm", None)
    return ranges is not None and ranges.model_fields_set.isdisjoint({"start", "stop"})


def ranged(scene: Scene, system: System) -> tuple[Scene, dict[str, str]]:
    """The scene with the speeds filled in that it leaves open, and why, by section.

    They are those of its machine: about the first loss of contact, or the natural frequency where
    contact is never or always lost. What the scene gives stays.
    """
    sections = [name for name in (*RANGES, "basins") if is_open(scene, name)]
    speed, lost, why = _natural(system) if sections else (0.0, False, "")
    if speed == 0.0:
        return scene, {}
    said, update = {}, {}
    for name in sections:
        section = getattr(scene, name)
        if name == "basins":
            given = "rpm" in scene.run.model_fields_set or section.vary
            low = high = scene.run.rpm if given else _round(PAST * speed)
            why = "that of run.rpm" if given else why
            window = _window(system, low)
        else:
            shares, window = RANGES[name][0 if lost else 2 :], {}
            low, high = (_round(share * speed) for share in shares[:2])
        window["rpm"] = section.rpm.model_copy(update={"start": low, "stop": high})
        left = {k: v for k, v in window.items() if k == "rpm" or k not in section.model_fields_set}
        update[name] = section.model_copy(update=left)
        speeds = f"{low:g} rpm" if low == high else f"{low:g} to {high:g} rpm"
        if not getattr(section, "vary", ()):
            said[name] = f"{name}.rpm is not given: {speeds} of the cam, {why}"
    return scene.model_copy(update=update), said


def _natural(system: System) -> tuple[float, bool, str]:
    """(speed in rpm, whether contact is lost there first, why)."""
    first, f = detachment(system).first, system.follower
    if first is not None:
        return first.rpm, True, f"from the first loss of contact at {first.rpm:.5g} rpm"
    if f.stiffness > 0.0:
        speed = sqrt(f.stiffness / f.mass) * 30.0 / pi
        return speed, False, f"from the natural frequency, {speed:.5g} per minute"
    pull = max(0.0, f.gravity + f.preload / f.mass)
    speed = sqrt(pull / _lift(system)[1]) * 30.0 / pi
    return speed, False, "where the cam accelerates as the follower falls"


def _lift(system: System) -> tuple[float, float]:
    """(lowest c, highest minus lowest), m."""
    low = min(stretch.c_min for stretch in system.cam.stretches)
    return low, (system.cam.top - low) or 1.0


def _window(system: System, rpm: float) -> dict[str, Any]:
    """Starts that the motion can reach at a speed."""
    low, lift = _lift(system)
    fast = _round(FAST * lift * omega_of(rpm))
    return {"q": (_round(low), _round(low + (1.0 + HIGH) * lift)), "v": (-fast, fast)}


def _round(value: float) -> float:
    return float(f"{value:.3g}")
