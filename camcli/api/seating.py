"""How hard a valve with a measured cam seats, with what the error of its table leaves.

The rows of the table are moved by errors of the size that the fit finds in them (`Errors.noise`),
equally likely up to sqrt(3) of that standard deviation, and fitted again with the same smoothing
lengths; each such cam seats its valve at a speed of its own. The velocity is uncertain by ERRORS
root mean squares of these deviations, and by what a rougher fit changes, which shows how far the
smoothing itself may bend the cam.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt
from random import Random
from typing import Any

import numpy as np

from camcli.analysis.contact_loss.study import ContactLoss, motion_past
from camcli.analysis.sweep import Speed
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
    others = list(_other_cams(system))
    rough, table = _shape(system).rougher
    rougher = System(system.follower, table, rough)
    ranges = []
    for rpm, motion in motions.items():
        moved = [motion_past(other, rpm, machine.settings) for other in (rougher, *others)]
        entry: dict[str, float | None] = {"rpm": rpm}
        for column in VELOCITIES:
            velocities = [_velocity(one, column) for one in moved]
            entry |= _range(column, _velocity(motion, column), velocities)
        ranges.append(entry)
    return ranges


def hardest(found: ContactLoss) -> Speed | None:
    """The motion past the loss of contact that seats hardest; None where none seats."""
    seated = [(_velocity(one, VELOCITIES[0]) or 0.0, one.rpm, one) for one in found.past]
    return max(seated, key=lambda one: one[:2])[2] if seated else None


def _shape(system: System) -> Any:
    """The table of a measured cam."""
    return system.shape


def _other_cams(system: System) -> Iterator[System]:
    """The machine with cams fitted to rows with other errors; a dwell stays where it is."""
    cam = _shape(system)
    from camcli.cams.lift_fit import Errors, Smoother

    turn = cam.measured
    noise = cam.errors.noise
    draw = Random(SEED)
    largest = sqrt(3.0) * noise
    moves = (turn.line > 0) & (turn.lift != turn.lift.min())
    for _ in range(CAMS):
        off = np.array([draw.uniform(-largest, largest) for _ in turn.lift])
        rows = replace(turn, lift=turn.lift + np.where(moves, off, 0.0))
        other = cam.model_copy()
        for known in ("errors", "accuracy", "least_lift", "rougher"):
            other.__dict__.pop(known, None)
        other.__dict__["errors"] = Errors(Smoother(rows), cam.errors.given)
        yield System(system.follower, build(other), other)


def _velocity(motion: Speed, column: str) -> float | None:
    """A velocity of the seat of a motion, m/s; None where it never seats."""
    value = None if motion.loads is None else getattr(motion.loads, column)
    return None if value is None else float(value)


def _range(
    column: str, own: float | None, velocities: list[float | None]
) -> dict[str, float | None]:
    """A velocity and the ends of its range, by their keys; None where the valve never seats.

    velocities: of the rougher fit, then of the other cams. One with which the valve never seats
    counts as 0.
    """
    from camcli.cams.lift_fit import ERRORS

    name = column.removesuffix("_m_per_s")
    low = high = None
    if own is not None:
        rough, *others = [0.0 if value is None else value for value in velocities]
        scatter = sqrt(sum((value - own) ** 2 for value in others) / len(others))
        off = ERRORS * scatter + abs(rough - own)
        low, high = max(own - off, 0.0), own + off
    return {column: own, f"{name}_low_m_per_s": low, f"{name}_high_m_per_s": high}
