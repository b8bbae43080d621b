"""Panels: the names told before a run are those that are drawn; others are refused."""

from types import SimpleNamespace

import pytest

import camcli
from camcli.cli import panels
from camcli.cli.panels import check_panels
from camcli.errors import SceneError
from camcli.plots.picture import Picture
from camcli.quantities import SEAT
from camcli.scene.schema import PANELS
from tests.conftest import refused

SHORT = {"run.transient": 20, "run.record": 30}
SPEEDS = {"orbits.rpm.start": 700, "orbits.rpm.stop": 712, "orbits.starts": 2}
ONE = {**SPEEDS, "orbits.rpm.stop": 700}
CELLS = {"basins.cells": [8, 8], "basins.rpm.start": 699, "basins.rpm.stop": 700}
MAP = [{"key": key, "start": 700, "stop": 701, "num": 2} for key in ("rpm", "follower.stiffness")]
DRAWN = {  # what is drawn: the command, its scene, further arguments; panels that hang on the data
    "motion": ("simulate", {}, {}, ()),
    "profile": ("simulate", {"contact.face": "knife"}, {"profile_only": True}, ("geometry",)),
    "diagram": ("sweep", {"sweep.rpm.num": 3, "sweep.lyapunov": True}, {}, ("enlarged",)),
    "map": ("sweep", {"sweep.vary": MAP}, {}, tuple(SEAT)),
    "loss": (
        "detach",
        {
            "detach.rpm.num": 3,
            "detach.hold_to": 130,
            "spring": {"mass": 0.6},
            "detach.tolerance": [{"key": "follower.mass", "percent": 2.0}],
            "detach.machines": 3,
        },
        {},
        ("enlarged",),
    ),
    "branches": ("orbits", {**SPEEDS, "orbits.rpm.num": 5}, {}, ("event", "attraction")),
    "orbits": ("orbits", ONE, {}, ("attraction",)),
    "window": ("basins", {**CELLS, "basins.rpm.num": 3}, {}, ()),
    "range": ("basins", {**CELLS, "basins.rpm.num": 4}, {}, ()),
    "motions": ("classify", {"classify.rpm.num": 2}, {}, ()),
}


@pytest.mark.parametrize("picture", DRAWN)
def test_the_panels_of_a_picture_have_the_names_that_are_told_before(picture):
    command, values, more, hangs = DRAWN[picture]
    result = getattr(camcli, command)(camcli.load_scene(None, {**SHORT, **values}), **more)
    (drawn,) = (draw() for draw in result.pictures.values())
    assert isinstance(drawn, Picture)
    names = {name.split()[0] for name in drawn.panels}
    told = set(PANELS[command][picture])
    assert names <= told
    assert told <= names | set(hangs)


OF_SWEEP = "found 'labels', expected one of impacts, enlarged, strobe, exponents, it is a panel of"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sweep --panels labels", f"{OF_SWEEP} cam classify"),
        ("simulate --profile-only --set contact.face=knife --panels geometry", "ask for outline"),
        ("sweep --set plot.panels=[labels]", f"--set: plot.panels: {OF_SWEEP} cam classify"),
        (
            "orbits --panels basins",
            "expected one of phases, positions, plane, multipliers, attraction",
        ),
        (
            "orbits --rpm 700 --panels phases",
            "expected one of motion, orbit, plane, attraction, lift, ",
        ),
        ("orbits --panels curves", "add --curve KIND"),
        ("orbits --panels cover", "add --all N,M"),
        ("orbits --panels coverings", "add --chaos"),
        ("classify --panels label", "one of labels, phases, exponents, did you mean 'labels'?"),
        ("classify --panels ''", "--panels: plot.panels.0: found '', expected one of phases, expo"),
        ("simulate --panels lift", "one of motion, gap, phase, section, passage, add --profile-on"),
        ("simulate --profile-only --panels gap", "leave --profile-only out"),
        ("sweep --panels kind", "vary two numbers"),
        ("sweep --panels exponents", "found 'exponents', not measured, add --lyapunov"),
        (
            "sweep --vary rpm=700:710 --vary follower.mass=1:2 --panels seat_velocity_m_per_s",
            "found 'seat_velocity_m_per_s', not measured, give cam.lash in m",
        ),
        ("orbits --panels attraction", "found 'attraction', not measured, add --prove"),
        ("detach --panels springs", "found 'springs', not measured, add --hold-to RPM"),
        ("detach --panels surge", "found 'surge', not measured, give spring.mass in kg"),
        ("detach --panels shares", "found 'shares', not measured, add --tolerance KEY=5%"),
        (
            "simulate --profile-only --panels angle",
            "found 'angle', not measured, give contact.face",
        ),
        ("basins --panels fractions", "expected one of basins, ask for more than three speeds"),
        ("bench --panels phases", "No such option"),
    ],
)
def test_panels_that_are_not_drawn_are_refused_before_any_work(cam, tmp_path, line, said):
    done = cam(line)
    refused(done, said)
    assert "springs" in line or "springs" not in done.stderr  # of detach alone
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("short_samples")
def test_panels_of_the_scene_may_be_meant_for_another_command(cam, tmp_path):
    scene = tmp_path / "scene.yaml"
    machine = "follower: {mass: 1, stiffness: 1000, restitution: 0.5}\n"
    machine += "cam: {kind: eccentric, base: 0.1, lift: 0.1}\n"
    scene.write_text(f"{machine}plot: {{panels: [labels]}}\n")
    said = cam("sweep -c scene.yaml --rpm 100:200 --points 2 --dry-run", code=0).stderr
    assert "plot.panels of the scene names none that cam sweep draws here (impacts, enl" in said
    said = cam("classify -c scene.yaml --rpm 100:200 --points 2 --dry-run", code=0).stderr
    assert "plot.panels" not in said
    scene.write_text(f"{machine}plot: {{panels: [label]}}\n")
    done = cam("classify -c scene.yaml")
    refused(done, "scene.yaml:3:17: plot.panels.0: found 'label', expected one of labels, phases, ")


def test_the_library_refuses_panels_that_the_picture_does_not_have():
    result = camcli.sweep(camcli.load_scene(None, {**SHORT, "sweep.rpm.num": 2}))
    assert camcli.plot(result, panels=["strobe"])
    for name in ("labels", "exponents", "nothing"):
        with pytest.raises(SceneError, match=f"found '{name}', expected one of impacts, "):
            camcli.plot(result, panels=["strobe", name])


@pytest.mark.parametrize(
    ("command", "panel"),
    [("sweep", "exponents"), ("simulate", "angle"), ("detach", "springs"), ("detach", "surge"),
     ("detach", "machines"), ("detach", "shares")],
)  # fmt: skip
def test_panels_that_are_not_measured_are_refused_only_where_this_run_asks_for_them(
    command, panel, capsys
):
    """By --panels or --set; those in the scene's own file may be meant for another run."""
    usual = {"sweep": "impacts", "simulate": "lift", "detach": "phases"}[command]
    scene = camcli.load_scene(
        None, {"plot.panels": [usual, panel], "simulate.profile_only": command == "simulate"}
    )
    asked = {"no_plot": False, "panels": None, "sets": (), "quiet": False}
    check_panels(command, scene, SimpleNamespace(**asked))
    assert capsys.readouterr().err == ""
    for more in ({"panels": f"{usual},{panel}"}, {"sets": (f"plot.panels=[{usual},{panel}]",)}):
        with pytest.raises(SceneError, match=f"found '{panel}', not measured"):
            check_panels(command, scene, SimpleNamespace(**{**asked, **more}))
    check_panels(command, scene, SimpleNamespace(**{**asked, "panels": panel, "no_plot": True}))


TWO = [{"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 3},
       {"key": "follower.damping", "start": 0.0, "stop": 1.0, "num": 3}]  # fmt: skip
WITHIN = {"orbits.rpm.start": 700, "orbits.rpm.stop": 712}
ALONE = {**WITHIN, "orbits.rpm.stop": 700}
ALL = {**ALONE, "orbits.all": {"turns": 1, "impacts": 2}}
FORM = {"orbits.curve": "fold", "orbits.curve_range": [0.7, 0.8]}
AS_DRAWN = [  # command, values: its pictures
    ("simulate", {}, ["motion"]),
    ("simulate", {"simulate.profile_only": True}, ["profile"]),
    ("sweep", {}, ["diagram"]),
    ("sweep", {"sweep.vary": TWO[:1]}, ["diagram"]),
    ("sweep", {"sweep.vary": TWO}, ["map"]),
    ("basins", {**CELLS, "basins.rpm.num": 3}, ["window"]),
    ("basins", {**CELLS, "basins.rpm.num": 4}, ["range"]),
    ("orbits", WITHIN, ["branches"]),
    ("orbits", ALONE, ["orbits"]),
    ("orbits", {"orbits.vary": TWO[:1], **ALONE}, ["branches"]),
    ("orbits", {**ALONE, "orbits.chaos": True}, ["orbits", "chaos"]),
    ("orbits", {**WITHIN, **FORM}, ["branches", "curve"]),
    ("orbits", ALL, ["orbits", "cover"]),
    ("detach", {}, ["loss"]),
    ("classify", {}, ["motions"]),
]  # fmt: skip


@pytest.mark.parametrize(("command", "values", "pictures"), AS_DRAWN)
def test_the_pictures_of_a_run_are_known_before(command, values, pictures):
    assert panels._drawn(command, camcli.load_scene(None, values)) == pictures
