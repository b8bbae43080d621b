"""How much of its start an orbit remembers: the largest growth of a difference between two rests.

An orbit that rests on the cam leaves it at a phase known to rounding. If differences then grow by
more than doubles have digits, the next impacts are an accident of rounding, and that such a run
closes on itself says nothing about the machine.
"""

from __future__ import annotations

from math import inf

from camcli.analysis.engine import Tape
from camcli.kernel.exponents import AREA, FIRST, log_growth, stretch_log
from camcli.kernel.orbit import CHATTER
from camcli.system import System

FORGOTTEN = 25.0  # natural logarithm of the growth (7e10) that leaves five digits of a phase


def forgets(system: System, rpm: float, tape: Tape, turns: int) -> bool:
    """True where a cycle of `turns` turns at the end of a record is an accident of rounding."""
    window = range(max(0, tape.periods - 2 * turns), tape.periods)
    return largest_growth(system, rpm, tape, window) > FORGOTTEN


def largest_growth(system: System, rpm: float, tape: Tape, window: range) -> float:
    """Natural logarithm of the largest growth since the last rest, in these turns of a record."""
    lane = system.lane(rpm, 1.0, 1)
    pair, largest = [0.0] * 7, -inf
    growth = _fresh()
    columns = zip(tape.kind, tape.period, tape.theta, tape.q, tape.u, strict=True)
    for kind, period, theta, q, u in columns:
        if period not in window:
            continue
        row = [float(theta), float(q), float(u)]
        stretch_log(system.cam, lane, [int(kind), int(period)], row, 1, pair, growth)
        if kind == CHATTER:
            growth = _fresh()
        elif growth[FIRST] > 0.0:
            largest = max(largest, log_growth(growth, FIRST))
    return largest


def _fresh() -> list[float]:
    growth = [0.0] * 7
    growth[FIRST] = growth[AREA] = 1.0
    return growth
