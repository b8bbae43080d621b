"""cam sweep over two numbers: the map's rows, its borders, its picture, its pieces."""

import json

import numpy as np
import pytest

from camcli import check, load_scene, sweep
from tests.conftest import rows
from tests.support.orbit_oracle import CAM, CHAPTER, STABLE, B, corner_rpm, period_doubling_rpm

SMALL = "--set run.transient=100 --set run.record=30"
PLANE = "--rpm 690:700 --vary follower.restitution=0.7:0.8 --points 3,2"


def test_a_row_per_point_with_the_columns_of_its_speed(cam, tmp_path):
    cam(f"sweep {PLANE} {SMALL} --lyapunov --panels kind,max_gap_m,exponents", code=0)
    found = rows(tmp_path / "out/sweep/map.csv")
    assert [(r["rpm"], r["follower.restitution"]) for r in found] == [
        (rpm, r) for r in ("0.7", "0.8") for rpm in ("690.0", "695.0", "700.0")
    ]
    last = found[-1]
    assert (last["label"], last["period"], last["impacts_per_turn"]) == ("P(1;1)", "1", "1.0")
    cam(f"sweep --rpm 700 {SMALL} --lyapunov --no-plot -o one")
    (one,) = rows(tmp_path / "one/speeds.csv")
    shared = set(one) & set(last)
    assert shared >= {"label", "lyapunov_per_period", "max_gap_m", "max_impact_m_per_s", "status"}
    assert {name: last[name] for name in shared} == {name: one[name] for name in shared}
    assert (tmp_path / "out/sweep/map.png").read_bytes()[:4] == b"\x89PNG"
    result = json.loads((tmp_path / "out/sweep/run.json").read_text())["result"]
    assert sum(entry["points"] for entry in result["labels"]) == 6


def test_points_that_rounding_decides_are_counted_and_decided_as_a_sweep_does(cam, tmp_path):
    speeds = f"--rpm 358.04:358.1 --no-plot {SMALL}"
    words = "--vary follower.restitution=0.8:0.8 --points 2,1"
    done = cam("sweep", speeds, words)
    assert {row["label"] for row in rows(tmp_path / "out/sweep/map.csv")} == {"undecided"}
    assert "2 of 2 points are undecided" in done.stderr
    assert "--decide" in done.stderr
    assert "undecided" not in cam("sweep", speeds, f"{words} --decide").stderr
    cam("sweep", speeds, "--points 2 -o sweep")
    found, wanted = rows(tmp_path / "out/sweep/map.csv"), rows(tmp_path / "sweep/speeds.csv")
    assert [row["label"] for row in found] == [row["label"] for row in wanted]
    assert all("inf" in row["label"] for row in found)


@pytest.mark.slow
def test_the_borders_of_the_orbit_are_within_a_cell_of_the_published_bifurcations(cam, tmp_path):
    """Carried down, P(1;1) lives from its period doubling to its corner impact, at each r."""
    words = "--set sweep.direction=down --set run.transient=300 --no-plot"
    plane = "--rpm 660:760 --vary follower.restitution=0.6:0.9 --points 101,4"
    cam(f"sweep {plane} {words} --set run.record=30", code=0)
    found = rows(tmp_path / "out/sweep/map.csv")
    for r in dict.fromkeys(row["follower.restitution"] for row in found):
        own = [float(row["rpm"]) for row in found
               if row["follower.restitution"] == r and row["label"] == "P(1;1)"]  # fmt: skip
        machine = CHAPTER._replace(restitution=float(r))
        low = float(corner_rpm(CAM, machine, STABLE, 1, 0, B, 680).rpm)
        high = float(period_doubling_rpm(CAM, machine, STABLE, 1, 700, 745).rpm)
        assert low < min(own) < low + 1.0
        assert high - 1.0 < max(own) < high


@pytest.mark.parametrize("transient", [60, 90])
def test_a_slow_spiral_into_an_orbit_is_named_after_the_orbit(cam, tmp_path, transient):
    """Close below its period doubling P(1;1) is the attractor; its multiplier near -1 brings the
    record near itself in two turns long before it does in one, and before that in none."""
    rpm, r = 739.8319327731092, 0.9
    machine = CHAPTER._replace(restitution=r)
    assert rpm < period_doubling_rpm(CAM, machine, STABLE, 1, 700, 745).rpm
    words = f"--set follower.restitution={r} --set run.transient={transient} --set run.record=100"
    start = "--set run.start.q=1.385 --set run.start.v=-7.7857"  # near the orbit
    cam(f"sweep --rpm {rpm} {words} {start} --no-plot -q", code=0)
    assert [row["label"] for row in rows(tmp_path / "out/sweep/speeds.csv")] == ["P(1;1)"]


def test_curves_of_orbits_are_laid_over_a_map(cam, tmp_path):
    curve = (
        "curve,kind,label,corner,rpm,restitution\n1,fold,P(1;1),,690,0.7\n1,fold,P(1;1),,700,0.8\n"
    )
    (tmp_path / "curve.csv").write_text(curve)
    words = f"{PLANE} {SMALL} -q"
    cam("sweep", words, "-o plain")
    cam("sweep", words, "--curves curve.csv -o laid", code=0)
    plain, laid = (tmp_path / name / "map.png" for name in ("plain", "laid"))
    assert plain.read_bytes() != laid.read_bytes()
    done = cam("sweep", words, "--curves missing.csv", code=2)
    assert "missing.csv: no such file" in done.stderr


AUTO = "--rpm 660:760 --vary follower.restitution=0.6:0.9 --points 2,2"


def test_the_curves_of_a_map_are_found_from_its_edges(cam, tmp_path):
    """From edge to edge: the corner impact of P(1;1) and its doubling against the reference."""
    done = cam("sweep", AUTO, SMALL, "--curves auto --no-plot -o out", code=0)
    assert "corner impact at b of P(1;1), ends: end-of-range of restitution" in done.stdout
    found = rows(tmp_path / "out" / "curves.csv")
    for kind, exact in (
        ("corner-impact", lambda m: corner_rpm(CAM, m, STABLE, 1, 0, B, 680)),
        ("period-doubling", lambda m: period_doubling_rpm(CAM, m, STABLE, 1, 700, 745)),
    ):
        mine = [row for row in found if (row["kind"], row["label"]) == (kind, "P(1;1)")]
        curve = [(float(row["rpm"]), float(row["follower.restitution"])) for row in mine]
        assert sorted(r for _, r in (curve[0], curve[-1])) == [0.6, 0.9]
        for rpm, r in (curve[0], curve[len(curve) // 2], curve[-1]):
            reference = exact(CHAPTER._replace(restitution=r)).rpm
            assert abs(rpm - reference) < 1e-11 * rpm
    (point,) = rows(tmp_path / "out" / "codim2.csv")
    assert (point["kind"], point["label"]) == ("double-corner-impact", "P(2;1:1)")
    again = cam(f"sweep {AUTO} {SMALL} --curves out/curves.csv --no-plot -q", code=0)
    assert again.stderr == ""


def test_a_budget_that_is_spent_before_any_curve_says_no_more_than_that(cam, tmp_path):
    done = cam("sweep", AUTO, SMALL, "--curves auto --no-plot --set run.work_budget=100000", code=3)
    assert "work-budget: the budget of work was used up" in done.stderr
    assert "no bifurcation" not in done.stdout
    assert len(rows(tmp_path / "out/sweep/map.csv")) == 4
    assert rows(tmp_path / "out/sweep/curves.csv") == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--vary run.strobe_deg=0:15 --rpm 660:700", "sweep.vary: found run.strobe_deg"),
        ("--rpm 660:700", "expected two numbers"),
        ("--vary follower.mass=1:1 --rpm 660:700", "found one value of follower.mass"),
    ],
)
def test_a_map_whose_curves_cannot_be_followed_says_so(cam, words, said):
    assert said in cam(f"sweep {words} --curves auto --dry-run", code=2).stderr


@pytest.mark.ci
def test_the_curves_of_a_map_are_proved_and_what_is_not_says_why(cam, tmp_path):
    """P(1;1) from edge to edge; P(2;1:1) up to the point at which two of its curves cross."""
    words = f"{AUTO} {SMALL} --curves auto --prove --no-plot -o out"
    done = cam("sweep", words, code=0)
    found = rows(tmp_path / "out" / "curves.csv")
    for number, label, all_of_it in (("1", "P(1;1)", True), ("3", "P(2;1:1)", False)):
        mine = [row for row in found if row["curve"] == number]
        *cells, last = [row["proved_to_next"] for row in mine]
        assert (mine[0]["label"], last) == (label, "")
        assert set(cells) == ({"yes"} if all_of_it else {"yes", "no"})
        assert (f"not proved: curve {number} " in done.stdout) is not all_of_it
        if all_of_it:  # an exact point between two of them lies beside the line through them
            sought = CHAPTER._replace(restitution=0.75)
            rpm = float(corner_rpm(CAM, sought, STABLE, 1, 0, B, 680).rpm)
            own = [float(row["rpm"]) for row in mine]
            assert min(own) < rpm < max(own)
    (point,) = rows(tmp_path / "out" / "codim2.csv")
    assert point["proved"] == "yes"
    assert float(point["rpm_low"]) < float(point["rpm"]) < float(point["rpm_high"])
    result = json.loads((tmp_path / "out/run.json").read_text())["result"]
    ranges = result["proofs"]["curve_ranges"]
    whole = [one for one in ranges if one["curve"] == 1]
    assert [(one["first"], one["failed_step"]) for one in whole] == [(1, None)]
    assert result["proofs"]["points"] == [{"proved": True, "failed_step": None}]
    certificate = json.loads((tmp_path / "out/proof.json").read_text())
    stated = len(certificate["statements"]) + len(certificate["uncovered"])
    assert stated == sum(one["failed_step"] is None for one in ranges)
    assert all(name.startswith("curve ") for name in certificate["uncovered"])
    assert check.main([str(tmp_path / "out/proof.json")]) == 0
    few = cam("sweep", words, "--set sweep.prove_turns=1 --set orbits.branches=0", code=0)
    assert "proved: curve 1 has no gap from rpm 697.4387463, restitution 0.6 to" in few.stdout
    assert "not tried" not in few.stdout or "whose orbits have 2 turns" in few.stdout


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("--rpm 660:700", "none"),
        ("--rpm 660:700 --vary follower.mass=1:2", "none"),
        ("--rpm 660:700 --vary follower.mass=1:2 --curves own.csv", "own.csv"),
    ],
)
def test_only_curves_that_are_found_on_a_map_are_proved(cam, words, found):
    said = cam(f"sweep {words} --prove --dry-run", code=2).stderr
    assert said == (
        f"--prove: sweep.curves: found {found}, expected auto, whose curves are proved, add "
        "--curves auto, or leave --prove out; cam orbits --prove proves other curves\n"
    )


@pytest.mark.slow
def test_a_zoom_has_values_and_a_panel_of_its_own(cam, tmp_path):
    words = "--rpm 739:740 --points 3 --zoom 739.3:739.4 --set sweep.direction=down"
    cam(f"sweep {words} {SMALL} --no-plot", code=0)
    found = [float(row["rpm"]) for row in rows(tmp_path / "out/sweep/speeds.csv")]
    assert found == sorted(found, reverse=True)
    inside = [rpm for rpm in found if 739.3 <= rpm <= 739.4]
    assert (len(found), len(inside)) == (204, 201)
    scene = load_scene(None, {"sweep.rpm": {"start": 739, "stop": 740, "num": 3},
                              "sweep.zoom": [{"start": 739.3, "stop": 739.4, "num": 5}],
                              "run.transient": 50, "run.record": 5})  # fmt: skip
    picture = sweep(scene).pictures["sweep"]()
    zooms = [name for name in picture.panels if "zoom" in name]
    assert zooms == ["impacts zoom 1", "strobe zoom 1"]
    picture.figure().canvas.draw()
    cam(f"sweep --rpm 739:740 --zoom 739.2:739.3 --points 3,2 {SMALL} --no-plot")
    speeds = [row["rpm"] for row in rows(tmp_path / "out/sweep/speeds.csv")]
    assert speeds == ["739.0", "739.2", "739.3", "739.5", "740.0"]


def test_the_ways_up_and_down_are_told_apart(cam, tmp_path):
    """At 680 rpm chaos from rest, and P(1;1) where the state is carried down."""
    words = "--rpm 680:700 --points 2 --both --no-plot --set sweep.tables=npz"
    cam("sweep", words, SMALL, code=0)
    ways = [("680.0", "aperiodic", "up"), ("700.0", "P(1;1)", "up"),
            ("700.0", "P(1;1)", "down"), ("680.0", "P(1;1)", "down")]  # fmt: skip
    speeds = rows(tmp_path / "out/sweep/speeds.csv")
    assert [(row["rpm"], row["label"], row["direction"]) for row in speeds] == ways
    ranges = json.loads((tmp_path / "out/sweep/run.json").read_text())["result"]["ranges"]
    assert [(row["direction"], row["speeds"]) for row in ranges] == [
        ("up", 1), ("up", 1), ("down", 2)
    ]  # fmt: skip
    strobe = np.load(tmp_path / "out/sweep/strobe.npz")["direction"]
    assert strobe.tolist() == ["up"] * 60 + ["down"] * 60


def test_motions_from_further_starts_come_after_those_of_the_first(cam, tmp_path):
    """At 358.5 rpm P(1;2) exists beside P(3;3:3:2)."""
    words = "--set run.transient=400 --set run.record=12 --no-plot"
    cam(f"sweep --rpm 358.5 {words} --set", "'sweep.also=[{q: 0.55, v: 32.5}]'", code=0)
    found = rows(tmp_path / "out/sweep/speeds.csv")
    assert [(row["rpm"], row["label"], row["start"]) for row in found] == [
        ("358.5", "P(3;3:3:2)", "0"),
        ("358.5", "P(1;2)", "1"),
    ]
    points = rows(tmp_path / "out/sweep/strobe.csv")
    assert [row["start"] for row in points] == ["0"] * 12 + ["1"] * 12
    assert float(points[-1]["q_m"]) == pytest.approx(0.546, abs=1e-3)


@pytest.mark.parametrize("row", ["", "1,P(1;1),700,1,155,0.2", "1,2,3,4,5,6,7", "1,2,3"])
def test_branches_that_cannot_be_laid_over_a_sweep_are_refused_before_any_work(cam, tmp_path, row):
    """No file, one solved at one speed along another parameter, rows too long and too short."""
    if row:
        text = "branch,label,rpm,stable,theta_deg_1,q_m\n" + f"{row}\n" * 2
        (tmp_path / "branch.csv").write_text(text)
    done = cam("sweep", "--points", "3", "--branches", "branch.csv", code=2)
    assert "branch.csv in rpm" in done.stderr
    assert not (tmp_path / "out").exists()
