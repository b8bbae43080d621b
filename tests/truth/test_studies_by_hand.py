"""What sweeps, basins and classified motions ask their studies, and make of their answers."""

from __future__ import annotations

from contextlib import contextmanager
from math import inf
from random import Random
from types import SimpleNamespace as Made

import numpy as np
import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.api import basins, classify, command, explanation, rows, sweep, tolerances
from camcli.api.command import Command, command_of
from camcli.errors import SceneError, Status
from camcli.piece_faults import PieceFault, gather, gathering
from camcli.quantities import Head, Quantity
from camcli.system import Follower


def fault(name):
    return PieceFault(name, "E", "place", "traceback")


# --- sweep


@pytest.mark.parametrize("explain", [True, False])
def test_a_sweep_asks_for_what_its_section_says(monkeypatch, explain):
    """Faults of the speeds and of what comes after them are those of the result."""
    section = Made(
        vary=(), zoom=(), also=(), branches="b.csv", direction="up", adaptive=True,
        sections=("strobe",), lyapunov=False, explain=explain, curves=None, prove=False,
    )  # fmt: skip
    machine = Made(scene=Made(sweep=section), system="system", settings="settings")
    monkeypatch.setattr(sweep, "machine_of", lambda scene: machine)
    monkeypatch.setattr(sweep, "_refuse_what_contradicts", lambda section: None)
    monkeypatch.setattr(sweep, "span_of", lambda *given: ("run.x", [1.5, 2.5], "setup"))
    monkeypatch.setattr(sweep, "read_branches", lambda path, key: (path, key))
    asked = {}
    found = Made(faults=[fault("600 rpm")])
    monkeypatch.setattr(sweep, "run", lambda *given, **more: asked.update(more) or found)
    monkeypatch.setattr(sweep, "replace", lambda result, **more: (result, more))

    def explained(*given):
        gather([fault("the changes")])
        asked["explained"] = given
        return ["motion"], "explanation"

    monkeypatch.setattr(sweep, "_explained", explained)
    monkeypatch.setattr(sweep, "_result", lambda *given: given)
    result, more = sweep.sweep("scene", "progress", work="work")
    branches = ("b.csv", "run.x")
    told = (["motion"], "explanation") if explain else ([], None)
    assert result == (machine, found, branches, *told)
    pieces = ["600 rpm", *["the changes"] * explain]
    assert [one.piece for one in more["faults"]] == pieces
    assert asked.get("explained") == ((machine, found, "progress", "work") if explain else None)
    wanted = {"key": "run.x", "setup": "setup", "direction": "up", "adaptive": True,
              "impacts": False, "strobe": True, "lyapunov": False, "work": "work",
              "also": []}  # fmt: skip
    assert {name: asked[name] for name in wanted} == wanted


@pytest.mark.parametrize("direction", ["up", "down", "both"])
def test_changes_of_a_carried_state_are_not_explained(direction):
    scene = camcli.load_scene(None, {"sweep.explain": True, "sweep.direction": direction})
    with pytest.raises(SceneError, match=f"found {direction}, expected fixed"):
        sweep._refuse_what_contradicts(scene.sweep)


def test_the_lines_of_a_map_are_those_of_its_second_number(monkeypatch):
    """The progress counts them; a section's choices go to the study, faults to the result."""
    asked, told = {}, []
    found = Made(cost=Cost(), speeds=[], faults=[fault("a line")], direction="up")

    def sweep_map(*given, **more):
        asked.update(more)
        more["on_line"]()
        return found

    for name, answer in (("Varied", None), ("has_seat", False), ("units_of", None),
                         ("map_notes", []), ("status_notes", []), ("drawn_by", None)):  # fmt: skip
        monkeypatch.setattr(sweep, name, lambda *given, answer=answer: answer)
    monkeypatch.setattr(sweep, "sweep_map", sweep_map)
    axes = [
        Made(key="run.x", start=1.0, stop=3.0, num=3),
        Made(key="run.y", start=4.0, stop=5.0, num=2),
    ]
    section = Made(direction="up", vary=axes, curves=None, lyapunov=True, decide=False)
    machine = Made(scene=Made(sweep=section, cam=Made(kind="arcs")), system=None,
                   settings=Made(record=4))  # fmt: skip
    result = sweep._mapped(machine, lambda *given: told.append(given), "work")
    assert told == [("lines", 1, 2)]
    del asked["on_line"]
    assert asked == {"direction": "up", "lyapunov": True, "decide": False, "work": "work"}
    assert [one.piece for one in result.faults] == ["a line"]


def test_the_certificate_of_a_map_is_that_of_its_cam_and_strobe(monkeypatch):
    monkeypatch.setattr(
        "camcli.analysis.orbits.certificate.certificate_of_curves", lambda *given: given[:4]
    )
    monkeypatch.setattr("camcli.cams.formula.formula_of", lambda *given: given)
    machine = Made(system=Made(shape="shape", follower=Made(seat_restitution=0.25)),
                   scene=Made(run=Made(strobe_deg=35.0)))  # fmt: skip
    atlas = Made(ranges=["range"], curves=["curve"])
    content = sweep._certificate(machine, atlas)
    assert content == (["range"], ["curve"], ("shape", 0.25), 35.0)
    atlas.ranges = None
    assert sweep._certificate(machine, atlas)[0] == ()


def test_motions_are_classified_once_at_each_speed_that_did_not_fail(monkeypatch):
    asked = {}

    def run(system, settings, rpms, threads, on_speed):
        asked.update(rpms=rpms, threads=threads)
        on_speed()
        return [Made(fault=None), Made(fault=fault("650 rpm"))]

    monkeypatch.setattr("camcli.analysis.classify.classify", run)
    monkeypatch.setattr(explanation, "explanation_of", lambda *given: given)
    speeds = [(700.0, None), (600.0, "x"), (650.0, None), (700.0, None)]
    found = Made(bare=[Made(rpm=rpm, fault=broken) for rpm, broken in speeds])
    machine = Made(system=None, settings=None)
    told = []
    with gathering() as faults:
        motions, why = sweep._explained(
            machine, found, lambda *given: told.append(given), Made(threads=3)
        )
    assert asked == {"rpms": [700.0, 650.0], "threads": 3}
    assert told == [("motions", 1, 2)]
    assert why[:2] == (machine, motions)
    assert [one.piece for one in faults] == ["650 rpm"]


@pytest.mark.parametrize("seat", [True, False])
def test_the_tables_of_a_sweep(monkeypatch, seat):
    """Sections that were asked for; ways stand behind the columns of a seat."""
    monkeypatch.setattr(sweep, "SharedRows", lambda *given: Made(table=lambda *of: of))
    monkeypatch.setattr(sweep, "speed_row", lambda speed, seat: (speed, seat))
    seen = []
    monkeypatch.setattr(sweep, "Table", Made(of_rows=lambda *given: seen.append(given) or given))
    found = Made(key="run.x", bare=["a", "b"], ways=[("up", 1), ("down", 2)],
                 way_names=["direction", "start"])  # fmt: skip
    section = Made(sections=("strobe",), tables="csv")
    tables = sweep._tables(found, section, seat)
    assert list(tables) == ["strobe", "speeds"]
    name, columns = tables["strobe"]
    assert (name, columns[0], columns[-2:]) == ("strobe", "run.x", ("direction", "start"))
    ((columns, make_rows),) = seen
    seats = sweep.seat_names(True)
    assert columns[-2:] == ("direction", "start")
    assert (columns[-2 - len(seats) : -2] == seats) is (seats[0] in columns) is seat
    assert [*make_rows()] == [("a", seat, "up", 1), ("b", seat, "down", 2)]
    section.tables = "none"
    assert list(sweep._tables(found, section, seat)) == ["speeds"]


def test_a_sample_of_a_map_keeps_curves_that_are_read(tmp_path):
    axes = [{"key": "follower.mass", "start": 1.0, "stop": 2.0, "num": 9},
            {"key": "follower.damping", "start": 1.0, "stop": 2.0, "num": 9}]  # fmt: skip
    for curves, kept in (("auto", None), ("own.csv", "own.csv"), (None, None)):
        scene = camcli.load_scene(None, {"sweep.vary": axes, "sweep.curves": curves})
        assert command_of("sweep").sample(scene, 2).sweep.curves == kept


# --- basins


def test_basins_ask_for_what_their_section_says(monkeypatch):
    """Cells of all values count; the cam drawn is that of the first value, if that has one."""
    section = Made(q=(0.1, 0.9), v=(-20.0, 40.0), cells=(4, 3), budget=77, refine=1,
                   boundary="boundary", exponents="exponents", saddles="saddles")  # fmt: skip
    machine = Made(scene=Made(basins=section), system="system", settings="settings")
    monkeypatch.setattr(basins, "machine_of", lambda scene: machine)
    setups = {"setup": lambda value: (f"system at {value}", 1, 2)}
    monkeypatch.setattr(basins, "span_of", lambda *given: ("run.x", [2.0, 3.0], setups["setup"]))
    asked, told = [], []
    lost = Status.NO_RETURN
    speeds = [Made(rpm=700.0, faults=[fault("a cell")], troubled={}),
              Made(rpm=800.0, faults=[], troubled={lost: 9}),
              Made(rpm=750.0, faults=[], troubled={})]  # fmt: skip
    found = Made(speeds=speeds, cost=Cost(3, 4), troubled=True)

    def study(*given, **more):
        more.pop("on_cells")(10)
        asked.append((given, more))
        return found

    for name, answer in (
        ("throw", lambda system, rpm: (system, rpm)), ("height_notes", lambda heights: [heights]),
        ("basins_notes", lambda study, budget: [budget]), ("_tables", lambda *given: {}),
        ("_summary", lambda study, question: {"a": 1}), ("drawn_by", lambda *given: given),
        ("study", study),
    ):  # fmt: skip
        monkeypatch.setattr(basins, name, answer)
    result = basins.basins(None, lambda *given: told.append(given), work="work")
    ((given, more),) = asked
    system, values, settings, question = given
    assert (system, values, settings) == ("system", [2.0, 3.0], "settings")
    window = question.window
    assert (window.q, window.v, window.nq, window.nv) == ((0.1, 0.9), (-20.0, 40.0), 4, 3)
    assert (question.budget, question.refine) == (77, 1)
    assert more == {"setup": setups["setup"], "boundary": "boundary", "exponents": "exponents",
                    "saddles": "saddles", "work": "work", "key": "run.x"}  # fmt: skip
    assert told == [("cells", 10, 24)]
    assert result.summary == {"a": 1, "status": lost.text}
    assert result.notes == (("system", 800.0), 77)
    assert (result.cost, result.complete) == (Cost(3, 4), False)
    assert [one.piece for one in result.faults] == ["a cell"]
    picture = ("basins.draw_basins", found, question)
    assert result.pictures["basins"] == (*picture, "system at 2.0", "run.x")

    def no_machine(value):
        raise ValueError("odd")

    setups["setup"], found.troubled = no_machine, False
    result = basins.basins(None)
    assert result.pictures["basins"][3] == "system"
    assert result.complete
    setups["setup"] = None
    assert basins.basins(None).pictures["basins"][3] == "system"


def test_more_cells_than_there_are_do_not_count(monkeypatch):
    """Cells of refined windows are done beside those that were foreseen."""
    told = []
    monkeypatch.setattr(basins, "study", lambda *given, on_cells, **more: on_cells(70) or Made(
        speeds=[], cost=Cost(), troubled=False, grids=[]))  # fmt: skip
    monkeypatch.setattr(basins, "basins_notes", lambda *given: [])
    scene = camcli.load_scene(None, {"basins.cells": [8, 8]})
    basins.basins(scene, lambda *given: told.append(given))
    assert told == [("cells", 64, 64)]


def test_growth_is_told_where_any_speed_has_it():
    def speed(value, exponents):
        attractor = Made(label="P(1;1)", states=[(0.5, 0.25)], multipliers=None)
        return Made(value=value, rpm=600.0, attractors=[attractor], branches=[1],
                    fractions={1: (0.5, 0.25)}, exponents=exponents)  # fmt: skip

    table = basins._attractors_table(Made(speeds=[speed(1.0, None), speed(2.0, [0.5])]), "run.x")
    assert table.columns[-1] == basins.GROWTH[-1]
    bare = basins._attractors_table(Made(speeds=[speed(1.0, None)]), "rpm")
    assert (bare.columns[0], bare.columns[-1]) == ("attractor", "rpm")


def test_an_attractor_that_does_not_repeat_has_no_turns():
    attractor = Made(label="aperiodic", turns=0, states=[], multipliers=None)
    found = Made(attractors=[attractor], regions=[None], branches=[7], rpm=600.0, stays=[31],
                 fractions={1: (0.25, 0.01)})  # fmt: skip
    assert basins._attractor(found, 0)["turns"] is None


def test_a_large_refined_window_comes_in_blocks_with_every_cell_once():
    """300 x 300 finest cells, of which those of the first two lines are four in one."""
    side = 300
    level = np.ones((side, side), int)
    level[:2] = 0
    codes = np.arange(side * side).reshape(side, side)
    window = basins.Window((0.0, 3.0), (10.0, 13.0), side, side)
    grid = Made(window=window, level=level, codes=codes)
    blocks = list(basins._cells(grid, 1))
    sizes = [len(q) for q, _, _ in blocks]
    assert sizes == [1 << 16, side * (side - 2) + side // 2 - (1 << 16)]
    q, v, found = (np.concatenate(column) for column in zip(*blocks, strict=True))
    whole = found < side
    assert np.array_equal(np.sort(found[~whole]), np.arange(2 * side, side * side))
    assert np.array_equal(np.sort(found[whole]), np.arange(0, side, 2))
    assert np.allclose(q[~whole], (found[~whole] % side + 0.5) / 100.0)
    assert np.allclose(v[~whole], 10.0 + (found[~whole] // side + 0.5) / 100.0)
    assert np.allclose(q[whole], (found[whole] + 1.0) / 100.0)
    assert np.allclose(v[whole], 10.01)


# --- classify


@pytest.mark.parametrize("explain", [True, False])
def test_classified_motions_are_asked_for_as_their_section_says(monkeypatch, explain):
    section = Made(explain=explain, starts=7, seed=99)
    machine = Made(scene=Made(classify=section), system="system", settings="settings")
    monkeypatch.setattr(classify, "machine_of", lambda scene: machine)
    checked = []
    monkeypatch.setattr(classify, "check_explainable", lambda *given: checked.append(given))
    monkeypatch.setattr(classify, "span_of", lambda *given: ("run.x", [1.5, 2.5], "setup"))
    asked, told = [], []
    motions = [Made(fault=None), Made(fault=fault("2.5"))]

    def run(*given):
        given[6]()
        asked.append((*given[:6], *given[7:]))
        return motions

    monkeypatch.setattr(classify, "run", run)
    monkeypatch.setattr(classify, "explanation_of", lambda *given: ("why", *given[:2]))
    monkeypatch.setattr(classify, "_summary", lambda *given: given)
    monkeypatch.setattr(classify, "_result", lambda *given: given)
    monkeypatch.setattr(classify, "replace", lambda result, **more: (result, more["faults"]))
    result, faults = classify.classify(None, lambda *of: told.append(of), work=Made(threads=3))
    assert asked == [("system", "settings", [1.5, 2.5], 7, 99, 3, "setup", "run.x")]
    assert told == [("speeds", 1, 2)]
    why = ("why", machine, motions) if explain else None
    assert result == (machine, "run.x", motions, why, (motions, why, "run.x"))
    assert [one.piece for one in faults] == ["2.5"]
    assert checked == ([(section, "classify")] if explain else [])
    classify.classify(None)
    assert asked[-1][5] is None


def test_a_sample_of_classified_motions_has_few_starts():
    sampled = command_of("classify").sample
    for starts, few in ((3, 3), (5, 5), (20, 5)):
        scene = camcli.load_scene(None, {"classify.starts": starts, "classify.explain": True})
        own = sampled(scene, 2).classify
        assert (own.starts, own.explain, own.rpm.num) == (few, False, 2)


@pytest.mark.parametrize(("count", "changes"), [(1, None), (2, 1), (3, 2)])
def test_changes_are_explained_between_motions_from_the_scene_s_own_start(
    monkeypatch, count, changes
):
    """A motion of another start, or one that failed, is left out; the budget's status is told."""
    told, asked = [], []

    @contextmanager
    def budget_of(scene, progress):
        yield Made(status=Status.WORK_BUDGET)

    def explain(system, settings, motions, on_change):
        on_change()
        asked.append(motions)
        return Made(status=Status.OK, events="events")

    monkeypatch.setattr(explanation, "budget_of", budget_of)
    monkeypatch.setattr(explanation, "replace", lambda one, **more: Made(**{**vars(one), **more}))
    monkeypatch.setattr("camcli.analysis.explain.changes.explain", explain)
    own = [Made(start="own", fault=None, n=n) for n in range(count)]
    motions = [Made(start="other", fault=None), *own, Made(start="own", fault="x")]
    machine = Made(settings=Made(start="own"), system=None, scene=None)
    found = explanation.explanation_of(machine, motions, lambda *given: told.append(given))
    if changes is None:
        assert (found.status, found.changes, asked) == (Status.OK, [], [])
        return
    assert asked == [own]
    assert told == [("changes", 1, changes)]
    assert (found.status, found.events) == (Status.WORK_BUDGET, "events")

    def broken(*given):
        raise ValueError("odd")

    monkeypatch.setattr("camcli.analysis.explain.changes.explain", broken)
    with gathering():
        assert explanation.explanation_of(machine, motions, None).status == Status.FAULT


# --- rows and columns of several commands


def test_a_speed_without_rows_has_no_block():
    """A speed of one row has one; the value comes first, the ways last."""
    impacts = [(np.array([1]), np.array([2.0])), (np.array([]), np.array([]))]
    strobe = [(np.array([]), np.array([])), (np.array([3, 4]), np.array([5.0, 6.0]))]
    sections = [(value, of) for value, *of in zip((0.5, 0.75), impacts, strobe, strict=True)]
    study = Made(ways=[("up",), ("down",)], sections=lambda names: iter(sections))
    (first, nothing), (none, second) = rows.blocks(study, ["impacts", "strobe"])
    assert nothing is none is None
    assert (first[0], first[1].tolist(), first[-1]) == (0.5, [1], "up")
    assert (second[0], second[2].tolist(), second[-1]) == (0.75, [5.0, 6.0], "down")


def test_the_form_of_a_table_has_as_wide_texts_as_its_ways():
    """Numbers of starts are whole; a table without rows has numbers in all columns."""
    ways = [("up", 0), ("down", 1), ("sideways", 2)]
    study = Made(ways=ways, way_names=["direction", "start"],
                 row_counts={"impacts": [2, 3, 0], "strobe": [0, 0, 0]})  # fmt: skip
    impacts = rows.form(study, "impacts")
    assert (impacts.rows, impacts.kinds[0]) == (5, "<f8")
    assert impacts.kinds[-2:] == ["<U4", "<i8"]
    assert impacts.kinds[1:-2] == list(rows.KINDS["impacts"])
    empty = rows.form(study, "strobe")
    assert (empty.rows, empty.kinds) == (0, ["<f8"] * 8)


def test_columns_of_a_command_are_told_by_table_and_by_when_they_are_there():
    def run():
        pass

    angle = Quantity("theta_deg", "deg", "angle", "of an impact", numbered=True)
    state = Quantity("status", "", "status", "how it ended", "ok or not")
    seat = Quantity("seat_m", "m", "seat", "height of the seat")
    heads = (Head("first", "one", (angle, state), {"with cam.lash": (seat,)}),
             Head("second", "two", (seat,)))  # fmt: skip
    own = Command(run=run, tables=heads, files=("a.png", "b.json", "c.png"))
    assert [tuple(column) for column in command.columns_of(own)] == [
        ("first", "theta_deg_1..", "deg", angle.meaning, ""),
        ("first", "status", "", state.meaning, ""),
        ("first", "seat_m", "m", seat.meaning, "with cam.lash"),
        ("second", "seat_m", "m", seat.meaning, ""),
    ]
    assert state.meaning != state.words
    assert own.artefacts == ("first.csv", "second.csv", "a.png", "b.json", "c.png")
    assert (own.pictures, own.name) == (("a", "c"), "run")


def test_a_sample_has_at_most_a_thousand_turns_of_either_kind():
    for transient, record, most, wanted in (
        (5000, 4000, None, (1000, 1000)), (5000, 4000, 7, (1000, 7)), (300, 200, None, (300, 200)),
        (300, 200, 900, (300, 200)), (300, 4000, 1500, (300, 1500)),
    ):  # fmt: skip
        scene = camcli.load_scene(None, {"run.transient": transient, "run.record": record})
        run = command.sample(scene, None, most).run
        assert (run.transient, run.record) == wanted


# --- tolerances


@pytest.mark.parametrize(
    ("stiffness", "preload", "spring"),
    [(100.0, 0.0, (220.0, 7.0)), (0.0, 5.0, (200.0, 6.3)), (100.0, 5.0, (220.0, 6.3))],
)
def test_a_number_that_the_nominal_spring_has_not_is_off_by_no_factor(
    monkeypatch, stiffness, preload, spring
):
    made = []
    monkeypatch.setattr(tolerances, "accel_errors", lambda shape: (0.5,))
    monkeypatch.setattr(tolerances, "first_loss", lambda system, errors, share: 1.0)
    monkeypatch.setattr(tolerances, "replaced", lambda *given: made.append(given))

    class Machines:
        axes = (Made(key="follower.stiffness"), Made(key="follower.preload"))
        machine = Made(system=Made(follower=Follower(1.0, stiffness, preload=preload)))

        def __call__(self, stiffness, preload):
            return (
                Made(follower=Follower(1.0, stiffness, preload=preload), shape="own"),
                600.0,
                None,
            )

    tolerances._HoldSpeeds(Machines(), [Made(stiffness=200.0, preload=7.0)])((110.0, 4.5))
    ((system, *given),) = made
    assert system.shape == "own"
    assert given == pytest.approx(spring)


def test_the_median_and_chances_are_those_of_machines_in_between():
    """Corners count for the worst case alone; a machine that failed for nothing."""
    speeds = [[100.0, 900.0], [200.0, 150.0], [300.0, 400.0], [None, None], [500.0, 250.0],
              [310.0, 300.0], [350.0, 299.0], [320.0, 600.0]]  # fmt: skip
    springs = [Made(quantity="hold_both")]
    told = tolerances._summary(speeds, 2, springs, Made(hold_to=300.0, machines=6))
    assert told == {
        "machines": 6, "worst_rpm": 100.0, "median_rpm": 320.0,
        "springs": {"hold_both": {"worst_rpm": 150.0, "chance": 0.6}},
    }  # fmt: skip
    assert tolerances._summary(speeds[:2], 2, springs, Made(hold_to=300.0, machines=6)) is None


def test_the_nth_machine_is_always_the_same():
    """Each number lies at the share of its range that the generator gives, one after the other."""
    ranges = [(1.0, 2.0), (-30.0, -10.0)]
    shares = Random(0)
    wanted = [tuple(low + (high - low) * shares.random() for low, high in ranges) for _ in range(5)]
    for count in (2, 5):
        found = tolerances._drawn_between(ranges, count)
        assert [*map(pytest.approx, found)] == wanted[:count]


@pytest.mark.parametrize(
    ("value", "found", "cure"),
    [
        (True, "found True", "e.g. follower"),
        ("stiff", "found 'stiff'", "e.g. follower"),
        (0, "found 0", "e.g. follower"),
        (0.0, "found 0.0", "e.g. follower"),
        ({"a": 1}, "found a section", "e.g. follower"),
        (None, "the scene leaves it out", "write follower.mass into the scene"),
    ],
)
def test_what_is_no_number_has_no_tolerance(monkeypatch, value, found, cure):
    monkeypatch.setattr(tolerances, "resolved", lambda scene: {"follower": {"mass": value}})
    named = []
    monkeypatch.setattr(tolerances, "Varied", lambda *given: named.append(given[1:]))
    with pytest.raises(SceneError) as caught:
        tolerances._axis(Made(scene=None), "follower.mass", 5.0)
    (fault,) = caught.value.faults
    assert (fault.where, fault.path, fault.found) == ("--tolerance", "follower.mass", found)
    assert fault.cure.startswith(cure)
    monkeypatch.setattr(tolerances, "resolved", lambda scene: {"follower": 3.0})
    with pytest.raises(SceneError):  # a key below a number names nothing
        tolerances._axis(Made(scene=None), "follower.mass", 5.0)
    (((axis,), option),) = named
    assert (axis.key, option) == ("follower.mass", "--tolerance")


def test_machines_within_their_tolerances_are_named_by_their_option(monkeypatch):
    monkeypatch.setattr(tolerances, "_axis", lambda machine, key, percent: (key, percent))
    monkeypatch.setattr(tolerances, "Varied", lambda *given: given)
    asked = [Made(key="follower.mass", percent=5.0), Made(key="cam.lift", percent=2.0)]
    machine = Made(scene=Made(detach=Made(tolerance=asked)))
    axes = [("follower.mass", 5.0), ("cam.lift", 2.0)]
    assert tolerances.tolerated(machine) == (machine, axes, "--tolerance")


def test_speeds_of_a_machine_are_kept_as_they_are():
    """As many as there are springs and one; infinite where contact is never lost."""
    codecs = []

    def collect(holds, pieces, codec, on_result):
        codecs.append(codec)
        return [[1.5, inf, 3], fault("a machine")]

    holds = Made(springs=["one", "two"])
    with gathering() as faults:
        told = tolerances._speeds_of_machines(holds, [1, 2], Made(collect=collect), None)
    assert told == [[1.5, inf, 3.0], [None, None, None]]
    assert [one.piece for one in faults] == ["a machine"]
    (codec,) = codecs
    for row in ([1.5, inf, 3.0], [-inf, 0.0, 2.0]):
        assert list(codec.load(codec.store(row))) == row
    for wrong in ([1.5], [1.5, 2.5, 3.5, 4.5], [1.5, 2.5, "x"]):
        with pytest.raises(ValueError, match=r"."):
            codec.load(wrong)
    assert codec.faults([1.5]) == []
    assert codec.faults(faults[0]) == faults
