"""Long runs are killed at random moments: old artefacts stay, the end is the same to the byte.

CAMCLI_SOAK=N kills N times in all.
"""

import json
import signal
import time

import pytest

from tests.parallel.long_runs import (
    SOAK,
    Case,
    at_work,
    begin,
    command,
    dying,
    ended,
    files,
    gone,
    kills,
    run,
    soak,
)

TURNS = ("--set", "run.transient=60", "--set", "run.record=40")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "121", *TURNS)
CASES = {
    "one thread": ((*SWEEP, "--no-plot", "--threads", "1"), ("--points", "9"), 4),
    "two threads": ((*SWEEP, "--threads", "2"), ("--points", "9"), 4),
    "carried": ((*SWEEP, "--no-plot", "--set", "sweep.direction=up"), ("--points", "9"), 4),
    "basins": (("basins", "--cells", "90", "--no-plot"), ("--cells", "9"), 4),
    "basins over a range": (
        ("basins", "--rpm", "690:730", "--points", "4", "--cells", "30", "--threads", "2"),
        ("--points", "2"),
        4,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_killed_at_random_moments(tmp_path, name):
    words, earlier, count = CASES[name]
    case = Case(tmp_path, words, earlier)
    count = SOAK // len(CASES) or count
    seed = list(CASES).index(name) + 1
    assert soak(case, seed, count) == count
    print(f"{name}: {count} kills, {dict(kills)}")


SCENE = """
figure: {{title: "On {0}", command: "{1}", shows: "a test"}}
follower: {{mass: 1.221, stiffness: 1430.8, restitution: 0.8}}
cam: {{kind: arcs, base_radius: 0.4, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.40393320723821, nose_radius: 0.15, top_dwell_deg: 40, offset: 0.3}}
run: {{transient: 150, record: {2}}}
sweep: {{rpm: {{start: 690, stop: 745, num: 401}}}}
"""


@pytest.fixture
def figures(tmp_path):
    (tmp_path / "scenes").mkdir()
    for name, record in (("1.1", 20), ("1.2", 30)):
        text = SCENE.format(name, "sweep", record)
        (tmp_path / "scenes" / f"{name}.yaml").write_text(text)
    return ("figures", "--folder", str(tmp_path / "scenes"), "--threads", "2")


def test_figures_killed_at_any_moment_end_the_same_and_leave_no_children(tmp_path, figures):
    began = time.perf_counter()
    assert run(command(*figures, "-o", "new"), tmp_path)[0] == 0
    seconds = time.perf_counter() - began
    new, met = files(tmp_path / "new"), 0
    for how, part in ((signal.SIGKILL, 0.6), (signal.SIGINT, 0.5), (signal.SIGTERM, 0.7)):
        process = begin(command(*figures, "-o", "out"), tmp_path)
        time.sleep(part * seconds)
        process.send_signal(how)
        code = ended(process)[0]
        assert gone(tmp_path)
        assert code in (0, 130, -how)
        met += code != 0
    assert met >= 1
    assert run(command(*figures, "-o", "out"), tmp_path)[0] == 0
    found = files(tmp_path / "out")
    same = [name for name in new if name.endswith((".csv", ".png"))]
    assert len(same) == 8
    assert [name for name in same if found[name] != new[name]] == []


def test_a_killed_run_says_how_far_it_is(tmp_path):
    words = (*SWEEP, "--no-plot", "--threads", "1")
    process = begin(dying("slow", 50, "SIGINT", *words), tmp_path)
    assert at_work(tmp_path / "out/sweep")
    process.send_signal(signal.SIGINT)
    code, said = ended(process)
    assert code == 130
    assert "pieces are on disk, the same command goes on from them" in said
    assert "interrupted" in said
    assert "Traceback" not in said
    code, said = run(command(*words), tmp_path)
    assert (code, "going on: " in said) == (0, True)
    record = json.loads((tmp_path / "out/sweep/run.json").read_text())
    assert 1 <= record["cost"]["pieces_from_disk"] <= 121
    assert record["cost"]["impacts_per_s"] is None


def test_a_second_run_into_the_folder_leaves(tmp_path):
    words = (*SWEEP, "--no-plot", "--threads", "1")
    process = begin(dying("slow", 100, "SIGINT", *words), tmp_path)
    assert at_work(tmp_path / "out/sweep")
    code, said = run(command(*words), tmp_path)
    assert code == 2
    assert "another run at work here" in said
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    assert ended(process)[0] == 130
