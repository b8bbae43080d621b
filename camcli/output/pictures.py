"""Figures as files."""

from __future__ import annotations

from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_png(figure: Figure, file: BinaryIO) -> None:
    """Write a PNG at the resolution of the figure: same figure, same bytes on one installation.

    Nothing of the program, the time or the place is put into it, and no setting of the user
    changes it.
    """
    from camcli.plots.style import look

    with look():
        figure.savefig(file, format="png", dpi=figure.dpi, metadata={"Software": None})
