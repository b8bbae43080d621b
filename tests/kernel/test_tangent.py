"""How a difference grows: the flight's matrix against mpmath, and the turns a log counts.

Products with impacts: exponents, orbits and crises are held against multipliers and simulations.
"""

from math import log

import pytest
from mpmath import mp

from camcli.kernel.cam_table import TURN
from camcli.kernel.flow import constants_of
from camcli.kernel.forms import PLAIN
from camcli.kernel.orbit_loop import IMPACT
from camcli.kernel.variational import Growth, Pair, flight_tangent
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
