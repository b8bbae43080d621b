"""How many rows a page has: bounded whatever the machine, or the motion is refused."""

from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import camcli
from camcli.api.explore_motions import MOST_ROWS, ROOM, rows_of_the_page, rows_per_turn
from camcli.api.machine import machine_of
from camcli.cli.explore import path_to_show
from camcli.system import Follower
from tests.conftest import refused

CONFIGS = Path(__file__).parents[2] / "configs"
FEW = "--set run.transient=5 --set run.record=10 --set orbits.starts=0"


def test_a_map_over_any_damping_has_a_page_of_bounded_length():
    """It followed every motion in steps of the fastest decay: a million million rows."""
    axes = [{"key": "follower.damping", "start": 1e-9, "stop": 1e9, "num": 2}]
    scene = {"sweep.vary": axes, "sweep.rpm.num": 2, "run.transient": 5, "run.record": 10}
    result = camcli.explore(camcli.load_scene(None, {**scene, "orbits.starts": 0}), with_map=True)
    rows = [len(one.trajectory) for one in result.values.simulations]
    assert sum(rows) < MOST_ROWS + ROOM
    assert max(rows) < 20_000


@pytest.mark.parametrize(
    ("stiffness", "damping", "rows"),
    [
        (1e4, 0.0, 250),  # 100 rad in a turn of a second, 0.4 rad a row
        (1e4, 150.0, 250),  # as long as it swings
        (300.0, 0.0, 48),  # 17.3 rad are 43.3 steps
        (1e4, 1000.0, 2000),  # 500 + 490 = 990 1/s: 2475 steps, of which 2000 are shown
        (1e4, 500.0, 1198),  # 250 + sqrt(250^2 - 100^2) = 479.13 1/s are 1197.8 steps
        (4e6, 0.0, 5000),  # what swings is followed however fast
    ],
)
def test_a_page_has_a_row_for_each_two_fifths_of_a_radian(stiffness, damping, rows):
    """Of the follower's fastest motion: a cubic is within 0.4^4/384 of it."""
    assert rows_per_turn(Follower(1.0, stiffness, damping=damping), 60.0) == rows
    heavy = Follower(4.0, 4.0 * stiffness, damping=4.0 * damping)  # the same motion
    assert rows_per_turn(heavy, 60.0) == rows


@pytest.mark.parametrize(("start", "stop"), [(60.0, 120.0), (120.0, 60.0)])
def test_the_slowest_speed_of_a_page_has_the_most_rows(start, stop):
    sweep = SimpleNamespace(rpm=SimpleNamespace(start=start, stop=stop))
    machine = SimpleNamespace(
        scene=SimpleNamespace(sweep=sweep), system=SimpleNamespace(follower=Follower(1.0, 1e4))
    )
    assert rows_of_the_page(machine) == 250


def test_heavy_damping_alone_is_shown(cam, tmp_path):
    """It asked for at most 0 points."""
    cam("explore --set follower.damping=1e9 --rpm 700:710 --points 2", FEW, code=0)
    assert (tmp_path / "out/explore/explore.html").stat().st_size < 1e6


def test_motions_that_stop_before_their_first_row_are_left_out(cam, tmp_path, monkeypatch):
    """It was a fault of the page; and a second run found a run.json that no run had left."""
    explore = import_module("camcli.api.explore")
    motions = [SimpleNamespace(label="P(1;1)", rpm=rpm, origin="", turns=1) for rpm in (1.0, 2.0)]
    stand_ins = {
        "_computed": lambda *_: {},
        "attractors": lambda *_: motions,
        "motions_of_stops": lambda *_: [],
        "_simulated": lambda machine, motion, _: SimpleNamespace(trajectory=rows[motion.rpm]),
    }
    for name, stand_in in stand_ins.items():
        monkeypatch.setattr(explore, name, stand_in)
    rows = {1.0: [], 2.0: [(0.0,) * 7]}
    found = explore._explored(machine_of(None), None, None, [])
    assert (found.motions, len(found.simulations)) == (motions[1:], 1)
    rows[2.0] = []
    for _ in range(2):
        done = cam("explore", code=3)
        assert "no whole turn of any motion was recorded: there is no page to show" in done.stderr
        assert [path.name for path in (tmp_path / "out/explore").iterdir()] == ["run.json"]
    (tmp_path / "out/explore/run.json").write_text("{}")
    assert "found run.json, which no run has left there" in cam("explore", code=2).stderr


@pytest.mark.parametrize("damping", [300.0, 3e3, 3e4, 3e6])
def test_a_cubic_from_row_to_row_is_the_motion_however_it_is_damped(damping):
    """Beside the motion sampled 16 times as finely, within a thousandth of the lift."""
    scene = camcli.load_scene(
        None,
        {"follower.damping": damping, "run.transient": 3, "run.record": 2, "run.start.q": 1.2,
         "run.start.v": -200.0},
    )  # fmt: skip
    rows = rows_per_turn(Follower(*dict(scene.follower).values()), 700.0)
    coarse, fine = (
        camcli.simulate(
            scene.model_copy(
                update={"simulate": scene.simulate.model_copy(update={"samples": samples})}
            )
        ).tables["trajectory"]
        for samples in (rows, 16 * rows)
    )
    t, q, v = (coarse[name] for name in ("t_s", "q_m", "v_m_per_s"))
    k = np.clip(np.searchsorted(t, fine["t_s"], side="right") - 1, 0, len(t) - 2)
    h = t[k + 1] - t[k]
    s = np.divide(fine["t_s"] - t[k], h, out=np.zeros_like(h), where=h > 0)
    cubic = (
        (1 + 2 * s) * (1 - s) ** 2 * q[k]
        + s * (1 - s) ** 2 * h * v[k]
        + s * s * (3 - 2 * s) * q[k + 1]
        + s * s * (s - 1) * h * v[k + 1]
    )
    lift = np.ptp(fine["c_m"])
    assert np.abs(cubic - fine["q_m"]).max() < 1e-3 * lift


def test_what_is_too_fast_to_be_shown_is_refused_before_any_work(cam, tmp_path):
    refused(
        cam("explore --set follower.stiffness=1e16 --rpm 1:2 --points 2"),
        "sweep.rpm: found motions of 13574799604 rows a turn at 1 rpm, expected at most 250000",
    )
    refused(
        cam("explore --with map --vary follower.stiffness=0:1e12 --points 2,20"),
        "rows a turn, at rpm = 660 and follower.stiffness = 1e+12, expected at most 10937",
    )
    assert list(tmp_path.iterdir()) == []


def test_the_commands_of_a_page_name_a_file_elsewhere_without_its_path(cam, tmp_path):
    """A page is given away; a path tells who has made it, and leads nowhere there."""
    scene = tmp_path / "elsewhere" / "scene.yaml"
    scene.parent.mkdir()
    scene.write_text((CONFIGS / "eccentric.yaml").read_text())
    cam(f"explore -c {scene} --rpm 20:21 --points 2 -o out", FEW, code=0)
    text = (tmp_path / "out/explore.html").read_text(encoding="utf-8")
    assert str(tmp_path) not in text
    assert "-c elsewhere/scene.yaml" in text
    assert path_to_show(Path("/far/away/scene.yaml")) == "scene.yaml"
