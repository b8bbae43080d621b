"""cam rerun: the run of a run.json again, and whether its bytes agree."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from camcli.cli.exit_codes import NUMERICS, note
from camcli.cli.long_run import PASSING
from camcli.cli.options import Request
from camcli.cli.repeat import call_of
from camcli.cli.report import table
from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash

NAME = "rerun"
MOST_BYTES = 64 << 20  # of a run.json
NAMES = re.compile(r"[a-zA-Z0-9_-]{1,64}\.[a-z]{1,8}")  # of artefacts
SAME, OTHER, MISSING = "same bytes", "other bytes", "not made"


def run(request: Request) -> int:
    """Run it again and compare; exit code 3 where bytes differ that should not."""
    path = request.extra["record"]
    record = _read(path)
    if request.out is not None:
        return _compare(request, path, record, request.out)
    with TemporaryDirectory(prefix=PASSING) as folder:
        return _compare(request, path, record, Path(folder))


def _compare(request: Request, path: Path, record: Mapping[str, Any], out: Path) -> int:
    home = request.extra["folder"] or path.parent
    drawn = bool(record["options"].get("plot", True))
    again, call = call_of(record, request, out, home)
    again = replace(again, no_plot=not drawn, json=False)
    with redirect_stdout(StringIO()):
        code = call(again)
    made = json.loads((out / "run.json").read_text())["artefacts"]
    verdicts = {name: _verdict(name, record["artefacts"], made) for name in record["artefacts"]}
    _show(request, record, verdicts)
    differ = [name for name, verdict in verdicts.items() if verdict != SAME]
    if differ and record.get("program_sha256") != program_hash():
        note("the record is of another version of this program")
    if any(not name.endswith(".png") for name in differ):
        return NUMERICS
    if differ:
        note("only pictures differ: their bytes are the same on the same installation alone")
    return code


def _verdict(name: str, before: Mapping[str, str], now: Mapping[str, str]) -> str:
    if name not in now:
        return MISSING
    return SAME if now[name] == before[name] else OTHER


def _show(request: Request, record: Mapping[str, Any], verdicts: Mapping[str, str]) -> None:
    same = all(verdict == SAME for verdict in verdicts.values())
    if request.json:
        result = {"command": record["command"], "same": same, "artefacts": verdicts}
        print(json.dumps(result, indent=2))
        return
    title = f"cam {record['command']} again: " + ("the same bytes" if same else "bytes differ")
    table(title, ["artefact", "verdict"], [[name, verdict] for name, verdict in verdicts.items()])


def _read(path: Path) -> dict[str, Any]:
    """The record; raises SceneError where the file is none."""
    try:
        record = json.loads(_text(path))
        if not _is_whole(record):
            raise ValueError("no scene, options and artefacts in it")
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or f"{type(error).__name__}: {error}"
        expected = "expected the run.json of a run"
        fault = Fault("FILE", str(path), f"cannot be read ({reason})", expected, "name another")
        raise SceneError(fault) from None
    return record


def _text(path: Path) -> str:
    if not path.is_file():
        path.stat()  # says what is wrong where there is nothing
        raise ValueError("no file")
    with open(path, "rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise ValueError("too large")
    return data.decode()


def _is_whole(record: Any) -> bool:
    if not isinstance(record, dict):
        return False
    if not all(isinstance(record.get(key), dict) for key in ("scene", "options", "artefacts")):
        return False
    hashes = record["artefacts"]
    return bool(hashes) and all(
        NAMES.fullmatch(k) and isinstance(v, str) for k, v in hashes.items()
    )
