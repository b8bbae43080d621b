"""Multiple shooting: derivatives, the bordered solver, quadratic convergence, the same bits."""

import random

import numpy as np
import pytest

from camcli.analysis.orbits.shooter import PLACES, Shooter
from camcli.kernel import backend, shooting
from camcli.kernel.bordered import BLOCK, ROWS, WIDE, Tables, solve_bordered
from camcli.kernel.cam_table import stretch_at
from tests.conftest import chapter_system


def tables(n):
    sizes = n * BLOCK, 2 * n, 2 * n + 1, 2 * n + 1, ROWS * WIDE, 2 * n * WIDE, 35
    return Tables(*([0.0] * size for size in sizes))


def assembled(n, blocks):
    """(matrix, residual) of the cyclic system, without the parameter."""
    J, E = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)
    for k in range(n):
        j, o = (k + 1) % n, BLOCK * k
        for i in range(2):
            for c in range(2):
                J[2 * k + i, 2 * k + c] += blocks[o + 2 * i + c]
                J[2 * k + i, 2 * j + c] += blocks[o + 4 + 2 * i + c]
            E[2 * k + i] = blocks[o + 8 + i]
    return J, E


@pytest.mark.parametrize("parameter", [name for name in PLACES if name != "seat_restitution"])
def test_the_column_of_the_parameter(parameter):
    """It only steers the continuation, but the tangent should be that of the branch."""
    constants = {"damping": 2.0, "gravity": 9.81, "preload": 10.0}
    shooter = Shooter(chapter_system(**constants), 700.0, parameter)
    stretch, value = stretch_at(shooter.system.cam, 2.71), shooter.machine[PLACES[parameter]]
    root = shooter.at_value([2.71, 0.9, value], (stretch, 0), 1, value)
    h = 1e-4 * value
    sides = [shooter.at_value(root.x, root.whole, 1, value + s * h) for s in (-1, 1)]
    for j in range(2):
        slope = (sides[1].x[j] - sides[0].x[j]) / (2 * h)
        assert abs(root.tangent[j] / root.tangent[-1] - slope) < 2e-6 * abs(slope)


def bordered_system(draw, n, growth):
    """Random blocks with one direction in each that grows, a random border and column."""
    t = tables(n)
    for k in range(n):
        L = draw.normal(size=(2, 2))
        u, s, v = np.linalg.svd(L)
        L = u @ np.diag(s * [growth, 1.0]) @ v
        R = draw.normal(size=(2, 2)) + 2 * np.eye(2)
        o = BLOCK * k
        t.blocks[o : o + 4] = [float(z) for z in L.ravel()]
        t.blocks[o + 4 : o + 8] = [float(z) for z in R.ravel()]
        t.blocks[o + 8 : o + 10] = [float(z) for z in draw.normal(size=2)]
        t.columns[2 * k : 2 * k + 2] = [float(z) for z in draw.normal(size=2)]
    row = [float(z) for z in draw.normal(size=2 * n + 1)]
    return t, row, float(draw.normal())


@pytest.mark.parametrize("growth", [1.0, 10.0, 1e3, 1e-3, 1e6])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 8, 20, 40])
def test_the_bordered_solver_against_lapack(n, growth):
    """The backward error too: however much the orbit stretches, elimination is stable."""
    for seed in range(5):
        t, row, right = bordered_system(np.random.default_rng(100 * n + seed), n, growth)
        J, E = assembled(n, t.blocks)
        full = np.zeros((2 * n + 1, 2 * n + 1))
        full[:-1, :-1], full[:-1, -1], full[-1] = J, t.columns, row
        assert solve_bordered(n, t, row, right)
        for found, b in ((t.step, [*-E, right]), (t.tangent, [*np.zeros(2 * n), 1.0])):
            exact = np.linalg.solve(full, b)
            condition = np.linalg.cond(full)
            error = np.abs(exact - found).max() / np.abs(exact).max()
            assert error < 1e-13 * condition, (seed, error, condition)
            residual = np.abs(full @ found - b).max()
            assert residual < 1e-12 * np.abs(full).sum(axis=1).max() * np.abs(found).max()


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_a_singular_system_is_refused(n):
    t, row, right = bordered_system(np.random.default_rng(3), n, 1.0)
    t.columns[:] = [0.0] * (2 * n)
    row[-1] = 0.0
    for k in range(n):
        t.blocks[BLOCK * k : BLOCK * k + 8] = [0.0] * 8
    assert not solve_bordered(n, t, row, right)


START_POINTS = {
    "P(1;1)": (700.0, [2.7105, 0.85], 1),
    "P(1;2)": (358.5, [2.6354469, 0.978, 5.8108811, 0.994], 1),
}


@pytest.mark.parametrize("name", START_POINTS)
@pytest.mark.parametrize("changes", [{}, {"damping": 0.3, "gravity": 0.5}])
def test_newton_converges_quadratically(monkeypatch, name, changes):
    """e, C e^2 with a C that does not depend on e, until rounding."""
    monkeypatch.setenv("CAMCLI_KERNEL", "python")  # in which one step can be asked for
    system = chapter_system(**changes)
    rpm, start, turns = START_POINTS[name]
    shooter = Shooter(system, rpm)
    n = len(start) // 2
    whole = tuple(v for k in range(n) for v in (stretch_at(system.cam, start[2 * k]), 0))
    exact = shooter.at_value([*start, rpm], whole, turns, rpm)
    assert exact is not None
    assert exact.steps <= 7
    monkeypatch.setattr(shooting, "CONVERGED", 1e300)  # one step at a time
    draw = random.Random(3)
    kick = [draw.uniform(-1, 1) for _ in start]
    ratios = []
    for size in (3e-3, 1e-3, 3e-4, 1e-4, 3e-5):
        x = [a + size * d for a, d in zip(exact.x, kick, strict=False)]
        errors = [max(abs(a - b) for a, b in zip(x, exact.x, strict=False))]
        for _ in range(4):
            root = shooter.at_value([*x, rpm], whole, turns, rpm)
            assert root.steps == 1
            x = root.x[:-1]
            errors.append(max(abs(a - b) for a, b in zip(x, exact.x, strict=False)))
        assert errors[-1] < 2e-15 * max(abs(v) for v in exact.x)
        assert errors[1] < 1e-2 * errors[0] or size > 1e-3
        ratios.append(errors[1] / errors[0] ** 2)
    assert max(ratios) < 2 * min(ratios)


@pytest.mark.parametrize("guess", [[2.7105, 300.0], [2.7105, -40.0], [3.0, 0.0]])
def test_a_bad_guess_fails_without_a_word(guess):
    system = chapter_system()
    shooter = Shooter(system, 700.0)
    whole = (stretch_at(system.cam, guess[0]), 0)
    root = shooter.at_value([*guess, 700.0], whole, 1, 700.0)
    assert root is None or all(np.isfinite(root.x))


@pytest.mark.parametrize(
    ("in_use", "cached", "done", "taken"),
    [
        (True, True, 0, True),
        (True, False, 0, False),
        (True, False, backend.LITTLE_NEWTON, True),
        (False, True, 0, False),
        (False, True, backend.LEAST_NEWTON, True),
        (False, False, backend.LEAST_NEWTON, False),
    ],
)
def test_newton_is_compiled_where_that_is_quicker(monkeypatch, in_use, cached, done, taken):
    """Code that waits to be read, or much work done in plain Python, are reasons; the root stays.

    `done` is what plain Python has done before the root that it solves here.
    """
    monkeypatch.delenv("CAMCLI_KERNEL", raising=False)
    machine_code = backend.compiled()
    monkeypatch.setattr(backend, "_compiled", None)
    monkeypatch.setattr(backend, "_newton_found", False)
    monkeypatch.setattr(backend, "is_cached", lambda name: False)
    monkeypatch.setattr(backend, "_plain_newton", done)
    root = single_impact(Shooter(chapter_system(), 700.0))
    assert backend._plain_newton == done + root.count * root.steps
    monkeypatch.setattr(backend, "_compiled", machine_code if in_use else None)
    monkeypatch.setattr(backend, "is_cached", lambda name: cached)
    shooter = Shooter(chapter_system(), 700.0)
    assert shooter.kernel.compiled == taken
    again = single_impact(shooter)
    assert again == root
    assert shooter.admits(again)


def single_impact(shooter):
    """The stable P(1;1) at 700 rpm, from near by."""
    stretch = stretch_at(shooter.system.cam, 2.71)
    return shooter.at_value([2.71, 0.9, 700.0], (stretch, 0), 1, 700.0)


@pytest.mark.parametrize(("parameter", "value", "is_one"), [
    ("rpm", -700.0, False), ("rpm", 0.0, False), ("mass", -1e-3, False), ("mass", 0.0, False),
    ("damping", -1e-3, False), ("damping", 0.0, True), ("gravity", -1.0, True),
    ("preload", -1.0, True),
])  # fmt: skip
def test_no_root_of_a_machine_that_cannot_be(parameter, value, is_one):
    """The equations hold only the square of the speed, and have roots at a negative one too."""
    root = single_impact(Shooter(chapter_system(), 700.0))
    shooter = Shooter(chapter_system(), 700.0, parameter)
    found = shooter.at_value([*root.x[:-1], value], root.whole, 1, value)
    assert (found is not None) == is_one
