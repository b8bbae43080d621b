"""Numbers of the cam-follower example (Osorio, di Bernardo & Santini 2008), run and solved."""

from math import inf

import pytest
from conftest import settings

from camcli.analysis.classify import classify_at
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.system import omega_of

COEXISTING = {"q": 0.546, "v": 32.48}


@pytest.mark.parametrize(
    ("rpm", "start", "label", "impacts", "chatter"),
    [
        (100.0, {}, "contact", 0.0, "none"),
        (114.9, {}, "contact", 0.0, "none"),
        (190.0, {}, "P(1;inf)", inf, "complete"),
        # At 358.0 rpm even the 17th digit of the data decides, and doubles may close a cycle by
        # rounding; most of what lies within it settles on this orbit.
        (358.0, {}, "P(3;3:3:2)", 8.0, "none"),
        (358.5, {}, "P(3;3:3:2)", 8.0, "none"),
        (359.0, {}, "P(3;3:3:2)", 8.0, "none"),
        (358.0, COEXISTING, "P(1;2)", 2.0, "none"),
        (358.5, COEXISTING, "P(1;2)", 2.0, "none"),
        (359.0, COEXISTING, "P(1;2)", 2.0, "none"),
        (360.0, {}, "P(6;3:3:2:3:3:2)", 16.0, "none"),
        (684.0, {}, "P(1;1)", 1.0, "none"),
        (700.0, {}, "P(1;1)", 1.0, "none"),
    ],
)
def test_attractors(chapter, rpm, start, label, impacts, chatter):
    motion = classify_at(chapter, rpm, settings(600, 400, **start))
    assert (motion.label, motion.impacts, motion.chatter) == (label, impacts, chatter)
    assert motion.stable
    if (rpm, label) == (358.5, "P(1;2)"):
        ((q, w),) = motion.orbit.states
        assert (q, w * omega_of(rpm)) == pytest.approx((0.546, 32.48), abs=1e-2)
        assert q == pytest.approx(0.546, abs=5e-4)


@pytest.mark.parametrize("rpm", [361.0, 682.0, 745.0])
def test_chaos_has_a_positive_exponent_with_an_error_bar(chapter, rpm):
    motion = classify_at(chapter, rpm, settings(600, 400))
    assert (motion.label, motion.period, motion.stable) == ("aperiodic", 0, None)
    assert motion.exponents.largest > 3.0 * motion.exponents.spread > 0.0


def p11(chapter, rpm):
    """The motions P(1;1), that on A1 first."""
    shooter = Shooter(chapter, rpm)
    real = [r for r in single_impact_roots(shooter, rpm, 1) if shooter.admits(r)]
    return sorted((from_root(chapter, r) for r in real), key=lambda o: o.theta)


def test_the_multipliers_turn_real_at_738_7743752(chapter):
    assert p11(chapter, 738.7743751)[1].multipliers[0].imag > 0
    assert all(m.imag == 0 and -1 < m.real < 0 for m in p11(chapter, 738.7743753)[1].multipliers)


@pytest.mark.parametrize("rpm", [660.0, 673.2344449, 673.2344451, 690.0, 720.0, 739.4, 756.0])
def test_two_solutions_p11_exist_from_the_corner_impact_on(chapter, rpm):
    found = p11(chapter, rpm)
    assert [(o.regions, o.label) for o in found] == (
        [(("A1",), "P(1;1)"), (("A2",), "P(1;1)")] if rpm > 673.234445 else []
    )
    assert [o.stable for o in found] == [False, rpm < 739.319780216][: len(found)]


def test_both_solutions_at_700_rpm(chapter):
    unstable, stable = p11(chapter, 700.0)
    degrees = [57.29577951308232 * orbit.theta[0] for orbit in (unstable, stable)]
    assert degrees == pytest.approx([104.1608293878, 155.3036856027], abs=1e-10)
    assert unstable.trace == pytest.approx(1.9307756743, abs=1e-10)
    assert stable.trace == pytest.approx(0.6027216709, abs=1e-10)
    assert abs(stable.multipliers[0]) == pytest.approx(0.8, abs=1e-14)
