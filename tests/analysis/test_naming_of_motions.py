"""How a motion is named by its orbit, and which orbits are looked for, with stand-in solvers."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from math import inf, pi
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.integrate import Cost, Settings, Start
from camcli.analysis.labels import APERIODIC, UNDECIDED, Label
from camcli.analysis.orbits import identify, search
from camcli.analysis.orbits.identify import RecordedImpact
from camcli.analysis.orbits.search import OrbitsFound
from camcli.analysis.orbits.shooter import Root
from camcli.errors import Status
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT

TURN = 2.0 * pi


def root_of(impacts, value=700.0, turns=2, **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    given = {"machine": (value,), "rates": [-2.0 * v for _, v, _, _ in impacts],
             "tangent": [1.0] * (len(x) + 1), "trace": 0.5, "step": 0.0, "steps": 2}  # fmt: skip
    return Root([*x, value], whole, turns, parameter=0, **{**given, **more})


# -- names


ONCE, TWICE = Label((1.0, 0.0)), Label((1.0, 1.0))  # the second repeats one turn


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("solved", [False, True])
@pytest.mark.parametrize(("name", "status", "near", "chaotic", "doubtful", "of_record"), [
    (ONCE, Status.OK, True, False, False, False),
    (TWICE, Status.OK, True, False, True, False),
    (APERIODIC, Status.OK, True, False, True, True),
    (UNDECIDED, Status.OK, True, False, True, True),
    (APERIODIC, Status.OK, True, True, True, True),
    (APERIODIC, Status.OK, False, False, False, False),
    (UNDECIDED, Status.NO_RETURN, True, False, False, False),
    ("contact", Status.OK, True, False, False, False),
])  # fmt: skip
def test_a_doubtful_name_is_that_of_the_orbit_that_is_solved(
    monkeypatch, name, status, near, chaotic, doubtful, of_record, measured, solved
):
    """Unless the record says chaos; exponents are those of the orbit, else of the record."""
    calls = []
    record = Stub(status=status, near=near)
    measured_exponents = Stub(chaotic=chaotic)
    orbit = Stub(label="P(9)") if solved else None
    monkeypatch.setattr(identify, "label", lambda of: name if of is record else None)

    def exponents(*of):
        assert of == ("system", 700.0, record)
        calls.append("record")
        return measured_exponents

    def find(*of):
        assert of == ("system", 700.0, record)
        calls.append("orbit")
        return orbit

    monkeypatch.setattr(identify, "of_record", exponents)
    monkeypatch.setattr(identify, "identify", find)
    monkeypatch.setattr(identify, "of_orbit", lambda *of: ("exponents", *of))
    found = identify.named("system", 700.0, record, measured)
    asks = (measured or doubtful) and not (of_record and chaotic)
    wanted = ["record"] * of_record + ["orbit"] * asks
    if asks and solved:
        assert found == ("P(9)" if doubtful else name, ("exponents", "system", orbit))
    else:
        later = measured and status == Status.OK and not of_record
        wanted += ["record"] * later
        assert found == (name, measured_exponents if of_record or later else None)
    assert calls == wanted


# -- the orbit at the end of a record


def record_of(symbols, events=(), chatter=(), status=Status.OK, rests=False):
    """A record of turns with so many impacts each; events: (kind, turn, phase)."""
    columns = [np.array(column) for column in zip(*events, strict=True)] or [np.array([])] * 3
    return Stub(
        periods=len(symbols), status=status, rests_throughout=rests, symbols=symbols,
        kind=columns[0], period=columns[1], theta=columns[2], u=-columns[2],
        chatter=np.array([k in chatter for k in range(len(symbols))]),
    )  # fmt: skip


def ask(monkeypatch, record, gaps, bouncing=None, growth=1.0):
    """What `identify` makes of a record, and what it asked for."""
    calls = []
    n = record.periods
    states = np.array([[float(k), -float(k)] for k in range(n)])
    monkeypatch.setattr(identify, "sections", lambda of: (states, list(record.symbols)))
    monkeypatch.setattr(identify, "returns", lambda of, longest: gaps if longest == 9 else None)
    monkeypatch.setattr(identify, "Shooter", lambda *of: calls.append("shooter") or of)
    monkeypatch.setattr(
        identify, "_bouncing", lambda *of: (calls.append(of), (bouncing or {}).get(of[2]))[1]
    )
    monkeypatch.setattr(
        identify,
        "largest_growth",
        lambda system, rpm, of, window: (calls.append(window), growth)[1],
    )
    monkeypatch.setattr(identify, "resting_orbit", lambda *of: of)
    return identify.identify("system", 700.0, record, 9), calls


def test_an_orbit_that_rests_all_along_is_that_of_the_last_turn(monkeypatch):
    found, _ = ask(monkeypatch, record_of([3.0, 1.0, 0.0], rests=True), [])
    assert found == ("system", 700.0, [(2.0, -2.0)], [0.0], [])
    for short in (record_of([0.0], rests=True), record_of([0.0, 0.0], status=Status.NO_RETURN)):
        assert ask(monkeypatch, short, [])[0] is None


def test_the_shortest_period_that_is_solved_is_the_orbits(monkeypatch):
    """Of those whose turns have the same impacts as the turns before; one solver does for all."""
    events = [(IMPACT, k, 0.5 * k) for k in range(6)]
    record = record_of([9.0, 9.0, 1.0, 2.0, 1.0, 2.0], events)
    gaps = [(1, 0.125), (2, 0.25), (3, 0.5)]
    found, calls = ask(monkeypatch, record, gaps, {2: "orbit"})
    assert found == "orbit"
    impacts = [RecordedImpact(k, 0.5 * k, -0.5 * k) for k in (4, 5)]
    assert calls == ["shooter", (("system", 700.0), impacts, 2, 0.25, (5.0, -5.0), [1.0, 2.0])]
    found, calls = ask(monkeypatch, record_of([2.0] * 6, events), gaps, {3: "three"})
    assert found == "three"
    assert calls[0] == "shooter"
    assert [of[2] for of in calls[1:]] == [1, 2, 3]
    assert ask(monkeypatch, record_of([2.0] * 6, events), gaps)[0] is None
    assert ask(monkeypatch, record_of([2.0] * 6, events), [])[0] is None


@pytest.mark.parametrize("lifts", [True, False])
@pytest.mark.parametrize(("gap", "growth", "closes"), [
    (1e-12, 7e10, True), (1.1e-12, 1.0, False), (0.0, 7.1e10, False),
])  # fmt: skip
def test_an_orbit_through_a_rest_closes_by_itself(monkeypatch, lifts, gap, growth, closes):
    """It lifts off or chatters in its turns; errors must not grow beyond what doubles hold."""
    events = [
        (DETACHMENT, 2, 1.5), (IMPACT, 3, 2.0),
        *([(DETACHMENT, 4, 1.25), (IMPACT, 4, 1.75)] if lifts else [(IMPACT, 4, 1.75)]),
        (IMPACT, 5, 2.5),
    ]  # fmt: skip
    record = record_of([9.0, 9.0, 1.0, 2.0, 1.0, 2.0], events, () if lifts else (5,))
    found, calls = ask(monkeypatch, record, [(2, gap)], growth=growth)
    if closes:
        leaves = [(0, 1.25)] if lifts else []
        assert found == ("system", 700.0, [(4.0, -4.0), (5.0, -5.0)], [1.0, 2.0], leaves)
    else:
        assert found is None
    assert calls == ([range(2, 6)] if gap <= 1e-12 else [])
    both = record_of([1.0, 1.0], [(DETACHMENT, 0, 1.0), (DETACHMENT, 1, 1.0)])
    assert ask(monkeypatch, both, [(1, 0.0)])[1] == [range(2)]


@pytest.mark.parametrize(("symbols", "stable", "distance", "kept"), [
    ([1.0, 0.0, 0.0, 1.0], True, 0.0, True), ([1.0, 1.0, 0.0, 0.0], True, 0.0, True),
    ([1.0, 0.0, 1.0, 1.0], True, 0.0, False), ([1.0, 0.0, 0.0, 1.0], False, 0.0, False),
    ([1.0, 0.0, 0.0, 1.0], True, 0.0119, True), ([1.0, 0.0, 0.0, 1.0], True, 0.0121, False),
])  # fmt: skip
@pytest.mark.parametrize("impacts", [["impact"], []])
def test_an_orbit_is_one_that_its_record_comes_near_to(
    monkeypatch, symbols, stable, distance, kept, impacts
):
    """Four turns of an orbit of two; its multiplier of 3/4 leaves four gaps to go, three times."""
    orbit = Stub(symbols=(1.0, 0.0), turns=2, multipliers=(-0.75, 0.5), stable=stable, states="s")
    shooter = Stub(system="system", machine=(650.0, 9.0))
    monkeypatch.setattr(
        identify, "free_orbit", lambda *of: orbit if of == ("system", 650.0) else None
    )
    monkeypatch.setattr(
        identify, "_solved", lambda *of: orbit if of == (shooter, ["impact"], 4) else None
    )
    monkeypatch.setattr(
        identify, "distance_to", lambda *of: distance if of == ((1.0, 2.0), "s") else None
    )
    found = identify._bouncing(shooter, impacts, 4, 0.001, (1.0, 2.0), symbols)
    assert found is (orbit if kept else None)
    orbit.multipliers = (1.0, 0.5)  # as slow as can be
    assert identify._bouncing(shooter, impacts, 4, 4.1e-9, (1.0, 2.0), symbols) is (
        orbit if kept or (stable and distance == 0.0121) else None
    )
    orbit.multipliers = (0.0, 0.0)
    for distance_left, is_near in ((2.9e-9, True), (3.1e-9, False)):
        monkeypatch.setattr(identify, "distance_to", lambda *of, left=distance_left: left)
        near = identify._bouncing(shooter, impacts, 4, 0.0, (1.0, 2.0), symbols)
        right = stable and symbols != [1.0, 0.0, 1.0, 1.0]
        assert near is (orbit if is_near and right else None)


@pytest.mark.parametrize(("trace", "shortest", "attracts", "admits", "kept"), [
    (1.5, 4, True, True, True), (1.514, 4, True, True, True), (-1.514, 4, True, True, True),
    (1.516, 4, True, True, False), (-1.516, 4, True, True, False),  # 1.01 (1 + 0.5)
    (0.5, 2, True, True, True), (0.5, 4, False, True, False), (0.5, 4, True, False, False),
])  # fmt: skip
def test_an_orbit_that_is_solved_attracts_and_is_a_motion(
    monkeypatch, trace, shortest, attracts, admits, kept
):
    """One that the record goes through twice is solved again as itself."""

    class Solved(Root):
        det = 0.5

    impacts = [(1.0, 0.5, 0, 0), (2.0, 0.25, 1, 1), (1.0, 0.5, 0, 2), (2.0, 0.25, 1, 3)]
    made = root_of(impacts, 650.0, 4, trace=trace)
    root = Solved(made.x, made.whole, 4, made.machine, 0, made.rates, made.tangent, trace, 0.0, 2)
    asked = []

    def at_value(*of):
        asked.append(of)
        return root

    shooter = Stub(system="system", at_value=at_value, admits=lambda one: admits)
    monkeypatch.setattr(identify, "newton_from", lambda *of: root)
    monkeypatch.setattr(identify, "section_states", lambda *of: ("states", 9))
    monkeypatch.setattr(identify, "shortest_period", lambda states: shortest)
    monkeypatch.setattr(identify, "attracts", lambda *of: attracts and of == (trace, 0.5))
    monkeypatch.setattr(identify, "from_root", lambda *of: of)
    found = identify._solved(shooter, ["impacts"], 4)
    assert found == (("system", root) if kept else None)
    half = ([1.0, 0.5, 2.0, 0.25, 650.0], (0, 0, 1, 1), 2, 650.0)
    assert asked == ([half] if shortest == 2 else [])


def test_newtons_method_begins_with_the_impacts_of_a_record(monkeypatch):
    """A period begins at the strobe, at 1 rad; a turn with the angle zero."""
    impacts = [RecordedImpact(5, 1.0, -0.5), RecordedImpact(5, 0.75, -1.0),
               RecordedImpact(7, 3.0, -2.0)]  # fmt: skip
    monkeypatch.setattr(identify, "stretch_at", lambda cam, theta: int(4.0 * theta))
    monkeypatch.setattr(identify, "settled", lambda shooter, root: ("settled", root))
    system = Stub(strobe=1.0, cam="cam", restitution=lambda stretch: stretch / 16.0)
    shooter = Stub(system=system, value=650.0, at_value=lambda *of: of)
    found = identify.newton_from(shooter, impacts, 3)
    guess = [1.0, 0.125, 0.75, 0.1875, 3.0, 1.5, 650.0]
    assert found == ("settled", (guess, [4, 0, 3, 1, 12, 2], 3, 650.0))
    assert identify.newton_from(shooter, [], 3) is None
    assert identify.newton_from(shooter, impacts * 700, 3) is None


CAM = Stub(stretches=[Stub(start=0.0, end=2.0), Stub(start=2.0, end=TURN)])


def placed(monkeypatch, *impacts):
    monkeypatch.setattr(identify, "stretch_at", lambda cam, theta: int(theta >= 2.0))
    system = Stub(at=lambda machine: Stub(cam=CAM) if machine == (700.0,) else None, cam="other")
    found = identify._placed(system, root_of(impacts))
    if found is None:
        return None
    x, whole = found
    return [*zip(x[:-1:2], x[1:-1:2], whole[::2], whole[1::2], strict=True)]


def test_impacts_are_placed_on_the_stretch_and_in_the_turn_of_their_phase(monkeypatch):
    approx = pytest.approx
    found = placed(
        monkeypatch, (1.0, 0.5, 0, 3), (2.0, 0.25, 0, 4), (2.5, 0.125, 0, 5), (1.5, 0.5, 1, 6),
        (TURN, 0.75, 1, 7), (TURN + 1.0, 0.5, 1, 8), (-0.5, 0.25, 0, 9), (0.0, 1.0, 0, 9),
    )  # fmt: skip
    assert found == [
        (1.0, 0.5, 0, 3), (2.0, 0.25, 0, 4), (2.5, 0.125, 1, 5), (1.5, 0.5, 0, 6),
        (0.0, 0.75, 0, 8), (approx(1.0), 0.5, 0, 9), (approx(TURN - 0.5), 0.25, 1, 8),
        (0.0, 1.0, 0, 9),
    ]  # fmt: skip
    for far in (2.0 * TURN, -TURN - 0.5, 2.0 * TURN + 1.0, -1e-20):
        assert placed(monkeypatch, (1.0, 0.5, 0, 0), (far, 0.5, 1, 1)) is None


@pytest.mark.parametrize(("phases", "turns", "in_order"), [
    (((1.0, 0), (0.5, 1)), 2, True), (((1.0, 0), (0.5, 0)), 2, False),
    (((1.0, 0), (1.0, 0)), 2, False), (((1.0, 0), (0.5, 2)), 2, True),
    (((1.0, 0), (1.0, 2)), 2, False), (((1.0, 0), (1.5, 2)), 2, False), (((1.0, 0),), 1, True),
])  # fmt: skip
def test_an_orbit_is_settled_where_its_impacts_follow_each_other(
    monkeypatch, phases, turns, in_order
):
    root = root_of([(theta, 0.5, 0, turn) for theta, turn in phases], turns=turns)
    assert identify._in_order(root) is in_order
    monkeypatch.setattr(identify, "_placed", lambda system, one: (list(one.x), one.whole))
    assert identify.settled(Stub(system="s"), root) is (root if in_order else None)


def test_an_orbit_whose_impacts_have_moved_is_solved_again(monkeypatch):
    """Four times at most."""
    root = root_of([(1.0, 0.5, 0, 0)], turns=1)
    asked = []

    def at_value(*of):
        asked.append(of)
        return root

    shooter = Stub(system="system", at_value=at_value)
    moving = [(["x"], ("elsewhere",))] * 9
    for moves, settles in ((0, True), (3, True), (4, False)):
        places = [*moving[:moves], (["x"], root.whole)]
        monkeypatch.setattr(identify, "_placed", lambda system, one, of=places: of.pop(0))
        asked.clear()
        assert identify.settled(shooter, root) is (root if settles else None)
        assert asked == [(["x"], ("elsewhere",), 1, 700.0)] * moves
    monkeypatch.setattr(identify, "_placed", lambda system, one: None)
    assert identify.settled(shooter, root) is identify.settled(shooter, None) is None


def test_a_rest_is_left_at_a_lift_off_or_with_a_blow():
    events = [
        (IMPACT, 0, 0.5),
        (CHATTER, 0, 1.0),
        (IMPACT, 0, 1.5),
        (IMPACT, 0, 2.0),
        (DETACHMENT, 1, 2.5),
        (CHATTER, 1, 3.0),
        (DETACHMENT, 2, 3.5),
        (CHATTER, 2, 4.0),
    ]
    record = record_of([1.0, 1.0, 1.0], events)
    assert identify.departures(record) == [(0, 1.5), (1, 2.5), (2, 3.5)]


# -- which orbits are found


def orbit_of(label="P(1;1)", primitive=True, admissible=True, stable=True, **more):
    given = {"turns": 1, "symbols": (1.0,), "name": label}
    return Stub(label=label, primitive=primitive, admissible=admissible, stable=stable,
                **{**given, **more})  # fmt: skip


def test_an_orbit_is_kept_once_and_apart_from_the_virtual_ones(monkeypatch):
    monkeypatch.setattr(search, "same_orbit", lambda a, b: a.name == b.name)
    found = OrbitsFound()
    real, virtual = orbit_of("a"), orbit_of("a", admissible=False)
    other = orbit_of("b", admissible=False)
    assert [found.add(one) for one in (real, virtual, real, virtual, other)] == [
        True, True, False, False, True,
    ]  # fmt: skip
    assert not found.add(orbit_of("c", primitive=False))
    assert (found.orbits, found.virtual) == ([real], [virtual, other])


@pytest.mark.parametrize("label", [None, "a"])
def test_orbits_are_sorted_by_what_attracts_first(monkeypatch, label):
    """Then by their turns and their impacts; with a label only those of it are kept."""
    found = [
        orbit_of("a", stable=stable, turns=turns, symbols=symbols)
        for stable, turns, symbols in (
            (False, 1, (9.0,)), (True, 2, (1.0, 0.0)), (True, 1, (2.0,)), (True, 1, (1.0,)),
        )
    ] + [orbit_of("b", turns=5, symbols=(0.0,))]  # fmt: skip
    shooter = Stub(cost=Cost(1, 2, 3))
    asked = []

    def find(result, *of):
        asked.append(of)
        result.orbits = list(found)

    monkeypatch.setattr(search, "Shooter", lambda *of: shooter if of == ("system", 700.0) else None)
    monkeypatch.setattr(search, "_find", find)
    result = search.find("system", 700.0, "settings", 5, label, 7)
    assert asked == [(shooter, 700.0, "settings", 5, label, 7)]
    order = [found[3], found[2], found[1], *([found[4]] if label is None else []), found[0]]
    assert result.orbits == order
    assert result.cost == Cost(1, 2, 3)


FREE = Label((0.0,))


@pytest.mark.parametrize(("label", "found", "asked"), [
    (None, "", ["free", 1, 2, 3, 4, 5, 6, ("simulated", 5)]),
    (FREE, "", ["free"]),
    (FREE, "free", ["free"]),
    (Label((1.0, 0.0)), "", [2, ("simulated", 9), ("returns", 5)]),
    (Label((1.0, 0.0)), "orbit", [2]),
    (Label((1.0, 0.0)), "continuum", [2]),
    (Label((1.0, 0.0)), "other", [2, ("returns", 5)]),
    (Label((2.0, 1.0)), "", [("simulated", 9), ("returns", 5)]),
    (Label((inf, 1.0)), "", [("simulated", 9)]),
])  # fmt: skip
@pytest.mark.parametrize("starts", [5, 2, 12])
def test_where_orbits_are_looked_for(monkeypatch, label, found, asked, starts):
    """By equation, by simulation, and of a label that was not found among close returns."""
    calls = []
    result = OrbitsFound()
    free = Stub(label=FREE) if label in (None, FREE) or found else None

    def single(of, shooter, rpm, turns):
        assert (of, shooter, rpm) == (result, made, 700.0)
        calls.append(turns)
        if found == "orbit":
            result.orbits.append(Stub(label=label))
        elif found == "other":
            result.orbits.append(Stub(label="other"))
        elif found == "continuum":
            result.continua.append("dwell")

    made = Stub(system="system")
    monkeypatch.setattr(search, "piece", lambda name, what: what())
    monkeypatch.setattr(search, "free_orbit", lambda *of: free if of == ("system", 700.0) else None)
    monkeypatch.setattr(OrbitsFound, "add", lambda self, one: calls.append("free"))
    monkeypatch.setattr(search, "_add_single_impacts", single)
    monkeypatch.setattr(
        search, "_add_simulated", lambda *of: calls.append(("simulated", of[4]))
        if (*of[:4], of[5]) == (result, made, 700.0, "settings", label) else None,
    )  # fmt: skip
    monkeypatch.setattr(
        search, "_try_returns", lambda *of: calls.append(("returns", of[3]))
        if (*of[:3], *of[4:]) == (made, 700.0, "settings", label, result) else None,
    )  # fmt: skip
    search._find(result, made, 700.0, "settings", starts, label, 9)
    counts = {"simulated": starts if label is None else max(starts, 9), "returns": max(starts, 4)}
    wanted = [(one[0], counts[one[0]]) if isinstance(one, tuple) else one for one in asked]
    if free is None or label not in (None, FREE):
        wanted = [one for one in wanted if one != "free"]
    assert calls == wanted


@pytest.mark.parametrize("label", [None, "b"])
def test_motions_are_simulated_until_one_ends_on_the_label(monkeypatch, label):
    settings = Settings(30, 8, 1e-7, 40, Start(theta=0.5))
    motions = [Start(theta=k / 8.0) for k in range(9)]
    monkeypatch.setattr(search, "cloud", lambda *of: iter(motions) if of == ("system", 700.0)
                        else None)  # fmt: skip
    ends = ["a", None, "b", "c", "d"]
    asked, names, added = [], [], []

    def ends_on(shooter, rpm, run, start):
        asked.append((rpm, run, start))
        name = ends[len(asked) - 1]
        return name and Stub(label=name)

    monkeypatch.setattr(search, "_orbit_from", ends_on)
    monkeypatch.setattr(search, "piece", lambda name, what: (names.append(name), what())[1])
    result = Stub(add=lambda one: added.append(one.label))
    search._add_simulated(result, Stub(system="system"), 700.0, settings, 4, label)
    count = 5 if label is None else 3
    run = replace(settings, record=search.FEWEST_TURNS)
    starts = [settings.start, *motions[:4]][:count]
    assert asked == [(700.0, run, start) for start in starts]
    assert names == [f"the motion from start {k} at 700 rpm" for k in range(count)]
    assert added == [name for name in ends[:count] if name]


def test_a_cloud_of_starts_is_about_the_cam_at_the_strobe(monkeypatch):
    """Six lifts above it, and as many per radian to either side of its velocity."""
    cam = Stub(
        strobe=1, top=2.5,
        stretches=[Stub(start_c=1.0, start_c1=9.0), Stub(start_c=1.5, start_c1=0.25),
                   Stub(start_c=0.5, start_c1=9.0)],
    )  # fmt: skip
    monkeypatch.setattr(Start, "at_strobe", lambda *of: of)
    found = list(islice(search.cloud(Stub(cam=cam), 700.0), 3))
    halves, thirds = (0.5, 0.25, 0.75), (1 / 3, 2 / 3, 1 / 9)
    assert [of[1] for of in found] == [700.0] * 3
    for (_, _, (q, w)), half, third in zip(found, halves, thirds, strict=True):
        assert q == pytest.approx(1.5 + 12.0 * half)
        assert w == pytest.approx(0.25 + 12.0 * (2.0 * third - 1.0))


def test_close_returns_are_tried_from_the_closest_on(monkeypatch):
    """Of motions without a transient; until one solves to a motion of the label."""
    label = Label((1.0, 0.0))
    settings = Settings(30, 8, 1e-7, 40, Start(theta=0.5))
    runs = []

    def simulate(system, rpm, run, start):
        runs.append((run.transient, run.record, start))
        return Stub(status=Status.NO_RETURN if len(runs) == 2 else Status.OK, number=len(runs))

    monkeypatch.setattr(search, "cloud", lambda *of: iter(["s1", "s2", "s3", "s4"]))
    monkeypatch.setattr(
        search, "_close_returns",
        lambda record, of: [(0.5 / record.number, f"{record.number}a"), (0.3, f"{record.number}b")]
        if of == label else None,
    )  # fmt: skip
    solved = {  # by the impacts tried: label, whether it is new, and a motion
        "4a": None, "3a": ("other", True, True), "1b": (label, True, False),
        "3b": (label, False, True), "4b": (label, True, True), "1a": (label, True, True),
    }  # fmt: skip
    tried, added = [], []

    def newton(shooter, impacts, turns):
        assert turns == 2
        tried.append(impacts)
        return solved[impacts] and impacts

    def orbit(system, root, verdict):
        name, new, admissible = solved[root]
        assert verdict == len(root)
        return Stub(label=name, new=new, admissible=admissible)

    monkeypatch.setattr(search, "newton_from", newton)
    monkeypatch.setattr(search, "from_root", orbit)
    shooter = Stub(system="system", simulate=simulate, verdict=lambda root: (len(root), 7, 8.0))
    result = Stub(add=lambda one: (added.append(one.label), one.new)[1])
    search._try_returns(shooter, 700.0, settings, 3, label, result)
    turns = 30 + search.FEWEST_TURNS
    assert runs == [(0, turns, start) for start in (settings.start, "s1", "s2", "s3")]
    assert tried == ["4a", "3a", "1b", "3b", "4b"]
    assert added == [label] * 3
