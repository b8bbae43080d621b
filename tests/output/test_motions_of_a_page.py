"""Which motions stand on a page of `cam explore`, from results made here, and what it asks for."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from math import pi
from types import SimpleNamespace as Made

import numpy as np
import pytest

import camcli
from camcli.analysis.labels import Label
from camcli.api import explore, explore_motions, explore_page
from camcli.api.explore_motions import (
    NONE,
    PageMotion,
    axes_of_map,
    labels_of_codes,
    motions_from_starts,
    motions_of_a_map,
    solved_motions,
    start_of,
)
from camcli.api.machine import machine_of
from camcli.api.orbit_question import question_of, varied_by
from camcli.errors import Fault, Status

SLOPE = 0.25  # of the lift at the strobe, m/rad
CAM = Made(strobe=0, stretches=[Made(start_c=0.5, start_c1=SLOPE)])
RPM = 60.0 / pi  # two radians a second


def machine(**scene):
    return Made(system=Made(cam=CAM), scene=Made(**scene))


@pytest.mark.parametrize(
    ("state", "start"),
    [
        ((0.5, 2.0 * SLOPE), (None, None)),
        ((0.5 - 1e-16, 2.0 * SLOPE), (None, None)),  # rounding
        ((0.5, 2.0 * SLOPE * (1.0 + 1e-13)), (None, None)),
        ((0.5, 2.0 * SLOPE * (1.0 + 1.5e-12)), (0.5, 2.0 * SLOPE * (1.0 + 1.5e-12))),
        ((0.5, 2.0 * SLOPE * (1.0 + 1e-11)), (0.5, 2.0 * SLOPE * (1.0 + 1e-11))),
        ((0.5 - 1e-16, -1.0), (0.5, -1.0)),  # on the cam, and an impact begins here
        ((0.5 + 1e-9, 2.0 * SLOPE), (0.5 + 1e-9, 2.0 * SLOPE)),
    ],
)
def test_a_follower_that_goes_with_the_cam_starts_at_rest_on_it(state, start):
    assert start_of(machine(), RPM, *state) == start


def orbit(rpm, stable, q=1.0, label=None):
    return Made(rpm=rpm, stable=stable, states=[(q, 3.0), (q, 9.0)],
                label=label or Label((1.0, 2.0)))  # fmt: skip


def found_orbits(branches, orbits=(), span=True, known=(), **speeds):
    """(rpm, stable) of the solved motions of a page from 100 to 140 rpm by tens."""
    values = Made(branches=[Made(points=points) for points in branches], orbits=orbits,
                  question=Made(span=span))  # fmt: skip
    rpm = Made(**({"start": 100.0, "stop": 140.0, "num": 5} | speeds))
    own = machine(sweep=Made(rpm=rpm))
    return solved_motions(own, Made(values=values), list(known))


def test_a_branch_has_a_motion_for_each_step_of_the_speeds():
    """And where its stability changes; each branch begins anew."""
    one = [orbit(x, x < 117.0) for x in (100.0, 104.0, 109.9, 110.0, 115.0, 118.0, 122.0, 128.0)]
    other = [orbit(x, True) for x in (127.0, 117.0, 107.1)]
    found = found_orbits([one, other])
    assert [(m.rpm, m.stable) for m in found] == [
        (100.0, True), (110.0, True), (118.0, False), (128.0, False), (127.0, True), (117.0, True),
    ]  # fmt: skip
    down = found_orbits([one, other], start=140.0, stop=100.0)
    assert [m.rpm for m in down] == [m.rpm for m in found]
    for motion in found:
        v = 3.0 * motion.rpm * pi / 30.0
        assert (motion.q, motion.v, motion.turns, motion.loops) == (1.0, pytest.approx(v), 2, True)
        assert (motion.origin, motion.exponent, motion.place) == ("solved", None, None)
        assert [x.tolist() for x in motion.strobes] == [[1.0], [pytest.approx(v)]]
        assert motion.impacts is NONE


def test_without_a_range_every_orbit_is_shown():
    orbits = [orbit(120.0, True, q) for q in (1.0, 2.0)]
    assert [m.q for m in found_orbits([[orbit(110.0, True)]], orbits, span=None)] == [1.0, 2.0]


def known_motion(rpm, q=1.0, label=None, at=None):
    """What a sweep has found at this speed, with a state at the strobe of this orbit."""
    v = 3.0 * (at or rpm) * pi / 30.0
    return PageMotion(rpm, label or Label((1.0, 2.0)), "up", q, v, 2, True, True, -1.0, None,
                      NONE, (np.array([7.0, q]), np.array([0.0, v])))  # fmt: skip


@pytest.mark.parametrize(
    ("orbit_at", "known", "shown"),
    [
        (orbit(120.0, True), known_motion(120.0), False),
        (orbit(120.0, False), known_motion(120.0), True),  # a sweep finds no unstable one
        (orbit(120.0, True, label=Label((1.0, 1.0))), known_motion(120.0), True),
        (orbit(120.0, True), known_motion(120.0, q=1.05), False),  # a hundredth of 7
        (orbit(120.0, True), known_motion(120.0, q=1.2), True),
        (orbit(115.0, True), known_motion(120.0, at=115.0), False),  # half a step away
        (orbit(114.9, True), known_motion(120.0, at=114.9), True),
    ],
)
def test_a_stable_orbit_is_not_shown_again_where_a_sweep_has_found_it(orbit_at, known, shown):
    found = found_orbits([[orbit_at]], known=[known_motion(100.0, q=9.0), known])
    assert len(found) == shown


@pytest.mark.parametrize(
    ("count", "chosen"),
    [
        (1, [0]),
        (3, [0, 1, 2]),
        (16, range(16)),
        (17, [0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16]),  # without the middle one
        (32, range(1, 32, 2)),
        (160, range(5, 160, 10)),
    ],
)
def test_at_most_sixteen_starts_a_side_in_the_middles_of_equal_parts(count, chosen):
    """Of a row of cells, and of a column; the attractor's label by its number, -1 is no start."""
    for wide, high in ((count, 1), (1, count)):
        codes = np.full(count, 4)
        codes[0] = -1
        codes[-1] = 9 if count > 1 else -1
        cells = {"attractor": codes, "q_m": 1.0 + np.arange(count), "v_m_per_s": -np.arange(count)}
        speed = Made(branches=[4], attractors=[Made(label="P(1;1)")])
        result = Made(tables={"basins": cells}, values=[Made(speeds=[speed])])
        own = machine(basins=Made(cells=(wide, high), rpm=Made(start=88.0)))
        found = list(motions_from_starts(own, result, 5))
        assert [(m.q, m.v) for m in found] == [(1.0 + k, -k) for k in chosen if codes[k] != -1]
        for motion in found:
            last = motion.q == count
            assert motion.label == ("undecided" if last else "P(1;1)")
            assert (motion.rpm, motion.turns, motion.place) == (88.0, 5, (motion.q, motion.v))
            assert (motion.origin, motion.loops, motion.stable, motion.exponent) == (
                "start", False, None, None,
            )  # fmt: skip


def test_motions_of_a_map_go_on_from_the_ends_of_their_records():
    """Of columns by rows; where nothing was recorded there is none."""
    scene = camcli.load_scene(None)
    axes = [camcli.scene.Axis(key="follower.mass", start=1.0, stop=2.0, num=3),
            camcli.scene.Axis(key="run.rpm", start=600.0, stop=640.0, num=2)]  # fmt: skip
    labels = [Label((1.0,) * 9), Label((2.0, 1.0)), "aperiodic"]

    def point(k, row):
        end = Made(q=10.0 * row + k, v=-10.0 * row - k)
        return Made(value=1.0 + 0.5 * k, label=labels[k], exponent=0.1 * k,
                    end=None if (k, row) == (1, 1) else end)  # fmt: skip

    lines = [[point(k, row) for k in range(3)] for row in range(2)]
    result = Made(scene=Made(sweep=Made(vary=axes)),
                  values=[Made(second=[600.0, 640.0], lines=lines)])  # fmt: skip
    found = list(motions_of_a_map(machine_of(scene), result, 8))
    assert [(m.place, m.q, m.v) for m in found] == [
        ((1.0 + 0.5 * k, (600.0, 640.0)[row]), 10.0 * row + k, -10.0 * row - k)
        for row in range(2) for k in range(3) if (k, row) != (1, 1)
    ]  # fmt: skip
    for motion in found:
        k = round(2.0 * (motion.place[0] - 1.0))
        assert (motion.rpm, motion.system.follower.mass) == motion.place[::-1]
        assert motion.sets == {"follower.mass": motion.place[0]}
        assert (motion.label, motion.exponent) == (labels[k], 0.1 * k)
        shown = [(8, False, True), (2, True, True), (8, False, None)][k]
        assert (motion.turns, motion.loops, motion.stable) == shown


# --- what a page asks of other commands

VARIED = [{"key": "follower.restitution", "start": 0.7, "stop": 0.9, "num": 2}]
ODD = {  # a scene in which every section asks for what a page does not show
    "sweep.rpm": {"start": 700.0, "stop": 690.0, "num": 2}, "sweep.vary": VARIED,
    "sweep.zoom": [{"start": 0.75, "stop": 0.8, "num": 4}], "sweep.adaptive": True,
    "sweep.explain": True, "sweep.tables": "none", "sweep.sections": ["strobe"],
    "sweep.branches": "b.csv", "sweep.curves": "auto", "sweep.prove": True,
    "sweep.direction": "down",
    "orbits.vary": VARIED, "orbits.chaos": True, "orbits.starts": 0,
    "orbits.prove": True, "orbits.checker": True, "orbits.simulated": 5,
    "basins.vary": VARIED, "basins.cells": [2, 2], "basins.refine": 2,
    "basins.rpm": {"start": 690.0, "stop": 700.0, "num": 3},
    "explore.basins": True, "explore.map": True, "run.transient": 5, "run.record": 5,
}  # fmt: skip


def test_a_page_asks_its_parts_for_what_it_shows_alone():
    """The speeds of the page, one speed of basins, a map of both numbers; nothing beside them."""
    scene = camcli.load_scene(None, ODD)
    parts = explore.parts_of(scene)
    assert list(parts) == ["sweep fixed", "sweep up", "sweep down", "orbits", "basins", "map"]
    for way in ("fixed", "up", "down"):
        command, own = parts[f"sweep {way}"]
        assert (command, own.sweep.direction, own.sweep.vary) == ("sweep", way, ())
        assert (own.sweep.rpm, own.sweep.tables) == (scene.sweep.rpm, "csv")
        assert own.sweep.sections == ("impacts", "strobe")
        assert own.sweep.lyapunov
        assert not own.sweep.prove
        assert own.sweep.curves is own.sweep.branches is None
    for name in ("sweep up", "map"):
        sweep = parts[name].scene.sweep
        assert (sweep.zoom, sweep.adaptive, sweep.explain) == ((), False, False)
    assert [axis.key for axis in parts["map"].scene.sweep.vary] == ["rpm", "follower.restitution"]
    command, own = parts["basins"]
    window = own.basins
    assert (command, window.vary, window.refine, window.cells) == ("basins", (), 0, (2, 2))
    assert (window.rpm.start, window.rpm.stop) == (690.0, 690.0)
    command, own = parts["orbits"]
    orbits = own.orbits
    assert (command, orbits.vary, orbits.parameter) == ("orbits", (), "rpm")
    assert (orbits.rpm.start, orbits.rpm.stop, orbits.chaos, orbits.all) == (
        690.0, 700.0, False, None,
    )  # fmt: skip
    assert (orbits.prove, orbits.checker, orbits.simulated) == (False, False, 0)
    assert [*explore.parts_of(camcli.load_scene(None))] == [*parts][:4]
    all_orbits = camcli.load_scene(None, {"orbits.all": {"impacts": 1, "turns": 1}})
    assert explore.parts_of(all_orbits)["orbits"].scene.orbits.all is None


@pytest.mark.parametrize(
    ("at", "kept"),
    [(None, None), (690.0, 690.0), (700.0, 700.0), (689.9, None), (700.1, None), (695.0, 695.0)],
)
def test_orbits_of_a_page_are_looked_for_at_a_speed_of_the_page(at, kept):
    scene = camcli.load_scene(
        None,
        {"sweep.rpm": {"start": 700.0, "stop": 690.0, "num": 3}, "orbits.at": at,
         "orbits.parameter": "restitution", "orbits.range": [0.7, 0.9], "orbits.label": "P(1;1)"},
    )  # fmt: skip
    orbits = explore.parts_of(scene)["orbits"].scene.orbits
    assert (orbits.at, orbits.parameter, orbits.range) == (kept, "rpm", None)
    assert orbits.label == "P(1;1)"


def test_a_scene_that_varies_other_numbers_has_the_orbits_and_basins_of_its_speeds():
    parts = explore.parts_of(camcli.load_scene(None, ODD))
    (varied,) = varied_by(parts["orbits"].scene)
    question = question_of(parts["orbits"].scene, [varied])
    assert (question.parameter, question.span.low, question.span.high) == ("rpm", 690.0, 700.0)
    landed = camcli.basins(parts["basins"].scene)
    assert {*labels_of_codes(landed)} >= {1}


def test_what_rounding_puts_behind_the_last_turn_of_a_motion_stays_on_its_page(monkeypatch):
    """Two turns at 600 rpm take 0.2 s; a double there is good to 2e-16 of it."""
    counted = []

    def rows_of(motion, simulation, happened, last):
        counted.append((len(happened), last))
        return np.zeros((4, 1))

    monkeypatch.setattr(explore_page, "_rows", rows_of)
    motion = known_motion(600.0)
    seconds = (0.0, 0.2 * (1.0 - 1e-13), 0.2 * (1.0 + 1e-13), 0.2 * (1.0 + 1e-10))
    events = [Made(seconds=s, kind="impact", u_before=-1.0) for s in seconds]
    explore_page.motion_data(Made(motions=[motion], simulations=[Made(events=events)], parts={}))
    ((kept, last),) = counted
    assert kept == 3
    assert 2.0 * (1.0 + 1e-13) < last < 2.0 * (1.0 + 1e-11)


def test_why_a_page_has_no_motion_is_what_happened_most():
    statuses = [Status.IMPACT_BUDGET, Status.NO_RETURN, Status.IMPACT_BUDGET]
    sweeps = [("up", Made(values=[Made(speeds=[Made(status=int(one))])])) for one in statuses]
    fault = str(explore._nothing_to_show(sweeps))
    assert fault.startswith("sweep.rpm: found no motion at any speed (")
    alone = [str(explore._nothing_to_show(sweeps[k : k + 1])) for k in (0, 1)]
    assert fault == alone[0] != alone[1]


@pytest.mark.parametrize(
    ("values", "keys"),
    [
        (VARIED, ["rpm", "follower.restitution"]),
        ([*VARIED, {"key": "rpm", "start": 600.0, "stop": 700.0, "num": 2}],
         ["follower.restitution", "rpm"]),
        ([*VARIED, {"key": "follower.mass", "start": 9.0, "stop": 11.0, "num": 2}],
         ["follower.restitution", "follower.mass"]),
    ],
)  # fmt: skip
def test_a_map_of_one_number_is_one_over_the_speeds_of_the_page(values, keys):
    scene = camcli.load_scene(None, {"sweep.vary": values, "sweep.rpm.num": 7})
    axes = axes_of_map(scene)
    assert [axis.key for axis in axes] == keys
    if len(values) == 1:
        span = scene.sweep.rpm
        assert (axes[0].start, axes[0].stop, axes[0].num) == (span.start, span.stop, 7)


@pytest.mark.parametrize("keys", [("rpm", "cam.base_radius"), ("cam.base_radius", "rpm")])
def test_a_map_of_a_page_has_no_number_of_the_cam(keys):
    values = {"rpm": (600.0, 700.0), "cam.base_radius": (0.11, 0.12)}
    axes = [camcli.scene.Axis(key=key, start=values[key][0], stop=values[key][1]) for key in keys]
    scene = Made(sweep=Made(vary=axes, rpm=None))
    with pytest.raises(camcli.SceneError, match=f"found {keys[0]} and {keys[1]}"):
        axes_of_map(scene)


def test_a_map_has_room_for_the_motions_of_its_stiffest_machine(monkeypatch):
    """At any of its corners; 16 x 3 motions in 350 000 rows have 7291 each."""
    rows = {(600.0, 1.0): 100, (600.0, 2.0): 300, (700.0, 1.0): 7291, (700.0, 2.0): 200}
    monkeypatch.setattr(
        explore_motions, "Varied",
        lambda machine, axes: lambda *place: (Made(follower=place[1]), place[0], None),
    )  # fmt: skip
    monkeypatch.setattr(explore_motions, "rows_per_turn", lambda follower, rpm: rows[rpm, follower])
    axes = (camcli.scene.Axis(key="rpm", start=600.0, stop=700.0, num=40),
            camcli.scene.Axis(key="follower.mass", start=1.0, stop=2.0, num=3))  # fmt: skip
    assert explore_motions.rows_of_a_map("machine", axes) == 7291
    for place in rows:
        rows[700.0, 1.0] = 200
        rows[place] = 7292
        with pytest.raises(camcli.SceneError) as caught:
            explore_motions.rows_of_a_map("machine", axes)
        (fault,) = caught.value.faults
        at = f"at rpm = {place[0]:g} and follower.mass = {place[1]:g}"
        assert fault.found == f"found motions of 7292 rows a turn, {at}"
        assert fault.expected == "expected at most 7291 on a page"
        rows[place] = 50
    # 80 motions of 4375 rows each fill it exactly, whichever number has five values
    axes = (axes[0], camcli.scene.Axis(key="follower.mass", start=1.0, stop=2.0, num=5))
    for two in (axes, axes[::-1]):
        rows.clear()
        rows |= {(x, y): 4375 for x in (1.0, 2.0, 600.0, 700.0) for y in (1.0, 2.0, 600.0, 700.0)}
        assert explore_motions.rows_of_a_map("machine", two) == 4375
        rows |= dict.fromkeys(rows, 4376)
        with pytest.raises(camcli.SceneError):
            explore_motions.rows_of_a_map("machine", two)


def test_a_page_without_motions_is_refused_but_where_a_fault_is_the_cause(monkeypatch):
    monkeypatch.setattr(explore, "_computed", lambda *_: {})
    fault = Fault("sweep.rpm", "", "nothing to show", "", "")
    monkeypatch.setattr(explore, "_nothing_to_show", lambda sweeps: fault)
    monkeypatch.setattr(explore, "motions_of_stops", lambda machine: [])
    few = machine_of(camcli.load_scene(None, {"sweep.rpm.num": 2, "run.record": 2}))
    with pytest.raises(camcli.SceneError):
        explore._explored(few, None, None, [])
    assert explore._explored(few, None, None, ["a fault"]).motions == []


def test_a_page_has_the_source_of_its_scene_and_every_stop(monkeypatch):
    @dataclass
    class Stop:
        name: str

    written = []
    monkeypatch.setattr(explore, "_explored", lambda *_: "explored")
    monkeypatch.setattr(explore, "_result", lambda machine, *_: machine)
    machine = explore.explore(camcli.load_scene(None), source="-c my.yaml")
    monkeypatch.setattr(explore, "stops_of", lambda *_: [Stop("lash"), Stop("hardest landing")])
    monkeypatch.setattr(explore, "machine_data", lambda _: {})
    monkeypatch.setattr(explore, "motion_data", lambda explored: {"explored": explored})
    monkeypatch.setattr(explore, "page", lambda data: written.append(data) or "a page")
    explore._write_page(machine, "explored", BytesIO())
    assert written == [{"source": "-c my.yaml", "explored": "explored",
                        "stops": [{"name": "lash"}, {"name": "hardest landing"}]}]  # fmt: skip
