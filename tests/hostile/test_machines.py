"""Machines at the ends of their ranges that once raised, hung or gave numbers without a value."""

from __future__ import annotations

from pathlib import Path

import pytest

from camcli.scene import load_scene
from tests.hostile.bounds import plain_kernel, run_one_turn

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.mark.parametrize(
    ("name", "sets"),
    [
        ("law-harmonic", ["cam.rise.start_deg=1e-310"]),  # no stretch began at 0
        ("law-smooth", ["cam.rise.start_deg=1e-300", "run.start.theta_deg=1e-301"]),
        ("law-smooth", ["cam.rise.start_deg=359.9999999999999"]),
        ("law-cycloidal", ["cam.rise.law={scca: {b: 5e-324, c: 1, d: 0}}"]),
        ("law-harmonic", ["cam.rise.length_deg=1e-6", "cam.fall.length_deg=1e-6"]),
        ("law-harmonic", ["cam.top_dwell_deg=5e-324"]),
        ("bouncing-ball", ["run.strobe_deg=359.99999999999994", "cam.base=1e-30"]),  # width 0
        ("chapter", ["run.strobe_deg=5e-324", "run.start.v=1e-300", "follower.restitution=1e-300"]),
        ("chapter", ["run.strobe_deg=139.99999999999997"]),
        ("chapter", ["run.strobe_deg=140.00000000000003"]),
        ("lift-table", ["run.strobe_deg=5e-324"]),
        ("eccentric", ["cam.lift=5e-324", "follower.restitution=1"]),
        ("eccentric", ["run.start.q=1e9", "run.start.v=1e12", "run.rpm=1e-9"]),
        ("chapter", ["follower.mass=1e-15", "follower.stiffness=1e15", "run.rpm=1e-9"]),
        ("chapter", ["follower.damping=1e15", "follower.stiffness=0", "run.rpm=1e9"]),
    ],
)
def test_an_extreme_machine_gives_a_status(name, sets):
    with plain_kernel():
        run_one_turn(load_scene(CONFIGS / f"{name}.yaml", sets))
