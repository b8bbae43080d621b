"""The result at one speed of a sweep, and those of many without their sections.

A row of speeds.csv takes some 1500 bytes as an object and a quarter of that in columns, which is
what a sweep of a hundred thousand speeds keeps of them.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from math import nan
from typing import Any, NamedTuple

from camcli.analysis.integrate import Cost, Start
from camcli.analysis.labels import APERIODIC, UNDECIDED
from camcli.analysis.loads import Loads
from camcli.errors import Status
from camcli.piece_faults import PieceFault

NOTHING = Loads()
NONE = -1  # in a column of counts, where there is none; in one of numbers it is nan
FEW = 2_000  # speeds that are kept as objects, which is quicker; later ones are in columns
REALS = 4 + len(Loads._fields)  # numbers of a speed
COUNTS = 7


class Speed(NamedTuple):
    """Result at one speed, or at one value of what is varied instead.

    Columns are arrays: rad -> deg, m, m/s already converted.
    impacts: (period, theta_deg, q_m, u_minus_m_per_s); strobe: (period, q_m, v_m_per_s, impacts,
    chatter). Either is None where it was not asked for. `impact_count` is of the recorded turns;
    exponent: the largest one per turn, and exponent_error its standard error, None where it was not
    asked for or is not known; end: where the next speed starts, of a sweep that carries its state;
    loads: of the record; known: False
    where the record is one of many motions and the true one is not known; holds_for, watched: as
    `classify`, but inside a range of aperiodic motions one is seen for its record only; fault: what
    nobody foresaw and cost this speed: its status is FAULT then, and nothing of the
    motion is known (no impact_count; rpm is nan where even the machine could not be made).
    """

    value: float
    rpm: float
    label: str
    impact_count: int | None
    status: int
    impacts: tuple | None
    strobe: tuple | None
    cost: Cost
    exponent: float | None = None
    exponent_error: float | None = None
    end: Start | None = None
    loads: Loads = NOTHING
    known: bool = True
    holds_for: str | None = None
    watched: int | None = None
    fault: PieceFault | None = None


class SpeedColumns(Sequence[Speed]):
    """Speeds without their sections; `append` takes any speed.

    The first `few` are kept as objects, those after them in columns: REALS numbers and COUNTS whole
    numbers of each, one speed after the other, and what few speeds have by its place among these.
    labels: of all speeds, in the same order.
    """

    def __init__(self, few: int = FEW) -> None:
        self.few = few
        self.labels: list[str] = []
        self._first: list[Speed] = []
        # of those in columns
        self._holds_for: list[str | None] = []
        self._reals = array("d")  # value, rpm, exponent, exponent_error, and the loads
        self._counts = array("q")  # impacts, evaluations, crossings (`Cost`), impact_count,
        # watched, status, known
        self._texts: dict[str | None, str | None] = {}  # equal texts are one object
        self._ends: dict[int, Start] = {}
        self._faults: dict[int, PieceFault] = {}

    def __len__(self) -> int:
        return len(self.labels)

    def append(self, speed: Speed) -> None:
        """Keep what a summary says of a speed."""
        self.labels.append(self._texts.setdefault(speed.label, speed.label) or "")
        if len(self._first) < self.few:
            self._first.append(speed._replace(impacts=None, strobe=None))
            return
        place = len(self._holds_for)
        reals = (speed.value, speed.rpm, speed.exponent, speed.exponent_error, *speed.loads)
        self._reals.extend([nan if number is None else number for number in reals])
        self._counts.extend(
            (
                speed.cost.impacts,
                speed.cost.evaluations,
                speed.cost.crossings,
                NONE if speed.impact_count is None else speed.impact_count,
                NONE if speed.watched is None else speed.watched,
                int(speed.status),
                int(speed.known),
            )
        )
        self._holds_for.append(self._texts.setdefault(speed.holds_for, speed.holds_for))
        if speed.end is not None:
            self._ends[place] = speed.end
        if speed.fault is not None:
            self._faults[place] = speed.fault

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(len(self)))]
        k = range(len(self))[k]
        if k < len(self._first):
            return self._first[k]
        return self._from_columns(k - len(self._first), self.labels[k])

    def _from_columns(self, place: int, label: str) -> Speed:
        """The speed of a label at a place among those in columns; see `append`."""
        reals = self._reals[REALS * place : REALS * (place + 1)]
        value, rpm, *others = reals
        exponent, error, *loads = [None if number != number else number for number in others]
        counts = self._counts[COUNTS * place : COUNTS * (place + 1)]
        impacts, evaluations, crossings, impact_count, watched, status, known = counts
        return Speed(
            value=value,
            rpm=rpm,
            label=label,
            impact_count=None if impact_count == NONE else impact_count,
            status=Status(status),
            impacts=None,
            strobe=None,
            cost=Cost(impacts, evaluations, crossings),
            exponent=exponent,
            exponent_error=error,
            end=self._ends.get(place),
            loads=Loads(*loads),
            known=bool(known),
            holds_for=self._holds_for[place],
            watched=None if watched == NONE else watched,
            fault=self._faults.get(place),
        )

    def value(self, k: int) -> float:
        """The value of what is varied, of speed k."""
        if k < len(self._first):
            return self._first[k].value
        return self._reals[REALS * (k - len(self._first))]

    def in_chaos(self, k: int) -> bool:
        """Whether the motion of speed k looks aperiodic, or came to a rest among such."""
        if self.labels[k] in (UNDECIDED, APERIODIC):
            return True
        if k < len(self._first):
            return bool(self._first[k].holds_for)
        return bool(self._holds_for[k - len(self._first)])

    @property
    def cost(self) -> Cost:
        """Of all together."""
        impacts, evaluations, crossings = (sum(self._counts[n::COUNTS]) for n in range(3))
        return sum((speed.cost for speed in self._first), Cost(impacts, evaluations, crossings))

    def chosen(self, order: Sequence[int]) -> Sequence[Speed]:
        """The speeds with these numbers, in this order; many are read only when asked for."""
        if len(order) <= self.few:
            return [self[k] for k in order]
        return Chosen(self, array("q", order))


class Chosen(Sequence[Speed]):
    """Some of a sequence of speeds, in another order."""

    def __init__(self, speeds: Sequence[Speed], order: Sequence[int]):
        self._speeds = speeds
        self._order = order

    def __len__(self) -> int:
        return len(self._order)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self._speeds[n] for n in self._order[k]]
        return self._speeds[self._order[k]]
