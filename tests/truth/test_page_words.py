"""All words of a page with pictures, against a sheet, and rules that hold for every page.

The sheet `tests/truth/pages.toml` has every text of a page but the numbers at ticks: heading,
lists, legend, then panel by panel the names of its axes, its title, and what is written into it.
Digits are 0, as on the sheet of screens; what the numbers are is held elsewhere.
`CAMCLI_LOOKS=1 CAMCLI_NO_SKIPS=1 pytest -n 0 tests/truth/test_page_words.py` writes it anew.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

import camcli
from camcli.scene.schema import Plot
from tests.support.picture_sizes import check_texts
from tests.truth.test_screen_words import line_in_shape

SHEET = Path(__file__).parent / "pages.toml"
CONFIGS = Path(__file__).parents[2] / "configs"
TURNS = {"run.transient": 20, "run.record": 10, "run.patience": 0}
FACE = {"face": "roller", "follower_radius": 0.01, "base_radius": 0.018}
MASS, RATE = {"key": "follower.mass", "percent": 5}, {"key": "follower.stiffness", "percent": 3}
LOSS = {"key": "follower.restitution", "start": 0.7, "stop": 0.8, "num": 2}
LAW = {"kind": "law", "base": 0.1, "lift": 0.3, "top_dwell_deg": 40,
       "rise": {"start_deg": 90, "length_deg": 70, "law": "harmonic"},
       "fall": {"length_deg": 70, "law": "harmonic"}}  # fmt: skip


def span(low: float, high: float, num: int, **more: Any) -> dict[str, Any]:
    return {"start": low, "stop": high, "num": num, **more}


PAGES: dict[str, tuple[str, str | None, dict[str, Any]]] = {  # command, scene, values
    "simulate": ("simulate", None, {"run.rpm": 190.0}),
    "simulate a lash": ("simulate", "valve-lash", {}),
    "simulate a stop": ("simulate", "eccentric", {}),
    "a cam": ("simulate", "valve-train", {"contact": FACE, "simulate.profile_only": True}),
    "cams": ("simulate", None, {"simulate.profile_only": True, "simulate.beside": [LAW]}),
    "a measured cam": ("simulate", "lift-table", {"simulate.profile_only": True}),
    "sweep": ("sweep", None, {"sweep.rpm": span(690.0, 760.0, 8)}),
    "sweep in contact": ("sweep", None, {"sweep.rpm": span(90.0, 100.0, 3)}),
    "sweep both ways": ("sweep", None, {"sweep.rpm": span(738.0, 742.0, 3),
                                        "sweep.direction": "both", "sweep.lyapunov": True}),
    "sweep a map": ("sweep", None, {"sweep.vary": [span(690.0, 760.0, 2, key="rpm"), LOSS]}),
    "detach": ("detach", "law-smooth", {
        "detach.rpm": span(130.0, 180.0, 3), "detach.hold_to": 180.0, "spring.mass": 0.1,
        "detach.tolerance": [MASS, RATE], "detach.machines": 40}),
    "orbits": ("orbits", None, {"orbits.rpm": span(690.0, 745.0, 5), "orbits.starts": 0}),
    "orbits at one speed": ("orbits", None, {"orbits.rpm": span(700.0, 700.0, 1),
                                             "orbits.starts": 0}),
    "a curve": ("orbits", None, {
        "orbits.rpm": span(735.0, 745.0, 3), "orbits.starts": 0, "orbits.curve": "period-doubling",
        "orbits.curve_range": [0.78, 0.82]}),
    "basins": ("basins", None, {"basins.cells": [8, 8], "basins.saddles": True}),
    "basins over speeds": ("basins", None, {"basins.cells": [4, 4],
                                            "basins.rpm": span(358.0, 359.0, 4)}),
    "classify": ("classify", None, {"classify.rpm": span(690.0, 760.0, 5)}),
}  # fmt: skip
DEAR = ("a measured cam", "orbits", "a curve", "basins", "basins over speeds", "detach")


@cache
def result_of(name: str) -> Any:
    command, scene, values = PAGES[name]
    path = None if scene is None else CONFIGS / f"{scene}.yaml"
    return getattr(camcli, command)(camcli.load_scene(path, {**TURNS, **values}))


@cache
def page_of(name: str) -> Any:
    """The usual page of a result; who changes it takes one of his own."""
    return camcli.plot(result_of(name))


def each_page(test: Callable[..., None]) -> Callable[..., None]:
    names = [pytest.param(name, marks=[pytest.mark.ci] * (name in DEAR)) for name in PAGES]
    return pytest.mark.parametrize("name", names)(test)


def words_of(axes: Any) -> list[str]:
    """The texts of a panel but the numbers of its axes: names, titles, words, legend."""
    legend = axes.get_legend()
    texts = [
        axes.get_xlabel(), axes.get_ylabel(),
        *(axes.get_title(loc=place) for place in ("left", "center", "right")),
        *(text.get_text() for text in axes.texts),
        *(text.get_text() for text in (legend.get_texts() if legend else ())),
    ]  # fmt: skip
    return [line_in_shape(text.replace("\n", " / ")) for text in texts if text]


@each_page
def test_the_words_of_a_page_are_those_of_the_sheet(name):
    figure = page_of(name)
    found = [" | ".join(words_of(axes)) for axes in figure.axes]
    found.append(f"caption: {line_in_shape(figure.caption)}")
    sheet = tomllib.loads(SHEET.read_text(encoding="utf-8")) if SHEET.exists() else {}
    if "CAMCLI_LOOKS" in os.environ:
        sheet[name] = found
        SHEET.write_text(written(sheet), encoding="utf-8")
    assert found == sheet[name]


def written(sheet: dict[str, list[str]]) -> str:
    parts = ["# The words of pages, digits as 0; see tests/truth/test_page_words.py.\n"]
    for name in (name for name in PAGES if name in sheet):
        rows = "".join(
            '  "{}",\n'.format(line.replace("\\", "\\\\").replace('"', '\\"'))
            for line in sheet[name]
        )
        parts.append(f'"{name}" = [\n{rows}]\n')
    return "\n".join(parts)


def shown(texts: list[Text]) -> list[tuple[str, Any]]:
    """Words that are seen, with their boxes in dots."""
    found = [(text.get_text(), text.get_window_extent()) for text in texts if text.get_text()]
    return [(text, box) for text, box in found if box.width > 0.0]


def own_words(axes: Any) -> list[Text]:
    """The names and titles of a panel, and what is written into it and seen there."""
    titles = [axes._left_title, axes.title, axes._right_title]
    inside = [text for text in axes.texts if text.get_visible() and not text.get_clip_on()]
    return [axes.xaxis.label, axes.yaxis.label, *titles, *inside]


@pytest.mark.ci
@pytest.mark.parametrize(
    ("name", "width"),
    [
        *((name, 85.0) for name in PAGES),
        *(
            pytest.param(name, 170.0, marks=pytest.mark.soak)
            for name in ("a cam", "detach", "orbits")
        ),
    ],
)
def test_rules_that_hold_for_every_page(name, width):
    """Nothing leaves the page, no words of a heading or of two panels overlap, letters are read.

    Panels stand below the heading and apart from one another; their letters stand above them, in
    their line; every axis with numbers has two at least; no word is smaller than 6 pt.
    """
    figure = camcli.plot(result_of(name), width=width)
    figure.draw_without_rendering()
    heading, *panels = figure.axes
    page = figure.bbox
    words = shown(heading.texts)
    for text, box in words:
        assert page.x0 - 1 <= box.x0 < box.x1 <= page.x1 + 1, text
        assert page.y0 - 1 <= box.y0 < box.y1 <= page.y1 + 1, text
    for k, (text, box) in enumerate(words):
        for other, beside in words[:k]:
            assert not box.padded(-1.0).overlaps(beside), (text, other)
    sizes = {text.get_fontsize() for axes in figure.axes for text in axes.findobj(Text)
             if text.get_text() and text.get_visible()}  # fmt: skip
    assert min(sizes) >= 6.0
    foot = heading.get_window_extent().y0
    boxes = [axes.get_window_extent() for axes in panels]
    for axes, box in zip(panels, boxes, strict=True):
        assert box.y1 <= foot + 1.0
        numbers = [
            tick.label1
            for axis, along in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim()))
            for tick in axis.get_major_ticks()
            if min(along) <= tick.get_loc() <= max(along) and tick.label1.get_visible()
        ]
        for text, place in shown([*own_words(axes), *numbers]):
            assert page.x0 - 2 <= place.x0 < place.x1 <= page.x1 + 2, text
            assert page.y0 - 2 <= place.y0 < place.y1 <= page.y1 + 2, text
    for one, other in pairwise(sorted(boxes, key=lambda box: (-box.y1, box.x0))):
        assert not one.padded(-1.0).overlaps(other)
    for axes, box in zip(panels, boxes, strict=True):
        letter = axes._left_title
        if letter.get_text():
            place = letter.get_window_extent()
            assert place.y0 >= box.y1 - 1.0
            assert abs(place.x0 - box.x0) <= 0.06 * page.width
        for axis, along in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            low, high = sorted(along)
            inside = [x for x in axis.get_majorticklocs() if low <= x <= high]
            labelled = axis.get_tick_params().get(
                "labelbottom", axis.get_tick_params().get("labelleft")
            )
            assert len(inside) >= 2 or not labelled or not len(axis.get_majorticklocs())
    assert figure.get_figheight() * 25.4 <= 230.0 + 1e-6
    assert figure.get_figwidth() * 25.4 == pytest.approx(width)
    check_texts(figure)


@each_page
def test_no_two_texts_of_a_page_overlap_and_none_leaves_it(name):
    """On a page; in a column of a journal the test above looks."""
    check_texts(page_of(name))


@pytest.mark.ci
@pytest.mark.parametrize("name", PAGES)
def test_no_two_texts_overlap_about_a_panel_that_is_asked_for(name):
    """In a column of a journal, the first four; a plane of equal axes as high as it is wide."""
    form = Plot(width=85.0)
    for draw in result_of(name).pictures.values():
        panels = draw().panels
        asked = [own for own, panel in panels.items() if not panel.usual]
        for own in [*asked[:4], *({"plane"} & {*panels})]:
            check_texts(draw().figure(form.model_copy(update={"panels": (own,)})))


@each_page
def test_limits_hold_the_data_and_legends_name_what_is_drawn(name):
    """Of a line in the data's places at least one point is seen; each entry has a line or mark.

    But for panels that show a part: what is enlarged, and multipliers about the unit circle.
    """
    heading, *panels = page_of(name).axes
    drawn = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            drawn.setdefault(label, handle)
        if "enlarged" in axes.get_ylabel() or r"\mu" in axes.get_ylabel():
            continue
        (left, right), (low, high) = sorted(axes.get_xlim()), sorted(axes.get_ylim())
        for line in axes.lines:
            x, y = (np.asarray(part, dtype=float) for part in line.get_data())
            if line.get_transform() != axes.transData or not np.isfinite(x + y).any():
                continue
            margin = 1e-9 * (right - left), 1e-9 * (high - low)
            seen = (x >= left - margin[0]) & (x <= right + margin[0])
            seen &= (y >= low - margin[1]) & (y <= high + margin[1])
            assert seen.any(), (name, line)
    legend = heading.get_legend()
    named = (
        []
        if legend is None
        else [text.get_text().replace("\n", " ") for text in legend.get_texts()]
    )
    assert {*named} <= {label.replace("\n", " ") for label in drawn}
    assert len({*named}) == len(named)
