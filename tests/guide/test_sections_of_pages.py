"""Pages of a guide that is written here, and the sections that they have."""

from __future__ import annotations

import pytest

from camcli import guide
from camcli.guide import Page, pages, section_of

WRITTEN = {
    "tutorial/z-first.md": "#  Begin here \nText ä.\n## One more\nof z\n### below\n\n",
    "how-to/b.md": "# B\n\n## Twice\nb\n\n## One two \nlast\n",
    "how-to/a.md": "# A\n## Twice\na\n",
    "explanation/e.md": "Plain\n# no title\n",
    "reference/r.md": "# R\n\nOne two\n",
    "other/x.md": "# X\n## Nowhere\n",
    "how-to/notes.txt": "# N\n",
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    for name, text in WRITTEN.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.setattr(guide, "FOLDER", tmp_path)
    return tmp_path


def test_pages_are_listed_by_kind_and_then_by_name(folder):
    assert list(pages().items()) == [
        ("z-first", Page("z-first", "tutorial", "Begin here", folder / "tutorial/z-first.md")),
        ("a", Page("a", "how-to", "A", folder / "how-to/a.md")),
        ("b", Page("b", "how-to", "B", folder / "how-to/b.md")),
        ("e", Page("e", "explanation", "Plain", folder / "explanation/e.md")),
        ("r", Page("r", "reference", "R", folder / "reference/r.md")),
    ]
    assert pages()["z-first"].text() == WRITTEN["tutorial/z-first.md"]


@pytest.mark.parametrize(
    ("topic", "page", "text"),
    [
        ("one-more", "z-first", "## One more\nof z\n### below\n"),
        ("ONE two", "b", "## One two \nlast\n"), ("One-Two", "b", "## One two \nlast\n"),
    ],
)  # fmt: skip
def test_a_section_is_found_by_its_heading_in_small_letters(topic, page, text):
    found, section = section_of(topic)
    assert (found.topic, section) == (page, text)


@pytest.mark.parametrize("topic", ["twice", "nowhere", "below", "b", "one", "no title", ""])
def test_a_heading_that_no_page_has_or_several_have_is_no_section(topic):
    assert section_of(topic) is None
