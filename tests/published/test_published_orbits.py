"""Published numbers of the chapter's periodic orbits, found by the solver of orbits."""

from functools import cache

import pytest

from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter, multipliers
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.orbits.study import Question, orbits
from camcli.kernel.certify import ADMISSIBLE
from tests.conftest import chapter_system, settings


@cache
def chapter_study():
    question = Question(700.0, span=Span(660.0, 756.0, 2.0), starts=1)
    return orbits(chapter_system(), settings(transient=60), question)


def event(kind, label):
    return next(b for b in chapter_study().bifurcations if (b.kind, b.label) == (kind, label))


def test_the_corner_impact_of_p11():
    """Speed, one-sided traces and multipliers; the two solutions are born there."""
    at = event("corner-impact", "P(1;1)")
    assert at.corner == "b"
    assert abs(at.value - 673.234445) < 5e-7
    assert abs(at.left.trace - 1.6418699) < 5e-8
    assert abs(at.right.trace - 1.3714214) < 5e-8
    assert abs(at.left.det - 0.64) < 1e-15
    assert abs(at.right.det - 0.64) < 1e-15
    large, small = multipliers(at.left.trace, at.left.det)
    assert abs(large - 1.0051474) < 5e-8
    assert abs(small - 0.6367225) < 5e-8
    upper, lower = multipliers(at.right.trace, at.right.det)
    assert abs(upper - (0.6857107 + 0.4120689j)) < 1e-7
    assert lower == upper.conjugate()
    assert at.classification == "nonsmooth-fold"
    assert at.agrees is True


def test_the_period_doubling_and_the_corner_impact_after_it():
    flip, at = event("period-doubling", "P(1;1)"), event("corner-impact", "P(2;1:1)")
    assert abs(flip.value - 739.319780) < 5e-7
    assert min(abs(m + 1.0) for m in flip.orbit.multipliers) < 1e-10
    assert at.corner == "c"
    assert abs(at.value - 739.377930) < 5e-7
    assert abs(at.left.trace - 1.3816246) < 5e-8
    assert abs(at.right.trace + 4.0910731) < 5e-8
    assert abs(at.left.det - 0.4096) < 1e-15
    assert abs(at.right.det - 0.4096) < 1e-15
    assert at.agrees is True


def stable_root(shooter, rpm):
    """The root on A2, the stable solution below the period doubling."""
    roots = [r for r in single_impact_roots(shooter, rpm, 1) if r.rates[0] < 0]
    return min(roots, key=lambda r: r.trace)


def test_the_multipliers_turn_real_at_738_7743752():
    """trace^2 = 4 det, by bisection; beyond it they are negative and part."""
    shooter = Shooter(chapter_system(), 700.0)
    low, high = 735.0, 739.3

    def excess(rpm):
        root = stable_root(shooter, rpm)
        return root.trace**2 - 4 * root.det

    assert excess(low) < 0 < excess(high)
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    assert abs(low - 738.7743752) < 5e-8
    before, after = (stable_root(shooter, low + d) for d in (-1e-3, 1e-3))
    assert multipliers(before.trace, before.det)[0].imag > 0
    pair = multipliers(after.trace, after.det)
    assert all(m.imag == 0 and -1 < m.real < 0 for m in pair)


@pytest.mark.parametrize("rpm", [673.2344451, 674.0, 690.0, 720.0, 739.4, 756.0])
def test_two_solutions_p11_exist_from_the_corner_impact_on(rpm):
    system = chapter_system()
    shooter = Shooter(system, rpm)
    real = [r for r in single_impact_roots(shooter, rpm, 1) if shooter.verdict(r)[0] == ADMISSIBLE]
    orbits = sorted((from_root(system, r) for r in real), key=lambda o: o.theta)
    assert [o.regions for o in orbits] == [("A1",), ("A2",)]
    assert [o.label for o in orbits] == ["P(1;1)"] * 2
    assert not orbits[0].stable
    assert orbits[1].stable == (rpm < 739.319780216)


@pytest.mark.parametrize("rpm", [660.0, 673.0, 673.2344449])
def test_and_none_before(rpm):
    shooter = Shooter(chapter_system(), rpm)
    roots = single_impact_roots(shooter, rpm, 1)
    assert not any(shooter.verdict(r)[0] == ADMISSIBLE for r in roots)


def test_both_branches_span_the_published_range():
    branches = [b for b in chapter_study().branches if b.labels == ["P(1;1)"]]
    assert len(branches) == 2
    for branch in branches:
        assert branch.ends == ("corner-impact", "end-of-range")
        assert abs(branch.points[0].value - 673.234445003812) < 1e-9
        assert branch.points[-1].value == 756.0
    assert all(b.agrees is not False for b in chapter_study().bifurcations)


def test_the_stable_multipliers_at_700_rpm():
    shooter = Shooter(chapter_system(), 700.0)
    root = stable_root(shooter, 700.0)
    assert abs(root.trace - 0.6027216709) < 1e-10
    assert abs(abs(multipliers(root.trace, root.det)[0]) - 0.8) < 1e-14
