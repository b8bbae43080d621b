"""Sources, overrides, defaults, the hash and the JSON Schema."""

import json
import os
from pathlib import Path

import numpy as np
import pydantic
import pytest
import yaml

from camcli.errors import SceneError
from camcli.scene import Scene, default_scene_path, json_schema, load_scene, resolved, scene_hash

ROOT = Path(__file__).parents[2]


def refused(source=None, overrides=(), options=None):
    with pytest.raises(SceneError) as caught:
        load_scene(source, overrides, options)
    return caught.value.faults


# -- sources -----------------------------------------------------------------------------------


def test_the_shipped_scene_names_every_key_with_its_default():
    shipped = load_scene()
    assert Scene(follower=shipped.follower, cam=shipped.cam) == shipped
    written = yaml.safe_load(default_scene_path().read_text())

    def keys(value):
        return {k: keys(v) for k, v in value.items()} if isinstance(value, dict) else None

    assert keys({**written, "cam": None}) == keys({**resolved(shipped), "cam": None})


def test_a_dict_is_a_scene_as_from_a_file():
    data = yaml.safe_load(default_scene_path().read_text())
    assert load_scene(data) == load_scene() == load_scene(str(default_scene_path()))
    data["run"]["rpm"], data["run"]["record"] = np.float64(650.0), np.int64(7)
    data["basins"]["q"] = np.array([0.25, 0.75])
    scene = load_scene(data)
    assert (scene.run.rpm, scene.run.record, scene.basins.q) == (650.0, 7, (0.25, 0.75))
    data["run"]["rpm"] = "650"
    (fault,) = refused(data)
    assert (fault.where, fault.path, fault.cure[:17]) == ("scene", "run.rpm", "remove the quotes")
    data["run"] = data
    assert "nested deeper" in refused(data)[0].found


def test_a_table_beside_a_dict_is_looked_for_in_the_folder():
    path = ROOT / "configs" / "lift-table.yaml"
    scene = load_scene(path)
    assert load_scene(resolved(scene), folder=path.parent) == scene
    assert "no such file" in refused(resolved(scene))[0].found


def test_empty_sections_take_their_defaults(load, valid):
    empty = "run:\nsimulate: ~\nsweep: {rpm: }\n"
    assert load(valid + empty) == load(valid) == load(valid + "run: {start: null}\n")


def test_what_a_person_means(load, valid):
    scene = load(valid + "run: {transient: 6e2, record: 400.0, chatter_tolerance: 1e-6}\n")
    assert (scene.run.transient, scene.run.record) == (600, 400)
    assert isinstance(scene.run.transient, int)
    assert scene.run.chatter_tolerance == 1e-6
    switches = load(valid + "sweep: {lyapunov: yes, explain: Off}\nbench: {quick: on}\n")
    assert (switches.sweep.lyapunov, switches.sweep.explain, switches.bench.quick) == (1, 0, 1)
    assert load(valid + "orbits: {label: no}\n").orbits.label == "no"
    for sweep in ("start: 760, stop: 660", "num: 1", "start: 700, stop: 700"):
        assert load(valid + f"sweep: {{rpm: {{{sweep}}}}}\n")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_what_is_no_file_is_refused_and_not_waited_for(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    for path, words in (
        (tmp_path / "none.yaml", "no such file"),
        (tmp_path, "found a folder"),
        ("/dev/null", "found a pipe, socket or device"),
        (tmp_path / "pipe", "found a pipe, socket or device"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read: file name too long"),
    ):
        assert refused(path)[0].found.startswith(words)
    usual = os.stat(__file__)
    monkeypatch.setattr(os, "stat", lambda *_, **__: usual)  # it became a pipe since
    assert refused(tmp_path / "pipe")[0].found == "found nothing in this file"


# -- overrides ---------------------------------------------------------------------------------


def test_options_beat_overrides_which_beat_the_file(load, valid):
    text = valid + "run: {rpm: 1, record: 1, transient: 1}\n"
    for overrides in (["run.rpm=2", "run.record=2"], {"run.rpm": 2.0, "run.record": 2}):
        run = load(text, overrides, {"run.rpm": (3.0, "--rpm")}).run
        assert (run.rpm, run.record, run.transient) == (3.0, 2, 1)
    assert load_scene(None, ["run.rpm=1", "run.rpm=2"]).run.rpm == 2.0


def test_texts_are_read_like_the_file_and_values_taken_as_they_are():
    sets = ["run.chatter_tolerance=1e-6", "run.start={q: 0.2, v: -1}", "sweep.sections=[strobe]",
            "sweep.direction=down", "sweep.rpm.num=1", " run.transient = 0"]  # fmt: skip
    values = {"run.chatter_tolerance": 1e-6, "run.start": {"q": 0.2, "v": -1}, "sweep.rpm.num": 1,
              "sweep.sections": ("strobe",), "sweep.direction": "down",
              "run.transient": 0}  # fmt: skip
    scene = load_scene(None, sets)
    assert scene == load_scene(None, values)
    assert (scene.run.start.v, scene.sweep.sections, scene.run.transient) == (-1.0, ("strobe",), 0)
    (fault,) = refused(None, {"run.rpm": "700"})
    assert (fault.where, fault.path) == ("overrides", "run.rpm")


def test_a_section_is_replaced_a_key_is_merged():
    replaced = load_scene(None, ["run={rpm: 5}", "run.start.theta_deg=9"])
    assert (replaced.run.rpm, replaced.run.record, replaced.run.start.theta_deg) == (5, 400, 9)
    faults = refused(None, ["follower={mass: 2}"])
    assert [f.path for f in faults] == ["follower.stiffness", "follower.restitution"]
    assert {f.where for f in faults} == {"--set follower={mass: 2}"}


def test_overrides_repair_supply_and_reach_into_nulls_and_lists(load, valid):
    assert load(valid + "run: {rpm: abc}\n", ["run.rpm=5"]).run.rpm == 5.0
    sets = ["follower.mass=1", "follower.stiffness=1", "follower.restitution=1"]
    assert load(valid[valid.index("cam:") :], sets).follower.mass == 1.0
    assert load(valid + "run: {start: null}\n", ["run.start.q=0.3"]).run.start.q == 0.3
    assert [f.path for f in refused(None, ["sweep.sections.1=impacts"])] == ["sweep.sections"]
    both = ["sweep.sections.0=strobe", "sweep.sections.1=impacts"]
    assert load_scene(None, both).sweep.sections == ("strobe", "impacts")


def test_another_kind_of_cam_drops_the_keys_of_the_old_one():
    sets = ["cam.kind=eccentric", "cam.base=0", "cam.lift=1"]
    assert load_scene(None, sets).cam.kind == "eccentric"
    assert [f.path for f in refused(None, [*sets, "cam.nose_radius=1"])] == ["cam.nose_radius"]


@pytest.mark.parametrize(
    ("text", "path", "found", "cure"),
    [
        ("run.rpm=660:760", "run.rpm", "'660:760'", "sweep.rpm"),
        ("run.rpm", "", "no '='", "="),
        ("=3", "", "path ''", "run.rpm"),
        ("a." * 40 + "a=3", "", "path 'a.a.", "run.rpm"),
        ("rpm=3", "rpm", "unknown key 'rpm'", "run.rpm or sweep.rpm"),
        ("run.rpm.x=3", "run.rpm", "a map", "a single value"),
        ("run.rpm=[", "run.rpm", "bracket", "close"),
        ("run.start={q: 1, q: 2}", "run.start.q", "'q' twice", "keep one"),
    ],
)
def test_fault_of_a_set_names_it(text, path, found, cure):
    (fault,) = refused(None, [text])
    assert fault.where == f"--set {text if len(text) <= 60 else text[:57] + '...'}"
    assert fault.path == path
    assert found in fault.found
    assert cure in fault.cure


def test_faults_of_file_sets_and_options_come_in_that_order(places, valid, tmp_path):
    text = valid.replace("0.8}", "2}") + "run: {recrod: 4}\n"
    options = {"sweep.rpm.num": (10**9, "--points"), "run.rpm": (-1.0, "--rpm")}
    assert places(text, ["run.record=x", "nothing"], options) == [
        ("1:57", "follower.restitution"),
        ("11:7", "run.recrod"),
        ("--set run.record=x", "run.record"),
        ("--set nothing", ""),
        ("--points", "sweep.rpm.num"),
        ("--rpm", "run.rpm"),
    ]
    unread = refused(tmp_path / "none.yaml", ["run.rpm=["])
    assert [f.path for f in unread] == ["", "run.rpm"]


# -- the scene ---------------------------------------------------------------------------------


def test_hash_depends_on_values_only(load, valid):
    plain_hash = scene_hash(load(valid))
    assert plain_hash == scene_hash(load(valid + "run: {transient: 6.0e2, rpm: 7e2}\n"))
    lines = valid.splitlines(keepends=True)
    assert plain_hash == scene_hash(load("".join([*lines[1:], lines[0]])))
    assert plain_hash != scene_hash(load(valid + "run: {rpm: 700.0000000000001}\n"))
    assert len(plain_hash) == 64


def test_a_resolved_scene_is_a_scene_again_and_does_not_change():
    scene = load_scene(None, ["run.start.q=0.1"])
    assert load_scene(json.loads(json.dumps(resolved(scene), allow_nan=False))) == scene
    with pytest.raises(pydantic.ValidationError):
        scene.run.rpm = 3


def test_json_schema_describes_every_key_and_allows_empty_sections():
    schema = json_schema()
    assert schema["required"] == ["follower", "cam"]
    assert {"type": "null"} in schema["properties"]["run"]["anyOf"]
    assert {"type": "null"} in schema["$defs"]["Run"]["properties"]["start"]["anyOf"]
    for model in (schema, *schema["$defs"].values()):
        assert model["additionalProperties"] is False
        for key, entry in model["properties"].items():
            assert key == "kind" or entry["description"]
    assert schema["$defs"]["Follower"]["properties"]["mass"]["minimum"] == 1e-15
    assert schema["$defs"]["Run"]["properties"]["transient"]["maximum"] == 10**9


def test_an_example_that_is_not_here_is_the_one_shipped(tmp_path, monkeypatch):
    """What the guide names runs from an installed program too; a file here comes first."""
    shipped = load_scene(ROOT / "configs" / "lift-table.yaml")
    monkeypatch.chdir(tmp_path)
    assert load_scene("configs/lift-table.yaml") == shipped
    for name in ("configs/no-such.yaml", "lift-table.yaml", "configs"):
        with pytest.raises(SceneError):
            load_scene(name)
    (tmp_path / "configs").mkdir()
    own = tmp_path / "configs" / "lift-table.yaml"
    own.write_text("follower: 3")
    with pytest.raises(SceneError, match="follower"):
        load_scene("configs/lift-table.yaml")
