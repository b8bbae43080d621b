"""What happens when a fixed point of a continuous map meets a border: the normal form in the plane.

    x' = tau_L x + y + mu,  y' = -delta_L x   for x <= 0
    x' = tau_R x + y + mu,  y' = -delta_R x   for x > 0

Trace and determinant of the two one-sided Jacobians at the border decide everything. Sources: Nusse
& Yorke (1992) and Banerjee & Grebogi, Phys. Rev. E 59 (1999) 4052 for the form and its 2-cycle;
Feigin's parity rules; Banerjee, Yorke & Grebogi, PRL 80 (1998) 3049 for robust chaos; Hassouneh,
Abed & Nusse, PRL 92 (2004) 070201 for dangerous bifurcations. No units; nothing raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log

from camcli.analysis.border_cycles import (
    RENORM,
    Cycle,
    NormalForm,
    Prediction,
    Side,
    attractor,
    cycle,
    size_of,
    unclear,
)

KINDS = (
    ("degenerate", "an equality holds within rounding: the linear parts do not decide"),
    ("dangerous", "a stable fixed point on both sides, yet its basin shrinks to nothing at mu = 0"),
    ("robust-chaos", "a chaotic attractor for one sign of mu, and for all sides close to these"),
    ("no-attractor", "something attracts on one side, nothing bounded on the other"),
    ("nonsmooth-fold", "two fixed points are born for one sign of mu, there is none for the other"),
    ("border-period-doubling", "a fixed point on each side, and a cycle LR is born for one sign"),
    ("persistence", "a fixed point on each side, and no cycle LR is born"),
)
PLAIN, THEOREM = 8, 7  # inequalities of parity and stability, and of robust chaos
AT_ZERO_STEPS, AT_ZERO_LOG = 20_000, 30.0  # orbits at mu = 0: steps, and the log that decides
DECIDED = AT_ZERO_LOG / AT_ZERO_STEPS  # a smaller growth at mu = 0 is not told from none


@dataclass(frozen=True)
class Inequality:
    """One inequality as printed, the numbers on its two sides, and whether it holds."""

    text: str
    left: float
    right: float
    holds: bool


@dataclass(frozen=True)
class Collision:
    """The verdict on one border collision, of a kind in KINDS.

    `below` and `above` say what attracts for mu < 0 and mu > 0; `inequalities` are those the
    verdict rests on, up to the first that fails for robust chaos; `words` are plain sentences.
    """

    kind: str
    inequalities: tuple[Inequality, ...]
    cycles: tuple[Cycle, ...]
    below: Prediction
    above: Prediction
    words: tuple[str, ...]


def classify(left: Side, right: Side) -> Collision:
    """Name the border collision of two sides and follow what attracts before and after it.

    Equations: fixed points at x = mu / (1 - tau + delta), the 2-cycle LR at x_L = mu (1 + tau_R +
    delta_R) / q and x_R = mu (1 + tau_L + delta_L) / q with q = 1 - (tau_L tau_R - delta_L -
    delta_R) + delta_L delta_R. Whatever cannot be decided is said so in `below`, `above`, `words`.
    """
    cycles = tuple(cycle(word, left, right) for word in ("L", "R", "LR"))
    below, above = attractor(left, right, -1), attractor(left, right, 1)
    chaos, equal = _robust_chaos(left, right), equalities(left, right)
    checks = [*_parity(left, right), *_stability("L", left), *_stability("R", right)]
    if left.stable and right.stable:
        growth = growth_at_zero(left, right)
        checks.append(_more(f"log growth per step at mu = 0 > {DECIDED:.2g}", growth, DECIDED))
    kind = "degenerate" if equal else _kind(checks, chaos, below, above)
    words = (
        f"{kind}: {dict(KINDS)[kind]}.",
        *(f"Equal within rounding: {text}." for text in equal),
        *_undecided_growth(checks),
        f"For mu < 0, {_ends(below)}.",
        f"For mu > 0, {_ends(above)}.",
        *_two_cycle(cycles[2]),
        *_no_theorem(chaos),
    )
    return Collision(kind, (*checks, *chaos), cycles, below, above, words)


def equalities(left: Side, right: Side) -> list[str]:
    """Every equality that holds within rounding and leaves the verdict open."""
    found = [
        f"on {name}, {text}" for name, side in _named(left, right) if (text := side.degenerate)
    ]
    if left.at_minus_one * right.at_minus_one < 0.0:
        trace = left.trace * right.trace - left.det - right.det
        text = Side(trace, left.det * right.det).degenerate
        found += [f"along LR, {text}"] * bool(text)
    chaos = _robust_chaos(left, right)
    if len(chaos) == THEOREM and unclear(*_crisis(*_saddle_first(left, right))):
        found.append("the unstable manifold of a fixed point touches the stable one of the saddle")
    return found


def _named(left: Side, right: Side) -> list[tuple[str, Side]]:
    return [("L", left), ("R", right)]


def _saddle_first(left: Side, right: Side) -> tuple[Side, Side]:
    """The two sides, that of the regular saddle first; in their order if it is neither or both."""
    return (right, left) if right.at_one < 0.0 < left.at_one else (left, right)


def _more(text: str, left: float, right: float = 0.0) -> Inequality:
    return Inequality(text, left, right, left > right)


def _less(text: str, left: float, right: float = 0.0) -> Inequality:
    return Inequality(text, left, right, left < right)


def _parity(left: Side, right: Side) -> list[Inequality]:
    """Feigin's rules: the signs say whether the number of multipliers beyond +1, -1 is odd."""
    one, minus_one = left.at_one * right.at_one, left.at_minus_one * right.at_minus_one
    return [
        _more("(1 - tau_L + delta_L)(1 - tau_R + delta_R) > 0", one),
        _less("(1 + tau_L + delta_L)(1 + tau_R + delta_R) < 0", minus_one),
    ]


def _stability(name: str, side: Side) -> list[Inequality]:
    return [
        _more(f"1 - tau_{name} + delta_{name} > 0", side.at_one),
        _more(f"1 + tau_{name} + delta_{name} > 0", side.at_minus_one),
        _less(f"delta_{name} < 1", side.det, 1.0),
    ]


def _crisis(saddle: Side, other: Side) -> tuple[float, ...]:
    """Terms of the existence condition of Banerjee, Yorke & Grebogi, times a positive number.

    Their sum is positive where the first fold of the unstable manifold of the regular saddle comes
    back on the inner side of its stable one, which closes a trapping region.
    """
    l1, l2 = saddle.multipliers
    return l1 * other.trace * (l1 - 1.0), -other.det * (l1 - 1.0), l1 * l1 * (1.0 - l2)


def _robust_chaos(left: Side, right: Side) -> tuple[Inequality, ...]:
    """The conditions of Banerjee, Yorke & Grebogi up to the first that fails: THEOREM if none."""
    saddle, other = _saddle_first(left, right)
    s, o = ("L", "R") if saddle is left else ("R", "L")
    found = []
    for condition in (
        lambda: _more(f"tau_{s} > 1 + delta_{s}", saddle.trace, 1.0 + saddle.det),
        lambda: _less(f"tau_{o} < -(1 + delta_{o})", other.trace, -(1.0 + other.det)),
        lambda: _more(f"delta_{s} > 0", saddle.det),
        lambda: _less(f"delta_{s} < 1", saddle.det, 1.0),
        lambda: _more(f"delta_{o} > 0", other.det),
        lambda: _less(f"delta_{o} < 1", other.det, 1.0),
        lambda: _more(
            f"(l1 tau_{o} - delta_{o})(l1 - 1) + l1^2 (1 - l2) > 0, l1 > l2 the multipliers of {s}",
            sum(_crisis(saddle, other)),
        ),
    ):
        found.append(condition())
        if not found[-1].holds:
            break
    return tuple(found)


def _kind(checks, chaos, below: Prediction, above: Prediction) -> str:
    nowhere = [found.kind == "none" for found in (below, above)]
    one_each_side, born_two = checks[0].holds, checks[1].holds
    if len(checks) > PLAIN and checks[-1].holds:
        return "dangerous"
    if len(chaos) == THEOREM and chaos[-1].holds:
        return "robust-chaos"
    if one_each_side and nowhere[0] != nowhere[1]:
        return "no-attractor"
    if not one_each_side:
        return "nonsmooth-fold"
    return "border-period-doubling" if born_two else "persistence"


def growth_at_zero(left: Side, right: Side) -> float:
    """Largest mean growth, log per step, of an orbit at mu = 0, where the map is homogeneous.

    A direction that repeats and grows draws others to it if |det| < 1. Where both determinants are
    positive, the orbit of one of the two directions of the border ends on it, as critical points do
    in Singer's theorem; elsewhere the sixteen directions tried are a sample.
    """
    form = NormalForm(left, right, 0.0)
    square = [turned for t in (-1.0, -0.5, 0.0, 0.5) for turned in ((1.0, t), (-t, 1.0))]
    return max(_growth(form, sign * x, sign * y) for x, y in square for sign in (1.0, -1.0))


def _growth(form: NormalForm, x: float, y: float) -> float:
    total, steps = 0.0, 0
    while steps < AT_ZERO_STEPS and abs(total) < AT_ZERO_LOG:
        *_, (x, y) = form.run(x, y, RENORM, inf)
        size = size_of(x, y)
        if size == 0.0:
            return -inf
        total, steps, x, y = total + log(size), steps + RENORM, x / size, y / size
    return total / steps


def _undecided_growth(checks: list[Inequality]) -> list[str]:
    if len(checks) == PLAIN or abs(checks[-1].left) > DECIDED:
        return []
    return [
        f"The growth at mu = 0, {checks[-1].left:.2g} per step, is too small to exclude danger."
    ]


def _ends(found: Prediction) -> str:
    measured = (
        "" if found.exponent is None else f"{found.exponent:.4g} +- {found.spread:.1g} per step"
    )
    return {
        "none": "nothing bounded attracts",
        "fixed-point": f"the fixed point {found.word} attracts",
        "cycle": f"the cycle {found.word} of period {found.period} attracts",
        "chaos": f"a chaotic attractor, largest exponent {measured}",
        "several": f"several attract: {found.word}",
        "undecided": f"not decided, orbits stay bounded: {found.word or 'no period'}, {measured}",
    }[found.kind]


def _two_cycle(found: Cycle) -> list[str]:
    if not found.exists_for:
        return []
    sign, first = "<>"[found.exists_for > 0], found.multipliers[0]
    twisted = isinstance(first, complex)
    size = (
        f"multipliers {first.real:.6g} +- {first.imag:.6g} i"
        if twisted
        else f"larger multiplier {first:.6g}"
    )
    state = "stable" if found.stable else "unstable"
    return [f"The cycle LR exists for mu {sign} 0 and is {state}: {size}."]


def _no_theorem(chaos: tuple[Inequality, ...]) -> list[str]:
    last = chaos[-1]
    if len(chaos) < 2 or last.holds:
        return []
    numbers = f"{last.left:.6g} against {last.right:.6g}"
    open_end = ", which leaves it open whether a chaotic attractor exists" * (len(chaos) == THEOREM)
    return [f"The theorem on robust chaos does not apply: {last.text} fails, {numbers}{open_end}."]
