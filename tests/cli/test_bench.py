"""cam bench as a user runs it: artefacts, columns, exit codes, plans and refusals."""

import json
import re
from dataclasses import fields
from types import SimpleNamespace

import pytest

import camcli.api.bench as bench_module
from camcli.analysis.bench import precision, stability
from camcli.api.bench import RESULTS, STUDIES, Throughput, WholeStudy
from camcli.cli import bench as screen
from camcli.scene import load_scene
from camcli.words.bench import precision_notes
from tests.conftest import rows

LITTLE = "--quick --set bench.cases=[periodic] --set bench.methods=[core,rk4]"


def test_precision(cam, tmp_path):
    done = cam(f"bench precision {LITTLE} -o .", code=0)
    found = rows(tmp_path / "precision.csv")
    assert list(found[0])[:6] == ["case", "method", "setting", "seconds", "error", "impacts"]
    assert [r["method"] for r in found] == ["core"] * 3 + ["rk4"] * 2
    for r in found[:3]:
        assert r["status"] == "ok"
        assert float(r["error"]) <= float(r["bound"])
    assert (tmp_path / "precision.png").stat().st_size > 20_000
    record = json.loads((tmp_path / "run.json").read_text())
    (told,) = record["result"]["precision"]["cases"]
    assert told["case"] == "periodic"
    assert told["error_turns"] < 1e-12
    assert told["most_exact_other"].startswith("rk4")
    assert record["cost"]["impacts"] == 120
    assert "Work and precision" in done.stdout
    assert "5 of precision in" in done.stdout


def test_a_failed_row_is_exit_code_3(cam, tmp_path, monkeypatch):
    bad = stability.Row("1: r = 0, b", "one", lambda bench: stability.need(False, '"two"'))
    monkeypatch.setattr(stability, "ROWS", {1: bad, 8: stability.ROWS[8]})
    done = cam("bench stability --json -o .", code=3)
    assert json.loads(done.stdout)["result"]["stability"] == {"rows": 2, "failed": ["1: r = 0, b"]}
    assert (tmp_path / "stability.png").read_bytes()[:4] == b"\x89PNG"
    first, second = rows(tmp_path / "stability.csv")
    assert list(first) == ["case", "expected", "observed", "status", "seconds"]
    assert (first["case"], first["observed"], first["status"]) == ("1: r = 0; b", "'two'", "failed")
    assert second["status"] == "ok"
    said = cam("bench stability --no-plot -o .").stderr
    assert 'stability: row 1: r = 0, b: expected one, but: "two"' in said


def test_scale(cam, tmp_path, monkeypatch):
    little = {"sweep.rpm": {"start": 690.0, "stop": 700.0, "num": 3}, "run.record": 40}
    study = STUDIES["sweep"].run
    small = WholeStudy(run=study, turns=1920, keys=little)
    monkeypatch.setattr("camcli.api.bench.STUDIES", {"sweep": small})
    done = cam("bench scale --quick -o .", code=0)
    (row,) = rows(tmp_path / "scale.csv")
    one, every = float(row["seconds_one_thread"]), float(row["seconds"])
    impacts = study(load_scene(None, little)).cost.impacts
    assert (row["case"], row["turns"], row["impacts"]) == ("sweep", "1920", str(impacts))
    assert float(row["speedup"]) == one / every
    assert float(row["impacts_per_s"]) == impacts / every
    assert "Whole studies" in done.stdout


def test_the_plan_of_a_quick_run_keeps_to_two_minutes(cam, tmp_path):
    plan = json.loads(cam("bench --dry-run --json --quick", code=0).stdout)["plan"]
    assert list(plan) == ["precision", "stability", "scale", "validation"]
    assert plan["stability"]["runs"] == 24
    bounds = [part["seconds"] for part in plan.values()]  # of each part, which takes less
    assert sum(bounds) < 125.0
    assert not list(tmp_path.iterdir())


def test_the_records_of_a_bench_hold_every_row():
    """What run.json says of each part, from rows written here."""
    rows = [Throughput(*(float(k + n) for n, _ in enumerate(fields(Throughput)))) for k in range(3)]
    result, trouble = RESULTS["scale"](rows)
    assert result == {"studies": [vars_of(row) for row in rows]}
    assert trouble == []
    outcomes = [
        SimpleNamespace(case=k, expected=f"e{k}", observed=f"o{k}", status=status)
        for k, status in enumerate(["ok", "failed", "ok"])
    ]
    result, trouble = RESULTS["stability"](outcomes)
    assert result == {"rows": 3, "failed": [1]}
    assert trouble == ["row 1: expected e1, but: o1"]


def test_a_point_of_ours_beyond_its_bound_is_told():
    rows = [
        precision.Measured("period-1", precision.CORE, setting, 0.5, error, 40, 700, missed,
                           of_bound=of_bound, status=status)
        for setting, error, missed, of_bound, status in [
            ("tol 1e-9", 2.25e-7, 3, 4.5, "missed"), ("tol 1e-6", 1.5e-3, 0, 1234.0, "over-bound"),
        ]
    ]  # fmt: skip
    assert precision_notes(rows) == [
        "period-1, tol 1e-9: missed: error 2.2e-07 turns, 4.5 times its bound at most, "
        "3 impacts missed",
        "period-1, tol 1e-6: over-bound: error 0.0015 turns, 1.23e+03 times its bound at most, "
        "0 impacts missed",
    ]


def vars_of(row):
    return {field.name: getattr(row, field.name) for field in fields(row)}


@pytest.mark.parametrize("statuses", [("ok", "absent"), ("ok", "ok")])
def test_a_method_that_is_not_installed_is_told(statuses, monkeypatch):
    status_of = {"ok": precision.OK, "absent": precision.ABSENT}
    measured = [
        precision.Measured("period-1", "other", "tol 1e-9", error=1e-9, status=status_of[status])
        for status in statuses
    ]
    monkeypatch.setattr(bench_module, "_measured", lambda *_: measured)
    monkeypatch.setattr(bench_module, "_table", lambda *_: None)
    notes = bench_module.bench(load_scene(None, {"bench.part": "precision"})).notes
    assert (bench_module.NO_HEYOKA in notes) == ("absent" in statuses)


def test_the_machine_of_a_scene_is_said_to_be_unused(cam, tmp_path):
    (tmp_path / "mine.yaml").write_text(
        "follower: {mass: 1, stiffness: 100, restitution: 0.5}\n"
        "cam: {kind: eccentric, base: 0, lift: 0.01}\n"
    )
    told = "note: of mine.yaml only the section bench is used"
    assert told in cam("bench validation -c mine.yaml --dry-run", code=0).stderr
    assert cam("bench validation --dry-run", code=0).stderr == ""
    assert cam("bench validation -c mine.yaml --dry-run -q", code=0).stderr == ""


def test_a_table_of_the_bench_has_heads_in_words_and_cells_of_few_digits(capsys):
    shown = [SimpleNamespace(case="one_two", error_turns=1.2345e-7, impacts=None, runs=12)]
    screen._show("Title", ["case", "error_turns", "impacts", "runs"], shown)
    title, heads, _, cells = capsys.readouterr().out.strip().splitlines()
    assert title == "Title"
    assert re.split(" {2,}", heads.strip()) == ["case", "error turns", "impacts", "runs"]
    assert re.split(" {2,}", cells.strip()) == ["one_two", "1.2e-07", "-", "12"]
