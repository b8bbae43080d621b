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


def test_every_number_of_the_calculator_and_its_file(cam, tmp_path):
    """By hand, of x -> (T_L x + y, -D_L x) left of zero, (T_R x + y, -D_R x) right of it, + mu.

    With T = 1 and D = 0.24 the multipliers are 0.6 and 0.4; with T = -2.5 and D = 1, -2 and -0.5.
    A fixed point has x (1 - T + D) = mu: on the left 0.24 x = mu, so for mu < 0, on the right
    4.5 x = mu, for mu > 0. The 2-cycle has trace T_L T_R - D_L - D_R = -3.74 and determinant 0.24,
    multipliers (-3.74 +- sqrt(3.74^2 - 0.96))/2, and 1 - trace + determinant = 4.98.
    """
    line = "classify --trace 1,-2.5 --det 0.24,1"
    said = cam(f"{line} --json -o here", code=0).stdout
    assert (tmp_path / "here" / "border_collision.json").read_text() == said
    assert [path.name for path in (tmp_path / "here").iterdir()] == ["border_collision.json"]
    cam(f"{line} -o there --dry-run", code=0)
    assert not (tmp_path / "there").exists()
    record = json.loads(said)
    left, right = record["sides"]["L"], record["sides"]["R"]
    assert (left["trace"], left["det"], right["trace"], right["det"]) == (1.0, 0.24, -2.5, 1.0)
    assert (left["stable"], right["stable"]) == (True, False)
    root = math.sqrt(3.74**2 - 4 * 0.24)
    multipliers = {
        "L": [0.6, 0.4], "R": [-2.0, -0.5], "LR": [(-3.74 - root) / 2, (-3.74 + root) / 2],
    }  # fmt: skip
    cycles = {cycle["word"]: cycle for cycle in record["cycles"]}
    assert cycles.keys() == multipliers.keys()
    for word, wanted in multipliers.items():
        found = sorted(value[0] for value in cycles[word]["multipliers"])
        assert found == pytest.approx(sorted(wanted), rel=1e-12)
        assert cycles[word]["stable"] == (word == "L")
    assert [cycles[word]["exists_for_mu"] for word in ("L", "R")] == [-1, 1]
    for side in (left, right):
        values = [complex(*pair) for pair in side["multipliers"]]
        assert sum(values) == pytest.approx(side["trace"])
        assert math.prod(values) == pytest.approx(side["det"])
