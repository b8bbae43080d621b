"""Published numbers of the example's periodic orbits, found by the solver of orbits."""

import pytest

from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter, multipliers
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.orbits.study import Question, orbits
from tests.conftest import chapter_system, settings

SYSTEM = chapter_system()


@pytest.fixture(scope="module")
def found():
    question = Question(700.0, span=Span(660.0, 756.0, 2.0), starts=1)
    return orbits(SYSTEM, settings(transient=60), question)


def event(found, kind, label):
    return next(b for b in found.bifurcations if (b.kind, b.label) == (kind, label))


def test_the_corner_impact_of_p11(found):
    """Speed, one-sided traces and multipliers; the two solutions are born there."""
    at = event(found, "corner-impact", "P(1;1)")
    assert (at.corner, at.classification, at.agrees) == ("b", "nonsmooth-fold", True)
    assert at.value == pytest.approx(673.234445003812, abs=1e-9)
    assert (at.left.trace, at.right.trace) == pytest.approx((1.6418699, 1.3714214), abs=5e-8)
    assert (at.left.det, at.right.det) == pytest.approx((0.64, 0.64), abs=1e-15)
    left, right = (multipliers(side.trace, side.det) for side in (at.left, at.right))
    assert left == pytest.approx((1.0051474, 0.6367225), abs=5e-8)
    assert right[0] == pytest.approx(0.6857107 + 0.4120689j, abs=1e-7)
    assert right[1] == right[0].conjugate()
    branches = [b for b in found.branches if b.labels == ["P(1;1)"]]
    assert [b.ends for b in branches] == [("corner-impact", "end-of-range")] * 2
    for branch in branches:
        assert branch.points[0].value == pytest.approx(673.234445003812, abs=1e-9)
        assert branch.points[-1].value == 756.0


def test_the_period_doubling_and_the_corner_impact_after_it(found):
    flip, at = (
        event(found, "period-doubling", "P(1;1)"),
        event(found, "corner-impact", "P(2;1:1)"),
    )
    assert flip.value == pytest.approx(739.3197802160, abs=5e-10)
    assert min(abs(m + 1.0) for m in flip.orbit.multipliers) < 1e-10
    assert (at.corner, at.agrees) == ("c", True)
    assert at.value == pytest.approx(739.3779296493, abs=5e-10)
    assert (at.left.trace, at.right.trace) == pytest.approx((1.3816246, -4.0910731), abs=5e-8)
    assert (at.left.det, at.right.det) == pytest.approx((0.4096, 0.4096), abs=1e-15)


def p11(rpm):
    """The motions P(1;1), that on A1 first."""
    shooter = Shooter(SYSTEM, rpm)
    real = [r for r in single_impact_roots(shooter, rpm, 1) if shooter.admits(r)]
    return sorted((from_root(SYSTEM, r) for r in real), key=lambda o: o.theta)


def test_the_multipliers_turn_real_at_738_7743752():
    assert p11(738.7743751)[1].multipliers[0].imag > 0
    assert all(m.imag == 0 and -1 < m.real < 0 for m in p11(738.7743753)[1].multipliers)


@pytest.mark.parametrize("rpm", [660.0, 673.2344449, 673.2344451, 690.0, 720.0, 739.4, 756.0])
def test_two_solutions_p11_exist_from_the_corner_impact_on(rpm):
    found = p11(rpm)
    assert [(o.regions, o.label) for o in found] == (
        [(("A1",), "P(1;1)"), (("A2",), "P(1;1)")] if rpm > 673.234445 else []
    )
    assert [o.stable for o in found] == [False, rpm < 739.319780216][: len(found)]


def test_both_solutions_at_700_rpm():
    unstable, stable = p11(700.0)
    degrees = [57.29577951308232 * orbit.theta[0] for orbit in (unstable, stable)]
    assert degrees == pytest.approx([104.1608293878, 155.3036856027], abs=1e-10)
    assert unstable.trace == pytest.approx(1.9307756743, abs=1e-10)
    assert stable.trace == pytest.approx(0.6027216709, abs=1e-10)
    assert abs(stable.multipliers[0]) == pytest.approx(0.8, abs=1e-14)
