"""The machines of the bench: the chapter's, with some constants changed, and runs of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

from camcli.analysis.integrate import Orbit, Settings, Start, Tape
from camcli.cams.compile import build
from camcli.cams.pieces import Part
from camcli.kernel.cam_table import Cam
from camcli.system import Follower, System

NAMES = {1: "impact", 2: "chatter", 3: "detachment"}

Event = tuple[str, int, float, float, float]  # kind, turn, theta (rad), q (m), u (m/rad)


@dataclass(frozen=True)
class Done:
    """What a run of the command line left: exit code, stdout and stderr."""

    code: int
    out: str
    said: str


@dataclass(frozen=True)
class Bench:
    """What the bench needs from outside: cams by their scene section, and the command line."""

    parts_of: Callable[[Mapping[str, Any]], list[Part]]
    command: Callable[[Sequence[str]], Done]
    tables: dict[str, Cam] = field(default_factory=dict)
    systems: dict[str, System] = field(default_factory=dict)

    def cam(self, section: Mapping[str, Any], strobe_deg: float = 0.0) -> Cam:
        """The compiled table of a cam section, kept."""
        key = json.dumps([section, strobe_deg], sort_keys=True)
        if key not in self.tables:
            self.tables[key] = build(self.parts_of(section), strobe_deg)
        return self.tables[key]

    def system(self, name: str, make: Callable[[], System]) -> System:
        """A machine by its name, made once and kept."""
        if name not in self.systems:
            self.systems[name] = make()
        return self.systems[name]

    def chapter(self, strobe_deg: float = 0.0, **changes: float) -> System:
        """The chapter's follower on the chapter's cam, some constants changed."""
        machine = reference("stability")
        follower = Follower(**{**machine["follower"], **changes})
        return System(follower, self.cam(machine["cam"], strobe_deg))


@cache
def reference(name: str) -> dict[str, Any]:
    """A file of reference results (tests/bench/make_reference.py makes them)."""
    folder = files("camcli.analysis.bench") / "reference"
    return json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))


def settings(
    record: int = 3, transient: int = 0, tolerance: float = 1e-9, budget: int = 1_000_000, **start
) -> Settings:
    """Settings with short names; `start` holds q (m), v (m/s), theta_deg."""
    return Settings(transient, record, tolerance, budget, Start(**start))


def run(system: System, rpm: float, **wanted) -> Tape:
    """The tape of one orbit; `wanted` as for `settings`."""
    return Orbit(system, rpm, settings(**wanted)).run()


def events(tape: Tape, first: int = 0) -> list[Event]:
    """Every logged event; `first`: 1 for a start off the strobe."""
    columns = zip(tape.kind, tape.period, tape.theta, tape.q, tape.u, strict=True)
    return [
        (NAMES[int(k)], int(p) + first, float(t), float(q), float(u)) for k, p, t, q, u in columns
    ]


def phases(tape: Tape, kind: str = "impact") -> list[float]:
    """Phases of the events of a kind, rad."""
    return [theta for name, _, theta, _, _ in events(tape) if name == kind]
