"""The kernel's entries, in plain Python or compiled, and tables in the form that they take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from typing import Any, TypeVar

from camcli.kernel.cam_table import Cam, Stretch
from camcli.kernel.cells import settle_cells
from camcli.kernel.certify import certify_orbit
from camcli.kernel.enclosed_landing import enclose_landing
from camcli.kernel.flow import Constants, Flow, fill_flows
from camcli.kernel.follow import follow_orbits
from camcli.kernel.loads import measure_loads
from camcli.kernel.orbit_loop import Log, Strobe
from camcli.kernel.shooting import correct_orbit
from camcli.kernel.variational import stretch_events

Row = TypeVar("Row")


@dataclass(frozen=True)
class Kernel:
    """The kernel's entries in one of their two forms, and tables in the form they take.

    In plain Python a column is a list of numbers (numpy's scalars are slow there) and a table a
    list of rows; compiled, both are arrays.
    """

    compiled: bool
    fill_flows: Callable
    follow_orbits: Callable
    correct_orbit: Callable
    certify_orbit: Callable
    settle_cells: Callable
    stretch_events: Callable
    measure_loads: Callable
    enclose_landing: Callable

    def numbers(self, values: Any, kind: type = float) -> Any:
        """The values as a column of floats, or of ints where `kind` is int.

        It may be `values` itself, so that what the kernel writes is seen there.
        """
        if not self.compiled:
            return values if isinstance(values, list) else [kind(value) for value in values]
        import numpy as np

        column = np.ascontiguousarray(values, np.float64 if kind is float else np.int64)
        return column if column.flags.writeable else column.copy()

    def zeros(self, count: int, kind: type = float) -> Any:
        """A column of zeros."""
        if not self.compiled:
            return [kind(0)] * count
        import numpy as np

        return np.zeros(count, np.float64 if kind is float else np.int64)

    def table(self, kind: type, rows: Sequence) -> Any:
        """A table of rows of `kind`, a class of float and int fields; it may be `rows` itself.

        What the kernel writes into a row is read as an attribute of table[n] in both forms.
        """
        if not self.compiled:
            return rows if isinstance(rows, list) else list(rows)
        import numpy as np

        return np.array(list(map(_entries_of(kind), rows)), _row_type(kind))

    def copies(self, kind: type, row: Any, count: int) -> Any:
        """A table of so many rows like one."""
        if not self.compiled:
            return [copy(row) for _ in range(count)]
        import numpy as np

        return np.repeat(self.table(kind, [row]), count)

    def room(self, kind: type, count: int) -> Any:
        """A table of rows of zeros, for a kind whose defaults are zeros."""
        if not self.compiled:
            return [kind() for _ in range(count)]
        import numpy as np

        return np.zeros(count, _row_type(kind))

    def log(self, rows: int) -> Log:
        """A log with room for so many events."""
        return Log(
            kind=self.zeros(rows, int),
            period=self.zeros(rows, int),
            theta=self.zeros(rows),
            q=self.zeros(rows),
            u=self.zeros(rows),
            capacity=rows,
        )

    def unwritten_log(self, rows: int) -> Log:
        """`log` without the zeros: most of a large one stays unused, and is never read."""
        if not self.compiled:
            return self.log(rows)
        import numpy as np

        return Log(
            kind=np.empty(rows, np.int64),
            period=np.empty(rows, np.int64),
            theta=np.empty(rows),
            q=np.empty(rows),
            u=np.empty(rows),
            capacity=rows,
        )

    def strobe(self, rows: int) -> Strobe:
        """A table of strobes with room for so many periods."""
        q = self.zeros(rows)
        w = self.zeros(rows)
        impacts = self.zeros(rows, int)
        chatter = self.zeros(rows, int)
        return Strobe(q, w, impacts, chatter, rows)

    def cam(self, cam: Cam) -> Cam:
        """The tables of a cam."""
        stretches = self.table(Stretch, cam.stretches)
        return cam._replace(stretches=stretches, pieces=self.numbers(cam.pieces))

    def stretch_flows(self, cam: Cam, constants: Constants) -> Any:
        """The table of `flow.fill_flows`, for a cam in this kernel's form."""
        flows = self.room(Flow, len(cam.stretches) ** 2)
        self.fill_flows(cam, constants, flows)
        return flows


def as_list(values: Any) -> list:
    """A column as a list of Python's own numbers: reading numpy's one by one is slow."""
    return values.tolist() if hasattr(values, "tolist") else list(values)


def row_of(kind: type[Row], row: Any) -> Row:
    """A row of a `Kernel.table` as an object of plain numbers."""
    if isinstance(row, kind):
        return copy(row)
    return kind(*row.item())


def rows_of(kind: type[Row], rows: Any) -> list[Row]:
    """`row_of` each of these rows of a table: reading them one by one is slow."""
    if isinstance(rows, list):
        return [copy(row) for row in rows]
    return [kind(*values) for values in rows.tolist()]


@cache
def _entries_of(kind: type) -> Callable[[Any], tuple]:
    """A function that returns the fields of a row of this kind as a tuple, in their order."""
    return attrgetter(*kind.__annotations__)


@cache
def _row_type(kind: type) -> Any:
    """NumPy's type of a row of this kind; always the same object, which numba knows quickly."""
    import numpy as np

    fields = [(name, np.dtype(of)) for name, of in kind.__annotations__.items()]
    return np.dtype((np.record, fields))


PLAIN = Kernel(
    False, fill_flows, follow_orbits, correct_orbit, certify_orbit, settle_cells, stretch_events,
    measure_loads, enclose_landing,
)  # fmt: skip
