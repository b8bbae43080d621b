"""What the picture of an orbit shows: the last turns in columns, smooth between the samples."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from camcli.analysis.simulate import STICKING, Simulation

BLINK = 1e-9  # turns: closer is the same time
FINER = 8  # points from one row to the next
MOST_POINTS = 400_000


@dataclass(frozen=True)
class Trace:
    """Columns over time, in degrees, m and m/s; phases count on from turn to turn.

    `sticks` holds from a point to the next. `events` has (angle, q) of every kind of event, and
    `jumps` (u_minus, u_plus) of the impacts. `origin` is the angle at time 0.
    """

    low: float
    high: float
    origin: float
    angle: np.ndarray
    cam: np.ndarray
    gap: np.ndarray
    u: np.ndarray
    sticks: np.ndarray
    events: dict[str, np.ndarray]
    jumps: np.ndarray

    @classmethod
    def of(cls, simulation: Simulation, turns: int) -> Trace | None:
        """The last turns of a simulation; None where it has no trajectory."""
        rows = simulation.trajectory
        if not rows:
            return None
        per_second = simulation.rpm / 60.0
        first, last = _turns(rows, per_second, turns)
        begin = (first - BLINK) / per_second
        origin = round(rows[0][1] - 360.0 * per_second * rows[0][0], 9) % 360.0
        kept = [row for row in rows if row[0] >= begin]
        t, _, q, v, c, c_dot = np.array([row[:6] for row in kept], dtype=float).T
        parts = max(2, min(FINER, MOST_POINTS // len(kept)))
        gap, u = _finer(t, q - c, v - c_dot, parts)
        sticks = [row[6] == STICKING for row in kept]
        events = [row for row in simulation.events if row[0] >= begin]
        return cls(
            low=360.0 * first + origin,
            high=360.0 * last + origin,
            origin=origin,
            angle=360.0 * per_second * _finer(t, t, np.ones_like(t), parts)[0] + origin,
            cam=_finer(t, c, c_dot, parts)[0],
            gap=np.maximum(gap, min(0.0, float((q - c).min()))),
            u=u,
            sticks=np.append(np.repeat(sticks[:-1], parts), sticks[-1]).astype(bool),
            events=_events(events, 360.0 * per_second, origin),
            jumps=np.array([row[5:7] for row in events if row[3] == "impact"]).reshape(-1, 2),
        )

    def during(self, values: np.ndarray, sticking: bool) -> np.ndarray:
        """Values on the segments of one state of the contact, nan elsewhere."""
        begins = self.sticks == sticking
        ends = np.append(False, begins[:-1])
        return np.where(begins | ends, values, np.nan)


def _turns(rows: list[tuple], per_second: float, turns: int) -> tuple[int, int]:
    """First and last whole turn to show."""
    begin = floor(rows[0][0] * per_second + BLINK)
    last = max(ceil(rows[-1][0] * per_second - BLINK), begin + 1)
    return max(last - turns, begin), last


def _events(rows: list[tuple], degrees_per_second: float, origin: float) -> dict[str, np.ndarray]:
    kinds = dict.fromkeys(row[3] for row in rows)
    return {
        kind: np.array(
            [(row[0] * degrees_per_second + origin, row[4]) for row in rows if row[3] == kind]
        )
        for kind in kinds
    }


def _finer(t: np.ndarray, y: np.ndarray, slope: np.ndarray, parts: int):
    """Values and slopes of the cubic through both at the rows, `parts` points per segment.

    Where time stands still (a jump of the slope), the slopes within are nan: a gap in the curve.
    """
    x = np.arange(parts) / parts
    h = np.diff(t)[:, None]
    rise = np.diff(y)[:, None]
    start, end = h * slope[:-1, None], h * slope[1:, None]
    values = y[:-1, None] + x * (
        start + x * (3.0 * rise - 2.0 * start - end + x * (start + end - 2.0 * rise))
    )
    slopes = start + x * (
        2.0 * (3.0 * rise - 2.0 * start - end) + 3.0 * x * (start + end - 2.0 * rise)
    )
    slopes = np.divide(slopes, h, out=np.full_like(slopes, np.nan), where=h > 0.0)
    slopes[:, 0] = slope[:-1]
    return np.append(values.ravel(), y[-1]), np.append(slopes.ravel(), slope[-1])
