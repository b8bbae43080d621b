"""Which periodic orbits are there at one speed: by equation, by simulation, by close returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice
from math import inf

from camcli.analysis.integrate import Cost, Orbit, Settings, Start
from camcli.analysis.labels import LONGEST_PERIOD, name
from camcli.analysis.orbits.identify import identify, impacts_of, newton_from, passages
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root, primitive
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.singles import single_impact_roots
from camcli.errors import OK
from camcli.kernel.cam_table import ROW, START0, START1
from camcli.system import System, omega_of

SAME = 1e-7  # relative distance of section states that counts as none
MOST_SINGLE = 6  # turns of the single-impact orbits looked for unasked
WINDOW = 6.0  # heights and velocities (per rad) of the cloud of starts, in lifts of the cam
MOST_STARTS = 64  # motions tried for one label
MOST_RETURNS = 200  # close returns tried for one label
RETURN = 0.3  # relative distance of the ends of a close return
RECORD = 2 * LONGEST_PERIOD + 2  # turns


@dataclass
class Found:
    """Orbits at one value of the parameter; `virtual` ones penetrate or pull."""

    orbits: list[PeriodicOrbit] = field(default_factory=list)
    virtual: list[PeriodicOrbit] = field(default_factory=list)
    cost: Cost = field(default_factory=Cost)

    def add(self, orbit: PeriodicOrbit | None) -> bool:
        """Keep an orbit that is new; True where it was."""
        kept = self.orbits if orbit is None or orbit.admissible else self.virtual
        if orbit is None or not primitive(orbit) or any(same_orbit(orbit, o) for o in kept):
            return False
        kept.append(orbit)
        return True


def same_orbit(a: PeriodicOrbit, b: PeriodicOrbit) -> bool:
    """True for the same turns, symbols and section states."""
    if a.symbols != b.symbols or len(a.theta) != len(b.theta):
        return False
    size = [max(abs(s[j]) for s in a.states) or 1.0 for j in range(2)]
    return all(
        abs(s[j] - t[j]) <= SAME * size[j]
        for s, t in zip(a.states, b.states, strict=True)
        for j in range(2)
    )


def find(
    system: System,
    rpm: float,
    settings: Settings,
    starts: int,
    label: str | None = None,
    most: int = MOST_STARTS,
) -> Found:
    """Orbits at one speed: of the scene's start, of a cloud of starts, and with one impact.

    `starts` motions are simulated beside the scene's own. With a label only orbits of that label
    are kept; up to `most` starts are tried until one settles on it, then close returns of the
    simulated motions as guesses for an unstable one.
    """
    found = Found()
    shooter = Shooter(system, rpm)
    turns = [*range(1, MOST_SINGLE + 1)] if label is None else _single_turns(label)
    for m in turns:
        for root in single_impact_roots(shooter, rpm, m):
            found.add(from_root(system, root, shooter.verdict(root)[0]))
    if label is None:
        _simulated(system, rpm, settings, starts, found)
    elif not found.orbits:
        _simulated(system, rpm, settings, max(starts, most), found, label)
        found.orbits = [orbit for orbit in found.orbits if orbit.label == label]
        if not found.orbits and inf not in symbols_of(label):
            _by_returns(system, shooter, rpm, settings, max(starts, 4), label, found)
    found.orbits.sort(key=lambda orbit: (not orbit.stable, orbit.turns, orbit.symbols))
    found.cost = found.cost + shooter.cost
    return found


def _simulated(
    system, rpm, settings: Settings, starts: int, found: Found, label: str | None = None
) -> None:
    """Add what the scene's start and `starts` others settle on, up to the first of the label."""
    run = replace(settings, record=RECORD)
    for start in (settings.start, *islice(cloud(system, rpm), starts)):
        tape = Orbit(system, rpm, run, start).run()
        found.cost = found.cost + tape.cost
        orbit = identify(system, rpm, tape)
        found.add(orbit)
        if orbit is not None and orbit.label == label:
            return


def cloud(system: System, rpm: float) -> Iterator[Start]:
    """Starts at the strobe spread over WINDOW lifts: Halton's points in bases 2 and 3."""
    cam, omega = system.cam, omega_of(rpm)
    o = cam.strobe * ROW
    low = min(cam.rows[i * ROW + START0] for i in range(cam.stretches))
    reach = WINDOW * (cam.top - low)
    n = 0
    while True:
        n += 1
        x, y = halton(n, 2), halton(n, 3)
        q = cam.rows[o + START0] + reach * x
        w = cam.rows[o + START1] + reach * (2.0 * y - 1.0)
        yield Start(q, w * omega, system.strobe_deg)


def halton(n: int, base: int) -> float:
    """The n-th number of the van der Corput sequence, in (0, 1)."""
    value, share = 0.0, 1.0
    while n > 0:
        share /= base
        n, digit = divmod(n, base)
        value += share * digit
    return value


def symbols_of(label: str) -> tuple[float, ...]:
    """The symbols of a label P(m;s1:...:sm); ValueError where it is none."""
    text = label.strip()
    if not (text.startswith("P(") and text.endswith(")") and ";" in text):
        raise ValueError(f"found '{label}'")
    turns, _, words = text[2:-1].partition(";")
    counts = [word.strip() for word in words.split(":")]
    if not turns.strip().isdecimal() or not all(w == "inf" or w.isdecimal() for w in counts):
        raise ValueError(f"found '{label}'")
    symbols = tuple(inf if word == "inf" else float(int(word)) for word in counts)
    if int(turns) != len(symbols) or len(symbols) > LONGEST_PERIOD:
        raise ValueError(f"found '{label}'")
    return symbols


def canonical(label: str) -> str:
    """The label in the rotation that names it."""
    return name(symbols_of(label))


def _single_turns(label: str) -> list[int]:
    symbols = symbols_of(label)
    return [len(symbols)] if sum(symbols) == 1.0 else []


def _by_returns(system, shooter, rpm, settings, starts, label: str, found: Found) -> None:
    """Newton's method from the closest returns with the label's symbols."""
    wanted = symbols_of(label)
    m = len(wanted)
    rotations = {wanted[k:] + wanted[:k] for k in range(m)}
    run = replace(settings, transient=0, record=settings.transient + RECORD)
    tries = []
    for start in (settings.start, *islice(cloud(system, rpm), starts)):
        tape = Orbit(system, rpm, run, start).run()
        found.cost = found.cost + tape.cost
        if tape.status == OK:
            tries += _returns(tape, m, rotations)
    for _, events in sorted(tries, key=lambda pair: pair[0])[:MOST_RETURNS]:
        root = newton_from(system, shooter, events, m)
        if root is not None:
            orbit = from_root(system, root, shooter.verdict(root)[0])
            if orbit.label == label and found.add(orbit) and orbit.admissible:
                return


def _returns(tape, m: int, rotations):
    """(distance, impacts) of every window of m turns with the wanted symbols that nearly closes."""
    states, symbols = passages(tape)
    size = [max(abs(s[j]) for s in states) or 1.0 for j in range(2)]
    by_turn: dict[int, list] = {}
    for event in impacts_of(tape, range(tape.periods)):
        by_turn.setdefault(event[0], []).append(event)
    for k in range(len(states) - m):
        if tuple(symbols[k : k + m]) not in rotations or inf in symbols[k : k + m]:
            continue
        gap = max(abs(states[k + m][j] - states[k][j]) / size[j] for j in range(2))
        if gap <= RETURN:
            yield gap, [event for turn in range(k, k + m) for event in by_turn.get(turn, [])]
