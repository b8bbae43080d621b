"""Pictures as bytes and as pixels; results made by hand."""

from io import BytesIO
from math import cos, pi, sin

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

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


def seen_texts(figure):
    """Every text of a page that is seen, with its box in dots: also numbers at ticks."""
    found = []
    for axes in figure.axes:
        legend = axes.get_legend()
        found += [axes._left_title, axes.title, axes._right_title, *axes.texts]
        found += legend.get_texts() if legend else []
        for one in (axes, *axes.child_axes):
            for axis, along in ((one.xaxis, one.get_xlim()), (one.yaxis, one.get_ylim())):
                if not (axes.axison and axis.get_visible()):
                    continue
                low, high = sorted(along)
                ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
                found += [axis.label, axis.offsetText]
                found += [text for tick in ticks for text in (tick.label1, tick.label2)]
    boxes = [(text.get_text(), text.get_window_extent()) for text in found if text.get_visible()]
    return [(text, _of_words(text, box)) for text, box in boxes if text.strip() and box.width > 0.0]


def _of_words(text, box):
    """The box of a text without the blank lines that it ends in."""
    lines = text.split("\n")
    blank = len(lines) - len(text.rstrip("\n").split("\n"))
    return Bbox.from_extents(box.x0, box.y0 + blank * box.height / len(lines), box.x1, box.y1)


def check_texts(figure):
    """No two texts of a page overlap by more than a quarter of a millimetre, none leaves it."""
    figure.draw_without_rendering()
    page, little = figure.bbox, 0.25 / 25.4 * figure.dpi
    shown = seen_texts(figure)
    assert len(shown) > 1
    for k, (text, box) in enumerate(shown):
        assert page.x0 - little <= box.x0 < box.x1 <= page.x1 + little, text
        assert page.y0 - little <= box.y0 < box.y1 <= page.y1 + little, text
        inner = box.padded(-little)
        if inner.width > 0.0 and inner.height > 0.0:
            for other, beside in shown[:k]:
                assert not inner.overlaps(beside), (text, other)


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
