"""Which files a result writes, in which order, and what an error of one of them costs."""

from __future__ import annotations

from contextlib import contextmanager
from io import BytesIO
from types import SimpleNamespace as Made

import pytest

import camcli
from camcli.analysis.integrate import Cost
from camcli.api import result
from camcli.errors import Fault, SceneError
from camcli.output.drawing_process import DrawnPicture
from camcli.output.run_folder import UnwritableError
from camcli.piece_faults import PieceFault


class Folder:
    """A folder that keeps what is done in it."""

    def __init__(self, old=None):
        self.files, self.log, self.old = {}, [], old or {}

    @property
    def names(self):
        return list(self.files)

    @property
    def hashes(self):
        return {name: f"hash of {name}" for name in self.files}

    def write(self, name, fill):
        self._write(name, fill, "write")

    def write_whole(self, name, fill):
        self._write(name, fill, "whole")

    def _write(self, name, fill, how):
        file = BytesIO()
        fill(file)
        self.files[name] = file.getvalue()
        self.log.append((how, name))

    def write_text(self, name, chunks):
        self.log.append(("text", name))

    @contextmanager
    def writing(self, name):
        raise AssertionError("no table shares its rows")

    def claim(self, names):
        self.log.append(("claim", *names))

    def keep_pictures(self, names, scene_hash):
        self.log.append(("keep", *names))
        return self.old

    def commit(self, kept):
        self.log.append(("commit", *kept))


def table(name):
    return Made(
        shared=None,
        npz=lambda file: file.write(f"{name} npz".encode()),
        write_csv=lambda file: file.write(f"{name} csv".encode()),
    )


def made(command="sweep", tables="npz", formats=("png", "pdf"), **more):
    scene = camcli.load_scene(None, {"sweep.tables": tables, "plot.formats": list(formats)})
    own = {
        "command": command, "scene": scene, "system": None, "values": None, "summary": {"a": 1},
        "tables": {name: table(name) for name in ("impacts", "speeds")}, "cost": Cost(),
        "pictures": {"sweep": lambda: "a sweep", "map": lambda: "a map"},
        "files": {"page.html": lambda file: file.write(b"page"),
                  "film.gif": lambda file: file.write(b"film")},
    }  # fmt: skip
    return result.Result(**{**own, **more})


@pytest.fixture
def drawn(monkeypatch):
    """What is drawn here: of which picture, as which kind, in which form."""
    seen = []

    def write_picture(picture, file, kind, form):
        seen.append((picture, kind, form))
        file.write(f"{picture} {kind}".encode())
        return [f"left out of {picture}"]

    monkeypatch.setattr("camcli.output.pictures.write_picture", write_picture)
    return seen


@pytest.mark.parametrize(
    ("command", "tables", "files"),
    [
        ("sweep", "npz", {"impacts.npz": b"impacts npz", "speeds.csv": b"speeds csv"}),
        ("sweep", "csv", {"impacts.csv": b"impacts csv", "speeds.csv": b"speeds csv"}),
        ("classify", "npz", {"impacts.csv": b"impacts csv", "speeds.csv": b"speeds csv"}),
    ],
)
def test_tables_of_a_sweep_are_arrays_where_they_are_asked_for(drawn, command, tables, files):
    """But for that of speeds, which has texts; files come behind tables and pictures."""
    folder = Folder()
    whole = made(command, tables)
    record = whole.write(folder)
    pictures = {f"{name}.{kind}": f"a {name} {kind}".encode()
                for name in ("sweep", "map") for kind in ("png", "pdf")}  # fmt: skip
    assert folder.files == {**files, **pictures, "page.html": b"page", "film.gif": b"film"}
    assert list(folder.files) == [*files, *pictures, "page.html", "film.gif"]
    assert [how for how, *_ in folder.log] == [
        *["write"] * 2, *["whole"] * 6, "claim", "text", "commit"
    ]  # fmt: skip
    assert folder.log[8] == ("claim", *folder.files, "run.json")
    assert folder.log[9:] == [("text", "run.json"), ("commit",)]
    assert record["artefacts"] == folder.hashes
    assert whole.left_out == {"sweep": ["left out of a sweep"], "map": ["left out of a map"]}
    assert {form for *_, form in drawn} == {whole.scene.plot}


def test_without_a_plot_pictures_of_the_same_scene_stay():
    """Nothing is drawn, by no process; what stays has its hash in the record."""
    folder = Folder(old={"map.pdf": "old hash"})
    process = Made(begin=None, next_drawn=None)
    record = made().write(folder, plot=False, drawing_process=process)
    assert list(folder.files) == ["impacts.npz", "speeds.csv", "page.html", "film.gif"]
    assert ("keep", "sweep.png", "sweep.pdf", "map.png", "map.pdf") in folder.log
    assert folder.log[-1] == ("commit", "map.pdf")
    assert record["artefacts"] == {**folder.hashes, "map.pdf": "old hash"}


def test_another_process_draws_what_it_can(drawn):
    """All pictures are asked for at once, in order; what it gives None for is drawn here."""
    begun = []
    answers = iter([DrawnPicture(b"drawn", ["force"], []), None, None,
                    DrawnPicture(b"drawn too", [], [])])  # fmt: skip
    process = Made(begin=begun.append, next_drawn=lambda: next(answers))
    folder = Folder()
    whole = made()
    whole.write(folder, drawing_process=process)
    (tasks,) = begun
    assert [(task.picture(), task.kind) for task in tasks] == [
        (f"a {name}", kind) for name in ("sweep", "map") for kind in ("png", "pdf")
    ]
    assert {task.form for task in tasks} == {whole.scene.plot}
    assert [(picture, kind) for picture, kind, _ in drawn] == [("a sweep", "pdf"), ("a map", "png")]
    assert (folder.files["sweep.png"], folder.files["map.pdf"]) == (b"drawn", b"drawn too")


def scene_error(name):
    return SceneError(Fault("", name, "found none", "expected one", "give it"))


def raising(error):
    def fill(file):
        raise error

    return fill


def test_the_first_error_of_a_scene_is_raised_when_all_else_is_in_its_place(drawn):
    """What nobody foresaw is a fault of the record, beside those of the result."""
    files = {"one": raising(scene_error("first")), "two": raising(ValueError("of a bug")),
             "three": raising(scene_error("second")),
             "four": lambda file: file.write(b"4")}  # fmt: skip
    folder = Folder()
    recorded = []
    old = PieceFault("700 rpm", "E", "place", "traceback")
    whole = made(files=files, faults=(old,))
    record = result.run_record
    try:
        result.run_record = lambda **given: recorded.append(given) or record(**given)
        with pytest.raises(SceneError, match="first"):
            whole.write(folder)
    finally:
        result.run_record = record
    assert folder.files["four"] == b"4"
    assert folder.log[-1] == ("commit",)
    (given,) = recorded
    told = str(given["piece_faults"])
    assert "700 rpm" in told
    assert "two" in told
    assert "of a bug" in told
    assert (given["command"], given["result"], given["verdict"]) == ("sweep", {"a": 1}, [])


@pytest.mark.parametrize("error", [UnwritableError(Fault("", "", "found no room", "", "")),
                                   KeyboardInterrupt()])  # fmt: skip
def test_a_folder_that_cannot_be_written_ends_the_run_at_once(drawn, error):
    folder = Folder()
    with pytest.raises(type(error)):
        made(files={"one": raising(error), "two": raising(AssertionError)}).write(folder)
    assert folder.log[-1][0] == "whole"


@pytest.mark.parametrize(
    ("style", "font", "error", "raised", "drawn_again"),
    [
        (None, None, ValueError("odd"), ValueError, False),
        (None, "serif", ValueError("odd"), ValueError, False),
        ("my.mplstyle", None, ValueError("odd " * 100), SceneError, True),
        ("my.mplstyle", None, OSError("no room"), OSError, False),
        ("my.mplstyle", None, scene_error("plot.panels"), SceneError, False),
    ],
)
def test_a_style_is_to_blame_where_a_picture_can_be_drawn_without_it(
    monkeypatch, style, font, error, raised, drawn_again
):
    """The reason is told in 200 characters; errors of the disk and of the scene are their own."""
    seen = []

    def write_picture(picture, file, kind, form):
        seen.append((picture, file, kind, form))
        if len(seen) == 1:
            raise error

    monkeypatch.setattr("camcli.output.pictures.write_picture", write_picture)
    whole = made()
    plot = whole.scene.plot.model_copy(update={"style": style, "font": font})
    object.__setattr__(whole, "scene", whole.scene.model_copy(update={"plot": plot}))
    file = BytesIO()
    with pytest.raises(raised) as caught:
        whole._draw("map", "pdf", file)
    assert len(seen) == 1 + drawn_again
    assert seen[0] == ("a map", file, "pdf", plot)
    if not drawn_again:
        assert caught.value is error
        return
    picture, other, kind, without = seen[1]
    assert (picture, kind) == ("a map", "pdf")
    assert other is not file
    assert without == plot.model_copy(update={"style": None})
    (fault,) = caught.value.faults
    assert (fault.where, fault.path) == (style, "plot.style")
    assert fault.found.startswith("found a style in which map.pdf cannot be drawn (odd odd")
    assert len(fault.found) < 300


def test_a_style_is_not_to_blame_where_a_picture_cannot_be_drawn_at_all(monkeypatch):
    def write_picture(picture, file, kind, form):
        raise ValueError("without style" if form.style is None else "with it")

    monkeypatch.setattr("camcli.output.pictures.write_picture", write_picture)
    whole = made()
    plot = whole.scene.plot.model_copy(update={"style": "my.mplstyle"})
    object.__setattr__(whole, "scene", whole.scene.model_copy(update={"plot": plot}))
    with pytest.raises(ValueError, match="without style"):
        whole._draw("map", "png", BytesIO())


def test_every_warning_of_another_process_is_told():
    drawn = DrawnPicture(b"png", [], ["of a font", "of a glyph"])
    with pytest.warns(UserWarning, match="of a") as told:
        made()._write_drawn("map", drawn, BytesIO())
    assert [str(one.message) for one in told] == ["of a font", "of a glyph"]


def test_every_panel_that_is_not_there_is_named():
    picture = Made(panels={"strobes": None, "kind": None},
                   lacking=lambda names: [name for name in names if name != "kind"])  # fmt: skip
    whole = made(pictures={"map": lambda: picture})
    with pytest.raises(SceneError) as caught:
        camcli.plot(whole, panels=["strobe", "kind", "enlarged"])
    assert [fault.found for fault in caught.value.faults] == ["found 'strobe'", "found 'enlarged'"]
    assert caught.value.faults[0].cure == "did you mean 'strobes'?"


def test_a_picture_is_drawn_by_its_name_in_the_form_that_is_asked_for():
    """The first one without a name; panels that the scene names are no fault of the caller."""

    def picture(name):
        return Made(figure=lambda section: (name, section), lacking=list)

    whole = made(pictures={name: lambda name=name: picture(name) for name in ("sweep", "map")})
    plot = whole.scene.plot.model_copy(update={"panels": ("strobe",), "height": 99.0})
    object.__setattr__(whole, "scene", whole.scene.model_copy(update={"plot": plot}))
    assert camcli.plot(whole) == ("sweep", plot)
    name, form = camcli.plot(whole, "map", width=123.0)
    assert (name, form) == ("map", plot.model_copy(update={"width": 123.0}))
    with pytest.raises(KeyError):
        camcli.plot(whole, "force")


def test_axes_of_ones_own_get_a_panel_each():
    """The first panels, unless they are named: then each has to have its axes."""

    class Axes:
        def __init__(self, name):
            self.name, self.drawn = name, []

        def get_figure(self, root):
            assert root
            return f"figure of {self.name}"

    def panel(name):
        return Made(draw=lambda axes: axes.drawn.append(name))

    panels = {name: panel(name) for name in ("impacts", "strobe", "kind")}
    picture = Made(panels=panels, lacking=lambda names: [],
                   chosen=lambda names: {one: panels[one] for one in names or panels})  # fmt: skip
    whole = made(pictures={"sweep": lambda: picture})
    one, two = Axes("one"), Axes("two")
    assert camcli.plot(whole, axes=[one, two]) == "figure of one"
    assert (one.drawn, two.drawn) == (["impacts"], ["strobe"])
    assert camcli.plot(whole, axes=two, panels=["kind"]) == "figure of two"
    assert two.drawn == ["strobe", "kind"]
    camcli.plot(whole, axes=(two, one), panels=["kind", "impacts"])
    assert (one.drawn, two.drawn) == (["impacts", "impacts"], ["strobe", "kind", "kind"])
    with pytest.raises(SceneError, match="found 2 panels and 1 axes"):
        camcli.plot(whole, axes=one, panels=["kind", "strobe"])


@pytest.mark.parametrize(
    ("command", "kind", "contact", "record"),
    [("simulate", "arcs", False, None), ("detach", "arcs", True, None),
     ("detach", "table", True, "record")],
)  # fmt: skip
def test_the_verdict_is_told_of_the_loss_of_contact_and_the_table(
    monkeypatch, command, kind, contact, record
):
    """Of a single motion without the first loss; bounds of a lift table where there is one."""
    monkeypatch.setattr("camcli.words.verdict.verdict", lambda *given: Made(
        lines=given[1:], details=[given[0].command]))  # fmt: skip
    monkeypatch.setattr(
        "camcli.analysis.contact_loss.detachment.detachment", lambda system: f"lost by {system}"
    )
    monkeypatch.setattr("camcli.api.lift_table.table_record", lambda cam, system: "record")
    monkeypatch.setattr(result, "error_record", lambda tolerance, system: {"event": tolerance})
    scene = Made(cam=Made(kind=kind), run=Made(chatter_tolerance=0.25))
    whole = made()
    for name, value in {"scene": scene, "system": "system", "command": command}.items():
        object.__setattr__(whole, name, value)
    assert whole.verdict == ("lost by system" if contact else None, record)
    assert whole.verdict_details == [command]
    assert whole.error == {"event": 0.25, **({"lift_table": "record"} if record else {})}
    bare = made()
    assert (bare.error, bare.verdict, bare.verdict_details) == ({}, [], [])
