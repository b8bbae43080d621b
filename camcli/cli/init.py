"""cam init: a scene to begin with."""

import os
from pathlib import Path
from shlex import quote
from typing import Annotated, Any

from typer import Argument, Option

from camcli.errors import Fault, SceneError
from camcli.interrupts import held

FOLLOWER = """\
follower:
  mass: 0.12           # kg, FILL IN: valve, retainer, tappet and a third of the spring
  stiffness: 40000     # N/m, FILL IN: the spring; 1 N/mm is 1000 N/m
  preload: 250         # N, FILL IN: force of the spring at zero lift
  damping: 20          # N s/m: oil and friction; 0 to leave it out
  gravity: 0           # m/s2, 9.81 where the weight presses on the cam
  restitution: 0.4     # -, 0..1: speed after an impact over speed before; oiled steel 0.3 to 0.6
# in the place of stiffness and preload, loads of the spring on the shut and on the open valve, N:
# spring: {seat_load: 250, nose_load: 650, solid_at: 0.012}   # m, lift at which it is solid
# contact: {width: 0.012, base_radius: 0.017, follower_radius: null}   # m: for the Hertz pressure
"""
LAW = """\
cam:
  kind: law            # FILL IN; also arcs (circles), eccentric, table (cam init TABLE)
  base: 0              # m, the follower's height on the base circle
  lift: 0.010          # m
  rise: {start_deg: 115, length_deg: 65, law: modified-sine}   # deg of the cam
  top_dwell_deg: 0     # deg
  fall: {length_deg: 65, law: modified-sine}
"""
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
    table: Annotated[
        Path | None, Argument(help="Lift table to look at.", metavar="[TABLE]")
    ] = None,
    force: Annotated[bool, Option("--force", help="Overwrite the scene and its picture.")] = False,
) -> None:
    """Write a scene to begin with.

    \b
    cam init TABLE  looks at a lift table, says how it reads it, and writes TABLE.yaml and a
                    picture of the cam beside it; what is only a guess is marked CHECK
    cam init        writes scene.yaml, a valve train to fill in
    """
    if table is None:
        path = Path("scene.yaml")
        _write(path, (FOLLOWER + "\n" + LAW).encode(), force)
        print(f"{path}: fill in mass, spring and cam, then: cam detach -c {quote(str(path))}")
        return
    from camcli.cams.files import read_bytes
    from camcli.cams.lift_guess import guess
    from camcli.cams.lift_table import MAX_BYTES

    expected, cure = "expected a table of angles and lifts", "check the name"
    found = guess(read_bytes(table, str(table), MAX_BYTES, expected, cure), str(table))
    keys, unsure = found.keys, found.unsure
    path = table.with_suffix(".yaml")
    _write(path, _scene(table, keys, unsure).encode(), force)
    print(f"{table}: {', '.join(f'{key} {value}' for key, value in keys.items())}")
    for key, why in unsure.items():
        print(f"CHECK {key}: {keys[key]} is a guess: {why}")
    _draw(path, force)
    print(f"{path}: fill in mass and spring, then: cam detach -c {quote(str(path))}")


def _scene(table: Path, keys: dict[str, Any], unsure: dict[str, str]) -> str:
    """The scene's text."""
    import json

    values = {"kind": "table", "file": table.name, **keys}
    values |= {"zero_deg": 0, "direction": "same", "base": 0}
    lines = []
    for key, value in values.items():
        written = f"  {key}: {json.dumps(value, ensure_ascii=False)}"
        comment = f"CHECK: {unsure[key]}" if key in unsure else COMMENTS.get(key, "")
        lines.append(f"{written:<30} # {comment}".rstrip(" #"))
    return f"{FOLLOWER}\ncam:\n" + "\n".join(lines) + "\n"


def _draw(path: Path, force: bool) -> None:
    """The cam beside its rows as a picture beside the scene; faults name keys of the scene."""
    import io

    from camcli.api.simulate import simulate
    from camcli.output.pictures import write_picture
    from camcli.scene import load_scene

    result = simulate(load_scene(path), profile_only=True)
    picture = io.BytesIO()
    write_picture(result.pictures["profile"](), picture)
    _write(path.with_suffix(".png"), picture.getvalue(), force)
    print(f"{path.with_suffix('.png')}: the cam and the rows of the table")


def _write(path: Path, data: bytes, force: bool) -> None:
    """Write a file of the user's own folder, whole or not at all."""
    if path.exists() and not force:
        found, cure = "found a file of this name", "add --force to overwrite it"
        raise SceneError(Fault(str(path), "", found, "expected none", cure))
    part = path.with_name(f"{path.name}.cam-part")
    try:
        with held():
            part.write_bytes(data)
            os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        found = f"cannot be written: {(error.strerror or str(error)).lower()}"
        raise SceneError(Fault(str(path), "", found, "", "check the folder")) from None
