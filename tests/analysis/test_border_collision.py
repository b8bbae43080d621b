"""Border collisions of the normal form in the plane: verdicts, cycles, attractors."""

import random
from math import inf, isclose, log, nan, prod, sqrt
from statistics import fmean, stdev

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from camcli.analysis import border_collision as module
from camcli.analysis.border_collision import (
    Cycle,
    Equal,
    NormalForm,
    Prediction,
    Rule,
    Side,
    _exponent,
    _starts,
    _word,
    attractor,
    classify,
    cycle,
    growth_at_zero,
)
from camcli.analysis.labels import APERIODIC, CONTACT, UNDECIDED, Label
from camcli.analysis.orbits.corner_impacts import _agree
from camcli.words.border_collision import KINDS, collision_words, inequality_text

SWAP = str.maketrans("LR", "RL")


def seeded(examples):
    """The same examples at every run, in any time."""
    return settings(max_examples=examples, deadline=None, derandomize=True)


def sides(trace_left, det_left, trace_right, det_right):
    return Side(trace_left, det_left), Side(trace_right, det_right)


def reals(size):
    return st.floats(-size, size).map(lambda value: round(value, 3))


ANY = st.builds(sides, reals(3.0), reals(1.5), reals(3.0), reals(1.5))
STABLE = st.builds(
    lambda a, b, s, t: sides(s * (1.0 + a), a, t * (1.0 + b), b),
    *[st.floats(0.02, 0.98)] * 2,
    *[st.floats(-0.98, 0.98)] * 2,
)


def step(left, right, mu, x, y):
    """The map once more, written out."""
    side = left if x <= 0.0 else right
    return side.trace * x + y + mu, -side.det * x


def iterate(left, right, mu, point, steps):
    for _ in range(steps):
        point = step(left, right, mu, *point)
        if not abs(point[0]) < 1e12:
            return None
    return point


@pytest.mark.parametrize(
    ("side", "kind"),
    [
        (Side(1.0, 0.2), "attracting node"),
        (Side(-1.0, 0.2), "flip attractor"),
        (Side(0.1, -0.5), "flip attractor"),
        (Side(0.5, 0.5), "spiral attractor"),
        (Side(0.5, 1.5), "spiral repeller"),
        (Side(1.7, 0.5), "regular saddle"),
        (Side(-1.7, 0.5), "flip saddle"),
        (Side(4.0, 3.5), "repelling node"),
        (Side(0.1, -3.0), "flip repeller"),
        (Side(1.3, 0.3), "nonhyperbolic"),
        (Side(0.3, 1.0), "nonhyperbolic"),
    ],
)
def test_kind_of_a_side(side, kind):
    assert side.kind == kind
    assert side.stable == ("attract" in kind)


@seeded(100)
@given(reals(1e3), reals(1e3))
def test_multipliers_have_the_sum_and_the_product(trace, det):
    large, small = Side(trace, det).multipliers
    assert abs(large) >= abs(small) * (1.0 - 1e-15)
    assert isclose((large + small).real, trace, rel_tol=1e-14, abs_tol=1e-13)
    assert isclose((large * small).real, det, rel_tol=1e-14, abs_tol=1e-300)
    assert isclose(Side(1e8, 1.0).multipliers[1].real, 1e-8, rel_tol=1e-15)  # not cancelled


@pytest.mark.parametrize(
    ("parameters", "kind", "below", "above"),
    [
        ((0.5, 0.2, -0.5, 0.3), "persistence", "fixed-point", "fixed-point"),
        ((0.5, 0.2, -1.6, 0.3), "border-period-doubling", "fixed-point", "chaos"),
        ((0.2, 0.2, -1.4, 0.3), "border-period-doubling", "fixed-point", "cycle"),
        ((1.7, 0.5, -1.7, 0.5), "robust-chaos", "none", "chaos"),
        ((-1.7, 0.5, 1.7, 0.5), "robust-chaos", "chaos", "none"),
        ((1.6418699, 0.64, 1.3714214, 0.64), "nonsmooth-fold", "none", "fixed-point"),
        ((1.3816246, 0.4096, -4.0910731, 0.4096), "border-period-doubling", "fixed-point", "chaos"),
        ((1.7, 0.5, -4.0, 0.5), "nonsmooth-fold", "none", "none"),
        ((2.4, 0.3, 2.2, 0.4), "persistence", "none", "none"),
        ((-0.5, 0.2, -3.6, 0.3), "no-attractor", "fixed-point", "none"),
        ((-1.85, 0.9, 0.4, 0.95), "dangerous", "several", "several"),
        ((1.2, 0.2, 0.1, 0.3), "degenerate", None, "fixed-point"),
        ((0.5, 0.2, -1.3, 0.3), "degenerate", "fixed-point", None),
    ],
)
def test_verdict(parameters, kind, below, above):
    found = classify(*sides(*parameters))
    assert found.kind == kind
    assert below in (None, found.below.kind)
    assert above in (None, found.above.kind)
    assert collision_words(found)[0].startswith(f"{kind}: {KINDS[kind]}")


def test_inequalities_carry_their_numbers():
    found = classify(*sides(1.6418699, 0.64, 1.3714214, 0.64))
    fold, last = found.inequalities[0], found.inequalities[-1]
    assert not fold.holds
    assert fold.left == pytest.approx(-0.0018699 * 0.2685786, rel=1e-12)
    assert (inequality_text(last), last.left) == ("tau_R < -(1 + delta_R)", 1.3714214)
    assert last.right == pytest.approx(-1.64, rel=1e-15)
    assert not last.holds
    assert "tau_R < -(1 + delta_R) fails, 1.37142 against -1.64" in collision_words(found)[-1]


@pytest.mark.parametrize("mirrored", [False, True])
def test_all_inequalities_with_the_numbers_of_both_sides(mirrored):
    """Traces 1.9 and -1.75, determinants 0.4 and 0.3: the saddle is L, or R where mirrored."""
    one, other = Side(1.9, 0.4), Side(-1.75, 0.3)
    saddle, beyond = ("R", "L") if mirrored else ("L", "R")
    found = classify(*((other, one) if mirrored else (one, other)))
    of_one = [(Rule.AT_ONE, -0.5, 0.0), (Rule.AT_MINUS_ONE, 3.3, 0.0),
              (Rule.DET_BELOW_ONE, 0.4, 1.0)]  # fmt: skip
    of_other = [(Rule.AT_ONE, 3.05, 0.0), (Rule.AT_MINUS_ONE, -0.45, 0.0),
                (Rule.DET_BELOW_ONE, 0.3, 1.0)]  # fmt: skip
    first, second = (of_other, of_one) if mirrored else (of_one, of_other)
    root = sqrt(1.9 * 1.9 - 4.0 * 0.4)
    large, small = 0.5 * (1.9 + root), 0.5 * (1.9 - root)
    trapping = (large * -1.75 - 0.3) * (large - 1.0) + large**2 * (1.0 - small)
    wanted = [
        (Rule.PRODUCT_AT_ONE, "", -0.5 * 3.05, 0.0),
        (Rule.PRODUCT_AT_MINUS_ONE, "", 3.3 * -0.45, 0.0),
        *((rule, "L", *numbers) for rule, *numbers in first),
        *((rule, "R", *numbers) for rule, *numbers in second),
        (Rule.BEYOND_ONE, saddle, 1.9, 1.4), (Rule.BEYOND_MINUS_ONE, beyond, -1.75, -1.3),
        (Rule.DET_POSITIVE, saddle, 0.4, 0.0), (Rule.DET_BELOW_ONE, saddle, 0.4, 1.0),
        (Rule.DET_POSITIVE, beyond, 0.3, 0.0), (Rule.DET_BELOW_ONE, beyond, 0.3, 1.0),
        (Rule.TRAPPING, saddle, trapping, 0.0),
    ]  # fmt: skip
    told = [*found.parity, *found.chaos]
    assert [(one.rule, one.side) for one in told] == [line[:2] for line in wanted]
    for one, (*_, left, right) in zip(told, wanted, strict=True):
        assert (one.left, one.right) == pytest.approx((left, right), rel=1e-12), one.rule


@pytest.mark.parametrize(
    ("of_sides", "equal"),
    [
        # of the cycle LR, 1 + tau_L tau_R - delta_L - delta_R + delta_L delta_R = 0
        ((0.3, 0.4, -1.4, 0.3), [("LR", Equal.MINUS_ONE)]),
        ((-1.4, 0.3, 0.3, 0.4), [("LR", Equal.MINUS_ONE)]),
        ((1.4, 0.4, -1.3, 0.3), [("L", Equal.PLUS_ONE), ("R", Equal.MINUS_ONE)]),
        ((-1.3, 0.3, 1.4, 0.4), [("L", Equal.MINUS_ONE), ("R", Equal.PLUS_ONE)]),
    ],
)
def test_whose_multiplier_is_on_the_unit_circle(of_sides, equal):
    found = classify(*sides(*of_sides))
    assert (found.kind, list(found.equal)) == ("degenerate", equal)


def test_equality_is_named():
    words = collision_words(classify(*sides(0.5, 0.2, -1.3, 0.3)))
    assert "Equal within rounding: on R, a multiplier is -1." in words
    trace = -(1.0 + 0.06 - 0.5) / 0.5  # along LR: 1 + tau_L tau_R - delta_L - delta_R + 0.06 = 0
    assert 1.0 + trace + 0.3 > 0.0
    assert classify(*sides(0.5, 0.2, trace, 0.3)).kind == "persistence"
    trace = -(1.0 + 0.02 + -0.3) / 0.5
    along = classify(*sides(0.5, 0.1, trace, 0.2))
    assert collision_words(along)[1] == "Equal within rounding: along LR, a multiplier is -1."


def test_chaos_exponent_of_the_lozi_map():
    """tau = -+ 1.7, delta = 0.5 is (x, y) -> (1 - 1.7 |x| + y, ...) with b = -0.5."""
    found = attractor(*sides(1.7, 0.5, -1.7, 0.5), 1)
    form, tangent, total = NormalForm(*sides(1.7, 0.5, -1.7, 0.5), 1.0), (1.0, 0.3), 0.0
    point, steps = (0.1, 0.0), 30_000
    for _ in range(steps):
        trace = 1.7 if point[0] <= 0.0 else -1.7
        tangent = trace * tangent[0] + tangent[1], -0.5 * tangent[0]
        size = sqrt(tangent[0] ** 2 + tangent[1] ** 2)
        total, tangent = total + log(size), (tangent[0] / size, tangent[1] / size)
        point = step(form.left, form.right, 1.0, *point)
    assert abs(found.exponent - total / steps) < 5.0 * found.spread + 1e-3
    starts = [(0.1 + 0.01 * k, 0.002 * k) for k in range(24)]
    means, errors, _ = zip(*(_exponent(form, *start, 1e6) for start in starts), strict=True)
    assert 0.5 < fmean(errors) / stdev(means) < 2.0  # over independent runs


def test_a_tangent_that_vanishes_has_the_exponent_of_what_is_there_at_once():
    """The left side maps every difference to zero in two steps, and holds its fixed point."""
    form = NormalForm(*sides(0.0, 0.0, 0.5, 0.1), -1.0)
    assert _exponent(form, -1.0, 0.0, 1e6) == (-inf, 0.0, (-1.0, 0.0))


def test_the_exponent_of_a_cycle_is_per_step():
    """log of the spectral radius of the product along its word, over the length of the word."""
    seen = set()
    for pair in (sides(0.1, 0.3, -1.5, 0.3), sides(0.4, 0.1, -0.5, 0.2)):
        for mu in (-1, 1):
            found = attractor(*pair, mu)
            assert found.kind in ("fixed-point", "cycle")
            product = np.eye(2)
            for name in found.word:
                side = pair["LR".index(name)]
                product = np.array([[side.trace, 1.0], [-side.det, 0.0]]) @ product
            radius = np.abs(np.linalg.eigvals(product)).max()
            assert found.exponent == pytest.approx(log(radius) / len(found.word), rel=1e-9)
            assert found.period == len(found.word)
            seen.add(found.period)
    assert {1, 2} <= seen


def test_motion_on_an_invariant_curve_is_not_called_chaos():
    """det = 1 on both sides; the tangent grows with the number of steps, not exponentially."""
    (x, y, u, v), steps = (0.0, 0.0, 1.0, 0.0), 100_000
    for _ in range(steps):
        trace = -0.7 if x <= 0.0 else -0.8
        x, y, u, v = trace * x + y + 1.0, -x, trace * u + v, -u
    assert abs(u) + abs(v) < steps
    assert "chaos" not in attractor(*sides(-0.7, 1.0, -0.8, 1.0), 1).word


def test_huge_numbers_do_not_raise():
    for big in (1e150, 1e308, -1e308):
        assert classify(Side(big, 0.5), Side(0.5, big)).kind in KINDS
    assert cycle("L" * 20 + "R" * 20, Side(1e300, 1e300), Side(-1e300, 1e300)).exists_for == 0


def test_the_theorem_of_robust_chaos_agrees_with_iteration():
    rng, agreeing, lost = random.Random(7), 0, 0
    for _ in range(120):
        a, b = rng.random(), rng.random()
        left, right = sides(1.0 + a + rng.random(), a, -1.0 - b - rng.random(), b)
        last = classify(left, right).inequalities[-1]
        assert last.rule is Rule.TRAPPING
        start = cycle("R", left, right).points[0]
        bounded = iterate(left, right, 1.0, (start[0] + 1e-6, start[1]), 3_000) is not None
        assert bounded or not last.holds
        agreeing += bounded == last.holds
        lost += not bounded
    assert agreeing > 110
    assert lost > 40


def grows(left, right, directions=60):
    """Largest log of growth over many directions of the homogeneous map, in 4000 steps."""
    best = -inf
    for k in range(directions):
        t = 4.0 * k / directions
        x, y = (t - 1.0, 1.0) if t < 2.0 else (3.0 - t, -1.0)
        total = 0.0
        for _ in range(4_000):
            x, y = step(left, right, 0.0, x, y)
            size = abs(x) + abs(y)
            total, x, y = total + log(size), x / size, y / size
            if abs(total) > 25.0:
                break
        best = max(best, total)
    return best


@seeded(10)
@given(STABLE)
def test_danger_is_growth_in_some_direction(pair):
    brute = grows(*pair)
    assume(abs(brute) > 20.0)
    assert (growth_at_zero(*pair) > 0.0) == (brute > 0.0)
    assert (classify(*pair).kind in ("dangerous", "degenerate")) == (brute > 0.0)


def mirrored(found):
    """A prediction with its words read from the other side."""
    words = [word.translate(SWAP) for word in found.word.split(", ")] if found.word else []
    turned = [min(w[k:] + w[:k] for k in range(len(w))) for w in words if set(w) <= set("LR")]
    return found.kind, found.period, sorted(turned)


def plain(found):
    words = [word for word in found.word.split(", ") if word and set(word) <= set("LR")]
    return found.kind, found.period, sorted(words)


@seeded(25)
@given(ANY)
def test_exchange_of_the_sides_mirrors_the_verdict(pair):
    there, back = classify(*pair), classify(*reversed(pair))
    assert there.kind == back.kind
    assume(there.kind != "degenerate")  # there an orbit may stay on the border, which is L's
    assert (mirrored(there.below), mirrored(there.above)) == (plain(back.above), plain(back.below))
    assert there.cycles[0].multipliers == back.cycles[1].multipliers
    assert there.cycles[2].exists_for == -back.cycles[2].exists_for


@seeded(80)
@given(ANY, st.text("LR", min_size=1, max_size=7))
def test_a_cycle_that_exists_returns(pair, word):
    found = cycle(word, *pair)
    assume(found.exists_for)
    spin = 1.0 + sum(abs(x) for x, _ in found.points)
    for k, (x, y) in enumerate(found.points):
        assert (x <= 0.0) == (word[k] == "L")
        after = found.points[(k + 1) % len(word)]
        now = step(*pair, float(found.exists_for), x, y)
        assert now == pytest.approx(after, rel=1e-6, abs=1e-7 * spin)
    dets = {"L": pair[0].det, "R": pair[1].det}
    det = (found.multipliers[0] * found.multipliers[1]).real
    assert det == pytest.approx(prod(dets[symbol] for symbol in word), rel=1e-9, abs=1e-12)


@seeded(25)
@given(ANY)
def test_a_predicted_cycle_attracts(pair):
    for mu in (-1, 1):
        found = attractor(*pair, mu)
        if found.kind not in ("fixed-point", "cycle"):
            continue
        orbit = cycle(found.word, *pair)
        assert orbit.stable
        assert orbit.exists_for == mu
        assert found.exponent < 0.0
        x, y = orbit.points[0]
        away = 1e-6 * min(abs(point[0]) for point in orbit.points)
        turns = min(int(-25.0 / found.exponent), 20_000) // len(found.word) * len(found.word)
        end = iterate(*pair, float(mu), (x + away, y), turns + 10 * len(found.word))
        assert end is not None
        assert abs(end[0] - x) + abs(end[1] - y) < 0.1 * away + 1e-9 * (abs(x) + abs(y))


@pytest.mark.parametrize(("kind", "period", "simulated", "stays", "agrees"), [
    ("none", 0, APERIODIC, False, True), ("none", 0, Label((1, 1)), True, False),
    ("several", 0, Label((1, 1)), True, None), ("undecided", 0, APERIODIC, False, None),
    ("chaos", 0, UNDECIDED, True, None), ("fixed-point", 0, UNDECIDED, False, None),
    ("chaos", 0, APERIODIC, True, True), ("chaos", 0, APERIODIC, False, False),
    ("chaos", 0, Label((1, 1)), True, False), ("chaos", 0, CONTACT, True, False),
    ("fixed-point", 0, Label((1, 1)), True, True), ("fixed-point", 0, Label((1,)), True, False),
    ("fixed-point", 0, Label((1, 1)), False, False), ("fixed-point", 0, APERIODIC, True, False),
    ("cycle", 3, Label((1, 1, 1, 1, 1, 2)), True, True),
    ("cycle", 3, Label((1, 1, 2)), True, False), ("cycle", 3, CONTACT, True, False),
])  # fmt: skip
def test_what_a_simulation_beside_a_corner_says_of_the_prediction(
    kind, period, simulated, stays, agrees
):
    """The orbit that meets the corner has two turns, so a cycle of the map has twice as many."""
    assert _agree(Prediction(kind, period), simulated, stays, 2) is agrees


@pytest.mark.parametrize(
    ("start", "points"),
    [((4.0, 0.0), [9.0, 19.0]), ((-4.0, 0.0), [-7.0, -13.0]), ((nan, 0.0), [nan])],
)
def test_points_end_with_the_first_one_beyond_the_limit_on_either_side(start, points):
    """x -> 2 x + 1 on both sides, as long as |x| < 10."""
    form = NormalForm(*sides(2.0, 0.0, 2.0, 0.0), 1.0)
    found = [x for x, _ in form.run(*start, 50, limit=10.0)]
    assert found == pytest.approx(points, nan_ok=True)
    assert len(list(form.run(4.0, 0.0, 50))) == 50


@pytest.mark.parametrize(
    ("side", "equal"),
    [
        (Side(1.3, 0.3), Equal.PLUS_ONE),
        (Side(-1.3, 0.3), Equal.MINUS_ONE),
        (Side(0.3, 1.0), Equal.UNIT_PAIR),
        (Side(3.0, 1.0), None),  # two real multipliers whose product is one
        (Side(0.3, 1.0 - 2.0**-52), Equal.UNIT_PAIR),  # inside, but by no more than rounding
        (Side(1.3 - 2.0**-51, 0.3), Equal.PLUS_ONE),
        (Side(-1.3 + 2.0**-51, 0.3), Equal.MINUS_ONE),
        (Side(0.3, 1.0 - 1e-12), None),
    ],
)
def test_a_multiplier_on_the_unit_circle_is_neither_inside_nor_outside(side, equal):
    assert side.degenerate == equal
    assert side.stable == (equal is None and side.det < 1.0 - 2.0**-52)


def test_the_determinant_of_a_long_cycle_is_a_product():
    """Twenty times a trace of 3: the entries of the turn cancel to fewer digits than none."""
    pair = sides(3.0, 0.5, 2.0, 0.25)
    large, small = cycle("L" * 20 + "R", *pair).multipliers
    assert (large * small).real == pytest.approx(0.5**20 * 0.25, rel=1e-12)


def test_where_attractors_are_looked_for():
    """About each point of a cycle by a thousandth of its size and one, and on four rings."""
    points = [(2.0, -3.0), (-0.5, 0.25)]
    found = list(_starts([Cycle("LR", (0j, 0j), False, tuple(points), 1)]))
    wanted = [(0.0, 0.0)]
    for (x, y), r in [
        ((2.0, -3.0), 6e-3), ((-0.5, 0.25), 1.75e-3),
        *(((0.0, 0.0), 4.0**k) for k in range(4)),
    ]:  # fmt: skip
        wanted += [(x + r, y), (x - r, y), (x, y + r), (x, y - r)]
    assert np.array(found) == pytest.approx(np.array(wanted), rel=1e-12)


SEEN = {
    "chaos": Prediction("chaos", 0, 0.25, "", 0.01),
    "open": Prediction("undecided", 0, 0.125, "LLR", 0.02),
    "gone": Prediction("none"),
    "three": Prediction("cycle", 3, -0.5, "LRR"),
}


@pytest.mark.parametrize(
    ("ends", "found"),
    [
        (["gone"], Prediction("none")),
        (["gone", "chaos", "chaos"], SEEN["chaos"]),
        (["three", "three"], SEEN["three"]),
        (["three", "gone", "chaos"], Prediction("several", word="LRR, chaos")),
        (["three", "open", "chaos"], Prediction("undecided", 0, 0.125, "LLR, LRR, chaos", 0.02)),
    ],
)
def test_what_is_said_of_several_ends(monkeypatch, ends, found):
    """Two fixed points that repel, and orbits that end so."""
    pair = sides(-1.5, 0.2, 1.7, -0.5)
    measured = []

    def follow(form, start, measure):
        measured.append(measure)
        return SEEN[ends[start]]

    monkeypatch.setattr(module, "_starts", lambda cycles: range(len(ends)))
    monkeypatch.setattr(module, "_follow", follow)
    assert attractor(*pair, -1) == found
    known = ["chaos" in ends[:k] for k in range(len(ends))]
    assert measured == [not one for one in known]  # a second chaos is no other


@pytest.mark.parametrize(
    ("pair", "mu", "followed"),
    [
        (sides(1.7, 0.5, -1.7, 0.5), -1, False),  # no fixed point, and the plane keeps its sense
        (sides(1.7, 0.5, -1.7, 0.5), 1, True),
        (sides(1.7, 0.5, -1.7, -0.5), -1, True),
        (sides(1.7, -0.5, -1.7, 0.5), -1, True),
    ],
)
def test_nothing_bounded_is_looked_for_where_nothing_can_be(monkeypatch, pair, mu, followed):
    starts = []
    monkeypatch.setattr(
        module, "_follow", lambda form, start, _: starts.append(start) or Prediction("none")
    )
    assert attractor(*pair, mu).kind == "none"
    assert bool(starts) == followed


@pytest.mark.parametrize(
    ("right", "mu", "start", "found"),
    [
        (Side(0.95, 0.0), 1.0, 1e8, ("R", Prediction("fixed-point", 1, log(0.95), "R"))),
        (Side(0.95, 0.0), -1.0, 1e8, ("R", None)),  # on its way to x = -20, which is on L
        (Side(1.05, 0.0), -1.0, 20.0 + 1e-9, ("R", None)),  # beside a point that repels
        (Side(1.05, 0.0), 1.0, 1.0, ("", Prediction("none"))),  # beyond 1e5 after 182 steps
        (Side(0.95, 0.0), 1.0, -1e9, ("", Prediction("none"))),
        (Side(0.95, 0.0), 1.0, nan, ("", Prediction("none"))),
    ],
)
def test_what_the_word_of_an_orbit_says_of_its_end(right, mu, start, found):
    """x -> trace x + mu where x > 0."""
    limit = 1e5 if right.trace > 1.0 else 1e9
    word, end = _word(NormalForm(Side(0.5, 0.0), right, mu), start, 0.0, limit)
    assert (word, end and end.kind) == (found[0], found[1] and found[1].kind)
    if end is not None and end.period:
        assert end.exponent == pytest.approx(found[1].exponent, rel=1e-12)


def test_an_exponent_has_the_error_of_the_mean_over_its_blocks():
    """Without a determinant a difference grows by the trace at each step: a skew tent."""
    form = NormalForm(*sides(1.7, 0.0, -1.3, 0.0), 1.0)
    x, rates = 0.2, []
    for _ in range(16):
        logs = []
        for _ in range(512):
            trace = 1.7 if x <= 0.0 else -1.3
            logs.append(log(abs(trace)))
            x = trace * x + 1.0
        rates.append(fmean(logs))
    mean, error, (last, _) = _exponent(form, 0.2, 0.0, 1e9)
    assert mean == pytest.approx(fmean(rates), rel=1e-12)
    assert error == pytest.approx(stdev(rates) / 4.0, rel=1e-9)
    assert last == pytest.approx(x, abs=1e-6)


def test_an_exponent_is_that_of_the_blocks_until_an_orbit_escapes():
    """x doubles, and is beyond 2^665 in the second block; growth counts by sixteen steps."""
    form = NormalForm(*sides(0.5, 0.0, 2.0, 0.0), 0.0)
    mean, error, (last, _) = _exponent(form, 1.0, 0.0, 2.0**665)
    rates = [log(2.0), log(2.0) * 144 / 512]  # 665 = 512 + 153, of which 144 are whole sixteens
    assert mean == pytest.approx(fmean(rates), rel=1e-12)
    assert error == pytest.approx(stdev(rates) / sqrt(2.0), rel=1e-12)
    assert last == 2.0**665


def test_growth_at_zero_is_the_largest_over_sixteen_directions(monkeypatch):
    """x' = x/2 + y on the left and 2 x + y on the right, y' = 0: (1, 1) grows most, to 3."""
    pair = sides(0.5, 0.0, 2.0, 0.0)
    assert growth_at_zero(*pair) == pytest.approx((47.0 * log(2.0) + log(3.0)) / 48.0, rel=1e-12)
    half = sides(0.5, 0.0, 0.5, 0.0)  # what shrinks is followed as far: e^-30 after 44 halvings
    wanted = (log(1.5) - 47.0 * log(2.0)) / 48.0
    assert growth_at_zero(*half) == pytest.approx(wanted, rel=1e-12)
    border = [(1.0, t) for t in (-1.0, -0.5, 0.0, 0.5)]
    wanted = {z for x, y in border for z in ((x, y), (-y, x), (-x, -y), (y, -x))}
    assert len(wanted) == 16
    for largest in wanted:
        asked = set()

        def growth(form, x, y, largest=largest, asked=asked):
            asked.add((x, y))
            return 0.5 if (x, y) == largest else -1.0

        monkeypatch.setattr(module, "_growth", growth)
        assert growth_at_zero(*pair) == 0.5
        assert asked == wanted


@pytest.mark.parametrize(("growth", "kind"), [
    (1.4e-3, "persistence"), (1.6e-3, "dangerous"), (-2.0, "persistence"),
])  # fmt: skip
def test_a_growth_that_no_orbit_could_show_is_no_danger(monkeypatch, growth, kind):
    """A log of 30 in 20 000 steps decides."""
    monkeypatch.setattr(module, "growth_at_zero", lambda *_: growth)
    found = classify(*sides(0.5, 0.2, -0.5, 0.3))
    assert (found.kind, found.growth.left) == (kind, growth)
    assert found.growth.right == pytest.approx(1.5e-3, rel=1e-12)


def test_equalities_of_the_sides_come_in_order(monkeypatch):
    monkeypatch.setattr(module, "attractor", lambda *_: Prediction("none"))
    found = classify(Side(1.3, 0.3), Side(0.3, 1.0))
    assert found.equal == (("L", Equal.PLUS_ONE), ("R", Equal.UNIT_PAIR))


def conditions(found):
    return [(one.rule, one.side, one.left, one.right) for one in found.chaos]


def test_the_conditions_of_robust_chaos_and_their_order():
    """The saddle's first; R is the saddle where only it has a multiplier beyond one."""
    for mirrored in (False, True):
        pair, saddle, other = sides(1.7, 0.5, -1.8, 0.6), "L", "R"
        if mirrored:
            pair, saddle, other = pair[::-1], "R", "L"
        large = (1.7 + sqrt(1.7**2 - 2.0)) / 2.0
        small = 0.5 / large
        trapping = -1.8 * large * (large - 1.0) - 0.6 * (large - 1.0) + large**2 * (1.0 - small)
        assert conditions(classify(*pair)) == [
            (Rule.BEYOND_ONE, saddle, 1.7, 1.5), (Rule.BEYOND_MINUS_ONE, other, -1.8, -1.6),
            (Rule.DET_POSITIVE, saddle, 0.5, 0.0), (Rule.DET_BELOW_ONE, saddle, 0.5, 1.0),
            (Rule.DET_POSITIVE, other, 0.6, 0.0), (Rule.DET_BELOW_ONE, other, 0.6, 1.0),
            (Rule.TRAPPING, saddle, pytest.approx(trapping, rel=1e-12), 0.0),
        ]  # fmt: skip
    both = classify(*sides(2.4, 0.3, 2.2, 0.4))  # of two saddles L is the first
    assert conditions(both) == [
        (Rule.BEYOND_ONE, "L", 2.4, 1.3), (Rule.BEYOND_MINUS_ONE, "R", 2.2, -1.4),
    ]  # fmt: skip
