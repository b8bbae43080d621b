"""How long a motion is followed before it is called aperiodic, by every command alike."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import settings

import camcli
from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.classify import COMPLETE, classify_at
from camcli.analysis.explain import changes
from camcli.analysis.explain.changes import BASIN, Events, LabelChange, _change
from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import Cost, Orbit
from camcli.analysis.labels import APERIODIC, UNDECIDED
from camcli.analysis.sweep import SURE, sweep
from camcli.scene import load_scene
from tests.analysis.test_crisis import motion

RUN = settings(600, 400)


def tail(system, rpm, turns):
    """Heights at the strobe of the last 50 of so many turns from rest, and impacts in each."""
    record = Orbit(system, rpm, settings(turns - 50, 50)).run()
    return record.strobe_q[:50], record.impacts[:50]


@pytest.mark.parametrize(("skipped", "rpm"), [(0, 745.0), (37, 745.0), (5, 190.0)])
def test_an_orbit_goes_on_to_the_last_bit(chapter, skipped, rpm):
    """In the air, and at rest on the cam."""
    whole = Orbit(chapter, rpm, settings(20, 100 + skipped)).run()
    first = Orbit(chapter, rpm, settings(20, 30))
    first.run()
    rest = first.go_on(skipped, 70).run()
    at = 30 + skipped
    assert rest.strobe_q[:70].tobytes() == whole.strobe_q[at : at + 70].tobytes()
    assert rest.strobe_w[:70].tobytes() == whole.strobe_w[at : at + 70].tobytes()
    assert rest.impacts[:70].tolist() == whole.impacts[at : at + 70].tolist()
    own = whole.period >= at
    assert (
        rest.theta[rest.period < 70].tobytes()
        == whole.theta[own][whole.period[own] < at + 70].tobytes()
    )


@pytest.mark.parametrize("rpm", [682.25, 682.5])
def test_chaos_that_ends_is_what_it_ends_on(chapter, rpm):
    """The boundary crisis is at 682.2046 rpm; the record of 400 turns shows nothing but chaos."""
    q, impacts = tail(chapter, rpm, 21_000)
    assert (impacts == 1).all()
    assert np.ptp(q) < 1e-9
    found = classify_at(chapter, rpm, RUN)
    assert found.label == "P(1;1)"
    assert abs(found.orbit.states[0][0] - q[-1]) < 1e-9
    assert 1000 < found.watched <= 21_000
    simulated = camcli.simulate(load_scene(None, {"run.rpm": rpm}))
    assert simulated.summary["label"] == "P(1;1)"
    assert any("has settled on P(1;1)" in note for note in simulated.notes)


def test_a_motion_is_followed_as_long_as_is_asked(chapter):
    """Just past the crisis chaos outlives some thousand turns, and the row says how many it had."""
    for patience in (0, 1000):
        found = classify_at(chapter, 682.25, replace(RUN, patience=patience))
        assert (found.label, found.watched) == ("aperiodic", 1000 + patience)
    assert classify_at(chapter, 745.0, RUN).watched == 21_000
    assert classify_at(chapter, 700.0, RUN).watched is None


@pytest.mark.parametrize("rpm", [632.5, 640.0])
def test_chaos_that_comes_to_a_rest_is_undecided(chapter, rpm):
    """Thousands of turns after the record: the motion repeats itself from there on."""
    record = Orbit(chapter, rpm, settings(1000, 3000)).run(events=False)
    first = 1000 + int(np.flatnonzero(record.chatter)[0])
    found = classify_at(chapter, rpm, RUN)
    assert (found.label, found.chatter, found.watched) == (UNDECIDED, COMPLETE, first + 1)


def test_a_sweep_follows_the_ends_of_a_chaotic_range(chapter):
    """Inwards until two in a row stay; the rows show the orbit, tables and label agree."""
    speeds = sweep(chapter, rpm_grid(681.0, 683.0, 9), RUN).speeds
    labels = [speed.label for speed in speeds]
    assert labels[:5] == ["aperiodic"] * 5 or UNDECIDED in labels[:5]
    assert labels[5:] == ["P(1;1)"] * 4
    ends = [k for k, speed in enumerate(speeds) if (speed.watched or 0) > 1000]
    assert {3, 4, 5, 6} <= set(ends)
    stay = [speeds[k].label == APERIODIC for k in range(3, 5)]
    assert stay == [True] * SURE
    for speed in speeds[5:]:
        q = speed.strobe[1]
        assert len(q) == 400
        assert np.ptp(q) < 1e-6
        assert speed.impact_count == 400 == len(speed.impacts[0])
    assert [a.value < b.value for a, b in pairwise(speeds)] == [True] * 8


def test_a_sweep_that_carries_its_state_follows_where_it_was(chapter):
    (first, second) = sweep(chapter, [682.25, 682.5], RUN, direction="up").speeds
    assert (first.label, second.label) == ("P(1;1)", "P(1;1)")
    assert first.watched > 1000


def test_a_record_too_short_for_a_period_tells_nothing(chapter):
    """Two turns of sixteen impacts that differ; and ten turns: what follows them has a name."""
    (speed,) = sweep(chapter, [199.0], settings(2, 2)).speeds
    assert speed.impact_count >= 16
    assert speed.label.startswith("P(")
    rpms = [*rpm_grid(740.5, 745.5, 6), 746.0]  # the middle ones are no ends
    found = sweep(chapter, rpms, settings(100, 10)).speeds
    assert {speed.label for speed in found} == {APERIODIC}
    assert [speed.watched for speed in found[2:5]] == [110] * 3


def test_chaos_that_is_lost_is_no_change_of_basins(chapter):
    """P(1;1) attracts on both sides; whether the chaos does is known only after a search."""
    before, after = motion(682.21, APERIODIC, 0.5), motion(684.0, "P(1;1)")
    after.orbit = SimpleNamespace(resting=False)
    points = [SimpleNamespace(value=rpm, label="P(1;1)", stable=True) for rpm in (680.0, 690.0)]
    events = Events([], [], [SimpleNamespace(points=points)], Cost())
    change = _change(chapter, RUN, events, before, after, False)
    assert change.persists == ("P(1;1)",)
    assert change.cause != BASIN


def test_an_undecided_motion_between_two_is_passed_over(chapter, monkeypatch):
    """Chaos that rests too rarely to be followed hides no crisis behind it."""
    nothing = Events([], [], [], Cost())
    monkeypatch.setattr(changes, "find_events", lambda *words: nothing)
    monkeypatch.setattr(changes, "_change", lambda s, r, f, a, b, may: LabelChange(
        a.rpm, b.rpm, a.label, b.label, "unexplained"
    ))  # fmt: skip
    names = (UNDECIDED, APERIODIC, UNDECIDED, APERIODIC, UNDECIDED, "P(1;1)", "P(1;1)")
    motions = [motion(670.0 + k, name, 0.5) for k, name in enumerate(names)]
    found = changes.explain(chapter, RUN, motions)
    assert [(c.low, c.high) for c in found.changes] == [(670.0, 671.0), (673.0, 675.0)]


def test_basins_take_up_what_a_chaotic_transient_ends_on(chapter):
    """Nothing is known yet, and the record that begins in chaos is one of P(1;1) in the end."""
    finder = AttractorFinder(CellBatches(chapter, 682.25, RUN), 4000)
    assert finder._recognise(0.0, 0.0, 2)
    assert [one.label for one in finder.attractors] == ["P(1;1)"]


def test_a_rest_by_chance_is_no_end_of_a_chaotic_range():
    """At 665.25 and 667.25 rpm the record happens to hold a rest; the chaos goes on beyond both."""
    values = {"sweep.rpm.start": 660.0, "sweep.rpm.stop": 682.0, "sweep.rpm.num": 89}
    speeds = camcli.sweep(load_scene(None, values)).tables["speeds"]
    recorded = RUN.transient + RUN.record
    followed = speeds["rpm"][speeds["watched_turns"] > recorded]
    assert followed.tolist() == [660.0, 660.25, 665.25, 667.25, 681.75, 682.0]
    assert set(speeds["label"]) <= {APERIODIC, UNDECIDED}
