"""Sudden changes of chaotic attractors: the solved tangency beside runs on either side of it."""

import numpy as np
import pytest
from conftest import chapter_system, settings

from camcli.analysis.crisis import find_crisis
from camcli.analysis.engine import Orbit, Start, with_turns

RUN = settings(300, 1)


def leaves(system, rpm, start, box, turns=400_000):
    """True where a run from the start has a height at the strobe outside the box."""
    q = np.asarray(Orbit(system, rpm, with_turns(RUN, 0, turns), start).run(events=False).strobe_q)
    return bool(((q < box[0]) | (q > box[1])).any())


def carried(system, rpm):
    """(state, box of heights at the strobe) of the attractor from rest at this speed."""
    orbit = Orbit(system, rpm, with_turns(RUN, 1000, 20_000))
    q = np.asarray(orbit.run(events=False).strobe_q)
    room = 0.1 * np.ptp(q)
    return orbit.here(), (q.min() - room, q.max() + room)


@pytest.mark.parametrize(
    ("restitution", "ends", "label", "corner", "rpm", "far"),
    [
        (0.8, (740.0, 740.3), "P(7;1:1:1:1:1:1:1)", "c", 740.10648, 740.125),
        (0.75, (740.0, 741.0), "P(5;1:1:1:1:1)", "c", 740.08055, 740.12),
    ],
)
def test_interior_crisis_by_an_image_of_a_corner(restitution, ends, label, corner, rpm, far):
    """Runs decide: none leaves before the solved speed, every one a little beyond it."""
    system = chapter_system(restitution=restitution)
    found = find_crisis(system, RUN, *ends, turns=100_000)
    assert (found.kind, found.orbit.label, found.corner) == ("interior-crisis", label, corner)
    assert found.rpm == pytest.approx(rpm, abs=2e-3)
    before, after = found.evidence[0][1:]
    assert before > 0.0 > after
    large, small = found.orbit.multipliers
    assert large.real > 1.0 > abs(small)
    start, box = carried(system, ends[0])
    nudged = [Start(start.q * (1.0 + k * 1e-7), start.v, start.theta_deg) for k in range(3)]
    assert not any(leaves(system, found.rpm - 2e-3, s, box) for s in nudged)
    assert all(leaves(system, far, s, box) for s in nudged)


def test_interior_crisis_by_a_smooth_fold():
    found = find_crisis(chapter_system(), RUN, 361.0, 361.3)
    assert (found.kind, found.orbit.label, found.corner) == ("interior-crisis", "P(3;3:3:2)", "")
    assert found.rpm == pytest.approx(361.16732, abs=1e-3)
    assert found.orbit.multipliers[0].real == pytest.approx(35.94, abs=0.05)


def test_boundary_crisis_loses_chaos_to_an_orbit():
    found = find_crisis(chapter_system(), RUN, 681.0, 684.0)
    assert (found.kind, found.orbit.label, found.corner) == ("boundary-crisis", "P(1;1)", "b")
    assert found.orbit.regions == ("A1",)
    assert found.rpm == pytest.approx(682.2048, abs=2e-3)


def test_nothing_happens_to_an_orbit_that_stays():
    found = find_crisis(chapter_system(), RUN, 730.0, 731.0, turns=2000)
    assert (found.kind, found.orbit) == ("unexplained", None)
    assert "stay" in found.words[0]
