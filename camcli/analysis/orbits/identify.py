"""From a simulated motion to the periodic orbit it settles on, solved and certified."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camcli.analysis.differences import Matrix, flown, since_first_strobe, struck
from camcli.analysis.exponents import Exponents, of_orbit, of_record
from camcli.analysis.integrate import Record
from camcli.analysis.labels import (
    APERIODIC,
    LONGEST_PERIOD,
    UNDECIDED,
    Label,
    label,
    returns,
    sections,
)
from camcli.analysis.multipliers import attracts
from camcli.analysis.orbits.orbit import (
    PeriodicOrbit,
    free_orbit,
    from_root,
    resting_orbit,
    section_states,
)
from camcli.analysis.orbits.same_orbit import (
    distance_to,
    shortest_period,
)
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.errors import Status
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.kernel.flow import RPM
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.system import System

CLOSED = 1e-12  # relative distance of two passages of an orbit that rests on the way
DRIFT = 3.0  # how much farther than the last two passages a solved orbit may lie from the record
MOST_SOLVED = 2000  # in one period of an orbit to be solved
CLEARLY = 1.01  # times the largest trace of an orbit that attracts: not a matter of rounding
TOO_LARGE = 7e10  # growth of a phase error that leaves five digits of a turn


class RecordedImpact(NamedTuple):
    """An impact of a record: the turn of the record, phase (rad), incoming rate u (m/rad)."""

    period: int
    theta: float
    u: float


class RecordedEvent(NamedTuple):
    """An event of a record: its kind (`kernel.orbit_loop`), and the rest as of an impact."""

    kind: int
    period: int
    theta: float
    u: float


def named(
    system: System, rpm: float, record: Record, measured: bool = False
) -> tuple[str, Exponents | None]:
    """The label of what a record ends on, and its exponents where `measured`.

    A slow spiral towards an orbit comes near itself after many turns before it does after few, and
    in a short record not at all: where `label` finds no period, or that of fewer turns repeated,
    the orbit is solved. None is looked for where the record's exponent says chaos.
    """
    name = label(record)
    ok = record.status == Status.OK
    exponents = None
    doubtful = isinstance(name, Label) and name.repeats
    if name in (APERIODIC, UNDECIDED) and ok and record.near:
        doubtful = True
        exponents = of_record(system, rpm, record)
    chaotic = exponents is not None and exponents.chaotic
    if (measured or doubtful) and not chaotic:
        orbit = identify(system, rpm, record)
        if orbit is not None:
            return (orbit.label if doubtful else name), of_orbit(system, orbit)
    if measured and ok and exponents is None:
        exponents = of_record(system, rpm, record)
    return name, exponents


def identify(
    system: System, rpm: float, record: Record, longest: int = LONGEST_PERIOD
) -> PeriodicOrbit | None:
    """The attracting orbit at the end of a record with events and strobes, or None.

    Its period is the shortest one whose Newton iteration converges to an admissible, attracting
    orbit that the record approaches. A motion through a rest closes by itself: the cam alone
    decides where it leaves.
    """
    n = record.periods
    if record.status != Status.OK or n < 2:
        return None
    states, symbols = sections(record)

    def last_states(turns: int) -> list[tuple[float, float]]:
        return [(q, w) for q, w in states[-turns:].tolist()]

    if record.rests_throughout:
        return resting_orbit(system, rpm, last_states(1), symbols[-1:], [])
    shooter = None
    for turns, gap in returns(states, longest):
        last_symbols = symbols[n - turns :]
        if last_symbols != symbols[n - 2 * turns : n - turns]:
            continue
        orbit = None
        window = range(n - turns, n)
        events = list(_events(record, window))
        lifts_off = any(event.kind == DETACHMENT for event in events)
        if not lifts_off and not record.chatter[window.start : window.stop].any():
            shooter = shooter or Shooter(system, rpm)
            (end,) = last_states(1)
            impacts = _impacts_among(events)
            orbit = _bouncing(shooter, impacts, turns, gap, end, last_symbols)
        elif gap <= CLOSED:
            grown = largest_growth(system, rpm, record, range(max(0, n - 2 * turns), n))
            if grown <= TOO_LARGE:  # else rounding, not the machine, closed the cycle
                leaves = [
                    (period - window.start, theta)
                    for period, theta in departures(record)
                    if period in window
                ]
                orbit = resting_orbit(system, rpm, last_states(turns), last_symbols, leaves)
        if orbit is not None:
            return orbit
    return None


def _events(record: Record, window: range) -> Iterator[RecordedEvent]:
    """The events in these turns of a record."""
    rows = slice(*np.searchsorted(record.period, (window.start, window.stop)))
    columns = (record.kind, record.period, record.theta, record.u)
    return map(RecordedEvent, *(column[rows].tolist() for column in columns))


def impacts_of(record: Record, window: range) -> list[RecordedImpact]:
    """The impacts in these turns of a record."""
    return _impacts_among(_events(record, window))


def _impacts_among(events: Iterable[RecordedEvent]) -> list[RecordedImpact]:
    """The impacts among events."""
    return [
        RecordedImpact(event.period, event.theta, event.u)
        for event in events
        if event.kind == IMPACT
    ]


def departures(record: Record) -> list[tuple[int, float]]:
    """(period, theta) where the follower leaves from rest: a lift-off, or a blow by an upward kink.

    A blow is an impact of a follower that rested after a chatter.
    """
    rested = record.kind[:-1] == CHATTER
    after_rest = np.concatenate(([False], rested))[: len(record.kind)]
    leaves = (record.kind == DETACHMENT) | ((record.kind == IMPACT) & after_rest)
    return list(zip(record.period[leaves].tolist(), record.theta[leaves].tolist(), strict=True))


def largest_growth(system: System, rpm: float, record: Record, window: range) -> float:
    """Largest factor between a phase error after a rest and one before the next, in these turns.

    The first one above TOO_LARGE is returned at once.

    An orbit that rests on the cam leaves it at a phase known to rounding. If an error of that phase
    grows by more than doubles have digits, the next impacts are an accident of rounding, and that
    such a run closes on itself says nothing about the machine. An error dtheta at the first impact,
    a hop of s rad and incoming rate u after lift-off, is a difference (u, u/s) dtheta of position
    and velocity; flights and impacts carry it on (saltation matrices: Leine & Nijmeijer, Dynamics
    and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7), and at an impact it is a phase
    error again, |dq/u|.
    """
    const = system.constants(rpm, 1.0, 1)
    largest = 0.0
    last: float | None = None  # angle of the last event of a motion from rest
    # (dq, 0, dw, 0): the first column of a matrix (`differences`); none before the first impact
    difference: Matrix | None = None
    for event in _events(record, window):
        angle = since_first_strobe(system, event.period, event.theta)
        if event.kind != IMPACT or last is None:
            last = angle if event.kind == DETACHMENT else None
            difference = None
            continue
        hop = angle - last
        if difference is not None:
            difference = flown(const, hop, difference)
        else:
            difference = (-event.u, 0.0, -event.u / hop if hop > 0.0 else 0.0, 0.0)
        dq = difference[0]
        largest = max(largest, abs(dq / event.u))
        if largest > TOO_LARGE:
            break
        difference = struck(system, const, event.theta, event.u, difference)
        last = angle
    return largest


def _bouncing(
    shooter: Shooter,
    impacts: Sequence[RecordedImpact],
    turns: int,
    gap: float,
    last_state: tuple[float, float],
    symbols: Sequence[float],
) -> PeriodicOrbit | None:
    """The orbit of so many turns near the end of a record, or None.

    None also where the orbit does not attract, has other counts of impacts than the record, or is
    not what the record comes nearer to. last_state: of the record; symbols: its counts in the last
    turns; gap: between that state and the one `turns` before. A motion whose multiplier is near 1
    may be many such gaps away from its orbit.
    """
    if not impacts:
        orbit = free_orbit(shooter.system, shooter.machine[RPM])
    else:
        orbit = _solved(shooter, impacts, turns)
    if orbit is None:
        return None
    alike = sorted(orbit.symbols * (turns // orbit.turns)) == sorted(symbols)
    slow = 1.0 / max(1e-6, 1.0 - abs(orbit.multipliers[0]))
    approached = distance_to(last_state, orbit.states) <= DRIFT * (gap * slow + 1e-9)
    return orbit if orbit.stable and alike and approached else None


def _solved(
    shooter: Shooter, impacts: Sequence[RecordedImpact], turns: int
) -> PeriodicOrbit | None:
    """The admissible and attracting orbit near the impacts of so many turns.

    Near a record of chaos there are many that do not attract: they are not made.
    """
    root = newton_from(shooter, impacts, turns)
    if root is None or abs(root.trace) > CLEARLY * (1.0 + root.det):
        return None
    period = 1 if turns == 1 else shortest_period(section_states(shooter.system, root)[0])
    if period < turns:  # the orbit itself, which the root goes through several times
        n = root.count * period // turns
        root = shooter.at_value(
            [*root.x[: 2 * n], root.value], root.whole[: 2 * n], period, root.value
        )
    if root is None or not attracts(root.trace, root.det) or not shooter.admits(root):
        return None
    return from_root(shooter.system, root)


def newton_from(shooter: Shooter, impacts: Sequence[RecordedImpact], turns: int) -> Root | None:
    """Newton's method from the impacts of `turns` turns; None where it fails."""
    if not 0 < len(impacts) <= MOST_SOLVED:
        return None
    system = shooter.system
    whole = []
    guess = []
    for impact in impacts:
        turn = impact.period - impacts[0].period
        if impact.theta < system.strobe:  # a period begins at the strobe, a turn at the angle zero
            turn += 1
        stretch = stretch_at(system.cam, impact.theta)
        whole += [stretch, turn]
        guess += [impact.theta, -system.restitution(stretch) * impact.u]
    root = shooter.at_value([*guess, shooter.value], whole, turns, shooter.value)
    return settled(shooter, root)


def settled(shooter: Shooter, root: Root | None, rounds: int = 4) -> Root | None:
    """The root with every impact on the stretch it lies on, solved again where one has moved."""
    for _ in range(rounds):
        moved = None if root is None else _placed(shooter.system, root)
        if root is None or moved is None:
            return None
        x, whole = moved
        if whole == root.whole:
            return root if _in_order(root) else None
        root = shooter.at_value(x, whole, root.turns, root.value)
    return None


def _placed(system: System, root: Root) -> tuple[list[float], tuple[int, ...]] | None:
    """(x, whole) of the same impacts, each with its phase within the turn and on its stretch.

    None where a phase is more than a turn outside. Both are laid out as in `Root`.
    """
    x = list(root.x)
    whole: list[int] = []
    cam = system.at(root.machine).cam
    for k, theta in enumerate(root.theta):
        stretch = root.stretch(k)
        turn = root.turn(k)
        on_stretch = cam.stretches[stretch].start <= theta <= cam.stretches[stretch].end
        if not (on_stretch and theta < TURN):
            turns_on = 0  # that the phase is to be moved by
            if theta < 0.0:
                turns_on = 1
            elif theta >= TURN:
                turns_on = -1
            in_turn = theta + turns_on * TURN
            turn -= turns_on
            if not 0.0 <= in_turn < TURN:
                return None
            x[2 * k] = in_turn
            stretch = stretch_at(cam, in_turn)
        whole += [stretch, turn]
    return x, tuple(whole)


def _in_order(root: Root) -> bool:
    """True where the impacts follow each other in time."""
    places = [theta + TURN * root.turn(k) for k, theta in enumerate(root.theta)]
    return all(a < b for a, b in pairwise([*places, places[0] + TURN * root.turns]))
