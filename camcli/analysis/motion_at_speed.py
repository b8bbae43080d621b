"""The motion that one speed of a sweep ends on: its record, its label and its loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import nan
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.classify import ClassifiedMotion, classify_at
from camcli.analysis.integrate import (
    Cost,
    Orbit,
    Record,
    Settings,
    Setup,
    Start,
    run_all,
    with_turns,
)
from camcli.analysis.labels import APERIODIC, UNDECIDED, sections
from camcli.analysis.loads import loads_of
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.same_orbit import SAME, distances, size_of
from camcli.analysis.patience import (
    cost_beyond,
    forgets_too_much,
    named_on,
    names_nothing,
    turns_after,
)
from camcli.analysis.speeds import NOTHING, Speed
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.cam_table import lift_at
from camcli.kernel.orbit_loop import IMPACT
from camcli.piece_faults import PieceFault, attempt
from camcli.system import System

ON_CAM = 1e-12  # relative distance of a state from the cam's that is rounding
TURNS_AT_ONCE, SPEEDS_AT_ONCE = 20_000, 64  # most of a call of the kernel: some 5 ms


@dataclass(frozen=True)
class SpeedTask:
    """A sweep's work at one of its values, wherever it is done.

    key: of what is varied; setup: makes machine, speed (rpm) and settings of a value; impacts,
    strobe: whether these sections are wanted; lyapunov: whether the exponents are; turns: of all
    values together; turns_each: of one value. follow: where a rest makes the record one of many,
    the true motion is followed beyond doubles, else it is undecided. start: None for the scene's.
    patient: what looks aperiodic is followed on, as `classify` does. keeps_ends: the result holds
    the state at its end, where the next speed may start.
    """

    key: str
    setup: Callable[[float], Setup]
    impacts: bool
    strobe: bool
    lyapunov: bool
    turns: float
    turns_each: float
    follow: bool = True
    start: Start | None = None
    patient: bool = False
    keeps_ends: bool = False

    def __call__(self, value: float) -> Speed:
        """The motion at a value, from the task's start."""
        return self.started_at(value, self.start)

    def after(self, before: Speed | None, value: float) -> Speed:
        """The motion at a value, from where the one before ended; the first has None before it."""
        return self.started_at(value, self.start if before is None else before.end)

    @property
    def at_once(self) -> int:
        """How many values `many` should be given: few turns in all, for an interrupt waits so long.

        Plain Python switches to the compiled kernel in the middle of an orbit, so it takes one.
        """
        backend.for_work(self.turns)
        if not backend.current().compiled:
            return 1
        return max(1, min(SPEEDS_AT_ONCE, int(TURNS_AT_ONCE / max(1.0, self.turns_each))))

    def many(self, values: Sequence[float]) -> list[Speed]:
        """The motions at several values, each as if alone, in fewer calls of the kernel."""
        if len(values) == 1:
            return [self(values[0])]
        begun = [self._begun(value, self.start) for value in values]
        orbits = [one for one in begun if isinstance(one, BegunOrbit)]
        records = attempt("", lambda: _records_of(orbits))
        if isinstance(records, PieceFault):  # alone, each value shows whether it is at fault
            return [self(value) for value in values]
        speeds = []
        next_records = iter(records)
        for value, one in zip(values, begun, strict=True):
            if isinstance(one, BegunOrbit):
                record, longer = next(next_records)
                speeds.append(self._ended(value, one, record, longer))
            else:
                speeds.append(one)
        return speeds

    def started_at(self, value: float, start: Start | None) -> Speed:
        """The motion at a value from a start; a fault is kept in the result and not raised."""
        one = self._begun(value, start)
        if not isinstance(one, BegunOrbit):
            return one
        record = attempt(one.name, lambda: run_all([one.orbit], loads=True)[0])
        if isinstance(record, PieceFault):
            return self._failed(value, one.rpm, record)
        return self._ended(value, one, record)

    def _begun(self, value: float, start: Start | None) -> BegunOrbit | Speed:
        """The orbit of a value, ready to run; a result with its fault where it cannot be made."""
        name = f"{self.key} = {value!r}"
        if start is not None and start == self.start:
            name += f" from {start.place}"
        machine = attempt(name, lambda: self.setup(value))
        if isinstance(machine, PieceFault):
            return self._failed(value, nan, machine)
        system, rpm, settings = machine
        orbit = attempt(name, lambda: Orbit(system, rpm, settings, start))
        if isinstance(orbit, PieceFault):
            return self._failed(value, rpm, orbit)
        return BegunOrbit(name, system, rpm, settings, start, orbit)

    def _ended(
        self, value: float, one: BegunOrbit, record: Record, longer: Record | None = None
    ) -> Speed:
        """Name and measure an orbit that has run; longer: its longer record, see `named_on`."""
        speed = attempt(one.name, lambda: self._measured(value, one, record, longer))
        return self._failed(value, one.rpm, speed) if isinstance(speed, PieceFault) else speed

    def _failed(self, value: float, rpm: float, fault: PieceFault) -> Speed:
        """A result of which nothing is known; the sections that are wanted have no rows."""
        reals = np.empty(0)
        counts = np.empty(0, int)
        return Speed(
            value=value,
            rpm=rpm,
            label=UNDECIDED,
            impact_count=None,
            status=Status.FAULT,
            impacts=(counts, reals, reals, reals) if self.impacts else None,
            strobe=(range(0), reals, reals, counts, counts) if self.strobe else None,
            cost=Cost(),
            fault=fault,
        )

    def _measured(
        self, value: float, one: BegunOrbit, record: Record, longer: Record | None
    ) -> Speed:
        """Name what an orbit ends on, and measure its loads.

        Where rounding decides the record after a rest, the true motion is followed if `follow` asks
        for it, else it counts as not known. An aperiodic record is followed on if `patient`.
        """
        end = None
        cost = record.cost if longer is None else record.cost + longer.cost
        status = record.status
        known = True
        holds_for = None
        watched = None
        label = UNDECIDED
        exponents = None
        one_of_many = forgets_too_much(record)
        if not one_of_many:
            label, exponents, named_by = named_on(one.orbit, one.rpm, record, self.lyapunov, longer)
            one_of_many = forgets_too_much(named_by)
            if named_by is not longer:
                cost = cost + cost_beyond(record, named_by)
        if one_of_many and not self.follow:
            label = UNDECIDED
            exponents = None
            known = False
        elif one_of_many or (self.patient and label == APERIODIC):
            motion, record, end = true_motion(one.orbit, one.rpm, one.settings, one.start, record)
            label = motion.label
            exponents = motion.exponents
            known = label != UNDECIDED
            cost = cost + motion.cost
            holds_for = motion.holds_for
            watched = motion.watched
            if status == Status.OK:
                status = Status(motion.status)
        elif label == APERIODIC:
            watched = one.settings.transient + record.periods
        if not self.keeps_ends or status != Status.OK:
            end = None
        elif end is None:
            end = one.orbit.as_start()
        largest = None
        standard_error = None
        if self.lyapunov and exponents:
            largest = exponents.largest
            standard_error = exponents.spread
        return Speed(
            value=value,
            rpm=one.rpm,
            label=label,
            impact_count=record.hits,
            status=status,
            impacts=_impact_rows(record, one.orbit.omega) if self.impacts else None,
            strobe=_strobe_rows(record, one.orbit.omega) if self.strobe else None,
            cost=cost,
            exponent=largest,
            exponent_error=standard_error,
            end=end,
            loads=loads_of(one.system, one.rpm, record) if known else NOTHING,
            known=known,
            holds_for=holds_for,
            watched=watched,
        )


class BegunOrbit(NamedTuple):
    """An orbit at its start; name: of the piece of work that it is."""

    name: str
    system: System
    rpm: float
    settings: Settings
    start: Start | None
    orbit: Orbit


def _records_of(begun: Sequence[BegunOrbit]) -> list[tuple[Record, Record | None]]:
    """The records of orbits, each with the turns after it where it is too short for a label."""
    records = _together([one.orbit for one in begun], loads=True)
    short = [k for k, record in enumerate(records) if names_nothing(record)]
    longer: dict[int, Record] = {}
    if short:
        after = _together([turns_after(begun[k].orbit) for k in short], loads=False)
        longer = dict(zip(short, after, strict=True))
    return [(record, longer.get(k)) for k, record in enumerate(records)]


def _together(orbits: Sequence[Orbit], loads: bool) -> list[Record]:
    """The records of orbits; neighbours on one cam are computed in one call of the kernel."""
    records: list[Record] = []
    for _, members in groupby(orbits, lambda orbit: id(orbit.system.cam)):
        records += run_all(list(members), loads=loads)
    return records


def true_motion(
    run: Orbit, rpm: float, settings: Settings, start: Start | None, record: Record
) -> tuple[ClassifiedMotion, Record, Start]:
    """(the motion as `classify` names it, a record that shows it, the state at that record's end).

    run, record: the plain run of doubles, at its end, and its record. The record is given back
    where the motion has no orbit, or where each turn of the record is a turn of that orbit.
    Otherwise doubles ended elsewhere: between two rests an error of rounding may grow beyond all
    digits, so that theirs is one of many motions, or the record was over before the motion had
    settled. Then the record returned consists of as many turns computed from the states of the
    orbit.
    """
    system = run.system
    motion = classify_at(system, rpm, settings, start, begun=(run, record))
    orbit = motion.orbit
    if orbit is None or _shows(record, orbit):
        return motion, record, run.as_start()
    starts = [start_at(system, rpm, state) for state in orbit.states]
    one_turn = with_turns(settings, 0, 1)
    turns = run_all([Orbit(system, rpm, one_turn, begin) for begin in starts])
    motion = replace(motion, cost=sum((turn.cost for turn in turns), motion.cost))
    count = record.periods
    shown = _over_and_over(turns, count)
    return motion, shown, starts[count % orbit.turns]


def _shows(record: Record, orbit: PeriodicOrbit) -> bool:
    """True where every turn of a record is a turn of the orbit.

    A turn of the record is one of the orbit if it begins at one of the orbit's states, within SAME,
    and has as many impacts as the orbit has from that state. The order of the turns need not be
    compared: the same map leads from each to the next.
    """
    states, symbols = sections(record)
    size = size_of(orbit.states)
    of_orbit = np.array(orbit.states)
    if len(states) and not (distances(of_orbit, states[0], size) <= SAME).any():
        return False  # as of most records of another motion
    near = np.array([distances(states, state, size) <= SAME for state in of_orbit])
    if not near.any(axis=0).all():
        return False
    state_of_turn = near.argmax(axis=0).tolist()
    return all(
        orbit.symbols[state] == symbol for state, symbol in zip(state_of_turn, symbols, strict=True)
    )


def start_at(system: System, rpm: float, state: Sequence[float]) -> Start:
    """A state (m, m/rad) at the strobe as a start; None values where it rests on the cam."""
    c, c1, _ = lift_at(system.cam, system.cam.strobe, system.strobe)
    q, w = state
    if abs(q - c) <= ON_CAM * abs(c) and abs(w - c1) <= ON_CAM * (abs(c1) + abs(c)):
        return Start.at_strobe(system, rpm, None)
    return Start.at_strobe(system, rpm, state)


def _over_and_over(turns: Sequence[Record], count: int) -> Record:
    """A record of `count` turns: those given, each a record of its one turn, over and over."""
    rounds, left = divmod(count, len(turns))  # whole rounds, and the turns after them
    in_first_turn = [turn.period == 0 for turn in turns]  # rows of each log
    rows = np.array([mask.sum() for mask in in_first_turn])

    def repeated(one_round: np.ndarray, entries_left: int) -> np.ndarray:
        """The entries of a round, over and over, and the first of them once more."""
        return np.concatenate((np.tile(one_round, rounds), one_round[:entries_left]))

    columns: dict[str, Any] = {}
    for name in ("kind", "theta", "q", "u"):
        parts = [getattr(turn, name)[mask] for turn, mask in zip(turns, in_first_turn, strict=True)]
        columns[name] = repeated(np.concatenate(parts), rows[:left].sum())
    columns["period"] = np.repeat(np.arange(count), repeated(rows, left))
    for name in ("strobe_q", "strobe_w", "impacts", "chatter"):
        columns[name] = repeated(np.array([getattr(turn, name)[0] for turn in turns]), left)
    sums: dict[str, Any] = {}
    for name in ("hits", "chatters"):
        sums[name] = int(repeated(np.array([getattr(turn, name) for turn in turns]), left).sum())
    unknown: dict[str, Any] = {"repeats": 0, "near": False, "loads": None}
    last = turns[(count - 1) % len(turns)]
    return last._replace(**columns, **sums, **unknown, periods=count)


def _impact_rows(record: Record, omega: float) -> tuple:
    """(period, theta_deg, q_m, u_minus_m_per_s) of the impacts of whole recorded periods.

    omega: of the cam, rad/s, by which a rate per rad becomes a velocity.
    """
    if record.hits == len(record.kind):  # nothing else was logged
        angles = np.degrees(record.theta)
        return record.period.copy(), angles, record.q.copy(), record.u * omega
    rows = (record.kind == IMPACT) & (record.period >= 0)
    return (
        record.period[rows],
        np.degrees(record.theta[rows]),
        record.q[rows],
        record.u[rows] * omega,
    )


def _strobe_rows(record: Record, omega: float) -> tuple:
    """(period, q_m, v_m_per_s, impacts, chatter) of the whole recorded periods."""
    count = record.periods
    q = record.strobe_q[:count]
    v = record.strobe_w[:count] * omega
    return range(count), q, v, record.impacts[:count], record.chatter[:count]
