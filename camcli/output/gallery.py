"""index.html: every figure with its scene, command, numbers and cost.

Plain HTML (`gallery.html`) without scripts and without anything from elsewhere; pictures beside it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any
from urllib.parse import quote

MOST_ROWS, MOST_COLUMNS = 20, 10


@dataclass(frozen=True)
class Picture:
    """One figure as the page shows it; without `files` it is not computed yet."""

    name: str
    title: str
    shows: str
    command: str
    scene: str
    folder: Path
    files: Sequence[str] = ()
    seconds: float = 0.0
    notes: Sequence[str] = ()

    @property
    def heading(self) -> str:
        """Number and title, as HTML."""
        return escape(f"{self.name} {self.title}")

    @property
    def id(self) -> str:
        """Its place in the page."""
        return "figure-" + re.sub(r"[^A-Za-z0-9-]", "-", self.name)


def page(pictures: Sequence[Picture]) -> str:
    """The page."""
    template = Template((files("camcli.output") / "gallery.html").read_text(encoding="utf-8"))
    contents = "".join(f'<li><a href="#{p.id}">{p.heading}</a></li>\n' for p in pictures)
    return template.substitute(contents=contents, figures="".join(map(_article, pictures)))


def _article(p: Picture) -> str:
    pngs = [file for file in p.files if file.endswith(".png")]
    none = "This command draws no picture." if p.files else "Not computed yet."
    shown = "".join(_figure(p, file) for file in pngs) or f"<p>{none}</p>\n"
    label = escape(f"Scene of {p.name}")
    return f"""<article id="{p.id}" aria-labelledby="{p.id}-title">
<h2 id="{p.id}-title">{p.heading}</h2>
{shown}<pre class="command"><code>{escape(p.command)}</code></pre>
{_html(list(p.notes), "", "")}{_numbers(p) if p.files else ""}<details>
<summary>Scene</summary>
<pre role="group" aria-label="{label}" tabindex="0"><code>{escape(p.scene)}</code></pre>
</details>
</article>
"""


def _figure(p: Picture, file: str) -> str:
    try:
        with open(p.folder / file, "rb") as png:
            head = png.read(24)
    except OSError:
        head = b""
    wide, high = (int.from_bytes(head[k : k + 4], "big") for k in (16, 20))
    source = quote(f"{p.name}/{file}")
    return f"""<figure>
<a href="{source}"><img src="{source}" width="{wide}" height="{high}" loading="lazy"
alt="{p.heading}, opens the picture"></a>
<figcaption>{escape(p.shows)}</figcaption>
</figure>
"""


def _numbers(p: Picture) -> str:
    """What its run.json says, links to its files, and its cost."""
    try:
        record = json.loads((p.folder / "run.json").read_text(encoding="utf-8"))
        cost = record["cost"]
        counted = f"{cost['impacts']} impacts, {cost['gap_evaluations']} gap evaluations, "
    except (OSError, ValueError, LookupError, TypeError):  # of another program, or damaged
        record, counted = {"result": {}}, ""
    links = [f'<a href="{quote(f"{p.name}/{file}")}">{escape(file)}</a>' for file in p.files]
    return f"""<details>
<summary>Numbers and files</summary>
{_html(record.get("result"), "numbers", p.name)}<p>Files: {", ".join(links)}</p>
</details>
<p>Cost: {counted}{p.seconds:.1f} s with start and drawing.</p>
"""


def _html(value: Any, name: str, figure: str) -> str:
    """A value of run.json: maps as lists of terms, lists of maps as tables, other lists as such."""
    if isinstance(value, Mapping):
        inner = {k.replace("_", " "): v for k, v in value.items() if v not in (None, [], {}, "")}
        rows = [f"<dt>{escape(k)}</dt><dd>{_html(v, k, figure)}</dd>\n" for k, v in inner.items()]
        return f"<dl>\n{''.join(rows)}</dl>\n" if rows else ""
    if isinstance(value, list) and value and isinstance(value[0], Mapping):
        return _table(value, f"{name} of {figure}")
    if isinstance(value, list):
        items = [f"<li>{escape(_text(item))}</li>\n" for item in value[:MOST_ROWS]]
        return f"<ul>\n{''.join(items)}</ul>\n" if items else ""
    return escape(_text(value))


def _table(rows: Sequence[Mapping[str, Any]], label: str) -> str:
    keys = list(dict.fromkeys(k for row in rows for k, v in row.items() if _is_plain(v)))
    lines = [[_text(row.get(key)) for key in keys[:MOST_COLUMNS]] for row in rows[:MOST_ROWS]]
    head = [f'<th scope="col">{escape(k.replace("_", " "))}</th>' for k in keys[:MOST_COLUMNS]]
    body = ["".join(f"<td>{escape(cell)}</td>" for cell in line) for line in lines]
    cut = f"<p>The first {MOST_ROWS} of {len(rows)}, all of them in run.json.</p>\n"
    return f"""<div class="wide" role="group" aria-label="{escape(label)}" tabindex="0"><table>
<thead><tr>{"".join(head)}</tr></thead>
<tbody>{"".join(f"<tr>{line}</tr>" for line in body)}</tbody>
</table></div>
{cut if len(rows) > MOST_ROWS else ""}"""


def _is_plain(value: Any) -> bool:
    if isinstance(value, list):
        return len(value) <= 6 and not any(isinstance(x, list | Mapping) for x in value)
    return not isinstance(value, Mapping)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    return "" if value is None else f"{value:.12g}" if isinstance(value, float) else str(value)
