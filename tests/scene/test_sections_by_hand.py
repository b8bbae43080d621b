"""Sections of a scene: what they refuse, what they work out, and which key was probably meant."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace as Stub

import pytest
from pydantic import ValidationError

from camcli.errors import SceneError
from camcli.scene import load_scene
from camcli.scene.schema import (
    Axis,
    Contact,
    Orbits,
    Tolerance,
    _keys_like,
    _refuse_other_sections,
    _refuse_what_an_oscillator_follows_from,
    json_schema,
)

EVERY = ("follower", "cam", "run")
FOLLOWER = {"mass": 1.0, "stiffness": 1000.0, "restitution": 0.5}
OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {"kind": "oscillator", "frequency": 2.8, "clearance": 0.1, "damping_ratio": 0.2,
            "stiffness": 4.0},
}  # fmt: skip


def law(**changes) -> dict:
    motion = {"law": "cycloidal", "length_deg": 80.0}
    return {"kind": "law", "base": 0.0, "lift": 0.01, "rise": {**motion, "start_deg": 90.0},
            "fall": motion, **changes}  # fmt: skip


def refusal(*given, **named) -> str:
    with pytest.raises(SceneError) as caught:
        load_scene(*given, **named)
    (fault,) = caught.value.faults
    return f"{fault.path}: {fault.found}, {fault.expected}, {fault.cure}"


@pytest.mark.parametrize(
    ("key", "sections", "near"),
    [
        ("restitution", EVERY, ["follower.restitution"]),
        ("x.mass", EVERY, ["follower.mass"]),  # of the follower, where it is one of them
        ("mass", ("cam",), ["cam.mass"]),
        ("base_radius", EVERY, ["cam.base_radius"]),  # of several kinds of cam
        ("a.b.Lift", EVERY, ["cam.lift"]),
        ("x.MASS", EVERY, ["follower.mass"]),
        ("x.STIFNESS", EVERY, ["follower.stiffness"]),
        ("spring.RATE", EVERY, ["follower.stiffness"]),
        ("cam.resitution", EVERY, ["follower.restitution"]),
        ("spring.rate", EVERY, ["follower.stiffness"]),
        ("spring.seat_load", EVERY, ["follower.stiffness", "follower.preload"]),
        ("x.nose_load", ("follower",), ["follower.preload"]),  # the only one like it
        ("zzz", EVERY, []),
    ],
)
def test_which_key_of_the_machine_was_probably_meant(key, sections, near):
    assert _keys_like(key, sections) == near
    with pytest.raises(SceneError) as caught:
        _refuse_other_sections(key.replace("cam.", "x."), sections, "an.example")
    (fault,) = caught.value.faults
    assert fault.cure == (f"did you mean {' or '.join(near)}?" if near else "e.g. an.example")
    if sections == EVERY:
        assert fault.expected == "expected a number of follower, cam or run"
    for section in sections:
        assert _refuse_other_sections(f"{section}.zzz", sections, "") is None


def test_a_number_of_the_run_may_vary_but_has_no_tolerance():
    assert Axis(key="run.strobe_deg", start=1.0, stop=2.0).path == "run.strobe_deg"
    for key in ("rpm", "run.rpm"):
        data = {"key": key, "start": "600 crank", "stop": "800crank"}
        axis = Axis.model_validate(data)
        assert (axis.start, axis.stop, axis.path) == (300.0, 400.0, "run.rpm")
    with pytest.raises(ValidationError, match="number"):
        Axis.model_validate({**data, "key": "follower.mass"})
    assert Tolerance(key="cam.lift", percent=3.0).percent == 3.0
    with pytest.raises(ValidationError, match="found the key"):
        Tolerance(key="run.rpm", percent=3.0)


MASS = {"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 3}


def test_a_zoom_is_of_the_number_that_varies_first():
    zoom = [{"start": "1340 crank", "stop": "1360 crank"}]
    for vary in ([], [{"key": "run.rpm", "start": 660.0, "stop": 700.0}]):
        (found,) = load_scene(None, {"sweep.vary": vary, "sweep.zoom": zoom}).sweep.zoom
        assert (found.start, found.stop) == (670.0, 680.0)
    inside = [{"start": 1.2, "stop": 1.5}]
    (found,) = load_scene(None, {"sweep.vary": [MASS], "sweep.zoom": inside}).sweep.zoom
    assert found.stop == 1.5
    told = refusal(None, {"sweep.vary": [MASS], "sweep.zoom": [{"start": 670.0, "stop": 680.0}]})
    assert "found a zoom from 670 to 680, expected two ends within 1 to 2, and no map" in told
    axes = [MASS, {"key": "rpm", "start": 600.0, "stop": 700.0}]
    assert "and no map" in refusal(None, {"sweep.vary": axes, "sweep.zoom": inside})
    twice = [{**axes[1], "key": key} for key in ("rpm", "run.rpm")]
    assert "found the same name twice: 'run.rpm'" in refusal(None, {"sweep.vary": twice})


def test_ten_million_motions_are_classified_at_most():
    most = {"classify.starts": 99_999, "classify.rpm": {"start": 1.0, "stop": 2.0, "num": 100}}
    assert load_scene(None, most).classify.starts == 99_999
    for values, what in (
        ({"classify.rpm": {"start": 1.0, "stop": 2.0, "num": 101}}, "speed"),
        ({"classify.vary": [{**MASS, "num": 101}]}, "value"),
    ):
        told = refusal(None, {**most, **values})
        assert f"found 101 {what}s x 100000 starts, 10100000 motions" in told
        assert told.endswith(f"ask for fewer {what}s or starts")


def test_all_orbits_stand_alone_and_a_checker_has_something_to_check():
    every = {"impacts": 2, "turns": 1}
    for name, value in (("label", "P(1;1)"), ("curve", "fold"), ("simulated", 5), ("vary", [MASS])):
        with pytest.raises(ValidationError, match=f"found {name} beside all"):
            Orbits.model_validate({"all": every, name: value})
    for proof in ({"prove": True}, {"chaos": True}, {"all": every}):
        assert Orbits.model_validate({"checker": True, **proof}).checker
    with pytest.raises(ValidationError, match="found checker: true without prove"):
        Orbits(checker=True)


def test_words_of_switches_cranks_panels_and_faces():
    assert load_scene(None, ["sweep.lyapunov=YES", "sweep.explain=Off"]).sweep.lyapunov
    assert load_scene(None, {"run.crank": False, "run.rpm": "600 crank"}).run.crank
    told = refusal(None, {"plot.panels": ["zzz"]}, command="basins")
    assert "expected one of basins, fractions, attractors, choose some of these" in told
    told = refusal(None, {"simulate.base_radius": 0.1})
    assert told.startswith("simulate.base_radius: found it without profile_only")


RADIUS, WIDTH = {"follower_radius": 0.01}, {"width": 0.02}
NO_RADIUS = "with follower_radius 0.01, expected no radius: only a roller has one"
NO_WIDTH = "with width 0.02, expected no width"


@pytest.mark.parametrize(
    ("face", "alone", "with_radius", "with_width", "with_both"),
    [
        ("knife", "", NO_RADIUS, NO_WIDTH, NO_RADIUS),
        ("flat", "", NO_RADIUS, "", NO_RADIUS),
        ("roller", "without follower_radius", "", "without follower_radius", ""),
        (None, "neither face nor width", "neither face nor width", "", ""),
    ],
)
def test_which_sizes_go_with_a_face(face, alone, with_radius, with_width, with_both):
    for sizes, refused in ((dict[str, float](), alone), (RADIUS, with_radius),
                           (WIDTH, with_width), (RADIUS | WIDTH, with_both)):  # fmt: skip
        if refused:
            with pytest.raises(ValidationError, match=refused):
                Contact(face=face, **sizes)
        else:
            assert Contact(face=face, **sizes).model_dump(include={*sizes}) == sizes


def test_a_spring_is_two_loads_or_none_beside_the_follower_s_own_numbers():
    free = {"mass": 1.0, "restitution": 0.5}
    cam = law(base=0.1)
    plain = {"follower": FOLLOWER, "cam": cam}
    found = load_scene({**plain, "spring": {"rate": None, "mass": 0.03}})
    assert found.follower.mass == pytest.approx(1.01)
    found = load_scene({**plain, "spring": {"mass": 0.03, "in_follower": True}})
    assert found.follower.mass == 1.0
    loads = {"rate": 0.0, "preload": 5.0, "mass": None, "in_follower": False}
    found = load_scene({"follower": free, "cam": cam, "spring": loads})
    assert (found.follower.stiffness, found.follower.preload) == (0.0, 5.0)
    kept = {"rate": 2000.0, "seat_load": 5.0, "mass": 0.3, "in_follower": True, "solid_at": 0.5}
    found = load_scene({"follower": free, "cam": cam, "spring": kept})
    assert found.follower.mass == 1.0
    assert found.follower.preload == pytest.approx(5.0 - 2000.0 * 0.1)
    assert (found.spring.in_follower, found.spring.solid_at) == (True, 0.5)
    three = {"rate": 5.0, "preload": 3.0, "seat_load": 4.0}
    told = refusal({"follower": free, "cam": cam, "spring": three})
    assert told.startswith("spring: found rate, preload, seat_load, expected two of rate, preload")
    told = refusal({"follower": {**free, "preload": 1.0}, "cam": cam, "spring": kept})
    assert told.startswith("spring: found follower.preload beside loads of the spring")
    far = {"rate": 1e15, "seat_load": 5.0}  # a preload of 1e17 N
    told = refusal({"follower": free, "cam": law(base=100.0), "spring": far})
    assert "expected a spring that presses harder at 100 m than at 100 m" in told
    told = refusal({**plain, "follower": {**FOLLOWER, "stiffness": 0.0}, "spring": {"mass": 0.1}})
    assert told.startswith("spring.mass: found a mass of a spring, expected a stiffness above 0")


def test_a_lash_is_held_against_the_height_of_the_cam_below_zero_too():
    low = {"follower": FOLLOWER, "cam": law(base=-1.0, lash=5e-13)}
    assert "cam.lash: found 5e-13, which is lost in the rounding of the cam's heights" in refusal(
        low
    )
    assert load_scene({**low, "cam": law(base=-1.0, lash=2e-12)}).cam.lash == 2e-12
    assert load_scene({**low, "cam": law(lash=0.0)}).cam.lash == 0.0
    told = refusal({**low, "cam": law()}, {"follower.seat_restitution": 0.0})
    assert told.startswith("follower.seat_restitution: found 0.0 without cam.lash")


def test_an_oscillator_has_the_follower_and_the_speed_that_it_is():
    scene = load_scene(OSCILLATOR, {"sweep.rpm.num": 7})
    follower = scene.follower
    assert (follower.mass, follower.stiffness, follower.restitution) == (1.0, 4.0, 0.8)
    assert follower.damping == pytest.approx(2.0 * 0.2 * 2.0)
    rpm = 2.8 * 30.0 / pi
    for section in (scene.sweep, scene.detach, scene.orbits, scene.basins, scene.classify):
        assert section.rpm.start == section.rpm.stop == pytest.approx(rpm)
    assert scene.run.rpm == pytest.approx(rpm)
    for section, num in ((scene.sweep, 7), (scene.classify, 101)):
        (axis,) = section.vary
        assert (axis.key, axis.num) == ("cam.frequency", num)
        assert (axis.start, axis.stop) == pytest.approx((0.8 * 2.8, 1.2 * 2.8))
    assert scene.orbits.vary == scene.basins.vary == ()
    own = [{"key": "cam.clearance", "start": 0.1, "stop": 0.2}]
    (axis,) = load_scene(OSCILLATOR, {"sweep.vary": own}).sweep.vary
    assert axis.key == "cam.clearance"
    for path in ("cam.lash", "follower.seat_restitution"):
        assert refusal(OSCILLATOR, {path: 0.0}).startswith(f"{path}: found {path.split('.')[1]} b")
    assert "sweep.rpm: found a range of speeds" in refusal(OSCILLATOR, {"sweep.rpm.stop": 3.0})


@pytest.mark.parametrize(
    ("path", "refused"),
    [
        ("cam.damping", False), ("follower.restitution", False), ("run.strobe_deg", False),
        ("run.rpm", True), ("follower.mass", True),
    ],
)  # fmt: skip
def test_what_of_an_oscillator_may_vary(path, refused):
    axis = Stub(path=path, key=path)
    if refused:
        with pytest.raises(SceneError, match="expected a number of its cam, or follower"):
            _refuse_what_an_oscillator_follows_from(axis, "sweep")
    else:
        _refuse_what_an_oscillator_follows_from(axis, "sweep")


def test_the_schema_for_editors_takes_nothing_for_a_section_that_may_be_left_out():
    schema = json_schema()
    properties = schema["properties"]
    assert properties["follower"]["$ref"] == "#/$defs/Follower"
    assert properties["run"]["anyOf"] == [{"$ref": "#/$defs/Run"}, {"type": "null"}]
    assert "$ref" not in properties["run"]
    assert schema["description"] == "Everything a run depends on."
    assert "Examples" not in schema["$defs"]["LawCam"]["description"]
    assert schema["$schema"].endswith("2020-12/schema")
