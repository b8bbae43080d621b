"""The checker's statements on all orbits, on chaos and on rest, and its cams with steps and seats.

What is left out is given by stand-ins; numbers are chosen by hand.
"""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli import check
from tests.support.checker import refusal, source


@pytest.fixture(autouse=True)
def digits(monkeypatch):
    monkeypatch.setattr(ctx, "prec", check.BITS)


def part(start, end, *polynomial, **more) -> check.Stretch:
    """A stretch of a cam, by powers of the angle from its start."""
    coefficients = [x if isinstance(x, arb_series) else arb(x) for x in polynomial]
    return check.Stretch(arb(start), arb(end), arb(start), coefficients, **more)


# -- steps and seats


USUAL = {"polynomial": (3,), "wave": (1, 2, 1), "circle": (), "longer": 0.0, "count": 1}
ONE_WAVE = [
    ({}, True), ({"wave": (0, 2, 1)}, True), ({"count": 2}, False), ({"wave": ()}, False),
    ({"wave": (1, 2, 2)}, False), ({"polynomial": (3, 1)}, False), ({"circle": (1, 2)}, False),
    ({"longer": 0.001}, False), ({"longer": -0.001}, False), ({"longer": 2.0**-191}, False),
    ({"longer": 2.0**-191, "wave": (0, 0.25, 1)}, True),
    ({"longer": 2.0**-191, "wave": (0, -2, 1)}, False),
    ({"longer": 2.0**-191, "wave": (-2, 0, 1)}, False),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "expected"), ONE_WAVE)
def test_which_cam_is_one_wave(changes, expected):
    """longer: by what the stretch is more than a turn; times the height it is below 2^-192."""
    given = {**USUAL, **changes}
    numbers = ([arb(x) for x in given[key]] for key in ("polynomial", "wave", "circle"))
    one = check.Stretch(arb(0), 2 * arb.pi() + given["longer"], arb(0), *numbers)
    assert check.is_one_wave([one] * given["count"]) == expected


def test_a_step_has_its_terms_in_the_number_that_varies():
    """At the start of the turn and between two stretches; a step that does not vary has one."""
    p = check.sloped(arb(3), arb(1))
    stretches = [part(0, 2, 5, p), part(2, 3, 7, 1), part(3, 4, 8 + p, 0)]
    first, second, third = check.steps(stretches, 2)
    assert first == [5 - 11, -1]  # behind the last stretch, at 8 + p
    assert second == [7 - 11, -2]  # behind 5 + 2 p
    assert third == [8 + 3 - 8, 1]
    fixed = check.steps([part(0, 2, 5, 1), part(2, 3, 9)], 3)
    assert fixed == [[-4, 0, 0], [2, 0, 0]]


@pytest.mark.parametrize(
    ("step", "half", "refused"),
    [("0", "0.1", False), ("p - 3", "0.1", True), ("(p - 3)*(p - 3)*1e-40", "0.1", False),
     ("(p - 3)*(p - 3)", "0.001", True), ("(p - 3)*0.001", "0", False),
     ("1e-57*(p - 3)", "1", False), ("1e-57*(p - 3)", "2", True),
     ("1000*1e-57*((p - 3) - (p - 3)*(p - 3))", "1", True)],
)  # fmt: skip
def test_a_cam_has_no_step_at_any_value_of_its_number(step, half, refused):
    """Of three stretches, of which the middle one is higher; by less than 2^-192 is no step."""
    step = step.replace("1e-40", "tiny").replace("1e-57", "small").replace("0.001", "1/1000")
    numbers = {"p": Fraction(3), "tiny": Fraction(1, 10**60), "small": Fraction(1, 10**58)}
    cam = check.Cam(
        source({"end": "3"}, {"end": "4", "polynomial": [f"1 + {step}"]}, {"end": "2*pi"},
               numbers=numbers)
    )  # fmt: skip
    orbit = Made(parameters=("cam.p",), cam=cam, values=lambda hull: hull[-1:])
    hull = [arb(1), arb(2), arb(3, half)]
    why = refusal(check.without_steps, orbit, Made(hull=hull))
    assert why == ("the cam may have a step" if refused else "")
    orbit.parameters = ("rpm",)
    assert refusal(check.without_steps, orbit, Made(hull=hull)) == ""


@pytest.mark.parametrize("wave", [True, False])
def test_over_two_numbers_of_a_cam_a_wave_alone_has_no_step(wave):
    numbers = {"p": Fraction(3), "q": Fraction(5)}
    row = {"end": "2*pi", "wave": ["p", "q", "1"]} if wave else {"end": "2*pi"}
    orbit = Made(parameters=("cam.p", "cam.q"), cam=check.Cam(source(row, numbers=numbers)),
                 values=lambda hull: hull)  # fmt: skip
    why = refusal(check.without_steps, orbit, Made(hull=[arb(3, 1), arb(5, 2)]))
    known = "whether this cam has a step is not known over two of its numbers"
    assert why == ("" if wave else known)


RISES = {  # a polynomial by the angle from 0 to 1, and whether it is above a height of 0.999999
    "rises": ((1, 1), True), "falls": ((1, -1), False), "falls to it": ((2, -1), True),
    "rises with slope zero": ((1, 0, 1), True), "falls with slope zero": ((1, 0, -1), False),
    "with slope and curvature zero": ((1, 0, 0, 1), True), "of order four": ((1, 0, 0, 0, 1), True),
    "from the end": ((2, -2, 1), True), "from the end, of order three": ((2, -3, 3, -1), True),
    "falls to below": ((1.5, -1), False), "from below": ((0.5, 1), False),
    "falls first and rises from there": ((2, 0, -0.75, 0.1), True),
    "falls too far first": ((2, 0, -2.5, 1.0), False),
}  # fmt: skip


@pytest.mark.parametrize(("polynomial", "above"), RISES.values(), ids=RISES)
@pytest.mark.parametrize("start", [0, 2])
def test_a_cam_rises_from_a_height_at_one_of_its_ends(polynomial, above, start):
    stretch = part(start, start + 1, *polynomial)
    height = arb("0.999999")
    assert check.rises_from(stretch, stretch.start, stretch.end, height) == above


# -- all orbits


def small(impacts=1, turns=1, **changes) -> Made:
    given = {
        "constants": {"rpm": None, "mass": 2}, "strobe": Fraction(5), "parameter": "rpm",
        "low": Fraction(700), "high": Fraction(700), "impacts": ["impact"] * impacts,
        "turns": turns,
    }  # fmt: skip
    return Made(**{**given, **changes})


def all_orbits(*orbits, covers=((1, 1), (2, 1), (1, 2), (2, 2), (1, 3), (2, 3))) -> Made:
    return Made(
        constants={"rpm": Fraction(700), "mass": 2}, strobe=Fraction(5), impacts=2, turns=3,
        orbits=list(orbits), covers=[Made(impacts=a, turns=b) for a, b in covers],
    )  # fmt: skip


ANOTHER = "an orbit is one of another machine"
SPEED = "an orbit is one of another speed"
LARGER = "an orbit is larger than those that are covered"
TWICE = "an orbit may stand there twice"
MISSING = "a cover is missing"
ALL = [
    ([], {}, ""), ([small()], {}, ""), ([small(2, 3), small()], {}, ""),
    ([small(constants={"rpm": None, "mass": 3})], {}, ANOTHER),
    ([small(constants={"rpm": Fraction(700), "mass": 2})], {}, ANOTHER),
    ([small(strobe=Fraction(6))], {}, ANOTHER), ([small(parameter="mass")], {}, ANOTHER),
    ([small(), small(strobe=Fraction(6))], {}, ANOTHER),
    ([small(low=Fraction(699), high=Fraction(701))], {}, ""),
    ([small(low=Fraction(701), high=Fraction(702))], {}, SPEED),
    ([small(low=Fraction(698), high=Fraction(699))], {}, SPEED),
    ([small(3)], {}, LARGER), ([small(1, 4)], {}, LARGER), ([small(2, 3)], {}, ""),
    ([small(), small(2), small()], {}, TWICE), ([small(2), small(), small()], {}, TWICE),
    ([], {"covers": ((1, 1), (2, 1), (1, 2), (2, 2), (1, 3))}, MISSING),
    ([], {"covers": ((1, 1), (1, 2), (2, 1), (2, 2), (1, 3), (2, 3))}, MISSING),
    ([], {"covers": ()}, MISSING),
]  # fmt: skip


@pytest.mark.parametrize(("orbits", "more", "why"), ALL)
def test_all_orbits_are_of_one_machine_and_none_stands_there_twice(monkeypatch, orbits, more, why):
    calls: list = []
    monkeypatch.setattr(check, "possible", lambda *given: calls.append(given))
    monkeypatch.setattr(check, "check_orbit", lambda *given: calls.append(given))
    monkeypatch.setattr(
        check, "may_be_one", lambda one, other: len(one.impacts) == len(other.impacts)
    )
    monkeypatch.setattr(check, "Machine", lambda cam, constants: ("machine", constants))

    def cover_of(machine):
        ctx.prec = 64
        return "cover", machine

    monkeypatch.setattr(check, "PhaseCover", cover_of)
    monkeypatch.setattr(check, "check_cover", lambda *given: calls.append(given))
    given = all_orbits(*orbits, **more)
    cam = Made(kind="arcs", stretches=[Made(seat=False)])
    assert refusal(check.check_all, cam, given) == why
    assert ctx.prec == check.BITS
    if not why:
        cover = ("cover", ("machine", given.constants))
        assert calls == [
            (given.constants, ()), *((cam, one) for one in orbits),
            *((cover, one, given.orbits) for one in given.covers),
        ]  # fmt: skip


def covered(boxes: str, known=(), empty=lambda box: True, alone=lambda box, way: True) -> tuple:
    """What is said of a cover of one impact in two turns, on two stretches; and what is asked."""
    asked: list = []
    flights = Made(
        stretches=[0, 1],
        empty=lambda box, turns: asked.append((".", box[0], turns)) or empty(box[0]),
        alone=lambda box, turns, way: asked.append(("o", box[0], turns, way)) or alone(box[0], way),
    )
    given = Made(impacts=1, turns=2, boxes=boxes, orbits=list(known))
    return refusal(check.check_cover, flights, given, ["first", "second"]), asked


def test_a_cover_is_gone_through_box_by_box(monkeypatch):
    """Two stretches; the first is cut in half, and the first half of that once more."""
    ways = {"first": ["way 1", "way 2"], "second": ["way 3"]}
    monkeypatch.setattr(check, "ways", lambda orbit, *numbers: [*ways[orbit], numbers])
    answer, asked = covered("11..o.", [1], alone=lambda box, way: way == "way 3")
    assert answer == ""
    assert asked == [
        (".", (0, 2, 0), 2), (".", (0, 2, 1), 2), ("o", (0, 1, 1), 2, "way 3"), (".", (1, 0, 0), 2),
    ]  # fmt: skip
    answer, asked = covered("oo", [0, 1], alone=lambda box, way: way in ("way 2", (1, 2, 2)))
    assert answer == ""
    assert [row[3] for row in asked] == ["way 1", "way 2", "way 3", (1, 2, 2)]
    hold = "a box may hold another orbit than the one it names"
    assert covered("oo", [0, 1], alone=lambda box, way: way == "way 2")[0] == hold
    assert covered("..", empty=lambda box: box[0] == 0)[0] == "a box of a cover may hold an orbit"


@pytest.mark.parametrize(
    ("boxes", "known", "why"),
    [
        ("..", [], ""), (".", [], "boxes are missing in a cover"),
        ("1..", [], "boxes are missing in a cover"), ("...", [], "a cover has too many boxes"),
        ("..", [0], "a cover has too many boxes"), ("o.", [1], ""),
        ("o.", [], "a box names an orbit that is not there"),
        ("o.", [2], "a box names an orbit that is not there"),
        ("2..", [], "a box is cut along a phase that it has not"),
    ],
)  # fmt: skip
def test_a_cover_has_its_boxes_and_no_more(monkeypatch, boxes, known, why):
    monkeypatch.setattr(check, "ways", lambda *given: ["way"])
    assert covered(boxes, known)[0] == why


# -- boxes of impacts


def box(middle, axes) -> Made:
    return Made(middle=[arb(x) for x in middle], axes=[arb(x) for x in axes])


def test_a_point_and_a_box_in_units_of_a_box():
    """M = [[2, 1], [0, 4]] about (1, 2)."""
    one = box((1, 2), (2, 1, 0, 4))
    assert check.within(one, [arb(1) + 2 * 3 + 5, arb(2) + 4 * 5]) == arb_mat([[3], [5]])
    # another one, M [[-1/2, 1/4], [0, -1/2]], of half the width in y and three quarters in x
    axes = (-1, 0, 0, -2)
    for x, y, apart in (("1.74", 0, False), ("1.76", 0, True), ("-1.76", 0, True),
                        (0, "1.49", False), (0, "-1.51", True), (0, "1.51", True)):  # fmt: skip
        at = (arb(1) + 2 * arb(x) + arb(y), arb(2) + 4 * arb(y))
        assert check.beside(one, Made(middle=list(at), axes=[arb(a) for a in axes])) == apart


def falls(phase: arb) -> Made:
    """A gap that is zero at 2 and falls there, (2 - x)(1 + x)."""
    return Made(gap=(2 - phase) * (1 + phase), rate=1 - 2 * phase)


@pytest.mark.parametrize(
    ("landings", "found"), [((1.5, 2.25), True), ((2.125, 2.5), False), ((1.25, 1.875), False)]
)
def test_a_landing_is_found_where_it_is_said_to_be(landings, found):
    asked = []

    def flight(machine, z, k, phase):
        asked.append((machine, z, k))
        return falls(phase)

    low, high = map(arb, landings)
    phase = check.landing(Made(flight=flight), "machine", "z", 7, low.union(high))
    assert set(asked) == {("machine", "z", 7)}
    if found:
        assert phase.contains(2)
        assert phase.rad() < 1e-6
    else:
        assert phase is None


def test_every_cell_of_a_box_has_its_middle_its_ends_and_its_slopes(monkeypatch):
    """Three along x and two along y of a box about (10, 20), M = [[3, 1], [0, 6]].

    The map has the slopes [[2, 1], [0, 4]]; it is asked twice, over all landings given and over
    those that follow. A landing at 30 leaves at r times 5.
    """
    checked: list = []
    asked: list = []
    monkeypatch.setattr(check, "check_cell_flight", lambda *given: checked.append(given))
    monkeypatch.setattr(check, "landing", lambda orbit, machine, z, k, at: (
        checked.append((z, k, at)) or arb(30)))  # fmt: skip
    monkeypatch.setattr(check, "impact_map", lambda flight: flight)

    def flight(machine, z, k, end=None):
        asked.append((z, end))
        if end is not None:
            return Made(r=arb("0.5"), rate=arb(-5))
        return check.ImpactSlopes(arb(2), arb(1), arb(0), arb(4))

    orbit = Made(machine=lambda p: ("machine", p), flight=flight)
    flights = [Made(low=arb(29), high=arb(31 + k)) for k in range(6)]
    one = Made(middle=[arb(10), arb(20)], axes=[arb(x) for x in (3, 1, 0, 6)], cells=[3, 2],
               flights=flights)  # fmt: skip
    found = list(check.cells(orbit, one, "p"))
    for number, cell in enumerate(found):
        x, y = (Fraction(-2, 3), Fraction(0), Fraction(2, 3))[number // 2], Fraction(-1, 2)
        y += number % 2
        middle = (10 + 3 * x + y, 20 + 6 * y)
        (_, machine, given, spread, cuts, p), (same, k, at) = checked[2 * number : 2 * number + 2]
        assert (machine, p, k) == (("machine", "p"), "p", 0)
        assert cuts is flights[number]
        assert same is given
        assert all(abs(a - check.ball_of(b)) < 1e-60 for a, b in zip(given, middle, strict=True))
        assert abs(arb(at.rad()) - (2 + number) / 2) < 1e-6
        # 3 times a third and a half; 6 times a half
        assert all(abs(arb(a.rad()) - b) < 1e-6 for a, b in
                   zip(spread.entries(), (1.5, 3.0), strict=True))  # fmt: skip
        assert cell.image == (30, arb("2.5"))
        assert cell.slopes == arb_mat([[6, 8], [0, 24]])  # of the map, times M
        assert all(abs(arb(a.rad()) - b) < 1e-6 for a, b in
                   zip(cell.reach, (1 / 3, 0.5), strict=True))  # fmt: skip
        ends = {0: [-1], 1: [], 2: [1]}[number // 2]
        assert all(abs(3 * a - b) < 1e-60 for a, b in zip(cell.ends, ends, strict=True))
        (_, end), (rough, _), (sharp, _) = asked[3 * number : 3 * number + 3]
        assert end == 30
        assert rough is sharp  # the one list, whose landings were made sharper
        assert abs(arb(sharp[2].rad()) - (2 * 1.5 + 3.0)) < 1e-6
        assert abs(arb(sharp[0].rad()) - 1.5) < 1e-6
        assert abs(arb(sharp[1].rad()) - 3.0) < 1e-6
    one.cells = [1, 6]
    both = [cell.ends for cell in check.cells(orbit, one, "p")]
    assert both == [[-1, 1]] * 6


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({}, ""), ({"spread": ("0.125", "0.5")}, "an impact may not bounce"),
        ({"spread": ("0.6", "0.25")}, "a flight may begin or land outside its stretch of the cam"),
        ({"low": arb("0.9")}, "a flight may begin or land outside its stretch of the cam"),
        ({"high": arb("3.1")}, "a flight may begin or land outside its stretch of the cam"),
        ({"gaps": ("0.29", "-0.31")}, "a flight may not land between the phases that are given"),
        ({"gaps": ("0.31", "-0.29")}, "a flight may not land between the phases that are given"),
    ],
)  # fmt: skip
def test_all_flights_from_a_cell_bounce_and_land_between_two_phases(changes, why):
    """From (0.5, 0.4) in the first stretch to the second; a gap changes by 0.125 and 0.7 0.25."""
    known = {"spread": ("0.125", "0.25"), "low": arb("1.5"), "high": arb("2.5"),
             "gaps": ("0.31", "-0.31"), **changes}  # fmt: skip
    calls: list = []

    def flight(machine, z, k, end):
        calls.append((z, end))
        gap = arb(known["gaps"][0] if end < 2 else known["gaps"][1])
        return Made(gap=gap, gap_by_theta=arb(1), gap_by_v=arb("0.7"))

    machine = Made(stretches=[Made(start=arb(0), end=arb(1)), Made(start=arb(1), end=arb(3))])
    orbit = Made(places=[Made(stretch=0), Made(stretch=1)], flight=flight,
                 clear=lambda *given: calls.append(given))  # fmt: skip
    middle = [arb("0.5"), arb("0.4")]
    spread = arb_mat([[arb(0, x)] for x in known["spread"]])
    cuts = Made(low=known["low"], high=known["high"])
    assert refusal(check.check_cell_flight, orbit, machine, middle, spread, cuts, "p") == why
    if why:
        return
    (z, k, given), *asked = calls
    assert (k, z[3], z[4]) == (0, 1, "p")
    assert given is cuts
    for x, at, radius in zip(z, (0.5, 0.4, 2.0), (0.125, 0.25, 0.5), strict=False):
        assert abs(x.mid() - at) < 1e-9
        assert abs(arb(x.rad()) - radius) < 1e-6
    assert [(one is middle, float(end)) for one, end in asked] == [
        (True, 1.5), (False, 1.5), (True, 2.5), (False, 2.5),
    ]  # fmt: skip


def test_the_flights_of_a_box_last_for_the_turns_of_their_landing_at_all_parameters(monkeypatch):
    asked: list = []
    monkeypatch.setattr(check, "Orbit", lambda *given: asked.append(given) or "orbit")
    monkeypatch.setattr(check, "cells", lambda *given: asked.append(given) or [])
    lands = Made(stretch=4, turn=2)
    given = Made(boxes=[None, Made(stretch=3, lands=lands)], parameter="mass", low=Fraction(1),
                 high=Fraction(3), constants="constants")  # fmt: skip
    check.check_covers("cam", given, 1, [])
    cam, constants, parameters, places, turns = asked[0]
    assert (cam, constants, parameters, turns) == ("cam", "constants", ("mass",), 3)
    assert [(one.stretch, one.turn) for one in places] == [(3, 0), (4, 2)]
    orbit, one, p = asked[1]
    assert (orbit, one) == ("orbit", given.boxes[1])
    assert p.mid() == 2
    assert abs(arb(p.rad()) - 1) < 1e-6


@pytest.mark.parametrize(
    ("growth", "weights", "why"),
    [
        ("1.5", (1, 2), ""), ("1.51", (1, 2), "the number of sequences may grow more slowly"),
        ("1.5", (2, 1), "the number of sequences may grow more slowly"),
        ("1", (1, 2), "the number of sequences does not grow"), ("1.01", (1, 1), ""),
        ("1.5", (1, 2, 3), "it has not its weights"),
    ],
)  # fmt: skip
def test_how_fast_the_number_of_sequences_grows(monkeypatch, growth, weights, why):
    """The first box covers the second one, and that both: by 3/2 with the weights 1 and 2.

    With equal weights by 1 from the first box and by 2 from the other.
    """
    calls: list = []
    monkeypatch.setattr(check, "check_covers", lambda *given: calls.append(given[2:]))
    boxes = [Made(middle=[arb(1)] * 2, axes=[arb(x) for x in (1, 0, 0, 1)], stretch=k)
             for k in range(2)]  # fmt: skip
    given = Made(boxes=boxes, low=Fraction(1), high=Fraction(1), coverings=[[1, 1], [0, 1], [1, 0]],
                 weights=[Fraction(x) for x in weights], growth=Fraction(growth))  # fmt: skip
    if weights == (1, 1):
        given.coverings.append([0, 0])
    assert refusal(check.check_chaos, "cam", given) == why
    assert calls == [(0, [0, 1] if weights == (1, 1) else [1]), (1, [0, 1])]


# -- rest


LOADS = {"mass": Fraction(2), "stiffness": Fraction(3), "damping": Fraction(5),
         "gravity": Fraction(7), "preload": Fraction(11)}  # fmt: skip


def test_the_force_of_contact_is_that_of_all_of_its_parts():
    force = check.ContactForce(LOADS)
    c = [arb(13), arb(17), arb(19)]
    assert force.at(arb(23), c) == 3 * 13 + 2 * 7 + 11 + 23 * 5 * 17 + 23 * 23 * 2 * 19
    assert force.of_lift(arb(23), c) == 3 * 13 + 23 * 5 * 17 + 23 * 23 * 2 * 19
    assert force.damped
    assert not check.ContactForce({**LOADS, "damping": Fraction(0)}).damped


@pytest.mark.parametrize(
    ("at_rest", "by_speed", "by_square", "damping", "presses"),
    [
        (10, 1, 1, 1, True), (1, 1, "-0.2", 1, True), (1, 1, "-0.4", 1, False),
        (-1, 1, 1, 1, False), (1, -3, 1, 1, False), (1, -3, 1, 0, True),
        (20, "-0.5", 1, 1, True), (1, 0, "-0.05", 0, True), (1, 0, "-0.07", 0, False),
        (1, -1, "0.25", 1, False), (-1, 0, 1, 0, False),
    ],
)  # fmt: skip
def test_a_follower_is_pressed_at_every_speed_up_to_the_last_one(
    at_rest, by_speed, by_square, damping, presses
):
    """N = a + b omega + c omega^2 up to omega = 4, along a very short part of the cam."""
    known = {**LOADS, "mass": Fraction(1), "stiffness": Fraction(1), "gravity": Fraction(0),
             "preload": Fraction(5), "damping": Fraction(damping)}  # fmt: skip
    stretch = part(0, 1, arb(at_rest) - 5, arb(by_speed), arb(by_square) / 2)
    force = check.ContactForce(known)
    assert force.presses(stretch, arb(0), arb(2) ** -30, arb(4)) == presses


@pytest.mark.parametrize(
    ("polynomial", "presses"),
    [
        (("0.1", 1), True), (("-0.1", 1), False), (("1.1", -1), True), (("0.9", -1), False),
        (("1.25", -1, 1), True), (("0.6", -1, 1), False), (("0.5", "0.3", "-0.9"), False),
    ],
)  # fmt: skip
def test_a_follower_is_pressed_all_along_a_part(polynomial, presses):
    """The force is the lift: it rises, falls, or is above zero by the mean value theorem."""
    known = {**LOADS, "mass": Fraction(1, 10**9), "stiffness": Fraction(1), "gravity": Fraction(0),
             "preload": Fraction(0), "damping": Fraction(0)}  # fmt: skip
    force = check.ContactForce(known)
    assert force.presses(part(0, 1, *polynomial), arb(0), arb(1), arb(1)) == presses


@pytest.mark.parametrize("least", ["0.1", "-0.1"])
@pytest.mark.parametrize("falling", [False, True])
def test_at_the_last_speed_the_force_is_least_at_an_end(falling, least):
    """N = 3 + c'' at 1 rad/s, with a slope that goes from 0.1 to 3 m/rad^3, or backwards."""
    start = arb(least)
    if falling:  # with (1 - x) for x: 3 + c'' = start + 0.1 (1 - x) + 1.45 (1 - x)^2
        bend = (start + arb("1.55") - 3, -3, arb("1.45"))
    else:
        bend = (start - 3, arb("0.1"), arb("1.45"))
    polynomial = [arb(0), arb(0), bend[0] / 2, arb(bend[1]) / 6, bend[2] / 12]
    known = {**dict.fromkeys(LOADS, Fraction(0)), "mass": Fraction(1), "preload": Fraction(3)}
    force = check.ContactForce(known)
    stretch = part(0, 1, *polynomial)
    assert force.presses(stretch, arb(0), arb(1), arb(1)) == (least == "0.1")


def detachment(monkeypatch, presses=lambda *given: True, **changes):
    """A statement on a cam of two stretches, whose force at the higher speed is -c''."""
    asked: list = []

    class Force:
        def __init__(self, known):
            asked.append(known)

        def presses(self, stretch, start, end, omega):
            asked.append((stretch, float(start), float(end), omega))
            return presses(float(start))

        def at(self, omega, c):
            asked.append((omega, *map(float, c)))
            return -c[2]

    monkeypatch.setattr(check, "ContactForce", Force)
    monkeypatch.setattr(check, "resting", lambda cam, given: "constants")
    # c'' is 2 + 6 x on the first and -4 - 6 x on the second
    cam = Made(stretches=[part(0, 2, 0, 0, 1, 1), part(2, 5, 0, 0, -2, -1)])
    given = {"cuts": [[arb(1)], [arb(3), arb(4)]], "low": Fraction(30), "high": Fraction(60),
             "stretch": 0, "at_end": True}  # fmt: skip
    return cam, Made(**{**given, **changes}), asked


def test_a_follower_at_rest_is_pressed_on_every_part_and_not_at_one_place(monkeypatch):
    cam, given, asked = detachment(monkeypatch)
    assert refusal(check.check_detachment, cam, given) == ""
    low, high = arb.pi(), 2 * arb.pi()
    ends = [(0, 0.0, 1.0), (0, 1.0, 2.0), (1, 2.0, 3.0), (1, 3.0, 4.0), (1, 4.0, 5.0)]
    assert asked[0] == "constants"
    assert [(cam.stretches.index(a), b, c) for a, b, c, _ in asked[1:6]] == ends
    assert all(abs(omega - low) < 1e-60 for *_, omega in asked[1:6])
    omega, *c = asked[6]
    assert abs(omega - high) < 1e-60
    assert c == [12.0, 16.0, 14.0]  # at the end of the first stretch


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"at_end": False}, ""),
        ({"stretch": 1}, "the force may not end"),
        ({"stretch": 1, "at_end": False}, "the force may not end"),
        ({"stretch": 2}, "the cam has no such stretch"),
        ({"cuts": [[]]}, "not every stretch has its cuts"),
        ({"cuts": [[], [], []]}, "not every stretch has its cuts"),
        ({"cuts": [[arb(1), arb(1)], []]}, "the cuts of a stretch do not follow one another"),
        ({"cuts": [[], [arb(1)]]}, "the cuts of a stretch do not follow one another"),
        ({"cuts": [[], [arb(5)]]}, "the cuts of a stretch do not follow one another"),
        ({"presses": lambda start: start != 4.0}, "the force may end at a lower speed"),
        ({"presses": lambda start: start != 1.0}, "the force may end at a lower speed"),
    ],
)
def test_what_is_wrong_with_a_first_detachment(monkeypatch, changes, why):
    cam, given, _ = detachment(monkeypatch, **changes)
    assert refusal(check.check_detachment, cam, given) == why


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({}, ""), ({"low": Fraction(0)}, "its range is empty"),
        ({"low": Fraction(2)}, "its range is empty"), ({"low": Fraction(3)}, "its range is empty"),
        ({"slope": "0.1"}, "the slope of the cam jumps"),
        ({"rpm": Fraction(100)}, "exactly the parameter has to be left open"),
    ],
)  # fmt: skip
def test_a_follower_can_rest_on_a_cam_without_a_kink(changes, why):
    known = {"rpm": changes.get("rpm"), "mass": Fraction(2)}
    given = Made(constants=known, low=changes.get("low", Fraction(1)), high=Fraction(2))
    cam = Made(kind="arcs", stretches=[part(0, 1, 1, 0), part(1, 2, 1, changes.get("slope", 0))])
    assert refusal(check.resting, cam, given) == why
    if not why:
        assert check.resting(cam, given) is known


@pytest.mark.parametrize(
    ("before", "behind", "leaves"),
    [("0.1", "-0.1", True), ("-0.1", "-0.1", False), ("0.1", "0.1", False), (0, "-0.1", False),
     ("0.1", 0, False)],
)  # fmt: skip
@pytest.mark.parametrize("start", [0, 1])
def test_a_follower_leaves_where_it_is_pressed_before_and_not_behind(before, behind, leaves, start):
    """Its acceleration is -(c + 2 c'): c'' lies so much above that, or below."""

    def stretch(more, at):
        c, c1 = arb(3), arb(5)
        return Made(start=arb(at), end=arb(at + 1), derivatives=lambda x, n: (
            [c, c1, -13 + arb(more)] if x == (at + 1 if more is before else at) else [c, c1, c1]
        ))  # fmt: skip

    rows = [stretch(before, 7), stretch(behind, 9)]
    machine = Made(
        stretches=rows if start == 1 else rows[::-1], acceleration=lambda q, w: -(q + 2 * w)
    )
    why = refusal(check.lifts_off, machine, start)
    assert why == ("" if leaves else "the follower may not leave there")


def corner_hit(monkeypatch, **changes):
    """A statement on two impacts behind lift-off; what is asked for and left out is told."""
    calls: list = []
    given = {
        "start": 1, "impacts": [Made(stretch=0, turn=2), Made(stretch=1, turn=2)],
        "corner": Made(stretch=0, turn=3), "flights": ["a", "b", "c"], "constants": "constants",
        "low": Fraction(120), "high": Fraction(122),
        "gaps": {121: arb(0), 120: arb(1), 122: arb(-1)}, "slope": arb(2),
    }  # fmt: skip
    statement = Made(**{**given, **changes})
    orbit = Made(n=4, machine=lambda rpm: ("machine", float(rpm.mid())),
                 clear=lambda *asked, lifts: calls.append((*asked, lifts)))  # fmt: skip
    monkeypatch.setattr(check, "resting", lambda *asked: None)
    monkeypatch.setattr(check, "Orbit", lambda *asked: calls.append(asked) or orbit)
    monkeypatch.setattr(check, "lifts_off", lambda *asked: calls.append(asked))
    z = [arb(x) for x in (0, 0, "0.5", "0.25", "1.5", "0.125", 1, 0)]

    def flown(orbit, said, rpm):
        gap = check.sloped(statement.gaps[int(float(rpm.mid()))], statement.slope)
        return Made(unknowns=z, landings=[arb("0.75"), arb("1.75"), arb(1)], gap=gap)

    monkeypatch.setattr(check, "flown", flown)
    cam = Made(stretches=[Made(start=arb(0), end=arb(1)), Made(start=arb(1), end=arb(2))])
    return cam, statement, calls, z


def test_every_flight_to_a_corner_is_shown_with_its_landings(monkeypatch):
    cam, statement, calls, z = corner_hit(monkeypatch)
    assert refusal(check.check_corner_hit, cam, statement) == ""
    asked, lift_off, *flights = calls
    assert asked[:3] == (cam, "constants", ("rpm",))
    assert [(one.stretch, one.turn) for one in asked[3]] == [(1, 0), (0, 2), (1, 2), (0, 3)]
    assert asked[4] == 4  # turns
    assert lift_off == (("machine", 121.0), 1)
    for k, (hull, number, cuts, lifts) in enumerate(flights):
        expected = list(z)
        expected[2 * k + 2] = (arb("0.75"), arb("1.75"), arb(1))[k]
        assert all(abs(x - y) < 1e-60 for x, y in zip(hull, expected, strict=False))
        assert hull[-1].contains(120)
        assert hull[-1].contains(122)
        assert len(hull) == 9
        assert (number, cuts, lifts) == (k, "abc"[k], k == 0)
    assert len(flights) == 3


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"gaps": {121: arb(0), 120: arb(-1), 122: arb(1)}, "slope": arb(-2)}, ""),
        ({"gaps": {121: arb(0), 120: arb(1), 122: arb(1)}}, "the corner may not be met"),
        ({"gaps": {121: arb(0), 120: arb(-1), 122: arb(-1)}}, "the corner may not be met"),
        ({"gaps": {121: arb(0), 120: arb(1), 122: arb(0, 1)}}, "the corner may not be met"),
        ({"gaps": {121: arb(0), 120: arb(0, 1), 122: arb(1)}}, "the corner may not be met"),
        ({"slope": arb(0, 1)}, "the corner may be met at several speeds"),
        ({"slope": arb(0)}, "the corner may be met at several speeds"),
        ({"flights": ["a", "b"]}, "not every impact has its flight"),
        ({"flights": ["a", "b", "c", "d"]}, "not every impact has its flight"),
        ({"start": 2}, "the cam has no such stretch"),
        ({"corner": Made(stretch=2, turn=3)}, "the cam has no such stretch"),
    ],
)
def test_what_is_wrong_with_a_corner_that_is_hit(monkeypatch, changes, why):
    cam, statement, _, _ = corner_hit(monkeypatch, **changes)
    assert refusal(check.check_corner_hit, cam, statement) == why


DROP = (  # level up to 1 rad, down by x^2 up to 1.5 rad, level at -1/2 up to 3 rad
    {"end": "1", "polynomial": ["0"]},
    {"end": "1.5", "center": "1", "polynomial": ["0", "0", "-1"]},
    {"end": "3", "polynomial": ["-0.5"]}, {"end": "2*pi", "polynomial": ["0"]},
)  # fmt: skip


@pytest.mark.parametrize("restitution", ["0.5", "0.75"])
def test_a_motion_to_a_corner_has_its_slope_by_the_speed(restitution):
    """It leaves at 1 rad and falls by 1/2 within omega rad, so that it lands at 2 rad at 1 rad/s.

    There it bounces with r/omega, and behind another s = 2 - omega its gap is r s/omega - (s/omega)
    ^2/2.
    """
    known = {**dict.fromkeys(check.CONSTANTS, Fraction(0)), "mass": Fraction(1), "rpm": None,
             "gravity": Fraction(1), "restitution": Fraction(restitution)}  # fmt: skip
    cam = check.Cam(source(*DROP))
    r, turn = arb(restitution), arb.pi() / 30  # rad/s of an rpm
    impact = Made(stretch=2, turn=0, low=arb("1.75"), high=arb("2.5"))
    places = [Made(stretch=1, turn=0), impact, Made(stretch=2, turn=0)]
    orbit = check.Orbit(cam, known, ("rpm",), places, 1)
    statement = Made(start=1, impacts=[impact], corner=places[2])
    found = check.flown(orbit, statement, 1 / turn)
    wanted = (arb(1), arb(0), arb(2), r, arb(3), arb(0))
    assert all(abs(x - y) < 1e-60 for x, y in zip(found.unknowns, wanted, strict=True))
    given, corner = found.landings
    assert abs(given.mid() - 2.125) < 1e-6
    assert abs(given.rad() - 0.375) < 1e-6
    assert corner == 3
    assert abs(found.gap[0] - (r - arb("0.5"))) < 1e-60
    # s/omega = 2/omega - 1 changes by -2
    assert abs(found.gap[1] - turn * (-2 * r + 2)) < 1e-60
    why = "impact 1 may lie elsewhere"
    for low, high in (("2.125", "2.5"), ("1.75", "1.875")):
        impact.low, impact.high = arb(low), arb(high)
        assert refusal(check.flown, orbit, statement, 1 / turn) == why
        with pytest.MonkeyPatch.context() as patch:  # whatever is found between
            patch.setattr(check, "landing", lambda *given: arb(2))
            assert refusal(check.flown, orbit, statement, 1 / turn) == why
    impact.low, impact.high = arb("1.75"), arb("2.5")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "landing", lambda *given: None)
        assert refusal(check.flown, orbit, statement, 1 / turn) == why
