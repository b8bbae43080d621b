"""The small case of every entry tells machine code that is right from code that is not."""

import math

import numpy as np
import pytest

from camcli.kernel.certify import Verdict
from camcli.kernel.marks import ENTRIES
from camcli.kernel.self_check import ARRAYS, CASES, case_of, is_right


def arrays(values):
    """Every column and table of some arguments."""
    for value in values:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, tuple):
            yield from arrays(value)


def floats(values):
    """(column, place) of every float that is not 0."""
    for array in arrays(values):
        for column in [array[name] for name in array.dtype.names or ()] or [array]:
            if column.dtype == np.float64:
                yield from ((column, n) for n in range(len(column)) if column[n] != 0.0)


def test_every_entry_has_its_case():
    assert set(CASES) == set(ENTRIES)


@pytest.mark.parametrize("name", CASES)
def test_a_case_tells_one_bit(name):
    entry = ENTRIES[name]
    assert is_right(name, entry)
    after = case_of(name)
    entry(*after)
    before = b"".join(array.tobytes() for array in arrays(case_of(name)))
    assert b"".join(array.tobytes() for array in arrays(after)) != before  # it does something

    def nudged(*args):
        returned = entry(*args)
        column, n = list(floats(args))[-1]
        column[n] = math.nextafter(column[n], math.inf)
        return returned

    assert not is_right(name, nudged)
    assert not is_right(name, lambda *args: (entry(*args) or 0) + 1)
    assert not is_right(name, lambda *args: None)  # code that does nothing


def test_the_case_lands_chatters_rests_and_leaves():
    """Of the simulation: so little time is well spent."""
    args = case_of("follow_orbits")
    assert ENTRIES["follow_orbits"](*args) == 3
    works, runs, log = args[4], args[5], args[8]
    assert set(log.kind[: runs[0].log_last].tolist()) == {1, 2, 3}
    assert 0 < runs[1].log_first < runs[1].log_last == runs[2].log_first
    assert (runs[2].periods, runs[2].not_begun) == (2, 0)
    impacts = [log.period[: runs[0].log_last].tolist().count(period) for period in range(6)]
    assert impacts[3] == impacts[4] == impacts[5] > 0
    assert works[0].steps < 6 * impacts[3]  # turns are copied
    assert ARRAYS.compiled


def test_the_cam_of_the_check_has_pieces_that_are_looked_up():
    (cam, *_) = case_of("certify_orbit")
    for i in range(len(cam.stretches)):
        stretch = cam.stretches[i]
        assert stretch.per_angle * (stretch.end - stretch.start) == pytest.approx(
            stretch.piece_count
        )
    assert max(stretch.piece_count for stretch in cam.stretches) > 1


def test_the_case_certifies_an_orbit_that_is_one():
    args = case_of("certify_orbit")
    assert ENTRIES["certify_orbit"](*args) == Verdict.ADMISSIBLE
    assert args[-1][0].evaluations > 0
