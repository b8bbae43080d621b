"""The machine: a follower and a compiled cam, frozen; from it the constants of one speed.

A `Family` is the machines of a scene over some numbers that its cam depends on.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import floor, isfinite, log10, pi, tau
from operator import attrgetter
from typing import Any

from camcli.cams.compile import Shape, build, column, corners, lift_range
from camcli.cams.regions import regions
from camcli.errors import Fault, NoMachineError, SceneError, plural
from camcli.kernel.cam_table import Cam, stretch_at
from camcli.kernel.flow import AS_ON_THE_CAM, RAD_PER_S, Constants, constants_of
from camcli.kernel.forms import Kernel
from camcli.quantities import FOLLOWER, METRES, MILLIMETRES, Units

RPM = 30.0 / pi  # in a radian per second
REMEMBERED = 32  # cams
SMALL_LIFT = 0.1  # m: lengths of a smaller cam are printed in mm
CONSTANTS = 1 + len(FOLLOWER)  # numbers of the kernel's table: the speed and the follower's
MOST_MEMBERS = 256  # machines of a family that are kept
LOOKS = 16  # machines between here and an end of a range, after which there is one all the way
_follower_constants = attrgetter(*FOLLOWER)  # in the order of the kernel's table
EDGE = 1e-12  # of a range: how well the value is known at which there is no machine any more


@dataclass(frozen=True)
class Follower:
    """Constants of the follower, in the units of `quantities.FOLLOWER`.

    Examples
    --------
    >>> from camcli import Follower
    >>> Follower(mass=1.2, stiffness=1430.8).restitution
    0.8
    """

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

    `shape` gives the cam's functions, for who needs more digits than the table holds. `member` is
    the place of the machine in a family, where its cam is to vary.

    Examples
    --------
    >>> from camcli import Follower, System
    >>> from camcli.cams import EccentricCam
    >>> cam = EccentricCam(kind="eccentric", base=0.0, lift=0.02)
    >>> System.build(Follower(mass=1.2, stiffness=1430.8), cam).lift_range
    (0.0, 0.02)
    """

    follower: Follower
    cam: Cam
    shape: Shape = field(compare=False, repr=False)
    member: Member | None = field(default=None, compare=False, repr=False)

    @classmethod
    def build(cls, follower: Follower, shape: Shape, strobe: float = 0.0) -> System:
        """Compile the cam; the strobe phase (rad) becomes a boundary of the table."""
        return cls(follower, cam_of(shape, strobe), shape)

    def with_follower(self, **changes: float) -> System:
        """The same cam under another follower; what is known of the cam is kept."""
        other = System(replace(self.follower, **changes), self.cam, self.shape, self.member)
        other.__dict__["_of_the_cam"] = self._of_the_cam  # in the place of its cached property
        return other

    def __getstate__(self) -> dict:
        """Without the tables in a kernel's form, which `cam_for` makes again, and its family."""
        return {"follower": self.follower, "cam": self.cam, "shape": self.shape, "member": None}

    def cam_for(self, kernel: Kernel) -> Cam:
        """The table as this kernel takes it; made once."""
        of_the_cam = self._of_the_cam
        if kernel not in of_the_cam:
            of_the_cam[kernel] = kernel.cam(self.cam)
        return of_the_cam[kernel]

    @cached_property
    def _of_the_cam(self) -> dict[Any, Any]:
        """What depends on the cam alone, by name, or by kernel its tables.

        It is computed once for all followers on the cam, which share this dictionary.
        """
        return {}

    @cached_property
    def known(self) -> dict[str, Any]:
        """What analyses have found of this machine alone, by name, so that each finds it once."""
        return {}

    @property
    def strobe(self) -> float:
        """Phase of the stroboscopic section, rad."""
        return self.cam.stretches[self.cam.strobe].start

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
        if not (isfinite(const.W2) and isfinite(const.Z * const.Z) and isfinite(const.G)):
            found = f"found omega0/omega = {const.W:g}, zeta/omega = {const.Z:g} at {rpm!r} rpm"
            cure = "check mass, stiffness, damping, preload and rpm"
            raise SceneError(Fault("", "follower", found, "expected finite squares of both", cure))
        return const

    @property
    def lift_range(self) -> tuple[float, float]:
        """(lowest, highest) c, m; computed once."""
        of_the_cam = self._of_the_cam
        if "lift_range" not in of_the_cam:
            of_the_cam["lift_range"] = lift_range(self.cam)
        return of_the_cam["lift_range"]

    @property
    def has_seat(self) -> bool:
        """Whether the follower comes to a seat: that of a cam with lash."""
        return bool(self.seat_stretches)

    @property
    def seat_stretches(self) -> frozenset[int]:
        """The stretches on which the follower comes to its seat; computed once."""
        of_the_cam = self._of_the_cam
        if "seat_stretches" not in of_the_cam:
            seats = column(self.cam, "seat")
            of_the_cam["seat_stretches"] = frozenset(i for i, seat in enumerate(seats) if seat)
        return of_the_cam["seat_stretches"]

    def is_seat(self, theta: float) -> bool:
        """Whether the follower rests on its seat at a phase, rad in [0, 2 pi)."""
        return bool(self.cam.stretches[stretch_at(self.cam, theta)].seat)

    def restitution(self, i: int) -> float:
        """The coefficient of restitution on stretch i."""
        of_seat = self.follower.seat_restitution
        if of_seat is not None and self.cam.stretches[i].seat:
            return of_seat
        return self.follower.restitution

    @property
    def lash(self) -> float:
        """Clearance between the follower and the base circle, m; 0 without a seat."""
        return getattr(self.shape, "lash", None) or 0.0

    @cached_property
    def as_drawn(self) -> System:
        """The follower on the cam without its lash, for what is asked of the lobe itself."""
        if not self.has_seat:
            return self
        shape: Any = self.shape
        drawn = shape.as_drawn()
        return System(self.follower, cam_of(drawn, self.strobe), drawn)

    @property
    def rocker_ratio(self) -> float:
        """Lift of the follower per lift of the cam's lobe; 1 where no rocker is between them."""
        return getattr(self.shape, "rocker_ratio", 1.0)

    @property
    def lift(self) -> float:
        """From the lowest to the highest c, m: a close bound; computed once."""
        of_the_cam = self._of_the_cam
        if "lift" not in of_the_cam:
            of_the_cam["lift"] = self.cam.top - min(column(self.cam, "c_min"))
        return of_the_cam["lift"]

    def machine(self, rpm: float) -> list[float]:
        """The speed and the follower's constants as the kernel's table (`kernel.flow`)."""
        constants = _follower_constants(self.follower)
        numbers = [AS_ON_THE_CAM if value is None else float(value) for value in constants]
        return [float(rpm), *numbers]

    def at(self, machine: Sequence[float]) -> System:
        """The machine whose cam belongs to a table of the kernel.

        machine: the table (`machine`), with the values of the family's numbers behind it. Without
        such values, and where they are its own, it is this machine itself; the follower is not
        looked at. Raises NoMachineError where there is no machine at these values.
        """
        values = tuple(machine[CONSTANTS:])
        if self.member is None or values == self.member.values or not values:
            return self
        return self.member.family.at(values).system


@dataclass(frozen=True)
class Member:
    """One machine of a family.

    values: of the family's numbers; machine: the kernel's table, with the values behind it.
    """

    family: Family
    values: tuple[float, ...]
    system: System
    machine: tuple[float, ...]


class Family:
    """The machines of a scene over some numbers that its cam depends on.

    names: keys of the scene; ranges: the values from the lowest to the highest; build: the machine
    and its speed (rpm) for a value of each, or a NoMachineError, which says why there is none.
    Every machine of it has the same stretches in the same order, so that an impact stays in its
    stretch while the numbers vary; values at which one is missing, or another one appears, are
    outside the family.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        ranges: tuple[tuple[float, float], ...],
        values: tuple[float, ...],
        build: Callable[[tuple[float, ...]], tuple[System, float]],
    ):
        """values: those of `home`, the machine from which one looks at the others."""
        self.names = names
        self.ranges = ranges
        self._build = build
        # by their values, the latest used last
        self._members: OrderedDict[tuple[float, ...], Member] = OrderedDict()
        self._stretches: tuple | None = None  # of every member, see `_check`
        self.compiled = 0  # cams so far
        self.home = self.at(values)
        self.derived = self._derived()

    def at(self, values: Sequence[float]) -> Member:
        """The machine at these values; raises NoMachineError where there is none."""
        key = tuple(map(float, values))
        member = self._members.pop(key, None)
        if member is None:
            system, rpm = self._build(key)
            self.compiled += 1
            self._check(system)
            member = Member(self, key, system, (*system.machine(rpm), *key))
            member = replace(member, system=replace(system, member=member))
        self._members[key] = member
        while len(self._members) > MOST_MEMBERS:
            self._members.popitem(last=False)
        return member

    def moved(self, machine: Sequence[float], values: Sequence[float]) -> tuple[float, ...]:
        """A kernel's table with other values behind it, and the constants that depend on them."""
        other = self.at(values).machine
        constants = [other[k] if k in self.derived else machine[k] for k in range(CONSTANTS)]
        return (*constants, *other[CONSTANTS:])

    def _check(self, system: System) -> None:
        """Raise NoMachineError where the cam has other stretches than at home.

        They are compared by which are dwells, which are seats, and at which the strobe lies.
        """
        cam = system.cam
        kinds = [(stretch.dwell, stretch.seat) for stretch in cam.stretches]
        stretches = (cam.strobe, *kinds)
        if self._stretches is None:
            self._stretches = stretches
        if stretches == self._stretches:
            return
        count = len(kinds)
        count_at_home = len(self._stretches) - 1
        if count == count_at_home:
            raise NoMachineError("a part of the cam passes the strobe or the angle zero there")
        raise NoMachineError(
            f"the cam has {plural(count, 'part')} there, here {count_at_home}: one appears or "
            "vanishes"
        )

    def _derived(self) -> frozenset[int]:
        """Places in the kernel's table of the constants that depend on the values.

        They are those that differ from home's at the ends or the middle of a range.
        """
        home = self.home
        derived: set[int] = set()
        for k, (low, high) in enumerate(self.ranges):
            for value in (low, high, 0.5 * (low + high)):
                values = (*home.values[:k], value, *home.values[k + 1 :])
                try:
                    machine = self.at(values).machine
                except NoMachineError:
                    continue
                derived |= {j for j in range(CONSTANTS) if machine[j] != home.machine[j]}
        return frozenset(derived)

    def reach(self, place: int, fixed: Sequence[float], end: float) -> tuple[float, str]:
        """(how far towards `end` there is a machine, and why not farther, empty where it is).

        place: the number that moves, from its value in `fixed`, where the others stay. LOOKS values
        on the way are tried, and the first one without a machine is then approached by bisection.
        """

        def fault(value: float) -> str:
            """Why there is no machine at a value of the number; empty where there is one."""
            try:
                self.at((*fixed[:place], value, *fixed[place + 1 :]))
            except NoMachineError as error:
                return str(error)
            return ""

        start = fixed[place]
        good = start  # the last value at which there is a machine
        bad = end  # the first one at which there is none, for this reason:
        reason = ""
        for k in range(1, LOOKS + 1):
            bad = end if k == LOOKS else start + (end - start) * (k / LOOKS)
            reason = fault(bad)
            if reason:
                break
            good = bad
        while reason and abs(bad - good) > EDGE * abs(end - start):
            middle = 0.5 * (good + bad)
            if not min(good, bad) < middle < max(good, bad):
                break
            fault_at_middle = fault(middle)
            if fault_at_middle:
                bad = middle
                reason = fault_at_middle
            else:
                good = middle
        return good, reason


@lru_cache(maxsize=REMEMBERED)
def cam_of(shape: Shape, strobe: float) -> Cam:
    """The table of a cam; made once for all followers on it."""
    return build(shape, strobe)


def decimals(width: float) -> int:
    """How many decimals to show of a number known to within `width`: two digits of the width."""
    return max(0, 1 - floor(log10(width))) if width > 0.0 else 6


def is_measured(system: System) -> bool:
    """Whether its cam is a lift table, whose error leaves more open than any computation."""
    return kind_of_cam(system) == "table"


def kind_of_cam(system: System) -> str:
    """`cam.kind` of its scene; empty of a cam that no scene has."""
    return getattr(system.shape, "kind", "")


def units_of(system: System) -> Units:
    """The units in which a machine's lengths, stiffness and forces are shown."""
    return MILLIMETRES if system.lift < SMALL_LIFT else METRES
