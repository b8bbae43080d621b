"""Where on a step of a branch something happens: each event is the root of its own test function.

period-doubling  1 + trace + det = 0        a multiplier is -1
fold             the parameter turns round   1 - trace + det = 0, a multiplier is 1
corner-impact    theta_k = corner
grazing          the certificate is lost: a contact appears in a flight, or an impact fades
A Neimark-Sacker bifurcation needs det = 1; here det = r^(2 n) exp(-b m T/mass) < 1 whenever
anything dissipates, so none is looked for. References: Allgower & Georg, Numerical Continuation
Methods (1990), ch. 8 and 9; di Bernardo, Budd, Champneys & Kowalczyk, Piecewise-smooth Dynamical
Systems (2008), ch. 6 and 7.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import ulp
from typing import NamedTuple

from camcli.analysis.bracketing import bracket
from camcli.analysis.orbits.arclength import BranchStep
from camcli.analysis.orbits.identify import settled
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.orbit import section_states
from camcli.analysis.orbits.same_orbit import shortest_period
from camcli.analysis.orbits.shooter import SMALL, Root, Shooter
from camcli.cams.regions import corner_list
from camcli.kernel.bordered import BLOCK, LEFT, RESIDUAL, RIGHT
from camcli.kernel.shooting import fill_block

MOST_SECANTS = 30
SETTLED = 1e-13  # of its size: a secant step of the parameter that ends the iteration
AT_ONCE = 1e-10  # a test function this small at the first point of a branch is zero there
HALVES = 0.05  # rad, between the halves of an orbit that is about to be a single one
SAME_VALUE = 1e-6  # relative distance of the parameters of a fold and of its period doubling
ERRORS = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8)  # relative half widths tried for a bracket
FADING_STEPS = 4.0  # steps ahead that the end of a fading impact is looked for
RATE_ERROR = 4e-15  # of a landing rate, relative to the lift per rad: some 18 roundings
CLOSE_TO_A_CORNER = 0.05  # rad: nearer, an impact may be past its corner within a step
CLOSE_TO_A_MULTIPLIER = 0.15  # of 1 + |trace|: half of what the trace may change by in a step
MOST_PARABOLAS = 8
NO_DIP = 0.9  # of the least value: where a parabola dips no further, the next one will not either
AMPLITUDES = (1e-3, 1e-4, 1e-5, 1e-2)  # rad, tried between a doubled orbit and the single one

RootTest = Callable[[Root], float]  # zero where an event happens
Pair = tuple[float, float]


@dataclass(frozen=True)
class Located:
    """An event on a step of a branch.

    root: the orbit there; reach: how far along the step, in its metric; error: half the width of
    the bracket of the parameter, status: whether that is one. impact (0-based) and side belong to a
    corner impact: +1 at the end of its region, -1 at the start. For grazing `impact` is the
    flight's and `phase` where the contact appears, rad, unless it is the impact `fading` whose
    velocity goes to zero.
    """

    kind: Kind
    root: Root
    reach: float
    error: float
    status: Bracket
    impact: int = -1
    side: int = 0
    phase: float = 0.0
    fading: int | None = None


class Certainty(NamedTuple):
    """How sure an event's parameter is: half the width of its bracket, and whether it is one."""

    error: float
    status: Bracket


@dataclass(frozen=True)
class Crossing:
    """The same orbit seen with impact `impact` on both sides of a boundary.

    left, right: roots with the impact at the end of the one stretch and the start of the next;
    upward: whether the branch comes from the left; corner: name of the boundary, empty where the
    cam is smooth there; kink: c_theta jumps. ahead: direction of the branch on the far side, the
    one it goes to.
    """

    left: Root
    right: Root
    impact: int
    upward: bool
    corner: str
    kink: bool
    ahead: list[float]

    @property
    def far(self) -> Root:
        """The root on the side that the branch goes to."""
        return self.right if self.upward else self.left

    @property
    def turns_back(self) -> bool:
        """True where the parameter turns round: both sides exist for one sign only."""
        coming = (self.left if self.upward else self.right).tangent[-1]
        return (coming < 0.0) != (self.far.tangent[-1] < 0.0)


def flip_test(root: Root) -> float:
    """1 + trace + det, zero at a period doubling."""
    return 1.0 + root.trace + root.det


def fold_test(root: Root) -> float:
    """1 - trace + det, zero at a fold."""
    return 1.0 - root.trace + root.det


def collapses(shooter: Shooter, root: Root) -> bool:
    """True for an orbit that is another one gone through several times."""
    return shortest_period(section_states(shooter.system, root)[0]) < root.turns


def corner_on(shooter: Shooter, step: BranchStep) -> Located | None:
    """The first place on the step where an impact reaches the end of its region."""

    def located(k: int, side: int) -> Located:
        """The orbit on the step whose impact k lies at the end of its region, on that side."""

        def past(root: Root) -> float:
            """rad by which the impact is behind its corner."""
            return root.theta[k] - shooter.edge(root, k, side)

        root = shooter.at_corner(step.after, k, side)
        if root is None or not _on(step, root):
            beside = _before_corner(shooter, step, k, side)
            root = shooter.at_corner(beside, k, side)
            if root is None or not _on(step, root):
                error = abs(step.after.value - beside.value)
                reach = max(step.reach(beside), 0.0)
                return Located(
                    Kind.CORNER_IMPACT, beside, reach, error, Bracket.UNRESOLVED, k, side
                )
        certainty = _bracket(shooter, root, past)
        reach = max(step.reach(root), 0.0)
        return Located(Kind.CORNER_IMPACT, root, reach, certainty.error, certainty.status, k, side)

    corners = (located(k, side) for _, k, side in shooter.beyond(step.after))
    return min(corners, key=lambda event: event.reach, default=None)


def _on(step: BranchStep, root: Root) -> bool:
    return -1e-9 * step.length <= step.reach(root) <= step.length


def _before_corner(shooter: Shooter, step: BranchStep, k: int, side: int) -> Root:
    """The last root on a step, at whose end impact k is beyond its region, before it is so.

    side: at which end of the region.
    """

    def far(root: Root) -> float:
        """rad by which the impact is beyond its region; negative inside."""
        return side * (root.theta[k] - shooter.edge(root, k, side))

    def far_at(length: float) -> float:
        """The same so far along the step; 1 where no root is found."""
        root = step.at(shooter, length)
        return 1.0 if root is None else far(root)

    far_before = far(step.before)
    if far_before >= 0.0:
        return step.before
    low, *_ = bracket(far_at, 0.0, step.length, far_before, far(step.after))
    return step.at(shooter, low) or step.before


def smooth_events(
    shooter: Shooter, step: BranchStep, turned: bool, doubling_told: bool = False
) -> list[Located]:
    """Period doublings and folds on a step, in order.

    turned: the parameter turns round on it; doubling_told: the period doubling at its
    beginning, if there is one, has been told already.
    """
    events = []
    before = flip_test(step.before)
    after = flip_test(step.after)
    known = doubling_told and abs(before) <= AT_ONCE
    if (before < 0.0) != (after < 0.0) and not known:
        events.append(_root_of(shooter, step, Kind.PERIOD_DOUBLING, flip_test, before, after))
    if turned:
        way = 1.0 if step.unit[-1] >= 0.0 else -1.0  # of the parameter before the fold
        ahead = partial(_parameter_slope, way)
        events.append(_root_of(shooter, step, Kind.FOLD, ahead, 1.0, -1.0))
    return sorted(events, key=lambda event: event.reach)


def _parameter_slope(way: float, root: Root) -> float:
    """The parameter's part of a root's tangent, times 1 or -1; zero at a fold."""
    return way * root.tangent[-1]


def _root_of(
    shooter: Shooter, step: BranchStep, kind: Kind, test: RootTest, before: float, after: float
) -> Located:
    """The place on a step where `test` changes sign; UNRESOLVED where the orbit is lost there.

    before, after: its values, or signs, at both ends of the step.
    """
    sign = 1.0 if before < 0.0 else -1.0  # so that the test rises along the step

    def value(length: float) -> float:
        root = step.at(shooter, length)
        return sign * test(root) if root is not None else float("nan")

    low, high, _, _ = bracket(value, 0.0, step.length, sign * before, sign * after)
    reach = 0.5 * (low + high)
    root = step.at(shooter, reach)
    if root is None:
        last = step.at(shooter, low) or step.before
        return Located(kind, last, low, abs(step.after.value - last.value), Bracket.UNRESOLVED)
    if kind == Kind.FOLD:
        sides = [step.at(shooter, end) for end in (low, high)]
        width = max((abs(r.value - root.value) for r in sides if r is not None), default=0.0)
        error = max(width, 8.0 * ulp(root.value), shooter.rounding(root))
        return Located(kind, root, reach, error, Bracket.OK)
    certainty = _bracket(shooter, root, test)
    return Located(kind, root, reach, certainty.error, certainty.status)


def twice_on(shooter: Shooter, step: BranchStep) -> Root | None:
    """A root inside a step on which the branch passes an event and comes back, or None.

    There a test function has the other sign than at both ends of the step: cut at this root, each
    part holds one event. An impact turns round near the end of its region, or the trace or the
    parameter near a doubling or a fold.
    """
    # each is positive at both ends; and what of it is near zero
    tests: list[tuple[RootTest, float]] = [
        (partial(_inside, shooter, k, side), CLOSE_TO_A_CORNER)
        for k in range(step.before.count)
        for side in (-1, 1)
    ]
    close_to_multiplier = CLOSE_TO_A_MULTIPLIER * (1.0 + abs(step.before.trace))
    for test in (flip_test, fold_test):
        sign = 1.0 if test(step.before) >= 0.0 else -1.0
        tests.append((partial(_times, sign, test), close_to_multiplier))
    for positive_test, near_zero in tests:
        root = beyond_both(shooter, step, positive_test, near_zero)
        if root is not None:
            return root
    return None


def _inside(shooter: Shooter, k: int, side: int, root: Root) -> float:
    """rad by which impact k of a root is inside its region, from the end on that side."""
    return side * (shooter.edge(root, k, side) - root.theta[k])


def _times(sign: float, test: RootTest, root: Root) -> float:
    """A test function times a sign."""
    return sign * test(root)


def beyond_both(
    shooter: Shooter, step: BranchStep, test: RootTest, near_zero: float
) -> Root | None:
    """A root inside a step at which a test is negative, though it is positive at both ends.

    It is looked for by successive parabolas through three places (length along the step, value of
    the test), and only if the lower end is below `near_zero`.
    """
    left = (0.0, test(step.before))
    right = (step.length, test(step.after))
    if not 0.0 < min(left[1], right[1]) < near_zero or step.length <= 0.0:
        return None
    x = 0.5 * step.length
    for _ in range(MOST_PARABOLAS):
        root = step.at(shooter, x)
        if root is None:
            return None
        middle = (x, test(root))
        if middle[1] < 0.0:
            return root
        a, at_a = left
        b, at_b = middle
        c, at_c = right
        first_slope = (at_b - at_a) / (b - a)
        second_slope = (at_c - at_b) / (c - b)
        bend = (second_slope - first_slope) / (c - a)  # half the parabola's second derivative
        if bend <= 0.0:
            return None
        x = 0.5 * (a + b) - 0.5 * first_slope / bend
        lowest = at_a + first_slope * (x - a) + bend * (x - a) * (x - b)
        if not a < x < c or lowest >= NO_DIP * min(at_a, at_b, at_c):
            return None
        if x > b:
            left = middle
        else:
            right = middle
    return None


def _bracket(shooter: Shooter, root: Root, test: RootTest, least: float = 0.0) -> Certainty:
    """Smallest half width of the parameter around the root at whose ends `test` differs in sign.

    The widths of ERRORS are tried. least: of |test| at the ends, what rounding cannot make.
    """
    for relative in ERRORS:
        width = relative * abs(root.value)
        below = shooter.moved(root, root.value - width)
        above = shooter.moved(root, root.value + width)
        if below is None or above is None:
            continue
        at_below = test(below)
        at_above = test(above)
        if min(abs(at_below), abs(at_above)) < least:
            continue
        if (at_below < 0.0) != (at_above < 0.0):
            return Certainty(width, Bracket.OK)
    return Certainty(ERRORS[-1] * abs(root.value), Bracket.UNRESOLVED)


def doubling_at(shooter: Shooter, root: Root) -> Located | None:
    """The period doubling a branch is begun at, if it is begun at one."""
    if abs(flip_test(root)) > AT_ONCE:
        return None
    certainty = _bracket(shooter, root, flip_test)
    return Located(Kind.PERIOD_DOUBLING, root, 0.0, certainty.error, certainty.status)


def doubling_near(shooter: Shooter, beside: Root, width: float) -> Root | None:
    """The orbit beside a root whose multiplier is -1, by the secant method.

    width: relative, the first step of the parameter.
    """

    def at(value: float) -> tuple[float, Root | None]:
        root = shooter.moved(beside, value)
        return (0.0, None) if root is None else (flip_test(root), root)

    size = abs(beside.value) + shooter.scale
    return secant(at, beside.value, width * size, size)


def parent_of(shooter: Shooter, event: Located, within: float = 0.0) -> Located | None:
    """The period doubling from which a branch was born, where it turns round at a fold there.

    On the doubled branch it looks like a fold, at which both halves of the orbit are the same.
    `within`: how far from the root's parameter it may lie, where the root is past it already.
    """
    root = event.root
    n = root.count // 2
    if root.count % 2 or root.turns % 2:
        return None
    halves = list(zip(root.x[: 2 * n], root.x[2 * n : -1], strict=True))
    phases = halves[::2]  # each impact's phase and rate stand one after the other
    if within == 0.0 and any(abs(first - second) > HALVES for first, second in phases):
        return None
    x = [0.5 * (first + second) for first, second in halves]
    x.append(root.value)
    single = replace(root, x=x, whole=root.whole[: 2 * n], turns=root.turns // 2)
    parent = doubling_near(shooter, single, 1e-7)
    size = abs(root.value) + shooter.scale
    if parent is None or abs(parent.value - root.value) > max(SAME_VALUE * size, within):
        return None
    certainty = _bracket(shooter, parent, flip_test)
    return Located(Kind.PERIOD_DOUBLING, parent, event.reach, certainty.error, certainty.status)


def graze_on(shooter: Shooter, step: BranchStep) -> Located | None:
    """Where on the step the root ceases to be a motion; None where it is one at the step's end.

    If the rate of its slowest impact counts as zero there, that impact fades; else another contact
    comes into a flight, a graze.
    """
    if shooter.admits(step.after):
        return None

    def sign(length: float) -> float:
        """-1 where the root is a motion, 1 where it is none: what `bracket` narrows."""
        root = step.at(shooter, length)
        return -1.0 if root is not None and shooter.admits(root) else 1.0

    low, high, _, _ = bracket(sign, 0.0, step.length, -1.0, 1.0)
    last = step.at(shooter, low) or step.before
    slowest = min(range(last.count), key=lambda k: abs(last.rates[k]))
    if abs(last.rates[slowest]) < shooter.zero_rate:
        return _fade(shooter, step, slowest, low, last)
    first = step.at(shooter, high) or step.after
    _, impact, phase = shooter.verdict(first)
    error = max(abs(first.value - last.value), 8.0 * ulp(last.value))
    return Located(Kind.GRAZING, last, low, error, Bracket.OK, impact, phase=phase)


def _fade(shooter: Shooter, step: BranchStep, k: int, low: float, last: Root) -> Located:
    """Where impact k, slow at `last`, fades: u = 0, on the step or a little beyond it.

    low: how far along the step `last` is. There the certificate is lost to rounding some way before
    u = 0, so it says only that the impact fades, not where.
    """

    def rate(root: Root | None) -> float:
        """The incoming rate u of the impact, negative before it fades, m/rad."""
        return float("nan") if root is None else root.rates[k]

    high = step.length
    beyond = step.after
    while rate(beyond) < 0.0 and high < FADING_STEPS * step.length:
        high *= 1.5
        beyond = step.at(shooter, high) or beyond
    root = last
    certainty = Certainty(abs(beyond.value - last.value), Bracket.UNRESOLVED)
    if rate(last) < 0.0 <= rate(beyond):
        # low: where u < 0 still, so that the trace, which goes with 1/u, has its sign
        low, *_ = bracket(lambda x: rate(step.at(shooter, x)), low, high, rate(last), rate(beyond))
        root = step.at(shooter, low) or last
        certainty = _bracket(shooter, root, rate, RATE_ERROR * shooter.zero_rate / SMALL)
    return Located(
        Kind.GRAZING,
        root,
        low,
        certainty.error,
        certainty.status,
        impact=k,
        phase=root.theta[k],
        fading=k,
    )


def secant(
    at: Callable[[float], tuple[float, Root | None]], start: float, width: float, size: float
) -> Root | None:
    """The root at the zero of a function, by the secant method; None where it fails.

    at: (value, root) at a place; start, width: the first place and the first step; size: of the
    place, relative to which a step is small enough to end with.
    """
    before = start
    here = start + width
    value_before, root_before = at(before)
    value, root = at(here)
    if root_before is None or root is None:
        return None
    for _ in range(MOST_SECANTS):
        if value == value_before:
            return root
        there = here - value * (here - before) / (value - value_before)
        before = here
        value_before = value
        here = there
        value, root = at(here)
        if root is None or abs(here - before) <= SETTLED * size:
            return root
    return None


def cross(shooter: Shooter, event: Located) -> Crossing | None:
    """The other side of a corner impact, or None where no orbit is found there."""
    before = event.root
    k = event.impact
    side = event.side
    cam = shooter.system_of(before).cam
    stretches = cam.stretches
    stretch = before.stretch(k)
    turns, stretch_behind = divmod(stretch + side, len(stretches))
    on_other_side = before.landing_on(k, stretch_behind, before.turn(k) + turns)
    far = shooter.at_corner(on_other_side, k, -side)
    if far is None:
        return None
    boundary = stretch_behind if side > 0 else stretch  # the stretch that begins there
    names = {corner.stretch: corner.name for corner in corner_list(cam)}
    upward = side > 0
    return Crossing(
        left=before if upward else far,
        right=far if upward else before,
        impact=k,
        upward=upward,
        corner=names.get(boundary, ""),
        kink=stretches[boundary].slope_jump != 0.0,
        ahead=[side * d for d in far.tangent],
    )


def doubled(shooter: Shooter, event: Located) -> tuple[Root, list[float]] | None:
    """An orbit of twice the period beside a period doubling, and the direction away from it.

    It leaves along the eigenvector d of -1: (x + e d, x - e d) to first order in e. Some
    amplitudes e are tried, on the planes across the direction (d, -d).
    """
    root = event.root
    eigenvector = _flip_vector(shooter, root)
    if eigenvector is None:
        return None
    direction = [*eigenvector, *[-d for d in eigenvector], 0.0]
    whole = list(root.whole)
    for k in range(root.count):
        whole += [root.stretch(k), root.turn(k) + root.turns]
    origin = [*root.x[:-1], *root.x]  # the single orbit, gone through twice
    square = 0.0
    for d in direction:
        square += d * d
    for amplitude in AMPLITUDES:
        guess = [x + amplitude * d for x, d in zip(origin, direction, strict=True)]
        distance = amplitude * square
        orbit = shooter.correct(guess, whole, 2 * root.turns, direction, origin, distance)
        orbit = settled(shooter, orbit)
        if orbit is not None and shooter.admits(orbit) and not collapses(shooter, orbit):
            return orbit, direction
    return None


def _flip_vector(shooter: Shooter, root: Root) -> list[float] | None:
    """(dtheta_k, dv_k) of all impacts in the direction of the multiplier -1, largest phase 1.

    None where every phase of it is zero.
    """
    n = root.count
    const = root.const
    blocks = [0.0] * (BLOCK * n)
    cam = shooter.system_of(root).cam
    for k in range(n):
        fill_block(cam, const, root.x, root.whole, root.turns, k, n, blocks)

    def carried(start: Pair) -> list[Pair]:
        """The difference (dtheta, dv) at every impact, and at the first one a period later.

        Each flight has the equations L d + R d' = 0 with matrices L and R, rows one after the other
        in its block, for the differences d at its start and d' at its end.
        """
        differences = [start]
        for block in range(0, BLOCK * n, BLOCK):
            l11, l12, l21, l22 = blocks[block + LEFT : block + RIGHT]
            r11, _, r21, _ = blocks[block + RIGHT : block + RESIDUAL]  # r12 is 0, r22 is 1
            theta, v = differences[-1]
            next_theta = -(l11 * theta + l12 * v) / r11
            next_v = -(l21 * theta + l22 * v) - r21 * next_theta
            differences.append((next_theta, next_v))
        return differences

    # The monodromy matrix plus 1 maps the wanted difference to zero: it is at right angles to both
    # rows, of which the larger one is taken.
    theta_by_theta, v_by_theta = carried((1.0, 0.0))[-1]
    theta_by_v, v_by_v = carried((0.0, 1.0))[-1]
    rows = ((theta_by_theta + 1.0, theta_by_v), (v_by_theta, v_by_v + 1.0))
    by_theta, by_v = max(rows, key=lambda row: abs(row[0]) + abs(row[1]))
    in_one_period = carried((-by_v, by_theta))[:-1]
    vector = [x for difference in in_one_period for x in difference]
    largest = max(abs(x) for x in vector[::2])
    return [x / largest for x in vector] if largest > 0.0 else None
