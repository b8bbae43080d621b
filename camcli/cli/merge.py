"""cam merge: the artefacts of a run whose pieces were computed in shards."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from camcli.cli.long_run import MOST_SHARDS, PIECES
from camcli.cli.options import Request
from camcli.cli.repeat import call_of
from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash
from camcli.parallel import Shard
from camcli.parallel.journal import JournalError, header_of, one_of
from camcli.parallel.pieces import END
from camcli.scene.places import shown

NAME = "merge"
SHOWN = 10  # missing shards named


def run(request: Request) -> int:
    """Join the parts, compute what needs all of them, and write the artefacts; the exit code."""
    paths = _paths(request.extra["parts"] or [Path("out")])
    header = _header(paths)
    what = _described(paths[0], header)
    _refuse_missing(paths)
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
        cure = "name the folder they are in"
        where = ", ".join(map(str, given))
        raise SceneError(Fault("PART", where, "found no parts", expected, cure))
    return found


def _header(paths: Sequence[Path]) -> str:
    """What all parts belong to; raises SceneError where they do not belong together."""
    first = None
    for path in paths:
        try:
            header = header_of(path)
        except (JournalError, OSError) as error:
            found = f"cannot be read ({getattr(error, 'strerror', None) or 'no pieces in it'})"
            raise _refusal(path, found, "leave it out", "expected a file of --shard I/N") from None
        first = header if first is None else first
        if header != first:
            found = f"found pieces of other work than in {paths[0]} ({_difference(first, header)})"
            cure = "merge each on its own; every shard needs the same scene, options and version"
            raise _refusal(path, found, cure)
    return first


def _described(path: Path, header: str) -> dict[str, Any]:
    """The header's values; raises SceneError where they are none, or of another program."""
    what = _values(header)
    if not {"command", "scene", "options", "program"} <= set(what):
        raise _refusal(path, "found no description of a run", "leave it out")
    if what["program"] != program_hash():
        cure = "merge with the version that computed the parts"
        raise _refusal(path, "found pieces of another version of this program", cure)
    return what


def _values(header: str) -> dict[str, Any]:
    try:
        values = json.loads(header)
    except (ValueError, RecursionError):
        return {}
    return values if isinstance(values, dict) else {}


def _difference(a: str, b: str) -> str:
    one, two = _values(a), _values(b)
    different = [key for key in one if one[key] != two.get(key)]
    return ", ".join(f"another {shown(key)}" for key in different) or "another description"


def _refuse_missing(paths: Sequence[Path]) -> None:
    """Raise SceneError unless every shard is there once and complete."""
    present: dict[int, dict[int, Path]] = {}
    for path in paths:
        number, count = _end(path)
        twin = present.setdefault(count, {}).setdefault(number, path)
        if twin is not path:
            raise _refusal(path, f"found part {number} of {count} in {twin} too", "leave one out")
    if len(present) != 1:
        found = f"found parts of {' and of '.join(map(str, sorted(present)))}"
        expected, cure = "expected one number of parts", "merge parts of one division"
        raise _refusal("", found, cure, expected)
    ((count, numbers),) = present.items()
    if len(numbers) < count:
        missing = list(islice((n for n in range(1, count + 1) if n not in numbers), SHOWN + 1))
        names = ", ".join(map(str, missing[:SHOWN])) + (", ..." if len(missing) > SHOWN else "")
        found = f"found {len(numbers)} of {count} parts, {names} missing"
        raise _refusal("", found, "run --shard of those too", "expected all")


def _end(path: Path) -> Shard:
    """Which part it is; raises SceneError for one that is not complete."""
    match one_of(path, END):
        case [int(number), int(count)] if 1 <= number <= count <= MOST_SHARDS:
            return Shard(number, count)
    raise _refusal(path, "found a part not complete", "run the same command again, it goes on")


def _refusal(path: Path | str, found: str, cure: str, expected: str = "") -> SceneError:
    return SceneError(Fault("PART", str(path), found, expected, cure))
