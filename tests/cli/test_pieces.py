"""An exception that nobody foresaw costs its piece alone: a speed, a block of cells, a branch.

Its row has the status `fault`, all others are as in a run without it, the exit code is 1, and the
traceback stands in run.json.
"""

import json
import os
import re
import subprocess
import sys
from functools import partial
from importlib import import_module

import pytest

from camcli.analysis import motion_at_speed
from camcli.errors import Fault, SceneError
from tests.conftest import rows
from tests.support.clocks import time_passes

FEW = "--no-plot --set run.transient=5 --set run.record=10 --set run.patience=0"


@pytest.fixture
def breaking(monkeypatch):
    """Let a function fail where its arguments meet a condition."""

    def breaks(place: str, when=lambda *args, **options: True, error=ZeroDivisionError):
        path, _, name = place.rpartition(".")
        module, _, kind = path.rpartition(".")
        owner = import_module(path if kind.islower() else module)
        owner = owner if kind.islower() else getattr(owner, kind)
        real = getattr(owner, name)

        def broken(*args, **options):
            if when(*args, **options):
                raise error("nobody foresaw this")
            return real(*args, **options)

        monkeypatch.setattr(owner, name, broken)

    return breaks


def at_speed(*rpms):
    """Of functions of (system, rpm, ...)."""
    return lambda _, rpm, *args, **options: rpm in rpms


def faults_of(folder):
    return json.loads((folder / "run.json").read_text())["piece_faults"]


def told(done, folder, *pieces):
    """What stderr and run.json say of the faults; returns the pieces by record."""
    assert "Traceback" not in done.stdout + done.stderr
    assert "internal fault" not in done.stderr
    assert f"please report it with {folder.name}/run.json" in done.stderr
    records = faults_of(folder)
    for record in records:
        assert record["error"] == "ZeroDivisionError: nobody foresaw this"
        assert "test_pieces.py" in record["traceback"]
        assert record["place"].startswith("camcli/")
    found = [piece for record in records for piece in record["pieces"]]
    assert found == list(pieces)
    assert all(f"fault: {', '.join(record['pieces'][:5])}" in done.stderr for record in records)


def but(folder, name, column, *values):
    """The rows of a CSV without those with these values in a column."""
    return [row for row in rows(folder / name) if row[column] not in values]


SWEEPS = {
    "one thread": "--threads 1",
    "two threads": "--threads 2",
    "carried": "--set sweep.direction=down",
    "another number": "--vary follower.restitution=0.7:0.9",
    "adaptive": "--adaptive",
    "with exponents": "--lyapunov",
}


@pytest.mark.parametrize("name", SWEEPS)
def test_a_speed_of_a_sweep(cam, tmp_path, breaking, name):
    key, value = ("follower.restitution", "0.8") if "vary" in SWEEPS[name] else ("rpm", "700.0")
    line = f"sweep --points 5 {SWEEPS[name]} {FEW}"
    line += " --rpm 700" if "vary" in SWEEPS[name] else " --rpm 680:720"
    cam(line, "-o whole", code=0)

    def when(system, rpm, record):
        follower = system.follower
        return rpm == 700.0 and (key == "rpm" or follower.restitution == float(value))

    breaking("camcli.analysis.motion_at_speed.loads_of", when)
    done = cam(line, "-o out", code=1)
    out, whole = tmp_path / "out", tmp_path / "whole"
    told(done, out, f"{key} = {value}")
    assert f"fault at 1 {'speed (700 rpm)' if key == 'rpm' else 'value'}" in done.stderr
    (bad,) = [row for row in rows(out / "speeds.csv") if row[key] == value]
    assert {x for column, x in bad.items() if column not in (key, "label", "status")} == {""}
    assert (bad["label"], bad["status"]) == ("undecided", "fault")
    labels = [row["label"] for row in rows(out / "speeds.csv")]
    record = json.loads((out / "run.json").read_text())["result"]
    assert record["undecided"] == labels.count("undecided")
    for table in ("speeds.csv", "impacts.csv", "strobe.csv"):
        if name == "carried" and table != "speeds.csv":
            continue  # below it the state comes from elsewhere
        if name == "adaptive":  # more speeds were asked for where its motion was not known
            assert {tuple(row.values()) for row in but(out, table, key, value)} <= {
                tuple(row.values()) for row in rows(whole / table)
            }
        elif name != "carried":
            assert but(out, table, key, value) == but(whole, table, key, value)
    assert value not in {row[key] for row in rows(out / "strobe.csv")}


def test_with_json_the_record_has_the_faults(cam, breaking):
    breaking("camcli.analysis.motion_at_speed.loads_of", at_speed(700.0))
    done = cam(f"sweep --rpm 680:720 --points 5 --json {FEW}", code=1)
    record = json.loads(done.stdout)
    assert [one["pieces"] for one in record["piece_faults"]] == [["rpm = 700.0"]]
    assert {"status", "speeds"} <= record["result"]["ranges"][0].keys()


def test_many_faults_are_told_as_one(cam, tmp_path, breaking):
    """With the picture, and when every speed fails."""
    breaking("camcli.analysis.motion_at_speed.loads_of")
    done = cam("sweep --rpm 680:720 --points 9 --set run.record=4", code=1)
    lines = [line for line in done.stderr.splitlines() if line.startswith("fault: ")]
    assert len(lines) == 1
    assert "rpm = 680.0, rpm = 685.0, rpm = 690.0, rpm = 695.0, rpm = 700.0 and 4 more" in lines[0]
    assert {row["status"] for row in rows(tmp_path / "out/sweep/speeds.csv")} == {"fault"}
    assert (tmp_path / "out/sweep/sweep.png").exists()


def test_the_first_value_may_fail_and_its_machine_too(cam, tmp_path, breaking):
    line = "sweep --rpm 700 --vary run.record=4:12 --points 3 --no-plot"
    breaking("camcli.api.machine.machine_of", lambda scene: scene.run.record == 4)
    done = cam(line, code=1)
    found = rows(tmp_path / "out/sweep/speeds.csv")
    assert [row["status"] for row in found] == ["fault", "ok", "ok"], done.stderr


def test_a_point_of_a_map(cam, tmp_path, breaking):
    line = f"sweep --rpm 680:720 --vary follower.restitution=0.7:0.8 --points 3,2 {FEW}"
    line = line.replace("--no-plot", "")
    cam(line, "-o whole", code=0)
    breaking(
        "camcli.analysis.motion_at_speed.loads_of",
        lambda system, rpm, record: (rpm, system.follower.restitution) == (700.0, 0.8),
    )
    done = cam(line, "-o out", code=1)
    told(done, tmp_path / "out", "follower.restitution = 0.8, rpm = 700.0")
    pairs = zip(rows(tmp_path / "out/map.csv"), rows(tmp_path / "whole/map.csv"), strict=True)
    differ = [(a["status"], b["status"]) for a, b in pairs if a != b]
    assert differ == [("fault", "ok")]
    assert (tmp_path / "out/map.png").exists()


def test_errors_that_somebody_foresaw_end_the_run_as_before(cam, breaking):
    refused = partial(SceneError, Fault("cam", "", "found no cam", "", ""))
    breaking("camcli.analysis.motion_at_speed.loads_of", error=lambda _: refused())
    assert "found no cam" in cam(f"sweep --points 3 {FEW}", code=2).stderr
    breaking("camcli.analysis.motion_at_speed.loads_of", error=MemoryError)
    assert "out of memory" in cam(f"sweep --points 3 {FEW}", code=2).stderr


# --- pieces on disk, shards, clusters


def test_a_shard_with_a_fault_is_merged(cam, tmp_path, breaking, monkeypatch):
    """The piece is tried again by merge: where it fails again, the bytes are those of one run."""
    line = f"sweep --rpm 680:720 --points 5 {FEW}"
    cam(line, "-o sound", code=0)
    with monkeypatch.context():
        breaking("camcli.analysis.motion_at_speed.loads_of", at_speed(700.0))
        cam(line, "-o whole", code=1)
        done = cam(line, "--shard 1/2 -o parts", code=1)
        assert "fault: rpm = 700.0: ZeroDivisionError" in done.stderr
        assert "report it with parts/sweep-1-of-2.pieces" in done.stderr
        assert b"Traceback" in (tmp_path / "parts/sweep-1-of-2.pieces").read_bytes()
        cam(line, "--shard 2/2 -o parts", code=0)
        done = cam("merge parts -o again", code=1)
        assert "fault: rpm = 700.0" in done.stderr
    for name in ("speeds.csv", "impacts.csv", "strobe.csv"):
        whole = (tmp_path / "whole" / name).read_bytes()
        assert (tmp_path / "again" / name).read_bytes() == whole


def test_a_merge_that_does_not_fail_has_the_piece(cam, tmp_path, breaking, monkeypatch):
    line = f"sweep --rpm 680:720 --points 5 {FEW}"
    cam(line, "-o sound", code=0)
    with monkeypatch.context() as patch:
        real = motion_at_speed.loads_of
        breaking("camcli.analysis.motion_at_speed.loads_of", at_speed(700.0))
        cam(line, "--shard 1/1 -o parts", code=1)
        patch.setattr(motion_at_speed, "loads_of", real)
        cam("merge parts -o again", code=0)
    for name in ("speeds.csv", "impacts.csv", "strobe.csv"):
        sound = (tmp_path / "sound" / name).read_bytes()
        assert (tmp_path / "again" / name).read_bytes() == sound


@pytest.mark.parametrize("direction", ["fixed", "up"])
def test_a_piece_that_failed_is_tried_again_when_the_run_goes_on(
    cam, tmp_path, breaking, monkeypatch, direction
):
    """And with it all that may depend on it: the end is as of a run without a fault."""
    time_passes(monkeypatch)
    line = f"sweep --rpm 680:720 --points 9 --threads 1 --set sweep.direction={direction} {FEW}"
    cam(line, "-o sound", code=0)
    real = motion_at_speed.loads_of
    breaking("camcli.analysis.motion_at_speed.loads_of", at_speed(690.0))

    def interrupted(system, rpm, record):
        if rpm == 710.0:
            raise KeyboardInterrupt
        if rpm == 690.0:
            raise ZeroDivisionError
        return real(system, rpm, record)

    monkeypatch.setattr(motion_at_speed, "loads_of", interrupted)
    done = cam(line, "-o out", code=130)
    kept = 5 if direction == "fixed" else 2  # a state carried on from a fault is another one
    assert f"{kept} pieces are on disk, the same command goes on from them" in done.stderr
    monkeypatch.setattr(motion_at_speed, "loads_of", real)
    done = cam(line, "-o out", code=0)
    assert f"going on: {kept} pieces" in done.stderr
    for name in ("speeds.csv", "impacts.csv", "strobe.csv"):
        sound = (tmp_path / "sound" / name).read_bytes()
        assert (tmp_path / "out" / name).read_bytes() == sound


BROKEN = """
from camcli.analysis import motion_at_speed
real = motion_at_speed.loads_of
def broken(system, rpm, record):
    if rpm == 700.0:
        raise ZeroDivisionError("nobody foresaw this")
    return real(system, rpm, record)
motion_at_speed.loads_of = broken
"""


@pytest.mark.ci
@pytest.mark.slow
def test_a_speed_in_a_worker_of_a_cluster(tmp_path):
    pytest.importorskip("distributed")
    (tmp_path / "sitecustomize.py").write_text(BROKEN)
    line = f"sweep --rpm 680:720 --points 5 {FEW}".split()
    for name, more in (("cluster", ("--cluster", "local", "--threads", "2")), ("threads", ())):
        done = subprocess.run(
            [sys.executable, "-m", "camcli", *line, *more, "-o", name],
            cwd=tmp_path, capture_output=True, text=True,
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
        )  # fmt: skip
        assert done.returncode == 1, done.stderr
        assert "fault: rpm = 700.0: ZeroDivisionError: nobody foresaw this" in done.stderr
        (fault,) = faults_of(tmp_path / name)
        assert "sitecustomize.py" in fault["traceback"]
    for name in ("speeds.csv", "impacts.csv", "strobe.csv"):
        threads = (tmp_path / "threads" / name).read_bytes()
        assert (tmp_path / "cluster" / name).read_bytes() == threads


# --- other commands


def test_a_speed_of_classify(cam, tmp_path, breaking):
    line = "classify --rpm 690:710 --points 3 --set run.transient=50"
    cam(line, "-o whole", code=0)
    breaking("camcli.analysis.classify.of_orbit", lambda system, orbit: orbit.rpm == 700.0)
    done = cam(line, "--explain -o out", code=1)
    told(done, tmp_path / "out", "rpm = 700.0")
    bad = {"status": "fault", "rpm": "700.0", "label": "undecided", "period": "0"}
    found = rows(tmp_path / "out/classify.csv")
    assert {k: v for k, v in found[1].items() if v} == bad
    whole = rows(tmp_path / "whole/classify.csv")
    assert [found[0], found[2]] == [whole[0], whole[2]]
    assert (tmp_path / "out/classify.png").exists()
    assert "nan" not in done.stdout


def test_a_change_that_cannot_be_explained(cam, tmp_path, breaking):
    breaking("camcli.analysis.explain.changes._change")
    done = cam("classify --rpm 735:745 --points 2 --explain --no-plot -o out", code=1)
    told(done, tmp_path / "out", "the change from 735.0 to 745.0 rpm")
    record = json.loads((tmp_path / "out/run.json").read_text())["result"]
    assert [change["cause"] for change in record["changes"]] == ["unexplained"]


def test_a_block_of_cells(cam, tmp_path, breaking):
    line = "basins --rpm 700 --cells 40,40"
    cam(line, "-o whole --no-plot", code=0)
    breaking(
        "camcli.analysis.basins.cell_batches._Task._followed",
        lambda task, gap, rate, mode: len(gap) < 1024 and task.count > 1024,
    )
    done = cam(line, "-o out", code=1)
    found, whole = rows(tmp_path / "out/basins.csv"), rows(tmp_path / "whole/basins.csv")
    (fault,) = faults_of(tmp_path / "out")
    lost = int(fault["pieces"][0].split()[0])
    assert re.fullmatch(
        r"\d+ cells at 700 rpm, from [\d.e-]+ m above the cam on", fault["pieces"][0]
    )
    differ = [a["attractor"] for a, b in zip(found, whole, strict=True) if a != b]
    assert 0 < len(differ) == lost < 1024
    assert set(differ) == {"-7"}
    assert f"fault in {lost} cells" in done.stderr
    attractors = {row["label"]: row for row in rows(tmp_path / "out/attractors.csv")}
    assert attractors["fault"]["attractor"] == "-7"
    assert float(attractors["fault"]["fraction"]) > 0.0
    assert (tmp_path / "out/basins.png").exists()


def test_a_speed_of_basins(cam, tmp_path, breaking):
    line = "basins --rpm 690:710 --points 3 --cells 8,8 --exponents"
    cam(line, "-o whole --no-plot", code=0)
    breaking("camcli.analysis.basins.study.entropies", lambda codes: calls() == 2)
    count = [0]

    def calls():
        count[0] += 1
        return count[0]

    done = cam(line, "-o out", code=1)
    told(done, tmp_path / "out", "rpm = 700.0")
    found, whole = rows(tmp_path / "out/attractors.csv"), rows(tmp_path / "whole/attractors.csv")
    (bad,) = [row for row in found if row["rpm"] == "700.0"]
    assert (bad["label"], bad["attractor"], bad["fraction"]) == ("fault", "-7", "1.0")
    assert but(tmp_path / "out", "attractors.csv", "rpm", "700.0") == [
        row for row in whole if row["rpm"] != "700.0"
    ]
    assert (tmp_path / "out/basins.png").exists()


def test_a_part_of_basins(cam, tmp_path, breaking):
    for name in ("uncertainty", "boundary_saddles", "largest_exponent"):
        breaking(f"camcli.analysis.basins.study.{name}")
    options = "--boundary --saddles --exponents"
    done = cam(f"basins --rpm 700 --cells 8,8 {options} --no-plot -o out", code=1)
    pieces = [piece for fault in faults_of(tmp_path / "out") for piece in fault["pieces"]]
    assert pieces[:2] == ["the boundary at rpm = 700.0", "the saddles at rpm = 700.0"]
    assert all(piece.startswith("the exponent of P(") for piece in pieces[2:])
    assert len(rows(tmp_path / "out/basins.csv")) == 64
    assert "Traceback" not in done.stderr


def test_a_branch_of_orbits(cam, tmp_path, breaking):
    line = "orbits --rpm 690:720 --points 5 --set run.transient=50 --set orbits.starts=2"
    cam(line, "-o whole --no-plot", code=0)
    breaking("camcli.analysis.orbits.branch_segment._advance", lambda *_: calls() == 3)
    count = [0]

    def calls():
        count[0] += 1
        return count[0]

    done = cam(line, "-o out", code=1)
    (fault,) = faults_of(tmp_path / "out")
    assert fault["pieces"][0].startswith("the branch of 1 impact in 1 turn from ")
    found = json.loads((tmp_path / "out/run.json").read_text())["result"]["branches"]
    assert "fault" in found[0]["ends"]
    ours, whole = rows(tmp_path / "out/branch.csv"), rows(tmp_path / "whole/branch.csv")
    kept, all_of_it = (
        [row["rpm"] for row in table if row["branch"] == "1"] for table in (ours, whole)
    )
    assert 1 < len(kept) < len(all_of_it)  # what was found up to there is kept
    assert set(kept) <= set(all_of_it)
    assert "fault on branch 1" in done.stderr
    assert (tmp_path / "out/orbits.png").exists()


@pytest.mark.parametrize(
    ("place", "options"),
    [
        ("camcli.analysis.orbits.search.identify", ""),
        ("camcli.analysis.orbits.search.single_impact_roots", ""),
        ("camcli.analysis.orbits.study.both_ways", ""),
        ("camcli.analysis.orbits.proofs.prove_orbit", "--prove"),
        ("camcli.api.orbits.remarks", ""),
        ("camcli.api.orbit_tables.bifurcation_row", "--rpm 720:745"),
        ("camcli.analysis.orbits.study.doubled", "--rpm 720:745"),
        ("camcli.analysis.orbits.study.curve",
         "--rpm 735:745 --curve period-doubling --in restitution"),
    ],
)  # fmt: skip
def test_whatever_fails_in_orbits_costs_no_file_of_the_rest(
    cam, tmp_path, breaking, place, options
):
    few = "--points 5 --no-plot --set run.transient=50 --set orbits.starts=1"
    line = (
        f"orbits {options} {few}" if "--rpm" in options else f"orbits --rpm 690:720 {options} {few}"
    )
    breaking(place)
    done = cam(line, "-o out", code=1)
    assert faults_of(tmp_path / "out"), done.stderr
    assert "Traceback" not in done.stderr
    assert rows(tmp_path / "out/branch.csv") or "both_ways" in place or "search" in place


def test_detach_loses_a_speed_a_force_curve_or_a_region(cam, tmp_path, breaking):
    line = "detach --rpm 110:200 --points 4 --hold-to 150"
    cam(line, "-o whole --no-plot", code=0)
    breaking("camcli.analysis.contact_loss.bursts._bursts", lambda _, orbit, __: slow(orbit, 110.0))
    breaking("camcli.analysis.contact_loss.study.lift_off")
    breaking("camcli.analysis.contact_loss.study.loads_of", lambda _, rpm, __: rpm == 200.0)
    breaking("camcli.analysis.contact_loss.force.Force.curve", lambda _, rpm, **__: rpm == 200.0)
    breaking("camcli.analysis.contact_loss.study.hold_to")
    done = cam(line, "-o out", code=1)
    pieces = [piece for fault in faults_of(tmp_path / "out") for piece in fault["pieces"]]
    for name in ("rpm = 110.0", "the chatter from region", "the motion at 200.0 rpm, past",
                 "the contact force at 200 rpm", "the springs that hold to 150 rpm"):  # fmt: skip
        assert any(piece.startswith(name) for piece in pieces), (name, pieces)
    found, whole = rows(tmp_path / "out/speeds.csv"), rows(tmp_path / "whole/speeds.csv")
    assert [row["status"] for row in found] == ["ok"] * (len(whole) - 1) + ["fault"]
    assert found[:-1] == whole[:-1]
    assert "Traceback" not in done.stderr
    assert (tmp_path / "out/detach.png").exists()


def slow(orbit, rpm):
    return abs(orbit.omega - rpm * 3.141592653589793 / 30.0) < 1e-9


def test_a_machine_within_the_tolerances(cam, tmp_path, breaking):
    line = "detach --rpm 110:130 --points 2 --no-plot --tolerance follower.mass=5%"
    few = "--set detach.machines=6"
    cam(line, few, "-o whole", code=0)
    count = [0]

    def second(*_):
        count[0] += 1
        return count[0] == 2

    breaking("camcli.api.tolerances.first_loss", second)
    cam(line, few, "-o out --threads 1", code=1)
    found, whole = rows(tmp_path / "out/tolerance.csv"), rows(tmp_path / "whole/tolerance.csv")
    assert found[1]["first_detachment_rpm"] == ""
    assert [found[0], *found[2:]] == [whole[0], *whole[2:]]
    (fault,) = faults_of(tmp_path / "out")
    assert fault["pieces"][0].startswith("the machine with follower.mass = 1.28")
    record = json.loads((tmp_path / "out/run.json").read_text())
    assert any("in the worst" in text.lower() for text in record["verdict_details"])


def test_a_motion_of_the_page(cam, tmp_path, breaking):
    line = f"explore --rpm 690:710 --points 3 {FEW.replace('--no-plot', '')}"
    breaking("camcli.api.explore.simulate", lambda _, rpm, *__, **___: rpm == 700.0)
    done = cam(line, "-o out --set orbits.starts=1", code=1)
    pieces = [piece for fault in faults_of(tmp_path / "out") for piece in fault["pieces"]]
    assert pieces
    assert all(piece.startswith("the motion ") and "at 700 rpm" in piece for piece in pieces)
    assert (tmp_path / "out/explore.html").stat().st_size > 50_000
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("part", ["orbits", "sweep", "basins"])
def test_a_part_of_the_page(cam, tmp_path, breaking, part):
    line = f"explore --rpm 690:710 --points 3 --with basins {FEW.replace('--no-plot', '')}"
    few = "--set orbits.starts=1 --set basins.cells=[8,8]"
    first = [True]

    def once(*_, **__):
        return part != "sweep" or bool(first and first.pop())

    breaking(f"camcli.api.explore.{part}", once)
    cam(line, few, "-o out", code=1)
    (fault,) = faults_of(tmp_path / "out")
    assert fault["pieces"] == ["sweep fixed" if part == "sweep" else part]
    assert (tmp_path / "out/explore.html").stat().st_size > 50_000


FIGURE = """
figure: {{title: "A figure", command: sweep, shows: "a test"}}
follower: {{mass: 1.221, stiffness: 1430.8, restitution: 0.8}}
cam: {{kind: eccentric, base: 0.05, lift: 0.02}}
run: {{transient: 2, record: 2}}
sweep: {{rpm: {{start: {0}, stop: 720, num: 3}}, sections: [strobe]}}
"""


@pytest.mark.slow
def test_a_figure(cam, tmp_path, breaking):
    (tmp_path / "scenes").mkdir()
    for name, start in (("1.1", 690), ("1.2", 700)):
        (tmp_path / "scenes" / f"{name}.yaml").write_text(FIGURE.format(start))
    breaking("camcli.cli.figures.digest", lambda _, found: found["ranges"][0]["from_rpm"] == 690)
    done = cam("figures --folder scenes -o out", code=1)
    assert "fault: 1.1: ZeroDivisionError: nobody foresaw this" in done.stderr
    assert "Traceback" not in done.stderr
    (fault,) = json.loads((tmp_path / "out/faults.json").read_text())
    assert "Traceback" in fault["traceback"]
    assert not (tmp_path / "out/1.1/figure.json").exists()  # not finished: computed again
    assert (tmp_path / "out/1.2/figure.json").exists()
    assert "1.2" in (tmp_path / "out/index.html").read_text()
    breaking("camcli.cli.figures.digest", lambda *_: False)


@pytest.mark.slow
def test_a_comparison_and_an_entry_of_a_figure(cam, tmp_path, breaking):
    (tmp_path / "scenes").mkdir()
    for name, start in (("1.1", 690), ("1.2", 700)):
        (tmp_path / "scenes" / f"{name}.yaml").write_text(FIGURE.format(start))
    cam("figures --folder scenes -o out --update-reference", code=0)
    breaking("camcli.cli.figures.compared", lambda figure, state: figure.name == "1.1")
    breaking("camcli.cli.figures.caption", lambda *_: True)
    done = cam("figures --folder scenes -o out --check", code=1)
    pieces = [
        p for f in json.loads((tmp_path / "out/faults.json").read_text()) for p in f["pieces"]
    ]
    assert "the comparison of 1.1" in pieces
    assert "the entry of 1.2 in index.html" in pieces
    assert (tmp_path / "out/1.1/figure.json").exists()
    assert "Traceback" not in done.stderr


def test_a_point_of_the_bench(cam, tmp_path, breaking):
    few = "--set bench.cases=[periodic] --set bench.methods=[core] --no-plot"
    count = [0]

    def first(*_):
        count[0] += 1
        return count[0] == 1

    breaking("camcli.analysis.bench.precision.compare", first)
    done = cam(f"bench precision --quick {few} -o out", code=1)
    found = rows(tmp_path / "out/precision.csv")
    assert found[0]["status"] == "fault"
    assert {row["status"] for row in found[1:]} == {"ok"}
    assert "fault: precision: periodic, core" in done.stderr


def test_a_curve_with_a_fault_costs_itself_alone(cam, tmp_path, breaking):
    breaking("camcli.analysis.orbits.atlas.curve", lambda *a: a[1].kind == "period-doubling")
    words = "--rpm 660:760 --vary follower.restitution=0.6:0.9 --points 2,2 --set run.record=30"
    done = cam(
        "sweep",
        words,
        "--set run.transient=100 --set orbits.branches=0 --curves auto --no-plot -q -o out",
        code=1,
    )
    assert "the curve of the period-doubling at" in done.stderr
    kinds = {row["kind"] for row in rows(tmp_path / "out" / "curves.csv")}
    assert kinds == {"corner-impact"}
    assert len(rows(tmp_path / "out" / "map.csv")) == 4


def test_a_fault_of_a_run_that_is_made_again_names_a_record_only_where_one_is_left(
    cam, tmp_path, breaking
):
    """Of `cam rerun` only the folder of -o is left."""
    cam(f"sweep --rpm 680:720 --points 3 {FEW} -o sound", code=0)
    breaking("camcli.analysis.motion_at_speed.loads_of", at_speed(700.0))
    done = cam("rerun sound", code=1)
    assert "fault: rpm = 700.0: ZeroDivisionError" in done.stderr
    last = "this is a fault of camcli and cost these pieces alone, please report it"
    assert done.stderr.splitlines()[-1] == last
    done = cam("rerun sound -o again", code=1)
    assert done.stderr.splitlines()[-1] == (f"{last} with again/run.json, which has the traceback")
    assert faults_of(tmp_path / "again")[0]["pieces"] == ["rpm = 700.0"]
