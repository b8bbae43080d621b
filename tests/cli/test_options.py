"""What every option of the commands that compute sets: these keys of the scene, and no other."""

from __future__ import annotations

from pathlib import Path

import pytest

from camcli.api import ANALYSES
from camcli.cli.options import _parameters
from camcli.scene import resolved

SHARED = [  # of every command that computes, held with one
    ("--set follower.mass=2.5", {"follower.mass": 2.5}),
    ("--format pdf,svg", {"plot.formats": ["pdf", "svg"]}),
    ("--width 3.3in", {"plot.width": 83.82}),
    ("--width 85mm", {"plot.width": 85.0}),
    ("--height 12cm", {"plot.height": 120.0}),
    ("--height 144pt", {"plot.height": 50.8}),
    ("--no-plot --font 'DejaVu Sans'", {"plot.font": "DejaVu Sans"}),
    ("--no-plot --style ggplot", {"plot.style": "ggplot"}),
    ("--no-title", {"plot.title": False}),
    ("--set run.record=7 --set run.record=8", {"run.record": 8}),
    ("--set run.record=7 --width 60", {"run.record": 7, "plot.width": 60.0}),
]


def speeds(section, low, high, num=None):
    """The keys of a range of speeds."""
    found = {f"{section}.rpm.start": low, f"{section}.rpm.stop": high}
    return found if num is None else found | {f"{section}.rpm.num": num}


def axis(key, low, high, num):
    """A number that varies, as it stands in the record."""
    return {"key": key, "start": low, "stop": high, "num": num}


CRANK = {"run.crank": True}  # a speed of a crank says that there is one
MASS = axis("follower.mass", 1.0, 2.0, 5)
OWN = {
    "simulate": [
        ("--rpm 650", {"run.rpm": 650.0}),
        ("--rpm 1300crank", {"run.rpm": 650.0} | CRANK),
        ("--points 7", {"simulate.samples": 7}),
        ("--profile-only", {"simulate.profile_only": True}),
        ("--profile-only --base-radius 0.9",
         {"simulate.profile_only": True, "simulate.base_radius": 0.9}),
        ("--animate", {"simulate.animate": True}),
        ("--panels gap,phase", {"plot.panels": ["gap", "phase"]}),
    ],
    "sweep": [
        ("--rpm 650:651", speeds("sweep", 650.0, 651.0)),
        ("--rpm 1300crank:1302crank", speeds("sweep", 650.0, 651.0) | CRANK),
        ("--rpm 650", speeds("sweep", 650.0, 650.0, 1)),
        ("--points 7", {"sweep.rpm.num": 7}),
        ("--lyapunov", {"sweep.lyapunov": True}),
        ("--explain", {"sweep.explain": True}),
        ("--vary follower.mass=1:2 --points 5", {"sweep.vary": [MASS]}),
        ("--vary follower.mass=1:2 --points 5 --rpm 650",
         {"sweep.vary": [MASS], "run.rpm": 650.0}),
        ("--rpm 650:651 --vary follower.mass=1:2 --points 3,5",
         {"sweep.vary": [axis("rpm", 650.0, 651.0, 3), MASS]}),
        ("--vary rpm=1300crank:1302crank --points 3",
         {"sweep.vary": [axis("rpm", 650.0, 651.0, 3)]} | CRANK),
        ("--zoom 700:701 --zoom 702:703",
         {"sweep.zoom": [{"start": 700.0, "stop": 701.0, "num": 201},
                         {"start": 702.0, "stop": 703.0, "num": 201}]}),
        ("--zoom 700:701 --points 9,4",
         {"sweep.rpm.num": 9, "sweep.zoom": [{"start": 700.0, "stop": 701.0, "num": 4}]}),
        ("--both", {"sweep.direction": "both"}),
        ("--adaptive", {"sweep.adaptive": True}),
        ("--branches some.csv", {"sweep.branches": "some.csv"}),
        ("--vary follower.mass=1:2 --vary rpm=650:651 --points 5 --curves auto",
         {"sweep.vary": [MASS, axis("rpm", 650.0, 651.0, 5)], "sweep.curves": "auto"}),
        ("--vary follower.mass=1:2 --vary rpm=650:651 --points 5 --curves auto --prove",
         {"sweep.vary": [MASS, axis("rpm", 650.0, 651.0, 5)], "sweep.curves": "auto",
          "sweep.prove": True}),
        ("--vary follower.mass=1:2 --vary rpm=650:651 --points 5 --decide",
         {"sweep.vary": [MASS, axis("rpm", 650.0, 651.0, 5)], "sweep.decide": True}),
        ("--panels strobe", {"plot.panels": ["strobe"]}),
    ],
    "detach": [
        ("--rpm 150:160", speeds("detach", 150.0, 160.0)),
        ("--rpm 150", speeds("detach", 150.0, 150.0, 1) | {"detach.force_rpm": [150.0]}),
        ("--rpm 300crank",
         speeds("detach", 150.0, 150.0, 1) | {"detach.force_rpm": [150.0]} | CRANK),
        ("--points 6", {"detach.rpm.num": 6}),
        ("--hold-to 200", {"detach.hold_to": 200.0}),
        ("--hold-to 400crank", {"detach.hold_to": 200.0} | CRANK),
        ("--tolerance follower.mass=5%,follower.stiffness=3% --tolerance follower.preload=2.5%",
         {"detach.tolerance": [{"key": "follower.mass", "percent": 5.0},
                               {"key": "follower.stiffness", "percent": 3.0},
                               {"key": "follower.preload", "percent": 2.5}]}),
        ("--report", {"detach.report": True}),
        ("--prove", {"detach.prove": True}),
        ("--panels forces", {"plot.panels": ["forces"]}),
    ],
    "orbits": [
        ("--rpm 650:700", speeds("orbits", 650.0, 700.0)),
        ("--rpm 650", speeds("orbits", 650.0, 650.0) | {"orbits.at": 650.0}),
        ("--points 6", {"orbits.rpm.num": 6}),
        ("--rpm 650:700 --at 660", speeds("orbits", 650.0, 700.0) | {"orbits.at": 660.0}),
        ("--rpm 650:700 --at 1320crank",
         speeds("orbits", 650.0, 700.0) | {"orbits.at": 660.0} | CRANK),
        ("--label 'P(2;1:1)'", {"orbits.label": "P(2;1:1)"}),
        ("--parameter mass --range 1:2", {"orbits.parameter": "mass", "orbits.range": [1.0, 2.0]}),
        ("--branches 5", {"orbits.branches": 5}),
        ("--curve fold", {"orbits.curve": "fold"}),
        ("--curve fold --in damping --range 0:2",
         {"orbits.curve": "fold", "orbits.curve_in": "damping", "orbits.range": [0.0, 2.0]}),
        ("--parameter mass --range 1:2 --curve fold --in damping=0:2",
         {"orbits.parameter": "mass", "orbits.range": [1.0, 2.0], "orbits.curve": "fold",
          "orbits.curve_in": "damping", "orbits.curve_range": [0.0, 2.0]}),
        ("--curve fold --in follower.mass=1:2 --points 5",
         {"orbits.curve": "fold", "orbits.vary": [MASS]}),
        ("--curve fold --in mass=1:2 --in rpm=650:700 --points 5",
         {"orbits.curve": "fold", "orbits.vary": [MASS, axis("rpm", 650.0, 700.0, 5)]}),
        ("--vary follower.mass=1:2 --points 5", {"orbits.vary": [MASS]}),
        ("--all 3,2", {"orbits.all": {"impacts": 3, "turns": 2}}),
        ("--prove", {"orbits.prove": True}),
        ("--prove --with-checker", {"orbits.prove": True, "orbits.checker": True}),
        ("--rpm 745 --chaos",
         speeds("orbits", 745.0, 745.0) | {"orbits.at": 745.0, "orbits.chaos": True}),
        ("--panels multipliers", {"plot.panels": ["multipliers"]}),
    ],
    "basins": [
        ("--rpm 650:651", speeds("basins", 650.0, 651.0)),
        ("--rpm 650", speeds("basins", 650.0, 650.0, 1)),
        ("--points 6 --rpm 650:651", speeds("basins", 650.0, 651.0, 6)),
        ("--cells 9", {"basins.cells": [9, 9]}),
        ("--cells 9,4", {"basins.cells": [9, 4]}),
        ("--cells 9x4", {"basins.cells": [9, 4]}),
        ("--q 0.2:0.4", {"basins.q": [0.2, 0.4]}),
        ("--v -3:4", {"basins.v": [-3.0, 4.0]}),
        ("--refine 2", {"basins.refine": 2}),
        ("--boundary", {"basins.boundary": True}),
        ("--exponents", {"basins.exponents": True}),
        ("--vary follower.mass=1:2 --points 5", {"basins.vary": [MASS]}),
        ("--saddles", {"basins.saddles": True}),
        ("--panels basins", {"plot.panels": ["basins"]}),
    ],
    "classify": [
        ("--rpm 650:651", speeds("classify", 650.0, 651.0)),
        ("--rpm 650", speeds("classify", 650.0, 650.0, 1)),
        ("--points 6 --rpm 650:651", speeds("classify", 650.0, 651.0, 6)),
        ("--starts 3", {"classify.starts": 3}),
        ("--starts 3 --seed 4", {"classify.starts": 3, "classify.seed": 4}),
        ("--rpm 650:651 --explain", speeds("classify", 650.0, 651.0) | {"classify.explain": True}),
        ("--vary follower.mass=1:2 --points 5", {"classify.vary": [MASS]}),
        ("--panels labels", {"plot.panels": ["labels"]}),
    ],
    "explore": [
        ("--rpm 650:651", speeds("sweep", 650.0, 651.0)),
        ("--points 6", {"sweep.rpm.num": 6}),
        ("--with basins", {"explore.basins": True}),
        ("--with map --rpm 650:651 --vary follower.mass=1:2 --points 3,5",
         speeds("sweep", 650.0, 651.0, 3) | {"explore.map": True, "sweep.vary": [MASS]}),
        ("--with map,basins --vary follower.mass=1:2 --points 3,5",
         {"sweep.rpm.num": 3, "explore.map": True, "explore.basins": True, "sweep.vary": [MASS]}),
        ("--set follower.mass=2.5",
         {"follower.mass": 2.5, "explore.source": "--set follower.mass=2.5"}),
    ],
}  # fmt: skip
USUAL: dict[str, dict] = {}  # of each command, the scene with which it runs without options
ELSEWHERE = {  # options that set nothing of a scene, and where they are held
    "config": "tests/cli/test_faults.py",
    "out": "tests/cli/test_commands.py",
    "no_plot": "tests/cli/test_commands.py",
    "json": "tests/cli/test_commands.py",
    "verbose": "tests/truth/test_screen_words.py",
    "quiet": "tests/cli/test_faults.py",
    "threads": "tests/properties/test_same_bytes.py",
    "dry_run": "tests/cli/test_plan.py",
    "shard": "tests/cli/test_merge.py",
    "cluster": "tests/cli/test_cluster.py",
    "open_": "tests/output/test_explore.py",
    "trace": "tests/cli/test_classify.py",
    "det": "tests/cli/test_classify.py",
}
CASES = [
    (command, line, keys)
    for command in ANALYSES
    for line, keys in [*OWN[command], *(SHARED if command == "simulate" else ())]
]


def flat(value, path=""):
    """The leaves of maps by their dotted path; a list, and what an axis varies, is a leaf."""
    if not isinstance(value, dict) or path in ("orbits.all",):
        return {path: value}
    return {
        name: leaf
        for key, inner in value.items()
        for name, leaf in flat(inner, f"{path}.{key}".lstrip(".")).items()
    }


@pytest.fixture
def asked(cam, monkeypatch):
    """The leaves of the scene with which a line of the command would run."""

    def of(line):
        scenes = []
        monkeypatch.setattr(
            "camcli.cli.run.execute", lambda _, scene, *__, **___: scenes.append(scene) or 0
        )
        cam(line, code=0)
        return flat(resolved(scenes[0]))

    return of


@pytest.mark.parametrize(("command", "line", "keys"), CASES)
def test_an_option_sets_its_keys_and_no_other(asked, command, line, keys):
    if command not in USUAL:
        USUAL[command] = asked(command)
    usual, found = USUAL[command], asked(f"{command} {line}")
    changed = {key: value for key, value in found.items() if value != usual.get(key)}
    assert changed == keys
    assert set(usual) <= set(found)


@pytest.mark.parametrize("command", ANALYSES)
def test_every_option_has_a_line_here(command):
    """Of those of the command alone: the shared ones are those of every command."""
    from importlib import import_module

    from camcli.cli.options import DRAWING, SCENE, Request

    module = import_module(f"camcli.cli.{command}")
    without = getattr(module, "WITHOUT", ())
    shared = [p for p in _parameters(Request) if p.name not in without]
    lines = " ".join(line for line, _ in [*OWN[command], *SHARED])
    for parameter in [*shared, *_parameters(getattr(module, command))[1:]]:
        names = [n for n in parameter.default.param_decls if n.startswith("-")]
        assert parameter.name in ELSEWHERE or any(f"{name} " in f"{lines} " for name in names)
    assert {*SCENE, *DRAWING} & ELSEWHERE.keys() == {"config"}
    assert all((Path(__file__).parents[2] / file).is_file() for file in ELSEWHERE.values())
