"""What a fit of a lift table says of itself, recomputed from the table, the cam and the law."""

from __future__ import annotations

from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.cams import lift_fit
from camcli.cams.lift_fit import ERRORS
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.system import Follower, System
from tests.support.lift_tables import Lobe, cycloidal, scene, smooth, table

CASES = [(Lobe(cycloidal), 1.0, 4), (Lobe(smooth, 60.0, 20.0), 2.0, 3)]


def lifts_of(system: System, degrees: np.ndarray) -> np.ndarray:
    """c of the compiled cam at some angles, m."""
    phases = degrees * pi / 180.0
    return np.array([lift_at(system.cam, stretch_at(system.cam, x), x)[0] for x in phases])


@pytest.mark.parametrize(("lobe", "step", "decimals"), CASES)
def test_the_fields_of_an_accuracy(tmp_path, lobe, step, decimals):
    text = table(lobe, step, decimals=decimals)
    cam = scene(tmp_path, text).cam
    found = cam.accuracy
    rows = np.array([line.split(",") for line in text.split()[1:]], dtype=float)
    degrees, lifts = rows[:, 0], rows[:, 1] * 1e-3
    quantum = 1e-3 * 10.0**-decimals
    assert found.rows == len(rows)
    assert found.knots == 360.0 / step
    assert found.lift == pytest.approx(lifts.max() - lifts.min())
    assert found.quantum == pytest.approx(quantum)
    assert found.spacing_deg == pytest.approx(step)
    assert 0.5 < found.noise / (quantum / sqrt(12.0)) < 1.5
    system = System.build(Follower(mass=1.0, stiffness=1.0), cam)
    off = np.abs(lifts_of(system, degrees) - lifts)
    assert found.largest == pytest.approx(off.max(), rel=1e-3)
    assert off[found.line - 2] == pytest.approx(off.max(), rel=1e-3)  # the head is line 1
    assert 0.2 * found.rms < off.std() < 2.0 * found.rms <= 2.0 * found.largest
    true = max(abs(lobe.at(deg)[1]) for deg in np.arange(0.0, 360.0, 0.01))
    assert found.accel == pytest.approx(true, rel=0.02)
    assert found.bound == found.bending + ERRORS * found.standard
    assert ERRORS == 3.0
    assert 0.0 < found.standard < found.worst  # all rows off in the worst way are more than noise
    assert 0.0 <= found.bending < 0.5 * true
    assert 0.5 * step <= found.length_deg < 30.0  # the shortest is half of a knot spacing
    assert (found.jump_deg, found.jump_of, found.jump) == (None, None, None)
    assert (found.jump_error, found.jump_sure) == (None, None)


def test_a_length_between_two_is_blended_by_its_place_on_a_scale_of_ratios():
    """Halfway between two lengths is their geometric mean; beyond all of them stands the last."""
    first, second = lift_fit.LENGTHS[3:5]
    length = np.array([first, second, sqrt(first * second), 0.01, 1e9])
    smoother = SimpleNamespace(
        count=5, fit=lambda one: SimpleNamespace(coefficients=np.full(5, one))
    )
    errors = lift_fit.Errors(smoother, length)
    assert errors.coefficients == pytest.approx(
        [first, second, (first + second) / 2.0, lift_fit.LENGTHS[0], lift_fit.LENGTHS[-1]]
    )


@pytest.mark.parametrize("first", [0, 5, 30, 37])
def test_smoothing_lengths_change_slowly_all_round_the_turn(first):
    """The lift bends everywhere, and noise hides it at ten knots in a row alone, which may lie on
    either side of zero: from their ends on lengths grow by a half from knot to knot."""
    count = 40
    noisy = (first + np.arange(10)) % count
    hidden = np.zeros(count)
    hidden[noisy] = 10.0
    smoother = SimpleNamespace(
        count=count, moving=np.ones(count, bool), spread=lambda shares, rows: hidden,
        change=lambda length: np.ones(count),
    )  # fmt: skip
    lengths = np.roll(lift_fit.Smoother.balanced(smoother, 1.0), -first)
    # a bend within a knot of the noise is hidden as well: 12 knots
    wanted = np.full(count, 0.5)
    wanted[np.arange(-1, 11)] = 0.5 + 0.5 * np.minimum(np.arange(1, 13), np.arange(12, 0, -1))
    assert lengths == pytest.approx(wanted)
