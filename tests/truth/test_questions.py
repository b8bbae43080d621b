"""What a scene asks of an analysis, row by row; and that nothing is remarked where all is well."""

from __future__ import annotations

from pathlib import Path

import pytest

import camcli
from camcli.api.family import check_followed, why_not
from camcli.api.orbit_question import question_of, varied_by
from camcli.errors import SceneError
from camcli.scene import Axis

CONFIGS = Path(__file__).parents[2] / "configs"

# -- the section `orbits`: its two ways to say what is varied, and what it leaves open -----------

RANGE = {"orbits.rpm": {"start": 710.0, "stop": 690.0, "num": 41}}
CURVE = {"orbits.curve": "fold", "orbits.curve_in": "restitution"}
MASS = {"orbits.parameter": "mass", "orbits.range": [1.0, 1.5]}
LOSS = {"key": "follower.restitution", "start": 0.85, "stop": 0.75, "num": 9}
HEAVY = {"key": "follower.mass", "start": 1.2, "stop": 1.3, "num": 13}
ALL = {"at": 700.0, "vary": "rpm", "span": (690.0, 710.0, 0.5), "plane": None}
TENTH = (0.9 * 0.8, 1.1 * 0.8)  # restitution 0.8: a tenth to either side

QUESTIONS = {
    "speeds": ({}, {}),
    "a speed of its own": ({"orbits.at": 695.0}, {"at": 695.0}),
    "a run elsewhere": ({"run.rpm": 800.0}, {"at": 700.0}),
    "a run in the range": ({"run.rpm": 691.0}, {"at": 691.0}),
    "one speed": ({"orbits.rpm": {"start": 699.0, "stop": 699.0, "num": 1}},
                  {"at": 699.0, "span": None}),
    "mass": (MASS, {"vary": "mass", "span": (1.0, 1.5, 0.0125)}),
    "around the restitution": ({"orbits.parameter": "restitution"},
                               {"vary": "restitution", "span": (*TENTH, 0.16 / 40)}),
    "up to one": ({"orbits.parameter": "restitution", "follower.restitution": 0.95},
                  {"vary": "restitution", "span": (0.855, 1.0, 0.145 / 40)}),
    "a key": ({"orbits.vary": [HEAVY]},
              {"vary": "mass", "span": (1.2, 1.3, 0.1 / 12), "at": 700.0}),
    "a key, the run elsewhere": ({"orbits.vary": [HEAVY], "run.rpm": 800.0},
                                 {"vary": "mass", "span": (1.2, 1.3, 0.1 / 12), "at": 800.0}),
    "a curve": (CURVE, {"plane": (("rpm", "restitution"), ((690.0, 710.0), TENTH), 10)}),
    "a curve over range": (
        {**CURVE, "orbits.range": [0.7, 0.9]},
        {"plane": (("rpm", "restitution"), ((690.0, 710.0), (0.7, 0.9)), 10)}),
    "a curve over curve_range": (
        {**CURVE, "orbits.curve_range": [0.75, 0.95], "orbits.range": [0.7, 0.9]},
        {"plane": (("rpm", "restitution"), ((690.0, 710.0), (0.75, 0.95)), 10)}),
    "a curve in two constants": (
        {**MASS, **CURVE, "orbits.curve_range": [0.75, 0.95]},
        {"vary": "mass", "span": (1.0, 1.5, 0.0125),
         "plane": (("mass", "restitution"), ((1.0, 1.5), (0.75, 0.95)), 10)}),
    "a curve in two constants, the second open": (
        {**MASS, **CURVE},
        {"vary": "mass", "span": (1.0, 1.5, 0.0125),
         "plane": (("mass", "restitution"), ((1.0, 1.5), TENTH), 10)}),
    "a curve over one key": (
        {"orbits.curve": "fold", "orbits.vary": [LOSS]},
        {"plane": (("rpm", "restitution"), ((690.0, 710.0), (0.75, 0.85)), 10)}),
    "a curve over two keys": (
        {"orbits.curve": "fold", "orbits.vary": [HEAVY, LOSS]},
        {"vary": "mass", "span": (1.2, 1.3, 0.1 / 12),
         "plane": (("mass", "restitution"), ((1.2, 1.3), (0.75, 0.85)), 2)}),
    "few speeds": ({**CURVE, "orbits.rpm": {"start": 690.0, "stop": 710.0, "num": 5}},
                   {"span": (690.0, 710.0, 5.0),
                    "plane": (("rpm", "restitution"), ((690.0, 710.0), TENTH), 2)}),
}  # fmt: skip


@pytest.mark.parametrize("name", QUESTIONS)
def test_what_orbits_asks(name):
    values, wanted = QUESTIONS[name]
    wanted = {**ALL, **wanted}
    scene = camcli.load_scene(None, {**RANGE, **values})
    asked = question_of(scene, varied_by(scene))
    assert (asked.rpm, asked.parameter) == (wanted["at"], wanted["vary"])
    if wanted["span"] is None:
        assert asked.span is None
    else:
        span = asked.span.low, asked.span.high, asked.span.spacing
        assert span == pytest.approx(wanted["span"])
    if wanted["plane"] is None:
        assert asked.plane is None
        return
    names, ranges, steps = wanted["plane"]
    assert (asked.plane.names, asked.plane.steps) == (names, steps)
    for found, ends in zip(asked.plane.ranges, ranges, strict=True):
        assert found == pytest.approx(ends)


@pytest.mark.parametrize(
    ("values", "field", "wanted"),
    [({}, "stable", None), ({"orbits.stability": "stable"}, "stable", True),
     ({"orbits.stability": "unstable"}, "stable", False), ({"orbits.starts": 3}, "starts", 3),
     ({"orbits.branches": 0}, "branches", 0), ({"orbits.curve": "fold"}, "curve", "fold"),
     ({"orbits.label": "P(3;3:3:2)"}, "label", "P(3;3:3:2)"), ({}, "all_of", None),
     ({"orbits.all": {"impacts": 3, "turns": 2}}, "all_of", (3, 2)),
     ({"orbits.all": {"impacts": 3, "turns": 2}}, "span", None)],
)  # fmt: skip
def test_what_orbits_asks_beside(values, field, wanted):
    scene = camcli.load_scene(None, {**RANGE, **values})
    found = getattr(question_of(scene, varied_by(scene)), field)
    assert (str(found) if field == "label" else found) == wanted


# -- a machine with nothing to remark ------------------------------------------------------------

CALM = {
    "run.transient": 50, "run.record": 30, "sweep.rpm": {"start": 690, "stop": 700, "num": 3},
    "classify.rpm": {"start": 700, "stop": 710, "num": 2}, "orbits.starts": 1,
    "orbits.rpm": {"start": 699, "stop": 701, "num": 3}, "orbits.branches": 0,
    "basins.cells": [6, 6], "basins.rpm": {"start": 700, "stop": 700, "num": 1},
    "detach.rpm": {"start": 100, "stop": 130, "num": 3},
}  # fmt: skip


@pytest.mark.parametrize(
    "name", ["simulate", "sweep", "detach", "orbits", "basins", "classify", "explore"]
)
def test_nothing_is_remarked_of_a_calm_machine(name):
    result = getattr(camcli, name)(camcli.load_scene(None, CALM))
    assert result.notes == ()
    assert result.complete
    assert result.faults == ()


# -- why a number cannot be followed ---------------------------------------------------------------

LAW = {"kind": "law", "base": 0.0, "lift": 0.01, "fall": {"length_deg": 60.0, "law": "3-4-5"},
       "rise": {"start_deg": 90.0, "length_deg": 60.0, "law": "3-4-5"}}  # fmt: skip
REASONS = [  # scene, key, why a branch along it cannot be
    ("arcs", "cam.nose_radius", ""), ("arcs", "cam.offset", ""), ("table", "cam.base", ""),
    ("arcs", "cam.kind", "it is a text, 'arcs'"),
    ("arcs", "run.record", "it says how motions are simulated and recorded, no orbit depends"),
    ("arcs", "run.strobe_deg", "it says how motions are simulated and recorded"),
    ("arcs", "cam.nothing", ""),  # the scene says that there is no such key
    ("law", "cam.rise", "it is a section, name a number in it"),
    ("law", "cam.rise.length_deg", ""), ("law", "cam.rise.law", "it is a text, '3-4-5'"),
    ("law", "cam.lash", "the scene leaves it out, so that a branch has nowhere to begin"),
    ("table", "cam.base_radius", "only pictures of the lobe need it, no orbit depends on it"),
    ("table", "cam.smoothing", "it says how the table is smoothed, which is no number of a"),
    ("table", "cam.header", "it is a switch"), ("table", "cam.skip_lines", "it is a whole number"),
    ("table", "cam.angle", "it is a text, 'crank'"),
]  # fmt: skip


@pytest.mark.parametrize(("scene", "key", "why"), REASONS, ids=[f"{a} {b}" for a, b, _ in REASONS])
def test_why_a_number_is_not_followed(scene, key, why):
    follower = {"mass": 1.0, "stiffness": 1.0, "restitution": 0.5}
    loaded = {
        "arcs": lambda: camcli.load_scene(),
        "law": lambda: camcli.load_scene({"follower": follower, "cam": LAW}),
        "table": lambda: camcli.load_scene(CONFIGS / "lift-table.yaml"),
    }[scene]()
    found = why_not(loaded, Axis(key=key, start=0.1, stop=0.2, num=3))
    assert found.startswith(why)
    assert bool(found) == bool(why)


@pytest.mark.parametrize(
    ("key", "start", "stop", "found", "expected"),
    [
        ("cam.kind", 0.1, 0.2, "found cam.kind",
         "expected a number to follow: it is a text, 'arcs'"),
        ("cam.offset", 0.3, 0.3, "found 0.3 to 0.3", "expected two different ends"),
        ("cam.offset", 0.4, 0.31, "found 0.31 to 0.4",
         "expected a range that holds cam.offset = 0.3 of the scene"),
    ],
)  # fmt: skip
def test_a_number_that_is_not_followed_is_refused_at_its_key(key, start, stop, found, expected):
    axis = Axis(key=key, start=start, stop=stop, num=3)
    with pytest.raises(SceneError) as refused:
        check_followed(camcli.load_scene(), axis)
    (fault,) = refused.value.faults
    assert (fault.path, fault.found, fault.expected) == ("orbits.vary", found, expected)
    assert fault.cure
