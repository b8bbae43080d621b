"""From a simulated motion to the periodic orbit it settles on, solved and certified."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf

from camcli.analysis.integrate import DETACHMENT, IMPACT, Orbit, Settings, Start, Tape, with_turns
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.analysis.orbits.error_growth import forgets
from camcli.analysis.orbits.orbit import (
    PeriodicOrbit,
    from_root,
    region_names,
    rotation,
    section_states,
    shortest_period,
    whole_of,
)
from camcli.analysis.orbits.shooter import VERDICTS, Root, Shooter
from camcli.errors import OK
from camcli.kernel.cam_table import END, ROW, START, TURN, stretch_at
from camcli.kernel.certify import ADMISSIBLE
from camcli.kernel.orbit_loop import CHATTER
from camcli.system import System

NEAR = 1e-2  # relative distance of two passages of the section that suggests a period
CLOSED = 1e-12  # relative distance of two passages of an orbit that rests on the way
DRIFT = 3.0  # how much farther than the last two passages a solved orbit may lie from the record
MOST_IMPACTS = 2000  # in one period of an orbit to be solved


def solve_from(
    system: System,
    rpm: float,
    settings: Settings,
    start: Start | None = None,
    longest: int = LONGEST_PERIOD,
) -> PeriodicOrbit | None:
    """The stable orbit a motion from `start` has come close to after settings.transient turns.

    Its period is the shortest one whose Newton iteration converges to an admissible, attracting
    orbit that the record approaches; None where no period up to `longest` has one.
    """
    record = with_turns(settings, settings.transient, 2 * longest + 2)
    tape = Orbit(system, rpm, record, start).run()
    return identify(system, rpm, tape, longest)


def identify(
    system: System, rpm: float, tape: Tape, longest: int = LONGEST_PERIOD
) -> PeriodicOrbit | None:
    """The attracting orbit at the end of a record with events and strobes, or None."""
    if tape.status != OK or tape.periods < 2:
        return None
    if not tape.touches:
        return _resting(system, rpm, tape, 1)
    shooter = Shooter(system, rpm)
    for m, distance in _candidates(tape, longest):
        window = range(tape.periods - m, tape.periods)
        if any(tape.chatter[k] for k in window) or _rests(tape, window):
            kept = distance <= CLOSED and not forgets(system, rpm, tape, m)
            orbit = _resting(system, rpm, tape, m) if kept else None
        else:
            orbit = _bouncing(system, shooter, tape, m, distance)
        if orbit is not None:
            return orbit
    return None


def passages(tape: Tape) -> tuple[list[tuple[float, float]], list[float]]:
    """States at the strobes (m, m/rad), and the symbol of each whole turn."""
    n = tape.periods
    states = [(float(tape.strobe_q[k]), float(tape.strobe_w[k])) for k in range(n)]
    symbols = [inf if tape.chatter[k] else float(tape.impacts[k]) for k in range(n)]
    return states, symbols


def _candidates(tape: Tape, longest: int):
    """(m, relative distance) for every period that the end of the record suggests, ascending."""
    states, symbols = passages(tape)
    n = len(states)
    size = [max(abs(state[j]) for state in states) or 1.0 for j in range(2)]
    for m in range(1, min(longest, n // 2) + 1):
        if symbols[n - m :] != symbols[n - 2 * m : n - m]:
            continue
        gap = max(abs(states[n - 1][j] - states[n - 1 - m][j]) / size[j] for j in range(2))
        if gap <= NEAR:
            yield m, gap


def _rests(tape: Tape, window: range) -> bool:
    """True where the follower leaves the cam from rest in one of these turns."""
    return any(
        kind == DETACHMENT and period in window
        for kind, period in zip(tape.kind, tape.period, strict=True)
    )


def impacts_of(tape: Tape, window: range):
    """(period, theta, u) of the impacts in these turns."""
    return [
        (int(period), float(theta), float(u))
        for kind, period, theta, u in zip(tape.kind, tape.period, tape.theta, tape.u, strict=True)
        if kind == IMPACT and period in window
    ]


def newton_from(
    system: System, shooter: Shooter, events: Sequence[tuple[int, float, float]], turns: int
) -> Root | None:
    """Newton's method from the impacts (period, theta, u) of `turns` turns; None if it fails."""
    if not 0 < len(events) <= MOST_IMPACTS:
        return None
    first, r = events[0][0], system.follower.restitution
    strobe = system.strobe
    count = [period - first + (1 if theta < strobe else 0) for period, theta, _ in events]
    whole = whole_of(system, [theta for _, theta, _ in events], count)
    value = shooter.machine[shooter.parameter]
    guess = [x for _, theta, u in events for x in (theta, -r * u)] + [value]
    root = shooter.at_value(guess, whole, turns, value)
    return None if root is None else settled(system, shooter, root)


def settled(system: System, shooter: Shooter, root: Root, rounds: int = 4) -> Root | None:
    """The root with every impact on the stretch it lies on, solved again where one has moved."""
    for _ in range(rounds):
        moved = placed(system, root)
        if moved is None:
            return None
        x, whole = moved
        if whole == root.whole:
            return root if in_order(root) else None
        root = shooter.at_value(x, whole, root.turns, root.value)
        if root is None:
            return None
    return None


def placed(system: System, root: Root) -> tuple[list[float], tuple[int, ...]] | None:
    """(x, whole) with every phase within the turn and its stretch renewed."""
    x, whole = list(root.x), list(root.whole)
    rows = system.cam.rows
    for k in range(root.count):
        i, theta = whole[2 * k], x[2 * k]
        if rows[i * ROW + START] <= theta <= rows[i * ROW + END] and theta < TURN:
            continue
        if theta < 0.0:
            theta, whole[2 * k + 1] = theta + TURN, whole[2 * k + 1] - 1
        elif theta >= TURN:
            theta, whole[2 * k + 1] = theta - TURN, whole[2 * k + 1] + 1
        if not 0.0 <= theta < TURN:
            return None
        x[2 * k], whole[2 * k] = theta, stretch_at(system.cam, theta)
    return x, tuple(whole)


def in_order(root: Root) -> bool:
    """True where the impacts follow each other in time."""
    places = [theta + TURN * root.whole[2 * k + 1] for k, theta in enumerate(root.theta)]
    places.append(places[0] + TURN * root.turns)
    return all(before < after for before, after in pairwise(places))


def _bouncing(system, shooter, tape, m, distance) -> PeriodicOrbit | None:
    """The orbit of m turns near the end of the record, if it is one and attracts."""
    window = range(tape.periods - m, tape.periods)
    root = newton_from(system, shooter, impacts_of(tape, window), m)
    root = None if root is None else once(system, shooter, root)
    if root is None:
        return None
    code, _, _ = shooter.verdict(root)
    orbit = from_root(system, root, code)
    if code != ADMISSIBLE or not orbit.stable:
        return None
    states, symbols = passages(tape)
    if sorted(orbit.symbols * (m // orbit.turns)) != sorted(symbols[-m:]):
        return None
    off = min(_far(states[-1], state, orbit.states) for state in orbit.states)
    slow = 1.0 / max(1e-6, 1.0 - abs(orbit.multipliers[0]))
    return orbit if off <= DRIFT * (distance * slow + 1e-9) else None


def once(system: System, shooter: Shooter, root: Root) -> Root | None:
    """The orbit itself where the root goes through it several times."""
    turns = shortest_period(section_states(system, root)[0])
    if turns == root.turns:
        return root
    n = root.count * turns // root.turns
    x = [*root.x[: 2 * n], root.value]
    return shooter.at_value(x, root.whole[: 2 * n], turns, root.value)


def _far(state, other, states) -> float:
    size = [max(abs(s[j]) for s in states) or 1.0 for j in range(2)]
    return max(abs(state[j] - other[j]) / size[j] for j in range(2))


def departures(tape: Tape) -> list[tuple[int, float]]:
    """(period, theta) where the follower leaves from rest: a lift-off, or a blow by an upward kink.

    A blow is an impact of a follower that rested after a chatter.
    """
    leaves, rests = [], False
    for kind, period, theta in zip(tape.kind, tape.period, tape.theta, strict=True):
        if kind == DETACHMENT or (kind == IMPACT and rests):
            leaves.append((int(period), float(theta)))
        rests = kind == CHATTER
    return leaves


def _resting(system: System, rpm: float, tape: Tape, m: int) -> PeriodicOrbit:
    """An orbit that sticks: the cam alone decides where it leaves, so simulation closes exactly."""
    window = range(tape.periods - m, tape.periods)
    leaves = [(n - window.start, theta) for n, theta in departures(tape) if n in window]
    states, symbols = passages(tape)
    return resting_orbit(system, rpm, states[-m:], symbols[-m:], leaves)


def resting_orbit(system: System, rpm: float, states, symbols, leaves) -> PeriodicOrbit:
    """An orbit through rests: states at the strobes, symbols of the turns, leaves (turn, rad)."""
    m, first = len(states), rotation(symbols, states)
    rotated = [(first + j) % m for j in range(m)]
    thetas = [theta for j in rotated for turn, theta in leaves if turn == j]
    names = region_names(system)
    return PeriodicOrbit(
        rpm=rpm, value=rpm, turns=m,
        symbols=tuple(symbols[j] for j in rotated),
        theta=tuple(thetas),
        rates=(),
        states=tuple(states[j] for j in rotated),
        regions=tuple(names[stretch_at(system.cam, theta)] for theta in thetas),
        trace=0.0, det=0.0, verdict=VERDICTS[ADMISSIBLE], resting=True,
    )  # fmt: skip
