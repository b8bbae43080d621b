"""Every error that is claimed, against what is off: never too small, and not ten times too large.

Errors of solved events of branches are held against the oracle where those are found
(tests/analysis/test_orbits_branches.py), errors of a measured cam in tests/cams/test_lift_table.py.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, log, sqrt

import numpy as np
import pytest
from mpmath import mp, mpf

import camcli
from camcli.analysis.basins.measures import fractions, uncertainty
from camcli.analysis.basins.window import Window
from camcli.analysis.border_collision import NormalForm, Side, attractor
from camcli.analysis.explain.crisis import find_crisis
from camcli.analysis.explain.tangency import Sampling
from camcli.analysis.exponents import of_record
from camcli.analysis.integrate import Orbit
from camcli.api.machine import machine_of
from camcli.kernel.orbit_loop import CHATTER
from tests.analysis.test_basins_measures import Painted, gap_level
from tests.conftest import chapter_system, settings
from tests.support.machines import CHAPTER, VALVE
from tests.support.mechanics import lift_of
from tests.truth.test_load_columns import random_scene

TURN = 2.0 * np.pi


# -- one event -----------------------------------------------------------------------------------

LIFTS = {
    "m": CHAPTER.load({"run.rpm": 745.0}),
    "mm, below zero": VALVE.load({"run.rpm": 3300.0}),
    **{f"random {seed}": camcli.load_scene(random_scene(seed)) for seed in (0, 4, 10, 25)},
}


def test_contacts_are_as_near_to_the_cam_as_is_claimed():
    """c of the phase of each event, in 40 digits; the claim is a rule for all lifts."""
    shares = []
    for scene in LIFTS.values():
        machine = machine_of(scene)
        record = Orbit(machine.system, scene.run.rpm, settings(5, 20)).run()
        lift, result = lift_of(scene.cam.model_dump()), camcli.simulate(scene, profile_only=True)
        claimed = result.error["contact_gap_m"]
        with mp.workdps(40):
            off = [
                abs(mpf(float(q)) - lift.exactly(mpf(float(theta)))[0])
                for q, theta in zip(record.q[:60], record.theta[:60], strict=True)
            ]
        assert len(off) >= 20
        shares.append(float(max(off)) / claimed)
    assert 0.1 <= max(shares) <= 1.0
    assert min(shares) >= 0.01


def test_accumulations_are_as_exact_as_is_asked_for():
    """However coarse: a map that replaces the last impacts of a chatter errs by no more."""
    system, shares = chapter_system(), []

    def ends(tolerance: float) -> np.ndarray:
        record = Orbit(system, 150.0, settings(3, 4, tolerance)).run()
        return np.asarray(record.theta)[np.asarray(record.kind) == CHATTER]

    exact = ends(1e-13)
    assert len(exact) == 4
    for tolerance in (1e-3, 1e-5, 1e-7, 1e-9, 1e-11):
        off = np.abs(ends(tolerance) - exact).max() / TURN
        assert off <= tolerance
        shares.append(off / tolerance)
    assert max(shares) >= 0.1


# -- standard errors, against repeated runs ------------------------------------------------------

CHAOS = {
    "long": (745.0, 400, {}),
    "coarse": (745.0, 100, {"damping": 2.0}),
    "heavy": (745.0, 100, {"gravity": 9.81, "restitution": 0.7}),
    "many impacts": (400.0, 100, {"preload": 50.0, "restitution": 0.9}),
}


@pytest.mark.parametrize("name", CHAOS)
def test_standard_errors_of_chaotic_exponents_are_the_scatter_of_runs(name):
    """24 runs from starts of their own: their spread is what each of them claims."""
    rpm, record, changes = CHAOS[name]
    system, found = chapter_system(**changes), []
    for k in range(24):
        start = {"q": 0.6 + 0.013 * k, "v": 0.0}
        tape = Orbit(system, rpm, settings(150 + k, record, **start)).run()
        one = of_record(system, rpm, tape)
        found.append((one.largest, one.spread))
    exponents, claimed = np.array(found).T
    assert 0.5 < exponents.std(ddof=1) / sqrt(np.mean(claimed**2)) < 2.0


def test_chaotic_means_three_standard_errors():
    system = chapter_system()
    one = of_record(system, 745.0, Orbit(system, 745.0, settings(150, 100)).run())
    assert one.chaotic
    limit = one.largest / 3.0
    for spread, certain in ((limit * (1 + 1e-12), False), (limit * (1 - 1e-12), True)):
        assert type(one)(one.largest, one.second, spread, one.rule, one.impacts).chaotic == certain


@pytest.mark.parametrize("sides", [(1.7, 0.5, -1.7, 0.5), (1.4, 0.3, -2.1, 0.4)])
def test_standard_errors_of_a_normal_form_are_those_of_its_length(sides):
    """The claim, against the scatter of 24 pieces of one long orbit of the map."""
    tl, dl, tr, dr = sides
    left, right = Side(tl, dl), Side(tr, dr)
    found = attractor(left, right, 1)
    assert found.kind == "chaos"
    steps, rates = measures_of_a_record(), []
    (x, y), (u, v) = (0.1, 0.0), (1.0, 0.3)
    form = NormalForm(left, right, 1.0)
    *_, (x, y) = form.run(x, y, 1000)
    for _ in range(24):
        total = 0.0
        for after in form.run(x, y, steps):
            trace, det = (tl, dl) if x <= 0.0 else (tr, dr)
            u, v = trace * u + v, -det * u
            size = hypot(u, v)
            total, u, v, (x, y) = total + log(size), u / size, v / size, after
        rates.append(total / steps)
    assert 0.5 < np.std(rates, ddof=1) / found.spread < 2.0
    assert abs(found.exponent - np.mean(rates)) < 4.0 * found.spread


def measures_of_a_record() -> int:
    """Steps that an exponent is measured on."""
    from camcli.analysis.border_collision import BLOCK, BLOCKS

    return BLOCK * BLOCKS


# -- basins --------------------------------------------------------------------------------------

SHAPES: dict[str, Callable] = {
    "disk": lambda x, y: x**2 + y**2 < 0.31**2,
    "ellipse": lambda x, y: (x - 0.3 * y) ** 2 + 4.0 * y**2 < 0.35**2,
    "stripes": lambda x, y: np.sin(40.0 * (x + 0.1 * y)) > 0.2,
}


@pytest.mark.parametrize("cells", [10, 50])
@pytest.mark.parametrize("name", SHAPES)
def test_standard_errors_of_fractions(name, cells):
    """The share on a grid off the one on a grid eight times as fine, 40 times; also coarsely."""
    rng, painted, found = np.random.default_rng(7), SHAPES[name], []

    def inside(number: int, dx: float, dy: float) -> np.ndarray:
        x = (np.arange(number) + 0.5) / number - 0.5
        return painted(x[None, :] - dx, x[:, None] - dy)

    for shift in rng.uniform(-0.1, 0.1, (40, 2)):
        codes = np.where(inside(cells, *shift), 1, 2).astype(np.int16)
        share, claimed = fractions(codes, [1, 2])[1]
        found.append((share - inside(8 * cells, *shift).mean(), claimed))
    off, claimed = np.array(found).T
    assert 0.1 < sqrt(np.mean(off**2) / np.mean(claimed**2)) < 1.0


BOUNDARIES: dict[str, tuple[Callable, float]] = {
    "line": (lambda q, v, a, b: np.where(v < 0.2 + 0.3 * a + 0.2 * b * q, 0, 1), 1.0),
    "circle": (
        lambda q, v, a, b: np.where(np.hypot(q - 0.4 - 0.2 * a, v - 0.5) < 0.2 + 0.1 * b, 0, 1),
        1.0,
    ),
    "Cantor set": (lambda q, v, a, b: gap_level(q + a) % 2, 1.0 - log(2.0) / log(3.0)),
}


@pytest.mark.parametrize("starts", [2000, 8192])
@pytest.mark.parametrize("name", BOUNDARIES)
def test_standard_errors_of_uncertainty_exponents(name, starts):
    """Of 20 windows; a Cantor set's shares wave about their power law, and saturate."""
    painted, truth = BOUNDARIES[name]
    unit, found = Window((0.0, 1.0), (0.0, 1.0), 16, 16), []
    for a, b in np.random.default_rng(9).uniform(0.0, 1.0, (20, 2)):
        finder = Painted(lambda q, v, a=a, b=b: painted(q, v, a, b))
        one = uncertainty(finder, unit, starts)
        found.append((one.exponent - truth, one.error))
    off, claimed = np.array(found).T
    assert 0.1 < sqrt(np.mean(off**2) / np.mean(claimed**2)) < 2.0
    assert (np.abs(off) < 3.0 * claimed).mean() >= 0.95


# -- crises --------------------------------------------------------------------------------------

CRISES = {740.1065: (740.0, 740.3), 361.1673: (361.0, 361.3), 682.2047: (681.5, 683.0)}


@pytest.mark.soak
@pytest.mark.parametrize("known", CRISES)
def test_a_crisis_lies_within_its_error(known):
    """Of half as many starts beside twice as many, and what runs of millions of turns showed."""
    coarse, fine = (
        find_crisis(chapter_system(), settings(300, 1), *CRISES[known], sampling=sampling)
        for sampling in (Sampling(starts=2000), Sampling(starts=9001, solved=12))
    )
    for found in (coarse, fine):
        assert found.met
        assert abs(found.rpm - fine.rpm) <= found.error <= 1e-5 * found.rpm
        assert abs(found.rpm - known) <= found.error + 1e-4  # which is rounded to four digits
        beyond = (found.bracket[1] - found.rpm) * np.sign(CRISES[known][1] - CRISES[known][0])
        assert beyond >= -found.error  # no run leaves before
