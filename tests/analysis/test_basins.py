"""Basins: which attractors there are, and every cell against a long plain simulation."""

import numpy as np
import pytest

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.basins.measures import fractions
from camcli.analysis.basins.study import BasinsQuestion, Branches, basins, study
from camcli.analysis.basins.window import Window
from camcli.analysis.classify import classify_at
from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import label
from camcli.analysis.orbits.identify import departures
from camcli.parallel import Work
from camcli.system import omega_of
from tests.conftest import chapter_system, settings

WINDOW = Window((0.1, 0.9), (-50.0, 50.0), 40, 40)


def mapped(system, rpm, window=WINDOW, **more):
    return basins(system, rpm, settings(), BasinsQuestion(window, **more))[0]


def labels(result):
    return [attractor.label for attractor in result.attractors]


def test_fractions_agree_at_two_resolutions(chapter):
    coarse, fine = mapped(chapter, 358.5), mapped(chapter, 358.5, WINDOW.with_cells(70, 70))
    assert labels(coarse) == labels(fine) == ["P(1;2)", "P(3;3:3:2)"]
    for code in (1, 2):
        (a, da), (b, db) = coarse.fractions[code], fine.fractions[code]
        assert abs(a - b) <= 2.0 * (da + db)
        assert 0.0 < db < da
    assert coarse.undecided == fine.undecided == 0
    states = [np.array(r.attractors[1].states) for r in (coarse, fine)]
    assert np.abs(states[0] - states[1]).max() <= 1e-14


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [(739.35, ["P(2;1:1)"]), (190.0, ["P(1;inf)"]), (100.0, ["contact"]), (745.0, ["aperiodic"])],
)
def test_attractors_elsewhere(chapter, rpm, expected):
    result = mapped(chapter, rpm, WINDOW.with_cells(12, 12))
    assert labels(result) == expected
    assert result.undecided == 0
    assert not result.troubled


@pytest.mark.slow
def test_two_aperiodic_attractors_are_told_apart():
    """A damped machine; the second one's basin is so small that only cells find it."""
    machine = chapter_system(restitution=0.6, damping=40.0, gravity=9.81)
    window = Window((0.05, 1.5), (-30.0, 30.0), 16, 16)
    result = mapped(machine, 752.09, window, budget=500)
    assert labels(result) == ["aperiodic", "aperiodic"]
    low, high = (attractor.points[:, 0] for attractor in result.attractors)
    assert low.max() < 0.5 < 0.7 < high.min()
    assert result.fractions[2][0] == pytest.approx(0.0167, abs=1e-3)
    assert result.undecided == 0


def plain_label(system, rpm, q, v, after_rests, turns=3000):
    """Of a long plain simulation; of what comes back to a rest for ever, the label classify finds.

    There doubles forget all between two rests, and which cycle they close is rounding. All motions
    are one after a rest, so the label is asked for once per departure, kept in `after_rests`.
    """
    tape = Orbit(system, rpm, settings(turns, 200, q=q, v=v)).run()
    leaves = departures(tape)
    if not leaves:
        return label(tape)
    theta = round(leaves[0][1], 9)
    if theta not in after_rests:
        after_rests[theta] = classify_at(system, rpm, settings(600, 400, q=q, v=v)).label
    return after_rests[theta]


@pytest.mark.slow
@pytest.mark.parametrize("rpm", [358.0, 700.0])
def test_every_cell_agrees_with_a_long_plain_simulation(chapter, rpm):
    window = WINDOW.with_cells(8, 8)
    result = mapped(chapter, rpm, window)
    names = np.array(["undecided", *labels(result)])
    q, v = window.centres(np.arange(window.count))
    starts, after_rests = zip(q.tolist(), v.tolist(), strict=True), {}
    expected = [plain_label(chapter, rpm, *start, after_rests) for start in starts]
    assert names[result.codes.ravel()].tolist() == expected
    assert len(set(expected)) == len(result.attractors)


def settled(system, q, v, batches, **more):
    finder = AttractorFinder(batches, 4000, **more)
    finder.look_around(WINDOW)
    outcome, turns = finder.settle(q, v)
    return finder.ranks()[np.maximum(outcome, 0)].tolist(), turns.tolist(), finder


@pytest.mark.parametrize("rpm", [358.5, 745.0])
def test_neither_order_nor_threads_nor_blocks_change_a_cell(chapter, rpm):
    q, v = WINDOW.with_cells(20, 10).centres(np.arange(200))
    usual = CellBatches(chapter, rpm, settings(), Work(1))
    codes, turns, finder = settled(chapter, q, v, usual)
    shuffled = np.random.default_rng(1).permutation(len(q))
    small = CellBatches(chapter, rpm, settings(), Work(2), block=37)
    others = settled(chapter, q[shuffled], v[shuffled], small, chunk=90)
    assert [codes[k] for k in shuffled] == others[0]
    assert [turns[k] for k in shuffled] == others[1]
    assert [a.states for a in finder.attractors] == [a.states for a in others[2].attractors]


def test_attractors_found_by_cells_alone_are_the_same(chapter, monkeypatch):
    wanted = mapped(chapter, 358.5, WINDOW.with_cells(20, 20))
    monkeypatch.setattr(AttractorFinder, "look_around", lambda self, window: None)
    found = mapped(chapter, 358.5, WINDOW.with_cells(20, 20), budget=600)
    assert labels(found) == labels(wanted)
    assert found.codes.tolist() == wanted.codes.tolist()


def test_what_conserves_energy_has_no_attractor():
    result = mapped(chapter_system(restitution=1.0), 358.5, WINDOW.with_cells(8, 8), budget=50)
    assert labels(result) == []
    assert result.undecided == 64


def test_refined_basins_are_those_of_the_full_grid(chapter):
    window = WINDOW.with_cells(32, 32)
    refined = mapped(chapter, 358.5, window, refine=2)
    full = mapped(chapter, 358.5, window.halved(2))
    assert refined.window == full.window
    assert (refined.codes != full.codes).mean() < 5e-3
    assert refined.computed < 0.35 * full.cells
    assert abs(refined.fractions[1][0] - full.fractions[1][0]) < full.fractions[1][1]
    assert (refined.codes == full.codes)[refined.level == 2].all()  # cells of the full grid


@pytest.mark.slow
def test_numbers_of_attractors_stay_from_speed_to_speed(chapter):
    """P(1;2) is born above 355 rpm; a cycle of 26 turns becomes P(3), which doubles its period."""
    speeds = [355.0, 358.5, 360.0, 360.5]
    result = study(chapter, speeds, settings(), BasinsQuestion(WINDOW.with_cells(8, 8)))
    named = [
        dict(zip(s.branches, [a.label for a in s.attractors], strict=True)) for s in result.speeds
    ]
    assert [sorted(names) for names in named] == [[1], [1, 2], [1, 2], [1, 2]]
    assert [names.get(2) for names in named] == [None, "P(1;2)", "P(1;2)", "P(1;2)"]
    assert [names[1] for names in named[1:3]] == ["P(3;3:3:2)", "P(6;3:3:2:3:3:2)"]
    assert result.grids == ()
    assert all(speed.codes.size == 0 for speed in result.speeds)


def test_the_boundary_is_the_stable_manifold_of_the_saddle_found(chapter):
    """Beside it, along its unstable direction, starts land on different attractors."""
    asked = BasinsQuestion(WINDOW.with_cells(12, 12))
    (speed,) = study(chapter, [358.5], settings(), asked, saddles=True).speeds
    (saddle,) = speed.saddles
    orbit, (grows, shrinks) = saddle.orbit, saddle.orbit.multipliers
    assert (orbit.label, saddle.led) == ("P(1;2)", saddle.tried)
    assert grows.real > 1.0 > shrinks.real > 0.0
    assert grows.real * shrinks.real == pytest.approx(0.8**4, rel=1e-12)  # two impacts
    _, finder = basins(chapter, 358.5, settings(), asked)
    (q, w), omega = orbit.states[0], omega_of(358.5)
    ends = [finder.destination(q, (w + side) * omega).label for side in (-1e-6, 1e-6)]
    assert sorted(ends) == ["P(1;2)", "P(3;3:3:2)"]


def test_an_attractor_goes_on_the_branch_that_it_is_nearest_to_and_that_is_nearest_to_it():
    """Of one label: one between two branches goes on neither, where each of these has a nearer."""

    def at(gap, label="P(1;1)"):
        return Attractor(label, 1, ((gap, 0.0),))

    branches = Branches(last=[at(1.0), at(1.2), at(3.0, "P(1;2)"), at(4.0)])
    new = at(1.21), at(1.04), at(1.1), at(1.05, "P(1;2)"), at(3.9)
    assert branches._by_state(new) == {0: 1, 1: 0, 4: 3}
    assert branches._by_state((at(2.0),)) == {}  # as far as that it is another one
    assert Branches()._by_state(new) == {}


def test_shares_of_the_plane_are_listed_by_attractor_then_undecided_then_troubles():
    codes = np.array([[2, 1, 0, -2], [-1, -3, 1, 1]])
    assert list(fractions(codes, [1, 2])) == [1, 2, 0, -2, -3]


def test_states_and_counts_of_an_attractor_begin_where_its_label_does():
    """With the largest counts; where two turns are alike, with the smallest state."""
    states = (0.5, 0.0), (0.25, 1.0), (0.75, 2.0)
    found = Attractor.periodic_of("P(3;3:2:1)", states, (1.0, 3.0, 2.0))
    assert found.symbols == (3.0, 2.0, 1.0)
    assert found.states == (states[1], states[2], states[0])
    alike = Attractor.periodic_of("P(2;1:1)", states[:2], (1.0, 1.0))
    assert (alike.symbols, alike.states) == ((1.0, 1.0), (states[1], states[0]))
