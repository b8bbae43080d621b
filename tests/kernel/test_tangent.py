"""How a difference grows: the flight's matrix against mpmath, and the turns a log counts.

Products with impacts: exponents, orbits and crises are held against multipliers and simulations.
"""

from math import log

import numpy as np
import pytest
from mpmath import mp

from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.flow import constants_of
from camcli.kernel.forms import PLAIN
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.kernel.variational import LARGE, Growth, Pair, _normed, flight_tangent
from tests.conftest import chapter_system

REGIMES = {
    "undamped": {},
    "damped": {"damping": 2.0},
    "springless": {"stiffness": 0.0, "gravity": 9.81},
    "springless, damped": {"stiffness": 0.0, "damping": 5.0, "preload": 8.0},
    "critical": {"damping": 2.0 * (1430.8 * 1.221) ** 0.5},
    "overdamped": {"damping": 300.0},
}


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("rpm", [150.0, 3000.0])
def test_the_flight_matrix_is_the_exponential_of_its_equation(name, rpm):
    lane = constants_of(chapter_system(**REGIMES[name]).machine(rpm), 0.0, 0)
    for s in (1e-6, 0.01, 0.7, TURN, 3 * TURN):
        with mp.workdps(60):
            rates = mp.matrix([[0, 1], [-(mp.mpf(lane.W) ** 2), -2 * mp.mpf(lane.Z)]])
            exact = mp.expm(rates * s, method="taylor")
            found = mp.matrix([flight_tangent(lane, s)[:2], flight_tangent(lane, s)[2:]])
            for i in range(2):
                for j in range(2):
                    size = (1.0, 1.0 + lane.W, 1.0 + s)[i - j]  # of any motion
                    assert abs(found[i, j] - exact[i, j]) < 2e-15 * (1 + lane.W * s) * size


def test_the_length_of_the_flights_of_a_log():
    """Phases count from the strobe, on which an impact may lie exactly."""
    system = chapter_system()
    entry, tables = PLAIN.stretch_events, ([Pair()], [Growth()])
    const = system.constants(700.0, 1e-9, 1000)
    theta = [1.0, 0.0, 3.0]
    entry(system.cam, const, [IMPACT] * 3, [0, 1, 1], theta, [-1.0] * 3, *tables)
    assert tables[1][0].length == pytest.approx(TURN + 2.0, rel=1e-15)


def test_the_logarithms_of_length_and_area_have_their_own_powers_of_two():
    """Each is kept as a factor and a number of times 2^64."""
    system = chapter_system()
    growths = [Growth(first=3.0, first_twos=-2, area=0.5, area_twos=5), Growth(first=0.0, area=7.0)]
    const = system.constants(700.0, 1e-9, 1000)
    PLAIN.stretch_events(system.cam, const, [], [], [], [], [Pair()], growths)
    two = log(2.0)
    found = [one for growth in growths for one in (growth.first_log, growth.area_log)]
    wanted = [log(3.0) - 128.0 * two, 319.0 * two, 0.0, log(7.0)]
    assert found == pytest.approx(wanted, rel=1e-15)


def matrix_of_flight(const, s):
    """The exponential of the equation of a flight of s rad."""
    rates = mp.matrix([[0, 1], [-(mp.mpf(const.W) ** 2), -2 * mp.mpf(const.Z)]])
    return np.array(mp.expm(rates * s).tolist(), dtype=float)


def matrix_of_impact(cam, const, theta, u):
    """The saltation matrix, with the restitution of the seat on the last stretch."""
    i = stretch_at(cam, theta)
    r = const.r_seat if i == len(cam.stretches) - 1 else const.r
    c, c1, c2 = lift_at(cam, i, theta)
    before, after = (-const.G - const.W2 * c - 2 * const.Z * (c1 + x) - c2 for x in (u, -r * u))
    return np.array([[-r, 0.0], [(r * before + after) / u, -r]])


def test_a_log_carries_a_pair_from_impact_to_impact():
    """Against the product of the matrices, of which QR tells the lengths and the area.

    A detachment changes nothing, and after a chatter a new pair begins at the next impact. What is
    left over of the events belongs to the last part.
    """
    system = chapter_system(damping=3.0, gravity=9.81, preload=20.0)
    stretches = [*system.cam.stretches[:-1], system.cam.stretches[-1]._replace(seat=1)]
    cam = system.cam._replace(stretches=stretches)
    const = system.constants(700.0, 1e-9, 1000)._replace(r=0.75, r_seat=0.5)
    on_seat = 0.5 * (stretches[-1].start + stretches[-1].end)
    log_of_events = [
        (IMPACT, 0, 2.5, -0.5),
        (IMPACT, 0, 2.75, -1.0),
        (DETACHMENT, 0, 2.875, 0.0),
        (IMPACT, 0, on_seat, -2.0),
        (IMPACT, 2, 2.25, -0.25),
        (CHATTER, 2, 3.0, 0.0),
        (IMPACT, 2, 3.25, -4.0),
        (IMPACT, 2, 3.5, -0.5),
        (IMPACT, 3, 1.0, -0.75),
    ]
    kinds, periods, phases, rates = map(list, zip(*log_of_events, strict=True))
    begun = {"first": LARGE, "first_twos": 2, "area": 1.0 / LARGE, "area_twos": -5}
    pairs, growths = [Pair()], [Growth(**begun), Growth()]
    PLAIN.stretch_events(cam, const, kinds, periods, phases, rates, pairs, growths)
    vectors, last = None, 0.0
    for k, growth in enumerate(growths):
        spans, chatters = [], 0
        lengths, areas = ([LARGE**3], [1.0 / LARGE**6]) if k == 0 else ([], [])
        for kind, period, theta, u in log_of_events[4 * k : 4 if k == 0 else None]:
            chatters += kind == CHATTER
            if kind == CHATTER:
                vectors = None
            elif kind == IMPACT:
                phase = TURN * period + theta
                if vectors is None:
                    vectors = np.eye(2)
                else:
                    spans.append(phase - last)
                    carried = matrix_of_flight(const, phase - last) @ vectors
                    carried = matrix_of_impact(cam, const, theta, u) @ carried
                    vectors, factors = np.linalg.qr(carried)
                    lengths.append(abs(factors[0, 0]))
                    areas.append(abs(factors[0, 0] * factors[1, 1]))
                    vectors[:, 0] *= np.sign(factors[0, 0])
                last = phase
        first, area = growth.first * LARGE**growth.first_twos, growth.area * LARGE**growth.area_twos
        assert first == pytest.approx(np.prod(lengths), rel=1e-10)
        assert area == pytest.approx(np.prod(areas), rel=1e-10, abs=0.0)
        assert all(1.0 / LARGE <= one <= LARGE for one in (growth.first, growth.area))
        assert growth.first_log == pytest.approx(sum(map(log, lengths)), rel=1e-9)
        assert growth.area_log == pytest.approx(sum(map(log, areas)), rel=1e-9)
        assert growth.length == pytest.approx(sum(spans))
        assert (growth.impacts, growth.chatters) == (len(spans), chatters)
    pair = pairs[0]
    assert (pair.seen, pair.theta, pair.period) == (1, 1.0, 3)
    assert [pair.qq, pair.wq] == pytest.approx(list(vectors[:, 0]), rel=1e-9)
    second = [pair.qw, pair.ww]
    assert [abs(x) for x in second] == pytest.approx([abs(x) for x in vectors[:, 1]], rel=1e-9)
    assert pair.qq * pair.qw + pair.wq * pair.ww == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("value", "normed"),
    [
        (1.5 * LARGE, (1.5, 1)),
        (3.0 * LARGE**4, (3.0, 4)),
        (0.5 / LARGE, (0.5, -1)),
        (0.75 / LARGE**3, (0.75, -3)),
        (LARGE, (LARGE, 0)),
        (1.0 / LARGE, (1.0 / LARGE, 0)),
        (0.0, (0.0, 0)),
    ],
)
def test_powers_of_two_are_split_off_a_factor(value, normed):
    """A factor is value 2^(64 twos); a zero has no logarithm and stays."""
    assert _normed(value) == normed
