"""The one zero in a box, by the checker's own test, on two equations whose zeros are known.

x y = p and x - y = 1 have x = (1 + sqrt(1 + 4 p))/2 and y = x - 1; near p = 6 these are 3 and 2.
"""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from flint import arb, arb_mat
from mpmath import mp, mpf, sqrt

from camcli import check
from camcli.cams.balls import precision

OFF = (mpf("1e-6"), mpf("-2e-6"), mpf(0))  # of the box's middle from the zero
HALF = mpf("1e-4")


class Equations:
    """The equations at (x, y, p), in the place of an orbit's."""

    equation_count = 2

    def equations(self, z, with_slopes):
        x, y, p = z
        slopes = arb_mat([[y, x, arb(-1)], [arb(1), arb(-1), arb(0)]]) if with_slopes else None
        return arb_mat([[x * y - p], [x - y - 1]]), slopes


def text(x) -> arb:
    return arb(mp.nstr(mpf(x), 45))


def zero(p) -> list:
    x = (1 + sqrt(1 + 4 * p)) / 2
    return [x, x - 1, p]


def tangent() -> list:
    """By p: dx = dy = 1/(x + y)."""
    return [mpf(1) / 5, mpf(1) / 5, mpf(1)]


def box_about(fixed: int, error="3e-5", half=HALF) -> SimpleNamespace:
    """A box whose unknown `fixed` leads along the zeros."""
    middle = [z + off for z, off in zip(zero(mpf(6)), OFF, strict=True)]
    along = [t / tangent()[fixed] for t in tangent()]
    free = [k for k in range(3) if k != fixed]
    rows = [[mpf(2), mpf(3), mpf(-1)], [mpf(1), mpf(-1), mpf(0)]]
    inverse = mp.matrix([[row[k] for k in free] for row in rows]) ** -1
    return SimpleNamespace(
        middle=[text(m) for m in middle], tangent=[text(t) for t in along], fixed=fixed,
        error=[arb(0) if k == fixed else arb(error) for k in range(3)], half=text(half),
        inverse=[[text(inverse[i, j]) for j in range(2)] for i in range(2)], flights=[],
    )  # fmt: skip


def shown(box, monkeypatch) -> SimpleNamespace:
    monkeypatch.setattr(check, "check_form", lambda box, size: None)
    monkeypatch.setattr(check, "without_steps", lambda orbit, box: None)
    check.Orbit.krawczyk(Equations(), box)
    return box


@pytest.fixture(autouse=True)
def many_bits():
    with precision(60), mp.workdps(50):
        yield


def at(fixed: int, eta) -> list:
    """The zero whose unknown `fixed` is so far from the box's middle."""
    value = zero(mpf(6))[fixed] + OFF[fixed] + eta
    p = {0: lambda x: x * (x - 1), 1: lambda y: y * (y + 1), 2: lambda p: p}[fixed](value)
    return zero(p)


@pytest.mark.parametrize("fixed", [0, 1, 2])
def test_a_box_holds_the_zeros_of_its_range_and_no_more_than_it_has_to(monkeypatch, fixed):
    with mp.workdps(50):
        box = shown(box_about(fixed), monkeypatch)
        for eta in (-HALF, -HALF / 3, mpf(0), HALF):
            for ball, exact in zip(box.hull, at(fixed, eta), strict=True):
                assert ball.contains(text(exact))
        for ball, exact in zip(box.center, at(fixed, mpf(0)), strict=True):
            assert ball.contains(text(exact))
            assert float(ball.rad()) < 1e-9  # much sharper than the error
        step = mpf("1e-20")
        for eta in (-HALF, mpf(0), HALF):
            here, there = at(fixed, eta), at(fixed, eta + step)
            for ball, a, b in zip(box.slope, here, there, strict=True):
                assert ball.overlaps(text((b - a) / step) + arb(0, 1e-15))
        assert box.slope[fixed] == 1
        assert all(float(ball.rad()) < 1e-3 for ball in box.slope)


@pytest.mark.parametrize(
    "change",
    [
        {"error": "1e-6"},  # the zero is farther away
        {"error": "1e-3", "half": mpf(1)},  # the tangent bends away
    ],
)
@pytest.mark.parametrize("fixed", [0, 1, 2])
def test_a_box_in_which_no_zero_is_shown_is_refused(monkeypatch, fixed, change):
    with pytest.raises(check.RefusedError, match="exactly one orbit"):
        shown(box_about(fixed, **change), monkeypatch)


def test_what_a_box_needs_is_near_the_inverse(monkeypatch):
    box = box_about(2)
    box.inverse = [[-x for x in row] for row in box.inverse]
    with pytest.raises(check.RefusedError):
        shown(box, monkeypatch)
