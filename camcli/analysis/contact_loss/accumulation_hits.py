"""Speeds at which the n-th impact of a burst lands on a corner, followed from n to n + 1.

Where the burst's end reaches the corner, at speed w, all its impacts lie before the corner; at the
root for n, impact n + 1 lies behind it. So the root for n + 1 lies between w and the root for n.
"""

from __future__ import annotations

from dataclasses import dataclass

from camcli.analysis.bracketing import bracket
from camcli.analysis.contact_loss.accumulation import FAR, Goal
from camcli.analysis.contact_loss.burst import Bursts
from camcli.analysis.contact_loss.detachment import JUMP, OK
from camcli.analysis.contact_loss.force import DEG

AT = 1e-7  # rad: a landing this close to the corner, at a bracket of relative 1e-12, is on it


@dataclass(frozen=True)
class Hit:
    """Impact `impact` (1 is the first after lift-off) lands on `corner`; rpm.

    Status `jump`: the curve ends here, the impact ceases to exist or to come first (a graze).
    """

    impact: int
    corner: str
    rpm: float
    low: float
    high: float
    status: str
    burst: str
    ends_deg: tuple[float, float] | None = None  # phase of the impact on both sides of a jump


def corner_hits(bursts: Bursts, goal: Goal, low: float, high: float, count: int) -> list[Hit]:
    """Hits of impacts 1..count on the goal for speeds from `low` to `high`.

    `low`: a speed at which the whole burst lies before the goal. An impact that is still before
    the goal at `high` has its hit beyond the range.
    """
    hits = []
    for n in range(1, count + 1):

        def excess(rpm: float, n: int = n) -> float:
            burst = bursts.at(rpm, n)
            if len(burst.impacts) >= n:
                return burst.impacts[n - 1] - goal.theta
            return min(burst.end, FAR) - goal.theta

        e_low, e_high = excess(low), excess(high)
        if not e_low < 0.0 <= e_high:
            continue
        a, b, e_a, e_b = bracket(excess, low, high, e_low, e_high)
        good = min(-e_a, e_b) < AT
        ends = None if good else ((e_a + goal.theta) * DEG, (e_b + goal.theta) * DEG)
        hits.append(Hit(n, goal.name, 0.5 * (a + b), a, b, OK if good else JUMP, bursts.name, ends))
        high = b
    return hits
