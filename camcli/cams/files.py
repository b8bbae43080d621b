"""Text from a file that a user names: its kind, size and encoding are checked first."""

import os
import re
import stat
from pathlib import Path

from camcli.errors import Fault, SceneError

_CONTROL = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


def refused(where: str, key: str, found: str, expected: str, cure: str) -> SceneError:
    """One fault of a file that the scene names; `key` is the key of the section it concerns."""
    return SceneError(Fault(where, key, found, expected, cure))


def read_bytes(path: Path, name: str, most: int, expected: str, cure: str, key: str = "") -> bytes:
    """The file's bytes; raises SceneError where it is missing, no file, or larger than `most`.

    name: what messages call it. most: bytes. `expected` says what it should be, `cure` what to do
    about a name that is no file's, `key` is the key of the scene's section that names it.
    """
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            raise refused(name, key, "found a folder", expected, "name the file in it")
        if not stat.S_ISREG(status.st_mode):
            found = "found a pipe, socket or device"
            raise refused(name, key, found, expected, "save it as a file first")
        data = _first_bytes(path, status.st_size, most + 1)
    except SceneError:  # one of the two above, which is a ValueError too
        raise
    except FileNotFoundError:
        raise refused(name, key, "no such file", expected, cure) from None
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        found = f"cannot be read: {reason}"
        raise refused(name, key, found, expected, "check the name and the permissions") from None
    if len(data) > most:
        size = f"{most // 1000} kB" if most < 10**6 else f"{most // 10**6} MB"
        expected = f"expected at most {size}"
        raise refused(name, key, f"found more than {size}", expected, "is this the right file?")
    return data


def _first_bytes(path: Path, size: int, most: int) -> bytes:
    """The first `most` bytes of a file that had `size` bytes a moment ago.

    It never waits, should the file have become a pipe since then.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with open(os.open(path, flags), "rb") as file:
        data = file.read(min(most, size + 1))
        if size < len(data) < most:  # it has grown
            data += file.read(most - len(data))
    return data


def decoded(data: bytes, name: str, key: str = "", table: bool = False) -> str:
    """The text of UTF-8 with or without a byte order mark; raises SceneError with the place.

    table: UTF-16 with its byte order mark and the letters of Windows are read too, as spreadsheets
    and measuring machines write them.
    """
    is_utf16 = data[:2] in (b"\xff\xfe", b"\xfe\xff")  # by its byte order mark
    try:
        text = data.decode("utf-16" if is_utf16 and table else "utf-8-sig")
        control = _CONTROL.search(text)
        if control is None:
            return text
        before = text[: control.start()]
        found = f"found the control character 0x{ord(control[0]):02x}"
        expected = "expected text"
        cure = "is this a binary file?"
    except UnicodeDecodeError as error:
        windows = data.decode("cp1252", "replace")
        if table and not is_utf16 and _CONTROL.search(windows) is None:
            return windows
        before = "" if is_utf16 else data[: error.start].decode("utf-8-sig")
        found = f"found byte 0x{data[error.start]:02x}"
        expected = "expected UTF-8 text"
        cure = "save the file as UTF-8" if 0 not in data else "is this a binary file?"
        if is_utf16:
            found = "found UTF-16 text"
            cure = "save the file as UTF-8"
    line = before.count("\n") + 1
    column = len(before) - before.rfind("\n")
    raise refused(f"{name}:{line}:{column}", key, found, expected, cure)
