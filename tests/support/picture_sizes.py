"""Pictures as bytes and as pixels; results made by hand."""

from io import BytesIO
from math import cos, pi, sin

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.simulate import Simulation
from camcli.analysis.speeds import Speed
from camcli.analysis.sweep import Sweep
from camcli.errors import Status
from camcli.output.pictures import write_picture
from camcli.plots.picture import TALLEST
from tests.analysis.test_detach import eccentric

RPM = 60.0  # a turn per second


def png(picture, kind="png", form=None):
    buffer = BytesIO()
    write_picture(picture, buffer, kind, form)
    return buffer.getvalue()


_last = [None, None]  # the last picture, and its figure


def figure_of(picture):
    """The figure of a picture, made once."""
    if _last[0] is not picture:
        _last[:] = picture, picture.figure()
    return _last[1]


def drawn(picture):
    """The figure, drawn."""
    figure = figure_of(picture)
    if figure.stale:
        figure.canvas.draw()
    return figure


def pixels(picture):
    """(row, column, rgb) of a picture."""
    return np.asarray(drawn(picture).canvas.buffer_rgba())[:, :, :3]


def count(image, colour):
    """How many pixels have a colour."""
    rgb = [round(255 * part) for part in to_rgb(colour)]
    return int(np.logical_and.reduce([image[:, :, k] == rgb[k] for k in range(3)]).sum())


def words(picture):
    """Every text of a picture that is not a number of an axis."""
    figure = figure_of(picture)
    texts = [text for axes in figure.axes for text in [*axes.texts, axes.title]]
    for axes in figure.axes:
        texts += axes.get_legend().get_texts() if axes.get_legend() else []
    return [text.get_text() for text in texts]


def tall(picture):
    """Height in mm; it is never above that of a page, and the layout finds room for all."""
    figure = drawn(picture)
    height = figure.get_figheight() * 25.4
    assert height <= TALLEST + 1e-9
    heads, *panels = figure.axes
    tops = [axes.get_tightbbox().y1 for axes in panels]
    assert max(tops) <= heads.bbox.y0 + 8
    return height


def overlaps(texts):
    """Texts that run into one another."""
    boxes = [text.get_window_extent() for text in texts if text.get_text()]
    return [a for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]


def panel(low=0.0, high=1.0, wide=1140, tall=300):
    """Axes of a size in pixels over a range."""
    figure = Figure(figsize=(20.0, 10.0), dpi=300)
    FigureCanvasAgg(figure)  # has a renderer; without one each extent of a text makes its own
    axes = figure.add_axes((0.1, 0.1, wide / 6000, tall / 3000))
    axes.set_xlim(low, high)
    return axes


def speed(rpm, phases=(), q=(), status=Status.OK):
    phases = None if phases is None else (range(len(phases)), phases, phases, phases)
    strobe = None if q is None else (range(len(q)), q, q, q, q)
    return Speed(rpm, rpm, "aperiodic", 0, status, phases, strobe, Cost())


def label_of(text):
    """A label with its values, as an analysis gives it."""
    return Label.parse(text) if text.startswith("P(") else text


def sweep_of(*speeds):
    return Sweep(list(speeds), "fixed", Cost())


EVEN = eccentric("0.09", "0.02")  # the cam of `bounce`
SAMPLES = 64


def bounce(turns=2, label="P(1;inf)", status=Status.OK, rows=None):
    """A follower that rests for half a turn, then makes one hop: made up."""
    trajectory, events = [], []
    for k in range(turns):
        for j in range(SAMPLES):
            x = j / SAMPLES - 0.5
            gap, u, state = (
                (x * (0.5 - x), 0.5 - 2.0 * x, "flight") if 2 * j >= SAMPLES else (0, 0, "sticking")
            )
            turned = 2.0 * pi * j / SAMPLES
            c, c_dot = 0.1 - 0.01 * cos(turned), 0.02 * pi * sin(turned)
            trajectory.append(
                (k + j / SAMPLES, 360.0 * j / SAMPLES, c + gap, c_dot + u, c, c_dot, state)
            )
        events += [
            (k + 0.0, k, 0.0, "impact", 0.09, -0.5, 0.4),
            (k + 0.1, k, 36.0, "chatter", 0.09, 0.0, 0.0),
            (k + 0.5, k, 180.0, "detachment", 0.11, 0.0, 0.0),
        ]
    trajectory = trajectory if rows is None else trajectory[:rows]
    return Simulation(RPM, trajectory, events, label, status, turns, [90.0, 180.0], Cost(), None)
