"""The checker's equations of an orbit and its statements, by closed forms and by stand-ins."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, ctx
from mpmath import mp, mpf

from camcli import check
from tests.support.checker import ball, near, refusal, source

STEP = arb(2) ** -100
CLOSE = arb(2) ** -80  # of differences over such a step


@pytest.fixture(autouse=True)
def digits(monkeypatch):
    """Those of the checker, and more of mpmath."""
    monkeypatch.setattr(ctx, "prec", check.BITS)
    with mp.workdps(90):
        yield


# -- flights and equations: two impacts in three turns, the second one on the seat

FORCE = {"mass": "3/2", "stiffness": "700", "damping": "11", "gravity": "9", "preload": "13",
         "restitution": "3/4", "rpm": None}  # fmt: skip
NUMBERS = {"lift": Fraction(1, 50), "seat": Fraction(1, 10)}
ROWS = (
    {"end": "pi", "polynomial": ["seat"], "seat": True},
    {"end": "2*pi", "center": "pi", "polynomial": ["seat", "0", "lift", "-lift/4"],
     "wave": ["lift", "lift/3", "2"]},
)  # fmt: skip
PLACES = [Made(stretch=1, turn=0), Made(stretch=0, turn=2)]
Z = [mpf("4.5"), mpf("0.25"), mpf("0.75"), mpf("0.5")]  # theta and v of both impacts
TURNS = 3


def constants(**changes) -> dict:
    known = {**FORCE, **changes}
    return {key: None if x is None else Fraction(x) for key, x in known.items()}


def orbit_of(parameters=("rpm",), changes=(), event=None, places=PLACES, turns=TURNS):
    cam = check.Cam(source(*ROWS, numbers=NUMBERS, seat_restitution=Fraction(1, 5)))
    if any(name.startswith("cam.") for name in parameters):
        cam.stretches[0].seat = False
        for row in cam.formulas_of_stretches:
            row.seat = False
    return check.Orbit(cam, constants(**dict(changes)), parameters, places, turns, event)


def height(k: int, theta: mpf) -> mpf:
    """The cam on its stretch k."""
    x, lift = theta - mp.pi, mpf(1) / 50
    lobe = lift * x**2 - lift / 4 * x**3 + lift * mp.cos(2 * x) + lift / 3 * mp.sin(2 * x)
    return mpf(1) / 10 + (lobe if k else 0)


def gap(k: int, theta: mpf, v: mpf, end: mpf) -> mpf:
    """The gap at the end of flight k, a damped oscillation in closed form."""
    omega = 10 * mp.pi
    z, square = 11 / (3 * omega), mpf(1400) / 3 / omega**2
    rest = -(9 + mpf(26) / 3) / omega**2 / square
    here, there = PLACES[k].stretch, PLACES[1 - k].stretch
    turned = 2 * mp.pi * (2 if k == 0 else TURNS - 2)
    s, f = end + turned - theta, mp.sqrt(square - z**2)
    u = height(here, theta) - rest
    rate = mp.diff(lambda x: height(here, x), theta) + v
    q = rest + mp.exp(-z * s) * (u * mp.cos(f * s) + (rate + z * u) / f * mp.sin(f * s))
    return q - height(there, end)


@pytest.mark.parametrize("k", [0, 1])
@pytest.mark.parametrize("given", [None, "1.25"])
def test_a_flight_ends_with_the_gap_and_the_slopes_of_the_closed_form(k, given):
    orbit = orbit_of()
    z = [*map(ball, Z), arb(300)]
    end = Z[2 - 2 * k] if given is None else mpf(given)
    found = orbit.flight(orbit.at(z), z, k, None if given is None else arb(given))
    at = (Z[2 * k], Z[2 * k + 1], end)
    orders = {"gap": (0, 0, 0), "rate": (0, 0, 1), "acceleration": (0, 0, 2),
              "gap_by_theta": (1, 0, 0), "gap_by_v": (0, 1, 0), "rate_by_theta": (1, 0, 1),
              "rate_by_v": (0, 1, 1)}  # fmt: skip
    for name, order in orders.items():
        wanted = mp.diff(lambda *x: gap(k, *x), at, order) if any(order) else gap(k, *at)
        assert abs(getattr(found, name) - ball(wanted)) < arb("1e-12"), name
    assert near(found.r, mpf(1) / 5 if k == 0 else mpf(3) / 4)


def test_the_turns_between_impacts_are_those_of_the_period():
    orbit = orbit_of()
    assert [near(orbit.turned(k), 2 * mp.pi * turns) for k, turns in ((0, 2), (1, 1))]
    assert near(orbit.turned(0), 4 * mp.pi)
    assert near(orbit.turned(1), 2 * mp.pi)


GRAZE = Made(event="grazing", impact=1, side=0, touch=Made(stretch=1, turn=2))
DOUBLING = Made(event="period-doubling", impact=0, side=0, touch=None)
EQUATIONS = {
    "the speed": (("rpm",), {}, None, [300]),
    "the mass": (("mass",), {"rpm": "300", "mass": None}, None, ["1.5"]),
    "the restitution": (("restitution",), {"rpm": "300", "restitution": None}, None, ["0.75"]),
    "a number of the cam": (("cam.lift",), {"rpm": "300"}, None, ["0.02"]),
    "a curve of grazes": (("rpm", "preload"), {"preload": None}, GRAZE, [300, 13, "2.5"]),
    "a curve of doublings": (("cam.lift", "rpm"), {}, DOUBLING, ["0.02", 300]),
    "a curve with a restitution": (
        ("rpm", "restitution"),
        {"restitution": None},
        DOUBLING,
        [300, "0.75"],
    ),
}


@pytest.mark.parametrize(("names", "changes", "event", "more"), EQUATIONS.values(), ids=EQUATIONS)
def test_the_equations_have_the_derivatives_that_their_differences_have(
    names, changes, event, more
):
    """By every unknown; the values are the gaps and what the impacts lose, by the closed form."""
    orbit = orbit_of(names, changes, event)
    z = [*map(ball, Z), *map(arb, more)]
    assert orbit.values(z) == z[4 : 4 + len(names)]
    values, slopes = orbit.equations(z, with_slopes=True)
    plain, none = orbit.equations(z, with_slopes=False)
    assert none is None
    size = len(z) - 1
    assert orbit.equation_count == size
    assert (slopes.nrows(), slopes.ncols()) == (size, size + 1)
    assert all(abs(x - y) < CLOSE for x, y in zip(plain.entries(), values.entries(), strict=True))
    for j in range(size + 1):
        beside = [
            orbit.equations([x + side * STEP * (i == j) for i, x in enumerate(z)], False)[0]
            for side in (-1, 1)
        ]
        for i in range(size):
            slope = (beside[1][i, 0] - beside[0][i, 0]) / (2 * STEP)
            assert abs(slope - slopes[i, j]) < CLOSE * (1 + abs(slope)), (i, j)
    for k, r in ((0, mpf(1) / 5 if not names[0].startswith("cam.") else mpf(3) / 4),
                 (1, mpf(3) / 4)):  # fmt: skip
        at = (Z[2 * k], Z[2 * k + 1], Z[2 - 2 * k])
        rate = mp.diff(lambda *x, k=k: gap(k, *x), at, (0, 0, 1))
        assert near(values[2 * k, 0], gap(k, *at))
        assert abs(values[2 * k + 1, 0] - ball(r * rate + Z[3 - 2 * k])) < arb("1e-12")


MORE_PLACES = {
    1: [Made(stretch=1, turn=1)],
    2: PLACES,
    3: [*PLACES, Made(stretch=1, turn=2)],
}
MORE_Z = [*Z, mpf("3.75"), mpf("0.375")]


@pytest.mark.parametrize("n", [1, 3])
def test_the_equations_of_one_impact_and_of_three(n):
    """By every unknown; of one impact a flight ends with the unknowns that it begins with."""
    orbit = orbit_of(places=MORE_PLACES[n])
    z = [*map(ball, MORE_Z[: 2 * n]), arb(300)]
    _, slopes = orbit.equations(z, with_slopes=True)
    for j in range(2 * n + 1):
        beside = [
            orbit.equations([x + side * STEP * (i == j) for i, x in enumerate(z)], False)[0]
            for side in (-1, 1)
        ]
        for i in range(2 * n):
            slope = (beside[1][i, 0] - beside[0][i, 0]) / (2 * STEP)
            assert abs(slope - slopes[i, j]) < CLOSE * (1 + abs(slope)), (i, j)


@pytest.mark.parametrize("n", [2, 3])
def test_the_map_of_a_period_is_the_product_of_those_of_its_flights(n):
    """By differences of its equations; of the determinant only the losses and the damper count."""
    orbit = orbit_of(places=MORE_PLACES[n])
    z = [*map(ball, MORE_Z[: 2 * n]), arb(300)]
    _, slopes = orbit.equations(z, with_slopes=True)
    whole, scale = check.identity(2), arb(1)
    for k in range(n):
        rows = here = (2 * k, 2 * k + 1)
        there = (2 * ((k + 1) % n), 2 * ((k + 1) % n) + 1)
        before = arb_mat([[slopes[i, j] for j in here] for i in rows])
        behind = arb_mat([[slopes[i, j] for j in there] for i in rows])
        one = behind.inv() * before * -1
        whole = one * whole
        flight = orbit.flight(orbit.at(z), z, k)
        scale = scale * flight.rate
        for times_rate, factor in ((False, arb(1)), (True, flight.rate)):
            found = check.impact_map(flight, times_rate).matrix()
            for x, y in zip(found.entries(), one.entries(), strict=True):
                assert abs(x - y * factor) < CLOSE
    trace, det, one = orbit.trace_det(z)
    assert one == 1
    assert abs(trace - whole[0, 0] - whole[1, 1]) < CLOSE
    lost = (mpf(3) / 4) ** (n - 1) / 5  # one of the impacts is on the seat
    assert near(det, lost**2 * mp.exp(-22 / (3 * 10 * mp.pi) * 6 * mp.pi))
    scaled, same, factor = orbit.trace_det(z, times_rates=True)
    assert abs(scaled - trace * scale) < CLOSE
    assert same.overlaps(det)
    assert abs(factor - scale) < CLOSE


def test_maps_follow_one_another():
    first, second = check.ImpactSlopes(1, 2, 3, 4), check.ImpactSlopes(5, 6, 7, 8)
    assert second.after(first) == (5 + 18, 10 + 24, 7 + 24, 14 + 32)
    assert first.matrix() == arb_mat([[1, 2], [3, 4]])
    assert check.identity(3) == arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({}, ""),
        ({"places": [], "turns": 1}, "an orbit without impacts is not checked here"),
        ({"places": [Made(stretch=2, turn=0)]}, "the cam has no such stretch"),
        ({"places": [Made(stretch=1, turn=3)]}, ""),
        ({"places": [Made(stretch=1, turn=4)]}, "an impact lies beyond the period"),
        ({"changes": {"rpm": "300"}}, "exactly the parameter has to be left open"),
        ({"changes": {"mass": None}}, "exactly the parameter has to be left open"),
    ],
)
def test_which_orbits_have_equations(change, why):
    assert refusal(lambda: orbit_of(**change)) == why


@pytest.mark.parametrize("name", check.CONSTANTS)
def test_a_parameter_is_a_constant_that_a_machine_may_have(name):
    orbit = Made(parameters=(name,), cam=Made(stretches=[], seat_restitution=None),
                 constants=constants(**{"rpm": "300", name: None}))  # fmt: skip
    for value, positive, at_most_one in (("0.5", True, True), ("1", True, True),
                                         ("1.25", True, False), ("0", False, True)):  # fmt: skip
        why = refusal(check.Orbit.machine, orbit, arb(value))
        if name in ("rpm", "mass", "stiffness", "damping", "restitution") and not positive:
            assert why == "the parameter is no such constant"
        elif name == "restitution" and not at_most_one:
            assert why == "the restitution exceeds 1"
        else:
            assert why == ""


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({}, ""),
        ({"stiffness": "0", "damping": "0", "restitution": "1", "gravity": "-1"}, ""),
        ({"mass": "0"}, "speed or mass is not positive"),
        ({"rpm": "-1"}, "speed or mass is not positive"),
        ({"stiffness": "-1"}, "a constant is negative"),
        ({"damping": "-1"}, "a constant is negative"),
        ({"restitution": "0"}, "the restitution lies outside 0 to 1"),
        ({"restitution": "1.01"}, "the restitution lies outside 0 to 1"),
        ({"gravity": None}, "exactly the parameter has to be left open"),
    ],
)
def test_the_constants_of_a_machine_are_possible(changes, why):
    known = constants(rpm="300")
    assert refusal(check.possible, {**known, **constants(**{"rpm": "300", **changes})}, ()) == why
    open_one = constants(**{"preload": None, "rpm": "300", **changes})
    assert refusal(check.possible, open_one, {"preload"}) == why


# -- boxes of an orbit, by stand-ins


def box(**changes):
    usual = {
        "middle": [arb(x) for x in (1, 2, 3)], "tangent": [arb(x) for x in (4, 5, 1)],
        "error": [arb("0.1"), arb("0.2"), arb(0)], "fixed": 2, "half": arb("0.5"),
        "inverse": [[arb(1), arb(2)], [arb(3), arb(4)]],
    }  # fmt: skip
    return Made(**{**usual, **changes})


UNKNOWN = "a box has not one entry for each unknown"
NO_MATRIX = "a matrix has not one row and column for each free unknown"
NEGATIVE = "a box has a negative width"
LEANS = "a box does not lean along its unknown"


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({}, ""),
        ({"half": arb(0), "error": [arb(0)] * 3}, ""),
        *(({key: [arb(0), arb(1), arb(1), arb(0)]}, UNKNOWN)
          for key in ("middle", "tangent", "error")),
        *(({key: [arb(0), arb(1)]}, UNKNOWN) for key in ("middle", "tangent", "error")),
        ({"fixed": 3}, UNKNOWN),
        ({"inverse": [[arb(1), arb(2)]]}, NO_MATRIX),
        ({"inverse": [[arb(1), arb(2)], [arb(3)]]}, NO_MATRIX),
        ({"inverse": [[arb(1), arb(2)], [arb(3), arb(4)], [arb(5), arb(6)]]}, NO_MATRIX),
        ({"half": arb(-1)}, NEGATIVE),
        ({"error": [arb("0.1"), arb("-0.2"), arb(0)]}, NEGATIVE),
        ({"tangent": [arb(4), arb(5), arb("1.01")]}, LEANS),
        ({"error": [arb("0.1"), arb("0.2"), arb("0.01")]}, LEANS),
        ({"fixed": 1}, LEANS),
    ],
)  # fmt: skip
def test_the_form_of_a_box(changes, why):
    assert refusal(check.check_form, box(**changes), 2) == why


@pytest.mark.parametrize(
    ("hull", "corner", "why"),
    [
        (("1.5", "0.1", "0.5", "0.2"), None, ""),
        (("0.9", "0.1", "0.5", "0.2"), None, "impact 1 may lie outside its stretch of the cam"),
        (("2.1", "0.1", "0.5", "0.2"), None, "impact 1 may lie outside its stretch of the cam"),
        (("1.5", "0.1", "-0.1", "0.2"), None, "impact 2 may lie outside its stretch of the cam"),
        (("1.5", "0.1", "1", "0.2"), None, "impact 2 may lie outside its stretch of the cam"),
        (("1.5", "0.1", "1", "0.2"), 1, ""),
        (("0.9", "0.1", "1", "0.2"), 1, "impact 1 may lie outside its stretch of the cam"),
        (("1.5", "0", "0.5", "0.2"), None, "impact 1 may not bounce"),
        (("1.5", "0.1", "1", "-0.1"), 1, "impact 2 may not bounce"),
    ],
)
def test_impacts_of_a_motion_lie_on_their_stretches_and_bounce(hull, corner, why):
    stretches = [Made(start=arb(k), end=arb(k + 1)) for k in range(2)]
    asked = []
    orbit = Made(
        n=2, places=[Made(stretch=1), Made(stretch=0)], at=lambda hull: Made(stretches=stretches),
        clear=lambda *given: asked.append(given),
    )  # fmt: skip
    z = [arb(x) for x in hull]
    assert refusal(check.Orbit.motion, orbit, z, ["first", "second"], corner) == why
    if not why:
        assert asked == [(z, 0, "first"), (z, 1, "second")]
    for flights in (["first"], ["first", "second", "third"]):
        told = refusal(check.Orbit.motion, orbit, z, flights, corner)
        assert told == "not every impact has its flight"


def test_numbers_along_a_branch_have_their_value_in_its_middle_and_their_slope_on_all_of_it():
    """x y and x - p, where x = 3 + 2 eta and y = 5 - eta, and p = eta is known to a tenth."""
    one = Made(
        hull=[arb(3, "0.2"), arb(5, "0.1"), arb(0, "0.1")], slope=[arb(2), arb(-1), arb(1)],
        center=[arb(3), arb(5), arb(0)], half=arb("0.1"),
    )  # fmt: skip
    (first, second) = check.Orbit.along(None, one, lambda z: [z[0] * z[1], z[0] - z[2]])
    assert first[0] == 15
    assert second == (3, 1)
    for eta in ("-0.1", "0", "0.1"):
        assert first[1].overlaps(2 * (5 - arb(eta)) - (3 + 2 * arb(eta)))
    assert first[1].rad() < 0.41
    orbit = Made(
        trace_det=lambda z: (z[0] * z[1], z[0] - z[2], "scale"),
        along=lambda box, function: (
            [(x, arb(k)) for k, x in enumerate(function(box.center)[:2])] + [(arb(0), arb(0))]
        ),
    )
    trace, det = check.Orbit.multipliers(orbit, one)
    assert (trace.lower(), trace.upper()) == (15, 15)
    assert det.mid() == 3
    assert abs(det.rad() / arb("0.1") - 1) < 1e-6


# -- statements, by stand-ins


def told(monkeypatch, *names: str) -> list:
    """The calls of parts of the checker that are left out."""
    calls: list = []
    for name in names:
        monkeypatch.setattr(
            check, name, lambda *asked, name=name: calls.append((name, *asked)) or name
        )
    return calls


def recorder(calls: list, *names: str, **more) -> Made:
    """A stand-in of an orbit, whose parts tell when they are called."""
    parts = {name: lambda *asked, name=name: calls.append((name, *asked)) or name for name in names}
    return Made(**parts, **more)


@pytest.mark.parametrize("stable", [True, False])
def test_a_statement_on_an_orbit_has_its_motion_its_stability_and_its_name(monkeypatch, stable):
    calls = told(monkeypatch, "named")
    orbit = recorder(calls, "motion", "steady")
    monkeypatch.setattr(check, "only_one", lambda *given: calls.append(given) or orbit)
    given = Made(box=Made(hull="hull", flights="flights"), stable=stable)
    check.check_orbit("cam", given)
    assert calls == [
        ("cam", given), ("motion", "hull", "flights"), ("steady", given.box, stable),
        ("named", given, "hull"),
    ]  # fmt: skip


def test_the_parameters_of_a_statement_and_its_event(monkeypatch):
    monkeypatch.setattr(check, "Orbit", lambda *given: given)
    given = Made(kind="event", strobe=Fraction(359), parameter="rpm", second="mass", event="event",
                 constants="constants", impacts="impacts", turns=3)  # fmt: skip
    alone = ("cam", "constants", ["rpm"], "impacts", 3, None)
    assert check.orbit_of("cam", given) == alone
    given.kind = "curve"
    both = ("cam", "constants", ["rpm", "mass"], "impacts", 3, "event")
    assert check.orbit_of("cam", given) == both
    for strobe in (Fraction(360), Fraction(-1, 10)):
        given.strobe = strobe
        assert refusal(check.orbit_of, "cam", given) == "the strobe lies outside the turn"


@pytest.mark.parametrize(
    ("low", "high", "fixed", "why"),
    [
        ("699", "700.5", 4, ""), ("700", "700", 4, ""), ("699.5", "701", 4, ""),
        ("698.99", "700", 4, "its box does not cover the range of the parameter"),
        ("700", "701.01", 4, "its box does not cover the range of the parameter"),
        ("700.5", "700.25", 4, "its range is empty"),
        ("700", "700", 3, "the box of an orbit leans along the parameter"),
    ],
)  # fmt: skip
def test_a_box_covers_the_range_of_its_statement(monkeypatch, low, high, fixed, why):
    calls: list = []
    orbit = recorder(calls, "krawczyk", n=2)
    monkeypatch.setattr(check, "orbit_of", lambda *given: orbit)
    middle = [arb(1), arb(2), arb(3), arb(4), arb(700)]
    one = Made(fixed=fixed, middle=middle, half=arb(1))
    given = Made(box=one, low=Fraction(low), high=Fraction(high))
    assert refusal(check.only_one, "cam", given) == why
    assert calls == ([] if fixed == 3 else [("krawczyk", one)])
    if not why:
        assert check.only_one("cam", given) is orbit


@pytest.mark.parametrize(
    ("impacts", "turns", "strobe", "label"),
    [
        # (turn, phase in degrees) of each impact; before the strobe it is of the turn before
        (((0, 100), (0, 200), (1, 10)), 2, 90, "P(2;3:0)"),
        (((0, 100), (0, 200), (1, 10)), 2, 0, "P(2;2:1)"),
        (((0, 100), (1, 200), (1, 210), (2, 20)), 3, 0, "P(3;2:1:1)"),
        (((0, 100), (1, 200), (1, 210), (2, 20)), 3, 30, "P(3;3:0:1)"),
        (((0, 100), (1, 200), (1, 210), (2, 20)), 3, 150, "P(3;3:1:0)"),
        (((0, 50), (2, 10)), 3, 100, "P(3;1:1:0)"),
        (((0, 0), (0, 50), (0, 70), (1, 10)), 2, 0, "P(2;3:1)"),  # at the strobe it is behind it
        (((0, 50), (3, 10)), 3, 20, "P(3;1:1:0)"),
    ],
)
def test_a_label_counts_from_strobe_to_strobe(impacts, turns, strobe, label):
    hull = [x for _, degrees in impacts for x in (check.radians(Fraction(degrees)), arb(7))]
    given = Made(turns=turns, strobe=Fraction(strobe),
                 impacts=[Made(turn=turn) for turn, _ in impacts])  # fmt: skip
    assert check.labels(given, [*hull, arb(700)]) == [label]


# -- ellipses


def ellipse() -> tuple:
    return tuple(arb(x) for x in ("0.3", "-0.4", "0.5", "1.2"))


def test_an_ellipse_has_its_axes():
    axes = ellipse()
    a, b, *_ = axes
    assert near(check.length(a, b), mpf("0.5"))
    assert near(check.area(axes), mpf("0.36") + mpf("0.2"))
    assert check.matrix((1, 2, 3, 4)) == arb_mat([[1, 2], [3, 4]])
    product = check.inverse(axes) * check.matrix(axes)
    assert all(abs(x - y) < CLOSE for x, y in
               zip(product.entries(), check.identity(2).entries(), strict=True))  # fmt: skip


@pytest.mark.parametrize(
    ("gaps", "why"),
    [
        (("0.51", "-0.51"), ""), (("0.49", "-0.51"), "may land outside"),
        (("0.51", "-0.49"), "may land outside"), (("-0.51", "0.51"), "may land outside"),
    ],
)  # fmt: skip
def test_flights_from_an_ellipse_land_where_the_next_one_lies(gaps, why):
    """The gap changes by the length of M^T (0.5, -0.25) = (0.025, -0.5), 0.5006, at most."""
    asked = []

    def flight(machine, z, k, end):
        asked.append((machine, z, k, float(end)))
        gap = arb(gaps[0] if end < 3 else gaps[1])
        return Made(gap=gap, gap_by_theta=arb("0.5"), gap_by_v=arb("-0.25"))

    orbit = Made(n=3, flight=flight)
    hull, wide = [arb(x) for x in (1, 2, 9, 9, 3, 4)], ["wide"]
    hull[0] = arb(3)  # behind the third impact comes the first one
    said = refusal(check.check_landings, orbit, "machine", hull, wide, 2, ellipse(), arb("0.125"))
    assert why in said
    assert bool(why) == bool(said)
    assert asked[0] == ("machine", hull, 2, 2.875)
    assert asked[1] == ("machine", wide, 2, 2.875)
    if not why:
        assert [row[3] for row in asked[2:]] == [3.125, 3.125]
    else:
        assert said == "flight 3 may land outside the next ellipse"


def attractor(monkeypatch, maps=((4, 0, 0, "0.1"), ("0.03", 0, 0, "0.8")), **changes) -> tuple:
    """An orbit of two impacts whose maps have these slopes, between two ellipses."""
    calls = told(monkeypatch, "named", "check_landings")
    orbit = recorder(
        calls, "motion", n=2, at=lambda z: ("machine", z),
        flight=lambda machine, z, k: (machine, z, k),
    )  # fmt: skip
    monkeypatch.setattr(check, "only_one", lambda *given: orbit)

    def impact_map(flight):
        calls.append(flight)
        a, b, c, d = (arb(x) for x in maps[flight[2]])
        return Made(matrix=lambda: arb_mat([[a, b], [c, d]]))

    monkeypatch.setattr(check, "impact_map", impact_map)
    hull = [arb(x) for x in (1, 2, 3, 4, 700)]
    axes = [[arb("0.03"), arb("0.04"), arb(0), arb("0.2")],
            [arb("0.5"), arb(0), arb("0.05"), arb("0.12")]]  # fmt: skip
    given = {"box": Made(hull=hull, flights="flights"), "axes": axes, **changes}
    return Made(**given), orbit, calls


def test_every_flight_of_an_attractor_is_shown_for_its_own_ellipses(monkeypatch):
    """The extents in theta are 0.05 and 0.5, those in v 0.2 and 0.13."""
    given, orbit, calls = attractor(monkeypatch)
    assert refusal(check.check_attractor, "cam", given) == ""
    name, wide, flights = calls[0]
    assert (name, flights) == ("motion", "flights")
    for x, middle, radius in zip(
        wide, (1, 2, 3, 4, 700), ("0.05", "0.2", "0.5", "0.13", 0), strict=True
    ):
        assert x.mid() == middle
        assert abs(arb(x.rad()) - arb(radius)) < 1e-8
    hull, machine = given.box.hull, ("machine", given.box.hull)
    assert calls[1] == ("named", given, hull)
    landings = [call for call in calls if call[0] == "check_landings"]
    for k, call in enumerate(landings):
        assert call[1:7] == (orbit, machine, hull, wide, k, given.axes[k])
        assert abs(call[7] - (arb("0.5"), arb("0.05"))[k]) < CLOSE
    assert [call for call in calls if call[0] == machine] == [(machine, wide, k) for k in (0, 1)]


@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        # M^-1 S M is in units of both ellipses: [[1/2, 0], [0, 1/3]] has the axes 2 and 3
        ("1.9", "0.1", ""), ("2.1", "0.1", "flight 1 may not come nearer to the orbit"),
        ("0.1", "2.9", ""), ("0.1", "3.1", "flight 1 may not come nearer to the orbit"),
        ("-2.1", "0.1", "flight 1 may not come nearer to the orbit"),
    ],
)  # fmt: skip
def test_a_map_shrinks_in_units_of_its_ellipses(monkeypatch, first, second, why):
    given, _, _ = attractor(monkeypatch, ((first, 0, 0, second), (0, 0, 0, 0)))
    given.axes = [[arb(1), arb(0), arb(0), arb(1)], [arb(2), arb(0), arb(0), arb(3)]]
    assert refusal(check.check_attractor, "cam", given) == why


@pytest.mark.parametrize(
    ("slopes", "shrinks"),
    [
        ((0, "0.9", "0.2", 0), True), ((0, "1.1", "0.2", 0), False),
        (("0.7", "0.7", 0, 0), True), (("0.8", "0.8", 0, 0), False), ((2, 0, 0, 2), False),
        (("0.8", 0, "0.8", 0), False), ((0, "0.8", 0, "0.8"), False),
    ],
)  # fmt: skip
def test_a_map_that_turns_the_axes_shrinks_by_the_longer_one(monkeypatch, slopes, shrinks):
    """The columns of M are no axes of its own: the longest image of |u| = 1 decides."""
    given, _, _ = attractor(monkeypatch, (slopes, (0, 0, 0, 0)))
    given.axes = [[arb(1), arb(0), arb(0), arb(1)]] * 2
    said = refusal(check.check_attractor, "cam", given)
    assert said == ("" if shrinks else "flight 1 may not come nearer to the orbit")


@pytest.mark.parametrize("number", [0, 1])
def test_every_impact_has_an_ellipse_that_is_not_flat(monkeypatch, number):
    given, _, _ = attractor(monkeypatch)
    given.axes[number] = [arb(2) ** -6, arb(2) ** -5, arb(2) ** -5, arb(2) ** -4]
    assert refusal(check.check_attractor, "cam", given) == "an ellipse is flat"
    for axes in (given.axes[:1], [*given.axes, given.axes[0]],
                 [given.axes[0], given.axes[1][:3]]):  # fmt: skip
        given.axes = axes
        assert refusal(check.check_attractor, "cam", given) == "not every impact has an ellipse"


# -- events


@pytest.mark.parametrize("corner", [None, 1])
@pytest.mark.parametrize("kind", ["fold", "period-doubling", "multipliers-meet", "corner-impact"])
def test_a_statement_on_an_event_has_all_that_its_kind_needs(monkeypatch, kind, corner):
    calls = told(monkeypatch, "crosses", "named", "check_signs")
    orbit = recorder(calls, "krawczyk", "motion")
    inside = [True]
    monkeypatch.setattr(check, "orbit_of", lambda *given: orbit)
    monkeypatch.setattr(check, "corner_of", lambda *given: corner)
    monkeypatch.setattr(check, "other_inside", lambda *given: calls.append(given) or inside[0])
    hull = [arb(1), arb(2), arb(700)]
    given = Made(box=Made(hull=hull, flights="flights"), event=Made(event=kind), signs=[],
                 low=Fraction(699), high=Fraction(701))  # fmt: skip
    assert refusal(check.check_event, "cam", given) == ""
    expected = [
        ("krawczyk", given.box), ("motion", hull, "flights", corner),
        ("crosses", orbit, given.box, given.event), ("named", given, hull),
    ]  # fmt: skip
    if corner is not None:
        expected.append(("check_signs", orbit, given, corner))
    elif kind != "multipliers-meet":
        expected.append((orbit, given.box, given.event))
    assert calls == expected
    inside[0] = False
    asks_for_other = corner is None and kind != "multipliers-meet"
    why = "another multiplier may lie on the unit circle" if asks_for_other else ""
    assert refusal(check.check_event, "cam", given) == why
    inside[0] = True
    given.signs = [1]
    assert refusal(check.check_event, "cam", given) == (
        "it has more than its kind needs" if corner is None else ""
    )
    for low, high in ((Fraction(698), Fraction(699)), (Fraction(701), Fraction(702))):
        given.low, given.high = low, high
        assert refusal(check.check_event, "cam", given) == "its parameter may lie elsewhere"


@pytest.mark.parametrize(
    ("value", "slope", "holds"),
    [("0.19", "2", True), ("-0.19", "2", True), ("0.19", "-2", True), ("0.21", "2", False),
     ("-0.21", "2", False), ("0.21", "-2", False), ("0", "0", False)],
)  # fmt: skip
def test_a_function_crosses_zero_where_its_slope_leads_there(monkeypatch, value, slope, holds):
    """Within a tenth of the parameter."""
    monkeypatch.setattr(check, "zero_at", lambda *given: given)
    asked = []
    orbit = Made(along=lambda *given: asked.append(given) or [(arb(value), arb(slope))])
    one = Made(half=arb("0.1"))
    why = refusal(check.crosses, orbit, one, "event")
    assert why == ("" if holds else "the function of an event may have no zero")
    assert asked == [(one, (orbit, "event"))]


def test_what_is_zero_at_an_event():
    """Of trace and determinant, of the place of an impact; on a curve times the rates."""
    stretches = [Made(start=arb(k), end=arb(k + 1)) for k in range(3)]
    values = {False: (arb("0.7"), arb("0.3"), arb(1)), True: (arb("1.4"), arb("0.3"), arb(2))}
    orbit = Made(
        event=None, at=lambda z: Made(stretches=stretches),
        places=[Made(stretch=0), Made(stretch=2), Made(stretch=1)],
        trace_det=lambda z, times_rates: values[times_rates],
    )  # fmt: skip
    z = [arb(x) for x in ("0.1", "5", "2.25", "6", "1.75", "7")]

    def zero(kind, **more):
        (found,) = check.zero_at(orbit, Made(event=kind, **more))(z)
        return found

    for event, factor in ((None, 1), ("event", 2)):
        orbit.event = event
        assert zero("period-doubling").overlaps(factor * arb("2"))
        assert abs(zero("period-doubling") - factor * arb("2")) < CLOSE
        assert abs(zero("fold") - factor * arb("0.6")) < CLOSE
    orbit.event = None
    assert abs(zero("multipliers-meet") - (arb("0.49") - arb("1.2"))) < CLOSE
    assert abs(zero("corner-impact", impact=1, side=1) - arb("-0.75")) < CLOSE
    assert abs(zero("corner-impact", impact=1, side=-1) - arb("0.25")) < CLOSE
    assert abs(zero("corner-impact", impact=2, side=1) - arb("-0.25")) < CLOSE
    touches = check.zero_at(orbit, Made(event="grazing"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "touching", lambda *given: given)
        assert touches(z)[:2] == (orbit, z)


GRAZE_FORM = "a graze names its flight and its stretch"
MORE = "an event has more than its kind needs"
CORNER_FORM = "a corner impact names its impact and side"
EVENTS = [
    (("grazing", 1, 0, 2), None), (("grazing", 2, 0, 2), GRAZE_FORM),
    (("grazing", 1, 1, 2), GRAZE_FORM), (("grazing", 1, 0, 3), GRAZE_FORM),
    (("grazing", 1, 0, None), GRAZE_FORM),
    (("fold", 0, 0, None), None), (("fold", 1, 0, None), MORE), (("fold", 0, 1, None), MORE),
    (("period-doubling", 1, 0, None), MORE), (("multipliers-meet", 0, -1, None), MORE),
    (("corner-impact", 0, -1, None), 0), (("corner-impact", 1, 1, None), 1),
    (("corner-impact", 2, 1, None), CORNER_FORM), (("corner-impact", 1, 0, None), CORNER_FORM),
]  # fmt: skip


@pytest.mark.parametrize(("numbers", "expected"), EVENTS)
def test_an_event_names_the_impact_and_the_side_that_its_kind_has(numbers, expected):
    kind, impact, side, touch = numbers
    event = Made(event=kind, impact=impact, side=side,
                 touch=None if touch is None else Made(stretch=touch, turn=0))  # fmt: skip
    orbit = Made(n=2, cam=Made(stretches=[0, 1, 2]))
    if isinstance(expected, str):
        assert refusal(check.corner_of, orbit, event) == expected
    else:
        assert check.corner_of(orbit, event) == expected
    assert check.corner_of(orbit, None) is None


@pytest.mark.parametrize(
    ("kind", "trace", "det", "expected"),
    [
        ("fold", "1.5", "0.5", True), ("fold", "-1.4", "0.5", True),
        ("fold", "-1.6", "0.5", False), ("fold", "2.1", "1.1", False),
        ("period-doubling", "-1.5", "0.5", True), ("period-doubling", "1.4", "0.5", True),
        ("period-doubling", "1.6", "0.5", False), ("period-doubling", "-2.1", "1.1", False),
    ],
)  # fmt: skip
def test_the_other_multiplier_at_an_event_is_inside_the_circle(kind, trace, det, expected):
    orbit = Made(multipliers=lambda box: (arb(trace), arb(det)))
    assert check.other_inside(orbit, None, Made(event=kind)) == expected


# -- branches and curves


def joint(value: str, fixed=0):
    hull = [arb(9), arb(9), arb(9)]
    hull[fixed] = arb(value)
    return Made(hull=hull)


@pytest.mark.parametrize("stable", [True, False])
@pytest.mark.parametrize("kind", ["fold", "corner-impact"])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("slope", ["2", "-2"])
@pytest.mark.parametrize("beside", ["4", "6"])
def test_an_end_of_a_branch_has_the_stability_that_its_event_leaves(
    monkeypatch, stable, kind, side, slope, beside
):
    """The function grows by its slope from the event, at 5, to the joint beside it."""
    calls = told(monkeypatch, "crosses")
    monkeypatch.setattr(check, "zero_at", lambda *given: "function")
    monkeypatch.setattr(check, "other_inside", lambda *given: calls.append(given) or True)
    orbit = recorder(calls, "steady")
    orbit.along = lambda *given: calls.append(given) or [(arb(99), arb(slope))]
    one, event = Made(fixed=1), Made(event=kind, side=side)
    at_event, beside_event = joint("5", 1), joint(beside, 1)
    why = refusal(check.check_end, orbit, stable, one, event, at_event, beside_event)
    grows = (float(slope) > 0) == (beside == "6")
    assert calls[:2] == [("crosses", orbit, at_event, event), (one, "function")]
    if kind == "fold":
        good = grows == stable
        assert why == ("" if good else "the stability beside an event is another")
        assert calls[2:] == [(orbit, one, event)]
    else:  # the impact lies before the end of its stretch, or behind its start
        good = grows == (side < 0)
        assert why == ("" if good else "the branch goes to the wrong side of a corner")
        assert calls[2:] == ([("steady", one, stable)] if good else [])


def test_another_multiplier_may_cross_at_an_end(monkeypatch):
    told(monkeypatch, "crosses")
    monkeypatch.setattr(check, "zero_at", lambda *given: "function")
    monkeypatch.setattr(check, "other_inside", lambda *given: False)
    orbit = Made(along=lambda *given: [(arb(0), arb(1))])
    given = (orbit, True, Made(fixed=0), Made(event="fold"), joint("5"), joint("6"))
    assert refusal(check.check_end, *given) == "another multiplier may cross the unit circle"


FOLD, DOUBLED = Made(event="fold"), Made(event="period-doubling")


def branch(monkeypatch, boxes: int, ends):
    """A branch of so many boxes, whose joints lie at 1, 2, ... of the parameter."""
    calls = told(monkeypatch, "one_chain", "check_end", "counted")
    orbit = recorder(calls, "motion", "steady")
    monkeypatch.setattr(check, "orbit_of", lambda *given: orbit)
    monkeypatch.setattr(check, "corner_of", lambda orbit, event: event and event.event)
    given = Made(
        boxes=[Made(hull=f"hull {k}", flights=f"flights {k}") for k in range(boxes)],
        joints=[Made(hull=[arb(50), arb(k + 1)]) for k in range(boxes + 1)], ends=ends,
        stable="stable", low=[Fraction("0.9"), Fraction("1.1")],
        high=[boxes + Fraction("0.9"), boxes + Fraction("1.1")],
    )  # fmt: skip
    return given, orbit, calls


@pytest.mark.parametrize("ends", [[None, None], [FOLD, None], [None, DOUBLED], [FOLD, DOUBLED]])
def test_every_box_of_a_branch_is_steady_or_has_the_event_at_its_end(monkeypatch, ends):
    given, orbit, calls = branch(monkeypatch, 3, ends)
    assert refusal(check.check_branch, "cam", given) == ""
    boxes, joints = given.boxes, given.joints
    expected = [("one_chain", orbit, given)]
    for k, event in enumerate((ends[0], None, ends[1])):
        one = boxes[k]
        expected.append(("motion", one.hull, one.flights, event and event.event))
        expected.append(("counted", given, one.hull))
        if event is None:
            expected.append(("steady", one, "stable"))
        else:
            both = (joints[0], joints[1]) if k == 0 else (joints[3], joints[2])
            expected.append(("check_end", orbit, "stable", one, event, *both))
    assert calls == expected


@pytest.mark.parametrize("ends", [[None, None], [FOLD, None], [None, DOUBLED], [FOLD, DOUBLED]])
def test_one_box_has_one_event_only(monkeypatch, ends):
    given, orbit, calls = branch(monkeypatch, 1, ends)
    why = "" if None in ends else "one box can have one event only"
    assert refusal(check.check_branch, "cam", given) == why
    event = ends[0] or ends[1]
    if event is not None and not why:
        both = given.joints if ends[0] else given.joints[::-1]
        assert calls[-1] == ("check_end", orbit, "stable", given.boxes[0], event, *both)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"ends": [None]}, "a branch has two ends"),
        ({"ends": [None] * 3}, "a branch has two ends"),
        ({"low": [Fraction("1.05"), Fraction("1.1")]}, "an end of the branch may lie elsewhere"),
        ({"low": [Fraction("0.9"), Fraction("0.95")]}, "an end of the branch may lie elsewhere"),
        ({"high": [Fraction("3.01"), Fraction("3.1")]}, "an end of the branch may lie elsewhere"),
        ({"low": [Fraction(1)]}, "an end of the branch may lie elsewhere"),
        ({"high": [Fraction(3)] * 3}, "an end of the branch may lie elsewhere"),
        ({"low": [Fraction(1), Fraction("2.95")]}, "its range is empty"),
        ({"low": [Fraction(1), Fraction("2.9")]}, ""),
    ],
)
def test_the_ends_of_a_branch_are_those_of_its_range(monkeypatch, changes, why):
    given, _, _ = branch(monkeypatch, 2, [None, None])
    vars(given).update(changes)
    assert refusal(check.check_branch, "cam", given) == why


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_chain_has_each_box_between_its_joints_and_is_named_in_the_middle(monkeypatch, count):
    calls = told(monkeypatch, "joins", "named")
    orbit = recorder(calls, "krawczyk")
    boxes = [f"box {k}" for k in range(count)]
    joints = [Made(hull=f"hull {k}") for k in range(count + 1)]
    given = Made(boxes=boxes, joints=joints)
    check.one_chain(orbit, given)
    assert calls[: 2 * count + 1] == [("krawczyk", one) for one in (*boxes, *joints)]
    joined = [call[1:] for call in calls if call[0] == "joins"]
    sides = list(pairwise(joints))
    assert joined == [(boxes[k], one) for k in range(count) for one in sides[k]]
    assert calls[-1] == ("named", given, joints[(count + 1) // 2].hull)
    for wrong in (joints[:-1], [*joints, joints[0]]):
        given.joints = wrong
        told_why = refusal(check.one_chain, orbit, given)
        assert told_why == "a chain has one joint more than boxes"
    given.boxes, given.joints = [], joints[:1]
    assert refusal(check.one_chain, orbit, given) == "a chain has one joint more than boxes"


def curve(monkeypatch, kind="fold", det="0.5", **changes):
    calls = told(monkeypatch, "one_chain", "counted")
    orbit = recorder(calls, "motion", n=2, grazes=kind == "grazing")
    orbit.values = lambda hull: hull[4:6]
    orbit.trace_det = lambda hull: calls.append(("trace", hull)) or ("trace", arb(det), "scale")
    monkeypatch.setattr(check, "orbit_of", lambda *given: orbit)
    monkeypatch.setattr(check, "corner_of", lambda *given: "corner")

    def end(first, second):
        ranges = [Made(low=x - Fraction(1, 10), high=x + Fraction(1, 10)) for x in (first, second)]
        return Made(parameter=ranges[0], second=ranges[1])

    hulls = [[arb(9)] * 4 + [arb(a), arb(b), arb(8)] for a, b in ((1, 2), (5, 6), (3, 7))]
    given = {
        "joints": [Made(hull=hull) for hull in hulls], "begin": end(Fraction(1), Fraction(2)),
        "end": end(Fraction(3), Fraction(7)), "event": Made(event=kind, touch=None),
        "boxes": [Made(hull=f"hull {k}", flights=f"flights {k}", fixed=4 + k) for k in (0, 1)],
    }  # fmt: skip
    return Made(**{**given, **changes}), orbit, calls


@pytest.mark.parametrize("kind", ["fold", "period-doubling", "corner-impact", "grazing"])
def test_every_box_of_a_curve_holds_motions_with_the_event(monkeypatch, kind):
    given, orbit, calls = curve(monkeypatch, kind)
    assert refusal(check.check_curve, "cam", given) == ""
    expected: list = [("one_chain", orbit, given)]
    for one in given.boxes:
        expected += [("motion", one.hull, one.flights, "corner"), ("counted", given, one.hull)]
        if kind in ("fold", "period-doubling"):
            expected.append(("trace", one.hull))
    assert calls == expected
    given, _, _ = curve(monkeypatch, kind, det="1.01")
    asks = kind in ("fold", "period-doubling")
    why = "another multiplier may lie on the unit circle" if asks else ""
    assert refusal(check.check_curve, "cam", given) == why
    given, _, _ = curve(monkeypatch, kind)
    given.event.touch = "touch"
    why = "" if kind == "grazing" else MORE
    assert refusal(check.check_curve, "cam", given) == why


@pytest.mark.parametrize("end", ["begin", "end"])
@pytest.mark.parametrize("number", ["parameter", "second"])
@pytest.mark.parametrize("side", ["low", "high"])
def test_an_end_of_a_curve_lies_in_both_of_its_ranges(monkeypatch, end, number, side):
    given, _, _ = curve(monkeypatch)
    place = getattr(getattr(given, end), number)
    middle = (place.low + place.high) / 2
    setattr(place, side, middle)
    assert refusal(check.check_curve, "cam", given) == ""
    setattr(place, side, middle + (Fraction(1, 100) if side == "low" else Fraction(-1, 100)))
    assert refusal(check.check_curve, "cam", given) == "an end of the curve may lie elsewhere"


@pytest.mark.parametrize(("fixed", "good"), [(3, False), (4, True), (5, True), (6, False)])
def test_a_box_of_a_curve_leans_along_one_of_both_numbers(monkeypatch, fixed, good):
    given, _, _ = curve(monkeypatch)
    given.boxes[1].fixed = fixed
    why = "" if good else "a box of a curve leans along a parameter"
    assert refusal(check.check_curve, "cam", given) == why
