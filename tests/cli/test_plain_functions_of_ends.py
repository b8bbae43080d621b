"""How a command ends, function by function: codes, faults, streams, and what could never fit."""

from __future__ import annotations

import errno
import json
import os
import sys
from io import BytesIO, TextIOWrapper
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

from camcli.api.command import Command, Drawing, Size
from camcli.cli import exit_codes, sizes
from camcli.cli.exit_codes import DONE, INTERNAL, INTERRUPTED, USAGE
from camcli.errors import Fault, SceneError
from camcli.parallel import Shard
from camcli.scene.schema import Plot

ONE = Fault("a", "b", "found c", "expected d", "do e")
TWO = Fault("", "f", "found g", "", "")


class ParserError(Exception):
    """An error of the option parser."""

    exit_code = 2

    def __init__(self, text: str, *options: str) -> None:
        super().__init__(text)
        params = [Made(opts=[name, f"--long{name}"]) for name in options]
        self.ctx = Made(command=Made(params=params))

    def format_message(self) -> str:
        return self.args[0]


class NoArgsIsHelpError(ParserError):
    """A command without any word."""


class Exit(Exception):  # noqa: N818
    """The end of a command with a code of its own."""

    exit_code = 3


class Abort(Exception):  # noqa: N818
    """The option parser was interrupted."""


def raises(error: BaseException):
    def call() -> None:
        raise error

    return call


@pytest.fixture
def ended(monkeypatch, capsys):
    """A guarded call: its code, what it printed and said, and whether it was an interrupt."""

    def of(call, as_json=False, signal=False):
        arrived = []
        monkeypatch.setattr(exit_codes, "signal_came", lambda: signal)
        monkeypatch.setattr(exit_codes, "interrupt_arrived", lambda: arrived.append(1))
        code = exit_codes.guarded(call, as_json)
        said = capsys.readouterr()
        assert len(arrived) == (code == INTERRUPTED)
        return code, said.out, said.err

    return of


@pytest.mark.parametrize(
    ("call", "signal", "code", "said"),
    [
        (lambda: 3, False, 3, ""), (lambda: None, False, DONE, ""), (lambda: "x", True, DONE, ""),
        (lambda: INTERRUPTED, False, INTERRUPTED, "interrupted\n"),
        (raises(SystemExit(7)), False, 7, ""), (raises(SystemExit()), False, DONE, ""),
        (raises(SystemExit("x")), False, DONE, ""),
        (raises(SceneError(ONE, TWO)), True, USAGE,
         "a: b: found c, expected d, do e\nf: found g\n"),
        (raises(KeyboardInterrupt()), False, INTERRUPTED, "interrupted\n"),
        (raises(Exit()), False, 3, ""), (raises(Exit()), True, INTERRUPTED, "interrupted\n"),
        (raises(Abort()), False, INTERRUPTED, "interrupted\n"),
        (raises(KeyError("x")), True, INTERRUPTED, "interrupted\n"),
        (raises(OSError(errno.EACCES, "no", "x")), False, USAGE,
         "cam: x: no, see what the system allows, then repeat the command\n"),
    ],
)  # fmt: skip
def test_how_a_call_ends(ended, call, signal, code, said):
    """An error of a library after a signal is an interrupt; a refusal stays one."""
    assert ended(call, signal=signal) == (code, "", said)


def test_faults_are_an_object_for_a_program(ended):
    def call():
        print("said before")
        raise SceneError(ONE, TWO)

    code, out, _ = ended(call, True)
    before, _, answer = out.partition("\n")
    keys = ("where", "path", "found", "expected", "cure")
    faults = [dict(zip(keys, texts, strict=True)) for texts in (
        ("a", "b", "found c", "expected d", "do e"), ("", "f", "found g", "", ""))]  # fmt: skip
    assert (before, json.loads(answer)) == ("said before", {"exit_code": code, "faults": faults})
    assert ended(lambda: 3, True) == (3, "", "")
    interrupted = json.loads(ended(raises(KeyboardInterrupt()), True)[1])
    assert (interrupted["exit_code"], interrupted["faults"][0]["found"]) == (130, "interrupted")


EXTRA = "Got unexpected extra argument"


@pytest.mark.parametrize(
    ("error", "cure"),
    [
        (ParserError(f"{EXTRA} (my.yaml)", "-x", "-c"), "did you mean -c my.yaml?"),
        (ParserError(f"{EXTRA}s (my.YML b)", "-c"), "did you mean -c my.YML?"),
        (ParserError(f"{EXTRA} (my.json)", "-c"), "did you mean -c my.json?"),
        (ParserError(f"{EXTRA} (my.yaml)", "-x"), ""),
        (ParserError(f"{EXTRA} (my.yaml)", "--cells"), ""),
        (ParserError(f"{EXTRA} (7.yaml)"), "give a speed or a range as --rpm 7.yaml"),
        (ParserError(f"{EXTRA}s (600:700 b c)", "-c"), "give a speed or a range as --rpm 600:700"),
        (ParserError(f"{EXTRA} (.5)", "-c"), "give a speed or a range as --rpm .5"),
        (ParserError(f"{EXTRA} (-7)", "-c"), ""),
        (ParserError(f"{EXTRA} (my.csv)", "-c"), ""),
        (ParserError("No such option: my.yaml", "-c"), ""),
    ],
)
def test_what_was_probably_meant_by_words_that_are_refused(error, cure):
    code, faults = exit_codes.failure(error)
    assert (code, faults) == (USAGE, [Fault("cam", "", error.args[0], "", cure)])
    del error.ctx
    assert not exit_codes._takes_a_scene(error)


def test_the_code_of_a_failure(capsys, monkeypatch):
    assert exit_codes.failure(NoArgsIsHelpError("the help")) == (USAGE, [])
    assert capsys.readouterr().err == "the help\n"
    assert exit_codes.failure(Exit()) == (3, [])
    assert exit_codes.failure(Abort()) == (INTERRUPTED, [])
    code, (fault,) = exit_codes.failure(OSError("odd"))
    cure = "see what the system allows, then repeat the command"
    assert (code, fault) == (USAGE, Fault("cam", "", "odd", "", cure))
    code, (fault,) = exit_codes.failure(KeyError("\x1b" + "x" * 250))
    assert (code, fault.where, fault.path) == (INTERNAL, "cam", "")
    text = "KeyError: '\\x1b" + "x" * 250
    assert fault.found == f"internal fault: {text[:197]}... ()"
    monkeypatch.setenv("CAMCLI_TRACEBACK", "1")
    with pytest.raises(KeyError):
        exit_codes.failure(KeyError("x"))
    assert exit_codes.failure(MemoryError())[0] == USAGE


def test_a_note_that_nobody_reads_is_dropped(monkeypatch):
    dropped = []
    monkeypatch.setattr(exit_codes, "_to_nowhere", dropped.append)

    def fails(text):
        raise BrokenPipeError

    stream = Made(isatty=lambda: False, write=fails, flush=lambda: None)
    monkeypatch.setattr(sys, "stderr", stream)
    exit_codes.note("x")
    assert dropped == [stream]


@pytest.mark.parametrize(
    ("errors", "lenient"),
    [
        (None, "backslashreplace"), ("strict", "backslashreplace"), ("ignore", "ignore"),
        ("surrogateescape", exit_codes.BYTES_OR_ESCAPES),
    ],
)  # fmt: skip
def test_how_a_stream_writes_what_its_encoding_lacks(errors, lenient):
    assert exit_codes._lenient(errors) == lenient


def test_letters_that_stand_for_bytes_are_those_bytes():
    def written(text, at):
        return exit_codes._bytes_or_escapes(UnicodeEncodeError("ascii", text, at, len(text), "no"))

    assert written("ab\udc80c", 2) == (b"\x80", 3)
    assert written("\udcff\udc80", 0) == (b"\xff", 1)
    assert written("a\udc7f", 1) == (b"\\udc7f", 2)
    assert written("\udd00x", 0) == (b"\\udd00", 1)
    assert written("\u00e9\udc80", 0) == (b"\\xe9", 1)
    error = UnicodeDecodeError("ascii", b"\xff", 0, 1, "no")
    with pytest.raises(UnicodeDecodeError):
        exit_codes._bytes_or_escapes(error)


class Screen(TextIOWrapper):
    """A stream that a person watches."""

    def isatty(self) -> bool:
        return True


def test_output_is_held_unless_a_person_watches(monkeypatch):
    real = TextIOWrapper(BytesIO(), encoding="ascii", errors="strict")
    monkeypatch.setattr(sys, "stdout", real)
    exit_codes.hold_output()
    held = sys.stdout
    assert (held.real, held.encoding, held.errors) == (real, "ascii", "backslashreplace")
    screen = Screen(BytesIO(), encoding="ascii", errors="strict")
    monkeypatch.setattr(sys, "stdout", screen)
    exit_codes.hold_output()
    assert (sys.stdout, screen.errors) == (screen, "backslashreplace")
    error_stream = sys.stderr
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    exit_codes.hold_output()
    streams = sys.stdout, sys.stderr
    monkeypatch.setattr(sys, "stderr", error_stream)
    for stream in streams:
        assert (stream.name, stream.mode) == (os.devnull, "w")
        stream.close()


@pytest.mark.parametrize("error", [None, BrokenPipeError(), OSError(errno.ENOSPC, "no room")])
def test_what_was_held_is_let_go_once(monkeypatch, error):
    """A reader that has left is no fault; another one is told, and drops what follows."""
    dropped, written = [], []

    def write(data):
        written.append(bytes(data))
        if error is not None:
            raise error

    real = Made(encoding="utf-8", errors="strict", flush=lambda: None, buffer=Made(write=write))
    held = exit_codes.Held(real)
    monkeypatch.setattr(exit_codes, "_to_nowhere", dropped.append)
    monkeypatch.setattr(sys, "stdout", held)
    held.write("one")
    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        with pytest.raises(SceneError) as told:
            exit_codes._release()
        assert str(told.value) == (
            "stdout: could not be written (no room), the artefacts are complete"
        )
    else:
        exit_codes._release()
    assert dropped == [real] * (error is not None)
    error = None
    held.write("2")
    exit_codes._release()
    assert written == [b"one", b"2"]


# --- what could never fit


def test_the_disk_of_a_folder_that_is_not_there_is_that_of_the_nearest_one(tmp_path, monkeypatch):
    asked = []

    def usage(folder):
        asked.append(folder)
        return Made(total=9, used=1, free=7)  # the rest is not for us

    monkeypatch.setattr("shutil.disk_usage", usage)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").mkdir()
    for folder in ("a", "a/b/c", "x" * 300, "/"):
        assert sizes.free_disk(Path(folder)) == 7.0
    assert asked == [tmp_path / "a", tmp_path / "a", tmp_path, Path("/")]

    def fails(folder):
        raise OSError

    monkeypatch.setattr("shutil.disk_usage", fails)
    assert sizes.free_disk(tmp_path) == float("inf")


def test_the_pixels_of_a_picture_are_those_of_its_style(monkeypatch):
    """100 mm x 50.8 mm are 100/25.4 x 2 inches; without a height a page is 230 mm high."""
    monkeypatch.setattr("camcli.plots.style.dpi_of", {"coarse": 10.0, "fine": 1000.0}.get)

    def pixels(**plot):
        return sizes._pixels(Plot.model_construct(**{"height": None, "style": None, **plot}))

    assert pixels(width=100.0, height=50.8) == pytest.approx(100.0 / 25.4 * 2.0 * 300.0**2)
    assert pixels(width=100.0, height=50.8, style="coarse") == pytest.approx(78740.15748 / 100.0)
    assert pixels(width=25.4, style="fine") == pytest.approx(230.0 / 25.4 * 1e6)
    asked = Made(
        plot=Plot.model_construct(width=100.0, height=50.8, style="fine", formats=("png",))
    )
    drawing = Drawing(file=2e5, memory=1e8, per_pixel=5.0)
    command = Command(run=sizes.in_words, size=None, drawing=lambda scene: drawing)
    more = 100.0 / 25.4 * 2.0 * 1e6 - sizes._pixels(Plot())
    assert sizes.drawing_of(command, asked) == (
        pytest.approx(1e8 + 5.0 * more), pytest.approx(2e5 + 0.01 * more)
    )  # fmt: skip


def test_a_refusal_says_what_there_is_and_what_helps(monkeypatch):
    """Of 1.25 GB a run may have 80 %; a shard of three needs a third of the pieces."""
    monkeypatch.setattr(sizes, "memory", lambda: 1.25e9)
    monkeypatch.setattr(sizes, "free_disk", lambda folder: 123.0e6)
    size = Size(what="7 cells", pieces=1, orbits=1, turns=0.0, rows=0, memory=1.5e9, tables=1e9,
                kept=0.6e9)  # fmt: skip
    drawing = Drawing(file=1.0, memory=2.5e9, per_pixel=0.0)

    def run():
        """A command's function, which is never called."""

    command = Command(run=run, size=lambda scene: size, drawing=lambda scene: drawing)
    scene = Made(plot=Plot())

    def said(**more):
        with pytest.raises(SceneError) as refused:
            sizes.refuse_too_large(command, scene, Path("o"), **more)
        return str(refused.value).splitlines()

    of_memory = (
        "run: found 7 cells, at least 1.5 GB of memory, expected at most 1 GB, 80% of this "
        "machine's, ask for fewer"
    )
    of_disk = "expected at most 123 MB, free on the disk of o, ask for fewer, or choose another -o"
    assert said() == [
        of_memory,
        "run: found 7 cells, at least 2.5 GB of memory to draw, expected at most 1 GB, 80% of "
        "this machine's, draw smaller: plot.width, plot.height, or the dpi of plot.style",
        f"run: found 7 cells, at least 1.6 GB of files, {of_disk}",
    ]
    assert said(shard=Shard(1, 3)) == [
        of_memory, f"run: found 7 cells, at least 200 MB of files, {of_disk}"
    ]  # fmt: skip
