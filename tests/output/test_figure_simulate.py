"""The picture of a simulation: made-up hops, every edge case."""

import json
import shutil
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import camcli
from camcli.analysis.simulate import simulate as run
from camcli.errors import Status
from camcli.plots import simulate as simulate_plots
from camcli.plots import style
from camcli.plots.simulate import PALE_FLIGHT, Trace, draw_simulation, frame_angles
from camcli.scene.schema import Plot
from camcli.words.simulate import slowed
from tests.conftest import settings
from tests.support.picture_sizes import EVEN, bounce, count, pixels, tall


@pytest.mark.parametrize(("turns", "shown"), [(1, 1), (40, 40)])
def test_any_number_of_turns(turns, shown):
    image = pixels(draw_simulation(bounce(turns), EVEN, shown))
    for colour in (style.FLIGHT, style.STICKING, style.CHATTER, style.DETACHMENT):
        assert count(image, colour) > 50


@pytest.mark.parametrize("rows", [0, 17])
def test_a_run_that_stopped_early_says_so(rows):
    stopped = bounce(label="undecided", status=Status.IMPACT_BUDGET, rows=rows)
    picture = draw_simulation(stopped, EVEN, 3)
    assert count(pixels(picture), style.TROUBLE) > 10
    assert "impact-budget" in picture.words
    tall(picture)


@pytest.mark.parametrize("rpm", [190.0, 198.4])
def test_corners_are_kinks_in_the_relative_velocity(chapter, rpm):
    few, many = (
        Trace.of(run(chapter, rpm, settings(10, 1), samples), chapter, 1) for samples in (90, 3600)
    )
    inside = ~(few.sticks | np.isnan(few.u))
    exact = np.interp(few.angle[inside], many.angle, many.u)
    near = np.abs(few.angle[inside] - 209.8206285048424) < 4.0
    assert np.abs(few.u[inside] - exact)[near].max() < 5e-4
    if rpm == 190.0:
        assert few.u[inside][near].max() == pytest.approx(2.005, abs=6e-4)


@pytest.mark.slow
def test_an_animation_is_one_period_that_repeats(cam, tmp_path, monkeypatch):
    few = partial(simulate_plots.draw_frames, frames=6, near_frames=6)  # to save time
    monkeypatch.setattr(simulate_plots, "draw_frames", few)
    values = {"run.rpm": 190, "run.transient": 10, "run.record": 2}
    sets = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    done = cam("simulate --animate", *sets, "--no-plot -o here --json", code=0)
    written = json.loads(done.stdout)["artefacts"]
    assert ("simulate.mp4" in written) == (shutil.which("ffmpeg") is not None)
    with Image.open(tmp_path / "here" / "simulate.gif") as film:
        assert film.n_frames == 6
        assert film.info["loop"] == 0
        lasting = []
        for frame in range(film.n_frames):
            film.seek(frame)
            lasting.append(film.info["duration"])  # ms, in whole hundredths of a second
    assert lasting == [30, 40, 30, 30, 40, 30]  # 30 frames a second


def test_impacts_before_a_detachment_are_told_apart_from_turn_to_turn(chapter):
    """At 198.58 rpm the turns with and without a complete chatter take turns."""
    simulation = run(chapter, 198.58, settings(600, 4), 90)
    picture = draw_simulation(simulation, chapter, 2)
    axes = picture.figure(Plot(panels=["passage"])).axes[1]
    low, high = axes.get_xlim()
    angles = np.array([6.0 * 198.58 * row[0] for row in simulation.events if row[3] == "impact"])
    shown = angles[angles > angles.max() // 360.0 * 360.0 - 360.0]
    turns = [[x % 360.0 for x in shown if x // 360.0 % 2 == k] for k in (0, 1)]
    wanted = sorted(sorted(x for x in own if low < x < high) for own in turns)
    found = sorted(
        sorted(line.get_xdata()) for line in axes.lines if line.get_label().startswith("impact")
    )
    assert min(map(len, wanted)) > 10
    assert len(found) == 2
    for one, two in zip(found, wanted, strict=True):
        assert one == pytest.approx(two, abs=1e-6)
    filled, hollow = (
        sorted(line.get_xdata())
        for line in sorted(axes.lines, key=lambda line: line.get_label())
        if line.get_label().startswith("impact")
    )
    curves = [line for line in axes.lines if line.get_color() in (style.FLIGHT, PALE_FLIGHT)]
    for line, own in zip(curves, (filled, hollow), strict=True):  # on its own turn's curve
        x, y = (column[np.isfinite(line.get_ydata())] for column in line.get_data())
        gap = np.interp(own, x, y)
        other = np.interp(hollow if own is filled else filled, x, y)
        assert np.median(gap) < 0.2 * np.median(other)


def test_frames_are_two_degrees_apart_near_impacts_and_six_elsewhere():
    impacts = np.array([100.0, 130.0, 300.0])
    places = frame_angles(0.0, 360.0, impacts)
    steps = np.diff(np.append(places, 360.0))
    assert steps.max() <= 6.0 + 1e-9
    for place, step in zip(places, steps, strict=True):
        away = np.maximum(np.maximum(place - impacts, impacts - place - step), 0.0).min()
        assert step <= 2.0 + 1e-9 or away >= 8.0
    assert np.sum(steps > 5.9) > 35
    assert frame_angles(360.0, 1080.0, np.empty(0)) == pytest.approx(np.arange(360.0, 1080.0, 6.0))
    assert slowed(190.0, 2.0) == "6.33 times slower"
    assert slowed(190.0, 2.0, 3.0) == "6.33 times slower, 3 times that near impacts"


@pytest.mark.parametrize("width", [85.0, 170.0])
def test_no_machine_is_cut_off(width):
    """At any width of the picture the frame, the cam and the words lie within their panel."""
    result = camcli.simulate(camcli.load_scene(None), profile_only=True)
    form = Plot(panels=["outline", "turned", "mechanism"], width=width)
    figure = result.pictures["profile"]().figure(form)
    figure.draw_without_rendering()
    seen = [axes for axes in figure.axes if not axes.spines["left"].get_visible()]
    assert len(seen) == 3
    for axes in seen:
        panel = axes.get_window_extent()
        for artist in (*axes.lines, *axes.patches, *axes.texts):
            box = artist.get_window_extent()
            assert panel.y0 - 1.0 < box.y0 <= box.y1 < panel.y1 + 1.0
            assert panel.x0 - 1.0 < box.x0 <= box.x1 < panel.x1 + 1.0


def passage(angle, gap, sticks, repeats, impacts=()):
    """(the lines of flight and of sticking of the panel, and its impacts), a detachment at 200."""
    angle = np.asarray(angle, dtype=float)
    events = {"detachment": np.array([[200.0, 0.0]])}
    if len(impacts):
        events["impact"] = np.array([[place, 0.0] for place in impacts])
    trace = SimpleNamespace(
        angle=angle, gap=np.asarray(gap, dtype=float), sticks=np.asarray(sticks), events=events,
        high=angle[-1], during=partial(Trace.during, None),
    )  # fmt: skip
    axes = Figure().subplots()
    simulate_plots._draw_passage(axes, trace, SimpleNamespace(repeats=repeats, corners=[]))
    lines = [line for line in axes.lines if line.get_marker() == "None" and line.get_lw() >= 1.0]
    dots = [line.get_xdata().tolist() for line in axes.lines if line.get_marker() == "o"]
    return lines, dots


def points_of(line) -> list[list[tuple[float, float]]]:
    """What a line joins, piece by piece."""
    pieces = [[]]
    for x, y in zip(*line.get_data(), strict=True):
        if np.isnan(x) or np.isnan(y):
            pieces.append([])
        else:
            pieces[-1].append((float(x), float(y)))
    return [piece for piece in pieces if piece]


@pytest.mark.parametrize("repeats", [1, 2])
def test_lines_of_a_passage_join_where_the_state_changes(repeats):
    """Rest up to 200 deg, a hop up to 202, rest from there: each joint is a point of both lines.

    The turns have hops of heights 1 and 2, and nothing is drawn from 8 deg before the detachment on
    backwards, or from 4 deg behind it.
    """
    angle = np.arange(0.0, 1440.0)
    within = angle % 360.0
    sticks = (within < 200.0) | (within >= 202.0)
    height = 1.0 + angle // 360.0 % 2.0
    gap = np.where(within == 201.0, height, 0.0)
    impacts = [202.0 + 360.0 * k for k in range(4)] + [180.0, 205.0]
    lines, dots = passage(angle, gap, sticks, repeats, impacts)
    heights = [[1.0, 2.0, 1.0, 2.0]] if repeats == 1 else [[1.0, 1.0], [2.0, 2.0]]
    assert len(lines) == 2 * len(heights)
    for own, (flight, rest) in zip(heights, zip(lines[::2], lines[1::2], strict=True), strict=True):
        assert points_of(flight) == [[(200.0, 0.0), (201.0, top), (202.0, 0.0)] for top in own]
        before = [(193.0 + k, 0.0) for k in range(8)]
        assert points_of(rest) == [before, [(202.0, 0.0), (203.0, 0.0)]] * len(own)
        assert rest.get_lw() > flight.get_lw()
    assert dots == [[202.0] * len(own) for own in heights]
    assert len({line.get_color() for line in lines}) == 1 + len(heights)


def test_a_line_of_a_passage_does_not_go_on_to_the_turn_after_it():
    """One point of a flight in each turn, all near the detachment: they are of two shades."""
    angle = [198.0, 558.0, 918.0, 1278.0]
    (first, _, second, _), _ = passage(angle, [1.0, 2.0, 3.0, 4.0], [False] * 4, 2)
    assert points_of(first) == [[(198.0, 1.0)], [(198.0, 3.0)]]
    assert points_of(second) == [[(198.0, 2.0)], [(198.0, 4.0)]]
