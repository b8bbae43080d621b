"""Long runs killed at chosen and at random moments: old artefacts stay, the end has the same bytes.

CAMCLI_SOAK=N kills N times in all.
"""

import json
import signal
import time

import pytest

from tests.parallel.long_runs import (
    SOAK,
    Case,
    Fork,
    at_work,
    begin,
    but_record,
    cam,
    command,
    ended,
    files,
    gone,
    run,
    slow,
)

FEW = ("--set", "run.transient=5", "--set", "run.record=5")
SHORT = ("sweep", "--rpm", "660:760", "--points", "21", "--no-plot", "--threads", "1", *FEW)
EARLIER = ("--points", "9", "--set", "sweep.tables=npz")


@pytest.fixture(scope="module")
def shared(tmp_path_factory):
    """impacts.csv and strobe.csv where an earlier run left impacts.npz and strobe.npz."""
    return Case(tmp_path_factory.mktemp("moments"), SHORT, EARLIER)


@pytest.fixture
def case(shared):
    shared.reset()
    return shared


@pytest.mark.parametrize("how", ["SIGKILL", "SIGINT", "SIGTERM"])
@pytest.mark.parametrize(("where", "number"), [("half", 1), ("half", 12), ("put", 7), ("put", 21)])
def test_killed_at_a_piece(case, where, number, how):
    code, said = case.die(where, number, how)
    assert code == (-9 if how == "SIGKILL" else 130)
    if code == 130 and number > 1:
        assert f"{number - 1} pieces are on disk, the same command goes on from them" in said
    assert "Traceback" not in said
    assert case.check() == 0
    said = case.finish()
    assert (f"going on: {number - 1} pieces" in said) == (number > 1)
    assert ("torn" in said) == (where == "half" and how == "SIGKILL")


@pytest.mark.parametrize("how", ["SIGKILL", "SIGINT"])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_killed_at_an_artefact_all_are_old(case, number, how):
    assert case.die("fsync", number, how)[0] in (130, -9)
    assert case.check() == 0
    assert "going on: 21 pieces" in case.finish()


@pytest.mark.parametrize("how", ["SIGKILL", "SIGTERM"])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_killed_at_a_rename_each_is_old_or_new(case, number, how):
    assert case.die("replace", number, how)[0] in (130, -9)
    assert case.check() == number - 1
    assert "going on: 21 pieces" in case.finish()


def test_killed_before_any_file_goes(case):
    for number in range(1, 9):  # artefacts of another form, the pieces
        case.reset()
        code, said = case.die("unlink", number, "SIGKILL")
        if code == 0:
            break
        assert code == -9, said
        case.check()
        case.finish()
    assert number > 3


def test_killed_at_every_turn_of_going_on(case):
    for turn in range(6):
        assert case.die("put", 4, ("SIGKILL", "SIGINT", "SIGTERM")[turn % 3])[0] in (130, -9)
        assert case.check() == 0
    assert "going on: 18 pieces" in case.finish()
    record = json.loads((case.folder / "run.json").read_text())
    assert (record["cost"]["pieces_from_disk"], record["cost"]["impacts_per_s"]) == (18, None)


def test_unfinished_work_of_another_scene_is_told_and_kept(case):
    case.die("put", 5, "SIGKILL")
    code, said = cam((*SHORT, "--points", "15", "-o", "out"), case.cwd)
    assert code == 0
    assert "keeps unfinished work of other scenes" in said
    assert len(list(case.folder.glob(".*.pieces"))) == 1
    assert "going on: 4 pieces" in case.finish()


def test_a_picture_is_whole_too(tmp_path):
    words = ("sweep", "--rpm", "660:760", "--points", "11", *FEW)
    case = Case(tmp_path, words, ("--points", "5"))
    case.die("replace", 4, "SIGKILL")
    assert case.check() == 3
    case.finish()
    assert files(case.folder)["sweep.png"][:4] == b"\x89PNG"


def test_a_second_run_into_the_folder_leaves(tmp_path):
    first = Fork(SHORT, tmp_path, slow(100))
    assert at_work(tmp_path / "out/sweep")
    code, said = cam(SHORT, tmp_path)
    assert (code, "another run at work here" in said) == (2, True)
    first.send_signal(signal.SIGTERM)
    assert first.ended()[0] == 130
    assert cam(SHORT, tmp_path)[0] == 0


MANY = ("--set", "run.transient=60", "--set", "run.record=40")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "121", *MANY)
RANGE = ("basins", "--rpm", "690:730", "--points", "4", "--cells", "30", "--threads", "2")
CASES = {
    "one thread": ((*SWEEP, "--no-plot", "--threads", "1"), ("--points", "9")),
    "two threads": ((*SWEEP, "--threads", "2"), ("--points", "9")),
    "carried": ((*SWEEP, "--no-plot", "--set", "sweep.direction=up"), ("--points", "9")),
    "basins": (("basins", "--cells", "90", "--no-plot"), ("--cells", "9")),
    "basins over a range": ((*RANGE, "--no-plot"), ("--points", "2")),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_killed_at_random_moments(tmp_path, name):
    words, earlier = CASES[name]
    Case(tmp_path, words, earlier).soak(list(CASES).index(name), SOAK // len(CASES) or 1)


SCENE = """
figure: {{title: "On {0}", command: sweep, shows: "a test"}}
follower: {{mass: 1.221, stiffness: 1430.8, restitution: 0.8}}
cam: {{kind: arcs, base_radius: 0.4, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.40393320723821, nose_radius: 0.15, top_dwell_deg: 40, offset: 0.3}}
run: {{transient: 100, record: {1}}}
sweep: {{rpm: {{start: 690, stop: 745, num: 90}}, sections: [strobe]}}
"""


@pytest.mark.slow
def test_figures_killed_at_any_moment_end_the_same_and_leave_no_children(tmp_path):
    (tmp_path / "scenes").mkdir()
    for name, record in (("1.1", 4), ("1.2", 5)):
        (tmp_path / "scenes" / f"{name}.yaml").write_text(SCENE.format(name, record))
    words = ("figures", "--folder", str(tmp_path / "scenes"), "--threads", "2")
    began = time.perf_counter()
    assert run(command(*words, "-o", "new"), tmp_path)[0] == 0
    seconds = time.perf_counter() - began
    new, met = files(tmp_path / "new"), 0
    for how, part in ((signal.SIGKILL, 0.6), (signal.SIGINT, 0.5)):
        process = begin(command(*words, "-o", "out"), tmp_path)
        time.sleep(part * seconds)
        process.send_signal(how)
        code = ended(process)[0]
        assert gone(tmp_path)
        assert code in (0, 130, -how)
        met += code != 0
    assert met >= 1
    assert run(command(*words, "-o", "out"), tmp_path)[0] == 0
    assert but_record(files(tmp_path / "out")) == but_record(new)
    assert len(but_record(new)) == 6
