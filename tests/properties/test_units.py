"""Units have no say, nor has the phase at which the turn begins: whole commands, table by table.

The same machine is asked in other units of length, mass and time (powers of two, so that its
numbers round alike), and with the cam, the strobe and the start turned by some degrees. Each column
and each number of the summary then is what its name says: scaled by its unit, shifted if it is a
phase at the cam, and else the same. Who forgets the strobe, a wrap, a factor omega or a mass, or
compares a length with a number of no unit, is found wherever that enters.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

import camcli

pytestmark = pytest.mark.slow
SCENE = {
    "follower": {"mass": 0.35, "stiffness": 5200.0, "damping": 6.0, "gravity": 9.81,
                 "preload": 60.0, "restitution": 0.6},
    "cam": {"kind": "law", "base": -0.004, "lift": 0.012,
            "rise": {"start_deg": 40.0, "length_deg": 75.0, "law": "harmonic"},
            "top_dwell_deg": 25.0, "fall": {"length_deg": 65.0, "law": "3-4-5"}},
    "run": {"strobe_deg": 77.0, "transient": 20, "record": 12, "rpm": 2700.0,
            "start": {"q": 0.02, "v": 0.5, "theta_deg": 30.0}},
}  # fmt: skip


class Units(NamedTuple):
    """How many of the new units are one of the old ones, and by how many degrees all is turned."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0
    turned: float = 0.0

    @property
    def force(self) -> float:
        return self.mass * self.length / self.time**2

    def factor(self, name: str) -> float:
        """Of a number with this name, or a column of the n-th impact."""
        speed, name = self.length / self.time, name.rstrip("0123456789").removesuffix("_")
        for ending, factor in (
            ("n_per_m", self.mass / self.time**2), ("m_per_s", speed), ("rad_per_s", 1 / self.time),
            ("_pa", self.force / self.length**2), ("_n", self.force), ("_m", self.length),
            ("_s", self.time), ("rpm", 1 / self.time),
        ):  # fmt: skip
            if name.endswith(ending):
                return factor
        if name in SPEEDS:
            return 1 / self.time
        own = {"q": self.length, "v": speed, "preload": self.force}
        return {**own, "stiffness": self.mass / self.time**2}.get(name, 1.0)


SPEEDS = (
    "value",
    "error",
    "rpm_error",
    "rpm_low",
    "rpm_high",
    "from",
    "to",
    "stable_ranges",
    "turning_points",
    "stable_from",
    "stable_to",
    "low",
    "high",
)
PHASES = ("theta_deg", "contact_lost_deg", "contact_regained_deg", "landing_deg")
ERRORS = ("rpm_error", "error")  # only as large


def in_units(units: Units, **changes: dict[str, Any]) -> Any:
    """The machine with some values of its sections, in other units and turned."""
    scene = {key: dict(value) for key, value in SCENE.items()}
    for key, value in changes.items():
        scene[key] = {**scene.get(key, {}), **value}
    length, mass, time = units[:3]
    own, cam, run = scene["follower"], scene["cam"], scene["run"]
    for name, factor in (
        ("mass", mass), ("stiffness", mass / time**2), ("damping", mass / time),
        ("gravity", length / time**2), ("preload", units.force),
    ):  # fmt: skip
        own[name] *= factor
    cam["base"] *= length
    cam["lift"] *= length
    cam["rise"] = {**cam["rise"], "start_deg": (cam["rise"]["start_deg"] + units.turned) % 360.0}
    run["rpm"] /= time
    run["strobe_deg"] = (run["strobe_deg"] + units.turned) % 360.0
    run["start"] = {
        "q": run["start"]["q"] * length, "v": run["start"]["v"] * length / time,
        "theta_deg": (run["start"]["theta_deg"] + units.turned) % 360.0,
    }  # fmt: skip
    for section in scene.values():
        for name, factor in (
            ("rpm", 1 / time), ("q", length), ("v", length / time), ("margin_n", units.force),
            ("hold_to", 1 / time), ("at", 1 / time), ("force_rpm", 1 / time),
            ("precompression_m", length),
        ):  # fmt: skip
            value = section.get(name)
            if isinstance(value, dict):
                ends = {end: value[end] * factor for end in ("start", "stop")}
                section[name] = {**value, **ends}
            elif isinstance(value, list):
                section[name] = [x * factor for x in value]
            elif value is not None and section is not run:
                section[name] = value * factor
        if "zoom" in section:
            section["zoom"] = [
                {**part, "start": part["start"] / time, "stop": part["stop"] / time}
                for part in section["zoom"]
            ]
        if "also" in section:
            section["also"] = [
                {"q": one["q"] * length, "v": one["v"] * length / time,
                 "theta_deg": (one["theta_deg"] + units.turned) % 360.0}
                for one in section["also"]
            ]  # fmt: skip
    return camcli.load_scene(scene)


def turned_to(name: str) -> bool:
    """Whether a name is that of a phase at the cam."""
    return name in PHASES or name.startswith("theta_deg_") or name.endswith("_deg")


def same_number(a: float, b: float, name: str, units: Units, where: str) -> None:
    """Whether b, in the units, is a."""
    if not math.isfinite(a) or not math.isfinite(b):
        assert str(a) == str(b), (where, a, b)
    elif turned_to(name):
        off = (b - a - units.turned + 180.0) % 360.0 - 180.0
        assert abs(off) < 1e-6, (where, a, b)
    else:
        wanted = a * units.factor(name)
        close = 0.5 if name in ERRORS else 1e-6
        assert b == pytest.approx(wanted, rel=close, abs=FLOOR), (where, a, b, wanted)


FLOOR = 1e-11  # what is smaller is rounding of larger numbers
SAID = ("words", "place", "points")  # sentences, in which numbers have their own units
ROUNDED = ("box", "enclosure_low", "enclosure_high")


def same_record(a: Any, b: Any, units: Units, name: str = "", where: str = "result") -> None:
    """Whether a value of a summary is the same in the units."""
    if name in SAID or name in ROUNDED:
        return
    if units.turned and (name == "least_force" or where.startswith("result.hold")):
        return  # a dwell has one force all along, and the first of its phases is told
    if isinstance(a, dict):
        assert list(map(str, a)) == list(map(str, b)), where
        for key in a:
            same_record(a[key], b[key], units, str(key), f"{where}.{key}")
    elif name == "virtual":  # in the order of their phases
        order = sorted(a, key=lambda one: one["trace"]), sorted(b, key=lambda one: one["trace"])
        same_record(*map(list, order), units, "", where)
    elif name.endswith("q_m_v_m_per_s") and len(a) == 2 and not isinstance(a[0], list):
        for key, one, other in zip(("q_m", "v_m_per_s"), a, b, strict=True):
            same_record(one, other, units, key, f"{where}.{key}")
    elif isinstance(a, list | tuple):
        assert len(a) == len(b), (where, a, b)
        for k, (one, other) in enumerate(zip(a, b, strict=True)):
            same_record(one, other, units, name, f"{where}[{k}]")
    elif isinstance(a, complex):
        assert abs(a - b) < 1e-6, (where, a, b)
    elif isinstance(a, bool | str | None):
        assert a == b, (where, a, b)
    else:
        same_number(float(a), float(b), name, units, where)


def same_tables(a: Any, b: Any, units: Units) -> None:
    """Whether each column of each table is the same in the units."""
    assert list(a.tables) == list(b.tables)
    for table in a.tables:
        one, other = dict(a.tables[table]), dict(b.tables[table])
        assert list(one) == list(other)
        if table == "branch":
            one, other = common_points(one, other)
        if table == "force" and units.turned:  # sampled from the begin of a turn on
            continue
        for column in one:
            where, left, right = f"{table}.{column}", one[column], other[column]
            assert len(left) == len(right), where
            for x, y in zip(left.tolist(), right.tolist(), strict=True):
                if isinstance(x, str):
                    assert x == y, (where, x, y)
                else:
                    same_number(x, y, column, units, where)


def common_points(one: dict, other: dict) -> tuple[dict, dict]:
    """The points that two tables of branches share, but those of events, whose stability is open.

    Steps may end at the begin of a turn, so one of them may have a point more.
    """
    rows = []
    for table in (one, other):
        trace, det = table["trace"], table["det"]
        clear = np.minimum(abs(1.0 - trace + det), abs(1.0 + trace + det)) > 1e-6
        own = table["branch"], table["label"], np.round(trace, 6), np.round(det, 6)
        rows.append({key: k for k, key in enumerate(zip(*own, strict=True)) if clear[k]})
    both = [key for key in rows[0] if key in rows[1]]
    assert len(both) > 0.7 * max(len(one["rpm"]), len(other["rpm"]))
    kept = [[own[key] for key in both] for own in rows]
    first, second = ({c: t[c][k] for c in t} for t, k in zip((one, other), kept, strict=True))
    return first, second


SCALED = Units(2.0**-7, 2.0**5, 2.0**-3)
TURNED = Units(turned=163.0)  # the strobe is then at 240 deg, the rise begins at 203
ASKED = {
    "simulate": [
        {"run": {"rpm": rpm}, "simulate": {"samples": 24}} for rpm in (650.0, 900.0, 2700.0)
    ] + [{"run": {"rpm": 900.0, "impact_budget": 3, "transient": 0}, "simulate": {"samples": 24}}],
    "sweep": [
        {"run": {"impact_budget": 3, "rpm": 2700.0, "transient": 0},
         "sweep": {"rpm": {"start": 900.0, "stop": 2700.0, "num": 3}}},
        {"sweep": {"rpm": {"start": 2620.0, "stop": 3000.0, "num": 4}, "direction": "both",
                   "also": [{"q": 0.03, "v": 0.2, "theta_deg": 100.0}], "lyapunov": True,
                   "zoom": [{"start": 2650.0, "stop": 2660.0, "num": 2}]}},
        {"run": {"start": {"q": 0.009, "v": 1.0, "theta_deg": 350.0}},
         "sweep": {"rpm": {"start": 650.0, "stop": 900.0, "num": 3}}},
    ],
    "detach": [
        {"detach": {"rpm": {"start": 600.0, "stop": 1000.0, "num": 3}, "hold_to": 1500.0,
                    "impacts": 2, "margin_n": 5.0, "force_rpm": [500.0, 800.0]}},
    ],
    "orbits": [
        {"orbits": {"rpm": {"start": 2620.0, "stop": 3010.0, "num": 8}, "at": 2700.0}},
    ],
    "basins": [
        {"basins": {"rpm": {"start": 2700.0, "stop": 2700.0, "num": 1}, "q": [0.009, 0.05],
                    "v": [-3.0, 3.0], "cells": [14, 12], "exponents": True}},
    ],
    "classify": [
        {"classify": {"rpm": {"start": 2620.0, "stop": 3000.0, "num": 3}, "starts": 2,
                      "explain": True}},
    ],
}  # fmt: skip
RUNS = [(name, k) for name, asked in ASKED.items() for k in range(len(asked))]


@pytest.fixture(autouse=True)
def _compiled(monkeypatch):
    """What is little work is done by the plain kernel else, which takes longer here."""
    monkeypatch.setenv("CAMCLI_KERNEL", "compiled")


@pytest.mark.parametrize("units", [SCALED, TURNED], ids=["units", "turned"])
@pytest.mark.parametrize(("name", "k"), RUNS)
def test_a_command_says_the_same(name, k, units):
    ask, changes = getattr(camcli, name), ASKED[name][k]
    a, b = (ask(in_units(one, **changes)) for one in (Units(), units))
    same_tables(a, b, units)
    same_record(a.summary, b.summary, units)
    assert len(a.notes) == len(b.notes)
    assert a.complete == b.complete
