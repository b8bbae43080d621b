"""How hard a valve with a measured cam seats, from motions and cams made by hand."""

from __future__ import annotations

from itertools import count
from math import sqrt
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.api import seating
from camcli.cams.lift_fit import ERRORS


def motion(rpm, velocity, ramp=None):
    loads = Made(seat_velocity_m_per_s=velocity, seat_ramp_velocity_m_per_s=ramp)
    return Made(rpm=rpm, loads=loads)


@pytest.mark.parametrize(
    ("value", "rougher", "moved"),
    [
        (0.5, 0.46875, [0.5625, 0.4375, 0.53125]),
        (0.5, None, [None, 0.5, 0.5]),  # one that never seats counts as 0
        (0.03125, 0.0625, [0.125, 0.25]),  # the lower end is not below 0
    ],
)
def test_a_velocity_of_seating_has_both_errors_on_either_side(value, rougher, moved):
    """ERRORS root mean squares of what the cams that were moved change, and the rougher fit's."""
    squares = [((other or 0.0) - value) ** 2 for other in moved]
    error = ERRORS * sqrt(sum(squares) / len(squares)) + abs((rougher or 0.0) - value)
    told = seating._range("seat_velocity_m_per_s", value, rougher, moved)
    assert told == {
        "seat_velocity_m_per_s": value,
        "seat_velocity_low_m_per_s": pytest.approx(max(value - error, 0.0)),
        "seat_velocity_high_m_per_s": pytest.approx(value + error),
    }


def test_a_valve_that_never_seats_has_no_range():
    assert seating._range("seat_ramp_velocity_m_per_s", None, 0.5, [0.25]) == {
        "seat_ramp_velocity_m_per_s": None, "seat_ramp_velocity_low_m_per_s": None,
        "seat_ramp_velocity_high_m_per_s": None,
    }  # fmt: skip


def test_the_motion_that_seats_hardest_is_the_faster_one_of_two():
    past = [motion(700.0, 0.5), motion(800.0, 0.5), motion(900.0, None), motion(600.0, 0.25)]
    assert seating.hardest(Made(past=past)).rpm == 800.0
    assert seating.hardest(Made(past=past[::-1])).rpm == 800.0
    never = [motion(700.0, None), Made(rpm=750.0, loads=None)]
    assert seating.hardest(Made(past=never)).rpm == 750.0
    assert seating.hardest(Made(past=[])) is None


def test_the_rows_of_the_file_are_moved_by_their_noise(monkeypatch):
    """But for the base dwell and rows between those of the file; by up to sqrt(3) of it."""
    asked = []
    lift = np.array([0.0, 1.0, 2.0, 3.0, 0.0])
    turn = Made(lift=lift, line=np.array([1, 2, 0, 3, 0]))
    cam = Made(measured=turn, errors=Made(noise=0.5),
               with_lifts=lambda lifts: asked.append(lifts) or len(asked))  # fmt: skip
    monkeypatch.setattr(seating, "build", lambda cam: f"built {cam}")
    monkeypatch.setattr(seating, "System", lambda *given: given)
    draws = count(1)

    class Draws:
        def __init__(self, seed):
            assert seed == 0

        def uniform(self, low, high):
            assert (low, high) == pytest.approx((-0.5 * sqrt(3.0), 0.5 * sqrt(3.0)))
            return 0.001 * next(draws)

    monkeypatch.setattr(seating, "Random", Draws)
    systems = list(seating._moved_cams(Made(shape=cam, follower="follower")))
    assert systems == [("follower", f"built {k}", k) for k in range(1, 9)]
    for k, lifts in enumerate(asked):
        errors = 0.001 * (5 * k + np.arange(1, 6))
        assert lifts == pytest.approx(lift + np.array([0.0, errors[1], 0.0, errors[3], 0.0]))


def test_ranges_of_seating_are_those_of_three_motions(monkeypatch):
    """The hardest one past the loss of contact, the one at work and one asked for; each once."""
    shape = Made(rougher=("rougher shape", "rougher cam"))
    system = Made(has_seat=True, follower="follower", shape=shape)
    machine = Made(scene=Made(cam=Made(kind="table")), system=system, settings="settings")
    monkeypatch.setattr(seating, "System", lambda *given: given)
    monkeypatch.setattr(seating, "_moved_cams", lambda system: ["moved 1", "moved 2"])
    followed = []

    def motion_past(system, rpm, settings):
        assert settings == "settings"
        followed.append((system, rpm))
        return motion(rpm, 0.1 * len(followed), 0.01 * len(followed))

    monkeypatch.setattr(seating, "motion_past", motion_past)
    monkeypatch.setattr(seating, "_range", lambda column, *given: {column: given})
    found = Made(past=[motion(700.0, 0.5, 0.75), motion(800.0, 0.25)],
                 at_work=motion(650.0, 0.125), at_asked=motion(750.0, None, 0.375))  # fmt: skip
    entries = seating.seating_ranges(machine, found)
    assert [entry["rpm"] for entry in entries] == [700.0, 650.0, 750.0]
    rougher = ("follower", "rougher cam", "rougher shape")
    assert followed == [
        (system, rpm) for rpm in (700.0, 650.0, 750.0) for system in (rougher, "moved 1", "moved 2")
    ]
    first = entries[0]
    assert first["seat_velocity_m_per_s"] == (0.5, pytest.approx(0.1), pytest.approx([0.2, 0.3]))
    assert first["seat_ramp_velocity_m_per_s"] == (
        0.75, pytest.approx(0.01), pytest.approx([0.02, 0.03])
    )  # fmt: skip
    assert entries[2]["seat_velocity_m_per_s"][0] is None
    found.at_asked = Made(rpm=750.0, loads=None)
    found.at_work = found.past[0]
    assert [entry["rpm"] for entry in seating.seating_ranges(machine, found)] == [700.0]
    nothing = Made(past=[], at_work=None, at_asked=None)
    assert seating.seating_ranges(machine, nothing) == []
    system.has_seat = False
    assert seating.seating_ranges(machine, found) == []
    system.has_seat, machine.scene.cam.kind = True, "law"
    assert seating.seating_ranges(machine, found) == []
