"""The fit of a lift table and its errors, beside those of dense matrices.

Small tables are made by formula. The oracle writes the splines by truncated powers, and stacks the
rows and the penalty into one matrix whose pseudoinverse gives the coefficients, their scatter and
their degrees of freedom. What `camcli.cams.lift_fit` says of its rules is written here once more.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from math import comb, exp, factorial, pi, sqrt
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.cams import lift_fit
from camcli.cams.lift_fit import Errors, Smoother, bends_between_rows, piece, scatter
from camcli.cams.lift_reading import Dwell, Turn

UM = 1e-6
LENGTHS = 0.5 * 2.0 ** (np.arange(18) / 3.0)
AHEAD = 2.0 ** (2.0 / 3.0)


def lobe_of(rows: int, noise: float, digits: int, base: float = 0.0) -> Turn:
    """A lobe from 190 to 350 deg, above a dwell, written to so many decimals of a m.

    Its second derivative jumps twice, and its toes are a few last digits high. Rows from 30 to 60
    deg are filled. Where there is noise one row is off by far more.
    """
    rng = np.random.default_rng(rows)
    theta = (np.arange(rows) + rng.uniform(-0.2, 0.2, rows) + 0.3) * 360.0 / rows
    x = np.clip((theta - 190.0) / 160.0, 0.0, 1.0)
    lift = 8e-3 * np.sin(pi * x) ** 4
    lift += 6e-3 * np.maximum(x - 0.3, 0.0) ** 2 * np.maximum(0.9 - x, 0.0) ** 4
    lift += noise * rng.normal(0.0, 1.0, rows) * (lift > 0.0)
    lift[4 * rows // 5] += 12.0 * noise
    lift = np.round(base + lift, digits)
    still = lift == round(base, digits)
    first, *_, last = np.flatnonzero(~still)  # a toe of 8 last digits, and one of 9
    lift[[first, last]] = [round(base + k * 10.0**-digits, digits) for k in (8, 9)]
    line = np.where((theta > 30.0) & (theta < 60.0), 0, np.arange(rows) + 2)
    start = min(theta[still & (theta > 300.0)], default=theta[0])
    end = max(theta[still & (theta < 250.0)])
    dwell = Dwell(float(start), float(end + 360.0 * (end < start)), float(lift[still][0]))
    return Turn(theta, lift, line, 10.0**-digits, 360.0 / rows, [dwell])


def wave_of(rows: int, noise: float, digits: int) -> Turn:
    """A wave round the turn, with runs of rows that have one lift; one goes through its end."""
    rng = np.random.default_rng(rows)
    theta = (np.arange(rows) + rng.uniform(-0.2, 0.2, rows) + 0.3) * 360.0 / rows
    lift = 4e-3 * (1.0 - np.cos(np.radians(theta))) + 1e-3 * np.sin(np.radians(2.0 * theta))
    lift = np.round(lift + rng.normal(0.0, noise, rows), digits)
    lift[5:7], lift[11:14], lift[-2:] = lift[5], lift[12], lift[0]
    return Turn(theta, lift, np.arange(rows) + 2, 10.0**-digits, 360.0 / rows, [])


TURNS = {
    "rounded": lambda: lobe_of(48, 0.0, 6),
    "raised": lambda: lobe_of(46, 0.0, 5, base=3e-3),
    "scattering": lambda: lobe_of(50, 20.0 * UM, 6),
    "a wave": lambda: wave_of(40, 3.0 * UM, 6),
    "few rows": lambda: wave_of(24, 0.0, 5),
}


def apart(a, b, turn: float):
    """How far two places lie apart, by the shorter way round."""
    return np.abs((a - b + turn / 2.0) % turn - turn / 2.0)


def widest(values: np.ndarray, reach) -> np.ndarray:
    """The largest value within so many knots of each one, by the reach of that one."""
    count = len(values)
    near = apart(np.arange(count)[:, None], np.arange(count), count)
    reach = np.broadcast_to(reach, count)
    return np.where(near <= reach[:, None], values, 0.0).max(axis=1)


def held_by(turn: Turn, dwell: Dwell, count: int) -> list[int]:
    """Coefficients as far within a dwell as the lift needs beyond to climb more than 8 digits."""
    off = turn.theta[abs(turn.lift - dwell.level) > 8.0 * turn.quantum]
    before = min((dwell.start - off) % 360.0) * count / 360.0
    after = min((off - dwell.end) % 360.0) * count / 360.0
    low = dwell.start * count / 360.0 + max(1.0, before)
    high = dwell.end * count / 360.0 - max(1.0, after)
    held = [j % count for j in range(3 * count) if low < j - 3 <= high]
    return held if len(held) >= 8 else []


class Dense:
    """A table's fits by dense matrices."""

    def __init__(self, turn: Turn):
        self.turn, n = turn, len(turn.lift)
        self.count = count = min(720, max(32, round(360.0 / turn.spacing)))
        self.per = count / (2.0 * pi)  # knots in a radian
        self.level = np.full(count, np.nan)
        for dwell in turn.dwells:
            held = held_by(turn, dwell, count)
            self.level[held] = dwell.level
        self.free = np.isnan(self.level)
        intervals = (np.arange(count)[:, None] + np.arange(8)) % count
        self.moving = self.free[intervals].any(axis=1)
        self.share = np.empty(n)
        for k in range(n):
            run = 1
            for step in (1, -1):
                there = k + step
                while run < n and turn.lift[there % n] == turn.lift[k]:
                    run, there = run + 1, there + step
            self.share[k] = 1.0 / min(run, 8)
        self.rows = self.basis(turn.theta * count / 360.0)
        stencil = [1.0, -4.0, 6.0, -4.0, 1.0]
        self.inverses: dict[float, tuple[np.ndarray, np.ndarray]] = {}
        self.bends = sum(w * np.roll(np.eye(count), k, axis=1) for k, w in enumerate(stencil))

    def basis(self, u: np.ndarray, order: int = 0) -> np.ndarray:
        """(places, count): a derivative of every basis function by the knot spacing.

        Function j is the B-spline of degree 7 on the knots j - 7 to j + 1.
        """
        x = (u[:, None] - np.arange(self.count) + 7.0) % self.count
        value = np.zeros_like(x)
        power = 7 - order
        for k in range(9):
            past = np.where((x > k) & (x < 8.0), x - k, 0.0)
            value += (-1) ** k * comb(8, k) * past**power / factorial(power)
        return np.where(x < 8.0, value, 0.0)

    def inverse(self, length: float) -> tuple[np.ndarray, np.ndarray]:
        """(the rows and the penalty, stacked; the pseudoinverse of its free columns)."""
        if length in self.inverses:
            return self.inverses[length]
        weight = sqrt(len(self.turn.lift) / self.count * length**8)
        stacked = np.vstack([np.sqrt(self.share)[:, None] * self.rows, weight * self.bends])
        q, r = np.linalg.qr(stacked[:, self.free])
        self.inverses[length] = stacked, np.linalg.solve(r, q.T)
        return self.inverses[length]

    def response(self, length: float) -> np.ndarray:
        """(count, rows): how every coefficient answers to the lift of every row."""
        answers = np.zeros((self.count, len(self.turn.lift)))
        answers[self.free] = self.inverse(length)[1][:, : len(self.share)] * np.sqrt(self.share)
        return answers

    def fit(self, length: float) -> np.ndarray:
        stacked, inverse = self.inverse(length)
        found = np.where(self.free, 0.0, self.level)
        right = np.concatenate([np.sqrt(self.share) * self.turn.lift, np.zeros(self.count)])
        found[self.free] = inverse @ (right - stacked @ found)
        return found

    def at_knots(self, length: float, order: int) -> np.ndarray:
        knots = np.arange(self.count, dtype=float)
        return self.basis(knots, order) @ self.fit(length) * self.per**order

    def change(self, length: float, order: int) -> np.ndarray:
        return abs(self.at_knots(2.0 * length, order) - self.at_knots(length, order))

    def spread(self, answers: np.ndarray, order: int) -> np.ndarray:
        """Standard errors at knots that move, of rows whose variance is one over their share."""
        knots = np.arange(self.count, dtype=float)
        of_rows = self.basis(knots, order) @ answers * self.per**order
        found = np.sqrt((of_rows**2 / self.share).sum(axis=1))
        return np.where(self.moving, found, 0.0)

    def balanced(self, sigma: float) -> np.ndarray:
        lengths = np.full(self.count, 0.5)
        hidden = np.ones(self.count, bool)
        for length in LENGTHS:
            limit = 6.0 * sigma * self.spread(self.response(length), 2)
            bending = widest(self.change(AHEAD * length, 2), 2.0 * length)
            hidden &= bending <= widest(limit, 2.0 * length)
            lengths[hidden] = length
        knots = np.arange(self.count)
        return (lengths + 0.5 * apart(knots[:, None], knots, self.count)).min(axis=1)


class DenseErrors:
    """Errors of a fit that is blended of two lengths at every knot."""

    def __init__(self, dense: Dense, lengths: np.ndarray):
        self.dense, self.lengths = dense, lengths
        place = np.clip(np.log2(lengths / 0.5) * 3.0, 0.0, 17.0)
        self.shares = {
            float(length): np.maximum(0.0, 1.0 - abs(place - k)) for k, length in enumerate(LENGTHS)
        }
        self.coefficients = self.blended(dense.fit)
        self.answers = self.blended(dense.response)

    def blended(self, value) -> np.ndarray:
        parts = [(share, value(length)) for length, share in self.shares.items() if share.any()]
        return sum((share * part.T).T for share, part in parts)

    @cached_property
    def noise(self) -> float:
        dense, turn = self.dense, self.dense.turn
        off = dense.rows @ self.coefficients - turn.lift
        u = (turn.theta * dense.count / 360.0).astype(int)
        moves = dense.moving[u]
        free = float(dense.share[moves].sum() - np.trace(dense.rows @ self.answers))
        squares = (dense.share * off**2)[moves]
        squares = squares[squares < (6.0 * scatter(turn)) ** 2]
        found = sqrt(squares.sum() / max(free, 1.0))
        rounding = turn.quantum / sqrt(12.0)
        return found if found > rounding * (1.0 + 2.0 / sqrt(2.0 * max(free, 1.0))) else rounding

    def standard(self, order: int) -> np.ndarray:
        return self.noise * self.dense.spread(self.answers, order)

    def changes(self, factor: float, order: int) -> np.ndarray:
        return self.blended(lambda length: self.dense.change(factor * length, order))

    def excess(self, order: int) -> np.ndarray:
        more = np.maximum(self.changes(AHEAD, order) - 3.0 * self.standard(order), 0.0)
        return np.where(self.standard(order) > 0.0, more, 0.0)

    def bounds(self, order: int) -> np.ndarray:
        """3 standard errors, and C L^p from excess = C (AHEAD L)^p (2^p - 1)."""
        reach = 2.0 * self.lengths
        once, twice = (widest(self.changes(factor, order), reach) for factor in (1.0, 2.0))
        growth = np.divide(twice, once, out=np.zeros_like(once), where=once > 0.0)
        p = np.log2(np.clip(growth, 1.28, 4.0))
        bending = self.excess(order) / (AHEAD**p * (2.0**p - 1.0))
        bound = 3.0 * self.standard(order) + widest(bending, self.lengths)
        beside = widest(1.0 - self.dense.moving, 8) > 0.0
        return np.where(self.dense.moving, np.where(beside, widest(bound, 8), bound), 0.0)


@pytest.fixture(scope="module", params=TURNS)
def both(request):
    """(a table's fit, the dense one)."""
    turn = TURNS[request.param]()
    smoother, dense = Smoother(turn), Dense(turn)
    lengths = smoother.balanced(scatter(turn))
    return Errors(smoother, lengths), DenseErrors(dense, lengths)


def near(found, exact, share: float = 1e-5):
    """Everywhere to a share of the largest one."""
    found, exact = np.asarray(found), np.asarray(exact)
    assert abs(found - exact).max() <= share * abs(exact).max()


def test_coefficients_and_what_is_held(both):
    errors, other = both
    smoother, dense = errors.smoother, other.dense
    assert smoother.count == dense.count
    assert sorted(smoother.order) == np.flatnonzero(dense.free).tolist()
    assert smoother.moving.tolist() == np.flatnonzero(dense.moving).tolist()
    near(smoother.shares, dense.share, 1e-15)
    for length in (0.5, 1.0, 3.0):
        near(smoother.fit(length).coefficients, dense.fit(length), 1e-7)
    near(errors.coefficients, other.coefficients, 1e-6)
    near(smoother.residuals(errors.coefficients),
         dense.rows @ other.coefficients - dense.turn.lift, 1e-2)  # fmt: skip


def test_a_piece_of_the_table_is_the_spline_between_two_knots(both):
    """Its powers are those of the angle from its middle; a base is added."""
    errors, other = both
    count = other.dense.count
    for i in (0, 5, count - 1):
        made = piece(errors.coefficients, i, 0.25)
        ends = np.array([i, i + 1]) * 2.0 * pi / count
        assert (made.center - made.half, made.center + made.half) == pytest.approx(tuple(ends))
        t = np.array([0.0, 0.25, 0.5, 1.0])
        off = ends[0] + t * (ends[1] - ends[0]) - made.center
        value = sum(term * off**k for k, term in enumerate(made.coefficients))
        exact = 0.25 + other.dense.basis(i + t) @ errors.coefficients
        assert value == pytest.approx(exact, abs=1e-13)


def test_what_rows_decide_is_the_trace_of_their_answers(both):
    errors, other = both
    dense = other.dense
    for length in (0.5, 2.0):
        trace = np.trace(dense.rows @ dense.response(length))
        assert errors.smoother.leverage(length).sum() == pytest.approx(trace, rel=1e-9)
    assert errors.noise == pytest.approx(other.noise, rel=1e-4)


def test_the_length_at_every_knot_balances_bending_and_noise(both):
    errors, other = both
    for share in (0.5, 1.0, 4.0):
        sigma = share * scatter(other.dense.turn)
        near(errors.smoother.balanced(sigma), other.dense.balanced(sigma), 1e-12)


@pytest.mark.parametrize("order", [2, 3])
def test_errors_of_derivatives(both, order):
    errors, other = both
    mine = errors.accel if order == 2 else errors.jerk
    near(mine.standard, other.standard(order))
    near(mine.excess, other.excess(order), 1e-3)
    near(mine.bounds, other.bounds(order), 1e-3)


def test_what_is_said_of_the_fit(both):
    errors, other = both
    dense, turn, found = other.dense, other.dense.turn, errors.accuracy
    off = dense.rows @ other.coefficients - turn.lift
    told = (turn.line > 0) & (turn.lift != 0.0)
    assert found.rms == pytest.approx(sqrt((off[told] ** 2).mean()), rel=1e-3)
    measured = abs(off) * (turn.line > 0)
    assert found.largest == pytest.approx(measured.max(), rel=1e-3)
    assert (found.line, found.rows) == (turn.line[measured.argmax()], (turn.line > 0).sum())
    assert found.length_deg == pytest.approx(
        np.median(other.lengths[dense.moving]) * 360.0 / dense.count
    )
    halves = np.repeat(np.flatnonzero(dense.moving), 2) + np.tile([0.0, 0.5], dense.moving.sum())
    accels = abs(dense.basis(halves, 2) @ other.coefficients) * dense.per**2
    assert found.accel == pytest.approx(accels.max(), rel=1e-5)
    middle = np.floor(halves[[accels.argmax()]]) + 0.5
    answers = dense.basis(middle, 2) @ other.answers * dense.per**2
    worst = 0.5 * turn.quantum * abs(answers[:, turn.line > 0]).sum()
    assert found.worst == pytest.approx(worst, rel=1e-4)
    assert found.standard == pytest.approx(other.standard(2).max(), rel=1e-4)
    assert found.bound == pytest.approx(other.bounds(2).max(), rel=1e-3)
    assert found.knots == dense.count
    assert found.lift == turn.lift.max() - turn.lift.min()


def test_a_jump_is_looked_for_at_ends_of_dwells_and_peaks_of_bending(both):
    errors, other = both
    excess, count = errors.accel.excess, other.dense.count
    ends = [end % 360.0 for dwell in other.dense.turn.dwells for end in dwell[:2]]
    knots = np.arange(count)
    peaks = [k for k in knots if excess[k] > 0.0
             and excess[k] == excess[apart(knots, k, count) <= 6].max()]  # fmt: skip
    peaks = sorted(peaks, key=lambda k: -excess[k])[:6]
    away = [k * 360.0 / count for k in peaks]
    away = [deg for deg in away if all(apart(deg, end, 360.0) > 2.0 for end in ends)]
    assert errors.places_of_jumps() == pytest.approx([*ends, *away])


def test_a_deviation_that_is_wanted_is_met_or_is_that_of_an_end(both):
    smoother = both[0].smoother
    least, most = (smoother.rms(smoother.fit(length).coefficients) for length in LENGTHS[[0, -1]])
    assert smoother.with_rms(0.5 * least) == smoother.with_rms(least) == LENGTHS[0]
    assert smoother.with_rms(2.0 * most) == pytest.approx(LENGTHS[-1], rel=1e-4)
    for share in (0.2, 0.7):
        wanted = least * (most / least) ** share
        length = smoother.with_rms(wanted)
        assert smoother.rms(smoother.fit(length).coefficients) < wanted
        longer = smoother.fit(length * (1.0 + 1e-5)).coefficients
        assert smoother.rms(longer) >= wanted


@pytest.mark.parametrize("times", [5.9, 6.1])
def test_rows_that_are_wrong_are_no_noise(monkeypatch, times):
    """Residuals of more than 6 times the scatter; here the largest one is about that."""
    turn = wave_of(36, 20.0 * UM, 6)
    dense, fit = Dense(turn), DenseErrors(Dense(turn), np.ones(36))
    squares = dense.share * (dense.rows @ fit.coefficients - turn.lift) ** 2
    freedom = dense.share.sum() - np.trace(dense.rows @ fit.answers)
    kept = np.sort(squares)[: 36 if times < 6.0 else 35]
    monkeypatch.setattr(lift_fit, "scatter", lambda turn: sqrt(squares.max()) / times)
    assert Errors(Smoother(turn), 1.0).noise == pytest.approx(sqrt(kept.sum() / freedom), rel=1e-6)


@pytest.mark.parametrize(
    ("rows", "knots"), [(28, 32), (33, 33), (719, 719), (721, 720), (1500, 720)]
)
def test_a_turn_has_so_many_knots_and_holds_those_in_a_dwell(rows, knots):
    """A knot for each row, within limits; a free one at least at either end of a dwell."""
    turn = lobe_of(rows, 0.0, 6)
    levels = Smoother(turn).levels
    assert Smoother(turn).count == knots
    assert sorted(levels) == sorted(held_by(turn, turn.dwells[0], knots))
    assert set(levels.values()) <= {0.0}


@pytest.mark.parametrize("length", [8, 9])
def test_a_dwell_holds_eight_coefficients_or_none(length):
    """Rows at the knots: of 8 + 4 equal ones those one knot from the next row stay free."""
    theta = np.arange(40) * 9.0
    lift = 1e-3 * (1.0 + np.arange(40) % 7)
    lift[10 : 10 + length + 3] = 5e-4
    dwell = Dwell(90.0, 90.0 + 9.0 * (length + 2), 5e-4)
    turn = Turn(theta, lift, np.arange(40) + 2, 1e-6, 9.0, [dwell])
    held = Smoother(turn).levels
    assert held == dict.fromkeys(held_by(turn, dwell, 40), 5e-4)
    assert len(held) == (8 if length == 8 else 9) or not held
    assert bool(held) is (length >= 8)


def test_a_lift_of_eight_last_digits_leaves_one_knot_free_at_either_end_of_a_dwell():
    """No row is so far off that a dwell ends before its rows do."""
    lift = np.zeros(40)
    lift[30:36] = 8e-6
    turn = Turn(np.arange(40) * 9.0, lift, np.arange(40) + 2, 1e-6, 9.0, [Dwell(324.0, 621.0, 0.0)])
    assert sorted(Smoother(turn).levels) == sorted(j % 40 for j in range(36 + 5, 69 + 3))


def test_no_more_than_six_peaks_of_bending_are_looked_at():
    """They are seven knots apart at least: the largest within six on either side."""
    smoother = Smoother(wave_of(150, 0.0, 9))
    rng = np.random.default_rng(1)
    excess = rng.uniform(0.0, 1.0, 150)
    errors = Errors(smoother, 1.0)
    vars(errors.accel)["excess"] = excess
    far = apart(np.arange(150)[:, None], np.arange(150), 150)
    peaks = [k for k in range(150) if excess[k] == excess[far[k] <= 6].max()]
    close = [k for k in range(150) if excess[k] == excess[far[k] <= 5].max()]
    wide = [k for k in range(150) if excess[k] == excess[far[k] <= 7].max()]
    highest = sorted(peaks, key=lambda k: -excess[k])
    assert len(peaks) > 7
    assert len(close) > len(peaks) > len(wide)
    assert errors.places_of_jumps() == pytest.approx([k * 2.4 for k in highest[:6]])


def test_peaks_of_bending_are_left_out_beside_ends_of_dwells_and_not_beside_each_other():
    """Knots stand at every 0.125 deg; a dwell goes from 300 deg to 20 deg in the next turn."""
    excess = np.zeros(2880)
    heights = {300.0: 9.0, 318.0: 8.0, 18.0: 7.0, 17.875: 6.9, 100.0: 6.0, 101.0: 5.0, 302.125: 4.0}
    for deg, height in {**heights, 200.0: 3.0, 250.0: -10.0}.items():
        excess[round(deg * 8)] = height
    turn = Stub(dwells=[Dwell(300.0, 380.0, 0.0)])
    errors = Stub(smoother=Stub(count=2880, turn=turn), accel=Stub(excess=excess))
    # of the six highest peaks two are an end of the dwell; 200 deg is the seventh
    assert Errors.places_of_jumps(errors) == [300.0, 20.0, 318.0, 100.0, 101.0, 302.125]
    turn.dwells = [Dwell(100.5, 150.0, 0.0), Dwell(200.0, 317.0, 0.0)]
    assert Errors.places_of_jumps(errors) == [100.5, 150.0, 200.0, 317.0, 300.0, 18.0, 302.125]


@pytest.mark.parametrize(("errors", "is_noise"), [(1.9, False), (2.1, True)])
def test_residuals_are_noise_where_they_are_surely_more_than_rounding(errors, is_noise):
    """By 2 standard errors of a standard deviation: its share of 1/sqrt(2 freedom)."""
    turn = TURNS["a wave"]()
    dense, lengths = Dense(turn), np.ones(40)
    fit = DenseErrors(dense, lengths)
    freedom = dense.share.sum() - np.trace(dense.rows @ fit.answers)
    assert fit.noise > 2.0 * turn.quantum / sqrt(12.0)
    rounding = fit.noise / (1.0 + errors / sqrt(2.0 * freedom))
    coarser = replace(turn, quantum=rounding * sqrt(12.0))
    found = Errors(Smoother(coarser), lengths).noise
    assert found == pytest.approx(fit.noise if is_noise else rounding, rel=1e-6)


@pytest.mark.parametrize("name", [*TURNS, "599 rows", "600 rows"])
def test_the_scatter_of_the_rows_is_that_off_polynomials_through_their_neighbours(name):
    """Of the nine tenths of a normal distribution nearest its mean, the mean square is known.

    Between -z and z, which hold a share of 0.9, it is 1 - 2 z phi(z)/0.9. Of 600 rows every second
    one is looked at, of more fewer.
    """
    more = {"599 rows": lambda: wave_of(601, UM, 8), "600 rows": lambda: wave_of(602, UM, 8)}
    turn = {**TURNS, **more}[name]()
    n, z = len(turn.lift), 1.6448536269514722
    trimmed = 1.0 - 2.0 * z * exp(-z * z / 2.0) / sqrt(2.0 * pi) / 0.9
    estimates = []
    for reach in (2, 3, 4):
        squares = []
        moving = [
            k for k in range(n)
            if turn.line[k] and not turn.lift[k - 1] == turn.lift[k] == turn.lift[(k + 1) % n]
        ]  # fmt: skip
        for k in moving[:: 1 if len(moving) < 600 else 2]:
            steps = [*range(-reach, 0), *range(1, reach + 1)]
            there = np.array([(k + step) % n for step in steps])
            x = (turn.theta[there] - turn.theta[k] + 180.0) % 360.0 - 180.0
            weights = np.linalg.solve(np.vander(x / x.max()).T, np.eye(2 * reach)[-1])
            off = turn.lift[k] - weights @ turn.lift[there]
            squares.append(off**2 / (1.0 + weights @ weights))
        kept = sorted(squares)[: int(0.9 * len(squares)) + 1]
        estimates.append(sqrt(np.mean(kept) / trimmed))
    least = max(turn.quantum / sqrt(12.0), min(estimates))
    assert scatter(turn) == pytest.approx(least, rel=1e-4)
    rounding = sqrt(1.0 / 12.0)  # of a uniform distribution one wide
    assert scatter(replace(turn, quantum=1.0)) == pytest.approx(rounding)
    assert scatter(replace(turn, quantum=1.0, line=0 * turn.line)) == pytest.approx(rounding)
    assert bends_between_rows(turn) is bool(estimates[0] > 1.5 * estimates[1])
