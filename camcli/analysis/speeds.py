"""The result at one speed of a sweep, and those of many without their sections.

A row of speeds.csv takes some 1500 bytes as an object, and a fifth of that as a row of numbers. The
rows of a sweep whose pieces are on disk are on disk, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import nan
from struct import Struct
from typing import Any, NamedTuple

from camcli.analysis.integrate import Cost, Start
from camcli.analysis.loads import Loads
from camcli.errors import Status
from camcli.parallel.rows import Rows
from camcli.piece_faults import PieceFault

NOTHING = Loads()
NONE = -1  # among whole numbers, where there is none; among reals it is nan
FEW = 2_000  # speeds that are kept as objects, which is quicker; later ones are rows of numbers
REALS = 7 + len(Loads._fields)
COUNTS = 10
ROW = Struct(f"={REALS}d{COUNTS}q")


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

    The first `few` are kept as objects. Those after them are rows of ROW, see `_row`; a text stands
    there as its number among all different ones.
    cost: of all together.
    """

    def __init__(self, few: int = FEW, rows: Callable[[int], Rows] = Rows) -> None:
        """rows: makes rows of so many bytes, as `Work.rows` does."""
        self.few = few
        self.cost = Cost()
        self._first: list[Speed] = []
        self._rows = rows(ROW.size)
        self._texts: list[str] = []
        self._number_of: dict[str, int] = {}  # of each text
        self._faults: dict[int, PieceFault] = {}  # by the number of the row

    def __len__(self) -> int:
        return len(self._first) + len(self._rows)

    def append(self, speed: Speed) -> None:
        """Keep what a summary says of a speed."""
        self.cost = self.cost + speed.cost
        if len(self._first) < self.few:
            self._first.append(speed._replace(impacts=None, strobe=None))
            return
        if speed.fault is not None:
            self._faults[len(self._rows)] = speed.fault
        self._rows.append(self._row(speed))

    def _row(self, speed: Speed) -> bytes:
        """The numbers of a speed: REALS reals, and COUNTS whole numbers."""
        end = speed.end
        reals = (
            *(speed.value, speed.rpm, speed.exponent, speed.exponent_error, *speed.loads),
            *((nan, nan, nan) if end is None else (end.q, end.v, end.theta)),
        )
        return ROW.pack(
            *[nan if number is None else number for number in reals],
            *speed.cost,
            NONE if speed.impact_count is None else speed.impact_count,
            NONE if speed.watched is None else speed.watched,
            int(speed.status),
            int(speed.known),
            self._number(speed.label),
            self._number(speed.holds_for),
            self._number(None if end is None else end.place),
        )

    def _number(self, text: str | None) -> int:
        """The number of a text."""
        if text is None:
            return NONE
        number = self._number_of.setdefault(text, len(self._texts))
        if number == len(self._texts):
            self._texts.append(text)
        return number

    def _text(self, number: int) -> str | None:
        """The text of a number."""
        return None if number == NONE else self._texts[number]

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(len(self)))]
        k = range(len(self))[k]
        if k < len(self._first):
            return self._first[k]
        return self._from_row(k - len(self._first))

    def _from_row(self, k: int) -> Speed:
        """The speed that `_row` made row k of."""
        numbers = ROW.unpack(self._rows[k])
        value, rpm, *others = numbers[:REALS]
        theta = others.pop()
        others = [None if number != number else number for number in others]
        exponent, error, *loads, q, v = others
        impacts, evaluations, crossings, impact_count, watched, *codes = numbers[REALS:]
        status, known, label, holds_for, place = codes
        return Speed(
            value=value,
            rpm=rpm,
            label=self._texts[label],
            impact_count=None if impact_count == NONE else impact_count,
            status=Status(status),
            impacts=None,
            strobe=None,
            cost=Cost(impacts, evaluations, crossings),
            exponent=exponent,
            exponent_error=error,
            end=None if place == NONE else Start(q, v, theta, self._texts[place]),
            loads=Loads(*loads),
            known=bool(known),
            holds_for=self._text(holds_for),
            watched=None if watched == NONE else watched,
            fault=self._faults.get(k),
        )

    def chosen(self, order: Sequence[int]) -> Sequence[Speed]:
        """The speeds with these numbers, in this order; many are read only when asked for."""
        if len(order) <= self.few:
            return [self[k] for k in order]
        return Chosen(self, order)


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
