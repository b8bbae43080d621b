"""Work that has a limit stops at it and not before, and an impact at the strobe is counted once."""

from __future__ import annotations

from math import ceil, log

import numpy as np
import pytest

import camcli
from camcli.analysis.basins import region
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.explain import changes
from camcli.analysis.orbits import proofs
from camcli.api import explore_motions
from tests.truth.test_columns import BISTABLE, scene_at


def test_the_diagram_of_a_page_has_the_last_points_of_every_speed(monkeypatch):
    """At most MOST_POINTS in all: as many of each speed, of a period no more than one."""
    values = {"sweep.rpm": {"start": 680.0, "stop": 700.0, "num": 2}, "run.transient": 100,
              "run.record": 130, "orbits.starts": 0}  # fmt: skip
    scene = camcli.load_scene(None, {**values, "run.patience": 0})
    whole = camcli.explore(scene).values.motions
    monkeypatch.setattr(explore_motions, "MOST_POINTS", 2 * 7 + 1)
    few = camcli.explore(scene).values.motions
    assert [one.label for one in few] == [one.label for one in whole]
    seen = set()
    for one, other in zip(few, whole, strict=True):
        if one.origin in ("solved", "stop"):
            continue
        most = 1 if one.label == "P(1;1)" else 7
        seen.add(one.label)
        for short, long in ((one.impacts, other.impacts), (one.strobes, other.strobes)):
            for a, b in zip(short, long, strict=True):
                assert a.tolist() == b[-most:].tolist()
                assert len(a) == most
                assert len(b) > 100 or most == 1
    assert seen == {"P(1;1)", "aperiodic"}


EXPLAINED = {"run.transient": 200, "run.record": 130}


def explained(low: float, high: float, num: int = 2) -> dict:
    """What `classify --explain` tells of a range."""
    rpm = {"start": low, "stop": high, "num": num}
    scene = camcli.load_scene(None, {**EXPLAINED, "classify.rpm": rpm, "classify.explain": True})
    return camcli.classify(scene).summary


@pytest.mark.parametrize(
    ("name", "most", "kinds"),
    [
        ("MOST_LEAVING", 1, ["period-doubling", "corner-impact"]),
        ("MOST_LEAVING", 0, ["period-doubling"]),
        ("MOST_SEEDS", 1, ["period-doubling", "corner-impact"]),
        ("MOST_SEEDS", 0, []),
    ],
)
def test_so_many_branches_are_followed_for_an_explanation(monkeypatch, name, most, kinds):
    """One through P(1;1), and one that leaves it where it doubles and ends at a corner."""
    monkeypatch.setattr(changes, name, most)
    found = explained(735.0, 739.6)
    assert [event["kind"] for event in found["events"]] == kinds


@pytest.mark.parametrize("most", [0, 1])
def test_so_many_changes_are_searched_for_a_crisis(monkeypatch, most):
    searched = []

    def find(_, __, near, far):
        searched.append((near, far))
        raise ZeroDivisionError

    monkeypatch.setattr(changes, "MOST_CRISES", most)
    monkeypatch.setattr(changes, "find_crisis", find)
    (change,) = explained(740.4, 740.65)["changes"]
    assert searched == [(740.4, 740.65)][:most] or searched == [(740.65, 740.4)][:most]
    assert change["cause"] == "unexplained"


@pytest.mark.parametrize(("most", "yes"), [(1, True), (0, False)])
def test_an_orbit_of_so_many_impacts_is_proved(monkeypatch, most, yes):
    monkeypatch.setattr(proofs, "MOST_PROVED", most)
    rpm = {"start": 700.0, "stop": 700.0, "num": 1}
    scene = camcli.load_scene(None, {"orbits.rpm": rpm, "orbits.starts": 0})
    branch = camcli.orbits(scene, prove=True).tables["branch"]
    one = branch["label"] == "P(1;1)"
    assert one.any()
    assert (branch["proved"][one] == "yes").all() == yes


@pytest.mark.parametrize("most", [region.MOST_RETURN, 6])
def test_rings_of_starts_are_followed_until_they_should_be_home(monkeypatch, most):
    """Over as many periods as shrink the ellipse to the size of home, or as the limit allows."""
    monkeypatch.setattr(region, "MOST_RETURN", most)
    asked = {"rpm": {"start": BISTABLE, "stop": BISTABLE, "num": 1}, "q": [-0.002, 0.028],
             "v": [-9.0, 9.0], "cells": [5, 5]}  # fmt: skip
    turns: list[int] = []
    real = CellBatches.run

    def run(self, gap, rate, targets, budget, *more, **options):
        turns.append(budget)
        return real(self, gap, rate, targets, budget, *more, **options)

    monkeypatch.setattr(CellBatches, "run", run)
    scene = scene_at(BISTABLE, run={"transient": 100, "record": 40}, basins=asked)
    (speed,) = camcli.basins(camcli.load_scene(scene)).summary["speeds"]
    wanted = set()
    for one in speed["attractors"]:
        m, shrink = one["turns"], one["form_shrinks_by"]
        periods = ceil(log(region.HOME) / log(shrink))
        wanted.add(m * min(periods, ceil(most / m)))
        assert one["ring_of_starts_returns"]
    assert len(wanted) == (1 if most == 6 else 2)
    assert wanted <= set(turns)


# -- ties --------------------------------------------------------------------------------------


def test_an_impact_at_the_strobe_is_counted_in_one_turn():
    """P(1;1) strobed where it lands, and a rounding behind: every command says so."""
    rpm = 700.0
    orbit = camcli.simulate(camcli.load_scene(None, {"run.rpm": rpm, "run.transient": 1000}))
    phase = float(orbit.tables["events"]["theta_deg"][-1])
    for at in (phase, np.nextafter(phase, 360.0)):
        range_ = {"start": rpm, "stop": rpm, "num": 1}
        scene = camcli.load_scene(None, {
            "run.rpm": rpm, "run.strobe_deg": float(at), "run.transient": 400, "run.record": 40,
            "sweep.rpm": range_, "classify.rpm": range_, "orbits.rpm": range_, "orbits.starts": 1,
        })  # fmt: skip
        events = camcli.simulate(scene).tables["events"]
        assert np.bincount(events["period"].astype(int)).sum() == events.rows
        swept = camcli.sweep(scene)
        assert swept.tables["speeds"]["label"].tolist() == ["P(1;1)"]
        assert swept.tables["strobe"]["impacts"].sum() == len(swept.tables["impacts"]["rpm"])
        assert abs(swept.tables["strobe"]["impacts"].sum() - 40) <= 1
        (label,) = camcli.classify(scene).tables["classify"]["label"].tolist()
        assert label in ("P(1;1)", "undecided")  # where rounding puts it into either turn
        assert "P(1;1)" in camcli.orbits(scene).tables["branch"]["label"].tolist()
