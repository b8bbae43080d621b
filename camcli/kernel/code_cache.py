"""The folder on disk that keeps the kernel's machine code between runs.

What is read from it is run. So the folder and each file in it count only where they belong to this
user or to the administrator, and nobody else may write them. A file is opened without following a
link and without waiting for a pipe, and no more than MOST_BYTES of it are read. It begins with a
SHA-256 of its own name and its content.

Whoever runs code for the first time marks it: `on_trial` puts an empty file beside it, with a lock
on it, and removes it when the code has been checked. The system drops the lock when the process
ends, however it ends. So a mark without a lock is left of a process that died there, and a mark
with a lock belongs to one that is still at it. Where the system has no locks the age of a mark
decides.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from functools import cache
from pathlib import Path
from shutil import rmtree
from time import sleep, time

from camcli import errors
from camcli.installed import version
from camcli.interrupts import removed_if_ended

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

MOST_BYTES = 1 << 26  # of a file; an entry takes some 80 kB
ABANDONED = 60.0  # s: nobody compiles, tries code or writes a file for so long
LOOKS = 600  # in that time, whether the other one is done
UNUSED = 30 * 86400.0  # s, after which code goes, of whatever sources it is
CODE, MARK = ".nbc", ".trial"  # ends of names
SUM = hashlib.sha256().digest_size
# Numba's settings that change the machine code; the others, as NUMBA_NUM_THREADS, leave it alone.
CODE_SETTINGS = (
    "NUMBA_BOUNDSCHECK", "NUMBA_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_DEBUGINFO",
    "NUMBA_ENABLE_AVX", "NUMBA_EXTEND_VARIABLE_LIFETIMES", "NUMBA_LLVM_REFPRUNE_FLAGS",
    "NUMBA_LLVM_REFPRUNE_PASS", "NUMBA_LOOP_VECTORIZE", "NUMBA_OPT", "NUMBA_SLP_VECTORIZE",
)  # fmt: skip
# An open that waits for nothing and follows no link.
CAREFULLY = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
# What the system says of a link (two ways) and of a socket that are opened so.
NO_FILE = (errno.ELOOP, errno.EMLINK, errno.ENXIO)


class News(Enum):
    """What a user may want to know of the kernel's machine code."""

    COMPILING = "compiling"  # it is not on disk, and takes some seconds
    DAMAGED = "damaged"  # what was on disk is removed
    KILLED = "killed"  # what was on disk ended a process that tried it, and is removed
    NOT_OURS = "not-ours"  # others may write the folder on disk, so it is not used
    PUBLIC = "public"  # numba's public functions compile it, which makes each start slower


class DamagedCodeError(Exception):
    """What stands in the place of a file of code is not what was written there."""


@cache
def source_hash() -> str:
    """Hash of every source that decides about the compiled code: it names the folder.

    numba itself sees only edits in the file of an entry, not in what it calls.
    """
    digest = hashlib.sha256()
    for path in (Path(errors.__file__), *sorted(Path(__file__).parent.glob("*.py"))):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_dir() -> Path:
    """Folder of the compiled kernel: one per state of the sources."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    if home.startswith("~"):
        home = os.devnull  # a user without a home: nothing is kept, which only costs time
    return Path(home) / "camcli" / f"kernel-{source_hash()}"


@cache
def machine_key() -> str:
    """Hash of all that the code depends on beside the sources: it is in the names of files."""
    import sys

    import llvmlite.binding as llvm

    cpu = llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features()
    settings = [(name, os.environ.get(name)) for name in CODE_SETTINGS]
    python = sys.implementation.name, *sys.version_info[:2]
    depends = *map(version, ("numba", "llvmlite")), python, *map(str, cpu), settings
    return hashlib.sha256(repr(depends).encode()).hexdigest()[:16]


def is_ours(status: os.stat_result) -> bool:
    """False where anybody but this user and the administrator can have written a file or folder."""
    if not hasattr(os, "geteuid"):
        return True  # such a system keeps its permissions elsewhere
    return status.st_uid in (0, os.geteuid()) and not status.st_mode & 0o022


def is_trusted(folder: Path) -> bool:
    """True for a folder, and no link to one, that is ours."""
    try:
        status = os.lstat(folder)
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and is_ours(status)


def is_plain(path: Path) -> bool:
    """True for a file or folder, and no link, pipe or device, that belongs to us."""
    try:
        status = os.lstat(path)
    except OSError:
        return True  # it has gone
    plain = stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)
    return plain and (not hasattr(os, "geteuid") or status.st_uid in (0, os.geteuid()))


def make_folder(folder: Path) -> None:
    """Make the folder, for this user alone, where that can be done."""
    with suppress(OSError):
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)


def is_cached(entry: str = "follow_orbits") -> bool:
    """True if an earlier process left this entry compiled for these sources, and undamaged."""
    folder = cache_dir()
    if not is_trusted(folder) or not any(folder.glob(f"{entry}.*{CODE}")):
        return False
    with suppress(DamagedCodeError):
        files = folder.glob(f"{entry}.{machine_key()}.*{CODE}")
        return any(read_code(path) is not None for path in files)
    return False


def read_code(path: Path) -> bytes | None:
    """What `keep_code` kept at this path, None where there is no file that can be read.

    Raises DamagedCodeError for anything else, which `discard` removes.
    """
    try:
        handle = os.open(path, os.O_RDONLY | CAREFULLY)
    except OSError as error:
        if error.errno in NO_FILE:
            raise DamagedCodeError from None
        return None
    with open(handle, "rb") as file:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode) or not is_ours(status):
            raise DamagedCodeError
        data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES or data[:SUM] != _sum(path, data[SUM:]):
            raise DamagedCodeError
    with suppress(OSError):
        os.utime(path)  # when it was used last
    return data[SUM:]


def keep_code(path: Path, content: bytes) -> None:
    """Write a file for `read_code`; beside its place first, so that nobody finds half of it.

    A file that a killed process left half written is removed, and code that nobody uses any more.
    """
    part = path.with_suffix(f".{os.urandom(8).hex()}")
    with suppress(OSError):
        try:
            with open(_created(part), "wb") as file:
                file.write(_sum(path, content) + content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    for other in path.parent.parent.glob("kernel-*/*"):
        with suppress(OSError):
            status = os.lstat(other)
            lasting = other.suffix in (CODE, MARK) or stat.S_ISDIR(status.st_mode)
            if time() - status.st_mtime > (UNUSED if lasting else ABANDONED):
                discard(other)
                other.parent.rmdir()


def discard(path: Path) -> None:
    """Remove a file or folder, if that can be done."""
    with suppress(OSError):
        if path.is_dir() and not path.is_symlink():
            rmtree(path)
        else:
            path.unlink(missing_ok=True)


def _sum(path: Path, content: bytes) -> bytes:
    """SHA-256 of the file's name and content: a file under another's name is damaged too."""
    return hashlib.sha256(path.name.encode() + b"\n" + content).digest()


def _created(path: Path) -> int:
    """Handle of a new file for this user alone."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | CAREFULLY, 0o600)


@contextmanager
def on_trial(folder: Path, name: str) -> Iterator[None]:
    """Mark in the folder that this process is in the block; see `deaths`.

    Nothing is marked where the folder cannot be written.
    """
    draft = folder / f"{name}.{os.urandom(8).hex()}"
    mark = draft.with_name(draft.name + MARK)
    handle = None
    with suppress(OSError):
        if is_trusted(folder):
            handle = _created(draft)
            _lock(handle)
            draft.rename(mark)  # locked before anybody can see it
    try:
        with removed_if_ended(mark):
            yield
    finally:
        discard(draft)
        discard(mark)
        if handle is not None:
            os.close(handle)


def deaths(folder: Path, name: str) -> list[Path]:
    """The marks of processes that ended while they were in `on_trial` under this name."""
    if not is_trusted(folder):
        return []
    return [mark for mark in folder.glob(f"{name}.*{MARK}") if _is_abandoned(mark)]


def _lock(handle: int) -> None:
    """Lock a mark of our own, where the system and the file's disk have locks."""
    with suppress(OSError):
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_abandoned(mark: Path) -> bool:
    """True for a mark whose process has ended; by its age where there are no locks."""
    try:
        handle = os.open(mark, os.O_RDONLY | CAREFULLY)
    except OSError as error:
        return error.errno in NO_FILE
    try:
        old = time() - os.fstat(handle).st_mtime > ABANDONED
        if fcntl is None:
            return old
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return True
    except BlockingIOError:
        return False
    except OSError:
        return old
    finally:
        os.close(handle)


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Let one process compile while others wait that start with it, where there are locks.

    Not for ever: it may have been stopped.
    """
    handle = None
    try:
        with suppress(OSError):
            if fcntl is not None and is_trusted(folder):
                handle = os.open(folder, os.O_RDONLY)
                for _ in range(LOOKS):
                    with suppress(BlockingIOError):
                        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                        break
                    sleep(ABANDONED / LOOKS)
        yield
    finally:
        if handle is not None:
            os.close(handle)
