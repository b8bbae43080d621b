"""Disks that are full, read-only or no folder: words, exit code 2, and what fits is kept."""

import os
import resource
import subprocess

import pytest

from camcli.parallel.checkpoint import records
from tests.support.long_runs import but_record, cam, files

SWEEP = (
    "sweep", "--rpm", "660:760", "--points", "41", "--no-plot", "--threads", "2",
    "--set", "run.transient=5", "--set", "run.record=80",
)  # fmt: skip


@pytest.fixture
def disk(tmp_path):
    """A file system of its own that may not be written."""
    place = tmp_path / "disk"
    place.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", str(place)]
    if os.geteuid() != 0 or subprocess.run(words, capture_output=True).returncode != 0:
        pytest.skip("needs the right to mount a tmpfs")
    yield
    subprocess.run(["umount", "-l", str(place)], check=True)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    assert cam((*SWEEP, "-o", "out"), folder)[0] == 0
    return but_record(files(folder / "out"))


@pytest.mark.usefixtures("disk")
def test_a_read_only_disk_is_said(tmp_path):
    for out in ("disk/new", "disk"):
        code, said = cam((*SWEEP, "-o", out), tmp_path)
        assert (code, "-o" in said, "internal fault" in said) == (2, True, False)
    code, said = cam((*SWEEP, "-o", "disk", "--shard", "1/2"), tmp_path)
    assert (code, "Read-only" in said or "may not be written" in said) == (2, True)


def small_files() -> None:
    """No file of more bytes, in this process."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))


@pytest.mark.parametrize("extra", [(), ("--shard", "1/1")])
def test_files_that_may_not_grow(tmp_path, whole, extra):
    words = (*SWEEP, "-o", "out", *extra)
    code, said = cam(words, tmp_path, small_files)
    assert (code, "File too large" in said) == (2, True), said
    (path,) = tmp_path.glob("out/*.pieces")
    with open(path, "rb") as file:
        *_, last = records(file)
    assert 40_000 < last.end == path.stat().st_size < 60_000  # whole pieces, nothing torn
    code, said = cam(words, tmp_path)
    assert (code, "going on" in said) == (0, True)
    if extra:
        assert cam(("merge", "out", "--no-plot"), tmp_path)[0] == 0
        path.unlink()
    assert but_record(files(tmp_path / "out")) == whole


@pytest.mark.parametrize("name", [".sweep.csv.cam-part", "sweep-1-of-2.pieces"])
def test_a_folder_where_a_file_should_be(tmp_path, name):
    (tmp_path / "out" / name).mkdir(parents=True)
    code, said = cam((*SWEEP, "-o", "out", "--shard", "1/2"), tmp_path)
    assert (code, "internal fault" in said) == (0 if name[0] == "." else 2, False)
    code, said = cam((*SWEEP, "-o", "out"), tmp_path)
    assert (code, "internal fault" in said) == (2 if name[0] == "." else 0, False)
