"""Every field of run.json against a value computed another way, on the machine of the columns.

A field without a check here is a failure. What stands in a table too is compared with that table,
whose columns are judged in `test_columns`. Sentences are read elsewhere.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
from dataclasses import replace
from importlib.metadata import version
from itertools import groupby, pairwise
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import camcli
from camcli.analysis.integrate import Cost
from tests.support.mechanics import RAD, TURN, Machine
from tests.support.motion import Motion
from tests.support.orbits import Exact, multipliers
from tests.truth.test_columns import (
    CAUGHT,
    SCENE,
    Record,
    critical_speeds,
    exponent_of,
    label_of,
    least_preload,
    motion_of,
    region_at,
    same,
    scene_at,
)

pytestmark = [pytest.mark.slow, pytest.mark.ci]


def texts(found: Any) -> bool:
    """Sentences: their numbers are judged where they are made."""
    return all(isinstance(text, str) and text for text in found)


def rows_of(table: Any) -> list[dict[str, Any]]:
    names = list(table)
    columns = (table[name].tolist() for name in names)
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def either(number: float) -> Any:
    """As JSON has it: infinities are texts."""
    return str(number) if np.isinf(number) else float(number)


# -- the frame of all commands ----------------------------------------------------------------


def test_what_was_run_with_what_and_at_which_cost(tmp_path):
    """Impacts and evaluations are counted, files and scene hashed, versions and machine told."""
    scene = camcli.load_scene(scene_at(1500.0))
    result = camcli.simulate(scene)
    told = json.loads(json.dumps(result.save(tmp_path, plot=False)))
    record = json.loads((tmp_path / "run.json").read_text())
    assert told == record
    own = [event for event in motion_of(scene_at(1500.0)).events if event.kind == "impact"]
    largest = max(map(abs, Machine.of(scene_at(1500.0)).lift.range))
    packages = [name for name in record["versions"] if name != "python"]
    assert {"camcli", "numpy", "numba", "scipy", "python-flint"} <= set(packages)
    files = [path for path in tmp_path.iterdir() if path.name != "run.json"]
    follower = record["scene"]["follower"]
    assert follower == {**SCENE["follower"], "seat_restitution": None}
    assert record["scene"]["run"]["rpm"] == 1500.0
    assert record["scene"]["run"]["strobe_deg"] == 77.0
    again = camcli.simulate(camcli.load_scene(record["scene"]))
    assert again.summary == result.summary
    other = camcli.simulate(camcli.load_scene(scene_at(1500.0, follower={"mass": 0.36})))
    other = other.save(tmp_path / "other", plot=False)
    assert other["scene_sha256"] != record["scene_sha256"]
    seconds = record["cost"]["seconds"]
    begin = TURN * record["scene"]["run"]["transient"]
    hardest = max(-event.u_minus for event in own if event.at >= begin)
    lands = (
        f"At 1500 rpm of the cam contact is lost: the follower lands at up to {hardest:.2g} m/s."
    )
    same(record, {
        "command": "simulate", "verdict": [lands], "verdict_details": [],
        "scene": lambda found: found["cam"]["lift"] == 0.012,
        "scene_sha256": lambda text: len(bytes.fromhex(text)) == 32,
        "cost": {
            "impacts": len(own),
            "seconds": lambda found: 0.0 < found < 100.0,
            "impacts_per_s": len(own) / seconds,
            # a landing takes at least one of them, and a flight is no hundred steps here
            "gap_evaluations": lambda found: len(own) <= found < 100 * len(own),
            "crossings": lambda found: 0 < found < 100 * len(own),
            "pieces_from_disk": 0,
        },
        "error": {
            "accumulation_phase_turns": 1e-13,
            # four roundings of the largest lift
            "contact_gap_m": 2.0**-50 * largest,
            "meaning": lambda text: text.startswith("bound for each event"),
        },
        "result": result.summary,
        "notes": [],
        "piece_faults": [],
        "artefacts": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files},
        "program_sha256": lambda text: len(bytes.fromhex(text)) == 32,
        "versions": {"python": platform.python_version(), **{x: version(x) for x in packages}},
        "machine": {"system": platform.system(), "processor": platform.machine(),
                    "processors": os.cpu_count()},
    }, "run.json")  # fmt: skip

    for name, wanted in (
        ("accumulation_phase_turns", 1e-13),
        ("contact_gap_m", 2.0**-50 * largest),
    ):
        assert record["error"][name] == pytest.approx(wanted, rel=0.01, abs=0.0)


def test_roundings_of_a_cam_below_zero_are_those_of_its_lowest_lift():
    """From -0.3 to -0.1 m."""
    cam = {"kind": "eccentric", "base": -0.3, "lift": 0.2}
    scene = {"follower": {"mass": 1.0, "stiffness": 100.0, "restitution": 0.5}, "cam": cam}
    error = camcli.simulate(camcli.load_scene(scene), profile_only=True).error
    assert error["contact_gap_m"] == pytest.approx(4.0 * 2.0**-52 * 0.3, rel=0.01, abs=0.0)


def test_a_chaotic_motion_has_both_notes_on_how_far_it_can_be_trusted():
    values = {"run.rpm": 745.0, "run.transient": 0, "run.record": 200, "run.patience": 0}
    result = camcli.simulate(camcli.load_scene(None, values))
    rounded, unending = result.notes
    # errors of 1e-16 of a turn have grown to 1e-5 after ln(1e11) = 25 times the time of e-fold
    assert 30 < result.values.one_of_many < 120
    assert rounded.startswith(
        f"from turn {result.values.one_of_many} of the record on, this is one"
    )
    assert unending == "the record shows no period; it was followed for 200 turns"


# -- the result of each command ---------------------------------------------------------------


@pytest.mark.parametrize("rpm", [650.0, 900.0, 1500.0])
def test_simulate(rpm):
    scene = scene_at(rpm, run={"transient": 30, "record": 8})
    result = camcli.simulate(camcli.load_scene(scene))
    motion = motion_of(scene)
    same(result.summary, {
        "rpm": rpm, "label": label_of(motion, 30, 8), "status": "ok", "periods": 8,
        "events": result.tables["events"].rows,
        "corners_deg": [x / RAD for x in motion.machine.corners()],
    })  # fmt: skip


def test_the_cam_alone():
    """Ranges, least force, first loss, and curvatures from coordinates by differences."""
    scene, base = scene_at(900.0, simulate={"samples": 720}), 0.03
    result = camcli.simulate(camcli.load_scene(scene), profile_only=True, base_radius=base)
    machine = Machine.of(scene)
    x = np.unique(
        np.concatenate([np.linspace(a, b, 20_001)[1:-1] for a, b in pairwise(machine.lift.edges)])
    )
    c, c1, c2 = machine.lift.at(x)
    ends = np.searchsorted(x, machine.lift.edges)
    c3 = np.concatenate([np.gradient(c2[a:b], x[a:b]) for a, b in pairwise(ends)])
    low = machine.lift.range[0]

    def extremes(values: np.ndarray) -> list[Any]:
        return [
            lambda found, k=k: (
                abs(found["value"] - values[k]) < (1e-3 if values is c3 else 1e-6) * np.ptp(values)
                and (
                    abs(values[abs(x - found["theta_deg"] * RAD) < 1e-3] - values[k]).min()
                    < 1e-3 * np.ptp(values)
                    if values is c3  # which jumps there
                    else abs(np.interp(found["theta_deg"] * RAD, x, values) - values[k])
                    < 1e-3 * np.ptp(values)
                )
            )
            for k in (values.argmin(), values.argmax())
        ]

    radius = base + c - low
    flat = radius + c2
    kappa = (radius**2 + 2 * c1**2 - radius * c2) / np.hypot(radius, c1) ** 3
    force, at = machine.extreme_force(0.0, TURN, -1)
    same(result.summary, {
        "rpm": 900.0,
        "corners_deg": dict(zip("ab", (x / RAD for x in machine.corners()), strict=True)),
        "ranges": {
            "c (m)": extremes(c), "c_theta (m/rad)": extremes(c1),
            "c_thetatheta (m/rad2)": extremes(c2),
            "c_thetathetatheta (m/rad3)": extremes(c3),
        },
        "jerk_infinite_deg": [x / RAD for x in machine.corners()],
        "jerk_unknown": None, "jerk_error_m_per_rad3": None,
        "least_force_n": {"value": force, "theta_deg": at / RAD},
        "first_detachment_rpm": machine.loss()[0],
        "first_detachment_between_rpm": lambda ends: (
            ends[0] < result.summary["first_detachment_rpm"] < ends[1] < ends[0] * (1.0 + 4e-12)
        ),
        "base_radius_m": base,
        "flat_faced": {
            "least_radius_m": {"value": flat.min(), "theta_deg": x[flat.argmin()] / RAD},
            "undercut": bool(flat.min() <= 0.0),
            "least_base_radius_m": base - flat.min(),
        },
        "largest_roller_radius_m": {
            "value": 1.0 / kappa.max(), "theta_deg": x[kappa.argmax()] / RAD,
        },
        "rocker_ratio": 1.0,
        "assumed": lambda text: "base_radius" in text,
    }, close=2e-4)  # fmt: skip


def test_sweep():
    scene = scene_at(900.0, sweep={"rpm": {"start": 640.0, "stop": 970.0, "num": 4}})
    result = camcli.sweep(camcli.load_scene(scene))
    labels = [(rpm, Record(scene, rpm).label) for rpm in (640.0, 750.0, 860.0, 970.0)]
    ranges = []
    for label, some in groupby(labels, lambda row: row[1]):
        rpms = [rpm for rpm, _ in some]
        ranges.append({"label": label, "status": "ok", "from_rpm": rpms[0], "to_rpm": rpms[-1],
                       "speeds": len(rpms)})  # fmt: skip
    same(
        result.summary,
        {"status": "ok", "direction": "fixed", "undecided": 0, "holds_for": {}, "ranges": ranges},
    )


def motion_at(scene: dict[str, Any], rpm: float, turns: int = 2) -> Motion:
    return motion_of(
        {**scene, "run": {**scene["run"], "rpm": rpm, "transient": 0, "record": turns}}
    )


def bursts_of(scene: dict[str, Any], rpm: float) -> dict[str, float]:
    """Where the chatter of a turn ends (deg), by the region in which it begins."""
    machine, events = Machine.of(scene), motion_at(scene, rpm).events
    found = {}
    for k, event in enumerate(events):
        if event.kind == "chatter" and event.at >= 0.0:
            begin = [e for e in events[:k] if e.kind == "detachment"][-1]
            found[region_at(machine, begin.theta)] = event.theta / RAD
    return found


def burst_words(scene: dict[str, Any], rpm: float) -> str:
    return ", ".join(f"{region} complete" for region in sorted(bursts_of(scene, rpm))) or "none"


def landing(scene: dict[str, Any], rpm: float, impact: int, region: str) -> float:
    """Phase (deg) of the n-th impact after contact is lost in a region."""
    machine, events = Machine.of(scene), motion_at(scene, rpm).events
    for k, event in enumerate(events):
        if event.kind == "detachment" and region_at(machine, event.theta) == region:
            return [e for e in events[k:] if e.kind == "impact"][impact - 1].theta / RAD
    raise AssertionError(region)


def just_above(row: dict[str, Any]) -> dict[str, Any]:
    """Of a region that opens: a millionth above, where contact is lost for a moment."""
    place = row["theta_deg"]
    return {
        "region": row["region"],
        "kind": lambda kind: kind in ("flies-off", "released-and-caught", "within-region"),
        "corner": lambda name: name in ("", "b", "e"),
        "rpm": row["rpm"] * (1.0 + 1e-6),
        "release_deg": lambda x: 0.0 <= place - x < 0.1,
        "landing_deg": lambda x: 0.0 < x - place < 0.1,
        "rest_deg": lambda x: 0.0 < x - place < 0.2,
    }


def holds(machine: Machine, asked: dict[str, Any]) -> list[dict[str, Any]]:
    """Each spring: its least force is the margin, and it is lost at the speed of the table."""
    known = critical_speeds(machine, asked)
    low, top = machine.lift.range
    impossible: dict[str, Any] = {
        "quantity": "hold_stiffness", "status": "impossible", "stiffness": None, "preload": None,
        "region": lambda name: True,
        "theta_deg": lambda x: machine.lift.at(x * RAD)[0, 0] <= 0.0,
        "detaches_rpm": None, "least_n": None, "obstacle": "pull", "missing_n": 0.0,
        "nose_n": None, "more": True, "words": lambda text: "the spring would pull" in text,
        "low_rpm": None, "high_rpm": None,
    }  # fmt: skip
    found = [impossible]
    for (quantity, region), (theta, rpm) in known.items():
        if quantity.startswith("hold"):
            per = machine.stiffness / machine.preload if quantity == "hold_both" else 0.0
            preload, *_ = least_preload(machine, asked["hold_to"], asked["margin_n"], per)
            stiffness = per * preload if per else machine.stiffness
            found.append({
                "quantity": quantity, "status": "ok", "stiffness": stiffness, "preload": preload,
                "region": region, "theta_deg": theta, "detaches_rpm": rpm,
                "least_n": asked["margin_n"], "obstacle": None, "missing_n": None,
                "nose_n": preload + stiffness * top, "more": True,
                "low_rpm": lambda x, rpm=rpm: 0.0 <= rpm * (1.0 + 1e-9) - x < 3e-9 * rpm,
                "high_rpm": lambda x, rpm=rpm: 0.0 <= x - rpm * (1.0 - 1e-9) < 3e-9 * rpm,
                "words": lambda text, preload=preload: f"preload {preload:.7g}"[:14] in text,
            })  # fmt: skip
    assert low < 0.0
    return found


def detach_asked(scene: dict[str, Any]) -> dict[str, Any]:
    speeds = (650.0, 1000.0, 4) if scene is not CAUGHT else (80.0, 160.0, 5)
    start, stop, num = speeds
    return {"rpm": {"start": start, "stop": stop, "num": num}, "impacts": 3,
            "hold_to": 1500.0 if scene is not CAUGHT else 200.0, "margin_n": 7.0}  # fmt: skip


def working(scene: dict[str, Any]) -> dict[str, Any]:
    """What is told of the speed of the run, where the scene states it."""
    rpm = scene.get("run", {}).get("rpm")
    if rpm is None:
        return {}
    own = replace(Machine.of(scene), rpm=rpm)
    force, at = own.extreme_force(0.0, TURN, -1)
    loads = Record(scene_at(rpm, run={"transient": 20, "record": 2}), rpm).loads()
    told = ("max_impact_m_per_s", "landing_deg", "landing_lift_m")
    return {
        "working": {
            "rpm": rpm, "least_force_n": force, "theta_deg": at / RAD, "open": False,
            **{name: loads[name] if force < 0.0 else None for name in told},
        }
    }  # fmt: skip


@pytest.mark.parametrize("name", ["harmonic", "arcs"])
def test_detach(name):
    scene = CAUGHT if name == "arcs" else scene_at(900.0)
    asked, machine = detach_asked(scene), Machine.of(scene)
    result = camcli.detach(camcli.load_scene({**scene, "detach": asked}))
    known, tables = critical_speeds(machine, asked), result.tables

    def critical(row: dict[str, Any]) -> dict[str, Any]:
        """Of a row of detach.csv: the truth lies between both ends, which are close."""
        rpm = row["rpm"]
        truth = known.get((row["quantity"], row["region"]), (None, rpm))[1]
        found: dict[str, Any] = {
            "quantity": row["quantity"], "region": row["region"],
            "theta_deg": None if np.isinf(rpm) else row["theta_deg"], "rpm": either(rpm),
            "low_rpm": lambda low: float(low) <= truth <= float(low) * 1.000001,
            "high_rpm": lambda high: float(high) * 0.999999 <= truth <= float(high),
            "status": "never" if np.isinf(rpm) else "ok",
        }  # fmt: skip
        if row["quantity"] in ("accumulation_at_corner", "completion_loss"):
            found["burst"] = lambda region: region in bursts_of(scene, rpm - 1e-3)
        return found

    speeds = np.linspace(asked["rpm"]["start"], asked["rpm"]["stop"], asked["rpm"]["num"])
    ranges = []
    for words, some in groupby([(rpm, burst_words(scene, rpm)) for rpm in speeds], lambda x: x[1]):
        rpms = [rpm for rpm, _ in some]
        ranges.append({"bursts": words, "from_rpm": rpms[0], "to_rpm": rpms[-1],
                       "speeds": len(rpms)})  # fmt: skip
    least = []
    for rpm in np.unique(tables["force"]["rpm"]):
        own = replace(machine, rpm=rpm)
        force, _ = own.extreme_force(0.0, TURN, -1)

        def there(x: float, own=own, force=force) -> bool:
            """On a dwell it is equal all over, at a corner of one side."""
            sides = (own.force(x * RAD, side)[0] for side in (-1, 1))
            return min(abs(found - force) for found in sides) < 1e-6

        near = lambda found, force=force: abs(found - force) < 1e-6  # noqa: E731
        least.append({"rpm": rpm, "force_n": near, "theta_deg": there})
    opened = [row for row in rows_of(tables["detach"]) if row["quantity"] == "opens"]

    def hit(row: dict[str, Any]) -> dict[str, Any]:
        rpm = row["rpm"]
        corner = machine.corners()["abcdef".index(row["corner"])] / RAD
        return {
            **row, "status": "ok",
            "burst": lambda region: abs(landing(scene, rpm, row["impact"], region) - corner) < 1e-5,
            "low_rpm": lambda low: 0.0 <= rpm - low < 1e-6,
            "high_rpm": lambda high: 0.0 <= high - rpm < 1e-6,
        }  # fmt: skip

    def ended(row: dict[str, Any]) -> bool:
        """Just below its speed the impact is near before_deg, just above at after_deg."""
        assert sorted(row) == ["after_deg", "before_deg", "burst", "corner", "high_rpm", "impact",
                               "low_rpm", "rpm", "status"]  # fmt: skip
        own = row["impact"], row["burst"]
        before, after = (landing(scene, row["rpm"] + d, *own) for d in (-1e-3, 1e-3))
        # a graze: apart by the square root of the speed's difference before, not after
        near = abs(before - row["before_deg"]) < 0.3 and abs(after - row["after_deg"]) < 0.01
        return near and row["low_rpm"] <= row["rpm"] <= row["high_rpm"] and row["status"] == "jump"

    def jumps(row: dict[str, Any]) -> bool:
        """Just below its speed the burst ends before the corner, just above it after it."""
        assert sorted(row) == ["burst", "high_rpm", "low_rpm", "quantity", "region", "rpm",
                               "status", "theta_deg"]  # fmt: skip
        before, after = (bursts_of(scene, row["rpm"] + d)[row["burst"]] for d in (-1e-4, 1e-4))
        assert row["quantity"] == "accumulation_at_corner"
        assert row["theta_deg"] == pytest.approx(
            machine.corners()["abcdef".index(row["region"])] / RAD
        )
        inside = row["low_rpm"] <= row["rpm"] <= row["high_rpm"]
        return before < row["theta_deg"] < after and inside and row["status"] == "jump"

    critical_rows = [r for r in rows_of(tables["detach"]) if not r["quantity"].startswith("hold")]
    same(result.summary, {
        "status": "ok", "words": texts,
        "critical_speeds": [critical(row) for row in critical_rows],
        "just_above_opening": [just_above(row) for row in opened if np.isfinite(row["rpm"])],
        "corner_hits": [hit(row) for row in rows_of(tables["corner_hits"])],
        "corner_hits_ended": lambda rows: all(map(ended, rows)),
        "accumulation_jumps": lambda rows: all(map(jumps, rows)),
        "bursts": ranges,
        "least_force": least,
        "hold": holds(machine, asked),
        "hold_margin_n": asked["margin_n"],
        **working(scene),
    }, close=1e-6)  # fmt: skip
    assert bool(result.summary["accumulation_jumps"]) == (name == "arcs")


def orbit_record(row: dict[str, Any]) -> dict[str, Any]:
    """Of a row of branch.csv, whose columns are judged."""
    pair = [[row[f"multiplier_{k}_re"], row[f"multiplier_{k}_im"]] for k in (1, 2)]
    impacts = [x for name, x in row.items() if name.startswith("theta_deg_") and x == x]
    rates = [x for name, x in row.items() if name.startswith("u_minus_m_per_s_") and x == x]
    return {
        "label": row["label"], "rpm": row["rpm"], "stable": bool(row["stable"]),
        "verdict": "admissible", "theta_deg": impacts, "regions": row["region"].split(":"),
        "u_minus_m_per_s": rates, "multipliers": pair, "trace": row["trace"], "det": row["det"],
    }  # fmt: skip


def is_virtual(machine: Machine, one: dict[str, Any]) -> bool:
    """A root of the shooting equations that is no motion: it pulls, or flies through the cam."""
    own, turns = Exact(machine, machine.rpm), int(one["label"][2])
    assert sorted(one) == ["det", "label", "multipliers", "regions", "rpm", "stable", "theta_deg",
                           "trace", "u_minus_m_per_s", "verdict"]  # fmt: skip
    (theta,), (u,) = one["theta_deg"], one["u_minus_m_per_s"]
    at, up = [(theta * RAD - machine.strobe) % TURN], [-machine.restitution * u]
    miss = own.shooting(at, up, turns)
    assert max(abs(miss[0]), abs(miss[1]) / 100.0) < 1e-9
    whole = np.array(own.monodromy(at, up, turns).tolist(), float)
    assert one["trace"] == pytest.approx(np.trace(whole), rel=1e-9)
    assert one["det"] == pytest.approx(np.linalg.det(whole), rel=1e-6)
    pulls = u >= 0.0
    gaps = [own.flight(at[0], up[0], s)[0] for s in np.linspace(0.0, TURN * turns, 400)[2:-2]]
    said = "would have to pull" if pulls else "penetrates the cam"
    return said in one["verdict"] and (pulls or min(gaps) < 0.0)


def ranges_are_stable(ranges: list, own: list[dict], events: list[dict]) -> bool:
    """The rows within are those with multipliers in the unit circle; ends are rows or events."""
    inside = [
        max(abs(complex(row[f"multiplier_{k}_re"], row[f"multiplier_{k}_im"])) for k in (1, 2))
        < 1.0 - 1e-6
        for row in own
    ]
    ends = {row["rpm"] for row in (*own, *events)}
    event_speeds = {row["rpm"] for row in events}
    covered = [any(low <= row["rpm"] <= high for low, high in ranges) for row in own]
    agree = all(
        stable == within
        for stable, within, row in zip(inside, covered, own, strict=True)
        if row["rpm"] not in event_speeds
    )
    return agree and all(end in ends for pair in ranges for end in pair)


def test_orbits():
    asked = {"rpm": {"start": 2620.0, "stop": 3010.0, "num": 8}, "at": 2700.0}
    scene = scene_at(900.0, run={"transient": 10, "record": 8}, orbits=asked)
    result = camcli.orbits(camcli.load_scene(scene), prove=True)
    branch, events = (rows_of(result.tables[name]) for name in ("branch", "bifurcations"))
    numbers = sorted({row["branch"] for row in branch})
    branches = []
    for number in numbers:
        own = [row for row in branch if row["branch"] == number]
        branches.append({
            "branch": number, "labels": sorted({row["label"] for row in own}),
            "origin": lambda text: text in ("found", "period-doubling"),
            "from": own[0]["rpm"], "to": own[-1]["rpm"], "points": len(own),
            # it ends at an event of its own, or where another branch begins, or with the range
            "ends": lambda ends, own=own: all(
                (end == "end-of-range") == (row["rpm"] in (2620.0, 3010.0))
                for end, row in zip(ends, (own[0], own[-1]), strict=True)
            ),
            "stable_ranges": lambda ranges, own=own: ranges_are_stable(ranges, own, events),
            "turning_points": [
                there["rpm"]
                for before, there, after in zip(own, own[1:], own[2:], strict=False)
                if (there["rpm"] - before["rpm"]) * (after["rpm"] - there["rpm"]) < 0.0
            ],
        })  # fmt: skip

    def event(row: dict[str, Any]) -> dict[str, Any]:
        tl, dl, tr, dr = (row[x] for x in ("trace_left", "det_left", "trace_right", "det_right"))
        born = [one["branch"] for one in result.summary["branches"] if one["origin"] == row["kind"]]
        corner = row["kind"] == "corner-impact"
        lefts = {
            "(1 - tau_L + delta_L)(1 - tau_R + delta_R) > 0": (1 - tl + dl) * (1 - tr + dr),
            "(1 + tau_L + delta_L)(1 + tau_R + delta_R) < 0": (1 + tl + dl) * (1 + tr + dr),
            "1 - tau_L + delta_L > 0": 1 - tl + dl, "1 + tau_L + delta_L > 0": 1 + tl + dl,
            "1 - tau_R + delta_R > 0": 1 - tr + dr, "1 + tau_R + delta_R > 0": 1 + tr + dr,
            "delta_L < 1": dl, "delta_R < 1": dr, "tau_L > 1 + delta_L": tl,
        }  # fmt: skip

        def inequalities(found: list[dict[str, Any]]) -> bool:
            for one in found:
                assert sorted(one) == ["holds", "left", "right", "text"]
                holds = (
                    one["left"] > one["right"] if ">" in one["text"] else one["left"] < one["right"]
                )
                assert one["holds"] == holds
                if "log growth" not in one["text"]:
                    assert one["left"] == pytest.approx(lefts[one["text"]], rel=1e-9)
            return bool(found) == corner

        return {
            "branch": row["branch"], "label": row["label"], "kind": row["kind"],
            "value": row["rpm"], "error": row["rpm_error"], "status": "ok",
            "corner": row["corner"], "classification": row["classification"],
            "continues_as_branch": born[0] if born else 0,
            "prediction_agrees": True if corner else None, "words": texts,
            "inequalities": inequalities,
        }  # fmt: skip

    def proof(low: float, high: float, box: Any) -> dict[str, Any]:
        return {
            "proved": True, "refuted": False, "failed_step": None, "box": box,
            "holds_for": lambda text: text in ("last-digit", "exact-data"),
            "value": lambda text: (text is None) == (low == high)
            and (text is None or low <= float(text.strip("[").split()[0]) <= high),
            "signs": lambda pairs: all(sign in (-1, 1) for _, sign in pairs),
            # a, b, c, d of each impact; the checker of certificates confirms that they hold
            "ellipses": lambda axes: axes is None or all(len(of_impact) == 4 for of_impact in axes),
            # tests/exact/test_certain_starts.py has the areas
            "area_m2_per_s": lambda area: area is None or area > 0.0,
            "share_of_window": lambda share: share is None or 0.0 < share <= 1.0,
        }  # fmt: skip

    def holds_phase(theta: list[float]) -> Any:
        """A box has phase (rad) and outgoing rate of each impact."""
        return lambda box: any(
            abs(float(text.strip("[").split()[0]) - theta[0] * RAD) < 1e-9 for text in box[::2]
        )

    def near(row: dict[str, Any]) -> list[float]:
        own = [one for one in branch if one["branch"] == row["branch"]]
        return orbit_record(min(own, key=lambda one: abs(one["rpm"] - row["rpm"])))["theta_deg"]

    at = [row for row in branch if row["rpm"] == 2700.0]
    with mp.workdps(30):
        machine = Machine.of(scene_at(2700.0))
        corners = [row for row in events if row["kind"] == "corner-impact"]
        assert corners
        assert all(signs_said(result.summary["words"], row) for row in corners)
        same(result.summary, {
            "status": "ok", "words": texts, "continua": [], "curves": [],
            "orbits": [orbit_record(row) for row in at],
            "virtual": lambda found: len(found) > 0 and all(is_virtual(machine, x) for x in found),
            "branches": branches, "bifurcations": [event(row) for row in events],
            "proofs": {
                "flank_excess_m": 0.0,  # a cam of circles alone has any
                "curves": [], "curve_ranges": [],
                "orbits": [proof(0.0, 0.0, holds_phase(orbit_record(x)["theta_deg"])) for x in at],
                "bifurcations": [
                    proof(row["rpm"] - row["rpm_error"], row["rpm"] + row["rpm_error"],
                          holds_phase(near(row)))
                    for row in events
                ],
                "ranges": lambda found: ranges_cover(found, branch, events),
            },
        }, close=1e-9)  # fmt: skip


def signs_said(words: list[str], row: dict[str, Any]) -> bool:
    """The sentence of a proved corner impact has the signs that its two linear parts give."""
    tl, dl, tr, dr = (row[x] for x in ("trace_left", "det_left", "trace_right", "det_right"))
    (said,) = (
        text for text in words if text.startswith(f"proved: corner-impact of {row['label']}")
    )
    products = {
        "(1 - tau_L + delta_L)(1 - tau_R + delta_R)": (1 - tl + dl) * (1 - tr + dr),
        "(1 + tau_L + delta_L)(1 + tau_R + delta_R)": (1 + tl + dl) * (1 + tr + dr),
    }
    return all(f"{text} {'>' if x > 0.0 else '<'} 0" in said for text, x in products.items())


def ranges_cover(found: list[dict[str, Any]], branch: list[dict], events: list[dict]) -> bool:
    """What is proved of whole ranges: each point of a branch lies in one that says what it is."""

    def value(text: str) -> float:
        return float(text.strip("[").split()[0])

    for one in found:
        assert sorted(one) == ["boxes", "branch", "failed_step", "high", "label", "low", "stable"]
        assert one["failed_step"] is None
        assert one["boxes"] >= 1
        low, high = value(one["low"]) + 1e-6, value(one["high"]) - 1e-6
        own = [row for row in branch if row["branch"] == one["branch"]]
        inside = [row for row in own if low < row["rpm"] < high]
        assert inside
        assert {bool(row["stable"]) for row in inside} == {one["stable"]}
        assert {row["label"] for row in inside} == {one["label"]}
        ends = [row["rpm"] for row in events] + [row["rpm"] for row in branch]
        assert all(min(abs(value(one[x]) - end) for end in ends) < 1e-6 for x in ("low", "high"))
    return len(found) >= len({row["branch"] for row in branch})


def test_classify():
    """Label, exponents and their sum, transient and counts; chaos by a longer run of its own."""
    rpms = [900.0, 1500.0, 2100.0, 2700.0]
    asked = {"rpm": {"start": 900.0, "stop": 2700.0, "num": 4}}
    scene = scene_at(900.0, run={"transient": 30, "record": 40}, classify=asked)
    result = camcli.classify(camcli.load_scene(scene))
    table, motions = result.tables["classify"], []
    rows = rows_of(table)
    for row, record in zip(rows, result.summary["motions"], strict=True):
        rpm, turns = row["rpm"], record["turns"]
        assert turns >= 40
        own = {**scene, "run": {**scene["run"], "rpm": rpm, "record": 20}}
        motion = motion_of(own)
        machine, label = motion.machine, label_of(motion, 30, 20)
        rests = any(event.kind == "chatter" for event in motion.events)
        hits = [e for e in motion.events if e.kind == "impact" and e.at >= TURN * 30]
        exponent, per_turn = exponent_of(motion, 49, label), len(hits) / 20
        decay = machine.damping * 60.0 / rpm / machine.mass
        chaos = label == "undecided"
        if chaos:
            label, exponent, per_turn = "aperiodic", *growth(machine, 30, 400)
        rule = 2 * np.log(machine.restitution) * per_turn - decay
        error = 0.0 if not chaos else record["exponents"]["standard_error"]
        assert 0.0 < error < 0.2 or not chaos
        wide = 4.0 * error + (0.1 if chaos else 1e-5)
        near = lambda x, size=wide: lambda found: abs(float(found) - x) <= size  # noqa: E731
        pair = [0.0, 0.0]
        if not chaos and not rests:
            q, v, _ = motion.state(TURN * 49)
            once = Motion(machine, 1, machine.strobe / RAD, q, v)
            pair = sorted(np.linalg.eigvals(multipliers(machine, once, 1)),
                          key=lambda z: (-abs(z), -z.imag))  # fmt: skip
        impacts = "inf" if rests else near(per_turn) if chaos else per_turn
        motions.append({
            "value": rpm, "rpm": rpm, "label": label, "period": 0 if chaos else 1,
            "impacts": impacts, "chatter": "complete" if rests else "none",
            "stable": None if chaos else True,
            "transient_turns": None if chaos else
            lambda found, motion=motion: settles(motion, found),
            "status": "ok",
            "start": {"q": None, "v": None, "theta_deg": 0.0, "place": "run.start"},
            "holds_for": None, "watched_turns": turns + 20_000 + 30 if chaos else None,
            "turns": turns, "complete_chatters": turns if rests else 0,
            "multipliers": None if chaos else [near_complex(z) for z in pair],
            "exponents": {
                "largest": "-inf" if rests else near(exponent),
                "second": "-inf" if rests else near(rule - exponent),
                "standard_error": error,
                "sum_rule": "-inf" if rests else near(rule),
                "defect": None if rests else lambda found: abs(found) < 1e-12,
            },
        })  # fmt: skip
        assert row["label"] == label
        assert (row["period"], row["chatter"], row["status"]) == (
            0 if chaos else 1, "complete" if rests else "none", "ok",
        )  # fmt: skip
        assert row["impacts"] == (np.inf if rests else pytest.approx(per_turn, abs=wide))
        assert row["stable"] == 1.0 or (chaos and np.isnan(row["stable"]))
        assert row["lyapunov_per_period"] == pytest.approx(exponent, abs=wide)
        assert row["holds_for"] == ""
        assert np.isnan(row["watched_turns"]) != chaos
    assert [row["rpm"] for row in rows] == rpms
    columns = ["rpm", "label", "period", "impacts", "chatter", "stable", "lyapunov_per_period",
               "status", "holds_for", "watched_turns", "lyapunov_error_per_period"]  # fmt: skip
    assert list(table) == columns
    never = [m["watched_turns"] for m in result.summary["motions"] if m["label"] == "aperiodic"]
    (over, rarer) = re.search(
        r"aperiodic was followed for (\d+) turns .* is rarer than once in (\d+) turns",
        " ".join(result.summary["words"]),
    ).groups()
    assert int(over) == min(never)
    assert np.exp(-int(over) / int(rarer)) == pytest.approx(0.05, rel=0.04)
    same(result.summary, {"status": "ok", "words": texts, "motions": motions}, close=1e-9)


def test_costs_are_summed_each_by_itself():
    assert Cost(1, 20, 300) + Cost(4000, 50000, 600000) == Cost(4001, 50020, 600300)


def test_costs_count_every_run():
    """Impacts of all speeds and ways of a sweep; of classify also those that tell its transient."""
    run, rpm = {"transient": 30, "record": 10}, {"start": 1500.0, "stop": 2700.0, "num": 2}
    scene = scene_at(900.0, run=run, sweep={"rpm": rpm, "direction": "both"}, classify={"rpm": rpm})
    counted = 0
    for rpms in ((1500.0, 2700.0), (2700.0, 1500.0)):
        state: dict[str, float] = {}
        for one in rpms:
            record = Record(scene, one, **state)
            counted += sum(event.kind == "impact" for event in record.motion.events)
            state = {"begin_deg": 77.0, **record.end()}
    assert camcli.sweep(camcli.load_scene(scene)).cost.impacts == counted
    result = camcli.classify(camcli.load_scene(scene))
    turns = [2 * 30 + motion["turns"] + 2 * 64 for motion in result.summary["motions"]]
    assert result.cost.impacts == pytest.approx(3 * turns[0] + 1 * turns[1], rel=0.03)


def near_complex(z: complex) -> list[Any]:
    """[re, im] to the accuracy of a motion that still settles."""
    return [lambda x: abs(x - z.real) < 1e-4, lambda y: abs(y - z.imag) < 1e-4]


def settles(motion: Motion, turns: int) -> bool:
    """After so many turns the state at the strobe stays near its end, not much earlier."""
    states = np.array([motion.state(TURN * n)[:2] for n in range(50)])
    off = np.abs(states - states[-1]).max(1) / np.abs(states).max()
    near = off[turns] < 1e-4 if turns < 50 else True
    return bool(near and (turns == 0 or off[turns - 1] > 1e-12))


def growth(machine: Machine, skip: int, turns: int) -> tuple[float, float]:
    """(largest exponent per turn, impacts per turn) of a motion from rest, after `skip` turns."""
    motion = Motion(machine, skip + turns)
    at = [e.at for e in motion.events if e.kind == "impact" and e.at >= TURN * skip]
    up = [e.u_plus for e in motion.events if e.kind == "impact" and e.at >= TURN * skip]
    own, vector, total, last = Exact(machine, machine.rpm), np.array([1.0, 1.0]), 0.0, at[0]
    with mp.workdps(15):
        for x, rate in zip(at, up, strict=True):
            step = own.saltation(mpf(x), mpf(rate)) * own.matrix(mpf(x - last))
            vector = np.array(step.tolist(), float) @ vector
            size = np.hypot(vector[0], vector[1] / machine.omega)
            total, vector, last = total + np.log(size), vector / size, x
    return total / ((at[-1] - at[0]) / TURN), len(at) / turns
