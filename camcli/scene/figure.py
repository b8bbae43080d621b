"""The section that makes a scene a figure of `cam figures`."""

from __future__ import annotations

import shlex
from typing import Annotated

from pydantic import AfterValidator, Field

from camcli.scene.fields import Section, refused


def _splits(text: str) -> str:
    """The text, or ValueError where a shell could not split it into words."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        found = f"found {text!r}: {str(error).lower()}"
        raise refused(found, "expected words as in a shell", "close the quotes") from None
    if not words or "--" in words:
        found = f"found '--' in {text!r}" if words else "found no command"
        raise refused(found, "expected a command of cam and its options", "name one, without '--'")
    return text


class Figure(Section):
    """A figure: what it shows, and the command that draws it from this scene."""

    title: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        description="what the figure shows, in one line"
    )
    command: Annotated[str, Field(max_length=1000), AfterValidator(_splits)] = Field(
        description="command and options that draw it, as after `cam`; -c and -o are added"
    )
    shows: Annotated[str, Field(max_length=2000)] = Field(
        "",
        description="caption, also for who cannot see it; {NAME|.2f} is a number of the run, by "
        "its name in the reference",
    )
    printed: dict[str, float] = Field(
        {}, description="numbers of the run, by their names in the reference, as printed elsewhere"
    )

    @property
    def words(self) -> list[str]:
        """The command and its options."""
        return shlex.split(self.command)
