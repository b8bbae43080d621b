"""An impact passes from one smooth region of the cam to the next; an orbit doubles its period."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from camcli.analysis.orbits.identify import settled
from camcli.analysis.orbits.locate import Found
from camcli.analysis.orbits.orbit import section_states, shortest_period
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.cams.regions import corner_list
from camcli.kernel.cam_table import END, KICK, ROW, START, TURN, lift
from camcli.kernel.certify import ADMISSIBLE
from camcli.kernel.flow import flow, lane_of
from camcli.kernel.variational import relative_accel

FIRST_AMPLITUDES = (
    1e-3,
    1e-4,
    1e-5,
    1e-2,
)  # rad, distance of the doubled orbit from the single one


@dataclass(frozen=True)
class Crossing:
    """The same orbit seen with impact `impact` on both sides of a boundary.

    left, right: roots with the impact at the end of the one stretch and the start of the next;
    corner: name of the boundary, empty where the cam is smooth there; kink: c_theta jumps.
    `ahead`: direction of the branch on the far side.
    """

    left: Root
    right: Root
    impact: int
    upward: bool
    corner: str
    kink: bool
    ahead: list[float]

    @property
    def near(self) -> Root:
        """The side the branch comes from."""
        return self.left if self.upward else self.right

    @property
    def far(self) -> Root:
        """The side the branch goes to."""
        return self.right if self.upward else self.left

    @property
    def turns_back(self) -> bool:
        """True where the parameter turns round: both sides exist for one sign only."""
        coming = self.near.tangent[-1]
        return (coming < 0.0) != (self.far.tangent[-1] < 0.0)


def cross(shooter: Shooter, found: Found) -> Crossing | None:
    """The other side of a corner impact, or None where no orbit is found there."""
    rows, stretches = shooter.cam.rows, shooter.cam.stretches
    near, k, side = found.root, found.impact, found.side
    i = near.whole[2 * k]
    j = (i + side) % stretches
    x, whole = list(near.x), list(near.whole)
    x[2 * k] = rows[j * ROW + (START if side > 0 else END)]
    whole[2 * k] = j
    whole[2 * k + 1] += side if abs(j - i) != 1 or stretches == 1 else 0
    if stretches == 2 and (i, side) in ((1, 1), (0, -1)):
        whole[2 * k + 1] += side
    row = [0.0] * len(x)
    row[2 * k] = 1.0
    far = shooter.correct(x, whole, near.turns, row, x)
    if far is None:
        return None
    boundary = j if side > 0 else i
    names = {corner.stretch: corner.name for corner in corner_list(shooter.system.cam)}
    left, right = (near, far) if side > 0 else (far, near)
    return Crossing(
        left=left, right=right, impact=k, upward=side > 0, corner=names.get(boundary, ""),
        kink=rows[boundary * ROW + KICK] != 0.0, ahead=[side * d for d in far.tangent],
    )  # fmt: skip


def doubled(shooter: Shooter, found: Found) -> tuple[Root, list[float]] | None:
    """An orbit of twice the period beside a period doubling, and the direction away from it.

    It leaves along the eigenvector d of -1: (x + e d, x - e d) to first order in e.
    """
    root = found.root
    direction = _flip_vector(shooter, root)
    if direction is None:
        return None
    twice = [*direction, *[-d for d in direction], 0.0]
    whole = list(root.whole)
    for k in range(root.count):
        whole += [root.whole[2 * k], root.whole[2 * k + 1] + root.turns]
    origin = [*root.x[:-1], *root.x]
    for amplitude in FIRST_AMPLITUDES:
        guess = [x + amplitude * d for x, d in zip(origin, twice, strict=True)]
        length = amplitude * sum(d * d for d in twice)
        orbit = shooter.correct(guess, whole, 2 * root.turns, twice, origin, length)
        orbit = None if orbit is None else settled(shooter.system, shooter, orbit)
        if orbit is None or shooter.verdict(orbit)[0] != ADMISSIBLE:
            continue
        if shortest_period(section_states(shooter.system, orbit)[0]) == orbit.turns:
            return orbit, twice
    return None


def _flip_vector(shooter: Shooter, root: Root) -> list[float] | None:
    """(dtheta_k, dv_k) of all impacts in the direction of the multiplier -1, largest phase 1."""
    steps = [_impact_map(shooter, root, k) for k in range(root.count)]
    m = [[1.0, 0.0], [0.0, 1.0]]
    for s in steps:
        m = [[s[i][0] * m[0][j] + s[i][1] * m[1][j] for j in range(2)] for i in range(2)]
    rows = [[m[0][0] + 1.0, m[0][1]], [m[1][0], m[1][1] + 1.0]]
    a, b = max(rows, key=lambda row: abs(row[0]) + abs(row[1]))
    size = sqrt(a * a + b * b)
    if size == 0.0:
        return None
    d = [-b / size, a / size]
    vector = []
    for s in steps:
        vector += d
        d = [s[i][0] * d[0] + s[i][1] * d[1] for i in range(2)]
    largest = max(abs(x) for x in vector[::2])
    return [x / largest for x in vector] if largest > 0.0 else None


def _impact_map(shooter: Shooter, root: Root, k: int) -> list[list[float]]:
    """Derivative of (theta, v) at impact k + 1 by those at impact k; equations in the kernel."""
    lane, n = lane_of(root.machine, 0.0, 0), root.count
    j = (k + 1) % n
    turns = root.whole[2 * j + 1] - root.whole[2 * k + 1] + (root.turns if k == n - 1 else 0)
    s = root.theta[j] - root.theta[k] + TURN * turns
    v, u, r = root.x[2 * k + 1], root.rates[j], lane.r
    c, c1, c2 = lift(shooter.system.cam, root.whole[2 * k], root.theta[k])
    start = relative_accel(lane, c, c1 + v, c2)
    c, c1, c2 = lift(shooter.system.cam, root.whole[2 * j], root.theta[j])
    stop = relative_accel(lane, c, c1 + u, c2)
    b, b1, p = flow(lane, s)
    gap = (-(v * (1.0 - lane.W2 * p) + b * start), b)
    rate = (lane.W2 * b * v - b1 * start, b1)
    theta = [-g / u for g in gap]
    return [theta, [-r * (rate[i] + stop * theta[i]) for i in range(2)]]
