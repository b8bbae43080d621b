"""Newton's method for periodic orbits with impacts, through the kernel's `shooting`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.integrate import Cost, Orbit, Record, Settings, Start, spend
from camcli.analysis.orbits.family_shooting import (
    FamilyShooting,
    Solved,
    border,
    on_edge,
    rounding_of_last,
)
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.arithmetic import exp_decay
from camcli.kernel.bordered import Tables, tables_for
from camcli.kernel.cam_table import TURN
from camcli.kernel.certify import ADMISSIBLE
from camcli.kernel.contact_search import Tally
from camcli.kernel.flow import (
    AS_ON_THE_CAM,
    DAMPING,
    GRAVITY,
    MASS,
    PRELOAD,
    RESTITUTION,
    SEAT_RESTITUTION,
    STIFFNESS,
    Constants,
    Flow,
    constants_of,
)
from camcli.kernel.forms import as_list, row_of
from camcli.kernel.shooting import STEP, STEPS_TAKEN, TRACE, Border, fill_tables
from camcli.quantities import PARAMETERS
from camcli.system import CONSTANTS, System, omega_of

PLACES = {name: place for place, name in enumerate(PARAMETERS)}  # in the table of `kernel.flow`
Vector = Sequence[float] | np.ndarray  # theta_1, v_1, ..., theta_n, v_n, parameter
SOLVED = 600  # compiled evaluations of the gap that take as long as Newton's step of one impact
FLOWN = 400  # and as one that is not compiled
SMALL = 1e-3  # share of its natural size below which a parameter or a rate counts as zero


@dataclass(frozen=True)
class Root:
    """A solution of the shooting equations, admissible or not.

    x: theta_1, v_1, ..., theta_n, v_n, parameter (rad in the turn, outgoing m/rad); whole: stretch
    and turn of each impact; rates: incoming m/rad; tangent: direction of the branch, not normed;
    machine: constants at this point (`kernel.flow`), of a family its values behind them; step: the
    last Newton step, relative; seat: stretches of the cam.
    """

    x: list[float]
    whole: tuple[int, ...]
    turns: int
    machine: tuple[float, ...]
    parameter: int
    rates: list[float]
    tangent: list[float]
    trace: float
    step: float
    steps: int
    seat: frozenset[int] = frozenset()  # the stretches that are the cam's seat

    @property
    def count(self) -> int:
        """Impacts in one period of the orbit."""
        return len(self.rates)

    @property
    def value(self) -> float:
        """The parameter."""
        return self.x[-1]

    @property
    def theta(self) -> list[float]:
        """Impact phases within the turn, rad."""
        return self.x[:-1:2]

    def stretch(self, k: int) -> int:
        """The stretch of the cam on which impact k lands."""
        return self.whole[2 * k]

    def turn(self, k: int) -> int:
        """The turn in which impact k lands, counted from that of the first one."""
        return self.whole[2 * k + 1]

    def landing_on(self, k: int, stretch: int, turn: int) -> "Root":
        """The root with impact k on another stretch and in another turn, not solved for that."""
        whole = (*self.whole[: 2 * k], stretch, turn, *self.whole[2 * k + 2 :])
        return replace(self, whole=whole)

    def flight_length(self, k: int) -> float:
        """The angle from impact k to the next one, rad; after the last comes the first again."""
        after = (k + 1) % self.count
        turns = self.turn(after) - self.turn(k) + (self.turns if after <= k else 0)
        return self.theta[after] - self.theta[k] + TURN * turns

    @cached_property
    def const(self) -> Constants:
        """The constants of the machine at this point; no chatter is closed with them."""
        return constants_of(self.machine, 0.0, 0)

    @property
    def det(self) -> float:
        """Determinant of the monodromy matrix, exact: r^2 from an impact, exp(-2 Z s) from s rad.

        That is r^(2 n) exp(-b m T/mass) for n impacts in m turns, where none is on a seat.
        """
        const = self.const
        value = exp_decay(2.0 * const.Z * TURN * self.turns)
        for i in self.whole[::2]:
            r = const.r_seat if i in self.seat else const.r
            value *= r * r
        return value


def with_machine(system: System, machine: Sequence[float]) -> tuple[System, float]:
    """The system with the constants of a kernel's table, and its speed in rpm.

    In a family the values behind the constants name the member, whose cam it is. Raises
    NoMachineError where there is no such member.
    """
    rpm, *constants = machine[:CONSTANTS]
    names = [name for name in PLACES if name != "rpm"]
    changes: dict[str, Any] = dict(zip(names, constants, strict=True))
    if changes["seat_restitution"] == AS_ON_THE_CAM:
        changes["seat_restitution"] = None
    if system.member is not None:
        return system.at(machine).with_follower(**changes), rpm
    return replace(system, follower=replace(system.follower, **changes)), rpm


def table_of(system: System, rpm: float) -> tuple[float, ...]:
    """The kernel's table of a machine, of a family with its values behind the constants."""
    return (*system.machine(rpm), *(() if system.member is None else system.member.values))


def place_of(system: System, name: str) -> int:
    """Where a parameter stands in the machine of a `Shooter`."""
    if name in PLACES:
        return PLACES[name]
    assert system.member is not None
    return CONSTANTS + system.member.family.names.index(name)


def machine_at(
    system: System, machine: Sequence[float], name: str, value: float
) -> tuple[float, ...]:
    """The machine of a `Shooter` with a parameter at a value, and with all that follows from it.

    Raises NoMachineError where there is none.
    """
    place = place_of(system, name)
    values = list(machine)
    values[place] = value
    if place >= CONSTANTS and system.member is not None:
        return system.member.family.moved(values, values[CONSTANTS:])
    return tuple(values)


class ShootingRoom(NamedTuple):
    """What the kernel writes to, for orbits of so many impacts."""

    tables: Tables
    rates: Any  # incoming rate of each impact
    out: Any  # trace, last step, number of steps: see `kernel.shooting`
    place: Any  # impact and phase at which an orbit fails: see `kernel.certify`


class Shooter:
    """Room and machine for solving many orbits; one per thread.

    The kernel is plain Python or compiled, with the same bits (`backend.for_newton`). Where the
    parameter is a number of the system's family, every root is solved on the cam of its own value
    (`family_shooting`).
    """

    def __init__(self, system: System, rpm: float, parameter: str = "rpm"):
        self.system = system
        member = system.member
        self.machine = table_of(system, rpm)
        self.parameter = place_of(system, parameter)
        self.scale = SMALL * _natural(self.parameter, self.machine[MASS], omega_of(rpm))
        size = system.lift or abs(system.cam.top) or 1.0
        self.zero_rate = SMALL * size  # m/rad: smaller ones count as zero
        self.family: FamilyShooting | None = None
        if member is not None and self.parameter >= CONSTANTS:
            low, high = member.family.ranges[self.parameter - CONSTANTS]
            self.scale = SMALL * (high - low)
            self.family = FamilyShooting(
                system, self.machine, self.parameter, self.scale, self.zero_rate
            )
        self.simulated = Cost()
        self.kernel = backend.for_newton()
        self.cam = system.cam
        self.seat = system.seat_stretches
        self._kernel_cam = system.cam_for(self.kernel)
        self._flows = self.kernel.room(Flow, len(system.cam.stretches) ** 2)
        self._works = self.kernel.room(Tally, 1)
        self._spent = 0  # evaluations of `verdict` that are counted, see `spend`
        self._rooms: dict[int, ShootingRoom] = {}

    def at(self, value: float) -> tuple[float, ...]:
        """The machine with the parameter replaced; raises NoMachineError where there is none."""
        machine = list(self.machine)
        machine[self.parameter] = value
        return tuple(machine) if self.family is None else self.family.at(value).machine

    def system_of(self, root: Root) -> System:
        """The machine whose cam is the one at a root."""
        return self.system.at(root.machine)

    def edge(self, root: Root, k: int, side: int) -> float:
        """Phase of the end (side 1) or start (-1) of the stretch of impact k, on the root's cam."""
        stretch = self.system_of(root).cam.stretches[root.whole[2 * k]]
        return stretch.end if side > 0 else stretch.start

    @property
    def value(self) -> float:
        """The parameter in the machine itself."""
        return self.machine[self.parameter]

    @property
    def cost(self) -> Cost:
        """Work of the certifying flights and of the simulations so far."""
        work = row_of(Tally, self._works[0])
        return self.simulated + Cost(0, work.evaluations, work.crossings)

    def simulate(self, system: System, rpm: float, settings: Settings, start: Start) -> Record:
        """The record of a motion; its cost is counted here."""
        record = Orbit(system, rpm, settings, start).run()
        self.simulated = self.simulated + record.cost
        return record

    def _room(self, n: int) -> ShootingRoom:
        """The tables for orbits of n impacts, allocated when they are first asked for."""
        if n not in self._rooms:
            zeros = self.kernel.zeros
            self._rooms[n] = ShootingRoom(tables_for(n, zeros), zeros(n), zeros(3), zeros(2))
        return self._rooms[n]

    def _table(self, values, kind=float):
        return self.kernel.numbers(as_list(values), kind)

    def correct(
        self,
        guess: Vector,
        whole: Sequence[int],
        turns: int,
        row: Vector,
        origin: Vector,
        right: float = 0.0,
    ) -> Root | None:
        """The root near `guess` with row (x - origin) = right, or None where Newton fails.

        The machine's constants are those of the shooter, the parameter is the last entry of x.
        whole: stretch and turn of each impact.
        """
        if self.family is not None:
            last = border(as_list(row), as_list(origin), right)
            return self._as_root(
                self.family.correct(as_list(guess), whole, turns, last), whole, turns
            )
        n = len(whole) // 2
        room = self._room(n)
        out = room.out
        x = self._table(guess)  # the kernel leaves the root here,
        machine = self._table(self.machine)  # and its machine here
        ends = Border(self._table(row), self._table(origin), right, self.scale, self.zero_rate)
        out[STEPS_TAKEN] = 0.0
        status = self.kernel.correct_orbit(
            self._kernel_cam,
            machine,
            self.parameter,
            n,
            turns,
            self._table(whole, int),
            x,
            ends,
            room.rates,
            room.tables,
            out,
        )
        steps = n * int(out[STEPS_TAKEN])
        if not self.kernel.compiled:
            backend.count_plain_newton(steps)
        spend(SOLVED * steps)
        if status != Status.OK:
            return None
        return Root(
            x=as_list(x),
            whole=tuple(whole),
            turns=turns,
            machine=tuple(as_list(machine)),
            parameter=self.parameter,
            rates=as_list(room.rates),
            tangent=as_list(room.tables.tangent),
            trace=float(out[TRACE]),
            step=float(out[STEP]),
            steps=int(out[STEPS_TAKEN]),
            seat=self.seat,
        )

    def at_value(
        self, guess: Vector, whole: Sequence[int], turns: int, value: float
    ) -> Root | None:
        """The root near `guess` at a fixed value of the parameter, or None."""
        x = [*as_list(guess)[:-1], value]
        return self.correct(x, whole, turns, [0.0] * (len(x) - 1) + [1.0], x)

    def moved(self, root: Root, value: float) -> Root | None:
        """The root followed to another value of the parameter in one step, or None."""
        return self.at_value(root.x, root.whole, root.turns, value)

    def _as_root(self, solved: Solved | None, whole: Sequence[int], turns: int) -> Root | None:
        """What was solved in the family as a Root."""
        if solved is None:
            return None
        return Root(
            x=solved.x,
            whole=tuple(whole),
            turns=turns,
            machine=solved.machine,
            parameter=self.parameter,
            rates=solved.rates,
            tangent=solved.tangent,
            trace=solved.trace,
            step=solved.step,
            steps=solved.steps,
            seat=self.seat,
        )

    def at_corner(self, guess: Root, k: int, side: int) -> Root | None:
        """The root with impact k exactly at the end (side 1) or start (-1) of its stretch."""
        x = list(guess.x)
        row = [0.0] * len(guess.x)
        row[2 * k] = 1.0
        if self.family is not None:
            x[2 * k] = self.edge(guess, k, side)
            last = on_edge(k, guess.whole[2 * k], side)
            solved = self.family.correct(x, guess.whole, guess.turns, last)
            return self._as_root(solved, guess.whole, guess.turns)
        stretch = self.cam.stretches[guess.whole[2 * k]]
        x[2 * k] = stretch.end if side > 0 else stretch.start
        return self.correct(x, guess.whole, guess.turns, row, x)

    def rounding(self, root: Root) -> float:
        """By how much rounding may have moved the parameter at a root, across its branch."""
        if self.family is not None:
            return self.family.rounding(root.x, root.whole, root.turns, root.tangent)
        tables = tables_for(root.count, lambda count: [0.0] * count)
        cam = self.system_of(root).cam
        fill_tables(
            cam, list(root.machine), self.parameter, root.count, root.turns, root.whole, root.x,
            self.scale, tables,
        )  # fmt: skip
        return rounding_of_last(cam, root.x, tables, root.tangent)

    def beyond(self, root: Root) -> list[tuple[float, int, int]]:
        """(rad beyond, impact, side) of the impacts that are off their stretch.

        side: +1 beyond its end, -1 before its start.
        """
        off = []
        cam = self.system_of(root).cam
        for k, theta in enumerate(root.theta):
            stretch = cam.stretches[root.stretch(k)]
            if stretch.start - theta > 0.0:
                off.append((stretch.start - theta, k, -1))
            if theta - stretch.end > 0.0:
                off.append((theta - stretch.end, k, 1))
        return off

    def admits(self, root: Root) -> bool:
        """True for a motion, False for a root that is none."""
        return self.verdict(root)[0] == ADMISSIBLE

    def verdict(self, root: Root) -> tuple[int, int, float]:
        """(verdict, impact, phase): `certify`'s code, and where the root fails (0-based, rad)."""
        place = self._room(root.count).place
        cam = self._kernel_cam
        if self.family is not None:
            cam = self.system_of(root).cam_for(self.kernel)
        code = self.kernel.certify_orbit(
            cam,
            self._table(root.machine),
            root.count,
            root.turns,
            self._table(root.whole, int),
            self._table(root.x),
            self._table(root.rates),
            self._flows,
            place,
            self._works,
        )
        before = self._spent
        self._spent = row_of(Tally, self._works[0]).evaluations
        spend(FLOWN * (self._spent - before))
        return int(code), int(place[0]), float(place[1])


def _natural(parameter: int, mass: float, omega: float) -> float:
    """A size of the parameter that matters: inertia forces of a metre at the cam's frequency."""
    return {
        STIFFNESS: mass * omega * omega,
        DAMPING: mass * omega,
        GRAVITY: omega * omega,
        PRELOAD: mass * omega * omega,
        RESTITUTION: 1.0,
        SEAT_RESTITUTION: 1.0,
    }.get(parameter, 0.0)
