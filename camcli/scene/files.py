"""Scene text from disk: size and kind of the file are checked before anything is read."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from camcli.cams.lift_text import never_waiting
from camcli.scene.places import Finding, Mark, Source

MAX_BYTES = 256 * 1024  # a scene is a few kB


def default_scene_path() -> Path:
    """The chapter's scene: inside the package (wheel) or beside it (checkout)."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "configs" / "chapter.yaml"
    return inside if inside.is_file() else package.parent / "configs" / "chapter.yaml"


def read_text(path: Path, source: Source) -> str | Finding:
    """Text of a scene file (UTF-8, byte order mark allowed), or why it cannot be read."""
    try:
        finding = _refuse(os.stat(path), source)
        if finding:
            return finding
        with open(path, "rb", opener=never_waiting) as file:
            finding = _refuse(os.fstat(file.fileno()), source)  # it may be another file by now
            data = b"" if finding else file.read(MAX_BYTES + 1)
        if finding:
            return finding
    except (OSError, ValueError) as error:
        return _unreadable(error, source)
    if len(data) > MAX_BYTES:
        return _too_large(f"more than {MAX_BYTES} bytes", source)
    return _decode(data, source)


def _refuse(status: os.stat_result, source: Source) -> Finding | None:
    mark = Mark(source)
    if stat.S_ISDIR(status.st_mode):
        return Finding(mark, (), "found a folder", "expected a YAML file", "name the file in it")
    if not stat.S_ISREG(status.st_mode):
        found = "found a pipe, socket or device"
        return Finding(mark, (), found, "expected a YAML file", "save the scene as a file first")
    if status.st_size > MAX_BYTES:
        return _too_large(f"{status.st_size} bytes", source)
    return None


def _too_large(size: str, source: Source) -> Finding:
    expected = f"expected a scene of at most {MAX_BYTES // 1024} kB"
    return Finding(Mark(source), (), f"found {size}", expected, "is this the right file?")


def _unreadable(error: OSError | ValueError, source: Source) -> Finding:
    if isinstance(error, FileNotFoundError):
        cure = "check the name, or leave out -c for the chapter's scene"
        return Finding(Mark(source), (), "no such file", "expected a YAML file", cure)
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    cure = "check the name and the permissions"
    return Finding(Mark(source), (), f"cannot be read: {reason}", "expected a YAML file", cure)


def _decode(data: bytes, source: Source) -> str | Finding:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        mark = Mark(source, before.count(b"\n") + 1, error.start - before.rfind(b"\n"))
        utf16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")
        found = "found UTF-16 text" if utf16 else f"found byte 0x{data[error.start]:02x}"
        cure = "save the file as UTF-8" if utf16 or 0 not in data else "is this a binary file?"
        return Finding(mark, (), found, "expected UTF-8 text", cure)
