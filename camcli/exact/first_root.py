"""The first zero of a function that begins positive: none is missed and none invented.

Intervals are cut in half until each is shown to be free of zeros by a Taylor form of order 2, or to
hold exactly one where the function falls or is concave and changes its sign. That one is found by
Newton's method and enclosed by an interval Newton step (R. E. Moore, Interval Analysis, 1966).
"""

from __future__ import annotations

from collections.abc import Callable

from flint import arb, ctx

from camcli.exact.balls import UndecidedError

Function = Callable[[arb], list[arb]]  # x -> [value, slope, second derivative, ...]
LEAST_BITS = 400  # cutting gives up, too near a double zero, at half of the digits or at these
COARSE = 64  # bits that exclude zeros
NEWTON = 30  # steps


def first_root(f: Function, low: arb, high: arb) -> arb | None:
    """The first zero of f between two points, or None; f is positive just after `low`.

    Raises UndecidedError near a double zero, and where `high` itself may be a zero.
    """
    low, high, full = low.mid(), high.mid(), ctx.prec
    try:  # few digits exclude as surely as many, where they do
        ctx.prec = COARSE
        found = _bracket(f, low, high)
    except UndecidedError:
        ctx.prec = full
        found = _bracket(f, low, high)
    finally:
        ctx.prec = full
    return None if found is None else _enclosed(f, *found)


def _bracket(f: Function, low: arb, high: arb) -> tuple[arb, arb] | None:
    """Two points with the first zero and no other between them, the second beyond it."""
    least = float(high - low) * 2.0 ** -min(ctx.prec // 2, LEAST_BITS)
    todo = [(low, high)]
    while todo:
        a, b = todo.pop()
        x = a.union(b)
        whole = f(x)
        if whole[0] > 0:
            continue
        middle = x.mid()
        at = f(middle)
        h = x - middle
        if at[0] + h * (at[1] + h * whole[2] / 2) > 0:
            continue
        if whole[1] < 0 or whole[2] < 0:  # at most one zero: it falls, or is concave from above 0
            end = f(b)[0]
            if end > 0:
                continue
            if end < 0:
                return a, b
        if float(b - a) < least:
            raise UndecidedError
        if at[0].contains(0):  # a zero on the cut would belong to both sides
            middle = (3 * a + 2 * b) / 5
        todo += [(middle.mid(), b), (a, middle.mid())]
    return None


def _enclosed(f: Function, a: arb, b: arb) -> arb:
    """The only zero between a, where f is positive or zero, and b, where it is negative."""
    x = ((a + b) / 2).mid()
    for _ in range(NEWTON):
        value, slope = f(x)[:2]
        if value > 0:
            a = x
        elif value < 0:
            b = x
        else:
            break  # as near as the radius of f allows
        after = (x - value / slope).mid()
        if slope < 0 and abs(after - x) <= abs(x) * arb(2) ** (8 - ctx.prec):
            break
        x = after if slope < 0 and a < after < b else ((a + b) / 2).mid()
    value, slope = f(x)[:2]
    room = 4 * (abs(value) / abs(slope)).abs_upper() + arb(2) ** (16 - ctx.prec)
    around = arb(x, room)
    slope = f(around)[1]
    root = x - value / slope
    if not slope < 0 or not around.contains_interior(root):
        raise UndecidedError
    return root


def refined(f: Function, x: arb) -> arb:
    """The zero in x of a function that falls on all of it, as sharply as its own balls allow."""
    while True:
        middle = x.mid()
        root = middle - f(middle)[0] / f(x)[1]
        if not root.rad() < x.rad() / 2:
            return x
        x = root
