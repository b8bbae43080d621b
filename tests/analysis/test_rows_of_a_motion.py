"""What is kept of a motion at one speed: its rows, its label, and the state at its end."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis import motion_at_speed
from camcli.analysis.exponents import Exponents
from camcli.analysis.integrate import Cost, Record, Start
from camcli.analysis.labels import APERIODIC, UNDECIDED, Label
from camcli.analysis.motion_at_speed import SpeedTask, _impact_rows, _over_and_over, _strobe_rows
from camcli.errors import Status
from camcli.kernel.orbit_loop import IMPACT

OTHER = IMPACT + 1
OMEGA = 50.0


def record_of(kinds, periods, turns: int, **more) -> Record:
    """A record whose log has these kinds and periods; each number tells its row."""
    n = np.arange(len(kinds), dtype=float)
    strobes = np.arange(turns + 1, dtype=float)
    counts = np.arange(turns + 1)
    columns = {
        "kind": np.array(kinds), "period": np.array(periods), "theta": pi / 180.0 * n,
        "q": 0.1 * n, "u": -0.2 * n, "strobe_q": 0.3 * strobes, "strobe_w": 0.4 * strobes,
        "impacts": counts, "chatter": 10 * counts, "periods": turns, "detachments": 0,
        "resting": False, "status": Status.OK, "cost": Cost(),
    }  # fmt: skip
    return Record(**(columns | more))


def test_the_impacts_of_a_record_are_those_of_its_whole_turns():
    """Other events are left out, and impacts before the first strobe (period -1)."""
    kinds = [IMPACT, IMPACT, OTHER, IMPACT, OTHER, IMPACT]
    record = record_of(kinds, [-1, 0, 0, 0, 1, 1], 2, hits=3)
    period, angle, q, v = _impact_rows(record, OMEGA)
    assert period.tolist() == [0, 0, 1]
    for found, size in ((angle, 1.0), (q, 0.1), (v, -0.2 * OMEGA)):
        assert found == pytest.approx([size * row for row in (1, 3, 5)])
    one_left = record_of([IMPACT, OTHER, IMPACT], [0, 0, 1], 2, hits=2)
    assert _impact_rows(one_left, OMEGA)[0].tolist() == [0, 1]
    only = record_of([IMPACT] * 3, [0, 0, 1], 2, hits=3)
    period, angle, q, v = _impact_rows(only, OMEGA)
    assert period.tolist() == [0, 0, 1]
    for found, size in ((angle, 1.0), (q, 0.1), (v, -0.2 * OMEGA)):
        assert found == pytest.approx([size * row for row in (0, 1, 2)])
    numbers, q, v, impacts, chatter = _strobe_rows(record, OMEGA)  # the last turn is not whole
    assert (numbers, impacts.tolist(), chatter.tolist()) == (range(2), [0, 1], [0, 10])
    assert q == pytest.approx([0.0, 0.3])
    assert v == pytest.approx([0.0, 0.4 * OMEGA])


def test_turns_over_and_over():
    """Of two turns, with two impacts and one, seven: three rounds and the first once more.

    The rows of a log behind its one turn do not count.
    """
    first = record_of([IMPACT, OTHER, IMPACT, IMPACT], [0, 0, 0, 1], 1, hits=2, chatters=1,
                      detachments=4, repeats=3, near=True, loads="loads")  # fmt: skip
    second = record_of([IMPACT], [0], 1, hits=1)
    second = second._replace(q=second.q + 9.0, strobe_q=second.strobe_q + 8.0)
    found = _over_and_over([first, second], 7)
    in_round = [0.0, 0.1, 0.2, 9.0]
    assert found.q == pytest.approx([*in_round * 3, *in_round[:3]])
    assert found.kind.tolist() == [IMPACT, OTHER, IMPACT, IMPACT] * 3 + [IMPACT, OTHER, IMPACT]
    assert found.period.tolist() == [
        turn for turn, rows in enumerate([3, 1] * 3 + [3]) for _ in range(rows)
    ]
    assert found.strobe_q == pytest.approx([0.0, 8.0] * 3 + [0.0])
    assert (found.hits, found.chatters, found.periods) == (3 * 3 + 2, 4, 7)
    assert (found.repeats, found.near, found.loads) == (0, False, None)
    assert found.detachments == 4  # of the turn that is the last
    assert _over_and_over([first, second], 4).detachments == 0


@pytest.mark.parametrize(
    ("resting", "detachments", "hits", "throughout"),
    [(True, 0, 0, True), (False, 0, 0, False), (True, 1, 0, False), (True, 0, 1, False)],
)
def test_a_follower_that_rests_throughout_neither_leaves_nor_lands(
    resting, detachments, hits, throughout
):
    record = record_of([], [], 3, resting=resting, detachments=detachments, hits=hits)
    assert record.rests_throughout is throughout


MOTION = Label((1.0,))
CHAOS = Exponents(largest=0.5, second=-1.0, spread=0.01, rule=-0.5, impacts=1.0)


def speed_of(monkeypatch, *, forgets=(), label=MOTION, status=Status.OK, followed=None, **task):
    """The speed of an orbit whose records tell what they are given to tell.

    forgets: which of its two records, the one that was made and the one it is named by, may be one
    of many; followed: the label of the true motion.
    """
    records = {"record": record_of([], [], 5, status=status, hits=3, cost=Cost(1, 0, 0)),
               "named by": record_of([], [], 7)}  # fmt: skip
    ended = Status.UNRESOLVED if followed == UNDECIDED else Status.OK
    truth = Stub(label=followed, exponents=CHAOS, cost=Cost(10, 0, 0), holds_for="holds",
                 watched=99, status=ended)  # fmt: skip
    names = {id(one): name for name, one in records.items()}
    for name, stand_in in {
        "forgets_too_much": lambda record: names[id(record)] in forgets,
        "named_on": lambda *_: (label, CHAOS, records["named by"]),
        "true_motion": lambda *_: (truth, record_of([], [], 6, hits=4), "true end"),
        "loads_of": lambda *_: "loads",
    }.items():
        monkeypatch.setattr(motion_at_speed, name, stand_in)
    given = dict.fromkeys(("impacts", "strobe"), False) | {
        "lyapunov": True, "turns": 1.0, "turns_each": 1.0,
    }  # fmt: skip
    one = Stub(orbit=Stub(omega=OMEGA, as_start=lambda: "end"), rpm=700.0, system="system",
               settings=Stub(transient=20), start=None)  # fmt: skip
    return SpeedTask("rpm", None, **(given | task))._measured(700.0, one, records["record"], None)


@pytest.mark.parametrize(
    ("case", "label", "known", "holds_for", "watched", "hits", "cost"),
    [
        ({}, MOTION, True, None, None, 3, 1),
        ({"label": APERIODIC}, APERIODIC, True, None, 25, 3, 1),
        ({"label": UNDECIDED}, UNDECIDED, True, None, None, 3, 1),
        ({"label": APERIODIC, "patient": True, "followed": MOTION}, MOTION, True, "holds", 99, 4,
         11),
        ({"patient": True, "followed": APERIODIC}, MOTION, True, None, None, 3, 1),
        ({"forgets": ["record"], "followed": APERIODIC}, APERIODIC, True, "holds", 99, 4, 11),
        ({"forgets": ["named by"], "followed": MOTION}, MOTION, True, "holds", 99, 4, 11),
        ({"forgets": ["record"], "followed": UNDECIDED}, UNDECIDED, False, "holds", 99, 4, 11),
        ({"forgets": ["record"], "follow": False}, UNDECIDED, False, None, None, 3, 1),
        ({"forgets": ["named by"], "follow": False}, UNDECIDED, False, None, None, 3, 1),
    ],
)  # fmt: skip
def test_what_is_said_of_a_motion(monkeypatch, case, label, known, holds_for, watched, hits, cost):
    """Where a rest makes a record one of many the true motion is followed, or nothing is known."""
    speed = speed_of(monkeypatch, **case)
    assert (speed.label, speed.known, speed.holds_for) == (label, known, holds_for)
    assert (speed.watched, speed.impact_count, speed.cost) == (watched, hits, Cost(cost, 0, 0))
    assert speed.loads == ("loads" if known else motion_at_speed.NOTHING)
    undone = not known and not case.get("follow", True)
    failed = case.get("followed") == UNDECIDED
    assert speed.status is (Status.UNRESOLVED if failed else Status.OK)
    has_exponent = not undone
    assert speed.exponent == (0.5 if has_exponent else None)
    assert speed.exponent_error == (0.01 if has_exponent else None)
    assert speed_of(monkeypatch, **case, lyapunov=False).exponent is None


@pytest.mark.parametrize(
    ("case", "end"),
    [
        ({"keeps_ends": True}, "end"),
        ({}, None),
        ({"keeps_ends": True, "status": Status.UNRESOLVED}, None),
        (
            {
                "keeps_ends": True,
                "status": Status.UNRESOLVED,
                "forgets": ["record"],
                "followed": MOTION,
            },
            None,
        ),
        ({"keeps_ends": True, "forgets": ["record"], "followed": MOTION}, "true end"),
        ({"forgets": ["record"], "followed": MOTION}, None),
        ({"keeps_ends": True, "forgets": ["record"], "followed": UNDECIDED}, None),
        ({"keeps_ends": True, "forgets": ["record"], "follow": False}, "end"),
    ],
)
def test_where_the_next_motion_may_begin(monkeypatch, case, end):
    """At the state that this one ends at, the true one where it is followed; not after trouble."""
    speed = speed_of(monkeypatch, **case)
    assert speed.end == end
    in_trouble = "status" in case or case.get("followed") == UNDECIDED
    assert speed.status is (Status.UNRESOLVED if in_trouble else Status.OK)


@pytest.mark.parametrize("fails", ["setup", "orbit"])
@pytest.mark.parametrize(
    ("start", "name"),
    [(None, "mass = 2.5"), (Start(0.3, place="run.also.1"), "mass = 2.5 from run.also.1"),
     (Start(0.9), "mass = 2.5")],
)  # fmt: skip
def test_a_motion_that_cannot_be_made_says_which_it_is(monkeypatch, fails, start, name):
    """One of several starts has its name; the state that another motion ended with has none."""

    def setup(value):
        if fails == "setup":
            raise ZeroDivisionError
        return "system", 55.0, "settings"

    def orbit(*given):
        assert given == ("system", 55.0, "settings", start)
        raise ZeroDivisionError

    monkeypatch.setattr(motion_at_speed, "Orbit", orbit)
    own = start if start is not None and start.place != "run.start" else None
    task = SpeedTask("mass", setup, True, False, False, 10.0, 10.0, start=own)
    found = task.started_at(2.5, start)
    assert (found.status, found.value, found.fault.piece) == (Status.FAULT, 2.5, name)
    assert found.rpm == 55.0 if fails == "orbit" else found.rpm != found.rpm
    assert (found.impact_count, found.strobe, found.cost) == (None, None, Cost())
    assert [len(column) for column in found.impacts] == [0, 0, 0, 0]
