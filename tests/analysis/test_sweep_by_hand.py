"""The order of a sweep's work and of its rows, with motions that are written down here.

Each motion has a label by its value and its start, and costs 1, 10 and 100; one that is watched
costs twice as much.
"""

from __future__ import annotations

from array import array
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import pytest
from conftest import settings

from camcli.analysis import sweep as module
from camcli.analysis.integrate import Cost, Start
from camcli.analysis.loads import Loads
from camcli.analysis.speeds import Speed
from camcli.analysis.sweep import _between, _ranges_of_chaos, _SweepRows, _unwatched, sweep
from camcli.errors import Status
from camcli.parallel.rows import Rows

A, C = module.APERIODIC_LOOK, module.CHAOS_LOOK
HIGH, LOW = Start(0.5, 1.0), Start(0.25, -1.0)


def speed(value, label="P(1;1)", times=1, end=None, **more) -> Speed:
    cost = Cost(times, 10 * times, 100 * times)
    return Speed(value, value, label, 1, Status.OK, None, None, cost, end=end, **more)


class HandWork:
    """Work done at once; asked: (value, start, whether it is watched) of each piece in order."""

    rows = Rows

    def __init__(self, label):
        self.label = label
        self.asked, self.tasks = [], []

    def _made(self, task, value, start):
        if not self.tasks or self.tasks[-1] is not task:
            self.tasks.append(task)
        self.asked.append((value, start, task.patient))
        times = 2 if task.patient else 1
        return speed(value, self.label(value, start, task.patient), times, Start(value))

    def collect(self, task, pieces, codec, tell):
        watched = isinstance(task, module._WatchedFrom)
        inner = task.task if watched else task
        found = [self._made(inner, *(one if watched else (one, inner.start))) for one in pieces]
        for one in found:
            tell(one)
        return found

    def collect_chain(self, after, first, pieces, codec, tell):
        found, start = [], after.__self__.start if first is None else first
        for value in pieces:
            found.append(self._made(after.__self__, value, start))
            tell(found[-1])
            start = found[-1].end
        return found


@pytest.fixture
def refused(monkeypatch):
    """What was asked before any work: the first value, and each start."""
    asked = []
    monkeypatch.setattr(module, "refuse_below", lambda setup, at, start: asked.append((at, start)))
    return asked


def swept(work, values, patience=0, **more):
    told = []
    run = replace(settings(7, 3), patience=patience)
    found = sweep("machine", values, run, work=work, on_speed=told.append, **more)
    return found, [one.value for one in told]


@pytest.mark.parametrize("also", [(), (HIGH,)])
@pytest.mark.parametrize(
    ("direction", "orders"),
    [
        ("fixed", {"": [5.0, 2.0, 9.0]}),
        ("up", {"": [2.0, 5.0, 9.0]}),
        ("down", {"": [9.0, 5.0, 2.0]}),
        ("both", {"up": [2.0, 5.0, 9.0], "down": [9.0, 5.0, 2.0]}),
    ],
)
def test_the_order_of_a_sweep(refused, direction, orders, also):
    """A state that is carried goes from each value to the next; else all have the same start."""
    work = HandWork(lambda *_: "P(1;1)")
    found, told = swept(work, [5.0, 2.0, 9.0], direction=direction, also=also)
    wanted, ways, asked = [], [], []
    for number, start in enumerate([None, *also]):
        for way, values in orders.items():
            before = [start, *map(Start, values)] if direction != "fixed" else [start] * 4
            asked += [(value, one, False) for value, one in zip(values, before, strict=False)]
            wanted += values
            ways += [(*([way] if way else []), *([number] if also else []))] * 3
    assert work.asked == asked
    assert told == list(found.values) == [one.value for one in found.speeds] == wanted
    assert list(found.ways) == ways
    assert found.way_names == (*["direction"] * (direction == "both"), *["start"] * len(also))
    assert found.cost == (len(wanted), 10 * len(wanted), 100 * len(wanted))
    assert refused == [((5.0,), start) for start in (None, *also)]
    for task in work.tasks:
        assert (task.turns, task.turns_each) == (30, 10)
        assert task.keeps_ends == (direction != "fixed")


def test_a_sweep_of_nothing_asks_nothing(refused):
    found, told = swept(HandWork(None), [])
    assert (list(found.speeds), told, refused, found.cost) == ([], [], [], (0, 0, 0))


@pytest.mark.parametrize("changes", [0, 1, None])
def test_values_are_added_where_labels_differ_and_all_are_sorted_then(refused, changes):
    """From one start the motion changes at 50.3; from the other, or from both, it does not."""
    starts = (None, HIGH)

    def label(value, start, patient):
        beyond = changes is not None and start == starts[changes] and value > 50.3
        return "P(2;1:1)" if beyond else "P(1;1)"

    work = HandWork(label)
    found, told = swept(work, [100.0, 0.0], adaptive=True, also=(HIGH,))
    if changes is None:
        assert list(found.values) == [100.0, 0.0] * 2  # nothing was added: as they were asked for
        assert list(found.ways) == [(0,), (0,), (1,), (1,)]
        return
    values = list(found.values)
    assert values == sorted(values) == sorted(told)
    assert [way for value, way in zip(values, found.ways, strict=True) if value == 0.0] == [
        (0,), (1,),
    ]  # fmt: skip
    of_start = [one for one, way in zip(found.speeds, found.ways, strict=True) if way == (changes,)]
    (apart,) = [
        later.value - earlier.value
        for earlier, later in pairwise(of_start)
        if earlier.label != later.label
    ]
    assert 100.0 / 2400.0 < apart <= 100.0 / 1200.0
    assert len(values) == 4 + 11  # halvings of 100 until it is below a twelfth
    assert found.cost.impacts == len(values)


@pytest.mark.parametrize(
    ("direction", "steps"),
    [("fixed", [0.0]), ("up", [1.0]), ("down", [-1.0]), ("both", [1.0, -1.0])],
)
@pytest.mark.parametrize("patience", [0, 500])
def test_what_looks_aperiodic_is_watched_from_both_ends_of_its_range(
    refused, direction, steps, patience
):
    """At 2 to 8; those at 2 and 3 have settled in the end: from there on it is watched inwards."""

    def label(value, start, patient):
        chaos = 2.0 <= value <= 8.0 and not (patient and value <= 3.0)
        return "aperiodic" if chaos else "P(1;1)"

    work = HandWork(label)
    values = [float(k) for k in range(10)]
    found, told = swept(work, values, patience, direction=direction)
    watched = [2.0, 3.0, 7.0, 8.0, 4.0, 5.0] if patience else []
    asked, listed = [], []
    for step in steps:  # from each value to the next one
        listed += values[::-1] if step < 0.0 else values
        for value in (*listed[-10:], *watched):
            start = Start(value - step) if step and value != listed[-10] else None
            asked.append((value, start))
    assert [(value, start) for value, start, _ in work.asked] == asked
    assert [value for value, _, patient in work.asked if patient] == watched * len(steps)
    assert told == listed  # each is told of once
    assert list(found.values) == listed
    settled = (2.0, 3.0) if patience else ()
    labels = [label(value, None, value in settled) for value in listed]
    assert [one.label for one in found.speeds] == [one.label for one in found.bare] == labels
    costs = [2 if value in watched else 1 for value in listed]
    assert [one.cost.impacts for one in found.speeds] == costs
    # of both, where one takes another's place
    assert found.cost.impacts == len(listed) + 2 * len(watched) * len(steps)


@pytest.mark.parametrize(
    ("label", "holds_for", "look"),
    [
        ("P(1;1)", None, 0), ("P(1;inf)", "last-digit", C), ("undecided", None, C),
        ("aperiodic", None, A), ("aperiodic", "exact-data", A), ("contact", None, 0),
    ],
)  # fmt: skip
def test_what_a_motion_looks_like(label, holds_for, look):
    rows = _SweepRows(HandWork(None), None, patient=True)
    one = speed(3.0, label, holds_for=holds_for)
    rows._take(one._replace(impacts=([1, 2, 3], [], [], [])))
    rows._take(one._replace(strobe=(range(2), [], [], [], [])))
    assert list(rows.looks) == [look, look]
    assert {name: list(counts) for name, counts in rows.counts.items()} == {
        "impacts": [3, 0], "strobe": [0, 2],
    }  # fmt: skip


def rows_of(watched, at=None):
    count = len(watched)
    return SimpleNamespace(at=at or range(count), watched=bytearray(watched))


def test_a_row_that_was_watched_stays_in_its_range():
    """Ranked backwards: the rows stand in descending order of their values."""
    rows = rows_of([0, 0, 1, 0, 0, 0, 1], at=[7, 6, 5, 4, 3, 2, 1])
    looks = [9, 0, A, C, 0, A, 0, 0]  # by the numbers in `at`
    ranked = [6, 5, 4, 3, 2, 1, 0]
    assert _ranges_of_chaos(rows, looks, ranked) == [range(3), range(4, 5)]
    assert _ranges_of_chaos(rows_of([0, 0]), [0, 0], [0, 1]) == []


@pytest.mark.parametrize(
    ("looks", "watched", "chosen"),
    [
        ([A, A, A, A, A, A], [0] * 6, [0, 1, 5, 4]),
        ([A, A, A, A, A, A], [1, 1, 0, 0, 0, 1], [4]),  # two neighbours stayed so at the left end
        ([A, A, A, A, C, A], [0] * 6, [0, 1, 5, 3]),  # what rested by chance is no neighbour
        ([A, 0, A, A, A, A], [0, 1, 0, 0, 0, 0], [0, 2, 3, 5, 4]),  # what settled begins it anew
        ([A, A, A, A, 0, A], [0, 0, 0, 0, 1, 0], [0, 1, 5, 3, 2]),
        ([0, 0], [1, 1], []),
        ([A], [0], [0]),
    ],
)
def test_which_motions_of_a_range_are_watched_next(looks, watched, chosen):
    places = range(len(looks))
    assert _unwatched(rows_of(watched), looks, places, places) == chosen
    shifted = _unwatched(rows_of([0, *watched]), [A, *looks], range(9), range(1, len(looks) + 1))
    assert shifted == [row + 1 for row in chosen]


def test_which_middles_are_added():
    """Steps of one in 1200 and less are not halved, nor those beside a fault."""

    def middles(*labels, values=(6000.0, 6001.0, 6003.0, 7200.0), faults=()):
        speeds = [speed(value, label) for value, label in zip(values, labels, strict=True)]
        for k in faults:
            speeds[k] = speeds[k]._replace(status=Status.FAULT)
        return _between(speeds[::-1])

    assert middles("P(1;1)", "P(2;1:1)", "P(1;1)", "P(1;1)") == [6002.0]
    assert middles("P(1;1)", "P(2;1:1)", "P(1;1)", "contact") == [6002.0, 6601.5]
    assert middles("contact", "P(2;1:1)", "P(1;1)", "contact", faults=[2]) == []
    assert middles("contact", "P(2;1:1)", "P(1;1)", "contact", faults=[1]) == [6601.5]
    assert middles("contact", values=[7.0]) == middles(values=[]) == []


def test_chaos_that_changes_its_size_is_looked_at_more_closely():
    """By more than a tenth of the range of all, which need not begin at zero; None counts as 0."""

    def middles(loads, labels=("aperiodic",) * 4):
        rows = zip((10.0, 20.0, 30.0, 40.0), labels, loads, strict=True)
        return _between([speed(*row, loads=more) for *row, more in rows])

    gaps = [Loads(max_gap_m=50.0 + x) for x in (0.0, 0.09, 0.11, 1.0)]
    assert middles(gaps) == [35.0]
    hits = [Loads(1.0, 0.5, u) for u in (None, 2.0, 2.1, 4.0)]
    assert middles(hits) == [15.0, 35.0]
    both = [Loads(1.0, 0.5, 3.0), Loads(2.0, 0.5, 3.0), Loads(2.0, 0.5, 3.0), Loads(2.0, 0.5, 9.0)]
    assert middles(both) == [15.0, 35.0]
    assert middles(both, ["P(1;1)"] * 4) == []
    assert middles(both[::-1]) == [15.0, 35.0]  # a smaller motion differs, too
    assert middles(both, ["aperiodic", "P(1;1)", "P(1;1)", "P(1;1)"]) == [15.0]
    for beside in ("aperiodic", "P(1;1)"):  # a change of label is one at any size
        labels = (beside, *{"aperiodic", "P(1;1)"} - {beside}) * 2
        assert middles([Loads(1.0, 0.5, 3.0)] * 4, labels) == [15.0, 25.0, 35.0]


def test_speeds_of_several_parts_are_one_sequence_in_another_order():
    parts = [[speed(float(10 * n + k)) for k in range(count)] for n, count in enumerate((2, 1, 3))]
    joined = module._Joined(parts, array("q", [5, 0, 2, 1, 3, 4]))
    assert [one.value for one in joined] == [22.0, 0.0, 10.0, 1.0, 20.0, 21.0]
    assert [one.value for one in joined[1:4]] == [0.0, 10.0, 1.0]
    assert (joined[-1].value, len(joined)) == (21.0, 6)
