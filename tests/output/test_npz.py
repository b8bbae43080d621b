"""An archive whose columns are filled side by side is the one that Python's zipfile writes."""

import io
import zipfile

import numpy as np
import pytest

from camcli.api.rows import form
from camcli.api.sweep import sweep
from camcli.output import npz
from camcli.output.npz import Form, Npz
from camcli.scene import load_scene

COLUMNS = {
    "rpm": np.array([1.5, -0.0, np.nan, np.inf, 5e-324]),
    "period": np.array([0, 1, -2, 2**53 + 1, 4]),
    "direction": np.array(["up", "down", "", "up", "u"]),
}
FORM = Form(5, ["<f8", "<i8", "<U4"])


def by_zipfile() -> bytes:
    """The archive, one column after the other."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for name, column in COLUMNS.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, column, version=(1, 0))
    return content.getvalue()


def side_by_side(*ends: int) -> bytes:
    """The archive, whose rows come in blocks that end at these numbers."""
    content = io.BytesIO()
    archive = Npz(content, list(COLUMNS), FORM)
    for begin, end in zip((0, *ends), ends, strict=False):
        archive.add([column[begin:end] for column in COLUMNS.values()])
    archive.close()
    return content.getvalue()


@pytest.mark.parametrize("ends", [(5,), (1, 2, 5), (0, 3, 3, 5)])
def test_the_bytes_are_those_of_zipfile(ends):
    assert side_by_side(*ends) == by_zipfile()


def test_sizes_and_places_of_more_than_two_gigabytes_stand_in_fields_of_64_bits(monkeypatch):
    """Here from 150 bytes on; zipfile has the same limit in a variable of its own."""
    for module, name in ((npz, "LARGE"), (zipfile, "ZIP64_LIMIT")):
        monkeypatch.setattr(module, name, 150)
    content = side_by_side(2, 5)
    assert content == by_zipfile()
    assert zipfile.ZipFile(io.BytesIO(content)).testzip() is None
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        for name, column in COLUMNS.items():
            np.testing.assert_array_equal(found[name], column)


@pytest.mark.parametrize(("ends", "words"), [((4,), "fewer rows"), ((5, 6), None)])
def test_another_number_of_rows_than_was_counted_is_refused(ends, words):
    if words is not None:
        with pytest.raises(ValueError, match=words):
            side_by_side(*ends)
        return
    archive = Npz(io.BytesIO(), ["a"], Form(2, ["<f8"]))
    with pytest.raises(ValueError, match="more rows"):
        archive.add([np.zeros(3)])


@pytest.mark.parametrize(
    "changes",
    [
        {"sweep.direction": "both"},
        {"sweep.also": [{"q": 0.5, "v": 30}]},
        {"sweep.rpm.start": 50, "sweep.rpm.stop": 60},  # the follower never leaves the cam
    ],
)
def test_an_archive_of_a_sweep_holds_the_columns_of_its_tables(changes):
    numbers = {"sweep.rpm.num": 4, "run.transient": 5, "run.record": 3}
    result = sweep(load_scene(None, numbers | changes, command="sweep"))
    for name in ("impacts", "strobe"):
        table = result.tables[name]
        content = io.BytesIO()
        table.npz(content)
        with np.load(io.BytesIO(content.getvalue()), allow_pickle=False) as found:
            assert list(found) == list(table)
            for column in table:
                assert found[column].dtype == table[column].dtype
                np.testing.assert_array_equal(found[column], table[column])
        assert form(result.values[0], name).rows == table.rows
