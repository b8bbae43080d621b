"""From a lift table to a verdict, as somebody who knows engines and no bifurcations would go."""

import json
import re
import shutil
from math import pi, radians, sqrt
from textwrap import wrap

import numpy as np
import pytest
from mpmath import mp

import camcli
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.labels import Label
from camcli.system import Follower, System
from camcli.words.labels import motion
from tests.conftest import cam_in, rows
from tests.support.lift_tables import Lobe, scene, smooth, table
from tests.support.valve_on_seat import Lobe as LashedLobe
from tests.support.valve_on_seat import Valve

pytestmark = pytest.mark.usefixtures("short_samples")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a table, and the scene and the picture that cam init made of it."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "lobe.csv").write_text(table(Lobe(smooth), 2, decimals=3))
    cam_in(folder, "init lobe.csv", code=0)
    filled_in(folder / "lobe.yaml")
    return folder


def filled_in(scene):
    """Other numbers in the place of those that cam init made up."""
    text = scene.read_text()
    for made_up, mine in (("0.12345", "0.12   "), ("41234.5", "40000  "), ("245.67", "250   "),
                          ("0.010123", "0.010   ")):  # fmt: skip
        text = text.replace(made_up, mine)
    scene.write_text(text)


@pytest.fixture
def begun(made, tmp_path):
    """A copy of it, where the command runs."""
    return shutil.copytree(made, tmp_path, dirs_exist_ok=True)


@pytest.mark.ci
@pytest.mark.slow
def test_init_overwrites_nothing_and_writes_a_scene_to_fill_in(cam, begun):
    again = cam("init lobe.csv")
    assert (again.returncode, again.stdout) == (2, "")
    assert "lobe.yaml: found a file of this name" in again.stderr
    assert cam("init lobe.csv --force").returncode == 0
    before = (begun / "lobe.yaml").read_bytes()
    assert cam("init lobe.csv --force").returncode == 0
    assert (begun / "lobe.yaml").read_bytes() == before
    assert cam("init").returncode == 0
    keys = "follower.mass, follower.stiffness, follower.preload, cam.lift"
    told = f"note: scene.yaml: FILL IN: cam init made up {keys}; put your numbers there"
    for remark in ("FILL IN", "mine"):  # not the remark counts but the number
        text = (begun / "scene.yaml").read_text().replace("FILL IN", remark)
        (begun / "scene.yaml").write_text(text)
        done = cam("detach -c scene.yaml --no-plot --points 3", code=3)
        assert told in done.stderr
        assert "scene.yaml: lines 5, 24: CHECK: guesses of cam init" in done.stderr
        first, second = done.stdout.splitlines()[:2]
        assert first == f"This is of a made-up machine: cam init made up {keys}."
        assert second.startswith("Contact holds up to ")
    cam("simulate -c scene.yaml --profile-only --no-plot", code=3)  # the lift is made up
    cam("init -o again", code=0)
    filled_in(begun / "again/scene.yaml")
    done = cam("detach -c again/scene.yaml --no-plot --points 3", code=0)
    assert "FILL IN" not in done.stderr
    assert done.stdout.startswith("Contact holds up to ")


@pytest.mark.ci
@pytest.mark.slow
def test_a_scene_of_a_table_runs_at_a_speed_of_its_machine(cam, begun):
    cam("init lobe.csv --force", code=0)
    text = (begun / "lobe.yaml").read_text()
    rpm = float(re.search(r"^  rpm: (\S+)", text, re.MULTILINE)[1])
    found = camcli.detach(camcli.load_scene(begun / "lobe.yaml", {"detach.rpm.num": 2}))
    first = found.values.detachment.first.rpm
    assert 0.85 * first < rpm < 0.95 * first
    assert found.summary["working"]["rpm"] == rpm
    cam("simulate -c lobe.yaml --profile-only --no-plot", code=0)  # a cam needs no spring
    cam("simulate -c lobe.yaml --no-plot --set run.transient=2 --set run.record=2", code=3)
    loads = "--set spring='{seat_load: 200, nose_load: 600, mass: 0.05}'"
    text = re.sub(r"(?m)^  (stiffness|preload): .*\n", "", text)
    (begun / "lobe.yaml").write_text(text)
    done = cam(f"simulate -c lobe.yaml --no-plot {loads} --set run.record=2", code=3)
    assert done.stdout.startswith("This is of a made-up machine: cam init made up follower.mass.\n")


def test_what_writes_no_run_takes_its_options_too(cam, begun):
    done = cam("init lobe.csv -o other --json --no-plot", code=0)
    assert json.loads(done.stdout)["files"] == ["other/lobe.yaml", "other/lobe.csv"]
    assert (begun / "other/lobe.csv").read_bytes() == (begun / "lobe.csv").read_bytes()
    assert cam("detach -c other/lobe.yaml --dry-run").returncode == 0
    assert cam("init --dry-run -o none", code=0).stdout == "would write none/scene.yaml\n"
    assert not (begun / "none").exists()
    assert cam("schema -q -o other", code=0).stdout == ""
    assert "follower" in json.loads((begun / "other/schema.json").read_text())["properties"]
    cam("classify --trace 0.5,-1.6 --det 0.2,0.3 -o other -q", code=0)
    assert json.loads((begun / "other/border_collision.json").read_text())["kind"]


@pytest.mark.parametrize("command", ["sweep", "detach", "orbits", "classify", "basins"])
def test_a_range_that_is_not_given_comes_from_the_machine(cam, begun, command):
    done = cam(f"{command} -c lobe.yaml --dry-run", code=0)
    words = done.stderr.partition(f"note: {command}.rpm is not given: it is ")[2].split()
    assert 2300 < float(words[0]) < 3500  # about the loss of contact, not another machine
    if command == "orbits":
        for given in ("-c lobe.yaml --rpm 100:200", ""):
            assert "is not given" not in cam(f"{command} --dry-run {given}").stderr


@pytest.mark.slow
def test_a_run_begins_with_a_verdict(cam, begun):
    short = ("--no-plot", "--set", "run.transient=5", "--set", "run.record=5", "--points", "5")
    done = cam("detach -c lobe.yaml", *short, "--hold-to 5000", code=0)
    verdict = done.stdout.partition("\n\n")[0]
    speed = float(verdict.split("up to ")[1].split(" rpm")[0])
    said = [float(x) for x in verdict.split("its table leaves ")[1].split(" rpm")[0].split(" to ")]
    low, high = json.loads((begun / "out/detach/run.json").read_text())["error"]["lift_table"][
        "first_detachment_rpm"
    ]
    assert said == pytest.approx([low, high], abs=0.51)
    assert 0.9 * speed < low < speed < high < 1.1 * speed
    assert re.search(
        r"N to spare it takes \S+ N/mm, \S+ N of preload or \S+ N/mm with \S+ N of preload\.\n?",
        verdict,
    )

    done = cam("detach -c lobe.yaml", *short, "--hold-to 1000")
    assert "\nThe present spring holds up to 1000 rpm" in done.stdout.partition("\n\n")[0]
    assert "a softer spring with the same preload" in done.stdout

    solid = "--set spring.solid_at=0.0101 --set detach.machines=1"
    some = f"{solid} --tolerance follower.mass=5%"
    done = cam("detach -c lobe.yaml", *short, f"--hold-to 5000 {some} -v")
    assert "impossible" in done.stdout
    assert "With more preload" not in done.stdout.partition("\n\n")[0]
    assert "solid_at is the present one's" in done.stdout.partition("\n\n")[0]

    done = cam("sweep -c lobe.yaml", *short)
    assert "Contact holds" not in done.stdout  # said where it is asked for
    holds, past = json.loads((begun / "out/sweep/run.json").read_text())["verdict"]
    assert holds.startswith(f"Contact holds up to {speed:.0f} rpm of the cam; its table leaves ")
    assert past.startswith("Past it, ")
    assert " mm and lands at " in past
    done = cam("simulate -c lobe.yaml --rpm 100", *short[:-2])
    assert done.stdout.startswith("At 100 rpm of the cam contact holds")
    done = cam("detach --set follower.preload=-200", *short)
    assert done.stdout.startswith("Contact is lost at every speed: the spring does not press even")


@pytest.mark.ci
@pytest.mark.slow
def test_a_wrong_unit_or_sign_is_doubted(cam, begun):
    (begun / "radii.csv").write_text(
        "".join(f"{k},{18 + Lobe(smooth).at(k)[0] * 1e3:.3f}\n" for k in range(0, 360, 2))
    )
    radii = "cam.file=radii.csv cam.header=0 cam.angle_column=1 cam.lift_column=2"
    for sets, said in (
        ("cam.rocker_ratio=26.4", "a lift of 264 mm; is it in m, or is cam.lift the file's unit?"),
        ("cam.base_radius=36", "a base radius of 36 m"),
        ("follower.preload=-5", "a preload of -5 N pulls the follower off the cam"),
        (radii, "the smallest lift of the table is 18 mm; if these are radii"),
    ):
        words = " --set ".join(["simulate -c lobe.yaml --dry-run", *sets.split()])
        assert f"warning: {said}" in cam(words).stderr
    assert "warning" not in cam("simulate -c lobe.yaml --dry-run").stderr


@pytest.mark.ci
@pytest.mark.slow
def test_a_spring_of_hold_to_holds_the_cam_that_was_measured(cam, begun):
    """The table is rounded; with its true law and any error in its bound they hold as well."""
    short = "--no-plot --points 2 --set detach.settle=0 --hold-to 5000"
    little = "--tolerance follower.mass=1e-6% --set detach.machines=5"
    done = cam(f"detach -c lobe.yaml {short} {little} -v")
    assert "The tolerances are follower.mass 1e-06 %, the error of the table." in done.stdout
    record = json.loads((begun / "out/detach/run.json").read_text())
    rows = np.genfromtxt(begun / "out/detach/tolerance.csv", delimiter=",", names=True)
    assert rows["table_error"][:4].tolist() == [-1.0, 1.0, -1.0, 1.0]
    ends = record["error"]["lift_table"]["first_detachment_rpm"]
    lost = rows["first_detachment_rpm"]
    assert min(lost) == pytest.approx(ends[0], rel=1e-7)
    assert max(lost) <= ends[1]
    assert max(lost[4:]) - min(lost[4:]) > 0.2 * (ends[1] - ends[0])
    springs = record["result"]["hold"]
    chances = record["result"]["tolerance"]["springs"].values()
    assert [spring["chance"] for spring in chances] == [1.0, 1.0, 1.0]
    exact = begun / "exact"
    exact.mkdir()
    law = scene(exact, table(Lobe(smooth), 0.5, decimals=12)).cam
    for spring in springs:
        assert spring["detaches_rpm"] > 5010  # of the smoothed cam: the error is to spare
        follower = Follower(0.12, spring["stiffness"], 20.0, 0.0, spring["preload"], 0.4)
        assert 5000 < detachment(System.build(follower, law)).first.rpm < 6000


@pytest.mark.parametrize(
    "loads",
    [{"seat_load": 260.0, "nose_load": 680.0}, {"rate": 42000.0, "nose_load": 680.0},
     {"rate": 42000.0, "seat_load": 260.0}, {"preload": 260.0, "nose_load": 680.0}],
)  # fmt: skip
def test_a_spring_is_given_by_any_two_of_its_loads(loads):
    """42 N/mm, 260 N on the shut valve, 680 N at its lift of 10 mm."""
    follower = {"mass": 0.12, "restitution": 0.4}
    made = camcli.load_scene({"follower": follower, "cam": CYCLOIDAL, "spring": loads})
    assert made.follower.stiffness == pytest.approx(42000.0, rel=1e-6)
    assert made.follower.preload == pytest.approx(260.0, rel=1e-6)
    again = camcli.load_scene(json.loads(made.model_dump_json()))
    assert again == made


@pytest.mark.parametrize(
    ("follower", "spring", "said"),
    [
        ({"stiffness": 42000}, {"seat_load": 260}, "found follower.stiffness beside loads"),
        ({}, {"seat_load": 260}, "spring: found seat_load, expected two of rate, preload"),
        ({}, {"preload": 260, "seat_load": 260}, "both are at q = 0 here"),
        ({}, {"seat_load": 680, "nose_load": 260}, "expected a spring that presses harder at 0.01"),
        ({}, {"rate": 1, "seat_load": 2, "nose_load": 3}, "found rate, seat_load, nose_load"),
        ({}, {"solid_at": 0.012}, "follower.stiffness"),
    ],
)
def test_too_little_or_too_much_of_a_spring_is_one_fault(follower, spring, said):
    follower = {"mass": 0.12, "restitution": 0.4, **follower}
    with pytest.raises(camcli.SceneError) as error:
        camcli.load_scene({"follower": follower, "cam": CYCLOIDAL, "spring": spring})
    (fault,) = error.value.faults
    assert said in str(fault)


CYCLOIDAL = {
    "kind": "law", "base": 0.0, "lift": 0.01, "top_dwell_deg": 0.0,
    "rise": {"start_deg": 115.0, "length_deg": 65.0, "law": "cycloidal"},
    "fall": {"length_deg": 65.0, "law": "cycloidal"},
}  # fmt: skip
VALVE = {
    "follower": {"mass": 0.12, "stiffness": 42000.0, "preload": 260.0, "restitution": 0.4},
    "cam": CYCLOIDAL,
    "detach": {"rpm": {"start": 3000.0, "stop": 4000.0, "num": 3}, "settle": 0},
}


def test_springs_leave_a_margin_and_room_and_are_not_absurd():
    """The margin is a tenth of the largest force the springs must give, unless it is stated."""
    found = camcli.detach(camcli.load_scene(VALVE, {"detach.hold_to": 4500.0})).values
    accel = max(-a for a in camcli.simulate(camcli.load_scene(VALVE), profile_only=True)
                .tables["profile"]["c_thetatheta_m_per_rad2"])  # fmt: skip
    assert found.margin == pytest.approx(0.1 * 0.12 * (150 * pi) ** 2 * accel, rel=1e-3)
    assert [hold.least_n for hold in found.holds] == pytest.approx([found.margin] * 3)
    assert found.holds[2].preload / found.holds[2].stiffness == pytest.approx(260 / 42000)
    more = found.holds[1].preload - 260
    for room, status in ((1.001, "ok"), (0.999, "impossible")):
        values = {"detach.hold_to": 4500.0, "spring": {"solid_at": 0.01 + room * more / 42000}}
        holds = camcli.detach(camcli.load_scene(VALVE, values)).values.holds
        assert [hold.status for hold in holds] == ["ok", status, "ok"]
    holds = camcli.detach(camcli.load_scene(VALVE, {"detach.hold_to": 45000.0})).values.holds
    assert {hold.status for hold in holds} == {"absurd"}


@pytest.mark.slow
def test_what_happens_past_the_loss_of_contact(cam, begun):
    short = "--no-plot --points 5"
    done = cam(f"detach -c lobe.yaml {short} -v")
    verdict = done.stdout.partition("\n\n")[0]
    result = camcli.detach(camcli.load_scene(begun / "lobe.yaml", {"detach.rpm.num": 5}))
    first, speeds = result.values.detachment.first.rpm, result.tables["speeds"]
    assert first < speeds["rpm"][0] < speeds["rpm"][-1] == result.scene.detach.rpm.stop
    assert f"from {speeds['rpm'][0]:.0f} to {speeds['rpm'][-1]:.0f} rpm" in verdict  # 100 apart
    k = int(speeds["max_impact_m_per_s"].argmax())
    gap, lift = max(speeds["max_gap_m"]), speeds["landing_lift_m"][k]
    hardest = speeds["max_impact_m_per_s"][k]
    assert f"it flies {gap * 1e3:.3g} mm and lands at {hardest:.2g} m/s at most." in verdict
    place = f"{speeds['landing_deg'][k]:.4g} deg, {lift * 1e3:.3g} mm above its lowest"
    assert f"The hardest landing is at {place}." in verdict
    assert "Past the loss of contact" in done.stdout
    assert "Critical speeds" in done.stdout
    done = cam(f"detach -c lobe.yaml {short}")
    assert "bracket, " not in done.stdout
    assert "The hardest landing" not in done.stdout


def test_the_pressure_is_told_from_standstill_on_and_at_the_working_speed(cam, tmp_path):
    """On the nose of an eccentric, c = e (1 - cos): N = 2 k e + F0 - m e w^2, R the same all over.

    Without damping N is linear in w^2 at each phase: its largest lies at an end of the speeds.
    """
    e, radius, top = 0.005, 0.020, 900.0
    follower = {"mass": 0.11, "stiffness": 45e3, "preload": 250.0, "damping": 0.0,
                "restitution": 0.4}  # fmt: skip
    contact = {"width": 0.012, "base_radius": 0.015, "modulus": 1.1e11}
    scene = {
        "cam": {"kind": "eccentric", "base": 0.0, "lift": 2 * e}, "follower": follower,
        "contact": contact, "run": {"rpm": 700.0},
        "detach": {"rpm": {"start": 300.0, "stop": top, "num": 2}},
    }  # fmt: skip
    (tmp_path / "ring.yaml").write_text(json.dumps(scene))
    done = cam("detach -c ring.yaml --no-plot", code=0)
    told = done.stdout.partition("Contact force if")[2].splitlines()[3:7]
    assert [line.split()[0] for line in told] == ["0", "300", "700", "900"]

    def pressure(rpm, theta):
        moved = 0.11 * (rpm * pi / 30.0) ** 2 * e * np.cos(theta)
        pressed = 45e3 * e * (1.0 - np.cos(theta)) + 250.0 + moved
        return np.sqrt(pressed * 1.1e11 / (pi * 0.012 * radius))

    least = json.loads((tmp_path / "out/detach/run.json").read_text())["result"]["least_force"]
    for line, row in zip(told, least, strict=True):
        highest = pressure(row["rpm"], pi)
        assert row["largest_pressure_pa"] == pytest.approx(highest, rel=1e-5)
        assert row["largest_pressure_deg"] == pytest.approx(180.0, abs=0.5)  # it is sampled
        shown = [row["largest_pressure_pa"] / 1e6, row["largest_pressure_deg"]]
        assert line.split()[-2:] == [f"{shown[0]:.3g}", f"{shown[1]:.4g}"]
    everywhere = pressure(np.linspace(0.0, top, 91)[:, None], np.linspace(0.0, 2 * pi, 361))
    assert everywhere.max() == pytest.approx(least[0]["largest_pressure_pa"], rel=1e-5)


def test_the_pressure_of_a_line_contact():
    """A round cam: under a flat face R is its radius, under a roller 1/R is the sum of both."""
    ring = {"kind": "eccentric", "base": 0.0, "lift": 0.01}
    contact = {"width": 0.012, "base_radius": 0.015, "modulus": 1.1e11}
    scene = {**VALVE, "cam": ring, "contact": contact}
    force = camcli.detach(camcli.load_scene(scene)).tables["force"]
    wanted = np.sqrt(np.maximum(force["force_n"], 0) * 1.1e11 / (pi * 0.012 * 0.020))
    assert force["pressure_pa"] == pytest.approx(wanted, rel=1e-12)
    scene = {**VALVE, "contact": {**contact, "follower_radius": 0.01}}
    force = camcli.detach(camcli.load_scene(scene)).tables["force"]
    radius = 1 / (1 / 0.015 + 1 / 0.01)  # on the base circle
    assert force["pressure_pa"][0] == pytest.approx(sqrt(260 * 1.1e11 / (pi * 0.012 * radius)))
    del contact["base_radius"]
    with pytest.raises(camcli.SceneError, match=r"contact\.base_radius: found no radius"):
        camcli.detach(camcli.load_scene({**VALVE, "contact": contact}))


@pytest.mark.ci
@pytest.mark.slow
def test_a_report_is_one_page_for_print(cam, begun):
    """A4, the same bytes again, with springs for the end of the range where none are asked for."""
    cam("detach -c lobe.yaml --no-plot --points 3 --report", code=0)
    page = (begun / "out/detach/report.pdf").read_bytes()
    assert (page[:5], page.count(b"/Type /Page "), page.count(b"/Count 1")) == (b"%PDF-", 1, 1)
    width, height = re.search(rb"/MediaBox \[ 0 0 ([0-9.]+) ([0-9.]+) \]", page).groups()
    assert (float(width), float(height)) == pytest.approx((210 / 25.4 * 72, 297 / 25.4 * 72))
    record = json.loads((begun / "out/detach/run.json").read_text())
    assert record["scene"]["detach"]["hold_to"] == record["scene"]["detach"]["rpm"]["stop"]
    assert len(record["result"]["hold"]) == 3
    cam("rerun out/detach/run.json --folder . -o again", code=0)
    assert (begun / "again/report.pdf").read_bytes() == page


@pytest.mark.slow
def test_tolerances_give_the_chance_and_the_worst_case(cam, tmp_path):
    """Without damping a speed goes with 1/sqrt(m)."""
    values = {"detach.hold_to": 4500.0, "detach.margin_n": 0.0, "detach.machines": 20,
              "detach.tolerance": [{"key": "follower.mass", "percent": 12.0}]}  # fmt: skip
    found = camcli.detach(camcli.load_scene(VALVE, values))
    table, said = found.tables["tolerance"], found.summary["tolerance"]
    root = np.sqrt(table["follower.mass"] / 0.12)
    assert root[:2] ** 2 == pytest.approx([0.88, 1.12])
    assert table["first_detachment_rpm"] * root == pytest.approx(found.values.detachment.first.rpm)
    for name in ("stiffness", "preload", "both"):
        assert table[f"hold_{name}_rpm"] * root == pytest.approx(4500.0, rel=1e-9)
    assert said["worst_rpm"] == pytest.approx(min(table["first_detachment_rpm"]))
    chance = np.mean(table["follower.mass"][2:] <= 0.12)
    assert 0.2 < chance < 0.8
    assert {spring["chance"] for spring in said["springs"].values()} == {chance}
    (tmp_path / "valve.yaml").write_text(json.dumps({**VALVE, "run": {"rpm": 3000.0}}))
    words = "detach -c valve.yaml --no-plot --hold-to 4500 --tolerance follower.mass=12%"
    done = cam(words, "--set detach.machines=20 --set detach.margin_n=0 -v")
    verdict = done.stdout.partition("\n\n")[0]
    speeds = f"hold up to {said['median_rpm']:.4g} rpm, the worst up to {said['worst_rpm']:.4g}."
    assert f"Half of the machines in tolerance {speeds}" in verdict
    assert "The tolerances are follower.mass 12 %." in verdict
    assert "In the worst machine they are follower.mass +12 %." in verdict
    assert "What matters most is follower.mass: 1e+02 % of the variance" not in verdict
    assert said["worst"] == {"follower.mass": pytest.approx(12.0)}
    sampled = table["follower.mass"][2:], table["first_detachment_rpm"][2:]
    assert said["shares"]["follower.mass"] == pytest.approx(np.corrcoef(sampled)[0, 1] ** 2)
    rows = (tmp_path / "out/detach/tolerance.csv").read_text()
    assert rows == "".join(found.tables["tolerance"].csv())


def test_tolerances_may_be_given_one_by_one(cam, tmp_path):
    """Without damping and preload the speed goes with sqrt(k/m): all three columns are there."""
    words = "--tolerance follower.mass=5% --tolerance follower.stiffness=3%,follower.restitution=1%"
    cam("detach --no-plot --rpm 100:120 --points 2 --set detach.machines=1", words, code=0)
    rows = np.genfromtxt(tmp_path / "out/detach/tolerance.csv", delimiter=",", names=True)
    found = rows["first_detachment_rpm"] / 114.97932674399878183
    expected = np.sqrt(rows["followerstiffness"] / 1430.8 / (rows["followermass"] / 1.221))
    assert len(rows) == 2**3 + 1
    assert found == pytest.approx(expected, rel=1e-12)


def test_a_table_elsewhere_is_found_when_numbers_vary(cam, begun):
    vary = "--vary cam.rocker_ratio=1:1.1 --points 2 --no-plot"
    (begun / "elsewhere").mkdir()
    (begun / "lobe.csv").rename(begun / "elsewhere/lobe.csv")
    (begun / "lobe.yaml").rename(begun / "elsewhere/lobe.yaml")
    short = "--set run.transient=2 --set run.record=2 --rpm 2000"
    cam(f"sweep -c elsewhere/lobe.yaml {vary} {short}", code=0)


@pytest.mark.parametrize(
    ("label", "said"),
    [
        ("contact", "stays on the cam"),
        ("aperiodic", "never repeats"),
        ("undecided", "not known"),
        ("P(1;1)", "1 impact every turn"),
        ("P(3;3:3:2)", "8 impacts in 3 turns"),
        ("P(1;inf)", "bounces to rest every turn"),
        ("P(2;inf:3)", "rests in 1 of 2 turns"),
    ],
)
def test_a_label_in_words(label, said):
    assert motion(Label.parse(label) if label.startswith("P(") else label) == said


def test_the_number_that_matters_most_has_most_of_the_variance():
    """Without damping and preload rpm^2 goes with k/m: shares are as the squares of tolerances."""
    tolerance = [{"key": "follower.mass", "percent": 3.0},
                 {"key": "follower.stiffness", "percent": 1.0}]  # fmt: skip
    values = {"detach.tolerance": tolerance, "detach.machines": 120,
              "detach.rpm": {"start": 114.0, "stop": 114.5, "num": 2}}  # fmt: skip
    result = camcli.detach(camcli.load_scene(None, values))
    said = result.summary["tolerance"]
    assert said["shares"]["follower.mass"] == pytest.approx(0.9, abs=0.05)
    assert said["shares"]["follower.stiffness"] == pytest.approx(0.1, abs=0.05)
    assert said["worst"] == pytest.approx({"follower.mass": 3.0, "follower.stiffness": -1.0})
    machines, shares = camcli.plot(result, panels=["machines", "shares"]).axes[1:]
    assert sum(bar.get_height() for bar in machines.patches) == 120
    places = {line.get_label(): line.get_xdata()[0] for line in machines.lines}
    drawn = result.tables["tolerance"]["first_detachment_rpm"]
    assert min(places.values()) == min(drawn) == said["worst_rpm"]
    assert places["the machine as given"] == pytest.approx(114.979326744)
    halves = [np.median(drawn[4:]), 114.979326744, min(drawn)]
    assert sorted(places.values()) == pytest.approx(sorted(halves))
    widths = [bar.get_width() for bar in shares.patches]
    assert widths == pytest.approx([100.0 * share for share in sorted(said["shares"].values())])
    names = [text.get_text() for text in shares.get_yticklabels()]
    assert names == ["stiffness\nworst −1 %", "mass\nworst +3 %"]


def test_shares_of_the_variance_add_up_to_one_of_few_machines_too():
    """The speed goes with sqrt(k/m), for small tolerances nearly a straight line.

    The numbers of only twelve machines are correlated by chance: their squared correlations with
    the speed add up to 1.27.
    """
    percents = {"mass": 3.0, "stiffness": 2.0, "restitution": 5.0}
    tolerance = [{"key": f"follower.{name}", "percent": off} for name, off in percents.items()]
    values = {"detach.tolerance": tolerance, "detach.machines": 12,
              "detach.rpm": {"start": 114.0, "stop": 114.5, "num": 2}}  # fmt: skip
    shares = camcli.detach(camcli.load_scene(None, values)).summary["tolerance"]["shares"]
    assert sum(shares.values()) == pytest.approx(1.0, abs=0.002)
    assert max(shares.values()) <= 1.0
    assert shares["follower.restitution"] < 0.001  # the first detachment does not hang on it
    assert shares["follower.mass"] > shares["follower.stiffness"] > 0.05


INCH, ROCKER, CLEARANCE = 0.0254, 1.6, 0.00025  # m per inch; valve per lobe; m at the valve
LOBE_INCH, FLANK = 0.25, 68.0  # of a 3-4-5 polynomial without a top dwell; deg of the cam
FOLLOWER = {"mass": 0.12, "stiffness": 40_000.0, "preload": 250.0, "damping": 15.0}


def least_force(rpm, stiffness):
    """Of a valve that is kept on the known lobe, from one end of its lash to the other, N."""
    x = np.linspace(0.0, 1.0, 100_001)
    lift, flank, omega = ROCKER * LOBE_INCH * INCH, radians(FLANK), rpm * pi / 30
    height = lift * (10 * x**3 - 15 * x**4 + 6 * x**5) - CLEARANCE
    speed = omega * lift / flank * (30 * x**2 - 60 * x**3 + 30 * x**4)
    acceleration = omega**2 * lift / flank**2 * (60 * x - 180 * x**2 + 120 * x**3)
    force = FOLLOWER["mass"] * acceleration + stiffness * height + FOLLOWER["preload"]
    return (force - FOLLOWER["damping"] * speed)[height >= 0.0].min()  # least on the closing side


def where_it_ends(holds, low, high):
    """Where something that is true at `low` and false at `high` ends."""
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def hardest_seating(rpm):
    """In the first turn of a valve between its lobe and its seat (mpmath), m/s."""
    with mp.workdps(15):
        lobe = LashedLobe(
            0.0, ROCKER * LOBE_INCH * INCH, 100.0, FLANK, 0.0, FLANK, "3-4-5", CLEARANCE
        )
        struck = []
        for event in Valve(lobe, rpm, restitution=0.4, seat_restitution=0.3, **FOLLOWER).events():
            if event.kind == "chatter" and event.surface == "seat" and struck:
                return float(max(struck)) * rpm * pi / 30
            if event.surface == "seat":
                struck.append(-event.u)
    raise AssertionError


def closing_ramp(rpm):
    """Speed at which the lobe alone sets the valve down, m/s."""
    lift = ROCKER * LOBE_INCH * INCH
    x = where_it_ends(lambda x: lift * (10 * x**3 - 15 * x**4 + 6 * x**5) < CLEARANCE, 0.0, 1.0)
    return rpm * pi / 30 * lift / radians(FLANK) * (30 * x**2 - 60 * x**3 + 30 * x**4)


@pytest.mark.ci
def test_from_crank_degrees_and_inches_behind_a_rocker_to_a_spring(cam, tmp_path):
    """A file rounded to 0.0001 inch every 2 deg of the crank, beside the law that it was made of.

    The working speeds are one at which the valve keeps to its lobe, and one at which it floats and
    falls on its seat half again as hard as the ramp would set it down.
    """
    lines = ["crank deg,lobe lift (inch)"]
    for crank in range(-150, 151, 2):
        x = max(1.0 - abs(crank / 2) / FLANK, 0.0)
        lines.append(f"{crank},{LOBE_INCH * (10 * x**3 - 15 * x**4 + 6 * x**5):.4f}")
    (tmp_path / "lobe.csv").write_text("\n".join(lines))
    cam("init lobe.csv --no-plot", code=0)
    filled_in(tmp_path / "lobe.yaml")
    text = (tmp_path / "lobe.yaml").read_text()
    for key, mine in (
        ("damping", "15"), ("restitution", "0.4\n  seat_restitution: 0.3"), ("rpm", "3000"),
        ("rocker_ratio", "1.6"), ("measured_at", "lobe"), ("base", "0\n  lash: 0.00025"),
    ):  # fmt: skip
        text, count = re.subn(rf"(?m)^  {key}: .*$", f"  {key}: {mine}", text)
        assert count == 1, key
    (tmp_path / "lobe.yaml").write_text(text)
    short = "--set run.transient=5 --set run.record=5 --set detach.margin_n=100"
    line = "detach -c lobe.yaml --hold-to 4000 --points 2 --no-plot -o ."
    done = cam(line, short, code=0)
    assert "CHECK" not in done.stderr

    found = json.loads((tmp_path / "run.json").read_text())["result"]
    first = next(one for one in found["critical_speeds"] if one["quantity"] == "first_detachment")
    truth = where_it_ends(lambda rpm: least_force(rpm, FOLLOWER["stiffness"]) > 0, 1000.0, 9000.0)
    assert first["low_rpm"] <= truth <= first["high_rpm"]
    assert first["rpm"] == pytest.approx(truth, rel=0.005)

    cam("sweep -c lobe.yaml --rpm 3000:3900 --points 2 --no-plot -o sweep", short, code=0)
    slow, fast = rows(tmp_path / "sweep/speeds.csv")
    for row in (slow, fast):
        rpm = float(row["rpm"])
        ramp = float(row["seat_ramp_velocity_m_per_s"])
        assert ramp == pytest.approx(closing_ramp(rpm), rel=0.003)
    assert slow["seat_velocity_m_per_s"] == slow["seat_ramp_velocity_m_per_s"]
    hardest = hardest_seating(3900.0)
    assert hardest > 1.4 * closing_ramp(3900.0)
    assert float(fast["seat_velocity_m_per_s"]) == pytest.approx(hardest, rel=0.06)

    stiffer = next(hold for hold in found["hold"] if hold["quantity"] == "hold_stiffness")
    enough = where_it_ends(lambda k: least_force(4000.0, k) < 100.0, 1e4, 1e6)
    assert enough < stiffer["stiffness"] < 1.05 * enough


ALL_AT_ONCE = (
    "--hold-to 4000 --tolerance follower.mass=5%,follower.stiffness=3% --set cam.lash=0.00025 "
    "--set detach.machines=4 --set spring='{mass: 0.06, in_follower: true, solid_at: 0.02}' "
    "--set contact='{width: 0.01, follower_radius: 0.012, base_radius: 0.03}' --points 3 --no-plot"
)


@pytest.mark.ci
@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("lift-table", ALL_AT_ONCE),
        ("valve-train", "--hold-to 8000crank --points 3 --no-plot"),
        ("valve-lash", ALL_AT_ONCE),
    ],
)
def test_a_verdict_is_ten_lines_of_a_screen_at_most(cam, tmp_path, name, more):
    done = cam(f"detach -c configs/{name}.yaml {more}", code=0)
    verdict = done.stdout.partition("\n\n")[0].splitlines()
    record = json.loads((tmp_path / "out/detach/run.json").read_text())
    assert verdict == record["verdict"]
    lines = [line for sentence in verdict for line in wrap(sentence, 80)]
    assert len(lines) <= 10, lines
    whole = cam(f"detach -c configs/{name}.yaml {more} -v", code=0)
    both = [*record["verdict"], *record["verdict_details"]]
    assert whole.stdout.partition("\n\n")[0].splitlines() == both
