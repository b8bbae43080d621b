"""Why a chaotic attractor changes size at once, or is lost, between two speeds.

A crisis (Grebogi, Ott & Yorke, Physica D 7 (1983) 181): the attractor, closure of the unstable
manifold W^u of an orbit B in it, meets the stable manifold W^s of a saddle p one side of which
leads out (`tangency`).

The cam-follower example (Osorio, di Bernardo & Santini, arXiv:0711.1008):
740.1065 rpm, P(7;1:1:1:1:1:1:1) of multiplier 12.6, corner c; 361.1673, P(3;3:3:2), 35.9, smooth;
682.2046, P(1;1) on A1, 1.176, corner b, chaos is lost; runs of 3 or 4 million turns agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import NamedTuple

from camcli.analysis.explain.attractor import LEAST, CarriedAttractor, states_of
from camcli.analysis.explain.saddles import LostError, find_saddles, inner_side
from camcli.analysis.explain.tangency import USUAL, Fold, Folds, Sampling, first_touch
from camcli.analysis.integrate import Cost, Settings, StartError
from camcli.analysis.labels import APERIODIC, label
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.same_orbit import same_orbit
from camcli.cams.regions import Corner
from camcli.system import System

TURNS = 200_000  # of each run, unless told otherwise
CALM = 0.8  # of the way to the change: the speed at which saddles are looked for
BESIDE = (1e-6, 1e-8, 1e-10)  # relative: starts beside the saddle, on the side that leads out


class CrisisKind(StrEnum):
    """What becomes of the chaotic attractor carried between the speeds, and by what.

    INTERIOR, BOUNDARY: it meets a saddle, and what leaves comes back or is lost. UNEXPLAINED: it
    changes, no cause is found. STAYS: nothing leaves its range. NOT_CHAOTIC: there is no such
    attractor.
    """

    INTERIOR = "interior-crisis"
    BOUNDARY = "boundary-crisis"
    UNEXPLAINED = "unexplained"
    STAYS = "stays"
    NOT_CHAOTIC = "not-chaotic"


@dataclass(frozen=True)
class MetSaddle:
    """A saddle, as it is at rpm +- error, where a fold of the attractor touches its W^s."""

    orbit: PeriodicOrbit
    rpm: float
    error: float


@dataclass(frozen=True)
class Crisis:
    """The change found, at rpm +- error.

    error: rpm, of a crisis an estimate of how much earlier a fold that was not sampled may touch
    (`tangency.width`), otherwise the distance to the runs, inf where nothing happens; bracket: rpm,
    the last run of so many `turns` that stays and the first that leaves, carried from `near`;
    corner: whose image touches W^s, None for a smooth fold. inside, beyond: how many saddles were
    seen in the attractor and beyond it; of those that lead out, met: ordered from the near end;
    unmet: no fold was seen to touch; lost: could not be followed.
    """

    kind: CrisisKind
    rpm: float
    error: float
    bracket: tuple[float, float]
    near: float
    turns: int
    cost: Cost
    corner: Corner | None = None
    inside: int = 0
    beyond: int = 0
    met: tuple[MetSaddle, ...] = ()
    unmet: tuple[PeriodicOrbit, ...] = ()
    lost: int = 0


def find_crisis(
    system: System,
    settings: Settings,
    near: float,
    far: float,
    turns: int = TURNS,
    sampling: Sampling = USUAL,
) -> Crisis:
    """The crisis between two speeds (rpm) of the attractor carried from `near`.

    That end is the side on which the attractor is the smaller one, or exists at all: the start of
    the scene settles on it there. turns: of each run; sampling: how thoroughly folds are looked
    for. Raises StartError for a start below the cam.
    """
    carried = CarriedAttractor(system, settings, near, far, turns)
    near_run, far_run = carried.ends
    chaotic = label(near_run) == APERIODIC
    if not chaotic or not carried.has_left(far_run):
        kind = CrisisKind.STAYS if chaotic else CrisisKind.NOT_CHAOTIC
        return Crisis(kind, far, inf, (near, far), near, turns, carried.cost)
    carried.narrow()
    calm = near + CALM * (carried.stays - near)
    calm_run = carried.run(calm, events=True)
    carried.measure(calm, calm_run)
    inside = find_saddles(system, calm, calm_run, carried.size)
    run_that_leaves = carried.run(carried.leaves, events=True)
    beyond = find_saddles(system, calm, run_that_leaves, carried.size)
    # W^u of an orbit whose multiplier is below -1 goes both ways
    bases = [orbit for orbit in inside if orbit.multipliers[0].real < -1.0] or inside
    new = [orbit for orbit in beyond if not any(same_orbit(orbit, other) for other in inside)]
    seen = Tangencies()
    if bases:
        seen = _tangencies(carried, calm, bases[0], [*inside, *new], sampling)
    kind = CrisisKind.UNEXPLAINED
    rpm = carried.leaves
    error = abs(carried.leaves - carried.stays)
    corner = None
    if seen.touched:
        earliest = seen.touched[0]
        rpm = earliest.fold.rpm
        error = earliest.error
        kind = _kind(earliest.folds, rpm)
        corner = earliest.folds.corner(earliest.fold)
    return Crisis(
        kind=kind,
        rpm=rpm,
        error=error,
        bracket=(carried.stays, carried.leaves),
        near=near,
        turns=turns,
        cost=carried.cost,
        corner=corner,
        inside=len(inside),
        beyond=len(beyond),
        met=tuple(MetSaddle(one.saddle(), one.fold.rpm, one.error) for one in seen.touched),
        unmet=tuple(seen.unmet),
        lost=seen.lost,
    )


class Touched(NamedTuple):
    """Where the attractor's edge first touches the stable manifold of a saddle.

    folds: the attractor's edge against that saddle's manifold; fold: where they touch, and at what
    speed; error: of that speed, rpm.
    """

    folds: Folds
    fold: Fold
    error: float

    def saddle(self) -> PeriodicOrbit:
        """The saddle at the speed of the tangency."""
        _, saddle = self.folds.at(self.fold.rpm)
        return saddle.orbit


class Tangencies(NamedTuple):
    """What the attractor's edge meets.

    touched: where it touches, the nearest to the attractor's speed first; unmet: saddles that it
    does not touch; lost: how many saddles could not be followed.
    """

    touched: Sequence[Touched] = ()
    unmet: Sequence[PeriodicOrbit] = ()
    lost: int = 0


def _tangencies(
    carried: CarriedAttractor,
    calm: float,
    base: PeriodicOrbit,
    saddles: Sequence[PeriodicOrbit],
    sampling: Sampling,
) -> Tangencies:
    """Where the attractor's edge touches the stable manifolds of saddles that lead out.

    base: the saddle in the attractor whose unstable manifold is the attractor's edge. calm: the
    speed (rpm) at which the saddles were found.
    """
    touched = []
    unmet = []
    lost = 0
    for saddle in saddles:
        try:
            side = inner_side(carried, calm, saddle)
            if side == 0.0:
                continue
            folds = Folds(carried, base, saddle, side, sampling)
            tangency = first_touch(folds, calm) or first_touch(folds, carried.stays)
        except LostError:
            lost += 1
            continue
        if tangency is None:
            unmet.append(saddle)
        else:
            touched.append(Touched(folds, tangency.fold, tangency.error))
    touched.sort(key=lambda one: carried.way(one.fold.rpm))
    return Tangencies(touched, unmet, lost)


def _kind(folds: Folds, rpm: float) -> CrisisKind:
    """Interior where what leaves along the saddle comes back to the box, boundary where it is lost.

    Starts beside the saddle that lie below the cam are passed over. Where all of them do, the run
    that left the attractor is asked instead.
    """
    carried = folds.carried
    _, saddle = folds.at(rpm)
    for beside in BESIDE:
        try:
            states = carried.states(rpm, saddle.leaf(0.0, -beside * folds.side), carried.turns)
            break
        except StartError:
            continue
    else:
        states = states_of(carried.run(carried.leaves))
    tail = states[carried.turns // 2 :]
    returned = len(tail) - carried.outside(tail) > LEAST
    return CrisisKind.INTERIOR if returned else CrisisKind.BOUNDARY
