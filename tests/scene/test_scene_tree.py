"""YAML text to nodes: values, places, and what stops the reading."""

import pytest
import yaml

from camcli.scene import tree as tree_module
from camcli.scene.nodes import at, plain
from camcli.scene.places import Source
from camcli.scene.tree import MAX_DEPTH, MAX_NODES, parse

FILE = Source(0, "f", numbered=True)


@pytest.fixture(params=["CBaseLoader", "BaseLoader"], autouse=True)
def each_parser(request, monkeypatch):
    """Both parsers, compiled and not: an installation may lack the compiled one."""
    loader = getattr(yaml, request.param, None)
    if loader is None:
        pytest.skip("this PyYAML has no compiled parser")
    monkeypatch.setattr(tree_module, "_LOADER", loader)


def only(text):
    """(place, path, found) of the single fault."""
    (finding,) = parse(text, FILE).findings
    return str(finding.mark), finding.path, finding.found


def test_values_and_places_of_values_and_keys():
    root = parse("a: {b: 1e-3, c: 'x'}\nd:\n  - ~\n  - on\ne:\n", FILE).root
    assert plain(root) == {"a": {"b": 1e-3, "c": "x"}, "d": [None, "on"], "e": None}
    expected = {
        ("a",): ("f:1:4", "f:1:1"),
        ("a", "b"): ("f:1:8", "f:1:5"),
        ("a", "c"): ("f:1:17", "f:1:14"),
        ("d", 1): ("f:4:5", "f:4:5"),
        ("e",): ("f:5:3", "f:5:1"),
    }
    for path, marks in expected.items():
        node, key_mark = at(root, path)
        assert (str(node.mark), str(key_mark)) == marks


def test_quoted_scalars_are_text():
    text = "[\"1\", '1e-3', \"\", 'null', true]"
    assert plain(parse(text, FILE).root) == ["1", "1e-3", "", "null", True]


@pytest.mark.parametrize("text", ["", "# only a comment\n", "---\n", "\n\n"])
def test_empty_document_is_null(text):
    assert plain(parse(text, FILE).root) is None


def test_aliases_stand_for_values_and_keys():
    root = parse("a: &x {b: 1}\nc: *x\nd: &k key\n*k : 2\n", FILE).root
    assert plain(root) == {"a": {"b": 1}, "c": {"b": 1}, "d": "key", "key": 2}
    assert plain(parse("a: &n 010\n*n : &m 1\n*m : 3", FILE).root) == {"a": "010", "010": 1, "1": 3}
    assert str(at(root, ("c",))[0].mark) == "f:2:4"
    assert str(at(root, ("c", "b"))[0].mark) == "f:1:11"


@pytest.mark.parametrize(
    ("text", "place", "path", "found"),
    [
        ("a: 1\nb: 2\na: 3\n", "f:3:1", ("a",), "found key 'a' on lines 1 and 3"),
        ("a: {b: 1, b: 2}", "f:1:11", ("a", "b"), "found key 'b' on lines 1 and 1"),
        ("a: &a {b: 1, b: 2}\nc: [*a, *a]", "f:1:14", ("a", "b"), "found key 'b' on"),
        ("a: !!python/object:os.system x", "f:1:4", ("a",), "found the tag !!python/object:os"),
        ("a: [!mine 1]", "f:1:5", ("a", 0), "found the tag !mine"),
        ("a: *b", "f:1:4", ("a",), "found *b"),
        ("a: &a {b: *a}", "f:1:11", ("a", "b"), "found *a"),
        ("a: 1\n---\nb: 2\n", "f:2:1", (), "found a second document"),
        ("? [a]\n: 1", "f:1:3", (), "found a map or list as a key"),
        ("{a: {{b: 1}: 2}}", "f:1:6", ("a",), "found a map or list as a key"),
        ("a: &a [1]\n*a : 2", "f:2:1", (), "found a map or list as a key"),
        ("run:\n\trpm: 7\n", "f:2:1", (), "found a tab"),
        ("run:\n  rpm: 7\n\trecord: 4\n", "f:3:1", (), "found a tab"),
        ("a: b: c\n", "f:1:5", (), "found a second ':'"),
        ("a: [1, 2\n", "f:2:1", (), "a bracket is not closed"),
        ("a:\n  b: 1\n c: 2\n", "f:3:2", (), "the indentation does not fit"),
        ("a: 1\nb\n", "f:3:1", (), "a key has no ':'"),
        ("a: 'x\n", "f:2:1", (), "a quote is not closed"),
        ("a: 1\nb: \x00", "f:2:4", (), "found the control character U+0000"),
        ("a: \udc80", "f:1:4", (), "found the control character U+DC80"),
    ],
)
def test_one_clear_fault(text, place, path, found):
    where, at_path, words = only(text)
    assert (where, at_path) == (place, path)
    assert words.startswith(found)


@pytest.mark.parametrize("escape", ["\\ud800", "\\UFFFFFFFF", "\\U00110000", "\\q"])
def test_escapes_of_no_character_are_one_fault(escape):
    assert len(parse(f'a: "{escape}"', FILE).findings) == 1


def test_faults_that_need_not_stop_are_all_reported():
    found = [str(f.mark) for f in parse("a: !x 1\na: 2\nb: !y 3\n", FILE).findings]
    assert found == ["f:1:4", "f:2:1", "f:3:4"]


def test_depth_is_limited_with_and_without_aliases():
    assert parse("[" * MAX_DEPTH + "]" * MAX_DEPTH, FILE).root
    assert "nested" in only("[" * (MAX_DEPTH + 1))[2]
    chain = [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, MAX_DEPTH + 2)]
    assert "nested" in only("\n".join(["a0: &a0 [x]", *chain]))[2]


def test_number_of_values_is_limited_with_and_without_aliases():
    assert parse("[" + "1," * (MAX_NODES - 1) + "]", FILE).root
    assert "more than" in only("[" + "1," * MAX_NODES + "]")[2]
    half = "a: &a [" + "1," * (MAX_NODES // 2) + "]\n"
    assert parse(half, FILE).root
    assert "more than" in only(half + "b: *a\n")[2]
