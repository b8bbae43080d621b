"""From a simulated motion to the periodic orbit it settles on, solved and certified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf

from camcli.analysis.integrate import Orbit, Record, Settings, Start, with_turns
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.analysis.orbits.error_growth import TOO_LARGE, largest_growth
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root, resting_orbit, section_states
from camcli.analysis.orbits.same_orbit import CLOSE, distance, distance_to, shortest_period, size_of
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.errors import Status
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.system import System

CLOSED = 1e-12  # relative distance of two passages of an orbit that rests on the way
DRIFT = 3.0  # how much farther than the last two passages a solved orbit may lie from the record
MOST_IMPACTS = 2000  # in one period of an orbit to be solved

Impact = tuple[int, float, float]  # period, theta (rad), incoming u (m/rad)


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
    run = with_turns(settings, settings.transient, 2 * longest + 2)
    record = Orbit(system, rpm, run, start).run()
    return identify(system, rpm, record, longest)


def identify(
    system: System, rpm: float, record: Record, longest: int = LONGEST_PERIOD
) -> PeriodicOrbit | None:
    """The attracting orbit at the end of a record with events and strobes, or None."""
    if record.status != Status.OK or record.periods < 2:
        return None
    if not record.touches:
        return _resting(system, rpm, record, 1)
    shooter = Shooter(system, rpm)
    for m, gap in _candidates(record, longest):
        window = range(record.periods - m, record.periods)
        orbit = None
        if not _rests(record, window):
            orbit = _bouncing(shooter, record, m, gap)
        elif gap <= CLOSED and not _accidental(system, rpm, record, m):
            orbit = _resting(system, rpm, record, m)
        if orbit is not None:
            return orbit
    return None


def passages(record: Record) -> tuple[list[tuple[float, float]], list[float]]:
    """States at the strobes (m, m/rad), and the symbol of each whole turn."""
    n = record.periods
    states = [(float(record.strobe_q[k]), float(record.strobe_w[k])) for k in range(n)]
    symbols = [inf if record.chatter[k] else float(record.impacts[k]) for k in range(n)]
    return states, symbols


def impacts_of(record: Record, window: range) -> list[Impact]:
    """The impacts in these turns."""
    return [
        (int(period), float(theta), float(u))
        for kind, period, theta, u in zip(
            record.kind, record.period, record.theta, record.u, strict=True
        )
        if kind == IMPACT and period in window
    ]


def departures(record: Record) -> list[tuple[int, float]]:
    """(period, theta) where the follower leaves from rest: a lift-off, or a blow by an upward kink.

    A blow is an impact of a follower that rested after a chatter.
    """
    leaves, rests = [], False
    for kind, period, theta in zip(record.kind, record.period, record.theta, strict=True):
        if kind == DETACHMENT or (kind == IMPACT and rests):
            leaves.append((int(period), float(theta)))
        rests = kind == CHATTER
    return leaves


def _candidates(record: Record, longest: int) -> Iterator[tuple[int, float]]:
    """(m, relative distance) for every period that the end of the record suggests, ascending."""
    states, symbols = passages(record)
    n, size = len(states), size_of(states)
    for m in range(1, min(longest, n // 2) + 1):
        if symbols[n - m :] == symbols[n - 2 * m : n - m]:
            gap = distance(states[n - 1], states[n - 1 - m], size)
            if gap <= CLOSE:
                yield m, gap


def _rests(record: Record, window: range) -> bool:
    """True where the follower chatters to rest, or leaves from rest, in one of these turns."""
    return any(record.chatter[k] for k in window) or any(
        kind == DETACHMENT and period in window
        for kind, period in zip(record.kind, record.period, strict=True)
    )


def _accidental(system: System, rpm: float, record: Record, turns: int) -> bool:
    """True where rounding, not the machine, closed the cycle that ends a record."""
    window = range(max(0, record.periods - 2 * turns), record.periods)
    return largest_growth(system, rpm, record, window) > TOO_LARGE


def _resting(system: System, rpm: float, record: Record, m: int) -> PeriodicOrbit:
    """An orbit that sticks: the cam alone decides where it leaves, so simulation closes exactly."""
    window = range(record.periods - m, record.periods)
    leaves = [(n - window.start, theta) for n, theta in departures(record) if n in window]
    states, symbols = passages(record)
    return resting_orbit(system, rpm, states[-m:], symbols[-m:], leaves)


def _bouncing(shooter: Shooter, record: Record, m: int, gap: float) -> PeriodicOrbit | None:
    """The orbit of m turns near the end of the record, if it is one and attracts."""
    window = range(record.periods - m, record.periods)
    root = newton_from(shooter, impacts_of(record, window), m)
    root = None if root is None else _gone_once(shooter, root)
    if root is None or not shooter.admits(root):
        return None
    orbit = from_root(shooter.system, root)
    states, symbols = passages(record)
    alike = sorted(orbit.symbols * (m // orbit.turns)) == sorted(symbols[-m:])
    slow = 1.0 / max(1e-6, 1.0 - abs(orbit.multipliers[0]))
    approached = distance_to(states[-1], orbit.states) <= DRIFT * (gap * slow + 1e-9)
    return orbit if orbit.stable and alike and approached else None


def newton_from(shooter: Shooter, events: Sequence[Impact], turns: int) -> Root | None:
    """Newton's method from the impacts of `turns` turns; None where it fails."""
    if not 0 < len(events) <= MOST_IMPACTS:
        return None
    system, value = shooter.system, shooter.value
    first, r = events[0][0], system.follower.restitution
    whole, guess = [], []
    for period, theta, u in events:
        turn = period - first + (1 if theta < system.strobe else 0)
        whole += [stretch_at(system.cam, theta), turn]
        guess += [theta, -r * u]
    root = shooter.at_value([*guess, value], whole, turns, value)
    return None if root is None else settled(shooter, root)


def settled(shooter: Shooter, root: Root, rounds: int = 4) -> Root | None:
    """The root with every impact on the stretch it lies on, solved again where one has moved."""
    for _ in range(rounds):
        moved = _placed(shooter.system, root)
        if moved is None:
            return None
        x, whole = moved
        if whole == root.whole:
            return root if _in_order(root) else None
        again = shooter.at_value(x, whole, root.turns, root.value)
        if again is None:
            return None
        root = again
    return None


def _placed(system: System, root: Root) -> tuple[list[float], tuple[int, ...]] | None:
    """(x, whole) with every phase within the turn and its stretch renewed."""
    x, whole = list(root.x), list(root.whole)
    stretches = system.cam.stretches
    for k in range(root.count):
        i, theta = whole[2 * k], x[2 * k]
        if stretches[i].start <= theta <= stretches[i].end and theta < TURN:
            continue
        turns = 1 if theta < 0.0 else -1 if theta >= TURN else 0
        theta, whole[2 * k + 1] = theta + turns * TURN, whole[2 * k + 1] - turns
        if not 0.0 <= theta < TURN:
            return None
        x[2 * k], whole[2 * k] = theta, stretch_at(system.cam, theta)
    return x, tuple(whole)


def _in_order(root: Root) -> bool:
    """True where the impacts follow each other in time."""
    places = [theta + TURN * root.whole[2 * k + 1] for k, theta in enumerate(root.theta)]
    return all(a < b for a, b in pairwise([*places, places[0] + TURN * root.turns]))


def _gone_once(shooter: Shooter, root: Root) -> Root | None:
    """The orbit itself where the root goes through it several times."""
    turns = shortest_period(section_states(shooter.system, root)[0])
    if turns == root.turns:
        return root
    n = root.count * turns // root.turns
    return shooter.at_value([*root.x[: 2 * n], root.value], root.whole[: 2 * n], turns, root.value)
