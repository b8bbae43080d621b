"""Colours by meaning, matplotlib's settings, and words for print."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from string import ascii_lowercase
from threading import RLock
from typing import Any

import matplotlib
from matplotlib.colors import to_hex, to_rgb

from camcli.analysis.labels import period_of
from camcli.cams.files import decoded, read_bytes
from camcli.errors import Fault, SceneError

DPI = 300  # as in camcli.mplstyle
MOST_BYTES = 256_000  # of a style's file
COMMENT = re.compile(r'("[^"]*")|#.*')  # in it, or quoted text
WITH_INDEX = 9  # pt, of words with an index, which is 0.7 of them
NOTE = 7  # pt, of what stands inside or above a panel
MOST_CORNERS = len(ascii_lowercase)  # a cam with more is drawn without them

# One meaning each in every picture. The contact of the follower, and its events:
FLIGHT = "#0072B2"
STICKING = "#E69F00"
SLOWING = "#A85B00"  # sticking while the cam's acceleration is below zero
IMPACT = "#000000"
CHATTER = "#CC79A7"  # where a chatter accumulates
DETACHMENT = "#009E73"
TROUBLE = "#D55E00"  # a status that is not ok, a warning

CAM = "#4D4D4D"
CAM_BODY = "#EFEFEF"  # and what else lies inside a border: the unit disk
GUIDE = "#9A9A9A"  # corners, turns: lines that help to read
BAND = "#F3EEDF"  # the range shown enlarged in another panel
SIMULATED = "#A9A9A9"  # impacts, behind what is computed
MEASURED, DOUBT = "#7A5200", "#E8DCC4"  # rows of a table, the bound on their error
FORCES = ("#F2C766", "#C98B00", "#A66F00", "#5E3F00", "#000000")  # several contact forces
PULL = "#D9F0E8"  # below zero force, the follower leaves

# Motions: a periodic one has the colour of its period (Paul Tol's muted scheme).
PERIODS = ("#332288", "#88CCEE", "#CC6677", "#999933")
LONGER = "#AA4499"
CONTACT = "#F7DFA8"  # always in contact
APERIODIC, UNDECIDED = "#000000", "#BDBDBD"

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
    settings: dict[Any, Any] = {**matplotlib.rcParamsDefault, **RC}
    if sheet is not None:
        settings |= _sheet(sheet)
    if font is not None:
        _refuse_unknown(font)
        settings |= {"font.family": [font, "DejaVu Sans"], "mathtext.fontset": "custom"}
        settings |= {"mathtext.rm": font, "mathtext.it": f"{font}:italic"}
    for name in KEPT:
        settings.pop(name, None)
    with _ONE_AT_A_TIME, matplotlib.rc_context(settings):
        yield


def _sheet(sheet: str) -> dict[Any, Any]:
    """The settings of a matplotlib style."""
    from matplotlib.style import library

    if sheet in library:
        return dict(library[sheet])
    expected = "expected a matplotlib style: its name, or a file of lines `key: value`"
    cure = "python -c 'import matplotlib.style; print(matplotlib.style.available)' lists the names"
    text = decoded(read_bytes(Path(sheet), sheet, MOST_BYTES, expected, cure, "plot.style"), sheet)
    settings: Any = matplotlib.RcParams()
    for number, line in enumerate(text.splitlines(), 1):  # matplotlib's reader would print them
        key, colon, value = COMMENT.sub(lambda found: found[1] or "", line).partition(":")
        if not key.strip() and not colon:
            continue
        try:
            settings[key.strip()] = value.strip().removeprefix('"').removesuffix('"')
        except (KeyError, ValueError):
            found, where = "found no setting of matplotlib", f"{sheet}:{number}"
            cure = "correct the line, or leave it out"
            raise SceneError(Fault(where, "plot.style", found, expected, cure)) from None
    return dict(settings)


def _refuse_unknown(font: str) -> None:
    from matplotlib.font_manager import fontManager

    names = sorted({entry.name for entry in fontManager.ttflist})
    if font not in names:
        expected = f"expected an installed font, e.g. {', '.join(names[:4])}"
        raise SceneError(Fault("plot.font", "", f"found '{font}'", expected, ""))


def period_colour(period: int) -> str:
    """Colour of a periodic orbit."""
    return PERIODS[period - 1] if period <= len(PERIODS) else LONGER


def label_colour(label: str) -> str:
    """Colour of the motion with a label."""
    if label.startswith("P("):
        return period_colour(period_of(label))
    return {"contact": CONTACT, "undecided": UNDECIDED}.get(label, APERIODIC)


def mixed(colour: str, share: float, other: str = "white") -> str:
    """A colour with a share of another."""
    pairs = zip(to_rgb(colour), to_rgb(other), strict=True)
    red, green, blue = ((1.0 - share) * a + share * b for a, b in pairs)
    return to_hex((red, green, blue)).upper()


def apart(wanted: Sequence[str]) -> list[str]:
    """The colours wanted; of those wanted again, paler and darker shades."""
    shades = ((0.0, "white"), (0.45, "white"), (0.45, "black"), (0.7, "white"), (0.2, "black"))
    places = [wanted[:k].count(colour) % len(shades) for k, colour in enumerate(wanted)]
    return [mixed(colour, *shades[k]) for colour, k in zip(wanted, places, strict=True)]


def number(value: float) -> str:
    """A number as it reads best: 190, 198.56, 739.378."""
    return f"{value:.10g}".replace("-", "−")


def motion(label: str, longest: int = 32) -> str:
    """A label for print: P(1;∞), long ones cut."""
    text = label.replace("inf", "∞")
    return text if len(text) <= longest else text[: longest - 2].rstrip(":;") + "…)"


def corner_names(corners_deg: Sequence[float]) -> dict[str, float]:
    """Corners as a, b, c, ... by phase; none where a cam has more than there are letters."""
    if len(corners_deg) > MOST_CORNERS:
        return {}
    return dict(zip(ascii_lowercase, sorted(corners_deg), strict=False))
