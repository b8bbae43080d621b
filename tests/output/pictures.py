"""Figures as bytes and as pixels."""

from io import BytesIO

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

from camcli.output.pictures import write_png
from camcli.plots import style


def png(figure):
    buffer = BytesIO()
    write_png(figure, buffer)
    return buffer.getvalue()


def pixels(figure):
    """(row, column, rgb) of a figure, which has our width."""
    image = np.asarray(Image.open(BytesIO(png(figure))).convert("RGB"))
    assert image.shape[1] == style.WIDTH
    return image


def count(image, colour):
    """How many pixels have a colour, given by name or as three numbers to 255."""
    if isinstance(colour, str):
        colour = tuple(round(255 * part) for part in to_rgb(colour))
    return int((image == colour).all(axis=2).sum())
