"""Signals while a command is at work: none is lost, and every command ends soon."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from camcli import interrupts
from tests.support.long_runs import begin, command, ended, files

SOME = {
    "one long piece": "sweep --rpm 745 --set run.transient=100000000",
    "explain": "sweep --rpm 735:745 --points 4000 --explain",
}
ALL = {
    **SOME,
    "many pieces": "sweep --points 100001",
    "cells": "basins --cells 4000 --set basins.budget=100000 --rpm 739.35",
    "one orbit": "simulate --rpm 745 --set run.transient=1000000000",
    "detach": "detach --rpm 110:2000 --points 100000",
    "classify": "classify --rpm 740:745 --points 1000",
    "orbits": "orbits --rpm 340:760 --label P(9;1:1:1:1:1:1:1:1:7) --set run.transient=5000000",
}
BOTH = signal.SIGINT, signal.SIGTERM


@pytest.mark.slow
@pytest.mark.parametrize(
    ("signals", "lines"),
    [(BOTH, SOME), *(pytest.param(b, ALL, marks=pytest.mark.soak) for b in (BOTH, BOTH[::-1]))],
)
def test_a_signal_ends_what_would_take_minutes(tmp_path, signals, lines):
    """All at once, one signal to every second one."""
    running = []
    for name, line in lines.items():
        (tmp_path / name).mkdir()
        words = command(*line.split(), "--no-plot", "-o", "out")
        running.append(begin(words, tmp_path / name))
    time.sleep(0.5 + 1.2 * len(lines))
    for n, (name, process) in enumerate(zip(lines, running, strict=True)):
        assert process.poll() is None, name
        process.send_signal(signals[n % 2])
    for name, process in zip(lines, running, strict=True):
        said = process.communicate(timeout=20)[1]  # a second, where the machine is not busy
        seen = process.returncode, said.count("interrupted"), "Traceback" in said
        assert seen == (130, 1, False), (name, said)
        assert files(tmp_path / name / "out") == {}


SWALLOWING = """
import os, signal
from camcli.cli import exit_codes
from camcli.cli.app import main
from camcli.parallel.work import Kept
real, said = Kept.put, exit_codes.note
def put(*args):
    try:
        os.kill(os.getpid(), signal.SIGINT)
        sum(range(100))
    except KeyboardInterrupt:
        pass
    return real(*args)
def note(text):
    os.kill(os.getpid(), signal.SIGINT)  # once more, while the end is told
    said(text)
Kept.put, exit_codes.note = put, note
main()
"""


@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_signal_that_a_library_swallows_is_seen_at_the_next_piece(tmp_path, threads):
    words = ("sweep", "--points", "50", "--no-plot", "--threads", threads)
    code, said = ended(begin([sys.executable, "-c", SWALLOWING, *words], tmp_path))
    assert (code, "interrupted" in said) == (130, True), said


def test_a_signal_that_a_library_makes_another_error_of_is_an_interrupt(tmp_path):
    words = ("sweep", "--points", "50", "--no-plot", "--threads", "1")
    script = SWALLOWING.replace("        pass\n", "        raise RuntimeError('half imported')\n")
    code, said = ended(begin([sys.executable, "-c", script, *words], tmp_path))
    assert (code, "interrupted" in said, "internal fault" in said) == (130, True, False), said


LOADING = """
import os, signal, sys
from camcli.cli.app import main
from camcli.kernel import code_cache
def make(path):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        sum(range(100))
    except BaseException:
        print("unwound", file=sys.stderr)
        raise
code_cache.make_folder = make
main()
"""


def test_nothing_is_raised_in_the_compiler(tmp_path, monkeypatch):
    """LLVM crashes where an exception leaves its objects half made."""
    monkeypatch.setenv("CAMCLI_KERNEL", "compiled")
    words = ("sweep", "--points", "2", "--no-plot", "--threads", "1")
    code, said = ended(begin([sys.executable, "-c", LOADING, *words], tmp_path))
    assert (code, "interrupted" in said, "unwound" in said) == (130, True, False), said


EARLY = """
import gc, os, signal, sys
at = sys.argv.pop(1)
def send():
    os.kill(os.getpid(), signal.SIGINT)
    sum(range(100))
class Finder:
    def find_spec(name, path=None, target=None):
        if name == at:
            send()
real = gc.freeze
gc.freeze = lambda: (at == "end" and send(), real())
sys.meta_path.insert(0, Finder)
signal.signal(signal.SIGINT, signal.default_int_handler)
from camcli.__main__ import main
main()
"""
LOADED = [
    "camcli.cli.app",
    "typer",
    "camcli.interrupts",
    "camcli.cli.exit_codes",
    "camcli.cli.schema",
]


@pytest.mark.parametrize("moment", [*LOADED, "camcli.scene", "end"])
def test_a_signal_while_the_program_is_loaded_or_ends_shows_no_traceback(tmp_path, moment):
    words = [sys.executable, "-c", EARLY, moment, "schema"]
    code, said = ended(begin(words, tmp_path))
    wanted = (0, "") if moment == "end" else (130, "interrupted\n")
    assert (code, said) == wanted


FROZEN = """
import os, signal, sys, threading, time
from camcli.cli.app import main
from camcli.output import pictures
def write(frames, file, kind):
    with pictures.unfinished_folder() as place:
        (place / "frames").write_bytes(b"x")
        print(place, file=sys.stderr, flush=True)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGTERM)).start()
        begun = time.monotonic()
        while time.monotonic() < begun + 20:  # a library that is deaf to exceptions
            try:
                time.sleep(1)
            except KeyboardInterrupt:
                pass
pictures.write_animation = write
main()
"""


@pytest.mark.ci
def test_an_animation_that_is_cut_leaves_nothing(tmp_path):
    words = ("simulate", "--rpm", "700", "--animate", "--no-plot", "--set", "run.record=2")
    code, said = ended(begin([sys.executable, "-c", FROZEN, *words, "-o", "out"], tmp_path))
    place, told = said.splitlines()
    assert (code, told) == (130, "interrupted")
    assert not Path(place).exists()
    assert list((tmp_path / "out").glob("*")) + list((tmp_path / "out").glob(".*")) == []


@pytest.mark.parametrize("arrived", [False, True])
def test_the_end_of_a_process_waits_as_long_as_signals_are_held(monkeypatch, arrived):
    """Also much longer than the patience with the main thread; no other number ends it."""
    reader, writer = os.pipe()
    os.write(writer, bytes([signal.SIGUSR1, signal.SIGTERM]))
    held, slept, ended = [None], [], []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) == 500:
            held.pop()

    monkeypatch.setattr(interrupts, "sleep", sleep)
    monkeypatch.setattr(interrupts, "_holding", held)
    monkeypatch.setattr(interrupts, "_ending", arrived)
    monkeypatch.setattr(interrupts, "_end", lambda: ended.append(len(slept)))
    try:
        interrupts._watch(reader)
    finally:
        os.close(reader)
        os.close(writer)
    assert slept[0] == 0.6
    assert ended == ([] if arrived else [500])


def test_what_cannot_be_removed_keeps_no_process_from_its_end(tmp_path, monkeypatch, capsys):
    for name in ("a", "b", "c"):
        (tmp_path / name).write_text("unfinished")
    left = [*(str(tmp_path / name) for name in ("a", "b", "none", "c"))]
    unlink = os.unlink

    def refuse(path: str) -> None:
        if path == left[1]:
            raise PermissionError
        unlink(path)

    def leave(code: int) -> None:
        raise SystemExit(code)

    monkeypatch.setattr(os, "unlink", refuse)
    monkeypatch.setattr(os, "_exit", leave)
    monkeypatch.setattr(interrupts, "_leftovers", left)
    with pytest.raises(SystemExit) as end:
        interrupts._end()
    assert end.value.code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["b"]
    assert capsys.readouterr() == ("", "interrupted\n")
