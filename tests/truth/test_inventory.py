"""Every number that a message hangs on has a case on either side.

The conditions are read from the program: each `if` with <, <=, > or >= under which something is
refused, noted or, in `words`, said. One that is not listed here fails: who adds it brings the two
cases, as a row of PAIRS or as a test of its own, named in ELSEWHERE.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf, nextafter, radians
from pathlib import Path
from types import SimpleNamespace as Made
from typing import Any, NamedTuple

import pytest

import camcli
from camcli.analysis import border_collision
from camcli.analysis.border_collision import Side
from camcli.analysis.contact_loss.bursts import LiftOffKind
from camcli.analysis.contact_loss.detachment import CriticalQuantity, detachment
from camcli.api import orbit_tables
from camcli.api.atlas import plane_of
from camcli.api.command import command_of
from camcli.api.explore_motions import refuse_too_many
from camcli.api.family import check_followed
from camcli.api.machine import check_explainable, machine_of
from camcli.api.orbit_question import question_of, varied_by
from camcli.cams.files import read_bytes
from camcli.cli import run, sizes
from camcli.cli.basins import _cells
from camcli.errors import SceneError
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.output.tables import Table
from camcli.scene import Axis
from camcli.scene.load import parse_rpm
from camcli.scene.schema import RpmRange
from camcli.system import System, units_of
from camcli.words import plan
from camcli.words.border_collision import collision_words
from camcli.words.detach import _lift_off, plainly
from camcli.words.explore import Machine
from camcli.words.simulate import closing_words, jerk_title, rounding_notes, slowed
from camcli.words.statuses import counted
from camcli.words.tolerance import share_words
from camcli.words.verdict import (
    _at_the_foot,
    _meetings,
    _on_landings,
    _seated,
    _with_range,
    height,
)
from tests.conftest import cam_in

ROOT = Path(__file__).parents[2]
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
SAYING = {"Fault", "refused", "note", "SceneError", "ValueError", "fault"}
BLOCKS = (ast.If, ast.For, ast.While, ast.With, ast.Try, ast.FunctionDef)


def has_order(test: ast.expr) -> bool:
    """Whether a condition asks which of two is the larger."""
    return any(
        isinstance(order, ORDERS)
        for node in ast.walk(test) if isinstance(node, ast.Compare) for order in node.ops
    )  # fmt: skip


def said_in(body: list[ast.stmt]) -> Iterator[ast.AST]:
    """All that stands in these statements themselves, without the blocks in them."""
    for statement in body:
        if not isinstance(statement, BLOCKS):
            yield from ast.walk(statement)


def refuses(body: list[ast.stmt]) -> bool:
    for node in said_in(body):
        if isinstance(node, ast.Raise) and node.exc is not None:
            return True
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if name in SAYING:
                return True
    return False


def has_words(body: list[ast.stmt]) -> bool:
    return any(
        isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip()
        for node in said_in(body)
    )


def conditions() -> Iterator[str]:
    """`file: condition` of every threshold of a message."""
    for part in ("api", "cams", "cli", "scene", "output", "words"):
        for path in sorted((ROOT / "camcli" / part).rglob("*.py")):
            name = path.relative_to(ROOT / "camcli").as_posix()
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                words = part == "words"
                if isinstance(node, ast.If) and has_order(node.test):
                    told = refuses(node.body) or (words and has_words(node.body))
                elif words and isinstance(node, ast.IfExp) and has_order(node.test):
                    told = has_words([ast.Expr(node.body), ast.Expr(node.orelse)])
                else:
                    continue
                if told:
                    yield f"{name}: {ast.unparse(node.test)}"


ELSEWHERE = {  # condition: the test that has a case on either side
    "words/verdict.py: hardest > 0.0":
        "tests/published/test_impact_oscillator.py::"
        "test_the_verdict_on_an_oscillator_is_about_its_stop",
    "words/detach_tables.py: len(kept) < len(rows)":
        "tests/truth/test_pictures_detach.py::"
        "test_a_long_table_of_a_report_says_how_many_rows_it_leaves_out",
    "output/npz.py: self._next + data.nbytes > self.end":
        "tests/output/test_npz.py::test_another_number_of_rows_than_was_counted_is_refused",
    "api/explore_motions.py: samples * motions > ROOM":
        "tests/output/test_explore_sizes.py::test_what_is_too_fast_to_be_shown_is_refused_before",
    "api/orbit_tables.py: numbers > most_numbers or lines >= MOST_LINES":
        "tests/truth/test_inventory.py::test_so_many_numbers_are_drawn_over_a_picture",
    "cams/law.py: abs(rest) > CLOSURE": "tests/truth/test_thresholds.py::test_forms",
    "cams/law.py: lobe > TURN + written(CLOSURE)": "tests/truth/test_thresholds.py::test_forms",
    "cams/lift_guess.py: len(run.rows) < LEAST_RUN":
        "tests/truth/test_table_thresholds.py::test_guesses",
    "cams/lift_guess.py: again < len(below) and (not any((k < again for k in continuing)))":
        "tests/cams/test_table_files.py::REFUSED",
    "cams/lift_guess.py: before - now > self.reach and now >= self.angles[0]":
        "tests/cams/test_table_files.py::REFUSED",
    "cams/lift_reading.py: count > most": "tests/truth/test_table_thresholds.py::test_sizes",
    "cams/lift_reading.py: count > MAX_LINES": "tests/truth/test_table_thresholds.py::test_sizes",
    "cams/lift_reading.py: len(line) > LONGEST_LINE":
        "tests/truth/test_table_thresholds.py::test_sizes",
    "cams/lift_reading.py: max(chosen) >= width":
        "tests/cams/test_lift_table_faults.py::test_a_file_that_is_no_table_is_refused",
    "cams/lift_reading.py: len(rows.angle) < LEAST_ROWS":
        "tests/truth/test_table_thresholds.py::test_reading",
    "cams/lift_reading.py: span > 360 + spacing / 4":
        "tests/truth/test_table_thresholds.py::test_reading",
    "cams/lift_reading.py: off < LEAST_MOVING":
        "tests/truth/test_table_thresholds.py::test_reading",
    "cams/lift_reading.py: abs(steps[-1] - steps[0]) > 2 * step + abs(steps[1] - steps[0]) // 4":
        "tests/cams/test_lift_table_faults.py::test_ends_of_a_table_may_be_off_by_its_last_digit",
    "cams/lift_reading.py: rows_lack and gap > WIDEST_GAP":
        "tests/truth/test_table_thresholds.py::test_reading",
    "cli/forecast.py: watch.passed() > MOST":
        "tests/cli/test_plan.py::test_a_sample_that_takes_long_is_cut_off",
    "cli/merge.py: lacking(total) > 0":
        "tests/cli/test_merge.py::test_what_is_missing_torn_or_of_another_run",
    "cli/sizes.py: needed > limit.bytes":
        "tests/truth/test_inventory.py::test_what_needs_more_than_there_is_is_refused",
    "cli/run.py: max(size.tables, size.kept) > MUCH":
        "tests/truth/test_inventory.py::test_much_to_write_is_noted",
    "scene/load.py: len(data) > MAX_BYTES":
        "tests/truth/test_thresholds.py::test_a_scene_has_so_many_bytes",
    "words/detach.py: first.rpm > max(rpms)": "tests/truth/test_thresholds.py::test_springs",
    "words/detach.py: first.rpm < min(rpms)": "tests/truth/test_thresholds.py::test_springs",
    "words/lift_table.py: accuracy.noise > NOISY * rounding":
        "tests/truth/test_table_thresholds.py::test_what_a_fit_is_warned_of",
    "words/lift_table.py: accuracy.largest > OUTLIER * accuracy.noise":
        "tests/truth/test_table_thresholds.py::test_what_a_fit_is_warned_of",
    "words/machine.py: lift > LARGE_LIFT and follower.mass < LARGE_MASS":
        "tests/truth/test_thresholds.py::test_doubts",
    "words/machine.py: radius is not None and radius > LARGE_RADIUS":
        "tests/truth/test_thresholds.py::test_doubts",
    "words/machine.py: solid is not None and solid < top":
        "tests/truth/test_thresholds.py::test_doubts",
    "words/machine.py: follower.preload < 0.0": "tests/truth/test_thresholds.py::test_doubts",
    "words/machine.py: least > RADII * lift":
        "tests/truth/test_table_thresholds.py::test_radii_are_doubted",
    **dict.fromkeys(
        (
            "words/machine.py: 0.0 < added < FLAT * follower.preload",
            "words/machine.py: is_heavy and force < WEIGHT * follower.mass",
            "words/machine.py: spring.mass > others",
            "words/machine.py: width is not None and width > LARGE_WIDTH",
        ),
        "tests/truth/test_thresholds.py::test_doubts",
    ),
    "words/verdict.py: first > rpm": "tests/truth/test_thresholds.py::test_springs",
}  # fmt: skip


class Pair(NamedTuple):
    """What is said by two cases: of `within` not these words, of `beyond` they are."""

    words: str
    said: Callable[[Any], str]
    within: Any
    beyond: Any


def faults(call: Callable[..., Any]) -> Callable[[Any], str]:
    """What a call refuses, as text; empty where it takes its argument."""

    def said(value: Any) -> str:
        try:
            call(value)
        except (SceneError, ValueError) as error:
            return str(error)
        return ""

    return said


def scene_of(values: dict[str, Any]) -> Any:
    return camcli.load_scene(None, values)


SCENE = faults(scene_of)
CHAPTER = camcli.load_scene()
SYSTEM = machine_of(CHAPTER).system
UNITS = units_of(SYSTEM)
LOW, HIGH = SYSTEM.lift_range
AXIS = {"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 2}
LOSS = {"key": "follower.restitution", "start": 0.7, "stop": 0.9, "num": 3}
SPEEDS = {"orbits.rpm": {"start": 690.0, "stop": 710.0, "num": 3}}
# the flank, nose and top of the arcs: half a turn at most, so that 360 deg are twice as many
FREE = 360.0 - (270.0 - 90.0 - 40.0)
FORCED = {"kind": "oscillator", "stiffness": 1.0, "amplitude": 1.0, "frequency": 1e-9,
          "clearance": 0.0}  # fmt: skip


def asked(values: dict[str, Any]) -> None:
    """What the section `orbits` asks."""
    scene = scene_of({**SPEEDS, **values})
    question_of(scene, varied_by(scene))


def explained(speeds: int) -> None:
    """Ask for an explanation of changes over so many speeds."""
    check_explainable(scene_of({"classify.rpm.num": speeds}).classify, "classify")


def chaos_at(stop: float) -> dict[str, Any]:
    """Chaos asked for from 700 rpm to another speed."""
    return {"orbits.chaos": True, "orbits.rpm": {"start": 700.0, "stop": stop, "num": 3}}


def drawn(count: int) -> None:
    """A picture of two panels into so many axes."""
    import matplotlib.pyplot as plt

    scene = scene_of({"run.transient": 1, "run.record": 2})
    figure, axes = plt.subplots(count, squeeze=False)
    try:
        camcli.plot(camcli.simulate(scene), panels=["gap", "phase"], axes=list(axes.flat))
    finally:
        plt.close(figure)


def curve(axis: dict[str, Any]) -> None:
    scene = scene_of({"sweep.vary": [axis, LOSS], "sweep.curves": "auto"})
    plane_of(scene, scene.sweep.vary)


def lines_of(rpms: list[float]) -> str:
    """What is said of a branch.csv whose branches have these speeds."""
    rows = "".join(f"1,{rpm},1,100,0.1\n" for rpm in rpms)
    path = Path(TEMPORARY[0]) / "branch.csv"
    path.write_text(f"branch,rpm,stable,theta_deg_1,q_m\n{rows}")
    return faults(lambda where: orbit_tables.read_branches(where, "rpm"))(path)


def bytes_of(count: int) -> str:
    path = Path(TEMPORARY[0]) / "file"
    path.write_bytes(b"x" * count)
    return faults(lambda where: read_bytes(where, "file", 1000, "", "", "file"))(path)


def growth(value: float) -> str:
    """What is said of a border collision of two stable sides that grows by so much at the event."""
    found = border_collision.classify(Side(0.3, 0.2), Side(-0.4, 0.3))
    growing = replace(found.growth, left=value)
    return " ".join(collision_words(replace(found, growth=growing)))


def lift_off(landing: float, rest: float) -> str:
    made = Made(landing=landing, rest=rest, release=0.1, corner="b", kind=LiftOffKind.FLIES_OFF)
    return _lift_off(made, 10.0)


def weight(stiffness: float) -> str:
    scene = scene_of({"follower.stiffness": stiffness, "follower.gravity": 9.81})
    return Machine.of(scene, machine_of(scene).system).pull


def raised(lift: float) -> str:
    return height(Made(system=SYSTEM, scene=CHAPTER), LOW + lift - LOW)


def at_the_foot(share: float) -> str:
    """What the verdict says of a rate that is asked for at this share of the lift of the arcs."""
    low, high = radians(90.0), radians(150.0)  # of the flank, on which c rises
    for _ in range(60):
        theta = 0.5 * (low + high)
        at = lift_at(SYSTEM.cam, stretch_at(SYSTEM.cam, theta), theta)[0]
        low, high = (theta, high) if at < LOW + share * (HIGH - LOW) else (low, theta)
    hold = Made(quantity=CriticalQuantity.HOLD_STIFFNESS, theta=theta)
    return " ".join(_at_the_foot(Made(system=SYSTEM), [hold]))


def with_lash(lash: float) -> System:
    """A machine whose lobe has this lash (m), and a seat where it has any."""
    motion = {"length_deg": 60.0, "law": "3-4-5"}
    cam = {"kind": "law", "base": 0.0, "lift": 0.01, "rise": {**motion, "start_deg": 100.0},
           "fall": motion, "lash": lash}  # fmt: skip
    follower = {"restitution": 0.5, "mass": 1.0, "stiffness": 1.0}
    return machine_of(camcli.load_scene({"follower": follower, "cam": cam})).system


def seated(lash: float) -> str:
    """What the verdict says of a seat under a lobe with this lash (m)."""
    names = "rpm", "seat_velocity_m_per_s", "seat_ramp_velocity_m_per_s", "seat_bounce_height_m"
    tables = {"speeds": Table.of_rows(names, lambda: [(700.0, 1.0, 0.5, 1e-4)])}
    return _seated(Made(system=with_lash(lash), tables=tables, summary={}), 650.0)


def range_of_seating(width: float) -> str:
    """What the verdict says of a valve that seats with 2 m/s, where its table leaves this width."""
    low, high = 2.0 - width / 2.0, 2.0 + width / 2.0
    entry = {"seat_velocity_m_per_s": 2.0, "seat_velocity_low_m_per_s": low,
             "seat_velocity_high_m_per_s": high}  # fmt: skip
    return _with_range(Made(summary={"seating": [entry]}), 2.0)


def bouncing(high: float) -> str:
    """What the verdict says of a follower that bounces so high (m) on its seat."""
    row = {"max_impact_m_per_s": 1.0, "landing_deg": 90.0, "landing_lift_m": 0.001,
           "max_gap_m": 0.001, "rpm": 700.0, "shut_bounces_per_turn": 0.0,
           "seat_bounce_height_m": high}  # fmt: skip
    tables = {"speeds": Table.of_rows(tuple(row), lambda: [tuple(row.values())])}
    result = Made(system=with_lash(1e-6), scene=CHAPTER, tables=tables)
    return " ".join(_on_landings(result, 650.0))


def surging(harmonics: list[int]) -> str:
    """What the verdict says where these meet a spring of 433 Hz below 4000 rpm; 7 the strongest."""
    strong = [{"harmonic": n, "rpm": 60.0 * 433.0 / n, "factor": 1.0 / n} for n in harmonics]
    surge = {"frequency_hz": 433.0, "limit": 0.12, "strong": strong}
    return _meetings(surge, strong)


def closing(off: float) -> str:
    return closing_words(Made(touches=[Made(along=0.1)], closing=off), UNITS)


def speeds(num: int) -> RpmRange:
    return RpmRange(start=600.0, stop=700.0, num=num)


def nose(start: float, stop: float) -> Axis:
    """A range of the nose's radius, 0.15 m in the scene."""
    return Axis(key="cam.nose_radius", start=start, stop=stop, num=3)


def constant(low: float, high: float) -> dict[str, Any]:
    return {"orbits.parameter": "restitution", "orbits.range": [low, high]}


def cells(text: str) -> Any:
    return _cells(text)


def wrong(count: int) -> None:
    """A scene with so many keys that nobody knows."""
    unknown = {f"x{k}": 1 for k in range(count)}
    follower = {"mass": 1.0, "stiffness": 1.0, "restitution": 0.5, **unknown}
    camcli.load_scene({"follower": follower, "cam": CHAPTER.cam.model_dump()})


def several(num: int, starts: int) -> dict[str, Any]:
    return {"classify.rpm": {"start": 600, "stop": 700, "num": num}, "classify.starts": starts}


def masses(num: int, starts: int) -> dict[str, Any]:
    """A thousand masses; the speeds of the range, which are so many, do not count."""
    mass = {"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 1000}
    return {**several(num, starts), "classify.vary": [mass]}


def spring(top: float) -> None:
    """With 90 N at the lowest lift, and so many at the highest."""
    loads = {"seat_load": 90.0, "nose_load": top}
    follower = {"mass": 1.0, "restitution": 0.5}
    camcli.load_scene({"follower": follower, "cam": CHAPTER.cam.model_dump(), "spring": loads})


def zoom(start: float, stop: float) -> dict[str, Any]:
    return {"sweep.rpm": {"start": 660.0, "stop": 760.0, "num": 3},
            "sweep.zoom": [{"start": start, "stop": stop, "num": 2}]}  # fmt: skip


def lash(value: float) -> None:
    """On a lobe whose highest lift is 10 mm: 1e-12 of it is rounding."""
    motion = {"length_deg": 60.0, "law": "3-4-5"}
    cam = {"kind": "law", "base": 0.0, "lift": 0.01, "rise": {**motion, "start_deg": 100.0},
           "fall": motion, "lash": value}  # fmt: skip
    camcli.load_scene({"follower": {"restitution": 0.5, "mass": 1.0, "stiffness": 1.0}, "cam": cam})


def lost_at(rpms: list[float]) -> str:
    """What is said of these speeds, past the first loss of contact at 114.98 rpm."""
    found = Made(detachment=detachment(SYSTEM), speeds=[Made(rpm=x) for x in rpms], holds=())
    return " ".join(plainly(found))


def several_basins(num: int) -> Any:
    return scene_of({"basins.rpm": {"start": 690.0, "stop": 700.0, "num": num}})


def line_of(line: str) -> str:
    """What is written to stderr of a command line that is planned only."""
    return cam_in(Path(TEMPORARY[0]), f"{line} --dry-run").stderr


TEMPORARY: dict[int, Path] = {}
PAIRS = {
    "api/atlas.py: axis.start == axis.stop or axis.num < 2": [
        Pair("found one value of follower.mass", faults(curve), AXIS, {**AXIS, "stop": 1.0}),
        Pair("found one value of follower.mass", faults(curve), AXIS, {**AXIS, "num": 1}),
    ],
    "api/explore_motions.py: span.num > most": [
        Pair("speeds", faults(lambda n: refuse_too_many(speeds(n), 250)), 1000, 1001),
        Pair("speeds", faults(lambda n: refuse_too_many(speeds(n), 2500)), 100, 101),
    ],
    "api/family.py: not low <= value <= high": [
        Pair("a range that holds", faults(lambda ends: check_followed(CHAPTER, nose(*ends))),
             (0.15, 0.2), (nextafter(0.15, 1.0), 0.2)),
        Pair("a range that holds", faults(lambda ends: check_followed(CHAPTER, nose(*ends))),
             (0.1, 0.15), (0.1, nextafter(0.15, 0.0))),
    ],
    "api/orbit_question.py: first.name == 'rpm' and follows and "
    "(not first.low <= at <= first.high)": [
        Pair("where orbits are looked for", faults(asked), {"orbits.at": at},
             {"orbits.at": nextafter(at, way)}) for at, way in ((690.0, 0.0), (710.0, inf))
    ],
    "api/orbit_question.py: section.vary or varied[0].name != 'rpm' or len(varied) > 1": [
        Pair("one speed, and no other number", faults(asked), chaos_at(700.0),
             {**chaos_at(700.0), **constant(0.7, 0.9)}),
    ],
    "api/orbit_question.py: section.at is None and speeds.low < speeds.high and (not is_default) "
    "and (not holds_speed)": [
        Pair("one speed, and no other number", faults(asked), {**chaos_at(700.0), "run.rpm": 650.0},
             {**chaos_at(nextafter(700.0, inf)), "run.rpm": 650.0}),
        Pair("one speed, and no other number", faults(asked), {**chaos_at(701.0), "run.rpm": 701.0},
             {**chaos_at(701.0), "run.rpm": nextafter(701.0, inf)}),
    ],
    "api/orbit_question.py: not varied.low < varied.high": [
        Pair("two different ends", faults(asked), constant(0.8, 0.9), constant(0.8, 0.8)),
    ],
    "api/orbit_question.py: not varied.low <= value <= varied.high": [
        Pair("a range that holds restitution = 0.8", faults(asked), constant(0.8, 0.9),
             constant(nextafter(0.8, 1.0), 0.9)),
        Pair("a range that holds restitution = 0.8", faults(asked), constant(0.7, 0.8),
             constant(0.7, nextafter(0.8, 0.0))),
    ],
    "api/machine.py: section.rpm.num < 2": [
        Pair("found one speed", faults(explained), 2, 1),
    ],
    "api/orbit_question.py: section.curve is None and len(numbers) > 1": [
        Pair("one number along a branch", faults(asked), {"orbits.vary": [LOSS]},
             {"orbits.vary": [LOSS, {**AXIS, "start": 1.2}]}),
    ],
    "api/orbit_tables.py: len(different_values) == 1 < count": [
        Pair("along another parameter", lines_of, [700.0, 701.0], [700.0, 700.0]),
        Pair("along another parameter", lines_of, [700.0], [700.0, 700.0]),
    ],
    "api/result.py: 'panels' in form and len(panels) > len(given_axes)": [
        Pair("found 2 panels and 1 axes", faults(drawn), 2, 1),
    ],
    "cams/arcs.py: lobe > 360": [
        Pair("too much", SCENE, {"cam.top_dwell_deg": FREE * (1.0 - 1e-9)},
             {"cam.top_dwell_deg": FREE * (1.0 + 1e-9)}),
    ],
    "cams/files.py: len(data) > most": [Pair("more than 1 kB", bytes_of, 1000, 1001)],
    "cams/oscillator.py: not size < FARTHEST": [
        Pair("1e6 m", faults(lambda high: camcli.load_scene(
            {"follower": {"restitution": 0.5}, "cam": {**FORCED, "amplitude": high}}
        )), 1e6 * (1.0 - 1e-9), 1e6 * (1.0 + 1e-9)),
    ],
    "cli/basins.py: len(words) > 2 or not all((word.strip().isdecimal() for word in words))": [
        Pair("expected N or NQ,NV", faults(cells), "4,5", "4,5,6"),
        Pair("expected N or NQ,NV", faults(cells), "4", "4.5"),
    ],
    "cli/explore.py: not asked <= {'basins', 'map'}": [
        Pair("expected basins or map", line_of, "explore --with basins --vary follower.mass=1:2",
             "explore --with maps"),
    ],
    "cli/options.py: threads is not None and (not 1 <= threads <= MOST_THREADS)": [
        Pair("expected 1 or more", line_of, f"simulate --profile-only --threads {within}",
             f"simulate --profile-only --threads {beyond}")
        for within, beyond in ((1, 0), (4096, 4097))
    ],
    "cli/run.py: points is not None and points > 1 and (f'{section}.rpm.num' in values)": [
        Pair("and one speed", line_of, "sweep --rpm 700 --points 1", "sweep --rpm 700 --points 2"),
    ],
    "cli/run.py: len(axes) > most": [
        Pair("numbers to vary", line_of,
             "sweep --vary follower.mass=1:2 --vary follower.restitution=0.5:0.6 --points 2",
             "sweep --rpm 700:701 --vary follower.mass=1:2 --vary follower.restitution=0.5:0.6"),
        Pair("numbers to vary", line_of, "classify --vary follower.mass=1:2 --points 2",
             "classify --vary follower.mass=1:2 --vary follower.restitution=0.5:0.6"),
    ],
    "scene/load.py: len(parts) > 2": [
        Pair("the number of speeds", faults(parse_rpm), "660:760", "660:760:5"),
    ],
    "scene/load.py: not SLOWEST <= rpm_of_cam <= FASTEST": [
        Pair("in this range", faults(parse_rpm), repr(1e-9), repr(nextafter(1e-9, 0.0))),
        Pair("in this range", faults(parse_rpm), repr(1e9), repr(nextafter(1e9, inf))),
    ],
    "scene/load.py: len(ordered) > MAX_FAULTS": [
        Pair("further fault", faults(wrong), 100, 101),
    ],
    "scene/schema.py: len(set(values)) < len(values)": [
        Pair("the same name twice", SCENE, {"plot.panels": ["lift", "velocity"]},
             {"plot.panels": ["lift", "velocity", "lift"]}),
    ],
    "scene/schema.py: not low < high": [
        Pair("two different ends", SCENE, {"basins.q": [0.1, nextafter(0.1, 1.0)]},
             {"basins.q": [0.1, 0.1]}),
    ],
    "scene/schema.py: motions > MOST_MOTIONS": [
        Pair("fewer speeds or starts", SCENE, several(1000, 9999), several(1000, 10000)),
        Pair("1000 values x 10001 starts", SCENE, masses(1, 9999), masses(1, 10000)),
        Pair("fewer values or starts", SCENE, masses(10_000_000, 9999), masses(1, 10000)),
    ],
    "scene/schema.py: not 0.0 <= rate <= LARGEST or not abs(preload) <= LARGEST": [
        Pair("a spring that presses harder", faults(spring), 90.0, nextafter(90.0, 0.0)),
    ],
    "scene/schema.py: len(vary) == 2 or not low <= first < last <= high": [
        Pair("two ends within 660 to 760", SCENE, zoom(660.0, 760.0), zoom(*ends))
        for ends in ((nextafter(660.0, 0.0), 760.0), (660.0, nextafter(760.0, inf)),
                     (700.0, 700.0))
    ],
    "scene/schema.py: lash < least": [
        Pair("lost in the rounding", faults(lash), 1.02e-14, 0.98e-14),
    ],
    "words/border_collision.py: collision.growth is not None and "
    "abs(collision.growth.left) <= DECIDED": [
        Pair("too small to exclude", growth, -1.5e-3 * (1.0 + 1e-9), -1.5e-3),
    ],
    "words/detach.py: lift_off.landing < inf": [
        Pair("does not land", lambda x: lift_off(x, inf), 1.0, inf),
    ],
    "words/detach.py: lift_off.rest < inf": [
        Pair("rests again", lambda x: lift_off(1.0, x), inf, 2.0),
    ],
    "words/detach.py: len(rpms) > 1": [
        Pair("and above", lost_at, [130.0], [130.0, 140.0]),
    ],
    "words/plan.py: scene.basins.count > 1": [
        Pair("stands for all", lambda num: " ".join(plan.basins(several_basins(num))), 1, 2),
    ],
    "words/simulate.py: turn < 0": [
        Pair("before the record", lambda turn: " ".join(rounding_notes(turn)), 0, -1),
    ],
    "words/simulate.py: lobe.closing <= CLOSED * lift": [
        Pair("does not close", closing, 0.999e-13, 1.001e-13),
    ],
    "words/simulate.py: len(corners) > MANY": [
        Pair("infinite at 13 corners", lambda n: jerk_title({f"c{k}": 0.0 for k in range(n)}),
             12, 13),
    ],
    "words/simulate.py: factor >= 1.0": [
        Pair("times faster", lambda seconds: slowed(60.0, seconds), 1.0, nextafter(1.0, 0.0)),
    ],
    "words/statuses.py: len(values) > NAMED": [
        Pair(", ...", lambda n: counted([float(k) for k in range(n)], "rpm"), 5, 6),
    ],
    "words/verdict.py: lift < FOOT * (high - low)": [
        Pair("there preload presses", at_the_foot, 0.1 + 1e-9, 0.1 - 1e-9),
    ],
    "words/verdict.py: result.system.lash > 0.0": [
        Pair("the ramp alone", seated, 0.0, 1e-6),
    ],
    "words/verdict.py: width > VAGUE * velocity": [
        Pair("hardly tells", range_of_seating, 1.0, 1.01),
    ],
    "words/tolerance.py: machines < MANY": [
        Pair("about 50 %", lambda machines: share_words(0.47, machines), 1000, 999),
        Pair("47 %", lambda machines: share_words(0.47, machines), 999, 1000),
    ],
    "words/verdict.py: len(strong) > 1": [
        Pair("harmonics of the cam", surging, [7], [7, 12]),
        Pair("harmonic 7 meets the spring's 433 Hz at 3711 rpm", surging, [7, 12], [7]),
    ],
    "words/verdict.py: bounce > 0.0": [
        Pair("on its seat it bounces up to", bouncing, 0.0, 1e-9),
    ],
    "words/verdict.py: lift > NOTHING * (high - low)": [
        Pair("above its lowest", raised, 1e-3 * (HIGH - LOW) * (1.0 - 1e-9),
             1e-3 * (HIGH - LOW) * (1.0 + 1e-9)),
    ],
}  # fmt: skip
ROWS = [(name, pair) for name, pairs in PAIRS.items() for pair in pairs]


def test_every_threshold_of_a_message_has_its_two_cases():
    listed = set(conditions())
    known = {*ELSEWHERE, *PAIRS}
    assert listed - known == set(), "a new threshold: give it a case on either side"
    assert known - listed == set(), "no such threshold in the program"


@pytest.mark.parametrize("where", sorted(set(ELSEWHERE.values())))
def test_the_tests_named_are_there(where):
    file, name = where.split("::")
    assert name in (ROOT / file).read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "pair"), ROWS, ids=[name for name, _ in ROWS])
def test_on_either_side(name, pair, tmp_path, monkeypatch):
    TEMPORARY[0] = tmp_path
    monkeypatch.chdir(tmp_path)
    assert pair.words not in pair.said(pair.within), name
    assert pair.words in pair.said(pair.beyond), name


def test_what_needs_more_than_there_is_is_refused(tmp_path, monkeypatch):
    """Memory: 80 % of what the machine has; files: what is free on the disk."""
    command = command_of("sweep")
    scene = scene_of({"sweep.rpm": {"start": 690.0, "stop": 700.0, "num": 1000}})
    size = command.size(scene)
    for name, need in (("memory", size.memory / 0.8), ("free_disk", size.kept + size.tables)):
        for more, refused in ((1.0 + 1e-9, False), (1.0 - 1e-9, True)):
            monkeypatch.setattr(sizes, "memory", lambda: 1e15)
            monkeypatch.setattr(sizes, "free_disk", lambda folder: 1e15)
            monkeypatch.setattr(sizes, name, lambda *_, most=need * more: most)
            said = faults(lambda _: sizes.refuse_too_large(command, scene, tmp_path,
                                                                drawn=False))(None)  # fmt: skip
            assert bool(said) == refused


def test_much_to_write_is_noted(monkeypatch, capsys):
    for much, noted in ((200e6, False), (200e6 * (1.0 + 1e-9), True)):
        size = Made(tables=much, kept=0)
        command = Made(name="sweep", less="", size=lambda scene, size=size: size)
        run._tell_of_size(command, None)
        assert ("this writes at least 200 MB" in capsys.readouterr().err) == noted


def test_so_many_numbers_are_drawn_over_a_picture(tmp_path):
    """Of a point of a branch its value, its position and each phase; of a curve both numbers."""
    path = tmp_path / "table.csv"
    for points, phases, taken in ((8, 1, True), (9, 1, False), (6, 2, True), (7, 2, False)):
        names = [f"theta_deg_{k}" for k in range(1, phases + 1)]
        rows = [f"1,{700 + k},1,0.1" + ",100" * phases for k in range(points)]
        path.write_text("\n".join([",".join(["branch,rpm,stable,q_m", *names]), *rows]))
        said = faults(lambda file: orbit_tables.read_branches(file, "rpm", 24))(path)
        assert ("24 numbers in them" not in said) == taken
    keys = ("rpm", "follower.restitution")
    for points, taken in ((12, True), (13, False)):
        rows = [f"1,fold,{700 + k},0.8" for k in range(points)]
        path.write_text("\n".join(["curve,kind,rpm,restitution", *rows]))
        said = faults(lambda file: orbit_tables.read_curves(file, keys, 24))(path)
        assert (said == "") == taken
        assert ("24 numbers in them" not in said) == taken


def test_any_spring_pulls_a_follower_and_not_its_weight():
    assert "its weight" in weight(0.0)
    assert "its weight" not in weight(1e-9)
