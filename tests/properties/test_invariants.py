"""What holds for every orbit, whatever the machine: hypothesis looks for one that breaks it."""

import itertools
from math import isfinite, pi

from hypothesis import example, given, settings
from hypothesis import strategies as st

from camcli.analysis.simulate import simulate
from camcli.errors import Status
from tests import conftest
from tests.support.kernel_runs import ORACLE_CAM, events, run, system

SPEED = st.floats(30.0, 3000.0)
CONSTANTS = st.fixed_dictionaries(
    {
        "mass": st.floats(0.1, 10.0),
        "stiffness": st.one_of(st.just(0.0), st.floats(10.0, 1e5)),
        "damping": st.one_of(st.just(0.0), st.floats(1e-3, 1e3)),
        "gravity": st.one_of(st.just(0.0), st.floats(0.1, 20.0)),
        "preload": st.one_of(st.just(0.0), st.floats(0.1, 200.0)),
        "restitution": st.one_of(st.just(0.0), st.just(1.0), st.floats(0.01, 0.99)),
    }
).filter(lambda data: data["stiffness"] + data["gravity"] + data["preload"] > 0)
BALL = {"mass": 1.0, "stiffness": 0.0, "preload": 8.0, "restitution": 0.875}
SCALES = lambda v: v == 0.0 or abs(v) > 1e-200  # noqa: E731 - times 2^n it is no subnormal
STARTS = st.one_of(
    st.just({}),
    st.fixed_dictionaries({"q": st.floats(0.26, 2.0), "v": st.floats(-30.0, 30.0).filter(SCALES)}),
)
MOSTLY = settings(max_examples=80, deadline=None, derandomize=True)


@MOSTLY
@given(SPEED, CONSTANTS, STARTS, st.integers(-30, 30))
def test_mass_has_no_unit(rpm, data, start, n):
    """m, k, b, F0 times 2^n: the same bits."""
    scaled = dict(data)
    for name in ("mass", "stiffness", "damping", "preload"):
        scaled[name] *= 2.0**n
    one, two = (run(rpm, system(**x), record=8, budget=3000, **start) for x in (data, scaled))
    assert list(one.theta) == list(two.theta)
    assert list(one.strobe_w) == list(two.strobe_w)
    assert one.status == two.status


@MOSTLY
@given(SPEED, CONSTANTS, STARTS, st.integers(-20, 20))
def test_time_has_no_unit(rpm, data, start, n):
    """rpm, v, b times 2^n; k, g, F0 times 4^n: the same bits."""
    f = 2.0**n
    scaled = {**data, "damping": data["damping"] * f}
    for name in ("stiffness", "gravity", "preload"):
        scaled[name] *= f * f
    later = {name: value * (f if name == "v" else 1.0) for name, value in start.items()}
    one = run(rpm, system(**data), record=8, budget=3000, **start)
    two = run(rpm * f, system(**scaled), record=8, budget=3000, **later)
    assert list(one.theta) == list(two.theta)
    assert list(one.strobe_w) == list(two.strobe_w)


@MOSTLY
@given(SPEED, CONSTANTS, STARTS)
def test_events_are_sound(rpm, data, start):
    """In order, on the cam, approaching it; every number finite, every status one of three."""
    tape = run(rpm, system(**data), record=10, budget=3000, **start)
    rows = events(tape)
    assert tape.status in (Status.OK, Status.IMPACT_BUDGET, Status.NO_RETURN)
    assert all(a[1:3] <= b[1:3] for a, b in itertools.pairwise(rows))
    for kind, _, theta, q, u in rows:
        assert 0.0 <= theta <= 2 * pi
        assert abs(q - float(ORACLE_CAM.c(theta))) < 1e-14
        assert u < 0 if kind == "impact" else u == 0
    assert all(isfinite(x) for x in [*tape.strobe_q, *tape.strobe_w])
    assert sum(tape.impacts) <= tape.cost.impacts


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SPEED, CONSTANTS, STARTS)
@example(30.0, BALL, {})
def test_the_follower_is_never_inside_the_cam(rpm, data, start):
    """Sampled densely from the closed form between the events."""
    machine = system(**data)
    wanted = conftest.settings(record=4, budget=500, **start)
    result = simulate(machine, rpm, wanted, 360)
    omega = rpm * pi / 30
    for t, theta, q, v, c, c_dot, contact in result.trajectory:
        size = max(abs(q), 1.0) + abs(v) / omega
        assert q >= c - 1e-14 * size, (t, theta, q - c)
        assert contact != "sticking" or (q == c and v == c_dot)
