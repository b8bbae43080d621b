"""Which columns of a lift table are the angle and the lift, and what they are, by their titles."""

from __future__ import annotations

from math import radians, sin

import pytest

from camcli.cams import lift_guess
from camcli.cams.lift_guess import Guess
from camcli.errors import SceneError

ANGLES = [5.0 * k for k in range(73)]
HUMP = [9.0 * sin(radians(k / 2)) ** 2 for k in ANGLES]
OTHER = [4.0 * sin(radians(k / 2)) ** 4 for k in ANGLES]
FLANK = HUMP[:37]
NOSE_TO_NOSE = HUMP[36:] + HUMP[:37]


@pytest.mark.parametrize(
    "title",
    [
        "deg", "[°]", "angle", "winkel", "grad", "theta", "phi", "crank", "cam", "°kw", "nw",
        "rotation", "position",
    ],
)  # fmt: skip
def test_of_columns_that_rise_that_of_an_angle_is_known_by_its_title(title):
    columns = {0: [2.0 * x for x in ANGLES], 1: ANGLES, 2: HUMP, 3: [3.0 * x for x in ANGLES]}
    assert lift_guess._angle_column(columns, ["time", title, "lift", "row"], "t.csv") == 1
    assert lift_guess._angle_column(columns, ["time", "row", "lift", "x"], "t.csv") == 0


def test_an_angle_goes_over_more_than_thirty_degrees_where_there_is_a_choice():
    """By title and span, else by the title, else by the span, else the first."""
    short = [x / 12 for x in ANGLES]  # 30
    down = [-x for x in ANGLES]
    find = lift_guess._angle_column
    assert find({0: short, 1: down}, ["a", "b"], "t") == 1
    assert find({0: short, 1: down}, ["deg", "b"], "t") == 0
    assert find({0: short, 1: down}, ["deg", "angle"], "t") == 1
    assert find({2: short, 1: HUMP}, ["", "", ""], "t") == 2
    with pytest.raises(SceneError, match=r"t\.csv: found no column that only rises or only falls"):
        find({0: HUMP}, [""], "t.csv")


@pytest.mark.parametrize(
    "title",
    [
        "lift", "hub", "rise", "valve", "ventil", "displacement", "hoehe", "höhe", "h", "y [mm]",
        "s (mm)",
    ],
)  # fmt: skip
def test_of_columns_that_rise_and_fall_that_of_a_lift_is_known_by_its_title(title):
    columns = {0: ANGLES, 1: HUMP, 2: OTHER}
    assert lift_guess._lift_columns(columns, ["deg", "data", title], 0, "t") == (2, [1])
    assert lift_guess._lift_columns(columns, ["deg", title, "data"], 0, "t") == (1, [2])
    assert lift_guess._lift_columns(columns, ["deg", "data", "shy"], 0, "t") == (1, [2])


@pytest.mark.parametrize(
    "title",
    [
        "velocity", "acceleration", "jerk", "geschwindigkeit", "beschleunigung", "ruck", "force",
        "kraft", "curvature", "error", "deviation", "abweichung", "tolerance", "lift mm/deg",
        "lift mm/ rad", "lift mm/°", "lift mm/s",
    ],
)  # fmt: skip
def test_a_column_of_another_thing_than_a_lift_is_none(title):
    columns = {0: ANGLES, 1: HUMP, 2: OTHER}
    assert lift_guess._lift_columns(columns, ["deg", title, "data"], 0, "t") == (2, [])
    assert lift_guess._lift_columns(columns, ["deg", title, "lift"], 0, "t") == (2, [])
    assert lift_guess._lift_columns(columns, ["deg", title, title], 0, "t") == (1, [])


def test_what_stands_for_a_lobe_where_no_column_rises_and_falls():
    """From nose to nose, and a flank; a lobe with both of its flanks comes before either."""
    find = lift_guess._lift_columns
    turn = ANGLES + [360.0 + 5.0 * k for k in range(1, 2)]
    nose = NOSE_TO_NOSE
    assert len(nose) == len(turn)
    assert find({0: turn, 1: nose}, ["deg", ""], 0, "t") == (1, [])
    assert find({0: turn, 1: nose, 2: [*HUMP, 0.0]}, ["deg", "lift", "x"], 0, "t") == (2, [])
    assert find({0: ANGLES[:37], 1: FLANK}, ["deg", ""], 0, "t") == (1, [])
    leaves_slowly = [k * k / 8 for k in range(9)]  # the last step is a quarter of the lift
    zero, below = [0.0] * 9, [x - 0.5 for x in FLANK[::4]]
    for none in (zero, [-x for x in FLANK[::4]], below, leaves_slowly, leaves_slowly[::-1]):
        with pytest.raises(SceneError, match="found no column that rises and falls again"):
            find({0: ANGLES[: len(none)], 1: none}, ["deg", "lift"], 0, "t")


@pytest.mark.parametrize(
    ("title", "kind"),
    [
        ("crank deg", "crank"), ("kurbelwinkel", "crank"), ("kw", "crank"), ("°kw", "crank"),
        ("ca", "crank"), ("cad", "crank"), ("°ca", "crank"), ("angle", "cam"), ("cam", "cam"),
        ("nockenwinkel", "cam"), ("nw", "cam"), ("cadence", "cam"), ("abkw", "cam"),
    ],
)  # fmt: skip
def test_whose_angle_a_column_holds(title, kind):
    """A short table whose title does not say cam may be of a crank."""
    guessed = Guess({})
    lift_guess._angle_kind(guessed, [300.0, 100.0], title)
    assert guessed.keys == {"angle": kind}
    said = kind == "crank" or title in ("cam", "nockenwinkel", "nw")
    doubt = {"angle": "200 deg of the cam, or of a crank that turns twice as fast?"}
    assert guessed.unsure == ({} if said else doubt)


@pytest.mark.parametrize(
    ("title", "side"),
    [
        ("valve lift", "valve"), ("ventilhub", "valve"), ("lift", "lobe"), ("valve lobe", "lobe"),
        ("ventil nocken", "lobe"), ("valve tappet", "lobe"), ("valve lifter", "lobe"),
        ("ventil stößel", "lobe"), ("ventil stoessel", "lobe"), ("valve cam", "lobe"),
        ("valve camshaft", "valve"),
    ],
)  # fmt: skip
def test_on_which_side_of_a_rocker_a_lift_was_measured(title, side):
    guessed = Guess({})
    lift_guess._rocker(guessed, title)
    assert guessed.keys == {"rocker_ratio": 1, "measured_at": side}
    assert set(guessed.unsure) == (set() if side == "valve" else {"rocker_ratio", "measured_at"})


@pytest.mark.parametrize(
    "title", ["1/100mm", "lift 1/100 mm", "0.01 mm", "0.01mm", ".01 mm", "[.01mm]", "hub 0.01 mm"]
)
def test_hundredths_of_a_millimetre_by_the_title(title):
    guessed = Guess({})
    lift_guess._lift_unit(guessed, [100.0, 1234.0], title)  # radii: the lift is the difference
    assert guessed.keys == {"lift": "fraction", "max_lift": 1e-5}
    assert guessed.unsure["lift"].endswith("11.34 mm of lift")
    guessed = Guess({})
    lift_guess._lift_unit(guessed, [61.0, 1234.0], title)  # no radii: they begin below a twentieth
    assert guessed.unsure["lift"].endswith("12.34 mm of lift")


@pytest.mark.parametrize("title", ["lift to 10.01 mm", "11/100 mm", "mm", "0.1 mm"])
def test_other_numbers_in_a_title_are_no_hundredths(title):
    guessed = Guess({})
    lift_guess._lift_unit(guessed, [0.0, 9.0], title)
    assert guessed.keys == {"lift": "mm"}


def test_a_reason_is_added_to_those_before():
    guessed = Guess({})
    guessed.doubt("lift", "one")
    guessed.doubt("angle", "two")
    guessed.doubt("lift", "three")
    assert guessed.unsure == {"lift": "one; three", "angle": "two"}


def test_shares_of_a_lift_and_how_often_it_rises_round_the_turn():
    assert lift_guess._shares([7.0, 5.0, 9.0]) == [0.5, 0.0, 1.0]
    first_in_the_middle = [0.9, 0.0, 0.0, 0.5, 1.0]  # one lobe, through zero
    assert lift_guess._lobes(first_in_the_middle) == 1
    assert lift_guess._lobes([0.0, 1.0, 0.05, 1.0, 0.0]) == 1  # between ground and lobe
    assert lift_guess._lobes([0.0, 1.0, 0.01, 1.0, 0.0]) == 2
    assert lift_guess._lobes([0.0, 1.0, 0.0, 0.09, 0.0]) == 1
    assert lift_guess._lobes([0.0, 1.0, 0.0, 0.11, 0.0]) == 2
