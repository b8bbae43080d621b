"""The file of finished pieces: values to the last bit, torn, damaged, foreign, on a full disk."""

import json
import os
import struct
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from zlib import crc32

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from camcli.errors import SceneError
from camcli.parallel import Checkpoint
from camcli.parallel import checkpoint as checkpoint_module
from camcli.parallel.checkpoint import DTYPES, END, SUM, key_of, pack, records, unpack

SHAPES = arrays_of.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=4)
ARRAYS = st.sampled_from(DTYPES).flatmap(
    lambda kind: arrays_of.arrays(np.dtype(kind), SHAPES, fill=st.nothing())
)
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
VALUES = st.recursive(SCALARS | ARRAYS, lambda inner: st.lists(inner, max_size=4), max_leaves=12)


def same(a, b) -> bool:
    """Equal in type and to the last bit."""
    if isinstance(a, np.ndarray):
        return (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
    if isinstance(a, float):
        return isinstance(b, float) and (a != a != b or struct.pack("d", a) == struct.pack("d", b))
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and a == b


@settings(max_examples=60, deadline=None)
@given(VALUES)
def test_every_value_comes_back(value):
    text, arrays = pack(value)
    assert b"\n" not in text
    assert same(value, unpack(text, arrays))


def test_what_is_a_list_or_a_number_afterwards():
    assert unpack(*pack((1, range(3), [True]))) == [1, [0, 1, 2], [True]]
    numbers = unpack(*pack([np.float64(0.1), np.int32(7), np.bool_(True), np.array(2.0)]))
    assert [type(n) for n in numbers] == [float, int, bool, float]
    for value in ({1}, object(), b"x", np.array(["x"]), 1j):
        with pytest.raises(TypeError):
            pack([value])


SHAPED = [
    [1 << 62],
    [1 << 32, 1 << 32],
    [10**30],
    [0, 10**30],
    [2.0],
    ["2"],
    [[2]],
    [0, 1 << 63],
    [-1],
    [-1, -1],
    [2],
]
BROKEN = [
    b"", b"\xff", b"1 2", b"[" * 100_000, b"9" * 5000,
    *(json.dumps({"dtype": "<f8", "shape": s, "at": 0}).encode() for s in SHAPED),
    *(json.dumps({"dtype": "<f8", "shape": [1], "at": at}).encode() for at in (-8, 1, 8, 2**70)),
]  # fmt: skip


@pytest.mark.parametrize("data", BROKEN, ids=range(len(BROKEN)))
def test_broken_bytes_are_refused_and_allocate_nothing(data):
    tracemalloc.start()
    with pytest.raises(ValueError, match=r"."):
        unpack(data, bytes(8))
    assert tracemalloc.get_traced_memory()[1] < 1 << 21
    tracemalloc.stop()


SHARD = {"shard": [3, 4]}
COLUMNS = {"q": np.array([0.1, -np.inf]), "n": np.full(1, 0x0A0A, "<i2")}  # and line breaks
PIECES = {
    ("0", 0): [1, 0.1, None], ("0", 1): "text", ("1", 0): COLUMNS, ("range/0", 2): [],
    (END, 0): SHARD,
}  # fmt: skip


def written(path, pieces=PIECES) -> bytes:
    checkpoint = Checkpoint(path, "work")
    for name, value in pieces.items():
        checkpoint.put(*name, value)
    checkpoint.close()
    return path.read_bytes()


def ends(path) -> list[int]:
    with open(path, "rb") as file:
        return [record.end for record in records(file)]


def found(checkpoint) -> dict:
    return plain({name: checkpoint.get(*name) for name in PIECES if name in checkpoint})


def plain(value):
    """The value with the arrays in it as lists."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value


def test_what_was_put_is_there_again(tmp_path):
    written(tmp_path / "c")
    checkpoint = Checkpoint(tmp_path / "c", "work")
    assert found(checkpoint) == plain(PIECES)
    assert (checkpoint.resumed, checkpoint.torn) == (4, 0)  # the end of a shard is no piece
    assert ("0", 7) not in checkpoint
    checkpoint.put("0", 0, 2)
    assert (checkpoint.get("0", 0), checkpoint.pieces) == (2, 4)
    checkpoint.discard()
    Checkpoint(tmp_path / "c", "work").close()  # nothing was put
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize("name", ["a", "ab", "abc", "abcdefgh"])
def test_arrays_are_read_where_a_processor_is_quick(tmp_path, name):
    """At a multiple of their numbers' size, however long the line before them is."""
    with closing(Checkpoint(tmp_path / "pieces", "key")) as checkpoint:
        checkpoint.put(name, 1, {"few": np.array([True]), "numbers": np.arange(5.0)})
        assert all(array.flags.aligned for array in checkpoint.get(name, 1).values())


def test_the_first_pieces_wait_for_a_later_one(tmp_path, monkeypatch):
    clock = [0.0]  # s
    monkeypatch.setattr("camcli.parallel.checkpoint.monotonic", lambda: clock[0])
    checkpoint = Checkpoint(tmp_path / "c", "work")
    clock[0] = 1.0
    checkpoint.put("0", 0, 1)
    assert (len(ends(tmp_path / "c")), ("0", 0) in checkpoint, checkpoint.pieces) == (1, True, 1)
    clock[0] = 1.001
    checkpoint.put("0", 1, 2)
    assert (len(ends(tmp_path / "c")), checkpoint.pieces) == (3, 2)
    checkpoint.discard()


def test_large_pieces_do_not_wait(tmp_path, monkeypatch):
    monkeypatch.setattr("camcli.parallel.checkpoint.monotonic", lambda: 0.0)  # no time passes
    checkpoint = Checkpoint(tmp_path / "c", "work", most_waiting=100)
    for number, lines in ((0, 1), (1, 3), (2, 3), (3, 5)):  # 64 bytes wait, 128 do not
        checkpoint.put("0", number, {"columns": (None, np.zeros(8))})
        assert len(ends(tmp_path / "c")) == lines
    checkpoint.discard()


def test_torn_at_every_byte_all_whole_pieces_stay(tmp_path):
    whole, path = written(tmp_path / "whole"), tmp_path / "torn"
    marks = ends(tmp_path / "whole")
    for size in range(len(whole) + 1):
        path.write_bytes(whole[:size])
        checkpoint = Checkpoint(path, "work")
        count = max(0, sum(mark <= size for mark in marks) - 1)
        assert found(checkpoint) == plain(dict(list(PIECES.items())[:count]))
        assert checkpoint.torn == size - max((m for m in marks if m <= size), default=0)
        for name in list(PIECES)[count:]:
            checkpoint.put(*name, PIECES[name])
        checkpoint.close()
        assert path.read_bytes() == whole


def test_a_flipped_bit_costs_its_piece_alone(tmp_path):
    whole, path = written(tmp_path / "whole"), tmp_path / "flipped"
    marks = ends(tmp_path / "whole")
    names = list(PIECES)
    for at in range(0, len(whole) * 8, 3):  # 3 and 8 have no divisor: each bit of a byte is met
        damaged = bytearray(whole)
        damaged[at // 8] ^= 1 << at % 8
        path.write_bytes(damaged)
        record = sum(mark * 8 <= at for mark in marks)  # its number; the first one is no piece
        if at < 8 * SUM:  # not known to be ours: left as it is
            with pytest.raises(SceneError, match="no pieces of this run"):
                Checkpoint(path, "work")
            assert path.read_bytes() == damaged
            continue
        left = {} if record == 0 else {n: PIECES[n] for n in names if n != names[record - 1]}
        checkpoint = Checkpoint(path, "work")
        assert found(checkpoint) == plain(left)
        between = 0 < record < len(names)
        assert checkpoint.damaged == (marks[record] - marks[record - 1] if between else 0)
        for name in names:
            if name not in left:
                checkpoint.put(*name, PIECES[name])
        checkpoint.close()
        again = Checkpoint(path, "work")
        assert found(again) == plain(PIECES)
        again.close()


@pytest.mark.parametrize("bytes_lost", [1, 8, 13, 25])
def test_what_is_behind_lost_or_foreign_bytes_stays(tmp_path, bytes_lost):
    """Nothing but the beginning of a record says where the next one is."""
    whole, path = written(tmp_path / "whole"), tmp_path / "damaged"
    marks = ends(tmp_path / "whole")
    names = list(PIECES)
    begin, end = marks[1], marks[2]  # of the second piece
    assert bytes_lost + 3 < end - begin
    for changed in (
        whole[: begin + 3] + whole[begin + 3 + bytes_lost :],
        whole[:begin] + b"0123abcd 7 [" * bytes_lost + whole[begin:],
        whole[:begin] + b"a" * bytes_lost + whole[end:],
    ):
        path.write_bytes(changed)
        checkpoint = Checkpoint(path, "work")
        kept = found(checkpoint)
        assert {**plain(PIECES), **kept} == plain(PIECES)
        assert set(names) - set(kept) <= {names[1]}
        assert checkpoint.damaged > 0
        checkpoint.close()


def test_pieces_of_another_run_are_not_taken_for_ours(tmp_path):
    """As a power cut may leave them on the disk, or arrays that hold a file of pieces."""
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    checkpoint = Checkpoint(theirs, "other work")
    checkpoint.put("0", 1, "theirs")
    checkpoint.close()
    foreign = theirs.read_bytes()[ends(theirs)[0] :]
    whole = written(ours)
    marks = ends(ours)
    for place in (len(whole), marks[1]):  # at the end; in the place of a damaged piece
        ours.write_bytes(whole[:place] + b"damage" + foreign + whole[place:])
        checkpoint = Checkpoint(ours, "work")
        assert found(checkpoint) == plain(PIECES)
        checkpoint.close()
    nested = {"bytes": np.frombuffer(b"\n" + foreign, np.uint8)}
    checkpoint = Checkpoint(tmp_path / "nested", "work")
    checkpoint.put("0", 0, nested)
    checkpoint.put("0", 2, 2)
    checkpoint.close()
    content = bytearray((tmp_path / "nested").read_bytes())
    content[content.index(foreign) - 1] ^= 1
    (tmp_path / "nested").write_bytes(content)
    with closing(Checkpoint(tmp_path / "nested", "work")) as checkpoint:
        assert [name in checkpoint for name in (("0", 0), ("0", 1), ("0", 2))] == [0, 0, 1]


@pytest.mark.ci
def test_the_next_record_is_not_looked_for_without_end(tmp_path):
    """In 64 MiB of a file, whatever looks like one; then where the damaged one says it ends."""
    whole, path = written(tmp_path / "whole"), tmp_path / "damaged"
    begin, names = ends(tmp_path / "whole")[1], list(PIECES)
    enough, like_one = 1 << 26, b"0123abcd 7 ["
    for between, count in (
        (bytes(enough - (1 << 20)), len(names)), (bytes(enough), 1),
        (like_one + bytes((enough >> 1) - (1 << 20)), len(names)), (like_one * (1 << 20), 1),
    ):  # fmt: skip
        path.write_bytes(whole[:begin] + between + whole[begin:])
        checkpoint = Checkpoint(path, "work")
        assert len(found(checkpoint)) == count
        checkpoint.close()
    large = Checkpoint(tmp_path / "large", "work")
    for number in range(3):
        large.put("0", number, np.zeros(enough // 8 + 1) if number == 0 else number)
    large.close()
    with open(tmp_path / "large", "r+b") as file:
        file.seek(enough // 2)
        file.write(b"x")
    with closing(Checkpoint(tmp_path / "large", "work")) as checkpoint:
        assert [("0", number) in checkpoint for number in range(3)] == [False, True, True]


def test_a_file_cut_in_its_first_line_under_the_run_is_begun_anew(tmp_path):
    whole = written(tmp_path / "c")
    (tmp_path / "c").write_bytes(whole[:12] + whole[ends(tmp_path / "c")[0] :])
    checkpoint = Checkpoint(tmp_path / "c", "work")
    assert (checkpoint.resumed, checkpoint.pieces) == (0, 0)
    checkpoint.close()


def test_a_head_that_a_power_cut_left_as_zeros_starts_anew(tmp_path):
    whole = written(tmp_path / "c")
    (tmp_path / "c").write_bytes(bytes(100) + whole[100:])
    checkpoint = Checkpoint(tmp_path / "c", "work")
    assert (checkpoint.resumed, checkpoint.torn) == (0, len(whole))
    checkpoint.close()


@pytest.mark.parametrize("cut", [False, True])
def test_a_file_that_changes_under_the_run_is_said(tmp_path, cut):
    checkpoint = Checkpoint(tmp_path / "c", "work")
    checkpoint.put("0", 5, np.arange(9.0))
    assert checkpoint.get("0", 5).tolist() == list(range(9))
    data = bytearray((tmp_path / "c").read_bytes())
    data[-5] ^= 1
    (tmp_path / "c").write_bytes(data[: 30 if cut else None])
    with pytest.raises(SceneError, match="0/5 was changed or damaged while the run was at work"):
        checkpoint.get("0", 5)


def line(data: bytes, key: bytes = b"") -> bytes:
    """A line with a right sum of any content; key: of the run that it belongs to."""
    rest = b"0 %s\n" % data
    return b"%08x %s" % (crc32(rest, crc32(key)), rest)


def test_a_line_with_a_name_that_is_none_ends_the_file(tmp_path):
    whole = written(tmp_path / "c")
    for named in ([0, 0, 1], ["0", 0], "x", ["0", 1.0, 1]):
        (tmp_path / "c").write_bytes(whole + line(json.dumps(named).encode(), b"work"))
        checkpoint = Checkpoint(tmp_path / "c", "work")
        assert found(checkpoint) == plain(PIECES)
        assert checkpoint.torn == len(line(json.dumps(named).encode()))
        checkpoint.close()


@pytest.mark.parametrize("data", [b"rpm,label\n700,P(1;1)\n", b"\xff" * 100, line(b'"x"')])
def test_a_file_of_other_content_is_refused_and_left(tmp_path, data):
    (tmp_path / "c").write_bytes(data)
    for attempt in (lambda: Checkpoint(tmp_path / "c", "work"), lambda: key_of(tmp_path / "c")):
        with pytest.raises(SceneError):
            attempt()
    assert (tmp_path / "c").read_bytes() == data


def test_pieces_of_another_key_are_refused_and_a_giant_key_is_not_read(tmp_path):
    before = written(tmp_path / "c")
    for key in ("other", "", "work "):
        with pytest.raises(SceneError):
            Checkpoint(tmp_path / "c", key)
    assert (tmp_path / "c").read_bytes() == before
    assert key_of(tmp_path / "c") == ("work", SHARD)
    with open(tmp_path / "giant", "wb") as file:
        file.write(b"00000000 ")
        file.truncate(1 << 40)  # a file of holes
    with pytest.raises(SceneError):
        key_of(tmp_path / "giant")


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("victim"), os.mkdir])
def test_links_and_pipes_are_not_opened(tmp_path, make):
    (tmp_path / "victim").write_bytes(b"")
    make(tmp_path / "c")
    for attempt in (lambda: Checkpoint(tmp_path / "c", "work"), lambda: key_of(tmp_path / "c")):
        with pytest.raises(OSError, match=r"."):
            attempt()
    assert (tmp_path / "victim").read_bytes() == b""


def test_parts_are_read_and_left_more_than_files_may_be_open(tmp_path):
    import resource

    most = resource.getrlimit(resource.RLIMIT_NOFILE)
    parts = tuple(tmp_path / str(k) for k in range(120))
    before = [written(path, pieces={("0", k): k}) for k, path in enumerate(parts)]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(100, most[0]), most[1]))
    try:
        checkpoint = Checkpoint(tmp_path / "all", "work", parts)
        checkpoint.put("0", 120, 120)
        assert [checkpoint.get("0", k) for k in range(121)] == list(range(121))
        assert checkpoint.resumed == 120
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, most)
    checkpoint.discard()
    assert [path.read_bytes() for path in parts] == before


def test_many_threads_share_one_until_it_is_closed(tmp_path):
    checkpoint = Checkpoint(tmp_path / "c", "work")

    def puts(who: int) -> None:
        for k in range(50):
            checkpoint.put(f"{who}", k, [who, k] * (k % 7))
            assert checkpoint.get(f"{who}", k) == [who, k] * (k % 7)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(puts, range(8)))
        pool.submit(checkpoint.close)
        late = pool.submit(checkpoint.put, "late", 0, 1)
    with pytest.raises(ValueError, match="closed"):
        checkpoint.put("0", 50, 1)
    checkpoint.close()  # once more: what came too late is not written
    resumed = Checkpoint(tmp_path / "c", "work")
    assert (resumed.resumed, resumed.torn) == (400 + (late.exception() is None), 0)


def test_pieces_may_have_any_numbers_in_any_order(tmp_path):
    numbers = [3, 0, 10**18, 70, -2, 5000, *range(1020, 1030), -1, 1, 10**30, 2, 3000]
    path = tmp_path / "pieces"
    with closing(Checkpoint(path, "key")) as checkpoint:
        for turn in (1, 2):  # the second one takes the place of the first
            for number in numbers:
                checkpoint.put("0", number, number * turn)
        checkpoint.put("1", 4000, "of another place")
    tracemalloc.start()
    with closing(Checkpoint(path, "key")) as checkpoint:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < 1 << 20
        assert checkpoint.pieces == len(numbers) + 1
        assert [checkpoint.get("0", number) for number in numbers] == [2 * n for n in numbers]
        others = {*range(-9, 6000), 10**18 - 1, 10**18 + 1, -(10**18), 10**30 + 1} - {*numbers}
        assert not [number for number in others if ("0", number) in checkpoint]
        assert [k for k in range(5000) if ("1", k) in checkpoint] == [4000]


@pytest.mark.parametrize("other", [("1", 0), ("0", 1)], ids=["other place", "other number"])
def test_a_whole_piece_in_the_place_of_another_is_not_taken_for_it(tmp_path, other):
    """As where somebody changes the file of a run that is at work."""
    path = tmp_path / "pieces"
    with closing(Checkpoint(path, "work")) as checkpoint:
        checkpoint.put("0", 0, "a")
        checkpoint.put(*other, "b")
        assert checkpoint.get("0", 0) == "a"  # which writes both
        first, second, end = ends(path)  # where the key ends, and the two pieces
        assert second - first == end - second
        data = path.read_bytes()
        path.write_bytes(data[:first] + data[second:] + data[first:second])
        for name in (("0", 0), other):
            with pytest.raises(SceneError, match="was changed or damaged"):
                checkpoint.get(*name)


@pytest.mark.parametrize("kind", [">f8", ">i8", "<f8", "<i8"])
def test_arrays_of_either_order_of_bytes_keep_their_numbers(kind):
    numbers = unpack(*pack([np.arange(1.0, 4.0).astype(kind)]))[0]
    assert (numbers.tolist(), numbers.dtype.str) == ([1, 2, 3], f"<{kind[1:]}")


@pytest.mark.parametrize("names", [None, ("a",)])
@pytest.mark.parametrize("shape", [["x"], [10**30], [-1], [3], [[]]])
def test_a_whole_record_with_outlines_of_no_array_is_none(names, shape):
    """As of a file that somebody else has made, check sum and all; also where it is read partly."""
    value = {"a": [{"dtype": "<f8", "shape": shape, "at": 0}], "b": 1}
    line = checkpoint_module._record("0", 0, value, 7)
    assert checkpoint_module._parsed(line, b"", 7, names) is None


def test_a_record_whose_arrays_are_longer_than_may_be_read_is_not_read(tmp_path):
    written(tmp_path / "c", {("0", 0): np.arange(50.0)})
    begin, end = ends(tmp_path / "c")
    with open(tmp_path / "c", "rb") as file:
        reader = checkpoint_module._Reader(file)
        reader.record_at(0, 1 << 20)
        assert reader.record_at(begin, 400).end == end  # 50 numbers of 8 bytes
        assert reader.record_at(begin, 399) is None


def test_a_file_is_closed_where_an_interrupt_comes_as_it_is_read(tmp_path, monkeypatch):
    written(tmp_path / "c")
    opened = []
    open_pieces = checkpoint_module.open_pieces

    def note(*given):
        opened.append(open_pieces(*given))
        return opened[-1]

    def interrupt(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(checkpoint_module, "open_pieces", note)
    monkeypatch.setattr(checkpoint_module, "records", interrupt)
    with pytest.raises(KeyboardInterrupt):
        Checkpoint(tmp_path / "c", "work")
    assert [file.closed for file in opened] == [True, True]


def test_behind_a_damaged_record_the_next_one_begins_where_its_arrays_end(tmp_path):
    """Also where nothing more may be searched for: the line of the damaged one tells its size."""
    path = tmp_path / "pieces"
    with closing(Checkpoint(path, "work")) as checkpoint:
        checkpoint.put("0", 0, {"first": np.arange(50.0)})
        checkpoint.put("0", 1, {"second": np.arange(9.0)})
    marks = ends(path)
    data = bytearray(path.read_bytes())
    data[marks[1] - 8] ^= 1  # in the arrays of the first
    path.write_bytes(data)
    with open(path, "rb") as file:
        reader = checkpoint_module._Reader(file)
        reader.record_at(0, 1 << 20)
        assert reader.record_at(marks[0], 1 << 20) is None
        reader._left = 0
        record = reader.first_behind(marks[0])
    assert (record.place, record.number, record.begin) == ("0", 1, marks[1])
