"""The colours of explore.html: how far apart they are, and how they show on its paper."""

import re
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

import camcli
from camcli.api.explore_page import COLOURS
from tests.output.test_figure_style import EVERY_SIGHT, luminance, seen

STYLE = (Path(camcli.__file__).parent / "output/explore_page/style.css").read_text("utf-8")
MOTIONS = (
    "period1",
    "period2",
    "period3",
    "period4",
    "longer",
    "rests",
    "contact",
    "aperiodic",
    "undecided",
)
AREAS = tuple(f"area-{name}" for name in MOTIONS)
KINDS = ("flight", "sticking", "impact", "chatter", "detachment", "trouble")
FORCES = ("cam", "force", "inertia")


def colours_of(text):
    found = dict(re.findall(r"--([a-z-]+\d?): (#[0-9a-fA-F]{3,6}|var\(--[a-z]+\));", text))
    return {name: "#" + 2 * value[1:] if len(value) == 4 and value[1] == value[2] == value[3]
            else value for name, value in found.items()}  # fmt: skip


LIGHT = {**COLOURS, **colours_of(STYLE.partition("@media")[0])}
DARK = {**LIGHT, **colours_of(STYLE.partition(":root:not(.printing) {")[2].partition("}")[0])}
LIGHT["rests"] = LIGHT["sticking"]
SCHEMES = {"light": LIGHT, "dark": DARK}


def contrast(one, other):
    dark, light = sorted((luminance(one) + 0.05, luminance(other) + 0.05))
    return light / dark


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("sight", EVERY_SIGHT)
@pytest.mark.parametrize("names", [MOTIONS, AREAS, KINDS, FORCES])
def test_what_means_something_else_looks_different_to_everybody(scheme, names, sight):
    colours = SCHEMES[scheme]
    for one, other in combinations(names, 2):
        apart = np.linalg.norm(seen(colours[one], sight) - seen(colours[other], sight))
        assert apart > 20, (one, other)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_words_and_marks_show_on_their_paper(scheme):
    colours = SCHEMES[scheme]
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    for word, ground in product(("ink", "faint", "accent"), ("paper", "page", "shade")):
        assert contrast(colours[word], colours[ground]) > 4.5, (word, ground)
    assert contrast(colours["paper"], colours["accent"]) > 4.5  # on a pressed button
    for metal in ("steel", "shine"):  # of the cam, with the letters of its corners on it
        assert contrast(colours["ink"], colours[metal]) > 4.5, metal
        assert contrast(colours["steel-edge"], colours[metal]) > 3.0, metal
    for mark in (*MOTIONS, *KINDS, *FORCES, "guide"):  # guide: axes, and the edges of buttons
        assert contrast(colours[mark], colours["paper"]) > 3.0, mark
