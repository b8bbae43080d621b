"""Each quantity is one row: what is made of the rows agrees with what is computed."""

import re
from dataclasses import fields
from typing import get_args

import pytest

import camcli
from camcli.analysis.loads import Loads
from camcli.analysis.orbits.shooter import PLACES
from camcli.api import ANALYSES, bench
from camcli.api.command import columns_of, command_of
from camcli.cams.lift_reading import UNIT_WORDS
from camcli.cams.lift_table import TableCam
from camcli.cli.init import COMMENTS
from camcli.kernel import flow
from camcli.output.tables import MAY_BE_EMPTY, TEXTS
from camcli.plots.axes import axis_name
from camcli.quantities import (
    FOLLOWER,
    LENGTHS,
    LIFT_RANGES,
    LOADS,
    METRES,
    MILLIMETRES,
    PARAMETERS,
    PRESSURE,
    SEAT,
    THETA,
    VARIABLE,
    Q,
    U,
    V,
    drawn,
    ending,
)
from camcli.scene import Scene
from camcli.system import Follower
from camcli.words.loads import ANGLES

COMMANDS = (*ANALYSES, "bench")
COLUMNS = [(command, one) for command in COMMANDS for one in columns_of(command_of(command))]
OTHERWISE = {  # columns that do not end in their unit
    "lyapunov_per_period", "lyapunov_error_per_period", "seconds", "seconds_one_thread", "error",
    "bound", "period",
    "rpm_error", "rpm_low", "rpm_high",
}  # fmt: skip


@pytest.mark.parametrize(
    ("unit", "end", "picture"),
    [
        ("m", "m", "m"), ("m/s2", "m_per_s2", "m/s²"), ("N s/m", "n_s_per_m", "N s/m"),
        ("m/rad2", "m_per_rad2", "m/rad²"), ("1/turn", "per_turn", "1/turn"),
        ("um", "um", "µm"), ("rad/s", "rad_per_s", "rad/s"),
    ],
)  # fmt: skip
def test_a_unit_is_spelt_from_one_text(unit, end, picture):
    assert (ending(unit), drawn(unit)) == (end, picture)


def test_the_name_of_every_column_ends_in_its_unit():
    units = {one.unit for _, one in COLUMNS} - {""}
    assert units > {"m", "deg", "rpm", "m/s", "N", "Pa", "s"}
    varied = [("any", one) for one in PARAMETERS.values()]
    for command, one in [*COLUMNS, *varied]:
        name = one.column.removesuffix("_1..")
        if name in OTHERWISE:
            continue
        if one.unit:
            assert re.search(rf"(^|_){ending(one.unit)}$", name), (command, one)
        else:
            ends = [end for end in map(ending, units) if name.endswith(f"_{end}")]
            assert ends == [], (command, one)


def test_every_column_says_what_it_is():
    for command, one in COLUMNS:
        assert len(one.meaning) > 3, (command, one)
        assert "  " not in one.meaning


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_writes_the_tables_that_it_tells(command):
    record = command_of(command)
    told = [f"{head.name}.csv" for head in record.tables]
    assert len(set(record.artefacts)) == len(record.artefacts)
    assert record.artefacts[: len(told)] == tuple(told)
    more = {name for name in record.files if name.endswith((".csv", ".npz"))}
    assert more <= {"profile_2.csv", "profile_3.csv", "impacts.npz", "strobe.npz"}


def test_rows_stand_for_what_is_computed():
    assert [ANGLES.get(name, name) for name in (*LOADS, *SEAT)] == [*Loads._fields]
    for head in bench.HEADS:
        assert head.names() == tuple(f.name for f in fields(bench.PARTS[head.name]))
    lifts = get_args(TableCam.model_fields["lift"].annotation)
    assert {*LENGTHS, "fraction"} == set(lifts)
    assert {*UNIT_WORDS} == {*LENGTHS}
    assert [word.split()[0] for word in COMMENTS["lift"].split(" | ")] == [*LENGTHS, "fraction"]


def test_the_constants_of_the_follower_are_those_of_the_scene_and_of_the_kernel():
    scene = Scene.model_fields["follower"].annotation
    assert list(FOLLOWER) == [f.name for f in fields(Follower)] == list(scene.model_fields)
    for name, quantity in FOLLOWER.items():
        assert scene.model_fields[name].description == quantity.description
    parameters = get_args(
        Scene.model_fields["orbits"].annotation.model_fields["parameter"].annotation
    )
    assert tuple(PARAMETERS) == parameters
    assert {name: getattr(flow, name.upper()) for name in PARAMETERS} == PLACES


def test_numbers_are_shown_in_the_units_of_the_machine():
    assert MILLIMETRES.shown("m") == ("mm", 1000.0)
    assert MILLIMETRES.shown("m/rad2") == ("mm/rad2", 1000.0)
    assert MILLIMETRES.shown("m/s") == ("m/s", 1.0)
    assert MILLIMETRES.shown("N/m") == ("N/mm", 0.001)
    assert METRES.shown("m/rad") == ("m/rad", 1.0)
    assert METRES.head(PRESSURE) == "Hertz (MPa)"
    assert METRES.shown("Pa")[1] * 2.1e11 == pytest.approx(210_000.0)
    assert MILLIMETRES.head(LOADS["max_gap_m"]) == "loft (mm)"
    assert MILLIMETRES.stiffnesses(2500.0) == "2.5 N/mm"


SHORT = {"run.transient": 20, "run.record": 4}
RANGE = {"start": 700.0, "stop": 720.0, "num": 2}
AXES = [
    {"key": "rpm", **RANGE},
    {"key": "follower.restitution", "start": 0.7, "stop": 0.8, "num": 2},
]
RUNS = {
    "simulate": ({}, {}),
    "profile": ({"contact.face": "flat"}, {"profile_only": True}),
    "sweep": ({"sweep.rpm": RANGE, "sweep.direction": "both", "sweep.also": [{"q": 0.6}]}, {}),
    "restitution": ({"sweep.vary": AXES[1:]}, {}),
    "map": ({"sweep.vary": AXES}, {}),
    "detach": (
        {"detach.rpm": RANGE, "detach.hold_to": 800.0, "detach.machines": 1,
         "detach.tolerance": [{"key": "follower.mass", "percent": 5.0}]},
        {},
    ),
    "orbits": ({"orbits.rpm": {**RANGE, "stop": 700.0}, "orbits.starts": 0}, {"prove": True}),
    "classify": ({"classify.rpm": RANGE}, {}),
    "basins": (
        {"basins.cells": [4, 4], "basins.exponents": True, "basins.rpm": RANGE}, {},
    ),
}  # fmt: skip
COMMAND_OF = {"profile": "simulate", "restitution": "sweep", "map": "sweep"}


@pytest.mark.parametrize("name", RUNS)
def test_every_column_of_a_run_is_told_in_its_order(name):
    command = COMMAND_OF.get(name, name)
    values, more = RUNS[name]
    result = getattr(camcli, command)(camcli.load_scene(None, {**SHORT, **values}), **more)
    assert result.tables
    keys = {"rpm", *(axis["key"] for axis in AXES), "follower.mass"}
    for table, content in result.tables.items():
        told = [one for one in columns_of(command_of(command)) if one.table == table]
        known = {re.sub(r"_1\.\.$", "", one.column) for one in told}
        always = [one.column for one in told if not one.when and one.column != "KEY"]
        found = [re.sub(r"(?<=[a-z])_\d+$", "", column) for column in content]
        assert set(found) <= known | keys, table
        order = [re.sub(r"_1\.\.$", "", column) for column in always]
        assert [c for c in dict.fromkeys(found) if c in order] == [
            c for c in order if c in found
        ], table


def test_columns_that_have_a_type_of_their_own_are_columns():
    assert {one.column for _, one in COLUMNS} >= TEXTS | MAY_BE_EMPTY


def numbers_in(scheme, node, path=""):
    """(path, description) of every number below a node of a JSON Schema."""
    if "$ref" in node:
        found = scheme["$defs"][node["$ref"].rpartition("/")[2]]
        yield from numbers_in(scheme, {**found, **{k: node[k] for k in node if k != "$ref"}}, path)
    for choice in [*node.get("anyOf", ()), *node.get("oneOf", ())]:
        words = {k: node[k] for k in ("description",) if k in node}
        yield from numbers_in(scheme, {**choice, **words}, path)
    for name, part in node.get("properties", {}).items():
        yield from numbers_in(scheme, part, f"{path}.{name}".removeprefix("."))
    if node.get("type") in ("number", "integer"):
        yield path, node["description"]


NOT_MEASURED = {"header", "skip_lines", "angle_column", "lift_column"}  # places in a file


def test_every_number_that_a_run_can_vary_has_words_and_the_unit_of_its_key():
    """An axis says `nose radius (m)`, not `cam.nose_radius`."""
    scheme = Scene.model_json_schema()
    found = [
        (path, words)
        for path, words in numbers_in(scheme, scheme)
        if path.split(".")[0] in ("follower", "cam", "run")
        and path.rpartition(".")[2] not in NOT_MEASURED
    ]
    assert {path for path, _ in found} == set(VARIABLE) - {"rpm"}
    for path, words in found:
        one = VARIABLE[path]
        assert path not in axis_name(path)
        assert "." not in axis_name(path), path
        if one.unit in ("", "rpm", "turns"):
            assert not re.search(r", (m|kg|N|deg|rad/s|N/m|N s/m)\b", words), path
        else:
            assert f", {one.unit}" in words, path


@pytest.mark.parametrize(
    ("key", "axis"),
    [
        ("rpm", "cam speed (rpm)"),
        ("follower.restitution", "coefficient of restitution $r$ (-)"),
        ("cam.nose_radius", r"nose radius $\rho_2$ (m)"),
        ("cam.frequency", "circular frequency of the force (rad/s)"),
        ("run.strobe_deg", "phase of the strobe (deg)"),
    ],
)
def test_an_axis_over_what_is_varied_has_words_symbol_and_unit(key, axis):
    assert axis_name(key) == axis


def test_symbols_are_those_of_the_guide():
    """Of numbers that vary, and of the motion; all others have none."""
    follower = {"mass": "m", "stiffness": "k", "damping": "b"}
    wanted = {f"{part}.{key}": one for part in ("follower", "cam") for key, one in follower.items()}
    wanted |= {"follower.gravity": "g", "follower.preload": "F_0", "follower.restitution": "r"}
    wanted |= {
        "cam.base_radius": r"\rho_0", "cam.flank_radius": r"\rho_1", "cam.nose_radius": r"\rho_2",
        "cam.flank_center": r"\kappa_1", "cam.nose_center": r"\kappa_2",
        "cam.damping_ratio": r"\zeta", "run.start.q": "q", "run.start.v": "v",
        "run.start.theta_deg": r"\theta",
    }  # fmt: skip
    wanted |= {f"cam.{way}.law.scca.{x}": x for way in ("rise", "fall") for x in "bcd"}
    assert {key: one.symbol for key, one in VARIABLE.items() if one.symbol} == wanted
    assert (THETA.name, Q.name, V.name) == (r"cam angle $\theta$", "position $q$", "velocity $v$")
    assert U.name == r"relative velocity $u = v - \dot c$"
    assert [one.name for one in LIFT_RANGES.values()] == [
        "$c$", r"$c_\theta$", r"$c_{\theta\theta}$", r"$c_{\theta\theta\theta}$",
    ]  # fmt: skip
