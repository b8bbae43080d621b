"""A family of machines and the small functions of one, on cams that are stubs."""

import pickle
from math import pi, tau
from types import SimpleNamespace

import pytest

from camcli.cams import EccentricCam
from camcli.errors import NoMachineError, SceneError
from camcli.kernel.flow import AS_ON_THE_CAM
from camcli.quantities import (
    LIFTS,
    METRES,
    MILLIMETRES,
    UM,
    Head,
    Quantity,
    drawn,
    headed,
    labelled,
)
from camcli.system import MOST_MEMBERS, Family, Follower, Member, System, decimals, units_of

FOLLOWER = Follower(
    mass=2.0, stiffness=3.0, damping=5.0, gravity=7.0, preload=11.0, restitution=0.13,
    seat_restitution=0.17,
)  # fmt: skip
RPM = 400.0
ECCENTRIC = EccentricCam(kind="eccentric", base=0.0, lift=0.02)


def stub_cam(*kinds: tuple[int, int], strobe: int = 0) -> SimpleNamespace:
    """A cam of stretches of which each is (dwell, seat)."""
    stretches = [
        SimpleNamespace(dwell=dwell, seat=seat, start=0.5 * n, c_min=3.0 - n)
        for n, (dwell, seat) in enumerate(kinds)
    ]
    return SimpleNamespace(stretches=stretches, strobe=strobe, top=4.0)


CAM = stub_cam((1, 1), (0, 0), (1, 0), strobe=2)


def family_of(build, home=(1.0, 12.0), ranges=((0.0, 4.0), (10.0, 20.0))) -> Family:
    return Family(("first", "second"), ranges, home, build)


def changed(**changes: float) -> System:
    return System(FOLLOWER, CAM, None).with_follower(**changes)


def test_the_machine_of_a_system_is_in_the_order_of_the_kernel():
    machine = System(FOLLOWER, CAM, None).machine(RPM)
    assert machine == [RPM, 2.0, 3.0, 5.0, 7.0, 11.0, 0.13, 0.17]
    assert changed(seat_restitution=None).machine(RPM)[-1] == AS_ON_THE_CAM
    bare = changed(damping=0.0, gravity=0.0, preload=0.0, restitution=0.0, seat_restitution=0.0)
    assert bare.machine(RPM) == [RPM, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_what_depends_on_the_cam_alone_is_made_once_for_all_followers():
    made = []

    class Form:
        def cam(self, cam):
            made.append(cam)
            return len(made)

    kernel = Form()
    system = System(FOLLOWER, CAM, None)
    heavy = system.with_follower(mass=9.0)
    assert [one.cam_for(kernel) for one in (system, heavy, heavy.with_follower(mass=8.0))] == [
        1
    ] * 3
    assert made == [CAM]
    assert System(FOLLOWER, CAM, None).cam_for(kernel) == 2


def test_every_stretch_of_a_cam_has_its_region_and_a_lobe_its_ratio():
    split = System.build(FOLLOWER, ECCENTRIC, 1.0)
    assert set(split.region_names) == set(range(len(split.cam.stretches)))
    assert len(split.cam.stretches) > len(set(split.region_names.values()))
    assert (split.corners, split.rocker_ratio) == ([], 1.0)
    assert System(FOLLOWER, CAM, SimpleNamespace(rocker_ratio=1.5)).rocker_ratio == 1.5


def test_constants_that_differ_at_an_end_or_in_the_middle_of_a_range_are_derived():
    """Each place of each range changes one; at the second's lowest there is no machine."""

    def build(values):
        if values[1] == 10.0:
            raise NoMachineError("none")
        at = {
            (0.0, 12.0): {"preload": 1.0}, (2.0, 12.0): {"damping": 1.0},
            (4.0, 12.0): {"gravity": 1.0}, (1.0, 15.0): {"stiffness": 1.0},
        }  # fmt: skip
        return changed(**at.get(values, {})), RPM + (values[1] == 20.0)

    family = family_of(build)
    assert family.derived == {0, 2, 3, 4, 5}
    own = (1.0, 22.0, 33.0, 55.0, 77.0, 111.0, 0.5, 0.6, 1.0, 12.0)
    moved = family.moved(own, (1.0, 20.0))
    assert moved == (RPM + 1.0, 22.0, 3.0, 5.0, 7.0, 11.0, 0.5, 0.6, 1.0, 20.0)
    assert family.home.machine == (RPM, 2.0, 3.0, 5.0, 7.0, 11.0, 0.13, 0.17, 1.0, 12.0)
    system = family.home.system
    assert system.at(own) is system
    assert system.at(own[:8]) is system
    heavy = system.with_follower(mass=9.0)
    assert heavy.at(own) is heavy
    other = system.at((*own[:8], 2.0, 12.0))
    assert other.follower.damping == 1.0
    assert other.member.values == (2.0, 12.0)
    assert other.with_follower(mass=9.0).at(own) is system
    assert System(FOLLOWER, CAM, None).at(own).member is None


def test_the_machines_of_a_family_that_were_used_last_are_kept():
    built = []

    def build(values):
        built.append(values)
        return changed(), RPM

    family = family_of(build)
    members = [family.at((100.0 + k, 12.0)) for k in range(MOST_MEMBERS)]
    count = len(built)
    assert family.compiled == count
    assert family.at((100.0, 12.0)) is members[0]  # so that the next one that goes is 101
    family.at((50.0, 12.0))
    assert family.compiled == count + 1
    for k in (0, 2, MOST_MEMBERS - 1):
        assert family.at((100.0 + k, 12.0)) is members[k]
    assert family.compiled == len(built) == count + 1
    family.at((101.0, 12.0))
    assert built[-1] == (101.0, 12.0)


@pytest.mark.parametrize(
    ("cam", "said"),
    [
        (stub_cam((1, 0), (0, 0), (1, 0), strobe=2), "passes the strobe or the angle zero"),
        (stub_cam((1, 1), (1, 0), (1, 0), strobe=2), "passes the strobe or the angle zero"),
        (stub_cam((1, 1), (0, 0), (1, 0), strobe=1), "passes the strobe or the angle zero"),
        (stub_cam((1, 1), (0, 0), strobe=1), "the cam has 2 parts there, here 3: one appears"),
        (stub_cam((1, 1), strobe=0), "the cam has 1 part there, here 3: one appears"),
    ],
)
def test_a_cam_with_other_stretches_is_outside_the_family(cam, said):
    def build(values):
        return System(FOLLOWER, CAM if values[0] < 3.0 else cam, None), RPM

    family = family_of(build)
    assert family.at((2.0, 12.0)).values == (2.0, 12.0)
    with pytest.raises(NoMachineError, match=said):
        family.at((3.0, 12.0))


@pytest.mark.parametrize("scale", [1.0, 1e-6])
@pytest.mark.parametrize(("end", "limit"), [(4.0, 2.618), (-4.0, -1.303), (2.5, 2.618)])
def test_a_family_reaches_as_far_as_there_are_machines(scale, end, limit):
    """The reason is the one beside the last machine; a little farther there is another one."""

    def build(values):
        first = values[0] / scale
        if abs(first) > abs(limit):
            raise NoMachineError("near" if abs(first) < abs(limit) + 0.01 else "far")
        return changed(), RPM

    ranges = ((min(0.1, end) * scale, max(0.1, end) * scale), (10.0, 20.0))
    family = family_of(build, (0.1 * scale, 12.0), ranges)
    good, reason = family.reach(0, (0.1 * scale, 13.0), end * scale)
    if abs(end) < abs(limit):
        assert (good, reason) == (end * scale, "")
        return
    assert reason == "near"
    family.at((good, 13.0))
    assert abs(good - limit * scale) <= 2e-12 * abs(end) * scale


@pytest.mark.parametrize("place", [0, 1])
def test_a_reach_may_end_before_the_first_look(place):
    """It is then looked for from where the number that moves stands."""

    def build(values):
        if abs(values[place] - (0.7, 12.0)[place]) > 1e-3:
            raise NoMachineError("no more")
        return changed(), RPM

    family = family_of(build, (0.7, 12.0))
    end = (0.95, 19.0)[place]
    good, reason = family.reach(place, (0.7, 12.0), end)
    assert (good, reason) == (pytest.approx((0.701, 12.001)[place], abs=1e-10), "no more")


def test_a_reach_that_ends_at_the_end_is_the_end_itself():
    """0.7 + (0.1 - 0.7) is not 0.1."""
    family = family_of(lambda values: (changed(), RPM), (0.7, 12.0))
    assert 0.7 + (0.1 - 0.7) != 0.1
    assert family.reach(0, (0.7, 12.0), 0.1) == (0.1, "")
    assert family.reach(1, (0.7, 12.0), 19.0) == (19.0, "")


def test_a_reach_looks_evenly_and_ends_where_doubles_do():
    """Of 16 looks the last but one finds a gap; around 1000 the limit is known to a last digit."""

    def build(values):
        if 14.5 < values[0] < 15.5 or values[0] > 1000.0103:
            raise NoMachineError("none")
        return changed(), RPM

    family = family_of(build, (0.5, 12.0), ((0.5, 16.0), (10.0, 20.0)))
    good, reason = family.reach(0, (0.0, 12.0), 16.0)
    assert (good, reason) == (pytest.approx(14.5, abs=1e-10), "none")
    good, reason = family.reach(0, (1000.0, 12.0), 1000.016)
    assert (good, reason) == (pytest.approx(1000.0103, abs=3e-13), "none")


def test_the_seat_has_its_own_restitution_where_one_is_told():
    system = System(FOLLOWER, CAM, None)
    assert [system.restitution(i) for i in range(3)] == [0.17, 0.13, 0.13]
    plastic = changed(seat_restitution=0.0)
    assert [plastic.restitution(i) for i in range(3)] == [0.0, 0.13, 0.13]
    alike = changed(seat_restitution=None)
    assert [alike.restitution(i) for i in range(3)] == [0.13] * 3
    assert system.has_seat
    assert system.seat_stretches == {0}
    assert system.strobe == 1.0
    assert system.lift == 4.0 - 1.0


def test_the_cam_without_its_lash_keeps_follower_and_strobe():
    shape = EccentricCam(kind="eccentric", base=0.0, lift=0.02, lash=0.003)
    system = System.build(FOLLOWER, shape, 1.25)
    assert system.lash == 0.003
    drawn_system = system.as_drawn
    assert (drawn_system.follower, drawn_system.strobe) == (FOLLOWER, 1.25)
    assert drawn_system.lash == 0.0
    assert not drawn_system.has_seat
    assert drawn_system.as_drawn is drawn_system
    assert drawn_system.lift_range == pytest.approx((0.0, 0.02), abs=1e-15)
    assert system.lift_range == pytest.approx((0.0, 0.017), abs=1e-15)
    member = Member(None, (1.0,), system, (1.0,))
    held = System(FOLLOWER, system.cam, shape, member)
    assert held.with_follower(mass=3.0).member is member
    assert pickle.loads(pickle.dumps(held)).member is None


def test_constants_have_the_tolerance_in_rad_and_finite_squares():
    system = System.build(FOLLOWER, ECCENTRIC)
    const = system.constants(RPM, 1e-3, 77)
    omega = RPM * pi / 30.0
    assert const.tolerance == pytest.approx(1e-3 * tau, rel=1e-15)
    assert const.impact_budget == 77
    assert pytest.approx((3.0 / 2.0) ** 0.5 / omega, rel=1e-14) == const.W
    assert pytest.approx(5.0 / 4.0 / omega, rel=1e-14) == const.Z
    assert pytest.approx((7.0 + 11.0 / 2.0) / omega**2, rel=1e-14) == const.G
    for change in ({"stiffness": 1e308, "mass": 1e-8}, {"damping": 1e200}, {"gravity": 1e308}):
        with pytest.raises(SceneError, match="expected finite squares of both"):
            system.with_follower(**change).constants(1e-5, 1e-3, 77)


def test_a_width_has_two_digits_and_lengths_are_in_mm_below_a_tenth_of_a_metre():
    widths = {0.0: 6, 0.0012: 4, 0.01: 3, 0.099: 3, 0.1: 2, 1.0: 1, 9.9: 1, 10.0: 0, 1e5: 0}
    assert {width: decimals(width) for width in widths} == widths
    for lift, units in ((0.0999, MILLIMETRES), (0.1, METRES), (2.0, METRES)):
        assert units_of(SimpleNamespace(lift=lift)) is units


def test_numbers_are_shown_with_as_many_digits_as_are_asked_for():
    assert MILLIMETRES.lengths(0.0123456) == "12.3 mm"
    assert MILLIMETRES.lengths(0.0123456, 5) == "12.346 mm"
    assert METRES.lengths(1.23456, 2) == "1.2 m"
    assert MILLIMETRES.stiffnesses(10_714_600.0) == "10710 N/mm"
    assert METRES.stiffnesses(10_714_600.0, 6) == "10714600 N/m"
    assert MILLIMETRES.stiffnesses(123_456.0, 2) == "120 N/mm"


def test_the_words_of_a_quantity_are_made_of_its_parts():
    full = Quantity(
        "x_um", "um", "name", "in words", entries="0..1", head="short", numbered=True, symbol="k_1"
    )
    plain = Quantity("rate_per_s", "1/s", "rate")
    assert full.label == "name $k_1$ (µm)"
    assert plain.label == "rate (1/s)"
    assert (full.heading, plain.heading) == ("short (um)", "rate (1/s)")
    assert (full.meaning, plain.meaning) == ("in words (0..1)", "rate")
    assert (full.description, plain.description) == ("in words, 0..1", "rate, 1/s")
    assert full.columns(3) == ["x_um_1", "x_um_2", "x_um_3"]
    assert MILLIMETRES.head(full) == "short (um)"
    assert MILLIMETRES.head(plain) == "rate"
    assert MILLIMETRES.head(LIFTS["c_theta"]) == "$c_\\theta$ (mm/rad)"
    assert METRES.head(Quantity("v", "m/s", "speed")) == "speed (m/s)"
    assert METRES.head(Quantity("r", "", "ratio")) == headed("ratio", "") == "ratio"
    assert drawn("um/rad3") == "µm/rad³"
    assert labelled("bend", "m/rad2") == "bend (m/rad²)"
    assert UM == 1e6
    head = Head(
        "table", "a row", (Quantity("p", "", "p", varied=True), full,
        Quantity("q", "", "q", varied=True), plain),
    )  # fmt: skip
    assert head.names() == ("p", "x_um_1", "q", "rate_per_s")
    assert head.names("one", impacts=2) == ("one", "x_um_1", "x_um_2", "q", "rate_per_s")
    assert head.names("one", "two") == ("one", "x_um_1", "two", "rate_per_s")
