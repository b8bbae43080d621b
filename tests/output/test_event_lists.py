"""Lists of events beside a picture, and the line of a change without its story."""

import pytest

from camcli.analysis.explain.changes import CriticalEvent, LabelChange
from camcli.plots.critical_speeds import event_lists, numbered
from camcli.words.explanations import change_line, unnumbered

LONG_LABEL = "P(9;" + ":".join("1" * 9) + ")"


def events(count, kind="fold", label="P(1;1)"):
    return [
        CriticalEvent(700.0 + k, 1e-9, kind, label, classification="a-b-c") for k in range(count)
    ]


@pytest.mark.parametrize(
    ("count", "columns", "lengths"), [(0, 0, []), (20, 5, [20]), (21, 4, [11, 10])]
)
def test_more_than_twenty_events_stand_in_two_lists(count, columns, lengths):
    """Beside one another; then motion and class share a column of 24 letters."""
    lists = event_lists([(k + 1, one) for k, one in enumerate(events(count, label=LONG_LABEL))])
    assert [len(rows) - 1 for rows in lists] == lengths
    rows = [row for part in lists for row in part[1:]]
    assert [row[0] for row in rows] == [str(k + 1) for k in range(count)]
    for part in lists:
        assert part[0][:4] == ["", "event", "rpm", "motion"]
        assert {len(row) for row in part} == {columns}
    for row in rows:
        said = [LONG_LABEL, "a b c"] if columns == 5 else ["P(9;1:1:1:1:1…), a b c"]
        assert row[3:] == said


def test_events_without_a_number_are_counted_below_the_lists():
    first, second = events(2)
    lists = event_lists([(1, first), (None, second)])
    assert lists[1:] == [[[unnumbered(1)]]]
    assert event_lists([(None, second)]) == []


def test_the_first_44_events_have_numbers_and_minor_ones_the_last_of_them():
    """In ascending order; of more those that change no kind of attractor stay without one."""
    minor = [CriticalEvent(600.0 + k, 0.0, "corner-hit", "x") for k in range(3)]
    found = numbered([*events(43), *minor])
    assert [event.rpm for _, event in found] == sorted(event.rpm for _, event in found)
    assert [number for number, _ in found[:3]] == [1, None, None]
    assert [number for number, _ in found[3:]] == list(range(2, 45))


def test_a_change_in_one_line():
    found = (
        CriticalEvent(739.31978, 1e-5, "period-doubling", "P(1;1)"),
        CriticalEvent(739.5, 0.0, "fold", LONG_LABEL),
    )
    change = LabelChange(739.0, 740.0, "P(1;1)", "P(2;1:1)", "period-doubling", found)
    said = f"at 739.31978 rpm, P(1;1); at 739.5 rpm, {LONG_LABEL}"
    assert change_line(change, found, verbose=False) == f"739 to 740 rpm: period-doubling; {said}"
