"""cam basins as a shell sees it: columns, codes, words, exit codes, bytes."""

import csv
import json
import signal
import subprocess
import sys
import time

import pytest

SMALL = ("--cells", "24", "--no-plot")
CODES = {"1", "2"}


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """`cam basins` of the default scene, run once: (process, folder)."""
    folder = tmp_path_factory.mktemp("bare")
    done = subprocess.run(
        [sys.executable, "-m", "camcli", "basins"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done, folder / "out/basins"


def test_bare_command_finds_both_attractors(bare):
    done, folder = bare
    assert done.returncode == 0, done.stderr
    found = rows(folder / "attractors.csv")
    assert list(found[0]) == [
        "attractor", "label", "q_m", "v_m_per_s", "fraction", "standard_error", "rpm",
    ]  # fmt: skip
    assert [(row["attractor"], row["label"]) for row in found] == [
        ("1", "P(1;2)"), ("2", "P(3;3:3:2)"),
    ]  # fmt: skip
    assert float(found[0]["q_m"]) == pytest.approx(0.546, abs=1e-3)
    assert float(found[0]["v_m_per_s"]) == pytest.approx(32.48, abs=1e-2)
    assert sum(float(row["fraction"]) for row in found) == pytest.approx(1.0)
    assert all(0.0 < float(row["standard_error"]) < 1e-3 for row in found)
    assert (folder / "basins.png").read_bytes()[:4] == b"\x89PNG"


def test_a_row_per_cell_at_its_centre(bare):
    table = rows(bare[1] / "basins.csv")
    assert list(table[0]) == ["q_m", "v_m_per_s", "attractor"]
    assert len(table) == 200 * 200
    assert {row["attractor"] for row in table} == CODES
    first, last = table[0], table[-1]
    assert (float(first["q_m"]), float(first["v_m_per_s"])) == pytest.approx((0.102, -49.75))
    assert (float(last["q_m"]), float(last["v_m_per_s"])) == pytest.approx((0.898, 49.75))
    share = sum(row["attractor"] == "1" for row in table) / len(table)
    assert share == float(rows(bare[1] / "attractors.csv")[0]["fraction"])
    for row in table[::997]:
        assert row["q_m"] == repr(float(row["q_m"]))
        assert row["v_m_per_s"] == repr(float(row["v_m_per_s"]))


def test_the_record_states_method_criterion_and_cost(bare):
    done, folder = bare
    record = json.loads((folder / "run.json").read_text())
    result = record["result"]
    assert result["method"] == "orbit"
    assert "whole period" in result["criterion"]
    (speed,) = result["speeds"]
    assert speed["undecided"] == 0
    assert speed["computed_share"] == 1.0
    assert 0.0 < speed["basin_entropy"] < speed["boundary_entropy"] < 0.7
    assert speed["uncertainty"] is None
    orbit = speed["attractors"][1]
    assert len(orbit["states_q_m_v_m_per_s"]) == orbit["turns"] == 3
    assert orbit["ring_of_starts_returns"] is True
    assert 0.0 < orbit["ellipse_radius_over_size"] <= 0.25
    assert len(orbit["multipliers"]) == 2
    assert set(record["artefacts"]) == {"attractors.csv", "basins.csv", "basins.png"}
    assert "impacts in" in done.stdout.splitlines()[-1]
    assert "P(3;3:3:2)" in done.stdout


def test_threads_kernels_and_repetition_give_the_same_bytes(cam_process, tmp_path):
    runs = {
        "one": (("--threads", "1"), {"CAMCLI_KERNEL": "compiled"}),
        "two": (("--threads", "2"), {"CAMCLI_KERNEL": "compiled"}),
        "auto": ((), {}),
    }
    for name, (words, env) in runs.items():
        done = cam_process("basins", "--cells", "30", "--refine", "1", *words, "-o", name, env=env)
        assert done.returncode == 0, done.stderr
    for name in ("attractors.csv", "basins.csv", "basins.png"):
        assert len({(tmp_path / run / name).read_bytes() for run in runs}) == 1, name


def test_plain_python_gives_the_same_bytes(cam_process, tmp_path):
    """At 700 rpm, where a turn has one impact."""
    for kernel in ("python", "compiled"):
        words = ("--rpm", "700", "--cells", "4,3", "--no-plot", "-o", kernel)
        done = cam_process("basins", *words, env={"CAMCLI_KERNEL": kernel})
        assert done.returncode == 0, done.stderr
    for name in ("attractors.csv", "basins.csv"):
        one, two = (tmp_path / kernel / name for kernel in ("python", "compiled"))
        assert one.read_bytes() == two.read_bytes()
    assert rows(two.parent / "attractors.csv")[0]["label"] == "P(1;1)"


def test_refined_cells_are_rows_of_their_own_size(cam, tmp_path):
    done = cam("basins", "--cells", "16", "--refine", "3", "--no-plot", "--json")
    (speed,) = json.loads(done.stdout)["result"]["speeds"]
    table = rows(tmp_path / "out/basins/basins.csv")
    assert speed["cells"] == 128 * 128
    assert speed["computed"] < 0.4 * speed["cells"]
    assert 256 < len(table) < speed["computed"]
    heights = sorted({row["v_m_per_s"] for row in table}, key=float)
    assert len(heights) > 128  # centres of cells of several sizes


def test_boundary_dimension_on_request(cam):
    done = cam("basins", *SMALL, "--boundary", "--json")
    found = json.loads(done.stdout)["result"]["speeds"][0]["uncertainty"]
    assert found["exponent"] + found["boundary_dimension"] == pytest.approx(2.0)
    assert 0.8 < found["exponent"] < 1.1
    assert len(found["error_share_count"]) >= 3


def test_simple_cell_mapping_says_so(cam, tmp_path):
    done = cam("basins", "--cells", "100", "--method", "simple", "--no-plot")
    assert "simple mapping" in done.stdout
    assert "P(3;3:3:2)" in done.stdout
    record = json.loads((tmp_path / "out/basins/run.json").read_text())
    assert "image of its centre" in record["result"]["criterion"]


def test_a_range_gives_fractions_by_speed_and_no_grid(cam, tmp_path):
    (tmp_path / "out/basins").mkdir(parents=True)
    (tmp_path / "out/basins/basins.csv").write_text("of an earlier run")
    done = cam("basins", "--rpm", "359:360", "--points", "3", "--cells", "12")
    assert done.returncode == 0, done.stderr
    found = rows(tmp_path / "out/basins/attractors.csv")
    assert [row["rpm"] for row in found] == ["359.0"] * 2 + ["359.5"] * 2 + ["360.0"] * 2
    by_number = {}
    for row in found:
        by_number.setdefault(row["attractor"], []).append(row["label"])
    assert by_number["1"] == ["P(1;2)"] * 3
    assert by_number["2"] == ["P(3;3:3:2)", "P(3;3:3:2)", "P(6;3:3:2:3:3:2)"]
    assert not (tmp_path / "out/basins/basins.csv").exists()
    assert (tmp_path / "out/basins/basins.png").read_bytes()[:4] == b"\x89PNG"


def test_window_and_cells_from_options(cam, tmp_path):
    done = cam("basins", "--q", "0.05:0.15", "--v=-2:2", "--cells", "10,4", "--no-plot")
    assert done.returncode == 0, done.stderr
    table = rows(tmp_path / "out/basins/basins.csv")
    assert len(table) == 40
    below = [row for row in table if row["attractor"] == "-1"]
    assert len(below) == 20
    assert all(float(row["q_m"]) < 0.1 for row in below)


def test_undecided_cells_are_counted_shown_and_said(cam, tmp_path):
    words = ("--rpm", "739.35", "--cells", "10", "--set", "basins.budget=40", "--no-plot")
    done = cam("basins", *words)
    assert done.returncode == 0
    assert "undecided" in done.stderr
    last = rows(tmp_path / "out/basins/attractors.csv")[-1]
    assert (last["attractor"], last["label"], last["q_m"]) == ("0", "undecided", "")
    assert float(last["fraction"]) > 0.5
    assert "undecided" in done.stdout


def test_trouble_keeps_the_rows_and_exits_3(cam, tmp_path):
    words = ("--set", "follower.stiffness=0", "--cells", "6")
    done = cam("basins", *words)
    assert done.returncode == 3
    assert "no-return in 36 cells" in done.stderr
    assert len(rows(tmp_path / "out/basins/basins.csv")) == 36
    assert rows(tmp_path / "out/basins/attractors.csv")[0]["label"] == "no-return"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--cells", "none"), "--cells: found 'none'"),
        (("--cells", "0"), "basins.cells"),
        (("--q", "0.5"), "--q: found '0.5', expected LO:HI"),
        (("--q", "0.9:0.1"), "found [0.9, 0.1], expected [low, high]"),
        (("--method", "magic"), "basins.method"),
        (("--method", "simple", "--refine", "2"), "basins.refine"),
        (("--refine", "11"), "basins.refine"),
        (("--cells", "16384", "--refine", "10"), "GB of memory"),
        (("--set", "basins.boundary=3"), "basins.boundary"),
    ],
)
def test_faults_are_said_before_any_work(cam, tmp_path, words, said):
    done = cam("basins", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_dry_run_gives_plan_and_cost(cam, tmp_path):
    done = cam("basins", "--cells", "1000", "--dry-run", "--json")
    assert done.returncode == 0, done.stderr
    planned = json.loads(done.stdout)["plan"]
    assert planned["orbits"] == 1_000_000
    assert 3e7 < planned["impacts"] < 6e8
    assert 2.0 < planned["seconds"] < 100.0
    assert planned["memory"] < 1e9
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_leaves_no_artefact(tmp_path):
    command = [sys.executable, "-m", "camcli", "basins", "--cells", "3000", "--no-plot"]
    how = {
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "preexec_fn": lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    }
    with subprocess.Popen(command, cwd=tmp_path, text=True, **how) as process:
        while not (tmp_path / "out/basins").exists():
            time.sleep(0.05)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        _, words = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in words
    left = [path.name for path in (tmp_path / "out/basins").iterdir()]
    assert all(name.startswith(".basins-") and name.endswith(".pieces") for name in left)


def test_help_documents_columns_codes_and_methods(cam):
    text = cam("basins", "--help").stdout
    words = ("attractors.csv", "basins.csv", "basins.png", "undecided", "-1 below the cam",
             "standard_error", "--refine", "--boundary", "--method", "--cells")  # fmt: skip
    assert all(word in text for word in words)
    assert "--refine" not in cam("sweep", "--help").stdout


def test_multipliers_and_exponents_are_appended_when_asked_for(cam, tmp_path):
    words = ("basins", "--rpm", "361", "--cells", "20", "--exponents", "--no-plot", "-o", "out")
    done = cam(*words)
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "out" / "attractors.csv", newline="") as file:
        found = {row["label"]: row for row in csv.DictReader(file)}
    # P(1;2): two impacts in a turn, complex multipliers, so ln|m| = ln(r^2) = 2 ln 0.8
    assert float(found["P(1;2)"]["lyapunov_per_period"]) == pytest.approx(-0.446287102628, rel=1e-9)
    assert float(found["P(1;2)"]["multiplier_1_im"]) > 0.0
    assert float(found["aperiodic"]["lyapunov_per_period"]) > 0.05
    assert found["aperiodic"]["multiplier_1_re"] == ""
