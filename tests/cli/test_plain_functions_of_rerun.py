"""cam rerun, cam merge and cam init, function by function: verdicts, records, files, by hand."""

from __future__ import annotations

import json
import os
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace as Made

import pytest

from camcli.cli import init, merge, rerun
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS
from camcli.cli.options import Request
from camcli.cli.rerun import Record
from camcli.errors import Fault, SceneError


@pytest.fixture
def again(tmp_path, monkeypatch, capsys):
    """A record that is run again, all of whose files have the hashes that it lists.

    made: hashes that come out; here: files that are beside it, with other bytes in `changed`.
    """

    def of(
        old, made, here=(), changed=(), own=True, faults=(), complete=True, draws=True, **options
    ):
        notes: list[str] = []
        done: list = []
        for name in here:
            (tmp_path / name).write_text("x")
        record = Made(command="sweep", artefacts=old, draws=draws, program_sha256="p",
                      load=lambda *given: done.append(given) or "scene")  # fmt: skip

        @contextmanager
        def folder(out, **more):
            done.append((out, more, out.is_dir()))
            yield "store"

        new = {"artefacts": made, "piece_faults": list(faults)}
        monkeypatch.setattr(rerun, "read_record", lambda path: done.append(path) or record)
        monkeypatch.setattr(rerun, "command_of", lambda name: Made(artefacts=("a.csv", "b.csv")))
        monkeypatch.setattr(rerun, "check_before", lambda *given: done.append(given[1:]))
        monkeypatch.setattr(rerun, "run_folder", folder)
        monkeypatch.setattr(
            rerun, "unchanged", lambda folder, old: {k: 1 for k in here if k not in changed}
        )
        monkeypatch.setattr(rerun, "program_hash", lambda: "p" if own else "q")
        monkeypatch.setattr(
            rerun,
            "compute",
            lambda *given: done.append(given[1:]) or (Made(complete=complete), new),
        )
        monkeypatch.setattr(rerun, "tell_faults", lambda *given: notes.append(given))
        monkeypatch.setattr(rerun, "note", notes.append)
        monkeypatch.setattr(rerun, "table", lambda *given: print(json.dumps(given)))
        request = Request(**options)
        code = rerun.rerun(request, tmp_path, Path("home"))
        return code, json.loads(capsys.readouterr().out), notes, (request, done)

    return of


OLD = {"a.csv": "1", "b.csv": "2", "c.png": "3"}


@pytest.mark.parametrize(
    ("made", "here", "changed", "own", "verdicts", "code", "notes"),
    [
        (OLD, (), (), True, ["same bytes"] * 3, DONE, []),
        (OLD, (), (), False, ["same bytes"] * 3, DONE, []),
        ({**OLD, "d.csv": "4"}, ("a.csv",), (), True, ["same bytes"] * 3, DONE, []),
        ({**OLD, "b.csv": "9"}, (), (), True, ["same bytes", "other bytes", "same bytes"], NUMERICS,
         []),
        ({"a.csv": "1", "c.png": "3"}, (), (), False, ["same bytes", "not made", "same bytes"],
         NUMERICS, [rerun.OTHER_PROGRAM]),
        ({**OLD, "c.png": "9"}, (), (), False, ["same bytes", "same bytes", "other bytes"], DONE,
         [rerun.OTHER_PROGRAM, rerun.ONLY_PICTURES]),
        (OLD, ("a.csv", "c.png"), ("c.png",), True, ["same bytes", "same bytes", rerun.CHANGED],
         DONE, []),
        (OLD, ("a.csv",), ("a.csv",), True, [rerun.CHANGED, "same bytes", "same bytes"], NUMERICS,
         []),
    ],
)  # fmt: skip
def test_whether_the_bytes_of_a_run_agree(again, made, here, changed, own, verdicts, code, notes):
    """Pictures alone may differ; what stands beside the record with other bytes is told."""
    found, shown, said, _ = again(OLD, made, here, changed, own)
    assert (found, said) == (code, notes)
    same = set(verdicts) == {"same bytes"}
    title = f"cam sweep again: {'the same bytes' if same else 'bytes differ'}"
    rows = [list(row) for row in zip(OLD, verdicts, strict=True)]
    assert shown == [title, ["artefact", "verdict"], rows]
    found, shown, _, _ = again(OLD, made, here, changed, own, json=True)
    assert shown == {
        "command": "sweep", "same": same, "artefacts": dict(zip(OLD, verdicts, strict=True))
    }  # fmt: skip


def test_a_folder_of_the_name_of_a_file_is_no_file_that_was_changed(again, tmp_path):
    (tmp_path / "b.csv").mkdir()
    code, shown, _, _ = again(OLD, OLD, ("a.csv",))
    assert (code, shown[0]) == (DONE, "cam sweep again: the same bytes")


def test_trouble_and_faults_of_a_run_again(again, tmp_path):
    """A fault is told with the run.json that stays, where one does."""
    code, _, said, _ = again(OLD, OLD, complete=False)
    assert (code, said) == (DONE, [rerun.SAME_TROUBLE])
    code, _, said, _ = again(OLD, {**OLD, "a.csv": "9"}, faults=["f"], complete=False)
    assert (code, said) == (INTERNAL, [(["f"], None)])
    code, _, said, _ = again(OLD, OLD, faults=["f"], out=tmp_path / "o")
    assert (code, said) == (INTERNAL, [(["f"], tmp_path / "o" / "run.json")])


def test_a_run_again_goes_where_it_is_asked_to(again, tmp_path):
    """Without -o into a folder that is gone afterwards; the scene's files are by the record."""
    *_, (request, done) = again(OLD, OLD, threads=3, out=tmp_path / "o")
    names = {"threads": 3, "names": ["a.csv", "b.csv"]}
    path = tmp_path / "run.json"
    assert done == [
        path, (Path("home"), tmp_path, str(path)), ("scene", tmp_path / "o", True),
        (tmp_path / "o", names, False), ("scene", request, "store", True),
    ]  # fmt: skip
    *_, (_, done) = again(OLD, OLD, draws=False)
    assert (done[2][2], done[4][3]) == (False, False)
    out, _, was_there = done[3]
    assert (was_there, out.exists()) == (True, False)


def record(command="sweep", **more) -> Record:
    return Record.model_validate({"command": command, "scene": {"run": {"rpm": 7.0}}, **more})


def test_whether_a_run_drew_is_told_by_its_artefacts():
    for artefacts, draws in (
        ({"sweep.png": "1"}, True), ({"a.csv": "1", "map.pdf": "1"}, True),
        ({"sweep.csv": "1"}, False), ({"branches.png": "1"}, False), ({"sweep.gif": "1"}, False),
        ({}, False),
    ):  # fmt: skip
        assert record(artefacts=artefacts).draws is draws


@pytest.mark.parametrize(
    ("folder", "cam", "values"),
    [
        (None, {"allow_outside": True}, {}),
        (Path("home"), {"allow_outside": True}, {"cam.allow_outside": True}),
        (Path("home"), {"allow_outside": False}, {}),
        (Path("home"), {"allow_outside": 1}, {}),
        (Path("home"), 3, {}),
    ],
)
def test_a_record_may_look_elsewhere_only_where_the_user_says_so(monkeypatch, folder, cam, values):
    """What stood beside the scene in earlier versions goes into it."""
    asked = []
    monkeypatch.setattr(rerun, "load_scene", lambda *given, **more: asked.append((given, more)))
    scene = {"cam": cam, "run": {"rpm": 7.0}}
    options = {"plot": True, "chaos": 1, "odd": 2, "with_map": True}
    record(scene=scene, options=options).load(folder, Path("beside"))
    moved = {"orbits.chaos": 1, "options.odd": 2, "explore.map": True}
    assert asked == [((scene, {**values, **moved}), {"folder": folder or Path("beside")})]


def test_faults_of_a_record_are_told_with_its_name_and_what_helps_here(monkeypatch):
    def refuse(*given, **more):
        raise SceneError(
            Fault("scene", "a", "found 1", "", "cure"),
            Fault("x", "cam.allow_outside", "found it", "", "cure"),
            Fault("scene", "cam.file", "found no such file", "", "cure"),
        )

    monkeypatch.setattr(rerun, "load_scene", refuse)
    with pytest.raises(SceneError) as refused:
        record().load(None, Path(), "own")
    told = [(fault.where, fault.path, fault.cure) for fault in refused.value.faults]
    folder = "say with --folder where it is"
    assert told == [("own", "a", "cure"), ("x", "cam.allow_outside", folder),
                    ("own", "cam.file", folder)]  # fmt: skip


@pytest.mark.parametrize(
    ("command", "result", "run", "stays"),
    [
        ("detach", {}, {"rpm": 7.0, "record": 3}, False),
        ("detach", {"working": 1}, {"rpm": 7.0, "record": 3}, True),
        ("sweep", {}, {"rpm": 7.0, "record": 3}, True),
        ("detach", {}, 3, True),
    ],
)
def test_a_speed_that_was_taken_for_the_default_is_not_one_that_a_scene_states(
    command, result, run, stays
):
    scene = {"cam": {}, "run": run}
    stated = record(command, scene=scene, result=result)._as_stated()
    assert stated == (scene if stays else {"cam": {}, "run": {"record": 3}})


def test_what_is_no_record_is_refused_in_words():
    text = json.dumps({"command": "sweep", "scene": {}, "artefacts": {"a.csv": 1}})
    for data, said in (
        (text, "artefacts: a.csv: Input should be a valid string"),
        ('{"command": "bench", "scene": {}}', "command: a bench measures seconds, which are"),
        ('{"command": "sweeps", "scene": {}}', "command: expected simulate, "),
        ("x" * 500, "Invalid JSON"),
    ):  # fmt: skip
        with pytest.raises(SceneError) as refused:
            rerun.record_of(data, Path("r"))
        (fault,) = refused.value.faults
        assert fault.found.startswith(f"found {said}".replace("found ", "cannot be read (", 1))
        assert (fault.where, fault.expected, fault.cure) == ("r", rerun.EXPECTED, rerun.CURE)
        assert len(fault.found) < 340


# --- cam merge


def test_parts_are_those_of_all_folders_in_order(tmp_path):
    for name in ("b/sweep-1-of-2.pieces", "a/c/sweep-2-of-2.pieces", "a/sweep-1-of-2.pieces",
                 "a/sweep.pieces", "a/sweep-1-of-2.csv"):  # fmt: skip
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    alone = tmp_path / "a" / "sweep.pieces"
    found = merge._paths([tmp_path / "b", alone, tmp_path / "a"])
    assert [str(path.relative_to(tmp_path)) for path in found] == [
        "b/sweep-1-of-2.pieces", "a/sweep.pieces", "a/c/sweep-2-of-2.pieces",
        "a/sweep-1-of-2.pieces",
    ]  # fmt: skip
    (tmp_path / "d").mkdir()
    with pytest.raises(SceneError, match="found no parts"):
        merge._paths([tmp_path / "d"])


def test_in_what_the_keys_of_pieces_differ():
    one = {"command": "sweep", "scene": {"a": 0.0}, "program": "p"}

    def said(**more):
        return merge._differ(json.dumps(one), json.dumps({**one, **more}))

    assert said(command="basins", program="q") == "another command, another program"
    assert said(scene={"a": -0.0}) == "another scene"
    assert said() == "written in another way"
    assert merge._differ(json.dumps(one), "{}") == (
        "another command, another scene, another program"
    )


def test_the_division_with_the_fewest_missing_parts_is_told():
    merge._refuse_missing({3: {1}, 2: {1, 2}})
    merge._refuse_missing({2: {1}, 3: {1, 2, 3}})
    with pytest.raises(SceneError, match="found 2 of 3 parts, not there: 3,"):
        merge._refuse_missing({3: {1, 2}})
    with pytest.raises(SceneError, match="found 2 of 3 parts, not there: 2,"):
        merge._refuse_missing({9: {1, 2, 3}, 3: {3, 1}})


# --- cam init


@pytest.mark.parametrize("dry_run", [False, True])
@pytest.mark.parametrize("picture", [None, Path("o/t.png")])
@pytest.mark.parametrize("table", [None, Path("t.csv")])
def test_the_files_of_a_scene_are_written_then_its_speed_then_its_picture(
    monkeypatch, dry_run, picture, table
):
    """Of a table each lobe has its speed; what is not drawn has no picture."""
    done: list = []

    def records(name):
        return lambda *given: done.append((name, *given))

    others = {"b": Path("o/t-b.yaml")}
    planned = init._Planned(
        init.Files(Path("o/t.yaml"), picture, Path("o/t.csv"), others),
        {"scene": b"1", "copy": b"2", "scene of b": b"3"}, {}, {},
    )  # fmt: skip
    monkeypatch.setattr(init, "_of_table", lambda *given: planned)
    monkeypatch.setattr(init, "_template", lambda: "template")
    for name in ("_refuse_to_overwrite", "_write", "_set_speed", "_draw", "_show"):
        monkeypatch.setattr(init, name, records(name))
    request = Request(dry_run=dry_run, out=Path("o"))
    assert init.init(request, table, True) == 0
    if table is None:
        planned = init._Planned(init.Files(Path("o/scene.yaml")), {"scene": b"template"}, {}, {})
        written = [("_write", Path("o"), {"scene.yaml": b"template"})]
    else:
        contents = {"t.yaml": b"1", "t.csv": b"2", "t-b.yaml": b"3"}
        written = [("_write", Path("o"), contents), ("_set_speed", Path("o/t.yaml")),
                   ("_set_speed", Path("o/t-b.yaml"))]  # fmt: skip
        written += [("_draw", Path("o/t.yaml"), picture)] * (picture is not None)
    assert done == [
        ("_refuse_to_overwrite", planned.files, planned.content, True),
        *([] if dry_run else written), ("_show", planned, table, request),
    ]  # fmt: skip


def test_a_table_gives_a_scene_for_each_lobe(monkeypatch, tmp_path):
    table = tmp_path / "t.csv"
    table.write_bytes(b"rows")
    lobe = Made(keys={"lift_column": 3}, unsure={"lift": "why b"})
    found = Made(lobes={"b": lobe}, keys={"lift_column": 2}, unsure={"lift": "why"})
    asked = []
    monkeypatch.setattr("camcli.cams.lift_guess.guess", lambda *given: asked.append(given) or found)
    monkeypatch.setattr(init, "_scene", lambda *given: f"{given}")
    plan = init._of_table(table, Request(out=tmp_path / "o", no_plot=True))
    assert asked == [(b"rows", str(table))]
    assert plan.content == {
        "scene": f"{(table, found.keys, found.unsure)}".encode(), "copy": b"rows",
        "scene of b": f"{(table, lobe.keys, lobe.unsure)}".encode(),
    }  # fmt: skip
    assert (plan.keys, plan.unsure) == (found.keys, found.unsure)
    assert plan.files == init.Files(
        tmp_path / "o" / "t.yaml", None, tmp_path / "o" / "t.csv", {"b": tmp_path / "o/t-b.yaml"}
    )
    assert init._of_table(table, Request()).files.picture == tmp_path / "t.png"


@pytest.mark.parametrize(
    ("name", "files", "said"),
    [
        ("t.yaml", init.Files(Path("t.yaml")), "the scene would be written over the table"),
        ("t.csv", init.Files(Path("o/t.yaml"), Path("t.CSV")), "picture would be written over"),
        ("t.csv", init.Files(Path("o/t.yaml"), None, Path("o/t.yaml")),
         "the scene would be written over the copy of the table"),
        ("t.csv", init.Files(Path("s.yaml"), others={"b": Path("t.csv")}),
         "the scene of b would be written over the table"),
        ("\udc80.csv", init.Files(Path("s.yaml")), "found a name that is no UTF-8 text"),
        ("t.csv", init.Files(Path("s.yaml"), Path("t.png"), Path("t.csv")), None),
    ],
)  # fmt: skip
def test_files_that_would_be_one(name, files, said):
    if said is None:
        init._refuse_shared(Path(name), files)
        return
    with pytest.raises(SceneError) as refused:
        init._refuse_shared(Path(name), files)
    assert said in str(refused.value)


def test_the_picture_of_a_scene_is_that_of_its_cam_alone(monkeypatch, tmp_path):
    asked = []
    result = Made(pictures={"profile": lambda: "drawn"}, scene=Made(plot="form"))
    monkeypatch.setattr(
        "camcli.api.simulate.simulate",
        lambda scene, profile_only: asked.append((scene, profile_only)) or result,
    )
    monkeypatch.setattr("camcli.scene.load_scene", lambda *given: given)

    def write_picture(drawn, file, form):
        file.write(f"{drawn} as {form}".encode())

    monkeypatch.setattr("camcli.output.pictures.write_picture", write_picture)
    init._draw(tmp_path / "s.yaml", tmp_path / "p.png")
    panels = {"plot.panels": ["lift", "velocity", "acceleration"], "plot.title": False}
    assert asked == [((tmp_path / "s.yaml", panels), True)]
    assert (tmp_path / "p.png").read_bytes() == b"drawn as form"
    assert os.listdir(tmp_path) == ["p.png"]
