"""The work that an analysis may do is counted: it ends where the count reaches the limit."""

from importlib import import_module
from types import SimpleNamespace as Made

import pytest
from flint import arb

import camcli
from camcli.analysis.chaos import study
from camcli.analysis.chaos.section import Chaos
from camcli.analysis.integrate import (
    Budget,
    BudgetSpentError,
    Cost,
    budgeted,
    follow_on,
    run_all,
    spend,
)
from camcli.analysis.orbits import codim2, curve_proofs, proofs
from camcli.analysis.sweep import status_name
from camcli.api import explanation
from camcli.cams.balls import UndecidedError
from camcli.errors import Status
from camcli.exact.shooting import NotProvedError, ProofStep, box_of


@pytest.mark.parametrize(
    ("works", "done"), [([4, 6], 10), ([9, 0, 1], 10), ([9, 7], 16), ([10], 10)]
)
def test_a_budget_ends_when_its_limit_is_reached(works, done):
    """Not before: and what is shown is never more than the limit."""
    ticks = []
    budget = Budget(10, lambda *shown: ticks.append(shown))
    *before, last = works
    for work in before:
        budget.spend(work)
        assert budget.status == Status.OK
    with pytest.raises(BudgetSpentError):
        budget.spend(last)
    assert (budget.done, budget.status) == (done, Status.WORK_BUDGET)
    total = 0
    for work, shown in zip(works, ticks, strict=True):
        total += work
        assert shown == (min(total, 10), 10)
    with pytest.raises(BudgetSpentError):  # what asks whether there is any left
        budget.spend(0)


def test_work_counts_for_the_block_that_it_is_in():
    spend(10**9)  # nobody counts
    with budgeted(10, lambda *shown: None) as outer:
        spend(3)
        with budgeted(100, lambda *shown: None) as inner:
            spend(50)
        spend(4)
        assert (outer.done, inner.done) == (7, 50)
        with pytest.raises(BudgetSpentError):
            spend(3)
    spend(10**9)


@pytest.mark.parametrize(
    "follow", [lambda: run_all([None]), lambda: run_all([]), lambda: follow_on(None, [5])]
)
def test_nothing_is_followed_where_no_work_is_left(follow):
    with budgeted(1, lambda *shown: None):
        with pytest.raises(BudgetSpentError):
            spend(1)
        with pytest.raises(BudgetSpentError):
            follow()


def test_a_proof_that_runs_out_of_work_says_so(monkeypatch):
    """Of an orbit, a point, a part of a curve and chaos: not that a step of it has failed."""
    said = ProofStep.WORK_BUDGET
    orbit = Made(root=Made(), theta=(1.0, 2.0), rpm=700.0, parameter="rpm")

    def spent(*asked, **more):
        spend(10**9)

    with budgeted(10, lambda *shown: None):
        with pytest.raises(NotProvedError) as refusal:
            proofs._spend(1)
        assert refusal.value.step == said
        point = Made(solution=(Made(in_doubles=False, n=2), None), conditions=[])
        assert codim2.prove(point).step == said
        monkeypatch.setattr(curve_proofs, "_part", spent)
        curve = Made(points=[Made(first=float(k), second=0.0) for k in range(3)])
        (part,) = curve_proofs.prove_curve(None, curve, 1, None)
        assert (part.failed_step, part.evidence) == (said, None)
        monkeypatch.setattr(study, "ImpactMap", spent)
        assert study.chaos_at(None, None, [orbit], 700.0, True) == (Chaos(700.0, step=said), None)


@pytest.mark.parametrize("error", [UndecidedError, ZeroDivisionError, ValueError])
def test_what_balls_do_not_decide_is_a_step_of_a_proof_that_failed(error, monkeypatch):
    """A matrix without an inverse, a root of what may be negative, a place of two stretches."""

    def undecided(*asked, **more):
        raise error

    monkeypatch.setattr(curve_proofs, "OnCurve", undecided)
    root = Made(whole=(1, 0))
    points = [Made(orbit=Made(root=root), first=float(k), second=0.0) for k in range(2)]
    (part,) = curve_proofs.prove_curve(None, Made(points=points, located=Made()), 1, None)
    assert part.failed_step == ProofStep.SINGULAR
    with pytest.raises(NotProvedError) as refusal:
        box_of(undecided, [arb(1), arb(2)], 0)
    assert refusal.value.step == ProofStep.SINGULAR

    def points():
        yield "first"
        raise error

    assert codim2._solvable(points) == ["first"]


@pytest.mark.parametrize("status", [Status.OK, Status.WORK_BUDGET])
@pytest.mark.parametrize("command", ["sweep", "classify"])
def test_a_result_is_not_complete_where_its_explanation_was_cut_short(monkeypatch, command, status):
    """Though every speed has its row: the note says why, and the status is that of the run."""
    cut = Made(status=status, cost=Cost(impacts=3), events=[])
    analysis = import_module(f"camcli.api.{command}")
    for module in (analysis, explanation):
        monkeypatch.setattr(module, "explanation_of", lambda *_: cut, raising=False)
        monkeypatch.setattr(module, "explained", lambda *_: {}, raising=False)
        monkeypatch.setattr(module, "corners_table", lambda *_: {}, raising=False)
    monkeypatch.setattr(analysis, "_summary", lambda *_: {})
    few = {f"{command}.rpm": {"start": 700.0, "stop": 701.0, "num": 2}, f"{command}.explain": True,
           "run.transient": 400, "run.record": 40}  # fmt: skip
    result = getattr(camcli, command)(camcli.load_scene(None, few))
    assert result.complete is (status == Status.OK)
    assert (any("budget" in note for note in result.notes)) is (status != Status.OK)
    assert result.summary["status"] == status_name(status)
    assert result.cost.impacts > 3


@pytest.mark.parametrize(
    ("status", "curves", "told"),
    [(Status.OK, 0, True), (Status.OK, 2, True), (Status.WORK_BUDGET, 2, True),
     (Status.WORK_BUDGET, 0, False)],
)  # fmt: skip
def test_that_there_are_no_curves_is_said_where_the_search_came_to_its_end(
    monkeypatch, status, curves, told
):
    sweep = import_module("camcli.api.sweep")
    line = Made(_replace=lambda proved: proved)
    found = Made(ranges=None, points=[], curves=[Made(points=[1, 2], line=line)] * curves)
    monkeypatch.setattr("camcli.api.atlas.atlas_of", lambda *_: (found, status))
    monkeypatch.setattr(sweep, "proved_parts", lambda *_: "proved")
    monkeypatch.setattr(sweep, "atlas_words", lambda *_: ["the words"])
    monkeypatch.setattr(sweep, "curve_table", lambda *_, **__: "curves")
    monkeypatch.setattr(sweep, "codim2_table", lambda *_: "points")
    machine = Made(scene=Made(sweep=Made(vary=(), prove_turns=1)), system=Made(shape=None))
    auto = sweep._auto_curves(machine, Made(names=("a", "b")), ("rpm", "mass"), None)
    assert auto.summary == {"words": ["the words"] if told else []}
    assert (auto.status, auto.certificate, len(auto.lines)) == (status, None, curves)
    assert auto.tables == {"curves": "curves", "codim2": "points"}
