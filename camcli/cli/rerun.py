"""cam rerun: the run of a run.json again, and whether its bytes agree."""

import json
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    StringConstraints,
    ValidationError,
)

from camcli.api import ANALYSES
from camcli.api.command import command_of
from camcli.cams.files import read_bytes
from camcli.cli.exit_codes import DONE, INTERNAL, NUMERICS, note
from camcli.cli.options import DRAWING, SCENE, Request, argument, option
from camcli.cli.report import table
from camcli.cli.run import check_before, compute, tell_faults
from camcli.errors import Fault, SceneError, shown
from camcli.output.program import program_hash
from camcli.output.run_folder import RECORD, run_folder, unchanged
from camcli.scene import Scene, load_scene
from camcli.scene.schema import PictureFormat
from camcli.words.rerun import (
    CHANGED,
    MISSING,
    ONLY_PICTURES,
    OTHER,
    OTHER_PROGRAM,
    SAME,
    SAME_TROUBLE,
    rerun_title,
)

HOME = option("Where the files are that the scene names.", "DIR")
REPEATED = (*SCENE, "dry_run")  # these stand in the record
WITHOUT = (*REPEATED, "no_plot", "verbose", *DRAWING)  # the record says whether it drew
MOST_BYTES = 64 * 10**6  # of a run.json
PICTURES = (*get_args(PictureFormat), "gif", "mp4")  # endings of files that are drawn
EXPECTED, CURE = "expected the run.json of a run", "give that of a folder made with -o"
ARTEFACT = StringConstraints(pattern=r"^[a-zA-Z0-9_-]{1,64}\.[a-z0-9]{1,8}$")


def rerun(
    request: Request,
    record: Path = argument("A run.json, or its folder.", "FILE", ...),
    folder: Path | None = HOME,
) -> int:
    """Run again what a run.json records: do the bytes agree?

    Examples:
      cam rerun out/sweep/run.json             do the bytes agree?
      cam rerun out/sweep -o again             and keep what was computed

    \b
    Exit code 0 where the bytes agree, of a run that ended with 3 as well, and 3 where a CSV
    differs. Artefacts go to a temporary folder, or to -o. For all commands but bench and figures;
    the folder of one figure is a run. A lift table is looked for beside FILE, or in --folder.
    """
    record = record / "run.json" if record.is_dir() else record
    old = read_record(record)
    scene = old.load(folder, record.parent, str(record))
    command = command_of(old.command)
    still_there = {name for name in old.artefacts if (record.parent / name).is_file()}
    changed = still_there - set(unchanged(record.parent, old.artefacts))
    with ExitStack() as stack:
        out = request.out
        if out is None:
            out = Path(stack.enter_context(TemporaryDirectory(prefix="cam-rerun-")))
        check_before(command, scene, out, old.draws)
        store = stack.enter_context(
            run_folder(out, threads=request.threads, names=[*command.artefacts])
        )
        result, new = compute(command, scene, request, store, old.draws)
    verdicts = {}
    for name, sha256 in old.artefacts.items():
        if name not in new["artefacts"]:
            verdicts[name] = MISSING
        elif new["artefacts"][name] != sha256:
            verdicts[name] = OTHER
        elif name in changed:
            verdicts[name] = CHANGED
        else:
            verdicts[name] = SAME
    differing = [name for name, verdict in verdicts.items() if verdict != SAME]
    if request.json:
        answer = {"command": old.command, "same": not differing, "artefacts": verdicts}
        print(json.dumps(answer, indent=2))
    else:
        title = rerun_title(old.command, not differing)
        table(title, ["artefact", "verdict"], [list(row) for row in verdicts.items()])
    if differing and old.program_sha256 != program_hash():
        note(OTHER_PROGRAM)
    if new["piece_faults"]:
        tell_faults(new["piece_faults"], None if request.out is None else out / RECORD)
        return INTERNAL
    if any(name.rpartition(".")[2] not in PICTURES for name in differing):
        return NUMERICS
    if differing and not changed:
        note(ONLY_PICTURES)
    if not result.complete:
        note(SAME_TROUBLE)
    return DONE


# --- what a run.json, or the key of a run's pieces, says of the run: enough to do it again


EARLIER = {  # what stood beside the scene in a run.json of earlier versions, and where it is now
    "profile_only": "simulate.profile_only",
    "base_radius": "simulate.base_radius",
    "animate": "simulate.animate",
    "report": "detach.report",
    "prove": "orbits.prove",
    "chaos": "orbits.chaos",
    "with_basins": "explore.basins",
    "with_map": "explore.map",
    "source": "explore.source",
}


def _can_be_rerun(command: str) -> str:
    """The name of a command whose run.json says enough; that of bench does not."""
    if command == "bench":
        raise ValueError("a bench measures seconds, which are others each time: repeat cam bench")
    if command not in ANALYSES:
        raise ValueError(f"expected {', '.join(ANALYSES)}")
    return command


class Record(BaseModel):
    """A run; the rest of a run.json is not read."""

    command: Annotated[str, AfterValidator(_can_be_rerun)]
    scene: dict[str, Any]
    result: dict[str, Any] = {}
    options: dict[str, Any] = {}  # of earlier versions
    artefacts: dict[Annotated[str, ARTEFACT], str] = {}
    program_sha256: str = ""

    @property
    def draws(self) -> bool:
        """Whether the run drew a picture."""
        pictures = command_of(self.command).pictures
        endings = get_args(PictureFormat)
        return any(f"{name}.{kind}" in self.artefacts for name in pictures for kind in endings)

    def load(self, folder: Path | None, beside: Path, name: str = "scene") -> Scene:
        """Its scene, files that it names in a folder of the user's, else `beside` the record.

        Only there the user has allowed to look. Raises SceneError, which calls the scene `name`.
        """
        cam = self.scene.get("cam")
        outside = isinstance(cam, dict) and cam.get("allow_outside") is True
        values: dict[str, Any] = {}
        if folder is not None and outside:
            values["cam.allow_outside"] = True
        for key, value in self.options.items():
            if key != "plot":
                values[EARLIER.get(key, f"options.{key}")] = value
        try:
            return load_scene(self._as_stated(), values, folder=folder or beside)
        except SceneError as error:
            faults = []
            for fault in error.faults:
                if fault.path == "cam.allow_outside" or "no such file" in fault.found:
                    fault = replace(fault, cure="say with --folder where it is")
                if fault.where == "scene":
                    fault = replace(fault, where=name)
                faults.append(fault)
            raise SceneError(*faults) from None

    def _as_stated(self) -> dict[str, Any]:
        """The scene without the speed of the run where cam detach took it for the default.

        A record holds the defaults too, and cam detach tells what happens at a speed that the scene
        states, and at no other.
        """
        run = self.scene.get("run")
        if self.command != "detach" or "working" in self.result or not isinstance(run, dict):
            return self.scene
        without_speed = {key: value for key, value in run.items() if key != "rpm"}
        return {**self.scene, "run": without_speed}


def record_of(text: str | bytes, path: Path) -> Record:
    """The record; raises SceneError where the text is none."""
    try:
        return Record.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        words = shown(first["msg"].removeprefix("Value error, "), 300)
        keys = [shown(str(key)) for key in first["loc"]]
        reason = ": ".join([*keys, words])
        raise _unreadable(path, f"cannot be read ({reason})") from None


def read_record(path: Path) -> Record:
    """The record in a file; raises SceneError where it is none of artefacts, or a giant."""
    record = record_of(read_bytes(path, str(path), MOST_BYTES, EXPECTED, CURE), path)
    if not record.artefacts:
        raise _unreadable(path, "found no artefacts in it")
    return record


def _unreadable(path: Path, found: str) -> SceneError:
    """The fault of a file that is no run.json, with what was found."""
    return SceneError(Fault(str(path), "", found, EXPECTED, CURE))
