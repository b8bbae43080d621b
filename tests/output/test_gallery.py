"""The page of figures: valid, whole, offline, and usable by keyboard; without a browser."""

from html.parser import HTMLParser
from itertools import pairwise
from urllib.parse import unquote, urlsplit

import pytest

from camcli.output.gallery import MOST_ROWS, STYLE, Picture, page

VOID = {"meta", "img"}
CLOSES = {"p": {"p"}, "pre": {"p"}, "ul": {"p"}, "h2": {"p"}, "h3": {"p"}}  # what ends by itself
FOCUSED = {"a", "summary"}
PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + (1340).to_bytes(4, "big") + (900).to_bytes(4, "big")
RECORD = {
    "result": {
        "first_rpm": 114.97932674412345,
        "words": ["lost & <found>"],
        "ranges": [{"label": "P(1;1)", "from_rpm": 1.0 * k} for k in range(MOST_ROWS + 5)],
        "deep": {"hits": [{"corner": "c", "rpm": 1.5}]},
        "empty": None,
    },
    "cost": {"impacts": 12, "gap_evaluations": 34},
}


class Page(HTMLParser):
    """Elements with their attributes, text and parents; raises where tags do not match."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.found = [], []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), f"an attribute twice in <{tag}>"
        over = self.open[-1]["tag"] if self.open else None
        assert over != "p" or "p" not in CLOSES.get(tag, ()), f"<{tag}> within <p>"
        one = {"tag": tag, "text": "", "within": [e["tag"] for e in self.open], **dict(attrs)}
        self.found.append(one)
        if tag not in VOID:
            self.open.append(one)

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> without a beginning"
        assert self.open.pop()["tag"] == tag, f"</{tag}> closes another"

    def handle_data(self, data):
        for one in self.open:
            one["text"] += data

    def all(self, *tags):
        return [one for one in self.found if one["tag"] in tags]


@pytest.fixture
def out(tmp_path):
    """Two figures: a whole one, with names that need care, and one not computed."""
    for file in ("sweep.png", "speeds & more.csv", "run.json"):
        path = tmp_path / "3.6 a#1" / file
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(PNG if file.endswith("png") else b"")
    return tmp_path


def picture(out, name, **more):
    files = {path.name: 1 for path in sorted((out / name).glob("*"))}
    values = {
        "title": 'Impacts <b> & "more"', "shows": "What it shows", "command": "cam sweep -c x.yaml",
        "scene": "run: {rpm: 1} # <i> &lt;", "notes": ["a <note>"],
        "seconds": 1.25, "record": RECORD,
    }  # fmt: skip
    return Picture(name=name, folder=out / name, files=files, **{**values, **more})


@pytest.fixture
def shown(out):
    none = {"seconds": None, "notes": [], "record": {}}
    return Page("".join(page([picture(out, "3.6 a#1"), picture(out, "3.7", **none)])))


def test_every_link_leads_somewhere_and_stays_here(shown, out):
    ids = [one["id"] for one in shown.found if "id" in one]
    assert len(ids) == len(set(ids))
    links = [one["href"] for one in shown.all("a")] + [one["src"] for one in shown.all("img")]
    assert len(links) == 1 + 2 + 1 + 3 + 1  # skip, list, picture, files, image
    for link in links:
        parts = urlsplit(link)
        assert not parts.scheme
        assert not parts.netloc
        if parts.path:
            assert (out / unquote(parts.path)).is_file(), link
        else:
            assert parts.fragment in ids, link


def test_nothing_is_fetched_from_elsewhere(shown):
    assert {one["tag"] for one in shown.found} & {"script", "link", "iframe", "object"} == set()
    assert "url(" not in STYLE
    assert "@import" not in STYLE
    assert not [one for one in shown.found if any(key.startswith("on") for key in one)]


def test_pictures_have_words_a_size_and_a_link(shown):
    (image,) = shown.all("img")
    assert image["alt"] == '3.6 a#1 Impacts <b> & "more", opens the picture'
    assert (image["width"], image["height"]) == ("1340", "900")
    assert image["within"][-2:] == ["figure", "a"]
    assert [one["text"] for one in shown.all("figcaption")] == ["What it shows"]
    assert "Not computed yet." in [one["text"] for one in shown.all("p")]


def test_the_keyboard_reaches_everything_in_order(shown):
    stops = [one for one in shown.found if one["tag"] in FOCUSED or one.get("tabindex") == "0"]
    assert stops[0]["href"] == "#figures"
    assert [one["href"] for one in stops[1:4]][:2] == ["#figure-3-6-a-1", "#figure-3-7"]
    assert stops[3]["href"].endswith("sweep.png")
    assert all(int(one.get("tabindex", 0)) <= 0 for one in shown.found)
    assert ":focus-visible" in STYLE
    assert "outline: none" not in STYLE


def test_what_scrolls_can_be_focused_and_has_its_own_name(shown):
    scrolled = [one for one in shown.all("div", "pre") if one.get("class") != "command"]
    assert len(scrolled) == 4
    names = [one["aria-label"] for one in scrolled]
    assert len(names) == len(set(names))
    assert {(one["role"], one["tabindex"]) for one in scrolled} == {("group", "0")}


def test_headings_go_down_by_one(shown):
    levels = [int(one["tag"][1]) for one in shown.all("h1", "h2", "h3", "h4", "h5", "h6")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert [one["text"] for one in shown.all("h3")] == ["words", "ranges", "deep", "Files"]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_a_language_a_title_and_marks(shown):
    assert [one["lang"] for one in shown.all("html")] == ["en"]
    assert all(one["text"].strip() for one in shown.all("title", "h1", "h2", "h3", "summary"))
    assert [len(shown.all(tag)) for tag in ("main", "nav", "header", "article")] == [1, 1, 1, 2]
    assert [one["text"] for one in shown.all("pre")][-1] == "run: {rpm: 1} # <i> &lt;"
    assert "lost & <found>" in [one["text"] for one in shown.all("li")]


def test_long_tables_are_cut_and_say_so(shown):
    assert len([one for one in shown.all("tr") if "tbody" in one["within"]]) == MOST_ROWS + 1
    assert any("The first 20 of 25" in one["text"] for one in shown.all("p"))
