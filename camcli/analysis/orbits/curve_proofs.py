"""Curves of bifurcations proved as wholes: boxes that overlap, from point to point.

The unknowns z of a point on a curve are those of its orbit, both numbers that vary, and at a graze
the angle of flight to it; the equations are those of `codim2.Meeting` with the curve's own
condition alone, one fewer than unknowns. Between two neighbours on the curve one of the numbers is
given. In each box there is for each of its values exactly one zero (`exact.shooting.box_of`), whose
orbit is a motion but for the condition. Neighbouring boxes share a zero, so that all of them hold
one and the same curve, which has no gap, and on which the given number takes every value between
the two points. As the equations are regular in the box, the condition's function crosses zero along
the branch of orbits wherever the other number alone varies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from flint import arb, arb_mat, ctx

from camcli.analysis.integrate import BudgetSpentError, spend
from camcli.analysis.orbits.codim2 import Condition, Meeting, condition_at
from camcli.analysis.orbits.curves import Curve, CurvePoint, Plane
from camcli.analysis.orbits.proofs import BOXED, OVERLAP
from camcli.analysis.orbits.shooter import Root
from camcli.cams.balls import UndecidedError, precision
from camcli.exact.shooting import (
    FILLED,
    Box,
    NotProvedError,
    Place,
    ProofStep,
    Shooting,
    box_of,
)
from camcli.system import System

DIGITS = 40  # decimal digits of the balls
MOST = 64  # boxes between two neighbours on a curve
UNSOLVED = (UndecidedError, ZeroDivisionError, ValueError)


@dataclass(frozen=True)
class CurveEvidence:
    """What a certificate needs of a part of a curve that is proved, in so many bits.

    on: its equations; joints: boxes of single orbits: one before the first box, one that each box
    shares with the next, one behind the last.
    """

    bits: int
    on: OnCurve
    boxes: tuple[Box, ...]
    joints: tuple[Box, ...]

    def then(self, after: CurveEvidence) -> CurveEvidence | None:
        """This part and the one after it, which begins with the joint that this one ends with.

        None where a graze has passed to another stretch of the cam: that is another equation.
        """
        if self.on.touched != after.on.touched:
            return None
        return replace(self, boxes=self.boxes + after.boxes, joints=self.joints + after.joints[1:])


@dataclass(frozen=True)
class CurveRange:
    """A part of a curve between two of its points, proved without a gap or not.

    curve: its number; first, last: numbers of the two points on it, from 1; places: both numbers
    that vary, there; boxes: how many it took; failed_step: None where it is proved; evidence: what
    a certificate says of it.
    """

    curve: int
    first: int
    last: int
    places: tuple[tuple[float, float], tuple[float, float]]
    boxes: int = 0
    failed_step: ProofStep | None = None
    evidence: CurveEvidence | None = field(default=None, compare=False, repr=False)

    def joined(self, after: CurveRange) -> CurveRange:
        """This part and the one behind it as one; both are proved, or fail at the same step."""
        evidence = None
        if self.evidence is not None and after.evidence is not None:
            evidence = self.evidence.then(after.evidence)
        return replace(
            self,
            last=after.last,
            places=(self.places[0], after.places[1]),
            boxes=self.boxes + after.boxes,
            evidence=evidence,
        )


def prove_curve(system: System, curve: Curve, number: int, plane: Plane) -> list[CurveRange]:
    """The curve in as few ranges as possible, each proved from end to end, or not at all.

    Neighbouring parts that fail at one step are told as one. number: of the curve.
    """
    ranges: list[CurveRange] = []
    joint: Box | None = None  # of the last point, where the part before it is proved
    fewest = 1  # boxes that are tried first: half as many as were needed before
    for k, (here, there) in enumerate(pairwise(curve.points), 1):
        places = (here.first, here.second), (there.first, there.second)
        part = CurveRange(number, k, k + 1, places)
        try:
            with precision(DIGITS):
                evidence = _part(system, curve, plane, (here, there), joint, fewest)
        except NotProvedError as failed:
            joint = None
            part = replace(part, failed_step=failed.step)
        except BudgetSpentError:
            joint = None
            part = replace(part, failed_step=ProofStep.WORK_BUDGET)
        else:
            joint = evidence.joints[-1]
            part = replace(part, boxes=len(evidence.boxes), evidence=evidence)
            fewest = max(1, part.boxes // 2)
        if ranges and ranges[-1].failed_step == part.failed_step:
            ranges[-1] = ranges[-1].joined(part)
        else:
            ranges.append(part)
    return ranges


def _part(
    system: System, curve: Curve, plane: Plane, points: tuple[CurvePoint, CurvePoint],
    joint: Box | None, fewest: int,
) -> CurveEvidence:  # fmt: skip
    """The boxes of the curve between two neighbours.

    The number that changes more between them, in shares of its range, is given in all boxes.
    joint: the box of the first point, None where it has none yet; fewest: boxes that are tried
    first, then twice as many, up to MOST. Raises NotProvedError.
    """
    first_point, last_point = points
    first = first_point.orbit.root
    last = last_point.orbit.root
    if first is None or last is None or curve.located is None:
        raise NotProvedError(ProofStep.MODEL)
    if first.whole != last.whole:
        raise NotProvedError(ProofStep.PASSES)
    try:
        on = OnCurve(system, curve, plane, first)
        start = on.unknowns(system, curve, plane, first, (first_point.first, first_point.second))
        end = on.unknowns(system, curve, plane, last, (last_point.first, last_point.second))
    except UNSOLVED:
        raise NotProvedError(ProofStep.SINGULAR) from None
    changes = [
        abs(float(b - a)) / (high - low)
        for a, b, (low, high) in zip(on.values(start), on.values(end), plane.ranges, strict=True)
    ]
    given = on.place if changes[0] >= changes[1] else on.place + 1
    start_box = joint or on.box(start, given)
    end_box = on.box(end, given)
    for box in (start_box, end_box):  # where a point is no motion, more boxes do not help
        on.meeting.admit(box.hull())
    count = fewest
    while True:
        try:
            boxes, shared = on.chain(start_box, end_box, given, count)
        except NotProvedError:
            count *= 2
            if count > MOST:
                raise
        else:
            return CurveEvidence(ctx.prec, on, tuple(boxes), (start_box, *shared, end_box))


class OnCurve:
    """The equations of a curve near one of its points, in balls.

    The unknowns z: phase and rate of each impact, both numbers that vary, of which the first
    stands at `place`, and at a graze the angle of flight to it.
    """

    def __init__(self, system: System, curve: Curve, plane: Plane, root: Root):
        """Near a root on the curve; raises NotProvedError where a number is not known in balls."""
        condition = condition_at(system, curve, plane, root)
        self.meeting = Meeting(system, plane, root, [condition])
        if self.meeting.in_doubles:
            raise NotProvedError(ProofStep.CAM)
        self.place = 2 * self.meeting.n

    @property
    def condition(self) -> Condition:
        """What happens to all orbits of the curve."""
        return self.meeting.conditions[0]

    @property
    def touched(self) -> Place | None:
        """The stretch and the turn in which a flight grazes the cam, None where it is no graze."""
        return self.meeting.grazes[0].place if self.meeting.grazes else None

    def values(self, z: Sequence[arb]) -> Sequence[arb]:
        """Both numbers among the unknowns z."""
        return z[self.place : self.place + 2]

    def flown(self, hull: Sequence[arb]) -> tuple[Shooting, list[arb]]:
        """(equations, unknowns) of the orbits of a hull: both numbers are in the equations."""
        shooting = self.meeting.shooting(self.values(hull))
        return shooting, [*hull[: self.place], arb(shooting.rpm)]

    def unknowns(
        self, system: System, curve: Curve, plane: Plane, root: Root, values: tuple[float, float]
    ) -> list[arb]:
        """The unknowns at a root: its orbit, both numbers, and where it grazes."""
        z = self.meeting.start(root, values)
        if self.meeting.grazes:
            z[-1] = arb(condition_at(system, curve, plane, root).angle)
        return z

    def equations(self, z: Sequence[arb]) -> tuple[arb_mat, arb_mat]:
        """(E, E') at the unknowns z."""
        values = self.meeting.equations(z)
        return arb_mat([[value] for value in values]), self.meeting.derivatives(z)

    def box(self, guess: Sequence[arb], given: int, half: arb | int = 0) -> Box:
        """A box about the zero near a guess: one zero for each value of the given unknown.

        half: by how much that varies to either side. Raises NotProvedError.
        """
        spend(BOXED * self.meeting.n)
        filled = FILLED if self.meeting.in_balls else 1
        return box_of(self.equations, guess, given, half, filled)

    def chain(self, start: Box, stop: Box, given: int, count: int) -> tuple[list[Box], list[Box]]:
        """Lay so many boxes from one point to another: (boxes, those of the zeros between them).

        Each shares a zero with the next one, the first and the last one have those of the points.
        Raises NotProvedError where that fails.
        """
        first = start.hull()
        last = stop.hull()
        begin = first[given].mid()
        half = (last[given].mid() - begin) / (2 * count)  # of the way of one box
        boxes: list[Box] = []
        joints: list[Box] = []
        for k in range(count):
            middle = [
                a.mid() + (2 * k + 1) * (b.mid() - a.mid()) / (2 * count)
                for a, b in zip(first, last, strict=True)
            ]
            box = self.box(middle, given, abs(OVERLAP * half).upper())
            self.meeting.admit(box.hull())
            shared = first
            if boxes:
                edge = begin + 2 * k * half
                joints.append(self.box(box.orbit_at(edge - box.middle[given]), given))
                shared = joints[-1].hull()
            holds_before = boxes[-1].holds(shared) if boxes else True
            if not (box.holds(shared) and holds_before):
                raise NotProvedError(ProofStep.SINGULAR)
            boxes.append(box)
        if not boxes[-1].holds(last):
            raise NotProvedError(ProofStep.SINGULAR)
        return boxes, joints
