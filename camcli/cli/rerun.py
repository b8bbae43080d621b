"""cam rerun: the run of a run.json again, and whether its bytes agree."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import replace
from importlib import import_module
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, get_args, get_origin

from camcli.cli.exit_codes import NUMERICS, note
from camcli.cli.options import HOW, Request
from camcli.cli.report import table
from camcli.errors import Fault, SceneError, shown
from camcli.output.program import program_hash
from camcli.output.run_folder import RECORD

NAME = "rerun"
COMMANDS = ("simulate", "sweep", "detach", "orbits", "basins", "classify")
DEEPEST = 32  # levels of a scene
MOST_BYTES = 64 << 20  # of a run.json
NAMES = re.compile(r"[a-zA-Z0-9_-]{1,64}\.[a-z]{1,8}")  # of artefacts
SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"


def run(request: Request) -> int:
    """Run it again and compare; exit code 3 where bytes differ that should not."""
    path = request.extra["record"]
    record = _read(path)
    if request.out is not None:
        return _compare(request, path, record, request.out)
    with TemporaryDirectory(prefix="cam-rerun-") as folder:
        return _compare(request, path, record, Path(folder))


def _compare(request: Request, path: Path, record: Mapping[str, Any], out: Path) -> int:
    home = request.extra["folder"] or path.parent
    again, call = call_of(record, request, out, home)
    again = replace(again, no_plot=not record["options"].get("plot", True), json=False)
    with redirect_stdout(StringIO()):
        code = call(again)
    before, now = record["artefacts"], json.loads((out / RECORD).read_text())["artefacts"]
    verdicts = {
        name: MISSING if name not in now else SAME if now[name] == before[name] else OTHER
        for name in before
    }
    differ = [name for name, verdict in verdicts.items() if verdict != SAME]
    if request.json:
        same = not differ
        said = {"command": record["command"], "same": same, "artefacts": verdicts}
        print(json.dumps(said, indent=2))
    else:
        title = f"cam {record['command']} again: {'bytes differ' if differ else 'the same bytes'}"
        table(title, ["artefact", "verdict"], [list(row) for row in verdicts.items()])
    if differ and record.get("program_sha256") != program_hash():
        note("the record is of another version of this program")
    if any(not name.endswith(".png") for name in differ):
        return NUMERICS
    if differ:
        note("only pictures differ: their bytes are the same on the same installation alone")
    return code


def call_of(
    what: Mapping[str, Any], request: Request, out: Path, home: Path, parts: tuple[Path, ...] = ()
) -> tuple[Request, Callable[[Request], int]]:
    """(request, function) that run the command of a record again, with artefacts into `out`.

    what: its `command`, `scene` and `options`; home: the folder that holds the files the scene
    names; of the request at hand --no-plot, --json, --quiet and --threads are kept. Raises
    SceneError for a record of another kind.
    """
    command, scene, options = (what.get(key) for key in ("command", "scene", "options"))
    if command not in COMMANDS or not isinstance(scene, dict) or not isinstance(options, dict):
        found = f"found the command {shown(str(command))}"
        expected = f"expected a record of {', '.join(COMMANDS)}"
        raise SceneError(Fault("FILE", "", found, expected, "name the run.json of such a run"))
    if _is_deeper(scene, DEEPEST):
        expected = f"expected at most {DEEPEST} levels"
        raise SceneError(Fault("FILE", "scene", "found too many levels", expected, ""))
    from camcli.cli.app import COMMANDS as KNOWN

    own = {key: option for key, option in KNOWN[command][1].items() if key not in HOW}
    extra = dict.fromkeys(HOW) | {
        key: _option(key, options.get(key, default), kind) for key, (kind, default) in own.items()
    }
    again = replace(
        request, config=None, sets=[], rpm=None, points=None, out=out, extra=extra, scene=scene,
        home=home, parts=parts, dry_run=False,
    )  # fmt: skip
    run = import_module(f"camcli.cli.{command}").run
    return again, lambda asked: _with_its_files(run, asked)


def _with_its_files(run: Callable[[Request], int], request: Request) -> int:
    """Run it; where a file that the scene names is missing, --folder is the cure."""
    try:
        return run(request)
    except SceneError as error:
        cure = "say with --folder where it is"
        raise SceneError(
            *(
                replace(f, cure=cure) if f.path == "cam.file" and "no such file" in f.found else f
                for f in error.faults
            )
        ) from None


def _is_deeper(value: Any, most: int) -> bool:
    if not isinstance(value, dict | list):
        return False
    items = value.values() if isinstance(value, dict) else value
    return most == 0 or any(_is_deeper(item, most - 1) for item in items)


def _option(key: str, value: Any, annotated: Any) -> Any:
    """The value of an option; raises SceneError where the record has one of another type."""
    kind = get_args(annotated)[0]
    allowed = {get_origin(each) or each for each in get_args(kind) or (kind,)}
    if type(value) in allowed or (type(value) is int and float in allowed):
        return value
    names = " or ".join(sorted(each.__name__ for each in allowed))
    found = f"found a {type(value).__name__} for the option {key}"
    raise SceneError(Fault("FILE", "", found, f"expected {names}", "name the record of a run"))


def _read(path: Path) -> dict[str, Any]:
    """The record; raises SceneError where the file is none."""
    try:
        if not path.is_file():
            path.stat()  # says what is wrong where there is nothing
            raise ValueError("no file")
        with open(path, "rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise ValueError("too large")
        record = json.loads(data)
        if not _is_whole(record):
            raise ValueError("no scene, options and artefacts in it")
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
        expected = "expected the run.json of a run"
        fault = Fault("FILE", str(path), f"cannot be read ({reason})", expected, "name another")
        raise SceneError(fault) from None
    return record


def _is_whole(record: Any) -> bool:
    if not isinstance(record, dict):
        return False
    if not all(isinstance(record.get(key), dict) for key in ("scene", "options", "artefacts")):
        return False
    hashes = record["artefacts"]
    return bool(hashes) and all(
        NAMES.fullmatch(k) and isinstance(v, str) for k, v in hashes.items()
    )
