"""cam init: a scene to begin with."""

import io
import json
import os
from pathlib import Path
from shlex import quote
from typing import Any

from camcli.cli.options import DRAWING, SCENE, Request, argument, flag
from camcli.errors import Fault, SceneError
from camcli.interrupts import held

WITHOUT = (*SCENE, *DRAWING, "threads")  # shared options that mean nothing here
COMMENTS = {
    "header": "lines that name the columns",
    "skip_lines": "lines of the file before the header",
    "decimal": "point | comma",
    "angle_column": "name, or number from 1",
    "lift_column": "name, or number from 1",
    "angle": "cam | crank: a crank turns twice as fast as the cam",
    "lift": "m | mm | inch | fraction (of max_lift)",
    "zero_deg": "deg of the cam where the table's angle is zero; turns all phases",
    "direction": "same | reversed: whether the cam's angle rises or falls with the table's",
    "base": "m, the follower's height at zero lift",
}


def init(
    request: Request,
    table: Path | None = argument("Lift table to look at.", "[TABLE]"),
    force: bool = flag("Overwrite the scene and its picture."),
) -> int:
    """Write a scene to begin with.

    \b
    cam init TABLE  looks at a lift table, says how it reads it, and writes TABLE.yaml and a
                    picture of the cam beside it; what is only a guess is marked CHECK
    cam init        writes scene.yaml, a valve train to fill in
    -o DIR          writes there, a copy of the table too
    """
    text = Path(__file__).with_name("scene.yaml").read_text(encoding="utf-8")
    path, keys, unsure = Path("scene.yaml"), {}, {}
    files, fill = [], "mass, spring and cam"
    if table is not None:
        from camcli.cams.files import read_bytes
        from camcli.cams.lift_guess import guess
        from camcli.cams.lift_table import MAX_BYTES

        expected, cure = "expected a table of angles and lifts", "check the name"
        data = read_bytes(table, str(table), MAX_BYTES, expected, cure)
        keys, unsure = (found := guess(data, str(table))).keys, found.unsure
        path, fill = table.with_suffix(".yaml"), "mass and spring"
        text = _scene(text, table, keys, unsure)
        if request.out is not None and request.out.resolve() != table.parent.resolve():
            files.append((request.out / table.name, data))
    path = path if request.out is None else request.out / path.name
    files.append((path, text.encode()))
    for file, content in () if request.dry_run else files:
        write_whole(file, content, force)
    drawn = [path.with_suffix(".png")] * (table is not None and not request.no_plot)
    for file in () if request.dry_run else drawn:
        write_whole(file, _picture(path), force)
    names = [str(file) for file in (*(file for file, _ in files), *drawn)]
    if request.json:
        print(json.dumps({"command": "init", "files": names, "keys": keys, "unsure": unsure}))
        return 0
    if table is not None:
        print(f"{table}: {', '.join(f'{key} {value}' for key, value in keys.items())}")
    for key, why in unsure.items():
        print(f"CHECK {key}: {keys[key]} is a guess: {why}")
    if request.dry_run:
        print(f"would write {', '.join(names)}")
        return 0
    for file in drawn:
        print(f"{file}: the cam and the rows of the table")
    print(f"{path}: fill in {fill}, then: cam detach -c {quote(str(path))}")
    return 0


def _scene(text: str, table: Path, keys: dict[str, Any], unsure: dict[str, str]) -> str:
    """The scene's text with the table in the place of its cam."""
    values = {"kind": "table", "file": table.name, **keys}
    values |= {"zero_deg": 0, "direction": "same", "base": 0}
    lines = []
    for key, value in values.items():
        written = f"  {key}: {json.dumps(value, ensure_ascii=False)}"
        comment = f"CHECK: {unsure[key]}" if key in unsure else COMMENTS.get(key, "")
        lines.append(f"{written:<30} # {comment}".rstrip(" #"))
    return text.partition("cam:\n")[0] + "cam:\n" + "\n".join(lines) + "\n"


def _picture(path: Path) -> bytes:
    """The cam of the scene beside its rows, as a PNG; faults name keys of the scene."""
    from camcli.api.simulate import simulate
    from camcli.output.pictures import write_picture
    from camcli.scene import load_scene

    result = simulate(load_scene(path), profile_only=True)
    picture = io.BytesIO()
    write_picture(result.pictures["profile"](), picture)
    return picture.getvalue()


def write_whole(path: Path, data: bytes, force: bool) -> None:
    """Write a file of the user's own folder, whole or not at all."""
    if path.exists() and not force:
        found, cure = "found a file of this name", "add --force to overwrite it"
        raise SceneError(Fault(str(path), "", found, "expected none", cure))
    part = path.with_name(f"{path.name}.cam-part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with held():
            part.write_bytes(data)
            os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        found = f"cannot be written: {(error.strerror or str(error)).lower()}"
        raise SceneError(Fault(str(path), "", found, "", "check the folder")) from None
