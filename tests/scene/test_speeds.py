"""Speeds of a crank: `6000 crank` is 3000 rpm of the cam, wherever a speed stands."""

import json

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene, resolved
from camcli.scene.load import parse_rpm
from camcli.words.machine import crank_of
from camcli.words.speeds import of_both_shafts


@pytest.mark.parametrize(
    "text", ["6000crank", "6000 crank", " 6e3 rpm crank", "6000 rpm of the crank", "3000 cam", 3000]
)
def test_every_way_to_write_a_speed_is_the_same_speed(text):
    scene = load_scene(None, {"run.rpm": text, "detach.hold_to": text})
    assert (scene.run.rpm, scene.detach.hold_to) == (3000.0, 3000.0)
    assert scene.run.crank == ("crank" in str(text))
    assert crank_of(scene) == (2.0 if "crank" in str(text) else 0.0)


def test_every_speed_of_a_scene_may_be_one_of_the_crank():
    both = {"start": "5000 crank", "stop": "7000 crank"}
    changes = {name: {"rpm": both} for name in ("detach", "orbits", "classify", "basins")}
    changes["detach"] |= {"force_rpm": ["5000 crank", 3000], "hold_to": "7000crank"}
    changes["orbits"]["at"] = "6000 crank"
    changes["sweep"] = {"rpm": both, "zoom": [{"start": "6000 crank", "stop": 3100}]}
    scene = load_scene(None, changes)
    for name in changes:
        section = getattr(scene, name)
        assert (section.rpm.start, section.rpm.stop) == (2500.0, 3500.0), name
    assert scene.detach.force_rpm == (2500.0, 3000.0)
    assert (scene.detach.hold_to, scene.orbits.at) == (3500.0, 3000.0)
    assert (scene.sweep.zoom[0].start, scene.sweep.zoom[0].stop) == (3000.0, 3100.0)
    axis = {"key": "run.rpm", **both}
    mapped = load_scene(
        None, {"sweep.vary": [axis], "sweep.zoom": [{"start": "6000 crank", "stop": 3100}]}
    )
    assert (mapped.sweep.vary[0].start, mapped.sweep.zoom[0].start) == (2500.0, 3000.0)
    assert load_scene(json.loads(json.dumps(resolved(scene)))) == scene


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"follower.mass": "6 crank"}, "follower.mass"),
        (
            {"sweep.vary": [{"key": "follower.mass", "start": "1 crank", "stop": 2}]},
            "sweep.vary.0.start",
        ),
        ({"run.rpm": "3e9 crank"}, "run.rpm"),
        ({"run.rpm": "crank"}, "run.rpm"),
        ({"run.rpm": "true crank"}, "run.rpm"),
        ({"run.rpm": "null crank"}, "run.rpm"),
        ({"run.rpm": "6000 crnk"}, "run.rpm"),
        ({"run.crank": 2}, "run.crank"),
    ],
)  # fmt: skip
def test_what_is_no_speed_of_a_crank_is_one_fault(changes, path):
    with pytest.raises(SceneError) as error:
        load_scene(None, changes)
    assert [fault.path for fault in error.value.faults] == [path]


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("6000crank", "6000.0 crank"),
        ("5000:6000crank", ("5000.0 crank", "6000.0 crank")),
        ("5000crank:6000 crank", ("5000.0 crank", "6000.0 crank")),
        ("2500cam:6000crank", (2500.0, "6000.0 crank")),
        ("2500:3000 cam", (2500.0, 3000.0)),
    ],
)
def test_a_shaft_behind_a_range_is_that_of_both_ends(text, read):
    assert parse_rpm(text) == read


@pytest.mark.parametrize("text", ["5000crank:6000", "3e9crank", "1crank:2:3", "6000crnk"])
def test_a_range_that_names_one_shaft_only_in_front_is_refused(text):
    with pytest.raises(SceneError):
        parse_rpm(text)


def test_both_shafts_are_told():
    told = "2500 to 3000 rpm of the cam, 5000 to 6000 of the crank"
    assert of_both_shafts(2500.0, 3000.0) == told
    assert of_both_shafts(3000.0, 3000.0) == "3000 rpm of the cam, 6000 of the crank"


def test_the_command_line_takes_them_and_answers_in_both(cam, tmp_path):
    short = "--points 2 --no-plot --set run.transient=2 --set run.record=2"
    line = "detach -c configs/valve-train.yaml --set run.rpm=6200crank --hold-to 7000crank"
    done = cam(f"{line} --rpm 6400:6800crank {short}", code=0)
    assert (
        "note: detach.rpm is 3200 to 3400 rpm of the cam, 6400 to 6800 of the crank" in done.stderr
    )
    assert "At the working speed, 3100 rpm of the cam (6200 of the crank)" in done.stdout
    assert "To hold up to 3500 rpm of the cam (7000 of the crank)" in done.stdout
    scene = json.loads((tmp_path / "out/detach/run.json").read_text())["scene"]
    assert (scene["run"]["rpm"], scene["run"]["crank"]) == (3100.0, True)
    forces = {
        line.split(",")[0] for line in (tmp_path / "out/detach/force.csv").read_text().split()
    }
    assert "3500.0" in forces  # the speed of --hold-to
    done = cam(f"sweep -c configs/valve-train.yaml --vary run.rpm=6200:6300crank {short}", code=0)
    assert "note: run.rpm is 3100 to 3150 rpm of the cam, 6200 to 6300 of the crank" in done.stderr
    done = cam(f"simulate --rpm 1400crank {short.partition('--points 2')[2]}", code=0)
    assert done.stdout.startswith("At 700 rpm of the cam (1400 of the crank) contact is lost")


def test_the_speed_at_which_orbits_are_found_may_be_one_of_a_crank(cam):
    asked = "orbits --rpm 1400:1402crank --dry-run --at"
    cam(f"{asked} 1400crank", code=0)
    done = cam(f"{asked} 1500crank", code=2)
    assert "orbits.at: found rpm = 750.0" in done.stderr
    assert "--at: found '1500crnk'" in cam(f"{asked} 1500crnk", code=2).stderr
