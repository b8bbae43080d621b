"""From a lift table to a verdict, as somebody who knows engines and no bifurcations would go."""

import json

import pytest

from camcli.analysis.contact_loss.detachment import detachment
from camcli.system import Follower, System
from tests.cams.lift_tables import Lobe, scene, smooth, table


@pytest.fixture
def begun(cam, tmp_path):
    """A folder with a table and the scene that cam init wrote for it."""
    (tmp_path / "lobe.csv").write_text(table(Lobe(smooth), 1, decimals=3))
    assert cam("init", "lobe.csv").returncode == 0
    return tmp_path


def test_init_overwrites_nothing_and_writes_a_scene_to_fill_in(cam, begun):
    before = (begun / "lobe.yaml").read_bytes()
    again = cam("init", "lobe.csv")
    assert (again.returncode, again.stdout) == (2, "")
    assert "lobe.yaml: found a file of this name" in again.stderr
    assert cam("init", "lobe.csv", "--force").returncode == 0
    assert (begun / "lobe.yaml").read_bytes() == before
    assert cam("init").returncode == 0
    assert cam("detach", "-c", "scene.yaml", "--no-plot", "--points", "3").returncode == 0


@pytest.mark.parametrize("command", ["sweep", "detach", "orbits", "classify", "basins"])
def test_a_range_that_is_not_given_comes_from_the_machine(cam, begun, command):
    done = cam(command, "-c", "lobe.yaml", "--dry-run")
    assert done.returncode == 0, done.stderr
    words = done.stderr.partition(f"note: {command}.rpm is not given: ")[2].split()
    assert 2300 < float(words[0]) < 3500  # about the loss of contact, not another machine
    given = cam(command, "-c", "lobe.yaml", "--dry-run", "--rpm", "100:200")
    assert "is not given" not in given.stderr
    assert "is not given" not in cam(command, "--dry-run").stderr


def test_a_run_begins_with_a_verdict(cam, begun):
    short = ("--no-plot", "--set", "run.transient=5", "--set", "run.record=5", "--points", "5")
    done = cam("detach", "-c", "lobe.yaml", *short, "--hold-to", "5000")
    assert done.returncode == 0, done.stderr
    verdict = done.stdout.splitlines()[0]
    speed, error = (float(x) for x in verdict.split("up to ")[1].split(" rpm")[0].split(" +- "))
    low, high = json.loads((begun / "out/detach/run.json").read_text())["error"]["lift_table"][
        "first_detachment_rpm"
    ]
    assert speed - error < low + 1
    assert high - 1 < speed + error
    assert error < 0.1 * speed
    assert "To hold up to 5000 rpm of the cam with 0 N to spare: a stiffer spring" in verdict
    assert "; or another spring: " in verdict

    done = cam("sweep", "-c", "lobe.yaml", *short)
    assert done.stdout.startswith(f"Contact holds up to {speed:.0f} +- ")
    assert " rpm, the follower lands at up to " in done.stdout.splitlines()[0]
    done = cam("simulate", "-c", "lobe.yaml", "--rpm", "100", *short[:-2])
    assert done.stdout.startswith("At 100 rpm of the cam contact holds")
    done = cam("detach", "--set", "follower.preload=-200", *short)
    assert done.stdout.startswith("Contact is lost at every speed: the spring does not press even")


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        ("cam.rocker_ratio=26.4", "a lift of 264 mm; is it in m, or cam.lift the file's unit?"),
        ("cam.base_radius=36", "a base radius of 36 m"),
        ("follower.preload=-5", "a preload of -5 N pulls the follower off the cam"),
    ],
)
def test_a_wrong_unit_or_sign_is_doubted(cam, begun, sets, said):
    done = cam("simulate", "-c", "lobe.yaml", "--dry-run", "--set", sets)
    assert f"warning: {said}" in done.stderr
    assert "warning" not in cam("simulate", "-c", "lobe.yaml", "--dry-run").stderr
    (begun / "radii.csv").write_text(
        "".join(f"{k},{18 + Lobe(smooth).at(k)[0] * 1e3:.3f}\n" for k in range(360))
    )
    radii = cam("simulate", "-c", "lobe.yaml", "--dry-run", "--set", "cam.file=radii.csv",
                "--set", "cam.header=0", "--set", "cam.angle_column=1",
                "--set", "cam.lift_column=2")  # fmt: skip
    assert "the smallest lift of the table is 18 mm; if these are radii" in radii.stderr


def test_a_spring_of_hold_to_holds_the_cam_that_was_measured(cam, begun):
    """The table is rounded; with its true law the springs hold as well."""
    short = ("--no-plot", "--points", "2", "--set", "detach.settle=0", "--hold-to", "5000")
    assert cam("detach", "-c", "lobe.yaml", *short).returncode == 0
    springs = json.loads((begun / "out/detach/run.json").read_text())["result"]["hold"]
    exact = begun / "exact"
    exact.mkdir()
    law = scene(exact, table(Lobe(smooth), 0.5, decimals=12)).cam.parts()
    for spring in springs:
        assert spring["detaches_rpm"] > 5010  # of the smoothed cam: the error is to spare
        follower = Follower(0.12, spring["stiffness"], 20.0, 0.0, spring["preload"], 0.4)
        assert 5000 < detachment(System.build(follower, law)).first.rpm < 6000
