"""Speeds at which a chatter's end, or one of its impacts, reaches a corner or the next release.

Where the end comes up to the phase at which contact is lost again, the chatter is complete no
longer: the chatter that ends at the point of release (Dankowicz & Fotsch, Procedia IUTAM 20 (2017)
18). The corners are those of the cam-follower example (Osorio, di Bernardo & Santini,
arXiv:0711.1008).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf

from camcli.analysis.bracketing import bracket
from camcli.analysis.contact_loss.bursts import JUST_ABOVE, Bursts, SettledMotion
from camcli.analysis.contact_loss.detachment import CriticalQuantity, CriticalSpeed, SpeedStatus
from camcli.cams.regions import SAME_PHASE, Corner, corner_list
from camcli.errors import Status
from camcli.kernel.cam_table import TURN

# rad: a phase this close to its goal has come up to it. The bracket of the speed is NARROW, 1e-12,
# and at a point of release or a graze a phase moves with the root of the speed: some 1e-5.
AT = 1e-4
FAR = 10.0 * TURN  # stands for a burst that does not accumulate


@dataclass(frozen=True)
class CornerHit:
    """Impact `impact` (1 is the first after lift-off) lands on `corner`; value and bracket in rpm.

    Status JUMP: the curve ends here, the impact ceases to exist or to come first (a graze), and
    `ends` are the phases (rad) of impact number `impact` on both sides.
    """

    impact: int
    corner: str
    rpm: float
    low: float
    high: float
    status: SpeedStatus
    burst: str
    ends: tuple[float, float] | None = None


def corners_ahead(bursts: Bursts) -> list[tuple[Corner, float]]:
    """(corner, its phase unrolled from the release on, rad) in the order a burst meets them."""
    ahead_of = []
    for corner in corner_list(bursts.system.cam):
        ahead = corner.theta - bursts.theta
        if abs(ahead) >= SAME_PHASE:
            ahead_of.append((corner, corner.theta if ahead > 0.0 else corner.theta + TURN))
    return sorted(ahead_of, key=lambda pair: pair[1])


def scan_speeds(opens: float, region: str, speeds: Sequence[SettledMotion]) -> list[float]:
    """Where to look for changes of the bursts of one region: ascending speeds, rpm.

    The longest row of neighbouring speeds at which the settled motion has such a burst, complete,
    the speed after it, and before it the opening speed itself.
    """
    ascending = sorted(speeds, key=lambda speed: speed.rpm)
    rows: list[list[int]] = [[]]  # numbers of neighbouring speeds that have such a burst
    for k, speed in enumerate(ascending):
        if any(burst.region == region and burst.end is not None for burst in speed.bursts):
            rows[-1].append(k)
        else:
            rows.append([])
    row = max(rows, key=len)
    if not row:
        return []
    first, last = row[0], row[-1]
    scan = [speed.rpm for speed in ascending[first : last + 2]]
    before = ascending[first - 1].rpm if first > 0 else inf
    just_above = opens * (1.0 + JUST_ABOVE)
    if before <= opens and just_above < scan[0]:
        return [just_above, *scan]
    return scan


def reaching(
    bursts: Bursts, corner: Corner, goal: float, speeds: Sequence[float]
) -> Iterator[CriticalSpeed]:
    """Every change, between neighbours of `speeds`, of "the burst accumulates before the corner".

    goal: the corner's phase as `corners_ahead` has it. Status JUMP where the end of the chatter
    jumps over it instead of coming up to it.
    """

    def excess(rpm: float) -> float:
        return min(bursts.at(rpm).end, FAR) - goal

    for _, where in _changes(bursts, excess, speeds):
        yield CriticalSpeed(
            CriticalQuantity.ACCUMULATION, corner.name, corner.theta, *where, bursts.name
        )


def completion_loss(bursts: Bursts, speeds: Sequence[float]) -> Iterator[CriticalSpeed]:
    """Where the burst's end reaches, one turn later, the phase at which the next one begins."""

    def excess(rpm: float) -> float:
        burst = bursts.at(rpm)
        if burst.release == inf:  # contact is never lost at this speed
            return FAR
        return min(burst.end, FAR) - burst.release - TURN  # below 0: at rest before the next one

    for last, where in _changes(bursts, excess, speeds):
        theta = bursts.at(last).release  # at the last complete speed the burst ends here too
        yield CriticalSpeed(
            CriticalQuantity.COMPLETION_LOSS, bursts.name, theta, *where, bursts.name
        )


def _changes(
    bursts: Bursts, excess: Callable[[float], float], speeds: Sequence[float]
) -> Iterator[tuple[float, tuple[float, float, float, SpeedStatus]]]:
    """For every change of sign of `excess` between neighbours: where it is, in two parts.

    The first is the end of the bracket at which excess < 0, rpm. The second has the fields of
    `CriticalSpeed` from rpm on: (middle of the bracket, its low end, its high end, status).
    """
    values = [(rpm, excess(rpm)) for rpm in speeds]
    for (a, e_a), (b, e_b) in pairwise(values):
        if (e_a < 0.0) == (e_b < 0.0):
            continue
        if e_a < 0.0:
            low, high, e_low, e_high = bracket(excess, a, b, e_a, e_b)
            last = low
        else:  # the order of the speeds is turned round by the sign
            low, high, e_low, e_high = bracket(lambda x: excess(-x), -b, -a, e_b, e_a)
            low, high, last = -high, -low, -low
        status = SpeedStatus.OK if min(-e_low, e_high) < AT else SpeedStatus.JUMP
        if any(bursts.at(rpm).status != Status.OK for rpm in (low, high)):
            status = SpeedStatus.UNRESOLVED
        yield last, (0.5 * (low + high), low, high, status)


def corner_hits(
    bursts: Bursts, corner: Corner, goal: float, low: float, high: float, count: int
) -> Iterator[CornerHit]:
    """Hits of impacts 1..count on the corner, at phase `goal`, for speeds from `low` to `high`.

    `low`: a speed at which the whole burst lies before the corner. At the root for n, impact n + 1
    lies behind it, so its root lies between `low` and that for n. An impact that is still before
    the corner at `high` has its hit beyond the range.
    """
    for n in range(1, count + 1):

        def excess(rpm: float, n: int = n) -> float:
            burst = bursts.at(rpm, n)
            at = burst.impacts[n - 1] if len(burst.impacts) >= n else min(burst.end, FAR)
            return at - goal

        e_low = excess(low)
        e_high = excess(high)
        if not e_low < 0.0 <= e_high:
            continue
        a, b, e_a, e_b = bracket(excess, low, high, e_low, e_high)
        status = SpeedStatus.OK
        ends = None
        if min(-e_a, e_b) >= AT:
            status = SpeedStatus.JUMP
            ends = (e_a + goal, e_b + goal)
        yield CornerHit(n, corner.name, 0.5 * (a + b), a, b, status, bursts.name, ends)
        high = b
