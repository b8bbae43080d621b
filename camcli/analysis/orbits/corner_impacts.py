"""What a corner impact does to an orbit: the normal form's prediction beside a simulation.

Near the corner the return map is continuous and piecewise smooth in the phase of the impact; with
x proportional to (theta_k - corner) it is the border-collision normal form with the one-sided
traces and determinants (Osorio, di Bernardo & Santini, Corner-impact bifurcations: a novel class of
discontinuity-induced bifurcations in cam-follower systems, arXiv:0711.1008).
The fixed point of side L lies at x = mu/(1 - tau_L + delta_L), which gives the sign of mu for
either direction of the parameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

from camcli.analysis.border_collision import Collision, Prediction, Side, classify
from camcli.analysis.exponents import of_record
from camcli.analysis.integrate import Settings, Start, with_turns
from camcli.analysis.labels import APERIODIC, LONGEST_PERIOD, UNDECIDED, Label, label
from camcli.analysis.orbits.identify import identify, passages, settled
from camcli.analysis.orbits.locate import Crossing
from camcli.analysis.orbits.orbit import section_states
from camcli.analysis.orbits.same_orbit import distance_to
from camcli.analysis.orbits.shooter import Shooter, with_machine
from camcli.errors import Status
from camcli.kernel.flow import RPM
from camcli.system import omega_of

ASIDE = 1e-6  # relative change of the parameter at which the simulation looks
NUDGE = 1e-3  # of the orbit's way from the corner, the start beside a known orbit
REACH = 3e-2  # relative distance from the corner's orbit that still counts as beside it
CLOSER, SHRINKS = 64.0, 8.0  # a second look so much closer, and how much nearer it must stay
SETTLE = 3000  # turns; multipliers near 1 are common at a corner


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
    """Both one-sided linear parts, the classification, and the check on both sides."""

    left: Side
    right: Side
    collision: Collision
    below: OneSide
    above: OneSide


def corner_impact(shooter: Shooter, crossing: Crossing, settings: Settings) -> CornerImpact:
    """Classify a corner impact and compare it with simulations on both sides of it."""
    left = Side(crossing.left.trace, crossing.left.det)
    right = Side(crossing.right.trace, crossing.right.det)
    collision = classify(left, right)
    below, above = (_one_side(shooter, crossing, collision, settings, side) for side in (-1, 1))
    return CornerImpact(left, right, collision, below, above)


def mu_sign(crossing: Crossing, side: int) -> int:
    """Sign of mu where the parameter is above (side 1) or below (-1) its value at the corner."""
    root = crossing.left
    rising = (root.tangent[2 * crossing.impact] < 0.0) == (root.tangent[-1] < 0.0)
    gain = 1.0 - root.trace + root.det
    sign = (1 if rising else -1) * (1 if gain > 0.0 else -1)
    return sign * side


def _one_side(
    shooter: Shooter, crossing: Crossing, collision: Collision, settings: Settings, side: int
) -> OneSide:
    """The prediction and the simulation on one side of the parameter."""
    mu = mu_sign(crossing, side)
    predicted = collision.above if mu > 0 else collision.below
    turns = crossing.left.turns
    seen = _simulated(shooter, crossing, settings, side * ASIDE)
    stays, agrees = seen.stays, _agree(predicted, seen.label, seen.stays, turns)
    if agrees is False and stays:  # what shrinks with the distance is of the corner's making
        closer = _simulated(shooter, crossing, settings, side * ASIDE / CLOSER)
        if closer.far * SHRINKS > seen.far:
            stays = False
            agrees = _agree(predicted, seen.label, stays, turns)
    return OneSide(seen.value, mu, predicted, seen.label, stays, agrees)


@dataclass(frozen=True)
class _Simulated:
    """A simulation beside the corner, and its largest distance from the corner's orbit."""

    value: float
    label: str
    far: float
    stays: bool


def _simulated(
    shooter: Shooter, crossing: Crossing, settings: Settings, aside: float
) -> _Simulated:
    """Simulate at a relative distance `aside` of the parameter from the corner impact."""
    at = crossing.left.value
    value = at + aside * max(abs(at), shooter.scale)
    start = _start(shooter, crossing, value)
    system, rpm = with_machine(shooter.system, shooter.at(value))
    run = with_turns(settings, SETTLE, 2 * LONGEST_PERIOD + 2)
    record = shooter.simulate(system, rpm, run, start)
    orbit = identify(system, rpm, record)
    name = _unsolved(system, rpm, record) if orbit is None else orbit.label
    states = section_states(shooter.system, crossing.left)[0]
    far = max((distance_to(state, states) for state in passages(record)[0]), default=1.0)
    return _Simulated(value, name, far, record.status == Status.OK and far <= REACH)


def _start(shooter: Shooter, crossing: Crossing, value: float) -> Start:
    """Beside an attracting orbit at this value if there is one, else beside the corner's orbit."""
    corner = section_states(shooter.system, crossing.left)[0][0]
    best = None
    for root in (crossing.left, crossing.right):
        beside = shooter.moved(root, value)
        beside = None if beside is None else settled(shooter, beside)
        if beside is None or not shooter.admits(beside):
            continue
        side = Side(beside.trace, beside.det)
        rank = 2 if side.stable else int(side.at_one > 0.0)  # the far side of a saddle leads away
        if best is None or rank > best[0]:
            best = rank, beside
    root = crossing.left if best is None else best[1]
    q, w = section_states(shooter.system, root)[0][0]
    omega = omega_of(shooter.at(value)[RPM])
    shift = max(NUDGE * hypot(q - corner[0], w - corner[1]), 1e-13 * abs(q))
    return Start(q + shift, w * omega, shooter.system.strobe_deg)


def _unsolved(system, rpm: float, record) -> str:
    """The label of a record without a solved orbit; chaos may be very small beside a corner."""
    exponents = of_record(system, rpm, record) if record.status == Status.OK else None
    if exponents is not None and exponents.chaotic:
        return APERIODIC
    return UNDECIDED if any(record.chatter) else label(record)


def _agree(predicted: Prediction, simulated: str, stays: bool, turns: int) -> bool | None:
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
