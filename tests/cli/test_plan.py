"""What --dry-run foresees, beside what real commands then do; timings are not asserted."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.api.command import command_of
from camcli.cli import forecast, sizes
from camcli.kernel import backend, code_cache
from camcli.scene import load_scene
from camcli.words import plan
from tests.support.bounds import limited

CONFIGS = Path(__file__).parents[2] / "configs"
FACTOR = 2.0  # between what is foreseen and what is measured
SMALL = 10e3  # bytes that nobody minds
TURNS = "--set run.transient=50 --set run.record=100"
LONG = (
    "sweep as npz", "sweep of speeds alone", "report", "explore with basins", "explore with map",
    "simulate finely", "profile", "map", "classify",
)  # fmt: skip


def some_as_soak(names, long=LONG):
    """Names of cases as parameters; those that take long and are like another one are soaks."""
    return [pytest.param(n, marks=pytest.mark.soak) if n in long else n for n in names]


SEEN = {
    "sweep": "sweep --points 41",
    "sweep of chatter": "sweep --rpm 110:200 --points 40",
    "sweep as npz": f"sweep --set sweep.tables=npz --points 40 {TURNS}",
    "sweep of speeds alone": f"sweep --set sweep.tables=none --points 40 {TURNS}",
    "sweep both ways, zoomed": f"sweep --rpm 690:745 --both --zoom 700:710 --points 21,9 {TURNS}",
    "sweep of a long record": "sweep --points 9 --set run.record=3000",
    "map": f"sweep --rpm 690:745 --vary follower.restitution=0.7:0.8 --points 16,16 {TURNS}",
    "basins": "basins --cells 120",
    "basins over a range": "basins --rpm 690:710 --points 6 --cells 30",
    "classify": "classify --rpm 700:745 --points 20",
    "classify with starts": f"classify --rpm 700:745 --points 8 --starts 12 {TURNS}",
    "detach": "detach",
    "report": "detach --report --points 21",
    "simulate": "simulate --rpm 745 --set run.record=800 --points 90",
    "simulate finely": "simulate --points 20000 --set run.record=6",
    "profile": "simulate --profile-only --points 5000",
    "explore": f"explore --points 41 {TURNS} --set orbits.starts=2",
    "explore with basins": f"explore --points 5 --with basins --set basins.cells=[20,20] {TURNS}",
    "explore with map": f"explore --points 5,9 --with map --vary follower.mass=1:2 {TURNS}",
    **{
        f"{words.split()[0]} of {name}": f"{words} -c {CONFIGS / name}.yaml"
        for name in ("eccentric", "law-harmonic", "valve-train", "bouncing-ball")
        for words in (
            f"sweep --points 9 {TURNS}", f"simulate --points 60 {TURNS}", "detach --points 9",
        )
    },
    "explore of eccentric": f"explore -c {CONFIGS}/eccentric.yaml --points 6 {TURNS}",
    "classify of valve-train": f"classify -c {CONFIGS}/valve-train.yaml --points 5 {TURNS}",
}  # fmt: skip


def foreseen(cam, *words: str) -> dict:
    """The plan of a command."""
    done = cam(*words, "--dry-run --json", code=0)
    return json.loads(done.stdout)["plan"]


@pytest.mark.slow
@pytest.mark.parametrize("name", some_as_soak(SEEN))
def test_a_plan_is_right_within_a_factor_of_two_and_writes_nothing(
    cam, tmp_path, monkeypatch, name
):
    monkeypatch.setattr(forecast, "MOST", 600.0)  # s, where the machine is slow
    words = SEEN[name] + " --no-plot" * ("explore" not in name and name != "report")
    cost = foreseen(cam, words)
    assert list(tmp_path.iterdir()) == []
    done = cam(words, "--json -o here")
    assert done.returncode in (0, 3), done.stderr
    impacts = json.loads(done.stdout)["cost"]["impacts"]
    size = sum(path.stat().st_size for path in (tmp_path / "here").iterdir())
    if "explore" not in name:  # of its impacts those of the solved orbits are not foreseen
        assert impacts / FACTOR <= cost["impacts"] + 10
        assert cost["impacts"] <= impacts * FACTOR + 10
    assert (size - SMALL) / FACTOR <= cost["bytes"] <= (size + SMALL) * FACTOR
    assert cost["disk"] >= cost["bytes"]
    limited = any("run.work_budget" in note for note in cost["notes"])
    assert limited == ("explain" in words)  # the time of anything else is known


MEASURED = {
    "sweep": f"sweep --points 101 {TURNS} --set run.patience=0",
    "sweep, nothing drawn": "sweep --points 201 --no-plot",
    "map": f"sweep --rpm 690:745 --vary follower.mass=1:2 --points 10,10 {TURNS}",
    "simulate finely": "simulate --points 30000 --set run.record=4",
    "profile": "simulate --profile-only --points 5000 --width 300mm --height 300mm",
    "orbits": "orbits --rpm 700:712 --points 11 --set orbits.starts=2",
    "basins": "basins --cells 30",
    "classify": f"classify --points 11 {TURNS}",
    "explore": f"explore --points 101 {TURNS} --set run.patience=0 --set orbits.starts=2",
}
CHILD = """
import re, sys
from pathlib import Path
from camcli.cli.app import app
app(sys.argv[1:], standalone_mode=False)
print(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
"""  # the peak of this process, not of the one it was forked from


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
@pytest.mark.parametrize("name", some_as_soak(MEASURED, (*LONG, "orbits", "basins")))
def test_the_memory_of_a_plan_is_that_of_the_run_within_a_factor_of_two(
    cam, tmp_path, monkeypatch, name
):
    monkeypatch.setattr(forecast, "MOST", 0.0)  # of memory nothing is sampled
    planned = foreseen(cam, MEASURED[name])["memory"]
    command = [sys.executable, "-c", CHILD, *MEASURED[name].split(), "-q", "-o", "here"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    measured = int(done.stdout.split()[-1]) * 1024
    assert measured / FACTOR <= planned <= measured * FACTOR


@pytest.mark.usefixtures("short_samples")
def test_what_is_known_before_is_exact_and_what_is_not_is_said(cam):
    turns = ("--set", "run.transient=70", "--set", "run.record=30", "--points", "21")
    sweep = foreseen(cam, "sweep", *turns)
    assert (sweep["orbits"], sweep["periods"]) == (21, 2100)
    assert foreseen(cam, "simulate", "--rpm", "700")["periods"] == 1000
    explore = foreseen(cam, "explore", *turns)
    assert (explore["orbits"], explore["periods"]) == (63, 6300)
    assert explore["seconds"] > 0.0
    orbits = foreseen(cam, "orbits")
    assert (orbits["seconds"], orbits["bytes"]) == (None, None)
    assert "not known before" in orbits["notes"][0]


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("simulate", {"simulate.animate": True}),
        ("sweep", {"sweep.explain": True}),
        ("detach", {"detach.tolerance": [{"key": "follower.mass", "percent": 5}]}),
        ("orbits", {}),
        ("basins", {"basins.refine": 2}),
        ("classify", {"classify.explain": True}),
        ("explore", {}),
    ],
)
def test_the_plan_of_each_command_says_what_it_leaves_out(name, asked):
    """In the words that `tests/output/test_phrases.py` compares; here, that they are its own."""
    scene = load_scene(None, asked)
    said = command_of(name).not_foreseen(scene)
    assert said == getattr(plan, name)(scene) != []


@pytest.mark.usefixtures("short_samples")
def test_a_shard_makes_its_part_of_the_pieces_and_no_tables(cam):
    part = foreseen(cam, "sweep", "--points", "40", "--shard", "2/4")
    assert (part["orbits"], part["bytes"]) == (10, 0)
    assert any("shard 2 of 4" in text for text in part["notes"])


@pytest.mark.slow
def test_the_pieces_of_a_plan_are_those_of_a_shard(cam, tmp_path):
    words = "sweep --rpm 690:745 --points 120"
    planned = foreseen(cam, words, "--shard 1/2")["disk"]
    cam(words, "--shard 1/2 -o here", code=0)
    size = sum(path.stat().st_size for path in (tmp_path / "here").iterdir())
    assert size / FACTOR <= planned <= size * FACTOR
    simulated = foreseen(cam, "simulate --no-plot --set run.record=50")
    assert simulated["disk"] == simulated["bytes"]  # it keeps no pieces


@pytest.mark.parametrize(
    ("line", "found", "figure"),
    [
        ("basins --cells 16384 --refine 6", "16384 x 16384 cells", "GB of mem"),
        ("sweep --points 10000000 --set run.record=100000", "10000000 speeds", "GB of files"),
        ("sweep --set run.record=1000000000 --dry-run", "1000000000 rec", "GB of files"),
        ("simulate --points 100000 --set run.record=1000000000", "samples", "000000 GB"),
        ("classify --set run.record=1000000000 --dry-run", "101 speeds", "GB of memory"),
        ("explore --set run.record=1000000000", "401 speeds of 3 sweeps", "GB of memory"),
        (
            "explore --with map --vary follower.mass=1:2 --points 2,10000000 --dry-run",
            "20000000 points of a map", "GB of memory",
        ),
        ("basins --width 1000mm --height 1000mm --format pdf", "cells", "memory to draw"),
    ],
)  # fmt: skip
def test_what_cannot_fit_is_refused_with_its_figure(
    cam, tmp_path, monkeypatch, line, found, figure
):
    monkeypatch.setattr(sizes, "memory", lambda: 12e9)
    done = cam(line, code=2)
    assert all(words in done.stderr for words in (found, figure, "expected"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("short_samples")
def test_much_to_write_is_said_once(cam, monkeypatch):
    """The plan has a figure of its own, from a sample: two figures would contradict each other."""
    large = "sweep --points 4000 --set run.record=2000"
    assert "writes" not in cam(large, "--dry-run").stderr
    monkeypatch.setattr("camcli.cli.run.execute", lambda *args, **more: 0)
    said = cam(large).stderr
    assert "note: this writes at least 689 MB of files, and 515 MB of pieces until then" in said
    assert "sweep.tables=npz" in said
    assert "writes" not in cam("sweep --points 3").stderr


ENDLESS = "--set follower.stiffness=1e16 --set basins.budget=60"


@pytest.mark.parametrize(
    "words",
    [
        f"basins -c {CONFIGS}/eccentric.yaml {ENDLESS}",
        f"simulate -c {CONFIGS}/law-harmonic.yaml {ENDLESS} --points 100000",
        f"explore -c {CONFIGS}/eccentric.yaml {ENDLESS}",
        f"detach -c {CONFIGS}/eccentric.yaml {ENDLESS}",
    ],
)
def test_a_sample_that_takes_long_is_cut_off(cam, monkeypatch, words):
    """Without that each of them takes more than a minute."""
    backend.compiled()
    monkeypatch.setattr(forecast, "MOST", 0.02)
    with limited(10.0):
        plan = foreseen(cam, words)
    assert (plan["seconds"], plan["impacts"], plan["bytes"]) == (None, None, None)
    assert any("not known before" in text for text in plan["notes"])
    has_budget = words.startswith("detach")  # the others end by themselves
    assert any("run.work_budget" in text for text in plan["notes"]) == has_budget


def test_compiling_is_no_part_of_a_sample(cam, monkeypatch):
    now, make = [0.0], code_cache.make_folder

    def slowly(path):
        now[0] += 2 * forecast.MOST
        make(path)

    monkeypatch.setattr(backend, "perf_counter", lambda: now[0])
    monkeypatch.setattr(backend, "_compiled", None)
    monkeypatch.setattr(code_cache, "make_folder", slowly)
    monkeypatch.setenv("CAMCLI_KERNEL", "compiled")
    assert foreseen(cam, "sweep", "--points", "5")["seconds"] == 0.0


@pytest.mark.parametrize("budget", [5_000_000, 1_000_000_000])
def test_what_is_not_foreseen_ends_with_the_budget_of_work(cam, budget):
    """Branches of orbits, and explanations: 5 million units of work are a second."""
    asked = f"--set run.work_budget={budget}"
    (line,) = [text for text in foreseen(cam, f"orbits {asked}")["notes"] if "work_budget" in text]
    assert line == f"run.work_budget = {budget} ends it after some {budget / 5e6:.0f} s"
    words = f"classify --rpm 700:701 --points 2 --set run.record=9 {asked}"
    for more, told in (("", False), ("--explain", True)):
        notes = " ".join(foreseen(cam, f"{words} {more}")["notes"])
        assert ("work_budget" in notes) == told
