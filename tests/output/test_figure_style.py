"""Colours mean one thing in every picture, and are named in one place."""

import re
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from camcli.analysis.contact_loss.force import ForceCurve
from camcli.plots import style
from camcli.plots.axes import draw_forces, newtons
from camcli.plots.basins import area_colours
from camcli.plots.orbit_lines import colours

FOLDER = Path(style.__file__).parent
ROLES = ("FLIGHT", "STICKING", "IMPACT", "CHATTER", "DETACHMENT", "TROUBLE", "MEASURED", "FORCE")
# Machado, Oliveira and Fernandes (2009), severity 1, linear RGB
SIGHTS = {
    "all cones": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "no L cones": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                   [-0.003882, -0.048116, 1.051998]],
    "no M cones": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                   [-0.011820, 0.042940, 0.968881]],
}  # fmt: skip


def seen(colour, sight):
    """CIE Lab coordinates of a colour as somebody sees it."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(np.array(SIGHTS[sight]) @ linear, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    f = np.cbrt(np.maximum(np.array(to_xyz) @ linear / [0.9505, 1.0, 1.089], 1e-9))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def orbit(turns=1, stable=True, resting=False):
    return SimpleNamespace(turns=turns, stable=stable, resting=resting)


def test_colours_are_named_in_one_place_only():
    for path in FOLDER.glob("*.py"):
        if path.name != "style.py":
            text = path.read_text(encoding="utf-8")
            assert (
                re.findall(r"#[0-9A-Fa-f]{6}|\"(?:red|blue|green|orange|purple|gr[ae]y)\"", text)
                == []
            )


def test_no_two_meanings_share_a_colour():
    own = [getattr(style, role) for role in ROLES]
    own += [*style.PERIODS[1:], style.LONGER, style.SADDLE, style.CONTACT, style.UNDECIDED]
    own += [style.RESTING[1], style.APERIODIC_AREA, style.SIMULATED, style.CAM, style.CAM_BODY]
    own += [style.GUIDE, style.BAND, style.DOUBT, style.PULL]
    assert len({colour.upper() for colour in own}) == len(own)


@pytest.mark.parametrize("sight", SIGHTS)
def test_motions_are_told_apart_by_everybody(sight):
    pairs = combinations((*style.SERIES, style.STICKING, style.APERIODIC_AREA), 2)
    away = {pair: np.linalg.norm(seen(pair[0], sight) - seen(pair[1], sight)) for pair in pairs}
    assert min(away.values()) > 10.0, min(away, key=away.get)


def test_an_orbit_has_its_colour_whatever_else_is_drawn():
    node, saddle, doubled = [orbit(), orbit(stable=False)], [orbit(stable=False)], [orbit(2)]
    own = {"node": style.FLIGHT, "saddle": style.SADDLE, "doubled": style.PERIODS[1]}
    assert colours([node]) == [own["node"]]
    assert colours([saddle]) == [own["saddle"]]
    assert colours([doubled, node, saddle]) == [own["doubled"], own["node"], own["saddle"]]
    assert colours([[orbit(resting=True)], node]) == [style.STICKING, style.FLIGHT]


def test_branches_of_one_kind_are_apart_while_there_are_colours():
    many = colours([[orbit()] for _ in range(len(style.SERIES))])
    assert many[0] == style.FLIGHT
    assert sorted(many) == sorted(style.SERIES)
    assert len(colours([[orbit()] for _ in range(20)])) == 20


def test_a_basin_has_the_colour_of_its_motion():
    labels = ["aperiodic", "P(1;2)", "P(3;3:3:2)", "P(2;inf:1)", "contact"]
    rest = [style.PERIODS[2], style.STICKING, style.CONTACT]
    assert area_colours(labels) == [style.APERIODIC_AREA, style.FLIGHT, *rest]
    assert area_colours(labels[::-1]) == area_colours(labels)[::-1]


def curve(force):
    return ForceCurve(100.0, [0.0, 180.0, 360.0], force, min(force), 180.0)


@pytest.mark.parametrize(("force", "shaded"), [([1.0, -2.0, 1.0], True), ([1.0, 0.0, 1.0], False)])
def test_negative_force_is_shaded(force, shaded):
    with style.look():
        figure = style.page(400)
        axes = style.place(figure, 100, 100, 400, 200)
        draw_forces(axes, [curve(force)])
        found = [patch for patch in axes.patches if patch.get_facecolor()[:3] == to_rgb(style.PULL)]
        assert len(found) == shaded
        assert all(patch.get_y() < -1.0 for patch in found)
        assert all(patch.get_y() + patch.get_height() == 0.0 for patch in found)
        assert axes.lines[0].get_color() == style.FORCE
        assert axes.get_ylabel() == "contact force (N)"


def test_forces_for_print():
    assert newtons(-66.4691, 6) == "−66.4691 N"
    assert newtons(-1e-12, 6) == "0 N"
