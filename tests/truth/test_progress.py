"""What a command tells of its progress: each piece once, and all of them where it has all."""

from __future__ import annotations

import pytest

import camcli

FEW = {"run.transient": 5, "run.record": 4, "run.patience": 0}


def upper(num: int) -> dict:
    return {"start": 690.0, "stop": 710.0, "num": num}


def axis(key: str, start: float, stop: float, num: int) -> dict:
    return {"key": key, "start": start, "stop": stop, "num": num}


AXES = [axis("rpm", 690.0, 710.0, 3), axis("follower.restitution", 0.7, 0.8, 4)]
CHANGING = {"classify.rpm": {"start": 735.0, "stop": 741.0, "num": 3}, "classify.explain": True,
            "run.transient": 200, "run.record": 100}  # fmt: skip
TOLD = [  # command, its scene, and of each kind of piece how many are done of how many
    (camcli.sweep, {"sweep.rpm": upper(5)}, {"speeds": (5, 5)}),
    (camcli.sweep, {"sweep.rpm": upper(3), "sweep.direction": "up"}, {"speeds": (3, 3)}),
    (camcli.sweep, {"sweep.vary": AXES}, {"lines": (4, 4)}),
    (camcli.classify, {"classify.rpm": upper(3)}, {"speeds": (3, 3)}),
    (camcli.classify, CHANGING, {"speeds": (3, 3), "changes": (1, 2)}),  # one changes its label
    (camcli.detach, {"detach.rpm": upper(3)}, {"speeds": (3, 3)}),
    (camcli.orbits, {"orbits.rpm": upper(3), "orbits.starts": 0, "orbits.branches": 1},
     {"branches": (2, 3)}),  # through both orbits; none leaves there
]  # fmt: skip


@pytest.mark.parametrize(("command", "values", "pieces"), TOLD)
def test_every_piece_is_told_once(command, values, pieces):
    told: dict[str, list[tuple[int, int]]] = {}
    scene = camcli.load_scene(None, {**FEW, **values})
    command(scene, progress=lambda what, *counts: told.setdefault(what, []).append(counts))
    assert told == {
        what: [(done, total) for done in range(1, most + 1)]
        for what, (most, total) in pieces.items()
    }


def test_cells_are_told_as_they_come():
    """Of two speeds with twelve cells each."""
    told = []
    scene = camcli.load_scene(None, {"basins.rpm": upper(2), "basins.cells": [3, 4]})
    camcli.basins(scene, progress=lambda *counts: told.append(counts))
    assert {(what, total) for what, _, total in told} == {("cells", 24)}
    done = [count for _, count, _ in told]
    assert done == sorted(done)
    assert {12, 24} <= set(done)
    assert done[-1] == 24
