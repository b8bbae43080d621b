"""Tables as .npz: the values of the CSV, the same bytes every time."""

import io

import numpy as np
import pytest
from camcli.output.bulk import write_npz
from hypothesis import given
from hypothesis import strategies as st

SETS = st.lists(st.lists(st.tuples(st.integers(-9, 9), st.floats(allow_nan=False))), max_size=4)


def written(names, rows) -> bytes:
    file = io.BytesIO()
    write_npz(names, rows, file)
    return file.getvalue()


@given(SETS)
def test_every_value_is_there_in_order(sets):
    def rows():
        for pairs in sets:
            yield [p for p, _ in pairs], np.array([x for _, x in pairs], dtype=float)

    data = written(("period", "q_m"), rows)
    found = np.load(io.BytesIO(data), allow_pickle=False)
    assert found["period"].tolist() == [p for pairs in sets for p, _ in pairs]
    assert found["q_m"].tobytes() == np.array([x for s in sets for _, x in s], float).tobytes()
    assert (found["period"].dtype, found["q_m"].dtype) == (np.dtype("i8"), np.dtype("f8"))
    assert data == written(("period", "q_m"), rows)


@pytest.mark.parametrize("more", [(), ("--lyapunov",)])
def test_the_numbers_of_the_csv(cam, tmp_path, more):
    words = ("sweep", "--rpm", "690:745", "--points", "5", "--no-plot", *more)
    turns = ("--set", "run.transient=5", "--set", "run.record=5")
    for form in ("csv", "npz", "none"):
        done = cam(*words, *turns, "--set", f"sweep.tables={form}", "-o", form)
        assert done.returncode == 0, done.stderr
    for name in ("impacts", "strobe"):
        table = np.genfromtxt(tmp_path / f"csv/{name}.csv", delimiter=",", names=True)
        found = np.load(tmp_path / f"npz/{name}.npz", allow_pickle=False)
        assert list(found) == list(table.dtype.names)
        for column in found:
            assert found[column].tolist() == table[column].tolist()
    assert sorted(p.name for p in (tmp_path / "none").iterdir()) == ["run.json", "speeds.csv"]


def test_another_form_replaces_the_one_before(cam, tmp_path):
    words = ("sweep", "--rpm", "700", "--no-plot", "-o", "out", "--set")
    for form in ("csv", "npz", "csv"):
        assert cam(*words, f"sweep.tables={form}").returncode == 0
        found = {p.name for p in (tmp_path / "out").iterdir()}
        assert found == {f"impacts.{form}", f"strobe.{form}", "speeds.csv", "run.json"}
