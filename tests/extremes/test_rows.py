"""The table of extreme cases: one test per row, the rows `cam bench stability` runs."""

import pytest

import camcli
from camcli.analysis.bench.stability import OK, ROWS, measure
from camcli.api.bench import machines
from camcli.errors import Status
from tests.support.kernel_runs import run, system


@pytest.mark.parametrize("number", ROWS)
def test_row(number):
    outcome = measure(ROWS[number], machines())
    assert outcome.status == OK, outcome.observed


def test_every_numerical_row_is_there_once():
    assert list(ROWS) == [1, 2, 3, *range(5, 26)]
    assert all(row.case.startswith(f"{number}: ") for number, row in ROWS.items())


def test_a_spring_without_force_on_the_dwell_is_no_trouble():
    """c = 0 on the base, so force and acceleration of a landing there vanish together."""
    scene = camcli.load_scene(None, {"cam.offset": 0.4, "run.rpm": 300.0, "run.record": 50})
    cost = camcli.simulate(scene).values.cost
    assert cost.evaluations < 10 * cost.impacts


@pytest.mark.parametrize("q", [0.1, 0.4 - 0.3])
def test_the_height_of_the_dwell_as_written_is_on_the_cam(q):
    """Row 18 too: 0.4 m - 0.3 m is an ulp more than 0.1 m."""
    scene = camcli.load_scene(None, {"run.start.q": q, "run.start.v": 0.0, "run.rpm": 100.0})
    assert not len(camcli.simulate(scene).tables["events"]["t_s"])


def test_a_damped_follower_without_force_is_thrown_off_by_the_lobe():
    """Row 9 from rest on the cam, where damping brakes it: no impact is invented."""
    tape = run(1.0, system(stiffness=0.0, damping=1.0), record=50)
    assert tape.status in (Status.OK, Status.NO_RETURN)
    assert len(tape.kind) < 100
