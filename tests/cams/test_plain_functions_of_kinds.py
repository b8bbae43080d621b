"""Arcs, laws, oscillators and varied cams, each function asked alone."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from types import SimpleNamespace as Stub

import pytest
from flint import arb, fmpq
from pydantic import ValidationError

from camcli.cams import ArcsCam, EccentricCam, LawCam
from camcli.cams import law as laws
from camcli.cams.arcs import Circle
from camcli.cams.balls import derivatives, number, precision
from camcli.cams.compile import Part, Piece
from camcli.cams.lash import _slopes_through_zero, _varies, with_lash
from camcli.cams.law import SccaLaw, Widths, within_turn
from camcli.cams.oscillator import OscillatorCam
from camcli.cams.varied import ScaledTable, can_vary, with_number
from camcli.kernel.cam_table import TERMS

ARCS = {
    "kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
    "nose_center": 0.4, "nose_radius": 0.15, "top_dwell_deg": 40.0, "offset": 0.07,
}  # fmt: skip


def law_cam(**changes) -> LawCam:
    usual = {
        "kind": "law", "base": 0.01, "lift": 0.02, "top_dwell_deg": 20.0,
        "rise": {"law": "cycloidal", "start_deg": 30.0, "length_deg": 80.0},
        "fall": {"law": {"scca": {"b": 0.2, "c": 0.3, "d": 0.5}}, "length_deg": 90.0},
    }  # fmt: skip
    return LawCam(**{**usual, **changes})


# -- arcs --------------------------------------------------------------------------------------


@pytest.mark.parametrize("center", ["0.4", "-0.45"])
def test_the_slopes_of_a_circle_are_the_derivatives_of_its_lift(center):
    with precision(50):
        part = Circle(arb(center), arb("0.85"), arb("0.07")).part(arb(0), arb(1), arb("0.3"))
        for theta in ("0.1", "0.3", "0.77"):
            found = part.slopes(arb(theta))
            exact = derivatives(part.lift, arb(theta), 3)
            assert len(found) == 4
            for a, b in zip(found, exact, strict=True):
                assert abs(a - b) < 1e-40
        line = arb(center) + arb("0.85") - arb("0.07")  # above the axis of the circle
        assert abs(part.lift(arb("0.3")) - line) < 1e-40


@pytest.mark.parametrize(("dwell", "count"), [(40.0, 7), (0.0, 6)])
def test_the_parts_of_an_outline_last_and_its_flank_closes(dwell, count):
    """0.4 + 0.4500001 is not quite flank_radius: the sum counts."""
    cam = ArcsCam(**{**ARCS, "top_dwell_deg": dwell, "flank_center": 0.45 + 4e-10})
    with precision(50):
        parts = cam.lobe()
        assert len(parts) == count
        assert all(part.start < part.end for part in parts)
        flank = parts[1]
        assert abs(flank.lift(flank.start) - (number(0.4) - number(0.07))) < 1e-40
        slope = derivatives(flank.lift, flank.start, 1)[1]
        assert abs(slope) < 1e-40


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(
    ("gap", "closes"), [(0.9, True), (-0.9, True), (1.1, False), (-1.1, False)]
)
def test_the_gap_of_a_flank_is_held_against_its_size(size, gap, closes):
    lengths = {k: size * v for k, v in ARCS.items() if k not in ("kind", "top_dwell_deg")}
    lengths["flank_center"] += gap * 1e-9 * lengths["flank_radius"]
    values = {**ARCS, **lengths}
    if closes:
        ArcsCam(**values)
    else:
        with pytest.raises(ValidationError, match="misses the base circle"):
            ArcsCam(**values)


# -- laws --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("widths", "name", "value", "wanted"),
    [
        ((0.2, 0.3, 0.5), "b", 0.1, (0.1, 0.4, 0.5)),
        ((0.2, 0.3, 0.5), "c", 0.4, (0.1, 0.4, 0.5)),
        ((0.2, 0.3, 0.5), "d", 0.1, (0.2, 0.7, 0.1)),  # 1 - 0.1 - 0.2 in decimals
        ((0.4, 0.0, 0.6), "b", 0.7, (0.7, 0.0, 0.3)),
        ((0.4, 0.0, 0.6), "d", 0.7, (0.3, 0.0, 0.7)),
        ((0.0, 0.4, 0.6), "c", 0.5, (0.0, 0.5, 0.5)),
        ((0.0, 0.0, 1.0), "d", 0.75, (0.0, 0.25, 0.75)),
        ((0.4, 0.6, 0.0), "c", 0.5, (0.5, 0.5, 0.0)),
    ],
)
def test_another_width_goes_along_so_that_the_sum_stays_one(widths, name, value, wanted):
    given = Widths(**dict(zip("bcd", widths, strict=True)))
    found = given.with_width(name, value)
    assert (found.b, found.c, found.d) == wanted
    with precision(50):
        found = given.with_width(name, arb(value))
        assert abs(number(found.b) + number(found.c) + number(found.d) - 1) < 1e-15
        assert getattr(found, name) == value
        for one, width in zip("bcd", wanted, strict=True):
            assert float(number(getattr(found, one))) == pytest.approx(width, abs=1e-15)


@pytest.mark.parametrize("total", [0.9, 1.1])
def test_widths_that_do_not_add_up_to_one_are_refused(total):
    with pytest.raises(ValidationError, match="the sum must be 1"):
        Widths(b=0.2, c=total - 0.7, d=0.5)
    Widths(b=0.2, c=0.3 + 5e-10, d=0.5)


def test_widths_are_the_decimal_numbers_that_were_written():
    """Beside one that varies each counts; else the second is what the others leave."""
    tenth, three, six = Fraction(1, 10), Fraction(3, 10), Fraction(6, 10)
    assert laws._widths(Stub(b=0.1, c=0.3 + 5e-10, d=0.6)) == (tenth, three, six)
    assert laws._widths(Stub(b=0.7, c=0.0, d=0.3 + 5e-10)) == (1 - three, 0, three)
    for place in range(3):
        given, wanted = [0.1, 0.3, 0.6], [tenth, three, six]
        given[place] = wanted[place] = arb(0.25)
        b, c, d = given
        assert list(laws._widths(Stub(b=b, c=c, d=d))) == wanted


@pytest.mark.parametrize(
    ("widths", "edges"),
    [
        ((0.2, 0.3, 0.5), [0, 0.1, 0.25, 0.75, 0.9, 1]),
        ((0.4, 0.6, 0.0), [0, 0.2, 0.5, 0.8, 1]),
        ((0.0, 0.4, 0.6), [0, 0.2, 0.8, 1]),
        ((0.4, 0.0, 0.6), [0, 0.2, 0.8, 1]),
        ((0.0, 0.0, 1.0), [0, 1]),
        ((0.0, 1.0, 0.0), [0, 0.5, 1]),
        ((1.0, 0.0, 0.0), [0, 0.5, 1]),
        ((0.5, 0.0, 0.5), [0, 1]),
    ],
)
def test_zones_of_no_width_are_left_out_of_a_law(widths, edges):
    b, c, d = widths
    segments = laws._segments(SccaLaw(scca={"b": b, "c": c, "d": d}))
    assert [float(one.start) for one in segments] == edges[:-1]
    assert [float(one.end) for one in segments] == edges[1:]
    with precision(50):
        for one, behind in pairwise(segments):
            for k in (0, 1):
                before, after = (
                    derivatives(s.height, number(one.end), 1)[k] for s in (one, behind)
                )
                assert abs(before - after) < 1e-12
        assert abs(segments[0].height(arb(0))) < 1e-40
        assert abs(segments[-1].height(arb(1)) - 1) < 1e-12


def test_a_ball_about_zero_is_laid_within_the_turn_as_narrow_as_it_is():
    for angle in (0, 360, -360, 720):
        found = within_turn(arb(angle) + arb(0, 1e-12))
        assert found.rad() < 1e-10
        assert found.contains(0) or found.contains(360)
    assert within_turn(fmpq(-7, 2)) == fmpq(713, 2)


# -- oscillators -------------------------------------------------------------------------------


def test_the_damping_of_an_oscillator_is_its_ratio_of_twice_the_root():
    with precision(50):
        for ratio, product in ((0.3, 2.5), (arb("0.3"), 2.5), (0.3, arb("2.5"))):
            cam = Stub(damping_ratio=ratio, stiffness=product, mass=1.0, damping=None)
            found = OscillatorCam.follower_damping.fget(cam)
            assert float(found) == pytest.approx(0.6 * 2.5**0.5, rel=1e-15)
    for damping in (None, 0.7):
        cam = Stub(damping_ratio=None, damping=damping)
        assert OscillatorCam.follower_damping.fget(cam) == (damping or 0.0)


def test_an_oscillator_has_one_damping_and_moves_a_million_metres_at_most():
    plain = {"kind": "oscillator", "frequency": 0.5, "clearance": 0.0}
    for ratio in (0.0, 0.3):
        with pytest.raises(ValidationError, match="leave one of them out"):
            OscillatorCam(**plain, damping=0.0, damping_ratio=ratio)
    near = {**plain, "stiffness": 0.25}
    with pytest.raises(ValidationError, match="no steady motion"):
        OscillatorCam(**near)
    OscillatorCam(**near, damping=2.1e-6)  # 1/(2.1e-6 * 0.5)
    with pytest.raises(ValidationError, match=r"1\.053e\+06 m high: at most 1e6 m"):
        OscillatorCam(**near, damping=1.9e-6)


# -- cams whose numbers vary -------------------------------------------------------------------


def test_a_flank_radius_and_a_width_of_a_law_take_another_number_along():
    with precision(50):
        varied = with_number(ArcsCam(**ARCS), "cam.flank_radius", arb("0.9"))
        assert varied.flank_radius == 0.85
        assert abs(varied.flank_center - (arb("0.9") - number(0.4))) < 1e-40
        cam = law_cam()
        varied = with_number(cam, "cam.fall.law.scca.d", arb(5) / 8)
        widths = varied.fall.law.scca
        assert (widths.b, widths.d) == (0.2, arb(5) / 8)
        assert abs(widths.c - arb("0.175")) < 1e-15
        varied = with_number(cam, "cam.rise.length_deg", arb(70))
        assert (varied.rise.length_deg, varied.rise.law) == (arb(70), "cycloidal")
        assert varied.fall == cam.fall
        for one in (
            varied,
            with_number(cam, "cam.lift", arb(1)),
        ):
            assert _varies(one)
    assert not _varies(cam)
    assert can_vary(cam, "cam.rise.length_deg")


def test_a_table_with_lash_has_no_other_numbers():
    table = {"kind": "table", "base": 0.1, "lift_scale": 1.0, "max_lift": None,
             "measured_at": "lobe", "rocker_ratio": 1.0}  # fmt: skip
    assert can_vary(Stub(**table, lash=None), "cam.lift_scale")
    for lash in (0.0, 0.001):
        assert not can_vary(Stub(**table, lash=lash), "cam.lift_scale")


def test_the_parts_of_a_scaled_table_are_its_pieces_and_dwells_moved():
    """Three pieces on 1 to 2.5 and a dwell; the table's base is 0.25."""
    pieces = tuple(
        Piece(1.25 + 0.5 * k, 0.25, (0.3 + k, 0.5, -0.2) + (0.0,) * (TERMS - 3)) for k in range(3)
    )
    drawn = [Part(arb(1), arb("2.5"), None, pieces=pieces), Part(arb("2.5"), arb(3), None, arb(2))]
    table = Stub(parts=lambda: drawn, base=0.25)
    with precision(50):
        parts = ScaledTable(table, arb(3), arb("0.7")).parts()
        assert [(float(one.start), float(one.end)) for one in parts] == [
            (1.0, 1.5), (1.5, 2.0), (2.0, 2.5), (2.5, 3.0)
        ]  # fmt: skip
        assert abs(parts[3].level - (arb("0.7") + 3 * arb("1.75"))) < 1e-40
        for k, one in enumerate(parts[:3]):
            x = arb("0.1")
            c = number(0.3 + k) + number(0.5) * x + number(-0.2) * x * x
            theta = arb(pieces[k].center) + x
            assert abs(one.lift(theta) - (arb("0.7") + 3 * (c - arb("0.25")))) < 1e-40


# -- lash --------------------------------------------------------------------------------------


def test_a_dwell_at_the_height_of_the_seat_is_the_seat():
    """And slopes of a lobe are lowered with it."""
    level = Part(arb(0), arb(1), None, arb("2.75"))
    lobe = Part(arb(1), arb(2), lambda theta: theta + 9, slopes=lambda theta: [theta + 9, 1, 0, 7])
    with precision(50):
        seat, above = with_lash([level, lobe], arb("0.75"), arb(2))
        assert (seat.seat, seat.level) == (True, 2)
        assert [float(x) for x in above.slopes(arb("1.5"))] == [9.75, 1.0, 0.0, 7.0]


@pytest.mark.parametrize(
    ("zeros", "start"), [((1.3,), 0.0), ((1.1, 2.3), 0.0), ((0.4, 1.9, 3.3), -0.6)]
)
def test_where_a_height_may_be_zero_it_has_a_slope_of_one_sign(zeros, start):
    """A polynomial with these zeros, from its start to 4."""

    def height(x):
        total = x - zeros[0]
        for zero in zeros[1:]:
            total = total * (x - zero)
        return total

    with precision(50):
        slopes = _slopes_through_zero(height, arb(start), arb(4))
    assert len(slopes) == len(zeros)
    for k, (one, zero) in enumerate(zip(slopes, zeros, strict=True)):
        assert float(one.low) < zero < float(one.high)
        rising = (len(zeros) - k) % 2 == 1
        assert (one.rate > 0) is rising
        assert (one.rate < 0) is not rising
        for share in (0.1, 0.9):
            at = Fraction(share) * (Fraction(float(one.high)) - Fraction(float(one.low)))
            rate = derivatives(height, arb(float(Fraction(float(one.low)) + at)), 1)[1]
            assert one.rate.contains(rate)


def test_numbers_of_an_eccentric_vary():
    cam = EccentricCam(kind="eccentric", base=0.1, lift=0.3)
    assert not _varies(cam)
    assert _varies(cam.model_copy(update={"lift": arb(1)}))
