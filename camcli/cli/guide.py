"""cam guide"""

from __future__ import annotations

import sys

from camcli.cli.options import Request, argument
from camcli.errors import Fault, SceneError

WITHOUT = (
    "config", "sets", "rpm", "points", "out", "no_plot", "formats", "width", "height", "font",
    "style", "no_title", "panels", "json", "verbose", "quiet", "threads", "dry_run",
)  # fmt: skip

SUBJECTS = {  # what a page of another name tells of: the page
    "force": "spring",
    "hertz": "spring",
    "seat": "lash",
    "seating": "lash",
    "surge": "spring",
    "tolerance": "detach",
    "valve": "lash",
}


def _topics(beginning: str) -> list[str]:
    """The topics that begin with what was typed."""
    from camcli.guide import pages

    return [topic for topic in pages() if topic.startswith(beginning)]


def guide(
    request: Request,
    topic: str | None = argument(
        "A page of the guide. Default: the list of all.", "[TOPIC]", complete=_topics
    ),
) -> int:
    """Show the guide.

    Examples:
      cam guide                                the list
      cam guide first-steps                    a tour of twenty minutes
      cam guide sweep                          all files and columns of sweep

    A command is a topic too: cam guide sweep tells every file, column, option and status of it.
    So is the heading of a section: cam guide chaos shows it and names its page.
    """
    from camcli.guide import KINDS, pages, section_of

    known = pages()
    topic = topic if topic in known else SUBJECTS.get((topic or "").lower(), topic)
    if topic is None:
        for kind, heading in KINDS.items():
            print(f"{heading}:")
            for page in known.values():
                if page.kind == kind:
                    print(f"  cam guide {page.topic:18} {page.title}")
        return 0
    section = None if topic in known else section_of(topic)
    if section is not None:
        page, text = section
        _show(f"{text}\nThe whole page: cam guide {page.topic}\n")
        return 0
    if topic not in known:
        from difflib import get_close_matches

        near = get_close_matches(topic, known, 1)
        cure = f"did you mean {near[0]}?" if near else "cam guide lists them"
        raise SceneError(Fault("guide", "", f"found '{topic}'", "expected a topic", cure))
    _show(known[topic].text())
    return 0


def _show(text: str) -> None:
    """Print a page: set and paged where a person sits at a terminal, else as Markdown."""
    if not (sys.stdout.isatty() and sys.stdin.isatty()):  # a pager would wait for a key
        print(text, end="")
        return
    from rich.console import Console
    from rich.markdown import Markdown

    console = Console()
    with console.pager(styles=True):
        console.print(Markdown(text))
