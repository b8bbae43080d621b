"""Where chatter ends, and the speeds at which that phase reaches a corner or is lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from math import inf

from camcli import errors
from camcli.analysis.bracketing import bracket
from camcli.analysis.contact_loss.accumulation_range import COMPLETE, Settled
from camcli.analysis.contact_loss.burst import Bursts
from camcli.analysis.contact_loss.detachment import JUMP, OK, UNRESOLVED, Critical
from camcli.cams.regions import corner_list
from camcli.kernel.cam_table import TURN

AT = 1e-4  # rad: a phase this close to a corner, at a bracket of relative 1e-12, has reached it
FAR = 10.0 * TURN  # stands for a burst that does not accumulate
JUST_ABOVE = 1e-6


@dataclass(frozen=True)
class Goal:
    """A phase to be reached: a corner (unrolled from the release on), or the release itself."""

    name: str
    theta: float
    within: float  # the same phase within the turn


def corners_ahead(bursts: Bursts) -> list[Goal]:
    """Corners in the turn after lift-off, in the order a burst meets them."""
    goals = []
    for corner in corner_list(bursts.system.cam):
        ahead = corner.theta - bursts.theta
        if abs(ahead) < 1e-12:
            continue
        theta = corner.theta if ahead > 0.0 else corner.theta + TURN
        goals.append(Goal(corner.name, theta, corner.theta))
    return sorted(goals, key=lambda goal: goal.theta)


def scan_speeds(opens: float, region: str, speeds: Sequence[Settled]) -> list[float]:
    """Where to look for changes of the bursts of one region: ascending speeds.

    The longest row of neighbouring speeds at which the settled motion has such a burst, complete,
    the speed after it, and before it the opening speed itself.
    """
    speeds = sorted(speeds, key=lambda speed: speed.rpm)
    present = [(region, COMPLETE) in speed.bursts for speed in speeds]
    rows = [list(row) for there, row in groupby(range(len(speeds)), present.__getitem__) if there]
    if not rows:
        return []
    row = max(rows, key=len)
    scan = [speed.rpm for speed in speeds[row[0] : row[-1] + 2]]
    before = speeds[row[0] - 1].rpm if row[0] else inf
    just_above = opens * (1.0 + JUST_ABOVE)
    return [just_above, *scan] if before <= opens and just_above < scan[0] else scan


def reaching(bursts: Bursts, goal: Goal, speeds: list[float]) -> list[Critical]:
    """Every change, between neighbours of `speeds`, of "the burst accumulates before the goal".

    Status `jump` where the end of the chatter jumps over the goal instead of coming up to it.
    """
    return _changes(bursts, lambda rpm: _capped(bursts, rpm) - goal.theta, speeds, goal)


def completion_loss(bursts: Bursts, speeds: list[float]) -> list[Critical]:
    """Where the burst's end reaches, one turn later, the phase at which the next one begins."""

    def excess(rpm: float) -> float:
        release = bursts.at(rpm).release
        return _capped(bursts, rpm) - release - TURN if release < inf else FAR

    goal = Goal(bursts.name, bursts.theta + TURN, bursts.theta)
    return _changes(bursts, excess, speeds, goal, "completion_loss")


def _capped(bursts: Bursts, rpm: float) -> float:
    return min(bursts.at(rpm).end, FAR)


def _changes(bursts, excess, speeds, goal, quantity="accumulation_at_corner") -> list[Critical]:
    found = []
    values = [excess(rpm) for rpm in speeds]
    for k in range(1, len(speeds)):
        before, after = values[k - 1], values[k]
        if (before < 0.0) == (after < 0.0):
            continue
        if before < 0.0:
            low, high, e_low, e_high = bracket(excess, speeds[k - 1], speeds[k], before, after)
            left = (low, e_low)
        else:  # the order of the speeds is turned round by the sign
            low, high, e_low, e_high = bracket(
                lambda x: excess(-x), -speeds[k], -speeds[k - 1], after, before
            )
            low, high, left = -high, -low, (-low, e_low)
        found.append(_critical(bursts, quantity, goal, low, high, left, min(-e_low, e_high)))
    return found


def _critical(bursts, quantity, goal, low, high, left, distance) -> Critical:
    troubled = any(bursts.at(rpm).status != errors.OK for rpm in (low, high))
    status = UNRESOLVED if troubled else (OK if distance < AT else JUMP)
    theta = goal.within
    if quantity == "completion_loss":  # where the chatter ends at the last complete speed
        theta = bursts.at(left[0]).release
    rpm = 0.5 * (low + high)
    return Critical(quantity, goal.name, theta, rpm, low, high, status, bursts.name)
