"""cam sweep --lyapunov and --explain as a shell sees them."""

import json
import re
from functools import partial
from math import inf, log

import pytest

from camcli.analysis.explain.crisis import find_crisis
from camcli.analysis.explain.tangency import Sampling
from tests.conftest import rows

SMALL = "--set run.transient=200 --set run.record=130"


def exponents(path):
    return [row["lyapunov_per_period"] for row in rows(path)]


@pytest.mark.parametrize(
    "words", [("--set", "sweep.lyapunov=true"), ("--lyapunov", "--set", "sweep.sections=[strobe]")]
)
def test_the_exponent_of_an_impact_per_turn_is_ln_r(cam, tmp_path, words):
    cam("sweep --rpm 690:700 --points 2 --no-plot", *words)
    found = exponents(tmp_path / "out/sweep/speeds.csv")
    assert [float(x) for x in found] == pytest.approx([log(0.8)] * 2, abs=1e-12)
    assert (tmp_path / "out/sweep/impacts.csv").exists() == ("--lyapunov" not in words)


def test_rest_is_minus_infinity_and_chaos_positive(cam, tmp_path):
    path = tmp_path / "out/sweep/speeds.csv"
    words = f"sweep --lyapunov --no-plot {SMALL} --points 2"
    resting = cam(f"{words} --rpm 100:190")
    assert [float(x) for x in exponents(path)] == [-inf, -inf]
    assert re.search(r"^P\(1;inf\) +190 +190 +1 +-inf +ok$", resting.stdout, re.MULTILINE)
    cam(f"{words} --rpm 745:750")
    assert min(float(x) for x in exponents(path)) > 0.2
    cam(f"{words} --rpm 745:750 --set run.record=3")
    assert min(float(x) for x in exponents(path)) > 0.2  # of the turns after such a short record


@pytest.mark.slow
def test_without_the_flags_the_column_is_empty_and_all_else_the_same(cam, tmp_path):
    """And a corners.csv of an earlier run with --explain does not stay."""
    words = f"sweep --rpm 690:750 --points 3 --no-plot {SMALL}"
    for folder, more in (("more", ("--lyapunov",)), ("bare", ("--set", "sweep.explain=true"))):
        assert cam(words, *more, "-o", folder).returncode == 0
    assert (tmp_path / "bare/corners.csv").exists()
    assert cam(f"{words} -o bare").returncode == 0
    assert not (tmp_path / "bare/corners.csv").exists()
    assert set(exponents(tmp_path / "bare/speeds.csv")) == {""}
    assert "" not in exponents(tmp_path / "more/speeds.csv")
    for name in ("impacts.csv", "strobe.csv"):
        assert (tmp_path / "bare" / name).read_bytes() == (tmp_path / "more" / name).read_bytes()


@pytest.mark.ci
@pytest.mark.slow
def test_events_and_changes_of_a_range_are_listed_with_their_causes(cam, tmp_path, monkeypatch):
    """Corner impacts, a doubling and a crisis, on two threads.

    The crisis with a coarse sample of folds: the fine ones are those of the figures and a soak.
    """
    coarse = partial(find_crisis, sampling=Sampling(starts=500, searches=3, solved=4))
    monkeypatch.setattr("camcli.analysis.explain.changes.find_crisis", coarse)
    done = cam("sweep --rpm 670:742 --points 7 --explain --threads 2 -o .", code=0)
    for said in ("Critical speeds of attractors", "739.3197802", "Changes of the diagram"):
        assert said in done.stdout
    record = json.loads((tmp_path / "run.json").read_text())["result"]
    found = [(e["kind"], e["label"], e["corner"]) for e in record["events"]]
    assert found == [
        ("corner-impact", "P(1;1)", "b"),
        ("boundary-crisis", "chaos, P(1;1)", "b"),
        ("period-doubling", "P(1;1)", ""),
        ("corner-impact", "P(2;1:1)", "c"),
    ]
    published = [673.2344450038, 682.2048, 739.3197802160, 739.3779296493]
    for event, rpm in zip(record["events"], published, strict=True):
        assert abs(event["rpm"] - rpm) < max(event["error"], 1e-10) < 2e-3
    causes = [(c["before"], c["after"], c["cause"]) for c in record["changes"]]
    assert causes == [
        ("aperiodic", "P(1;1)", "boundary-crisis"),
        ("P(1;1)", "aperiodic", "period-doubling+corner-impact"),
    ]
    assert "meets the stable manifold of P(1;1)" in record["changes"][0]["words"]
    classes = {row["classification"] for row in rows(tmp_path / "corners.csv")}
    assert classes >= {"nonsmooth-fold", "border-period-doubling"}
    assert (tmp_path / "sweep.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.ci
@pytest.mark.slow
def test_a_crisis_beside_an_undecided_motion_is_explained(cam, tmp_path, monkeypatch):
    """The motion from rest at 361.192 rpm has no name; the crisis is the figure's jump.

    The fold that touches first is among the few lowest, so the others are not looked for here.
    """
    few = partial(find_crisis, sampling=Sampling(starts=500, searches=1, solved=2))
    monkeypatch.setattr("camcli.analysis.explain.changes.find_crisis", few)
    words = "--rpm 361.1:361.192 --points 2 --explain --no-plot"
    cam(f"sweep {words} --set run.transient=300 --set run.record=130", code=0)
    record = json.loads((tmp_path / "out/sweep/run.json").read_text())["result"]
    (change,), (event,) = record["changes"], record["events"]
    assert (change["after"], change["cause"]) == ("undecided", "interior-crisis")
    assert abs(event["rpm"] - 361.1673134) < event["error"] < 2e-3
    assert "P(3;3:3:2) (larger multiplier 35.9" in change["words"]
