"""cam bench as a user runs it: artefacts, columns, exit codes, plans and refusals."""

import csv
import json
import subprocess
import sys

import pytest

from camcli.analysis.bench import stability
from camcli.cli import bench_run as bench
from camcli.cli.app import app
from camcli.cli.exit_codes import guarded

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
    code, out, _ = run("precision", *LITTLE, "--flights", "20")
    assert code == 0
    found = run.rows("precision")
    assert list(found[0])[:6] == ["case", "method", "setting", "seconds", "error", "impacts"]
    assert [r["method"] for r in found] == ["core"] * 3 + ["rk4"] * 2
    for r in found[:3]:
        assert r["status"] == "ok"
        assert float(r["error"]) <= float(r["bound"])
    assert (run.folder / "precision.png").stat().st_size > 20_000
    (flown,) = run.rows("flights")
    assert (flown["asked"], flown["flights"], flown["missed"], flown["invented"]) == (
        "20", "20", "0", "0",
    )  # fmt: skip
    record = json.loads((run.folder / "run.json").read_text())
    assert record["scene"]["bench"]["flights"] == 20
    assert [c["case"] for c in record["result"]["precision"]["cases"]] == ["periodic"]
    assert record["cost"]["impacts"] == 120
    assert "Work and precision" in out
    assert "5 points, 20 random flights in" in out


def test_a_failed_row_is_exit_code_3(run, monkeypatch):
    bad = stability.Row("1: r = 0, b", "one", lambda bench: stability.need(False, '"two"'))
    good = stability.ROWS[8]
    monkeypatch.setattr(stability, "ROWS", {1: bad, 8: good})
    code, out, _ = run("stability", "--json")
    assert code == 3
    assert json.loads(out)["result"]["stability"] == {"rows": 2, "failed": ["1: r = 0, b"]}
    first, second = run.rows("stability")
    assert list(first) == ["case", "expected", "observed", "status", "seconds"]
    assert (first["case"], first["observed"], first["status"]) == ("1: r = 0; b", "'two'", "failed")
    assert second["status"] == "ok"
    assert (run.folder / "stability.png").exists()
    code, _, said = run("stability", "--no-plot")
    assert 'stability: row 1: r = 0, b: expected one: "two"' in said
    assert not (run.folder / "stability.png").exists()


@pytest.mark.slow
def test_a_scene_imports_only_what_it_needs(run, monkeypatch):
    monkeypatch.setattr(bench, "QUICK", dict.fromkeys(bench.QUICK, 60.0))
    code, *_ = run("--quick", "scenes", "--no-plot")
    assert code == 0
    found = {r["scene"]: r for r in run.rows("scenes")}
    assert min(float(r["ratio"]) for r in found.values()) == 1.0
    assert found["cam --help"]["heavy"] == ""
    assert "numba" not in found["simulate; chatter"]["heavy"]
    assert "matplotlib" in found["simulate; picture"]["heavy"]
    assert "matplotlib" not in found["sweep; log"]["heavy"]


def test_what_is_not_reached_is_said_and_is_exit_code_3(run, monkeypatch):
    monkeypatch.setattr(bench, "QUICK", dict.fromkeys(bench.QUICK, 0.0))
    code, out, said = run(*LITTLE, "--no-plot")
    assert code == 3
    assert "precision: points of ours not reached, time was up: 3 of 3" in said
    assert "precision: time was up after 0 of 100 random flights" in said
    assert "stability: rows not reached, time was up: 24 of 24" in said
    assert "scenes: commands not reached, time was up: 5 of 5" in said
    assert "0 of 24 extreme cases" in out
    for name in ("precision", "stability", "scenes"):
        assert {r["status"] for r in run.rows(name)} == {"not-reached"}


def test_the_plan_keeps_to_ten_minutes_and_a_quick_one_to_one(run):
    for words, promised in (((), 600.0), (("--quick",), 60.0)):
        code, out, _ = run("--dry-run", "--json", *words)
        plan = json.loads(out)["plan"]
        assert code == 0
        assert list(plan) == ["points", "flights", "stability", "scenes"]
        assert plan["stability"]["runs"] == 24
        assert sum(part["seconds"] for part in plan.values()) <= 0.95 * promised
    _, out, _ = run("precision", "--dry-run", "--json", "--quick", "--flights", "1000000")
    plan = json.loads(out)["plan"]
    assert list(plan) == ["points", "flights"]
    assert plan["flights"]["runs"] == 10**6
    assert 600.0 < plan["flights"]["seconds"] < 60_000.0
    assert not list(run.folder.iterdir())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["speed"], "expected one of precision, stability, scenes"),
        (["--rpm", "700"], "every case has its own"),
        (["--points", "7"], "every case has its own"),
        (["--flights", "-1"], "bench.flights"),
        (["--set", "bench.cases=[fast]"], "bench.cases"),
        (["--set", "bench.methods=[]"], "bench.methods"),
    ],
)
def test_bad_usage_is_one_clear_message(run, words, told):
    code, _, said = run(*words)
    assert code == 2
    assert told in said


def test_help_imports_neither_scipy_nor_heyoka():
    probe = (
        "import sys\nfrom camcli.cli.app import app\n"
        "app(['bench', '--help'], standalone_mode=False)\n"
        "print({m for m in ('scipy', 'heyoka', 'numpy', 'numba') if m in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "set()"
