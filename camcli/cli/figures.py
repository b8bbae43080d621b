"""cam figures: which there are, what must be computed again and why, and the comparison."""

import json
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import asdict, dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from camcli.api import ANALYSES
from camcli.api.command import command_of
from camcli.api.machine import leaves_speeds_open, machine_of, with_values
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS, USAGE, failure, note
from camcli.cli.explore import source_of
from camcli.cli.options import DRAWING, Request, Values, argument, flag, option, refuse_idle
from camcli.cli.panels import check_panels
from camcli.cli.report import progress_bar, table
from camcli.cli.run import check_before, compute, exit_code, fault_lines, open_folder, tell_faults
from camcli.errors import Fault, SceneError, plural
from camcli.interrupts import raise_if_interrupted, signal_came
from camcli.output.certificate_check import CheckedCertificate, check_certificate
from camcli.output.digest import CHAOTIC, REGULAR, SOLVED, Drift, caption, digest, drifts
from camcli.output.gallery import GalleryFigure, page
from camcli.output.program import program_hash
from camcli.output.run_folder import RECORD, run_folder, unchanged
from camcli.parallel import thread_count
from camcli.parallel.helpers import Helpers
from camcli.piece_faults import (
    PieceFault,
    attempt,
    fault_records,
    gather,
    gathering,
    is_foreseen,
    piece,
)
from camcli.scene import Scene, default_scene_path, load_scene
from camcli.words.figures import (
    NO_REFERENCE,
    caption_lacks,
    certificate_refused,
    computed_line,
    drift_line,
    drift_verdict,
    more_drifts,
)

NAME = "figures"
# shared options that mean nothing here
FORMS = ("formats", "width")  # of the options of pictures, those that all figures can share
WITHOUT = ("verbose", "config", "rpm", "points", "no_plot", *sorted({*DRAWING} - {*FORMS}))
STATE, REFERENCES = "figure.json", "reference"
NEW, UNCHANGED, CHECK = "new", "unchanged", "check"
WHOLE = (DONE, NUMERICS)  # exit codes of a run whose artefacts are whole
COMMANDS = (*ANALYSES, "bench")  # what a figure can be
READS = {"explore": ("sweep", "orbits", "basins")}  # commands that read others' sections
FAULTS = "faults.json"  # of pieces: figures, pages, comparisons that nobody foresaw to fail
MOST_DRIFTS = 12  # of a figure shown to people
LARGE = 1_000_000  # bytes: a larger table does not stay, its digest does
SECONDS_BETWEEN_LOOKS = 0.2  # for an interrupt, while figures are at work
UNKNOWN_SECONDS = 1e9  # of a figure that was never computed: it comes first
WORTH_HELPERS = 20.0  # s of figures, many times more than their processes take to start

Groups = dict[str, dict[str, Any]]
Model = TypeVar("Model", bound=BaseModel)


class State(BaseModel):
    """What a figure was made of and how its command ended, as figure.json keeps it."""

    hashes: dict[str, str]
    exit: int = DONE
    notes: list[str] = []
    seconds: float = 0.0
    files: dict[str, str] = {}  # SHA-256
    certificate: CheckedCertificate | None = None
    digest: Groups = {}

    @property
    def values(self) -> dict[str, Any]:
        """All numbers of the digest."""
        return {name: value for group in self.digest.values() for name, value in group.items()}


class Reference(BaseModel):
    """A stored digest, with the hashes of what it was made of."""

    scene: str
    data: str
    seconds: float
    regular: dict[str, Any]
    chaotic: dict[str, Any]
    solved: dict[str, Any]


@dataclass(frozen=True)
class Figure:
    """A scene that is a figure; `hashes` are those of all that its files depend on."""

    name: str
    path: Path
    scene: Scene
    command: str
    hashes: dict[str, str]

    @property
    def title(self) -> str | None:
        """The title that the scene gives it."""
        return None if self.scene.figure is None else self.scene.figure.title

    @property
    def shown_command(self) -> str:
        """What a user types for it."""
        return f"cam {self.command} -c {self.path}"

    @property
    def reference_path(self) -> Path:
        """Where its reference is kept."""
        return self.path.parent / REFERENCES / f"{self.name}.json"


def figures(
    request: Request,
    names: list[str] | None = argument("Figures, e.g. 3.5 or 3.6. Default: all.", "[NAME]..."),
    folder: Path | None = option("Folder of scenes. Default: configs/figures, here or shipped."),
    check: bool = flag("Compute all, and compare with the reference."),
    update_reference: bool = flag("Make this run's numbers the reference."),
) -> int:
    """The figures of the cam-follower example, brought up to date.

    Examples:
      cam figures                              those that have changed
      cam figures 3.6 3.14                     some of them
      cam figures --check                      compared with the reference: long
      cam figures --width 85mm --format pdf    for a journal's column, PDF too

    Files:
      NAME/            artefacts, run.json and figure.json of one figure
      index.html       all pictures with scene, command, numbers and cost
      faults.json      tracebacks of what a fault of camcli cost

    \b
    NAME/           artefacts, run.json and figure.json of one figure; a table beyond 1 MB does not
                    stay, its counts and quantiles in figure.json do: cam rerun NAME -o DIR makes it
                    again
    index.html      all pictures with scene, command, numbers and cost; works offline
    faults.json     where a fault of camcli cost a figure, its comparison or its entry alone: the
                    tracebacks; exit code 1, and the figure is computed again the next time

    \b
    Figures are the scenes in --folder that have a section `figure`: its `command` is run as
    `cam COMMAND -c NAME.yaml -o OUT/NAME`. NAME selects: 3.6 means 3.6a to 3.6f. Reasons to
    compute:
    new               no finished run in the folder
    scene changed     another value of a key that the command reads (titles and comments do not
                      count)
    data changed      another content of a file that the scene names
    program changed   another source of this program
    artefact changed  a file is missing or has another size
    check             --check computes everything
    else unchanged: nothing is computed. Figures run side by side, --threads N at a time, and in
    processes of their own if they take long; no byte of a table or a picture depends on that. One
    that fails costs no other one. An interrupted run keeps what is finished.

    \b
    --check compares with REFERENCE/NAME.json: labels, critical speeds, counts, quantiles. Solved
    numbers may differ by 1e-8 of their value; simulated ones must be the same to the last bit,
    since the kernel's arithmetic is the same everywhere. Where only chaotic motions or last bits
    differ it says `portability broke`, else how far each number has drifted. A drift is exit code
    3. --update-reference writes what was computed as the new reference.

    \b
    The certificate of a figure with proofs, proof.json, is checked by check.py in a process of its
    own: index.html has what it says, with the file's size and its time. One that is not confirmed
    is exit code 3.
    """
    folder = folder or default_folder()
    if update_reference:
        _refuse_beside_update(request, folder, check)
    known = figures_in(folder, request.sets or (), _picture_values(request))
    asked = chosen(known, names or ())
    out = request.folder(NAME)
    why = {figure.name: CHECK if check else reason(figure, out / figure.name) for figure in asked}
    if request.dry_run:
        _show_plan(request, asked, why, out)
        return DONE
    began = perf_counter()
    with gathering() as faults:
        with run_folder(out) as store:
            (out / FAULTS).unlink(missing_ok=True)
            try:
                wanted = [figure for figure in asked if why[figure.name] != UNCHANGED]
                done = _compute(request, wanted, why, out)
            finally:
                entries = [_entry(figure, out / figure.name) for figure in known]
                store.write_text("index.html", [page(entries)])
                store.commit()
        drifted = _drifts(asked, out) if check else []
        lacking: list[str] = []
        for figure in asked:
            name = f"the caption of {figure.name}"
            lacking += piece(name, partial(_lacks, figure, out), [])
    states = {}
    for figure in asked:
        state = read(State, out / figure.name / STATE)
        if state is not None:
            states[figure.name] = state
    if update_reference and len(states) == len(asked):
        update(asked, known, states)
        note(f"{asked[0].reference_path.parent}/: references of {plural(len(asked), 'figure')}")
    seconds = perf_counter() - began
    _show(request, asked, why, done, drifted if check else None, seconds)
    if not request.json:
        print(computed_line(f"{out}/index.html", len(done), len(asked), seconds))
    for text in lacking:
        note(text)
    if faults:
        _write_faults(out, faults)
    codes = [state.exit for state in (*states.values(), *done.values())]
    return _exit_code(codes, bool(drifted or lacking), bool(faults))


def _exit_code(codes: Sequence[int], numbers_differ: bool, has_faults: bool) -> int:
    """The exit code of all figures: the worst; those of figures that are whole count least.

    codes: of the figures.
    """
    worse = {code for code in codes if code not in WHOLE}
    if has_faults:
        worse.add(INTERNAL)
    if worse:
        return max(worse)
    if numbers_differ or NUMERICS in codes:
        return NUMERICS
    return DONE


def _refuse_beside_update(request: Request, folder: Path, check: bool) -> None:
    """Raise SceneError for what means nothing, or does harm, with --update-reference."""
    program = Path(__file__).resolve().parents[1]
    installed = folder.resolve().is_relative_to(program)
    beside = "with --update-reference"
    refuse_idle(
        (check, "--check", beside, "leave it out: a reference just written always agrees"),
        (request.sets, "--set", beside, "change the scenes instead"),
        (installed, "--folder", beside, f"copy {folder} of the installed program first"),
    )


def _show_plan(
    request: Request, asked: Sequence[Figure], why: Mapping[str, str], out: Path
) -> None:
    """Print which figures would be computed, and how long each took the last time."""
    rows = [
        {
            "figure": figure.name,
            "reason": why[figure.name],
            "seconds": last_seconds(figure, out),
            "command": figure.shown_command,
        }
        for figure in asked
    ]
    _print(request, "cam figures, planned; seconds of the last time", rows, {"plan": rows})


# --- which figures there are


def default_folder() -> Path:
    """configs/figures of the folder we are in, a checkout, else of the installed program."""
    here = Path("configs", "figures")
    return here if here.is_dir() else default_scene_path().parent / "figures"


def _picture_values(request: Request) -> Values:
    """What --width and --format set in every scene; the page needs PNGs beside other forms."""
    values = request.picture_values()
    if "plot.formats" in values:
        formats, option_name = values["plot.formats"]
        with_png = list(dict.fromkeys(["png", *formats]))
        values["plot.formats"] = (with_png, option_name)
    return values


def figures_in(folder: Path, sets: Sequence[str] = (), plot: Values | None = None) -> list[Figure]:
    """All figures of a folder, 3.9 before 3.10; raises SceneError with the faults of all scenes.

    sets: texts of --set; plot: what options of pictures set in every scene.
    """

    def by_numbers(path: Path) -> list:
        """A key by which `2` sorts before `10`: the name in parts of digits and others."""
        parts = re.findall(r"\d+|\D+", path.stem)
        return [(int(part), "") if part.isdigit() else (0, part) for part in parts]

    paths = sorted(folder.glob("*.yaml"), key=by_numbers)
    if not paths:
        found = "found no scenes" if folder.is_dir() else "found no such folder"
        raise SceneError(Fault("--folder", str(folder), found, "expected *.yaml", "name another"))
    figures_of_folder = []
    faults = []
    for path in paths:
        try:
            figures_of_folder.append(_figure(path, sets, plot))
        except SceneError as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise SceneError(*faults)
    return figures_of_folder


def _figure(path: Path, sets: Sequence[str], plot: Values | None) -> Figure:
    """A figure from its scene file, with hashes of all that it depends on; raises SceneError.

    sets, plot: see `figures_in`.
    """
    if not path.stem.strip("."):  # its folder would not lie in the output folder
        found = f"found a scene named '{path.name}'"
        cure = "rename it: the folder has its name"
        raise SceneError(Fault(str(path), "", found, "expected a name with a letter", cure))
    scene = load_scene(path, sets, plot)
    if scene.figure is None:
        expected = "expected title and command"
        raise SceneError(Fault(str(path), "figure", "found no such section", expected, "add it"))
    command = scene.figure.command
    if command not in COMMANDS:
        found = f"found the command '{command}'"
        expected = f"expected one of {', '.join(COMMANDS)}"
        raise SceneError(Fault(str(path), "figure.command", found, expected, ""))
    hashes = {
        "scene": _scene_hash(scene),
        "data": getattr(scene.cam, "sha256", None) or "",
        "program": program_hash(pictures=True),
    }
    if command == "explore":
        source = source_of(Request(config=path, sets=list(sets)))
        scene = with_values(scene, "explore", source=source)
    return Figure(name=path.stem, path=path, scene=scene, command=command, hashes=hashes)


def _scene_hash(scene: Scene) -> str:
    """SHA-256 of the command and of what it reads: not of titles, nor of other commands' keys.

    A key that has its default does not count, so that a new one changes no figure. The cam alone
    knows no impacts, and of a run only the speed.
    """
    assert scene.figure is not None
    command = scene.figure.command
    values = scene.model_dump(mode="json", exclude_defaults=True)
    values["cam"].pop("sha256", None)
    not_read = {"figure", *COMMANDS} - {command, *READS.get(command, ())}
    sections = {name: section for name, section in values.items() if name not in not_read}
    if command == "simulate" and scene.simulate.profile_only:
        follower = dict(values["follower"])
        follower.pop("restitution", None)
        sections |= {"run": scene.run.rpm, "follower": follower}
    text = json.dumps([[command], sections], sort_keys=True, separators=(",", ":"), allow_nan=False)
    return sha256(text.encode()).hexdigest()


def chosen(known: Sequence[Figure], names: Collection[str]) -> list[Figure]:
    """The figures with these names, or with these names and a letter; all without names."""
    if not names:
        return list(known)
    expected = f"expected one of {', '.join(figure.name for figure in known)}"
    wanted: set[str] = set()
    faults = []
    for name in names:
        pattern = re.escape(name) + "[a-z]?"
        matching = {figure.name for figure in known if re.fullmatch(pattern, figure.name)}
        if not matching:
            faults.append(Fault("NAME", "", f"found '{name}'", expected, "or none, for all"))
        wanted |= matching
    if faults:
        raise SceneError(*faults)
    return [figure for figure in known if figure.name in wanted]


# --- what must be computed


def read(model: type[Model], path: Path) -> Model | None:
    """What a file holds; None where there is none, or none that can be read."""
    try:
        return model.model_validate_json(path.read_bytes()) if path.is_file() else None
    except (OSError, ValidationError):
        return None


def reason(figure: Figure, folder: Path) -> str:
    """Why the figure must be computed, or `unchanged`."""
    state = read(State, folder / STATE)
    if state is None:
        return NEW
    for key, value in figure.hashes.items():
        if state.hashes.get(key) != value:
            return f"{key} changed"
    return UNCHANGED if unchanged(folder, state.files) == state.files else "artefact changed"


def last_seconds(figure: Figure, out: Path) -> float | None:
    """Seconds it took last time, here or where the reference was made."""
    here, there = out / figure.name / STATE, figure.reference_path
    known = read(State, here) or read(Reference, there)
    return known.seconds if known else None


def _computed(figure: Figure, request: Request) -> State:
    """Compute a figure into the folder of the request; one whose artefacts are whole is finished.

    What is foreseen to fail, in its scene or for want of memory or disk, costs this figure alone.
    """
    folder = request.folder(figure.command)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / STATE).unlink(missing_ok=True)  # until it is whole again
    began = perf_counter()
    try:
        done = _drawn(figure, request)
    except SceneError as error:
        notes = [str(fault) for fault in error.faults]
        done = State(hashes=figure.hashes, exit=USAGE, notes=notes)
    except Exception as error:
        if signal_came() or not is_foreseen(error):
            raise
        code, faults = failure(error)
        done = State(hashes=figure.hashes, exit=code, notes=[str(fault) for fault in faults])
    done = done.model_copy(update={"seconds": round(perf_counter() - began, 3)})
    if done.exit in WHOLE:
        _finish(folder, done)
    return done


def _drawn(figure: Figure, request: Request) -> State:
    """Run the command of a figure, and write its artefacts."""
    command = command_of(figure.command)
    scene = figure.scene
    if leaves_speeds_open(scene, command.name):
        scene = machine_of(scene).scene
    folder = request.folder(command.name)
    check_panels(command.name, scene, request)
    check_before(command, scene, folder, drawn=True)
    with open_folder(command, scene, request) as store:
        result, record = compute(command, scene, request, store, plot=True)
        numbers = digest(result.tables, record["result"])  # while what is on disk is still there
    notes = [] if result.complete else list(result.notes)
    notes += fault_lines(record["piece_faults"], folder / RECORD)
    code = exit_code(result, record)
    certificate = check_certificate(folder)
    if certificate is not None and not certificate.confirmed:
        notes.append(certificate_refused(certificate.lines))
        if code == DONE:  # a fault of camcli is worse, and the figure is not whole
            code = NUMERICS
    return State(
        hashes=figure.hashes, exit=code, notes=notes, digest=numbers, certificate=certificate
    )


def _finish(folder: Path, done: State, large: int = LARGE) -> None:
    """Write figure.json, and remove the tables of more than `large` bytes: the digest stays."""
    for path in folder.glob("*.csv"):
        if path.stat().st_size > large:
            path.unlink()
    paths = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name[0] != "."]
    files = {path.name: sha256(path.read_bytes()).hexdigest() for path in paths}
    state = done.model_copy(update={"files": files})
    with run_folder(folder) as store:
        store.write_text(STATE, [state.model_dump_json(indent=1)])
        store.commit()


def _compute(
    request: Request, wanted: Sequence[Figure], why: Mapping[str, str], out: Path
) -> dict[str, State]:
    """Run the figures, as many at a time as there are threads, the longest first.

    Most of a figure is work that only one thread of a process can do at a time, so those that take
    long have a process for each thread. Each is marked as finished at once. On an interrupt no more
    are begun, and those at work end with this process; their finished pieces stay on disk. Where
    nobody watches the bar, each has a line.
    """
    seconds = {figure.name: last_seconds(figure, out) or UNKNOWN_SECONDS for figure in wanted}
    longest_first = sorted(wanted, key=lambda figure: -seconds[figure.name])
    count = thread_count(request.threads)
    threads_of_each = max(1, count // max(1, len(wanted)))
    request_of_each = replace(request, quiet=True, threads=threads_of_each)
    known = sum(x for x in seconds.values() if x < UNKNOWN_SECONDS)
    at_a_time = min(count, len(wanted))
    helpers = Helpers(at_a_time) if at_a_time > 1 and known > WORTH_HELPERS else None
    finished = 0
    faults = dict[str, PieceFault]()

    def compute_one(figure: Figure) -> State:
        """Compute a figure and say so; a fault of camcli costs this figure alone."""
        nonlocal finished
        name = figure.name
        own_request = replace(request_of_each, out=out / name)
        compute_it = _computed if helpers is None else partial(helpers.call, _computed)
        state = attempt(name, lambda: compute_it(figure, own_request))
        if isinstance(state, PieceFault):
            faults[name] = state
            state = State(hashes=figure.hashes, exit=INTERNAL, notes=["fault, see below"])
        finished += 1
        if progress is not None:
            progress("figures", finished, len(wanted))
        elif not request.quiet:
            code = "" if state.exit == DONE else f", exit code {state.exit}"
            note(f"{name}: {why[name]}, {state.seconds:.1f} s{code}")
        return state

    with progress_bar(request.quiet) as progress:
        pool = ThreadPoolExecutor(count)
        try:
            running = {figure.name: pool.submit(compute_one, figure) for figure in longest_first}
            pending = set(running.values())
            while pending:
                ended, pending = wait(pending, timeout=SECONDS_BETWEEN_LOOKS)
                raise_if_interrupted()
                for future in ended:
                    future.result()  # raises what it has raised
            done = {name: future.result() for name, future in running.items()}
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            if helpers is not None:
                helpers.end()
    gather(faults[name] for name in running if name in faults)
    for name, state in done.items():
        if state.exit == DONE:
            continue
        for line in state.notes or [f"exit code {state.exit}"]:
            note(f"{name}: {line}")
    return done


# --- references


def update(asked: Sequence[Figure], known: Sequence[Figure], states: dict[str, State]) -> None:
    """Write the references of these figures; remove those of no known one."""
    folder = asked[0].reference_path.parent
    with run_folder(folder) as store:
        for figure in asked:
            state = states[figure.name]
            hashes = {key: figure.hashes[key] for key in ("scene", "data")}
            text = {**hashes, "seconds": round(state.seconds, 1), **state.digest}
            store.write_text(f"{figure.name}.json", [json.dumps(text, indent=0) + "\n"])
        store.commit()
    for path in folder.glob("*.json"):
        if path.stem not in {figure.name for figure in known}:
            path.unlink()


def compared(figure: Figure, state: State) -> list[Drift]:
    """Every number of a figure that differs from the stored reference.

    A reference that is missing or cannot be read is one such difference.
    """
    path = figure.reference_path
    reference = read(Reference, path)
    if reference is None:
        why = "cannot be read: restore it, or cam figures --update-reference"
        if not path.exists():
            how = f"cam figures {figure.name} --folder {figure.path.parent} --update-reference"
            why = f"{NO_REFERENCE} ({how} makes it)"
        return [Drift(figure=figure.name, group=SOLVED, name=str(path), reference=None, found=why)]
    old = {group: getattr(reference, group) for group in (REGULAR, CHAOTIC, SOLVED)}
    of_numbers = list(drifts(figure.name, old, state.digest))
    of_hashes = [
        Drift(
            figure=figure.name,
            group=REGULAR,
            name=f"hash of the {key}",
            reference=was[:12],
            found=figure.hashes[key][:12],
        )
        for key, was in (("scene", reference.scene), ("data", reference.data))
        if was != figure.hashes[key]
    ]
    if of_hashes:  # another scene explains any number: it need not be another machine's bits
        of_numbers = [replace(drift, portability=False) for drift in of_numbers]
    return of_hashes + of_numbers


def _drifts(asked: Sequence[Figure], out: Path) -> list[Drift]:
    """Every number that differs from its reference, of the figures that are finished."""
    drifted: list[Drift] = []
    for figure in asked:
        state = read(State, out / figure.name / STATE)
        if state is not None:
            name = f"the comparison of {figure.name}"
            drifted += piece(name, partial(compared, figure, state), [])
    return drifted


def verdict(drifted: Sequence[Drift]) -> str:
    """One line on what the drifts mean together."""
    missing = [drift for drift in drifted if str(drift.found).startswith(NO_REFERENCE)]
    moved = [drift for drift in drifted if drift not in missing]
    figures = len({drift.figure for drift in moved})
    explained_by_other_bits = sum(drift.portability for drift in moved)
    return drift_verdict(len(moved), figures, explained_by_other_bits, len(missing))


# --- what is shown


def _write_faults(out: Path, faults: Sequence[PieceFault]) -> None:
    """Say what failed, and keep the tracebacks."""
    records = fault_records(faults)
    with run_folder(out) as store:
        store.write_text(FAULTS, [json.dumps(records, indent=1) + "\n"])
        store.commit()
    tell_faults(records, out / FAULTS)


def _lacks(figure: Figure, out: Path) -> list[str]:
    """A sentence where the caption of a finished figure names a number that its run lacks."""
    state = read(State, out / figure.name / STATE)
    if state is None:
        return []
    assert figure.scene.figure is not None
    try:
        caption(figure.scene.figure.shows, state.values)
    except KeyError as name:
        return [f"{figure.path}: figure.shows: {caption_lacks(name)}"]
    return []


def _entry(figure: Figure, folder: Path) -> GalleryFigure:
    """A figure as the page shows it; one that fails there has its name alone."""
    bare = GalleryFigure(
        name=figure.name,
        title=figure.name,
        caption="",
        command=figure.shown_command,
        scene="",
        folder=folder,
    )
    return piece(f"the entry of {figure.name} in index.html", partial(_shown, figure, folder), bare)


def _shown(figure: Figure, folder: Path) -> GalleryFigure:
    """A figure as the gallery shows it, from what its last run left in the folder."""
    about = figure.scene.figure
    state = read(State, folder / STATE)
    assert about is not None
    text = figure.path.read_text(encoding="utf-8-sig")
    shown = GalleryFigure(
        name=figure.name,
        title=about.title,
        caption="",
        command=figure.shown_command,
        scene=text,
        folder=folder,
    )
    if state is None:
        return shown
    try:
        words = caption(about.shows, state.values)
    except KeyError as name:
        words = caption_lacks(name)
    return replace(
        shown,
        caption=words,
        files=list(state.files),
        seconds=state.seconds,
        notes=state.notes,
        certificate=state.certificate,
        printed={name: (value, state.values.get(name)) for name, value in about.printed.items()},
    )


def _print(request: Request, title: str, rows: list[dict[str, Any]], more: dict[str, Any]) -> None:
    """Rows as one JSON object with `more`, or as a table for people."""
    if request.json:
        print(json.dumps({"command": NAME, **more}, indent=2))
        return
    cells = [["" if value is None else str(value) for value in row.values()] for row in rows]
    table(title, list(rows[0]) if rows else [], cells)


def _show(
    request: Request,
    asked: Sequence[Figure],
    why: Mapping[str, str],
    done: Mapping[str, State],
    drifted: Sequence[Drift] | None,
    seconds: float,
) -> None:
    """Print a table of the figures and how their commands ended.

    why: the reason to compute each figure; done: how those that were computed ended; drifted: what
    differs from the reference, None where nothing was compared; seconds: for all.
    """
    rows = []
    for figure in asked:
        state = done.get(figure.name, State(hashes={}))
        rows.append({
            "figure": figure.name,
            "title": figure.title,
            "reason": why[figure.name],
            "seconds": state.seconds,
            "exit": state.exit,
        })  # fmt: skip
    more: dict[str, Any] = {"figures": rows, "seconds": seconds}
    if drifted is not None:
        more |= {"verdict": verdict(drifted), "drifts": [asdict(drift) for drift in drifted]}
    _print(request, plural(len(asked), "figure"), rows, more)
    if drifted and request.quiet:
        _print_drifts(drifted, note)  # a drift is a fault, and those are said to the quiet too
    elif drifted is not None and not request.json:
        _print_drifts(drifted, print)


def _print_drifts(drifted: Sequence[Drift], tell: Callable[[str], None]) -> None:
    """The first drifts of each figure, a line each, and what they mean together."""
    for name in dict.fromkeys(drift.figure for drift in drifted):
        of_figure = [drift for drift in drifted if drift.figure == name]
        for drift in of_figure[:MOST_DRIFTS]:
            tell(drift_line(drift, drift.group == CHAOTIC))
        if len(of_figure) > MOST_DRIFTS:
            tell(more_drifts(name, len(of_figure) - MOST_DRIFTS))
    tell(verdict(drifted))
