"""The pictures: tiny hand-made results, every edge case, and the pixels that matter."""

import subprocess
import sys
from dataclasses import replace
from math import cos, inf, nan, pi, sin

import matplotlib
import numpy as np
import pytest

from camcli.analysis.integrate import Cost, Start
from camcli.analysis.simulate import Simulation
from camcli.analysis.sweep import Speed, Sweep
from camcli.cams.arcs import ArcsCam
from camcli.errors import Status
from camcli.plots import axes, density, style
from camcli.plots.simulate import Trace, draw_simulation
from camcli.plots.sweep import draw_sweep, enlarged_range
from camcli.system import Follower, System
from tests.conftest import settings
from tests.output import pictures

RPM = 60.0  # a turn per second
BLACK, RED = (0, 0, 0), (0xD5, 0x5E, 0x00)


@pytest.fixture(scope="module")
def system():
    cam = ArcsCam(
        kind="arcs",
        base_radius=0.4,
        flank_center=0.45,
        flank_radius=0.85,
        nose_center=0.40393320723821,
        nose_radius=0.15,
        top_dwell_deg=40,
        offset=0.3,
    )
    return System.build(Follower(1.221, 1430.8), cam.parts())


def speed(rpm, phases=(), q=(), status=Status.OK):
    phases = None if phases is None else (range(len(phases)), phases, phases, phases)
    strobe = None if q is None else (range(len(q)), q, q, q, q)
    return Speed(rpm, "aperiodic", 0, status, phases, strobe, Cost())


def sweep(*speeds):
    return Sweep(list(speeds), "fixed", Cost())


def picture(draw, *args, **kwargs):
    """Pixels (row, column, rgb) of a drawing."""
    return pictures.pixels(draw(*args, **kwargs))


def drawn(system, *speeds, start=None):
    run = replace(settings(), start=start or Start())
    return picture(draw_sweep, sweep(*speeds), system, run)


def count(pixels, colour):
    return int((pixels == colour).all(axis=2).sum())


def bounce(turns=2, label="P(1;inf)", status=Status.OK, rows=None):
    """A follower that rests for half a turn, then makes one hop: made up."""
    trajectory, events = [], []
    for k in range(turns):
        for j in range(16):
            x = j / 16 - 0.5
            gap, u, state = (
                (x * (0.5 - x), 0.5 - 2.0 * x, "flight") if j >= 8 else (0, 0, "sticking")
            )
            c, c_dot = 0.1 - 0.01 * cos(pi * j / 8), 0.02 * pi * sin(pi * j / 8)
            trajectory.append((k + j / 16, 22.5 * j, c + gap, c_dot + u, c, c_dot, state))
        events += [
            (k + 0.0, k, 0.0, "impact", 0.09, -0.5, 0.4),
            (k + 0.1, k, 36.0, "chatter", 0.09, 0.0, 0.0),
            (k + 0.5, k, 180.0, "detachment", 0.11, 0.0, 0.0),
        ]
    trajectory = trajectory if rows is None else trajectory[:rows]
    return Simulation(RPM, trajectory, events, label, status, turns, [90.0, 180.0], Cost())


# --- the sweep


def test_sweep_is_the_same_bytes_twice_whatever_the_user_set(system):
    it = sweep(speed(700.0, [150.0], [2.0]), speed(701.0, [151.0, 155.0], [2.1, 1.0]))
    first = pictures.png(draw_sweep(it, system, settings()))
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "axes.grid": True}):
        assert pictures.png(draw_sweep(it, system, settings())) == first
        assert matplotlib.rcParams["font.size"] == 20
    assert b"Software" not in first
    assert b"tIME" not in first


@pytest.mark.parametrize("many", [1, 2, 401, 4001])
def test_any_number_of_speeds(system, many):
    rpms = np.linspace(660.0, 760.0, many)
    drawn(system, *(speed(rpm, [150.0 + k % 7], [1.0 + k % 3]) for k, rpm in enumerate(rpms)))


def test_a_descending_sweep_is_the_ascending_picture(system):
    speeds = [speed(700.0 + k, [150.0 + k], [1.0 + k]) for k in range(5)]
    assert np.array_equal(drawn(system, *speeds), drawn(system, *speeds[::-1]))


def test_a_panel_is_left_out_where_nothing_was_recorded(system):
    both = drawn(system, speed(700.0, [150.0], [2.0])).shape[0]
    impacts = drawn(system, speed(700.0, [150.0], None)).shape[0]
    strobe = drawn(system, speed(700.0, None, [2.0])).shape[0]
    assert impacts < both
    assert strobe < both
    drawn(system, speed(700.0, None, None))
    drawn(system)


def test_no_impacts_at_all_is_said_in_the_panel(system, monkeypatch):
    said = []
    monkeypatch.setattr(style, "note", lambda axes, text: said.append(text))
    drawn(system, speed(100.0, [], [0.1]), speed(101.0, [], [0.1]))
    assert said == ["no impact at any of these speeds"]
    said.clear()
    drawn(system, speed(100.0, [], []))
    assert len(said) == 2


def test_a_branch_lands_on_the_pixel_grid_dark_and_two_pixels_thick(system):
    without = drawn(system, speed(700.0, None, [1.0, 3.0]))
    with_ = drawn(system, speed(700.0, None, [1.0, 2.0, 3.0]))
    assert count(with_, BLACK) - count(without, BLACK) == density.WIDEST * density.THICKNESS


def test_troubled_speeds_get_red_ticks(system):
    good = [speed(700.0 + k, [150.0], [2.0]) for k in range(5)]
    assert count(drawn(system, *good), RED) == 0
    bad = [*good, speed(703.5, [], [], Status.IMPACT_BUDGET)]
    assert count(drawn(system, *bad), RED) > 10


def test_values_that_are_not_finite_are_left_out(system):
    drawn(system, speed(700.0, [150.0], [2.0, inf, nan]), speed(701.0, [151.0], [nan]))


def test_a_long_text_is_wrapped(system):
    good = [speed(700.0, [150.0], [1.0]), speed(701.0, [150.0], [1.0])]
    bad = [replace(good[0], status=Status.IMPACT_BUDGET), replace(good[1], status=Status.NO_RETURN)]
    short = drawn(system, *good)
    long = drawn(system, *bad, start=Start(q=1.0 / 3.0, v=-1.0 / 3.0))
    assert long.shape[0] > short.shape[0]


# --- what a sweep's picture is made of


def shares_of(values, columns):
    pixels = density.Pixels(columns, 0.0, 1.0, 8)
    density.take_all(values, pixels.take)
    return pixels.shares(density.Cloud.of(values))


def test_shares_count_every_point_of_a_column_even_out_of_range():
    shares = shares_of([[0.25, 0.25, 9.0, 0.75]], density.Columns.of([700.0], 20))
    assert shares.shape == (8, 20)
    column = shares[:, 10]
    assert column.max() == 0.5
    assert column.compressed().tolist() == [0.5, 0.5, 0.25, 0.25]
    assert shares[:, 0].mask.all()


def test_the_ends_of_the_range_are_inside():
    shares = shares_of([[0.0, 1.0]], density.Columns.of([1.0], 9))
    assert shares[:, 4].compressed().tolist() == [0.5, 0.5, 0.5]
    assert shares.mask[1:6, 4].all()


def test_columns_are_even_for_even_speeds_and_hold_several_beyond_one_per_pixel():
    columns = density.Columns.of(np.linspace(660.0, 760.0, 101), 303)
    assert np.bincount(columns.bin_of_column).tolist() == [3] * 101
    assert (columns.low, columns.high) == (659.5, 760.5)
    columns = density.Columns.of(np.linspace(660.0, 760.0, 401), 100)
    assert np.bincount(columns.bin_of_speed).tolist() == [4] * 50 + [5] + [4] * 49


def test_phases_are_zoomed_or_enlarged_where_they_are_close():
    near = density.Cloud.of([[140.0, 190.0]] * 8)
    assert axes.phase_range(near.extremes()) == (138.0, 192.0)
    assert enlarged_range(near) is None
    mixed = density.Cloud.of([[140.0, 190.0]] * 8 + [[1.0, 359.0]] * 2)
    assert axes.phase_range(mixed.extremes()) == (0.0, 360.0)
    assert enlarged_range(mixed) == (138.0, 192.0)
    chaos = density.Cloud.of([[140.0, 190.0]] * 2 + [[1.0, 359.0]] * 8)
    assert enlarged_range(chaos) is None
    assert axes.phase_range(density.Cloud.of([[], []]).extremes()) == (0.0, 360.0)


def test_the_cam_beside_the_diagram_is_the_cam(system):
    theta, (c, c_theta, c_thetatheta) = axes.lift_curves(system.cam, 3)
    assert c[np.nanargmin(abs(theta - 0.0))] == pytest.approx(0.1, abs=1e-12)
    assert np.nanmax(c) == pytest.approx(0.25393320723821, abs=1e-12)
    assert np.nanmax(c_theta) == pytest.approx(0.2747021271326710, abs=1e-12)
    assert np.nanmin(c_thetatheta) == pytest.approx(-1.869212582774405, abs=1e-9)


def test_names_are_spread_apart_and_stay_inside():
    assert axes.spread([1.0, 1.5, 9.0], 1.0, 0.0, 10.0) == [0.75, 1.75, 9.0]
    assert axes.spread([0.0, 0.1], 1.0, 0.0, 10.0) == [0.0, 1.0]
    assert axes.spread([], 1.0, 0.0, 10.0) == []
    assert style.corner_names([float(k) for k in range(27)]) == {}


def test_labels_for_print():
    assert style.motion("P(1;inf)") == "P(1;∞)"
    long = style.motion("P(47;" + ":".join(["3"] * 47) + ")")
    assert len(long) <= 32
    assert long.endswith("…)")


# --- the simulation


def test_simulation_is_the_same_bytes_twice():
    one, two = (pictures.png(draw_simulation(bounce(), 2)) for _ in range(2))
    assert one == two
    assert count(picture(draw_simulation, bounce(), turns=2), (0xE6, 0x9F, 0x00)) > 100


@pytest.mark.parametrize("rows", [0, 1, 2, 9, 17])
def test_short_trajectories(rows):
    stopped = bounce(label="undecided", status=Status.IMPACT_BUDGET, rows=rows)
    assert count(picture(draw_simulation, stopped, turns=3), RED) > 10


@pytest.mark.parametrize("turns", [1, 3, 40])
def test_any_number_of_turns(turns):
    picture(draw_simulation, bounce(40), turns=turns)


def test_only_the_last_turns_are_shown():
    trace = Trace.of(bounce(5), 2)
    assert (trace.low, trace.high, trace.angle[0]) == (1080.0, 1800.0, 1080.0)
    assert {kind: len(points) for kind, points in trace.events.items()} == {
        "impact": 2,
        "chatter": 2,
        "detachment": 2,
    }
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
    trace = Trace.of(Simulation(RPM, rows, [], "undecided", Status.OK, 1, [], Cost()), 1)
    assert np.isnan(trace.u[trace.angle == 36.0]).any()
    assert np.nanmin(abs(trace.u)) > 0.7
    assert not np.isnan(trace.gap).any()


def test_the_angle_is_the_cams_whatever_the_strobe():
    shifted = [(row[0], (row[1] + 90.0) % 360.0, *row[2:]) for row in bounce().trajectory]
    trace = Trace.of(Simulation(RPM, shifted, [], "contact", Status.OK, 2, [], Cost()), 1)
    assert (trace.low, trace.high) == (450.0, 810.0)


def test_pyplot_stays_out():
    code = "import sys, camcli.plots.sweep; print('matplotlib.pyplot' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
