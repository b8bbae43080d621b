"""The picture of a cam alone against its closed form: curves, outline, circles, words."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Polygon

import camcli
from tests.support.machines import CHAPTER, ECCENTRIC, TABLE, VALVE, MeasuredCam, off_corners
from tests.support.picture_reader import COLOURS, FORCES, check, hexed, on_page, read_page, usual

CASES = {  # machine, speed, radius of the base circle, lift of the follower per lift of the cam
    "chapter": (CHAPTER, 120.0, 0.4, 1.0, {}),
    "valve": (VALVE, 3000.0, 0.015, 1.0, {}),
    "valve without a base": (VALVE, 2000.0, None, 1.0, {}),
    "table": (TABLE, 3000.0, 0.036, 1.0, {}),
    "table above": (
        replace(TABLE, cam=MeasuredCam(0.004)),
        3000.0,
        0.036,
        1.0,
        {"cam.base": 0.004},
    ),
    "rocker": (TABLE, 3400.0, 0.02, 1.5, {"cam.rocker_ratio": 1.5, "cam.measured_at": "valve"}),
    "eccentric": (ECCENTRIC, 300.0, 0.02, 1.0, {}),
}
CLOSE = dict.fromkeys(("table", "table above", "rocker"), (2e-6, 2e-5, 1e-3))  # m, m/rad, m/rad2
ARCS = {  # centre: distance from the axis, where it lies when the cam has not turned, radius
    "O": [(0.0, 0.0, 0.4), (0.0, 0.0, 0.55393320723821)],
    "O₁": [(0.45, 270.0, 0.85)],
    "O₂": [(0.40393320723821, 160.0, 0.15)],
}


@cache
def made(name):
    machine, rpm, base, _, values = CASES[name]
    own = None if name in ("chapter", "rocker") else base
    scene = machine.load(
        {"run.rpm": rpm, **values, **({"cam.base_radius": base} if name == "rocker" else {})}
    )
    return camcli.simulate(scene, profile_only=True, base_radius=own)


class Shape:
    """Radii of the cam, and what a flat face and a knife edge see of it."""

    def __init__(self, name):
        self.machine, self.rpm, self.base, self.ratio, _ = CASES[name]
        self.lowest = float(self.machine.cam.lift(self.machine.turn)[0].min())
        self.drawn_base = self.base
        if self.base is None:  # 1.5 lifts are drawn
            self.drawn_base = 1.5 * float(np.ptp(self.machine.cam.lift(self.machine.turn)[0]))

    def radius(self, theta, base=None):
        c = self.machine.cam.lift(theta)[0]
        return (self.drawn_base if base is None else base) + (c - self.lowest) / self.ratio

    def flat(self, theta):
        return self.radius(theta, self.base or 0.0) + self.machine.cam.lift(theta)[2] / self.ratio

    def knife(self, theta):
        R = self.radius(theta, self.base)
        d, dd = (order / self.ratio for order in self.machine.cam.lift(theta)[1:])
        return (R * R + 2.0 * d * d - R * dd) / (R * R + d * d) ** 1.5


def checks(name):
    machine, rpm, base, ratio, _ = CASES[name]
    shape, result = Shape(name), made(name)
    close = CLOSE.get(name, (1e-12, 1e-12, 1e-11))
    turn = machine.turn

    def curve(panel, colour, wanted, within):
        """The panel's curve: in its colour, through the values, over a whole turn."""
        (line,) = [a for a in panel.axes.lines if len(a.get_xdata()) > 100 and a in panel.left
                   and a.get_linestyle() == "-"]  # fmt: skip
        theta, values = line.get_data()
        theta, values = np.asarray(theta), np.asarray(values)
        at = off_corners(machine.cam, theta)
        assert np.abs(values - wanted(theta))[at].max() <= within
        assert (min(theta), max(theta)) == (0.0, pytest.approx(360.0))
        assert np.diff(theta).max() < 2.0
        assert hexed(line.get_color()) == hexed(colour)
        panel.left.remove(line)
        turned(panel)
        return line

    def turned(panel):
        panel.corners(machine.cam.corners, "x", named=panel.name == "lift")
        assert panel.axes.get_xlim() == (0.0, 360.0)
        assert panel.axes.get_xlabel() == r"cam angle $\theta$ (deg)"

    def lift(panel):
        if name in CLOSE:
            (rows,) = panel.lines("measured", "rows of the table", count=1)
            theta, c = rows.get_data()
            degrees = np.arange(-144, 146, 2) / 2.0 + 180.0
            assert sorted(theta) == pytest.approx(degrees)
            assert np.abs(c - machine.cam.lift(theta)[0]).max() <= 0.5001e-4 * 0.0254
            assert rows.get_linestyle() == "None"
        line = curve(panel, "cam", lambda theta: machine.cam.lift(theta)[0], close[0])
        assert line.get_label() == "cam" or name not in CLOSE
        panel.reads("y", f"$c$ ({machine.unit})", machine.per_m)

    def velocity(panel):
        panel.guide("y", 0.0, "guide")
        curve(panel, "cam", lambda theta: machine.cam.lift(theta)[1], close[1])
        panel.reads("y", rf"$c_\theta$ ({machine.unit}/rad)", machine.per_m)

    def acceleration(panel):
        panel.guide("y", 0.0, "guide")
        if name in CLOSE:
            (band,) = panel.pick(PolyCollection, count=1)
            assert hexed(band.get_facecolor()[0]) == COLOURS["doubt"]
            assert band.get_label() == "bound on its error"
            x, y = band.get_paths()[0].vertices.T
            (line,) = [a for a in panel.axes.lines if len(a.get_xdata()) > 100]
            theta, c2 = map(np.asarray, line.get_data())
            half = np.array([np.ptp(y[np.abs(x - at) < 1e-9]) / 2.0 for at in theta])
            truth = machine.cam.lift(theta)[2]
            assert (np.abs(c2 - truth) <= half * (1.0 + 1e-9)).all()
            low = np.array([y[np.abs(x - at) < 1e-9].min() for at in theta])
            assert low + half == pytest.approx(c2, abs=1e-12)
            said = float(panel.title.removeprefix("error below ").removesuffix(" mm/rad²"))
            assert said == pytest.approx(1e3 * half.max(), rel=0.06)
        else:
            assert panel.title == ""
        within = max(close[2], 1e-11 * np.abs(machine.cam.lift(turn)[2]).max())
        curve(panel, "cam", lambda theta: machine.cam.lift(theta)[2], within)
        panel.reads("y", rf"$c_{{\theta\theta}}$ ({machine.unit}/rad²)", machine.per_m)

    def jerk(panel):
        """By differences of the second derivative; a right axis counts mm and degrees."""
        if name in CLOSE:
            panel.words(
                "of a measured cam not known: the error of its\nthird derivative has no bound"
            )
            turned(panel)
            return
        panel.guide("y", 0.0, "guide")
        (line,) = [a for a in panel.axes.lines if len(a.get_xdata()) > 100]
        theta, values = map(np.asarray, line.get_data())
        step = 1e-3
        away = np.min(
            [np.full(len(theta), 9.0), *(abs(theta - x) for x in machine.cam.corners.values())], 0
        )
        ahead, behind = (machine.cam.lift(theta + side * step)[2] for side in (1.0, -1.0))
        wanted = (ahead - behind) / (2.0 * np.radians(step))
        clear = (away > 2.0 * step) & (theta > step) & (theta < 360.0 - step)
        assert abs(values - wanted)[clear].max() < 1e-6 * abs(wanted[clear]).max()
        panel.left.remove(line)
        turned(panel)
        corners = ", ".join(machine.cam.corners)
        assert panel.title == f"infinite {f'at {corners}' if corners else 'nowhere'}"
        panel.reads("y", rf"$c_{{\theta\theta\theta}}$ ({machine.unit}/rad³)", machine.per_m)
        if name == "valve":
            (right,) = panel.axes.child_axes
            panel.axes.figure.draw_without_rendering()
            assert right.get_ylabel() == "mm/deg³"
            assert right.get_ylim()[1] == pytest.approx(
                panel.axes.get_ylim()[1] * 1e3 * np.radians(1.0) ** 3
            )

    def force(panel):
        panel.guide("y", 0.0, "guide")
        low, _ = panel.axes.get_ylim()
        wanted = machine.force(rpm, turn)
        if wanted.min() < -1e-9 * wanted.max():
            panel.band("y", low, 0.0, "pull")
        speed = rpm * np.pi / 30.0
        within = machine.mass * speed**2 * close[2] + machine.stiffness * close[0]
        within += machine.damping * speed * close[1] + 1e-9 * np.abs(wanted).max()
        curve(panel, FORCES[1], lambda theta: machine.force(rpm, theta), within)
        said = panel.title.removeprefix(f"at {rpm:g} rpm, least ").removesuffix(" N")
        tenth = 1e-3 * max(1.0, abs(wanted.min())) + within
        assert float(said.replace("−", "-")) == pytest.approx(wanted.min(), abs=tenth)
        panel.reads("y", "contact force (N)")

    def curvature(panel):
        values = shape.flat(turn)
        undercut = base is not None and values.min() <= 0.0
        needs = max(0.0, -(shape.flat(turn) - (base or 0.0)).min())
        panel.guide("y", 0.0, "guide")
        within = 1e-12 + 2.0 * close[2] / ratio
        curve(panel, "trouble" if undercut else "cam", shape.flat, within)
        verdict = "flat face: undercut, " if undercut else "flat face, "
        said = panel.title.removeprefix(f"{verdict}needs a base radius above ")
        number, unit = said.split()
        assert unit == machine.unit
        assert float(number) / machine.per_m == pytest.approx(needs, abs=1e-3 * needs + within)
        less = "" if base is not None else "\nless the base radius"
        panel.reads("y", f"radius of curvature{less} ({machine.unit})", machine.per_m)

    def pitch(panel):
        if base is None:
            panel.words("unknown without the base radius\n(--base-radius)", 0.5, 0.5)
            assert panel.title == "knife, or roller: pitch curve"
            turned(panel)
        else:
            values = shape.knife(turn)
            within = 1e-9 * np.abs(values).max() + 2.0 * close[2] / base**2
            panel.guide("y", 0.0, "guide")
            curve(panel, "cam", shape.knife, within)
            if values.max() > 0.0:
                said = panel.title.removeprefix("knife, or roller of at most ")
                number, unit = said.removesuffix(": pitch curve").split()
                largest = machine.per_m / values.max()
                assert unit == machine.unit
                assert float(number) == pytest.approx(largest, rel=1e-3 + within / values.max())
            else:
                assert panel.title == "knife, or roller: pitch curve"
        assert panel.axes.get_ylabel() == "curvature (1/m)"

    # --- the machine

    def body(panel, turned_deg, left=0.0):
        """The cam's body, turned counterclockwise, and its axis."""
        panel.dots([left], [0.0], "o", "cam", within=1e-4 * shape.drawn_base)
        for patch in panel.left:
            if isinstance(patch, Polygon) and hexed(patch.get_facecolor()) == COLOURS["body"]:
                x, y = patch.get_xy().T
                phase = np.degrees(np.arctan2(x - left, y)) + turned_deg
                if np.abs(np.hypot(x - left, y) - outline(phase)).max() < 1e-4 * shape.drawn_base:
                    panel.left.remove(patch)
                    return
        panel.fail("body turned by", turned_deg, "at", left)

    def outline(phase):
        """Distance of the body's edge from the axis in a direction of the cam."""
        if name != "eccentric":
            return shape.radius(phase)
        # a circle, its centre half a lift from the axis, away from the lowest lift
        angle, aside = np.radians(phase), 0.5 * machine.cam.height
        reach = shape.drawn_base + aside
        return -aside * np.cos(angle) + np.sqrt(reach**2 - (aside * np.sin(angle)) ** 2)

    def follower(panel, phase, gap, left=0.0):
        """The tip stands above the cam by the gap, flying or resting."""
        colour = COLOURS["flight" if gap > 0.0 else "sticking"]
        tip = float(shape.radius(phase)) + gap
        for patch in panel.left:
            if isinstance(patch, Polygon) and hexed(patch.get_facecolor()) == colour:
                x, y = patch.get_xy().T
                if (
                    abs(y.min() - tip) < 1e-5 * tip
                    and abs(np.mean((x.min(), x.max())) - left) < 1e-3 * tip
                ):
                    panel.left.remove(patch)
                    return tip
        return panel.fail("follower with its tip at", left, tip)

    def stem_and_spring(panel, tip, left=0.0):
        """Decoration: a stem from the tip upwards, a spring to the frame, the frame."""
        upright = [
            a for a in panel.left
            if a in list(panel.axes.lines) and hexed(a.get_color()) == COLOURS["cam"]
            and len(a.get_xdata()) > 1 and np.abs(np.mean(a.get_xdata()) - left) < 0.2 * tip
            and min(a.get_ydata()) > tip
        ]  # fmt: skip
        assert len(upright) == 3, (panel.name, len(upright))
        stem, spring, frame = sorted(upright, key=lambda a: min(a.get_ydata()))
        assert min(stem.get_ydata()) > tip
        assert max(stem.get_ydata()) == pytest.approx(min(spring.get_ydata()))
        assert max(spring.get_ydata()) == pytest.approx(frame.get_ydata()[0])
        forget(panel, *upright)

    def drawn_outline(panel, turned_deg=0.0):
        dots(panel, turned_deg)
        body(panel, turned_deg)
        tip = follower(panel, turned_deg, 0.0)
        stem_and_spring(panel, tip)
        circles(panel, turned_deg)
        title = rf"$\theta$ = {turned_deg:g} deg"
        if turned_deg == 0.0:
            told = [(n, r) for n, many in rings().items() for _, _, r in many]
            radii = ", ".join(f"{n} {r * machine.per_m:.4g} {machine.unit}" for n, r in told)
            title += f"\nradii: {radii}" if base else "\nbase radius not given: 1.5 lifts"
        assert panel.title == title
        assert panel.axes.get_aspect() == 1.0
        for corner, at in machine.cam.corners.items():
            words = corner if turned_deg else rf"{corner} {at:.5g}$\degree$"
            rim = 1.08 * float(shape.radius(at))
            angle = np.radians(at - turned_deg)
            panel.words(words, rim * np.sin(angle), rim * np.cos(angle), 1e-6)

    def rings():
        if name == "chapter":
            return ARCS
        return {"O": [(0.0, 0.0, shape.drawn_base)]}

    def dots(panel, turned_deg):
        """A ray and a dot for every corner."""
        for at in machine.cam.corners.values():
            angle, rim = np.radians(at - turned_deg), float(shape.radius(at))
            x, y = rim * np.sin(angle), rim * np.cos(angle)
            panel.line([0.0, x], [0.0, y], "guide", within=1e-5 * rim)
            panel.dots([x], [y], "o", "cam", within=1e-5 * rim)

    def circles(panel, turned_deg):
        for centre, many in rings().items():
            for distance, direction, radius in many:
                angle = np.radians(direction - turned_deg)
                x, y = distance * np.sin(angle), distance * np.cos(angle)
                near = 1e-9
                found = [
                    a for a in panel.left
                    if isinstance(a, Circle) and abs(a.radius - radius) < near
                    and np.hypot(a.center[0] - x, a.center[1] - y) < near
                ]  # fmt: skip
                assert found, (centre, radius)
                assert hexed(found[0].get_edgecolor()) == COLOURS["guide"]
                assert not found[0].get_fill()
                forget(panel, found[0])
                panel.dots([x], [y], ".", "cam", within=1e-9)
                size = float(shape.radius(turn).max())
                panel.words(centre, x, y, 0.03 * size)

    def mechanism(panel):
        lifting = turn[np.argmax(machine.cam.lift(turn)[1])]
        landing = turn[np.argmin(machine.cam.lift(turn)[1])]
        size = float(shape.radius(turn).max())
        room = 0.4 * float(np.ptp(shape.radius(turn)))
        moments = (("at rest", 0.0, 0.0), ("lifting", lifting, 0.0), ("landing", landing, room))
        texts = [a.get_text() for a in panel.axes.texts]
        for k, (what, wanted, gap) in enumerate(moments):
            left = 3.2 * size * k
            (text,) = [one for one in texts if one.startswith(f"{what}, ")]
            panel.words(text, left, within=1e-3 * size)
            phase = float(text.rpartition("= ")[2].removesuffix(" deg"))
            assert phase == pytest.approx(wanted, abs=1.0)
            exact = phases_of(result)[k]
            assert phase == pytest.approx(exact, rel=1e-3)
            body(panel, exact, left)
            stem_and_spring(panel, follower(panel, exact, gap, left), left)
            for corner, at in machine.cam.corners.items():
                angle, rim = np.radians(at - exact), 0.87 * float(shape.radius(at))
                place = rim * np.sin(angle) + left, rim * np.cos(angle)
                panel.words(corner, *place, 1e-4 * size)
        for part in ("cam", "follower", "spring", r"$\omega$"):
            panel.words(part)
        (arrow,) = [a for a in panel.left if getattr(a, "arrow_patch", None) is not None]
        (x0, y0), (x1, y1) = arrow.xyann, arrow.xy
        assert x0 * y1 - y0 * x1 > 0.0  # counterclockwise
        forget(panel, arrow)

    return {
        "outline": drawn_outline, "turned": lambda panel: drawn_outline(panel, 180.0),
        "mechanism": mechanism, "lift": lift, "velocity": velocity, "acceleration": acceleration,
        "jerk": jerk, "force": force, "curvature": curvature, "curvature of the pitch curve": pitch,
    }  # fmt: skip


def phases_of(result):
    """At rest, where the lift grows fastest, and where it falls fastest, by the table."""
    table = result.tables["profile"]
    slope = table["c_theta_m_per_rad"]
    return 0.0, table["theta_deg"][np.argmax(slope)], table["theta_deg"][np.argmin(slope)]


def forget(panel, *artists):
    panel.left = [a for a in panel.left if a not in artists]


@pytest.mark.parametrize("name", CASES)
def test_every_panel_of_a_cam_shows_its_closed_form(name):
    own = checks(name)
    assert check(made(name), own) == {*own}


def test_cams_side_by_side_have_a_column_each_and_the_same_axes():
    others = [VALVE.scene["cam"], ECCENTRIC.scene["cam"]]
    scene = CHAPTER.load({"simulate.beside": others, "run.rpm": 120})
    result = camcli.simulate(scene, profile_only=True)
    names = ["outline", "lift", "velocity", "acceleration", "force"]
    drawn = result.pictures["profile"]().chosen(names)
    figure = camcli.plot(result, panels=names, height=900)
    panels = {panel.name: panel for panel in on_page(figure, drawn)}
    cams = {"": CHAPTER.cam, " 2": VALVE.cam, " 3": ECCENTRIC.cam}
    omega = 120.0 * np.pi / 30.0
    for name, says in (
        ("lift", "$c$ (m)"), ("velocity", r"$c_\theta$ (m/rad)"),
        ("acceleration", r"$c_{\theta\theta}$ (m/rad²)"), ("force", "contact force (N)"),
    ):  # fmt: skip
        limits, every = set(), []
        for which, cam in cams.items():
            panel = panels[name + which]
            line = max(panel.axes.lines, key=lambda a: len(a.get_xdata()))
            theta, values = map(np.asarray, line.get_data())
            c, c1, c2 = cam.lift(theta)
            force = CHAPTER.stiffness * c + CHAPTER.mass * omega**2 * c2
            wanted = {"lift": c, "velocity": c1, "acceleration": c2, "force": force}[name]
            away = np.abs(values - wanted)[off_corners(cam, theta)]
            assert away.max() < 1e-9 * np.abs(wanted).max()
            limits.add(panel.axes.get_ylim())
            every += [values.min(), values.max()]
            assert panel.axes.get_ylabel() == (says if which == "" else "")
        ((low, high),) = limits
        room = 0.05 * (max(every) - min(every))
        assert min(every) - room <= low <= min(every) <= max(every) <= high <= max(every) + room
    outlines = [panels[f"outline{which}"] for which in cams]
    assert [panel.title for panel in outlines] == ["arcs", "harmonic", "eccentric"]
    assert {panels[f"force{which}"].axes.get_xlabel() for which in cams} == {r"$\theta$ (deg)"}


def test_a_follower_without_a_spring_is_a_ball_on_a_table():
    result = camcli.simulate(ECCENTRIC.load({"follower.stiffness": 0.0}), profile_only=True)
    (axes,) = camcli.plot(result, panels=["turned"]).axes[1:]
    (ball,) = [a for a in axes.patches if isinstance(a, Circle) and a.get_fill()]
    (table,) = [a for a in axes.lines if len(a.get_xdata()) == 2]
    top = 1.5 * 0.02 + 0.02  # radius under the follower where the lift is highest
    assert table.get_ydata() == pytest.approx([top, top])
    assert ball.center == (0.0, pytest.approx(top + ball.radius))
    assert hexed(ball.get_facecolor()) == COLOURS["sticking"]


def test_the_page_of_a_cam_says_its_lift_and_where_contact_is_lost():
    page = read_page(made("chapter"))
    assert page.texts == ["Cam with a lift of 0.1539 m"]
    page.says("first detachment at 114.979 rpm, 150.179 deg")
    rest = ["lift", "velocity", "acceleration", "jerk", "force", "curvature"]
    assert usual(made("chapter")) == [*rest, "curvature of the pitch curve"]
    rest.remove("jerk")
    assert usual(made("table")) == [*rest, "curvature of the pitch curve"]
    page = read_page(made("valve"))
    assert page.texts == ["Cam with a lift of 10 mm"]
    page.says("first detachment at 2682.06 rpm, 196.816 deg")
    page = read_page(made("table"))
    assert page.texts[0] == "Cam with a lift of 10.16 mm"
    assert {*page.legend} == {"cam", "rows of the table", "bound on its error"}
    least, turn = 0.0, TABLE.turn
    low, high = 1000.0, 6000.0
    while high - low > 0.01:
        least = 0.5 * (low + high)
        low, high = (low, least) if TABLE.force(least, turn).min() < 0.0 else (least, high)
    said = page.figure.caption.removeprefix("First detachment at ").split()
    assert float(said[0]) == pytest.approx(least, rel=5e-3)
    assert float(said[2]) == pytest.approx(turn[np.argmin(TABLE.force(least, turn))] % 360, abs=3.0)
