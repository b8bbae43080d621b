"""The frame of every analysis: load the scene, call the API, save, and say what came out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camcli.cli.drawing import WHAT_DRAWS, process_for
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS, note
from camcli.cli.options import Request, Values, given, numbers
from camcli.cli.report import progress_bar, say
from camcli.errors import Fault, SceneError, is_or_are, plural, shown
from camcli.installed import version
from camcli.kernel.backend import Stopwatch, stopwatch
from camcli.kernel.code_cache import News, cache_dir
from camcli.output.drawing_process import import_what_draws
from camcli.output.run_folder import RECORD, RunFolder, run_folder
from camcli.output.run_record import to_text
from camcli.piece_faults import MOST_TEXT, PieceFault, attempt, fault_records
from camcli.scene import Scene, here_or_shipped, load_scene, parse_rpm, resolved
from camcli.scene.load import WrittenSpeed
from camcli.scene.made_up import made_up
from camcli.scene.speeds import OF_THE_SPEED, names_a_crank

if TYPE_CHECKING:
    from camcli.api.command import Command
    from camcli.api.result import Result
    from camcli.parallel import Shard

Show = Callable[["Result", bool], None]  # bool: whether to print the theory too
MOST_SHARDS = 100_000
OWN_SPEEDS = ("sweep", "classify", "basins")  # commands that do not read run.rpm, unless they vary
ANSWERING = ("simulate", "detach")  # commands that are asked whether contact holds
MOST_PIECES = 5  # named in the line on a fault
MOST_NAMES = 3  # of files with pieces of other scenes that a note names
MOST_DIGITS = 30  # of --points; a longer number is nonsense, and slow to read
CHECKS = "guesses of cam init; correct what is wrong, and remove the word"
NEWS = {
    News.COMPILING: "compiling the kernel for this machine: some 5 to 10 s, once ...",
    News.DAMAGED: "the cache of the kernel was damaged and is removed",
    News.KILLED: "an earlier process ended while it loaded the kernel: its cache is removed",
    News.NOT_OURS: (
        "the cache of the kernel is not used, and each run compiles: {folder} is not a folder that "
        "only you may write; make it one (chown, chmod go-w), or remove it"
    ),
    News.PUBLIC: (
        "note: camcli's own way to compile does not know numba {numba}, so numba compiles the "
        "kernel by itself: half a minute once, and each start takes some 2 s longer; the numbers "
        "are the same"
    ),
}


def one_speed(request: Request) -> Values:
    """The keys that --rpm and --points set for a command that runs at one speed."""
    rpm = None if request.rpm is None else parse_rpm(request.rpm)
    if isinstance(rpm, tuple):
        found = f"found the range '{request.rpm}'"
        raise SceneError(Fault("--rpm", "", found, "expected one speed", "use cam sweep"))
    (points,) = points_of(request)
    return given("run", rpm=rpm) | given("simulate", "--points", samples=points)


def ranges(
    request: Request,
    section: str,
    vary: Sequence[str] | None = None,
    most: int = 1,
    option: str = "--vary",
) -> Values:
    """--rpm, --points and --vary of a command for a range of speeds, or of other numbers.

    At most so many numbers are varied; beside another one --rpm may be a single speed. option: the
    one in which `vary` was typed.
    """
    rpm = None if request.rpm is None else parse_rpm(request.rpm)
    if vary:
        return _varied(request, section, rpm, vary, most, option)
    values: Values = {}
    if rpm is not None:
        low, high = _two(rpm)
        values[f"{section}.rpm.start"] = (low, "--rpm")
        values[f"{section}.rpm.stop"] = (high, "--rpm")
        if low == high:
            values[f"{section}.rpm.num"] = (1, "--rpm")
    (points,) = points_of(request)
    if points is not None and points > 1 and f"{section}.rpm.num" in values:
        found = f"found {points} and one speed"
        raise SceneError(Fault("--points", "", found, "", "give a range: --rpm LO:HI"))
    return values | given(f"{section}.rpm", "--points", num=points)


def _varied(
    request: Request,
    section: str,
    rpm: WrittenSpeed | tuple[WrittenSpeed, WrittenSpeed] | None,
    vary: Sequence[str],
    most: int,
    option: str,
) -> Values:
    """The key `vary` of a section; for the arguments see `ranges`. A single speed is run.rpm."""
    axes = [_axis(text, option) for text in vary]
    values: Values = {}
    if isinstance(rpm, tuple):
        axes.insert(0, {"key": "rpm", "start": rpm[0], "stop": rpm[1]})
    elif rpm is not None:
        values["run.rpm"] = (rpm, "--rpm")
    if len(axes) > most:
        found = f"found {len(axes)} numbers to vary"
        cure = f"give --rpm one speed, or fewer {option}"
        raise SceneError(Fault(option, "", found, f"expected at most {most}", cure))
    for axis, points in zip(axes, points_of(request, len(axes)), strict=True):
        if points is not None:
            axis["num"] = points
    values[f"{section}.vary"] = (axes, option)
    return values


def _axis(text: str, option: str) -> dict[str, Any]:
    """Key, start and stop of an axis from a text KEY=LO:HI; option: with which it was given."""
    key, _, ends = text.partition("=")
    key = key.strip()
    if key in OF_THE_SPEED and names_a_crank(ends.split(":")):
        low, high = _two(parse_rpm(ends, option))
        return {"key": key, "start": low, "stop": high}
    return {"key": key, **span_of(text, option, "KEY=LO:HI", "follower.restitution=0.6:0.9")}


def _two(rpm: WrittenSpeed | tuple[WrittenSpeed, WrittenSpeed]) -> tuple[Any, Any]:
    """Both ends of a range of speeds; a single one is both."""
    return rpm if isinstance(rpm, tuple) else (rpm, rpm)


def points_of(request: Request, axes: int = 1) -> Sequence[int | None]:
    """The number of --points for each of so many axes; None for each where it is not given.

    A single number is that of all axes.
    """
    if request.points is None:
        return [None] * axes
    words = request.points.split(",")
    readable = all(word.strip().isdecimal() and len(word) <= MOST_DIGITS for word in words)
    if len(words) not in (1, axes) or not readable:
        expected = "expected a whole number above 0"
        if axes == 2:
            expected += ", or N,M"
        cure = "give one number for each that is varied" if readable else "e.g. --points 41"
        raise SceneError(Fault("--points", "", f"found '{shown(request.points)}'", expected, cure))
    counts = [int(word) for word in words]
    return counts * axes if len(counts) == 1 else counts


def span_of(text: str, option: str, form: str, example: str) -> dict[str, Any]:
    """The numbers of LO:HI as keys of a scene, `start` and `stop`.

    option: what the text was given with; form and example: how it should look, for the fault.
    """
    ends = numbers(text, option, form, example)
    assert ends is not None  # there is a text
    low, high = ends
    return {"start": low, "stop": high}


def run(
    name: str,
    request: Request,
    values: Values,
    show: Show,
    *,
    shard: str | None = None,
    cluster: str | None = None,
) -> int:
    """Run the command of this name as the user asked for it; returns the exit code.

    values: what the options set in the scene. show: prints the result of the run. shard, cluster:
    the texts of --shard and --cluster. With --dry-run nothing is run but the samples of a forecast.
    """
    from camcli.cli.panels import check_panels

    scene = load_scene(
        request.config, request.sets or (), values | request.picture_values(), command=name
    )
    check_panels(name, scene, request)
    if not request.quiet:
        _tell(scene, request.config)
        _tell_of_unused_speed(name, scene, request)
        _tell_of_a_crank(name, scene)

    # Only now: a scene that is refused is refused without the time that these take to be imported.
    from camcli.api.command import command_of
    from camcli.api.machine import leaves_speeds_open, machine_of
    from camcli.words.speeds import chosen_speeds

    if leaves_speeds_open(scene, name):
        machine = machine_of(scene)
        scene = machine.scene
        if name in machine.chosen and not request.quiet:
            note(chosen_speeds(name, machine.chosen[name]))
    command = command_of(name)
    part = shard_of(shard)
    check_before(command, scene, request.folder(name), not request.no_plot, part)
    if request.dry_run:
        from camcli.cli.forecast import forecast

        with compiling(request):
            forecast(command, scene, request, part)
        return DONE
    if not request.quiet:
        _tell_of_size(command, scene)
    return execute(command, scene, request, show, shard=part, cluster=cluster)


def check_before(
    command: Command,
    scene: Scene,
    folder: Path,
    drawn: bool,
    shard: Shard | None = None,
) -> None:
    """Raise SceneError before any work for what can never fit, or never be drawn."""
    from camcli.cli.sizes import refuse_too_large

    if drawn and (scene.plot.font or scene.plot.style):
        from camcli.plots.style import check_look

        check_look(scene.plot.font, scene.plot.style)
    refuse_too_large(command, scene, folder, drawn=drawn, shard=shard)


def _tell_of_size(command: Command, scene: Scene) -> None:
    """Note before a run that it will write more than MUCH bytes, and how to ask for less."""
    from camcli.cli.sizes import MUCH, in_words

    size = command.size(scene)
    if max(size.tables, size.kept) > MUCH:
        text = f"note: this writes at least {in_words(size.tables)} of files"
        if size.kept:
            text += f", and {in_words(size.kept)} of pieces until then"
        if command.less:
            text += f"; {command.less}"
        note(f"{text}; see cam {command.name} --dry-run")


def execute(command: Command, scene: Scene, request: Request, show: Show, **pieces: Any) -> int:
    """Run an analysis of a scene, and say what came out; pieces: see `open_folder`."""
    with open_folder(command, scene, request, **pieces) as folder:
        drawn = not request.no_plot
        result, record = compute(command, scene, request, folder, drawn)
        fault = attempt("the words on the screen", lambda: _say(result, record, request, show))
        if isinstance(fault, PieceFault):  # all files are in their places: only run.json changes
            all_faults = [*record["piece_faults"], *fault_records([fault])]
            record = {**record, "piece_faults": all_faults}
            folder.replace_record(to_text(record))
        tell_faults(record["piece_faults"], folder.folder / RECORD)
    if folder.shard_done:
        return INTERNAL if folder.work.faults else DONE
    return exit_code(result, record)


def exit_code(result: Result, record: Mapping[str, Any]) -> int:
    """The exit code of a run, from its result and its run.json."""
    if record["piece_faults"]:
        return INTERNAL
    still_made_up = made_up(result.scene)
    if result.command == "simulate" and result.scene.simulate.profile_only:
        still_made_up = [key for key in still_made_up if key.startswith("cam.")]  # no spring counts
    return DONE if result.complete and not still_made_up else NUMERICS


def compute(
    command: Command,
    scene: Scene,
    request: Request,
    folder: RunFolder,
    plot: bool,
) -> tuple[Result, Mapping[str, Any]]:
    """Run an analysis, write its artefacts into the folder, and return (result, its run.json)."""
    process = process_for(command, scene) if plot else None
    if plot:
        _keep_matplotlib_quiet()
    with compiling(request), progress_bar(request.quiet) as progress:
        result = command.in_pieces(folder.work)(scene, progress)
        if plot and result.pictures and process is None:
            import_what_draws(WHAT_DRAWS)
        record = result.write(folder, plot=plot, from_disk=folder.resumed, drawing_process=process)
    return result, record


def _keep_matplotlib_quiet() -> None:
    """Let matplotlib say errors alone: of a home that may not be written it warns at each import.

    Its temporary folder then does as well, only slower, and no user of cam can do a thing with it.
    """
    import logging  # matplotlib imports it too

    logging.getLogger("matplotlib").setLevel(logging.ERROR)


@contextmanager
def open_folder(
    command: Command,
    scene: Scene,
    request: Request,
    *,
    shard: Shard | None = None,
    cluster: str | None = None,
    parts: tuple[Path, ...] = (),
) -> Iterator[RunFolder]:
    """The run folder of a command, with a word on the pieces in it.

    The block ends early where only a shard was asked for. Where it is interrupted the finished
    pieces stay, and the same command goes on from them. `parts`: files of shards to read.
    """
    values = resolved(scene)
    path = request.folder(command.name)
    key = None  # of the pieces: all that decides their numbers
    if command.keeps_pieces(scene):
        sections = ("follower", "cam", "run", command.name)
        deciding = {name: values[name] for name in sections if name in values}
        key = {"command": command.name, "scene": deciding}
    names = [*command.artefacts]
    names += [f"{name}.{kind}" for name in command.pictures for kind in scene.plot.formats]
    with run_folder(
        path, key, threads=request.threads, cluster=cluster, shard=shard, parts=parts,
        names=names, about={"scene": values, "plot": not request.no_plot},
    ) as folder:  # fmt: skip
        checkpoint = folder.work.checkpoint
        if folder.mixed and not request.quiet:
            found = f"of a run that was killed while it put them there ({', '.join(folder.mixed)})"
            note(f"{path}/ holds files {found}: they are made anew")
        if checkpoint is not None and not request.quiet:
            _tell_of_pieces(folder, bool(parts))
        try:
            yield folder
        except KeyboardInterrupt:
            if checkpoint is not None and checkpoint.pieces and not folder.committed:
                note(f"{_on_disk(checkpoint.pieces)}, the same command goes on from them")
            raise
    if folder.shard_done and checkpoint is not None:
        _tell_of_shard(command, shard, folder, checkpoint.path, request)


def _tell_of_shard(
    command: Command, shard: Shard | None, folder: RunFolder, pieces: Path, request: Request
) -> None:
    """Say that a shard is complete; pieces: the file that has them."""
    faults = fault_records(folder.work.faults)
    tell_faults(faults, pieces)
    if request.json:
        answer: dict[str, Any] = {"command": command.name, "shard": shard, "pieces": str(pieces)}
        if faults:
            answer["piece_faults"] = faults
        print(to_text(answer))
    elif not request.quiet:
        again = " (it tries again what failed)" if faults else ""
        merge = f"run cam merge {folder.folder}{again}"
        note(f"{pieces}: complete; when all shards are, {merge}")


def _say(result: Result, record: Mapping[str, Any], request: Request, show: Show) -> None:
    """The result on stdout, warnings and troubles on stderr."""
    if request.json:
        print(to_text(record), end="")
    else:
        if result.command in ANSWERING:
            details = record["verdict_details"] if request.verbose else []
            for sentence in (*record["verdict"], *details):
                say(sentence)
        show(result, request.verbose)
        say(f"{request.folder(result.command)}/: {', '.join([*record['artefacts'], RECORD])}")
        if result.system and result.cost.impacts:
            from camcli.words.cost import cost_line

            say(cost_line(record["cost"], record["error"]))
        if "lift_table" in record["error"]:
            from camcli.words.lift_table import bound_line

            say(bound_line(record["error"]["lift_table"]))
    if not (request.quiet and result.complete):
        for text in result.notes:
            note(text)
    for name, panels in result.left_out.items():
        if panels and not request.quiet:
            from camcli.words.figures import no_room

            note(f"note: {name}.{result.scene.plot.formats[0]}: {no_room(panels)}")


def tell_faults(faults: Sequence[Mapping[str, Any]], place: Path | None) -> None:
    """Print a line on each kind of fault of a piece, and how to report them."""
    for line in fault_lines(faults, place):
        note(line)


def fault_lines(faults: Sequence[Mapping[str, Any]], place: Path | None) -> list[str]:
    """A line on each kind of fault of a piece, and how to report them.

    place: of the run.json, None where it is gone.
    """
    lines = []
    for fault in faults:
        pieces = fault["pieces"]
        names = shown(", ".join(pieces[:MOST_PIECES]), MOST_TEXT)
        if len(pieces) > MOST_PIECES:
            names += f" and {len(pieces) - MOST_PIECES} more"
        in_source = f" ({fault['place']})" if fault["place"] else ""
        lines.append(f"fault: {names}: {shown(fault['error'], MOST_TEXT)}{in_source}")
    if faults:
        with_record = "" if place is None else f" with {place}, which has the traceback"
        lines.append(
            f"this is a fault of camcli and cost these pieces alone, please report it{with_record}"
        )
    return lines


def compiling(request: Request) -> AbstractContextManager[Stopwatch]:
    """Say so before the kernel is compiled, and what is not as it should be with its cache."""
    told: set[News] = set()

    def tell(news: News) -> None:
        """Say once what the kernel does before it can run."""
        if news not in told:
            told.add(news)
            note(NEWS[news].format(folder=cache_dir(), numba=version("numba")))

    return stopwatch(None if request.quiet else tell)


def shard_of(text: str | None) -> Shard | None:
    """The shard of --shard I/N; raises SceneError."""
    if text is None:
        return None
    from camcli.parallel import Shard

    number, _, count = text.partition("/")
    if number.isascii() and number.isdigit() and count.isascii() and count.isdigit():
        shard = Shard(int(number), int(count))
        if 1 <= shard.number <= shard.total <= MOST_SHARDS:
            return shard
    expected = f"expected I/N with 1 <= I <= N <= {MOST_SHARDS}"
    raise SceneError(Fault("--shard", "", f"found '{text}'", expected, "e.g. 3/16"))


def _tell(scene: Scene, config: Path | None) -> None:
    """What a user should know before anything is computed."""
    from camcli.words.machine import doubts, lossless_notes

    if config is not None:
        _tell_of_scene_file(config)
    still_made_up = made_up(scene)
    if still_made_up:
        file = f"{config}: " if config is not None else ""
        keys = ", ".join(still_made_up)
        note(f"note: {file}FILL IN: cam init made up {keys}; put your numbers there")
    for text in doubts(scene):
        note(text)
    if scene.cam.kind == "table":
        from camcli.words.lift_table import table_notes

        for text in table_notes(scene):
            note(text)
    for text in lossless_notes(scene):
        note(text)


def _tell_of_scene_file(config: Path) -> None:
    """Note where camcli takes an example of its own, and the lines that are marked CHECK."""
    shipped = here_or_shipped(config)
    if shipped != config:
        note(f"note: there is no {config} here, so camcli takes its own: {shipped}")
    if not config.is_file():
        return
    marked = []
    for number, line in enumerate(config.read_text(errors="replace").splitlines(), 1):
        _, _, comment = line.partition("#")
        if "CHECK" in comment:
            marked.append(str(number))
    if marked:
        lines = f"line {marked[0]}" if len(marked) == 1 else f"lines {', '.join(marked)}"
        note(f"note: {config}: {lines}: CHECK: {CHECKS}")


def _tell_of_unused_speed(name: str, scene: Scene, request: Request) -> None:
    """Note a speed that --set gives to a command which takes its speeds from its own section.

    A scene file is told nothing: other commands read its run.rpm.
    """
    paths = [text.partition("=")[0].strip() for text in request.sets or ()]
    if "run.rpm" in paths and name in OWN_SPEEDS and not getattr(scene, name).vary:
        used = f"cam {name} takes its speeds from {name}.rpm; give --rpm, or set that"
        note(f"note: --set run.rpm is not used: {used}")


def _tell_of_a_crank(name: str, scene: Scene) -> None:
    """Note the range of speeds in rpm of cam and crank, of a scene that says it has a crank."""
    from camcli.words.speeds import of_both_shafts

    section: Any = getattr(scene, name, None)
    if not scene.run.crank or not hasattr(section, "rpm"):
        return
    if section.rpm.model_fields_set & {"start", "stop"} and not getattr(section, "vary", ()):
        note(f"note: {name}.rpm is {of_both_shafts(section.rpm.start, section.rpm.stop)}")
    for axis in getattr(section, "vary", ()):
        if axis.key in OF_THE_SPEED:
            note(f"note: {axis.key} is {of_both_shafts(axis.start, axis.stop)}")


def _on_disk(pieces: int) -> str:
    """How many pieces of a run are kept, as the beginning of a sentence."""
    return f"{plural(pieces, 'piece')} {is_or_are(pieces)} on disk"


def _tell_of_pieces(folder: RunFolder, merging: bool) -> None:
    """Note the pieces that are on disk: ours, a torn one, and those of other runs."""
    checkpoint = folder.work.checkpoint
    assert checkpoint is not None
    all_pieces = folder.folder.glob(f".*{checkpoint.path.suffix}")
    others = [path for path in all_pieces if path != checkpoint.path]
    if others:
        megabytes = sum(path.stat().st_size for path in others) / 1e6
        names = [path.name for path in others[:MOST_NAMES]]
        if len(others) > MOST_NAMES:
            names.append("...")
        work = f"unfinished work of other scenes ({', '.join(names)}; {megabytes:.3g} MB)"
        note(f"{folder.folder}/ keeps {work}")
    if folder.resumed and not merging:
        note(f"going on: {_on_disk(folder.resumed)}")
    if checkpoint.torn:
        verb = is_or_are(checkpoint.torn)
        note(f"a piece was torn: the last {plural(checkpoint.torn, 'byte')} {verb} computed again")
    if checkpoint.damaged:
        verb = is_or_are(checkpoint.damaged)
        note(f"{plural(checkpoint.damaged, 'byte')} on disk {verb} damaged and passed over")
