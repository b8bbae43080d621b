"""cam merge: the artefacts of a run whose pieces were computed in shards."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from camcli.cli.long_run import MOST_SHARDS
from camcli.cli.options import Request
from camcli.cli.rerun import call_of
from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash
from camcli.output.run_folder import PIECES
from camcli.parallel.checkpoint import key_of

NAME = "merge"
SHOWN = 10  # missing shards named


def run(request: Request) -> int:
    """Join the parts, compute what needs all of them, and write the artefacts; the exit code."""
    paths = _paths(request.extra["parts"] or [Path("out")])
    what = _common_key(paths)
    out = request.out or paths[0].parent
    home = request.extra["folder"] or Path()
    request, call = call_of(what, request, out, home, tuple(paths))
    return call(request)


def _paths(given: Sequence[Path]) -> list[Path]:
    """The files named, or those in the folders named; raises SceneError where there are none."""
    found: list[Path] = []
    for path in given:
        found += sorted(path.rglob(f"*-of-*{PIECES}")) if os.path.isdir(path) else [path]
    if not found:
        expected = f"expected files COMMAND-I-of-N{PIECES}, made by --shard I/N"
        where = ", ".join(map(str, given))
        raise _refusal(where, "found no parts", "name the folder they are in", expected)
    return found


def _common_key(paths: Sequence[Path]) -> dict[str, Any]:
    """What all parts belong to; raises SceneError unless each is there once, complete and ours."""
    first: dict[str, Any] = {}
    numbers: dict[int, dict[int, Path]] = {}  # by the number of parts
    for path in paths:
        try:
            text, end = key_of(path)
        except OSError as error:
            found = f"cannot be read ({error.strerror})"
            raise _refusal(path, found, "leave it out", "expected a file of --shard I/N") from None
        key = _values(text)
        if not {"command", "scene", "options", "program"} <= key.keys():
            raise _refusal(path, "found no description of a run", "leave it out")
        first = first or key
        if key != first:
            other = ", ".join(f"another {name}" for name in first if key.get(name) != first[name])
            found = f"found pieces of other work than in {paths[0]} ({other})"
            cure = "merge each on its own; every shard needs the same scene, options and version"
            raise _refusal(path, found, cure)
        match end:
            case [int(number), int(count)] if 1 <= number <= count <= MOST_SHARDS:
                twin = numbers.setdefault(count, {}).setdefault(number, path)
            case _:
                cure = "run the same command again, it goes on"
                raise _refusal(path, "found a part not complete", cure)
        if twin is not path:
            raise _refusal(path, f"found part {number} of {count} in {twin} too", "leave one out")
    if first["program"] != program_hash():
        cure = "merge with the version that computed the parts"
        raise _refusal(paths[0], "found pieces of another version of this program", cure)
    _refuse_missing(numbers)
    return first


def _values(text: str) -> dict[str, Any]:
    try:
        values = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return values if isinstance(values, dict) else {}


def _refuse_missing(numbers: dict[int, dict[int, Path]]) -> None:
    """Raise SceneError unless these are all parts of one division."""
    if len(numbers) != 1:
        found = f"found parts of {' and of '.join(map(str, sorted(numbers)))}"
        cure = "merge parts of one division"
        raise _refusal("", found, cure, "expected one number of parts")
    ((count, present),) = numbers.items()
    if len(present) < count:
        missing = list(islice((n for n in range(1, count + 1) if n not in present), SHOWN + 1))
        names = ", ".join(map(str, missing[:SHOWN])) + (", ..." if len(missing) > SHOWN else "")
        found = f"found {len(present)} of {count} parts, {names} missing"
        raise _refusal("", found, "run --shard of those too", "expected all")


def _refusal(path: Path | str, found: str, cure: str, expected: str = "") -> SceneError:
    return SceneError(Fault("PART", str(path), found, expected, cure))
