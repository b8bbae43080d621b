"""Versions of installed packages.

`importlib.metadata` takes 20 ms to import and to read ten of them. The folder that an installer
leaves of a package has its name and version in its own name (the standard for wheels asks for
that), so reading the names of folders is enough; what is not found so is left to the library.
"""

import os
import sys
from contextlib import suppress
from functools import cache

ENDING = ".dist-info"


def version(package: str) -> str:
    """The version of an installed package; raises PackageNotFoundError for another one."""
    number = _by_name().get(_plain(package))
    if number is None:
        from importlib.metadata import version as read

        return read(package)
    return number


@cache
def _by_name() -> dict[str, str]:
    """Versions by the plain names of packages: of two that are installed the first on the path."""
    versions: dict[str, str] = {}
    for folder in sys.path:
        with suppress(OSError):
            for entry in os.listdir(folder or "."):
                if entry.endswith(ENDING):
                    name, _, number = entry.removesuffix(ENDING).partition("-")
                    versions.setdefault(_plain(name), number)
    return versions


def _plain(name: str) -> str:
    """A name as all ways to write it have in common."""
    return name.lower().replace("-", "_").replace(".", "_")
