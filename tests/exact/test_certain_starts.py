"""The area of starts that must end at an orbit, proved beside the ellipses about its impacts.

The judge flies the edge of each ellipse to the strobe by the roots of the characteristic equation,
from the circle of the cam's flank or nose, and takes the area of the polygon of states there.
"""

from math import degrees, pi, radians

import numpy as np
import pytest

import camcli
from camcli.analysis.orbits.attraction import _axes
from camcli.analysis.orbits.starts import rounded_down
from camcli.scene import load_scene

MASS, STIFFNESS = 1.221, 1430.8
NOSE, NOSE_RADIUS = 0.40393320723821, 0.15  # m, about 160 and 200 deg
EDGE = 20_000  # corners of the polygon


def lift(theta):
    """(c, c_theta) where impacts of P(1;1) and P(2;1:0) are: on the nose before the top dwell."""
    y = theta - radians(160.0)
    root = np.sqrt(NOSE_RADIUS**2 - (NOSE * np.sin(y)) ** 2)
    slope = -NOSE * np.sin(y) - NOSE**2 * np.sin(y) * np.cos(y) / root
    return NOSE * np.cos(y) + root - 0.3, slope


def flown(theta, u, phase, rpm, damping):
    """(q, v) at a phase (rad) of motions that leave the cam at theta, u m/rad from it."""
    omega = rpm * pi / 30
    c, slope = lift(theta)
    q, v = c, omega * (slope + u)
    zeta = damping / (2 * MASS)
    root = -zeta + 1j * np.sqrt(STIFFNESS / MASS - zeta**2)
    t = (phase - theta) / omega
    amplitude = q - 1j * (v - zeta * -q) / root.imag  # q(t) = Re(amplitude exp(root t))
    turned = amplitude * np.exp(root * t)
    return turned.real, (root * turned).real


def polygon(q, v):
    return 0.5 * abs(np.sum(q * np.roll(v, -1) - v * np.roll(q, -1)))


def proved(rpm, label, **changes):
    """(orbit, proof, entry of run.json, sentences) of the stable one of a label."""
    section = {"rpm.start": rpm, "rpm.stop": rpm, "label": label, "starts": 0, "branches": 0}
    values = {f"orbits.{key}": value for key, value in section.items()}
    result = camcli.orbits(load_scene(None, values | changes), prove=True)
    rows = zip(
        result.values.orbits,
        result.values.proofs.orbits,
        result.summary["proofs"]["orbits"],
        strict=True,
    )
    (found,) = [row for row in rows if row[0].stable]
    return *found, [line for line in result.summary["words"] if "ellipse" in line]


def states(orbit, proof, phase, circle, damping=0.0):
    """States at a phase (rad, from the turn of the impact) from points M u of the ellipse."""
    a, b, c, d = proof.axes[0]
    x, y = circle
    middle = [float(text.strip("[").split()[0]) for text in proof.box[:2]]
    theta, u = middle[0] + a * x + b * y, middle[1] + c * x + d * y
    return flown(theta, u, phase, orbit.rpm, damping)


def edge():
    angles = np.linspace(0.0, 2 * pi, EDGE, endpoint=False)
    return np.cos(angles), np.sin(angles)


WIDE = {"basins.q": [0.0, 4.0], "basins.v": [-80.0, 80.0]}


@pytest.mark.parametrize(
    ("damping", "strobe", "least"),
    [(0.0, 0.0, 0.99999), (0.0, 250.0, 0.99999), (2.0, 0.0, 0.98), (5.0, 300.0, 0.98)],
)
def test_the_area_is_that_of_the_states_at_the_strobe(damping, strobe, least):
    changes = {"follower.damping": damping, "run.strobe_deg": strobe}
    orbit, proof, entry, (words,) = proved(700.0, "P(1;1)", **WIDE, **changes)
    phase = radians(strobe) + (2 * pi if strobe == 0.0 else 0.0)
    q, v = states(orbit, proof, phase, edge(), damping)
    area = polygon(q, v)
    assert least * area < entry["area_m2_per_s"] < area * (1 + 1e-7)
    assert q.min() > 0.0
    assert q.max() < 4.0
    assert abs(v).max() < 80.0
    assert least * area / 640.0 < entry["share_of_window"] < area / 640.0
    said = f"at least {rounded_down(100 * entry['share_of_window'], 3):g} % of the starts"
    assert said in words
    assert float(said.split()[2]) <= 100 * area / 640.0


@pytest.mark.ci
def test_a_flight_of_two_turns_passes_the_strobe_twice():
    orbit, proof, entry, (words,) = proved(1345.0, "P(2;1:0)")
    areas = [polygon(*states(orbit, proof, turns * 2 * pi, edge())) for turns in (1, 2)]
    assert 0.99999 * sum(areas) < entry["area_m2_per_s"] < sum(areas) * (1 + 1e-7)
    assert entry["share_of_window"] is None
    assert "an area of at least 0.162 m * m/s" in words


@pytest.mark.ci
def test_there_is_no_share_where_a_state_lies_outside_the_window():
    orbit, proof, entry, _ = proved(700.0, "P(1;1)", **WIDE)
    assert entry["share_of_window"] is not None
    q, v = states(orbit, proof, 2 * pi, edge())
    cuts = {"basins.q": [[0.0, q.max() - 1e-4], [q.min() + 1e-4, 4.0]],
            "basins.v": [[-80.0, v.max() - 1e-3], [v.min() + 1e-3, 80.0]]}  # fmt: skip
    for key, windows in cuts.items():
        for window in windows:
            *_, cut, _ = proved(700.0, "P(1;1)", **{**WIDE, key: window})
            assert (cut["area_m2_per_s"], cut["share_of_window"]) == (entry["area_m2_per_s"], None)


@pytest.mark.ci
def test_nothing_is_said_where_the_strobe_lies_in_the_ellipse():
    _, _, entry, (words,) = proved(700.0, "P(1;1)", **{"run.strobe_deg": 155.3})
    assert entry["ellipses"]
    assert (entry["area_m2_per_s"], entry["share_of_window"]) == (None, None)
    assert words.endswith("tends to it")


@pytest.mark.ci
def test_such_starts_end_at_the_orbit():
    orbit, proof, *_ = proved(700.0, "P(1;1)")
    rng = np.random.default_rng(1)
    angles, radii = rng.uniform(0.0, 2 * pi, 12), np.sqrt(rng.uniform(0.5, 1.0, 12))
    circle = radii * np.cos(angles), radii * np.sin(angles)
    for q, v in zip(*states(orbit, proof, 2 * pi, circle), strict=True):
        start = {"run.start.q": float(q), "run.start.v": float(v), "run.rpm": 700.0}
        result = camcli.simulate(load_scene(None, start | {"run.transient": 300}))
        events = result.tables["events"]
        assert result.summary["label"] == "P(1;1)"
        assert events["theta_deg"][-1] % 360.0 == pytest.approx(degrees(orbit.theta[0]), abs=1e-6)
        assert events["theta_deg"][-1] % 360.0 == pytest.approx(155.3037, abs=1e-4)


def test_an_ellipse_has_six_digits():
    """A certificate has them as they are printed: all digits of a shorter number, and no more."""
    _, proof, *_ = proved(700.0, "P(1;1)")
    numbers = [x for ellipse in proof.axes for x in ellipse]
    assert numbers == [float(f"{x:.6g}") for x in numbers]
    assert numbers != [float(f"{x:.5g}") for x in numbers]


def test_a_bound_is_never_rounded_up():
    assert rounded_down(0.0019999999, 3) == 0.00199
    assert rounded_down(0.125, 3) == 0.125


@pytest.mark.parametrize("angle", [0.0, 0.9])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_axes_of_ellipses_go_along_with_the_flights(angle, count):
    """Each flight maps the axes to the next ones, smaller by the mean factor of a flight.

    At last to the first ones, turned where the multipliers are complex. The maps are those of a
    product that is known: s^count times a rotation, or diag(1, 1/2), in other coordinates.
    """
    shrinks = 0.8
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    inner = turned if angle else np.diag([1.0, 0.5])
    frames = [np.array([[1.0, 0.3 * k], [0.2, 2.0 + k]]) for k in range(count)]
    maps = []
    for k in range(count):
        last = k + 1 == count
        after = frames[(k + 1) % count]
        maps.append(shrinks * after @ (inner if last else np.eye(2)) @ np.linalg.inv(frames[k]))
    axes = _axes(maps)
    assert len(axes) == count
    for k, jacobian in enumerate(maps[:-1]):
        assert axes[k + 1] == pytest.approx(jacobian @ axes[k] / shrinks)
    back = np.linalg.solve(axes[0], maps[-1] @ axes[-1]) / shrinks
    assert np.linalg.norm(back, 2) == pytest.approx(1.0)
    if angle:
        assert back.T @ back == pytest.approx(np.eye(2), abs=1e-12)
    else:
        assert np.abs(back) == pytest.approx(np.abs(np.diag(np.diag(back))), abs=1e-12)
        assert sorted(np.abs(np.diag(back))) == pytest.approx([0.5, 1.0])
