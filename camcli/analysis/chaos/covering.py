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


class CellOfBox(NamedTuple):
    """A part of a box, and where its flights land.

    ends: x of the ends of the box (-1, 1) that the cell touches, counted from the cell's middle and
    so with the sign of the end; image: (theta, v) of where the middle lands; slopes: of the map on
    the cell, by (x, y); reach: balls of what x and y may differ from the middle; flight: its entry
    of a certificate.
    """

    ends: list[arb]
    image: tuple[arb, arb]
    slopes: arb_mat
    reach: tuple[arb, arb]
    flight: dict[str, Any]


class _Impacts(NamedTuple):
    """The impacts (theta, v) of a cell: of its middle, and balls of those of all of it.

    spread: column of balls of what theta and v may differ from the middle.
    """

    middle: tuple[arb, arb]
    wide: tuple[arb, arb]
    spread: arb_mat


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
        rate_after = arb(1)  # of the impact there; the flight does not depend on it
        return self.shooting.flight(self.machine, [*start, end, rate_after], 0)

    def cells(self, columns: int, rows: int) -> list[CellOfBox]:
        """The cells of the box, so many in x and in y; raises NotProvedError."""
        grid = ((i, j) for i in range(columns) for j in range(rows))
        return [self._cell(i, j, columns, rows) for i, j in grid]

    def _cell(self, column: int, row: int, columns: int, rows: int) -> CellOfBox:
        """A cell of the grid, with its flights shown to be clear of the cam until they land.

        column, row: its number in x and in y. Raises NotProvedError.
        """
        reach = arb(0, 1 / arb(columns)), arb(0, 1 / arb(rows))
        spread = self.axes * arb_mat([[x] for x in reach])
        x = arb(2 * column + 1) / columns - 1
        y = arb(2 * row + 1) / rows - 1
        off = self.axes * arb_mat([[x], [y]])
        middle = (arb(self.box.middle[0]) + off[0, 0], arb(self.box.middle[1]) + off[1, 0])
        wide = (middle[0] + spread[0, 0], middle[1] + spread[1, 0])
        impacts = _Impacts(middle, wide, spread)
        near_landing = self._landing_of(middle)
        low, high = self._landings(impacts, near_landing)
        landings = arb(low).union(arb(high))
        self._show_landings(impacts, low, high)
        try:
            divided = divided_flight(self.shooting, [*wide, landings, arb(1), self.rpm], 0)
        except UndecidedError:
            raise NotProvedError(ProofStep.GRAZES) from None
        # an interval Newton step encloses the landing of the middle
        gap = self._flight(middle, near_landing).gap
        landing = near_landing - gap / self._flight(middle, landings).rate
        # the slopes twice: first over all landings, then over those that follow from them
        rough_spread = (flight_map(self._flight(wide, landings)) * spread)[0, 0]
        slopes = flight_map(self._flight(wide, landing + rough_spread)) * self.axes
        landed = self._flight(middle, landing)
        ends = []
        if column == 0:
            ends.append(arb(-1) / columns)
        if column == columns - 1:
            ends.append(arb(1) / columns)
        flight = {"low": exact(low), "high": exact(high), **divided}
        return CellOfBox(ends, (landing, -landed.r * landed.rate), slopes, reach, flight)

    def _landing_of(self, start: Sequence[arb]) -> arb:
        """A phase near the landing of the flight from (theta, v), by Newton's method."""
        phase = arb((self.box.lands.low + self.box.lands.high) / 2)
        for _ in range(LANDING_STEPS):
            flight = self._flight(start, phase)
            phase = (phase - flight.gap / flight.rate).mid()
        return phase

    def _landings(self, impacts: _Impacts, near_landing: arb) -> tuple[float, float]:
        """Two phases between which the flights of a cell are expected to land, with few digits."""
        slopes = flight_map(self._flight(impacts.wide, near_landing))
        reach = ((slopes * impacts.spread)[0, 0] * LANDING_ROOM).abs_upper()
        last_digit = 0.1**DIGITS
        low = round(float((near_landing - reach).mid()) - last_digit, DIGITS)
        high = round(float((near_landing + reach).mid()) + last_digit, DIGITS)
        return low, high

    def _show_landings(self, impacts: _Impacts, low: float, high: float) -> None:
        """Show that all flights of a cell bounce, and land between two phases of the stretch.

        The gap at these is that of the flight from the middle, off by its slopes by theta and v
        times the spread of these. Raises NotProvedError.
        """
        landings = arb(low).union(arb(high))
        theta, v = impacts.wide
        for place, phase in zip(self.shooting.places, (theta, landings), strict=True):
            stretch = self.shooting.stretches[place.stretch]
            if not (stretch.start < phase and phase < stretch.end):
                raise NotProvedError(ProofStep.ELSEWHERE)
        if not v > 0:
            raise NotProvedError(ProofStep.PULLS)
        for end, sign_of_gap in ((arb(low), 1), (arb(high), -1)):
            slopes = self._flight(impacts.wide, end).by_start
            gap = self._flight(impacts.middle, end).gap
            by_theta = slopes.gap_by_theta * impacts.spread[0, 0]
            by_v = slopes.gap_by_v * impacts.spread[1, 0]
            if not sign_of_gap * (gap + by_theta + by_v) > 0:
                raise NotProvedError(ProofStep.CONTACT)


def covers(cells: Sequence[CellOfBox], others: Sequence[SectionBox]) -> bool:
    """Whether the box of these cells is shown to cover others.

    On each of these its image has |y| < 1, and its ends, x = -1 and x = 1, are mapped to the sides
    x < -1 and x > 1: each on the side of its own sign, or each on the other one.
    """
    for other in others:
        inverse = _axes(other).inv()
        same_sides: set[bool] = set()  # whether an end is mapped to the side of its own sign
        for cell in cells:
            theta, v = cell.image
            image = inverse * arb_mat([[theta - other.middle[0]], [v - other.middle[1]]])
            slopes = inverse * cell.slopes
            y = image[1, 0] + (slopes * arb_mat([[d] for d in cell.reach]))[1, 0]
            if not abs(y) < 1 - SLACK:
                return False
            for end in cell.ends:
                x = image[0, 0] + slopes[0, 0] * end + slopes[0, 1] * cell.reach[1]
                if not abs(x) > 1 + SLACK:
                    return False
                same_sides.add((x > 0) == (end > 0))
        if len(same_sides) != 1:
            return False
    return True


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
        for box, other in combinations(chaos.boxes, 2):
            apart = _beside(box, other) or _beside(other, box)
            if box.stretch == other.stretch and not apart:
                raise NotProvedError(ProofStep.COVERING)
        for k, box in enumerate(chaos.boxes):
            covered = [chaos.boxes[j] for i, j in chaos.coverings if i == k]
            divided = _divided(BoxFlights(shape, follower, rpm, box), covered)
            boxes.append(replace(box, cells=(divided.columns, divided.rows)))
            flights.append(tuple(cell.flight for cell in divided.cells))
    except NotProvedError as failed:
        return replace(chaos, step=failed.step)
    growth, weights = growth_of(len(boxes), chaos.coverings)
    return replace(
        chaos,
        boxes=tuple(boxes),
        flights=tuple(flights),
        growth=growth,
        weights=weights,
        step=None if growth > 1.0 else ProofStep.COVERING,
    )


class DividedBox(NamedTuple):
    """The cells of a box, so many columns along x and rows along y."""

    columns: int
    rows: int
    cells: list[CellOfBox]


def _divided(box: BoxFlights, others: Sequence[SectionBox]) -> DividedBox:
    """The cells on which a box is shown to cover others: as few as tried; raises NotProvedError."""
    failed = NotProvedError(ProofStep.COVERING)
    for columns, rows in TRIED:
        try:
            cells = box.cells(columns, rows)
        except NotProvedError as error:
            failed = error
            continue
        if covers(cells, others):
            return DividedBox(columns, rows, cells)
        failed = NotProvedError(ProofStep.COVERING)
    raise failed


def _beside(box: SectionBox, other: SectionBox) -> bool:
    """Whether another box lies on one side of this one, along one of its axes.

    In units of this box, |x|, |y| <= 1, the other one is a parallelogram about its middle.
    """
    inverse = _axes(box).inv()
    middle = inverse * arb_mat([[arb(other.middle[k]) - box.middle[k]] for k in (0, 1)])
    axes = inverse * _axes(other)
    for k in (0, 1):
        reach = abs(axes[k, 0]) + abs(axes[k, 1])
        if abs(middle[k, 0]) > 1 + SLACK + reach:
            return True
    return False
