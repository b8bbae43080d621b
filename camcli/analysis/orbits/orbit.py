"""A periodic orbit as the user sees it: label, phases, section states, multipliers, verdict."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from camcli.analysis.bracketing import lowest
from camcli.analysis.labels import CONTACT, Label, rotation
from camcli.analysis.multipliers import attracts, multipliers
from camcli.analysis.orbits.same_orbit import shortest_period
from camcli.analysis.orbits.shooter import Root
from camcli.kernel.arithmetic import exp_decay
from camcli.kernel.cam_table import TURN, Cam, lift, stretch_at
from camcli.kernel.certify import Verdict
from camcli.kernel.flow import RPM, flow, move
from camcli.system import System

SAMPLES = 32  # of the lift on a smooth stretch, between which it has one maximum at most
DIGITS = 12  # significant digits that decide between rotations of one label


@dataclass(frozen=True)
class PeriodicOrbit:
    """An orbit of `turns` turns, its turns in the rotation that names it.

    value: of the parameter; theta: impact phases (rad in the turn), of a resting orbit the phases
    at which it leaves the cam; rates: incoming m/rad; states: (q m, dq/dtheta m/rad) at the strobe
    that begins each turn; symbols: impacts in each turn, inf for a complete chatter; verdict:
    whether it is a motion, or why not. A resting orbit sticks somewhere: its multipliers are zero.
    Of one that never meets the cam (`free_orbit`) theta and rates are empty.
    """

    rpm: float
    value: float
    turns: int
    symbols: tuple[float, ...]
    states: tuple[tuple[float, float], ...]
    theta: tuple[float, ...] = ()
    rates: tuple[float, ...] = ()
    regions: tuple[str, ...] = ()
    trace: float = 0.0
    det: float = 0.0
    verdict: Verdict = Verdict.ADMISSIBLE
    resting: bool = False
    root: Root | None = None

    @cached_property
    def label(self) -> str:
        """P(m;s1:...:sm), or `contact` where the follower never leaves the cam."""
        still = self.resting and not self.theta and not any(self.symbols)
        return CONTACT if still else Label(self.symbols)

    @cached_property
    def multipliers(self) -> tuple[complex, complex]:
        """Of the stroboscopic map over one period of the orbit."""
        return multipliers(self.trace, self.det)

    @property
    def admissible(self) -> bool:
        """True for a motion, False for a mere root of the equations."""
        return self.verdict is Verdict.ADMISSIBLE

    @property
    def stable(self) -> bool:
        """True where both multipliers lie inside the unit circle."""
        return attracts(self.trace, self.det)

    @property
    def impacts(self) -> int:
        """Impacts in one period that are solved for."""
        return len(self.rates)

    @property
    def free(self) -> bool:
        """True where the follower never meets the cam."""
        return not self.resting and not self.theta

    @property
    def primitive(self) -> bool:
        """False for an orbit that is another one gone through several times."""
        return shortest_period(self.states) == self.turns


def from_root(system: System, root: Root, verdict: int = Verdict.ADMISSIBLE) -> PeriodicOrbit:
    """The orbit of a solved root, whose turns are rotated so that they give the largest label.

    Of a family it is on the cam of the root's value.
    """
    system = system.at(root.machine)
    states, symbols = section_states(system, root)
    first_turn = _first_turn(symbols, states)
    impacts_before = int(sum(symbols[:first_turn]))
    in_time = [k for _, k in _since_strobe(system, root)]
    order = _rotated(in_time, impacts_before)
    names = system.region_names
    return PeriodicOrbit(
        rpm=root.machine[RPM],
        value=root.value,
        turns=root.turns,
        symbols=_rotated(symbols, first_turn),
        theta=tuple(root.theta[k] for k in order),
        rates=tuple(root.rates[k] for k in order),
        states=_rotated(states, first_turn),
        regions=tuple(names[root.stretch(k)] for k in order),
        trace=root.trace,
        det=root.det,
        verdict=Verdict(verdict),
        root=root,
    )


def resting_orbit(
    system: System,
    rpm: float,
    states: Sequence[tuple[float, float]],
    symbols: Sequence[float],
    leaves: Sequence[tuple[int, float]],
) -> PeriodicOrbit:
    """An orbit through rests, its turns rotated so that they give the largest label.

    states: (q m, dq/dtheta m/rad) at the strobe that begins each turn; symbols: impacts of each,
    inf with a chatter; leaves: (turn, phase rad) of each departure from rest.
    """
    first = _first_turn(symbols, states)
    names = system.region_names
    turns_in_order = _rotated(range(len(states)), first)
    thetas = tuple(theta for j in turns_in_order for turn, theta in leaves if turn == j)
    return PeriodicOrbit(
        rpm=rpm,
        value=rpm,
        turns=len(states),
        symbols=_rotated(symbols, first),
        states=_rotated(states, first),
        theta=thetas,
        regions=tuple(names[stretch_at(system.cam, theta)] for theta in thetas),
        resting=True,
    )


def free_orbit(system: System, rpm: float) -> PeriodicOrbit | None:
    """The orbit without impacts, P(1;0): the follower stays where spring and load balance.

    q = -(m g + preload)/k, above the whole cam; None where the cam reaches it. The flight over one
    turn has the multipliers: trace 1 - W^2 P + B', determinant exp(-4 pi Z) (`kernel.flow`).
    """
    follower = system.follower
    const = system.constants(rpm, 1.0, 1)
    if follower.stiffness == 0.0:
        return None
    q = -(follower.mass * follower.gravity + follower.preload) / follower.stiffness
    highest_start = max(stretch.start_c for stretch in system.cam.stretches)
    if not q > highest_start or q <= _highest(system.cam):
        return None
    _, b1, p = flow(const, TURN)
    return PeriodicOrbit(
        rpm=rpm,
        value=rpm,
        turns=1,
        symbols=(0.0,),
        states=((q, 0.0),),
        trace=1.0 - const.W2 * p + b1,
        det=exp_decay(2.0 * const.Z * TURN),
    )


def _highest(cam: Cam) -> float:
    """The largest c (m) to rounding; `cam.top` is a bound on it."""

    def minus_largest(i: int) -> float:
        """-c where it is largest on stretch i."""
        stretch = cam.stretches[i]
        return lowest(lambda x: -lift(cam, i, x)[0], stretch.start, stretch.end, SAMPLES)[0]

    return -min(map(minus_largest, range(len(cam.stretches))))


def section_states(system: System, root: Root) -> tuple[list[tuple[float, float]], list[float]]:
    """(states, symbols): (q, dq/dtheta) at every strobe, and the impacts in the turn after it.

    A state is that of the flight from the last impact before the strobe.
    """
    const = root.const
    cam = system.at(root.machine).cam
    since = _since_strobe(system, root)
    places = [place for place, _ in since]
    states = []
    symbols = []
    for j in range(root.turns):
        strobe = TURN * j  # rad since the first one
        symbols.append(float(bisect_left(places, TURN * (j + 1)) - bisect_left(places, strobe)))
        before = bisect_right(places, strobe)  # so many impacts
        place, k = since[before - 1]  # of the period before where none is before
        flown = strobe - place if before else strobe - place + TURN * root.turns
        v = root.x[2 * k + 1]
        c, c1, _ = lift(cam, root.stretch(k), root.theta[k])
        states.append(move(const, c, c1 + v, flown))
    return states, symbols


def _since_strobe(system: System, root: Root) -> list[tuple[float, int]]:
    """(rad since the first strobe, impact) of every impact in one period, ascending.

    An impact at the strobe itself belongs to the turn that begins there, so that at the end of the
    period, where rounding or a phase of 360 deg may put it, it is the first one.
    """
    since = []
    strobe = system.strobe
    period = TURN * root.turns
    for k, theta in enumerate(root.theta):
        turn_from_strobe = root.turn(k) + (-1 if theta < strobe else 0)
        periods = turn_from_strobe // root.turns  # that the impact is to be moved back by
        place = TURN * root.turn(k) + (theta - strobe) - period * periods
        since.append((place if place < period else place - period, k))
    return sorted(since)


def _first_turn(symbols: Sequence[float], states: Sequence[tuple[float, float]]) -> int:
    """The turn at which the label begins; among equal ones that of the lowest state."""
    if len(symbols) == 1:
        return 0
    rounded = [tuple(-float(f"{x:.{DIGITS}g}") for x in state) for state in states]
    return rotation(symbols, lambda first: _rotated(rounded, first))


def _rotated(items: Sequence, first: int) -> tuple:
    return (*items[first:], *items[:first])
