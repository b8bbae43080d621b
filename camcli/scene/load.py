"""A scene from its file, `--set` texts and options: valid as a whole, or every fault at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from camcli.errors import Fault, SceneError
from camcli.scene.files import default_scene_path, read_text
from camcli.scene.nodes import Node, node_of, plain, replaced
from camcli.scene.overrides import apply_set, of_new_kind
from camcli.scene.places import Finding, Mark, Source, shown
from camcli.scene.schema import Scene
from camcli.scene.tree import parse

MAX_FAULTS = 100  # a file with more is not a scene; the last fault then says how many


def load_scene(
    path: Path | None,
    sets: Sequence[str] = (),
    options: Mapping[str, tuple[object, str]] | None = None,
) -> Scene:
    """Read, override and validate a scene; None is the chapter's.

    `sets` are the texts of `--set`, `options` maps a dotted path to (value, option name).
    Options beat `--set`, a later `--set` beats an earlier one, and both beat the file.
    Raises SceneError with all faults, in the order of the file, then of the command line.
    """
    findings: list[Finding] = []
    root = _read(path, findings)
    start = root or Node(Mark(Source(0, "")), {})  # the command line is checked all the same
    scene = _override(start, sets, options or {}, findings)
    if root is None:
        raise _error(findings)
    return _validate(scene, path, findings)


def scene_of(values: Mapping[str, Any], folder: Path) -> Scene:
    """The scene that `resolved` gave these values; files it names are in `folder`.

    Raises SceneError.
    """
    root = node_of(values, Mark(Source(0, "scene")))
    return _validate(root, folder / "scene", [])


def resolved(scene: Scene) -> dict[str, Any]:
    """The full scene, defaults included, as plain values that JSON can hold."""
    return scene.model_dump(mode="json")


def scene_hash(scene: Scene) -> str:
    """SHA-256 of the full scene: the same on every machine, order and notation do not matter."""
    import hashlib
    import json

    text = json.dumps(resolved(scene), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _read(path: Path | None, findings: list[Finding]) -> Node | None:
    """Nodes of the file, None when it cannot be read to its end or is no map."""
    file = default_scene_path() if path is None else path
    source = Source(0, shown(str(file), 500), numbered=True)
    text = read_text(file, source)
    if isinstance(text, Finding):
        findings.append(text)
        return None
    root, faults = parse(text, source)
    findings.extend(faults)
    if root and not isinstance(root.value, dict):
        findings.append(_no_map(root))
        return None
    return root


def _no_map(root: Node) -> Finding:
    if root.value is None:
        found = "found nothing in this file"
    else:
        found = "found a list" if isinstance(root.value, list) else "found a single value"
    expected = f"expected a map with the sections {', '.join(Scene.model_fields)}"
    return Finding(root.mark, (), found, expected, "start from 'follower:' and 'cam:'")


def _override(
    root: Node,
    sets: Sequence[str],
    options: Mapping[str, tuple[object, str]],
    findings: list[Finding],
) -> Node:
    before = root
    for rank, text in enumerate(sets, 1):
        root, faults = apply_set(root, text, rank)
        findings.extend(faults)
    root = of_new_kind(root, before)
    for rank, (dotted_path, (value, name)) in enumerate(options.items(), len(sets) + 1):
        node = node_of(value, Mark(Source(rank, name)))
        root = replaced(root, tuple(dotted_path.split(".")), node)
    return root


def _validate(root: Node, path: Path | None, findings: list[Finding]) -> Scene:
    # context: a cam that names a file finds it beside the scene
    context = {"folder": path.parent if path else Path()}
    try:
        scene = Scene.model_validate(plain(root), strict=True, context=context)
    except ValidationError as error:
        from camcli.scene.faults import Translator

        details = error.errors(include_url=False)
        raise _error([*findings, *Translator(root).findings(details)]) from None
    if findings:
        raise _error(findings)
    return scene


def _error(findings: Iterable[Finding]) -> SceneError:
    """All faults in order, one per place and path."""
    first: dict[tuple[Mark, tuple], Finding] = {}
    for item in findings:
        first.setdefault((item.mark, item.path), item)
    ordered = sorted(first.values(), key=lambda item: item.mark)
    faults = [item.fault() for item in ordered[:MAX_FAULTS]]
    if len(ordered) > MAX_FAULTS:
        more = f"{len(ordered) - MAX_FAULTS} further faults"
        faults.append(Fault(ordered[0].mark.source.name, "", more, "", "correct these first"))
    return SceneError(*faults)
