"""The pictures of basins against basins.csv, attractors.csv and saddles.csv."""

import re
from functools import cache

import numpy as np
import pytest
from matplotlib.contour import QuadContourSet
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

import camcli
from tests.conftest import some_in_ci
from tests.support.machines import CHAPTER, VALVE
from tests.support.picture_reader import (
    COLOURS,
    check,
    dashes,
    hexed,
    mixed,
    motion_colour,
    read_page,
)

SHAPES = ("o", "s", "^", "D", "v", "P", "X")
OUTSIDE = "attractor outside the window"
STIFF = 1430.8 * (361.0 / 358.5) ** 2  # the motions at 361 rpm are those at 358.5 rpm
CASES = {
    "chapter": (
        CHAPTER,
        {"basins.cells": [12, 16], "basins.saddles": True, "run.strobe_deg": 120.0},
    ),
    "valve": (
        VALVE,
        {"basins.rpm": {"start": 6500, "stop": 6500}, "basins.q": [-0.012, 0.05],
         "basins.v": [-30, 20], "basins.cells": [14, 10], "basins.budget": 12},
    ),
    "three": (
        CHAPTER,
        {"basins.cells": [8, 6], "basins.q": [0.05, 0.9], "run.rpm": 358.5, "run.transient": 200,
         "basins.vary": [{"key": "follower.restitution", "start": 0.799, "stop": 0.801, "num": 3}]},
    ),
    "chaos": (
        CHAPTER,
        {"basins.cells": [4, 3], "basins.rpm": {"start": 361, "stop": 361}, "run.transient": 200,
         "run.strobe_deg": 20.0},
    ),
    "refined": (
        CHAPTER,
        {"basins.cells": [6, 6], "basins.refine": 1, "run.strobe_deg": 20.0, "basins.budget": 20},
    ),
    "range": (
        CHAPTER,
        {"basins.cells": [6, 5], "run.rpm": 361.0, "run.strobe_deg": 20.0, "run.transient": 200,
         "basins.vary": [{"key": "follower.stiffness", "start": STIFF, "stop": 1430.8, "num": 4}]},
    ),
}  # fmt: skip


@cache
def made(name):
    machine, values = CASES[name]
    return camcli.basins(machine.load(values))


@cache
def swatches(name):
    """Colours by what the list above the panels calls them."""
    return {
        name_in(row): hexed(row[0].get_markerfacecolor())
        for row in read_page(made(name)).rows()
        if hasattr(row[0], "get_marker") and row[0].get_marker() == "s"
    }


def name_in(row):
    """What a row of the list is of: its first words that are no share."""
    words = [cell for cell in row if isinstance(cell, str)]
    return next(one for one in words if not one.endswith("%") and one != OUTSIDE)


def shown(label):
    """How a label begins where it is printed; a long one is cut."""
    return label.replace("inf", "∞")[:20]


def checks(name):
    machine, values = CASES[name]
    result = made(name)
    tables, key = result.tables, values.get("basins.vary", [{"key": "rpm"}])[0]["key"]
    attractors = tables["attractors"]
    strobe = values.get("run.strobe_deg", machine.strobe_deg)
    named = dict(zip(attractors["attractor"], attractors["label"], strict=True))
    speeds = {speed["value"]: speed for speed in result.summary["speeds"]}

    def states(speed):
        """(number, period or 0, q, v) of every attractor."""
        for one in speed["attractors"]:
            q, v = np.array(one["states_q_m_v_m_per_s"]).T
            yield one["attractor"], one["turns"] or 0, q, v

    def colour(number):
        if number == -1:
            return COLOURS["body"]
        said = shown(named.get(number, "undecided"))
        return next(c for text, c in swatches(name).items() if text.startswith(said))

    def window(panel):
        at = [float(word) for word in re.findall(r"[\d.]+", panel.name)] or [*speeds]
        value = min(speeds, key=lambda x: abs(x - at[0]))
        cells = {column: tables["basins"][column] for column in tables["basins"]}
        if key in cells:
            own = cells[key] == value
            cells = {column: cells[column][own] for column in cells}
        (image,) = panel.images()
        assert len(cells["q_m"]) >= 12
        for q, v, number in zip(cells["q_m"], cells["v_m_per_s"], cells["attractor"], strict=True):
            assert image.colour(q, v) == colour(number), (q, v, number)
        ellipses(panel, speeds[value])
        for number, turns, q, v in states(speeds[value]):
            if 0 < turns <= 12:
                panel.dots(q, v, SHAPES[number - 1], "white", "black")
            elif turns:
                panel.dots(q, v, ".", "aperiodic", "aperiodic")
            else:
                (cloud,) = panel.lines("aperiodic", None, count=1)
                assert cloud.get_marker() == "."
                table = swept(name, value)
                for drawn, wanted in zip(cloud.get_data(), table, strict=True):
                    size = np.ptp(wanted)
                    assert min(drawn) == pytest.approx(min(wanted), abs=0.1 * size)
                    assert max(drawn) == pytest.approx(max(wanted), abs=0.1 * size)
        if "saddles" in tables:
            boundary(panel, cells)
        low, high = values.get("basins.q", (0.1, 0.9))
        c = float(machine.cam.lift(strobe)[0])
        if low <= c <= high:
            panel.band("x", low, c, "body")
            (edge,) = panel.lines("cam", "cam, $q = c$", count=1)
            assert list(edge.get_xdata()) == pytest.approx([c, c])
        assert panel.axes.get_xlim() == (low, high)
        assert panel.axes.get_ylim() == tuple(values.get("basins.v", (-50.0, 50.0)))
        panel.reads("x", f"position $q$ ({machine.unit})", machine.per_m)
        shared = name == "three" and value != min(speeds)
        assert panel.axes.get_ylabel() == ("" if shared else "velocity $v$ (m/s)")
        if len(speeds) == 1:
            assert panel.title == ""  # the title of the page says it
        elif key == "rpm":
            assert panel.title == f"{value:g} rpm"
        else:
            said = panel.title.replace("\n", " ")
            assert said == f"coefficient of restitution {value:g}"

    def ellipses(panel, speed):
        """About each state from whose ellipse starts came back: as wide and as high as it is."""
        named = "ellipse: starts in it were seen to settle there"
        lines = panel.pick(Line2D, lambda a: dashes(a) == "dashed")
        assert all(hexed(line.get_color()) == COLOURS["black"] for line in lines)
        assert [line.get_label() for line in lines[:1]] in ([], [named])
        wanted = [
            (state, half)
            for one in speed["attractors"]
            if one.get("ring_of_starts_returns") and 0 < one["turns"] <= 12
            for state, half in zip(
                one["states_q_m_v_m_per_s"], one["half_widths_q_m_v_m_per_s"], strict=True
            )
        ]
        assert len(lines) == len(wanted)
        for line, (state, half) in zip(lines, wanted, strict=True):
            for values, middle, reach in zip(line.get_data(), state, half, strict=True):
                assert np.mean([values.min(), values.max()]) == pytest.approx(
                    middle, abs=0.01 * reach
                )
                assert np.ptp(values) == pytest.approx(2.0 * reach, rel=1e-3)
            # opposite places are equally far from the state
            x, y = (values - middle for values, middle in zip(line.get_data(), state, strict=True))
            assert x[:60] == pytest.approx(-x[60:120], abs=1e-9 * half[0])
            assert y[:60] == pytest.approx(-y[60:120], abs=1e-9 * half[1])

    def boundary(panel, cells):
        """Lines between cells of different basins, and the saddle's states on them."""
        codes = {}
        for q, v, number in zip(cells["q_m"], cells["v_m_per_s"], cells["attractor"], strict=True):
            codes[q, v] = number
        wide, high = (np.diff(np.unique(cells[c]))[0] for c in ("q_m", "v_m_per_s"))
        for lines in panel.pick(QuadContourSet):
            for path in lines.get_paths():
                for q, v in path.vertices:
                    near = {
                        n for (x, y), n in codes.items()
                        if abs(x - q) < 0.51 * wide + 1e-9 and abs(y - v) < 0.51 * high + 1e-9
                    }  # fmt: skip
                    assert len(near) > 1
        for label, q, v in zip(*(tables["saddles"][c] for c in ("label", "q_m", "v_m_per_s")),
                               strict=True):  # fmt: skip
            (cross,) = panel.pick(object, lambda a: getattr(a, "get_marker", str)() == "x")
            x, y = cross.get_data()
            assert (x[0], y[0]) == pytest.approx((q, v))
            assert len(x) == int(label[2:].partition(";")[0])

    def fractions(panel):
        edges = sorted(speeds)
        half = 0.5 * (edges[1] - edges[0])
        height = dict.fromkeys(edges, 0.0)
        rows = zip(attractors[key], attractors["attractor"], attractors["fraction"], strict=True)
        for rpm, number, fraction in rows:
            shade = colour_of_branch(number)
            for bar in panel.left:
                if isinstance(bar, Rectangle) and hexed(bar.get_facecolor()) == shade:
                    middle = bar.get_x() + 0.5 * bar.get_width()
                    if abs(middle - rpm) < 1e-6 and bar.get_height() == pytest.approx(fraction):
                        assert bar.get_y() == pytest.approx(height[rpm])
                        assert abs(bar.get_width()) == pytest.approx(2.0 * half)
                        height[rpm] += fraction
                        panel.left.remove(bar)
                        break
            else:
                panel.fail("bar", rpm, number, fraction)
        panel.pick(Rectangle, lambda bar: bar.get_height() == 0.0)
        assert panel.axes.get_xlim() == pytest.approx((edges[0] - half, edges[-1] + half))
        assert panel.axes.get_ylim() == (0.0, 1.0)
        assert panel.labels == ("stiffness $k$ (N/m)", "fraction of the window")

    def colour_of_branch(number):
        if number <= 0:
            return COLOURS["undecided"]
        return next(c for n, c in swatches(name).items() if n.startswith(f"{number}: "))

    def places(panel):
        for value, speed in speeds.items():
            for number, turns, q, _ in states(speed):
                shade = colour_of_branch(number)
                if turns:
                    panel.dots([value] * turns, q, "o", shade, "black")
                    continue
                (cloud,) = [
                    a for a in panel.left
                    if hexed(a.get_markerfacecolor()) == shade and set(a.get_xdata()) == {value}
                ]  # fmt: skip
                wanted = swept(name, value)[0]
                drawn = cloud.get_ydata()
                assert min(drawn) == pytest.approx(min(wanted), abs=0.1 * np.ptp(wanted))
                assert max(drawn) == pytest.approx(max(wanted), abs=0.1 * np.ptp(wanted))
                panel.left.remove(cloud)
        panel.reads("y", f"attractors' stroboscopic $q$ ({machine.unit})", machine.per_m)
        assert panel.axes.get_xlabel() == "stiffness $k$ (N/m)"

    return {"basins": window, "fractions": fractions, "attractors": places,
            "basins coefficient of restitution": window}  # fmt: skip


@cache
def swept(name, value):
    """Stroboscopic states (q, v) of an aperiodic motion, by a sweep from rest."""
    machine, values = CASES[name]
    more = {k: v for k, v in values.items() if k.startswith("run")} | {"run.record": 2000}
    if "basins.vary" in values:
        more |= {values["basins.vary"][0]["key"]: value}
    else:
        more |= {"run.rpm": value}
    rpm = more["run.rpm"]
    scene = machine.load({**more, "sweep.rpm": {"start": rpm, "stop": rpm, "num": 1}})
    table = camcli.sweep(scene).tables["strobe"]
    return table["q_m"], table["v_m_per_s"]


@pytest.mark.parametrize("name", some_in_ci(CASES, quick=["chapter", "valve", "refined"]))
def test_every_panel_of_basins_shows_the_rows_of_its_tables(name):
    own, result = checks(name), made(name)
    seen = check(result, own)
    assert seen <= {*own}


@pytest.mark.parametrize("name", CASES)
def test_the_page_of_basins_names_every_colour_and_its_share(name):
    machine, values = CASES[name]
    result = made(name)
    page, attractors = read_page(result), result.tables["attractors"]
    columns = zip(*(attractors[c] for c in ("attractor", "label", "fraction", "standard_error")),
                  strict=True)  # fmt: skip
    if name == "range":
        for number, label in {n: label for n, label, *_ in reversed([*columns]) if n > 0}.items():
            row = next(row for row in page.rows() if str(row[-1]).startswith(f"{number}: "))
            first = row[-1].partition(": ")[2].partition(",")[0]
            assert shown(label) in row[-1]  # where the branch begins
            assert hexed(row[0].get_markerfacecolor()) in {
                mixed(motion_colour(first), share) for share in (0.3, 0.8)
            }
        page.says(f"Basin fractions, stiffness 1430.800000 to {STIFF:.6f} N/m at 361 rpm")
        page.says("4 values, 6 × 5 starts each, q from 0.1 to")
        page.says("0.9 m, v from −50 to 50 m/s")
        return
    for number, label, fraction, error in columns:
        row = next(
            row
            for row in page.rows()
            if any(isinstance(cell, str) and cell.startswith(shown(label)) for cell in row)
        )
        (text,) = [c for c in row if isinstance(c, str) and c.endswith("%")][:1]
        said = [float(x) for x in re.findall(r"[\d.]+", text)]
        if len(said) == 2:
            digits = 10.0 ** -len(re.search(r"\.(\d+)\)", text + ".)")[1]) if "." in text else 1.0
            assert said[0] == pytest.approx(100.0 * fraction, abs=0.6 * digits)
            assert said[1] == pytest.approx(100.0 * error, abs=0.6 * digits)
        elif name != "three":
            assert said[0] == pytest.approx(100.0 * fraction, rel=6e-3)
        if number > 0:
            shades = {mixed(motion_colour(label), share) for share in (0.3, 0.8)}
            assert hexed(row[0].get_markerfacecolor()) in shades
            if motion_colour(label) != COLOURS["aperiodic"] and name != "three":
                assert row[1].get_marker() == SHAPES[number - 1]
        if number == 0:
            assert hexed(row[0].get_markerfacecolor()) == COLOURS["undecided"]
    below = [row for row in page.rows() if "none: below the cam" in row]
    assert len(below) == (-1 in result.tables["basins"]["attractor"])
    assert all(hexed(row[0].get_markerfacecolor()) == COLOURS["body"] for row in below)
    if name == "valve":
        assert below
    if name == "refined":
        assert 0 in attractors["attractor"]
    strobe = values.get("run.strobe_deg", machine.strobe_deg)
    wide, high = (values["basins.cells"][k] * 2 ** values.get("basins.refine", 0) for k in (0, 1))
    page.says(f"{wide} × {high} starts (q, v) at θ = {strobe:g} deg")
    if name == "chapter":
        (led,), (tried,) = (result.tables["saddles"][column] for column in ("led", "tried"))
        count = "" if led == tried else f": {led} of {tried} motions led to it"
        page.row(f"saddle P(1;2){count}")
        entropy = result.summary["speeds"][0]["basin_entropy"]
        page.says(f"basin entropy {entropy:.3g}")
