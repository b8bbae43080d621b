"""Pictures as files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, BinaryIO

if TYPE_CHECKING:
    from camcli.plots.picture import Picture
    from camcli.scene.schema import Plot

SAID: dict[str, dict[str, Any]] = {  # by itself matplotlib writes its version, and the time
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}


def write_picture(
    picture: Picture, file: BinaryIO, kind: str = "png", form: Plot | None = None
) -> None:
    """Write a PNG, PDF or SVG: same picture, same bytes on one installation.

    Nothing of the program, the time or the place is put into it, and no setting of the user
    changes it but those of `form`.
    """
    from camcli.plots.style import look

    figure = picture.figure(form)
    with look(*((form.font, form.style) if form else ())):
        figure.savefig(file, format=kind, metadata=SAID[kind])
