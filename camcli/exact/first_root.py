"""The first zero of a function that begins positive: none is missed and none invented.

Intervals are cut in half until each is shown to be free of zeros by a Taylor form of order 2, or to
hold exactly one where the function falls or is concave and changes its sign. That one is found by
Newton's method and enclosed by an interval Newton step (R. E. Moore, Interval Analysis, 1966).
"""

from collections.abc import Callable, Sequence
from itertools import pairwise

from flint import arb, ctx

from camcli.cams.balls import COARSE, UndecidedError, coarsely

Function = Callable[[arb], list[arb]]  # x -> [value, slope, second derivative, ...]
LEAST_BITS = 400  # cutting gives up, too near a double zero, at half of the digits or at these
NEWTON_STEPS = 30  # steps
SPARE_BITS = 24  # bits more than what the order of the next step makes of them


def first_root(f: Function, low: arb, high: arb, cut: arb | None = None) -> arb | None:
    """The first zero of f between two points, or None; f is positive just after `low`.

    Looked for before `cut` first. Raises UndecidedError near a double zero, and where `high` itself
    may be a zero.
    """
    ends = [low.mid(), *([] if cut is None else [cut.mid()]), high.mid()]
    root = coarsely(lambda: _bracket(f, ends))
    return None if root is None else _enclosed(f, *root)


def _bracket(f: Function, ends: list[arb]) -> tuple[arb, arb] | None:
    """Two points with the first zero and no other between them, the second beyond it."""
    least = float(ends[-1] - ends[0]) * 2.0 ** -min(ctx.prec // 2, LEAST_BITS)
    todo: list[tuple] = [(a, b, None) for a, b in pairwise(ends)][::-1]
    while todo:
        a, b, end = todo.pop()  # end: the value at b, where it is known
        x = a.union(b)
        whole = f(x)
        if whole[0] > 0:
            continue
        if whole[1] < 0 or whole[2] < 0:  # at most one zero: it falls, or is concave from above 0
            end = f(b)[0] if end is None else end
            if end > 0:
                continue
            if end < 0:
                return a, b
        middle = x.mid()
        at = f(middle)
        h = x - middle
        if at[0] + h * (at[1] + h * whole[2] / 2) > 0:
            continue
        if float(b - a) < least:
            raise UndecidedError
        todo += [(middle, b, end), (a, middle, at[0])]
        if at[0].contains(0):  # a zero on the cut would belong to both sides
            middle = ((3 * a + 2 * b) / 5).mid()
            todo[-2:] = [(middle, b, end), (a, middle, None)]
    return None


def _enclosed(f: Function, a: arb, b: arb) -> arb:
    """The only zero between a, where f is positive or zero, and b, where it is negative."""
    x = ((a + b) / 2).mid()
    for _ in range(NEWTON_STEPS):
        value, slope, second = f(x)[:3]
        if value > 0:
            a = x
        elif value < 0:
            b = x
        else:
            break  # as near as the radius of f allows
        step = _step(value, slope, second)
        if abs(step) <= abs(x) * arb(2) ** (-ctx.prec // 2):  # the last one doubles the digits
            break
        x = (x + step).mid() if a < x + step < b else ((a + b) / 2).mid()
    else:
        raise UndecidedError
    room = 4 * (abs(value) / abs(slope)).abs_upper() + arb(2) ** (16 - ctx.prec)
    around = arb(x, room)
    slope = f(around)[1]
    root = x - value / slope
    if not slope < 0 or not around.contains_interior(root):
        raise UndecidedError
    return root


def _step(value: arb, slope: arb, second: arb) -> arb:
    """To where the parabola of a function falls through zero: Euler's method, of third order."""
    bend = slope * slope - 2 * value * second
    return (2 * value / (bend.sqrt() - slope)).mid()


def sharpened(f: Function, s: arb, slopes: Sequence[arb]) -> tuple[arb, arb]:
    """(zero, slope there) with all digits in use, of the only zero in a ball s that has few.

    slopes: f1, f2, f3, the derivatives of f on all of s. From x near the zero, d = -f(x)/(f1(x) +
    R f2) is the interval Newton step in the room R, and the slope at x + d is f1(x) + d f2(x) +
    d^2 f3/2.
    """
    full = ctx.prec
    x = s.mid()
    few = [full // 2 + SPARE_BITS]
    while few[-1] > 3 * COARSE:
        few.append(few[-1] // 3 + SPARE_BITS)
    try:
        for ctx.prec in reversed(few):
            x = (x + _step(*f(x))).mid()
    finally:
        ctx.prec = full
    for _ in range(NEWTON_STEPS):
        value, slope, second = f(x)
        step = -value / slope
        if not step * step * abs(second) > value.rad():
            break
        x = (x + step).mid()
    falls, bend, jerk = slopes
    room = arb(0, 2 * abs(step).upper() + arb(2) ** (16 - ctx.prec))
    step = -value / (slope + room * bend)
    if not (falls < 0 and s.contains(x + room) and room.contains_interior(step)):
        raise UndecidedError
    return x + step, slope + step * (second + step * jerk / 2)
