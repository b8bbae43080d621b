"""What the standard cases leave as it is by default: margins, tolerances, what is varied, periods.

Values are those of the machine of tests/truth/mechanics, which is written once more.
"""

from __future__ import annotations

import re
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import camcli
from camcli.api.machine import machine_of
from tests.support import oracle
from tests.support.mechanics import TURN, Machine
from tests.truth.test_columns import least_preload, scene_at

CONFIGS = Path(__file__).parents[2] / "configs"
FEW = {
    "detach.rpm": {"start": 3400.0, "stop": 3500.0, "num": 2},
    "detach.settle": 0,
    "detach.impacts": 0,
}
LIMIT = 1500.0  # rpm that a spring shall hold to


def detached(**detach: Any) -> camcli.api.result.Result:
    """What `detach` finds, with nothing but springs and tolerances."""
    asked = {"rpm": {"start": 650.0, "stop": 660.0, "num": 2}, "impacts": 0, "settle": 0}
    return camcli.detach(camcli.load_scene(scene_at(900.0, detach={**asked, **detach})))


# -- the margin of a spring ----------------------------------------------------------------------


@pytest.mark.parametrize("margin", [0.0, 7.0, None])
def test_a_spring_leaves_the_margin_that_is_asked_for(margin):
    """With none it loses contact at the very speed; by default a tenth of what is needed is left.

    What is needed is the pull of inertia and damping at its worst.
    """
    found = detached(hold_to=LIMIT, margin_n=margin)
    machine = Machine.of(scene_at(LIMIT))
    inertia = replace(machine, stiffness=0.0, gravity=0.0, preload=0.0)
    ways = [inertia.extreme_force(0.0, TURN, -1)[0], 0.0]
    told = found.values.margin
    if margin is None:
        assert 0.0 < told <= -0.1 * min(ways) * (1.0 + 1e-9)
    else:
        assert told == margin
    rows = {str(row["quantity"]): row for row in found.summary["hold"]}
    for name, per_preload in (("hold_preload", 0.0), ("hold_both", 5200.0 / 60.0)):
        preload, *_ = least_preload(machine, LIMIT, told, per_preload)
        row = rows[name]
        assert row["preload"] == pytest.approx(preload, rel=1e-9)
        own = replace(machine, preload=preload, stiffness=row["stiffness"])
        assert row["detaches_rpm"] == pytest.approx(own.first_loss(), rel=1e-9)
        assert row["least_n"] == pytest.approx(told, abs=1e-9)
        if margin == 0.0:
            assert row["detaches_rpm"] == pytest.approx(LIMIT, rel=1e-9)
        else:
            assert row["detaches_rpm"] > LIMIT * (1.0 + 1e-4)


# -- a tolerance on each constant ----------------------------------------------------------------

CONSTANTS = [
    "follower.mass", "follower.stiffness", "follower.damping", "follower.gravity",
    "follower.preload", "follower.restitution", "cam.base", "cam.lift", "cam.rise.length_deg",
    "cam.rise.start_deg", "cam.top_dwell_deg", "cam.fall.length_deg",
]  # fmt: skip


def with_value(key: str, value: float) -> dict[str, Any]:
    """The scene with one number changed."""
    section, *names = key.split(".")
    scene = scene_at(900.0)
    place = scene[section] = dict(scene[section])
    for name in names[:-1]:
        place[name] = dict(place[name])
        place = place[name]
    place[names[-1]] = value
    return scene


@pytest.mark.parametrize("key", CONSTANTS)
def test_a_tolerance_on_each_constant(key):
    """Both ends and what lies between: the speed to which each machine holds, and the worst one."""
    found = detached(
        hold_to=LIMIT, margin_n=0.0, tolerance=[{"key": key, "percent": 4.0}], machines=3
    )
    table = found.tables["tolerance"]
    place: Any = scene_at(900.0)
    for name in key.split("."):
        place = place[name]
    assert sorted(table[key][:2]) == pytest.approx(sorted([0.96 * place, 1.04 * place]))
    assert len(table[key]) == 5
    nominal, (spring,) = Machine.of(scene_at(900.0)), [
        row for row in found.summary["hold"] if row["quantity"] == "hold_both"
    ]  # fmt: skip
    held = []
    for value, first, both in zip(
        table[key], table["first_detachment_rpm"], table["hold_both_rpm"], strict=True
    ):
        own = Machine.of(with_value(key, float(value)))
        assert first == pytest.approx(own.first_loss(), rel=1e-9)
        stiffer = spring["stiffness"] * own.stiffness / nominal.stiffness
        harder = spring["preload"] * own.preload / nominal.preload
        held.append(replace(own, stiffness=stiffer, preload=harder).first_loss())
        assert both == pytest.approx(held[-1], rel=1e-9)
    told = found.summary["tolerance"]
    assert told["worst_rpm"] == min(table["first_detachment_rpm"])
    assert told["median_rpm"] == sorted(table["first_detachment_rpm"][2:])[1]
    assert told["springs"]["hold_both"]["worst_rpm"] == pytest.approx(min(held), rel=1e-9)
    share = np.mean([rpm >= LIMIT for rpm in table["hold_both_rpm"][2:]])
    assert told["springs"]["hold_both"]["chance"] == pytest.approx(share)


# -- the +- of a verdict -------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [0.3, 1.7])
def test_the_error_in_a_verdict_reaches_both_ends(factor):
    """Both ends of the range that a measured cam leaves are said, to half of their last digit."""
    scene = camcli.load_scene(
        str(CONFIGS / "lift-table.yaml"), {"follower.preload": 260.0 * factor, **FEW}
    )
    result = camcli.detach(scene)
    low, high = result.error["lift_table"]["first_detachment_rpm"]
    assert low < result.values.detachment.first.rpm < high
    (said,) = re.findall(
        r"holds up to (\S+) rpm of .* its table leaves (\S+) to (\S+) rpm", result.verdict[0]
    )
    half = 0.5 * 10.0 ** -len(said[1].partition(".")[2])
    wanted = result.values.detachment.first.rpm, low, high
    assert [float(x) for x in said] == pytest.approx(wanted, rel=0.0, abs=1.001 * half)
    assert half < 0.06 * (high - low)


# -- another number than the speed ---------------------------------------------------------------

VARIED = {
    "follower.restitution": (0.3, 0.7), "follower.preload": (50.0, 70.0),
    "cam.lift": (0.011, 0.013), "cam.rise.start_deg": (30.0, 50.0), "run.strobe_deg": (10.0, 200.0),
    "run.transient": (3, 9), "run.start.theta_deg": (20.0, 300.0),
}  # fmt: skip


def told(column: np.ndarray) -> np.ndarray:
    """A column in which no cell is filled is one of numbers, among words it is of empty ones.

    With an empty cell one of whole numbers is one of floats.
    """
    if column.dtype.kind not in "iuf":
        return column
    numbers = column.astype(float)
    return np.where(np.isnan(numbers), "", numbers.astype(str))


TABLES = {"sweep": ("speeds", "impacts", "strobe"), "classify": ("classify",)}


@pytest.mark.parametrize("key", VARIED)
def test_a_row_is_the_machine_with_that_number(key):
    """Sweep and classify: each row, and all that was recorded there, as of a scene that has it."""
    axis = {"key": key, "start": VARIED[key][0], "stop": VARIED[key][1], "num": 2}
    for command in ("sweep", "classify"):
        whole = getattr(camcli, command)(
            camcli.load_scene(scene_at(1500.0, **{command: {"vary": [axis]}}))
        )
        for value in VARIED[key]:
            one = {"rpm": {"start": 1500.0, "stop": 1500.0, "num": 1}}
            scene = camcli.load_scene(scene_at(1500.0, **{command: one}), {key: value})
            single = getattr(camcli, command)(scene)
            for name in TABLES[command]:
                table, own = single.tables[name], whole.tables[name]
                mine = own[key] == value
                assert mine.sum() == table.rows
                for column in table:
                    if column != "rpm":
                        found, wanted = (told(x) for x in (own[column][mine], table[column]))
                        np.testing.assert_array_equal(found, wanted, column)


# -- long periods, many points -------------------------------------------------------------------

LONG = 358.12815789473683  # rpm of a cycle of 151 turns through one rest


def long_cycle() -> tuple[str, list[float]]:
    """Its label, as classify has it, and the impacts in its turns from the rest on."""
    one = {"start": LONG, "stop": LONG, "num": 1}
    scene = camcli.load_scene(None, {"classify.rpm": one, "run.transient": 300, "run.record": 100})
    table = camcli.classify(scene).tables["classify"]
    (name,), (period,), (impacts,) = table["label"], table["period"], table["impacts"]
    counts = [float(x) for x in str(name)[2:-1].partition(";")[2].split(":")]
    assert str(name).startswith(f"P({len(counts)};inf:")
    assert (period, impacts, len(counts), counts.count(inf)) == (len(counts), inf, 151, 1)
    return str(name), counts


def test_a_period_of_151_turns_is_recorded_turn_by_turn():
    """A sweep shows two whole periods of it; the same impacts come back, at the same phases."""
    name, counts = long_cycle()
    one = {"start": LONG, "stop": LONG, "num": 1}
    values = {"sweep.rpm": one, "run.transient": 300, "run.record": 302}
    found = camcli.sweep(camcli.load_scene(None, values)).tables
    assert found["speeds"]["label"][0] == name
    rests, impacts = found["strobe"]["chatter"] == 1, found["strobe"]["impacts"]
    (first, second) = np.flatnonzero(rests)
    assert second - first == 151
    turned = np.roll(impacts[:151], -first)
    np.testing.assert_array_equal(turned[1:], counts[1:])
    np.testing.assert_array_equal(impacts[:151], impacts[151:])
    theta, turn = found["impacts"]["theta_deg"], found["impacts"]["period"]
    np.testing.assert_array_equal(theta[turn < 151], theta[turn >= 151])


@pytest.mark.soak
def test_a_period_of_151_turns_is_the_oracles():
    """From the rest at corner b, in 300 digits: so many impacts in each turn, and then the rest."""
    _, counts = long_cycle()
    with mp.workdps(60):  # as the package closes the circles
        cam = oracle.ArcsCam(flank_radius=mpf(0.4) + mpf(0.45), digits=400)
    machine = oracle.Oracle(
        cam, mass=1.221, stiffness=1430.8, restitution=0.8, rpm=LONG, digits=300
    )
    events = machine.run(theta=2.6, turns=152)
    first = next(event.turn for event in events if event.kind == "chatter")
    assert first == 151  # shortly before corner b, where the next one begins
    hits = [event.turn for event in events if event.kind == "impact"]
    found = [hits.count(k) for k in range(1, 151)]
    assert found == [int(x) for x in counts[1:]]


@pytest.mark.soak
@pytest.mark.parametrize("points", [2_000, 20_000])
def test_many_points(points, tmp_path):
    """Every hundredth or so as it is alone; as many rows as speeds, and pictures of them."""
    short = {"run.transient": 30, "run.record": 4}
    axis = {"start": 660.0, "stop": 760.0, "num": points}
    whole = camcli.sweep(camcli.load_scene(None, {**short, "sweep.rpm": axis}))
    speeds = whole.tables["speeds"]
    np.testing.assert_allclose(speeds["rpm"], np.linspace(660.0, 760.0, points), rtol=1e-15)
    assert whole.tables["strobe"].rows == 4 * points
    assert speeds["impacts"].sum() == whole.tables["impacts"].rows
    for k in range(0, points, points // 40):
        rpm = float(speeds["rpm"][k])
        one = {"start": rpm, "stop": rpm, "num": 1}
        single = camcli.sweep(camcli.load_scene(None, {**short, "sweep.rpm": one}))
        for name in ("speeds", "strobe", "impacts"):
            own, mine = single.tables[name], whole.tables[name]["rpm"] == rpm
            for column in own:
                np.testing.assert_array_equal(whole.tables[name][column][mine], own[column])
    whole.save(tmp_path)
    assert (tmp_path / "sweep.png").stat().st_size > 10_000


@pytest.mark.parametrize(("asked", "leave"), [(0, 0), (1, 1), (9, 1)])
def test_so_many_branches_leave_beside_those_that_were_found(asked, leave):
    """Two orbits are found, and one of them doubles its period at 739.32 rpm."""
    values = {
        "orbits.rpm": {"start": 730.0, "stop": 760.0, "num": 16}, "orbits.at": 735.0,
        "orbits.branches": asked, "orbits.starts": 4,
    }  # fmt: skip
    branches = camcli.orbits(camcli.load_scene(None, values)).summary["branches"]
    assert [one["origin"] for one in branches] == ["found"] * 2 + ["period-doubling"] * leave


def test_undecided_cells_are_those_of_all_speeds():
    rpm = {"start": 358.0, "stop": 359.0, "num": 2}
    values = {"basins.rpm": rpm, "basins.cells": [8, 6], "basins.budget": 6}
    result = camcli.basins(camcli.load_scene(None, values))
    open_ = [
        round(sum(result.tables["basins"]["attractor"][result.tables["basins"]["rpm"] == x] == 0))
        for x in (358.0, 359.0)
    ]
    assert min(open_) > 0
    assert result.notes[-1].startswith(
        f"{sum(open_)} of 96 cells are undecided: they met no attractor within 6 turns; "
    )


def test_every_key_of_a_run_and_of_the_follower_reaches_the_machine():
    run = {"transient": 11, "record": 12, "chatter_tolerance": 1e-7, "impact_budget": 1234,
           "patience": 1500}  # fmt: skip
    constants = {"mass": 1.25, "stiffness": 321.0, "damping": 0.75, "gravity": 9.5, "preload": 8.5,
                 "restitution": 0.625}  # fmt: skip
    values = {
        **{f"run.{key}": value for key, value in run.items()},
        **{f"follower.{key}": value for key, value in constants.items()},
        "run.start": {"q": 0.9, "v": -1.5}, "run.strobe_deg": 40.0,
    }  # fmt: skip
    machine = machine_of(camcli.load_scene(None, values))
    assert {key: getattr(machine.settings, key) for key in run} == run
    assert (machine.settings.start.q, machine.settings.start.v) == (0.9, -1.5)
    assert {key: getattr(machine.system.follower, key) for key in constants} == constants
    assert np.degrees(machine.system.strobe) == pytest.approx(40.0, rel=1e-14)
