"""The statement of a proof.json about chaos; the guide says what it means (`proofs`)."""

from typing import Any

from flint import arb

from camcli.analysis.chaos.section import Chaos, SectionBox
from camcli.analysis.orbits.certificate import CONSTANTS
from camcli.cams.decimals import exact, exactly
from camcli.system import Follower


def statement(chaos: Chaos, follower: Follower, low: arb, high: arb) -> dict[str, Any]:
    """The statement of proved chaos for every speed (rpm) from low to high, both exact."""
    known = vars(follower)
    constants = {key: None if key == "rpm" else exact(known[key]) for key in CONSTANTS}
    return {
        "kind": "chaos",
        "parameter": "rpm",
        "constants": constants,
        "low": exactly(low),
        "high": exactly(high),
        "growth": repr(chaos.growth),
        "weights": [str(weight) for weight in chaos.weights],
        "coverings": [list(pair) for pair in chaos.coverings],
        "boxes": [
            _box(box, flights) for box, flights in zip(chaos.boxes, chaos.flights, strict=True)
        ],
    }


def _box(box: SectionBox, flights: tuple[dict[str, Any], ...]) -> dict[str, Any]:
    """A box as the certificate has it; its numbers are texts that mean them exactly.

    middle: phase (rad) and rate (m/rad); axes: the matrix M, row after row; lands: where an impact
    of the box lands next; cells: how many parts the box has along each axis; flights: one record
    for each cell.
    """
    return {
        "stretch": box.stretch,
        "middle": [exact(x) for x in box.middle],
        "axes": [exact(x) for row in box.axes for x in row],
        "lands": {"stretch": box.lands.stretch, "turn": box.lands.turn},
        "cells": list(box.cells),
        "flights": list(flights),
    }
