"""Where a lobe passes its seat, for one cam and for all cams of a ball of numbers.

The lobe is c = a sin 2 theta on a half turn, whose corners with a seat at height h are those of
arcsin(h/a) in mpmath; a is a number, a ball, or a series in a.
"""

from __future__ import annotations

import pytest
from flint import arb, arb_series
from mpmath import asin, mp, mpf, sqrt

from camcli.cams.balls import UndecidedError, derivatives, head, precision
from camcli.cams.compile import Part
from camcli.cams.lash import Span, _spans, _spans_of_many, with_lash

SEAT, LASH, SIZE = mpf("0.1"), mpf("0.2"), mpf("0.9")
ENDS = (mpf(0), mp.pi)


def corners(size, lash=LASH) -> list:
    """The angles at which a sin 2 theta is as high as lash and seat, in one turn of the sine."""
    first = asin((SEAT + lash) / size) / 2
    return [first, mp.pi / 2 - first]


def ball(x, radius=0) -> arb:
    return arb(mp.nstr(x, 50)) + arb(0, radius)


def lobe(size) -> Part:
    """The lobe from 0 to pi, as a function of a ball or a power series."""
    return Part(ball(ENDS[0]), ball(ENDS[1]), lambda theta: size * (theta * 2).sin())


def parts_of(size, varies: bool, lash=LASH) -> list[Part]:
    return with_lash([lobe(size)], ball(lash), ball(SEAT), varies)


@pytest.mark.parametrize("radius", [0, 1e-30, 1e-12, 1e-4, 1e-2])
@pytest.mark.parametrize("lash", [LASH, SIZE * sqrt(mpf(0.5)) - SEAT], ids=["any", "an eighth"])
def test_the_corners_of_all_cams_of_a_ball_are_in_theirs(radius, lash):
    """On the seat, on the lobe, and on the seat again; no ball is much wider than it has to be.

    The second lash has its corners at an eighth of the part, where halves of it meet.
    """
    with precision(60), mp.workdps(50):
        seat, up, rest = parts_of(ball(SIZE, radius), radius > 0, lash)
        assert [part.seat for part in (seat, up, rest)] == [True, False, True]
        for k, (before, behind) in enumerate(((seat, up), (up, rest))):
            assert before.end.overlaps(behind.start)
            for off in (-0.999, 0, 0.999):
                exact = corners(SIZE + mpf(off) * mpf(radius), lash)[k]
                assert head(behind.start).overlaps(ball(exact, 1e-36))
            at = corners(SIZE, lash)[k]
            share = (SEAT + lash) / SIZE
            move = share / SIZE / sqrt(1 - share**2) / 2
            assert head(behind.start).rad() <= float(2 * move * radius) + 1e-45
            assert abs(float(head(behind.start).mid()) - float(at)) < max(1e-15, radius)
        assert seat.level.overlaps(ball(SEAT))
        assert (seat.lift, rest.lift) == (None, None)
        for theta in (0.5, 0.9, 1.2):
            lowered = up.lift(arb(theta)) if radius == 0 else head(up.lift(arb(theta)))
            exact = SIZE * mp.sin(2 * mpf(theta)) - lash
            assert lowered.overlaps(ball(exact, 1e-45))
        assert rest.end.overlaps(ball(mp.pi, 1e-45))


def test_a_corner_moves_with_the_number_of_its_cam():
    """d theta/d a = -h_a/h_theta = -tan 2 theta/(2 a)."""
    with precision(60), mp.workdps(50):
        size = arb_series([ball(SIZE), 1], 2)
        _, up, rest = parts_of(size, True)
        for corner, exact in zip((up.start, rest.start), corners(SIZE), strict=True):
            assert corner[0].overlaps(ball(exact, 1e-36))
            moved = -mp.tan(2 * exact) / (2 * SIZE)
            assert corner[1].overlaps(ball(moved, 1e-40))
            assert corner[1].rad() < 1e-30


@pytest.mark.parametrize("height", ["0.9", "0.90001", "0.89999"])
def test_cams_that_only_just_touch_the_height_of_the_seat_are_undecided(height):
    """Some of them leave it and others do not."""
    with precision(60):
        part = lobe(ball(SIZE, 1e-3))
        lift = part.lift
        with pytest.raises(UndecidedError):
            list(_spans_of_many(lambda theta: lift(theta) - arb(height), part))


@pytest.mark.parametrize(("height", "above"), [("1", False), ("-1", True)])
def test_a_lobe_that_does_not_meet_the_height_is_one_span(height, above):
    with precision(60):
        part = lobe(ball(SIZE, 1e-3))
        lift = part.lift
        for spans in (_spans, _spans_of_many):
            one = part if spans is _spans_of_many else lobe(ball(SIZE))
            found = list(spans(lambda theta: lift(theta) - arb(height), one))
            assert found == [Span(one.start, one.end, above)]


@pytest.mark.parametrize("start", ["0", "0.1", "0.4"])
def test_one_cam_and_a_ball_of_that_cam_alone_have_the_same_spans(start):
    """Also where the part begins on the lobe, whose first corner it has not."""
    with precision(60):
        part = Part(arb(start), ball(mp.pi), lobe(ball(SIZE)).lift)
        height = part.lift
        level = ball(SEAT + LASH)
        one = list(_spans(lambda theta: height(theta) - level, part))
        many = list(_spans_of_many(lambda theta: height(theta) - level, part))
        assert [span.above for span in one] == [span.above for span in many]
        assert len(one) == (2 if start == "0.4" else 3)
        for a, b in zip(one, many, strict=True):
            assert a.low.overlaps(b.low)
            assert a.high.overlaps(b.high)
        slope_at = derivatives(height, one[0].high, 1)[1]
        assert slope_at < 0 if start == "0.4" else slope_at > 0
