"""A stdout or a stderr that fails costs no artefact, and the exit code stays what it is."""

import os
import subprocess
import sys
from io import BytesIO, TextIOWrapper

import pytest

from camcli.cli.exit_codes import Held, _to_nowhere

pytestmark = pytest.mark.slow

TURNS = ("--set", "run.transient=5", "--set", "run.record=20", "--set", "run.patience=0")
SWEEP = ("sweep", "--points", "3", "--no-plot", *TURNS)
WARNED = (*SWEEP, "--set", "follower.restitution=1", "--set", "run.record=2")
LEFT = ("simulate", "--no-plot", "--set", "run.impact_budget=5", "--rpm", "190")
MADE = {"impacts.csv", "strobe.csv", "speeds.csv", "run.json"}
FULL = "/dev/full"


def cam(folder, *words: str, **streams) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "camcli", *words]
    return subprocess.run(command, cwd=folder, **{"stderr": subprocess.PIPE, **streams})


def made(folder):
    return {path.name for path in (folder / "out/sweep").iterdir()}


@pytest.fixture
def left():
    """A pipe whose reader has left."""
    ours, theirs = os.pipe()
    os.close(ours)
    yield theirs
    os.close(theirs)


def test_a_reader_that_leaves(tmp_path, left):
    done = cam(tmp_path, *SWEEP, "-q", stdout=left)
    assert (done.returncode, done.stderr) == (0, b"")
    assert made(tmp_path) == MADE


@pytest.mark.skipif(not os.path.exists(FULL), reason="no full device here")
def test_a_full_disk_under_stdout(tmp_path):
    with open(FULL, "wb") as full:
        done = cam(tmp_path, *SWEEP, "-q", stdout=full)
    assert done.returncode == 2
    assert done.stderr.startswith(b"stdout: could not be written (No space left on device)")
    assert made(tmp_path) == MADE


@pytest.mark.skipif(not os.path.exists(FULL), reason="no full device here")
@pytest.mark.parametrize(
    ("words", "code"), [(WARNED, 0), (LEFT, 3), (("sweep", "--rpm", "x"), 2)], ids=str
)
def test_notes_that_cannot_be_written_are_dropped(tmp_path, left, words, code):
    with open(FULL, "wb") as full:
        stream = left if code == 3 else full
        done = cam(tmp_path, *words, stdout=subprocess.DEVNULL, stderr=stream)
    assert done.returncode == code
    assert code or made(tmp_path) == MADE


@pytest.mark.parametrize("words", [(*SWEEP, "-q"), ("--help",)], ids=["sweep", "help"])
def test_no_stdout_at_all(tmp_path, words):
    done = cam(tmp_path, *words, preexec_fn=lambda: os.close(1))
    assert (done.returncode, done.stderr) == (0, b"")


def test_letters_that_an_encoding_lacks_are_escaped_and_names_keep_their_bytes():
    """In the locale C Python's stdout is ASCII and hands the bytes of names through."""
    real = TextIOWrapper(BytesIO(), encoding="ascii", errors="surrogateescape")
    held = Held(real)
    name = b"gr\xc3\xb6\xdfe".decode("ascii", "surrogateescape")
    held.write(f"{name}: Poincar\u00e9, \u03b8")
    held.flush()
    assert held.bytes.getvalue() == b"gr\xc3\xb6\xdfe: Poincar\\xe9, \\u03b8"


def test_a_folder_with_an_endless_name(tmp_path):
    done = cam(tmp_path, *SWEEP, "-o", "a" * 300, stdout=subprocess.DEVNULL)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert b"File name too long" in line


@pytest.mark.parametrize(
    ("words", "theory"),
    [("classify --rpm 700", "add up to 2 ln r"), ("orbits --rpm 700", "multipliers"),
     ("basins --rpm 700 --cells 4,4", "basin entropy")],
)  # fmt: skip
def test_theory_is_printed_where_it_is_asked_for(cam, words, theory):
    assert theory not in cam(words, "--no-plot").stdout
    assert theory in cam(words, "--no-plot --verbose", code=0).stdout


@pytest.mark.parametrize("words", ["simulate", "sweep", "classify", "basins --cells 3,3"])
def test_a_speed_at_which_the_follower_flies_absurdly_high_is_warned_of(cam, words):
    """v = omega max |c_theta| over omega0 is 840 m; the spring is already bent by c."""
    short = "--no-plot --set run.transient=2 --set run.record=2 --set basins.budget=20 --rpm"
    assert "the cam throws the follower 840 m up" in cam(words, short, "1e6").stderr
    assert "throws" not in cam(words, short, "1000").stderr


def test_what_nobody_reads_any_more_is_dropped_without_a_fault(tmp_path):
    """Also what is written later, when Python ends."""
    with open(tmp_path / "out", "w") as stream:
        stream.write("said, ")
        stream.flush()
        _to_nowhere(stream)
        stream.write("and not heard")
        stream.flush()
    assert (tmp_path / "out").read_text() == "said, "
