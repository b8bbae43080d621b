"""Lyapunov exponents: the sum rule, exact values, two trajectories, and what rests."""

import math

import pytest
from conftest import chapter_system, settings, solve_from

from camcli.analysis.exponents import of_orbit, of_record, sum_rule
from camcli.analysis.integrate import Orbit, Start
from camcli.system import omega_of


def measured(system, rpm, record=1500):
    """Exponents of the record after 600 turns."""
    return of_record(system, rpm, Orbit(system, rpm, settings(600, record)).run())


@pytest.mark.parametrize(
    ("rpm", "follower"),
    [
        (361.0, {}),
        (745.0, {"damping": 2.0}),
        (745.0, {"gravity": 9.81, "restitution": 0.7}),
        (400.0, {"preload": 50.0, "restitution": 0.9}),
    ],
)
def test_the_sum_of_both_exponents_is_the_mean_contraction(rpm, follower):
    found = measured(chapter_system(**follower), rpm)
    assert abs(found.defect) < 1e-9
    assert found.rule < 0.0


@pytest.mark.parametrize("damping", [0.0, 1.5])
@pytest.mark.parametrize("on_seat", [0.0, 0.25, 2.0])
@pytest.mark.parametrize("on_cam", [0.0, 1.75])
def test_what_is_left_of_an_area_after_a_turn(on_cam, on_seat, damping):
    """Damping takes exp(-c t / m) of it, each impact the square of its own restitution."""
    mass, rpm, lobe, seat = 1.3, 240.0, 0.8, 0.3
    system = chapter_system(damping=damping, mass=mass, restitution=lobe, seat_restitution=seat)
    left = math.exp(-damping / mass * 60.0 / rpm) * lobe ** (2 * on_cam) * seat ** (2 * on_seat)
    found = sum_rule(system.constants(rpm, 1.0, 1), on_cam + on_seat, on_seat)
    assert math.exp(found) == pytest.approx(left, rel=1e-12)
    plastic = chapter_system(mass=mass, restitution=0.0, seat_restitution=seat)
    gone = sum_rule(plastic.constants(rpm, 1.0, 1), on_cam + on_seat, on_seat)
    assert (gone == -math.inf) == (on_cam > 0.0)


def test_a_solved_orbit_has_the_exponents_of_its_multipliers(chapter):
    found = of_orbit(chapter, solve_from(chapter, 700.0, settings(600)))
    assert found.largest == pytest.approx(math.log(0.8), rel=1e-14)
    assert found.second == pytest.approx(math.log(0.8), rel=1e-14)
    rough = measured(chapter, 700.0)
    assert abs(rough.largest - found.largest) < 5.0 * rough.spread
    three = of_orbit(chapter, solve_from(chapter, 358.5, settings(600)))
    assert three.impacts == pytest.approx(8.0 / 3.0, rel=1e-15)  # P(3;3:3:2)
    assert three.rule == pytest.approx(2.0 * math.log(0.8) * 8.0 / 3.0, rel=1e-14)
    assert abs(three.defect) < 1e-8
    assert three.largest == pytest.approx(8.0 * math.log(0.8) / 3.0, rel=1e-12)


def test_chaos_agrees_with_two_trajectories(chapter):
    found = measured(chapter, 745.0, 4000)
    assert found.chaotic
    estimate, error = two_trajectories(chapter, 745.0, 600)
    assert abs(found.largest - estimate) < 3.0 * math.hypot(error, found.spread)
    assert error < 0.1


def two_trajectories(system, rpm, turns):
    """Mean growth per turn of a difference of 1e-8, brought back to that size after every turn.

    Nothing of the saltation matrices is used: both orbits are simulated.
    """
    omega, size = omega_of(rpm), 1e-8
    state = strobe(Orbit(system, rpm, settings(600, 1)))
    offset, logs = (size, 0.0), []
    for _ in range(turns):
        pair = [state, (state[0] + offset[0], state[1] + offset[1])]
        ends = [strobe(Orbit(system, rpm, settings(0, 1), Start(q, w * omega))) for q, w in pair]
        difference = [ends[1][j] - ends[0][j] for j in range(2)]
        length = math.hypot(*difference)
        logs.append(math.log(length / size))
        offset = tuple(x / length * size for x in difference)
        state = ends[0]
    mean = sum(logs) / turns
    batches = [sum(logs[k : k + 60]) / 60 for k in range(0, turns, 60)]
    variance = sum((b - mean) ** 2 for b in batches) / (len(batches) - 1)
    return mean, math.sqrt(variance / len(batches))


def strobe(orbit):
    """State at the strobe after the run."""
    orbit.run(events=False, strobes=False)
    return orbit.position()
