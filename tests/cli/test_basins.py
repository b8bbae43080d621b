"""cam basins as a shell sees it: columns, codes, words, exit codes, bytes."""

import json

import pytest

from tests.conftest import rows


@pytest.fixture
def run(cam, tmp_path):
    """Run the command without a picture: (process, folder of its artefacts)."""

    def call(*words):
        return cam("basins", *words, "--no-plot"), tmp_path / "out/basins"

    return call


@pytest.mark.slow
def test_attractors_cells_and_record(run):
    done, folder = run("--cells", "40,30", "--boundary")
    assert done.returncode == 0, done.stderr
    found, table = rows(folder / "attractors.csv"), rows(folder / "basins.csv")
    columns = "attractor", "label", "q_m", "v_m_per_s", "fraction", "standard_error", "rpm"
    assert tuple(found[0]) == columns
    assert [(row["attractor"], row["label"]) for row in found] == [
        ("1", "P(1;2)"), ("2", "P(3;3:3:2)"),
    ]  # fmt: skip
    assert float(found[0]["q_m"]) == pytest.approx(0.546, abs=1e-3)
    assert float(found[0]["v_m_per_s"]) == pytest.approx(32.48, abs=1e-2)
    assert sum(float(row["fraction"]) for row in found) == pytest.approx(1.0)
    assert all(0.0 < float(row["standard_error"]) < 1e-2 for row in found)
    assert tuple(table[0]) == ("q_m", "v_m_per_s", "attractor")
    assert len(table) == 40 * 30
    assert (float(table[0]["q_m"]), float(table[0]["v_m_per_s"])) == pytest.approx((0.11, -145 / 3))
    share = sum(row["attractor"] == "1" for row in table) / len(table)
    assert share == float(found[0]["fraction"])
    record = json.loads((folder / "run.json").read_text())
    assert set(record["artefacts"]) == {"attractors.csv", "basins.csv"}
    result = record["result"]
    assert result["method"] == "orbit"
    assert "whole period" in result["criterion"]
    (speed,) = result["speeds"]
    assert (speed["undecided"], speed["computed_share"]) == (0, 1.0)
    assert 0.0 < speed["basin_entropy"] < speed["boundary_entropy"] < 0.7
    doubt = speed["uncertainty"]
    assert doubt["exponent"] + doubt["boundary_dimension"] == pytest.approx(2.0)
    assert 0.8 < doubt["exponent"] < 1.1
    orbit = speed["attractors"][1]
    assert len(orbit["states_q_m_v_m_per_s"]) == orbit["turns"] == 3
    assert orbit["ring_of_starts_returns"] is True
    assert 0.0 < orbit["ellipse_radius_over_size"] <= 0.25
    assert "impacts in" in done.stdout.splitlines()[-1]
    assert "boundary dimension" in done.stdout


def test_refined_cells_are_rows_of_their_own_size(run):
    done, folder = run("--cells", "16", "--refine", "2", "--json")
    (speed,) = json.loads(done.stdout)["result"]["speeds"]
    table = rows(folder / "basins.csv")
    assert speed["cells"] == 64 * 64
    assert 256 < len(table) < speed["computed"] < 0.6 * speed["cells"]
    assert len({row["v_m_per_s"] for row in table}) > 64  # centres of cells of several sizes


def test_a_range_gives_fractions_by_speed_and_no_grid(run):
    _, folder = run("--cells", "2")
    assert (folder / "basins.csv").exists()
    done, folder = run("--rpm", "359.6:360.2", "--points", "4", "--cells", "8", "--exponents")
    assert done.returncode == 0, done.stderr
    found = rows(folder / "attractors.csv")
    assert [row["rpm"] for row in found] == ["359.6"] * 2 + ["359.8"] * 2 + ["360.0"] * 2 + [
        "360.2"
    ] * 2
    by_number = {n: [row["label"] for row in found if row["attractor"] == n] for n in "12"}
    assert by_number["1"] == ["P(1;2)"] * 4
    assert by_number["2"] == ["P(3;3:3:2)"] + ["P(6;3:3:2:3:3:2)"] * 3
    # P(1;2): two impacts in a turn, complex multipliers, so ln|m| = ln(r^2) = 2 ln 0.8
    assert float(found[0]["lyapunov_per_period"]) == pytest.approx(-0.446287102628, rel=1e-9)
    assert float(found[0]["multiplier_1_im"]) > 0.0
    assert not (folder / "basins.csv").exists()


def test_cells_below_the_cam_undecided_cells_and_trouble(run):
    _, folder = run("--q", "0.05:0.15", "--v=-2:2", "--cells", "10,4")
    below = [row for row in rows(folder / "basins.csv") if row["attractor"] == "-1"]
    assert len(below) == 20
    assert all(float(row["q_m"]) < 0.1 for row in below)
    done, _ = run("--rpm", "739.35", "--cells", "8", "--set", "basins.budget=40")
    assert done.returncode == 0
    assert "undecided" in done.stderr
    last = rows(folder / "attractors.csv")[-1]
    assert (last["attractor"], last["label"], last["q_m"]) == ("0", "undecided", "")
    assert "undecided" in done.stdout
    done, _ = run("--set", "follower.stiffness=0", "--cells", "6")
    assert done.returncode == 3
    assert "no-return in 36 cells" in done.stderr
    assert len(rows(folder / "basins.csv")) == 36
    assert rows(folder / "attractors.csv")[0]["label"] == "no-return"


def test_a_few_speeds_have_their_cells_and_saddles(run):
    words = "--rpm", "358:359", "--points", "2", "--cells", "16", "--saddles"
    done, folder = run(*words)
    assert done.returncode == 0, done.stderr
    found, cells = rows(folder / "saddles.csv"), rows(folder / "basins.csv")
    assert [(row["rpm"], row["label"]) for row in found] == [
        ("358.0", "P(1;2)"),
        ("359.0", "P(1;2)"),
    ]
    assert all(row["led"] == row["tried"] == "24" for row in found)
    for rpm in ("358.0", "359.0"):
        own = [row["attractor"] for row in cells if row["rpm"] == rpm]
        (share,) = (float(row["fraction"]) for row in rows(folder / "attractors.csv")
                    if (row["rpm"], row["attractor"]) == (rpm, "1"))  # fmt: skip
        assert own.count("1") / len(own) == pytest.approx(share)


def test_another_number_that_is_varied_is_the_first_column(cam, tmp_path):
    words = "--rpm 700 --vary follower.restitution=0.8:0.81 --points 2 --cells 4 --no-plot"
    cam(f"basins {words} -o out", code=0)
    for name, last in (("basins", "attractor"), ("attractors", "rpm")):
        columns = list(rows(tmp_path / f"out/{name}.csv")[0])
        assert (columns[0], columns[-1]) == ("follower.restitution", last)
