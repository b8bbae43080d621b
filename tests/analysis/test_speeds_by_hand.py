"""The speeds of a sweep: how they are kept in a file, and how their runs are put together."""

from __future__ import annotations

import json
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import motion_at_speed as module
from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.integrate import Cost, Start
from camcli.analysis.labels import APERIODIC, Label
from camcli.analysis.loads import Loads
from camcli.analysis.motion_at_speed import BegunOrbit, SpeedTask, _records_of, _shows, _together
from camcli.analysis.speeds import Speed, SpeedColumns
from camcli.analysis.stored_speeds import OF_STARTS, OF_VALUES, faults_of, load_section, of_lines
from camcli.errors import Status
from camcli.piece_faults import PieceFault

FAULT = PieceFault("rpm = 700.0", "ZeroDivisionError", "camcli/x.py:1, f", "Traceback")
IMPACTS = (np.array([0, 2, 2]), np.array([10.0, 20.0, 30.5]), np.array([0.1, 0.2, 0.3]),
           np.array([-1.0, -2.0, -3.5]))  # fmt: skip
STROBE = (range(2), np.array([0.5, 0.25]), np.array([-0.5, 1.5]), np.array([3, 1]),
          np.array([0, 2]))  # fmt: skip


def speed(value=0.75, **more) -> Speed:
    known = {"value": value, "rpm": 700.0, "label": Label([2, 1]), "impact_count": 5,
             "status": Status.OK, "impacts": IMPACTS, "strobe": STROBE, "cost": Cost(3, 4, 6),
             "exponent": -0.25, "exponent_error": 0.125, "end": Start(0.5, -1.5, 0.25, "place"),
             "loads": Loads(*(0.5 + k for k in range(len(Loads._fields)))), "known": False,
             "holds_for": HoldsFor.LAST_DIGIT, "watched": 77}  # fmt: skip
    return Speed(**{**known, **more})


def as_kept(values):
    """Plain values with arrays as lists, as a file may give them back."""
    return json.loads(json.dumps(values, default=lambda x: x.tolist()))


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"impacts": None}, {"strobe": None},
        {"label": APERIODIC, "exponent": None, "exponent_error": None, "end": None},
        {"holds_for": None, "watched": None, "known": True, "status": Status.IMPACT_BUDGET},
        {"exponent": float("-inf"), "end": Start(), "loads": Loads()},
    ],
)  # fmt: skip
def test_a_speed_comes_back_from_a_file_with_all_it_had(more):
    one = speed(**more)
    back = OF_VALUES.load(as_kept(OF_VALUES.store(one)))
    for name in Speed._fields:
        before, after = getattr(one, name), getattr(back, name)
        if name in ("impacts", "strobe") and before is not None:
            assert [list(x) for x in after] == [list(x) for x in before]
        else:
            assert after == before, name
    if one.strobe is not None:
        assert back.strobe[0] == range(2)
    if one.end is not None:
        assert back.end.place == one.end.place
    assert type(back.label) is type(one.label)


def test_a_section_is_read_alone():
    values = as_kept(OF_VALUES.store(speed()))
    assert [list(x) for x in load_section("impacts", values)] == [list(x) for x in IMPACTS]
    assert [list(x) for x in load_section("strobe", values)] == [list(x) for x in STROBE]
    none = OF_VALUES.store(speed(impacts=None, strobe=None))
    assert load_section("impacts", none) is load_section("strobe", none) is None
    with pytest.raises(ValueError, match="expected"):
        load_section("strobe", {"strobe": values["impacts"]})


def test_which_piece_of_work_a_speed_is_of_and_its_faults():
    assert OF_VALUES.fits(speed(0.75), 0.75)
    assert not OF_VALUES.fits(speed(0.75), 700.0)
    assert OF_STARTS.fits(speed(0.75), (0.75, 700.0))
    assert not OF_STARTS.fits(speed(0.75), (700.0, 0.75))
    broken = speed(0.5, fault=FAULT)
    assert faults_of([speed(), broken, speed()]) == [FAULT]
    assert OF_VALUES.faults(broken) == [FAULT]
    assert OF_VALUES.faults(speed()) == []
    codec = of_lines(np.array([0.25, 0.75]))
    line = [speed(0.25, watched=1), speed(0.75, watched=2)]
    back = codec.load(as_kept(codec.store(line)))
    assert [(one.value, one.watched) for one in back] == [(0.25, 1), (0.75, 2)]
    assert codec.fits(line, 0.0)
    assert not codec.fits(line[::-1], 0.0)
    assert not codec.fits(line[:1], 0.0)
    assert codec.faults([speed(), broken]) == [FAULT]


# -- runs that are put together


def one_orbit(name, cam):
    return Stub(name=name, system=Stub(cam=cam))


def test_neighbours_on_one_cam_are_computed_in_one_call(monkeypatch):
    calls = []

    def run_all(orbits, loads):
        calls.append(([one.name for one in orbits], loads))
        return [f"record {one.name}" for one in orbits]

    monkeypatch.setattr(module, "run_all", run_all)
    here, there = ["one cam"], ["one cam"]  # equal, and two
    orbits = [one_orbit(k, cam) for k, cam in enumerate((here, here, there, here))]
    for loads in (True, False):
        calls.clear()
        assert _together(orbits, loads) == [f"record {k}" for k in range(4)]
        assert calls == [([0, 1], loads), ([2], loads), ([3], loads)]


def test_turns_after_a_record_belong_to_the_orbit_whose_record_is_too_short(monkeypatch):
    calls = []

    def run_all(orbits, loads):
        calls.append(([one.name for one in orbits], loads))
        return [f"record of {one.name}" for one in orbits]

    monkeypatch.setattr(module, "run_all", run_all)
    monkeypatch.setattr(module, "names_nothing", lambda record: record[-1] in "13")
    monkeypatch.setattr(
        module, "turns_after", lambda orbit: one_orbit(f"after {orbit.name}", orbit.system.cam)
    )
    begun = [BegunOrbit("", None, 0.0, None, None, one_orbit(str(k), None)) for k in range(5)]
    assert _records_of(begun) == [
        ("record of 0", None), ("record of 1", "record of after 1"), ("record of 2", None),
        ("record of 3", "record of after 3"), ("record of 4", None),
    ]  # fmt: skip
    assert calls == [(["0", "1", "2", "3", "4"], True), (["after 1", "after 3"], False)]
    calls.clear()
    _records_of(begun[::2])
    assert len(calls) == 1


def task_of(setup=lambda value: None, **more):
    asked = {"impacts": False, "strobe": False, "lyapunov": False, "turns": 10.0,
             "turns_each": 5.0, "start": "start"}  # fmt: skip
    return SpeedTask("follower.mass", setup, **{**asked, **more})


def test_several_values_are_measured_each_by_its_own_record(monkeypatch):
    """One that cannot be made stays in its place; a call that fails is made for each alone."""

    def begun(self, value, start):
        assert start == "start"
        return "broken" if value == 2.0 else BegunOrbit(f"at {value}", *"1234", value)

    monkeypatch.setattr(SpeedTask, "_begun", begun)
    monkeypatch.setattr(SpeedTask, "_ended", lambda self, *given: given)
    monkeypatch.setattr(SpeedTask, "__call__", lambda self, value: f"alone {value}")
    monkeypatch.setattr(
        module, "_records_of", lambda some: [(f"r{x.orbit}", f"l{x.orbit}") for x in some]
    )
    task = task_of()
    one, two, three = task.many([1.0, 2.0, 3.0])
    assert (one[0], one[1].name, *one[2:]) == (1.0, "at 1.0", "r1.0", "l1.0")
    assert two == "broken"
    assert (three[0], three[1].name, *three[2:]) == (3.0, "at 3.0", "r3.0", "l3.0")
    assert task.many([4.0]) == ["alone 4.0"]

    def fails(some):
        raise KeyError("unforeseen")

    monkeypatch.setattr(module, "_records_of", fails)
    assert task.many([5.0, 6.0]) == ["alone 5.0", "alone 6.0"]


@pytest.mark.parametrize(
    ("compiled", "turns_each", "count"),
    [(False, 5.0, 1), (True, 5.0, 64), (True, 1000.0, 20), (True, 30_000.0, 1), (True, 0.0, 64)],
)
def test_how_many_speeds_are_computed_at_once(monkeypatch, compiled, turns_each, count):
    asked = []
    kernel = Stub(for_work=asked.append, current=lambda: Stub(compiled=compiled))
    monkeypatch.setattr(module, "backend", kernel)
    assert task_of(turns=123.0, turns_each=turns_each).at_once == count
    assert asked == [123.0]


def record_of(states, impacts, chatter=None):
    q, w = np.array(states).T
    return Stub(strobe_q=q, strobe_w=w, impacts=np.array(impacts), periods=len(q),
                chatter=np.array(chatter or [0] * len(q)))  # fmt: skip


def test_a_record_shows_an_orbit_whose_turns_are_all_of_it():
    """The orbit: one impact from the first state, three from the other one."""
    a, b, c = (0.5, 2.0), (-0.25, 1.5), (0.5, 1.5)
    orbit = Stub(states=(a, b), symbols=(1, 3))
    assert _shows(record_of([a, b, a], [1, 3, 1]), orbit)
    assert _shows(record_of([b, a], [3, 1]), orbit)
    assert not _shows(record_of([a, b, a], [3, 1, 3]), orbit)
    assert not _shows(record_of([a, b, a], [1, 3, 2]), orbit)  # the last turn, too
    assert not _shows(record_of([a, b, c], [1, 3, 1]), orbit)
    assert not _shows(record_of([c, b], [1, 3]), orbit)
    assert not _shows(record_of([b, a], [3, 1], [1, 0]), orbit)  # it comes to a rest
    resting = Stub(states=(a, b), symbols=(1, float("inf")))
    assert _shows(record_of([a, b], [1, 9], [0, 1]), resting)
    near = (0.5 * (1 + 1e-12), 2.0)
    far = (0.5 + 1e-3, 2.0)
    assert _shows(record_of([near, b], [1, 3]), orbit)
    assert not _shows(record_of([far, b], [1, 3]), orbit)


@pytest.mark.parametrize("known", ["no orbit", "shown", "elsewhere"])
def test_the_true_motion_is_shown_by_turns_of_its_orbit(monkeypatch, known):
    """A record of seven turns of an orbit of three ends where the second of its states begins."""
    orbit = None if known == "no orbit" else Stub(states=("a", "b", "c"), turns=3)
    asked = []

    def classify_at(*given, **more):
        asked.append((given, more))
        return Stub(orbit=orbit, cost=Cost(10, 30, 50))

    monkeypatch.setattr(module, "classify_at", classify_at)
    monkeypatch.setattr(module, "replace", lambda one, **more: Stub(**{**vars(one), **more}))
    monkeypatch.setattr(module, "_shows", lambda record, orbit: known == "shown")
    monkeypatch.setattr(module, "start_at", lambda system, rpm, state: f"start {state} {rpm}")
    monkeypatch.setattr(module, "Orbit", lambda *given: given)
    monkeypatch.setattr(
        module, "run_all", lambda orbits: [Stub(given=one, cost=Cost(1, 2, 4)) for one in orbits]
    )
    monkeypatch.setattr(module, "_over_and_over", lambda turns, count: (turns, count))
    run = Stub(system="system", as_start=lambda: "end of doubles")
    record = Stub(periods=7)
    runs = settings(5, 7)
    motion, shown, end = module.true_motion(run, 700.0, runs, "begin", record)
    assert asked == [(("system", 700.0, runs, "begin"), {"begun": (run, record)})]
    assert motion.orbit is orbit
    if known == "elsewhere":
        turns, count = [one.given for one in shown[0]], shown[1]
        assert motion.cost == Cost(13, 36, 62)
        assert [one[3] for one in turns] == [f"start {state} 700.0" for state in "abc"]
        assert {(one[0], one[1], one[2].transient, one[2].record) for one in turns} == {
            ("system", 700.0, 0, 1)
        }
        assert (count, end) == (7, "start b 700.0")
    else:
        assert (shown, end) == (record, "end of doubles")
        assert motion.cost == Cost(10, 30, 50)


def test_some_speeds_of_all_are_those_that_a_list_would_give():
    speeds = SpeedColumns(few=2)
    for rpm in (700.0, 710.0, 720.0, 730.0, 740.0, 750.0):
        speeds.append(Speed(rpm, rpm, "P(1;1)", 3, Status.OK, None, None, Cost()))
    rpms = [700.0, 710.0, 720.0, 730.0, 740.0, 750.0]
    for part in (slice(None), slice(1, 5, 2), slice(None, None, -1), slice(-2, None), slice(4, 1)):
        assert [speed.rpm for speed in speeds[part]] == rpms[part]
    assert (speeds[-1].rpm, speeds[1].rpm, speeds[2].rpm) == (750.0, 710.0, 720.0)


ONE, TWO, FOUR = Cost(1, 10, 100), Cost(2, 20, 200), Cost(4, 40, 400)


def tape(name, cost, **more):
    known = {"name": name, "cost": cost, "hits": 5, "status": Status.OK, "periods": 7}
    return Stub(**{**known, **more})


def measured(
    monkeypatch, label="P(1;1)", named_by=None, longer=None, vague=(), true="P(2;1:1)", **asked
):
    """What `_measured` tells of a record after 5 turns that costs ONE; true motions cost FOUR."""
    record = tape("record", ONE, **asked.pop("record", {}))
    exponents = Stub(largest=-0.5, spread=0.125)
    true = Stub(label=true, exponents=Stub(largest=-0.25, spread=0.5), cost=FOUR,
                holds_for=HoldsFor.LAST_DIGIT, watched=99, status=Status.UNRESOLVED)  # fmt: skip
    monkeypatch.setattr(module, "forgets_too_much", lambda tape: tape.name in vague)
    monkeypatch.setattr(module, "named_on", lambda *given: (label, exponents, named_by or record))
    monkeypatch.setattr(
        module, "true_motion", lambda *given: (true, tape("shown", FOUR), Start(0.5, 1.0))
    )
    monkeypatch.setattr(module, "loads_of", lambda system, rpm, tape: f"loads of {tape.name}")
    orbit = Stub(as_start=lambda: Start(0.25, 2.0), omega=3.0)
    one = BegunOrbit("name", "system", 700.0, settings(5, 7), None, orbit)
    return task_of(**asked)._measured(0.75, one, record, longer)


@pytest.mark.parametrize(
    ("longer", "by", "vague", "cost"),
    [
        (None, None, (), ONE), (TWO, None, (), ONE + TWO), (TWO, "longer", (), ONE + TWO),
        (None, "other", (), ONE + FOUR), (TWO, "other", (), ONE + TWO + FOUR),
        (None, None, ("record",), ONE + FOUR), (TWO, "longer", ("longer",), ONE + TWO + FOUR),
        (None, "other", ("other",), ONE + FOUR + FOUR),
    ],
)  # fmt: skip
def test_each_record_that_names_a_motion_is_counted_once(monkeypatch, longer, by, vague, cost):
    longer = longer and tape("longer", longer)
    named_by = {None: None, "longer": longer, "other": tape("other", FOUR)}[by]
    assert measured(monkeypatch, named_by=named_by, longer=longer, vague=vague).cost == cost


@pytest.mark.parametrize("true", ["undecided", "aperiodic"])
def test_the_true_motion_is_known_where_it_has_a_name(monkeypatch, true):
    found = measured(monkeypatch, vague=("record",), true=true)
    assert (found.label, found.known) == (true, true != "undecided")
    assert found.loads == ("loads of shown" if found.known else Loads())


@pytest.mark.parametrize("way", ["named", "aperiodic", "watched", "followed", "unknown"])
@pytest.mark.parametrize("lyapunov", [True, False])
@pytest.mark.parametrize("keeps_ends", [True, False])
@pytest.mark.parametrize("status", [Status.OK, Status.IMPACT_BUDGET])
def test_what_is_told_of_a_motion(monkeypatch, way, lyapunov, keeps_ends, status):
    """A trouble of its own record stays; there is no end where there is trouble, or none wanted."""
    found = measured(
        monkeypatch, "aperiodic" if way in ("aperiodic", "watched") else "P(1;1)",
        vague=("record",) if way in ("followed", "unknown") else (), patient=way == "watched",
        follow=way != "unknown", lyapunov=lyapunov, keeps_ends=keeps_ends,
        record={"status": status},
    )  # fmt: skip
    true = way in ("watched", "followed")
    named = {"named": "P(1;1)", "aperiodic": "aperiodic", "unknown": "undecided"}
    assert found.label == ("P(2;1:1)" if true else named[way])
    assert found.known == (way != "unknown")
    assert found.watched == (99 if true else 5 + 7 if way == "aperiodic" else None)
    assert found.holds_for == (HoldsFor.LAST_DIGIT if true else None)
    assert found.status == (Status.UNRESOLVED if true and status == Status.OK else status)
    fine = keeps_ends and found.status == Status.OK
    assert found.end == (Start(0.25, 2.0) if fine else None)
    numbers = {True: (-0.25, 0.5), False: (-0.5, 0.125)}[true]
    told = numbers if lyapunov and way != "unknown" else (None, None)
    assert (found.exponent, found.exponent_error) == told
    of_loads = Loads() if way == "unknown" else f"loads of {'shown' if true else 'record'}"
    assert (found.loads, found.value, found.rpm) == (of_loads, 0.75, 700.0)
