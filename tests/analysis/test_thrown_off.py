"""The rows of a flight that begins at the point of a cam: two ramps that meet at its top."""

import numpy as np
import pytest

import camcli

LIFT, RPM = 0.010, 100.0
RATE = LIFT / (70.0 / 360.0 * 60.0 / RPM)  # of both ramps, m/s
WAY = {"length_deg": 70.0, "law": "constant-velocity"}
SCENE = {
    "follower": {"mass": 0.25, "stiffness": 400.0, "damping": 0.5, "gravity": 9.81,
                 "preload": 2.0, "restitution": 0.3},
    "cam": {"kind": "law", "base": 0.0, "lift": LIFT, "top_dwell_deg": 0,
            "rise": {**WAY, "start_deg": 110.0}, "fall": WAY},
}  # fmt: skip


def test_the_follower_leaves_the_top_with_the_velocity_of_the_rise():
    scene = camcli.load_scene(SCENE, {"run.rpm": RPM, "run.record": 1})
    tables = camcli.simulate(scene).tables
    events, rows = tables["events"], tables["trajectory"]
    at = list(events["event"]).index("detachment")
    begin, end = events["t_s"][at : at + 2]
    assert (events["theta_deg"][at], events["event"][at + 1]) == (180.0, "impact")
    assert events["u_plus_m_per_s"][at] == pytest.approx(2.0 * RATE)
    flight = (rows["t_s"] >= begin) & (rows["t_s"] <= end)
    time, q, v, c, slope = (
        rows[name][flight] for name in ("t_s", "q_m", "v_m_per_s", "c_m", "c_dot_m_per_s")
    )
    left = int(np.flatnonzero(time <= begin + 1e-9)[-1])  # the row after the detachment
    assert v[left] == pytest.approx(RATE, rel=1e-12)
    landing = int(np.argmax(time == end))  # the row before the impact
    assert v[landing] - slope[landing] == pytest.approx(events["u_minus_m_per_s"][at + 1])
    assert (q[left + 1 : landing] > c[left + 1 : landing]).all()
    assert landing > left + 4
    f = SCENE["follower"]
    pull = [f["mass"] * f["gravity"] + f["preload"] + f["stiffness"] * x for x in q[left:landing]]
    accel = -(np.array(pull) + f["damping"] * v[left:landing]) / f["mass"]
    steps = np.diff(time[left:landing])
    mean = 0.5 * (accel[1:] + accel[:-1])
    assert np.diff(v[left:landing]) == pytest.approx(mean * steps, rel=1e-3)  # of a trapezium
