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
from typing import NamedTuple

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
    """(corner, its phase counted on from the release, rad) in the order a burst meets them.

    The phase is the corner's own, or a turn more where it lies before the release.
    """
    corners = []
    for corner in corner_list(bursts.system.cam):
        ahead = corner.theta - bursts.theta
        if abs(ahead) >= SAME_PHASE:
            corners.append((corner, corner.theta if ahead > 0.0 else corner.theta + TURN))
    return sorted(corners, key=lambda pair: pair[1])


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

    for change in _changes(bursts, excess, speeds):
        yield change.as_speed(CriticalQuantity.ACCUMULATION, corner.name, corner.theta, bursts.name)


def completion_loss(bursts: Bursts, speeds: Sequence[float]) -> Iterator[CriticalSpeed]:
    """Where the burst's end reaches, one turn later, the phase at which the next one begins."""

    def excess(rpm: float) -> float:
        burst = bursts.at(rpm)
        if burst.release == inf:  # contact is never lost at this speed
            return FAR
        return min(burst.end, FAR) - burst.release - TURN  # below 0: at rest before the next one

    for change in _changes(bursts, excess, speeds):
        theta = bursts.at(change.below).release  # while still complete the burst ends here too
        yield change.as_speed(CriticalQuantity.COMPLETION_LOSS, bursts.name, theta, bursts.name)


class _Change(NamedTuple):
    """Where a phase passes its goal as the speed changes; rpm.

    It lies between low and high. below: the one of these at which the phase is before its goal.
    """

    low: float
    high: float
    below: float
    status: SpeedStatus

    def as_speed(
        self, quantity: CriticalQuantity, region: str, theta: float, burst: str
    ) -> CriticalSpeed:
        """The critical speed in the middle; see `CriticalSpeed` for what is given."""
        middle = 0.5 * (self.low + self.high)
        return CriticalSpeed(
            quantity, region, theta, middle, self.low, self.high, self.status, burst
        )


def _changes(
    bursts: Bursts, excess: Callable[[float], float], speeds: Sequence[float]
) -> Iterator[_Change]:
    """Every change of sign of `excess` between neighbouring speeds (rpm), bracketed.

    excess: the phase of the burst at a speed less that of its goal, rad.
    """
    values = [(rpm, excess(rpm)) for rpm in speeds]
    for (slower, e_slower), (faster, e_faster) in pairwise(values):
        if (e_slower < 0.0) == (e_faster < 0.0):
            continue
        if e_slower < 0.0:
            low, high, e_low, e_high = bracket(excess, slower, faster, e_slower, e_faster)
            below = low
        else:  # `bracket` wants the negative end first: minus the speed rises the other way
            minus_high, minus_low, e_low, e_high = bracket(
                lambda minus_speed: excess(-minus_speed), -faster, -slower, e_faster, e_slower
            )
            low, high = -minus_low, -minus_high
            below = high
        status = SpeedStatus.OK if min(-e_low, e_high) < AT else SpeedStatus.JUMP
        if any(bursts.at(rpm).status != Status.OK for rpm in (low, high)):
            status = SpeedStatus.UNRESOLVED
        yield _Change(low, high, below, status)


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
            """The phase of impact n, or where there is none of the burst's end, less the goal."""
            burst = bursts.at(rpm, n)
            phase = burst.impacts[n - 1] if len(burst.impacts) >= n else min(burst.end, FAR)
            return phase - goal

        e_low = excess(low)
        e_high = excess(high)
        if not e_low < 0.0 <= e_high:
            continue
        slower, faster, e_slower, e_faster = bracket(excess, low, high, e_low, e_high)
        status = SpeedStatus.OK
        ends = None
        if min(-e_slower, e_faster) >= AT:
            status = SpeedStatus.JUMP
            ends = (e_slower + goal, e_faster + goal)
        middle = 0.5 * (slower + faster)
        yield CornerHit(n, corner.name, middle, slower, faster, status, bursts.name, ends)
        high = faster
