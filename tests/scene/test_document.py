"""YAML text to plain data and places: values, marks, and what stops the reading."""

import math

import pytest
import yaml

from camcli.scene import document as document_module
from camcli.scene.document import MAX_DEPTH, MAX_VALUES, oddity, parse, scalar


@pytest.fixture(params=["CBaseLoader", "BaseLoader"], autouse=True)
def each_parser(request, monkeypatch):
    """Both parsers, compiled and not: an installation may lack the compiled one."""
    loader = getattr(yaml, request.param, None)
    if loader is None:
        pytest.skip("this PyYAML has no compiled parser")
    monkeypatch.setattr(document_module, "LOADER", loader)


def only(text):
    """(place, path, found) of the single fault."""
    (finding,) = parse(text, "f").findings
    return str(finding.mark), ".".join(finding.path), finding.found


def test_quoted_words_are_text_and_an_empty_document_is_null():
    assert parse("[\"1\", '1e-3', \"\", 'null', true]", "f").data == ["1", "1e-3", "", "null", True]
    for text in ("", "# only a comment\n", "---\n", "\n\n"):
        assert (parse(text, "f").data, parse(text, "f").findings) == (None, [])


def test_aliases_stand_for_values_and_keys():
    data = parse("a: &x {b: 1}\nc: *x\nd: &k key\n*k : 2\n", "f").data
    assert data == {"a": {"b": 1}, "c": {"b": 1}, "d": "key", "key": 2}
    assert data["a"] is not data["c"]


@pytest.mark.parametrize(
    ("text", "place", "path", "found"),
    [
        ("a: 1\nb: 2\na: 3\n", "f:3:1", "a", "found key 'a' on lines 1 and 3"),
        ("a: {b: 1, b: 2}", "f:1:11", "a.b", "found key 'b' on lines 1 and 1"),
        ("a: !!python/object:os.system x", "f:1:4", "a", "found the tag !!python/object:os"),
        ("a: [!mine 1]", "f:1:5", "a.0", "found the tag !mine"),
        ("a: *b", "f:1:4", "", "found an alias (*) without its anchor"),
        ("a: 1\n---\nb: 2\n", "f:2:1", "", "found a second document"),
        ("? [a]\n: 1", "f:1:3", "", "found a map or list as a key"),
        ("{a: {{b: 1}: 2}}", "f:1:6", "a", "found a map or list as a key"),
        ("a: &a [1]\n*a : 2", "f:1:4", "", "found a map or list as a key"),
        ("run:\n\trpm: 7\n", "f:2:1", "", "found a tab"),
        ("run:\n  rpm: 7\n\trecord: 4\n", "f:3:1", "", "found a tab"),
        ("a: b: c\n", "f:1:5", "", "found a second ':'"),
        ("a: [1, 2\n", "f:2:1", "", "a bracket is not closed"),
        ("a:\n  b: 1\n c: 2\n", "f:3:2", "", "the indentation does not fit"),
        ("a: 1\nb\n", "f:3:1", "", "a key has no ':'"),
        ("a: 'x\n", "f:2:1", "", "a quote is not closed"),
        ("a: 1\nb: \x00", "f:2:4", "", "found the control character U+0000"),
        ("a: \udc80", "f:1:4", "", "found the control character U+DC80"),
    ],
)
def test_one_clear_fault(text, place, path, found):
    where, at_path, words = only(text)
    assert (where, at_path) == (place, path)
    assert words.startswith(found)


@pytest.mark.parametrize("code", ["00110000", "7FFFFFFF", "80000000", "FFFFFFFF"])
def test_an_escape_beyond_the_last_character_is_a_fault(code):
    """The parser that is not compiled ends with a fault of Python's own, of two kinds."""
    (finding,) = parse(f'a: "\\U{code}"', "f").findings
    assert (finding.path, finding.expected) == ((), "expected YAML")


def test_depth_and_number_of_values_are_limited_with_and_without_aliases():
    assert parse("[" * MAX_DEPTH + "]" * MAX_DEPTH, "f").data
    assert "nested deeper than 32" in only("[" * (MAX_DEPTH + 2))[2]
    chain = [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, MAX_DEPTH + 2)]
    assert "nested deeper than 32" in only("\n".join(["a0: &a0 [x]", *chain]))[2]
    assert "nested deeper than 32" in only("a: &a {b: *a}")[2]
    row, rows = MAX_VALUES // 7, 7  # each row counts itself and its values, the list of rows one
    text = "- &a [" + "1," * (row - 1) + "]\n" + "- *a\n" * (rows - 1)
    text += "- 1\n" * (MAX_VALUES - 1 - rows * row)
    assert parse(text, "f").data
    assert "more than 20000 values" in only(text + "- 1\n")[2]


@pytest.mark.parametrize(
    ("text", "value"),
    [("", None), ("~", None), ("Null", None), ("TRUE", True), ("False", False), ("-0", 0),
     ("+5", 5), ("1e-3", 1e-3), ("1.e-9", 1e-9), ("1.0E+3", 1e3), (".5", 0.5), ("5.", 5.0),
     ("1234567890123456789", 1234567890123456789.0), ("1e999", math.inf), ("inf", math.inf),
     ("-.inf", -math.inf), ("+.INF", math.inf), ("1" * 100_000, math.inf)],
)  # fmt: skip
def test_an_unquoted_word_with_a_meaning(text, value):
    found = scalar(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "cure"),
    [("1:30", "base 60"), ("010", "leading zeros"), ("0x1F", "decimal"), ("1_000", "underscores"),
     ("1,5", "decimal point"), ("1d-3", "with e"), ("700 rpm", "unit"), ("1.2kg", "unit"),
     ("7500crank", "as 6000 crank"), ("7500 rpm Crank", "as 6000 crank"), ("6e3crankk", "unit"),
     ("1/3", "expressions"), ("−5", "ASCII"), ("on", ""), ("something else", ""), (".", ""),
     ("e5", ""), ("١", "")],
)  # fmt: skip
def test_an_odd_word_stays_text_and_is_told_what_to_do(text, cure):
    assert scalar(text) == text
    assert cure in oddity(text)
    assert bool(cure) == bool(oddity(text))


def test_a_value_put_at_a_path_leaves_all_others_as_they_were():
    """At every path of nested maps and lists, and at paths that make an item or a map."""
    text = "a: {b: [1, {c: 2, d: [3, 4]}, 5], e: 6}\nf: [[7, 8], [{g: 9}, 10]]\n"
    paths = [path for path in parse(text, "f").places if path]
    assert len(paths) == 18
    for path in paths:
        document = parse(text, "f")
        document.put(path, parse("new", "g"))
        expected = yaml.safe_load(text)
        *above, last = [int(key) if key.isdecimal() else key for key in path]
        node = expected
        for key in above:
            node = node[key]
        node[last] = "new"
        assert document.data == expected, path
        assert document.value(path) == "new"
        assert str(document.place(path).value).startswith("g")
    for path, made in (
        (("a", "x", "y"), {"x": {"y": "new"}}),
        (("a", "e", "y"), {"e": {"y": "new"}}),
    ):
        document = parse(text, "f")
        document.put(path, parse("new", "g"))
        assert document.data["a"] == yaml.safe_load(text)["a"] | made
