"""The checker's parts of a flight, on a gap that is a polynomial: which cuts show it, which do not.

gap(s) = s (s - 1)^2 (2 - s) = t^2 (1 - t^2), t = s - 1: it rises up to s = 1 - 1/sqrt(2),
touches zero at 1, falls from 1 + 1/sqrt(2) on, lands at 2, s rad after the impact at 5.5 rad.
The cam is level.
"""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import pytest
from flint import arb, ctx

from camcli import check

THETA = 5.5
TURN = 6.283185307179586
STRETCHES = [
    SimpleNamespace(
        start=arb(k) * arb.pi(), end=arb(k + 1) * arb.pi(),
        derivatives=lambda x, n: [arb(0)] * (n + 1),
    )
    for k in range(2)
]  # fmt: skip


@pytest.fixture(autouse=True)
def bits_of_the_checker():
    before, ctx.prec = ctx.prec, check.BITS
    yield
    ctx.prec = before


def motion(raised: float):
    """`Machine.state`: the gap and two derivatives, over a level cam; the touch is so high."""

    def state(c, w, s):
        t = s - 1
        square = t * t
        gap = (square + raised) * (1 - square)
        return gap, 2 * t * (1 - raised) - 4 * t * square, 2 * (1 - raised) - 12 * square

    return state


def orbit(raised=0.0, grazes=True, touch=1.0, passed=(1, 0, 0), turns=1):
    """A stub of `check.Orbit` with one impact, on stretch 1 of two; touch: rad after it."""
    machine = SimpleNamespace(stretches=STRETCHES, state=motion(raised))
    known = SimpleNamespace(
        n=1, turns=turns, grazes=grazes, at=lambda hull: machine, turned=lambda k: arb(2),
        places=[SimpleNamespace(stretch=1, turn=0)], cam=SimpleNamespace(kind="arcs"),
        event=SimpleNamespace(impact=0, touch=SimpleNamespace(stretch=passed[1], turn=passed[2])),
    )  # fmt: skip
    known.divided = lambda machine, k, passages, theta, lands: [
        check.PartOfFlight(a, b, STRETCHES[one.stretch], 2 * arb.pi() * one.turn, i)
        for i, one in enumerate(passages)
        for a, b in one.parts
    ]
    hull = [arb(THETA), arb(1), arb(touch)]
    return known, hull


def flight(*cuts: float, rise=1, fall=1, wrap=0.7832):
    """Cut at these s, up to `wrap` in the first turn and behind it in the second."""
    ends = [arb(THETA + s) for s in (0.0, *cuts, 2.0)]
    parts = list(pairwise(ends))
    first = [part for part in parts if part[0] < THETA + wrap]
    second = [part for part in parts if not part[0] < THETA + wrap]
    passages = [
        SimpleNamespace(stretch=1, turn=0, parts=first),
        SimpleNamespace(stretch=0, turn=1, parts=second),
    ]
    return SimpleNamespace(rise=rise, fall=fall, passages=passages)


CUTS = (0.15, 0.4, 0.6, 0.75, 0.85, 1.15, 1.25, 1.4, 1.6, 1.85)
PLACE = (1, 0, 1)  # the touch is above stretch 0 of the next turn


def clear(known, hull, made, **more) -> str:
    try:
        check.Orbit.clear(known, hull, 0, made, **more)
    except check.RefusedError as why:
        return str(why)
    return ""


MAY_MEET = "flight 1 may meet the cam on its way"


def test_a_flight_that_touches_where_it_is_said_is_clear():
    assert clear(*orbit(passed=PLACE), flight(*CUTS)) == ""
    assert clear(*orbit(0.05, grazes=False), flight(*CUTS)) == ""  # 0.05 above zero there


@pytest.mark.parametrize(
    ("made", "cuts"),
    [
        (orbit(passed=(1, 0, 0)), CUTS),  # the touch in another turn
        (orbit(passed=(1, 1, 1)), CUTS),  # above another stretch
        (orbit(grazes=False), CUTS),
        (orbit(touch=0.5, passed=PLACE), CUTS),  # in a part that is convex no longer
        (orbit(touch=1.3, passed=PLACE), CUTS),
        (orbit(passed=PLACE), (0.15, 0.4, 0.55, 1.45, 1.6, 1.85)),  # not convex all over
        (orbit(passed=PLACE), (*CUTS[:5], 1.0, *CUTS[5:])),  # cut there
        (orbit(-1e-3, grazes=False), CUTS),
    ],
)
def test_a_touch_elsewhere_is_refused(made, cuts):
    assert clear(*made, flight(*cuts)) == MAY_MEET


@pytest.mark.parametrize(
    ("cuts", "rise", "fall", "why"),
    [
        (CUTS, 1, 1, ""),
        ((0.1, 0.2, *CUTS[1:]), 2, 1, ""),
        ((0.1, 0.2, *CUTS[1:]), 3, 1, MAY_MEET),  # it falls again before 0.4
        ((*CUTS[:-1], 1.8, 1.9), 1, 2, ""),
        ((*CUTS[:-1], 1.8, 1.9), 1, 3, MAY_MEET),
        ((0.4, *CUTS[2:]), 1, 1, MAY_MEET),  # the first part is too long
        (CUTS[:-1], 1, 1, MAY_MEET),  # the last one is
        (CUTS, 0, 1, "flight 1 does not rise first and fall last"),
        (CUTS, 1, 0, "flight 1 does not rise first and fall last"),
        (CUTS, 6, 6, "flight 1 does not rise first and fall last"),
        (CUTS, 5, 6, MAY_MEET),
    ],
)
def test_a_flight_rises_first_and_falls_last(cuts, rise, fall, why):
    made = orbit(0.05, grazes=False)
    assert clear(*made, flight(*cuts, rise=rise, fall=fall)) == why


def test_a_flight_from_rest_begins_with_a_convex_part():
    """Where the slope is zero at first: gap = s^2 (2 - s)."""
    known, hull = orbit(grazes=False)
    rest = lambda c, w, s: (s * s * (2 - s), s * (4 - 3 * s), 4 - 6 * s)  # noqa: E731
    known.at = lambda hull: SimpleNamespace(stretches=STRETCHES, state=rest)
    cuts = (0.5, 0.9, 1.7)
    assert clear(known, hull, flight(*cuts, rise=2), lifts=True) == ""
    assert clear(known, hull, flight(*cuts, rise=2)) == MAY_MEET
    assert clear(known, hull, flight(0.7, 0.9, 1.7, rise=2), lifts=True) == MAY_MEET


def test_a_touch_is_that_of_its_own_flight():
    known, hull = orbit(passed=PLACE)
    known.event.impact = 1
    assert clear(known, hull, flight(*CUTS)) == MAY_MEET


def test_the_gap_is_that_above_the_cam_at_its_phase_within_the_turn(monkeypatch):
    """The same gap over c = x^2, where x is the phase within the turn: it is seen from the cam's
    height and slope on, and where the pieces of a fit meet by what it grows on each part."""

    def parabola(x, n):
        return [x * x, 2 * x, arb(2)][: n + 1]

    def behind_the_turn(x, n):
        assert x.mid() < 2
        return parabola(x, n)

    known, hull = orbit(0.05, grazes=False)
    gap = motion(0.05)
    told = []

    def state(c, w, s):
        told.append((c, w))
        x = arb(THETA) + s
        cam = parabola(x if s.mid() < 0.83 else x - 2 * arb.pi(), 2)  # as `flight` puts them
        return tuple(a + b for a, b in zip(gap(c, w, s), cam, strict=True))

    monkeypatch.setattr(STRETCHES[0], "derivatives", behind_the_turn)
    monkeypatch.setattr(STRETCHES[1], "derivatives", parabola)
    known.at = lambda hull: SimpleNamespace(stretches=STRETCHES, state=state)
    assert clear(known, hull, flight(*CUTS)) == ""
    assert all((c - THETA**2).contains(0) and (w - 2 * THETA - 1).contains(0) for c, w in told)
    edges: list = []
    monkeypatch.setattr(check, "above_edges", lambda *given: edges.append(given))
    known.cam.kind = "pieces"
    cuts = (0.1, 0.2, *CUTS[1:-1], 1.8, 1.9)
    assert clear(known, hull, flight(*cuts, rise=2, fall=2)) == ""
    ends = [0.0, *cuts, 2.0]
    number = len(ends) - 1
    for (k, pairs, sign), wanted in zip(
        edges, ((1, [0, 1]), (-1, [number - 1, number - 2])), strict=True
    ):
        assert (k, sign) == (0, wanted[0])
        assert len(pairs) == 2
        for (part, gain), number in zip(pairs, wanted[1], strict=True):
            low, high = ends[number : number + 2]
            assert part.start == arb(THETA + low)
            gaps = [gap(None, None, arb(s))[0] for s in (low, high)]
            assert gain.overlaps(gaps[1] - gaps[0])
            assert abs(gain - gaps[1] + gaps[0]) < 0.1


@pytest.mark.parametrize(("height", "bend", "why"), [
    (0.26, 2.0, ""), (0.24, 2.0, MAY_MEET), (0.26, -2.0, ""), (0.24, -2.0, MAY_MEET),
    (0.6, -4.0, ""), (0.4, -4.0, MAY_MEET),
])  # fmt: skip
def test_a_gap_is_above_zero_on_a_part_by_taylor(height, bend, why):
    """On a part of a rad with the slope zero in its middle: by less than bend/8 it may be lower."""
    known, hull = orbit(grazes=False)

    def state(c, w, s):
        if s.mid() < 0.5:
            return arb(0), arb(1), arb(0)
        if s.mid() > 1.5:
            return arb(0), arb(-1), arb(0)
        return arb(height), arb(0), arb(bend)

    known.at = lambda hull: SimpleNamespace(stretches=STRETCHES, state=state)
    assert clear(known, hull, flight(0.5, 1.5)) == why


def test_a_landing_is_behind_the_impact():
    known, hull = orbit(0.05, grazes=False)
    known.turned = lambda k: arb(0)
    assert clear(known, hull, flight(*CUTS)) == "flight 1 ends before it begins"


# -- passages


def passed(*passages: tuple[int, int, list[float]], turns=1, places=((1, 0),)):
    known = SimpleNamespace(
        n=len(places), turns=turns,
        places=[SimpleNamespace(stretch=stretch, turn=turn) for stretch, turn in places],
    )  # fmt: skip
    rows = [SimpleNamespace(stretch=a, turn=b, cuts=cuts) for a, b, cuts in passages]
    machine = SimpleNamespace(stretches=STRETCHES)
    return check.Orbit.divided(known, machine, 0, rows, arb(THETA), arb(THETA + TURN))


def test_a_flight_is_cut_at_the_ends_of_the_stretches_that_it_passes():
    """From stretch 1 over stretch 0 of the next turn to stretch 1 there."""
    parts = passed((1, 0, [6.0]), (0, 1, [1.0, 2.0]), (1, 1, []))
    ends = [float(part.start) for part in parts]
    turn = TURN
    assert ends == pytest.approx([5.5, 6.0, turn, turn + 1.0, turn + 2.0, 1.5 * turn])
    assert [float(part.end) for part in parts] == pytest.approx([*ends[1:], 5.5 + turn])
    assert [part.passage for part in parts] == [0, 0, 1, 1, 1, 2]
    assert [float(part.offset) for part in parts] == pytest.approx([0, 0, *[turn] * 4])
    assert [STRETCHES.index(part.stretch) for part in parts] == [1, 1, 0, 0, 0, 1]


@pytest.mark.parametrize(
    ("passages", "turns", "places"),
    [
        ([(1, 0, []), (0, 1, [])], 1, ((1, 0),)),  # it ends too early
        ([(0, 1, []), (1, 1, [])], 1, ((1, 0),)),  # it begins too late
        ([(1, 0, []), (1, 1, [])], 1, ((1, 0),)),  # a stretch is left out
        ([(1, 0, []), (0, 1, []), (0, 1, []), (1, 1, [])], 1, ((1, 0),)),  # or passed twice
        ([(1, 0, []), (0, 1, []), (1, 1, [])], 2, ((1, 0),)),
        ([(1, 0, []), (0, 1, []), (1, 1, [])], 2, ((1, 0), (0, 1))),
        ([], 1, ((1, 0),)),
    ],
)
def test_a_flight_passes_stretch_after_stretch(passages, turns, places):
    with pytest.raises(check.RefusedError, match="stretch after stretch"):
        passed(*passages, turns=turns, places=places)


def test_the_next_impact_ends_a_flight():
    assert len(passed((1, 0, []), (0, 1, []), turns=2, places=((1, 0), (0, 1)))) == 2
    with pytest.raises(check.RefusedError, match="no such stretch"):
        passed((2, 0, []))


@pytest.mark.parametrize(
    ("trace", "det", "stable", "unstable"),
    [
        (arb(1.4), arb(0.5), True, False),
        (arb(-1.4), arb(0.5), True, False),
        (arb(1.6), arb(0.5), False, True),
        (arb(-1.6), arb(0.5), False, True),
        (arb(1.5, 1e-9), arb(0.5), False, False),  # it may be on the unit circle
        (arb(0.1), arb(1.1), False, True),
        (arb(0.1), arb(1, 1e-9), False, False),
        (arb(0.1), arb(-1.2), False, True),
    ],
)
def test_an_orbit_is_stable_or_not_by_the_triangle_of_jury(trace, det, stable, unstable):
    known = SimpleNamespace(multipliers=lambda box: [trace, det])
    for asked, holds in ((True, stable), (False, unstable)):
        if holds:
            check.Orbit.steady(known, None, asked)
        else:
            with pytest.raises(check.RefusedError):
                check.Orbit.steady(known, None, asked)


def level(height_at_start: float, height_at_end: float):
    """A stretch of one rad that is so high at both of its ends."""
    heights = {0.0: height_at_start, 1.0: height_at_end}
    return SimpleNamespace(
        start=arb(0), end=arb(1), derivatives=lambda x, n: [arb(heights[float(x)])]
    )


@pytest.mark.parametrize(
    ("sign", "gains", "higher", "clear_of_it"),
    [
        (1, [0.5, 0.25], 0.74, True),  # the gap has grown to 0.75
        (1, [0.5, 0.25], 0.76, False),
        (1, [0.5, 0.25], -3.0, True),  # the cam steps down
        (-1, [-0.5, -0.25], 0.74, True),  # backwards from the landing
        (-1, [-0.5, -0.25], 0.76, False),
        (1, [0.5, -0.4], 0.2, False),
    ],
)
def test_a_step_of_the_cam_is_lower_than_the_gap_there(sign, gains, higher, clear_of_it):
    """Two parts over one stretch, then one over the next, which begins so much higher."""
    here = level(9.0, 1.0) if sign > 0 else level(1.0, 9.0)
    there = level(1.0 + higher, 9.0) if sign > 0 else level(9.0, 1.0 + higher)
    pairs = [
        (check.PartOfFlight(arb(0), arb(1), stretch, arb(0), passage), arb(gain))
        for stretch, passage, gain in (
            (here, 4, gains[0]),
            (here, 4, gains[1]),
            (there, 4 + sign, -100.0),
        )
    ]
    if clear_of_it:
        check.above_edges(0, pairs, sign)
    else:
        with pytest.raises(check.RefusedError, match="flight 1 may meet an edge of the cam"):
            check.above_edges(0, pairs, sign)


@pytest.mark.parametrize(("before", "touched"), [(0, 0), (0, 1), (1, 1), (2, 3)])
def test_where_a_flight_touches_is_counted_from_the_turn_of_its_impact(before, touched):
    """On c = theta/8, from 1/8 with the rate 1 over the cam, where q'' = -1: turns of the impact
    and of the touch, which lies on the other stretch, c = -theta^2/4."""
    ramp = check.Stretch(start=arb(0), end=arb(3), center=arb(0), polynomial=[arb(0), arb(1) / 8])
    bowl = check.Stretch(
        start=arb(3), end=arb(7), center=arb(0), polynomial=[arb(0), arb(0), arb(-1) / 4]
    )
    machine = SimpleNamespace(
        stretches=[ramp, bowl],
        state=lambda q, w, s: (q + w * s - s * s / 2, w - s, arb(-1)),
    )
    orbit = SimpleNamespace(at=lambda z: machine,
                            places=[None, SimpleNamespace(stretch=0, turn=before)])  # fmt: skip
    event = SimpleNamespace(impact=1, touch=SimpleNamespace(stretch=1, turn=touched))
    s = arb(2) + 2 * arb.pi() * (touched - before)
    slope, gap = check.touching(orbit, [None, None, arb(1), arb(1), s], event)
    at = arb(3)  # of its turn
    assert (slope - (arb(9) / 8 - s + at / 2)).contains(0)
    assert (gap - (arb(1) / 8 + 9 * s / 8 - s * s / 2 + at * at / 4)).contains(0)
