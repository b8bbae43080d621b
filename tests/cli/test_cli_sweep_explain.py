"""cam sweep --lyapunov and --explain as a shell sees them."""

import csv
import json
from math import inf, log

import pytest

SMALL = ("--set", "run.transient=200", "--set", "run.record=130")


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def exponents(path):
    return [row["lyapunov_per_period"] for row in rows(path)]


def test_the_exponent_of_an_impact_per_turn_is_ln_r(cam, tmp_path):
    done = cam("sweep", "--rpm", "700", "--lyapunov", "--no-plot")
    assert done.returncode == 0, done.stderr
    (found,) = exponents(tmp_path / "out/sweep/speeds.csv")
    assert float(found) == pytest.approx(log(0.8), abs=1e-12)


@pytest.mark.parametrize("words", [("--set", "sweep.lyapunov=true"), ("--lyapunov",)])
def test_without_the_impacts_section_it_is_measured_all_the_same(cam, tmp_path, words):
    section = ("--set", "sweep.sections=[strobe]")
    cam("sweep", "--rpm", "690:700", "--points", "2", "--no-plot", *section, *words)
    assert not (tmp_path / "out/sweep/impacts.csv").exists()
    found = exponents(tmp_path / "out/sweep/speeds.csv")
    assert [float(x) for x in found] == pytest.approx([log(0.8)] * 2, abs=1e-12)


def test_rest_is_minus_infinity_chaos_positive_and_the_unknown_empty(cam, tmp_path):
    path = tmp_path / "out/sweep/speeds.csv"
    words = ("sweep", "--lyapunov", "--no-plot", *SMALL, "--points", "2")
    cam(*words, "--rpm", "100:190")
    assert [float(x) for x in exponents(path)] == [-inf, -inf]
    cam(*words, "--rpm", "745:750")
    assert min(float(x) for x in exponents(path)) > 0.2
    cam(*words, "--rpm", "745:750", "--set", "run.record=3")
    assert exponents(path) == ["", ""]


def test_without_the_flag_the_column_is_empty_and_all_else_the_same(cam, tmp_path):
    words = ("sweep", "--rpm", "690:750", "--points", "4", "--no-plot", *SMALL)
    for folder, more in (("bare", ()), ("more", ("--lyapunov",))):
        assert cam(*words, *more, "-o", folder).returncode == 0
    assert set(exponents(tmp_path / "bare/speeds.csv")) == {""}
    assert "" not in exponents(tmp_path / "more/speeds.csv")
    for name in ("impacts.csv", "strobe.csv"):
        assert (tmp_path / "bare" / name).read_bytes() == (tmp_path / "more" / name).read_bytes()


@pytest.fixture(scope="module")
def explained(tmp_path_factory):
    """`cam sweep --explain --lyapunov` with one thread and with two: processes and folders."""
    import subprocess
    import sys

    folder = tmp_path_factory.mktemp("explained")
    done = [
        subprocess.run(
            [sys.executable, "-m", "camcli", "sweep", "--rpm", "660:760", "--points", "51",
             "--explain", "--lyapunov", "--threads", threads, "-o", threads],
            cwd=folder, capture_output=True, text=True, check=False,
        )
        for threads in "12"
    ]  # fmt: skip
    return done, folder


def test_the_events_of_the_default_range_are_listed(explained):
    (done, _), folder = explained
    assert done.returncode == 0, done.stderr
    assert all(rpm in done.stdout for rpm in ("739.3197802", "673.234445"))
    assert "Critical speeds of attractors" in done.stdout
    assert "Changes of the diagram" in done.stdout
    record = json.loads((folder / "1/run.json").read_text())["result"]
    found = {event["kind"]: event["rpm"] for event in reversed(record["events"])}
    assert found["period-doubling"] == pytest.approx(739.3197802, abs=1e-7)
    assert found["corner-impact"] == pytest.approx(673.2344450, abs=1e-7)
    assert {(change["before"], change["after"]) for change in record["changes"]} >= {
        ("aperiodic", "P(1;1)"),
        ("P(1;1)", "aperiodic"),
    }
    classes = {row["classification"] for row in rows(folder / "1/corners.csv")}
    assert classes >= {"nonsmooth-fold", "border-period-doubling"}
    assert (folder / "1/sweep.png").read_bytes()[:4] == b"\x89PNG"


def test_threads_change_no_byte(explained):
    _, folder = explained
    names = sorted(path.name for path in (folder / "1").iterdir() if path.name != "run.json")
    assert names == ["corners.csv", "impacts.csv", "speeds.csv", "strobe.csv", "sweep.png"]
    for name in names:
        assert (folder / "1" / name).read_bytes() == (folder / "2" / name).read_bytes()


def test_a_later_run_without_it_leaves_no_corners(cam, tmp_path):
    words = ("sweep", "--rpm", "690:700", "--points", "3", "--no-plot", *SMALL)
    path = tmp_path / "out/sweep/corners.csv"
    assert cam(*words, "--set", "sweep.explain=true").returncode == 0
    assert path.exists()
    assert cam(*words).returncode == 0
    assert not path.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--set", "sweep.direction=up"), ("sweep.direction", "found up", "expected fixed")),
        (("--set", "sweep.direction=down"), ("sweep.direction", "found down")),
        (("--rpm", "700"), ("sweep.rpm", "expected a range")),
    ],
)
def test_what_cannot_be_explained_is_refused_before_any_work(cam, tmp_path, words, said):
    done = cam("sweep", "--explain", *words)
    assert done.returncode == 2
    assert all(word in done.stderr for word in said)
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_help_names_both(cam):
    text = cam("sweep", "--help").stdout
    assert all(word in text for word in ("--lyapunov", "--explain", "corners.csv"))
