"""The machine at each point of a map whose curves are followed, and what is told of proofs."""

from __future__ import annotations

from math import cos, pi
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.orbits.atlas import Atlas
from camcli.analysis.orbits.codim2 import PointProof
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.api.atlas import _machines, plane_of
from camcli.api.machine import machine_of
from camcli.api.sweep import _proofs
from camcli.errors import NoMachineError
from camcli.exact.shooting import ProofStep
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.scene import load_scene
from camcli.words.proofs import FAILED

NUMBERS = {"cam.base": 0.01, "cam.lift": 0.02, "follower.mass": 1.5, "follower.restitution": 0.7,
           "rpm": 650.0}  # fmt: skip
RANGES = {"cam.base": (0.005, 0.015), "cam.lift": (0.03, 0.015), "follower.mass": (1.0, 2.0),
          "follower.restitution": (0.6, 0.9), "rpm": (600.0, 800.0),
          "cam.lash": (0.001, 0.018)}  # fmt: skip


def map_over(*keys: str, **more):
    """The function that gives the machine at a point of a map over two numbers of the scene."""
    axes = [{"key": key, "start": RANGES[key][0], "stop": RANGES[key][1], "num": 3} for key in keys]
    values = {"cam": {"kind": "eccentric", "base": 0.01, "lift": 0.02, **more},
              "follower": {"mass": 1.5, "stiffness": 900.0, "restitution": 0.7},
              "run": {"rpm": 650.0}, "sweep": {"vary": axes}}  # fmt: skip
    scene = load_scene(values)
    plane = plane_of(scene, scene.sweep.vary)
    return _machines(machine_of(scene), scene.sweep.vary, plane), plane


def height(system, theta: float) -> float:
    """c at a phase (rad), m."""
    return lift_at(system.cam, stretch_at(system.cam, theta), theta)[0]


@pytest.mark.parametrize("keys", [
    ("follower.mass", "rpm"), ("rpm", "follower.restitution"), ("cam.lift", "rpm"),
    ("rpm", "cam.base"), ("cam.base", "follower.mass"), ("follower.restitution", "cam.lift"),
    ("cam.lift", "cam.base"),
])  # fmt: skip
def test_each_point_of_a_map_has_its_own_machine(keys):
    """Both numbers are those of the point, in any order of points; all others are the scene's."""
    at, plane = map_over(*keys)
    assert plane.ranges == tuple(tuple(sorted(RANGES[key])) for key in keys)
    shares = [(0.0, 0.0), (0.25, 0.75), (1.0, 0.5), (0.25, 0.75)]
    for point in shares:
        values = [low + share * (high - low)
                  for share, (low, high) in zip(point, plane.ranges, strict=True)]  # fmt: skip
        known = NUMBERS | dict(zip(keys, values, strict=True))
        system, rpm = at(*values)
        assert rpm == known["rpm"]
        follower = system.follower
        assert (follower.mass, follower.restitution) == (
            known["follower.mass"], known["follower.restitution"],
        )  # fmt: skip
        assert (follower.stiffness, follower.damping, follower.seat_restitution) == (900, 0, None)
        for theta in (0.0, 1.0, pi, 5.0):
            wanted = known["cam.base"] + 0.5 * known["cam.lift"] * (1.0 - cos(theta))
            assert height(system, theta) == pytest.approx(wanted, abs=1e-15)
        named = {} if system.member is None else dict(
            zip(system.member.family.names, system.member.values, strict=True)
        )  # fmt: skip
        of_cam = {key: known[key] for key in keys if key.startswith("cam.")}
        assert named == of_cam


def test_a_point_without_a_cam_has_no_machine():
    """The lash may be no larger than the lift; with a larger lift there is a machine."""
    at, _ = map_over("cam.lash", "cam.lift", lash=0.002)
    with pytest.raises(NoMachineError):
        at(0.017, 0.016)
    system, rpm = at(0.017, 0.025)
    assert (rpm, system.member.values) == (650.0, (0.017, 0.025))
    assert height(system, pi) == pytest.approx(0.01 + 0.025 - 0.017, abs=1e-15)


def test_the_entry_of_run_json_for_the_proofs_of_a_map():
    """Of each point in its order, of each range, and of each curve that was not tried."""

    def curve(turns):
        return Made(points=[Made(orbit=Made(turns=turns)), Made(orbit=Made(turns=9))])

    proofs = [None, PointProof(None, (1.0, 2.0), (3.0, 4.0)), PointProof(ProofStep.GRAZES),
              PointProof(ProofStep.WORK_BUDGET)]  # fmt: skip
    places = ((600.0, 0.6), (700.0, 0.7))
    ranges = [CurveRange(2, 1, 5, places, 7, evidence="evidence"),
              CurveRange(2, 5, 6, places, 0, ProofStep.PULLS)]  # fmt: skip
    atlas = Atlas("plane", [curve(3), curve(1), curve(4)], [Made(proof=one) for one in proofs])
    entry = _proofs(atlas, 2.5e-17)
    assert entry == {
        "curve_ranges": [], "not_tried": [], "flank_excess_m": 2.5e-17,
        "points": [
            None, {"proved": True, "failed_step": None},
            {"proved": False, "failed_step": FAILED[ProofStep.GRAZES]},
            {"proved": False, "failed_step": FAILED[ProofStep.WORK_BUDGET]},
        ],
    }  # fmt: skip
    atlas.ranges = ranges
    asked = _proofs(atlas, 0.0)
    assert asked["not_tried"] == [{"curve": 1, "turns": 3}, {"curve": 3, "turns": 4}]
    common = {"curve": 2, "places": places}
    assert asked["curve_ranges"] == [
        {**common, "first": 1, "last": 5, "boxes": 7, "failed_step": None},
        {**common, "first": 5, "last": 6, "boxes": 0, "failed_step": FAILED[ProofStep.PULLS]},
    ]  # fmt: skip
    assert asked["flank_excess_m"] == 0.0
