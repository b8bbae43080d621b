"""Where on a step of a branch something happens: each event is the root of its own equation.

period-doubling  1 + trace + det = 0        a multiplier is -1
fold             the parameter turns round   1 - trace + det = 0, a multiplier is 1
corner-impact    theta_k = corner
grazing          the certificate is lost: a contact appears in a flight, or an impact fades
A Neimark-Sacker bifurcation needs det = 1; here det = r^(2 n) exp(-b m T/mass) < 1 whenever
anything dissipates, so none is looked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ulp

from camcli.analysis.bracketing import bracket
from camcli.analysis.orbits.arclength import Step, beyond
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.kernel.cam_table import END, ROW, START
from camcli.kernel.certify import ADMISSIBLE

PERIOD_DOUBLING, FOLD, CORNER, GRAZING = "period-doubling", "fold", "corner-impact", "grazing"
COMPLETION, RANGE, LOST, CLOSED = "chatter-completion", "end-of-range", "lost", "closed"
OK, UNRESOLVED = "ok", "unresolved"
MOST_SECANTS = 30
SETTLED = 1e-13  # of its size: a secant step of the parameter that ends the iteration
AT_ONCE = 1e-10  # a test function this small at the first point of a branch is zero there
HALVES = 0.05  # rad, between the halves of an orbit that is about to be a single one
SAME_VALUE = 1e-6  # relative distance of the parameters of a fold and of its period doubling
ERRORS = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8)  # relative half widths tried for a bracket


@dataclass(frozen=True)
class Found:
    """An event on a step: its root, how far along, and the bracket of the parameter.

    `impact` (0-based) and `side` belong to a corner impact: +1 at the end of its region, -1 at the
    start; for grazing `impact` is the flight's and `phase` where the contact appears, rad.
    """

    kind: str
    root: Root
    reach: float
    error: float
    status: str
    impact: int = -1
    side: int = 0
    phase: float = 0.0


def flip_test(root: Root) -> float:
    """1 + trace + det, zero at a period doubling."""
    return 1.0 + root.trace + root.det


def corners_on(shooter: Shooter, step: Step) -> list[Found]:
    """The first place on the step where an impact reaches the end of its region."""
    found = []
    for _, k, side in beyond(shooter, step.after):
        root = at_corner(shooter, step.after, k, side)
        if root is None:
            continue
        reach = step.reach(root)
        if -1e-9 * step.length <= reach <= step.length:
            error, status = _bracket(shooter, root, lambda r, k=k, x=root.x[2 * k]: r.x[2 * k] - x)
            found.append(Found(CORNER, root, max(reach, 0.0), error, status, k, side))
    return sorted(found, key=lambda f: f.reach)[:1]


def at_corner(shooter: Shooter, guess: Root, k: int, side: int) -> Root | None:
    """The root with impact k exactly at the end (side 1) or start (-1) of its stretch."""
    row = [0.0] * len(guess.x)
    row[2 * k] = 1.0
    x = list(guess.x)
    x[2 * k] = shooter.cam.rows[guess.whole[2 * k] * ROW + (END if side > 0 else START)]
    return shooter.correct(x, guess.whole, guess.turns, row, x)


def smooth_events(shooter: Shooter, step: Step, turned: bool) -> list[Found]:
    """Period doublings and folds on a step, in order; `turned`: the parameter turns round on it."""
    found = []
    before, after = flip_test(step.before), flip_test(step.after)
    if (before < 0.0) != (after < 0.0) and abs(before) > AT_ONCE:
        found.append(_root_of(shooter, step, PERIOD_DOUBLING, flip_test, before, after))
    if turned:
        sign = 1.0 if step.unit[-1] >= 0.0 else -1.0
        found.append(_root_of(shooter, step, FOLD, lambda r: sign * r.tangent[-1], 1.0, -1.0))
    return sorted((f for f in found if f is not None), key=lambda f: f.reach)


def _root_of(shooter, step: Step, kind: str, test: Callable[[Root], float], before, after):
    """The place on a step where `test` changes sign."""
    sign = 1.0 if before < 0.0 else -1.0

    def value(length: float) -> float:
        root = step.at(shooter, length)
        return sign * test(root) if root is not None else float("nan")

    ends = bracket(value, 0.0, step.length, sign * before, sign * after)
    root = step.at(shooter, 0.5 * (ends[0] + ends[1]))
    if root is None:
        return None
    if kind == FOLD:
        sides = [step.at(shooter, end) for end in ends[:2]]
        width = max((abs(r.value - root.value) for r in sides if r is not None), default=0.0)
        error, status = max(width, 8.0 * ulp(root.value)), OK
    else:
        error, status = _bracket(shooter, root, test)
    return Found(kind, root, 0.5 * (ends[0] + ends[1]), error, status)


def _bracket(shooter: Shooter, root: Root, test: Callable[[Root], float]) -> tuple[float, str]:
    """Smallest half width of the parameter around the root at whose ends `test` differs in sign."""
    for relative in ERRORS:
        width = relative * abs(root.value)
        ends = [
            shooter.at_value(root.x, root.whole, root.turns, root.value + side * width)
            for side in (-1.0, 1.0)
        ]
        if None not in ends and (test(ends[0]) < 0.0) != (test(ends[1]) < 0.0):
            return width, OK
    return ERRORS[-1] * abs(root.value), UNRESOLVED


def doubling_at(shooter: Shooter, root: Root) -> Found | None:
    """The period doubling a branch is begun at, if it is begun at one."""
    if abs(flip_test(root)) > AT_ONCE:
        return None
    error, status = _bracket(shooter, root, flip_test)
    return Found(PERIOD_DOUBLING, root, 0.0, error, status)


def parent_of(shooter: Shooter, found: Found, within: float = 0.0) -> Found | None:
    """The period doubling from which a branch was born, where it turns round at a fold there.

    On the doubled branch it looks like a fold, at which both halves of the orbit are the same.
    `within`: how far from the root's parameter it may lie, where the root is past it already.
    """
    root = found.root
    n, turns = root.count // 2, root.turns // 2
    if root.count % 2 or root.turns % 2:
        return None
    halves = list(zip(root.x[: 2 * n], root.x[2 * n : -1], strict=True))
    if within == 0.0 and any(abs(a - b) > HALVES for a, b in halves[::2]):
        return None
    single = [0.5 * (a + b) for a, b in halves]

    def at(value: float) -> tuple[float, Root | None]:
        parent = shooter.at_value([*single, value], root.whole[: 2 * n], turns, value)
        return (0.0, None) if parent is None else (flip_test(parent), parent)

    size = abs(root.value) + shooter.scale
    parent = secant(at, root.value, 1e-7 * size, size)
    if parent is None or abs(parent.value - root.value) > max(SAME_VALUE * size, within):
        return None
    error, status = _bracket(shooter, parent, flip_test)
    return Found(PERIOD_DOUBLING, parent, found.reach, error, status)


def graze_on(shooter: Shooter, step: Step) -> Found | None:
    """Where on the step the orbit ceases to be a motion; its end must be none."""
    if shooter.verdict(step.after)[0] == ADMISSIBLE:
        return None

    def value(length: float) -> float:
        root = step.at(shooter, length)
        good = root is not None and shooter.verdict(root)[0] == ADMISSIBLE
        return -1.0 if good else 1.0

    low, high, _, _ = bracket(value, 0.0, step.length, -1.0, 1.0)
    last, first = step.at(shooter, low), step.at(shooter, high)
    last = last if last is not None else step.before
    first = first if first is not None else step.after
    _, impact, phase = shooter.verdict(first)
    error = max(abs(first.value - last.value), 8.0 * ulp(last.value))
    return Found(GRAZING, last, low, error, OK, impact=impact, phase=phase)


def secant(at: Callable[[float], tuple], start: float, width: float, size: float) -> Root | None:
    """Secant method for the zero of at(x)[0]; the root of the last evaluation."""
    x0, x1 = start, start + width
    (y0, root), (y1, other) = at(x0), at(x1)
    if root is None or other is None:
        return None
    for _ in range(MOST_SECANTS):
        if y1 == y0:
            return other
        x0, x1, y0 = x1, x1 - y1 * (x1 - x0) / (y1 - y0), y1
        y1, other = at(x1)
        if other is None:
            return None
        if abs(x1 - x0) <= SETTLED * size:
            return other
    return None
