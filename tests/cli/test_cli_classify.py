"""cam classify as a user runs it: labels, exponents, explanations, the calculator."""

import csv
import json
import math

import pytest


def rows(path):
    """A CSV as dictionaries."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def explained(cam, tmp_path, *words):
    """Result of run.json of an explained range."""
    done = cam("classify", "--explain", "--no-plot", "-o", "out", *words)
    assert done.returncode == 0, done.stderr
    return json.loads((tmp_path / "out" / "run.json").read_text())["result"]


def speeds(result, kind):
    """Critical speeds of a kind."""
    return [event["rpm"] for event in result["events"] if event["kind"] == kind]


def test_the_chapters_range_is_explained(cam, tmp_path):
    result = explained(cam, tmp_path, "--points", "51")
    assert speeds(result, "corner-impact")[:2] == pytest.approx(
        [673.2344450038120, 739.3779296493], rel=1e-11
    )
    assert speeds(result, "period-doubling")[0] == pytest.approx(739.3197802160, rel=1e-12)
    causes = {(c["from_rpm"], c["to_rpm"]): c["cause"] for c in result["changes"]}
    assert causes[(738.0, 740.0)] == "period-doubling+corner-impact"
    corners = rows(tmp_path / "out" / "corners.csv")
    assert {row["classification"] for row in corners} >= {"nonsmooth-fold"}
    assert all(row["kind"] == "corner-impact" for row in corners)


def test_the_low_range_is_explained(cam, tmp_path):
    result = explained(cam, tmp_path, "--rpm", "110:200", "--points", "46")
    assert speeds(result, "first-detachment") == pytest.approx([114.979326744], rel=1e-11)
    ends = speeds(result, "accumulation-at-corner")
    assert ends[0] == pytest.approx(119.712, abs=5e-4)
    assert any(abs(rpm - 136.312) < 5e-4 for rpm in ends)
    assert speeds(result, "chatter-completion")[0] == pytest.approx(198.5605, abs=5e-5)
    hits = speeds(result, "corner-hit")
    for rpm in (124.998297, 122.699318, 121.685872, 121.106981, 120.735577, 120.481041):
        assert min(abs(rpm - hit) for hit in hits) < 1e-6


def test_another_restitution_shifts_the_answers(cam, tmp_path):
    from conftest import chapter_system, settings

    from camcli.analysis.orbits.arclength import Span
    from camcli.analysis.orbits.study import Question, orbits

    result = explained(cam, tmp_path, "--points", "51", "--set", "follower.restitution=0.75")
    solved = orbits(
        chapter_system(restitution=0.75), settings(600),
        Question(700.0, span=Span(660.0, 760.0, 1.0), starts=0),
    )  # fmt: skip
    for kind in ("corner-impact", "period-doubling"):
        wanted = [b.value for b in solved.bifurcations if b.kind == kind and b.branch != 2]
        found = speeds(result, kind)
        for rpm in wanted:
            assert min(abs(rpm - x) for x in found) < 1e-8, (kind, rpm, found)
    assert speeds(result, "corner-impact")[0] != pytest.approx(673.23444500, rel=1e-4)


def test_columns_and_exponents_of_one_speed(cam, tmp_path):
    done = cam("classify", "--rpm", "700", "--no-plot", "-o", "out")
    assert done.returncode == 0
    (row,) = rows(tmp_path / "out" / "classify.csv")
    assert list(row) == [
        "rpm", "label", "period", "impacts", "chatter", "stable", "lyapunov_per_period", "status",
    ]  # fmt: skip
    assert row["label"] == "P(1;1)"
    assert float(row["lyapunov_per_period"]) == pytest.approx(math.log(0.8), rel=1e-13)
    assert "sum of the exponents" in done.stdout


def test_a_cloud_of_starts_finds_both(cam, tmp_path):
    done = cam("classify", "--rpm", "358.5", "--starts", "24", "--no-plot", "-o", "out")
    assert done.returncode == 0
    labels = [row["label"] for row in rows(tmp_path / "out" / "classify.csv")]
    assert labels == ["P(1;2)", "P(3;3:3:2)"]


def test_same_bytes_on_one_thread_or_two_compiled_or_not(cam, tmp_path):
    words = (
        "classify",
        "--rpm",
        "738:746",
        "--points",
        "5",
        "--no-plot",
        "--set",
        "run.record=200",
    )
    for name, more, kernel in (
        ("a", ("--threads", "1"), "compiled"),
        ("b", ("--threads", "2"), "compiled"),
        ("c", (), "python"),
    ):
        done = cam(*words, *more, "-o", name, env={"CAMCLI_KERNEL": kernel})
        assert done.returncode == 0, done.stderr
    texts = {(tmp_path / name / "classify.csv").read_bytes() for name in "abc"}
    assert len(texts) == 1


@pytest.mark.parametrize(
    ("traces", "dets", "kind"),
    [
        ("0.5,-0.5", "0.2,0.3", "persistence"),
        ("0.5,-1.6", "0.2,0.3", "border-period-doubling"),
        ("1.7,-1.7", "0.5,0.5", "robust-chaos"),
    ],
)
def test_the_calculator(cam, traces, dets, kind):
    done = cam("classify", "--trace", traces, "--det", dets, "--json")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["kind"] == kind
    if kind == "border-period-doubling":
        cycle = next(c for c in record["cycles"] if c["word"] == "LR")
        sizes = [m[0] for m in cycle["multipliers"]]
        assert sizes == pytest.approx([-1.25207973, -0.04792027], abs=5e-9)
    assert "robust" in cam("classify", "--trace", "1.7,-1.7", "--det", "0.5,0.5").stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--trace", "1,2"], "expected both --trace and --det"),
        (["--trace", "1", "--det", "1,2"], "expected two numbers L,R"),
        (["--trace", "1,nan", "--det", "1,2"], "expected two numbers L,R"),
        (["--rpm", "700", "--explain"], "expected a range"),
        (["--starts", "-3"], "classify.starts"),
    ],
)
def test_bad_usage_is_one_clear_message(cam, words, said):
    done = cam("classify", "--no-plot", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
