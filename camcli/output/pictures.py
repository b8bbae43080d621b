"""Pictures as files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, BinaryIO

from camcli.interrupts import removed_if_ended
from camcli.quantities import MM_PER_INCH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camcli.plots.picture import Picture
    from camcli.scene.schema import Plot

CAPTION = {"png": "Description", "pdf": "Subject", "svg": "Description"}  # its key in a file
METADATA: dict[str, dict[str, Any]] = {  # None: what matplotlib writes by itself is left out
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}
# Two thirds of the time of the library's own choice, 6, for 3 % more bytes.
SAVING: dict[str, dict[str, Any]] = {"png": {"pil_kwargs": {"compress_level": 3}}}


def write_picture(
    picture: Picture, file: BinaryIO, kind: str = "png", form: Plot | None = None
) -> Sequence[str]:
    """Write a PNG, PDF or SVG: same picture, same bytes on one installation.

    Its caption goes into the file too. Nothing of the program, the time or the place is put into
    it, and no setting of the user changes it but those of `form`.

    form: the section `plot` of a scene. Returns the names of the panels for which the page has no
    room.
    """
    from camcli.plots.style import look

    figure = picture.figure(form)
    metadata = dict(METADATA[kind])
    if figure.caption:
        metadata[CAPTION[kind]] = figure.caption
    saving = SAVING.get(kind, {})
    with look(form.font, form.style) if form else look():
        figure.savefig(file, format=kind, metadata=metadata, **saving)
    return figure.left_out


def write_pages(
    pictures: Sequence[Picture], file: BinaryIO, form: Plot, margin: float = 0.0
) -> None:
    """Write pictures as the pages of one PDF, each as `write_picture` writes one.

    margin: blank around each, mm.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    from camcli.plots.style import look

    with look(form.font, form.style), PdfPages(file, metadata=METADATA["pdf"]) as pdf:
        for picture in pictures:
            figure = picture.figure(form)
            pdf.savefig(figure, bbox_inches=figure.bbox_inches.padded(margin / MM_PER_INCH))


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
    """Write the frames as a GIF that repeats, or as an MP4; kind: `gif` or `mp4`.

    frames: the same figure again and again, drawn anew each time it is given.
    """
    if kind == "gif":
        _write_gif(frames, file)
        return
    from matplotlib.animation import FFMpegWriter

    from camcli.plots.simulate import FRAMES_PER_S

    writer = FFMpegWriter(fps=FRAMES_PER_S)
    first = next(frames)
    with unfinished_folder() as folder:
        path = folder / f"frames.{kind}"
        with writer.saving(first, path, first.dpi):
            writer.grab_frame()
            for _ in frames:  # each draws the next state on the figure that is grabbed
                writer.grab_frame()
        file.write(path.read_bytes())


def _write_gif(frames: Iterator[Figure], file: BinaryIO) -> None:
    """Write a GIF that repeats, with FRAMES_PER_S frames a second on average.

    A GIF counts hundredths of a second: a frame lasts 30 or 40 ms. If each of 30 frames a second
    lasted 30 ms, the motion would be a tenth faster than the picture says.
    """
    from PIL import Image

    from camcli.plots.simulate import FRAMES_PER_S

    images = []
    for figure in frames:
        canvas: Any = figure.canvas
        canvas.draw()
        size = canvas.get_width_height()
        pixels = canvas.buffer_rgba()
        image = Image.frombuffer("RGBA", size, pixels, "raw", "RGBA", 0, 1)  # 0, 1: top row first
        images.append(image.convert("RGB"))
    changes = [round(100 * k / FRAMES_PER_S) for k in range(len(images) + 1)]  # in 1/100 s
    durations_ms = [10 * (end - start) for start, end in pairwise(changes)]
    images[0].save(
        file, format="gif", save_all=True, append_images=images[1:], duration=durations_ms, loop=0
    )


@contextmanager
def unfinished_folder() -> Iterator[Path]:
    """A temporary folder, which goes however the block ends, and where the process is cut too."""
    with TemporaryDirectory() as folder, removed_if_ended(folder):
        yield Path(folder)
