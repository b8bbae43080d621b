"""Another process that draws a run's pictures while this one computes, and writes its tables.

Importing what draws takes as long as all else that is imported, and a picture as long as a sweep.
A picture is the same whoever draws it.
"""

from __future__ import annotations

import gc
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from camcli.parallel.helpers import Helper, HelperFailedError

if TYPE_CHECKING:
    from camcli.plots.picture import Picture
    from camcli.scene.schema import Plot

MOST_SENT = 1 << 26  # bytes of a result: a larger one is drawn where it is
OBJECTS = 300_000  # until Python looks for garbage: an import makes many objects, and none of it


class Drawing(NamedTuple):
    """A picture to be drawn: by what, as what kind of file (png, pdf or svg), in which form."""

    picture: Callable[[], Picture]
    kind: str
    form: Plot


class Drawn(NamedTuple):
    """The bytes of a picture's file, and the panels for which its page has no room."""

    content: bytes
    left_out: Sequence[str]


class DrawingProcess:
    """A process that imports what draws at once, and draws what `begin` gives it.

    Where it cannot be started, or fails in anything, `next_drawn` gives None: whoever asks draws
    the picture itself then, and meets the error if there is one.
    """

    def __init__(self, modules: Sequence[str]):
        """modules: what will be needed to draw."""
        self._helper: Helper | None = None
        self._ready = False
        self._drawings: deque[Drawing] = deque()  # that it was not asked for yet
        with suppress(OSError, TypeError, HelperFailedError):
            # an OSError where there may be no more processes, a TypeError where no Python is known
            self._helper = Helper()
            self._helper.ask(prepare, modules)

    def begin(self, drawings: Sequence[Drawing]) -> None:
        """Draw these pictures, one after the other; returns when the first one has begun."""
        self._drawings.extend(drawings)
        self._ask()

    def next_drawn(self) -> Drawn | None:
        """The next of the pictures, as soon as it is drawn; None: it was not."""
        if self._helper is None:
            return None
        try:
            drawn = self._helper.answer()
        except HelperFailedError:
            self.end()
            return None
        self._ask()
        return drawn

    def end(self) -> None:
        """End the process, whatever it does."""
        if self._helper is not None:
            self._helper.end()
            self._helper = None

    def _ask(self) -> None:
        """Ask for the next picture, which is sent to a process that waits for it."""
        if self._helper is None or not self._drawings:
            return
        try:
            if not self._ready:
                self._helper.answer()  # that it has started
                self._helper.answer()  # that it has imported what draws
                self._ready = True
            self._helper.ask(draw, self._drawings.popleft())
        except HelperFailedError:
            self.end()


def prepare(modules: Sequence[str]) -> None:
    """Import what will be needed to draw; in the process that draws."""
    gc.set_threshold(OBJECTS)
    for module in modules:
        import_what_draws(module)


def draw(drawing: Drawing) -> Drawn:
    """Draw a picture; in the process that draws."""
    from io import BytesIO

    from camcli.output.pictures import write_picture

    file = BytesIO()
    left_out = write_picture(drawing.picture(), file, drawing.kind, drawing.form)
    return Drawn(file.getvalue(), left_out)


def import_what_draws(module: str) -> None:
    """Import a module that draws; where that fails, it fails again for whoever needs the module.

    matplotlib writes a list of properties into the documentation of each of its classes while they
    are imported. That takes a fifth of the time, and a command shows none of it.
    """
    with suppress(Exception):
        from matplotlib import artist

        list_of_properties = artist.kwdoc
        artist.kwdoc = lambda artist: ""
        try:
            import_module(module)
        finally:
            artist.kwdoc = list_of_properties
