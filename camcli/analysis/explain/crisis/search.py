"""Why a chaotic attractor changes size at once, or is lost, between two speeds.

Tried are a corner first reached, a new contact, and a crisis (Grebogi, Ott & Yorke, Physica D 7
(1983) 181): the attractor, closure of the unstable manifold W^u of an orbit B in it, meets the
stable manifold W^s of a saddle p one side of which leads out (`tangency`).

The cam-follower example (Osorio, di Bernardo & Santini, arXiv:0711.1008):
740.1065 rpm, P(7;1:1:1:1:1:1:1) of multiplier 12.6, corner c; 361.1673, P(3;3:3:2), 35.9, smooth;
682.2047, P(1;1) on A1, 1.176, corner b, chaos is lost; runs of 3 or 4 million turns agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import inf

import numpy as np

from camcli.analysis.explain.crisis.approach import Approach, approach
from camcli.analysis.explain.crisis.attractor import LEAST, Carried, states_of
from camcli.analysis.explain.crisis.saddles import LostError, find_saddles, inner_side
from camcli.analysis.explain.crisis.tangency import Fold, Folds, first_touch
from camcli.analysis.integrate import Cost, Settings, StartError
from camcli.analysis.labels import label
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.same_orbit import same_orbit
from camcli.cams.regions import Corner
from camcli.system import System

TURNS = 200_000  # of each run, unless told otherwise
ENDS = ("lower", "upper")
CALM = 0.8  # of the way to the change: the speed at which saddles are looked for
BESIDE = (1e-6, 1e-8, 1e-10)  # relative: starts beside the saddle, on the side that leads out


class CrisisKind(StrEnum):
    """What becomes of the chaotic attractor carried between the speeds, and by what.

    INTERIOR, BOUNDARY: it meets a saddle, and what leaves comes back or is lost. CORNER, GRAZING:
    it first reaches a corner or a new contact. UNEXPLAINED: it changes, no cause is found. STAYS:
    nothing leaves its range. NOT_CHAOTIC: there is no such attractor.
    """

    INTERIOR = "interior-crisis"
    BOUNDARY = "boundary-crisis"
    CORNER = "corner-impact"
    GRAZING = "grazing"
    UNEXPLAINED = "unexplained"
    STAYS = "stays"
    NOT_CHAOTIC = "not-chaotic"


@dataclass(frozen=True)
class Meeting:
    """A saddle, as it is at rpm +- error, where a fold of the attractor touches its W^s."""

    orbit: PeriodicOrbit
    rpm: float
    error: float


@dataclass(frozen=True)
class Saddles:
    """The saddles seen in the attractor and beyond it, and what became of those that lead out.

    met: ordered from the near end; unmet: no fold was seen to touch; lost: could not be followed.
    """

    inside: int
    beyond: int
    met: tuple[Meeting, ...]
    unmet: tuple[PeriodicOrbit, ...]
    lost: int


@dataclass(frozen=True)
class Crisis:
    """The change found, at rpm +- error.

    error: rpm, of a crisis an estimate of how much earlier a fold that was not sampled may touch
    (`tangency.width`), otherwise the distance to the runs, inf where nothing happens; bracket: rpm,
    the last run of so many `turns` that stays and the first that leaves, carried from `near`;
    corner: reached first, or whose image touches W^s; approach, saddles: None where nothing leaves.
    """

    kind: CrisisKind
    rpm: float
    error: float
    bracket: tuple[float, float]
    near: float
    turns: int
    cost: Cost
    corner: Corner | None = None
    approach: Approach | None = None
    saddles: Saddles | None = None

    @property
    def explained(self) -> bool:
        """True where a cause is found."""
        return self.approach is not None and self.kind is not CrisisKind.UNEXPLAINED

    @property
    def orbit(self) -> PeriodicOrbit | None:
        """The saddle met first."""
        return self.saddles.met[0].orbit if self.saddles and self.saddles.met else None


def find_crisis(
    system: System,
    settings: Settings,
    low: float,
    high: float,
    end: str = "lower",
    turns: int = TURNS,
) -> Crisis:
    """The crisis between two speeds (rpm) of the attractor carried from the `end` named.

    That end is the side on which the attractor is the smaller one, or exists at all: the start of
    the scene settles on it there. Raises ValueError for another end, StartError for a start below
    the cam.
    """
    if end not in ENDS:
        raise ValueError(f"found end {end!r}, expected one of {', '.join(ENDS)}")
    near, far = (low, high) if end == "lower" else (high, low)
    carried = Carried(system, settings, near, far, turns)
    first, last = carried.ends
    chaotic = label(first) == "aperiodic"
    if not chaotic or not carried.has_left(last):
        kind = CrisisKind.STAYS if chaotic else CrisisKind.NOT_CHAOTIC
        return Crisis(kind, far, inf, carried.bracket, near, turns, carried.cost)
    carried.narrow()
    reached = approach(carried)
    seen, touched = _saddles(carried)
    kind, rpm, error, corner = _cause(carried, reached, touched)
    return Crisis(
        kind, rpm, error, carried.bracket, near, turns, carried.cost, corner, reached, seen
    )


def _saddles(carried: Carried) -> tuple[Saddles, tuple[Folds, Fold, float] | None]:
    """Solve the tangency with every saddle seen before or beyond the change that leads out.

    The manifold that is followed is that of the shortest orbit in the attractor whose multiplier
    is below -1, since its W^u goes both ways; else of the shortest one. Returns the first tangency
    too.
    """
    calm = carried.near + CALM * (carried.stays - carried.near)
    inside = find_saddles(carried, calm, carried.run(calm, True))
    beyond = find_saddles(carried, calm, carried.run(carried.leaves, True))
    bases = [orbit for orbit in inside if orbit.multipliers[0].real < -1.0] or inside
    new = [orbit for orbit in beyond if not any(same_orbit(orbit, other) for other in inside)]
    met: list[tuple[Folds, Fold, float]] = []
    unmet, lost = [], 0
    for orbit in [*inside, *new] if bases else []:
        try:
            side = inner_side(carried, calm, orbit)
            if side == 0.0:
                continue
            folds = Folds(carried, bases[0], orbit, side)
            touched = first_touch(folds, calm) or first_touch(folds, carried.stays)
        except LostError:
            lost += 1
            continue
        if touched is None:
            unmet.append(orbit)
        else:
            met.append((folds, *touched))
    met.sort(key=lambda row: carried.way(row[1].rpm))
    rows = tuple(Meeting(folds.at(at.rpm)[1].orbit, at.rpm, error) for folds, at, error in met)
    return Saddles(len(inside), len(beyond), rows, tuple(unmet), lost), met[0] if met else None


def _cause(
    carried: Carried, reached: Approach, touched: tuple[Folds, Fold, float] | None
) -> tuple[CrisisKind, float, float, Corner | None]:
    """(kind, rpm, error, corner) by the tangency, else by what is reached first."""
    if touched is not None:
        folds, at, error = touched
        return _kind(folds, at.rpm), at.rpm, error, folds.corner(at)
    if reached.rpm is None:
        rpm, kind = carried.leaves, CrisisKind.UNEXPLAINED
    else:
        rpm, kind = reached.rpm, CrisisKind.GRAZING if reached.grazes else CrisisKind.CORNER
    error = max(abs(rpm - end) for end in carried.bracket)
    return kind, rpm, error, reached.reached


def _kind(folds: Folds, rpm: float) -> CrisisKind:
    """Interior where what leaves along the saddle comes back to the box, boundary where it is lost.

    Starts below the cam are passed over; where all are, a run that leaves decides.
    """
    carried, (_, saddle) = folds.carried, folds.at(rpm)
    states = None
    for beside in BESIDE:
        try:
            states = carried.states(rpm, saddle.leaf(0.0, -beside * folds.side), carried.turns)
            break
        except StartError:
            continue
    if states is None:
        states = states_of(carried.run(carried.leaves))
    tail: np.ndarray = states[carried.turns // 2 :]
    returned = len(tail) - carried.outside(tail) > LEAST
    return CrisisKind.INTERIOR if returned else CrisisKind.BOUNDARY
