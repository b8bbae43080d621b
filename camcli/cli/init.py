"""cam init: a scene to begin with."""

import io
import json
import os
import re
import unicodedata
from collections.abc import Mapping, Sequence
from contextlib import suppress
from operator import methodcaller
from pathlib import Path
from shlex import quote
from types import MappingProxyType
from typing import Any, NamedTuple

from camcli.cli.exit_codes import note
from camcli.cli.options import DRAWING, SCENE, Request, argument, flag
from camcli.errors import Fault, SceneError, printable

WITHOUT = (*SCENE, *DRAWING, "threads", "verbose")  # shared options that mean nothing here
PNG = b"\x89PNG\r\n\x1a\n"  # the first bytes of every such picture
BELOW = 0.9  # of the speed at which contact is lost: where a machine might work
COMMENTS = {
    "header": "lines that name the columns",
    "skip_lines": "lines of the file before the header",
    "decimal": "point | comma",
    "angle_column": "name, or number from 1",
    "lift_column": "name, or number from 1",
    "angle": "cam | crank: a crank turns twice as fast as the cam",
    "lift": "m | mm | um | inch | thou (0.001 inch) | fraction (of max_lift)",
    "max_lift": "m, lift where the table says 1",
    "subtract": "number of the table on the base circle",
    "mirrored": "true | false: whether the table is one flank, and the other its mirror image",
    "base_radius": "m, of the base circle; only for the shape of the lobe",
    "lift_scale": "factor on every lift of the table; 1: as measured",
    "rocker_ratio": "lift of the valve per lift of the lobe; 1: no rocker between them",
    "measured_at": "lobe | valve: on which side of the rocker the table was measured",
    "zero_deg": "deg of the cam where the table's angle is zero; turns all phases",
    "direction": "same | reversed: whether the cam's angle rises or falls with the table's",
    "base": "m, the follower's height at zero lift",
    "rpm": "CHECK: the working speed, rpm of the cam; of a crank: 6000 crank",
}


class Files(NamedTuple):
    """What `cam init` writes: the scene, its picture, and a copy of the table elsewhere."""

    scene: Path
    picture: Path | None = None
    copy: Path | None = None
    others: Mapping[str, Path] = MappingProxyType({})  # scenes of further lobes, by column

    @property
    def named(self) -> dict[str, Path]:
        """The files that are written, by what they are: scene, picture, copy, `scene of COLUMN`."""
        named = {"scene": self.scene}
        if self.picture is not None:
            named["picture"] = self.picture
        if self.copy is not None:
            named["copy"] = self.copy
        return named | {f"scene of {column}": path for column, path in self.others.items()}


def init(
    request: Request,
    table: Path | None = argument("Lift table to look at.", "[TABLE]"),
    force: bool = flag("Overwrite the scene and its picture."),
) -> int:
    """Write a scene to begin with.

    Examples:
      cam init my-lift.csv                     a scene for a lift table
      cam init                                 scene.yaml, a valve train to fill in

    \b
    cam init TABLE  looks at a lift table, says how it reads it, and writes TABLE.yaml and a
                    picture of the cam beside it; what is only a guess is marked CHECK, with the
                    picture also a working speed, nine tenths of that at which contact is lost
    cam init        writes scene.yaml, a valve train to fill in
    -o DIR          writes there, a copy of the table too

    \b
    Numbers marked FILL IN are made up. As long as one of them is there, the verdict of every run
    begins with it, and the exit code is 3; it is the number that counts, not the remark.

    \b
    A file with the lifts of two lobes gives a scene of each: TABLE.yaml, and TABLE-COLUMN.yaml.

    \b
    No table is ever written over: --force replaces a scene by a scene and a PNG by a PNG. A file
    that holds two tables, or a row that cannot be read, is refused by its line.
    """
    if table is None:
        template = _template().encode()
        plan = _Planned(Files((request.out or Path()) / "scene.yaml"), {"scene": template}, {}, {})
    else:
        plan = _of_table(table, request)
    files = plan.files
    _refuse_to_overwrite(files, plan.content, force)
    if not request.dry_run:
        written = {}
        for what, path in files.named.items():
            if what in plan.content:  # the picture is drawn later, from the scene
                written[path.name] = plan.content[what]
        _write(files.scene.parent, written)
        if table is not None:
            for scene in (files.scene, *files.others.values()):
                _set_speed(scene)
        if files.picture is not None:
            _draw(files.scene, files.picture)
    _show(plan, table, request)
    return 0


class _Planned(NamedTuple):
    """What `cam init` is going to write, and what it has read of a lift table.

    content: bytes by what a file is, see `Files.named`. keys: of the cam, as the table reads;
    unsure: for those that are guesses, why.
    """

    files: Files
    content: dict[str, bytes]
    keys: dict[str, Any]
    unsure: dict[str, str]


def _template() -> str:
    """The text of the scene of a valve train to fill in."""
    return Path(__file__).with_name("scene.yaml").read_text(encoding="utf-8")


def _of_table(table: Path, request: Request) -> _Planned:
    """Look at a lift table: the scene of each of its lobes, and a copy of it."""
    from camcli.cams.files import read_bytes
    from camcli.cams.lift_guess import guess
    from camcli.cams.lift_table import MAX_BYTES

    expected = "expected a table of angles and lifts"
    data = read_bytes(table, str(table), MAX_BYTES, expected, "check the name")
    found = guess(data, str(table))
    files = _files(table, request.out, not request.no_plot, list(found.lobes))
    _refuse_shared(table, files)
    content = {"scene": _scene(table, found.keys, found.unsure).encode(), "copy": data}
    for column, lobe in found.lobes.items():
        content[f"scene of {column}"] = _scene(table, lobe.keys, lobe.unsure).encode()
    return _Planned(files, content, found.keys, found.unsure)


def _show(plan: _Planned, table: Path | None, request: Request) -> None:
    """Say how the table reads, what is a guess, and what to do next."""
    files = plan.files
    names = [str(path) for path in files.named.values()]
    if request.json:
        answer = {"command": "init", "files": names, "keys": plan.keys, "unsure": plan.unsure}
        print(json.dumps(answer))
        return
    if table is not None:
        print(f"{table}: {', '.join(f'{key} {value}' for key, value in plan.keys.items())}")
    for key, why in plan.unsure.items():
        print(f"CHECK {key}: {plan.keys[key]} is a guess: {why}")
    if request.dry_run:
        print(f"would write {', '.join(names)}")
        return
    if files.picture is not None:
        print(f"{files.picture}: the cam and the rows of the table")
    to_fill_in = "mass, spring and cam" if table is None else "mass and spring"
    for path in (files.scene, *files.others.values()):
        print(f"{path}: fill in {to_fill_in}, then: cam detach -c {quote(str(path))}")


# -- which files, and which of them may not be written ------------------------------------------


def _files(table: Path, out: Path | None, drawn: bool, columns: Sequence[str]) -> Files:
    """Where the files of a table go: beside it, or in another folder with a copy of it.

    columns: those of further lobes, each of which has a scene that bears its name or number.
    """
    folder = table.parent if out is None else out
    others: dict[str, Path] = {}
    for column in columns:
        word = re.sub(r"[^a-z0-9]+", "-", _plain(column)).strip("-") or f"lobe{len(others) + 2}"
        others[column] = folder / f"{table.stem}-{word}.yaml"
    copy = folder / table.name
    return Files(
        scene=folder / table.with_suffix(".yaml").name,
        picture=folder / table.with_suffix(".png").name if drawn else None,
        copy=None if _is_one(copy, table) else copy,
        others=others,
    )


def _refuse_shared(table: Path, files: Files) -> None:
    """Raise SceneError where two of the files would be one, or the name cannot stand in a scene."""
    try:
        table.name.encode()
    except UnicodeEncodeError:
        found = "found a name that is no UTF-8 text"
        expected = "expected one: a scene must hold it"
        raise SceneError(Fault(str(table), "", found, expected, "rename the table")) from None
    for what, path in files.named.items():
        if what == "copy":
            continue
        for other, name in ((table, "table"), (files.copy, "copy of the table")):
            if other is not None and _is_one(path, other):
                found = f"found that the {what} would be written over the {name}"
                cure = "rename the table, e.g. to end in .csv"
                raise SceneError(Fault(str(path), "", found, "expected files of their own", cure))


def _is_one(one: Path, other: Path) -> bool:
    """True where two names are of one file.

    They are through links, and where the names differ only in the case of letters: on some systems
    that makes no other file.
    """
    with suppress(OSError, ValueError):
        if os.path.samefile(one, other):
            return True
    same_folder = _plain(os.path.realpath(one.parent)) == _plain(os.path.realpath(other.parent))
    with suppress(OSError, ValueError):
        same_folder = os.path.samefile(one.parent, other.parent)
    return same_folder and _plain(one.name) == _plain(other.name)


def _plain(name: str) -> str:
    """A name without the differences that some file systems do not see."""
    return unicodedata.normalize("NFC", name).casefold()


def _refuse_to_overwrite(files: Files, content: dict[str, bytes], force: bool) -> None:
    """Raise SceneError where a file of this name is not to be overwritten."""
    for what, path in files.named.items():
        if not os.path.lexists(path):
            continue
        ours = _is_ours(what, path, content.get(what, b""))
        if ours and (force or what == "copy"):
            continue
        found = "found a file of this name"
        cure = "add --force to overwrite it"
        if not ours:
            kind = {"picture": "PNG", "copy": "copy of the table"}.get(what, "scene")
            found += f" that is no {kind}"
            cure = "move it away, or choose another -o DIR"
        raise SceneError(Fault(str(path), "", found, "expected none", cure))


def _is_ours(what: str, path: Path, content: bytes) -> bool:
    """Whether a file is a scene, a PNG, or the copy of the table as it would be written."""
    from camcli.scene.document import parse
    from camcli.scene.load import MAX_BYTES

    try:
        if not path.is_file():
            return False
        with open(path, "rb") as file:
            data = file.read(max(MAX_BYTES, len(content)) + 1)
    except OSError:
        return False
    if what == "copy":
        return data == content
    if what == "picture":
        return data.startswith(PNG)
    scene = parse(data[:MAX_BYTES].decode(errors="replace"), str(path)).data
    return isinstance(scene, dict) and "cam" in scene


# -- what is written ---------------------------------------------------------------------------


def _scene(table: Path, keys: dict[str, Any], unsure: dict[str, str]) -> str:
    """The text of a scene with a table as its cam; keys, unsure: see `_Planned`."""
    values = {"kind": "table", "file": table.name, **keys}
    values |= {"zero_deg": 0, "direction": "same", "base": 0}
    lines = []
    for key, value in values.items():
        needs_escapes = isinstance(value, str) and not value.isprintable()
        entry = f"  {key}: {json.dumps(value, ensure_ascii=needs_escapes)}"
        comment = f"CHECK: {unsure[key]}" if key in unsure else COMMENTS.get(key, "")
        lines.append(f"{entry:<30} # {printable(comment)}".rstrip(" #"))
    before_cam, _, _ = _template().partition("cam:\n")
    return f"{before_cam}cam:\n" + "\n".join(lines) + "\n"


def _set_speed(scene: Path) -> None:
    """Write a speed of the machine into its scene: somewhat below that at which contact is lost.

    A table that cannot be read leaves the scene as it is; who draws it, or runs it, is told why.
    """
    from camcli.analysis.natural_speed import natural_speed
    from camcli.api.machine import machine_of
    from camcli.scene import load_scene

    try:
        rpm = BELOW * natural_speed(machine_of(load_scene(scene)).system).rpm
    except SceneError:
        return
    if rpm <= 0.0:
        return
    text = scene.read_text(encoding="utf-8")
    rounded = float(f"{rpm:.2g}")
    line = f"  rpm: {rounded:<15g} # {COMMENTS['rpm']}"
    _write(scene.parent, {scene.name: f"{text}\nrun:\n{line}\n".encode()})


def _draw(scene: Path, picture: Path) -> None:
    """Write the picture of the scene's cam beside the rows of its table."""
    from camcli.api.simulate import simulate
    from camcli.output.pictures import write_picture
    from camcli.scene import load_scene

    form = {"plot.panels": ["lift", "velocity", "acceleration"], "plot.title": False}
    try:
        # the cam alone: its spring is made up, so the force that it would give means nothing
        result = simulate(load_scene(scene, form), profile_only=True)
    except SceneError:
        note(f"note: {scene} is written; what the fault is about may be corrected there")
        raise
    png = io.BytesIO()
    write_picture(result.pictures["profile"](), png, form=result.scene.plot)
    _write(picture.parent, {picture.name: png.getvalue()})


def _write(folder: Path, files: dict[str, bytes]) -> None:
    """Write files into the user's own folder, all of them or none."""
    from camcli.output.run_folder import run_folder

    with run_folder(folder) as store:
        for name, data in files.items():
            store.write(name, methodcaller("write", data))
        store.commit()
