"""Pictures are drawn in another process while tables are written, or here where that fails."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import warnings
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import pytest
from conftest import some_in_ci

import camcli
from camcli.api.command import command_of
from camcli.cli import drawing
from camcli.output import drawing_process
from camcli.output.drawing_process import DrawingProcess, DrawingTask, prepare
from camcli.output.pictures import write_picture
from camcli.output.run_folder import run_folder

SHORT = {"run__transient": 20, "run__record": 20}
NARROW = {"start": 690.0, "stop": 700.0, "num": 3}
RUNS = {
    "simulate": {"run__rpm": 190.0},
    "sweep": {"sweep__rpm": NARROW},
    "detach": {"detach__rpm": {"start": 110.0, "stop": 120.0, "num": 3}},
    "orbits": {"orbits__rpm": NARROW},
    "basins": {"basins__cells": [6, 5]},
    "classify": {"classify__rpm": NARROW},
}
TWO = (
    {"key": "rpm", "start": 660.0, "stop": 760.0, "num": 3},
    {"key": "follower.restitution", "start": 0.6, "stop": 0.9, "num": 2},
)
MORE = {  # by the command: results that are computed in balls
    "sweep": {"sweep__vary": TWO, "sweep__curves": "auto"},
    "orbits": {"orbits__all": {"impacts": 1, "turns": 1}, "orbits__at": 700.0},
}


def scene_of(**values) -> camcli.Scene:
    """The default scene with these values; two underscores stand for a dot."""
    return camcli.load_scene(None, {name.replace("__", "."): v for name, v in values.items()})


def drawings_of(result: camcli.Result) -> list[DrawingTask]:
    """All pictures of a result, as its scene wants them."""
    return [DrawingTask(picture, "png", result.scene.plot) for picture in result.pictures.values()]


def drawn_here(drawing: DrawingTask) -> bytes:
    """The bytes of a picture that this process draws."""
    file = BytesIO()
    write_picture(drawing.picture(), file, drawing.kind, drawing.form)
    return file.getvalue()


def raise_error() -> None:
    raise ZeroDivisionError


@pytest.fixture(scope="module")
def other() -> Iterator[DrawingProcess]:
    """A process that draws one picture after the other."""
    process = DrawingProcess(["camcli.plots.picture", "a_module_that_is_not_there"])
    yield process
    process.end()


@pytest.mark.parametrize("name", some_in_ci(RUNS, {"sweep"}))
def test_a_picture_is_the_same_whoever_draws_it(other, name):
    check_drawn_alike(other, name, RUNS[name])


@pytest.mark.ci
@pytest.mark.parametrize("name", MORE)
def test_a_picture_of_what_is_proved_is_the_same_whoever_draws_it(other, name):
    check_drawn_alike(other, name, MORE[name])


def check_drawn_alike(other: DrawingProcess, name: str, values: dict) -> None:
    """The first picture of a run has the same bytes, drawn here and in another process."""
    drawing, *_ = drawings_of(getattr(camcli, name)(scene_of(**SHORT, **values)))
    other.begin([drawing])
    drawn = other.next_drawn()
    assert drawn is not None
    assert drawn.content == drawn_here(drawing)


def test_panels_without_room_are_told_of_a_picture_that_another_process_draws(tmp_path):
    values = {"plot__width": 60.0, "plot__height": 40.0, "sweep__rpm": NARROW}
    here = camcli.sweep(scene_of(**SHORT, **values))
    here.save(tmp_path / "here")
    there = camcli.sweep(scene_of(**SHORT, **values))
    other = DrawingProcess(["camcli.plots.picture"])
    with run_folder(tmp_path / "there") as folder:
        there.write(folder, drawing_process=other)
    other.end()
    assert there.left_out == here.left_out
    assert any(here.left_out.values())


def test_a_picture_that_cannot_be_sent_later_on_is_not_drawn_there(tmp_path, monkeypatch):
    """Nothing is asked for before the process is ready: then it cannot be asked."""
    (tmp_path / "slow_to_import.py").write_text("import time\ntime.sleep(1.0)\n")
    monkeypatch.syspath_prepend(tmp_path)
    other = DrawingProcess(["slow_to_import"])
    other.begin([DrawingTask(lambda: None, "png", scene_of().plot)])
    assert other.next_drawn() is None
    assert other.next_drawn() is None


def test_nothing_is_waited_for_where_nothing_is_drawn(other):
    assert other.next_drawn() is None


class Warns:
    """A picture that warns before it is drawn."""

    def __init__(self, task: DrawingTask) -> None:
        self.task = task

    def __call__(self):
        warnings.warn("a letter is missing", stacklevel=1)
        return self.task.picture()


def test_what_another_process_warns_of_is_told(other):
    (task,) = drawings_of(camcli.sweep(scene_of(**SHORT, sweep__rpm=NARROW)))
    other.begin([task._replace(picture=Warns(task))])
    drawn = other.next_drawn()
    assert drawn is not None
    assert drawn.warnings == ["a letter is missing"]


@pytest.mark.parametrize("idle", [False, True])
def test_a_process_that_is_let_go_ends(idle):
    other = DrawingProcess(["camcli.plots.picture"])
    process = other._helper.process
    if idle:
        other._ready.wait()
    other.let_go()
    ended_by_itself, before_it_was_ready = 0, -signal.SIGTERM
    assert process.wait(30.0) in ([ended_by_itself] if idle else [0, before_it_was_ready])
    assert other.next_drawn() is None


@pytest.mark.parametrize(
    "fails", some_in_ci(["in a picture", "before", "not started"], {"in a picture"})
)
def test_what_another_process_fails_in_is_drawn_here(tmp_path, monkeypatch, fails):
    result = camcli.sweep(scene_of(**SHORT, sweep__rpm=NARROW))
    if fails == "not started":
        monkeypatch.setattr(sys, "executable", str(tmp_path / "no python"))
    other = DrawingProcess(["camcli.plots.picture"])
    if fails == "in a picture":
        other.begin([DrawingTask(raise_error, "png", result.scene.plot), *drawings_of(result)])
        assert other.next_drawn() is None
        assert other.next_drawn() is None  # it has ended
    elif fails == "before":
        other._helper.process.kill()
    with run_folder(tmp_path / "out") as folder:
        record = result.write(folder, drawing_process=other)
    other.end()
    assert record["piece_faults"] == []
    (drawing,) = drawings_of(result)
    assert (tmp_path / "out" / "sweep.png").read_bytes() == drawn_here(drawing)


@pytest.mark.parametrize(
    ("line", "started"),
    [
        ("sweep --rpm 660:760", True), ("basins", True), ("classify -c a.yaml --json", True),
        ("", False), ("explore", False), ("figures", False), ("rerun out/run.json", False),
        ("--version", False), ("sweep --no-plot", False), ("sweep --dry-run", False),
        ("sweep --shard=1/2", False), ("sweep --threads 1", False), ("orbits --help", False),
        ("orbits -h", False),
    ],
)  # fmt: skip
def test_a_process_is_started_for_a_line_that_draws(monkeypatch, line, started):
    asked = []
    monkeypatch.setattr(drawing_process, "DrawingProcess", asked.append)
    for processors in (1, 2):
        count = "camcli.parallel.threads.thread_count"
        monkeypatch.setattr(count, lambda asked, count=processors: count)
        drawing.start(line.split())
        assert len(asked) == (started and processors > 1)
    drawing._started.clear()


def test_a_large_result_is_not_sent(monkeypatch):
    """401 speeds of 200 turns are; so many turns that their rows fill 64 MiB are not."""

    class Stub:
        ended = False

        def end(self) -> None:
            self.ended = True

    for record, sent in ((200, True), (10_000, False)):
        process = Stub()
        monkeypatch.setattr(drawing, "_started", [("sweep", process)])
        found = drawing.process_for(command_of("sweep"), scene_of(run__record=record))
        assert (found is process, process.ended) == (sent, not sent)
        assert drawing.process_for(command_of("basins"), scene_of()) is None


@pytest.mark.ci
def test_a_command_that_another_process_draws_for_imports_nothing_that_draws(tmp_path):
    words = ["sweep", "--rpm", "690:700", "--points", "3", "--quiet"]
    code = (
        "import sys, atexit\n"
        "atexit.register(lambda: print('matplotlib' in sys.modules))\n"
        "from camcli.parallel import threads\n"
        "threads.thread_count = lambda asked: 2\n"
        "from camcli.cli.app import main\n"
        "main()"
    )
    both = {}
    for threads in ([], ["--threads", "1"]):
        done = subprocess.run(
            [sys.executable, "-c", code, *words, *threads],
            cwd=tmp_path, capture_output=True, text=True, check=True, env=dict(os.environ),
        )  # fmt: skip
        assert done.stdout.split() == [str(bool(threads))]
        (picture,) = Path(tmp_path).rglob("sweep.png")
        both[bool(threads)] = picture.read_bytes()
    assert both[True] == both[False]


def test_the_search_for_garbage_is_that_of_the_process_that_asks():
    before = gc.get_threshold()
    try:
        prepare([], (701, 13, 7))
        assert gc.get_threshold() == (701, 13, 7)
    finally:
        gc.set_threshold(*before)


@pytest.mark.parametrize("error", [OSError, TypeError])
def test_where_no_process_can_be_started_nothing_is_drawn_by_one(monkeypatch, error):
    """As where there may be no more processes, and where no Python is known."""

    def refuse() -> None:
        raise error

    monkeypatch.setattr(drawing_process, "Helper", refuse)
    process = DrawingProcess([])
    process.begin([DrawingTask(lambda: None, "png", None)])
    assert process.next_drawn() is None
