"""Work that has a limit stops at it and not before, and an impact at the strobe is counted once."""

from __future__ import annotations

from math import ceil, log

import numpy as np
import pytest

import camcli
from camcli.analysis.basins import region
from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.basins.window import Window
from camcli.analysis.explain import changes
from camcli.analysis.explain.changes import Explanation, Limits
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.shooter import Shooter
from camcli.api.explore_motions import of_sweep
from camcli.api.machine import machine_of
from camcli.exact.shooting import NotProvedError, ProofStep
from camcli.kernel.cam_table import stretch_at
from camcli.piece_faults import gathering
from tests.conftest import chapter_system
from tests.truth.test_columns import BISTABLE, scene_at


def test_the_diagram_of_a_page_has_the_last_points_of_every_speed():
    """At most so many in all: as many of each speed, of a period no more than one."""
    values = {"sweep.rpm": {"start": 680.0, "stop": 700.0, "num": 2}, "run.transient": 100,
              "run.record": 130, "run.patience": 0}  # fmt: skip
    scene = camcli.load_scene(None, values, command="sweep")
    machine, result = machine_of(scene), camcli.sweep(scene)
    whole = list(of_sweep(machine, result, "fixed", 1000))
    few = list(of_sweep(machine, result, "fixed", 1000, most_points=2 * 7 + 1))
    assert [one.label for one in few] == [one.label for one in whole] == ["aperiodic", "P(1;1)"]
    for one, other in zip(few, whole, strict=True):
        most = 1 if one.label == "P(1;1)" else 7
        for short, long in ((one.impacts, other.impacts), (one.strobes, other.strobes)):
            for a, b in zip(short, long, strict=True):
                assert a.tolist() == b[-most:].tolist()
                assert len(a) == most
                assert len(b) > 100 or most == 1


EXPLAINED = {"run.transient": 200, "run.record": 130}


def explained(low: float, high: float, limits: Limits) -> Explanation:
    """What is found about the changes of a range of two speeds."""
    rpm = {"start": low, "stop": high, "num": 2}
    scene = camcli.load_scene(None, {**EXPLAINED, "classify.rpm": rpm})
    machine, (motions, _) = machine_of(scene), camcli.classify(scene).values
    with gathering():
        return changes.explain(machine.system, machine.settings, motions, limits=limits)


@pytest.mark.parametrize(
    ("limits", "kinds"),
    [
        (Limits(leaving=1), ["period-doubling", "corner-impact"]),
        (Limits(leaving=0), ["period-doubling"]),
        (Limits(seeds=1), ["period-doubling", "corner-impact"]),
        (Limits(seeds=0), []),
    ],
)
def test_so_many_branches_are_followed_for_an_explanation(limits, kinds):
    """One through P(1;1), and one that leaves it where it doubles and ends at a corner."""
    found = explained(735.0, 739.6, limits)
    assert [event.kind for event in found.events] == kinds


@pytest.mark.parametrize("most", [0, 1])
def test_so_many_changes_are_searched_for_a_crisis(monkeypatch, most):
    searched = []

    def find(_, __, near, far):
        searched.append((near, far))
        raise ZeroDivisionError

    monkeypatch.setattr(changes, "find_crisis", find)
    (change,) = explained(740.4, 740.65, Limits(crises=most)).changes
    assert searched == [(740.4, 740.65)][:most] or searched == [(740.65, 740.4)][:most]
    assert change.cause == "unexplained"


@pytest.mark.parametrize(("most", "yes"), [(1, True), (0, False)])
def test_an_orbit_of_so_many_impacts_is_proved(most, yes):
    system = chapter_system()
    places = (stretch_at(system.cam, 2.71), 0)
    root = Shooter(system, 700.0).at_value([2.7105, 0.85, 700.0], places, 1, 700.0)
    if yes:
        assert proofs.shooting_of(system, root, most).n == 1
    else:
        with pytest.raises(NotProvedError) as refused:
            proofs.shooting_of(system, root, most)
        assert refused.value.step == ProofStep.MODEL


@pytest.mark.parametrize("most", [region.MOST_RETURN, 6])
def test_rings_of_starts_are_followed_until_they_should_be_home(monkeypatch, most):
    """Over as many periods as shrink the ellipse to the size of home, or as the limit allows."""
    turns: list[int] = []
    real = CellBatches.run

    def run(self, gap, rate, targets, budget, *more, **options):
        turns.append(budget)
        return real(self, gap, rate, targets, budget, *more, **options)

    monkeypatch.setattr(CellBatches, "run", run)
    machine = machine_of(camcli.load_scene(scene_at(BISTABLE)))
    finder = AttractorFinder(CellBatches(machine.system, BISTABLE, machine.settings), 4000)
    finder.look_around(Window((-0.002, 0.028), (-9.0, 9.0), 5, 5))
    wanted = []
    for one in finder.regions:
        m = len(one.points)
        periods = ceil(log(region.HOME) / log(one.shrink))
        wanted.append(m * min(periods, ceil(most / m)))
        assert region._holds(finder.batches, one, most_turns=most)
        assert turns[-1] == wanted[-1]
    assert len(set(wanted)) == (1 if most == 6 else 2)


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
