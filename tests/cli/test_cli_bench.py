"""cam bench as a user runs it: artefacts, columns, exit codes, plans and refusals."""

import csv
import json

import pytest

from camcli.analysis.bench import stability
from camcli.api.bench import STUDIES
from camcli.cli.app import app
from camcli.cli.exit_codes import guarded
from camcli.scene import load_scene

LITTLE = ["--quick", "--set", "bench.cases=[periodic]", "--set", "bench.methods=[core, rk4]"]


@pytest.fixture
def run(tmp_path, capsys):
    """`cam bench WORDS` in this process: exit code, stdout, stderr, and a reader of its tables."""

    def call(*words):
        code = guarded(lambda: app(["bench", *words, "-o", str(tmp_path)], standalone_mode=False))
        said = capsys.readouterr()
        return code, said.out, said.err

    def rows(name):
        with open(tmp_path / f"{name}.csv", newline="") as file:
            return list(csv.DictReader(file))

    call.rows, call.folder = rows, tmp_path
    return call


def test_precision(run):
    code, out, _ = run("precision", *LITTLE)
    assert code == 0
    found = run.rows("precision")
    assert list(found[0])[:6] == ["case", "method", "setting", "seconds", "error", "impacts"]
    assert [r["method"] for r in found] == ["core"] * 3 + ["rk4"] * 2
    for r in found[:3]:
        assert r["status"] == "ok"
        assert float(r["error"]) <= float(r["bound"])
    assert (run.folder / "precision.png").stat().st_size > 20_000
    record = json.loads((run.folder / "run.json").read_text())
    (told,) = record["result"]["precision"]["cases"]
    assert told["case"] == "periodic"
    assert told["error_turns"] < 1e-12
    assert told["most_exact_other"].startswith("rk4")
    assert record["cost"]["impacts"] == 120
    assert "Work and precision" in out
    assert "5 of precision in" in out


def test_a_failed_row_is_exit_code_3(run, monkeypatch):
    bad = stability.Row("1: r = 0, b", "one", lambda bench: stability.need(False, '"two"'))
    monkeypatch.setattr(stability, "ROWS", {1: bad, 8: stability.ROWS[8]})
    code, out, _ = run("stability", "--json")
    assert code == 3
    assert json.loads(out)["result"]["stability"] == {"rows": 2, "failed": ["1: r = 0, b"]}
    assert (run.folder / "stability.png").read_bytes()[:4] == b"\x89PNG"
    first, second = run.rows("stability")
    assert list(first) == ["case", "expected", "observed", "status", "seconds"]
    assert (first["case"], first["observed"], first["status"]) == ("1: r = 0; b", "'two'", "failed")
    assert second["status"] == "ok"
    code, _, said = run("stability", "--no-plot")
    assert 'stability: row 1: r = 0, b: expected one: "two"' in said


def test_scale(run, monkeypatch):
    little = {"sweep.rpm": {"start": 690.0, "stop": 700.0, "num": 3}, "run.record": 40}
    study, *_ = STUDIES["sweep"]
    monkeypatch.setattr("camcli.api.bench.STUDIES", {"sweep": (study, 1920, little)})
    code, out, _ = run("scale", "--quick")
    (row,) = run.rows("scale")
    one, every = float(row["seconds_one_thread"]), float(row["seconds"])
    assert code == 0
    impacts = study(load_scene(None, little)).cost.impacts
    assert (row["case"], row["turns"], row["impacts"]) == ("sweep", "1920", str(impacts))
    assert float(row["speedup"]) == one / every
    assert float(row["impacts_per_s"]) == impacts / every
    assert "Whole studies" in out


def test_the_plan_of_a_quick_run_keeps_to_a_minute(run):
    code, out, _ = run("--dry-run", "--json", "--quick")
    plan = json.loads(out)["plan"]
    assert code == 0
    assert list(plan) == ["precision", "stability", "scale"]
    assert plan["stability"]["runs"] == 24
    assert sum(part["seconds"] for part in plan.values()) < 120.0
    assert not list(run.folder.iterdir())
