"""The output folder: checked and locked before any work, changed at the end of it at once."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from camcli.errors import Fault, SceneError

PART = ".part"


class Store:
    """Artefacts of one run in one folder.

    Every file is written beside its place; `commit` moves all there by renames, so that until then
    the artefacts of an earlier run stand as they were. One process at a time has the folder.
    """

    def __init__(self, folder: Path):
        """Create and lock the folder, or raise SceneError if artefacts could not be written."""
        self.folder = folder
        self.hashes: dict[str, str] = {}
        self._written: list[str] = []
        self._dropped: list[str] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise _refused(folder, "found a file where the folder should be") from None
        except OSError as error:
            raise _refused(folder, f"found no way to create it ({error.strerror})") from None
        if not os.access(folder, os.W_OK | os.X_OK):
            raise _refused(folder, "found a folder that may not be written")
        self._lock = locked(folder)
        try:
            for stale in folder.glob(f".*{PART}"):  # of a run that was killed
                stale.unlink(missing_ok=True)
        except OSError as error:
            self.close()
            raise _refused(
                folder, f"{stale.name} could not be removed ({error.strerror})"
            ) from None

    def write(self, name: str, fill: Callable[[BinaryIO], None]) -> None:
        """Let `fill` write the bytes of `name`; an earlier file stays until `commit`."""
        part = self._part(name)
        try:
            with open(part, "wb") as file:
                fill(file)
                file.flush()
                os.fsync(file.fileno())
            self.hashes[name] = _hash(part)
        except OSError as error:
            part.unlink(missing_ok=True)
            raise unwritable(self.folder, name, error) from None
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        self._written = [other for other in self._written if other != name] + [name]

    def write_text(self, name: str, chunks: Iterable[str]) -> None:
        """Write `name` from pieces of text."""
        self.write(name, lambda file: file.writelines(chunk.encode() for chunk in chunks))

    def remove(self, name: str) -> None:
        """Drop, with the next commit, an artefact of an earlier run that this run does not make."""
        self._dropped.append(name)

    def commit(self) -> None:
        """Put everything written in its place, in the order in which it was written."""
        name = ""
        try:
            for name in self._dropped:
                if name not in self._written:
                    (self.folder / name).unlink(missing_ok=True)
            for name in self._written:
                os.replace(self._part(name), self.folder / name)
        except OSError as error:
            raise unwritable(self.folder, name, error) from None
        self._written, self._dropped = [], []

    def close(self) -> None:
        """Leave the folder to others; what was not committed is gone."""
        for name in self._written:
            self._part(name).unlink(missing_ok=True)
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    def _part(self, name: str) -> Path:
        return self.folder / f".{name}{PART}"


def locked(folder: Path) -> int | None:
    """A lock on a folder or file that ends with the process; None where the system has none.

    Raises SceneError where another process has it.
    """
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        found, cure = "found another run at work here", "wait for it, or choose another"
        raise SceneError(Fault("-o", str(folder), found, "expected it free", cure)) from None
    except OSError:  # a file system without locks
        os.close(handle)
        return None
    return handle


def unwritable(folder: Path, name: str, error: OSError) -> SceneError:
    """The refusal for a file that could not be written."""
    return _refused(folder, f"{name} could not be written ({error.strerror})")


def _hash(path: Path) -> str:
    digest = sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _refused(folder: Path, found: str) -> SceneError:
    return SceneError(
        Fault("-o", str(folder), found, "expected a writable folder", "choose another")
    )
