"""Every field of what the study of basins returns, recomputed by other means.

The starts of a window are followed one by one, and what a speed is said to be is counted from them.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from math import inf, isnan, log

import numpy as np
import pytest

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.basins.measures import entropies
from camcli.analysis.basins.study import (
    BasinsQuestion,
    Branches,
    basins,
    carried,
    distance,
    largest_exponent,
    study,
)
from camcli.analysis.basins.window import Window
from camcli.analysis.classify import classify_at
from camcli.analysis.integrate import AtSpeeds, Cost
from camcli.errors import Status
from tests.conftest import chapter_system, settings
from tests.support.mechanics import lift_of
from tests.truth.test_columns import scene_at

RPM = 358.5
WINDOW = Window((0.05, 0.6), (-40.0, 30.0), 11, 7)  # of which one column lies below the cam
CAM_Q = 0.1  # m: at the angle zero the follower is on the base circle


@cache
def at_the_speed():
    """(basins, finder) of the example; every start is decided."""
    return basins(chapter_system(), RPM, settings(), BasinsQuestion(WINDOW))


def every_field(one, wanted, where: str) -> None:
    """Each field against its value or a check of it; none may be left out."""
    assert sorted(wanted) == sorted(field.name for field in fields(one)), where
    for name, value in wanted.items():
        found = getattr(one, name)
        holds = value(found) if callable(value) else found == value
        assert holds, f"{where}.{name}: {found}"


def starts() -> tuple[np.ndarray, np.ndarray]:
    """The middles of the cells, row by row in v."""
    (q0, q1), (v0, v1) = WINDOW.q, WINDOW.v
    q = q0 + (q1 - q0) * (np.arange(11) + 0.5) / 11
    v = v0 + (v1 - v0) * (np.arange(7) + 0.5) / 7
    return np.tile(q, 7), np.repeat(v, 11)


def test_a_speed_is_what_its_cells_say():
    found, finder = at_the_speed()
    q, v = starts()
    one_by_one = []
    for start in zip(q, v, strict=True):
        end = finder.destination(*start)
        below = start[0] < CAM_Q
        one_by_one.append(-1 if below else 1 + found.attractors.index(end))
    codes = np.array(one_by_one).reshape(7, 11)
    fresh = AttractorFinder(CellBatches(chapter_system(), RPM, settings()), 4000)
    fresh.look_around(WINDOW)
    turns = np.sort(fresh.settle(*WINDOW.centres(np.arange(77)), share=True)[1])
    taken = turns[turns > 0]
    above = codes != -1
    every_field(found, {
        "rpm": RPM, "cam_q": lambda x: abs(x - CAM_Q) < 1e-15, "window": WINDOW,
        "codes": lambda x: x.dtype == np.int16 and (x == codes).all(), "level": None,
        "attractors": lambda x: [one.label for one in x] == ["P(1;2)", "P(3;3:3:2)"],
        "regions": lambda x: [len(one.points) for one in x] == [1, 3], "stays": (0, 0),
        "fractions": lambda x: list(x) == [1, 2] and all(
            x[k][0] == (codes == k).sum() / above.sum() for k in (1, 2)),
        "undecided": 0, "troubled": {},
        "entropies": entropies(codes),
        "computed": 77,
        "turns": lambda x: x == tuple(
            int(np.percentile(taken, p, method="lower")) for p in (50, 99, 100)),
        "cost": lambda x: x.impacts > 77 and x.evaluations > x.impacts and x.crossings > x.impacts,
        "branches": (), "uncertainty": None, "exponents": None,
        # departures at the corner b and where the top dwell ends: both motions end on P(3;3:3:2)
        "rests": lambda x: [theta for theta, _ in x] == [2.621124501, 3.490658504] and all(
            (after.kind, sorted(after.symbols)) == ("settled", [2, 3, 3]) for _, after in x),
        "value": 0.0,
        "faults": (), "saddles": None,
    }, "basins")  # fmt: skip
    assert found.cells == 77
    assert above.sum() == 70


def test_starts_without_an_end_are_counted():
    """Nothing settles in four turns."""
    found, _ = basins(chapter_system(), RPM, settings(), BasinsQuestion(WINDOW, budget=4))
    assert found.undecided == (found.codes == 0).sum() > 0
    assert found.fractions[0][0] == found.undecided / 70
    assert max(found.turns) <= 4


def test_the_cam_at_a_strobe_on_its_slope():
    """The strobe of the machine is where its starts are."""
    scene = scene_at(RPM)
    system = chapter_system(strobe_deg=140.0)
    found, _ = basins(system, RPM, settings(), BasinsQuestion(Window((0.2, 0.3), (0, 1), 1, 1)))
    lift = lift_of(chapter_cam(scene)).exactly(np.radians(140.0))[0]
    assert found.cam_q == pytest.approx(float(lift), rel=1e-13)


def chapter_cam(scene) -> dict:
    """The cam of the example as a section of a scene."""
    import camcli

    return camcli.load_scene().cam.model_dump()


def test_a_value_that_fails_is_known_to_have_failed():
    """Its cells have the status of a fault, refined or not; the other value is as ever."""
    real = AtSpeeds(chapter_system(), settings())

    def setup(value):
        if value == 700.0:
            raise ZeroDivisionError("nobody foresaw this")
        return real(value)

    window = Window((0.3, 0.5), (-3.0, 3.0), 3, 2)
    fault = int(Status.FAULT)
    for refine, key in ((0, "rpm"), (1, "follower.mass")):
        asked = BasinsQuestion(window, refine=refine)
        more = {"exponents": True, "saddles": False, "key": key}
        if refine:
            more = {"exponents": False, "saddles": True, "key": key}
        found = study(chapter_system(), [100.0, 700.0], settings(), asked, setup=setup, **more)
        sound, bad = found.speeds
        fine = window.halved(refine)
        every_field(bad, {
            "rpm": (lambda x: x == 700.0) if key == "rpm" else isnan, "cam_q": isnan,
            "window": fine,
            "codes": lambda x, fine=fine: x.shape == (fine.nv, fine.nq) and set(x.flat) == {-fault},
            "level": (lambda x: x is None) if not refine else (lambda x: not x.any()),
            "attractors": (), "regions": (), "stays": (), "fractions": {-fault: (1.0, 0.0)},
            "undecided": 0, "troubled": {fault: fine.count},
            "entropies": lambda x: x["boundary_boxes"] == 0, "computed": 0, "turns": (0, 0, 0),
            "cost": Cost(), "branches": (), "uncertainty": None,
            "exponents": None if refine else (), "rests": (), "value": 700.0,
            "faults": lambda x, key=key: [one.piece for one in x] == [f"{key} = 700.0"],
            "saddles": () if refine else None,
        }, "a speed that failed")  # fmt: skip
        assert (sound.value, sound.rpm, sound.faults, sound.branches) == (100.0, 100.0, (), (1,))
        assert sound.attractors[0].label == "contact"
        assert (sound.exponents, sound.saddles) == ((None, ()) if refine else ((-inf,), None))
        assert found.troubled
        assert found.cost == sound.cost
        assert found.grids == found.speeds


@pytest.mark.parametrize(("number", "kept"), [(3, True), (4, False)])
def test_cells_are_kept_of_a_few_speeds(number, kept):
    """Of more than three only the numbers."""
    values = [100.0 + k for k in range(number)]
    asked = BasinsQuestion(Window((0.3, 0.5), (-3.0, 3.0), 2, 2), refine=1)
    found = study(chapter_system(), values, settings(), asked)
    assert [speed.codes.size for speed in found.speeds] == [16 if kept else 0] * number
    assert [speed.level is not None for speed in found.speeds] == [kept] * number
    assert found.grids == (found.speeds if kept else ())
    assert [speed.branches for speed in found.speeds] == [(1,)] * number
    assert found.cost == sum((speed.cost for speed in found.speeds), Cost())
    assert not found.troubled


def test_the_largest_exponent_of_an_attractor():
    """ln |z|/m of multipliers; -inf of a rest; of chaos from a record, above zero."""
    system = chapter_system()
    states = ((0.3, 0.1),) * 3
    solved = Attractor("P(3;1:1:1)", 3, states, (1.0, 1.0, 1.0), (-0.5 + 0j, 0.1 + 0j))
    resting = Attractor("P(1;inf)", 1, states[:1], (inf,))
    assert largest_exponent(CellBatches(system, 700.0, settings()), solved) == pytest.approx(
        log(0.5) / 3.0
    )
    assert largest_exponent(CellBatches(system, 190.0, settings()), resting) == -inf
    (chaos,) = basins(
        system, 745.0, settings(), BasinsQuestion(Window((0.4, 0.5), (0.0, 1.0), 2, 1))
    )[0].attractors
    assert (chaos.label, chaos.periodic) == ("aperiodic", False)
    known = classify_at(system, 745.0, settings()).exponents
    found = largest_exponent(CellBatches(system, 745.0, settings()), chaos)
    assert found == pytest.approx(known.largest, abs=5.0 * known.spread)
    assert found > 0.3


def test_an_attractor_goes_on_where_its_motion_ends():
    """P(3;3:3:2) doubles its period on the way to 360.5 rpm: by another label, from both sides."""
    system, branches = chapter_system(), Branches()
    window = Window((0.1, 0.9), (-50.0, 50.0), 6, 6)
    (low, low_finder), (high, high_finder) = (
        basins(system, rpm, settings(), BasinsQuestion(window)) for rpm in (RPM, 360.0)
    )
    assert [one.label for one in low.attractors] == ["P(1;2)", "P(3;3:3:2)"]
    assert [one.label for one in high.attractors] == ["P(1;2)", "P(6;3:3:2:3:3:2)"]
    assert branches.number(low.attractors, low_finder) == (1, 2)
    assert branches.number(high.attractors, high_finder) == (1, 2)
    assert branches.last == list(high.attractors)
    assert (branches.present, branches.before) == ([0, 1], high_finder)
    for one, other in zip(low.attractors, high.attractors, strict=True):
        assert carried(one, low_finder, high_finder) is other
    assert branches.number(low.attractors[:1], low_finder) == (1,)
    assert branches.present == [0]
    new = Attractor("P(9;1:1:1:1:1:1:1:1:1)", 9, ((0.2, 0.0),) * 9)
    assert Branches(last=[new], present=[]).number(high.attractors, high_finder) == (2, 3)


def test_how_far_apart_attractors_are():
    """The state of either that is farthest from the other, over the larger of both."""
    one = Attractor("P(2;1:1)", 2, ((1.0, 0.0), (2.0, 0.5)))
    other = Attractor("P(2;1:1)", 2, ((1.1, 0.0), (2.0, 0.9)))
    assert distance(one, other) == distance(other, one) == pytest.approx(0.4 / 2.0)
    further = Attractor("P(3;1:1:1)", 3, ((1.1, 0.0), (2.0, 0.9), (4.0, 0.0)))
    assert distance(one, further) == distance(further, one) == pytest.approx(2.0 / 4.0)
    dense = Attractor("aperiodic", 0, ((0.0, 0.0),), points=np.zeros((1000, 2)))
    assert distance(dense, dense) == 0.0
