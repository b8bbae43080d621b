"""What is asked of the process that draws, and when, with a helper made by hand."""

from __future__ import annotations

import gc
import warnings
from types import SimpleNamespace as Stub

import pytest

from camcli.output import drawing_process as drawing
from camcli.output.drawing_process import DrawingProcess, DrawingTask, draw
from camcli.parallel.helpers import HelperFailedError


class Helper:
    """A process that draws whatever it is asked for, in capital letters."""

    def __init__(self, fails_in: str = ""):
        self.told: list = []
        self.fails_in = fails_in

    def _do(self, what: str, *more) -> None:
        self.told.append((what, *more))
        if what == self.fails_in:
            raise HelperFailedError

    def wait_until_ready(self):
        self._do("wait")

    def call(self, function, *given):
        self._do("call", function, *given)

    def ask(self, function, task):
        assert function is draw
        self._do("ask", task)

    def answer(self):
        self._do("answer")
        return [task for what, *tasks in self.told if what == "ask" for task in tasks][-1].upper()

    def end(self):
        self._do("end")

    def let_go(self):
        self._do("let go")

    @property
    def asked(self) -> list[str]:
        return [entry[1] for entry in self.told if entry[0] == "ask"]


def process_of(monkeypatch, helper: Helper) -> DrawingProcess:
    monkeypatch.setattr(drawing, "Helper", lambda: helper)
    process = DrawingProcess(["some.module"])
    process._ready.wait(10.0)
    return process


def test_pictures_are_drawn_one_after_the_other_in_their_order(monkeypatch):
    helper = Helper()
    process = process_of(monkeypatch, helper)
    prepared = ("call", drawing.prepare, ["some.module"], gc.get_threshold())
    assert helper.told == [("wait",), prepared]
    process.begin(["a", "b", "c"])
    assert helper.asked == ["a"]
    assert process.next_drawn() == "A"
    assert helper.asked == ["a", "b"]  # it is at work while this one is written
    assert [process.next_drawn() for _ in range(3)] == ["B", "C", None]
    process.begin(["d"])
    process.let_go()
    assert [entry[0] for entry in helper.told[-2:]] == ["ask", "end"]
    assert process.next_drawn() is None


def test_a_process_with_nothing_to_do_is_let_go_and_one_that_is_late_is_asked_later(monkeypatch):
    helper = Helper()
    process = process_of(monkeypatch, helper)
    process.let_go()
    assert helper.told[-1] == ("let go",)
    process.end()
    assert helper.told[-1] == ("let go",)
    late = Helper()
    process = process_of(monkeypatch, late)
    limits = []
    process._ready = Stub(wait=limits.append)  # it gives nothing: not ready within any limit
    process.begin(["a"])
    assert (late.asked, limits) == ([], [drawing.PATIENCE])
    process._ready = Stub(wait=lambda: True)
    assert process.next_drawn() == "A"


@pytest.mark.parametrize("fails_in", ["ask", "answer"])
def test_a_process_that_fails_draws_no_more(monkeypatch, fails_in):
    helper = Helper(fails_in)
    process = process_of(monkeypatch, helper)
    process.begin(["a", "b"])
    assert process.next_drawn() is None
    assert (helper.asked, helper.told[-1]) == (["a"], ("end",))
    assert process.next_drawn() is None


def test_a_process_that_cannot_import_what_draws_is_ready_all_the_same(monkeypatch):
    """It fails again in what it is asked for."""
    process = process_of(monkeypatch, Helper("call"))
    assert process._ready.is_set()


@pytest.mark.parametrize("error", [OSError, TypeError])
def test_a_process_that_cannot_be_started_draws_nothing(monkeypatch, error):
    def none():
        raise error

    monkeypatch.setattr(drawing, "Helper", none)
    process = DrawingProcess([])
    process.begin(["a"])
    assert process.next_drawn() is None
    process.let_go()


def test_what_draws_is_imported_without_its_lists_of_properties(monkeypatch):
    from matplotlib import artist

    whole = artist.kwdoc
    seen = []

    def import_module(name):
        seen.append((name, artist.kwdoc(None)))
        if name == "b":
            raise ValueError

    monkeypatch.setattr(drawing, "import_module", import_module)
    monkeypatch.setattr(gc, "set_threshold", lambda *numbers: seen.append(numbers))
    drawing.prepare(["a", "b", "c"], (5, 6, 7))
    assert seen == [(5, 6, 7), ("a", ""), ("b", ""), ("c", "")]
    assert artist.kwdoc is whole


def test_a_drawn_picture_has_its_bytes_and_what_was_told_of_it(monkeypatch):
    def write_picture(picture, file, kind, form):
        file.write(f"{picture} {kind} {form.font}".encode())
        warnings.warn("no such glyph", stacklevel=1)
        return ["gap"]

    monkeypatch.setattr("camcli.output.pictures.write_picture", write_picture)
    found = draw(DrawingTask(lambda: "orbit", "svg", Stub(font="Serif")))
    assert found == (b"orbit svg Serif", ["gap"], ["no such glyph"])
