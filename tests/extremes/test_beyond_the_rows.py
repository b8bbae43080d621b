"""Extreme cases beside the rows of `cam bench stability`: more speeds, starts, bounded cost."""

import pytest

import camcli
from camcli.analysis.integrate import Orbit, Settings
from camcli.analysis.simulate import simulate
from camcli.errors import Status
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.kernel.helpers import events, run, settings, system


@pytest.mark.parametrize("damping", [0.0, 1.0])
@pytest.mark.parametrize("rpm", [1.0, 500.0])
def test_rows_9_and_24_no_force_holds_the_follower(rpm, damping):
    """k = g = preload = 0 from rest on the dwell: the lobe throws it off, once and for good."""
    tape = run(rpm, system(stiffness=0.0, damping=damping), record=50)
    assert len(events(tape)) < 100
    assert tape.status in ((Status.NO_RETURN,) if damping == 0.0 else (Status.OK, Status.NO_RETURN))


def test_a_spring_without_force_on_the_dwell_is_no_trouble():
    """c = 0 on the base, so force and acceleration of a landing there vanish together."""
    scene = load_scene(None, ["cam.offset=0.4"])
    machine = System.build(Follower(**scene.follower.model_dump()), scene.cam)
    tape = Orbit(machine, 300.0, Settings(5, 50, 1e-9, 10**6)).run()
    assert tape.status == Status.OK
    assert tape.cost.evaluations < 10 * tape.cost.impacts


@pytest.mark.parametrize("q", [0.1, 0.4 - 0.3])
def test_row_18_the_height_of_the_dwell_as_written_is_on_the_cam(q):
    """0.4 m - 0.3 m is an ulp more than 0.1 m."""
    scene = load_scene(None, {"run.start.q": q, "run.start.v": 0.0, "run.rpm": 100.0})
    assert not simulate(system(), 100.0, settings(1, q=q, v=0.0), 10).events
    assert not len(camcli.simulate(scene).tables["events"]["t_s"])
