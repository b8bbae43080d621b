"""The output folder: checked before any work, written atomically after it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO

from camcli.errors import Fault, SceneError


class Store:
    """Artefacts of one run in one folder; every file appears complete by a rename."""

    def __init__(self, folder: Path):
        """Create the folder, or raise SceneError if artefacts could not be written there."""
        self.folder = folder
        self.hashes: dict[str, str] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise _refused(folder, "found a file where the folder should be") from None
        except OSError as error:
            raise _refused(folder, f"found no way to create it ({error.strerror})") from None
        if not os.access(folder, os.W_OK | os.X_OK):
            raise _refused(folder, "found a folder that may not be written")

    def write(self, name: str, fill: Callable[[BinaryIO], None]) -> None:
        """Let `fill` write the bytes of `name`; an earlier file stays until this one is whole."""
        part = self.folder / f".{name}.{os.getpid()}.part"
        try:
            with open(part, "wb") as file:
                fill(file)
                file.flush()
                os.fsync(file.fileno())
            self.hashes[name] = _hash(part)
            os.replace(part, self.folder / name)
        except OSError as error:
            raise _refused(self.folder, f"{name} could not be written ({error.strerror})") from None
        finally:
            part.unlink(missing_ok=True)

    def write_text(self, name: str, chunks: Iterable[str]) -> None:
        """Write `name` from pieces of text."""
        self.write(name, lambda file: file.writelines(chunk.encode() for chunk in chunks))

    def remove(self, name: str) -> None:
        """Remove an artefact of an earlier run that this run does not make."""
        (self.folder / name).unlink(missing_ok=True)


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
