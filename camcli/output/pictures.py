"""Pictures as files."""

from __future__ import annotations

from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from camcli.plots.picture import Picture


def write_png(picture: Picture, file: BinaryIO) -> None:
    """Write a PNG: same picture, same bytes on one installation.

    Nothing of the program, the time or the place is put into it, and no setting of the user
    changes it.
    """
    from camcli.plots.style import look

    figure = picture.figure()
    with look():
        figure.savefig(file, format="png", metadata={"Software": None})
