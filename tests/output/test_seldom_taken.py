"""Branches that hardly any run takes: what is told of the rare, from results made here."""

from __future__ import annotations

import json
from contextlib import nullcontext
from math import inf, nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.figure import Figure

from camcli.analysis.orbits.branch_segment import Kind
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.one_period import MOST_SHOWN
from camcli.api.orbits import _orbit
from camcli.cli import explore, run
from camcli.cli.options import Request
from camcli.kernel.certify import Verdict
from camcli.output.digest import _quantiles, caption
from camcli.parallel import Shard
from camcli.plots import basins, bench, detach, orbits
from camcli.scene.document import parse
from camcli.words.figures import certificate_refused, drift_line, drift_verdict
from camcli.words.orbits import branch_words
from camcli.words.proofs import named


def drift(**values):
    whole = {"figure": "3.5", "name": "x", "reference": 2.0, "found": 2.5, "by": 0.5}
    return Made(**{**whole, "portability": False, **values})


@pytest.mark.parametrize(
    ("found", "wanted"),
    [
        (lambda: drift_line(drift(), True),
         "3.5: x (chaotic): reference 2.0, found 2.5, off by 0.5 (0.25 of it)"),
        (lambda: drift_line(drift(reference=-2.0, found=-2.5, by=-0.5, portability=True), False),
         "3.5: x: reference -2.0, found -2.5, off by -0.5 (0.25 of it): portability broke"),
        (lambda: drift_line(drift(found=1.5, by=-0.5), False),
         "3.5: x: reference 2.0, found 1.5, off by -0.5 (0.25 of it)"),
        (lambda: drift_line(drift(reference=0.0, found=None, by=0.5), False),
         "3.5: x: reference 0.0, found nothing, off by 0.5"),
        (lambda: drift_line(drift(reference=None, by=None), False),
         "3.5: x: reference nothing, found 2.5"),
        (lambda: drift_verdict(3, 2, 3),
         "3 numbers drifted in 2 figures: portability broke: only chaotic motions and last bits "
         "differ"),
        (lambda: drift_verdict(3, 1, 2),
         "3 numbers drifted in 1 figure, 2 of them where bits should agree on every machine "
         "(portability broke)"),
        (lambda: drift_verdict(1, 1, 0, 2),
         "1 number drifted in 1 figure; 2 figures have no reference to compare with: "
         "--update-reference makes one"),
        (lambda: drift_verdict(0, 0, 0, 1),
         "1 figure has no reference to compare with: --update-reference makes one"),
        (lambda: certificate_refused(["confirmed: a", "not confirmed: b", "not confirmed: c"]),
         "its certificate is not confirmed: not confirmed: b"),
        (lambda: named(CurveRange(3, 4, 9, ((1.0, 2.0), (3.0, 4.0)), 5)),
         "curve 3 from point 4 to point 9"),
        (lambda: caption("{a} of the information; {b}", {"a": inf, "b": "P(1;inf:1)"}),
         "∞ of the information; P(1;∞:1)"),
        (lambda: dict(_quantiles("t", {"a": np.array([nan, nan]), "b": np.array([nan, 4.0])})),
         {f"t b {level}": 4.0
          for level in ("least", "q05", "q25", "median", "q75", "q95", "largest")}),
    ],
)  # fmt: skip
def test_what_is_told_seldom(found, wanted):
    assert found() == wanted


def test_a_branch_names_its_first_and_its_last_orbit_and_the_event_it_leaves_from():
    points = [Made(regions=("rise",), value=700.0), Made(regions=("rise",), value=745.5)]
    branch = Made(number=4, labels=["P(1;1)", "P(1;2)", "P(1;inf)"], points=points,
                  ends=(Kind.END_OF_RANGE, Kind.END_OF_RANGE))  # fmt: skip
    assert branch_words(branch, "rpm", 2, 80) == "4   P(1;1) to P(1;∞), from event 2"
    branch.labels = ["P(1;1)"]
    assert branch_words(branch, "rpm", None, 80) == "4   P(1;1), impacts in rise"
    assert branch_words(branch, "rpm", None, len("4   P(1;1), impacts in rise") - 1) == "4   P(1;1)"


def basins_of(count, share=0.05):
    """A window with so many attractors, the k-th of which takes k / 200 of it."""
    attractors = [Made(label=f"P({k};1)", states=np.array([[9.0, 9.0]]), periodic=True, period=k)
                  for k in range(1, count + 1)]  # fmt: skip
    return Made(
        value=700.0, rpm=700.0, branches=list(range(1, count + 1)), attractors=attractors,
        fractions={k: (k / 200.0, 0.0) for k in range(1, count + 1)}, codes=np.array([1]),
        undecided=0, troubled={},
    )  # fmt: skip


@pytest.mark.parametrize("count", [12, 13, 15])
def test_the_list_of_a_window_names_twelve_attractors_and_what_the_others_take(monkeypatch, count):
    monkeypatch.setattr(basins, "_attractor_row", lambda grids, branch, *_: [branch])
    grid = basins_of(count)
    labels = basins._labels([grid])
    rows = basins._attractor_rows([grid], labels, dict.fromkeys(labels, "black"), "rpm")
    assert [row[0] for row in rows[1:13]] == list(range(1, 13))
    rest = {12: [], 13: [["and 1 more, together", "6.50 %"]],  # 13/200; 13 + 14 + 15 of 200
            15: [["and 3 more, together", "21.0 %"]]}  # fmt: skip
    assert [row[2:] for row in rows[13:]] == rest[count]


@pytest.mark.parametrize("undecided", [0, 3])
def test_the_list_of_a_range_names_the_twelve_largest_attractors(undecided):
    grid = basins_of(14)
    grid.undecided = undecided
    found = basins._range_entries(Made(speeds=[grid, grid]))
    assert [branch for branch, _ in found[:12]] == list(range(3, 15))
    assert found[12] == (-1, ["2 further attractors, in repeated colours"])
    assert [words for _, words in found[13:]] == [["undecided, or numerical trouble"]] * (
        undecided > 0
    )


def test_a_page_of_orbits_says_how_many_more_there_are(monkeypatch):
    monkeypatch.setattr(orbits, "_dot", lambda *_: "")
    orbit = Made(theta=[radians(30.0)], root=None, resting=False, stable=True, label="P(1;1)",
                 trace=0.5, det=0.06)  # fmt: skip
    for more in (0, 1, 5):
        rows = orbits._orbit_rows([orbit] * (MOST_SHOWN + more), ["red"] * (MOST_SHOWN + more))
        assert len(rows) == 1 + MOST_SHOWN + (more > 0)
        if more:
            assert rows[-1] == [f"and {more} more, in the tables"]


def test_panels_without_anything_to_show_say_so():
    axes = Figure().subplots()
    bench._ranges(axes, [])
    assert axes.get_xlim() == pytest.approx((0.5e-4, 2.0))
    assert axes.get_ylim() == pytest.approx((0.25e-17, 3.0))
    for speeds, worst in (([inf, inf], 800.0), ([700.0], inf), ([], inf)):
        axes = Figure().subplots()
        detach._draw_machines(axes, Made(speeds=speeds, worst=worst), 750.0)
        assert [text.get_text() for text in axes.texts] == ["contact is never lost"]
        assert not axes.patches


def test_an_escape_that_is_no_character_is_refused_where_it_stands():
    cases = [
        ('figure:\n  title: "a \\uffff b"\n', "x.yaml:2:10: figure.title"),
        ('"k\\uffff": 1\n', "x.yaml:1:1"),
    ]
    for text, where in cases:
        (finding,) = parse(text, "x.yaml").findings
        assert str(finding.fault()) == (
            f"{where}: found an escape that is no character, expected text, remove it"
        )


@pytest.mark.parametrize("failed", [False, True])
def test_a_shard_tells_its_pieces_as_json(capsys, tmp_path, failed):
    fault = Made(piece="rpm = 7", error="KeyError: 1", place="camcli/a.py:1, f", traceback="T")
    folder = Made(work=Made(faults=[fault] * failed), folder=tmp_path)
    request = Made(json=True, quiet=False)
    run._tell_of_shard(Made(name="sweep"), Shard(2, 3), folder, tmp_path / "p", request)
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert told["command"] == "sweep"
    assert told["pieces"] == str(tmp_path / "p")
    assert told["shard"] in ([2, 3], {"number": 2, "total": 3})
    assert [one["pieces"] for one in told.get("piece_faults", [])] == [["rpm = 7"]] * failed
    assert ("fault: rpm = 7" in said.err) == failed
    assert (f"with {tmp_path}/p, which has the traceback" in said.err) == failed
    request.json = False
    run._tell_of_shard(Made(name="sweep"), Shard(2, 3), folder, tmp_path / "p", request)
    again = " (it tries again what failed)" if failed else ""
    assert capsys.readouterr().err.splitlines()[-1] == (
        f"{tmp_path}/p: complete; when all shards are, run cam merge {tmp_path}{again}"
    )
    request.quiet = True
    run._tell_of_shard(Made(name="sweep"), Shard(2, 3), folder, tmp_path / "p", request)
    assert "complete" not in capsys.readouterr().err


def test_words_that_fail_are_told_beside_what_failed_before(capsys, monkeypatch, tmp_path):
    """All files are in their places then: run.json alone is written again, with both."""
    before = {"pieces": ["rpm = 7"], "error": "KeyError: 1", "place": "", "traceback": "T"}
    written: list[str] = []
    folder = Made(work=Made(faults=[]), folder=tmp_path, shard_done=False,
                  replace_record=written.append)  # fmt: skip

    def fails(*_):
        raise ZeroDivisionError("words")

    monkeypatch.setattr(run, "open_folder", lambda *_, **__: nullcontext(folder))
    monkeypatch.setattr(run, "compute", lambda *_: (None, {"piece_faults": [before], "x": 1}))
    monkeypatch.setattr(run, "_say", fails)
    assert run.execute(Made(), Made(), Made(no_plot=True), fails) == 1
    (text,) = written
    record = json.loads(text)
    assert record["x"] == 1
    told = [(one["pieces"], one["error"]) for one in record["piece_faults"]]
    assert told == [
        (["rpm = 7"], "KeyError: 1"),
        (["the words on the screen"], "ZeroDivisionError: words"),
    ]
    said = capsys.readouterr().err
    assert "fault: rpm = 7: KeyError: 1" in said
    assert "fault: the words on the screen: ZeroDivisionError: words" in said


def test_an_orbit_over_another_number_has_its_impacts_at_the_speed():
    """600 rpm are 20 pi rad/s; the parameter, 0.75, is no speed."""
    orbit = Made(label="P(1;2)", rpm=600.0, value=0.75, stable=True, verdict=Verdict.LATE,
                 theta=[radians(30.0), radians(270.0)], regions=["A1", "A4"], rates=[-0.25, -0.5],
                 multipliers=[0.5, 0.25], trace=0.75, det=0.125)  # fmt: skip
    assert _orbit(orbit) == {
        "label": "P(1;2)", "rpm": 600.0, "stable": True, "regions": ["A1", "A4"],
        "verdict": "virtual: an impact is missing", "theta_deg": pytest.approx([30.0, 270.0]),
        "u_minus_m_per_s": pytest.approx([-5.0 * pi, -10.0 * pi]),
        "multipliers": [0.5, 0.25], "trace": 0.75, "det": 0.125,
    }  # fmt: skip


@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("complete", [False, True])
def test_what_was_cut_short_is_told_even_to_who_wants_nothing_said(capsys, quiet, complete):
    result = Made(notes=["warning: the budget was spent"], complete=complete, left_out={})
    run._say(result, {"answer": 1}, Made(json=True, quiet=quiet), None)
    told = capsys.readouterr()
    assert json.loads(told.out) == {"answer": 1}
    assert ("budget" in told.err) is not (quiet and complete)


@pytest.mark.parametrize(
    ("points", "speeds", "masses"),
    [("5", 5, None), ("5,3", 5, 3), (",3", None, 3), (None, None, None)],
)
def test_points_of_a_page_are_of_its_speeds_and_of_the_other_numbers_of_its_map(
    points, speeds, masses
):
    request = Request(points=points, rpm="650:651")
    values = {
        key: value for key, (value, _) in explore._values(request, ["follower.mass=1:2"]).items()
    }
    assert values.get("sweep.rpm.num") == speeds
    (mass,) = values["sweep.vary"]
    assert mass.get("num") == masses
    assert (values["sweep.rpm.start"], values["sweep.rpm.stop"]) == (650.0, 651.0)
