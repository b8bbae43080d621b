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

    `expected` says what it should be, `cure` what to do about a name that is no file's, `key` is
    the key of the scene's section that names it.
    """

    problem = ("", "")
    try:
        status = os.stat(path)
        mode = status.st_mode
        if stat.S_ISDIR(mode):
            problem = "found a folder", "name the file in it"
        elif not stat.S_ISREG(mode):
            problem = "found a pipe, socket or device", "save it as a file first"
        else:  # without waiting, should the file have become a pipe since it was looked at
            flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
            with open(os.open(path, flags), "rb") as file:
                data = file.read(min(most, status.st_size) + 1)
                if status.st_size < len(data) <= most:  # it has grown
                    data += file.read(most + 1 - len(data))
    except FileNotFoundError:
        problem = "no such file", cure
    except (OSError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or str(error)).lower()
        problem = f"cannot be read: {reason}", "check the name and the permissions"
    if problem[0]:
        raise refused(name, key, problem[0], expected, problem[1]) from None
    if len(data) > most:
        size = f"{most // 1000} kB" if most < 10**6 else f"{most // 10**6} MB"
        expected = f"expected at most {size}"
        raise refused(name, key, f"found more than {size}", expected, "is this the right file?")
    return data


def decoded(data: bytes, name: str, key: str = "", table: bool = False) -> str:
    """The text of UTF-8 with or without a byte order mark; raises SceneError with the place.

    table: UTF-16 with its byte order mark and the letters of Windows are read too, as spreadsheets
    and measuring machines write them.
    """
    marked = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        text = data.decode("utf-16" if marked and table else "utf-8-sig")
        odd = _CONTROL.search(text)
        if odd is None:
            return text
        before = text[: odd.start()]
        found = f"found the control character 0x{ord(odd[0]):02x}"
        expected = "expected text"
        cure = "is this a binary file?"
    except UnicodeDecodeError as error:
        letters = data.decode("cp1252", "replace")
        if table and not marked and _CONTROL.search(letters) is None:
            return letters
        before = "" if marked else data[: error.start].decode("utf-8-sig")
        found = f"found byte 0x{data[error.start]:02x}"
        expected = "expected UTF-8 text"
        cure = "save the file as UTF-8" if 0 not in data else "is this a binary file?"
        if marked:
            found = "found UTF-16 text"
            cure = "save the file as UTF-8"
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    raise refused(f"{name}:{line}:{column}", key, found, expected, cure)
