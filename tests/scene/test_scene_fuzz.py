"""Whatever comes in, a Scene or a SceneError comes out."""

import os
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camcli.errors import SceneError
from camcli.scene import Scene, load_scene, parse_rpm
from camcli.scene import document as document_module

SHIPPED = (Path(__file__).parents[2] / "configs" / "chapter.yaml").read_text()
QUICK = settings(
    max_examples=int(os.environ.get("CAMCLI_FUZZ", "200")),
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
WORDS = """
run rpm cam kind follower mass sweep sections arcs null true on 1:30 010 1e-3 .nan -.inf 1e999
: - ? [ ] { } , # & * &a *a << ! !!int % @ ` | > ' " --- ... ~ 0 -1 700 é 😀
"""
SPACES = (" ", "\n", "\n  ", "\t", "\x00", "\x1b", "\ufeff", "\u2028", "\x85", ": ", "- ", "\r")
PIECES = st.sampled_from([*WORDS.split(), *SPACES])
YAMLISH = st.lists(PIECES, max_size=40).map("".join)
KEYS = """
run run.rpm run.start run.start.q cam cam.kind cam.offset follower follower.mass sweep.rpm
sweep.rpm.num sweep.sections sweep.sections.0 simulate.samples x run.x.y
"""
PATHS = st.sampled_from(KEYS.split())
VALUES = st.one_of(
    YAMLISH,
    st.floats().map(repr),
    st.integers().map(str),
    st.text(max_size=20),
    st.sampled_from(["{}", "[]", "null", "{kind: arcs}", "[strobe]", "{q: 1}", "5e-324"]),
)


def check(*args):
    """Load; the faults of a SceneError can be printed anywhere, anything else is a failure."""
    faults = ()
    try:
        scene = load_scene(*args)
    except SceneError as error:
        faults = error.faults
    else:
        assert isinstance(scene, Scene)
        return
    assert faults
    assert all(str(fault).isprintable() and fault.where for fault in faults)


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "scene.yaml"


@QUICK
@given(st.one_of(st.binary(max_size=200), YAMLISH.map(str.encode), st.text().map(str.encode)))
def test_random_files(scene_file, data):
    scene_file.write_bytes(data)
    check(scene_file)


@QUICK
@given(YAMLISH)
def test_random_files_with_the_parser_in_python(scene_file, text):
    scene_file.write_text(text, newline="")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(document_module, "_LOADER", document_module.limited(yaml.BaseLoader))
        check(scene_file)


@QUICK
@given(st.data())
def test_the_shipped_scene_with_mutations(scene_file, data):
    text = SHIPPED
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        stop = data.draw(st.integers(start, min(len(text), start + 30)))
        text = text[:start] + data.draw(st.one_of(PIECES, YAMLISH, st.just(""))) + text[stop:]
    scene_file.write_text(text, newline="")
    check(scene_file)


@QUICK
@given(
    st.lists(
        st.one_of(st.tuples(st.one_of(PATHS, YAMLISH), VALUES).map("=".join), st.text()), max_size=4
    )
)
def test_random_sets(sets):
    check(None, sets)


@QUICK
@given(
    st.dictionaries(
        PATHS,
        st.one_of(
            st.none(),
            st.booleans(),
            st.floats(),
            st.integers(),
            st.text(),
            st.lists(st.text()),
            st.dictionaries(st.text(), st.floats()),
        ),
        max_size=3,
    )
)
def test_random_options(values):
    check(None, (), {path: (value, "--option") for path, value in values.items()})


@QUICK
@given(st.floats(1e-9, 1e9), st.floats(1e-9, 1e9))
def test_every_speed_is_read_back(low, high):
    assert parse_rpm(repr(low)) == low
    assert parse_rpm(f"{low!r}:{high!r}") == (low, high)
    assert load_scene(None, [f"run.rpm={low!r}"]).run.rpm == low


@QUICK
@given(st.one_of(st.text(), YAMLISH))
def test_random_rpm(text):
    try:
        speeds = parse_rpm(text)
    except SceneError:
        return
    assert all(1e-9 <= s <= 1e9 for s in (speeds if isinstance(speeds, tuple) else (speeds,)))
