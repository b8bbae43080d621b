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
from itertools import combinations_with_replacement
from math import isclose
from typing import NamedTuple

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
NO_ORBIT = "."  # letters of a cover
ORBIT = "o"

Box = tuple[Key, ...]  # a cell of the cam for each impact


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
    """Find all orbits of so few impacts and turns at a speed, and cover all phases.

    `tick` is called after each cover. Where they are not shown to be all, `failure` says why.
    """
    system = shooter.system
    nothing = AllOrbits(system.follower, impacts, turns)
    if not _smooth(system.shape):
        return replace(nothing, failure=Failure.CAM)
    if not 0.0 < system.follower.restitution < 1.0:
        lossless = system.follower.restitution == 1.0
        return replace(nothing, failure=Failure.LOSSLESS if lossless else Failure.PLASTIC)
    orbits: list[PeriodicOrbit] = []
    covers: list[Cover] = []
    failure = None
    with precision(COARSE // 3):
        try:
            search = _CoverSearch(shooter, rpm, orbits)
            for m in range(1, turns + 1):
                for n in range(1, impacts + 1):
                    covers.append(search.cover(n, m))
                    tick()
        except UndecidedError:
            of_an_oscillator = kind_of_cam(system) == "oscillator"
            failure = Failure.STOP if of_an_oscillator else Failure.FLIGHTS
        except _TooManyError:
            failure = Failure.BOXES
        except BudgetSpentError:
            failure = Failure.WORK_BUDGET
    return _in_order(AllOrbits(system.follower, impacts, turns, orbits, tuple(covers), failure))


def _smooth(shape: Shape) -> bool:
    """Whether the cam has a closed formula, and its slope jumps nowhere."""
    if any(part.pieces or part.seat for part in shape.parts()):
        return False
    with precision(JUMP_DIGITS):
        stretches = stretches_of(shape)
        slopes_at_starts = [one.derivatives(one.start, 1)[1] for one in stretches]
        slopes_at_ends = [one.derivatives(one.end, 1)[1] for one in stretches]
        slopes_before_starts = [slopes_at_ends[-1], *slopes_at_ends[:-1]]
        pairs = zip(slopes_before_starts, slopes_at_starts, strict=True)
        return all(before.overlaps(behind) for before, behind in pairs)


def _in_order(unordered: AllOrbits) -> AllOrbits:
    """The same with the stable orbits first, then those of few turns; covers number them anew."""

    def rank(number: int) -> tuple:
        """What the orbits are sorted by."""
        orbit = unordered.orbits[number]
        return not orbit.stable, orbit.turns, orbit.symbols

    old_numbers = sorted(range(len(unordered.orbits)), key=rank)
    new_number = {old: new for new, old in enumerate(old_numbers)}
    covers = tuple(
        replace(cover, known=tuple(new_number[old] for old in cover.known))
        for cover in unordered.covers
    )
    orbits = [unordered.orbits[old] for old in old_numbers]
    return replace(unordered, orbits=orbits, covers=covers)


class _TooManyError(Exception):
    """More boxes would be needed."""


class _BoxRoot(NamedTuple):
    """A zero of the equations in a box: phase within the turn and rate after each impact."""

    phases: list[float]  # rad
    rates: list[float]  # m/rad


class _CoverSearch:
    """The orbits found so far, and the boxes made."""

    def __init__(self, shooter: Shooter, rpm: float, orbits: list[PeriodicOrbit]):
        """orbits: a list to which those found are added.

        Raises UndecidedError as `PhaseCover` does.
        """
        self.shooter = shooter
        self.system: System = shooter.system
        self.rpm = rpm
        self.orbits = orbits
        machine = BallMachine(self.system.shape, self.system.follower, rpm)
        self.space = PhaseCover(machine)
        self.made = 0

    def cover(self, impacts: int, turns: int) -> Cover:
        """The cover of the orbits of so many impacts in so many turns.

        A box that is shown neither to hold no orbit nor to hold only a known one is cut in half
        along its widest phase. Raises _TooManyError.
        """
        letters: list[str] = []
        known: list[int] = []
        counts: Counter[str] = Counter()
        drawn = []
        for whole_box in self._whole_boxes(impacts, turns):
            boxes = [whole_box]
            while boxes:
                box = boxes.pop()
                self._count_box()
                exclusion = self.space.excluded(box, turns)
                orbit = None
                if exclusion is not None:
                    letters.append(NO_ORBIT)
                    counts[str(exclusion)] += 1
                else:
                    orbit = self._orbit(box, turns)
                    if orbit is not None:
                        letters.append(ORBIT)
                        known.append(orbit)
                if exclusion is None and orbit is None:
                    k = self._widest(box)
                    letters.append(str(k + 1))
                    boxes += _halves(box, k)
                elif impacts == DRAWN:
                    drawn.append((self._ends(box), "" if exclusion is None else str(exclusion)))
        few_enough_drawn = tuple(drawn) if len(drawn) <= MOST_DRAWN else ()
        return Cover(impacts, turns, "".join(letters), tuple(known), dict(counts), few_enough_drawn)

    def _count_box(self) -> None:
        """Count a box, and its work; raises _TooManyError beyond MOST_BOXES."""
        self.made += 1
        spend(BOX_WORK)
        if self.made > MOST_BOXES:
            raise _TooManyError

    def _whole_boxes(self, impacts: int, turns: int) -> Iterator[Box]:
        """A box for each sequence of whole stretches that the impacts may lie on.

        The first impact lies in the first turn, each other one not before it.
        """
        count = self.space.count
        for first in range(count):
            not_before = range(first, first + turns * count + 1)
            for others in combinations_with_replacement(not_before, impacts - 1):
                yield tuple(Key(stretch, depth=0, part=0) for stretch in (first, *others))

    def _widest(self, box: Box) -> int:
        """The impact whose phases are widest."""
        widths = [float(self.space.cell(key).in_turn.rad()) for key in box]
        return widths.index(max(widths))

    def _ends(self, box: Box) -> tuple[tuple[float, float], ...]:
        """The lowest and the highest phase of each impact, rad."""
        balls = [self.space.cell(key).x for key in box]
        return tuple((float(x.lower()), float(x.upper())) for x in balls)

    def _orbit(self, box: Box, turns: int) -> int | None:
        """The number of the only orbit that may have its impacts in a box, None where none is.

        A new one is added to the orbits.
        """
        root = self._solved(box, turns)
        if root is None:
            return None
        if not self.space.alone(box, turns, [arb(x, ROUND) for x in root.phases]):
            return None
        counted_on = [
            TURN * (key.stretch // self.space.count) + phase
            for key, phase in zip(box, root.phases, strict=True)
        ]
        for number, orbit in enumerate(self.orbits):
            if _has_phases(orbit, counted_on, turns):
                return number
        new = self._new(box, root, turns)
        if new is None:
            return None
        self.orbits.append(new)
        return len(self.orbits) - 1

    def _solved(self, box: Box, turns: int) -> _BoxRoot | None:
        """The zero of E in a box or near it, by Newton's method; None where that does not find it.

        It may leave the box by AWAY times its half width on the way.
        """
        space = self.space
        cells = [space.cell(key) for key in box]
        middle = [float(cell.in_turn.mid()) for cell in cells]
        reach = [AWAY * float(cell.in_turn.rad()) for cell in cells]
        phases = list(middle)
        for _ in range(NEWTON_STEPS):
            points = [
                Cell(space.machine.stretches, key.stretch, arb(phase))
                for key, phase in zip(box, phases, strict=True)
            ]
            checked = space.at(points, turns)
            if checked is None:
                return None
            values, slopes = checked.equations
            try:
                step = [float(x) for x in (slopes.inv() * values).mid().entries()]
            except ZeroDivisionError:
                return None
            phases = [phase - change for phase, change in zip(phases, step, strict=True)]
            away = zip(phases, middle, reach, strict=True)
            if not all(abs(phase - here) <= most for phase, here, most in away):
                return None
            if max(map(abs, step)) < CONVERGED:
                on_stretches = all(
                    cell.stretch.start < phase and phase < cell.stretch.end
                    for cell, phase in zip(cells, phases, strict=True)
                )
                rates = [float(rate) for rate in checked.rates]
                return _BoxRoot(phases, rates) if on_stretches else None
        return None

    def _new(self, box: Box, solved: _BoxRoot, turns: int) -> PeriodicOrbit | None:
        """The motion with these impacts, None where the equations have a zero that is none."""
        count = self.space.count
        impacts = sorted(  # (turn, phase, rate) in one period that begins with a turn
            (key.stretch // count % turns, phase, rate)
            for key, phase, rate in zip(box, solved.phases, solved.rates, strict=True)
        )
        guess: list[float] = []
        whole: list[int] = []
        for turn, phase, rate in impacts:
            guess += [phase, rate]
            whole += [stretch_at(self.system.cam, phase), turn]
        root = self.shooter.at_value([*guess, self.rpm], whole, turns, self.rpm)
        if root is None:
            return None
        for theta, (_, phase, _) in zip(root.theta, impacts, strict=True):
            if not isclose(theta, phase, abs_tol=SAME):
                return None
        verdict, _, _ = self.shooter.verdict(root)
        orbit = from_root(self.system, root, verdict)
        return orbit if orbit.admissible and orbit.primitive else None


def _halves(box: Box, k: int) -> list[Box]:
    """A box cut in half along phase k, the later half first; raises _TooManyError."""
    key = box[k]
    if key.depth == DEEPEST:
        raise _TooManyError
    parts = (2 * key.part + 1, 2 * key.part)
    return [(*box[:k], Key(key.stretch, key.depth + 1, part), *box[k + 1 :]) for part in parts]


def _has_phases(orbit: PeriodicOrbit, phases: list[float], turns: int) -> bool:
    """Whether phases, counted on over so many turns, are an orbit's, from one of its impacts on.

    phases: rad. The orbit is gone through as often as the turns hold it.
    """
    root = orbit.root
    assert root is not None
    times, turns_left = divmod(turns, orbit.turns)
    if turns_left or times * root.count != len(phases):
        return False
    in_period = [theta + TURN * root.turn(k) for k, theta in enumerate(root.theta)]
    period = TURN * orbit.turns
    unrolled = [x + period * again for again in range(times + 1) for x in in_period]
    for k in range(root.count):
        from_impact_k = unrolled[k : k + len(phases)]
        shift = TURN * round((phases[0] - from_impact_k[0]) / TURN)
        pairs = zip(from_impact_k, phases, strict=True)
        if all(abs(x + shift - phase) < SAME for x, phase in pairs):
            return True
    return False
