"""The picture of a simulation: made-up hops, every edge case."""

import numpy as np
import pytest

from camcli.analysis.integrate import Cost
from camcli.analysis.simulate import Simulation
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.simulate import Trace, draw_simulation
from tests.output.pictures import RPM, bounce, count, pixels, tall


@pytest.mark.parametrize(("turns", "shown"), [(1, 1), (40, 40), (5, 3)])
def test_any_number_of_turns(turns, shown):
    image = pixels(draw_simulation(bounce(turns), shown))
    for colour in (style.FLIGHT, style.STICKING, style.CHATTER, style.DETACHMENT):
        assert count(image, colour) > 50


@pytest.mark.parametrize("rows", [0, 1, 2, 17])
def test_a_run_that_stopped_early_says_so(rows):
    stopped = bounce(label="undecided", status=Status.IMPACT_BUDGET, rows=rows)
    picture = draw_simulation(stopped, 3)
    assert count(pixels(picture), style.TROUBLE) > 10
    assert "impact-budget" in picture.words
    tall(picture)


def test_only_the_last_turns_are_shown():
    trace = Trace.of(bounce(5), 2)
    assert (trace.low, trace.high, trace.angle[0]) == (1080.0, 1800.0, 1080.0)
    counts = {kind: len(points) for kind, points in trace.events.items()}
    assert counts == {"impact": 2, "chatter": 2, "detachment": 2}
    assert trace.jumps.tolist() == [[-0.5, 0.4]] * 2


def test_the_curve_between_rows_is_the_hop_itself():
    trace = Trace.of(bounce(1), 1)
    hops = trace.angle >= 180.0
    x = trace.angle[hops] / 360.0 - 0.5
    assert trace.gap[hops] == pytest.approx(x * (0.5 - x), abs=1e-15)
    assert trace.u[hops] == pytest.approx(0.5 - 2.0 * x, abs=1e-12)
    assert not trace.gap[~hops].any()


def test_flight_and_sticking_share_the_point_between_them():
    trace = Trace.of(bounce(1), 1)
    flight, rest = (trace.during(trace.gap, state) for state in (False, True))
    both = ~np.isnan(flight) & ~np.isnan(rest)
    assert trace.angle[both].tolist() == [180.0]
    assert not (np.isnan(flight) & np.isnan(rest)).any()


def test_an_impact_breaks_the_phase_curve():
    rows = [
        (0.0, 0.0, 0.2, -1.0, 0.1, 0.0, "flight"),
        (0.1, 36.0, 0.1, -1.0, 0.1, 0.0, "flight"),
        (0.1, 36.0, 0.1, 0.8, 0.1, 0.0, "flight"),
        (0.2, 72.0, 0.18, 0.8, 0.1, 0.0, "flight"),
    ]
    trace = Trace.of(Simulation(RPM, rows, [], "undecided", Status.OK, 1, [], Cost(), None), 1)
    assert np.isnan(trace.u[trace.angle == 36.0]).any()
    assert np.nanmin(abs(trace.u)) > 0.7
    assert not np.isnan(trace.gap).any()


def test_the_angle_is_the_cams_whatever_the_strobe():
    shifted = [(row[0], (row[1] + 90.0) % 360.0, *row[2:]) for row in bounce().trajectory]
    trace = Trace.of(Simulation(RPM, shifted, [], "contact", Status.OK, 2, [], Cost(), None), 1)
    assert (trace.low, trace.high) == (450.0, 810.0)
