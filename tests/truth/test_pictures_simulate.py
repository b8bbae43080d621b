"""The picture of a simulation against trajectory.csv and events.csv."""

import io
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.text import Annotation

import camcli
from camcli.output import pictures
from camcli.plots import simulate as simulate_plots
from camcli.plots.simulate import Trace, _cubic, _fine
from tests.support.machines import CHAPTER, VALVE
from tests.support.picture_reader import (
    COLOURS,
    Panel,
    check,
    dashes,
    hexed,
    mixed,
    read_page,
    usual,
)

CONFIGS = Path(__file__).parents[2] / "configs"
TURNS = 2  # drawn, of three
RUNS = {  # machine, speed, samples a turn
    "chapter 190": (CHAPTER, 190.0, 120),
    "valve 2900": (VALVE, 2900.0, 120),
    "valve 3300": (VALVE, 3300.0, 120),
}


@cache
def made(name, finer=1):
    machine, rpm, samples = RUNS[name]
    values = {
        "run.rpm": rpm, "run.transient": 30, "run.record": 3, "simulate.plot_turns": TURNS,
        "simulate.samples": samples * finer,
    }  # fmt: skip
    return camcli.simulate(machine.load(values))


class Rows:
    """The drawn turns of trajectory.csv, with the angle counted on from turn to turn."""

    def __init__(self, name, finer=1):
        self.machine, self.rpm, _ = RUNS[name]
        result = made(name, finer)
        table, events = result.tables["trajectory"], result.tables["events"]
        self.per_s = 6.0 * self.rpm
        self.angle = self.machine.strobe_deg + self.per_s * table["t_s"]
        assert np.abs((self.angle - table["theta_deg"] + 180.0) % 360.0 - 180.0).max() < 1e-6
        self.low = self.machine.strobe_deg + 360.0 * (3 - TURNS)
        self.high = self.machine.strobe_deg + 360.0 * 3
        kept = self.angle > self.low - 1e-6
        self.every = {name: table[name] for name in table}
        self.angle = self.angle[kept]
        for own, column in (("q", "q_m"), ("v", "v_m_per_s"), ("state", "contact")):
            setattr(self, own, table[column][kept])
        c, c1, self.c2 = self.machine.cam.lift(self.angle)
        self.gap, self.u = self.q - c, self.v - c1 * np.radians(self.per_s)
        self.rests = self.state == "sticking"
        self.gap[self.rests] = 0.0
        self.events = {
            kind: (at := (events["event"] == kind)
                   & (events["t_s"] > (3 - TURNS - 1e-9) * 60.0 / self.rpm),
                   self.machine.strobe_deg + self.per_s * events["t_s"][at],
                   events["q_m"][at], events["u_minus_m_per_s"][at], events["u_plus_m_per_s"][at])
            for kind in dict.fromkeys(events["event"])
        }  # fmt: skip
        # between the last impact and the end of a chatter that its map closes: hops without rows
        turned = self.machine.strobe_deg + self.per_s * events["t_s"]
        self.closed = np.zeros(len(self.angle), bool)
        for k in np.flatnonzero(events["event"] == "chatter"):
            self.closed |= (self.angle >= turned[k - 1]) & (self.angle <= turned[k])
        # rows with a neighbour of another kind, or a corner, on one side belong to both
        inside = self.rests[1:-1]
        self.amid = np.zeros(len(self.rests), bool)
        self.amid[1:-1] = (self.rests[:-2] == inside) & (self.rests[2:] == inside)


def check_contact(panel, rows, fine, wanted, truth, named):
    """Flight, sticking and sticking on a slowing cam: each where it holds, through all rows."""
    slowing = rows.rests & (rows.c2 < -1e-6)
    near = np.zeros(len(rows.angle), bool)  # to where the cam's acceleration jumps
    for corner in rows.machine.cam.corners.values():
        near |= np.abs((rows.angle - corner + 180.0) % 360.0 - 180.0) < 4.0
    amid = rows.amid & ~near
    states = {
        "follower in flight": (~rows.rests, "flight", 1.0),
        r"sticking, $\ddot{c} \geq 0$": (rows.rests & ~slowing, "sticking", 3.0),
        r"sticking, $\ddot{c} < 0$": (slowing, "slowing", 3.0),
    }
    for name, (state, colour, width) in states.items():
        if not (state & amid).any():
            continue
        (line,) = panel.lines(colour, name if named else None, count=1)
        assert (line.get_linewidth(), dashes(line)) == (width, "solid")
        x, y = line.get_data()
        assert np.isnan(shown(x, y, rows.angle[~state & amid])).all(), name
        at = state & amid
        size = np.abs(wanted).max()
        assert np.abs(shown(x, y, rows.angle[at]) - wanted[at]).max() < 1e-9 * size, name
        between = shown(x, y, fine.angle)
        seen = np.isfinite(between) & ~fine.closed
        assert np.abs(between - truth)[seen].max() < 1e-3 * size, name


def shown(x, y, at):
    """What a line shows at places: nan in its gaps."""
    k = np.clip(np.searchsorted(x, at - 1e-7), 1, len(x) - 1)
    exact = np.abs(x[k] - at) < 1e-7
    share = np.divide(at - x[k - 1], x[k] - x[k - 1], out=np.zeros(len(at)), where=~exact)
    share[at > x[-1] + 1e-7] = np.nan
    return np.where(exact, y[k], y[k - 1] + share * (y[k] - y[k - 1]))


def check_angles(panel, rows):
    """The axis of angles, its ticks, and a line at every turn."""
    axes = panel.axes
    assert axes.get_xlim() == pytest.approx((rows.low, rows.high))
    assert axes.get_xlabel() == r"cam angle $\theta$ (deg)"
    for tick, text in zip(axes.get_xticks(), axes.get_xticklabels(), strict=True):
        assert float(text.get_text()) == tick % 360.0
    for turn in np.arange(0.0, rows.high + 1.0, 360.0):
        if turn >= rows.low:
            panel.guide("x", turn, "guide")


def check_events(panel, rows, heights, named):
    said = {"chatter": "chatter accumulates"}
    for kind, (_, angle, q, _, _) in rows.events.items():
        label = said.get(kind, kind) if named else None
        panel.marks(angle, q if heights else 0.0 * q, kind, label)


def gap_axis(panel, way, gap):
    """m, mm or µm: so that the largest number is not small."""
    unit, factor = next(
        (u, f) for u, f in (("m", 1.0), ("mm", 1e3), ("µm", 1e6)) if gap.max() * f >= 0.02
    )
    panel.reads(way, f"relative position $q - c$ ({unit})", factor)


def checks(name):
    machine, rpm, _ = RUNS[name]
    rows, fine = Rows(name), Rows(name, 7)

    def motion(panel):
        (cam,) = [a for a in panel.axes.lines if a.get_label() == "cam"]
        x, c = cam.get_xdata(), machine.cam.lift(cam.get_xdata())[0]
        panel.line(x, c, "cam", label="cam")
        assert x[0] == pytest.approx(rows.low)
        assert x[-1] == pytest.approx(rows.angle[-1])
        assert np.diff(x).max() < 1.0
        (area,) = panel.pick(PolyCollection)
        outline = area.get_paths()[0].vertices
        bottom = panel.axes.get_ylim()[0]
        assert hexed(area.get_facecolor()[0]) == COLOURS["body"]
        assert {*outline[np.abs(outline[:, 1] - bottom) > 1e-12, 1]} <= {*cam.get_ydata()}
        assert bottom < min(c)
        check_contact(panel, rows, fine, rows.q, fine.q, named=True)
        check_events(panel, rows, heights=True, named=True)
        check_angles(panel, rows)
        for corner in machine.cam.corners.values():
            first = rows.low + (corner - rows.low) % 360.0
            for at in np.arange(first, rows.high, 360.0):
                panel.guide("x", at, "guide", "dotted")
        panel.in_order(
            {n: rows.low + (at - rows.low) % 360.0 for n, at in machine.cam.corners.items()}, "x"
        )
        panel.reads("y", f"position $q$ ({machine.unit})", machine.per_m)
        panel.axes.figure.canvas.draw()
        (time,) = panel.axes.child_axes
        assert time.get_xlabel() == "time (s)"
        assert time.get_xlim() == pytest.approx(((3 - TURNS) * 60.0 / rpm, 3 * 60.0 / rpm))

    def gap(panel):
        panel.guide("y", 0.0, "cam")
        check_contact(panel, rows, fine, rows.gap, fine.gap, named=False)
        check_events(panel, rows, heights=False, named=False)
        check_angles(panel, rows)
        gap_axis(panel, "y", rows.gap)

    def phase(panel):
        panel.guide("x", 0.0, "guide")
        panel.guide("y", 0.0, "guide")
        _, _, _, before, after = rows.events["impact"]
        jumps = np.column_stack([before, after, np.full(len(after), np.nan)]).ravel()
        panel.dots(0.0 * np.nan_to_num(jumps), jumps, "o", "impact", style="solid")
        if rows.rests.any():
            panel.dots([0.0], [0.0], "o", "sticking", style="solid")
        (curve,) = panel.lines("flight", None, count=1)
        size = np.array([np.ptp(rows.gap), np.ptp(rows.u)])
        g = rows.gap
        tops = np.flatnonzero((g[1:-1] >= g[:-2]) & (g[1:-1] >= g[2:])) + 1
        arrows = panel.pick(Annotation)
        for arrow in arrows:  # where a gap is largest the relative velocity falls through zero
            (gap_m, u), (gap_before, u_before) = arrow.xy, arrow.xyann
            assert u_before > 0.0 >= u
            assert np.abs(g[tops] - gap_m).min() < 0.01 * g.max()
            assert np.abs(gap_m - gap_before) < 0.01 * g.max()
            assert hexed(arrow.arrow_patch.get_facecolor()) == COLOURS["flight"]
        assert bool(arrows) == bool(rows.gap.max() > 0.0)
        drawn = np.column_stack(curve.get_data()) / size
        drawn = drawn[np.isfinite(drawn).all(axis=1)]
        flying = ~rows.rests & rows.amid
        states = np.column_stack([rows.gap, rows.u])[flying] / size
        away = np.abs(states[:, None] - drawn[None]).max(axis=2).min(axis=1)
        jumping = np.isin(rows.angle[flying].round(6), rows.events["impact"][1].round(6))
        assert away[~jumping].max() < 1e-8
        assert away[jumping].max() < 0.05  # ends of a flight, marked by themselves
        finer = np.column_stack([fine.gap, fine.u]) / size
        stray = np.abs(drawn[:, None] - finer[None]).max(axis=2).min(axis=1)
        assert stray.max() < 0.05
        gap_axis(panel, "x", rows.gap)
        panel.reads("y", r"relative velocity $u = v - \dot c$ (m/s)")

    def passage(panel):
        last = rows.events["detachment"][1][-1] % 360.0
        phase = (rows.angle - last + 180.0) % 360.0 - 180.0 + last
        low, high = panel.axes.get_xlim()
        assert (low, high) == pytest.approx((last - 8.0, last + 4.0))
        turn = np.floor((rows.angle - last + 180.0) / 360.0)
        every = str(made(name).summary["label"]).startswith("P(1;")  # turn is the same
        shades = ["flight"] if every else ["flight", mixed("flight", 0.55)]
        rests = panel.lines("sticking", count=len(shades))
        for own, shade in enumerate(shades):
            for line, state in ((panel.lines(shade, count=1)[0], ~rows.rests),
                                (rests[own], rows.rests)):  # fmt: skip
                x, y = (column[np.isfinite(line.get_ydata())] for column in line.get_data())
                assert ((x >= low) & (x <= high)).all()
                at = state & rows.amid & (phase > low + 1e-6) & (phase < high - 1e-6)
                at &= turn % len(shades) == own
                away = np.abs(x[None] - phase[at][:, None]) / 10.0
                away = np.maximum(away, np.abs(y[None] - rows.gap[at][:, None]) / rows.gap.max())
                assert away.min(axis=1, initial=1.0).max(initial=0.0) < 1e-9
                assert not len(x) or at.any()
            hits = np.asarray(rows.events.get("impact", ([], []))[1])
            mine = hits[np.floor((hits - last + 180.0) / 360.0) % len(shades) == own]
            mine = (mine - last + 180.0) % 360.0 - 180.0 + last
            mine = mine[(mine > low) & (mine < high)]
            said = "impact" if every else ("impact", "impact of every second turn")[own]
            face = ("impact", "white")[own]
            panel.dots(mine, 0.0 * mine, "o", face, "impact", said, within=1e-6)
        panel.guide("y", 0.0, "cam")
        panel.corners(machine.cam.corners, "x")
        unit = panel.axes.get_ylabel().rpartition("(")[2][:-1]
        factor = {"m": 1.0, "mm": 1e3, "µm": 1e6}[unit]
        panel.reads("y", f"relative position $q - c$ ({unit})", factor)
        assert panel.axes.get_xlabel() == r"cam angle $\theta$ (deg)"

    def section(panel):
        t = rows.every["t_s"] * rpm / 60.0
        at = np.abs(t - np.round(t)) < 1e-9
        panel.dots(rows.every["q_m"][at], rows.every["v_m_per_s"][at], "o", "impact")
        assert at.sum() in (3, 4)
        panel.reads("x", f"stroboscopic $q$ ({machine.unit})", machine.per_m)
        panel.reads("y", "stroboscopic $v$ (m/s)")

    return {
        "motion": motion, "gap": gap, "phase": phase, "passage": passage, "section": section,
    }  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_every_panel_of_a_simulation_shows_the_rows_of_its_tables(name):
    own = checks(name)
    assert check(made(name), own) == {*own}


@pytest.mark.parametrize("name", RUNS)
def test_the_page_of_a_simulation_says_speed_motion_and_why_it_stopped(name):
    _, rpm, _ = RUNS[name]
    page = read_page(made(name))
    label = made(name).summary["label"].replace("inf", "∞")
    assert usual(made(name)) == ["motion", "gap", "phase"]
    assert page.texts == [f"Time response at {rpm:g} rpm, {label}"]
    kinds = {
        {"chatter": "chatter accumulates"}.get(kind, kind)
        for kind in made(name).tables["events"]["event"]
    }
    states = {
        "follower in flight",
        r"sticking, $\ddot{c} \geq 0$",
        r"sticking, $\ddot{c} < 0$",
    }
    assert {*page.legend} - states == {"cam"} | kinds


def test_a_run_that_stops_says_so_and_draws_what_there_is():
    values = {"run.rpm": 3000, "run.impact_budget": 3, "run.record": 3, "run.transient": 0}
    result = camcli.simulate(VALVE.load(values))
    assert result.summary["status"] == "impact-budget"
    page = read_page(result)
    page.says("stopped (impact-budget): ")
    stopped = next(t for t in page.figure.axes[0].texts if t.get_text().startswith("stopped"))
    assert hexed(stopped.get_color()) == COLOURS["trouble"]


def test_the_frames_of_an_animation_are_the_machine_at_the_rows_of_the_trajectory(monkeypatch):
    name, frames = "valve 3300", []
    machine, rpm, _ = RUNS[name]

    def keep(figure):
        turning, time = figure.axes
        body, follower = turning.patches[:2]
        (dot,) = [a for a in time.lines if a.get_marker() == "o"]
        (cursor,) = [a for a in time.lines if a.get_transform() != time.transData]
        frames.append(
            (body.get_xy().copy(), follower.get_xy().copy(), hexed(follower.get_facecolor()),
             dot.get_xydata()[0].copy(), hexed(dot.get_color()), cursor.get_xdata()[0],
             (Panel("time", time).title, time.get_xlim(), time.get_ylabel(), time.get_xlabel()),
             [text.get_text() for text in time.get_legend().get_texts()])
        )  # fmt: skip

    few = partial(simulate_plots.draw_frames, frames=20, near_frames=60)  # a third, to save time
    monkeypatch.setattr(simulate_plots, "draw_frames", few)
    monkeypatch.setattr(pictures, "_write_gif", lambda drawn, _: [keep(one) for one in drawn])
    values = {
        "run.rpm": rpm, "run.transient": 30, "run.record": 3, "simulate.plot_turns": TURNS,
        "simulate.samples": 120,
    }  # fmt: skip
    result = camcli.simulate(machine.load(values), animate=True)
    result.files["simulate.gif"](io.BytesIO())
    rows, base = Rows(name), 0.015  # 1.5 lifts, as the scene has no base circle
    _, hits, _, before, _ = rows.events["impact"]
    hard = hits[np.abs(before) >= 0.1 * np.abs(before).max()] - 360.0 * 2.0
    hard = hard[(hard >= machine.strobe_deg) & (hard < machine.strobe_deg + 360.0)]
    cursors = np.array([float(np.ravel(frame[5])[0]) for frame in frames])
    steps = np.diff([*cursors, machine.strobe_deg + 360.0])  # one period
    assert cursors[0] == pytest.approx(machine.strobe_deg)
    assert (steps > 0.0).all()
    assert steps.max() <= 18.0 + 1e-9
    for hit in hard:
        assert steps[(cursors <= hit) & (cursors + steps > hit)] <= 6.0 + 1e-9
    lowest = -0.002
    for body, follower, face, dot, colour, cursor, said, legend in frames:
        assert legend == ["in flight", "at rest on the cam"]
        angle = float(np.ravel(cursor)[0])
        wanted = np.interp(angle + 360.0 * 2.0, rows.angle, rows.q)
        assert dot == pytest.approx([angle, wanted], abs=1e-5)
        c = float(machine.cam.lift(angle)[0])
        flies = wanted - c > 1e-6
        row = int(np.searchsorted(rows.angle, angle + 360.0 * 2.0)) - 1
        if abs(wanted - c) > 1e-6 or rows.rests[max(row, 0) : row + 2].all():
            assert colour == face == COLOURS["flight" if flies else "sticking"]
        assert follower[0] == pytest.approx([0.0, base + wanted - lowest], abs=1e-5)
        phase = np.degrees(np.arctan2(*body.T)) + angle
        radius = base + machine.cam.lift(phase)[0] - lowest
        assert np.hypot(*body.T) == pytest.approx(radius, rel=1e-4)
        label = result.summary["label"].replace("inf", "∞")
        title, limits, ylabel, xlabel = said
        slower = 20 / 30 / (60.0 / rpm)  # seconds of a turn on the screen, and of the machine's
        pace = f"{slower:.3g} times slower, 3 times that near impacts"
        assert title == f"{rpm:g} rpm, {label}\n{pace}"
        assert limits == pytest.approx((machine.strobe_deg, machine.strobe_deg + 360.0))
        assert (xlabel, ylabel) == (r"cam angle $\theta$ (deg)", "position (mm)")


@pytest.mark.parametrize("turns", [2, 9])
def test_an_animation_shows_as_many_turns_as_were_asked_for(monkeypatch, turns):
    """Of a motion that never repeats, where so many were recorded."""
    seen = []

    def keep(frames, file, kind):
        seen.append(next(frames).axes[1].get_xlim())

    monkeypatch.setattr(pictures, "write_animation", keep)
    values = {"run.rpm": 745.0, "run.transient": 30, "run.record": 5, "run.strobe_deg": 30.0,
              "simulate.plot_turns": turns, "simulate.samples": 48}  # fmt: skip
    result = camcli.simulate(CHAPTER.load(values), animate=True)
    result.files["simulate.gif"](io.BytesIO())
    (limits,) = seen
    assert limits == pytest.approx((30.0, 30.0 + 360.0 * min(turns, 5)))


def test_what_is_drawn_between_rows_comes_after_the_right_one():
    """Times with a jump twice, and corners between rows and upon them."""
    t = np.array([0.0, 0.1, 0.25, 0.25, 0.4, 1.0])
    corners = np.array([-0.1, 0.05, 0.1, 0.25, 0.33, 0.7, 1.2])
    fine, row = _fine(t, corners)
    assert (np.diff(fine) >= 0.0).all()
    assert (t[row] <= fine).all()
    assert (fine <= t[np.minimum(row + 1, len(t) - 1)]).all()
    assert set(range(len(t))) == set(row.tolist())
    for corner in corners[1:-1]:
        beside = np.abs(fine - corner)
        assert (beside[fine < corner].min(), beside[fine > corner].min()) < (1e-6, 1e-6)
    y, slope = t**3, 3.0 * t**2  # a cubic is met exactly
    values, slopes = _cubic(t, y, slope, fine, row)
    moves = t[row] < t[np.minimum(row + 1, len(t) - 1)]
    assert values == pytest.approx(fine**3, abs=1e-12)
    assert slopes[moves] == pytest.approx(3.0 * fine[moves] ** 2, abs=1e-12)


CORNERS = {"b": 150.1793714951576, "c": 160.0, "e": 209.8206285048424}  # deg


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("record", [3, 9, 20])
def test_nothing_is_drawn_before_the_first_row_where_the_strobe_lies_on_a_corner(corner, record):
    """Rounding may put the corner before the row at the strobe: in flight a curve would begin there
    far off, where the last cubic of the turn is."""
    values = {"run.rpm": 700, "run.transient": 30, "run.record": record, "simulate.plot_turns": 2,
              "run.strobe_deg": CORNERS[corner]}  # fmt: skip
    result = camcli.simulate(camcli.load_scene(None, values))
    found = result.values[0] if isinstance(result.values, tuple) else result.values
    trace, rows = Trace.of(found, result.system, 2), result.tables["trajectory"]
    last = rows["t_s"] * 700.0 / 60.0 >= record - 2 - 1e-9
    q = rows["q_m"][last]
    reach = 0.01 * np.ptp(q)  # between two rows of a flight of 256 samples a turn
    assert q.min() - reach <= np.nanmin(trace.q)
    assert np.nanmax(trace.q) <= q.max() + reach


@pytest.mark.parametrize("strobe_deg", [0.0, 100.0, 200.0, 300.0])
def test_every_corner_of_every_turn_shown_is_among_the_points(strobe_deg):
    """From both sides, wherever the strobe is."""
    values = {"run.rpm": 700, "run.transient": 5, "run.record": 4, "run.strobe_deg": strobe_deg,
              "simulate.samples": 24, "simulate.plot_turns": 3}  # fmt: skip
    result = camcli.simulate(camcli.load_scene(None, values))
    found = result.values[0] if isinstance(result.values, tuple) else result.values
    trace = Trace.of(found, result.system, 3)
    assert (trace.low, trace.high) == (strobe_deg + 360.0, strobe_deg + 4 * 360.0)
    assert trace.angle.min() == pytest.approx(trace.low)
    corners = [90.0, 150.1793714951576, 160.0, 200.0, 209.8206285048424, 270.0]
    for corner in [x + 360.0 * turn for x in corners for turn in range(6)]:
        if trace.low + 1.0 < corner < trace.angle.max() - 1.0:  # the last row is before the end
            off = trace.angle - corner
            assert off[off < 0.0].max() > -1e-3, corner
            assert off[off > 0.0].min() < 1e-3, corner


def test_a_rest_on_the_seat_is_told_from_one_on_the_lobe():
    """The seat is the flat part of the lift; the lobe below it lies as far off as the lash."""
    lash = 0.0003
    values = {"cam.lash": lash, "run.rpm": 2900.0, "run.transient": 10, "run.record": 3}
    loaded = VALVE.load({**values, "simulate.plot_turns": 2, "simulate.samples": 120})
    result = camcli.simulate(loaded)
    _, axes = camcli.plot(result, panels=["motion"]).axes
    lines = {line.get_label(): line for line in axes.lines}
    angle, q = lines["at rest on its seat"].get_data()
    seated = np.isfinite(q)
    lifted = VALVE.cam.lift(angle % 360.0)[0] - VALVE.cam.lift(np.array([0.0]))[0]
    assert seated.any()
    assert (lifted[seated] <= lash * (1.0 + 1e-6)).all()
    assert np.ptp(q[seated]) == 0.0
    stuck = np.zeros(len(q), bool)
    for name, line in lines.items():
        if name.startswith("sticking"):
            stuck |= np.isfinite(line.get_ydata())
    assert stuck.any()
    assert (lifted[stuck] >= lash * (1.0 - 1e-6)).all()
    table = result.tables["trajectory"]  # all that rests is one or the other
    rests = np.flatnonzero(table["contact"] == "sticking")
    last = table["theta_deg"][rests[rests > len(table["t_s"]) // 2]]
    shown_at = np.sort(angle[seated | stuck] % 360.0)
    assert all(np.abs(shown_at - theta).min() < 1e-6 for theta in last[::7])
    below = lines["lobe, clear of the follower"].get_ydata()
    clear = np.isfinite(below)
    assert below[clear] == pytest.approx(VALVE.cam.lift(angle[clear] % 360.0)[0] - lash, abs=1e-12)
    assert (lifted[clear] < lash * (1.0 + 1e-6)).all()


def test_the_screen_says_whether_an_impact_is_on_seat_or_lobe(cam):
    turns = "--set run.transient=10 --set run.record=2"
    said = cam(f"simulate -c {CONFIGS}/valve-lash.yaml --no-plot {turns}", code=0).stdout
    assert "impact, seat" in said
    assert "impact, lobe" in said
    said = cam(f"simulate -c {CONFIGS}/valve-train.yaml --no-plot {turns}", code=0).stdout
    assert "seat" not in said
