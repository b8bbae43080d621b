"""Published numbers of the example's periodic orbits, found by the solver of orbits."""

import pytest

from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from tests.conftest import chapter_system

SYSTEM = chapter_system()


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
