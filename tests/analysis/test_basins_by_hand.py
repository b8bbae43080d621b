"""Basins asked for at several speeds: what each question is given, and what is kept of it.

Cells, attractors and motions are stand-ins with numbers that all differ.
"""

from __future__ import annotations

from math import inf, log
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import settings

from camcli.analysis.basins import cell_batches, rest_outcomes, saddles
from camcli.analysis.basins import study as module
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.basins.study import Basins, BasinsQuestion, Branches, _More
from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Cost, Start
from camcli.errors import Status
from camcli.parallel import ShardDone, Work
from camcli.piece_faults import gathering

WINDOW = Window((0.3, 0.5), (-3.0, 3.0), 3, 2)
FINE = Window((0.3, 0.5), (-3.0, 3.0), 6, 4)


def basins_of(rpm=700.0, **more):
    known = {"rpm": rpm, "cam_q": 0.1, "window": FINE, "codes": np.ones((4, 6), np.int16),
             "level": None, "attractors": (), "regions": (), "stays": (), "fractions": {},
             "undecided": 0, "troubled": {}, "entropies": {}, "computed": 24, "turns": (1, 2, 3),
             "cost": Cost(1, 1, 1)}  # fmt: skip
    return Basins(**{**known, **more})


def attractor(label, q=0.3, w=0.1):
    return Attractor(label, 1, ((q, w),))


@pytest.mark.parametrize("asked", ["none", "boundary", "saddles", "exponents"])
def test_each_question_beside_the_cells_is_asked_alone(monkeypatch, asked):
    """The boundary of the window asked for, the saddles of the finest one, the cost at last."""
    calls = []
    monkeypatch.setattr(module, "uncertainty", lambda *given: calls.append(given) or "uncertainty")
    monkeypatch.setattr(
        module, "boundary_saddles", lambda *given: calls.append(given) or ["one", "two"]
    )
    monkeypatch.setattr(
        module, "largest_exponent", lambda *given: calls.append(given) or given[1].label
    )
    fault = Stub(piece="a block")
    batches = Stub(cost=Cost(7, 8, 9), faults=[fault], system="system", rpm=650.0, settings="runs")
    finder = Stub(batches=batches)
    branches = Stub(number=lambda attractors, of: (3, 1) if of is finder else None)
    wants = {name: name == asked for name in ("boundary", "saddles", "exponents")}
    speed = basins_of(attractors=(attractor("a"), attractor("b")), value=0.5)
    found = _More(branches, "follower.mass", **wants).answered(speed, finder, WINDOW)
    assert (found.branches, found.cost, found.faults) == ((3, 1), Cost(7, 8, 9), (fault,))
    assert found.uncertainty == ("uncertainty" if asked == "boundary" else None)
    assert found.saddles == (("one", "two") if asked == "saddles" else None)
    assert found.exponents == (("a", "b") if asked == "exponents" else None)
    assert (
        calls
        == {
            "none": [],
            "boundary": [(finder, WINDOW)],
            "saddles": [(finder, FINE, speed.codes)],
            "exponents": [(batches, one) for one in speed.attractors],
        }[asked]
    )


def test_a_question_that_fails_leaves_the_others(monkeypatch):
    def fails(*given):
        raise KeyError("unforeseen")

    for name in ("uncertainty", "boundary_saddles", "largest_exponent"):
        monkeypatch.setattr(module, name, fails)
    finder = Stub(batches=Stub(cost=Cost(), faults=[], system=0, rpm=0, settings=0))
    more = _More(Stub(number=lambda *given: (1,)), "follower.mass", True, True, True)
    with gathering() as faults:
        speed = basins_of(attractors=(attractor("P(1;1)"),), value=0.5)
        found = more.answered(speed, finder, WINDOW)
    assert (found.uncertainty, found.saddles, found.exponents) == (None, (), (None,))
    assert [one.piece for one in faults] == [
        "the boundary at follower.mass = 0.5", "the saddles at follower.mass = 0.5",
        "the exponent of P(1;1) at follower.mass = 0.5",
    ]  # fmt: skip


@pytest.mark.parametrize("asked_for", ["boundary", "saddles", "exponents"])
def test_basins_are_computed_value_by_value_under_their_own_names(monkeypatch, asked_for):
    calls = []

    def basins(system, rpm, runs, question, *, work, on_cells):
        calls.append((system, rpm, runs, question, work.place, on_cells))
        return basins_of(rpm, cost=Cost(int(rpm), 0, 0)), f"finder {rpm}"

    def answered(more, speed, finder, window):
        asked = {name: getattr(more, name) for name in ("boundary", "saddles", "exponents")}
        return module.replace(speed, rests=(finder, window, more.key, asked))

    monkeypatch.setattr(module, "basins", basins)
    monkeypatch.setattr(module._More, "answered", answered)
    asked = BasinsQuestion(WINDOW, refine=1)
    found = module.study(
        "system", [0.5, 0.25], "runs", asked, key="follower.mass", **{asked_for: True},
        setup=lambda value: (f"machine {value}", 100.0 * value, f"runs {value}"),
        work=Work(place="here/"), on_cells="told",
    )  # fmt: skip
    assert calls == [
        ("machine 0.5", 50.0, "runs 0.5", asked, "here/0/", "told"),
        ("machine 0.25", 25.0, "runs 0.25", asked, "here/1/", "told"),
    ]
    assert [(one.value, one.rpm) for one in found.speeds] == [(0.5, 50.0), (0.25, 25.0)]
    wants = {name: name == asked_for for name in ("boundary", "saddles", "exponents")}
    assert [one.rests for one in found.speeds] == [
        ("finder 50.0", WINDOW, "follower.mass", wants),
        ("finder 25.0", WINDOW, "follower.mass", wants),
    ]
    assert found.cost == Cost(75, 0, 0)


def test_all_speeds_of_a_shard_are_done_before_it_ends(monkeypatch):
    done = []

    def basins(system, rpm, runs, question, **more):
        done.append(rpm)
        if rpm < 3.0:
            raise ShardDone
        return basins_of(rpm), "finder"

    monkeypatch.setattr(module, "basins", basins)
    monkeypatch.setattr(module._More, "answered", lambda self, speed, *more: speed)
    with pytest.raises(ShardDone):
        module.study("system", [1.0, 2.0, 3.0], "runs", BasinsQuestion(WINDOW))
    assert done == [1.0, 2.0, 3.0]


def test_the_largest_exponent_is_of_the_multiplier_a_rest_or_a_record(monkeypatch):
    asked = []
    seen = {}

    class OneOrbit:
        def __init__(self, *given):
            asked.append(given)

        def run(self, events=True):
            return Stub(status=seen["status"], cost=Cost(3, 5, 7))

    monkeypatch.setattr(module, "Orbit", OneOrbit)
    monkeypatch.setattr(module, "of_record", lambda system, rpm, record: seen["exponents"])
    monkeypatch.setattr(cell_batches, "Orbit", OneOrbit)
    system = Stub(strobe=0.5)
    batches = CellBatches(system, 700.0, settings(17, 5))
    solved = Attractor("P(3;1:1:1)", 3, ((0.3, 0.1),) * 3, (1.0,) * 3, (-0.5 + 0j, 0.1 + 0j))
    assert module.largest_exponent(batches, solved) == pytest.approx(log(0.5) / 3)
    rests = Attractor("P(1;inf)", 1, ((0.3, 0.1),), (inf,))
    assert module.largest_exponent(batches, rests) == -inf
    assert asked == []
    chaos = Attractor("aperiodic", 0, ((0.25, 0.75), (0.5, 0.1)))
    for status, exponents, largest in (
        (Status.OK, Stub(largest=0.375), 0.375), (Status.OK, None, None),
        (Status.IMPACT_BUDGET, Stub(largest=0.375), None),
    ):  # fmt: skip
        seen.update(status=status, exponents=exponents)
        found = module.largest_exponent(batches, chaos)
        assert found == largest
    of_system, rpm, runs, start = asked[0]
    assert (of_system, rpm, runs.transient, runs.record) == (system, 700.0, 0, 4000)
    assert start == Start.at_strobe(system, 700.0, (0.25, 0.75))
    assert batches.cost == Cost(9, 15, 21)  # of three records


# -- branches


class Speed:
    """A finder of one speed whose motions end where they are told to."""

    def __init__(self, ends, omega):
        self.ends = ends
        self.batches = Stub(omega=omega)

    def destination(self, q, v):
        return self.ends.get((q, v))


def test_an_attractor_goes_on_where_motions_of_both_speeds_lead_to_each_other():
    """By state a and b are none: their labels are new. Velocities are kept, not rates."""
    old_a, old_b = attractor("old a", 0.25, 0.5), attractor("old b", 0.75, 2.0)
    new_a, new_b = attractor("new a", 0.2, 0.25), attractor("new b", 0.7, 1.0)
    to_new = {(0.25, 5.0): new_b, (0.75, 20.0): new_a}  # crosswise; omega is 10 before, 20 then
    to_old = {(0.7, 20.0): old_a, (0.2, 5.0): old_b}
    for back, known, numbers in (
        (to_old, {}, (2, 1)),
        ({(0.7, 20.0): old_a}, {}, (3, 1)),  # b does not lead back
        ({**to_old, (0.7, 20.0): old_b}, {}, (2, 3)),  # it leads back to another one
        (to_old, {0: 1}, (2, 1)),
        (to_old, {0: 0}, (1, 3)),  # one that is matched by its state keeps its branch
    ):
        branches = Branches([old_a, old_b], [0, 1], Speed(back, 10.0))
        branches._by_state = lambda attractors, known=known: dict(known)
        after = Speed(to_new, 20.0)
        assert branches.number((new_a, new_b), after) == numbers
        assert branches.present == sorted(n - 1 for n in numbers)
        assert branches.before is after
        assert [branches.last[n - 1] for n in numbers] == [new_a, new_b]
        assert len(branches.last) == max(2, *numbers)


def test_a_branch_that_was_absent_at_the_speed_before_is_not_followed():
    old, new = attractor("old", 0.25, 0.5), attractor("new", 0.2, 0.25)
    ends = {(0.25, 5.0): new}
    back = {(0.2, 5.0): old}
    for present, before, number in (
        ([0], Speed(back, 10.0), 1), ([], Speed(back, 10.0), 2), ([0], None, 2),
    ):  # fmt: skip
        branches = Branches([old], present, before)
        assert branches.number((new,), Speed(ends, 20.0)) == (number,)


# -- boundaries


def test_the_way_between_two_cells_is_halved_to_where_its_ends_part(monkeypatch):
    """Two ways: the outcome changes at q = 0.3 on the one, and on the other at v = -0.7."""
    low = np.array([[0.0, 1.0], [0.5, -2.0]])
    high = np.array([[1.0, 1.0], [0.5, 2.0]])
    monkeypatch.setattr(saddles, "_pairs", lambda window, codes: (low, high))

    def settle(q, v):
        first = np.array([q[0] < 0.3, v[1] < -0.7])
        return np.where(first, [1, 3], [2, 4]), None

    found = saddles._on_boundaries(Stub(settle=settle), "window", "codes")
    assert found == pytest.approx(np.array([[0.3, 1.0], [0.5, -0.7]]), rel=1e-15)


# -- blocks of cells

TARGETS = Stub(points=[Stub(attractor=2), Stub(attractor=1)], rests=[Stub(end=4)], stay=[5, 6],
               boxes=[0, 3, 1])  # fmt: skip
STATES = np.array([[0.5, -1.0], [0.0, 2.0]])
OUTCOMES = np.array([[0, 4, 7, 1, 3], [3, -1, 0, 0, -1]])


def read(states=STATES, outcomes=OUTCOMES, cost=(1, 2, 3), targets=TARGETS):
    return cell_batches._ends_of(targets, [states, outcomes, list(cost)])


def test_the_ends_of_a_block_are_read_back():
    found = read()
    assert found.states.tolist() == STATES.tolist()
    assert found.outcomes.tolist() == OUTCOMES.tolist()
    assert (found.cost, found.fault) == ([1, 2, 3], None)


@pytest.mark.parametrize(
    ("column", "least", "most", "told"),
    [
        (0, 0, 3, "modes"), (1, -10 - max(Status), 4, "outcomes"), (2, 0, None, "turns"),
        (3, 0, None, "turns"), (4, -1, None, "symbols"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("row", [0, 1])
def test_what_no_cell_can_have_is_refused(column, least, most, told, row):
    for value, is_taken in ((least, True), (least - 1, False), (most, True),
                            (most and most + 1, False)):  # fmt: skip
        if value is None:
            continue
        outcomes = OUTCOMES.copy()
        outcomes[row, column] = value
        if is_taken:
            read(outcomes=outcomes)
        else:
            with pytest.raises(ValueError, match=f"expected other {told}"):
                read(outcomes=outcomes)


def test_ends_of_another_shape_are_refused():
    with pytest.raises(ValueError, match="expected other gaps"):
        read(np.array([[0.5, -1.0], [-1e-9, 2.0]]))
    for states, outcomes in ((STATES[:1], OUTCOMES), (STATES, OUTCOMES[:1])):
        with pytest.raises(ValueError, match="as many states as outcomes"):
            read(states, outcomes)
    for more in ({"cost": (1, 2)}, {"cost": (1, 2, -3)}, {"states": STATES[:, :1]},
                 {"outcomes": OUTCOMES[:, :4]}):  # fmt: skip
        with pytest.raises(ValueError, match="expected"):
            read(**more)


@pytest.mark.parametrize(
    ("points", "rests", "stay", "boxes", "most"),
    [([6], [2], [9], [3], 6), ([1], [5], [9], [3], 5), ([1], [2], [9] * 5, [3], 4),
     ([1], [2], [9], [8, 3], 7), ([], [], [], [], -1)],
)  # fmt: skip
def test_the_largest_outcome_is_that_of_the_last_attractor_that_is_known(
    points, rests, stay, boxes, most
):
    targets = Stub(points=[Stub(attractor=k) for k in points], rests=[Stub(end=k) for k in rests],
                   stay=stay, boxes=boxes)  # fmt: skip
    outcomes = np.array([[0, most, 7, 1, 3]])
    read(STATES[:1], outcomes, targets=targets)
    with pytest.raises(ValueError, match="expected other outcomes"):
        read(STATES[:1], outcomes + np.array([0, 1, 0, 0, 0]), targets=targets)


def test_the_record_of_a_cell_begins_with_its_state_to_the_last_bit(monkeypatch):
    runs = []

    class OneOrbit:
        def __init__(self, system, rpm, run, start):
            runs.append((system, rpm, run.transient, run.record, start))
            self.state = Stub(gap=9.0, gap_rate=9.0, mode=9, period=-3)

        def run(self):
            return self.state

    monkeypatch.setattr(rest_outcomes, "Orbit", OneOrbit)
    batches = Stub(system="system", rpm=700.0, settings=settings(1, 2),
                   start=lambda gap, rate, mode: (gap, rate, mode),
                   record=lambda orbit: orbit.run())  # fmt: skip
    state = rest_outcomes.record_of(batches, (0.125, -0.5, 1.0), 17, 5)
    assert vars(state) == {"gap": 0.125, "gap_rate": -0.5, "mode": 1, "period": -3}
    ((system, rpm, transient, record, start),) = runs
    assert (system, rpm, transient, record) == ("system", 700.0, 17, 5)
    assert start[0] > 0.0
    assert start[2] == 0
