"""cam merge: the artefacts of a run whose pieces were computed in shards."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from itertools import islice
from pathlib import Path

from camcli.api.command import command_of
from camcli.cli.options import DRAWING, Request, argument
from camcli.cli.rerun import HOME, REPEATED, Record, record_of
from camcli.cli.run import MOST_SHARDS, check_before, execute
from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash
from camcli.parallel.checkpoint import key_of

WITHOUT = (*REPEATED, *DRAWING)  # shared options that mean nothing here
PIECES = ".pieces"  # ending of the files of --shard
SHOWN = 10  # missing shards named


def merge(
    request: Request,
    parts: list[Path] | None = argument("Parts, or folders of them.", "[PART]..."),
    folder: Path | None = HOME,
) -> int:
    """Join the parts of a run that was computed in shards.

    Examples:
      cam sweep --shard 1/2 -o parts           on one machine
      cam sweep --shard 2/2 -o parts           on another one
      cam merge parts -o out/sweep             the same bytes as of one run

    \b
    cam sweep --shard 1/4 -o DIR ... cam sweep --shard 4/4 -o DIR, on any machines and in any
    order, then cam merge DIR: the same artefacts, byte for byte, as of one run.
    """
    paths = _paths(parts or [Path("out")])
    record, told_by, drawn = _record(paths)
    no_plot = request.no_plot or not drawn
    scene = record.load(folder, Path(), str(told_by))
    request = replace(request, out=request.out or paths[0].parent, no_plot=no_plot)
    command = command_of(record.command)
    check_before(command, scene, request.folder(command.name), not no_plot)
    show = import_module(f"camcli.cli.{record.command}").show
    return execute(command, scene, request, show, parts=tuple(paths))


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


def _record(paths: Sequence[Path]) -> tuple[Record, Path, bool]:
    """The record of the run that the parts belong to, the last part, and whether it draws.

    A part begins with its key, a JSON text of the command and of the values that decide numbers; it
    is the same in all parts of a run. It ends with which shard it is, its whole scene and whether
    the run draws. The values of a scene that decide no number (how pictures look) are those of the
    last part.

    Raises SceneError unless they are all parts of one run, complete. A part that is there twice, or
    one of another division of the same run, does no harm.
    """
    numbers: dict[int, set[int]] = {}  # parts that are there, by their total
    first = ""  # key of the first part
    plot = False
    for path in paths:
        try:
            key, end = key_of(path)
        except OSError as error:
            found = f"cannot be read ({error.strerror})"
            raise _refusal(path, found, "leave it out", "expected a file of --shard I/N") from None
        record_of(key, path)  # raises SceneError where the key is none of a run
        first = first or key
        if key != first:  # the values may be equal: -0.0 is another machine than 0.0
            found = f"found pieces of other work than in {paths[0]} ({_differ(first, key)})"
            cure = "merge each on its own; every shard needs the same scene, options and version"
            raise _refusal(path, found, cure)
        match end:
            case {
                "shard": [int(number), int(total)],
                "scene": dict(scene),
                "plot": bool(drawn),
            } if 1 <= number <= total <= MOST_SHARDS:
                numbers.setdefault(total, set()).add(number)
                plot |= drawn
            case _:
                cure = "run the same command again, it goes on"
                raise _refusal(path, "found a part not complete", cure)
    deciding = json.loads(first)
    whole_scene = {**scene, **deciding["scene"]}
    record = record_of(json.dumps({**deciding, "scene": whole_scene}, default=repr), path)
    if record.program_sha256 != program_hash():
        cure = "merge with the version that computed the parts"
        raise _refusal(paths[0], "found pieces of another version of this program", cure)
    _refuse_missing(numbers)
    return record, path, plot


def _refuse_missing(numbers: Mapping[int, set[int]]) -> None:
    """Raise SceneError unless all parts of one division of the run are there.

    numbers: of the parts that are there, by how many there are in all.
    """

    def lacking(total: int) -> int:
        """How many parts of this division are not there."""
        return total - len(numbers[total])

    total = min(numbers, key=lacking)
    if lacking(total) > 0:
        absent = (number for number in range(1, total + 1) if number not in numbers[total])
        names = [str(number) for number in islice(absent, SHOWN)]
        if lacking(total) > SHOWN:
            names.append("...")
        found = f"found {len(numbers[total])} of {total} parts, not there: {', '.join(names)}"
        raise _refusal("", found, "run --shard of those too", "expected all")


def _differ(one: str, two: str) -> str:
    """In what two keys of pieces differ, in words."""
    first = json.loads(one)
    second = json.loads(two)
    names = [
        f"another {name}"
        for name in first
        if json.dumps(first[name]) != json.dumps(second.get(name))
    ]
    return ", ".join(names) or "written in another way"


def _refusal(path: Path | str, found: str, cure: str, expected: str = "") -> SceneError:
    """The fault of a part of a run."""
    return SceneError(Fault("PART", str(path), found, expected, cure))
