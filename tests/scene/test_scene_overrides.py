"""`--set`, options and `--rpm`: what beats what, and faults that name their source."""

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene, parse_rpm


def refused(sets=(), options=None):
    with pytest.raises(SceneError) as caught:
        load_scene(None, sets, options)
    return caught.value.faults


def test_options_beat_set_which_beats_the_file(load, valid):
    text = valid + "run: {rpm: 1, record: 1, transient: 1}\n"
    sets = ["run.rpm=2", "run.record=2"]
    run = load(text, sets, {"run.rpm": (3.0, "--rpm")}).run
    assert (run.rpm, run.record, run.transient) == (3.0, 2, 1)


def test_a_later_set_beats_an_earlier_one():
    assert load_scene(None, ["run.rpm=1", "run.rpm=2"]).run.rpm == 2.0


def test_values_are_read_like_the_file():
    sets = [
        "run.chatter_tolerance=1e-6",
        "run.start={q: 0.2, v: -1}",
        "sweep.sections=[strobe]",
        "sweep.direction=down",
        "sweep.rpm.num=1",
        " run.transient = 0",
        "run.record=5.0",
    ]
    scene = load_scene(None, sets)
    assert (scene.run.chatter_tolerance, scene.run.start.q, scene.run.start.v) == (1e-6, 0.2, -1.0)
    assert (scene.sweep.sections, scene.sweep.direction) == (("strobe",), "down")
    assert (scene.sweep.rpm.num, scene.run.transient, scene.run.record) == (1, 0, 5)


def test_a_section_is_replaced_a_key_is_merged():
    replaced = load_scene(None, ["run={rpm: 5}", "run.start.theta_deg=9"])
    assert (replaced.run.rpm, replaced.run.record, replaced.run.start.theta_deg) == (5, 400, 9)
    faults = refused(["follower={mass: 2}"])
    assert [f.path for f in faults] == ["follower.stiffness", "follower.restitution"]
    assert {f.where for f in faults} == {"--set follower={mass: 2}"}


def test_set_repairs_a_fault_of_the_file(load, valid):
    assert load(valid + "run: {rpm: abc}\n", ["run.rpm=5"]).run.rpm == 5.0


def test_set_supplies_what_the_file_lacks(load, valid):
    text = valid[valid.index("cam:") :]
    sets = ["follower.mass=1", "follower.stiffness=1", "follower.restitution=1"]
    assert load(text, sets).follower.mass == 1.0


def test_set_into_a_null_and_into_a_list(load, valid):
    assert load(valid + "run: {start: null}\n", ["run.start.q=0.3"]).run.start.q == 0.3
    text = valid + "sweep: {sections: [impacts, strobe]}\n"
    assert [f.path for f in refused(["sweep.sections.1=impacts"])] == ["sweep.sections"]
    assert load(text, ["sweep.sections.0=strobe", "sweep.sections.1=impacts"]).sweep.sections == (
        "strobe",
        "impacts",
    )


@pytest.mark.parametrize(
    ("text", "path", "found", "cure"),
    [
        ("run.rpm=abc", "run.rpm", "'abc'", "as a number"),
        ("run.rpm=660:760", "run.rpm", "'660:760'", "sweep.rpm"),
        ("run.rpm", "", "no '='", "="),
        ("=3", "", "path ''", "run.rpm"),
        ("run..rpm=3", "", "path 'run..rpm'", "run.rpm"),
        ("a." * 40 + "a=3", "", "path 'a.a.", "run.rpm"),
        ("rpm=3", "rpm", "unknown key 'rpm'", "run.rpm or sweep.rpm"),
        ("rum.rpm=3", "rum", "unknown key 'rum'", "'run'"),
        ("run.rpm.x=3", "run.rpm", "a map", "a single value"),
        ("run.rpm=[", "run.rpm", "bracket", "close"),
        ("run.start={q: 1, q: 2}", "run.start.q", "'q' twice", "keep one"),
        ("run.start={q: !!int 1}", "run.start.q", "tag !!int", "remove"),
        ("run.rpm='7'", "run.rpm", "'7'", "quotes"),
        ("run.rpm=", "run.rpm", "nothing", "a value"),
        ("run.rpm=a=b", "run.rpm", "'a=b'", "number"),
    ],
)
def test_fault_of_a_set_names_it(text, path, found, cure):
    (fault,) = refused([text])
    assert fault.where == f"--set {text if len(text) <= 60 else text[:57] + '...'}"
    assert fault.path == path
    assert found in fault.found
    assert cure in fault.cure


def test_faults_of_file_sets_and_options_come_in_that_order(places, valid):
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


def test_set_is_checked_even_without_a_readable_file(tmp_path):
    with pytest.raises(SceneError) as caught:
        load_scene(tmp_path / "none.yaml", ["run.rpm=["])
    assert [f.path for f in caught.value.faults] == ["", "run.rpm"]
    assert caught.value.faults[0].found == "no such file"


@pytest.mark.parametrize(
    ("text", "speeds"),
    [
        ("700", 700.0),
        ("7e2", 700.0),
        ("+.5", 0.5),
        ("660:760", (660.0, 760.0)),
        ("760:660", (760.0, 660.0)),
        ("700 : 700", (700.0, 700.0)),
    ],
)
def test_rpm(text, speeds):
    assert parse_rpm(text) == speeds


@pytest.mark.parametrize(
    "text",
    [
        "",
        ":",
        "1:",
        ":1",
        "1:2:3",
        "abc",
        "-3",
        "0",
        "nan",
        "inf",
        "1e999",
        "1e-10",
        "true",
        "null",
        "0x1",
        "010",
        "7 00",
        "660-760",
        "1,5",
        "1:nan",
        "\x00",
        "9" * 5000,
    ],
)
def test_rpm_garbage(text):
    with pytest.raises(SceneError) as caught:
        parse_rpm(text)
    (fault,) = caught.value.faults
    assert fault.where == "--rpm"
    assert "LO:HI" in fault.expected
    assert fault.cure
    assert len(str(fault)) < 300
