"""The machine as it is drawn, measured with a ruler in largest radii of the cam.

`machine.toml` has every artist of each drawing of the chapter's machine: where words stand, from
where to where arrows lead, and what each line and area covers. Who changes a drawing on purpose
writes it anew (`CAMCLI_LOOKS=1 pytest -n 0 tests/output/test_machine_drawn.py`) and looks at it.
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from matplotlib.text import Annotation, Text

import camcli
from camcli.cams.compile import phase_of
from camcli.plots import mechanism
from camcli.plots.mechanism import Outline
from camcli.scene import load_scene
from camcli.scene.schema import Plot
from camcli.system import Follower, System

SHEET = Path(__file__).parent / "machine.toml"
SCENE = load_scene(None)
SYSTEM = System.build(Follower(**SCENE.follower.model_dump()), SCENE.cam, phase_of(0.0))
OUTLINE = Outline.of_lift(SYSTEM, None, SCENE.cam)
SIZE = float(OUTLINE.radius.max())
FLYING = 0.4 * (SIZE - float(OUTLINE.radius.min()))
MOMENTS = {"at rest": (0.0, 0.0), "in flight": (200.0, FLYING)}
DRAWINGS = {  # width of the panel in mm, and what is drawn
    "outline": (80.0, lambda axes: mechanism._draw_outline(axes, OUTLINE, 30.0, "")),
    "narrow outline": (29.0, lambda axes: mechanism._draw_outline(axes, OUTLINE, 0.0, "")),
    "outline among others": (40.0, lambda axes: mechanism._draw_outline(axes, OUTLINE, 0.0, "B")),
    "geometry": (80.0, lambda axes: mechanism._draw_geometry(axes, OUTLINE)),
    "moments": (111.0, lambda axes: mechanism._draw_mechanism(axes, OUTLINE, MOMENTS)),
    "narrow moments": (109.0, lambda axes: mechanism._draw_mechanism(axes, OUTLINE, MOMENTS)),
    "a film": (100.0, lambda axes: mechanism.draw_machine(axes, OUTLINE, FLYING, 90.0, SIZE)),
}


def drawn(name):
    wide, draw = DRAWINGS[name]
    figure = Figure(figsize=(wide / 20.32, 74.0 / 20.32), dpi=300)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    draw(axes)
    return axes


def measured(*lengths):
    return " ".join(f"{round(float(x) / SIZE, 2) + 0.0:g}" for x in lengths)


def one_line(text):
    return text.replace("\n", " / ")


def row_of(artist):
    """What an artist is, and where."""
    if isinstance(artist, Annotation) and not artist.get_text():
        return f"arrow {measured(*artist.xyann, *artist.xy)}"
    if isinstance(artist, Text):
        words = one_line(artist.get_text())
        return f"{words} at {measured(*artist.get_position())}" if words else None
    if isinstance(artist, Line2D):
        x, y = np.array(artist.get_data(), dtype=float)
        seen = np.isfinite(x)
        if not seen.any():
            return None
        ends = x[seen].min(), x[seen].max(), y[seen].min(), y[seen].max()
        return f"line of {seen.sum()}: {measured(*ends)}"
    if isinstance(artist, Circle):
        return f"circle {measured(*artist.center, artist.radius)}"
    if isinstance(artist, Polygon):
        x, y = artist.get_xy().T
        return f"area {measured(x.min(), x.max(), y.min(), y.max())}"
    return None


def rows_of(axes):
    frame = {axes.patch, axes.xaxis, axes.yaxis, *axes.spines.values()}
    frame |= {axes.title, axes._left_title, axes._right_title}
    rows = [row_of(artist) for artist in axes.get_children() if artist not in frame]
    limits = f"shown {measured(*axes.get_xlim(), *axes.get_ylim())}"
    titles = [axes.get_title(loc=place) for place in ("left", "center", "right")]
    return [*filter(None, rows), limits, *(f"title {one_line(title)}" for title in titles if title)]


def written(sheet):
    parts = ["# The machine drawn, in largest radii; see tests/output/test_machine_drawn.py.\n"]
    for name in DRAWINGS:
        rows = "".join(f"  '{row}',\n" for row in sheet.get(name, []))
        parts.append(f'"{name}" = [\n{rows}]\n')
    return "\n".join(parts)


@pytest.mark.parametrize("name", DRAWINGS)
def test_every_artist_of_a_drawing_is_where_it_was_put(name):
    found = rows_of(drawn(name))
    sheet = tomllib.loads(SHEET.read_text(encoding="utf-8")) if SHEET.exists() else {}
    if "CAMCLI_LOOKS" in os.environ:
        sheet[name] = found
        SHEET.write_text(written(sheet), encoding="utf-8")
    assert found == sheet[name]


def test_heights_of_cam_and_follower_are_named_outside_their_arrows():
    """c(t) at the left of its arrow, q(t) at the right of its own: no arrow crosses a name."""
    result = camcli.simulate(camcli.load_scene(None), profile_only=True)
    figure = result.pictures["profile"]().figure(Plot(panels=["mechanism"]))
    figure.draw_without_rendering()
    named = {"$c(t)$": [], "$q(t)$": []}
    for axes in figure.axes:
        for text in axes.texts:
            if text.get_text() in named:
                box, (x, _) = text.get_window_extent(), text.get_position()
                anchor = axes.transData.transform((x, 0.0))[0]
                named[text.get_text()].append((box.x0 - anchor, box.x1 - anchor))
    assert len(named["$c(t)$"]) == len(named["$q(t)$"]) > 0
    assert all(left < right <= 1.0 for left, right in named["$c(t)$"])
    assert all(-1.0 <= left < right for left, right in named["$q(t)$"])


def test_the_last_arc_ends_at_the_first_corner_beyond_the_turn():
    arcs = mechanism._arcs(replace(OUTLINE, corners={"a": 10.0, "b": 100.0, "c": 300.0}))
    assert arcs == [(10.0, 100.0), (100.0, 300.0), (300.0, 370.0)]
