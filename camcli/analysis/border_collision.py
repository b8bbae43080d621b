"""What happens when a fixed point of a continuous map meets a border: the normal form in the plane.

    x' = tau_L x + y + mu,  y' = -delta_L x   for x <= 0
    x' = tau_R x + y + mu,  y' = -delta_R x   for x > 0

Trace and determinant of the two one-sided Jacobians at the border decide everything, and only the
sign of mu matters: scaling x, y and mu by one positive number changes nothing. A word of L and R
names a cycle by the sides it visits. Sources: Nusse & Yorke, Physica D 57 (1992) 39 and Banerjee &
Grebogi, Phys. Rev. E 59 (1999) 4052 for the form and its 2-cycle; Feigin's parity rules as in di
Bernardo, Budd, Champneys & Kowalczyk, Piecewise-smooth Dynamical Systems (2008), ch. 3; Banerjee,
Yorke & Grebogi, PRL 80 (1998) 3049 for robust chaos; Hassouneh, Abed & Nusse, PRL 92 (2004) 070201
for dangerous bifurcations. No units; nothing raises, an overflow counts as an escape. `log` alone
comes from libm, and only exponents and growths pass through it.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import fsum, inf, log, prod, sqrt

from camcli.analysis.multipliers import multipliers

LONGEST_WORD = 64
TRANSIENT = 1_000  # steps before an orbit's symbols are read
REPEATED_SYMBOLS = 4 * LONGEST_WORD  # symbols that must repeat
BLOCKS, BLOCK = 16, 512  # of the record an exponent is measured on
ESCAPED = 1e9  # times |mu| and the farthest fixed point, virtual or not: counts as infinity
BESIDE_CYCLE = 1e-3  # relative distance of a start from an unstable cycle
RINGS = (1.0, 4.0, 16.0, 64.0)  # radii of further starts, in |mu|
GROWN = 10.0  # by this factor over a record whose symbols repeat: it is on its way to infinity
SURE_OF_CHAOS = 3.0  # standard errors by which chaos has its exponent above zero
FLOOR = 1e-3  # amount by which it has
RENORM = 16  # steps between two renormalisations of a tangent
# of the sum of the terms: a sum below this share of it may have either sign
SUM_ROUNDING = 2.0**-49
THEOREM = 7  # conditions for robust chaos
AT_ZERO_STEPS, AT_ZERO_LOG = 20_000, 30.0  # orbits at mu = 0: steps, and the log that decides
DECIDED = AT_ZERO_LOG / AT_ZERO_STEPS  # a smaller growth at mu = 0 is not told from none

Point = tuple[float, float]


def unclear(*terms: float) -> bool:
    """True where the sum of the terms is zero within the rounding of the terms."""
    return abs(fsum(terms)) <= SUM_ROUNDING * fsum(map(abs, terms))


class Equal(StrEnum):
    """What holds with equality, within rounding, so that the linear parts do not decide."""

    PLUS_ONE = "multiplier-plus-one"
    MINUS_ONE = "multiplier-minus-one"
    UNIT_PAIR = "complex-pair-on-the-unit-circle"
    TANGENCY = "manifolds-touch"  # the unstable one of a fixed point, the stable one of the saddle


class Rule(StrEnum):
    """What an inequality is about; the formulas stand in `camcli.words.border_collision`."""

    PRODUCT_AT_ONE = "product-at-one"
    PRODUCT_AT_MINUS_ONE = "product-at-minus-one"
    AT_ONE = "at-one"
    AT_MINUS_ONE = "at-minus-one"
    DET_BELOW_ONE = "det-below-one"
    DET_POSITIVE = "det-positive"
    GROWTH = "growth"
    BEYOND_ONE = "multiplier-beyond-one"
    BEYOND_MINUS_ONE = "multiplier-beyond-minus-one"
    TRAPPING = "trapping-region"


# the others say that the left side is the greater one
LESS = (Rule.PRODUCT_AT_MINUS_ONE, Rule.DET_BELOW_ONE, Rule.BEYOND_MINUS_ONE)


@dataclass(frozen=True)
class Side:
    """Trace and determinant of the map on one side of the border, or of one turn of a cycle."""

    trace: float
    det: float

    @property
    def at_one(self) -> float:
        """1 - trace + det, the characteristic polynomial at +1."""
        return 1.0 - self.trace + self.det

    @property
    def at_minus_one(self) -> float:
        """1 + trace + det, the characteristic polynomial at -1."""
        return 1.0 + self.trace + self.det

    @property
    def multipliers(self) -> tuple[complex, complex]:
        """Eigenvalues of the map on this side."""
        return multipliers(self.trace, self.det)

    @property
    def stable(self) -> bool:
        """Both multipliers inside the unit circle, by more than rounding (Jury's conditions)."""
        inside = self.at_one > 0.0 and self.at_minus_one > 0.0 and self.det < 1.0
        return inside and not self.degenerate

    @property
    def degenerate(self) -> Equal | None:
        """The multiplier that lies on the unit circle within rounding, if any."""
        if unclear(1.0, -self.trace, self.det):
            return Equal.PLUS_ONE
        if unclear(1.0, self.trace, self.det):
            return Equal.MINUS_ONE
        if self.multipliers[0].imag != 0.0 and unclear(1.0, -self.det):
            return Equal.UNIT_PAIR
        return None

    @property
    def kind(self) -> str:
        """Node, spiral or saddle. `flip`: a negative multiplier; of a saddle, the unstable one."""
        if self.degenerate:
            return "nonhyperbolic"
        if self.at_one * self.at_minus_one < 0.0:
            return "regular saddle" if self.at_one < 0.0 else "flip saddle"
        if self.multipliers[0].imag != 0.0:
            return "spiral attractor" if self.stable else "spiral repeller"
        if self.trace < 0.0 or self.det < 0.0:  # one of them is negative
            return "flip attractor" if self.stable else "flip repeller"
        return "attracting node" if self.stable else "repelling node"


@dataclass(frozen=True)
class Cycle:
    """A cycle of the normal form, of the word read from its leftmost symbols on.

    `exists_for` is the sign of mu at which its points lie on the sides the word says, 0 for
    neither; `points` are those at mu = exists_for, in the order of the word, none if it is 0.
    """

    word: str
    multipliers: tuple
    stable: bool
    points: tuple[Point, ...] = ()
    exists_for: int = 0


@dataclass(frozen=True)
class Prediction:
    """What attracts at one sign of mu.

    `kind` is fixed-point, cycle, chaos, none (every orbit followed escapes), several or undecided;
    `word` the sides visited, or all that attract. `exponent`: the largest Lyapunov exponent per
    step of natural logarithm, exact for a cycle, else measured with its standard error `spread`.
    """

    kind: str
    period: int = 0
    exponent: float | None = None
    word: str = ""
    spread: float = 0.0


@dataclass(frozen=True)
class NormalForm:
    """The map of the module's head with its two sides, at one sign of mu."""

    left: Side
    right: Side
    mu: float

    def run(self, x: float, y: float, steps: int, limit: float = inf) -> Iterator[Point]:
        """The next `steps` points; ends early with the first one whose x is beyond `limit`."""
        left_trace = self.left.trace
        left_det = self.left.det
        right_trace = self.right.trace
        right_det = self.right.det
        mu = self.mu
        for _ in range(steps):
            if x <= 0.0:
                x, y = left_trace * x + y + mu, -left_det * x
            else:
                x, y = right_trace * x + y + mu, -right_det * x
            yield x, y
            if not -limit < x < limit:
                return


def cycle(word: str, left: Side, right: Side) -> Cycle:
    """The cycle of a word.

    Its turn is affine, p -> M p + s with s proportional to mu, and its first point solves
    (I - M) p = s. The determinant of M is the product of the sides' determinants, which is exact
    where that of the entries would cancel.
    """
    m_xx, m_xy, m_yx, m_yy = 1.0, 0.0, 0.0, 1.0
    s_x, s_y = 0.0, 0.0  # at mu = 1
    sides = [left if symbol == "L" else right for symbol in word]
    for side in sides:  # M and s become those of one step more
        trace = side.trace
        det = side.det
        m_xx, m_xy, m_yx, m_yy = trace * m_xx + m_yx, trace * m_xy + m_yy, -det * m_xx, -det * m_xy
        s_x, s_y = trace * s_x + s_y + 1.0, -det * s_x
    turn = Side(m_xx + m_yy, prod(side.det for side in sides))
    if turn.at_one == 0.0:
        return Cycle(word, turn.multipliers, False)
    x = ((1.0 - m_yy) * s_x + m_xy * s_y) / turn.at_one
    y = (m_yx * s_x + (1.0 - m_xx) * s_y) / turn.at_one
    for sign in (1, -1):
        first = sign * x, sign * y
        others = NormalForm(left, right, float(sign)).run(*first, len(word) - 1)
        points = (first, *others)
        if _sides(points) == word:
            return Cycle(word, turn.multipliers, turn.stable, points, sign)
    return Cycle(word, turn.multipliers, turn.stable)


def _sides(points: Iterable[Point]) -> str:
    """The word of the sides on which points lie."""
    return "".join("L" if x <= 0.0 else "R" for x, _ in points)


def repeating(symbols: str) -> str:
    """The shortest word that repeats all through the symbols, first in lexical order, or ''."""
    for p in range(1, min(LONGEST_WORD, len(symbols) // 2) + 1):
        if symbols[p:] == symbols[:-p]:
            return min(symbols[k : k + p] for k in range(p))
    return ""


def attractor(left: Side, right: Side, mu: int) -> Prediction:
    """What attracts at mu = +1 or -1.

    Stable fixed points and 2-cycles come from their formulas; the rest from orbits that start near
    every cycle of period 1 or 2, at the border, and on RINGS. Where both determinants are positive
    and no fixed point exists, nothing bounded does (Brouwer's plane translation theorem).
    """
    cycles = [cycle(word, left, right) for word in ("L", "R", "LR")]
    existing = [one for one in cycles if one.exists_for == mu]
    no_fixed_point = all(len(one.word) == 2 for one in existing)
    if left.det > 0.0 and right.det > 0.0 and no_fixed_point:
        return Prediction("none")
    form = NormalForm(left, right, float(mu))
    attracting = {one.word: _settled(one) for one in existing if one.stable}  # by word
    for start in _starts(existing):
        end = _follow(form, start, "aperiodic" not in attracting)
        if end.kind != "none":
            attracting.setdefault(end.word or "aperiodic", end)
    predictions = list(attracting.values())
    if len(predictions) < 2:
        return predictions[0] if predictions else Prediction("none")
    words = ", ".join(sorted(one.word or one.kind for one in predictions))
    for one in predictions:
        if one.kind == "undecided":
            return Prediction("undecided", 0, one.exponent, words, one.spread)
    return Prediction("several", word=words)


def _settled(stable: Cycle) -> Prediction:
    """The prediction for motion that ends on a stable cycle.

    The exponent is the mean growth per step of the cycle's larger multiplier: ln |z|/period, the
    logarithm taken of |z|^2.
    """
    larger = stable.multipliers[0]
    period = len(stable.word)
    square = larger.real * larger.real + larger.imag * larger.imag
    exponent = log(square) / (2.0 * period) if square > 0.0 else -inf
    return Prediction("cycle" if period > 1 else "fixed-point", period, exponent, stable.word)


def size_of(x: float, y: float) -> float:
    """A norm that needs no root: |x| + |y|."""
    return abs(x) + abs(y)


def _starts(cycles: list[Cycle]) -> Iterator[Point]:
    """Points to follow the map from: the origin, points beside every cycle, and rings.

    About each centre lie four, a radius away along x and y.
    """
    origin = (0.0, 0.0)
    yield origin
    circles = [
        (point, BESIDE_CYCLE * (1.0 + size_of(*point))) for one in cycles for point in one.points
    ]
    circles += [(origin, ring) for ring in RINGS]
    for (x, y), radius in circles:
        yield x + radius, y
        yield x - radius, y
        yield x, y + radius
        yield x, y - radius


def _follow(form: NormalForm, start: Point, measure: bool) -> Prediction:
    """What an orbit ends on; the exponent of an aperiodic one is measured if `measure`.

    A word that it repeats without a cycle that attracts is followed on, too: where the orbit has
    grown since, it goes away from a cycle that repels, and ends on nothing.
    """
    limit = ESCAPED / min(1.0, *(abs(side.at_one) or 1.0 for side in (form.left, form.right)))
    *_, (x, y) = form.run(*start, TRANSIENT, limit)
    word, prediction = _word(form, x, y, limit)
    if prediction is not None:
        return prediction
    if not word and not measure:
        return Prediction("undecided")
    size = size_of(x, y)
    exponent, spread, (x, y) = _exponent(form, x, y, limit)
    word, prediction = _word(form, x, y, limit)
    if prediction is not None:
        return prediction
    if word:
        kind = "none" if size_of(x, y) > GROWN * size else "undecided"
    else:
        kind = "chaos" if exponent > max(SURE_OF_CHAOS * spread, FLOOR) else "undecided"
    return Prediction(kind, 0, exponent, word, spread)


def _word(form: NormalForm, x: float, y: float, limit: float) -> tuple[str, Prediction | None]:
    """(the word that an orbit from (x, y) repeats, '' where none; what it ends on, None if open).

    It ends on nothing beyond the limit, and on the cycle of its word where that exists at this mu
    and attracts.
    """
    if not abs(x) < limit:
        return "", Prediction("none")
    points = list(form.run(x, y, REPEATED_SYMBOLS, limit))
    last_x, _ = points[-1]
    if not abs(last_x) < limit:
        return "", Prediction("none")
    word = repeating(_sides(points))
    if not word:
        return word, None
    repeated = cycle(word, form.left, form.right)
    if not repeated.stable or repeated.exists_for * form.mu <= 0.0:
        return word, None
    return word, _settled(repeated)


def _exponent(form: NormalForm, x: float, y: float, limit: float) -> tuple[float, float, Point]:
    """(mean growth of the log of a tangent per step, its standard error, the last point).

    The tangent (u, v) is carried along the orbit in BLOCKS blocks of BLOCK steps, and scaled back
    to length 1 every RENORM steps. The blocks' scatter gives the error.
    """
    rates = []
    u = 1.0
    v = 0.0
    for _ in range(BLOCKS):
        growth = 0.0
        for k, after in enumerate(form.run(x, y, BLOCK, limit), 1):
            side = form.left if x <= 0.0 else form.right
            u, v = side.trace * u + v, -side.det * u
            x, y = after
            if k % RENORM == 0:
                size = size_of(u, v)
                if size == 0.0:
                    return -inf, 0.0, (x, y)
                growth += log(size)
                u = u / size
                v = v / size
        rates.append(growth / BLOCK)
        if not abs(x) < limit:
            break
    mean = fsum(rates) / len(rates)
    squares = fsum((rate - mean) * (rate - mean) for rate in rates)
    return mean, sqrt(squares / max(len(rates) - 1, 1) / len(rates)), (x, y)


@dataclass(frozen=True)
class Inequality:
    """One inequality, and the numbers on its two sides; side: L or R where it is about one."""

    rule: Rule
    side: str
    left: float
    right: float = 0.0

    @property
    def holds(self) -> bool:
        """Whether the inequality holds."""
        return self.left < self.right if self.rule in LESS else self.left > self.right


@dataclass(frozen=True)
class Collision:
    """The verdict on one border collision.

    kind: degenerate (an equality holds within rounding: the linear parts do not decide), dangerous
    (a stable fixed point on both sides, yet its basin shrinks to nothing at mu = 0), robust-chaos
    (a chaotic attractor for one sign of mu, and for all sides close to these), no-attractor
    (something attracts on one side, nothing bounded on the other), nonsmooth-fold (two fixed points
    are born for one sign of mu, there is none for the other), border-period-doubling (a fixed point
    on each side, and a cycle LR is born for one sign) or persistence (no such cycle).
    parity: what the kind rests on, of Feigin's rules and of stability; growth: at mu = 0, log per
    step, where both sides are stable; chaos: the conditions for robust chaos up to the first that
    fails; equal: equalities within rounding that leave the verdict open, each with the side, or the
    cycle LR, that it is about; cycles: L, R and LR; below, above: what attracts for mu < 0 and
    mu > 0.
    """

    kind: str
    parity: tuple[Inequality, ...]
    growth: Inequality | None
    chaos: tuple[Inequality, ...]
    equal: tuple[tuple[str, Equal], ...]
    cycles: tuple[Cycle, ...]
    below: Prediction
    above: Prediction

    @property
    def inequalities(self) -> tuple[Inequality, ...]:
        """All inequalities that the verdict rests on."""
        growth = () if self.growth is None else (self.growth,)
        return (*self.parity, *growth, *self.chaos)


def classify(left: Side, right: Side) -> Collision:
    """Name the border collision of two sides and follow what attracts before and after it.

    Equations: fixed points at x = mu / (1 - tau + delta), the 2-cycle LR at x_L = mu (1 + tau_R +
    delta_R) / q and x_R = mu (1 + tau_L + delta_L) / q with q = 1 - (tau_L tau_R - delta_L -
    delta_R) + delta_L delta_R. Whatever cannot be decided is `undecided` in `below`, `above`.
    """
    below = attractor(left, right, -1)
    above = attractor(left, right, 1)
    chaos, equal = _robust_chaos(left, right)
    for name, side in (("R", right), ("L", left)):
        if side.degenerate is not None:
            equal.insert(0, (name, side.degenerate))
    parity = _parity(left, right)
    one_each_side = parity[0].holds  # a fixed point before the collision and one after it
    born_two = parity[1].holds  # a cycle of two appears
    growth = None
    if left.stable and right.stable:
        growth = Inequality(Rule.GROWTH, "", growth_at_zero(left, right), DECIDED)
    if equal:
        kind = "degenerate"
    elif growth is not None and growth.holds:
        kind = "dangerous"
    elif chaos[-1].holds:  # the list ends with the first that fails
        kind = "robust-chaos"
    elif one_each_side and (below.kind == "none") != (above.kind == "none"):
        kind = "no-attractor"
    elif not one_each_side:
        kind = "nonsmooth-fold"
    else:
        kind = "border-period-doubling" if born_two else "persistence"
    return Collision(
        kind=kind,
        parity=tuple(parity),
        growth=growth,
        chaos=tuple(chaos),
        equal=tuple(equal),
        cycles=tuple(cycle(word, left, right) for word in ("L", "R", "LR")),
        below=below,
        above=above,
    )


def _parity(left: Side, right: Side) -> list[Inequality]:
    """Feigin's two rules, then the conditions for a stable fixed point on each side (Jury's).

    Feigin asks whether the number of real multipliers beyond +1, and of those beyond -1, is odd on
    both sides together: the products of the characteristic polynomials at +1 and at -1 tell.
    """
    at_one = left.at_one * right.at_one
    at_minus_one = left.at_minus_one * right.at_minus_one
    rules = [
        Inequality(Rule.PRODUCT_AT_ONE, "", at_one),
        Inequality(Rule.PRODUCT_AT_MINUS_ONE, "", at_minus_one),
    ]
    for name, side in (("L", left), ("R", right)):
        rules += [
            Inequality(Rule.AT_ONE, name, side.at_one),
            Inequality(Rule.AT_MINUS_ONE, name, side.at_minus_one),
            Inequality(Rule.DET_BELOW_ONE, name, side.det, 1.0),
        ]
    return rules


def _robust_chaos(left: Side, right: Side) -> tuple[list[Inequality], list[tuple[str, Equal]]]:
    """(the conditions of Banerjee, Yorke & Grebogi to the first that fails, what leaves all open).

    All are THEOREM. The sum of the terms of the last is positive where the first fold of the
    unstable manifold of the regular saddle comes back on the inner side of its stable one, which
    closes a trapping region. What leaves all open is an equality within rounding, of a side ("L",
    "R") or of the cycle "LR".
    """
    open_ends: list[tuple[str, Equal]] = []
    if left.at_minus_one * right.at_minus_one < 0.0:
        trace = left.trace * right.trace - left.det - right.det
        degenerate = Side(trace, left.det * right.det).degenerate
        if degenerate is not None:
            open_ends.append(("LR", degenerate))
    if right.at_one < 0.0 < left.at_one:
        saddle_name, saddle, other_name, other = "R", right, "L", left
    else:
        saddle_name, saddle, other_name, other = "L", left, "R", right
    inequalities = [
        Inequality(Rule.BEYOND_ONE, saddle_name, saddle.trace, 1.0 + saddle.det),
        Inequality(Rule.BEYOND_MINUS_ONE, other_name, other.trace, -(1.0 + other.det)),
        Inequality(Rule.DET_POSITIVE, saddle_name, saddle.det),
        Inequality(Rule.DET_BELOW_ONE, saddle_name, saddle.det, 1.0),
        Inequality(Rule.DET_POSITIVE, other_name, other.det),
        Inequality(Rule.DET_BELOW_ONE, other_name, other.det, 1.0),
    ]
    for k, condition in enumerate(inequalities, 1):
        if not condition.holds:
            return inequalities[:k], open_ends
    large, small = (z.real for z in saddle.multipliers)
    terms = (
        large * other.trace * (large - 1.0),
        -other.det * (large - 1.0),
        large * large * (1.0 - small),
    )
    if unclear(*terms):
        open_ends.append((saddle_name, Equal.TANGENCY))
    return [*inequalities, Inequality(Rule.TRAPPING, saddle_name, fsum(terms))], open_ends


def growth_at_zero(left: Side, right: Side) -> float:
    """Largest mean growth, log per step, of an orbit at mu = 0, where the map is homogeneous.

    A direction that repeats and grows draws others to it if |det| < 1. Where both determinants are
    positive, the orbit of one of the two directions of the border ends on it, as critical points do
    in Singer's theorem; elsewhere the sixteen directions tried are a sample.
    """
    form = NormalForm(left, right, 0.0)
    growths = []
    for t in (-1.0, -0.5, 0.0, 0.5):
        for x, y in ((1.0, t), (-t, 1.0), (-1.0, -t), (t, -1.0)):  # quarter turns
            growths.append(_growth(form, x, y))
    return max(growths)


def _growth(form: NormalForm, x: float, y: float) -> float:
    """Mean growth (log per step) along the orbit of the homogeneous map that starts at (x, y).

    The point is scaled back to size 1 after every RENORM steps, so that nothing overflows. It ends
    where the growth of AT_ZERO_LOG, up or down, decides.
    """
    growth = 0.0
    steps = 0
    while steps < AT_ZERO_STEPS and abs(growth) < AT_ZERO_LOG:
        *_, (x, y) = form.run(x, y, RENORM)
        size = size_of(x, y)
        if size == 0.0:
            return -inf
        growth = growth + log(size)
        steps = steps + RENORM
        x = x / size
        y = y / size
    return growth / steps
