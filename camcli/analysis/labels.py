"""Name a motion from its stroboscopic record: P(m;s1:...:sm), contact, aperiodic or undecided.

An mT-periodic orbit has s_i impacts in its i-th period of the cam, `inf` where that period holds a
complete chatter. Of its m rotations the one that is largest in lexical order is the name.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from math import inf

from camcli.analysis.integrate import Record
from camcli.analysis.orbits.same_orbit import CLOSE, SAME
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

    def __reduce__(self) -> tuple:
        return Label, (self.symbols,)

    @classmethod
    def parse(cls, text: str) -> Label:
        """The label that a text means, in any rotation; ValueError where it is none."""
        head, _, words = text.strip().removesuffix(")").partition(";")
        turns, counts = head.removeprefix("P(").strip(), [word.strip() for word in words.split(":")]
        whole = head.startswith("P(") and text.strip().endswith(")") and turns.isdecimal()
        if not whole or not all(word == "inf" or word.isdecimal() for word in counts):
            raise ValueError(f"found '{text}'")
        if int(turns) != len(counts) or len(counts) > LONGEST_PERIOD:
            raise ValueError(f"found '{text}'")
        return cls(tuple(inf if word == "inf" else float(int(word)) for word in counts))


def rotation(symbols: Sequence[float], tie: Callable[[int], tuple] = lambda first: ()) -> int:
    """Where the rotation begins that is largest in lexical order; ties go to the largest `tie`."""
    return max(range(len(symbols)), key=lambda k: ((*symbols[k:], *symbols[:k]), tie(k)))


def label(record: Record) -> str:
    """The label of the attractor a record ends on.

    `aperiodic` where no period fits, `undecided` where the record is too short to say even that.
    """
    n = record.periods
    if n == 0:
        return UNDECIDED
    if record.status == Status.OK and not record.touches:
        return CONTACT
    q, w = _plain(record.strobe_q)[:n], _plain(record.strobe_w)[:n]
    symbols = [
        inf if full else count
        for count, full in zip(_plain(record.impacts)[:n], _plain(record.chatter)[:n], strict=True)
    ]
    m = find_period(q, w, symbols)
    if m == 0:
        return APERIODIC if sum(_plain(record.impacts)[:n]) >= FEWEST_IMPACTS else UNDECIDED
    return Label(symbols[-m:])


def find_period(q: Sequence[float], w: Sequence[float], symbols: Sequence[float]) -> int:
    """Smallest m whose shift repeats the record, or 0.

    A shift repeats where the symbols do and the states agree to SAME of their size, or approach
    each other geometrically with an extrapolated limit of nothing (slow multipliers).
    """
    n = len(q)
    size_q = max(abs(value) for value in q) or 1.0
    size_w = max(abs(value) for value in w) or 1.0
    for m in range(1, min(LONGEST_PERIOD, n // 2) + 1):
        window = min(n - m, max(2 * m, WINDOW))
        if symbols[n - window :] != symbols[n - window - m : n - m]:
            continue

        def distance(k: int, m: int = m) -> float:
            return max(abs(q[k] - q[k - m]) / size_q, abs(w[k] - w[k - m]) / size_w)

        last = distance(n - 1)
        if last <= SAME and all(distance(k) <= SAME for k in range(n - window, n)):
            return m
        if last > CLOSE or last > SLOWEST * distance(m + (n - m) // 4):
            continue
        if symbols[m:] == symbols[:-m] and _shrinks([distance(k) for k in range(m, n)], m):
            return m
    return 0


def _shrinks(distances: list[float], m: int) -> bool:
    """True where the largest distance of each quarter shrinks geometrically towards zero."""
    quarter = len(distances) // 4
    if quarter < 2 * m:
        return False
    d = [max(distances[k * quarter : (k + 1) * quarter]) for k in range(4)]
    if not all(after <= SLOWEST * before for before, after in itertools.pairwise(d)):
        return False
    bend = (d[3] - d[2]) - (d[2] - d[1])
    limit = d[3] - (d[3] - d[2]) ** 2 / bend if bend > 0.0 else d[3]
    return abs(limit) <= LIMIT_SHARE * d[3]


def _plain(values) -> list:
    return values.tolist() if hasattr(values, "tolist") else list(values)
