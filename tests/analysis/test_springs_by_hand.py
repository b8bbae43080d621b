"""Which spring holds, from the force that each phase asks for, on turns of a few phases by hand."""

from __future__ import annotations

from math import inf, pi
from types import SimpleNamespace as Stub

import pytest

from camcli.analysis.contact_loss import hold
from camcli.analysis.contact_loss.detachment import CriticalQuantity, Reason
from camcli.analysis.contact_loss.hold import HoldStatus, Need, Obstacle

BOTH = CriticalQuantity.HOLD_BOTH


class Turn(Need):
    """A turn of a few phases: of stretch k, at k + 1 rad, (force needed N, lift m)."""

    def __init__(self, *phases, stiffness=4.0, preload=3.0, margin=3.0, highest=1.25):
        self.phases = phases
        self.margin, self.highest = margin, highest
        self.system = "system"
        self.force = Stub(region_of=lambda i: Stub(name=f"A{i}"))
        self.cam = Stub(top=1.5)
        self.follower = Stub(stiffness=stiffness, preload=preload)

    def at(self, i, theta):
        assert theta == i + 1.0
        return self.phases[i]

    def most(self, f):
        value, i = max((f(*self.at(i, i + 1.0)), -i) for i in range(len(self.phases)))
        return value, -i, 1.0 - i


class Noted(Turn):
    """A turn that only notes the spring that it is to check."""

    def checked(self, *of):
        return hold.Hold(of[0], HoldStatus.OK, region=of)


# -- the force that is needed


@pytest.mark.parametrize(
    ("c1", "c2", "least"),
    [
        (-1.0, 0.5, -4.0 / 6.0),  # the least of -2 omega + 1.5 omega^2, below the speed asked for
        (-1.0, 0.0625, 4.0 * (-2.0 + 4.0 * 0.1875)),  # it lies above that speed
        (-1.0, -0.5, 4.0 * (-2.0 - 4.0 * 1.5)),
        (1.0, -0.5, 4.0 * (2.0 - 4.0 * 1.5)),
        (1.0, 0.5, 0.0),  # at standstill
        (2.0, -0.125, 0.0),
        (0.0, 0.5, 0.0),
    ],
)
def test_a_phase_asks_for_a_force_at_its_worst_speed(monkeypatch, c1, c2, least):
    """Margin less weight, less the least of b omega c' + m omega^2 c'' up to omega = 4 rad/s.

    Errors of the acceleration, in thirds of a turn, are taken off.
    """
    errors = (0.25, 0.75, 1.5)
    need = Need.__new__(Need)
    need.margin, need.accel_error, need.omega, need.cam = 7.0, errors, 4.0, "cam"
    need.follower = Stub(damping=2.0, mass=3.0, gravity=5.0)
    for theta, error in ((0.0, 0.25), (2.0, 0.25), (2.2, 0.75), (4.3, 1.5), (2.0 * pi, 1.5)):
        monkeypatch.setattr(
            hold, "lift_at", lambda *of, theta=theta, error=error: (
                (0.125, c1, c2 + error) if of == ("cam", 6, theta) else None
            )
        )  # fmt: skip
        assert need.at(6, theta) == (pytest.approx(7.0 - 15.0 - least), 0.125)


def test_the_largest_value_is_told_with_its_place():
    need = Need.__new__(Need)
    need.at = lambda i, theta: (10.0 * i, theta)
    need.force = Stub(lowest=lambda f: (f(3, 0.5), 7, 8.0))
    assert need.most(lambda force, c: force + c) == (30.5, 7, 8.0)


def test_the_usual_margin_is_a_tenth_of_the_largest_force(monkeypatch):
    asked = []

    def need_of(largest):
        def made(*of):
            asked.append(of)
            return Stub(most=lambda f: (f(largest, "c"), 7, 8.0))

        return made

    for largest, margin in ((250.0, 25.0), (-5.0, 0.0)):
        monkeypatch.setattr(hold, "Need", need_of(largest))
        assert hold.usual_margin("system", 700.0, (0.5, 1.5)) == margin
    assert asked == [("system", 700.0, 0.0, (0.5, 1.5))] * 2


# -- the least stiffness


def test_the_least_stiffness_is_the_largest_that_a_phase_asks_for():
    """A spring compressed by 0.5 m at c = 0, with 2 N besides: (12 - 2)/2, (10 - 2)/1."""
    turn = Noted((12.0, 1.5), (10.0, 0.5), (1.5, -0.5), (-7.0, -1.5))
    assert turn.least_stiffness(BOTH, 2.0, 0.5).region == (BOTH, 8.0, 6.0, True, 1, 2.0)
    turn = Noted((12.0, 1.5), (1.0, 0.5), (1.5, -0.5))
    assert turn.least_stiffness(BOTH, 2.0, 0.5).region == (BOTH, 5.0, 4.5, True, 0, 1.0)
    # none is needed where the rest of the preload does
    turn = Noted((1.0, 1.5), (1.5, 0.5), (1.5, -0.5))
    assert turn.least_stiffness(BOTH, 2.0, 0.5).region == (BOTH, 0.0, 2.0, False, 0, 1.0)


@pytest.mark.parametrize(
    ("third", "fourth", "place", "obstacle", "missing"),
    [
        (2.75, -7.0, 2, Obstacle.LIFT, 0.75),  # where the spring is not compressed
        (1.5, -5.0, 3, Obstacle.PULL, 0.0),  # one of 8 N/m pulls by 8 N, and 7 N more are there
        (2.75, -5.0, 3, Obstacle.PULL, 0.0),  # the worse of the two
        (2.75, -5.5, 2, Obstacle.LIFT, 0.75),
        (1.5, 2.5, 3, Obstacle.LIFT, 0.5),  # it would pull, but force is missing anyhow
    ],
)
def test_a_phase_at_which_no_stiffness_helps_says_why(third, fourth, place, obstacle, missing):
    turn = Noted((12.0, 1.5), (10.0, 0.5), (third, -0.5), (fourth, -1.5))
    found = turn.least_stiffness(BOTH, 2.0, 0.5)
    assert (found.quantity, found.status) == (BOTH, HoldStatus.IMPOSSIBLE)
    assert (found.region, found.theta) == (f"A{place}", place + 1.0)
    assert (found.obstacle, found.missing_n) == (obstacle, missing)
    assert (found.stiffness, found.preload, found.detaches) == (None, None, None)


def test_a_force_that_is_missing_by_rounding_is_not_missing():
    """1e-12 of margin, preload and spring force at the top together: 3 + 2 + 8 (1.5 + 0.5) N."""
    for lack, status in ((2.0e-11, HoldStatus.OK), (2.2e-11, HoldStatus.IMPOSSIBLE)):
        for third in ((2.0 + lack, -0.5), (-6.0 + lack, -1.5)):
            turn = Noted((12.0, 1.5), (10.0, 0.5), third)
            assert turn.least_stiffness(BOTH, 2.0, 0.5).status == status
    pulls = Noted((12.0, 1.5), (10.0, 0.5), (-5.0, -1.5)).least_stiffness(BOTH, 2.0, 0.5)
    assert pulls.obstacle == Obstacle.PULL
    barely = Noted((12.0, 1.5), (10.0, 0.5), (2.0 + 1e-15, -2.0)).least_stiffness(BOTH, 2.0, 0.5)
    assert barely.obstacle == Obstacle.PULL  # rounding of what is lacking, 12 N


# -- the least preload


@pytest.mark.parametrize(
    ("forces", "more", "given", "solid", "missing"),
    [
        # force less 4 N/m times lift; 3 N are there
        ((12.0, 10.0), {}, (4.0, 8.0, True, 1), 2.5, None),  # 5 N more: 1.25 m above 1.25 m
        ((12.0, 10.0), {}, (4.0, 8.0, True, 1), 2.25, 0.25),
        ((16.0, 10.0), {}, (4.0, 10.0, True, 0), 3.0, None),
        ((12.0, 10.0), {"preload": 8.0}, (4.0, 8.0, True, 1), 1.25, None),
        ((12.0, 10.0), {"preload": 9.0}, (4.0, 8.0, True, 1), 1.25, None),
        ((12.0, 10.0), {"preload": 9.0}, (4.0, 8.0, True, 1), 1.0, 0.25),
        ((2.0, 1.0), {}, (4.0, 0.0, False, 1), 1.25, None),
        ((12.0, 10.0), {"stiffness": 0.0}, (0.0, 12.0, True, 0), 1.25, None),
        ((12.0, 10.0), {"stiffness": 0.0}, (0.0, 12.0, True, 0), 1.125, 0.125),
    ],
)
def test_the_least_preload_is_the_largest_asked_for(forces, more, given, solid, missing):
    turn = Noted((forces[0], 1.5), (forces[1], 0.5), **more)
    found = turn.least_preload(solid)
    stiffness, preload, needed, place = given
    quantity = CriticalQuantity.HOLD_PRELOAD
    assert found.quantity == quantity
    assert found.region == (quantity, stiffness, preload, needed, place, place + 1.0)
    least = max(force - stiffness * c for force, c in zip(forces, (1.5, 0.5), strict=True))
    assert found.more is (least > turn.follower.preload)
    if missing is None:
        assert (found.status, found.obstacle, found.missing_n) == (HoldStatus.OK, None, None)
    else:
        assert (found.status, found.obstacle) == (HoldStatus.IMPOSSIBLE, Obstacle.SOLID)
        assert found.missing_n == pytest.approx(missing)


# -- the answer


@pytest.mark.parametrize(
    ("spring", "needed", "status", "more"),
    [
        ((5.0, 6.0), True, HoldStatus.OK, True),
        ((4.0, 6.0), True, HoldStatus.OK, False),
        ((5.0, 6.0), False, HoldStatus.NOT_NEEDED, True),
        ((3.0, 6.0), True, HoldStatus.OK, False),
        ((5.0, 20.0 * 8.0 - 6.25), True, HoldStatus.OK, True),  # of the nose's 4 1.25 + 3 N
        ((5.0, 20.0 * 8.0 - 6.2), True, HoldStatus.ABSURD, True),
        ((5.0, 20.0 * 8.0 - 6.2), False, HoldStatus.NOT_NEEDED, True),
    ],
)
@pytest.mark.parametrize("lost", ["first", "always", "never"])
def test_a_spring_is_told_with_the_speed_to_which_it_holds(
    monkeypatch, spring, needed, status, more, lost
):
    turn = Turn((12.0, 1.5), (10.0, 0.5), (1.5, -0.5))
    first = Stub(rpm=800.0, low=799.0, high=801.0) if lost == "first" else None
    asked = []

    def detachment(system):
        asked.append(system)
        return Stub(first=first, always=("why",) if lost == "always" else ())

    monkeypatch.setattr(hold, "detachment", detachment)
    monkeypatch.setattr(hold, "replaced", lambda *of: of)
    k, preload = spring
    found = turn.checked(BOTH, k, preload, needed, 2, 7.0)
    assert asked == [("system", k, preload)]
    assert (found.quantity, found.status, found.more) == (BOTH, status, more)
    assert (found.stiffness, found.preload) == spring
    assert (found.region, found.theta) == (("A2", 7.0) if needed else ("", None))
    never = {"always": None, "never": inf}.get(lost)
    assert (found.detaches, found.low, found.high) == (
        (800.0, 799.0, 801.0) if lost == "first" else (never,) * 3
    )
    least = min(k * c + preload + 3.0 - force for force, c in turn.phases)
    assert found.least_n == pytest.approx(least)
    assert found.nose_n == pytest.approx(k * 1.25 + preload)
    assert (found.obstacle, found.missing_n) == (None, None)


def test_no_spring_is_absurd_where_the_present_one_does_not_press_at_the_nose(monkeypatch):
    monkeypatch.setattr(hold, "detachment", lambda system: Stub(first=None, always=()))
    monkeypatch.setattr(hold, "replaced", lambda *of: of)
    for preload in (-5.0, -6.0):  # of 5 N at the nose
        turn = Turn((12.0, 1.5), stiffness=4.0, preload=preload)
        assert turn.checked(BOTH, 500.0, 600.0, True, 0, 1.0).status == HoldStatus.OK


@pytest.mark.parametrize("kinks", [0, 1])
def test_three_springs_are_answers_but_where_the_cam_throws(monkeypatch, kinks):
    reasons = [Stub(reason=Reason.FORCE), *[Stub(reason=Reason.KINK)] * kinks]
    monkeypatch.setattr(hold, "detachment", lambda system: Stub(always=reasons))
    made = []

    def need(*of):
        made.append(of)
        return Stub(
            least_stiffness=lambda *given: ("stiffness", *given),
            least_preload=lambda solid: ("preload", solid),
        )

    monkeypatch.setattr(hold, "Need", need)
    system = Stub(follower=Stub(preload=7.0))
    found = hold.hold_to(system, 700.0, 9.0, 0.25, (0.5, 1.5), 0.125)
    stiffness, _, both = kinds = (
        CriticalQuantity.HOLD_STIFFNESS, CriticalQuantity.HOLD_PRELOAD, BOTH,
    )  # fmt: skip
    if kinks:
        assert [(one.quantity, one.status, one.obstacle) for one in found] == [
            (kind, HoldStatus.IMPOSSIBLE, Obstacle.KINK) for kind in kinds
        ]
        assert made == []
        return
    assert made == [(system, 700.0, 9.0, (0.5, 1.5))]
    assert found == [("stiffness", stiffness, 7.0, 0.0), ("preload", 0.125),
                     ("stiffness", both, 0.0, 0.25)]  # fmt: skip
