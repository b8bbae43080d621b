"""From errors of a validation, overrides and options to findings, each step asked alone."""

from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace as Stub

import pytest

from camcli.errors import SceneError
from camcli.scene import load, load_scene, resolved, scene_hash
from camcli.scene.document import parse
from camcli.scene.faults import _finding, findings
from tests.scene.conftest import VALID

OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {"kind": "oscillator", "frequency": 2.8, "clearance": 0.1, "damping": 0.2},
}
FOLLOWER, CAM = VALID.splitlines()[0], {"kind": "eccentric", "base": 0.1, "lift": 0.02}


def errors(*told: tuple[str, str]) -> Stub:
    """An error of pydantic: of each part its path and its type."""
    details = [
        {"loc": tuple(int(key) if key.isdecimal() else key for key in path.split(".")),
         "type": kind, "msg": "Input should be a thing", "ctx": {"ge": 1.0}}
        for path, kind in told
    ]  # fmt: skip
    return Stub(errors=lambda include_url: details)


def paths_of(text: str, *told: tuple[str, str]) -> list[str]:
    return [".".join(one.path) for one in findings(parse(text, "s.yaml"), errors(*told))]


def test_errors_are_told_in_the_order_of_their_values():
    """An alias has its value at the anchor."""
    text = "run: {rpm: &x 1, record: 2, transient: *x}\n"
    told = [(f"run.{key}", "int_type") for key in ("transient", "record", "rpm")]
    assert paths_of(text, *told) == ["run.transient", "run.rpm", "run.record"]


def test_what_follows_from_another_error_is_not_told():
    text = "sweep: {sections: [a, b]}\nbasins: {q: [1]}\n"
    item, whole, other = "sweep.sections.0", "sweep.sections", "basins.q"
    assert paths_of(text, (item, "literal_error"), (whole, "too_short")) == [item]
    assert paths_of(text, (whole, "too_short"), (other, "too_short")) == [whole, other]
    assert paths_of(text, (item, "literal_error"), (whole, "value_error")) == [whole, item]
    sizes = (
        ("run.rpm", "greater_than_equal"),
        ("run.rpm", "string_type"),
        ("run.record", "string_type"),
    )
    assert paths_of("run: {rpm: 1, record: 2}\n", *sizes) == ["run.rpm", "run.record"]


def test_two_hundred_errors_are_put_into_words_and_the_others_are_counted():
    keys = [f"k{n}" for n in range(202)]
    text = "".join(f"{key}:\n  - {key}\n" for key in keys)
    told = list(findings(parse(text, "s.yaml"), errors(*((key, "int_type") for key in keys))))
    assert [bool(one.found) for one in told] == [True] * 200 + [False] * 2
    assert str(told[200].mark) == "s.yaml:402:3"


@pytest.mark.parametrize(("before", "told"), [(49, False), (50, True)])
def test_a_misspelt_key_is_looked_for_among_fifty(before, told):
    text = "figure: {" + "".join(f"x{n}: 1, " for n in range(before)) + "titel: 1}\n"
    unknown = [(f"figure.x{n}", "extra_forbidden") for n in range(before)]
    all_told = [("figure.title", "missing"), *unknown, ("figure.titel", "extra_forbidden")]
    assert ("figure.title" in paths_of(text, *all_told)) is told


@pytest.mark.parametrize("kind", ["model_type", "model_attributes_type", "dict_type"])
def test_a_map_is_expected_whatever_pydantic_calls_it(kind):
    document = parse("sweep: {zoom: [3]}\nfigure: {printed: 3}\n", "s.yaml")
    for path, words in (
        (("sweep", "zoom", "0"), "a map with the keys start, stop, num"),
        (("figure", "printed"), "a map"),
    ):
        found = _finding(document, path, {"type": kind, "loc": path, "msg": "", "ctx": {}})
        assert found.expected == f"expected {words}"
        assert found.cure.startswith("write 'key: value' lines below ")


def said_of(*given, **named) -> list[str]:
    with pytest.raises(SceneError) as caught:
        load_scene(*given, **named)
    return [str(fault) for fault in caught.value.faults]


def test_a_law_that_is_missing_and_a_cam_that_is_none():
    motion = {"start_deg": 0.0, "length_deg": 90.0}
    law = {"kind": "law", "base": 0.0, "lift": 0.1, "rise": motion,
           "fall": {"length_deg": 90.0, "law": "3-4-5"}}  # fmt: skip
    follower = {"mass": 1.0, "stiffness": 1.0, "restitution": 0.5}
    (fault,) = said_of({"follower": follower, "cam": law})
    assert fault.startswith("scene: cam.rise.law: no key 'law', expected one of harmonic, cycl")
    law["rise"] = {**motion, "law": "3-4-5"}
    (fault,) = said_of({"follower": follower, "cam": {**law, "law": "3-4-5"}})
    assert fault.startswith("scene: cam.law: found the unknown key 'law', expected one of ")
    (fault,) = said_of({"follower": follower, "cam": "arcs"})
    assert "found 'arcs', expected a map with the keys kind, write" in fault


# -- overrides and options ---------------------------------------------------------------------


@pytest.mark.parametrize("text", ["run.rpm=fast", " run.rpm = fast"])
def test_what_an_option_replaces_is_looked_at_before(text):
    (fault,) = said_of(None, [text], {"run.rpm": (700.0, "--rpm")})
    assert fault.startswith(f"--set {text}: run.rpm: found 'fast', expected a number")
    told = said_of(None, [text, "run.record=0"], {"run.rpm": (700.0, "--rpm")})
    assert [fault.partition(": found")[0] for fault in told] == [
        f"--set {text}: run.rpm", "--set run.record=0: run.record"
    ]  # fmt: skip


class Contexts:
    """A scene that takes everything, and remembers the contexts in which it was validated."""

    model_fields = load.Scene.model_fields

    def __init__(self):
        self.seen = []

    def model_validate(self, data, strict, context):
        assert strict
        self.seen.append(context)
        return "scene"


@pytest.mark.parametrize(
    ("overrides", "options", "permitted"),
    [
        ([], {}, False),
        (["run.rpm=700"], {"run.record": (3, "--record")}, False),
        (["cam.allow_outside=true"], {}, True),
        ([" cam.allow_outside = true"], {}, True),
        ({"cam.allow_outside": True}, {}, True),
        (["cam={}"], {}, True),
        ([], {"cam.allow_outside": (True, "--x")}, True),
        ([], {"cam": ({}, "--cam")}, True),
        (["cam.allow_outside.x=true"], {}, False),
    ],
)
def test_the_command_line_alone_permits_a_file_elsewhere(
    monkeypatch, overrides, options, permitted
):
    scene = Contexts()
    monkeypatch.setattr(load, "Scene", scene)
    assert load_scene({}, overrides, options, folder="home", command="sweep") == "scene"
    assert scene.seen == [{"folder": Path("home"), "permitted": permitted, "command": "sweep"}]
    assert load._faults_at({"run.rpm"}, parse("{}", "s.yaml"), Path("home")) == []
    assert scene.seen[1] == {"folder": Path("home"), "permitted": True, "command": ""}


def test_an_override_that_cannot_be_read_is_one_fault():
    (fault,) = said_of(None, ["run.record=*x"])
    assert fault.startswith("--set run.record=*x: run.record: found an alias (*) without")


def test_an_unknown_key_of_a_cam_stays_where_an_override_leaves_its_kind():
    follower = {"mass": 1.0, "stiffness": 1.0, "restitution": 0.5}
    scene = {"follower": follower, "cam": {**CAM, "zzz": 1}}
    for overrides in ({}, {"run.rpm": 700.0}, {"cam.lift": 0.03}):
        (fault,) = said_of(scene, overrides)
        assert fault.startswith("scene: cam.zzz: found the unknown key 'zzz'")


@pytest.mark.parametrize(
    ("text", "odd"),
    [
        ("a", False),
        ("ü\ud7ff\ue000", False),
        ("a\ud800", True),
        ("\udc80b", True),
        ("\udfff", True),
    ],
)
def test_bytes_that_are_no_text_are_halves_of_a_character(text, odd):
    assert load._has_odd_bytes(text) is odd


def test_a_scene_from_stdin_is_not_cut(monkeypatch):
    for more in (0, 1):
        data = b"#" * (load.MAX_BYTES + more)
        monkeypatch.setattr(load.sys, "stdin", Stub(buffer=io.BytesIO(data)))
        if more:
            with pytest.raises(SceneError, match="found more than 256 kB, expected at most 256 kB"):
                load._stdin()
        else:
            assert load._stdin() == data


# -- what a scene is known by ------------------------------------------------------------------


def test_of_an_oscillator_what_follows_from_its_cam_is_left_out():
    values = resolved(load_scene(OSCILLATOR))
    assert values["follower"] == {"restitution": 0.8}
    assert "rpm" not in values["run"]
    counts = {name: values[name]["rpm"] for name in ("sweep", "detach", "orbits", "basins")}
    assert counts == {
        "sweep": {"num": 401}, "detach": {"num": 181}, "orbits": {"num": 201}, "basins": {"num": 41}
    }  # fmt: skip
    empty = load_scene({**OSCILLATOR, "spring": {}})
    assert scene_hash(empty) == scene_hash(load_scene(OSCILLATOR))


def test_a_scene_is_the_same_in_whatever_order_it_is_written():
    def hash_of(*names: str) -> str:
        printed = {name: float(ord(name)) for name in names}
        figure = {"title": "a", "command": "sweep", "printed": printed}
        return scene_hash(load_scene(None, {"figure": figure}))

    assert hash_of("a", "b", "c") == hash_of("c", "a", "b") != hash_of("a", "b", "d")
