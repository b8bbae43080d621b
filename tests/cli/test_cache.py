"""The kernel's cache on disk may be damaged, full, read-only or another's: it only costs time."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.cli.run import NEWS
from camcli.kernel import code_cache
from camcli.kernel.code_cache import News
from tests.conftest import own_way, refused

WORDS = ("simulate", "--rpm", "190", "--no-plot", "-q", "--set", "run.transient=3")
ROOT = Path(__file__).parents[2]


posix = pytest.mark.skipif(os.name == "nt", reason="there are no such files or owners")

IMPATIENT = """
from camcli.kernel import code_cache
code_cache.ABANDONED = 1.0
from camcli.cli.app import main
main()
"""


def cam(cache: Path, *words: str, start=("-m", "camcli"), **options):
    """The command with the kernel compiled, and its code kept in `cache`."""
    env = {**options.pop("env", os.environ), "XDG_CACHE_HOME": str(cache)}
    env["CAMCLI_KERNEL"] = "compiled"
    command = [sys.executable, *start, *(words or WORDS)]
    return subprocess.run(command, capture_output=True, text=True, env=env, **options)


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """(a filled cache, events.csv)"""
    folder = tmp_path_factory.mktemp("warm")
    filled = code_cache.cache_dir()
    if filled.is_dir():  # spares a compilation
        # not what a process left that was killed while it tried code, as some tests do
        left = shutil.ignore_patterns("*.kept.*", "*.made.*", "*.numba.*")
        shutil.copytree(filled, folder / "cache" / "camcli" / filled.name, ignore=left)
    done = cam(folder / "cache", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "cache", (folder / "out/simulate/events.csv").read_bytes()


@pytest.fixture
def cache(warm, tmp_path):
    """A copy of the filled cache."""
    shutil.copytree(warm[0], tmp_path / "cache")
    return tmp_path / "cache"


def code_files(cache: Path, entry: str = "*") -> list[Path]:
    found = sorted(cache.rglob(f"{entry}.*.nbc"))
    assert found
    return found


def test_there_are_words_for_all_news():
    assert set(NEWS) == set(News)


CHEAP = "stretch_events"  # the entry of a simulation that is compiled soonest; all are kept alike


DAMAGES = {
    "empty": lambda data: b"",
    "cut": lambda data: data[: len(data) // 2],
    "a bit": lambda data: data[:-1000] + bytes([data[-1000] ^ 1]) + data[-999:],
    "another": lambda data: b"\x80\x05K\x01." * 20,
}


@pytest.mark.ci
@own_way
@pytest.mark.slow
@pytest.mark.parametrize(
    "how", [k if k == "a bit" else pytest.param(k, marks=pytest.mark.soak) for k in DAMAGES]
)
def test_a_damaged_cache_is_said_and_made_anew(cache, warm, tmp_path, how):
    for path in code_files(cache, CHEAP):
        path.write_bytes(DAMAGES[how](path.read_bytes()))
    killed, at_work = (path.with_suffix(f".{name}") for name in ("killed", "now"))
    for part in (killed, at_work):
        part.write_bytes(b"half")
    old, recent = (cache / "camcli" / f"kernel-{age}" / "advance.0.nbc" for age in ("old", "new"))
    for code in (old, recent):
        code.parent.mkdir()
        code.touch()
    for path, written in ((killed, 0), (old, 0), (at_work, 2**33)):
        os.utime(path, (written, written))
    words = [word for word in WORDS if word != "-q"]
    fcntl = pytest.importorskip("fcntl")
    handle = os.open(killed.parent, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)  # as one that was stopped while it compiled
    done = cam(cache, *words, start=("-c", IMPATIENT), cwd=tmp_path)
    os.close(handle)
    assert (done.returncode, "was damaged and is removed" in done.stderr) == (0, True), done.stderr
    assert (tmp_path / "out/simulate/events.csv").read_bytes() == warm[1]
    kept = [path for path in code_files(cache) if path != recent]
    for path in kept:
        os.utime(path, (0, 0))
    assert "compiling" not in cam(cache, *words, cwd=tmp_path).stderr
    assert any(path.stat().st_mtime > 0 for path in kept)
    assert (killed.exists(), at_work.exists()) == (False, True)
    assert (old.parent.exists(), recent.exists()) == (False, True)


@pytest.fixture
def without_numba(tmp_path):
    """The environment of a program that fails where it imports numba."""
    (tmp_path / "numba.py").write_text("raise ImportError")
    path = f"{tmp_path}{os.pathsep}{ROOT}"
    return {**os.environ, "PYTHONPATH": path, "CAMCLI_KERNEL": "compiled"}


@own_way
@pytest.mark.parametrize("threads", [None, "1", "0"])
def test_compiled_code_runs_without_numba(cache, warm, tmp_path, without_numba, threads):
    """Settings of numba that change no code, and that it could not start with, change nothing."""
    if threads is not None:
        without_numba["NUMBA_NUM_THREADS"] = threads
    done = cam(cache, cwd=tmp_path, env=without_numba)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/simulate/events.csv").read_bytes() == warm[1]


@own_way
def test_of_processes_that_start_at_once_one_compiles(warm, tmp_path, without_numba):
    """A process that finds another at work waits for its code, and compiles nothing itself."""
    fcntl = pytest.importorskip("fcntl")
    folder = tmp_path / "cache" / "camcli" / code_cache.cache_dir().name
    folder.mkdir(parents=True)
    command = [sys.executable, "-m", "camcli", *(word for word in WORDS if word != "-q")]
    env = {**without_numba, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    handle = os.open(folder, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    with subprocess.Popen(command, stderr=subprocess.PIPE, env=env, cwd=tmp_path) as process:
        assert "compiling" in process.stderr.readline().decode()
        for path in code_files(warm[0]):
            shutil.copy(path, folder)
        os.close(handle)
    assert process.returncode == 0
    assert (tmp_path / "out/simulate/events.csv").read_bytes() == warm[1]


NUMBA_FAULTS = {
    "NUMBA_NUM_THREADS: found '0', expected a whole number above 0": {"NUMBA_NUM_THREADS": "0"},
    "numba: cannot be imported (ImportError: ": {},
}


@pytest.mark.parametrize("line", ["simulate --rpm 190", "sweep --points 2 --threads 2"])
@pytest.mark.parametrize("said", NUMBA_FAULTS)
def test_a_numba_that_cannot_start_is_a_fault_with_its_cure(tmp_path, without_numba, line, said):
    env = {**without_numba, **NUMBA_FAULTS[said]}
    done = cam(tmp_path / "cold", *line.split(), "--no-plot", cwd=tmp_path, env=env)
    refused(done, said)
    assert done.stderr.count(said) == 1


@own_way
@posix
def test_a_pipe_in_the_cache_does_not_stop_a_run(cache, warm, tmp_path, without_numba):
    """Nor does a link to a device: both are removed, and the code is compiled again."""
    for path in code_files(cache, CHEAP):
        path.unlink()
        os.mkfifo(path)
    words = [word for word in WORDS if word != "-q"]
    done = cam(cache, *words, cwd=tmp_path, env=without_numba, timeout=60)
    assert "was damaged and is removed" in done.stderr
    assert not list(cache.rglob(f"{CHEAP}.*"))


@posix
@pytest.mark.parametrize("place", ["folder", "link"])
def test_a_cache_that_others_may_write_is_not_used(cache, tmp_path, without_numba, place):
    folder = cache / "camcli" / code_cache.cache_dir().name
    if place == "folder":
        folder.chmod(0o770)
    else:
        folder.rename(tmp_path / "elsewhere")
        folder.symlink_to(tmp_path / "elsewhere")
    words = [word for word in WORDS if word != "-q"]
    done = cam(cache, *words, cwd=tmp_path, env=without_numba)
    refused(done, "numba: cannot be imported", f"{folder} is not a folder that only you may write")


HEAD = 64  # bytes of an object file before its instructions


def crashing(path: Path) -> None:
    """Keep code with a right sum that ends a process: its instructions are overwritten."""
    content = code_cache.read_code(path)
    symbol, _, code = content.partition(b"\n")
    code = code[:HEAD] + bytes(4096) + code[HEAD + 4096 :]
    code_cache.keep_code(path, symbol + b"\n" + code)


@own_way
@posix
def test_code_that_ended_a_process_is_not_loaded_again(cache, tmp_path, without_numba):
    (path,) = code_files(cache, CHEAP)
    crashing(path)
    words = [word for word in WORDS if word != "-q"]
    codes = []
    for _ in range(2):
        done = cam(cache, *words, cwd=tmp_path, env=without_numba)
        codes.append(done.returncode)
    assert codes[0] < 0  # a signal ended it
    refused(done, "an earlier process ended while it loaded the kernel", "numba: cannot be")
    assert not list(cache.rglob(f"{CHEAP}.*"))  # nor is a mark left


@pytest.mark.ci
@own_way
@pytest.mark.slow
def test_a_full_disk_under_the_cache_is_no_trouble(tmp_path, warm):
    place = tmp_path / "disk"
    place.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=4M", "tmpfs", str(place)]
    if os.geteuid() != 0 or subprocess.run(words, capture_output=True, check=False).returncode != 0:
        pytest.skip("needs the right to mount a tmpfs")
    try:
        shutil.copytree(warm[0], place, dirs_exist_ok=True)
        for path in code_files(place, CHEAP):
            path.unlink()
        with pytest.raises(OSError, match="No space"):
            (place / "filler").write_bytes(bytes(2**23))
        done = cam(place, cwd=tmp_path)
        assert not list(place.rglob(f"{CHEAP}.*"))
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out/simulate/events.csv").read_bytes() == warm[1]


@pytest.mark.ci
@own_way
@pytest.mark.slow
def test_a_read_only_cache_never_serves_code_of_other_sources(cache, warm, tmp_path):
    """An edited copy of the program beside a filled cache that cannot be written."""
    package = tmp_path / "camcli"
    shutil.copytree(ROOT / "camcli", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    (tmp_path / "cache").chmod(0o500)
    env = {**os.environ, "PYTHONPATH": str(tmp_path), "XDG_CACHE_HOME": str(cache)}
    asking = [
        sys.executable,
        "-c",
        "from camcli.kernel import code_cache as c; print(c.is_cached())",
    ]
    for found in ("True", "False"):
        done = subprocess.run(asking, capture_output=True, text=True, env=env, cwd=tmp_path)
        assert done.stdout.strip() == found
        with open(package / "kernel" / "flow.py", "a") as file:
            file.write("\n# another kernel\n")
    assert not list(package.rglob("*.nb?"))
