"""Which periodic orbits are there at one speed: by equation, by simulation, by close returns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from math import inf

from camcli.analysis.integrate import Cost, Record, Settings, Start
from camcli.analysis.labels import LONGEST_PERIOD, Label
from camcli.analysis.orbits.identify import identify, impacts_of, newton_from, passages
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.same_orbit import distance, same_orbit, size_of
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.errors import Status
from camcli.system import System, omega_of

MOST_SINGLE = 6  # turns of the single-impact orbits looked for unasked
WINDOW = 6.0  # heights and velocities (per rad) of the cloud of starts, in lifts of the cam
MOST_STARTS = 64  # motions tried for one label
MOST_RETURNS = 200  # close returns tried for one label
RETURN = 0.3  # relative distance of the ends of a close return
RECORD = 2 * LONGEST_PERIOD + 2  # turns


@dataclass
class OrbitsFound:
    """Orbits at one value of the parameter; `virtual` ones penetrate or pull."""

    orbits: list[PeriodicOrbit] = field(default_factory=list)
    virtual: list[PeriodicOrbit] = field(default_factory=list)
    cost: Cost = field(default_factory=Cost)

    def add(self, orbit: PeriodicOrbit) -> bool:
        """Keep an orbit that is new; True where it was."""
        kept = self.orbits if orbit.admissible else self.virtual
        if not orbit.primitive or any(same_orbit(orbit, other) for other in kept):
            return False
        kept.append(orbit)
        return True


def find(
    system: System,
    rpm: float,
    settings: Settings,
    starts: int,
    label: Label | None = None,
    most: int = MOST_STARTS,
) -> OrbitsFound:
    """Orbits at one speed: of the scene's start, of a cloud of starts, and with one impact.

    `starts` motions are simulated beside the scene's own. With a label only orbits of that label
    are kept; up to `most` starts are tried until one settles on it, then close returns of the
    simulated motions as guesses for an unstable one.
    """
    found, shooter = OrbitsFound(), Shooter(system, rpm)
    turns: Sequence[int] = range(1, MOST_SINGLE + 1)
    if label is not None:
        turns = [len(label.symbols)] if sum(label.symbols) == 1.0 else []
    for m in turns:
        for root in single_impact_roots(shooter, rpm, m):
            found.add(from_root(system, root, shooter.verdict(root)[0]))
    if label is None:
        _simulate(shooter, rpm, settings, starts, found)
    elif not found.orbits:
        _simulate(shooter, rpm, settings, max(starts, most), found, label)
        found.orbits = [orbit for orbit in found.orbits if orbit.label == label]
        if not found.orbits and inf not in label.symbols:
            _try_returns(shooter, rpm, settings, max(starts, 4), label, found)
    found.orbits.sort(key=lambda orbit: (not orbit.stable, orbit.turns, orbit.symbols))
    found.cost = shooter.cost
    return found


def starts_of(system: System, rpm: float, settings: Settings, count: int) -> Iterator[Start]:
    """The scene's start, then `count` of the cloud."""
    yield settings.start
    yield from islice(cloud(system, rpm), count)


def cloud(system: System, rpm: float) -> Iterator[Start]:
    """Starts at the strobe spread over WINDOW lifts: Halton's points in bases 2 and 3."""
    cam, omega = system.cam, omega_of(rpm)
    strobe = cam.stretches[cam.strobe]
    low = min(cam.stretches[i].start_c for i in range(len(cam.stretches)))
    reach = WINDOW * (cam.top - low)
    n = 0
    while True:
        n += 1
        q = strobe.start_c + reach * halton(n, 2)
        w = strobe.start_c1 + reach * (2.0 * halton(n, 3) - 1.0)
        yield Start(q, w * omega, system.strobe_deg)


def halton(n: int, base: int) -> float:
    """The n-th number of the van der Corput sequence, in (0, 1)."""
    value, share = 0.0, 1.0
    while n > 0:
        share /= base
        n, digit = divmod(n, base)
        value += share * digit
    return value


def _simulate(
    shooter: Shooter,
    rpm: float,
    settings: Settings,
    starts: int,
    found: OrbitsFound,
    label: Label | None = None,
) -> None:
    """Add what the scene's start and `starts` others settle on, up to the first of the label."""
    system, run = shooter.system, replace(settings, record=RECORD)
    for start in starts_of(system, rpm, settings, starts):
        orbit = identify(system, rpm, shooter.simulate(system, rpm, run, start))
        if orbit is not None:
            found.add(orbit)
            if orbit.label == label:
                return


def _try_returns(
    shooter: Shooter,
    rpm: float,
    settings: Settings,
    starts: int,
    label: Label,
    found: OrbitsFound,
) -> None:
    """Newton's method from the closest returns with the label's symbols."""
    system, m = shooter.system, len(label.symbols)
    run = replace(settings, transient=0, record=settings.transient + RECORD)
    tries: list[tuple[float, list]] = []
    for start in starts_of(system, rpm, settings, starts):
        record = shooter.simulate(system, rpm, run, start)
        if record.status == Status.OK:
            tries += _close_returns(record, label)
    for _, events in sorted(tries, key=lambda pair: pair[0])[:MOST_RETURNS]:
        root = newton_from(shooter, events, m)
        if root is not None:
            orbit = from_root(system, root, shooter.verdict(root)[0])
            if orbit.label == label and found.add(orbit) and orbit.admissible:
                return


def _close_returns(record: Record, label: Label) -> Iterator[tuple[float, list]]:
    """(distance, impacts) of every window with the label's symbols that nearly closes."""
    states, symbols = passages(record)
    m, size = len(label.symbols), size_of(states)
    by_turn: dict[int, list] = {}
    for event in impacts_of(record, range(record.periods)):
        by_turn.setdefault(event[0], []).append(event)
    for k in range(len(states) - m):
        if Label(symbols[k : k + m]) != label:
            continue
        gap = distance(states[k + m], states[k], size)
        if gap <= RETURN:
            yield gap, [event for turn in range(k, k + m) for event in by_turn.get(turn, [])]
