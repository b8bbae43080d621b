"""The two sides of a corner impact: the sign of mu, which motion is simulated, and the verdict.

The fixed point of side L is x = mu/(1 - tau_L + delta_L), and x < 0 there; x grows with the phase
of the impact past the corner.
"""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import pytest

from camcli.analysis.border_collision import Prediction
from camcli.analysis.integrate import Start
from camcli.analysis.labels import APERIODIC, UNDECIDED, Label
from camcli.analysis.orbits import corner_impacts
from camcli.analysis.orbits.corner_impacts import SimulatedSide, corner_impact
from camcli.errors import Status
from tests.conftest import chapter_system, settings

ONE, TWO = Label((1,)), Label((1, 1))
FOUND = [Prediction("fixed-point", 1), Prediction("cycle", 2)]


class Scripted:
    """Stands for the runs beside a corner: what each shows, by how far aside it is."""

    def __init__(self, *runs: SimulatedSide):
        self.runs, self.asked = list(runs), []

    def __call__(self, shooter, crossing, settings, aside):
        self.asked.append(aside)
        return self.runs.pop(0)


def sides(monkeypatch, runs: Scripted, theta=1.0, parameter=1.0, trace=0.5, det=0.2, turns=1):
    """The corner impact of a root whose tangent is (..., theta of impact 1, ..., parameter)."""
    monkeypatch.setattr(corner_impacts, "_simulated", runs)
    collision = SimpleNamespace(below=FOUND[0], above=FOUND[1])
    monkeypatch.setattr(corner_impacts, "classify", lambda left, right: collision)
    tangent = [-9.0, -9.0, theta, -9.0, parameter]
    left = SimpleNamespace(trace=trace, det=det, tangent=tangent, turns=turns)
    right = SimpleNamespace(trace=-3.0, det=0.7, tangent=[9.0] * 5, turns=turns)
    return corner_impact(None, SimpleNamespace(left=left, right=right, impact=1), None)


def shown(label, distance=0.0, value=700.0, broke_off=False) -> SimulatedSide:
    return SimulatedSide(value, label, distance, broke_off)


@pytest.mark.parametrize("theta", [0.25, -0.25])
@pytest.mark.parametrize("parameter", [2.0, -2.0])
@pytest.mark.parametrize(("trace", "det"), [(0.5, 0.2), (1.5, 0.2), (-3.0, 0.2), (1.1, 0.2)])
def test_the_sign_of_mu_is_that_of_the_side_on_which_the_orbit_is(
    monkeypatch, theta, parameter, trace, det
):
    """Above the corner's value x has the sign of dtheta/dparameter, as the root of L goes on."""
    runs = Scripted(shown(TWO, 1.0, 699.0), shown(TWO, 1.0, 701.0))  # they do not stay
    found = sides(monkeypatch, runs, theta, parameter, trace, det)
    x_above = theta / parameter
    mu_above = 1 if x_above * (1.0 - trace + det) > 0.0 else -1
    assert (found.above.mu, found.below.mu) == (mu_above, -mu_above)
    assert found.above.predicted is FOUND[mu_above > 0]
    assert found.below.predicted is FOUND[mu_above < 0]
    assert runs.asked == [-1e-6, 1e-6]
    assert (found.below.value, found.above.value) == (699.0, 701.0)
    assert (found.left.trace, found.left.det) == (trace, det)
    assert (found.right.trace, found.right.det) == (-3.0, 0.7)


def test_simulations_agree_with_what_is_predicted(monkeypatch):
    """Below a fixed point is predicted, above a cycle of two; of an orbit of one turn."""
    found = sides(monkeypatch, Scripted(shown(ONE), shown(TWO, 3e-2)))
    assert (found.below.agrees, found.above.agrees, found.agrees) == (True, True, True)
    assert (found.below.stays, found.above.stays) == (True, True)
    assert (found.below.label, found.above.label) == (ONE, TWO)
    away = sides(monkeypatch, Scripted(shown(ONE), shown(TWO, 3.0001e-2)))
    assert (away.above.stays, away.above.agrees, away.agrees) == (False, False, False)
    of_two_turns = sides(monkeypatch, Scripted(shown(TWO), shown(Label((1,) * 4))), turns=2)
    assert of_two_turns.agrees is True
    untold = sides(monkeypatch, Scripted(shown(ONE), shown(UNDECIDED)))
    assert (untold.below.agrees, untold.above.agrees, untold.agrees) == (True, None, None)


def test_a_run_that_broke_off_tells_nothing(monkeypatch):
    runs = Scripted(shown("", inf, broke_off=True), shown(TWO))
    found = sides(monkeypatch, runs)
    assert (found.below.agrees, found.below.stays, found.agrees) == (None, False, None)
    assert runs.asked == [-1e-6, 1e-6]


@pytest.mark.parametrize(
    ("nearer", "stays"),
    [
        (shown(TWO, 0.001), True),  # eight times nearer: of the corner's making
        (shown(TWO, 0.00101), False),
        (shown("", 0.02, broke_off=True), True),
    ],
)
def test_what_does_not_shrink_with_the_distance_is_another_motion(monkeypatch, nearer, stays):
    """A fixed point is predicted below; a motion of two turns is simulated 0.008 from it."""
    runs = Scripted(shown(TWO, 0.008), nearer, shown(TWO))
    found = sides(monkeypatch, runs)
    assert runs.asked == [-1e-6, -1e-6 / 64.0, 1e-6]
    assert (found.below.stays, found.below.agrees) == (stays, False)


def test_a_prediction_of_nothing_agrees_with_what_stays_at_its_distance(monkeypatch):
    before, FOUND[0] = FOUND[0], Prediction("none", 0)
    try:
        found = sides(monkeypatch, Scripted(shown(TWO, 0.02), shown(TWO, 0.02), shown(TWO)))
    finally:
        FOUND[0] = before
    assert (found.below.stays, found.below.agrees, found.agrees) == (False, True, True)


@pytest.mark.parametrize("at_corner", [7000.0, 0.0, -5.0, -7000.0])
def test_where_a_side_is_simulated_and_how_its_motion_is_named(monkeypatch, at_corner):
    """2e-6 of the value aside, of the parameter's scale (3000) where that is more."""
    value = at_corner + 2e-6 * max(abs(at_corner), 3000.0)
    record = SimpleNamespace(status=Status.OK, chatter=[False, False])
    known = {
        "_start": lambda shooter, crossing, value: ("start", value),
        "with_machine": lambda system, p: (f"{system} {p:.9g}", 42.0),
        "identify": lambda system, rpm, record: None,
        "of_record": lambda system, rpm, record: None,
        "label": lambda record: TWO,
        "section_states": lambda system, root: ([(1.0, 2.0), (9.0, 9.0)], None),
        "passages": lambda record: ([(1.0, 2.0), (1.5, 2.5), (1.25, 2.0)], None),
        "distance_to": lambda state, states: abs(state[0] - states[0][0]),
    }
    asked = []
    shooter = SimpleNamespace(
        scale=3000.0, system="machine", at=lambda value: value,
        simulate=lambda *given: asked.append(given) or record,
    )  # fmt: skip

    def run(**changes) -> SimulatedSide:
        for name, stub in {**known, **changes}.items():
            monkeypatch.setattr(corner_impacts, name, stub)
        crossing = SimpleNamespace(left=SimpleNamespace(value=at_corner))
        return corner_impacts._simulated(shooter, crossing, settings(), 2e-6)

    assert run() == (pytest.approx(value, rel=1e-15), TWO, 0.5, False)
    ((system, rpm, asked_settings, start),) = asked
    assert (system, rpm) == (f"machine {value:.9g}", 42.0)
    assert start == ("start", pytest.approx(value, rel=1e-15))
    assert (asked_settings.transient, asked_settings.record) == (3000, 130)
    assert run(identify=lambda *_: SimpleNamespace(label=ONE)).label == ONE
    chaotic, calm = (SimpleNamespace(chaotic=x) for x in (True, False))
    assert run(of_record=lambda *_: chaotic).label == APERIODIC
    assert run(of_record=lambda *_: calm).label == TWO
    assert run(passages=lambda record: ([], None)).distance == 1.0
    record.chatter = [False, True]
    assert run(of_record=lambda *_: calm).label == UNDECIDED
    record.status = Status.NO_RETURN
    gone = run(of_record=lambda *_: chaotic)
    assert (gone.distance, gone.broke_off, gone.label) == (inf, False, UNDECIDED)
    record.status = Status.IMPACT_BUDGET
    assert (run().distance, run().broke_off) == (inf, True)


def orbit(name, trace, det, states, moves=True):
    return SimpleNamespace(name=name, trace=trace, det=det, states=states, moves=moves)


ATTRACTS, REPELS_BELOW_ONE, SADDLE = (0.5, 0.2), (-2.0, 0.2), (3.0, 0.2)


@pytest.mark.parametrize(
    ("left", "right", "from_where"),
    [
        (ATTRACTS, SADDLE, "left"),
        (SADDLE, ATTRACTS, "right"),
        (REPELS_BELOW_ONE, ATTRACTS, "right"),
        (REPELS_BELOW_ONE, SADDLE, "left"),
        (SADDLE, REPELS_BELOW_ONE, "right"),
        (ATTRACTS, ATTRACTS, "left"),
        (SADDLE, SADDLE, "left"),
        (None, SADDLE, "right"),  # no root there
        ("no motion", SADDLE, "right"),
        (None, "no motion", "corner"),
    ],
)
def test_a_run_starts_beside_the_orbit_that_attracts_most(monkeypatch, left, right, from_where):
    """A thousandth of that orbit's way from the corner's own, (0.1, 2.0) at the strobe."""
    system = chapter_system()
    places = {"left": (0.4, 6.0), "right": (0.1, 7.0), "corner": (0.1, 2.0)}

    def moved(guess, value):
        assert value == 701.0
        multipliers = {"left": left, "right": right}[guess.name]
        if multipliers is None:
            return None
        trace, det = (0.1, 0.1) if multipliers == "no motion" else multipliers
        moves = multipliers != "no motion"
        return orbit(guess.name, trace, det, [places[guess.name], (8.0, 8.0)], moves)

    corner = orbit("left", 0.0, 0.0, [places["corner"], (9.0, 9.0)])
    monkeypatch.setattr(corner_impacts, "settled", lambda shooter, root: root)
    monkeypatch.setattr(corner_impacts, "section_states", lambda _, one: (one.states, None))
    shooter = SimpleNamespace(
        system=system, moved=moved, admits=lambda one: one.moves, at=lambda value: {"rpm": value}
    )
    monkeypatch.setattr(corner_impacts, "with_machine", lambda system, p: (system, p["rpm"]))
    crossing = SimpleNamespace(left=corner, right=orbit("right", 0.0, 0.0, []))
    q, w = places[from_where]
    way = ((q - 0.1) ** 2 + (w - 2.0) ** 2) ** 0.5
    shift = max(1e-3 * way, 1e-13 * q)
    found = corner_impacts._start(shooter, crossing, 701.0)
    assert found == Start.at_strobe(system, 701.0, (q + shift, w))
