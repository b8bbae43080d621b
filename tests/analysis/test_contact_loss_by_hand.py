"""The force on the cam, the speeds at which contact is lost, and what is asked of them, by hand."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from types import SimpleNamespace as Stub

import pytest

from camcli.analysis.contact_loss import detachment, force, study
from camcli.analysis.contact_loss.detachment import (
    AlwaysLost,
    CriticalQuantity,
    CriticalSpeed,
    Reason,
    SpeedStatus,
)
from camcli.analysis.contact_loss.force import Force, ForceCurve, LostBetween
from camcli.analysis.contact_loss.study import STANDSTILL, ContactLoss
from camcli.analysis.integrate import BudgetSpentError, Cost, Settings
from camcli.analysis.labels import UNDECIDED
from camcli.errors import Fault, SceneError, Status

TURN = 2.0 * pi
RPM = pi / 30.0  # rad/s


# -- the force


@dataclass(frozen=True)
class Region:
    name: str
    stretches: tuple[int, ...]


def stretch(start, end, c_min=0.0, accel=(0.0, 0.0), seat=False, pieces=2.0):
    return Stub(start=start, end=end, c_min=c_min, accel_min=accel[0], accel_max=accel[1],
                seat=seat, piece_count=pieces)  # fmt: skip


CAM = Stub(top=0.25, stretches=[
    stretch(0.5, 1.0, -0.5, (-3.0, 2.0)), stretch(1.0, 3.0, 0.125, (-1.0, 7.0), seat=True),
    stretch(3.0, 6.5, -0.25, (-5.0, 1.0), pieces=3.0),
])  # fmt: skip


def force_of(monkeypatch, cam=CAM, **follower) -> Force:
    regions = [Region("A1", (0, 1)), Region("A2", (1,)), Region("A3", (2,))]
    monkeypatch.setattr(force, "regions", lambda asked: regions if asked is cam else None)
    given = {"mass": 2.0, "gravity": 3.0, "preload": 8.0, "stiffness": 24.0, "damping": 6.0}
    return Force(Stub(follower=Stub(**{**given, **follower}), cam=cam))


def test_a_force_is_a_quadratic_in_the_speed(monkeypatch):
    """A = g + F0/m + k c/m, B = b c'/m, C = c'' and its error, times the mass."""
    made = force_of(monkeypatch)
    made.error = lambda theta: theta / 8.0
    monkeypatch.setattr(
        force, "lift_at", lambda *of: (0.5, -2.0, 3.0) if of == (CAM, 2, 4.0) else 0
    )
    assert made.terms(2, 4.0) == (3.0 + 4.0 + 12.0 * 0.5, 3.0 * -2.0, 3.5)
    assert made.newton(2, 4.0, 10.0) == 2.0 * (13.0 - 60.0 + 350.0)


def test_roundings_are_those_of_the_largest_terms(monkeypatch):
    """2^-49 of A, of the largest lift, which is below zero, and of the largest acceleration."""
    made = force_of(monkeypatch)
    assert made.a_rounding == 2.0**-49 * (7.0 + 12.0 * 0.5)
    assert made.b_rounding == 2.0**-49 * 3.0 * 7.0
    assert made.c_rounding == 2.0**-49 * 7.0
    assert force_of(monkeypatch, preload=-10.0).a_rounding == 2.0**-49 * (2.0 + 6.0)
    other = Stub(top=0.75, stretches=[stretch(0.5, 1.0, -0.5, (-9.0, 2.0)), *CAM.stretches[1:]])
    made = force_of(monkeypatch, other)
    assert (made.a_rounding, made.c_rounding) == (2.0**-49 * (7.0 + 12.0 * 0.75), 2.0**-49 * 9.0)
    assert made.b_rounding == 2.0**-49 * 3.0 * 9.0


def test_regions_are_those_parts_that_are_not_on_a_seat(monkeypatch):
    made = force_of(monkeypatch)
    assert made.on_lobe == [0, 2]
    assert made.regions == [Region("A1", (0,)), Region("A3", (2,))]
    assert [made.region_of(i).name for i in (0, 2)] == ["A1", "A3"]
    assert (made.starts, made.ends, made.counts) == ([0.5, 1.0, 3.0], [1.0, 3.0, 6.5], [2, 2, 3])


BIT = 2.0**-49


@pytest.mark.parametrize(("a", "b", "c", "lost"), [
    (6.0, 0.0, -1.5, (2.0, inf)),
    (6.0, 1.0, -1.0, (3.0, inf)),
    (6.0, -1.0, -1.0, (2.0, inf)),
    (6.0, -5.0, 1.0, (2.0, 3.0)),
    (6.0, -3.0, 0.0, (2.0, inf)),
    (6.0, -4.0, 1.0, (inf, inf)),  # no root
    (6.0, 5.0, 1.0, (inf, inf)),  # both below zero
    (6.0, 0.0, 0.0, (inf, inf)),
    (6.0, 2.0, 0.0, (inf, inf)),
    (-1.0, 5.0, 1.0, (0.0, inf)),
    (0.0, 0.0, 0.0, (0.0, inf)),
    (0.0, 6.0, -2.0, (3.0, inf)),
    (0.0, 6.0, 2.0, (inf, inf)),
    (0.0, 0.0, 2.0, (inf, inf)),
    (0.0, -1.0, 2.0, (0.0, inf)),
    (0.0, 0.0, -2.0, (0.0, inf)),
    # but for rounding, of 4, 2 and 1 bits
    (4.0 * BIT, 6.0, -2.0, (3.0, inf)),
    (-4.0 * BIT, 6.0, -2.0, (3.0, inf)),
    (-4.1 * BIT, 6.0, -2.0, (0.0, inf)),
    (0.0, 2.0 * BIT, -2.0, (0.0, inf)),
    (0.0, 2.0 * BIT, 2.0, (inf, inf)),
    (0.0, -2.0 * BIT, 2.0, (inf, inf)),
    (0.0, -2.1 * BIT, 2.0, (0.0, inf)),
    (0.0, 0.0, 1.0 * BIT, (0.0, inf)),
    (0.0, 0.0, 1.1 * BIT, (inf, inf)),
    (0.0, 6.0, -1.0 * BIT, (inf, inf)),
])  # fmt: skip
def test_contact_is_lost_between_the_roots(a, b, c, lost):
    made = Force.__new__(Force)
    made.terms = lambda i, theta: (a, b, c) if (i, theta) == (2, 4.0) else None
    made.a_rounding, made.b_rounding, made.c_rounding = 4.0 * BIT, 2.0 * BIT, BIT
    assert made.lost(2, 4.0) == pytest.approx(lost, rel=1e-12, abs=0.0)


def test_the_lowest_value_is_the_first_of_those_that_are_as_low(monkeypatch):
    """But for 1e-14 of it, and for rounding; on the lobe, or on the stretches asked for."""
    made = force_of(monkeypatch)
    known = {0: -1.0, 1: -9.0, 2: -2.0}
    asked = []

    def lowest(f, low, high, samples):
        asked.append((low, high, samples))
        return f(low), 0.5 * (low + high)

    monkeypatch.setattr(force, "lowest", lowest)

    def value(i, theta):
        assert theta == made.starts[i]
        return known[i]

    assert made.lowest(value) == (-2.0, 2, 4.75)
    assert asked == [(0.5, 1.0, 96), (3.0, 6.5, 144)]
    assert made.lowest(value, (1, 2)) == (-9.0, 1, 2.0)
    assert made.lowest(value, (2,)) == (-2.0, 2, 4.75)
    for less, rounding, i in (
        (0.9e-14, 0.0, 0), (1.3e-14, 0.0, 2), (1.3e-14, 1e-14, 0), (0.4, 0.5, 0), (0.6, 0.5, 2),
    ):  # fmt: skip
        known[2] = -1.0 - less
        assert made.lowest(value, rounding=rounding)[1] == i
    known.update({0: inf, 2: inf})
    assert made.lowest(value) == (inf, 0, 0.5)


def test_the_weakest_force_is_known_but_for_the_rounding_of_its_terms(monkeypatch):
    made = force_of(monkeypatch)
    omega = 300.0 * RPM
    asked = []
    made.newton = lambda *of: of
    made.lowest = lambda f, rounding: asked.append((f(2, 4.0), rounding)) or "lowest"
    assert made.weakest(300.0) == "lowest"
    ((of, rounding),) = asked
    assert of == (2, 4.0, pytest.approx(omega))
    terms = 13.0 + omega * (21.0 + 7.0 * omega)
    assert rounding == pytest.approx(2.0 * BIT * terms)


@pytest.mark.parametrize("released", [None, 0, 2])
def test_a_force_stays_positive_where_the_kernel_sees_no_release(monkeypatch, released):
    made = force_of(monkeypatch)
    made.system.constants = lambda *of: ("const", *of)
    asked = []

    def release(cam, const, i, start):
        asked.append((cam, const, i, start))
        return i == released, "phase"

    monkeypatch.setattr(force, "find_detachment", release)
    const = ("const", 300.0, 1e-9, 1)
    assert made.stays_positive(Region("A", (0, 2)), 300.0) is (released is None)
    calls = [(CAM, const, 0, 0.5), (CAM, const, 2, 3.0)]
    assert asked == (calls[:1] if released == 0 else calls)

    def no_doubles(*of):
        raise SceneError(Fault("rpm", "", "too slow", "", ""))

    made.system.constants = no_doubles
    assert made.stays_positive(Region("A", (0, 2)), 300.0) is False


def test_a_curve_of_the_force_has_both_sides_of_each_corner(monkeypatch):
    """At least so many points a turn; a seat is not pressed by the lobe."""
    made = force_of(monkeypatch)
    made.newton = lambda i, theta, omega: 10.0 * i + theta + omega / RPM
    made.weakest = lambda rpm: (rpm, 7, 8.0)
    monkeypatch.setattr(force, "lift_at", lambda cam, i, theta: (i, theta, 9.0))
    hertz = Stub(pressure=lambda n, i, theta, c2: (n, i, theta, c2))
    curve = made.curve(300.0, points=6, hertz=hertz)  # one a radian
    thetas = [0.5, 1.0, 1.0, 1.0 + 2.0 / 3.0, 1.0 + 4.0 / 3.0, 3.0, 3.0, 3.875, 4.75, 5.625, 6.5]
    stretches = [0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 2]
    assert curve.theta == pytest.approx(thetas)
    assert (curve.theta[1], curve.theta[5], curve.theta[-1]) == (1.0, 3.0, 6.5)
    forces = [10.0 * i + theta + 300.0 for i, theta in zip(stretches, thetas, strict=True)]
    assert curve.force_n == pytest.approx(forces)
    assert (curve.rpm, curve.lowest_n, curve.lowest_theta) == (300.0, 300.0, 8.0)
    for k, (i, theta, n) in enumerate(zip(stretches, curve.theta, curve.force_n, strict=True)):
        assert curve.pressure_pa[k] == (0.0 if i == 1 else (n, i, theta, 9.0))
    assert made.curve(300.0, points=6).pressure_pa == []


def test_a_curve_of_the_force_ends_at_the_very_end_of_a_stretch(monkeypatch):
    """Which the sum of its start and its length misses by rounding."""
    cam = Stub(top=0.25, stretches=[stretch(0.2, 0.9)])
    monkeypatch.setattr(force, "regions", lambda of: [Region("A1", (0,))])
    given = {"mass": 2.0, "gravity": 3.0, "preload": 8.0, "stiffness": 24.0, "damping": 6.0}
    made = Force(Stub(follower=Stub(**given), cam=cam))
    made.newton = made.weakest = lambda *of: (1.0, 2.0, 3.0)
    assert 0.2 + (0.9 - 0.2) != 0.9
    assert made.curve(300.0, points=1).theta[-1] == 0.9


def test_the_highest_of_a_curve_is_told_with_its_phase():
    for values, highest in (([4.0, 2.0, 3.0], (4.0, 0.5)), ([1.0, 2.0, 3.0], (3.0, 2.5))):
        assert ForceCurve(1.0, [0.5, 1.5, 2.5], [9.0] * 3, 1.0, 0.5).highest(values) == highest


# -- the speeds


class Places:
    """A force that is known at a few places: (stretch, phase): what `lost` is there."""

    def __init__(self, known, cam="cam", regions=()):
        self.known, self.cam, self.regions = known, cam, regions
        self.mass, self.a_rounding = 2.0, 1e-3

    def lost(self, i, theta):
        return LostBetween(*self.known[i, theta])

    def lowest(self, f, stretches=None):
        return min(
            (f(i, theta), i, theta)
            for i, theta in self.known
            if stretches is None or i in stretches
        )


@pytest.mark.parametrize(("regained", "fills"), [(inf, 30.0), (30.0, 30.0), (29.0, inf)])
def test_a_region_opens_at_its_first_loss_and_is_filled_at_its_last(monkeypatch, regained, fills):
    """Unless contact comes back somewhere before that."""
    known = {(0, 1.0): (5.0, inf), (1, 2.0): (20.0, inf), (1, 3.0): (10.0, regained),
             (2, 4.0): (30.0, inf), (3, 5.0): (40.0, 41.0)}  # fmt: skip
    monkeypatch.setattr(detachment, "_critical", lambda *of: of)
    region = Region("A", (1, 2))
    made = Places(known)
    loss = detachment._loss(made, region)
    assert (loss.region, loss.stretch) == (region, 1)
    assert loss.opens == (made, CriticalQuantity.OPENS, region, 1, 3.0, 10.0)
    assert loss.fills == (made, CriticalQuantity.FILLS, region, 2, 4.0, fills)


@pytest.mark.parametrize("quantity", [CriticalQuantity.OPENS, CriticalQuantity.FILLS])
@pytest.mark.parametrize(("below", "above", "stays", "known"), [
    (1.0, -1.0, True, True), (1.0, 0.0, True, True), (1.0, 1.0, True, False),
    (0.0, -1.0, True, False), (-1.0, -1.0, True, False), (1.0, -1.0, False, None),
])  # fmt: skip
def test_a_critical_speed_has_the_force_on_both_its_sides(quantity, below, above, stays, known):
    """Where a region opens, the force stays above zero in all of it at the lower end."""
    rpm = 300.0
    low, high = rpm * (1.0 - 1e-12), rpm * (1.0 + 1e-12)
    asked = []

    def newton(i, theta, omega):
        asked.append((i, theta, omega))
        return below if omega < rpm * RPM else above

    def stays_positive(region, at):
        assert (region.name, at) == ("A", low)
        return stays

    made = Stub(newton=newton, stays_positive=stays_positive)
    found = detachment._critical(made, quantity, Region("A", (1,)), 1, 4.0, rpm * RPM)
    assert [omega for *_, omega in asked] == pytest.approx([low * RPM, high * RPM], rel=1e-14)
    assert {of[:2] for of in asked} == {(1, 4.0)}
    is_known = (quantity == CriticalQuantity.FILLS) if known is None else known
    status = SpeedStatus.OK if is_known else SpeedStatus.UNRESOLVED
    assert found == CriticalSpeed(quantity, "A", 4.0, pytest.approx(rpm), pytest.approx(low),
                                  pytest.approx(high), status)  # fmt: skip
    assert found.low < found.rpm < found.high
    for omega, alone in ((0.0, SpeedStatus.STANDSTILL), (inf, SpeedStatus.NEVER)):
        nothing = detachment._critical(made, quantity, Region("A", (1,)), 1, 4.0, omega)
        assert nothing == CriticalSpeed(quantity, "A", 4.0, omega, omega, omega, alone)


def opening(status=SpeedStatus.OK, rpm=300.0, theta=1.0, name="A"):
    speed = CriticalSpeed(CriticalQuantity.OPENS, name, theta, rpm, rpm, rpm, status)
    return Stub(opens=speed, name=name)


@pytest.mark.parametrize(("weakest", "told"), [
    (-5.0, -5.0), (-2.1e-3, -2.1e-3), (-1.9e-3, 0.0), (1.9e-3, 0.0), (2.1e-3, 2.1e-3),
])  # fmt: skip
def test_why_contact_is_lost_at_any_speed(weakest, told):
    """Each kink at which the slope drops, and a force at standstill; rounding is none."""
    asked = []
    jumps = (-0.5, 0.25, 0.0, -0.125)
    made = Stub(
        cam=Stub(stretches=[Stub(slope_jump=jump) for jump in jumps]),
        starts=[0.0, 1.0, 2.0, 3.0], mass=2.0, a_rounding=1e-3,
        weakest=lambda rpm: (asked.append(rpm), (weakest, 7, 4.0))[1],
    )  # fmt: skip
    kinks = (AlwaysLost(Reason.KINK, 0.0, 0.5), AlwaysLost(Reason.KINK, 3.0, 0.125))
    assert detachment._always(made, [opening(), opening(SpeedStatus.NEVER)]) == kinks
    assert asked == []
    losses = [opening(), opening(SpeedStatus.STANDSTILL)]
    assert detachment._always(made, losses) == (*kinks, AlwaysLost(Reason.FORCE, 4.0, told))
    assert asked == [0.0]


@pytest.mark.parametrize(("rpms", "first"), [
    ([300.0, 200.0, 200.0 * (1.0 - 0.9e-12), inf, 0.0], 1),  # the first that is as slow
    ([300.0, 200.0, 200.0 * (1.0 - 1.2e-12), inf, 0.0], 2),
    ([inf, 0.0], None),
    ([300.0, 200.0], 1),
])  # fmt: skip
@pytest.mark.parametrize("always", [(), ("why",)])
def test_the_first_detachment_is_the_first_region_that_opens(monkeypatch, rpms, first, always):
    losses = {k: opening(rpm=rpm, name=f"A{k}") for k, rpm in enumerate(rpms)}
    monkeypatch.setattr(detachment, "Force", lambda system: Stub(regions=list(losses)))
    monkeypatch.setattr(detachment, "_loss", lambda made, region: losses[region])
    monkeypatch.setattr(detachment, "_always", lambda made, known: always)
    found = detachment._detachment("system")
    assert (found.losses, found.always) == (tuple(losses.values()), always)
    if always or first is None:
        assert found.first is None
    else:
        assert (found.first.region, found.first.rpm) == (f"A{first}", rpms[first])
        assert found.first.quantity == CriticalQuantity.FIRST_DETACHMENT


def test_a_share_of_the_error_is_that_of_its_part_of_the_turn():
    errors = (0.25, 0.75, 1.5)
    shared = detachment._shared(errors, -0.5)
    for theta, error in ((0.0, 0.25), (2.0, 0.25), (2.1, 0.75), (4.1, 0.75), (4.2, 1.5),
                         (TURN, 1.5)):  # fmt: skip
        assert shared(theta) == -0.5 * error


def test_a_first_loss_is_that_of_the_machine_with_its_error(monkeypatch):
    """The range of a measured cam ends where a rougher fit is weakest, as it is or pressed."""
    errors = (0.25, 0.75)
    losing = {  # by the machine and the share of the error, at phases of one stretch
        ("fit", -1.0): {1.0: 6.0, 2.0: 7.0, 3.0: 8.0},
        ("fit", 0.5): {1.0: 9.0, 2.0: 8.5, 3.0: 9.0},
        ("fit", 1.0): {1.0: 20.0, 2.0: 21.0, 3.0: 22.0},
        ("rough", 0.0): {1.0: 9.0, 2.0: 10.0, 3.0: 8.0},
        ("rough", 1.0): {1.0: 9.0, 2.0: 8.0, 3.0: 9.0},
    }
    monkeypatch.setattr(detachment, "stretch_at", lambda cam, theta: 7 if cam == "cam" else 9)
    monkeypatch.setattr(
        detachment, "_shared", lambda given, share: share if given == errors else None
    )
    monkeypatch.setattr(
        detachment, "Force", lambda system, share: Places(
            {(7, theta): (lost, inf) for theta, lost in losing[system.name, share].items()}
        )
    )  # fmt: skip
    fit, rough = Stub(name="fit", cam="cam"), Stub(name="rough", cam="other")
    assert detachment.first_loss(fit, errors, 0.5) == pytest.approx(8.5 / RPM)
    low, high = detachment.loss_range(fit, errors, rough)
    assert low == pytest.approx(6.0 / RPM)
    assert high == pytest.approx(21.0 / RPM)  # 22 where the rough fit is weakest, 21 if pressed
    losing["rough", 0.0] = {1.0: 7.0, 2.0: 10.0, 3.0: 8.0}
    assert detachment.loss_range(fit, errors, rough)[1] == pytest.approx(20.0 / RPM)


# -- the whole study


def speed_of(name, status=SpeedStatus.OK, rpm=300.0, quantity=CriticalQuantity.OPENS):
    return CriticalSpeed(quantity, name, 1.0, rpm, rpm, rpm, status)


def told(name, **more):
    """A property of the result of a study with these fields."""
    fields = {"ends": (), "landings": (), "speeds": (), "past": ()}
    made = Stub(**{**fields, **more})
    for other in ("accumulation", "jumps"):
        setattr(made, other, getattr(ContactLoss, other).fget(made))
    return getattr(ContactLoss, name).fget(made)


def test_ends_of_chatters_and_landings_are_told_by_their_status():
    kinds = list(SpeedStatus)
    ends = [speed_of(str(kind), kind) for kind in kinds]
    assert told("accumulation", ends=ends) == [
        one for one in ends if one.status != SpeedStatus.JUMP
    ]
    assert told("jumps", ends=ends) == [one for one in ends if one.status == SpeedStatus.JUMP]
    assert told("hits", landings=ends) == [one for one in ends if one.status == SpeedStatus.OK]
    assert told("ended", landings=ends) == [one for one in ends if one.status != SpeedStatus.OK]


def test_critical_speeds_come_in_the_order_of_their_table():
    """The first one, then each region's two, then where chatters end and complete no longer."""
    losses = [
        Stub(opens=speed_of("o1"), fills=speed_of("f1", SpeedStatus.NEVER, inf)),
        Stub(opens=speed_of("o2", SpeedStatus.STANDSTILL, 0.0), fills=speed_of("f2")),
    ]
    ends = (speed_of("e1"), speed_of("e2", SpeedStatus.JUMP), speed_of("e3"))
    more = {"ends": ends, "completion": (speed_of("c1"),)}
    for first, names in ((speed_of("first"), ["first"]), (None, [])):
        lost = Stub(first=first, losses=losses)
        found = told("critical_speeds", detachment=lost, **more)
        assert [one.region for one in found] == [*names, "o1", "f1", "f2", "e1", "e3", "c1"]


def test_speeds_in_trouble_are_those_of_both_simulations():
    def motions(*of):
        return [Stub(rpm=rpm, status=status) for rpm, status in of]

    speeds = motions((1.0, Status.OK), (2.0, Status.NO_RETURN), (3.0, Status.FAULT))
    past = motions((4.0, Status.IMPACT_BUDGET), (5.0, Status.OK))
    assert told("troubled", speeds=speeds, past=past) == [
        (2.0, Status.NO_RETURN), (3.0, Status.FAULT), (4.0, Status.IMPACT_BUDGET)
    ]  # fmt: skip


def lost_in(*regions, first="A1"):
    losses = [
        Stub(region=Stub(name=name), opens=Stub(rpm=opens, finite=opens < inf, theta=7.0),
             fills=Stub(rpm=fills))
        for name, opens, fills in regions
    ]  # fmt: skip
    return Stub(losses=losses, first=first and Stub(region=first))


@pytest.mark.parametrize(("asked", "pressure", "working", "hold", "speeds"), [
    (None, False, None, None, [100.0, 150.0, 175.0, 200.0]),
    (None, False, 120.0, None, [100.0, 120.0, 150.0, 175.0, 200.0]),
    (None, False, 50.0, 300.0, [50.0, 100.0, 150.0, 175.0, 200.0, 300.0]),
    (None, False, 200.0, None, [100.0, 150.0, 175.0, 200.0]),
    (None, False, 201.0, 160.0, [100.0, 150.0, 160.0, 175.0, 200.0]),  # faster than the range
    (None, True, None, None, [STANDSTILL, 100.0, 150.0, 175.0, 200.0]),
    ([190.0, 110.0, 190.0], True, 120.0, None, [190.0, 110.0]),
    ([190.0, 110.0], False, 120.0, 130.0, [190.0, 110.0, 130.0]),
    ([190.0, 110.0], False, 120.0, 190.0, [190.0, 110.0]),
    ([], False, None, 130.0, [130.0]),
])  # fmt: skip
def test_of_which_speeds_the_force_is_shown(asked, pressure, working, hold, speeds):
    """The ends of the range, what is within it of the region that opens first, and others."""
    lost = lost_in(("A0", 160.0, 165.0), ("A1", 150.0, 175.0))
    rpms = [200.0, 130.0, 100.0]
    assert study._force_speeds(lost, rpms, asked, pressure, working, hold) == speeds


def test_speeds_of_a_loss_outside_the_range_are_not_shown():
    for opens, fills, within in ((100.0, 200.0, []), (90.0, 201.0, []), (101.0, inf, [101.0]),
                                 (50.0, 199.0, [199.0])):  # fmt: skip
        lost = lost_in(("A1", opens, fills))
        found = study._force_speeds(lost, [100.0, 200.0], None, False, None, None)
        assert found == [100.0, *within, 200.0]
    nowhere = lost_in(("A1", 150.0, 160.0), first=None)
    assert study._force_speeds(nowhere, [100.0, 200.0], None, False, None, None) == [100.0, 200.0]


class Pieces:
    """Notes the pieces of work, of which some fail."""

    def __init__(self, monkeypatch, *failing):
        self.names, self.failing = [], failing
        monkeypatch.setattr(study, "piece", self)

    def __call__(self, name, what, without=None):
        self.names.append(name)
        return without if name in self.failing else what()


def test_curves_of_the_force_are_pieces_of_their_own(monkeypatch):
    pieces = Pieces(monkeypatch, "the contact force at 200 rpm")
    made = Stub(curve=lambda rpm, hertz: (rpm, hertz))
    monkeypatch.setattr(study, "Force", lambda system: made if system == "system" else None)
    found = study._force_curves("system", [100.0, 200.0, 300.5], "hertz")
    assert found == ((100.0, "hertz"), (300.5, "hertz"))
    assert pieces.names == [f"the contact force at {rpm} rpm" for rpm in ("100", "200", "300.5")]


@pytest.mark.parametrize(
    "failing",
    [(), ("the springs that hold to 300 rpm",), ("the contact force with other springs",)],
)
@pytest.mark.parametrize(("margin", "precompression"), [(None, None), (0.0, 0.0), (9.0, 0.25)])
def test_springs_that_hold_are_told_with_the_force_they_leave(
    monkeypatch, failing, margin, precompression
):
    """Of the machine as it is first; a spring that is none has no curve."""
    holds = [Stub(stiffness=5.0, preload=6.0), Stub(stiffness=None, preload=None),
             Stub(stiffness=7.0, preload=0.0)]  # fmt: skip
    Pieces(monkeypatch, *failing)
    errors = (0.5, 1.5)
    given = ("system", 300.0)
    monkeypatch.setattr(study, "usual_margin", lambda *of: 4.0 if of == (*given, errors) else None)
    monkeypatch.setattr(study, "usual_precompression", lambda of: 0.75 if of == "system" else None)
    asked = []
    monkeypatch.setattr(study, "hold_to", lambda *of: (asked.append(of), holds)[1])
    monkeypatch.setattr(study, "replaced", lambda *of: of)
    monkeypatch.setattr(study, "Force", lambda of: Stub(curve=lambda rpm: (of, rpm)))
    found = study._springs_to(*given, margin, precompression, accel_error=errors, solid=0.125)
    used = (4.0 if margin is None else margin, 0.75 if precompression is None else precompression)
    assert found.margin == used[0]
    no_holds = any("hold to" in name for name in failing)
    assert asked == ([] if no_holds else [(*given, *used, errors, 0.125)])
    assert found.holds == (() if no_holds else tuple(holds))
    curves = [(None, ("system", 300.0))]
    if not no_holds:
        curves += [(holds[k], (("system", holds[k].stiffness, holds[k].preload), 300.0))
                   for k in (0, 2)]  # fmt: skip
    assert found.curves == (() if any("force" in name for name in failing) else tuple(curves))


def test_bursts_are_followed_in_each_region_that_opens_at_a_speed(monkeypatch):
    pieces = Pieces(monkeypatch, "the chatter from region A3")
    made = []

    class Machine:
        def __init__(self, *of):
            made.append(of)
            self.cost = Cost(len(made), 10, 0)

    monkeypatch.setattr(study, "Bursts", Machine)
    chatter = study._ChatterChanges(["motion"], 6)
    followed = []

    def follow(bursts, loss):
        followed.append((bursts.cost.impacts, loss.region.name))
        if loss.region.name == "A1":
            raise BudgetSpentError

    chatter.follow = follow
    lost = lost_in(("A1", 100.0, inf), ("A2", inf, inf), ("A3", 200.0, inf), ("A4", 300.0, inf))
    cost = chatter.follow_all("system", lost, 50)
    assert made == [("system", f"A{k}", 7.0, 50) for k in (1, 3, 4)]
    assert followed == [(1, "A1"), (3, "A4")]
    assert pieces.names == [f"the chatter from region A{k}" for k in (1, 3, 4)]
    assert cost == Cost(6, 30, 0)
    lost.first = None
    assert chatter.follow_all("system", lost, 50) == Cost()
    assert len(made) == 3


def test_what_happens_to_bursts_is_asked_corner_by_corner(monkeypatch):
    """Landings are followed from the first speed at which a chatter reaches the corner on."""
    monkeypatch.setattr(study, "lift_off", lambda *of: ("lift-off", *of))
    monkeypatch.setattr(
        study, "scan_speeds",
        lambda *of: [110.0, 120.0, 190.0] if of == (100.0, "A1", ["motion"]) else None,
    )  # fmt: skip
    monkeypatch.setattr(
        study, "corners_ahead", lambda of: [("a", 1.0), ("b", 2.0), ("c", 3.0)] if of == "bursts"
        else None,
    )  # fmt: skip
    ends = {"a": [Stub(low=111.0), Stub(low=115.0)], "b": [], "c": [Stub(low=130.0)]}
    asked = []

    def reaching(*of):
        asked.append(of)
        return iter(ends[of[1]])

    monkeypatch.setattr(study, "reaching", reaching)
    monkeypatch.setattr(study, "corner_hits", lambda *of: iter([of]))
    monkeypatch.setattr(study, "completion_loss", lambda *of: iter([of]))
    chatter = study._ChatterChanges(["motion"], 6)
    loss = Stub(opens=Stub(rpm=100.0), region=Stub(name="A1"))
    for again in (1, 2):  # what is there already stays
        chatter.follow("bursts", loss)
        speeds = [110.0, 120.0, 190.0]
        assert chatter.lift_offs == [("lift-off", "bursts", loss)] * again
        corners = (("a", 1.0), ("b", 2.0), ("c", 3.0))
        assert asked == [("bursts", *corner, speeds) for corner in corners] * again
        assert chatter.ends == [*ends["a"], *ends["c"]] * again
        assert chatter.landings == [
            ("bursts", "a", 1.0, 111.0, 190.0, 6), ("bursts", "c", 3.0, 130.0, 190.0, 6)
        ] * again  # fmt: skip
        assert chatter.completion == [("bursts", speeds)] * again


def test_motions_past_the_loss_are_simulated_as_far_as_the_budget_goes(monkeypatch):
    def motion(*of):
        if of[1] == 300.0:
            raise BudgetSpentError
        return of

    work = []
    monkeypatch.setattr(study, "motion_past", motion)
    monkeypatch.setattr(study.backend, "for_work", lambda *of: work.append(of))
    monkeypatch.setattr(study, "detachment", lambda system: ("lost", system))
    monkeypatch.setattr(
        study, "_past_speeds",
        lambda *of: [100.0, 200.0, 300.0, 400.0] if of == (("lost", "system"), "rpms", 5) else None,
    )  # fmt: skip
    found = study.past_motions("system", "rpms", "settings", 5)
    assert found == (("system", 100.0, "settings"), ("system", 200.0, "settings"))
    assert work == [(2 * 20 * 5, 4000)]


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("other", [None, Stub(cost=Cost(10, 20, 30))])
def test_a_motion_past_the_loss_is_measured_over_its_whole_turns(monkeypatch, fails, other):
    """Another motion that only names it is paid for, too."""
    pieces = Pieces(monkeypatch, *(["the motion at 300.5 rpm, past the loss of contact"] * fails))
    monkeypatch.setattr(study, "with_turns", lambda *of: ("turns", *of))
    record = Stub(impacts=[1, 2, 4, 8], periods=3, status=Status.NO_RETURN, cost=Cost(1, 2, 3))
    orbit = Stub(run=lambda: record)
    monkeypatch.setattr(
        study, "Orbit",
        lambda *of: orbit if of == ("system", 300.5, ("turns", "settings", 20, 20)) else None,
    )  # fmt: skip
    monkeypatch.setattr(
        study,
        "named_on",
        lambda *of: ("P(1;1)", 7, other or record) if of == (orbit, 300.5, record) else None,
    )
    monkeypatch.setattr(study, "loads_of", lambda *of: of)
    found = study.motion_past("system", 300.5, "settings")
    assert len(pieces.names) == 1
    assert (found.value, found.rpm, found.impacts, found.strobe) == (300.5, 300.5, None, None)
    told_of = (found.label, found.impact_count, found.status, found.cost)
    if fails:
        assert told_of == (UNDECIDED, None, Status.FAULT, Cost())
    else:
        cost = Cost(11, 22, 33) if other else Cost(1, 2, 3)
        assert told_of == ("P(1;1)", 7, Status.NO_RETURN, cost)
        assert found.loads == ("system", 300.5, record)


@pytest.mark.parametrize(("rpms", "scans"), [
    ([100.0], False), ([200.0, 100.0, 150.0], True), ([100.0 + k for k in range(40)], True),
    ([100.0 + k for k in range(41)], False),
])  # fmt: skip
@pytest.mark.parametrize(
    ("hold", "margin"), [(None, None), (None, 5.0), (300.0, 5.0), (300.0, None)]
)
def test_a_study_of_the_loss_is_put_together(monkeypatch, rpms, scans, hold, margin):
    """Changes are looked for between 41 speeds at least; what each part costs is counted once."""
    settings = Settings(9, 8, 1e-7, 40)
    lost = Stub(first=None, losses=())
    asked = Stub(work=[], motions=[], chatter=[], curves=[], springs=[])

    def motions(system, at, of, settle, on_speed=None):
        asked.motions.append((system, list(at), of, settle, on_speed))
        return [Stub(rpm=rpm, cost=Cost(1, 0, 0)) for rpm in at]

    def chatter(scan, impacts):
        made = Stub(lift_offs=["l"], ends=["e"], completion=["c"], landings=["h"])
        made.follow_all = lambda *of: (asked.chatter.append(([m.rpm for m in scan], impacts, *of)),
                                       Cost(0, 1000, 0))[1]  # fmt: skip
        return made

    def springs(*of, **more):
        asked.springs.append((of, more))
        return study._Springs(("hold",), ("curve",), 7.0)

    past = (Stub(cost=Cost(0, 0, 5)), Stub(cost=Cost(0, 0, 6)))
    monkeypatch.setattr(study.backend, "for_work", lambda *of: asked.work.append(of))
    monkeypatch.setattr(study, "detachment", lambda system: lost)
    monkeypatch.setattr(study, "settled_motions", motions)
    monkeypatch.setattr(study, "_ChatterChanges", chatter)
    monkeypatch.setattr(study, "_past_speeds", lambda *of: ["past", *of])
    monkeypatch.setattr(
        study, "_motions_past",
        lambda *of: past if of == ("system", ["past", lost, rpms], settings) else None,
    )  # fmt: skip
    monkeypatch.setattr(study, "_springs_to", springs)
    monkeypatch.setattr(study, "_force_speeds", lambda *of: of)
    monkeypatch.setattr(study, "_force_curves", lambda *of: (asked.curves.append(of), ("f",))[1])
    found = study.detach(
        "system", rpms, settings, settle=4, impacts=6, force_speeds=[9.0], hold_speed=hold,
        margin=margin, precompression=0.25, accel_error=(0.5,), solid=0.125, hertz="hertz",
        working_speed=50.0, on_speed="tick",
    )  # fmt: skip
    assert asked.work == [(len(rpms) * 6, 4000)]
    assert asked.motions[0] == ("system", rpms, settings, 4, "tick")
    scanned = rpms
    if scans:
        (_, scanned, *more) = asked.motions[1]
        assert more == [settings, 4, None]
        assert len(scanned) == 41
        assert (scanned[0], scanned[-1]) == (min(rpms), max(rpms))
    assert len(asked.motions) == 1 + scans
    assert asked.chatter == [(scanned, 6, "system", lost, 40)]
    assert [speed.rpm for speed in found.speeds] == rpms
    assert found.cost == Cost(len(rpms) + (41 if scans else 0), 1000, 11)
    assert (found.lift_offs, found.ends, found.completion, found.landings) == (
        ("l",), ("e",), ("c",), ("h",),
    )  # fmt: skip
    assert (found.detachment, found.past, found.forces) == (lost, past, ("f",))
    of_force = (lost, rpms, [9.0], True, 50.0, hold)
    assert asked.curves == [("system", of_force, "hertz")]
    if hold is None:
        assert asked.springs == []
        assert (found.holds, found.springs, found.margin) == ((), (), margin or 0.0)
    else:
        assert asked.springs == [
            (("system", 300.0, margin, 0.25), {"accel_error": (0.5,), "solid": 0.125})
        ]
        assert (found.holds, found.springs, found.margin) == (("hold",), ("curve",), 7.0)
    assert (found.at_work, found.at_asked) == (None, None)
