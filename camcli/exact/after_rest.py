"""What the motion after a rest leads to, where doubles cannot tell.

A rest erases all memory, so the motion after it is one motion of the machine. It is followed with
many digits until it repeats (SETTLED), has run LONGEST turns without either (WANDERS), or comes to
a rest from which it has left before. Such a cycle is the machine's where it forgets little (CYCLE).
One that forgets more than doubles hold may hang on digits that no scene has, so neighbours of the
speed are followed too, SHARES off, within half its last digit: the first ENOUGH that go through the
same cycle, or else settle, must all do the same, and the motion ends as they do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import Decimal, localcontext

from camcli.analysis.integrate import Settings, Start, Tape
from camcli.analysis.orbits.error_growth import TOO_LARGE
from camcli.analysis.orbits.identify import departures
from camcli.exact.drive import DIGITS
from camcli.exact.error import NOISE
from camcli.exact.motion import TrueMotion
from camcli.exact.settled import repeats
from camcli.kernel.cam_table import stretch_at
from camcli.system import System, omega_of

SETTLED, WANDERS, CYCLE, UNKNOWN = "settled", "wanders", "cycle", "unknown"
LONGEST = 400  # turns followed
MOST_IMPACTS = 4_000
SAME_PLACE = 1e-9  # rad: departures nearer than this are one
SAME = 1e-5  # of the states: motions of neighbours that settled are nearer than this
SHARES = tuple(Decimal(k * sign).scaleb(-17) for k in (1, 2, 3, 4) for sign in (1, -1))
ENOUGH = 3  # neighbours that settle


@dataclass(frozen=True)
class After:
    """Where the motion after a rest ends.

    states (q m, dq/dtheta m/rad) at the strobes of one period, the last one being `turns` turns
    after the departure; symbols: of the turns that end there; leaves: (turn, rad) of the departures
    of a cycle; growth: largest, of an error after a rest; reason: why nothing more is known.
    """

    kind: str
    turns: int
    states: tuple[tuple[float, float], ...] = ()
    symbols: tuple[float, ...] = ()
    leaves: tuple[tuple[int, float], ...] = ()
    growth: float = 0.0
    reason: str = ""

    def start(self, system: System, rpm: float) -> Start | None:
        """The last state, to go on from in doubles; None where nothing is known."""
        if self.kind not in (SETTLED, WANDERS):
            return None
        q, w = self.states[-1]
        return Start(q, w * omega_of(rpm), system.strobe_deg)


def after_rest(system: System, rpm: float, settings: Settings, tape: Tape) -> Start | None:
    """A state on the true motion after the first rest in a record, where doubles may take over.

    That is after its chaotic transient, at the strobe. None where there is no rest in the record,
    the motion comes back to it, or nothing certain can be said.
    """
    return ends(system, rpm, settings, tape).start(system, rpm)


def ends(system: System, rpm: float, settings: Settings, tape: Tape) -> After:
    """`follow` from the first departure in a record."""
    leaves = departures(tape)
    if not leaves:
        return After(UNKNOWN, 0, reason="no departure from a rest in the record")
    return follow(system, rpm, settings, leaves[0][1])


def follow(system: System, rpm: float, settings: Settings, theta: float) -> After:
    """The motion that leaves the cam from rest at the phase theta (rad)."""
    if system.parts is None:
        return After(UNKNOWN, 0, reason="the cam is known in doubles only")
    with localcontext() as context:
        context.prec = DIGITS
        found = _one(system, rpm, settings, theta)
        if found.kind != CYCLE or found.growth <= TOO_LARGE:
            return found
        return _of_neighbours(system, rpm, settings, theta, found)


def _of_neighbours(system, rpm, settings, theta, cycle: After) -> After:
    """What ENOUGH machines agree on whose speed differs by less than its rounding."""
    agreed: list[After] = []
    for share in SHARES:
        found = _one(system, rpm, settings, theta, share)
        if found.kind == SETTLED or (found.kind == CYCLE and found.symbols == cycle.symbols):
            agreed.append(found)
            if not _same(agreed[0], found):
                break
            if len(agreed) == ENOUGH:
                return cycle if found.kind == CYCLE else agreed[0]
    reason = f"a cycle of {cycle.turns} turns through a rest hangs on digits the data do not have"
    return After(UNKNOWN, cycle.turns, growth=cycle.growth, reason=reason)


def _same(a: After, b: After) -> bool:
    """True where two motions have settled on one orbit, or both on the cycle."""
    if CYCLE in (a.kind, b.kind):
        return a.kind == b.kind
    size = [max(abs(state[j]) for state in a.states) or 1.0 for j in range(2)]

    def near(p, q) -> bool:
        return all(abs(p[j] - q[j]) <= SAME * size[j] for j in range(2))

    return len(a.states) == len(b.states) and any(near(a.states[-1], q) for q in b.states)


def _one(system, rpm, settings, theta: float, share: Decimal = Decimal(0)) -> After:
    """One machine's motion, its speed larger by a share."""
    motion = TrueMotion(system, rpm, settings, share)
    trail = motion.trail
    if not motion.leave(stretch_at(system.cam, theta), theta):
        return After(UNKNOWN, 0, reason=motion.reason)
    states: list[tuple[float, float]] = []
    for _ in _steps(motion):
        if (since := _returned(trail)) is not None:
            return _cycle(motion, since)
        while len(states) < len(trail.states):
            states.append(tuple(map(float, trail.states[len(states)])))
            if m := repeats(states, trail.symbols[: len(states)]):
                symbols = tuple(trail.symbols[len(states) - m : len(states)])
                grown = motion.worst / NOISE
                return After(SETTLED, len(states), tuple(states[-m:]), symbols, (), grown)
    if motion.reason or len(states) < LONGEST:
        return After(UNKNOWN, len(states), reason=motion.reason or "too many impacts")
    return After(WANDERS, len(states), (states[-1],), (trail.symbols[len(states) - 1],))


def _steps(motion: TrueMotion) -> Iterator[None]:
    """Event by event, up to the limits."""
    trail = motion.trail
    while len(trail.states) < LONGEST and len(trail.impacts) < MOST_IMPACTS and motion.step():
        yield


def _returned(trail) -> int | None:
    """Index of the earlier departure from the rest just left, if there was one."""
    last = trail.leaves[-1][1]
    for k, (_, other) in enumerate(trail.leaves[:-1]):
        if abs(other.theta - last.theta) <= SAME_PLACE:
            return k
    return None


def _cycle(motion: TrueMotion, since: int) -> After:
    """The cycle between two equal departures."""
    trail = motion.trail
    (begins, _), (ends_, _) = trail.leaves[since], trail.leaves[-1]
    m = round((ends_ - begins) / motion.turn)
    last = len(trail.states)  # strobes so far; the turn of the last departure is not over
    states = tuple(tuple(map(float, state)) for state in trail.states[last - m :])
    leaves = tuple(
        (int(place / motion.turn) - last + m - 1, float(at.theta))
        for place, at in trail.leaves[since + 1 :]
    )
    symbols = (*trail.symbols[last - m + 1 :], motion.symbol_of_turn(begins))
    return After(CYCLE, m, states, symbols, leaves, motion.worst / NOISE)
