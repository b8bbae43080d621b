"""A measured lift is said to jump where its law jumps, and nowhere else.

The laws are those of `law_oracle`, integrated from their accelerations; their jumps are known.
"""

import random
from functools import cache
from math import pi

import numpy as np
import pytest
from mpmath import mpf

from camcli.words.lift_table import cautions
from tests.support.law_oracle import LAWS
from tests.support.lift_tables import Lobe, scene, table

CONTINUOUS = ["cycloidal", "3-4-5", "4-5-6-7", "modified-sine", "modified-trapezoid"]
GRID = 800  # intervals of the tabulated laws: 1e-9 of the lift off


@cache
def law(name: str):
    """The law as a function of doubles: (lift, second derivative) at x in [0, 1]."""
    x = np.linspace(0.0, 1.0, GRID + 1)
    values = [[float(LAWS[name].derivative(mpf(t), n)) for t in x] for n in (0, 1)]
    accels = [
        [float(LAWS[name].derivative(mpf(t), 2, side)) for t in x] for side in (1, -1)
    ]  # right of the left end, left of the right end of an interval

    def at(t: float) -> tuple[float, float]:
        """By Taylor's polynomial from the left end, with the mean third derivative."""
        k = min(int(t * GRID), GRID - 1)
        s, low, high = t - x[k], accels[0][k], accels[1][k + 1]
        bend = low / 2 + (high - low) * GRID * s / 6
        return values[0][k] + s * (values[1][k] + s * bend), low + (high - low) * GRID * s

    return at


def jump_of(folder, lobe: Lobe, step: float, decimals: int):
    """What is said of a lobe's table, the step in deg, decimals of a mm."""
    cam = scene(folder, table(lobe, step, 1e-3, decimals)).cam
    return cam.accuracy, [words for words in cautions(cam.accuracy) if "jump" in words]


@pytest.mark.parametrize(
    ("name", "flank", "dwell", "step", "decimals"),
    [
        ("cycloidal", 60, 40, 1, 4),
        ("cycloidal", 60, 40, 2, 3),
        ("cycloidal", 100, 20, 1, 3),
        ("3-4-5", 60, 40, 0.5, 4),
        ("3-4-5", 76.5, 35.3, 0.5, 4),
        ("4-5-6-7", 60, 40, 1, 4),
        ("4-5-6-7", 50, 0, 1, 3),
        ("modified-sine", 60, 40, 1, 3),
        ("modified-sine", 50, 0, 2, 2),
        ("modified-sine", 50, 0, 2, 4),
        ("modified-trapezoid", 50, 0, 2, 3),
        ("modified-trapezoid", 63, 17, 2, 4),
    ],
)
def test_a_law_without_a_jump_has_none(tmp_path, name, flank, dwell, step, decimals):
    """Lifts to 0.1, 1 and 10 um: all of these were once said to jump, of others one in five."""
    lobe = Lobe(law(name), flank, dwell)
    accuracy, said = jump_of(tmp_path, lobe, step, decimals)
    assert (accuracy.jump_deg, accuracy.jump, accuracy.jump_sure, said) == (None, None, None, [])


@pytest.mark.parametrize(
    ("name", "step", "decimals", "flank"),
    [
        ("constant-acceleration", 1, 3, 70.0),
        ("constant-acceleration", 2, 3, 53.0),
        ("harmonic", 0.5, 3, 70.0),
        ("harmonic", 1, 4, 60.0),
    ],
)
def test_a_jump_is_found_where_it_is_and_as_large_as_it_is(tmp_path, name, step, decimals, flank):
    lobe = Lobe(law(name), flank=flank)
    accuracy, (said,) = jump_of(tmp_path, lobe, step, decimals)
    rise = 180.0 - flank
    most = 0.010 / (flank * pi / 180) ** 2  # of c_thetatheta, over the law's second derivative
    jumps = {  # at the dwell's ends, where acceleration turns into its contrary, at the nose
        "constant-acceleration": {rise: 4, rise + flank / 2: -8},
        "harmonic": {rise: pi * pi / 2},
    }[name]
    off = min(accuracy.jump_deg, 360.0 - accuracy.jump_deg)
    place = min(jumps, key=lambda deg: abs(deg - off))
    sign = 1.0 if accuracy.jump_deg < 180.0 else -1.0  # the fall mirrors the rise
    assert off == pytest.approx(place, abs=0.3 * step)
    assert abs(accuracy.jump - sign * jumps[place] * most) < 5 * accuracy.jump_error
    assert accuracy.jump_error < 0.1 * abs(accuracy.jump)
    assert accuracy.jump_sure**2 > 20.0
    near = f"warning: c_thetatheta seems to jump near {accuracy.jump_deg:.4g} deg, by "
    assert said.startswith(near + f"{accuracy.jump:.2g} +- {accuracy.jump_error:.1g} m/rad2; a ")
    assert f"fits the rows worse, by {accuracy.jump_sure:.2g} standard errors" in said


@pytest.mark.parametrize(("step", "decimals"), [(1, 3), (2, 4)])
def test_a_kink_of_the_lift_is_a_jump_of_its_slope(tmp_path, step, decimals):
    """Constant velocity: the slope jumps by the lift over the flank."""
    lobe = Lobe(law("constant-velocity"), flank=70.0, dwell=20.0)
    accuracy, (said,) = jump_of(tmp_path, lobe, step, decimals)
    corners = np.array([100.0, 170.0, 190.0, 260.0])
    k = int(np.argmin(abs(corners - accuracy.jump_deg)))
    assert abs(corners[k] - accuracy.jump_deg) < 0.3 * step
    slope = 0.010 / (70.0 * pi / 180)
    assert abs(accuracy.jump - (slope, -slope, -slope, slope)[k]) < 5 * accuracy.jump_error
    assert said.startswith("warning: c_theta seems to jump near ")
    assert " m/rad; " in said


def random_lobe(rng: random.Random, name: str) -> tuple[Lobe, float, int]:
    """(lobe, spacing, decimals) of a table; continuous laws change within 6 deg or more."""
    flank, dwell = rng.uniform(50, 110), rng.choice([0.0, rng.uniform(5, 60)])
    lobe = Lobe(law(name), flank, dwell, rng.uniform(0.003, 0.015))
    return lobe, rng.choice([0.5, 1, 2]), rng.choice([2, 3, 4])


@pytest.mark.soak
@pytest.mark.slow
@pytest.mark.parametrize("name", CONTINUOUS)
def test_no_alarm_of_many_laws_without_a_jump(tmp_path, name):
    """So many tables of random flanks, dwells, lifts, spacings and digits; none is said to jump."""
    rng = random.Random(name)
    for _ in range(100):
        lobe, step, decimals = drawn = random_lobe(rng, name)
        accuracy, _ = jump_of(tmp_path, lobe, step, decimals)
        assert accuracy.jump_deg is None, (drawn, accuracy)


@pytest.mark.soak
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "least"), [("constant-acceleration", 0.5), ("harmonic", 0.35)]
)  # to 0.01 mm hardly one can be told from a fast change
def test_most_jumps_are_found(tmp_path, name, least):
    rng, found = random.Random(name), 0
    for _ in range(100):
        lobe, step, decimals = random_lobe(rng, name)
        found += jump_of(tmp_path, lobe, step, decimals)[0].jump_deg is not None
    assert found >= 100 * least
