"""A case of the precision part: its machine, and the stored reference of its motion."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from math import pi
from typing import Any

from camcli.analysis.bench.machine import Bench, reference
from camcli.analysis.bench.peers.lifts import lift_of
from camcli.system import Follower, System, omega_of

OPTIONAL = 1e-3  # turns before an accumulation: impacts there are not asked of anybody
ROUNDING = 2.220446049250313e-16
ALLOWANCE = 8  # roundings of ours in one event; how far one goes is `growth`, from the reference


@dataclass(frozen=True)
class Mark:
    """An event of the reference: phase as two doubles (rad), speed (m/s), our bound (turns)."""

    turn: int
    theta: float
    rest: float  # theta - its double
    u: float
    bound: float
    optional: bool = False

    @property
    def at(self) -> float:
        """Turns since the start, in a double."""
        return self.turn + self.theta / (2.0 * pi)

    def late(self, turn: int, theta: float) -> float:
        """Turns by which another phase comes after this one."""
        return (turn - self.turn) + ((theta - self.theta) - self.rest) / (2.0 * pi)


@dataclass(frozen=True)
class Case:
    """A motion of whole turns from theta = 0 with its reference."""

    name: str
    data: dict[str, Any]

    @property
    def title(self) -> str:
        """What it is, in words."""
        return self.data["title"]

    @property
    def rpm(self) -> float:
        """Speed of the cam."""
        return self.data["rpm"]

    @property
    def turns(self) -> int:
        """Whole turns of the run."""
        return self.data["turns"]

    @property
    def start(self) -> tuple[float | None, float | None]:
        """(q, v) at theta = 0; None for rest on the cam."""
        return self.data["start"]["q"], self.data["start"]["v"]

    @cached_property
    def follower(self) -> Follower:
        """Constants of the follower."""
        return Follower(**self.data["follower"])

    @cached_property
    def lift(self):
        """The cam in closed form, for the peers."""
        return lift_of(self.data["cam"])

    def system(self, bench: Bench) -> System:
        """The machine for our own kernel."""
        return System(self.follower, bench.cam(self.data["cam"]))

    @cached_property
    def _events(self) -> list[tuple[str, Mark]]:
        ends = [
            e["turn"] + float(e["theta"]) / (2.0 * pi)
            for e in self.data["events"]
            if e["kind"] == "chatter"
        ]
        found = []
        for e in self.data["events"]:
            exact = Decimal(e["theta"])
            theta = float(exact)
            at = e["turn"] + theta / (2.0 * pi)
            near = any(0.0 <= end - at < OPTIONAL for end in ends)
            rest = float(exact - Decimal(theta))
            mark = Mark(e["turn"], theta, rest, float(e["u"]), bound(e["growth"]), near)
            found.append((e["kind"], mark))
        return found

    @cached_property
    def hits(self) -> list[Mark]:
        """Impacts of the reference."""
        return [mark for kind, mark in self._events if kind == "impact"]

    @cached_property
    def rests(self) -> list[Mark]:
        """Accumulations of the reference."""
        return [mark for kind, mark in self._events if kind == "chatter"]

    @cached_property
    def omega(self) -> float:
        """Speed of the cam, rad/s."""
        return omega_of(self.rpm)

    @property
    def final_bound(self) -> float:
        """What is promised of the state at the end."""
        return bound(self.data["final"]["growth"])


def bound(growth: float) -> float:
    """What is promised of ours: a few roundings in every event, as far as the motion takes them."""
    return ALLOWANCE * ROUNDING * growth


def case(name: str) -> Case:
    """A stored case."""
    return Case(name, reference(name))
