"""The pictures of periodic orbits against branch.csv, bifurcations.csv and curve.csv."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Annotation, Text

import camcli
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.proofs import Proof, Proofs, Range
from camcli.exact.shooting import ProofStep
from camcli.plots.branch_lines import curved
from camcli.plots.orbits import draw_curves, draw_orbits
from camcli.plots.proofs import proved_steps
from camcli.scene.schema import Plot
from tests.conftest import some_in_ci
from tests.support import all_orbits_oracle
from tests.support.machines import CHAPTER, VALVE, off_corners
from tests.support.picture_reader import (
    COLOURS,
    MARKS,
    Panel,
    check,
    dashes,
    hexed,
    mixed,
    motion_colour,
    read_page,
    usual,
)
from tests.support.picture_sizes import check_texts
from tests.truth.test_pictures_sweep import check_cloud

SHADES = ((0.0, "white"), (0.45, "white"), (0.45, "black"), (0.7, "white"), (0.2, "black"))
NEAR_DEG = 20.0  # phases further apart are not joined
BRANCHES = {
    "chapter": (
        CHAPTER,
        {"orbits.rpm": {"start": 672, "stop": 756, "num": 20}, "orbits.simulated": 12,
         "run.transient": 200, "run.record": 20, "run.strobe_deg": 40.0,
         "orbits.curve": "period-doubling", "orbits.curve_in": "restitution",
         "orbits.curve_range": [0.78, 0.82], "orbits.starts": 4},
    ),
    "valve": (
        VALVE,
        {"orbits.rpm": {"start": 6500, "stop": 10500, "num": 20}, "orbits.at": 8000,
         "orbits.starts": 4, "orbits.simulated": 9},
    ),
    "restitution": (
        VALVE,
        {"run.rpm": 7000, "orbits.starts": 4, "orbits.rpm.num": 8,
         "orbits.parameter": "restitution", "orbits.range": [0.4, 0.6]},
    ),
    "resting": (
        VALVE,
        {"orbits.rpm": {"start": 2900, "stop": 3600, "num": 8}, "orbits.at": 3300,
         "orbits.starts": 0},
    ),
}  # fmt: skip
BRANCHES["contact"] = (
    VALVE,
    {"orbits.rpm": {"start": 1500, "stop": 1600, "num": 3}, "orbits.at": 1550, "orbits.starts": 0},
)
ORBITS = {
    "chapter": (CHAPTER, {"orbits.rpm": {"start": 700, "stop": 700, "num": 1}}),
    "three turns": (
        CHAPTER,
        {"orbits.rpm": {"start": 358.5, "stop": 358.5, "num": 1}, "run.strobe_deg": 120.0},
    ),
    "valve": (VALVE, {"orbits.rpm": {"start": 7000, "stop": 7000, "num": 1}, "orbits.starts": 4}),
    "resting": (VALVE, {"orbits.rpm": {"start": 3300, "stop": 3300, "num": 1}, "orbits.starts": 0}),
}  # fmt: skip
NAMES = {"rpm": "cam speed (rpm)", "restitution": "coefficient of restitution $r$ (-)"}


@cache
def made(kind, name):
    machine, values = {"branches": BRANCHES, "orbits": ORBITS}[kind][name]
    return camcli.orbits(machine.load(values))


def shades(labels):
    """The colours of orbits: by their kind, those of one kind in shades."""
    wanted = [motion_colour(label) for label in labels]
    return [
        mixed(colour, *SHADES[wanted[:k].count(colour)]) for k, colour in enumerate(wanted)
    ]  # fmt: skip


class Branch:
    """The rows of one branch: parameter, phases, position, trace and determinant."""

    def __init__(self, table, number, parameter, colour):
        own = table["branch"] == number
        self.number, self.colour = number, colour
        self.x = np.asarray(table[parameter])[own]
        self.stable = np.asarray(table["stable"])[own] == 1
        theta = [c for c in table if c.startswith("theta_deg_")]
        self.theta = np.column_stack([table[c][own] for c in theta])
        self.q = np.asarray(table["q_m"])[own][:, None]
        self.trace, self.det = table["trace"][own], table["det"][own]
        self.label = table["label"][own][0]
        pairs = [
            table[f"multiplier_{k}_re"][own] + 1j * table[f"multiplier_{k}_im"][own] for k in (1, 2)
        ]
        self.pairs = np.column_stack(pairs)
        self.radius = np.abs(self.pairs).max(axis=1)

    def steady(self, k):
        """Whether orbits between row k and the next are stable: as that further from |mu| = 1."""
        further = k if abs(self.radius[k] - 1.0) >= abs(self.radius[k + 1] - 1.0) else k + 1
        return bool(self.stable[further])

    def segments(self, values, turn):
        """From row to row: parameter and value at both ends, and whether it is stable."""
        found = set()
        for k in range(len(self.x) - 1):
            for a, b in links(values[k], values[k + 1], NEAR_DEG if turn else np.inf):
                found.add((*rounded(self.x[k], a, self.x[k + 1], b), self.steady(k)))
        return found

    def share(self, mu):
        """Parameters at which a multiplier is mu, trace and determinant being linear in between."""
        t, d, dt, dd = self.trace[:-1], self.det[:-1], np.diff(self.trace), np.diff(self.det)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (mu * mu - t * mu + d) / (dt * mu - dd)
        near = (np.abs(s.imag) < 1e-6) & (s.real > -1e-6) & (s.real < 1.0 + 1e-6)
        found = (self.x[:-1] + s.real * np.diff(self.x))[near]
        return [*found, *self.x[np.abs(self.pairs - mu).min(axis=1) < 1e-9]]


def links(before, after, most):
    """Which values of one row go on in the next: the nearest first, each once."""
    a, b = (row[np.isfinite(row)] for row in (before, after))
    pairs = sorted((abs(x - y), i, j) for i, x in enumerate(a) for j, y in enumerate(b))
    taken, found = set(), []
    for away, i, j in pairs:
        if away <= most and not {("a", i), ("b", j)} & taken:
            taken |= {("a", i), ("b", j)}
            found.append((a[i], b[j]))
    return found


def period_of(label):
    """Turns after which a motion repeats; one that stays on the cam does so in each."""
    return int(label[2:].partition(";")[0]) if label.startswith("P(") else 1


def rounded(*values):
    return tuple(float(f"{value:.9g}") for value in values)


def strokes(lines):
    """From point to point of lines: both ends, and whether it is drawn solid."""
    found = set()
    for line in lines:
        x, y = line.get_data()
        assert dashes(line) in ("solid", "dashed")
        for k in range(len(x) - 1):
            found.add((*rounded(x[k], y[k], x[k + 1], y[k + 1]), dashes(line) == "solid"))
    return found


def checks(name):
    machine, values = BRANCHES[name]
    result = made("branches", name)
    parameter = values.get("orbits.parameter", "rpm")
    table, events = result.tables["branch"], result.tables["bifurcations"]
    numbers = list(dict.fromkeys(table["branch"]))
    period = {n: period_of(table["label"][table["branch"] == n][0]) for n in numbers}
    colours = dict(
        zip(
            numbers, shades([table["label"][table["branch"] == n][0] for n in numbers]), strict=True
        )
    )
    branches = [Branch(table, n, parameter, colours[n]) for n in numbers]
    span = result.scene.orbits.rpm
    low, high = values.get("orbits.range", sorted((span.start, span.stop)))
    found = {}  # events by what several branches share
    for k in range(len(events["kind"])):
        at = events[parameter][k]
        found.setdefault((events["kind"][k], events["corner"][k], f"{at:.9g}"), k)
    order = sorted(found.values(), key=lambda k: events[parameter][k])
    corners = machine.cam.corners
    simulated = "orbits.simulated" in values

    def common(panel, named):
        for number, k in enumerate(order, 1):
            at = events[parameter][k]
            panel.guide("x", at, "cam", "dotted")
            if named:
                assert panel.words(str(number)).xy == pytest.approx((at, 1.0))
        room = 0.02 * (high - low)
        assert panel.axes.get_xlim() == pytest.approx((low - room, high + room))
        assert panel.axes.get_xlabel() == NAMES[parameter]

    def grey(panel, section, column):
        if simulated:
            rows = result.tables[section]
            points = [(x, y, "") for x, y in zip(rows[parameter], rows[column], strict=True)]
            points += [(x, np.nan, "") for x in result.tables["strobe"][parameter]]
            check_cloud(panel, points, {"": COLOURS["simulated"]}, fills=False)
            panel.key(("simulated", "simulated"))

    def lines_of(panel, of, turn):
        for branch in branches:
            lines = [a for a in panel.lines(branch.colour, None) if a.get_marker() in ("None", "")]
            assert strokes(lines) == branch.segments(of(branch), turn), branch.number
            assert {bool(line.get_path_effects()) for line in lines} <= {simulated}  # a white rim

    def marked(panel, of, corner):
        """The event's marks, at the corner or where its branch is."""
        for k in order:
            kind, at = events["kind"][k], events[parameter][k]
            branch = branches[numbers.index(events["branch"][k])]
            nearest = np.argsort(np.abs(branch.x - at), kind="stable")[:2]
            wanted = of(branch)[nearest]
            marker, face, edge = MARKS[kind]

            def fits(a, at=at, marker=marker, face=face, edge=edge):
                return (
                    isinstance(a, Line2D) and a.get_marker() == marker
                    and same_place(a.get_xdata(), at)
                    and hexed(a.get_markerfacecolor()) == hexed(face)
                    and hexed(a.get_markeredgecolor()) == hexed(edge)
                )  # fmt: skip

            (marks,) = panel.pick(Line2D, fits, 1)
            y = np.array(marks.get_ydata())
            if corner and events["corner"][k]:
                assert y == pytest.approx([corners[events["corner"][k]]], abs=1e-6)
                continue
            size = np.nanmax(np.abs(wanted))
            step = np.nanmax(np.abs(np.diff(wanted, axis=0)), initial=0.0) + 1e-6 * size
            away = np.abs(y[:, None] - wanted.ravel()[None]).T
            if not corner:  # the table has the state at the first strobe, of every turn it is drawn
                assert len(y) == period[branch.number]
                away = away[:, [int(np.argmin(np.nanmin(away, axis=0)))]]
            assert np.nanmin(away, axis=0).max() <= step, (kind, y, wanted)

    def branch_numbers(panel, of):
        for branch in branches:

            def is_its(a, b=branch):
                return a.get_text() == str(b.number) and hexed(a.get_color()) == b.colour

            texts = panel.pick(Text, is_its)
            assert len(texts) <= 1
            for text in texts:
                x, y = text.get_position()
                columns = [column_of(branch.x, column) for column in of(branch).T]
                away = [abs(np.interp(x, *own) - y) for own in columns if len(own[0])]
                assert min(away) < 5e-2 * np.ptp(panel.axes.get_ylim())

    def phases(panel):
        grey(panel, "impacts", "theta_deg")
        lines_of(panel, lambda b: b.theta, 360.0)
        marked(panel, lambda b: b.theta, corner=True)
        branch_numbers(panel, lambda b: b.theta)
        common(panel, named=True)
        panel.corners(corners, "y")
        if not any(np.isfinite(branch.theta).any() for branch in branches):
            panel.words("there is no impact", 0.5, 0.5)
            return
        what = "departure" if "inf" in branches[0].label else "impact"
        panel.reads("y", rf"{what} phase $\theta$ (deg)")

    def positions(panel):
        grey(panel, "strobe", "q_m")
        # a table has the first state of an orbit; of several turns the others are drawn beside it
        for branch in branches:
            lines = [a for a in panel.lines(branch.colour, None) if a.get_marker() in ("None", "")]
            wanted = branch.segments(branch.q, 0.0)
            if period[branch.number] == 1:
                assert strokes(lines) == wanted
            else:
                assert strokes(lines) > wanted
        marked(panel, lambda b: b.q, corner=False)
        common(panel, named=False)
        strobe = values.get("run.strobe_deg", machine.strobe_deg)
        at = f", $\\theta$ = {strobe:g} deg" if strobe else ""
        panel.reads("y", f"stroboscopic $q$ ({machine.unit}){at}", machine.per_m)

    def plane(panel):
        unit_circle(panel)
        rings = [
            a for a in panel.pick(Line2D, lambda a: dashes(a) == "dotted")
            if hexed(a.get_color()) == COLOURS["guide"]
        ]  # fmt: skip
        sizes = [b.det[k] ** 0.5 for b in branches for k in range(len(b.x))
                 if b.trace[k] ** 2 < 4.0 * b.det[k]]  # fmt: skip
        told = []
        for ring in rings:
            size = np.hypot(*ring.get_data())
            assert np.ptp(size) < 1e-9
            assert min(abs(size[0] - s) for s in sizes) < 1e-9
            told.append(size[0])
        assert bool(rings) == bool(sizes)
        if told:
            panel.words(rf"dotted: $|\mu|$ = {', '.join(f'{size:.4g}' for size in sorted(told))}")
        numbered = panel.pick(Annotation, lambda a: bool(a.get_text()))
        pairs = [
            (branch, k) for branch in branches for k in range(len(branch.x) - 1)
            if branch.trace[k] ** 2 < 4.0 * branch.det[k]
        ]  # fmt: skip
        for number in numbered:
            value, mu = float(number.get_text()), complex(*number.xy)
            near = [  # between two rows of a branch, on the way from pair to pair
                abs(mu - branch.pairs[j]).min()
                for branch, k in pairs for j in (k, k + 1)
                if min(branch.x[k : k + 2]) <= value <= max(branch.x[k : k + 2])
            ]  # fmt: skip
            assert min(near) < 0.06, (value, mu)
            assert mu.imag > 0.0
            panel.dots([mu.real], [mu.imag], "o", "white", "cam", within=1e-12)
        arrows = panel.pick(Annotation)
        for branch in branches:
            outside(panel, branch.pairs.ravel(), branch.colour)
            lines = panel.lines(branch.colour, None)
            points = np.concatenate([a.get_xdata() + 1j * np.asarray(a.get_ydata()) for a in lines])
            for mu in branch.pairs[:: max(1, len(branch.pairs) // 7)].ravel():
                assert np.abs(points - mu).min() < 0.03, (branch.number, mu)
            for line in lines:
                own = line.get_xdata() + 1j * np.asarray(line.get_ydata())
                assert all(branch.share(mu) for mu in own[:: max(1, len(own) // 9)])
                stable = dashes(line) == "solid"
                if dashes(line) == "none":  # a path too short to be seen
                    stable = hexed(line.get_markerfacecolor()) == branch.colour
                    if not stable:
                        assert hexed(line.get_markerfacecolor()) == COLOURS["white"]
                assert not stable or np.abs(own).max() < 1.0 + 1e-6
                assert stable in {branch.steady(k) for k in range(len(branch.x) - 1)}
        for arrow in arrows:
            head, tail = complex(*arrow.xy), complex(*arrow.xyann)
            rising = [
                min(abs(a - b) for a in branch.share(head) for b in branch.share(tail)) > 0.0
                and max(a - b for a in branch.share(head) for b in branch.share(tail)
                        if abs(a - b) < 0.2 * np.ptp(branch.x)) > 0.0
                for branch in branches
                if branch.share(head) and branch.share(tail)
                and hexed(arrow.arrow_patch.get_facecolor()) == branch.colour
            ]  # fmt: skip
            assert rising
            assert all(rising)
        said = {"rpm": "cam speed", "restitution": "coefficient of restitution"}[parameter]
        unit = {"rpm": "rpm", "restitution": "-"}[parameter]
        assert panel.title.replace(
            "\n", " "
        ) == f"arrows: rising {said}" + f"; numbers: {unit}" * bool(numbered)
        if name == "chapter":
            assert len(numbered) >= 3
        furthest = max(b.radius.max() for b in branches)
        half = panel.axes.get_xlim()[1]
        assert panel.axes.get_xlim() == panel.axes.get_ylim() == (-half, half)
        assert half == pytest.approx(min(max(1.2, 1.06 * furthest), 1.5))
        beyond = f" (triangle: beyond ±{half:g})" if furthest > half else ""
        assert panel.labels == (rf"Re $\mu${beyond}", r"Im $\mu$")

    def real_parts(panel):
        panel.guide("y", -1.0, "cam")
        panel.guide("y", 1.0, "cam")
        panel.band("y", -1.0, 1.0, "body")
        turns = []
        for branch in branches:
            lines = panel.lines(branch.colour, None)
            for line in lines:
                x, y = map(np.asarray, line.get_data())
                order = np.argsort(branch.x)
                for at, real in list(zip(x, y, strict=True))[:: max(1, len(x) // 12)]:
                    k = np.searchsorted(branch.x[order], at)
                    near = order[max(0, k - 2) : k + 2]
                    roots = [np.roots([1.0, -t, d]) for t, d in between(branch, near, at)]
                    away = min(np.abs(r.real - real).min() for r in roots)
                    assert away < 1e-6 * max(1.0, abs(real)), (branch.number, at, real)
                assert dashes(line) == ("solid" if shown_stable(branch, x) else "dashed")
            gap = branch.trace**2 - 4.0 * branch.det
            signs = np.flatnonzero(gap[1:] * gap[:-1] < 0.0)
            turns += [sorted(branch.x[[k, k + 1]]) for k in signs]
        marks = panel.pick(
            Line2D, lambda a: hexed(a.get_color()) == COLOURS["guide"] and dashes(a) == "dashed"
        )
        at = [a.get_xdata()[0] for a in marks]
        assert len(at) == min(2, len(turns))
        room = np.ptp([low, high]) * 1e-3
        assert all(any(a - room <= x <= b + room for a, b in turns) for x in at)
        assert panel.title.replace("\n", " ").startswith(
            "a complex pair turns real at " if at else ""
        )
        for x in at:
            assert f"{x:.6g}" in panel.title
        if name == "chapter":  # the number of the model
            assert min(abs(x - 738.7743752) for x in at) < 0.01
        common(panel, named=False)
        largest = max(np.abs(b.pairs.real).max() for b in branches)
        says = r"Re $\mu$ (asinh scale)" if largest > 4.0 else r"Re $\mu$"
        assert panel.axes.get_ylabel() == says
        assert panel.axes.get_yscale() == ("asinh" if largest > 4.0 else "linear")

    def zoom(panel):
        """A corner impact that hides beside another event: lines through the rows around it."""
        k = order[int(panel.name.split()[1]) - 1]
        at, corner = events[parameter][k], corners[events["corner"][k]]
        begin, end = panel.axes.get_xlim()
        assert 0.5 * (begin + end) == pytest.approx(at)
        rows = result.tables["impacts"]
        points = [(x, y, "") for x, y in zip(rows[parameter], rows["theta_deg"], strict=True)]
        near = [p for p in points if begin <= p[0] <= end]
        if near:
            check_cloud(panel, near, {"": COLOURS["simulated"]}, fills=False)
            panel.key(("simulated", "simulated"))
        for branch in branches:
            lines = [a for a in panel.lines(branch.colour, None) if a.get_marker() in ("None", "")]
            drawn = np.concatenate([np.column_stack(a.get_data()) for a in lines])
            for x, theta in zip(branch.x, branch.theta, strict=True):
                for one in theta[np.isfinite(theta)] if begin <= x <= end else ():
                    away = np.abs(drawn - [x, one]) / [end - begin, 10.0]
                    assert away.max(axis=1).min() < 1e-6
            for line in lines:
                x, y = line.get_data()
                for px, py in list(zip(x, y, strict=True))[:: max(1, len(x) // 20)]:
                    columns = [column_of(branch.x, column) for column in branch.theta.T]
                    away = [abs(np.interp(px, *own) - py) for own in columns if len(own[0])]
                    assert min(away) < 1.0
            if branch.label == "P(1;1)":  # also between the rows
                assert max(away_from_closed_form(*line.get_data()).max() for line in lines) < 1e-6
        seen = [i for i in order if begin <= events[parameter][i] <= end]
        for i in seen:
            panel.guide("x", events[parameter][i], "cam", "dotted")
            assert panel.words(str(order.index(i) + 1)).xy == pytest.approx(
                (events[parameter][i], 1.0)
            )
            panel.pick(Line2D, lambda a, i=i: same_place(a.get_xdata(), events[parameter][i]), 1)
        branch_numbers(panel, lambda b: b.theta)
        panel.corners(corners, "y")
        others = [i for i in order if events[parameter][i] != at]
        beside = min(others, key=lambda i: abs(events[parameter][i] - at))
        phases = np.degrees(result.values.bifurcations[beside].orbit.theta)
        reach = 2.2 * max(np.abs(phases - corner).min(), 0.05)
        ends = [corner]
        for line in panel.axes.lines:
            x, y = (np.asarray(values, dtype=float) for values in line.get_data())
            if line.get_marker() in ("None", "") and len(x) > 2:
                ends += y[(x >= begin) & (x <= end) & (np.abs(y - corner) <= reach)].tolist()
        room = 0.1 * np.ptp(ends) or 0.1
        wanted = min(ends) - room, max(ends) + room
        assert panel.axes.get_ylim() == pytest.approx(wanted)
        assert panel.labels == (NAMES[parameter], r"phase $\theta$ (deg), enlarged")

    def words(panel):
        number = int(panel.name.split()[1])
        k = order[number - 1]
        label = events["label"][k].replace("inf", "∞")
        assert panel.title == f"{number}: {label}, corner impact at {events['corner'][k]}"
        (text,) = panel.pick(Text)
        said = " ".join(text.get_text().split()).replace("−", "-")
        for side, where in (
            ("left", "before the corner (left)"),
            ("right", "after the corner (right)"),
        ):
            trace, det = events[f"trace_{side}"][k], events[f"det_{side}"][k]
            assert f"impact {where}: trace {trace:.6g}, determinant {det:.6g}, multipliers " in said
            one, two = np.roots([1.0, -trace, det])
            pair = sorted([one.real, two.real], key=abs, reverse=True)  # the larger one first
            wanted = [one.real, abs(one.imag)] if one.imag else pair
            tail = said.partition(where)[2].partition("multipliers ")[2]
            found = [float(x) for x in re.findall(r"-?[\d.]+", tail)[:2]]
            assert found == pytest.approx(wanted, rel=1e-3)
            assert ("±" in tail[:20]) == bool(one.imag)
        assert events["classification"][k] in said

    return {
        "phases": phases, "positions": positions, "plane": plane, "multipliers": real_parts,
        "event": zoom, "event in words": words,
    }  # fmt: skip


def away_from_closed_form(rpm, theta_deg):
    """How far orbits with one impact a turn are from c = (1+r)/(1-r) cot(pi w0/w) (w/w0) c_theta.

    A share of c; for a follower without damping, gravity and preload.
    """
    c, c1, _ = CHAPTER.cam.lift(theta_deg)
    ratio = np.sqrt(CHAPTER.stiffness / CHAPTER.mass) / (np.asarray(rpm) * np.pi / 30.0)
    bounce = (1.0 + CHAPTER.restitution) / (1.0 - CHAPTER.restitution)
    return np.abs(1.0 - bounce / np.tan(np.pi * ratio) / ratio * c1 / c)


def outside(panel, mu, colour):
    """A triangle of a colour at each border beyond which multipliers lie; these are all real."""
    half = panel.axes.get_xlim()[1]
    assert np.abs(mu.imag).max() <= half
    wanted = {">"} if (mu.real > half).any() else set()
    wanted |= {"<"} if (mu.real < -half).any() else set()

    def is_its(a):
        return a.get_marker() in {"<", ">", "^", "v"} and hexed(a.get_color()) == colour

    found = panel.pick(Line2D, is_its)
    assert {a.get_marker() for a in found} == wanted
    assert len(found) == len(wanted)
    for a in found:
        assert a.get_xdata()[0] == (half if a.get_marker() == ">" else -half)
        assert a.get_ydata()[0] == 0.0


def unit_circle(panel):
    (disk,) = panel.pick(Polygon)
    assert np.hypot(*disk.get_xy().T) == pytest.approx(np.ones(len(disk.get_xy())))
    assert hexed(disk.get_facecolor()) == COLOURS["body"]
    assert hexed(disk.get_edgecolor()) == COLOURS["cam"]
    panel.guide("x", 0.0, "guide")
    panel.guide("y", 0.0, "guide")
    assert panel.axes.get_aspect() == 1.0


def same_place(x, at):
    return len(x) > 0 and np.abs(np.asarray(x, dtype=float) - at).max() < 1e-9 * abs(at)


def column_of(x, y):
    """Known values of a column over a rising parameter."""
    known = np.isfinite(y)
    order = np.argsort(x[known], kind="stable")
    return x[known][order], y[known][order]


def between(branch, near, at):
    """Trace and determinant at a parameter, on lines between rows that are near."""
    for i in near:
        for j in near:
            a, b = branch.x[i], branch.x[j]
            if abs(i - j) == 1 and min(a, b) - 1e-9 <= at <= max(a, b) + 1e-9 and a != b:
                s = (at - a) / (b - a)
                yield tuple(c[i] + s * (c[j] - c[i]) for c in (branch.trace, branch.det))
        if abs(branch.x[i] - at) < 1e-6:
            yield branch.trace[i], branch.det[i]


def shown_stable(branch, x):
    """Whether orbits are stable where a line over the parameter runs."""
    middle = 0.5 * (x[0] + x[-1])
    inside = [
        branch.steady(k) for k in range(len(branch.x) - 1)
        if min(branch.x[k : k + 2]) <= middle <= max(branch.x[k : k + 2])
    ]  # fmt: skip
    return inside[0]


@pytest.mark.parametrize("name", some_in_ci(BRANCHES, quick=["restitution", "contact"]))
def test_every_panel_of_branches_shows_the_rows_of_the_tables(name):
    seen = check(made("branches", name), checks(name), "orbits")
    assert seen >= {"phases", "positions", "plane", "multipliers"}
    assert ("event in words" in seen) == (name == "chapter")


def test_the_page_of_branches_names_every_branch_and_every_event():
    result = made("branches", "chapter")
    page, table = read_page(result, "orbits"), result.tables["branch"]
    page.says("Periodic orbits, 672 to 756 rpm", "found at 700 rpm")
    numbers = list(dict.fromkeys(table["branch"]))
    labels = {n: table["label"][table["branch"] == n][0] for n in numbers}
    wanted = shades([labels[n] for n in numbers])
    for n, colour in zip(numbers, wanted, strict=True):
        (row,) = [r for r in page.rows() if any(str(c).startswith(f"{n}   {labels[n]}") for c in r)]
        assert hexed(row[0].get_color()) == colour
    page.row("1", "corner impact of P(1;1) at b", "673.234445", "1, 2", "nonsmooth fold")
    page.row("2", "period doubling of P(1;1)", "739.31978", "1", "3 leaves")
    row = page.row(
        "3", "corner impact of P(2;1:1) at c", "739.37793", "3", "border period doubling"
    )
    (mark,) = [c for c in row if isinstance(c, Line2D) and c.get_marker() == "o"]
    assert hexed(mark.get_markerfacecolor()) == COLOURS["white"]


def test_a_curve_of_bifurcations_is_drawn_through_the_rows_of_its_table():
    result = made("branches", "chapter")
    table = result.tables["curve"]

    def curves(panel):
        for number, colour in zip(
            dict.fromkeys(table["curve"]), shades(["P(1;"] * len(set(table["curve"]))), strict=True
        ):
            own = table["curve"] == number
            label, kind = table["label"][own][0], table["kind"][own][0].replace("-", " ")
            lines = panel.lines(colour)
            (line,) = [a for a in lines if len(a.get_xdata()) == own.sum()]
            assert line.get_xdata() == pytest.approx(table["rpm"][own])
            assert line.get_ydata() == pytest.approx(table["restitution"][own])
            ends = result.summary["curves"][number - 1]["ends"]
            corner = f" at {table['corner'][own][0]}" if table["corner"][own][0] else ""
            why = "; ".join(sorted(set(ends) - {"end-of-range"}))
            said = f"{kind}{corner} of {label}" + f" (ends: {why})" * bool(why)
            assert line.get_label() == said
            open_ends = [k for k, end in zip((0, -1), ends, strict=True) if end != "end-of-range"]
            marks = [(a.get_xdata()[0], a.get_ydata()[0]) for a in lines if a is not line]
            assert marks == [
                (table["rpm"][own][k], table["restitution"][own][k]) for k in open_ends
            ]
        assert panel.labels == ("cam speed (rpm)", "coefficient of restitution $r$ (-)")

    assert check(result, {"curves": curves}, "curve") == {"curves"}


def test_a_band_lies_along_the_parts_of_a_curve_that_are_proved():
    result = made("branches", "chapter")
    curves = result.values.curves
    table = result.tables["curve"]
    own = table["curve"] == 1
    count = int(own.sum())
    assert count >= 5
    ranges = [
        CurveRange(1, 1, 3, ((0.0, 0.0), (0.0, 0.0)), 5),
        CurveRange(1, 3, 4, ((0.0, 0.0), (0.0, 0.0)), 5, ProofStep.GRAZES),
        CurveRange(1, 4, count, ((0.0, 0.0), (0.0, 0.0)), 5),
    ]
    figure = draw_curves(curves, ("rpm", "restitution"), (), ranges).figure()
    axes = figure.axes[1]
    lines = [line for line in axes.lines if hexed(line.get_color()) == "#FFE600"]
    bands = [line for line in lines if len(line.get_xdata())]
    assert [len(band.get_xdata()) for band in bands] == [3, count - 3]
    for band, rows in zip(bands, (slice(0, 3), slice(3, count)), strict=True):
        assert band.get_xdata() == pytest.approx(table["rpm"][own][rows])
        assert band.get_ydata() == pytest.approx(table["restitution"][own][rows])
        others = [line for line in axes.lines if line not in lines and len(line.get_xdata()) > 1]
        assert all(line.get_zorder() > band.get_zorder() for line in others)
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend[-1] == "proved without a gap"
    plain = draw_curves(curves, ("rpm", "restitution"), (), ranges[1:2]).figure()
    assert "#FFE600" not in [hexed(line.get_color()) for line in plain.axes[1].lines]


# --- all orbits of one speed

EXCLUDED = {  # by what a box is without an orbit: the legend's words
    "#EFEFEF": "the other flight is longer",
    "#BFD3E6": "no orbit has such a flight",
    "#F2D9A6": "the rates of an impact do not agree",
    "#8FBF9F": "a Newton step leads out of the box",
}
HOLDS_ORBIT = "#E58FA3"


@pytest.mark.ci
def test_boxes_without_an_orbit_cover_all_phases_of_two_impacts():
    """All but those with an orbit of branch.csv. A flight that no orbit has is none, or too fast.

    The judge of flights is `all_orbits_oracle`, which knows nothing of balls.
    """
    result = camcli.orbits(CHAPTER.load({"orbits.all": {"impacts": 2, "turns": 2},
                                         "orbits.at": 700.0}))  # fmt: skip
    w = all_orbits_oracle.W0 / (700.0 * np.pi / 30)
    table = result.tables["branch"]
    counts = {(one["impacts"], one["turns"]): one for one in result.summary["all"]["covers"]}
    turned = iter((1, 2))

    def cover(panel):
        turns = next(turned)
        rng = np.random.default_rng(turns)
        low, high = panel.axes.get_ylim()
        assert low == 180.0 * turns
        assert panel.axes.get_xlim() == (0.0, 360.0)
        boxes = {}
        for one in panel.pick(PolyCollection):
            boxes[hexed(one.get_facecolor()[0])] = [path.vertices[:4] for path in one.get_paths()]
        named = {**EXCLUDED, HOLDS_ORBIT: "the box holds one orbit, which is known"}
        panel.key(*((named[colour], colour) for colour in boxes))
        for at in places(turns):
            assert any(holds(box, *at) for box in boxes[HOLDS_ORBIT])
        for _ in range(300):
            x, length = rng.uniform(0.0, 360.0), rng.uniform(low, high)
            inside = {colour for colour, own in boxes.items()
                      if any(holds(box, x, length) for box in own)}  # fmt: skip
            assert inside
            if inside == {HOLDS_ORBIT}:
                assert any(abs(x - a) < 8.0 and abs(length - b) < 8.0 for a, b in places(turns))
            elif inside == {"#BFD3E6"}:
                phases = np.radians([x, x + length])
                flown = all_orbits_oracle.is_flown(phases, turns, w)
                assert not flown or all_orbits_oracle.is_too_fast(phases, turns, w)
        labels = list(dict.fromkeys(table["label"]))  # orbits of one label look alike
        shade = dict(zip(labels, shades(labels), strict=True))
        colours = [shade[label] for label in table["label"]]
        for row, colour in enumerate(colours):
            at = place(row, turns)
            if at is not None:
                face = colour if table["stable"][row] else "white"
                state = "stable" if table["stable"][row] else "unstable"
                words = f"{table['label'][row]}, {state}"
                panel.dots([at[0]], [at[1]], "o", face, colour, label=words)
        panel.corners(CHAPTER.cam.corners, "x", named=False)
        boxes = counts[2, turns]["boxes"]
        assert panel.title == f"2 impacts in {turns} turn{'s' * (turns > 1)}: {boxes} boxes"
        assert panel.labels == ("phase of the first impact (deg)", "from it to the second (deg)")

    def place(row, turns):
        own = [table[f"theta_deg_{k}"][row] for k in (1, 2)]
        own = [x for x in own if np.isfinite(x)]
        if table["label"][row].startswith("P(1;1)"):
            return (own[0], 360.0) if turns == 2 else None
        if turns != 1 or len(own) != 2:
            return None
        lengths = [(own[1 - k] - own[k]) % 360.0 for k in (0, 1)]
        return max(zip(own, lengths, strict=True), key=lambda pair: pair[1])

    def places(turns):
        found = (place(row, turns) for row in range(len(table["label"])))
        return [one for one in found if one is not None]

    def holds(box, x, length):
        (left, at_left), (right, at_right), _, (_, top) = box
        share = (x - left) / (right - left)
        bottom = at_left + share * (at_right - at_left)
        return left <= x <= right and bottom <= length <= bottom + top - at_left

    assert check(result, {"cover": cover}, "cover") == {"cover"}
    assert next(turned, None) is None
    for width in (85.0, 170.0):
        check_texts(result.pictures["cover"]().figure(Plot(width=width)))


# --- the orbits of one speed


class Orbit:
    """A row of branch.csv with one period of its motion, simulated from its state."""

    def __init__(self, name, k, colour):
        machine, values = ORBITS[name]
        table = made("orbits", name).tables["branch"]
        self.label, self.colour = table["label"][k], colour
        self.turns = period_of(self.label)
        self.stable = table["stable"][k] == 1
        theta = np.array([table[c][k] for c in table if c.startswith("theta_deg_")], dtype=float)
        self.theta = theta[np.isfinite(theta)]
        self.mu = np.array(
            [table[f"multiplier_{n}_re"][k] + 1j * table[f"multiplier_{n}_im"][k] for n in (1, 2)]
        )
        self.rpm = table["rpm"][k]
        self.strobe = values.get("run.strobe_deg", machine.strobe_deg)
        state = {"q": table["q_m"][k], "v": table["v_m_per_s"][k], "theta_deg": self.strobe}
        changes = {"run.rpm": self.rpm, "run.start": state, "run.transient": 0,
                   "run.record": self.turns, "run.strobe_deg": self.strobe}  # fmt: skip
        run = camcli.simulate(machine.load(changes)).tables
        rows, events = run["trajectory"], run["events"]
        self.angle = self.strobe + 6.0 * self.rpm * rows["t_s"]
        c, c1, _ = machine.cam.lift(self.angle)
        self.q, self.gap = rows["q_m"], rows["q_m"] - c
        self.u = rows["v_m_per_s"] - c1 * np.radians(6.0 * self.rpm)
        self.rests = rows["contact"] == "sticking"
        self.gap[self.rests] = self.u[self.rests] = 0.0
        impact = events["event"] == "impact"
        self.impacts = self.strobe + 6.0 * self.rpm * events["t_s"][impact], events["q_m"][impact]
        turns = np.arange(self.turns) * 360.0 + self.strobe
        first = np.searchsorted(self.angle, turns - 1e-6)
        omega = self.rpm * np.pi / 30.0
        self.states = rows["q_m"][first], rows["v_m_per_s"][first] / omega


def single_checks(name):
    machine, _ = ORBITS[name]
    table = made("orbits", name).tables["branch"]
    colours = shades(table["label"])
    orbits = [Orbit(name, k, colour) for k, colour in enumerate(colours)]
    longest = max(orbits, key=lambda orbit: orbit.turns)

    def dots(panel, x, y, orbit):
        face = orbit.colour if orbit.stable else "white"
        panel.dots(x, y, "o", face, orbit.colour, within=1e-6 * np.abs(np.append(x, y)).max())

    def style(orbit):
        return "solid" if orbit.stable else "dashed"

    def motion(panel):
        (cam,) = panel.lines("cam", "cam", count=1)
        x, c = cam.get_data()
        assert np.abs(c - machine.cam.lift(x)[0]).max() < 1e-11
        assert (min(x), max(x)) == pytest.approx(
            (longest.strobe, longest.strobe + 360.0 * longest.turns), abs=2.0
        )
        for orbit in orbits:
            for line in [
                a for a in panel.left if isinstance(a, Line2D) and len(a.get_xdata()) > 50
            ]:
                if hexed(line.get_color()) == orbit.colour and dashes(line) == style(orbit):
                    x, y = line.get_data()
                    away = np.abs(np.interp(orbit.angle, x, y) - orbit.q)
                    if away[orbit.angle <= x[-1]].max() < 1e-6 * np.abs(orbit.q).max():
                        panel.left.remove(line)
                        break
            else:
                panel.fail("line of", orbit.label)
            if orbit.rests.any():
                (rest,) = panel.lines("sticking", "sticking", count=1)
                x, y = map(np.asarray, rest.get_data())
                seen = np.isfinite(y)
                inner = orbit.rests & np.append(orbit.rests[1:], False)
                assert (
                    np.abs(np.interp(orbit.angle[inner], x[seen], y[seen]) - orbit.q[inner]).max()
                    < 1e-6
                )
            if len(orbit.impacts[0]):
                panel.marks(*orbit.impacts, "impact", "impact", within=1e-5)
        for turn in np.arange(0.0, 360.0 * longest.turns + 361.0, 360.0):
            begin, end = panel.axes.get_xlim()
            if begin <= turn <= end:
                panel.guide("x", turn, "guide")
        panel.reads("y", f"position $q$ ({machine.unit})", machine.per_m)

    def loop(panel):
        panel.guide("x", 0.0, "guide")
        panel.guide("y", 0.0, "guide")
        for orbit in orbits:
            size = np.ptp(orbit.gap) or 1.0, np.ptp(orbit.u) or 1.0
            flying = ~orbit.rests
            for line in panel.left:
                if hexed(line.get_color()) != orbit.colour or dashes(line) != style(orbit):
                    continue
                x, y = (
                    column[np.isfinite(line.get_ydata())]
                    for column in map(np.asarray, line.get_data())
                )
                away = np.maximum(
                    np.abs(x[None] - orbit.gap[flying][:, None]) / size[0],
                    np.abs(y[None] - orbit.u[flying][:, None]) / size[1],
                ).min(axis=1)
                if np.sort(away)[: -2 * len(orbit.impacts[0]) - 2].max() < 1e-6:
                    panel.left.remove(line)
                    break
            else:
                panel.fail("loop of", orbit.label)
        assert panel.axes.get_xlabel().startswith("relative position $q - c$ (")
        panel.reads("y", r"relative velocity $u = v - \dot c$ (m/s)")

    def plane(panel):
        unit_circle(panel)
        for orbit in orbits:
            dots(panel, orbit.mu.real, orbit.mu.imag, orbit)
            outside(panel, orbit.mu, orbit.colour)
        half = panel.axes.get_xlim()[1]
        furthest = max(np.abs(orbit.mu).max() for orbit in orbits)
        beyond = f" (triangle: beyond ±{half:g})" if furthest > half else ""
        assert panel.labels == (rf"Re $\mu${beyond}", r"Im $\mu$")

    def on_the_cam(panel):
        order = ("lift", "velocity", "acceleration").index(panel.name)
        (line,) = [a for a in panel.lines("cam", None) if len(a.get_xdata()) > 50]
        theta, values = line.get_data()
        wanted = machine.cam.lift(theta)[order]
        seen = np.isfinite(theta) & off_corners(machine.cam, theta)
        assert np.abs(values - wanted)[seen].max() < 1e-9 * np.nanmax(np.abs(wanted))
        for orbit in orbits:

            def is_its(a, orbit=orbit):
                return a.get_marker() == "o" and hexed(a.get_markeredgecolor()) == orbit.colour

            (marks,) = panel.pick(Line2D, is_its, 1)
            face = orbit.colour if orbit.stable else COLOURS["white"]
            assert hexed(marks.get_markerfacecolor()) == face
            at, heights = map(np.asarray, marks.get_data())
            assert np.sort(at) == pytest.approx(np.sort(orbit.theta), abs=1e-6)
            away = np.abs(heights - machine.cam.lift(at)[order])[off_corners(machine.cam, at)]
            assert away.max(initial=0.0) < 1e-4 * np.ptp(values[seen])
            for phase in orbit.theta:
                panel.guide("x", phase, orbit.colour, style(orbit))
        panel.corners(machine.cam.corners, "x", named=panel.name == "lift")
        names = ["lift $c$", "velocity\n$c_\\theta$", "acceleration\n$c_{\\theta\\theta}$"]
        per = ("", "/rad", "/rad²")[order]
        panel.reads("y", f"{names[order]} ({machine.unit}{per})", machine.per_m)
        assert panel.axes.get_xlabel() == r"cam angle $\theta$ (deg)"

    def section(panel):
        for orbit in orbits:
            dots(panel, *orbit.states, orbit)
        strobe = longest.strobe
        at = f", $\\theta$ = {strobe:g} deg" if strobe else ""
        panel.reads("x", f"stroboscopic $q$ ({machine.unit}){at}", machine.per_m)
        panel.reads("y", rf"stroboscopic $q_\theta$ ({machine.unit}/rad)", machine.per_m)

    return {
        "motion": motion, "orbit": loop, "plane": plane, "section": section,
        **dict.fromkeys(("lift", "velocity", "acceleration"), on_the_cam),
    }  # fmt: skip


@pytest.mark.parametrize("name", some_in_ci(ORBITS, quick=["chapter"]))
def test_every_panel_of_the_orbits_of_one_speed_shows_their_rows(name):
    own = single_checks(name)
    assert check(made("orbits", name), own) == {*own}


def test_the_page_of_the_orbits_of_one_speed_lists_them():
    page, table = read_page(made("orbits", "chapter")), made("orbits", "chapter").tables["branch"]
    assert usual(made("orbits", "chapter")) == ["motion", "orbit", "plane"]
    page.says("Periodic orbits at 700 rpm", f"{len(table['label'])} orbits found at 700 rpm")
    for k, colour in enumerate(shades(table["label"])):
        stable = table["stable"][k] == 1
        row = page.row(
            table["label"][k], "stable" if stable else "unstable", f"{table['theta_deg_1'][k]:.2f}"
        )
        assert hexed(row[0].get_markeredgecolor()) == colour
        assert hexed(row[0].get_markerfacecolor()) == (colour if stable else COLOURS["white"])


def proved_study(result, ranges=(), orbits=()):
    """A study with proofs that are made up: an orbit without one has failed."""
    failed = Proof(step=ProofStep.NO_ORBIT)
    first = [*orbits, *[failed] * (len(result.values.orbits) - len(orbits))]
    proofs = Proofs(orbits=first, points=[], events=[], ranges=list(ranges))
    return replace(result.values, proofs=proofs)


def test_a_band_lies_along_the_parts_of_a_branch_that_are_proved():
    result = made("branches", "chapter")
    table = result.tables["branch"]
    of_first = table["branch"] == 1
    rpm, stable = table["rpm"][of_first], table["stable"][of_first] == 1
    theta = table["theta_deg_1"][of_first]
    low, high = rpm[stable].min(), rpm[stable].max()
    ranges = [
        Range(1, "P(1;1)", True, f"[{float(low)!r} +/- 1e-20]", repr(float(high)), 5),
        Range(1, "P(1;1)", False, repr(float(high)), "756.0", 5, ProofStep.GRAZES),
    ]
    figure = draw_orbits(proved_study(result, ranges), result.system).figure()
    heading, phases, positions = figure.axes[:3]
    assert [text.get_text() for text in heading.texts].count("proved without a gap") == 1
    for axes, values in ((phases, theta), (positions, table["q_m"][of_first])):
        (band,) = [line for line in axes.lines if hexed(line.get_color()) == "#FFE600"]
        x, y = band.get_data()
        assert (min(x), max(x)) == (low, high)
        own = (rpm >= low) & (rpm <= high)
        order = slice(None) if x[0] == rpm[own][0] else slice(None, None, -1)
        assert x == pytest.approx(rpm[own][order])
        assert y == pytest.approx(values[own][order])
        over = [line for line in axes.lines if hexed(line.get_color()) == COLOURS["period 1"]]
        assert over
        assert all(line.get_zorder() > band.get_zorder() for line in over)
        assert all(line.get_linewidth() < band.get_linewidth() for line in over)
    plain = draw_orbits(proved_study(result, ranges[1:]), result.system).figure()
    assert "proved without a gap" not in [text.get_text() for text in plain.axes[0].texts]


def test_a_range_does_not_say_which_way_of_a_branch_that_turns_round_is_proved():
    def steps(values, low, high, stable=False):
        mu = 0.5 if stable else 2.0
        points = [
            SimpleNamespace(value=value, stable=stable, multipliers=(mu, 0.1)) for value in values
        ]
        return proved_steps(points, [Range(1, "P(1;1)", stable, repr(low), repr(high))])

    assert steps([1.0, 2.0, 3.0, 4.0], 2.0, 4.0) == [False, True, True]
    assert steps([4.0, 3.0, 2.0], 2.0, 4.0) == [True, True]
    assert steps([1.0, 2.0, 3.0, 2.0, 1.0], 1.0, 2.0) == [False] * 4
    assert steps([1.0, 2.0, 3.0, 2.0], 1.0, 2.0) == [True, False, False]
    # unstable before it turns round, and again from a doubling on, at 2.5
    values = [4.0, 3.0, 2.0, 1.0, 2.0, 2.5, 3.0, 4.0]
    points = [
        SimpleNamespace(value=x, stable=k == 4, multipliers=(0.1 if k == 4 else 1.5, 0.1))
        for k, x in enumerate(values)
    ]
    of_both = [
        Range(1, "P(1;1)", False, "1.0", "4.0"),
        Range(1, "P(1;1)", False, "2.5", "4.0", 0, ProofStep.GRAZES),
    ]
    assert proved_steps(points, of_both) == [True] * 3 + [False] * 4
    # at a corner two points have one value, but for rounding: no turn
    assert steps([1.0, 2.0, 2.0 - 1e-15, 3.0], 1.0, 3.0) == [True, True, True]


ELLIPSES = ((-0.0005, 0.007, -0.015, 0.0), (0.001, 0.002, 0.003, -0.004))


@pytest.mark.parametrize("count", [1, 2])
def test_the_ellipses_from_which_motions_tend_to_an_orbit_are_drawn_in_deg_and_m_per_s(count):
    result = made("branches", "chapter")
    first = result.values.orbits[0]
    study = proved_study(result, orbits=[Proof(axes=ELLIPSES[:count])])
    picture = draw_orbits(study, result.system)
    figure = picture.figure(result.scene.plot.model_copy(update={"panels": ("attraction",)}))
    (axes,) = figure.axes[1:]
    omega = first.rpm * np.pi / 30.0
    assert len(axes.patches) == count
    for patch, (a, b, c, d) in zip(axes.patches, ELLIPSES, strict=False):
        phase, rate = np.asarray(patch.get_xy()).T
        share = np.linalg.solve([[a, b], [c, d]], [np.radians(phase), rate / omega])
        assert np.hypot(*share) == pytest.approx(1.0)
        assert np.ptp(phase) == pytest.approx(2.0 * np.degrees(np.hypot(a, b)), rel=1e-3)
    assert [text.get_text() for text in axes.texts] == ([] if count == 1 else ["1", "2"])
    said = f"{first.rpm:g} rpm, impact at {np.degrees(first.theta[0]):.2f} deg"
    assert axes.get_title(loc="right") == said
    assert axes.get_xlabel() == r"$\theta$ less the impact's (deg)"
    assert axes.get_ylabel() == "rebound velocity\nless the impact's (m/s)"
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend == [f"impacts from which every motion tends to {first.label}: proved"]


@pytest.mark.ci
@pytest.mark.parametrize("end", [0, 1])
def test_a_branch_that_is_lost_is_marked_and_named_at_that_end(end):
    """No branch of the scenes here is lost, so an end is said to be."""
    result = made("branches", "valve")
    (branch,) = result.values.branches
    ends = ["end-of-range", "end-of-range"]
    ends[end] = "lost"
    study = replace(result.values, branches=[replace(branch, ends=tuple(ends))])
    heading, phases, positions = draw_orbits(study, result.system).figure().axes[:3]
    table, row = result.tables["branch"], -end  # the first or the last one
    rpm, thetas = table["rpm"][row], [table[f"theta_deg_{k}"][row] for k in (1, 2)]
    for axes, values in ((phases, thetas), (positions, [table["q_m"][row]])):
        panel = Panel("lost", axes)
        (marks,) = panel.pick(Line2D, lambda a: a.get_marker() == "X", 1)
        assert list(marks.get_xdata()) == pytest.approx([rpm] * len(values))
        assert sorted(marks.get_ydata()) == pytest.approx(sorted(values))
        assert hexed(marks.get_markerfacecolor()) == COLOURS["trouble"]
    assert any(f"lost at {rpm:g} rpm" in text.get_text() for text in heading.texts)


def landing(left, right, mu):
    """Where x' = tau x + y + mu, y' = -delta x ends: a fixed point L or R, nothing, or elsewhere.

    The normal form of a border collision (M. di Bernardo, C. J. Budd, A. R. Champneys and P.
    Kowalczyk, Piecewise-smooth Dynamical Systems, 2008): left for x < 0, right for x > 0, each
    (tau, delta); followed from points near the border.
    """
    ends = set()
    for angle in np.linspace(0.1, 6.1, 13):
        x, y = 0.3 * np.cos(angle), 0.3 * np.sin(angle)
        for _ in range(4000):
            before = x
            tau, delta = left if x < 0.0 else right
            x, y = tau * x + y + mu, -delta * x
            if abs(x) > 1e6:
                break
        if abs(x) > 1e6:
            continue
        settled = abs(x - before) < 1e-9 * max(1.0, abs(x))
        ends.add(f"the fixed point {'LR'[int(x > 0.0)]} attracts" if settled else "elsewhere")
    return ends or {"nothing bounded attracts"}


def test_the_words_of_a_corner_impact_are_what_its_normal_form_does():
    result = made("branches", "chapter")
    table, told = result.tables["bifurcations"], 0
    for k, event in enumerate(result.summary["bifurcations"]):
        if event["kind"] != "corner-impact":
            continue
        left, right = ((table[f"trace_{s}"][k], table[f"det_{s}"][k]) for s in ("left", "right"))
        for where, mu in (("the normal form's parameter is below 0", -1.0), ("it is above 0", 1.0)):
            found = [w for w in event["words"] if w.startswith(f"Where {where}, ")]
            ends = landing(left, right, mu)
            if ends == {"elsewhere"}:
                assert "a chaotic attractor" in found[0]
            else:
                assert ends == {found[0].partition(", ")[2].removesuffix(".")}
            told += 1
            for words in found[1:]:  # of the cycle LR
                product = np.array([[left[0], 1.0], [-left[1], 0.0]]) @ np.array(
                    [[right[0], 1.0], [-right[1], 0.0]]
                )
                largest = max(np.linalg.eigvals(product), key=abs)
                assert float(words.rpartition(" ")[2].removesuffix(".")) == pytest.approx(
                    largest, rel=1e-5
                )
                assert ("is stable" in words) == (abs(largest) < 1.0)
    assert told == 6


def test_lines_between_rows_are_curved_wherever_an_enlarged_part_shows_them():
    """Coarse rows of P(1;1): between those that it shows the closed form is met, and no others."""
    branches = made("branches", "chapter").values.branches
    own = max(
        (branch for branch in branches if set(branch.labels) == {"P(1;1)"}),
        key=lambda branch: len(branch.points),
    )
    points = own.points[::4]
    values = [point.value for point in points]
    low, high = sorted(0.7 * values[k] + 0.3 * values[k + 1] for k in (1, len(values) - 4))
    found = curved(points, low, high)
    between = [point for point in found if point.value not in values]
    gaps = [(min(a, b), max(a, b)) for a, b in pairwise(values)]
    shown = [(a, b) for a, b in gaps if a <= high and b >= low]
    assert 3 <= len(shown) < len(gaps)
    for a, b in gaps:
        inside = [point for point in between if a < point.value < b]
        assert (len(inside) > 5) == ((a, b) in shown)
    rpm, theta = zip(*((p.value, np.degrees(p.theta[0])) for p in between), strict=True)
    assert away_from_closed_form(np.array(rpm), np.array(theta)).max() < 3e-3
