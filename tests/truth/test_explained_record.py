"""What run.json keeps of an explanation, of events and changes made by hand."""

from types import SimpleNamespace as Made

from camcli.analysis.explain.changes import BASIN, CriticalEvent, Explanation, LabelChange
from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.kinds import Kind
from camcli.api.explanation import corners_table, explained
from camcli.errors import Status

EVENT = CriticalEvent(
    rpm=700.25, error=0.125, kind=Kind.GRAZING, label="P(2;3)", corner="b",
    classification="persistence", status="unresolved", source=Made(beyond=Made(label="P(5;4)")),
)  # fmt: skip


def change(cause, events=(), status=Status.OK, persists=(), may_search=True):
    return LabelChange(
        low=699.5, high=701.75, before="P(2;3)", after="chaos", cause=cause, events=events,
        persists=persists, may_search=may_search, status=status,
    )  # fmt: skip


def test_each_event_and_each_change_has_its_numbers_and_its_sentence():
    changes = [change("grazing", (EVENT,)), change("unexplained", may_search=False), change(BASIN)]
    assert explained(Explanation([EVENT], changes, [], Cost(), Status.WORK_BUDGET)) == {
        "status": "work-budget",
        "events": [
            {
                "rpm": 700.25, "error": 0.125, "kind": "grazing", "label": "P(2;3)",
                "corner": "b", "classification": "persistence", "status": "unresolved",
                "words": "P(2;3) ends (grazing), and a run beyond it settles on P(5;4)",
            }
        ],
        "changes": [
            {
                "from_rpm": 699.5, "to_rpm": 701.75, "before": "P(2;3)", "after": "chaos",
                "cause": cause, "words": words,
            }
            for cause, words in (
                ("grazing", "P(2;3) ends (grazing), and a run beyond it settles on P(5;4)"),
                ("unexplained",
                 "no bifurcation of a solved branch lies between them, and no branch through both "
                 "is stable; crises are looked for in the first 3 changes only"),
                ("basin",
                 "the chaotic attractor lives on at both speeds: the start changes basins."),
            )
        ],
    }  # fmt: skip


def told(one):
    return explained(Explanation([], [one], [], Cost()))["changes"][0]["words"]


def test_what_was_not_found_is_told_with_what_attracts_beside():
    assert told(change("unexplained", persists=("P(1;1)",))) == (
        "P(1;1) attracts at both speeds; whether the chaos beside lives on at both is not known"
    )
    assert told(change("unexplained", persists=("P(1;1)", "P(3;2)"))) == (
        "P(1;1) and P(3;2) attract at both speeds; whether the chaos beside lives on at both is "
        "not known"
    )
    assert told(change("unexplained", status=Status.WORK_BUDGET)) == (
        "work-budget: the budget of work was used up, and the rest is left out"
    )


def test_corners_are_those_of_corner_impacts_alone():
    empty = corners_table(None)
    assert empty.rows == 0
    folds = [Made(kind=Kind.FOLD), Made(kind=Kind.GRAZING)]
    assert corners_table(Explanation([], [], folds, Cost())).rows == 0
