"""One look for every picture: colours by meaning, sizes for print, places on the page.

Places are pixels of the PNG from the top left corner, not left to a layout engine: the images of
densities must land on the pixel grid, and lists are laid out by the width of their words.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from string import ascii_lowercase
from threading import RLock
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

DPI = 200
WIDTH = 1340  # px: 170 mm, the text width of an A4 page
LEFT, RIGHT, BOTTOM = 140, 60, 95  # px, margins of panels that need no others
WIDE = WIDTH - LEFT - RIGHT
LINE = 30  # px from one line of text to the next
MOST_CORNERS = len(ascii_lowercase)  # a cam with more is drawn without them

# Okabe and Ito's colours, told apart by colour-blind readers, one meaning each in every picture.
FLIGHT = "#0072B2"  # the follower, free
STICKING = "#E69F00"  # the follower, pressed to the cam
IMPACT = "#000000"
CHATTER = "#CC79A7"  # where a chatter accumulates
DETACHMENT = "#009E73"
TROUBLE = "#D55E00"  # a status that is not ok, a warning

CAM = "#4D4D4D"
CAM_BODY = "#EFEFEF"  # and what else lies inside a border: the unit disk
GUIDE = "#9A9A9A"  # corners, turns: lines that help to read
BAND = "#F3EEDF"  # the range shown enlarged in another panel
SIMULATED = "#9DB7C9"  # impacts, behind what is computed
MEASURED, DOUBT = "#882255", "#E2C4D3"  # rows of a table, the bound on their error

# What presses the follower to the cam is of the colour of sticking; below zero, of detachment.
FORCE = "#A66F00"
FORCES = ("#F2C766", STICKING, FORCE, "#5E3F00", IMPACT)  # several in a panel
PULL = "#D9F0E8"

# Motions. An orbit has the colour of its period, paler, darker and paler for colour-blind readers.
PERIODS = (FLIGHT, "#56B4E9", "#332288", "#5F6F7A")
LONGER = "#AA66FF"
SADDLE = "#7A5200"  # an orbit that is nowhere stable
RESTING = (STICKING, "#B87F00")  # an orbit with rest on the cam
CONTACT = "#F7DFA8"  # always in contact
APERIODIC, APERIODIC_AREA = IMPACT, "#F0E442"  # its points; its basin below them
UNDECIDED = "#8C8C8C"
SERIES = (*PERIODS, LONGER, SADDLE)  # things without a meaning of their own

DENSITY = LinearSegmentedColormap.from_list(
    "cam", [(0.0, "#A9D3EE"), (0.33, "#4FA3D6"), (0.6, FLIGHT), (0.82, "#003A5C"), (1.0, "black")]
)

KEPT = ("backend", "backend_fallback", "interactive", "toolbar")  # not of our business
RC = {
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.titlesize": 9,
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "font.family": "DejaVu Sans",
    "font.size": 8,
    "legend.borderaxespad": 0.0,
    "legend.borderpad": 0.0,
    "legend.columnspacing": 1.5,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handleheight": 1.0,
    "legend.handlelength": 1.6,
    "legend.handletextpad": 0.5,
    "legend.labelspacing": 0.45,
    "legend.loc": "upper left",
    "lines.linewidth": 1.0,
    "lines.solid_capstyle": "butt",
    "mathtext.fontset": "dejavusans",
    "xtick.direction": "out",
    "xtick.labelsize": 8,
    "xtick.major.size": 3,
    "xtick.major.width": 0.6,
    "ytick.labelsize": 8,
    "ytick.major.size": 3,
    "ytick.major.width": 0.6,
}


_ONE_AT_A_TIME = RLock()  # matplotlib's settings are the process's


@contextmanager
def look() -> Iterator[None]:
    """Our settings of matplotlib whatever the user's are, which hold again afterwards.

    As a decorator: of a function that makes artists, since they take most settings when made.
    """
    settings: dict[Any, Any] = {**matplotlib.rcParamsDefault, **RC}
    for name in KEPT:
        del settings[name]
    with _ONE_AT_A_TIME, matplotlib.rc_context(settings):
        yield


class Page(Figure):
    """A figure that looks the same wherever it is shown: ticks and formulas are made when drawn."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw with our settings."""
        with look():
            super().draw(renderer)


def page(height: int, title: str = "", below: str = "", colour: str = "black") -> Figure:
    """An empty figure of our width and its heading; its canvas measures texts in PNG pixels."""
    figure = Page(figsize=(WIDTH / DPI, height / DPI), dpi=DPI)
    FigureCanvasAgg(figure)
    if title:
        write(figure, 20, 14, title, size=9, weight="bold")
    if below:
        write(figure, 20, 52, below, linespacing=1.25 if "\n" in below else 1.2, color=colour)
    return figure


def share(figure: Figure, left: float, top: float) -> tuple[float, float]:
    """A place in pixels from the top left corner as shares from the lower left one."""
    wide, high = figure.get_size_inches() * DPI
    return left / wide, 1.0 - top / high


def place(
    figure: Figure, left: float, top: float, width: float, height: float, **more: Any
) -> Axes:
    """Axes in pixels from the top left corner of the figure."""
    (x, y), (right, above) = share(figure, left, top + height), share(figure, left + width, top)
    return figure.add_axes((x, y, right - x, above - y), **more)


def write(figure: Figure, left: float, top: float, text: str, **more: Any) -> None:
    """Text whose top left corner is at a pixel."""
    figure.text(*share(figure, left, top), text, va="top", **more)


def note(axes: Axes, text: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=CAM)


def period_colour(period: int) -> str:
    """Colour of a periodic orbit."""
    return PERIODS[period - 1] if period <= len(PERIODS) else LONGER


def label_colour(label: str) -> str:
    """Colour of the motion with a label."""
    if not label.startswith("P("):
        return CONTACT if label == "contact" else APERIODIC
    return RESTING[0] if "inf" in label else period_colour(int(label[2:].split(";")[0]))


def apart(wanted: Sequence[str], series: Sequence[str] = SERIES) -> list[str]:
    """The colours wanted; where one is taken, the last of the series that nobody wants."""
    spare = [colour for colour in series if colour not in wanted]
    out: list[str] = []
    for colour in wanted:
        if colour in out:
            colour = spare.pop() if spare else min(series, key=out.count)
        out.append(colour)
    return out


def number(value: float) -> str:
    """A number as it reads best: 190, 198.56, 739.378."""
    return f"{value:.10g}"


def motion(label: str, longest: int = 32) -> str:
    """A label for print: P(1;∞), long ones cut."""
    text = label.replace("inf", "∞")
    return text if len(text) <= longest else text[: longest - 2].rstrip(":;") + "…)"


def corner_names(corners_deg: Sequence[float]) -> dict[str, float]:
    """Corners as a, b, c, ... by phase; none where a cam has more than there are letters."""
    if len(corners_deg) > MOST_CORNERS:
        return {}
    return dict(zip(ascii_lowercase, sorted(corners_deg), strict=False))
