"""What a matplotlib figure shows, read back artist by artist.

A `Panel` holds every artist of one pair of axes. A check explains them one after the other: each
method looks for an artist with these data and this look, takes it away, and fails where there is
none. What is left at the end was drawn and nobody said why: `done` fails.

Colours are written here once more, by their meaning.
"""

import re
from dataclasses import dataclass
from itertools import islice
from math import inf

import numpy as np
from matplotlib.colors import to_hex, to_rgb
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.markers import CARETUP
from matplotlib.text import Annotation, Text

import camcli
from tests.support.looks import hold_to_the_sheet, look_of, look_of_axes, look_of_name

COLOURS = {
    "flight": "#0072B2", "sticking": "#E69F00", "slowing": "#8E3E11", "impact": "#000000",
    "chatter": "#B76995", "detachment": "#07A974", "trouble": "#CC5E0F", "cam": "#4D4D4D",
    "body": "#EFEFEF", "guide": "#9A9A9A", "band": "#F3EEDF", "simulated": "#A9A9A9",
    "measured": "#7A5200", "doubt": "#E8DCC4", "pull": "#D9F0E8", "contact": "#DDC87B",
    "aperiodic": "#000000", "undecided": "#97ABA8", "longer": "#7856AF", "white": "#FFFFFF",
    "black": "#000000", "period 1": "#231082", "period 2": "#28B6F7", "period 3": "#FD3F79",
    "period 4": "#402E00",
}  # fmt: skip
FORCES = ("#F2C766", "#C98B00", "#A66F00", "#5E3F00", "#000000")
MARKS = {  # of an event: marker, face and edge
    "impact": ("o", "impact", "none"),
    "chatter": (CARETUP, "chatter", "white"),
    "chatter-completion": (CARETUP, "chatter", "white"),
    "detachment": ("D", "detachment", "white"),
    "departure": ("d", "white", "detachment"),
    "period-doubling": ("s", "white", "impact"),
    "fold": ("<", "white", "impact"),
    "corner-impact": ("o", "white", "impact"),
    "grazing": ("v", "white", "impact"),
    "lost": ("X", "trouble", "white"),
}
TOLD = 40  # artists that a message names


# --- colours, strokes, numbers


def hexed(colour):
    """A colour by its meaning or in matplotlib's words, as #RRGGBB; none stays none."""
    if isinstance(colour, str) and (colour in COLOURS or colour == "none"):
        return COLOURS.get(colour, colour)
    return to_hex(colour).upper()


def motion_colour(label):
    """The colour of the motion with a label."""
    if "inf" in label or "∞" in label:
        return COLOURS["sticking"]
    if label.startswith("P("):
        period = int(label[2:].partition(";")[0])
        return COLOURS[f"period {period}" if period <= 4 else "longer"]
    return COLOURS[label]


def mixed(colour, share, other="white"):
    """A colour with a share of another one."""
    pairs = zip(to_rgb(hexed(colour)), to_rgb(other), strict=True)
    return to_hex([(1.0 - share) * own + share * more for own, more in pairs]).upper()


def dashes(line):
    """Solid, dashed (strokes longer than gaps), dotted, or none."""
    if line.get_linestyle() in ("None", "none", "", " "):
        return "none"
    _, pattern = line._unscaled_dash_pattern
    if not pattern:
        return "solid"
    return "dashed" if pattern[0] > pattern[1] else "dotted"


def same(found, wanted, close=1e-9, within=None):
    """Whether two columns are equal within a share of their size, nan at the same places.

    within: the largest difference itself instead.
    """
    found, wanted = np.asarray(found, dtype=float), np.asarray(wanted, dtype=float)
    if found.shape != wanted.shape:
        return False
    if within is None:
        within = close * np.abs(wanted[np.isfinite(wanted)]).max(initial=0.0)
    return bool(np.allclose(found, wanted, rtol=0.0, atol=within, equal_nan=True))


def label_of(artist):
    """What the legend calls it, if anything."""
    label = artist.get_label()
    return None if label is None or label.startswith("_") else label


def told(artist):
    """An artist in a line, for the message of a test that fails."""
    if isinstance(artist, Line2D):
        x, y = np.asarray(artist.get_xdata()), np.asarray(artist.get_ydata())
        look = hexed(artist.get_color()), dashes(artist), artist.get_marker(), label_of(artist)
        return f"line of {len(x)}: {x[:4]} {y[:4]} {look}"
    if isinstance(artist, Text):
        return f"text {artist.get_text()!r} {artist.get_position()}"
    return f"{artist} {label_of(artist)}"


def numbers(texts):
    """Numbers on an axis, from their texts."""
    plain = [re.sub(r"\$\\mathdefault\{(.*)\}\$", r"\1", text) for text in texts]
    return np.array([float(text.replace("−", "-")) for text in plain])


# --- panels


class Image:
    """An image as what it shows at places of its axes."""

    def __init__(self, artist):
        """A picture of cells with the ends of both axes; rows from the lowest up."""
        self.artist = artist
        self.left, self.right, self.low, self.high = artist.get_extent()
        first_below = artist.origin == "lower"
        self.values = artist.get_array() if first_below else artist.get_array()[::-1]

    def value(self, x, y):
        """What is shown at a place: the number, or the colour's bytes."""
        rows, columns = self.values.shape[:2]
        row = (np.asarray(y) - self.low) / (self.high - self.low) * rows
        column = (np.asarray(x) - self.left) / (self.right - self.left) * columns
        return self.values[
            np.clip(row.astype(int), 0, rows - 1), np.clip(column.astype(int), 0, columns - 1)
        ]

    def colour(self, x, y):
        """The colour at a place, None where it is blank."""
        value = self.value(x, y)
        if self.values.ndim == 3:
            return to_hex(np.asarray(value[:3]) / 255.0).upper()
        return None if np.ma.is_masked(value) else hexed(self.artist.to_rgba(value))


class Panel:
    """One pair of axes, the narrow curves beside it and its colour bars; see the module."""

    def __init__(self, name, axes, besides=(), bars=()):
        """All artists of axes but frame, title and legend; `left`: those not explained yet."""
        self.name, self.axes, self.besides, self.bars = name, axes, besides, bars
        frame = {axes.patch, axes.xaxis, axes.yaxis, *axes.spines.values(), *axes.child_axes}
        frame |= {axes.title, axes._left_title, axes._right_title, axes.get_legend()}
        drawn = [a for a in axes.get_children() if a not in frame and a.get_visible()]
        self.left = [a for a in drawn if not isinstance(a, Text) or a.get_text() or is_arrow(a)]
        self.looks = {look_of(a) for a in self.left} | self._looks_of_names()
        self.looks |= {*look_of_axes(axes)}

    def _looks_of_names(self):
        """The looks of the titles and the names of the axes, but for plain ones of 8 pt."""
        axes = self.axes
        named = {
            "title": axes.title, "title at the right": axes._right_title,
            "title at the left": axes._left_title, "name below": axes.xaxis.label,
            "name beside": axes.yaxis.label,
        }  # fmt: skip
        looks = {look_of_name(text, what) for what, text in named.items() if text.get_text()}
        return looks - {f"{what} of 8" for what in named}

    def fail(self, *said):
        """Say what was looked for, and what is there."""
        there = [told(artist) for artist in islice(self.left, TOLD)]
        raise AssertionError(f"{self.name}: found no {' '.join(map(str, said))}; there: {there}")

    def done(self):
        """Nothing is left that was not explained, and all looks are on the sheet."""
        assert not self.left, (self.name, [told(artist) for artist in self.left])
        hold_to_the_sheet(kind_of(self.name), self.looks)

    def pick(self, kind, fits=lambda _: True, count=None):
        """Take all artists of a class that fit; count: how many there must be."""
        found = [a for a in self.left if isinstance(a, kind) and fits(a)]
        if count not in (None, len(found)):
            self.fail(count, kind.__name__)
        self.left = [a for a in self.left if a not in found]
        return found

    # --- what is written

    @property
    def title(self):
        """The title without the panel's letter, wherever it stands."""
        said = [self.axes.get_title(loc=place) for place in ("left", "center", "right")]
        said[0] = re.sub(r"^\([a-z]\) ?", "", said[0])
        return " ".join(filter(None, said))

    @property
    def labels(self):
        """Names of the two axes."""
        return self.axes.get_xlabel(), self.axes.get_ylabel()

    def reads(self, way, name, factor=1.0):
        """The axis has this name, and its numbers are the data times a factor."""
        axes = self.besides[0] if self.besides and way == "y" else self.axes
        axis = getattr(axes, f"{way}axis")
        assert axis.get_label_text() == name, (self.name, axis.get_label_text(), name)
        low, high = sorted(axis.get_view_interval())
        places = [float(f"{low + share * (high - low):.3g}") for share in (0.2, 0.5, 0.8)]
        formatter = axis.get_major_formatter()
        shown, wanted = numbers(formatter.format_ticks(places)), factor * np.array(places)
        assert not formatter.get_offset(), (self.name, formatter.get_offset())
        size = factor * max(abs(low), abs(high))
        assert np.abs(shown - wanted).max() <= 6e-3 * size, (self.name, shown, wanted)

    def words(self, text, x=None, y=None, within=None):
        """A text; x, y: where it stands (data, or share of the axes), within so much."""
        found = [a for a in self.left if isinstance(a, Text) and a.get_text() == text]
        for at, want in enumerate((x, y)):
            if want is not None:
                room = within or 1e-9 * max(abs(want), 1.0)
                found = [a for a in found if abs(a.get_position()[at] - want) <= room]
        if not found:
            self.fail("text", repr(text), "at", x, y)
        self.left.remove(found[0])
        return found[0]

    def in_order(self, places, way):
        """Texts at the panel's edge in the order of their places, each near its own."""
        low, high = sorted(getattr(self.axes, f"get_{way}lim")())
        rising = sorted(places, key=places.get)
        texts = [self.words(str(name)) for name in rising]
        at = [text.get_position()["xy".index(way)] for text in texts]
        assert at == sorted(at), (self.name, at)
        for name, place in zip(rising, at, strict=True):
            assert abs(place - places[name]) <= 0.12 * (high - low), (self.name, name, place)

    # --- what is drawn

    def line(self, x, y, colour, style="solid", label=None, width=None, **near):
        """A line through these points; label: what the legend calls it, False for anything.

        near: `close` or `within` of `same`.
        """

        def fits(a):
            wide = width is None or a.get_linewidth() == width
            plain = a.get_marker() in ("None", "", None)
            return plain and wide and dashes(a) == style and hexed(a.get_color()) == hexed(colour)

        return self._through(f"line {colour} {style} {label}", fits, x, y, label, near)

    def dots(self, x, y, marker, face, edge=None, label=None, style="none", **near):
        """Marks at these points, joined by a line of a style."""

        def fits(a):
            edged = edge is None or hexed(a.get_markeredgecolor()) == hexed(edge)
            filled = hexed(a.get_markerfacecolor()) == hexed(face)
            return a.get_marker() == marker and dashes(a) == style and filled and edged

        return self._through(f"marks {marker} {face} {label}", fits, x, y, label, near)

    def marks(self, x, y, kind, label=None, **near):
        """The marks of an event."""
        marker, face, edge = MARKS[kind]
        return self.dots(x, y, marker, face, edge, label, **near)

    def _through(self, what, fits, x, y, label, near):
        """The line or the marks that fit, through points of the data."""
        alike = [
            a for a in self.left
            if isinstance(a, Line2D) and a.get_transform() == self.axes.transData and fits(a)
            and (label is False or label_of(a) == label)
        ]  # fmt: skip
        for a in alike:
            if same(a.get_xdata(), x, **near) and same(a.get_ydata(), y, **near):
                self.left.remove(a)
                return a
        return self.fail(what, x, y, "; alike:", list(map(told, alike)))

    def lines(self, colour=None, label=False, count=None):
        """Take all lines of a colour and a label."""

        def fits(a):
            of_colour = colour is None or hexed(a.get_color()) == hexed(colour)
            return of_colour and (label is False or label_of(a) == label)

        return self.pick(Line2D, fits, count)

    def guide(self, way, at, colour, style="solid"):
        """A line across the whole panel at a value of an axis: way x is upright, y lies."""
        across = getattr(self.axes, f"get_{way}axis_transform")()
        size = max(abs(at), 1e-3 * np.ptp(getattr(self.axes, f"get_{way}lim")()))
        for a in self.left:
            if not isinstance(a, Line2D) or a.get_transform() != across:
                continue
            data = getattr(a, f"get_{way}data")()
            there = len(set(data)) == 1 and abs(data[0] - at) <= 1e-9 * size
            if there and hexed(a.get_color()) == hexed(colour) and dashes(a) == style:
                self.left.remove(a)
                return
        self.fail("guide", way, at, colour, style)

    def corners(self, corners, way, named=True):
        """The cam's corners that lie in the panel: a line each, and its name at the edge."""
        low, high = sorted(getattr(self.axes, f"get_{way}lim")())
        seen = {name: at for name, at in corners.items() if low <= at <= high}
        for at in seen.values():
            self.guide(way, at, "guide", "dotted" if way == "x" else "solid")
        if named:
            self.in_order(seen, way)

    def band(self, way, low, high, colour):
        """A band across the whole panel from one value of an axis to another."""
        for a in self.left:
            if not hasattr(a, "get_width") or hexed(a.get_facecolor()) != hexed(colour):
                continue
            begin = getattr(a, f"get_{way}")()
            size = a.get_width() if way == "x" else a.get_height()
            if same(sorted([begin, begin + size]), sorted([low, high])):
                self.left.remove(a)
                return
        self.fail("band", way, low, high, colour)

    def images(self):
        """Take all images."""
        return [Image(a) for a in self.pick(AxesImage)]

    def key(self, *names):
        """Entries of the legend that draw nothing: a square in the colour of each name."""
        for name, colour in names:

            def fits(a, name=name, colour=colour):
                empty = not len(a.get_xdata()) and a.get_marker() == "s"
                return empty and label_of(a) == name and hexed(a.get_color()) == hexed(colour)

            self.pick(Line2D, fits, count=1)


def is_arrow(artist):
    """Whether it is an arrow, with or without words."""
    return isinstance(artist, Annotation) and artist.arrow_patch is not None


# --- a result's panels


def panels_of(result, picture=None, **form):
    """Every panel of a picture, those of one word on a page of their own."""
    picture = picture or next(iter(result.pictures))
    drawn = result.pictures[picture]().panels
    for name, panel in drawn.items():
        hold_to_the_sheet(kind_of(name), [size_of(panel)])
    for word in dict.fromkeys(name.split()[0] for name in drawn):
        figure = camcli.plot(result, picture, panels=[word], height=900, **form)
        yield from on_page(figure, {k: v for k, v in drawn.items() if k.split()[0] == word})


def size_of(panel):
    """How tall a panel is, how many stand side by side, and whether it is drawn unasked."""
    shape = "" if panel.shape == inf else f", at most {panel.shape:g} of its width"
    usual = "" if panel.usual else ", only where it is asked for"
    return f"panel of {panel.height:g} mm, {panel.across} in a row{shape}{usual}"


def usual(result, picture=None):
    """The panels that are drawn where none is asked for."""
    drawn = result.pictures[picture or next(iter(result.pictures))]().panels
    return [name for name, panel in drawn.items() if panel.usual]


def kind_of(name):
    """A panel's name without its number."""
    return re.sub(r" [\d.]+( rpm)?(?= |$)", "", name)


def on_page(figure, drawn):
    """The panels of a figure in their order, with the curves and colour bars beside each."""
    bars = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"]
    places = [axes for axes in figure.axes[1:] if axes not in bars]
    assert len(places) == sum(1 + len(panel.beside) for panel in drawn.values())
    for name, panel in drawn.items():
        main, *besides = places[: 1 + len(panel.beside)]
        del places[: 1 + len(panel.beside)]
        yield Panel(name, main, besides, bars)


def rows_on_page(figure, drawn):
    """The names of the panels as they stand on the page: row by row, each from left to right."""
    rows = {}
    for panel in on_page(figure, drawn):
        place = panel.axes.get_subplotspec().get_position(figure)
        rows.setdefault(round(-place.y1, 6), []).append((place.x0, panel.name))
    return [[name for _, name in sorted(row)] for _, row in sorted(rows.items())]


def check(result, checks, picture=None, **form):
    """Explain every artist of every panel: checks by the panel's name, without its number."""
    seen = set()
    for panel in panels_of(result, picture, **form):
        kind = kind_of(panel.name)
        assert kind in checks, f"nothing checks the panel {panel.name}"
        checks[kind](panel)
        panel.done()
        seen.add(kind)
    return seen


# --- a page as it is shown


@dataclass
class Page:
    """What stands above the panels: texts in their order, and the legend by name."""

    figure: object
    texts: list
    legend: dict

    def says(self, *texts):
        """Each of these stands there or in the caption, whatever line it is broken into."""
        whole = " ".join(self.texts)
        for text in texts:
            sentence = text[:1].upper() + text[1:]
            captioned = text in self.figure.caption or sentence in self.figure.caption
            assert text in whole or captioned, (text, self.texts, self.figure.caption)

    def rows(self):
        """The rows of the lists: texts and samples of lines and marks, from left to right."""
        heading, rows = self.figure.axes[0], {}
        for text in heading.texts:
            if text.get_text():
                x, y = text.get_position()
                rows.setdefault(round(y, 6), []).append((x, text.get_text()))
        for line in heading.lines:
            x, y = line.get_xdata()[0], line.get_ydata()[0]
            rows.setdefault(round(y, 6), []).append((x, line))
        return [[cell for _, cell in sorted(rows[y], key=lambda at: at[0])] for y in sorted(rows)]

    def row(self, *cells):
        """The row of a list that has these texts, from left to right."""
        for row in self.rows():
            rest = iter(row)
            if all(any(own == cell for own in rest) for cell in cells):
                return row
        raise AssertionError((cells, [[str(cell) for cell in row] for row in self.rows()]))


def read_page(result, picture=None, **form):
    """The heading of a result's usual page, after checks that hold for any page.

    Every label drawn in a panel without a legend of its own is in the heading's, once, with the
    look that it has there; an axis without a name shares that of a panel below, of the same range.
    """
    figure = camcli.plot(result, picture, **form)
    heading, *panels = figure.axes
    entries, shown = heading.get_legend(), {}
    if entries is not None:
        for handle, text in zip(entries.legend_handles, entries.get_texts(), strict=True):
            assert text.get_text() not in shown
            shown[text.get_text()] = handle
    wanted = {}
    for axes in panels:
        if axes.get_legend() is None:
            for handle, name in zip(*axes.get_legend_handles_labels(), strict=True):
                wanted.setdefault(name, handle)
    assert {*shown} == {*wanted}
    for name, handle in wanted.items():
        assert look(shown[name]) == look(handle), (name, look(shown[name]), look(handle))
    for axes in panels:
        assert is_named(axes, panels), axes
    drawn = [a for a in (*heading.texts, *heading.lines) if not isinstance(a, Text) or a.get_text()]
    hold_to_the_sheet("heading", map(look_of, drawn))
    hold_one_below_the_other(heading)
    return Page(figure, [text.get_text() for text in heading.texts if text.get_text()], shown)


def hold_one_below_the_other(heading):
    """The heading holds its legend, which stands below the words, to a pixel."""
    legend, page = heading.get_legend(), heading.get_window_extent()
    words = [text.get_window_extent() for text in heading.texts if text.get_text()]
    if legend is not None:
        box = legend.get_window_extent()
        assert page.y0 - 1.0 <= box.y0 < box.y1 <= page.y1 + 1.0, (page, box)
        assert all(box.y1 <= word.y0 + 1.0 for word in words), (box, heading.texts)
    assert all(page.y0 - 1.0 <= word.y0 < word.y1 <= page.y1 + 1.0 for word in words), words


def look(artist):
    """What tells an entry of a legend from the others."""
    if not isinstance(artist, Line2D):
        face = artist.get_facecolor()
        return hexed(face[0] if np.ndim(face) > 1 else face)
    stroke = dashes(artist), hexed(artist.get_color())
    mark = artist.get_marker(), hexed(artist.get_markerfacecolor())
    return (
        stroke if stroke[0] != "none" else None,
        mark if mark[0] not in ("None", "", None) else None,
    )


def is_named(axes, panels):
    """Whether an axis says what runs to the right, or shares that with a panel below."""
    ticks = axes.xaxis.get_tick_params()
    if axes.get_xlabel() or not axes.axison or not ticks["bottom"] or not len(axes.get_xticks()):
        return True
    place = axes.get_subplotspec().get_position(axes.figure)
    below = [
        other for other in panels
        if other.get_subplotspec() is not None and other.get_xlim() == axes.get_xlim()
        and other.get_subplotspec().get_position(axes.figure).y1 <= place.y0 + 1e-6
    ]  # fmt: skip
    return not ticks["labelbottom"] and any(other.get_xlabel() for other in below)
