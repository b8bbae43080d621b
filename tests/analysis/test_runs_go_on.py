"""What a run costs, where a run that goes on begins, and what is recorded then.

A run is the same to the last bit however it is cut, so each part is compared with one run in whole.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import settings
from flint import arb

from camcli.analysis import simulate as simulate_module
from camcli.analysis.classify import _Followed
from camcli.analysis.integrate import (
    USUAL_PORTIONS,
    Cost,
    Orbit,
    Portions,
    Record,
    Start,
    StartError,
    _runs_of,
    budgeted,
    follow_on,
    rounding_of,
    run_all,
)
from camcli.analysis.labels import Label
from camcli.analysis.loads import loads_of
from camcli.analysis.orbits.codim2 import _outwards
from camcli.analysis.patience import watch
from camcli.analysis.simulate import one_of_many_from, simulate
from camcli.cams.eccentric import EccentricCam
from camcli.errors import Status
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.contact_search import Tally
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.follow import copy_state
from camcli.kernel.orbit_loop import RESTING, State
from camcli.system import Follower, System

SMALL = Portions(plain_steps=40, compiled_steps=40, first_rows=2, most_rows=4)
FLOWN = Portions(compiled_steps=500, copies_turns=False)
CHATTERS, BOUNCES, CHAOTIC = 190.0, 700.0, 745.0  # rpm


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    monkeypatch.setenv("CAMCLI_KERNEL", "python")


def same_turns(record: Record, whole: Record, first: int) -> None:
    """Each recorded turn is one of the whole record, from the turn `first` on."""
    turns = slice(first, first + record.periods)
    for name in ("strobe_q", "strobe_w", "impacts", "chatter"):
        own = getattr(record, name)[: record.periods]
        assert own.tobytes() == getattr(whole, name)[turns].tobytes(), name


@pytest.mark.parametrize(
    "portions", [USUAL_PORTIONS, SMALL, FLOWN], ids=["usual", "small", "flown"]
)
@pytest.mark.parametrize("events", [True, False])
def test_a_budget_is_spent_by_steps_evaluations_and_rows(chapter, portions, events):
    """A row counts as twenty evaluations; what an orbit has done before does not count."""
    orbits = [Orbit(chapter, rpm, settings(4, 12)) for rpm in (CHATTERS, BOUNCES, CHAOTIC)]
    orbits[1].work = Tally(evaluations=700, crossings=30, steps=900)
    spent: list[int] = []
    with budgeted(10**9, lambda done, limit: spent.append(done)) as budget:
        records = run_all(orbits, events=events, portions=portions)
    work = sum(one.work.steps + one.work.evaluations for one in orbits) - 900 - 700
    rows = sum(len(record.kind) for record in records)
    assert (rows > 0) == events
    assert budget.done == work + 20 * rows
    assert spent == sorted(spent)
    assert (len(spent) > 5) == (portions is SMALL)


@pytest.mark.parametrize("rpm", [CHATTERS, BOUNCES, CHAOTIC])
def test_a_transient_costs_as_much_as_recorded_turns(chapter, rpm):
    """Its impacts too, whether its turns were flown or are others again."""
    cut = Orbit(chapter, rpm, settings(20, 10)).run()
    whole = Orbit(chapter, rpm, settings(0, 30)).run()
    assert cut.cost.impacts == whole.cost.impacts >= int(whole.impacts.sum())
    same_turns(cut, whole, 20)
    again = Orbit(chapter, rpm, settings(20, 10)).run(portions=FLOWN)
    assert again.cost.impacts == cut.cost.impacts


@pytest.mark.parametrize("parts", [[1], [3, 5, 2], [4, 4, 4, 1]], ids=str)
def test_an_orbit_that_is_followed_in_parts_is_one_orbit(chapter, parts):
    orbit = Orbit(chapter, CHAOTIC, settings(10, 20))
    orbit.run()
    before = orbit.state.total_impacts
    followed = follow_on(orbit, parts)
    whole = Orbit(chapter, CHAOTIC, settings(0, 30 + sum(parts))).run()
    assert [record.periods for _, record in followed] == parts
    first = 30
    for on, record in followed:
        same_turns(record, whole, first)
        first += record.periods
        so_far = Orbit(chapter, CHAOTIC, settings(first, 0))
        so_far.run()
        assert on.position() == so_far.position()
        assert (on.state.period, on.work.evaluations > 0) == (record.periods, True)
    impacts = sum(record.cost.impacts for _, record in followed)
    assert impacts == whole.cost.impacts - before
    assert orbit.state.period == 20  # it stays where it is


def test_all_of_a_state_goes_on_but_for_its_place_in_the_log():
    kinds = State.__annotations__
    one = State(**{name: kinds[name](k) for k, name in enumerate(kinds, 1)})
    to = State(logged=-7)
    copy_state(one, to)
    assert to == replace(one, logged=-7)


def test_parts_behind_a_rest_or_a_period_are_left_out(chapter):
    for rpm, transient, parts in ((CHATTERS, 3, 1), (BOUNCES, 2_000, 1), (632.5, 1_000, None)):
        orbit = Orbit(chapter, rpm, settings(transient, 20))
        orbit.run()
        followed = follow_on(orbit, [150] * 40)
        *before, (_, last) = followed
        assert last.chatters > 0 or last.repeats > 0
        assert all(record.chatters == record.repeats == 0 for _, record in before)
        assert parts in (None, len(followed))
        assert 0 < len(followed) < 40
    few = Orbit(chapter, CHATTERS, settings(0, 1, budget=3))
    ((_, record),) = follow_on(few, [4, 4])
    assert record.status == Status.IMPACT_BUDGET


# -- patience ------------------------------------------------------------------------------------


@pytest.mark.parametrize("turns", [1, 300, 2300])
def test_what_is_shown_of_a_motion_that_stays_follows_its_patience(chapter, turns):
    orbit = Orbit(chapter, CHAOTIC, settings(10, 20))
    orbit.run()
    seen = watch(orbit, CHAOTIC, turns, 40)
    assert (seen.turns, seen.stays, seen.orbit) == (turns, True, None)
    whole = Orbit(chapter, CHAOTIC, settings(0, 30 + turns + 40)).run()
    assert seen.record.periods == 40
    same_turns(seen.record, whole, 30 + turns)
    before = Orbit(chapter, CHAOTIC, settings(10, 20)).run().cost.impacts
    assert seen.cost.impacts == whole.cost.impacts - before


@pytest.mark.parametrize("turns", [20_000, 20_300])
def test_patience_is_the_same_in_one_call_of_the_kernel_and_in_several(chapter, monkeypatch, turns):
    monkeypatch.delenv("CAMCLI_KERNEL")
    orbit = Orbit(chapter, CHAOTIC, settings(10, 20))
    orbit.run()
    seen = watch(orbit, CHAOTIC, turns, 40)
    assert (seen.turns, seen.stays) == (turns, True)
    whole = Orbit(chapter, CHAOTIC, settings(0, 30 + turns + 40)).run()
    same_turns(seen.record, whole, 30 + turns)
    before = Orbit(chapter, CHAOTIC, settings(10, 20)).run().cost.impacts
    assert seen.cost.impacts == whole.cost.impacts - before


def test_without_patience_a_motion_stays_and_nothing_is_spent(chapter):
    orbit = Orbit(chapter, CHAOTIC, settings(10, 20))
    orbit.run()
    seen = watch(orbit, CHAOTIC, 0, 40)
    assert (seen.turns, seen.stays, seen.orbit) == (0, True, None)
    assert seen.record is None
    assert seen.cost == (0, 0, 0)


def test_a_motion_that_rests_is_shown_from_the_turn_before_on(chapter):
    """A chatter that ends in a turn may have begun in the one before."""
    orbit = Orbit(chapter, 632.5, settings(1000, 20))
    orbit.run()
    seen = watch(orbit, 632.5, 20_000, 30)
    assert not seen.stays
    assert seen.record.chatter[1]
    whole = Orbit(chapter, 632.5, settings(1020, seen.turns + 30)).run()
    assert int(np.flatnonzero(whole.chatter)[0]) == seen.turns - 1
    same_turns(seen.record, whole, seen.turns - 2)


def test_a_motion_that_settles_is_shown_from_where_that_is_seen(chapter):
    orbit = Orbit(chapter, BOUNCES, settings(0, 20))
    orbit.run()
    seen = watch(orbit, BOUNCES, 20_000, 130)
    assert not seen.stays
    assert seen.orbit.label == "P(1;1)"
    assert seen.turns == 2000  # the first look
    same_turns(seen.record, Orbit(chapter, BOUNCES, settings(0, 2200)).run(), 2020)


def test_a_motion_that_nothing_shows_is_followed_for_eight_times_its_record(chapter):
    followed = _Followed(chapter, CHAOTIC, settings(10, 130), Start(), None)
    first = followed.cost.impacts
    followed.go_on()
    whole = Orbit(chapter, CHAOTIC, settings(0, 10 + 9 * 130)).run()
    assert followed.turns == 10 + 9 * 130
    assert followed.record.periods == 8 * 130
    same_turns(followed.record, whole, 140)
    assert followed.cost.impacts == whole.cost.impacts > first


@pytest.mark.parametrize(("record", "turns"), [(10, 130), (130, 130), (140, 140)])
def test_a_short_record_is_made_as_long_as_a_label_takes(chapter, record, turns):
    followed = _Followed(chapter, CHAOTIC, settings(7, record), Start(), None)
    assert (followed.recorded, followed.record.periods) == (turns, turns)
    assert (followed.turns, followed.watched) == (7 + turns, None)


def test_a_record_that_is_there_is_not_made_again(chapter):
    orbit = Orbit(chapter, CHAOTIC, settings(7, 130))
    record = orbit.run()
    followed = _Followed(chapter, CHAOTIC, settings(7, 130), Start(), (orbit, record))
    assert followed.record is record
    assert followed.cost == (0, 0, 0)


# -- one of many ---------------------------------------------------------------------------------


def test_an_error_of_rounding_grows_by_as_much_as_two_motions_part(chapter):
    """Two motions that begin 1e-13 m apart are 7e-3 m apart then."""
    turns = 200
    in_the_air = settings(0, turns, q=0.3, v=0.1)
    record = Orbit(chapter, CHAOTIC, in_the_air).run()
    first, _ = one_of_many_from(chapter, CHAOTIC, in_the_air, record, "aperiodic")
    beside = Orbit(chapter, CHAOTIC, in_the_air, Start(0.3 + 1e-13, 0.1)).run()
    apart = np.abs(beside.strobe_q - record.strobe_q)[:turns]
    parted = int(np.flatnonzero(apart > 7e10 * 1e-13)[0])
    assert abs(first - parted) <= 6
    for transient in (1, first, first + 1, first + 40):
        asked = settings(transient, turns - transient, q=0.3, v=0.1)
        rest = Orbit(chapter, CHAOTIC, asked).run()
        found, _ = one_of_many_from(chapter, CHAOTIC, asked, rest, "aperiodic")
        assert found == first - transient
        assert simulate(chapter, CHAOTIC, asked, 0, follow=False).one_of_many == found
    short = settings(0, first, q=0.3, v=0.1)  # its last turn is the one before
    record = Orbit(chapter, CHAOTIC, short).run()
    assert one_of_many_from(chapter, CHAOTIC, short, record, "aperiodic")[0] is None


@pytest.mark.parametrize(("label", "alone"), [("P(3;4:2:1)", True), ("aperiodic", False)])
def test_a_record_is_one_of_many_whatever_its_motion_ends_on(monkeypatch, chapter, label, alone):
    """It was followed on since it looks aperiodic; a record that shows an orbit attracts."""
    ends = SimpleNamespace(label=Label.parse("P(3;4:2:1)"))
    named = Label.parse(label) if alone else ends.label
    monkeypatch.setattr(
        simulate_module, "_named", lambda *_: (named, None if alone else ends, Cost(1, 2, 4))
    )
    asked = settings(0, 150, q=0.3, v=0.1)
    found = simulate(chapter, CHAOTIC, asked, 0)
    assert found.label == "P(3;4:2:1)"
    assert found.ends is (None if alone else ends)
    plain = simulate(chapter, CHAOTIC, asked, 0, follow=False)
    assert plain.one_of_many > 10
    assert found.one_of_many == (None if alone else plain.one_of_many)


def test_what_a_rest_ends_or_an_orbit_attracts_is_one_alone(chapter):
    for rpm, label in ((BOUNCES, "P(1;1)"), (CHATTERS, "undecided")):
        record = Orbit(chapter, rpm, settings(0, 100)).run()
        assert one_of_many_from(chapter, rpm, settings(0, 100), record, label)[0] is None


# -- outwards ------------------------------------------------------------------------------------


@pytest.mark.parametrize("middle", [0.1, -0.1, 1e3, -7e-9, 1.0])
@pytest.mark.parametrize("radius", [0.0, 1e-25, 1e-3])
def test_doubles_about_a_ball_are_the_nearest_but_for_one(middle, radius):
    ball = arb(middle) * (1 + arb(2) ** -70) + arb(0, radius * abs(middle))
    low, high = _outwards(ball)
    assert arb(low) < ball < arb(high)
    assert arb(np.nextafter(np.nextafter(low, np.inf), np.inf)) >= ball.lower()
    assert arb(np.nextafter(np.nextafter(high, -np.inf), -np.inf)) <= ball.upper()


def test_a_run_in_trouble_ends_the_patience(chapter):
    """A budget of impacts that does not last for a chatter."""
    few = settings(0, 1, budget=3)
    orbit = Orbit(chapter, CHATTERS, few)
    seen = watch(orbit, CHATTERS, 50, 4)
    assert seen.record.status != Status.OK
    assert not seen.stays
    assert (seen.turns, seen.orbit) == (seen.record.periods, None)


@pytest.mark.parametrize("label", ["aperiodic", Label((2.0, float("inf")))])
@pytest.mark.parametrize("rest", [None, 650, "ends"])
def test_growth_is_counted_over_all_portions_of_events(monkeypatch, rest, label):
    """1300 events, two a turn: a difference grows at two of them, in the second and third portion.

    A rest between them ends the difference, and so does a map onto one state; the error is too
    large with both of them. An orbit with rests is no exception: what attracts are its rests.
    """
    count = 1300
    kinds = [simulate_module.IMPACT] * count
    growth = [0.0] * count
    growth[600] = growth[1201] = 0.75 * simulate_module.LOG_TOO_LARGE
    left = [1.0] * count  # of a difference, at each event
    if rest == "ends":
        left[650] = 0.0
    elif rest is not None:
        kinds[rest] = simulate_module.CHATTER
    whole = SimpleNamespace(cost=Cost(3, 5, 7), kind=kinds, period=[k // 2 for k in range(count)],
                            theta=[float(k) for k in range(count)], u=[-1.0] * count)  # fmt: skip
    portions = []

    def stretch(cam, const, kinds, periods, thetas, rates, pairs, growths):
        first = int(thetas[0])
        portions.append(first)
        growths.extend(
            SimpleNamespace(first=left[k], first_log=growth[k])
            for k in range(first, first + len(kinds))
        )

    kernel = SimpleNamespace(
        table=lambda *_: None, numbers=lambda values, *_: values, copies=lambda *_: [],
        stretch_events=stretch,
    )  # fmt: skip
    machine = SimpleNamespace(constants=lambda *_: None, cam_for=lambda _: None)
    monkeypatch.setattr(simulate_module.backend, "current", lambda: kernel)
    monkeypatch.setattr(simulate_module, "rows_of", lambda kind, growths: growths)
    monkeypatch.setattr(
        simulate_module, "Orbit", lambda *_: SimpleNamespace(run=lambda strobes: whole)
    )
    record = SimpleNamespace(periods=40, chatter=[1])
    found, cost = one_of_many_from(machine, 700.0, settings(10, 40), record, label)
    assert cost == Cost(3, 5, 7)
    assert len(portions) > 2
    assert found == (1201 // 2 - 10 if rest is None else None)


# -- how orbits begin ----------------------------------------------------------------------------


@pytest.mark.parametrize("rpm", [CHATTERS, BOUNCES])
def test_what_a_part_of_a_run_costs_is_its_own(chapter, rpm):
    """And so are its departures from rest; what was counted before is not counted again."""
    first = Orbit(chapter, rpm, settings(3, 6))
    begun = first.run(portions=FLOWN)
    rest = first.go_on(0, 5).run(portions=FLOWN)
    whole = Orbit(chapter, rpm, settings(3, 11)).run(portions=FLOWN)
    assert begun.cost + rest.cost == whole.cost
    assert begun.detachments + rest.detachments == whole.detachments
    assert (begun.detachments > 0) == (rpm == CHATTERS)


def test_where_an_orbit_stands_is_a_start(chapter):
    """At any phase; one at rest has no numbers of its own."""
    start = Start(0.3, 0.5, 1.0)
    orbit = Orbit(chapter, 700.0, settings(), start)
    found = orbit.as_start()
    assert (found.q, found.v, found.theta) == pytest.approx((0.3, 0.5, 1.0), rel=1e-14)
    orbit.state.mode = RESTING
    assert orbit.as_start() == Start(theta=1.0)


@pytest.mark.parametrize(
    ("theta", "inside", "period"),
    [(0.0, 0.0, -7), (TURN, 0.0, -7), (0.3, 0.3, -8), (-0.5, TURN - 0.5, -8),
     (TURN + 1.0, 1.0, -8), (3.0, 3.0, -8)],
)  # fmt: skip
def test_a_start_beside_the_strobe_cuts_a_turn_short(chapter, theta, inside, period):
    state = Orbit(chapter, 700.0, settings(7, 3), Start(theta=theta)).state
    assert state.theta == pytest.approx(inside, abs=1e-15)
    assert state.period == period
    assert state.stretch == stretch_at(chapter.cam, state.theta)


@pytest.mark.parametrize(("c", "off"), [(0.1, 2e-16), (-0.5, 2e-16), (5.0, 1e-15), (-5.0, 1e-15)])
def test_a_start_may_be_off_the_cam_by_a_rounding(c, off):
    assert rounding_of(c) == pytest.approx(off, rel=1e-12, abs=0.0)


def test_a_start_where_another_stretch_begins_is_beside_the_strobe(chapter):
    cam = chapter.cam
    for i, one in enumerate(cam.stretches):
        state = Orbit(chapter, 700.0, settings(7, 3), Start(theta=one.start)).state
        assert state.stretch == i
        assert state.period == (-7 if i == cam.strobe else -8)


@pytest.mark.parametrize("base", [0.25, 5.0, -5.0])
def test_how_a_start_beside_the_cam_begins(base):
    """Off it by a rounding it is on it, and there it lands if it moves into it; else it is free."""
    cam = EccentricCam(kind="eccentric", base=base, lift=0.5)
    machine = System.build(Follower(mass=1.0, stiffness=0.0, gravity=9.81), cam)
    c = lift_at(machine.cam, stretch_at(machine.cam, 0.0), 0.0)[0]
    off = 1.5e-16 * max(1.0, abs(c))
    ulp = float(np.spacing(abs(c)))
    for gap, v, mode, left in (
        (ulp, 0.0, BOUNCED, 0.0), (-ulp, 1.0, BOUNCED, 0.0), (ulp, -1.0, FREE, 0.0),
        (0.0, 0.0, BOUNCED, 0.0), (20.0 * off, 0.0, FREE, 20.0 * off), (0.5, 1.0, FREE, 0.5),
    ):  # fmt: skip
        state = Orbit(machine, 700.0, settings(7, 3), Start(c + gap, v)).state
        assert state.gap == pytest.approx(left, abs=ulp), (gap, v)
        assert (state.gap == 0.0) == (left == 0.0)
        assert state.mode == mode, (gap, v)
        assert state.gap_rate == pytest.approx(v / (700.0 * np.pi / 30.0))
    with pytest.raises(StartError):
        Orbit(machine, 700.0, settings(7, 3), Start(c - 20.0 * off, 0.0))


def test_what_the_kernel_is_asked_for_of_each_orbit():
    """Strobes stand one after the other; loads are measured of what is logged, and not too long."""

    def runs(*turns, events=True, strobes=True, loads=True, transient=5):
        orbits = [SimpleNamespace(settings=settings(transient, n)) for n in turns]
        return _runs_of(orbits, events, strobes, loads)

    found = runs(30, 10_000, 10_001)
    assert [run.turns for run in found] == [30, 10_000, 10_001]
    assert [run.strobe_first for run in found] == [0, 30, 10_030]
    assert [run.strobe_rows for run in found] == [30, 10_000, 10_001]
    assert [run.wants_loads for run in found] == [1, 1, 0]
    assert [run.log_from for run in found] == [0, 0, 0]
    for more in ({"events": False}, {"strobes": False}, {"loads": False}):
        assert [run.wants_loads for run in runs(30, 40, **more)] == [0, 0]
    assert [run.strobe_rows for run in runs(30, 40, strobes=False)] == [0, 0]
    assert [run.log_from for run in runs(30, transient=0)] == [-1]
    mixed = [SimpleNamespace(settings=settings(transient, 30)) for transient in (0, 5, 0)]
    assert [run.log_from for run in _runs_of(mixed, True, True, True)] == [-1, 0, -1]


def test_a_run_that_ends_before_its_record_begins_has_no_rows(chapter):
    """Neither strobes nor loads: nothing was recorded."""
    few = settings(50, 4, budget=3)
    (record,) = run_all([Orbit(chapter, CHATTERS, few)], loads=True)
    assert record.status == Status.IMPACT_BUDGET
    assert (len(record.strobe_q), len(record.kind), record.periods) == (0, 0, 0)
    assert record.loads is None
    (record,) = run_all([Orbit(chapter, CHATTERS, settings(0, 4, budget=3))], loads=True)
    assert (len(record.strobe_q), record.periods, record.loads) == (1, 0, None)


def test_loads_on_the_way_are_those_of_the_record(chapter):
    """With an impact on the base circle of a cam whose lowest lift is not zero."""
    dropped = settings(0, 2, q=0.2, v=0.0)
    (record,) = run_all([Orbit(chapter, CHATTERS, dropped)], loads=True)
    found = loads_of(chapter, CHATTERS, record)
    assert found == loads_of(chapter, CHATTERS, record._replace(loads=None))
    assert found.shut_bounces_per_turn > 0.4
