"""How a motion is followed until it has a name, with runs and solved orbits that are stand-ins."""

from __future__ import annotations

from math import isnan, nan
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import classify as module
from camcli.analysis.after_rest import CYCLE, HoldsFor
from camcli.analysis.classify import ClassifiedMotion, _Followed
from camcli.analysis.integrate import AtSpeeds, Cost, Start
from camcli.analysis.labels import APERIODIC, FEWEST_TURNS, UNDECIDED
from camcli.errors import Status

RUN = settings(17, 200)


def record_of(name, chatter=(), status=Status.OK, cost=(0, 0, 0)):
    return Stub(name=name, status=status, chatter=np.array(chatter, int), periods=len(chatter),
                cost=Cost(*cost), impacts=np.zeros(len(chatter), int))  # fmt: skip


def orbit_of(name, **more):
    return Stub(label=name, turns=3, symbols=(2, 1, 1), theta=(0.1,), stable=True, **more)


def exponents_of(name, chaotic=False):
    return Stub(name=name, chaotic=chaotic)


class Names:
    """Stand-ins for what solves and measures: `solved` has the orbit of each record by its name."""

    def __init__(self, monkeypatch, solved=(), chaotic=()):
        monkeypatch.setattr(
            module, "identify", lambda system, rpm, record: dict(solved).get(record.name)
        )
        monkeypatch.setattr(
            module, "of_orbit", lambda system, orbit: exponents_of(f"of {orbit.label}")
        )
        monkeypatch.setattr(
            module, "of_record",
            lambda system, rpm, record: exponents_of(
                f"of record {record.name}", record.name in chaotic
            ),
        )  # fmt: skip


def begun(record, longer=None):
    """A run at the end of its record, and how it goes on."""

    def go_on(skipped, turns):
        assert (skipped, turns) == (0, 8 * 200)
        return Stub(name="longer run", run=lambda: longer)

    return Stub(name="run", go_on=go_on), record


def followed(record, longer=None):
    return _Followed("system", 700.0, RUN, Start(), begun(record, longer))


def test_a_motion_without_a_name_is_followed_on(monkeypatch):
    """What it ends on takes the place of what was known; a record in trouble does not."""
    Names(monkeypatch, {"longer": orbit_of("P(3;2:1:1)")})
    motion = followed(record_of("first"), record_of("longer", cost=(3, 5, 7)))
    assert (motion.orbit, motion.exponents.name) == (None, "of record first")
    assert (motion.turns, motion.cost, motion.certain) == (217, Cost(0, 0, 0), False)
    motion.go_on()
    assert (motion.orbit.label, motion.exponents.name) == ("P(3;2:1:1)", "of P(3;2:1:1)")
    assert (motion.run.name, motion.record.name) == ("longer run", "longer")
    assert (motion.turns, motion.cost, motion.certain) == (217 + 1600, Cost(3, 5, 7), True)
    lost = record_of("lost", status=Status.IMPACT_BUDGET, cost=(2, 4, 6))
    motion = followed(record_of("first"), lost)
    motion.go_on()
    assert (motion.run.name, motion.record.name, motion.status) == ("run", "first", Status.OK)
    assert (motion.turns, motion.cost) == (217, Cost(2, 4, 6))
    assert (motion.orbit, motion.exponents) == (None, None)


def test_a_motion_is_certain_with_an_orbit_or_with_chaos(monkeypatch):
    Names(monkeypatch, {"solved": orbit_of("P")}, ["chaos"])
    for name, certain in (("solved", True), ("chaos", True), ("neither", False)):
        assert followed(record_of(name)).certain is certain
    lost = followed(record_of("lost", status=Status.IMPACT_BUDGET))
    assert (lost.exponents, lost.certain, lost.status) == (None, False, Status.IMPACT_BUDGET)
    resting = record_of("rests", [1, 0, 2, 1, 9])
    resting.periods = 4  # the last turn is not whole
    assert followed(resting).rests_in_record == 4


@pytest.mark.parametrize("goes_on", [True, False])
def test_the_true_motion_after_a_rest_takes_the_place_of_the_one_of_doubles(monkeypatch, goes_on):
    """With its run and its turns where doubles go on from it."""
    Names(monkeypatch)
    after = module._AfterRest(
        orbit_of("true"), exponents_of("true"), record_of("after", cost=(1, 2, 4)),
        HoldsFor.LAST_DIGIT, Stub(name="run after") if goes_on else None,
    )  # fmt: skip
    asked = []
    monkeypatch.setattr(module, "_after_rest", lambda *given: asked.append(given) or after)
    motion = followed(record_of("first"))
    first = motion.record
    motion.follow_after_rest()
    assert asked == [("system", 700.0, RUN, first)]
    assert (motion.orbit.label, motion.exponents.name) == ("true", "true")
    assert motion.holds_for is HoldsFor.LAST_DIGIT
    found = (motion.run.name, motion.record.name, motion.cost, motion.turns)
    if goes_on:
        assert found == ("run after", "after", Cost(1, 2, 4), 217 + 217)
    else:
        assert found == ("run", "first", Cost(0, 0, 0), 217)


def test_an_end_after_a_rest_is_taken_where_it_has_an_orbit(monkeypatch):
    Names(monkeypatch)
    for orbit in (None, orbit_of("true")):
        after = module._AfterRest(
            orbit, exponents_of("true"), record_of("after", cost=(1, 2, 4)), HoldsFor.ROUNDING
        )
        monkeypatch.setattr(module, "_after_rest", lambda *given, after=after: after)
        motion = followed(record_of("first"))
        assert motion.end_after_rest() is (orbit is not None)
        names = (motion.orbit, motion.exponents.name, motion.record.name)
        if orbit is None:
            assert names == (None, "of record first", "first")
            assert (motion.holds_for, motion.cost) == (None, Cost(0, 0, 0))
        else:
            assert names == (orbit, "true", "after")
            assert (motion.holds_for, motion.cost) == (HoldsFor.ROUNDING, Cost(1, 2, 4))


@pytest.mark.parametrize("end", ["stays", "no record", "orbit", "else"])
def test_a_motion_that_looks_aperiodic_is_watched(monkeypatch, end):
    Names(monkeypatch)
    seen = Stub(turns=50, cost=Cost(1, 2, 4), stays=end == "stays",
                record=None if end == "no record" else record_of("seen"),
                orbit=orbit_of("late") if end == "orbit" else None)  # fmt: skip
    asked = []
    monkeypatch.setattr(module, "watch", lambda *given: asked.append(given) or seen)
    motion = followed(record_of("first"))
    motion.follow_with_patience()
    assert asked == [(motion.run, 700.0, RUN.patience, 200)]
    assert (motion.watched, motion.cost) == (217 + 50, Cost(1, 2, 4))
    names = (motion.record.name, motion.orbit and motion.orbit.label, motion.exponents.name)
    assert (
        names
        == {
            "stays": ("first", None, "of record first"),
            "no record": ("first", None, "of record first"),
            "orbit": ("seen", "late", "of late"),
            "else": ("seen", None, "of record seen"),
        }[end]
    )


@pytest.mark.parametrize("kind", [CYCLE, "settled", "unknown"])
def test_what_is_behind_a_rest(monkeypatch, kind):
    """A cycle is its own orbit; any other end that is known, a start for doubles."""
    Names(monkeypatch, {"after": orbit_of("solved")})
    begin = None if kind == "unknown" else Start(0.3, 0.4)
    after = Stub(kind=kind, states="states", symbols="symbols", leaves="leaves",
                 holds_for=None if kind == "unknown" else HoldsFor.EXACT_DATA,
                 start=lambda *of: begin if of == ("system", 700.0) else "wrong")  # fmt: skip
    monkeypatch.setattr(module, "after_first_rest", lambda system, rpm, record: after)
    monkeypatch.setattr(module, "resting_orbit", lambda *given: orbit_of(" ".join(map(str, given))))
    runs = []

    class OneOrbit:
        def __init__(self, *given):
            runs.append(given)

        def run(self):
            return record_of("after")

    monkeypatch.setattr(module, "Orbit", OneOrbit)
    given = record_of("given")
    found = module._after_rest("system", 700.0, settings(17, 5), given)
    if kind == CYCLE:
        assert found.orbit.label == "system 700.0 states symbols leaves"
        assert found.exponents.name == f"of {found.orbit.label}"
        assert (found.record, found.holds_for, found.run) == (given, HoldsFor.EXACT_DATA, None)
        assert runs == []
    elif kind == "settled":
        assert (found.orbit.label, found.exponents.name) == ("solved", "of solved")
        assert (found.record.name, found.holds_for) == ("after", HoldsFor.EXACT_DATA)
        assert isinstance(found.run, OneOrbit)
        ((system, rpm, run, start),) = runs
        assert (system, rpm, start, run.transient) == ("system", 700.0, begin, 17)
        assert run.record == module.FEWEST_TURNS > 5
    else:
        assert (found.orbit, found.exponents.name) == (None, "of record given")
        assert (found.record, found.holds_for, found.run) == (given, HoldsFor.ROUNDING, None)


def stages(monkeypatch, **known):
    """The motion of `classify_at` whose stages are told, and those that were gone through."""
    gone = []

    class Motion:
        def __init__(self, system, rpm, runs, start, begun):
            self.given = (system, rpm, runs, start, begun)
            self.status = known.get("status", Status.OK)
            self.orbit = known.get("orbit")
            self.chaotic = known.get("chaotic", False)
            self.rests_in_record = known.get("rests", 0)
            self.record = record_of("record", [1, 0])
            self.record.impacts += [3, 4]
            self.exponents = "exponents"
            self.cost = Cost(1, 2, 3)
            self.holds_for = HoldsFor.LAST_DIGIT
            self.watched = 99

        @property
        def certain(self):
            return self.orbit is not None or self.chaotic

        def go_on(self):
            gone.append("on")
            self.orbit = known.get("later")

        def follow_after_rest(self):
            gone.append("after rest")
            self.orbit = known.get("after")
            self.chaotic = known.get("chaotic_after", self.chaotic)

        def follow_with_patience(self):
            gone.append("patience")
            self.rests_in_record = known.get("rests_late", 0)
            self.orbit = known.get("late")

        def end_after_rest(self):
            gone.append("end")
            self.orbit = known.get("end")
            return self.orbit is not None

    monkeypatch.setattr(module, "_Followed", Motion)
    found = module.classify_at("system", 700.0, RUN)
    assert (found.value, found.rpm, found.start) == (700.0, 700.0, RUN.start)
    assert (found.exponents, found.cost, found.watched) == ("exponents", Cost(1, 2, 3), 99)
    assert (found.impacts, found.chatter) == (3.5 if found.orbit is None else 4.0, "complete")
    assert (found.transient, found.status) == (None, known.get("status", Status.OK))
    assert (found.holds_for is None) == (found.orbit is None)
    return found.label, gone


LATE = orbit_of("P(3;2:1:1)")


@pytest.mark.parametrize(
    ("known", "label", "stages_gone"),
    [
        ({"orbit": LATE}, LATE.label, []),
        ({}, UNDECIDED, ["on"]),
        ({"later": LATE}, LATE.label, ["on"]),
        ({"later": LATE, "rests": 1}, LATE.label, ["on"]),
        ({"orbit": LATE, "rests": 2}, LATE.label, []),
        ({"rests": 1, "after": LATE}, LATE.label, ["on", "after rest"]),
        ({"rests": 1}, UNDECIDED, ["on", "after rest"]),
        ({"rests": 1, "chaotic_after": True}, APERIODIC, ["on", "after rest", "patience"]),
        ({"chaotic": True}, APERIODIC, ["patience"]),
        ({"chaotic": True, "late": LATE}, LATE.label, ["patience"]),
        ({"chaotic": True, "rests_late": 1}, UNDECIDED, ["patience"]),
        ({"chaotic": True, "rests_late": 2}, UNDECIDED, ["patience", "end"]),
        ({"chaotic": True, "rests_late": 2, "end": LATE}, LATE.label, ["patience", "end"]),
        ({"chaotic": True, "rests_late": 2, "late": LATE}, LATE.label, ["patience"]),
        ({"chaotic": True, "status": Status.IMPACT_BUDGET}, UNDECIDED, []),
        ({"rests": 1, "status": Status.IMPACT_BUDGET}, UNDECIDED, []),
    ],
)
def test_through_which_stages_a_motion_gets_its_name(monkeypatch, known, label, stages_gone):
    assert stages(monkeypatch, **known) == (label, stages_gone)


def motion_of(label, cost, orbit=None, start=None):
    return ClassifiedMotion(0.0, 0.0, start, label, orbit, None, 1.0, "", None, Status.OK,
                            Cost(*cost), record_of(label))  # fmt: skip


def test_motions_from_a_cloud_are_told_once_with_all_that_they_cost(monkeypatch):
    """The scene's start first; of five starts with the seed 2 those behind the first ten."""
    asked = []
    labels = ["undecided", "aperiodic", "undecided", "aperiodic", "undecided", "aperiodic"]

    def classify_at(system, rpm, runs, start):
        k = len(asked)
        asked.append(start)
        return motion_of(labels[k], (10**k, 0, 0), start=start)

    monkeypatch.setattr(module, "classify_at", classify_at)
    monkeypatch.setattr(module, "cloud", lambda system, rpm: iter(range(100)))
    ends = []
    monkeypatch.setattr(module, "own_end", lambda s, r, motion: ends.append("own") or motion)
    monkeypatch.setattr(
        module, "with_transient", lambda s, r, motion: ends.append(motion.label) or motion
    )
    found = module.attractors("system", 700.0, RUN, 5, 2)
    assert asked == [RUN.start, 10, 11, 12, 13, 14]
    assert ends == ["own", "aperiodic"]
    assert [one.label for one in found] == ["aperiodic", "undecided"]  # in their fixed order
    assert [one.cost.impacts for one in found] == [101_010, 10_101]
    assert [one.start for one in found] == [10, RUN.start]


def test_motions_are_classified_value_by_value(monkeypatch):
    """Of what is varied, with the speed that belongs to it; a value may fail alone."""
    asked = []

    def attractors(system, rpm, runs, starts, seed):
        asked.append((system, rpm, runs, starts, seed))
        if rpm == 6.0:
            raise KeyError("unforeseen")
        return [motion_of(f"{rpm}", (1, 0, 0)), motion_of(f"{rpm} more", (2, 0, 0))]

    monkeypatch.setattr(module, "attractors", attractors)
    monkeypatch.setattr(module, "refuse_below", lambda setup, values: asked.append(values))
    told = []
    made = module.classify(
        "system", RUN, [0.5, 3.0, 0.25], 4, 7, 1, lambda: told.append(len(told)),
        lambda value: (f"machine {value}", 2.0 * value, f"runs {value}"), "follower.damping",
    )  # fmt: skip
    assert asked == [
        (0.5,), ("machine 0.5", 1.0, "runs 0.5", 4, 7), ("machine 3.0", 6.0, "runs 3.0", 4, 7),
        ("machine 0.25", 0.5, "runs 0.25", 4, 7),
    ]  # fmt: skip
    assert told == [0, 1, 2]
    assert [one.value for one in made] == [0.5, 0.5, 3.0, 0.25, 0.25]
    assert [one.label for one in made] == ["1.0", "1.0 more", UNDECIDED, "0.5", "0.5 more"]
    failed = made[2]
    assert (failed.status, failed.fault.piece) == (Status.FAULT, "follower.damping = 3.0")
    assert (isnan(failed.rpm), failed.start) == (True, RUN.start)
    asked.clear()
    made = module.classify("system", RUN, [5.0, 6.0], 1)  # speeds
    assert asked[1:] == [("system", 5.0, RUN, 1, 0), ("system", 6.0, RUN, 1, 0)]
    assert [one.rpm for one in made[2:]] == [6.0]
    assert made[2].fault.piece == "rpm = 6.0"
    asked.clear()
    assert module.classify("system", RUN, []) == asked == []


def test_a_motion_knows_its_period_and_rests():
    rests = record_of("one", [1, 0, 2, 4])
    rests.periods = 3
    motion = ClassifiedMotion(1.0, 2.0, Start(), "P", orbit_of("P"), None, nan, "", None,
                              Status.OK, Cost(), rests)  # fmt: skip
    assert (motion.period, motion.chatters, motion.stable) == (3, 3, True)
    open_end = motion_of(APERIODIC, (0, 0, 0))
    assert (open_end.period, open_end.chatters, open_end.stable) == (0, 0, None)
    assert AtSpeeds("system", RUN)(700.0) == ("system", 700.0, RUN)


def test_a_record_too_short_for_a_name_is_made_anew(monkeypatch):
    """Whatever was begun; one that is long enough is taken as it is."""
    Names(monkeypatch, chaotic=["made"])
    runs = []

    class OneOrbit:
        def __init__(self, *given):
            runs.append(given)

        def run(self):
            return record_of("made", cost=(1, 2, 4))

    monkeypatch.setattr(module, "Orbit", OneOrbit)
    short = settings(17, FEWEST_TURNS - 1)
    for given in (begun(record_of("short")), None):
        motion = _Followed("system", 700.0, short, Start(0.3, 0.4), given)
        assert (motion.record.name, motion.cost) == ("made", Cost(1, 2, 4))
        assert (motion.turns, motion.recorded) == (17 + FEWEST_TURNS, FEWEST_TURNS)
        system, rpm, run, start = runs[-1]
        assert (system, rpm, start) == ("system", 700.0, Start(0.3, 0.4))
        assert (run.transient, run.record) == (17, FEWEST_TURNS)
    long = settings(17, FEWEST_TURNS)
    motion = _Followed("system", 700.0, long, Start(), begun(record_of("long")))
    assert (motion.record.name, motion.cost, len(runs)) == ("long", Cost(), 2)


SOLVED = orbit_of("P(3;2:1:1)", resting=False)
OTHER = orbit_of("P(3;9:1:1)", resting=False)
RESTS = orbit_of("P(3;inf:1:1)", resting=True)


@pytest.mark.parametrize(
    ("orbit", "holds_for"),
    [(None, None), (RESTS, None), (SOLVED, HoldsFor.LAST_DIGIT), (SOLVED, HoldsFor.ROUNDING)],
)
def test_an_end_that_is_told_already_is_not_asked_for(monkeypatch, orbit, holds_for):
    """Nothing can be lost on the way to a rest, and what is behind one has been asked."""
    monkeypatch.setattr(module, "with_transient", lambda *given: given)
    motion = module.replace(motion_of("label", (1, 2, 3), orbit), holds_for=holds_for)
    assert module.own_end("system", RUN, motion) == ("system", RUN, motion)


@pytest.mark.parametrize("transient", [None, 12])
@pytest.mark.parametrize(
    ("growth", "after", "holds_for", "end"),
    [
        (7e10, (OTHER, HoldsFor.EXACT_DATA), None, SOLVED),  # digits enough are left
        (9e10, (OTHER, None), HoldsFor.ROUNDING, SOLVED),
        (9e10, (OTHER, HoldsFor.ROUNDING), HoldsFor.ROUNDING, SOLVED),
        (9e10, (None, HoldsFor.EXACT_DATA), HoldsFor.ROUNDING, SOLVED),
        (9e10, (SOLVED, HoldsFor.EXACT_DATA), HoldsFor.EXACT_DATA, SOLVED),
        (9e10, (OTHER, HoldsFor.LAST_DIGIT), HoldsFor.LAST_DIGIT, OTHER),
        (9e10, (RESTS, HoldsFor.LAST_DIGIT), HoldsFor.LAST_DIGIT, RESTS),
    ],
)
def test_where_the_own_start_of_a_motion_ends(
    monkeypatch, transient, growth, after, holds_for, end
):
    """Errors grow from before the first strobe to where the orbit is reached."""
    asked = []
    run = record_of("run", [0] * 40)
    true = module._AfterRest(after[0], exponents_of("true"), record_of("after", [0]), after[1])
    monkeypatch.setattr(module, "_from_start", lambda *given: asked.append(given) or run)
    monkeypatch.setattr(
        module, "_reached",
        lambda motion, record: module.replace(motion, transient=transient, cost=Cost(9, 9, 9)),
    )  # fmt: skip
    monkeypatch.setattr(module, "largest_growth", lambda *given: asked.append(given) or growth)
    monkeypatch.setattr(module, "_after_rest", lambda *given: asked.append(given) or true)
    monkeypatch.setattr(module, "same_orbit", lambda one, other: one is other)
    monkeypatch.setattr(module, "_chatter", lambda record: f"of {record.name}")
    motion = module.replace(motion_of(SOLVED.label, (1, 2, 3), SOLVED), rpm=700.0)
    found = module.own_end("system", RUN, motion)
    assert asked[0] == ("system", RUN, motion, True)
    assert asked[1] == ("system", 700.0, run, range(-1, transient or 40))
    assert asked[2:] == ([("system", 700.0, RUN, run)] if growth > module.TOO_LARGE else [])
    assert (found.orbit, found.label, found.holds_for) == (end, end.label, holds_for)
    assert found.cost == Cost(9, 9, 9)
    if end is SOLVED:
        assert (found.record, found.transient) == (motion.record, transient)
        return
    assert (found.record.name, found.transient, found.exponents.name) == ("after", None, "true")
    assert (found.impacts, found.chatter) == (4.0, "complete" if end is RESTS else "of after")


@pytest.mark.parametrize("events", [True, False])
def test_a_transient_is_counted_in_a_run_from_the_start(monkeypatch, events):
    """128 turns longer than the one that was asked for, none of them skipped."""
    runs = []

    class OneOrbit:
        def __init__(self, *given):
            runs.append(given)

        def run(self, events):
            return "record", events

    monkeypatch.setattr(module, "Orbit", OneOrbit)
    motion = module.replace(motion_of("label", (1, 2, 3), start=Start(0.3, 0.4)), rpm=700.0)
    assert module._from_start("system", settings(17, 5), motion, events) == ("record", events)
    ((system, rpm, run, start),) = runs
    assert (system, rpm, start) == ("system", 700.0, Start(0.3, 0.4))
    assert (run.transient, run.record) == (0, 17 + 128)


@pytest.mark.parametrize(
    ("away", "transient"),
    [
        ([], None), ([0, 0, 0], 0), ([1, 1, 0, 1], 0), ([2], None), ([0, 2], None),
        ([2, 2, 0, 0], 2), ([0, 2, 0, 0], 2), ([2, 0, 0, 2], None), ([0, 0, 2, 0], 3), ([0], 0),
    ],
)  # fmt: skip
def test_the_transient_ends_where_the_state_stays_at_the_orbit(monkeypatch, away, transient):
    """Farther than SAME is away; a state that comes near by chance has not settled."""
    states = [(float(k), far) for k, far in enumerate(away)]
    monkeypatch.setattr(module, "passages", lambda record: (states, "symbols"))
    monkeypatch.setattr(
        module, "distance_to",
        lambda state, of: state[1] * 0.75 * module.SAME if of == "states" else None,
    )  # fmt: skip
    orbit = orbit_of("P(3;2:1:1)", states="states")
    motion = motion_of("label", (1, 2, 3), orbit)
    found = module._reached(motion, record_of("run", cost=(10, 20, 30)))
    assert found.transient == transient
    assert (found.cost, found.record) == (Cost(11, 22, 33), motion.record)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (("P", SOLVED), ("P", SOLVED), True), (("P", SOLVED), ("Q", SOLVED), True),
        (("P", SOLVED), ("P", OTHER), False), (("P", SOLVED), ("P", None), False),
        (("P", None), ("P", SOLVED), False), (("P", None), ("P", None), True),
        (("P", None), ("Q", None), False),
    ],
)  # fmt: skip
def test_motions_are_one_by_their_orbits_or_else_by_their_words(monkeypatch, one, other, same):
    monkeypatch.setattr(module, "same_orbit", lambda a, b: a is b)
    a, b = (motion_of(label, (0, 0, 0), orbit) for label, orbit in (one, other))
    assert module.same_motion(a, b) is same


def test_impacts_are_those_of_a_period_or_the_mean_over_whole_turns():
    record = Stub(impacts=np.array([3, 4, 5, 100]), periods=3)
    assert module._impacts(None, record) == 4.0
    assert module._impacts(SOLVED, record) == 4
    assert module._impacts(Stub(symbols=(1, 2), theta=()), record) == 0.0
    assert module._impacts(None, Stub(impacts=np.array([7]), periods=0)) == 0.0


def test_the_work_of_motions_is_that_of_all_starts(monkeypatch):
    """At two speeds, from the scene's start and three more, of 22 turns each."""
    asked = []
    monkeypatch.setattr(module.backend, "for_work", asked.append)
    monkeypatch.setattr(module, "refuse_below", lambda setup, values: asked.append(values))
    monkeypatch.setattr(module, "attractors", lambda *_: [])
    assert module.classify("system", settings(17, 5), [700.0, 800.0], starts=3) == []
    assert asked == [(700.0,), 2 * 4 * 22]
