"""Chaos at one speed: what is given to the proof, what is written down, what a picture shows.

The impact map and the proof are stand-ins with numbers that all differ.
"""

from __future__ import annotations

from fractions import Fraction
from math import pi, ulp
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from flint import arb, ctx

from camcli.analysis.chaos import homoclinic
from camcli.analysis.chaos import study as module
from camcli.analysis.chaos.homoclinic import ImpactMap
from camcli.analysis.chaos.section import Chaos, Lands, SectionBox
from camcli.analysis.chaos.statement import statement
from camcli.analysis.integrate import BudgetSpentError
from camcli.cams.balls import precision
from camcli.exact.shooting import ProofStep
from camcli.kernel.orbit_loop import IMPACT
from camcli.system import Follower

FOLLOWER = Follower(mass=1.25, stiffness=300.5, damping=0.375, gravity=9.81, preload=2.5,
                    restitution=0.75)  # fmt: skip
ONE = SectionBox(4, (1.5, 0.1), ((0.5, -0.25), (0.125, 2.0)), Lands(5, 2, 0.1, 0.2), (3, 7))
TWO = SectionBox(6, (2.75, -0.3), ((0.75, 0.2), (-0.6, 1.5)), Lands(8, 1, 0.3, 0.4), (1, 2))
CHAOS = Chaos(745.0, "P(1;1)", (ONE, TWO), ((0, 1), (1, 0), (1, 1)), 1.375, (7, 12), None,
              (({"at": 1}, {"at": 2}), ({"at": 3},)))  # fmt: skip


def test_a_statement_of_chaos_has_every_number_as_a_text_that_means_it_exactly():
    small = arb(2) ** -40
    found = statement(CHAOS, FOLLOWER, arb(745) - small, arb(745) + 3 * small)
    assert (found["kind"], found["parameter"]) == ("chaos", "rpm")
    assert Fraction(found["low"]) == 745 - Fraction(1, 2**40)
    assert Fraction(found["high"]) == 745 + Fraction(3, 2**40)
    assert (found["growth"], found["weights"]) == ("1.375", ["7", "12"])
    assert found["coverings"] == [[0, 1], [1, 0], [1, 1]]
    constants = dict(found["constants"])
    assert constants.pop("rpm") is None
    assert {key: Fraction(text) for key, text in constants.items() if text is not None} == {
        key: Fraction(value) for key, value in vars(FOLLOWER).items() if key in constants
    }
    assert {"mass", "stiffness", "damping", "gravity", "preload", "restitution"} <= set(constants)
    one, two = found["boxes"]
    assert (one["stretch"], one["lands"], one["cells"]) == (4, {"stretch": 5, "turn": 2}, [3, 7])
    assert (two["stretch"], two["lands"], two["cells"]) == (6, {"stretch": 8, "turn": 1}, [1, 2])
    assert [Fraction(x) for x in one["middle"]] == [Fraction(1.5), Fraction(0.1)]
    assert [Fraction(x) for x in two["middle"]] == [Fraction(2.75), Fraction(-0.3)]
    assert [Fraction(x) for x in one["axes"]] == [0.5, -0.25, 0.125, 2.0]
    assert [Fraction(x) for x in two["axes"]] == [Fraction(x) for x in (0.75, 0.2, -0.6, 1.5)]
    assert (one["flights"], two["flights"]) == ([{"at": 1}, {"at": 2}], [{"at": 3}])


@pytest.mark.parametrize("box", [ONE, TWO])
def test_the_outline_of_a_box_goes_round_its_four_corners(box):
    points = module._outline(box)
    assert points[:, 0].tolist() == points[:, -1].tolist()
    x, y = box.inside(points)
    assert np.maximum(abs(x), abs(y)) == pytest.approx(np.ones(len(x)))  # on an edge
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    (a, b), (c, d) = box.axes
    places = [(box.middle[0] + a * u + b * v, box.middle[1] + c * u + d * v) for u, v in corners]
    at = [np.argmin(np.hypot(*(points[:, :-1].T - place).T)) for place in places]
    assert at == sorted(at)
    for k, place in zip(at, places, strict=True):
        assert points[:, k] == pytest.approx(place)
    steps = np.hypot(np.diff(x), np.diff(y))
    assert steps.max() < 0.1


@pytest.mark.parametrize("rpm", [745.0, 0.3, 1023.9999])
@pytest.mark.parametrize("holds", [True, False])
@pytest.mark.parametrize("excess", [None, 0.125])
def test_boxes_are_proved_for_every_speed_that_rounds_to_theirs(monkeypatch, rpm, holds, excess):
    given = []

    def proved(boxes, shape, follower, speeds):
        given.append((boxes, shape, follower, speeds, ctx.prec))
        return Chaos(rpm, "proved", step=None if holds else ProofStep.CONTACT)

    monkeypatch.setattr(module, "proved", proved)
    monkeypatch.setattr(module, "statement", lambda *asked: asked)
    shape = Stub() if excess is None else Stub(flank_excess=excess)
    before = ctx.prec
    found, said = module._proved(Stub(shape=shape, follower="follower"), Chaos(rpm, "given"))
    assert ctx.prec == before
    ((boxes, of_shape, follower, speeds, bits),) = given
    assert (boxes.label, of_shape, follower, bits) == ("given", shape, "follower", 128)
    with precision(60):
        half = arb(ulp(rpm)) / 2
        ends = arb(rpm) - half, arb(rpm) + half
        assert all(speeds.contains(end) for end in ends)
    assert float(speeds.rad()) < 0.5001 * ulp(rpm)
    assert (found.label, found.flank_excess) == ("proved", excess or 0.0)
    if holds:
        chaos, follower, low, high = said
        assert (chaos, follower) == (found, "follower")
        assert (low, high) == ends
        assert low.is_exact()
        assert high.is_exact()
    else:
        assert said is None


def search(monkeypatch, candidates, proves=None, spent_at=None):
    """`chaos_at` with orbits 1 to 3 of which the first is no saddle; (result, boxes tried).

    candidates: how many sets of boxes each saddle has.
    """
    tried = []

    def prove(system, boxes):
        tried.append(boxes)
        if boxes == spent_at:
            raise BudgetSpentError
        holds = boxes == proves
        chaos = Chaos(745.0, f"boxes {boxes}", step=None if holds else ProofStep.CONTACT)
        return chaos, "stated" if holds else None

    monkeypatch.setattr(module, "ImpactMap", lambda *machine: machine)
    monkeypatch.setattr(module, "saddle_of", lambda of, orbit: None if orbit == 1 else orbit)
    monkeypatch.setattr(
        module, "candidates", lambda of, saddle: ((saddle, k) for k in range(candidates))
    )
    monkeypatch.setattr(module, "_proved", prove)
    return module.chaos_at("system", "settings", [1, 2, 3], 745.0, True), tried


def test_chaos_is_proved_about_the_first_orbit_where_it_can_be(monkeypatch):
    (found, said), tried = search(monkeypatch, 4, proves=(3, 1))
    assert (found.label, said, found.proved) == ("boxes (3, 1)", "stated", True)
    assert tried == [(2, 0), (2, 1), (2, 2), (2, 3), (3, 0), (3, 1)]


def test_of_chaos_without_a_proof_the_last_step_that_failed_is_told(monkeypatch):
    (found, said), tried = search(monkeypatch, 70)
    assert (found.label, found.step, said) == ("boxes (3, 59)", ProofStep.CONTACT, None)
    assert len(tried) == 2 * 60  # of each saddle so many
    (found, said), tried = search(monkeypatch, 0)
    assert (found.step, found.rpm, found.boxes, said) == (ProofStep.NO_CHAIN, 745.0, (), None)
    (found, said), tried = search(monkeypatch, 5, spent_at=(2, 1))
    assert (found.label, found.step, said) == ("boxes (2, 0)", ProofStep.WORK_BUDGET, None)
    assert tried == [(2, 0), (2, 1)]
    found, said = module.chaos_at("system", "settings", [2], 650.0, False)
    assert (found.rpm, found.step, said) == (650.0, ProofStep.CAM, None)


def test_a_picture_has_the_outline_where_a_box_lands_on_no_single_stretch(monkeypatch):
    class Map:
        def __init__(self, *machine):
            assert machine == ("system", 745.0, "settings")

        def image(self, points):
            return None if points[0].mean() < 2.0 else Stub(points=10.0 * points)

        def simulated(self):
            return "impacts"

    monkeypatch.setattr(module, "ImpactMap", Map)
    view = module.view_of("system", "settings", CHAOS)
    assert view.impacts == "impacts"
    for outline, box in zip(view.outlines, CHAOS.boxes, strict=True):
        assert outline.tolist() == module._outline(box).tolist()
    assert view.images[0].tolist() == view.outlines[0].tolist()
    assert view.images[1].tolist() == (10.0 * view.outlines[1]).tolist()


@pytest.mark.parametrize("count", [0, 3])
def test_simulated_impacts_leave_the_stretch_they_meet_with_its_restitution(monkeypatch, count):
    events = [
        (IMPACT, -1, 1.0, 0.0, -9.0), (IMPACT, 0, 0.5, 0.0, -2.0), (IMPACT + 1, 0, 1.5, 0.0, -7.0),
        (IMPACT, 0, 4.0, 0.0, -3.0), (IMPACT, 2, 0.75, 0.0, -5.0),
    ]  # fmt: skip

    class OneOrbit:
        def __init__(self, *machine):
            assert machine[1:] == (745.0, "settings")

        def run(self, strobes):
            assert not strobes
            return Stub(events=lambda: events if count else events[:1])

    monkeypatch.setattr(homoclinic, "Orbit", OneOrbit)
    monkeypatch.setattr(homoclinic, "stretch_at", lambda cam, theta: int(theta > pi))
    system = Stub(cam=None, restitution=lambda i: (0.8, 0.5)[i])
    theta, v = ImpactMap(system, 745.0, "settings").simulated()
    assert theta.tolist() == [0.5, 4.0, 0.75][:count]
    assert v == pytest.approx([1.6, 1.5, 4.0][:count])
