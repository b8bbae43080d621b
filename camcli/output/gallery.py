"""index.html: every figure with its scene, command, numbers and cost.

Plain HTML (`gallery.html`) without scripts and without anything from elsewhere; pictures beside it.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

from camcli.errors import plural
from camcli.output.certificate_check import PROOF, CheckedCertificate
from camcli.output.pictures import caption_in

MOST_ROWS, MOST_COLUMNS = 20, 10
UNNUMBERED = "Without a number"  # the heading of figures whose names do not begin with one
OPENING = "3.6e"  # the picture above all others, where it is drawn: the sweep of the README


@dataclass(frozen=True)
class GalleryFigure:
    """One figure as the page shows it; without `files` it is not computed yet."""

    name: str
    title: str
    caption: str
    command: str
    scene: str
    folder: Path
    files: Sequence[str] = ()
    seconds: float = 0.0
    notes: Sequence[str] = ()
    certificate: CheckedCertificate | None = None
    # a number printed in the book, and what was computed for it, by what it is
    printed: Mapping[str, tuple[float, Any]] = field(default_factory=dict)

    @property
    def heading(self) -> str:
        """Number, where its name is one, and title, as HTML."""
        return escape(f"{self.name} {self.title}" if self.is_numbered else self.title)

    @property
    def is_numbered(self) -> bool:
        """Whether its name is a number, as 3.6a."""
        return self.name[:1].isdigit()

    @property
    def id(self) -> str:
        """Its place in the page."""
        return "figure-" + re.sub(r"[^A-Za-z0-9-]", "-", self.name)

    @property
    def pictures(self) -> list[str]:
        """Its pictures, as links."""
        return [quote(f"{self.name}/{file}") for file in self.files if file.endswith(".png")]


def page(figures: Sequence[GalleryFigure]) -> str:
    """The whole page: contents, the first picture, and an article for each figure.

    Figures with a number come first, else in the order given.
    """
    figures = sorted(figures, key=lambda figure: not figure.is_numbered)
    template = Template((files("camcli.output") / "gallery.html").read_text(encoding="utf-8"))
    contents = ""
    for name, members in groupby(figures, _group):
        thumbnails = "".join(map(_thumbnail, members))
        contents += f"<section>\n<h2>{escape(name)}</h2>\n<ul>\n{thumbnails}</ul>\n</section>\n"
    drawn = [figure for figure in figures if figure.pictures]
    opening = next((figure for figure in drawn if figure.name == OPENING), None)
    if opening is None and drawn:
        opening = drawn[0]
    first = f"{_image(opening, opening.pictures[0])}\n" if opening else ""
    articles = "".join(map(_article, figures))
    return template.substitute(contents=contents, first=first, figures=articles)


def _group(figure: GalleryFigure) -> str:
    """The heading under which a figure is listed: 3.6 of the figures 3.6a and 3.6b."""
    return re.sub(r"(?<=\d)[a-z]$", "", figure.name) if figure.is_numbered else UNNUMBERED


def _thumbnail(figure: GalleryFigure) -> str:
    """The figure in the list at the top of the page: a small picture and its heading."""
    image = f'<img src="{figure.pictures[0]}" loading="lazy" alt="">' if figure.pictures else ""
    return f'<li><a href="#{figure.id}">{image}{figure.heading}</a></li>\n'


def _article(figure: GalleryFigure) -> str:
    """The figure with all that belongs to it: pictures, command, notes, numbers, scene."""
    pages = [quote(f"{figure.name}/{file}") for file in figure.files if file.endswith(".html")]
    words = escape(figure.caption or figure.title)
    shown = "".join(_figure(figure, source) for source in figure.pictures)
    shown += "".join(f'<p>{words} <a href="{link}">Open the page</a></p>\n' for link in pages)
    if not shown:
        reason = "This command draws no picture." if figure.files else "Not computed yet."
        shown = f"<p>{reason}</p>\n"
    notes = _html(list(figure.notes), "", "")
    numbers = _numbers(figure) if figure.files else ""
    label = escape(f"Scene of {figure.name}")
    scene = escape(figure.scene)
    return f"""<article id="{figure.id}" aria-labelledby="{figure.id}-title">
<h2 id="{figure.id}-title">{figure.heading}</h2>
{shown}<pre class="command"><code>{escape(figure.command)}</code></pre>
{notes}{_certified(figure)}{_printed(figure)}{numbers}<details>
<summary>Scene</summary>
<pre role="group" aria-label="{label}" tabindex="0"><code>{scene}</code></pre>
</details>
</article>
"""


def _image(figure: GalleryFigure, source: str) -> str:
    """A picture with its size and its caption in words; source: the link to its PNG."""
    try:
        with open(figure.folder / Path(source).name, "rb") as png:
            head = png.read(24)
    except OSError:
        head = b""
    width = int.from_bytes(head[16:20], "big")  # pixels; 0 where the file is not there
    height = int.from_bytes(head[20:24], "big")
    words = escape(figure.caption or figure.title)
    return f'<img src="{source}" width="{width}" height="{height}" loading="lazy"\nalt="{words}">'


def _figure(figure: GalleryFigure, source: str) -> str:
    """A picture with its caption beneath it: what it shows, and how that was computed."""
    how_computed = caption_in(figure.folder / Path(source).name)
    words = figure.caption or figure.title
    caption = f"{words} {how_computed}" if how_computed else words
    return f"""<figure>
<a href="{source}">{_image(figure, source)}</a>
<figcaption>{escape(caption)}</figcaption>
</figure>
"""


def _certified(figure: GalleryFigure) -> str:
    """A link to the certificate, its size, and what its checker said of it in which time.

    The checker's last line counts what it confirmed; those before it have many digits.
    """
    checked = figure.certificate
    if checked is None:
        return ""
    link = quote(f"{figure.name}/{PROOF}")
    size = f"{max(1, round(checked.bytes / 1000)):,} kB"
    *statements, last = checked.lines or ["nothing"]
    said = f"""<p>Certificate: <a href="{link}" download>{PROOF}</a> ({size}). Its checker said in
{checked.seconds:.1f} s: {escape(last)}.</p>
"""
    if not statements:
        return said
    return f"""{said}<details>
<summary>What it said of each statement</summary>
<ul>
{_tagged("li", statements)}</ul>
</details>
"""


def _printed(figure: GalleryFigure) -> str:
    """Numbers printed in the book beside what was computed."""
    rows = [
        {"number": name, "printed": printed, "computed": computed}
        for name, (printed, computed) in figure.printed.items()
    ]
    return _table(rows, f"Printed numbers of {figure.name}") if rows else ""


def _numbers(figure: GalleryFigure) -> str:
    """The numbers of a figure's run.json, links to its files, and its cost, in HTML."""
    result: Any = {}
    counted = ""
    not_kept = ""
    # the run.json of another program, or a damaged one, costs its own numbers alone
    with suppress(OSError, ValueError, LookupError, TypeError, RecursionError):
        record = json.loads((figure.folder / "run.json").read_text(encoding="utf-8"))
        cost = record["cost"]
        impacts = plural(cost["impacts"], "impact")
        evaluations = plural(cost["gap_evaluations"], "gap evaluation")
        not_kept = ", ".join(sorted({*record.get("artefacts", ())} - {*figure.files}))
        counted = f"{impacts}, {evaluations}, "
        result = record.get("result")
    links = [
        f'<a href="{quote(f"{figure.name}/{file}")}">{escape(file)}</a>' for file in figure.files
    ]
    too_large = ""
    if not_kept:
        too_large = f"; the command also writes {escape(not_kept)}, too large to be kept"
    return f"""<details>
<summary>Numbers and files</summary>
{_html(result, "numbers", figure.name)}<p>Files: {", ".join(links)}{too_large}</p>
</details>
<p>Cost: {counted}{figure.seconds:.1f} s with start and drawing.</p>
"""


def _html(value: Any, name: str, figure: str) -> str:
    """A value of run.json: maps as lists of terms, lists of maps as tables, other lists as such.

    name: of the value; figure: to which it belongs. Entries without content are left out.
    """
    if isinstance(value, Mapping):
        rows = ""
        for key, entry in value.items():
            if entry not in (None, [], {}, ""):
                term = key.replace("_", " ")
                rows += f"<dt>{escape(term)}</dt><dd>{_html(entry, term, figure)}</dd>\n"
        return f"<dl>\n{rows}</dl>\n" if rows else ""
    if isinstance(value, list) and value and all(isinstance(row, Mapping) for row in value):
        return _table(value, f"{name} of {figure}")
    if isinstance(value, list):
        items = _tagged("li", map(_text, value[:MOST_ROWS]))
        return f"<ul>\n{items}</ul>\n" if items else ""
    return escape(_text(value))


def _table(rows: Sequence[Mapping[str, Any]], label: str) -> str:
    """Maps as a table in HTML; label: its name for those who do not see it.

    The columns are the keys with plain values, MOST_COLUMNS of them; MOST_ROWS rows are shown.
    """
    plain_keys: list[str] = []
    for row in rows:
        for key, value in row.items():
            if _is_plain(value) and key not in plain_keys:
                plain_keys.append(key)
    keys = plain_keys[:MOST_COLUMNS]
    head = _tagged('th scope="col"', [key.replace("_", " ") for key in keys])
    body = [_tagged("td", [_text(row.get(key)) for key in keys]) for row in rows[:MOST_ROWS]]
    cut = f"<p>The first {MOST_ROWS} of {len(rows)}, all of them in run.json.</p>\n"
    return f"""<div class="wide" role="group" aria-label="{escape(label)}" tabindex="0"><table>
<thead><tr>{head}</tr></thead>
<tbody>{"".join(f"<tr>{line}</tr>" for line in body)}</tbody>
</table></div>
{cut if len(rows) > MOST_ROWS else ""}"""


def _tagged(tag: str, texts: Iterable[str]) -> str:
    """Each text between this tag, which may have attributes."""
    return "".join(f"<{tag}>{escape(text)}</{tag.split()[0]}>" for text in texts)


def _is_plain(value: Any) -> bool:
    """Whether a value fits a cell: no map, and no long or nested list."""
    if isinstance(value, list):
        return len(value) <= 6 and not any(isinstance(x, list | Mapping) for x in value)
    return not isinstance(value, Mapping)


def _text(value: Any) -> str:
    """A value as text: numbers to twelve digits, lists with commas, yes or no; nothing for None."""
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.12g}" if isinstance(value, float) else str(value)
