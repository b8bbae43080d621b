"""The range of a seating velocity holds that of the law which the table was made of."""

import numpy as np
import pytest

import camcli
from camcli.analysis.contact_loss.study import motion_past
from camcli.api.machine import machine_of
from camcli.api.seating import VELOCITIES, seating_ranges
from tests.support.lift_tables import Lobe, cycloidal, polynomial, scene, smooth, table

FOLLOWER = {"mass": 0.12, "stiffness": 42000.0, "preload": 260.0, "restitution": 0.4}
LASH, FLANK = 0.00025, 70.0
LAWS = {"4-5-6-7": smooth, "3-4-5": polynomial, "cycloidal": cycloidal}


class Motion:
    """What `seating_ranges` reads of a study: here one motion, at the working speed."""

    def __init__(self, at_work):
        self.past, self.at_work, self.at_asked = (), at_work, None


def of_law(law):
    """The machine with the law itself."""
    motion = {"length_deg": FLANK, "law": law}
    cam = {"kind": "law", "base": 0.0, "lift": 0.01, "top_dwell_deg": 0.0, "lash": LASH,
           "rise": {"start_deg": 180.0 - FLANK, **motion}, "fall": motion}  # fmt: skip
    return machine_of(camcli.load_scene({"follower": FOLLOWER, "cam": cam}))


@pytest.mark.ci
@pytest.mark.parametrize(
    ("law", "step", "decimals"), [("4-5-6-7", 1, 3), ("3-4-5", 2.5, 2), ("cycloidal", 5, 3)]
)
def test_the_seating_of_the_law_lies_in_the_range_of_its_table(tmp_path, law, step, decimals):
    """Below the loss of contact and past it; a range is not ten times as wide as the errors are."""
    lobe = Lobe(LAWS[law], flank=FLANK)
    measured = machine_of(scene(tmp_path, table(lobe, step, decimals=decimals), lash=LASH))
    exact = of_law(law)
    wide = []
    for rpm in (2500.0, 3600.0):
        truth = motion_past(exact.system, rpm, exact.settings).loads
        found = Motion(motion_past(measured.system, rpm, measured.settings))
        (told,) = seating_ranges(measured, found)
        assert told["rpm"] == rpm
        for column in VELOCITIES:
            name = column.removesuffix("_m_per_s")
            low, high = told[f"{name}_low_m_per_s"], told[f"{name}_high_m_per_s"]
            true = getattr(truth, column)
            assert low <= told[column] <= high
            assert low <= true <= high, (rpm, column, low, true, high)
            wide.append((high - low) / 2.0 / abs(true - told[column]))
    assert np.median(wide) < 10.0


def test_a_law_and_a_table_without_a_seat_have_no_range(tmp_path):
    exact = of_law("cycloidal")
    motion = motion_past(exact.system, 2500.0, exact.settings)
    assert seating_ranges(exact, Motion(motion)) == []
    bare = machine_of(scene(tmp_path, table(Lobe(smooth), 2)))
    assert seating_ranges(bare, Motion(motion)) == []
