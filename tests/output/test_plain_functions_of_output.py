"""Functions of what a run writes, each asked alone: pages, records, digests, pictures' files."""

from __future__ import annotations

import io
import subprocess
import sys
from contextlib import contextmanager
from enum import StrEnum
from hashlib import sha256
from math import inf, isclose, nan
from pathlib import Path
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from matplotlib.backends import backend_pdf

from camcli.analysis.integrate import Cost
from camcli.output import certificate_check, pictures, tables
from camcli.output.certificate_check import CheckedCertificate, check_certificate
from camcli.output.digest import digest, drifts
from camcli.output.gallery import MOST_ROWS, GalleryFigure, _certified, _html, page
from camcli.output.notebook import result_html, table_html
from camcli.output.npz import Form
from camcli.output.run_record import cost_record, error_record, to_text
from camcli.output.tables import Named, SharedRows, Table
from camcli.plots.simulate import FRAMES_PER_S

# -- the page of figures -----------------------------------------------------------------------


def figure(name: str, **more) -> GalleryFigure:
    usual = {"title": f"Title of {name}", "caption": "", "command": "cam", "scene": ""}
    return GalleryFigure(name=name, folder=Path("none"), **{**usual, **more})


def test_a_figure_without_a_caption_is_told_by_its_title():
    files = ["explore.html", "sweep.png"]
    text = page([figure("3.1", title="A & B", files=files)])
    assert text.count('alt="A &amp; B"') == 2  # the first picture of the page, and in its article
    assert "<figcaption>A &amp; B</figcaption>" in text
    assert '<p>A &amp; B <a href="3.1/explore.html">Open the page</a></p>' in text
    text = page([figure("3.1", title="A & B", caption="C", files=files)])
    assert text.count('alt="C"') == 2
    assert "<figcaption>C</figcaption>" in text
    assert '<p>C <a href="3.1/explore.html">' in text


def test_figures_are_listed_under_the_number_that_they_share():
    names = ["own", "3.6b", "3.6a", "3.10", "a2b", "3.6", "3.6ab"]
    listed, _, _ = page([figure(name) for name in names]).partition("</nav>")
    _, *sections = listed.split("<h2>")
    found = [(text.partition("<")[0], text.count("<li>")) for text in sections]
    assert found == [("3.6", 2), ("3.10", 1), ("3.6", 1), ("3.6ab", 1), ("Without a number", 2)]
    assert "3.6b Title of 3.6b" in listed
    assert ">Title of own<" in listed


@pytest.mark.parametrize(
    ("size", "lines", "told"),
    [
        (1, ["a", "all"], "(1 kB). Its checker said in\n1.2 s: all.</p>"),
        (1499, ["all"], "(1 kB). Its checker said in\n1.2 s: all.</p>"),
        (1501, ["all"], "(2 kB). Its checker said in\n1.2 s: all.</p>"),
        (1_234_567, ["<all>"], "(1,235 kB). Its checker said in\n1.2 s: &lt;all&gt;.</p>"),
        (1_234_567, [], "(1,235 kB). Its checker said in\n1.2 s: nothing.</p>"),
    ],
)
def test_the_size_of_a_certificate_and_the_last_words_of_its_checker(size, lines, told):
    checked = CheckedCertificate(bytes=size, seconds=1.23, confirmed=True, lines=lines)
    text = _certified(figure("a b", certificate=checked))
    assert told in text
    assert text.startswith('<p>Certificate: <a href="a%20b/proof.json" download>')
    assert ("<li>a</li></ul>" in text) == (len(lines) > 1) == ("<details>" in text)


def test_values_of_a_record_are_lists_terms_and_tables():
    many = [f"w{k}" for k in range(MOST_ROWS + 5)]
    assert _html(many, "words", "3.1").count("<li>") == MOST_ROWS
    assert "<li>w0</li><li>w1</li>" in _html(many, "words", "3.1")
    mixed = _html([{"x": 1}, 2.5], "mixed", "3.1")
    assert "<table>" not in mixed
    assert mixed.count("<li>") == 2
    table = _html([{"x": 1}, {"x": 2}], "two_of", "3.1")
    assert 'aria-label="two_of of 3.1"' in table
    assert _html({"a_b": {"c": None}, "d": []}, "", "f") == "<dl>\n<dt>a b</dt><dd></dd>\n</dl>\n"
    assert (_html({"d": ""}, "", "f"), _html([], "", "f")) == ("", "")
    assert [_html(x, "", "f") for x in (True, 1 / 3, None, "<", 7)] == [
        "yes", "0.333333333333", "", "&lt;", "7",
    ]  # fmt: skip


# -- certificates ------------------------------------------------------------------------------


@pytest.mark.parametrize(("code", "confirmed"), [(0, True), (1, False), (2, False), (-9, False)])
def test_a_certificate_is_given_to_a_checker_of_its_own(tmp_path, monkeypatch, code, confirmed):
    asked = []

    def run(words, **more):
        asked.append((words, more["encoding"], more["check"]))
        return Stub(returncode=code, stdout="one\ntwo\n", stderr="at last\n")

    assert check_certificate(tmp_path) is None
    (tmp_path / "proof.json").write_bytes(b"x" * 17)
    times = iter([100.0, 102.34567])
    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(certificate_check, "perf_counter", lambda: next(times))
    found = check_certificate(tmp_path)
    assert found == CheckedCertificate(
        bytes=17, seconds=2.346, confirmed=confirmed, lines=["one", "two", "at last"]
    )
    ((words, encoding, check),) = asked
    assert words[:2] == [sys.executable, "-P"]
    assert Path(words[2]).name == "check.py"
    assert words[3:] == [str(tmp_path / "proof.json")]
    assert (encoding, check) == ("utf-8", False)


# -- notebooks ---------------------------------------------------------------------------------


class Drawn:
    """A figure of matplotlib, as far as a notebook asks it for a picture."""

    def savefig(self, file, **more):
        assert more == {"format": "png", "dpi": 110}
        file.write(b"abc")


def test_a_notebook_has_sentences_a_picture_and_eight_rows_of_each_table():
    rows = [(k / 3, k, f"<{k}>") for k in range(1, 10)]
    table = Table.of_rows(("a<", "b", "c"), lambda: rows)
    cells = "".join(
        f"<tr><td>{k / 3:.6g}</td><td>{k}</td><td>&lt;{k}&gt;</td></tr>" for k in range(1, 9)
    )
    inner = "</caption><thead><tr><th>a&lt;</th><th>b</th><th>c</th></tr></thead>"
    whole = f"{inner}<tbody>{cells}</tbody></table>"
    assert table_html(table) == f"<table><caption>9 rows{whole}"
    one = Table.of_rows(("b",), lambda: [(5,)])
    small = "<thead><tr><th>b</th></tr></thead><tbody><tr><td>5</td></tr></tbody></table>"
    tables = {"x&": table, "y": one}
    assert result_html(["first <", "second"], Drawn(), tables).split("\n") == [
        "<p>first &lt;</p>",
        "<p>second</p>",
        '<img alt="" src="data:image/png;base64,YWJj">',
        f"<details><summary>x&amp;</summary><table><caption>x&amp;: 9 rows{whole}</details>",
        f"<details><summary>y</summary><table><caption>y: 1 row</caption>{small}</details>",
    ]
    assert result_html(["only"], None, {}) == "<p>only</p>"


# -- digests -----------------------------------------------------------------------------------


def table_of(columns: str, *rows) -> Table:
    return Table.of_rows(tuple(columns.split()), lambda: iter(rows))


NAMING = "attractor branch stable chatter impact period"  # numbers that name a row
LEFT_OUT = (  # what differs from machine to machine, or follows from others
    "rpm_error rpm_low rpm_high standard_error lyapunov_error_per_period turns_round stable_from "
    "stable_to"
)


def test_which_columns_name_a_row_and_which_are_left_out():
    columns = f"{NAMING} {LEFT_OUT} q_m v_m_s"
    names = columns.split()
    row = tuple(float(k) for k in range(2, 2 + len(names)))
    place = "t.csv 2 3 4 5 6 7"
    found = digest({"t": table_of(columns, row)}, None)["solved"]
    assert found == {"t.csv rows": 1, f"{place} q_m": 16.0, f"{place} v_m_s": 17.0}
    large = digest({"t": table_of(columns, *[row] * 41)}, None)["solved"]
    told = {name.split()[1] for name in large} - {"rows"}
    assert told == {*NAMING.split(), "q_m", "v_m_s"} - {"period"}
    assert large["t.csv branch = 3"] == 41


@pytest.mark.parametrize(
    ("name", "label", "group"),
    [
        ("impacts", "P(1;1)", "regular"), ("strobe", "aperiodic", "chaotic"),
        ("trajectory", "undecided", "chaotic"), ("trajectory", "P(1;1)", "regular"),
        ("events", "undecided", "chaotic"), ("strobe", "", "regular"),
        ("map", "aperiodic", "solved"), ("corner_hits", "P(1;1)", "solved"),
    ],
)  # fmt: skip
def test_to_which_group_the_table_of_a_single_motion_belongs(name, label, group):
    rows = [(0.5, 1.5), (0.25, 2.5)]
    found = digest({name: table_of("q_m v_m_s", *rows)}, {"label": label} if label else [1])
    assert [one for one, numbers in found.items() if f"{name}.csv rows" in numbers] == [group]
    assert found[group][f"{name}.csv rows"] == 2
    expected = {"label": label} if label else {}
    assert found["regular"].items() >= expected.items()


def test_of_many_texts_the_commonest_are_counted_and_long_ones_are_cut():
    long = "x" * 41
    texts = [f"t{k}" for k in range(24)] + ["t5"]
    rows = [(name, "z" * 40) for name in [*texts, *texts, long]]
    found = digest({"t": table_of("name word", *rows)}, None)["solved"]
    assert found["t.csv name = t5"] == 4
    assert found["t.csv name = t23"] == 2
    assert found["t.csv name different"] == 25
    assert len([name for name in found if name.startswith("t.csv name = ")]) == 24
    assert found[f"t.csv word = {'z' * 40}"] == len(rows)
    assert "t.csv word different" not in found
    short = digest({"t": table_of("name q_m", (long, 1.5))}, None)["solved"]
    assert short[f"t.csv {'x' * 28}~{sha256(long.encode()).hexdigest()[:8]} q_m"] == 1.5


def test_numbers_written_as_texts_are_numbers_and_empty_ones_none():
    rows = [("1.5", "a"), ("", "b"), ("-2", "")]
    found = digest({"t": table_of("x name", *rows)}, None)["solved"]
    assert found == {"t.csv rows": 3, "t.csv a x": 1.5, "t.csv  x": -2.0}


@pytest.mark.parametrize(("proved", "told"), [(True, 0.75), (False, None)])
def test_the_entropy_of_chaos_is_told_where_it_is_proved(proved, told):
    chaos = {"proved": proved, "entropy_per_turn": 0.75}
    assert digest({}, {"chaos": chaos})["solved"].get("entropy per turn") == told
    assert digest({}, {"chaos": None})["solved"] == {}


@pytest.mark.parametrize(("off", "told"), [(0.9e-6, True), (-0.9e-6, True), (1.1e-6, False)])
def test_a_phase_is_that_of_a_corner_to_a_millionth_of_a_degree(off, told):
    rows = [("impact", 40.0), ("impact", 40.0), ("rest", 70.0)]
    result = {"periods": 3, "corners_deg": [10.0, 20.0, 40.0 + off, 71.0]}
    found = digest({"events": table_of("event theta_deg", *rows)}, result)["solved"]
    assert ("impact corner" in found) == told
    assert found.get("impact corner", "c") == "c"
    assert (found["impacts a turn"], found["rests a turn"]) == (0.666667, 0.333333)
    assert (found["impact deg"], found["rest deg"]) == (40.0, 70.0)


def test_numbers_that_came_or_went_are_told_group_by_group():
    old = {"regular": {"b": 1, "a": 2}, "chaotic": {}, "solved": {"s": 1.0}}
    new = {"regular": {"c": 3, "a": 2}, "chaotic": {"d bits": "x"}, "solved": {"s": 1.5}}
    found = [(d.group, d.name, d.reference, d.found, d.by, d.portability)
             for d in drifts("f", old, new)]  # fmt: skip
    assert found == [
        ("regular", "b", 1, None, None, False), ("regular", "c", None, 3, None, False),
        ("chaotic", "d bits", None, "x", None, True), ("solved", "s", 1.0, 1.5, 0.5, False),
    ]  # fmt: skip


# -- records -----------------------------------------------------------------------------------


def test_the_cost_of_a_run_has_a_speed_where_all_was_computed():
    cost = Cost(impacts=30, evaluations=700, crossings=11)
    whole = {
        "impacts": 30, "seconds": 4.0, "impacts_per_s": 7.5, "gap_evaluations": 700,
        "crossings": 11, "pieces_from_disk": 0,
    }  # fmt: skip
    assert cost_record(cost, 4.0) == whole
    from_disk = {"impacts_per_s": None, "pieces_from_disk": 2}
    assert cost_record(cost, 4.0, 2) == whole | from_disk
    assert cost_record(cost, 0.0) == whole | {"seconds": 0.0, "impacts_per_s": None}


@pytest.mark.parametrize(
    ("top", "lift", "farthest"), [(0.25, 0.125, 0.25), (0.5, 1.75, 1.25), (-0.5, 0.25, 0.75)]
)
def test_the_error_of_a_gap_is_four_roundings_of_the_cam_s_farthest_height(top, lift, farthest):
    record = error_record(3e-10, Stub(cam=Stub(top=top), lift=lift))
    assert record["accumulation_phase_turns"] == 3e-10
    assert isclose(record["contact_gap_m"], 4 * 2.220446049250313e-16 * farthest)


def test_a_record_is_text_with_every_value_in_json_s_own_form():
    value = {"b": (1, 2.5), "a": {"z": inf, "y": -inf}, "n": nan, "c": 1.5 - 2j, "t": True}
    assert "".join(to_text(value).split()) == (
        '{"b":[1,2.5],"a":{"z":"inf","y":"-inf"},"n":null,"c":[1.5,-2.0],"t":true}'
    )
    assert to_text({"b": 1}) == '{\n  "b": 1\n}\n'


# -- tables ------------------------------------------------------------------------------------


def test_names_that_are_known_are_told_in_their_order():
    with pytest.raises(KeyError, match=r"found no table 'c'; there are b, a"):
        Named("table", {"b": 1, "a": 2})["c"]
    with pytest.raises(KeyError, match="found no picture 3; there are none"):
        Named("picture", {})[3]
    assert Named("table", {"b": 1})["b"] == 1


ALWAYS_TEXTS = (
    "case classification contact corner direction event expected holds_for kind label method "
    "observed proved quantity region status"
)


def test_columns_that_are_texts_are_so_in_a_table_without_any():
    columns = f"rpm {ALWAYS_TEXTS} stable watched_turns"
    empty = table_of(columns)
    nothing = table_of(columns, (1.5, *[None] * 16, 1, 2))
    for found in (empty.arrays(), nothing.arrays(), {name: nothing[name] for name in nothing}):
        kinds = {name: values.dtype.kind for name, values in found.items()}
        numbers = dict.fromkeys(("rpm", "stable", "watched_turns"), "f")
        assert kinds == dict.fromkeys(ALWAYS_TEXTS.split(), "U") | numbers
    assert list(nothing.arrays("stable", "rpm")) == ["stable", "rpm"]
    assert nothing.arrays("label")["label"].tolist() == [""]


class Archive:
    """What a collector gives to an archive: the rows of each call, column by column."""

    def __init__(self) -> None:
        self.added, self.closed = [], False

    def add(self, columns):
        self.added.append([column.tolist() for column in columns])

    def close(self):
        self.closed = True


def test_small_blocks_go_into_an_archive_together_and_none_is_lost():
    """Four rows at a time, in the place of thousands; a block of more has room of its own."""
    archive = Archive()
    collector = tables._Collector(archive, Form(4, ["<f8", "<i8", "<U2"]))
    collector.add([[1.5, None, 3.5], range(1, 4), "up"])
    collector.add([4.5, [4], ["a"]])  # four: still together
    collector.add([5.5, range(10, 4, -3), ["b", None]])
    collector.add([[6.5, 7.5, 8.5, 9.5, 10.5], 7, "c"])  # one more than there is room for
    collector.add([[11.5] * 7, 7, "c"])
    collector.add([12.5, 8, "d"])
    collector.close()
    ends = [[repr(x) for x in columns[0]] for columns in archive.added]
    assert ends == [
        ["1.5", "nan", "3.5", "4.5"], ["5.5", "5.5"],
        ["6.5", "7.5", "8.5", "9.5", "10.5"], ["11.5"] * 7, ["12.5"],
    ]  # fmt: skip
    _, counts, texts = ([x for one in archive.added for x in one[k]] for k in range(3))
    assert counts == [1, 2, 3, 4, 10, 7, *[7] * 12, 8]
    assert texts == ["up", "up", "up", "a", "b", "", *["c"] * 12, "d"]
    assert archive.closed


class Word(StrEnum):
    SMALL = "small"


def test_columns_that_are_joined_are_numbers_or_texts():
    """Whole numbers are int64; NaN alone is an empty text beside texts, no other number is."""
    few = np.array([1, 2], np.uint8)
    joined = tables._joined([few, np.array([3])])
    assert (joined.dtype, joined.tolist()) == (np.int64, [1, 2, 3])
    assert tables._joined([few]).dtype == np.int64
    texts = tables._joined([np.array([nan, nan]), np.array(["a"])])
    assert texts.tolist() == ["", "", "a"]
    with pytest.raises(TypeError, match="numbers or texts, not both"):
        tables._joined([np.array([nan, 1.0]), np.array(["a"])])
    kinds = [tables._kind(np.array(values)) for values in ([1, 2], [1.5], ["abc", "d"])]
    assert kinds == ["<i8", "<f8", "<U3"]
    assert tables._kind(np.empty(0, int)) == "<f8"
    assert tables._cells([Word.SMALL, "x", None, 3, 2.5]) == ["small", "x", "", 3, 2.5]
    with pytest.raises(TypeError, match="a table cannot hold bytes, set"):
        tables._cells([{1}, b"x", 2.0])


def test_a_table_of_shared_rows_has_the_blocks_that_are_its_own():
    def read(names):
        assert names == ["b"]
        yield from ([([1, 2], "x")], [None], [([3], "y")])

    table = SharedRows(read, lambda name: None).table("b", ("n", "word"))
    assert "".join(table.csv()) == "n,word\n1,x\n2,x\n3,y\n"
    assert (table.rows, table["word"].tolist()) == (3, ["x", "x", "y"])


@pytest.mark.parametrize("kind", [list, np.array])
def test_a_number_in_a_list_or_an_array_is_the_shortest_that_python_writes(kind):
    ends = [1e16, 9999999999999998.0, 1e-4, 9.999999999999999e-05, 1.5e300, 5e-324, 0.1, 0.0]
    numbers = [*ends, *(-x for x in ends), inf, -inf]
    table = Table(("a", "b"), lambda: iter([(kind(numbers), range(len(numbers)))]))
    assert "".join(table.csv()).splitlines()[1:] == [f"{x!r},{k}" for k, x in enumerate(numbers)]


def test_a_range_in_a_table_may_have_any_step():
    table = Table(("a", "b"), lambda: iter([(range(10, 0, -4), 0.5)]))
    assert (table["a"].tolist(), table["b"].tolist(), table.rows) == ([10, 6, 2], [0.5] * 3, 3)
    assert "".join(table.csv()) == "a,b\n10,0.5\n6,0.5\n2,0.5\n"


# -- files of pictures -------------------------------------------------------------------------


@pytest.mark.parametrize(("has_ffmpeg", "kinds"), [(True, ("gif", "mp4")), (False, ("gif",))])
def test_a_film_is_an_mp4_only_where_it_can_be_made(monkeypatch, has_ffmpeg, kinds):
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda _: has_ffmpeg))
    assert pictures.animation_kinds() == kinds


def test_a_picture_has_its_caption_and_its_form_and_leaves_none_to_the_next(monkeypatch):
    told = []

    @contextmanager
    def look(*form):
        told.append(form)
        yield

    monkeypatch.setattr("camcli.plots.style.look", look)

    def written(caption: str, kind: str, form=None):
        saved = {}
        figure = Stub(caption=caption, left_out=["gap"],
                      savefig=lambda file, **named: saved.update(named, file=file))  # fmt: skip
        left_out = pictures.write_picture(Stub(figure=lambda _: figure), "file", kind, form)
        assert (left_out, saved.pop("file"), saved.pop("format")) == (["gap"], "file", kind)
        return saved

    quick = {"pil_kwargs": {"compress_level": 3}}
    form = Stub(font="Serif", style="dark")
    assert written("Why", "png", form) == {
        "metadata": {"Software": None, "Description": "Why"}, **quick
    }  # fmt: skip
    assert written("", "png") == {"metadata": {"Software": None}, **quick}
    nothing = {"Creator": None, "Producer": None, "CreationDate": None}
    assert written("Why", "pdf") == {"metadata": {**nothing, "Subject": "Why"}}
    svg = {"Creator": None, "Date": None, "Description": "Why"}
    assert written("Why", "svg") == {"metadata": svg}
    assert told == [("Serif", "dark"), (), (), ()]


def test_the_caption_of_a_picture_is_read_from_its_file(tmp_path):
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    info = PngInfo()
    info.add_text("Subject", "another")
    Image.new("RGB", (1, 1)).save(tmp_path / "a.png", pnginfo=info)
    info.add_text("Description", "Why")
    Image.new("RGB", (1, 1)).save(tmp_path / "b.png", pnginfo=info)
    (tmp_path / "c.png").write_text("no picture")
    captions = [pictures.caption_in(tmp_path / f"{name}.png") for name in "abcd"]
    assert captions == ["", "Why", "", ""]


def test_each_frame_of_a_film_is_grabbed_once_when_it_is_drawn(monkeypatch):
    drawn, grabbed = [], []

    class Writer:
        def __init__(self, fps):
            assert fps == FRAMES_PER_S

        @contextmanager
        def saving(self, figure, path, dpi):
            assert (figure, dpi) == (one, 90)
            yield
            path.write_bytes(bytes(grabbed))

        def grab_frame(self):
            grabbed.append(drawn[-1])

    def frames():
        for k in (5, 7, 9):
            drawn.append(k)
            yield one

    one = Stub(dpi=90)
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter", Writer)
    file = io.BytesIO()
    pictures.write_animation(frames(), file, "mp4")
    assert file.getvalue() == bytes([5, 7, 9])


class Frame:
    """A figure of one colour, two pixels wide and three high; the first of them is black."""

    def __init__(self, red: int) -> None:
        self.canvas = self
        self.pixels = None
        self.red = red

    def draw(self):
        self.pixels = bytes([0, 0, 0, 255]) + bytes([self.red, 20, 40, 255]) * 5

    def get_width_height(self):
        return 2, 3

    def buffer_rgba(self):
        return self.pixels


def test_frames_of_a_film_last_a_thirtieth_of_a_second_on_average():
    from PIL import Image

    file = io.BytesIO()
    pictures.write_animation(iter(map(Frame, (60, 120, 180, 240))), file, "gif")
    with Image.open(file) as film:
        assert film.info["loop"] == 0
        assert (film.size, film.n_frames) == ((2, 3), 4)
        lasting, reds = [], []
        for k in range(4):
            film.seek(k)
            lasting.append(film.info["duration"])
            shown = film.convert("RGB")
            assert shown.getpixel((0, 0)) == (0, 0, 0)
            reds.append(shown.getpixel((1, 2))[0])
    assert reds == [60, 120, 180, 240]
    assert FRAMES_PER_S == 30
    assert lasting == [30, 40, 30, 30]  # of 0, 3.3, 6.7, 10 and 13.3 hundredths, each rounded


def test_pages_have_the_form_that_was_asked_for_and_a_margin_in_millimetres(monkeypatch):
    told = []

    @contextmanager
    def pages(file, metadata):
        told.append(("opened", file, metadata))
        yield Stub(savefig=lambda figure, bbox_inches: told.append((figure.name, bbox_inches)))

    def picture(name):
        def figure(form):
            told.append((name, form.font))
            return Stub(name=name, bbox_inches=Stub(padded=lambda inches: (name, inches)))

        return Stub(figure=figure)

    @contextmanager
    def look(font, style):
        told.append(("look", font, style))
        yield

    monkeypatch.setattr(backend_pdf, "PdfPages", pages)
    monkeypatch.setattr("camcli.plots.style.look", look)
    form = Stub(font="Serif", style="dark")
    pictures.write_pages([picture("a"), picture("b")], "file", form, margin=12.7)
    nothing = {"Creator": None, "Producer": None, "CreationDate": None}
    assert told == [
        ("look", "Serif", "dark"), ("opened", "file", nothing),
        ("a", "Serif"), ("a", ("a", 0.5)), ("b", "Serif"), ("b", ("b", 0.5)),
    ]  # fmt: skip
