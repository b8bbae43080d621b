"""What the motion after a rest leads to, as the census of one speed learns it on the way."""

from __future__ import annotations

import numpy as np

from camcli.analysis.basins import recurrence
from camcli.analysis.basins.attractor import Attractor, begin_where_label_does, is_one
from camcli.analysis.basins.cell_batches import Crew, Ends
from camcli.analysis.basins.rests import SAME, departure, excursions
from camcli.analysis.labels import Label
from camcli.kernel.cells import FORGOTTEN, GOES_ON, NEW_REST
from camcli.kernel.flight import BOUNCED, FREE

RECORD = 32_768  # states of the excursions from a rest


def follow_cells(census, gap, rate, budget: int, mode=None, share: bool = False) -> Ends:
    """Follow starts; `census` learns of the rests they stop at, and these starts begin again."""
    gap, rate = np.asarray(gap, dtype=float), np.asarray(rate, dtype=float)
    if mode is None:
        mode = np.where((gap > 0.0) | (rate < 0.0), FREE, BOUNCED)
    ends = census.crew.run(gap, rate, census.targets, budget, mode, share)
    while len(stopped := np.flatnonzero(ends.outcome == NEW_REST)):
        states = np.column_stack((ends.gap, ends.rate))[stopped]
        _, first = np.unique(states, axis=0, return_index=True)
        for k in stopped[first].tolist():
            if not census.rests.is_known(ends.gap[k], ends.rate[k]):
                start = float(gap[k]), float(rate[k]), int(mode[k])
                state = float(ends.gap[k]), float(ends.rate[k]), int(ends.mode[k])
                _learn(census, start, state, int(ends.turns[k]))
        more = census.crew.run(gap[stopped], rate[stopped], census.targets, budget, mode[stopped])
        for column in vars(ends):
            getattr(ends, column)[stopped] = getattr(more, column)
    return ends


def _learn(census, start, state, turns: int) -> None:
    """Find out what the (gap, rate, mode) after a rest, met by a start after `turns`, leads to.

    The doubles are believed where they remember; else the motion after the rest is followed with
    many digits, and the attractor it ends on admitted. Where all digits are lost before, it is
    aperiodic if no start beside it settles: they come back to a rest, each elsewhere.
    """
    end = GOES_ON
    if not census.rests.doubles_hold(census.targets, census.budget, *state):
        end = _end_of(census, truth(census.crew, census.rests.followed, start, turns))
        end = chaos(census, state) if end == FORGOTTEN else end
    census.rests.add(*state[:2], end)
    census.targets = census.rests.fill(census.targets)


def truth(crew: Crew, known: dict, start, turns: int):
    """What the motion after the rest leads to that a start (gap, rate, mode) comes to, or None.

    The rest's chatter ends in turn `turns`; `known`: what was found, by departure.
    """
    from camcli.analysis.after_rest import after_rest

    theta = departure(crew, *start, turns)
    if theta is None:
        return None
    place = round(theta / SAME)
    if place not in known:
        known[place] = after_rest(crew.system, crew.rpm, theta)
    return known[place]


def _end_of(census, found) -> int:
    """The attractor that a motion after a rest (`rest.after.After`) ends on, or FORGOTTEN."""
    if found is None:
        return FORGOTTEN
    if found.kind == "cycle":
        states, symbols = begin_where_label_does(found.states, found.symbols)
        cycle = Attractor(Label(symbols), found.turns, states, symbols, (0j, 0j))
        census._admit(cycle)
        return next((k for k, a in enumerate(census.attractors) if is_one(a, cycle)), FORGOTTEN)
    start = found.start(census.crew.system, census.crew.rpm)
    gap, rate = census.crew.states([start.q], [start.v]) if start else ([], [])
    for _ in range(2 * len(gap)):
        ends = census.crew.run(gap, rate, census.targets._replace(rests=-1), census.budget)
        if ends.outcome[0] >= 0:
            return int(ends.outcome[0])
        census._identify(float(ends.gap[0]), float(ends.rate[0]), float(ends.mode[0]))
    return FORGOTTEN


def chaos(census, state) -> int:
    """The aperiodic attractor that excursions from a rest make up, or FORGOTTEN."""
    ends, points = excursions(census.crew, census.targets, state, RECORD)
    met = {int(end) for end in ends if end != NEW_REST}
    if any(end < 0 or census.attractors[end].periodic for end in met):
        return FORGOTTEN
    if met:
        return min(met)
    if not recurrence.is_recurrent(points) or not census._take_up(points):
        return FORGOTTEN
    lift = np.array(census.crew.lift)
    return next(
        k
        for k, known in enumerate(census.attractors)
        if not known.periodic and recurrence.meet(known.points - lift, points)
    )
