"""The stops of explore.html: which motions they show."""

from dataclasses import replace
from math import cos, pi, radians, sin
from types import SimpleNamespace

import pytest
from scipy.optimize import brentq

import camcli
from camcli.analysis.integrate import Start, with_turns
from camcli.analysis.labels import APERIODIC, CONTACT, Label
from camcli.analysis.simulate import simulate
from camcli.api.explore_stops import (
    _doubling,
    _low_speeds,
    _once_a_turn,
    _settled,
    _two_motions,
    motions_of_stops,
    stops_of,
)
from camcli.api.machine import machine_of


def test_a_chatter_just_above_the_lift_off_is_told_as_one():
    """Its speed, told with four digits, is 1e-4 below 1.15 times that of the lift-off.

    The page of this scene had two stops on its lift-off, and none on its chatter.
    """
    machine = machine_of(camcli.load_scene("configs/law-smooth.yaml"))
    motions = motions_of_stops(machine)
    settings = with_turns(machine.settings, 0, 1)
    simulations = [
        simulate(
            machine.system,
            one.rpm,
            replace(settings, start=Start(one.q, one.v, machine.system.strobe)),
            1,
        )
        for one in motions
    ]
    found = SimpleNamespace(motions=motions, simulations=simulations)
    names = [stop.name for stop in _low_speeds(machine, found)]
    assert names == ["Contact", "Lift-off at 134.7°", "Chatter"]


def found_motions(*motions, events=()):
    """What a page has found: motions of sweeps (rpm, label), and events (kind, label, rpm)."""
    swept = [
        SimpleNamespace(rpm=rpm, label=label, origin="fixed", stable=None) for rpm, label in motions
    ]
    solved = [SimpleNamespace(kind=kind, label=label, value=rpm) for kind, label, rpm in events]
    orbits = SimpleNamespace(values=SimpleNamespace(bifurcations=solved))
    return SimpleNamespace(motions=swept, parts={"orbits": orbits})


ONE, TWO, LONG = Label((1.0,)), Label((1.0, 1.0)), Label((1.0,) * 39 + (2.0,))


def test_a_doubling_is_shown_in_the_middle_of_its_speeds():
    """Just past it nobody sees two turns; past the next bifurcation it is another orbit."""
    machine = machine_of(camcli.load_scene(None))
    doubled = [(rpm, TWO) for rpm in (690.0, 701.0, 705.0, 711.0, 722.0, 723.0, 724.0)]
    events = [("fold", ONE, 695.0), ("period-doubling", ONE, 700.0), ("grazing", TWO, 715.0)]
    (stop,) = _doubling(machine, found_motions((699.0, ONE), *doubled, events=events))
    assert stop.name == "Period doubling"
    assert stop.motion == 3
    assert stop.words == (
        "At 700 rpm P(1;1) becomes unstable and its period doubles: at 705 rpm it is P(2;1:1), "
        "each turn unlike the one before."
    )
    three = [(rpm, Label((1.0, 2.0))) for rpm in (701.0, 705.0)]  # not the same impacts
    assert not [*_doubling(machine, found_motions(*three, events=events))]
    assert not [*_doubling(machine, found_motions(*doubled, events=events[:1]))]
    assert not [*_doubling(machine, SimpleNamespace(motions=[], parts={}))]


def test_two_motions_are_those_that_an_eye_can_follow():
    """Not an orbit of 40 turns, which no eye tells from chaos, where there is one of two."""
    machine = machine_of(camcli.load_scene(None))
    both = [(680.0, ONE), (680.0, LONG), (690.0, ONE), (690.0, TWO), (691.0, ONE), (691.0, TWO)]
    more = [(692.0, TWO), (692.0, ONE), (700.0, ONE), (700.0, APERIODIC), (710.0, ONE)]
    (stop,) = _two_motions(machine, found_motions(*both, *more))
    assert stop.motion == 4
    assert stop.words.startswith("At 691 rpm the same machine runs in two ways, P(1;1) or P(2;1:1)")
    (stop,) = _two_motions(machine, found_motions(*both[:2], *more[2:4], (720.0, CONTACT)))
    assert stop.motion == 2
    assert "P(1;1) or chaos" in stop.words
    assert not [*_two_motions(machine, found_motions((710.0, ONE), (720.0, CONTACT)))]


def test_an_engine_has_stops_on_its_lash_and_on_its_hardest_landing():
    """The blow that takes up the lash is the slope of the lift where it is the lash, times omega.

    The rise is a modified sine of 10 mm over 65 degrees, from its first eighth to its last
    s = h (2 + pi x - 9/4 sin(pi/3 + 4/3 pi x)) / (4 + pi), of which an eighth lifts 0.2 mm.
    """
    speeds = {"sweep.rpm": {"start": 2800, "stop": 4000, "num": 3}, "orbits.starts": 0}
    result = camcli.explore(camcli.load_scene("configs/valve-lash.yaml", speeds))
    scene = result.scene
    stops = {stop.name: stop for stop in stops_of(machine_of(scene), result.values)}
    assert list(stops) == ["Lash", "Lift-off at 186.2°", "Chatter", "Hard landing"]
    lift, length, lash = scene.cam.lift, radians(scene.cam.rise.length_deg), scene.cam.lash

    def lifted(x):
        return lift * (2 + pi * x - 2.25 * sin(pi / 3 + 4 / 3 * pi * x)) / (4 + pi)

    x = brentq(lambda x: lifted(x) - lash, 0.125, 0.875)
    slope = lift * pi * (1 - 3 * cos(pi / 3 + 4 / 3 * pi * x)) / (4 + pi) / length
    blow = slope * 2800 * pi / 30
    assert f"strikes the valve train at {blow:.3g} m/s" in stops["Lash"].words
    assert f"strikes the seat at {blow:.3g} m/s" in stops["Lash"].words  # the fall is its mirror
    opens = (scene.cam.rise.start_deg + scene.cam.rise.length_deg * x) / 360.0
    assert stops["Lash"].t == pytest.approx(opens - 0.04, abs=1e-6)
    swept = camcli.sweep(camcli.load_scene("configs/valve-lash.yaml", speeds)).tables["speeds"]
    hardest = swept["max_impact_m_per_s"].max()
    assert f"lands hardest, at {hardest:.3g} m/s" in stops["Hard landing"].words
    shown = result.values.motions[stops["Hard landing"].motion]
    assert shown.rpm == swept["rpm"][swept["max_impact_m_per_s"].argmax()]


def test_a_follower_that_never_rests_first_bounces_once_a_turn():
    """The eccentric turns below the spring without a load: the force is never of one sign."""
    machine = machine_of(camcli.load_scene("configs/eccentric.yaml"))
    swept = found_motions((26, TWO), (22, ONE), (19, ONE), (24, ONE), (21, APERIODIC))
    (stop,) = _once_a_turn(machine, swept)
    assert (stop.name, stop.motion) == ("Once a turn", 1)
    assert "At 22 rpm" in stop.words
    assert not list(_once_a_turn(machine, found_motions((26, TWO))))
    chapter = machine_of(camcli.load_scene(None))  # it loses contact at 114.98 rpm
    assert not list(_once_a_turn(chapter, swept))


def test_a_stop_begins_with_the_state_at_its_strobe():
    """At rest on the flank it has the cam's own velocity; in flight its position and velocity."""
    on_the_flank = machine_of(camcli.load_scene(None, {"run.strobe_deg": 120.0}))
    still = _settled(on_the_flank, 90.0)
    assert (still.label, still.q, still.v) == (CONTACT, None, None)
    values = {"run.strobe_deg": 200.0, "run.rpm": 190.0, "run.transient": 40, "run.record": 1}
    flying = _settled(machine_of(camcli.load_scene(None, values)), 190.0)
    table = camcli.simulate(camcli.load_scene(None, values)).tables["trajectory"]
    assert table["contact"][0] == "flight"
    wanted = table["q_m"][0], table["v_m_per_s"][0]
    assert (flying.q, flying.v) == pytest.approx(wanted, rel=1e-9)
    assert abs(flying.v) > 0.01
