"""The designer's question: which spring keeps contact, with a margin, up to a given speed.

    N = k c + F0 + m g + D >= margin,  D(theta) = min over omega <= Omega of
                                       b omega c_theta + m omega^2 c_thetatheta,

is linear in k and F0, so each smallest value is one maximum over the turn.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf

from camcli.analysis.contact_loss.detachment import CriticalQuantity, Reason, detachment
from camcli.analysis.contact_loss.force import Force
from camcli.cams.compile import lift_range
from camcli.kernel.cam_table import TURN, lift_at
from camcli.system import System, omega_of

SLIGHT = 1e-12  # relative: a force that is missing by no more is rounding of the sums above
USUAL_MARGIN = 0.1  # of the largest force the spring must give: the margin where none is stated
ABSURD = 20.0  # times the force of the present spring at the nose: no spring for its place


class HoldStatus(StrEnum):
    """Whether there is such a spring, whether it is needed at all, or absurdly strong (ABSURD)."""

    OK = "ok"
    NOT_NEEDED = "not-needed"
    ABSURD = "absurd"
    IMPOSSIBLE = "impossible"


class Obstacle(StrEnum):
    """Why no spring holds contact.

    KINK: the cam throws the follower off at any speed. LIFT: where c + precompression <= 0 a
    spring does not press, and force is missing. PULL: one stiff enough elsewhere would pull there.
    SOLID: the present spring, compressed for more preload, is solid below the highest lift.
    """

    KINK = "kink"
    LIFT = "no-lift"
    PULL = "pull"
    SOLID = "solid"


@dataclass(frozen=True)
class Hold:
    """One answer: the spring, the phase that decides, and where contact is then lost first.

    stiffness in N/m and preload in N are None where no spring holds. theta: the deciding phase,
    rad, None where none does. detaches: the speed (rpm) at which contact is lost first with the new
    spring, inf never; low, high: the speeds between which it lies. least_n: the least force up to
    the speed asked for, N. nose_n: the spring's force at the highest lift, N. obstacle, missing_n:
    why no spring holds, and the force that is missing, N (of a SOLID spring the height, m). more:
    whether it has more than the present spring, of stiffness, or of preload where only the preload
    is another one. If less would do, the present spring holds.
    """

    quantity: CriticalQuantity
    status: HoldStatus
    stiffness: float | None = None
    preload: float | None = None
    region: str = ""
    theta: float | None = None
    detaches: float | None = None
    least_n: float | None = None
    obstacle: Obstacle | None = None
    missing_n: float | None = None
    nose_n: float | None = None
    more: bool = True
    low: float | None = None
    high: float | None = None


def usual_margin(system: System, rpm: float, accel_error: Sequence[float] = (0.0,)) -> float:
    """The margin where none is stated: a share of the largest force the spring must give, N."""
    largest, _, _ = Need(system, rpm, 0.0, accel_error).most(lambda need, c: need)
    return max(0.0, USUAL_MARGIN * largest)


def usual_precompression(system: System) -> float:
    """How far a new spring is compressed at the lowest lift, m: as far as the present one is."""
    follower = system.follower
    if follower.preload > 0.0 and follower.stiffness > 0.0:
        return follower.preload / follower.stiffness
    lowest, highest = lift_range(system.cam)
    return max(0.0, -lowest) + 0.5 * (highest - lowest)


def hold_to(
    system: System,
    rpm: float,
    margin: float,
    precompression: float,
    accel_error: Sequence[float] = (0.0,),
    solid: float = inf,
) -> list[Hold]:
    """Smallest stiffness, smallest preload, and both with preload = stiffness x precompression.

    rpm: the speed up to which the force (N) stays at least `margin`; precompression in m.
    accel_error: bounds on the error of a measured c_thetatheta, m/rad2, in equal shares of a turn.
    solid: height q (m) at which the present spring is solid; more preload brings it nearer.
    """
    kinds = (
        CriticalQuantity.HOLD_STIFFNESS,
        CriticalQuantity.HOLD_PRELOAD,
        CriticalQuantity.HOLD_BOTH,
    )
    if any(lost.reason is Reason.KINK for lost in detachment(system).always):
        return [Hold(kind, HoldStatus.IMPOSSIBLE, obstacle=Obstacle.KINK) for kind in kinds]
    need = Need(system, rpm, margin, accel_error)
    preload = system.follower.preload
    return [
        need.least_stiffness(CriticalQuantity.HOLD_STIFFNESS, preload, 0.0),
        need.least_preload(solid),
        need.least_stiffness(CriticalQuantity.HOLD_BOTH, 0.0, precompression),
    ]


def replaced(system: System, stiffness: float, preload: float) -> System:
    """The same machine with another spring."""
    return system.with_follower(stiffness=stiffness, preload=preload)


class Need:
    """The force a spring must give at every phase, P = margin - m g - D."""

    def __init__(
        self, system: System, rpm: float, margin: float, accel_error: Sequence[float] = (0.0,)
    ):
        """Springs that press with `margin` (N) at rpm, whatever the error of c_thetatheta is.

        accel_error: bounds on that error, m/rad2, in equal parts of the turn.
        """
        self.system = system
        self.margin = margin
        self.accel_error = accel_error
        self.force = Force(system)
        self.omega = omega_of(rpm)
        self.cam = system.cam
        self.follower = system.follower
        _, self.highest = lift_range(system.cam)  # m, exact: `cam.top` is a bound on it

    def at(self, i: int, theta: float) -> tuple[float, float]:
        """(P, c) at a phase of stretch i, N and m, at the worst speed up to the one asked for.

        D, the least of linear omega + square omega^2, is at omega = 0 or at the speed asked for, or
        where its slope is zero between them.
        """
        c, c1, c2 = lift_at(self.cam, i, theta)
        share = min(int(theta / TURN * len(self.accel_error)), len(self.accel_error) - 1)
        c2 -= self.accel_error[share]
        linear = self.follower.damping * c1
        square = self.follower.mass * c2
        worst = min(0.0, self.omega * (linear + self.omega * square))
        if square > 0.0 and linear < 0.0 and -linear < 2.0 * square * self.omega:
            worst = min(worst, -linear * linear / (4.0 * square))
        return self.margin - self.follower.mass * self.follower.gravity - worst, c

    def most(self, f: Callable[[float, float], float]) -> tuple[float, int, float]:
        """(largest f(P, c), stretch, theta) over the turn."""
        value, i, theta = self.force.lowest(lambda i, x: -f(*self.at(i, x)))
        return -value, i, theta

    def least_stiffness(self, quantity: CriticalQuantity, fixed: float, reach: float) -> Hold:
        """The spring of least stiffness k that presses with fixed + k (c + reach) >= P everywhere.

        fixed: the part of the preload (N) that does not grow with k. reach: how far the spring is
        compressed at c = 0 (m), so that the preload is fixed + k reach. Where the spring is
        compressed, c + reach > 0, each phase asks for a stiffness, and the largest is taken. Where
        it is not, stiffness does not help: what is lacking there decides whether there is a spring.
        """

        def stiffness_for(need: float, c: float) -> float:
            """The stiffness that a phase asks for, N/m."""
            compressed = c + reach
            return (need - fixed) / compressed if compressed > 0.0 else -inf

        k, i, theta = self.most(stiffness_for)
        k = max(k, 0.0)

        def lack(need: float, c: float) -> float:
            """The force that is lacking where the spring is not compressed, N."""
            compressed = c + reach
            return need - fixed - min(k * compressed, 0.0) if compressed <= 0.0 else -inf

        lacking, worst_stretch, worst_theta = self.most(lack)
        size = abs(self.margin) + abs(fixed) + k * abs(self.cam.top + reach)
        if lacking <= SLIGHT * size:
            return self.checked(quantity, k, fixed + k * reach, k > 0.0, i, theta)
        need, _ = self.at(worst_stretch, worst_theta)
        missing = need - fixed  # whatever the stiffness
        return Hold(
            quantity,
            HoldStatus.IMPOSSIBLE,
            region=self.force.region_of(worst_stretch).name,
            theta=worst_theta,
            obstacle=Obstacle.LIFT if missing > SLIGHT * lacking else Obstacle.PULL,
            missing_n=max(missing, 0.0),
        )

    def least_preload(self, solid: float) -> Hold:
        """The spring of the present stiffness with the least preload; more than now, or not.

        solid: the height (m) at which the present spring is solid. More preload compresses it
        further, so that the highest lift comes as near to that as if it were higher.
        """
        quantity = CriticalQuantity.HOLD_PRELOAD
        stiffness = self.follower.stiffness
        present = self.follower.preload
        least, i, theta = self.most(lambda need, c: need - stiffness * c)
        hold = self.checked(quantity, stiffness, max(least, 0.0), least > 0.0, i, theta)
        hold = replace(hold, more=least > present)
        compressed_by = (least - present) / stiffness if hold.more and stiffness > 0.0 else 0.0
        height = self.highest + compressed_by
        if height > solid:
            hold = replace(
                hold,
                status=HoldStatus.IMPOSSIBLE,
                obstacle=Obstacle.SOLID,
                missing_n=height - solid,
            )
        return hold

    def checked(
        self,
        quantity: CriticalQuantity,
        k: float,
        preload: float,
        needed: bool,
        i: int,
        theta: float,
    ) -> Hold:
        """The answer with its own first detachment and least force, computed anew.

        k, preload: of the new spring, N/m and N. needed: whether it takes one; then the phase theta
        of stretch i is the one that decides.
        """
        lost = detachment(replaced(self.system, k, preload))
        never = None if lost.always else inf
        detaches = lost.first.rpm if lost.first else never
        low = lost.first.low if lost.first else never
        high = lost.first.high if lost.first else never
        lacking, _, _ = self.most(lambda need, c: need - self.margin - k * c - preload)
        nose = k * self.highest + preload
        follower = self.follower
        present_nose = follower.stiffness * self.highest + follower.preload
        status = HoldStatus.NOT_NEEDED
        if needed:
            is_absurd = nose > ABSURD * present_nose > 0.0
            status = HoldStatus.ABSURD if is_absurd else HoldStatus.OK
        return Hold(
            quantity=quantity,
            status=status,
            stiffness=k,
            preload=preload,
            region=self.force.region_of(i).name if needed else "",
            theta=theta if needed else None,
            detaches=detaches,
            least_n=0.0 - lacking,
            nose_n=nose,
            more=k > follower.stiffness,
            low=low,
            high=high,
        )
