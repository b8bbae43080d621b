"""cam orbits as a user runs it: files, options, answers to what does not exist.

The numbers are those of the library, which tests/published and tests/analysis hold to account.
"""

import json
from math import hypot, isclose, pi, tan

import pytest

from tests.conftest import rows

QUICK = "--set orbits.starts=0 --set run.transient=50"


@pytest.mark.slow
def test_the_bare_command(cam, tmp_path):
    """Branches, bifurcations, sentences and pictures of the example's range."""
    done = cam("orbits -o out --verbose", QUICK, code=0)
    found = {(row["label"], row["kind"], row["corner"]): row
             for row in rows(tmp_path / "out" / "bifurcations.csv")}  # fmt: skip
    corner = found["P(1;1)", "corner-impact", "b"]
    assert float(corner["rpm"]) == pytest.approx(673.2344450038120, rel=1e-13)
    assert float(corner["trace_left"]) == pytest.approx(1.6418699, abs=5e-8)
    assert float(corner["det_right"]) == pytest.approx(0.64, rel=1e-14)
    assert corner["classification"] == "nonsmooth-fold"
    second = found["P(2;1:1)", "corner-impact", "c"]
    assert float(second["rpm"]) == pytest.approx(739.3779296493, rel=1e-12)
    assert all(float(row["rpm_error"]) < 1e-9 for row in found.values())
    points = rows(tmp_path / "out" / "branch.csv")
    for number, stable, region in (("1", "1", "A2"), ("2", "0", "A1")):
        own = [row for row in points if row["branch"] == number]
        assert {row["region"] for row in own} == {region}
        assert (own[1]["stable"], own[-1]["rpm"]) == (stable, "756.0")
    doubled = [row for row in points if row["label"] == "P(2;1:1)"]
    assert {row["region"] for row in doubled} == {"A2:A2", "A2:A3"}
    assert all(float(row["theta_deg_2"]) > 0.0 for row in doubled)
    result = json.loads((tmp_path / "out" / "run.json").read_text())["result"]
    corners = [b for b in result["bifurcations"] if b["kind"] == "corner-impact"]
    assert all(b["prediction_agrees"] and b["inequalities"] and b["words"] for b in corners)
    assert "Neimark-Sacker bifurcations are impossible" in done.stdout
    assert "The class rests on: " in done.stdout
    assert (tmp_path / "out" / "orbits.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_budget_of_work_ends_the_search_and_keeps_what_was_found(cam, tmp_path, monkeypatch):
    """The same rows as far as they go, by either kernel, and a sentence that names the knob."""
    assert cam("orbits --no-plot -o whole", QUICK).returncode == 0
    words = f"orbits --no-plot {QUICK} --set run.work_budget=1500000 -o"
    done = cam(words, "part", code=3)
    assert "work-budget: the budget of work was used up" in done.stderr
    assert "raise run.work_budget" in done.stderr
    result = json.loads((tmp_path / "part" / "run.json").read_text())["result"]
    assert result["status"] == "work-budget"
    assert "work-budget" in result["branches"][-1]["ends"]
    for name in ("branch.csv", "bifurcations.csv"):
        whole, part = (
            [{k: v for k, v in row.items() if v} for row in rows(tmp_path / folder / name)]
            for folder in ("whole", "part")
        )
        assert all(row in whole for row in part)
        assert len(part) < len(whole)
    assert len(rows(tmp_path / "part" / "branch.csv")) > 10
    monkeypatch.setenv("CAMCLI_KERNEL", "compiled")
    assert cam(words, "other").returncode == 3
    same = [(tmp_path / name / "branch.csv").read_bytes() for name in ("part", "other")]
    assert same[0] == same[1]


def test_proofs_share_the_budget_of_work(cam, tmp_path):
    words = ("--rpm", "700", "--set", "orbits.starts=2", "--set", "run.work_budget=90000")
    done = cam("orbits", "--prove", "--no-plot", *words, "-o", "out", code=3)
    assert "not proved: P(1;1): the budget of work was used up" in done.stdout
    assert [row["proved"] for row in rows(tmp_path / "out" / "branch.csv")] == ["yes", "no"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--rpm", "660", "--label", "P(1;1)"), ("not found at 660 rpm", "673.23444500")),
        (("--rpm", "700", "--label", "P(2;9:9)"), ("nor at 24 speeds",)),
    ],
)
def test_an_absent_label_is_answered(cam, words, said):
    done = cam("orbits", *words, "--no-plot", QUICK, code=0)
    assert all(text in done.stdout for text in said)


def test_where_a_branch_is_stable_and_turns_is_told(cam, tmp_path):
    """Born in a fold, doubled at the end: both are proved in tests/published."""
    fold, doubling = 357.7983058636, 359.6205255980
    words = ("--rpm", "350:365", "--at", "358.5", "--label", "P(3;3:3:2)", "--no-plot", "-o", "out")
    done = cam("orbits", *words, QUICK, code=0)
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("1 ") and "to" in line]
    assert "357.7983 to 359.6205  357.7983 " in line
    found = json.loads((tmp_path / "out" / "run.json").read_text())["result"]["branches"]
    assert found[0]["stable_ranges"] == [pytest.approx([fold, doubling], rel=1e-12)]
    assert found[0]["turning_points"] == pytest.approx([fold], rel=1e-12)
    assert found[1]["stable_ranges"][0][0] == pytest.approx(
        doubling, rel=1e-12
    )  # the doubled orbit
    for row in rows(tmp_path / "out" / "branch.csv"):  # by its multipliers
        moduli = [hypot(*(float(row[f"multiplier_{k}_{part}"]) for part in ("re", "im")))
                  for k in (1, 2)]  # fmt: skip
        mine = found[int(row["branch"]) - 1]
        ranges = mine["stable_ranges"]
        turns = any(isclose(float(row["rpm"]), x, rel_tol=1e-14) for x in mine["turning_points"])
        assert turns == (row["turns_round"] == "1")
        if row["stable"] == "1":
            assert [float(row["stable_from"]), float(row["stable_to"])] in ranges
        else:
            assert row["stable_from"] == row["stable_to"] == ""
        if max(moduli) < 0.999:
            assert any(low < float(row["rpm"]) < high for low, high in ranges)
    events = done.stdout.partition("Bifurcations")[2].partition("\n- ")[0].splitlines()[3:]
    shown = [(int(line.split()[0]), float(line.split()[-1])) for line in events]
    assert shown == sorted(shown)
    assert len(shown) > 3


def test_an_orbit_that_the_search_missed_is_found_from_its_neighbours(cam):
    words = ("--rpm", "378:380", "--at", "379", "--label", "P(3;3:3:2)", "--no-plot")
    done = cam("orbits", *words, code=0)
    assert "was not found" not in done.stdout
    assert "Periodic orbits at 379 rpm" in done.stdout


def closure(r):
    """c at corner b of a P(1;1) at 700 rpm: c = (1 + r)/(1 - r) cot(pi W) c_theta/W."""
    w, slope = 34.2319495767677805 / (700 * pi / 30), 0.2747021271326710
    return (1 + r) / (1 - r) / tan(pi * w) / w * slope


def test_another_parameter_and_its_column(cam, tmp_path):
    cam("orbits --rpm 700 --parameter restitution --range 0.5:0.9 --no-plot -o out", QUICK, code=0)
    points = rows(tmp_path / "out" / "branch.csv")
    assert {row["rpm"] for row in points} == {"700.0"}
    corner = rows(tmp_path / "out" / "bifurcations.csv")[0]
    r = float(corner["restitution"])
    assert closure(r) == pytest.approx(0.2312555620189976, rel=1e-11)


@pytest.mark.slow
def test_a_curve_in_two_parameters_passes_through_known_points(cam, tmp_path):
    done = cam(
        "orbits --curve corner-impact --in restitution --range 0.7:0.8 -o out", QUICK, code=0
    )
    points = rows(tmp_path / "out" / "curve.csv")
    assert "curve 1 ends: end-of-range of restitution; end-of-range of restitution" in done.stdout
    titles = [line.strip() for line in done.stdout.splitlines() if line.strip().startswith("Curve")]
    assert titles[0] == "Curve 1: corner-impact of P(1;1) at b"
    ends = {row["restitution"]: row for row in points if row["label"] == "P(1;1)"}
    assert float(ends["0.7"]["rpm"]) == pytest.approx(684.646551556922, rel=1e-12)
    assert float(ends["0.7"]["trace_left"]) == pytest.approx(1.49419492988210, rel=1e-11)
    assert float(ends["0.8"]["rpm"]) == pytest.approx(673.234445003812, rel=1e-12)
    assert (tmp_path / "out" / "curve.png").read_bytes().startswith(b"\x89PNG")
    assert cam("orbits --rpm 700 --no-plot -o out", QUICK).returncode == 0
    assert not (tmp_path / "out" / "curve.png").exists()


def test_a_curve_in_two_constants_of_the_follower(cam, tmp_path):
    """The corner impact of P(1;1) at b: where damping is 0, r is that of the closed equation."""
    done = cam(
        "orbits --rpm 700 --curve corner-impact",
        "--parameter restitution --range 0.5:0.9",
        "--in damping=0:0.5 --no-plot -o out",
        QUICK,
        code=0,
    )
    points = rows(tmp_path / "out" / "curve.csv")
    assert list(points[0])[4:6] == ["restitution", "damping_n_s_per_m"]
    r = next(float(row["restitution"]) for row in points if row["damping_n_s_per_m"] == "0.0")
    assert closure(r) == pytest.approx(0.2312555620189976, rel=1e-11)
    assert "end-of-range of damping" in done.stdout


def test_a_curve_of_what_does_not_happen_is_no_success(cam):
    done = cam("orbits --rpm 699:702 --curve grazing --no-plot", QUICK, code=3)
    assert "no grazing was located" in done.stderr


def test_a_continuum_on_a_dwell_is_said_to_be_one(cam, tmp_path):
    """Elastic and undamped: P(1;1) at any phase of either dwell, and no orbit at their ends."""
    done = cam("orbits --rpm 700 --set follower.restitution=1 --no-plot -o out", QUICK)
    assert "P(1;1) exists with its impact anywhere from 160 to 200 deg" in done.stdout
    assert not [row for row in rows(tmp_path / "out" / "branch.csv") if row["label"] == "P(1;1)"]
    result = json.loads((tmp_path / "out" / "run.json").read_text())["result"]
    ends = [(c["from_deg"], c["to_deg"]) for c in result["continua"]]
    assert ends == [pytest.approx((160.0, 200.0)), pytest.approx((270.0, 450.0))]


ONE = "orbits --rpm 690:710 --points 5 --label P(1;1) --branches 0"


@pytest.mark.parametrize(("which", "stable"), [("stable", "1"), ("unstable", "0")])
def test_only_stable_or_unstable_orbits_are_followed(cam, tmp_path, which, stable):
    cam(f"{ONE} --set orbits.stability={which} --no-plot -o out", code=0)
    points = rows(tmp_path / "out" / "branch.csv")
    assert {(row["branch"], row["stable"]) for row in points} == {("1", stable)}


def test_at_one_speed_there_are_no_motions_to_simulate_behind_branches(cam, tmp_path):
    cam("orbits --rpm 700 --set orbits.simulated=3 --set orbits.starts=0 --no-plot", code=0)
    assert not (tmp_path / "out/orbits/impacts.csv").exists()


def test_simulated_motions_are_drawn_behind_the_branches(cam, tmp_path):
    words = "--rpm 738:739 --points 5 --at 738.5 --label P(1;1)"
    cam(
        f"orbits {words} --set orbits.simulated=3 --set orbits.stability=stable --no-plot",
        QUICK,
        code=0,
    )
    seen = {
        float(r["rpm"]): float(r["theta_deg"]) for r in rows(tmp_path / "out/orbits/impacts.csv")
    }
    solved = {
        float(r["rpm"]): float(r["theta_deg_1"]) for r in rows(tmp_path / "out/orbits/branch.csv")
    }
    assert set(seen) == {738.0, 738.5, 739.0}
    for rpm in set(seen) & set(solved):  # the simulation has settled on the branch
        assert seen[rpm] == pytest.approx(solved[rpm], abs=1e-6)


@pytest.mark.parametrize("at", ["700", "701"])
def test_orbits_may_be_looked_for_at_the_ends_of_the_range(cam, tmp_path, at):
    line = f"orbits --rpm 700:701 --at {at} --points 2 --no-plot -o . --set orbits.starts=0"
    cam(line, "--set run.transient=10 --set run.record=10", code=0)
    (shown,) = {
        row["rpm"] for row in json.loads((tmp_path / "run.json").read_text())["result"]["orbits"]
    }
    assert shown == float(at)


def test_a_curve_over_speeds_is_the_same_however_they_are_given(cam, tmp_path):
    """--vary rpm names the first number alone; the second has a range about the scene's value."""
    few = "--curve corner-impact --points 4 --set orbits.starts=2 --no-plot"
    cam(f"orbits --rpm 670:680 {few} -o one", code=0)
    cam(f"orbits --vary rpm=670:680 {few} -o other", code=0)
    one, other = (tmp_path / name / "curve.csv" for name in ("one", "other"))
    assert len(one.read_text().splitlines()) > 2
    assert other.read_bytes() == one.read_bytes()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("--vary follower.mass=2:3", "orbits.vary: found 2.0 to 3.0, expected a range that holds"),
        ("--parameter mass --range 2:3", "orbits.range: found 2.0 to 3.0, expected a range that"),
        ("--vary cam.nose_radius=0.2:0.3", "orbits.vary: found 0.2 to 0.3, expected a range that"),
        (
            "--vary follower.restitution=-1:2",
            "expected of restitution a number of at least 0, corr",
        ),
        ("--parameter restitution --range 0.5:2", "of restitution a number of at most 1, correct"),
        (
            "--curve fold --in cam.nose_radius=0:0.2 --in rpm=600:700",
            "orbits.vary: cam.nose_radius: found 0.0, expected a number greater than 0",
        ),
    ],
)
def test_a_range_is_refused_where_it_was_given(cam, line, said):
    assert said in cam(f"orbits {line}", code=2).stderr
