"""Name a motion from its stroboscopic record: P(m;s1:...:sm), contact, aperiodic or undecided.

An mT-periodic orbit has s_i impacts in its i-th period of the cam, `inf` where that period holds a
complete chatter. Of its m rotations the one that is largest in lexical order is the name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from math import inf

import numpy as np

from camcli.analysis.integrate import Record
from camcli.errors import Status
from camcli.kernel.returns import CLOSE, LONGEST_PERIOD

CONTACT, APERIODIC, UNDECIDED = "contact", "aperiodic", "undecided"  # labels without symbols
MOST_SYMBOLS = 1_000_000  # of a label in a file
REMEMBERED = 1024  # labels
FEWEST_IMPACTS = 16  # in the record, to call it aperiodic
FEWEST_TURNS = 2 * LONGEST_PERIOD + 2  # in it, so that the longest period would show twice


class Label(str):
    """P(m;s1:...:sm) of these symbols; a string, so that it is compared and written as its text.

    Only what a user types is parsed. Words, colours and periods come from `symbols`, and a label
    without symbols (contact, aperiodic, undecided) is no `Label` but a plain string.

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
        m = len(self.symbols)
        found = self.symbols
        return any(m % d == 0 and found == found[:d] * (m // d) for d in range(1, m))

    def __reduce__(self) -> tuple:
        return Label, (self.symbols,)

    @classmethod
    def parse(cls, text: str) -> Label:
        """The label that a text of a user means, in any rotation; ValueError where it is none.

        At most LONGEST_PERIOD turns: orbits of more are not looked for.
        """
        close = re.sub(r"\s*([(;:)])\s*", r"\1", text.strip())
        found = re.fullmatch(r"P\((\d{1,9});((?:\d{1,9}|inf)(?::(?:\d{1,9}|inf))*)\)", close)
        counts = found[2].split(":") if found else []
        if not found or not int(found[1]) == len(counts) <= LONGEST_PERIOD:
            raise ValueError(f"found '{text}'")
        return cls(tuple(map(float, counts)))


def rotation(symbols: Sequence[float], tie: Callable[[int], tuple] = lambda first: ()) -> int:
    """Where the rotation begins that is largest in lexical order; ties go to the largest `tie`."""
    turned = [(*symbols[k:], *symbols[:k]) for k in range(len(symbols))]
    largest = max(turned)
    equal = [k for k, one in enumerate(turned) if one == largest]
    return equal[0] if len(equal) == 1 else max(equal, key=tie)


def period_of(label: str) -> int:
    """Turns after which a motion with this label repeats; 0 where it does not."""
    if isinstance(label, Label):
        return len(label.symbols)
    return 1 if label == CONTACT else 0


def to_plain(label: str) -> str | list[float]:
    """The label as plain values, for a file: its symbols, or the word that it is."""
    return list(label.symbols) if isinstance(label, Label) else label


def from_plain(stored: str | list[float]) -> str:
    """The label of these plain values; ValueError where they are none."""
    if isinstance(stored, str):
        if stored not in (CONTACT, APERIODIC, UNDECIDED):
            raise ValueError(f"found the label {stored!r:.40}")
        return stored
    if not isinstance(stored, list) or not 0 < len(stored) <= MOST_SYMBOLS:
        raise ValueError("expected a label")
    if not all(s == inf or (isinstance(s, int | float) and 0 <= s == int(s)) for s in stored):
        raise ValueError("expected a label of counts of impacts")
    return Label(stored)


def sections(record: Record) -> tuple[np.ndarray, list[float]]:
    """States at the strobes that begin whole turns, (turns, 2) in m, m/rad, and their symbols."""
    columns = record.strobe_q, record.strobe_w, record.impacts, record.chatter
    q, w, impacts, chatter = (column[: record.periods] for column in columns)
    return np.array((q, w)).T, np.where(chatter != 0, inf, impacts).tolist()


def passages(record: Record) -> tuple[list[tuple[float, float]], list[float]]:
    """The passages in numbers of Python, where an array has NumPy's."""
    states, symbols = sections(record)
    return list(map(tuple, states.tolist())), symbols


def label(record: Record) -> str:
    """The label of the orbit that a record repeats at its end (see `orbits.identify.named`).

    `contact` where the follower never leaves the cam. `aperiodic` where no period fits, `undecided`
    where the record is too short to say even that: a period longer than half of it would not show.
    Else the record repeats at its end after `record.repeats` turns, whose impacts are the symbols.
    """
    if record.periods and record.status == Status.OK and record.rests_throughout:
        return CONTACT
    if record.repeats == 0:
        long_enough = record.periods >= FEWEST_TURNS and record.hits >= FEWEST_IMPACTS
        return APERIODIC if long_enough else UNDECIDED
    last_period = slice(record.periods - record.repeats, record.periods)
    impacts = record.impacts[last_period].tolist()
    chatter = record.chatter[last_period].tolist()
    return _labelled(tuple(inf if c else float(s) for s, c in zip(impacts, chatter, strict=True)))


@lru_cache(maxsize=REMEMBERED)
def _labelled(symbols: tuple[float, ...]) -> Label:
    """The label of these symbols: neighbours in a sweep have the same."""
    return Label(symbols)


def returns(states: np.ndarray, longest: int) -> Iterator[tuple[int, float]]:
    """(turns, distance) of the shifts that bring the last state CLOSE to itself."""
    if n := min(longest, len(states) // 2):
        apart = _distances(states[-1], states[-2 : -2 - n : -1], states)
        yield from ((m + 1, float(apart[m])) for m in np.flatnonzero(apart <= CLOSE).tolist())


def _distances(a: np.ndarray, b: np.ndarray, states: np.ndarray) -> np.ndarray:
    """`same_orbit.distance` of many pairs, relative to the largest of all states."""
    size = np.abs(states).max(0)
    return (np.abs(a - b) / np.where(size > 0.0, size, 1.0)).max(1)
