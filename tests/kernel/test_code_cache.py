"""Code from the disk is run, so it is read only where it is a plain file of this user's own."""

import contextlib
import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from camcli.kernel import code_cache
from camcli.kernel.code_cache import DamagedCodeError, deaths, keep_code, on_trial, read_code

ROOT = Path(__file__).parents[2]
posix = pytest.mark.skipif(os.name == "nt", reason="there are no such files or owners")


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "camcli" / "kernel-0"
    code_cache.make_folder(place)
    return place


def python(script: str, *words: object, **options) -> subprocess.CompletedProcess:
    """The script in a process of its own, which is ended where it hangs."""
    command = [sys.executable, "-c", script, *map(str, words)]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        command, capture_output=True, text=True, timeout=30, env=env, check=False, **options
    )


def test_what_is_kept_is_read_again_under_its_own_name_only(folder):
    path = folder / "advance.0.nbc"
    assert read_code(path) is None
    keep_code(path, b"code")
    assert read_code(path) == b"code"
    path.rename(folder / "settle_cells.0.nbc")
    with pytest.raises(DamagedCodeError):
        read_code(folder / "settle_cells.0.nbc")


@posix
def test_an_entry_is_cached_where_code_of_this_machine_is_kept_undamaged(folder, monkeypatch):
    monkeypatch.setattr(code_cache, "cache_dir", lambda: folder)
    monkeypatch.setattr(code_cache, "machine_key", lambda: "here")
    assert not code_cache.is_cached("advance")
    keep_code(folder / f"advance.there.0{code_cache.CODE}", b"code")
    assert not code_cache.is_cached("advance")  # of another machine
    path = folder / f"advance.here.0{code_cache.CODE}"
    keep_code(path, b"code")
    assert code_cache.is_cached("advance")
    assert not code_cache.is_cached("settle_cells")
    path.write_bytes(path.read_bytes()[:-1])
    path.chmod(0o600)
    assert not code_cache.is_cached("advance")  # damaged
    path.unlink()
    keep_code(path, b"code")
    folder.chmod(0o777)
    assert not code_cache.is_cached("advance")  # others may write there


@posix
def test_the_folder_and_its_files_are_for_this_user_alone(folder):
    path = folder / "advance.0.nbc"
    umask = os.umask(0)
    try:
        keep_code(path, b"code")
    finally:
        os.umask(umask)
    assert [stat.S_IMODE(place.stat().st_mode) for place in (folder, path)] == [0o700, 0o600]


READ = """
import sys
from pathlib import Path
from camcli.kernel.code_cache import DamagedCodeError, read_code
try:
    read_code(Path(sys.argv[1]))
except DamagedCodeError:
    print("damaged")
"""


def links_to(place):
    return lambda path: path.symlink_to(place)


def socket_at(path):
    import socket

    here = os.getcwd()
    os.chdir(path.parent)  # a socket's path is short
    try:
        socket.socket(socket.AF_UNIX).bind(path.name)
    finally:
        os.chdir(here)


@posix
@pytest.mark.parametrize(
    "make",
    [
        lambda path: os.mkfifo(path),
        links_to("/dev/zero"),
        links_to("code"),
        socket_at,
        lambda path: path.write_bytes(bytes(code_cache.MOST_BYTES + 100)),
        lambda path: path.touch(),
    ],
    ids=["pipe", "device", "link", "socket", "large", "empty"],
)
def test_what_is_no_plain_file_is_damaged(folder, make):
    keep_code(folder / "code", b"code")
    make(folder / "advance.0.nbc")
    assert python(READ, folder / "advance.0.nbc").stdout == "damaged\n"


@posix
@pytest.mark.parametrize("mode", [0o620, 0o602])
def test_a_file_that_others_may_write_is_damaged(folder, mode):
    path = folder / "advance.0.nbc"
    keep_code(path, b"code")
    path.chmod(mode)
    with pytest.raises(DamagedCodeError):
        read_code(path)


@posix
def test_a_folder_is_trusted_where_nobody_else_may_write(folder, tmp_path, monkeypatch):
    assert code_cache.is_trusted(folder)
    for mode, trusted in ((0o755, True), (0o775, False), (0o707, False), (0o500, True)):
        folder.chmod(mode)
        assert code_cache.is_trusted(folder) == trusted
    folder.chmod(0o700)
    (tmp_path / "link").symlink_to(folder)
    assert not code_cache.is_trusted(tmp_path / "link")
    me = 1000
    monkeypatch.setattr(os, "geteuid", lambda: me)
    for owner, ours in ((me, True), (0, True), (me + 1, False)):
        status = os.stat_result((stat.S_IFDIR | 0o700, 1, 1, 1, owner, 0, 0, 0, 0, 0))
        assert code_cache.is_ours(status) == ours


TRY = """
import os, signal, sys, time
from pathlib import Path
from camcli import interrupts
from camcli.kernel.code_cache import on_trial
interrupts.install()
with interrupts.compiling(), on_trial(Path(sys.argv[1]), "code"):
    print("there", flush=True)
    time.sleep(60)
"""


@posix
@pytest.mark.parametrize(
    ("number", "left"), [(signal.SIGKILL, 1), (signal.SIGSEGV, 1), (signal.SIGTERM, 0)]
)
def test_a_death_is_told_from_a_trial_that_lasts_and_from_an_interrupt(folder, number, left):
    command = [sys.executable, "-c", TRY, str(folder)]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    processes = [
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=env)
        for _ in range(2)
    ]
    for process in processes:
        assert process.stdout.readline() == b"there\n"
    with on_trial(folder, "code"):
        assert len(list(folder.iterdir())) == 3
        assert deaths(folder, "code") == []
        processes[0].send_signal(number)
        processes[0].communicate()
        assert len(deaths(folder, "code")) == left  # of three marks: two are still at it
        assert deaths(folder, "other") == []
    processes[1].kill()
    processes[1].communicate()
    assert len(deaths(folder, "code")) == left + 1


def test_a_trial_that_ends_or_fails_leaves_no_mark(folder):
    def fails():
        with on_trial(folder, "code"):
            assert len(list(folder.iterdir())) == 1
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()
    assert list(folder.iterdir()) == []
    folder.chmod(0o777)
    with on_trial(folder, "code"):  # nothing is written into a folder of others
        assert list(folder.iterdir()) == []


def test_without_locks_the_age_of_a_mark_decides(folder, monkeypatch):
    monkeypatch.setattr(code_cache, "fcntl", None)
    with on_trial(folder, "code"):
        (mark,) = folder.iterdir()
        assert deaths(folder, "code") == []
        old = time.time() - 2 * code_cache.ABANDONED
        os.utime(mark, (old, old))
        assert deaths(folder, "code") == [mark]


@pytest.mark.parametrize("name", code_cache.CODE_SETTINGS)
def test_settings_that_change_code_change_the_key(monkeypatch, name):
    from numba.core import config

    assert f'"{name}"' in Path(config.__file__).read_text()  # numba still has it
    key = code_cache.machine_key.__wrapped__
    before = key()
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "elsewhere")
    assert key() == before
    monkeypatch.setenv(name, "0")
    assert key() != before


def open_handles() -> set[int]:
    """The handles that this process has open."""
    found = set()
    for handle in range(512):
        with contextlib.suppress(OSError):
            os.fstat(handle)
            found.add(handle)
    return found


def is_free(folder: Path) -> bool:
    """Whether another one may begin to compile."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        code_cache.fcntl.flock(handle, code_cache.fcntl.LOCK_EX | code_cache.fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    finally:
        os.close(handle)
    return True


@posix
@pytest.mark.parametrize("fails", [False, True])
def test_one_alone_compiles_and_the_next_one_may_when_it_has_ended(folder, fails):
    """However it ends; a handle that stayed open would keep the next one for a minute."""
    before = open_handles()
    with contextlib.suppress(ZeroDivisionError), code_cache.alone(folder):
        assert not is_free(folder)
        if fails:
            raise ZeroDivisionError
    assert is_free(folder)
    assert open_handles() == before


@posix
def test_no_handle_stays_open(folder):
    before = open_handles()
    keep_code(folder / "advance.0.nbc", b"code")
    assert read_code(folder / "advance.0.nbc") == b"code"
    with on_trial(folder, "advance"):
        assert deaths(folder, "advance") == []
        assert open_handles() > before  # the mark's, which is locked
    assert deaths(folder, "advance") == []
    assert open_handles() == before
