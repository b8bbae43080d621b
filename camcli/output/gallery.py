"""index.html: every figure with its scene, command, numbers and cost.

Plain HTML without scripts and without anything from elsewhere; pictures lie beside it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

MOST_ROWS, MOST_COLUMNS = 20, 10
STYLE = """
:root { color-scheme: light dark; --line: #8885; }
body { font: 1rem/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 75rem; padding: 1rem; }
h1, h2, h3 { line-height: 1.25; }
.skip { position: absolute; left: -99rem; }
.skip:focus { position: static; }
:focus-visible { outline: 3px solid #0072B2; outline-offset: 2px; }
nav ul { columns: 22rem; padding-left: 1.2rem; }
article { border-top: 1px solid var(--line); margin-top: 2rem; }
figure { margin: 1rem 0; max-width: 54rem; }
figure a { display: block; scroll-margin: 1rem; width: fit-content; }
img { background: white; display: block; height: auto; max-width: 100%; }
figcaption { margin-top: .5rem; }
pre.command { overflow-wrap: anywhere; white-space: pre-wrap; }
pre, .wide { border: 1px solid var(--line); overflow-x: auto; padding: .5rem; }
code { font-size: .9rem; }
table { border-collapse: collapse; font-size: .9rem; }
th, td { border-bottom: 1px solid var(--line); padding: .15rem .6rem; text-align: left; }
dl { display: grid; gap: 0 1rem; grid-template-columns: max-content 1fr; }
dd { margin: 0; }
"""


@dataclass(frozen=True)
class Picture:
    """One figure as the page shows it; `files` and `record` are empty before it is computed."""

    name: str
    title: str
    shows: str
    command: str
    scene: str
    folder: Path
    files: Mapping[str, int]
    seconds: float | None
    notes: Sequence[str]
    record: Mapping[str, Any]


def page(pictures: Sequence[Picture]) -> Iterator[str]:
    """The page in pieces."""
    yield '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
    yield f"<title>Figures of the chapter</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
    yield '<a class="skip" href="#figures">Skip to the figures</a>\n'
    yield "<header>\n<h1>Figures of the chapter</h1>\n"
    yield "<p>Made by <code>cam figures</code>, each by the command that stands with it.</p>\n"
    yield '<nav aria-label="Figures">\n<ul>\n'
    for picture in pictures:
        yield f'<li><a href="#{_id(picture)}">{escape(_heading(picture))}</a></li>\n'
    yield '</ul>\n</nav>\n</header>\n<main id="figures" tabindex="-1">\n'
    for picture in pictures:
        yield from _article(picture)
    yield "</main>\n</body>\n</html>\n"


def _id(picture: Picture) -> str:
    return "figure-" + re.sub(r"[^A-Za-z0-9-]", "-", picture.name)


def _heading(picture: Picture) -> str:
    return f"{picture.name} {picture.title}"


def _article(picture: Picture) -> Iterator[str]:
    name = _id(picture)
    yield f'<article id="{name}" aria-labelledby="{name}-title">\n'
    yield f'<h2 id="{name}-title">{escape(_heading(picture))}</h2>\n'
    pngs = [file for file in picture.files if file.endswith(".png")]
    for file in pngs:
        alt = f"{_heading(picture)}, opens the picture"  # the caption says what it shows
        wide, high = _size(picture.folder / file)
        source = quote(f"{picture.name}/{file}")
        yield f'<figure>\n<a href="{source}"><img src="{source}" width="{wide}" height="{high}" '
        yield f'alt="{escape(alt)}" loading="lazy"></a>\n'
        yield f"<figcaption>{escape(picture.shows)}</figcaption>\n</figure>\n"
    if not picture.files:
        yield "<p>Not computed yet.</p>\n"
    elif not pngs:
        yield "<p>This command draws no picture.</p>\n"
    yield f'<pre class="command"><code>{escape(picture.command)}</code></pre>\n'
    if picture.notes:
        yield "<ul>\n" + "".join(f"<li>{escape(note)}</li>\n" for note in picture.notes) + "</ul>\n"
    yield from _numbers(picture)
    yield "<details>\n<summary>Scene</summary>\n"
    label = escape(f"Scene of {picture.name}")
    yield f'<pre role="group" aria-label="{label}" tabindex="0"><code>{escape(picture.scene)}'
    yield "</code></pre>\n</details>\n</article>\n"


def _numbers(picture: Picture) -> Iterator[str]:
    record = picture.record
    if not record:
        return
    yield "<details>\n<summary>Numbers and files</summary>\n"
    yield from _value("", record.get("result"), 3, picture.name)
    links = [f'<a href="{quote(f"{picture.name}/{f}")}">{escape(f)}</a>' for f in picture.files]
    yield f"<h3>Files</h3>\n<p>{', '.join(links)}</p>\n</details>\n"
    cost = record.get("cost") or {}
    counted = f"{cost.get('impacts', 0)} impacts, {cost.get('gap_evaluations', 0)} gap evaluations"
    took = "" if picture.seconds is None else f", {picture.seconds:.1f} s with start and drawing"
    yield f"<p>Cost: {counted}{took}.</p>\n"


def _value(title: str, value: Any, level: int, name: str) -> Iterator[str]:
    """A value of run.json: scalars as a list of terms, lists of maps as tables."""
    if isinstance(value, Mapping):
        if title:
            yield f"<h{level}>{escape(title)}</h{level}>\n"
        value = {k: v for k, v in value.items() if v not in (None, [], {}, "")}
        plain = {k: v for k, v in value.items() if _is_plain(v)}
        if plain:
            rows = [f"<dt>{_words(k)}</dt><dd>{_cell(v)}</dd>\n" for k, v in plain.items()]
            yield f"<dl>\n{''.join(rows)}</dl>\n"
        for key, inner in value.items():
            if key not in plain:
                deeper = min(level + bool(title), 6)
                yield from _value(key.replace("_", " "), inner, deeper, name)
    elif isinstance(value, list) and value:
        yield f"<h{level}>{escape(title)}</h{level}>\n"
        label = f"{title} of {name}"
        yield from _table(label, value) if isinstance(value[0], Mapping) else _list(value)


def _table(label: str, rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    keys = list(dict.fromkeys(k for row in rows for k, v in row.items() if _is_plain(v)))
    keys = keys[:MOST_COLUMNS]
    yield f'<div class="wide" role="group" aria-label="{escape(label)}" tabindex="0"><table>\n'
    yield "<thead><tr>"
    yield (
        "".join(f'<th scope="col">{_words(key)}</th>' for key in keys) + "</tr></thead>\n<tbody>\n"
    )
    for row in rows[:MOST_ROWS]:
        cells = (row.get(key) for key in keys)
        yield "<tr>" + "".join(f"<td>{_cell(value)}</td>" for value in cells) + "</tr>\n"
    yield "</tbody></table></div>\n"
    if len(rows) > MOST_ROWS:
        yield f"<p>The first {MOST_ROWS} of {len(rows)}, all of them in run.json.</p>\n"


def _list(values: Sequence[Any]) -> Iterator[str]:
    items = [f"<li>{_cell(value)}</li>\n" for value in values[:MOST_ROWS]]
    yield f"<ul>\n{''.join(items)}</ul>\n"


def _is_plain(value: Any) -> bool:
    if isinstance(value, list):
        return len(value) <= 6 and all(isinstance(v, int | float) for v in value)
    return not isinstance(value, Mapping)


def _words(key: str) -> str:
    return escape(key.replace("_", " "))


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, list):
        return escape(", ".join(_cell(v) for v in value))
    return "" if value is None else escape(str(value))


def _size(path: Path) -> tuple[int, int]:
    """Width and height of a PNG, from its header."""
    try:
        with open(path, "rb") as file:
            head = file.read(24)
    except OSError:
        head = b""
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")
