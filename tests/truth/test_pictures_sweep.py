"""The pictures of sweeps and maps against impacts.csv, strobe.csv, speeds.csv and map.csv."""

import csv
from functools import cache

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from scipy.ndimage import maximum_filter1d

import camcli
from camcli.plots.discs import Discs
from tests.conftest import some_in_ci
from tests.support.machines import CHAPTER, VALVE
from tests.support.picture_reader import (
    COLOURS,
    check,
    hexed,
    motion_colour,
    panels_of,
    read_page,
    usual,
)

FILLED = 5  # cells: the most that a speed fills
MOST_ROWS = 480  # cells below one another in a panel, at least: closer points may be one disc
OPAQUE = 0.1  # share of the points of a speed from which they are opaque
PALER = 0.3  # opacity of what is carried down
ROUNDING = 1e-6  # cells
CASES = {
    "chapter": (
        CHAPTER,
        {
            "sweep.rpm": {"start": 660, "stop": 760, "num": 21}, "run.transient": 300,
            "run.record": 40, "sweep.lyapunov": True,
            "sweep.zoom": [{"start": 680, "stop": 700, "num": 6},
                           {"start": 750, "stop": 735, "num": 4}],
        },
    ),
    "valve": (
        VALVE,
        {"sweep.rpm": {"start": 2600, "stop": 3400, "num": 9}, "sweep.explain": True},
    ),
    "both ways": (
        VALVE,
        {"sweep.rpm": {"start": 5600, "stop": 5000, "num": 16}, "sweep.direction": "both",
         "sweep.also": [{"q": 0.02, "v": 1.0}, {"q": 0.03}]},
    ),
    "restitution": (
        VALVE,
        {"sweep.vary": [{"key": "follower.restitution", "start": 0.2, "stop": 0.7, "num": 8}],
         "run.impact_budget": 12, "run.rpm": 3000},
    ),
    "at rest": (VALVE, {"sweep.rpm": {"start": 500, "stop": 900, "num": 3}}),
}  # fmt: skip
AXES = {"rpm": "cam speed (rpm)", "follower.restitution": "coefficient of restitution $r$ (-)"}
SOLVED = {  # made up, in every branch one point beyond the range
    "chapter": [
        [(660.0, 0, 150.0, 120.0, 0.15), (690.0, 0, 152.0, 110.0, 0.16),
         (700.0, 1, 153.0, 100.0, 0.17), (770.0, 1, 154.0, 90.0, 0.18)],
    ],
    "both ways": [
        [(5100.0, 1, 200.0, None, 0.004), (5300.0, 1, 210.0, None, 0.006)],
        [(5200.0, 0, 100.0, 140.0, 0.003), (5400.0, 0, 110.0, 150.0, 0.002)],
    ],
}  # fmt: skip


@cache
def made(name, branches=None):
    machine, values = CASES[name]
    more = {} if branches is None else {"sweep.branches": branches}
    return camcli.sweep(machine.load({**values, **more}))


def written(name, folder):
    """A branch.csv of the branches."""
    path = folder / "branch.csv"
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["branch", "label", "rpm", "stable", "theta_deg_1", "theta_deg_2", "q_m"])
        for number, points in enumerate(SOLVED[name], 1):
            for rpm, stable, one, two, q in points:
                rows.writerow([number, "P(1;2)", rpm, stable, one, two, q])
    return str(path)


def kind_of(label):
    """In which words, and with which colour, the motion is shown."""
    if not label.startswith("P("):
        return label, COLOURS[label]
    if "inf" in label:
        return "with rests", COLOURS["sticking"]
    period = int(label[2:].partition(";")[0])
    return (f"period {period}" if period <= 4 else "longer periods"), motion_colour(label)


def thick(counts, aside):
    """Of the cells up to so many below and above each, the largest count."""
    return maximum_filter1d(counts, 2 * aside + 1, axis=0, mode="constant")


def check_cloud(panel, points, kinds, fills=True, ways=None):
    """The points of each kind are discs, or for some values cells of an image; of both ways apart.

    points: rows (value, y or nan, kind); kinds: colours by name, in the order they are drawn;
    fills: the images are as wide as the panel; ways: up or down of each point.
    """
    discs, images = {}, {}
    for one in panel.images():
        artist = one.artist
        is_disc = isinstance(artist, Discs)
        colour = hexed(artist.colour if is_disc else artist.cmap(1.0))
        down = artist.larger > 1.0 if is_disc else artist.cmap(1.0)[3] < 0.5
        found = discs if is_disc else images
        assert (colour, down) not in found
        found[colour, down] = one
    (begin, end), (low, high) = panel.axes.get_xlim(), panel.axes.get_ylim()
    every = sorted({x for x, *_ in points})
    for kind, colour in kinds.items():
        for way, opacity in {"up": 1.0, "down": PALER}.items() if ways else [("", 1.0)]:
            some = [k for k in range(len(points)) if not ways or ways[k] == way]
            own = [points[k][:2] for k in some if points[k][2] == kind]
            seen = [(x, y) for x, y in own if begin <= x <= end]
            disc, image = (found.pop((colour, way == "down"), None) for found in (discs, images))
            if not any(low <= y <= high for _, y in seen):
                assert disc is None
                assert image is None
                continue
            opacities = opacity * (1.0 if kind == "contact" else 0.5), opacity
            shown = set() if disc is None else check_discs(disc.artist, seen, low, high, opacities)
            others = [(x, y) for x, y in seen if x not in shown]
            assert (image is not None) == any(low <= y <= high for _, y in others)
            if image is not None:
                check_image(panel, image, others, every, fills, 3 if way == "down" else 1)
                artist = image.artist
                ends = artist.to_rgba(artist.norm.vmin)[3], artist.to_rgba(artist.norm.vmax)[3]
                assert ends == pytest.approx(opacities)
                assert artist.to_rgba(np.ma.masked_all(1))[0][3] == 0.0
                assert artist.norm.vmin < artist.norm.vmax == OPAQUE
    assert not discs
    assert not images


def check_discs(artist, own, low, high, opacities):
    """A disc at each point, exactly where it has no other near, or one for several that are close.

    The more of the points of its value it has, the more opaque it is.

    own: rows (value, y or nan); low, high: ends of the panel. Returns the values with discs.
    """
    places, shades = artist.places, artist.opacity
    by_value: dict = {x: [] for x, _ in own}
    for x, y in own:
        by_value[x] += [y] if np.isfinite(y) else []
    by_value = {x: np.array(found) for x, found in by_value.items()}
    palest, opaque = opacities
    shares, shown = [], []  # of the points without another one near
    close = (high - low) / MOST_ROWS
    assert set(places[:, 0]) <= set(by_value)
    for x in set(places[:, 0]):
        every = by_value[x]
        y = np.unique(every[(every >= low) & (every <= high)])
        mine = places[:, 0] == x
        at, shade = places[mine, 1], shades[mine]
        apart = np.abs(y[:, None] - at)
        assert apart.min(axis=1).max() <= close
        assert apart.min(axis=0).max() <= close
        assert len(at) <= len(y)
        lonely = [k for k in range(len(y)) if np.count_nonzero(np.abs(y - y[k]) <= 2 * close) == 1]
        for k in lonely:
            (disc,) = np.flatnonzero(apart[k] <= close)
            assert apart[k, disc] <= 1e-5 * (high - low)
            shares.append(np.count_nonzero(every == y[k]) / len(every))
            shown.append(shade[disc])
            if shares[-1] >= OPAQUE:
                assert shown[-1] == pytest.approx(opaque)
        assert palest - 1e-9 <= shade.min() <= shade.max() <= opaque + 1e-9
    order = np.argsort(shares, kind="stable")
    assert (np.diff(np.array(shown)[order]) >= -1e-9).all()
    return set(places[:, 0])


def whole(image, axes, fills):
    """The cells of an image with the blank ones around it, up to the ends of the panel.

    Returns them with their ends on both axes. fills: to the right and left too, where the image of
    a cloud is as wide as its panel.
    """
    cells, ends = image.values, []
    for k, (begin, end, limits) in enumerate(
        ((image.low, image.high, axes.get_ylim()), (image.left, image.right, axes.get_xlim()))
    ):
        cell = (end - begin) / cells.shape[k]
        before, after = ((begin - limits[0]) / cell, (limits[1] - end) / cell)
        if k == 1 and not fills:
            ends += [begin, end]
            continue
        blank = round(before), round(after)
        assert (before, after) == pytest.approx(blank, abs=1e-4)  # on one grid, none cut
        pad = [blank, (0, 0)] if k == 0 else [(0, 0), blank]
        mask = np.pad(np.ma.getmaskarray(cells), pad, constant_values=True)
        cells = np.ma.array(np.pad(cells.filled(0.0), pad), mask=mask)
        ends += limits
    return cells, ends[2], ends[3], ends[0], ends[1]


def check_image(panel, image, own, every, fills, common):
    """In each speed's columns the share of its points in each cell, and so many above and below.

    own: rows (value, y or nan); every: all values there are, of which each has its columns.
    """
    values, left, right, low, high = whole(image, panel.axes, fills)
    rows, wide = values.shape
    sure, counts = np.ones(wide, bool), np.zeros(values.shape)
    centres = left + (np.arange(wide) + 0.5) * (right - left) / wide
    cell = (right - left) / wide
    every = [x for x in every if left <= x <= right]
    nearest = np.array([min(every, key=lambda x: abs(x - at)) for at in centres])
    for value in sorted({x for x, _ in own if left <= x <= right}):
        y = np.array([at for x, at in own if x == value and np.isfinite(at)])
        inside = (y >= low) & (y <= high)
        row = ((y[inside] - low) / (high - low) * rows).astype(int)
        there = np.bincount(np.minimum(row, rows - 1), minlength=rows) / max(1, len(y))
        away = np.abs(centres - value) / cell
        columns = (nearest == value) & (away <= FILLED / 2.0 + ROUNDING)
        assert columns.any()
        counts[:, columns] = there[:, None]
        sure[columns & (away > FILLED / 2.0 - ROUNDING)] = False
    expected = thick(counts, common)
    assert np.allclose(values.filled(0.0)[:, sure], expected[:, sure], rtol=1e-6, atol=1e-12)


def kinds_of(speeds):
    """Name and colour of each row; what came to a rest while it was watched has its own name."""
    return [
        ("undecided after rests", kind_of(label)[1])
        if label == "undecided" and np.isfinite(watched)
        else kind_of(label)
        for label, watched in zip(speeds["label"], speeds["watched_turns"], strict=True)
    ]


def checks(name, result, branches=()):
    machine, values = CASES[name]
    tables, key = result.tables, next(iter(result.tables["speeds"]))
    speeds = {n: tables["speeds"][n] for n in tables["speeds"]}
    ways = [n for n in speeds if n in ("direction", "start")]
    labels = {
        (value, *rest): kind
        for value, kind, *rest in zip(speeds[key], kinds_of(speeds), *(speeds[n] for n in ways),
                                      strict=True)
    }  # fmt: skip
    kinds = dict(sorted({*labels.values()}))
    clouds, carried = {}, {}
    for section, column in (("impacts", "theta_deg"), ("strobe", "q_m")):
        table = tables[section]
        clouds[section] = [
            (value, y, labels[(value, *rest)][0])
            for value, y, *rest in zip(table[key], table[column], *(table[n] for n in ways),
                                       strict=True)
        ]  # fmt: skip
        if "direction" in ways:
            carried[section] = list(table["direction"])
    zooms = [sorted((z["start"], z["stop"])) for z in values.get("sweep.zoom", ())]
    events = result.summary.get("events", ())
    limits, places, letters = {}, {}, {}
    for panel in panels_of(result):
        limits[panel.name], places[panel.name] = panel.axes.get_ylim(), panel.axes.get_xlim()
        letters[panel.name] = panel.axes.get_title(loc="left")
    first = next(iter(limits))

    def cloud(panel, section):
        check_cloud(panel, clouds[section], kinds, ways=carried.get(section))
        begin, end = panel.axes.get_xlim()
        seen = [y for x, y, _ in clouds[section] if begin <= x <= end]
        if "zoom" in panel.name and np.ptp(seen) < 100.0:  # no more than what is in the zoom
            low, high = panel.axes.get_ylim()
            assert low <= min(seen) <= max(seen) <= high
            assert high - low <= 1.09 * np.ptp(seen) or np.ptp(seen) < 1e-3 * max(seen)
        panel.key(*kinds.items())
        for way, wide in (("up", 1.0), ("down", 3.0)) if carried else ():
            (line,) = panel.lines("cam", f"carried {way}", count=1)
            assert (line.get_linewidth(), line.get_alpha()) == (
                wide,
                PALER if wide > 1.0 else None,
            )
        if panel.name == first:
            low, high = panel.axes.get_xlim()
            for number, event in enumerate(events, 1):
                if low <= event["rpm"] <= high:
                    text = panel.words(str(number))
                    assert text.xy == (event["rpm"], 1.0)
        for event in events:
            panel.guide("x", event["rpm"], "cam", "dotted")
        solved(panel, section)
        trouble(panel)
        below = panel.name == "strobe" and "strobe enlarged" in limits  # shares its numbers
        assert panel.axes.get_xlabel() == ("" if below and branches else AXES[key])
        if panel.name == section or panel.name == "strobe enlarged":
            for number in range(1, len(zooms) + 1):
                name = f"{section} zoom {number}"
                panel.band("x", *places[name], "band")
                panel.words(letters[name])

    def solved(panel, section):
        low, high = panel.axes.get_xlim()
        for branch in branches:
            x, stable, one, two, q = (np.array(c, dtype=float) for c in zip(*branch, strict=True))
            x = np.where((x >= low) & (x <= high), x, np.nan)
            for y in [q] if section == "strobe" else [one, two]:
                for own, style, what in (
                    (stable, "solid", "stable"),
                    (1 - stable, "dashed", "unstable"),
                ):
                    seen = np.where(own == 1, y, np.nan)
                    low_y, high_y = panel.axes.get_ylim()
                    if "enlarged" not in panel.name:  # its range holds the branches too
                        drawn = seen[np.isfinite(x) & np.isfinite(seen)]
                        assert ((drawn >= low_y) & (drawn <= high_y)).all()
                    panel.line(x, seen, "white", label=False, width=1.8)
                    panel.line(x, seen, "trouble", style, f"solved, {what}", width=0.8)

    def trouble(panel):
        low, high = panel.axes.get_xlim()
        bad = np.sort(speeds[key][speeds["status"] != "ok"])
        bad = bad[(bad >= low) & (bad <= high)]
        if len(bad):
            (ticks,) = panel.pick(object, lambda a: getattr(a, "get_marker", str)() == "|")
            assert ticks.get_xdata() == pytest.approx(bad)
            assert hexed(ticks.get_color()) == COLOURS["trouble"]

    def impacts(panel):
        if not clouds["impacts"]:
            panel.words("no impact at any of these speeds", 0.5, 0.5)
            assert panel.axes.get_ylim() == (0.0, 360.0)
        cloud(panel, "impacts")
        panel.corners(machine.cam.corners, "y", named=True)
        if clouds["impacts"]:
            words = ", enlarged" if panel.name == "enlarged" else ""
            panel.reads("y", r"impact phase $\theta$ (deg)" + words)
        if panel.name == "impacts":
            at = [y for _, y, _ in clouds["impacts"]]
            assert not at or (limits["impacts"][0] <= min(at) and max(at) <= limits["impacts"][1])
        for k, axes in enumerate(panel.besides):
            beside(axes, panel, k)

    def beside(axes, panel, k):
        line = max(axes.lines, key=lambda a: len(a.get_xdata()))
        x, theta = line.get_data()
        seen = np.isfinite(theta)
        lift = machine.cam.lift(theta)[k] * machine.per_m
        away = np.abs(x - lift)[seen] / np.abs(lift[seen]).max()
        at_corner = np.min([np.abs(theta[seen] - c) for c in machine.cam.corners.values()], axis=0)
        assert away[at_corner > 1e-6].max() < 1e-12
        assert theta[seen].min() == pytest.approx(0.0, abs=1e-9)
        assert theta[seen].max() == pytest.approx(360.0)
        assert np.diff(np.unique(theta[seen])).max() < 1.0
        assert hexed(line.get_color()) == COLOURS["cam"]
        assert axes.get_ylim() == panel.axes.get_ylim()
        lines = [
            c for c in machine.cam.corners.values() if axes.get_ylim()[0] <= c <= axes.get_ylim()[1]
        ]
        others = sorted(a.get_ydata()[0] for a in axes.lines if a is not line)
        assert others == pytest.approx(sorted(lines))
        assert panel.axes.get_ylabel() == ""
        if panel.name == "impacts":
            names = ["$c$", r"$c_\theta$", r"$c_{\theta\theta}$"]
            assert axes.get_title(loc="center") == names[k]
            assert axes.get_xlabel() == machine.unit + ("", "/rad", "/rad²")[k]

    def strobe(panel):
        cloud(panel, "strobe")
        at = f", $\\theta$ = {machine.strobe_deg:g} deg" if machine.strobe_deg else ""
        words = ", enlarged" if panel.name == "strobe enlarged" else ""
        panel.reads("y", f"stroboscopic $q$ ({machine.unit}){at}{words}", machine.per_m)
        if panel.name == "strobe" and "strobe enlarged" in limits:
            panel.band("y", *limits["strobe enlarged"], "band")
            panel.words(letters["strobe enlarged"])

    def exponents(panel):
        panel.guide("y", 0.0, "guide")
        (dots,) = panel.pick(PathCollection)
        known = np.isfinite(speeds["lyapunov_per_period"])
        x, y = np.asarray(dots.get_offsets()).T
        assert x == pytest.approx(speeds[key][known])
        assert y == pytest.approx(speeds["lyapunov_per_period"][known])
        wanted = [kind_of(label)[1] for label in speeds["label"][known]]
        assert [hexed(c) for c in dots.get_facecolors()] == wanted
        trouble(panel)
        panel.reads("y", "exponent\n(1/turn)")
        assert panel.axes.get_xlabel() == AXES[key]

    return {
        "impacts": impacts, "enlarged": impacts, "impacts zoom": impacts, "strobe": strobe,
        "strobe enlarged": strobe, "strobe zoom": strobe, "exponents": exponents,
    }  # fmt: skip


@pytest.mark.parametrize("name", some_in_ci(CASES, quick=["both ways", "at rest"]))
def test_every_panel_of_a_sweep_shows_the_rows_of_its_tables(name, tmp_path):
    branches = SOLVED.get(name, [])
    result = made(name, written(name, tmp_path) if branches else None)
    check(result, checks(name, result, branches))


HEADINGS = {
    "chapter": (
        "Bifurcation diagram, 660 to 760 rpm",
        "each speed started at rest on the cam, 300 turns of transient; 25 speeds; 1 undecided "
        "after rests, grey; darker where more points fall",
    ),
    "valve": (
        "Bifurcation diagram, 2600 to 3400 rpm",
        "each speed started at rest on the cam, 60 turns of transient; 9 speeds; darker where "
        "more points fall; the stroboscopic position is always the same, and is not drawn",
    ),
    "both ways": (
        "Bifurcation diagram, 5000 to 5600 rpm",
        "carried up, then down, started at rest on the cam, and at q = 0.02 m, v = 1 m/s, "
        "and at q = 0.03 m, the cam's v; 60 turns of transient at each speed; 16 speeds; darker",
    ),
    "restitution": (
        "Bifurcation diagram, coefficient of restitution 0.2 to 0.7 at 3000 rpm",
        "each value started at rest on the cam, 60 turns of transient; 8 values; 1 not ok, marked "
        "at the bottom edge (impact-budget 1); darker",
    ),
    "at rest": ("Bifurcation diagram, 500 to 900 rpm", "3 speeds; darker"),
}


@pytest.mark.parametrize("name", CASES)
def test_the_page_of_a_sweep_says_what_was_done_and_what_changes_the_motion(name):
    result = made(name)
    page = read_page(result)
    title, words = HEADINGS[name]
    zooms = ["impacts zoom 1", "impacts zoom 2", "strobe zoom 1", "strobe zoom 2"]
    more = {"chapter": ["enlarged", "strobe", "exponents", *zooms], "valve": ["enlarged"]}
    assert usual(result)[1:] == more.get(name, usual(result)[1:])
    assert page.texts[0] == title
    page.says(words)
    ways = {"carried up", "carried down"} if "both" in CASES[name][1].values() else set()
    assert {*page.legend} == {name for name, _ in kinds_of(result.tables["speeds"])} | ways
    for number, event in enumerate(result.summary.get("events", ()), 1):
        what = event["kind"].replace("-", " ")
        if event["corner"]:
            what += f" {event['corner']}" if what.endswith("corner") else f" at {event['corner']}"
        label = event["label"].replace("inf", "∞")
        page.row(str(number), what, f"{event['rpm']:.5f}", label)
