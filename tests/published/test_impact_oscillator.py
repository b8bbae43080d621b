"""Two classics as cams: the forced oscillator with a stop, and the ball on a vibrating table.

Oscillator (Shaw & Holmes, J. Sound Vib. 90, 1983; Budd & Dux, Phil. Trans. R. Soc. A 347, 1994):
x'' + x = cos(w t), x <= sigma, x' -> -r x'. With q - c = sigma - x it is a follower with m = k = 1
on c = gamma cos(w t) - sigma, gamma = 1/(1 - w^2). Between impacts x - gamma cos(w t + phi) is
a free oscillation; that it returns to the same height after T = 2 pi n/w with velocity V in, -r V
out, gives with C, S = cos T, sin T and cs = (1 + r) S/(1 - C)
    gamma cos phi = sigma + cs V/2,   gamma w sin phi = -(1 - r) V/2,
so (sigma + cs V/2)^2 + ((1 - r) V/(2 w))^2 = gamma^2. V is the incoming velocity, relative to the
stop; a negative V is a root that pulls. The flight's matrix [[C, S], [-S, C]] times the impact's
[[-r, 0], [(1 + r) a/V, -r]], a = cos phi - sigma being x'' at the stop, has det r^2 and
    trace = -2 r C + S (1 + r) a/V.

Ball (Luck & Mehta, Phys. Rev. E 48, 1993; Holmes, J. Sound Vib. 84, 1982): g, table c of amplitude
a, Gamma = a w^2/g. One impact in n turns: V = g n T/(1 + r) relative, table velocity
a w cos psi = g n T (1 - r)/(2 (1 + r)); fold where cos psi = 1, at pi n (1 - r)/(1 + r), period
doubling at sqrt(fold^2 + (2 (1 + r^2)/(1 + r)^2)^2).
"""

from itertools import product
from math import cos, exp, hypot, pi, sin, sqrt
from pathlib import Path

import pytest
from mpmath import mp, mpf

import camcli
from camcli.analysis.integrate import Orbit, Settings, Start
from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.orbits.study import OrbitsQuestion, orbits
from camcli.cams.eccentric import EccentricCam
from camcli.kernel.certify import PULLS
from camcli.scene import load_scene
from camcli.system import Follower, System

CONFIGS = Path(__file__).parents[2] / "configs"
TIGHT = 1e-10
RPM = 30 / pi  # of 1 rad/s


def oscillator(w, r, sigma):
    """The system of x'' + x = cos(w t) with a stop."""
    gamma = abs(1 / (1 - w * w))
    cam = EccentricCam(kind="eccentric", base=-sigma - gamma, lift=2 * gamma)
    return System.build(Follower(1.0, 1.0, restitution=r), cam)


def velocities(w, r, sigma, n):
    """Both roots V of the quadratic, the larger first; none where they are not real."""
    gamma, time = 1 / (1 - w * w), 2 * pi * n / w
    cs = (1 + r) * sin(time) / (1 - cos(time))
    a, b = cs * cs / 4 + ((1 - r) / (2 * w)) ** 2, sigma * cs
    inside = b * b - 4 * a * (sigma * sigma - gamma * gamma)
    if inside < 0:
        return []
    root = sqrt(inside)
    return [(-b + root) / (2 * a), (-b - root) / (2 * a)]


def trace(w, r, sigma, n, v):
    """Of the return map over n forcing periods."""
    time = 2 * pi * n / w
    cs = (1 + r) * sin(time) / (1 - cos(time))
    a = (sigma + cs * v / 2) * (1 - w * w) - sigma
    return -2 * r * cos(time) + sin(time) * (1 + r) * a / v


@pytest.mark.parametrize("n", [1, 3])
@pytest.mark.parametrize("sigma", [0.0, 0.1, -0.1])
@pytest.mark.parametrize(
    ("w", "r"), [(1.97, 0.8), (1.9, 0.8), (2.6, 0.8), (4.2, 0.5), (0.7, 0.6), (7.0, 0.9)]
)
def test_every_single_impact_orbit_is_a_root_of_the_quadratic(w, r, sigma, n):
    system, rpm = oscillator(w, r, sigma), w * RPM
    shooter = Shooter(system, rpm)
    roots = single_impact_roots(shooter, rpm, n)
    found = sorted((-root.rates[0] * w for root in roots), reverse=True)
    expected = velocities(w, r, sigma, n)
    assert found == pytest.approx(expected, rel=TIGHT)
    for root in roots:
        v = -root.rates[0] * w
        assert root.trace == pytest.approx(trace(w, r, sigma, n, v), rel=1e-9, abs=TIGHT)
        assert root.det == pytest.approx(r * r, rel=1e-15)
        if v < 0:
            assert shooter.verdict(root)[0] == PULLS


@pytest.mark.parametrize("w", [2.0, 2 + 1e-12, 2 - 1e-12])
def test_the_orbit_at_w_2(w):
    """V = 20/3, trace 1.6: both multipliers are r. Each flight lasts half a natural period."""
    system = oscillator(w, 0.8, 0.0)
    shooter = Shooter(system, w * RPM)
    roots = single_impact_roots(shooter, w * RPM, 1)
    assert len(roots) == 2
    (root,) = [root for root in roots if shooter.admits(root)]
    orbit = from_root(system, root)
    assert -2 * orbit.rates[0] == pytest.approx(20 / 3, rel=1e-11)
    assert orbit.trace == pytest.approx(1.6, rel=1e-11)
    assert orbit.det == pytest.approx(0.64, rel=1e-15)
    assert orbit.theta[0] == pytest.approx(pi / 2, abs=1e-10)
    assert orbit.stable


def answer(config, low, high, at, label=None):
    """The orbits of a scene of configs/ over a range of speeds."""
    scene = load_scene(CONFIGS / config)
    system = System.build(Follower(**scene.follower.model_dump()), scene.cam)
    span = Span(low, high, (high - low) / 20)
    question = OrbitsQuestion(at, span=span, label=label, starts=0)
    return orbits(system, Settings(600, 1, 1e-9, 10**6, Start()), question)


def test_the_period_doubling_of_the_shipped_oscillator():
    """sigma = 0 scales with gamma, so one cam serves every w: V is proportional to its lift."""
    found = answer("eccentric.yaml", 24.9, 25.6, 25.0)
    doubling = next(b for b in found.bifurcations if b.kind == "period-doubling")
    w = doubling.value / RPM
    assert w == pytest.approx(2.65334773, abs=5e-9)
    v = velocities(w, 0.8, 0.0, 1)[0]
    assert v == pytest.approx(0.44926471, abs=5e-9)
    assert 1 + trace(w, 0.8, 0.0, 1, v) + 0.64 == pytest.approx(0.0, abs=1e-8)
    assert {label for b in found.branches for label in b.labels} == {"P(1;1)", "P(2;1:1)"}


def ball(r, amplitude=0.001, g=9.81):
    """The system of a ball on a table."""
    cam = EccentricCam(kind="eccentric", base=-amplitude, lift=2 * amplitude)
    return System.build(Follower(0.01, 0.0, gravity=g, restitution=r), cam)


def rpm_of(gamma, amplitude=0.001, g=9.81):
    """Speed of the eccentric at a dimensionless acceleration."""
    return sqrt(gamma * g / amplitude) * RPM


def critical(r, n):
    """(fold, period doubling) in Gamma."""
    fold = pi * n * (1 - r) / (1 + r)
    return fold, hypot(fold, 2 * (1 + r * r) / (1 + r) ** 2)


@pytest.mark.parametrize(("r", "n"), [(0.5, 1), (0.5, 2), (0.2, 1), (0.8, 1), (0.8, 3)])
def test_the_balls_fold_and_period_doubling(r, n):
    fold, doubling = critical(r, n)
    low, high, start = (rpm_of(x) for x in (0.98 * fold, 1.02 * doubling, 0.5 * (fold + doubling)))
    span = Span(low, high, (high - low) / 20)
    question = OrbitsQuestion(
        start, span=span, label=Label([1, *[0] * (n - 1)]), branches=0, starts=0
    )
    found = orbits(ball(r), Settings(20, 1, 1e-9, 10**6, Start()), question)
    at = {event.kind: event.value for event in found.bifurcations}
    assert at["fold"] == pytest.approx(rpm_of(fold), rel=TIGHT)
    assert at["period-doubling"] == pytest.approx(rpm_of(doubling), rel=TIGHT)
    for orbit in found.orbits:
        w = orbit.rpm / RPM
        assert -w * orbit.rates[0] == pytest.approx(9.81 * n * 2 * pi / w / (1 + r), rel=TIGHT)
        # c = -a cos theta moves with a w sin theta, in phase with the impact
        table = 0.001 * w * sin(orbit.theta[0])
        assert table == pytest.approx(9.81 * n * pi / w * (1 - r) / (1 + r), rel=TIGHT)


def test_the_error_of_a_fold_holds_and_is_not_ten_times_too_large():
    """Of 27 balls, against 40 digits: a fold is located to some roundings of its speed."""
    shares = []
    for n, r in product((1, 2, 3), (0.15, 0.2, 0.3, 0.37, 0.45, 0.5, 0.61, 0.7, 0.8)):
        low, high = (rpm_of(x) for x in critical(r, n))
        span = Span(0.98 * low, high, (high - 0.98 * low) / 20)
        question = OrbitsQuestion(
            0.5 * (low + high), span=span, label=Label([1, *[0] * (n - 1)]), branches=0, starts=0
        )
        found = orbits(ball(r), Settings(20, 1, 1e-9, 10**6, Start()), question)
        (fold,) = (event for event in found.bifurcations if event.kind == "fold")
        gamma = mp.pi * n * (1 - mpf(r)) / (1 + mpf(r))
        exact = mp.sqrt(gamma * mpf(9.81) / mpf(0.001)) * 30 / mp.pi
        shares.append(float(abs(fold.value - exact) / fold.error))
    assert 0.2 < max(shares) <= 1.0


@pytest.mark.parametrize(("kind", "which"), [("fold", 0), ("period-doubling", 1)])
def test_the_balls_curves_of_folds_and_period_doublings(kind, which):
    """Over the speed and the restitution, one impact in two turns."""
    speeds = [rpm_of(critical(r, 2)[which]) for r in (0.55, 0.45)]
    scene = {
        "follower": {"mass": 0.01, "stiffness": 0.0, "gravity": 9.81, "restitution": 0.5},
        "cam": {"kind": "eccentric", "base": -0.001, "lift": 0.002},
        "run": {"rpm": 0.5 * sum(map(rpm_of, critical(0.5, 2)))},
        "orbits": {
            "vary": [
                {"key": "rpm", "start": 0.98 * speeds[0], "stop": 1.02 * speeds[1], "num": 5},
                {"key": "follower.restitution", "start": 0.45, "stop": 0.55, "num": 5},
            ],
            "curve": kind, "label": "P(2;1:0)", "starts": 0, "branches": 0,
        },
    }  # fmt: skip
    (curve,) = camcli.orbits(load_scene(scene)).values.curves
    assert sorted([curve.points[0].second, curve.points[-1].second]) == [0.45, 0.55]
    assert len(curve.points) >= 3
    for point in curve.points:
        assert point.first == pytest.approx(rpm_of(critical(point.second, 2)[which]), rel=TIGHT)


# Spring and preload hold the mass at -preload/k, the cam's top is at -0.2.
FREE = {
    "follower": {"mass": 1, "stiffness": 1, "damping": 0.1, "preload": 0.1, "restitution": 0.8},
    "cam": {"kind": "eccentric", "base": -2.2, "lift": 2},
    "run": {"rpm": 12.414085, "start": {"q": -0.1, "v": 0}},
}


def free(section, changes=(), **values):
    """The scene at its own speed, with the section of one analysis."""
    rpm = {"start": 12.414085, "stop": 12.414085, "num": 1}
    return load_scene({**FREE, section: {"rpm": rpm, **values}}, changes)


def test_the_orbit_without_impacts_is_an_orbit_like_any_other():
    assert camcli.simulate(load_scene(FREE)).summary["label"] == "P(1;0)"
    assert list(camcli.sweep(free("sweep")).tables["speeds"]["label"]) == ["P(1;0)"]
    named = camcli.classify(free("classify")).tables["classify"]
    assert (named["label"][0], named["period"][0], named["stable"][0]) == ("P(1;0)", 1, 1)
    turn = 60 / 12.414085
    assert named["lyapunov_per_period"][0] == pytest.approx(-0.05 * turn, rel=1e-13)
    cells = free("basins", q=[-0.19, -0.05], v=[-0.05, 0.05], cells=[4, 4])
    (basin, *_) = camcli.basins(cells).summary["speeds"][0]["attractors"]
    assert (basin["label"], basin["states_q_m_v_m_per_s"]) == ("P(1;0)", [[-0.1, 0.0]])
    orbits = camcli.orbits(free("orbits", label="P(1;0)"))
    (orbit,) = orbits.summary["orbits"]
    mu = exp(-0.05 * turn) * cos(sqrt(1 - 0.05**2) * turn)
    assert orbit["multipliers"][0][0] == pytest.approx(mu, rel=1e-13)
    assert orbit["label"] in camcli.orbits(free("orbits", starts=0)).tables["branch"]["label"]


def test_without_damping_the_orbit_without_impacts_is_neutral_and_not_stable():
    """Both multipliers on the unit circle: exp(+-i w T), and a determinant of exactly 1."""
    undamped = free("orbits", {"follower.damping": 0.0}, label="P(1;0)")
    branch = camcli.orbits(undamped).tables["branch"]
    assert branch["multiplier_1_re"][0] == pytest.approx(cos(60 / 12.414085), rel=1e-13)
    assert (branch["label"][0], branch["det"][0], branch["stable"][0]) == ("P(1;0)", 1.0, 0)


def test_the_orbit_without_impacts_grazes_where_the_cam_reaches_it():
    section = {"label": "P(1;0)", "parameter": "preload", "range": [0, 0.5]}
    found = camcli.orbits(free("orbits", **section)).tables["bifurcations"]
    assert list(found["kind"]) == ["grazing"]
    assert abs(found["preload_n"][0] - 0.2) <= found["preload_n_error"][0] < 1e-12


def test_an_impact_fades_where_its_rate_is_zero_within_the_printed_error():
    """At rest the mass is at -preload/k, the cam's top at -0.2; without damping, w = 2 to 1."""
    section = {"parameter": "preload", "range": [0, 0.5], "starts": 4}
    fast = {"P(1;1)", "P(2;1:0)", "P(6;1:0:0:0:0:0)"}
    for rpm, preload, labels in ((12.414085, 0.1, {"P(1;0)", "P(1;1)"}), (714.0, 0.25, fast)):
        speed = {"start": rpm, "stop": rpm, "num": 1}
        changed = {"follower.preload": preload, "run.start": {}}
        damped = load_scene({**FREE, "orbits": {**section, "rpm": speed}}, changed)
        found = camcli.orbits(damped).summary["bifurcations"]
        assert {row["label"] for row in found} >= labels
        assert {(row["kind"], row["status"]) for row in found} == {("grazing", "ok")}
        for row in found:
            assert abs(row["value"] - 0.2) <= row["error"] < 1e-10

    cam = {"kind": "eccentric", "base": -5 / 6, "lift": 2 / 3}
    follower = {"mass": 1, "stiffness": 1, "restitution": 0.8}
    section = {"rpm": {"start": 18, "stop": 22}, "at": 19.3, "starts": 4, "label": "P(2;1:0)"}
    (row,) = camcli.orbits(
        load_scene({"follower": follower, "cam": cam, "orbits": section})
    ).summary["bifurcations"]
    assert abs(row["value"] - 60 / pi) <= row["error"] < 1e-10


def test_no_label_without_impacts_is_searched_for(monkeypatch):
    """Whether the follower can stay away from the cam is known at once."""
    monkeypatch.setattr(Orbit, "run", lambda *_: pytest.fail("a motion was simulated"))
    speeds = {"orbits.rpm.start": 700, "orbits.rpm.stop": 700, "orbits.label": "P(1;0)"}
    found = camcli.orbits(load_scene(None, speeds))
    assert "nor at 24 speeds" in found.summary["words"][0]


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({}, "The mass hits the stop at up to {:.2g} m/s."),
        ({"cam.amplitude": 0.09}, "The mass does not hit the stop in the turns recorded."),
        (
            {"cam.amplitude": 0.01, "cam.clearance": -0.5},
            "The mass stays at the stop in the turns recorded.",
        ),
    ],
)
def test_the_verdict_on_an_oscillator_is_about_its_stop(changes, wanted):
    cam = {"kind": "oscillator", "damping": 0.1, "frequency": 1, "clearance": 1}
    scene = {"cam": cam, "follower": {"restitution": 0.8}}
    result = camcli.simulate(load_scene(scene, {"run.transient": 200, "run.record": 5, **changes}))
    hardest = -min(result.tables["events"]["u_minus_m_per_s"], default=0.0)
    assert result.verdict == [wanted.format(hardest)]
    speeds = {"run.transient": 20, "run.record": 5, **changes}
    axis = {"key": "cam.frequency", "start": 0.9, "stop": 1.1, "num": 2}
    swept = camcli.sweep(load_scene(scene, {**speeds, "sweep.vary": [axis]}))
    assert swept.verdict == []  # contact holds up to no speed: the machine has one
