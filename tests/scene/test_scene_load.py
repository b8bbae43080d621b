"""Files, defaults, the hash and the JSON Schema."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pydantic
import pytest

from camcli.cams import CAMS
from camcli.errors import SceneError
from camcli.scene import Scene, default_scene_path, json_schema, load_scene, resolved, scene_hash
from camcli.scene import files as files_module

ROOT = Path(__file__).parents[2]


def refused(path):
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    (fault,) = caught.value.faults
    return fault


def test_defaults_are_those_of_the_shipped_scene():
    shipped = load_scene(None)
    assert Scene(follower=shipped.follower, cam=shipped.cam) == shipped


def test_the_shipped_scene_names_every_key():
    import yaml

    written = yaml.safe_load(default_scene_path().read_text())
    del written["cam"]  # its keys depend on its kind

    def keys(value):
        return {k: keys(v) for k, v in value.items()} if isinstance(value, dict) else None

    full = resolved(load_scene(None))
    del full["cam"]
    assert keys(written) == keys(full)


def test_the_scene_inside_the_package_comes_first(tmp_path, monkeypatch):
    module = tmp_path / "camcli" / "scene" / "files.py"
    monkeypatch.setattr(files_module, "__file__", str(module))
    assert default_scene_path() == tmp_path / "configs" / "chapter.yaml"
    inside = tmp_path / "camcli" / "configs" / "chapter.yaml"
    inside.parent.mkdir(parents=True)
    inside.touch()
    assert default_scene_path() == inside


def test_empty_sections_take_their_defaults(load, valid):
    empty = "run:\nsimulate: ~\nsweep: {rpm: }\n"
    assert load(valid + empty) == load(valid) == load(valid + "run: {start: null}\n")


def test_whole_numbers_may_be_written_as_floats(load, valid):
    transient = load(valid + "run: {transient: 6e2, record: 400.0}\n").run.transient
    assert transient == 600
    assert isinstance(transient, int)


def test_one_speed_and_descending_ranges_are_valid(load, valid):
    for sweep in ("start: 760, stop: 660", "num: 1", "start: 700, stop: 700"):
        assert load(valid + f"sweep: {{rpm: {{{sweep}}}}}\n")


def test_byte_order_mark_and_line_ends_of_windows(load, places, valid):
    windows = b"\xef\xbb\xbf" + valid.replace("\n", "\r\n").encode()
    assert load(windows) == load(valid)
    assert places(windows.replace(b"mass: 1", b"mass: -1")) == [("1:18", "follower.mass")]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_missing_folder_pipe_and_device(tmp_path):
    assert refused(tmp_path / "none.yaml").found == "no such file"
    assert refused(tmp_path).found == "found a folder"
    assert refused(Path("/dev/null")).found == "found a pipe, socket or device"
    assert refused(Path("a\0b")).found.startswith("cannot be read")
    assert refused(Path("x" * 5000)).found.startswith("cannot be read")
    os.mkfifo(tmp_path / "pipe")
    fault = refused(tmp_path / "pipe")
    assert fault.found == "found a pipe, socket or device"
    assert fault.where == str(tmp_path / "pipe")


def test_no_permission(tmp_path, valid, monkeypatch):
    path = tmp_path / "scene.yaml"
    path.write_text(valid)

    def denied(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", denied)
    assert refused(path).found == "cannot be read: permission denied"


@pytest.mark.parametrize(
    ("data", "place", "found", "cure"),
    [
        (b"\x00\x01\x02", "1:1", "control character U+0000", "binary"),
        (b"a: 1\nb: \xff\x00", "2:4", "byte 0xff", "binary"),
        (b"a: \xe9\n", "1:4", "byte 0xe9", "UTF-8"),
        ("run: 1\n".encode("utf-16"), "1:1", "UTF-16", "UTF-8"),
    ],
)
def test_binary_and_other_encodings(faults, data, place, found, cure):
    (fault,) = faults(data)
    assert fault.where.endswith(f"scene.yaml:{place}")
    assert found in fault.found
    assert cure in fault.cure


def test_a_file_that_grows_after_the_check_is_still_refused(tmp_path, monkeypatch):
    path = tmp_path / "scene.yaml"
    path.write_bytes(b"#" * (files_module.MAX_BYTES + 1))
    assert "found 262145 bytes" in refused(path).found
    monkeypatch.setattr(files_module, "_refuse", lambda *_: None)
    assert "more than 262144 bytes" in refused(path).found


def test_hash_depends_on_values_only(load, valid):
    plain_hash = scene_hash(load(valid))
    assert plain_hash == scene_hash(load(valid + "run: {transient: 6.0e2, rpm: 7e2}\n"))
    lines = valid.splitlines(keepends=True)
    assert plain_hash == scene_hash(load("".join([*lines[1:], lines[0]])))
    assert plain_hash != scene_hash(load(valid + "run: {rpm: 700.0000000000001}\n"))
    assert len(plain_hash) == 64


def test_resolved_scene_is_a_scene_again():
    scene = load_scene(None, ["run.start.q=0.1"])
    text = json.dumps(resolved(scene), allow_nan=False)
    assert Scene.model_validate(json.loads(text)) == scene
    assert resolved(scene)["sweep"]["sections"] == ["impacts", "strobe"]


def test_a_scene_does_not_change():
    with pytest.raises(pydantic.ValidationError):
        load_scene(None).run.rpm = 3


@pytest.mark.parametrize("cam", CAMS)
def test_each_cam_is_as_strict_as_the_other_sections(cam):
    assert cam.model_config["extra"] == "forbid"
    assert cam.model_config["frozen"]
    assert "const" in cam.model_json_schema()["properties"]["kind"]


def test_text_and_booleans_are_no_numbers_in_the_cam(places, valid):
    for bad in ("'0.3'", "true", ".nan", "[0.3]"):
        assert places(valid.replace("offset: 0.3", f"offset: {bad}")) == [("10:11", "cam.offset")]


def test_json_schema_describes_every_key_and_allows_empty_sections():
    schema = json_schema()
    json.dumps(schema)
    assert schema["required"] == ["follower", "cam"]
    assert {"type": "null"} in schema["properties"]["run"]["anyOf"]
    assert {"type": "null"} in schema["$defs"]["Run"]["properties"]["start"]["anyOf"]
    for model in (schema, *schema["$defs"].values()):
        assert model["additionalProperties"] is False
        for key, entry in model["properties"].items():
            assert key == "kind" or entry["description"]
    assert schema["$defs"]["Follower"]["properties"]["mass"]["minimum"] == 1e-15
    assert schema["$defs"]["Run"]["properties"]["transient"]["maximum"] == 10**9


def test_import_is_light():
    code = "import sys, camcli.scene; print(*sys.modules)"
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    heavy = {"numpy", "scipy", "numba", "matplotlib", "typer", "rich", "difflib"}
    assert not heavy & set(run.stdout.split())
