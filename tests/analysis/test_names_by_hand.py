"""Exponents, labels and patience of records and runs that are written down here."""

from __future__ import annotations

from math import inf, isnan, log, nan, pi, sqrt
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis import exponents as exponents_module
from camcli.analysis import labels as labels_module
from camcli.analysis import patience as patience_module
from camcli.analysis.exponents import Exponents, _standard_error, of_orbit, of_record, sum_rule
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label, label
from camcli.analysis.patience import Watched, named_on, names_nothing, watch
from camcli.errors import Status
from camcli.kernel.orbit_loop import IMPACT

TURN = 2.0 * pi


# -- exponents


@pytest.mark.parametrize(
    ("largest", "spread", "chaotic"),
    [(0.31, 0.1, True), (0.29, 0.1, False), (1e-300, 0.0, True), (0.0, 0.0, False),
     (-0.1, 0.0, False), (-inf, 0.0, False), (0.5, inf, False), (nan, 0.1, False)],
)  # fmt: skip
def test_chaos_has_an_exponent_above_zero_by_three_errors(largest, spread, chaotic):
    found = Exponents(largest, -1.0, spread, -0.75, 2.0)
    assert found.chaotic is chaotic
    if largest > -inf:
        assert found.defect == pytest.approx(largest - 0.25)
    else:
        assert isnan(found.defect)


def test_the_rule_of_the_sum_is_infinite_where_an_impact_leaves_nothing():
    """On the cam or on its seat, if there are impacts there."""
    both = Stub(Z=0.25, r=0.5, r_seat=0.25)
    assert sum_rule(both, 3.0, 1.0) == pytest.approx(4.0 * log(0.5) + 2.0 * log(0.25) - pi)
    assert sum_rule(Stub(Z=0.25, r=0.5, r_seat=0.0), 3.0, 1.0) == -inf
    assert sum_rule(Stub(Z=0.25, r=0.5, r_seat=0.0), 3.0) == pytest.approx(6.0 * log(0.5) - pi)
    assert sum_rule(Stub(Z=0.25, r=0.0, r_seat=0.5), 3.0, 3.0) == pytest.approx(6.0 * log(0.5) - pi)
    assert sum_rule(Stub(Z=0.25, r=0.0, r_seat=0.5), 3.0, 1.0) == -inf


def test_the_error_of_a_mean_of_batches_that_count_by_their_lengths():
    rates, weights = [0.3, 0.1, 0.4, 0.2], [1.0, 2.0, 4.0, 3.0]
    mean = (0.3 + 0.2 + 1.6 + 0.6) / 10.0
    squares = sum(w**2 * (r - mean) ** 2 for r, w in zip(rates, weights, strict=True))
    assert _standard_error(rates, weights) == pytest.approx(sqrt(4.0 / 3.0 * squares) / 10.0)
    even = [2.0] * 4
    assert _standard_error(rates, even) == pytest.approx(np.std(rates, ddof=1) / 2.0)
    assert _standard_error([0.3], [1.0]) == inf


def part(first_log, area_log, impacts, length, first=1.0, area=1.0, chatters=0):
    return Stub(first_log=first_log, area_log=area_log, impacts=impacts, length=length,
                first=first, area=area, chatters=chatters)  # fmt: skip


def seat_machine(r=0.5, r_seat=0.25, has_seat=True):
    """Stretch 1, beyond 1 rad, is the seat."""
    cam = Stub(stretches=[Stub(seat=0), Stub(seat=1)])
    const = Stub(r=r, r_seat=r_seat, Z=0.125)
    return Stub(constants=lambda *_: const, cam_for=lambda kernel: "cam", cam=cam,
                has_seat=has_seat)  # fmt: skip


@pytest.fixture
def measured(monkeypatch):
    """`of_record` of a machine and a record whose parts are told."""
    monkeypatch.setattr(exponents_module, "stretch_at", lambda cam, theta: int(theta > 1.0))

    def of(parts, machine=None, rows=80, theta=None):
        kernel = Stub(copies=lambda *_: "growths", numbers=lambda values, *_: values,
                      table=lambda *_: None, stretch_events=lambda *_: None)  # fmt: skip
        monkeypatch.setattr(exponents_module.backend, "current", lambda: kernel)
        monkeypatch.setattr(exponents_module, "rows_of", lambda kind, growths: parts)
        theta = np.full(rows, 0.5) if theta is None else np.array(theta)
        kind = np.full(rows, IMPACT)
        kind[3] = IMPACT + 1
        record = Stub(kind=kind, period=None, theta=theta, u=None)
        return of_record(machine or seat_machine(), 700.0, record)

    return of


def test_the_exponents_of_a_record_are_means_over_its_parts_that_grow(measured):
    """What has no length, or has shrunk to nothing, is no part of them."""
    gone = [part(9.0, 9.0, 9, 0.0), part(9.0, 9.0, 9, 5.0, first=0.0),
            part(9.0, 9.0, 9, 5.0, area=0.0)]  # fmt: skip
    kept = [part(0.5, -1.0, 3, TURN), part(2.0, -2.5, 5, 3.0 * TURN)]
    theta = [2.0, 2.0, 0.5, 2.0, 2.0] + [
        0.5
    ] * 75  # the first impact begins the pair, row 3 is none
    found = measured([gone[0], kept[0], *gone[1:], kept[1]], theta=theta)
    assert found.largest == pytest.approx(2.5 / 4.0)
    assert found.largest + found.second == pytest.approx(-3.5 / 4.0)
    assert found.impacts == 2.0
    on_seat = 2.0 / 4.0
    rule = 2.0 * log(0.5) * 1.5 + 2.0 * log(0.25) * on_seat - 0.25 * TURN
    assert found.rule == pytest.approx(rule)
    rates, lengths = [0.5, 2.0 / 3.0], [TURN, 3.0 * TURN]
    assert found.spread == pytest.approx(_standard_error(rates, lengths))
    assert measured(gone) is None
    resting = measured([*kept, part(0.0, 0.0, 1, 1.0, chatters=1)])
    assert resting == Exponents(-inf, -inf, 0.0, -inf, inf)


@pytest.mark.parametrize(
    ("machine", "rows", "known"),
    [
        ({}, 80, True), ({}, 79, False), ({"r": 0.0}, 80, False), ({"r_seat": 0.0}, 80, False),
        ({"r_seat": 0.0, "has_seat": False}, 80, True),
    ],
)  # fmt: skip
def test_which_records_have_exponents(measured, machine, rows, known):
    """Of twenty parts with four impacts each, that all leave something."""
    parts = [part(0.5, -1.0, 3, TURN), part(2.0, -2.5, 5, TURN)]
    assert (measured(parts, seat_machine(**machine), rows) is not None) == known


def test_the_exponents_of_an_orbit_are_per_turn(monkeypatch):
    monkeypatch.setattr(exponents_module, "stretch_at", lambda cam, theta: int(theta > 1.0))
    orbit = Stub(
        rpm=700.0, resting=False, impacts=6, turns=4, theta=(0.5, 2.0, 0.25, 2.5, 0.5, 3.0),
        multipliers=(-0.5 + 0j, 0.3 + 0.4j),
    )  # fmt: skip
    found = of_orbit(seat_machine(), orbit)
    assert (found.largest, found.second) == pytest.approx((log(0.5) / 4.0, log(0.5) / 4.0))
    rule = (2.0 * log(0.5) * 3 + 2.0 * log(0.25) * 3) / 4.0 - 0.25 * TURN
    assert (found.rule, found.spread, found.impacts) == (pytest.approx(rule), 0.0, 1.5)
    orbit.resting = True
    assert of_orbit(seat_machine(), orbit) == Exponents(-inf, -inf, 0.0, -inf, inf)


# -- labels


@pytest.mark.parametrize(
    ("symbols", "repeats"),
    [((1, 1), True), ((1, 2), False), ((2, 1, 2, 1), True), ((1,), False), ((1, 1, 1), True),
     ((2, 1, 2), False), ((2, 1, 1, 2, 1, 1), True), ((2, 1, 2, 2, 1, 2, 2), False)],
)  # fmt: skip
def test_a_label_repeats_where_fewer_turns_have_its_symbols(symbols, repeats):
    assert Label(symbols).repeats is repeats


def record_of(periods=200, hits=50, repeats=0, rests=False, status=Status.OK):
    impacts = np.arange(periods + 1)
    chatter = np.zeros(periods + 1, int)
    if periods > 1:
        chatter[periods - 2] = 3
    return Stub(periods=periods, hits=hits, repeats=repeats, rests_throughout=rests, status=status,
                impacts=impacts, chatter=chatter)  # fmt: skip


@pytest.mark.parametrize(
    ("more", "name"),
    [
        ({"rests": True, "hits": 0}, "contact"),
        ({"rests": True, "hits": 0, "status": Status.NO_RETURN}, "undecided"),
        ({"rests": True, "hits": 0, "periods": 0}, "undecided"),
        ({"periods": 130, "hits": 16}, "aperiodic"), ({"periods": 129, "hits": 16}, "undecided"),
        ({"periods": 130, "hits": 15}, "undecided"),
        ({"repeats": 3}, "P(3;inf:199:197)"), ({"repeats": 1}, "P(1;199)"),
    ],
)  # fmt: skip
def test_the_label_of_a_record(more, name):
    """Of its last whole turns, which have 197 impacts, a chatter and 199."""
    assert label(record_of(**more)) == name


@pytest.mark.parametrize(("n", "longest", "shifts"), [
    (9, 64, [2, 4]), (8, 64, [2, 4]), (7, 64, [2]), (9, 3, [2]), (1, 64, []),
])  # fmt: skip
def test_a_shift_is_at_most_half_of_the_states(n, longest, shifts):
    """States that alternate; the distance is relative to the largest of all."""
    states = np.array([(1.0 + k % 2, -4.0) for k in range(n)])
    states[-1, 1] -= 1e-9
    found = list(labels_module.returns(states, longest))
    assert [turns for turns, _ in found] == shifts
    assert [apart for _, apart in found] == pytest.approx([0.25e-9] * len(shifts), rel=1e-5)


# -- patience


def piece(name, rests=(), repeats=0, status=Status.OK, periods=2000, cost=1):
    """A part of so many turns, some of which end in a rest; the turn behind it is not whole."""
    chatter = np.zeros(periods + 1, int)
    chatter[[*rests, periods]] = 1
    return Stub(name=name, chatter=chatter, repeats=repeats, status=status,
                periods=periods, cost=Cost(cost, 10 * cost, 100 * cost))  # fmt: skip


class Run:
    """A run; it shows the turns that it is asked for."""

    system = "system"

    def __init__(self, name, shown):
        self.name, self.shown, self.asked = name, shown, []

    def go_on(self, skipped, turns):
        self.asked.append((skipped, turns))
        return Stub(run=lambda: self.shown)


@pytest.fixture
def watched(monkeypatch):
    """`watch` over parts of 2000 turns, at most ten at once; (found, parts asked of each run)."""

    def of(patience, *batches, solved=None, calms=False):
        """batches: (run, record) of the parts of each call."""
        left, asked = iter(batches), []

        def follow_on(orbit, parts):
            asked.append((orbit.name, list(parts)))
            return next(left)

        exponents = Stub(largest=-0.31 if calms else -0.29, spread=0.1)
        monkeypatch.setattr(patience_module, "follow_on", follow_on)
        monkeypatch.setattr(
            patience_module, "of_record",
            lambda system, rpm, record: exponents if record.name.startswith("shown") else None,
        )  # fmt: skip
        monkeypatch.setattr(
            patience_module, "identify",
            lambda system, rpm, record: "orbit" if record.name == solved else None,
        )  # fmt: skip
        return watch(Run("begun", None), 700.0, patience, 50), asked

    return of


def run(name, shown=None):
    return Run(name, shown or piece(f"shown by {name}", cost=7))


def test_without_patience_nothing_is_followed(watched):
    assert watched(0) == (Watched(0, None, None, True, Cost()), [])


@pytest.mark.parametrize(("calms", "status", "stays"), [
    (False, Status.OK, True), (True, Status.OK, False), (False, Status.IMPACT_BUDGET, False),
])  # fmt: skip
def test_a_motion_that_neither_settles_nor_rests_stays(watched, calms, status, stays):
    """Ten parts at once, and 1500 turns more from the end of the tenth."""
    end = run("end", piece("shown", status=status, cost=7))
    found, asked = watched(
        21_500, [(run(str(k)), piece("part")) for k in range(10)],
        [(end, piece("last", periods=1500, cost=3))], calms=calms,
    )  # fmt: skip
    assert asked == [("begun", [2000] * 10), ("9", [1500])]
    assert (found.turns, found.record.name, found.orbit) == (21_500, "shown", None)
    assert found.stays is stays
    assert found.cost == Cost(20, 200, 2000)
    assert end.asked == [(0, 50)]


@pytest.mark.parametrize(("first", "skipped"), [(0, 0), (1, 0), (2, 1), (1999, 1998)])
def test_a_motion_that_rests_is_shown_from_the_turn_before(watched, first, skipped):
    """A chatter may begin in the turn before the one that it ends in."""
    before = run("a")
    rested = piece("b", (first, 1999), cost=2)
    found, asked = watched(
        5000, [(before, piece("a")), (run("b"), rested)], solved="shown by a"
    )  # fmt: skip
    assert asked == [("begun", [2000, 2000, 1000])]
    assert before.asked == [(skipped, 50)]
    assert (found.turns, found.record.name) == (2000 + first + 1, "shown by a")
    assert (found.orbit, found.stays, found.cost) == ("orbit", False, Cost(10, 100, 1000))


def test_a_motion_in_trouble_or_on_an_orbit_is_followed_no_further(watched):
    lost = piece("b", status=Status.IMPACT_BUDGET, periods=5, cost=2)
    found, _ = watched(9000, [(run("a"), piece("a")), (run("b"), lost)])
    assert found == Watched(2005, lost, None, False, Cost(3, 30, 300))
    batch = [(run("a"), piece("a")), (run("b"), piece("b", repeats=2))]
    found, _ = watched(9000, batch, solved="shown by b")
    assert (found.turns, found.orbit, found.stays) == (4000, "orbit", False)
    assert found.cost == Cost(9, 90, 900)
    last = [(run("c"), piece("c", periods=1000))]
    found, asked = watched(5000, batch, last)  # it looked periodic, and was not
    assert asked == [("begun", [2000, 2000, 1000]), ("b", [1000])]
    assert (found.turns, found.orbit, found.stays) == (5000, None, True)
    assert found.cost == Cost(17, 170, 1700)


@pytest.mark.parametrize(
    ("periods", "status", "name", "by"),
    [
        (129, Status.OK, "undecided", "longer"), (130, Status.OK, "undecided", "record"),
        (129, Status.OK, "P(1;1)", "record"), (129, Status.IMPACT_BUDGET, "undecided", "record"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("at_hand", [True, False])
def test_a_record_too_short_for_a_name_is_put_aside(
    monkeypatch, periods, status, name, by, at_hand
):
    record, longer = Stub(name="record", periods=periods, status=status), Stub(name="longer")
    own = Run("begun", longer)
    names = {"record": (name, "of record"), "longer": ("aperiodic", "of longer")}
    asked = []

    def named(system, rpm, record, measured):
        asked.append((system, rpm, record.name, measured))
        return names[record.name]

    monkeypatch.setattr(patience_module, "named", named)
    monkeypatch.setattr(patience_module, "label", lambda record: name)
    found = named_on(own, 700.0, record, True, longer if at_hand else None)
    assert found == (*names[by], longer if by == "longer" else record)
    assert own.asked == ([(0, 130)] if by == "longer" and not at_hand else [])
    assert {(one[0], one[1], one[3]) for one in asked} == {("system", 700.0, True)}
    assert names_nothing(record) == (by == "longer")
