"""Lift tables for the tests: known laws, rounded as real tables are, and scenes that read them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import cos, pi, sin
from pathlib import Path

from camcli.scene import load_scene

SCENE = """\
follower: {mass: 0.12, stiffness: 42000, preload: 260, restitution: 0.4}
cam:
  kind: table
  file: lift.csv
  header: true
  angle_column: deg
  lift_column: lift
  angle: cam
  lift: mm
  zero_deg: 0
  direction: same
  base: 0
"""


def polynomial(x: float) -> tuple[float, float]:
    """3-4-5 polynomial: lift and second derivative for x in [0, 1]."""
    return x**3 * (10 - 15 * x + 6 * x * x), 60 * x - 180 * x * x + 120 * x**3


def cycloidal(x: float) -> tuple[float, float]:
    return x - sin(2 * pi * x) / (2 * pi), 2 * pi * sin(2 * pi * x)


def smooth(x: float) -> tuple[float, float]:
    """4-5-6-7 polynomial: continuous third derivative at the ends."""
    lift = x**4 * (35 - 84 * x + 70 * x * x - 20 * x**3)
    return lift, 420 * x * x * (1 - 4 * x + 5 * x * x - 2 * x**3)


@dataclass(frozen=True)
class Lobe:
    """A rise and its mirror image about 180 deg, with a top dwell between."""

    law: Callable[[float], tuple[float, float]]
    flank: float = 70.0  # deg
    dwell: float = 0.0  # deg
    height: float = 0.010  # m

    def at(self, deg: float) -> tuple[float, float]:
        """(c, c_thetatheta) in m and rad."""
        beyond = abs(deg % 360.0 - 180.0) - self.dwell / 2
        if beyond <= 0.0 < self.dwell:
            return self.height, 0.0
        x = 1 - beyond / self.flank
        if x <= 0:
            return 0.0, 0.0
        lift, accel = self.law(x)
        scale = pi * self.flank / 180
        return self.height * lift, self.height * accel / (scale * scale)


@dataclass(frozen=True)
class Eccentric:
    """c = h (1 - cos theta)/2: no dwell at all."""

    height: float = 0.010

    def at(self, deg: float) -> tuple[float, float]:
        half = 0.5 * self.height
        return half * (1 - cos(deg * pi / 180)), half * cos(deg * pi / 180)


def table(lobe, step: float, unit: float = 1e-3, decimals: int = 4, low=0.0, high=360.0) -> str:
    """CSV text of a lobe, rounded to `decimals` of a unit."""
    count = round((high - low) / step)
    angles = [float(low + Fraction(str(step)) * k) for k in range(count)]
    lines = ["deg,lift"]
    lines += [f"{angle:g},{lobe.at(angle)[0] / unit:.{decimals}f}" for angle in angles]
    return "\n".join(lines) + "\n"


def scene(folder: Path, text: str | bytes, **changes):
    """The scene of a table text, with keys of the cam section changed."""
    (folder / "lift.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    path = folder / "scene.yaml"
    path.write_text(SCENE)
    return load_scene(path, [f"cam.{key}={value}" for key, value in changes.items()])


def worst_error(cam, compiled, lobe, places: int = 1441) -> tuple[float, float]:
    """(largest error of c_thetatheta, its largest size), m/rad2, off the compiled table."""
    from camcli.kernel.cam_table import lift_at, stretch_at

    error = size = 0.0
    for k in range(places):
        deg = 360.0 * k / places
        theta = deg * pi / 180
        found = lift_at(compiled, stretch_at(compiled, theta), theta)[2]
        true = lobe.at(deg)[1]
        error, size = max(error, abs(found - true)), max(size, abs(true))
    return error, size
