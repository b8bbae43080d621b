"""The picture of classified motions against classify.csv and the motions themselves."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

import camcli
from tests.support.machines import CHAPTER, VALVE
from tests.support.picture_reader import (
    COLOURS,
    check,
    dashes,
    hexed,
    label_of,
    mixed,
    read_page,
)
from tests.truth.test_pictures_sweep import check_cloud, kind_of

RECORD = 130  # turns, as many as are recorded at least
CASES = {
    "explained": (
        VALVE,
        {"classify.rpm": {"start": 2600, "stop": 3400, "num": 9}, "classify.explain": True},
    ),
    "valve": (VALVE, {"classify.rpm": {"start": 11500, "stop": 4500, "num": 15}}),
    "damping": (
        VALVE,
        {"classify.vary": [{"key": "follower.damping", "start": 10, "stop": 30, "num": 3}],
         "run.rpm": 6500, "run.impact_budget": 4},
    ),
    "one speed": (
        CHAPTER,
        {"classify.rpm": {"start": 358.5, "stop": 358.5, "num": 1}, "classify.starts": 30,
         "run.transient": 200},
    ),
}  # fmt: skip
FORGETS = "largest exponent −∞"


@cache
def made(name):
    machine, values = CASES[name]
    return camcli.classify(machine.load({"run.record": RECORD, **values}))


@cache
def phases(name):
    """Impact phases of every motion of the table, by a sweep from its start."""
    machine, values = CASES[name]
    values = {k: v for k, v in values.items() if k.startswith("run")}
    found = []
    for motion in made(name).summary["motions"]:
        start = {key: motion["start"][key] for key in ("q", "v", "theta_deg")}
        more = {
            "run.rpm": motion["rpm"],
            "run.start": start,
            "run.record": motion["turns"],
        }
        if name == "damping":
            more["follower.damping"] = motion["value"]
        if motion["turns"] > RECORD:  # it was followed for longer
            more["run.transient"] = values.get("run.transient", 60) + RECORD
        more["sweep.rpm"] = {"start": motion["rpm"], "stop": motion["rpm"], "num": 1}
        found.append(camcli.sweep(machine.load({**values, **more})).tables["impacts"]["theta_deg"])
    return found


def checks(name):
    machine, _ = CASES[name]
    result = made(name)
    table, motions = result.tables["classify"], result.summary["motions"]
    key = next(iter(table))
    order = np.argsort(table[key], kind="stable")
    one = len(set(table[key])) == 1
    x = np.arange(1.0, len(order) + 1) if one else table[key][order]
    labels = [table["label"][k] for k in order]
    events = result.summary.get("events", ())
    seen = []

    def common(panel):
        for number, event in enumerate(events, 1):
            panel.guide("x", event["rpm"], "cam", "dotted")
            if not seen or seen[0] == panel.name:
                assert panel.words(str(number)).xy == (event["rpm"], 1.0)
        seen.append(panel.name)
        low, high = panel.axes.get_xlim()
        assert low < min(x) <= max(x) < high
        name_of = {"rpm": "cam speed (rpm)", "follower.damping": "damping $b$ (N s/m)"}[key]
        assert panel.axes.get_xlabel() == ("motions, numbered, at 358.5 rpm" if one else name_of)

    def cloud(panel):
        every = phases(name)
        kinds = [kind_of(label) for label in labels]
        points = [
            (at, y, kind)
            for at, k, (kind, _) in zip(x, order, kinds, strict=True)
            for y in every[k]
        ]
        points += [(at, np.nan, kind) for at, (kind, _) in zip(x, kinds, strict=True)]
        check_cloud(panel, points, dict(sorted(kinds)))
        panel.key(*sorted(set(kinds)))
        panel.corners(machine.cam.corners, "y")
        bad = [at for at, k in zip(x, order, strict=True) if table["status"][k] != "ok"]
        if bad:
            (ticks,) = panel.pick(Line2D, lambda a: a.get_marker() == "|", count=1)
            assert ticks.get_xdata() == pytest.approx(bad)
            assert hexed(ticks.get_color()) == COLOURS["trouble"]
        panel.reads("y", r"impact phase $\theta$ (deg)")
        common(panel)

    def exponents(panel):
        panel.guide("y", 0.0, "cam")
        resting, ends, widest = [], [0.0], 0.0
        for at, k in zip(x, order, strict=True):
            largest = table["lyapunov_per_period"][k]
            if largest == -np.inf:
                resting.append(at)
            if not np.isfinite(largest):
                continue
            _, colour = kind_of(table["label"][k])
            panel.dots([at], [largest], "o", colour)
            error = motions[k]["exponents"]["standard_error"]
            error = error if isinstance(error, float) and np.isfinite(error) else 0.0
            (bar,) = panel.pick(
                LineCollection, lambda a, at=at: abs(a.get_segments()[0][0, 0] - at) < 1e-9, 1
            )
            ((below, above),) = bar.get_segments()
            assert (*below, *above) == pytest.approx((at, largest - error, at, largest + error))
            assert hexed(bar.get_color()[0]) == colour
            ends += [largest - error, largest + error]
            widest = max(widest, error)
        low, high = panel.axes.get_ylim()
        assert low <= min(ends) <= max(ends) <= high
        if resting:  # their marks stand below all others
            assert low + 0.06 * (high - low) < min(ends)
        if resting:
            (marks,) = panel.lines(None, FORGETS, count=1)
            assert list(marks.get_xdata()) == resting
            assert set(marks.get_ydata()) == {0.03}
            assert hexed(marks.get_color()) == COLOURS["sticking"]
            assert dashes(marks) == "none"
        bars = ",\n± standard error" if widest > 0.0 else ""
        panel.reads("y", f"largest exponent (1/turn){bars}")
        common(panel)

    def strip(panel):
        places = sorted(set(x))
        low, high = panel.axes.get_xlim()
        edges = [low, *(0.5 * (a + b) for a, b in pairwise(places)), high]
        boxes = panel.pick(Rectangle)
        for k, here in enumerate(places):
            own = [label for label, at in zip(labels, x, strict=True) if at == here]
            for row, label in enumerate(own):
                bottom, top = 1.0 - (row + 1) / len(own), 1.0 - row / len(own)
                over = [
                    box for box in boxes
                    if box.get_x() <= edges[k] + 1e-9 and bottom == pytest.approx(box.get_y())
                    and box.get_x() + box.get_width() >= edges[k + 1] - 1e-9
                    and box.get_height() == pytest.approx(top - bottom)
                ]  # fmt: skip
                colour = kind_of(label)[1]
                assert {hexed(box.get_facecolor()) for box in over} == {mixed(colour, 0.8)}
                feet = [
                    box for box in boxes
                    if (box.get_x(), box.get_y(), box.get_width()) in
                    {(own.get_x(), own.get_y(), own.get_width()) for own in over}
                    and box.get_height() == pytest.approx(0.25 * (top - bottom))
                ]  # fmt: skip
                assert [hexed(foot.get_facecolor()) for foot in feet] == [colour]
                for box in over:  # it ends where the label changes
                    end = box.get_x() + box.get_width()
                    inside = {m for m, at in zip(labels, x, strict=True) if box.get_x() < at < end}
                    assert label in inside
                    assert len(own) > 1 or inside == {label}
        texts = panel.pick(Text)
        if one:  # there is room for both
            assert {text.get_text() for text in texts} == set(labels)
        for text in texts:
            at = int(np.argmin(np.abs(np.array(places) - text.get_position()[0])))
            row = [label for label, place in zip(labels, x, strict=True) if place == places[at]]
            short = {label.replace("inf", "∞") for label in row}
            short |= {label[2:].partition(";")[0] for label in row}
            assert text.get_text() in short
        assert not {label_of(box) for box in boxes} - {None, ""}
        assert panel.axes.get_ylabel() == "label"
        common(panel)

    return {"phases": cloud, "exponents": exponents, "labels": strip}


@pytest.mark.parametrize("name", CASES)
def test_every_panel_of_classified_motions_shows_the_rows_of_the_table(name):
    own = checks(name)
    assert check(made(name), own) == {*own}


def test_the_page_of_classified_motions_counts_every_kind():
    page = read_page(made("valve"))
    labels = list(made("valve").tables["classify"]["label"])
    resting = sum("inf" in label for label in labels)
    chaotic = labels.count("aperiodic")
    assert chaotic
    page.says(
        "Motions at 15 speeds, 4500 to 11500 rpm", f"aperiodic ({chaotic})",
        f"periodic ({len(labels) - resting - chaotic})",
        f"periodic with rests ({resting})",
    )  # fmt: skip
    page = read_page(made("explained"))
    page.says("Motions at 9 speeds, 2600 to 3400 rpm", "contact (1); periodic with rests (8)")
    for number, event in enumerate(made("explained").summary["events"], 1):
        page.row(str(number), f"{event['rpm']:.5f}")
    page = read_page(made("damping"))
    page.says("Motions at 3 values, damping 10 to 30 N s/m at 6500 rpm")
    page = read_page(made("one speed"))
    page.says("Motions at 358.5 rpm", "periodic (2)")
