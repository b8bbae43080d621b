"""The stops of explore.html: which motions they show."""

from dataclasses import replace
from types import SimpleNamespace

import camcli
from camcli.analysis.integrate import Start, with_turns
from camcli.analysis.simulate import simulate
from camcli.api.explore_stops import _low_speeds, motions_of_stops
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
