"""Boxes proved to cover others, in ball arithmetic: see `section` for what that means.

All flights from a box are shown to be clear of the cam until they land between two phases. The box
is divided into cells: with the slopes D of the map on a cell, a point of it lands at the image of
its middle + D times its distance from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

from flint import arb, arb_mat

from camcli.analysis.chaos.section import Chaos, SectionBox, growth_of
from camcli.analysis.orbits.attraction import flight_map
from camcli.analysis.orbits.certificate import divided_flight
from camcli.cams.balls import UndecidedError
from camcli.cams.compile import Shape
from camcli.cams.decimals import exact
from camcli.exact.machine import BallMachine
from camcli.exact.shooting import BallFlight, NotProvedError, Place, ProofStep, Shooting
from camcli.system import Follower

BITS = 128  # of the balls
TRIED = ((1, 1), (2, 1), (4, 2), (8, 4), (16, 8), (32, 16))  # cells along x and y
SLACK = 1e-3  # by which the inequalities hold more clearly than they must
LANDING_STEPS = 8
LANDING_ROOM = 1.2  # times how far the landings of a cell go from that of its middle, or more
DIGITS = 9  # after the point, of the phases between which they lie


class Cell(NamedTuple):
    """A part of a box, and where its flights land.

    edges: x of the ends of the box, from the cell's middle, where it has one; image: (theta, v) of
    where the middle lands; slopes: of the map on the cell, by (x, y); distances: of (x, y) from the
    middle; flight: its entry of a certificate.
    """

    edges: list[arb]
    image: tuple[arb, arb]
    slopes: arb_mat
    distances: tuple[arb, arb]
    flight: dict[str, Any]


@dataclass(frozen=True)
class BoxFlights:
    """The flights from a box, of every machine whose speed lies in the ball rpm."""

    shape: Shape
    follower: Follower
    rpm: arb
    box: SectionBox

    @cached_property
    def shooting(self) -> Shooting:
        """The equations of one flight, from the box to where it lands."""
        lands = self.box.lands
        places = (Place(self.box.stretch, 0), Place(lands.stretch, lands.turn))
        return Shooting(self.shape, self.follower, self.rpm, "rpm", places, lands.turn + 1)

    @cached_property
    def machine(self) -> BallMachine:
        """The machines."""
        return self.shooting.machine(self.rpm)

    @cached_property
    def axes(self) -> arb_mat:
        """M of the box."""
        return _axes(self.box)

    def _flight(self, start: Sequence[arb], end: arb) -> BallFlight:
        """The flight from (theta, v) to a phase (rad)."""
        return self.shooting.flight(self.machine, [*start, end, arb(1)], 0)

    def cells(self, across: int, along: int) -> list[Cell]:
        """The cells of the box, so many in x and in y; raises NotProvedError."""
        grid = ((i, j) for i in range(across) for j in range(along))
        return [self._cell(i, j, across, along) for i, j in grid]

    def _cell(self, i: int, j: int, across: int, along: int) -> Cell:
        """Cell i in x and j in y, with its flights shown to be clear of the cam until they land."""
        distances = arb(0, 1 / arb(across)), arb(0, 1 / arb(along))
        spread = self.axes * arb_mat([[x] for x in distances])
        at = self.axes * arb_mat([[arb(2 * i + 1) / across - 1], [arb(2 * j + 1) / along - 1]])
        middle = [arb(self.box.middle[k]) + at[k, 0] for k in (0, 1)]
        wide = [middle[k] + spread[k, 0] for k in (0, 1)]
        lands = arb((self.box.lands.low + self.box.lands.high) / 2)
        for _ in range(LANDING_STEPS):
            one = self._flight(middle, lands)
            lands = (lands - one.gap / one.rate).mid()
        reach = (flight_map(self._flight(wide, lands)) * spread)[0, 0] * LANDING_ROOM
        low, high = (
            round(float((lands + side * reach.abs_upper()).mid()) + side * 0.1**DIGITS, DIGITS)
            for side in (-1, 1)
        )
        there = arb(low).union(arb(high))
        for place, phase in zip(self.shooting.places, (wide[0], there), strict=True):
            stretch = self.shooting.stretches[place.stretch]
            if not (stretch.start < phase and phase < stretch.end):
                raise NotProvedError(ProofStep.ELSEWHERE)
        if not wide[1] > 0:
            raise NotProvedError(ProofStep.PULLS)
        for end, side in ((low, 1), (high, -1)):
            by = self._flight(wide, arb(end)).by_start
            gap = self._flight(middle, arb(end)).gap
            room = gap + by.gap_by_theta * spread[0, 0] + by.gap_by_v * spread[1, 0]
            if not side * room > 0:
                raise NotProvedError(ProofStep.CONTACT)
        try:
            divided = divided_flight(self.shooting, [*wide, there, arb(1), self.rpm], 0)
        except UndecidedError:
            raise NotProvedError(ProofStep.GRAZES) from None
        lands = lands - self._flight(middle, lands).gap / self._flight(middle, there).rate
        by_start = (flight_map(self._flight(wide, there)) * spread)[0, 0]
        slopes = flight_map(self._flight(wide, lands + by_start)) * self.axes
        landed = self._flight(middle, lands)
        ends = [end for end, here in ((-1, i == 0), (1, i == across - 1)) if here]
        edges = [arb(end) / across for end in ends]
        image = (lands, -landed.r * landed.rate)
        flight = {"low": exact(low), "high": exact(high), **divided}
        return Cell(edges, image, slopes, distances, flight)


def covers(cells: Sequence[Cell], others: Sequence[SectionBox]) -> bool:
    """Whether the box of these cells is shown to cover others."""
    sides: list[set[bool]] = [set() for _ in others]
    for cell in cells:
        for other, seen in zip(others, sides, strict=True):
            inverse = _axes(other).inv()
            place = inverse * arb_mat([[cell.image[k] - other.middle[k]] for k in (0, 1)])
            turned = inverse * cell.slopes
            y = place[1, 0] + (turned * arb_mat([[d] for d in cell.distances]))[1, 0]
            if not abs(y) < 1 - SLACK:
                return False
            for edge in cell.edges:
                x = place[0, 0] + turned[0, 0] * edge + turned[0, 1] * cell.distances[1]
                if not abs(x) > 1 + SLACK:
                    return False
                seen.add((x > 0) == (edge > 0))
    return all(len(seen) == 1 for seen in sides)


def _axes(box: SectionBox) -> arb_mat:
    """M of a box in balls."""
    return arb_mat([[arb(x) for x in row] for row in box.axes])


def proved(chaos: Chaos, shape: Shape, follower: Follower, rpm: arb) -> Chaos:
    """The same with its proof: the flights and cells of its boxes, or the step that failed.

    rpm: every speed that it is about. The precision in use should be BITS or more.
    """
    boxes = []
    flights = []
    try:
        for one, other in combinations(chaos.boxes, 2):
            if one.stretch == other.stretch and not (_beside(one, other) or _beside(other, one)):
                raise NotProvedError(ProofStep.COVERING)
        for k, box in enumerate(chaos.boxes):
            over = [chaos.boxes[j] for i, j in chaos.coverings if i == k]
            divided, cells = _divided(BoxFlights(shape, follower, rpm, box), over)
            boxes.append(replace(box, cells=divided))
            flights.append(tuple(cell.flight for cell in cells))
    except NotProvedError as failed:
        return replace(chaos, step=failed.step)
    growth, weights = growth_of(len(boxes), chaos.coverings)
    step = None if growth > 1.0 else ProofStep.COVERING
    return replace(chaos, boxes=tuple(boxes), flights=tuple(flights), growth=growth,
                   weights=weights, step=step)  # fmt: skip


def _divided(box: BoxFlights, others: Sequence[SectionBox]) -> tuple[tuple[int, int], list[Cell]]:
    """(cells across and along, these) on which a box is shown to cover others: as few as tried."""
    failed = NotProvedError(ProofStep.COVERING)
    for across, along in TRIED:
        try:
            cells = box.cells(across, along)
        except NotProvedError as error:
            failed = error
            continue
        if covers(cells, others):
            return (across, along), cells
        failed = NotProvedError(ProofStep.COVERING)
    raise failed


def _beside(one: SectionBox, other: SectionBox) -> bool:
    """Whether a box lies on one side of another one, along one of its axes."""
    inverse = _axes(one).inv()
    place = inverse * arb_mat([[arb(other.middle[k]) - one.middle[k]] for k in (0, 1)])
    reach = inverse * _axes(other)
    return any(abs(place[k, 0]) > 1 + SLACK + abs(reach[k, 0]) + abs(reach[k, 1]) for k in (0, 1))
