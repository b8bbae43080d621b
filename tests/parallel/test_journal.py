"""The file of finished pieces: torn, damaged, foreign, on a full disk."""

import errno
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camcli.parallel.codec import pack
from camcli.parallel.journal import HEAD, MAGIC, Journal, JournalError, header_of, one_of, records

PIECES = {"0/0": [1, 0.1, None], "0/1": "text", "range/0/2": [], "end": [3, 4]}


def written(path, header="work", pieces=PIECES) -> bytes:
    journal = Journal(path, header)
    for name, value in pieces.items():
        journal.put(name, value)
    journal.close()
    return path.read_bytes()


def ends(path) -> list[int]:
    with open(path, "rb", buffering=0) as file:
        return [end for *_, end in records(file)]


def test_what_was_put_is_there_again(tmp_path):
    written(tmp_path / "j")
    journal = Journal(tmp_path / "j", "work")
    assert {name: journal.get(name) for name in journal.index} == PIECES
    assert (journal.found, journal.torn) == (4, 0)
    assert "0/7" not in journal
    with pytest.raises(KeyError):
        journal.get("0/7")
    journal.put("0/0", 2)
    assert journal.get("0/0") == 2
    journal.discard()
    assert not (tmp_path / "j").exists()


def test_torn_at_every_byte_all_whole_pieces_stay(tmp_path):
    whole, path = written(tmp_path / "whole"), tmp_path / "torn"
    marks = ends(tmp_path / "whole")
    for size in range(len(whole) + 1):
        path.write_bytes(whole[:size])
        journal = Journal(path, "work")
        pieces = max(0, sum(mark <= size for mark in marks) - 1)
        assert list(journal.index) == list(PIECES)[:pieces]
        assert all(journal.get(name) == PIECES[name] for name in journal.index)
        assert journal.torn == size - max((m for m in marks if m <= size), default=0)
        for name in list(PIECES)[pieces:]:
            journal.put(name, PIECES[name])
        journal.close()
        assert path.read_bytes() == whole


def test_a_flipped_bit_costs_its_piece_and_those_behind_it(tmp_path):
    whole, path = written(tmp_path / "whole"), tmp_path / "flipped"
    marks = ends(tmp_path / "whole")
    for at in range(len(whole) * 8):
        damaged = bytearray(whole)
        damaged[at // 8] ^= 1 << at % 8
        path.write_bytes(damaged)
        before = sum(mark * 8 <= at for mark in marks)
        if before == 0:  # not known to be ours: left as it is
            with pytest.raises(JournalError):
                Journal(path, "work")
            assert path.read_bytes() == damaged
            continue
        journal = Journal(path, "work")
        assert list(journal.index) == list(PIECES)[: before - 1]
        journal.close()


def test_no_length_can_move_between_name_and_payload(tmp_path):
    written(tmp_path / "j", pieces={"0/1": 23})
    data = bytearray((tmp_path / "j").read_bytes())
    at = ends(tmp_path / "j")[0]
    magic, label, size, check = HEAD.unpack_from(data, at)
    HEAD.pack_into(data, at, magic, label + 1, size - 1, check)
    (tmp_path / "j").write_bytes(data)
    assert list(Journal(tmp_path / "j", "work").index) == []


@pytest.mark.parametrize(
    "data",
    [b"rpm,label\n700,P(1;1)\n", b"\0" * 100, HEAD.pack(MAGIC, 0, 1 << 60, 0)],
    ids=["table", "zeros", "giant"],
)
def test_a_file_that_is_no_journal_is_refused_and_left(tmp_path, data):
    (tmp_path / "j").write_bytes(data)
    for attempt in (lambda: Journal(tmp_path / "j", "work"), lambda: header_of(tmp_path / "j")):
        with pytest.raises(JournalError):
            attempt()
    assert (tmp_path / "j").read_bytes() == data


def test_other_work_is_refused_and_left(tmp_path):
    before = written(tmp_path / "j")
    for header in ("other", "", "work "):
        with pytest.raises(JournalError):
            Journal(tmp_path / "j", header)
    assert (tmp_path / "j").read_bytes() == before
    assert header_of(tmp_path / "j") == "work"


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200), st.booleans())
def test_hostile_bytes_are_refused_in_words(tmp_path_factory, data, valid):
    path = tmp_path_factory.getbasetemp() / "hostile"
    path.write_bytes(framed("", data) if valid else data)
    try:
        header = header_of(path)
    except JournalError:
        header = None
    assert header is None or isinstance(header, str)
    one_of(path, "end")


def framed(name: str, payload: bytes) -> bytes:
    """A record with a right checksum around any bytes."""
    from zlib import crc32

    label = name.encode()
    head = HEAD.pack(MAGIC, len(label), len(payload), 0)[:-4]
    check = crc32(payload, crc32(label, crc32(head)))
    return head + check.to_bytes(4, "little") + label + payload


def test_a_giant_header_is_not_read(tmp_path):
    path = tmp_path / "giant"
    with open(path, "wb") as file:
        file.write(HEAD.pack(MAGIC, 0, 1 << 40, 0))
        file.truncate((1 << 40) + HEAD.size)  # a file of holes
    with pytest.raises(JournalError):
        header_of(path)
    path.unlink()


def test_framed_is_what_the_journal_writes(tmp_path):
    assert written(tmp_path / "j", pieces={"a": 1}) == framed("", pack("work")) + framed(
        "a", b"1\n"
    )


class Full:
    """A file on a disk that is full after so many bytes; a write is cut there, the next fails."""

    def __init__(self, file, room: int):
        self.file, self.room = file, room

    def __getattr__(self, name):
        return getattr(self.file, name)

    def write(self, data) -> int:
        if self.room == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        some = data[: self.room]
        self.room -= len(some)
        return self.file.write(some)


def test_full_disk_at_every_byte_leaves_whole_pieces_and_goes_on(tmp_path):
    size = len(written(tmp_path / "whole", pieces={"0/0": "x" * 20}))
    head = ends(tmp_path / "whole")[0]
    for room in range(size - head):
        path = tmp_path / f"full{room}"
        journal = Journal(path, "work")
        journal._file = Full(journal._file, room)
        with pytest.raises(OSError, match="No space"):
            journal.put("0/0", "x" * 20)
        assert path.stat().st_size == head
        assert "0/0" not in journal
        journal._file.room = 1000
        journal.put("0/0", "x" * 20)
        journal.close()
        assert path.read_bytes() == (tmp_path / "whole").read_bytes()


def test_parts_are_read_and_left(tmp_path):
    one = written(tmp_path / "1", pieces={"0/0": 1, "0/2": 3})
    written(tmp_path / "2", pieces={"0/1": 2, "0/3": 4})
    journal = Journal(tmp_path / "all", "work", (tmp_path / "1", tmp_path / "2"))
    journal.put("0/4", 5)
    assert [journal.get(f"0/{k}") for k in range(5)] == [1, 2, 3, 4, 5]
    assert journal.found == 4
    journal.discard()
    assert (tmp_path / "1").read_bytes() == one
    (tmp_path / "3").write_bytes(b"")
    for wrong in ("3", "4"):
        with pytest.raises((JournalError, OSError)):
            Journal(tmp_path / "all", "work", (tmp_path / wrong,))
    assert not (tmp_path / "all").exists()


def test_more_parts_than_files_may_be_open(tmp_path):
    import resource

    most = resource.getrlimit(resource.RLIMIT_NOFILE)
    paths = tuple(tmp_path / str(k) for k in range(120))
    for k, path in enumerate(paths):
        written(path, pieces={f"0/{k}": k})
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(100, most[0]), most[1]))
    try:
        journal = Journal(tmp_path / "all", "work", paths)
        assert [journal.get(f"0/{k}") for k in range(120)] == list(range(120))
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, most)


def test_many_threads_one_file(tmp_path):
    journal = Journal(tmp_path / "j", "work")

    def puts(who: int) -> None:
        for k in range(200):
            journal.put(f"{who}/{k}", [who, k] * (k % 7))
            assert journal.get(f"{who}/{k}") == [who, k] * (k % 7)

    threads = [threading.Thread(target=puts, args=(who,)) for who in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    journal.close()
    again = Journal(tmp_path / "j", "work")
    assert (again.found, again.torn) == (1600, 0)
    assert again.get("3/6") == [3, 6] * 6


def test_nothing_is_put_after_the_end(tmp_path):
    journal = Journal(tmp_path / "j", "work")
    journal.close()
    with pytest.raises(ValueError, match="closed"):
        journal.put("0/0", 1)
