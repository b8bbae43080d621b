"""Sizes and limits of what is drawn, a case on either side: lash, turns of a page, frames."""

import io
from math import nextafter
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from camcli.analysis.labels import Label
from camcli.api.explore_motions import attractors
from camcli.output.pictures import write_animation
from camcli.plots import style
from camcli.plots.detach import _draw_forces
from camcli.plots.mechanism import Outline
from camcli.plots.simulate import frame_angles, hard_impacts
from camcli.quantities import MILLIMETRES

WIDE = 0.08 * 0.05  # m, of the largest radius


@pytest.mark.parametrize(
    ("lash", "times"),
    [(0.001, 4.0), (0.0032, 1.25), (nextafter(WIDE, 0.0), 1.0), (WIDE, 1.0), (0.005, 1.0)],
)
def test_a_lash_is_drawn_as_wide_as_can_be_seen(lash, times):
    """The lobe is drawn as much lower as the gap is drawn wider, and the picture says how much."""
    radius = np.array([0.03, 0.04, 0.05])
    lowered = radius - lash

    def outline(flat=False, low=lowered):
        angles = np.array([0.0, 2.0, 4.0])
        return Outline(angles, radius, {}, [], False, flat, MILLIMETRES, True, 1.0, 0.02,
                       lowered=low, lash=lash)  # fmt: skip

    seen = outline().with_lash_seen()
    assert seen.widened == pytest.approx(times)
    assert seen.lowered == pytest.approx(radius - max(WIDE, lash))
    assert seen.radius is radius
    for same in (outline(flat=True), outline(low=None)):
        assert same.with_lash_seen() is same


@pytest.mark.parametrize(
    ("corner", "words", "named"),
    [(200.0, "at 4000 rpm", True), (300.0, "at 4000 rpm", False), (300.0, "", True)],
)
def test_names_of_corners_do_not_meet_the_words_above_a_panel(corner, words, named):
    """In a panel of 75 mm, as two stand beside one another on a page."""
    axes = Figure(figsize=(75.0 / 25.4, 2.0), dpi=style.DPI).add_axes((0.0, 0.0, 1.0, 1.0))
    curve = Made(theta=(0.0, 6.0), force_n=(1.0, 2.0), rpm=4000.0, lowest_n=1.0)
    _draw_forces(axes, [curve], ["present spring"], {"b": corner}, words)
    assert ("b" in [text.get_text() for text in axes.texts]) is named
    assert any(list(line.get_xdata()) == [corner, corner] for line in axes.lines)


def made_sweep(label, recorded):
    """One speed whose position at the strobe of turn n is 1 + n/100, with an impact in each."""
    turns = np.arange(recorded)
    speed = Made(
        rpm=30.0, label=label, exponent=0.125,
        impacts=(turns, 10.0 * turns, turns, -1.0 * turns),
        strobe=(turns, 1.0 + 0.01 * turns, 2.0 + 0.01 * turns),
    )  # fmt: skip
    return Made(values=[Made(speeds=[speed])])


MACHINE = Made(system=Made(cam=Made(strobe=0, stretches=[Made(start_c=0.5, start_c1=0.0)])))


@pytest.mark.parametrize(
    ("label", "recorded", "asked", "shown", "loops", "points"),
    [
        (Label((1.0,) * 15 + (2.0,)), 40, 20, 16, True, 16),
        (Label((1.0,) * 16 + (2.0,)), 40, 20, 16, False, 17),
        (Label((1.0, 2.0)), 40, 20, 2, True, 2),
        (Label((1.0, 2.0, 3.0)), 40, 2, 2, False, 3),
        (Label((1.0, 2.0, 3.0)), 2, 20, 2, False, 2),
        ("aperiodic", 40, 20, 16, False, 40),
        ("aperiodic", 40, 15, 15, False, 40),
        ("aperiodic", 40, 0, 1, False, 40),
        ("contact", 40, 20, 1, True, 1),
    ],
)
def test_a_page_shows_at_most_sixteen_turns_of_a_motion(
    label, recorded, asked, shown, loops, points
):
    """It starts where so many are left of the record; one that repeats is shown once."""
    (motion,) = attractors(MACHINE, [("up", made_sweep(label, recorded))], asked)
    assert (motion.turns, motion.loops, motion.origin) == (shown, loops, "up")
    first = 1.0 + 0.01 * (recorded - shown)
    assert (motion.q, motion.v) == (pytest.approx(first), pytest.approx(first + 1.0))
    last = np.arange(recorded)[-points:]
    assert motion.impacts[0] == pytest.approx(10.0 * last)
    assert motion.impacts[1] == pytest.approx(-1.0 * last)
    assert motion.strobes[0] == pytest.approx(1.0 + 0.01 * last)
    assert motion.stable == (None if label == "aperiodic" else True)


def test_a_motion_that_two_sweeps_find_is_shown_once():
    period = Label((1.0, 2.0))
    twice = made_sweep(period, 40)
    sweeps = [("up", twice), ("down", twice), ("fixed", made_sweep("contact", 40))]
    sweeps.append(("fixed", made_sweep("contact", 0)))
    assert [one.origin for one in attractors(MACHINE, sweeps, 20)] == ["up", "fixed"]


@pytest.mark.parametrize(
    ("impacts", "frames"),
    [
        ([], [range(0, 360, 6)]),
        ([100.0], [range(0, 91, 6), range(92, 109, 2), range(114, 360, 6)]),
        ([98.0], [range(0, 91, 6), range(92, 107, 2), range(112, 360, 6)]),
        ([97.9], [range(0, 85, 6), range(86, 107, 2), range(112, 360, 6)]),
        ([370.0], [range(0, 360, 6)]),
        ([366.0], [range(0, 355, 6), range(356, 360, 2)]),
    ],
)
def test_frames_are_closer_from_eight_degrees_before_an_impact_to_eight_behind(impacts, frames):
    """Six degrees a frame, 60 a turn; two where its beginning or end is so close."""
    wanted = [angle for part in frames for angle in part]
    assert frame_angles(0.0, 360.0, np.array(impacts)) == pytest.approx(wanted)


def test_an_impact_a_tenth_as_hard_as_the_hardest_is_hard():
    speeds = np.array([[-2.0, 1.0], [-0.2, 0.1], [-0.1999, 0.1], [0.0, 0.0]])
    angles = np.array([[30.0, 0.0], [90.0, 0.0], [150.0, 0.0], [200.0, 0.0]])
    assert list(hard_impacts(Made(events={"impact": angles}, jumps=speeds))) == [30.0, 90.0]
    assert not len(hard_impacts(Made(events={}, jumps=np.empty((0, 2)))))


def test_a_film_has_thirty_frames_a_second():
    """In hundredths of a second, as a GIF counts: three frames last a tenth, none twice as long."""

    def frames():
        figure = Figure(figsize=(0.2, 0.2), dpi=50)
        FigureCanvasAgg(figure)
        for shade in range(7):
            figure.set_facecolor(str(shade / 7))
            yield figure

    file = io.BytesIO()
    write_animation(frames(), file, "gif")
    with Image.open(file) as film:
        lasting = []
        for number in range(film.n_frames):
            film.seek(number)
            lasting.append(film.info["duration"])
    assert lasting == [30, 40, 30, 30, 40, 30, 30]
    assert sum(lasting[:6]) == 200
