"""What is kept and told of a piece that raised what nobody foresaw."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace as Stub

import pytest

from camcli import piece_faults
from camcli.cams.decimals import exact
from camcli.errors import CamError
from camcli.parallel import Codec, Work
from camcli.piece_faults import (
    PieceFault,
    attempt,
    fault_records,
    gather,
    gathering,
    is_foreseen,
    piece,
)

HERE = Path(__file__).name


def raised(error: Exception) -> PieceFault:
    def fails():
        raise error

    fault = attempt("the piece", fails)
    assert isinstance(fault, PieceFault)
    return fault


def test_the_place_of_a_fault_is_the_innermost_line_of_this_package():
    """Of `decimals`, though it is raised by what that calls; without any, where it was raised."""
    fault = attempt("the piece", lambda: exact(Stub()))
    assert isinstance(fault, PieceFault)
    assert fault.piece == "the piece"
    assert fault.place.startswith("camcli/cams/decimals.py:")
    assert fault.place.endswith(", exact")
    text = fault.traceback
    assert text.startswith("Traceback (most recent call last):")
    assert HERE in text
    assert text.rstrip().endswith(fault.error)


def test_of_a_long_traceback_the_innermost_frames_are_kept():
    def falls(depth):
        return falls(depth - 1) if depth else 1 / 0

    def begins():
        return falls(piece_faults.FRAMES + 20)

    text = attempt("the piece", begins).traceback
    assert "return falls(depth - 1) if depth else 1 / 0" in text
    assert "in begins" not in text


@pytest.mark.parametrize(
    ("error", "told"),
    [(ZeroDivisionError("by zero"), "ZeroDivisionError: by zero"),
     (ZeroDivisionError(), "ZeroDivisionError"), (KeyError("a: "), "KeyError: 'a: '")],
)  # fmt: skip
def test_an_error_is_told_by_its_kind_and_message(error, told):
    fault = raised(error)
    assert fault.error == told
    assert fault.place.startswith("camcli/piece_faults.py:")
    assert fault.place.endswith(", attempt")


@pytest.mark.parametrize(
    ("error", "foreseen"),
    [
        (CamError("x"), True), (OSError("x"), True), (FileNotFoundError("x"), True),
        (MemoryError(), True), (ImportError("x"), True), (ModuleNotFoundError("x"), True),
        (RuntimeError("can't start new thread"), True),
        (RuntimeError("x.so: failed to map segment from shared object"), True),
        (RuntimeError("x"), False), (ValueError("x"), False), (AssertionError(), False),
    ],
)  # fmt: skip
def test_what_is_foreseen_ends_the_run(monkeypatch, error, foreseen):
    assert is_foreseen(error) is foreseen

    def fails():
        raise error

    if foreseen:
        with gathering(), pytest.raises(type(error)):
            piece("a", fails)
    else:
        monkeypatch.setattr(piece_faults, "signal_came", lambda: True)
        with pytest.raises(type(error)):  # whatever a library makes of a signal
            attempt("a", fails)


def test_a_piece_that_fails_is_gathered_by_the_innermost_gathering():
    def fails():
        raise ValueError("x")

    with pytest.raises(ValueError, match="x"):
        piece("without", fails, instead=1)
    with gathering() as outer:
        assert piece("first", fails, instead="instead") == "instead"
        with gathering() as inner:
            assert piece("inner", fails) is None
            assert piece("whole", lambda: 5, instead=6) == 5
        gather([Stub(piece="given")])
        assert piece("last", fails, instead=[]) == []
    assert [fault.piece for fault in outer] == ["first", "given", "last"]
    assert [fault.piece for fault in inner] == ["inner"]
    gather([Stub(piece="nobody gathers it")])
    assert len(outer) == 3


def test_faults_of_one_kind_at_one_place_are_one_record():
    """The first of them is shown whole, the pieces of all are named."""

    def of(name, error="ValueError: 1", place="a.py:1, f"):
        return PieceFault(name, error, place, f"Traceback of {name}")

    faults = [of("p"), of("q", "ValueError: 2"), of("r", place="a.py:2, f"),
              of("s", "KeyError: 1"), of("t", "ValueError: 3")]  # fmt: skip
    assert fault_records(faults) == [
        {"pieces": pieces, "error": first.error, "place": first.place,
         "traceback": first.traceback}
        for pieces, first in ((["p", "q", "t"], faults[0]), (["r"], faults[2]), (["s"], faults[3]))
    ]  # fmt: skip
    assert fault_records([]) == []


class Disk:
    """A checkpoint in memory: what is kept by place and piece."""

    def __init__(self):
        self.kept = {}

    def __contains__(self, key):
        return key in self.kept

    def put(self, place, k, values):
        self.kept[place, k] = values

    def get(self, place, k, names=None):
        return self.kept[place, k]

    def expected_size(self, count, beside):
        return 0

    def path_of(self, place, k):
        return Path("a")


def odd_fails(result) -> list:
    return [f"fault of {result}"] if result % 2 else []


CODEC = Codec(lambda x: x, lambda x: x, faults=odd_fails)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_result_with_a_fault_is_not_kept_and_neither_is_what_is_asked_for_after_it(threads):
    """In other calls of its place, which may depend on it; other places go on as they were."""
    disk = Disk()
    work = Work(threads=threads, checkpoint=disk)
    elsewhere = work.within("elsewhere")
    assert list(work.run(lambda x: x, [0, 1, 2], CODEC)) == [0, 1, 2]
    assert disk.kept == {("0", 0): 0, ("0", 2): 2}
    assert (work.faults, work.failed) == (["fault of 1"], True)
    assert list(work.collect(lambda x: x, [4, 6], CODEC)) == [4, 6]
    assert list(elsewhere.run(lambda x: x, [8, 10], CODEC)) == [8, 10]
    assert disk.kept == {
        ("0", 0): 0, ("0", 2): 2, ("elsewhere/0", 0): 8, ("elsewhere/0", 1): 10,
    }  # fmt: skip
    assert not elsewhere.failed
    again = Work(threads=threads, checkpoint=disk)
    asked = []
    assert list(again.run(lambda x: asked.append(x) or x, [0, 1, 2], CODEC)) == [0, 1, 2]
    assert asked == [1]  # it is tried again
    assert again.faults == ["fault of 1"]


@pytest.mark.parametrize("room", [0, -1])
def test_in_a_chain_nothing_behind_a_fault_is_kept(room):
    """Each result is that of the one before and of its piece: 0, 2, 5 with a fault, 9, 14.

    Without room for all in memory, they come from there and from disk.
    """
    disk = Disk()
    work = Work(checkpoint=disk, in_memory=room)
    found = work.collect_chain(lambda before, x: before + x, 0, [0, 2, 3, 4, 5], CODEC)
    assert list(found) == [0, 2, 5, 9, 14]
    assert disk.kept == {("0", 0): 0, ("0", 1): 2}
    assert work.faults == ["fault of 5", "fault of 9"]
