"""A command called again from a record of what it was asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, get_args, get_origin

from camcli.cli.options import HOW, Request
from camcli.errors import Fault, SceneError
from camcli.scene.places import shown

COMMANDS = ("simulate", "sweep", "detach", "orbits", "basins", "classify")
DEEPEST = 32  # levels of a scene


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
