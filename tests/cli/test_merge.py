"""cam merge: parts of a run become its artefacts; what does not belong together is refused."""

import json
import os
import re
import shutil
from pathlib import Path
from zlib import crc32

import pytest

from camcli.cli import merge
from camcli.output.run_folder import PIECES
from camcli.parallel.checkpoint import Checkpoint, key_of
from tests.conftest import refused
from tests.support.long_runs import but_record, files

ROOT = Path(__file__).parents[2]
TURNS = "--set run.transient=10 --set run.record=10 --no-plot"
SWEEP = f"sweep --rpm 690:745 --points 9 {TURNS}"


def shards(cam, total: int, line: str) -> None:
    for number in range(1, total + 1):
        cam(line, f"--shard {number}/{total} -o parts", code=0)


@pytest.mark.parametrize(
    ("total", "words"),
    [
        (3, f"{SWEEP} --lyapunov --set sweep.tables=npz --set detach.rpm.num=7"),
        pytest.param(
            2, f"sweep --rpm 736:740 --points 3 {TURNS} --explain",
            marks=pytest.mark.slow,
        ),
        (2, f"sweep --rpm 690:700 --vary follower.restitution=0.7:0.8 --points 3,2 {TURNS}"),
        (2, "basins --rpm 359:360 --points 2 --cells 16 --no-plot"),
    ],
    ids=["sweep", "explain", "map", "range"],
)  # fmt: skip
def test_merged_is_the_same_to_the_byte(cam, tmp_path, total, words):
    assert cam(words, "-o whole").returncode == 0
    shards(cam, total, words)
    cam("merge parts -o merged", code=0)  # no shard was to draw
    assert but_record(files(tmp_path / "merged")) == but_record(files(tmp_path / "whole"))
    one, two = (json.loads((tmp_path / f / "run.json").read_text()) for f in ("merged", "whole"))
    for key in ("scene", "scene_sha256", "artefacts", "result", "program_sha256"):
        assert one[key] == two[key]
    assert not list((tmp_path / "merged").glob(".*"))


@pytest.mark.slow
def test_a_measured_cam_needs_its_folder(cam, tmp_path):
    (tmp_path / "cams").mkdir()
    for name in ("lift-table.yaml", "valve-lift.csv"):
        shutil.copy(ROOT / "configs" / name, tmp_path / "cams" / name)
    words = f"sweep -c cams/lift-table.yaml --rpm 900:1500 --points 2 {TURNS}"
    assert cam(words, "-o whole").returncode in (0, 3)
    assert cam(words, "--shard 1/1 -o parts").returncode == 0
    refused(cam("merge parts"), "cam.file", "--folder")
    done = cam("merge parts --folder cams --no-plot -o merged")
    assert done.returncode in (0, 3), done.stderr
    assert but_record(files(tmp_path / "merged")) == but_record(files(tmp_path / "whole"))
    cam("rerun whole/run.json --folder cams", code=0)
    refused(cam("rerun whole/run.json"), "cam.file", "--folder")
    table = tmp_path / "cams" / "valve-lift.csv"
    table.write_text(table.read_text() + "\n")
    refused(cam("merge parts --folder cams"), "SHA-256")


def test_what_is_missing_torn_or_of_another_run(cam, tmp_path):
    shards(cam, 3, SWEEP)
    parts = tmp_path / "parts"
    second = parts / "sweep-2-of-3.pieces"
    whole = second.read_bytes()
    second.unlink()
    refused(cam("merge parts"), "2 of 3 parts, not there: 2")
    cam(SWEEP, "--set run.record=11 --shard 2/3 -o parts")
    refused(cam("merge parts"), "other work", "another scene")
    second.write_bytes(whole[:-3])
    refused(cam("merge parts"), "sweep-2-of-3", "not complete", "run the same command again")
    done = cam(SWEEP, "--shard 2/3 -o parts")
    assert (done.returncode, "complete" in done.stderr) == (0, True)
    assert second.read_bytes() == whole
    shutil.copy(second, parts / "copy-of-3.pieces")  # a part twice does no harm,
    cam(SWEEP, "--shard 2/2 -o parts")  # nor one of another division
    assert cam("merge parts --no-plot").returncode == 0


def test_a_damaged_piece_costs_that_piece_alone(cam, tmp_path):
    cam(SWEEP, "-o whole --no-plot", code=0)
    cam(SWEEP, "--shard 1/1 -o parts", code=0)
    part = tmp_path / "parts" / "sweep-1-of-1.pieces"
    content = bytearray(part.read_bytes())
    content[len(content) // 2] ^= 1
    part.write_bytes(content)
    done = cam("merge parts --no-plot -o merged", code=0)
    assert but_record(files(tmp_path / "merged")) == but_record(files(tmp_path / "whole"))
    done = cam(SWEEP, "--shard 1/1 -o parts", code=0)
    assert re.search(r"\d+ bytes on disk are damaged and passed over", done.stderr)
    assert len(part.read_bytes()) > len(content)
    cam("merge parts --no-plot -o again", code=0)
    assert but_record(files(tmp_path / "again")) == but_record(files(tmp_path / "whole"))


def test_nothing_to_merge_or_to_share(cam, tmp_path):
    for text in ("0/3", "4/3", "3", "1/2/3", "", "1/999999"):
        refused(cam(SWEEP, "--shard", text), "--shard")
    refused(cam(SWEEP, "--set sweep.direction=up --shard 1/2"), "--shard", "chain")
    (tmp_path / "empty").mkdir()
    refused(cam("merge empty"), "found no parts")
    refused(cam("merge absent"), "absent", "No such file")


def line(place: str, value, key: str = "") -> bytes:
    """A line with a right sum; key: of the run, for all but the first."""
    rest = b"0 %s\n" % json.dumps([place, 0, value]).encode()
    return b"%08x %s" % (crc32(rest, crc32(key.encode())), rest)


def part(key, end=None) -> bytes:
    """A file of pieces without any, of this key and with this value of its last record."""
    end = end or {"shard": [1, 1], "scene": {}, "plot": False}
    return line("key", key) + line("end", end, key if isinstance(key, str) else "")


OLD = {"command": "sweep", "scene": {}, "options": {}, "program_sha256": "0"}
HOSTILE = [
    bytes(range(256)) * 4, b"", part([1, 2]), part("{"), part("{}"), part("[" * 100_000),
    part(json.dumps(OLD)), part(json.dumps(OLD), [1, "x"]),
]  # fmt: skip


def test_hostile_parts_are_refused_in_words(cam, tmp_path):
    path = tmp_path / "sweep-1-of-1.pieces"
    for data in HOSTILE:
        path.write_bytes(data)
        refused(cam("merge ."), path.name)
    path.unlink()
    os.mkfifo(path)
    refused(cam("merge ."), path.name, "no plain file")


def test_parts_that_ask_for_nonsense_or_hold_no_results(cam, tmp_path):
    shards(cam, 1, SWEEP)
    path = tmp_path / "parts" / "sweep-1-of-1.pieces"
    text, whole = key_of(path)[0], path.read_bytes()
    for key, value in (
        ("command", "schema"), ("command", ["sweep"]), ("scene", []), ("options", 3),
        ("options", {"explain": "yes"}), ("options", {"lyapunov": {}}), ("scene", {"run": 3}),
    ):  # fmt: skip
        path.write_bytes(part(json.dumps({**json.loads(text), key: value})))
        refused(cam("merge parts"))
    path.write_bytes(whole)
    checkpoint = Checkpoint(path, text)
    checkpoint.put("0", 3, [1, 2])
    checkpoint.close()
    refused(cam("merge parts"), "0/3 holds no result")


def test_parts_in_a_folder_are_those_of_shards_in_order(tmp_path):
    """The pieces of a run of one's own that was cut short, hidden in the same folder, are none."""
    (tmp_path / "more").mkdir()
    names = [f"sweep-2-of-2{PIECES}", f"more/sweep-1-of-2{PIECES}", f"old-2-of-9{PIECES}"]
    for name in (*names, f".sweep-0123456789ab{PIECES}", "sweep-1-of-2.txt", f"sweep{PIECES}"):
        (tmp_path / name).write_bytes(b"")
    found = merge._paths([tmp_path])
    assert found == sorted(tmp_path / name for name in names)
    own = tmp_path / f"sweep{PIECES}"
    assert merge._paths([own, tmp_path / "more"]) == [own, tmp_path / names[1]]
    too_long = Path("x" * 5000)  # for any system: who reads it says so
    assert merge._paths([too_long]) == [too_long]
