"""What a corner impact does to an orbit: the normal form's prediction beside a simulation.

Near the corner the return map is continuous and piecewise smooth in the phase of the impact; with
x proportional to (theta_k - corner) it is the border-collision normal form with the one-sided
traces and determinants (Osorio, di Bernardo & Santini, Corner-impact bifurcations: a novel class of
discontinuity-induced bifurcations in cam-follower systems, arXiv:0711.1008).
The fixed point of side L lies at x = mu/(1 - tau_L + delta_L), which gives the sign of mu for
either direction of the parameter.
"""

from dataclasses import dataclass
from math import hypot, inf
from typing import NamedTuple

from camcli.analysis.border_collision import Collision, Prediction, Side, classify
from camcli.analysis.exponents import of_record
from camcli.analysis.integrate import Settings, Start, with_turns
from camcli.analysis.labels import APERIODIC, LONGEST_PERIOD, UNDECIDED, Label, label, passages
from camcli.analysis.orbits.identify import identify, settled
from camcli.analysis.orbits.locate import Crossing
from camcli.analysis.orbits.orbit import section_states
from camcli.analysis.orbits.same_orbit import distance_to
from camcli.analysis.orbits.shooter import Shooter, with_machine
from camcli.errors import Status

ASIDE = 1e-6  # relative change of the parameter at which the simulation looks
NUDGE = 1e-3  # of the orbit's way from the corner, the start beside a known orbit
BESIDE_CORNER = 3e-2  # relative distance from the corner's orbit that still counts as beside it
CLOSER = 64.0  # so many times nearer to the corner a second simulation looks
SHRINKS = 8.0  # so many times smaller its distance has to be, at least
CORNER_SETTLE = 3000  # turns; multipliers near 1 are common at a corner


@dataclass(frozen=True)
class OneSide:
    """One direction of the parameter: what the normal form predicts, what a simulation shows.

    value: of the parameter at which is simulated; mu: its sign there; label: of the simulated
    motion; stays: whether it stays beside the corner's orbit; agrees: None where one of the two
    cannot tell.
    """

    value: float
    mu: int
    predicted: Prediction
    label: str
    stays: bool
    agrees: bool | None


@dataclass(frozen=True)
class CornerImpact:
    """Both one-sided linear parts, the classification, and the check on both sides.

    agrees: whether the simulations on both sides are as predicted; None where one cannot tell.
    """

    left: Side
    right: Side
    collision: Collision
    below: OneSide
    above: OneSide

    @property
    def agrees(self) -> bool | None:
        agree = (self.below.agrees, self.above.agrees)
        return None if None in agree else all(agree)


def corner_impact(shooter: Shooter, crossing: Crossing, settings: Settings) -> CornerImpact:
    """Classify a corner impact and compare it with simulations on both sides of it."""
    left = Side(crossing.left.trace, crossing.left.det)
    right = Side(crossing.right.trace, crossing.right.det)
    collision = classify(left, right)
    root = crossing.left
    rising = (root.tangent[2 * crossing.impact] < 0.0) == (root.tangent[-1] < 0.0)
    mu_above = 1 if rising == (1.0 - root.trace + root.det > 0.0) else -1  # its sign

    def one_side(side: int) -> OneSide:
        """What is predicted and what is simulated at `side` (-1, 1) of the corner's value."""
        mu = mu_above * side
        predicted = collision.above if mu > 0 else collision.below
        run = _simulated(shooter, crossing, settings, side * ASIDE)
        stays = run.distance <= BESIDE_CORNER
        if run.broke_off:
            return OneSide(run.value, mu, predicted, run.label, stays, None)
        agrees = _agree(predicted, run.label, stays, root.turns)
        if agrees is False and stays:  # what shrinks with the distance is of the corner's making
            nearer = _simulated(shooter, crossing, settings, side * ASIDE / CLOSER)
            if not nearer.broke_off and nearer.distance * SHRINKS > run.distance:
                stays = False
                agrees = _agree(predicted, run.label, stays, root.turns)
        return OneSide(run.value, mu, predicted, run.label, stays, agrees)

    return CornerImpact(left, right, collision, below=one_side(-1), above=one_side(1))


class SimulatedSide(NamedTuple):
    """A run beside a corner impact: the parameter, its label, its distance from the orbit there.

    distance: the largest of its states, relative; infinite where the run did not end well.
    broke_off: whether numerical trouble ended it. A follower that never returns is no such trouble.
    """

    value: float
    label: str
    distance: float
    broke_off: bool


def _simulated(
    shooter: Shooter, crossing: Crossing, settings: Settings, aside: float
) -> SimulatedSide:
    """A run at a value of the parameter `aside` of the corner's, relatively."""
    at_corner = crossing.left.value
    value = at_corner + aside * max(abs(at_corner), shooter.scale)
    start = _start(shooter, crossing, value)
    system, rpm = with_machine(shooter.system, shooter.at(value))
    run = with_turns(settings, CORNER_SETTLE, 2 * LONGEST_PERIOD + 2)
    record = shooter.simulate(system, rpm, run, start)
    orbit = identify(system, rpm, record)
    ok = record.status == Status.OK
    if orbit is not None:
        name = orbit.label
    else:  # chaos may be very small beside a corner
        exponents = of_record(system, rpm, record) if ok else None
        if exponents is not None and exponents.chaotic:
            name = APERIODIC
        else:
            name = UNDECIDED if any(record.chatter) else label(record)
    if not ok:
        return SimulatedSide(value, name, inf, broke_off=record.status != Status.NO_RETURN)
    states_at_corner = section_states(shooter.system, crossing.left)[0]
    states = passages(record)[0]
    distance = max((distance_to(state, states_at_corner) for state in states), default=1.0)
    return SimulatedSide(value, name, distance, broke_off=False)


def _start(shooter: Shooter, crossing: Crossing, value: float) -> Start:
    """Where a run at a value of the parameter starts: near an orbit there, or the corner's orbit.

    Of the orbits with the impact on either side of the corner those that are motions are taken into
    account: an attracting one first, then one without a multiplier above 1 (1 - trace + det > 0),
    since from a saddle half of the starts lead away; at last the corner's own. The start is off the
    orbit by NUDGE of that orbit's distance from the corner's.
    """
    states_at_corner, _ = section_states(shooter.system, crossing.left)
    corner_q, corner_w = states_at_corner[0]
    best_rank = -1
    best = crossing.left
    for guess in (crossing.left, crossing.right):
        beside = settled(shooter, shooter.moved(guess, value))
        if beside is None or not shooter.admits(beside):
            continue
        side = Side(beside.trace, beside.det)
        rank = 2 if side.stable else int(side.at_one > 0.0)
        if rank > best_rank:
            best_rank = rank
            best = beside
    states, _ = section_states(shooter.system, best)
    q, w = states[0]
    shift = max(NUDGE * hypot(q - corner_q, w - corner_w), 1e-13 * abs(q))
    system, rpm = with_machine(shooter.system, shooter.at(value))
    return Start.at_strobe(system, rpm, (q + shift, w))


def _agree(predicted: Prediction, simulated: str, stays: bool, turns: int) -> bool | None:
    """Whether a simulation agrees with the prediction; None where that cannot be told.

    simulated: the label of its motion; stays: it remained near the corner's orbit; turns: those of
    the orbit that meets the corner.
    """
    if predicted.kind == "none":
        return not stays
    if predicted.kind in ("several", "undecided") or simulated == UNDECIDED:
        return None
    if not stays:
        return False
    if predicted.kind == "chaos":
        return simulated == APERIODIC
    period = len(simulated.symbols) if isinstance(simulated, Label) else 0
    return period == turns * max(1, predicted.period)
