"""Pseudo-arclength continuation of a periodic orbit with impacts in one parameter.

Keller's method: predict along the tangent, correct on the plane across it. The metric weighs
PHASE rad, PHASE times the orbit's own rate and the whole range of the parameter alike. A step
is halved until the corrector is quick, the tangent turns little and the trace changes little. An
impact may leave the smooth region it uses by a little; `stops` then cuts the step at the corner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt

from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.kernel.cam_table import END, ROW, START

MOST_NEWTON = 7  # steps of the corrector, beyond which the predictor is halved
QUICK = 4  # steps of the corrector that let the next step grow
GROWTH = 1.6
TURNED = 0.9  # least cosine between the tangents of neighbouring points
STEEP = 100.0  # trace beyond which its change says nothing: an impact fades
OVERSHOOT = 0.02  # rad beyond the end of a smooth region
PHASE = 5.0  # rad, of an impact, that counts as much as the whole range of the parameter
TRACE_CHANGE = 0.3  # of 1 + |trace|, from point to point
SMALLEST = 1e-10  # step in the metric below which a branch is given up


@dataclass(frozen=True)
class Metric:
    """Weights of the unknowns in the length of a step."""

    weights: tuple[float, ...]

    @classmethod
    def of(cls, root: Root, span: float) -> Metric:
        """Phases in PHASE rad, rates in PHASE times the largest, the parameter in its span."""
        n = root.count
        rate = max(abs(v) for v in root.x[1:-1:2]) or 1.0
        share = n * PHASE * PHASE
        pair = (1.0 / share, 1.0 / (share * rate * rate))
        return cls(pair * n + (1.0 / (span * span),))

    def dot(self, a: Sequence[float], b: Sequence[float]) -> float:
        """Inner product of two directions."""
        return sum(w * x * y for w, x, y in zip(self.weights, a, b, strict=True))

    def unit(self, direction: Sequence[float]) -> list[float]:
        """The direction with length 1."""
        size = sqrt(self.dot(direction, direction))
        return [x / size for x in direction]

    def row(self, unit: Sequence[float]) -> list[float]:
        """The border row that measures the length along a unit direction."""
        return [w * x for w, x in zip(self.weights, unit, strict=True)]


@dataclass(frozen=True)
class Step:
    """From `before` along the unit direction to `after`, `length` away."""

    before: Root
    unit: list[float]
    after: Root
    length: float
    metric: Metric

    def at(self, shooter: Shooter, length: float) -> Root | None:
        """The root at another distance within the step, its guess from both ends."""
        share = length / self.length if self.length > 0.0 else 0.0
        guess = [a + share * (b - a) for a, b in zip(self.before.x, self.after.x, strict=True)]
        return shooter.correct(
            guess, self.before.whole, self.before.turns, self.metric.row(self.unit),
            self.before.x, length,
        )  # fmt: skip

    def reach(self, root: Root) -> float:
        """Distance of a root from the beginning, along the step."""
        row = self.metric.row(self.unit)
        return sum(r * (a - b) for r, a, b in zip(row, root.x, self.before.x, strict=True))

    def cut(self, root: Root) -> Step:
        """The part of the step up to a root on it."""
        return Step(self.before, self.unit, root, self.reach(root), self.metric)


def oriented(metric: Metric, root: Root, along: Sequence[float]) -> list[float]:
    """The root's unit tangent, on the side of `along`."""
    unit = metric.unit(root.tangent)
    return unit if metric.dot(unit, along) >= 0.0 else [-x for x in unit]


def beyond(shooter: Shooter, root: Root) -> list[tuple[float, int, int]]:
    """(rad beyond, impact, +1 at the end or -1 at the start) of impacts outside their region."""
    rows = shooter.cam.rows
    out = []
    for k, theta in enumerate(root.theta):
        o = root.whole[2 * k] * ROW
        if theta < rows[o + START]:
            out.append((rows[o + START] - theta, k, -1))
        elif theta > rows[o + END]:
            out.append((theta - rows[o + END], k, 1))
    return out


@dataclass(frozen=True)
class Span:
    """Range of the parameter, and the largest step of it between points."""

    low: float
    high: float
    spacing: float

    @property
    def width(self) -> float:
        """high - low."""
        return self.high - self.low

    def holds(self, value: float) -> bool:
        """True within the range, ends included."""
        return self.low <= value <= self.high


def walk(
    shooter: Shooter, root: Root, along: Sequence[float], metric: Metric, span: Span
) -> Iterator[Step | None]:
    """Steps from a root in the direction `along`, for ever; None where no step succeeds.

    No step leaves the range: one that would ends at its bound. The caller stops at the end of what
    it wants, and starts anew where it cuts a step short.
    """
    longest = span.spacing / span.width
    unit, length = oriented(metric, root, along), longest
    while True:
        step = _step(shooter, root, unit, metric, length, span)
        if step is None:
            length *= 0.5
            if length < SMALLEST:
                yield None
                return
            continue
        yield step
        root, unit = step.after, oriented(metric, step.after, unit)
        length = min(longest, step.length * (GROWTH if root.steps <= QUICK else 1.0))


def _step(shooter, root: Root, unit, metric: Metric, length: float, span: Span) -> Step | None:
    step = _corrected(shooter, root, unit, metric, length, span)
    if step is None or step.after.steps > MOST_NEWTON or step.length <= 0.0:
        return None
    after = step.after
    if metric.dot(oriented(metric, after, unit), unit) < TURNED:
        return None
    if any(far > OVERSHOOT for far, _, _ in beyond(shooter, after)):
        return None
    change = abs(after.trace - root.trace)
    if abs(root.trace) < STEEP and change > TRACE_CHANGE * (1.0 + abs(root.trace)):
        return None
    return step


def _corrected(shooter, root: Root, unit, metric: Metric, length: float, span: Span):
    """Predictor and corrector; at the end of the range with a fixed parameter."""
    guess = [x + length * t for x, t in zip(root.x, unit, strict=True)]
    if span.low <= guess[-1] <= span.high:
        after = shooter.correct(guess, root.whole, root.turns, metric.row(unit), root.x, length)
        if after is None or not span.low <= after.value <= span.high:
            return None
        return Step(root, unit, after, length, metric)
    bound = span.low if guess[-1] < span.low else span.high
    share = (bound - root.value) / (guess[-1] - root.value)
    guess = [x + share * length * t for x, t in zip(root.x, unit, strict=True)]
    after = shooter.at_value(guess, root.whole, root.turns, bound)
    return None if after is None else Step(root, unit, after, length, metric).cut(after)
