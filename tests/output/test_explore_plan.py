"""How long the page of a scene is taken to be: what basins and a map add to it, by hand."""

from types import SimpleNamespace as Made

import numpy as np
import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.sweep import Speed, Sweep
from camcli.api.explore import page_bytes
from camcli.api.explore_motions import rows_of_the_page
from camcli.api.machine import machine_of
from camcli.errors import Status

AXES = [{"key": "rpm", "start": 690.0, "stop": 700.0, "num": 3},
        {"key": "follower.preload", "start": 0.0, "stop": 5.0, "num": 40}]  # fmt: skip


def length(impacts=2, speeds=4, **asked):
    """The bytes foreseen from two speeds of P(1;1), each with so many impacts, of so many."""
    rpm = {"start": 690.0, "stop": 700.0, "num": speeds}
    values = {"sweep.rpm": rpm, "basins.cells": [30, 20], **asked}
    machine = machine_of(camcli.load_scene(None, values, command="explore"))
    turns = np.arange(impacts)
    ones = np.ones(impacts)
    found = [
        Speed(x, x, Label((1.0,)), 0, Status.OK, (turns, ones, ones, ones),
              (turns, ones, ones, ones, ones), Cost())
        for x in (692.0, 698.0)
    ]  # fmt: skip
    of_map = [Made(label=label) for label in (Label((1.0,)), Label((1.0,) * 3), "aperiodic")]
    parts = {f"sweep {way}": Made(values=[Sweep(found, way, Cost())]) for way in
             ("fixed", "up", "down")}  # fmt: skip
    sampled = {**parts, "map": Made(values=[Made(speeds=of_map)])}
    return page_bytes(machine, sampled), rows_of_the_page(machine)


def test_basins_and_a_map_add_their_motions_and_cells():
    """Of basins 16 x 16 motions of at most 8 turns, and the cells, four bytes for three.

    Of a map at most 16 motions along each side; their periods are those of its samples, chaos is
    shown for 8 turns.
    """
    alone, rows = length()
    turn = 17.4 * rows + 12.0 * 3.0  # bytes: rows, and three events
    with_basins, _ = length(**{"explore.basins": True})
    assert with_basins - alone == pytest.approx(8 * 256 * turn + 4 / 3 * 600)
    with_map, _ = length(**{"explore.map": True, "sweep.vary": AXES})
    assert with_map - alone == pytest.approx((1 + 3 + 8) / 3 * 3 * 16 * turn, rel=1e-6)


def test_motions_are_counted_for_all_speeds_and_a_quarter_more_for_solved_orbits():
    """Two speeds stand for four, in three sweeps that find the same: two motions, of a turn each.

    Each takes 250 bytes, its rows and events, and 10.7 for each point of the diagram.
    """
    two, rows = length(speeds=2)
    four, _ = length(speeds=4)
    motion = 250.0 + 17.4 * rows + 12.0 * 3.0 + 10.7 * 2 * 1
    assert four - two == pytest.approx(1.25 * (2.0 - 1.0) * 2 * motion, rel=1e-6)
