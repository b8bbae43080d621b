"""A curve is laid from box to box only where every box and every joint holds; on x^2 = 1.

Its two branches x = 1 and x = -1 never meet, over any p.
"""

from collections.abc import Callable
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat

from camcli.analysis.orbits.curve_proofs import OnCurve
from camcli.cams.balls import precision
from camcli.exact.shooting import Box, NotProvedError, ProofStep, box_of


def equations(z):
    x, _ = z
    return arb_mat([[x * x - 1]]), arb_mat([[2 * x, arb(0)]])


def box(x: float, p, half=0) -> Box:
    return box_of(equations, [arb(x), arb(p)], 1, half)


def laid(first: float, last: float, branch: Callable[[float], float], motion=lambda p: True,
         ends=(0, 1)):  # fmt: skip
    """How far boxes were admitted of four from p = 0 to 1, between the points x = first and last.

    branch: the x of the box at a p; motion: whether what a box holds at its p is a motion; ends: p
    at both points, where they are others.
    """
    admitted = []

    def admit(hull):
        assert hull[1].rad() > 0.125, "a box covers its own quarter, and more"
        if not motion(float(hull[1].mid())):
            raise NotProvedError(ProofStep.CONTACT)
        admitted.append(float(hull[1].mid()))

    on = OnCurve.__new__(OnCurve)
    on.meeting = Made(n=1, admit=admit)
    on.box = lambda middle, given, half=0: box(branch(float(middle[1])), middle[1], half)
    with precision(60):
        on.chain(box(first, ends[0]), box(last, ends[1]), 1, 4)
    return admitted


def test_a_chain_of_motions_on_one_branch_is_proved():
    for x in (1.0, -1.0):
        assert laid(x, x, lambda p: x) == [0.125, 0.375, 0.625, 0.875]  # noqa: B023
        back = laid(x, x, lambda p: x, ends=(1, 0))  # noqa: B023
        assert back == [0.875, 0.625, 0.375, 0.125]


@pytest.mark.parametrize("place", [0.125, 0.375, 0.625, 0.875])
def test_a_chain_with_one_box_that_may_hold_no_motion_is_refused(place):
    with pytest.raises(NotProvedError) as refused:
        laid(1.0, 1.0, lambda p: 1.0, lambda p: abs(p - place) > 0.1)
    assert refused.value.step == ProofStep.CONTACT


@pytest.mark.parametrize(
    ("first", "last", "branch"),
    [
        (-1.0, 1.0, lambda p: 1.0),  # another branch than that of the first point
        (1.0, -1.0, lambda p: 1.0),  # or of the last one
        (1.0, -1.0, lambda p: 1.0 if p < 0.5 else -1.0),  # the boxes have no zero in common
        (1.0, 1.0, lambda p: -1.0 if 0.25 < p < 0.75 else 1.0),
    ],
)
def test_a_chain_that_leaves_its_branch_is_refused(first, last, branch):
    with pytest.raises(NotProvedError) as refused:
        laid(first, last, branch)
    assert refused.value.step == ProofStep.SINGULAR
