"""How hard a valve with a measured cam seats, with what the error of its table leaves.

The rows of the table are moved by errors of the size that the fit finds in them (`Errors.noise`),
equally likely up to sqrt(3) of that standard deviation, and fitted again with the same smoothing
lengths; each such cam seats its valve at a speed of its own. The velocity is uncertain by ERRORS
root mean squares of these deviations, and by what a rougher fit changes, which shows how far the
smoothing itself may bend the cam.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from random import Random
from typing import Any

import numpy as np

from camcli.analysis.contact_loss.study import ContactLoss, motion_past
from camcli.analysis.speeds import Speed
from camcli.api.machine import Machine
from camcli.cams.compile import build
from camcli.system import System

CAMS = 8  # tables with other errors
SEED = 0
VELOCITIES = ("seat_velocity_m_per_s", "seat_ramp_velocity_m_per_s")


def seating_ranges(machine: Machine, found: ContactLoss) -> list[dict[str, float | None]]:
    """Entries of run.json for the speed of hardest seating, the working speed and one asked for.

    None of a cam that is not measured, or of a follower without a seat.
    """
    system = machine.system
    if machine.scene.cam.kind != "table" or not system.has_seat:
        return []
    motions = {
        motion.rpm: motion
        for motion in (hardest(found), found.at_work, found.at_asked)
        if motion is not None and motion.loads is not None
    }
    if not motions:
        return []
    moved_cams = list(_moved_cams(system))
    rougher_shape, rougher_cam = _shape(system).rougher
    rougher = System(system.follower, rougher_cam, rougher_shape)
    ranges = []
    for rpm, motion in motions.items():
        by_rougher = motion_past(rougher, rpm, machine.settings)
        by_moved = [motion_past(moved, rpm, machine.settings) for moved in moved_cams]
        entry: dict[str, float | None] = {"rpm": rpm}
        for column in VELOCITIES:
            entry |= _range(
                column,
                _velocity(motion, column),
                _velocity(by_rougher, column),
                [_velocity(other, column) for other in by_moved],
            )
        ranges.append(entry)
    return ranges


def hardest(found: ContactLoss) -> Speed | None:
    """The motion past the loss of contact that seats hardest; None where none was followed.

    Of two that seat alike it is the faster one.
    """

    def hardness(motion: Speed) -> tuple[float, float]:
        """Velocity at the seat (m/s; 0 where it never seats) and speed of the cam (rpm)."""
        return _velocity(motion, "seat_velocity_m_per_s") or 0.0, motion.rpm

    return max(found.past, key=hardness, default=None)


def _shape(system: System) -> Any:
    """The table of a measured cam."""
    return system.shape


def _moved_cams(system: System) -> Iterator[System]:
    """The machine on CAMS cams, each fitted to rows that are moved by errors.

    The errors of rows of the file are as large as their noise; the base dwell stays where it is.
    """
    cam = _shape(system)
    turn = cam.measured
    generator = Random(SEED)
    largest = sqrt(3.0) * cam.errors.noise  # of errors that are equally likely up to it
    is_row_of_the_file = turn.line > 0
    moves = is_row_of_the_file & (turn.lift != turn.lift.min())
    for _ in range(CAMS):
        errors = np.array([generator.uniform(-largest, largest) for _ in turn.lift])
        moved_cam = cam.with_lifts(turn.lift + np.where(moves, errors, 0.0))
        yield System(system.follower, build(moved_cam), moved_cam)


def _velocity(motion: Speed, column: str) -> float | None:
    """A velocity of the seat of a motion, m/s; None where it never seats."""
    value = None if motion.loads is None else getattr(motion.loads, column)
    return None if value is None else float(value)


def _range(
    column: str, value: float | None, by_rougher: float | None, by_moved: list[float | None]
) -> dict[str, float | None]:
    """A velocity (m/s) and the ends of its range, by their keys; None where the valve never seats.

    by_rougher, by_moved: the same with the rougher fit, and with the moved cams. One with which the
    valve never seats counts as 0.
    """
    from camcli.cams.lift_fit import ERRORS

    name = column.removesuffix("_m_per_s")
    low = high = None
    if value is not None:
        squares = sum(((moved or 0.0) - value) ** 2 for moved in by_moved)
        scatter = sqrt(squares / len(by_moved))
        error = ERRORS * scatter + abs((by_rougher or 0.0) - value)
        low = max(value - error, 0.0)
        high = value + error
    return {column: value, f"{name}_low_m_per_s": low, f"{name}_high_m_per_s": high}
