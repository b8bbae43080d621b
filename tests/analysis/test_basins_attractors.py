"""Regions about attractors, recurrence, and attractors matched from speed to speed."""

from dataclasses import replace

import numpy as np
import pytest

from camcli.analysis.basins import recurrence
from camcli.analysis.basins.attractor import Attractor, begin_where_label_does, is_one, order
from camcli.analysis.basins.attractor_finder import Census, overlap
from camcli.analysis.basins.branches import Branches, distance
from camcli.analysis.basins.cell_batches import NOTHING, Crew
from camcli.analysis.basins.mapping import Question
from camcli.analysis.basins.region import _holds, rings, size_of
from camcli.analysis.basins.study import study
from camcli.analysis.basins.window import Window
from tests.conftest import settings

WINDOW = Window((0.1, 0.9), (-50.0, 50.0), 20, 20)


@pytest.fixture(scope="module")
def census(chapter):
    found = Census(Crew(chapter, 358.5, settings()), 4000)
    found.scout(WINDOW)
    return found


def test_starts_on_the_rim_of_every_region_come_back(census):
    for attractor, region in zip(census.attractors, census.regions, strict=True):
        assert region.returns
        starts, at = rings(region)
        assert size_of(region, at, *starts.T).max() == pytest.approx(1.0)
        ends = census.crew.run(*starts.T, NOTHING, 300 * attractor.turns)
        assert size_of(region, at, ends.gap, ends.rate).max() < 1e-12


def test_regions_are_as_wide_as_they_may_be(census):
    for region in census.regions:
        assert _holds(census.crew, region)
        assert not _holds(census.crew, region.scaled(1.25))


def test_the_multipliers_of_the_solver_are_those_of_the_region(census):
    for attractor, region in zip(census.attractors, census.regions, strict=True):
        rho = max(abs(z) for z in attractor.multipliers)
        assert region.rho == pytest.approx(rho, rel=1e-5)
        assert rho < region.shrink < 1.0


def test_no_regions_overlap(census):
    one, two = census.regions
    assert not overlap(one, two)
    assert overlap(one, one)
    assert overlap(one.scaled(30.0), two.scaled(30.0))


def test_a_known_orbit_is_not_admitted_twice(census):
    before = list(census.attractors)
    for known in before:
        turned = replace(known, states=known.states[1:] + known.states[:1])
        assert is_one(known, turned)
        assert not census._admit(turned)
    assert census.attractors == before


def test_an_orbit_that_repels_is_not_admitted(chapter):
    """The P(1;1) orbit near 739.35 rpm has period-doubled: it exists, but repels."""
    crew = Crew(chapter, 739.35, settings())
    census = Census(crew, 4000)
    census.scout(WINDOW)
    (stable,) = census.attractors
    middle = np.array(stable.states).mean(axis=0)
    point = newton(crew, middle)
    assert np.abs(np.array(stable.states) - point).max() > 1e-3
    assert not census._admit(Attractor("P(1;1)", 1, (tuple(point.tolist()),), (1.0,)))


def newton(crew, state):
    """Fixed point of the one-turn map by differences."""
    lift = np.array(crew.lift)
    x = state - lift

    def image(y):
        ends = crew.run([y[0]], [y[1]], NOTHING, 1)
        return np.array([ends.gap[0], ends.rate[0]])

    for _ in range(30):
        h = 1e-7
        steps = [(image(x + h * e) - image(x - h * e)) / (2.0 * h) for e in np.eye(2)]
        x = x - np.linalg.solve(np.column_stack(steps) - np.eye(2), image(x) - x)
    assert np.abs(image(x) - x).max() < 1e-10
    return x + lift


def test_states_begin_where_the_label_does():
    states, symbols = begin_where_label_does(((1, 1), (2, 2), (3, 3)), (3.0, 2.0, 3.0))
    assert symbols == (3.0, 3.0, 2.0)
    assert states == ((3, 3), (1, 1), (2, 2))
    same, _ = begin_where_label_does(((5, 0), (4, 0)), (1.0, 1.0))
    assert same == ((4, 0), (5, 0))


def test_order_is_by_label_then_state():
    made = [
        Attractor("aperiodic", 0, ((0.0, 0.0),)),
        Attractor("P(2;2:1)", 2, ((0.1, 0.0), (0.2, 0.0)), (2.0, 1.0)),
        Attractor("P(1;2)", 1, ((0.3, 0.0),), (2.0,)),
        Attractor("P(1;2)", 1, ((0.2, 0.0),), (2.0,)),
        Attractor("contact", 1, ((0.1, 0.0),), (0.0,)),
    ]
    ranked = sorted(made, key=order)
    assert [a.label for a in ranked] == ["contact", "P(1;2)", "P(1;2)", "P(2;2:1)", "aperiodic"]
    assert ranked[1].states[0][0] == 0.2


def ring(n, shift=0.0):
    angle = np.arange(n) * 2.399963
    return np.column_stack((np.cos(angle) + shift, np.sin(angle)))


def test_a_record_that_stays_is_recurrent_and_one_that_drifts_is_not():
    points = ring(8000)
    assert recurrence.is_recurrent(points)
    drift = points + np.linspace(0.0, 0.5, len(points))[:, None]
    assert not recurrence.is_recurrent(drift)


def test_records_are_one_where_their_boxes_meet():
    assert recurrence.meet(ring(4000), ring(4000, 0.5))
    assert not recurrence.meet(ring(4000), ring(4000, 3.0))


def test_boxes_know_their_owner_and_keep_off_periodic_regions(census):
    near = np.array(census.regions[0].points[0])
    one, two = near + 0.1 * ring(4000), near + 0.1 * ring(4000, 3.0)
    boxes = recurrence.boxes_of({1: one, 2: two}, [census.regions[0], None, None], 3)
    assert set(boxes.owner[boxes.grid.boxes(one)].tolist()) <= {0, 2}
    assert set(boxes.owner[boxes.grid.boxes(two)].tolist()) == {3}
    assert boxes.owner[boxes.grid.boxes(near[None, :])[0]] == 0


def test_branches_keep_their_numbers(chapter):
    """P(1;2) is born at some 355 rpm, P(3) doubles its period: the numbers stay."""
    speeds = [354.0, 358.0, 359.5, 362.0]
    result = study(chapter, speeds, settings(), Question(WINDOW))
    named = [
        dict(zip(s.branches, [a.label for a in s.attractors], strict=True)) for s in result.speeds
    ]
    assert [sorted(names) for names in named] == [[1], [1, 2], [1, 2], [1, 2]]
    assert [names.get(2) for names in named] == [None, "P(1;2)", "P(1;2)", "P(1;2)"]
    assert named[1][1] == "P(3;3:3:2)"
    assert result.grid is None


def test_a_branch_that_was_gone_comes_back_by_its_state():
    def orbit(q, label="P(1;1)"):
        return Attractor(label, 1, ((q, 0.0),), (1.0,))

    class Gone:
        attractors: tuple = ()

        def destination(self, q, v):
            return None

        class crew:  # noqa: N801
            omega = 1.0

    branches = Branches()
    assert branches.number((orbit(1.0), orbit(3.0)), Gone()) == (1, 2)
    assert branches.number((orbit(3.1),), Gone()) == (2,)
    assert branches.number((orbit(1.1), orbit(3.2), orbit(9.0)), Gone()) == (1, 2, 3)
    assert branches.number((orbit(3.2), orbit(3.25), orbit(9.0)), Gone()) == (2, 4, 3)
    assert branches.number((orbit(1.1, "P(1;2)"),), Gone()) == (5,)
    assert distance(orbit(1.0), orbit(2.0)) == 0.5
