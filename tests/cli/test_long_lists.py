"""Where lists and names become too long for a line: one that just fits, and one more."""

from __future__ import annotations

from math import radians
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.border_collision import Inequality, Rule
from camcli.cli.bench import _shortened, _text
from camcli.cli.figures import _print_drifts
from camcli.cli.merge import _refuse_missing
from camcli.cli.orbits import _phases, _show_branches, _show_curve
from camcli.cli.report import pair
from camcli.cli.run import _tell_of_pieces, fault_lines
from camcli.errors import SceneError, shown
from camcli.output import digest
from camcli.output.digest import Drift
from camcli.piece_faults import PieceFault
from camcli.plots.picture import _cut_to, _in_pairs
from camcli.words.basins import share_words
from camcli.words.bench import in_seconds
from camcli.words.detach_tables import _cell
from camcli.words.in_print import label_text
from camcli.words.orbits import (
    _rests_on,
    branch_line,
    more_than_a_table_tells,
    stable_cell,
    turns_cell,
)
from camcli.words.proofs import FAILED, _on_points_of_branches
from camcli.words.speeds import range_words, speed_text


def orbit(count):
    return SimpleNamespace(theta=[radians(10.0 * k) for k in range(1, count + 1)])


def fault(count):
    pieces = [f"rpm = {k}" for k in range(1, count + 1)]
    return [{"pieces": pieces, "error": "KeyError: 'x'", "place": "camcli/a.py:1, f"}]


def branch(ranges, turns):
    """A branch that is stable over so many ranges, and turns round at so many values."""
    stable = [(100.0 * k, 100.0 * k + 10.25) for k in range(1, ranges + 1)]
    values = [700.5 + k for k in range(turns)]
    return SimpleNamespace(number=3, stable_ranges=lambda _: stable, turning_points=values)


def collision(count):
    """A corner impact whose class was found by so many inequalities."""
    found = [Inequality(Rule.BEYOND_ONE, "", 0.1 * k, 1.0) for k in range(count)]
    return SimpleNamespace(
        corner_impact=SimpleNamespace(collision=SimpleNamespace(inequalities=found))
    )


def unproved(count):
    """What is said of a branch with so many points that are not proved."""
    points = [SimpleNamespace(value=10.0 * k) for k in range(1, count + 1)]
    result = SimpleNamespace(
        question=SimpleNamespace(parameter="rpm"),
        branches=[SimpleNamespace(number=1, points=points)],
    )
    proof = SimpleNamespace(proved=False, step=next(iter(FAILED)))
    return [*_on_points_of_branches(result, SimpleNamespace(points=[[proof] * count]))]


def missing(total):
    """The parts of a run that are named where only the first of so many is there."""
    with pytest.raises(SceneError) as refused:
        _refuse_missing({total: {1}})
    return str(refused.value).partition("not there: ")[2].partition(", expected")[0]


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        (lambda: _phases(orbit(6)), "10, 20, 30, 40, 50, 60"),
        (lambda: _phases(orbit(8)), "10, 20, 30, 40, 50, 60 and 2 more"),
        (lambda: fault_lines(fault(5), None)[0],
         "fault: rpm = 1, rpm = 2, rpm = 3, rpm = 4, rpm = 5: KeyError: 'x' (camcli/a.py:1, f)"),
        (lambda: fault_lines(fault(7), None)[0],
         "fault: rpm = 1, rpm = 2, rpm = 3, rpm = 4, rpm = 5 and 2 more: KeyError: 'x' "
         "(camcli/a.py:1, f)"),
        (lambda: fault_lines([], None), []),
        (lambda: fault_lines([{"pieces": ["p" * 201], "error": "e" * 201, "place": ""}], None)[0],
         f"fault: {'p' * 197}...: {'e' * 197}..."),
        (lambda: fault_lines([{"pieces": ["p" * 200], "error": "e" * 200, "place": ""}], None)[0],
         f"fault: {'p' * 200}: {'e' * 200}"),
        (lambda: [shown("x" * 60), shown("x" * 61)], ["x" * 60, "x" * 57 + "..."]),
        (lambda: [label_text(f"P(1;{'1' * n})") for n in (27, 28)],
         [f"P(1;{'1' * 27})", f"P(1;{'1' * 26}…)"]),
        (lambda: label_text(f"P(1;{'1' * 25}:111)"), f"P(1;{'1' * 25}…)"),
        (lambda: _rests_on(collision(3)).count(" fails ("), 2),
        (lambda: [f"({0.1 * k:g})" in _rests_on(collision(3)) for k in range(3)],
         [True, True, False]),
        (lambda: [line.partition("rpm = ")[2].partition(":")[0] for n in (3, 4)
                  for line in unproved(n)[1:]],
         ["10, 20, 30", "10, 20, 30, ..."]),
        (lambda: [missing(11), missing(12)],
         ["2, 3, 4, 5, 6, 7, 8, 9, 10, 11", "2, 3, 4, 5, 6, 7, 8, 9, 10, 11, ..."]),
        (lambda: [len(dict(digest._counts("x", np.arange(n)))) for n in (23, 24, 25, 40)],
         [23, 24, 25, 25]),
        (lambda: dict(digest._counts("x", np.arange(25)))["x different"], 25),
        (lambda: _shortened("0.12345678901234567890"[:20]), "0.123456789012345678"),
        (lambda: _shortened("0.12345678901234567890"[:21]), "0.1234567890123456.."),
        (lambda: [_text(x) for x in (None, float("nan"), 0.00123456, 12, "1/16 tol 1e-9")],
         ["-", "-", "0.0012", "12", "1/16 1e-9"]),
        (lambda: pair([0.25 + 0.5j, 0.25 - 0.5j], 3), "0.25 +- 0.5 i"),
        (lambda: pair([1.0 / 3.0, -2.0], 3), "0.333, -2"),
        (lambda: share_words(2, "P(1;1)", 0.12345), "2: P(1;1) 12.3 %"),
        (lambda: share_words(1, "P(9;" + 26 * "1", 1.0), f"1: P(9;{26 * '1'} 100 %"),
        (lambda: share_words(1, "P(9;" + 27 * "1", 1.0), f"1: P(9;{23 * '1'}... 100 %"),
        (lambda: branch_line(branch(0, 0), ()), "branch 3 is nowhere stable"),
        (lambda: branch_line(branch(1, 1), ()),
         "branch 3 is stable from 100 to 110.25; it turns round at 700.5"),
        (lambda: branch_line(branch(5, 5), ()),
         "branch 3 is stable from 100 to 110.25, 200 to 210.25, 300 to 310.25, 400 to 410.25, "
         "500 to 510.25; it turns round at 700.5, 701.5, 702.5, 703.5, 704.5"),
        (lambda: branch_line(branch(7, 8), ()),
         "branch 3 is stable from 100 to 110.25, 200 to 210.25, 300 to 310.25, 400 to 410.25, "
         "500 to 510.25, in 2 further ranges (run.json); it turns round at 700.5, 701.5, 702.5, "
         "703.5, 704.5, 3 further values (run.json)"),
        (lambda: stable_cell(branch(0, 0), ()), "nowhere"),
        (lambda: stable_cell(branch(2, 0), ()), "100 to 110.25, 200 to 210.25"),
        (lambda: stable_cell(branch(3, 0), ()), "100 to 110.25, 200 to 210.25, ..."),
        (lambda: turns_cell(branch(0, 2)), "700.5, 701.5"),
        (lambda: turns_cell(branch(0, 3)), "700.5, 701.5, ..."),
        (lambda: [more_than_a_table_tells(branch(*n), ()) for n in ((2, 2), (3, 0), (0, 3))],
         [False, True, True]),
        (lambda: _cell(None), ""),
        (lambda: _cell(12.3456), "12.3"),
        (lambda: _cell(0.0123456, 1e3, 5), "12.346"),
        (lambda: _cell(1.23456789, 1.0, 9), "1.234568"),
        (lambda: speed_text(739.31978021600165, 2e-12), "739.319780216"),
        (lambda: speed_text(739.31978021600165, 2e-4), "739.3198"),
        (lambda: speed_text(739.31978021600165, 30.0), "739"),
        (lambda: speed_text(739.25, 0.0), "739.25"),
        (lambda: range_words(float("inf"), float("inf")), "never"),
        (lambda: range_words(4000.4, float("inf")), "from 4000 rpm on, or never"),
        (lambda: range_words(739.25, 739.25), "739.25 rpm"),
    ],
)  # fmt: skip
def test_what_is_long_is_cut_where_it_no_longer_fits(found, wanted):
    assert found() == wanted


@pytest.mark.parametrize("count", [12, 14])
def test_the_first_twelve_drifts_of_each_figure_are_told(count):
    """Two figures, each with its own lines, and a verdict at the end."""
    drifted = [Drift(name, "solved", f"x{k}", 1.0, 2.0, 1.0)
               for name in ("one", "two") for k in range(count)]  # fmt: skip
    lines = []
    _print_drifts(drifted, lines.append)
    assert len(lines) == 2 * (12 + (count > 12)) + 1
    assert [line for line in lines if "more (--json" in line] == [
        f"{name}: and {count - 12} more (--json has all of them)"
        for name in ("one", "two") if count > 12
    ]  # fmt: skip


ROWS = [["", "event"], ["1", "a"], ["2", "bbb"], ["3", "cc"]]


def test_a_list_of_a_picture_is_cut_or_set_in_pairs():
    """The last row that fits says how many are left out; the longer words stand at the left."""
    assert _cut_to(ROWS, 4) == ROWS
    assert _cut_to(ROWS, 3) == [["", "event"], ["1", "a"], ["", "and 2 more, in the tables"]]
    named = [["", "event"], ["1", "P(40;2:1)"], ["2", "P(20;2:1)"], ["3", "P(1;1)"], ["4", "fold"]]
    assert _cut_to(named, 4) == [*named[:1], *named[3:], ["", "and 2 more, in the tables"]]
    assert _in_pairs(ROWS)[1:] == [["2", "bbb", "1", "a"], ["3", "cc", "", ""]]
    assert _in_pairs([["", "a", "b"], ["1", "x", "y"]]) == [["", "a", "b"], ["1", "x", "y"]]


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(1.0, "1 s"), (0.999, "1000 ms"), (0.25, "250 ms"), (1e-3, "1 ms"), (9.94e-4, "990 µs"),
     (83.4, "83 s"), (123.0, "120 s")],
)  # fmt: skip
def test_a_time_in_the_unit_that_suits_it(seconds, told):
    assert in_seconds(seconds) == told


def rows_of(printed):
    """The rows of a printed table by words, without its title, head and line."""
    lines = [line.split() for line in printed.splitlines() if line.strip()]
    return [words for words in lines if words[0].replace(".", "").isdigit()]


@pytest.mark.parametrize(
    ("count", "told"), [(11, 11), (12, 12), (23, 23), (24, 12), (35, 18), (36, 12)]
)
def test_about_twelve_points_of_a_curve_are_shown(capsys, count, told):
    """From its first one on, evenly."""
    points = [SimpleNamespace(first=700.0 + k, second=0.5, orbit=orbit(1)) for k in range(count)]
    _show_curve(SimpleNamespace(points=points, first="rpm", second="restitution"), "Fold")
    found = [float(words[0]) for words in rows_of(capsys.readouterr().out)]
    assert len(found) == told
    assert found == [700.0 + k for k in range(0, count, max(1, count // 12))]


def test_a_branch_names_three_of_its_labels(capsys):
    own = branch(0, 0)
    own.points = [SimpleNamespace(value=700.0), SimpleNamespace(value=745.5)]
    own.labels, own.ends = ["P(1;1)", "P(1;2)", "P(1;3)", "P(1;4)"], ("one", "two")
    question = SimpleNamespace(parameter="rpm")
    _show_branches(SimpleNamespace(branches=[own], bifurcations=[], question=question), True)
    (row,) = rows_of(capsys.readouterr().out)
    assert " ".join(row) == "3 P(1;1), P(1;2), P(1;3) 700 745.5 nowhere - one | two 2"


@pytest.mark.parametrize("count", [0, 3, 4])
def test_three_files_of_unfinished_work_are_named(capsys, tmp_path, count):
    """Those of other scenes, with what they take together; not the run's own."""
    names = [f".sweep-{k}.pieces" for k in range(count)]
    for name in (*names, ".sweep-own.pieces"):
        (tmp_path / name).write_bytes(b"x" * 500_000)
    own = SimpleNamespace(path=tmp_path / ".sweep-own.pieces", torn=0, damaged=0)
    folder = SimpleNamespace(folder=tmp_path, work=SimpleNamespace(checkpoint=own), resumed=0)
    _tell_of_pieces(folder, merging=False)
    said = capsys.readouterr().err
    assert sum(name in said for name in names) == min(count, 3)
    assert ("..." in said) == (count > 3)
    assert (f"; {0.5 * count:g} MB)" in said) == (count > 0)
    assert "own" not in said


def test_the_innermost_forty_frames_of_a_traceback_are_kept():
    def even(left):
        odd(left - 1)

    def odd(left):
        if left < 0:
            raise KeyError("x")
        even(left - 1)

    with pytest.raises(KeyError) as raised:
        even(60)
    text = PieceFault.of(raised.value, "").traceback
    assert text.count(", in even") + text.count(", in odd") == 40
    assert text.rstrip().endswith("KeyError: 'x'")
