"""The machines of the bench: the example's, with some constants changed, and runs of them."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from camcli.analysis.integrate import Orbit, Record, Settings, Start
from camcli.cams.compile import Shape
from camcli.kernel.orbit_loop import EventKind
from camcli.system import Follower, System


class LoggedEvent(NamedTuple):
    """A logged event."""

    kind: str
    turn: int
    theta: float  # rad
    q: float  # m
    u: float  # m/rad


class Machines:
    """Machines with the cams of scene sections; `shape_of` gives the cam that a section means."""

    def __init__(self, shape_of: Callable[[Mapping[str, Any]], Shape]):
        self.shape_of = shape_of
        self.made: dict[str, System] = {}

    def system(self, follower: Follower, section: Mapping[str, Any], strobe: float = 0.0) -> System:
        """A follower on a cam, whose compiled table is kept."""
        key = json.dumps([section, strobe], sort_keys=True)
        if key not in self.made:
            self.made[key] = System.build(follower, self.shape_of(section), strobe)
        return replace(self.made[key], follower=follower)

    def example(self, strobe: float = 0.0, **changes: float) -> System:
        """The cam-follower example of Osorio, di Bernardo and Santini (2008), some changed."""
        stored = reference("stability")
        return self.system(Follower(**{**stored["follower"], **changes}), stored["cam"], strobe)


@cache
def reference(name: str) -> dict[str, Any]:
    """A file of reference results (tests/bench/make_reference.py makes them)."""
    folder = files("camcli.analysis.bench") / "reference"
    return json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))


def orbit(
    system: System,
    rpm: float,
    record: int = 3,
    transient: int = 0,
    tolerance: float = 1e-9,
    budget: int = 1_000_000,
    **start,
) -> Orbit:
    """An orbit at its start, `start` with q (m), v (m/s), theta (rad)."""
    return Orbit(system, rpm, Settings(transient, record, tolerance, budget, Start(**start)))


def run(system: System, rpm: float, **wanted) -> Record:
    """The record of one orbit; `wanted` as for `orbit`."""
    return orbit(system, rpm, **wanted).run()


def events(record: Record, first: int = 0) -> list[LoggedEvent]:
    """Every logged event; `first`: 1 for a start off the strobe, whose turn the record calls -1."""
    return [
        LoggedEvent(EventKind(kind).text, period + first, theta, q, u)
        for kind, period, theta, q, u in record.events()
    ]


def phases(record: Record, kind: str = "impact") -> list[float]:
    """Phases of the events of a kind, rad."""
    return [event.theta for event in events(record) if event.kind == kind]
