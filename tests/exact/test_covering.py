"""The prover of boxes that cover one another, on a ball over a level plate.

With G = 1 an impact (theta, v) is followed by (theta + 2 v, r v), so that landings, slopes and
coverings are known beforehand; and each of its refusals has a box that must be refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import pytest
from flint import arb, arb_mat

from camcli.analysis.chaos.covering import BITS, BoxFlights, CellOfBox, covers, proved
from camcli.analysis.chaos.section import Chaos, Lands, SectionBox
from camcli.cams.balls import precision
from camcli.cams.compile import Part
from camcli.exact.shooting import NotProvedError, ProofStep
from camcli.system import Follower

RPM, R = 30.0, 0.5  # omega = pi
BALL = Follower(mass=1.0, stiffness=0.0, gravity=pi * pi, restitution=R)
SLACK = 1e-3


@dataclass(frozen=True)
class Plate:
    """Level, in two stretches that meet at 6 rad."""

    cut: float = 6.0

    def parts(self) -> list[Part]:
        def level(theta):
            return theta * 0 + 1

        return [Part(arb(0), arb(self.cut), level), Part(arb(self.cut), 2 * arb.pi(), level)]


def box(middle, axes, low=0.0, high=0.0) -> SectionBox:
    """A box whose flights land near theta + 2 v, on the first stretch."""
    lands = middle[0] + 2.0 * middle[1]
    return SectionBox(0, middle, axes, Lands(0, 0, low or lands - 0.1, high or lands + 0.1))


def flights(one: SectionBox) -> BoxFlights:
    return BoxFlights(Plate(), BALL, arb(RPM), one)


FIRST = box((1.0, 1.0), ((0.0, 0.01), (0.1, 0.0)))  # x is v - 1 in tenths
SECOND = box((3.0, 0.5), ((0.1, 0.0), (0.025, 0.02)))  # along its images, half as long


@pytest.fixture(autouse=True)
def digits():
    with precision(40):
        yield


def entries(matrix: arb_mat) -> list[float]:
    return [float(x) for x in matrix.entries()]


@pytest.mark.parametrize(("across", "along"), [(1, 1), (8, 1), (3, 2)])
def test_the_cells_of_a_box_are_mapped_as_newton_says(across, along):
    cells = flights(FIRST).cells(across, along)
    assert len(cells) == across * along
    for number, cell in enumerate(cells):
        i, j = divmod(number, along)
        x, y = (2 * i + 1) / across - 1, (2 * j + 1) / along - 1
        theta, v = 1.0 + 0.01 * y, 1.0 + 0.1 * x
        assert [float(one) for one in cell.image] == pytest.approx([theta + 2 * v, R * v])
        # by x: 0.1 of v, and so 0.2 and 0.05; by y: 0.01 of theta
        if across == 8:
            middles = entries(cell.slopes.mid())
            assert middles == pytest.approx([0.2, 0.01, 0.05, 0.0], rel=0.02, abs=2e-3)
        assert all(slope.contains(value) for slope, value in
                   zip(cell.slopes.entries(), (0.2, 0.01, 0.05, 0.0), strict=True))  # fmt: skip
        assert [float(one.rad()) for one in cell.reach] == pytest.approx([1 / across, 1 / along])
        ends = [-1 / across] * (i == 0) + [1 / across] * (i == across - 1)
        assert [float(one) for one in cell.ends] == pytest.approx(ends)
        low, high = float(cell.flight["low"]), float(cell.flight["high"])
        farthest = 0.2 / across + 0.01 / along
        assert low < theta + 2 * v - farthest
        assert high > theta + 2 * v + farthest
        assert high - low < 2 * 1.5 * farthest + 2e-2


def test_a_box_covers_another_and_not_itself():
    cells = flights(FIRST).cells(8, 1)
    assert covers(cells, [SECOND])
    assert covers(cells, [])
    assert not covers(cells, [FIRST])
    assert not covers(cells, [SECOND, FIRST])
    assert not covers(cells, [replace(SECOND, axes=((0.25, 0.0), (0.0625, 0.02)))])  # too long
    assert not covers(cells, [replace(SECOND, axes=((0.1, 0.0), (0.025, 0.002)))])  # too narrow
    assert not covers(cells, [replace(SECOND, middle=(3.4, 0.6))])  # one side of it alone


UNIT = SectionBox(0, (0.0, 0.0), ((1.0, 0.0), (0.0, 1.0)), Lands(0, 0, 0.0, 0.0))


def cell(x: float, y: float, edges, slopes=(0.0, 0.0, 0.0, 0.0)) -> CellOfBox:
    """A cell that lands at (x, y), of which all is mapped there but for its slopes."""
    a, b, c, d = map(arb, slopes)
    matrix = arb_mat([[a, b], [c, d]])
    return CellOfBox([arb(x) for x in edges], (arb(x), arb(y)), matrix, (arb(0, 1), arb(0, 1)), {})


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("x", "y", "slopes", "holds"),
    [
        (1.0011, 0.0, (0.0, 0.0, 0.0, 0.0), True),  # a thousandth more than the end
        (1.0009, 0.0, (0.0, 0.0, 0.0, 0.0), False),
        (2.0, 0.9989, (0.0, 0.0, 0.0, 0.0), True),
        (2.0, 0.9991, (0.0, 0.0, 0.0, 0.0), False),
        (2.0, -0.9991, (0.0, 0.0, 0.0, 0.0), False),
        (2.0, 0.0, (0.0, 0.9, 0.0, 0.0), True),  # spread along x
        (2.0, 0.0, (0.0, 1.1, 0.0, 0.0), False),
        (2.0, 0.0, (0.0, 0.0, 0.5, 0.4), True),  # spread along y, by x and by y
        (2.0, 0.0, (0.0, 0.0, 0.5, 0.6), False),
        (0.0, 0.0, (2.0, 0.0, 0.0, 0.0), True),  # both ends of one cell
        (0.0, 0.0, (-2.0, 0.0, 0.0, 0.0), True),
        (0.0, 0.0, (0.9, 0.0, 0.0, 0.0), False),
    ],
)
def test_how_clearly_a_box_covers(sign, x, y, slopes, holds):
    if slopes[0] != 0.0:
        made = [cell(x, y, (-1, 1), slopes)]
    else:  # a cell at either end, on the two sides
        made = [cell(sign * x, y, (1,), slopes), cell(-sign * x, y, (-1,), slopes)]
    assert covers(made, [UNIT]) == holds


def test_both_ends_on_one_side_are_no_covering():
    assert not covers([cell(2.0, 0.0, (1,)), cell(2.0, 0.0, (-1,))], [UNIT])
    assert not covers(
        [cell(2.0, 0.0, (1,)), cell(1.5, 0.0, ())], [replace(UNIT, middle=(2.0, 3.0))]
    )


REFUSED = [
    (box((1.0, -0.01), ((0.0, 1e-5), (1e-4, 0.0)), 0.9, 1.0), ProofStep.PULLS),
    (box((0.005, 1.0), ((0.0, 0.01), (0.1, 0.0))), ProofStep.ELSEWHERE),  # begins before zero
    (box((3.9, 1.0), ((0.0, 0.01), (0.1, 0.0))), ProofStep.ELSEWHERE),  # lands beyond the cut
    (box((3.0, 0.05), ((0.0, 1e-5), (0.025, 0.0))), ProofStep.CONTACT),  # its landings reach back
]


@pytest.mark.parametrize(("one", "step"), REFUSED)
def test_a_box_must_be_refused(one, step):
    with pytest.raises(NotProvedError) as refused:
        flights(one).cells(1, 1)
    assert refused.value.step == step


def of_boxes(*boxes: SectionBox, coverings) -> Chaos:
    """A claim that boxes cover one another, proved or not."""
    claim = Chaos(RPM, boxes=boxes, coverings=coverings)
    return proved(claim, Plate(), BALL, arb(RPM))


def test_boxes_that_overlap_are_not_proved():
    assert BITS == 128
    beside = replace(FIRST, middle=(1.03, 1.0))  # 0.01 to either side of both
    assert of_boxes(FIRST, beside, coverings=()).step == ProofStep.COVERING  # nothing grows
    near = replace(FIRST, middle=(1.015, 1.0))
    assert of_boxes(FIRST, near, coverings=()).flights == ()
    assert of_boxes(FIRST, beside, coverings=()).flights != ()


def test_a_covering_that_is_none_fails_after_all_divisions():
    found = of_boxes(FIRST, SECOND, coverings=((1, 0),))
    assert (found.step, found.flights) == (ProofStep.COVERING, ())
    found = of_boxes(FIRST, SECOND, coverings=((0, 1),))
    assert [one.cells for one in found.boxes] == [(4, 2), (2, 1)]
    assert [len(one) for one in found.flights] == [8, 2]
    assert found.step == ProofStep.COVERING  # it is proved, but does not grow
