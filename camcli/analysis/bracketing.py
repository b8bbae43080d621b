"""Lowest value over an interval, and a bracketed root; the same bits on every machine.

Golden sections refine a minimum. A root is bracketed by the ITP method of I. F. D. Oliveira and
R. H. C. Takahashi, ACM Trans. Math. Softw. 47 (2021), article 5.
"""

from collections.abc import Callable
from math import inf

GOLDEN = 0.6180339887498949
TIE = 1e-14  # relative difference that counts as none: the earlier place is then named
CLOSEST = 1e-9  # of the argument: f is flat there, its least value exact to rounding
NARROW = 1e-12  # relative width of a bracket: some hundred times the rounding of a simulated root
FIRST_CUT, MOST_STEPS = 0.2, 200  # kappa_1 of the ITP method; bisection alone needs 60 steps


def lowest(
    f: Callable[[float], float], low: float, high: float, samples: int
) -> tuple[float, float]:
    """(value, x) of the smallest f on [low, high], ends included; f may be inf in places.

    Every local minimum among the samples is refined by golden sections; f must be smooth enough
    to have one minimum between three neighbouring samples. Where the least sample is at an end, a
    minimum inside has to be lower by more than TIE.
    """
    xs = [low + (high - low) * (k / samples) for k in range(samples)] + [high]
    ys = [f(x) for x in xs]
    best = min(range(len(xs)), key=ys.__getitem__)
    if best == samples and ys[0] <= ys[-1] + TIE * abs(ys[-1]):
        best = 0  # both ends, as where the interval is a whole turn
    value = ys[best]
    best_x = xs[best]
    tie = TIE * abs(value) if best in (0, samples) and abs(value) < inf else 0.0
    for k, y in enumerate(ys):
        left = max(k - 1, 0)
        right = min(k + 1, samples)
        is_flat = y == ys[left] == ys[right]
        if y == inf or y > ys[left] or y > ys[right] or is_flat:
            continue
        refined, x = _golden(f, xs[left], xs[right])
        if refined < value - tie:
            tie = 0.0
            value = refined
            best_x = x
    return value, best_x


def _golden(f: Callable[[float], float], a: float, b: float) -> tuple[float, float]:
    """(f, x) at the minimum of f in [a, b], by golden section; f has a single one there.

    a < x < y < b; the part beyond the higher one of f(x) and f(y) is given up.
    """
    x = b - GOLDEN * (b - a)
    y = a + GOLDEN * (b - a)
    fx = f(x)
    fy = f(y)
    while b - a > CLOSEST:
        if fx <= fy:
            b = y
            y = x
            fy = fx
            x = b - GOLDEN * (b - a)
            fx = f(x)
        else:
            a = x
            x = y
            fx = fy
            y = a + GOLDEN * (b - a)
            fy = f(y)
    return (fx, x) if fx <= fy else (fy, y)


def bracket(
    f: Callable[[float], float], low: float, high: float, f_low: float, f_high: float
) -> tuple[float, float, float, float]:
    """(low, high, f_low, f_high) with f_low < 0 <= f_high, narrowed to a relative NARROW.

    Needs f(low) < 0 <= f(high); f may be inf. The next x is, as in the ITP method, the root of the
    secant, pushed a little towards the middle, and then kept so near to the middle that all steps
    together are never more than one beyond bisection. So a jump of f is bracketed as well as a
    root.
    """
    width = high - low
    allowed = 2.0 * width  # as wide as the bracket may be at this step, but for one step more
    for _ in range(MOST_STEPS):
        goal = NARROW * abs(high)
        if high - low <= goal:
            break
        allowed *= 0.5
        middle = 0.5 * (low + high)
        from_middle = max(0.5 * goal, allowed - 0.5 * (high - low))
        x = (f_high * low - f_low * high) / (f_high - f_low) if f_high < inf else middle
        push = max(FIRST_CUT * (high - low) * (high - low) / width, 0.3 * goal)
        toward = 1.0 if middle >= x else -1.0
        x = x + toward * push if push <= abs(middle - x) else middle
        x = min(max(x, middle - from_middle), middle + from_middle)
        if not low < x < high:
            x = middle
        if x in (low, high):
            break
        y = f(x)
        if y < 0.0:
            low = x
            f_low = y
        else:
            high = x
            f_high = y
    return low, high, f_low, f_high
