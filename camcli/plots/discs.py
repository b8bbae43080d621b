"""Discs of one colour as the pixels of a panel, each at its exact place."""

from __future__ import annotations

from math import ceil, floor, pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.image import AxesImage
from matplotlib.transforms import IdentityTransform

from camcli.quantities import MM_PER_INCH

LEAST, USUAL = 0.18, 0.4  # mm, the diameter of a disc at least, and where it has room enough
ALONE = 0.3, 0.45  # mm, that of discs so far apart that they make no line, at least and at most:
WHITE = 0.4  # of the way from speed to speed, between these, so that they make no broken line
JOINED = 0.45  # mm, from speed to speed at most, where discs make a line:
MEETING, MEET = 1.5, 0.54  # of that way, and mm, the diameter of these: the smaller of both
COVERED = 0.35  # of the paper about their speed, by discs: where there are more, they are smaller
MARGIN = 16.0  # mm, about the points of a speed, which others seldom fill
LINES = 16  # points of a speed that may be lines, also where speeds are closer than a pixel
DENSE = 6.0  # points of a speed per mm, beside others alike: discs would be an area
HALF_DENSE, AREA = 3.0, 0.6  # per mm: discs meet from here on, up to so many mm between speeds
BESIDE = 1.5  # ways from speed to speed, at most, to the next one alike
CLOSEST = 0.085  # mm, a pixel: closer speeds are on paper as one,
PIXEL_PART = 0.3  # which is full of their points where they are closer than this part of it
STRIP = CLOSEST, 0.2  # mm, the paper about a speed is so wide, at least and at most between others


def _fitting(crowd: Any, step: Any, room: Any, high: Any) -> Any:
    """The diameter (mm) of so many discs that they cover COVERED of their paper."""
    least, most = STRIP
    wide = np.maximum(step, np.clip(room, least, most))
    return np.sqrt(4.0 / pi * COVERED * wide * (high + MARGIN) / np.maximum(crowd, 1))


def have_no_room(crowd: Any, step: Any, room: Any, high: Any) -> Any:
    """Whether the points of speeds are too many for discs, see `diameters`."""
    many = (_fitting(crowd, step, room, high) < LEAST) & (MEETING * step < LEAST)
    upon_others = (crowd > LINES) & (step < PIXEL_PART * CLOSEST)
    return many | upon_others | ((crowd > DENSE * high) & (room <= BESIDE * step))


def diameters(crowd: Any, step: Any, room: Any, way: Any, high: Any) -> Any:
    """The diameters (mm) of discs: where there are many, smaller ones.

    crowd: how many share the paper about their speed, which is `room` wide and `high`, mm; step:
    mm to the next speed; way: mm, the widest from speed to speed about there. Between speeds so
    close that discs meet there is no white; between others it is too wide for a broken line.
    """
    meeting = np.minimum(MEETING * way, MEET)
    joined = way <= np.where(crowd > HALF_DENSE * high, AREA, JOINED)
    apart = np.clip((1.0 - WHITE) * way, *ALONE)
    most = np.where(joined, np.maximum(USUAL, meeting), apart)
    least = np.where(joined, np.maximum(LEAST, meeting), LEAST)
    return np.clip(_fitting(crowd, step, room, high), least, most)


class Discs(AxesImage):
    """Discs, of which the most opaque one over a pixel is seen there."""

    def __init__(
        self,
        axes: Axes,
        colour: str,
        places: np.ndarray,
        opacity: np.ndarray,
        shares: np.ndarray,
        crowd: np.ndarray,
        larger: float = 1.0,
    ) -> None:
        """places: (discs, 2), on the axes; opacity: of each, 0 to 1; larger: times as usual.

        crowd, shares: (discs,) and (4, discs), see `diameters`: how many; step, room, way and
        height as shares of the panel's sides.
        """
        low, high = axes.get_xlim()
        super().__init__(axes, extent=(low, high, *axes.get_ylim()), origin="lower", zorder=2)
        self.set_data(np.zeros((1, 1)))  # matplotlib draws no image without data
        self.places = places
        self.opacity = opacity
        self._shares = shares
        self._crowd = crowd
        self.larger = larger
        self.colour = colour

    def make_image(
        self, renderer: Any, magnification: float = 1.0, unsampled: bool = False
    ) -> tuple[Any, float, float, Any]:
        """The pixels of the panel, see matplotlib: rows from the bottom, and their left bottom."""
        axes = self.axes
        box = axes.bbox
        left, right = floor(box.x0 * magnification), ceil(box.x1 * magnification)
        bottom, top = floor(box.y0 * magnification), ceil(box.y1 * magnification)
        figure: Any = axes.get_figure(root=True)
        pixels_per_mm = figure.dpi * magnification / MM_PER_INCH
        wide, high = (length * magnification / pixels_per_mm for length in (box.width, box.height))

        sides = self._shares * [[wide], [wide], [wide], [high]]
        diameter = diameters(self._crowd, *sides) * self.larger
        radius = 0.5 * diameter * pixels_per_mm
        at = axes.transData.transform(self.places) * magnification
        left, right = _with_discs(at[:, 0], radius, left, right)
        bottom, top = _with_discs(at[:, 1], radius, bottom, top)
        opacity = _covered(at - (left, bottom), radius, self.opacity, (right - left, top - bottom))
        pixels = np.empty((*opacity.shape, 4), dtype=np.uint8)
        for channel, part in enumerate(to_rgb(self.colour)):
            pixels[..., channel] = round(255.0 * part)
        pixels[..., 3] = np.rint(255.0 * opacity)
        return pixels, left / magnification, bottom / magnification, IdentityTransform()


def _with_discs(at: np.ndarray, radius: np.ndarray, low: int, high: int) -> tuple[int, int]:
    """The part of the pixels low..high along an axis that any discs reach, one pixel at least."""
    reach = ceil(radius.max()) + 1
    first = min(max(floor(at.min()) - reach, low), high - 1)
    last = max(min(ceil(at.max()) + reach, high), first + 1)
    return first, last


def _covered(
    at: np.ndarray, radius: np.ndarray, opacity: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """(rows, columns): opacity of every pixel, of which a disc's edge covers a part.

    at: (discs, 2) in pixels from the left and from below; size: columns and rows.
    """
    columns, rows = size
    reach = int(np.ceil(radius.max() + 0.5))  # pixels, beside that of the middle of the largest
    # with an edge all around, into which discs reach that lie at the panel's
    edged = columns + 2 * reach
    covered = np.zeros((rows + 2 * reach) * edged, dtype=np.float32)
    inside = ((at >= 0.0) & (at <= size)).all(axis=1)
    x, y = np.minimum(at[inside], np.nextafter(size, 0.0)).T
    radius, opacity = radius[inside], opacity[inside].astype(np.float32)
    column, row = x.astype(int), y.astype(int)
    x, y = (x - column).astype(np.float32), (y - row).astype(np.float32)
    pixel = (row + reach) * edged + column + reach
    rim = (radius + 0.5).astype(np.float32)
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            share = rim - np.hypot(right + 0.5 - x, down + 0.5 - y)
            some = share > 0.0
            seen = np.minimum(share[some], 1.0) * opacity[some]
            np.maximum.at(covered, pixel[some] + (down * edged + right), seen)
    return covered.reshape(-1, edged)[reach : reach + rows, reach : reach + columns]
