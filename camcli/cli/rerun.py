"""cam rerun: the run of a run.json again, and whether its bytes agree."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import redirect_stdout
from dataclasses import replace
from importlib import import_module
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, StringConstraints, TypeAdapter, ValidationError

from camcli.cli.exit_codes import NUMERICS, note
from camcli.cli.options import HOW, Request
from camcli.cli.report import table
from camcli.errors import Fault, SceneError, shown
from camcli.output.program import program_hash
from camcli.output.run_folder import RECORD

NAME = "rerun"
MOST_BYTES = 64 << 20  # of a run.json
ARTEFACT = StringConstraints(pattern=r"^[a-zA-Z0-9_-]{1,64}\.[a-z]{1,8}$")
SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"


class Record(BaseModel):
    """What a run.json says of a run, and the key of its pieces too; the rest of it is not read."""

    command: Literal["simulate", "sweep", "detach", "orbits", "basins", "classify"]
    scene: dict[str, Any]
    options: dict[str, Any]
    artefacts: dict[Annotated[str, ARTEFACT], str] = {}
    program_sha256: str = ""


def run(request: Request) -> int:
    """Run it again and compare; exit code 3 where bytes differ that should not."""
    path = request.extra["record"]
    record = record_of(_text(path), path)
    if not record.artefacts:
        raise _refusal(path, "found no artefacts in it")
    if request.out is not None:
        return _compare(request, path, record, request.out)
    with TemporaryDirectory(prefix="cam-rerun-") as folder:
        return _compare(request, path, record, Path(folder))


def _compare(request: Request, path: Path, record: Record, out: Path) -> int:
    home = request.extra["folder"] or path.parent
    again, call = call_of(record, request, out, home)
    again = replace(again, no_plot=not record.options.get("plot", True), json=False)
    with redirect_stdout(StringIO()):
        code = call(again)
    now = json.loads((out / RECORD).read_text())["artefacts"]
    verdicts = {
        name: MISSING if name not in now else SAME if now[name] == digest else OTHER
        for name, digest in record.artefacts.items()
    }
    differ = [name for name, verdict in verdicts.items() if verdict != SAME]
    if request.json:
        same = not differ
        said = {"command": record.command, "same": same, "artefacts": verdicts}
        print(json.dumps(said, indent=2))
    else:
        title = f"cam {record.command} again: {'bytes differ' if differ else 'the same bytes'}"
        table(title, ["artefact", "verdict"], [list(row) for row in verdicts.items()])
    if differ and record.program_sha256 != program_hash():
        note("the record is of another version of this program")
    if any(not name.endswith(".png") for name in differ):
        return NUMERICS
    if differ:
        note("only pictures differ: their bytes are the same on the same installation alone")
    return code


def call_of(
    record: Record, request: Request, out: Path, home: Path, parts: tuple[Path, ...] = ()
) -> tuple[Request, Callable[[Request], int]]:
    """(request, function) that run the command of a record again, with artefacts into `out`.

    home: the folder that holds the files the scene names; of the request at hand --no-plot, --json,
    --quiet and --threads are kept. Raises SceneError for options of another kind.
    """
    from camcli.cli.app import COMMANDS

    extra: dict[str, Any] = dict.fromkeys(HOW)
    for key, (annotated, default) in COMMANDS[record.command][1].items():
        if key not in HOW:
            given = record.options.get(key, default)
            try:
                kind = TypeAdapter(get_args(annotated)[0])
                extra[key] = kind.validate_python(given, strict=True)
            except ValidationError as error:
                found = f"found {shown(str(given))} for the option {key}"
                raise SceneError(Fault("FILE", "", found, _said(error), "name another")) from None
    again = replace(
        request, config=None, sets=[], rpm=None, points=None, out=out, extra=extra,
        scene=record.scene, home=home, parts=parts, dry_run=False,
    )  # fmt: skip
    run = import_module(f"camcli.cli.{record.command}").run

    def call(asked: Request) -> int:
        try:
            return run(asked)
        except SceneError as error:
            raise SceneError(*map(_say_where, error.faults)) from None

    return again, call


def _say_where(fault: Fault) -> Fault:
    """Where a file that the scene names is missing, --folder is the cure."""
    lost = fault.path == "cam.file" and "no such file" in fault.found
    return replace(fault, cure="say with --folder where it is") if lost else fault


def record_of(text: str | bytes, path: Path) -> Record:
    """The record; raises SceneError where the text is none."""
    try:
        return Record.model_validate_json(text)
    except ValidationError as error:
        raise _refusal(path, f"cannot be read ({_said(error)})") from None


def _said(error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    return ": ".join([*(shown(str(key)) for key in first["loc"]), first["msg"]])


def _text(path: Path) -> bytes:
    """The bytes of a file; raises SceneError where it is none, or a giant."""
    try:
        if not path.is_file():
            path.stat()  # says what is wrong where there is nothing
            raise _refusal(path, "cannot be read (no file)")
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise _refusal(path, f"cannot be read ({error.strerror})") from None
    if len(data) > MOST_BYTES:
        raise _refusal(path, "cannot be read (too large)")
    return data


def _refusal(path: Path, found: str) -> SceneError:
    return SceneError(Fault("FILE", str(path), found, "expected the run.json of a run", ""))
