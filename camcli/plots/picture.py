"""A picture is named panels below a heading; matplotlib's constrained layout gives them room."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, inf
from string import ascii_lowercase
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.text import Annotation, Text
from matplotlib.ticker import AutoLocator, MaxNLocator

from camcli.plots import style
from camcli.quantities import MM_PER_INCH
from camcli.scene.schema import Plot
from camcli.words.figures import no_room

MM = 1.0 / MM_PER_INCH  # inch
TALLEST = 230.0  # mm: an A4 page without its margins
COLUMN, COMPACT = 90.0, 120.0  # mm: a journal's column, and the height of a picture made for it
NARROWEST, NARROWER = 55.0, 27.0  # mm, of a panel beside another; without numbers of its own
SQUEEZED = 0.65  # of its height, what a panel needs at least
EDGE, LINE, ROW = 2.0, 3.9, 3.4  # mm: around the heading, from line to line in it and in lists
BELOW = 11.0  # mm, of the numbers and the name below a panel
LETTER = 5.0  # mm, from a panel to the next with whose numbers it is read
COLUMNS = 6  # of the grid
CORNER, BESIDE = 0.08, -0.015  # of the width of a panel: numbers above it, its letter then
ABOVE = 7.0  # pt, of that letter above the panel's highest number
TITLED = 0.66  # of the width of a panel before numbers and names are beside it, words above it
NARROW = 0.085  # of the width of a panel, of a curve beside it
FEWEST_TICKS, MOST_TICKS = 3, 9  # on an axis, where a panel has not chosen its own
CALM = (1, 2, 5, 10)  # between two of these ticks, and times any power of ten
POINTS, DIGIT = 72.0, 0.64  # of an inch; width of a digit, of the size of its letters
PLACES = 9  # decimals of a place on the page
AGAIN = 4  # times that panels are placed anew where one of equal axes has become larger
CHARS = 0.64  # per mm, of the words below the title
LISTED = 0.42  # of the height that a page may have, where its lists end; longer ones are cut
MOST_ROWS = 44  # of a list on a wider page: with more no panel has room
FEWEST_ROWS = 4  # of a list that is cut, with its head and its last words
BOLD: dict[str, Any] = {"size": 9, "weight": "bold"}  # of the title
FEWEST = 2  # columns of a list whose last words are not put below
SAMPLE, SPACE = 5.0, 2.0  # mm: a mark or line in a list, between its columns

UNBROKEN = "\N{NO-BREAK SPACE}"
WITH_UNIT = re.compile(  # between number and unit, and within a range
    r"(?<=\d) (?=(?:rpm|deg|kg|[mµ]?m|N|rad)\b)|(?<=\d) (?=to [\d−-])|(?<=\d to) (?=[\d−-])"
)

Cell = str | dict[str, Any]  # words, or the look of a line or mark in their place
Rows = Sequence[Sequence[Cell]]  # a list above the panels, its head first


@dataclass(frozen=True)
class Panel:
    """What draws itself into axes.

    Panels of one `x` below one another share its numbers, those of one `y` beside one another.
    """

    draw: Callable[[Axes], None]
    height: float = 60.0  # mm, without the numbers and the name of its axis
    x: str = ""
    across: int = 1  # so many such panels stand side by side: 1, 2 or 3
    usual: bool = True  # False: only where it is asked for
    beside: Sequence[Callable[[Axes], None]] = ()  # narrow curves to the left, on a page only
    y: str = ""
    shape: float = inf  # of its height to its width, at most
    above: float = 0.0  # mm, of a legend of its own above it
    column: str = ""  # panels of one column below one another have one letter
    asked: bool = False  # for: where the page is too low others are left out before it
    shown_in: Mapping[str, Callable[[Axes, str], None]] = field(default_factory=dict)
    # what other panels draw of this one where both are on the page, given its letter


@dataclass(frozen=True)
class Picture:
    """What is drawn of a result: heading, lists, panels by name, from top to bottom."""

    title: str
    panels: dict[str, Panel]
    caption: str = ""  # not drawn: it goes into the file, and the gallery prints it
    words: str = ""  # below the title: what nobody may overlook
    colour: str = "black"  # of the words
    lists: Sequence[Rows] = field(default_factory=list)
    tall: float = TALLEST  # mm, at most in a column of a journal

    def figure(self, form: Plot | None = None) -> Page:
        """The panels on a page of their own; matplotlib's settings are ours meanwhile."""
        form = form or Plot()
        with style.look(form.font, form.style):
            return self._page(form)

    def chosen(self, names: Sequence[str] | None) -> dict[str, Panel]:
        """The panels of these names (`event` means event 3 too); the usual ones without any."""
        found = {own: self.panels[own] for name in names or () for own in self._named(name)}
        return found or {name: panel for name, panel in self.panels.items() if panel.usual}

    def lacking(self, names: Sequence[str] | None) -> list[str]:
        """Those of the names that none of the panels has."""
        return [name for name in names or () if not self._named(name)]

    def _named(self, name: str) -> list[str]:
        return [own for own in self.panels if own == name or own.startswith(f"{name} ")]

    def _caption(self, left_out: Sequence[str]) -> str:
        """What belongs below the picture, and which panels had no room on the page."""
        sentences = [self.caption, no_room(left_out) if left_out else ""]
        return " ".join(f"{text[0].upper()}{text[1:]}." for text in sentences if text)

    def _page(self, form: Plot) -> Page:
        layout = _Layout()
        figure = Page(figsize=(form.width * MM, (form.height or TALLEST) * MM), layout=layout)
        figure.look = form.font, form.style
        FigureCanvasAgg(figure)
        tallest = form.height or (TALLEST if form.width > COLUMN else self.tall)
        whole = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        heading = _Heading(whole, self, form, tallest)
        room = max(tallest - heading.top, BELOW)
        rows, left_out = _rows_with_room(self.chosen(form.panels), form, room)
        figure.caption = self._caption(left_out)
        figure.left_out = left_out
        figure.has_room = not left_out and _least(rows, form) <= room

        shared = _shared(rows)
        below = _height(rows, form) + _above(rows) + BELOW * (len(rows) - sum(shared)) + EDGE
        figure.set_figheight(min(below, room) * MM)  # as high as the panels will about be
        handles = _draw_rows(figure, rows, form)
        top = heading.finish(handles)
        height = form.height or min(top + below, tallest)
        share = top / height
        heading.axes.set_position((0.0, 1.0 - share, 1.0, share))
        figure.set_figheight(height * MM)
        layout.set(rect=(0.0, 0.0, 1.0, 1.0 - share))
        return figure


Row = list[tuple[str, Panel]]  # panels side by side, with their names


def _rows_with_room(
    panels: dict[str, Panel], form: Plot, room: float
) -> tuple[list[Row], list[str]]:
    """The rows of panels for which a page has so much room, mm, and the names of the others."""
    rows = _rows(panels, form.width)
    left_out: list[str] = []
    while len(rows) > 1 and _least(rows, form) > room:
        last = _least_asked(rows)
        rows.remove(last)
        left_out += [name for name, _ in last]
    return rows, left_out


def _draw_rows(figure: Figure, rows: list[Row], form: Plot) -> dict[str, Any]:
    """Draw all panels, and their curves beside them; returns what the legend shows, by its words.

    The grid has COLUMNS for the panels, and to the left of these one for each curve beside them.
    """
    most_beside = max(len(panel.beside) for row in rows for _, panel in row)
    narrow = most_beside if form.width >= 2.0 * NARROWEST else 0
    heights = [_height([row], form) + _above([row]) for row in rows]
    grid = figure.add_gridspec(
        len(rows),
        narrow + COLUMNS,
        width_ratios=[NARROW] * narrow + [1.0 / COLUMNS] * COLUMNS,
        height_ratios=heights,
    )
    letters = _letters([panel for row in rows for _, panel in row])
    following = iter(letters)
    shared = [*_shared(rows), False]  # the last row has its own numbers
    curves: list[Axes] = []  # beside panels
    named_at_left: list[Axes] = []
    drawn: dict[str, tuple[Axes, str]] = {}  # axes and letters of the panels by name
    handles: dict[str, Any] = {}
    for k, row in enumerate(rows):
        wide = COLUMNS // len(row)
        # several panels stand below the curves beside the others too
        inner = grid[k, :].subgridspec(1, len(row)) if narrow and len(row) > 1 else None
        for place, (name, panel) in enumerate(row):
            left = narrow + place * wide
            axes = _new_axes(figure, inner[place] if inner else grid[k, left : left + wide])
            panel.draw(axes)
            _calm_ticks(axes)
            letter = next(following)
            if len(set(letters)) > 1:
                if letter not in {other for _, other in drawn.values()}:
                    _name(axes, letter)
                _fold_title(axes)
            drawn[name] = axes, letter
            if panel.beside and narrow:
                places = [_new_axes(figure, grid[k, n]) for n in range(len(panel.beside))]
                _draw_beside(axes, places, panel, below_others=bool(curves))
                curves += places
            at_left = len(row) == 1 or (panel.y != "" and place == 0)
            is_plane = axes.get_aspect() != "auto"  # its name is beside its own box
            if axes.get_ylabel() and at_left and not is_plane:
                named_at_left.append(axes)
            if place and panel.y == row[0][1].y != "":
                axes.set_ylabel("")
                axes.tick_params(labelleft=False)
            if shared[k]:
                axes.set_xlabel("")
                axes.tick_params(labelbottom=False)
            if axes.get_legend() is None:
                for handle, words in zip(*axes.get_legend_handles_labels(), strict=True):
                    handles.setdefault(words, handle)
    _draw_in_others(dict(panel for row in rows for panel in row), drawn)
    figure.align_ylabels(named_at_left)
    figure.align_xlabels(curves)
    figure.align_titles(curves)
    return handles


def _new_axes(figure: Figure, place: SubplotSpec) -> Axes:
    """Axes without small ticks, of which matplotlib makes one for each axis that has none."""
    axes = figure.add_subplot(place)
    for axis in (axes.xaxis, axes.yaxis):
        axis.minorTicks = []
    return axes


def _draw_beside(axes: Axes, places: list[Axes], panel: Panel, below_others: bool) -> None:
    """The narrow curves beside a panel, which leaves its numbers and its name to them.

    below_others: below those of another panel, which have their scales.
    """
    for place, draw in zip(places, panel.beside, strict=True):
        draw(place)
        if below_others:
            _leave_out_scale(place)
        axes.tick_params(left=False, labelleft=False)
        axes.set_ylabel("")


def _draw_in_others(panels: dict[str, Panel], drawn: dict[str, tuple[Axes, str]]) -> None:
    """Draw in each panel what others show of it: where in it they are, with their letters."""
    for name, (_, letter) in drawn.items():
        for other, draw_part in panels[name].shown_in.items():
            if other in drawn:
                draw_part(drawn[other][0], letter)


class _Layout(ConstrainedLayoutEngine):
    """Its solver's last digits hang on addresses in memory; places are rounded beyond a pixel."""

    def execute(self, fig: Figure) -> None:
        """Place the panels; again where words about a panel with equal axes have no room.

        What such a panel leaves blank on its page counts as room for them, until it is larger.
        """
        super().execute(fig)
        for _ in range(AGAIN):
            if not self._is_outgrown(fig):
                break
            super().execute(fig)
        for axes in fig.axes:
            place = [round(x, PLACES) for x in axes.get_position(original=True).bounds]
            axes._set_position(place, which="original")  # type: ignore[attr-defined]

    def _is_outgrown(self, fig: Figure) -> bool:
        """Whether a panel with equal axes, or words about it, stand out of the place for panels."""
        _, low, _, high = self.get()["rect"]
        bottom, top = low * fig.bbox.height, (low + high) * fig.bbox.height
        boxes = [axes.get_tightbbox() for axes in fig.axes if axes.get_aspect() != "auto"]
        return any(box.y0 < bottom - 1.0 or box.y1 > top + 1.0 for box in boxes if box)


class Page(Figure):
    """A figure that looks the same wherever it is shown: ticks and formulas are made when drawn."""

    look: tuple[str | None, str | None] = (None, None)  # font and style
    caption = ""
    left_out: Sequence[str] = ()  # panels for which there was no room
    has_room = True  # for all of its panels, none of them smaller than it may be

    def draw(self, renderer: RendererBase) -> None:
        """Draw with the settings it was made with.

        A figure is saved in two drawings, of which the first is for its layout alone.
        """
        layout = self.get_layout_engine()
        with style.look(*self.look), _ticks_made_once(self.axes):
            if self.canvas.is_saving() and isinstance(layout, _Layout):
                layout.execute(self)
            else:
                super().draw(renderer)


class _Ticks:
    """The ticks of an axis and the boxes of their numbers, made anew where it has moved.

    They hang on the range of the axis and on the place of its panel in pixels. The methods stand
    in for those of matplotlib's axis of which they are made.
    """

    def __init__(self, axis: Any) -> None:
        self.axis = axis
        self._make = axis._update_ticks
        self._measure = axis._get_ticklabel_bboxes
        self._made_at: tuple[float, ...] = ()
        self._ticks: list[Any] = []
        self._boxes: tuple[list[Any], list[Any]] | None = None

    def ticks(self) -> list[Any]:
        """The ticks that are drawn, with their places and texts."""
        at = *self.axis.axes.bbox.bounds, *self.axis.get_view_interval()
        if at != self._made_at:
            self._ticks = self._make()
            self._boxes = None
            self._made_at = at
        return self._ticks

    def boxes(self, ticks: list[Any], renderer: RendererBase) -> tuple[list[Any], list[Any]]:
        """The boxes of the numbers on either side of the axis."""
        if ticks is not self._ticks:
            return self._measure(ticks, renderer)
        if self._boxes is None:
            self._boxes = self._measure(ticks, renderer)
        return self._boxes


@contextmanager
def _ticks_made_once(every: Sequence[Axes]) -> Iterator[None]:
    """Keep the ticks of all axes in the block, in which nobody changes how they are chosen.

    matplotlib makes them again whenever a panel, its title, a spine or a name beside it is
    measured, thirty times for each axis of a sweep, which is half of the time that drawing takes.
    """
    each: list[Any] = [axis for axes in every for axis in (axes.xaxis, axes.yaxis)]
    for axis in each:
        kept = _Ticks(axis)
        axis._update_ticks = kept.ticks
        axis._get_ticklabel_bboxes = kept.boxes
    try:
        yield
    finally:
        for axis in each:
            del axis._update_ticks
            del axis._get_ticklabel_bboxes


def _letters(panels: Sequence[Panel]) -> list[str]:
    """The letter of each panel, such as (a), in reading order; those of one column share it."""
    keys = [panel.column or str(place) for place, panel in enumerate(panels)]
    order = list(dict.fromkeys(keys))
    return [f"({ascii_lowercase[order.index(key) % len(ascii_lowercase)]})" for key in keys]


def _name(axes: Axes, letter: str) -> None:
    """Write the letter of a panel before what its title says at the left."""
    said = axes.get_title(loc="left")
    place: dict[str, Any] = {}
    if _numbered(axes) and not said:
        place = {"x": BESIDE, "ha": "right", "pad": ABOVE}
    axes.set_title(f"{letter} {said}" if said else letter, loc="left", size=8, **place)


def _calm_ticks(axes: Axes) -> None:
    """Ticks every 1, 2 or 5 of a power of ten where a panel has not chosen its own: never 2.5."""
    if type(axes.xaxis.get_major_locator()) is AutoLocator:
        axes.xaxis.set_major_locator(_Apart())
    if type(axes.yaxis.get_major_locator()) is AutoLocator:
        axes.yaxis.set_major_locator(MaxNLocator("auto", steps=CALM, min_n_ticks=FEWEST_TICKS))


class _Apart(MaxNLocator):
    """Ticks along an axis from left to right: as many as have room for their numbers."""

    def __init__(self) -> None:
        super().__init__(MOST_TICKS, steps=CALM, min_n_ticks=FEWEST_TICKS)

    def __call__(self) -> Any:
        """The ticks; called for anew once the axis is as wide as it is going to be."""
        for most in range(MOST_TICKS, 1, -1):
            self.set_params(nbins=most)
            ticks = super().__call__()
            if self._have_room(ticks):
                break
        return ticks

    def _have_room(self, ticks: Any) -> bool:
        """Whether the numbers of ticks are a letter apart at least."""
        axis: Any = self.axis
        axes = axis.axes
        low, high = axes.get_xlim()
        points = axes.get_window_extent().width * POINTS / axes.figure.dpi
        step = abs((ticks[1] - ticks[0]) / (high - low)) * points
        letters = max(map(len, axis.get_major_formatter().format_ticks(ticks))) + 1
        size = axis.get_major_ticks(1)[0].label1.get_size()
        return bool(letters * DIGIT * size <= step)


def _leave_out_scale(axes: Axes) -> None:
    """Of a curve beside a panel: its scale stands above the curves beside the first panel."""
    axes.tick_params(axis="x", top=False, labeltop=False)
    axes.set_title("", loc="center")
    axes.set_xlabel("")


def _numbered(axes: Axes) -> bool:
    """Whether a number of an event stands above the left end of a panel, where its letter is."""
    left, right = axes.get_xlim()
    above = (
        text for text in axes.texts
        if isinstance(text, Annotation) and text.arrow_patch and text.get_text()
    )  # fmt: skip
    return any(text.xyann[0] < left + CORNER * (right - left) for text in above)


def _fold_title(axes: Axes) -> None:
    """Break the words above the right end of a panel where they would meet what is beside them.

    That is the letter of the panel, or the words above the one beside it.
    """
    words = axes.get_title(loc="right")
    if not words or "$" in words:
        return
    width = axes._right_title.get_window_extent().width  # type: ignore[attr-defined]
    room = TITLED * axes.get_window_extent().width
    if width > room:
        chars = max(int(len(words) * room / width), 12)
        below = "\n" if words.endswith("\n") else ""  # room for what stands between
        axes.set_title("\n".join(_title_lines(words, chars)) + below, loc="right")


def _title_lines(title: str, chars: int) -> list[str]:
    """A title in lines of so many letters; numbers stay with their units, and ranges whole."""
    joined = WITH_UNIT.sub(UNBROKEN, title)
    lines = textwrap.wrap(joined, chars, break_on_hyphens=False)
    return [line.replace(UNBROKEN, " ") for line in lines]


def _count_of_rows(lists: Sequence[Rows]) -> int:
    """How many rows all lists have together."""
    return sum(len(rows) for rows in lists)


def _cut_to(rows: Rows, most: int) -> Rows:
    """A list of at most so many rows: the last one says how many more the tables have.

    Those with the most letters are left out first: motions with long names matter least, and no
    page has room for them.
    """
    if len(rows) <= most:
        return rows
    title = next(k for k, cell in enumerate(rows[0]) if cell != "")  # behind marks and numbers
    left_out = len(rows) - most + 1
    last = [*[""] * title, f"and {left_out} more, in the tables"]
    longest = sorted(range(1, len(rows)), key=lambda k: (_letters_of(rows[k]), k))[-left_out:]
    return [*(row for k, row in enumerate(rows) if k not in longest), last]


def _letters_of(row: Sequence[Cell]) -> int:
    """How many letters the words of a row have."""
    return sum(len(cell) for cell in row if isinstance(cell, str))


def _in_pairs(rows: Rows) -> Rows:
    """A list of marks with a few words each in half as many rows, the longer words at the left."""
    head, *others = rows
    for row in others:
        if len(row) != FEWEST or not isinstance(row[1], str):
            return rows
    longest_first = sorted(others, key=lambda row: -len(str(row[1])))
    half = (len(longest_first) + 1) // 2
    left, right = longest_first[:half], longest_first[half:]
    if len(right) < half:
        right.append(["", ""])
    pairs = [[*a, *b] for a, b in zip(left, right, strict=True)]
    return [head, *pairs]


def _folded(row: Sequence[Cell], most: int) -> list[Sequence[Cell]]:
    """A row of a list without its last words, and these below it."""
    return [row[:-1], ["", "", row[-1]]] if len(row) == most and row[-1] else [row]


def _height(rows: list[Row], form: Plot) -> float:
    """The height of the panels of all rows, mm, each row as high as its highest panel."""
    height = 0.0
    for row in rows:
        wide = form.width / len(row)
        height += max(min(panel.height, panel.shape * wide) for _, panel in row)
    return height


def _above(rows: list[Row]) -> float:
    """The height that the legends above the panels of all rows take, mm."""
    return sum(max(panel.above for _, panel in row) for row in rows)


def _least(rows: list[Row], form: Plot) -> float:
    """What the rows need at least, mm."""
    shared = sum(_shared(rows))
    return (
        SQUEEZED * _height(rows, form)
        + _above(rows)
        + BELOW * (len(rows) - shared)
        + LETTER * shared
    )


def _shared(rows: list[Row]) -> list[bool]:
    """Of each row but the last whether the row below has its numbers and names."""
    shared = []
    for upper, lower in pairwise(rows):
        axes = {panel.x for _, panel in (*upper, *lower)}
        shared.append(len(upper) == len(lower) and len(axes) == 1 and axes != {""})
    return shared


def _least_asked(rows: list[Row]) -> Row:
    """The last row without a panel that was asked for; the last one where all have one."""
    free = [row for row in rows[1:] if not any(panel.asked for _, panel in row)]
    return (free or rows)[-1]


def _rows(panels: dict[str, Panel], width: float) -> list[Row]:
    """Panels from top to bottom, narrow ones side by side where there is room; width: mm."""
    rows: list[Row] = []
    for name, panel in panels.items():
        least = NARROWER if panel.y else NARROWEST
        most = min(panel.across, max(1, int(width / least)))
        if rows and panel.across == rows[-1][0][1].across and most > len(rows[-1]):
            rows[-1].append((name, panel))
        else:
            rows.append([(name, panel)])
    return rows


class _Heading:
    """Title, words, lists and legend from the top downwards, in axes that count mm."""

    def __init__(self, axes: Axes, picture: Picture, form: Plot, tallest: float) -> None:
        """tallest: of the page, mm."""
        self.axes = axes
        self.top = EDGE
        self.wide = form.width
        axes.set(xlim=(0.0, form.width), ylim=(1.0, 0.0))
        axes.set_axis_off()
        chars = int(CHARS * form.width)
        title = _title_lines(picture.title, int(0.8 * chars)) if form.title else []
        if any(self._is_wide(line, **BOLD) for line in title):
            title = _title_lines(picture.title, int(0.7 * chars))
        for line in title:
            self._write(EDGE, line, **BOLD)
            self.top += 1.3 * LINE
        words = [
            line
            for paragraph in picture.words.splitlines()
            for line in _title_lines(paragraph, chars)
        ]
        if form.title:
            for line in words:
                self._write(EDGE, line, color=picture.colour)
                self.top += LINE
            if words and picture.lists:
                self.top += SPACE
        left = EDGE
        below = self.top
        for rows in self._listed(picture.lists, tallest):
            right = self._list(left, rows)
            if right > self.wide + SPACE and left > EDGE:
                self._undo()
                self.top = below + SPACE
                right = self._list(EDGE, rows)
            if right > self.wide + SPACE:  # the last words of each row below it
                self._undo()
                most = max(map(len, rows))
                if most > FEWEST:
                    rows = [part for row in rows for part in _folded(row, most)]
                right = self._list(EDGE, rows)
                self._shorten()
            left = right
            below = max(below, self.top + ROW * len(rows))
        self.top = below

    def _listed(self, lists: Sequence[Rows], tallest: float) -> list[Rows]:
        """The lists, cut so that panels have room; in a column of a journal only the longest is.

        tallest: height that the page may have, mm.
        """
        shown = [rows for rows in lists if rows]
        if self.wide > COLUMN or not shown:
            return [_cut_to(rows, MOST_ROWS) for rows in shown]
        head = shown[0][0]
        if all(rows[0] == head for rows in shown):  # parts of one list, set side by side elsewhere
            joined = [head]
            for rows in shown:
                joined += rows[1:]
            shown = [joined]
        most = int((LISTED * tallest - self.top) / ROW)  # rows of all lists
        if _count_of_rows(shown) <= most:
            return shown

        longest = max(range(len(shown)), key=lambda k: len(shown[k]))
        for k in range(len(shown)):
            if k != longest:
                shown[k] = _in_pairs(shown[k])
        others = _count_of_rows(shown) - len(shown[longest])
        shown[longest] = _cut_to(shown[longest], max(most - others, FEWEST_ROWS))
        return shown

    def _is_wide(self, line: str, **look: Any) -> bool:
        """Whether a line of words is wider than the page."""
        text = self._write(EDGE, line, **look)
        right = EDGE + text.get_window_extent().width / style.DPI / MM
        text.remove()
        return right > self.wide

    def _undo(self) -> None:
        """Take back the last list."""
        for artist in self.last:
            artist.remove()

    def _write(self, left: float, text: str, row: int = 0, **more: Any) -> Text:
        middle = self.top + ROW * (row + 0.5)
        return self.axes.text(left, middle, text, va="center_baseline", **more)

    def _list(self, left: float, rows: Rows) -> float:
        """A list with columns as wide as their words; its right end, and `last` its artists."""
        self.last: list[Artist] = []
        title_ends = left
        most = max(map(len, rows))
        for column in range(most):
            ends = [left]
            for row, cells in enumerate(rows):
                cell = cells[column] if column < len(cells) else ""
                if isinstance(cell, str):
                    colour = style.CAM if row == 0 else "black"
                    text = self._write(left, cell, row, color=colour, size=style.NOTE)
                    self.last.append(text)
                    end = left + text.get_window_extent().width / style.DPI / MM
                    # a title over all columns, or words below a row that was too wide
                    if column == len(cells) - 1 < most - 1:
                        title_ends = max(title_ends, end)
                        continue
                    ends.append(end)
                else:
                    middle = self.top + ROW * (row + 0.5)
                    alone = cell.get("ls") == "None"
                    x = [left + SAMPLE / 2.0] if alone else [left, left + SAMPLE]
                    self.last += self.axes.plot(x, [middle] * len(x), **cell)
                    ends.append(left + SAMPLE)
            if max(ends) > left:
                left = max(ends) + SPACE
        return max(left, title_ends + SPACE) + SPACE

    def _shorten(self) -> None:
        """End the words of the last list where the page does."""
        for text in self.last:
            if not isinstance(text, Text) or "$" in text.get_text():
                continue
            room = (self.wide - EDGE - text.get_position()[0]) * MM * style.DPI
            words = text.get_text()
            while len(words) > 1 and text.get_window_extent().width > room:
                words = words[:-1]
                text.set_text(f"{words.rstrip()}…")

    def finish(self, handles: dict[str, Any]) -> float:
        """The legend, in as many columns as there is room for; the height of all in mm."""
        columns_of_rows = {ceil(len(handles) / rows) for rows in range(1, len(handles) + 1)}
        for columns in sorted(columns_of_rows, reverse=True):
            legend = self.axes.legend(
                handles.values(),
                handles.keys(),
                loc="upper left",
                bbox_to_anchor=(EDGE, self.top + 1.0),
                bbox_transform=self.axes.transData,
                ncols=columns,
            )
            room = (self.wide - 2.0 * EDGE) * MM * style.DPI
            box = legend.get_window_extent()
            if columns == 1 and box.width > room:
                chars = int(0.8 * CHARS * self.wide)
                for text in legend.get_texts():
                    text.set_text(textwrap.fill(text.get_text(), chars))
                box = legend.get_window_extent()
            if columns == 1 or box.width < room:
                self.top += box.height / style.DPI / MM + 1.0
                break
        self.axes.set_ylim(self.top, 0.0)
        return self.top
