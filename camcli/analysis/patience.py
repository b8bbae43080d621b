"""How long a motion is followed before it is called aperiodic: the one rule of all commands.

Chaos beside a stable orbit may be a transient of many thousand turns, and a chaotic motion may come
to a rest once in as many: from there on it repeats itself. So a motion whose record looks aperiodic
is followed on, the same orbit to the last bit, for `Settings.patience` turns. It is aperiodic where
it has neither settled nor rested then. A longer one may still end: how long it was seen is said.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camcli.analysis.exponents import Exponents, of_record
from camcli.analysis.integrate import Cost, Orbit, Record, follow_on
from camcli.analysis.labels import FEWEST_TURNS, UNDECIDED, label
from camcli.analysis.orbits.identify import identify, named
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.errors import Status

LOOK = 2_000  # turns after which it is looked whether the motion has settled
LOOKS_AT_ONCE = 10  # in one call of the kernel, at most


@dataclass(frozen=True)
class Watched:
    """A motion that was followed on.

    turns: so many; record: the last ones, or those from the first rest on, None without patience;
    orbit: what they are of, where it is solved; stays: True where it neither settled nor rested nor
    met numerical trouble.
    """

    turns: int
    record: Record | None
    orbit: PeriodicOrbit | None
    stays: bool
    cost: Cost


def watch(orbit: Orbit, rpm: float, patience: int, recorded: int) -> Watched:
    """Follow an orbit on for `patience` turns, or until it settles or rests.

    orbit: at the end of its record; recorded: turns of the record that shows what became of it.
    """
    turns = 0
    cost = Cost()
    while turns < patience:
        left = min(patience - turns, LOOKS_AT_ONCE * LOOK)
        parts = [min(LOOK, left - begin) for begin in range(0, left, LOOK)]
        followed = follow_on(orbit, parts)
        for _, record in followed:
            cost = cost + record.cost
        *before, (ahead, record) = followed
        if before:  # whole parts in which the motion neither settled nor rested
            orbit, _ = before[-1]
            turns += LOOK * len(before)
        rests = np.flatnonzero(record.chatter[: record.periods])
        if len(rests):
            first = int(rests[0])  # the chatter ends in this turn; it may begin in the one before
            shown = orbit.go_on(max(0, first - 1), recorded).run()
            settled = identify(orbit.system, rpm, shown)
            return Watched(turns + first + 1, shown, settled, False, cost + shown.cost)
        turns += record.periods
        if record.status != Status.OK:
            return Watched(turns, record, None, False, cost)
        orbit = ahead
        if turns == patience or record.repeats:  # out of patience, or it looks periodic
            end = orbit.go_on(0, recorded).run()
            cost = cost + end.cost
            settled = identify(orbit.system, rpm, end)
            if settled is not None or turns == patience:
                stays = settled is None and end.status == Status.OK and not _calms(orbit, rpm, end)
                return Watched(turns, end, settled, stays, cost)
    return Watched(0, None, None, True, cost)  # no patience at all


def _calms(orbit: Orbit, rpm: float, record: Record) -> bool:
    """True where differences shrink in a record, or it rests: it is leaving the chaos."""
    exponents = of_record(orbit.system, rpm, record)
    return exponents is not None and exponents.largest + 3.0 * exponents.spread < 0.0


def forgets_too_much(record: Record) -> bool:
    """True where a complete chatter in some turns is followed by turns without.

    A rest erases all memory, and the turns up to the next one may grow an error of rounding beyond
    all digits: the record is then one of many. Where every turn rests they have no time to.
    """
    return record.status == Status.OK and 0 < record.chatters < record.periods


def named_on(
    orbit: Orbit,
    rpm: float,
    record: Record,
    measured: bool = False,
    longer: Record | None = None,
) -> tuple[str, Exponents | None, Record]:
    """(label, exponents, record): what a motion is called, and the record that this was told by.

    orbit: at the end of the record. A record that is too short to name anything is put aside: the
    turns after it are named in its place (longer: those of `turns_after`, where they are at hand).
    measured: see `identify.named`.
    """
    name, exponents = named(orbit.system, rpm, record, measured)
    if name != UNDECIDED or not _is_short(record):
        return name, exponents, record
    longer = turns_after(orbit).run() if longer is None else longer
    name, exponents = named(orbit.system, rpm, longer, measured)
    return name, exponents, longer


def cost_beyond(record: Record, named_by: Record) -> Cost:
    """What it cost beyond a record to name its motion; named_by: the record of `named_on`."""
    return Cost() if named_by is record else named_by.cost


def turns_after(orbit: Orbit) -> Orbit:
    """The orbit from the end of a record on, over as many turns as a label takes."""
    return orbit.go_on(0, FEWEST_TURNS)


def names_nothing(record: Record) -> bool:
    """Whether a record is too short to name anything, and shows no period."""
    return _is_short(record) and label(record) == UNDECIDED


def _is_short(record: Record) -> bool:
    return record.periods < FEWEST_TURNS and record.status == Status.OK
