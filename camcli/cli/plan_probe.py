"""What a run will do, from a short look at some of it in plain Python; nothing is compiled.

The number of kernel steps is bounded, never the time: the same scene gives the same counts. Only
the time these steps take is measured, and says how fast this machine is at the moment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from time import perf_counter

from camcli.analysis.integrate import Orbit, Settings, Start, with_turns
from camcli.errors import Status
from camcli.kernel.backend import PLAIN
from camcli.kernel.cam_table import ROW, START
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import (
    LOGGED,
    MODE,
    PERIOD,
    STRETCH,
    TOTAL,
    EventKind,
    Log,
    Plan,
    Strobe,
)
from camcli.system import System

STEPS = 24_000  # kernel steps of all looks together: some tenths of a second
PICKS = 24  # speeds looked at
ROWS = 96  # events kept of a look, as a sample of what the tables will hold
EVALUATION, CROSSING = 4.8e-6, 2.3e-6  # s in plain Python, on the machine of all constants
COMPILED = 85.0  # times faster than plain Python


@dataclass(frozen=True)
class Glance:
    """The first turns of one orbit; `ended`: its status was not ok, there are no more.

    impacts: of each whole turn; rest: of the turn that was left unfinished; states: (q, dq/dtheta)
    at the begin of every turn; rows: (theta_deg, q_m, u_minus_m_per_s) of some of the impacts;
    chatter: whether one was completed; plain: s this took; nominal: s it takes on the machine of
    all constants.
    """

    rpm: float
    impacts: Sequence[int]
    rest: int
    states: Sequence[tuple[float, float]]
    rows: Sequence[tuple[float, float, float]]
    chatter: bool
    ended: bool
    plain: float
    nominal: float

    @property
    def turns(self) -> int:
        """Whole turns seen."""
        return len(self.impacts)

    def later(self) -> float:
        """Impacts per turn once the first half of what was seen is over."""
        half = self.impacts[self.turns // 2 :]
        return sum(half) / len(half) if half else float(self.rest)

    def impacts_of(self, turns: int) -> float:
        """Impacts of the first so many turns: as seen, then going on as in the second half."""
        if self.turns >= turns:
            return float(sum(self.impacts[:turns]))
        if self.ended:
            return float(sum(self.impacts) + self.rest)
        return sum(self.impacts) + self.later() * (turns - self.turns)

    @property
    def turn(self) -> float:
        """Seconds of a turn in plain Python, on the machine of all constants."""
        return self.nominal / max(1, self.turns)


def glance(
    system: System,
    rpm: float,
    settings: Settings,
    turns: int,
    steps: int,
    begin: tuple[float, float] | None = None,
) -> Glance:
    """Follow one orbit for at most `turns` turns and `steps` kernel steps.

    It begins at the scene's start, or at the strobe where `begin` is given: (gap m, rate m/rad);
    nothing is then kept as rows.
    """
    began = perf_counter()
    orbit = Orbit(system, rpm, with_turns(settings, 0, turns), None if begin is None else Start())
    if begin is not None:
        _place(orbit, *begin)
    flows = PLAIN.stretch_flows(system.cam, orbit.lane)
    state, count = list(orbit.state), list(orbit.count)
    turns, rows = min(turns, steps), steps if begin is None else 0
    strobe = Strobe(PLAIN.zeros(2 * turns + 2), PLAIN.zeros(2 * turns + 2, int), turns + 1)
    if count[PERIOD] == 0:
        strobe.state[0], strobe.state[1] = orbit.position()
    written = Log(PLAIN.zeros(2 * rows, int), PLAIN.zeros(3 * rows), rows)
    work = PLAIN.zeros(3, int)
    status = PLAIN.advance(
        system.cam, orbit.lane, flows, state, count, Plan(-1, turns, steps), written,
        strobe, work,
    )  # fmt: skip
    whole = max(0, min(int(count[PERIOD]), turns))
    impacts = [int(n) for n in strobe.events[: 2 * whole : 2]]
    flat = [float(x) for x in strobe.state[: 2 * whole + 2]]
    return Glance(
        rpm=rpm,
        impacts=impacts,
        rest=int(count[TOTAL]) - sum(impacts),
        states=list(zip(flat[::2], flat[1::2], strict=True)),
        rows=_sample(written, int(count[LOGGED]), orbit.omega),
        chatter=any(strobe.events[1 : 2 * whole : 2]),
        ended=status not in (Status.OK, Status.PAUSED),
        plain=perf_counter() - began,
        nominal=_nominal(work),
    )


def _place(orbit: Orbit, gap: float, rate: float) -> None:
    """Put an orbit at a state at the strobe."""
    cam, count = orbit.system.cam, [0] * len(orbit.count)
    count[MODE] = FREE if gap > 0.0 or rate < 0.0 else BOUNCED
    count[STRETCH] = cam.strobe
    orbit.state, orbit.count = [cam.rows[cam.strobe * ROW + START], gap, rate], count


def picked(values: Sequence, most: int = PICKS) -> list:
    """At most so many of the values, from all over them."""
    n = len(values)
    if n <= most:
        return list(values)
    return [values[(2 * k + 1) * n // (2 * most)] for k in range(most)]


def grid_picks(rpm, most: int = PICKS) -> list[float]:
    """Some of the speeds of a range, which may be too long to make."""
    numbers = picked(range(rpm.num), most)
    return [rpm.start + (rpm.stop - rpm.start) * (k / max(1, rpm.num - 1)) for k in numbers]


def _nominal(work) -> float:
    """Seconds of this work on the machine of all constants."""
    return max(EVALUATION * float(work[0]) + CROSSING * float(work[1]), 1e-9)


def _sample(log: Log, used: int, omega: float) -> list[tuple[float, float, float]]:
    """Some of the impacts of the second half of a log, as the tables have them."""
    late = [k for k in range(used // 2, used) if log.whole[2 * k] == EventKind.IMPACT]
    return [
        (
            float(log.real[3 * k]) * (180.0 / pi),
            float(log.real[3 * k + 1]),
            float(log.real[3 * k + 2]) * omega,
        )
        for k in picked(late, ROWS)
    ]
