"""The page of figures: valid, whole, offline, and usable by keyboard; without a browser."""

import json
import re
from html.parser import HTMLParser
from itertools import pairwise
from urllib.parse import unquote, urlsplit

import pytest

from camcli.output.certificate_check import CheckedCertificate
from camcli.output.gallery import MOST_ROWS, GalleryFigure, _table, page
from camcli.output.pictures import caption_in, write_picture
from camcli.plots.picture import Panel, Picture
from camcli.scene.schema import Plot

VOID = {"meta", "img", "link"}
BLOCKS = {"p", "pre", "ul", "dl", "div", "table", "h2"}  # what ends a paragraph by itself
PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR" + (1340).to_bytes(4, "big") + (900).to_bytes(4, "big")
RECORD = {
    "result": {
        "first_rpm": 114.97932674412345,
        "words": ["lost & <found>"],
        "ranges": [{"label": "P(1;1)", "from_rpm": 1.0 * k} for k in range(MOST_ROWS + 5)],
        "deep": {"hits": [{"corner": "c", "rpm": [1.5, 2.0], "more": {"x": 1}}]},
        "empty": None,
        "none_found": 0,
        "at_zero": 0.0,
        "is_whole": False,
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
        assert tag not in BLOCKS or "p" not in [one["tag"] for one in self.open]
        one = {"tag": tag, "text": "", "within": [e["tag"] for e in self.open], **dict(attrs)}
        self.found.append(one)
        if tag not in VOID:
            self.open.append(one)

    def handle_endtag(self, tag):
        assert self.open.pop()["tag"] == tag, f"</{tag}> closes another"

    def handle_data(self, data):
        for one in self.open:
            one["text"] += data

    def all(self, *tags):
        return [one for one in self.found if one["tag"] in tags]


def picture(out, name, **more):
    texts = {
        "title": 'Impacts <b> & "more"', "caption": "What <it> $shows", "command": "cam sweep",
        "scene": "run: {rpm: 1} # <i> &lt; $x",
    }  # fmt: skip
    return GalleryFigure(name=name, folder=out / name, **{**texts, **more})


@pytest.fixture
def out(tmp_path):
    """The files of a figure whose names need care."""
    for file in ("run.json", "speeds & more.csv", "sweep.png"):
        path = tmp_path / "3.6 a#1" / file
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(PNG if file.endswith("png") else json.dumps(RECORD).encode())
    return tmp_path


@pytest.fixture
def shown(out):
    """The page of that figure, and of one that is not computed."""
    files = sorted(path.name for path in (out / "3.6 a#1").iterdir())
    whole = picture(
        out,
        "3.6 a#1",
        files=files,
        seconds=1.25,
        notes=["a <note>"],
        printed={"q & v": (0.546, 0.5461)},
    )
    return Page(page([whole, picture(out, "3.7")]))


def test_every_link_leads_somewhere_and_stays_here(shown, out):
    ids = [one["id"] for one in shown.found if "id" in one]
    assert len(ids) == len(set(ids))
    links = [one["href"] for one in shown.all("a")] + [one["src"] for one in shown.all("img")]
    assert len(links) == 1 + 2 + 1 + 3 + 3  # skip, list, picture, files, images
    for link in links:
        parts = urlsplit(link)
        assert not parts.scheme
        assert not parts.netloc
        if parts.path:
            assert (out / unquote(parts.path)).is_file(), link
        else:
            assert parts.fragment in ids, link


def test_a_figure_that_is_a_page_is_opened_by_a_link(out):
    (out / "motion").mkdir()
    (out / "motion" / "run.json").write_text(json.dumps(RECORD))
    found = Page(page([picture(out, "motion", files=["explore.html", "run.json"])]))
    assert [a["href"] for a in found.all("a") if a["text"][:4] == "Open"] == ["motion/explore.html"]


def test_nothing_is_fetched_from_elsewhere(shown):
    assert {one["tag"] for one in shown.found} & {"script", "iframe", "object"} == set()
    (icon,) = shown.all("link")  # without it a browser asks the site for one
    assert (icon["rel"], icon["href"][:19]) == ("icon", "data:image/svg+xml,")
    (style,) = shown.all("style")
    assert not any(word in style["text"] for word in ("url(", "@import", "outline: none"))
    assert not [one for one in shown.found if any(key.startswith("on") for key in one)]


def test_pictures_have_words_a_size_and_a_link(shown):
    first, small, image = shown.all("img")
    assert (first["src"], first["alt"]) == (image["src"], image["alt"])
    assert (small["alt"], small["src"]) == ("", image["src"])
    assert image["alt"] == "What <it> $shows"
    assert (image["width"], image["height"]) == ("1340", "900")
    assert image["within"][-2:] == ["figure", "a"]
    assert [one["text"] for one in shown.all("figcaption")] == ["What <it> $shows"]
    assert "Not computed yet." in [one["text"] for one in shown.all("p")]


def test_the_page_opens_with_the_sweep_of_the_example_else_with_its_first_picture(out):
    figures = [picture(out, name, files=["sweep.png"]) for name in ("3.1", "3.6e", "3.7")]
    assert Page(page(figures)).all("img")[0]["src"] == "3.6e/sweep.png"
    assert Page(page(figures[::2])).all("img")[0]["src"] == "3.1/sweep.png"
    not_drawn = [picture(out, "3.6e"), picture(out, "3.5", files=["run.json"]), figures[2]]
    assert Page(page(not_drawn)).all("img")[0]["src"] == "3.7/sweep.png"
    assert not Page(page([])).all("img")


def test_the_keyboard_reaches_everything_in_order_and_what_scrolls_has_a_name(shown):
    stops = [o for o in shown.found if o["tag"] in ("a", "summary") or o.get("tabindex") == "0"]
    assert stops[0]["href"] == "#figures"
    assert [one["href"] for one in stops[1:3]] == ["#figure-3-6-a-1", "#figure-3-7"]
    assert stops[3]["href"].endswith("sweep.png")
    assert all(int(one.get("tabindex", 0)) <= 0 for one in shown.found)
    assert ":focus-visible" in shown.all("style")[0]["text"]
    scrolled = [one for one in shown.all("div", "pre") if one.get("class") != "command"]
    names = [one["aria-label"] for one in scrolled]
    assert names == [
        "Printed numbers of 3.6 a#1",
        "ranges of 3.6 a#1",
        "hits of 3.6 a#1",
        "Scene of 3.6 a#1",
        "Scene of 3.7",
    ]
    assert {(one["role"], one["tabindex"]) for one in scrolled} == {("group", "0")}


def test_a_language_titles_marks_and_every_text_as_it_is(shown):
    assert [one["lang"] for one in shown.all("html")] == ["en"]
    levels = [int(one["tag"][1]) for one in shown.all("h1", "h2", "h3")]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert all(one["text"].strip() for one in shown.all("title", "h1", "h2", "summary"))
    assert [len(shown.all(tag)) for tag in ("main", "nav", "header", "article")] == [1, 1, 1, 2]
    assert [one["text"] for one in shown.all("pre")][-1] == "run: {rpm: 1} # <i> &lt; $x"
    assert {"lost & <found>", "a <note>"} <= {one["text"] for one in shown.all("li")}
    assert "Cost: 12 impacts, 34 gap evaluations, 1.2 s" in shown.all("article")[0]["text"]


def test_numbers_are_terms_and_tables_and_long_ones_are_cut(shown):
    assert [one["text"] for one in shown.all("dt")] == [
        "first rpm", "words", "ranges", "deep", "hits", "none found", "at zero", "is whole",
    ]  # fmt: skip
    assert shown.all("dd")[0]["text"] == "114.979326744"
    assert len([one for one in shown.all("tr") if "tbody" in one["within"]]) == MOST_ROWS + 2
    assert "1.5, 2" in [one["text"] for one in shown.all("td")]
    assert any("The first 20 of 25" in one["text"] for one in shown.all("p"))


@pytest.mark.parametrize("text", ["", "[]", "3", '{"cost": []}', '{"result": 1, "cost": {}}'])
def test_a_damaged_record_leaves_a_page(out, text):
    (out / "3.6 a#1" / "run.json").write_text(text)
    shown = Page(page([picture(out, "3.6 a#1", files=["run.json"])]))
    assert "Cost: 0.0 s" in shown.all("article")[0]["text"]


def test_a_file_too_large_to_be_kept_is_named(out):
    (out / "motion").mkdir()
    record = {**RECORD, "artefacts": {"sweep.png": "", "impacts.csv": "", "run.json": ""}}
    (out / "motion" / "run.json").write_text(json.dumps(record))
    text = page([picture(out, "motion", files=["sweep.png", "run.json", "extra.txt"])])
    (said,) = re.findall("the command also writes ([^<]*), too large to be kept", text)
    assert said == "impacts.csv"


def test_a_table_has_its_first_rows_and_columns_and_only_what_fits_a_cell():
    rows = [
        {"a_b": 1 / 3, "long": [1] * 7, "six": [1.5] * 6, "map": {"x": 1}, "none": None, "<": "&",
         **{f"c{k}": k for k in range(9)}, "row": n}
        for n in range(MOST_ROWS + 1)
    ]  # fmt: skip
    html = _table(rows, "it's")
    assert re.findall('<th scope="col">(.*?)</th>', html) == [
        "a b", "six", "none", "&lt;", "c0", "c1", "c2", "c3", "c4", "c5",
    ]  # fmt: skip
    cells = re.findall("<td>(.*?)</td>", html)
    assert cells[:5] == ["0.333333333333", ", ".join(["1.5"] * 6), "", "&amp;", "0"]
    assert len(cells) == 10 * MOST_ROWS
    assert f"The first {MOST_ROWS} of {MOST_ROWS + 1}, all of them in run.json." in html
    assert "The first" not in _table(rows[:-1], "")


def test_how_a_picture_was_computed_stands_below_it_and_not_in_it(out):
    text = "600 turns of transient"
    drawn = Picture("Title", {"one": Panel(lambda axes: None), "two": Panel(lambda axes: None)},
                    caption=text)  # fmt: skip
    (out / "drawn").mkdir()
    for kind in ("png", "pdf", "svg"):
        with open(out / "drawn" / f"sweep.{kind}", "wb") as file:
            write_picture(drawn, file, kind, Plot(height=60))
    small = drawn.figure(Plot(height=60))
    lost = "No room for two (--panels draws them alone, --height a taller page)."
    said = f"600 turns of transient. {lost}"
    on_it = [text.get_text() for text in small.axes[0].texts]
    assert (on_it, small.left_out) == (["Title"], ["two"])
    assert caption_in(out / "drawn" / "sweep.png") == small.caption == said
    assert text.encode() in (out / "drawn" / "sweep.svg").read_bytes()
    assert text.encode() in (out / "drawn" / "sweep.pdf").read_bytes()
    shown = Page(page([picture(out, "drawn", files=["run.json", "sweep.png"])]))
    assert [one["text"] for one in shown.all("figcaption")] == [f"What <it> $shows {said}"]
    assert caption_in(out / "nothing.png") == ""
    with open(out / "plain.png", "wb") as file:  # nor has a later picture that of an earlier one
        write_picture(Picture("Title", {"one": Panel(lambda axes: None)}), file, "png")
    assert caption_in(out / "plain.png") == ""


WHOLE = """\
<section>
<h2>3.6</h2>
<ul>
<li><a href="#figure-3-6a"><img src="3.6a/sweep.png" loading="lazy" alt="">3.6a One</a></li>
</ul>
</section>
<section>
<h2>Without a number</h2>
<ul>
<li><a href="#figure-own">Two</a></li>
</ul>
</section>
</nav>
</header>
<main id="figures" tabindex="-1">
<article id="figure-3-6a" aria-labelledby="figure-3-6a-title">
<h2 id="figure-3-6a-title">3.6a One</h2>
<figure>
<a href="3.6a/sweep.png"><img src="3.6a/sweep.png" width="1340" height="900" loading="lazy"
alt="What"></a>
<figcaption>What</figcaption>
</figure>
<p>What <a href="3.6a/explore.html">Open the page</a></p>
<pre class="command"><code>cam sweep</code></pre>
<ul>
<li>a &lt;note&gt;</li></ul>
<p>Certificate: <a href="3.6a/proof.json" download>proof.json</a> (12 kB). Its checker said in
0.2 s: all of 2.</p>
<details>
<summary>What it said of each statement</summary>
<ul>
<li>1: yes</li><li>2: yes</li></ul>
</details>
<div class="wide" role="group" aria-label="Printed numbers of 3.6a" tabindex="0"><table>
<thead><tr><th scope="col">number</th><th scope="col">printed</th>\
<th scope="col">computed</th></tr></thead>
<tbody><tr><td>q</td><td>0.546</td><td>0.5461</td></tr>\
<tr><td>v</td><td>1.5</td><td></td></tr></tbody>
</table></div>
<details>
<summary>Numbers and files</summary>
<dl>
<dt>first rpm</dt><dd>114.979326744</dd>
<dt>words</dt><dd><ul>
<li>a &amp; b</li><li>c</li></ul>
</dd>
<dt>loads</dt><dd><dl>
<dt>largest n</dt><dd>2.5</dd>
<dt>at</dt><dd><ul>
<li>1</li><li>2</li></ul>
</dd>
</dl>
</dd>
</dl>
<p>Files: <a href="3.6a/explore.html">explore.html</a>, <a href="3.6a/run.json">run.json</a>, \
<a href="3.6a/speeds.csv">speeds.csv</a>, <a href="3.6a/sweep.png">sweep.png</a>; \
the command also writes impacts.csv, too large to be kept</p>
</details>
<p>Cost: 12 impacts, 34 gap evaluations, 1.2 s with start and drawing.</p>
<details>
<summary>Scene</summary>
<pre role="group" aria-label="Scene of 3.6a" tabindex="0"><code>run: {}</code></pre>
</details>
</article>
<article id="figure-own" aria-labelledby="figure-own-title">
<h2 id="figure-own-title">Two</h2>
<p>Not computed yet.</p>
<pre class="command"><code>cam</code></pre>
<details>
<summary>Scene</summary>
<pre role="group" aria-label="Scene of own" tabindex="0"><code></code></pre>
</details>
</article>
</main>
</body>
</html>
"""


def test_the_whole_page_as_it_is_written(out):
    """Two figures, of which one has all that a figure can have and the other nothing."""
    result = {
        "first_rpm": 114.97932674412345, "words": ["a & b", "c"], "empty": None, "none": [],
        "loads": {"largest_n": 2.5, "at": [1, 2]},
    }  # fmt: skip
    record = {**RECORD, "result": result, "artefacts": {"sweep.png": "", "impacts.csv": ""}}
    (out / "3.6a").mkdir()
    (out / "3.6a" / "run.json").write_text(json.dumps(record))
    (out / "3.6a" / "sweep.png").write_bytes(PNG)
    whole = picture(
        out, "3.6a", title="One", caption="What", scene="run: {}", seconds=1.25, notes=["a <note>"],
        files=["explore.html", "run.json", "speeds.csv", "sweep.png"],
        printed={"q": (0.546, 0.5461), "v": (1.5, None)},
        certificate=CheckedCertificate(
            bytes=12345, seconds=0.25, confirmed=True, lines=["1: yes", "2: yes", "all of 2"]
        ),
    )  # fmt: skip
    bare = picture(out, "own", title="Two", caption="", scene="", command="cam")
    assert page([bare, whole]).partition('<nav aria-label="Figures">\n')[2] == WHOLE
    one = CheckedCertificate(bytes=1, seconds=0.25, confirmed=False, lines=["no certificate"])
    text = page([picture(out, "3.1", files=["run.json"], certificate=one)])
    assert "said in\n0.2 s: no certificate.</p>\n<details>\n<summary>Numbers" in text
    bare = picture(out, "own", title="Two", caption="", files=["run.json"])
    assert "<p>This command draws no picture.</p>" in page([bare])


def test_a_number_that_is_zero_is_one_of_the_numbers(shown):
    terms = [one["text"] for one in shown.all("dt")]
    told = dict(zip(terms, (one["text"] for one in shown.all("dd")), strict=True))
    assert (told["none found"], told["at zero"], told["is whole"]) == ("0", "0", "no")
    assert "empty" not in terms


def test_a_cell_of_a_table_holds_no_map_and_no_long_or_nested_list():
    rows = [
        {"a": 1, "b": [1, 2, 3, 4, 5, 6], "c": [[1], 2], "d": [{"x": 1}], "e": {"x": 1},
         "f": [*range(7)]},
        {"a": 2, "b": [], "c": [3]},
    ]  # fmt: skip
    text = _table(rows, "rows")
    heads = [one["text"] for one in Page(text).all("th")]
    assert {"a", "b"} <= set(heads)
    cells = [one["text"] for one in Page(text).all("td")]
    assert not any("{" in cell or "[" in cell for cell in cells)
