"""What the motion after a rest leads to, where doubles cannot tell.

A rest: the follower stays on the cam for a while (sticking), after a complete chatter or an impact
from which it does not bounce. A departure is the end of a rest: the follower leaves the cam by
itself (detachment), or is struck where the cam's slope jumps.

A rest erases all memory, so the motion after it is one motion of the machine. Two questions are
asked about it, in ball arithmetic (`camcli.exact`). What do these data do, exactly? The motion is
followed until it repeats (SETTLED), has run TURNS_FOLLOWED turns without (WANDERS), or comes back
to a departure it has had (CYCLE). And what does every machine do whose speed reads the same? All
are followed at once: where errors grow little they end as the exact data do, certainly. Where they
grow much, the answer is about these very data and hangs on digits that no measured speed has.
`HoldsFor` says which of these was answered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import lru_cache
from typing import TYPE_CHECKING

from camcli.analysis.integrate import Record, Start
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.analysis.orbits.identify import departures
from camcli.analysis.orbits.same_orbit import distance, size_of
from camcli.cams.balls import UndecidedError, decided
from camcli.cams.compile import Shape
from camcli.kernel import backend
from camcli.parallel.helpers import Turns
from camcli.system import Follower, System

if TYPE_CHECKING:
    from camcli.exact.motion import BallMotion

SETTLED, WANDERS, CYCLE, UNKNOWN = "settled", "wanders", "cycle", "unknown"
DIGITS = (210, 420, 840, 1680)  # tried one after the other; 210 last for most chaos of 400 turns
LAST_DIGIT_DIGITS = (60,)  # for balls of 1e-16
TURNS_FOLLOWED = 400  # turns followed
MOST_IMPACTS = 4_000
SAME = 1e-5  # of the states: motions that settled on one orbit are nearer than this
CLOSE = 1e-8  # relative distance of a state to the one a period before
KNOWN = 2.0**-80  # relative width of a state that rounds to the same doubles however it was found
SHRINKS = 0.95  # what a period leaves of that distance
NOTHING_LEFT = 1e-13  # a distance that need not shrink
# Bits lost beyond which all speeds that read alike are not followed at once. Some 27 make what
# 2.0**-53 of a speed changes wider than CLOSE, but `lost` is the most that may be lost anywhere on
# the way (58 at 203 rpm, in a chatter, where all come to one end): up to 100 it is tried, and costs
# no more than another motion.
HOPELESS = 100
REMEMBERED = 4096  # motions
TURNS = Turns()  # of threads at balls


class HoldsFor(StrEnum):
    """Which machines an answer about the motion after a rest is about."""

    LAST_DIGIT = "last-digit"  # every machine whose speed rounds to this one: proved for all
    EXACT_DATA = "exact-data"  # the machine of these doubles, exactly; others may differ
    ROUNDING = "rounding"  # none for certain: an attractor of the machine, that doubles ended on


State = tuple[float, float]  # q (m), dq/dtheta (m/rad) at a strobe


@dataclass(frozen=True)
class After:
    """Where the motion after a rest ends.

    states: of the strobes of one period, the last one `turns` turns after the departure; symbols:
    of the turns that end there; leaves: (turn, rad) of the departures of a cycle; holds_for: None
    where nothing is decided; lost: bits that errors have grown by.
    """

    kind: str
    turns: int = 0
    states: tuple[State, ...] = ()
    symbols: tuple[float, ...] = ()
    leaves: tuple[tuple[int, float], ...] = ()
    holds_for: HoldsFor | None = None
    lost: int = field(default=0, compare=False)

    def start(self, system: System, rpm: float) -> Start | None:
        """The last state, to go on from in doubles; None where nothing is known."""
        if self.kind not in (SETTLED, WANDERS):
            return None
        return Start.at_strobe(system, rpm, self.states[-1])


def after_first_rest(system: System, rpm: float, record: Record) -> After:
    """`after_rest` from the first departure in a record, UNKNOWN where there is none."""
    leaves = departures(record)
    return after_rest(system, rpm, leaves[0][1]) if leaves else After(UNKNOWN)


def after_rest(system: System, rpm: float, theta: float) -> After:
    """Where the motion ends that leaves the cam from rest near the phase theta (rad).

    Followed first for these very data, and then for every machine whose speed reads the same.
    """
    end = of_machine(system, rpm, theta)
    if end.kind not in (SETTLED, CYCLE):
        return end
    if end.lost > HOPELESS:
        return replace(end, holds_for=HoldsFor.EXACT_DATA)
    end_of_all = of_machine(system, rpm, theta, all_that_read_alike=True)
    alike = (
        end_of_all.kind == end.kind and end_of_all.symbols == end.symbols and _same(end_of_all, end)
    )
    return replace(end, holds_for=HoldsFor.LAST_DIGIT if alike else HoldsFor.EXACT_DATA)


def _same(a: After, b: After) -> bool:
    """True where two motions have settled on one orbit, or both on the cycle."""
    if CYCLE in (a.kind, b.kind):
        return a.kind == b.kind
    size = size_of(a.states)
    return len(a.states) == len(b.states) and any(
        distance(a.states[-1], state, size) <= SAME for state in b.states
    )


def of_machine(
    system: System, rpm: float, theta: float, all_that_read_alike: bool = False
) -> After:
    """The motion after a departure at theta (rad), followed in ball arithmetic.

    The machine has exactly the numbers of `system` and the speed `rpm`, as the doubles they are.
    all_that_read_alike: follow every machine at once whose speed rounds to the double `rpm`.
    """
    return of_shape(system.shape, system.follower, system.strobe, rpm, theta, all_that_read_alike)


@lru_cache(maxsize=REMEMBERED)
def of_shape(
    shape: Shape,
    follower: Follower,
    strobe: float,
    rpm: float,
    theta: float,
    all_that_read_alike: bool = False,
) -> After:
    """`of_machine` by the parts of the machine, remembered.

    Other starts at a speed, and a sweep the other way, come to the same rest: it is followed once.
    """
    compiled = backend.current().compiled
    return TURNS.call(followed, shape, follower, strobe, rpm, theta, all_that_read_alike, compiled)


def followed(
    shape: Shape,
    follower: Follower,
    strobe: float,
    rpm: float,
    theta: float,
    all_that_read_alike: bool,
    compiled: bool,
    digits: Sequence[int] = DIGITS,
) -> After:
    """`of_shape`, computed by this process, with the compiled kernel or plain Python.

    digits: tried one after the other, for the machine of these very data.
    """
    from camcli.exact.machine import BallMachine
    from camcli.exact.motion import EndlessError
    from camcli.exact.quick_motion import LandingTable, QuickMotion

    if compiled:
        backend.compiled()
    table = LandingTable(shape, follower, strobe, rpm)
    widest = KNOWN
    if all_that_read_alike:
        digits = LAST_DIGIT_DIGITS
        widest = CLOSE

    def after() -> After:
        make = BallMachine.within_last_digit if all_that_read_alike else BallMachine
        motion = QuickMotion(make(shape, follower, rpm), strobe, theta, table)
        return replace(_until_it_repeats(motion, widest), lost=motion.lost)

    try:
        return decided(after, digits)
    except (UndecidedError, EndlessError):
        return After(UNKNOWN)


def _until_it_repeats(motion: BallMotion, widest: float, most_impacts: int = MOST_IMPACTS) -> After:
    """Follow a motion until its states repeat, or for TURNS_FOLLOWED turns or so many impacts.

    Raises UndecidedError where a state is wider than `widest`, relative to its larger number.
    """
    trail = motion.trail  # it grows as the motion is followed
    states: list[State] = []  # of trail.states those that were looked at, as doubles
    largest = (0.0, 0.0)  # |q| and |w| of these
    while len(states) < TURNS_FOLLOWED and len(trail.impacts) < most_impacts:
        for q, w in trail.states[len(states) :]:
            if max(q.rad(), w.rad()) > widest * max(abs(q), abs(w)):
                raise UndecidedError
            state = float(q), float(w)
            states.append(state)
            largest = max(largest[0], abs(state[0])), max(largest[1], abs(state[1]))
            if m := repeats(states, trail.symbols[: len(states)], largest):
                symbols = tuple(trail.symbols[len(states) - m : len(states)])
                return After(SETTLED, len(states), tuple(states[-m:]), symbols)
        before = len(trail.leaves)
        motion.step()
        if len(trail.leaves) > before and (closed := cycle(motion)):
            return closed
    if not states:  # too many impacts before the first strobe
        return After(UNKNOWN)
    kind = WANDERS if len(states) >= TURNS_FOLLOWED else UNKNOWN
    return After(kind, len(states), (states[-1],), (trail.symbols[len(states) - 1],))


def cycle(motion: BallMotion) -> After | None:
    """The cycle that a motion closes with its last departure from rest, or None.

    It closes one where an earlier departure was at the same phase of the cam: what followed that
    one will follow the last one too. The cycle's states, symbols and departures are those of the
    `period` turns between the two.
    """
    trail = motion.trail
    last = trail.leaves[-1]
    turns_ago = [(last - leave) / motion.turn for leave in trail.leaves[:-1]]
    since = next((k for k, turns in enumerate(turns_ago) if turns.contains_integer()), None)
    if since is None:
        return None
    period = round(float(turns_ago[since]))
    begin = len(trail.states) - period
    states = tuple((float(q), float(w)) for q, w in trail.states[begin:])
    first = begin + 1  # the turn that the last departure is in is not over, and has no symbol yet
    leaves = tuple(
        (motion.turn_of(phi) - first, motion.phase(phi)) for phi in trail.leaves[since + 1 :]
    )
    symbols = (*trail.symbols[first:], motion.symbol_of_turn(trail.leaves[since]))
    return After(CYCLE, period, states, symbols, leaves)


def repeats(states: Sequence[State], symbols: Sequence[float], largest: State) -> int:
    """Turns m <= LONGEST_PERIOD after which the end of a record repeats, or 0.

    The last three periods have the same symbols, and each is nearer to the one before than that one
    was, at last within CLOSE of the largest numbers of all states.
    """
    n = len(states)
    size = size_of([largest])

    def apart(k: int, m: int) -> float:
        return distance(states[k], states[k - m], size)

    q = states[-1][0]
    near = CLOSE * size[0]
    longest = min(LONGEST_PERIOD, (n - 1) // 3)
    before = states[n - 1 - longest : n - 1]
    periods = [m for m, state in enumerate(reversed(before), 1) if abs(q - state[0]) <= near]
    for m in periods:
        last = apart(n - 1, m)
        if last > CLOSE or list(symbols[n - 2 * m :]) != list(symbols[n - 3 * m : n - m]):
            continue
        first, second = apart(n - 1 - 2 * m, m), apart(n - 1 - m, m)
        if last <= NOTHING_LEFT or (second <= SHRINKS * first and last <= SHRINKS * second):
            return m
    return 0
