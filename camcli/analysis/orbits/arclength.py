"""Pseudo-arclength continuation of a periodic orbit with impacts in one parameter.

Keller's method (Allgower & Georg, Numerical Continuation Methods, 1990, ch. 2 and 6): predict along
the tangent, correct on the plane across it. The metric weighs PHASE rad, PHASE times the orbit's
own rate and the whole range of the parameter alike. A step is halved until the corrector is quick,
the tangent turns little and the trace changes little. An impact may leave the smooth region it uses
by a little; who follows the branch then cuts the step at the corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camcli.analysis.orbits.shooter import Root, Shooter, Vector

MOST_NEWTON = 7  # steps of the corrector, beyond which the predictor is halved
QUICK = 4  # steps of the corrector that let the next step grow
GROWTH = 1.6
TURNED = 0.9  # least cosine between the tangents of neighbouring points
STEEP_TRACE = 100.0  # trace beyond which its change says nothing: an impact fades
OVERSHOOT = 0.02  # rad beyond the end of a smooth region
PHASE = 5.0  # rad, of an impact, that counts as much as the whole range of the parameter
TRACE_CHANGE = 0.3  # of 1 + |trace|, from point to point
SMALLEST_STEP = 1e-10  # step in the metric below which a branch is given up


@dataclass(frozen=True)
class Span:
    """Range of the parameter, and the largest step of it between points."""

    low: float
    high: float
    spacing: float

    @property
    def width(self) -> float:
        return self.high - self.low

    def holds(self, value: float) -> bool:
        """True within the range, ends included."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class Metric:
    """Weights of the unknowns theta_1, v_1, ..., parameter in the length of a step; (2 n + 1,)."""

    weights: np.ndarray

    @classmethod
    def of(cls, root: Root, width: float) -> Metric:
        """Phases in PHASE rad, rates in PHASE times the largest, the parameter in its range."""
        n = root.count
        rate = max(abs(v) for v in root.x[1:-1:2]) or 1.0
        share = n * PHASE * PHASE
        pair = (1.0 / share, 1.0 / (share * rate * rate))
        return cls(np.array([*pair * n, 1.0 / (width * width)]))

    def dot(self, a: Vector, b: Vector) -> float:
        """Inner product; added up in order, since np.dot's order is the machine's."""
        return float(np.cumsum(self.weights * a * b)[-1])

    def oriented(self, root: Root, along: Vector) -> np.ndarray:
        """The root's tangent with length 1, on the side of `along`."""
        unit = np.divide(root.tangent, np.sqrt(self.dot(root.tangent, root.tangent)))
        return unit if self.dot(unit, along) >= 0.0 else -unit


@dataclass(frozen=True)
class BranchStep:
    """From `before` along the unit direction to `after`, `length` away."""

    before: Root
    unit: np.ndarray
    after: Root
    length: float
    metric: Metric

    def at(self, shooter: Shooter, length: float) -> Root | None:
        """The root at another distance within the step, its guess from both ends."""
        share = length / self.length if self.length > 0.0 else 0.0
        guess = self.before.x + share * np.subtract(self.after.x, self.before.x)
        row = self.metric.weights * self.unit
        before = self.before
        return shooter.correct(guess, before.whole, before.turns, row, before.x, length)

    def reach(self, root: Root) -> float:
        """Distance of a root from the beginning, along the step."""
        return self.metric.dot(self.unit, np.subtract(root.x, self.before.x))

    def cut(self, root: Root) -> BranchStep:
        """The part of the step up to a root on it."""
        return BranchStep(self.before, self.unit, root, self.reach(root), self.metric)

    def rest(self, root: Root) -> BranchStep:
        """The part of the step behind a root on it."""
        unit = self.metric.oriented(root, self.unit)
        length = self.metric.dot(unit, np.subtract(self.after.x, root.x))
        return BranchStep(root, unit, self.after, length, self.metric)


def steps(
    shooter: Shooter, root: Root, along: Vector, metric: Metric, span: Span
) -> Iterator[BranchStep | None]:
    """Steps from a root in the direction `along`, for ever; None where no step succeeds.

    No step leaves the range: one that would ends at its bound. The caller stops at the end of what
    it wants, and starts anew where it cuts a step short.
    """
    longest = span.spacing / span.width
    unit = metric.oriented(root, along)
    length = longest
    while True:
        step = _corrected(shooter, root, unit, metric, length, span)
        if step is None or not _acceptable(shooter, step):
            length *= 0.5
            if length < SMALLEST_STEP:
                yield None
                return
            continue
        yield step
        root = step.after
        unit = metric.oriented(step.after, unit)
        length = min(longest, step.length * (GROWTH if root.steps <= QUICK else 1.0))


def _corrected(
    shooter: Shooter, root: Root, unit: np.ndarray, metric: Metric, length: float, span: Span
) -> BranchStep | None:
    """One step of predictor and corrector, `length` along the unit tangent; None where it fails.

    The corrector keeps the distance from the root along the tangent. Where the predictor leaves the
    range, the step is cut at the range's bound, and the corrector keeps the parameter there.
    """
    guess = root.x + length * unit
    end = float(guess[-1])
    if span.holds(end):
        row = metric.weights * unit
        after = shooter.correct(guess, root.whole, root.turns, row, root.x, length)
        if after is None or not span.holds(after.value):
            return None
        return BranchStep(root, unit, after, length, metric)
    bound = span.low if end < span.low else span.high
    share = (bound - root.value) / (end - root.value)
    after = shooter.at_value(root.x + share * length * unit, root.whole, root.turns, bound)
    return None if after is None else BranchStep(root, unit, after, length, metric).cut(after)


def _acceptable(shooter: Shooter, step: BranchStep) -> bool:
    """True where the branch is resolved by the step."""
    before, after = step.before, step.after
    if after.steps > MOST_NEWTON or step.length <= 0.0:
        return False
    if step.metric.dot(step.metric.oriented(after, step.unit), step.unit) < TURNED:
        return False
    if any(far > OVERSHOOT for far, _, _ in shooter.beyond(after)):
        return False
    change = abs(after.trace - before.trace)
    return abs(before.trace) >= STEEP_TRACE or change <= TRACE_CHANGE * (1.0 + abs(before.trace))
