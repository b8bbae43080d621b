"""What every analysis gives: tables, a summary, pictures, notes, cost, and a way to save them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import cached_property, partial
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO
from warnings import warn

from camcli.analysis.integrate import Budget, Cost, budgeted
from camcli.errors import Fault, SceneError, shown
from camcli.interrupts import signal_came
from camcli.output.drawing_process import DrawingProcess, DrawingTask, DrawnPicture
from camcli.output.run_folder import RunFolder, UnwritableError, run_folder
from camcli.output.run_record import (
    as_json,
    cost_record,
    error_record,
    run_record,
    to_text,
)
from camcli.output.tables import Named, Table
from camcli.piece_faults import PieceFault, fault_records, gather, gathering, piece
from camcli.scene import Scene, load_scene, resolved, scene_hash
from camcli.scene.schema import no_panel
from camcli.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from camcli.plots.picture import Picture
    from camcli.words.verdict import Answer

TOLD_FROM = 0.1  # of run.work_budget: the progress shows how much is spent once it is more
Progress = Callable[[str, int, int], None]  # what is counted, how many are done, of how many


@dataclass(frozen=True, repr=False)
class Result:
    """The result of one analysis of one scene; it pickles, so that processes can return it.

    Attributes
    ----------
    command : str
        The analysis: "simulate", "sweep", "detach", "orbits", "basins" or "classify".
    scene : Scene
        What was asked, with every default filled in.
    tables : Mapping[str, Table]
        Tables by the names of the CSV files without their ending; ``tables["speeds"]["rpm"]`` is a
        NumPy array. The unit stands in the name of a column. A table is a mapping of its columns:
        ``pandas.DataFrame(tables["speeds"])`` and ``polars.DataFrame(tables["speeds"])`` take it as
        it is.
    summary : Mapping[str, Any]
        Plain values beside the tables: the entry ``result`` of run.json.
    notes : tuple of str
        Warnings, and what could not be settled, as the command prints them.
    complete : bool
        False where a row's status is not ok or a search found no safe bracket (the command then
        ends with exit code 3). All good rows are there.
    faults : tuple of PieceFault
        Pieces (a speed, a block of cells, a branch, a motion) that an unforeseen exception has
        cost; their rows have the status ``fault``. The command then ends with exit code 1.
    cost : Cost
        Impacts and gap evaluations, those of transients included.
    seconds : float
        Time of the analysis, without that of compiling the kernel.
    pictures : Mapping[str, Callable]
        Functions that draw the pictures, by the names of their files; see `plot`.
    files : Mapping[str, Callable]
        Functions that write further files, such as a page or an animation, by their names.
    left_out : dict of str
        Of each picture that has been written, the panels for which its page had no room.
    system : System or None
        The machine: follower and compiled cam; of `bench`, which has many, None.
    values : object
        What the analysis returned, from which all of this was made: a frozen dataclass, or a tuple
        of two where an explanation or a question belongs to it.
    error : Mapping[str, Any]
        Bounds on errors, the entry `error` of run.json: of one event, and of a measured cam
        ``error["lift_table"]``: its fit, the bound on c_thetatheta, and ``first_detachment_rpm``,
        the two speeds between which contact is first lost (None: at no speed).
    verdict : list of str
        The answer in sentences, as the command begins with it; none of `bench`.
    verdict_details : list of str
        What more there is to say of it, as with `--verbose`.

    Examples
    --------
    >>> import tempfile
    >>> import camcli
    >>> result = camcli.detach()
    >>> result
    <Result of detach: tables detach, accumulation, corner_hits, force, speeds>
    >>> result.complete
    True
    >>> result.verdict[0]
    'Contact holds up to 114.979 rpm of the cam.'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     blamed = result.save(folder, plot=False)
    """

    command: str
    scene: Scene
    system: System | None
    values: Any
    tables: Mapping[str, Table]
    summary: Mapping[str, Any]
    pictures: Mapping[str, Callable[[], Picture]]
    cost: Cost = field(default_factory=Cost)
    seconds: float = 0.0
    notes: tuple[str, ...] = ()
    complete: bool = True
    faults: tuple[PieceFault, ...] = ()
    files: Mapping[str, Callable[[BinaryIO], Any]] = field(default_factory=dict)
    left_out: dict[str, Sequence[str]] = field(default_factory=dict, init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "summary", as_json(self.summary))
        object.__setattr__(self, "tables", Named("table", self.tables))
        object.__setattr__(self, "pictures", Named("picture", self.pictures))

    def __repr__(self) -> str:
        return f"<Result of {self.command}: tables {', '.join(self.tables)}>"

    def _repr_html_(self) -> str:
        """Verdict, first picture and tables, in a notebook."""
        from camcli.output.notebook import result_html

        figure = plot(self) if self.pictures else None
        return result_html(self.verdict, figure, dict(self.tables))

    @cached_property
    def error(self) -> Mapping[str, Any]:
        """Bounds on errors; see above."""
        if self.system is None or self.scene.cam.kind != "table":
            return self._error_of_an_event()
        from camcli.api.lift_table import table_record

        record = table_record(self.scene.cam, self.system)
        return {**self._error_of_an_event(), "lift_table": record}

    def _error_of_an_event(self) -> dict[str, Any]:
        """What the chatter tolerance of the scene means for one event; nothing of `bench`."""
        tolerance = self.scene.run.chatter_tolerance
        return {} if self.system is None else error_record(tolerance, self.system)

    @property
    def verdict(self) -> list[str]:
        """The answer in sentences; see above."""
        return self._answer.lines

    @property
    def verdict_details(self) -> list[str]:
        """More sentences; see above."""
        return self._answer.details

    @cached_property
    def _answer(self) -> Answer:
        """All sentences of the answer."""
        from camcli.analysis.contact_loss.detachment import detachment
        from camcli.words.verdict import Answer, verdict

        if self.system is None:
            return Answer([], [])
        contact = None if self.command == "simulate" else detachment(self.system)
        return verdict(self, contact, self.error.get("lift_table"))

    def save(self, folder: str | Path, *, plot: bool = True) -> Mapping[str, Any]:
        """Write the files of the command `cam COMMAND -o folder`, byte for byte.

        Parameters
        ----------
        folder : path
            Made if need be. Files of an earlier run are replaced at once at the end, each whole.
        plot : bool
            False leaves out the pictures.

        Returns
        -------
        Mapping
            The content of run.json.

        Raises
        ------
        SceneError
            If the folder cannot be written, or another run is at work in it; or, when all else is
            in its place, if a picture cannot be drawn as the scene asks.
        """
        with run_folder(Path(folder)) as run:
            return self.write(run, plot=plot)

    def write(
        self,
        folder: RunFolder,
        *,
        plot: bool = True,
        from_disk: int = 0,
        drawing_process: DrawingProcess | None = None,
    ) -> Mapping[str, Any]:
        """`save` into an open folder.

        from_disk: pieces that an interrupted run had computed; drawing_process: it draws the
        pictures while the tables are written, unless it fails.

        A table, a picture or a page that cannot be made costs itself alone: where nobody foresaw
        it, it is one of the record's piece_faults; what the scene or the system is to blame for is
        raised when all else is in its place.
        """
        # `piece` calls a function; an unforeseen exception in it is added to `faults`, and the last
        # argument is returned instead.
        with gathering() as faults:
            gather(self.faults)
            blamed = self._write_files(folder, plot, drawing_process)
            errors = piece("lift_table", lambda: self.error, self._error_of_an_event())
            answer = piece("verdict", lambda: self._answer, None)
            # Only from here on the hashes of the files are asked for, which waits for the disk.
            old_pictures: dict[str, str] = {}
            if not plot:
                old_pictures = folder.keep_pictures(
                    list(self._picture_files()), scene_hash(self.scene)
                )
            record = run_record(
                command=self.command,
                scene=resolved(self.scene),
                scene_sha256=scene_hash(self.scene),
                cost=cost_record(self.cost, self.seconds, from_disk),
                error=errors,
                verdict=[] if answer is None else answer.lines,
                verdict_details=[] if answer is None else answer.details,
                notes=list(self.notes),
                result=self.summary,
                piece_faults=fault_records(faults),
                artefacts=folder.hashes | old_pictures,
            )
            text = piece("the summary", partial(to_text, record))
            if text is None:  # the summary holds what JSON cannot; that is one more fault
                record |= {"result": None, "piece_faults": fault_records(faults)}
                text = to_text(record)
        folder.write_text("run.json", [text])
        folder.commit(old_pictures)
        if blamed:
            raise blamed[0]
        return record

    def _picture_files(self) -> dict[str, tuple[str, str]]:
        """The picture files that the scene asks for: (name of the picture, its ending) by file."""
        kinds = self.scene.plot.formats
        return {f"{name}.{kind}": (name, kind) for name in self.pictures for kind in kinds}

    def _write_files(
        self, folder: RunFolder, plot: bool, drawing_process: DrawingProcess | None
    ) -> list[Exception]:
        """Write tables, pictures and pages.

        Returns errors that the scene or the system is to blame for.
        """
        blamed: list[Exception] = []
        if plot and drawing_process is not None:
            form = self.scene.plot
            files = self._picture_files().values()
            drawing_process.begin(
                [DrawingTask(self.pictures[name], kind, form) for name, kind in files]
            )

        def attempt_file(
            name: str, write: Callable[..., Any], fill: Callable[[BinaryIO], Any]
        ) -> None:
            """Write one file; keep an error that the scene or the system is to blame for.

            Where the folder itself cannot be written, or the run is interrupted, the error is
            raised at once.
            """
            try:
                piece(name, partial(write, name, fill))
            except Exception as error:
                if isinstance(error, UnwritableError) or signal_came():
                    raise
                blamed.append(error)

        as_npz = self.command == "sweep" and self.scene.sweep.tables == "npz"
        tried_together = False
        written: list[str] = []  # tables that were written in one reading of their shared rows
        for name, table in self.tables.items():
            if table.shared is not None and not tried_together:
                written = self._written_together(folder, as_npz)
                tried_together = True
            if name in written:
                continue
            if as_npz and name != "speeds":  # which is small, and has texts
                attempt_file(f"{name}.npz", folder.write, table.npz)
            else:
                attempt_file(f"{name}.csv", folder.write, table.write_csv)
        if plot:
            for file, (name, kind) in self._picture_files().items():
                drawn = None if drawing_process is None else drawing_process.next_drawn()
                write_picture: Callable[[BinaryIO], None] = partial(self._draw, name, kind)
                if drawn is not None:
                    write_picture = partial(self._write_drawn, name, drawn)
                attempt_file(file, folder.write_whole, write_picture)
        for name, fill in self.files.items():
            attempt_file(name, folder.write_whole, fill)
        folder.claim([*folder.names, "run.json"])
        return blamed

    def _written_together(self, folder: RunFolder, as_npz: bool) -> list[str]:
        """Write the tables that share their rows, reading these once; the names of the tables.

        A table names the rows it is made of first in `Table.shared`. Where that fails none of the
        tables is left and the list is empty: the caller then writes one after the other, so that a
        table that cannot be made costs itself alone, and the error names it.
        """
        tables: dict[str, Table] = {}
        sources = set()
        for name, table in self.tables.items():
            if table.shared is not None:
                tables[name] = table
                sources.add(table.shared[0])
        if len(tables) < 2 or len(sources) > 1:
            return []
        rows = sources.pop()
        write = rows.write_npz if as_npz else rows.write_csv
        ending = "npz" if as_npz else "csv"
        try:
            with ExitStack() as stack:
                # The stack closes the file opened last first. A folder lists files in the order in
                # which they are closed, so the first table is opened last.
                files: list[BinaryIO] = []
                for name in reversed(tables):
                    file = stack.enter_context(folder.writing(f"{name}.{ending}"))
                    files.insert(0, file)
                write(list(tables.values()), files)
        except Exception:
            if signal_came():
                raise
            return []
        return list(tables)

    def _write_drawn(self, name: str, drawn: DrawnPicture, file: BinaryIO) -> None:
        """Write a picture that another process has drawn, and tell what that was warned of."""
        self.left_out[name] = drawn.left_out
        for text in drawn.warnings:
            warn(text, stacklevel=2)
        file.write(drawn.content)

    def _draw(self, name: str, kind: str, file: BinaryIO) -> None:
        """Write a picture; raises SceneError where only its style is to blame that it fails.

        name: of the picture; kind: png, pdf or svg.
        """
        from camcli.output.pictures import write_picture

        picture = self.pictures[name]()
        form = self.scene.plot
        try:
            self.left_out[name] = write_picture(picture, file, kind, form)
        except (SceneError, OSError):
            raise
        except Exception as error:
            if form.style is None:
                raise
            without_style = form.model_copy(update={"style": None})
            write_picture(picture, BytesIO(), kind, without_style)  # fails too where we are wrong
            reason = shown(str(error), 200)
            found = f"found a style in which {name}.{kind} cannot be drawn ({reason})"
            cure = "change it, or leave it out"
            raise SceneError(Fault(form.style, "plot.style", found, "", cure)) from None


def plot(
    result: Result,
    picture: str | None = None,
    *,
    axes: Axes | Sequence[Axes] | None = None,
    **form: Any,
) -> Figure:
    """Draw a result.

    Parameters
    ----------
    result : Result
        Of any analysis.
    picture : str, optional
        Which of ``result.pictures``; the first by default.
    axes : matplotlib Axes, or several, optional
        Your own axes: they get a panel each, with your settings of matplotlib. Name the panels by
        `panels`, else they are the first ones.
    **form
        Keys of the scene's section ``plot``: width and height (mm), font, style, title, panels.

    Returns
    -------
    matplotlib.figure.Figure
        A figure of its own, or that of your axes: nothing is written, pyplot is not touched.
        matplotlib's rcParams are ours while it draws, and as before when it is done.

    Raises
    ------
    KeyError
        If the result has no such picture.
    SceneError
        If `form` has an unknown key, a value that does not fit, panels that are not there, or
        more of them than there are axes.

    Examples
    --------
    >>> import camcli
    >>> turns = {"run.transient": 0, "run.record": 2}
    >>> result = camcli.simulate(camcli.load_scene(None, turns))
    >>> figure = camcli.plot(result, width=170.0)
    >>> round(25.4 * figure.get_figwidth())
    170
    """
    name = next(iter(result.pictures)) if picture is None else picture
    checked = load_scene(
        None, {f"plot.{key}": value for key, value in form.items()}, command=result.command
    )
    section = result.scene.plot.model_copy(update={key: getattr(checked.plot, key) for key in form})
    drawn = result.pictures[name]()
    if "panels" in form:
        missing = drawn.lacking(section.panels)
        if missing:
            known = list(drawn.panels)
            faults = [Fault("", "plot.panels", *no_panel(panel, known)) for panel in missing]
            raise SceneError(*faults)
    if axes is None:
        return drawn.figure(section)
    given_axes = list(axes) if isinstance(axes, Iterable) else [axes]
    panels = drawn.chosen(section.panels)
    if "panels" in form and len(panels) > len(given_axes):
        found = f"found {len(panels)} panels and {len(given_axes)} axes"
        expected = "expected axes for each panel"
        cure = "give more axes: _, axes = plt.subplots(len(panels)); or name fewer panels"
        raise SceneError(Fault("", "axes", found, expected, cure))
    for panel, panel_axes in zip(panels.values(), given_axes, strict=False):
        panel.draw(panel_axes)
    figure = given_axes[0].get_figure(root=True)
    assert figure is not None
    return figure


def drawn_by(function: str, *args: Any) -> Callable[[], Picture]:
    """A function without arguments that draws a picture; it pickles, as a Result does.

    function: `module.function` of camcli.plots, which is imported only when it is to draw.
    """
    return partial(_drawing, function, *args)


def _drawing(function: str, *args: Any) -> Picture:
    """Draw by the function `module.function` of camcli.plots."""
    module, _, name = function.partition(".")
    return getattr(import_module(f"camcli.plots.{module}"), name)(*args)


def ticks(progress: Progress | None, what: str, total: int) -> Callable[..., None]:
    """A function to call once for each of `total` things that are done."""
    done = 0

    def tick(*_: object) -> None:
        """Count one more piece as done."""
        nonlocal done
        done += 1
        if progress is not None:
            progress(what, done, total)

    return tick


def budget_of(scene: Scene, progress: Progress | None) -> AbstractContextManager[Budget]:
    """Let the work in the block end where run.work_budget is spent.

    How much of it is spent goes to the progress from TOLD_FROM of it on: most runs spend next to
    nothing.
    """

    def on_spent(spent: int, budget: int) -> None:
        """Show how much of the budget is spent."""
        if progress is not None and spent > TOLD_FROM * budget:
            progress("of run.work_budget", spent, budget)

    return budgeted(scene.run.work_budget, on_spent)
