"""cam init: a scene to begin with."""

import io
import json
from operator import methodcaller
from pathlib import Path
from shlex import quote
from typing import Any

from camcli.cli.options import DRAWING, SCENE, Request, argument, flag
from camcli.errors import Fault, SceneError

WITHOUT = (*SCENE, *DRAWING, "threads", "verbose")  # shared options that mean nothing here
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
    files, keys, unsure = {"scene.yaml": text.encode()}, {}, {}
    home, fill = request.out or Path(), "mass, spring and cam"
    if table is not None:
        from camcli.cams.files import read_bytes
        from camcli.cams.lift_guess import guess
        from camcli.cams.lift_table import MAX_BYTES

        expected, cure = "expected a table of angles and lifts", "check the name"
        data = read_bytes(table, str(table), MAX_BYTES, expected, cure)
        keys, unsure = (found := guess(data, str(table))).keys, found.unsure
        home, fill = request.out or table.parent, "mass and spring"
        files = {table.with_suffix(".yaml").name: _scene(text, table, keys, unsure).encode()}
        if home.resolve() != table.parent.resolve():
            files[table.name] = data
    path = home / next(iter(files))
    pictures = [path.with_suffix(".png")] * (table is not None and not request.no_plot)
    names = [str(home / name) for name in files] + list(map(str, pictures))
    if not request.dry_run:
        _write(home, files, force)
        for picture in pictures:  # a fault of the table names lines of the scene
            _write(home, {picture.name: _picture(path)}, force)
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
    for picture in pictures:
        print(f"{picture}: the cam and the rows of the table")
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
    """The cam of the scene beside its rows, as a PNG."""
    from camcli.api.simulate import simulate
    from camcli.output.pictures import write_picture
    from camcli.scene import load_scene

    picture = io.BytesIO()
    form = {"plot.panels": ["lift", "velocity", "acceleration"], "plot.title": False}
    result = simulate(load_scene(path, form), profile_only=True)  # no force: the spring is made up
    write_picture(result.pictures["profile"](), picture, form=result.scene.plot)
    return picture.getvalue()


def _write(home: Path, files: dict[str, bytes], force: bool) -> None:
    """Write files into the user's own folder, all of them or none."""
    from camcli.output.run_folder import run_folder

    for name in files if not force else ():
        if (home / name).exists():
            found, cure = "found a file of this name", "add --force to overwrite it"
            raise SceneError(Fault(str(home / name), "", found, "expected none", cure))
    with run_folder(home) as store:
        for name, data in files.items():
            store.write(name, methodcaller("write", data))
        store.commit()
