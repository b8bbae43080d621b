"""The designer's question: which spring keeps contact, with a margin, up to a given speed.

    N = k c + F0 + m g + D >= margin,  D(theta) = min over omega <= Omega of
                                       b omega c_theta + m omega^2 c_thetatheta,

is linear in k and F0, so each smallest value is one maximum over the turn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.contact_loss.force import DEG, Force
from camcli.kernel.cam_table import KICK, ROW, lift_at
from camcli.system import System, omega_of

STIFFNESS, PRELOAD, BOTH = "hold_stiffness", "hold_preload", "hold_both"
OK, NOT_NEEDED, IMPOSSIBLE = "ok", "not-needed", "impossible"
SLIGHT = 1e-12  # relative excess of a force that counts as rounding


@dataclass(frozen=True)
class Hold:
    """One answer: the spring, the phase that decides, and where contact is then lost first.

    stiffness N/m, preload N (None where impossible), theta_deg of the deciding phase (None where
    none does), detaches_rpm recomputed with the new spring (inf: never), least force up to the
    speed asked for in newton.
    """

    quantity: str
    status: str
    stiffness: float | None
    preload: float | None
    region: str
    theta_deg: float | None
    detaches_rpm: float | None
    least_n: float | None
    words: str


def hold_to(system: System, rpm: float, margin: float, precompression: float) -> list[Hold]:
    """Smallest stiffness, smallest preload, and both with preload = stiffness x precompression."""
    need = _Need(system, rpm, margin)
    if need.thrown:
        words = "impossible: at a downward kink the cam throws the follower off at any speed"
        return [_impossible(kind, words) for kind in (STIFFNESS, PRELOAD, BOTH)]
    return [_stiffness(need), _preload(need), _both(need, precompression)]


class _Need:
    """The force a spring must give at every phase, P = margin - m g - D."""

    def __init__(self, system: System, rpm: float, margin: float):
        self.system, self.rpm, self.margin = system, rpm, margin
        self.force, self.omega = Force(system), omega_of(rpm)
        self.cam, self.follower = system.cam, system.follower
        self.all = range(self.cam.stretches)
        self.thrown = any(self.cam.rows[i * ROW + KICK] < 0.0 for i in self.all)

    def at(self, i: int, theta: float) -> tuple[float, float]:
        """(P, c) at a phase, at the worst speed up to the one asked for."""
        c, c1, c2 = lift_at(self.cam, i, theta)
        linear, square = self.follower.damping * c1, self.follower.mass * c2
        worst = min(0.0, self.omega * (linear + self.omega * square))
        if square > 0.0 and linear < 0.0 and -linear < 2.0 * square * self.omega:
            worst = min(worst, -linear * linear / (4.0 * square))
        return self.margin - self.follower.mass * self.follower.gravity - worst, c

    def most(self, f: Callable[[float, float], float]) -> tuple[float, int, float]:
        """(largest f(P, c), stretch, theta) over the turn."""
        value, i, theta = self.force.lowest(lambda i, x: -f(*self.at(i, x)), self.all)
        return -value, i, theta

    def smallest(self, preload: float, reach: float) -> tuple[float, int, float, str]:
        """Least k with k (c + reach) + preload >= P everywhere: (k, stretch, theta, why not)."""

        def per_lift(p: float, c: float) -> float:
            return (p - preload) / (c + reach) if c + reach > 0.0 else -inf

        def short(p: float, c: float) -> float:
            return p - preload if c + reach <= 0.0 else -inf

        k, i, theta = self.most(per_lift)
        k = max(k, 0.0)
        # where c + reach <= 0 stiffness only takes force away: k is the best there can be
        lack, j, place = self.most(lambda p, c: short(p, c) - min(k * (c + reach), 0.0))
        size = abs(self.margin) + abs(preload) + k * abs(self.cam.top + reach)
        if lack > SLIGHT * size:
            missing = self.at(j, place)[0] - preload  # whatever the stiffness
            what = (
                f"{missing:.6g} N are missing"
                if missing > SLIGHT * lack
                else "the spring would pull"
            )
            return k, i, theta, f"{what} at {place * DEG:.10g} deg, where"
        return k, i, theta, ""


def _stiffness(need: _Need) -> Hold:
    k, i, theta, lack = need.smallest(need.follower.preload, 0.0)
    if lack:
        words = f"impossible with stiffness alone: {lack} c <= 0 and a spring does not press"
        return _impossible(STIFFNESS, words)
    return _checked(need, STIFFNESS, k, need.follower.preload, k > 0.0, i, theta)


def _preload(need: _Need) -> Hold:
    k = need.follower.stiffness
    least, i, theta = need.most(lambda p, c: p - k * c)
    return _checked(need, PRELOAD, k, max(least, 0.0), least > 0.0, i, theta)


def _both(need: _Need, precompression: float) -> Hold:
    k, i, theta, lack = need.smallest(0.0, precompression)
    if lack:
        words = f"impossible: {lack} c + precompression <= 0; raise detach.precompression_m"
        return _impossible(BOTH, words)
    return _checked(need, BOTH, k, k * precompression, k > 0.0, i, theta)


def _checked(need, quantity, stiffness, preload, needed, i, theta) -> Hold:
    """The answer with its own first detachment and least force, computed anew."""
    system = replaced(need.system, stiffness, preload)
    again = detachment(system)
    first = again.first.rpm if again.first else (inf if again.never else None)
    least = 0.0 - need.most(lambda p, c: p - need.margin - stiffness * c - preload)[0]
    what = {
        STIFFNESS: f"stiffness {stiffness:.10g} N/m, preload as it is",
        PRELOAD: f"preload {preload:.10g} N, stiffness as it is",
        BOTH: f"stiffness {stiffness:.10g} N/m and preload {preload:.10g} N",
    }[quantity]
    if not needed:
        what = f"no {quantity.removeprefix('hold_').replace('both', 'spring')} is needed"
    return Hold(
        quantity,
        OK if needed else NOT_NEEDED,
        stiffness,
        preload,
        need.force.region_of(i).name if needed else "",
        theta * DEG if needed else None,
        first,
        least,
        what,
    )


def replaced(system: System, stiffness: float, preload: float) -> System:
    """The same machine with another spring."""
    return System(replace(system.follower, stiffness=stiffness, preload=preload), system.cam)


def _impossible(quantity: str, words: str) -> Hold:
    return Hold(quantity, IMPOSSIBLE, None, None, "", None, None, None, words)
