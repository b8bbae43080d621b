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
from threading import Event, Thread
from typing import TYPE_CHECKING, NamedTuple
from warnings import catch_warnings

from camcli.parallel.helpers import Helper, HelperFailedError

if TYPE_CHECKING:
    from camcli.plots.picture import Picture
    from camcli.scene.schema import Plot

PATIENCE = 0.5  # s that tables wait for a process that is not ready
MOST_SENT = 1 << 26  # bytes of a result: a larger one is drawn where it is


class DrawingTask(NamedTuple):
    """A picture to be drawn: by what, as what kind of file (png, pdf or svg), in which form."""

    picture: Callable[[], Picture]
    kind: str
    form: Plot


class DrawnPicture(NamedTuple):
    """The bytes of a picture's file, and the panels for which its page has no room.

    warnings: what matplotlib told of it, in words.
    """

    content: bytes
    left_out: Sequence[str]
    warnings: Sequence[str]


class DrawingProcess:
    """A process that imports what draws at once, and draws what `begin` gives it.

    Where it cannot be started, or fails in anything, `next_drawn` gives None: whoever asks draws
    the picture itself then, and meets the error if there is one.
    """

    def __init__(self, modules: Sequence[str]):
        """modules: what will be needed to draw."""
        self._helper: Helper | None = None
        self._tasks: deque[DrawingTask] = deque()  # that the process was not asked for yet
        self._draws = False  # it was asked for a picture that nobody has taken yet
        self._ready = Event()  # it has imported what draws, or failed, or was not started
        with suppress(OSError, TypeError):
            # an OSError where there may be no more processes, a TypeError where no Python is known
            self._helper = Helper()
        if self._helper is None:
            self._ready.set()
        else:
            Thread(target=self._prepare, args=(self._helper, modules), daemon=True).start()

    def begin(self, tasks: Sequence[DrawingTask]) -> None:
        """Draw these pictures, one after the other; returns when the first one has begun.

        Where the process is not ready within PATIENCE the first one begins with `next_drawn`.
        """
        self._tasks.extend(tasks)
        if self._ready.wait(PATIENCE):
            self._ask()

    def next_drawn(self) -> DrawnPicture | None:
        """The next of the pictures, as soon as it is drawn; None: it was not."""
        self._ready.wait()
        if not self._draws:
            self._ask()
        if self._helper is None or not self._draws:
            return None
        try:
            drawn = self._helper.answer()
        except HelperFailedError:
            self.end()
            return None
        self._draws = False
        self._ask()
        return drawn

    def end(self) -> None:
        """End the process, whatever it does."""
        if self._helper is not None:
            self._helper.end()
            self._helper = None
            self._ready.wait()  # the thread that waited for it has ended, too

    def let_go(self) -> None:
        """End the process; one that has nothing to do ends by itself, and nobody waits for it."""
        if self._helper is not None and self._ready.is_set() and not self._draws:
            self._helper.let_go()
            self._helper = None
        self.end()

    def _prepare(self, helper: Helper, modules: Sequence[str]) -> None:
        """Have the process import what draws; where it fails in that, it fails in what follows."""
        try:
            helper.wait_until_ready()
            helper.call(prepare, modules, gc.get_threshold())
        except HelperFailedError:
            pass
        finally:
            self._ready.set()

    def _ask(self) -> None:
        """Send the next task to the process, which waits for it."""
        if self._helper is None or not self._tasks:
            return
        try:
            self._helper.ask(draw, self._tasks.popleft())
        except HelperFailedError:
            self.end()
        else:
            self._draws = True


def prepare(modules: Sequence[str], threshold: tuple[int, int, int]) -> None:
    """Import what will be needed to draw; in the process that draws.

    threshold: of Python's search for garbage, as in the process that asks: imports make none.
    """
    gc.set_threshold(*threshold)
    for module in modules:
        import_what_draws(module)


def draw(task: DrawingTask) -> DrawnPicture:
    """Draw a picture; in the process that draws."""
    from io import BytesIO

    from camcli.output.pictures import write_picture

    file = BytesIO()
    with catch_warnings(record=True) as told:
        left_out = write_picture(task.picture(), file, task.kind, task.form)
    return DrawnPicture(file.getvalue(), left_out, [str(one.message) for one in told])


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
