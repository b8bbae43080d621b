"""Attractors: regions about them, recurrence, branches, and what follows a rest."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis import after_rest as after_rest_module
from camcli.analysis.basins import (
    attractor_finder,
    cell_batches,
    recurrence,
    rest_outcomes,
    saddles,
)
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches
from camcli.analysis.basins.region import (
    DIFFERENCES,
    CaptureRegion,
    _holds,
    _turn_maps,
    overlap,
    parted,
    rings,
    size_of,
)
from camcli.analysis.basins.study import BasinsQuestion, basins
from camcli.analysis.basins.window import Window
from camcli.kernel.cells import FORGOTTEN, UNDECIDED
from tests.conftest import settings

WINDOW = Window((0.1, 0.9), (-50.0, 50.0), 20, 20)


def finder_at(system, rpm):
    found = AttractorFinder(CellBatches(system, rpm, settings()), 4000)
    found.look_around(WINDOW)
    return found


@pytest.fixture(scope="module")
def finder(chapter):
    return finder_at(chapter, 358.5)


def labels(result):
    return [attractor.label for attractor in result.attractors]


def test_regions_bring_back_what_starts_in_them_and_are_as_wide_as_may_be(finder):
    for attractor, region in zip(finder.attractors, finder.regions, strict=True):
        assert region.returns
        starts, at = rings(region)
        assert len(starts) == 3 * 24 * len(region.points)  # on three rings about each
        assert size_of(region, at, *starts.T).max() == pytest.approx(1.0)
        ends = finder.batches.run(starts[:, 0], starts[:, 1], NOTHING, 300 * attractor.turns)
        assert size_of(region, at, ends.gap, ends.rate).max() < 1e-12
        assert _holds(finder.batches, region)
        assert not _holds(finder.batches, region.scaled(1.25))
        rho = max(abs(z) for z in attractor.multipliers)
        assert region.rho == pytest.approx(rho, rel=1e-5)
        assert rho < region.shrink < 1.0


def test_a_region_does_not_hold_with_other_impacts_or_a_faster_return(finder):
    """home: whether starts come home is not asked here."""
    region = finder.regions[0]
    assert _holds(finder.batches, region, home=1e9)
    other = tuple(symbol + 1 for symbol in region.symbols)
    assert not _holds(finder.batches, replace(region, symbols=other), home=1e9)
    assert not _holds(finder.batches, replace(region, shrink=1e-3), home=1e9)


def test_regions_are_shrunk_until_apart():
    def region(x):
        forms = np.array([[1.0, 0.0, 1.0]])
        return CaptureRegion(np.array([[x, 0.0]]), forms, (1,), 0.5, 1.0, 0.5, True)

    one, two = region(0.0), region(1.5)
    assert overlap(one, two)
    assert not overlap(one, region(2.1))
    found = parted([None, one], two)
    assert found[0] is None
    assert [r.radius for r in found[1:]] == [0.5, 0.5]
    assert parted([one], region(0.0)) is None


def test_half_widths_are_the_extents_of_the_ellipses():
    """A x^2 + B x y + C y^2 = 1, sampled by rays."""
    forms = np.array([[4.0, 1.5, 1.0], [2.0, -0.3, 50.0]])
    region = CaptureRegion(np.zeros((2, 2)), forms, (1, 1), 0.5, 1.0, 0.5, True)
    angle = np.linspace(0.0, 2.0 * np.pi, 100_001)
    x, y = np.cos(angle), np.sin(angle)
    for (a, b, c), widths in zip(forms, region.half_widths(), strict=True):
        size = 1.0 / np.sqrt(a * x * x + b * x * y + c * y * y)
        assert widths == pytest.approx([(size * x).max(), (size * y).max()], rel=1e-6)


def test_attractors_are_looked_for_from_rest_and_not_below_the_cam(chapter, monkeypatch):
    finder, seen = AttractorFinder(CellBatches(chapter, 358.5, settings()), 4000), []
    monkeypatch.setattr(finder, "_settle", lambda q, v, *_: seen.extend(zip(q, v, strict=True)))
    finder.look_around(WINDOW)
    c, c1 = finder.batches.lift
    assert (c, c1 * finder.batches.omega) in seen
    assert min(q for q, _ in seen) == c
    assert len(seen) == 101  # ten by ten of the window, and rest


def test_an_orbit_is_admitted_once_and_only_if_it_attracts(finder, chapter):
    before = list(finder.attractors)
    for known in before:
        turned = Attractor.periodic_of(
            known.label, known.states[1:] + known.states[:1], known.symbols[1:] + known.symbols[:1]
        )
        assert known.is_same(turned)
        assert not finder.admit(turned)
    assert finder.attractors == before
    doubled = finder_at(chapter, 739.35)  # P(1;1) has doubled its period there: it repels
    (stable,) = doubled.attractors
    point = fixed_point(doubled.batches, np.array(stable.states).mean(axis=0))
    assert np.abs(np.array(stable.states) - point).max() > 1e-3
    assert not doubled.admit(Attractor("P(1;1)", 1, (tuple(point.tolist()),), (1.0,)))


def fixed_point(batches, state):
    """Of the one-turn map, by Newton's method with differences."""
    lift, h = np.array(batches.lift), 1e-7
    x = state - lift

    def image(y):
        ends = batches.run([y[0]], [y[1]], NOTHING, 1)
        return np.array([ends.gap[0], ends.rate[0]])

    for _ in range(30):
        steps = [(image(x + h * e) - image(x - h * e)) / (2.0 * h) for e in np.eye(2)]
        x = x - np.linalg.solve(np.column_stack(steps) - np.eye(2), image(x) - x)
    assert np.abs(image(x) - x).max() < 1e-10
    return x + lift


def ring(n, shift=0.0):
    angle = np.arange(n) * 2.399963
    return np.column_stack((np.cos(angle) + shift, np.sin(angle)))


def test_recurrence_of_records_and_their_boxes(finder):
    points = ring(8000)
    assert recurrence.is_recurrent(points)
    assert not recurrence.is_recurrent(points + np.linspace(0.0, 0.5, len(points))[:, None])
    late = np.where(np.arange(8000)[:, None] < 7600, points, points + 3.0)
    assert not recurrence.is_recurrent(late)  # a tenth of the second half is elsewhere
    assert recurrence.meet(ring(4000), ring(4000, 0.5))
    assert not recurrence.meet(ring(4000), ring(4000, 3.0))
    near = np.array(finder.regions[0].points[0])
    one, two = near + 0.1 * ring(4000), near + 0.1 * ring(4000, 3.0)
    boxes = recurrence.boxes_of({1: one, 2: two}, [finder.regions[0], None, None], 3)
    assert set(boxes.owner[boxes.grid.boxes(one)].tolist()) <= {0, 2}
    assert set(boxes.owner[boxes.grid.boxes(two)].tolist()) == {3}
    assert boxes.owner[boxes.grid.boxes(near[None, :])[0]] == 0
    tried = np.flatnonzero(boxes.owner == 3)
    stays = recurrence.stays_of(boxes, tried, np.full(len(tried), 2), np.full(len(tried), 7))
    assert stays[2] == 16 + 2 * 7  # twice the longest stay of a trial that went elsewhere


def test_rests_are_asked_once_and_what_no_ball_decides_is_undecided(chapter, monkeypatch):
    asked, real = [], after_rest_module.after_rest
    monkeypatch.setattr(rest_outcomes, "after_rest", lambda *a: asked.append(a[2]) or real(*a))
    whole, finder = basins(chapter, 358.25, settings(), BasinsQuestion(WINDOW))
    assert whole.undecided == 0
    assert len(asked) == len(set(asked)) >= 1
    assert len(finder.rests.states) <= 8
    unknown = after_rest_module.After(after_rest_module.UNKNOWN)
    monkeypatch.setattr(rest_outcomes, "after_rest", lambda *a: unknown)
    result, _ = basins(chapter, 358.25, settings(), BasinsQuestion(WINDOW))
    assert labels(whole)[:2] == labels(result) == ["P(1;2)", "P(3;3:3:2)"]
    assert labels(whole)[2].startswith("P(36;inf:")
    undecided = result.codes.ravel() == 0
    assert undecided.sum() == result.undecided > 20
    assert (whole.codes.ravel()[undecided] == 3).all()
    assert (whole.codes.ravel() == result.codes.ravel())[~undecided].all()
    assert result.turns[2] < 1000  # such cells are soon left


@pytest.mark.slow
@pytest.mark.parametrize(("rpm", "known", "cycle"), [(358.3, 2, "P(28;"), (362.0, 1, "P(230;")])
def test_cycles_through_rests_are_attractors(chapter, rpm, known, cycle):
    """At 358.3 rpm beside P(3;3:3:2), at 362 rpm instead of it."""
    result, _ = basins(chapter, rpm, settings(), BasinsQuestion(WINDOW.with_cells(6, 6)))
    assert labels(result)[:known] == ["P(1;2)", "P(3;3:3:2)"][:known]
    assert labels(result)[known].startswith(f"{cycle}inf:")
    assert len(labels(result)) == known + 1


@pytest.mark.parametrize("rpm", [523.62, 640.0])
def test_what_comes_to_a_rest_again_and_again_is_never_aperiodic(chapter, rpm):
    """However long it wanders in between: it is one cycle, here of thousands of turns."""
    result, finder = basins(chapter, rpm, settings(), BasinsQuestion(WINDOW.with_cells(6, 6)))
    assert labels(result) == []
    assert result.undecided == result.cells
    assert {end.kind for _, end in result.rests} == {after_rest_module.WANDERS}
    assert finder.rests.ends.count(FORGOTTEN) == len(finder.rests.ends)


def test_a_motion_that_ends_on_a_known_attractor_tells_nothing_new(finder):
    """Whatever is asked of it: an aperiodic attractor is not looked for on its way."""
    known = list(finder.attractors)
    for gap, rate in ((0.3, 0.1), (0.02, 0.0), (0.4, 0.9)):
        assert finder._recognise(gap, rate, 0) is False
    assert finder.attractors == known


def test_a_record_that_rests_is_no_aperiodic_attractor(chapter, monkeypatch):
    """At 640 rpm no orbit of 300 turns from rest comes to a rest, but longer ones do."""
    finder = AttractorFinder(CellBatches(chapter, 640.0, settings()), 100, aperiodic_turns=3000)
    monkeypatch.setattr(finder.batches, "run", unended(finder.batches))
    assert not finder._recognise(0.0, 0.0, 3)
    assert finder.attractors == []


def unended(batches):
    """`batches.run` that comes back to where it began: nothing is met on the way."""
    real = batches.run

    def run(gap, rate, targets, budget, mode=None, share=False):
        ends = real(gap, rate, NOTHING, 0, mode, share)
        return replace(ends, outcome=np.full(len(ends.gap), UNDECIDED))

    return run


def test_boxes_about_a_periodic_attractor_belong_to_nobody():
    """Box by box: those that its region touches, where gaps and rates are of other sizes."""
    random = np.random.default_rng(7)
    cloud = random.uniform((0.0, -3.0), (0.4, 5.0), (60_000, 2))  # it visits every box inside
    region = CaptureRegion(
        points=np.array([[0.31, -1.9], [0.05, 4.0]]), symbols=(1, 1), shrink=0.5, radius=1.0,
        forms=np.array([[900.0, 0.0, 4.0], [1600.0, 0.0, 1.0]]), rho=0.5, returns=True,
    )  # fmt: skip
    halves = np.array([[1.0 / 30.0, 0.5], [1.0 / 40.0, 1.0]])
    boxes = recurrence.boxes_of({0: cloud}, [None, region], 2)
    grid = boxes.grid
    for box in range(grid.side * grid.side):
        row, column = divmod(box, grid.side)
        low = np.array([grid.gap + column / grid.per_gap, grid.rate + row / grid.per_rate])
        high = low + np.array([1.0 / grid.per_gap, 1.0 / grid.per_rate])
        touched = any(
            np.all(high > point - half) and np.all(low < point + half)
            for point, half in zip(region.points, halves, strict=True)
        )
        inside = 2 <= row < grid.side - 2 and 2 <= column < grid.side - 2
        if touched:
            assert boxes.owner[box] == 0
        elif inside:
            assert boxes.owner[box] == 1


def test_a_block_that_fails_leaves_its_cells_where_they_began(chapter, monkeypatch):
    """The other blocks are followed; the fault is told."""
    batches = CellBatches(chapter, 358.5, settings(), block=2)
    followed = cell_batches._Task._followed

    def fails_once(self, gaps, rates, modes):
        if gaps[0] == 0.25:
            raise ZeroDivisionError
        return followed(self, gaps, rates, modes)

    monkeypatch.setattr(cell_batches._Task, "_followed", fails_once)
    ends = batches.run([0.5, 0.125, 0.25, 0.375, 0.75], [0.0, 1.0, 2.0, 3.0, 4.0], NOTHING, 3)
    failed = ends.outcome == cell_batches.FAILED
    assert failed.tolist() == [False, False, True, True, False]
    assert (ends.gap[2:4].tolist(), ends.rate[2:4].tolist()) == ([0.25, 0.375], [2.0, 3.0])
    assert ends.turns.tolist() == [3, 3, 0, 0, 3]
    assert (ends.outcome[~failed] == UNDECIDED).all()
    assert len(batches.faults) == 1


@pytest.mark.parametrize(
    ("is_known", "region", "regions", "is_taken"),
    [
        (True, "region", ["old", "new"], False),
        (False, None, ["old", "new"], False),  # it repels
        (False, "region", None, False),  # it cannot be parted from another
        (False, "region", ["old", "new"], True),
    ],
)
def test_an_attractor_is_taken_up_where_its_region_is_apart(
    monkeypatch, is_known, region, regions, is_taken
):
    found = AttractorFinder.__new__(AttractorFinder)
    found.batches, found.regions, found.attractors = "batches", ["old"], ["known"]
    rebuilt = []
    found._rebuild = lambda: rebuilt.append(list(found.regions))
    monkeypatch.setattr(attractor_finder, "region_of", lambda batches, one: region)
    monkeypatch.setattr(attractor_finder, "parted", lambda others, one: regions)
    attractor = SimpleNamespace(is_same=lambda known: is_known)
    assert found.admit(attractor) is is_taken
    assert found.attractors == ["known", *([attractor] if is_taken else [])]
    assert found.regions == (regions if is_taken else ["old"])
    assert rebuilt == [regions] * is_taken


@pytest.mark.parametrize("met", [True, False])
def test_a_record_that_is_not_taken_up_leaves_all_as_it_was(monkeypatch, met):
    """Where a stay in its boxes would have to be too long; joined to another record, or alone."""
    periodic = Attractor.aperiodic_of(np.array([[9.0, 9.0]]))
    known = Attractor.aperiodic_of(np.array([[1.0, 2.0], [3.0, 4.0]]))
    for stay, taken in ((recurrence.MOST_STAY, True), (recurrence.MOST_STAY + 1, False)):
        monkeypatch.setattr(recurrence, "meet", lambda points, _: met and points[0, 0] < 5.0)
        finder = SimpleNamespace(
            batches=SimpleNamespace(lift=(0.25, 0.5)), attractors=[periodic, known],
            regions=["a region", None], boxes="boxes", targets="targets",
        )  # fmt: skip

        def rebuild(finder=finder, stay=stay):
            finder.boxes, finder.targets = "new", "new"
            return [1, stay, 1][: len(finder.attractors)]

        finder._rebuild = rebuild
        attractors, regions = finder.attractors, finder.regions
        before = list(attractors), list(regions), "boxes", "targets"
        assert AttractorFinder.take_up(finder, np.array([[5.0, 6.0]])) is taken
        after = finder.attractors, finder.regions, finder.boxes, finder.targets
        if not taken:
            assert after == before
        elif met:
            assert finder.attractors[1].points.tolist() == [[1.0, 2.0], [3.0, 4.0], [5.25, 6.5]]
            assert finder.regions == ["a region", None]
        else:
            assert finder.attractors[2].points.tolist() == [[5.25, 6.5]]
            assert finder.regions == ["a region", None, None]


@pytest.mark.parametrize(("symbols", "runs"), [((2, 1), 1), ((1, 2), len(DIFFERENCES))])
def test_maps_of_turns_are_taken_with_the_largest_step_that_keeps_their_impacts(symbols, runs):
    """The first point's turn has two impacts and the second one's has one, whatever the step; a
    linear map has the same differences with each of them."""
    points = np.array([[0.5, 1.0], [0.25, -2.0]])
    slopes = np.array([[0.5, 0.25], [-1.0, 2.0]])
    steps = []

    def run(gap, rate, nothing, turns):
        assert (nothing, turns) == (NOTHING, 1)
        steps.append(float(gap[0] - gap[1]))
        ends = slopes @ np.array([gap, rate])
        return SimpleNamespace(gap=ends[0], rate=ends[1], symbol=np.array([2] * 4 + [1] * 4))

    maps = _turn_maps(SimpleNamespace(run=run), points, symbols, 1.0)
    assert len(steps) == runs
    assert steps == sorted(steps, reverse=True)
    assert maps == pytest.approx(np.array([slopes, slopes]), rel=1e-4)


def test_undecided_starts_of_every_chunk_are_resolved_in_their_places():
    """Three chunks of two starts, the last of one; the outcome is the start's gap, the turns ten
    times that, and two starts are undecided."""
    gaps = np.array([3.0, 5.0, 2.0, 7.0, 4.0])
    resolved, told = [], []

    def run(gap, rate, budget, share):
        outcome = np.where(np.isin(gap, (5.0, 7.0)), UNDECIDED, gap).astype(np.int16)
        states = np.column_stack((gap, rate, np.ones(len(gap))))
        return SimpleNamespace(gap=gap, outcome=outcome, turns=10 * gap.astype(np.int32),
                               states=lambda: states)  # fmt: skip

    def resolve(cells, states, budget, outcome, turns):
        resolved.append((cells.tolist(), states.tolist(), budget))
        outcome[cells], turns[cells] = 1, 99

    batches = SimpleNamespace(states=lambda q, v: (q, -v), work=SimpleNamespace(shard=None))
    finder = SimpleNamespace(chunk=2, batches=batches, _run=run, _resolve=resolve)
    outcome, turns = AttractorFinder._settle(finder, gaps, gaps / 2.0, 50, told.append)
    assert resolved == [([1, 3], [[5.0, -2.5, 1.0], [7.0, -3.5, 1.0]], 50)]
    assert outcome.tolist() == [3, 1, 2, 1, 4]
    assert turns.tolist() == [30, 99, 20, 99, 40]
    assert told == [2, 2, 1]


def test_saddles_stand_in_the_order_of_the_motions_that_were_led_to_them(monkeypatch):
    """Six starts on boundaries: one is led to a, two to b, two to c and one to none; d is found
    beside b, and nothing is led to it."""
    ends = iter(["a", "b", "c", "nowhere", "c", "b"])
    found = {"a": ["a"], "b": ["b", "d"], "c": ["c"], "nowhere": []}
    reached = []

    def record(system, rpm, settings, start):
        reached.append(next(ends))
        return reached[-1]

    def nearest(orbits, states, size):
        return orbits.index(reached[-1]) if reached[-1] in orbits else None

    monkeypatch.setattr(saddles, "Orbit", record)
    monkeypatch.setattr(saddles, "states_of", lambda _: np.array([[0.0, 1.0], [2.0, 4.0]]))
    monkeypatch.setattr(saddles, "_nearest", nearest)
    monkeypatch.setattr(saddles, "find_saddles", lambda system, rpm, at, size: found[at])
    monkeypatch.setattr(saddles, "_on_boundaries", lambda *_: np.zeros((6, 2)))
    batches = SimpleNamespace(system=None, rpm=700.0, settings=settings(), start=lambda *_: None,
                              states=lambda q, v: (q, v), record=lambda orbit: orbit)  # fmt: skip
    met = saddles.boundary_saddles(SimpleNamespace(batches=batches), None, None)
    assert [(one.orbit, one.led, one.tried) for one in met] == [
        ("b", 2, 6),
        ("c", 2, 6),
        ("a", 1, 6),
    ]
