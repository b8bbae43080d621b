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
    """The first zero of f between two points, as a ball, or None; f is positive just after `low`.

    cut: a point between them, before which the zero is expected; it is looked for there first.
    Raises UndecidedError near a double zero, and where `high` itself may be a zero.
    """
    points = [low.mid(), high.mid()] if cut is None else [low.mid(), cut.mid(), high.mid()]
    interval = coarsely(lambda: _interval_of_first_zero(f, points))
    return None if interval is None else _enclosed(f, *interval)


def _interval_of_first_zero(f: Function, points: list[arb]) -> tuple[arb, arb] | None:
    """Two points with the first zero and no other between them, the second beyond it.

    points: ascending; between two neighbours f is looked at on its own. An interval is free of
    zeros where f is above zero on all of it, by its values there or by the Taylor form
    f(m) + h (f'(m) + h f''/2) about its middle m. Raises UndecidedError.
    """
    smallest = float(points[-1] - points[0]) * 2.0 ** -min(ctx.prec // 2, LEAST_BITS)
    # to be looked at, the last one first: (a, b, value at b where it is known)
    intervals: list[tuple[arb, arb, arb | None]] = []
    for a, b in reversed(list(pairwise(points))):
        intervals.append((a, b, None))
    while intervals:
        a, b, value_at_b = intervals.pop()
        x = a.union(b)
        value, slope, second = f(x)[:3]
        if value > 0:
            continue
        if slope < 0 or second < 0:  # at most one zero: it falls, or is concave from above 0
            if value_at_b is None:
                value_at_b = f(b)[0]
            if value_at_b > 0:
                continue
            if value_at_b < 0:
                return a, b
        middle = x.mid()
        middle_value, middle_slope = f(middle)[:2]
        h = x - middle
        if middle_value + h * (middle_slope + h * second / 2) > 0:
            continue
        if float(b - a) < smallest:
            raise UndecidedError
        if middle_value.contains(0):  # a zero on the cut would belong to both sides
            cut = ((3 * a + 2 * b) / 5).mid()
            intervals += [(cut, b, value_at_b), (a, cut, None)]
        else:
            intervals += [(middle, b, value_at_b), (a, middle, middle_value)]
    return None


def _enclosed(f: Function, a: arb, b: arb) -> arb:
    """The only zero between a, where f is positive or zero, and b, where it is negative.

    A third-order step (`_step`) is taken as long as it stays between them, else they are halved;
    then the interval Newton step x - f(x)/f' over the room about x encloses the zero. Raises
    UndecidedError where it does not.
    """
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
    """The way to where the parabola with these derivatives falls through zero.

    That is Euler's method, of third order: 2 f/(sqrt(f'^2 - 2 f f'') - f').
    """
    bend = slope * slope - 2 * value * second
    return (2 * value / (bend.sqrt() - slope)).mid()


def sharpened(f: Function, s: arb, slopes: Sequence[arb]) -> tuple[arb, arb]:
    """(zero, slope there) with all digits in use, of the only zero in a ball s that has few.

    slopes: f1, f2, f3, the derivatives of f on all of s. From x near the zero, d = -f(x)/(f1(x) +
    R f2) is the interval Newton step in the room R, and the slope at x + d is f1(x) + d f2(x) +
    d^2 f3/2. Raises UndecidedError.
    """
    x = _near_zero(f, s.mid())
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


def _near_zero(f: Function, x: arb) -> arb:
    """A point near the zero that x is near, by third-order steps (`_step`) in few bits.

    Each step makes three times the bits, less SPARE_BITS, of the one before; the last has half of
    those in use.
    """
    full = ctx.prec
    bits_of_steps = [full // 2 + SPARE_BITS]  # the last step first
    while bits_of_steps[-1] > 3 * COARSE:
        bits_of_steps.append(bits_of_steps[-1] // 3 + SPARE_BITS)
    try:
        for ctx.prec in reversed(bits_of_steps):
            x = (x + _step(*f(x))).mid()
    finally:
        ctx.prec = full
    return x
