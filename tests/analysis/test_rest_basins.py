"""Rests on the way of cells: asked once, told apart, and never an attractor by accident."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import chapter_system, settings

from camcli.analysis import after_rest as after
from camcli.analysis.basins import rests as rests_module
from camcli.analysis.basins.attractor_finder import Census
from camcli.analysis.basins.cell_batches import Crew
from camcli.analysis.basins.decided_rests import chaos
from camcli.analysis.basins.mapping import Question, basins
from camcli.analysis.basins.rests import departure
from camcli.analysis.basins.window import Window
from camcli.kernel.cells import FORGOTTEN, GOES_ON, NEW_REST, UNDECIDED

WINDOW = Window((0.1, 0.9), (-50.0, 50.0), 20, 20)
CORNER_B = 2.621124501166232  # rad


def labels(result):
    return [attractor.label for attractor in result.attractors]


def test_a_departure_is_followed_once(chapter, monkeypatch):
    asked = []
    real = after.after_rest
    monkeypatch.setattr(after, "after_rest", lambda *words: asked.append(words[2]) or real(*words))
    result, census = basins(chapter, 358.0, settings(), Question(WINDOW))
    assert result.undecided == 0
    assert len(asked) == len(set(asked)) >= 1
    assert len(census.rests.states) <= 8


def test_without_the_functions_of_the_cam_such_cells_are_undecided_and_soon_left(chapter):
    bare = replace(chapter, shape=None)
    whole, _ = basins(chapter, 358.0, settings(), Question(WINDOW))
    result, census = basins(bare, 358.0, settings(), Question(WINDOW))
    assert labels(result) == ["P(1;2)", "P(3;3:3:2)"]
    assert result.undecided > 20
    undecided = result.codes.ravel() == 0
    assert result.turns[undecided].max() < 1000
    assert (whole.codes.ravel()[undecided] == 2).all()
    assert (whole.codes.ravel() == result.codes.ravel())[~undecided].all()
    assert census.budget == 4000


def test_a_cycle_of_the_machine_is_an_attractor(chapter):
    result, _ = basins(chapter, 358.3, settings(), Question(WINDOW))
    assert labels(result)[:2] == ["P(1;2)", "P(3;3:3:2)"]
    assert labels(result)[2].startswith("P(28;inf:")
    assert result.undecided == 0


def test_chaos_through_rests_is_aperiodic(chapter):
    """At 362 rpm excursions from a rest differ, and none settles."""
    result, census = basins(chapter, 362.0, settings(), Question(WINDOW))
    assert labels(result) == ["P(1;2)", "aperiodic"]
    assert result.undecided == 0
    assert len(census.attractors[census.ranks().tolist().index(2)].points) > 10_000


def test_excursions_that_settle_are_no_attractor(chapter):
    """At 358.0 rpm most starts beside the rest come to P(3;3:3:2): chaos, but a transient."""
    census = Census(Crew(chapter, 358.0, settings()), 4000)
    census.scout(WINDOW)
    state = rests_module.exact(census.crew, 0.0, 0.0, 3, 0, 3)
    gap, rate = np.array([state.strobe_q[1], state.strobe_w[1]]) - np.array(census.crew.lift)
    before = list(census.attractors)
    assert chaos(census, (float(gap), float(rate), 0)) == FORGOTTEN
    assert census.attractors == before


def test_doubles_are_believed_where_they_remember(chapter):
    crew = Crew(chapter, 190.0, settings())
    census = Census(crew, 4000)
    census.scout(WINDOW)
    assert set(census.rests.ends) == {GOES_ON}
    free = Census(Crew(chapter_system(restitution=1.0), 358.0, settings()), 10)
    assert free.targets.rests == -1


@pytest.mark.parametrize("rpm", [190.0, 358.0])
def test_the_departure_of_a_start(chapter, rpm):
    crew = Crew(chapter, rpm, settings())
    census = Census(crew, 400)
    stops = census.targets
    ends = crew.run([0.0, 0.2], [0.0, -0.5], stops, 400)
    for k, (gap, rate, mode) in enumerate(((0.0, 0.0, 1), (0.2, -0.5, 0))):
        assert ends.outcome[k] in (NEW_REST, UNDECIDED)
        if ends.outcome[k] == NEW_REST:
            theta = departure(crew, gap, rate, mode, int(ends.turns[k]))
            assert theta in (pytest.approx(CORNER_B), pytest.approx(3.490658503988659))
    assert NEW_REST in ends.outcome
