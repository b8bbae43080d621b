"""Faults a user can meet, and how the kernel may end.

This module is the bottom of the package: it imports nothing of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum


class Status(IntEnum):
    """How the kernel ended: data, not an exception, so the row is kept.

    `camcli.words.statuses` has the cause of each and what to do about it.
    """

    OK = 0
    LOG_FULL = 1  # the event log was too small: the caller makes it larger and resumes
    IMPACT_BUDGET = 2  # as many impacts in one turn as run.impact_budget
    NO_RETURN = 3  # the follower left the cam and nothing brings it back
    UNRESOLVED = 4  # a contact is closer to grazing than double precision can tell
    PAUSED = 5  # the work was interrupted: the caller resumes
    WORK_BUDGET = 6  # of a whole analysis was used up; the kernel does not know of it
    FAULT = 7  # an unforeseen exception cost one piece of a run; the kernel does not know of it

    @property
    def text(self) -> str:
        """The status as it stands in a `status` column."""
        return self.name.lower().replace("_", "-")


def worst_status(codes: Iterable[int]) -> str:
    """The status of a whole run, that of its worst row, as a `status` column names it."""
    return Status(max(codes, default=Status.OK)).text


@dataclass(frozen=True)
class Fault:
    """One fault of the input: where it stands, its path, what was found and what to do.

    `where` is `file:line:column`, `--set` or an option's name; `path` the dotted scene path.
    Its text is `where: path: found, expected, cure`, without what is empty.

    Examples
    --------
    >>> from camcli import Fault
    >>> print(Fault("scene.yaml:3:8", "run.rpm", "found -7", "expected a speed", "change it"))
    scene.yaml:3:8: run.rpm: found -7, expected a speed, change it
    """

    where: str
    path: str
    found: str
    expected: str
    cure: str

    def __str__(self) -> str:
        parts = [part for part in (self.found, self.expected, self.cure) if part]
        place = [part for part in (self.where, self.path) if part]
        return printable(": ".join([*place, ", ".join(parts)]))


def printable(text: str) -> str:
    """One line of text that no terminal takes for a command."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shown(text: str, limit: int = 60) -> str:
    """Text of the user, cut to `limit` characters and safe to print on any terminal."""
    return printable(text if len(text) <= limit else text[: limit - 3] + "...")


class CamError(Exception):
    """Base of every error this package raises on purpose."""


class SceneError(CamError, ValueError):
    """The input cannot be used; carries every fault found (exit code 2).

    A ValueError, so that a validator may raise it: validation then says where the faults stand.

    Examples
    --------
    >>> import camcli
    >>> try:
    ...     camcli.load_scene(None, {"run.rpm": -700, "follower.mass": 0})
    ... except camcli.SceneError as error:
    ...     sorted(fault.path for fault in error.faults)
    ['follower.mass', 'run.rpm']
    """

    def __init__(self, *faults: Fault):
        self.faults = faults
        super().__init__("\n".join(str(fault) for fault in faults))


class NoMachineError(CamError):
    """At these values of the numbers that vary there is no machine; the text says why."""


def is_given(value: object) -> bool:
    """Whether an option or an argument was given: it is neither None nor a flag left out.

    A number 0, which equals False, was given.
    """
    return value is not None and value is not False


def plural(count: int, singular: str) -> str:
    """1 speed, 2 speeds, 2 boxes: a count and what is counted."""
    if count == 1:
        return f"1 {singular}"
    ending = "es" if singular.endswith("x") else "s"
    return f"{count} {singular}{ending}"


def is_or_are(count: int) -> str:
    """The verb that goes with a count: 1 speed is, 2 speeds are."""
    return "is" if count == 1 else "are"
