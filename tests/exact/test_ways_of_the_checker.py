"""How the checker writes an orbit into a cover, which boxes there are, and which orbits are one."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from flint import arb

from camcli import check


def orbit(*impacts: tuple[int, int, float], turns: int, error=1e-9):
    """A statement on an orbit: (stretch, turn, phase) of its impacts, all with the rate 0.5."""
    hull = [x for *_, phase in impacts for x in (arb(phase, error), arb(0.5, error))]
    return SimpleNamespace(
        turns=turns, box=SimpleNamespace(hull=[*hull, arb(700)]),
        impacts=[SimpleNamespace(stretch=stretch, turn=turn) for stretch, turn, _ in impacts],
    )  # fmt: skip


TWO = orbit((1, 0, 1.0), (3, 1, 2.0), turns=2)


def written(ways) -> list[list[tuple[int, float]]]:
    return [[(stretch, round(float(phase.mid()), 6)) for stretch, phase in way] for way in ways]


def test_an_orbit_is_written_from_each_of_its_impacts_on():
    """Of four stretches a turn: the stretches are counted on from the turn of the first impact."""
    found = written(check.ways(TWO, 2, 2, 4))
    assert found == [[(1, 1.0), (3 + 4, 2.0)], [(3, 2.0), (1 + 4, 1.0)]]
    twice = written(check.ways(TWO, 4, 4, 4))
    assert twice == [
        [(1, 1.0), (7, 2.0), (9, 1.0), (15, 2.0)],
        [(3, 2.0), (5, 1.0), (11, 2.0), (13, 1.0)],
    ]


@pytest.mark.parametrize(
    ("impacts", "turns"), [(1, 2), (2, 1), (2, 3), (3, 3), (2, 4), (4, 2), (3, 4), (1, 1), (5, 4)]
)
def test_an_orbit_has_no_way_where_its_numbers_do_not_fit(impacts, turns):
    assert check.ways(TWO, impacts, turns, 4) == []


def test_whole_boxes_are_those_of_impacts_one_after_the_other():
    pairs = [(a[0], b[0]) for a, b in check.whole_boxes(2, 2, 3)]
    assert pairs == [(a, b) for a in range(3) for b in range(a, a + 7)]
    assert list(check.whole_boxes(1, 5, 2)) == [[(0, 0, 0)], [(1, 0, 0)]]
    threes = [tuple(key[0] for key in box) for box in check.whole_boxes(3, 1, 2)]
    assert threes == [(a, b, c) for a in range(2) for b in range(a, a + 3) for c in range(b, a + 3)]
    assert all(key[1:] == (0, 0) for box in check.whole_boxes(3, 1, 2) for key in box)


def test_a_box_is_cut_in_half_the_later_half_first():
    assert check.halves([(7, 3, 5), (9, 0, 0)], 0) == [
        [(7, 4, 11), (9, 0, 0)],
        [(7, 4, 10), (9, 0, 0)],
    ]
    assert check.halves([(7, 3, 5), (9, 59, 2)], 1) == [
        [(7, 3, 5), (9, 60, 5)],
        [(7, 3, 5), (9, 60, 4)],
    ]
    for k, box in ((2, [(7, 3, 5), (9, 0, 0)]), (0, [(7, 60, 5)])):
        with pytest.raises(check.RefusedError):
            check.halves(box, k)


@pytest.mark.parametrize(
    ("other", "one"),
    [
        (orbit((1, 0, 1.0), (3, 1, 2.0), turns=2), True),
        (orbit((3, 0, 2.0), (1, 1, 1.0), turns=2), True),  # counted from its second impact
        (orbit((1, 0, 1.0 + 3e-9), (3, 1, 2.0), turns=2), False),
        (orbit((1, 0, 1.0 + 1e-9), (3, 1, 2.0 - 1e-9), turns=2), True),
        (orbit((1, 0, 1.0), (3, 1, 2.0), turns=1), False),
        (orbit((1, 0, 1.0), turns=2), False),
        (orbit((1, 0, 1.0), (3, 1, 2.0), (1, 2, 1.0), turns=2), False),
    ],
)
def test_which_statements_may_be_about_one_orbit(other, one):
    assert check.may_be_one(TWO, other) is one
    assert check.may_be_one(other, TWO) is one
