"""The commands as a shell sees them: artefacts, columns, exit codes, streams."""

import itertools
import json
import re

import pytest

import camcli
from camcli.api import ANALYSES
from camcli.api.command import command_of
from camcli.cli.app import COMMANDS
from tests.conftest import rows
from tests.support.orbit_oracle import CAM, CHAPTER, STABLE, B, corner_rpm

SMALL = "--set run.transient=20 --set run.record=10 --no-plot"
TRAJECTORY = "t_s theta_deg q_m v_m_per_s c_m c_dot_m_per_s contact"
SPEEDS = (
    "rpm label impacts lyapunov_per_period status max_gap_m airborne_fraction max_impact_m_per_s"
    " min_contact_force_n max_contact_force_n contact_lost_deg contact_regained_deg landing_deg"
    " landing_lift_m shut_bounces_per_turn holds_for watched_turns lyapunov_error_per_period"
)
EVENTS = "t_s period theta_deg event q_m u_minus_m_per_s u_plus_m_per_s"


def test_help_names_commands_files_and_columns(cam):
    commands = "simulate sweep detach orbits basins classify bench figures merge rerun schema"
    done = cam("--help", code=0)
    assert all(name in done.stdout for name in commands.split())
    tables = {"simulate": "trajectory", "sweep": "impacts", "orbits": "branch", "bench": "scale",
              "basins": "attractors", "detach": "detach", "classify": "classify"}  # fmt: skip
    for command, table in tables.items():
        said = cam(command, "--help").stdout
        assert re.search(rf"\n  {table}\.csv  +\w", said)
        assert re.search(r"\n  \w+\.png  +\w", said)
    for command, line in COMMANDS.items():  # of those not asked for nothing else is known
        assert " ".join(cam(command, "--help").stdout.split()).count(line) == 1
    assert cam().stderr == done.stdout


def test_help_names_every_file_of_an_analysis(cam):
    for command in ANALYSES:
        said = cam(command, "--help").stdout
        missing = {name for name in command_of(command).artefacts if name not in said}
        assert missing <= {"impacts.npz", "strobe.npz"}  # in the place of their CSV files


def test_simulate_writes_exact_columns(cam, tmp_path):
    done = cam(f"simulate --rpm 190 {SMALL} -o here", code=0)
    trajectory, events = rows(tmp_path / "here/trajectory.csv"), rows(tmp_path / "here/events.csv")
    assert list(trajectory[0]) == TRAJECTORY.split()
    assert list(events[0]) == EVENTS.split()
    assert {row["event"] for row in events} == {"impact", "chatter", "detachment"}
    assert {row["contact"] for row in trajectory} == {"flight", "sticking"}
    times = [float(row["t_s"]) for row in trajectory]
    assert times == sorted(times)
    assert not list((tmp_path / "here").glob(".*"))
    line = done.stdout.splitlines()[-1]
    assert "impacts in" in line
    assert "error of each event" in line


def test_simulate_event_times_follow_from_period_and_phase(cam, tmp_path):
    cam(f"simulate --rpm 700 {SMALL} --set run.strobe_deg=90")
    for row in rows(tmp_path / "out/simulate/events.csv"):
        turns = int(row["period"]) + ((float(row["theta_deg"]) - 90) % 360) / 360
        assert float(row["t_s"]) == pytest.approx(turns * 60 / 700, rel=1e-12)


def test_simulate_shows_each_event_of_a_period_once(cam, tmp_path):
    """Those of the last turns that repeat, as events.csv has them; the last twelve at most."""

    def told(rpm, *options):
        done = cam("simulate", "--rpm", rpm, "--no-plot", *options)
        lines = [line.split() for line in done.stdout.splitlines()]
        listed = [words[1:3] for words in lines if words and words[0] == "impact"]
        events = rows(tmp_path / "out" / "simulate" / "events.csv")
        written = [[e["period"], f"{float(e['theta_deg']):.4f}"] for e in events]
        return done.stdout, listed, written

    text, listed, written = told("358")
    assert "P(3;3:3:2)" in text
    assert "those of one period" in text
    assert listed == [row for row in written if int(row[0]) >= 397]
    assert len(listed) == 8
    text, listed, written = told("745")
    assert "aperiodic" in text
    assert "the last 12" in text
    assert listed == written[-12:]
    text, listed, written = told("60")
    assert "0 events recorded" in text
    assert "theta (deg)" not in text
    assert listed == written == []


def test_sweep_writes_exact_columns_of_shortest_numbers(cam, tmp_path):
    done = cam(f"sweep --rpm 690:745 --points 3 {SMALL}")
    said = [line for line in done.stderr.splitlines() if "compiling the kernel" not in line]
    assert (done.returncode, said) == (0, [])
    assert "\x1b" not in done.stdout  # no escape codes without a terminal
    folder = tmp_path / "out/sweep"
    columns = {
        "impacts": ["rpm", "period", "theta_deg", "q_m", "u_minus_m_per_s"],
        "strobe": ["rpm", "period", "q_m", "v_m_per_s", "impacts", "chatter"],
        "speeds": SPEEDS.split(),
    }
    tables = {name: rows(folder / f"{name}.csv") for name in columns}
    assert {name: list(table[0]) for name, table in tables.items()} == columns
    assert [row["rpm"] for row in tables["speeds"]] == ["690.0", "717.5", "745.0"]
    assert {row["period"] for row in tables["strobe"]} == {str(k) for k in range(10)}
    for row in itertools.chain(tables["impacts"], tables["strobe"]):
        for text in row.values():
            assert text == repr(float(text)) or text == str(int(text))


def test_json_is_one_object_that_equals_the_record(cam, tmp_path):
    done = cam("sweep --rpm 700 --no-plot --json")
    record = json.loads(done.stdout)
    assert record == json.loads((tmp_path / "out/sweep/run.json").read_text())
    assert record["result"]["ranges"][0]["label"] == "P(1;1)"
    assert record["scene"]["follower"]["restitution"] == 0.8
    assert set(record["cost"]) >= {"impacts", "seconds", "impacts_per_s"}
    assert "impacts.csv" in record["artefacts"]


@pytest.mark.slow
def test_an_orbit_still_settling_is_named_after_it(cam, tmp_path):
    for rpm, label in (("739.3164", "P(1;1)"), ("745", "aperiodic")):
        done = cam("simulate", "--rpm", rpm, "--no-plot", "--json")
        assert json.loads(done.stdout)["result"]["label"] == label
    cam("detach", "--rpm", "700", "--no-plot")  # from rest, 20 turns before and 20 measured
    assert [row["label"] for row in rows(tmp_path / "out/detach/speeds.csv")] == ["P(1;1)"]


@pytest.mark.slow
def test_a_picture_stays_as_long_as_it_shows_the_numbers_of_the_folder(cam, tmp_path):
    words = "--rpm 700 --set run.transient=5 --set run.record=5"
    picture = tmp_path / "out/simulate/simulate.png"
    assert cam("simulate", words).returncode == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"
    record = json.loads(cam("simulate", f"{words} --no-plot --json").stdout)
    assert picture.name in record["artefacts"]
    assert cam("rerun", "out/simulate/run.json").returncode == 0
    assert cam("simulate", f"{words} --no-plot --set run.record=6").returncode == 0
    assert not picture.exists()


def test_files_of_other_people_are_neither_overwritten_nor_deleted(cam, tmp_path):
    theirs = {"sweep.png": "a photo", "impacts.csv": "a,b", "notes.txt": "x"}
    for name, text in theirs.items():
        (tmp_path / name).write_text(text)
    done = cam(f"sweep --rpm 700 {SMALL} -o .")
    assert (done.returncode, done.stdout) == (2, "")
    assert [f"found {name}, which no run has left" in done.stderr for name in theirs] == [1, 1, 0]
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == theirs
    (tmp_path / "sweep.png").unlink()
    (tmp_path / "impacts.csv").unlink()
    assert cam(f"sweep --rpm 700 {SMALL} -o .").returncode == 0
    assert cam("simulate --profile-only --no-plot -o .").returncode == 0
    assert {path.name for path in tmp_path.iterdir()} == {"notes.txt", "profile.csv", "run.json"}


def test_any_number_of_the_scene_can_be_varied(cam, tmp_path):
    """The first column bears its key; restitution decides what it decided beside a speed."""
    words = "--set run.transient=100 --set run.record=20 --no-plot -q"
    cam(f"sweep --vary follower.restitution=0.7:0.8 --points 2 {words}", code=0)
    found = rows(tmp_path / "out/sweep/speeds.csv")
    assert [row["follower.restitution"] for row in found] == ["0.7", "0.8"]
    cam(f"sweep --rpm 700 --set follower.restitution=0.7 {words} -o one")
    (one,) = rows(tmp_path / "one/speeds.csv")
    assert list(one.values())[1:] == list(found[0].values())[1:]
    cam(f"sweep --vary cam.nose_radius=0.14:0.15 --points 2 {words}")
    nose = rows(tmp_path / "out/sweep/speeds.csv")
    assert nose[1]["max_gap_m"] == found[1]["max_gap_m"] != nose[0]["max_gap_m"]


@pytest.mark.parametrize(
    ("command", "words", "table"),
    [("classify", "", "classify.csv"), ("basins", "--cells 4", "attractors.csv")],
)
def test_other_commands_vary_any_number_too(cam, tmp_path, command, words, table):
    """Each value gives the rows that the scene with this number gives at its speed."""
    words = f"{words} --set run.transient=100 --set run.record=20 --rpm 690 --no-plot"
    key = "cam.nose_radius"
    done = cam(command, "--vary", f"{key}=0.12:0.15", f"--points 2 {words} -o both", code=0)
    assert " at 690 rpm" in done.stdout
    cam(command, "--set", f"{key}=0.12", f"{words} -o one")
    found, alone = (rows(tmp_path / name / table) for name in ("both", "one"))
    assert next(iter(found[0])) == key
    assert {row[key] for row in found} == {"0.12", "0.15"}
    first = [row for row in found if row.pop(key) == "0.12"]
    assert first == [{name: row[name] for name in first[0]} for row in alone]


def test_orbits_vary_a_constant_by_its_key_as_by_its_short_name(cam, tmp_path):
    words = "--rpm 700 --points 8 --no-plot -q"
    cam(f"orbits --vary follower.restitution=0.75:0.85 {words} -o key", code=0)
    short = "--parameter restitution --range 0.75:0.85"
    cam(f"orbits {short} {words} -o short")
    by_key, by_name = (rows(tmp_path / name / "branch.csv") for name in ("key", "short"))
    assert next(iter(by_key[0])) == "follower.restitution"
    renamed = [{"restitution": row.pop("follower.restitution"), **row} for row in by_key]
    assert renamed == by_name
    found = camcli.orbits(
        camcli.load_scene(None, {
            "orbits.vary": [{"key": "follower.mass", "start": 1.2, "stop": 1.25, "num": 5}],
        })
    ).tables["branch"]  # fmt: skip
    assert (found["follower.mass"].min(), found["follower.mass"].max()) == (1.2, 1.25)
    assert set(found["rpm"]) == {700.0}


def test_curves_vary_a_second_number(cam, tmp_path):
    words = "--curve corner-impact --rpm 665:685 --at 680 --no-plot -q"
    vary = "--vary follower.restitution=0.78:0.8 --points 12,8"
    cam(f"orbits {words} {vary}", code=0)
    first = rows(tmp_path / "out/orbits/curve.csv")[0]
    machine = CHAPTER._replace(restitution=float(first["follower.restitution"]))
    assert abs(float(first["rpm"]) - corner_rpm(CAM, machine, STABLE, 1, 0, B, 680).rpm) < 1e-7
