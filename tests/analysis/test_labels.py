"""Labels: their text, their rotation, and how a stroboscopic record gets one."""

import pickle
from math import cos, inf

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import labels
from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label


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
    return labels.find_period(np.column_stack((q, w)), symbols)


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
