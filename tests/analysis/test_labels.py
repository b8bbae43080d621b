"""Labels from stroboscopic records."""

from math import cos, exp, inf

import pytest
from conftest import settings

from camcli.analysis.labels import Label, find_period
from camcli.analysis.sweep import sweep


def test_name_is_the_largest_rotation():
    assert Label([3, 2, 3]) == "P(3;3:3:2)"
    assert Label([2, inf, 1]) == "P(3;inf:1:2)"
    assert Label([0]) == "P(1;0)"


def test_fixed_point_and_period_three():
    assert find_period([1.0] * 40, [2.0] * 40, [1] * 40) == 1
    q = [1.0, 2.0, 3.0] * 20
    assert find_period(q, q, [1] * 60) == 3


def test_symbols_decide_where_states_agree():
    assert find_period([1.0] * 40, [2.0] * 40, [1, 2] * 20) == 2


@pytest.mark.parametrize("multiplier", [0.9, -0.9, 0.985, -0.985])
def test_slow_convergence_is_recognised(multiplier):
    q = [1.0 + 1e-2 * multiplier**k for k in range(400)]
    assert find_period(q, q, [1] * 400) == 1


def test_convergence_to_a_split_orbit_is_not_its_mean():
    q = [1.0 + (-1) ** k * (1e-3 + 1e-2 * exp(-0.01 * k)) for k in range(400)]
    assert find_period(q, q, [1] * 400) == 2


def test_quasiperiodic_and_chaotic_records_have_no_period():
    quasi = [2.0 + cos(2.399963 * k) for k in range(400)]
    assert find_period(quasi, quasi, [1] * 400) == 0
    chaos = [0.3]
    for _ in range(399):
        chaos.append(3.9 * chaos[-1] * (1 - chaos[-1]))
    assert find_period(chaos, chaos, [1] * 400) == 0


def test_a_record_of_few_impacts_is_undecided(chapter):
    result = sweep(chapter, [745.0], settings(100, 10))
    assert result.speeds[0].label == "undecided"
    result = sweep(chapter, [745.0], settings(100, 40))
    assert result.speeds[0].label == "aperiodic"
