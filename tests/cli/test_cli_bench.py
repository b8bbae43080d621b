"""cam bench as a user runs it: artefacts, columns, exit codes, plans and refusals."""

import csv
import json

import pytest

QUICK = ("bench", "--quick")
LITTLE = ("--set", "bench.cases=[periodic, chatter]", "--set", "bench.methods=[core, dop853, rk4]")


def rows(path):
    """A CSV as dictionaries."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_precision(cam, tmp_path):
    done = cam(*QUICK, "precision", *LITTLE, "--flights", "20", "-o", "out")
    assert done.returncode == 0, done.stderr
    found = rows(tmp_path / "out" / "precision.csv")
    assert list(found[0])[:6] == ["case", "method", "setting", "seconds", "error", "impacts"]
    assert {(r["case"], r["method"]) for r in found} == {
        (a, b) for a in ("periodic", "chatter") for b in ("core", "dop853", "rk4")
    }
    for row in found:
        if row["method"] == "core":
            assert row["status"] == "ok"
            assert float(row["error"]) <= float(row["bound"])
            assert float(row["of_bound"]) <= 1.0
    assert (tmp_path / "out" / "precision.png").stat().st_size > 20_000
    flights = rows(tmp_path / "out" / "flights.csv")
    assert flights[0]["method"] == "core"
    assert (flights[0]["missed"], flights[0]["invented"]) == ("0", "0")
    assert [(r["asked"], r["flights"]) for r in flights] == [("20", "20")] * 3
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["scene"]["bench"]["flights"] == 20
    assert [c["case"] for c in record["result"]["precision"]["cases"]] == ["periodic", "chatter"]
    assert "Work and precision" in done.stdout
    assert record["cost"]["impacts"] > 100
    assert "points, 20 random flights in" in done.stdout
    assert "impacts in" not in done.stdout


def test_stability(cam, tmp_path):
    done = cam("bench", "stability", "--json", "-o", "out")
    assert done.returncode == 0, done.stderr
    path = tmp_path / "out" / "stability.csv"
    assert path.read_text().splitlines()[0] == "case,expected,observed,status,seconds"
    found = rows(path)
    assert len(found) == 24
    assert all(r["status"] == "ok" and None not in r for r in found)
    assert (tmp_path / "out" / "stability.png").exists()
    assert json.loads(done.stdout)["result"]["stability"]["failed"] == []


def test_scenes(cam, tmp_path):
    done = cam(*QUICK, "scenes", "--no-plot", "-o", "out")
    assert done.returncode == 0, done.stderr
    found = {r["scene"]: r for r in rows(tmp_path / "out" / "scenes.csv")}
    assert min(float(r["ratio"]) for r in found.values()) == 1.0
    assert found["cam --help"]["heavy"] == ""
    assert "numba" not in found["simulate; chatter"]["heavy"]
    assert "matplotlib" in found["simulate; picture"]["heavy"]
    assert "matplotlib" not in found["sweep; log"]["heavy"]


def test_a_failed_row_is_exit_code_3(monkeypatch, tmp_path, capsys):
    from camcli.analysis.bench import stability
    from camcli.analysis.bench.row import Row, need
    from camcli.cli.app import app

    bad = Row("1: r = 0", "one", lambda bench: need(False, "two"))
    monkeypatch.setattr(stability, "ROWS", (bad,))
    words = ["bench", "stability", "--no-plot", "-o", str(tmp_path / "out")]
    assert app(words, standalone_mode=False) == 3
    assert "stability: row 1: r = 0: expected one: two" in capsys.readouterr().err
    assert rows(tmp_path / "out" / "stability.csv")[0]["status"] == "failed"


def test_what_is_not_reached_is_said_and_is_exit_code_3(monkeypatch, tmp_path, capsys):
    from camcli.analysis.bench import budget
    from camcli.cli.app import app

    monkeypatch.setattr(budget, "QUICK", dict.fromkeys(budget.QUICK, 0.0))
    words = [*QUICK, *LITTLE, "--no-plot", "-o", str(tmp_path / "out")]
    assert app(words, standalone_mode=False) == 3
    said = capsys.readouterr()
    assert "precision: 6 of 6 points of ours not reached, time was up" in said.err
    assert "precision: time was up after 0 of 100 random flights" in said.err
    assert "stability: 24 of 24 rows not reached, time was up" in said.err
    assert "scenes: 5 of 5 commands not reached, time was up" in said.err
    assert "0 of 24 extreme cases" in said.out
    for name in ("precision", "stability", "scenes"):
        assert {r["status"] for r in rows(tmp_path / "out" / f"{name}.csv")} == {"not-reached"}


def test_the_plan(cam, tmp_path):
    done = cam("bench", "--dry-run", "--json")
    plan = json.loads(done.stdout)["plan"]
    assert list(plan) == ["points", "flights", "stability", "scenes"]
    assert sum(part["seconds"] for part in plan.values()) < 600
    assert plan["stability"]["runs"] == 24
    quick = cam("bench", "precision", "--quick", "--dry-run")
    assert quick.returncode == 0
    assert "points" in quick.stdout
    assert "stability" not in quick.stdout
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["speed"], "expected one of precision, stability, scenes"),
        (["--rpm", "700"], "every case has its own"),
        (["--points", "7"], "every case has its own"),
        (["--flights", "-1"], "bench.flights"),
        (["--set", "bench.cases=[fast]"], "bench.cases"),
        (["--set", "bench.methods=[]"], "bench.methods"),
    ],
)
def test_bad_usage_is_one_clear_message(cam, words, said):
    done = cam("bench", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_help_imports_neither_scipy_nor_heyoka(cam):
    import subprocess
    import sys

    probe = (
        "import sys\nfrom camcli.cli.app import app\n"
        "app(['bench', '--help'], standalone_mode=False)\n"
        "print({m for m in ('scipy', 'heyoka', 'numpy', 'numba') if m in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "set()"
