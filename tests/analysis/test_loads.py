"""The engineer's columns against the multiple-precision oracle: its events, flights and forces."""

from itertools import pairwise
from math import hypot, pi, sqrt, ulp
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import chapter_system, settings
from mpmath import mp, mpf
from scipy.optimize import minimize_scalar

from camcli import system as machines
from camcli.analysis import loads as loads_module
from camcli.analysis.integrate import Orbit
from camcli.analysis.loads import loads_of
from camcli.cams.eccentric import EccentricCam
from camcli.kernel import backend
from camcli.kernel import loads as kernel_loads
from camcli.kernel.forms import PLAIN
from camcli.quantities import LOADS
from tests.support.oracle import ArcsCam, Follower, Oracle

EXAMPLE = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}
TURNS = 2
LOWEST, LIFT = 0.1, 0.15393320723821  # m


def largest(function, spans, samples=60):
    """The largest value over spans, from samples and a refinement around the best."""
    best, place, step = -np.inf, None, 0.0
    for low, high in spans:
        for x in np.linspace(low, high, samples):
            if (value := function(float(x))) > best:
                best, place, step = value, (low, high, float(x)), (high - low) / (samples - 1)
    low, high, x = place
    ends = max(low, x - step), min(high, x + step)
    inside = minimize_scalar(lambda y: -function(y), bounds=ends, method="bounded",
                             options={"xatol": 1e-10})  # fmt: skip
    return max(best, -inside.fun)


def expected(rpm, **changes):
    """The columns of TURNS turns from rest on the cam, from the oracle's events alone."""
    values = {**EXAMPLE, **changes}
    cam = ArcsCam()
    events = Oracle(cam, rpm=rpm, **values).run(turns=TURNS, chatter_cut=mpf("1e-13"))
    omega, r = rpm * pi / 30, values["restitution"]
    follower = Follower.make(*(values.get(k, 0) for k in
                               ("mass", "stiffness", "damping", "gravity", "preload")))  # fmt: skip
    flights, rests, begin, state = [], [], 0.0, None
    for e in events:
        at = float(e.theta) + 2 * pi * e.turn
        (rests if state is None else flights).append((begin, at, state))
        c, slope, _ = cam.laws(mpf(at))
        v = float(slope) * omega + (-r * float(e.u_minus) if e.kind == "impact" else 0.0)
        begin, state = at, None if e.kind == "chatter" else (float(c), v)
    (rests if state is None else flights).append((begin, 2 * pi * TURNS, state))

    def gap(flight):
        begin, end, (q, v) = flight
        height = lambda x: float(follower.flow(mpf((x - begin) / omega), q, v)[0] - cam.c(mpf(x)))  # noqa: E731
        return largest(height, [(begin, end)])

    def force(side):
        def value(x):
            c, c1, c2 = (float(y) for y in cam.laws(mpf(x)))
            m, k = values["mass"], values["stiffness"]
            load = m * values.get("gravity", 0.0) + values.get("preload", 0.0)
            return side * (k * c + values.get("damping", 0.0) * omega * c1 + load
                           + m * omega**2 * c2)  # fmt: skip

        corners = [x * pi / 180 + 2 * pi * n for n in range(TURNS) for x in cam_corners()]
        spans = []
        for begin, end, _ in rests:
            cuts = [begin, *(x for x in corners if begin < x < end), end]
            spans += [(a + 1e-13, b - 1e-13) for a, b in pairwise(cuts) if b - a > 1e-9]
        return side * largest(value, spans)

    def cam_corners():
        return (90.0, 150.1793714951576, 160.0, 200.0, 209.8206285048424, 270.0)

    long = sorted(flights, key=lambda f: f[1] - f[0])[-8:]
    hits = [(-float(e.u_minus), float(e.theta)) for e in events if e.kind == "impact"]
    lifts = [float(cam.c(mpf(theta))) - LOWEST for _, theta in hits]
    hardest, at = max(hits)
    phases = {kind: [float(e.theta) for e in events if e.kind == kind]
              for kind in ("chatter", "detachment")}  # fmt: skip
    return (
        max(map(gap, long)),
        sum(b - a for a, b, _ in flights) / (2 * pi * TURNS),
        hardest,
        max(force(-1), 0.0),
        force(1),
        min(phases["detachment"]),
        max(phases["chatter"], default=None),
        at,
        lifts[hits.index((hardest, at))],
        sum(
            lift <= 0.01 * LIFT and hits[k][0] >= 0.1 * max(hits[: k + 1])[0]
            for k, lift in enumerate(lifts)
        )
        / TURNS,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rpm", "changes"), [(190.0, {}), (160.0, {"damping": 5.0, "gravity": 9.81, "preload": 20.0})]
)
def test_the_columns_are_the_oracles(rpm, changes):
    with mp.workdps(30):
        wanted = expected(rpm, **changes)
    system = chapter_system(**changes)
    record = Orbit(system, rpm, settings(0, TURNS, tolerance=1e-12)).run()
    found = loads_of(system, rpm, record)
    of_the_cam = found[: len(LOADS)]  # the others are of a seat
    for name, value, exact in zip(LOADS, of_the_cam, wanted, strict=True):
        assert value == (None if exact is None else pytest.approx(exact, rel=1e-9, abs=1e-9)), name


def test_always_in_contact_and_never_at_rest(chapter):
    """The force on the base circle is k c; at 700 rpm nothing rests."""
    record = Orbit(chapter, 100.0, settings(5, 3)).run()
    found = loads_of(chapter, 100.0, record)
    assert found[:3] == (0.0, 0.0, 0.0)
    assert found.min_contact_force_n < 1430.8 * 0.1
    assert found.max_contact_force_n > 1430.8 * 0.25393
    assert found[5 : len(LOADS)] == (None, None, None, None, 0.0)
    assert set(found[len(LOADS) :]) == {None}  # there is no seat
    flying = loads_of(chapter, 700.0, Orbit(chapter, 700.0, settings(600, 10)).run())
    assert flying.airborne_fraction == pytest.approx(1.0, abs=1e-12)
    assert flying[3:7] == (None,) * 4


@pytest.mark.parametrize("rpm", [190.0, 745.0])
def test_plain_and_compiled_have_the_same_bits(chapter, rpm, monkeypatch):
    record = Orbit(chapter, rpm, settings(20, 5)).run()
    compiled = backend.compiled()
    found = []
    for kernel in (PLAIN, compiled):
        monkeypatch.setattr(backend, "current", lambda kernel=kernel: kernel)
        found.append(loads_of(chapter, rpm, record))
    assert found[0] == found[1]


@pytest.mark.parametrize("rpm", [130.0, 190.0, 345.0, 358.5, 520.0, 700.0, 745.0])
@pytest.mark.parametrize("changes", [{}, {"damping": 5.0, "gravity": 9.81}])
def test_every_way_that_is_passed_over_has_no_extreme(rpm, changes, monkeypatch):
    """The loads are those of a search through every flight and every rest, but for a rounding."""
    system = chapter_system(**changes)
    record = Orbit(system, rpm, settings(50, 100)).run()
    monkeypatch.setattr(backend, "current", lambda: PLAIN)
    quick = loads_of(system, rpm, record)
    monkeypatch.setattr(kernel_loads, "adds_nothing", lambda *_: False)
    searched = loads_of(system, rpm, record)
    assert quick[1:] == searched[1:]
    assert abs(quick.max_gap_m - searched.max_gap_m) <= 2.0 * ulp(1.0 + searched.max_gap_m)


@pytest.mark.parametrize(("strobe_deg", "v"), [(120.0, 25.0), (100.0, 30.0)])
def test_the_first_flight_of_a_record_begins_with_the_slope_at_the_strobe(strobe_deg, v):
    """From 0.05 m above the cam, whose slope is not zero there; by samples of a cosine's flight."""
    system, rpm = chapter_system(strobe_deg), 700.0
    omega, w0 = rpm * pi / 30, sqrt(1430.8 / 1.221)
    cam, begin = ArcsCam(), strobe_deg * pi / 180
    q = float(cam.c(mpf(begin))) + 0.05
    record = Orbit(system, rpm, settings(0, 1, q=q, v=v, theta_deg=strobe_deg)).run()
    span = (float(record.theta[0]) - begin) % (2 * pi)
    angles = np.linspace(0.0, span, 2001)
    heights = q * np.cos(w0 * angles / omega) + v / w0 * np.sin(w0 * angles / omega)
    gaps = heights - [float(cam.c(mpf(begin + x))) for x in angles]
    assert record.loads is None
    found = loads_of(system, rpm, record)
    assert 0 < gaps.argmax() < 2000
    assert found.max_gap_m == pytest.approx(gaps.max(), rel=1e-6)


@pytest.mark.parametrize("damping", [30.0, -0.0, 3.0])
@pytest.mark.parametrize("strobe_deg", [0.0, 200.0])
@pytest.mark.parametrize("rpm", [40.0, 120.0, 250.0])
def test_the_forces_of_a_follower_that_stays_are_those_of_a_wave(damping, strobe_deg, rpm):
    """c = 0.1 + e (1 - cos theta): F = k c + F0 + b w e sin theta + m w^2 e cos theta."""
    e, m, k = 0.02, 1.5, 1400.0
    cam = EccentricCam(kind="eccentric", base=0.1, lift=2.0 * e)
    follower = machines.Follower(mass=m, stiffness=k, damping=damping, preload=40.0)
    system = machines.System.build(follower, cam, strobe_deg * pi / 180.0)
    record = Orbit(system, rpm, settings(1, 2)).run()
    assert record.rests_throughout
    omega = rpm * pi / 30.0
    middle = k * (0.1 + e) + 40.0
    swing = hypot(damping * omega * e, (m * omega**2 - k) * e)
    found = loads_of(system, rpm, record)
    assert found.min_contact_force_n == pytest.approx(middle - swing, rel=1e-12)
    assert found.max_contact_force_n == pytest.approx(middle + swing, rel=1e-12)


def test_how_long_a_lobe_is_open_as_it_is_drawn(monkeypatch):
    """Above its lowest dwells; a measured one where its table tells it from the base circle."""
    rows = [  # start, end, whether it is a dwell, its height
        (0.0, 1.25, 1, 0.1), (1.25, 2.0, 0, 0.1), (2.0, 4.5, 1, 0.3), (4.5, 6.0, 0, 0.3),
        (6.0, 6.25, 1, 0.1 + 1e-8), (6.25, loads_module.TURN, 0, 0.1),
    ]  # fmt: skip
    stretches = [
        SimpleNamespace(start=start, end=end, dwell=dwell, start_c=c)
        for start, end, dwell, c in rows
    ]
    monkeypatch.setattr(loads_module, "lift_range", lambda cam: (0.1, 0.3))
    monkeypatch.setattr(loads_module, "is_measured", lambda system: system.measured)
    monkeypatch.setattr(
        loads_module, "_above", lambda shape, height: (shape.least_lift, height, "above")
    )
    drawn = SimpleNamespace(
        cam=SimpleNamespace(stretches=stretches),
        measured=False,
        shape=SimpleNamespace(least_lift=2e-5),
    )
    found = loads_module._open_as_drawn(SimpleNamespace(as_drawn=drawn))
    assert found == pytest.approx(loads_module.TURN - 1.25 - 0.25)
    drawn.measured = True
    found = loads_module._open_as_drawn(SimpleNamespace(as_drawn=drawn))
    assert found == (2e-5, 2e-5, "above")
