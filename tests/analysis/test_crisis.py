"""Sudden changes of chaotic attractors: the solved tangency beside runs on either side of it."""

import re
from math import inf

import numpy as np
import pytest
from conftest import chapter_system, settings

from camcli.analysis.explain.crisis import find_crisis
from camcli.analysis.explain.crisis.approach import Approach
from camcli.analysis.explain.crisis.folds import Folds
from camcli.analysis.explain.crisis.manifold import Saddle
from camcli.analysis.explain.crisis.runs import Carried
from camcli.analysis.explain.crisis.tangency import Tangency, width
from camcli.analysis.explain.crisis.words import approach_said, speed
from camcli.analysis.integrate import Orbit, Start, with_turns
from camcli.analysis.orbits.find import find
from camcli.cams.regions import corner_list

RUN = settings(300, 1)


def leaves(system, rpm, start, box, turns=400_000):
    """True where a run from the start has a height at the strobe outside the box."""
    q = np.asarray(Orbit(system, rpm, with_turns(RUN, 0, turns), start).run(events=False).strobe_q)
    return bool(((q < box[0]) | (q > box[1])).any())


def reads_well(words):
    """Sentences for people: no tuples, no repr of a float, no text of an error."""
    for said in words:
        assert said[0].isupper()
        assert said.endswith(".")
        assert not re.search(r"\d\.\d{7}|None|inf\b|run\.start|found|\(\(", said)


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
    found = find_crisis(system, RUN, *ends)
    assert (found.kind, found.orbit.label, found.corner) == ("interior-crisis", label, corner)
    assert found.rpm == pytest.approx(rpm, abs=2e-3)
    fold = found.evidence[0]
    assert fold.before > 0.0 > fold.after
    assert 1e-4 < found.error < 2e-3
    assert abs(found.rpm - rpm) < found.error
    assert "The fold that touches is the image of an impact at corner c." in found.words
    reads_well(found.words)
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
    assert abs(found.rpm - 361.1673134) < found.error < 1e-4  # a fold that finer samples solve
    assert "The fold that touches is smooth." in found.words
    reads_well(found.words)


def test_boundary_crisis_loses_chaos_to_an_orbit():
    found = find_crisis(chapter_system(), RUN, 681.0, 684.0)
    assert (found.kind, found.orbit.label, found.corner) == ("boundary-crisis", "P(1;1)", "b")
    assert found.orbit.regions == ("A1",)
    assert found.rpm == pytest.approx(682.2048, abs=2e-3)
    assert any(said.startswith("P(8;2:1:2:1:1:1:1:1) leads out") for said in found.words)
    reads_well(found.words)  # starts beside P(8;...) lie below the cam: nothing is said of them


def test_nothing_happens_to_an_orbit_that_stays():
    found = find_crisis(chapter_system(), RUN, 730.0, 731.0, turns=2000)
    assert (found.kind, found.orbit, found.error) == ("unexplained", None, inf)
    assert found.words == ("The motion carried from 730 rpm is not chaotic.",)


def test_the_end_says_which_attractor_is_carried():
    """The large attractor beyond the crisis holds the small one: carried back, nothing leaves."""
    found = find_crisis(chapter_system(), RUN, 740.0, 740.3, end="upper", turns=20_000)
    assert (found.kind, found.rpm) == ("unexplained", 740.0)
    assert found.words[0].startswith("Nothing leaves the attractor carried from 740.3 rpm")
    with pytest.raises(ValueError, match="found end 'left', expected one of lower, upper"):
        find_crisis(chapter_system(), RUN, 740.0, 740.3, end="left")


def test_a_start_below_the_cam_is_no_motion():
    system = chapter_system()
    study = Carried(system, RUN, 740.0, 740.3, 2000)
    orbit = find(system, 740.0, RUN, 0, "P(1;1)").orbits[0]
    saddle = Saddle(study, 740.0, orbit)
    assert abs(saddle.mu) == pytest.approx(abs(orbit.multipliers[0]), rel=1e-5)
    folds = Folds(study, orbit, orbit, 1.0)
    starts = [saddle.leaf(t) for t in (0.0, 30.0)]
    assert np.isfinite(folds.places(740.0, (saddle, saddle), 0.0, 3)).all()
    down = 30.0 if starts[1][0] < starts[0][0] else None
    saddle.axes = saddle.axes if down else -saddle.axes
    assert not np.isfinite(folds.places(740.0, (saddle, saddle), 30.0, 3)).any()


@pytest.mark.parametrize(
    ("solved", "error"),
    [
        ([740.1, 740.103], 3e-3),  # the next fold solved
        ([740.1, 740.1 + 1e-8], 3.0 * 0.02),  # one fold: what the runs allow
        ([740.1, 740.10001], 4e-7 * 740.1),  # folds that happen to agree
        ([740.14, 740.1401], 0.02),  # runs have left before: not the first fold
    ],
)
def test_error_by_scatter_and_by_runs(solved, error):
    study = Carried(chapter_system(), RUN, 740.0, 740.3, 100)
    study.bracket = (740.119, 740.12)
    first = Tangency(solved[0], 60, 0.1, 1e-9, 0.01, 0.0)
    assert width(Folds(study, None, None, 1.0), first, solved) == pytest.approx(error, rel=1e-6)


@pytest.mark.parametrize(
    ("error", "text"),
    [(3e-4, "740.1065"), (2e-5, "740.10648"), (0.3, "740.1"), (40.0, "740"), (inf, "740.1064781")],
)
def test_speeds_have_the_digits_of_their_error(error, text):
    assert speed(740.10647809678, error) == text


def test_what_is_not_the_cause_is_said_plainly(chapter):
    a, b = corner_list(chapter.cam)[:2]
    rows = ((a, 1e-7, 1e-7), (b, 0.08, 0.075))
    assert approach_said(Approach("", 740.0, None, rows, (inf, inf), 1e-6), False) == [
        "Impacts reach corner a already before it.",
        "No impact comes nearer than 4.3 deg to corner b and no flight has a low gap: "
        "neither causes it.",
    ]
    assert approach_said(Approach("", 740.0, None, rows, (0.0, 0.02), 1e-6), False)[1:] == [
        "Contacts of hardly any force occur already before it.",
        "No impact comes nearer than 4.3 deg to corner b: this does not cause it.",
    ]
    assert approach_said(Approach("corner-impact", 740.0, b, rows, (inf, inf), 1e-6), True)[1:] == [
        "Impacts draw near to corner b and reach it there for the first time, "
        "by a line through two runs.",
    ]
