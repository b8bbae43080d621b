"""What a corner impact does to an orbit: the normal form's prediction beside a simulation.

Near the corner the return map is continuous and piecewise smooth in the phase of the impact; with
x proportional to (theta_k - corner) it is the border-collision normal form with the one-sided
traces and determinants. The fixed point of side L lies at x = mu/(1 - tau_L + delta_L), which gives
the sign of mu for either direction of the parameter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot

from camcli.analysis.border_collision import Collision, Prediction, Side, classify
from camcli.analysis.exponents import of_tape
from camcli.analysis.integrate import Cost, Orbit, Settings, Start, with_turns
from camcli.analysis.labels import LONGEST_PERIOD, label
from camcli.analysis.orbits.crossing import Crossing
from camcli.analysis.orbits.identify import identify, settled
from camcli.analysis.orbits.orbit import section_states
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.errors import OK
from camcli.kernel.certify import ADMISSIBLE
from camcli.kernel.flow import RPM
from camcli.system import System, omega_of

ASIDE = 1e-6  # relative change of the parameter at which the simulation looks
NUDGE = 1e-3  # of the orbit's way from the corner, the start beside a known orbit
REACH = 3e-2  # relative distance from the corner's orbit that still counts as near
CLOSER, SHRINKS = 64.0, 8.0  # a second look so much closer, and how much nearer it must stay
SETTLE = 3000  # turns; multipliers near 1 are common at a corner


@dataclass(frozen=True)
class Beside:
    """One direction of the parameter: the normal form's word and the simulation's."""

    value: float
    mu: int
    predicted: Prediction
    simulated: str
    agrees: bool | None  # None where one of the two cannot tell

    @property
    def words(self) -> str:
        """What a simulation shows, and whether that was predicted."""
        verdict = {True: "as", False: "NOT as", None: "beside what was"}[self.agrees]
        return f"a simulation {self.simulated}, {verdict} predicted ({_said(self.predicted)})"


@dataclass(frozen=True)
class CornerImpact:
    """Both one-sided linear parts, the classification, and the check on both sides."""

    left: Side
    right: Side
    collision: Collision
    below: Beside
    above: Beside
    cost: Cost


def collide(shooter: Shooter, crossing: Crossing, settings: Settings) -> CornerImpact:
    """Classify a corner impact and compare it with simulations on both sides of it."""
    left = Side(crossing.left.trace, crossing.left.det)
    right = Side(crossing.right.trace, crossing.right.det)
    collision = classify(left, right)
    below, cost = _beside(shooter, crossing, collision, settings, -1)
    above, more = _beside(shooter, crossing, collision, settings, 1)
    return CornerImpact(left, right, collision, below, above, cost + more)


def mu_sign(crossing: Crossing, side: int) -> int:
    """Sign of mu where the parameter is above (side 1) or below (-1) its value at the corner."""
    root = crossing.left
    rising = (root.tangent[2 * crossing.impact] < 0.0) == (root.tangent[-1] < 0.0)
    gain = 1.0 - root.trace + root.det
    sign = (1 if rising else -1) * (1 if gain > 0.0 else -1)
    return sign * side


def _beside(shooter, crossing: Crossing, collision: Collision, settings: Settings, side: int):
    """The prediction and the simulation on one side of the parameter."""
    mu = mu_sign(crossing, side)
    predicted = collision.above if mu > 0 else collision.below
    seen = _look(shooter, crossing, settings, side * ASIDE)
    cost = seen.cost
    agrees = _agrees(predicted, seen.label, seen.near, crossing.left.turns)
    if agrees is False and seen.near:  # what shrinks with the distance is of the corner's making
        closer = _look(shooter, crossing, settings, side * ASIDE / CLOSER)
        cost = cost + closer.cost
        if closer.far * SHRINKS > seen.far:
            seen = replace(seen, near=False)
            agrees = _agrees(predicted, seen.label, False, crossing.left.turns)
    words = f"stays near, {seen.label}" if seen.near else f"leaves for {seen.label}"
    return Beside(seen.value, mu, predicted, words, agrees), cost


@dataclass(frozen=True)
class _Seen:
    """What a simulation beside the corner shows, and its distance from the corner's orbit."""

    value: float
    label: str
    far: float
    near: bool
    cost: Cost


def _look(shooter: Shooter, crossing: Crossing, settings: Settings, aside: float) -> _Seen:
    """Simulate at a relative distance `aside` of the parameter from the corner impact."""
    at = crossing.left.value
    value = at + aside * max(abs(at), shooter.scale)
    machine = shooter.at(value)
    tape = _simulate(shooter.system, machine, settings, _start(shooter, crossing, value))
    simulated, far = _name(shooter.system, machine, tape, crossing.left)
    return _Seen(value, simulated, far, tape.status == OK and far <= REACH, tape.cost)


def _start(shooter: Shooter, crossing: Crossing, value: float) -> Start:
    """Beside an attracting orbit at this value if there is one, else beside the corner's orbit."""
    corner = section_states(shooter.system, crossing.left)[0][0]
    best = None
    for root in (crossing.left, crossing.right):
        beside = shooter.at_value(root.x, root.whole, root.turns, value)
        beside = None if beside is None else settled(shooter.system, shooter, beside)
        if beside is None or shooter.verdict(beside)[0] != ADMISSIBLE:
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


def with_machine(system: System, machine) -> tuple[System, float]:
    """The system with the constants of a machine's table, and its speed."""
    rpm, mass, stiffness, damping, gravity, preload, restitution = machine
    follower = replace(
        system.follower, mass=mass, stiffness=stiffness, damping=damping, gravity=gravity,
        preload=preload, restitution=restitution,
    )  # fmt: skip
    return replace(system, follower=follower), rpm


def _simulate(system: System, machine, settings: Settings, start: Start):
    changed, rpm = with_machine(system, machine)
    run = with_turns(settings, SETTLE, 2 * LONGEST_PERIOD + 2)
    return Orbit(changed, rpm, run, start).run()


def _name(system: System, machine, tape, root: Root) -> tuple[str, float]:
    """(label of the attractor reached, its largest relative distance from the corner's orbit)."""
    changed, rpm = with_machine(system, machine)
    orbit = identify(changed, rpm, tape)
    name = _unsolved(changed, rpm, tape) if orbit is None else orbit.label
    states = section_states(system, root)[0]
    size = [max(abs(s[j]) for s in states) or 1.0 for j in range(2)]
    last = [(float(tape.strobe_q[k]), float(tape.strobe_w[k])) for k in range(tape.periods)]
    far = max(
        (min(max(abs(s[j] - o[j]) / size[j] for j in range(2)) for o in states) for s in last),
        default=1.0,
    )
    return name, far


def _unsolved(system: System, rpm: float, tape) -> str:
    """The label of a record without a solved orbit; chaos may be very small beside a corner."""
    exponents = of_tape(system, rpm, tape) if tape.status == OK else None
    if exponents is not None and exponents.chaotic:
        return "aperiodic"
    return "undecided" if any(tape.chatter) else label(tape)


def _agrees(predicted: Prediction, simulated: str, near: bool, turns: int) -> bool | None:
    if predicted.kind == "none":
        return not near
    if predicted.kind in ("several", "undecided") or simulated == "undecided":
        return None
    if not near:
        return False
    if predicted.kind == "chaos":
        return simulated == "aperiodic"
    period = int(simulated[2:].split(";")[0]) if simulated.startswith("P(") else 0
    return period == turns * max(1, predicted.period)


def _said(predicted: Prediction) -> str:
    return {
        "none": "nothing attracts nearby",
        "fixed-point": "an orbit of the same period",
        "cycle": f"an orbit of {predicted.period} times the period",
        "chaos": "chaos",
        "several": f"several: {predicted.word}",
        "undecided": "not decided",
    }[predicted.kind]
