"""Speeds kept in columns are the speeds that were put in, without their sections."""

from math import inf, nan

import numpy as np
import pytest

from camcli.analysis.integrate import Cost, Start
from camcli.analysis.labels import Label
from camcli.analysis.loads import Loads
from camcli.analysis.speeds import Speed, SpeedColumns
from camcli.errors import Status
from camcli.piece_faults import PieceFault

FAULT = PieceFault("rpm = 1.0", "ValueError: no", "there", "all of it")
SECTION = (np.arange(2), np.zeros(2), np.zeros(2), np.zeros(2))
PLAIN = Speed(0.75, 700.0, Label((1.0,)), 400, Status.OK, SECTION, SECTION, Cost(1000, 3000, 5))
KINDS = [
    PLAIN._replace(fault=FAULT),
    PLAIN,
    PLAIN._replace(exponent=-inf, exponent_error=0.0, loads=Loads(*map(float, range(20)))),
    PLAIN._replace(label="aperiodic", loads=Loads(max_gap_m=0.5, landing=0.0), watched=0),
    PLAIN._replace(label="undecided", known=False, holds_for="exact-data", watched=21_000),
    PLAIN._replace(label=Label((1.0, inf)), end=Start(0.1, None, 3.0), status=Status.UNRESOLVED),
    PLAIN._replace(end=Start(theta=1.5)),  # at rest
    PLAIN._replace(end=Start(0.25, -1.5, 2.0, "the start"), exponent=0.5, exponent_error=0.125),
    PLAIN._replace(label="undecided", impact_count=None, status=Status.FAULT, fault=FAULT),
]


def columns(few: int = 100) -> SpeedColumns:
    """One speed of each kind."""
    found = SpeedColumns(few)
    for speed in KINDS:
        found.append(speed)
    return found


def without_sections(speed: Speed) -> Speed:
    return speed._replace(impacts=None, strobe=None)


@pytest.mark.parametrize("few", [0, 3, 100])
def test_each_speed_comes_back_as_it_was(few):
    found = columns(few)
    assert list(found) == list(map(without_sections, KINDS))
    assert found[-1] == found[len(KINDS) - 1]
    assert isinstance(found[0].label, Label)
    places = [one.end and one.end.place for one in KINDS]
    assert [one.end and one.end.place for one in found] == places
    assert found.cost == Cost(9000, 27000, 45)


def test_a_speed_of_a_machine_that_could_not_be_made_has_no_number():
    found = SpeedColumns(few=0)
    found.append(PLAIN._replace(rpm=nan, loads=Loads()))
    assert found[0].rpm != found[0].rpm
    assert found[0].loads == Loads()


def test_many_are_read_in_their_order_when_they_are_asked_for():
    order = [4, 0, 2]
    few = columns().chosen(order)
    many = columns(2).chosen(order)
    assert isinstance(few, list)
    assert not isinstance(many, list)
    assert len(many) == 3
    assert list(many) == few == [without_sections(KINDS[k]) for k in order]
    assert many[1:] == few[1:]
