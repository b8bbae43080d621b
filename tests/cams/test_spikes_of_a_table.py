"""A row off its neighbours is a spike by the median of all deviations, whatever their signs."""

from types import SimpleNamespace

import numpy as np
import pytest

from camcli.cams.lift_reading import _refuse_spikes
from camcli.errors import SceneError

ROWS, AT = 60, 30
WEIGHTS = (-1 / 6, 2 / 3, 2 / 3, -1 / 6)  # of evenly spaced rows, by Lagrange
SMALL = 1e-6  # m, the background


def refused(share: float, signs: np.ndarray, digit: float = 1e-12, line: int = 42, **changes):
    """Whether a row that is off by a share of the background, and its neighbours by its pattern."""
    off = SMALL * signs
    off[AT] = share * SMALL
    for step, weight in zip((-2, -1, 1, 2), WEIGHTS, strict=True):
        off[AT + step] = -weight * off[AT]
    for step, value in changes.items():
        off[AT + int(step.removeprefix("at_"))] = value * SMALL
    lines = np.arange(ROWS) + 12
    lines[AT] = line
    weights = np.tile(np.array(WEIGHTS)[:, None], ROWS)
    turn = SimpleNamespace(deviations=lambda reach: (off, weights), quantum=digit, line=lines)
    try:
        _refuse_spikes(turn, "lift.csv")
    except SceneError as refusal:
        (fault,) = refusal.faults
        assert fault.where.startswith(f"lift.csv:{line}")
        assert f"{1e3 * share * SMALL:.6g} mm off" in fault.found
        return True
    return False


SIGNS = {
    "alternating": np.where(np.arange(ROWS) % 2, 1.0, -1.0),
    "below": -np.ones(ROWS),
    "above": np.ones(ROWS),
    "every third": np.where(np.arange(ROWS) % 3 == 0, 1.0, -1.0),
    "some none": np.where(np.arange(ROWS) % 3 == 0, 0.0, -1.0),
}


@pytest.mark.parametrize("name", SIGNS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_spike_is_eight_times_the_median_of_what_the_others_are_off(name, sign):
    """Rows that are not off at all do not count."""
    assert not refused(7.9 * sign, SIGNS[name].copy())
    assert refused(8.1 * sign, SIGNS[name].copy())


def test_a_spike_is_twelve_last_digits_and_its_neighbours_show_its_pattern():
    signs = SIGNS["alternating"]
    assert not refused(11.9, signs.copy(), digit=SMALL)
    assert refused(12.1, signs.copy(), digit=SMALL)
    assert not refused(20.0, signs.copy(), line=0)  # a row that was filled in
    for step, weight in zip((-2, -1, 1, 2), WEIGHTS, strict=True):
        for off, is_spike in ((1.9, True), (2.1, False), (-1.9, True), (-2.1, False)):
            there = {f"at_{step}": -20.0 * weight + off}  # a tenth of the spike may be missing
            assert refused(20.0, signs.copy(), **there) is is_spike
