"""A published problem, the register of all, and the questions that their functions ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path
from typing import Any

from camcli.analysis.bench.validation import Claim
from camcli.scene import Scene, load_scene
from camcli.scene.load import default_scene_path

RPM = 30.0 / pi  # of 1 rad/s
# Our own relative error of a solved orbit or of an impact after a few flights: some 50 roundings.
# The tests hold every number here to its independent value by this.
SOLVED = 1e-14

Overrides = dict[str, Any]


@dataclass(frozen=True)
class Problem:
    """A published problem.

    scene: name of its file in configs/validation; source: author, journal, year; claims: yields its
    numbers, given the problem; quick: part of the subset of --quick.
    """

    scene: str
    source: str
    claims: Callable[[Problem], Iterator[Claim]]
    quick: bool

    def loaded(self, overrides: Overrides | None = None) -> Scene:
        """Its scene, with some keys changed."""
        return load_scene(folder() / f"{self.scene}.yaml", overrides or {})


def problem(into: list[Problem], scene: str, source: str, quick: bool = False) -> Callable:
    """Enter the function of a problem into the list of its module."""

    def enter(claims: Callable[[Problem], Iterator[Claim]]) -> Callable:
        into.append(Problem(scene, source, claims, quick))
        return claims

    return enter


def folder() -> Path:
    """Where the scenes are: configs/validation of the package (wheel) or beside it (checkout)."""
    return default_scene_path().parent / "validation"


# --- questions


def rows_of(table: Any) -> list[dict[str, Any]]:
    """The rows of a table, by column."""
    return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def found_orbits(scene: Scene, label: str | None = None) -> list[dict[str, Any]]:
    """The orbits that `cam orbits` finds at one speed, of this label: rows of branch.csv."""
    from camcli.api.orbits import orbits

    return [row for row in rows_of(orbits(scene).tables["branch"]) if label in (None, row["label"])]


def bifurcations(scene: Scene) -> list[dict[str, Any]]:
    """The events of the branches that `cam orbits` follows, a row each."""
    from camcli.api.orbits import orbits

    return rows_of(orbits(scene).tables["bifurcations"])


def event(rows: list[dict[str, Any]], kind: str, label: str, corner: str = "") -> dict[str, Any]:
    """The event of this kind, orbit and corner; branches that meet there each tell it."""
    return next(
        row for row in rows if (row["kind"], row["label"], row["corner"]) == (kind, label, corner)
    )


def steady(cam: Any, theta: float) -> tuple[float, float]:
    """(p, p') of the oscillator's motion without its stop, at this phase of the force."""
    spring = cam.stiffness - cam.mass * cam.frequency**2
    damper = cam.follower_damping * cam.frequency
    share = cam.amplitude / (spring**2 + damper**2)
    along, across = spring * share, damper * share
    return (
        along * cos(theta) + across * sin(theta),
        cam.frequency * (across * cos(theta) - along * sin(theta)),
    )


def threshold(holds: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """(middle, half width) of the narrowest bracket about the value from which on `holds` is true.

    holds: false at low, true at high.
    """
    assert not holds(low)
    assert holds(high)
    while low < (middle := 0.5 * (low + high)) < high and high - low > 1e-14 * abs(middle):
        low, high = (low, middle) if holds(middle) else (middle, high)
    return 0.5 * (low + high), 0.5 * (high - low)


def crossing(f: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """(zero of a function, how far off it may be), by secants that keep their bracket.

    The error is what the last value of f means by its slope, and some roundings of f.
    """
    at_low, at_high = f(low), f(high)
    slope = (at_high - at_low) / (high - low)
    for _ in range(20):
        middle = high - at_high * (high - low) / (at_high - at_low)
        value = f(middle)
        if value * at_high < 0.0:
            low, at_low = high, at_high
        else:
            at_low *= 0.5  # Illinois: the other end must move too
        high, at_high = middle, value
        if abs(value) < SOLVED or high == low:
            break
    return high, (abs(at_high) + 10.0 * SOLVED) / abs(slope)
