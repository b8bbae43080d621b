"""Files of pieces that somebody has edited: a result, or a refusal that names that very file."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import cam_in
from tests.support.bounds import fuzz, limited

TURNS = "--set run.transient=5 --set run.record=10 --no-plot"
RUNS = {
    "sweep": f"sweep --rpm 690:745 --points 5 --lyapunov {TURNS}",
    "map": f"sweep --rpm 690:700 --vary follower.restitution=0.7:0.8 --points 3,2 {TURNS}",
    "basins": "basins --rpm 700 --cells 8 --no-plot",
}
ARRAYS = [
    {"dtype": "<f8", "shape": [0], "at": 0},
    {"dtype": "<f8", "shape": [1], "at": 0},  # a NaN, see `edited`
    {"dtype": "|b1", "shape": [2], "at": 0},
    {"dtype": "<f8", "shape": [0, 10**12], "at": 0},
]
NAN = bytes.fromhex("000000000000f87f")
ODD = st.sampled_from(
    [None, True, -1, 0, 1, 1e308, float("nan"), float("inf"), -1e9, 2**70, 10**6, "", "x", "\x1b",
     "contact", "aperiodic", "P(3;3:3:2)", "-" * 5000, [], {}, [1], [[1]], {"a": 1}, *ARRAYS]
)  # fmt: skip


@pytest.fixture(scope="module")
def parts(tmp_path_factory) -> dict[str, Path]:
    """The folder with both parts of each run."""
    folders = {}
    for name, line in RUNS.items():
        folders[name] = tmp_path_factory.mktemp(name)
        for number in (1, 2):
            cam_in(folders[name], line, f"--shard {number}/2 -o parts", code=0)
    return folders


def places(value: Any, place: tuple = ()) -> Iterator[tuple]:
    """The places of a value and of all that is in it."""
    yield place
    inner = value.items() if isinstance(value, dict) else enumerate(value[:12])
    for key, one in inner if isinstance(value, dict | list) else ():
        yield from places(one, (*place, key)) if isinstance(one, dict | list) else [(*place, key)]


def changed(value: Any, place: tuple, data: st.DataObject) -> Any:
    """The value with what is at this place replaced, left out, or there twice."""
    if place:
        whole = list(value) if isinstance(value, list) else dict(value)
        whole[place[0]] = changed(value[place[0]], place[1:], data)
        return whole
    choices = [ODD]
    if isinstance(value, dict):
        choices += [st.just({**value, "strange": 1}), st.just(dict(list(value.items())[1:]))]
    if isinstance(value, list):
        choices += [st.just(value[:-1]), st.just(value + value[-1:])]
    if isinstance(value, int | float):
        choices += [st.just(-value)]
    return data.draw(st.one_of(choices))


def edited(original: bytes, data: st.DataObject) -> bytes:
    """The file with one value or some bytes of arrays changed, and the sum right again."""
    split = list(texts_and_arrays(original))
    k = data.draw(st.integers(0, len(split) - 1))
    text, arrays = split[k]
    value = json.loads(text)
    if k == 0:  # the key, a text of JSON
        key = json.loads(value[2])
        place = data.draw(st.sampled_from(list(places(key))))
        value[2] = json.dumps(changed(key, place, data))
    else:
        place = data.draw(st.sampled_from(list(places(value))[1:]))
        value = changed(value, place, data)
    if arrays and data.draw(st.booleans()):
        arrays = NAN + arrays[len(NAN) :]
    split[k] = json.dumps(value, separators=(",", ":")).encode(), arrays
    first_text, _ = split[0]
    first_value = json.loads(first_text)[2]
    seed_of_others = crc32(first_value.encode()) if isinstance(first_value, str) else 0
    whole = b""
    for text, arrays in split:
        rest = b"%d %s\n" % (len(arrays), text)
        seed = seed_of_others if whole else 0
        whole += b"%08x %s%s" % (crc32(arrays, crc32(rest, seed)), rest, arrays)
    return whole


def texts_and_arrays(whole: bytes) -> Iterator[tuple[bytes, bytes]]:
    """The JSON of each record of a file, and the bytes of its arrays."""
    while whole:
        line, _, whole = whole.partition(b"\n")
        _, size, text = line.split(b" ", 2)
        yield text, whole[: int(size)]
        whole = whole[int(size) :]


@pytest.mark.parametrize("run", RUNS)
@fuzz(25)
@given(data=st.data())
def test_an_edited_part_is_merged_or_refused_by_its_name(parts, run, data):
    folder = parts[run]
    path = data.draw(st.sampled_from(sorted((folder / "parts").iterdir())))
    original = path.read_bytes()
    try:
        path.write_bytes(edited(original, data))
        with limited():
            done = cam_in(folder, "merge parts -o merged -q --no-plot")
    finally:
        path.write_bytes(original)
        shutil.rmtree(folder / "merged", ignore_errors=True)
    assert done.returncode in (0, 2, 3), done.stderr
    assert "fault" not in done.stderr
    assert len(done.stderr) < 3000
    if done.returncode == 2:
        # another run than the first part's, or a part of another number
        names = (path.name, "than in parts/", "parts, not there: ")
        assert any(name in done.stderr for name in names), done.stderr


@pytest.mark.parametrize("begin", [b"", b"01234567 ", b"01234567 999999999999999 \n"])
def test_a_line_that_no_memory_holds_is_not_read(parts, monkeypatch, begin):
    """A sparse file of a terabyte is one line that never ends."""
    monkeypatch.setattr("camcli.parallel.checkpoint.most_line", lambda: 1 << 20)
    folder = parts["sweep"]
    path = folder / "parts" / "sweep-2-of-2.pieces"
    original = path.read_bytes()
    try:
        with open(path, "ab") as file:
            file.write(begin)
            file.truncate(1 << 40)
        with limited(5.0):
            done = cam_in(folder, "merge parts -o merged -q --no-plot")
    finally:
        path.write_bytes(original)
        shutil.rmtree(folder / "merged", ignore_errors=True)
    assert done.returncode == 0, done.stderr  # what follows the last whole line is torn
