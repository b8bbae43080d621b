"""Tables on the loss of contact and the rows of a machine, by hand: every column of every row."""

from math import inf, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.contact_loss.detachment import CriticalQuantity
from camcli.analysis.contact_loss.hold import HoldStatus
from camcli.quantities import MILLIMETRES
from camcli.words import detach_tables, machine
from camcli.words.detach_tables import answers, lists_of_forces, lists_of_motions

LANDING = radians(250.0)  # on the flank; from 300 deg on the follower is on its seat


class System(Made):
    """What the tables ask of a machine with a seat from 300 deg to the end of the turn."""

    lift = 0.01  # so that its lengths are shown in mm
    rocker_ratio = 1.0
    lash = 0.0004
    has_seat = True
    cam = None

    def is_seat(self, theta):
        return self.has_seat and theta >= radians(300.0)


def motion(rpm, number, landing=LANDING):
    """A motion whose loads are all different, and different from those of other numbers."""
    return Made(rpm=rpm, loads=Made(
        max_gap_m=0.001 * number, max_impact_m_per_s=0.5 + number, landing=landing,
        landing_lift_m=0.0025 + 0.001 * number, shut_bounces_per_turn=2.0 + number,
        min_contact_force_n=-1e-10 if number == 1 else 10.0 * number,
        max_contact_force_n=100.0 + number, seat_velocity_m_per_s=0.25 + number,
        seat_opening_velocity_m_per_s=0.125 + number, seat_bounces_per_turn=3.0 + number,
        seat_bounce_height_m=0.0002 * number, seat_open=radians(10.0 + number),
    ))  # fmt: skip


def result_of(past=(), at_work=None, at_asked=None, crank=True, **more):
    values = {"past": past, "at_work": at_work, "at_asked": at_asked, "forces": [], "holds": []}
    scene = Made(run=Made(crank=crank), cam=Made(kind="law", angle="cam"))
    return Made(system=System(), scene=scene, values=Made(**{**values, **more}))


SHUT, BLOW = "seat", "blow"


def test_motions_past_the_loss_have_all_their_loads_and_the_speeds_of_both_shafts():
    """Where the follower lands on its seat or is struck by the lobe, that stands for the lift."""
    past = [motion(610.5, 1), motion(611.25, 2, radians(310.0)), motion(613.0, 4, radians(0.0))]
    past.append(motion(615.0, 6))
    past[-1].loads.min_contact_force_n = None
    table = answers(result_of(past))[0]
    assert table.title == "Past the loss of contact"
    assert table.heads == [
        "cam (rpm)", "crank (rpm)", "loft (mm)", "lands (m/s)", "at (deg)", "at lift (mm)",
        "bounces", "force (N)",
    ]  # fmt: skip
    assert table.rows == [
        ["610.50", "1221.00", "1", "1.5", "250", "3.5", "3", "0 to 101"],
        ["611.25", "1222.50", "2", "2.5", "310", SHUT, "4", "20 to 102"],
        ["613.00", "1226.00", "4", "4.5", "0", BLOW, "6", "40 to 104"],
        ["615.00", "1230.00", "6", "6.5", "250", "8.5", "8", ""],
    ]
    alone = answers(result_of(past[:1], crank=False))[0]
    assert alone.rows[0][:3] == ["610.5", "1", "1.5"]
    assert alone.rows[0][4] == "3.5"


def test_the_table_of_the_seat_has_the_working_speed_and_the_one_that_was_asked_for():
    """In ascending order, each once; a row that reads like the marked one is left out."""
    past = [motion(610.5, 1), motion(611.25, 2), motion(613.0, 4)]
    found = result_of(past, at_work=motion(600.0, 8), at_asked=motion(640.0, 9), crank=False)
    _, seat = answers(found)
    assert seat.title == "On the seat (*: the working speed)"
    assert seat.heads[0] == "cam (rpm)"
    assert seat.rows == [
        ["600.00*", "8.25", "8.12", "11", "1.6", "18"],
        ["610.50", "1.25", "1.12", "4", "0.2", "11"],
        ["611.25", "2.25", "2.12", "5", "0.4", "12"],
        ["613.00", "4.25", "4.12", "7", "0.8", "14"],
        ["640.00", "9.25", "9.12", "12", "1.8", "19"],
    ]
    found.values.at_work = motion(611.2501, 8)
    found.values.at_asked = motion(613.0 + 1e-10, 9)
    _, seat = answers(found)
    assert [row[:2] for row in seat.rows] == [
        ["610.50", "1.25"], ["611.25*", "8.25"], ["613.00", "4.25"]
    ]  # fmt: skip
    found.values.at_work = None
    _, seat = answers(found)
    assert seat.title == "On the seat"
    assert [row[0] for row in seat.rows] == ["610.50", "611.25", "613.00"]
    found.system.has_seat = False
    assert [table.title for table in answers(found)] == ["Past the loss of contact"]


def test_forces_of_a_follower_kept_on_the_cam_stand_beside_the_largest_pressure():
    def curve(rpm, lowest, pressure):
        largest = {"forces": (400.0 + rpm, 1.0), "pressures": (2e9 + 1e6 * rpm, radians(123.25))}
        return Made(rpm=rpm, lowest_n=lowest, lowest_theta=radians(31.5), force_n="forces",
                    pressure_pa=pressure, highest=lambda of: largest[of])  # fmt: skip

    curves = [curve(600.0, -1e-10, "pressures"), curve(700.0, -2.5, "pressures")]
    (table,) = answers(result_of(forces=curves))
    assert table.heads == [
        "cam (rpm)", "crank (rpm)", "least (N)", "at (deg)", "largest (N)", "Hertz (MPa)",
        "at (deg)",
    ]  # fmt: skip
    assert table.rows == [
        ["600", "1200", "0", "31.5", "1000", "2600", "123.2"],
        ["700", "1400", "-2.5", "31.5", "1100", "2700", "123.2"],
    ]
    assert table.title == "Contact force if the follower is kept on the cam"
    without = result_of(forces=[curve(600.0, 5.0, None)], crank=False)
    without.system.rocker_ratio = 1.5
    (table,) = answers(without)
    assert table.title == "Contact force at the valve, kept on the cam (lobe: 1.5 times)"
    assert (table.heads[-1], table.rows) == ("largest (N)", [["600", "5", "31.5", "1000"]])
    without.system.rocker_ratio = 0.75
    assert answers(without)[0].title.endswith("kept on the cam (lobe: 0.75 times)")
    ((title, heads, *rows),) = lists_of_forces(result_of(forces=curves))
    assert title == ["Contact force if the follower is kept on the cam"]
    assert (heads[2], rows[1][2]) == ("least (N)", "−2.5")


def test_springs_that_hold_have_rate_preload_force_at_full_lift_and_how_far_they_hold():
    def hold(quantity, stiffness, preload, nose, detaches, more=True, status=HoldStatus.OK):
        return Made(quantity=quantity, stiffness=stiffness, preload=preload, nose_n=nose,
                    detaches=detaches, more=more, status=status)  # fmt: skip

    rate, press, both = (
        CriticalQuantity.HOLD_STIFFNESS, CriticalQuantity.HOLD_PRELOAD, CriticalQuantity.HOLD_BOTH
    )  # fmt: skip
    holds = [
        hold(rate, 25000.0, 120.0, 370.0, 6500.0),
        hold(press, 20000.0, 180.0, 380.0, inf, more=False),
        hold(both, None, None, None, None),
        hold(both, 30000.0, 90.0, 390.0, 6600.5, status=HoldStatus.ABSURD),
    ]
    (table,) = answers(result_of(holds=holds))
    assert table.heads == [
        "spring", "rate (N/mm)", "preload (N)", "at full lift (N)", "holds to (rpm)", "status"
    ]  # fmt: skip
    assert table.rows == [
        ["stiffer spring", "25", "120", "370", "6500", HoldStatus.OK],
        ["less preload", "20", "180", "380", "never", HoldStatus.OK],
        ["another spring", "30", "90", "390", "6600.5", HoldStatus.ABSURD],
    ]


@pytest.mark.parametrize(
    ("count", "most", "marked", "kept"),
    [
        (5, 5, None, [0, 1, 2, 3, 4]), (9, 3, None, [0, 4, 8]), (9, 5, None, [0, 2, 4, 6, 8]),
        (9, 3, 5, [0, 4, 5, 8]), (8, 3, 7, [0, 4, 7]),
    ],
)  # fmt: skip
def test_rows_of_a_page_are_spread_from_the_first_to_the_last(count, most, marked, kept):
    rows = [[f"{k}*" if k == marked else f"{k}"] for k in range(count)]
    assert detach_tables._spread_out(rows, most) == [rows[k] for k in kept]


def test_a_list_of_motions_says_how_many_of_its_rows_are_shown():
    past = [motion(600.0 + k, k + 1) for k in range(9)]
    moved, seat = lists_of_motions(result_of(past, at_work=motion(605.0, 20)), 3)
    assert moved[0] == ["Past the loss of contact: 3 of 9 rows; more in speeds.csv"]
    assert [row[0] for row in moved[2:]] == ["600.0", "604.0", "608.0"]
    assert seat[0] == ["On the seat (*: the working speed): 4 of 9 rows; more in speeds.csv"]
    assert [row[0] for row in seat[2:]] == ["600.0", "604.0", "605.0*", "608.0"]
    whole, _ = lists_of_motions(result_of(past), 9)
    assert whole[0] == ["Past the loss of contact"]
    # the working speed between the first and the last of three: none is left out
    three, seat = lists_of_motions(result_of(past[:3], at_work=past[1]), 2)
    assert three[0] == ["Past the loss of contact: 2 of 3 rows; more in speeds.csv"]
    assert seat[0] == ["On the seat (*: the working speed)"]
    assert [row[0] for row in seat[2:]] == ["600.0", "601.0*", "602.0"]


def test_two_speeds_are_told_from_one_another_and_a_force_may_be_zero():
    past = [motion(610.5, 3), motion(610.75, 2)]
    assert answers(result_of([motion(605.0, 1), *past]))[0].rows[0][0] == "605.00"
    past[0].loads.min_contact_force_n = 0.0
    past[1].loads.max_contact_force_n = 0.0
    table = answers(result_of(past, crank=False))[0]
    assert [(row[0], row[-1]) for row in table.rows] == [
        ("610.50", "0 to 103"),
        ("610.75", "20 to 0"),
    ]
    past[0].loads.max_contact_force_n = None
    assert answers(result_of(past))[0].rows[0][-1] == ""


def test_a_cell_has_six_decimals_unless_it_would_be_zero_then():
    cells = [
        (None, 1.0, 3, ""), (0.0123456, 1.0, 6, "0.012346"), (2e-7, 1.0, 3, "0.0000002"),
        (0.0025, 1000.0, 3, "2.5"), (0.0, 1.0, 3, "0"), (-12.345, 1.0, 4, "-12.35"),
    ]  # fmt: skip
    for value, scale, digits, said in cells:
        assert detach_tables._cell(value, scale, digits) == said
    assert [detach_tables._zero(x) for x in (-2e-9, -1e-10, 1e-10, 3.0)] == [-2e-9, 0.0, 0.0, 3.0]


# --- the machine


def test_a_machine_has_a_row_for_each_of_its_numbers(monkeypatch):
    """Forces at both ends of the lift; with a lash the lift of the lobe and that of the valve."""
    monkeypatch.setattr(machine, "lift_range", lambda cam: (0.002, 0.0105))
    monkeypatch.setattr(machine, "cam_name", lambda cam: "the cam")
    follower = Made(mass=0.1, stiffness=20000.0, preload=-50.0, damping=3.0, restitution=0.4,
                    seat_restitution=0.25)  # fmt: skip
    system = System(follower=follower, rocker_ratio=1.5)
    scene = Made(
        cam=Made(kind="table", measured_at="valve"), spring=Made(mass=0.03),
        contact=Made(follower_radius=0.008, face=None, base_radius=0.015, width=0.012),
    )  # fmt: skip
    rows = machine.machine(Made(system=system, scene=scene))
    assert rows == [
        ["machine", ""],
        ["mass", "0.1 kg"],
        ["spring", "20 N/mm"],
        ["force at lowest lift", "−10 N"],
        ["force at full lift", "160 N"],
        ["damping", "3 N s/m"],
        ["restitution", "0.4"],
        ["cam", "the cam"],
        ["lift", "8.9 mm"],
        ["rocker ratio", "1.5"],
        ["table of the", "valve"],
        ["lash", "0.4 mm"],
        ["lift less lash", "8.5 mm"],
        ["restitution, seat", "0.25"],
        ["mass of the spring", "0.03 kg"],
        ["on the lobe", "roller of 8 mm"],
        ["base radius", "15 mm"],
        ["width of contact", "12 mm"],
    ]
    follower.seat_restitution, system.lash, system.rocker_ratio = None, 0.0, 1.0
    scene.spring, scene.cam.kind = Made(mass=None), "law"
    scene.contact = Made(follower_radius=None, face=None, base_radius=None, width=None)
    names = dict(machine.machine(Made(system=system, scene=scene))[8:])
    assert names == {
        "lift": "8.5 mm", "lash": "0 mm", "restitution, seat": "0.4", "on the lobe": "flat"
    }  # fmt: skip
    system.rocker_ratio, follower.seat_restitution = 0.75, 0.0
    names = dict(machine.machine(Made(system=system, scene=scene))[8:])
    assert names["rocker ratio"] == "0.75"
    assert "table of the" not in names
    assert names["restitution, seat"] == "0"
    system.rocker_ratio = 1.0
    system.has_seat, system.lash = False, 0.0004  # without a seat a lash counts for nothing
    scene.contact.face, scene.contact.follower_radius = "knife", 0.0
    names = dict(machine.machine(Made(system=system, scene=scene))[8:])
    assert names == {"lift": "8.5 mm", "on the lobe": f"knife of {MILLIMETRES.lengths(0.0, 4)}"}


def test_the_highest_place_of_a_cam_is_its_base_and_its_lift():
    """Of a cam of arcs it is the tip of its nose, counted from where c is zero."""
    table = Made(kind="table", base=0.002, measured=Made(lift=[0.001, 0.009, 0.004]))
    arcs = Made(kind="arcs", nose_center=0.05, nose_radius=0.012, offset=0.03, base_radius=0.04)
    law = Made(kind="law", lift=0.01, base=0.003)
    for cam, wanted in ((table, (0.009, 0.011)), (arcs, (0.022, 0.032)), (law, (0.01, 0.013)),
                        (Made(kind="eccentric"), (0.0, 0.0))):  # fmt: skip
        assert machine._lift_and_top(cam) == pytest.approx(wanted)


def test_a_lift_that_seems_to_be_a_radius_is_told_in_the_unit_of_the_file():
    def doubted(*lifts):
        cam = Made(measured=Made(lift=lifts), metres=0.001, subtract=12.5)
        return list(machine._doubt_of_radii(cam))

    assert doubted(0.02, 0.0031, 0.01) == [
        "warning: the smallest lift of the table is 3.1 mm; if these are radii, write subtract: "
        "15.6"
    ]
    assert doubted(0.02, 0.001, 0.01) == []
    assert len(doubted(0.02, 0.0010001, 0.01)) == 1
