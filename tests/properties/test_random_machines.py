"""What holds for any machine, at any speed, from any start; in the soak for ever new ones."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import camcli
from tests.properties.test_branches import explained
from tests.support.long_runs import but_record, cam, dying, files
from tests.support.mechanics import Machine
from tests.truth.test_load_columns import RECORD, TRANSIENT, agree, random_scene

SOAK = int(os.environ.get("CAMCLI_SOAK", "0"))
SEEDS = st.integers(0, 2**31)
NO_PERIOD = ("aperiodic", "undecided")


def examples(number: int) -> settings:
    """So many examples, always the same."""
    return settings(max_examples=number, deadline=None, derandomize=True, database=None)


soak = settings(
    max_examples=max(1, SOAK // 10),
    deadline=None,
    database=None,
    print_blob=True,
    suppress_health_check=list(HealthCheck),
)


def started(seed: int) -> dict[str, Any]:
    """A machine, a speed up to four times the one of its first loss, and a start in the air."""
    rng, scene = np.random.default_rng(seed), random_scene(seed)
    scene["run"]["rpm"] *= float(rng.choice([1.0, 1.0, 1.5, 2.5, 4.0]))
    machine = Machine.of(scene)
    (c,), (v,), _ = machine.cam(machine.strobe)
    size = np.ptp(machine.lift.range)
    scene["run"]["start"] = {
        "q": float(c + size * rng.uniform(0.0, 1.5)),
        "v": float(v + machine.omega * size * rng.uniform(-1.0, 1.0)),
        "theta_deg": scene["run"]["strobe_deg"],
    }
    return scene


# -- one start, one label ----------------------------------------------------------------------


def labels(scene: dict[str, Any]) -> dict[str, str]:
    """What each command calls the motion from the start of a scene.

    `basins` is asked for a window of one cell about the start, and only where another command knows
    a period: an aperiodic attractor takes it long, and contradicts nobody.
    """
    rpm, start = scene["run"]["rpm"], scene["run"]["start"]
    scene = {**scene, "run": {**scene["run"], "transient": 300, "record": 140}}
    one = {"start": rpm, "stop": rpm, "num": 1}

    def asked(command: str, **section: Any) -> Any:
        return getattr(camcli, command)(camcli.load_scene({**scene, command: section}))

    named = {
        "sweep": asked("sweep", rpm=one).tables["speeds"]["label"][0],
        "classify": asked("classify", rpm=one).tables["classify"]["label"][0],
    }
    named["simulate"] = asked("simulate", samples=1).summary["label"]
    if set(named.values()) <= set(NO_PERIOD):
        return named
    sides = {name: [x - 1e-9 * abs(x), x + 1e-9 * abs(x)] for name, x in start.items()}
    found = asked("basins", rpm=one, q=sides["q"], v=sides["v"], cells=[1, 1]).tables
    own = found["attractors"]["attractor"] == found["basins"]["attractor"][0]
    named["basins"] = found["attractors"]["label"][own][0]
    return named


def rounded(simulated: Any) -> bool:
    """Whether a record is one of many motions that rounding allows."""
    return any("one of many motions" in note for note in simulated.notes)


def one_motion(seed: int) -> None:
    """All commands that decide give the motion one name; undecided contradicts nobody."""
    named = labels(started(seed))
    assert len({str(label) for label in named.values()} - {"undecided"}) <= 1, named


@pytest.mark.ci
@examples(6)
@given(SEEDS)
@example(1560650)  # rounding closes a cycle of 23 turns
def test_commands_do_not_contradict_each_other(seed):
    one_motion(seed)


@pytest.mark.soak
@soak
@given(SEEDS)
def test_commands_do_not_contradict_each_other_elsewhere(seed):
    one_motion(seed)


# -- one run, however it is cut ----------------------------------------------------------------

LINES = (
    ("sweep", "--rpm", "{low!r}:{high!r}", "--points", "5"),
    ("sweep", "--vary", "follower.restitution=0.2:0.9", "--points", "5"),
    ("sweep", "--rpm", "{low!r}:{high!r}", "--points", "5", "--both"),
    ("sweep", "--rpm", "{low!r}:{high!r}", "--vary", "follower.preload={load!r}:{more!r}",
     "--points", "3,2"),
    ("basins", "--rpm", "{low!r}:{high!r}", "--points", "3", "--cells", "6"),
)  # fmt: skip
SHORT = {"transient": 40, "record": 12}


def same_bytes(folder: Path, seed: int, line: tuple[str, ...]) -> None:
    """One thread or two, in two parts that are merged, or killed on the way and gone on with."""
    scene = plain(started(seed))
    scene["run"] = {**scene["run"], **SHORT}
    start, scene["run"]["start"] = scene["run"]["start"], {}
    rpm, load = scene["run"]["rpm"], scene["follower"]["preload"]
    size = float(np.ptp(Machine.of(scene).lift.range))
    scene["basins"] = {
        "budget": 60, "q": [start["q"] - size, start["q"] + size], "v": [-size * rpm, size * rpm],
    }  # fmt: skip
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    of = {"low": rpm, "high": 1.2 * rpm, "load": load, "more": 1.1 * load}
    words = (*(word.format(**of) for word in line), "-c", "scene.yaml", "--no-plot")

    def run(name: str, *more: str, arm=lambda: None, code: int = 0) -> dict[str, bytes]:
        ended, said = cam((*words, "-o", name, *more), folder, arm)
        assert ended == code, said
        return but_record(files(folder / name))

    one = run("one", "--threads", "1")
    assert one
    assert run("two", "--threads", "2") == one
    run("resumed", arm=dying("put", 2, "SIGKILL"), code=-9)
    assert run("resumed", "--threads", "2") == one
    if "--both" in line:  # a chain has no parts
        return
    for part in ("1/2", "2/2"):
        run("parts", "--shard", part)
    assert cam(("merge", "parts", "-o", "merged", "--no-plot"), folder)[0] == 0
    assert but_record(files(folder / "merged")) == one


def plain(value: Any) -> Any:
    """A scene in the numbers of Python, which YAML writes."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    return value.item() if isinstance(value, np.generic) else value


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES[:-1], ids=[" ".join(line[:2]) for line in LINES[:-1]])
def test_a_run_is_the_same_however_it_is_cut(tmp_path, line):
    same_bytes(tmp_path, 18 + LINES.index(line), line)


@pytest.mark.soak
@pytest.mark.parametrize("line", LINES, ids=[" ".join(line[:2]) for line in LINES])
def test_other_runs_are_the_same_however_they_are_cut(tmp_path_factory, line):
    @settings(soak, max_examples=max(1, SOAK // 50))
    @given(SEEDS)
    def run(seed: int) -> None:
        same_bytes(tmp_path_factory.mktemp("cut"), seed, line)

    run()


# -- more machines for what the quick tests ask of some ------------------------------------------


@pytest.mark.soak
@soak
@given(SEEDS)
def test_loads_are_those_of_a_sampled_motion(seed):
    scene = random_scene(seed)
    run = {"transient": TRANSIENT, "record": RECORD}
    seen = camcli.simulate(camcli.load_scene({**scene, "run": {**scene["run"], **run}}))
    if not rounded(seen):  # else a sweep measures the true motion, and this is another one
        agree(scene)


@pytest.mark.soak
@soak
@given(SEEDS)
def test_no_other_machine_gains_or_loses_stability_without_an_event(seed):
    explained(seed)
