"""One valve worked out by hand, and every number that the screen prints of it.

A harmonic lobe without dwell, c = base + h/2 (1 - cos phi) with phi = (theta - 110 deg) pi/70 deg,
an undamped follower with preload and weight: force, critical speeds, springs, flights and pressure
are elementary. What is printed is held to half a unit of its last digit.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import takewhile
from math import (
    acos,
    atan2,
    cos,
    degrees,
    floor,
    hypot,
    inf,
    isnan,
    log10,
    pi,
    radians,
    sin,
    sqrt,
)  # fmt: skip
from statistics import fmean
from types import SimpleNamespace

import matplotlib.pyplot as plt
import pytest
import yaml
from conftest import cam_in, rows

import camcli
from camcli.analysis.contact_loss.detachment import detachment
from camcli.api.detach import _outline
from camcli.api.lift_table import with_ranges
from camcli.api.machine import machine_of
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.plots.detach import report_panels
from camcli.words.machine import machine
from camcli.words.simulate import lobe_title

MASS, STIFFNESS, PRELOAD, GRAVITY, RESTITUTION = 0.25, 40_000.0, 300.0, 9.81, 0.5
BASE, LIFT, START, LENGTH = 0.002, 0.010, 110.0, 70.0
WIDTH, RADIUS, MODULUS = 0.012, 0.030, 1.154e11
TOP_SPEED, FROM, TO = 4000.0, 3000.0, 3800.0
SCENE = f"""
follower: {{mass: {MASS}, stiffness: {STIFFNESS}, damping: 0, gravity: {GRAVITY},
            preload: {PRELOAD}, restitution: {RESTITUTION}}}
cam: {{kind: law, base: {BASE}, lift: {LIFT}, top_dwell_deg: 0,
       rise: {{start_deg: {START}, length_deg: {LENGTH}, law: harmonic}},
       fall: {{length_deg: {LENGTH}, law: harmonic}}}}
contact: {{width: {WIDTH}, base_radius: {RADIUS}}}
detach: {{rpm: {{start: {FROM}, stop: {TO}, num: 5}}}}
"""
RATE = 180.0 / LENGTH  # d phi/d theta
NOSE = 0.5 * LIFT * RATE**2  # -c_thetatheta at the nose, m/rad2
PRESS = PRELOAD + MASS * GRAVITY  # what presses at q = 0, N
ENDS = BASE + LIFT  # highest c, m


def omega(rpm: float) -> float:
    return rpm * pi / 30.0


def lobe(theta: float) -> tuple[float, float, float]:
    """c, c_theta, c_thetatheta at a phase in rad."""
    phi = (theta - radians(START)) * RATE
    if not 0.0 <= phi <= 2.0 * pi:
        return BASE, 0.0, 0.0
    return BASE + 0.5 * LIFT * (1.0 - cos(phi)), 0.5 * LIFT * RATE * sin(phi), NOSE * cos(phi)


def force(rpm: float, theta: float, stiffness: float = STIFFNESS, preload: float = PRELOAD):
    c, _, bend = lobe(theta)
    return stiffness * c + preload + MASS * GRAVITY + MASS * omega(rpm) ** 2 * bend


def detaches(stiffness: float, preload: float) -> float:
    """rpm: m omega^2 NOSE = k c + F0 + m g at the nose, the weakest phase."""
    return sqrt((stiffness * ENDS + preload + MASS * GRAVITY) / (MASS * NOSE)) * 30.0 / pi


def departure(rpm: float) -> float:
    """Phase in rad where the contact force reaches zero on the rise."""
    inertia = NOSE * MASS * omega(rpm) ** 2 - 0.5 * LIFT * STIFFNESS
    return radians(START) + acos(-(PRESS + STIFFNESS * (BASE + 0.5 * LIFT)) / inertia) / RATE


def flight(rpm: float) -> tuple[float, float, float]:
    """(largest gap m, impact speed m/s, landing phase rad) of the flight from the departure."""
    leave, w = departure(rpm), sqrt(STIFFNESS / MASS) / omega(rpm)  # w: free frequency, per rad
    rest = -PRESS / STIFFNESS
    c, slope, _ = lobe(leave)
    size, phase = hypot(c - rest, slope / w), atan2(slope / w, c - rest)

    def gap(theta: float) -> float:
        return rest + size * cos(w * (theta - leave) - phase) - lobe(theta)[0]

    steps = 20_000
    angles = [leave + k * radians(170.0) / steps for k in range(1, steps)]
    gaps = [gap(theta) for theta in angles]
    landing = next(k for k in range(50, steps) if gaps[k] <= 0.0)
    low, high = angles[landing - 1], angles[landing]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if gap(middle) > 0.0:
            low = middle
        else:
            high = middle
    speed = -size * w * sin(w * (low - leave) - phase) - lobe(low)[1]
    return max(gaps[:landing]), -speed * omega(rpm), low


NEEDED = MASS * omega(TOP_SPEED) ** 2 * NOSE - MASS * GRAVITY  # of the spring at the nose, N
MARGIN = 0.1 * NEEDED
SPRINGS = {  # stiffness, preload: the force at the nose is what is needed and the margin
    "stiffer spring": ((NEEDED + MARGIN - PRELOAD) / ENDS, PRELOAD),
    "more preload": (STIFFNESS, NEEDED + MARGIN - STIFFNESS * ENDS),
    "another spring": (
        (NEEDED + MARGIN) / (ENDS + PRELOAD / STIFFNESS),
        (NEEDED + MARGIN) / (ENDS + PRELOAD / STIFFNESS) * PRELOAD / STIFFNESS,
    ),
}


@pytest.fixture(scope="module")
def detach(tmp_path_factory):
    """Screen, folder and JSON result of `cam detach --hold-to`."""
    folder = tmp_path_factory.mktemp("valve")
    (folder / "valve.yaml").write_text(SCENE)
    line = f"detach -c valve.yaml --hold-to {TOP_SPEED:g} --verbose --no-plot -o out"
    done = cam_in(folder, line, code=0)
    return done.stdout, folder / "out", json.loads((folder / "out/run.json").read_text())["result"]


def near(text: str, value: float, of_digits: int = 0) -> bool:
    """Whether a printed number is the value, rounded to the digits that are printed.

    of_digits: so many significant ones at least.
    """
    digits = re.fullmatch(r"-?\d+(?:\.(\d+))?(?:e([+-]\d+))?", text.strip())
    assert digits, text
    unit = 10.0 ** (int(digits[2] or 0) - len(digits[1] or ""))
    if digits[1] is None and digits[2] is None:  # trailing zeros may stand for the digits before
        zeros = len(text) - len(text.rstrip("0"))
        unit *= 10.0 ** min(zeros, max(0, len(text.strip("-")) - 3))
    if of_digits and value:
        unit = min(unit, 10.0 ** (floor(log10(abs(value))) - of_digits + 1))
    return abs(float(text) - value) <= 0.501 * unit


def table(screen: str, title: str) -> list[list[str]]:
    """The rows of a table on the screen, by the line above it."""
    lines = screen.splitlines()
    top = next(k for k, line in enumerate(lines) if line.startswith(title))
    first = next(k for k in range(top, len(lines)) if lines[k].startswith("─")) + 1
    rows = takewhile(lambda line: re.search(r"\S {2,}\S", line), lines[first:])
    return [re.split(r" {2,}", line.strip()) for line in rows]


def test_the_verdict(detach):
    screen, *_ = detach
    verdict = screen.split("Past the loss of contact")[0].replace("\n", " ")
    (holds,) = re.findall(r"Contact holds up to (\S+) rpm of the cam", verdict)
    assert near(holds, detaches(STIFFNESS, PRELOAD))
    low, high, loft, speed = re.search(
        r"from (\S+) to (\S+) rpm, it flies (\S+) mm and lands at (\S+) m/s at most", verdict
    ).groups()
    assert (float(low), float(high)) == (FROM, TO)
    gap, impact, landing = flight(TO)
    assert near(speed, impact)
    (theta,) = re.findall(r"The hardest landing is at (\S+) deg, on the base circle\.", verdict)
    assert near(theta, degrees(landing))
    assert lobe(landing)[0] - BASE < 1e-3 * LIFT
    assert near(loft, 1e3 * gap)
    asked, margin, stiffer, harder, *both = re.search(
        r"To hold up to (\S+) rpm of the cam with (\S+) N to spare it takes (\S+) N/mm, "
        r"(\S+) N of preload or (\S+) N/mm with (\S+) N of preload\.",
        verdict,
    ).groups()
    assert float(asked) == TOP_SPEED
    assert near(margin, MARGIN)
    assert near(stiffer, 1e-3 * SPRINGS["stiffer spring"][0])
    assert near(harder, SPRINGS["more preload"][1])
    assert near(both[0], 1e-3 * SPRINGS["another spring"][0])
    assert near(both[1], SPRINGS["another spring"][1])


def test_the_table_past_the_loss_of_contact(detach):
    """A row a speed: its flight from the closed form, the forces at the two ends of the lobe."""
    screen, *_ = detach
    found = table(screen, "Past the loss of contact")
    assert len(found) >= 5
    for rpm, loft, speed, theta, lift, _, forces in found:
        value = FROM + round((float(rpm) - FROM) / ((TO - FROM) / (len(found) - 1))) * (
            TO - FROM
        ) / (len(found) - 1)
        assert near(rpm, value)
        gap, impact, landing = flight(value)
        assert near(loft, 1e3 * gap), rpm
        assert near(speed, impact), rpm
        assert near(theta, degrees(landing)), rpm
        assert near(lift, 1e3 * (lobe(landing)[0] - BASE)), rpm
        least, most = forces.split(" to ")
        assert float(least) == 0.0
        assert near(most, force(value, radians(START))), rpm  # where the rise begins
    # four digits, of which the last may be a zero that is left out
    digits = [len(forces.split(" to ")[1].replace(".", "").rstrip("0")) for *_, forces in found]
    assert max(digits) == 4


def test_the_springs_that_hold(detach):
    screen, _, result = detach
    found = table(screen, "Springs that hold contact")
    assert [row[0] for row in found] == list(SPRINGS)
    for (name, rate, preload, full, holds, status), row in zip(found, result["hold"], strict=True):
        k, load = SPRINGS[name]
        assert near(rate, 1e-3 * k)
        assert near(preload, load)
        assert near(full, k * ENDS + load), name
        assert near(holds, detaches(k, load))
        assert status == row["status"] == "ok"
        assert row["stiffness"] == pytest.approx(k, rel=1e-12)
        assert row["preload"] == pytest.approx(load, rel=1e-12)
        assert row["nose_n"] == pytest.approx(k * ENDS + load, rel=1e-12)
        assert row["detaches_rpm"] == pytest.approx(detaches(k, load), rel=1e-12)
        assert row["least_n"] == pytest.approx(MARGIN, rel=1e-12)
    assert result["hold_margin_n"] == pytest.approx(MARGIN, rel=1e-12)


def test_the_forces_and_the_pressure_of_a_follower_kept_on_the_cam(detach):
    """p = sqrt(F E*/(pi w rho)) on a flat face, rho = r_b + (c - base) + c_thetatheta."""
    screen, folder, result = detach
    pressures: dict[str, float] = {}
    for row in rows(folder / "force.csv"):
        pressed = float(row["pressure_pa"] or 0.0)
        pressures[row["rpm"]] = max(pressed, pressures.get(row["rpm"], 0.0))
    told = table(screen, "Contact force if the follower is kept")
    assert len(told) == len(pressures)
    for (rpm, least, at, most, pressed, _), highest in zip(told, pressures.values(), strict=True):
        assert near(pressed, 1e-6 * highest)
        value = next(row["rpm"] for row in result["least_force"] if near(rpm, row["rpm"]))
        if value == 0.0:  # at standstill the spring alone presses: least on the base circle
            assert near(least, force(value, 0.0))
            assert near(most, force(value, pi))
            continue
        assert near(least, force(value, pi))
        assert near(at, 180.0)
        assert near(most, force(value, radians(START)))
    checked = 0
    for row in rows(folder / "force.csv"):
        rpm, theta = float(row["rpm"]), radians(float(row["theta_deg"]))
        c, _, bend = lobe(theta)
        radius = RADIUS + (c - BASE) + bend
        here = force(rpm, theta)
        at_a_corner = min(abs(degrees(theta) - x) for x in (START, START + 2.0 * LENGTH)) < 1e-9
        if at_a_corner:
            continue
        assert float(row["force_n"]) == pytest.approx(here, rel=1e-9, abs=1e-9)
        pressure = float(row["pressure_pa"]) if row["pressure_pa"] else None
        if here > 1.0 and radius > 1e-4:
            assert pressure == pytest.approx(sqrt(here * MODULUS / (pi * WIDTH * radius)), rel=1e-9)
            checked += 1
    assert checked > 100


def test_the_critical_speeds(detach):
    screen, folder, _ = detach
    first = table(screen, "Critical speeds")[0]
    assert near(first[2], 180.0)
    assert near(first[3], detaches(STIFFNESS, PRELOAD))
    by_name = {(row["quantity"], row["region"]): row for row in rows(folder / "detach.csv")}
    row = by_name["first_detachment", "A1"]
    assert float(row["rpm"]) == pytest.approx(detaches(STIFFNESS, PRELOAD), rel=1e-12)
    assert float(row["omega_rad_per_s"]) == pytest.approx(omega(float(row["rpm"])), rel=1e-15)
    for name, (k, load) in zip(
        ("hold_stiffness", "hold_preload", "hold_both"), SPRINGS.values(), strict=True
    ):
        assert float(by_name[name, "A1"]["rpm"]) == pytest.approx(detaches(k, load), rel=1e-12)
    assert float(by_name["opens", "A2"]["rpm"]) == inf  # the dwell never lets go


def test_a_profile_and_a_motion(tmp_path):
    (tmp_path / "valve.yaml").write_text(SCENE)
    done = cam_in(tmp_path, "simulate -c valve.yaml --profile-only --rpm 2000 --no-plot", code=0)
    said = {row[0]: row[1:] for row in table(done.stdout, "Cam, corners")}
    wanted = {
        "least c (mm)": 1e3 * BASE,
        "largest c (mm)": 1e3 * ENDS,
        "least c_theta (mm/rad)": -1e3 * 0.5 * LIFT * RATE,
        "largest c_theta (mm/rad)": 1e3 * 0.5 * LIFT * RATE,
        "least c_thetatheta (mm/rad2)": -1e3 * NOSE,
        "largest c_thetatheta (mm/rad2)": 1e3 * NOSE,
        "least contact force at 2000 rpm (N)": force(2000.0, 0.0),
        "first detachment (rpm)": detaches(STIFFNESS, PRELOAD),
        "base radius a flat face needs (mm)": 1e3 * (NOSE - LIFT),
    }
    for name, value in wanted.items():
        assert near(said[name][0], value), (name, said[name], value)
    assert near(said["largest c (mm)"][1], 180.0)
    assert near(said["largest c_theta (mm/rad)"][1], START + 0.5 * LENGTH)
    done = cam_in(
        tmp_path,
        "simulate -c valve.yaml --rpm 3600 --no-plot --set run.transient=20 --set run.record=2",
        code=0,
    )
    _, impact, landing = flight(3600.0)
    (said,) = re.findall(r"lands at up to (\S+) m/s", done.stdout)
    assert near(said, impact)
    events = table(done.stdout, "3600 rpm")
    left, first = events[0], events[1]
    assert left[0] == "detachment"
    assert near(left[2], degrees(departure(3600.0)))
    assert first[0] == "impact"
    assert near(first[2], degrees(landing))
    assert near(first[3], -impact)
    assert near(first[4], RESTITUTION * impact)


def test_the_rows_of_the_machine():
    """As the page for print has them."""
    result = camcli.detach(camcli.load_scene(yaml.safe_load(SCENE)))
    said = dict(machine(result))
    assert said == {
        "machine": "", "mass": "0.25 kg", "spring": "40 N/mm", "damping": "0 N s/m",
        "force at lowest lift": f"{PRELOAD + STIFFNESS * BASE:g} N",
        "force at full lift": f"{PRELOAD + STIFFNESS * ENDS:g} N",
        "restitution": "0.5", "lift": "10 mm", "cam": said["cam"],
        "on the lobe": "flat", "base radius": "30 mm", "width of contact": "12 mm",
    }  # fmt: skip
    odd = replace(result.system.follower, mass=0.1234567, damping=12.34567, restitution=0.54321)
    own = SimpleNamespace(follower=odd, cam=result.system.cam, shape=result.system.shape,
                          rocker_ratio=1.0, lift=result.system.lift, has_seat=False)  # fmt: skip
    said = dict(machine(SimpleNamespace(system=own, scene=result.scene)))
    for name, text in {
        "mass": "0.1235 kg", "damping": "12.35 N s/m", "restitution": "0.543"
    }.items():  # fmt: skip
        assert said[name] == text
    seated = replace(odd, seat_restitution=0.234567)
    own = SimpleNamespace(**{**vars(own), "has_seat": True, "lash": 1.2345678e-4,
                             "follower": seated})  # fmt: skip
    said = dict(machine(SimpleNamespace(system=own, scene=result.scene)))
    assert (said["lash"], said["restitution, seat"]) == ("0.1235 mm", "0.235")
    assert (said["lift"], said["lift less lash"]) == ("10.12 mm", "10 mm")
    for ratio, text in ((0.75123456, "0.751235"), (1.0, None), (1.5, "1.5")):
        system = SimpleNamespace(follower=result.system.follower, cam=result.system.cam,
                                 shape=result.system.shape, rocker_ratio=ratio,
                                 lift=result.system.lift, has_seat=False)  # fmt: skip
        rows = dict(machine(SimpleNamespace(system=system, scene=result.scene)))
        assert rows.get("rocker ratio") == text


def test_the_page_names_the_drawn_lift_and_the_parts_that_its_numbers_come_from():
    """A lift of 10 mm and a lash of 0.3 mm, a roller on the lobe, and a spring of 60 g."""
    values = {"cam.lash": 0.0003, "spring": {"mass": 0.06, "in_follower": True},
              "contact": {"face": "roller", "follower_radius": 0.011}}  # fmt: skip
    own = camcli.load_scene(yaml.safe_load(SCENE), values)
    said = dict(machine(SimpleNamespace(system=machine_of(own).system, scene=own)))
    assert (said["lift"], said["lash"], said["lift less lash"]) == ("10 mm", "0.3 mm", "9.7 mm")
    assert (said["mass of the spring"], said["on the lobe"]) == ("0.06 kg", "roller of 11 mm")
    assert "width of contact" not in said
    none = camcli.load_scene(yaml.safe_load(SCENE), {"cam.lash": 0, "contact": None})
    said = dict(machine(SimpleNamespace(system=machine_of(none).system, scene=none)))
    assert (said["lift"], said["lash"]) == ("10 mm", "0 mm")
    assert not {"lift less lash", "on the lobe", "mass of the spring"} & set(said)


CRANK = """
cam: {kind: table, file: lift.csv, header: true, angle_column: 1, lift_column: 2, angle: crank,
      lift: mm, zero_deg: 0, direction: same, base: 0.002}
"""


@pytest.mark.ci
def test_a_measured_cam_in_degrees_of_the_crank(tmp_path):
    """The same lobe from a table of three decimals, at every degree of the crank."""
    phases = [0.5 * k for k in range(720)]
    lifts = [round(1e3 * (lobe(radians(theta))[0] - BASE), 3) for theta in phases]
    lines = [f"{2 * theta:g},{lift:.3f}" for theta, lift in zip(phases, lifts, strict=True)]
    (tmp_path / "lift.csv").write_text("crank_deg,mm\n" + "\n".join(lines) + "\n")
    text = SCENE.split("cam:")[0] + CRANK + "detach: {" + SCENE.split("detach: {")[1]
    (tmp_path / "valve.yaml").write_text(text)
    line = f"detach -c valve.yaml --hold-to {TOP_SPEED:g} --no-plot -o out"
    done = cam_in(tmp_path, line, code=0)
    record = json.loads((tmp_path / "out/run.json").read_text())
    found = record["error"]["lift_table"]
    holds, crank, *ends = re.search(
        r"Contact holds up to (\S+) rpm of the cam \((\S+) of the crank\); its table leaves "
        r"(\S+) to (\S+) rpm",
        done.stdout.replace("\n", " "),
    ).groups()
    low, high = found["first_detachment_rpm"]
    true = detaches(STIFFNESS, PRELOAD)
    assert low < true < high
    (rpm,) = [
        float(row["rpm"])
        for row in rows(tmp_path / "out/detach.csv")
        if row["quantity"] == "first_detachment"
    ]
    assert near(holds, rpm)
    assert near(crank, 2.0 * rpm)
    last = 10.0 ** -len(ends[0].partition(".")[2])
    assert [float(end) for end in ends] == pytest.approx((low, high), rel=0.0, abs=0.501 * last)
    past = table(done.stdout, "Past the loss of contact")
    kept = table(done.stdout, "Contact force if the follower is kept")
    for cam, turns_twice, *_ in [*past, *kept]:
        last = 10.0 ** -len(cam.partition(".")[2])  # each is rounded by itself
        assert abs(float(turns_twice) - 2.0 * float(cam)) <= 1.5 * last

    for hold in record["result"]["hold"]:  # between these speeds that spring is first too weak
        weak = detaches(hold["stiffness"], hold["preload"])
        assert hold["low_rpm"] < weak < hold["high_rpm"]

    small = {"detach.rpm": {"start": FROM, "stop": FROM, "num": 1}}
    result = camcli.detach(camcli.load_scene(tmp_path / "valve.yaml", small))
    system, exact = result.system, detachment(result.system).first
    ended = with_ranges(replace(result.values, ends=(exact,), completion=(exact,)), system)
    first = ended.detachment.first
    assert (first.low, first.high) == pytest.approx((low, high), rel=1e-12)
    for speed in (*ended.ends, *ended.completion):  # how far a chatter is off is not known
        assert isnan(speed.low)
        assert isnan(speed.high)
    off = [
        lift_at(system.cam, stretch_at(system.cam, radians(theta)), radians(theta))[0]
        - BASE - 1e-3 * lift
        for theta, lift in zip(phases, lifts, strict=True)
    ]  # fmt: skip
    fit = re.search(
        r"(\d+) rows, lift (\S+) mm, last digit (\S+) um; the cam is within (\S+) um rms, "
        r"(\S+) um at most \(line (\d+)\)",
        done.stderr.replace("\n", " "),
    ).groups()
    assert (int(fit[0]), float(fit[1]), float(fit[2])) == (720, 10.0, 1.0)
    moving = [x for x, lift in zip(off, lifts, strict=True) if lift > 0.0]
    assert near(fit[3], 1e6 * sqrt(fmean(x * x for x in moving)))
    largest = max(range(720), key=lambda k: abs(off[k]))
    assert near(fit[4], 1e6 * abs(off[largest]))
    assert abs(off[int(fit[5]) - 2]) == pytest.approx(abs(off[largest]), rel=1e-6)
    bound, share, standard, bending, worst = re.search(
        r"off by an estimated (\S+) m/rad2 at most, (\S+) % of its largest \(standard error of its "
        r"noise (\S+), smoothing (\S+); with every digit at its worst (\S+)\)",
        done.stdout.replace("\n", " "),
    ).groups()
    assert near(share, 100.0 * found["bound"] / found["accel"])
    assert float(bound) == pytest.approx(3.0 * float(standard) + float(bending), rel=0.1)
    for said, name in ((bound, "bound"), (standard, "standard"), (bending, "bending"),
                       (worst, "worst")):  # fmt: skip
        assert near(said, found[name])
    assert found["accel"] == pytest.approx(NOSE, rel=0.1)


@pytest.mark.parametrize(
    ("contact", "lash", "told"),
    [
        ({"face": "roller", "follower_radius": 0.011}, 0.0003, "roller of 11 mm"),
        ({"face": "flat"}, 0.0003, "flat face"),
        ({"face": "knife"}, None, "knife edge"),
        ({"width": 0.012, "follower_radius": 0.011}, None, "roller of 11 mm"),
    ],
)
def test_the_drawing_of_the_page_has_the_follower_that_the_scene_says(contact, lash, told):
    """On its seat it stands a widened lash above the lobe, which lifts as the cam is drawn."""
    values = {"contact": {**contact, "base_radius": 0.030}, "detach.rpm.num": 1}
    values |= {} if lash is None else {"cam.lash": lash}
    result = camcli.detach(camcli.load_scene(yaml.safe_load(SCENE), values), report=True)
    drawn = _outline(result.scene, result.system)
    assert told == lobe_title(drawn.lobe, drawn.units)
    roller = contact.get("follower_radius", 0.0)
    assert drawn.at(0.0) == pytest.approx(0.030 + roller)
    _, y = drawn.body
    clear = drawn.at(0.0) - roller - float(y.max())
    assert drawn.lash == (lash or 0.0)
    assert clear == pytest.approx(drawn.lash * drawn.widened, abs=1e-6)
    nose = -float(y.min())  # the lobe's highest point, half a turn away
    assert nose == pytest.approx(0.030 - clear + LIFT, rel=1e-3)
    title = read_titles(result)
    assert told in title
    assert ("lash 0.3 mm" in title) == (lash is not None)


def read_titles(result):
    """The titles of the panels of a report."""
    panels = report_panels(result.values, result.system, _outline(result.scene, result.system), ())
    figure = plt.figure(figsize=(4.0, 4.0))
    axes = figure.add_subplot()
    panels["outline"].draw(axes)
    title = " ".join([axes.get_title(), axes.get_title(loc="left")])
    plt.close(figure)
    return title
