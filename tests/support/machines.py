"""Machines whose cams are written here once more, in closed form, with NumPy alone.

`CHAPTER` is the default scene: lengths of some 0.1 m, a follower without damping, gravity or
preload, strobed at 0 deg. `VALVE` leaves every default: lengths of mm, a cam below zero, damping,
gravity, a preload, and a strobe on the slope of the rise. `TABLE` has a measured cam of which the
law is known, `ECCENTRIC` a flat face and no corner.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import camcli


@dataclass(frozen=True)
class Shape:
    """A cam of parts that a test makes: what `System.build` asks of one of a scene."""

    parts: Callable[[], list]


class ArcsCam:
    """Circles tangent to each other: base, flank, nose and top dwell, less the offset."""

    def __init__(self):
        """The corners of the example's cam, deg."""
        self.corners = {
            "a": 90.0, "b": 150.1793714951576, "c": 160.0, "d": 200.0, "e": 209.8206285048424,
            "f": 270.0,
        }  # fmt: skip

    def lift(self, theta_deg):
        """c (m), c_theta and c_thetatheta; at a corner those on its right."""
        turn = np.asarray(theta_deg, dtype=float) % 360.0
        falling = turn >= 180.0  # the lobe is its own mirror image
        mirrored = np.where(falling, 360.0 - turn, turn)
        none = np.zeros(turn.shape)
        found = np.array([none + 0.1, none, none])
        parts = (
            _circle(-0.45, 0.85, np.radians(mirrored - 90.0)),
            _circle(0.40393320723821, 0.15, np.radians(mirrored - 160.0)),
            (none + 0.25393320723821, none, none),
        )
        for name, part in zip("abc", parts, strict=True):
            begin = self.corners[name]
            inside = np.where(falling, mirrored > begin, mirrored >= begin)
            found = np.where(inside, part, found)
        return found[0], np.where(falling, -found[1], found[1]), found[2]


def _circle(centre, radius, x):
    """The radius K cos x + sqrt(rho^2 - K^2 sin^2 x) less the offset, and its derivatives."""
    root = np.sqrt(np.maximum(radius**2 - (centre * np.sin(x)) ** 2, 1e-9))  # elsewhere unused
    product = centre**2 * np.sin(x) * np.cos(x)
    bend = centre**2 * np.cos(2.0 * x) / root + product**2 / root**3
    return np.array(
        [
            centre * np.cos(x) + root - 0.3,
            -centre * np.sin(x) - product / root,
            -centre * np.cos(x) - bend,
        ]
    )


class HarmonicCam:
    """Rise from 100 to 170 deg, dwell, fall from 190 to 250 deg: 10 mm above a base of -2 mm."""

    def __init__(self):
        self.corners = {"a": 100.0, "b": 170.0, "c": 190.0, "d": 250.0}
        self.base, self.height = -0.002, 0.010

    def lift(self, theta_deg):
        """c (m), c_theta and c_thetatheta; at a corner those on its right."""
        turn = np.asarray(theta_deg, dtype=float) % 360.0
        rise, fall = (turn - 100.0) / 70.0, (250.0 - turn) / 60.0
        up, down = (turn >= 100.0) & (turn < 170.0), (turn >= 190.0) & (turn < 250.0)
        share = np.where(up, rise, np.where(down, fall, 0.0))
        speed = np.where(up, 180.0 / 70.0, np.where(down, -180.0 / 60.0, 0.0))  # of the phase
        c = 0.5 * self.height * (1.0 - np.cos(np.pi * share))
        c = np.where((turn >= 170.0) & (turn < 190.0), self.height, c) + self.base
        c1 = 0.5 * self.height * speed * np.sin(np.pi * share)
        return c, c1, 0.5 * self.height * speed**2 * np.cos(np.pi * share)


def off_corners(cam, theta):
    """Where phases (deg) are not at a corner, which has a value on either side."""
    away = [np.abs(np.asarray(theta) - corner) for corner in cam.corners.values()]
    return np.min([np.full(np.shape(theta), 360.0), *away], axis=0) > 1e-6


class MeasuredCam:
    """The law behind configs/valve-lift.csv: 0.4 inch, 1 + sum C_k x^k over 68 deg of the cam.

    C_k = -prod j/(j - k) over the other exponents; the file rounds it to 0.0001 inch.
    """

    def __init__(self, base=0.0):
        self.corners, self.base = {}, base
        self.exponents = (2, 6, 8, 10, 12)

    def lift(self, theta_deg):
        """c (m), c_theta and c_thetatheta."""
        x = (np.asarray(theta_deg, dtype=float) % 360.0 - 180.0) / 68.0  # from the nose
        inside, step = np.abs(x) < 1.0, np.degrees(1.0) / 68.0
        orders = [np.ones(x.shape), np.zeros(x.shape), np.zeros(x.shape)]
        for k in self.exponents:
            factor = -np.prod([j / (j - k) for j in self.exponents if j != k])
            orders[0] = orders[0] + factor * x**k
            orders[1] = orders[1] + factor * k * x ** (k - 1) * step
            orders[2] = orders[2] + factor * k * (k - 1) * x ** (k - 2) * step**2
        c, c1, c2 = (np.where(inside, 0.4 * 0.0254 * values, 0.0) for values in orders)
        return self.base + c, c1, c2


class EccentricCam:
    """base + lift (1 - cos theta)/2."""

    def __init__(self):
        self.corners = {}
        self.base, self.height = 0.01, 0.02

    def lift(self, theta_deg):
        """c (m), c_theta and c_thetatheta."""
        theta, half = np.radians(np.asarray(theta_deg, dtype=float)), 0.5 * self.height
        return self.base + half * (1.0 - np.cos(theta)), half * np.sin(theta), half * np.cos(theta)


@dataclass(frozen=True)
class Machine:
    """A scene, what it is in numbers, and in which unit its lengths are shown."""

    scene: dict | Path | None
    cam: ArcsCam | HarmonicCam | MeasuredCam | EccentricCam
    mass: float
    stiffness: float
    damping: float
    gravity: float
    preload: float
    restitution: float
    strobe_deg: float
    unit: str
    per_m: float
    spring_unit: str
    base_radius: float | None

    def load(self, values=()):
        """The scene with some values, by their paths."""
        return camcli.load_scene(self.scene, dict(values))

    def force(self, rpm, theta_deg, stiffness=None, preload=None):
        """The contact force of a follower kept on the cam, N."""
        c, c1, c2 = self.cam.lift(theta_deg)
        omega = rpm * np.pi / 30.0
        k = self.stiffness if stiffness is None else stiffness
        f0 = self.preload if preload is None else preload
        still = self.mass * self.gravity + f0 + k * c
        return still + self.damping * omega * c1 + self.mass * omega**2 * c2

    @property
    def turn(self):
        """Phases of a turn, deg, dense, and beside every corner."""
        beside = [at + side for at in self.cam.corners.values() for side in (-1e-9, 1e-9)]
        return np.sort([*np.linspace(0.0, 360.0, 36001), *beside])


CHAPTER = Machine(
    None, ArcsCam(), 1.221, 1430.8, 0.0, 0.0, 0.0, 0.8, 0.0, "m", 1.0, "N/m", 0.4,
)  # fmt: skip
_FOLLOWER = {
    "mass": 0.12, "stiffness": 40000.0, "damping": 20.0, "gravity": 9.81, "preload": 120.0,
    "restitution": 0.5,
}  # fmt: skip
VALVE = Machine(
    {
        "follower": _FOLLOWER,
        "cam": {
            "kind": "law", "base": -0.002, "lift": 0.010, "top_dwell_deg": 20,
            "rise": {"start_deg": 100, "length_deg": 70, "law": "harmonic"},
            "fall": {"length_deg": 60, "law": "harmonic"},
        },
        "run": {"rpm": 3300, "transient": 60, "record": 20, "strobe_deg": 130},
    },
    HarmonicCam(), **_FOLLOWER, strobe_deg=130.0, unit="mm", per_m=1000.0, spring_unit="N/mm",
    base_radius=None,
)  # fmt: skip
TABLE = Machine(
    Path(__file__).parents[2] / "configs" / "lift-table.yaml",
    MeasuredCam(), 0.12, 42000.0, 12.0, 0.0, 260.0, 0.4, 0.0, "mm", 1000.0, "N/mm", 0.036,
)  # fmt: skip
ECCENTRIC = Machine(
    {"follower": _FOLLOWER, "cam": {"kind": "eccentric", "base": 0.01, "lift": 0.02},
     "run": {"rpm": 300}},
    EccentricCam(), **_FOLLOWER, strobe_deg=0.0, unit="mm", per_m=1000.0, spring_unit="N/mm",
    base_radius=None,
)  # fmt: skip
