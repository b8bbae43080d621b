"""Whether the rows of a table go round the turn, and how those of less are completed."""

from decimal import Decimal
from types import SimpleNamespace

import pytest

from camcli.cams.lift_reading import Cell, _cover, _lift_words, _mirrored, _Rows, _unroll
from camcli.errors import SceneError

CAM = SimpleNamespace(subtract=0.0, metres=1e-3)


def rows_of(angles, lifts) -> _Rows:
    """The cells of a table, of which a line has an angle and a lift."""
    columns = [
        [Cell(f"t:{n}", n, str(x), Decimal(str(x))) for n, x in enumerate(numbers, 1)]
        for numbers in (angles, lifts)
    ]
    return _Rows("t", *columns)


def cover(last: str, steps=(0, 40, 90, 7), noise=0.0):
    """Of four rows that begin at 20 deg, ten degrees apart as far as they say, and end at last."""
    angles = [Decimal(x) for x in ("20", "130", "260", last)]
    lifts = [1e-3 * step for step in steps]
    return _cover(rows_of(angles, steps), angles, Decimal(10), list(steps), lifts, noise, CAM)


@pytest.mark.parametrize(
    ("last", "told"),
    [("382.5", (3, True)), ("380", (3, True)), ("377.6", (3, True)), ("377.5", (4, True)),
     ("365", (4, True))],
)  # fmt: skip
def test_rows_within_one_and_a_half_spacings_go_round_the_turn(last, told):
    """The last row is the first once more where less than a quarter of a spacing is missing."""
    assert cover(last) == told


def test_rows_of_too_much_or_with_another_lift_after_a_turn_are_refused():
    """A lift after a turn may be off by two digits and a quarter of the step of 40 beside it."""
    with pytest.raises(SceneError, match=r"covers 362\.6 deg of cam, 2\.6 too much"):
        cover("382.6")
    assert cover("380", (0, 40, 91, 12)) == (3, True)
    assert cover("380", (12, 52, 91, 0)) == (3, True)
    for steps in ((0, 40, 91, 13), (13, 53, 91, 0)):
        with pytest.raises(SceneError, match="one turn after the first"):
            cover("380", steps)


def test_rows_of_the_lobe_alone_begin_and_end_on_the_base_circle():
    assert cover("364.9", (3, 40, 91, -3), 3.0) == (4, False)
    with pytest.raises(SceneError, match=r"begins at 20 deg with a lift of 4000 mm.*\(15\.1 deg"):
        cover("364.9", (4000, 40, 91, 3), 3.0)
    with pytest.raises(SceneError, match=r"ends at 364\.9 deg with a lift of 4 mm"):
        cover("364.9", (3, 40, 91, 4), 3.0)
    with pytest.raises(SceneError, match=r"begins at 20 deg with a lift of -4 mm"):
        cover("364.9", (-4, 40, 91, 3), 3.0)


def test_a_lift_is_told_as_measured_and_less_what_is_subtracted():
    assert _lift_words(0.0025, CAM) == "2.5 mm"
    inches = SimpleNamespace(subtract=0.5, metres=0.0254)
    assert _lift_words(0.0025, inches) == "15.2 mm (2.5 mm after subtract: 0.5)"


@pytest.mark.parametrize(
    ("angles", "wanted"),
    [
        ([350, 355, 5, 9], [350, 355, 365, 369]),
        ([0, 90, 200, 350], [0, 90, 200, 350]),
        ([170, 350, 170, 340], [170, 350, 170, 340]),  # half a turn back is no way through zero
        ([170, 351, 170, 340], [170, 351, 530, 700]),
        ([300, 10, 300, 10], [300, 370, 660, 370]),  # once only
    ],
)
def test_angles_go_through_zero_once(angles, wanted):
    rows = rows_of(angles, [1, 2, 3, 4])
    _unroll(rows, Decimal(360))
    assert [int(cell.value) for cell in rows.angle] == wanted


@pytest.mark.parametrize(
    ("lifts", "angles", "mirrored"),
    [
        ([0, 1, 3, 7], [10, 20, 35, 60, 85, 100, 110], [0, 1, 3, 7, 3, 1, 0]),
        ([7, 3, 1, 0], [-40, -15, 0, 10, 20, 35, 60], [0, 1, 3, 7, 3, 1, 0]),
    ],
)
def test_one_flank_is_mirrored_at_its_nose(lifts, angles, mirrored):
    """Rows at 10, 20, 35 and 60 deg."""
    whole = _mirrored(rows_of([10, 20, 35, 60], lifts))
    assert [int(cell.value) for cell in whole.angle] == angles
    assert [int(cell.value) for cell in whole.lift] == mirrored
    for inside, words in (([0, 7, 3, 1], "inside"), ([7, 1, 0, 7], "at both ends of")):
        with pytest.raises(SceneError, match=f"{words} the table"):
            _mirrored(rows_of([10, 20, 35, 60], inside))
