"""Cams over their own numbers, in balls: lift, edges and derivatives against mpmath."""

import pytest
from flint import arb, arb_series
from mpmath import mp, mpf

from camcli import load_scene
from camcli.cams.balls import UndecidedError, head, precision, slope
from camcli.cams.varied import can_vary, constants_of, with_number
from camcli.exact.machine import stretches_of, varied_stretches
from tests.support.followed import Scca, arcs

DIGITS = 40
ANGLES = (1.7, 2.62, 2.7, 3.1, 3.6, 4.4)  # rad, one on each part of the circles
OSCILLATOR = {"mass": 1.1, "stiffness": 1.3, "damping_ratio": 0.05, "amplitude": 1.2,
              "frequency": 0.9, "clearance": 0.7}  # fmt: skip
LAW = {
    "kind": "law",
    "base": 0.1,
    "lift": 0.15,
    "rise": {"start_deg": 90, "length_deg": 70, "law": "cycloidal"},
    "top_dwell_deg": 40,
    "fall": {"length_deg": 60, "law": "harmonic"},
}
LAW_NUMBERS = {
    "base": 0.1,
    "lift": 0.15,
    "rise.start_deg": 90.0,
    "rise.length_deg": 70.0,
    "top_dwell_deg": 40.0,
    "fall.length_deg": 60.0,
}


def number(x) -> mpf:
    """The middle of a ball."""
    return mpf(x.mid().str(DIGITS + 10, radius=False))


def cam(section):
    """The cam of a scene."""
    constants = {} if section["kind"] == "oscillator" else {"mass": 1, "stiffness": 1}
    return load_scene({"follower": {"restitution": 0.8, **constants}, "cam": section}).cam


def check(shape, key, value, theta, exact):
    """c, c_theta and c_thetatheta at theta, and their derivatives by the number.

    exact: (angle, value) -> c.
    """
    mp.dps = DIGITS + 10
    with precision(DIGITS):
        parts = varied_stretches(with_number(shape, key, arb_series([arb(value), 1], 2)))
        stretch = next(one for one in parts if head(one.end) > theta)
        found = stretch.derivatives(arb(theta), 2)
    for order, series in enumerate(found):
        for by_number in (0, 1):
            told = number((head, slope)[by_number](series))
            other = mp.diff(exact, (mpf(theta), mpf(value)), (order, by_number))
            assert abs(told - other) < mpf("1e-12") * (1 + abs(other)), (key, order, by_number)


CIRCLES = "base_radius", "flank_center", "flank_radius", "nose_center", "nose_radius", "offset"


@pytest.mark.parametrize("key", CIRCLES)
def test_circles_over_each_number(key):
    shape = load_scene(None).cam
    home = {name: getattr(shape, name) for name in type(shape).model_fields}
    home["flank_radius"] = mpf(0.4) + mpf(0.45)

    def exact(theta, p):
        changes = {name: lambda _, n=name: home[n] for name in ("base_radius", "flank_center")}
        if key == "flank_radius":
            changes["flank_center"] = lambda p: p - mpf(0.4)
        else:
            changes[key] = lambda p: p
        return arcs(**changes)(p).c(theta)

    value = float(home[key])
    for theta in ANGLES:
        check(shape, f"cam.{key}", value, theta, exact)


def test_a_longer_dwell_begins_the_rise_earlier():
    """By half a degree a degree: c moves by c_theta pi/360 on the rise, by the opposite behind."""
    with precision(DIGITS):
        dwell = arb_series([arb(40), 1], 2)
        parts = varied_stretches(with_number(load_scene(None).cam, "cam.top_dwell_deg", dwell))
        for theta, sign in ((2.0, 1), (2.7, 1), (3.0, 1), (3.6, -1), (4.4, -1)):
            stretch = next(one for one in parts if head(one.end) > theta)
            c = stretch.derivatives(arb(theta), 3)
            for order in (0, 1, 2):
                moved = sign * head(c[order + 1]) * arb.pi() / 360
                assert abs(slope(c[order]) - moved) < 1e-30


@pytest.mark.parametrize("key", list(OSCILLATOR))
def test_an_oscillator_over_each_number(key):
    shape = cam({"kind": "oscillator", **OSCILLATOR})

    def exact(theta, p):
        of = {name: mpf(x) for name, x in OSCILLATOR.items()} | {key: p}
        spring = of["stiffness"] - of["mass"] * of["frequency"] ** 2
        damper = 2 * of["damping_ratio"] * mp.sqrt(of["stiffness"] * of["mass"]) * of["frequency"]
        force = of["amplitude"] / (spring**2 + damper**2)
        wave = spring * mp.cos(theta) + damper * mp.sin(theta)
        return force * wave - of["clearance"]

    check(shape, f"cam.{key}", OSCILLATOR[key], 2.0, exact)


def test_the_follower_and_the_speed_of_an_oscillator_go_with_its_numbers():
    shape = cam({"kind": "oscillator", **OSCILLATOR})
    with precision(DIGITS):
        (rpm,) = constants_of(with_number(shape, "cam.frequency", arb(2))).values()
        assert abs(rpm - 60 / arb.pi()) < 1e-30
        of_mass = constants_of(with_number(shape, "cam.mass", arb(4)))
        assert of_mass["mass"] == 4
        assert abs(of_mass["damping"] - 2 * arb(0.05) * arb(4 * arb(1.3)).sqrt()) < 1e-30
        (rpm,) = constants_of(with_number(shape, "cam.amplitude", arb(2))).values()
        assert abs(rpm - arb(0.9) * 30 / arb.pi()) < 1e-30


@pytest.mark.parametrize("key", list(LAW_NUMBERS))
def test_a_law_over_each_number(key):
    def exact(theta, p):
        of = {name: mpf(x) for name, x in LAW_NUMBERS.items()} | {key: p}
        x = (theta * 180 / mp.pi - of["rise.start_deg"]) / of["rise.length_deg"]
        top = of["rise.start_deg"] + of["rise.length_deg"] + of["top_dwell_deg"]
        y = (theta * 180 / mp.pi - top) / of["fall.length_deg"]
        if 0 < x < 1:
            return of["base"] + of["lift"] * (x - mp.sin(2 * mp.pi * x) / (2 * mp.pi))
        if 0 < y < 1:
            return of["base"] + of["lift"] * (1 + mp.cos(mp.pi * y)) / 2
        return of["base"] + of["lift"] * (x > 1 and y < 0)

    for theta in (0.5, 2.1, 3.0, 4.1, 5.5):
        check(cam(LAW), f"cam.{key}", LAW_NUMBERS[key], theta, exact)


WIDTHS = {"b": 0.25, "c": 0.25, "d": 0.5}


def with_widths(**widths):
    """The law with a rise of these widths."""
    return cam({**LAW, "rise": {**LAW["rise"], "law": {"scca": widths}}})


@pytest.mark.parametrize(
    ("key", "share"),
    [
        ("b", lambda p: (p, mpf("0.5") - p, mpf("0.5"))),
        ("c", lambda p: (mpf("0.5") - p, p, mpf("0.5"))),
        ("d", lambda p: (mpf("0.25"), mpf("0.75") - p, p)),
    ],
)
def test_a_law_over_each_of_its_widths(key, share):
    """The constant part goes along with the others, the sine with that."""
    for theta, zone in ((2.2, "cosine"), (2.7, "sine")):

        def exact(theta, p, zone=zone):
            origin = mp.radians(90)
            rise = Scca(mpf(0.1), mpf(0.15), origin, mp.radians(70), share(p), zone)
            return rise.laws(mp, theta - origin)[0]

        check(with_widths(**WIDTHS), f"cam.rise.law.scca.{key}", WIDTHS[key], theta, exact)


def test_the_widths_of_the_fall_are_its_own():
    """The fall begins at 200 deg with the widths that are varied, the rise keeps its own."""
    laws = {"fall": {**LAW["fall"], "law": {"scca": WIDTHS}}}
    shape = cam(
        {**LAW, **laws, "rise": {**LAW["rise"], "law": {"scca": {"b": 0.5, "c": 0.0, "d": 0.5}}}}
    )
    with precision(DIGITS):
        varied = with_number(shape, "cam.fall.law.scca.d", arb(0.625))
        assert (varied.fall.law.scca.d, varied.fall.law.scca.c) == (0.625, 0.125)
        assert varied.fall.law.scca.b == 0.25
        assert varied.rise == shape.rise


def test_a_width_of_zero_stays_zero():
    """Without a constant part the cosine goes along with the sine, and the rise has three parts."""
    shape = with_widths(b=0.25, c=0.0, d=0.75)
    with precision(DIGITS):
        varied = with_number(shape, "cam.rise.law.scca.b", arb_series([arb(0.25), 1], 2))
        assert varied.rise.law.scca.c == 0.0
        dwell, *rise, _top, _fall, _base = varied_stretches(varied)
        assert len(rise) == 3
        assert abs(slope(rise[0].end) - arb.pi() * 70 / 180 / 2) < 1e-30
        assert slope(dwell.end) == 0
    assert shape.rise.law.scca.with_width("d", 0.7).model_dump() == {"b": 0.3, "c": 0.0, "d": 0.7}


def test_a_width_that_may_vanish_is_undecided():
    with precision(DIGITS), pytest.raises(UndecidedError):
        stretches_of(with_number(with_widths(**WIDTHS), "cam.rise.law.scca.b", arb(0.45, 0.06)))


def test_a_dwell_of_no_length_is_none_wherever_a_start_in_a_ball_puts_it():
    shape = cam({**LAW, "top_dwell_deg": 0})
    with precision(DIGITS):
        for key in ("rise.start_deg", "rise.length_deg"):
            varied = with_number(shape, f"cam.{key}", arb(LAW_NUMBERS[key], 0.5))
            assert len(stretches_of(varied)) == len(stretches_of(shape)) == 4


def test_an_eccentric_over_its_lift():
    shape = cam({"kind": "eccentric", "base": 0.1, "lift": 0.02})
    check(shape, "cam.lift", 0.02, 2.0, lambda x, p: mpf(0.1) + p * (1 - mp.cos(x)) / 2)


def test_edges_move_with_the_number():
    """Corner b of the default cam, and the end of a rise, by their closed form."""
    mp.dps = DIGITS + 10
    with precision(DIGITS):
        parts = varied_stretches(
            with_number(load_scene(None).cam, "cam.nose_radius", arb_series([arb(0.15), 1], 2))
        )
        by_nose = parts[1].end
        later = varied_stretches(
            with_number(cam(LAW), "cam.rise.length_deg", arb_series([arb(70), 1], 2))
        )[1].end
    corner = arcs(nose_radius=lambda p: p)
    assert abs(number(by_nose[0]) - corner(mpf(0.15)).breakpoints[1]) < mpf("1e-30")
    slope = mp.diff(lambda p: corner(p).breakpoints[1], mpf(0.15))
    assert abs(number(by_nose[1]) - slope) < mpf("1e-12")
    assert abs(number(later[0]) - mp.radians(160)) < mpf("1e-30")
    assert abs(number(later[1]) - mp.radians(1)) < mpf("1e-30")


def test_a_ball_that_does_not_tell_the_parts_is_undecided():
    """A top dwell of 0 to 2 deg; a rise that ends before or behind the turn."""
    with precision(DIGITS), pytest.raises(UndecidedError):
        stretches_of(with_number(load_scene(None).cam, "cam.top_dwell_deg", arb(1, 1.5)))
    late = {**LAW, "rise": {**LAW["rise"], "start_deg": 290}}
    with precision(DIGITS), pytest.raises(UndecidedError):
        stretches_of(with_number(cam(late), "cam.rise.start_deg", arb(290, 1)))
    assert len(stretches_of(with_number(load_scene(None).cam, "cam.top_dwell_deg", arb(1)))) == 7


LASHED = {**LAW, "lash": 0.01, "fall": {"length_deg": 60, "law": "4-5-6-7"}}
LASH_NUMBERS = {"lash": 0.01, **LAW_NUMBERS}


def seat_of(number, value) -> tuple[mpf, mpf]:
    """Where the lobe of LASHED takes over from the seat and lets go, rad, by own root-finding."""
    of = {name: mpf(x) for name, x in LASH_NUMBERS.items()} | {number: value}
    share = of["lash"] / of["lift"]
    up = mp.findroot(lambda x: x - mp.sin(2 * mp.pi * x) / (2 * mp.pi) - share, 0.22)
    down = mp.findroot(lambda x: 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7 - share, 0.24)
    rise = of["rise.start_deg"] + of["rise.length_deg"] * up
    end = of["rise.start_deg"] + of["rise.length_deg"] + of["top_dwell_deg"]
    return mp.radians(rise), mp.radians(end + of["fall.length_deg"] * (1 - down))


@pytest.mark.parametrize("key", list(LASH_NUMBERS))
def test_corners_of_a_lash_move_with_each_number(key):
    """A ball holds the corners of all its cams, a series has their derivatives by the number."""
    mp.dps = DIGITS + 10
    shape, value = cam(LASHED), LASH_NUMBERS[key]
    radius = value * 1e-4

    def corners(number):
        """The end of the seat behind theta = 0, and the start of the next one."""
        first, *_, last = varied_stretches(with_number(shape, f"cam.{key}", number))
        assert (first.seat, last.seat) == (True, True)
        return first.end, last.start

    with precision(DIGITS):
        exact = corners(arb_series([arb(value), 1], 2))
        wide = corners(arb_series([arb(value, radius), 1], 2))
        many = with_number(shape, f"cam.{key}", arb(value, radius))
        assert len(stretches_of(many)) == len(stretches_of(shape))
    for k in (0, 1):
        assert abs(number(head(exact[k])) - seat_of(key, mpf(value))[k]) < mpf("1e-28")
        by_number = mp.diff(lambda p, k=k: seat_of(key, p)[k], mpf(value))
        assert abs(number(slope(exact[k])) - by_number) < mpf("1e-10") * (1 + abs(by_number))
        for way in (-1, 0, 1):
            exactly = seat_of(key, mpf(value) + way * mpf(radius))[k]
            with precision(DIGITS + 10):
                assert head(wide[k]).contains(arb(str(exactly)))


def test_a_ball_that_does_not_tell_where_the_seat_begins_is_undecided():
    """A lash that may be as small as none, one that may take all of the lift, and between."""
    for middle, radius in ((0.01, 0.0101), (0.15, 0.001), (0.08, 0.075)):
        with precision(DIGITS), pytest.raises(UndecidedError):
            stretches_of(with_number(cam(LASHED), "cam.lash", arb(middle, radius)))


def test_what_of_a_lash_and_of_a_table_is_not_known_in_balls():
    shape = cam(LASHED)
    assert can_vary(shape, "cam.lash")
    assert can_vary(shape, "cam.lift")
    none = cam({**LAW, "lash": 0.0})  # its seat is where its base circle is
    assert can_vary(none, "cam.lift")
    assert not can_vary(none, "cam.base")
    assert not can_vary(none, "cam.lash")
    table = load_scene("configs/lift-table.yaml").cam
    assert can_vary(table, "cam.lift_scale")
    assert not can_vary(table, "cam.zero_deg")
    lashed = load_scene("configs/lift-table.yaml", {"cam.lash": 0.0002}).cam
    assert not can_vary(lashed, "cam.lift_scale")


def test_a_table_s_fit_grows_with_its_scale_and_moves_with_its_base():
    table = load_scene("configs/lift-table.yaml").cam
    with precision(DIGITS):
        home = stretches_of(table)
        twice = stretches_of(with_number(table, "cam.lift_scale", arb(2)))
        higher = stretches_of(with_number(table, "cam.base", arb(table.base) + 1))
        assert len(home) == len(twice) == len(higher)
        for k in range(0, len(home), 40):
            middle = (home[k].start + home[k].end) / 2
            c = home[k].derivatives(middle, 2)
            assert abs(higher[k].derivatives(middle, 0)[0] - c[0] - 1) < 1e-25
            scaled = twice[k].derivatives(middle, 2)
            rise = c[0] - arb(table.base)
            assert abs(scaled[0] - arb(table.base) - 2 * rise) < 1e-25
            assert abs(scaled[1] - 2 * c[1]) < 1e-25


@pytest.mark.ci
@pytest.mark.parametrize(("key", "home", "varies"), [
    ("lift_scale", {"lift_scale": 1.5}, True),
    ("rocker_ratio", {"rocker_ratio": 1.5}, True),
    ("rocker_ratio", {"rocker_ratio": 1.5, "measured_at": "valve"}, False),  # only the lobe has it
    ("max_lift", {"lift": "fraction", "max_lift": 0.025}, True),
    ("max_lift", {}, False),
])  # fmt: skip
def test_a_table_s_fit_grows_with_each_of_its_factors(key, home, varies):
    values = {f"cam.{name}": value for name, value in home.items()}
    table = load_scene("configs/lift-table.yaml", values).cam
    assert can_vary(table, f"cam.{key}") == varies
    if not varies:
        return
    with precision(DIGITS):
        own = stretches_of(table)
        more = stretches_of(with_number(table, f"cam.{key}", arb(home[key]) * 3))
        for k in range(0, len(own), 40):
            middle = (own[k].start + own[k].end) / 2
            c, found = own[k].derivatives(middle, 1), more[k].derivatives(middle, 1)
            assert abs(found[0] - arb(table.base) - 3 * (c[0] - arb(table.base))) < 1e-25
            assert abs(found[1] - 3 * c[1]) < 1e-25
