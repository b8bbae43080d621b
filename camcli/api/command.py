"""What a command is beside what it computes: its files, how much a scene asks of it, its samples.

Each module of an analysis, `camcli.api.NAME`, has one `COMMAND`; the command line, `--dry-run` and
`cam rerun` know of a command what stands there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from inspect import signature
from typing import TYPE_CHECKING, Any, NamedTuple

from camcli.quantities import Head
from camcli.scene import Axis, Scene

if TYPE_CHECKING:
    from camcli.api.machine import Machine
    from camcli.api.result import Result
    from camcli.parallel import Work

MOST_SAMPLED_TURNS = 1000  # of transient and of record in a sample; the rest is taken to be alike


class Size(NamedTuple):
    """How much a scene asks for, and the least bytes that takes."""

    what: str  # in words
    pieces: int  # of equal work
    orbits: int
    turns: float  # of all orbits; 0 where it is not known before
    rows: int  # of the tables that do not grow with the recorded turns
    memory: float  # beside the program and its pictures
    tables: float  # of the files that are left
    kept: float  # of the pieces on disk until those are written


class Drawing(NamedTuple):
    """What a picture of usual size takes: bytes of its PNG, of memory, and per further pixel."""

    file: float
    memory: float
    per_pixel: float


class Part(NamedTuple):
    """An analysis that is part of a page: the name of its command, and its scene."""

    command: str
    scene: Scene


class Page(NamedTuple):
    """A page made of other analyses.

    parts: from the scene of the page, its parts by name. size: from the machine, and the results of
    samples of the parts by name, the bytes of the page.
    """

    parts: Callable[[Scene], Mapping[str, Part]]
    size: Callable[[Machine, Mapping[str, Result]], float]


class Repeated(NamedTuple):
    """One of several works that are alike, as a scene of its own, and how many they are."""

    scene: Scene
    times: int


def one_run(scene: Scene) -> Size:
    """The size of a command whose work is little and always the same."""
    return Size(
        what="one run", pieces=1, orbits=1, turns=0.0, rows=1, memory=0.0, tables=0.0, kept=0.0
    )


def whole(scene: Scene, n: int) -> Scene:
    """A sample of a command whose work is always the same: the scene with few turns."""
    return sample(scene, None)


def sample(scene: Scene, section: str | None, record: int | None = None, **values: Any) -> Scene:
    """The scene with few turns, and with some values of a section replaced.

    section: its name; None: no section changes. record: the most turns that are recorded, where
    that is not MOST_SAMPLED_TURNS.
    """
    from camcli.api.machine import with_values

    most_recorded = MOST_SAMPLED_TURNS if record is None else record
    few_turns = with_values(
        scene,
        "run",
        transient=min(MOST_SAMPLED_TURNS, scene.run.transient),
        record=min(most_recorded, scene.run.record),
    )
    return few_turns if section is None else with_values(few_turns, section, **values)


def fewer(section: Any, n: int) -> dict[str, Any]:
    """The keys `rpm` and `vary` of a section, each range with at most n values.

    None of the values is an end of its range, where what happens is often special. Where all values
    are whole numbers those of the sample are among them: a number of turns cannot be anything else.
    """

    def inside(axis: Axis) -> Axis:
        """The range with n values at most, moved in from both ends by half a step."""
        if n >= axis.num:
            return axis
        half_step = 0.5 * (axis.stop - axis.start) / n
        values = {"start": axis.start + half_step, "stop": axis.stop - half_step, "num": n}
        return axis.model_copy(update=values)

    varied = getattr(section, "vary", ())  # not every section can vary other numbers
    some = (_some_values(axis, n) if _is_whole(axis) else inside(axis) for axis in varied)
    return {"rpm": inside(section.rpm), "vary": tuple(some)}


def _is_whole(axis: Axis) -> bool:
    """Whether all values of a range are whole numbers."""
    step = (axis.stop - axis.start) / max(1, axis.num - 1)
    return axis.start.is_integer() and step.is_integer()


def _some_values(axis: Axis, n: int) -> Axis:
    """The range with n of its own values at most, equally spaced, and none of its ends."""
    if n >= axis.num:
        return axis
    last = axis.num - 1
    count = min(n, max(1, last - 1))
    stride = 0
    if count > 1:
        stride = min(axis.num // count, (last - 2) // (count - 1))
    first = (last - stride * (count - 1)) // 2
    step = (axis.stop - axis.start) / last
    start = axis.start + step * first
    values = {"start": start, "stop": start + step * stride * (count - 1), "num": count}
    return axis.model_copy(update=values)


def nothing(scene: Scene) -> list[str]:
    """A command of which a sample shows all that it costs."""
    return []


def no_pieces(scene: Scene) -> bool:
    """A command that keeps no pieces on disk."""
    return False


def all_at_once(scene: Scene) -> Repeated:
    """A command of which a sample is a part of all its work."""
    return Repeated(scene, times=1)


def no_bytes(scene: Scene) -> float:
    """A command that writes tables and pictures only."""
    return 0.0


def check_nothing(scene: Scene) -> None:
    """A command that refuses nothing more than the scene does."""


@dataclass(frozen=True)
class Command:
    """A command, which has the name of its API function.

    run
        The API function.
    tables
        The heads of its tables: a CSV file each.
    files
        The names of the other files that it may write: pictures, pages, other forms of a table.
    size, drawing
        How much a scene asks for.
    beside
        Bytes of the files that it asks for beside tables and pictures, about.
    sample
        The scene with about n of its pieces, of few turns each; None where no sample tells what the
        run costs.
    repeated
        One of several works that are alike, of which samples are taken, and how many they are.
    check
        Raises SceneError for what the run would refuse only after some work.
    not_foreseen
        Sentences on what no sample shows.
    keeps_pieces
        Whether finished pieces are kept on disk, so that an interrupted run goes on from them.
    has_budget
        Whether run.work_budget ends it.
    less
        How to ask for smaller files, in words.
    page
        Of a command that is made of others.
    """

    run: Callable[..., Result]
    tables: tuple[Head, ...] = ()
    files: tuple[str, ...] = ()
    size: Callable[[Scene], Size] = one_run
    drawing: Callable[[Scene], Drawing] = lambda scene: Drawing(
        file=200e3, memory=100e6, per_pixel=5.0
    )
    beside: Callable[[Scene], float] = no_bytes
    sample: Callable[[Scene, int], Scene] | None = whole
    repeated: Callable[[Scene], Repeated] = all_at_once
    check: Callable[[Scene], None] = check_nothing
    not_foreseen: Callable[[Scene], list[str]] = nothing
    keeps_pieces: Callable[[Scene], bool] = no_pieces
    has_budget: bool = False
    less: str = ""
    page: Page | None = None

    @property
    def name(self) -> str:
        """The name of the command, and of its section in a scene."""
        return self.run.__name__

    @property
    def artefacts(self) -> tuple[str, ...]:
        """The names of all files that the command may write.

        Files of other people with these names are looked for before any work is done.
        """
        return (*(f"{head.name}.csv" for head in self.tables), *self.files)

    @property
    def pictures(self) -> tuple[str, ...]:
        """The names of all pictures that it may draw, without their endings."""
        png_files = [name for name in self.artefacts if name.endswith(".png")]
        return tuple(name.removesuffix(".png") for name in png_files)

    def in_pieces(self, work: Work) -> Callable[..., Result]:
        """The API function to be called with a scene; where it works in pieces, by this `Work`."""
        if "work" in signature(self.run).parameters:
            return partial(self.run, work=work)
        return self.run


class Column(NamedTuple):
    """A column of a table of a command, as a reference tells it.

    when: in which runs it is there; empty: in all.
    """

    table: str
    column: str
    unit: str
    meaning: str
    when: str


def columns_of(command: Command) -> Iterator[Column]:
    """Every column of every table of a command, in the order of the files."""
    for head in command.tables:
        quantities_by_when = {"": head.columns, **head.more}  # "": in every run
        for when, quantities in quantities_by_when.items():
            for quantity in quantities:
                name = f"{quantity.column}_1.." if quantity.numbered else quantity.column
                yield Column(head.name, name, quantity.unit, quantity.meaning, when)


def command_of(name: str) -> Command:
    """The command of this name; its module is imported."""
    command: Command = import_module(f"camcli.api.{name}").COMMAND
    return command
