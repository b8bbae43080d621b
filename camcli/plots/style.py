"""Colours by meaning, matplotlib's settings, and words for print."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from io import BytesIO
from math import degrees, inf
from pathlib import Path
from string import ascii_lowercase
from threading import RLock
from typing import Any

import matplotlib
from matplotlib.colors import to_hex, to_rgb

from camcli.analysis.labels import Label, period_of
from camcli.cams.files import decoded, read_bytes
from camcli.errors import Fault, SceneError, shown

DPI = 300  # as in camcli.mplstyle
MOST_BYTES = 256_000  # of a style's file
EXPECTED = "expected a matplotlib style: its name, or a file of lines `key: value`"
MOST_FONTS = 3  # near to one that is not installed
FONTS = "name another: any installed one will do, and DejaVu Sans is always there"
MOST_SIZE, MOST_COUNT = 1000.0, 1e6  # of a number in it: points, shares; of those in COUNTS
COUNTS = ("agg.path.chunksize", "figure.max_open_warning", "animation.bitrate")
DPIS, LEAST_DPI, MOST_DPI = ("figure.dpi", "savefig.dpi"), 20.0, 1200.0
COMMENT = re.compile(r'("[^"]*")|#.*')  # in it, or quoted text
WITH_INDEX = 8.6  # pt, of words with an index, which is 0.7 of them: 6 pt
NOTE = 7  # pt, of what stands inside or above a panel
MOST_CORNERS = len(ascii_lowercase)  # a cam with more is drawn without them

# One meaning each in every picture. The contact of the follower, and its events: 20 apart in CIE
# Lab for everybody, whichever kind of cones is missing.
FLIGHT = "#0072B2"
STICKING = "#E69F00"
SLOWING = "#8E3E11"  # sticking while the cam's acceleration is below zero
IMPACT = "#000000"
CHATTER = "#B76995"  # where a chatter accumulates
DETACHMENT = "#07A974"
TROUBLE = "#CC5E0F"  # a status that is not ok, a warning

CAM = "#4D4D4D"
CAM_BODY = "#EFEFEF"  # and what else lies inside a border: the unit disk
GUIDE = "#9A9A9A"  # corners, turns: lines that help to read
BAND = "#F3EEDF"  # the range shown enlarged in another panel
BLANK = "#808080"  # a cell of a map without a value
SIMULATED = "#A9A9A9"  # impacts, behind what is computed
MEASURED, DOUBT = "#7A5200", "#E8DCC4"  # rows of a table, the bound on their error
FORCES = ("#F2C766", "#C98B00", "#A66F00", "#5E3F00", "#000000")  # several contact forces
PULL = "#D9F0E8"  # below zero force, the follower leaves

# Motions: a periodic one has the colour of its period (after Paul Tol). Ten colours cannot be 20
# apart in CIEDE2000 for everybody and be told by their names: these are 15 apart where L or M cones
# are missing but for two pairs, which the eye tells by their shape: rests are points, contact is an
# area, and solved orbits are lines with a white edge.
PERIODS = ("#231082", "#28B6F7", "#FD3F79", "#402E00")
LONGER = "#7856AF"
CONTACT = "#DDC87B"  # always in contact
APERIODIC, UNDECIDED = "#000000", "#97ABA8"
RESTS = "with rests"
KINDS = {  # of motions, see `kind_of_label`
    "contact": CONTACT,
    **{f"period {period}": colour for period, colour in enumerate(PERIODS, 1)},
    "longer periods": LONGER,
    RESTS: STICKING,
    "aperiodic": APERIODIC,
    "undecided": UNDECIDED,
}
# The same where they fill a map: as far apart, and pale enough for black lines and numbers.
AREAS = {
    **dict(zip(PERIODS, ("#5382DE", "#74CDFA", "#F06080", "#7D7F38"), strict=True)),
    LONGER: "#A55596",
    STICKING: "#E39B33",
    CONTACT: "#FBCEA7",
    APERIODIC: "#BFBFBF",
    UNDECIDED: "#FFFFFF",
}

# Curves over a map, beside black and white ones: as far apart in grey as in colour.
CURVE_RED, CURVE_GREEN = "#B2182B", "#7FDCC0"
PROVED = "#FFE600"  # the band along the proved part of a curve

# Boxes of impact phases without an orbit, by what excludes them (`exact.phase_cover.Exclusion`).
EXCLUDED = {"order": "#EFEFEF", "flight": "#BFD3E6", "impact": "#F2D9A6", "newton": "#8FBF9F"}
HOLDS_ORBIT = "#E58FA3"  # and those that hold none but a known one

KEPT = ("backend", "backend_fallback", "interactive", "toolbar")  # not of our business
RC = matplotlib.rc_params_from_file(
    Path(__file__).with_name("camcli.mplstyle"), use_default_template=False
)

_ONE_AT_A_TIME = RLock()  # matplotlib's settings are the process's


@contextmanager
def look(font: str | None = None, sheet: str | None = None) -> Iterator[None]:
    """Our settings of matplotlib whatever the user's are, which hold again afterwards.

    font: name of an installed one. sheet: name or file of a matplotlib style, on top of ours.
    Raises SceneError where there is none of that name.
    """
    with _settled(_ours(font, {} if sheet is None else _sheet(sheet))):
        yield


def _ours(font: str | None, style: dict[Any, Any] | None = None) -> dict[Any, Any]:
    """Our settings, those of a style on top of them, and those of a font."""
    settings: dict[Any, Any] = {**matplotlib.rcParamsDefault, **RC, **(style or {})}
    if font is not None:
        _refuse_unknown(font)
        settings |= {"font.family": [font, "DejaVu Sans"], "mathtext.fontset": "custom"}
        settings |= {"mathtext.rm": font, "mathtext.it": f"{font}:italic", "mathtext.cal": font}
    return settings


@contextmanager
def _settled(settings: dict[Any, Any]) -> Iterator[None]:
    """matplotlib's settings in the block; one thread at a time."""
    kept = {name: value for name, value in settings.items() if name not in KEPT}
    with _ONE_AT_A_TIME, matplotlib.rc_context(kept):
        yield


def check_look(font: str | None, sheet: str | None) -> None:
    """Raise SceneError where a picture could not be drawn so: a small one is.

    matplotlib takes settings that it cannot draw, and says so only when it does. The fault names
    the line of a style's file up to which the picture can be drawn.
    """
    with look(font, sheet):
        pass
    if sheet is None or _trial(font, dict(settings := _sheet(sheet))) is None:
        return
    items = list(settings.items())
    drawn = 0  # with so many of the settings something can be drawn,
    fails = len(items)  # with so many nothing can
    while fails - drawn > 1:
        middle = (drawn + fails) // 2
        if _trial(font, dict(items[:middle])) is None:
            drawn = middle
        else:
            fails = middle
    key = items[fails - 1][0]
    error = _trial(font, dict(items[:fails]))
    where = f"{sheet}:{lines[key]}" if (lines := _lines(sheet)) else sheet
    found = f"found {key}, in which nothing can be drawn ({shown(str(error), 200)})"
    expected, cure = "expected a style to draw in", "correct the line, or leave it out"
    raise SceneError(Fault(where, "plot.style", found, expected, cure))


def dpi_of(sheet: str | None) -> float:
    """Dots per inch of a picture in a style."""
    settings = {**RC, **({} if sheet is None else _sheet(sheet))}
    own = settings["savefig.dpi"]
    return float(settings["figure.dpi"] if own == "figure" else own)


def _trial(font: str | None, settings: dict[Any, Any]) -> Exception | None:
    """What goes wrong in a small picture with all that pictures are made of, None where nothing."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    try:
        with _settled(_ours(font, settings)):
            figure = Figure(figsize=(1.6, 1.6), dpi=50, layout="constrained")
            FigureCanvasAgg(figure)
            axes = figure.add_subplot()
            axes.plot([0.0, 1.0, 2.0], [0.0, 1.0, 0.5], marker="o", label="$q_1$ (m)")
            axes.plot([0.0, 1.0, 2.0], [1.0, 0.0, 0.3])
            axes.scatter([0.5], [0.5], label="point")
            axes.imshow([[0.0, 1.0], [1.0, 0.0]], extent=(0.0, 1.0, 0.0, 1.0))
            axes.fill_between([0.0, 1.0], [0.0, 0.0], [0.2, 0.1], hatch="/")
            axes.contour([[0.0, 1.0], [1.0, 0.0]])
            axes.annotate("a", (0.5, 0.5), (1.0, 1.0), arrowprops={"arrowstyle": "->"})
            axes.set(title="Test", xlabel="speed (rpm)", ylabel=r"phase $\theta$")
            axes.legend()
            figure.savefig(BytesIO(), format="png", dpi=50)
    except Exception as error:
        return error
    return None


def _sheet(sheet: str) -> dict[Any, Any]:
    """The settings of a matplotlib style; raises SceneError for what no picture can have."""
    from matplotlib.style import library

    if sheet in library:
        return dict(library[sheet])
    settings: Any = matplotlib.RcParams()
    for number, key, value in _read(sheet):  # matplotlib's reader would print them
        where, cure = f"{sheet}:{number}", "correct the line, or leave it out"
        try:
            _refuse_formula(key, value)
            settings[key] = value
        except (KeyError, ValueError):
            found = "found no setting of matplotlib"
            raise SceneError(Fault(where, "plot.style", found, EXPECTED, cure)) from None
        if not _within(key, settings[key]):
            found = f"found {key}: {shown(value)}"
            most = MOST_COUNT if key in COUNTS else MOST_SIZE
            expected = f"expected finite numbers of at most {most:g}"
            if key in DPIS:
                expected = f"expected {LEAST_DPI:g} to {MOST_DPI:g}"
            raise SceneError(Fault(where, "plot.style", found, expected, cure))
        if key == "font.family":
            _refuse_no_family(settings[key], where)
    return dict(settings)


def _read(sheet: str) -> Iterator[tuple[int, str, str]]:
    """(line, key, value) of the settings in a style's file."""
    cure = "python -c 'import matplotlib.style; print(matplotlib.style.available)' lists the names"
    text = decoded(read_bytes(Path(sheet), sheet, MOST_BYTES, EXPECTED, cure, "plot.style"), sheet)
    for number, line in enumerate(text.splitlines(), 1):
        key, colon, value = COMMENT.sub(lambda found: found[1] or "", line).partition(":")
        if key.strip() or colon:
            yield number, key.strip(), value.strip().removeprefix('"').removesuffix('"')


def _lines(sheet: str) -> dict[str, int]:
    """The line of each setting of a style's file; none of a style of matplotlib's own."""
    from matplotlib.style import library

    return {} if sheet in library else {key: number for number, key, _ in _read(sheet)}


def _refuse_formula(key: str, value: str) -> None:
    """Raise ValueError for a cycle of properties with arithmetic in it: it is evaluated."""
    if key == "axes.prop_cycle" and (
        "**" in value or re.search(r"\d{5}|['\"\])\d]\s*\*\s*\d|\d\s*\*\s*['\"\[(]", value)
    ):
        raise ValueError


def _within(key: str, value: Any) -> bool:
    """Whether all numbers of a setting are finite, and of a size that can be drawn."""
    if isinstance(value, list | tuple):
        return all(_within(key, one) for one in value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return True
    if key in DPIS:
        return LEAST_DPI <= value <= MOST_DPI
    return abs(value) <= (MOST_COUNT if key in COUNTS else MOST_SIZE)


def _refuse_no_family(families: Sequence[str], where: str) -> None:
    """Raise SceneError where none of the families is installed: matplotlib warns at each word."""
    from matplotlib.font_manager import font_family_aliases, fontManager

    known = {entry.name for entry in fontManager.ttflist} | set(font_family_aliases)
    if families and known.isdisjoint(families):
        found = f"found font.family: {shown(', '.join(families))}"
        expected, cure = "expected an installed font", "name another, or leave the line out"
        raise SceneError(Fault(where, "plot.style", found, expected, cure))


def _refuse_unknown(font: str) -> None:
    from matplotlib.font_manager import fontManager

    names = {entry.name for entry in fontManager.ttflist}
    if font in names:
        return
    in_small = {name.lower(): name for name in sorted(names)}
    near = get_close_matches(font.lower(), in_small, MOST_FONTS)
    cure = f"did you mean {' or '.join(in_small[name] for name in near)}?" if near else FONTS
    found, expected = f"found '{shown(font)}'", "expected an installed font"
    raise SceneError(Fault("plot.font", "", found, expected, cure))


def period_colour(period: int) -> str:
    """Colour of a periodic orbit."""
    return PERIODS[period - 1] if period <= len(PERIODS) else LONGER


def kind_of_label(label: str) -> str:
    """The kind of the motions with a label: contact, period 1, ..., with rests, aperiodic."""
    if not isinstance(label, Label):
        return label if label in KINDS else "aperiodic"
    if inf in label.symbols:
        return RESTS
    period = period_of(label)
    return f"period {period}" if period <= len(PERIODS) else "longer periods"


def label_colour(label: str) -> str:
    """Colour of the motion with a label."""
    return KINDS[kind_of_label(label)]


def mixed(colour: str, share: float, other: str = "white") -> str:
    """A colour with a share of another."""
    pairs = zip(to_rgb(colour), to_rgb(other), strict=True)
    red, green, blue = ((1.0 - share) * a + share * b for a, b in pairs)
    return to_hex((red, green, blue)).upper()


def luminance(colour: str) -> float:
    """Relative luminance, from 0 of black to 1 of white (WCAG 2.2)."""
    parts = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour))
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), parts, strict=True))


def apart(wanted: Sequence[str]) -> list[str]:
    """The colours wanted; of those wanted again, paler and darker shades."""
    shades = ((0.0, "white"), (0.45, "white"), (0.45, "black"), (0.7, "white"), (0.2, "black"))
    places = [wanted[:k].count(colour) % len(shades) for k, colour in enumerate(wanted)]
    return [mixed(colour, *shades[k]) for colour, k in zip(wanted, places, strict=True)]


def corner_names(corners: Sequence[float]) -> dict[str, float]:
    """Phases in deg of corners (rad) as a, b, c, ...; none where there are more than letters."""
    if len(corners) > MOST_CORNERS:
        return {}
    return dict(zip(ascii_lowercase, map(degrees, sorted(corners)), strict=False))
