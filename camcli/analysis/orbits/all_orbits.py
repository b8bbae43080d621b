"""All periodic orbits with so few impacts in so few turns, and that there are no others.

Boxes of impact phases (`camcli.exact.phase_cover`) are cut in half until each is shown to hold no
orbit, or none but one that is known. They cover all phases, so that the orbits found are all that
fly from impact to impact, without rest. Of the n rotations of an orbit only those are covered that
begin with its longest flight, and of its impacts the first lies in the first turn.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from itertools import combinations_with_replacement
from math import isclose

from flint import arb

from camcli.analysis.integrate import BudgetSpentError, spend
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.cams.balls import COARSE, UndecidedError, precision
from camcli.cams.compile import Shape
from camcli.exact.machine import BallMachine, stretches_of
from camcli.exact.phase_cover import Cell, Key, PhaseCover
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.system import Follower, System, kind_of_cam

MOST_BOXES = 400_000  # of all covers together
DEEPEST = 40  # halvings of a stretch
BOX_WORK = 5_000  # evaluations of the gap that take as long as a box
NEWTON_STEPS = 12  # towards the orbit near a box
CONVERGED = 1e-12  # rad: the last of them
AWAY = 2.0  # times its half width: so far from its middle a box is asked for an orbit
SAME = 1e-7  # rad: phases that differ by less are those of one impact
ROUND = 1e-9  # rad: error of the phases of an orbit, as the cover takes them
JUMP_DIGITS = 40  # at which a jump of the slope of the cam is seen
DRAWN = 2  # impacts of the covers of which a picture is drawn
MOST_DRAWN = 20_000  # boxes kept of one
NO_ORBIT, ORBIT = ".", "o"  # letters of a cover


class Failure(StrEnum):
    """Why it is not shown that the orbits are all."""

    FLIGHTS = "flights"  # flights may be long: the spring rests above a part of the cam
    STOP = "stop"  # the same of an oscillator, whose stop does not press all the time
    CAM = "cam"  # the slope of the cam jumps, or it has no closed formula
    BOXES = "boxes"  # more or smaller boxes would be needed
    WORK_BUDGET = "work-budget"
    LOSSLESS = "lossless"  # restitution 1: no bound on the rates of impacts
    PLASTIC = "plastic"  # restitution 0: no impact leaves the cam at a rate above zero


@dataclass(frozen=True)
class Cover:
    """The boxes of the orbits of so many impacts in so many turns.

    letters: of each box, before those of its halves: the figure k where it is cut in half along
    phase k, a point where it holds no orbit, o where it holds none but a known one. known: their
    numbers among the orbits, one for each o. counts: boxes by the reason for which they hold none.
    drawn: (low and high phase, rad, of each impact; reason) of boxes, an empty one for a known
    orbit, or nothing where they are too many.
    """

    impacts: int
    turns: int
    letters: str
    known: tuple[int, ...]
    counts: dict[str, int]
    drawn: tuple[tuple[tuple[tuple[float, float], ...], str], ...] = ()

    @property
    def boxes(self) -> int:
        """Boxes that are not cut."""
        return sum(self.counts.values()) + len(self.known)


@dataclass(frozen=True)
class AllOrbits:
    """The orbits with at most so many impacts in at most so many turns, and the covers.

    follower: whose orbits they are; failure: None where they are all.
    """

    follower: Follower
    impacts: int
    turns: int
    orbits: list[PeriodicOrbit] = field(default_factory=list)
    covers: tuple[Cover, ...] = ()
    failure: Failure | None = None


def all_orbits(
    shooter: Shooter, rpm: float, impacts: int, turns: int, tick: Callable[[], None] = lambda: None
) -> AllOrbits:
    """Find them, and cover all phases; `tick` is called after each cover."""
    system = shooter.system
    found = AllOrbits(system.follower, impacts, turns)
    if not _smooth(system.shape):
        return replace(found, failure=Failure.CAM)
    if not 0.0 < system.follower.restitution < 1.0:
        lossless = system.follower.restitution == 1.0
        return replace(found, failure=Failure.LOSSLESS if lossless else Failure.PLASTIC)
    covers: list[Cover] = []
    with precision(COARSE // 3):
        try:
            search = _Search(shooter, rpm, found.orbits)
            for m in range(1, turns + 1):
                for n in range(1, impacts + 1):
                    covers.append(search.cover(n, m))
                    tick()
            failure = None
        except UndecidedError:
            of_an_oscillator = kind_of_cam(system) == "oscillator"
            failure = Failure.STOP if of_an_oscillator else Failure.FLIGHTS
        except _TooManyError:
            failure = Failure.BOXES
        except BudgetSpentError:
            failure = Failure.WORK_BUDGET
    return _in_order(replace(found, covers=tuple(covers), failure=failure))


def _smooth(shape: Shape) -> bool:
    """Whether the cam has a closed formula, and its slope jumps nowhere."""
    if any(part.pieces or part.seat for part in shape.parts()):
        return False
    with precision(JUMP_DIGITS):
        stretches = stretches_of(shape)
        at_starts = [one.derivatives(one.start, 1)[1] for one in stretches]
        at_ends = [one.derivatives(one.end, 1)[1] for one in stretches]
        before_starts = [at_ends[-1], *at_ends[:-1]]
        pairs = zip(before_starts, at_starts, strict=True)
        return all(before.overlaps(after) for before, after in pairs)


def _in_order(found: AllOrbits) -> AllOrbits:
    """The same with the stable orbits first, then those of few turns."""
    numbers = sorted(range(len(found.orbits)), key=lambda k: _place(found.orbits[k]))
    place = {number: k for k, number in enumerate(numbers)}
    covers = [replace(one, known=tuple(place[k] for k in one.known)) for one in found.covers]
    orbits = [found.orbits[number] for number in numbers]
    return replace(found, orbits=orbits, covers=tuple(covers))


def _place(orbit: PeriodicOrbit) -> tuple:
    """What orbits are sorted by."""
    return not orbit.stable, orbit.turns, orbit.symbols


def _critical(follower: Follower) -> bool:
    """Whether the damping is exactly critical, which it is of a follower without forces too."""
    m, k, b = (Fraction(x) for x in (follower.mass, follower.stiffness, follower.damping))
    return b * b == 4 * k * m


class _TooManyError(Exception):
    """More boxes would be needed."""


class _Search:
    """The orbits found so far, and the boxes made."""

    def __init__(self, shooter: Shooter, rpm: float, orbits: list[PeriodicOrbit]):
        self.shooter = shooter
        self.system: System = shooter.system
        self.rpm = rpm
        self.orbits = orbits
        machine = BallMachine(self.system.shape, self.system.follower, rpm)
        if machine.near_critical and not _critical(self.system.follower):
            raise UndecidedError
        self.space = PhaseCover(machine)
        self.made = 0

    def cover(self, impacts: int, turns: int) -> Cover:
        """The cover of the orbits of so many impacts in so many turns."""
        letters: list[str] = []
        known: list[int] = []
        counts: Counter[str] = Counter()
        drawn = []
        for start in self._sequences(impacts, turns):
            boxes = [start]
            while boxes:
                box = boxes.pop()
                self.made += 1
                spend(BOX_WORK)
                if self.made > MOST_BOXES:
                    raise _TooManyError
                reason = self.space.excluded(box, turns)
                orbit = None if reason is not None else self._orbit(box, turns)
                if reason is not None or orbit is not None:
                    letters.append(ORBIT if reason is None else NO_ORBIT)
                    if impacts == DRAWN:
                        drawn.append((self._ends(box), "" if reason is None else str(reason)))
                if reason is not None:
                    counts[str(reason)] += 1
                elif orbit is not None:
                    known.append(orbit)
                else:
                    k = self._widest(box)
                    letters.append(str(k + 1))
                    index, depth, i = box[k]
                    if depth == DEEPEST:
                        raise _TooManyError
                    halves = ((index, depth + 1, half) for half in (2 * i + 1, 2 * i))
                    boxes += [(*box[:k], half, *box[k + 1 :]) for half in halves]
        kept = tuple(drawn) if len(drawn) <= MOST_DRAWN else ()
        return Cover(impacts, turns, "".join(letters), tuple(known), dict(counts), kept)

    def _sequences(self, impacts: int, turns: int) -> Iterator[tuple[Key, ...]]:
        """All sequences of stretches that the impacts may lie on, as whole boxes."""
        count = self.space.count
        for first in range(count):
            later = range(first, first + turns * count + 1)
            for rest in combinations_with_replacement(later, impacts - 1):
                yield tuple((index, 0, 0) for index in (first, *rest))

    def _widest(self, box: tuple[Key, ...]) -> int:
        """The impact whose phases are widest."""
        widths = [float(self.space.cell(key).own.rad()) for key in box]
        return widths.index(max(widths))

    def _ends(self, box: tuple[Key, ...]) -> tuple[tuple[float, float], ...]:
        """The lowest and the highest phase of each impact, rad."""
        balls = [self.space.cell(key).x for key in box]
        return tuple((float(x.lower()), float(x.upper())) for x in balls)

    def _orbit(self, box: tuple[Key, ...], turns: int) -> int | None:
        """The number of the only orbit that may have its impacts in a box, None where none is."""
        solved = self._solved(box, turns)
        if solved is None:
            return None
        phases, rates = solved
        if not self.space.alone(box, turns, [arb(x, ROUND) for x in phases]):
            return None
        places = [TURN * (key[0] // self.space.count) for key in box]
        absolute = [at + x for at, x in zip(places, phases, strict=True)]
        for number, orbit in enumerate(self.orbits):
            if _is(orbit, absolute, turns):
                return number
        new = self._new(box, phases, rates, turns)
        if new is None:
            return None
        self.orbits.append(new)
        return len(self.orbits) - 1

    def _solved(self, box: tuple[Key, ...], turns: int) -> tuple[list[float], list[float]] | None:
        """(phases within the turn, rates) of the zero of E near a box, where Newton finds it."""
        space = self.space
        cells = [space.cell(key) for key in box]
        middle = [float(cell.own.mid()) for cell in cells]
        reach = [AWAY * float(cell.own.rad()) for cell in cells]
        x = list(middle)
        for _ in range(NEWTON_STEPS):
            points = [
                Cell(space.machine.stretches, key[0], arb(at))
                for key, at in zip(box, x, strict=True)
            ]
            found = space.at(points, turns)
            if found is None:
                return None
            try:
                step = [float(dx) for dx in (found[1].inv() * found[0]).mid().entries()]
            except ZeroDivisionError:
                return None
            x = [at - dx for at, dx in zip(x, step, strict=True)]
            near = zip(x, middle, reach, strict=True)
            if not all(abs(at - here) <= most for at, here, most in near):
                return None
            if max(map(abs, step)) < CONVERGED:
                inside = all(
                    cell.stretch.start < at and at < cell.stretch.end
                    for cell, at in zip(cells, x, strict=True)
                )
                return (x, [float(rate) for rate in found[2]]) if inside else None
        return None

    def _new(
        self, box: tuple[Key, ...], phases: list[float], rates: list[float], turns: int
    ) -> PeriodicOrbit | None:
        """The motion with these impacts, None where the equations have a zero that is none."""
        count = self.space.count
        impacts = sorted(  # of one period that begins with a turn
            (key[0] // count % turns, phase, rate)
            for key, phase, rate in zip(box, phases, rates, strict=True)
        )
        numbers = [x for _, *pair in impacts for x in pair]
        whole = [
            place
            for turn, phase, _ in impacts
            for place in (stretch_at(self.system.cam, phase), turn)
        ]
        root = self.shooter.at_value([*numbers, self.rpm], whole, turns, self.rpm)
        if root is None or not all(
            isclose(theta, phase, abs_tol=SAME)
            for theta, (_, phase, _) in zip(root.theta, impacts, strict=True)
        ):
            return None
        orbit = from_root(self.system, root, self.shooter.verdict(root)[0])
        return orbit if orbit.admissible and orbit.primitive else None


def _is(orbit: PeriodicOrbit, phases: list[float], turns: int) -> bool:
    """Whether phases, counted on from turn to turn, are an orbit's, from one of its impacts on."""
    root = orbit.root
    assert root is not None
    times, rest = divmod(turns, orbit.turns)
    if rest or times * root.count != len(phases):
        return False
    own = [x + TURN * root.turn(k) for k, x in enumerate(root.theta)]
    period = TURN * orbit.turns
    unrolled = [x + period * again for again in range(times + 1) for x in own]
    for k in range(root.count):
        part = unrolled[k : k + len(phases)]
        shift = TURN * round((phases[0] - part[0]) / TURN)
        if all(abs(x + shift - y) < SAME for x, y in zip(part, phases, strict=True)):
            return True
    return False
