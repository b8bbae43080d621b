"""What a study of basins does with cells, attractors and turns that are written down here."""

from __future__ import annotations

from math import fsum, inf, nan, sqrt
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import chapter_system, settings

from camcli.analysis.basins import (
    attractor_finder,
    cell_batches,
    recurrence,
    region,
    saddles,
)
from camcli.analysis.basins import study as study_module
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import BELOW, AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches, Ends
from camcli.analysis.basins.measures import _fitted, fractions, uncertainty
from camcli.analysis.basins.recurrence import Boxes, Grid, boxes_of
from camcli.analysis.basins.refinement import Refined
from camcli.analysis.basins.region import (
    CaptureRegion,
    _holds,
    _turn_maps,
    parted,
    region_of,
    rings,
    size_of,
)
from camcli.analysis.basins.study import BasinsQuestion, Branches, basins
from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Cost, Orbit, Start
from camcli.errors import Status
from camcli.kernel.cells import FORGOTTEN, NEW_REST, UNDECIDED
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import RESTING

# -- all of one speed


@pytest.mark.parametrize("refined", [0, 1])
def test_what_is_told_of_one_speed(monkeypatch, refined):
    """Three attractors, found as c, a and b; two hundred cells, of which fifty have no turns."""
    window = Window((0.3, 0.5), (-3.0, 3.0), 20, 10)
    outcome = np.zeros(200, np.int16)
    for begin, value in ((60, 1), (100, 2), (150, BELOW), (160, UNDECIDED), (167, -13), (170, -12)):
        outcome[begin:] = value
    turns = np.zeros(200, np.int32)
    turns[25:175] = np.arange(150, 0, -1)
    rests = Stub(decided=((1.5, "after"),))
    batches = Stub(lift=(0.25, 0.5), cost=Cost(1, 2, 3))
    finder = Stub(
        attractors=["c", "a", "b"], regions=["of c", "of a", "of b"], boxes=Stub(stays=[5, 6, 7]),
        ranks=lambda: np.array([3, 1, 2], np.int16), rests=rests, batches=batches,
        look_around=lambda window: asked.append(window),
    )  # fmt: skip
    asked, made = [], []

    def settle(q, v, on_cells, share):
        asked.append((q[21], v[21], on_cells, share))
        return outcome, turns

    def refine(of, window, levels, on_cells):
        asked.append((of, window, levels, on_cells))
        level = np.ones((10, 20), np.uint8)
        return Refined(window, outcome, level, turns, 77)

    finder.settle = settle
    monkeypatch.setattr(study_module, "refine", refine)
    monkeypatch.setattr(study_module, "CellBatches", lambda *given: made.append(given) or batches)
    monkeypatch.setattr(
        study_module, "AttractorFinder", lambda of, budget: made.append((of, budget)) or finder
    )
    question = BasinsQuestion(window, 400, refined)
    found, its_finder = basins("system", 650.0, "runs", question, work="work", on_cells="told")
    assert made == [("system", 650.0, "runs", "work"), (batches, 400)]
    assert its_finder is finder
    centre = (0.3 + 0.2 * 1.5 / 20, -3.0 + 6.0 * 1.5 / 10)
    assert asked[0] is window
    assert asked[1] == (
        (finder, window, 1, "told") if refined else (*map(pytest.approx, centre), "told", True)
    )
    codes = np.zeros(200, int)
    for begin, code in ((0, 3), (60, 1), (100, 2), (150, -1), (160, 0), (167, -3), (170, -2)):
        codes[begin:] = code
    assert found.codes.tolist() == codes.reshape(10, 20).tolist()
    assert (found.attractors, found.regions, found.stays) == (
        ("a", "b", "c"), ("of a", "of b", "of c"), (6, 7, 5),
    )  # fmt: skip
    shares = {code: share for code, (share, _) in found.fractions.items()}
    assert list(shares) == [1, 2, 3, 0, -2, -3]
    assert shares[2] == 50 / 190
    assert (found.undecided, found.troubled) == (7, {2: 30, 3: 3})
    assert found.turns == (75, 148, 150)  # of 150 the 75th, the 148th and the last
    assert found.computed == (77 if refined else 200)
    assert (found.level is None) == (not refined)
    assert (found.cam_q, found.cost, found.rests) == (0.25, Cost(1, 2, 3), rests.decided)
    finder.boxes = None
    assert basins("system", 650.0, "runs", question)[0].stays == (0, 0, 0)


def test_a_branch_goes_on_by_state_where_the_label_is_the_same():
    """Each the nearest to the other, and near: of 0.3 m that is within 0.09."""
    old = [Attractor("a", 1, ((0.3, 0.1),)), Attractor("b", 1, ((0.5, 0.1),))]
    branches = Branches(old)
    new = [Attractor("b", 1, ((0.31, 0.1),)), Attractor("a", 1, ((0.35, 0.1),)),
           Attractor("a", 1, ((0.36, 0.1),))]  # fmt: skip
    assert branches._by_state(new) == {1: 0}
    assert branches._by_state([Attractor("b", 1, ((0.64, 0.1),))]) == {0: 1}
    assert branches._by_state([Attractor("b", 1, ((0.72, 0.1),))]) == {}
    assert Branches()._by_state(new) == {}


# -- the finder


def finder_of(batches=None, **more):
    """A finder that has not begun."""
    found = AttractorFinder.__new__(AttractorFinder)
    known = {"batches": batches, "budget": 400, "attractors": [], "regions": [],
             "targets": "targets", "boxes": None, "chunk": 3, "aperiodic_turns": 3000}  # fmt: skip
    for name, value in {**known, **more}.items():
        setattr(found, name, value)
    return found


@pytest.mark.parametrize(
    ("restitution", "damping", "dissipates"),
    [(1.0, 0.0, False), (1.0, 1e-9, True), (0.999, 0.0, True), (0.5, 2.0, True)],
)
def test_energy_is_lost_in_impacts_or_in_a_damper(restitution, damping, dissipates):
    """Where it is not, nothing is met, and no attractor is looked for."""
    follower = Stub(restitution=restitution, damping=damping)
    asked, told = [], []

    def settle(*given):
        asked.append(given)
        return np.array([4, 5]), np.array([6, 7])

    batches = Stub(
        system=Stub(follower=follower), states=lambda q, v: (np.array([0.1, -1e-9, 0.0]), v)
    )
    finder = finder_of(batches, _settle=settle)
    assert finder.dissipates is dissipates
    outcome, turns = finder.settle([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], told.append, share=True)
    assert (outcome.tolist(), turns.tolist()) == ([4, BELOW, 5], [6, 0, 7])
    ((q, v, budget, on_cells, share),) = asked
    assert (q.tolist(), v.tolist(), budget) == ([1.0, 3.0], [4.0, 6.0], 400 if dissipates else 1)
    assert (on_cells, share, told) == (told.append, True, [1])
    if not dissipates:
        assert finder._discover(np.zeros((2, 3))) is False


def test_the_first_starts_are_ten_by_ten_and_rest():
    """Those of two of ten columns are below the cam, which moves at the strobe."""
    seen = []
    batches = Stub(lift=(0.345, 0.25), omega=4.0)
    finder = finder_of(batches, _settle=lambda *given: seen.append(given))
    finder.look_around(Window((0.3, 0.5), (-3.0, 3.0), 7, 5))
    ((q, v, turns, _),) = seen
    wanted = [(0.31 + 0.02 * k, -2.7 + 0.6 * n) for n in range(10) for k in range(2, 10)]
    wanted = [one for one in wanted if one[0] > 0.345]
    assert np.column_stack((q, v)) == pytest.approx(np.array([*wanted, (0.345, 1.0)]))
    assert turns == 200


def test_the_end_of_one_start_that_lies_below_the_cam_is_that_from_the_cam():
    asked = []

    def run(gap, rate, budget):
        asked.append((gap.tolist(), rate, budget))
        return Stub(outcome=[outcome])

    batches = Stub(states=lambda q, v: (np.array(q) - 0.5, v))
    finder = finder_of(batches, attractors=["a", "b"], _run=run)
    for outcome in (1, UNDECIDED, BELOW):
        assert finder.destination(0.25, 3.0) == ("b" if outcome == 1 else None)
    assert asked[0] == ([0.0], [3.0], 400)


@pytest.mark.parametrize(("share", "shard"), [(True, None), (False, (0, 2)), (True, (0, 2))])
def test_cells_of_other_shards_are_left_to_them(share, shard):
    """The second chunk is another shard's; of the others the undecided are not resolved then."""
    resolved = []

    def run(gap, rate, budget, share):
        if shard and share and gap[0] == 3.0:
            raise attractor_finder.ShardDone
        outcome = np.where(gap == 4.0, UNDECIDED, np.where(gap == 5.0, FORGOTTEN, 1))
        return Stub(gap=gap, outcome=outcome, turns=gap, states=lambda: np.ones((len(gap), 3)))

    batches = Stub(states=lambda q, v: (q, v), work=Stub(shard=shard))
    finder = finder_of(batches, _run=run, _resolve=lambda *given: resolved.append(given[0]))
    starts, told = np.arange(7.0), []
    if share and shard:
        with pytest.raises(attractor_finder.ShardDone):
            finder._settle(starts, starts, 50, told.append, share)
        assert (resolved, told) == ([], [3, 1])
        return
    outcome, turns = finder._settle(starts, starts, 50, told.append, share)
    assert [cells.tolist() for cells in resolved] == [[4]]
    assert outcome.tolist() == [1, 1, 1, 1, UNDECIDED, UNDECIDED, 1]
    assert (turns.tolist(), told) == (list(range(7)), [3, 3, 1])


def ends_of(gap, rate, mode, outcome, turns):
    count = len(gap)
    columns = (gap, rate, mode, outcome, turns, np.arange(count) + 50, np.arange(count) + 70)
    return Ends(*(np.array(column) for column in columns))


def test_a_start_that_stops_at_an_unknown_rest_is_followed_again():
    """Of four starts three stop; two of them at one state, the third at the same gap."""
    learned, runs = [], []
    first = ends_of([1.0, 2.0, 2.0, 2.0], [5.0, 6.0, 7.0, 6.0], [0, 1, 1, 1],
                    [3, NEW_REST, NEW_REST, NEW_REST], [11, 12, 13, 14])  # fmt: skip
    again = ends_of([8.0, 8.5, 9.0], [1.0, 1.5, 2.0], [3, 3, 3], [4, NEW_REST, 5], [21, 22, 23])
    last = ends_of([7.0], [0.5], [0], [6], [31])

    def run(gap, rate, targets, budget, mode, share=False):
        runs.append((gap.tolist(), rate.tolist(), targets, budget, mode.tolist(), share))
        return (first, again, last)[len(runs) - 1]

    def learn(start, state, turns):
        learned.append((start, state, turns))
        finder.targets = f"targets {len(learned)}"

    finder = finder_of(Stub(run=run), rests=Stub(learn=learn))
    gap, rate = np.array([0.1, 0.2, 0.0, 0.4]), np.array([1.0, 2.0, 3.0, 4.0])
    ends = finder._run(gap, rate, 60, share=True)
    modes = [FREE, FREE, BOUNCED, FREE]
    assert runs == [
        (gap.tolist(), rate.tolist(), "targets", 60, modes, True),
        ([0.2, 0.0, 0.4], [2.0, 3.0, 4.0], "targets 2", 60, modes[1:], False),
        ([0.0], [3.0], "targets 3", 60, [BOUNCED], False),
    ]
    assert learned == [
        ((0.2, 2.0, FREE), (2.0, 6.0, 1), 12), ((0.0, 3.0, BOUNCED), (2.0, 7.0, 1), 13),
        ((0.0, 3.0, BOUNCED), (8.5, 1.5, 3), 22),
    ]  # fmt: skip
    assert ends.outcome.tolist() == [3, 4, 6, 5]
    assert ends.states().tolist() == [
        [1.0, 5.0, 0.0], [8.0, 1.0, 3.0], [7.0, 0.5, 0.0], [9.0, 2.0, 3.0],
    ]  # fmt: skip
    assert (ends.turns.tolist(), ends.stay[1], ends.symbol[1]) == ([11, 21, 31, 23], 50, 70)
    runs.clear()
    finder._run(gap, rate, 60, np.array([5, 6, 7, 8]))  # modes that are known are not guessed
    assert runs[0][4] == [5, 6, 7, 8]


def test_the_undecided_are_followed_from_where_they_were_left():
    """Their turns add up; it ends where nothing is new or nothing is undecided."""
    looked, runs = [], []
    again = [
        ends_of([0.5, 0.6, 0.7], [5.0, 6.0, 7.0], [0, 1, 3], [2, UNDECIDED, UNDECIDED], [9, 8, 7]),
        ends_of([0.8, 0.9], [8.0, 9.0], [0, 0], [UNDECIDED, 1], [4, 3]),
    ]

    def run(gap, rate, budget, mode):
        runs.append((gap.tolist(), rate.tolist(), budget, mode.tolist()))
        return again[len(runs) - 1]

    def discover(states):
        looked.append(states.tolist())
        return len(looked) < 3

    finder = finder_of(_run=run, _discover=discover)
    outcome, turns = np.full(5, UNDECIDED, np.int16), np.full(5, 100, np.int32)
    states = np.array([[0.1, 1.0, 0.0], [0.2, 2.0, 1.0], [0.3, 3.0, 3.0]])
    finder._resolve(np.array([4, 0, 2]), states, 60, outcome, turns)
    assert runs == [
        ([0.1, 0.2, 0.3], [1.0, 2.0, 3.0], 60, [0, 1, 3]), ([0.6, 0.7], [6.0, 7.0], 60, [1, 3]),
    ]  # fmt: skip
    assert looked[1:] == [[[0.6, 6.0, 1.0], [0.7, 7.0, 3.0]], [[0.8, 8.0, 0.0]]]
    assert outcome.tolist() == [UNDECIDED, UNDECIDED, 1, UNDECIDED, 2]
    assert turns.tolist() == [112, 100, 110, 100, 109]


@pytest.mark.parametrize(("new", "asked"), [(None, 16), (0, 1), (25, 9)])
def test_some_of_the_different_states_are_looked_at(new, asked):
    """Forty-nine, twice each and in no order: sixteen, evenly spread, until one is new."""
    seen = []

    def identify(gap, rate, mode):
        seen.append((gap, rate, mode))
        return gap == new

    follower = Stub(restitution=0.5, damping=0.0)
    finder = finder_of(Stub(system=Stub(follower=follower)), identify=identify)
    gaps = np.tile(np.arange(49.0)[::-1], 2)
    found = finder._discover(np.column_stack((gaps, -gaps, np.ones(98))))
    assert found is (new is not None)
    wanted = [k * 48 // 15 for k in range(16)]
    assert seen == [(float(k), -float(k), 1.0) for k in wanted][:asked]
    seen.clear()
    assert finder._discover(np.array([[7.0, 1.0, 0.0], [5.0, 2.0, 0.0]])) is False
    assert [gap for gap, *_ in seen] == [5.0, 7.0]


@pytest.mark.parametrize(
    ("outcome", "status", "chatter", "orbit", "recurs", "found"),
    [
        (UNDECIDED, Status.OK, [0, 0, 1], None, True, "taken up"),  # no whole turn rests
        (2, Status.OK, [0, 0, 0], None, True, False),
        (FORGOTTEN, Status.OK, [0, 0, 0], None, True, False),
        (-13, Status.OK, [0, 0, 0], None, True, False),
        (UNDECIDED, Status.IMPACT_BUDGET, [0, 0, 0], None, True, False),
        (UNDECIDED, Status.OK, [0, 1, 0], None, True, False),
        (UNDECIDED, Status.OK, [0, 0, 0], "orbit", True, "admitted"),
        (UNDECIDED, Status.OK, [0, 0, 0], None, False, False),
    ],
)
@pytest.mark.parametrize("patience", [20, 9000])
def test_when_a_long_record_is_an_aperiodic_attractor(
    monkeypatch, outcome, status, chatter, orbit, recurs, found, patience
):
    runs = []
    record = Stub(status=status, chatter=chatter, periods=2)

    class OneOrbit:
        def __init__(self, system, rpm, run, start):
            runs.append((run.transient, run.record, start))

        def run(self, events=True):
            return record

        def go_on(self, skipped, turns):
            return Stub(run=lambda events: (skipped, turns, events))

    def run(gap, rate, targets, budget, mode):
        runs.append((gap, rate, targets, budget, mode))
        return Stub(outcome=[outcome], gap=[0.5], rate=[0.25], mode=[3])

    monkeypatch.setattr(attractor_finder, "Orbit", OneOrbit)
    monkeypatch.setattr(
        attractor_finder, "identify",
        lambda system, rpm, record: orbit if record == (0, 130, True) else "wrong",
    )  # fmt: skip
    monkeypatch.setattr(recurrence, "is_recurrent", lambda points: recurs)
    batches = Stub(
        run=run, settings=module_settings(patience), system="system", rpm=700.0,
        start=lambda *state: state, passages=lambda of: np.arange(6).reshape(3, 2),
        record=lambda run, events=True: run.run(events=events),
    )  # fmt: skip
    taken = []
    finder = finder_of(
        batches, take_up=lambda points: taken.append(points.tolist()) or "taken up",
        _admit_orbit=lambda one: taken.append(one) or "admitted",
    )  # fmt: skip
    assert finder._recognise(0.1, 0.2, 1) == found
    assert runs[0] == ([0.1], [0.2], "targets", max(3000, patience), [1])
    assert runs[1:] == ([(0, 3000, (0.5, 0.25, 3))] if outcome == UNDECIDED else [])
    wanted = {"taken up": [[[0, 1], [2, 3]]], "admitted": ["orbit"]}
    assert taken == wanted.get(found, [])


def module_settings(patience):
    return attractor_finder.with_turns(study_module.replace(settings(), patience=patience), 0, 1)


@pytest.mark.parametrize(("stay", "taken"), [(recurrence.MOST_STAY, True), (501, False)])
def test_only_the_stays_of_aperiodic_attractors_may_not_be_too_long(stay, taken):
    periodic = Attractor("P(1;1)", 1, ((0.3, 0.1),), (1.0,))
    finder = finder_of(Stub(lift=(0.25, 0.5)), attractors=[periodic], regions=["region"],
                       _rebuild=lambda: [9000, stay])  # fmt: skip
    assert finder.take_up(np.array([[5.0, 6.0]])) is taken


def test_whose_a_trial_is(monkeypatch):
    """From five boxes: of attractors 1, 1, 1, 2 and 2."""
    grid = Grid(0.0, 0.0, 1.0, 1.0, side=4)
    owner = np.zeros(16, int)
    owner[[5, 6, 9]], owner[[10, 15]] = 1, 2
    asked, given = [], []

    def run(gap, rate, targets, turns):
        asked.append((np.column_stack((gap, rate)).tolist(), targets, turns))
        return Stub(
            gap=np.array([1.5, 2.5, 0.5, 2.5, 3.5]), rate=np.array([1.5, 2.5, 0.5, 2.5, 3.5]),
            outcome=np.array([UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED, 3]),
            stay=np.array([4, 5, 6, 7, 8]),
        )  # fmt: skip

    monkeypatch.setattr(attractor_finder, "targets_of", lambda regions, boxes: (regions, boxes))
    monkeypatch.setattr(recurrence, "stays_of", lambda *told: given.append(told) or "stays")
    boxes = Boxes(grid, owner, [0, 0])
    assert finder_of(Stub(run=run), regions="regions")._stays(boxes) == "stays"
    centres = [[1.5, 1.5], [2.5, 1.5], [1.5, 2.5], [2.5, 2.5], [3.5, 3.5]]
    assert asked == [(centres, ("regions", boxes), 1000)]
    ((told, tried, belongs, stay),) = given
    assert told is boxes
    assert tried.tolist() == [5, 6, 9, 10, 15]
    assert belongs.tolist() == [1, 2, 1, 2, 0]  # left in 1, in 2, in none; in 2; ended elsewhere
    assert stay.tolist() == [4, 5, 6, 7, 8]


def test_attractors_are_numbered_by_their_order():
    finder = finder_of(attractors=[Stub(order=lambda k=k: k) for k in (30, 40, 10, 20)])
    assert finder.ranks().tolist() == [3, 4, 1, 2]
    finder = finder_of(attractors=[Stub(order=lambda k=k: k) for k in (20, 30, 10)])
    assert finder.ranks().tolist() == [2, 3, 1]


# -- attractors


def test_the_order_and_the_size_of_attractors():
    """Contact, then by turns, a chatter before counted impacts; aperiodic ones last."""
    cloud = np.array([[0.3, 9.0], [0.2, -7.0]])
    ordered = [
        Attractor("contact", 1, ((9.0, 9.0),), (0.0,)),
        Attractor("P(1;inf)", 1, ((0.3, 0.1),), (inf,)),
        Attractor("P(1;1)", 1, ((0.3, 0.1),), (1.0,)),
        Attractor("P(1;1)", 1, ((0.4, 0.0),), (1.0,)),
        Attractor("P(2;1:0)", 2, ((0.1, 0.1), (0.2, 0.2)), (1.0, 0.0)),
        Attractor.aperiodic_of(cloud),
    ]
    mixed = [ordered[k] for k in (3, 5, 0, 4, 2, 1)]
    assert sorted(mixed, key=lambda one: one.order()) == ordered
    assert ordered[-1].size == 9.0
    assert ordered[-1].states == ((0.2, -7.0),)
    assert not ordered[-1].is_same(Attractor.aperiodic_of(cloud))
    assert Attractor("P(1;0)", 1, ((0.0, 0.0),), (0.0,)).size == 1.0
    turned = Attractor.periodic_of("P(3;1:1:1)", ((3.0, 0.0), (1.0, 5.0), (1.0, 4.0)), (1.0,) * 3)
    assert turned.states == ((1.0, 4.0), (3.0, 0.0), (1.0, 5.0))  # the least state is the first


# -- regions


def capture(points, forms, symbols=None, shrink=0.5, radius=1.0):
    count = len(points)
    return CaptureRegion(np.array(points), np.array(forms), symbols or (1,) * count, shrink,
                         radius, 0.5, False)  # fmt: skip


def test_rings_lie_on_ellipses_that_are_inclined():
    some = capture([(5.0, 1.0), (6.0, -2.0)], [(4.0, 1.5, 1.0), (2.0, -0.3, 50.0)])
    starts, at = rings(some)
    sizes = size_of(some, at, *starts.T)
    assert np.sort(sizes).reshape(3, 48) == pytest.approx(
        np.repeat([[0.04], [0.36], [1.0]], 48, axis=1)
    )
    for j, (a, b, c) in enumerate(some.forms):
        x, y = (starts[at == j] - some.points[j]).T
        assert sizes[at == j] == pytest.approx(a * x * x + b * x * y + c * y * y)
        angles = np.sort(np.arctan2(sqrt(c - b * b / 4.0 / a) * y, sqrt(a) * (x + b * y / 2.0 / a)))
        apart = np.diff(angles[::3])  # the same 24 directions on each ring
        assert len(apart) == 23
        assert 0.1 < apart.min() < apart.max() < 0.4


class Linear:
    """Turns about two points, each by its own factor along both axes; later ones by `later`."""

    def __init__(self, factors, symbols=(1, 1), later=None):
        self.factors, self.symbols, self.later, self.turns = factors, symbols, later, []
        self.points = np.array([(5.0, 1.0), (6.0, -2.0)])

    def run(self, gap, rate, targets, turns, mode=None):
        x, symbol = np.column_stack((gap, rate)), None
        for n in range(turns):
            j = np.abs(x[:, None] - self.points[None]).max(2).argmin(1)
            factor = np.array(self.factors)[j]
            if self.later is not None and sum(self.turns) + n >= 2:
                factor = np.full(len(j), self.later)
            x = self.points[1 - j] + factor[:, None] * (x - self.points[j])
            symbol = np.array(self.symbols)[j]
        self.turns.append(turns)
        return Stub(gap=x[:, 0], rate=x[:, 1], mode=np.zeros(len(x), int), symbol=symbol)


@pytest.mark.parametrize(
    ("factors", "symbols", "later", "shrink", "holds"),
    [
        ((0.8, 0.8), (1, 2), None, 0.5, True),
        ((0.8, 0.8), (2, 1), None, 0.5, False),  # other impacts
        ((1.5, 0.3), (1, 2), None, 0.5, False),  # out of the second ellipse on the way
        ((0.3, 1.5), (1, 2), None, 0.5, False),
        ((0.8, 0.8), (1, 2), None, 0.4, False),  # to 0.41 of the form in a period
        ((0.8, 0.8), (1, 2), 1.0, 0.5, False),  # it does not come home
    ],
)
def test_what_a_region_has_to_hold(factors, symbols, later, shrink, holds):
    circles = [(4.0, 0.0, 4.0)] * 2
    turns = Linear(factors, symbols, later)
    some = capture(turns.points, circles, (1, 2), shrink)
    assert _holds(turns, some) is holds
    if holds:  # 0.5^10 is below a thousandth: ten periods of two turns
        assert turns.turns == [1, 1, 20]
        turns.turns.clear()
        assert _holds(turns, some, most_turns=5)
        assert turns.turns == [1, 1, 6]
        assert not _holds(Linear((0.8, 0.8), (1, 2), 0.95), some, most_turns=5)


@pytest.mark.parametrize(("rho", "attracts"), [(1.0, False), (nan, False), (0.999, True)])
def test_an_orbit_attracts_where_its_map_shrinks(monkeypatch, rho, attracts):
    monkeypatch.setattr(region, "_turn_maps", lambda *_: np.zeros((1, 2, 2)))
    monkeypatch.setattr(region, "_spectral_radius", lambda maps: rho)
    monkeypatch.setattr(region, "_holds", lambda *_: True)
    attractor = Attractor("P(1;1)", 1, ((0.3, 0.1),), (1.0,))
    found = region_of(Stub(lift=(0.1, 0.0)), attractor)
    assert (found is not None) == attracts


@pytest.mark.parametrize("thin", [None, 0, 1])
def test_no_ellipse_may_be_too_thin(monkeypatch, thin):
    """One of two is inclined, and its axes are as 1 to 1e6."""
    forms = np.array([[1.0, 0.0, 1.0]] * 2)
    if thin is not None:
        forms[thin, 1] = 2.0 - 2e-12
    monkeypatch.setattr(region, "_turn_maps", lambda *_: np.zeros((2, 2, 2)))
    monkeypatch.setattr(region, "_spectral_radius", lambda maps: 0.5)
    monkeypatch.setattr(region, "_forms", lambda maps, s: forms)
    monkeypatch.setattr(region, "_holds", lambda *_: True)
    # a rounding above the cam at rest, and a rounding below it
    states = ((0.1 + 1e-14, 1e-14), (0.1 - 1e-9, 0.5))
    found = region_of(Stub(lift=(0.1, 0.0)), Attractor("P(2;1:1)", 2, states, (1.0, 1.0)))
    assert found.returns == (thin is None)
    assert found.radius == (0.25 if thin is None else 1e-8)
    assert found.points.tolist() == [[0.0, 0.0], [0.0, 0.5]]


def test_no_difference_is_taken_from_below_the_cam():
    """Of a point 2e-8 above it half of that, and nothing of one at rest."""
    slopes, lowest = np.array([[0.5, 0.25], [-1.0, 2.0]]), []

    def run(gap, rate, nothing, turns):
        lowest.append(float(gap.min()))
        x, y = slopes @ np.array([gap, rate])
        return Stub(gap=x, rate=y, symbol=np.array([1] * 12))

    points = np.array([[2e-8, 1.0], [0.0, 0.0], [0.5, 1.0]])
    maps = _turn_maps(Stub(run=run), points, (1, 1, 1), 1.0)
    assert lowest == [0.0]
    assert maps[0] == pytest.approx(slopes, rel=1e-5)
    assert maps[1].tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert maps[2] == pytest.approx(slopes, rel=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "radii"),
    [
        (1.0, 1.0, [0.5, 0.5]), (1.0, 1.9e-11, None), (1.9e-11, 1.0, None),
        (2e-11, 2e-11, [1e-11, 1e-11]),
    ],
)  # fmt: skip
def test_regions_that_would_have_to_be_tiny_are_one(old, new, radii):
    """Two circles of one metre, 1.5 m apart: one halving parts them."""
    circle = [(1.0, 0.0, 1.0)]
    found = parted([capture([(0.0, 0.0)], circle, radius=old)],
                   capture([(1.5, 0.0)], circle, radius=new))  # fmt: skip
    assert (found and [one.radius for one in found]) == radii


# -- boxes


def test_a_box_that_a_record_visits_is_no_neighbours():
    """Two records in one column of boxes, and in one row, next to each other."""
    corners = [(0.0, 0.0), (96.0, 96.0)]
    for step in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)):
        one = np.array([*corners, (40.5, 40.5)])
        two = np.array([corners[0], np.add((40.5, 40.5), step)])
        for records in ({0: one, 1: two}, {0: two, 1: one}):
            found = boxes_of(records, [None, None], 2)
            for k, record in records.items():
                assert found.owner[found.grid.boxes(record[-1:])].tolist() == [k + 1]
    assert found.stays == [1 << 40] * 2


def test_the_table_of_boxes_and_their_centres():
    grid = Grid(-0.5, 2.0, 4.0, 0.5, side=6)
    assert grid.centres(np.array([0, 1, 2, 8, 35])) == pytest.approx(
        np.array([(0.0, 3.0), (0.0, 3.0), (0.125, 3.0), (0.125, 5.0), (0.875, 13.0)])
    )
    targets = cell_batches.NOTHING
    filled = Boxes(grid, np.arange(36), [7, 8]).fill(targets)
    assert (filled.gap, filled.rate, filled.per_gap, filled.per_rate) == (-0.5, 2.0, 4.0, 0.5)
    assert (filled.columns, filled.rows, filled.stay) == (6, 6, [7, 8])
    assert filled.boxes.tolist() == list(range(36))
    whole = Grid.over(np.array([(0.0, -1.0), (0.96, 1.88)]))
    assert (whole.gap, whole.rate) == pytest.approx((-0.02, -1.06))
    assert (whole.per_gap, whole.per_rate, whole.side) == pytest.approx((100.0, 100.0 / 3.0, 100))


# -- blocks of cells


def test_a_state_at_the_strobe_as_a_start():
    """Within a rounding of the cam it is on it; at rest it has no numbers of its own."""
    batches = CellBatches(chapter_system(120.0), 300.0, settings())
    c, c1 = batches.lift
    assert c1 > 0.1
    omega = 300.0 * np.pi / 30.0
    q, v = [c, c + 1e-16, c - 1e-16, c + 0.25, c - 1e-9], [0.0, 1.0, 2.0, 3.0, 4.0]
    gap, rate = batches.states(q, v)
    assert gap.tolist() == pytest.approx([0.0, 0.0, 0.0, 0.25, -1e-9], abs=1e-16)
    assert gap[:3].tolist() == [0.0, 0.0, 0.0]
    assert rate == pytest.approx(np.array(v) / omega - c1)
    strobe = batches.system.strobe
    assert batches.start(0.5, 0.25, RESTING) == Start(None, None, strobe)
    assert batches.start(0.5, 0.25, FREE) == Start(
        c + 0.5, pytest.approx((c1 + 0.25) * omega), strobe
    )
    record = Stub(strobe_q=np.array([c, c + 0.5]), strobe_w=np.array([c1 - 1.0, c1]))
    assert batches.passages(record) == pytest.approx(np.array([(0.0, -1.0), (0.5, 0.0)]))


def test_a_block_is_kept_and_counted(monkeypatch):
    """Five cells in blocks of two; what is kept of a block fits a block of as many cells."""
    fault = Stub(piece="one")
    asked = []

    def run(task, blocks, codec, share):
        asked.append((task, blocks, codec, share))
        return [
            cell_batches.BlockEnds(
                np.column_stack((gap, rate)), np.arange(5 * len(gap)).reshape(-1, 5),
                [1, 20, 300], fault if k == 1 else None,
            )
            for k, (gap, rate, _) in enumerate(blocks)
        ]  # fmt: skip

    batches = CellBatches("system", 650.0, "runs", work=Stub(run=run), block=2, steps=77)
    gaps, rates = [0.0, 0.2, 0.0, 0.4, 0.5], [1.0, 2.0, -3.0, 4.0, 5.0]
    ends = batches.run(gaps, rates, "targets", 60, share=True)
    ((task, blocks, codec, share),) = asked
    assert vars(task) == {
        "system": "system", "rpm": 650.0, "settings": "runs", "targets": "targets", "budget": 60,
        "count": 5, "steps": 77,
    }  # fmt: skip
    assert [[column.tolist() for column in block] for block in blocks] == [
        [[0.0, 0.2], [1.0, 2.0], [BOUNCED, FREE]], [[0.0, 0.4], [-3.0, 4.0], [FREE, FREE]],
        [[0.5], [5.0], [FREE]],
    ]  # fmt: skip
    assert share is True
    assert (batches.cost, batches.faults) == (Cost(3, 60, 900), [fault])
    assert (ends.gap.tolist(), ends.rate.tolist()) == (gaps, rates)
    assert [column[3] for column in (ends.mode, ends.outcome, ends.turns)] == [5, 6, 7]
    assert [column[3] for column in (ends.stay, ends.symbol)] == [8, 9]
    done = cell_batches.BlockEnds(np.ones((2, 2)), np.ones((2, 5)), [1, 2, 3])
    assert codec.fits(done, blocks[0])
    assert not codec.fits(done, blocks[2])
    assert codec.faults(done) == ()
    assert codec.faults(done._replace(fault=fault)) == (fault,)
    assert [np.array(part).tolist() for part in codec.store(done)] == [
        [[1.0] * 2] * 2, [[1.0] * 5] * 2, [1, 2, 3],
    ]  # fmt: skip


def test_cells_cost_what_their_motions_cost(chapter):
    """Of two that bounce, for six turns each."""
    batches = CellBatches(chapter, 700.0, settings())
    gaps, rates = [0.25, 0.375], [0.5, -0.25]
    batches.run(gaps, rates, cell_batches.NOTHING, 6)
    cost = Cost()
    for gap, rate in zip(gaps, rates, strict=True):
        start = batches.start(gap, rate, FREE)
        cost += Orbit(chapter, 700.0, settings(0, 6), start).run(strobes=False).cost
    assert batches.cost == cost
    assert len(set(cost)) == 3


def test_cells_of_a_block_that_failed_have_the_modes_they_began_with(monkeypatch):
    def fails(*given):
        raise ZeroDivisionError

    monkeypatch.setattr(cell_batches._Task, "_followed", fails)
    task = cell_batches._Task("system", 650.0, "runs", "targets", 60, 2, 77)
    done = task((np.array([0.5, 0.0]), np.array([1.0, 2.0]), np.array([FREE, BOUNCED])))
    assert done.states.tolist() == [[0.5, 1.0], [0.0, 2.0]]
    failed = cell_batches.FAILED
    assert done.outcomes.tolist() == [[FREE, failed, 0, 0, 0], [BOUNCED, failed, 0, 0, 0]]
    assert (done.cost, "2 cells at 650 rpm, from 0.5 m" in done.fault.piece) == ([0, 0, 0], True)


# -- measures


def naive_shares(codes, listed):
    """Cell by cell: the share of each code, and p (1 - p) of those around a cell that differ."""
    rows, columns = codes.shape
    cells = [(i, j) for i in range(rows) for j in range(columns) if codes[i, j] != -1]
    others = sorted({int(codes[cell]) for cell in cells} - set(listed), reverse=True)
    found = {}
    for code in [*listed, *(one for one in others if one <= 0)]:
        terms = []
        for i, j in cells:
            around = [codes[a, b] for a, b in cells if abs(a - i) <= 1 and abs(b - j) <= 1]
            p = around.count(code) / len(around)
            terms.append(p * (1.0 - p))
        share = sum(codes[cell] == code for cell in cells) / len(cells)
        found[code] = share, sqrt(fsum(terms)) / len(cells)
    return found


def test_shares_and_errors_cell_by_cell():
    """With cells below the cam beside others, undecided ones and two kinds of trouble."""
    codes = np.random.default_rng(11).choice([-1, -1, 1, 1, 2, 0, -3, -2], (9, 7)).astype(np.int16)
    found = fractions(codes, [1, 2, 3])
    wanted = naive_shares(codes, [1, 2, 3])
    assert list(found) == list(wanted) == [1, 2, 3, 0, -2, -3]
    for code, pair in wanted.items():
        assert found[code] == pytest.approx(pair, rel=1e-12)


def test_a_start_is_in_doubt_where_either_neighbour_ends_elsewhere(monkeypatch):
    """By the definition, over every start; some end nowhere, some lie below the cam."""

    def end(q, v):
        if q < 0.32:
            return BELOW
        if 0.4 < q < 0.41:
            return UNDECIDED
        return int(q > 0.45 + 0.02 * v) + 2 * int(v > 2.9) + 4 * int(0.36 < q < 0.37)

    def settle(q, v):
        return np.array([end(*one) for one in zip(q, v, strict=True)]), None

    window = Window((0.3, 0.5), (-3.0, 3.0), 7, 5)
    found = uncertainty(Stub(settle=settle), window, 900)
    golden = 1.324717957244746
    starts = [((0.5 + n / golden) % 1.0, (0.5 + n / golden**2) % 1.0) for n in range(900)]
    rows = []
    for power in range(4, 12):
        e = 0.5**power
        trios = [
            [end(0.3 + 0.2 * (x + s * e), -3.0 + 6.0 * (y + s * e)) for s in (0, 1, -1)]
            for x, y in starts
        ]
        known = [trio for trio in trios if min(trio) >= 0]
        doubt = sum(len(set(trio)) > 1 for trio in known)
        if doubt >= 10:
            rows.append((e, doubt / len(known), doubt))
    assert 3 <= len(rows) < 8
    assert np.array(found.rows) == pytest.approx(np.array(rows))


@pytest.mark.parametrize(
    ("shares", "fitted"),
    [
        ((0.9, 0.3, 0.24, 0.13, 0.07), slice(2, 5)),
        ((0.9, 0.8, 0.6, 0.5, 0.45), slice(2, 5)),  # all are saturated: the finest three
        ((0.25, 0.2, 0.1, 0.04, 0.03), slice(0, 5)),
    ],
)
def test_the_line_through_the_shares_in_doubt(shares, fitted):
    """Of least squares in the logarithms, weighted by the counts; its error grows with misfit."""
    counts = (40, 35, 30, 20, 12)
    errors = [0.5**n for n in range(4, 9)]
    found = _fitted(list(zip(errors, shares, counts, strict=True)))
    x, y, w = (
        np.array(column)[fitted]
        for column in (np.log(errors), np.log(shares), np.array(counts, float))
    )
    middle, level = np.average(x, weights=w), np.average(y, weights=w)
    square = (w * (x - middle) ** 2).sum()
    slope = (w * (x - middle) * (y - level)).sum() / square
    misfit = (w * (y - level - slope * (x - middle)) ** 2).sum() / (len(x) - 2)
    assert found.exponent == pytest.approx(slope, rel=1e-9)
    assert found.error == pytest.approx(sqrt(max(1.0, misfit) / square), rel=1e-9)
    assert found.rows == tuple(zip(errors, shares, counts, strict=True))


# -- boundaries


def test_pairs_of_cells_on_boundaries_are_spread_over_all():
    """Neighbours in a row, then in a column, of which both lead to an attractor; 24 at most."""
    window = Window((0.0, 4.0), (0.0, 3.0), 4, 3)
    codes = np.array([[1, 1, 2, 0], [1, -1, 2, 3], [2, 2, 2, 3]])
    few = [((0, 1), (0, 2)), ((1, 2), (1, 3)), ((2, 2), (2, 3)), ((1, 0), (2, 0))]
    wide = Window((0.0, 10.0), (0.0, 6.0), 10, 6)
    stripes = np.tile([1, 2], (6, 5))
    many = [((row, column), (row, column + 1)) for row in range(6) for column in range(9)]
    spread = [many[k * 54 // 24] for k in range(24)]
    for of, cells, pairs in ((window, codes, few), (wide, stripes, spread)):
        low, high = saddles._pairs(of, cells)
        for found, side in ((low, 0), (high, 1)):
            wanted = [(column + 0.5, row + 0.5) for row, column in (pair[side] for pair in pairs)]
            assert found == pytest.approx(np.array(wanted))
    low, high = saddles._pairs(window, np.ones((3, 4), int))
    assert low.shape == high.shape == (0, 2)
