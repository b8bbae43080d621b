"""Each stop of a page of `cam explore`, from motions and events made here.

Sentences are tuples here, of the function of `words.explore.Machine` and of what it was given.
"""

from __future__ import annotations

from math import inf, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.integrate import Settings, Start
from camcli.analysis.labels import APERIODIC, CONTACT, Label
from camcli.api import explore_stops
from camcli.api.explore_motions import Explored, PageMotion
from camcli.api.explore_stops import STOP, Stop

ONE, TWO, THREE = Label((1.0,)), Label((1.0, 2.0)), Label((1.0, 2.0, 4.0))
CHATTER = Label((inf,))
CORNERS = {"a": radians(160.0), "b": radians(200.0)}


class Says:
    """In the place of the sentences of a machine."""

    valve = True

    def __getattr__(self, name):
        return lambda *given: (name, *given)


@pytest.fixture(autouse=True)
def _stubs(monkeypatch):
    monkeypatch.setattr(explore_stops.words.Machine, "of", lambda scene, system: Says())
    monkeypatch.setattr(explore_stops, "profile", lambda *of, **more: Made(corners=CORNERS))
    first = Made(rpm=100.0, theta=radians(170.0))
    monkeypatch.setattr(explore_stops, "detachment", lambda system: Made(first=first))


def machine(seat=True, lash=0.001, start=600.0, stop=700.0, num=11):
    scene = Made(cam=Made(lash=lash), run=Made(rpm=500.0),
                 sweep=Made(rpm=Made(start=start, stop=stop, num=num)))  # fmt: skip
    return Made(scene=scene, system=Made(has_seat=seat), settings=None)


def motion(rpm, label=ONE, origin="up", turns=2, stable=True):
    return PageMotion(rpm, label, origin, 1.0, 2.0, turns, False, stable, None, None)


def event(kind, turn, phase, seconds, u=-1.0):
    return Made(kind=kind, turn=turn, phase=phase, seconds=seconds, u_before=u)


def page(*pairs, bifurcations=None):
    """What a page has found: motions with their events, and the events of solved orbits."""
    parts = {}
    if bifurcations is not None:
        parts["orbits"] = Made(values=Made(bifurcations=bifurcations))
    simulations = [Made(events=list(events)) for _, events in pairs]
    return Explored([one for one, _ in pairs], simulations, parts)


def test_motions_below_and_above_the_first_loss_of_contact(monkeypatch):
    """Contact at 0.9 of it, a lift-off a turn at 1.06, and the fastest chatter of three speeds."""

    def found(labels):
        asked = []

        def settled(machine, rpm):
            asked.append(rpm)
            label = labels.get(round(rpm))
            return None if label is None else motion(rpm, label, STOP)

        monkeypatch.setattr(explore_stops, "_settled", settled)
        motions = explore_stops.motions_of_stops(machine())
        return asked, [(round(one.rpm), one.label) for one in motions]

    chatters = {150: CHATTER, 130: CHATTER, 115: CHATTER}
    asked, all_three = found({90: CONTACT, 106: CHATTER, **chatters})
    assert asked == pytest.approx([90.0, 106.0, 150.0])
    assert all_three == [(90, CONTACT), (106, CHATTER), (150, CHATTER)]
    asked, some = found({90: ONE, 106: TWO, 150: ONE, 130: None, 115: CHATTER})
    assert asked == pytest.approx([90.0, 106.0, 150.0, 130.0, 115.0])
    assert some == [(115, CHATTER)]
    assert found({90: None, 106: ONE, 150: APERIODIC, 130: TWO, 115: ONE})[1] == [(106, ONE)]
    assert found({90: CONTACT})[1] == [(90, CONTACT)]
    monkeypatch.setattr(explore_stops, "detachment", lambda system: Made(first=None))
    assert found({90: CONTACT}) == ([], [])


@pytest.mark.parametrize(
    ("label", "loops"), [(CONTACT, True), (ONE, True), (TWO, False), (APERIODIC, False)]
)
def test_a_stop_follows_a_motion_that_has_settled(monkeypatch, label, loops):
    """Three turns from rest at the strobe, then one is shown; too many rows are too many."""
    rows = {123.5: 4000, 123.4: 4001}
    monkeypatch.setattr(explore_stops, "rows_per_turn", lambda follower, rpm: rows[rpm])
    asked = []

    def simulate(*given, **more):
        asked.append((given, more))
        return Made(label=label, trajectory=[(0.0, 1.0, 7.0, 8.0, 5.0), (9.0,) * 5])

    monkeypatch.setattr(explore_stops, "simulate", simulate)
    monkeypatch.setattr(explore_stops, "start_of", lambda machine, rpm, q, v: (rpm + q, -v))
    own = machine()
    own.system = Made(strobe=0.5, follower=None)
    own.settings = Settings(30, 40, 1e-9, 1000, Start(9.0, 9.0, 9.0))
    found = explore_stops._settled(own, 123.46)
    assert (found.rpm, found.q, found.v, found.system) == (123.5, 130.5, -8.0, own.system)
    assert (found.label, found.turns, found.loops, found.origin) == (label, 1, loops, STOP)
    (((system, rpm, settings, samples), more),) = asked
    assert (system, rpm, samples, more) == (own.system, 123.5, 1, {"follow": False})
    assert (settings.transient, settings.record) == (3, 2)
    assert settings.start == Start(None, None, 0.5)
    assert explore_stops._settled(own, 123.44) is None


def test_the_nearest_event_is_of_its_kind_and_turns_and_counts_round_the_turn():
    events = [event("impact", 0, 12.0, 0.1), event("impact", 1, 358.0, 0.2),
              event("impact", 2, 1.5, 0.3), event("chatter", 0, 2.0, 0.4)]  # fmt: skip

    def nearest(turns, deg):
        found = explore_stops._nearest_event(Made(events=events), turns, "impact", radians(deg))
        return found and found.seconds

    assert (nearest(2, 2.0), nearest(3, 2.0), nearest(1, 2.0), nearest(0, 2.0)) == (
        0.2, 0.3, 0.1, None
    )  # fmt: skip
    assert (nearest(2, 355.0), nearest(2, 9.0)) == (0.2, 0.1)
    before = explore_stops._shortly_before
    assert before(event("impact", 0, 0.0, 0.5), 120.0) == pytest.approx(1.0 - 0.04)
    assert before(event("impact", 0, 0.0, 0.01), 120.0) == 0.0


def test_the_lash_is_shown_at_the_lowest_speed():
    """The blows nearest to the first and to the last angle at which the cam meets the valve."""
    struck = [event("impact", 0, 158.0, 0.1, -0.5), event("impact", 0, 203.0, 0.2, -0.75)]
    others = [event("impact", 0, 160.0, 0.3, -9.0)]
    found = page((motion(90.0, origin="stop"), others), (motion(700.0), others),
                 (motion(600.0), struck), (motion(650.0), others))  # fmt: skip
    (stop,) = explore_stops._lash(machine(), found)
    told = ("lash", 600.0, 0.001, 0.5, 0.75)
    assert stop == Stop(explore_stops.words.LASH, told, 2, pytest.approx(1.0 - 0.04))
    assert not [*explore_stops._lash(machine(seat=False), found)]
    assert not [*explore_stops._lash(machine(lash=0.0), found)]
    assert not [*explore_stops._lash(machine(), page((motion(600.0), [])))]
    assert not [*explore_stops._lash(machine(), page())]


def test_low_speeds_are_told_by_their_motions():
    """Contact from its beginning; the lift-off at 1.06 of the loss; another speed is a chatter."""
    lifts = [event("detachment", 0, 199.99999999999, 0.5), event("impact", 0, 170.0, 0.25)]
    later = [event("detachment", 0, 172.0, 0.25)]
    found = page(
        (motion(106.0, origin="up"), lifts), (motion(90.0, CONTACT, STOP, 1), []),
        (motion(106.0, ONE, STOP, 1), lifts), (motion(150.0, CHATTER, STOP, 1), later),
        (motion(130.0, CHATTER, STOP, 1), []),
    )  # fmt: skip
    stops = list(explore_stops._low_speeds(machine(), found))
    words = explore_stops.words
    assert stops == [
        Stop(words.IN_CONTACT, ("contact", 90.0), 1, 0.0),
        Stop(words.lift_off("b"), ("lift_off", 106.0, 100.0, "b"), 2,
             pytest.approx(0.5 * 106.0 / 60.0 - 0.04)),
        Stop(words.CHATTER, ("chatter", 150.0), 3, pytest.approx(0.25 * 2.5 - 0.04)),
    ]  # fmt: skip
    assert explore_stops._place(machine(), radians(200.001)) == words.angle(200.001)


def test_the_first_corner_impact_that_a_motion_is_near_to():
    """One that attracts before a nearer one that does not; never a start or a point of a map."""
    hits = [event("impact", 0, 10.0, 0.1), event("impact", 1, 199.0, 0.25)]
    bifurcations = [Made(kind="fold", label=ONE, value=690.0, corner=""),
                    Made(kind="corner-impact", label=TWO, value=600.0, corner="a"),
                    Made(kind="corner-impact", label=ONE, value=690.0, corner="b")]  # fmt: skip
    motions = [
        motion(690.0, origin="start"), motion(690.0, origin="map"), motion(690.0, origin=STOP),
        motion(690.0, TWO), motion(690.0, origin="solved", stable=False), motion(705.0),
        motion(680.0, origin="solved"), motion(621.0, TWO),
    ]  # fmt: skip

    def stops(*motions, **own):
        pairs = [(one, hits) for one in motions]
        return list(
            explore_stops._corner_impact(machine(**own), page(*pairs, bifurcations=bifurcations))
        )

    told = ("corner_impact", 690.0, ONE, "b")
    name = explore_stops.words.corner_impact("b")
    t = 0.25 * 680.0 / 60.0 - 0.04
    assert stops(*motions) == [Stop(name, told, 6, pytest.approx(t), close=True)]
    assert [one.motion for one in stops(*motions, start=700.0, stop=600.0)] == [6]
    assert [one.motion for one in stops(*motions[:5])] == [4]
    assert stops(*motions[:4]) == []
    assert stops(motion(690.0, turns=1))[0].t == pytest.approx(0.1 * 11.5 - 0.04)
    assert stops(motion(690.0, turns=0)) == []
    assert stops(motion(670.0)) != []
    assert stops(motion(669.9)) == []
    assert list(explore_stops._corner_impact(machine(), page())) == []


def test_the_middle_speed_of_motions_that_are_alike(monkeypatch):
    """One impact a turn in the order of speeds, chaos in that of the page; of two the second."""
    speeds = [(640.0, ONE), (620.0, ONE), (660.0, TWO), (610.0, ONE), (630.0, ONE),
              (650.0, CONTACT), (655.0, Label((2.0,))), (658.0, CHATTER)]  # fmt: skip
    found = page(*((motion(rpm, label), []) for rpm, label in speeds),
                 (motion(600.0, ONE, "solved"), []))  # fmt: skip
    assert list(explore_stops._once_a_turn(machine(), found)) == []
    monkeypatch.setattr(explore_stops, "detachment", lambda system: Made(first=None))
    (stop,) = explore_stops._once_a_turn(machine(), found)
    words = explore_stops.words
    assert stop == Stop(words.ONCE_A_TURN, ("once_a_turn", 630.0, ONE), 4, 0.0)
    chaos = [(600.0, ONE), (640.0, APERIODIC), (660.0, APERIODIC), (620.0, APERIODIC),
             (610.0, APERIODIC)]  # fmt: skip
    solved = [(motion(600.0, APERIODIC, origin), []) for origin in ("solved", "start", STOP)]
    found = page(*((motion(rpm, label), []) for rpm, label in chaos), *solved)
    assert list(explore_stops._chaos(machine(), found)) == [
        Stop(words.CHAOS, ("chaos", 620.0), 3, 0.0)
    ]
    assert list(explore_stops._chaos(machine(), page((motion(600.0), [])))) == []


def test_a_doubling_lies_between_the_bifurcations_on_both_sides_of_it():
    """Its doubled orbit may stand below it; the neighbours limit it, whatever their order."""

    def bifurcation(kind, value):
        return Made(kind=kind, label=TWO, value=value)

    events = [bifurcation("fold", 650.0), bifurcation("period-doubling", 620.0),
              bifurcation("grazing", 600.0), bifurcation("fold", 590.0),
              bifurcation("fold", 700.0)]  # fmt: skip
    double = Label((1.0, 2.0, 2.0, 1.0))  # six impacts in four turns
    speeds = [(649.0, double), (599.0, double), (651.0, double), (605.0, double),
              (610.0, Label((2.0, 2.0, 2.0))), (640.0, double), (600.0, double),
              (630.0, Label((1.0, 2.0, 1.0, 1.0)))]  # fmt: skip
    found = page(*((motion(rpm, label), []) for rpm, label in speeds), bifurcations=events)
    words = explore_stops.words
    assert list(explore_stops._doubling(machine(), found)) == [
        Stop(words.DOUBLING, ("doubling", 620.0, TWO, double, 640.0), 5, 0.0)
    ]


def test_two_motions_of_the_middle_one_of_the_speeds_with_the_shortest_periods():
    pairs = [(660.0, APERIODIC, ONE), (640.0, TWO, ONE), (650.0, ONE, TWO), (600.0, ONE, TWO),
             (610.0, THREE, ONE), (620.0, CONTACT, TWO)]  # fmt: skip
    motions = [motion(rpm, label) for rpm, *labels in pairs for label in labels]
    motions[0:0] = [motion(650.0, "undecided"), motion(630.0, ONE), motion(630.0, ONE)]
    found = page(*((one, []) for one in motions))
    words = explore_stops.words
    assert list(explore_stops._two_motions(machine(), found)) == [
        Stop(words.TWO_MOTIONS, ("two_motions", 640.0, ONE, TWO), 6, 0.0)
    ]


@pytest.mark.parametrize(("turns", "shown"), [(3, 600.0), (5, 610.0)])
def test_chaos_is_as_long_as_four_turns(turns, shown):
    long = Label((2.0,) + (1.0,) * (turns - 1))
    labels = {600.0: (long, TWO), 610.0: (APERIODIC, TWO)}
    motions = [motion(rpm, label) for rpm, both in labels.items() for label in both]
    (stop,) = explore_stops._two_motions(machine(), page(*((one, []) for one in motions)))
    assert stop.words[1] == shown


def test_the_hardest_landing_is_one_that_the_page_shows(monkeypatch):
    soft = [event("impact", 0, 0.0, 0.1, -1.0), event("impact", 2, 0.0, 0.2, -9.0)]
    hard = [event("impact", 1, 0.0, 0.3, -3.0), event("chatter", 0, 0.0, 0.4, -8.0)]
    found = page((motion(600.0, origin="solved"), [event("impact", 0, 0.0, 0.1, -7.0)]),
                 (motion(620.0), soft), (motion(640.0), hard), (motion(660.0), soft))  # fmt: skip
    words = explore_stops.words
    assert list(explore_stops._hard_landing(machine(), found)) == [
        Stop(words.HARD_LANDING, ("hard_landing", 640.0, 3.0), 2,
             pytest.approx(0.3 * 640.0 / 60.0 - 0.04))
    ]  # fmt: skip
    assert list(explore_stops._hard_landing(machine(), page((motion(600.0), [])))) == []
    monkeypatch.setattr(Says, "valve", False)
    assert list(explore_stops._hard_landing(machine(), found)) == []


def test_stops_go_from_standstill_to_chaos(monkeypatch):
    """Two motions and the hardest landing come last."""
    kinds = ["lash", "low_speeds", "once_a_turn", "corner_impact", "doubling", "chaos",
             "two_motions", "hard_landing"]  # fmt: skip
    for kind in kinds:
        stops = lambda machine, found, kind=kind: iter([(kind, machine, found)] * 2)  # noqa: E731
        monkeypatch.setattr(explore_stops, f"_{kind}", stops)
    assert explore_stops.stops_of("machine", "found") == [
        (kind, "machine", "found") for kind in kinds for _ in range(2)
    ]
