"""cam merge: parts of a run become its artefacts; what does not belong together is refused."""

import json
import shutil
from pathlib import Path
from zlib import crc32

import pytest

from camcli.parallel.codec import pack
from camcli.parallel.journal import HEAD, MAGIC, Journal, header_of
from tests.parallel.long_runs import but_record, files

ROOT = Path(__file__).parents[2]
TURNS = ("--set", "run.transient=10", "--set", "run.record=10", "--no-plot")
SWEEP = ("sweep", "--rpm", "690:745", "--points", "9", *TURNS)


def shards(cam, count: int, *words: str, out: str = "parts") -> None:
    for number in range(1, count + 1):
        done = cam(*words, "--shard", f"{number}/{count}", "-o", out)
        assert done.returncode == 0, done.stderr


def refused(done, *said: str) -> None:
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert "internal fault" not in done.stderr
    assert all(words in done.stderr for words in said), done.stderr


@pytest.mark.parametrize(
    ("count", "words"),
    [
        (3, SWEEP),
        (2, (*SWEEP, "--lyapunov", "--set", "sweep.tables=npz")),
        (2, ("sweep", "--rpm", "735:745", "--points", "11", *TURNS, "--explain")),
        (2, ("basins", "--cells", "40", "--boundary", "--no-plot", *TURNS[:-1])),
        (2, ("basins", "--rpm", "359:360", "--points", "2", "--cells", "20", "--no-plot")),
    ],
    ids=["sweep", "npz", "explain", "boundary", "range"],
)
def test_merged_is_the_same_to_the_byte(cam, tmp_path, count, words):
    assert cam(*words, "-o", "whole").returncode == 0
    shards(cam, count, *words)
    done = cam("merge", "parts", "-o", "merged", "--no-plot")
    assert done.returncode == 0, done.stderr
    assert but_record(files(tmp_path / "merged")) == but_record(files(tmp_path / "whole"))
    one, two = (json.loads((tmp_path / f / "run.json").read_text()) for f in ("merged", "whole"))
    for key in ("scene", "artefacts", "result", "program_sha256"):
        assert one[key] == two[key]
    assert not list((tmp_path / "merged").glob(".*"))


def test_a_measured_cam_needs_its_folder(cam, tmp_path):
    (tmp_path / "cams").mkdir()
    for name in ("lift-table.yaml", "valve-lift.csv"):
        shutil.copy(ROOT / "configs" / name, tmp_path / "cams" / name)
    words = ("sweep", "-c", "cams/lift-table.yaml", "--rpm", "900:1500", "--points", "4", *TURNS)
    assert cam(*words, "-o", "whole").returncode in (0, 3)
    shards_code = {cam(*words, "--shard", f"{k}/2", "-o", "parts").returncode for k in (1, 2)}
    assert shards_code == {0}
    refused(cam("merge", "parts"), "cam.file")
    done = cam("merge", "parts", "--folder", "cams", "--no-plot", "-o", "merged")
    assert done.returncode in (0, 3), done.stderr
    assert but_record(files(tmp_path / "merged")) == but_record(files(tmp_path / "whole"))
    again = cam("rerun", "whole/run.json", "--folder", "cams")
    assert again.returncode == 0, again.stderr
    refused(cam("rerun", "whole/run.json"), "cam.file")
    table = tmp_path / "cams" / "valve-lift.csv"
    rows = table.read_text().splitlines(keepends=True)
    table.write_text("".join(rows) + "\n")
    refused(cam("merge", "parts", "--folder", "cams"), "SHA-256")
    table.unlink()
    refused(cam("merge", "parts", "--folder", "cams"))


def test_what_is_missing_twice_there_or_of_another_run(cam, tmp_path):
    shards(cam, 3, *SWEEP)
    parts = tmp_path / "parts"
    (parts / "sweep-2-of-3.pieces").rename(tmp_path / "away.pieces")
    refused(cam("merge", "parts"), "2 of 3 parts, 2 missing")
    shutil.copy(parts / "sweep-1-of-3.pieces", parts / "copy-of-1.pieces")
    refused(cam("merge", "parts"), "found part 1 of 3", "too")
    (parts / "copy-of-1.pieces").unlink()
    cam(*SWEEP, "--set", "run.record=11", "--shard", "2/3", "-o", "parts")
    refused(cam("merge", "parts"), "other work", "another scene")
    (parts / "sweep-2-of-3.pieces").unlink()
    cam(*SWEEP, "--shard", "2/2", "-o", "parts")
    refused(cam("merge", "parts"), "parts of 2 and of 3")
    (parts / "sweep-2-of-2.pieces").unlink()
    whole = (tmp_path / "away.pieces").read_bytes()
    (parts / "sweep-2-of-3.pieces").write_bytes(whole[:-3])
    refused(cam("merge", "parts"), "sweep-2-of-3", "not complete", "run the same command again")
    done = cam(*SWEEP, "--shard", "2/3", "-o", "parts")
    assert (done.returncode, "complete" in done.stderr) == (0, True)
    assert (parts / "sweep-2-of-3.pieces").read_bytes() == whole
    assert cam("merge", "parts", "--no-plot").returncode == 0


def test_a_carried_sweep_has_no_parts(cam):
    refused(cam(*SWEEP, "--set", "sweep.direction=up", "--shard", "1/2"), "--shard", "chain")


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b", "1/2/3", "", "1/0", "-1/3", "1/999999"])
def test_no_such_shard(cam, text):
    refused(cam(*SWEEP, "--shard", text), "--shard")


def test_no_parts(cam, tmp_path):
    (tmp_path / "empty").mkdir()
    refused(cam("merge", "empty"), "found no parts")
    refused(cam("merge", "absent"), "absent", "No such file")
    refused(cam("merge"), "out")


def framed(name: str, payload: bytes) -> bytes:
    label = name.encode()
    head = HEAD.pack(MAGIC, len(label), len(payload), 0)[:-4]
    check = crc32(payload, crc32(label, crc32(head)))
    return head + check.to_bytes(4, "little") + label + payload


END = framed("end", pack([1, 1]))
DEEP = {"command": "sweep", "scene": {}, "options": {}, "program": "0"}
HOSTILE = {
    "random": bytes(range(256)) * 4,
    "empty": b"",
    "giant": HEAD.pack(MAGIC, 0, 1 << 62, 0),
    "no text": framed("", b"[1,2]\n") + END,
    "no json": framed("", pack("{")) + END,
    "a list": framed("", pack("[1]")) + END,
    "nothing in it": framed("", pack("{}")) + END,
    "deep": framed("", pack("[" * 100_000)) + END,
    "old version": framed("", pack(json.dumps(DEEP))) + END,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_parts_are_refused_in_words(cam, tmp_path, name):
    (tmp_path / "sweep-1-of-1.pieces").write_bytes(HOSTILE[name])
    refused(cam("merge", "."), "PART", "sweep-1-of-1.pieces")


@pytest.mark.parametrize(
    ("key", "value"),
    [("command", "schema"), ("command", ["sweep"]), ("scene", []), ("options", 3),
     ("options", {"explain": "yes"}), ("options", {"lyapunov": {}}), ("scene", {"run": 3})],
)  # fmt: skip
def test_a_part_that_asks_for_nonsense(cam, tmp_path, key, value):
    shards(cam, 1, *SWEEP)
    path = tmp_path / "parts" / "sweep-1-of-1.pieces"
    what = {**json.loads(header_of(path)), key: value}
    path.unlink()
    path.write_bytes(framed("", pack(json.dumps(what))) + END)
    refused(cam("merge", "parts"))


def test_pieces_that_hold_no_results(cam, tmp_path):
    shards(cam, 1, *SWEEP)
    path = tmp_path / "parts" / "sweep-1-of-1.pieces"
    journal = Journal(path, header_of(path))
    journal.put("0/3", [1, 2])
    journal.close()
    refused(cam("merge", "parts"), "0/3 holds no result")
