"""The bytes and the text of a file that a scene names, and why they cannot be had."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from camcli.cams.files import _first_bytes, decoded, read_bytes
from camcli.errors import SceneError


def refusal(run, *given, **named) -> str:
    with pytest.raises(SceneError) as caught:
        run(*given, **named)
    (fault,) = caught.value.faults
    return str(fault)


def read(path: Path, most: int) -> bytes:
    return read_bytes(path, "t", most, "expected a table", "check the name", "file")


@pytest.mark.parametrize(
    ("most", "size"), [(7, "0 kB"), (2_999, "2 kB"), (999_999, "999 kB"), (10**6, "1 MB")]
)
def test_a_file_has_so_many_bytes_at_most(tmp_path, most, size):
    path = tmp_path / "t.csv"
    path.write_bytes(b"a" * most)
    assert read(path, most) == b"a" * most
    with open(path, "ab") as file:
        file.write(b"b")
    assert refusal(read, path, most) == (
        f"t: file: found more than {size}, expected at most {size}, is this the right file?"
    )


@pytest.mark.parametrize(
    ("size", "most", "got"), [(3, 6, 6), (3, 20, 8), (8, 20, 8), (8, 5, 5), (7, 8, 8), (9, 20, 8)]
)
def test_a_file_that_has_grown_is_read_up_to_its_limit(tmp_path, size, most, got):
    path = tmp_path / "t.csv"
    path.write_bytes(b"01234567")
    assert _first_bytes(path, size, most) == b"01234567"[:got]


def test_what_is_no_file_of_text_is_told_in_words(tmp_path):
    end = "expected a table, check the name and the permissions"
    for path, told in {
        tmp_path: "found a folder, expected a table, name the file in it",
        tmp_path / "none": "no such file, expected a table, check the name",
        tmp_path / ("n" * 300): f"cannot be read: file name too long, {end}",
        tmp_path / "a\0b": f"cannot be read: embedded null byte, {end}",
    }.items():
        assert refusal(read, path, 9) == f"t: file: {told}"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    told = "t: file: found a pipe, socket or device, expected a table, save it as a file first"
    assert refusal(read, tmp_path / "pipe", 9) == told


TEXT = "Hub ü\n1,2\n"


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode(), TEXT.encode("utf-8-sig"), b"\xff\xfe" + TEXT.encode("utf-16-le"),
        b"\xfe\xff" + TEXT.encode("utf-16-be"), TEXT.encode("cp1252"),
    ],
)  # fmt: skip
def test_a_table_is_text_as_spreadsheets_write_it(data):
    """A scene is UTF-8 alone."""
    assert decoded(data, "t", "file", table=True) == TEXT
    if b"\xc3\xbc" in data:
        assert decoded(data, "t") == TEXT
    else:
        assert "expected UTF-8 text, save the file as UTF-8" in refusal(decoded, data, "t")


@pytest.mark.parametrize(
    ("data", "table", "told"),
    [
        (b"ab\ncd\x07", True, "2:3: found the control character 0x07, expected text, is this a b"),
        (b"\xff\xfea\x00b", True, "1:1: found UTF-16 text, expected UTF-8 text, save the file as"),
        (b"\xff\xfea\x00", False, "1:1: found UTF-16 text, expected UTF-8 text, save the file as"),
        (b"ab\nc\xfc", False, "2:2: found byte 0xfc, expected UTF-8 text, save the file as UTF-8"),
        ("ä\nöü".encode() + b"\xff", False, "2:3: found byte 0xff, expected UTF-8 text, save the"),
        (b"a\xfc\x00", True, "1:2: found byte 0xfc, expected UTF-8 text, is this a binary file?"),
        (b"a\n\xfcb\x01", True, "2:1: found byte 0xfc, expected UTF-8 text, save the file as UTF"),
    ],
)
def test_what_is_no_text_is_told_by_its_line_and_column(data, table, told):
    assert refusal(decoded, data, "t", table=table).startswith(f"t:{told}")
