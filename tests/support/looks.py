"""The looks of what pictures draw: strokes, marks, layers, letters, and the heights of panels.

`tests/truth/looks.toml` has every look that may stand in a panel, by the panel's name. Numbers and
colours are held against the tables by the checks of the panels; how thick a stroke is, what lies
over what, and how far a word stands from its point is chosen, and the sheet keeps what was chosen.
Whoever changes a look changes its row: `CAMCLI_LOOKS=1 pytest -n 0 tests/truth -k pictures` adds
the new rows, those that are no longer drawn go by hand.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from matplotlib.artist import Artist
from matplotlib.collections import Collection
from matplotlib.colors import to_hex
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Annotation, Text

MEANINGS = {  # colours that say what a thing is; those of motions and all shades are not told apart
    "#0072B2": "flight", "#E69F00": "sticking", "#8E3E11": "slowing", "#B76995": "chatter",
    "#07A974": "detachment", "#CC5E0F": "trouble", "#4D4D4D": "cam", "#9A9A9A": "guide",
    "#A9A9A9": "simulated", "#000000": "black", "#FFFFFF": "white",
}  # fmt: skip
SHEET = Path(__file__).parents[1] / "truth" / "looks.toml"


def look_of(artist: Artist) -> str:
    """The look of one artist in a line: what does not hang on the data."""
    look = f"{_kind(artist)}{_colour(artist)}, layer {artist.get_zorder():g}{_alpha(artist)}"
    return look + _seam(artist)


def look_of_name(text: Text, what: str) -> str:
    """The look of the name of an axis, or of a title: its letters, and how far away it stands."""
    return f"{what} of {text.get_fontsize():g}{_letters(text)}{_seam(text)}"


def look_of_axes(axes: Any) -> list[str]:
    """What is unusual about a panel's axes and its own legend."""
    looks = [
        f"axis {way}: {axis.get_scale()}"
        for way, axis in (("x", axes.xaxis), ("y", axes.yaxis))
        if axis.get_scale() != "linear"
    ]
    if axes.get_aspect() != "auto":
        looks.append(f"as wide as high times {axes.get_aspect():g}")
    if not axes.axison:
        looks.append("without a frame")
    for way, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        ticks = axis.get_tick_params()
        said = [f"{name} {ticks[name]:g}" for name in ("length", "labelsize") if name in ticks]
        if said:
            looks.append(f"ticks along {way}: {', '.join(said)}")
    looks += [f"second axis {one._orientation} at {one._pos:g}" for one in axes.child_axes]
    legend = axes.get_legend()
    if legend is not None:
        letters = {text.get_fontsize() for text in legend.get_texts()}
        looks.append(f"legend of {sorted(letters)} in {legend._ncols}, place {legend._loc}")
    return looks


def _kind(artist: Any) -> str:
    if isinstance(artist, Line2D):
        strokes = _stroke(artist)
        if artist.get_marker() in ("None", "none", "", " ", None):
            return strokes
        mark = f"mark {artist.get_marker()} of {artist.get_markersize():g}"
        return f"{strokes}, {mark} with an edge of {artist.get_markeredgewidth():g}"
    if isinstance(artist, Text):
        place = f"{artist.get_horizontalalignment()} {artist.get_verticalalignment()}"
        words = f"text of {artist.get_fontsize():g}, {place}, turned by {artist.get_rotation():g}"
        if isinstance(artist, Annotation) and artist.anncoords == "offset points":
            words += ", off by {:g}, {:g}".format(*artist.xyann)
        if isinstance(artist, Annotation) and artist.arrow_patch is not None:
            words += _arrow(artist.arrow_patch)
        return words + _letters(artist) + _place(artist)
    if isinstance(artist, AxesImage):
        return f"image, {artist.get_interpolation()}"
    if isinstance(artist, Patch):
        return f"area with an edge of {artist.get_linewidth():g}"
    if isinstance(artist, Collection):
        widths = sorted({float(width) for width in artist.get_linewidths()})
        return f"{type(artist).__name__} with edges of {widths}"
    return type(artist).__name__


def _arrow(arrow: Any) -> str:
    """Width and head of an arrow, and how far its ends are from its places, pt."""
    words = f", arrow of {arrow.get_linewidth():g}"
    style = arrow.get_arrowstyle()
    if style.arrow != "-":
        words += f" {style.arrow} {style.head_length:g} by {style.head_width:g}"
    return words + f", away {arrow.shrinkA:g} {arrow.shrinkB:g}"


def _letters(text: Text) -> str:
    """What is unusual about letters: thick ones, on a ground of their own, their lines apart."""
    words = ""
    if text.get_fontweight() != "normal":
        words += f", {text.get_fontweight()}"
    if text.get_bbox_patch() is not None:
        words += f", on a ground {text.get_bbox_patch().get_boxstyle().pad:.3g} wider"
    if text._linespacing not in (1.2, "normal"):
        words += f", lines {text._linespacing:g} apart"
    return words


def _place(text: Text) -> str:
    """Where words stand in their panel if that does not hang on the data: shares of its sides."""
    axes, way = text.axes, text.get_transform()
    if axes is None or isinstance(text, Annotation):
        return ""
    x, y = text.get_position()
    if way == axes.transAxes:
        return f", at {x:.3g} {y:.3g} of the panel"
    if way == axes.get_xaxis_transform():
        return f", at height {y:.3g} of the panel"
    return f", at width {x:.3g} of the panel" if way == axes.get_yaxis_transform() else ""


def _seam(artist: Artist) -> str:
    """What is drawn around an artist: its width and colour."""
    seams = [vars(effect).get("_gc", {}) for effect in artist.get_path_effects() or []]
    return "".join(
        f", seam of {gc['linewidth']:g} {MEANINGS.get(to_hex(gc['foreground']).upper(), 'a shade')}"
        for gc in seams
        if "linewidth" in gc
    )


def _stroke(line: Any) -> str:
    """Width and strokes of a line."""
    if line.get_linestyle() in ("None", "none", "", " "):
        return "no line"
    _, pattern = line._unscaled_dash_pattern
    strokes = "solid" if not pattern else "strokes {}".format(" ".join(f"{x:g}" for x in pattern))
    return f"line of {line.get_linewidth():g}, {strokes}"


def _colour(artist: Any) -> str:
    """What the colour of a line or of words means."""
    if not isinstance(artist, Line2D | Text):
        return ""
    return f", {MEANINGS.get(to_hex(artist.get_color()).upper(), 'a shade')}"


def _alpha(artist: Artist) -> str:
    alpha = artist.get_alpha()
    return "" if alpha is None else f", alpha {alpha:g}"


@cache
def _sheet() -> dict[str, list[str]]:
    if not SHEET.exists():
        return {}
    return tomllib.loads(SHEET.read_text(encoding="utf-8"))


def hold_to_the_sheet(panel: str, looks: Iterable[str]) -> None:
    """Every look of a panel stands on the sheet, among those of its name."""
    sheet = _sheet()
    known = sheet.setdefault(panel, [])
    new = sorted({*looks} - {*known})
    if new and "CAMCLI_LOOKS" in os.environ:
        known.extend(new)
        SHEET.write_text(_written(sheet), encoding="utf-8")
        return
    assert not new, f"{panel}: not on the sheet tests/truth/looks.toml: {new}"


def _written(sheet: dict[str, list[str]]) -> str:
    parts = ["# Looks in pictures, by panel; see tests/support/looks.py.\n"]
    for panel in sorted(sheet):
        rows = "".join(f'  "{look}",\n' for look in sorted(sheet[panel]))
        parts.append(f'"{panel}" = [\n{rows}]\n')
    return "\n".join(parts)
