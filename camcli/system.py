"""The machine: a follower and a compiled cam, frozen; from it the constants of one speed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import floor, isfinite, log10, pi, tau

from camcli.cams.compile import Shape, build, column, corners, lift_range
from camcli.cams.regions import regions
from camcli.errors import Fault, SceneError
from camcli.kernel.cam_table import Cam
from camcli.kernel.flow import AS_ON_THE_CAM, RAD_PER_S, Constants, constants_of
from camcli.kernel.forms import Kernel
from camcli.quantities import FOLLOWER, METRES, MILLIMETRES, Units

RPM = 30.0 / pi  # in a radian per second
SMALL_LIFT = 0.1  # m: lengths of a smaller cam are printed in mm


@dataclass(frozen=True)
class Follower:
    """Constants of the follower, in the units of `quantities.FOLLOWER`."""

    mass: float
    stiffness: float
    damping: float = 0.0
    gravity: float = 0.0
    preload: float = 0.0
    restitution: float = 0.8
    seat_restitution: float | None = None  # None: as on the cam


def omega_of(rpm: float) -> float:
    """rad/s from revolutions per minute; exact under scaling by powers of two."""
    return rpm * RAD_PER_S


def turns_per_second(rpm: float) -> float:
    """Revolutions per second from revolutions per minute."""
    return rpm / 60.0


def rpm_of(omega: float) -> float:
    """Revolutions per minute from rad/s."""
    return omega * RPM


@dataclass(frozen=True)
class System:
    """A follower on a cam, seen through a strobe phase (rad boundaries are in the table).

    `shape` gives the cam's functions, for who needs more digits than the table holds.
    """

    follower: Follower
    cam: Cam
    shape: Shape = field(compare=False, repr=False)

    @classmethod
    def build(cls, follower: Follower, shape: Shape, strobe: float = 0.0) -> System:
        """Compile the cam; the strobe phase (rad) becomes a boundary of the table."""
        return cls(follower, build(shape, strobe), shape)

    def with_follower(self, **changes: float) -> System:
        """The same cam under another follower."""
        other = System(replace(self.follower, **changes), self.cam, self.shape)
        other.__dict__["_cams"] = self._cams  # the tables are of the cam alone
        other.__dict__["lift_range"] = self.lift_range
        return other

    def __getstate__(self) -> dict:
        """Without the tables in a kernel's form, which `cam_for` makes again."""
        return {"follower": self.follower, "cam": self.cam, "shape": self.shape}

    def cam_for(self, kernel: Kernel) -> Cam:
        """The table as this kernel takes it; made once."""
        if kernel not in self._cams:
            self._cams[kernel] = kernel.cam(self.cam)
        return self._cams[kernel]

    @cached_property
    def _cams(self) -> dict[Kernel, Cam]:
        return {}

    @property
    def strobe(self) -> float:
        """Phase of the stroboscopic section, rad."""
        return column(self.cam, "start")[self.cam.strobe]

    @cached_property
    def corners(self) -> list[float]:
        """Phases of the cam's corners, rad."""
        starts = column(self.cam, "start")
        return [starts[n] for n in corners(self.cam)]

    @cached_property
    def region_names(self) -> dict[int, str]:
        """Name of the smooth region of every stretch."""
        return {i: region.name for region in regions(self.cam) for i in region.stretches}

    def constants(self, rpm: float, tolerance: float, impact_budget: int) -> Constants:
        """The dimensionless constants at one speed; tolerance as a fraction of a turn."""
        const = constants_of(self.machine(rpm), tolerance * tau, impact_budget)
        if not all(isfinite(number) for number in (const.W2, const.Z * const.Z, const.G)):
            found = f"found omega0/omega = {const.W:g}, zeta/omega = {const.Z:g} at {rpm!r} rpm"
            cure = "check mass, stiffness, damping, preload and rpm"
            raise SceneError(Fault("", "follower", found, "expected finite squares of both", cure))
        return const

    @cached_property
    def lift_range(self) -> tuple[float, float]:
        """(lowest, highest) c, m."""
        return lift_range(self.cam)

    @property
    def has_seat(self) -> bool:
        """Whether the follower comes to a seat: that of a cam with lash."""
        return any(column(self.cam, "seat"))

    def restitution(self, i: int) -> float:
        """The coefficient of restitution on stretch i."""
        own = self.follower.seat_restitution
        if own is not None and self.cam.stretches[i].seat:
            return own
        return self.follower.restitution

    @property
    def rocker_ratio(self) -> float:
        """Lift of the follower per lift of the cam's lobe; 1 where no rocker is between them."""
        return getattr(self.shape, "rocker_ratio", 1.0)

    @property
    def lift(self) -> float:
        """From the lowest to the highest c, m: a close bound."""
        return self.cam.top - min(column(self.cam, "c_min"))

    def machine(self, rpm: float) -> list[float]:
        """The follower's constants and the speed as the kernel's table (`kernel.flow`)."""
        constants = (getattr(self.follower, name) for name in FOLLOWER)
        given = (AS_ON_THE_CAM if number is None else float(number) for number in constants)
        return [float(rpm), *given]


def decimals(width: float) -> int:
    """How many decimals to show of a number known to within `width`: two digits of the width."""
    return max(0, 1 - floor(log10(width))) if width > 0.0 else 6


def is_measured(system: System) -> bool:
    """Whether its cam is a lift table, whose error leaves more open than any computation."""
    return getattr(system.shape, "kind", "") == "table"


def units_of(system: System) -> Units:
    """Those of a machine."""
    return MILLIMETRES if system.lift < SMALL_LIFT else METRES
