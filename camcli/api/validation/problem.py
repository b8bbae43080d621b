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


def register_in(problems: list[Problem], scene: str, source: str, quick: bool = False) -> Callable:
    """A decorator that makes a problem of the function below it and adds it to a list.

    scene, source, quick: of the problem; its claims are what the function yields.
    """

    def register(claims: Callable[[Problem], Iterator[Claim]]) -> Callable:
        """Add the problem with these claims."""
        problems.append(Problem(scene, source, claims, quick))
        return claims

    return register


def folder() -> Path:
    """Where the scenes are: configs/validation of the package (wheel) or beside it (checkout)."""
    return default_scene_path().parent / "validation"


# --- questions


def one_impact_in(turns: int) -> str:
    """The label of an orbit with one impact in so many turns: P(3;1:0:0)."""
    counts = ["1"] + ["0"] * (turns - 1)
    return f"P({turns};{':'.join(counts)})"


def rows_of(table: Any) -> list[dict[str, Any]]:
    """The rows of a table, by column."""
    return [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]


def found_orbits(scene: Scene, label: str | None = None) -> list[dict[str, Any]]:
    """The orbits that `cam orbits` finds at one speed: rows of branch.csv.

    label: only those of this one.
    """
    from camcli.api.orbits import orbits

    rows = rows_of(orbits(scene).tables["branch"])
    return [row for row in rows if label is None or row["label"] == label]


def bifurcations(scene: Scene) -> list[dict[str, Any]]:
    """The events of the branches that `cam orbits` follows, a row each."""
    from camcli.api.orbits import orbits

    return rows_of(orbits(scene).tables["bifurcations"])


def event(rows: list[dict[str, Any]], kind: str, label: str, corner: str = "") -> dict[str, Any]:
    """The event of this kind, label of the orbit, and corner.

    Branches that meet at an event have a row of it each: the first one counts.
    """
    asked_for = (kind, label, corner)
    return next(row for row in rows if (row["kind"], row["label"], row["corner"]) == asked_for)


def steady(cam: Any, theta: float) -> tuple[float, float]:
    """(p, p') of the oscillator's motion without its stop, at this phase of the force.

    The steady solution of m x'' + c x' + k x = a cos(w t), w t = theta.
    """
    spring = cam.stiffness - cam.mass * cam.frequency**2
    damper = cam.follower_damping * cam.frequency
    compliance = cam.amplitude / (spring**2 + damper**2)
    in_phase = spring * compliance
    out_of_phase = damper * compliance
    return (
        in_phase * cos(theta) + out_of_phase * sin(theta),
        cam.frequency * (out_of_phase * cos(theta) - in_phase * sin(theta)),
    )


def vary(key: str, low: float, high: float) -> Overrides:
    """Overrides that make `cam orbits` follow its orbits in this key."""
    return {"orbits.vary": [{"key": key, "start": low, "stop": high, "num": 5}]}
