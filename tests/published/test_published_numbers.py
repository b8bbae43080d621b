"""Numbers of the cam-follower example (Osorio, di Bernardo & Santini 2008), from whole runs."""

from math import inf

import pytest
from conftest import settings

from camcli.analysis.classify import classify_at
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
