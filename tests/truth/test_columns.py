"""Every column of every table against a value computed another way.

One machine that leaves all defaults: damping, gravity, preload, a cam below zero, a strobe on its
slope. What its tables should hold comes from `Motion` and `Machine`, closed forms in code of their
own. A table or a column without a check here is a failure: who adds one brings its check.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.optimize import minimize_scalar

import camcli
from tests.support.loads import loads
from tests.support.mechanics import RAD, TURN, Machine
from tests.support.motion import Event, Motion
from tests.support.orbits import event as exact_event
from tests.support.orbits import multipliers

pytestmark = pytest.mark.slow
SCENE = {
    "follower": {"mass": 0.35, "stiffness": 5200.0, "damping": 6.0, "gravity": 9.81,
                 "preload": 60.0, "restitution": 0.6},
    "cam": {"kind": "law", "base": -0.004, "lift": 0.012,
            "rise": {"start_deg": 40.0, "length_deg": 75.0, "law": "harmonic"},
            "top_dwell_deg": 25.0, "fall": {"length_deg": 65.0, "law": "3-4-5"}},
    "run": {"strobe_deg": 77.0, "transient": 6, "record": 4, "chatter_tolerance": 1e-13},
}  # fmt: skip
SAMPLES = 24
LOADS = (
    "max_gap_m", "airborne_fraction", "max_impact_m_per_s", "min_contact_force_n",
    "max_contact_force_n", "contact_lost_deg", "contact_regained_deg", "landing_deg",
    "landing_lift_m", "shut_bounces_per_turn",
)  # fmt: skip
CLOSE = 1e-9  # relative: of values, and of the largest of a column


class Near:
    """Numbers with the error that each may have."""

    def __init__(self, values, error):
        self.values, self.error = np.asarray(values, float), error


Wanted = Mapping[str, Any]  # by column: values, `Near`, or a function that asserts
Tables = Mapping[str, Wanted]


def compare(table: Mapping, wanted: Wanted, name: str = "") -> None:
    """Each column of a table against what it should hold, and none without a check."""
    missing = [column for column in table if column not in wanted]
    assert not missing, f"{name}: no independent value of {', '.join(missing)}"
    gone = [column for column in wanted if column not in table]
    assert not gone, f"{name}: no column {', '.join(gone)}"
    for column, values in wanted.items():
        where = f"{name}.{column}"
        if callable(values):
            values(table[column])
            continue
        own = values.values if isinstance(values, Near) else np.asarray(values)
        found = np.asarray(table[column])
        assert len(found) == len(own), (where, len(found), len(own))
        if found.dtype.kind == "U" and own.dtype.kind == "f":  # a text that nothing is said in
            assert np.isnan(own).all(), where
            own = np.full(len(own), "")
        if own.dtype.kind in "UOb" or found.dtype.kind == "U":
            assert found.tolist() == own.tolist(), where
            continue
        size = np.max(np.abs(own[np.isfinite(own)]), initial=0.0)
        error = values.error if isinstance(values, Near) else CLOSE * (np.abs(own) + 1e-3 * size)
        np.testing.assert_array_equal(np.isfinite(found), np.isfinite(own), where)
        known = np.isfinite(own)
        np.testing.assert_array_equal(found[~known & ~np.isnan(own)], own[~known & ~np.isnan(own)])
        with np.errstate(invalid="ignore"):  # infinities that are equal
            off = known & (np.abs(found - own) > error)
        assert not off.any(), (where, found[off][:3], own[off][:3])


def columns_of(table: Mapping, rows: Sequence[Sequence]) -> Wanted:
    """Rows as columns, by the names of a table that has as many."""
    assert rows
    columns = zip(*rows, strict=True)
    return dict(zip(table, map(np.array, columns), strict=True))


def compare_all(result: Any, wanted: Tables) -> None:
    """Every table of a result, and none without a check."""
    assert set(result.tables) == set(wanted)
    for name, columns in wanted.items():
        compare(result.tables[name], columns, name)


def same(found: Any, wanted: Any, where: str = "result", close: float = 1e-7) -> None:
    """Every field of a record against what it should hold, and none without a check."""
    if callable(wanted):
        assert wanted(found), (where, found)
    elif isinstance(wanted, dict):
        assert sorted(found) == sorted(wanted), where
        for key, value in wanted.items():
            same(found[key], value, f"{where}.{key}", close)
    elif isinstance(wanted, list | tuple):
        assert len(found) == len(wanted), (where, found, wanted)
        for k, (one, other) in enumerate(zip(found, wanted, strict=True)):
            same(one, other, f"{where}[{k}]", close)
    elif isinstance(wanted, bool | str | None):
        assert found == wanted, (where, found, wanted)
    else:
        assert found == pytest.approx(float(wanted), rel=close, abs=1e-12), (where, found, wanted)


def scene_at(rpm: float, **changes: Any) -> dict[str, Any]:
    """The machine at a speed; sections are merged."""
    scene = {key: dict(value) for key, value in SCENE.items()}
    scene["run"]["rpm"] = rpm
    for key, value in changes.items():
        scene[key] = {**scene.get(key, {}), **value}
    return scene


# -- one motion -------------------------------------------------------------------------------


def motion_of(scene: dict[str, Any], **start: Any) -> Motion:
    """The motion of a scene, over its transient and record."""
    run = scene["run"]
    return Motion(Machine.of(scene), run["transient"] + run["record"], **start)


def matched(own: Sequence[Event], theta_deg: np.ndarray, kinds: np.ndarray) -> list[Event]:
    """The events behind the rows of a table, in their order.

    Only the last impacts before a chatter may be without a row: its map closes them.
    """
    found, left = [], list(own)
    for theta, kind in zip(theta_deg, kinds, strict=True):
        while left[0].kind != kind or abs(left[0].theta / RAD - theta) > 1e-6:
            chatter = next(event for event in left if event.kind != "impact")
            assert left[0].kind == "impact"
            assert chatter.kind == "chatter"
            assert chatter.at - left[0].at < 1e-2
            left.pop(0)
        found.append(left.pop(0))
    assert not [event for event in left if event.kind != "impact"]
    assert len(left) < 60
    return found


def simulated(scene: dict[str, Any], result: Any) -> Tables:
    """Of `simulate`: the events of the record, and the state at its samples and events."""
    motion, run = motion_of(scene), scene["run"]
    begin, omega = TURN * run["transient"], motion.machine.omega
    table = result.tables["events"]
    own = [event for event in motion.events if event.at >= begin]
    events = matched(own, table["theta_deg"], table["event"])
    at = np.array([event.at for event in events]) - begin
    samples = TURN * np.arange(run["record"] * scene["simulate"]["samples"])
    rows = [(x, False) for x in samples / scene["simulate"]["samples"]]
    for x, event in zip(at, events, strict=True):
        rows += [(x, True), (x, False)] if event.kind == "impact" else [(x, False)]
    rows.sort(key=lambda row: (row[0], not row[1]))
    psi = np.array([x for x, _ in rows])
    q, v, rests = zip(*(motion.state(x + begin, before) for x, before in rows), strict=True)
    c, c1, _ = motion.machine.cam(motion.machine.strobe + psi)
    return {
        "events": {
            "t_s": at / omega,
            "period": np.floor(at / TURN),
            "theta_deg": [event.theta / RAD for event in events],
            "event": [event.kind for event in events],
            "q_m": [event.q for event in events],
            "u_minus_m_per_s": [event.u_minus for event in events],
            "u_plus_m_per_s": [event.u_plus for event in events],
        },
        "trajectory": {
            "t_s": psi / omega,
            "theta_deg": [motion.machine.phase_deg(x) for x in psi],
            "q_m": Near(q, 1e-11),
            "v_m_per_s": Near(v, 1e-7),
            "c_m": c,
            "c_dot_m_per_s": c1,
            "contact": [
                "sticking" if rest and not before else "flight"
                for rest, (_, before) in zip(rests, rows, strict=True)
            ],
        },
    }


@pytest.mark.parametrize("rpm", [650.0, 900.0, 1500.0, 2700.0])
def test_simulate(rpm):
    scene = scene_at(rpm, simulate={"samples": 36})
    result = camcli.simulate(camcli.load_scene(scene))
    compare_all(result, simulated(scene, result))


def test_simulate_inside_a_chatter_that_its_map_closes():
    """Samples of hops that have no rows of their own: their flights, a little off in phase."""
    run = {"transient": 3, "record": 1, "chatter_tolerance": 1e-5}
    scene = scene_at(900.0, run=run, simulate={"samples": 20_000})
    result = camcli.simulate(camcli.load_scene(scene))
    motion, events = motion_of(scene), result.tables["events"]
    rows, seen = result.tables["trajectory"], 0
    for k in np.flatnonzero(events["event"] == "chatter"):
        begin, end = events["t_s"][k - 1 : k + 1]
        inside = (rows["t_s"] > begin) & (rows["t_s"] < end)
        at = rows["t_s"][inside] * motion.machine.omega + TURN * 3
        own = np.array([motion.state(x)[:2] for x in at])
        up = events["u_plus_m_per_s"][k - 1]
        off = np.abs(rows["v_m_per_s"][inside] - own[:, 1])
        assert np.median(off) < 0.01 * up
        assert np.abs(rows["q_m"][inside] - own[:, 0]).max() < 0.01 * up * (end - begin)
        seen += inside.sum()
    assert seen > 40


@pytest.mark.parametrize("strobe_deg", [0.0, 100.0, 200.0, 300.0])
def test_a_motion_that_is_cut_ends_with_its_last_event(strobe_deg):
    """Too many impacts in a turn: its rows are those of the whole motion, and no more."""
    run = {"transient": 5, "record": 60, "strobe_deg": strobe_deg}
    scene = {"run.rpm": 660.0, "simulate.samples": 24}
    whole, cut = (
        camcli.simulate(camcli.load_scene(None, {**scene, **values}))
        for values in ({f"run.{key}": value for key, value in {**run, **more}.items()}
                       for more in ({}, {"impact_budget": 3}))
    )  # fmt: skip
    assert cut.summary["status"] != "ok"
    assert cut.summary["periods"] == cut.tables["events"]["period"][-1] > 2
    for name in ("events", "trajectory"):
        found, all_rows = cut.tables[name], whole.tables[name]
        assert 0 < found.rows < all_rows.rows
        for column in found:
            assert found[column].tolist() == all_rows[column][: found.rows].tolist()
    assert cut.tables["trajectory"]["t_s"][-1] == cut.tables["events"]["t_s"][-1]


# -- the cam ----------------------------------------------------------------------------------


def profile_of(scene: dict[str, Any], cam: dict[str, Any]) -> Wanted:
    """Of `simulate --profile-only`: equal steps, and every end of a part from both sides."""
    machine = Machine.of({**scene, "cam": cam})
    rows = [(x, 1) for x in TURN * np.arange(scene["simulate"]["samples"] + 1) / SAMPLES]
    for x in machine.lift.edges[1:-1]:
        rows = [row for row in rows if abs(row[0] - x) > 1e-9] + [(x, -1), (x, 1)]
    rows.sort()
    values = np.array([np.append(machine.lift.at(x, side)[:, 0], machine.force(x, side))
                       for x, side in rows])  # fmt: skip
    names = "c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2", "force_n"
    columns = dict(zip(names, values.T, strict=True))
    jerk = np.array([jerk_of(machine.lift, x, side) for x, side in rows])
    columns["c_thetathetatheta_m_per_rad3"] = jerk
    orders = [values[:, 0] - machine.lift.range[0], *values[:, 1:3].T, jerk]
    names = "lift_mm", "velocity_mm_per_deg", "acceleration_mm_per_deg2", "jerk_mm_per_deg3"
    for order, (name, column) in enumerate(zip(names, orders, strict=True)):
        columns[name] = 1000.0 * column / 57.29577951308232**order
    return {"theta_deg": [x / RAD for x, _ in rows], **columns}


def jerk_of(lift: Any, theta: float, side: int) -> float:
    """The third derivative on one side of a phase (rad): mpmath's of the second."""
    at_end = abs(theta - TURN) < 1e-9
    k = int(np.searchsorted(lift.edges, theta - 1e-9 if side < 0 or at_end else theta + 1e-9)) - 1
    with mp.workdps(40):
        return float(mp.diff(lambda x: lift.parts[k](x, mp)[2], mp.mpf(theta)))


def test_profiles():
    beside = [
        {"kind": "eccentric", "base": -0.01, "lift": 0.02},
        {**SCENE["cam"], "base": -0.007, "rise": {**SCENE["cam"]["rise"], "start_deg": 301.5}},
    ]
    scene = scene_at(900.0, simulate={"samples": SAMPLES, "beside": beside})
    result = camcli.simulate(camcli.load_scene(scene), profile_only=True, base_radius=0.03)
    cams = {"profile": SCENE["cam"], "profile_2": beside[0], "profile_3": beside[1]}
    compare_all(result, {name: profile_of(scene, cam) for name, cam in cams.items()})


# -- motions over a range ---------------------------------------------------------------------


def label_of(motion: Motion, begin: int, turns: int) -> str:
    """P(m;s1:...:sm) from the last turns of a motion, `undecided` where none of its states repeat.

    A motion that never leaves the cam is `contact`.
    """
    if not any(event.at >= TURN * begin for event in motion.events):
        return "contact"
    ends = range(begin, begin + turns)
    states = np.array([motion.state(TURN * n)[:2] for n in ends])
    inside = [[e for e in motion.events if TURN * n <= e.at < TURN * (n + 1)] for n in ends]
    symbols = [
        np.inf if any(e.kind == "chatter" for e in own) else sum(e.kind == "impact" for e in own)
        for own in inside
    ]
    size = np.abs(states).max(0)
    for m in range(1, turns // 2 + 1):
        close = (np.abs(states[m:] - states[:-m]) < 1e-5 * size).all()
        if close and symbols[m:] == symbols[:-m]:
            best = max(tuple(symbols[k : k + m]) for k in range(m))
            return f"P({m};{':'.join('inf' if x == np.inf else str(x) for x in best)})"
    return "undecided"


def multipliers_of(motion: Motion, begin: int, turns: int) -> np.ndarray:
    """Of the map over so many turns from a strobe, by central differences; zero after a rest."""
    machine, (q, v, _) = motion.machine, motion.state(TURN * begin)
    inside = [e for e in motion.events if TURN * begin <= e.at < TURN * (begin + turns)]
    if not inside or any(event.kind == "chatter" for event in inside):
        return np.zeros(2)
    size, columns = np.ptp(machine.lift.range), []
    for dq, dv in ((1e-6 * size, 0.0), (0.0, 1e-6 * size * machine.omega)):
        ends = [
            Motion(machine, turns, machine.strobe / RAD, q + side * dq, v + side * dv).state(
                TURN * turns
            )[:2]
            for side in (-1, 1)
        ]
        columns.append((np.array(ends[1]) - ends[0]) / (2 * (dq + dv)))
    return np.linalg.eigvals(np.array(columns).T)


def exponent_of(motion: Motion, begin: int, label: str) -> float:
    """The largest per turn; nan where the motion is not named."""
    if label == "contact":
        return -np.inf
    if not label.startswith("P("):
        return np.nan
    turns = int(label[2 : label.index(";")])
    largest = np.abs(multipliers_of(motion, begin, turns)).max()
    return np.log(largest) / turns if largest > 0.0 else -np.inf


class Record:
    """What a sweep should hold of one speed: its motion from a start, or from a state."""

    def __init__(self, scene: dict[str, Any], rpm: float, **start: Any):
        run = scene["run"]
        self.scene = {**scene, "run": {**run, "rpm": rpm}}
        self.begin, self.turns = run["transient"], run["record"]
        self.motion = motion_of(self.scene, **start)
        self.machine, self.rpm = self.motion.machine, rpm
        self.label = label_of(self.motion, self.begin, self.turns)

    def states(self) -> np.ndarray:
        """(turns, 2): q and v where each recorded turn begins."""
        ends = range(self.begin, self.begin + self.turns)
        return np.array([self.motion.state(TURN * n)[:2] for n in ends])

    def end(self) -> dict[str, float]:
        """Where the next speed of a sweep that carries its state begins."""
        q, v, rests = self.motion.state(TURN * (self.begin + self.turns))
        return {} if rests else {"q": q, "v": v}

    def impacts(self, table: Mapping, rows: np.ndarray) -> list[Event]:
        """The events behind some rows of impacts; soft ones before a chatter have none."""
        own = [event for event in self.motion.events if event.at >= TURN * self.begin]
        chatters = [event for event in own if event.kind == "chatter"]
        theta = table["theta_deg"][rows]
        found, left = [], [event for event in own if event.kind == "impact"]
        for x in theta:
            while abs(left[0].theta / RAD - x) > 1e-6:
                end = next(event for event in chatters if event.at >= left[0].at)
                assert end.at - left.pop(0).at < 1e-2
            found.append(left.pop(0))
        assert all(any(0 <= end.at - e.at < 1e-2 for end in chatters) for e in left)
        return found

    def period(self, event: Event) -> int:
        return int(event.at // TURN) - self.begin

    def loads(self) -> dict[str, float]:
        events = [event for event in self.motion.events if event.at >= TURN * self.begin]
        columns = {
            "event": np.array([event.kind for event in events], dtype="U10"),
            "period": np.array([self.period(event) for event in events], dtype=int),
            "theta_deg": np.array([event.theta / RAD for event in events]),
            "u_minus_m_per_s": np.array([event.u_minus for event in events]),
            "u_plus_m_per_s": np.array([event.u_plus for event in events]),
        }
        q, v, _ = self.motion.state(TURN * self.begin)
        return loads(self.machine, columns, q, v, self.turns)


def of_sweep(
    records: Sequence[tuple[Record, dict[str, Any]]], tables: Any, lyapunov: bool
) -> Tables:
    """impacts.csv, strobe.csv and speeds.csv; each record with its columns at the end."""
    impacts, strobe, speeds = [], [], []
    for record, way in records:
        rows = np.ones(tables["impacts"].rows, bool)
        for name, value in {"rpm": record.rpm, **way}.items():
            rows &= tables["impacts"][name] == value
        own = record.impacts(tables["impacts"], rows)
        impacts += [
            (record.rpm, record.period(e), e.theta / RAD, e.q, e.u_minus, *way.values())
            for e in own
        ]
        turns, events = [record.period(event) for event in own], record.motion.events
        chatters = [record.period(event) for event in events if event.kind == "chatter"]
        strobe += [
            (record.rpm, n, q, v, turns.count(n), int(n in chatters), *way.values())
            for n, (q, v) in enumerate(record.states())
        ]
        exponent = exponent_of(record.motion, record.begin, record.label) if lyapunov else np.nan
        named = record.label, len(own), exponent, "ok"
        error = 0.0 if lyapunov else np.nan  # each motion is a solved orbit, or rests
        loads = record.loads().values()
        speeds.append((record.rpm, *named, *loads, "", "", error, *way.values()))
    ways = list(records[0][1])
    heads = {
        "impacts": ["rpm", "period", "theta_deg", "q_m", "u_minus_m_per_s", *ways],
        "strobe": ["rpm", "period", "q_m", "v_m_per_s", "impacts", "chatter", *ways],
        "speeds": ["rpm", "label", "impacts", "lyapunov_per_period", "status", *LOADS,
                   "holds_for", "watched_turns", "lyapunov_error_per_period", *ways],
    }  # fmt: skip
    found = {
        name: dict(zip(heads[name], map(np.array, zip(*rows, strict=True)), strict=True))
        for name, rows in {"impacts": impacts, "strobe": strobe, "speeds": speeds}.items()
    }
    for name in ("holds_for", "watched_turns"):  # none is decided in balls, none looks aperiodic
        found["speeds"][name] = np.full(len(speeds), np.nan)
    exponents = found["speeds"]["lyapunov_per_period"]
    found["speeds"]["lyapunov_per_period"] = Near(exponents, 1e-6)
    return found


@pytest.mark.ci
def test_sweep_of_motions_from_rest():
    """Contact held and lost, one chatter in a turn and two."""
    scene = scene_at(900.0, sweep={"rpm": {"start": 640.0, "stop": 970.0, "num": 4}})
    result = camcli.sweep(camcli.load_scene(scene))
    records = [(Record(scene, rpm), {}) for rpm in (640.0, 750.0, 860.0, 970.0)]
    compare_all(result, of_sweep(records, result.tables, lyapunov=False))


def test_sweep_of_one_row_at_each_speed():
    run = {"transient": 30, "record": 1}
    scene = scene_at(900.0, run=run, sweep={"rpm": {"start": 2700.0, "stop": 2900.0, "num": 2}})
    result = camcli.sweep(camcli.load_scene(scene))
    records = [Record(scene, rpm) for rpm in (2700.0, 2900.0)]
    own = [
        (record, [e for e in record.motion.events if record.period(e) == 0]) for record in records
    ]
    assert [len(events) for _, events in own] == [1, 1]
    rows = [(record.rpm, 0, e.theta / RAD, e.q, e.u_minus) for record, (e,) in own]
    compare(result.tables["impacts"], columns_of(result.tables["impacts"], rows), "impacts")
    rows = [(record.rpm, 0, *record.states()[0], 1, 0) for record, _ in own]
    compare(result.tables["strobe"], columns_of(result.tables["strobe"], rows), "strobe")


@pytest.mark.ci
def test_sweep_that_carries_its_state_from_two_starts():
    run = {"transient": 30, "record": 8}
    second = {"q": 0.02, "v": 1.0, "theta_deg": 30.0}
    range_ = {"start": 2700.0, "stop": 2900.0, "num": 2}
    sweep = {"rpm": range_, "direction": "both", "lyapunov": True, "also": [second]}
    scene = scene_at(900.0, run=run, sweep=sweep)
    result = camcli.sweep(camcli.load_scene(scene))
    starts: list[dict[str, Any]] = [{}, {"begin_deg": 30.0, "q": 0.02, "v": 1.0}]
    records = []
    for number, start in enumerate(starts):
        for way, rpms in (("up", (2700.0, 2900.0)), ("down", (2900.0, 2700.0))):
            state = start
            for rpm in rpms:
                one = Record(scene, rpm, **state)
                records.append((one, {"direction": way, "start": number}))
                state = {"begin_deg": 77.0, **one.end()}
    assert {record.label for record, _ in records} == {"P(1;1)"}
    compare_all(result, of_sweep(records, result.tables, lyapunov=True))


def test_map():
    run = {"transient": 30, "record": 8}
    first = {"key": "rpm", "start": 2700.0, "stop": 2850.0, "num": 2}
    second = {"key": "follower.damping", "start": 4.0, "stop": 6.0, "num": 2}
    sweep = {"vary": [first, second], "lyapunov": True}
    result = camcli.sweep(camcli.load_scene(scene_at(900.0, run=run, sweep=sweep)))
    rows = []
    for damping in (4.0, 6.0):
        for rpm in (2700.0, 2850.0):
            own = Record(scene_at(900.0, run=run, follower={"damping": damping}), rpm)
            hits = [e for e in own.motion.events if own.period(e) >= 0 and e.kind == "impact"]
            exponent = exponent_of(own.motion, own.begin + own.turns - 1, own.label)
            named = own.label, int(own.label[2]), len(hits) / own.turns, exponent
            rows.append((rpm, damping, *named, *own.loads().values(), "ok", np.nan, np.nan, 0.0))
    names = ["rpm", "follower.damping", "label", "period", "impacts_per_turn",
             "lyapunov_per_period", *LOADS, "status", "holds_for", "watched_turns",
             "lyapunov_error_per_period"]  # fmt: skip
    columns = dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))
    columns["lyapunov_per_period"] = Near(columns["lyapunov_per_period"], 1e-4)
    compare_all(result, {"map": columns})


# -- loss of contact --------------------------------------------------------------------------

CONTACT = {"width": 0.012, "base_radius": 0.03, "follower_radius": 0.02, "modulus": 1e11}


def regions_of(machine: Machine) -> list[tuple[str, float, float]]:
    """(name, begin, end) between neighbouring corners, rad; the last one goes over 2 pi."""
    corners = machine.corners()
    ends = [*corners[1:], corners[0] + TURN]
    return [(f"A{k + 1}", a, b) for k, (a, b) in enumerate(zip(corners, ends, strict=True))]


def region_at(machine: Machine, theta: float) -> str:
    """The region that holds a phase (rad)."""
    return next(n for n, a, b in regions_of(machine) if a <= theta < b or theta < b - TURN)


def radius_of_contact(machine: Machine, theta: np.ndarray, side: int) -> np.ndarray:
    """Of cam and roller together: r (1 - kappa r), kappa of the pitch curve by its coordinates."""
    c, c1, c2 = machine.lift.at(theta, side)
    roller = CONTACT["follower_radius"]
    r = CONTACT["base_radius"] + roller + c - machine.lift.range[0]
    x1, y1 = c1 * np.cos(theta) - r * np.sin(theta), c1 * np.sin(theta) + r * np.cos(theta)
    x2 = (c2 - r) * np.cos(theta) - 2 * c1 * np.sin(theta)
    y2 = (c2 - r) * np.sin(theta) + 2 * c1 * np.cos(theta)
    return roller * (1.0 - roller * (x1 * y2 - y1 * x2) / np.hypot(x1, y1) ** 3)


def forces_of(machine: Machine, table: Mapping) -> Wanted:
    """Of force.csv, at its own phases; a boundary of a stretch has two rows, left side first."""
    theta = table["theta_deg"] * RAD
    again = np.r_[False, (theta[1:] == theta[:-1]) & (table["rpm"][1:] == table["rpm"][:-1])]
    force, pressure = np.empty(len(theta)), np.empty(len(theta))
    for side, rows in ((1, again | ~np.r_[again[1:], False]), (-1, np.r_[again[1:], False])):
        for rpm in np.unique(table["rpm"]):
            own = rows & (table["rpm"] == rpm)
            force[own] = replace(machine, rpm=rpm).force(theta[own], side)
            radius = radius_of_contact(machine, theta[own], side)
            load = np.maximum(force[own], 0.0) * CONTACT["modulus"]
            pressure[own] = np.sqrt(load / (np.pi * CONTACT["width"] * radius))
    return {"force_n": force, "pressure_pa": pressure}


CAUGHT = {
    "follower": {"mass": 1.221, "stiffness": 1430.8, "damping": 2.0, "gravity": 9.81,
                 "preload": 150.0, "restitution": 0.7},
    "cam": {"kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
            "nose_center": 0.40393320723821, "nose_radius": 0.15, "top_dwell_deg": 40.0,
            "offset": 0.45},
    "run": {"strobe_deg": 120.0, "chatter_tolerance": 1e-13, "rpm": 100.0},
}  # fmt: skip


def least_preload(machine: Machine, rpm: float, margin: float, per_preload: float = 0.0):
    """(least preload that leaves `margin` at every speed up to rpm, deciding phase and its side).

    per_preload: stiffness that each newton of preload brings; else the stiffness is as it is.
    """
    omega, stiffness = rpm * np.pi / 30, 0.0 if per_preload else machine.stiffness

    def wanted(theta, side: int = 1) -> np.ndarray:
        c, c1, c2 = machine.lift.at(theta, side)
        with np.errstate(divide="ignore", invalid="ignore"):  # a parabola in omega: ends, turning
            turn = np.nan_to_num(-machine.damping * c1 / (2 * machine.mass * c2))
        speeds = 0 * c, omega + 0 * c, np.clip(turn, 0.0, omega)
        moving = [machine.damping * x * c1 + machine.mass * x * x * c2 for x in speeds]
        still = machine.mass * machine.gravity + stiffness * c
        return (margin - np.min(moving, axis=0) - still) / (1.0 + per_preload * c)

    best = (-np.inf, 0.0, 1)
    for a, b in pairwise(machine.lift.edges):
        x = np.linspace(a, b, 1001)
        inner = wanted(x[1:-1])
        k = int(inner.argmax()) + 1
        found = minimize_scalar(
            lambda y: -wanted(y)[0], bounds=(x[k - 1] + 1e-9, x[k + 1] - 1e-9), method="bounded",
            options={"xatol": 1e-11},
        )  # fmt: skip
        ends = (wanted(a)[0], a, 1), (wanted(b, -1)[0], b, -1)
        best = max(best, (-found.fun, found.x, 1), *ends)
    return best


def critical_speeds(machine: Machine, detach: dict[str, Any]) -> dict[tuple[str, str], tuple]:
    """(phase in deg, rpm) of every row of detach.csv that has a closed form."""
    found: dict[tuple[str, str], tuple] = {}
    for name, a, b in regions_of(machine):
        for quantity, last in (("opens", False), ("fills", True)):
            rpm, theta = machine.loss(a, b, last)
            found[quantity, name] = theta / RAD if np.isfinite(rpm) else np.nan, rpm
    first = min((row for row in found.items() if row[0][0] == "opens"), key=lambda row: row[1][1])
    found["first_detachment", first[0][1]] = first[1]
    compressed = machine.preload / machine.stiffness
    for quantity, per_preload in (("hold_preload", 0.0), ("hold_both", 1.0 / compressed)):
        asked = detach["hold_to"], detach["margin_n"]
        preload, theta, side = least_preload(machine, *asked, per_preload)
        spring = {"preload": preload}
        if per_preload:
            spring["stiffness"] = preload * per_preload
        region = region_at(machine, theta + 1e-9 * side)
        found[quantity, region] = theta / RAD, replace(machine, **spring).loss()[0]
    return found


def burst_ends(scene: dict[str, Any], rpm: float) -> list[float]:
    """Phases (deg) at which the chatters of a turn end, in the order of where they begin."""
    own = {**scene, "run": {**scene["run"], "rpm": rpm, "transient": 0, "record": 2}}
    events = motion_of(own).events
    ends = {}
    for k, event in enumerate(events):
        if event.kind == "chatter" and event.at >= 0.0:
            begins = [e for e in events[:k] if e.kind == "detachment"]
            ends[round(begins[-1].theta / RAD, 6)] = event.theta / RAD
    return [ends[begin] for begin in sorted(ends)]


@pytest.mark.ci
@pytest.mark.parametrize(
    ("scene", "detach"),
    [
        (scene_at(900.0), {"rpm": {"start": 650.0, "stop": 1000.0, "num": 4},
                           "hold_to": 1500.0, "margin_n": 7.0}),
        (CAUGHT, {"rpm": {"start": 80.0, "stop": 160.0, "num": 5}, "hold_to": 200.0,
                  "margin_n": 0.0}),
    ],
    ids=["harmonic", "arcs"],
)  # fmt: skip
def test_detach(scene, detach):
    machine = Machine.of(scene)
    speeds = detach["rpm"]["start"], 130.0, 870.0
    asked = {**detach, "impacts": 3, "force_rpm": speeds}
    result = camcli.detach(camcli.load_scene({**scene, "detach": asked, "contact": CONTACT}))
    tables, known = result.tables, critical_speeds(machine, detach)

    def rows(name: str) -> list[tuple]:
        return list(zip(*(tables[name][column].tolist() for column in tables[name]), strict=True))

    # what has a closed form; ends of bursts on a corner are looked for by the motion there
    wanted = []
    for quantity, region, _, rpm, *_ in rows("detach"):
        if quantity in ("accumulation_at_corner", "completion_loss"):
            at, speed = machine.corners()["abcdef".index(region)] / RAD, rpm
            slower, faster = (burst_ends(scene, rpm + d) for d in (-1e-5, 1e-5))
            assert any(at - 1e-3 < end < at for end in slower)  # it reaches the corner,
            assert not any(at - 1e-3 < end < at for end in faster)  # and then passes it
        else:
            at, speed = known.pop((quantity, region))
        wanted.append((quantity, region, at, speed, speed * np.pi / 30))
    assert not known
    names = ("quantity", "region", "theta_deg", "rpm", "omega_rad_per_s")
    same = dict(zip(names, map(np.array, zip(*wanted, strict=True)), strict=True))
    same["theta_deg"] = Near(same["theta_deg"], 1e-5)  # of a minimum, which is flat
    own, (low, high) = same["rpm"], (tables["detach"][x] for x in ("rpm_low", "rpm_high"))
    finite = np.isfinite(own)  # a cam that is known exactly leaves brackets of rounding alone
    assert (low <= tables["detach"]["rpm"]).all()
    assert (tables["detach"]["rpm"] <= high).all()
    assert (low < high)[finite].all()
    same |= {"rpm_low": Near(own, 4e-12 * own), "rpm_high": Near(own, 4e-12 * own)}
    compare(tables["detach"], same, "detach")

    range_ = np.linspace(detach["rpm"]["start"], detach["rpm"]["stop"], detach["rpm"]["num"])
    ended = [(rpm, end) for rpm in range_ for end in burst_ends(scene, rpm)]
    compare(tables["accumulation"], columns_of(tables["accumulation"], ended), "accumulation")

    assert set(tables["corner_hits"]) == {"impact", "corner", "rpm"}
    for impact, corner, rpm in rows("corner_hits"):
        own = {**scene, "run": {**scene["run"], "rpm": rpm, "transient": 0, "record": 2}}
        events, phases = motion_of(own).events, []
        for k, event in enumerate(events):
            if event.kind == "detachment":
                later = [e for e in events[k:] if e.kind == "impact"][impact - 1 :]
                phases += [e.theta / RAD for e in later[:1]]
        place = machine.corners()["abcdef".index(corner)] / RAD
        assert min(abs(phase - place) for phase in phases) < 1e-6

    forces = tables["force"]
    assert np.unique(forces["rpm"]).tolist() == sorted([*speeds, detach["hold_to"]])
    theta = forces["theta_deg"]
    assert np.diff(theta).max() <= 0.5 + 1e-9
    assert {0.0, 360.0} <= set(theta.tolist())
    same = {"rpm": forces["rpm"], "theta_deg": theta, **forces_of(machine, forces)}
    compare(forces, same, "force")
    assert set(tables) == {"detach", "accumulation", "corner_hits", "force", "speeds"}


@pytest.mark.ci
def test_detach_measures_the_motion_past_the_loss():
    """Equal steps from the first loss to the end of the range, 20 turns each."""
    asked = {"rpm": {"start": 690.0, "stop": 790.0, "num": 2}, "impacts": 0, "settle": 0}
    scene = scene_at(900.0, detach=asked)
    table = camcli.detach(camcli.load_scene(scene)).tables["speeds"]
    rpms = np.linspace(690.0, 790.0, 16)
    rows = []
    for rpm in rpms[[0, 7, 15]]:
        own = Record(scene_at(900.0, run={"transient": 3, "record": 2}), rpm)
        rows.append((own.label, np.nan, "ok", *own.loads().values(), np.nan, np.nan, np.nan))
    names = ["label", "lyapunov_per_period", "status", *LOADS, "holds_for", "watched_turns",
             "lyapunov_error_per_period"]  # fmt: skip
    wanted: dict[str, Any] = dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))
    compare({"rpm": table["rpm"]}, {"rpm": rpms})
    assert not (table["impacts"] % 20).any()  # each turn is as the one before
    some = {name: table[name][[0, 7, 15]] for name in table if name not in ("rpm", "impacts")}
    compare(some, wanted, "speeds")


def test_detach_within_tolerances():
    """The corners of the tolerances, then machines inside; the speed to which each holds."""
    percent = {"follower.mass": 5.0, "follower.stiffness": 3.0, "cam.lift": 1.0,
               "follower.preload": 10.0}  # fmt: skip
    tolerance = [{"key": key, "percent": value} for key, value in percent.items()]
    asked = {"rpm": {"start": 650.0, "stop": 660.0, "num": 2}, "impacts": 0, "hold_to": 1500.0,
             "margin_n": 7.0, "tolerance": tolerance, "machines": 4}  # fmt: skip
    scene = scene_at(900.0, detach=asked)
    table = camcli.detach(camcli.load_scene(scene)).tables["tolerance"]
    nominal = {"follower.mass": 0.35, "follower.stiffness": 5200.0, "cam.lift": 0.012,
               "follower.preload": 60.0}  # fmt: skip
    off = np.array([table[key] / nominal[key] - 1.0 for key in nominal]).T
    off /= np.array(list(percent.values())) / 100.0
    corners = np.array(list(product((-1.0, 1.0), repeat=4)))
    np.testing.assert_allclose(off[:16], corners, rtol=1e-9)
    assert (np.abs(off[16:]) < 1.0).all()
    assert np.unique(off[16:]).size == 16
    machine = Machine.of(scene)
    springs = {"first_detachment": {}}
    for name, per_preload in (("hold_preload", 0.0), ("hold_both", 5200.0 / 60.0)):
        preload, *_ = least_preload(machine, 1500.0, 7.0, per_preload)
        stiffness = per_preload * preload if per_preload else 5200.0
        springs[name] = {"preload": preload, "stiffness": stiffness}
    found: dict[str, Any] = {key: table[key] for key in nominal}
    for name, spring in springs.items():
        speeds = []
        for mass, stiffness, lift, preload in zip(*(table[key] for key in nominal), strict=True):
            own = {"mass": mass, "stiffness": stiffness, "preload": preload}
            # a spring is off by the same share as the machine's own
            for key, value in spring.items():
                own[key] *= value / nominal[f"follower.{key}"]
            cam = scene_at(900.0, cam={"lift": lift})
            speeds.append(replace(Machine.of(cam), **own).loss()[0])
        found[f"{name}_rpm"] = speeds
    compare(table, found, "tolerance")


# -- periodic orbits --------------------------------------------------------------------------

MULTIPLIERS = ("multiplier_1_re", "multiplier_1_im", "multiplier_2_re", "multiplier_2_im")


def scene_of(rpm: float, value: float | None) -> dict[str, Any]:
    return scene_at(rpm) if value is None else scene_at(rpm, follower={"damping": value})


def orbit_rows(table: Mapping, key: str = "") -> tuple[Wanted, list[Motion]]:
    """What branch.csv should hold where its speeds, states and labels are right; the motions.

    Each row is flown once around from its state at the strobe, where it must come back to. With an
    impact on a corner, where a branch passes from one region to the next, it is of either side.
    """
    most = sum(name.startswith("theta_deg_") for name in table)
    rows, motions = [], []
    values = table[key] if key else [None] * table.rows
    seen = (table[x] for x in ("rpm", "label", "q_m", "v_m_per_s", "trace"))
    for value, rpm, label, q, v, trace in zip(values, *seen, strict=True):
        turns = int(label[2 : label.index(";")])
        machine = Machine.of(scene_of(rpm, value))
        motion = Motion(machine, turns, machine.strobe / RAD, q, v)
        motions.append(motion)
        ends = motion.state(TURN * turns)
        events = [event for event in motion.events if 0 <= event.at < TURN * turns]
        rests = any(event.kind == "chatter" for event in events)
        own = [e for e in events if e.kind == ("detachment" if rests else "impact")]
        if rests:  # departures, by their phases
            own.sort(key=lambda event: event.theta)
        side = 1
        if any(min(abs(e.theta - x) for x in machine.corners()) < 1e-9 for e in own):
            by = {way: np.trace(multipliers(machine, motion, turns, way)) for way in (-1, 1)}
            side = min(by, key=lambda way: abs(by[way] - trace))
        whole = multipliers(machine, motion, turns, side)
        pair = sorted(np.linalg.eigvals(whole), key=lambda z: (-abs(z), -z.imag))
        regions = [region_at(machine, event.theta + 1e-9 * side) for event in own]
        phases = [event.theta / RAD for event in own] + [np.nan] * (most - len(own))
        rates = [np.nan if rests else event.u_minus for event in own] + [np.nan] * (most - len(own))
        rows.append((
            label_of(Motion(machine, 2 * turns, machine.strobe / RAD, q, v), 0, 2 * turns),
            int(abs(pair[0]) < 1.0), ":".join(regions), *phases, *ends[:2],
            *(part for z in pair for part in (z.real, z.imag)),
            np.trace(whole), np.linalg.det(whole), *rates,
        ))  # fmt: skip
    names = [
        "label", "stable", "region", *(f"theta_deg_{k + 1}" for k in range(most)), "q_m",
        "v_m_per_s", *MULTIPLIERS, "trace", "det",
        *(f"u_minus_m_per_s_{k + 1}" for k in range(most)),
    ]  # fmt: skip
    return dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True)), motions


def readings(table: Mapping, key: str, events: Sequence[float] = ()) -> Wanted:
    """Where branches turn round and over which ranges they are stable, from values and `stable`.

    events: values at which a multiplier is on the unit circle: a range of stable orbits goes on to
    one beside it, and a branch that begins at one begins there.
    """
    count = table.rows
    turns, low, high = np.zeros(count), np.full(count, np.nan), np.full(count, np.nan)
    if not table["branch"].any():  # orbits at one speed
        return {"turns_round": np.full(count, np.nan), "stable_from": low, "stable_to": high}
    for number in np.unique(table["branch"]):
        own = np.flatnonzero(table["branch"] == number)
        values, stable = table[key][own], table["stable"][own].astype(bool)
        for k in range(1, len(own) - 1):
            before, behind = (
                values[:k][values[:k] != values[k]],
                values[k:][values[k:] != values[k]],
            )
            if len(before) and len(behind) and values[k - 1] != values[k]:
                turns[own[k]] = float((before[-1] < values[k]) == (behind[0] < values[k]))
        for k in np.flatnonzero(stable):
            first, last = k, k
            while first > 0 and stable[first - 1]:
                first -= 1
            while last < len(own) - 1 and stable[last + 1]:
                last += 1
            inside = list(values[first : last + 1])
            beside = [values[j] for j in (first - 1, last + 1) if 0 <= j < len(own)]
            inside += [x for x in beside if any(abs(x - event) < 1e-9 for event in events)]
            if first == 0:
                inside += [x for x in events if abs(x - values[0]) < 1e-5 * x]
            low[own[k]], high[own[k]] = min(inside), max(inside)
    return {"turns_round": turns, "stable_from": Near(low, 1e-6), "stable_to": Near(high, 1e-6)}


def columns_at(table: Mapping, wanted: Mapping, **more: Any) -> dict[str, Any]:
    """The columns wanted, with those that say where a row is, as they are in the table."""
    given = {name: table[name] for name in ("rpm", "branch", "follower.damping") if name in table}
    return {**given, **wanted, **more}


def bifurcation_rows(tables: Mapping, motions: Sequence[Motion], proved: bool) -> Wanted:
    """Of bifurcations.csv: each event solved in 30 digits, from the point of its branch nearby."""
    branch, table, rows = tables["branch"], tables["bifurcations"], []
    seen = (table[x].tolist() for x in ("branch", "label", "kind", "rpm", "rpm_error", "corner"))
    for k, (number, label, kind, rpm, error, name) in enumerate(zip(*seen, strict=True)):
        own = np.flatnonzero((branch["branch"] == number) & (branch["label"] == label))
        near = motions[own[np.abs(branch["rpm"][own] - rpm).argmin()]]
        machine, turns = near.machine, int(label[2 : label.index(";")])
        corner = machine.corners()["abcdef".index(name)] if name else None
        at, ((tl, dl), (tr, dr)), _ = exact_event(machine, kind, near, turns, corner)
        assert abs(rpm - at) <= error + 1e-15 * at
        assert error < 1e-12 * at + 1e-9
        if proved:
            assert table["enclosure_low"][k] <= at <= table["enclosure_high"][k]
            assert table["enclosure_high"][k] - table["enclosure_low"][k] < 1e-14 * at
        if kind == "grazing":
            tr = dr = np.nan  # no orbit of this label beyond it
        ways = (1 - tl + dl) * (1 - tr + dr)
        sorts = {"corner-impact": "persistence" if ways > 0 else "nonsmooth-fold"}
        rows.append((kind, name, tl, dl, tr, dr, sorts.get(kind, "")))
    names = "kind", "corner", "trace_left", "det_left", "trace_right", "det_right", "classification"
    return dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))


@pytest.mark.ci
def test_orbits_and_their_bifurcations():
    """A doubling, a grazing and a corner impact; proofs and points of a simulation."""
    asked = {"rpm": {"start": 2620.0, "stop": 3010.0, "num": 8}, "at": 2700.0, "simulated": 2}
    scene = scene_at(900.0, run={"transient": 10, "record": 8}, orbits=asked)
    result = camcli.orbits(camcli.load_scene(scene), prove=True)
    tables = result.tables
    branch, motions = orbit_rows(tables["branch"])
    events = tables["bifurcations"]
    event_at = np.abs(tables["branch"]["rpm"][:, None] - events["rpm"]).min(1) < 1e-6
    # a point at an event may be on either side of it, and cannot always be shown to be on one
    more = {
        "stable": np.where(event_at, tables["branch"]["stable"], branch["stable"]),
        "proved": np.where(event_at, tables["branch"]["proved"], "yes"),
        **readings(tables["branch"], "rpm", events["rpm"]),
    }
    compare(tables["branch"], columns_at(tables["branch"], {**branch, **more}), "branch")
    assert sorted(set(events["kind"])) == ["corner-impact", "grazing", "period-doubling"]
    wanted = bifurcation_rows(tables, motions, proved=True)
    known = ("label", "rpm_error", "enclosure_low", "enclosure_high")  # held above
    more = {name: events[name] for name in known}
    compare(
        events, columns_at(events, wanted, proved=["yes"] * events.rows, **more), "bifurcations"
    )
    records = [(Record(scene, rpm), {}) for rpm in (2620.0, 3010.0)]
    own = of_sweep(records, tables, lyapunov=False)
    for name in ("impacts", "strobe"):
        compare(tables[name], own[name], name)
    assert set(tables) == {"branch", "bifurcations", "impacts", "strobe"}


@pytest.mark.parametrize("rpm", [900.0, 1500.0])
def test_orbits_at_one_speed(rpm):
    """One that rests twice in a turn, and one of three impacts."""
    asked = {"rpm": {"start": rpm, "stop": rpm, "num": 1}}
    scene = scene_at(900.0, run={"transient": 60, "record": 8}, orbits=asked)
    tables = camcli.orbits(camcli.load_scene(scene)).tables
    branch, _ = orbit_rows(tables["branch"])
    assert tables["branch"]["branch"].tolist() == [0]
    branch |= readings(tables["branch"], "rpm")
    compare(tables["branch"], columns_at(tables["branch"], branch, rpm=[rpm]), "branch")


@pytest.mark.ci
def test_orbits_and_a_curve_in_another_number():
    """branch.csv along the damping, and the doubling in speed and damping."""
    vary = [{"key": "follower.damping", "start": 5.0, "stop": 7.0, "num": 5}]
    asked: dict[str, Any] = {"vary": vary, "at": 2940.0}
    run = {"transient": 60, "record": 8}
    scene = scene_at(2940.0, run=run, orbits=asked)
    tables = camcli.orbits(camcli.load_scene(scene)).tables
    branch, _ = orbit_rows(tables["branch"], "follower.damping")
    branch |= readings(tables["branch"], "follower.damping")
    rpms = np.full(tables["branch"].rows, 2940.0)
    compare(tables["branch"], columns_at(tables["branch"], branch, rpm=rpms), "branch")
    assert {5.0, 6.0, 7.0} <= set(tables["branch"]["follower.damping"].tolist())

    vary.insert(0, {"key": "rpm", "start": 2900.0, "stop": 3000.0, "num": 3})
    scene = scene_at(2940.0, run=run, orbits={**asked, "curve": "period-doubling"})
    tables = camcli.orbits(camcli.load_scene(scene)).tables
    curve, rows = tables["curve"], []
    branch, motions = orbit_rows(tables["branch"])
    for damping in curve["follower.damping"]:
        near = motions[int(np.abs(tables["branch"]["rpm"] - 2950.0).argmin())]
        machine = replace(near.machine, damping=damping)
        near = Motion(machine, 1, machine.strobe / RAD, *near.state(0.0)[:2])
        at, ((tl, dl), (tr, dr)), (theta,) = exact_event(machine, "period-doubling", near, 1)
        rows.append((1, "period-doubling", "P(1;1)", "", at, damping, theta, tl, dl, tr, dr))
    wanted = dict(columns_of(curve, rows))
    phases = [float(text) for text in curve["theta_deg"]]  # of one impact: a number
    compare({"theta_deg": phases}, {"theta_deg": wanted.pop("theta_deg")}, "curve")
    wanted["theta_deg"] = curve["theta_deg"]
    assert curve.rows >= 3
    compare(curve, wanted, "curve")
    dampings = curve["follower.damping"].tolist()
    assert (min(dampings), max(dampings)) == (5.0, 7.0)  # up to both ends
    assert np.diff(dampings).max() <= 1.0 + 1e-9


# -- basins -----------------------------------------------------------------------------------

BISTABLE = 2400.0  # rpm: P(1;2) and P(2;2:1)


def end_of(machine: Machine, q: float, v: float) -> tuple[str, list[np.ndarray]]:
    """(label, states at the strobe in its order) of what a start at the strobe settles on."""
    turns = 80
    motion = Motion(machine, turns, machine.strobe / RAD, q, v)
    counts = np.bincount([int(e.at // TURN) for e in motion.events], minlength=turns).tolist()
    label = {(2, 2): "P(1;2)", (2, 1): "P(2;2:1)", (1, 2): "P(2;2:1)"}[tuple(counts[-2:])]
    assert counts[-10:] == counts[-2:] * 5
    m = int(label[2])
    first = turns - 4 + (counts[-4] == 1)  # a turn of two impacts
    near = motion.state(TURN * first)[:2]
    one = closed(machine, m, near)
    assert np.abs(one - near).max() < 0.1 * np.abs(one).max()
    states = [one]
    for _ in range(m - 1):
        states.append(
            np.array(Motion(machine, 1, machine.strobe / RAD, *states[-1]).state(TURN)[:2])
        )
    return label, states


def closed(machine: Machine, turns: int, state: Sequence[float]) -> np.ndarray:
    """The periodic state nearby: Newton's method on the map over so many turns."""
    found = np.array(state)
    for _ in range(6):
        motion = Motion(machine, turns, machine.strobe / RAD, *found)
        miss = np.array(motion.state(TURN * turns)[:2]) - found
        found = found - np.linalg.solve(multipliers(machine, motion, turns) - np.eye(2), miss)
    return found


def growth_of(
    machine: Machine, states: Sequence[np.ndarray]
) -> tuple[np.ndarray, list[np.ndarray]]:
    """(multipliers, larger first; derivative of each turn in q and v over omega)."""
    scale, maps = np.diag([1.0, 1.0 / machine.omega]), []
    for state in states:
        motion = Motion(machine, 1, machine.strobe / RAD, *state)
        maps.append(scale @ multipliers(machine, motion, 1) @ np.linalg.inv(scale))
    whole = maps[0] if len(maps) == 1 else maps[1] @ maps[0]
    return np.array(sorted(np.linalg.eigvals(whole), key=lambda z: (-abs(z), -z.imag))), maps


def error_of_share(codes: np.ndarray, code: int) -> float:
    """sqrt(sum p (1 - p))/cells, p the share of a code among the 3 x 3 cells around one above."""
    above, total = codes != -1, 0.0
    for row, column in np.argwhere(above):
        near = codes[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        p = np.mean(near[near != -1] == code)
        total += p * (1.0 - p)
    return np.sqrt(total) / above.sum()


def ellipse_of(maps: Sequence[np.ndarray], k: int, states: np.ndarray, radius: float) -> np.ndarray:
    """Half widths of the ellipse about point k: x P x = (radius size)^2, its form by its sum."""
    rho = np.abs(np.linalg.eigvals(np.linalg.multi_dot([*maps[::-1], np.eye(2)]))).max()
    s = (0.5 * (1.0 + rho)) ** (1.0 / len(maps))
    form, product = np.zeros((2, 2)), np.eye(2)
    for n in range(20_000):
        form += product.T @ product
        product = maps[(k + n) % len(maps)] @ product / s
    return radius * np.abs(states).max() * np.sqrt(np.diag(np.linalg.inv(form)))


@pytest.mark.ci
def test_basins():
    """Two attractors from 5 x 5 starts, some below the cam, and the saddle between them."""
    asked = {"rpm": {"start": BISTABLE, "stop": BISTABLE, "num": 1}, "q": [-0.002, 0.028],
             "v": [-9.0, 9.0], "cells": [5, 5], "exponents": True, "saddles": True}  # fmt: skip
    scene = scene_at(BISTABLE, run={"transient": 100, "record": 40}, basins=asked)
    result = camcli.basins(camcli.load_scene(scene))
    machine, tables = Machine.of(scene), result.tables
    lowest = machine.cam(machine.strobe)[0, 0]
    q, v = np.meshgrid(-0.002 + 0.006 * (np.arange(5) + 0.5), -9.0 + 3.6 * (np.arange(5) + 0.5))
    found = {
        (x, y): end_of(machine, x, y) for x, y in zip(q.flat, v.flat, strict=True) if x > lowest
    }
    states = dict(found.values())
    number = {"P(1;2)": 1, "P(2;2:1)": 2}  # by turns
    codes = np.array([
        number[found[x, y][0]] if x > lowest else -1 for x, y in zip(q.flat, v.flat, strict=True)
    ])  # fmt: skip
    compare(
        tables["basins"], {"q_m": q.ravel(), "v_m_per_s": v.ravel(), "attractor": codes}, "basins"
    )
    assert set(states) == set(number)

    rows, fields, above = [], [], codes[codes != -1]
    for label, k in number.items():
        (first, second), maps = growth_of(machine, states[label])
        share, error = np.mean(above == k), error_of_share(codes.reshape(5, 5), k)
        exponent = np.log(abs(first)) / len(maps)
        pair = [part for z in (first, second) for part in (z.real, z.imag)]
        rows.append((k, label, *states[label][0], share, error, BISTABLE, *pair, exponent))
        section = np.array(states[label]) / [1.0, machine.omega]
        radius = radius_of(result, k)
        ellipses = [ellipse_of(maps, j, section, radius) for j in range(len(maps))]
        widths = [pair * [1.0, machine.omega] for pair in ellipses]
        fields.append({
            "attractor": k, "label": label, "turns": len(maps),
            "states_q_m_v_m_per_s": [list(state) for state in states[label]],
            "multipliers": [[z.real, z.imag] for z in (first, second)],
            "fraction": share, "standard_error": error,
            "ellipse_radius_over_size": lambda radius: 0.0 < radius <= 0.25,
            "form_shrinks_by": 0.5 * (1.0 + (0.5 * (1.0 + abs(first))) ** 2),
            "ring_of_starts_returns": True,
            "half_widths_q_m_v_m_per_s": [list(pair) for pair in widths],
        })  # fmt: skip
    compare(tables["attractors"], columns_of(tables["attractors"], rows), "attractors")

    saddles, label = tables["saddles"], "P(2;2:2)"
    orbit = closed(machine, 2, (saddles["q_m"][0], saddles["v_m_per_s"][0]))
    whole = multipliers(machine, Motion(machine, 2, machine.strobe / RAD, *orbit), 2)
    first, second = sorted(np.linalg.eigvals(whole), key=lambda z: -abs(z))
    assert abs(second) < 1.0 < abs(first)
    again = label_of(Motion(machine, 8, machine.strobe / RAD, *orbit), 0, 8)
    led, tried = int(saddles["led"][0]), int(saddles["tried"][0])
    assert 1 <= led <= tried
    row = (BISTABLE, again, *orbit, first, 0.0, second, 0.0, led, tried)
    compare(saddles, columns_of(saddles, [row]), "saddles")

    shares = [np.mean(above == k) for k in number.values()]
    entropy = -sum(p * np.log(p) for p in shares)
    same(result.summary, {
        "method": "orbit", "criterion": lambda text: "ellipse to ellipse" in text,
        "status": "ok", "budget_turns": 4000,
        "speeds": [{
            "value": BISTABLE, "rpm": BISTABLE, "attractors": fields, "cells": 25,
            "computed": 25, "computed_share": 1.0, "undecided": 0, "rests": [],
            "troubled": {},
            "turns_per_cell": lambda of: 1 <= of["median"] <= of["percentile_99"] <= of["most"],
            "basin_entropy": entropy, "boundary_entropy": entropy, "boxes": 1, "boundary_boxes": 1,
            "saddles": [{"label": label, "led": led, "tried": tried}], "uncertainty": None,
        }],
    }, close=1e-5)  # fmt: skip


def test_an_attractor_keeps_its_number_over_the_speeds():
    """Here that of its name; one of them begins on the way."""
    asked = {"rpm": {"start": 2395.0, "stop": 2405.0, "num": 5}, "q": [0.0, 0.03],
             "v": [-9.0, 9.0], "cells": [8, 8]}  # fmt: skip
    scene = scene_at(BISTABLE, run={"transient": 100, "record": 40}, basins=asked)
    table = camcli.basins(camcli.load_scene(scene)).tables["attractors"]
    found = {}
    for number, label in zip(table["attractor"].tolist(), table["label"].tolist(), strict=True):
        found.setdefault(label, set()).add(number)
    assert sorted(found) == ["P(1;2)", "P(2;2:1)"]
    assert sorted(map(sorted, found.values())) == [[1], [2]]
    assert 5 < len(table["rpm"]) < 10


@pytest.mark.parametrize("key", ["rpm", "follower.restitution"])
def test_cells_of_several_values_are_those_of_each(key):
    """The table of a range, part by part against those of its values alone."""
    window = {"q": [0.0, 0.03], "v": [-9.0, 9.0], "cells": [6, 4]}
    ends = {"rpm": (2395.0, 2405.0), "follower.restitution": (0.595, 0.6)}[key]

    def cells(values: Sequence[float]) -> Any:
        axis = {"start": values[0], "stop": values[-1], "num": len(values)}
        rpm = axis if key == "rpm" else {"start": BISTABLE, "stop": BISTABLE, "num": 1}
        vary = [] if key == "rpm" else [{"key": key, **axis}]
        scene = scene_at(BISTABLE, run={"transient": 100, "record": 40},
                         basins={**window, "rpm": rpm, "vary": vary})  # fmt: skip
        return camcli.basins(camcli.load_scene(scene)).tables["basins"]

    both, parts = cells(ends), [cells([value]) for value in ends]
    names = ["q_m", "v_m_per_s", "attractor"]
    assert list(both) == ([*names, key] if key == "rpm" else [key, *names])
    assert both[key].tolist() == [ends[0]] * 24 + [ends[1]] * 24
    for name in names:
        wanted = np.concatenate([part[name] for part in parts])
        if name != "attractor":  # their numbers go on from value to value
            assert both[name].tolist() == wanted.tolist()
    for k, part in enumerate(parts):
        own = both["attractor"][24 * k : 24 * k + 24].tolist()
        pairs = set(zip(own, part["attractor"].tolist(), strict=True))
        assert len(pairs) == len(set(own)) == len(set(part["attractor"].tolist()))


def radius_of(result: Any, attractor: int) -> float:
    """Of the ellipses of an attractor, as said in the record."""
    return result.summary["speeds"][0]["attractors"][attractor - 1]["ellipse_radius_over_size"]
