"""Certificates along numbers of a cam: confirmed as they are, refused where anything is changed."""

import json
from copy import deepcopy
from types import SimpleNamespace

import pytest
from flint import arb, ctx

import camcli
from camcli import check
from camcli.scene import load_scene
from tests.support.refusals import reasons

pytestmark = pytest.mark.slow

OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {"kind": "oscillator", "damping": 0.1, "amplitude": 1, "frequency": 1, "clearance": 1},
}
LAW = {
    "follower": {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8},
    "cam": {
        "kind": "law",
        "base": 0.1,
        "lift": 0.15,
        "rise": {"start_deg": 90, "length_deg": 70, "law": "cycloidal"},
        "top_dwell_deg": 40,
        "fall": {"length_deg": 70, "law": "cycloidal"},
    },
}


def certificate(scene, key, low, high, folder, **more) -> dict:
    """proof.json of a branch in a number of the cam."""
    axis = {"key": key, "start": low, "stop": high, "num": 3}
    few = {"orbits.starts": 0, "orbits.branches": 0, "orbits.label": "P(1;1)"}
    few |= {"orbits.stability": "stable", **{k.replace("__", "."): v for k, v in more.items()}}
    camcli.orbits(load_scene(scene, {"orbits.vary": [axis], **few}), prove=True).save(
        folder, plot=False
    )
    return json.loads((folder / "proof.json").read_text())


@pytest.fixture(scope="module")
def amplitude(tmp_path_factory):
    """An oscillator along its amplitude."""
    folder = tmp_path_factory.mktemp("amplitude")
    content = certificate(OSCILLATOR, "cam.amplitude", 0.97, 1.03, folder)
    return {**content, "statements": [s for s in content["statements"] if s["kind"] == "branch"]}


def test_a_branch_in_the_amplitude_is_confirmed(amplitude, checked):
    code, text = checked(amplitude)
    assert code == 0
    assert "P(1;1) exists and is stable for all cam.amplitude between 0.96999" in text
    (one,) = amplitude["statements"]
    assert one["parameter"] == "cam.amplitude"
    assert one["constants"]["rpm"] is None


def test_the_number_that_varies_may_have_any_value_in_the_file(amplitude, checked):
    content = deepcopy(amplitude)
    content["cam"]["numbers"]["amplitude"] = "0.5"
    assert checked(content)[0] == 0


CHANGES = {
    "another number of the cam": (("cam", "numbers", "clearance"), "1.0001"),
    "the frequency, and so the speed": (("cam", "numbers", "frequency"), "1.0001"),
    "a damping that is not the follower's": (("cam", "numbers", "damping"), "0.1001"),
    "another parameter": (("statements", 0, "parameter"), "cam.clearance"),
    "a parameter of another kind of cam": (("statements", 0, "parameter"), "cam.nose_radius"),
    "a parameter that is none": (("statements", 0, "parameter"), "cam.kind"),
    "a constant": (("statements", 0, "constants", "restitution"), "0.81"),
    "a speed": (("statements", 0, "constants", "rpm"), "9.5"),
    "a mass left open": (("statements", 0, "constants", "mass"), None),
    "a lower end": (("statements", 0, "low"), ["0.9", "0.9"]),
    "the other stability": (("statements", 0, "stable"), False),
    "a box in the wrong place": (("statements", 0, "boxes", 0, "middle", 2), "1.02"),
    "a box of no error": (("statements", 0, "boxes", 0, "error"), ["0", "0", "0"]),
    "a box that does not lean": (("statements", 0, "boxes", 0, "tangent"), ["0", "0", "1"]),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_is_refused(name, amplitude, checked):
    path, value = CHANGES[name]
    content = deepcopy(amplitude)
    place = content
    for step in path[:-1]:
        place = place[step]
    assert place[path[-1]] != value
    place[path[-1]] = value
    code, text = checked(content)
    assert code in (1, 2), text


@pytest.mark.parametrize(("more", "steps"), [("", False), (" + (amplitude - 1)/10000000000", True)])
def test_a_cam_without_a_step_at_one_value_only_is_refused(more, steps, amplitude, monkeypatch):
    """At the amplitude 1 of the file both halves of the turn meet, at no other one."""
    monkeypatch.setattr(ctx, "prec", check.BITS)
    content = deepcopy(amplitude["cam"])
    (whole,) = content["stretches"]
    raised = {**whole, "polynomial": [whole["polynomial"][0] + more]}
    content["stretches"] = [{**whole, "end": "pi"}, raised]
    cam = check.cam_of(content, "cam")
    orbit = SimpleNamespace(cam=cam, parameters=("cam.amplitude",), values=list)
    box = SimpleNamespace(hull=[arb(1, 0.01)])
    if steps:
        with pytest.raises(check.RefusedError, match=r"^the cam may have a step$"):
            check.without_steps(orbit, box)
    else:
        check.without_steps(orbit, box)


@pytest.mark.parametrize("frequency", ["0", "-1", "-1e-300"])
def test_an_oscillator_turns_forwards(frequency, amplitude, checked):
    """A frequency that is zero or negative is refused for that, whatever else is wrong then."""
    content = deepcopy(amplitude)
    content["cam"]["numbers"]["frequency"] = frequency
    code, text = checked(content)
    assert code == 1
    assert "the frequency is not positive" in reasons(text)


@pytest.mark.ci
def test_the_mass_of_an_oscillator_is_the_follower_s_too(checked, tmp_path):
    content = certificate(OSCILLATOR, "cam.mass", 0.998, 1.002, tmp_path / "out")
    branch = next(one for one in content["statements"] if one["kind"] == "branch")
    assert branch["constants"]["mass"] is None
    assert checked(content)[0] == 0
    branch["constants"]["mass"] = "1"
    assert checked(content)[0] == 1


@pytest.mark.ci
def test_a_number_without_a_statement_is_named(checked, tmp_path):
    """The angle of a law; and a mass where the damping, a share of its root, goes with it."""
    content = certificate(LAW, "cam.rise.length_deg", 69.5, 70.5, tmp_path / "a", run__rpm=700.0)
    assert content["uncovered"] == ["branch of P(1;1) from 69.5 to 70.5"]
    cam = {**OSCILLATOR["cam"], "damping_ratio": 0.05}
    del cam["damping"]
    content = certificate({**OSCILLATOR, "cam": cam}, "cam.mass", 0.998, 1.002, tmp_path / "b")
    assert content["uncovered"] == ["branch of P(1;1) from 0.998 to 1.002"]


@pytest.mark.ci
@pytest.mark.parametrize("key", ["cam.lift", "cam.lash"])
def test_a_branch_over_a_number_of_a_cam_with_lash_is_proved_without_certificate(key, tmp_path):
    """The corners of the seat move with the number; in a certificate they are fixed numbers."""
    scene = {**LAW, "cam": {**LAW["cam"], "lash": 0.01}}
    home = scene["cam"][key.removeprefix("cam.")]
    axis = {"key": key, "start": 0.99 * home, "stop": 1.01 * home, "num": 2}
    few = {"orbits.starts": 0, "orbits.branches": 0, "orbits.label": "P(1;1)", "run.rpm": 700.0}
    result = camcli.orbits(load_scene(scene, {"orbits.vary": [axis], **few}), prove=True)
    points = [proof for points in result.values.proofs.points for proof in points]
    assert points
    assert {proof.step for proof in points} == {None}
    assert [one.failed_step for one in result.values.proofs.ranges] == [None]
    result.save(tmp_path, plot=False)
    content = json.loads((tmp_path / "proof.json").read_text())
    assert "branch" not in {one["kind"] for one in content["statements"]}
    assert any(text.startswith("branch of P(1;1)") for text in content["uncovered"])


@pytest.mark.ci
def test_events_and_branches_in_the_nose_radius_are_confirmed(checked, tmp_path):
    """A doubling, and a corner impact at a corner that moves with the circle."""
    content = certificate(
        None, "cam.nose_radius", 0.1455, 0.147, tmp_path / "out", run__rpm=738.0,
        orbits__branches=1, orbits__label=None, cam__nose_radius=0.1468,
    )  # fmt: skip
    code, text = checked(content)
    assert code == 0, text
    assert (
        "period-doubling of P(1;1), cam.nose_radius from 0.146591929351195139221694292264" in text
    )
    assert "corner-impact of P(2;1:1), cam.nose_radius from 0.14645980584255715102269361106" in text
    assert content["uncovered"] == []
    moved = deepcopy(content)
    moved["statements"] = [one for one in moved["statements"] if one["kind"] != "branch"]
    moved["cam"]["numbers"]["top_dwell_deg"] = "40.0000001"
    code, text = checked(moved)
    assert code == 1
    assert "\nconfirmed: corner-impact" not in text


@pytest.mark.ci
def test_the_lift_of_a_law_and_the_damping_of_an_oscillator_are_confirmed(checked, tmp_path):
    for scene, key, low, high, more in (
        (LAW, "cam.lift", 0.14, 0.16, {"run__rpm": 700.0}),
        (OSCILLATOR, "cam.damping", 0.08, 0.12, {}),
        (OSCILLATOR, "cam.frequency", 0.98, 1.02, {}),
        (None, "cam.top_dwell_deg", 38.0, 42.0, {"run__rpm": 700.0}),
    ):
        content = certificate(scene, key, low, high, tmp_path / key, **more)
        code, text = checked(content)
        assert code == 0, text
        assert f"for all {key} between" in text
