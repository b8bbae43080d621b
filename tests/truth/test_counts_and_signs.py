"""One thing is not said as many, nothing is printed as -0, and pages have minus signs.

Whoever counts something in a sentence writes it with `plural`: the last test reads the source.
"""

from __future__ import annotations

import ast
import re
from math import copysign
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli import errors
from camcli.cams.compile import lift_range
from camcli.output import notebook
from camcli.output.tables import Table
from camcli.words import all_orbits, basins, bench, classify, cost, plan, simulate, sweep
from camcli.words.detach_tables import answers, lists_of_forces, lists_of_motions
from camcli.words.in_print import with_minus_signs
from camcli.words.machine import machine

PACKAGE = Path(camcli.__file__).parent


def test_a_count_and_its_verb():
    said = [errors.plural(count, "speed") for count in (0, 1, 2)]
    assert said == ["0 speeds", "1 speed", "2 speeds"]
    assert [errors.plural(count, "box") for count in (1, 3)] == ["1 box", "3 boxes"]
    assert [errors.is_or_are(count) for count in (0, 1, 2)] == ["are", "is", "are"]


def undecided_cells(count: int) -> str:
    speed = Made(computed=9, rests=[], undecided=count, cells=count, troubled={})
    return basins.basins_notes(Made(speeds=[speed]), budget=count)[0]


def cost_of(count: int) -> str:
    costs = {"seconds": 2.0, "impacts": count, "impacts_per_s": 3.0, "pieces_from_disk": count,
             "gap_evaluations": count * count}  # fmt: skip
    errors_of_run = {"contact_gap_m": 1e-16, "accumulation_phase_turns": 1e-9}
    return cost.cost_line(costs, errors_of_run)


def aperiodic(count: int) -> str:
    motion = Made(label="aperiodic", watched=count, chatters=0, value=1.0)
    return " ".join(classify._unsolved_notes([motion], "rpm"))


def rests_seldom(count: int) -> str:
    motion = Made(label="undecided", watched=None, chatters=1, value=1.0,
                  record=Made(periods=count))  # fmt: skip
    return " ".join(classify._unsolved_notes([motion], "rpm"))


def followed(count: int, **more: object) -> str:
    ends = Made(watched=count, **{"orbit": None, "chatters": 0, **more})
    (note,) = simulate.end_notes(Made(ends=ends, label="P(1;1)"))
    return note


def transient(count: int) -> str:
    start = Made(q=None, v=None)
    own = Made(direction="fixed", speeds=[1], key="rpm", also=[])
    return sweep.start_words(own, Made(start=start, transient=count))


def cover(count: int) -> str:
    return all_orbits.cover_words(Made(impacts=count, turns=count, boxes=count))


def proved_all(count: int) -> str:
    found = Made(failure=None, impacts=1, turns=1, covers=[Made(boxes=count)])
    result = Made(question=Made(rpm=700.0), proofs=Made(orbits=[]), orbits=[])
    return " ".join(all_orbits.all_sentences(result, found))


def machines(count: int) -> str:
    (said,) = plan.detach(Made(detach=Made(tolerance=[1], machines=count)))
    return said


def table_of(count: int) -> Table:
    return Table.of_rows(["x"], lambda: [(0.5,)] * count)


SENTENCES = {  # how each ends or what it holds with one, and with two
    undecided_cells: ("1 of 1 cell is undecided: it met no attractor within 1 turn; raise",
                      "2 of 2 cells are undecided: they met no attractor within 2 turns; raise"),
    cost_of: ("1 impact, 1 piece from disk, this run took 2 s (1 gap evaluation each)",
              "2 impacts, 2 pieces from disk, this run took 2 s (2 gap evaluations each)"),
    aperiodic: ("followed for 1 turn or more, and neither settled nor rested: what would end it is "
                "rarer than once in 1 turn (95 %)", "followed for 2 turns or more, and"),
    rests_seldom: ("complete chatter in 1 of 1 turn, one", "complete chatter in 1 of 2 turns, one"),
    followed: ("no period; it was followed for 1 turn", "no period; it was followed for 2 turns"),
    transient: ("on the cam, 1 turn of transient", "on the cam, 2 turns of transient"),
    cover: ("1 impact in 1 turn: 1 box", "2 impacts in 2 turns: 2 boxes"),
    proved_all: ("(1 box holds no other)", "(2 boxes hold no other)"),
    machines: ("1 machine of --tolerance comes on top", "2 machines of --tolerance come on top"),
    lambda n: bench.cases_title(n, 0): ("1 extreme case,", "2 extreme cases,"),
    lambda n: plan.turns_of_a_motion(n, n): ("1 recorded turn x 1 sample",
                                             "2 recorded turns x 2 samples"),
    lambda n: plan.speeds_of_a_sweep(n, n, 1): ("1 speed of 1 turn, 1 recorded",
                                                "2 speeds of 2 turns, 1 recorded"),
    lambda n: plan.motions_at_speeds(n, n, n): ("1 speed x 1 start x 1 recorded turn",
                                                "2 speeds x 2 starts x 2 recorded turns"),
    lambda n: plan.cells_of_a_window(3, 3, n): ("3 x 3 cells, refined 1 time",
                                                "3 x 3 cells, refined 2 times"),
    lambda n: plan.parts_of_a_page(n, n, n): ("1 speed of 3 sweeps, 1 cell, 1 point of a map",
                                              "2 speeds of 3 sweeps, 2 cells, 2 points of a map"),
    lambda n: basins.saddle_words("P(1;1)", 0, n): ("0 of 1 motion led", "0 of 2 motions led"),
    basins.further_words: ("1 further attractor, in", "2 further attractors, in"),
    lambda n: notebook.table_html(table_of(n), "c"): (": 1 row<", ": 2 rows<"),
}  # fmt: skip


@pytest.mark.parametrize(("say", "of_one", "of_two"), [(k, *v) for k, v in SENTENCES.items()])
def test_one_thing_is_not_said_as_many(say, of_one, of_two):
    assert of_one in say(1)
    assert of_two in say(2)


def test_a_detachment_leaves_with_zero_and_not_with_minus_zero(cam):
    """Of the chapter's cam, whose slope has no jump: u is zero before and after."""
    done = cam("simulate --rpm 190 --set run.transient=9 --set run.record=1 --no-plot -o out")
    assert not re.search(r"-0\s", done.stdout)
    scene = camcli.load_scene(None, {"run.rpm": 190.0, "run.transient": 9, "run.record": 1})
    events = camcli.simulate(scene).tables["events"]
    rates = [
        u for kind, u in zip(events["event"], events["u_plus_m_per_s"], strict=True)
        if kind == "detachment"
    ]  # fmt: skip
    assert len(rates) == 1
    assert all(u == 0.0 and copysign(1.0, u) == 1.0 for u in rates)


@pytest.mark.parametrize(
    ("screen", "page"),
    [("-24.5 N", "−24.5 N"), ("-.5 to -3", "−.5 to −3"), ("1e-07", "1e−07"), ("-", "-"),
     ("modified-sine", "modified-sine"), ("3-4-5 law", "3-4-5 law"), ("P(1;1)-2", "P(1;1)-2"),
     ("lift-2.csv", "lift-2.csv")],
)  # fmt: skip
def test_minus_signs_of_a_page(screen, page):
    assert with_minus_signs(screen) == page


def test_lists_of_a_page_are_the_tables_of_the_screen_with_minus_signs():
    values = {"detach.rpm": {"start": 118.0, "stop": 130.0, "num": 2}, "detach.hold_to": 150.0,
              "follower.preload": -30.0}  # fmt: skip
    result = camcli.detach(camcli.load_scene(None, values))
    on_screen = [[cell for row in table.rows for cell in row] for table in answers(result)]
    lists = [*lists_of_motions(result, 99), *lists_of_forces(result)]
    on_page = [[cell for row in rows[2:] for cell in row] for rows in lists]
    assert sorted(on_page) == sorted([cell.replace("-", "−") for cell in own] for own in on_screen)
    said = " ".join(cell for own in on_page for cell in own)
    assert "−" in said
    forces = {name: value for name, value in machine(result) if name.startswith("force at")}
    low, high = lift_range(result.system.cam)
    assert forces["force at lowest lift"].startswith("−") == (-30.0 + 1430.8 * low < 0.0)
    assert forces["force at full lift"] == f"{-30.0 + 1430.8 * high:.4g} N"


NOUNS = (
    "attractor|bounce|box|boxe|byte|case|cell|contact|crossing|evaluation|event|figure|graze|hop|"
    "impact|line|machine|motion|number|orbit|panel|part|period|piece|point|problem|root|row|run|"
    "sample|speed|start|statement|step|title|turn|value|worker"
)
COUNTED = re.compile(rf" (?:[a-z]+ )?(?:{NOUNS})s\b")
NEVER_ONE = {  # values before such a word that are no count, or a count that is above one
    "analysis/bench/precision.py": {"value"},  # steps in a turn
    "analysis/bench/stability.py": {"compared", "4 * len(plain)", "record.periods", "len(speeds)",
                                    "steps"},  # of cases that the program chooses
    "api/explore_motions.py": {"samples", "span.num"},  # more than a page holds
    "api/orbit_question.py": {"at"},
    "api/orbit_tables.py": {"MOST_LINES", "most_numbers"},
    "api/result.py": {"len(panels)"},  # more than there are axes
    "cams/lift_guess.py": {"LEAST_RUN", "count"},
    "cams/lift_reading.py": {"count", "lines"},  # too many of them; one has its own words
    "check.py": {"speed", "len(statement.boxes)"},
    "cli/merge.py": {"total"},  # of which some are not there
    "cli/run.py": {"len(axes)", "in_words(size.kept)"},
    "output/digest.py": {"name"},  # of numbers in a reference
    "parallel/stored.py": {"len(known)"},
    "scene/document.py": {"MAX_VALUES"},
    "scene/schema.py": {"motions"},  # more than are held at once
    "words/chaos.py": {"len(chaos.boxes)", "len(chaos.coverings)", "count"},  # a chain of them
    "words/cost.py": {"written_out(per_impact, 2)"},
    "words/detach_tables.py": {"len(rows)"},  # more than are shown
    "words/explanations.py": {"crisis.turns"},
    "words/explore.py": {"self.follower"},
    "words/labels.py": {"turns"},  # one has its own words
}  # fmt: skip


def test_what_is_counted_is_written_by_plural():
    """`{count} turns` reads `1 turns` for one; sizes such as `3 x 1 cells` are left alone."""
    wrong = []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = str(path.relative_to(PACKAGE))
        text = path.read_text(encoding="utf-8")
        if not re.search("}" + COUNTED.pattern, text):
            continue
        for string in ast.walk(ast.parse(text)):
            if not isinstance(string, ast.JoinedStr):
                continue
            for before, value, behind in zip(["", *string.values], string.values,
                                             string.values[1:], strict=False):  # fmt: skip
                if not isinstance(value, ast.FormattedValue) or value.format_spec is not None:
                    continue
                text_before = getattr(before, "value", "")
                text_behind = getattr(behind, "value", "")
                if not isinstance(text_behind, str) or not COUNTED.match(text_behind):
                    continue
                if isinstance(text_before, str) and re.search(r"[×x] $|\b1 to $", text_before):
                    continue
                counted = ast.unparse(value.value)
                if counted not in NEVER_ONE.get(name, ()):
                    wrong.append(f"{name}:{string.lineno}: {counted}{text_behind}")
    assert not wrong
