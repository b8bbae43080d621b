"""The picture of detachment and the page of its report, against tables and the force itself."""

import io
from functools import cache
from math import inf

import numpy as np
import pytest
from matplotlib.figure import Figure

import camcli
from camcli.analysis.contact_loss.spread import Spread
from camcli.output.pictures import caption_in
from camcli.plots.detach import draw_detach
from camcli.words.detach_tables import lists_of_motions
from tests.support.machines import CHAPTER, VALVE, off_corners
from tests.support.picture_reader import (
    COLOURS,
    FORCES,
    Panel,
    check,
    dashes,
    hexed,
    read_page,
    usual,
)
from tests.support.picture_sizes import check_texts

CASES = {
    "chapter": (
        CHAPTER,
        {"detach.rpm": {"start": 112, "stop": 210, "num": 30}, "detach.hold_to": 300.0,
         "detach.impacts": 3},
    ),
    "valve": (
        VALVE,
        {"detach.rpm": {"start": 3400, "stop": 2600, "num": 15}, "detach.hold_to": 3600.0,
         "detach.impacts": 3, "detach.margin_n": 0.0, "detach.force_rpm": [2500, 2682, 3000, 3300]},
    ),
    "held": (VALVE, {"detach.rpm": {"start": 1000, "stop": 1200, "num": 3}}),
    "lost": (
        VALVE, {"detach.rpm": {"start": 3000, "stop": 3100, "num": 3}, "follower.preload": -500.0},
    ),
}  # fmt: skip


@cache
def made(name):
    machine, values = CASES[name]
    return camcli.detach(machine.load(values))


@cache
def simulated(name):
    """(rpm, phase) of the impacts of one turn, three turns after rest, by a sweep."""
    machine, values = CASES[name]
    more = {k: v for k, v in values.items() if k.startswith("follower")}
    more |= {"sweep.rpm": values["detach.rpm"], "run.transient": 3, "run.record": 2}
    table = camcli.sweep(machine.load(more)).tables["impacts"]
    first = table["period"] == 0
    return table["rpm"][first], table["theta_deg"][first]


def check_forces(panel, machine, curves, where=""):
    """Curves of the contact force over the turn: (rpm, stiffness, preload) of each, in order."""
    shades = FORCES[1:2] if len(curves) == 1 else FORCES
    names = [text.get_text() for text in panel.axes.get_legend().get_texts()]
    lines = [a for a in panel.axes.lines if len(a.get_xdata()) > 10]
    for k, (rpm, stiffness, preload) in enumerate(curves):
        line = lines[k]
        theta, force = line.get_data()
        wanted = machine.force(rpm, theta, stiffness, preload)
        smooth = off_corners(machine.cam, theta)
        assert np.abs(force - wanted)[smooth].max() < 1e-9 * np.abs(wanted).max()
        assert {*theta} >= {0.0, 360.0}
        assert np.diff(theta).max() < 1.5
        assert hexed(line.get_color()) == shades[k]
        assert dashes(line) == "solid"
        assert line.get_label() == names[k]
        dense = machine.force(rpm, machine.turn, stiffness, preload).min()
        least = names[k].rpartition("least ")[2].split(" N")[0].replace("−", "-")
        assert float(least) == pytest.approx(dense, abs=2e-3 * max(1.0, abs(dense)))
        panel.left.remove(line)
    panel.guide("y", 0.0, "guide")
    low, _ = panel.axes.get_ylim()
    if low < 0.0 and min(a.get_ydata().min() for a in lines) < 0.0:
        panel.band("y", low, 0.0, "pull")
    panel.corners(machine.cam.corners, "x")
    panel.reads("y", "contact force (N)")
    assert panel.axes.get_xlim() == (0.0, 360.0)
    assert panel.axes.get_xlabel() == r"cam angle $\theta$ (deg)"
    assert panel.title == where
    return names


def checks(name, result):
    machine, values = CASES[name]
    tables = result.tables
    critical = list(zip(*(tables["detach"][c] for c in ("quantity", "region", "theta_deg", "rpm")),
                        strict=True))  # fmt: skip
    first = [(rpm, theta) for what, _, theta, rpm in critical if what == "first_detachment"]

    def phases(panel):
        low, high = panel.axes.get_ylim()
        slow, fast = panel.axes.get_xlim()
        # the axis of phases begins where the region opens whose bursts have most to show
        opens = {region: theta for what, region, theta, _ in critical if what == "opens"}
        fold = 0.0
        if np.isfinite(low) and first:
            begins = [theta for theta in opens.values() if low < theta < low + 12.0]
            fold = begins[0] - 1e-6 if begins else 0.5 * (low + high) - 180.0
        folded = lambda theta: fold + (np.asarray(theta, float) - fold) % 360.0  # noqa: E731
        rpm, theta = rpm_of, theta_of = simulated(name)
        panel.dots(rpm, folded(theta), "o", "simulated", label="impacts, simulated", close=1e-12)
        ends = panel.lines("chatter", "end of the chatter, computed")
        points = []
        for line in ends:
            assert dashes(line) == "solid"
            x, y = line.get_data()
            gaps = np.isnan(y)
            points += list(zip(x[~gaps], y[~gaps], strict=True))
            jump = np.abs(np.diff(y)) > 20.0
            assert not jump.any()
            assert (np.diff(x)[~gaps[1:] & ~gaps[:-1]] > 0.0).all()
        table = tables["accumulation"]
        wanted = sorted(zip(table["rpm"], folded(table["theta_deg"]), strict=True))
        assert np.array(sorted(points)).reshape(-1, 2) == pytest.approx(
            np.array(wanted).reshape(-1, 2)
        )
        for rpm, theta in first:
            panel.marks([rpm], folded([theta]), "detachment", "first detachment")
        corner = [(r, folded(t)) for what, _, t, r in critical if what == "accumulation_at_corner"]
        lost = []
        for what, _, theta, rpm in critical:
            if what == "completion_loss":  # at the phase at which the axis begins: where it ends
                at = folded(theta) + (360.0 if folded(theta) - fold < 1e-3 else 0.0)
                on_corner = min(abs(theta - c) for c in [*machine.cam.corners.values(), inf]) < 1e-3
                (corner if on_corner else lost).append((rpm, at))
        for marked, where in ((corner, "on a corner"), (lost, "where contact is lost")):
            if marked:
                words = f"the chatter ends {where}"
                panel.marks(*zip(*marked, strict=True), "chatter", words)
        hits = tables["corner_hits"]
        at = folded([machine.cam.corners[c] for c in hits["corner"]])
        at_hits = at
        if len(at):
            panel.marks(hits["rpm"], at, "corner-impact", "n-th impact on a corner", close=1e-6)
        told = []
        inside = (hits["rpm"] > slow) & (hits["rpm"] < fast) & (at > low) & (at < high)
        above = len({*hits["corner"][inside]}) == 1
        for note in [a for a in panel.left if hasattr(a, "xyann")]:
            k = int(np.argmin(np.abs(hits["rpm"] - note.xy[0])))
            assert note.xy == pytest.approx((hits["rpm"][k], 1.0 if above else at[k]))
            assert note.get_text() == str(hits["impact"][k])
            told.append(k)
            panel.left.remove(note)
            if above:
                panel.guide("x", hits["rpm"][k], "cam", "dotted")
        assert bool(told) == inside.any()
        assert not above or sorted(told) == np.flatnonzero(inside).tolist()
        lines = {f"{n} {turn}": float(folded(c)) + turn for n, c in machine.cam.corners.items()
                 for turn in (0.0, 360.0)}  # fmt: skip
        seen = {n: at for n, at in lines.items() if low <= at <= high}
        for at in seen.values():
            panel.guide("y", at, "guide")
        for n in sorted(seen, key=seen.get):
            panel.words(n.partition(" ")[0])
        speeds = values["detach.rpm"]
        margin = 0.03 * abs(speeds["stop"] - speeds["start"])
        if panel.name == "phases":
            ends = sorted((speeds["start"], speeds["stop"]))
            assert fast == pytest.approx(ends[1] + margin)
            shown = [*rpm_of, *table["rpm"], *hits["rpm"], *(r for r, _ in first)]
            least = min((x for x in shown if ends[0] - margin < x < fast), default=ends[0])
            if least - ends[0] + margin <= 0.15 * (ends[1] - ends[0] + 2.0 * margin):
                assert slow == pytest.approx(ends[0] - margin)
            else:  # no empty speeds below what there is to see
                assert slow == pytest.approx(least - 0.06 * (fast - least))
            phases = [
                *theta_of,
                *table["theta_deg"],
                *(t for _, t in first),
                *(t for _, t in corner + lost),
            ]
            phases = np.unique(np.mod([*phases, *at_hits], 360.0))
            gap = np.diff([*phases, phases[0] + 360.0]).max() if len(phases) else 0.0
            completed = any(what == "completion_loss" for what, *_ in critical)
            if gap < 90.0 or completed or not any(ends[0] - margin < x < fast for x in shown):
                assert high - low >= 360.0
            else:  # no empty phases either
                assert high - low == pytest.approx(
                    360.0 - gap + 2.0 * max(0.06 * (360.0 - gap), 4.0)
                )
        further = ",\non into the next turn" if high > 360.0 else ""
        assert panel.labels == ("cam speed (rpm)", rf"phase $\theta$ (deg){further}")
        numbers = panel.axes.yaxis.get_major_formatter()
        assert numbers(fold + 30.0) == f"{(fold + 30.0) % 360.0:g}"

    def forces(panel):
        table = tables["force"]
        rpms = list(dict.fromkeys(table["rpm"]))
        names = check_forces(panel, machine, [(rpm, None, preload) for rpm in rpms])
        for rpm, text in zip(rpms, names, strict=True):
            assert text.startswith(f"{rpm:.6g} rpm: least ")
            at = float(text.rpartition(" at ")[2].removesuffix(" deg"))
            force = machine.force(rpm, machine.turn, None, preload)
            low = min(float(machine.force(rpm, at + d, None, preload)) for d in (-1e-2, 0.0, 1e-2))
            assert low <= force.min() + 2e-3 * np.ptp(force)

    def springs(panel):
        rpm = values["detach.hold_to"]
        holds = [h for h in result.summary["hold"] if h["stiffness"] is not None]
        curves = [(rpm, None, None), *((rpm, h["stiffness"], h["preload"]) for h in holds)]
        names = check_forces(panel, machine, curves, f"at {rpm:g} rpm")
        assert names[0].startswith("present spring: least ")
        for hold, text in zip(holds, names[1:], strict=True):
            rounded = float(f"{hold['stiffness'] / machine.per_m:.4g}")
            rate = f"{rounded:.10g} {machine.spring_unit}"  # without a power of ten
            assert text.startswith(f"{rate}, preload {hold['preload']:.4g} N: least ")

    preload = values.get("follower.preload")
    return {"enlarged": phases, "phases": phases, "forces": forces, "springs": springs}


@pytest.mark.parametrize("name", CASES)
def test_every_panel_of_detachment_shows_the_rows_of_its_tables(name):
    result = made(name)
    seen = check(result, checks(name, result))
    assert seen == {"phases", "forces"} | (
        {"springs"} if "detach.hold_to" in CASES[name][1] else set()
    ) | ({"enlarged"} if name == "chapter" else set())


def test_the_page_of_detachment_says_where_contact_is_lost():
    assert usual(made("chapter")) == ["enlarged", "phases", "forces", "springs"]
    page = read_page(made("chapter"))
    page.says(
        "112 to 210 rpm",
        "contact is first lost at 114.979326744 rpm, 150.179371 deg; chatter stops being complete "
        "at 198.5605 rpm",
    )
    page = read_page(made("valve"))
    page.says("2600 to 3400 rpm", "contact is first lost at 2682.06256923 rpm, 196.816211 deg")
    read_page(made("held")).says("1000 to 1200 rpm", "contact is first lost at 2682.06")
    read_page(made("lost")).says("contact is lost at every speed")


@pytest.mark.parametrize("name", ["chapter", "valve", "held"])
def test_the_page_of_the_report_shows_the_cam_the_forces_and_the_loads(name, monkeypatch):
    machine, values = CASES[name]
    pages = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: pages.append(self))
    result = camcli.detach(machine.load(values), report=True)
    result.files["report.pdf"](io.BytesIO())
    (figure,) = pages
    _, outline, forces, loft, landing, springs = figure.axes
    assert outline.get_title().splitlines()[-1].startswith(r"$\theta$ = 0 deg")
    panel = Panel("forces", forces)
    rpms = list(dict.fromkeys(result.tables["force"]["rpm"]))
    check_forces(panel, machine, [(rpm, None, None) for rpm in rpms])
    panel.done()
    table = result.tables["speeds"]
    first = result.tables["detach"]["rpm"][0]
    for axes, column, words, factor in (
        (loft, "max_gap_m", f"largest gap ({machine.unit})", machine.per_m),
        (landing, "max_impact_m_per_s", "hardest impact (m/s)", 1.0),
    ):
        panel = Panel(column, axes)
        if len(table["rpm"]):
            (line,) = axes.lines
            rpm, y = map(np.asarray, line.get_data())
            assert rpm == pytest.approx(np.linspace(first, table["rpm"][-1], 200), rel=1e-12)
            assert (y[0], y[-1]) == (0.0, pytest.approx(factor * table[column][-1], rel=1e-12))
            own = {"start": rpm[60], "stop": rpm[60], "num": 1}
            again = {"sweep.rpm": own, "run.transient": 20, "run.record": 20, "run.start": {}}
            swept = camcli.sweep(machine.load({**values, **again})).tables["speeds"]
            assert y[60] == pytest.approx(factor * swept[column][0], rel=1e-9)
            panel.dots(rpm, y, "o", "impact", style="solid")
            assert axes.get_ylim()[0] == 0.0
            assert panel.labels == ("cam speed (rpm)", words)
        else:
            panel.words("contact holds over the whole range", 0.5, 0.5)
            assert axes.get_ylabel() == words
        panel.done()
    panel = Panel("springs", springs)
    rpm = values.get(
        "detach.hold_to", max(values["detach.rpm"]["start"], values["detach.rpm"]["stop"])
    )
    holds = [h for h in result.summary["hold"] if h["stiffness"] is not None]
    curves = [(rpm, None, None), *((rpm, h["stiffness"], h["preload"]) for h in holds)]
    check_forces(panel, machine, curves, f"at {rpm:g} rpm")
    panel.done()


def words_of(figure):
    """Everything that is written above the panels of a page, as one line."""
    return " ".join(" ".join(text.get_text() for text in figure.axes[0].texts).split())


def overlaps(figure):
    """Legends of panels that reach into the words above, or into another panel or its legend."""
    figure.draw_without_rendering()
    top = figure.axes[0].get_window_extent().y0
    boxes = [(axes, axes.get_window_extent()) for axes in figure.axes[1:]]
    legends = [(axes, axes.get_legend().get_window_extent()) for axes in figure.axes[1:]
               if axes.get_legend()]  # fmt: skip
    return [
        axes.get_ylabel()
        for axes, box in legends
        if box.y1 > top + figure.dpi / 25.4  # a millimetre, its blank border
        or any(box.overlaps(other) for own, other in (*boxes, *legends) if own is not axes)
    ]


@pytest.mark.ci
def test_a_report_with_everything_in_it_has_two_pages_and_loses_nothing(monkeypatch):
    """Lash, surge, Hertz pressure, springs, tolerances: more than one page has room for."""
    values = {
        "cam.lash": 0.0002, "spring": {"mass": 0.06, "in_follower": True},
        "contact": {"width": 0.012, "base_radius": 0.036, "face": "flat"},
        "detach.tolerance": [{"key": "follower.mass", "percent": 5.0},
                             {"key": "follower.stiffness", "percent": 3.0}],
        "detach.machines": 3, "detach.hold_to": 4000.0, "run.rpm": 3200.0,
        "detach.rpm": {"start": 3000, "stop": 4000, "num": 9},
    }  # fmt: skip
    pages = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: pages.append(self))
    result = camcli.detach(camcli.load_scene("configs/lift-table.yaml", values), report=True)
    result.files["report.pdf"](io.BytesIO())
    one, two = pages
    for page in pages:
        assert (page.left_out, page.has_room, overlaps(page)) == ([], True, [])
        assert page.get_figheight() <= 267.5 / 25.4
        high = [axes.get_position().height * page.get_figheight() for axes in page.axes[1:]]
        assert min(high) > 0.8  # inches
        check_texts(page)
    largest = 0.036 + np.ptp(result.system.lift_range)  # the face is drawn on the pitch curve
    drawn = f"lash 0.2 mm, drawn {0.08 * largest / 0.0002:.2g} times as wide"
    assert drawn in one.axes[1].get_title(loc="left")
    assert [axes.get_ylabel() for axes in one.axes[2:]] == [
        "contact force (N)", "largest gap (mm)", "hardest impact (m/s)",
    ]  # fmt: skip
    assert [axes.get_ylabel() for axes in two.axes[1:]] == [
        "contact force (N)", "resonance factor", "machines", "",
    ]  # fmt: skip
    assert two.axes[-1].texts[0].get_text().startswith("too few machines to tell")
    assert (
        "On the second page: the motion past the loss of contact, force with other springs, "
        "surge, machines within their tolerances, which tolerance matters." in words_of(one)
    )
    assert "Past the loss of contact: 8 of 15 rows; more in speeds.csv" in words_of(two)
    assert "On the seat (*: the working speed): 8 of 16 rows; more in speeds.csv" in words_of(two)
    assert " 3200* " in words_of(two)
    assert all(way in words_of(one) for way in ("stiffer spring", "more preload", "another spring"))
    read = camcli.plot(result)  # the picture has all of them too, on its one page
    assert (read.left_out, overlaps(read)) == ([], [])
    assert len(read.axes) == 1 + len(["phases", "forces", "springs", "surge", "machines", "shares"])
    assert "Surge itself is not simulated." in read.caption
    assert "not simulated" in words_of(one)
    assert "simulated" not in " ".join(axes.get_title(loc="right") for axes in read.axes)


@pytest.mark.ci
def test_a_long_table_of_a_report_says_how_many_rows_it_leaves_out():
    values = {"cam.lash": 0.0002, "detach.rpm": {"start": 2500, "stop": 3000, "num": 2},
              "run.rpm": 2600.0}  # fmt: skip
    result = camcli.detach(VALVE.load(values))
    past, seat = lists_of_motions(result, 15)
    assert (past[0], seat[0]) == (["Past the loss of contact"],
                                  ["On the seat (*: the working speed): 15 of 16 rows; "
                                   "more in speeds.csv"])  # fmt: skip
    past, seat = lists_of_motions(result, 3)
    assert past[0] == ["Past the loss of contact: 3 of 15 rows; more in speeds.csv"]
    assert len(past) == len(seat) == 5
    kept = result.tables["speeds"]["rpm"][[0, 7, 14]]
    assert [row[0] for row in past[2:]] == [f"{rpm:.0f}" for rpm in kept]
    assert seat[2][0] == "2600*"
    assert seat[4][0] == "3000"


@pytest.mark.ci
def test_panels_without_room_are_told_below_the_picture_and_on_the_screen(cam, tmp_path):
    detach = "detach -c configs/lift-table.yaml --rpm 3400:3500 --points 2 -o out"
    low = cam(f"{detach} --height 60mm --format svg,png", code=0)
    told = "no room for forces (--panels draws them alone, --height a taller page)"
    assert f"note: detach.svg: {told}" in low.stderr.splitlines()
    assert caption_in(tmp_path / "out" / "detach.png").endswith(f" {told.capitalize()}.")
    assert "room" not in (tmp_path / "out" / "detach.svg").read_text().split("</metadata>")[1]
    tall = cam(f"{detach} --height 150mm", code=0)
    assert "room" not in tall.stderr + caption_in(tmp_path / "out" / "detach.png")
    assert "room" not in cam(f"{detach} --height 60mm -q", code=0).stderr


@pytest.mark.ci
def test_the_picture_shows_where_bounces_of_opening_blow_and_seat_end():
    """Past the loss of contact a valve rests three times a turn: it is hit, it floats, it shuts."""
    values = {"cam.lash": 0.0002, "follower.seat_restitution": 0.3,
              "detach.rpm": {"start": 2500, "stop": 3000, "num": 2}}  # fmt: skip
    result = camcli.detach(VALVE.load(values))
    (axes,) = [axes for axes in camcli.plot(result).axes if "phase" in axes.get_ylabel()]
    (crosses,) = [line for line in axes.lines if line.get_marker() == "x"]
    shown = sorted(zip(crosses.get_xdata(), np.mod(crosses.get_ydata(), 360.0), strict=True))
    rests = []
    for rpm in (2500.0, 3000.0):
        run = {"run.rpm": rpm, "run.transient": 3, "run.record": 1, "run.start": {}}
        events = camcli.simulate(VALVE.load({**values, **run})).tables["events"]
        lifted = False
        for kind, theta in zip(events["event"], events["theta_deg"], strict=True):
            lifted = lifted or kind == "detachment"
            if kind == "chatter":
                rests += [] if lifted else [(rpm, theta)]
                lifted = False
    assert np.array(shown) == pytest.approx(np.array(sorted(rests)), abs=1e-6)
    assert min(result.tables["accumulation"]["rpm"]) == 3000.0  # none of the lobe's at 2500 rpm


@pytest.mark.parametrize("lash", [None, 0.0002])
def test_the_picture_says_whose_bounces_its_line_and_crosses_follow_where_there_is_a_seat(lash):
    values = {"cam.lash": lash, "detach.rpm": {"start": 3400, "stop": 3500, "num": 2}}
    page = camcli.plot(camcli.detach(VALVE.load(values)))
    said = " ".join(text.get_text() for axes in page.axes for text in axes.texts)
    told = "Crosses are where those end that the opening blow or the seat begins."
    assert (told in page.caption) is (lash is not None)
    assert "Crosses" not in said  # no sentences above a plot


def test_machines_within_their_tolerances_are_counted_beside_the_machine_as_given():
    result = camcli.detach(CHAPTER.load({"detach.rpm": {"start": 112, "stop": 118, "num": 3}}))
    speeds = [112.0, 113.0, 113.5, 114.0, 114.2, 116.0, np.inf]
    spread = Spread(speeds, 111.0, {"follower.mass": 5.0}, {"follower.mass": 1.0})
    (known,) = result.tables["detach"]["rpm"][
        result.tables["detach"]["quantity"] == "first_detachment"
    ]
    picture = draw_detach(result.values, result.system, spread=spread)
    axes = picture.figure(result.scene.plot.model_copy(update={"panels": ("machines",)})).axes[1]
    assert sum(bar.get_height() for bar in axes.patches) == 6  # one is never thrown off
    assert min(bar.get_x() for bar in axes.patches) == 112.0
    lines = {line.get_label(): (line.get_xdata()[0], line) for line in axes.lines}
    places = {name: float(x) for name, (x, _) in lines.items()}
    assert places == {
        "half of the machines": 113.75,
        "the machine as given": pytest.approx(known, rel=1e-12),
        "the worst machine": 111.0,
    }
    strokes = [(hexed(line.get_color()), dashes(line)) for _, line in lines.values()]
    wanted = ("cam", "solid"), ("detachment", "dashed"), ("trouble", "dotted")
    assert strokes == [(COLOURS[colour], style) for colour, style in wanted]
    assert axes.get_title(loc="right") == "the worst up to 111 rpm"
