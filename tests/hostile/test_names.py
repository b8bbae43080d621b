"""Names of files that are no text, and names that would make one file of two.

A name is bytes; those that are no UTF-8 reach the program as halves of characters, which a strict
stdout refuses. They are printed as escapes, and no run ends because of a name after its work.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import sys
from pathlib import Path

import pytest

from camcli.cli.app import app
from camcli.cli.exit_codes import guarded, hold_output

CONFIGS = Path(__file__).parents[2] / "configs"
ODD = os.fsdecode(b"\xff")  # U+DCFF
SHOWN = "\\udcff"
QUICK = "--no-plot --set run.transient=0 --set run.record=1"
FEW = "--points 2 --set orbits.starts=1"


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder with scenes and tables whose names are no text."""
    try:
        (tmp_path / ODD).mkdir()
    except OSError:
        pytest.skip("this file system holds no such names")
    for name in ("eccentric.yaml", "lift-table.yaml", "valve-lift.csv"):
        shutil.copy(CONFIGS / name, tmp_path / ODD / name)
        shutil.copy(CONFIGS / name, tmp_path / f"{ODD}{name}")
    shutil.copy(CONFIGS / "valve-lift.csv", tmp_path / "lift.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def strictly(monkeypatch, *words: str) -> tuple[int, str, str]:
    """(exit code, stdout, stderr) of `cam words...`, as in a process with a strict stdout."""
    out, said = io.BytesIO(), io.StringIO()
    stdout = io.TextIOWrapper(out, encoding="utf-8", errors="strict")
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", stdout)
        patch.setattr(sys, "stderr", said)
        hold_output()
        code = guarded(lambda: app(words, standalone_mode=False), "--json" in words)
        stdout.flush()
    errors = said.getvalue().encode("utf-8", "backslashreplace")  # as stderr writes everything
    return code, out.getvalue().decode(), errors.decode()


@pytest.mark.parametrize(
    "line",
    [
        f"simulate -c @eccentric.yaml -o @out {QUICK}",
        f"simulate -c @eccentric.yaml -o @out --json {QUICK}",
        "simulate -c @/lift-table.yaml -o @out --profile-only --no-plot",
        "detach -c @/lift-table.yaml -o @out --no-plot --rpm 3500:3600 --points 2",
        f"sweep -c @eccentric.yaml -o @out --rpm 15:16 --points 2 {QUICK}",
        f"sweep -c @eccentric.yaml -o @out --rpm 15:16 --points 2 --shard 1/1 {QUICK}",
        f"classify -c @eccentric.yaml -o @out --rpm 15:16 --points 2 {QUICK}",
        f"basins -c @eccentric.yaml -o @out --cells 2 {QUICK}",
        f"orbits -c @eccentric.yaml -o @out {FEW} {QUICK}",
        f"explore -c @eccentric.yaml -o @out {FEW} --set run.transient=0 --set run.record=1",
        "classify --trace 0.5,-1.6 --det 0.2,0.3 -o @out",
        "init lift.csv -o @out --no-plot",
        "init @/valve-lift.csv --no-plot",
        "init -o @out",
        "schema -o @out",
    ],
)
def test_a_name_that_is_no_text_is_printed_as_an_escape(home, monkeypatch, line):
    code, out, said = strictly(monkeypatch, *line.replace("@", ODD).split())
    assert code in (0, 3), said
    if not any(word in line for word in ("--json", "--trace", "schema")):  # which name no file
        assert SHOWN in out + said
    if "-o @out" in line and "--shard" not in line:
        assert any((home / f"{ODD}out").iterdir())


def test_what_such_a_run_left_can_be_run_again_and_merged(home, monkeypatch):
    for line in (
        f"explore -c @eccentric.yaml -o @out {FEW} --set run.transient=0 --set run.record=1",
        "rerun @out",
        f"sweep -c @eccentric.yaml -o @parts --rpm 15:16 --points 2 --shard 1/1 {QUICK}",
        "merge @parts -o @whole",
    ):
        code, _, said = strictly(monkeypatch, *line.replace("@", ODD).split())
        assert code in (0, 3), (line, said)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("init @valve-lift.csv", "valve-lift.csv: found a name that is no UTF-8 text"),
        ("init @no.csv", "no.csv: no such file"),
        ("simulate -c @no.yaml", "no.yaml: no such file"),
        ("simulate --set cam.file=@", "found bytes that are no UTF-8 text"),
        ("simulate --style @", "no UTF-8 text, expected a name in UTF-8, rename the file"),
        ("sweep --branches @branch.csv", "no UTF-8 text, expected a name in UTF-8, rename the"),
        ("simulate -o @eccentric.yaml", "found a file where the folder should be"),
        ("figures --folder @no", "found no such folder"),
        ("figures 3@", "expected one of"),
        ("rerun @no", "no such file"),
        ("merge @no", "cannot be read"),
        ("simulate --rpm 7@", "expected a speed"),
        ("detach --tolerance @=5%", "expected a number of follower or cam"),
        ("sweep --vary @=1:2", "expected a number of follower, cam or run"),
        ("@", "No such command"),
        ("simulate --fr@", "No such option"),
    ],
)
def test_a_refusal_shows_such_a_name_too(home, monkeypatch, line, said):
    code, out, errors = strictly(monkeypatch, *line.replace("@", ODD).split())
    assert (code, out) == (2, "")
    assert said in errors
    assert SHOWN in errors


# --- cam init never writes over a table


TABLE = (CONFIGS / "valve-lift.csv").read_bytes()


def everything(folder: Path) -> dict[str, bytes]:
    """Path and content of every file below a folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A folder `in` to lay tables into, and one beside it."""
    for name in ("in", "d3"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def lift_yaml(folder):
    (folder / "in/lift.yaml").write_bytes(TABLE)
    return "in/lift.yaml"


def lift_png(folder):
    (folder / "in/lift.png").write_bytes(TABLE)
    return "in/lift.png"


def large_letters(folder):
    (folder / "in/lift.YAML").write_bytes(TABLE)
    return "in/lift.YAML"


def through_dots(folder):
    (folder / "in/lift.yaml").write_bytes(TABLE)
    return "d3/../in/../in/lift.yaml"


def through_a_linked_folder(folder):
    (folder / "link").symlink_to("in")
    (folder / "in/lift.Png").write_bytes(TABLE)
    return "link/lift.Png"


def a_link_of_the_scene_s_name(folder):
    """The scene would be written where the table itself is, under another name."""
    (folder / "in/lift.yaml").write_bytes(TABLE)
    (folder / "in/lift.csv").symlink_to("lift.yaml")
    return "in/lift.csv"


def a_hard_link_of_the_picture_s_name(folder):
    (folder / "in/lift.csv").write_bytes(TABLE)
    os.link(folder / "in/lift.csv", folder / "in/lift.png")
    return "in/lift.csv"


def a_link_to_the_table(folder):
    (folder / "in/lift.csv").write_bytes(TABLE)
    (folder / "in/lift.yaml").symlink_to("lift.csv")
    return "in/lift.csv"


def another_table(folder):
    """The file with the scene's name is another measured table."""
    (folder / "in/lift.csv").write_bytes(TABLE)
    (folder / "in/lift.yaml").write_bytes(TABLE + b"# the other side\n")
    return "in/lift.csv"


def another_picture(folder):
    (folder / "in/lift.csv").write_bytes(TABLE)
    (folder / "in/lift.png").write_bytes(TABLE)
    return "in/lift.csv"


LAID = [
    lift_yaml, lift_png, large_letters, through_dots, through_a_linked_folder,
    a_link_of_the_scene_s_name, a_hard_link_of_the_picture_s_name, a_link_to_the_table,
    another_table, another_picture,
]  # fmt: skip


@pytest.mark.parametrize("force", ["", "--force"])
@pytest.mark.parametrize("out", ["", "-o in", "-o in/../in", "--dry-run"])
@pytest.mark.parametrize("laid", LAID, ids=lambda laid: laid.__name__)
def test_no_table_is_ever_written_over(bench, monkeypatch, laid, out, force):
    name = laid(bench)
    before = everything(bench)
    code, stdout, said = strictly(monkeypatch, *f"init {name} {out} {force}".split())
    assert (code, stdout) == (2, ""), said
    assert everything(bench) == before
    assert "over the table" in said or "that is no " in said


@pytest.mark.parametrize("laid", [lift_yaml, lift_png, large_letters])
def test_a_copy_elsewhere_is_a_file_of_its_own_too(bench, monkeypatch, laid):
    code, stdout, said = strictly(monkeypatch, *f"init {laid(bench)} -o d3".split())
    assert (code, stdout) == (2, "")
    assert "would be written over the copy of the table" in said
    assert not any((bench / "d3").iterdir())


def test_a_copy_never_replaces_another_table(bench, monkeypatch):
    (bench / "in/lift.csv").write_bytes(TABLE)
    (bench / "d3/lift.csv").write_bytes(TABLE + b"# of another cam\n")
    before = everything(bench)
    line = "init in/lift.csv -o d3 --no-plot"
    for force in ("", " --force"):
        code, _, said = strictly(monkeypatch, *(line + force).split())
        assert code == 2
        assert "d3/lift.csv: found a file of this name that is no copy of the table" in said
        assert everything(bench) == before
    (bench / "d3/lift.csv").write_bytes(TABLE)
    (bench / "d3/lift.yaml").symlink_to(bench / "nowhere.yaml")  # a file would be made there
    before = everything(bench)
    for force in ("", " --force"):
        code, _, said = strictly(monkeypatch, *(line + force).split())
        assert code == 2
        assert "d3/lift.yaml: found a file of this name that is no scene" in said
        assert everything(bench) == before
        assert not (bench / "nowhere.yaml").exists()
    (bench / "d3/lift.yaml").unlink()
    code, stdout, _ = strictly(monkeypatch, *line.split())
    assert code == 0
    assert "d3/lift.yaml: fill in mass and spring" in stdout
    assert (bench / "d3/lift.yaml").exists()


def test_a_name_without_an_ending_and_a_scene_of_before_are_fine(bench, monkeypatch):
    (bench / "in/lift").write_bytes(TABLE)
    line = "init in/lift --no-plot --json"
    code, stdout, _ = strictly(monkeypatch, *line.split())
    assert (code, json.loads(stdout)["files"]) == (0, ["in/lift.yaml"])
    assert strictly(monkeypatch, *line.split())[0] == 2
    assert strictly(monkeypatch, *line.split(), "--force")[0] == 0
    assert (bench / "in/lift").read_bytes() == TABLE
