"""Bursts of impacts and the speeds at which they change, on records that are written by hand."""

from __future__ import annotations

from math import inf, pi
from types import SimpleNamespace as Stub

import pytest

from camcli.analysis.contact_loss import accumulation, bursts
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.bursts import (
    Burst,
    Bursts,
    LiftOffKind,
    SettledBurst,
    SettledMotion,
)
from camcli.analysis.contact_loss.detachment import CriticalQuantity, CriticalSpeed, SpeedStatus
from camcli.analysis.integrate import BudgetSpentError, Cost, Settings, Start
from camcli.cams.regions import SAME_PHASE
from camcli.errors import Status
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT

TURN = 2.0 * pi
HALF_DEGREE = pi / 360.0


def seen(monkeypatch, *events, stays=()):
    """What a record shows whose events are (kind, period, phase), with the strobe at 1 rad."""
    system = Stub(strobe=1.0)

    def stays_at(of, orbit, theta, u):
        assert (of, orbit, u) == (system, "orbit", -0.5)
        return theta in stays

    monkeypatch.setattr(bursts, "_stays", stays_at)
    record = Stub(events=lambda: [(*event, 7.0, -0.5) for event in events])
    return bursts._bursts(system, "orbit", record)


def test_a_burst_is_the_impacts_after_a_departure_up_to_its_end(monkeypatch):
    """Phases are counted on from the strobe; one that rested unseen ends at its last impact."""
    found = seen(
        monkeypatch,
        (IMPACT, 0, 1.5),  # of a burst from before
        (CHATTER, 0, 2.0),
        (DETACHMENT, 0, 3.0),
        (IMPACT, 0, 4.0),
        (IMPACT, 0, 0.5),  # still before the next strobe
        (DETACHMENT, 0, 0.75),  # it ended unseen
        (DETACHMENT, 1, 1.25),  # without an impact
        (IMPACT, 1, 2.0),  # from which it does not bounce
        (CHATTER, 1, 2.5),  # begun by nothing that is seen
        (IMPACT, 1, 3.0),
        stays=(2.0,),
    )  # fmt: skip
    approx = pytest.approx
    assert found.bursts == [
        Burst(inf, approx(0.5), [approx(0.5)], approx(1.0)),
        Burst(3.0, approx(2.0), [approx(3.0), approx(TURN - 0.5)], approx(TURN - 0.5)),
        Burst(0.75, approx(TURN - 0.25), [], approx(TURN - 0.25)),
        Burst(1.25, approx(TURN + 0.25), [approx(TURN + 1.0), approx(TURN + 2.0)],
              approx(TURN + 1.0)),
    ]  # fmt: skip
    assert found.impacts == [1.5, 4.0, 0.5]
    assert found.rests == [2.0]
    opened = seen(monkeypatch, (CHATTER, 0, 2.0), (IMPACT, 0, 3.0), stays=(3.0,))
    assert opened.rests == [2.0, 3.0]
    assert opened.bursts == [Burst(inf, approx(2.0), [approx(2.0)], approx(2.0))]


@pytest.mark.parametrize(("r", "u", "accel", "stays"), [
    (0.0, -1.0, -2.0, True), (0.5, 0.0, -2.0, True), (0.5, -1.0, -2.0, False),
    (0.0, -1.0, 2.0, False), (0.0, -1.0, 0.0, False),
])  # fmt: skip
def test_a_follower_stays_where_it_does_not_bounce_and_is_pressed(monkeypatch, r, u, accel, stays):
    monkeypatch.setattr(bursts, "stretch_at", lambda *of: ("stretch", *of))
    monkeypatch.setattr(
        bursts, "restitution_at",
        lambda *of: r if of == ("cam", "const", ("stretch", "cam", 1.5)) else None,
    )  # fmt: skip
    monkeypatch.setattr(
        bursts, "contact_accel",
        lambda *of: (accel, 7.0, 8.0) if of[2:] == (("stretch", "cam", 1.5), 1.5) else None,
    )  # fmt: skip
    assert bursts._stays(Stub(cam="cam"), Stub(const="const"), 1.5, u) is stays


class Records:
    """A stand-in for `Orbit`, whose runs end one after the other as a test says."""

    def __init__(self, monkeypatch, *ends):
        self.ends, self.asked = list(ends), []
        monkeypatch.setattr(bursts, "Orbit", self)
        monkeypatch.setattr(bursts, "_bursts", lambda system, orbit, record: record.seen)

    def __call__(self, *of):
        self.asked.append(of)
        return self

    def run(self, strobes):
        assert strobes is False
        found, status = self.ends.pop(0)
        made = bursts._Seen(found, [1.0], [2.0])
        return Stub(seen=made, status=status, cost=Cost(1, 10, 100))


def of_machine(theta=1.5, start=0.25) -> Bursts:
    made = Bursts.__new__(Bursts)
    made.system, made.name, made.theta, made.impact_budget = "system", "A1", theta, 50
    made.cost, made._known = Cost(2, 0, 0), {}
    made._rest_before = lambda omega: start if omega == pi * 4.0 else None
    return made


ENDED = Burst(1.5, 4.0, [4.5, 5.0], 6.0)
GOES_ON = Burst(1.5, 4.0, [4.5, 5.0])
EARLIER, LATER = Burst(inf, 3.0, [3.5], 3.75), Burst(2.5, 7.0, [7.5], 8.0)


@pytest.mark.parametrize(("ends", "turns", "burst"), [
    ([([EARLIER, ENDED, LATER], Status.OK)], [0], Burst(1.5, 1.5, [2.0, 2.5], 3.5)),
    ([([GOES_ON], Status.OK), ([ENDED], Status.OK)], [0, 2], Burst(1.5, 1.5, [2.0, 2.5], 3.5)),
    ([([GOES_ON], Status.OK), ([GOES_ON], Status.OK)], [0, 2], Burst(1.5, 1.5, [2.0, 2.5])),
    ([([GOES_ON], Status.IMPACT_BUDGET)], [0],
     Burst(1.5, 1.5, [2.0, 2.5], status=Status.IMPACT_BUDGET)),
    ([([EARLIER], Status.OK), ([], Status.NO_RETURN)], [0, 2],
     Burst(inf, inf, status=Status.NO_RETURN)),
])  # fmt: skip
@pytest.mark.parametrize(("impacts", "budget"), [(0, 50), (3, 3)])
def test_a_burst_is_simulated_over_more_turns_until_it_has_ended(
    monkeypatch, ends, turns, burst, impacts, budget
):
    """From a rest before the loss, with as many impacts as are asked for; once at each speed."""
    records = Records(monkeypatch, *ends)
    machine = of_machine()
    assert machine.at(120.0, impacts) == burst
    assert machine.at(120.0, impacts) == burst
    start = Start(theta=0.25)
    assert records.asked == [
        ("system", 120.0, Settings(0, many, 1e-13, budget, start)) for many in turns
    ]
    assert machine.cost == Cost(2 + len(turns), 10 * len(turns), 100 * len(turns))
    assert records.ends == []


@pytest.mark.parametrize(("pressed", "theta"), [
    (lambda theta: True, TURN + 0.5 * HALF_DEGREE - HALF_DEGREE),
    (lambda theta: theta < 6.0, 0.5 * HALF_DEGREE + TURN - 33 * HALF_DEGREE),
    (lambda theta: False, None),
    (lambda theta: HALF_DEGREE < theta < 1.6 * HALF_DEGREE, 1.5 * HALF_DEGREE),
    (lambda theta: abs(theta - 0.5 * HALF_DEGREE) < 1e-9, None),  # only where contact is lost
])  # fmt: skip
def test_a_rest_is_looked_for_back_from_the_loss_in_half_degrees(monkeypatch, pressed, theta):
    """From a quarter of a degree back through the whole turn."""
    monkeypatch.setattr(bursts, "stretch_at", lambda *of: of)
    machine = Bursts.__new__(Bursts)
    machine.system, machine.theta = Stub(cam="cam"), 0.5 * HALF_DEGREE

    def newton(i, phase, omega):
        assert (i, omega) == (("cam", phase), 30.0)
        return 1.0 if pressed(phase) else 0.0

    machine.force = Stub(newton=newton)
    found = machine._rest_before(30.0)
    assert found == (None if theta is None else pytest.approx(theta))


def test_a_burst_is_simulated_once_for_each_speed_and_number_of_impacts():
    made = Bursts.__new__(Bursts)
    simulated = []
    made._known = {}
    made._simulated = lambda *of: simulated.append(of) or Burst(*of)
    asked = [(120.0, 0), (120.0, 3), (130.0, 0), (130.0, 2)]
    for rpm, impacts in (*asked, *asked):
        assert made.at(rpm, impacts) == Burst(rpm, impacts)
    assert made.at(130.0) == Burst(130.0, 0)
    assert simulated == asked


def test_a_follower_that_rests_nowhere_has_no_burst():
    machine = of_machine(start=None)
    assert machine.at(120.0) == Burst(inf, inf)
    assert machine.cost == Cost(2, 0, 0)


@pytest.mark.parametrize(("theta", "release", "begins", "ends", "kind", "corner"), [
    (1.0, 1.0, "a", "b", LiftOffKind.FLIES_OFF, "a"),
    (1.0 + 0.9 * SAME_PHASE, 1.0, "a", "b", LiftOffKind.FLIES_OFF, "a"),
    (1.0 + 1.1 * SAME_PHASE, 1.0, "a", "b", LiftOffKind.WITHIN, ""),
    (1.0, 1.0, "", "b", LiftOffKind.WITHIN, ""),
    (1.0, inf, "a", "b", LiftOffKind.UNSEEN, ""),
    (0.5 - 0.9 * SAME_PHASE, 0.4, "a", "b", LiftOffKind.CAUGHT, "b"),  # the end, a turn before
    (TURN + 0.5, 0.4, "a", "b", LiftOffKind.CAUGHT, "b"),
    (0.5 - 1.1 * SAME_PHASE, 0.4, "a", "b", LiftOffKind.WITHIN, ""),
    (0.5, 0.4, "a", "", LiftOffKind.WITHIN, ""),
    (3.0, 3.0, "a", "b", LiftOffKind.WITHIN, ""),
])  # fmt: skip
def test_how_contact_is_lost_just_above_the_speed_at_which_a_region_opens(
    theta, release, begins, ends, kind, corner
):
    """In a region from 1 rad to 0.5 rad in the next turn."""
    region = Stub(name="A1", start=1.0, end=TURN + 0.5, begins=begins, ends=ends)
    loss = Stub(region=region, opens=Stub(theta=theta, rpm=200.0))
    for burst, landing, rest in (
        (Burst(release, release, [4.0, 5.0], 6.0), 4.0, 6.0), (Burst(release, release), inf, inf),
        (Burst(release, release, [], 6.0), 6.0, 6.0),
    ):  # fmt: skip
        machine = Stub(at=lambda rpm, burst=burst: burst if rpm == 200.0 * (1.0 + 1e-6) else None)
        found = bursts.lift_off(machine, loss)
        assert found == bursts.LiftOff(
            "A1", kind, corner, 200.0 * (1.0 + 1e-6), release, landing, rest
        )


# -- settled motions


def test_rests_that_no_loss_of_contact_began_are_told_apart():
    ends = (SettledBurst("A1", 1.0), SettledBurst("", None), SettledBurst("A2", 3.0))
    motion = SettledMotion(700.0, ends, (), Status.OK, Cost(), (1.0 + 0.9e-9, 2.0, 3.0, 1.0 + 2e-9))
    assert motion.ends == [1.0, 3.0]
    assert motion.other_rests == [2.0, 1.0 + 2e-9]


def test_a_speed_that_fails_is_told_and_the_others_are_simulated(monkeypatch):
    monkeypatch.setattr(bursts, "Force", lambda system: ("force", system))
    turns = Settings(5, 2, 1e-7, 40, Start())
    given = Settings(99, 98, 1e-7, 40, Start(theta=0.5))

    def simulate(force, rpm, of):
        assert (force, of) == (("force", "system"), turns)
        if rpm == 200.0:
            raise BudgetSpentError
        return ("motion", rpm)

    pieces = []

    def piece(name, what, failed):
        pieces.append((name, failed))
        return failed if name == "rpm = 100.0" else what()

    monkeypatch.setattr(bursts, "_settled_motion", simulate)
    monkeypatch.setattr(bursts, "piece", piece)
    ticks = []
    found = bursts.settled_motions(
        "system", [100.0, 200.0, 300.0], given, 5, lambda: ticks.append(len(pieces))
    )
    fault = SettledMotion(100.0, (), (), Status.FAULT, Cost())
    assert found == [
        fault, SettledMotion(200.0, (), (), Status.WORK_BUDGET, Cost()), ("motion", 300.0)
    ]  # fmt: skip
    assert [name for name, _ in pieces] == ["rpm = 100.0", "rpm = 200.0", "rpm = 300.0"]
    assert pieces[2][1] == SettledMotion(300.0, (), (), Status.FAULT, Cost())
    assert ticks == [1, 3]


FIRST, SECOND, BEYOND = Burst(1.0, 2.0), Burst(3.0, 4.0), Burst(5.0, TURN)
BEFORE, BLOW = Burst(inf, 0.5, [0.75]), Burst(inf, 0.25, [0.5])


@pytest.mark.parametrize(("found", "status", "kept"), [
    ([BEFORE, FIRST, SECOND, BEYOND], Status.OK, [FIRST, SECOND]),
    ([BEFORE, BEYOND], Status.OK, [BEFORE]),
    ([BLOW, BEYOND], Status.OK, []),  # a lobe struck the follower at rest
    ([BEYOND], Status.OK, [BEYOND]),
    ([], Status.OK, []),
    ([BEFORE, FIRST, BEYOND], Status.NO_RETURN, [BEFORE, FIRST, BEYOND]),
])  # fmt: skip
def test_the_bursts_of_a_motion_are_those_that_begin_in_its_turn(monkeypatch, found, status, kept):
    """Where none does, one that goes on from before it is told."""
    records = Records(monkeypatch, (found, status))
    monkeypatch.setattr(bursts, "_begins_at_rest", lambda system, burst: burst is BLOW)
    monkeypatch.setattr(bursts, "_settled_burst", lambda *of: of)
    system = Stub(strobe=1.0)
    force = Stub(system=system)
    motion = bursts._settled_motion(force, 120.0, "turns")
    assert motion == SettledMotion(
        120.0, tuple((force, 1.0, burst) for burst in kept), (1.0,), status, Cost(1, 10, 100),
        (2.0,),
    )  # fmt: skip
    assert records.asked == [(system, 120.0, "turns")]


@pytest.mark.parametrize(("burst", "has_seat", "begins"), [
    (Burst(inf, 0.5, [1.0, 9.0]), True, True),  # at the corner, a strobe later
    (Burst(inf, 0.5, [TURN + 1.0 + 0.9 * SAME_PHASE]), True, True),
    (Burst(inf, 0.5, [1.0 + 1.1 * SAME_PHASE]), True, False),
    (Burst(inf, 0.5, [2.0]), True, False),
    (Burst(inf, 0.5, [3.0, 1.0]), True, True),  # the other corner
    (Burst(inf, 0.5, [2.0, 1.0]), True, False),  # only the first impact counts
    (Burst(inf, 0.5), True, False),
    (Burst(4.0, 0.5, [1.0]), True, False),  # contact was lost
    (Burst(inf, 0.5, [1.0]), False, False),
])  # fmt: skip
def test_a_burst_that_a_lobe_or_a_seat_began_is_none_of_lost_contact(burst, has_seat, begins):
    system = Stub(has_seat=has_seat, strobe=1.5, corners=(2.5, 4.5))
    assert bursts._begins_at_rest(system, burst) is begins


def test_a_settled_burst_has_its_region_and_its_end_within_the_turn(monkeypatch):
    monkeypatch.setattr(bursts, "stretch_at", lambda cam, theta: (cam, theta))
    force = Stub(cam="cam", region_of=lambda of: Stub(name=f"A{of[1]}") if of[0] == "cam" else None)
    made = [
        bursts._settled_burst(force, 1.5, burst)
        for burst in (Burst(2.0, 3.0, end=4.0), Burst(2.0, 3.0), Burst(inf, 3.0, end=TURN))
    ]
    assert [burst.region for burst in made] == ["A2.0", "A2.0", ""]
    assert [burst.end for burst in made] == [5.5, None, pytest.approx(1.5)]
    late = bursts._settled_burst(force, 1.5, Burst(2.0, 3.0, end=6.0))
    assert late.end == pytest.approx(7.5 - TURN)


# -- where the bursts change


def test_corners_are_met_in_the_order_from_the_release_on(monkeypatch):
    """The corner of the release itself is none that is ahead."""
    near = 0.9 * SAME_PHASE, 1.1 * SAME_PHASE
    thetas = [0.5, 5.0, 2.0 + near[0], 2.0 - near[0], 2.0 + near[1], 2.0 - near[1], 4.0, 1.0]
    corners = [Stub(theta=theta) for theta in thetas]
    monkeypatch.setattr(accumulation, "corner_list", lambda cam: corners if cam == "cam" else None)
    found = accumulation.corners_ahead(Stub(system=Stub(cam="cam"), theta=2.0))
    order = [2.0 + near[1], 4.0, 5.0, 0.5, 1.0, 2.0 - near[1]]
    assert [corner.theta for corner, _ in found] == order
    assert [phase for _, phase in found] == [
        theta if theta > 2.0 else theta + TURN for theta in order
    ]


def rising(at):
    return lambda rpm: (rpm - at) / 10.0


def jumping(at, before=-1.0, behind=1.0):
    return lambda rpm: before if rpm < at else behind


@pytest.mark.parametrize("falls", [False, True])
@pytest.mark.parametrize(("excess", "at", "status"), [
    (rising(120.25), 120.25, SpeedStatus.OK),
    (jumping(120.25), 120.25, SpeedStatus.JUMP),
    (jumping(120.25, -0.9e-4), 120.25, SpeedStatus.OK),  # it comes up to its goal on one side
    (jumping(120.25, behind=0.9e-4), 120.25, SpeedStatus.OK),
    (jumping(120.25, -1.1e-4, 1.1e-4), 120.25, SpeedStatus.JUMP),
])  # fmt: skip
@pytest.mark.parametrize("troubled", [None, "low", "high"])
def test_a_change_of_a_burst_is_bracketed_between_two_speeds(excess, at, status, falls, troubled):
    """Whichever way it changes; a burst that is not known at an end leaves it unresolved."""
    way = -1.0 if falls else 1.0
    if falls:
        rises = excess
        excess = lambda rpm: rises(2.0 * at - rpm)  # noqa: E731
    machine = Stub(at=lambda rpm: Stub(
        status=Status.NO_RETURN if (rpm < at, troubled) in ((True, "low"), (False, "high"))
        else Status.OK
    ))  # fmt: skip
    (change,) = accumulation._changes(machine, excess, [100.0, 110.0, 125.0, 150.0])
    assert change.low < change.high
    assert change.low == pytest.approx(at, rel=1e-11)
    assert change.high == pytest.approx(at, rel=1e-11)
    assert change.low <= at <= change.high
    assert change.below == (change.low if way > 0.0 else change.high)
    assert change.status == (SpeedStatus.UNRESOLVED if troubled else status)


def test_there_may_be_several_changes_or_none():
    machine = Stub(at=lambda rpm: Stub(status=Status.OK))

    def wave(rpm):
        return 1.0 if 112.0 <= rpm < 118.0 or rpm >= 131.0 else -1.0

    found = list(accumulation._changes(machine, wave, [110.0, 115.0, 120.0, 130.0, 140.0]))
    assert [round(change.low) for change in found] == [112, 118, 131]
    assert [change.below == change.low for change in found] == [True, False, True]
    assert list(accumulation._changes(machine, wave, [120.0, 125.0, 130.0])) == []


def test_an_end_of_a_burst_reaches_a_corner_or_the_next_release(monkeypatch):
    """Its phase less the corner's; or less that of the release a turn later."""
    asked = []
    change = accumulation._Change(110.0, 111.0, 111.0, SpeedStatus.JUMP)

    def changes(of, excess, speeds):
        asked.append((of, [excess(rpm) for rpm in (1.0, 2.0, 3.0)], speeds))
        return [change]

    monkeypatch.setattr(accumulation, "_changes", changes)
    known = {
        1.0: Burst(2.0, 2.0, end=5.0), 2.0: Burst(2.5, 2.5), 3.0: Burst(inf, inf),
        110.0: Burst(2.75, 2.75), 111.0: Burst(2.875, 2.875),
    }  # fmt: skip
    machine = Stub(at=known.get, name="A1", theta=9.0)
    far = 10.0 * TURN
    corner = Stub(name="b", theta=1.25)
    (speed,) = accumulation.reaching(machine, corner, 4.0, "speeds")
    assert speed == CriticalSpeed(
        CriticalQuantity.ACCUMULATION, "b", 1.25, 110.5, 110.0, 111.0, SpeedStatus.JUMP, "A1"
    )
    assert asked.pop() == (machine, [1.0, far - 4.0, far - 4.0], "speeds")
    (speed,) = accumulation.completion_loss(machine, "speeds")
    assert speed == CriticalSpeed(
        CriticalQuantity.COMPLETION_LOSS, "A1", 2.875, 110.5, 110.0, 111.0, SpeedStatus.JUMP, "A1"
    )
    wanted = [3.0 - TURN, far - 2.5 - TURN, far]
    assert asked.pop() == (machine, pytest.approx(wanted), "speeds")


def test_impacts_land_on_a_corner_one_after_the_other():
    """Each below the speed of the one before it; one that has gone ends its curve there.

    The corner is at 10 rad. Impact n is at rpm - 100 + n/2, but the third one is at 9 rad up to
    105 rpm, where it ceases to exist and the burst ends at 12 rad; the fifth one jumps to the
    corner at 104 rpm, and the sixth one from it at 103 rpm.
    """

    def at(rpm, n):
        phases = [rpm - 100.0 + k / 2.0 for k in range(1, n + 1)]
        if n == 3:
            phases[2:] = [9.0] if rpm < 105.0 else []
        if n == 5:
            phases[4] = 9.0 if rpm < 104.0 else 10.0 + 0.9e-4
        if n == 6:
            phases[5] = 10.0 - 0.9e-4 if rpm < 103.0 else 11.0
        return Burst(1.0, 1.0, phases, 12.0 if n == 3 else inf)

    def hits(low, high, count):
        machine = Stub(at=at, name="A1")
        return list(accumulation.corner_hits(machine, Stub(name="b"), 10.0, low, high, count))

    found = hits(100.0, 109.25, 6)  # the first one lands at 109.5 rpm, the fourth at 108
    assert [(hit.impact, hit.status) for hit in found] == [
        (2, SpeedStatus.OK), (3, SpeedStatus.JUMP), (5, SpeedStatus.OK),
        (6, SpeedStatus.OK),
    ]  # fmt: skip
    for hit, rpm in zip(found, (109.0, 105.0, 104.0, 103.0), strict=True):
        assert (hit.corner, hit.burst) == ("b", "A1")
        assert hit.low <= rpm <= hit.high
        assert hit.high - hit.low < 1e-9
        assert hit.rpm == 0.5 * (hit.low + hit.high)
    assert [hit.ends for hit in found] == [None, (9.0, 12.0), None, None]
    assert isinstance(found[0], CornerHit)
    assert [hit.impact for hit in hits(100.0, 120.0, 2)] == [1, 2]
    assert hits(109.125, 120.0, 2)[0].impact == 1  # at the lower end the second is behind already
    assert len(hits(109.125, 120.0, 2)) == 1
