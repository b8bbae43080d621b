"""What is said of an event on a branch."""

from math import degrees

from camcli.analysis.orbits.corner_impacts import CornerImpact, OneSide
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.study import Bifurcation
from camcli.kernel.cam_table import TURN
from camcli.words.border_collision import KINDS, collision_words


def event_words(event: Bifurcation) -> list[str]:
    """Sentences on one event: how an orbit grazes, what a corner impact does, what lies beyond."""
    located = event.located
    if located is None:  # of an orbit that rests: a run on the other side tells what comes
        if event.beyond:
            return [f"a simulation just beyond it settles on {event.beyond}."]
        return ["no periodic orbit was found in a simulation just beyond it."]
    if event.kind == Kind.GRAZING:
        if located.fading is not None:
            place = f"{degrees(located.root.theta[located.fading]):.8g} deg"
            return [f"the impact at {place} fades to zero velocity."]
        flight = f"the flight after impact {located.impact + 1}"
        place = f"{degrees(located.phase % TURN):.8g} deg"
        return [f"beyond it {flight} has a further impact, at {place}."]
    impact = event.corner_impact
    if impact is None:
        return []
    return [
        *collision_words(impact.collision),
        f"Just below it {_side_words(impact.below)}.",
        f"Just above it {_side_words(impact.above)}.",
    ]


def corner_line(impact: CornerImpact) -> str:
    """The class of a corner impact, and whether simulations on both sides agree with it."""
    kind = impact.collision.kind
    agreement = {
        True: "; simulations on both sides agree",
        False: "; a simulation does NOT agree",
        None: "",
    }[impact.agrees]
    return f"{kind}, {KINDS[kind]}{agreement}"


def _side_words(side: OneSide) -> str:
    """What a simulation on one side of an event shows, and whether that was predicted."""
    predicted = {
        "none": "nothing attracts nearby",
        "fixed-point": "an orbit of the same period",
        "cycle": f"an orbit of {side.predicted.period} times the period",
        "chaos": "chaos",
        "several": f"several: {side.predicted.word}",
        "undecided": "not decided",
    }[side.predicted.kind]
    shown = f"stays near it on {side.label}" if side.stays else f"leaves for {side.label}"
    if side.agrees is None:
        return f"a simulation {shown}, which the prediction ({predicted}) does not decide"
    return f"a simulation {shown}, {'as' if side.agrees else 'NOT as'} predicted ({predicted})"
