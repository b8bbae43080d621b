"""cam orbits: which of the orbits found are followed, and which panels are drawn."""

import csv
import json
import struct

import pytest

ONE = ("orbits", "--rpm", "690:710", "--points", "11", "--label", "P(1;1)", "--branches", "0")


def height(path) -> int:
    return struct.unpack(">I", path.read_bytes()[20:24])[0]


@pytest.mark.parametrize(("which", "stable"), [("stable", {"1"}), ("unstable", {"0"})])
def test_only_stable_or_unstable_orbits_are_followed(cam, tmp_path, which, stable):
    done = cam(*ONE, "--set", f"orbits.stability={which}", "--no-plot", "-o", "out")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "out" / "branch.csv").open()))
    assert {row["stable"] for row in rows} == stable
    assert {row["branch"] for row in rows} == {"1"}
    result = json.loads((tmp_path / "out" / "run.json").read_text())["result"]
    assert [orbit["stable"] for orbit in result["orbits"]] == [which == "stable"]


def test_panels_make_a_picture_shorter(cam, tmp_path):
    heights = {}
    for panels in ("branches", "multipliers", "branches,multipliers"):
        done = cam(*ONE, "--set", f"orbits.panels=[{panels}]", "-o", "out")
        assert done.returncode == 0, done.stderr
        heights[panels] = height(tmp_path / "out" / "orbits.png")
    assert heights["multipliers"] < heights["branches"] < heights["branches,multipliers"]


def test_a_panel_that_does_not_exist_is_a_fault(cam):
    done = cam(*ONE, "--set", "orbits.panels=[branch]")
    assert done.returncode == 2
    assert "orbits.panels" in done.stderr
