"""cam detach as a shell sees it: columns, published numbers, words, exit codes."""

import json
import re
from math import inf, pi

import pytest

from tests.conftest import cam_in, rows

SHORT = "--rpm 112:128 --points 3 --set detach.settle=1 --no-plot"


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """`cam detach --no-plot` of the default scene, run once: (process, folder)."""
    folder = tmp_path_factory.mktemp("bare")
    return cam_in(folder, "detach --no-plot --verbose", code=0), folder / "out/detach"


@pytest.mark.slow
@pytest.mark.parametrize(("budget", "table"), [(200_000, "accumulation"), (800_000, "corner_hits")])
def test_a_budget_of_work_keeps_what_was_found(bare, cam, tmp_path, budget, table):
    done = cam("detach --no-plot --set", f"run.work_budget={budget}", "-o part", code=3)
    assert "the budget of work was used up, and the rest is left out; raise" in done.stderr
    result = json.loads((tmp_path / "part" / "run.json").read_text())["result"]
    assert result["status"] == "work-budget"
    for name in ("detach", "accumulation", "corner_hits"):
        whole, part = ((at / f"{name}.csv").read_text() for at in (bare[1], tmp_path / "part"))
        assert set(part.splitlines()) <= set(whole.splitlines())
        assert name != table or 1 < len(part.splitlines()) < len(whole.splitlines())


@pytest.mark.slow
def test_bare_command_gives_every_published_number(bare):
    _, folder = bare
    found = {(row["quantity"], row["region"]): row for row in reversed(rows(folder / "detach.csv"))}
    expected = {
        ("first_detachment", "A2"): (114.979326744, 1e-9),
        ("opens", "A2"): (114.979326744, 1e-9),
        ("opens", "A4"): (114.979326744, 1e-9),
        ("fills", "A2"): (134.872968058, 1e-9),
        ("fills", "A4"): (134.872968058, 1e-9),
        ("accumulation_at_corner", "c"): (119.7125, 5e-4),
        ("accumulation_at_corner", "d"): (136.3125, 5e-4),
        ("completion_loss", "A2"): (198.5605, 2e-4),
    }
    for key, (rpm, error) in expected.items():
        assert float(found[key]["rpm"]) == pytest.approx(rpm, abs=error), key
        omega = float(found[key]["omega_rad_per_s"])
        assert omega == pytest.approx(float(found[key]["rpm"]) * pi / 30, rel=1e-15)
    assert float(found["opens", "A1"]["rpm"]) == inf
    hits = [row for row in rows(folder / "corner_hits.csv") if row["corner"] == "c"]
    assert [row["impact"] for row in hits] == [str(n) for n in range(1, 9)]
    assert float(hits[0]["rpm"]) == pytest.approx(124.998297, abs=1e-6)


@pytest.mark.slow
def test_record_and_table_tell_brackets_statuses_and_words(bare):
    done, folder = bare
    result = json.loads((folder / "run.json").read_text())["result"]
    for row in result["critical_speeds"]:
        assert row["status"] in ("ok", "never")
        if row["status"] == "ok":
            assert row["low_rpm"] < row["rpm"] < row["high_rpm"] < row["low_rpm"] + 1e-9
        else:
            assert row["rpm"] == "inf"
    kinds = {row["region"]: row["kind"] for row in result["just_above_opening"]}
    assert kinds == {"A2": "flies-off", "A4": "released-and-caught"}
    assert result["corner_hits_ended"][0]["corner"] == "e"
    assert result["least_force"][0]["force_n"] == pytest.approx(28.0379, abs=1e-4)
    b = 150.1793714951576  # as weak as e, which comes later, to rounding: zero at the second speed
    assert [row["theta_deg"] for row in result["least_force"]] == pytest.approx([b] * 4, abs=1e-9)
    for text in ("114.979326744", "119.71248", "198.5605", "flies off at b", "deg before e"):
        assert text in done.stdout
    assert "impacts in" in done.stdout.splitlines()[-1]
    table = done.stdout.partition("Past the loss")[2].splitlines()
    assert max(len(line) for line in table if re.fullmatch(r"[\d.]+ .*\d", line)) <= 80


def test_hold_to_gives_springs_and_their_own_detachment(cam, tmp_path):
    cam("detach", SHORT, "--hold-to 150 --set detach.margin_n=0", code=0)
    found = [row for row in rows(tmp_path / "out/detach/detach.csv") if "hold" in row["quantity"]]
    assert [row["quantity"] for row in found] == ["hold_stiffness", "hold_preload", "hold_both"]
    assert [float(row["rpm"]) for row in found] == pytest.approx([150.0] * 3, abs=1e-9)
    record = json.loads((tmp_path / "out/detach/run.json").read_text())
    assert record["scene"]["detach"]["hold_to"] == 150.0
    stiffness = record["result"]["hold"][0]["stiffness"]
    assert stiffness == pytest.approx(1430.8 * (150.0 / 114.979326744) ** 2, rel=1e-9)


# where c = -0.05 m the spring pulls with 95 N: a force of 5 N is left, and the margin is 10
PULLS = "--hold-to 60 --set cam.offset=0.45 --set detach.margin_n=10"
PULLS += " --set follower.preload=100 --set follower.stiffness=1900"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--rpm 50:60 --set detach.force_rpm=[90]", "held at every speed asked for, up to 60 rpm"),
        ("--rpm 120:125", "lost at every speed asked for"),
        ("--set follower.stiffness=0", "the contact force is zero at"),
        ("--set follower.preload=-200 --hold-to 150", "not held even at standstill"),
        ("--set cam.offset=0.45 --hold-to 150", "impossible with stiffness alone"),
        ("--hold-to 100", "The present spring holds up to 100 rpm"),
        (PULLS, " it takes 1.254 N/m, 105 N of preload or "),
    ],
)
def test_what_no_number_says_is_said_in_words(cam, tmp_path, words, said):
    short = SHORT.replace("--rpm 112:128", "") if "--rpm" in words else SHORT
    done = cam("detach", short, words)
    lost = "follower.stiffness=0" in words  # nothing brings the follower back
    assert done.returncode == (3 if lost else 0), done.stderr
    assert said in done.stdout
    # elsewhere contact is lost within the range
    assert ("asked for" in done.stdout) == ("--rpm" in words or words == PULLS)
    text = (tmp_path / "out/detach/detach.csv").read_text()
    assert ("first_detachment" in text) == ("even at standstill" not in done.stdout)
    if "detach.force_rpm=[90]" in words:
        assert {row["rpm"] for row in rows(tmp_path / "out/detach/force.csv")} == {"90.0"}


def test_a_kink_is_told_with_its_drop(cam, tmp_path):
    """Constant velocity: 10 mm over 60 deg up, where the rise ends the slope falls to zero."""
    (tmp_path / "cam.yaml").write_text(
        "follower: {mass: 0.1, stiffness: 20000, damping: 0, gravity: 0, preload: 100,"
        " restitution: 0.5}\n"
        "cam: {kind: law, base: 0.0, lift: 0.01, top_dwell_deg: 20,"
        " rise: {start_deg: 100, length_deg: 60, law: constant-velocity},"
        " fall: {length_deg: 80, law: cycloidal}}\n"
    )
    done = cam("detach -c cam.yaml --rpm 1000 --no-plot --set detach.settle=1", code=0)
    drop, at = re.search(r"slope drops by (\S+) m/rad at (\S+) deg", done.stdout).groups()
    assert float(drop) == pytest.approx(0.01 / (pi / 3.0), rel=1e-5)
    assert float(at) == pytest.approx(160.0)
