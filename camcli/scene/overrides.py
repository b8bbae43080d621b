"""`--set path.to.key=value` and `--rpm`: command-line text to nodes and numbers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args

from camcli.cams import CAMS
from camcli.errors import Fault, SceneError
from camcli.scene.fields import FASTEST, SLOWEST
from camcli.scene.nodes import Node, at, replaced
from camcli.scene.places import Finding, Mark, Source, shown
from camcli.scene.scalars import oddity, resolve
from camcli.scene.tree import MAX_DEPTH, parse

_KIND = ("cam", "kind")
_FORM = "expected path.to.key=value"
_SPEED = f"expected a speed from {SLOWEST:g} to {FASTEST:g} turns per minute, or a range LO:HI"


def apply_set(root: Node, text: str, rank: int) -> tuple[Node, tuple[Finding, ...]]:
    """The scene with one `--set` applied, and what is wrong with it (then nothing is applied)."""
    source = Source(rank, f"--set {shown(text)}")
    mark = Mark(source)
    path_text, equals, value_text = text.partition("=")
    path = tuple(key.strip() for key in path_text.split("."))
    if any("\ud800" <= character <= "\udfff" for character in text):  # as Python reads odd bytes
        found = "found bytes that are no UTF-8 text"
        return root, (Finding(mark, (), found, _FORM, "type it again"),)
    if not equals:
        cure = "write the key, an = and the value without blanks between"
        return root, (Finding(mark, (), "found no '='", _FORM, cure),)
    if "" in path or len(path) > MAX_DEPTH:
        found = f"found the path '{shown(path_text)}'"
        return root, (Finding(mark, (), found, _FORM, "name a key as in run.rpm"),)
    tree = parse(value_text, source)
    findings = tuple(item._replace(path=path + item.path) for item in tree.findings)
    if tree.root is None or findings:
        return root, findings
    return replaced(root, path, tree.root), ()


def of_new_kind(root: Node, before: Node) -> Node:
    """The scene after overrides; where they change `cam.kind`, foreign keys of the file fall away.

    Keys that the new kind knows are kept, and so is all that was set on the command line.
    """
    cam, kind, old = root.child("cam"), *(at(tree, _KIND)[0].value for tree in (root, before))
    fields = [model.model_fields for model in CAMS if kind in _kinds(model)]
    if kind == old or not fields:
        return root
    kept = {k: v for k, v in cam.value.items() if k in fields[0] or v.mark.source.rank > 0}
    return replaced(root, _KIND[:1], replace(cam, value=kept))


def _kinds(model) -> tuple:
    """The word that `kind` must be, in a tuple."""
    return get_args(model.model_fields["kind"].annotation)


def parse_rpm(text: str) -> float | tuple[float, float]:
    """A speed `X` or a range `LO:HI` (either order), in turns per minute."""
    parts = text.split(":")
    if len(parts) > 2:
        raise _rpm_error(text, "give the number of speeds with --points")
    speeds = [_speed(part.strip(), text) for part in parts]
    return speeds[0] if len(speeds) == 1 else (speeds[0], speeds[1])


def _speed(part: str, text: str) -> float:
    value = resolve(part)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _rpm_error(text, oddity(part) or "write it as 700 or 660:760")
    if not math.isfinite(value) or not SLOWEST <= value <= FASTEST:
        raise _rpm_error(text, "give a speed in this range")
    return float(value)


def _rpm_error(text: str, cure: str) -> SceneError:
    return SceneError(Fault("--rpm", "", f"found '{shown(text)}'", _SPEED, cure))
