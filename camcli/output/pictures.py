"""Pictures as files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, BinaryIO

from camcli.interrupts import removed_if_ended

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camcli.plots.picture import Picture
    from camcli.scene.schema import Plot

CAPTION = {"png": "Description", "pdf": "Subject", "svg": "Description"}  # its key in a file
SAID: dict[str, dict[str, Any]] = {  # by itself matplotlib writes its version, and the time
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}
# Two thirds of the time of the library's own choice, 6, for 3 % more bytes.
MORE: dict[str, dict[str, Any]] = {"png": {"pil_kwargs": {"compress_level": 3}}}


def write_picture(
    picture: Picture,
    file: BinaryIO,
    kind: str = "png",
    form: Plot | None = None,
    margin: float = 0.0,
) -> Sequence[str]:
    """Write a PNG, PDF or SVG: same picture, same bytes on one installation.

    Returns the names of the panels that the page has no room for.

    margin: blank around it, mm.

    Its caption goes into the file too. Nothing of the program, the time or the place is put into
    it, and no setting of the user changes it but those of `form`.
    """
    from camcli.plots.style import look

    figure = picture.figure(form)
    blank = margin / 25.4
    page = figure.bbox_inches.padded(blank) if blank else None
    said = dict(SAID[kind])
    if figure.caption:
        said[CAPTION[kind]] = figure.caption
    with look(*((form.font, form.style) if form else ())):
        figure.savefig(file, format=kind, metadata=said, bbox_inches=page, **MORE.get(kind, {}))
    return figure.left_out


def write_pages(
    pictures: Sequence[Picture], file: BinaryIO, form: Plot, margin: float = 0.0
) -> None:
    """Write pictures as the pages of one PDF, as `write_picture` writes one."""
    from matplotlib.backends.backend_pdf import PdfPages

    from camcli.plots.style import look

    with look(form.font, form.style), PdfPages(file, metadata=SAID["pdf"]) as pdf:
        for picture in pictures:
            figure = picture.figure(form)
            pdf.savefig(figure, bbox_inches=figure.bbox_inches.padded(margin / 25.4))


def caption_in(path: Path) -> str:
    """The caption that a PNG holds; nothing of a file that holds none or cannot be read."""
    from PIL import Image

    try:
        with Image.open(path) as image:
            return str(image.info.get(CAPTION["png"], ""))
    except (OSError, ValueError, SyntaxError):
        return ""


def animation_kinds() -> tuple[str, ...]:
    """What can be written here: gif, and mp4 where ffmpeg is found."""
    from matplotlib.animation import FFMpegWriter

    return ("gif", "mp4") if FFMpegWriter.isAvailable() else ("gif",)


def write_animation(frames: Iterator[Figure], file: BinaryIO, kind: str) -> None:
    """Write the frames as a GIF that repeats, or as an MP4."""
    if kind == "gif":
        _write_gif(frames, file)
        return
    from matplotlib.animation import FFMpegWriter

    from camcli.plots.simulate import FRAMES_PER_S

    writer = FFMpegWriter(fps=FRAMES_PER_S)
    first = next(frames)
    with unfinished_folder() as place:
        path = place / f"frames.{kind}"
        with writer.saving(first, path, first.dpi):
            writer.grab_frame()
            for _ in frames:
                writer.grab_frame()
        file.write(path.read_bytes())


def _write_gif(frames: Iterator[Figure], file: BinaryIO) -> None:
    """Write a GIF that repeats: its frames last 30 or 40 ms, and as many a second as are meant.

    A GIF counts hundredths of a second. With 30 ms for each of 30 frames a second the motion would
    be a tenth faster than the picture says.
    """
    from PIL import Image

    from camcli.plots.simulate import FRAMES_PER_S

    images = []
    for figure in frames:
        canvas: Any = figure.canvas
        canvas.draw()
        size = canvas.get_width_height()
        picture = Image.frombuffer("RGBA", size, canvas.buffer_rgba(), "raw", "RGBA", 0, 1)
        images.append(picture.convert("RGB"))
    ends = [round(100 * k / FRAMES_PER_S) for k in range(len(images) + 1)]
    lasting = [10 * (end - start) for start, end in pairwise(ends)]  # ms
    images[0].save(
        file, format="gif", save_all=True, append_images=images[1:], duration=lasting, loop=0
    )


@contextmanager
def unfinished_folder() -> Iterator[Path]:
    """A temporary folder, which goes however the block ends, and where the process is cut too."""
    with TemporaryDirectory() as place, removed_if_ended(place):
        yield Path(place)
