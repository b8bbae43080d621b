"""What pictures and tables say of an event on a branch, and of a border collision."""

from math import pi

from camcli.analysis.border_collision import DECIDED, THEOREM, Collision, Cycle, Prediction
from camcli.analysis.orbits.corner_impacts import OneSide
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.study import Bifurcation
from camcli.kernel.cam_table import TURN

DEG = 180.0 / pi
SIDES = {-1: "Where the normal form's parameter is below 0", 1: "Where it is above 0"}

KINDS = {
    "degenerate": "an equality holds within rounding: the linear parts do not decide",
    "dangerous": "a stable fixed point on both sides, yet its basin shrinks to nothing between",
    "robust-chaos": "a chaotic attractor on one side, and for all linear parts close to these",
    "no-attractor": "something attracts on one side, nothing bounded on the other",
    "nonsmooth-fold": "two fixed points are born on one side, there is none on the other",
    "border-period-doubling": "a fixed point on each side, and a cycle LR is born on one of them",
    "persistence": "a fixed point on each side, and no cycle LR is born",
}


def event_words(b: Bifurcation) -> list[str]:
    """Sentences on one event: how an orbit grazes, what a corner impact does, what lies beyond."""
    if b.located is None:
        return [f"beyond it a run settles on {b.beyond or 'nothing that could be solved'}."]
    if b.kind == Kind.GRAZING:
        found = b.located
        if found.fading is not None:
            place = f"{found.root.theta[found.fading] * DEG:.8g} deg"
            return [f"the impact at {place} fades to zero velocity."]
        flight = f"the flight after impact {found.impact + 1}"
        return [f"beyond it {flight} meets the cam at {(found.phase % TURN) * DEG:.8g} deg."]
    if b.corner_impact is None:
        return []
    below, above = _side_words(b.corner_impact.below), _side_words(b.corner_impact.above)
    sides = [f"Just below it {below}.", f"Just above it {above}."]
    return [*collision_words(b.corner_impact.collision), *sides]


def _side_words(side: OneSide) -> str:
    """What a simulation shows, and whether that was predicted."""
    verdict = {True: "as", False: "NOT as", None: "beside what was"}[side.agrees]
    predicted = {
        "none": "nothing attracts nearby",
        "fixed-point": "an orbit of the same period",
        "cycle": f"an orbit of {side.predicted.period} times the period",
        "chaos": "chaos",
        "several": f"several: {side.predicted.word}",
        "undecided": "not decided",
    }[side.predicted.kind]
    shown = f"stays near, {side.label}" if side.stays else f"leaves for {side.label}"
    return f"a simulation {shown}, {verdict} predicted ({predicted})"


def collision_words(found: Collision) -> list[str]:
    """Sentences: the class, what is open, what attracts, and why there is no robust chaos."""
    said = [f"{found.kind}: {KINDS[found.kind]}."]
    said += [f"Equal within rounding: {text}." for text in found.equal]
    if found.growth is not None and abs(found.growth.left) <= DECIDED:
        grows = f"The growth at the event, {found.growth.left:.2g} per step,"
        said.append(f"{grows} is too small to exclude danger.")
    said += [f"{SIDES[-1]}, {_ends(found.below)}.", f"{SIDES[1]}, {_ends(found.above)}."]
    return said + _two_cycle(found.cycles[2]) + _no_theorem(found)


def _ends(found: Prediction) -> str:
    known = found.exponent is not None
    measured = f"{found.exponent:.4g} +- {found.spread:.1g} per step" if known else ""
    return {
        "none": "nothing bounded attracts",
        "fixed-point": f"the fixed point {found.word} attracts",
        "cycle": f"the cycle {found.word} of period {found.period} attracts",
        "chaos": f"a chaotic attractor, largest exponent {measured}",
        "several": f"several attract: {found.word}",
        "undecided": f"not decided, orbits stay bounded: {found.word or 'no period'}, {measured}",
    }[found.kind]


def _two_cycle(found: Cycle) -> list[str]:
    if not found.exists_for:
        return []
    first = found.multipliers[0]
    size = f"larger multiplier {first.real:.6g}"
    if first.imag != 0.0:
        size = f"multipliers {first.real:.6g} +- {first.imag:.6g} i"
    state = "stable" if found.stable else "unstable"
    return [f"{SIDES[found.exists_for]}, the cycle LR exists and is {state}: {size}."]


def _no_theorem(found: Collision) -> list[str]:
    last = found.chaos[-1]
    if len(found.chaos) < 2 or last.holds:
        return []
    numbers = f"{last.left:.6g} against {last.right:.6g}"
    open_end = ", which leaves it open whether a chaotic attractor exists"
    more = open_end if len(found.chaos) == THEOREM else ""
    return [f"The theorem on robust chaos does not apply: {last.text} fails, {numbers}{more}."]
