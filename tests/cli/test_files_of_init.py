"""Which files `cam init` writes, which of them it may replace, and what it says of them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import SimpleNamespace as Stub

import pytest

from camcli import scene as scenes
from camcli.analysis import natural_speed
from camcli.api import machine
from camcli.cli import init
from camcli.cli.init import COMMENTS, PNG, Files
from camcli.errors import SceneError
from camcli.scene.load import MAX_BYTES


def test_files_of_a_table_are_beside_it_or_elsewhere_with_a_copy(tmp_path):
    table = tmp_path / "My.Lift.csv"
    table.write_text("x")
    columns = ["Lift B [mm]", "§", "3", "ÄÖ"]
    found = init._files(table, None, True, columns)
    assert found == Files(
        scene=tmp_path / "My.Lift.yaml", picture=tmp_path / "My.Lift.png", copy=None,
        others={
            "Lift B [mm]": tmp_path / "My.Lift-lift-b-mm.yaml",
            "§": tmp_path / "My.Lift-lobe3.yaml", "3": tmp_path / "My.Lift-3.yaml",
            "ÄÖ": tmp_path / "My.Lift-lobe5.yaml",
        },
    )  # fmt: skip
    out = tmp_path / "out"
    elsewhere = init._files(table, out, False, columns[:1])
    assert list(elsewhere.named.items()) == [
        ("scene", out / "My.Lift.yaml"), ("copy", out / "My.Lift.csv"),
        ("scene of Lift B [mm]", out / "My.Lift-lift-b-mm.yaml"),
    ]  # fmt: skip
    assert list(found.named) == ["scene", "picture", *(f"scene of {one}" for one in columns)]
    (tmp_path / "x").mkdir()
    assert init._files(table, tmp_path / "x" / "..", True, []).copy is None


def test_two_names_are_of_one_file_through_links_and_in_other_letters(tmp_path):
    (tmp_path / "a").write_text("")
    (tmp_path / "b").symlink_to("a")
    os.link(tmp_path / "a", tmp_path / "c")
    (tmp_path / "d").write_text("")
    (tmp_path / "to").symlink_to(".")
    (tmp_path / "sub").mkdir()
    pairs = {
        ("a", "b"): True, ("a", "c"): True, ("a", "d"): False, ("a", "A"): True,
        ("STRASSE", "straße"): True, ("\u00e9", "e\u0301"): True, ("none", "to/NONE"): True,
        ("none", "sub/none"): False, ("lost/x", "LOST/X"): True, ("lost/x", "gone/x"): False,
    }  # fmt: skip
    for (one, other), same in pairs.items():
        assert init._is_one(tmp_path / one, tmp_path / other) == same, (one, other)
        assert init._is_one(tmp_path / other, tmp_path / one) == same, (one, other)


@pytest.mark.parametrize(
    ("what", "data", "ours"),
    [
        ("scene", b"cam: {}\n", True), ("scene of b", b"run: 1\ncam: 2\n", True),
        ("scene", b"run: 1\n", False), ("scene", b"[cam]\n", False), ("scene", b"cam\n", False),
        ("scene", b"# \xff\ncam: 1\n", True), ("scene", b"", False),
        ("scene", b"cam: 1\n#" + b"x" * MAX_BYTES, True),
        ("picture", PNG + b"x", True), ("picture", b"x" + PNG, False), ("picture", b"", False),
        ("copy", b"table", True), ("copy", b"table\n", False), ("copy", b"tabl", False),
        ("scene", None, False), ("picture", None, False), ("copy", None, False),
    ],
)  # fmt: skip
def test_what_may_be_replaced_is_known_by_its_content(tmp_path, what, data, ours):
    """Nothing else is, and least of all a folder (None)."""
    path = tmp_path / "file"
    path.mkdir() if data is None else path.write_bytes(data)
    assert init._is_ours(what, path, b"table") is ours
    files = Files(path) if what == "scene" else Files(tmp_path / "s", others={"b": path})
    files = {"picture": Files(tmp_path / "s", path), "copy": Files(tmp_path / "s", copy=path)}.get(
        what, files
    )
    content = {what: b"table"}
    if ours:
        init._refuse_to_overwrite(files, content, force=True)
        if what == "copy":
            init._refuse_to_overwrite(files, content, force=False)
            return
    kind = {"picture": "PNG", "copy": "copy of the table"}.get(what, "scene")
    for force in [False] if ours else [False, True]:
        with pytest.raises(SceneError) as refused:
            init._refuse_to_overwrite(files, content, force)
        (fault,) = refused.value.faults
        more = "" if ours else f" that is no {kind}"
        cure = "add --force to overwrite it" if ours else "move it away, or choose another -o DIR"
        assert (fault.where, fault.found, fault.cure) == (
            str(path), f"found a file of this name{more}", cure,
        )  # fmt: skip


def test_a_link_to_nowhere_is_not_overwritten(tmp_path):
    (tmp_path / "s.yaml").symlink_to("gone.yaml")
    for force in (False, True):
        with pytest.raises(
            SceneError, match=r"s\.yaml: found a file of this name that is no scene"
        ):
            init._refuse_to_overwrite(Files(tmp_path / "s.yaml"), {}, force)
    init._refuse_to_overwrite(Files(tmp_path / "gone.yaml"), {}, False)


def test_a_copy_is_read_to_its_end_however_long_it_is(tmp_path):
    table = b"x" * (MAX_BYTES + 5)
    for data, ours in ((table, True), (table + b"y", False), (table[:-1], False)):
        (tmp_path / "t.csv").write_bytes(data)
        assert init._is_ours("copy", tmp_path / "t.csv", table) is ours


def test_each_key_of_a_scene_has_its_remark_or_why_it_is_a_guess():
    keys = {
        "header": 2, "skip_lines": 3, "decimal": "comma", "angle_column": 1, "lift_column": 2,
        "angle": "crank", "lift": "fraction", "max_lift": 1e-5, "subtract": 18.0,
        "mirrored": False, "base_radius": 0.018, "lift_scale": 2, "rocker_ratio": 1.5,
        "measured_at": "lobe",
    }  # fmt: skip
    lines = (
        init._scene(Path("d/t.csv"), keys, {"lift": "why\x07"}).partition("cam:\n")[2].split("\n")
    )
    written = {line.split(":")[0].strip(): line for line in lines if line}
    assert list(written) == ["kind", "file", *keys, "zero_deg", "direction", "base"]
    assert written["file"] == '  file: "t.csv"'
    assert written["lift"] == '  lift: "fraction"'.ljust(30) + r" # CHECK: why\x07"
    for key in {*keys, "zero_deg", "direction", "base"} - {"lift"}:
        assert written[key].partition(" # ")[2] == COMMENTS[key]
        assert written[key].index(" # ") == 30


@pytest.mark.parametrize("dry_run", [False, True])
@pytest.mark.parametrize("has_table", [False, True])
def test_what_is_said_of_the_files(capsys, dry_run, has_table):
    table = Path("t.csv") if has_table else None
    files = Files(Path("t b.yaml"), Path("t.png"), Path("c.csv"), {"x": Path("t-x.yaml")})
    plan = init._Planned(files, {}, {"header": 1, "lift": "mm"}, {"lift": "why"})
    init._show(plan, table, Stub(json=False, dry_run=dry_run))
    said = capsys.readouterr().out.splitlines()
    what = "mass and spring" if has_table else "mass, spring and cam"
    assert said == [
        *(["t.csv: header 1, lift mm"] if has_table else []),
        "CHECK lift: mm is a guess: why",
        *(["would write t b.yaml, t.png, c.csv, t-x.yaml"] if dry_run else [
            "t.png: the cam and the rows of the table",
            f"t b.yaml: fill in {what}, then: cam detach -c 't b.yaml'",
            f"t-x.yaml: fill in {what}, then: cam detach -c t-x.yaml",
        ]),
    ]  # fmt: skip
    init._show(plan, table, Stub(json=True, dry_run=dry_run))
    assert json.loads(capsys.readouterr().out) == {
        "command": "init", "files": ["t b.yaml", "t.png", "c.csv", "t-x.yaml"],
        "keys": {"header": 1, "lift": "mm"}, "unsure": {"lift": "why"},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("lost_at", "rpm"), [(1000.0, "900"), (1388.0, "1200"), (3456.7, "3100"), (0.0, None)]
)
def test_a_working_speed_is_nine_tenths_of_that_at_which_contact_is_lost(
    tmp_path, monkeypatch, lost_at, rpm
):
    scene = tmp_path / "s.yaml"
    scene.write_text("cam: 1\n")
    monkeypatch.setattr(scenes, "load_scene", lambda path: path)
    monkeypatch.setattr(machine, "machine_of", lambda scene: Stub(system=scene))
    monkeypatch.setattr(natural_speed, "natural_speed", lambda system: Stub(rpm=lost_at))
    init._set_speed(scene)
    written = scene.read_text().removeprefix("cam: 1\n").splitlines()
    line = f"  rpm: {rpm}".ljust(22) + " # CHECK: the working speed, rpm of the cam; "
    expected = ["", "run:", line + "of a crank: 6000 crank"]
    assert written == ([] if rpm is None else expected)
