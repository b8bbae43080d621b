"""Functions behind a scene, each asked alone: its speeds, its words, its springs."""

from __future__ import annotations

from itertools import combinations
from math import inf
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from pydantic import ValidationError

from camcli.errors import Fault, SceneError, shown
from camcli.scene import load_scene
from camcli.scene import schema as sections
from camcli.scene.document import MAX_DEPTH, Mark, _has_tab, document_of, dotted, parse, scalar
from camcli.scene.faults import _cure, _refused, _shown, wanted
from camcli.scene.load import _error, _override, _overriding, here_or_shipped, parse_rpm
from camcli.scene.made_up import made_up
from camcli.scene.schema import PANELS, SPRING, no_panel, panels_of
from camcli.scene.speeds import names_a_crank, of_a_shaft, of_the_cam, with_speeds

# -- speeds ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("6000 crank", (6000.0, "crank")), ("6000crank", (6000.0, "crank")),
        (" 6e3 rpm of the crank ", (6000.0, "crank")), ("3000cam", (3000.0, "cam")),
        ("-5 cam", (-5.0, "cam")), ("true crank", None), ("crank", None), ("6000", None),
        ("6000 crank now", None), ("a6000 crank", None), (6000, None), (None, None),
        ("6000 crank".rjust(60), (6000.0, "crank")), ("6000 crank".rjust(61), None),
    ],
)  # fmt: skip
def test_a_text_with_a_shaft_is_a_speed_of_it(text, read):
    assert of_a_shaft(text) == read
    if read is None:
        assert of_the_cam(text) is text
    else:
        assert of_the_cam(text) == read[0] / {"crank": 2.0, "cam": 1.0}[read[1]]
    is_cranks = read is not None and read[1] == "crank"
    assert names_a_crank({"a": [1, ("x", {"b": text})], "c": 2}) == is_cranks


def test_only_the_speeds_of_a_map_are_turned_into_those_of_the_cam():
    data = {"start": "500 crank", "stop": 400, "num": "6 crank", "key": "x"}
    found = with_speeds(data, ("start", "stop"))
    assert found == {"start": 250.0, "stop": 400, "num": "6 crank", "key": "x"}
    assert with_speeds(["500 crank"], ("start",)) == ["500 crank"]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("run.rpm", "600 crank"), ("sweep.rpm.start", "600 crank"),
        ("detach.hold_to", "600 crank"), ("orbits.at", "600crank"),
        ("classify.rpm.stop", "1300 crank"), ("basins.rpm.start", "600 crank"),
    ],
)  # fmt: skip
def test_a_speed_of_a_crank_in_any_one_section_says_that_there_is_a_crank(key, value):
    assert load_scene(None, {key: value}).run.crank
    assert not load_scene(None, {key: value.replace("crank", "cam")}).run.crank


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("2e9 crank", "2000000000.0 crank"), ("1e9", 1e9), ("1e-9", 1e-9),
        ("2e-9crank", "2e-09 crank"), ("700 : 650", (700.0, 650.0)),
    ],
)  # fmt: skip
def test_the_limits_of_a_speed_on_the_command_line_are_those_of_the_cam(text, read):
    assert parse_rpm(text) == read
    beyond = {"2e9 crank": "2.1e9 crank", "1e9": "1.1e9", "1e-9": "0.9e-9",
              "2e-9crank": "1.9e-9crank", "700 : 650": "700:0"}  # fmt: skip
    with pytest.raises(SceneError, match="give a speed in this range"):
        parse_rpm(beyond[text], "--at")


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("660-760", "write a range with a colon, as 660:760"),
        ("660..760", "write a range with a colon, as 660:760"),
        ("660 to 760", "write a range with a colon, as 660:760"),
        ("660,760", "write a range with a colon, as 660:760"),
        ("1:2:3", "give the number of speeds with --points"),
        ("5000crank:6000", "write crank behind the second end, or behind both"),
        ("500cam:600", "write cam behind the second end, or behind both"),
        ("true", "write it as 700, 660:760 or 6000crank"),
        ("null", "write it as 700, 660:760 or 6000crank"), ("", "give a value"),
        ("700rpm", "write the number without its unit"), ("700:", "give a value"),
        ("010", "write the number without leading zeros (it could mean octal)"),
    ],
)  # fmt: skip
def test_a_speed_that_cannot_be_read_names_its_option_and_what_to_write(text, cure):
    with pytest.raises(SceneError) as refused:
        parse_rpm(text, "--at")
    (fault,) = refused.value.faults
    assert (fault.where, fault.found, fault.cure) == ("--at", f"found '{text}'", cure)


# -- springs -----------------------------------------------------------------------------------

LOW, HIGH = 0.1, 0.25393320723821  # heights of the shipped cam: its offset, and the top above it
RATE, PRELOAD = 2000.0, 150.0
LOADS = {
    "rate": RATE, "preload": PRELOAD, "seat_load": RATE * LOW + PRELOAD,
    "nose_load": RATE * HIGH + PRELOAD,
}  # fmt: skip


@pytest.mark.parametrize("given", list(combinations(LOADS, 2)))
def test_any_two_loads_of_a_spring_are_the_same_spring(given):
    """On a cam whose base circle is not at q = 0."""
    scene = load_scene(None)
    follower = scene.follower.model_dump(exclude={"stiffness", "preload"})
    spring = {name: LOADS[name] for name in reversed(given)}
    source = {"follower": follower, "cam": scene.cam.model_dump(),
              "spring": {**spring, "mass": 0.3, "solid_at": 0.5}}  # fmt: skip
    found = load_scene(source)
    assert found.follower.stiffness == pytest.approx(RATE, rel=1e-9)
    assert found.follower.preload == pytest.approx(PRELOAD, rel=1e-9)
    assert found.follower.mass == pytest.approx(scene.follower.mass + 0.1, rel=1e-12)
    assert (found.spring.mass, found.spring.solid_at, found.spring.in_follower) == (0.3, 0.5, True)
    assert {getattr(found.spring, name) for name in SPRING} == {None}


@pytest.mark.parametrize("mass", [None, 0.06])
def test_numbers_that_were_not_filled_in_are_known_one_by_one(mass):
    """Also where a third of the spring has been added to the mass, as a scene adds it."""
    numbers = {"mass": 0.12345, "stiffness": 41234.5, "preload": 245.67}
    added = 0.0 if mass is None else 0.02

    def keys(lift=0.010123, spring_mass=mass, **changed):
        follower = Stub(**numbers | {"mass": 0.12345 + added} | changed)
        spring = None if spring_mass is None else Stub(mass=spring_mass)
        return made_up(Stub(follower=follower, spring=spring, cam=Stub(lift=lift)))

    others = ["follower.stiffness", "follower.preload"]
    assert keys() == ["follower.mass", *others, "cam.lift"]
    assert keys(lift="mm") == ["follower.mass", *others]
    assert keys(lift=0.0101, mass=0.12346) == others
    assert keys(stiffness=41234.0, preload=245.0) == ["follower.mass", "cam.lift"]
    assert keys(mass=0.12345) == ["follower.mass", *others, "cam.lift"]
    assert keys(mass=0.12345 + 0.03) == [*others, "cam.lift"]


# -- names of panels ---------------------------------------------------------------------------


def test_the_panels_of_a_command_are_those_of_all_its_pictures():
    assert panels_of("basins") == ["basins", "fractions", "attractors"]
    assert panels_of("detach")[0] == "phases"
    assert panels_of("sweep")[:5] == ["impacts", "enlarged", "strobe", "exponents", "kind"]
    assert set(panels_of()) == {name for command in PANELS for name in panels_of(command)}
    assert len(panels_of()) == len(set(panels_of()))
    assert panels_of("simulate") == panels_of()[: len(panels_of("simulate"))]


def test_a_panel_that_is_none_is_told_of_the_nearest_first():
    known = ["impacts", "strobe", "exponents"]
    assert no_panel("Strob", known) == (
        "found 'Strob'", "expected one of strobe, impacts, exponents", "did you mean 'strobe'?",
    )  # fmt: skip
    assert no_panel("xyz", known) == (
        "found 'xyz'", "expected one of impacts, strobe, exponents", "choose some of these",
    )  # fmt: skip


def test_sections_know_what_they_vary():
    """The number, how many values it takes, its column and its path in the scene."""
    rpm = sections.RpmRange(start=100.0, stop=300.0, num=7)
    axis = sections.Axis(key="follower.mass", start=1.0, stop=2.0, num=5)
    one = sections.Axis(key="rpm", start=2.0, stop=2.0, num=5)
    plain = sections.Varying(rpm=rpm)
    assert (plain.axis, plain.count, plain.key) == (rpm, 7, "rpm")
    varied = sections.Sweep(rpm=rpm, vary=(axis, one))
    assert (varied.axis, varied.count, varied.key) == (axis, 5, "follower.mass")
    alone = sections.Varying(rpm=rpm, vary=(one,))
    assert (alone.axis, alone.count, alone.key) == (one, 1, "rpm")
    assert (axis.path, one.path) == ("follower.mass", "run.rpm")


# -- what a document holds ---------------------------------------------------------------------


def test_the_path_of_a_key_is_told_with_points_and_cut_where_it_is_long():
    assert dotted(("run", "start", "q")) == "run.start.q"
    assert dotted(()) == ""
    assert len(dotted(["x" * 41])) <= 41
    assert dotted(["x" * 40]) == "x" * 40
    assert len(dotted(["ab"] * 100)) < 130


def test_values_of_python_and_numpy_are_plain_with_their_places():
    value = {"a": np.array([1, 2]), 3: (np.float64(0.5), True, None), "t": {"x": "y\ud800"}}
    document = document_of(value, Mark(2, "overrides"))
    assert document.data == {"a": [1, 2], "3": [0.5, True, None], "t": {"x": "y\\ud800"}}
    assert document.value(("a", "1")) == 2
    assert document.value(("3", "0")) == 0.5
    assert document.value(("3", "7")) is document.value(("t", "x", "z")) is None
    assert str(document.place(("a", "1")).value) == "overrides"


def test_places_in_lists_long_numbers_and_tabs():
    document = parse("a: [1, 2]\n", "s.yaml")
    document.put(("a", "1"), parse("5", "x"))
    assert document.data == {"a": [1, 5]}
    document.put(("a", "2"), parse("3", "x"))  # no such item: a map takes the place of the list
    assert document.data == {"a": {"2": 3}}
    assert type(scalar("1" * 18)) is int
    assert type(scalar("1" * 19)) is float
    text = "a:\n \tb: 1\nc\td\n"
    places = [(1, 3), (2, 1), (2, 2), (0, 1), (3, 0), (9, 0)]
    assert [_has_tab(text, *place) for place in places] == [True, True, False, False, False, False]


def test_a_path_on_the_command_line_has_as_many_keys_as_maps_may_nest():
    for depth, cure in ((32, "remove it"), (33, "name a key as in run.rpm")):
        with pytest.raises(SceneError) as refused:
            load_scene(None, {".".join(["a"] * depth): 1})
        assert refused.value.faults[0].cure == cure


def test_checks_of_names_ends_and_faces():
    with pytest.raises(SceneError, match="found the same name twice: 'y'"):
        sections._unique(("x", "y", "y", "x"))
    assert sections._unique(("x", "y")) == ("x", "y")
    with pytest.raises(SceneError, match=r"found \[2, 1\].*exchange the two"):
        sections._ascending((2.0, 1.0))
    with pytest.raises(SceneError, match=r"found \[1, 1\].*give a window of some width"):
        sections._ascending((1.0, 1.0))
    assert sections._ascending((1.0, 2.0)) == (1.0, 2.0)
    assert sections.Contact(face="flat", width=0.01).width == 0.01
    for face in ({"face": "knife", "width": 0.01}, {"face": "flat", "follower_radius": 1.0},
                 {"face": "roller", "width": 0.01}, {}):  # fmt: skip
        with pytest.raises(ValidationError, match="found"):
            sections.Contact(**face)
    falling = {"sweep.rpm": {"start": 300, "stop": 100}}
    for zoom, inside in (((250, 150), True), ((150, 250), True), ((300, 100), True),
                         ((301, 150), False), ((250, 99), False), ((200, 200), False)):  # fmt: skip
        ends = {"start": zoom[0], "stop": zoom[1]}
        if inside:
            assert load_scene(None, falling | {"sweep.zoom": [ends]}).sweep.zoom[0].num == 201
        else:
            with pytest.raises(SceneError, match="expected two ends within 100 to 300"):
                load_scene(None, falling | {"sweep.zoom": [ends]})


def test_a_character_that_is_none_is_told_by_its_line_and_column():
    (found,) = parse("a: 1\nbc: x\x01y\n", "s.yaml").findings
    assert str(found.mark) == "s.yaml:2:6"
    assert found.found == "found the control character U+0001"
    (found,) = parse("a: \x01\n", "--set x", 3, numbered=False).findings
    assert found.mark.rank == 3
    document = parse("a: {b: [1, x]}\nc: 2\n", "s.yaml")
    places = {path: (str(p.value), str(p.key)) for path, p in document.places.items() if path}
    assert places == {
        ("a",): ("s.yaml:1:4", "s.yaml:1:1"), ("a", "b"): ("s.yaml:1:8", "s.yaml:1:5"),
        ("a", "b", "0"): ("s.yaml:1:9", "s.yaml:1:9"),
        ("a", "b", "1"): ("s.yaml:1:12", "s.yaml:1:12"), ("c",): ("s.yaml:2:4", "s.yaml:2:1"),
    }  # fmt: skip
    assert document.place(("a", "b", "7", "x")) == document.places["a", "b"]


def test_a_value_is_shown_as_it_was_written_or_by_its_kind():
    text = "a: {x: 1}\nb: {}\nc: [1]\nd: []\ne: 'q'\nf: 1e-3\ng:\nh: ~\ni: 0x1\n"
    document = parse(text, "s.yaml")
    shown = [_shown(document, (key,)) for key in "abcdefghiz"]
    assert shown == [
        "a map", "an empty map", "a list of 1 value", "an empty list", "'q'", "1e-3", "nothing",
        "~", "'0x1'", "nothing",
    ]  # fmt: skip
    assert _shown(document, ("f", "x")) == "nothing"


RANGE = "a range of speeds stands in sweep.rpm; give rpm a single value"
BOTH_SIDES = "write cells along both sides: [5, 5]"


@pytest.mark.parametrize(
    ("value", "path", "kind", "cure"),
    [
        ("x", "a.q.1", "float_type", "give value 2 of q as a number"),
        ("1_0", "a.q", "int_type", "leave out the underscores"),
        (3, "sweep.rpm", "map", "write one speed as rpm: {start: 3, stop: 3}"),
        (3, "sweep.zoom", "map", "write 'key: value' lines below zoom"),
        (True, "sweep.rpm", "map", "write 'key: value' lines below rpm"),
        (5, "basins.cells", "tuple_type", BOTH_SIDES),
        (True, "basins.cells", "tuple_type", "write cells as a list: [True]"),
        ("svg", "plot.formats", "tuple_type", "write formats as a list: [svg]"),
        (None, "run.rpm", "float_type", "give rpm a value, or remove the line"),
        ("1:2", "run.rpm", "float_type", RANGE),
        ({"start": 1}, "run.rpm", "float_type", RANGE),
        ({"stop": 1}, "run.rpm", "float_type", "give rpm a single value"),
        ({"start": 1}, "orbits.rpm", "float_type", "give rpm a single value"),
        ([1], "run.rpm", "float_type", "give rpm a single value"),
        ([1], "basins.q", "too_short", "change q"),
        ("strob", "sweep.sections.0", "word", "did you mean 'strobe'?"),
        ("xyz", "sweep.sections.0", "word", "choose one of these"),
        (7, "figure.title", "string_type", "put title in quotes"),
        (False, "run.rpm", "float_type", "true and false are neither numbers nor text here"),
        (1.5, "run.record", "int_from_float", "round it"),
        (inf, "run.record", "finite_number", "give record a finite number"),
        (1.5, "run.rpm", "greater_than", "change rpm"),
        (3, "7", "string_type", "put 7 in quotes"),
        (3, "", "map", "write 'key: value' lines below the scene"),
    ],
)
def test_what_to_do_about_a_value(value, path, kind, cure):
    keys = tuple(path.split(".")) if path else ()
    assert _cure(value, keys, kind, ["impacts", "strobe"]) == cure


@pytest.mark.parametrize("as_texts", [True, False])
def test_overrides_and_options_have_marks_in_the_order_in_which_they_count(as_texts):
    overrides = ["a.b=1", "c"] if as_texts else {"a.b": 1, "c": 2}
    found = list(_overriding(overrides, {"d": (3, "--d"), "e": (4, "--e")}, 4))
    marks = [document.place(()).value for _, document in found]
    assert [mark.rank for mark in marks] == [1, 2, 7, 8]
    names = ["--set a.b=1", "--set c"] if as_texts else ["overrides", "overrides"]
    assert [mark.name for mark in marks] == [*names, "--d", "--e"]
    assert [path for path, _ in found] == ["a.b", "" if as_texts else "c", "d", "e"]
    assert [document.data for _, document in found][::2] == [1, 3]


def test_an_override_is_put_where_its_path_leads():
    """Blanks around keys do not count; one that cannot be read changes nothing."""
    text = "run: {rpm: 700, record: 1}\n"
    longest = ".".join(["a"] * MAX_DEPTH)
    for path, data in (
        (" run . rpm ", {"run": {"rpm": 1, "record": 1}}), ("run", {"run": 1}),
        (longest, None), (f"{longest}.a", f"'{shown(longest + '.a')}'"),
        ("run..rpm", "'run..rpm'"), ("", "''"), (" ", "' '"), ("run.", "'run.'"),
    ):  # fmt: skip
        for overrides in ({path: 1}, [f"{path}=1"]):
            document = parse(text, "f")
            findings = _override(document, overrides, {})
            if isinstance(data, str):
                ((found, keys),) = ((each.found, each.path) for each in findings)
                assert (found, keys) == (f"found the path {data}", ())
                assert document.data == parse(text, "f").data
            else:
                assert findings == []
                assert data is None or document.data == data
    for override, path, found in (
        ("run.rpm=[1", ("run", "rpm"), "a bracket is not closed, or a comma is missing"),
        ("run={rpm: 1, rpm: 2}", ("run", "rpm"), "found key 'rpm' twice"),
        ("run..rpm=[1", (), "found the path 'run..rpm'"),
        ("run.rpm", (), "found no '='"),
    ):
        document = parse(text, "f")
        (finding,) = _override(document, [override], {})
        assert (finding.path, finding.found) == (path, found)
        assert document.data == {"run": {"rpm": 700, "record": 1}}


def test_a_key_that_an_override_puts_into_another_kind_of_cam_is_refused():
    kind = {"cam.kind": "eccentric", "cam.base": 0.0, "cam.lift": 0.02}
    assert load_scene(None, kind).cam.kind == "eccentric"  # its keys of arcs have gone
    with pytest.raises(SceneError, match="found the unknown key 'nose_radius'"):
        load_scene(None, {"cam.nose_radius": 0.1, **kind})


@pytest.mark.parametrize(
    ("kind", "ctx", "words"),
    [
        ("int_type", {}, "a whole number"), ("int_from_float", {}, "a whole number"),
        ("tuple_type", {}, "a list"), ("bool_type", {}, "true or false"),
        ("string_type", {}, "text"), ("greater_than", {"gt": 0.1}, "a number greater than 0.1"),
        ("greater_than_equal", {"ge": 1e-15}, "a number of at least 1e-15"),
        ("less_than", {"lt": 360}, "a number less than 360"),
        ("less_than_equal", {"le": 2e9}, "a number of at most 2000000000"),
        ("float_type", {}, "a number"),
    ],
)  # fmt: skip
def test_what_a_value_should_have_been_is_told_in_words(kind, ctx, words):
    msg = "Input should be a valid number"
    assert wanted({"type": kind, "ctx": ctx, "msg": msg}) == words


@pytest.mark.parametrize(
    ("where", "path", "mark", "full_path"),
    [
        ("", "x.y", "s.yaml:2:4", ("cam", "x", "y")), ("", "z", "s.yaml:1:1", ("cam", "z")),
        ("", "", "s.yaml:1:1", ("cam",)), ("a:b.csv", "x", "a:b.csv", ("cam", "x")),
        ("t.csv:5", "", "t.csv:5:1", ("cam",)), ("t.csv:5:7", "x", "t.csv:5:7", ("cam", "x")),
    ],
)  # fmt: skip
def test_a_fault_of_a_section_stands_at_its_key_or_in_a_file_of_its_own(
    where, path, mark, full_path
):
    document = parse("cam: {x: {\n   y: 2}}\n", "s.yaml")
    cause = SceneError(Fault(where, path, "found", "expected", "cure"))
    (found,) = _refused(document, ("cam",), cause)
    assert (str(found.mark), found.mark.rank) == (mark, 0)
    assert (found.path, found.found, found.expected, found.cure) == (
        full_path, "found", "expected", "cure",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("key", "cure"),
    [
        ("run.p", "remove it"), ("run.strobe", "did you mean 'strobe_deg'?"),
        ("run.recrod", "did you mean 'record'?"),
        ("run.mass", "did you mean follower.mass or spring.mass?"),
        ("run.xyzzy", "remove it"),
    ],
)  # fmt: skip
def test_which_key_was_probably_meant(key, cure):
    with pytest.raises(SceneError) as refused:
        load_scene(None, {key: 1})
    (fault,) = refused.value.faults
    assert (fault.path, fault.cure) == (key, cure)


def test_faults_are_told_once_each_in_order_and_a_hundred_of_them():
    document = document_of({}, Mark(0, "scene"))
    marks = [Mark(0, "s.yaml", line, 1) for line in range(102, 0, -1)]
    findings = [Stub(mark=mark, path=("a",), fault=lambda mark=mark: str(mark)) for mark in marks]
    again = Stub(mark=marks[-1], path=("a",), fault=lambda: "again")
    error = _error([*findings, again])
    assert list(error.faults[:100]) == [f"s.yaml:{line}:1" for line in range(1, 101)]
    last = error.faults[100]
    assert (last.where, last.found, last.cure) == (
        "s.yaml", "2 further faults", "correct these first",
    )  # fmt: skip
    assert len(error.faults) == 101
    assert len(_error(findings[:100]).faults) == 100
    assert document.findings == []


def test_an_example_is_found_only_below_configs_and_only_where_it_is_not_here(
    tmp_path, monkeypatch
):
    from pathlib import Path

    monkeypatch.chdir(tmp_path)
    shipped = here_or_shipped(Path("configs/eccentric.yaml"))
    assert shipped.is_file()
    assert shipped.name == "eccentric.yaml"
    for path in ("eccentric.yaml", "configs/none.yaml", "x/configs/eccentric.yaml", "configs"):
        assert here_or_shipped(Path(path)) == Path(path)
    (tmp_path / "configs").mkdir()
    (tmp_path / "configs" / "eccentric.yaml").symlink_to("nowhere")
    assert here_or_shipped(Path("configs/eccentric.yaml")) == Path("configs/eccentric.yaml")
