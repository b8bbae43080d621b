"""cam figures, function by function: what is asked for, computed, kept and told, by hand."""

from __future__ import annotations

import json
import re
from concurrent.futures import Future
from contextlib import nullcontext
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

from camcli.cli import figures
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS, USAGE
from camcli.cli.figures import Figure, State
from camcli.cli.options import Request
from camcli.errors import Fault, SceneError
from camcli.output.certificate_check import CheckedCertificate
from camcli.output.digest import CHAOTIC, Drift
from camcli.piece_faults import PieceFault, gathering

HASHES = {"scene": "s", "data": "d", "program": "p"}


def figure(name, folder=Path("f"), shows="", command="sweep", **about):
    own = {"title": f"On {name}", "command": command, "shows": shows, "printed": {}, **about}
    scene = Made(figure=Made(**own))
    return Figure(name, folder / f"{name}.yaml", scene, command, HASHES)


def keep(out: Path, name: str, **more) -> None:
    """The state of a figure whose run is over."""
    (out / name).mkdir(parents=True, exist_ok=True)
    state = State(**{"hashes": HASHES, **more})
    (out / name / figures.STATE).write_text(state.model_dump_json())


@pytest.fixture
def noted(monkeypatch):
    found: list[str] = []
    monkeypatch.setattr(figures, "note", found.append)
    return found


# --- the command


@pytest.mark.parametrize("check", [False, True])
@pytest.mark.parametrize("update", [False, True])
def test_figures_are_brought_up_to_date(tmp_path, monkeypatch, capsys, noted, check, update):
    """Those that have changed are computed, those asked for are told of, the page has all."""
    known = [figure("3.5", tmp_path), figure("3.6a", tmp_path, "{x}"), figure("3.6b", tmp_path)]
    done: list = []
    clock = iter([10.0, 17.5])
    out = tmp_path / "out"
    out.mkdir()
    (out / figures.FAULTS).write_text("old")
    keep(out, "3.6b")
    drift = Drift("3.6a", "regular", "x", 1, 2)

    def compute(request, wanted, why, out):
        done.append(([one.name for one in wanted], dict(why)))
        keep(out, "3.6a")
        return {one.name: State(hashes={}) for one in wanted}

    monkeypatch.setattr(figures, "figures_in", lambda *given: done.append(given) or known)
    monkeypatch.setattr(
        figures, "reason", lambda one, folder: "new" if one.name == "3.6a" else "unchanged"
    )
    monkeypatch.setattr(figures, "_compute", compute)
    monkeypatch.setattr(figures, "page", lambda entries: f"{[one.name for one in entries]}")
    monkeypatch.setattr(figures, "_drifts", lambda asked, out: [drift])
    monkeypatch.setattr(figures, "_show", lambda *given: done.append(given[1:]))
    monkeypatch.setattr(figures, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(figures, "_refuse_beside_update", lambda *given: done.append(given))
    monkeypatch.setattr(
        figures, "update", lambda asked, known, states: done.append((len(known), [*states]))
    )
    for name in ("3.5", "3.6a", "3.6b"):
        (tmp_path / f"{name}.yaml").write_text("scene")
    request = Request(out=out, sets=["a=1"], width="10mm")
    code = figures.figures(request, ["3.6"], tmp_path, check, update)
    why = {"3.6a": "new", "3.6b": "unchanged"}
    if check:
        why = dict.fromkeys(why, "check")
    wanted = ["3.6a", "3.6b"] if check else ["3.6a"]
    ended = {name: State(hashes={}) for name in wanted}
    asked = known[1:]
    assert done == [
        *([(request, tmp_path, check)] if update else []),
        (tmp_path, ["a=1"], {"plot.width": (10.0, "--width")}),
        (wanted, why),
        *([(3, ["3.6a", "3.6b"])] if update else []),
        (asked, why, ended, [drift] if check else None, 7.5),
    ]
    lacks = f"{tmp_path}/3.6a.yaml: figure.shows: (The caption names 'x', which this run does not"
    told = [f"{tmp_path}/reference/: references of 2 figures"] if update else []
    assert noted[:-1] == told
    assert noted[-1].startswith(lacks)
    assert (out / "index.html").read_text() == "['3.5', '3.6a', '3.6b']"
    assert not (out / figures.FAULTS).exists()
    computed = f"{out}/index.html: {len(wanted)} of 2 figures computed in 7.5 s\n"
    assert capsys.readouterr().out == computed
    assert code == NUMERICS  # the caption lacks a number


def test_references_are_made_where_all_figures_have_their_numbers(
    tmp_path, monkeypatch, capsys, noted
):
    """The page is written even where a figure raises what nobody foresaw."""
    known = [figure("3.5", tmp_path), figure("3.6", tmp_path)]
    out = tmp_path / "out"
    monkeypatch.setattr(figures, "figures_in", lambda *given: known)
    monkeypatch.setattr(figures, "page", lambda entries: "page")
    monkeypatch.setattr(figures, "update", lambda *given: noted.append("updated"))
    monkeypatch.setattr(figures, "_entry", lambda *given: None)
    monkeypatch.setattr(figures, "_compute", lambda *given: {"3.5": State(hashes={}, exit=USAGE)})
    keep(out, "3.6")
    request = Request(out=out, json=True)
    assert figures.figures(request, None, tmp_path, False, True) == USAGE
    assert noted == []
    keep(out, "3.5", exit=DONE)
    monkeypatch.setattr(figures, "_compute", lambda *given: {})
    assert figures.figures(request, None, tmp_path, False, True) == DONE
    assert noted == ["updated", f"{tmp_path}/reference/: references of 2 figures"]
    keep(out, "3.6", exit=NUMERICS)
    assert figures.figures(request, None, tmp_path, False, False) == NUMERICS
    keep(out, "3.6")
    capsys.readouterr()
    assert figures.figures(request, None, tmp_path, False, False) == DONE
    assert len(json.loads(capsys.readouterr().out)["figures"]) == 2  # and nothing else
    shown = []
    drift = Drift("3.6", "regular", "x", 1, 2)
    monkeypatch.setattr(figures, "compared", lambda *given: [drift])
    assert figures.figures(request, None, tmp_path, True, False) == NUMERICS
    monkeypatch.setattr(figures, "compared", lambda *given: [])
    monkeypatch.setattr(figures, "_show", lambda *given: shown.append(given[4]))
    for check, drifted in ((True, []), (False, None)):
        assert figures.figures(request, None, tmp_path, check, False) == DONE
        assert shown.pop() == drifted
    (out / "index.html").unlink()

    def fails(*given):
        raise KeyError("x")

    monkeypatch.setattr(figures, "_compute", fails)
    with pytest.raises(KeyError):
        figures.figures(request, None, tmp_path, False, False)
    assert (out / "index.html").read_text() == "page"


@pytest.mark.parametrize("as_json", [False, True])
def test_a_plan_of_figures(tmp_path, monkeypatch, capsys, as_json):
    keep(tmp_path, "3.6", seconds=7.25)
    shown = []
    monkeypatch.setattr(figures, "table", lambda *given: shown.append(given))
    known = [figure("3.5", Path("f")), figure("3.6", Path("f"), command="basins")]
    why = {"3.5": "new", "3.6": "data changed"}
    figures._show_plan(Request(json=as_json), known, why, tmp_path)
    rows = [["3.5", "new", None, "cam sweep -c f/3.5.yaml"],
            ["3.6", "data changed", 7.25, "cam basins -c f/3.6.yaml"]]  # fmt: skip
    heads = ["figure", "reason", "seconds", "command"]
    if as_json:
        plan = [dict(zip(heads, row, strict=True)) for row in rows]
        assert json.loads(capsys.readouterr().out) == {"command": "figures", "plan": plan}
        assert shown == []
        figures._show_plan(Request(), [], {}, tmp_path)
        assert shown[0][1:] == ([], [])
    else:
        cells = [["3.5", "new", "", rows[0][3]], ["3.6", "data changed", "7.25", rows[1][3]]]
        assert shown == [("cam figures, planned; seconds of the last time", heads, cells)]


def test_what_means_nothing_beside_an_update_is_refused(tmp_path):
    def said(folder=tmp_path, check=False, **more):
        with pytest.raises(SceneError) as refused:
            figures._refuse_beside_update(Request(**more), folder, check)
        return [(fault.where, fault.cure) for fault in refused.value.faults]

    figures._refuse_beside_update(Request(sets=[]), tmp_path, False)
    assert said(check=True, sets=["a=1"]) == [
        ("--check", "leave it out: a reference just written always agrees"),
        ("--set", "change the scenes instead"),
    ]
    installed = Path(figures.__file__).parents[1] / "configs"
    link = tmp_path / "link"
    link.symlink_to(installed)
    for folder in (installed, link):
        (found,) = said(folder)
        assert found == ("--folder", f"copy {folder} of the installed program first")


# --- which figures there are


def test_scenes_of_a_folder_are_in_the_order_of_their_numbers(tmp_path, monkeypatch):
    names = ["3.10", "3.9b", "3.9a", "10.1", "b", "3.9", "a2", "a10"]
    for name in names:
        (tmp_path / f"{name}.yaml").write_text("x")
    (tmp_path / "3.1.yml").write_text("x")
    asked = []

    def of_path(path, sets, plot):
        asked.append((sets, plot))
        if path.stem.startswith("a"):
            same = Fault("a", "", "found it", "", "")
            raise SceneError(same, Fault(path.stem, "", "found it", "", ""))
        return path.stem

    monkeypatch.setattr(figures, "_figure", of_path)
    with pytest.raises(SceneError) as refused:
        figures.figures_in(tmp_path, ["s"], {"p": (1, "")})
    assert [fault.where for fault in refused.value.faults] == ["a", "a2", "a10"]
    assert asked == [(["s"], {"p": (1, "")})] * 8
    for name in ("a2", "a10"):
        (tmp_path / f"{name}.yaml").unlink()
    assert figures.figures_in(tmp_path) == ["b", "3.9", "3.9a", "3.9b", "3.10", "10.1"]
    for folder, found in ((tmp_path / "no", "no such folder"), (tmp_path / "e", "no scenes")):
        (tmp_path / "e").mkdir(exist_ok=True)
        with pytest.raises(SceneError, match=f"found {found}"):
            figures.figures_in(folder)


def test_a_figure_is_a_scene_that_names_its_command(monkeypatch):
    """It depends on the scene, the table and the program; a page names its scene."""
    asked = []
    scene = Made(figure=Made(command="sweep"), cam=Made())
    monkeypatch.setattr(figures, "load_scene", lambda *given: asked.append(given) or scene)
    monkeypatch.setattr(figures, "_scene_hash", lambda scene: f"of {scene.figure.command}")
    monkeypatch.setattr(figures, "program_hash", lambda pictures: f"with pictures: {pictures}")
    monkeypatch.setattr(figures, "with_values", lambda *given, **values: (*given, values))
    path = Path("f/3.5.yaml")
    made = figures._figure(path, ["a=1"], {"p": (1, "")})
    assert asked == [(path, ["a=1"], {"p": (1, "")})]
    hashes = {"scene": "of sweep", "data": "", "program": "with pictures: True"}
    assert made == Figure("3.5", path, scene, "sweep", hashes)
    scene.cam, scene.figure.command = Made(sha256="table"), "explore"
    page = figures._figure(path, ["a=1"], None)
    assert page.scene == (scene, "explore", {"source": "-c f/3.5.yaml --set a=1"})
    assert page.hashes == {**hashes, "scene": "of explore", "data": "table"}
    scene.figure.command = "bench"
    assert figures._figure(path, [], None).command == "bench"
    scene.figure.command = "merge"
    with pytest.raises(SceneError, match=r"f/3.5.yaml: figure.command: found the command 'merge'"):
        figures._figure(path, [], None)
    scene.figure = None
    with pytest.raises(SceneError, match=r"f/3.5.yaml: figure: found no such section"):
        figures._figure(path, [], None)
    count = len(asked)
    with pytest.raises(SceneError, match="expected a name with a letter, rename it"):
        figures._figure(Path("f/...yaml"), [], None)
    assert len(asked) == count


def test_a_page_of_figures_needs_pngs_beside_other_forms():
    def formats(text):
        return figures._picture_values(Request(formats=text))

    assert formats(None) == {}
    assert formats("pdf,svg") == {"plot.formats": (["png", "pdf", "svg"], "--format")}
    assert formats("pdf,png") == {"plot.formats": (["png", "pdf"], "--format")}
    assert figures._picture_values(Request(width="8cm")) == {"plot.width": (80.0, "--width")}


def test_figures_are_those_of_the_folder_we_are_in(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(figures, "default_scene_path", lambda: Path("p/configs/x.yaml"))
    assert figures.default_folder() == Path("p/configs/figures")
    (tmp_path / "configs" / "figures").mkdir(parents=True)
    assert figures.default_folder() == Path("configs/figures")


@pytest.mark.parametrize(
    ("command", "own", "others"),
    [
        ("sweep", ("sweep", "run", "plot"), ("orbits", "basins", "explore", "bench", "figure")),
        ("explore", ("explore", "sweep", "orbits", "basins"), ("detach", "classify", "simulate")),
    ],
)
def test_a_figure_depends_on_what_its_command_reads(command, own, others):
    """Not on the hash of a table, which is that of the data, nor on a key's default."""

    def scene(**sections):
        values = {"cam": {"kind": "table", "sha256": "t"}, "follower": {"mass": 2.0}, **sections}
        return Made(figure=Made(command=command), simulate=Made(profile_only=False),
                    model_dump=lambda mode, exclude_defaults: {
                        key: dict(value) for key, value in values.items()})  # fmt: skip

    plain = figures._scene_hash(scene())
    assert re.fullmatch("[0-9a-f]{64}", plain)
    assert figures._scene_hash(scene(cam={"kind": "table", "sha256": "u"})) == plain
    for section in own:
        assert figures._scene_hash(scene(**{section: {"a": 1}})) != plain
    for section in others:
        assert figures._scene_hash(scene(**{section: {"a": 1}})) == plain
    assert figures._scene_hash(scene(follower={"mass": 3.0})) != plain


def test_the_figure_of_a_cam_alone_depends_on_its_speed_and_no_impact():
    def hashed(profile_only, rpm=700.0, record=1, command="simulate", **follower):
        values = {"cam": {"kind": "arcs"}, "follower": {"mass": 2.0, **follower},
                  "run": {"rpm": rpm, "record": record}}  # fmt: skip
        return figures._scene_hash(Made(
            figure=Made(command=command), simulate=Made(profile_only=profile_only),
            run=Made(rpm=rpm), model_dump=lambda mode, exclude_defaults: dict(values),
        ))  # fmt: skip

    for other, same in (({"rpm": 701.0}, False), ({"record": 2}, True),
                        ({"restitution": 0.5}, True), ({"mass": 3.0}, False)):  # fmt: skip
        assert (hashed(True, **other) == hashed(True)) is same
        assert hashed(False, **other) != hashed(False)
    assert hashed(True) != hashed(False)
    assert hashed(True, command="sweep") == hashed(False, command="sweep")


def test_why_a_figure_is_computed(tmp_path):
    """A key of the program that the state has not is a change; so is a file of other bytes."""
    one = figure("3.5")
    assert figures.reason(one, tmp_path / "3.5") == "new"
    for hashes, why in ((HASHES, "unchanged"), ({**HASHES, "data": "x"}, "data changed"),
                        ({"scene": "s", "data": "d"}, "program changed"), ({}, "scene changed"),
                        ({**HASHES, "more": "x"}, "unchanged")):  # fmt: skip
        keep(tmp_path, "3.5", hashes=hashes)
        assert figures.reason(one, tmp_path / "3.5") == why
    (tmp_path / "3.5" / "a.csv").write_text("a")
    (tmp_path / "3.5" / figures.STATE).unlink()
    figures._finish(tmp_path / "3.5", State(hashes=HASHES))
    assert figures.reason(one, tmp_path / "3.5") == "unchanged"
    (tmp_path / "3.5" / "a.csv").write_text("b")
    assert figures.reason(one, tmp_path / "3.5") == "artefact changed"
    (tmp_path / "3.5" / figures.STATE).write_text("{}")
    assert figures.reason(one, tmp_path / "3.5") == "new"


# --- computing


def test_a_finished_figure_keeps_its_files_but_for_large_tables(tmp_path):
    for name, size in (("b.csv", 100), ("a.csv", 101), ("a.png", 500), (".x", 1)):
        (tmp_path / name).write_bytes(b"x" * size)
    (tmp_path / "folder").mkdir()
    figures._finish(tmp_path, State(hashes=HASHES, seconds=7.5, notes=["n"]), 100)
    state = figures.read(State, tmp_path / figures.STATE)
    assert (list(state.files), state.seconds, state.notes) == (["a.png", "b.csv"], 7.5, ["n"])
    assert not (tmp_path / "a.csv").exists()
    assert state.files["b.csv"] == sha256(b"x" * 100).hexdigest()


@pytest.mark.parametrize(
    ("error", "code", "notes"),
    [
        (SceneError(Fault("a", "", "found b", "", "")), USAGE, ["a: found b"]),
        (MemoryError(), USAGE, ["cam: out of memory, ask for fewer speeds, recorded turns or "
                                "--threads (cam ... --dry-run)"]),
        (KeyError("x"), None, []),
    ],
)  # fmt: skip
@pytest.mark.parametrize("signal", [False, True])
def test_what_fails_in_a_figure(tmp_path, monkeypatch, error, code, notes, signal):
    """What is foreseen costs it alone; the state of its last run is gone either way."""
    monkeypatch.setattr(figures, "signal_came", lambda: signal)
    clock = iter([1.0, 3.45678])
    monkeypatch.setattr(figures, "perf_counter", lambda: next(clock))
    keep(tmp_path, "3.5")

    def fails(one, request):
        raise error

    monkeypatch.setattr(figures, "_drawn", fails)
    request = Request(out=tmp_path / "3.5")
    if code is None or (signal and not isinstance(error, SceneError)):
        with pytest.raises(type(error)):
            figures._computed(figure("3.5"), request)
    else:
        state = figures._computed(figure("3.5"), request)
        assert (state.exit, state.notes, state.seconds) == (code, notes, 2.457)
        assert state.hashes == HASHES
    assert not (tmp_path / "3.5" / figures.STATE).exists()


@pytest.mark.parametrize("confirmed", [None, False, True])
@pytest.mark.parametrize(("complete", "code"), [(True, DONE), (False, NUMERICS), (False, INTERNAL)])
def test_a_figure_is_drawn_with_its_digest(monkeypatch, confirmed, complete, code):
    """Speeds that its scene leaves open are those of its machine."""
    fault = {"pieces": ["p"], "error": "E", "place": ""}
    result = Made(tables="tables", complete=complete, notes=["note"])
    record = {"result": "result", "piece_faults": [] if complete else [fault]}
    checked = None
    if confirmed is not None:
        checked = CheckedCertificate(bytes=1, seconds=2.0, confirmed=confirmed, lines=["no: x"])
    done: list = []

    def records(name, found=None):
        return lambda *given, **more: done.append((name, *given, *more.values())) or found

    whole = Made()
    monkeypatch.setattr(figures, "command_of", lambda name: Made(name=name))
    monkeypatch.setattr(figures, "leaves_speeds_open", lambda scene, name: name == "sweep")
    monkeypatch.setattr(figures, "machine_of", lambda scene: Made(scene=whole))
    monkeypatch.setattr(figures, "check_panels", records("panels"))
    monkeypatch.setattr(figures, "check_before", records("before"))
    monkeypatch.setattr(figures, "open_folder", lambda *given: nullcontext("store"))
    monkeypatch.setattr(figures, "compute", records("compute", (result, record)))
    monkeypatch.setattr(figures, "digest", lambda *given: {"regular": {"of": given}})
    monkeypatch.setattr(figures, "exit_code", lambda *given: code)
    monkeypatch.setattr(figures, "check_certificate", lambda folder: checked)
    monkeypatch.setattr(figures, "certificate_refused", lambda lines: f"refused: {lines[0]}")
    request, command = Request(out=Path("o")), Made(name="sweep")
    state = figures._drawn(figure("3.5"), request)
    assert done == [
        ("panels", "sweep", whole, request), ("before", command, whole, Path("o"), True),
        ("compute", command, whole, request, "store", True),
    ]  # fmt: skip
    refused = ["refused: no: x"] if confirmed is False else []
    told = [] if complete else ["note", "fault: p: E", "this is a fault of camcli and cost these "
                                "pieces alone, please report it with o/run.json, which has the "
                                "traceback"]  # fmt: skip
    assert state.notes == told + refused
    assert state.exit == (NUMERICS if refused and code == DONE else code)
    assert (state.certificate, state.hashes) == (checked, HASHES)
    assert state.digest == {"regular": {"of": ("tables", "result")}}


@pytest.mark.parametrize(
    ("threads", "known", "count", "has_helpers"),
    [
        (4, 21.0, 2, True), (4, 20.0, 2, False), (4, 21.0, 5, True), (4, 20.0, 5, False),
        (1, 99.0, 3, False),
    ],
)  # fmt: skip
def test_figures_are_computed_the_longest_first(
    monkeypatch, noted, threads, known, count, has_helpers
):
    """Unknown ones before all; each has its share of the threads, and its own folder."""
    wanted = [figure(f"3.{k}") for k in range(count)]
    seconds = {"3.0": known / 3.0, "3.1": known * 2.0 / 3.0}
    begun, helpers = [], []

    class Helpers:
        def __init__(self, number):
            helpers.append(number)

        def call(self, function, one, request):
            return function(one, request)

        def end(self):
            helpers.append("ended")

    def computed(one, request):
        begun.append((one.name, request))
        if one.name == "3.0":
            raise KeyError("x")
        code = {"3.1": NUMERICS, "3.2": USAGE}.get(one.name, DONE)
        return State(hashes={}, exit=code, seconds=1.25, notes=["a", "b"] if code == 3 else [])

    monkeypatch.setattr(figures, "last_seconds", lambda one, out: seconds.get(one.name))
    monkeypatch.setattr(figures, "thread_count", lambda asked: threads)
    monkeypatch.setattr(figures, "progress_bar", lambda quiet: nullcontext(None))
    monkeypatch.setattr(figures, "_computed", computed)
    monkeypatch.setattr(figures, "Helpers", Helpers)
    monkeypatch.setattr(figures, "ThreadPoolExecutor", Pool)
    request = Request(threads=7)
    why = {one.name: f"why {one.name}" for one in [*wanted, *map(figure, "abcdefgh")]}
    with gathering() as faults:
        done = figures._compute(request, wanted, why, Path("o"))
    unknown = [one.name for one in wanted[2:]]
    order = [*unknown, "3.1", "3.0"]
    assert [name for name, _ in begun] == order
    assert helpers == ([min(threads, count), "ended"] if has_helpers else [])
    for name, own in begun:
        assert (own.out, own.quiet) == (Path("o") / name, True)
        assert own.threads == max(1, threads // count)
    assert list(done) == order
    assert done["3.0"].exit == INTERNAL
    assert [fault.piece for fault in faults] == ["3.0"]
    lines = {name: f"{name}: why {name}, 1.2 s" for name in order}
    lines["3.0"] = "3.0: why 3.0, 0.0 s, exit code 1"
    lines["3.1"] += ", exit code 3"
    after = ["3.1: a", "3.1: b", "3.0: fault, see below"]
    if "3.2" in lines:
        lines["3.2"] += ", exit code 2"
        after = ["3.2: exit code 2", *after]
    assert noted == [*(lines[name] for name in order), *after]


@pytest.mark.parametrize("quiet", [False, True])
def test_figures_are_counted_on_a_bar_or_told_line_by_line(monkeypatch, noted, quiet):
    """An interrupt ends those that are at work, and their helpers."""
    counted, asked = [], []
    wanted = [figure("3.5"), figure("3.6")]
    helpers = Made(call=lambda function, one, request: function(one, request),
                   end=lambda: asked.append("end"))  # fmt: skip
    monkeypatch.setattr(figures, "last_seconds", lambda one, out: 50.0)
    monkeypatch.setattr(figures, "thread_count", lambda threads: asked.append(threads) or 2)
    monkeypatch.setattr(figures, "_computed", lambda one, request: State(hashes={}, seconds=1.0))
    monkeypatch.setattr(figures, "Helpers", lambda count: helpers)
    monkeypatch.setattr(figures, "ThreadPoolExecutor", Pool)
    why = {"3.5": "new", "3.6": "new", "3.7": "unchanged"}
    for bar in (lambda *given: counted.append(given), None):
        monkeypatch.setattr(figures, "progress_bar", lambda quiet, bar=bar: nullcontext(bar))
        figures._compute(Request(quiet=quiet, threads=7), wanted, why, Path("o"))
    assert counted == [("figures", 1, 2), ("figures", 2, 2)]
    assert noted == ([] if quiet else ["3.5: new, 1.0 s", "3.6: new, 1.0 s"])
    assert asked == [7, "end"] * 2

    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr(figures, "raise_if_interrupted", interrupt)
    with pytest.raises(KeyboardInterrupt):
        figures._compute(Request(), wanted, why, Path("o"))
    assert asked[4:] == [None, "end"]
    assert figures._compute(Request(), [], {}, Path("o")) == {}


def test_a_figure_that_ends_in_trouble_is_counted_on_the_bar_too(monkeypatch, noted):
    counted = []
    wanted = [figure(name) for name in ("3.5", "3.6", "3.7")]
    codes = {"3.5": NUMERICS, "3.6": DONE, "3.7": USAGE}
    monkeypatch.setattr(figures, "last_seconds", lambda one, out: 1.0)
    monkeypatch.setattr(figures, "thread_count", lambda threads: 1)
    monkeypatch.setattr(
        figures, "_computed",
        lambda one, request: State(hashes={}, exit=codes[one.name], seconds=1.0),
    )  # fmt: skip
    monkeypatch.setattr(figures, "ThreadPoolExecutor", Pool)
    bar = lambda *given: counted.append(given)  # noqa: E731
    monkeypatch.setattr(figures, "progress_bar", lambda quiet: nullcontext(bar))
    figures._compute(Request(), wanted, dict.fromkeys(codes, "new"), Path("o"))
    assert counted == [("figures", number, 3) for number in (1, 2, 3)]


class Pool:
    """Threads that do what they are given at once."""

    def __init__(self, number: int) -> None:
        assert number > 0

    def submit(self, call, *given):
        future: Future = Future()
        future.set_result(call(*given))
        return future

    def shutdown(self, wait, cancel_futures):
        assert (wait, cancel_futures) == (False, True)


# --- what is told


def test_what_drifts_mean_together():
    """A figure without a reference is counted by itself."""
    missing = Drift("3.7", "solved", "r", None, f"{figures.NO_REFERENCE} (make it)")
    moved = [
        Drift("3.5", "regular", "a", 1, 2, portability=True),
        Drift("3.5", "regular", "b", 1, 2),
        Drift("3.6", CHAOTIC, "c", 1, 2, portability=True),
    ]
    assert figures.verdict([*moved, missing]) == figures.drift_verdict(3, 2, 2, 1)
    assert figures.verdict([missing]) == figures.drift_verdict(0, 0, 0, 1)
    assert figures.verdict([]) == figures.drift_verdict(0, 0, 0, 0)


def test_only_finished_figures_are_compared(tmp_path, monkeypatch):
    keep(tmp_path, "3.6", notes=["own"])
    keep(tmp_path, "3.7")

    def compared(one, state):
        if one.name == "3.7":
            raise KeyError("x")
        return [one.name, *state.notes]

    monkeypatch.setattr(figures, "compared", compared)
    with gathering() as faults:
        found = figures._drifts([figure("3.5"), figure("3.6"), figure("3.7")], tmp_path)
    assert found == ["3.6", "own"]
    assert [fault.piece for fault in faults] == ["the comparison of 3.7"]


def test_a_caption_that_names_a_number_that_is_not_there(tmp_path):
    keep(tmp_path, "3.6", digest={"regular": {"a": 1}, "solved": {"b": 2.5}})
    assert figures._lacks(figure("3.5", shows="{x}"), tmp_path) == []
    assert figures._lacks(figure("3.6", shows="{a} and {b|.1f}"), tmp_path) == []
    (said,) = figures._lacks(figure("3.6", shows="{a} and {x}"), tmp_path)
    assert said == f"f/3.6.yaml: figure.shows: {figures.caption_lacks(KeyError('x'))}"


def test_the_entry_of_a_figure_on_the_page(tmp_path):
    """Before it is computed its scene; then what its run left; its name alone where that fails."""
    one = figure("3.6", tmp_path, "{a} and {b|.1f}", printed={"a": 7.0, "c": 8.0})
    (tmp_path / "3.6.yaml").write_text("\ufeffscene")
    new = figures._entry(one, tmp_path / "3.6")
    assert (new.title, new.scene, new.caption, new.files) == ("On 3.6", "scene", "", ())
    checked = CheckedCertificate(bytes=1, seconds=2.0, confirmed=True, lines=[])
    digest = {"regular": {"a": 1}, "solved": {"b": 2.5}}
    keep(tmp_path, "3.6", digest=digest, files={"x.csv": "h"}, seconds=7.5, notes=["n"],
         certificate=checked)  # fmt: skip
    whole = figures._entry(one, tmp_path / "3.6")
    assert (whole.caption, whole.files, whole.seconds) == ("1 and 2.5", ["x.csv"], 7.5)
    assert (whole.notes, whole.certificate, whole.folder) == (["n"], checked, tmp_path / "3.6")
    assert whole.printed == {"a": (7.0, 1), "c": (8.0, None)}
    lacking = figures._entry(figure("3.6", tmp_path, "{x}"), tmp_path / "3.6")
    assert lacking.caption == figures.caption_lacks(KeyError("x"))
    assert lacking.seconds == 7.5
    with gathering() as faults:
        bare = figures._entry(figure("3.6", tmp_path, "{b|no format}"), tmp_path / "3.6")
    assert (bare.name, bare.title, bare.scene, bare.files) == ("3.6", "3.6", "", ())
    assert bare.command == f"cam sweep -c {tmp_path}/3.6.yaml"
    assert [fault.piece for fault in faults] == ["the entry of 3.6 in index.html"]


def test_faults_are_kept_and_told(tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(figures, "tell_faults", lambda *given: told.append(given))
    faults = [PieceFault("3.5", "E: 1", "p", "T"), PieceFault("3.6", "F: 2", "q", "U")]
    figures._write_faults(tmp_path, faults)
    records = [{"pieces": ["3.5"], "error": "E: 1", "place": "p", "traceback": "T"},
               {"pieces": ["3.6"], "error": "F: 2", "place": "q", "traceback": "U"}]  # fmt: skip
    assert json.loads((tmp_path / figures.FAULTS).read_text()) == records
    assert told == [(records, tmp_path / figures.FAULTS)]


@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize("drifted", [None, [], [Drift("3.5", CHAOTIC, "c", 1, 2)]])
def test_figures_on_the_screen(monkeypatch, capsys, noted, quiet, as_json, drifted):
    """A drift is a fault, which is said to who wants nothing said."""
    shown = []
    monkeypatch.setattr(figures, "table", lambda *given: shown.append(given))
    why = {"3.5": "new", "3.6": "unchanged"}
    done = {"3.5": State(hashes={}, seconds=1.25, exit=3)}
    request = Request(quiet=quiet, json=as_json)
    figures._show(request, [figure("3.5"), figure("3.6")], why, done, drifted, 9.5)
    rows = [["3.5", "On 3.5", "new", 1.25, 3], ["3.6", "On 3.6", "unchanged", 0.0, 0]]
    heads = ["figure", "title", "reason", "seconds", "exit"]
    said = capsys.readouterr().out
    verdict = [] if drifted is None else [figures.verdict(drifted)]
    lines = ["3.5: c (chaotic): reference 1, found 2"] if drifted else []
    if as_json:
        answer = json.loads(said)
        assert answer["figures"] == [dict(zip(heads, row, strict=True)) for row in rows]
        assert (answer["seconds"], answer.get("verdict")) == (9.5, *(verdict or [None]))
        assert ("drifts" in answer) == (drifted is not None)
        assert [one["name"] for one in answer.get("drifts", [])] == ["c"] * bool(drifted)
    else:
        assert shown == [("2 figures", heads, [[str(cell) for cell in row] for row in rows])]
        is_said = not quiet or drifted == []
        assert said.splitlines() == ([*lines, *verdict] if is_said else [])
    assert noted == ([*lines, *verdict] if drifted and quiet else [])
