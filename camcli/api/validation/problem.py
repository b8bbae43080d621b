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


def vary(key: str, low: float, high: float) -> Overrides:
    """Overrides that make `cam orbits` follow its orbits in this key."""
    return {"orbits.vary": [{"key": key, "start": low, "stop": high, "num": 5}]}
