"""A branch.csv or curve.csv of a stranger: finite numbers, no more than can be drawn, or exit 2."""

from __future__ import annotations

import tracemalloc

import pytest

from camcli.api import orbit_tables as api
from camcli.errors import SceneError
from tests.conftest import refused

BRANCH = "branch,label,rpm,stable,theta_deg_1,theta_deg_2,q_m\n"
CURVE = "curve,kind,label,rpm,restitution\n"
ROWS = "1,P(1;1),690,1,10,,1\n1,P(1;1),700,0,11,,1.5\n2,P(1;1),700,0,11,12,1.5\n"
POINTS = "1,fold,P(1;1),690,0.7\n1,fold,P(1;1),700,0.8\n"
TURNS = "--set run.transient=1 --set run.record=2"
SWEEP = f"sweep --rpm 690:700 --points 2 {TURNS} --branches table.csv"
MAP = f"sweep --rpm 690:700 --vary follower.restitution=0.7:0.8 --points 2 {TURNS}"


def test_tables_of_orbits_are_read(cam, tmp_path):
    (tmp_path / "table.csv").write_text(BRANCH + ROWS)
    first, second = api.read_branches(tmp_path / "table.csv", "rpm")
    assert (list(first.values), first.stable, list(first.q)) == (
        [690, 700],
        [True, False],
        [1, 1.5],
    )
    assert [list(column) for column in second.phases] == [[11], [12]]
    assert first.phases[1][0] != first.phases[1][0]  # no second impact
    cam(SWEEP, code=0)
    (tmp_path / "curve.csv").write_text(CURVE + POINTS)
    cam(MAP, "--curves curve.csv", code=0)


@pytest.mark.parametrize("bad", ["inf", "-inf", "nan", "1e400", "x", "1 2", "\x1b"])
@pytest.mark.parametrize("old", ["690", "10", "1.5"])
def test_a_number_that_is_none_is_named_with_its_line(cam, tmp_path, old, bad):
    (tmp_path / "table.csv").write_text(BRANCH + ROWS.replace(old, bad, 1))
    line = 3 if old == "1.5" else 2
    refused(cam(SWEEP, "--no-plot"), f"table.csv:{line}:")


@pytest.mark.parametrize(
    "text",
    ["", "\n", BRANCH, "branch,rpm\n1,700\n", BRANCH + "1,P(1;1)\n", BRANCH + '1,"\n' * 3,
     BRANCH + "1," + "9" * 200_000 + ",690,1,10,,1\n", "x\n" * 1000],
)  # fmt: skip
def test_what_is_no_table_of_orbits_is_refused(cam, tmp_path, text):
    (tmp_path / "table.csv").write_text(text)
    done = cam(SWEEP, "--no-plot")
    if text == BRANCH:
        assert done.returncode == 0  # no branch was found: nothing is drawn
    else:
        refused(done, "table.csv")


@pytest.mark.parametrize("bad", ["inf", "nan", "x"])
def test_the_same_of_curves(cam, tmp_path, bad):
    (tmp_path / "table.csv").write_text(CURVE + POINTS.replace("0.8", bad))
    refused(cam(MAP, "--curves table.csv --no-plot"), "--curves: table.csv:3: ")


def test_more_than_can_be_drawn_is_not_read_into_memory(cam, tmp_path):
    """A file of 100 MB took 3.4 GB, and five minutes to draw."""
    path = tmp_path / "table.csv"
    path.write_text(BRANCH + "".join(f"{n},P(1;1),{n},1,10,,1\n" for n in range(1, 6000)))
    refused(cam(SWEEP), "more than 5000 lines")
    wide = ",".join(f"theta_deg_{n}" for n in range(3, 3000))
    path.write_text(f"{BRANCH.strip()},{wide}\n" + f"1,x,690,1,10,,1{',' * 2997}\n" * 2000)
    size = path.stat().st_size
    tracemalloc.start()
    with pytest.raises(SceneError, match="1000000 numbers"):
        api.read_branches(path, "rpm", 1_000_000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * 1_000_000 + 4 * size
    path.write_text(CURVE + "".join(f"{n},fold,P(1;1),690,0.7\n" for n in range(6000)))
    refused(cam(MAP, "--curves table.csv"), "more than 5000 lines")


@pytest.mark.parametrize("missing", [0, 1, 2, 3])
def test_a_branch_of_one_s_own_needs_four_columns_and_a_missing_one_is_named(
    cam, tmp_path, missing
):
    names = ["rpm", "stable", "theta_deg", "q_m"]
    (tmp_path / "table.csv").write_text(",".join(names) + "\n690,1,150,0.2\n700,0,151,0.21\n")
    (one,) = api.read_branches(tmp_path / "table.csv", "rpm")
    assert (list(one.values), one.stable, list(one.q)) == ([690, 700], [True, False], [0.2, 0.21])
    assert [list(column) for column in one.phases] == [[150, 151]]
    kept = [name if k != missing else "other" for k, name in enumerate(names)]
    (tmp_path / "table.csv").write_text(",".join(kept) + "\n690,1,150,0.2\n")
    refused(cam(SWEEP), f"found no column {names[missing]}, expected a branch.csv in rpm")
