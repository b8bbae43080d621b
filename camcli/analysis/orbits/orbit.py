"""A periodic orbit as the user sees it: label, phases, section states, multipliers, verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from camcli.analysis.labels import name
from camcli.analysis.orbits.shooter import VERDICTS, Root, multipliers
from camcli.cams.regions import regions
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.certify import ADMISSIBLE
from camcli.kernel.flow import RPM, lane_of, move
from camcli.system import System

REPEATS = 1e-7  # relative distance of section states that counts as none
DIGITS = 12  # significant digits that decide between rotations of one label


@dataclass(frozen=True)
class PeriodicOrbit:
    """An orbit of `turns` turns, its turns in the rotation that names it.

    value: of the parameter; theta: impact phases (rad in the turn), of a resting orbit the phases
    at which it leaves the cam; rates: incoming m/rad; states: (q m, dq/dtheta m/rad) at the strobe
    that begins each turn; symbols: impacts in each turn, inf for a complete chatter; verdict:
    `admissible` or why it is no motion. A resting orbit sticks somewhere: its multipliers are zero.
    """

    rpm: float
    value: float
    turns: int
    symbols: tuple[float, ...]
    theta: tuple[float, ...]
    rates: tuple[float, ...]
    states: tuple[tuple[float, float], ...]
    regions: tuple[str, ...]
    trace: float
    det: float
    verdict: str
    resting: bool = False
    root: Root | None = None

    @cached_property
    def label(self) -> str:
        """P(m;s1:...:sm), or `contact` where the follower never leaves the cam."""
        still = self.resting and not self.theta and not any(self.symbols)
        return "contact" if still else name(self.symbols)

    @cached_property
    def multipliers(self) -> tuple[complex, complex]:
        """Of the stroboscopic map over one period of the orbit."""
        return multipliers(self.trace, self.det)

    @property
    def admissible(self) -> bool:
        """True for a motion, False for a mere root of the equations."""
        return self.verdict == VERDICTS[ADMISSIBLE]

    @property
    def stable(self) -> bool:
        """True where both multipliers lie inside the unit circle (Jury's conditions)."""
        return self.det < 1.0 and abs(self.trace) < 1.0 + self.det

    @property
    def impacts(self) -> int:
        """Impacts in one period that are solved for."""
        return len(self.rates)


def from_root(system: System, root: Root, verdict: int = ADMISSIBLE) -> PeriodicOrbit:
    """The orbit of a solved root."""
    states, symbols = section_states(system, root)
    order = _impact_order(system, root)
    first = rotation(symbols, states)
    turns = root.turns
    behind = sum(int(count) for count in symbols[:first])
    order = order[behind:] + order[:behind]
    names = region_names(system)
    rotated = [(first + j) % turns for j in range(turns)]
    return PeriodicOrbit(
        rpm=root.machine[RPM],
        value=root.value,
        turns=turns,
        symbols=tuple(symbols[j] for j in rotated),
        theta=tuple(root.theta[k] for k in order),
        rates=tuple(root.rates[k] for k in order),
        states=tuple(states[j] for j in rotated),
        regions=tuple(names[root.whole[2 * k]] for k in order),
        trace=root.trace,
        det=root.det,
        verdict=VERDICTS[verdict],
        root=root,
    )


def region_names(system: System) -> dict[int, str]:
    """Name of the smooth region of every stretch."""
    return {i: region.name for region in regions(system.cam) for i in region.stretches}


def _strobes_from(system: System, root: Root) -> list[tuple[float, int]]:
    """(rad since the first strobe, impact) of every impact in one period, ascending."""
    strobe, period = system.strobe, TURN * root.turns
    since = []
    for k, theta in enumerate(root.theta):
        place = TURN * root.whole[2 * k + 1] + (theta - strobe)
        turns = root.whole[2 * k + 1] + (-1 if theta < strobe else 0)
        since.append((place - period * (turns // root.turns), k))
    return sorted(since)


def _impact_order(system: System, root: Root) -> list[int]:
    return [k for _, k in _strobes_from(system, root)]


def section_states(system: System, root: Root):
    """(states, symbols): (q, dq/dtheta) at every strobe, and the impacts in the turn after it."""
    lane = lane_of(root.machine, 0.0, 0)
    since = _strobes_from(system, root)
    states, symbols = [], []
    for j in range(root.turns):
        at = TURN * j
        symbols.append(float(sum(1 for place, _ in since if at <= place < at + TURN)))
        before = [pair for pair in since if pair[0] <= at]
        place, k = before[-1] if before else since[-1]
        ago = at - place if before else at - place + TURN * root.turns
        c, c1, _ = lift(system.cam, root.whole[2 * k], root.theta[k])
        states.append(move(lane, c, c1 + root.x[2 * k + 1], ago))
    return states, symbols


def rotation(symbols: Sequence[float], states: Sequence[tuple[float, float]]) -> int:
    """First turn of the largest rotation of the symbols; ties go to the lowest state."""
    turns = len(symbols)

    def key(first: int):
        word = tuple(symbols[(first + j) % turns] for j in range(turns))
        low = tuple(
            -float(f"{x:.{DIGITS}g}") for j in range(turns) for x in states[(first + j) % turns]
        )
        return word, low

    return max(range(turns), key=key)


def whole_of(system: System, thetas: Sequence[float], turns: Sequence[int]) -> tuple[int, ...]:
    """Stretch and turn of every impact, flat."""
    pairs = [
        (stretch_at(system.cam, theta), turn) for theta, turn in zip(thetas, turns, strict=True)
    ]
    return tuple(value for pair in pairs for value in pair)


def primitive(orbit: PeriodicOrbit) -> bool:
    """False for an orbit that is another one gone through several times."""
    return shortest_period(orbit.states) == orbit.turns


def shortest_period(states: Sequence[tuple[float, float]]) -> int:
    """The least number of turns after which the section states repeat."""
    turns, size = len(states), [max(abs(s[j]) for s in states) or 1.0 for j in range(2)]
    for m in range(1, turns // 2 + 1):
        if turns % m == 0 and all(
            abs(states[k][j] - states[k - m][j]) <= REPEATS * size[j]
            for k in range(turns)
            for j in range(2)
        ):
            return m
    return turns
