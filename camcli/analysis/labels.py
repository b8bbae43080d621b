"""Name a motion from its stroboscopic record: P(m;s1:...:sm), contact, aperiodic or undecided.

An mT-periodic orbit has s_i impacts in its i-th period of the cam, `inf` where that period holds a
complete chatter. Of its m rotations the one that is largest in lexical order is the name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import inf

import numpy as np

from camcli.analysis.integrate import Record
from camcli.analysis.orbits.same_orbit import CLOSE, SAME, State, distance, size_of
from camcli.errors import Status

CONTACT, APERIODIC, UNDECIDED = "contact", "aperiodic", "undecided"  # labels without symbols
LONGEST_PERIOD = 64
WINDOW = 16  # periods compared at least
FEWEST_IMPACTS = 16  # in the record, to call it aperiodic
LIMIT_SHARE = 0.1  # what extrapolation may leave of a distance that is still shrinking
SLOWEST = 0.97  # ratio of distances from a quarter of the record to the next


class Label(str):
    """P(m;s1:...:sm) of these symbols; a string, so that it is compared and written as its text.

    symbols: impacts in each period of the cam, in the order of the name, `inf` for a complete
    chatter.
    """

    symbols: tuple[float, ...]

    def __new__(cls, symbols: Sequence[float]) -> Label:
        first = rotation(symbols)
        named = (*symbols[first:], *symbols[:first])
        words = ":".join("inf" if s == inf else str(int(s)) for s in named)
        label = super().__new__(cls, f"P({len(named)};{words})")
        label.symbols = named
        return label

    @property
    def repeats(self) -> bool:
        """True where the symbols are those of fewer turns, several times: P(2;1:1)."""
        m, found = len(self.symbols), self.symbols
        return any(m % d == 0 and found == found[:d] * (m // d) for d in range(1, m))

    def __reduce__(self) -> tuple:
        return Label, (self.symbols,)

    @classmethod
    def parse(cls, text: str) -> Label:
        """The label that a text means, in any rotation; ValueError where it is none."""
        close = re.sub(r"\s*([(;:)])\s*", r"\1", text.strip())
        found = re.fullmatch(r"P\((\d{1,9});((?:\d{1,9}|inf)(?::(?:\d{1,9}|inf))*)\)", close)
        counts = found[2].split(":") if found else []
        if not found or not int(found[1]) == len(counts) <= LONGEST_PERIOD:
            raise ValueError(f"found '{text}'")
        return cls(tuple(map(float, counts)))


def rotation(symbols: Sequence[float], tie: Callable[[int], tuple] = lambda first: ()) -> int:
    """Where the rotation begins that is largest in lexical order; ties go to the largest `tie`."""
    return max(range(len(symbols)), key=lambda k: ((*symbols[k:], *symbols[:k]), tie(k)))


def period_of(label: str) -> int:
    """Turns after which a motion with this label repeats; 0 where it does not."""
    if label == CONTACT:
        return 1
    return int(label[2:].partition(";")[0]) if label.startswith("P(") else 0


def passages(record: Record) -> tuple[list[tuple[float, float]], list[float]]:
    """States at the strobes that begin its whole turns (m, m/rad), and the symbols of these."""
    columns = record.strobe_q, record.strobe_w, record.impacts, record.chatter
    q, w, impacts, chatter = (column[: record.periods] for column in columns)
    symbols = np.where(chatter != 0, inf, impacts)
    return list(zip(q.tolist(), w.tolist(), strict=True)), symbols.tolist()


def label(record: Record) -> str:
    """The label of the attractor a record ends on.

    `aperiodic` where no period fits, `undecided` where the record is too short to say even that.
    """
    if record.periods and record.status == Status.OK and not record.touches:
        return CONTACT
    states, symbols = passages(record)
    m = find_period(states, symbols)
    if m == 0:
        impacts = record.impacts[: record.periods].sum()
        return APERIODIC if len(states) > 1 and impacts >= FEWEST_IMPACTS else UNDECIDED
    return Label(symbols[-m:])


def find_period(states: Sequence[State], symbols: Sequence[float]) -> int:
    """Smallest m whose shift repeats the record, or 0.

    A shift repeats where the symbols do and the states agree to SAME of their size, or approach
    each other geometrically with an extrapolated limit of nothing (slow multipliers).
    """
    n, size = len(states), size_of(states) if states else (1.0, 1.0)
    for m in range(1, min(LONGEST_PERIOD, n // 2) + 1):
        window = min(n - m, max(2 * m, WINDOW))
        if symbols[n - window :] != symbols[n - window - m : n - m]:
            continue
        if distance(states[-1], states[-1 - m], size) > CLOSE:
            continue
        before = states[n - window - m :]
        if all(distance(a, b, size) <= SAME for a, b in zip(before[m:], before, strict=False)):
            return m
        if symbols[m:] != symbols[:-m]:
            continue
        apart = [distance(a, b, size) for a, b in zip(states[m:], states, strict=False)]
        if apart[-1] <= SLOWEST * apart[(n - m) // 4] and _shrinks(apart, m):
            return m
    return 0


def _shrinks(distances: list[float], m: int) -> bool:
    """True where the largest distance of each quarter shrinks geometrically towards zero."""
    quarter = len(distances) // 4
    if quarter < 2 * m:
        return False
    d = [max(distances[k * quarter : (k + 1) * quarter]) for k in range(4)]
    if not all(after <= SLOWEST * before for before, after in pairwise(d)):
        return False
    bend = (d[3] - d[2]) - (d[2] - d[1])
    limit = d[3] - (d[3] - d[2]) ** 2 / bend if bend > 0.0 else d[3]
    return abs(limit) <= LIMIT_SHARE * d[3]
