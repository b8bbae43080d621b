"""The picture of periodic orbits: every kind of study, and the lines that matter."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curves import Curve, CurvePoint
from camcli.analysis.orbits.shooter import PLACES
from camcli.analysis.orbits.study import Absence, OrbitsQuestion, OrbitsResult, orbits
from camcli.plots.branch_lines import phases, strands
from camcli.plots.orbits import MOST_LISTED, axis_name, draw_curves, draw_orbits
from tests.conftest import settings
from tests.support.picture_sizes import tall, words

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[2] / "configs"
QUESTIONS = {
    "doubling": OrbitsQuestion(700.0, span=Span(672.0, 756.0, 2.8)),
    "fold": OrbitsQuestion(358.5, span=Span(350.0, 385.0, 0.6)),
    "resting": OrbitsQuestion(190.0, span=Span(110.0, 205.0, 5.0)),
    "one speed": OrbitsQuestion(358.5),
}


@pytest.fixture(scope="module")
def found(chapter):
    return {name: orbits(chapter, settings(600), ask) for name, ask in QUESTIONS.items()}


def test_where_an_absent_label_exists_is_said(chapter, found):
    for span in (None, Span(600.0, 700.0, 1.0)):
        nothing = OrbitsResult(OrbitsQuestion(700.0, span=span), 700.0, [], [], [], [], [], Cost())
        assert "no periodic orbit was found" in words(draw_orbits(nothing, chapter))
    near = Absence(700.0, 650.0, 750.0, None, (712.3, "corner-impact"))
    absent = replace(nothing, question=OrbitsQuestion(700.0, label="P(4;1)"), absent=near)
    said = "no P(4;1) here; the nearest is at 712.3 rpm: corner impact"
    assert said in words(draw_orbits(absent, chapter))
    assert (
        "none at 700 rpm" in draw_orbits(replace(found["doubling"], absent=near), chapter).caption
    )


NAMES = {
    "rpm": ("cam speed", "rpm"),
    "mass": ("mass $m$", "kg"),
    "stiffness": ("stiffness $k$", "N/m"),
    "damping": ("damping $b$", "N s/m"),
    "gravity": ("gravity $g$", "m/s²"),
    "preload": ("preload $F_0$", "N"),
    "restitution": ("coefficient of restitution $r$", "-"),
    "seat_restitution": ("restitution on the seat", "-"),
}


def test_every_parameter_has_a_name_and_a_unit(chapter, found):
    for parameter in PLACES:
        ask = replace(QUESTIONS["doubling"], parameter=parameter)
        title = draw_orbits(replace(found["doubling"], question=ask), chapter).title
        name, unit = NAMES[parameter]
        assert axis_name(parameter) == f"{name} ({unit})"
        assert name.split(" $")[0] in title or parameter == "rpm"


# --- lines along a branch


def test_lines_break_where_a_departure_appears_and_where_a_phase_wraps(found):
    lines = strands(found["resting"].branches[0].points, phases, 360.0)
    assert len(lines) == 2
    points = found["doubling"].branches[0].points[:60]
    wrapped = strands(points, lambda orbit: [(orbit.value * 15.0) % 360.0], 360.0)
    assert len(wrapped) > 1
    assert max(abs(np.diff(line.y)).max() for line in wrapped) < 180.0


# --- events


@pytest.mark.parametrize(
    ("name", "zooms"), [("doubling", ["event 3"]), ("fold", ["event 10"]), ("resting", [])]
)
def test_only_a_hidden_corner_impact_is_enlarged(chapter, found, name, zooms):
    panels = draw_orbits(found[name], chapter).panels
    assert [name for name in panels if name.startswith("event")][:1] == zooms


@pytest.mark.ci
def test_many_branches_and_events_keep_to_the_page(chapter, found):
    result, last = found["fold"], found["fold"].branches[-1]
    last = replace(last, points=last.points[::20], ends=("lost", "lost"))
    branches = [replace(last, number=n) for n in range(1, 41)]
    more = [replace(b, value=b.value + 1e-3 * k) for k in range(4) for b in result.bifurcations]
    picture = draw_orbits(replace(result, branches=branches, bifurcations=more), chapter)
    assert tall(picture) > 200
    assert f"and {40 - MOST_LISTED} more, in the tables" in words(picture)


def test_curves_of_one_colour_differ_in_their_dashes(found):
    orbit = found["one speed"].orbits[0]
    points = tuple(CurvePoint(700.0 + k, 0.1 * k, orbit) for k in range(3))
    ends = "end-of-range", "end-of-range"
    curve = Curve("fold", "P(1;1)", "", "rpm", "restitution", points, ends)
    none = draw_curves([], ("follower.mass", "restitution"))
    assert "no bifurcation of this kind was located" in words(none)
    assert none.figure().axes[1].get_xlabel() == "mass $m$ (kg)"
    early = replace(curve, ends=("end-of-range", "an impact reaches a corner"))
    picture = draw_curves([curve] * 4 + [early], ("rpm", "restitution"))
    looks = {(line.get_color(), line.get_linestyle()) for line in picture.figure().axes[1].lines}
    assert len(looks) >= 5
    assert any("ends: an impact reaches a corner" in text for text in words(picture))


def test_a_motion_at_rest_at_the_strobe_is_shown_within_the_lift():
    """q = 0 and no velocity: no range of its own, nor one of a metre for 10 mm of lift."""
    values = {"orbits.at": 3300.0, "orbits.starts": 0, "orbits.rpm.num": 1}
    values |= {f"orbits.rpm.{end}": 3300.0 for end in ("start", "stop")}
    result = camcli.orbits(camcli.load_scene(CONFIGS / "valve-train.yaml", values))
    axes = camcli.plot(result, panels=["section"]).axes[1]
    assert axes.get_xlim() == axes.get_ylim() == pytest.approx((-0.01, 0.01), rel=1e-4)
    assert axes.get_xlabel() == "stroboscopic $q$ (mm)"


def test_positions_that_never_differ_and_multipliers_of_zero_are_told_and_not_drawn():
    values = {"orbits.rpm": {"start": 3300, "stop": 3500, "num": 3}, "orbits.starts": 0}
    scene = camcli.load_scene(CONFIGS / "valve-train.yaml", values)
    picture = camcli.orbits(scene).pictures["orbits"]()
    assert [*picture.chosen(None)][:1] == ["phases"]
    assert not {"positions", "plane", "multipliers"} & set(picture.chosen(None))
    assert "always the same, and is not drawn; both multipliers" in picture.caption
    assert set(picture.chosen(["plane", "positions"])) == {"plane", "positions"}


def test_eight_curves_of_bifurcations_are_told_apart_in_print_without_colours():
    """By dashes and width, whichever orbits they are of."""
    points = [SimpleNamespace(first=700.0, second=0.8), SimpleNamespace(first=701.0, second=0.7)]
    ends = ("end-of-range", "end-of-range")
    curves = [
        SimpleNamespace(
            first="rpm",
            label="P(1;1)",
            kind="fold",
            corner="",
            points=points,
            ends=ends,
            line=SimpleNamespace(first=[700.0, 701.0], second=[0.8, 0.7]),
        )
        for _ in range(8)
    ]
    axes = draw_curves(curves, ("rpm", "restitution")).figure().axes[1]
    looks = {f"{line._dash_pattern} {line.get_linewidth()}"
             for line in axes.lines}  # fmt: skip
    assert len(looks) == 8
