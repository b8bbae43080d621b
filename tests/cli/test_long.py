"""Long runs killed at chosen and at random moments: old artefacts stay, the end has the same bytes.

The soak (CAMCLI_SOAK=N) kills about N times, and says how long the ends took; some of the kills
meet a kernel that is being compiled.
"""

import json

import pytest

from camcli.errors import is_or_are, plural
from tests.support.long_runs import SOAK, Case, but_record, cam, with_options

pytestmark = pytest.mark.slow

FEW = (
    "--set", "run.transient=5", "--set", "run.record=5", "--set", "run.patience=0",
)  # fmt: skip
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


MOMENTS = [  # where, its count, artefacts that are new then, pieces that are on disk
    ("half", 1, 0, 0), ("half", 12, 0, 11), ("put", 7, 0, 6), ("put", 21, 0, 20),
    ("fsync", 1, 0, 21), *(("replace", k, k - 1, 21) for k in (1, 2, 4)),
    ("unlink", 1, 3, 21), ("unlink", 2, 3, 21),
]  # fmt: skip
SIGNALLED = {"SIGINT": (0, 1, 6, 9), "SIGTERM": (2, 4)}
KILLS = [
    *((*moment, "SIGKILL") for moment in MOMENTS),
    *((*MOMENTS[k], how) for how, some in SIGNALLED.items() for k in some),
]


@pytest.mark.parametrize(("where", "number", "new", "pieces", "how"), KILLS)
def test_killed_at_a_moment(case, where, number, new, pieces, how):
    code, said = case.die(where, number, how)
    assert code == (-9 if how == "SIGKILL" else 130), said
    assert "Traceback" not in said
    if code == 130 and where in ("replace", "unlink"):  # a signal waits until all are in place
        new, pieces = 4, 0
    elif code == 130 and where == "half":
        pieces += 1  # it is written whole on the way out
    told = f"{plural(pieces, 'piece')} {is_or_are(pieces)} on disk, the same command" in said
    assert told == (code == 130 and pieces > 0)
    assert case.check() == new
    said = case.finish()
    assert ("files of a run that was killed while it put them there" in said) == (0 < new < 4)
    assert (f"going on: {plural(pieces, 'piece')} " in said) == (pieces > 0)
    assert ("torn" in said) == (where == "half" and code == -9)
    record = json.loads((case.folder / "run.json").read_text())
    assert record["cost"]["pieces_from_disk"] == pieces
    assert (record["cost"]["impacts_per_s"] is None) == (pieces > 0)


def test_killed_before_the_pieces_are_forgotten(case):
    assert case.die("unlink", 3, "SIGKILL")[0] == -9
    assert case.check() == 4
    assert "going on: 21 pieces" in case.finish()


def test_unfinished_work_of_another_scene_is_told_and_kept(case):
    case.die("put", 5, "SIGKILL")
    code, said = cam((*with_options(SHORT, ("--points", "15")), "-o", "out"), case.cwd)
    assert code == 0
    assert "keeps unfinished work of other scenes" in said
    assert len(list(case.folder.glob(".*.pieces"))) == 1
    assert "going on: 4 pieces" in case.finish()


MANY = ("--set", "run.transient=60", "--set", "run.record=40")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "90", *MANY, "--no-plot")
RANGE = ("basins", "--rpm", "690:730", "--points", "3", "--cells", "16", "--threads", "2")
CASES = {
    "one thread": ((*SWEEP, "--threads", "1"), ("--points", "9")),
    "two threads": ((*SWEEP, "--threads", "2"), ("--points", "9")),
    "carried": ((*SWEEP, "--set", "sweep.direction=up"), ("--points", "9")),
    "basins": (("basins", "--cells", "40", "--no-plot"), ("--cells", "9")),
    "basins over a range": ((*RANGE, "--no-plot"), ("--points", "2")),
}


OTHERS = {
    "simulate": (("simulate", "--rpm", "745"), ("--rpm", "700")),
    "detach": (("detach", "--points", "200"), ("--points", "5")),
    "orbits": (("orbits", "--rpm", "690:745", "--points", "5"), ("--rpm", "700")),
    "classify": (("classify", "--rpm", "735:745", "--points", "12"), ("--points", "2")),
    "sweep with its picture": (SWEEP[:-1], ("--points", "9")),
    "proved": (("orbits", "--prove", "--no-plot", "--rpm", "700"), ("--rpm", "720")),
    "page": (("explore", "--rpm", "690:745", "--points", "4", *MANY), ("--points", "2")),
    "explained": ((*SWEEP[:3], "--points", "3", "--explain", *MANY), ("--points", "2")),
    "report": (("detach", "--report", "--points", "30"), ("--points", "5")),
    "animated": (("simulate", "--rpm", "700", "--animate", "--no-plot"), ("--rpm", "710")),
    "bench": (
        ("bench", "precision", "--quick", "--set", "bench.methods=[core]", "--no-plot"),
        ("--set", "bench.cases=[periodic]"),
    ),
    "merged": (("merge", "parts"), None, tuple(
        (*SWEEP[:-1], "--shard", f"{k}/2", "-o", "parts") for k in (1, 2)
    )),
    "run again": (("rerun", "before"), None, ((*SWEEP[:-1], "-o", "before"),)),
    "cluster": ((*SWEEP, "--cluster", "local"), ("--points", "9"), (), True),
}  # fmt: skip


@pytest.mark.parametrize("name", ["two threads", "basins over a range"])
def test_killed_at_random_moments(tmp_path, name):
    words, earlier = CASES[name]
    Case(tmp_path, words, earlier).soak(list(CASES).index(name), 1)


SCENE = """
figure: {title: "A figure", command: sweep, shows: "a test"}
follower: {mass: 1.221, stiffness: 1430.8, restitution: 0.8}
cam: {kind: arcs, base_radius: 0.4, flank_center: 0.45, flank_radius: 0.85,
      nose_center: 0.40393320723821, nose_radius: 0.15, top_dwell_deg: 40, offset: 0.3}
run: {transient: 100, record: 4}
sweep: {rpm: {start: 690, stop: 745, num: 60}, sections: [strobe]}
"""


def figures(tmp_path):
    """`cam figures` of one figure."""
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "1.1.yaml").write_text(SCENE)
    words = ("figures", "--folder", str(tmp_path / "scenes"), "--threads", "2")
    return Case(tmp_path, words, None, (), True)


@pytest.mark.soak
def test_figures_killed_at_any_moment_end_the_same_and_leave_no_children(tmp_path):
    case = figures(tmp_path)
    case.soak(1, 1)
    assert len(but_record(case.new)) == 3


COLD_SHARE = 30  # compiling takes half a minute: so many warm kills to a cold one


@pytest.mark.soak
@pytest.mark.parametrize("cold", [False, True], ids=["warm", "cold"])
@pytest.mark.parametrize("name", [*CASES, *OTHERS, "figures"])
def test_killed_many_times(tmp_path, name, cold, capsys):
    count = -(-SOAK // (len(CASES) + len(OTHERS) + 1) // (COLD_SHARE if cold else 1))
    words = (CASES | OTHERS).get(name)
    case = figures(tmp_path) if words is None else Case(tmp_path, *words)
    seen = case.soak(count, count, cold)
    with capsys.disabled():
        print(f"\n{name}: {count} kills, cold: {cold}, {seen}")
