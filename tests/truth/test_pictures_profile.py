"""The picture of a cam alone against its closed form: curves, outline, circles, words."""

from dataclasses import replace
from functools import cache
from math import isnan
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from matplotlib.text import Annotation, Text

import camcli
from camcli.plots import cam_profile
from camcli.quantities import MILLIMETRES
from tests.support.machines import CHAPTER, ECCENTRIC, TABLE, VALVE, MeasuredCam, off_corners
from tests.support.picture_reader import (
    COLOURS,
    FORCES,
    check,
    dashes,
    hexed,
    is_arrow,
    on_page,
    read_page,
    rows_on_page,
    same,
    usual,
)

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
        panel.corners(machine.cam.corners, "x", named=panel.name in ("lift", "force"))
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
        panel.reads("y", f"lift $c$ ({machine.unit})", machine.per_m)

    def velocity(panel):
        panel.guide("y", 0.0, "guide")
        curve(panel, "cam", lambda theta: machine.cam.lift(theta)[1], close[1])
        panel.reads("y", f"velocity\n$c_\\theta$ ({machine.unit}/rad)", machine.per_m)

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
        panel.reads(
            "y", f"acceleration\n$c_{{\\theta\\theta}}$ ({machine.unit}/rad²)", machine.per_m
        )

    def jerk(panel):
        """By differences of the second derivative; a right axis counts mm and degrees."""
        panel.guide("y", 0.0, "guide")
        (line,) = [a for a in panel.axes.lines if len(a.get_xdata()) > 100]
        theta, values = map(np.asarray, line.get_data())
        if name in CLOSE:
            (band,) = panel.pick(PolyCollection, count=1)
            assert hexed(band.get_facecolor()[0]) == COLOURS["doubt"]
            assert band.get_label().startswith("_")  # the title says what it is
            x, y = band.get_paths()[0].vertices.T
            half = np.array([np.ptp(y[np.abs(x - at) < 1e-9]) / 2.0 for at in theta])
            low = np.array([y[np.abs(x - at) < 1e-9].min() for at in theta])
            assert low + half == pytest.approx(values, abs=1e-12)
            before, after = "of the fit; its error estimated up to ", " mm/rad³, but for jumps"
            assert panel.title.startswith(before)
            said = float(panel.title.removeprefix(before).removesuffix(after))
            assert said == pytest.approx(1e3 * half.max(), rel=0.06)
            step = 1e-3
            ahead, behind = (machine.cam.lift(theta + side * step)[2] for side in (1.0, -1.0))
            wanted = (ahead - behind) / (2.0 * np.radians(step))
            assert (abs(values - wanted) <= half * (1.0 + 1e-9)).mean() > 0.95
            panel.left.remove(line)
            turned(panel)
            panel.reads(
                "y", f"jerk\n$c_{{\\theta\\theta\\theta}}$ ({machine.unit}/rad³)", machine.per_m
            )
            return
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
        panel.reads(
            "y", f"jerk\n$c_{{\\theta\\theta\\theta}}$ ({machine.unit}/rad³)", machine.per_m
        )
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
        # a blank line keeps the words above the names of corners
        assert panel.title.endswith("\n") == bool(machine.cam.corners)
        said = panel.title.strip().removeprefix(f"at {rpm:g} rpm, least ").removesuffix(" N")
        tenth = 1e-3 * abs(wanted.min()) + 5e-4 * np.abs(wanted).max() + within
        assert float(said.replace("−", "-")) == pytest.approx(wanted.min(), abs=tenth)
        panel.reads("y", "contact force (N)")

    def folded(panel):
        """The title in one line: a long one is broken."""
        return panel.title.replace("\n", " ")

    def curvature(panel):
        values = shape.flat(turn)
        undercut = base is not None and values.min() <= 0.0
        needs = max(0.0, -(shape.flat(turn) - (base or 0.0)).min())
        panel.guide("y", 0.0, "guide")
        within = 1e-12 + 2.0 * close[2] / ratio
        curve(panel, "trouble" if undercut else "cam", shape.flat, within)
        verdict = "flat face: undercut, " if undercut else "flat face, "
        said = folded(panel).removeprefix(f"{verdict}needs a base radius above ")
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
                said = folded(panel).removeprefix("knife, or roller of at most ")
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

    size = float(shape.radius(turn).max())

    def place(phase, away, turned_deg=0.0):
        angle = np.radians(np.subtract(phase, turned_deg))
        return away * np.sin(angle), away * np.cos(angle)

    def drawn_outline(panel, turned_deg=0.0):
        corners(panel, turned_deg)
        body(panel, turned_deg)
        tip = follower(panel, turned_deg, 0.0)
        stem_and_spring(panel, tip)
        circle(panel, "O", *rings()["O"][0], turned_deg)
        panel.words("O", 0.0, 0.0, 0.1 * size)
        if name == "chapter":
            for centre in ("O₁", "O₂"):
                ((away, direction, _),) = ARCS[centre]
                x, y = place(direction, away, turned_deg)
                panel.line([0.0, x], [0.0, y], "guide", within=1e-9)
                panel.dots([x], [y], ".", "cam", within=1e-9)
                panel.words(centre, x, y, 0.11 * size)
        title = rf"$\theta$ = {turned_deg:g} deg"
        if turned_deg == 0.0 and not base:
            title = f"base radius not given: 1.5 lifts\n{title}"
        assert panel.title == title
        assert panel.axes.get_aspect() == 1.0

    def rings():
        if name == "chapter":
            return ARCS
        return {"O": [(0.0, 0.0, shape.drawn_base)]}

    def corners(panel, turned_deg):
        """A ray and a dot for every corner, and its name outside."""
        for corner, at in machine.cam.corners.items():
            rim = float(shape.radius(at))
            x, y = place(at, rim, turned_deg)
            panel.line([0.0, x], [0.0, y], "guide", within=1e-5 * rim)
            panel.dots([x], [y], "o", "cam", within=1e-5 * rim)
            text = panel.words(corner, x, y, 0.13 * size)
            assert np.hypot(*text.get_position()) > rim + 0.05 * size

    def circle(panel, centre, distance, direction, radius, turned_deg=0.0):
        """What is drawn of a circle lies on it, and nothing of it on the outline."""
        x, y = place(direction, distance, turned_deg)
        panel.dots([x], [y], ".", "cam", within=1e-9)
        for line in panel.left:
            if not isinstance(line, Line2D) or dashes(line) != "dashed":
                continue
            at = np.array(line.get_data())
            at = at[:, np.isfinite(at[0])]
            if np.allclose(np.hypot(at[0] - x, at[1] - y), radius, rtol=1e-9, atol=0.0):
                phase = np.degrees(np.arctan2(*at)) + turned_deg
                away = np.hypot(*at) - np.array([float(outline(one)) for one in phase])
                assert np.abs(away).min(initial=np.inf) > 0.007 * size
                assert hexed(line.get_color()) == COLOURS["guide"]
                forget(panel, line)
                return at
        return panel.fail("circle around", centre, radius)

    def arrows(panel):
        """Takes all straight arrows: (begin, end) of each."""
        found = panel.pick(Annotation, is_arrow)
        return [(np.array(a.xyann), np.array(a.xy)) for a in found]

    def geometry(panel):
        body(panel, 0.0)
        corners(panel, 0.0)
        shown = {
            (centre, radius): circle(panel, centre, away, direction, radius)
            for centre, many in rings().items()
            for away, direction, radius in many
        }
        at = list(machine.cam.corners.values())
        for number, (begin, end) in enumerate(
            zip(at, [*at[1:], *(x + 360.0 for x in at[:1])], strict=True), 1
        ):
            text = panel.words(f"A{number}")
            x, y = text.get_position()
            phase = np.degrees(np.arctan2(x, y)) % 360.0
            assert begin < phase < end or begin < phase + 360.0 < end
            assert np.hypot(x, y) == pytest.approx(outline(phase), rel=0.35)
        panel.words("O", 0.0, 0.0, 0.1 * size)
        zero = panel.words(r"$\theta$ = 0", 0.0)
        ways = arrows(panel)
        away = 1.1 * shape.drawn_base
        (turning,) = [way for way in ways if np.allclose(np.hypot(*np.transpose(way)), away)]
        begin, end = turning
        assert begin[0] * end[1] - begin[1] * end[0] < 0.0  # theta grows clockwise on the body
        (arc,) = [
            line for line in panel.left
            if isinstance(line, Line2D) and np.allclose(np.hypot(*line.get_data()), away)
        ]  # fmt: skip
        angles = np.degrees(np.arctan2(*arc.get_data()))
        assert angles[-1] - angles[0] == pytest.approx(28.0)
        panel.line(*place(angles, away), "cam", within=1e-3 * away)
        arc.get_figure().draw_without_rendering()
        starts = arc.get_transform().transform(arc.get_xydata())[0, 0]
        free = starts - zero.get_window_extent().x1  # beside the words, near them
        assert 0.0 < free / arc.get_figure().dpi * 25.4 < 2.5
        wanted = {r"$\rho_0$": ((0.0, 0.0), shape.drawn_base)}
        if name == "chapter":
            first, second = (place(ARCS[c][0][1], ARCS[c][0][0]) for c in ("O₁", "O₂"))
            wanted |= {r"$\rho_1$": (first, 0.85), r"$\rho_2$": (second, 0.15)}
            wanted |= {r"$\rho_3$": ((0.0, 0.0), 0.55393320723821)}
            for centre, point in (("O₁", first), ("O₂", second)):
                panel.line([0.0, point[0]], [0.0, point[1]], "cam", within=1e-9)
                panel.words(centre, *point, 0.13 * size)
            for k, point in ((1, first), (2, second)):
                panel.words(rf"$\kappa_{k}$", *np.multiply((0.5, 0.8)[k - 1], point), 0.15 * size)
            for k in (1, 2, 3):
                (arc,) = panel.pick(
                    Line2D, lambda a, k=k: hexed(a.get_color()) == COLOURS["detachment"]
                    and same(phases(a)[[0, -1]], at[k - 1 : k + 1], within=1e-6)
                )  # fmt: skip
                away = np.hypot(*arc.get_data())
                assert np.ptp(away) < 1e-9
                text = panel.words(rf"$\theta_{k}$")
                assert np.hypot(*text.get_position()) == pytest.approx(away[0], abs=0.1 * size)
            assert np.abs(shown["O₁", 0.85]).max() < 1.3 * size  # cut, beside the arc
        for symbol, (centre, radius) in wanted.items():
            (way,) = [w for w in ways if w is not turning and np.allclose(w[0], centre)
                      and np.hypot(*(w[1] - w[0])) == pytest.approx(radius, rel=1e-4)]  # fmt: skip
            tip = np.degrees(np.arctan2(*way[1]))
            assert np.hypot(*way[1]) == pytest.approx(float(outline(tip)), rel=1e-4)
            text = panel.words(symbol)
            x, y = np.subtract(text.get_position(), way[0])
            along = (way[1] - way[0]) / radius
            assert abs(x * along[1] - y * along[0]) < 0.1 * size
        assert len(ways) == len(wanted) + 1

    def phases(line):
        return np.degrees(np.arctan2(*line.get_data())) % 360.0

    def geometry_in_words(panel):
        said = " ".join(a.get_text() for a in panel.pick(Text))
        length = lambda x: f"{x * machine.per_m:.4g} {machine.unit}"  # noqa: E731
        told = [length(shape.drawn_base) if base else "1.5 lifts base circle, around O; not given"]
        if name == "chapter":
            told += [r"$\rho_1$ 0.85 m flanks", r"$\kappa_1$ 0.45 m from O to O₁"]
            told += [r"$\rho_2$ 0.15 m nose", r"$\kappa_2$ 0.4039 m from O to O₂"]
            told += [r"$\rho_3$ 0.5539 m top dwell A3", r"$\theta_1$ 60.179$\degree$"]
            told += [r"$\theta_2$ 9.8206$\degree$", r"$\theta_3$ 40$\degree$ of A3"]
        told += [rf"{corner} {at:.5g}$\degree$" for corner, at in machine.cam.corners.items()]
        for words in told:
            assert words in said, (words, said)

    def mechanism(panel):
        rise, fall = phases_of(result)
        lift, gap = machine.cam.lift(turn)[0], 0.4 * float(np.ptp(shape.radius(turn)))
        flying = 0.5 * (rise + (fall if fall > rise else fall + 360.0)) % 360.0
        moments = (("at rest", 0.0, 0.0), ("in flight", flying, gap), ("landing", fall, 0.0))
        plain = name != "eccentric"
        for k, (what, phase, room) in enumerate(moments):
            left = 3.2 * size * k
            (text,) = panel.pick(Text, lambda a, what=what: a.get_text().startswith(f"{what},"))
            assert text.get_position()[0] == pytest.approx(left, abs=1e-3 * size)
            said = float(text.get_text().rpartition("= ")[2].removesuffix(" deg"))
            assert said == pytest.approx(phase, rel=1e-3)
            body(panel, phase, left)
            tip = follower(panel, phase, room, left)
            damper(panel, left)
            if room and plain:
                heights(panel, phase, room, left)
            stem_and_spring(panel, tip, left)
            for corner, at in machine.cam.corners.items():
                x, y = place(at, 0.87 * float(shape.radius(at)), phase)
                panel.words(corner, x + left, y, 1e-4 * size)
        assert lift.min() == pytest.approx(shape.lowest)
        for part in ("cam", "follower, $m$", "spring, $k$", "damper, $b$", r"$\omega$"):
            panel.words(part)
        panel.words(r"impact: $u^+ = -r\,u^-$", 6.4 * size, within=1e-3 * size)
        ((begin, end),) = arrows(panel)
        assert begin[0] * end[1] - begin[1] * end[0] > 0.0  # counterclockwise

    def damper(panel, left):
        """Decoration: a cup on the frame, a piston in it on the stem."""
        own = [
            a for a in panel.left
            if isinstance(a, Line2D) and hexed(a.get_color()) == COLOURS["cam"]
            and dashes(a) == "solid" and left - 0.35 * size < np.mean(a.get_xdata())
            and np.mean(a.get_xdata()) < left - 0.05 * size and min(a.get_ydata()) > size
        ]  # fmt: skip
        assert len(own) == 5
        forget(panel, *own)

    def heights(panel, phase, gap, left):
        """q and c from one plane: their difference is the gap, and c is the lift."""
        cam, near = float(shape.radius(phase)), 1e-3 * size
        zero = cam - float(machine.cam.lift(phase)[0]) / ratio
        for side, height, symbol in ((-1.0, cam, "c"), (1.0, cam + gap, "q")):
            x = left + 0.5 * side * size
            (arrow,) = panel.pick(
                Annotation, lambda a, x=x: is_arrow(a) and abs(a.xy[0] - x) < near
            )
            assert (arrow.xyann[1], arrow.xy[1]) == pytest.approx((zero, height), rel=1e-4)
            scale = "" if ratio == 1.0 else f"/{ratio:g}"
            panel.words(f"${symbol}(t)${scale}", x, zero + 0.75 * (height - zero), 0.1 * size)
            line = [left, left + 0.56 * side * size]
            panel.line(line, [height] * 2, "cam", "dotted", within=1e-4 * size)
        panel.line([left - 0.74 * size, left + 0.74 * size], [zero] * 2, "cam", "dotted",
                   within=1e-4 * size)  # fmt: skip
        panel.words("0", y=zero, within=1e-4 * size)

    found = {
        "outline": drawn_outline, "turned": lambda panel: drawn_outline(panel, 180.0),
        "geometry": geometry, "geometry in words": geometry_in_words,
        "mechanism": mechanism, "lift": lift, "velocity": velocity, "acceleration": acceleration,
        "jerk": jerk, "force": force, "curvature": curvature, "curvature of the pitch curve": pitch,
    }  # fmt: skip
    if name == "eccentric":  # a disk under a flat face is no outline that a tip follows
        del found["geometry"], found["geometry in words"]
    return found


def phases_of(result):
    """Where the lift grows fastest, and where it falls fastest, by the table."""
    table = result.tables["profile"]
    slope = table["c_theta_m_per_rad"]
    return table["theta_deg"][np.argmax(slope)], table["theta_deg"][np.argmin(slope)]


def forget(panel, *artists):
    panel.left = [a for a in panel.left if a not in artists]


@pytest.mark.ci
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
        ("lift", "lift $c$ (m)"), ("velocity", "velocity\n$c_\\theta$ (m/rad)"),
        ("acceleration", "acceleration\n$c_{\\theta\\theta}$ (m/rad²)"),
        ("force", "contact force (N)"),
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


def test_what_belongs_together_stands_side_by_side():
    """The two curvatures of a cam, and what is beside the outline on its sheet; the rest has rows.

    Each panel is as wide as the page but for those that share a row.
    """
    contact = {"contact": {"face": "flat", "base_radius": 0.04}}
    sheet = camcli.simulate(VALVE.load(contact), profile_only=True)
    curves = ["lift", "velocity", "acceleration", "jerk", "force"]
    for result, wanted in (
        (made("chapter"), [*curves, ("curvature", "curvature of the pitch curve")]),
        (sheet, [("outline", "angle"), *curves, "radius"]),
    ):
        figure = camcli.plot(result)
        drawn = result.pictures["profile"]().chosen(None)
        rows = rows_on_page(figure, drawn)
        assert rows == [[row] if isinstance(row, str) else list(row) for row in wanted]
        cells = {panel.name: panel.axes.get_subplotspec().get_position(figure).width
                 for panel in on_page(figure, drawn)}  # fmt: skip
        for row in rows:
            assert sum(cells[name] for name in row) > 0.85 * max(cells.values())
            assert max(cells[name] for name in row) < 1.1 * max(cells.values()) / len(row)


@pytest.mark.ci
@pytest.mark.parametrize("face", ["roller", "flat"])
def test_the_sheet_shows_the_lobe_under_its_follower(face):
    """Outline, pressure angle or eccentricity, and radius, from the closed form of the lift."""
    base, roller = 0.04, 0.012 if face == "roller" else 0.0
    contact = {"face": face, "base_radius": base, "follower_radius": roller or None}
    result = camcli.simulate(VALVE.load({"contact": contact}), profile_only=True)
    drawn = result.pictures["profile"]().chosen(None)
    assert list(drawn) == ["outline", "angle", "lift", "velocity", "acceleration", "jerk", "force",
                           "radius"]  # fmt: skip
    names = ["outline", "angle", "radius"]
    figure = camcli.plot(result, panels=names)
    outline, angle, radius = figure.axes[1:]

    def path(theta):
        c, c1, c2 = VALVE.cam.lift(theta)
        return base + roller + c + 0.002, c1, c2

    def line(axes):
        (one,) = [a for a in axes.lines if len(a.get_xdata()) > 100]
        theta, values = map(np.asarray, one.get_data())
        clear = off_corners(VALVE.cam, theta)
        return theta[clear], values[clear], hexed(one.get_color())

    theta, values, _ = line(angle)
    R, d, dd = path(theta)
    wanted = d if face == "flat" else np.degrees(np.arctan2(d, R))
    assert values == pytest.approx(wanted, abs=1e-12)
    says = "eccentricity (mm)" if face == "flat" else "pressure angle (deg)"
    assert angle.get_ylabel() == says
    theta, values, colour = line(radius)
    assert colour == COLOURS["cam"]  # not undercut
    R, d, dd = path(theta)
    with np.errstate(divide="ignore"):
        wanted = (R * R + d * d) ** 1.5 / (R * R + 2.0 * d * d - R * dd) - roller
    wanted = R + dd if face == "flat" else wanted
    far = abs(wanted) >= 10.0 * base
    assert np.isnan(values[far]).all()
    assert values[~far] == pytest.approx(wanted[~far], rel=1e-9)
    assert radius.get_title(loc="right").startswith("least ")
    assert outline.get_title(loc="left").startswith(r"(a) $\theta$ = 0 deg, ")
    assert outline.get_title() == ""  # the letter would lie upon it
    assert angle.get_title(loc="right").startswith("−")  # no hyphen
    (body,) = [a for a in outline.patches if isinstance(a, Polygon)
               and hexed(a.get_facecolor()) == COLOURS["body"]]  # fmt: skip
    x, y = body.get_xy().T
    # the body is touched by the follower at every phase, and never cut by it
    for at in (0.0, 120.0, 150.0, 180.0, 230.0):
        (R,), _, _ = path(np.array([at]))
        turn = np.radians(at)
        along = x * np.sin(turn) + y * np.cos(turn)
        across = x * np.cos(turn) - y * np.sin(turn)
        if face == "flat":
            assert along.max() == pytest.approx(R, abs=2e-5)
        else:
            assert np.hypot(along - R, across).min() == pytest.approx(roller, abs=2e-5)
    circles = [a for a in outline.patches if isinstance(a, Circle) and a.get_fill()]
    assert [a.radius for a in circles] == ([roller] if face == "roller" else [])


@pytest.mark.parametrize("base", [0.02, 0.03])
def test_radii_that_are_nearly_straight_are_left_out_on_both_sides(monkeypatch, base):
    """Of more than some base radii, hollow or not; the axis is that of the others."""
    limit = cam_profile.MOST_RADII * base
    radii = [0.5 * limit, -0.5 * limit, 2.0 * limit, -2.0 * limit, 0.9 * limit, -0.9 * limit]
    lobe = Made(undercut=False, base=base, touches=[Made(radius=one) for one in radii])
    drawn = []
    monkeypatch.setattr(
        cam_profile, "_curve", lambda axes, of, values, colour: drawn.extend(values)
    )
    monkeypatch.setattr(cam_profile, "radius_title", lambda *_: "")
    whole = Made(profile=Made(lobe=lobe), units=MILLIMETRES)
    cam_profile._draw_radius(Figure().add_subplot(), whole)
    assert [None if isnan(value) else value for value in drawn] == [
        *radii[:2], None, None, *radii[4:],
    ]  # fmt: skip
