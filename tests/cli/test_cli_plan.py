"""What --dry-run foresees, beside what real commands then do; timings are not asserted."""

import json
from pathlib import Path

import pytest

from camcli.analysis.basins.mapping import Question, basins
from camcli.analysis.basins.window import Window
from camcli.cli import plan

SEEN = {
    "sweep": ("sweep", "--points", "101"),
    "sweep with little transient": ("sweep", "--set", "run.record=50", "--points", "101"),
    "sweep with damping": ("sweep", "--set", "follower.damping=2", "--points", "101"),
    "sweep of P(3;3:3:2)": ("sweep", "--rpm", "357.5:361.5", "--points", "101"),
    "sweep of chatter": ("sweep", "--rpm", "110:200", "--points", "12"),
    "sweep of impacts": ("sweep", "--set", "sweep.sections=[impacts]", "--points", "60"),
    "sweep as npz": ("sweep", "--set", "sweep.tables=npz", "--points", "60"),
    "sweep without tables": ("sweep", "--set", "sweep.tables=none", "--points", "60"),
    "sweep without picture": ("sweep", "--no-plot", "--points", "30"),
    "sweep down": ("sweep", "--rpm", "735:672", "--set", "sweep.direction=down", "--points", "60"),
    "basins": ("basins", "--cells", "120"),
    "basins refined": ("basins", "--cells", "80", "--refine", "2"),
    "basins of a range": ("basins", "--rpm", "690:730", "--points", "3", "--cells", "60"),
    "basins by cells": ("basins", "--method", "simple", "--cells", "120"),
    "basins with a boundary": ("basins", "--cells", "60", "--boundary"),
    "classify": ("classify", "--rpm", "700:745", "--points", "40"),
    "simulate": ("simulate", "--rpm", "745", "--set", "run.record=1500", "--points", "90"),
    "simulate chatter": ("simulate", "--rpm", "190", "--set", "run.record=60"),
}


def foreseen(cam, *words: str) -> dict:
    """The plan of a command."""
    done = cam(*words, "--dry-run", "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["plan"]


def within_two(estimated: float, true: float) -> bool:
    return true / 2 <= estimated <= true * 2


@pytest.mark.slow
@pytest.mark.parametrize("words", SEEN.values(), ids=SEEN)
def test_a_plan_is_right_within_a_factor_of_two(cam, tmp_path, words):
    cost = foreseen(cam, *words)
    done = cam(*words, "--json", "-o", "here")
    assert done.returncode == 0, done.stderr
    impacts = json.loads(done.stdout)["cost"]["impacts"]
    size = sum(path.stat().st_size for path in (tmp_path / "here").iterdir())
    assert within_two(cost["impacts"], impacts), (cost["impacts"], impacts)
    assert within_two(cost["bytes"], size), (cost["bytes"], size)
    assert cost["disk"] >= cost["bytes"]


def test_the_turns_of_orbits_are_known_exactly(cam):
    words = ("--set", "run.transient=70", "--set", "run.record=30", "--points", "21")
    sweep = foreseen(cam, "sweep", *words)
    assert (sweep["orbits"], sweep["periods"]) == (21, 2100)
    assert foreseen(cam, "sweep", *words, "--set", "run.record=60")["periods"] == 21 * 130
    assert foreseen(cam, "simulate", "--rpm", "700")["periods"] == 1000


@pytest.mark.slow
@pytest.mark.parametrize("rpm", [190.0, 356.0, 358.5, 700.0, 745.0])
def test_the_turns_of_cells_are_known_within_a_factor_of_two(cam, chapter, rpm):
    from conftest import settings

    cost = foreseen(cam, "basins", "--rpm", str(rpm), "--cells", "150")
    question = Question(Window((0.1, 0.9), (-50.0, 50.0), 150, 150))
    _, census = basins(chapter, rpm, settings(600, 400), question)
    assert within_two(cost["periods"], census.crew.turns), (cost["periods"], census.crew.turns)


def test_pieces_of_a_shard_are_its_part_and_no_tables(cam):
    whole, part = (foreseen(cam, "sweep", *words) for words in ((), ("--shard", "2/4")))
    assert part["orbits"] == 101
    assert part["bytes"] == 0
    assert 3.5 < (whole["disk"] - whole["bytes"]) / part["disk"] < 4.5
    assert any("shard 2 of 4" in text for text in part["notes"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sweep", "--explain", "--points", "11"), "up to 10 searches"),
        (("classify", "--explain", "--points", "11"), "up to 10 searches"),
        (("basins", "--boundary"), "139264 further starts"),
        (("basins", "--exponents"), "exponents"),
        (("sweep", "--lyapunov"), "exponents"),
    ],
)
def test_what_comes_on_top_is_named(cam, words, said):
    assert any(said in text for text in foreseen(cam, *words)["notes"])


def test_a_plan_neither_compiles_nor_writes(cam, tmp_path):
    env = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "CAMCLI_KERNEL": "compiled"}
    for name in ("sweep", "basins", "classify", "simulate"):
        done = cam(name, "--dry-run", env=env)
        assert done.returncode == 0, done.stderr
        assert "compiling the kernel" in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_the_same_scene_gives_the_same_counts(cam):
    first, second = (foreseen(cam, "basins", "--rpm", "357:359") for _ in range(2))
    assert {**first, "seconds": 0} == {**second, "seconds": 0}


TOO_LARGE = {
    "cells": (("basins", "--cells", "16384", "--refine", "6"), "16384 x 16384 cells", "GB of mem"),
    "10^12 cells": (("basins", "--cells", "1000000"), "1000000", "16384"),
    "10^9 points": (("sweep", "--points", "1000000000"), "1000000000", "10000000"),
    "10^7 points": (
        ("sweep", "--points", "10000000", "--set", "run.record=100000"), "10000000 speeds",
        "GB of files",
    ),
    "10^15 turns": (("sweep", "--set", "run.record=1000000000000000"), "1000000000000000", ""),
    "10^9 turns": (("sweep", "--set", "run.record=1000000000"), "1000000000 rec", "GB of files"),
    "10^9 samples": (("simulate", "--points", "1000000000"), "1000000000", "100000"),
    "10^14 rows": (
        ("simulate", "--points", "100000", "--set", "run.record=1000000000"), "samples", "e+07 GB",
    ),
    "motions": (("classify", "--set", "run.record=1000000000"), "101 speeds", "GB of memory"),
}  # fmt: skip


@pytest.mark.parametrize("dry", [True, False], ids=["planned", "asked for"])
@pytest.mark.parametrize(("words", "found", "figure"), TOO_LARGE.values(), ids=TOO_LARGE)
def test_what_cannot_fit_is_refused_with_its_figure(cam, tmp_path, words, found, figure, dry):
    done = cam(*words, *(["--dry-run"] if dry else []))
    assert done.returncode == 2
    assert found in done.stderr
    assert figure in done.stderr
    assert "expected" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def need(memory: float, disk: float) -> plan.Need:
    return plan.Need("run.record", "so many turns", memory, disk, "ask for less")


def cost(memory: int, disk: int) -> plan.Plan:
    return plan.Plan(1, 1, 1, 1.0, disk, disk, memory)


@pytest.fixture
def request_of(tmp_path):
    from camcli.cli.options import Request

    def call(dry_run: bool) -> Request:
        return Request(None, [], None, None, tmp_path, True, True, True, None, dry_run)

    return call


@pytest.fixture(autouse=True)
def small_machine(monkeypatch):
    monkeypatch.setattr(plan, "memory", lambda: 1e9)
    monkeypatch.setattr(plan, "free_disk", lambda folder: 2e9)


def test_little_is_neither_looked_at_nor_refused(request_of):
    def estimate():
        raise AssertionError("there was no need to look")

    assert plan.planned("sweep", request_of(False), need(1e6, 1e6), estimate) is False


@pytest.mark.parametrize(
    ("memory", "disk", "said"),
    [(900_000_000, 1, "900 MB of memory"), (1, 2_100_000_000, "2.1 GB of files")],
)
def test_what_comes_near_is_looked_at_and_refused(request_of, memory, disk, said):
    from camcli.errors import SceneError

    with pytest.raises(SceneError) as caught:
        plan.planned("sweep", request_of(False), need(1e8, 1e8), lambda: cost(memory, disk))
    (fault,) = caught.value.faults
    assert fault.path == "run.record"
    assert said in fault.found
    assert fault.expected
    assert fault.cure


def test_a_plan_that_cannot_fit_is_shown_and_refused(request_of, capsys):
    from camcli.errors import SceneError

    with pytest.raises(SceneError):
        plan.planned("sweep", request_of(True), need(1, 1), lambda: cost(10**12, 10**12))
    assert json.loads(capsys.readouterr().out)["plan"]["memory"] == 10**12


def test_free_disk_is_that_of_the_nearest_folder_there_is(monkeypatch, tmp_path):
    monkeypatch.undo()
    asked: list[Path] = []

    class Usage:
        free = 5.0

    monkeypatch.setattr(
        plan.shutil, "disk_usage", lambda place: (asked.append(Path(place)), Usage)[1]
    )
    assert plan.free_disk(tmp_path / "not" / "there") == 5.0
    assert asked == [tmp_path]
