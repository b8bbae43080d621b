"""Which figures there are, and which of them must be computed again, with the reason."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from camcli.errors import Fault, SceneError
from camcli.output.program import program_hash
from camcli.scene import Scene, default_scene_path, load_scene, resolved

STATE = "figure.json"
OWNED = ("config", "sets", "out", "no_plot", "json", "quiet", "threads", "dry_run")
CAM_ONLY = "--profile-only"  # with it a command knows no impacts, and of a run only the speed
NEW, UNCHANGED, CHECK = "new", "unchanged", "check"


@dataclass(frozen=True)
class Figure:
    """A scene that is a figure; `hashes` are those of all that its files depend on."""

    name: str
    path: Path
    text: str
    title: str
    shows: str
    words: list[str]  # command and options
    hashes: dict[str, str]

    @property
    def shown_command(self) -> str:
        """What a user types for it."""
        return " ".join(["cam", self.words[0], "-c", str(self.path), *self.words[1:]])


def default_folder() -> Path:
    """configs/figures of the folder we are in, a checkout, else of the installed program."""
    here = Path("configs", "figures")
    return here if here.is_dir() else default_scene_path().parent / "figures"


def figures(folder: Path, sets: Sequence[str] = ()) -> list[Figure]:
    """All figures of a folder by number; raises SceneError with the faults of all scenes."""
    paths = sorted(folder.glob("*.yaml"), key=lambda path: natural(path.stem))
    if not paths:
        found = "found no scenes" if folder.is_dir() else "found no such folder"
        raise SceneError(Fault("--folder", str(folder), found, "expected *.yaml", "name another"))
    found, faults = [], []
    for path in paths:
        try:
            _refuse_name(path)
            found.append(_figure(path, sets))
        except SceneError as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise SceneError(*faults)
    return found


def _refuse_name(path: Path) -> None:
    """Raise SceneError where the folder of the figure would not lie in the output folder."""
    if not path.stem.strip("."):
        found, expected = f"found a scene named '{path.name}'", "expected a name with a letter"
        raise SceneError(
            Fault(str(path), "", found, expected, "rename it: the folder has its name")
        )


def natural(name: str) -> list:
    """Sorts 3.9 before 3.10."""
    parts = re.findall(r"\d+|\D+", name)
    return [(int(part), "") if part.isdigit() else (0, part) for part in parts]


def chosen(known: Sequence[Figure], names: Collection[str]) -> list[Figure]:
    """The figures with these names, or with these names and a letter; all without names."""
    if not names:
        return list(known)
    found, faults = set(), []
    for name in names:
        hits = {f.name for f in known if f.name == name or re.fullmatch(r"[a-z]", _rest(f, name))}
        found |= hits
        if not hits:
            expected = f"expected one of {', '.join(f.name for f in known)}"
            faults.append(Fault("NAME", "", f"found '{name}'", expected, "or none, for all"))
    if faults:
        raise SceneError(*faults)
    return [figure for figure in known if figure.name in found]


def _rest(figure: Figure, name: str) -> str:
    return figure.name.removeprefix(name) if figure.name.startswith(name) else ""


def _figure(path: Path, sets: Sequence[str]) -> Figure:
    scene = load_scene(path, sets)
    if scene.figure is None:
        expected = "expected title and command"
        raise SceneError(Fault(str(path), "figure", "found no such section", expected, "add it"))
    words = scene.figure.words
    _refuse_unknown(path, words)
    data = getattr(scene.cam, "sha256", None) or ""
    hashes = {
        "scene": _scene_hash(scene, words),
        "data": data,
        "program": program_hash(pictures=True),
    }
    return Figure(
        path.stem, path, path.read_text(encoding="utf-8-sig"), scene.figure.title,
        scene.figure.shows, words, hashes,
    )  # fmt: skip


def _refuse_unknown(path: Path, words: list[str]) -> None:
    """Let the command's own parser read the options; raises SceneError where it cannot."""
    known = _commands()
    name = words[0]
    if name not in known:
        expected = f"expected one of {', '.join(known)}"
        fault = Fault(str(path), "figure.command", f"found the command '{name}'", expected, "")
        raise SceneError(fault)
    try:
        context = known[name].make_context(name, words[1:])
    except Exception as error:
        said = error.format_message() if hasattr(error, "format_message") else "found --help"
        fault = Fault(str(path), "figure.command", said, "", f"see cam {name} --help")
        raise SceneError(fault) from None
    given = [p for p in context.command.params if p.name in OWNED and context.params[p.name]]
    if given:
        found = f"found {', '.join(max(p.opts, key=len) for p in given)}"
        cure = "write scene values into the scene; the rest is given to cam figures"
        expected = "expected options of this figure only"
        raise SceneError(Fault(str(path), "figure.command", found, expected, cure))


@cache
def _commands() -> dict[str, Any]:
    """Parsers of the commands that take a scene, by name."""
    from typer.main import get_command

    from camcli.cli.app import app

    every = get_command(app).commands.items()  # type: ignore[attr-defined]
    return {n: c for n, c in every if any(p.name == "config" for p in c.params)}


def _scene_hash(scene: Scene, words: list[str]) -> str:
    """SHA-256 of the command and of what it reads: not of titles, nor of other commands' keys."""
    values = resolved(scene)
    values["cam"].pop("sha256", None)
    others = {"figure", *_commands()} - {words[0]}
    read = {key: value for key, value in values.items() if key not in others}
    if CAM_ONLY in words:
        read = {**read, "run": values["run"]["rpm"]}
        read["follower"] = {k: v for k, v in values["follower"].items() if k != "restitution"}
    text = json.dumps([words, read], sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def state_of(folder: Path) -> dict[str, Any] | None:
    """figure.json of a finished figure, None where there is none."""
    try:
        state = json.loads((folder / STATE).read_text())
    except (OSError, ValueError):
        return None
    return state if isinstance(state, dict) and {"hashes", "files"} <= set(state) else None


def reason(figure: Figure, folder: Path) -> str:
    """Why the figure must be computed, or `unchanged`."""
    state = state_of(folder)
    if state is None:
        return NEW
    for key, value in figure.hashes.items():
        if state["hashes"].get(key) != value:
            return f"{key} changed"
    return UNCHANGED if state["files"] == sizes(folder) else "artefact changed"


def sizes(folder: Path) -> dict[str, int]:
    """Bytes of every artefact of a figure."""
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    return {
        p.name: p.stat().st_size
        for p in paths
        if p.is_file() and p.name != STATE and p.name[0] != "."
    }
