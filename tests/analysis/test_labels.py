"""Labels: their text, their rotation, and how a stroboscopic record gets one."""

import pickle
from math import cos, inf

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import labels
from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label, label
from camcli.analysis.orbits.identify import named
from camcli.kernel.returns import find_return
from tests.support.strobes import strobe_of


@pytest.mark.parametrize(
    ("text", "symbols", "name"),
    [
        ("P(1;1)", (1.0,), "P(1;1)"),
        (" P(3;2:3:3) ", (3.0, 3.0, 2.0), "P(3;3:3:2)"),
        ("P(2;0:1)", (1.0, 0.0), "P(2;1:0)"),
        ("P(3; 2:inf:1 )", (inf, 1.0, 2.0), "P(3;inf:1:2)"),
        ("P(1;0)", (0.0,), "P(1;0)"),
    ],
)
def test_a_label_is_the_largest_rotation_of_what_is_read(text, symbols, name):
    label = Label.parse(text)
    assert label == name
    assert label.symbols == symbols
    for first in range(len(symbols)):
        assert Label(symbols[first:] + symbols[:first]) == label
    assert pickle.loads(pickle.dumps(label)).symbols == symbols


def find_period(q, w, symbols):
    return find_return(strobe_of(q, w, symbols), len(q))[0]


def by_numpy(q, w, symbols):
    """The same of arrays: the last turns but m, shifted by m."""
    states, n = np.column_stack((q, w)), len(q)
    states = states / np.where(np.abs(states).max(0) > 0.0, np.abs(states).max(0), 1.0)
    near = False
    for m in range(1, min(64, n // 2) + 1):
        if np.abs(states[-1] - states[-1 - m]).max() > 1e-2:
            continue
        window = min(n - m, max(2 * m, 16))
        last, before = slice(n - window, n), slice(n - window - m, n - m)
        near |= symbols[n - m :] == symbols[n - 2 * m : n - m]
        if symbols[last] == symbols[before] and np.abs(states[last] - states[before]).max() <= 1e-7:
            return m, False
    return 0, near


def test_returns_are_those_that_arrays_show():
    """Records that repeat, nearly repeat or change their symbols, anywhere in a table."""
    draw, seen = np.random.default_rng(5), set()
    for _ in range(400):
        n, period = int(draw.integers(1, 150)), int(draw.integers(1, 70))
        q, w = draw.normal(size=(2, period))[:, np.arange(n) % period]
        q = q + draw.choice([0.0, 1e-8, 1e-3, 0.1]) * draw.normal(size=n)
        symbols = draw.choice([1.0, 2.0, inf], size=period)[np.arange(n) % period]
        if draw.random() < 0.3:
            symbols[draw.integers(0, n)] = 0.0
        wanted = by_numpy(q, w, symbols.tolist())
        strobe = strobe_of(q.tolist(), w.tolist(), symbols.tolist(), int(draw.integers(0, 5)))
        assert find_return(strobe, n) == wanted
        seen.add((wanted[0] > 0, wanted[1]))
    assert seen == {(True, False), (False, True), (False, False)}


def test_the_period_is_the_least_shift_of_states_and_symbols():
    assert find_period([1.0] * 40, [2.0] * 40, [1] * 40) == 1
    assert find_period([1.0] * 40, [2.0] * 40, [1, 2] * 20) == 2
    q = [1.0, 2.0, 3.0] * 20
    assert find_period(q, q, [1] * 60) == 3


def test_quasiperiodic_and_chaotic_records_have_no_period():
    quasi = [2.0 + cos(2.399963 * k) for k in range(400)]
    assert find_period(quasi, quasi, [1] * 400) == 0
    chaos = [0.3]
    for _ in range(399):
        chaos.append(3.9 * chaos[-1] * (1 - chaos[-1]))
    assert find_period(chaos, chaos, [1] * 400) == 0


@pytest.mark.parametrize(
    ("rpm", "turns", "name"),
    [
        (199.0, 1, "undecided"),  # some twenty impacts
        (199.0, 2, "undecided"),  # two turns that differ
        (745.0, 10, "undecided"),
        (745.0, 129, "undecided"),
        (745.0, 130, "aperiodic"),
    ],
)
def test_a_record_too_short_for_the_longest_period_is_undecided(chapter, rpm, turns, name):
    """However many impacts it has: an orbit of 64 turns shows in no less than twice as many."""
    assert labels.label(Orbit(chapter, rpm, settings(100, turns)).run()) == name


@pytest.mark.parametrize("rpm", [739.2, 739.3])
@pytest.mark.parametrize(("transient", "record"), [(60, 40), (100, 130)])
def test_a_slow_spiral_has_the_label_of_its_orbit(chapter, rpm, transient, record):
    """Just below the period doubling at 739.31978 rpm: P(1;1), reached in thousands of turns."""
    run = Orbit(chapter, rpm, settings(transient, record)).run()
    assert label(run) in ("aperiodic", "undecided")
    found, exponents = named(chapter, rpm, run)
    assert str(found) == "P(1;1)"
    assert -0.05 < exponents.largest < 0.0  # of a multiplier close to -1
