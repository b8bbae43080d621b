"""index.html: every figure with its scene, command, numbers and cost.

Plain HTML (`gallery.html`) without scripts and without anything from elsewhere; pictures beside it.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from itertools import groupby
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

from camcli.output.certificate_check import PROOF, CheckedCertificate
from camcli.output.pictures import caption_in

MOST_ROWS, MOST_COLUMNS = 20, 10
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
    printed: Mapping[str, tuple[float, Any]] = field(default_factory=dict)  # and what was computed

    @property
    def heading(self) -> str:
        """Number, where its name is one, and title, as HTML."""
        return escape(f"{self.name} {self.title}" if self.name[:1].isdigit() else self.title)

    @property
    def id(self) -> str:
        """Its place in the page."""
        return "figure-" + re.sub(r"[^A-Za-z0-9-]", "-", self.name)

    @property
    def pictures(self) -> list[str]:
        """Its pictures, as links."""
        return [quote(f"{self.name}/{file}") for file in self.files if file.endswith(".png")]


def page(figures: Sequence[GalleryFigure]) -> str:
    """The whole page: contents, the first picture, and an article for each figure."""
    template = Template((files("camcli.output") / "gallery.html").read_text(encoding="utf-8"))
    groups = groupby(figures, lambda p: re.sub(r"(?<=\d)[a-z]$", "", p.name))
    contents = "".join(
        f"<section>\n<h2>{escape(name)}</h2>\n<ul>\n{''.join(map(_thumbnail, members))}</ul>\n"
        "</section>\n"
        for name, members in groups
    )
    drawn = [p for p in figures if p.pictures]
    opening = next((p for p in drawn if p.name == OPENING), drawn[0] if drawn else None)
    first = f"{_image(opening, opening.pictures[0])}\n" if opening else ""
    articles = "".join(map(_article, figures))
    return template.substitute(contents=contents, first=first, figures=articles)


def _thumbnail(p: GalleryFigure) -> str:
    """The figure in the list at the top of the page: a small picture and its heading."""
    image = f'<img src="{p.pictures[0]}" loading="lazy" alt="">' if p.pictures else ""
    return f'<li><a href="#{p.id}">{image}{p.heading}</a></li>\n'


def _article(p: GalleryFigure) -> str:
    """The figure with all that belongs to it: pictures, command, notes, numbers, scene."""
    none = "This command draws no picture." if p.files else "Not computed yet."
    pages = [quote(f"{p.name}/{file}") for file in p.files if file.endswith(".html")]
    words = escape(p.caption or p.title)
    shown = "".join(_figure(p, source) for source in p.pictures)
    shown += "".join(f'<p>{words} <a href="{link}">Open the page</a></p>\n' for link in pages)
    shown = shown or f"<p>{none}</p>\n"
    label = escape(f"Scene of {p.name}")
    return f"""<article id="{p.id}" aria-labelledby="{p.id}-title">
<h2 id="{p.id}-title">{p.heading}</h2>
{shown}<pre class="command"><code>{escape(p.command)}</code></pre>
{_html(list(p.notes), "", "")}{_certified(p)}{_printed(p)}{_numbers(p) if p.files else ""}<details>
<summary>Scene</summary>
<pre role="group" aria-label="{label}" tabindex="0"><code>{escape(p.scene)}</code></pre>
</details>
</article>
"""


def _image(p: GalleryFigure, source: str) -> str:
    """A picture with its size and its caption in words."""
    try:
        with open(p.folder / Path(source).name, "rb") as png:
            head = png.read(24)
    except OSError:
        head = b""
    wide, high = (int.from_bytes(head[k : k + 4], "big") for k in (16, 20))
    words = escape(p.caption or p.title)
    return f'<img src="{source}" width="{wide}" height="{high}" loading="lazy"\nalt="{words}">'


def _figure(p: GalleryFigure, source: str) -> str:
    """A picture with its caption beneath it: what it shows, and how that was computed."""
    how = caption_in(p.folder / Path(source).name)
    return f"""<figure>
<a href="{source}">{_image(p, source)}</a>
<figcaption>{escape(" ".join(filter(None, (p.caption or p.title, how))))}</figcaption>
</figure>
"""


def _certified(p: GalleryFigure) -> str:
    """A link to the certificate, its size, and what its checker said of it in which time."""
    made = p.certificate
    if made is None:
        return ""
    link = quote(f"{p.name}/{PROOF}")
    size = f"{max(1, round(made.bytes / 1000)):,} kB"
    return f"""<p>Certificate: <a href="{link}" download>{PROOF}</a> ({size}). Its checker said in
{made.seconds:.1f} s:</p>
<ul>
{_tagged("li", made.lines)}</ul>
"""


def _printed(p: GalleryFigure) -> str:
    """Printed numbers beside what was computed."""
    columns = ("number", "printed", "computed")
    rows = [dict(zip(columns, (n, *pair), strict=True)) for n, pair in p.printed.items()]
    return _table(rows, f"Printed numbers of {p.name}") if rows else ""


def _numbers(p: GalleryFigure) -> str:
    """The numbers of a figure's run.json, links to its files, and its cost, in HTML."""
    try:
        path = p.folder / "run.json"
        record = json.loads(path.read_text(encoding="utf-8") if path.is_file() else "{}")
        cost = record["cost"]
        counted = f"{cost['impacts']} impacts, {cost['gap_evaluations']} gap evaluations, "
        gone = ", ".join(sorted({*record.get("artefacts", ())} - {*p.files}))
    except (OSError, ValueError, LookupError, TypeError, RecursionError):  # another's, or damaged
        record = {"result": {}}
        counted = ""
        gone = ""
    links = [f'<a href="{quote(f"{p.name}/{file}")}">{escape(file)}</a>' for file in p.files]
    made = f"; the command also writes {escape(gone)}, too large to be kept" if gone else ""
    return f"""<details>
<summary>Numbers and files</summary>
{_html(record.get("result"), "numbers", p.name)}<p>Files: {", ".join(links)}{made}</p>
</details>
<p>Cost: {counted}{p.seconds:.1f} s with start and drawing.</p>
"""


def _html(value: Any, name: str, figure: str) -> str:
    """A value of run.json: maps as lists of terms, lists of maps as tables, other lists as such."""
    if isinstance(value, Mapping):
        inner = {k.replace("_", " "): v for k, v in value.items() if v not in (None, [], {}, "")}
        rows = [f"<dt>{escape(k)}</dt><dd>{_html(v, k, figure)}</dd>\n" for k, v in inner.items()]
        return f"<dl>\n{''.join(rows)}</dl>\n" if rows else ""
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
    every = dict.fromkeys(k for row in rows for k, v in row.items() if _is_plain(v))
    keys = list(every)[:MOST_COLUMNS]
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
    """A value as text: numbers to twelve digits, lists with commas, nothing for None."""
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    if value is None:
        return ""
    return f"{value:.12g}" if isinstance(value, float) else str(value)
