"""What a list, a screen or a note shows seldom: with rows made here, against rows written by hand.

The extreme cases, the published numbers and the whole studies of a bench; orbits of many impacts;
every kind of a point; machines of every kind of cam in a wrong unit; a speed without an error; the
logs of a cluster.
"""

from __future__ import annotations

import io
import logging
import re
import warnings
from contextlib import contextmanager, nullcontext
from math import nan, radians
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.figure import Figure

import camcli
from camcli.analysis.bench import precision, stability, validation
from camcli.analysis.orbits.codim2 import PointKind
from camcli.api import explore_stops
from camcli.api.bench import Throughput
from camcli.api.orbit_question import question_of, varied_by
from camcli.cli import bench, orbits, report
from camcli.errors import SceneError
from camcli.output.pictures import write_animation
from camcli.parallel import dask_cluster
from camcli.plots import bench as drawn_bench
from camcli.plots import orbits as drawn_orbits
from camcli.plots import style
from camcli.plots.axes import point_looks
from camcli.plots.density import Columns
from camcli.plots.simulate import FRAMES_PER_S
from camcli.scene import schema
from camcli.words import in_print
from camcli.words.machine import doubts
from camcli.words.speeds import speed_text

# --- a bench on the screen


def cells(text: str) -> list[list[str]]:
    """The cells of every line that a command prints; lines drawn below heads are left out."""
    lines = [line.strip() for line in text.splitlines()]
    return [re.split(" {2,}", line) for line in lines if line.strip("─")]


def point(method: str, setting: str, seconds: float, error: float, of_bound: float = nan):
    return precision.Measured(
        "chatter", method, setting, seconds, error, 40, of_bound=of_bound, status=precision.OK
    )


def published(problem: str, quantity: str, number: str, ours: float, status: str = "ok"):
    return validation.ValidationRow(
        "a source", quantity, number, ours, ours - float(number), 5.04e-3, "Table 1", "3", "",
        status, 0.1, problem,
    )  # fmt: skip


def test_a_bench_on_the_screen(capsys):
    """Settings lose their `tol`; numbers have two digits, those beside published ones two more."""
    rows = {
        "precision": [
            point(precision.CORE, "tol 1e-9", 0.0625, 1.234e-15, 0.456),
            point("dop853", "tol 1e-12", 0.625, 2.345e-12),
            point("rk45", "tol 1e-3", 0.5, 3.456e-9),
        ],
        "stability": [stability.RowOutcome("1: r = 0", "one", "two", "failed", 1.239)],
        "validation": [
            published("ball", "height, m", "-0.250", -0.2512345),
            published("cam", "a count", "3", 3.0),
            published(
                "cam", "speed", "1.23456789012345678901234567890", 1.25 + 2.0**-50, "published-off"
            ),
        ],
        "scale": [Throughput("sweep", 10.0, 123456, 2, 4.0, 2.54321, 1.5728, 48543.5)],
    }
    bench.show(Made(values=rows, seconds=12.345), False)
    assert cells(capsys.readouterr().out) == [
        ["Work and precision"],
        ["case", "seconds", "error turns", "of bound", "fastest other", "ratio",
         "most exact other", "its error turns"],
        ["chatter", "0.062", "1.2e-15", "0.46", "dop853 1e-12", "10", "dop853 1e-12", "2.3e-12"],
        ["Extreme cases"],
        ["case", "observed", "status", "seconds"],
        ["1: r = 0", "two", "failed", "1.2"],
        ["ball"],
        ["quantity", "published", "ours", "difference", "bound", "status"],
        ["height, m", "-0.250", "-0.25123", "-1.2e-03", "5.0e-03", "ok"],
        ["cam"],
        ["quantity", "published", "ours", "difference", "bound", "status"],
        ["a count", "3", "3", "0.0e+00", "5.0e-03", "ok"],
        ["speed", f"{'1.23456789012345678901234567890'[:bench.MOST_CHARACTERS]}..",
         "1.250000000000001",
         "1.5e-02", "5.0e-03", "published-off"],
        ["Whole studies"],
        ["case", "impacts", "threads", "seconds", "speedup", "impacts per s"],
        ["sweep", "123456", "2", "2.5", "1.6", "4.9e+04"],
        ["3 of precision and 1 of stability and 3 of validation and 1 of scale in 12.3 s"],
    ]  # fmt: skip


def test_no_two_methods_of_a_bench_look_alike():
    looks = [look[1:] for look in drawn_bench.METHODS.values()]
    for part in zip(*looks, strict=True):  # colours, and marks
        assert len({*part}) == len(looks)
    assert {*drawn_bench.METHODS} == {
        precision.CORE, "rk45", "dop853", "lsoda", "radau", "heyoka", "rk4"
    }  # fmt: skip
    for method, (name, _, _) in drawn_bench.METHODS.items():
        assert method in ("core", name.split(",")[0].lower())


# --- orbits of many impacts, and kinds of points


@pytest.mark.parametrize("count", [1, 5, 6, 7, 9])
def test_an_orbit_of_many_impacts_in_lists(count):
    """The screen names six phases and says how many more there are; a page ends in dots."""
    at = [10.0 * (k + 1) + 0.126 for k in range(count)]
    orbit = Made(theta=[radians(x) for x in at], root=None, resting=False, stable=True,
                 label="P(1;1)", trace=0.5, det=0.06)  # fmt: skip
    on_screen = ", ".join(f"{x:g}" for x in at[:6])
    assert orbits._phases(orbit) == on_screen + (f" and {count - 6} more" if count > 6 else "")
    heads, row = drawn_orbits._orbit_rows([orbit], [style.PERIODS[0]])
    on_page = [f"{x:.2f}" for x in at] if count <= 6 else [f"{x:.2f}" for x in at[:5]] + ["…"]
    assert heads == ["", "orbit", "", "multipliers", "phases (deg)"]
    assert row[1:] == ["P(1;1)", "stable", "0.3, 0.2", ", ".join(on_page)]
    orbit.resting, orbit.stable = True, False
    _, row = drawn_orbits._orbit_rows([orbit], [style.PERIODS[0]])
    assert row[1:] == ["P(1;1)", "unstable", "0.3, 0.2", "leaves at " + ", ".join(on_page)]


def test_every_kind_of_a_point_has_a_mark_of_its_own():
    """Its own wherever it is drawn: also where the kinds before it are not there."""
    whole = point_looks([Made(kind=kind) for kind in PointKind])
    assert list(whole) == [kind.value.replace("-", " ") for kind in PointKind]
    assert len({look["marker"] for look in whole.values()}) == len(PointKind)
    for kind in PointKind:
        assert point_looks([Made(kind=kind)] * 2) == {
            kind.replace("-", " "): whole[kind.replace("-", " ")]
        }
    assert point_looks([]) == {}
    for look in whole.values():
        assert {*look} == {"marker", "color", "mfc", "ms", "mew", "ls"}
        assert (look["color"], look["mfc"], look["ls"]) == ("black", "white", "None")


@pytest.mark.parametrize("count", [9, 10, 11])
def test_speeds_are_counted_together_where_there_are_more_than_columns(count):
    """Speeds so uneven that two of them lie in one of the ten columns."""
    speeds = np.append(np.linspace(0.0, 1.0, count - 1), 0.01)
    found = Columns.of(speeds, width=10)
    bins = found.bin_of_speed
    assert len(bins) == count
    assert (len({*bins.tolist()}) == count) == (count <= 10)
    assert found.bins == (count if count <= 10 else 10)
    middle_of_bin = np.asarray(found.place_of_bin)
    if count <= 10:
        assert middle_of_bin == pytest.approx(np.sort(speeds))
    else:
        edges = np.linspace(found.low, found.high, 11)
        assert middle_of_bin == pytest.approx((edges[1:] + edges[:-1]) / 2.0)


# --- numbers and notes


@pytest.mark.parametrize(
    ("error", "said"),
    [(0.0, "739.3197802"), (float("inf"), "739.3197802"), (nan, "739.3197802"), (0.5, "739.3"),
     (0.1, "739.3"), (0.09, "739.32"), (20.0, "739"), (3e-7, "739.3197802")],
)  # fmt: skip
def test_a_speed_has_the_digits_that_its_error_leaves(error, said):
    assert speed_text(739.31978021234, error) == said


def test_a_pair_of_multipliers_has_four_digits_each():
    """On a page and on the screen: of two that are complex, real, equal, or below zero."""
    a, b = 0.123456, 0.765432
    complex_pair = in_print.pair(2.0 * a, a * a + b * b)
    assert complex_pair == "0.1235 ± 0.7654i"
    assert in_print.pair(-2.0 * a, a * a + b * b) == "−0.1235 ± 0.7654i"
    assert in_print.pair(a - b, -a * b) == "−0.7654, 0.1235"  # the larger one first
    assert in_print.pair(1.0, 0.25) == "0.5"
    assert report.pair([complex(a, b), complex(a, -b)], 4) == "0.1235 +- 0.7654 i"
    assert report.pair([complex(a, b), complex(a, -b)], 2) == "0.12 +- 0.77 i"
    assert report.pair([a, -b], 3) == "0.123, -0.765"


@pytest.mark.parametrize(
    ("key", "sections", "meant"),
    [
        ("mass", ("follower", "cam"), ["follower.mass"]),  # that of an oscillator is meant seldom
        ("follower.mas", ("follower", "cam"), ["follower.mass"]),
        ("mass", ("cam",), ["cam.mass"]),
        ("frequency", ("follower", "cam", "run"), ["cam.frequency"]),
        ("strobe", ("run",), ["run.strobe_deg"]),
        ("nothing_like_it", ("follower", "cam", "run"), []),
    ],
)
def test_the_key_that_is_meant_by_a_name_without_its_section(key, sections, meant):
    assert schema._keys_like(key, sections) == meant


def test_a_stop_of_a_page_has_a_speed_of_four_digits():
    told = [explore_stops._round(rpm) for rpm in (114.979, 4123.45, 0.123456)]
    assert told == [115.0, 4123.0, 0.1235]


CAMS = {  # each 250 mm high, with its top at 0.3 m
    "arcs": Made(kind="arcs", nose_center=0.4, nose_radius=0.2, base_radius=0.35, offset=0.3),
    "law": Made(kind="law", lift=0.25, base=0.05),
    "table": Made(kind="table", measured=Made(lift=[0.0, 0.25]), base=0.05, metres=1e-3,
                  subtract=0.0),
    "none": Made(kind="oscillator"),
}  # fmt: skip


@pytest.mark.parametrize("kind", CAMS)
def test_a_cam_of_each_kind_in_a_wrong_unit(kind):
    """Its lift beside the mass, its top beside the spring's solid length and the weight."""

    def said(mass: float, solid_at: float, stiffness: float) -> str:
        follower = Made(mass=mass, stiffness=stiffness, preload=0.0)
        spring = Made(solid_at=solid_at, mass=None)
        run = Made(rpm=700.0, crank=False)
        scene = Made(follower=follower, cam=CAMS[kind], spring=spring, contact=None,
                     detach=Made(hold_to=None), run=run)  # fmt: skip
        return " ".join(doubts(scene))

    known = kind != "none"
    assert ("warning: a lift of 250 mm; is it in m" in said(0.5, 1.0, 1e3)) == known
    assert "a lift of" not in said(1.5, 1.0, 1e3)
    assert ("solid at 299 mm, below the highest lift" in said(0.5, 0.299, 1e3)) == known
    assert "solid" not in said(0.5, 0.301, 1e3)
    # 0.3 m at 100 N/m are 30 N: less than 9.81 m/s2 of 3.1 kg, more than of 3 kg
    assert ("a mass of 3.1 kg weighs more than the 30 N" in said(3.1, 1.0, 100.0)) == known
    assert "weighs" not in said(3.0, 1.0, 100.0)


@pytest.mark.parametrize(
    ("values", "refused"),
    [
        ({}, False),
        ({"run.rpm": 90.0}, False),  # the range that every scene has may be elsewhere
        ({"orbits.rpm": {"start": 690.0, "stop": 710.0, "num": 3}}, False),  # holds the run's speed
        ({"orbits.rpm": {"start": 700.0, "stop": 710.0, "num": 3}}, False),
        ({"orbits.rpm": {"start": 690.0, "stop": 700.0, "num": 3}}, False),
        ({"orbits.rpm": {"start": 701.0, "stop": 710.0, "num": 3}}, True),
        ({"orbits.rpm": {"start": 690.0, "stop": 699.0, "num": 3}}, True),
        ({"orbits.rpm": {"start": 690.0, "stop": 699.0, "num": 3}, "orbits.at": 695.0}, False),
        ({"orbits.rpm": {"start": 701.0, "stop": 701.0, "num": 1}}, False),
        ({"orbits.vary": [{"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 2}]}, True),
    ],
)
def test_chaos_is_asked_at_one_speed(values, refused):
    scene = camcli.load_scene(None, {"orbits.chaos": True, "run.rpm": 700.0, **values})
    with pytest.raises(SceneError) if refused else nullcontext():
        question_of(scene, varied_by(scene))


def test_logs_of_a_cluster_are_silent_and_no_others():
    names = ["distributed", "distributed.worker", "tornado.application", "asyncio", "dask",
             "distributed_other"]  # fmt: skip
    loggers = {name: logging.getLogger(name) for name in names}
    levels = {name: logger.level for name, logger in loggers.items()}
    with warnings.catch_warnings():
        try:
            for logger in loggers.values():
                logger.setLevel(logging.DEBUG)
            dask_cluster._silence()
            silent = [n for n in names if not loggers[n].isEnabledFor(logging.CRITICAL)]
            action, _, _, module, _ = warnings.filters[0]
        finally:
            for name, logger in loggers.items():
                logger.setLevel(levels[name])
    assert silent == names[:4]
    assert action == "ignore"
    assert module.match("distributed.worker")
    assert not module.match("numpy")


@pytest.mark.parametrize(
    ("pieces", "slots", "count", "seconds", "size"),
    [
        (10_000, 2, 1, 1e-9, dask_cluster.MOST_IN_CHUNK),  # as many as go at once
        (10_000, 2, 4, 2.0 * dask_cluster.TARGET, 2),  # as long as is wanted
        (4 * dask_cluster.CHUNKS_PER_SLOT, 2, 1, 1e-9, 2),  # a share for every thread
        (10_000, 2, 1, 100.0, 1),
        (1, 8, 1, 1e-9, 1),
    ],
)
def test_chunks_of_a_cluster_take_about_as_long_as_is_wanted(pieces, slots, count, seconds, size):
    assert dask_cluster._size_of_chunk(pieces, slots, count, seconds) == size


SMALL = {  # command: values of a small run
    "simulate": {},
    "sweep": {"sweep.rpm": {"start": 700.0, "stop": 700.0, "num": 1}},
    "detach": {"detach.rpm": {"start": 120.0, "stop": 120.0, "num": 1}},
    "classify": {"classify.rpm": {"start": 700.0, "stop": 700.0, "num": 1}},
    "orbits": {"orbits.rpm": {"start": 700.0, "stop": 700.0, "num": 1}, "orbits.starts": 0},
    "basins": {"basins.cells": [2, 2]},
}


@pytest.mark.parametrize("command", SMALL)
def test_a_result_says_how_long_it_took(command):
    """More than nothing, and no longer than a clock around it."""
    short = {"run.transient": 20, "run.record": 5, "run.patience": 0}
    scene = camcli.load_scene(None, {**short, **SMALL[command]})
    began = perf_counter()
    result = getattr(camcli, command)(scene)
    assert 0.0 < result.seconds <= perf_counter() - began


class Film:
    """Stands for matplotlib's writer by ffmpeg: a file of the letters that the figure had."""

    def __init__(self, fps):
        self.fps = fps

    @contextmanager
    def saving(self, figure, path, dpi):
        self.figure, self.frames = figure, [f"{self.fps} {dpi:g}"]
        yield
        Path(path).write_text(" ".join(self.frames))

    def grab_frame(self):
        self.frames.append(self.figure.get_suptitle())


def test_a_film_has_each_frame_once(monkeypatch):
    """Where ffmpeg writes it: at the pace of the frames and in the picture's own dots."""
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter", Film)
    figure = Figure(dpi=90.0)
    file = io.BytesIO()
    write_animation((figure.suptitle(name).figure for name in "abcd"), file, "mp4")
    assert file.getvalue().decode() == f"{FRAMES_PER_S} 90 a b c d"
