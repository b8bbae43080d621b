"""cam orbits as a user runs it: the model's numbers, options, answers to what does not exist."""

import csv
import json
from math import pi, tan

import pytest


def rows(path):
    """A CSV as dictionaries."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def near(text, value, relative=1e-9):
    """A number of a CSV agrees with the published one."""
    return float(text) == pytest.approx(value, rel=relative)


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """`cam orbits --no-plot`, the chapter's range."""
    import subprocess
    import sys

    folder = tmp_path_factory.mktemp("orbits")
    words = [sys.executable, "-m", "camcli", "orbits", "--no-plot", "-o", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_published_bifurcations_come_out_of_the_bare_command(bare):
    found = rows(bare[0] / "bifurcations.csv")
    corner, doubling, second = (
        next(row for row in found if (row["label"], row["kind"]) == key)
        for key in (
            ("P(1;1)", "corner-impact"),
            ("P(1;1)", "period-doubling"),
            ("P(2;1:1)", "corner-impact"),
        )
    )  # fmt: skip
    assert near(corner["rpm"], 673.2344450038120, 1e-13)
    assert (corner["corner"], corner["classification"]) == ("b", "nonsmooth-fold")
    assert near(corner["trace_left"], 1.6418699, 5e-8)
    assert near(corner["trace_right"], 1.3714214, 5e-8)
    assert near(corner["det_left"], 0.64, 1e-15)
    assert near(doubling["rpm"], 739.3197802160, 1e-12)
    assert near(second["rpm"], 739.3779296493, 1e-12)
    assert second["corner"] == "c"
    assert near(second["trace_left"], 1.3816246, 5e-8)
    assert near(second["trace_right"], -4.0910731, 5e-8)
    assert near(second["det_right"], 0.4096, 1e-14)
    assert all(float(row["rpm_error"]) < 1e-9 for row in found)


def test_both_branches_run_from_the_corner_impact_to_the_end_of_the_range(bare):
    points = [row for row in rows(bare[0] / "branch.csv") if row["label"] == "P(1;1)"]
    for stable, region, number in (("1", "A2", "1"), ("0", "A1", "2")):
        own = [row for row in points if row["branch"] == number]
        assert near(own[0]["rpm"], 673.2344450038120, 1e-13)
        assert float(own[-1]["rpm"]) == 756.0
        assert {row["region"] for row in own} == {region}
        assert own[1]["stable"] == stable
        at_corner = own[0]
    assert near(at_corner["multiplier_1_re"], 1.0051474, 1e-7)
    assert near(at_corner["multiplier_2_re"], 0.6367225, 1e-7)
    first = next(row for row in points if row["branch"] == "1")
    assert near(first["multiplier_1_re"], 0.6857107, 1e-7)
    assert near(first["multiplier_1_im"], 0.4120689, 1e-7)


def test_the_doubled_branch_is_followed_through_the_corner(bare):
    own = [row for row in rows(bare[0] / "branch.csv") if row["label"] == "P(2;1:1)"]
    assert {row["region"] for row in own} == {"A2:A2", "A2:A3"}
    assert all((float(row["rpm"]) < 739.37793) == (row["region"] == "A2:A2") for row in own[:3])
    assert all(float(row["theta_deg_2"]) > 0.0 for row in own)


def test_words_compare_the_prediction_with_a_simulation(bare):
    record = json.loads((bare[0] / "run.json").read_text())["result"]
    corners = [b for b in record["bifurcations"] if b["kind"] == "corner-impact"]
    assert all(b["prediction_agrees"] for b in corners)
    assert all(b["inequalities"] for b in corners)
    assert "Neimark-Sacker bifurcations are impossible" in bare[1]
    assert "Rests on: " in bare[1]


def test_orbits_at_one_speed(cam, tmp_path):
    done = cam("orbits", "--rpm", "700", "--no-plot", "-o", "out")
    assert done.returncode == 0
    stable, unstable = rows(tmp_path / "out" / "branch.csv")
    assert near(stable["theta_deg_1"], 155.3036856027, 1e-12)
    assert near(stable["trace"], 0.6027216709, 1e-9)
    assert near(unstable["theta_deg_1"], 104.1608293878, 1e-12)
    assert near(unstable["trace"], 1.9307756743, 1e-10)
    assert (stable["stable"], unstable["stable"]) == ("1", "0")
    assert not rows(tmp_path / "out" / "bifurcations.csv")


def test_coexisting_orbits_at_358_5(cam, tmp_path):
    done = cam("orbits", "--rpm", "358.5", "--no-plot", "-o", "out")
    assert done.returncode == 0
    found = {row["label"]: row for row in rows(tmp_path / "out" / "branch.csv")}
    assert set(found) == {"P(1;2)", "P(3;3:3:2)"}
    assert float(found["P(1;2)"]["q_m"]) == pytest.approx(0.546, abs=5e-4)
    assert float(found["P(1;2)"]["v_m_per_s"]) == pytest.approx(32.48, abs=5e-3)


def test_the_chattering_orbit_has_zero_multipliers_and_named_ends(cam, tmp_path):
    done = cam("orbits", "--rpm", "100:205", "--at", "190", "--no-plot", "-o", "out")
    assert done.returncode == 0
    points = rows(tmp_path / "out" / "branch.csv")
    assert {row["label"] for row in points} == {"P(1;inf)"}
    assert {row["multiplier_1_re"] for row in points} == {"0.0"}
    found = {row["kind"]: row for row in rows(tmp_path / "out" / "bifurcations.csv")}
    assert near(found["detachment"]["rpm"], 114.979326744, 1e-11)
    assert near(found["chatter-completion"]["rpm"], 198.5605, 1e-7)
    assert near(found["departure"]["rpm"], 136.312, 3e-6)
    assert found["departure"]["corner"] == "d"


def test_an_absent_label_is_answered_with_the_nearest_speed(cam):
    done = cam("orbits", "--rpm", "660", "--label", "P(1;1)", "--no-plot")
    assert done.returncode == 0
    assert "not found at 660 rpm" in done.stdout
    assert "673.23444500" in done.stdout


def test_a_label_nobody_has_is_answered_with_none(cam):
    done = cam("orbits", "--rpm", "700", "--label", "P(2;9:9)", "--no-plot", "--set",
               "orbits.starts=2", "--set", "run.transient=50")  # fmt: skip
    assert done.returncode == 0
    assert "nor at 24 speeds" in done.stdout


def test_another_parameter_and_its_column(cam, tmp_path):
    done = cam("orbits", "--rpm", "700", "--parameter", "restitution", "--range", "0.5:0.9",
               "--no-plot", "-o", "out", "--set", "orbits.starts=0")  # fmt: skip
    assert done.returncode == 0
    points = rows(tmp_path / "out" / "branch.csv")
    assert {row["rpm"] for row in points} == {"700.0"}
    assert min(float(row["restitution"]) for row in points) > 0.58
    corner = rows(tmp_path / "out" / "bifurcations.csv")[0]
    r = float(corner["restitution"])
    w = 34.2319495767677805 / (700 * pi / 30)  # closure at b: c = (1+r)/(1-r) cot(pi W) c_theta/W
    c, slope = 0.2312555620189976, 0.2747021271326710
    assert c == pytest.approx((1 + r) / (1 - r) / tan(pi * w) / w * slope, rel=1e-11)


def test_a_curve_in_two_parameters_passes_through_known_points(cam, tmp_path):
    done = cam("orbits", "--curve", "corner-impact", "--in", "restitution", "--range", "0.7:0.8",
               "--no-plot", "-o", "out", "--set", "orbits.starts=0")  # fmt: skip
    assert done.returncode == 0
    points = rows(tmp_path / "out" / "curve.csv")
    ends = {row["restitution"]: row for row in points if row["label"] == "P(1;1)"}
    assert near(ends["0.7"]["rpm"], 684.646551556922, 1e-12)
    assert near(ends["0.7"]["trace_left"], 1.49419492988210, 1e-11)
    assert near(ends["0.8"]["rpm"], 673.234445003812, 1e-12)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--label", "P(3;1:1)"], "orbits.label"),
        (["--label", "hello"], "expected P(m;s1:...:sm)"),
        (["--rpm", "700", "--parameter", "damping"], "give one, e.g. --range 0:2"),
        (["--parameter", "colour"], "orbits.parameter"),
        (["--range", "3", "--parameter", "mass"], "expected two numbers LO:HI"),
        (["--parameter", "restitution", "--range", "0.5:1.5"], "expected values from 0 to 1"),
        (["--parameter", "restitution", "--range", "0.9:0.5"], "exchange them"),
        (["--curve", "fold", "--in", "rpm"], "orbits.curve_in"),
        (["--curve", "fold", "--rpm", "700"], "give --rpm LO:HI"),
        (["--branches", "-1"], "orbits.branches"),
    ],
)
def test_bad_usage_is_one_clear_message(cam, words, said):
    done = cam("orbits", "--no-plot", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_dry_run_writes_nothing(cam, tmp_path):
    done = cam("orbits", "--dry-run")
    assert done.returncode == 0
    assert "orbits" in done.stdout
    assert not (tmp_path / "out").exists()


def test_a_curve_has_its_picture(cam, tmp_path):
    words = ("orbits", "--rpm", "670:745", "--points", "40", "--set", "orbits.starts=0")
    curve = ("--curve", "period-doubling", "--in", "damping", "--range", "0:4")
    assert cam(*words, *curve, "-o", "out").returncode == 0
    assert (tmp_path / "out" / "curve.png").read_bytes().startswith(b"\x89PNG")
    assert cam(*words[:3], "-o", "out").returncode == 0
    assert not (tmp_path / "out" / "curve.png").exists()
