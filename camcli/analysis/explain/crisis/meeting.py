"""Which saddle the attractor meets first: every one that leads out is tried."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

from camcli.analysis.explain.crisis.folds import Folds
from camcli.analysis.explain.crisis.manifold import LostError, Saddle
from camcli.analysis.explain.crisis.runs import LEAST, Carried, impacts_of, states_of
from camcli.analysis.explain.crisis.saddles import crossed_one_way, find_saddles, inner_side
from camcli.analysis.explain.crisis.tangency import STEP, Tangency, first_touch
from camcli.analysis.integrate import StartError
from camcli.analysis.orbits.find import same_orbit
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.cams.regions import Corner, corner_list

CALM = 0.8  # of the way to the change: the speed at which saddles are looked for
AT_CORNER = 1e-6  # rad: an impact so near a corner is at it
BESIDE = (1e-6, 1e-8, 1e-10)  # relative: starts beside the saddle, on the side that leads out

INTERIOR, BOUNDARY = "interior-crisis", "boundary-crisis"


@dataclass(frozen=True)
class Meeting:
    """The earliest fold that touches the stable manifold of one saddle."""

    folds: Folds
    tangency: Tangency


@dataclass
class Contact:
    """The saddles looked at: how many, those met, those that lead out unmet, and how many lost."""

    inside: int
    beyond: int
    met: list[Meeting] = field(default_factory=list)
    unmet: list[PeriodicOrbit] = field(default_factory=list)
    lost: int = 0

    @property
    def first(self) -> Meeting | None:
        """The one met first from the near end, None where none is."""
        return min(self.met, key=lambda m: m.folds.carried.way(m.tangency.rpm), default=None)


def contact(carried: Carried) -> Contact:
    """Solve the tangency with every saddle seen before or beyond the change that leads out.

    The manifold that is followed is that of the shortest orbit in the attractor whose multiplier
    is below -1, since its W^u goes both ways; else of the shortest one.
    """
    calm = carried.near + CALM * (carried.bracket[0] - carried.near)
    leaves = carried.bracket[1]
    inside = find_saddles(carried, calm, carried.run(calm, True))
    beyond = find_saddles(carried, calm, carried.run(leaves, True))
    bases = [orbit for orbit in inside if orbit.multipliers[0].real < -1.0] or inside
    result = Contact(len(inside), len(beyond))
    new = [orbit for orbit in beyond if not any(same_orbit(orbit, other) for other in inside)]
    for orbit in [*inside, *new] if bases else []:
        if crossed_one_way(orbit):
            _try(carried, result, calm, bases[0], orbit)
    return result


def _try(carried: Carried, result: Contact, calm: float, base, orbit) -> None:
    """Add what becomes of one saddle."""
    try:
        side = inner_side(carried, calm, orbit)
        if side == 0.0:
            return
        folds = Folds(carried, base, orbit, side)
        tangency = first_touch(folds, calm) or first_touch(folds, carried.bracket[0])
    except LostError:
        result.lost += 1
        return
    if tangency is None:
        result.unmet.append(orbit)
    else:
        result.met.append(Meeting(folds, tangency))


def corner_of(meeting: Meeting) -> Corner | None:
    """The corner whose image the fold is; None for a smooth fold."""
    folds, at = meeting.folds, meeting.tangency
    base, _ = folds.at(at.rpm)
    theta = impacts_of(folds.carried.motion(at.rpm, base.leaf(at.t), at.n, True))[0]
    corners = corner_list(folds.carried.system.cam)
    hit = [c for c in corners if np.abs(theta - c.theta).min(initial=inf) < AT_CORNER]
    return hit[0] if hit else None


def kind_of(meeting: Meeting, saddle: Saddle) -> str:
    """Interior where what leaves along the saddle comes back to the box, boundary where it is lost.

    saddle: the one met, at the solved speed.
    """
    carried = meeting.folds.carried
    states = _beside(meeting, saddle)
    tail = states[carried.turns // 2 :]
    return INTERIOR if len(tail) - carried.outside(tail) > LEAST else BOUNDARY


def _beside(meeting: Meeting, saddle: Saddle) -> np.ndarray:
    """States of a motion that leaves along the saddle; starts below the cam are passed over."""
    carried = meeting.folds.carried
    for beside in BESIDE:
        x = saddle.leaf(0.0, -beside * meeting.folds.side)
        try:
            return carried.states(meeting.tangency.rpm, x, carried.turns)
        except StartError:
            continue
    return states_of(carried.run(carried.bracket[1]))


def fold_beside(meeting: Meeting) -> tuple[float, float]:
    """eta of the fold a little before and a little after the solved speed."""
    folds, at = meeting.folds, meeting.tangency
    step = STEP * at.rpm * folds.carried.ahead
    before, after = (
        folds.lowest(at.rpm + move, at.n, at.t + at.slope * move, at.half)[0]
        for move in (-step, step)
    )
    return before, after
