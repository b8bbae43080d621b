"""The checker's numbers, its cams and its machines, each by a formula of its own or by hand."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_series, ctx
from mpmath import mp, mpf

from camcli import check
from tests.support.checker import NEAR, ball, expression, near, source


@pytest.fixture(autouse=True)
def digits(monkeypatch):
    """Those of the checker, and more of mpmath."""
    monkeypatch.setattr(ctx, "prec", check.BITS)
    with mp.workdps(90):
        yield


def terms(x: arb_series, count: int) -> list[arb]:
    return [x[k] for k in range(count)]


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize("varying", ["x", "y", "both"])
def test_the_angle_of_a_vector_that_moves_has_the_terms_of_taylor(varying, signs):
    """In all four quadrants, where one of both numbers is a ball, too."""
    of_x = [mpf("1.5") * signs[0], mpf("0.3"), mpf("-0.2"), mpf("0.7")]
    of_y = [mpf("0.8") * signs[1], mpf("-0.4"), mpf("0.9"), mpf("0.1")]
    of_x = of_x[:1] if varying == "y" else of_x
    of_y = of_y[:1] if varying == "x" else of_y
    made = [
        ball(row[0]) if len(row) == 1 else arb_series([ball(a) for a in row], 6)
        for row in (of_y, of_x)
    ]
    found = check.angle_of(*made)
    expected = mp.taylor(
        lambda t: mp.atan2(mp.polyval(of_y, t, asc=True), mp.polyval(of_x, t, asc=True)), 0, 5
    )
    for term, wanted in zip(terms(found, 6), expected, strict=True):
        assert abs(term - ball(wanted)) < arb("1e-12")
    assert near(check.angle_of(ball(of_y[0]), ball(of_x[0])), mp.atan2(of_y[0], of_x[0]))


def test_a_number_has_a_value_and_a_slope():
    """What depends on nothing has the slope zero; a ball about a point reaches so far."""
    moving = check.sloped(arb("2.5"), arb(-3))
    assert (check.value_of(moving), check.slope_of(moving)) == (arb("2.5"), -3)
    assert (check.value_of(arb(7)), check.slope_of(arb(7))) == (7, 0)
    assert (check.value_of(7), check.slope_of(7)) == (7, 0)
    about = check.around(arb(5), arb(2) ** -3)
    assert about.mid() == 5
    assert abs(about.rad() / arb("0.125") - 1) < 1e-6
    assert near(check.radians(Fraction(45, 2)), mp.pi / 8)
    z = check.direction([arb(4), arb(5), arb(6)], 1)
    assert [check.value_of(x) for x in z] == [4, 5, 6]
    assert [check.slope_of(x) for x in z] == [0, 1, 0]


STRETCH = check.Stretch(
    start=arb(0), end=arb(3), center=arb("0.5"),
    polynomial=[arb(2), arb(-3), arb("0.5"), arb(4), arb("0.25"), arb("-0.125")],
    wave=(arb("0.7"), arb("-1.1"), arb("1.5")), circle=(arb("0.6"), arb("2.25")),
)  # fmt: skip


def lift(theta: mpf) -> mpf:
    x = theta - mpf("0.5")
    return (
        2 - 3 * x + x**2 / 2 + 4 * x**3 + x**4 / 4 - x**5 / 8
        + mpf("0.7") * mp.cos(1.5 * x) - mpf("1.1") * mp.sin(1.5 * x)
        + mpf("0.6") * mp.cos(x) + mp.sqrt(mpf("2.25") ** 2 - mpf("0.36") * mp.sin(x) ** 2)
    )  # fmt: skip


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_a_stretch_has_the_derivatives_of_its_formula(order):
    """All of its terms together, at an angle, over a ball of angles, and as a series."""
    theta = mpf("1.3")
    found = STRETCH.derivatives(ball(theta), order)
    expected = [mp.diff(lift, theta, k) for k in range(order + 1)]
    assert len(found) == order + 1
    for one, wanted in zip(found, expected, strict=True):
        assert abs(one - ball(wanted)) < arb("1e-15")
    moving = STRETCH.derivatives(check.sloped(ball(theta), arb(2)), order)
    for k, one in enumerate(moving):
        slope = 2 * mp.diff(lift, theta, k + 1)
        assert abs(check.value_of(one) - ball(expected[k])) < arb("1e-15")
        assert abs(check.slope_of(one) - ball(slope)) < arb("1e-12")
    wide = STRETCH.derivatives(arb("1.3", "0.01"), order)
    for k, one in enumerate(wide):
        for at in ("1.2901", "1.3", "1.3099"):
            assert one.overlaps(ball(mp.diff(lift, mpf(at), k)))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.25", "0.25"), ("base", "3"), ("-base", "-3"), ("base + 2", "5"), ("base - 5", "-2"),
        ("base*(lift - 1)", "-1.5"), ("base/4", "0.75"), ("base - lift - 1", "1.5"),
        ("sqrt(base*3)", "3"), ("- (base/lift)", "-6"),
    ],
)  # fmt: skip
def test_a_formula_has_the_value_of_its_signs(text, value):
    names = {"base": arb(3), "lift": arb("0.5")}
    assert check.evaluated(expression(text), names).overlaps(arb(value))
    quarter = check.evaluated(expression("atan2(lift, -lift)"), names)
    assert near(quarter, 3 * mp.pi / 4)


@pytest.mark.parametrize(
    "text",
    ["other", "True", "f(base)", "sqrt(base, base)", "sqrt()", "atan2(base)", "base**2",
     "base % 2", "+base", "base < 2", "sqrt(base, key=base)", "'base'", "base.real", "a.sqrt(base)",
     "atan2(base, base, base)", "~base"],
)  # fmt: skip
def test_a_formula_has_nothing_else(text):
    with pytest.raises(check.NoCertificateError, match="a formula has what is not known here"):
        check.evaluated(expression(text), {"base": arb(3)})


def test_a_cam_has_the_numbers_of_its_formulas_in_their_order():
    """What varies goes before the number of the file, and no stretch without a length is left."""
    given = source(
        {"end": "first", "polynomial": ["base", "twice"], "center": "base", "seat": True},
        {"end": "first"},
        {"end": "2*pi", "wave": ["base", "twice", "thrice"], "circle": ["base", "thrice"]},
        numbers={"base": Fraction(1, 2)},
        formulas=[("twice", "2*base"), ("thrice", "twice + base"), ("first", "pi*thrice/2")],
        seat_restitution=Fraction(1, 3),
    )
    cam = check.Cam(given)
    assert (cam.kind, cam.seat_restitution) == ("law", Fraction(1, 3))
    for stretches, base in (
        (cam.stretches, mpf("0.5")), (cam.with_numbers({"base": arb("0.25")}), mpf("0.25")),
    ):  # fmt: skip
        first, last = stretches
        assert near(first.start, 0)
        assert near(first.end, 3 * base * mp.pi / 2)
        assert near(last.start, 3 * base * mp.pi / 2)
        assert near(last.end, 2 * mp.pi)
        assert near(first.center, base)
        assert all(near(x, y) for x, y in zip(first.polynomial, (base, 2 * base), strict=True))
        wanted = (base, 2 * base, 3 * base)
        assert all(near(x, y) for x, y in zip(last.wave, wanted, strict=True))
        assert all(near(x, y) for x, y in zip(last.circle, wanted[::2], strict=True))
        assert (first.seat, last.seat) == (True, False)
        assert (first.wave, first.circle) == ([], [])


NO_CAM = "these numbers make no cam"
PART = "its stretches do not fill one turn"


def test_a_cam_over_a_ball_of_numbers_is_one_at_all_of_them():
    """No stretch may end before it begins, and the last one has to end after one turn."""
    numbers = {"p": Fraction(3), "q": Fraction(0)}
    cam = check.Cam(source({"end": "p"}, {"end": "2*pi + q"}, numbers=numbers))
    assert len(cam.with_numbers({"p": arb(3, 0.1)})) == 2
    assert len(cam.with_numbers({"p": 2 * arb.pi()})) == 1
    for changed, why in (
        ({"p": 2 * arb.pi() + arb(0, 0.1)}, NO_CAM), ({"p": arb(7)}, NO_CAM),
        ({"p": arb(0, 0.1)}, NO_CAM), ({"q": arb(0, 0.001)}, PART), ({"q": arb(-0.001)}, PART),
        ({"q": arb(0.001)}, PART),
    ):  # fmt: skip
        with pytest.raises(check.NoCertificateError, match=why):
            cam.with_numbers(changed)


NO_CAMS = {
    "no polynomial": (({"end": "2*pi", "polynomial": []},), NO_CAM),
    "a wave of two numbers": (({"end": "2*pi", "wave": ["1", "1"]},), NO_CAM),
    "a wave of four": (({"end": "2*pi", "wave": ["1", "1", "1", "1"]},), NO_CAM),
    "a circle of one number": (({"end": "2*pi", "circle": ["1"]},), NO_CAM),
    "a circle of three": (({"end": "2*pi", "circle": ["1", "1", "1"]},), NO_CAM),
    "backwards": (({"end": "3"}, {"end": "2"}, {"end": "2*pi"}), NO_CAM),
    "too short": (({"end": "2*pi - tiny"},), PART),
    "too long": (({"end": "2*pi + tiny"},), PART),
    "nothing": ((), PART),
}


@pytest.mark.parametrize(("rows", "why"), NO_CAMS.values(), ids=NO_CAMS)
def test_what_is_no_cam_is_refused(rows, why):
    with pytest.raises(check.NoCertificateError, match=why):
        check.Cam(source(*rows, numbers={"tiny": Fraction(2, 2**192)}))


def test_an_end_may_lie_a_rounding_before_its_start_or_beside_a_turn():
    """By less than 2^-192 rad."""
    numbers = {"tiny": Fraction(1, 2**193)}
    rows = [{"end": end} for end in ("3", "3 - tiny", "2*pi - tiny")]
    assert len(check.Cam(source(*rows, numbers=numbers)).stretches) == 2
    assert len(check.Cam(source({"end": "2*pi + tiny"}, numbers=numbers)).stretches) == 1


def line(start, end, *polynomial) -> check.Stretch:
    return check.Stretch(arb(start), arb(end), arb(start), [arb(a) for a in polynomial])


TINIER, LARGER = arb(2) ** -193, arb(2) ** -191
JUMPS = {
    "none": ([line(0, 1, 1, 2), line(1, 3, 3, "-1")], [False, True]),
    "at the end of the turn": ([line(0, 1, 1, 2), line(1, 3, 3, 2)], [True, False]),
    "in between": ([line(0, 1, 1, 2), line(1, 3, 4, "-1.5")], [True, True]),
    "one stretch": ([line(0, 1, 1, 0)], [False, False]),
    "one stretch that climbs": ([line(0, 1, 1, 1)], [True, False]),
    "a ball of roundings": ([line(0, 1, 1, 0), line(1, 2, arb(1, TINIER), 0)], [False, False]),
    "a ball that may hide a jump": ([line(0, 1, 1, 0), line(1, 2, arb(1, LARGER), 0)],
                                    [True, False]),
    "a jump as small as roundings": ([line(0, 1, 0, 0), line(1, 2, TINIER, 0)], [True, False]),
}  # fmt: skip


@pytest.mark.parametrize(("stretches", "expected"), JUMPS.values(), ids=JUMPS)
def test_where_a_cam_jumps_or_its_slope(stretches, expected):
    assert [check.jumps(stretches, order) for order in (0, 1)] == expected


CONSTANTS = {"rpm": 300, "mass": Fraction(3, 2), "stiffness": 700, "damping": 11, "gravity": 9,
             "preload": 13, "restitution": Fraction(3, 4)}  # fmt: skip
SEATED = Made(stretches=[], seat_restitution=Fraction(1, 5))


def machine(**changes) -> check.Machine:
    known = {key: Fraction(x) for key, x in {**CONSTANTS, **changes}.items()}
    return check.Machine(SEATED, known)


def test_a_machine_has_the_constants_of_its_equation():
    """omega is 10 pi rad/s; the same where each constant is the parameter, with its slope."""
    numbers = {key: mpf(x.numerator) / x.denominator for key, x in CONSTANTS.items()}

    def wanted(**changes) -> list:
        v = numbers | changes
        v["omega"] = v["rpm"] * mp.pi / 30
        return [
            v["damping"] / (2 * v["mass"] * v["omega"]),
            v["stiffness"] / v["mass"] / v["omega"] ** 2,
            (v["gravity"] + v["preload"] / v["mass"]) / v["omega"] ** 2,
            v["restitution"],
        ]

    made = machine()
    found = (made.Z, made.W2, made.G, made.r)
    assert all(near(x, y) for x, y in zip(found, wanted(), strict=True))
    assert near(made.r_seat, mpf(1) / 5)
    assert (made.sprung, made.damped, made.under, made.near_critical) == (True, True, True, False)
    assert near(made.f**2, wanted()[1] - wanted()[0] ** 2)
    for name in CONSTANTS:
        open_one = {key: None if key == name else Fraction(x) for key, x in CONSTANTS.items()}
        at = check.ball_of(Fraction(CONSTANTS[name]))
        moving = check.Machine(SEATED, open_one, {name: check.sloped(at, arb(1))})
        for k, x in enumerate((moving.Z, moving.W2, moving.G, moving.r)):
            slope = mp.diff(lambda p, k=k, name=name: wanted(**{name: p})[k], numbers[name])
            assert near(check.value_of(x), wanted()[k])
            assert abs(check.slope_of(x) - ball(slope)) < arb("1e-25")


@pytest.mark.parametrize(
    ("damping", "under", "near_critical"),
    [("15.99", True, False), ("15.9921", True, False), ("15.9923", False, True),
     ("16", False, True), ("16.0078", False, True), ("16.0079", False, False),
     ("17", False, False), ("0", True, False)],
)  # fmt: skip
def test_a_machine_is_near_critical_damping_within_a_thousandth(damping, under, near_critical):
    """With k = 64 and m = 1: b^2 - 256 is within b^2/1024 for 15.9922 < b < 16.0078."""
    made = machine(mass=1, stiffness=64, damping=damping)
    assert (made.under, made.near_critical) == (under, near_critical)
    omega = 10 * mp.pi
    square = (mpf(damping) ** 2 - 256) / 4 / omega**2
    if near_critical:
        assert near(made.square, square)
    else:
        assert near(made.f**2, abs(square))


def test_whether_there_is_a_spring_or_a_damper_is_known():
    assert [machine(stiffness=0).sprung, machine(damping=0).damped] == [False, False]
    free = machine(stiffness=0, damping=0)
    assert (free.near_critical, free.under) == (True, False)
    wide = {key: None if key == "stiffness" else Fraction(x) for key, x in CONSTANTS.items()}
    with pytest.raises(check.RefusedError, match="whether there is a spring is open"):
        check.Machine(SEATED, wide, {"stiffness": arb(1, 2)})


def test_a_flight_moves_on_by_its_equation():
    """Half a second of an angle behind the start; the derivatives are those of one another."""
    made = machine()
    q, w, s, h = arb("0.3"), arb("-0.7"), arb("0.5"), arb("1e-30")
    assert all(abs(x - y) < NEAR for x, y in zip(made.state(q, w, arb(0))[:2], (q, w), strict=True))
    rows = [made.state(q, w, s + step) for step in (-h, arb(0), h)]
    for k in (0, 1):
        assert abs((rows[2][k] - rows[0][k]) / (2 * h) - rows[1][k + 1]) < arb("1e-25")
    height, rate, acceleration = rows[1]
    balance = acceleration + 2 * made.Z * rate + made.W2 * height + made.G
    assert abs(balance) < NEAR
    assert near(made.acceleration(arb(0), arb(0)), -mpf(9 + mpf(26) / 3) / (10 * mp.pi) ** 2)


@pytest.mark.parametrize(
    ("seat", "own", "expected"),
    [(True, Fraction(1, 5), "0.2"), (False, Fraction(1, 5), "0.75"), (True, None, "0.75")],
)
def test_an_impact_on_the_seat_has_its_restitution(seat, own, expected):
    known = {key: Fraction(x) for key, x in CONSTANTS.items()}
    made = check.Machine(Made(stretches=[], seat_restitution=own), known)
    assert near(made.restitution(Made(seat=seat)), mpf(expected))


OSCILLATOR = source(
    {"end": "2*pi", "polynomial": ["frequency"]}, numbers={"frequency": Fraction(5)}
)
OSCILLATOR.kind = "oscillator"


@pytest.mark.parametrize("kind", ["oscillator", "law"])
def test_an_oscillator_turns_as_fast_as_its_force(kind):
    """Where a number of its cam varies; another cam turns at the speed of the file."""
    cam = check.Cam(OSCILLATOR)
    cam.kind = kind
    known = {key: Fraction(x) for key, x in CONSTANTS.items()}
    p = check.sloped(arb(8), arb(1))
    made = check.Machine(cam, known, {"cam.frequency": p})
    omega = mpf(8) if kind == "oscillator" else 10 * mp.pi
    assert near(check.value_of(made.W2), mpf(1400) / 3 / omega**2)
    assert near(check.value_of(made.stretches[0].polynomial[0]), 8)
    standing = check.Machine(cam, known, {"mass": arb(2)})
    assert near(standing.W2, mpf(1400) / 3 / (10 * mp.pi) ** 2)
    for frequency in (arb(0), arb(1, 2), arb(-3)):
        if kind == "oscillator":
            with pytest.raises(check.RefusedError, match="the frequency is not positive"):
                check.Machine(cam, known, {"cam.frequency": frequency})
        else:
            check.Machine(cam, known, {"cam.frequency": frequency})
    assert check.of_cam({"cam.a": 1, "mass": 2, "cam.b": 3}) == {"a": 1, "b": 3}


def test_a_number_of_the_cam_may_be_its_constant_too():
    """The mass of an oscillator is left open in the file and follows from its cam."""
    given = source({"end": "2*pi"}, numbers={"frequency": Fraction(5), "mass": Fraction(2)})
    given.kind = "oscillator"
    open_mass = {key: None if key == "mass" else Fraction(x) for key, x in CONSTANTS.items()}
    made = check.Machine(check.Cam(given), open_mass, {"cam.mass": arb(4)})
    assert near(made.W2, mpf(700) / 4 / 25)
