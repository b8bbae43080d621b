"""All orbits up to a size: the theorem, its certificate, and the flights that it rests on.

Independent of it are Newton's method from random phases in plain NumPy, `all_orbits_oracle`, and
the flights of simulated motions, none of which may be excluded.
"""

import json
from copy import deepcopy
from fractions import Fraction
from itertools import pairwise, product
from math import degrees, pi, radians
from random import Random

import pytest
from flint import arb, ctx

import camcli
from camcli import check
from camcli.api.machine import machine_of
from camcli.cams.balls import COARSE, precision
from camcli.cams.decimals import exact
from camcli.cams.formula import formula_of
from camcli.exact.machine import BallMachine
from camcli.exact.phase_cover import CellFlight, Key, PhaseCover, Unknown
from camcli.scene import load_scene
from tests.support import all_orbits_oracle as oracle
from tests.support.refusals import reasons


def scene_of(impacts: int, turns: int, rpm: float = 700.0, source=None, **more):
    size = {"orbits.all.impacts": impacts, "orbits.all.turns": turns, "orbits.at": rpm}
    return load_scene(source, size | {key.replace("__", "."): x for key, x in more.items()})


def certificate(result, folder) -> dict:
    result.save(folder, plot=False)
    return json.loads((folder / "proof.json").read_text())


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """(result, content of proof.json) for up to two impacts in one turn."""
    result = camcli.orbits(scene_of(2, 1))
    return result, certificate(result, tmp_path_factory.mktemp("small"))


@pytest.fixture
def checked_all(checked):
    """(exit code, what is printed) of the checker for the statement on all orbits, changed."""

    def run(content: dict, change=lambda one: None) -> tuple[int, str]:
        content = deepcopy(content)
        content["statements"] = [x for x in content["statements"] if x["kind"] == "all-orbits"]
        change(content["statements"][0])
        return checked(content)

    return run


def phases_of(result, impacts: int, turns: int) -> set[tuple]:
    """Phases of the orbits of a result, as the oracle has them."""
    return {
        tuple(sorted(round(degrees(x), 4) for x in orbit.theta * (turns // orbit.turns)))
        for orbit in result.values.orbits
        if turns % orbit.turns == 0 and impacts * orbit.turns == len(orbit.theta) * turns
    }


def test_the_small_theorem_is_confirmed(small, checked_all):
    result, content = small
    code, text = checked_all(content)
    names = "P(1;1), stable; P(1;1), unstable; P(1;2), unstable"
    assert code == 0
    assert text == (
        "confirmed: at rpm = 700 the orbits without rest that have "
        f"1 to 2 impacts in 1 turn are 3: {names}\n1 of 1 statement is confirmed\n"
    )
    assert result.complete
    assert phases_of(result, 1, 1) == oracle.orbits(700.0, 1, 1, 200)
    assert phases_of(result, 2, 1) == oracle.orbits(700.0, 2, 1, 600)


def test_the_boxes_of_a_cover_are_counted_by_its_letters(small):
    """Those that are not cut: the empty ones, and those of a known orbit."""
    result, _ = small
    covers = result.values.every.covers
    assert [(cover.impacts, cover.turns) for cover in covers] == [(1, 1), (2, 1)]
    for cover in covers:
        empty, known = cover.letters.count("."), cover.letters.count("o")
        assert (sum(cover.counts.values()), len(cover.known)) == (empty, known)
        assert cover.boxes == empty + known
        assert set(cover.letters) <= {".", "o", *"12"}
        assert min(cover.counts.values()) > 0
        assert known > 0


@pytest.mark.soak  # at 700 rpm it is a figure, whose certificate and numbers CI checks
@pytest.mark.parametrize(("rpm", "names"), [
    (700.0, ["P(1;1)", "P(1;1)", "P(1;2)", "P(2;2:1)"]),
    (745.0, None),
    (358.5, None),
])  # fmt: skip
def test_all_up_to_three_impacts_and_two_turns(rpm, names, checked_all, tmp_path):
    result = camcli.orbits(scene_of(3, 2, rpm))
    code, text = checked_all(certificate(result, tmp_path / "out"))
    assert code == 0, text
    found = [str(orbit.label) for orbit in result.values.orbits]
    assert names is None or found == names
    for impacts in (1, 2, 3):
        for turns in (1, 2):
            found = oracle.orbits(rpm, impacts, turns, 2000)
            assert found == phases_of(result, impacts, turns), (impacts, turns)


# -- changed certificates


def put(*path):
    *keys, last, value = path

    def change(one):
        for key in keys:
            one = one[key]
        one[last] = value

    return change


def dropped_orbit(one):
    """P(1;2) is not in the list."""
    del one["orbits"][2]


def dropped_box(one):
    boxes = one["covers"][1]["boxes"]
    at = boxes.index("1..")
    one["covers"][1]["boxes"] = boxes[:at] + boxes[at + 1 :]


def not_cut(one):
    """A box that had to be cut is said to be empty."""
    boxes = one["covers"][0]["boxes"]
    at = boxes.index("1..")
    one["covers"][0]["boxes"] = boxes[:at] + "." + boxes[at + 3 :]


def without_its_orbit(one):
    """The box about P(1;2) is said to be empty."""
    cover = one["covers"][1]
    cover["boxes"], cover["orbits"] = cover["boxes"].replace("o", "."), []


def moved_box(one):
    """The box about P(1;2) changes places with one beside it."""
    cover = one["covers"][1]
    boxes = cover["boxes"]
    at = boxes.index("o")
    place = at + 1 if boxes[at + 1] == "." else at - 1
    assert boxes[place] == "."
    letters = list(boxes)
    letters[at], letters[place] = ".", "o"
    cover["boxes"] = "".join(letters)


def cut_elsewhere(one):
    boxes = one["covers"][0]["boxes"]
    one["covers"][0]["boxes"] = boxes.replace("1", "2", 1)


def twice(one):
    one["orbits"].append(deepcopy(one["orbits"][0]))


def cut_short(one):
    """The last box of a cover is left out."""
    one["covers"][0]["boxes"] = one["covers"][0]["boxes"][:-1]


def cut_too_often(times: int):
    """The first box of a cover is cut so many times, always its first half."""

    def change(one):
        one["covers"][0]["boxes"] = "1" * times

    return change


def no_cover(one):
    del one["covers"][0]


def more_turns(one):
    one["turns"] = 2


def another_orbit(one):
    one["covers"][1]["orbits"] = [0]


def too_many(one):
    one["covers"][0]["boxes"] += "."


def end_of(boxes: str, at: int) -> int:
    """Where the tree that begins at a letter ends."""
    open_boxes = 1
    while open_boxes:
        open_boxes += 1 if boxes[at].isdigit() else -1
        at += 1
    return at


def whole_nose(one):
    """The nose is not cut: it is one box that is said to hold the stable P(1;1) only.

    That is true, but not shown: over so wide a box the slope of E has not one sign.
    """
    cover = one["covers"][0]
    boxes = cover["boxes"]
    start = end_of(boxes, end_of(boxes, 0))  # behind the dwell and the flank
    end = end_of(boxes, start)
    before, inside = boxes[:start].count("o"), boxes[start:end].count("o")
    assert cover["orbits"][before:] == [0] * inside != []
    cover["boxes"] = boxes[:start] + "o" + boxes[end:]
    cover["orbits"] = cover["orbits"][: before + 1]


def looser(one):
    """Another restitution in the theorem, and in its orbits, which then are none."""
    one["constants"]["restitution"] = "0.79"


WRONG = [
    (dropped_orbit, "a box names an orbit that is not there"),
    (dropped_box, "a box of a cover may hold an orbit"),
    (not_cut, "a box of a cover may hold an orbit"),
    (without_its_orbit, "a box of a cover may hold an orbit"),
    (moved_box, "a box of a cover may hold an orbit"),
    (whole_nose, "a box may hold another orbit than the one it names"),
    (cut_elsewhere, "a box is cut along a phase that it has not"),
    (cut_short, "boxes are missing in a cover"),
    (cut_too_often(60), "boxes are missing in a cover"),
    (cut_too_often(61), "a box is too small"),
    (twice, "an orbit may stand there twice"),
    (no_cover, "a cover is missing"),
    (more_turns, "a cover is missing"),
    (another_orbit, "a box may hold another orbit than the one it names"),
    (too_many, "a cover has too many boxes"),
    (looser, "an orbit is one of another machine"),
    (put("constants", "rpm", "701"), "an orbit is one of another speed"),
    (put("constants", "rpm", "0"), "speed or mass is not positive"),
    (put("constants", "rpm", None), "exactly the parameter has to be left open"),
    (put("orbits", 0, "stable", False), "both multipliers may lie inside the unit circle"),
    (put("orbits", 2, "label", "P(1;1)"), "its label is P(1;2)"),
    (put("strobe", "1"), "an orbit is one of another machine"),
    (put("impacts", 1), "an orbit is larger than those that are covered"),
]


@pytest.mark.parametrize(("change", "why"), WRONG)
def test_what_is_wrong_is_refused_for_its_reason(small, checked_all, change, why):
    code, text = checked_all(small[1], change)
    assert code == 1
    assert why in reasons(text)


@pytest.mark.parametrize(("change", "where"), [
    (put("covers", 0, "boxes", "x"), ".covers[0].boxes: expected the letters of a cover"),
    (put("covers", 0, "boxes", ""), ".covers[0].boxes: expected the letters of a cover"),
    (put("orbits", 0, "kind", "event"), ".orbits[0].kind: expected one of orbit"),
    (put("orbits", 0, 7), ".orbits[0].kind: expected one of orbit"),
    (put("impacts", 10), ".impacts: expected a whole number from 1 to 9"),
    (put("more", 1), ": expected an object with the keys kind, constants, strobe, impacts, turns, "
                     "orbits, covers"),
])  # fmt: skip
def test_what_is_no_such_statement_is_no_certificate(small, checked_all, change, where):
    code, text = checked_all(small[1], change)
    assert code == 2
    assert reasons(text) == [f"the file.statements[0]{where}"]


def test_every_letter_of_a_cover_counts(small, checked_all):
    """A letter that is another one makes a cover that is refused, wherever it stands."""
    random = Random(5)
    boxes = small[1]["statements"][-1]["covers"][0]["boxes"]
    for at in random.sample(range(len(boxes)), 12):
        other = random.choice([x for x in "1o." if x != boxes[at]])
        code, _ = checked_all(
            small[1], put("covers", 0, "boxes", boxes[:at] + other + boxes[at + 1 :])
        )
        assert code == 1, (at, boxes[at], other)


# -- the flights

DAMPED = {"follower.damping": 20.0, "follower.preload": 30.0, "follower.gravity": 9.81}
STRONG = {"follower.damping": 150.0, "follower.preload": 30.0}
BALL = {"follower.stiffness": 0.0, "follower.gravity": 9.81}


@pytest.mark.parametrize(("numbers", "rpm"), [
    ({}, 190.0),
    pytest.param({}, 361.0, marks=pytest.mark.ci),
    ({}, 745.0),
    pytest.param(DAMPED, 300.0, marks=pytest.mark.ci),
    (DAMPED, 700.0),
    (STRONG, 900.0),
    (BALL, 200.0),
])  # fmt: skip
def test_no_flight_of_a_motion_is_excluded(numbers, rpm):
    """Each lies in the balls of its cells, large and small, of the search and of the checker."""
    run = {"run.rpm": rpm, "run.transient": 0, "run.record": 60}
    scene = load_scene(None, numbers | run)
    events = camcli.simulate(scene).tables["events"]
    system = machine_of(scene).system
    omega = rpm * pi / 30
    rows = list(zip(events["event"], events["t_s"], events["theta_deg"],
                    events["u_minus_m_per_s"], events["u_plus_m_per_s"], strict=True))  # fmt: skip
    flights = [(a, b) for a, b in pairwise(rows) if a[0] == b[0] == "impact"]
    random = Random(2)
    known = {**vars(system.follower), "rpm": rpm}
    constants = {key: Fraction(exact(known[key])) for key in check.CONSTANTS}
    before = ctx.prec
    ctx.prec = check.BITS
    checker = check.PhaseCover(check.Machine(check.cam_of(formula_of(system.shape), ""), constants))
    ctx.prec = before
    judged = 0
    with precision(COARSE // 3):
        cover = PhaseCover(BallMachine(system.shape, system.follower, rpm))
        edges = [(float(one.start), float(one.end)) for one in cover.machine.stretches]

        def key(phase, turn):
            """The part of some size that holds a phase."""
            k = next(k for k, (_, end) in enumerate(edges) if phase < end)
            low, high = edges[k]
            depth = random.choice([0, 1, 2, 3, 5, 8, 12])
            part = int((phase - low) / (high - low) * 2**depth)
            return Key(k + turn * len(edges), depth, min(2**depth - 1, max(0, part)))

        for start, end in random.sample(flights, min(len(flights), 200)):
            a, b = radians(start[2]), radians(end[2])
            turn = round((a + (end[1] - start[1]) * omega - b) / (2 * pi))
            cells = key(a, 0), key(b, turn)
            found = cover.between(*cells)
            assert isinstance(found, CellFlight) or found is Unknown
            other = checker.known(*cells)
            assert other is not None
            for rates in (found, other):
                if rates is Unknown or rates.out is None:
                    continue
                room = arb(0, 1e-9)
                assert (rates.out + room).contains(arb(start[4] / omega))
                assert (rates.into + room).contains(arb(end[3] / omega))
                judged += 1
    assert judged > len(flights[:200])


@pytest.mark.parametrize("rpm", [18.0, 30.0])
def test_flights_between_wide_cells_of_a_fast_spring_lie_in_their_balls(rpm):
    """Cells of which the farthest phases lie more than a swing of the follower apart."""
    system = machine_of(load_scene(None, {"run.rpm": rpm})).system
    known = {**vars(system.follower), "rpm": rpm}
    constants = {key: Fraction(exact(known[key])) for key in check.CONSTANTS}
    random, before = Random(39), ctx.prec
    ctx.prec = check.BITS
    try:
        flow = check.Machine(check.cam_of(formula_of(system.shape), ""), constants)
        checker = check.PhaseCover(flow)
        cover = PhaseCover(BallMachine(system.shape, system.follower, rpm))
        swing = pi / float(flow.f)
        cells = [Key(k, depth, part) for k in range(7) for depth in (1, 2, 3)
                 for part in range(2**depth)]  # fmt: skip
        pairs = [(a, b) for a in cells for b in cells if a[:2] == b[:2] and a[2] <= b[2]]
        seen = 0
        shares = 0.5, 0.9, 0.99, 0.999
        for (a, b), share in product(pairs, shares):
            here, there = checker.cell(a), checker.cell(b)
            theta = arb(random.uniform(float(here.x.lower()), float(here.x.upper())))
            span = arb(share * swing)
            end = theta + span
            if not there.x.contains(end):
                continue
            seen += 1
            big, rate, p = flow.flow(span)
            (c, c1), (end_c, end_c1) = (
                cell.stretch.derivatives(x, 1) for cell, x in ((here, theta), (there, end))
            )
            pull = flow.G + flow.W2 * c
            w = (end_c - c + pull * p) / big
            out, into = w - c1, w * rate - pull * big - end_c1
            for made in (checker.flight(here, there), cover.between(a, b)):
                if isinstance(made, CellFlight) or getattr(made, "out", None) is not None:
                    assert made.out.overlaps(out)
                    assert made.into.overlaps(into)
        assert seen > 50
    finally:
        ctx.prec = before


def test_where_flights_may_be_long_it_is_said(tmp_path):
    """The spring of the classical impact oscillator rests above a part of its wall."""
    result = camcli.orbits(load_scene("configs/eccentric.yaml", {"orbits.all.impacts": 1}))
    assert not result.complete
    assert any("flights may be long" in note for note in result.notes)
    assert not result.files, "a proof without a statement"


@pytest.mark.parametrize(
    ("restitution", "why"),
    [(1.0, "nothing bounds the rates"), (0.0, "no impact leaves the cam at a rate above zero")],
)
def test_where_no_bound_of_the_rates_exists_nothing_is_proved(restitution, why):
    changes = {"orbits.all": {"impacts": 1, "turns": 1}, "orbits.at": 700.0}
    scene = load_scene(None, {**changes, "follower.restitution": restitution})
    result = camcli.orbits(scene)
    assert not result.complete
    assert any(why in note for note in result.notes)


@pytest.mark.ci
def test_an_oscillator_is_told_that_its_stop_presses_too_little():
    """Without the stop x = cos(2 t + phase)/sqrt((1 - 4)^2 + (0.1 2)^2), an amplitude of 0.3326."""
    cam = {"kind": "oscillator", "damping": 0.1, "frequency": 2}
    follower = {"restitution": 0.8}
    for clearance, pressed in ((-0.32, False), (-0.345, True)):
        scene = load_scene({"cam": cam | {"clearance": clearance}, "follower": follower})
        notes = camcli.orbits(scene, all=(1, 1)).notes
        assert any("the stop presses too little" in note for note in notes) != pressed


def test_of_a_cam_with_lash_nothing_is_said(tmp_path):
    result = camcli.orbits(load_scene("configs/valve-lash.yaml", {"orbits.all.impacts": 1}))
    assert not result.complete
    assert any("the slope of the cam jumps" in note for note in result.notes)


def test_where_there_is_none_that_is_a_theorem_too(checked_all, tmp_path):
    """At 190 rpm no flight is as long as a turn; the chatter there rests on the cam."""
    result = camcli.orbits(scene_of(1, 1, 190.0))
    code, text = checked_all(certificate(result, tmp_path / "out"))
    assert code == 0
    assert "are 0: none" in text


@pytest.mark.parametrize(
    ("stiffness", "damping"),
    [
        (1.0, 1.0),
        (2.0, 2.0**0.5),  # as near as doubles are to it
        (1.0 + 2.0**-33, 1.0 + 2.0**-34),  # b^2 - 4 k m is 2^-68
        (1.0, 1.0 + 2.0**-30),
        (1.0, 1.0 - 2.0**-19),
    ],
)
def test_near_critical_damping_all_are_found_as_soon_as_elsewhere(
    stiffness, damping, checked_all, tmp_path
):
    """Of a mass of 0.25 kg, at which 4 m k is the stiffness in N/m."""
    cam = {"kind": "eccentric", "base": 0.1, "lift": 0.2}
    follower = {"mass": 0.25, "stiffness": stiffness, "damping": damping, "preload": 5.0}
    scene = {"follower": {**follower, "restitution": 0.5}, "cam": cam, "run": {"rpm": 100}}
    result = camcli.orbits(load_scene(scene, {"run.work_budget": 200000}), all=(1, 1))
    assert result.complete, result.notes
    code, text = checked_all(certificate(result, tmp_path))
    assert code == 0, text
