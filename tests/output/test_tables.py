"""Tables: the same numbers as text, as .npz and as arrays, to the last bit."""

import copy
import io
import pickle
from collections.abc import Mapping
from dataclasses import replace
from math import nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camcli.analysis import stored_speeds
from camcli.api.sweep import sweep
from camcli.output.run_folder import run_folder
from camcli.output.tables import Named, Table
from camcli.parallel import Checkpoint
from camcli.scene import load_scene

NUMBERS = st.sampled_from([0.0, -0.0, 0.1, 1 / 3, 5e-324, 1e16, 5e22]) | st.floats(allow_nan=False)
BLOCK = st.tuples(st.floats(1.0, 1e4), st.lists(st.tuples(st.integers(-9, 9), NUMBERS)))


@given(st.lists(BLOCK, max_size=4))
def test_every_number_is_there_in_order_to_the_last_bit(given_blocks):
    def blocks():
        for rpm, pairs in given_blocks:
            yield rpm, [n for n, _ in pairs], np.array([x for _, x in pairs], dtype=float)

    table = Table(("rpm", "period", "q_m"), blocks)
    rows = [(rpm, n, x) for rpm, pairs in given_blocks for n, x in pairs]
    lines = "".join(table.csv()).splitlines()
    assert lines == ["rpm,period,q_m", *(f"{rpm!r},{n},{x!r}" for rpm, n, x in rows)]
    files = [io.BytesIO(), io.BytesIO()]
    for file in files:
        table.npz(file)
    assert files[0].getvalue() == files[1].getvalue()
    found = np.load(io.BytesIO(files[0].getvalue()), allow_pickle=False)
    assert found["q_m"].tobytes() == np.array([x for *_, x in rows], dtype=float).tobytes()
    for k, column in enumerate(table.columns):
        assert found[column].tolist() == table[column].tolist() == [row[k] for row in rows]


@pytest.mark.parametrize(
    "columns",
    [
        (range(3), np.full(3, 0.25), np.full(3, 7), np.array(["up"] * 3)),  # one column changes
        (np.full(3, 1e-7), [4, None, 6], np.full(3, 0.5)),
        (np.array([0.0, -0.0, 0.0]), np.array([0.5, nan, 0.5]), np.array([nan, nan, nan])),
        (np.full(3, 1e300), np.full(3, -0.0), 8),  # none does
        (np.full(1, 0.1), [1.5]),
    ],
)
def test_what_is_the_same_in_all_rows_stands_in_all_of_them(columns):
    table = Table([f"c{k}" for k in range(1 + len(columns))], lambda: iter([(2.5, *columns)]))
    rows = zip(*([x] * 3 if isinstance(x, int) else list(x) for x in columns), strict=True)
    expected = [",".join(["2.5", *("" if x is None else str(x) for x in row)]) for row in rows]
    assert "".join(table.csv()).splitlines()[1:] == expected


def test_what_is_not_known_is_empty_and_what_is_no_number_is_refused():
    table = Table.of_rows(("a", "b"), lambda: [(1.5, "x"), (None, None), (float("inf"), "y")])
    assert "".join(table.csv()) == "a,b\n1.5,x\n,\ninf,y\n"
    assert table["b"].tolist() == ["x", "", "y"]
    assert np.isnan(table["a"][1])
    with pytest.raises(KeyError):
        table["c"]
    with pytest.raises(TypeError, match="a table cannot hold float64"):
        list(Table.of_rows(("a",), lambda: [(np.float64(1.0),)]).csv())


def two_rows():
    yield [[1.0, 2.5], ["x", "y"]]


def test_a_table_is_a_mapping_that_pandas_takes_as_it_is():
    table = Table(("a", "b"), two_rows)
    columns = {"a": [1.0, 2.5], "b": ["x", "y"]}
    assert isinstance(table, Mapping)
    assert isinstance(table, dict)  # pandas.DataFrame makes one column of names of other mappings,
    assert {key: table[key].tolist() for key in list(table.keys())} == columns  # and reads so
    assert (len(table), table.rows, bool(table), "a" in table, "c" in table) == (2, 2, 1, 1, 0)
    whole = [
        dict(table), {**table}, table.copy(), table | {}, {} | table, dict(table.items()),
        dict(zip(table, table.values(), strict=True)),
    ]  # fmt: skip
    for found in whole:
        assert {key: column.tolist() for key, column in found.items()} == columns
    other = {"b": [0, 0], "c": [3, 4]}  # the right one counts where both have a column
    joined, before = table | other, other | table
    assert (list(joined), joined["b"], joined["c"]) == (["a", "b", "c"], [0, 0], [3, 4])
    assert (list(before), before["b"].tolist(), before["c"]) == (
        ["b", "c", "a"],
        ["x", "y"],
        [3, 4],
    )
    assert [*reversed(table)] == ["b", "a"]
    assert table.get("c") is None
    assert (table == table, table != Table(("a", "b"), two_rows)) == (True, True)
    for same in (copy.copy(table), pickle.loads(pickle.dumps(table))):
        assert {key: column.tolist() for key, column in same.items()} == columns
    for change in (
        lambda: table.__setitem__("a", 1), lambda: table.update(a=1), lambda: table.pop("a"),
        lambda: table.__ior__({"a": 1}), table.clear, lambda: table.setdefault("c", 1),
        lambda: table.__delitem__("a"), table.popitem,
    ):  # fmt: skip
        with pytest.raises(TypeError, match="a table cannot be changed"):
            change()


@pytest.mark.ci
@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_data_frame_of_a_table_has_its_columns_bit_by_bit(library):
    frames = pytest.importorskip(library)
    scene = load_scene(None, {"sweep.rpm": {"start": 700.0, "stop": 745.0, "num": 3}})
    for table in sweep(scene).tables.values():
        frame = frames.DataFrame(table)
        assert list(frame.columns) == list(table.columns)
        for column in table.columns:
            in_frame = frame[column].to_numpy()
            assert in_frame.shape == (table.rows,)
            if table[column].dtype.kind in "fi":
                assert in_frame.dtype == table[column].dtype
                assert in_frame.tobytes() == table[column].tobytes()
            else:
                assert in_frame.tolist() == table[column].tolist()


def test_a_wrong_name_is_told_which_there_are():
    with pytest.raises(KeyError, match="found no column 'c'; there are a, b"):
        Table(("a", "b"), two_rows)["c"]
    with pytest.raises(KeyError, match="found no table 'speed'; there are impacts, speeds"):
        Named("table", {"impacts": 1, "speeds": 2})["speed"]


def test_another_form_of_the_tables_replaces_the_one_before(cam, tmp_path):
    words = "sweep --rpm 690:745 --points 3 --no-plot -o out --set"
    found = []
    for form in ("csv", "npz", "none"):
        assert cam(words, f"sweep.tables={form}").returncode == 0
        names = {path.name for path in (tmp_path / "out").iterdir()}
        sections = () if form == "none" else (f"impacts.{form}", f"strobe.{form}")
        assert names == {*sections, "speeds.csv", "run.json"}
        if form == "csv":
            text = np.genfromtxt(tmp_path / "out/impacts.csv", delimiter=",", names=True)
        elif form == "npz":
            found = dict(np.load(tmp_path / "out/impacts.npz", allow_pickle=False))
    assert list(found) == list(text.dtype.names)
    assert all(found[column].tolist() == text[column].tolist() for column in found)


def test_a_block_of_single_values_is_one_row():
    """Beside blocks with as many rows as their columns, and with none."""
    blocks = [(1.5, 2, "x"), (2.5, range(2), "y"), (3.5, [], "z"), (4.5, 5, np.array(["v", "w"]))]
    table = Table(("a", "b", "c"), lambda: iter(blocks))
    rows = [(1.5, 2, "x"), (2.5, 0, "y"), (2.5, 1, "y"), (4.5, 5, "v"), (4.5, 5, "w")]
    assert table.rows == len(rows)
    assert "".join(table.csv()).splitlines() == ["a,b,c", *(f"{a},{b},{c}" for a, b, c in rows)]
    file = io.BytesIO()
    table.npz(file)
    found = np.load(io.BytesIO(file.getvalue()), allow_pickle=False)
    for k, column in enumerate(table.columns):
        assert [row[k] for row in rows] == table[column].tolist() == found[column].tolist()


MIXED = {  # blocks of a column, and the column
    "a missing whole number": ([[1, 0], [None, 1]], [1.0, 0.0, nan, 1.0]),
    "a fraction": ([[1], [0.5]], [1.0, 0.5]),
    "a fraction, then whole ones": ([[0.5], [1, 2], 3, 4.5], [0.5, 1.0, 2.0, 3.0, 4.5]),
    "a missing text": ([["yes"], [None]], ["yes", ""]),
    "a missing text first": ([[None, None], ["yes"], None], ["", "", "yes", ""]),
    "one beside the other": ([["yes", None], "no"], ["yes", "", "no"]),
    "a number for all rows": ([np.array([1.0]), 2.0, np.array([3.0]), None], [1.0, 2.0, 3.0, nan]),
    "whole numbers and a fraction": (
        [np.array([1, 2]), range(3, 5), np.array([0.5]), np.array([6]), np.arange(9)[::4]],
        [1.0, 2.0, 3.0, 4.0, 0.5, 6.0, 0.0, 4.0, 8.0],
    ),
    "every second of an array": ([np.arange(3.0), np.arange(6.0)[::2]], [0.0, 1, 2, 0, 2, 4]),
    "nothing known": ([[None], [None]], [nan, nan]),
    "an empty block": ([[], [1], [], [2]], [1, 2]),
}


@pytest.mark.parametrize("name", MIXED)
def test_a_column_whose_blocks_are_of_two_kinds_holds_both(name):
    """In the archive as in the array."""
    blocks, column = MIXED[name]
    table = Table(("a",), lambda: ((entry,) for entry in blocks))
    file = io.BytesIO()
    table.npz(file)
    stored = np.load(io.BytesIO(file.getvalue()), allow_pickle=False)["a"]
    for found in (stored, table["a"]):
        assert found.dtype.kind == np.array(column).dtype.kind
        np.testing.assert_array_equal(found, column)


@pytest.mark.parametrize("blocks", [[["yes"], [1]], [[1], ["yes"]], [[0.5], ["yes"]]])
def test_numbers_among_texts_are_refused(blocks):
    table = Table(("a",), lambda: ((entry,) for entry in blocks))
    for read in (lambda: table["a"], lambda: table.npz(io.BytesIO()), table.arrays):
        with pytest.raises(TypeError, match="holds numbers or texts, not both"):
            read()


def test_the_type_of_a_column_does_not_depend_on_what_is_in_it():
    def kinds(*rows):
        table = Table.of_rows(("label", "stable", "watched_turns", "rpm"), lambda: iter(rows))
        assert {name: table[name].dtype.kind for name in table} == {
            name: values.dtype.kind for name, values in table.arrays().items()
        }
        return [table[name].dtype.kind for name in table]

    always = ["U", "f", "f", "f"]
    assert kinds() == always
    assert kinds(("P(1;1)", 1, None, 700.0)) == always
    assert kinds((None, None, None, 700.0)) == always
    assert kinds(("aperiodic", None, 21000, 745.0), ("P(1;1)", 1, None, 700.0)) == always


@pytest.fixture
def saved(tmp_path, monkeypatch):
    """A sweep whose pieces are on disk, saved as CSV or .npz: (result, record, pieces read)."""
    read = []
    get = Checkpoint.get

    def counted(checkpoint, place, number, names=None):
        read.append((place, number))
        return get(checkpoint, place, number, names)

    monkeypatch.setattr(Checkpoint, "get", counted)

    def save(form):
        numbers = {"run.transient": 5, "run.record": 9, "sweep.tables": form}
        scene = load_scene(None, {"sweep.rpm.num": 4, **numbers}, command="sweep")
        with run_folder(tmp_path, {"command": "sweep"}) as run:
            result = sweep(scene, work=replace(run.work, in_memory=-1))
            read.clear()
            record = result.write(run, plot=False)
        return result, record, read

    return save


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_both_sections_of_a_sweep_are_written_in_one_reading_of_its_pieces(saved, tmp_path, form):
    result, record, read = saved(form)
    assert len(read) == len(set(read)) == result.tables["speeds"].rows
    names = [f"impacts.{form}", f"strobe.{form}", "speeds.csv"]
    assert list(record["artefacts"]) == names
    for name in names[:2]:
        alone = io.BytesIO()
        again = sweep(result.scene).tables[name.partition(".")[0]]
        (again.npz if form == "npz" else again.write_csv)(alone)
        assert (tmp_path / name).read_bytes() == alone.getvalue()


@pytest.mark.parametrize("form", ["csv", "npz"])
@pytest.mark.parametrize(("broken", "whole"), [("impacts", "strobe"), ("strobe", "impacts")])
def test_an_error_of_one_section_does_not_cost_the_other(saved, monkeypatch, form, broken, whole):
    def check(stored):
        raise ZeroDivisionError("not foreseen")

    monkeypatch.setitem(stored_speeds.CHECKS, broken, check)
    _, record, _ = saved(form)
    assert list(record["artefacts"]) == [f"{whole}.{form}", "speeds.csv"]
    (fault,) = record["piece_faults"]
    assert f"{broken}.{form}" in str(fault)
