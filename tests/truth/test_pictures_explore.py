"""The data of explore.html against the tables of the commands it is made of, and the cam itself."""

import re
from functools import cache

import numpy as np
import pytest

import camcli
from camcli.api.explore_page import machine_data
from camcli.api.machine import machine_of
from tests.output.test_explore import data_of, rows_of, shown
from tests.output.test_figure_style import seen
from tests.support.machines import CHAPTER, TABLE, VALVE
from tests.support.picture_reader import COLOURS, FORCES

CASES = {
    "valve": (
        VALVE,
        {
            "sweep.rpm": {"start": 6000, "stop": 11500, "num": 6}, "run.record": 20,
            "orbits.rpm": {"start": 6500, "stop": 10500, "num": 8}, "orbits.at": 8000,
            "orbits.starts": 2, "basins.rpm": {"start": 6500, "stop": 6500},
            "basins.q": [-0.012, 0.05], "basins.v": [-30, 20], "basins.cells": [7, 5],
            "sweep.vary": [{"key": "follower.damping", "start": 30, "stop": 10, "num": 3}],
        },
    ),
    "chapter": (
        CHAPTER,
        {
            "sweep.rpm": {"start": 730, "stop": 748, "num": 4}, "run.transient": 200,
            "run.record": 30, "run.strobe_deg": 120.0, "orbits.starts": 2,
            "orbits.rpm": {"start": 730, "stop": 748, "num": 8}, "orbits.at": 735,
        },
    ),
}  # fmt: skip
CLOSE = 2e-7  # of a number with 24 bits
KINDS = ("impact", "chatter", "detachment")


@pytest.fixture(scope="module", params=CASES)
def page(request, tmp_path_factory):
    """The case, its scene, the data of its page, and what kinds of motions it was asked for."""
    machine, values = CASES[request.param]
    scene, more = machine.load(values), request.param == "valve"
    folder = tmp_path_factory.mktemp(request.param)
    camcli.explore(scene, with_basins=more, with_map=more, source="-c x.yaml").save(folder)
    return request.param, data_of(folder), (folder / "explore.html").read_text()


@cache
def part(name, command, **changes):
    """A command with the same scene."""
    machine, values = CASES[name]
    more = {key.replace("__", "."): value for key, value in changes.items()}
    if command == "sweep":
        values = {key: value for key, value in values.items() if key != "sweep.vary"}
    scene = machine.load({**values, "sweep.lyapunov": True, **more})
    if command == "orbits":  # over the speeds of the sweep
        span = scene.sweep.rpm
        ends = {"orbits.rpm.start": span.start, "orbits.rpm.stop": span.stop}
        scene = machine.load({**values, **ends})
    return getattr(camcli, command)(scene)


def close(found, wanted):
    return found == pytest.approx(np.asarray(wanted, float), rel=CLOSE, abs=1e-9, nan_ok=True)


def test_the_machine_is_that_of_the_scene(page):
    name, data, _ = page
    machine, values = CASES[name]
    assert {*data} == {
        "source", "kind", "follower", "strobe_deg", "corners", "speeds", "outline", "cam",
        "motions", "rows", "events", "points", "branches", "bifurcations", "planes", "measured",
        "units", "valve", "crank", "seat", "lash", "stops",
    }  # fmt: skip
    assert data["units"] == {
        "mass": "kg", "stiffness": "N/m", "damping": "N s/m", "gravity": "m/s²", "preload": "N",
        "restitution": "",
    }  # fmt: skip
    assert data["crank"] == (2.0 if name == "valve" else 0.0)
    assert data["measured"] == ""  # a law is known exactly
    for key, value in data["follower"].items():
        assert value == getattr(machine, key)
    assert data["source"] == "-c x.yaml"
    assert data["strobe_deg"] == values.get("run.strobe_deg", machine.strobe_deg)
    assert data["corners"] == pytest.approx(machine.cam.corners)
    assert data["speeds"] == list(values["sweep.rpm"].values())
    check_cam(machine, data, machine.base_radius)


def test_a_speed_of_a_crank_makes_the_page_tell_both_shafts():
    """The crank turns twice as fast as the cam of a four-stroke engine."""
    cranked = machine_of(camcli.load_scene(None, {"run.rpm": "1400 crank"}))
    assert machine_data(cranked)["crank"] == 2.0
    assert machine_data(machine_of(camcli.load_scene(None, {"run.rpm": 700})))["crank"] == 0.0


def check_cam(machine, data, base, ratio=1.0):
    """Lift and derivatives, and the outline that the follower runs on."""
    cam = {key: np.asarray(value, float) for key, value in data["cam"].items()}
    theta = cam["theta_deg"]
    away = [np.abs(theta - corner) for corner in machine.cam.corners.values()]
    inner = np.min(away, axis=0) > 1e-3  # angles have 24 bits
    for key, wanted in zip(("c", "c1", "c2"), machine.cam.lift(theta), strict=True):
        assert np.abs(cam[key] - wanted)[inner].max() < 5e-5 * np.abs(wanted).max()
    assert np.diff(theta).max() < 0.51
    outline = data["outline"]
    assert {*outline} == {"x", "y", "ratio", "rise", "told", "flat"}
    lowest = float(machine.cam.lift(machine.turn)[0].min())
    drawn = base or 1.5 * float(np.ptp(machine.cam.lift(machine.turn)[0])) / ratio
    assert outline["told"] == (base is not None)
    assert not outline["flat"]
    assert outline["ratio"] == ratio
    assert outline["rise"] == pytest.approx(drawn - lowest / ratio, abs=1e-6 * drawn)
    phase = np.degrees(np.arctan2(outline["x"], outline["y"]))
    radius = np.hypot(outline["x"], outline["y"])
    wanted = drawn + (machine.cam.lift(phase)[0] - lowest) / ratio
    assert radius == pytest.approx(wanted, rel=2e-4)


def test_the_cam_of_a_rocker_is_its_lobe(tmp_path):
    values = {
        "sweep.rpm": {"start": 3000, "stop": 3100, "num": 2}, "orbits.starts": 0,
        "run.transient": 20, "run.record": 5,
        "orbits.rpm.num": 2, "cam.rocker_ratio": 1.5, "cam.measured_at": "valve",
    }  # fmt: skip
    camcli.explore(TABLE.load(values)).save(tmp_path)
    data = data_of(tmp_path)
    cam = {key: np.asarray(value, float) for key, value in data["cam"].items()}
    assert np.abs(cam["c"] - TABLE.cam.lift(cam["theta_deg"])[0]).max() < 3e-6
    assert "right to" in data["measured"]
    outline = data["outline"]
    phase = np.degrees(np.arctan2(outline["x"], outline["y"]))
    wanted = TABLE.base_radius + TABLE.cam.lift(phase)[0] / 1.5
    assert np.hypot(outline["x"], outline["y"]) == pytest.approx(wanted, abs=3e-6)
    assert outline["rise"] == pytest.approx(TABLE.base_radius, abs=3e-6)
    assert outline["ratio"] == 1.5


def colour_name(label):
    """The page's name of a motion's colour."""
    if not label.startswith("P("):
        return label
    if "inf" in label:
        return "rests"
    period = int(label[2:].partition(";")[0])
    return f"period{period}" if period <= 4 else "longer"


def period_of(label):
    return int(label[2:].partition(";")[0]) if label.startswith("P(") else 0


EVENTS = ("flight", "sticking", "impact", "chatter", "detachment")
MOTIONS = (
    "period1", "period2", "period3", "period4", "longer", "aperiodic", "undecided",
)  # fmt: skip
# so that they show on white, and are as far apart as in pictures
DARKER = {"sticking", "detachment", "period2", "period3", "longer", "undecided"}


def test_the_colours_of_the_page_mean_what_they_mean_in_pictures(page):
    _, _, text = page
    root = text.partition(":root {")[2].partition("}")[0]
    shown = dict(re.findall(r"--([a-z]+\d?): (#[0-9A-Fa-f]{6});", root))
    names = (*EVENTS, *MOTIONS, "cam", "body")
    in_pictures = {name: COLOURS[re.sub(r"period(\d)", r"period \1", name)] for name in names}
    alike = {name for name, colour in in_pictures.items() if shown[name].upper() == colour}
    assert {*in_pictures} - alike == DARKER
    assert shown["force"].upper() == FORCES[2]
    for name in DARKER:
        group = EVENTS if name in EVENTS else MOTIONS
        place = seen(shown[name], "all cones")
        away = {o: np.linalg.norm(place - seen(in_pictures[o], "all cones")) for o in group}
        assert min(away, key=away.__getitem__) == name


def motions_of(data):
    """Every motion with its rows, events and points."""
    event = point = strobe = 0
    for number, motion in enumerate(data["motions"]):
        rows = rows_of(data, number)
        events = {k: v[event : event + motion["events"]] for k, v in data["events"].items()}
        some = slice(point, point + motion["impacts"])
        impacts = {key: data["points"][key][some] for key in ("theta_deg", "u")}
        strobes = {k: data["points"][k][strobe : strobe + motion["strobes"]] for k in ("q", "v")}
        event, point, strobe = (
            event + motion["events"], point + motion["impacts"], strobe + motion["strobes"],
        )  # fmt: skip
        yield motion, rows, events, impacts, strobes
    assert [len(data["events"]["t"]), len(data["points"]["u"]), len(data["points"]["q"])] == [
        event, point, strobe,
    ]  # fmt: skip


def test_every_motion_is_that_of_a_sweep_of_a_start_of_the_map_or_of_an_orbit(page):
    name, data, _ = page
    seen = set()
    for motion, _, _, impacts, strobes in motions_of(data):
        assert {*motion} == {
            "rpm", "label", "symbols", "colour", "origin", "q", "v", "turns", "loops", "period",
            "stable", "exponent", "place", "sets", "rows", "events", "impacts", "strobes",
        }  # fmt: skip
        if motion["origin"] == "stop":
            continue  # tests/output/test_explore_stops.py
        label, period = motion["label"], period_of(motion["label"])
        assert motion["period"] == period
        assert motion["colour"] == colour_name(label)
        told = label[:-1].partition(";")[2].split(":") if period else []
        symbols = [float(s) for s in motion["symbols"]]
        assert symbols == [float(s) for s in told]
        assert motion["loops"] == (0 < period == motion["turns"])
        seen.add(motion["origin"])
        CHECKS[motion["origin"]](name, motion, impacts, strobes)
    solved_where_no_sweep_leads(name, data)
    assert seen >= {"fixed", "solved"}
    assert (seen >= {"start", "map"}) == (name == "valve")


def solved_where_no_sweep_leads(name, data):
    """One orbit of a branch per step of the speeds, near every row that is unstable."""
    table, span = part(name, "orbits").tables["branch"], CASES[name][1]["sweep.rpm"]
    step = (span["stop"] - span["start"]) / (span["num"] - 1)
    solved = [m for m in data["motions"] if m["origin"] == "solved"]
    for number in set(table["branch"]):
        for stable in (True, False):
            own = table["q_m"][table["branch"] == number]
            rpms = [m["rpm"] for m in solved if m["q"] in own and m["stable"] is stable]
            assert np.abs(np.diff(rpms)).min(initial=np.inf) >= step
    for k in np.flatnonzero(table["stable"] == 0):
        own = table["branch"] == table["branch"][k]
        assert any(
            m["stable"] is False and abs(m["rpm"] - table["rpm"][k]) <= 1.01 * step
            and m["q"] in table["q_m"][own]
            for m in solved
        ), (table["label"][k], table["rpm"][k])  # fmt: skip


def of_sweep(name, motion, impacts, strobes):
    result = part(name, "sweep", sweep__direction=motion["origin"])
    speeds, table, states = (result.tables[t] for t in ("speeds", "impacts", "strobe"))
    (row,) = np.flatnonzero(speeds["rpm"] == motion["rpm"])
    assert motion["label"] == speeds["label"][row]
    exponent = speeds["lyapunov_per_period"][row]
    told = motion["exponent"]
    assert (np.nan if told is None else float(told)) == pytest.approx(exponent, nan_ok=True)
    assert motion["stable"] is (True if motion["period"] else None)
    own = states["rpm"] == motion["rpm"]
    q, v = states["q_m"][own], states["v_m_per_s"][own]
    turns = motion["turns"]
    assert turns == (motion["period"] or min(16, len(q)))
    shown = motion["period"] or len(q)
    assert close(strobes["q"], q[-shown:])
    assert close(strobes["v"], v[-shown:])
    own = (table["rpm"] == motion["rpm"]) & (table["period"] >= len(q) - shown)
    assert close(impacts["theta_deg"], table["theta_deg"][own])
    assert close(impacts["u"], table["u_minus_m_per_s"][own])
    if motion["q"] is not None:
        assert (motion["q"], motion["v"]) == (q[-turns], v[-turns])


def of_orbit(name, motion, impacts, strobes):
    table = part(name, "orbits").tables["branch"]
    rows = np.flatnonzero((table["rpm"] == motion["rpm"]) & (table["label"] == motion["label"]))
    row = min(rows, key=lambda k: abs(table["q_m"][k] - motion["q"]))
    assert motion["q"] == pytest.approx(table["q_m"][row])
    assert motion["v"] == pytest.approx(table["v_m_per_s"][row])
    assert motion["stable"] == bool(table["stable"][row])
    assert motion["exponent"] is None
    assert len(impacts["u"]) == 0
    assert close(strobes["q"], [motion["q"]])
    assert close(strobes["v"], [motion["v"]])
    assert motion["turns"] == motion["period"]


def of_start(name, motion, *_):
    tables = part(name, "basins").tables
    cells, attractors = tables["basins"], tables["attractors"]
    q, v = motion["place"]
    assert (motion["q"], motion["v"]) == (q, v)
    (cell,) = np.flatnonzero((cells["q_m"] == q) & (cells["v_m_per_s"] == v))
    number = cells["attractor"][cell]
    (row,) = np.flatnonzero(attractors["attractor"] == number)
    assert motion["label"] == attractors["label"][row]
    assert motion["rpm"] == 6500.0


@cache
def mapped(name):
    machine, values = CASES[name]
    span = values["sweep.rpm"]
    axes = [{"key": "rpm", **span}, values["sweep.vary"][0]]
    return camcli.sweep(machine.load({**values, "sweep.vary": axes})).tables["map"]


def of_map(name, motion, *_):
    table = mapped(name)
    rpm, damping = motion["place"]
    (row,) = np.flatnonzero((table["rpm"] == rpm) & (table["follower.damping"] == damping))
    assert motion["label"] == table["label"][row]
    assert motion["rpm"] == rpm
    assert motion["sets"] == {"follower.damping": damping}


CHECKS = {
    "fixed": of_sweep, "up": of_sweep, "down": of_sweep, "solved": of_orbit, "start": of_start,
    "map": of_map,
}  # fmt: skip


def test_rows_and_events_of_a_motion_are_those_of_a_simulation_from_its_start(page):
    name, data, _ = page
    machine, values = CASES[name]
    every = list(motions_of(data))
    for motion, rows, events, *_ in every[:: max(1, len(every) // 12)]:
        start = {"q": motion["q"], "v": motion["v"], "theta_deg": data["strobe_deg"]}
        more = {
            "run.rpm": motion["rpm"], "run.start": start, "run.transient": 0,
            "run.record": motion["turns"] + 1, "simulate.samples": 720, **motion["sets"],
        }  # fmt: skip
        values = {key: value for key, value in values.items() if key.startswith("run")}
        tables = camcli.simulate(machine.load({**values, **more})).tables
        wanted, happened = tables["trajectory"], tables["events"]
        per_s = motion["rpm"] / 60.0
        t = happened["t_s"] * per_s
        seen = t <= motion["turns"]
        assert close(events["t"], t[seen])
        assert [KINDS[k] for k in events["kind"]] == list(happened["event"][seen])
        assert close(events["u"], happened["u_minus_m_per_s"][seen])
        assert rows["t"][0] == 0.0
        assert rows["t"][-1] == pytest.approx(motion["turns"])
        size = np.ptp(wanted["q_m"])
        q = np.interp(rows["t"], wanted["t_s"] * per_s, wanted["q_m"])
        assert np.abs(rows["q"] - q).max() < 2e-4 * size
        t = wanted["t_s"] * per_s
        here = t < motion["turns"]
        drawn = shown(rows, motion["rpm"], t[here], wanted["c_m"][here])  # the cubics of the page
        assert np.abs(drawn - wanted["q_m"][here]).max() < size / 2000
        rest = wanted["contact"] == "sticking"
        inner = rest[1:-1] & rest[:-2] & rest[2:]
        t = (wanted["t_s"] * per_s)[1:-1]
        for at in t[inner & (t < motion["turns"])][::7]:
            k = np.searchsorted(rows["t"], at, side="right") - 1
            assert rows["rest"][k]
        if not rest.any():
            assert not rows["rest"].any()
        v = np.interp(rows["t"], wanted["t_s"] * per_s, wanted["v_m_per_s"])
        every_t = [0.0, *(happened["t_s"] * per_s)]  # where the velocity jumps
        clear = np.min([np.abs(rows["t"] - at) for at in every_t], axis=0) > 0.01
        assert np.abs(rows["v"] - v)[clear].max(initial=0.0) < 0.02 * np.ptp(wanted["v_m_per_s"])


def test_branches_and_bifurcations_are_those_of_the_tables(page):
    name, data, _ = page
    table, events = (part(name, "orbits").tables[t] for t in ("branch", "bifurcations"))
    theta = [c for c in table if c.startswith("theta_deg_")]
    rates = [c for c in table if c.startswith("u_minus")]
    numbers = list(dict.fromkeys(table["branch"]))
    assert len(data["branches"]) == len(numbers)
    for number, branch in zip(numbers, data["branches"], strict=True):
        own = table["branch"] == number
        assert {*branch} == {"rpm", "stable", "label", "colour", "q", "v", "theta_deg", "u"}
        assert branch["rpm"] == list(table["rpm"][own])
        assert list(branch["stable"]) == list(table["stable"][own])
        assert branch["label"] == list(table["label"][own])
        assert branch["colour"] == colour_name(table["label"][own][0])
        assert close(branch["q"][0], table["q_m"][own])
        assert close(branch["v"][0], table["v_m_per_s"][own])
        for k, (angle, rate) in enumerate(zip(theta, rates, strict=True)):
            impact = np.isfinite(table[rate][own])
            assert close(branch["u"][k], table[rate][own])
            assert close(branch["theta_deg"][k], np.where(impact, table[angle][own], np.nan))
    shared = {}
    for k in range(len(events["rpm"])):
        key = events["kind"][k], events["label"][k], f"{events['rpm'][k]:.10g}"
        shared.setdefault(key, k)
    assert len(data["bifurcations"]) == len(shared)
    rpms = [event["rpm"] for event in data["bifurcations"]]
    assert rpms == sorted(rpms)
    for event in data["bifurcations"]:
        k = shared[event["kind"], event["label"], f"{event['rpm']:.10g}"]
        for key in ("corner", "classification"):
            assert event[key] == events[key][k]
        assert event["rpm"] == pytest.approx(events["rpm"][k], rel=1e-14)
        assert event["rpm_error"] == pytest.approx(events["rpm_error"][k])
        own = table["branch"] == events["branch"][k]
        near = np.flatnonzero(own)[np.argmin(np.abs(table["rpm"][own] - event["rpm"]))]
        assert table["rpm"][near] == pytest.approx(event["rpm"], rel=1e-6)
        at = np.array([table[c][near] for c in theta])
        u = np.array([table[c][near] for c in rates])
        impact = np.isfinite(u)
        assert sorted(event["theta_deg"]) == pytest.approx(sorted(at[impact]), abs=0.5)
        assert sorted(event["u"]) == pytest.approx(sorted(u[impact]), rel=0.05)
        assert event["q"] == pytest.approx([table["q_m"][near]], rel=1e-3)
        assert event["v"] == pytest.approx([table["v_m_per_s"][near]], rel=1e-2)
        if event["corner"]:
            assert any(event["classification"] in words for words in event["words"])


def test_planes_show_the_cells_of_basins_and_of_the_map(page):
    name, data, _ = page
    if name != "valve":
        assert data["planes"] == []
        return
    basins, chart = data["planes"]
    _, values = CASES[name]
    tables = part(name, "basins").tables
    attractors, cells = tables["attractors"], tables["basins"]
    assert basins["cells"] == values["basins.cells"]
    assert (basins["x"], basins["y"]) == (values["basins.q"], values["basins.v"])
    assert basins["names"] == ["position q at the strobe (m)", "velocity v at the strobe (m/s)"]
    assert basins["labels"] == list(attractors["label"])
    assert basins["colours"] == [colour_name(label) for label in attractors["label"]]
    wide, high = basins["cells"]
    codes = np.reshape(basins["codes"], (high, wide))
    for q, v, number in zip(cells["q_m"], cells["v_m_per_s"], cells["attractor"], strict=True):
        column = int((q - basins["x"][0]) / (basins["x"][1] - basins["x"][0]) * wide)
        row = int((v - basins["y"][0]) / (basins["y"][1] - basins["y"][0]) * high)
        code = codes[row, column]
        assert (code == 255) == (number == -1)
        if code != 255:
            assert attractors["attractor"][code] == number
    for label, fraction in zip(attractors["label"], attractors["fraction"], strict=True):
        assert f"{label} takes {100.0 * fraction:.3g} %" in basins["words"]
    table = mapped(name)
    x, y = np.unique(table["rpm"]), np.unique(table["follower.damping"])
    assert chart["cells"] == [len(x), len(y)]
    for ends, values in ((chart["x"], x), (chart["y"], y)):
        half = 0.5 * (values[1] - values[0])
        assert ends == pytest.approx((values[0] - half, values[-1] + half))
    assert chart["names"] == ["cam speed (rpm)", "damping (N s/m)"]
    codes = np.reshape(chart["codes"], (len(y), len(x)))
    for rpm, damping, label in zip(
        table["rpm"], table["follower.damping"], table["label"], strict=True
    ):
        code = codes[np.searchsorted(y, damping), np.searchsorted(x, rpm)]
        kind = f"period {period_of(label)}" if period_of(label) else label
        kind = "with rests" if "inf" in label else kind
        assert chart["labels"][code] == kind
        assert chart["colours"][code] == colour_name(label)
