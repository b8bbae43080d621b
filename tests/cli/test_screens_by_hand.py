"""Tables on the screen of results made by hand, in which every number is another one."""

from __future__ import annotations

import json
from math import inf, nan, pi, radians
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

from camcli.cli import (
    basins,
    classify,
    detach,
    figures,
    merge,
    orbits,
    panels,
    report,
    run,
    simulate,
    sweep,
)
from camcli.cli.exit_codes import DONE, INTERNAL, INTERRUPTED, NUMERICS, USAGE
from camcli.cli.options import Request
from camcli.errors import SceneError, Status

RPM = 600.0
OMEGA = 2.0 * pi * RPM / 60.0


@pytest.fixture
def printed(monkeypatch):
    """What a module prints: its tables as (title, heads, rows, how), and its sentences."""

    def of(module) -> list:
        found: list = []

        def table(title, heads, rows, whole="", hidden=0, cut=""):
            found.append((title, list(heads), [list(row) for row in rows], (whole, hidden, cut)))

        monkeypatch.setattr(module, "table", table)
        if hasattr(module, "say"):
            monkeypatch.setattr(module, "say", lambda text, mark="": found.append(mark + text))
        return found

    return of


def motion(value, label, impacts=1.25, **more):
    own = {
        "value": value, "rpm": 2.0 * value, "label": label, "impacts": impacts, "fault": None,
        "exponents": None, "chatter": "none", "transient": None, "status": Status.OK,
    }  # fmt: skip
    return Made(**{**own, **more})


def exponents(largest, spread):
    return Made(largest=largest, spread=spread)


def test_a_row_of_classified_motions():
    """From the first to the last value; impacts and chatter of the first, exponents of all."""
    motions = [
        motion(500.25, "P(1;1)", 1.25, exponents=exponents(-0.5, 0.0), transient=40, chatter="a"),
        motion(510.5, "P(1;1)", 2.5, transient=None, chatter="b"),
        motion(520.75, "P(1;1)", 3.5, exponents=exponents(-0.25, 0.0), transient=30),
    ]
    row = ["500.25", "520.75", "1.25", "-0.5 to -0.25"]
    assert classify._range_row(motions, True, "") == ["P(1;1)", *row, "a", "30 to 40"]
    label, words, *others = classify._range_row(motions, False, "")
    assert (label, others) == ("P(1;1)", row)
    assert words != label
    for faults, impacts in (((None, "x"), "1.25"), (("x", None), "")):
        two = [motion(500.25, "P(1;1)", count, fault=one)
               for count, one in zip((1.25, 2.5), faults, strict=True)]  # fmt: skip
        assert classify._range_row(two, True, "")[3] == impacts
    lost = [motion(500.25, "P(1;1)", fault="x")]
    assert classify._range_row(lost, True, "") == [
        "P(1;1)", "500.25", "500.25", "", "", "none", ""
    ]  # fmt: skip


def test_classified_motions_on_the_screen(printed, monkeypatch):
    """A row for each run of motions of one label and status."""
    found = printed(classify)
    monkeypatch.setattr("camcli.words.classify.remarks", lambda motions, key, verbose: [key])
    motions = [
        motion(1.0, "P(1;1)"), motion(2.0, "P(1;1)"),
        motion(3.0, "P(1;1)", status=Status.UNRESOLVED),
        motion(4.0, "contact"), motion(5.0, "P(1;1)"),
    ]  # fmt: skip
    scene = Made(classify=Made(key="rpm"), cam=Made(kind="arcs"))
    result = Made(values=(motions, None), scene=scene)
    for verbose in (False, True):
        found.clear()
        classify.show(result, verbose)
        (_, heads, rows, how), words = found
        first = 1 if verbose else 2
        assert heads[first : first + 4] == ["from (rpm)", "to (rpm)", "impacts", "exponent"]
        assert heads[1] == ("from (rpm)" if verbose else "motion")
        assert [(row[0], row[first], row[first + 1]) for row in rows] == [
            ("P(1;1)", "1", "2"), ("P(1;1)", "3", "3"), ("contact", "4", "4"), ("P(1;1)", "5", "5")
        ]  # fmt: skip
        assert (how, words) == (("classify.csv", 0, "label"), "- rpm")


def test_events_and_changes_on_the_screen(printed, monkeypatch):
    found = printed(classify)
    monkeypatch.setattr(
        "camcli.words.explanations.change_line",
        lambda change, events, verbose: f"{change.cause} of {len(events)}, {verbose}",
    )
    long = "P(40;" + "1:" * 39 + "1)"
    events = [
        Made(rpm=700.125, error=2e-6, kind="corner-impact", corner="b", label="P(1;1)",
             classification="persistence"),
        Made(rpm=710.5, error=0.0, kind="fold", corner="", label=long, classification=""),
    ]  # fmt: skip
    changes = [
        Made(low=700.1234567890123, high=700.5, before="P(1;1)", after=long, cause="fold"),
        Made(low=800.0, high=800.1234567890123, before=long, after="contact", cause="x"),
    ]
    classify.show_explanation(Made(events=events, changes=changes), False)
    (_, heads, rows, how), (_, other_heads, other_rows, _), words, more = found
    cut = long[:29] + "..."
    assert heads == ["rpm", "event", "motion", "error", "class"]
    assert rows == [
        ["700.125000", "corner-impact b", "P(1;1)", "2e-06", "persistence"],
        ["710.5", "fold", cut, "0e+00", ""],
    ]
    assert how[1] == 2
    assert other_heads == ["rpm", "from", "to", "cause"]
    assert other_rows == [
        ["700.1234568 - 700.5", "P(1;1)", cut, "fold"],
        ["800 - 800.1234568", cut, "contact", "x"],
    ]  # fmt: skip
    assert (words, more) == ("- fold of 2, False", "- x of 2, False")
    found.clear()
    classify.show_explanation(Made(events=events, changes=changes), True)
    assert found[0][3][1] == 0
    assert found[2].endswith("True")


def border():
    left = Made(trace=1.5123456789012, det=0.51234567890123, multipliers=(0.5123456789012, 1.0),
                kind="saddle", stable=False)  # fmt: skip
    right = Made(
        trace=-0.25, det=0.125, multipliers=(0.1 - 0.25j, 0.1 + 0.25j), kind="focus", stable=True
    )
    cycles = [
        Made(word="L", exists_for=-1, stable=False, multipliers=(0.5, 1.0), points=[(1.0, 2.0)]),
        Made(
            word="RL",
            exists_for=1,
            stable=True,
            multipliers=(0.2512345678901, 0.75),
            points=[(3.0, 4.0)],
        ),
        Made(word="R", exists_for=0, stable=False, multipliers=(0.1, 0.2), points=[]),
    ]
    inequalities = [Made(left=0.5, right=1.5, holds=True), 
                    Made(left=2.5123456789, right=3.5123456789, holds=False)]  # fmt: skip
    return left, right, Made(
        kind="persistence", inequalities=inequalities, cycles=cycles, below=Made(x=1),
        above=Made(x=2),
    )  # fmt: skip


def test_a_border_collision_on_the_screen_and_in_its_file(printed, monkeypatch, capsys):
    module = "camcli.words.border_collision"
    monkeypatch.setattr(f"{module}.inequality_text", lambda one: f"{one.left} < {one.right}")
    monkeypatch.setattr(f"{module}.inequality_record", lambda one: one.left)
    monkeypatch.setattr(f"{module}.collision_words", lambda result: ["said"])
    found = printed(classify)
    left, right, result = border()
    classify._show_collision(left, right, result)
    assert found.pop() == "- said"
    sides, inequalities, cycles = (rows for _, _, rows, _ in found)
    assert [(title, heads) for title, heads, _, _ in found] == [
        ("Border collision: persistence", ["side", "trace", "det", "multipliers", "is"]),
        ("Inequalities", ["inequality", "left", "right", ""]),
        ("Fixed points and the 2-cycle", ["word", "exists for", "stable", "multipliers"]),
    ]
    assert sides == [["L", "1.512345679", "0.5123456789", "0.512345679, 1", "saddle"],
                     ["R", "-0.25", "0.125", "0.1 +- 0.25 i", "focus"]]  # fmt: skip
    assert inequalities == [
        ["0.5 < 1.5", "0.5", "1.5", "holds"],
        ["2.5123456789 < 3.5123456789", "2.51234568", "3.51234568", "fails"],
    ]
    assert cycles == [
        ["L", "parameter < 0", "no", "0.5, 1"], ["RL", "parameter > 0", "yes", "0.251234568, 0.75"],
        ["R", "never", "no", "0.1, 0.2"],
    ]  # fmt: skip
    assert capsys.readouterr().out == ""
    record = classify._record(left, right, result)
    assert record["sides"] == {
        "L": {"trace": 1.5123456789012, "det": 0.51234567890123, "kind": "saddle",
              "stable": False, "multipliers": [0.5123456789012, 1.0]},
        "R": {"trace": -0.25, "det": 0.125, "kind": "focus", "stable": True,
              "multipliers": [0.1 - 0.25j, 0.1 + 0.25j]},
    }  # fmt: skip
    assert record["cycles"][1] == {
        "word": "RL", "stable": True, "exists_for_mu": 1, "multipliers": [0.2512345678901, 0.75],
        "points": [(3.0, 4.0)],
    }  # fmt: skip
    assert [cycle["exists_for_mu"] for cycle in record["cycles"]] == [-1, 1, 0]
    assert [record[name] for name in ("kind", "inequalities", "below", "above", "words")] == [
        "persistence", [0.5, 2.5123456789], {"x": 1}, {"x": 2}, ["said"]
    ]  # fmt: skip


@pytest.mark.parametrize("verbose", [False, True])
def test_orbits_their_events_and_points_on_the_screen(printed, monkeypatch, verbose):
    found = printed(orbits)
    monkeypatch.setattr("camcli.words.codim2.meets_words", lambda point: f"meets {point.kind}")
    orbit = Made(
        label="P(2;1:1)", stable=False, theta=[radians(155.5), radians(160.25)],
        multipliers=(0.512345678, -0.25), trace=0.25, det=-0.125,
    )  # fmt: skip
    events = [
        Made(branch=2, label="P(1;1)", kind="fold", corner="", value=700.5, error=2.5e-9,
             classification=""),
        Made(branch=1, label="P(2;1:1)", kind="corner-impact", corner="b", value=710.25, error=1e-8,
             classification="persistence"),
        Made(branch=1, label="P(3;1:1:1)", kind="grazing", corner="", value=690.75, error=0.0,
             classification="x"),
    ]  # fmt: skip
    point = Made(kind="cusp", label="P(1;1)", first=700.123456789012, second=0.7512345678901,
                 curves=[2, 5])  # fmt: skip
    study = Made(
        orbits=[orbit, Made(**{**vars(orbit), "stable": True})], bifurcations=events,
        codim2=[point],
        question=Made(parameter="rpm", plane=Made(names=("rpm", "restitution"))),
    )  # fmt: skip
    orbits._show_orbits(study, "Orbits", verbose)
    orbits._show_bifurcations(study, verbose)
    orbits._show_points(study, verbose)
    of_orbits, of_events, of_points = found
    row = ["P(2;1:1)", "no", "155.5, 160.25", "0.5123457, -0.25", "0.25", "-0.125"]
    heads = ["orbit", "stable", "impacts at (deg)", "multipliers", "trace", "det"]
    assert of_orbits[:2] == ("Orbits", heads)
    assert of_orbits[2] == [row, [row[0], "yes", *row[2:]]]
    assert of_events[1] == ["branch", "orbit", "event", "rpm", "error", "class"]
    assert of_events[2] == [  # each branch by its values
        ["1", "P(3;1:1:1)", "grazing", "690.75", "0.0e+00", "x"],
        ["1", "P(2;1:1)", "corner-impact at b", "710.25", "1.0e-08", "persistence"],
        ["2", "P(1;1)", "fold", "700.5", "2.5e-09", ""],
    ]
    assert of_points[1] == ["kind", "orbit", "rpm", "restitution", "curves", "meets"]
    assert of_points[2] == [
        ["cusp", "P(1;1)", "700.123456789", "0.7512345678901", "2, 5", "meets cusp"]
    ]
    assert [how[1] for *_, how in found] == ([0, 0, 0] if verbose else [3, 2, 1])


@pytest.mark.parametrize("verbose", [False, True])
def test_branches_on_the_screen(printed, monkeypatch, verbose):
    """From the first to the last point, whichever is the larger; three of the labels."""
    found = printed(orbits)
    monkeypatch.setattr("camcli.words.orbits.stable_cell", lambda branch, events: f"in {events}")
    monkeypatch.setattr("camcli.words.orbits.turns_cell", lambda branch: f"at {branch.number}")
    points = [Made(value=value) for value in (700.12345678, 800.0, 650.5, 690.25)]
    branch = Made(number=3, labels=["a", "b", "c", "d"], points=points, ends=("one", "two"))
    study = Made(branches=[branch], bifurcations="events", question=Made(parameter="rpm"))
    orbits._show_branches(study, verbose)
    ((title, heads, rows, how),) = found
    assert title == "Branches in rpm"
    assert heads == ["branch", "labels", "from", "to", "stable", "turns at", "ends", "points"]
    ends = ["in events", "at 3", "one | two", "4"]
    assert rows == [["3", "a, b, c", "700.1235", "690.25", *ends]]
    assert how[1] == (0 if verbose else 1)


def test_basins_on_the_screen(printed, monkeypatch, capsys):
    """States in m and m/s; then cells that belong to none; of several speeds the shares alone."""
    found = printed(basins)
    monkeypatch.setattr("camcli.words.basins.grid_lines", lambda speed, verbose: ["said"])
    speed = Made(
        value=0.75, rpm=RPM, branches=[7, 4], undecided=11, attractors=[
            Made(label="P(1;1)", states=[(0.5123456789012, 0.25)]),
            Made(label="P(2;1:1)", states=[(0.125, 0.0625), (0.3, 0.4)]),
        ],
        fractions={1: (0.25, 0.0), 2: (0.5, 0.01), 0: (0.125, 0.0), -4: (0.0625, 0.0)},
    )  # fmt: skip
    scene = Made(cam=Made(kind="arcs"), basins=Made(key="run.x"))
    basins.show(Made(values=(Made(speeds=[speed]), None), scene=scene), True)
    (_, heads, rows, _) = found[0]
    assert heads == ["attractor", "no.", "q (m)", "v (m/s)", "fraction"]
    v = [f"{w * OMEGA:.9g}" for w in (0.25, 0.0625)]
    assert rows == [
        ["P(1;1)", "7", "0.512345679", v[0], "25 %"], ["P(2;1:1)", "4", "0.125", v[1], "50 +- 1 %"],
        ["undecided", "0", "", "", "12.5 %"], [Status(4).text, "-4", "", "", "6.25 %"],
    ]  # fmt: skip
    assert capsys.readouterr().out == "said\n"
    found.clear()
    later = Made(**{**vars(speed), "value": 700.1234567890123, "undecided": 3, "fractions": {
        1: (0.75, 0.0), 2: (0.125, 0.0)}})  # fmt: skip
    basins.show(Made(values=(Made(speeds=[speed, later]), None), scene=scene), True)
    (_, heads, rows, how) = found[0]
    assert heads == ["run.x", "attractors and their fractions", "undecided cells"]
    assert rows == [
        ["0.75", "7: P(1;1) 25 %, 4: P(2;1:1) 50 %", "11"],
        ["700.1234568", "7: P(1;1) 75 %, 4: P(2;1:1) 12.5 %", "3"],
    ]
    assert how[0] == "attractors.csv"


@pytest.mark.parametrize("lyapunov", [False, True])
def test_a_sweep_on_the_screen(printed, monkeypatch, lyapunov):
    """What a label means, or the exponents; the way, where there are several."""
    found = printed(sweep)
    monkeypatch.setattr("camcli.words.labels.motion", lambda label, kind: f"{label} of {kind}")
    monkeypatch.setattr("camcli.words.sweep.sweep_title", lambda *given: "title")
    ranges = [
        Made(label="P(1;1)", first=500.25, last=510.5, way=("up",), speeds=3, status="ok",
             exponents=((-0.5, 0.0),)),
        Made(label="contact", first=520.0, last=530.0, way=("down",), speeds=2, status="no-return",
             exponents=()),
    ]  # fmt: skip
    monkeypatch.setattr("camcli.api.sweep.ranges", lambda study: ranges)
    scene = Made(cam=Made(kind="arcs"), sweep=Made(lyapunov=lyapunov))
    for key, head in (("rpm", "speeds"), ("run.x", "values")):
        found.clear()
        study = Made(key=key, way_names=["direction"])
        sweep.show(Made(values=(study, None), scene=scene, summary={}), False)
        ((_, heads, rows, how),) = found
        ends = ["from (rpm)", "to (rpm)"] if key == "rpm" else ["from", "to"]
        if lyapunov:
            assert heads == ["label", *ends, "direction", head, "exponent", "status"]
            assert rows == [
                ["P(1;1)", "500.25", "510.5", "up", "3", "-0.5", "ok"],
                ["contact", "520", "530", "down", "2", "", "no-return"],
            ]
        else:
            assert heads == ["label", "motion", *ends, "direction", head, "status"]
            assert rows == [
                ["P(1;1)", "P(1;1) of arcs", "500.25", "510.5", "up", "3", "ok"],
                ["contact", "contact of arcs", "520", "530", "down", "2", "no-return"],
            ]
        assert how == ("speeds.csv", 0, "label")


def test_a_map_on_the_screen_has_the_commonest_motion_first(printed, monkeypatch):
    found = printed(sweep)
    monkeypatch.setattr("camcli.words.sweep.map_title", lambda study, kind: kind)
    labels = [{"label": label, "status": status, "points": points} for label, status, points in (
        ("P(1;1)", "ok", 20), ("contact", "ok", 300), ("P(1;1)", "no-return", 4))]  # fmt: skip
    summary = {"labels": labels, "words": ["said", "too"]}
    sweep.show(Made(values=(None, None), scene=Made(cam=Made(kind="arcs")), summary=summary), False)
    (title, _, rows, how), *words = found
    assert (title, how, words) == ("arcs", ("run.json", 0, "label"), ["- said", "- too"])
    assert rows == [["contact", "300", "ok"], ["P(1;1)", "20", "ok"], ["P(1;1)", "4", "no-return"]]


@pytest.mark.parametrize("kind", ["arcs", "table"])
def test_the_theory_of_detachment_on_the_screen(printed, monkeypatch, kind):
    """Finite speeds alone; of a measured cam the digits and the bracket that its table leaves."""
    found = printed(detach)

    def speed(quantity, **more):
        own = {"quantity": quantity, "region": "A2", "theta": radians(155.5), "rpm": 700.5,
               "low": 690.25, "high": 710.75, "status": "ok", "finite": True}  # fmt: skip
        return Made(**{**own, **more})

    alike = Made(bursts="2 of 3", from_rpm=500.25, to_rpm=510.5, speeds=4)
    monkeypatch.setattr("camcli.words.detach.burst_ranges", lambda loss: [alike])
    loss = Made(
        critical_speeds=[speed("accumulation_at_corner"), speed("opens", low=nan, high=nan),
                         speed("fills", rpm=inf, finite=False)],
        hits=[Made(impact=3, corner="b", rpm=720.5, low=720.25, high=720.75, status="jump")],
    )  # fmt: skip
    detach._show_theory(Made(values=loss, scene=Made(cam=Made(kind=kind))))
    critical, hits, bursts = (rows for _, _, rows, _ in found)
    bracket = "bracket (rpm)"
    assert [heads for _, heads, _, _ in found] == [
        ["speed", "region", "theta (deg)", "rpm", bracket, "status"],
        ["impact", "corner", "rpm", bracket, "status"],
        ["chattering", "from (rpm)", "to (rpm)", "speeds"],
    ]
    name = "accumulates at corner"
    if kind == "arcs":
        assert critical == [
            [name, "A2", "155.50000000", "700.500000000", "2.0e+01", "ok"],
            ["opens", "A2", "155.50000000", "700.500000000", "nan", "ok"],
        ]
    else:
        (first, second) = critical
        assert first[:4] == [name, "A2", "155.5", "700.5"]
        assert "690" in first[4]
        assert "711" in first[4]
        assert second == ["opens", "A2", "155.5", "700.5", "", "ok"]
    assert hits == [["3", "b", "720.500000000", "5.0e-01", "jump"]]
    assert bursts == [["2 of 3", "500.25", "510.5", "4"]]
    found.clear()
    loss.critical_speeds = []
    detach._show_theory(Made(values=loss, scene=Made(cam=Made(kind=kind))))
    assert [title for title, *_ in found] == ["Impacts on corners", "Bursts after settling"]


UNITS = Made(
    length="mm", per_m=1e3, lengths=lambda value, digits=3: f"{1e3 * value:.{digits}g} mm",
    shown=lambda unit: (unit.replace("m", "mm", 1), 1e3),
)  # fmt: skip


def extreme(value, deg):
    return Made(value=value, theta=radians(deg))


@pytest.mark.parametrize("measured", [False, True])
def test_the_extremes_of_a_cam_on_the_screen(measured):
    """By rad in the unit of the machine, then by degree in mm; a guessed jerk has two digits."""
    names = ("c", "c_theta", "c_thetatheta", "c_thetathetatheta")
    ranges = {
        name: (extreme(-0.0012345 * 4**k, 10.0 + k), extreme(0.0023456 * 4**k, 50.0 + k))
        for k, name in enumerate(names)
    }
    ranges["c"] = (extreme(-0.0012345, 10.0), extreme(5e-19, 50.0))
    cam = Made(kind="table" if measured else "arcs", base=-0.0012346, least_lift=1e-6)
    rows = simulate._Rows(4)
    simulate._add_extremes(rows, Made(ranges=ranges), cam, UNITS)
    assert rows.cells[0][1:] == (["base circle", ""] if measured else ["-1.234", "10"])
    assert rows.cells[1][1:] == ["0", "50"]  # a rounding is none
    by_rad, by_deg = rows.cells[2:8], rows.cells[8:]
    for k in (1, 2, 3):
        digits = 2 if measured and k == 3 else 4
        rad = (pi / 180.0) ** k
        for least, scale, cells in ((0, 1.0, by_rad), (1, rad, by_deg)):
            low, high = cells[2 * k - 2 : 2 * k]
            assert float(low[1]) == pytest.approx(-1.2345 * 4**k * scale, rel=10.0 ** (1 - digits))
            assert float(high[1]) == pytest.approx(2.3456 * 4**k * scale, rel=10.0 ** (1 - digits))
            assert len(low[1].strip("-0.").replace(".", "")) <= digits
            assert (low[2], high[2]) == (f"{10 + k}", f"{50 + k}")
            assert [cell[0].split()[0] for cell in (low, high)] == ["least", "largest"]
            assert ("deg" in low[0]) == bool(least)


@pytest.mark.parametrize("face", ["flat", "roller"])
def test_the_sheet_of_a_lobe_on_the_screen(monkeypatch, face):
    """Lengths in the unit of the machine, angles in degrees; a line for what there is alone."""
    monkeypatch.setattr("camcli.words.simulate.lobe_title", lambda lobe, units: lobe.face)
    monkeypatch.setattr("camcli.words.simulate.closing_words", lambda lobe, units: "closes")
    lobe = Made(
        face=face, base=0.02, least=extreme(0.01, 10.0), hollow=extreme(0.05, 20.0),
        largest_roller=extreme(0.006, 30.0), least_base=0.015,
        beside=(extreme(-0.003, 40.0), extreme(0.004, 50.0)),
    )  # fmt: skip
    rows = simulate._Rows(4)
    simulate._add_lobe(rows, lobe, UNITS, 1.5)
    scale = 1e3 if face == "flat" else 180.0 / pi
    beside = [f"{-0.003 * scale:.4g}", f"{0.004 * scale:.4g}"]
    assert [cells[1:] for cells in rows.cells] == [
        ["20", ""], ["10", "10"], ["50", "20"], ["6", "30"], ["15", ""], [beside[0], "40"],
        [beside[1], "50"], ["closes", ""],
    ]  # fmt: skip
    assert rows.cells[0][0] == f"base radius of the lobe, {face}, rocker 1.5 (mm)"
    said = [cells[0].partition(" (")[0] for cells in rows.cells[-3:-1]]
    what = "eccentricity of the contact" if face == "flat" else "pressure angle"
    assert said == [f"least {what}", f"largest {what}"]
    lobe.hollow = lobe.largest_roller = lobe.least_base = None
    rows = simulate._Rows(4)
    simulate._add_lobe(rows, lobe, UNITS, 1.0)
    assert [cells[1] for cells in rows.cells] == ["20", "10", *beside, "closes"]
    assert rows.cells[0][0] == f"base radius of the lobe, {face} (mm)"


def test_the_curvature_of_a_cam_on_the_screen():
    curvature = Made(base_radius=0.02, flat_least=extreme(0.01, 20.0), least_base_radius=0.015,
                     roller=extreme(0.006, 30.0))  # fmt: skip
    rows = simulate._Rows(4)
    simulate._add_curvature(rows, curvature, UNITS, 1.5)
    assert [cells[1:] for cells in rows.cells] == [["10", "20"], ["15", ""], ["6", "30"]]
    assert "of the lobe (rocker 1.5)" in rows.cells[0][0]
    curvature.base_radius = curvature.roller = None
    rows = simulate._Rows(4)
    simulate._add_curvature(rows, curvature, UNITS, 1.0)
    assert rows.cells == [["base radius a flat face needs (mm)", "15", ""]]


# --- options and exit codes


@pytest.mark.parametrize(
    ("rpm", "points", "vary", "wanted"),
    [
        ("500:700", None, None, {"start": 500.0, "stop": 700.0}),
        ("500:700", "41", None, {"start": 500.0, "stop": 700.0, "num": 41}),
        ("600", None, None, {"start": 600.0, "stop": 600.0, "num": 1}),
        ("600", "1", None, {"start": 600.0, "stop": 600.0, "num": 1}),
        (None, "41", None, {"num": 41}),
    ],
)
def test_a_range_of_speeds_and_its_points(rpm, points, vary, wanted):
    found = run.ranges(Request(rpm=rpm, points=points), "sweep", vary)
    assert {key: value for key, (value, _) in found.items()} == {
        f"sweep.rpm.{key}": value for key, value in wanted.items()
    }


def test_numbers_that_vary_and_their_points():
    """A range of speeds is the first of them, a single speed that of the run."""
    vary = ["follower.restitution=0.6:0.9"]
    restitution = {"key": "follower.restitution", "start": 0.6, "stop": 0.9}
    speeds = {"key": "rpm", "start": 500.0, "stop": 700.0}

    def found(rpm, points, most=2, vary=vary):
        values = run.ranges(Request(rpm=rpm, points=points), "sweep", vary, most)
        return {key: value for key, (value, _) in values.items()}

    assert found("600", "5", 1) == {"run.rpm": 600.0, "sweep.vary": [{**restitution, "num": 5}]}
    assert found(None, None, 1) == {"sweep.vary": [restitution]}
    two = [{**speeds, "num": 7}, {**restitution, "num": 5}]
    assert found("500:700", "7,5") == {"sweep.vary": two}
    assert found("500:700", "7") == {"sweep.vary": [two[0], {**restitution, "num": 7}]}
    others = ["follower.mass=2:3", *vary]
    mass = {"key": "follower.mass", "start": 2.0, "stop": 3.0}
    assert found(None, "7,5", 2, others) == {"sweep.vary": [{**mass, "num": 7}, two[1]]}
    for rpm, points, most in (("500:700", None, 1), ("600", "7,5", 2), ("500:700", "7,5,3", 2)):
        with pytest.raises(SceneError):
            found(rpm, points, most)


@pytest.mark.parametrize(
    ("complete", "faults", "made", "command", "profile", "code"),
    [
        (True, [], [], "sweep", False, DONE),
        (False, [], [], "sweep", False, NUMERICS),
        (True, [], ["follower.mass"], "sweep", False, NUMERICS),
        (False, ["x"], [], "sweep", False, INTERNAL),
        (True, [], ["follower.mass"], "simulate", False, NUMERICS),
        (True, [], ["follower.mass"], "simulate", True, DONE),  # no spring counts
        (True, [], ["follower.mass", "cam.lift"], "simulate", True, NUMERICS),
        (True, [], ["follower.mass"], "detach", True, NUMERICS),
    ],
)
def test_the_exit_code_of_a_run(monkeypatch, complete, faults, made, command, profile, code):
    monkeypatch.setattr(run, "made_up", lambda scene: made)
    scene = Made(simulate=Made(profile_only=profile))
    result = Made(scene=scene, command=command, complete=complete)
    assert run.exit_code(result, {"piece_faults": faults}) == code


@pytest.mark.parametrize(
    ("codes", "differ", "faults", "code"),
    [
        ([], False, False, DONE),
        ([DONE, DONE], True, False, NUMERICS),
        ([DONE, NUMERICS, DONE], False, False, NUMERICS),
        ([USAGE, NUMERICS], True, False, USAGE),
        ([DONE], False, True, INTERNAL),
        ([USAGE, INTERNAL], False, True, USAGE),
        ([INTERRUPTED, USAGE], False, False, INTERRUPTED),
        ([INTERNAL, NUMERICS], True, False, INTERNAL),
    ],
)
def test_the_exit_code_of_figures_is_the_worst(codes, differ, faults, code):
    """Those of figures that are whole count least."""
    assert figures._exit_code(codes, differ, faults) == code


@pytest.mark.parametrize(
    ("named", "told"),
    [
        (["impacts"], False),
        (["impacts", "springs"], False),  # one of them is drawn
        (["springs", "surge"], True),  # they are those of cam detach
    ],
)
def test_panels_of_a_scene_are_told_of_where_none_is_drawn(capsys, named, told):
    scene = Made(plot=Made(panels=named), sweep=Made(vary=()))
    panels.check_panels("sweep", scene, Request())
    assert ("names none" in capsys.readouterr().err) is told
    panels.check_panels("sweep", scene, Request(quiet=True))
    panels.check_panels("sweep", scene, Request(no_plot=True))
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("section", "drawn"),
    [
        ({}, ["branches"]),
        ({"rpm": Made(start=700.0, stop=700.0)}, ["orbits"]),
        ({"rpm": Made(start=700.0, stop=700.0), "parameter": "mass"}, ["branches"]),
        ({"rpm": Made(start=700.0, stop=700.0), "vary": ["x"]}, ["branches"]),
        ({"all": Made(), "curve": "fold"}, ["orbits", "cover"]),  # no curve at one speed
        ({"chaos": True, "curve": "fold"}, ["branches", "chaos", "curve"]),
    ],
)
def test_pictures_that_a_run_of_orbits_will_draw(section, drawn):
    own = {"vary": (), "parameter": "rpm", "rpm": Made(start=600.0, stop=700.0), "all": None,
           "chaos": False, "curve": None}  # fmt: skip
    assert panels._drawn("orbits", Made(orbits=Made(**{**own, **section}))) == drawn


def test_a_column_is_cut_to_what_the_others_leave():
    """Two characters lie between columns; eight stay at least."""
    heads, rows = ["label", "impacts", "n"], [["P(1;1)", "2", "1234"], ["P(2;1:1)", "12345678", ""]]
    assert report._room_to_cut(heads, rows, "label", 60) == 60 - (2 + 8) - (2 + 4)
    assert report._room_to_cut(heads, rows, "n", 60) == 60 - (2 + 8) - (2 + 8)
    assert report._room_to_cut(heads, rows, "label", 20) == 8
    assert report._room_to_cut(heads, rows, "status", 60) is None


def test_options_that_name_speeds():
    """One speed is that at which orbits are looked for; a range is not."""
    assert orbits._speeds(Request()) == {}
    one = {key: value for key, (value, _) in orbits._speeds(Request(rpm="700")).items()}
    assert one == {"orbits.rpm.start": 700.0, "orbits.rpm.stop": 700.0, "orbits.at": 700.0}
    two = {key: value for key, (value, _) in orbits._speeds(Request(rpm="600:700")).items()}
    assert two == {"orbits.rpm.start": 600.0, "orbits.rpm.stop": 700.0}
    keys = orbits._keys_of
    assert keys(["restitution=0.6:0.9"]) == []
    assert keys(["cam.lift=0.1:0.2"]) == ["cam.lift=0.1:0.2"]
    assert keys(["restitution=0.6:0.9", "rpm=600:700"]) == [
        "follower.restitution=0.6:0.9", "rpm=600:700"
    ]  # fmt: skip


def part_keys(number, total, plot, first="sweep", **scene):
    """The key of a part, and how it ends."""
    key = {"command": first, "scene": {"run": {"rpm": 700.0}}, "program_sha256": "own"}
    return json.dumps(key), {"shard": [number, total], "scene": scene, "plot": plot}


def test_parts_of_one_run_draw_where_any_does_and_look_as_the_last_one(monkeypatch):
    """Values that decide numbers are those of the key; one whole division of the run is enough."""
    monkeypatch.setattr(merge, "program_hash", lambda: "own")

    def joined(*parts):
        told = {Path(f"{k}"): part for k, part in enumerate(parts)}
        monkeypatch.setattr(merge, "key_of", told.get)
        return merge._record(list(told))

    def part(number, total, plot, width):
        return part_keys(number, total, plot, run={"rpm": 1.0}, plot_width=width)

    record, path, drawn = joined(part(1, 2, True, 80), part(2, 2, False, 90))
    assert record.scene == {"run": {"rpm": 700.0}, "plot_width": 90}
    assert (record.command, path, drawn) == ("sweep", Path("1"), True)
    assert not joined(part(2, 2, False, 80), part(1, 2, False, 90))[2]
    joined(part(1, 2, True, 80), part(1, 3, True, 80), part(2, 2, True, 80))
    for parts, words in (
        ([part(1, 2, True, 80), part(1, 4, True, 80)], "found 1 of 2 parts"),
        ([part(1, 2, True, 80), part(3, 2, True, 80)], "not complete"),
        ([part(0, 2, True, 80)], "not complete"),
        ([part(1, run.MOST_SHARDS + 1, True, 80)], "not complete"),
        ([part(1, 1, True, 80), part_keys(1, 1, True, "basins")], "pieces of other work"),
    ):
        with pytest.raises(SceneError, match=words):
            joined(*parts)
    monkeypatch.setattr(merge, "program_hash", lambda: "another")
    with pytest.raises(SceneError, match="another version"):
        joined(part(1, 1, True, 80))


def figure(folder, name, **more):
    own = {"name": name, "path": folder / f"{name}.yaml", "scene": None, "command": "sweep",
           "hashes": {"scene": "s" * 20, "data": "", "program": "p"}}  # fmt: skip
    return figures.Figure(**{**own, **more})


def test_references_of_figures_are_written_and_those_of_no_figure_go(tmp_path):
    """A figure that was not asked for keeps its own; seconds are those of here, else of there."""
    one, two = figure(tmp_path, "3.5"), figure(tmp_path, "3.6")
    (tmp_path / "reference").mkdir()
    for name in ("3.6", "3.7"):
        (tmp_path / "reference" / f"{name}.json").write_text("{}")
    groups = {"regular": {"a": 1}, "chaotic": {"b": 2}, "solved": {"c": 3}}
    state = figures.State(hashes=one.hashes, seconds=1.26, digest=groups)
    figures.update([one], [one, two], {"3.5": state})
    left = sorted(path.name for path in (tmp_path / "reference").glob("*.json"))
    assert left == ["3.5.json", "3.6.json"]
    written = json.loads(one.reference_path.read_text())
    assert written == {"scene": "s" * 20, "data": "", "seconds": 1.3, **groups}
    assert figures.compared(one, state) == []
    out = tmp_path / "out"
    assert figures.last_seconds(one, out) == 1.3
    (out / "3.5").mkdir(parents=True)
    (out / "3.5" / figures.STATE).write_text(
        figures.State(hashes={}, seconds=7.5).model_dump_json()
    )
    assert figures.last_seconds(one, out) == 7.5
    assert figures.last_seconds(figure(tmp_path, "3.9"), out) is None
    other = figure(tmp_path, "3.5", hashes={"scene": "t" * 20, "data": "u" * 20, "program": "p"})
    drifted = state.model_copy(update={"digest": {**groups, "regular": {"a": 4}}})
    scene, data, number = figures.compared(other, drifted)
    assert (scene.name, scene.reference, scene.found) == ("hash of the scene", "s" * 12, "t" * 12)
    assert (data.name, data.reference, data.found) == ("hash of the data", "", "u" * 12)
    assert (number.name, number.reference, number.found, number.portability) == ("a", 1, 4, False)


def test_the_figures_that_are_meant():
    """3.6 means 3.6 and 3.6a to 3.6z, in the order in which they stand."""
    known = [Made(name=name) for name in ("3.5", "3.6a", "3.6b", "3.6bc", "3.60", "13.6", "3.7")]

    def names(*asked):
        return [one.name for one in figures.chosen(known, asked)]

    assert names() == [one.name for one in known]
    assert names("3.7", "3.6") == ["3.6a", "3.6b", "3.7"]
    assert names("3.6b") == ["3.6b", "3.6bc"]
    with pytest.raises(SceneError, match=r"3\.8"):
        names("3.8", "3.7")


@pytest.mark.parametrize(("out", "no_plot", "drawn"), [(None, False, True), ("o", True, True),
                                                       (None, False, False)])  # fmt: skip
def test_parts_are_joined_beside_the_first_of_them(monkeypatch, out, no_plot, drawn):
    """It draws where the parts do, unless it is told not to."""
    paths = [Path("one/a.pieces"), Path("two/b.pieces")]
    record = Made(command="sweep", load=lambda folder, beside, name: (folder, name))
    monkeypatch.setattr(merge, "_paths", lambda given: paths)
    monkeypatch.setattr(merge, "_record", lambda found: (record, found[-1], drawn))
    checked, done = [], []
    monkeypatch.setattr(merge, "check_before", lambda *given: checked.append(given[1:]))
    monkeypatch.setattr(merge, "execute", lambda *given, **more: done.append((given, more)) or 3)
    given = Request(out=None if out is None else Path(out), no_plot=no_plot)
    assert merge.merge(given, None, Path("home")) == 3
    (_, scene, request, show), more = done[0]
    assert scene == (Path("home"), "two/b.pieces")
    assert (request.out, request.no_plot) == (Path(out or "one"), no_plot or not drawn)
    assert (show, more) == (sweep.show, {"parts": tuple(paths)})
    assert checked == [(scene, request.out, not request.no_plot)]
