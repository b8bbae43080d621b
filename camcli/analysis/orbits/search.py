"""Which periodic orbits are there at one speed: by equation, by simulation, by close returns."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from math import inf

from camcli.analysis.integrate import BudgetSpentError, Cost, Record, Settings, Start
from camcli.analysis.labels import FEWEST_TURNS, Label, sections
from camcli.analysis.orbits.identify import (
    RecordedImpact,
    identify,
    impacts_of,
    newton_from,
)
from camcli.analysis.orbits.orbit import PeriodicOrbit, free_orbit, from_root
from camcli.analysis.orbits.same_orbit import close_returns, same_orbit, size_of
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import Continuum, continua, single_impact_roots
from camcli.errors import Status, plural
from camcli.piece_faults import piece
from camcli.system import System

MOST_SINGLE = 6  # turns of the single-impact orbits looked for unasked
CLOUD_LIFTS = 6.0  # heights and velocities (per rad) of the cloud of starts, in lifts of the cam
MOST_STARTS = 64  # motions tried for one label
# Motions among whose close returns a label is sought, however few starts were asked for: one alone
# may never come near an orbit that repels.
FEWEST_RETURNING = 4
MOST_RETURNS = 200  # close returns tried for one label
RETURN = 0.3  # relative distance of the ends of a close return


@dataclass
class OrbitsFound:
    """Orbits at one value of the parameter; `virtual` ones penetrate or pull."""

    orbits: list[PeriodicOrbit] = field(default_factory=list)
    continua: list[Continuum] = field(default_factory=list)
    virtual: list[PeriodicOrbit] = field(default_factory=list)
    cost: Cost = field(default_factory=Cost)

    def add(self, orbit: PeriodicOrbit) -> bool:
        """Keep an orbit that is new; True where it was."""
        of_same_kind = self.orbits if orbit.admissible else self.virtual
        if not orbit.primitive or any(same_orbit(orbit, other) for other in of_same_kind):
            return False
        of_same_kind.append(orbit)
        return True


def find(
    system: System,
    rpm: float,
    settings: Settings,
    starts: int,
    label: Label | None = None,
    most: int = MOST_STARTS,
) -> OrbitsFound:
    """Orbits at one speed: with one impact or none, of the scene's start, and of a cloud of starts.

    `starts` motions are simulated beside the scene's own. With a label only orbits of that label
    are kept; up to `most` starts are tried until one settles on it, then close returns of the
    simulated motions as guesses for an unstable one.
    """
    result = OrbitsFound()
    shooter = Shooter(system, rpm)
    with suppress(BudgetSpentError):
        _find(result, shooter, rpm, settings, starts, label, most)
    if label is not None:
        result.orbits = [orbit for orbit in result.orbits if orbit.label == label]
    result.orbits.sort(key=lambda orbit: (not orbit.stable, orbit.turns, orbit.symbols))
    result.cost = shooter.cost
    return result


def _find(
    result: OrbitsFound, shooter: Shooter, rpm: float, settings: Settings, starts: int,
    label: Label | None, most: int,
) -> None:  # fmt: skip
    """`find` into `result`, where other orbits than the label's may stand too."""
    system = shooter.system
    impacts = 0.0 if label is None else sum(label.symbols)  # of a period; inf with a chatter
    free = piece("the orbit without impacts", partial(free_orbit, system, rpm))
    if free is not None and label in (None, free.label):
        result.add(free)
    if label is None:
        turns_of_single = list(range(1, MOST_SINGLE + 1))
    else:
        turns_of_single = [len(label.symbols)] if impacts == 1.0 else []
    for turns in turns_of_single:
        name = f"the orbits of one impact in {plural(turns, 'turn')} at {rpm:.10g} rpm"
        piece(name, partial(_add_single_impacts, result, shooter, rpm, turns))
    by_equation = bool(result.orbits or result.continua)
    if label is None or (impacts > 0.0 and not by_equation):
        count = starts if label is None else max(starts, most)
        _add_simulated(result, shooter, rpm, settings, count, label)
    # A continuum fills its dwell with orbits of the label, so that none is left to be sought.
    if label is None or result.continua or any(orbit.label == label for orbit in result.orbits):
        return
    if 0.0 < impacts < inf:
        count = max(starts, FEWEST_RETURNING)
        tries = partial(_try_returns, shooter, rpm, settings, count, label, result)
        piece(f"the search for {label} among close returns", tries)


def _add_simulated(
    result: OrbitsFound, shooter: Shooter, rpm: float, settings: Settings, count: int,
    label: Label | None,
) -> None:  # fmt: skip
    """Add the orbits that motions end on: of the scene's start, and of so many of the cloud.

    With a label no more are simulated once an orbit of it is found.
    """
    run = replace(settings, record=FEWEST_TURNS)
    motions = (settings.start, *islice(cloud(shooter.system, rpm), count))
    for k, start in enumerate(motions):
        ends_on = partial(_orbit_from, shooter, rpm, run, start)
        orbit = piece(f"the motion from start {k} at {rpm:.10g} rpm", ends_on)
        if orbit is not None:
            result.add(orbit)
            if orbit.label == label:
                return


def _add_single_impacts(result: OrbitsFound, shooter: Shooter, rpm: float, turns: int) -> None:
    """Add the orbits with one impact in a given number of turns."""
    result.continua += continua(shooter, rpm, turns)
    for root in single_impact_roots(shooter, rpm, turns):
        verdict, _, _ = shooter.verdict(root)
        result.add(from_root(shooter.system, root, verdict))


def _orbit_from(shooter: Shooter, rpm: float, run: Settings, start: Start) -> PeriodicOrbit | None:
    """The orbit that a simulated motion ends on."""
    record = shooter.simulate(shooter.system, rpm, run, start)
    return identify(shooter.system, rpm, record)


def cloud(system: System, rpm: float) -> Iterator[Start]:
    """Starts at the strobe spread over CLOUD_LIFTS lifts: Halton's points in bases 2 and 3."""
    cam = system.cam
    strobe = cam.stretches[cam.strobe]
    reach = CLOUD_LIFTS * (cam.top - min(stretch.start_c for stretch in cam.stretches))
    n = 0
    while True:
        n += 1
        q = strobe.start_c + reach * halton(n, 2)
        w = strobe.start_c1 + reach * (2.0 * halton(n, 3) - 1.0)
        yield Start.at_strobe(system, rpm, (q, w))


def halton(n: int, base: int) -> float:
    """The n-th number of the van der Corput sequence, in (0, 1)."""
    value = 0.0
    share = 1.0
    while n > 0:
        share /= base
        n, digit = divmod(n, base)
        value += share * digit
    return value


def _try_returns(
    shooter: Shooter, rpm: float, settings: Settings, starts: int, label: Label, result: OrbitsFound
) -> None:
    """Newton's method from the closest returns with the label's symbols, the closest first.

    What is solved is added to the result, until an admissible orbit is of that label.
    """
    system = shooter.system
    run = replace(settings, transient=0, record=settings.transient + FEWEST_TURNS)
    close: list[tuple[float, list[RecordedImpact]]] = []  # distance and impacts of each
    for start in (settings.start, *islice(cloud(system, rpm), starts)):
        record = shooter.simulate(system, rpm, run, start)
        if record.status == Status.OK:
            close += _close_returns(record, label)
    for _, impacts in sorted(close, key=lambda pair: pair[0])[:MOST_RETURNS]:
        root = newton_from(shooter, impacts, len(label.symbols))
        if root is None:
            continue
        verdict, _, _ = shooter.verdict(root)
        orbit = from_root(system, root, verdict)
        if orbit.label == label and result.add(orbit) and orbit.admissible:
            return


def _close_returns(record: Record, label: Label) -> Iterator[tuple[float, list[RecordedImpact]]]:
    """(distance, impacts) of every window with the label's symbols that nearly closes."""
    states, symbols = sections(record)
    turns = len(label.symbols)
    if len(states) <= turns:
        return
    impacts = impacts_of(record, range(record.periods))
    first_turns, distances = close_returns(states, turns, size_of(states.tolist()), RETURN)
    for first, distance in zip(first_turns.tolist(), distances.tolist(), strict=True):
        if Label(symbols[first : first + turns]) == label:
            window = range(first, first + turns)
            yield distance, [impact for impact in impacts if impact.period in window]
