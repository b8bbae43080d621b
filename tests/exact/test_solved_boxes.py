"""Newton's method in a box of a cover, on equations with known roots, and the boxes themselves.

Four stretches of 90 deg; the equations and their slopes are those of a test, not of a machine.
"""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat

from camcli.analysis.orbits import all_orbits
from camcli.analysis.orbits.all_orbits import _CoverSearch, _halves, _has_phases, _TooManyError
from camcli.exact.phase_cover import Key

QUARTER = pi / 2
STRETCHES = [
    SimpleNamespace(
        start=k * QUARTER, end=(k + 1) * QUARTER, derivatives=lambda x, n: [arb(0)] * (n + 1)
    )
    for k in range(4)
]


class Space:
    """`PhaseCover` of some equations: f(phases) gives (values, slopes), or None."""

    count = 4
    machine = SimpleNamespace(stretches=STRETCHES)

    def __init__(self, f):
        self.f, self.tried = f, []

    def cell(self, key: Key):
        width = QUARTER / 2**key.depth
        low = (key.stretch % 4) * QUARTER + key.part * width
        turn = 2 * pi * (key.stretch // 4)
        ball = arb(low + width / 2, width / 2)
        return SimpleNamespace(stretch=STRETCHES[key.stretch % 4], in_turn=ball, x=ball + turn)

    def at(self, points, turns):
        assert turns == 2
        phases = [float(point.in_turn) for point in points]
        self.tried.append(phases)
        found = self.f(*phases)
        if found is None:
            return None
        values, slopes = found
        return SimpleNamespace(
            equations=(arb_mat([[x] for x in values]), arb_mat(slopes)),
            rates=[arb(0.5 + k) for k in range(len(phases))],
        )


def search(f) -> _CoverSearch:
    one = _CoverSearch.__new__(_CoverSearch)
    one.space = Space(f)
    return one


def one(root: float, of=lambda x: (x, 1.0)):
    """An equation with a root there: `of` gives value and slope at the distance from it."""

    def f(x):
        value, slope = of(x - root)
        return [value], [[slope]]

    return f


MIDDLE, HALF = 3 * QUARTER / 2, QUARTER / 2  # of the second stretch
BOX = (Key(1, 0, 0),)
SMALL = (Key(1, 2, 1),)  # its second quarter
LOW = QUARTER * 1.25


@pytest.mark.parametrize("box", [BOX, (Key(5, 0, 0),)])
@pytest.mark.parametrize("root", [QUARTER + 1e-9, MIDDLE, QUARTER + 0.2, 2 * QUARTER - 1e-9])
def test_a_root_in_a_box_is_found(box, root):
    found = search(one(root, lambda d: (sin(d), cos(d))))._solved(box, 2)
    assert found.phases == [pytest.approx(root, abs=1e-14)]
    assert found.rates == [0.5]


@pytest.mark.parametrize(
    ("root", "found"),
    [
        (LOW + 0.5 * HALF / 2, True),
        (LOW + 0.25 * HALF + 1.99 * 0.25 * HALF, True),  # twice its half width from the middle
        (LOW + 0.25 * HALF - 1.99 * 0.25 * HALF, True),
        (LOW + 0.25 * HALF + 2.01 * 0.25 * HALF, False),
        (LOW + 0.25 * HALF - 2.01 * 0.25 * HALF, False),
    ],
)
def test_a_root_beside_a_box_is_found_if_it_is_near(root, found):
    """A box of a quarter of the stretch: its half width is an eighth of a right angle."""
    solved = search(one(root))._solved(SMALL, 2)
    assert (solved is not None) is found
    if found:
        assert solved.phases == [pytest.approx(root, abs=1e-15)]


def test_a_root_on_another_stretch_or_at_its_end_is_none():
    for root in (QUARTER - 1e-9, 2 * QUARTER + 1e-9):
        assert search(one(root))._solved(BOX, 2) is None
    at_end = search(lambda x: ([0.0], [[1.0]]))
    assert at_end._solved((Key(1, 0, 0),), 2).phases == [MIDDLE]
    for edge in (QUARTER, 2 * QUARTER):
        assert search(one(edge))._solved(BOX, 2) is None


def test_a_double_root_takes_more_steps_than_are_made():
    """Newton's method halves the distance then; twelve steps do not reach 1e-12 rad."""
    double = search(one(MIDDLE + 0.1, lambda d: (d * d, 2.0 * d)))
    assert double._solved(BOX, 2) is None
    tried = [x for (x,) in double.space.tried]
    assert len(tried) == 12
    assert tried[1] - tried[0] == pytest.approx(0.05, rel=1e-9)
    assert tried[-1] == pytest.approx(MIDDLE + 0.1 - 0.1 / 2**11, rel=1e-9)
    near = search(one(MIDDLE + 1.5e-12, lambda d: (d * d, 2.0 * d)))
    assert near._solved(BOX, 2).phases == [pytest.approx(MIDDLE + 0.75e-12, abs=1e-15)]


def test_a_last_step_as_long_as_is_asked_for_does_not_end_it():
    steps = iter([0.9e-12])
    once = search(lambda x: ([next(steps)], [[1.0]]))
    assert once._solved(BOX, 2).phases == [MIDDLE - 0.9e-12]
    steps = iter([1.1e-12, 0.0])
    twice = search(lambda x: ([next(steps)], [[1.0]]))
    assert twice._solved(BOX, 2) is not None
    assert len(twice.space.tried) == 2


def test_where_there_is_no_slope_or_no_equation_there_is_no_root():
    assert search(lambda x: ([1.0], [[0.0]]))._solved(BOX, 2) is None
    assert search(lambda x: None)._solved(BOX, 2) is None
    assert search(lambda x, y: ([1.0, 1.0], [[1.0, 2.0], [2.0, 4.0]]))._solved(BOX * 2, 2) is None


def test_two_phases_are_solved_together():
    """A circle about (2, 4) and a line through its centre: one of two points is in the box."""

    def f(x, y):
        return [(x - 2) ** 2 + (y - 4) ** 2 - 0.25, 3 * (x - 2) - 4 * (y - 4)], [
            [2 * (x - 2), 2 * (y - 4)],
            [3.0, -4.0],
        ]

    box = (Key(1, 0, 0), Key(2 + 4, 0, 0))
    found = search(f)._solved(box, 2)
    assert found.phases == pytest.approx([2.4, 4.3], abs=1e-14)
    assert found.rates == [0.5, 1.5]

    def away(x, y):  # the second phase leaves its stretch
        return [x - 2.0, y - (3 * QUARTER + 0.1)], [[1.0, 0.0], [0.0, 1.0]]

    assert search(away)._solved(box, 2) is None


# -- boxes


def test_boxes_are_halved_where_they_are_widest():
    space = search(None)
    box = (Key(1, 1, 0), Key(6, 0, 0), Key(6, 0, 0))
    assert space._widest(box) == 1
    assert _halves(box, 1) == [
        (Key(1, 1, 0), Key(6, 1, 1), Key(6, 0, 0)),
        (Key(1, 1, 0), Key(6, 1, 0), Key(6, 0, 0)),
    ]
    later, earlier = _halves((Key(1, 1, 1),), 0)
    assert (later, earlier) == ((Key(1, 2, 3),), (Key(1, 2, 2),))
    (low, high), (first, last), _ = space._ends(box)
    assert (low, high) == pytest.approx((QUARTER, 1.5 * QUARTER))
    assert (first, last) == pytest.approx((6 * QUARTER, 7 * QUARTER))
    assert len(_halves((Key(0, 39, 0),), 0)) == 2
    with pytest.raises(_TooManyError):
        _halves((Key(0, 40, 0),), 0)


def test_impacts_follow_each_other_within_the_turns():
    """The first one in the first turn, the others up to the same stretch so many turns later."""
    boxes = list(search(None)._whole_boxes(1, 3))
    assert boxes == [(Key(k, 0, 0),) for k in range(4)]
    pairs = [(a.stretch, b.stretch) for a, b in search(None)._whole_boxes(2, 2)]
    assert pairs == [(a, b) for a in range(4) for b in range(a, a + 9)]
    threes = {tuple(key.stretch for key in box) for box in search(None)._whole_boxes(3, 1)}
    assert threes == {(a, b, c) for a in range(4) for b in range(a, a + 5) for c in range(b, a + 5)}


def test_a_cover_has_no_more_boxes_than_is_allowed(monkeypatch):
    counted = search(None)
    counted.made = 399_997
    spent = []
    monkeypatch.setattr(all_orbits, "spend", spent.append)
    for _ in range(3):
        counted._count_box()
    with pytest.raises(_TooManyError):
        counted._count_box()
    assert spent == [5000] * 4


def orbit(*impacts: tuple[float, int], turns: int):
    """Phases and turns of the impacts."""
    theta = [phase for phase, _ in impacts]
    root = SimpleNamespace(count=len(theta), theta=theta, turn=lambda k: impacts[k][1])
    return SimpleNamespace(root=root, turns=turns)


@pytest.mark.parametrize(
    ("phases", "turns", "has"),
    [
        ([1.0, 2.0 + 2 * pi], 2, True),
        ([2.0 + 2 * pi, 1.0 + 4 * pi], 2, True),  # from its second impact on
        ([2.0, 1.0 + 2 * pi], 2, True),  # a turn earlier
        ([1.0 + 0.9e-7, 2.0 + 2 * pi - 0.9e-7], 2, True),
        ([1.0 + 1.1e-7, 2.0 + 2 * pi], 2, False),
        ([1.0, 2.0 + 2 * pi + 1.1e-7], 2, False),
        ([1.0, 2.0], 2, False),
        ([1.0, 2.0 + 2 * pi], 1, False),
        ([1.0, 2.0 + 2 * pi], 3, False),
        ([1.0], 2, False),
        ([1.0, 2.0 + 2 * pi, 1.0 + 4 * pi, 2.0 + 6 * pi], 4, True),  # twice
        ([2.0, 1.0 + 2 * pi, 2.0 + 4 * pi, 1.0 + 6 * pi], 4, True),
        ([1.0, 2.0 + 2 * pi], 4, False),
    ],
)
def test_phases_are_those_of_a_known_orbit(phases, turns, has):
    assert _has_phases(orbit((1.0, 0), (2.0, 1), turns=2), phases, turns) is has


def test_a_root_is_asked_for_with_the_error_of_its_phases():
    """1e-9 rad to either side; where the box may hold another one, it is none."""
    asked = []
    alone = {"alone": True}
    known = search(one(MIDDLE + sqrt(2.0) / 10))
    known.space.alone = lambda box, turns, at: asked.append((box, turns, at)) or alone["alone"]
    known.orbits = [orbit((1.0, 0), turns=1), orbit((MIDDLE + sqrt(2.0) / 10, 0), turns=2)]
    assert known._orbit(BOX, 2) == 1
    ((box, turns, (ball,)),) = asked
    assert (box, turns) == (BOX, 2)
    assert float(ball.mid()) == pytest.approx(MIDDLE + sqrt(2.0) / 10, abs=1e-14)
    assert float(ball.rad()) == pytest.approx(1e-9, rel=1e-6)
    assert known._orbit((Key(5, 0, 0),), 2) == 1  # the same impact a turn later
    known._new = lambda box, root, turns: None
    known.orbits = known.orbits[:1]
    assert known._orbit(BOX, 2) is None
    known._new = lambda box, root, turns: orbit((root.phases[0], 0), turns=turns)
    assert known._orbit(BOX, 2) == 1
    assert known._orbit(BOX, 2) == 1
    assert len(known.orbits) == 2
    alone["alone"] = False
    assert known._orbit(BOX, 2) is None
