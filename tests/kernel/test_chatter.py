"""Accumulation of chatter on real orbits against the complete summation by the oracle."""

from functools import cache
from math import pi

import pytest

from camcli.kernel import flight as kernel_events
from tests.kernel.helpers import events, reference, run, system

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
    "r = 0.95": (116.5, {"restitution": 0.95}, 1),
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
@pytest.mark.parametrize("name", SCENES)
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


@pytest.mark.parametrize("r", [0.0, 1.0])
@pytest.mark.parametrize("rpm", [118.0, 150.0, 190.0])
def test_no_chatter_map_without_or_with_full_restitution(rpm, r, monkeypatch):
    """Rows 1 and 2: with r = 0 nothing hops, with r = 1 there is no 1/(1 - r)."""

    def never(*arguments):
        raise AssertionError("the chatter map was asked")

    monkeypatch.setattr(kernel_events, "chatter_map", never)
    monkeypatch.setattr(kernel_events, "_accumulation", never)
    tape = run(rpm, system(restitution=r), record=2, budget=100_000)
    assert "chatter" not in [row[0] for row in events(tape)]
    assert tape.cost.impacts > 0


@pytest.mark.parametrize("tolerance", [0.0, 1e-300, 1e-30])
def test_an_impossible_tolerance_ends_by_sticking(tolerance):
    """Hops of 1e-166 m are flown until u underflows; the accumulation is still right."""
    tape = run(130.0, system(), record=1, tolerance=tolerance)
    assert tape.status == 0
    kinds = [row[0] for row in events(tape)]
    assert kinds.count("detachment") == 2
    assert len(kinds) < 10_000
    last = max(row[2] for row in events(tape) if row[0] != "detachment" and row[2] < 3.4)
    assert last == pytest.approx(float(exact("top dwell")[0][0]), abs=1e-13)
