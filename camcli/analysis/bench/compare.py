"""A run against the reference: errors, missed and invented impacts, and our own bound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import nan

from camcli.analysis.bench.cases import OPTIONAL, Case, Mark
from camcli.analysis.bench.peers.world import Trace

CLOSEST = 1e-6  # turns: impacts closer than this are told apart by their speed too
WIDEST = 0.05  # turns: an impact further off is another one
MANY = 2000  # invented impacts beyond which they are not told apart
SAME_SPEED = 1.1  # ratio: bounces of a chatter differ by 1/r = 1.25 from one to the next


@dataclass(frozen=True)
class Agreement:
    """How a run agrees with the reference; errors in turns, and of the state as for `error`."""

    error: float
    missed: int
    extra: int
    excess: float  # largest error over its bound, of ours
    bound: float  # where the largest error is


def windows(marks: Sequence[Mark]) -> list[float]:
    """How far from each impact of the reference the same impact may be: to half its neighbours."""
    at = [mark.at for mark in marks]
    gaps = [b - a for a, b in pairwise(at)]
    sides = zip([WIDEST, *gaps], [*gaps, WIDEST], strict=True)
    return [min(WIDEST, max(CLOSEST, 0.45 * min(pair))) for pair in sides]


def pairs(marks: Sequence[Mark], hits: Sequence[tuple]) -> Iterator[tuple[int, int, float]]:
    """(i, j, late) of impacts that are the same one, in order."""
    room = windows(marks)
    i = j = 0
    while i < len(marks) and j < len(hits):
        late = marks[i].late(*hits[j][:2])
        ratio = hits[j][2] / marks[i].u if room[i] <= CLOSEST and marks[i].u else 1.0
        if late > room[i] or (abs(late) <= room[i] and ratio < 1.0 / SAME_SPEED):
            i += 1
        elif late < -room[i] or ratio > SAME_SPEED:
            j += 1
        else:
            yield i, j, late
            i, j = i + 1, j + 1


def compare(case: Case, trace: Trace, tolerance: float = 0.0) -> Agreement:
    """Errors of a run, and how they stand to the bound at a chatter tolerance (turns)."""
    found = list(pairs(case.hits, trace.hits))
    errors = [(abs(late), case.hits[i].bound) for i, _, late in found]
    closed = _closed(case, trace)
    errors += [(late, tolerance + mark.bound) for mark, late, _ in closed]
    state = _state_error(case, trace)
    if state is not None:
        errors.append((state, case.final_bound))
    error, bound = max(errors, default=(nan, nan))
    return Agreement(
        error=error,
        missed=_missed(case, trace, {i for i, _, _ in found}, closed),
        extra=_extra(case, trace, {j for _, j, _ in found}),
        excess=max((e / b for e, b in errors), default=nan),
        bound=bound,
    )


def _closed(case: Case, trace: Trace) -> list[tuple[Mark, float, float]]:
    """(accumulation, error, last impact followed before it) of every chatter closed, in turns."""
    found = []
    for mark in case.rests:
        near = min(trace.rests, key=lambda rest: abs(mark.late(*rest)), default=None)
        if near is None or abs(mark.late(*near)) >= WIDEST:
            continue
        before = [hit for hit in trace.hits if mark.late(*hit[:2]) <= mark.late(*near)]
        last = mark.at + mark.late(*before[-1][:2]) if before else 0.0
        found.append((mark, abs(mark.late(*near)), last))
    return found


def _missed(case: Case, trace: Trace, seen: set[int], closed) -> int:
    """Impacts not found, but for those that a chatter map has replaced."""

    def replaced(mark: Mark) -> bool:
        return mark.optional or any(last < mark.at <= end.at for end, _, last in closed)

    last = max(seen, default=-1) if trace.given_up else len(case.hits) - 1
    lost = [m for i, m in enumerate(case.hits[: last + 1]) if i not in seen]
    return sum(not replaced(mark) for mark in lost)


def _extra(case: Case, trace: Trace, seen: set[int]) -> int:
    """Impacts found that are not in the reference, those next to an accumulation apart."""
    marks = [m for m in case.hits if m.optional] + case.rests

    def near(hit) -> bool:
        return any(abs(m.late(*hit[:2])) < OPTIONAL for m in marks)

    others = [hit for j, hit in enumerate(trace.hits) if j not in seen]
    return len(others) if len(others) > MANY else sum(not near(hit) for hit in others)


def _state_error(case: Case, trace: Trace) -> float | None:
    """Error of the state at the end: of q over the cam's top, of v over omega times it."""
    if trace.final is None:
        return None
    q, v = (float(case.data["final"][key]) for key in ("q", "v"))
    top = abs(case.lift.top)
    return max(abs(trace.final[0] - q) / top, abs(trace.final[1] - v) / (case.omega * top))
