"""The frame of a run, function by function: what is set, checked, noted and told, by hand."""

from __future__ import annotations

import logging
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

from camcli.cli import run
from camcli.cli.exit_codes import DONE, INTERNAL
from camcli.cli.options import Request
from camcli.errors import SceneError
from camcli.kernel.code_cache import News
from camcli.parallel import Shard


@pytest.fixture
def noted(monkeypatch):
    """The notes of a run."""
    found: list[str] = []
    monkeypatch.setattr(run, "note", found.append)
    return found


# --- what the options set


def test_one_speed_and_its_points_are_set_with_the_option_of_each():
    assert run.one_speed(Request(rpm="700", points="31")) == {
        "run.rpm": (700.0, "--rpm"), "simulate.samples": (31, "--points")
    }  # fmt: skip
    assert run.one_speed(Request(rpm="6000crank"))["run.rpm"][0].startswith("6000")
    assert run.one_speed(Request()) == {}
    with pytest.raises(SceneError, match=r"^--rpm: found the range '1:2', expected one speed, use"):
        run.one_speed(Request(rpm="1:2"))


def test_ranges_are_set_with_the_option_of_each():
    assert run.ranges(Request(rpm="700:600", points="2"), "detach") == {
        "detach.rpm.start": (700.0, "--rpm"), "detach.rpm.stop": (600.0, "--rpm"),
        "detach.rpm.num": (2, "--points"),
    }  # fmt: skip
    assert run.ranges(Request(rpm="700"), "detach")["detach.rpm.num"] == (1, "--rpm")
    with pytest.raises(SceneError, match=r"--points: found 2 and one speed, give a range"):
        run.ranges(Request(rpm="700", points="2"), "detach")
    values = run.ranges(Request(rpm="700"), "orbits", ["cam.lift=1:2"], 1, "--in")
    axis = {"key": "cam.lift", "start": 1.0, "stop": 2.0}
    assert values == {"run.rpm": (700.0, "--rpm"), "orbits.vary": ([axis], "--in")}
    speeds = {"key": "rpm", "start": 600.0, "stop": 700.0}
    values = run.ranges(Request(rpm="600:700", points="3,5"), "sweep", ["cam.lift=1:2"], 2)
    assert values == {"sweep.vary": ([{**speeds, "num": 3}, {**axis, "num": 5}], "--vary")}
    words = (
        "^--in: found 2 numbers to vary, expected at most 1, give --rpm one speed, or fewer --in"
    )
    with pytest.raises(SceneError, match=words):
        run.ranges(Request(rpm="600:700"), "orbits", ["cam.lift=1:2"], 1, "--in")


@pytest.mark.parametrize("key", ["rpm", "run.rpm"])
def test_an_axis_of_speeds_may_be_one_of_a_crank(key):
    """It keeps its key; another number has no crank, and an axis in rpm is two numbers."""
    axis = run._axis(f" {key} =1000crank:1500crank", "--vary")
    assert (axis["key"], len(axis)) == (key, 3)
    assert [float(axis[end].split("crank")[0]) for end in ("start", "stop")] == [1000.0, 1500.0]
    one = run._axis(f"{key}=1000crank", "--vary")
    assert one["start"] == one["stop"]
    assert run._axis(f"{key}=100:150", "--vary") == {"key": key, "start": 100.0, "stop": 150.0}
    with pytest.raises(SceneError, match=r"^--in: found '.*', expected KEY=LO:HI, e\.g\. follower"):
        run._axis("cam.lift=1crank:2crank", "--in")


@pytest.mark.parametrize(
    ("points", "axes", "wanted"),
    [
        (None, 3, [None, None, None]), ("7", 1, [7]), (" 7", 3, [7, 7, 7]), ("7, 5", 2, [7, 5]),
        ("1" * 30, 1, [int("1" * 30)]),
        ("7,5", 1, "expected a whole number above 0, give one number for each that is varied"),
        ("7,5,3", 2, "expected a whole number above 0, or N,M, give one number for each that is "
                     "varied"),
        ("x", 1, "expected a whole number above 0, e.g. --points 41"),
        ("-7", 2, "expected a whole number above 0, or N,M, e.g. --points 41"),
        ("7.5", 3, "expected a whole number above 0, e.g. --points 41"),
        ("1" * 31, 1, "expected a whole number above 0, e.g. --points 41"),
        ("1," + "1" * 31, 2, "expected a whole number above 0, or N,M, e.g. --points 41"),
    ],
)  # fmt: skip
def test_the_numbers_of_points(points, axes, wanted):
    if isinstance(wanted, list):
        assert run.points_of(Request(points=points), axes) == wanted
        return
    with pytest.raises(SceneError) as refused:
        run.points_of(Request(points=points), axes)
    assert str(refused.value) == f"--points: found '{points}', {wanted}"


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (None, None), ("1/1", (1, 1)), ("3/16", (3, 16)), ("100000/100000", (100000, 100000)),
        ("0/2", "refused"), ("3/2", "refused"), ("1/100001", "refused"), ("1", "refused"),
        ("1/", "refused"), ("/2", "refused"), ("-1/2", "refused"), ("1/2/3", "refused"),
        ("\u0661/2", "refused"), ("1/\u0662", "refused"),
    ],
)  # fmt: skip
def test_the_shard_that_is_asked_for(text, wanted):
    if wanted != "refused":
        assert run.shard_of(text) == wanted
        return
    with pytest.raises(SceneError) as refused:
        run.shard_of(text)
    expected = "expected I/N with 1 <= I <= N <= 100000, e.g. 3/16"
    assert str(refused.value).endswith(expected)


# --- what is done before, and by whom


@pytest.mark.parametrize(
    ("font", "style", "drawn", "looked_at"),
    [
        (None, None, True, False), ("x", None, True, True), (None, "y", True, True),
        ("x", "y", False, False),
    ],
)  # fmt: skip
def test_a_look_is_tried_where_something_is_drawn(monkeypatch, font, style, drawn, looked_at):
    looks, sizes = [], []
    monkeypatch.setattr("camcli.plots.style.check_look", lambda *given: looks.append(given))
    monkeypatch.setattr(
        "camcli.cli.sizes.refuse_too_large", lambda *given, **more: sizes.append((given, more))
    )
    scene = Made(plot=Made(font=font, style=style))
    run.check_before("command", scene, Path("out"), drawn, Shard(1, 3))
    assert looks == [(font, style)] * looked_at
    assert sizes == [(("command", scene, Path("out")), {"drawn": drawn, "shard": Shard(1, 3)})]


@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("dry_run", [False, True])
@pytest.mark.parametrize("chosen", [{}, {"basins": 5, "sweep": 7}, {"basins": 5}])
def test_a_run_is_checked_before_it_begins(monkeypatch, noted, quiet, dry_run, chosen):
    """The speeds of this command alone are told, and the scene has them from there on."""
    done: list = []

    def records(name, result=None):
        return lambda *given, **more: done.append((name, *given, *more.values())) or result

    scene, whole = Made(), Made()
    request = Request(config=Path("a"), sets=["b=1"], rpm="7", no_plot=True, quiet=quiet,
                      dry_run=dry_run, width="10mm")  # fmt: skip
    command = Made(name="sweep")
    monkeypatch.setattr(run, "load_scene", records("load", scene))
    monkeypatch.setattr("camcli.cli.panels.check_panels", records("panels"))
    for name in ("_tell", "_tell_of_unused_speed", "_tell_of_a_crank", "_tell_of_size"):
        monkeypatch.setattr(run, name, records(name))
    monkeypatch.setattr("camcli.api.machine.leaves_speeds_open", lambda *given: given[0] is scene)
    monkeypatch.setattr(
        "camcli.api.machine.machine_of", lambda given: Made(scene=whole, chosen=chosen)
    )
    monkeypatch.setattr("camcli.words.speeds.chosen_speeds", lambda *given: given)
    monkeypatch.setattr("camcli.api.command.command_of", lambda name: command)
    monkeypatch.setattr(run, "check_before", records("check"))
    monkeypatch.setattr(run, "execute", records("execute", 3))
    monkeypatch.setattr("camcli.cli.forecast.forecast", records("forecast"))
    monkeypatch.setattr(run, "compiling", lambda given: nullcontext())
    code = run.run("sweep", request, {"x": (1, "-x")}, "show", shard="2/5", cluster="local")
    part = Shard(2, 5)
    told = [("_tell", scene, Path("a")), ("_tell_of_unused_speed", "sweep", scene, request),
            ("_tell_of_a_crank", "sweep", scene)]  # fmt: skip
    values = {"x": (1, "-x"), "plot.width": (10.0, "--width")}
    end = [("forecast", command, whole, request, part)]
    if not dry_run:
        end = [] if quiet else [("_tell_of_size", command, whole)]
        end.append(("execute", command, whole, request, "show", part, "local"))
    assert done == [
        ("load", Path("a"), ["b=1"], values, "sweep"),
        ("panels", "sweep", scene, request),
        *([] if quiet else told),
        ("check", command, whole, Path("out/sweep"), False, part),
        *end,
    ]
    assert code == (DONE if dry_run else 3)
    assert noted == ([("sweep", 7)] if "sweep" in chosen and not quiet else [])


@pytest.mark.parametrize(
    ("tables", "kept", "less", "said"),
    [
        (200e6, 200e6, "less", []),
        (123456789.0, 300e6, "", ["note: this writes at least 123 MB of files, and 300 MB of "
                                  "pieces until then; see cam sweep --dry-run"]),
        (2.5e9, 1e6, "leave it out", ["note: this writes at least 2.5 GB of files, and 1 MB of "
                                      "pieces until then; leave it out; see cam sweep --dry-run"]),
        (201e6, 0, "", ["note: this writes at least 201 MB of files; see cam sweep --dry-run"]),
    ],
)  # fmt: skip
def test_much_to_write_is_told_with_how_to_write_less(noted, tables, kept, less, said):
    command = Made(name="sweep", less=less, size=lambda scene: Made(tables=tables, kept=kept))
    run._tell_of_size(command, None)
    assert noted == said


@pytest.mark.parametrize("faults", [[], ["fault"]])
def test_a_shard_that_is_done_has_no_record_of_its_own(monkeypatch, faults):
    """Its code is that of its faults; else it is that of the result and its record."""
    folder = Made(work=Made(faults=faults, failed=False), folder=Path("f"), shard_done=True)
    monkeypatch.setattr(run, "open_folder", lambda *given, **more: nullcontext(folder))
    record = {"piece_faults": []}
    monkeypatch.setattr(run, "compute", lambda *given: ("result", record))
    monkeypatch.setattr(run, "_say", lambda *given: None)
    monkeypatch.setattr(run, "exit_code", lambda *given: given)
    request = Made(no_plot=False)
    assert run.execute("command", None, request, None) == (INTERNAL if faults else DONE)
    folder.shard_done = False
    assert run.execute("command", None, request, None) == ("result", record)


@pytest.mark.parametrize("plot", [False, True])
@pytest.mark.parametrize("process", [None, "process"])
@pytest.mark.parametrize("pictures", [{}, {"sweep": 1}])
def test_what_draws_is_imported_while_nothing_else_is_at_work(monkeypatch, plot, process, pictures):
    """Only where this process draws; what was on disk before is told to the record."""
    done = []
    result = Made(pictures=pictures, write=lambda folder, **more: done.append(more) or "record")

    def in_pieces(work):
        return lambda scene, progress: done.append((work, scene, progress)) or result

    @contextmanager
    def bar(quiet):
        yield "bar" if quiet else None

    monkeypatch.setattr(run, "process_for", lambda command, scene: process)
    monkeypatch.setattr(run, "_keep_matplotlib_quiet", lambda: done.append("quiet"))
    monkeypatch.setattr(run, "compiling", lambda request: nullcontext())
    monkeypatch.setattr(run, "progress_bar", bar)
    monkeypatch.setattr(run, "import_what_draws", done.append)
    request, folder = Made(quiet=True), Made(work="work", resumed=7)
    found = run.compute(Made(in_pieces=in_pieces), "scene", request, folder, plot)
    assert found == (result, "record")
    imported = [run.WHAT_DRAWS] if plot and pictures and process is None else []
    drawn_by = process if plot else None
    assert done == [
        *["quiet"] * plot, ("work", "scene", "bar"), *imported,
        {"plot": plot, "from_disk": 7, "drawing_process": drawn_by},
    ]  # fmt: skip


def test_of_matplotlib_only_errors_are_heard():
    logger = logging.getLogger("matplotlib")
    before = logger.level
    try:
        logger.setLevel(logging.WARNING)
        run._keep_matplotlib_quiet()
        assert not logger.isEnabledFor(logging.WARNING)
        assert logger.isEnabledFor(logging.ERROR)
    finally:
        logger.setLevel(before)


# --- the folder of a run, and its pieces


class Folder:
    """A run folder that is opened, and what it was opened with."""

    def __init__(self, checkpoint=None, mixed=(), shard_done=False, committed=False) -> None:
        self.work = Made(checkpoint=checkpoint, faults=[])
        self.mixed, self.shard_done, self.committed = mixed, shard_done, committed
        self.asked: list = []

    @contextmanager
    def __call__(self, path, key, **more):
        self.asked.append((path, key, more))
        yield self


@pytest.mark.parametrize("keeps", [False, True])
def test_the_pieces_of_a_run_are_known_by_what_decides_their_numbers(monkeypatch, keeps):
    """The follower, the cam, the run and the command's own section; not how pictures look."""
    values = {"follower": 1, "cam": 2, "run": 3, "sweep": 4, "basins": 5, "plot": 6}
    folder = Folder()
    monkeypatch.setattr(run, "resolved", lambda scene: values)
    monkeypatch.setattr(run, "run_folder", folder)
    command = Made(name="sweep", keeps_pieces=lambda scene: keeps, artefacts=("a.csv", "b.csv"),
                   pictures=("sweep", "map"))  # fmt: skip
    scene = Made(plot=Made(formats=("png", "pdf")))
    request = Request(threads=3, no_plot=True)
    parts = (Path("p"),)
    with run.open_folder(command, scene, request, shard="s", cluster="c", parts=parts) as found:
        assert found is folder
    ((path, key, more),) = folder.asked
    assert path == Path("out/sweep")
    deciding = {name: values[name] for name in ("follower", "cam", "run", "sweep")}
    assert key == ({"command": "sweep", "scene": deciding} if keeps else None)
    names = ["a.csv", "b.csv", "sweep.png", "sweep.pdf", "map.png", "map.pdf"]
    about = {"scene": values, "plot": False}
    assert more == {"threads": 3, "cluster": "c", "shard": "s", "parts": parts, "names": names,
                    "about": about}  # fmt: skip


@pytest.mark.parametrize("quiet", [False, True])
def test_what_is_told_of_a_folder_while_it_is_open(monkeypatch, noted, quiet):
    told = []
    monkeypatch.setattr(run, "resolved", lambda scene: {})
    monkeypatch.setattr(run, "_tell_of_pieces", lambda *given: told.append(given))
    monkeypatch.setattr(run, "_tell_of_shard", lambda *given: told.append(given))
    command = Made(name="sweep", keeps_pieces=lambda scene: True, artefacts=(), pictures=())
    scene, request = Made(plot=Made(formats=())), Request(quiet=quiet)

    def opened(folder, interrupt=False, **more):
        told.clear()
        noted.clear()
        monkeypatch.setattr(run, "run_folder", folder)
        with run.open_folder(command, scene, request, **more):
            if interrupt:
                raise KeyboardInterrupt

    pieces = Made(pieces=1, path=Path("p"))
    folder = Folder(pieces, ("a.csv", "b.csv"))
    opened(folder)
    mixed = "note: out/sweep/ holds files of a run that was killed while it put them there"
    assert [text.removeprefix("note: ") for text in noted] == [
        f"{mixed} (a.csv, b.csv): they are made anew".removeprefix("note: ")
    ] * (not quiet)
    assert told == [(folder, False)] * (not quiet)
    opened(Folder(None))
    assert (told, noted) == ([], [])
    shards = Folder(pieces, shard_done=True)
    opened(shards, shard="s", parts=(Path("x"),))
    assert told == [(shards, True)] * (not quiet) + [(command, "s", shards, Path("p"), request)]
    for count, verb in ((1, "1 piece is"), (2, "2 pieces are")):
        with pytest.raises(KeyboardInterrupt):
            opened(Folder(Made(pieces=count, path=None)), True)
        assert noted == [f"{verb} on disk, the same command goes on from them"]
    for folder in (Folder(None), Folder(Made(pieces=0)), Folder(pieces, committed=True)):
        with pytest.raises(KeyboardInterrupt):
            opened(folder, True)
        assert noted == []


@pytest.mark.parametrize(
    ("resumed", "torn", "damaged", "merging", "said"),
    [
        (0, 0, 0, False, []),
        (1, 0, 0, False, ["going on: 1 piece is on disk"]),
        (7, 0, 0, False, ["going on: 7 pieces are on disk"]),
        (7, 0, 0, True, []),
        (0, 1, 2, True, ["a piece was torn: the last 1 byte is computed again",
                         "2 bytes on disk are damaged and passed over"]),
        (0, 5, 1, False, ["a piece was torn: the last 5 bytes are computed again",
                          "1 byte on disk is damaged and passed over"]),
    ],
)  # fmt: skip
def test_pieces_that_are_there_torn_or_damaged(
    tmp_path, noted, resumed, torn, damaged, merging, said
):
    own = Made(path=tmp_path / ".own.pieces", torn=torn, damaged=damaged, pieces=1)
    (tmp_path / ".own.pieces").write_bytes(b"x")
    folder = Made(folder=tmp_path, work=Made(checkpoint=own), resumed=resumed)
    run._tell_of_pieces(folder, merging)
    assert noted == said


# --- what is said of the scene


@pytest.mark.parametrize("config", [None, Path("my.yaml")])
@pytest.mark.parametrize("kind", ["table", "arcs"])
@pytest.mark.parametrize("made_up", [[], ["follower.mass", "cam.lift"]])
def test_doubts_of_a_scene_are_told_in_order(monkeypatch, noted, config, kind, made_up):
    monkeypatch.setattr(run, "_tell_of_scene_file", lambda file: noted.append(file))
    monkeypatch.setattr(run, "made_up", lambda scene: made_up)
    monkeypatch.setattr("camcli.words.machine.doubts", lambda scene: ["doubt 1", "doubt 2"])
    monkeypatch.setattr("camcli.words.machine.lossless_notes", lambda scene: ["lossless"])
    monkeypatch.setattr("camcli.words.lift_table.table_notes", lambda scene: ["of a table"])
    run._tell(Made(cam=Made(kind=kind)), config)
    file = "" if config is None else "my.yaml: "
    fill_in = (
        f"note: {file}FILL IN: cam init made up follower.mass, cam.lift; put your numbers there"
    )
    assert noted == [
        *([] if config is None else [config]), *([fill_in] if made_up else []), "doubt 1",
        "doubt 2", *(["of a table"] if kind == "table" else []), "lossless",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\n", None),
        ("CHECK: 1\n", None),  # a key
        ("a: 1\nb: 2 # CHECK: is it?\n", "line 2"),
        ("# CHECK # twice\nb: 2\nc: 3  # see, CHECK\nCHECK: 4 # no\n", "lines 1, 3"),
    ],
)
def test_lines_that_are_marked_are_told(tmp_path, monkeypatch, noted, text, said):
    path = tmp_path / "my.yaml"
    path.write_text(text)
    monkeypatch.setattr(run, "here_or_shipped", lambda file: file)
    run._tell_of_scene_file(path)
    assert noted == ([] if said is None else [f"note: {path}: {said}: CHECK: {run.CHECKS}"])
    noted.clear()
    monkeypatch.setattr(run, "here_or_shipped", lambda file: tmp_path / "shipped.yaml")
    gone = tmp_path / "gone.yaml"
    run._tell_of_scene_file(gone)
    shipped = tmp_path / "shipped.yaml"
    assert noted == [f"note: there is no {gone} here, so camcli takes its own: {shipped}"]


@pytest.mark.parametrize(
    ("name", "sets", "vary", "told"),
    [
        ("sweep", ["run.rpm=7"], (), True), ("basins", ["a=1", " run.rpm =7"], (), True),
        ("classify", ["run.rpm=7"], (), True), ("sweep", ["run.rpm=7"], ("x",), False),
        ("sweep", ["run.rpms=7"], (), False), ("sweep", None, (), False),
        ("simulate", ["run.rpm=7"], (), False), ("orbits", ["run.rpm=7"], (), False),
    ],
)  # fmt: skip
def test_a_speed_that_is_not_used_is_told(noted, name, sets, vary, told):
    run._tell_of_unused_speed(name, Made(**{name: Made(vary=vary)}), Request(sets=sets))
    said = f"note: --set run.rpm is not used: cam {name} takes its speeds from {name}.rpm; give"
    assert [text.startswith(said) for text in noted] == [True] * told


def test_speeds_of_a_crank_are_told_on_both_shafts(monkeypatch, noted):
    """Those that the scene states: either end alone, or axes of the speed, of each its own."""
    monkeypatch.setattr("camcli.words.speeds.of_both_shafts", lambda low, high: f"{low} to {high}")

    def told(crank=True, stated=("start",), **more):
        noted.clear()
        rpm = Made(start=600.0, stop=700.0, model_fields_set={*stated})
        run._tell_of_a_crank("sweep", Made(run=Made(crank=crank), sweep=Made(rpm=rpm, **more)))
        return [*noted]

    of_the_range = ["note: sweep.rpm is 600.0 to 700.0"]
    assert told() == told(stated=("stop", "num")) == told(vary=()) == of_the_range
    assert told(crank=False) == told(stated=("num",)) == []
    axes = [Made(key="follower.mass", start=1.0, stop=2.0), Made(key="rpm", start=3.0, stop=4.0),
            Made(key="run.rpm", start=5.0, stop=6.0)]  # fmt: skip
    assert told(vary=axes) == ["note: rpm is 3.0 to 4.0", "note: run.rpm is 5.0 to 6.0"]
    run._tell_of_a_crank("sweep", Made(run=Made(crank=True), sweep=Made(vary=())))
    run._tell_of_a_crank("simulate", Made(run=Made(crank=True)))
    assert len(noted) == 2


# --- what is said of the result


@pytest.mark.parametrize("command", ["simulate", "detach", "sweep"])
@pytest.mark.parametrize("verbose", [False, True])
def test_a_result_on_the_screen(monkeypatch, capsys, noted, command, verbose):
    """The answer first; its details to who asks, the cost where there were impacts."""
    record = {
        "verdict": ["verdict"], "verdict_details": ["detail"], "cost": "cost",
        "artefacts": {"b.csv": 1, "a.png": 2}, "error": {"lift_table": "table"},
    }  # fmt: skip
    monkeypatch.setattr("camcli.words.cost.cost_line", lambda *given: f"{given[0]} with an error")
    monkeypatch.setattr("camcli.words.lift_table.bound_line", lambda given: f"of the {given}")
    result = Made(command=command, system="system", cost=Made(impacts=3), notes=[], left_out={},
                  complete=True)  # fmt: skip
    shown = []

    def show(*given):
        shown.append(given)
        print("shown")

    run._say(result, record, Request(out=Path("o"), verbose=verbose), show)
    answers = ["verdict", *["detail"] * verbose] if command != "sweep" else []
    end = ["shown", "o/: b.csv, a.png, run.json", "cost with an error", "of the table"]
    assert capsys.readouterr().out.splitlines() == [*answers, *end]
    assert shown == [(result, verbose)]
    record["error"] = {}
    for system, impacts in (("system", 0), (None, 3)):
        result.system, result.cost = system, Made(impacts=impacts)
        run._say(result, record, Request(verbose=verbose), show)
        assert capsys.readouterr().out.splitlines()[-1] == (
            f"out/{command}/: b.csv, a.png, run.json"
        )


@pytest.mark.parametrize("quiet", [False, True])
@pytest.mark.parametrize("complete", [False, True])
def test_notes_on_a_result(noted, quiet, complete):
    """Those of a run in trouble are told to who wants nothing said, panels without room are not."""
    scene = Made(plot=Made(formats=("svg", "png")))
    left_out = {"sweep": ["strobe", "impacts"], "map": []}
    result = Made(notes=["one", "two"], complete=complete, left_out=left_out, scene=scene)
    run._say(result, {}, Request(json=True, quiet=quiet), None)
    panels = ["note: sweep.svg: no room for strobe, impacts (--panels draws them alone, --height a "
              "taller page)"]  # fmt: skip
    assert noted == ["one", "two"] * (not (quiet and complete)) + panels * (not quiet)


def test_how_faults_are_to_be_reported():
    faults = [{"pieces": ["a"], "error": "E: 1", "place": "x.py:1, f"},
              {"pieces": ["b", "c"], "error": "F", "place": ""}]  # fmt: skip
    said = "this is a fault of camcli and cost these pieces alone, please report it"
    lines = ["fault: a: E: 1 (x.py:1, f)", "fault: b, c: F"]
    assert run.fault_lines(faults, Path("run.json")) == [
        *lines, f"{said} with run.json, which has the traceback"
    ]  # fmt: skip
    assert run.fault_lines(faults, None) == [*lines, said]


def test_the_news_of_the_kernel_are_told_once_each(monkeypatch, noted):
    monkeypatch.setattr(run, "stopwatch", lambda tell: tell)
    monkeypatch.setattr(run, "cache_dir", lambda: Path("cache"))
    monkeypatch.setattr(run, "version", lambda name: f"{name} 7")
    assert run.compiling(Request(quiet=True)) is None
    tell = run.compiling(Request())
    for news in (News.COMPILING, News.NOT_OURS, News.COMPILING, News.PUBLIC, News.NOT_OURS):
        tell(news)
    compiling, not_ours, public = noted
    assert compiling == run.NEWS[News.COMPILING]
    assert "compiles: cache is not a folder" in not_ours
    assert "does not know numba numba 7, so" in public


def test_faults_of_a_run_are_told_with_its_record(monkeypatch, noted):
    monkeypatch.setattr(run, "open_folder", lambda *given, **more: nullcontext(folder))
    folder = Made(folder=Path("f"), shard_done=False, work=Made(faults=[]))
    before = {"pieces": ["a"], "error": "E", "place": "", "traceback": ""}
    monkeypatch.setattr(run, "compute", lambda *given: (None, {"piece_faults": [before]}))
    monkeypatch.setattr(run, "_say", lambda *given: None)
    assert run.execute(None, None, Made(no_plot=True), None) == INTERNAL
    assert noted[0] == "fault: a: E"
    assert "with f/run.json, which" in noted[1]
