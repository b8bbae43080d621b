"""What a command foresees of a scene, beside figures worked out by hand and files that are left.

The counts of a plan are counted here from the scene's own words; bytes of tables are compared with
those of a run. Ways, further starts, zooms, sections and a second number are each off the default.
"""

from __future__ import annotations

import numpy as np
import pytest

import camcli
from camcli.api.bench import plan as bench_plan
from camcli.api.command import command_of, fewer
from camcli.api.machine import Varied, machine_of, ranged
from camcli.words.speeds import chosen_speeds

TURNS = {"run.transient": 30, "run.record": 70}


def scene_of(**values):
    """The chapter's machine; `__` in a name is the dot of a key."""
    own = {name.replace("__", "."): value for name, value in values.items()}
    return camcli.load_scene(None, {**TURNS, **own})


def axis(key, start, stop, num):
    return {"key": key, "start": start, "stop": stop, "num": num}


RANGE = {"start": 690.0, "stop": 745.0, "num": 21}
MASS, LOSS = axis("follower.mass", 1.0, 2.0, 6), axis("follower.restitution", 0.7, 0.8, 5)
ALSO = [{"q": 0.2, "v": 0.0, "theta_deg": 0.0}, {"q": 0.3, "v": 0.1, "theta_deg": 0.0}]
PARTS = [{"start": 700.0, "stop": 710.0, "num": 4}, {"start": 730.0, "stop": 735.0, "num": 3}]
PLANS = [  # command, values: words, pieces, orbits, turns of all orbits, rows
    ("sweep", {"sweep__rpm": RANGE}, "21 speeds of 100 turns, 70 recorded", 21, 21, 2100, 21),
    ("sweep", {"sweep__rpm": RANGE, "sweep__zoom": PARTS, "sweep__direction": "both"},
     "56 speeds of 100 turns, 70 recorded", 56, 56, 5600, 56),
    ("sweep", {"sweep__rpm": RANGE, "sweep__also": ALSO, "sweep__direction": "up"},
     "63 speeds of 100 turns, 70 recorded", 63, 63, 6300, 63),
    ("sweep", {"sweep__rpm": RANGE, "sweep__vary": [LOSS]},
     "5 speeds of 100 turns, 70 recorded", 5, 5, 500, 5),
    ("sweep", {"sweep__vary": [LOSS, MASS]},
     "30 speeds of 100 turns, 70 recorded", 30, 30, 3000, 30),
    ("classify", {"classify__rpm": RANGE, "classify__starts": 3},
     "21 speeds x 4 starts x 70 recorded turns", 84, 84, 8400, 21),
    ("basins", {"basins__cells": [30, 20], "basins__refine": 0},
     "30 x 20 cells, refined 0 times", 600, 600, 0, 600),
    ("basins", {"basins__cells": [30, 20], "basins__refine": 2,
                "basins__rpm": {"start": 690.0, "stop": 700.0, "num": 3}},
     "30 x 20 cells, refined 2 times", 1800, 1800, 0, 1800),
    ("basins", {"basins__cells": [30, 20], "basins__vary": [axis("follower.mass", 1.0, 2.0, 4)]},
     "30 x 20 cells, refined 0 times", 2400, 2400, 0, 0),
    ("simulate", {"simulate__samples": 90}, "70 recorded turns x 90 samples", 70, 1, 100, 0),
    ("simulate", {"simulate__samples": 90,
                  "simulate__beside": [{"kind": "eccentric", "base": 0.1, "lift": 0.02}] * 2,
                  "simulate__profile_only": True}, "270 samples", 1, 0, 0, 270),
    ("detach", {"detach__rpm": {"start": 100.0, "stop": 200.0, "num": 17}},
     "17 runs", 17, 17, 0, 17),
    ("orbits", {"orbits__starts": 7}, "8 runs", 8, 8, 0, 8),
    ("explore", {"sweep__rpm": RANGE, "basins__cells": [30, 20], "explore__basins": True},
     "21 speeds of 3 sweeps, 600 cells", 21, 663, 6300, 21),
    ("explore", {"sweep__rpm": RANGE, "sweep__vary": [LOSS, MASS], "explore__map": True},
     "21 speeds of 3 sweeps, 30 points of a map", 21, 93, 9300, 21),
    ("explore", {"sweep__rpm": RANGE, "sweep__vary": [LOSS], "explore__map": True},
     "21 speeds of 3 sweeps, 105 points of a map", 21, 168, 16800, 21),
]  # fmt: skip


@pytest.mark.parametrize("plan", PLANS, ids=lambda plan: f"{plan[0]}: {plan[3]}")
def test_counts_of_a_plan(plan):
    name, values, *wanted = plan
    size = command_of(name).size(scene_of(**values))
    assert [size.what, size.pieces, size.orbits, size.turns, size.rows] == wanted
    assert min(size.memory, size.tables, size.kept) >= 0.0


STEPS = {"start": 690.0, "stop": 745.0, "num": 13}
FILES = [
    ("sweep", {"sweep__rpm": STEPS}),
    ("sweep", {"sweep__rpm": STEPS, "sweep__sections": ["impacts"]}),
    ("sweep", {"sweep__rpm": STEPS, "sweep__sections": ["strobe"], "sweep__also": ALSO}),
    ("sweep", {"sweep__rpm": STEPS, "sweep__tables": "none", "sweep__direction": "both"}),
    ("sweep", {"sweep__vary": [LOSS, MASS]}),
    ("simulate", {"simulate__samples": 360}),
    ("simulate", {"simulate__samples": 3600, "simulate__profile_only": True}),
    ("classify", {"classify__rpm": {"start": 690.0, "stop": 700.0, "num": 11}}),
    ("basins", {"basins__rpm": {"start": 700.0, "stop": 700.0, "num": 1},
                "basins__cells": [25, 25]}),
]  # fmt: skip


@pytest.mark.parametrize("run", FILES, ids=lambda run: f"{run[0]} {sorted(run[1])}")
def test_the_tables_of_a_plan_are_left(tmp_path, run):
    """Within a factor of two, and some lines for headings."""
    name, values = run
    scene = scene_of(**values)
    size = command_of(name).size(scene)
    getattr(camcli, name)(scene).save(tmp_path, plot=False)
    files = [path for path in tmp_path.iterdir() if path.suffix == ".csv"]
    left = sum(path.stat().st_size for path in files)
    assert left / 2.0 - 500 <= size.tables <= 2.0 * left + 500
    if name == "sweep":
        (table,) = (path for path in files if path.stem in ("speeds", "map"))
        assert len(table.read_text().splitlines()) == size.rows + 1


@pytest.mark.parametrize("n", [1, 2, 5, 21, 40])
@pytest.mark.parametrize("ends", [(690.0, 745.0), (745.0, 690.0)], ids=["up", "down"])
def test_a_sample_lies_in_the_middles_of_equal_parts(n, ends):
    start, stop = ends
    scene = scene_of(sweep__rpm={"start": start, "stop": stop, "num": 21}, sweep__vary=[MASS])
    found = fewer(scene.sweep, n)
    (mass,) = found["vary"]
    for one, low, high, num in ((found["rpm"], start, stop, 21), (mass, 1.0, 2.0, 6)):
        part = (high - low) / n
        middles = [low + part * (k + 0.5) for k in (0, n - 1)]
        assert one.num == min(n, num)
        assert (one.start, one.stop) == pytest.approx([low, high] if n >= num else middles)


@pytest.mark.parametrize("num", [2, 3, 4, 5, 9, 20])
@pytest.mark.parametrize(("start", "step"), [(4.0, 1.0), (90.0, -3.0)])
def test_a_sample_of_whole_numbers_has_whole_numbers(start, step, num):
    """Some of the range's own, equally spaced, and not its ends: no run has half a turn more."""
    stop = start + step * (num - 1)
    scene = scene_of(sweep__vary=[axis("run.record", start, stop, num)])
    own = [start + step * k for k in range(num)]
    for n in (1, 2, 3, 4, 8, 20):
        (sampled,) = fewer(scene.sweep, n)["vary"]
        found = np.linspace(sampled.start, sampled.stop, sampled.num).tolist()
        assert set(found) <= set(own)
        assert len(found) == len(set(found)) <= n
        if n >= num:
            assert found == own
        elif num > 2:
            assert len(found) == min(n, num - 2)
            assert not {start, stop} & set(found)
            before, behind = own.index(found[0]), num - 1 - own.index(found[-1])
            assert abs(before - behind) <= 1  # in the middle
        # at least as far apart as half the parts into which so many cut the range
        assert np.all(np.abs(np.diff(found)) >= 0.5 * abs(stop - start) / n)
    Varied(machine_of(scene), fewer(scene.sweep, 2)["vary"])  # no value of it is refused


def test_a_sample_has_few_turns_and_no_extras():
    scene = scene_of(
        run__transient=40, run__record=5000, sweep__zoom=PARTS, sweep__also=ALSO,
        sweep__explain=True, sweep__adaptive=True, classify__starts=40, classify__explain=True,
        detach__rpm={"start": 100.0, "stop": 200.0, "num": 400}, basins__refine=3,
        basins__cells=[40, 6], basins__rpm={"start": 690.0, "stop": 700.0, "num": 4},
        simulate__samples=720,
    )  # fmt: skip
    names = "sweep", "classify", "detach", "basins"
    samples = {name: command_of(name).sample(scene, 2) for name in names}
    assert {(one.run.transient, one.run.record) for one in samples.values()} == {(40, 1000)}
    sweep, several = samples["sweep"].sweep, samples["classify"].classify
    assert (sweep.zoom, sweep.also, sweep.explain, sweep.adaptive) == ((), (), False, False)
    assert (sweep.rpm.num, several.rpm.num, several.starts, several.explain) == (2, 2, 5, False)
    assert (samples["detach"].detach.rpm.num, samples["detach"].detach.tolerance) == (50, ())
    window = samples["basins"].basins
    assert (window.cells, window.refine) == ((16, 6), 0)
    assert (window.rpm.start, window.rpm.stop, window.rpm.num) == (695.0, 695.0, 1)
    one, times = command_of("basins").repeated(scene)
    assert (one.basins.rpm.start, one.basins.cells, times) == (695.0, (40, 6), 4)
    assert command_of("basins").repeated(scene_of()) == (scene_of(), 1)


def figures(value: float) -> float:
    """To three digits."""
    return float(f"{value:.3g}")


def test_speeds_that_a_scene_leaves_open():
    """Shares of the first loss of contact, or of the natural frequency where there is none."""
    cam = {"kind": "eccentric", "base": 0.01, "lift": 0.02}
    follower = {"mass": 0.5, "stiffness": 2000.0, "damping": 0.0, "gravity": 0.0, "preload": 0.0}
    scene = camcli.load_scene({"cam": cam, "follower": {**follower, "restitution": 0.5}})
    # contact is lost where omega^2 c_thetatheta = -omega0^2 c: at the top, omega^2 = 4000 * 3
    # and c = 0.03, c_thetatheta = -0.01
    lost = (4000.0 * 0.03 / 0.01) ** 0.5 * 30.0 / 3.141592653589793
    filled = machine_of(scene).scene
    for name, (low, high) in {"sweep": (0.9, 1.5), "detach": (0.9, 1.3), "orbits": (1.0, 1.4),
                              "classify": (1.0, 1.4)}.items():  # fmt: skip
        rpm = getattr(filled, name).rpm
        assert (rpm.start, rpm.stop) == (figures(low * lost), figures(high * lost)), name
    window = filled.basins
    rpm = figures(1.05 * lost)
    assert (window.rpm.start, window.rpm.stop) == (rpm, rpm)
    fast = figures(4.0 * 0.02 * rpm * 3.141592653589793 / 30.0)
    assert (window.q, window.v) == ((0.01, figures(0.01 + 3.0 * 0.02)), (-fast, fast))
    _, chosen = ranged(scene, machine_of(scene).system)
    assert chosen_speeds("sweep", chosen["sweep"]) == (
        f"note: sweep.rpm is not given: it is {figures(0.9 * lost):g} to {figures(1.5 * lost):g} "
        f"rpm of the cam, chosen from the first loss of contact at {lost:.5g} rpm"
    )
    # the spring does not press at the lowest lift: contact is never held, and the speeds are those
    # of the natural frequency
    below = camcli.load_scene(
        {"cam": {**cam, "base": -0.01}, "follower": {**follower, "restitution": 0.5}}
    )
    own = 2000.0**0.5 / 0.5**0.5 * 30.0 / 3.141592653589793
    rpm = machine_of(below).scene.sweep.rpm
    assert (rpm.start, rpm.stop) == (figures(0.5 * own), figures(2.0 * own))
    ball = camcli.load_scene(
        {"cam": cam, "follower": {**follower, "stiffness": 0.0, "restitution": 0.5,
                                  "preload": 3.0, "gravity": 9.81}}
    )  # fmt: skip
    lost = ((9.81 + 3.0 / 0.5) / 0.01) ** 0.5 * 30.0 / 3.141592653589793
    assert machine_of(ball).scene.orbits.rpm.stop == figures(1.4 * lost)


@pytest.mark.parametrize(("lift", "shown"), [(1e-2, None), (1e-9, 1e-9), (1e-14, 1e-12)])
def test_a_window_of_starts_has_some_height_however_low_the_lift(lift, shown):
    """Three lifts above the lowest c, in three digits if they show it; 1e-12 of c at least."""
    cam = {"kind": "eccentric", "base": 1.0, "lift": lift}
    follower = {"mass": 0.5, "stiffness": 2000.0, "restitution": 0.5}
    q = machine_of(camcli.load_scene({"cam": cam, "follower": follower})).scene.basins.q
    if shown is None:
        assert q == (1.0, figures(1.0 + 3.0 * lift))
    else:
        assert q[0] == pytest.approx(1.0, abs=1e-15)
        assert q[1] - q[0] == pytest.approx(3.0 * shown, rel=1e-3)


def test_a_plan_of_measurements_grows_with_what_is_measured():
    """Seconds are in proportion to runs, and to repeats where a run is timed."""
    seconds: dict[str, list[float]] = {}
    for quick, repeats in ((False, 1), (False, 4), (True, 4)):
        scene = camcli.load_scene(None, {"bench.quick": quick, "bench.repeats": repeats})
        for name, part in bench_plan(scene).items():
            assert part["runs"] > 2
            seconds.setdefault(name, []).append(part["seconds"] / part["runs"])
    for name, (once, often, quick) in seconds.items():
        if name == "precision":  # a budget for each run, and the time of those that are timed
            assert once < often
            assert quick < often
        else:
            assert often == pytest.approx(once * (4 if name == "scale" else 1))
            assert quick == pytest.approx(once)
    assert set(seconds) == {"precision", "stability", "scale", "validation"}


# Bytes as they were measured once: of the program's memory, of the files that are left, and of the
# pieces until then. 70 of the 100 turns are recorded, at impacts and strobes. A speed that is in
# memory takes 4096 bytes there beside those of its piece.
SWEPT, SHOWN = 70 * 2, 3 * (64 * 70 + 1000)
TURN_ON_A_PAGE = 48 * 280, 48 * 17  # rows of a turn, in memory and on the page
BYTES = [
    ("sweep", {"sweep__rpm": RANGE}, 32 * SWEPT + 21 * 2100 + 21 * (32 * SWEPT + 800 + 4096),
     21 * (140 + 43 * SWEPT), 21 * (32 * SWEPT + 800)),
    ("sweep", {"sweep__rpm": RANGE, "sweep__sections": ["impacts"], "sweep__also": ALSO},
     32 * 70 + 63 * 2100 + 63 * (32 * 70 + 800 + 4096), 63 * (140 + 43 * 70), 63 * (32 * 70 + 800)),
    ("sweep", {"sweep__rpm": RANGE, "sweep__tables": "none"},
     32 * SWEPT + 21 * 2100 + 21 * (32 * SWEPT + 800 + 4096), 21 * 140, 21 * (32 * SWEPT + 800)),
    ("sweep", {"sweep__rpm": RANGE, "run__record": 100_000},  # 64 MiB of pieces at most
     32 * 200_000 + 21 * 2100 + 2**26, 21 * (140 + 43 * 200_000), 21 * (32 * 200_000 + 800)),
    ("sweep", {"sweep__vary": [LOSS, MASS]}, 30 * (1000 + 800), 30 * 140, 30 * 800),
    ("classify", {"classify__rpm": RANGE, "classify__starts": 3}, 21 * 70 * 45, 21 * 160, 0),
    ("basins", {"basins__cells": [30, 20]}, 600 * 70, 600 * 18, 600 * 27),
    ("basins", {"basins__cells": [30, 20], "basins__refine": 2,
                "basins__rpm": {"start": 690.0, "stop": 700.0, "num": 3}},
     600 * (70 + 14 * 16) + 20_000_000, 3 * 600 * 18, 3 * 600 * 27),
    ("basins", {"basins__cells": [30, 20],
                "basins__rpm": {"start": 690.0, "stop": 700.0, "num": 4}},
     600 * 70, 0, 4 * 600 * 27),
    ("simulate", {"simulate__samples": 90}, 6300 * 240, 6300 * 100, 0),
    ("simulate", {"simulate__samples": 90, "simulate__profile_only": True}, 90 * 350, 90 * 80, 0),
    ("detach", {"detach__rpm": {"start": 100.0, "stop": 200.0, "num": 17}}, 17 * 300, 17 * 100, 0),
    ("orbits", {"orbits__starts": 7}, 8 * 300, 8 * 100, 0),
    ("explore", {"sweep__rpm": RANGE}, 21 * (SHOWN + 2 * TURN_ON_A_PAGE[0]),
     90_000 + 21 * 2 * TURN_ON_A_PAGE[1], 0),
    ("explore", {"sweep__rpm": RANGE, "basins__cells": [30, 20], "explore__basins": True},
     21 * (SHOWN + 2 * TURN_ON_A_PAGE[0]) + 600 * 70 + 256 * 8 * TURN_ON_A_PAGE[0],
     90_000 + (21 * 2 + 256 * 8) * TURN_ON_A_PAGE[1], 0),
    ("explore", {"sweep__rpm": RANGE, "sweep__vary": [LOSS, MASS], "explore__map": True},
     21 * (SHOWN + 2 * TURN_ON_A_PAGE[0]) + 30 * 1000 + 256 * 8 * TURN_ON_A_PAGE[0],
     90_000 + (21 * 2 + 256 * 8) * TURN_ON_A_PAGE[1], 0),
]  # fmt: skip


@pytest.mark.parametrize("plan", BYTES, ids=lambda plan: f"{plan[0]} {sorted(plan[1])}")
def test_bytes_of_a_plan_are_those_of_its_parts(plan):
    name, values, *wanted = plan
    size = command_of(name).size(scene_of(**values))
    assert [size.memory, size.tables, size.kept] == pytest.approx(wanted, rel=1e-12)


DRAWINGS = [  # command, values: bytes of a PNG, of memory to draw it, for each further pixel
    ("sweep", {}, 700e3, 230e6, 15),
    ("sweep", {"sweep__vary": [LOSS, MASS]}, 80e3, 130e6, 30),
    ("simulate", {"simulate__profile_only": True}, 290e3, 70e6, 5),
    # 90 rows in each of 3 turns, 8 points a row; then no more than 400 000, or 2 a row
    ("simulate", {"simulate__samples": 90, "simulate__plot_turns": 3}, 290e3,
     70e6 + 1000 * 3 * 90 * 8, 5),
    ("simulate", {"simulate__samples": 90, "simulate__plot_turns": 90}, 290e3,
     70e6 + 1000 * 70 * 90 * 8, 5),
    ("simulate", {"simulate__samples": 2000, "simulate__plot_turns": 70}, 290e3,
     70e6 + 1000 * 400_000, 5),
    ("simulate", {"simulate__samples": 5000, "simulate__plot_turns": 70}, 290e3,
     70e6 + 1000 * 2 * 350_000, 5),
    ("classify", {}, 130e3, 230e6, 24),
    ("basins", {}, 110e3, 270e6, 75),
    ("detach", {}, 400e3, 90e6, 5),
    ("orbits", {}, 400e3, 120e6, 5),
    ("explore", {}, 0, 60e6, 0),
    ("bench", {}, 200e3, 100e6, 5),
]  # fmt: skip


@pytest.mark.parametrize("plan", DRAWINGS, ids=lambda plan: f"{plan[0]} {sorted(plan[1])}")
def test_what_a_picture_takes_is_as_it_was_measured(plan):
    name, values, *wanted = plan
    assert [*command_of(name).drawing(scene_of(**values))] == pytest.approx(wanted, rel=1e-12)


def test_what_is_asked_for_beside_tables_is_part_of_a_plan():
    """A page for print, a film; else nothing. And which commands keep pieces, or have a budget."""
    beside = [
        ("detach", {"detach__report": True}, 130e3), ("detach", {}, 0.0),
        ("simulate", {"simulate__animate": True}, 1.2e6), ("simulate", {}, 0.0), ("sweep", {}, 0.0),
    ]  # fmt: skip
    for name, values, wanted in beside:
        assert command_of(name).beside(scene_of(**values)) == wanted, (name, values)
    names = "sweep", "simulate", "basins", "classify", "detach", "orbits", "explore", "bench"
    kept = [name for name in names if command_of(name).keeps_pieces(scene_of())]
    assert kept == ["sweep", "basins", "bench"]
    tolerated = {"detach__tolerance": [{"key": "follower.mass", "percent": 5}]}
    assert command_of("detach").keeps_pieces(scene_of(**tolerated))
    assert [name for name in names if command_of(name).has_budget] == ["detach", "orbits"]
    less = {name: command_of(name).less for name in names if command_of(name).less}
    assert less == {"sweep": "--set sweep.tables=npz writes less"}


@pytest.mark.parametrize(
    ("samples", "n", "turns"), [(90, 2, 200), (9000, 1, 1), (20000, 2, 1), (5000, 3, 5)]
)
def test_a_sample_of_a_motion_has_nine_thousand_rows_for_each_piece(samples, n, turns):
    scene = scene_of(simulate__samples=samples, run__record=5000)
    assert command_of("simulate").sample(scene, n).run.record == turns
