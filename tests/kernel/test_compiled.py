"""Where the kernel's machine code comes from, and when numba's public way is taken.

The smallest entry stands for all: each is kept, tried and compiled alike.
"""

import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from pathlib import Path
from struct import pack
from time import sleep

import numba
import pytest

from camcli.kernel import backend, code_cache, compiled
from camcli.kernel.cam_table import TURN
from camcli.kernel.code_cache import News
from camcli.kernel.compiled import CodeSource
from camcli.kernel.self_check import case_of, is_right
from tests.conftest import own_way

ROOT = Path(__file__).parents[2]
ENTRY = "fill_flows"


class Source:
    """A source of code with a folder of its own, and what it tells."""

    def __init__(self, folder: Path):
        self.folder, self.news = folder, []

    def code(self):
        """The entry's code, as a process that begins gets it."""
        self.news.clear()
        call = CodeSource(self.folder, self.news.append).code(ENTRY, case_of(ENTRY))
        assert is_right(ENTRY, call)
        return call

    def files(self) -> list[str]:
        return sorted(p.name.split(".")[0] for p in self.folder.iterdir())


@pytest.fixture
def source(tmp_path):
    return Source(tmp_path / "camcli" / "kernel-0")


@pytest.fixture
def unknown(monkeypatch):
    """A numba that has not what our own way uses."""
    monkeypatch.setitem(sys.modules, "camcli.kernel.compiler", None)


@pytest.mark.ci
@pytest.mark.skipif(os.name == "nt", reason="there are no named pipes")
def test_a_numba_that_is_not_known_compiles_by_itself(source, unknown):
    before = numba.config.CACHE_DIR
    source.code()
    assert source.news == [News.COMPILING, News.PUBLIC]
    assert len(source.files()) == 1
    source.code()
    assert source.news == [News.PUBLIC]  # numba finds its code on the disk
    assert before == numba.config.CACHE_DIR
    (index,) = source.folder.rglob("*.nbi")
    index.unlink()
    os.mkfifo(index)  # which numba would wait for
    source.code()
    assert source.news == [News.COMPILING, News.PUBLIC]
    trial = compiled._Entry(source.folder, ENTRY, case_of(ENTRY)).trial_of_numba
    kept = {path: path.stat().st_mtime_ns for path in source.folder.rglob("*.nb?")}
    (source.folder / f"{trial}.0.trial").touch()  # a process ended while it tried this code
    source.code()
    assert set(source.news) >= {News.KILLED, News.PUBLIC}
    assert kept
    assert all(path.stat().st_mtime_ns > then for path, then in kept.items())  # made anew
    source.code()
    assert source.news == [News.PUBLIC]


@own_way
def test_our_own_way_is_taken_where_it_works_and_the_disk_next_time(source):
    source.code()
    assert source.news == [News.COMPILING]
    assert source.files() == [ENTRY]
    source.code()
    assert source.news == []


@pytest.mark.ci
@own_way
def test_our_own_way_works_where_numba_has_compiled_something_else_before(source, monkeypatch):
    """As in a notebook: by then numba knows functions that our way cannot lower."""
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "camcli.kernel.compiler", None)
        source.code()
        assert News.PUBLIC in source.news
    monkeypatch.delitem(sys.modules, "camcli.kernel.compiler", raising=False)
    news = []
    CodeSource(source.folder / "other", news.append).code("measure_loads", case_of("measure_loads"))
    assert news == [News.COMPILING]


def other_bits(content: bytes) -> bytes:
    """The same code with another last bit of 2 pi."""
    found = pack("<d", TURN)
    assert found in content
    return content.replace(found, pack("<d", math.nextafter(TURN, 0.0)))


@own_way
def test_code_on_the_disk_with_other_bits_is_damaged(source):
    source.code()
    (path,) = source.folder.iterdir()
    code_cache.keep_code(path, other_bits(code_cache.read_code(path)))
    source.code()
    assert source.news == [News.DAMAGED, News.COMPILING]
    assert source.files() == [ENTRY]


@own_way
def test_code_of_ours_with_other_bits_gives_way_to_the_public_way(source, monkeypatch):
    made = compiled._made_by_us
    monkeypatch.setattr(compiled, "_made_by_us", lambda entry: other_bits(made(entry)))
    source.code()
    assert source.news == [News.COMPILING, News.PUBLIC]
    assert not list(source.folder.glob(f"{ENTRY}.*"))  # it is not kept


@own_way
def test_code_of_ours_that_ended_two_processes_gives_way_to_the_public_way(source):
    """One may have been killed by somebody else."""
    code_cache.make_folder(source.folder)
    trial = compiled._Entry(source.folder, ENTRY, case_of(ENTRY)).trial_of_made
    marks = [source.folder / f"{trial}.{n}.trial" for n in range(2)]
    marks[0].touch()
    source.code()
    assert source.news == [News.COMPILING]
    assert source.files() == [ENTRY]
    for mark in marks:
        mark.touch()
    code_cache.discard(source.folder / next(source.folder.glob("*.nbc")))
    source.code()
    assert source.news == [News.COMPILING, News.PUBLIC]


def test_other_arguments_than_in_the_check_are_a_fault_of_the_program(source):
    cam, const, flows = case_of(ENTRY)
    with pytest.raises(TypeError, match="than in its check"):
        CodeSource(source.folder, source.news.append).code(ENTRY, (cam, const._replace(r=1), flows))


PUBLICLY = """
import runpy, sys
sys.modules["camcli.kernel.compiler"] = None
sys.argv = sys.argv[1:]
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""


@pytest.mark.soak
def test_commands_write_the_same_by_the_public_way(tmp_path):
    """A simulation, a sweep, basins and orbits, compiled by numba's public functions and by us."""
    lines = [
        "simulate --rpm 190", "sweep --rpm 660:760 --points 21", "basins --rpm 700 --cells 12,12",
        "orbits --rpm 700:702 --points 3",
    ]  # fmt: skip
    base = {**os.environ, "PYTHONPATH": str(ROOT), "CAMCLI_KERNEL": "compiled"}
    for name, start in (("ours", ("-m", "camcli")), ("public", ("-c", PUBLICLY, "camcli"))):
        env = {**base, "XDG_CACHE_HOME": str(tmp_path / name)}
        for line in lines:
            command, *words = line.split()
            words += ["--no-plot", "-o", str(tmp_path / name / command)]
            done = subprocess.run(
                [sys.executable, *start, command, *words],
                env=env, capture_output=True, text=True, check=False,
            )  # fmt: skip
            assert done.returncode == 0, done.stderr
            assert ("its own" in done.stderr or "by itself" in done.stderr) == (name == "public")
    for path in (tmp_path / "ours").glob("*/*.csv"):
        other = tmp_path / "public" / path.parent.name / path.name
        assert path.read_bytes() == other.read_bytes(), path


def test_a_run_is_not_charged_with_waiting_for_the_kernel(monkeypatch):
    """Ten seconds, three of them waited, by two threads at once in part, and one inside another."""
    now = [100.0]
    monkeypatch.setattr(backend, "perf_counter", lambda: now[0])

    def after(seconds):
        now[0] += seconds

    with backend.stopwatch() as outer:
        after(2.0)
        with backend.stopwatch() as watch:
            after(1.0)
            with watch.waiting():
                after(1.0)
                assert watch.passed() == 1.0
                with watch.waiting():
                    after(2.0)
            after(3.0)
            assert watch.passed() == 4.0
        after(1.0)
    assert (watch.seconds, watch.compile_seconds) == (4.0, 3.0)
    assert (outer.seconds, outer.compile_seconds) == (7.0, 3.0)


def test_one_entry_at_a_time_is_loaded_or_compiled(tmp_path, monkeypatch):
    """LLVM is at work for one thread only, whichever entries the threads wait for."""
    at_work, together = [], []

    def code(source, name, args):
        at_work.append(name)
        together.append(len(at_work))
        sleep(0.02)
        at_work.remove(name)
        return lambda *args: 0

    monkeypatch.setattr(CodeSource, "code", code)
    entries = compiled.compile_entries(tmp_path, nullcontext, lambda news: None).values()
    with ThreadPoolExecutor(len(entries)) as pool:
        list(pool.map(lambda entry: entry(()), entries))
    assert together == [1] * len(entries)


def test_news_are_told_to_the_nearest_run_that_asks_for_them():
    """A run within another one has its notice, or that of the other; without a run nobody is."""
    told: list = []
    with backend.stopwatch(lambda news: told.append(("outer", news))) as outer:
        with backend.stopwatch() as inner:
            backend._tell(News.DAMAGED)
            assert inner.outer is outer
        with backend.stopwatch(lambda news: told.append(("inner", news))):
            backend._tell(News.PUBLIC)
        backend._tell(News.KILLED)
    backend._tell(News.COMPILING)
    with backend.stopwatch():
        backend._tell(News.COMPILING)
    assert told == [("outer", News.DAMAGED), ("inner", News.PUBLIC), ("outer", News.KILLED)]


@pytest.mark.parametrize(
    ("kernel", "disabled", "may", "must"),
    [
        (None, None, True, False), ("python", None, False, False), ("compiled", None, True, True),
        ("auto", "0", True, False), ("compiled", "1", False, False), (None, " True ", False, False),
        (None, "yes", False, False), ("else", "no", True, False),
    ],
)  # fmt: skip
def test_the_environment_says_whether_the_kernel_is_compiled(
    monkeypatch, kernel, disabled, may, must
):
    for name, value in (("CAMCLI_KERNEL", kernel), ("NUMBA_DISABLE_JIT", disabled)):
        monkeypatch.delenv(name, raising=False)
        if value is not None:
            monkeypatch.setenv(name, value)
    assert (backend.may_compile(), backend.must_compile()) == (may, must)
