"""What --dry-run foresees, beside what real commands then do; timings are not asserted."""

import json

import pytest

from camcli.cli import forecast
from camcli.kernel import backend, compiled

SEEN = {
    "sweep": ("sweep", "--points", "41"),
    "sweep of chatter": ("sweep", "--rpm", "110:200", "--points", "40"),
    "sweep as npz": ("sweep", "--set", "sweep.tables=npz", "--points", "40"),
    "basins": ("basins", "--cells", "120"),
    "classify": ("classify", "--rpm", "700:745", "--points", "20"),
    "detach": ("detach",),
    "simulate": ("simulate", "--rpm", "745", "--set", "run.record=1500", "--points", "90"),
}


def foreseen(cam, *words: str) -> dict:
    """The plan of a command."""
    done = cam(*words, "--dry-run --json", code=0)
    return json.loads(done.stdout)["plan"]


@pytest.mark.slow
@pytest.mark.parametrize("words", SEEN.values(), ids=SEEN)
def test_a_plan_is_right_within_a_factor_of_two_and_writes_nothing(
    cam, tmp_path, monkeypatch, words
):
    monkeypatch.setattr(forecast, "MOST", 600.0)  # s, where the machine is slow
    cost = foreseen(cam, *words)
    assert list(tmp_path.iterdir()) == []
    done = cam(*words, "--no-plot --json -o here", code=0)
    impacts = json.loads(done.stdout)["cost"]["impacts"]
    size = sum(path.stat().st_size for path in (tmp_path / "here").iterdir())
    assert impacts / 2 <= cost["impacts"] <= impacts * 2
    assert (size - 5e3) / 2 <= cost["bytes"] - forecast.PICTURE <= (size + 5e3) * 2
    assert cost["disk"] >= cost["bytes"]


@pytest.mark.usefixtures("short_samples")
def test_what_is_known_before_is_exact_and_what_is_not_is_said(cam):
    turns = ("--set", "run.transient=70", "--set", "run.record=30", "--points", "21")
    sweep = foreseen(cam, "sweep", *turns)
    assert (sweep["orbits"], sweep["periods"]) == (21, 2100)
    assert foreseen(cam, "simulate", "--rpm", "700")["periods"] == 1000
    assert foreseen(cam, "explore", *turns)["seconds"] > 0.0
    orbits = foreseen(cam, "orbits")
    assert orbits["seconds"] is None
    assert "not known before" in orbits["notes"][0]


@pytest.mark.usefixtures("short_samples")
def test_a_shard_makes_its_part_of_the_pieces_and_no_tables(cam):
    part = foreseen(cam, "sweep", "--points", "40", "--shard", "2/4")
    assert (part["orbits"], part["bytes"]) == (10, 0)
    assert any("shard 2 of 4" in text for text in part["notes"])


@pytest.mark.parametrize(
    ("line", "found", "figure"),
    [
        ("basins --cells 16384 --refine 6", "16384 x 16384 cells", "GB of mem"),
        ("sweep --points 10000000 --set run.record=100000", "10000000 speeds", "GB of files"),
        ("sweep --set run.record=1000000000 --dry-run", "1000000000 rec", "GB of files"),
        ("simulate --points 100000 --set run.record=1000000000", "samples", "e+07 GB"),
        ("classify --set run.record=1000000000 --dry-run", "101 speeds", "GB of memory"),
    ],
)
def test_what_cannot_fit_is_refused_with_its_figure(cam, tmp_path, line, found, figure):
    done = cam(line, code=2)
    assert all(words in done.stderr for words in (found, figure, "expected"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("short_samples")
def test_much_to_write_is_said_and_a_sample_that_takes_long_ends(cam, monkeypatch):
    large = "sweep --points 4000 --set run.record=2000 --dry-run"
    said = cam(large).stderr
    assert "note: this writes 1.38 GB" in said
    assert "sweep.tables=npz" in said
    assert "writes" not in cam("sweep --points 3 --dry-run").stderr
    monkeypatch.setattr(forecast, "MOST", 0.0)
    plan = foreseen(cam, "detach")
    assert (plan["seconds"], plan["impacts"], plan["bytes"]) == (None, None, None)
    assert "not known before" in plan["notes"][0]


def test_compiling_is_no_part_of_a_sample(cam, monkeypatch):
    now = [0.0]

    def slowly(path):
        now[0] += 2 * forecast.MOST
        return backend.read_intact(path)

    monkeypatch.setattr(backend, "perf_counter", lambda: now[0])
    monkeypatch.setattr(backend, "_compiled", None)
    monkeypatch.setattr(compiled, "read_intact", slowly)
    monkeypatch.setenv("CAMCLI_KERNEL", "compiled")
    assert foreseen(cam, "sweep", "--points", "5")["seconds"] == 0.0
