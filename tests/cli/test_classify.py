"""cam classify as a user runs it: labels, exponents, explanations, the calculator."""

import json
import math

import pytest

from tests.conftest import rows


def explained(cam, tmp_path, *words):
    """Result of run.json of an explained range."""
    cam("classify --explain --no-plot -o out", *words, code=0)
    return json.loads((tmp_path / "out" / "run.json").read_text())["result"]


def speeds(result, kind):
    """Critical speeds of a kind."""
    return [event["rpm"] for event in result["events"] if event["kind"] == kind]


@pytest.mark.parametrize(
    ("command", "rpm", "budget", "kinds", "words"),
    [
        ("sweep", "736:740", 200_000, ["period-doubling"], "P(1;1)"),
        ("classify", "740.4:740.65", 9_999, [], "budget"),
    ],
)
def test_a_budget_of_work_keeps_the_causes_found(cam, tmp_path, command, rpm, budget, kinds, words):
    """Cut on a branch, of which a doubling was seen; and before the search for a crisis."""
    asked = ("--rpm", rpm, "--points", "2", "--set", f"run.work_budget={budget}")
    done = cam(command, "--explain", "--no-plot", "-o", "out", *asked, code=3)
    assert "work-budget: the budget of work was used up" in done.stderr
    assert "raise run.work_budget" in done.stderr
    result = json.loads((tmp_path / "out" / "run.json").read_text())["result"]
    assert result["status"] == "work-budget"
    assert [event["kind"] for event in result["events"]] == kinds
    (change,) = result["changes"]
    assert change["cause"] == (kinds or ["unexplained"])[0]
    assert words in change["words"]


@pytest.mark.slow
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


def test_columns_and_exponents_of_one_speed(cam, tmp_path):
    done = cam("classify --rpm 700 --no-plot --verbose -o out", code=0)
    (row,) = rows(tmp_path / "out" / "classify.csv")
    assert list(row) == [
        "rpm", "label", "period", "impacts", "chatter", "stable", "lyapunov_per_period", "status",
        "holds_for", "watched_turns", "lyapunov_error_per_period",
    ]  # fmt: skip
    assert row["label"] == "P(1;1)"
    assert float(row["lyapunov_per_period"]) == pytest.approx(math.log(0.8), rel=1e-13)
    assert "both exponents of a motion add up to" in done.stdout


@pytest.mark.parametrize(
    ("record", "shown"),
    [
        ("400", "the first complete chatter comes after "),
        ("5000", " of 5000 turns, one in some "),
    ],
)
def test_what_a_record_shows_of_rare_complete_chatters(cam, tmp_path, record, shown):
    """At 631.43 rpm one in some 200 turns, with chaos in between: in the record or after it."""
    words = ("--rpm", "631.43", "--set", f"run.record={record}", "--no-plot", "-v", "-o", "out")
    done = cam("classify", *words)
    assert shown in done.stdout
    (motion,) = json.loads((tmp_path / "out" / "run.json").read_text())["result"]["motions"]
    assert motion["label"] == "undecided"
    assert motion["complete_chatters"] > 0
    assert motion["turns"] >= int(record)


def test_the_calculator(cam):
    done = cam("classify --trace 0.5,-1.6 --det 0.2,0.3 --json", code=0)
    record = json.loads(done.stdout)
    assert record["kind"] == "border-period-doubling"
    cycle = next(c for c in record["cycles"] if c["word"] == "LR")
    sizes = [m[0] for m in cycle["multipliers"]]
    assert sizes == pytest.approx([-1.25207973, -0.04792027], abs=5e-9)
    assert "robust-chaos: " in cam("classify --trace 1.7,-1.7 --det 0.5,0.5").stdout
