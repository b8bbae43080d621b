"""What sweep, classify, orbits and basins print, against the tables of the same run.

The columns of these tables are judged in `test_columns`; a printed number is held to half a unit of
its last digit.
"""

from __future__ import annotations

import json
import re
from itertools import groupby

import numpy as np
import pytest
from conftest import cam_in, rows

from tests.truth.test_worked_valve import near, table

pytestmark = pytest.mark.slow
RUN = "--set run.transient=100 --set run.record=60 --no-plot -o out --rpm 700:745"


def screen(folder, line):
    """(screen, folder of the artefacts, record) of a command; the line of cost is judged here."""
    said = cam_in(folder, line, code=0).stdout
    record = json.loads((folder / "out/run.json").read_text())
    cost = record["cost"]
    last = re.fullmatch(r"(\d+) impacts in (\S+) s \((\S+)/s, (\S+) gap evaluations each\); error "
                        r"of each event: contact within (\S+) m, end of a chatter within (\S+) "
                        r"turn",
                        said.splitlines()[-1])  # fmt: skip
    assert int(last[1]) == cost["impacts"]
    assert near(last[2], cost["seconds"])
    assert float(last[3]) == pytest.approx(cost["impacts"] / cost["seconds"], rel=0.01)
    assert near(last[4], cost["gap_evaluations"] / cost["impacts"])
    assert float(last[6]) == record["error"]["accumulation_phase_turns"]
    return said, folder / "out", record["result"]


def ranges(found, *keys):
    """Neighbouring rows that are alike in some columns."""
    return [list(group) for _, group in groupby(found, lambda row: [row[key] for key in keys])]


@pytest.mark.parametrize(
    ("rpm", "repeats"),
    [
        (700, 1),
        pytest.param(190, 1, marks=pytest.mark.ci),
        pytest.param(360, 6, marks=pytest.mark.ci),
    ],
)
def test_simulate(rpm, repeats, tmp_path):
    """The last events of the period that repeats, each value in its own column."""
    run = "--set run.transient=400 --set run.record=9 --no-plot -o out"
    said = cam_in(tmp_path, f"simulate {run} --rpm {rpm}", code=0).stdout
    found = rows(tmp_path / "out/events.csv")
    last = max(int(row["period"]) for row in found)
    period = [row for row in found if int(row["period"]) > last - repeats][-12:]
    shown = table(said, f"{rpm} rpm: P({repeats};")
    assert len(shown) == len(period)
    for (event, turn, theta, before, after), row in zip(shown, period, strict=True):
        assert (event, turn) == (row["event"], row["period"])
        assert abs(float(theta) - float(row["theta_deg"])) < 0.6e-4
        assert near(before, float(row["u_minus_m_per_s"]), 4)
        assert near(after, float(row["u_plus_m_per_s"]), 4)


def test_sweep(tmp_path):
    said, out, _ = screen(tmp_path, f"sweep {RUN} --points 4")
    speeds = rows(out / "speeds.csv")
    groups = ranges(speeds, "label", "status")
    shown = table(said, f"{len(speeds)} speeds, {len(groups)} ranges of one label")
    assert len(shown) == len(groups) > 1
    for (label, _, low, high, count, status), group in zip(shown, groups, strict=True):
        assert (label, status) == (group[0]["label"], group[0]["status"])
        assert (float(low), float(high)) == (float(group[0]["rpm"]), float(group[-1]["rpm"]))
        assert int(count) == len(group)
    record = json.loads((out / "run.json").read_text())
    gap, impact, theta, lift = re.search(
        r"from 700 to 745 rpm, it flies (\S+) m and lands at (\S+) m/s at most\. The hardest "
        r"landing is at (\S+) deg, (\S+) m above its lowest\.",
        " ".join([*record["verdict"], *record["verdict_details"]]),
    ).groups()
    hardest = max(speeds, key=lambda row: float(row["max_impact_m_per_s"]))
    assert near(impact, float(hardest["max_impact_m_per_s"]))
    assert near(theta, float(hardest["landing_deg"]))
    assert near(lift, float(hardest["landing_lift_m"]))
    assert near(gap, max(float(row["max_gap_m"]) for row in speeds))


def test_classify(tmp_path):
    said, out, result = screen(tmp_path, f"classify {RUN} --points 3 --verbose")
    found = rows(out / "classify.csv")
    groups = ranges([{**row, "of": k} for k, row in enumerate(found)], "label", "chatter")
    shown = table(said, f"{len(found)} motions, {len(groups)} ranges of one label")
    assert len(shown) == len(groups) > 1
    for (label, low, high, impacts, exponent, chatter, transient), group in zip(
        shown, groups, strict=True
    ):
        motions = [result["motions"][row["of"]] for row in group]
        assert (label, chatter) == (group[0]["label"], group[0]["chatter"])
        assert (float(low), float(high)) == (float(group[0]["rpm"]), float(group[-1]["rpm"]))
        assert near(impacts, float(group[0]["impacts"]))
        value, _, error = exponent.partition(" +- ")
        assert len(group) > 1 or near(value, float(group[0]["lyapunov_per_period"]))
        assert near(value, max(float(row["lyapunov_per_period"]) for row in group))
        errors = [motion["exponents"]["standard_error"] for motion in motions]
        assert near(error, max(errors)) if error else max(errors) == 0.0
        turns = [motion["transient_turns"] for motion in motions]
        known = [n for n in turns if n is not None]
        wanted = f"{min(known)} to {max(known)}" if known and min(known) < max(known) else known
        assert transient == (wanted if isinstance(wanted, str) else str(*wanted[:1]) or "-")


def test_orbits(tmp_path):
    said, out, result = screen(tmp_path, f"orbits {RUN} --points 5 --verbose")
    branch, events = rows(out / "branch.csv"), rows(out / "bifurcations.csv")
    shown = table(said, "Periodic orbits at 700 rpm")
    assert len(shown) == len(result["orbits"])
    for (label, stable, theta, *_), orbit in zip(shown, result["orbits"], strict=True):
        assert label == orbit["label"]
        assert stable == ("yes" if orbit["stable"] else "no")
        assert all(near(x, y, 8) for x, y in zip(theta.split(), orbit["theta_deg"], strict=True))
    shown = table(said, "Branches in rpm")
    groups = ranges(branch, "branch")
    assert len(shown) == len(groups)
    told = result["branches"]
    for (number, labels, low, high, stable, turns, _, count), group, branch_told in zip(
        shown, groups, told, strict=True
    ):
        ends = [f"{x:.7g} to {y:.7g}" for x, y in branch_told["stable_ranges"]]
        assert stable == (", ".join(ends) or "nowhere")
        assert turns == (", ".join(f"{x:.7g}" for x in branch_told["turning_points"]) or "-")
        assert number == group[0]["branch"]
        assert labels.split(", ") == sorted({row["label"] for row in group})
        assert near(low, float(group[0]["rpm"]), 7)
        assert near(high, float(group[-1]["rpm"]), 7)
        assert int(count) == len(group)
    shown = table(said, "Bifurcations")
    assert len(shown) == len(events) > 1
    for (number, label, kind, rpm, *_), event in zip(shown, events, strict=True):
        at = f" at {event['corner']}" * bool(event["corner"])
        wanted = event["branch"], event["label"], event["kind"] + at
        assert (number, label, kind) == wanted
        assert near(rpm, float(event["rpm"]), 13)
    largest = max(float(row["det"]) for row in branch)
    (det,) = re.findall(r"is at most (\S+) on these branches", said.replace("\n", " "))
    assert near(det, largest)


def test_basins(tmp_path):
    line = "basins --cells 20,12 --refine 1 --no-plot --verbose -o out"
    said, out, result = screen(tmp_path, line)
    (speed,), found = result["speeds"], rows(out / "attractors.csv")
    shown = table(said, "358.5 rpm")
    assert len(shown) == len(found) > 1
    for (label, number, q, v, share), row in zip(shown, found, strict=True):
        assert (label, number) == (row["label"], row["attractor"])
        assert near(q, float(row["q_m"]), 9)
        assert near(v, float(row["v_m_per_s"]), 9)
        part, error = share.rstrip(" %").split(" +- ")
        assert near(part, 100.0 * float(row["fraction"]))
        assert near(error, 100.0 * float(row["standard_error"]))
    cells, computed, share, median, most99, most = re.search(
        r"cells (\d+), computed (\d+) \((\S+) %\); turns per cell: median (\d+), 99 % (\d+), "
        r"most (\d+)",
        said,
    ).groups()
    assert (int(cells), int(computed)) == (speed["cells"], speed["computed"])
    assert cells == "960"
    assert near(share, 100.0 * int(computed) / int(cells))
    assert [int(median), int(most99), int(most)] == list(speed["turns_per_cell"].values())
    basin, boundary, some, boxes = re.search(
        r"basin entropy (\S+), boundary entropy (\S+) \((\d+) of (\d+) boxes of 5 x 5 cells\)", said
    ).groups()
    assert near(basin, speed["basin_entropy"])
    assert near(boundary, speed["boundary_entropy"])
    assert (int(some), int(boxes)) == (speed["boundary_boxes"], speed["boxes"])
    assert float(basin) == pytest.approx(float(boundary) * int(some) / int(boxes), rel=1e-3)


def test_basins_over_a_range(tmp_path):
    line = "basins --rpm 358:359 --points 2 --cells 16 --no-plot -o out"
    said, out, result = screen(tmp_path, line)
    found = ranges(rows(out / "attractors.csv"), "rpm")
    shown = table(said, "2 speeds")
    for (rpm, words, undecided), group, speed in zip(shown, found, result["speeds"], strict=True):
        assert float(rpm) == float(group[0]["rpm"])
        assert int(undecided) == speed["undecided"]
        parts = re.findall(r"(\d+): (\S+) (\S+) %", words)
        assert len(parts) == len(group)
        for (number, label, share), row in zip(parts, group, strict=True):
            assert (number, label) == (row["attractor"], row["label"])
            assert near(share, 100.0 * float(row["fraction"]))


def printed_pair(text):
    """Two multipliers in print: a, b or a +- b i."""
    if " +- " in text:
        real, imaginary = map(float, text.removesuffix(" i").split(" +- "))
        return [complex(real, imaginary), complex(real, -imaginary)]
    return [float(x) for x in text.split(", ")]


def is_pair(text, trace, det):
    """Whether the numbers in print have this sum and this product."""
    one, other = printed_pair(text)
    return one + other == pytest.approx(trace, abs=1e-7) and one * other == pytest.approx(
        det, abs=1e-7
    )


def side_of(text, values):
    """A side of an inequality in print: sums and products of tau_L, delta_R, ..."""
    formula = text.replace(")(", ")*(").replace("l1 tau", "l1*tau").replace("l1^2 (", "l1**2*(")
    return eval(formula, {}, values)


@pytest.mark.parametrize(
    ("left", "right"),
    [((1.64, 0.64), (1.36, 0.63)), ((0.3, 0.2), (-1.9, 0.5)), ((1.4, 0.3), (-2.5, 0.2)),
     ((-0.5, 0.1), (1.6, 0.2)), ((0.5, -0.1), (0.4, -0.3))],
)  # fmt: skip
def test_border_collision(tmp_path, left, right):
    """Each inequality as its own words have it; fixed points x = mu/(1 - tau + delta); cycle LR."""
    (tl, dl), (tr, dr) = left, right
    said = cam_in(tmp_path, f"classify --trace={tl},{tr} --det={dl},{dr} -o out", code=0).stdout
    record = json.loads((tmp_path / "out/border_collision.json").read_text())
    shown = table(said, f"Border collision: {record['kind']}")
    for (name, trace, det, pair, kind), side, (tau, delta) in zip(
        shown, "LR", (left, right), strict=True
    ):
        assert (name, float(trace), float(det)) == (side, tau, delta)
        assert is_pair(pair, tau, delta)
        told = record["sides"][side]
        assert kind == told["kind"]
        assert told["stable"] == (max(map(abs, printed_pair(pair))) < 1.0)
    values = {"tau_L": tl, "tau_R": tr, "delta_L": dl, "delta_R": dr}
    shown = table(said, "Inequalities")
    assert len(shown) >= 8
    for (words, low, high, holds), told in zip(shown, record["inequalities"], strict=True):
        assert words == told["text"]
        formula, _, saddle = words.partition(", l1 > l2 the multipliers of ")
        one, way, other = re.fullmatch(r"(.*) ([<>]) (.*)", formula).groups()
        if saddle:
            upper, lower = np.sort(np.roots([1.0, -values[f"tau_{saddle}"],
                                             values[f"delta_{saddle}"]]))[::-1]  # fmt: skip
            values |= {"l1": upper, "l2": lower}
        assert near(low, told["left"])
        assert near(high, told["right"])
        if not one.startswith("log growth"):
            assert near(low, side_of(one, values))
            assert near(high, side_of(other, values))
        above = told["left"] > told["right"]
        assert holds == ("holds" if above == (way == ">") else "fails")
        assert told["holds"] == (holds == "holds")
    shown = {row[0]: row[1:] for row in table(said, "Fixed points and the 2-cycle")}
    q = 1 - (tl * tr - dl - dr) + dl * dr
    two = (1 + tr + dr) / q, (1 + tl + dl) / q  # x_L and x_R of the cycle for mu = 1
    exists = {
        "L": 1 if 1 - tl + dl < 0 else -1,  # where its x is below 0
        "R": 1 if 1 - tr + dr > 0 else -1,
        "LR": 1 if two[0] < 0 < two[1] else -1 if two[1] < 0 < two[0] else 0,
    }
    maps = {"L": left, "R": right, "LR": (tl * tr - dl - dr, dl * dr)}
    assert set(shown) == set(maps)
    for word, (where, stable, pair) in shown.items():
        assert where == {1: "parameter > 0", -1: "parameter < 0", 0: "never"}[exists[word]]
        assert is_pair(pair, *maps[word])
        assert stable == ("yes" if max(map(abs, printed_pair(pair))) < 1.0 else "no")
        told = next(one for one in record["cycles"] if one["word"] == word)
        assert (told["exists_for_mu"], told["stable"]) == (exists[word], stable == "yes")
