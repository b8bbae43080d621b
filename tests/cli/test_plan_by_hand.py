"""The numbers of a plan from those of its samples, by hand, for a command that is made up."""

import json
from contextlib import contextmanager
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.api.command import Command, Drawing, Size
from camcli.cli import forecast, sizes
from camcli.cli.forecast import Cost, Plan, Sample
from camcli.errors import SceneError
from camcli.interrupts import CutOffError, raise_if_interrupted
from camcli.parallel import Shard
from camcli.scene.schema import Plot


def size_of(scene) -> Size:
    return Size(
        what="made up", pieces=scene.pieces, orbits=scene.orbits, turns=scene.turns,
        rows=scene.rows, memory=3e6, tables=0.0, kept=0.0,
    )  # fmt: skip


def scene(pieces=1, orbits=1, turns=0.0, rows=0, record=1, **plot):
    return Made(pieces=pieces, orbits=orbits, turns=turns, rows=rows, run=Made(record=record),
                plot=Plot(**plot))  # fmt: skip


def run():
    """A command's function, which is never called."""


COMMAND = Command(
    run=run, size=size_of, drawing=lambda scene: Drawing(file=2e5, memory=1e8, per_pixel=5.0),
    beside=lambda scene: 700.0, keeps_pieces=lambda scene: True,
)  # fmt: skip


def test_a_cost_grows_with_turns_records_and_rows():
    """Ten times the turns, 12 times the recorded turns, 6 times the rows."""
    part = Sample(scene(orbits=2, turns=50.0, rows=5, record=10), Cost(7.0, 0.5, 110.0, 13.0, 17.0),
                  Made())  # fmt: skip
    asked = scene(orbits=4, turns=500.0, rows=30, record=60)
    assert forecast._by_turns(COMMAND, asked, part) == Cost(70.0, 5.0, 1320.0, 78.0, 204.0)
    without_records = part._replace(cost=part.cost._replace(recorded=0.0))
    assert forecast._by_turns(COMMAND, asked, without_records).kept == 6 * 17.0
    no_rows = part._replace(scene=scene(orbits=2, turns=50.0, rows=0, record=10))
    assert forecast._by_turns(COMMAND, asked, no_rows).rows == 30 * 13.0


def written(csv: int, npz: int):
    """A table that takes so many bytes as a file of either kind."""
    return Made(write_csv=lambda file: file.write(b"c" * csv),
                npz=lambda file: file.write(b"n" * npz))  # fmt: skip


@pytest.mark.parametrize(
    ("section", "recorded", "rows"),
    [
        ({"tables": "csv"}, 1000 + 2000, 40 + 500),
        ({"tables": "none"}, 1000 + 2000, 40 + 500),
        ({"tables": "npz"}, 7 + 8, 40 + 11),  # the speeds stay a CSV
        ({}, 1000 + 2000, 40 + 500),  # a section without a choice of files
        (None, 1000 + 2000, 40 + 500),  # a command without a section
    ],
)
def test_the_cost_of_a_sample_is_that_of_its_files(section, recorded, rows):
    """The tables that grow with the record are counted alone; the summary is {"a": 1}."""
    own = {} if section is None else {"sweep": Made(**section)}
    tables = {"impacts": written(1000, 7), "strobe": written(2000, 8), "speeds": written(40, 3),
              "map": written(500, 11)}  # fmt: skip
    result = Made(scene=Made(**own), command="sweep", tables=tables, summary={"a": 1},
                  cost=Made(impacts=12), seconds=0.5)  # fmt: skip
    assert forecast._cost_of(result, 99) == Cost(12, 0.5, recorded, rows + len('{"a": 1}'), 99)
    for name in ("trajectory", "events", "basins"):
        result.tables = {name: written(1000, 7)}
        assert forecast._cost_of(result, 0).rows == len('{"a": 1}')


def test_what_comes_once_is_told_from_what_each_piece_costs():
    """Of 2 and 4 pieces: 10 + 3 n, 0.25 n, nothing that grows, and a cost that seems to fall."""
    two, four = (
        Sample(scene(pieces=n), Cost(10.0 + 3.0 * n, 0.25 * n, 5.0, 20.0 - n, 0.0), Made())
        for n in (2, 4)
    )
    found = forecast._by_pieces(COMMAND, scene(pieces=40), [two, four])
    assert found == pytest.approx(Cost(130.0, 10.0, 5.0, 16.0, 0.0))
    alone = forecast._by_pieces(COMMAND, scene(pieces=40), [four])
    assert alone == Cost(220.0, 10.0, 50.0, 160.0, 0.0)
    falling = four._replace(cost=Cost(9.0, 2.0, 5.0, 16.0, 0.0))  # below nothing at no pieces
    steep = forecast._by_pieces(
        COMMAND, scene(pieces=40), [two._replace(cost=Cost(3.0, 0.5, 5.0, 18.0, 0.0)), falling]
    )
    assert steep.impacts == 90.0


COST = Cost(impacts=101.0, seconds=5.0, recorded=1000.0, rows=500.5, kept=333.0)


def test_a_plan_is_the_sum_of_its_files():
    """110 MB are the program's; a PNG of usual size has 200 kB, run.json 5 kB."""
    asked, request = scene(orbits=7, turns=101.0), Made(no_plot=False)
    plan = forecast._plan(COMMAND, asked, request, None, COST)
    left = 1501 + 5000 + 200_000 + 700
    assert plan == (7, 101, 101, 5.0, left, left + 333, 110_000_000 + 100_000_000 + 3_000_000)
    request.no_plot = True
    plan = forecast._plan(COMMAND, asked, request, None, COST)
    assert (plan.bytes, plan.memory) == (left - 200_000, 113_000_000)
    unknown = forecast._plan(COMMAND, scene(orbits=7), request, None, None)
    assert unknown == (7, None, None, None, None, None, 113_000_000)


def test_a_shard_has_its_part():
    plan = forecast._plan(
        COMMAND, scene(orbits=7, turns=101.0), Made(no_plot=False), Shard(1, 4), COST
    )
    assert plan == (2, 26, 26, 1.25, 0, 84, 113_000_000)


def test_a_larger_picture_takes_more():
    """170 mm x 230 mm at 300 dots an inch are 2007.87 x 2716.54 = 5.454e6 dots; twice as wide..."""
    usual = sizes.drawing_of(COMMAND, scene())
    assert usual == (1e8, 2e5)
    dots = 170.0 * 230.0 * (300.0 / 25.4) ** 2
    more = sizes.drawing_of(COMMAND, scene(width=340.0, height=230.0, formats=("png", "pdf")))
    width = Plot().width
    further = dots * (340.0 - width) / 170.0
    assert more.memory == pytest.approx(1e8 + 5.0 * further)
    assert more.files == pytest.approx(2 * (2e5 + 0.01 * further))
    assert sizes.drawing_of(COMMAND, scene(width=85.0)) == usual


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("bytes", None, "not known before"),
        ("bytes", 1.234e6, "1.23 MB"),
        ("disk", 999_900_000, "1000 MB"),
        ("memory", 1_000_000_000, "1 GB"),
        ("seconds", 12.34, "12 s"),
        ("seconds", 123.4, "120 s"),
        ("orbits", 1234567, "1234570"),
        ("impacts", 123456, "123456"),
    ],
)
def test_an_estimate_has_its_unit(name, value, said):
    assert forecast._cell(name, value) == said


def test_a_page_costs_what_its_parts_do_each_with_its_own_scene(monkeypatch):
    """Parts without a sample count nothing; of the tables only the page's length is written."""
    asked = []

    def extrapolated(command, scene, request, watch):
        asked.append((command.name, scene, request, watch))
        weight = {"one": 1.0, "two": 10.0}[scene]
        return Made(
            cost=Cost(*(weight * x for x in (2.0, 3.0, 5.0, 7.0, 11.0))), result=f"of {scene}"
        )

    commands = {"sweep": Made(name="sweep", sample=True), "other": Made(name="other", sample=None)}
    parts = {"a": Made(command="sweep", scene="one"), "b": Made(command="sweep", scene="two"),
             "c": Made(command="other", scene="three")}  # fmt: skip
    monkeypatch.setattr(forecast, "_extrapolated", extrapolated)
    monkeypatch.setattr(forecast, "command_of", commands.__getitem__)
    monkeypatch.setattr("camcli.api.machine.machine_of", lambda scene: Made(scene=f"all {scene}"))
    sizes_asked = []

    def size(machine, results):
        sizes_asked.append((machine.scene, results))
        return 1234.0

    page = Made(parts=lambda scene: parts if scene == "all page" else None, size=size)
    found = forecast._of_page(page, "page", "request", "watch")
    assert asked == [("sweep", "one", "request", "watch"), ("sweep", "two", "request", "watch")]
    assert sizes_asked == [("all page", {"a": "of one", "b": "of two"})]
    assert found == Cost(impacts=22.0, seconds=33.0, recorded=0.0, rows=1234.0, kept=0.0)


@pytest.mark.parametrize(
    ("shard", "disk", "memory", "drawn", "wanted"),
    [
        (None, 1000.0, 1e9, True, []),  # 700 of pieces and 300 of tables just fit
        (None, 999.0, 1e9, True, ["files"]),
        (Shard(1, 7), 100.0, 1e9, True, []),  # its part of the pieces, and no tables
        (Shard(1, 7), 99.0, 1e9, True, ["files"]),
        (None, 1000.0, 1e8, True, ["memory to draw"]),
        (None, 1000.0, 1e8, False, []),
        (Shard(1, 7), 1000.0, 1e8, True, []),
        (None, 10.0, 1e6, True, ["memory", "memory to draw", "files"]),
    ],
)
def test_a_run_that_can_never_fit_is_refused(
    monkeypatch, tmp_path, shard, disk, memory, drawn, wanted
):
    """4/5 of the memory, for 1 MB of results and 90 MB of a picture; all of the disk."""
    monkeypatch.setattr(sizes, "free_disk", lambda folder: disk)
    monkeypatch.setattr(sizes, "memory", lambda: memory)
    size = Size(what="made up", pieces=1, orbits=1, turns=0.0, rows=0, memory=1e6, tables=300.0,
                kept=700.0)  # fmt: skip
    drawing = Drawing(file=1.0, memory=9e7, per_pixel=5.0)
    command = Command(run=run, size=lambda scene: size, drawing=lambda scene: drawing)
    try:
        sizes.refuse_too_large(command, scene(), tmp_path, drawn=drawn, shard=shard)
    except SceneError as refused:
        told = [fault.found.rpartition(" of ")[2] for fault in refused.faults]
    else:
        told = []
    assert told == wanted


PLANNED = Plan(orbits=7, periods=None, impacts=12, seconds=0.5, bytes=1_230_000, disk=1_230_000,
               memory=2_000_000_000)  # fmt: skip


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("shard", [None, Shard(2, 5)])
@pytest.mark.parametrize(
    ("cut", "explain", "budget", "told"),
    [
        (False, False, True, []),
        (True, False, False, ["cut"]),
        (True, False, True, ["cut", "budget"]),
        (False, True, False, ["budget"]),
    ],
)
def test_what_is_told_of_a_plan(monkeypatch, capsys, as_json, shard, cut, explain, budget, told):
    """Where the budget may end the run that is told; its unit takes 2e-7 s."""
    monkeypatch.setattr(forecast, "_plan", lambda *given: planned.append(given[3:]) or PLANNED)
    checked, planned, tables = [], [], []

    def cost_of_all(command, scene, request):
        if cut:
            raise CutOffError
        return "cost"

    monkeypatch.setattr(forecast, "_cost_of_all", cost_of_all)
    monkeypatch.setattr(forecast, "table", lambda *given: tables.append(given))
    command = Made(name="sweep", check=checked.append, not_foreseen=lambda scene: ["not foreseen"],
                   has_budget=budget)  # fmt: skip
    scene = Made(sweep=Made(explain=explain), run=Made(work_budget=10**8))
    forecast.forecast(command, scene, Made(json=as_json), shard)
    assert (checked, planned) == ([scene], [(shard, None if cut else "cost")])
    words = {
        "cut": "a small part took 10 s: how long it takes is not known before the run",
        "budget": "run.work_budget = 100000000 ends it after some 20 s",
    }
    notes = ["shard 2 of 5: pieces only, no tables"] * (shard is not None)
    notes += ["not foreseen", *(words[name] for name in told)]
    said = capsys.readouterr().out
    if as_json:
        assert json.loads(said) == {
            "command": "sweep", "plan": {**PLANNED._asdict(), "notes": notes}
        }  # fmt: skip
        assert tables == []
    else:
        assert said.splitlines() == notes
        cells = ["7", "not known before", "12", "0.5 s", "1.23 MB", "1.23 MB", "2 GB"]
        rows = [[name, cell] for name, cell in zip(Plan._fields, cells, strict=True)]
        assert tables == [("cam sweep, planned", ["what", "estimate"], rows)]


def test_a_run_without_orbits_costs_its_files_alone(monkeypatch):
    size = Made(orbits=0, tables=123.0)
    command = Made(size=lambda scene: size, sample=None)
    assert forecast._cost_of_all(command, None, None) == Cost(0.0, 0.0, 0.0, 123.0, 0.0)
    size.orbits = 1
    assert forecast._cost_of_all(command, None, None) is None
    command.sample = True
    seconds = [9.0]

    @contextmanager
    def watch():
        yield Made(passed=lambda: seconds[0])

    def sampled(command, scene, request, of_all):
        raise_if_interrupted()
        return (scene, request, of_all.passed())

    monkeypatch.setattr(forecast, "stopwatch", watch)
    monkeypatch.setattr(forecast, "_sampled", sampled)
    assert forecast._cost_of_all(command, "scene", "request") == ("scene", "request", 9.0)
    seconds[0] = 10.5
    with pytest.raises(CutOffError):
        forecast._cost_of_all(command, "scene", "request")


@pytest.mark.parametrize(
    ("times", "rows", "wanted"),
    [
        (3, 0, Cost(6.0, 9.0, 0.0, 21.0, 33.0)),  # a summary of each run, and no table
        (3, 5, Cost(6.0, 9.0, 15.0, 21.0, 33.0)),
        (1, 0, Cost(2.0, 3.0, 5.0, 7.0, 11.0)),
    ],
)
def test_a_command_that_repeats_another_costs_as_often(monkeypatch, times, rows, wanted):
    asked = []

    def extrapolated(command, scene, request, watch):
        asked.append(scene)
        return Made(cost=Cost(2.0, 3.0, 5.0, 7.0, 11.0))

    monkeypatch.setattr(forecast, "_extrapolated", extrapolated)
    command = Made(page=None, repeated=lambda scene: Made(scene=f"one {scene}", times=times),
                   size=lambda scene: Made(rows=rows))  # fmt: skip
    assert forecast._sampled(command, "of all", None, None) == wanted
    assert asked == ["one of all"]
    monkeypatch.setattr(forecast, "_of_page", lambda page, *given: (page, *given))
    command.page = "page"
    assert forecast._sampled(command, "s", "r", "w") == ("page", "s", "r", "w")


@pytest.mark.parametrize(
    ("turns", "pieces", "each", "wanted"),
    [
        (50.0, 1000, 0.1, [8, 16]),  # 2.4 s together
        (50.0, 1000, 0.01, [8, 16, 32]),  # no larger ones
        (50.0, 16, 0.01, [8, 16]),  # all of them
        (50.0, 1000, 0.2, [8]),
        (0.0, 1000, 0.3, [2, 4]),  # two are compared, though one took 0.6 s, and both 1.8 s
        (0.0, 1000, 0.6, [2, 4]),
        (0.0, 1000, 0.1, [2, 4, 8]),
        (0.0, 2, 0.1, [2]),
        (0.0, 6, 0.01, [2, 4, 6]),
    ],
)
def test_samples_grow_until_they_have_taken_a_second(monkeypatch, turns, pieces, each, wanted):
    clock = [0.0]
    for_work = []

    @contextmanager
    def watch():
        begun = clock[0]
        yield Made(passed=lambda: clock[0] - begun)

    def run(small, tick):
        clock[0] += each * small.pieces
        tick(1, 2, 3)
        return f"of {small.pieces}"

    def in_pieces(work):
        assert work.threads == 3
        work.checkpoint.put("0", 1, np.zeros(4))
        return run

    monkeypatch.setattr(forecast, "stopwatch", watch)
    monkeypatch.setattr(forecast, "for_work", for_work.append)
    monkeypatch.setattr(forecast, "_cost_of", lambda *given: given)
    command = Made(
        sample=lambda scene, count: Made(pieces=min(count, scene.pieces), turns=turns),
        size=lambda one: one,
        in_pieces=in_pieces,
    )
    whole, request = Made(pieces=pieces, turns=turns), Made(threads=3)
    of_all = Made(passed=lambda: clock[0] + 3.0)
    found = forecast._samples(command, whole, request, of_all)
    assert [(one.scene.pieces, one.result) for one in found] == [(k, f"of {k}") for k in wanted]
    assert all(result == one.result and kept > 32 for one in found for result, kept in [one.cost])
    assert for_work == [turns or 10_001]
    clock[0] = 9.9
    with pytest.raises(CutOffError):
        forecast._samples(command, whole, request, Made(passed=lambda: clock[0] + 0.1))


@pytest.mark.parametrize("turns", [0.0, 7.0])
def test_a_cost_is_foreseen_by_turns_where_they_are_known(monkeypatch, turns):
    samples = [Made(result="small"), Made(result="large")]
    monkeypatch.setattr(forecast, "_samples", lambda *given: samples)
    monkeypatch.setattr(forecast, "_by_turns", lambda command, scene, one: ("turns", one.result))
    monkeypatch.setattr(forecast, "_by_pieces", lambda command, scene, all_: ("pieces", len(all_)))
    command = Made(size=lambda scene: Made(turns=turns))
    cost, result = forecast._extrapolated(command, None, None, None)
    assert cost == (("turns", "large") if turns else ("pieces", 2))
    assert result == "large"


def test_pieces_of_a_sample_are_weighed_and_not_kept():
    weighed = forecast._Weighed()
    weighed.put("0", 1, {"a": np.zeros(4), "b": 1})
    of_text = weighed.bytes - 32
    weighed.put("1", 0, {"a": np.zeros(6), "b": 1})
    assert weighed.bytes == 32 + of_text + 48 + of_text
    assert of_text >= len('{"a":[],"b":1}')
    assert (("0", 1) in weighed, weighed.expected_size(9, 99)) == (False, 0.0)
    assert len(weighed.rows(8)) == 0
