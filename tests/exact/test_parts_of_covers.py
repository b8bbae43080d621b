"""What prover and checker say of flights between cells and of boxes, on numbers chosen by hand."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, ctx

from camcli import check
from camcli.exact import phase_cover as proof

BOTH = pytest.mark.parametrize("kind", ["prover", "checker"])


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 128
    yield
    ctx.prec = before


def made(kind: str, *, longest=None, least=0, **machine):
    """A cover of either kind on a machine of these numbers, without a cam."""
    one = object.__new__(proof.PhaseCover if kind == "prover" else check.PhaseCover)
    one.longest, one.least = longest, arb(least)
    one.machine = Made(stretches=[0, 1], Z2=2 * machine.get("Z", arb(0)), undamped=True, **machine)
    one.stretches, one.count = one.machine.stretches, 2
    return one


def told(kind: str, found) -> str:
    """What is said of flights, in the words of the prover."""
    if kind == "checker":
        if found is None:
            return "impossible"
        return "unknown" if found == check.CellFlight() else "flight"
    if found is proof.Impossible:
        return "impossible"
    return "unknown" if found is proof.Unknown else "flight"


def flight_of(kind: str, out, into, slopes=None, middle=None):
    """A flight that is known, with or without its slopes."""
    rates = middle or (0, 0)
    if kind == "prover":
        detail = None
        if slopes is not None:
            detail = proof.Detail(proof.RateSlopes(*map(arb, slopes)),
                                  proof.Rates(*map(arb, rates)))  # fmt: skip
        return proof.CellFlight(arb(out), arb(into), detail)
    if slopes is None:
        return check.CellFlight(arb(out), arb(into))
    return check.CellFlight(arb(out), arb(into), check.RateSlopes(*map(arb, slopes)),
                            check.Rates(*map(arb, rates)))  # fmt: skip


def point(x, index=0, **more) -> Made:
    """A cell of one phase, or of a ball of phases."""
    given = {"x": arb(x), "index": index, "c": arb(0), "c1": arb(0), "c2": arb(0), "h": arb(0)}
    return Made(**{**given, **more}, middle=None)


def asked(kind: str, one, monkeypatch, *, short=None, below=False, flow=(1, "0.5", "0.5")):
    """The parts of a flight that are given: what short flights are, and whether one is below."""
    calls: list = []
    rates = proof.Rates if kind == "prover" else check.Rates
    names = ("_short", "_between_middles", "_pierces") if kind == "prover" else (
        "short", "between_middles", "below")  # fmt: skip
    middle = (arb(0), rates(arb(0, 50), arb(0, 50)))
    answers = (short, middle, below)
    for name, answer in zip(names, answers, strict=True):
        monkeypatch.setattr(
            one, name, lambda *given, name=name, answer=answer: calls.append(name) or answer
        )
    one.machine.flow = lambda s: tuple(arb(x) for x in flow)
    one.machine.acceleration = lambda q, w: arb(0)
    return calls


def unknown(kind: str):
    return proof.Unknown if kind == "prover" else check.CellFlight()


def impossible(kind: str):
    return proof.Impossible if kind == "prover" else None


FREE = {"W2": arb(0), "G": arb(0), "Z": arb(0)}
# out is c(b) - c(a) - c'(a) and into is c(b)/2 - c(a) - c'(b), where B = 1 and B' = P = 1/2
BOUNCES = {"c": arb(2)}, {"c": arb(3)}


@BOTH
@pytest.mark.parametrize(
    ("start", "landing", "said"),
    [
        ({"c": arb(2)}, {"c": arb(3)}, "flight"),
        ({"c": arb(2), "c1": arb(1)}, {"c": arb(3)}, "impossible"),  # out is zero
        ({"c": arb(2), "c1": arb(1, "1e-9")}, {"c": arb(3)}, "flight"),
        ({"c": arb(2), "c1": arb(2)}, {"c": arb(3)}, "impossible"),
        ({"c": arb(2)}, {"c": arb(3), "c1": arb("-0.5")}, "impossible"),  # into is zero
        ({"c": arb(2)}, {"c": arb(3), "c1": arb("-0.25")}, "flight"),
        ({"c": arb(2)}, {"c": arb(3), "c1": arb(-1)}, "impossible"),
    ],
)
def test_a_flight_leaves_the_cam_and_comes_back(kind, monkeypatch, start, landing, said):
    one = made(kind, **FREE)
    asked(kind, one, monkeypatch)
    ends = point(1, **start), point(2, 2, **landing)
    found = one.flight(*ends)
    assert told(kind, found) == said
    if said == "flight":
        assert (found.out - (3 - 2 - ends[0].c1)).contains(0)
        assert (found.into - (arb("1.5") - 2 - ends[1].c1)).contains(0)
    asked(kind, one, monkeypatch, below=True)
    assert told(kind, one.flight(*ends)) == "impossible"


@BOTH
def test_how_long_a_flight_may_be(kind, monkeypatch):
    one = made(kind, longest=arb(2), **FREE)
    asked(kind, one, monkeypatch)
    for lands, said in ((arb("0.5"), "impossible"), (arb(1), "impossible"), (arb("2.9"), "flight"),
                        (arb(3), "impossible"), (arb("3.5", "0.1"), "impossible"),
                        (arb(3, "0.1"), "flight")):  # fmt: skip
        found = one.flight(point(1, **BOUNCES[0]), point(lands, 2, **BOUNCES[1]))
        assert told(kind, found) == said
    one.longest = None
    assert told(kind, one.flight(point(1, **BOUNCES[0]), point(9, 2, **BOUNCES[1]))) == "flight"


@BOTH
@pytest.mark.parametrize(
    ("keeps", "least", "said"),
    [
        (True, "1.5", "flight"),
        (False, "1.5", "impossible"),
        (False, "0.5", "flight"),
        (None, "1.5", "flight"),
    ],
)
def test_a_flight_past_the_turn_of_its_swing_is_not_too_fast(kind, monkeypatch, keeps, least, said):
    """K = 1 - W2/2 is above zero or below, or may be either; B is 1."""
    w2 = {True: arb(1), False: arb(3), None: arb(2, "0.1")}[keeps]
    one = made(kind, least=least, W2=w2, G=arb(0), Z=arb(0))
    asked(kind, one, monkeypatch)
    ends = point(1, c=arb(2), c1=arb(-9)), point(2, 2, c=arb(3), c1=arb(9))
    assert told(kind, one.flight(*ends)) == said


@BOTH
@pytest.mark.parametrize("more", [0, 1, 2])
@pytest.mark.parametrize("overlap", [False, True])
def test_of_a_short_flight_its_acceleration_says_more(kind, monkeypatch, more, overlap):
    """On one stretch or from one to the next, also where the flight may last for no time."""
    one = made(kind, **FREE)
    ends = point(1, 4, **BOUNCES[0]), point(arb("1.05", "0.1" if overlap else 0), 4 + more,
                                            **BOUNCES[1])  # fmt: skip
    for short, said in (
        (impossible(kind), "impossible"),
        (unknown(kind), "unknown" if overlap else "flight"),
        (flight_of(kind, arb("0.9", "0.2"), arb("-0.6", "0.2")), "flight"),
    ):
        calls = asked(kind, one, monkeypatch, short=short)
        found = one.flight(*ends)
        assert calls.count("short") + calls.count("_short") == (more < 2)
        if more == 2:
            assert told(kind, found) == ("unknown" if overlap else "flight")
            continue
        assert told(kind, found) == said
        if overlap:
            assert found is short or found == short
    # both bounds of the rates hold: out is 1 and into -1/2
    ends[0].c1, ends[1].c1 = arb(0, "0.3"), arb(0, "0.3")
    asked(kind, one, monkeypatch, short=flight_of(kind, arb("1.2", "0.2"), arb("-0.7", "0.2")))
    if not overlap:
        found = one.flight(*ends)
        narrow = more < 2
        assert bool(found.out > 0.99) == narrow
        assert bool(found.into < -0.49) == narrow
        assert found.out < 1.31
        assert found.into > -0.81
        asked(kind, one, monkeypatch, short="given", flow=(arb(0, 1), "0.5", "0.5"))
        found = one.flight(*ends)
        assert (found == "given") == narrow
        assert narrow or told(kind, found) == "unknown"


def short_flight(kind: str, s: arb, *, flow=("0.25", "0.5"), longest=None, acceleration=None):
    """What is said of a short flight that starts at a height of 4, with G = 5 and W2 = 6.

    The slope of the cam is 2, its second derivative 3. acceleration: of the flight; if none is
    given, the rate that it may have.
    """
    one = made(kind, longest=longest, W2=arb(6), G=arb(5), Z=arb(0))
    given: list = []

    def move(q, w, time, order=2):
        given.append((q, time))
        return [None, None, w if acceleration is None else acceleration]

    one.machine.state = one.machine.move = move
    one.machine.flow = lambda most: (*map(arb, flow), None)
    stretch = Made(start=arb(0), end=arb(9), derivatives=lambda x, n: [None, arb(2), arb(3)])
    ends = Made(index=0, stretch=stretch, in_turn=arb(1), c=arb(4)), Made(
        index=0, stretch=stretch, in_turn=arb(2))  # fmt: skip
    return (one._short if kind == "prover" else one.short)(*ends, s), given


def holds_all(ball: arb, low: float, high: float) -> bool:
    """Whether a ball reaches from one number to the other, and hardly farther."""
    wide = ball.lower() <= low + 1e-9 and ball.upper() >= high - 1e-9
    return bool(wide and ball.rad() < (high - low) / 2 + 1e-6)


@BOTH
def test_the_rates_of_a_short_flight_are_its_half_length_times_its_acceleration(kind):
    """For 1/4 to 1/2 of a rad with B = 1/4 at the end of it, over a cam of the slope 2.

    The rate is 2 times 1 to 2, and 29 times up to 1/2 more: the acceleration is that less 3.
    """
    found, ((q, time),) = short_flight(kind, arb("0.375", "0.125"))
    assert q == 4
    assert holds_all(time, 0.0, 0.5)
    rate = arb("2").union(arb("18.5"))
    half = arb("0.125").union(arb("0.25"))
    for ball, sign in ((found.out, -1), (found.into, 1)):
        expected = sign * half * (rate - 3)
        assert ball.overlaps(expected)
        assert abs(ball.rad() / expected.rad() - 1) < 1e-6
        assert abs(ball.mid() / expected.mid() - 1) < 1e-6
    touching, _ = short_flight(kind, arb("0.25", "0.25"), acceleration=arb(-4))
    assert holds_all(touching.out, 0.0, 1.75)
    assert holds_all(touching.into, -1.75, 0.0)
    overlapping, _ = short_flight(kind, arb("0.125", "0.375"), acceleration=arb(-4))
    assert holds_all(overlapping.out, 0.0, 1.75)


@BOTH
@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"s": arb("0.5", "0.09")}, "flight"), ({"s": arb("0.5", "0.11")}, "unknown"),
        ({"longest": arb("0.49")}, "unknown"), ({"longest": arb("0.51")}, "flight"),
        ({"flow": ("0.25", "-0.1")}, "unknown"),
        ({"flow": ("-0.25", "0.5")}, "unknown"),
        ({"acceleration": arb(3)}, "impossible"),  # the gap is nowhere concave
        ({"acceleration": arb("3.1")}, "impossible"), ({"acceleration": arb("2.9")}, "flight"),
        ({"acceleration": arb("3", "0.1")}, "flight"),
    ],
)  # fmt: skip
def test_when_nothing_is_said_of_a_short_flight(kind, given, said):
    found, _ = short_flight(kind, **{"s": arb("0.5"), **given})
    assert told(kind, found) == said


# -- boxes


@BOTH
@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_equations_of_a_box_have_the_slopes_of_both_flights_of_each_impact(kind, n):
    """E of an impact is the rate out of the flight after it, and r times that into the one before.

    With r = 1/2 and flights whose rates and slopes all differ; each flight of three begins one
    impact and ends the next.
    """
    one = made(kind, r=arb("0.5"))
    flights = [
        flight_of(kind, 1, -1, slopes=[10 * k + x for x in (1, 2, 3, 4)], middle=(k + 5, -8 - k))
        for k in range(n)
    ]
    values, slopes = one.newton(flights, [None] * n)
    expected = [[0.0] * n for _ in range(n)]
    for k in range(n):
        nxt = (k + 1) % n
        expected[k][k] += 10 * k + 1
        expected[k][nxt] += 10 * k + 2
        expected[nxt][k] += 0.5 * (10 * k + 3)
        expected[nxt][nxt] += 0.5 * (10 * k + 4)
    assert [[float(slopes[i, j]) for j in range(n)] for i in range(n)] == expected
    wanted = [k + 5 - 0.5 * (8 + (k - 1) % n) for k in range(n)]
    assert [float(x) for x in values.entries()] == wanted


def no_zero(kind: str, values: list, slopes: list, off: list):
    """Whether the equations are shown to have no zero in the cells."""
    column = arb_mat([[arb(x)] for x in values])
    matrix = arb_mat([[x if isinstance(x, arb) else arb(x) for x in row] for row in slopes])
    cells = arb_mat([[arb(0, x)] for x in off])
    if kind == "checker":
        return made(kind).newton_excludes(column, matrix, cells)
    return proof._no_zero(proof.ImpactEquations(column, matrix), cells)


@BOTH
@pytest.mark.parametrize(
    ("values", "slopes", "off", "none"),
    [
        ((1,), ((2,),), ("0.51",), False), ((1,), ((2,),), ("0.49",), True),
        ((-1,), ((2,),), ("0.51",), False), ((1,), ((-2,),), ("0.51",), False),
        ((0, 1), ((1, 0), (0, 2)), ("0.1", "0.49"), True),
        ((1, 0), ((2, 0), (0, 1)), ("0.49", "0.1"), True),
        ((1, 1), ((2, 1), (1, 2)), ("0.34", "0.34"), False),  # at -1/3 each
        # the sum alone may be zero: the zero is at (-1/2, 1/2), beside the cells
        ((1, -1), ((3, 1), (1, 3)), ("0.45", "0.45"), True),
        ((1, -1), ((3, 1), (1, 3)), ("0.51", "0.51"), False),
        (("1.5", "0.5"), ((3, 1), (1, 3)), ("0.45", "0.45"), True),  # at (-1/2, 0)
        ((0, 1), ((1, 0), (0, 0)), ("0.1", "0.1"), True),  # the second is 1 everywhere
        ((1, 1), ((1, 1), (1, 1)), ("0.6", "0.6"), False),  # no inverse
        ((arb(0, 1),), ((2,),), ("0.1",), False),
    ],
)  # fmt: skip
def test_equations_have_a_zero_in_the_cells_unless_they_are_shown_to_have_none(
    kind, values, slopes, off, none
):
    assert bool(no_zero(kind, values, slopes, off)) == none


def emptiness(kind: str, monkeypatch, lengths: list, flights: list, turns=1):
    """Whether a box is shown to hold no orbit: its flights last so long and are these.

    Its equations are known to have a zero.
    """
    one = made(kind, r=arb("0.5"))
    starts = [arb(0)]
    for length in lengths:
        starts.append(starts[-1] + length)
    cells = {key: Made(x=x, h=arb(0, 1)) for key, x in zip("abcd", starts, strict=False)}
    keys = list(cells)
    by_pair = dict(zip(pairwise(keys), flights, strict=True))
    monkeypatch.setattr(one, "cell", lambda key: cells[key])
    monkeypatch.setattr(one, "later", lambda key, turns: keys[-1] if key == "a" else None)
    name = "known" if kind == "checker" else "between"
    monkeypatch.setattr(one, name, lambda *pair: by_pair[pair])
    answer = one.empty(keys[:-1], turns) if kind == "checker" else one.excluded(keys[:-1], turns)
    return answer if kind == "checker" else answer and str(answer)


TURN = 2 * 3.141592653589793


def known(kind, out=1, into=-2, slopes=(1, 0, 0, 1), middle=(0, 0)):
    return flight_of(kind, arb(out), arb(into), slopes, middle)


@BOTH
@pytest.mark.parametrize(
    ("lengths", "turns", "why"),
    [
        ((TURN,), 1, None), ((1.0,), 9, None),  # of one flight nothing is said
        ((4.0, 2.5), 1, None), ((2.5, 4.0), 1, "order"),
        ((4.0, arb(4.0, 0.1)), 1, None),  # which is longer is open
        ((3.2, 3.0), 1, None), ((3.1, 3.0), 1, "order"),  # shorter than half of the turn
        ((6.4, 6.0), 2, None), ((6.2, 6.1), 2, "order"),
        ((3.0, 2.0, 1.0), 1, None), ((2.0, 1.5, 2.5), 1, "order"), ((2.0, 1.5, 1.0), 1, "order"),
    ],
)  # fmt: skip
def test_the_first_flight_of_a_box_is_the_longest(kind, monkeypatch, lengths, turns, why):
    flights = [known(kind) for _ in lengths]
    found = emptiness(kind, monkeypatch, list(lengths), flights, turns)
    assert found == (why if kind == "prover" else why is not None)


@BOTH
@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_box_is_empty_where_one_flight_or_one_impact_is_none(kind, monkeypatch, n):
    """r is 1/2: an impact that leaves at 1 comes in at -2, one that leaves at 2 at -4."""
    lengths = [4.0 - 0.1 * k for k in range(n)]

    def found(flights):
        said = emptiness(kind, monkeypatch, lengths, flights)
        return said if kind == "prover" else ("impact" if said else None)

    good = [known(kind, out=k + 1, into=-2 * ((k + 1) % n + 1)) for k in range(n)]
    assert found(good) is None
    for k in range(n):
        flights = list(good)
        flights[k] = impossible(kind)
        assert found(flights) == ("flight" if kind == "prover" else "impact")
        flights[k] = unknown(kind)
        assert found(flights) is None
        out, into = good[k].out, good[k].into
        flights[k] = known(kind, out, into - 1)
        assert found(flights) == "impact"
        flights[k] = known(kind, out + 1, into)
        assert found(flights) == "impact"
        flights[k] = known(kind, out, into, slopes=None)
        assert found(flights) is None
        flights[k] = known(kind, out, into, middle=(9, 0))  # by the mean value theorem
        assert found(flights) == "impact"
    if n == 3:  # behind a flight of which nothing is known
        assert found([unknown(kind), good[1], known(kind, out=9)]) == "impact"


@BOTH
@pytest.mark.parametrize("n", [1, 2])
def test_an_orbit_is_alone_in_the_cells_together_with_its_own_phases(kind, monkeypatch, n):
    """From cell to cell, and from the last one to the first of so many turns later."""
    one = made(kind, r=arb("0.5"))
    sizes = {"a": arb(1, "0.1"), "b": arb(2, "0.1")}
    keys = [proof.Key(5, 3, 0), proof.Key(6, 3, 0)][:n]
    phases = [arb("1.3"), arb("2.4")][:n]
    module = proof if kind == "prover" else check
    monkeypatch.setattr(
        module, "Cell", lambda stretches, index, in_turn: Made(index=index, in_turn=in_turn)
    )
    monkeypatch.setattr(one, "cell", lambda key: Made(in_turn=sizes["ab"[key[0] - 5]]))
    pairs: list = []
    slopes = [known(kind)]
    monkeypatch.setattr(one, "flight", lambda *pair: pairs.append(pair) or slopes[0])
    matrix = arb_mat(n, n)
    for k in range(n):
        matrix[k, k] = arb(1, "0.5")
    newton = (None, matrix) if kind == "checker" else proof.ImpactEquations(None, matrix)
    monkeypatch.setattr(one, "newton", lambda *given: newton)
    asks = phases if kind == "prover" else [(5 + k, x) for k, x in enumerate(phases)]
    assert one.alone(keys, 3, asks) is True
    if kind == "prover":
        cells = [Made(index=5 + k, in_turn=phases[k]) for k in range(n)]
        assert one.at(cells, 3) == (newton, [1] * n)
        del pairs[n:]
    ends = [*range(5, 5 + n), 5 + 3 * 2]
    assert [(a.index, b.index) for a, b in pairs] == list(pairwise(ends))
    for k, (a, b) in enumerate(pairs):
        for cell, number in ((a, k), (b, (k + 1) % n)):
            assert cell.in_turn.contains(phases[number])
            assert cell.in_turn.contains(sizes["ab"[number]].mid())
            assert cell.in_turn.rad() < 0.3
    matrix[0, 0] = arb(1, 1)
    assert one.alone(keys, 3, asks) is False
    if kind == "checker":
        matrix[0, 0] = arb(1, "0.5")
        for none in (None, known(kind, slopes=None)):
            slopes[0] = none
            assert one.alone(keys, 3, asks) is False


@BOTH
@pytest.mark.parametrize(
    ("sprung", "damping", "bounded"),
    [(True, "under", True), (True, "over", False), (True, "near", False), (False, "under", False)],
)
def test_flights_are_bounded_where_a_spring_swings(kind, monkeypatch, sprung, damping, bounded):
    machine = Made(
        stretches=[], sprung=sprung, under=damping == "under", over=damping == "over",
        near_critical=damping == "near",
    )  # fmt: skip
    module = proof if kind == "prover" else check
    calls: list = []
    name = "_bound" if kind == "prover" else "bound"
    monkeypatch.setattr(module.PhaseCover, name, lambda self: calls.append(name))
    one = module.PhaseCover(machine)
    assert calls == [name] * bounded
    assert (one.longest, one.least) == (None, 0)


@BOTH
def test_a_cell_has_the_lift_of_all_of_its_phases_and_hardly_more(kind):
    """On c = x^3 about 1, in the turn after the next: by the mean value theorem twice over.

    The formulas of lift and slope say little of a ball of phases.
    """
    cells = check if kind == "checker" else proof

    def derivatives(x, n):
        vague = arb(0, 1) if x.rad() > 0 else arb(0)
        return [x * x * x + vague, 3 * x * x + vague, 6 * x, arb(6)][: n + 1]

    stretch = Made(derivatives=derivatives)
    cell = cells.Cell([None, stretch], 5, arb(1, "0.001"))
    assert cell.index == 5
    assert cell.stretch is stretch
    turns = 4 * arb.pi()
    assert abs(cell.middle.phase - 1 - turns) < 1e-30
    assert (cell.middle.c, cell.middle.c1) == (1, 3)
    assert (cell.x - 1 - turns).contains(arb("0.00099"))
    assert cell.h.contains(arb("0.00099"))
    assert cell.h.rad() < arb("0.0010001")
    for found, power, slope in ((cell.c, 3, 3), (cell.c1, 2, 6)):
        for end in ("0.999001", "1", "1.000999"):
            assert found.overlaps(arb(end) ** power * (1 if power == 3 else 3))
        assert found.rad() < arb(slope) * arb("0.0010021")
    assert cell.c2.contains(arb("6.005"))


def test_what_the_checker_and_the_prover_take_is_worked_out_once(monkeypatch):
    for kind, name in (("prover", "between"), ("checker", "known")):
        one = made(kind)
        calls: list = []
        one._flights = one.flights = {}
        monkeypatch.setattr(one, "cell", lambda key: key.upper())
        monkeypatch.setattr(one, "flight", lambda *pair, calls=calls: calls.append(pair) or pair)
        for pair in (("a", "b"), ("b", "a"), ("a", "b")):
            assert getattr(one, name)(*pair) == tuple(x.upper() for x in pair)
        assert calls == [("A", "B"), ("B", "A")]
        key = proof.Key(3, 7, 2)
        assert tuple(one.later(key, 4)) == (11, 7, 2)
