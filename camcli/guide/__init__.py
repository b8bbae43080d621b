"""The guide: Markdown pages, shown by `cam guide`, read on a code host, and built into a site.

A page is a file `KIND/TOPIC.md` that begins with its title. Pages of `reference` are written by
`python -m camcli.cli.reference` from the tables of the program, the glossary excepted.
"""

from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent
KINDS = {  # folder: what its pages are
    "tutorial": "Learn",
    "how-to": "Do",
    "explanation": "Understand",
    "reference": "Look up",
}


@dataclass(frozen=True)
class Page:
    """A page of the guide."""

    topic: str
    kind: str
    title: str
    path: Path

    def text(self) -> str:
        """The page, in Markdown."""
        return self.path.read_text(encoding="utf-8")


def pages() -> dict[str, Page]:
    """The pages by their topics, in the order in which they are listed."""
    listed = {}
    for kind in KINDS:
        for path in sorted((FOLDER / kind).glob("*.md")):
            with open(path, encoding="utf-8") as file:
                title = file.readline().removeprefix("# ").strip()
            listed[path.stem] = Page(path.stem, kind, title, path)
    return listed


def section_of(topic: str) -> tuple[Page, str] | None:
    """A page and the text of its section `## Topic`; small letters do, and - for a space.

    None where no page has such a section, or several have.
    """
    heading = topic.replace("-", " ").lower()
    found = [
        (page, f"## {section.rstrip()}\n")
        for page in pages().values()
        for section in page.text().split("\n## ")[1:]
        if section.partition("\n")[0].strip().lower() == heading
    ]
    return found[0] if len(found) == 1 else None
