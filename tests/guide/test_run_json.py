"""The guide's page on run.json names every key that a run has, and none that no run has."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from camcli.guide import pages
from tests.conftest import cam_in

CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = "--no-plot --json --set run.transient=100 --set run.record=40"
RUNS = {
    "simulate": "--rpm 700",
    "sweep": "--rpm 738:740 --points 2 --explain",
    "detach": f"-c {CONFIGS}/lift-table.yaml --hold-to 4000 "
    "--set spring.mass=0.06 --set spring.in_follower=true",
    "detach of a valve on its seat": f"-c {CONFIGS}/lift-table.yaml --rpm 3000 "
    "--set cam.lash=1e-4 --set contact.width=0.01 --set contact.face=flat",
    "detach that proves": "--rpm 114:126 --points 3 --prove",
    "orbits": "--rpm 735:745 --points 3 --prove",
    "basins": "--rpm 358.5 --set basins.cells=[20,20]",
    "classify": "--rpm 700:745 --points 2",
}
OF_SOME = {"labels", "exit_code", "faults", "plan", "points"}  # a map, a refusal, a plan
OF_A_PROVED_MAP = {"first", "last", "not_tried"}  # tests/cli/test_map.py has these
ANY = {"troubled", "holds_for"}  # their own keys are statuses and the like


def keys(found: object) -> Iterator[str]:
    """Every key in an object, at whatever depth."""
    if isinstance(found, dict):
        for key, value in found.items():
            yield key
            if key not in ANY:
                yield from keys(value)
    elif isinstance(found, list):
        for value in found:
            yield from keys(value)


def sections() -> dict[str, str]:
    """The parts of the page by their headings."""
    text = pages()["run-json"].path.read_text(encoding="utf-8")
    return dict(part.split("\n", 1) for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:])


def named(text: str) -> set[str]:
    return set(re.findall(r"`([a-z]\w*)`", text))


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    lines = ((name, f"{options} {SHORT}") for name, options in RUNS.items())
    return {name: json.loads(cam_in(folder, name.split()[0], line).stdout) for name, line in lines}


@pytest.mark.ci
@pytest.mark.parametrize("name", RUNS)
def test_every_key_of_a_result_is_told(records, name):
    whole = sections()
    told = named(whole[name.split()[0]]) | named(whole["The whole object"])
    if name == "classify":
        told |= named(whole["sweep"])
    assert set(keys(records[name]["result"])) - told - {"status", "words"} == set()


@pytest.mark.ci
def test_every_result_has_a_status(records):
    assert {name: record["result"]["status"] for name, record in records.items()} == dict.fromkeys(
        RUNS, "ok"
    )


@pytest.mark.parametrize(
    "line",
    ["sweep --rpm 180:200 --points 2", "classify --rpm 190", "simulate --rpm 190",
     "sweep --rpm 180:190 --vary follower.mass=1:2 --points 2,2", "basins --rpm 190 --cells 4"],
)  # fmt: skip
def test_trouble_stands_in_the_record_as_on_the_screen(tmp_path, line):
    """A script that reads --json sees the worst status of a row, and what stderr says."""
    done = cam_in(tmp_path, f"{line} {SHORT} --set run.impact_budget=3", code=3)
    record = json.loads(done.stdout)
    assert record["result"]["status"] == "impact-budget"
    assert record["notes"]
    assert set(record["notes"]) <= set(done.stderr.splitlines())


@pytest.mark.ci
def test_every_key_of_the_record_is_told(records):
    told = named(sections()["The whole object"])
    for record in records.values():
        assert set(record) - told == set()
        measured_cam = record["error"].get("lift_table", {})
        told_of_record = set(keys([record["cost"], record["error"]])) - set(keys(measured_cam))
        assert told_of_record - told == set()


@pytest.mark.ci
def test_no_key_is_told_that_no_run_has(records):
    there = {key for record in records.values() for key in keys(record)}
    there |= OF_SOME | OF_A_PROVED_MAP
    told = {key for text in sections().values() for key in named(text)}
    assert told - there == {"ok"}
