"""The commands, function by function: what is asked of a run, and what it shows, by hand."""

from __future__ import annotations

import json
import os
import re
import sys
from inspect import signature
from io import StringIO
from math import radians
from pathlib import Path
from types import SimpleNamespace as Made

import pytest
import typer

from camcli.api.bench import COMMAND
from camcli.cli import (
    app,
    basins,
    bench,
    classify,
    detach,
    drawing,
    explore,
    guide,
    options,
    orbits,
    panels,
    report,
    schema,
    simulate,
    sweep,
)
from camcli.cli.exit_codes import INTERRUPTED
from camcli.cli.options import Request
from camcli.cli.report import MORE
from camcli.errors import SceneError
from camcli.output.drawing_process import MOST_SENT
from camcli.words.proofs import NO_CERTIFICATE_OF_A_SEAT
from camcli.words.simulate import JERK_OF_A_FIT


@pytest.fixture
def printed(monkeypatch):
    """What a module prints: its tables as (title, rows), and its sentences; heads are beside."""

    heads: list = []

    def of(module) -> list:
        found: list = []

        def table(title, head, rows, *more, **how):
            heads.append(head)
            found.append((title, rows))

        def print_as_it_is(text, **how):
            assert not text.startswith("- ")  # a sentence is broken between words: see `say`
            found.append(text)

        monkeypatch.setattr(module, "table", table)
        if hasattr(module, "say"):
            monkeypatch.setattr(module, "say", lambda text, mark="": found.append(mark + text))
        monkeypatch.setattr("builtins.print", print_as_it_is)
        return found

    of.heads = heads
    return of


@pytest.fixture
def asked(monkeypatch):
    """What a command asks of its run: (name, request, values, how)."""
    runs: list = []
    monkeypatch.setattr(
        "camcli.cli.run.run",
        lambda name, request, values, show, **how: runs.append((name, request, values, how)) or 3,
    )
    return runs


def called(command, request, **given):
    """A command that is called with these options, and without the others."""
    own = {
        name: parameter.default.default
        for name, parameter in signature(command).parameters.items()
        if name != "request"
    }
    return command(request, **{**own, **given})


def values_of(runs: list) -> dict:
    """The values of the last run, without the options that gave them."""
    return {key: value for key, (value, _) in runs[-1][2].items()}


# --- what is asked of a run


def test_a_shard_and_a_cluster_are_those_of_the_run(asked):
    request = Request()
    for call, name in ((basins.basins, "basins"), (sweep.sweep, "sweep")):
        assert called(call, request, shard="1/2", cluster="local") == 3
        assert (asked[-1][0], asked[-1][3]) == (name, {"shard": "1/2", "cluster": "local"})


def test_what_simulate_is_asked(asked):
    """What means nothing together is left to the scene, which refuses it."""
    own = {"profile_only": True, "base_radius": 0.02, "animate": True}
    assert called(simulate.simulate, Request(rpm="700", points="31"), **own) == 3
    assert values_of(asked) == {
        "run.rpm": 700.0, "simulate.samples": 31,
        **{f"simulate.{name}": value for name, value in own.items()},
    }  # fmt: skip
    called(simulate.simulate, Request())
    assert (asked[-1][0], values_of(asked)) == ("simulate", {})


def test_enlarged_parts_of_a_sweep_have_points_of_their_own(asked):
    """The first number is that of the range, the second one of each part."""
    zoom = ["700:701", "702:703.5"]
    parts = [{"start": 700.0, "stop": 701.0}, {"start": 702.0, "stop": 703.5}]
    called(sweep.sweep, Request(points="7,5", rpm="600:800"), zoom=zoom, both=True)
    found = values_of(asked)
    assert found["sweep.zoom"] == [{**part, "num": 5} for part in parts]
    assert (found["sweep.rpm.num"], found["sweep.direction"]) == (7, "both")
    assert asked[-1][1].points == "7"
    called(sweep.sweep, Request(points="7", rpm="600:800"), zoom=zoom)
    found = values_of(asked)
    assert (found["sweep.zoom"], found["sweep.rpm.num"]) == (parts, 7)
    assert "sweep.direction" not in found
    vary = ["follower.mass=1:2", "follower.damping=3:4"]
    called(sweep.sweep, Request(points="7,5"), vary=vary)
    assert [axis["num"] for axis in values_of(asked)["sweep.vary"]] == [7, 5]


def test_what_detach_is_asked(asked):
    """A single speed is one whose force is told; a range is none."""
    called(
        detach.detach,
        Request(rpm="700"),
        hold_to="7000crank",
        tolerance=["a.b=5%, c = 2.5%", "d=1%"],
    )
    found = values_of(asked)
    assert found["detach.force_rpm"] == [700.0]
    assert found["detach.hold_to"].startswith("7000")
    assert found["detach.tolerance"] == [
        {"key": "a.b", "percent": 5}, {"key": "c", "percent": 2.5}, {"key": "d", "percent": 1}
    ]  # fmt: skip
    called(detach.detach, Request(rpm="600:700"), prove=True)
    found = values_of(asked)
    assert ("detach.force_rpm" in found, found["detach.prove"]) == (False, True)
    assert not {"detach.hold_to", "detach.tolerance", "detach.report"} & set(found)
    for text in ("a=5", "a=%", "a=x%", "a=true%", "5%"):
        with pytest.raises(
            SceneError, match=r"--tolerance: found '.*', expected KEY=PERCENT%, e.g"
        ):
            detach._tolerance(text if "=" in text else f"{text}=")
    with pytest.raises(SceneError, match=r"^--hold-to: found the range '3:4', expected one speed"):
        called(detach.detach, Request(), hold_to="3:4")


ORBITS = {"branches": None, "within": None, "vary": None, "all_": None, "prove": False,
          "with_checker": False, "chaos": False, "at": None, "label": None, "parameter": None,
          "range_": None, "curve": None}  # fmt: skip


def test_what_orbits_is_asked(asked):
    def found(rpm=None, points=None, **more):
        asked.clear()
        called(orbits.orbits, Request(rpm=rpm, points=points), **more)
        return values_of(asked)

    assert found("600:700", "7", at="650") == {
        "orbits.rpm.start": 600.0, "orbits.rpm.stop": 700.0, "orbits.rpm.num": 7,
        "orbits.at": 650.0,
    }  # fmt: skip
    assert found(at="6000 crank")["orbits.at"] == "6000 crank"
    curve = found(curve="fold", within=["damping=0:2"])
    assert (curve["orbits.curve_in"], curve["orbits.curve_range"]) == ("damping", [0.0, 2.0])
    curve = found(curve="fold", within=["damping"])
    assert (curve["orbits.curve_in"], "orbits.curve_range" in curve) == ("damping", False)
    both = found(curve="fold", within=["damping=0:2", "rpm=600:700"])
    assert [axis["key"] for axis in both["orbits.vary"]] == ["follower.damping", "rpm"]
    assert "orbits.curve_in" not in both
    size = found(all_="3,2")
    assert (size["orbits.all.impacts"], size["orbits.all.turns"]) == (3, 2)
    assert type(size["orbits.all.impacts"]) is int
    assert found(all_="3.5,2")["orbits.all.impacts"] == 3.5
    assert found(parameter="mass", range_="1:2", label="P(1;1)", branches=3) == {
        "orbits.parameter": "mass", "orbits.range": [1.0, 2.0], "orbits.label": "P(1;1)",
        "orbits.branches": 3,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("rpm", "given", "told"),
    [
        (None, {"within": ["damping"]}, ["--in without --curve"]),
        (None, {"range_": "1:2"}, ["--range without a parameter"]),
        (None, {"range_": "1:2", "curve": "fold"}, []),
        (None, {"vary": ["a"], "parameter": "mass", "range_": "1:2"},
         ["--parameter with --vary", "--range with --vary"]),
        (None, {"vary": ["a"], "curve": "fold", "within": ["b"]}, ["--in with --vary"]),
        (None, {"curve": "fold", "within": ["cam.lift=1:2"], "parameter": "mass", "range_": "1:2"},
         ["--parameter with --in KEY=LO:HI", "--range with --in KEY=LO:HI"]),
        ("1:2", {"parameter": "mass"}, ["--parameter with a range of speeds"]),
        ("1:2", {"parameter": "rpm"}, []), ("1", {"parameter": "mass"}, []),
        (None, {"with_checker": True}, ["--with-checker without --prove"]),
        ("1", {"with_checker": True, "chaos": True}, []),
        ("1", {"with_checker": True, "all_": "3,2"}, []),
        (None, {"all_": "3,2", "parameter": "mass", "label": "P"},
         ["--parameter with --all", "--label with --all"]),
        (None, {"all_": "3,2", "vary": ["a"]}, ["--vary with --all"]),
        (None, {"all_": "3,2", "curve": "fold"}, ["--curve with --all"]),
        ("1:2", {"all_": "3,2"}, ["--rpm LO:HI with --all"]),
        ("1:2", {"chaos": True}, ["--chaos without one speed"]),
        ("1", {"chaos": True}, []), (None, {"chaos": True}, []),
        ("1", {"chaos": True, "vary": ["a"]}, ["--chaos with a number that varies"]),
        ("1", {"at": "7"}, ["--at with one speed"]), ("1:2", {"at": "7"}, []),
    ],
)  # fmt: skip
def test_options_of_orbits_that_mean_nothing_together(rpm, given, told):
    speeds = {} if rpm is None else orbits._speeds(Request(rpm=rpm))
    more = {name: value for name, value in {**ORBITS, **given}.items() if name != "branches"}
    keys = orbits._keys_of(more["within"] or [])
    try:
        orbits._refuse_idle(speeds, keys, **more)
    except SceneError as refused:
        found = [
            f"{fault.where} {fault.found.removeprefix('found it ')}" for fault in refused.faults
        ]
    else:
        found = []
    assert found == told


def test_what_classify_is_asked(asked, monkeypatch):
    """With --trace no machine is asked for, and nothing that belongs to one."""
    collisions = []
    monkeypatch.setattr(classify, "_border_collision", lambda *given: collisions.append(given) or 5)
    assert called(classify.classify, Request(), starts=3, seed=0) == 3
    assert values_of(asked) == {"classify.starts": 3, "classify.seed": 0}
    request = Request()
    assert called(classify.classify, request, det="1,2") == 5
    assert collisions == [(request, None, "1,2")]
    for more, said in (
        ({"seed": 0}, ["--seed"]),
        ({"trace": "1,2", "explain": True, "vary": ["a"]}, ["--vary", "--explain"]),
        ({"trace": "1,2", "starts": 0, "seed": 0}, ["--starts"]),
    ):
        with pytest.raises(SceneError) as refused:
            called(classify.classify, request, **more)
        assert [fault.where for fault in refused.value.faults] == said
    with pytest.raises(SceneError) as refused:
        called(classify.classify, Request(config=Path("a"), sets=["b"], rpm="7"), trace="1")
    assert [fault.where for fault in refused.value.faults] == ["-c", "--set", "--rpm"]
    assert classify._left_and_right("--det", "1,2", "e") == [1.0, 2.0]
    with pytest.raises(SceneError, match=r"--det: found no --det, expected both --trace and --det"):
        classify._left_and_right("--det", None, "e")


def test_a_border_collision_is_written_where_it_is_asked_for(tmp_path, monkeypatch, capsys):
    shown = []
    monkeypatch.setattr(classify, "_show_collision", lambda *given: shown.append(given))
    out = tmp_path / "out"
    for request in (Request(), Request(out=out, dry_run=True)):
        assert classify._border_collision(request, "1.5,-0.5", "0.5,0.25") == 0
        assert (capsys.readouterr().out, out.exists()) == ("", False)
    (left, right, result), _ = shown
    assert ((left.trace, left.det), (right.trace, right.det)) == ((1.5, 0.5), (-0.5, 0.25))
    classify._border_collision(Request(out=out, json=True), "1.5,-0.5", "0.5,0.25")
    text = (out / "border_collision.json").read_text()
    assert capsys.readouterr().out == text
    assert (json.loads(text)["kind"], len(shown)) == (result.kind, 2)


@pytest.mark.parametrize(
    ("text", "cells"),
    [(None, None), ("7", [7, 7]), ("7,5", [7, 5]), ("7x5", [7, 5]), (" 7, 5", [7, 5]), ("7,5,3", 0),
     ("7.5", 0), ("-7", 0), ("7,", 0)],
)  # fmt: skip
def test_the_cells_of_basins(text, cells):
    if cells != 0:
        assert basins._cells(text) == cells
        return
    with pytest.raises(SceneError, match=r"--cells: found '.*', expected N or NQ,NV, whole n"):
        basins._cells(text)


@pytest.mark.parametrize("dry_run", [False, True])
@pytest.mark.parametrize("written", [False, True])
@pytest.mark.parametrize("has_browser", [False, True])
def test_a_page_is_opened_when_it_is_written(
    asked, monkeypatch, tmp_path, dry_run, written, has_browser
):
    opened, noted = [], []
    monkeypatch.setattr("webbrowser.open", lambda page: opened.append(page) or has_browser)
    monkeypatch.setattr(explore, "note", noted.append)
    if written:
        (tmp_path / "explore.html").write_text("x")
    request = Request(out=tmp_path, dry_run=dry_run, sets=["a b=1"])
    assert explore.explore(request, "basins,map", None, True) == 3
    page = (tmp_path / "explore.html").as_uri()
    is_opened = written and not dry_run
    assert opened == [page] * is_opened
    assert noted == [f"no browser was found; open {page}"] * (is_opened and not has_browser)
    assert values_of(asked) == {
        "explore.basins": True, "explore.map": True, "explore.source": "--set 'a b=1'"
    }  # fmt: skip
    opened.clear()
    explore.explore(request, "map", None, False)
    assert (opened, "explore.basins" in values_of(asked)) == ([], False)


def test_a_page_varies_where_it_has_a_map(asked, monkeypatch):
    """Its scene may ask for one; a scene on stdin is not looked at."""
    scenes = []
    monkeypatch.setattr(
        "camcli.scene.load_scene",
        lambda *given: scenes.append(given) or Made(explore=Made(map="asks" in str(given))),
    )
    vary = ["follower.mass=1:2"]
    explore.explore(Request(config=Path("asks.yaml"), sets=["a=1"]), None, vary, False)
    assert scenes == [(Path("asks.yaml"), ["a=1"])]
    assert "explore.map" not in values_of(asked)
    explore.explore(Request(), "map", vary, False)
    assert len(scenes) == 1
    for config in (None, Path("no.yaml"), Path("-")):
        with pytest.raises(SceneError, match="--vary: found it without --with map"):
            explore.explore(Request(config=config), "basins", vary, False)
    assert [given[0] for given in scenes[1:]] == [None, Path("no.yaml")]
    with pytest.raises(SceneError, match="--with: found 'maps,basins', expected basins or map"):
        explore.explore(Request(), "maps,basins", None, False)


def test_the_source_of_a_page_names_no_folder_of_this_machine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for path, shown in (("a b/s.yaml", "'a b/s.yaml'"), (tmp_path / "x" / "s.yaml", "x/s.yaml"),
                        (tmp_path.parent / "s.yaml", "s.yaml"), ("../s.yaml", "../s.yaml"),
                        ("\udc80.yaml", "'\\udc80.yaml'")):  # fmt: skip
        assert explore.source_of(Request(config=Path(path))) == f"-c {shown}"
    assert explore.source_of(Request(sets=["a=1", "b=[1, 2]"])) == "--set a=1 --set 'b=[1, 2]'"
    assert explore.source_of(Request()) == ""


@pytest.mark.parametrize("config", [None, Path("s.yaml")])
@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("as_json", [False, True])
def test_what_a_bench_is_asked(monkeypatch, printed, config, quiet, as_json):
    shown = printed(bench)
    done, noted = [], []
    monkeypatch.setattr("camcli.scene.load_scene", lambda *given: done.append(given) or "scene")
    monkeypatch.setattr("camcli.cli.run.execute", lambda *given: done.append(given) or 3)
    plan = {"precision": {"runs": 7, "seconds": 12.3456}, "scale": {"runs": 5, "seconds": 0.5}}
    monkeypatch.setattr("camcli.api.bench.plan", lambda scene: plan)
    monkeypatch.setattr(bench, "note", noted.append)
    request = Request(config=config, sets=["a=1"], quiet=quiet, json=as_json, width="10mm")
    assert bench.bench(request, "scale", True) == 3
    values = {"bench.quick": (True, "--quick"), "bench.part": ("scale", "PART"),
              "plot.width": (10.0, "--width")}  # fmt: skip
    assert done == [(config, ["a=1"], values), (COMMAND, "scene", request, bench.show)]
    said = "note: of s.yaml only the section bench is used: every case has a machine of its own"
    assert noted == [said] * (config is not None and not quiet)
    assert bench.bench(Request(dry_run=True, json=as_json), None, False) == 0
    assert done[2:] == [(None, (), {})]
    (told,) = shown
    if as_json:
        assert json.loads(told) == {"command": "bench", "plan": plan}
    else:
        rows = [["precision", "7", "12.3"], ["scale", "5", "0.5"]]
        assert told == ("cam bench, planned", rows)
        assert printed.heads == [["part", "runs", "seconds (at most)"]]


# --- what is shown


@pytest.mark.parametrize("verbose", [False, True])
def test_the_plain_sentences_of_a_detachment_stand_beside_its_theory(printed, monkeypatch, verbose):
    found = printed(detach)
    monkeypatch.setattr("camcli.words.detach.plainly", lambda loss: [f"plain {loss}"])
    monkeypatch.setattr("camcli.words.detach.theory", lambda loss: [f"theory {loss}"])
    tables = [("one", ["a"], [["1"]]), ("two", ["b"], [["2"]])]
    monkeypatch.setattr("camcli.words.detach_tables.answers", lambda result: tables)
    monkeypatch.setattr(detach, "_show_theory", lambda result: found.append("digits"))
    result = Made(values="loss", summary={"proved": {"words": "all of it"}})
    detach.show(result, verbose)
    answers = [("one", [["1"]]), ("two", [["2"]])]
    middle = ["digits", "- plain loss", "- theory loss"] if verbose else ["- plain loss"]
    end = [] if verbose else [MORE]
    assert found == [*answers, *middle, "- all of it", *end]
    found.clear()
    result.summary = {}
    detach.show(result, verbose)
    assert found == [*answers, *middle, *end]


@pytest.mark.parametrize("verbose", [False, True])
@pytest.mark.parametrize("kind", ["table", "arcs"])
def test_orbits_are_shown_with_what_was_found(printed, monkeypatch, verbose, kind):
    """That a seat has no certificate is told where one was asked for."""
    found = printed(orbits)
    for name in ("orbits", "branches", "bifurcations", "points"):
        monkeypatch.setattr(orbits, f"_show_{name}", lambda *given, name=name: found.append(
            (name, given[-1])))  # fmt: skip
    monkeypatch.setattr(orbits, "_show_curve", lambda curve, title: found.append(title))
    monkeypatch.setattr("camcli.words.orbits.curve_title", lambda *given: given)
    monkeypatch.setattr("camcli.words.orbits.orbits_title", lambda study, kind: kind)
    monkeypatch.setattr("camcli.words.orbits.remarks", lambda *given: [f"{given[1:]}"])
    study = Made(orbits=["o"], branches=["b"], bifurcations=["e"], curves=["x", "y"], codim2=["p"])
    scene = Made(cam=Made(kind=kind), orbits=Made(prove=True))
    system = Made(has_seat=True)
    result = Made(values=study, scene=scene, system=system)
    end = [f"- {(verbose, kind)}"]
    more = [] if verbose else [MORE]
    told = [*end, *[f"- {NO_CERTIFICATE_OF_A_SEAT}"] * (kind == "table"), *more]
    orbits.show(result, verbose)
    assert found == [*((name, verbose) for name in ("orbits", "branches", "bifurcations")),
                     (1, "x"), (2, "y"), ("points", verbose), *told]  # fmt: skip
    for one in ("orbits", "branches", "bifurcations", "curves", "codim2"):
        setattr(study, one, [])
    for prove, has_seat, some in ((True, True, []), (False, True, ["o"]), (True, False, ["o"])):
        found.clear()
        scene.orbits.prove, system.has_seat, study.orbits = prove, has_seat, some
        orbits.show(result, verbose)
        assert found == [*[("orbits", verbose)] * len(some), *end, *more]


def test_points_of_a_curve_are_shown_evenly(printed):
    found = printed(orbits)
    points = [
        Made(
            first=700.1234567890123 + k,
            second=100.2512345678901 + k,
            orbit=Made(theta=[radians(k)] * (k + 1)),
        )
        for k in range(25)
    ]
    orbits._show_curve(Made(points=points, first="rpm", second="x"), "title")
    ((title, rows),) = found
    assert title == "title"
    assert [row[:2] for row in rows] == [
        [f"{700 + k}.1234568", f"{100 + k}.2512346"] for k in range(0, 25, 2)
    ]
    assert rows[1][2] == "2, 2, 2"
    assert rows[-1][2] == "24, 24, 24, 24, 24, 24 and 19 more"


@pytest.mark.parametrize("has_seat", [False, True])
def test_the_last_events_of_an_orbit_are_shown(printed, monkeypatch, has_seat):
    """Twelve of them, each with where it is; a cam alone has a sheet of its own."""
    found = printed(simulate)
    monkeypatch.setattr(
        "camcli.words.simulate.record_title", lambda record, count, kind: f"{count} of {kind}"
    )
    monkeypatch.setattr(simulate, "_show_profile", lambda result: found.append("profile"))
    events = [(0.1 * k, k, 10.0 + k, "impact", 0.5, -0.123456 * k, 0.0625 * k) for k in range(14)]
    scene = Made(simulate=Made(profile_only=False), cam=Made(kind="arcs"))
    system = Made(has_seat=has_seat, is_seat=lambda theta: theta > radians(15.5))
    result = Made(scene=scene, values=Made(last_period=events), system=system)
    simulate.show(result, False)
    ((title, rows),) = found
    assert (title, len(rows)) == ("12 of arcs", 12)
    assert printed.heads == [["event", "period", "theta (deg)", "u- (m/s)", "u+ (m/s)"]]
    where = [", lobe", ", seat"] if has_seat else ["", ""]
    assert rows[0] == [f"impact{where[0]}", "2", "12.0000", "-0.2469", "0.125"]
    assert rows[-1] == [f"impact{where[1]}", "13", "23.0000", "-1.605", "0.8125"]
    scene.simulate.profile_only = True
    simulate.show(result, False)
    assert found[1:] == ["profile"]


@pytest.mark.parametrize("kind", ["table", "arcs"])
@pytest.mark.parametrize("lobe", [None, "lobe"])
def test_the_sheet_of_a_cam_has_where_contact_is_lost(printed, monkeypatch, kind, lobe):
    """Of a measured cam with the speeds that its table leaves open."""
    found = printed(simulate)
    monkeypatch.setattr("camcli.system.units_of", lambda system: "units")
    monkeypatch.setattr("camcli.system.is_measured", lambda system: kind == "table")
    monkeypatch.setattr("camcli.words.machine.digits_of", lambda scene: 5)
    for name in ("extremes", "lobe", "curvature"):
        monkeypatch.setattr(
            simulate, f"_add_{name}",
            lambda rows, what, *given, name=name: rows.add_text(f"{name} {what}", f"{given}"),
        )  # fmt: skip
    cam = Made(kind=kind)
    first = Made(finite=True, rpm=812.345678, theta=radians(155.5), low=800.0, high=820.0)
    profile = Made(
        force=Made(rpm=700.0, lowest_n=-3.25, lowest_theta=radians(45.0)), first=first, lobe=lobe,
        curvature="c", corners={"a": radians(10.0), "b": radians(20.5)},
    )  # fmt: skip
    result = Made(values=profile, scene=Made(cam=cam), system=Made(rocker_ratio=1.5))
    simulate._show_profile(result)
    (title, rows), *words = found
    assert title == "Cam, corners (deg): a 10, b 20.5"
    assert printed.heads == [["what", "value", "theta (deg)"]]
    sheet = ["lobe lobe", "('units', 1.5)", ""] if lobe else ["curvature c", "('units', 1.5)", ""]
    left_open = [["left open by the table (rpm)", "800 to 820", ""]] * (kind == "table")
    assert [row[1:] for row in rows[1:3]] == [["-3.25", "45"], ["812.35", "155.5"]]
    assert rows[1][0].startswith("least contact force at 700 rpm (N")
    assert rows[2][0] == "first detachment (rpm)"
    assert rows[3:] == [*left_open, sheet]
    if kind == "table":
        assert words == [f"- {JERK_OF_A_FIT}"]
    else:
        assert words == ["- the jerk is infinite at the corners; least and largest are those "
                         "between them"]  # fmt: skip
    for one in (None, Made(finite=False)):
        found.clear()
        profile.first, profile.corners = one, {}
        simulate._show_profile(result)
        assert found[0][0] == "Cam, corners (deg): none"
        assert len(found[0][1]) == 3
        assert len(found) == 1 + (kind == "table")


@pytest.mark.parametrize("files", [[], ["explore.html"]])
def test_how_much_a_page_shows_is_told(monkeypatch, files):
    lines: list = []
    monkeypatch.setattr("camcli.words.explore.page_line", lambda **given: lines.append(given))
    monkeypatch.setattr("builtins.print", lines.append)
    explore._show(Made(summary={"motions": 3}, files=files), False)
    assert lines == [{"motions": 3, "written": bool(files)}, None]


# --- the application


@pytest.mark.parametrize(
    ("words", "processors", "started"),
    [
        (["sweep", "--rpm", "7"], 2, ["sweep"]), (["simulate"], 4, ["simulate"]),
        (["sweep"], 1, []), (["explore"], 2, []), (["bench"], 2, []), (["guide", "sweep"], 2, []),
        ([], 2, []), (["sweep", "--no-plot"], 2, []), (["sweep", "--dry-run"], 2, []),
        (["sweep", "--shard", "1/2"], 2, []), (["sweep", "--shard=1/2"], 2, []),
        (["sweep", "--threads", "1"], 2, []), (["sweep", "-h"], 2, []),
        (["sweep", "--help"], 2, []),
    ],
)  # fmt: skip
def test_a_process_draws_where_a_processor_is_free_for_it(monkeypatch, words, processors, started):
    begun = []
    monkeypatch.setattr(drawing, "_started", [])
    monkeypatch.setattr("camcli.output.drawing_process.DrawingProcess", begun.append)
    monkeypatch.setattr("camcli.parallel.threads.thread_count", lambda asked: processors)
    drawing.start(words)
    assert begun == [
        ("camcli.plots.picture", f"camcli.plots.{name}", f"camcli.api.{name}") for name in started
    ]
    assert [name for name, _ in drawing._started] == started


def test_a_process_draws_for_its_command_alone_and_no_giant(monkeypatch):
    ended: list = []
    process = Made(end=lambda: ended.append("end"), let_go=lambda: ended.append("let go"))
    monkeypatch.setattr(drawing, "_started", [("sweep", process)])

    def asked(name, memory):
        return drawing.process_for(Made(name=name, size=lambda scene: Made(memory=memory)), None)

    assert asked("sweep", MOST_SENT) is process
    assert (asked("basins", 1), ended) == (None, [])
    assert (asked("sweep", MOST_SENT + 1), ended) == (None, ["end"])
    drawing.let_go()
    assert (drawing._started, ended) == ([], ["end", "let go"])


@pytest.mark.parametrize(
    ("ends", "code"), [(3, 3), (0, 0), (INTERRUPTED, 130), (KeyboardInterrupt(), 130)]
)
@pytest.mark.parametrize("as_json", [False, True])
def test_the_end_of_a_command_line(monkeypatch, ends, code, as_json):
    """An interrupt waits for no thread; what a shell's settings say of pictures is dropped."""
    done: list = []
    words = ["cam", "sweep", *["--json"] * as_json]

    def records(name):
        return lambda *given, **more: done.append((name, *given, *more.values()))

    def guarded(run, for_a_program):
        run()
        done.append(("json", for_a_program))
        monkeypatch.setattr("sys.stdout", StringIO())
        if isinstance(ends, BaseException):
            raise ends
        return ends

    real = StringIO()
    monkeypatch.setattr("sys.argv", words)
    monkeypatch.setattr("sys.stdout", real)
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    monkeypatch.delenv("_CAM_COMPLETE", raising=False)
    for name in ("install", "interrupt_arrived", "leave"):
        monkeypatch.setattr(f"camcli.interrupts.{name}", records(name))
    monkeypatch.setattr("camcli.cli.drawing.start", records("start"))
    monkeypatch.setattr("camcli.cli.drawing.let_go", records("let_go"))
    monkeypatch.setattr("camcli.cli.exit_codes.hold_output", records("hold"))
    monkeypatch.setattr("camcli.cli.exit_codes.guarded", guarded)
    monkeypatch.setattr(app, "app", records("app"))
    monkeypatch.setattr("gc.freeze", records("freeze"))
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert (ended.value.code, sys.stdout is real) == (code, True)
    assert "MPLBACKEND" not in os.environ
    assert done == [
        ("hold",), ("install",), ("start", words[1:]), ("app", False), ("json", as_json),
        ("interrupt_arrived",), ("let_go",), ("freeze",), *[("leave",)] * (code == 130),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "line", "command"),
    [
        (["-v", "sweep", "basins"], None, "sweep"), (["--version"], None, ""), ([], None, ""),
        (["x"], {"_TYPER_COMPLETE_ARGS": "cam basins --r"}, "basins"),
        (["x"], {"COMP_WORDS": "cam -v detach"}, "detach"), (["x"], {}, ""),
    ],
)  # fmt: skip
def test_of_the_commands_only_the_one_asked_for_is_imported(monkeypatch, words, line, command):
    """A shell that completes a line gives it in the environment."""
    for name in ("_CAM_COMPLETE", "_TYPER_COMPLETE_ARGS", "COMP_WORDS"):
        monkeypatch.delenv(name, raising=False)
    if line is not None:
        monkeypatch.setenv("_CAM_COMPLETE", "complete_bash")
        for name, text in line.items():
            monkeypatch.setenv(name, text)
    made = []
    monkeypatch.setattr(
        app, "application",
        lambda *asked: made.append(asked) or (lambda *given, **more: (given, more)),
    )  # fmt: skip
    assert app.app(words, a=1) == ((words,), {"a": 1})
    assert made == [(command,)]
    monkeypatch.setattr("sys.argv", ["cam", "guide"])
    monkeypatch.delenv("_CAM_COMPLETE", raising=False)
    assert app.app() == ((["guide"],), {})


def test_the_version_is_told_where_it_is_asked_for(capsys, monkeypatch):
    monkeypatch.setattr("camcli.__version__", "7.8")
    app._version(False)
    assert capsys.readouterr().out == ""
    with pytest.raises(typer.Exit):
        app._version(True)
    assert capsys.readouterr().out == "cam 7.8\n"


def test_the_schema_is_printed_and_written_where_it_is_asked_for(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("camcli.scene.json_schema", lambda: {"a": [1]})
    text = '{\n  "a": [\n    1\n  ]\n}\n'
    out = tmp_path / "out"
    for request in (Request(), Request(out=out, dry_run=True)):
        assert schema.schema(request) == 0
        assert (capsys.readouterr().out, out.exists()) == (text, False)
    schema.schema(Request(out=out))
    assert (out / "schema.json").read_text() == capsys.readouterr().out == text


def test_the_application_has_a_line_on_every_command():
    command = typer.main.get_command(app.application("bench")).commands["bench"]
    names = {parameter.name for parameter in command.params}
    assert {"part", "quick", "config", "threads"} <= names
    assert not {"verbose", "rpm", "points", "panels"} & names
    made = app.application("guide")
    lines = {one.name: one.help for one in made.registered_commands}
    assert [*lines] == [*app.COMMANDS]
    for name, line in app.COMMANDS.items():
        assert lines[name].splitlines()[0] == ("Show the guide." if name == "guide" else line)


# --- the options


@pytest.mark.parametrize(
    ("text", "form", "found"),
    [
        (None, "two numbers L,R", None), ("1,2.5", "two numbers L,R", [1.0, 2.5]),
        ("-1:2e3", "two numbers LO:HI", [-1.0, 2000.0]), ("7", "one number", [7.0]),
        ("k=1 : 2", "KEY=LO:HI", [1.0, 2.0]),
        ("1:2", "KEY=LO:HI", "refused"), ("k=1:2", "two numbers LO:HI", "refused"),
        ("1,2", "two numbers LO:HI", "refused"), ("1:2:3", "two numbers LO:HI", "refused"),
        ("1", "two numbers LO:HI", "refused"), ("1:", "two numbers LO:HI", "refused"),
        ("1:inf", "two numbers LO:HI", "refused"), ("1:true", "two numbers LO:HI", "refused"),
        ("1:x", "two numbers LO:HI", "refused"), ("1,2", "one number", "refused"),
    ],
)  # fmt: skip
def test_the_numbers_of_an_option(text, form, found):
    if found != "refused":
        assert options.numbers(text, "--x", form, "e") == found
        return
    with pytest.raises(SceneError) as refused:
        options.numbers(text, "--x", form, "example")
    assert str(refused.value) == f"--x: found '{text}', expected {form}, e.g. example"


@pytest.mark.parametrize(
    ("text", "length"),
    [(None, None), ("85mm", 85.0), (" 8.5 cm ", 85.0), ("3in", 76.2), ("85", 85.0), ("8.", 8.0),
     ("-8mm", "refused"), ("8m", "refused"), ("mm", "refused"), ("8mm9", "refused")],
)  # fmt: skip
def test_a_length_of_paper_in_millimetres(text, length):
    if length != "refused":
        assert options._millimetres(text, "width") == (
            None if length is None else pytest.approx(length)
        )
        return
    with pytest.raises(
        SceneError, match=rf"^--width: found '{text}', expected a number and one of"
    ):
        options._millimetres(text, "width")


def test_options_of_pictures_are_set_with_the_option_of_each():
    request = Request(width="8cm", height="30mm", font="f", style="s", panels="a, b", formats="png",
                      no_title=True)  # fmt: skip
    assert request.picture_values() == {
        "plot.width": (80.0, "--width"), "plot.height": (30.0, "--height"),
        "plot.font": ("f", "--font"), "plot.style": ("s", "--style"),
        "plot.panels": (["a", "b"], "--panels"), "plot.title": (False, "--no-title"),
        "plot.formats": (["png"], "--format"),
    }  # fmt: skip
    assert Request().picture_values() == {}
    assert Request().folder("sweep") == Path("out/sweep")
    assert Request(out=Path("o")).folder("sweep") == Path("o")
    assert options.given("a", b=0, c=False, d=None, e_f=True, g="") == {
        "a.b": (0, "--b"), "a.e_f": (True, "--e-f"), "a.g": ("", "--g")
    }  # fmt: skip


def test_the_name_of_a_folder_is_not_empty():
    assert options._folder("a b") == Path("a b")
    with pytest.raises(typer.BadParameter, match="expected the name of a folder"):
        options._folder("")


def test_an_option_that_is_given_more_often():
    assert str(options._repeated("-c", 2)) == (
        "-c: found it twice, expected one scene, give one scene, and what differs with --set"
    )
    assert str(options._repeated("--rpm", 3)) == (
        "--rpm: found it 3 times, expected it once, leave all but one of them out"
    )


@pytest.fixture
def do():
    """A command of its own: call it with words; what its function was given."""
    given: list = []

    def do(
        request: Request,
        many: list[str] | None = options.option("Many.", "KEY"),
        with_one: str | None = options.option("One.", "X"),
        all_: bool = options.flag("All."),
    ) -> int:
        """Do it.

        Examples:
          cam do --all    all of it

        Files:
          a.csv           rows

        The rest is not help.
        """
        given.append((request, many, with_one, all_))
        print("done")
        return 3

    def other(request: Request) -> int:
        """Another one."""
        return 0

    made = typer.Typer(rich_markup_mode=None)
    options.register(made, do, ("rpm", "no_plot", "font"))
    options.register(made, other, ("no_plot", *options.DRAWING))
    group = typer.main.get_command(made)
    return lambda *words, name="do": (group([name, *words], standalone_mode=False), given)


def test_a_function_is_a_command_with_the_shared_options(do, capsys):
    """Those that mean nothing to it are not there; a flag may stand twice, and a list."""
    code, given = do("--many", "a", "--many", "b", "--with-one", "c", "--all", "--all", "-c", "s")
    ((request, many, with_one, all_),) = given
    assert (code, many, with_one, all_) == (3, ["a", "b"], "c", True)
    assert (request.config, request.rpm, request.threads) == (Path("s"), None, None)
    for words, said in ((("-q",), ""), (("-q", "--json"), "done\n"), ((), "done\n")):
        capsys.readouterr()
        assert do(*words)[0] == 3
        assert capsys.readouterr().out == said
    assert given[-1][1:] == (None, None, False)
    for threads in ("1", "4096"):
        assert do("--threads", threads)[1][-1][0].threads == int(threads)
    count = len(given)
    for threads in ("0", "4097"):
        with pytest.raises(SceneError, match=rf"--threads: found {threads}, expected 1 or more"):
            do("--threads", threads)
    with pytest.raises(SceneError) as refused:
        do("--with-one", "a", "--config", "b", "--with-one", "c", "-c", "d", "-c", "e", "-q", "-q")
    told = [(fault.where, fault.found) for fault in refused.value.faults]
    assert sorted(told) == [("--with-one", "found it twice"), ("-c", "found it 3 times")]
    with pytest.raises(Exception, match="No such option"):
        do("--rpm", "7")
    assert len(given) == count


def test_the_help_of_a_command_is_short(do, capsys):
    """Its own options first; those of pictures are only named."""
    do("--help")
    said = capsys.readouterr().out
    head, _, rest = said.partition("Examples:\n  cam do --all    all of it\n")
    assert " ".join(head.split()).endswith("Do it. More: cam guide do.")
    assert rest.startswith("\nFiles:\n  a.csv           rows\n")
    own, shared = rest.index("Options:"), rest.index("Scene and run:")
    pictures = rest.index(f"{options.PICTURES}:")
    assert own < rest.index("--with-one X") < shared < rest.index("--threads") < pictures
    assert own < rest.index("--all") < shared
    named = re.findall(r"--[\w-]+", rest[pictures:])
    assert named == ["--format", "--width", "--height", "--style", "--no-title", "--panels"]
    assert len(rest[pictures:].strip().splitlines()) < 4
    assert "--help" not in rest
    assert "The rest" not in said
    do("--help", name="other")
    said = capsys.readouterr().out
    assert "Pictures" not in said
    assert "--threads" in said


# --- panels and tables


@pytest.mark.parametrize(
    ("command", "section", "scene", "lacking"),
    [
        ("sweep", {"lyapunov": True}, {}, {*panels.SEAT}),
        ("sweep", {"lyapunov": False}, {}, {*panels.SEAT, "exponents"}),
        ("simulate", {}, {}, {"radius", "angle"}),
        ("orbits", {"prove": False}, {}, {"attraction"}),
        ("orbits", {"prove": True}, {}, set()),
        ("detach", {}, {}, {"springs", "surge", "machines", "shares"}),
        ("detach", {"hold_to": 7}, {"spring": Made(mass=None)}, {"surge", "machines", "shares"}),
        ("detach", {"tolerance": [1]}, {"spring": Made(mass=0.1)}, {"springs"}),
    ],
)
def test_panels_of_what_is_not_measured(monkeypatch, command, section, scene, lacking):
    seats = []
    monkeypatch.setattr(panels, "has_seat", lambda scene, keys: seats.append(keys))
    own = {"lyapunov": False, "vary": [Made(key="cam.lash")], "hold_to": None, "tolerance": ()}
    whole = Made(**{command: Made(**{**own, **section}), "spring": None, **scene})
    assert {*panels._cures_of_lacking(command, whole, False)} == lacking
    assert seats == [["cam.lash"]] * (command == "sweep")
    if command == "simulate":
        assert panels._cures_of_lacking(command, whole, True) == {}


@pytest.mark.parametrize(
    ("faced", "kind", "refused"),
    [(None, "arcs", False), ("no face", "arcs", False), ("flat", "arcs", True),
     (None, "eccentric", True)],
)  # fmt: skip
def test_the_geometry_of_a_cam_is_that_of_one_under_a_tip(faced, kind, refused):
    contact = None if faced is None else Made(face=None if faced == "no face" else faced)
    scene = Made(contact=contact, cam=Made(kind=kind), orbits=Made(prove=True))
    panels._refuse_lacking("--panels", "orbits", scene, ["motion"])
    lacking = Made(contact=contact, cam=scene.cam, orbits=Made(prove=False))
    with pytest.raises(SceneError) as told:
        panels._refuse_lacking("--panels", "orbits", lacking, ["attraction", "geometry"])
    (one,) = told.value.faults
    assert (one.where, one.found, one.cure) == (
        "--panels", "found 'attraction', not measured", "add --prove"
    )  # fmt: skip
    if not refused:
        panels._refuse_lacking("--panels", "orbits", scene, ["geometry"])
        return
    with pytest.raises(SceneError, match=r"--panels: plot\.panels: found 'geometry', expected a"):
        panels._refuse_lacking("--panels", "orbits", scene, ["motion", "geometry"])
    for asked, option in ((Request(panels="a"), "--panels"), (Request(sets=["plot.panels=[a]"]),
                          "--set"), (Request(sets=[" plot = 1"]), "--set"),
                          (Request(sets=["plot.width=1"]), None), (Request(), None)):  # fmt: skip
        assert panels._asked_by(asked) == option


@pytest.mark.parametrize(
    ("command", "section", "drawn"),
    [
        ("simulate", {"profile_only": True}, ["profile"]),
        ("simulate", {"profile_only": False}, ["motion"]),
        ("sweep", {"vary": "ab"}, ["map"]),
        ("sweep", {"vary": "a"}, ["diagram"]),
        ("sweep", {"vary": ""}, ["diagram"]),
        ("basins", {"count": 3}, ["window"]),
        ("basins", {"count": 4}, ["range"]),
        ("classify", {}, [*panels.PANELS["classify"]]),
    ],
)
def test_pictures_that_a_run_will_draw(command, section, drawn):
    assert panels._drawn(command, Made(**{command: Made(**section)})) == drawn


@pytest.mark.parametrize(
    ("command", "name", "known", "cure"),
    [
        ("basins", "fractions", ["basins"], "ask for more than three speeds"),
        ("basins", "basins", ["fractions"], "ask for at most three speeds"),
        ("simulate", "lift", ["motion", "gap"], "add --profile-only"),
        ("orbits", "boxes", ["phases"], "add --chaos"),
        ("orbits", "plane", ["boxes"], "give a range: --rpm LO:HI"),  # of two pictures the first
        ("sweep", "exponents", [], "vary one number, not two"),
        ("sweep", "labels", ["impacts", "strobe"], "it is a panel of cam classify"),
        ("sweep", "phases", ["impacts", "strobe"], "it is a panel of cam detach"),
        ("detach", "spring", ["phases", "springs"], "did you mean 'springs'?"),
    ],
)
def test_what_would_draw_a_panel(command, name, known, cure):
    fault = panels._fault("--panels", command, name, known)
    assert (fault.where, fault.path, fault.found) == ("--panels", "plot.panels", f"found '{name}'")
    assert fault.cure == cure


def test_all_panels_that_a_run_does_not_draw_are_told_at_once(monkeypatch):
    """Of the command line; what is drawn is then asked whether it is measured."""
    lacking = []
    monkeypatch.setattr(panels, "_refuse_lacking", lambda *given: lacking.append(given))
    scene = Made(plot=Made(panels=["springs", "impacts", "boxes"]), sweep=Made(vary=()))
    request = Request(panels="x")
    with pytest.raises(SceneError) as refused:
        panels.check_panels("sweep", scene, request)
    assert [fault.found for fault in refused.value.faults] == ["found 'springs'", "found 'boxes'"]
    assert lacking == []
    scene.plot.panels = ["impacts"]
    panels.check_panels("sweep", scene, request)
    assert lacking == [("--panels", "sweep", scene, ["impacts"])]
    for quiet in (Made(plot=Made(panels=None)), Made(plot=Made(panels=["springs"]))):
        panels.check_panels("explore", quiet, request)
    panels.check_panels("sweep", Made(plot=Made(panels=None)), request)
    assert len(lacking) == 1
    speeds = Made(start=600.0, stop=700.0)
    both = Made(vary=(), parameter="rpm", rpm=speeds, all=None, chaos=True, curve="fold")
    scene = Made(plot=Made(panels=["multipliers", "boxes", "curves"]), orbits=both)
    panels.check_panels("orbits", scene, request)  # each is of another picture of this run
    assert len(lacking) == 2


def test_a_table_that_needs_no_colours(monkeypatch, capsys):
    """Heads left and right as their columns; with a line as long; what is empty is a dash."""
    monkeypatch.setattr("sys.stdout.isatty", lambda: False)
    for name in report.RICH_SETTINGS:
        monkeypatch.delenv(name, raising=False)
    rows = [["P(1;1)", "12", "x"], ["inf", "", "y"]]
    report.table("title", ["label", "number", "hidden"], rows, hidden=1)
    said = capsys.readouterr().out.splitlines()
    assert said == [
        "",
        "title",
        "label   number",
        "\u2500" * 14,
        "P(1;1)      12",
        "inf          -",
    ]
    assert report._print_wide("title", ["a"], [["x" * 140]])
    assert not report._print_wide("title", ["a", "b"], [["x" * 100, "y" * 39]])
    assert report._print_wide("title", ["a", "b"], [["x" * 100, "y" * 38]])
    assert not report._print_wide("t" * 141, ["a"], [["x"]])
    assert not report._print_wide("title", ["a"], [["[x]"]])
    for encoding, known in (("UTF-8", True), ("utf8", True), ("latin-1", False), (None, False)):
        stream = Made(encoding=encoding, isatty=lambda: False, write=lambda text: None)
        with monkeypatch.context() as patch:
            patch.setattr("sys.stdout", stream)
            printed = report._print_wide("title", ["a"], [["x"]])
        assert printed is known
    monkeypatch.setenv("COLUMNS", "80")
    assert not report._print_wide("title", ["a"], [["x"]])


# --- the guide


@pytest.mark.parametrize(
    ("topic", "wanted"),
    [
        ("first", "text of first"),
        ("seat", "text of lash"),
        ("Valve", "text of lash"),
        ("chaos", "of chaos\n\nThe whole page: cam guide first\n"),
    ],
)
def test_a_topic_is_a_page_a_subject_or_a_section(monkeypatch, topic, wanted):
    shown = []
    known = {
        name: Made(topic=name, text=lambda name=name: f"text of {name}")
        for name in ("first", "lash")
    }
    sections = {"chaos": (known["first"], "of chaos\n")}
    monkeypatch.setattr("camcli.guide.pages", lambda: known)
    monkeypatch.setattr("camcli.guide.section_of", sections.get)
    monkeypatch.setattr(guide, "_show", shown.append)
    assert guide.guide(Request(), topic) == 0
    assert shown == [wanted]
    assert guide._topics("la") == ["lash"]
    known["seat"] = Made(text=lambda: "a page of its own")
    guide.guide(Request(), "seat")
    assert shown[1:] == ["a page of its own"]
    for lost, cure in (("firts", "did you mean first?"), ("xyz", "cam guide lists them")):
        with pytest.raises(SceneError, match=rf"guide: found '{lost}', expected a topic, {cure}"):
            guide.guide(Request(), lost)


def test_the_list_of_the_guide_is_by_kind(monkeypatch, capsys):
    known = {name: Made(topic=name, kind=kind, title=f"On {name}") for name, kind in (
        ("a", "how-to"), ("b", "tutorial"), ("c", "how-to"))}  # fmt: skip
    monkeypatch.setattr("camcli.guide.pages", lambda: known)
    guide.guide(Request(), None)
    lines = {name: f"  cam guide {name}{'':17} On {name}" for name in "abc"}
    assert capsys.readouterr().out.splitlines() == [
        "Learn:", lines["b"], "Do:", lines["a"], lines["c"], "Understand:", "Look up:"
    ]  # fmt: skip
