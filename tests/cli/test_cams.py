"""Every kind of cam through every command, and the files of configs/."""

import json
from math import pi
from pathlib import Path

import pytest

from camcli.scene import load_scene
from tests.conftest import rows

ROOT = Path(__file__).parents[2]
CONFIGS = sorted(path for path in (ROOT / "configs").glob("*.yaml"))
COMMANDS = ["simulate", "sweep", "detach", "orbits", "classify"]
FOLLOWER = "follower: {mass: 1, stiffness: 1000, restitution: 0.6, preload: 40, damping: 1}\n"
REST = """
run: {rpm: 150, transient: 20, record: 20}
sweep: {rpm: {start: 120, stop: 160, num: 5}}
detach: {rpm: {start: 100, stop: 200, num: 11}}
orbits: {rpm: {start: 140, stop: 160, num: 5}, starts: 1}
classify: {rpm: {start: 140, stop: 160, num: 3}}
"""
LOBE = "base: -0.02, lift: 0.05, rise: {start_deg: 300, length_deg: 90, law: %s}, fall: %s"
KINDS = {
    "smooth": "{kind: law, " + LOBE % ("4-5-6-7", "{length_deg: 90, law: cycloidal}") + "}",
    "corners": "{kind: law, " + LOBE % ("harmonic", "{length_deg: 80, law: modified-sine}") + "}",
    "kinks": "{kind: law, "
    + LOBE % ("constant-velocity", "{length_deg: 90, law: {scca: {b: 0.2, c: 0.3, d: 0.5}}}")
    + "}",
    "eccentric": "{kind: eccentric, base: -0.06, lift: 0.05}",
}


def write(folder, cam, follower=FOLLOWER):
    """A scene file with this cam."""
    path = folder / "scene.yaml"
    path.write_text(f"{follower}cam: {cam}{REST}")
    return path


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_a_file_of_configs_loads_and_plans(path, cam, tmp_path, short_samples):
    assert "# yaml-language-server: $schema=schema.json" in path.read_text()
    assert load_scene(path).cam.parts()
    done = cam("simulate -c", str(path), "--dry-run --json")
    assert json.loads(done.stdout)["plan"]["impacts"] >= 0
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("kind", KINDS)
def test_every_command_takes_every_kind(cam, tmp_path, kind, command):
    """With pictures for the one that differs most from arcs."""
    path = write(tmp_path, KINDS[kind])
    words = [] if kind == "kinks" else ["--no-plot"]
    cam(command, "-c", str(path), "-o out --quiet", *words, code=0)
    assert (tmp_path / "out" / f"{command}.png").exists() == (not words)
    assert json.loads((tmp_path / "out" / "run.json").read_text())["result"]


def test_a_kink_throws_the_follower_off(cam, tmp_path):
    """The rise begins with a blow and ends with a launch; a spring holds neither."""
    path = write(tmp_path, KINDS["kinks"])
    done = cam("detach -c", str(path), "-o out --no-plot --hold-to 150")
    assert "the cam's slope drops by 0.031831 m/rad at 30 deg" in done.stdout
    assert "at a downward kink the cam throws the follower off at any speed" in done.stdout
    cam("simulate -c", str(path), "-o out --no-plot")
    events = rows(tmp_path / "out" / "events.csv")
    launches = {row["theta_deg"] for row in events if row["event"] == "detachment"}
    assert [float(x) for x in launches] == pytest.approx([30.0], abs=1e-12)
    blow = next(r for r in events if r["event"] == "impact" and r["theta_deg"][:3] == "300")
    speed = 0.05 / (pi / 2) * 150 * pi / 30
    assert float(blow["u_minus_m_per_s"]) == pytest.approx(-speed, rel=1e-12)


def test_a_blow_is_a_departure(cam, tmp_path):
    """A follower that only ever leaves by blows and launches is not in `contact`."""
    path = write(tmp_path, KINDS["kinks"])
    cam("orbits -c", str(path), "-o out --no-plot --rpm 130", code=0)
    orbit = next(r for r in rows(tmp_path / "out" / "branch.csv") if r["label"] == "P(1;inf)")
    phases = [float(orbit[key]) for key in orbit if key.startswith("theta_deg") and orbit[key]]
    assert phases == pytest.approx([30.0, 300.0], abs=1e-9)
