"""Accumulation of chatter on real orbits against the complete summation by the oracle."""

from functools import cache
from math import pi

import pytest

from tests.conftest import some_in_ci
from tests.support.kernel_runs import events, reference, run, system

ROUNDING = 2e-14  # turns per unit of the event's own stretching, beside the tolerance
TOLERANCES = [10.0**-n for n in (3, 5, 7, 9, 11, 13)]
SCENES = {
    "just before c": (119.7, {}, 1),
    "top dwell": (130.0, {}, 1),
    "fall": (160.0, {}, 2),
    "into the next turn": (190.0, {}, 2),
    "gravity": (170.0, {"restitution": 0.5, "gravity": 9.81}, 1),
    "damped": (150.0, {"damping": 30.0}, 1),
    "strongly damped": (190.0, {"damping": 150.0}, 1),
    "r = 0.05": (150.0, {"restitution": 0.05}, 1),
    "r = 0.1, damped": (190.0, {"restitution": 0.1, "damping": 50.0}, 1),
    "r = 0.3": (150.0, {"restitution": 0.3}, 1),
    "r = 0.9": (116.5, {"restitution": 0.9}, 1),
}


@cache
def exact(name):
    """(phase, stretching) of the accumulations, rad from the start, with all hops summed."""
    rpm, changes, turns = SCENES[name]
    cut = 1e-20 if changes.get("restitution", 0.8) < 0.85 else 1e-15  # rad neglected
    rows = reference(rpm, turns=turns, cut=cut, **changes)
    return [
        (row.theta + 2 * pi * row.turn, float(row.stretching))
        for row in rows
        if row.kind == "chatter"
    ]


def ours(name, tolerance):
    """(phases of the accumulations, impacts flown)"""
    rpm, changes, turns = SCENES[name]
    tape = run(rpm, system(**changes), record=turns, tolerance=tolerance)
    rows = [row[2] + 2 * pi * row[1] for row in events(tape) if row[0] == "chatter"]
    return rows, tape.cost.impacts


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    some_in_ci(
        SCENES,
        quick=["fall", "into the next turn", "gravity", "r = 0.05", "r = 0.1, damped", "r = 0.3"],
    ),
)
def test_the_error_of_an_accumulation_is_below_the_tolerance(name):
    """At every tolerance a user may ask for, in fractions of a turn; a smaller one flies more."""
    expected, impacts = exact(name), []
    assert expected
    for tolerance in TOLERANCES:
        found, count = ours(name, tolerance)
        assert len(found) == len(expected)
        for a, (b, stretching) in zip(found, expected, strict=True):
            assert abs(float(a - b)) / (2 * pi) <= tolerance + ROUNDING * stretching, tolerance
        impacts.append(count)
    assert impacts == sorted(impacts)
    assert impacts[0] < impacts[-1]


@pytest.mark.parametrize("rpm", [150.0, 190.0])
def test_a_chatter_is_closed_after_few_impacts(rpm):
    """The series of the map spares most hops at a tolerance of 1e-9 turns."""
    tape = run(rpm, system(), record=3)
    closed = [row[1] for row in events(tape) if row[0] == "chatter"]
    assert len(closed) >= 2
    assert tape.cost.impacts <= 3 * 15
