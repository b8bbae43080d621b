"""cam detach as a shell sees it: columns, published numbers, words, exit codes."""

import csv
import json
import subprocess
import sys
from math import inf, pi

import pytest

SHORT = ("--rpm", "112:128", "--points", "9", "--set", "detach.settle=1", "--no-plot")


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """`cam detach --no-plot` of the default scene, run once: (process, folder)."""
    folder = tmp_path_factory.mktemp("bare")
    done = subprocess.run(
        [sys.executable, "-m", "camcli", "detach", "--no-plot"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done, folder / "out/detach"


def test_bare_command_gives_every_published_number(bare):
    done, folder = bare
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
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
    assert [float(row["rpm"]) for row in hits] == pytest.approx(
        [124.998297, 122.699318, 121.685872, 121.106981, 120.735577, 120.481041, 120.299126,
         120.165355], abs=1e-6,
    )  # fmt: skip


def test_columns_are_exact(bare):
    _, folder = bare
    heads = {path.name: path.read_text().splitlines()[0] for path in folder.glob("*.csv")}
    assert heads == {
        "detach.csv": "quantity,region,theta_deg,rpm,omega_rad_per_s",
        "accumulation.csv": "rpm,theta_deg",
        "corner_hits.csv": "impact,corner,rpm",
        "force.csv": "rpm,theta_deg,force_n",
    }


def test_accumulation_has_rows_only_where_chatter_completes(bare):
    curve = rows(bare[1] / "accumulation.csv")
    per_speed = [row["rpm"] for row in curve]
    assert min(map(float, per_speed)) == 115.0
    assert per_speed.count("120.0") == 2
    assert per_speed.count("150.0") == 1
    assert "200.0" not in per_speed
    for row in curve:
        assert row["theta_deg"] == repr(float(row["theta_deg"]))


def test_record_and_table_tell_brackets_statuses_and_words(bare):
    done, folder = bare
    result = json.loads((folder / "run.json").read_text())["result"]
    for row in result["critical_speeds"]:
        assert row["status"] in ("ok", "never")
        if row["status"] == "ok":
            assert row["low_rpm"] < row["rpm"] < row["high_rpm"]
            assert row["high_rpm"] - row["low_rpm"] < 1e-9
    kinds = {row["region"]: row["kind"] for row in result["just_above_opening"]}
    assert kinds == {"A2": "flies-off", "A4": "released-and-caught"}
    assert result["corner_hits_ended"][0]["corner"] == "e"
    assert result["least_force"][0]["force_n"] == pytest.approx(28.0379, abs=1e-4)
    for text in ("114.979326744", "119.71248", "198.5605", "flies off at b", "deg before e"):
        assert text in done.stdout
    assert "impacts in" in done.stdout.splitlines()[-1]
    assert max(map(len, [x for x in done.stdout.splitlines() if "│" in x])) <= 80


def test_hold_to_gives_springs_and_their_own_detachment(cam, tmp_path):
    done = cam("detach", *SHORT, "--hold-to", "150")
    assert done.returncode == 0, done.stderr
    found = [row for row in rows(tmp_path / "out/detach/detach.csv") if "hold" in row["quantity"]]
    assert [row["quantity"] for row in found] == ["hold_stiffness", "hold_preload", "hold_both"]
    assert [float(row["rpm"]) for row in found] == pytest.approx([150.0] * 3, abs=1e-9)
    record = json.loads((tmp_path / "out/detach/run.json").read_text())
    assert record["options"]["hold_to"] == "150"
    assert record["scene"]["detach"]["hold_to"] == 150.0
    stiffness = record["result"]["hold"][0]["stiffness"]
    assert stiffness == pytest.approx(1430.8 * (150.0 / 114.979326744) ** 2, rel=1e-9)
    for rpm, label in (("149.999999", "contact"), ("150.001", "P(1;inf)")):
        words = ("--rpm", rpm, "--no-plot", "--set", f"follower.stiffness={stiffness!r}")
        cam("sweep", *words, "--set", "run.transient=5", "--set", "run.record=40")
        assert rows(tmp_path / "out/sweep/speeds.csv")[0]["label"] == label


def test_one_speed_shows_its_force_curve(cam, tmp_path):
    done = cam("detach", "--rpm", "150", "--no-plot", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)["result"]
    assert [row["rpm"] for row in result["least_force"]] == [150.0]
    assert {row["rpm"] for row in rows(tmp_path / "out/detach/force.csv")} == {"150.0"}
    assert result["bursts"] == [
        {"bursts": "A2 complete", "from_rpm": 150.0, "to_rpm": 150.0, "speeds": 1}
    ]


def test_asked_speeds_of_the_force(cam, tmp_path):
    cam("detach", *SHORT, "--set", "detach.force_rpm=[90, 100]")
    assert {row["rpm"] for row in rows(tmp_path / "out/detach/force.csv")} == {"90.0", "100.0"}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--rpm", "50:60"), "held at every speed up to 60 rpm"),
        (("--rpm", "120:125"), "lost at every speed asked for"),
        (("--set", "follower.preload=-200"), "not held even at standstill"),
        (("--set", "follower.preload=-200", "--hold-to", "150"), "not held even at standstill"),
        (("--set", "cam.offset=0.45", "--hold-to", "150"), "impossible with stiffness alone"),
    ],
)
def test_what_no_number_says_is_said_in_words(cam, words, said):
    done = cam("detach", *SHORT, "--points", "3", *words)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout


def test_a_follower_nothing_presses_has_no_first_detachment(cam, tmp_path):
    done = cam("detach", *SHORT, "--set", "follower.stiffness=0")
    assert "zero at" in done.stdout
    text = (tmp_path / "out/detach/detach.csv").read_text()
    assert "first_detachment" not in text
    assert ",0.0,0.0" not in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--hold-to", "abc"), "--hold-to"),
        (("--hold-to", "100:200"), "--hold-to"),
        (("--set", "detach.margin_n=-1"), "margin_n"),
        (("--set", "detach.impact=3"), "impacts"),
        (("--points", "0"), "--points"),
    ],
)
def test_faults_have_exit_code_2(cam, words, said):
    done = cam("detach", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_hold_to_belongs_to_detach_alone(cam):
    assert cam("sweep", "--hold-to", "100").returncode == 2
    assert "--hold-to" in cam("detach", "--help").stdout
    assert "--hold-to" not in cam("sweep", "--help").stdout


def test_dry_run_writes_nothing(cam, tmp_path):
    done = cam("detach", "--dry-run", "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["plan"]["orbits"] == 181
    assert list(tmp_path.iterdir()) == []


def test_same_scene_same_bytes_compiled_or_not(cam, tmp_path):
    for kernel in ("python", "compiled"):
        done = cam("detach", *SHORT, "-o", kernel, env={"CAMCLI_KERNEL": kernel})
        assert done.returncode == 0, done.stderr
    for name in ("detach.csv", "accumulation.csv", "corner_hits.csv", "force.csv"):
        one, two = (tmp_path / kernel / name for kernel in ("python", "compiled"))
        assert one.read_bytes() == two.read_bytes(), name


def test_no_plot_imports_neither_matplotlib_nor_a_compiler(tmp_path):
    code = (
        "import sys, camcli.cli.exit_codes as panel; from camcli.cli.app import app\n"
        f"panel.guarded(lambda: app(['detach', *{SHORT!r}], standalone_mode=False))\n"
        "print([m for m in ('matplotlib', 'numba', 'scipy', 'numpy') if m in sys.modules],"
        " file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stderr.splitlines()[-1] == "[]"


def test_picture_is_written_and_left_out(cam, tmp_path):
    picture = tmp_path / "out/detach/detach.png"
    assert cam("detach", *SHORT[:-1]).returncode == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"
    cam("detach", *SHORT)
    assert not picture.exists()
