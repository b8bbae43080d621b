"""Validation errors to findings: where it stands, what was found, what is expected, what to do."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from camcli.errors import FileFaultsError
from camcli.scene.expected import Expectations, in_words
from camcli.scene.fields import RefusedError
from camcli.scene.nodes import Node, at, plain
from camcli.scene.places import Finding, Mark, Path, Source, dotted, shown
from camcli.scene.scalars import oddity
from camcli.scene.schema import TAGGED, json_schema

MAX_HINTS = 50  # nearest names are looked up for so many unknown keys: the search is not free

_AT_KEY = {"extra_forbidden", "missing", "value_error", "union_tag_not_found"}
_RANGES = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
_SIZES = {"too_long", "string_too_short", "string_too_long", "string_pattern_mismatch"}
_VALUES = {
    *_RANGES,
    "string_unicode",
    "finite_number",
    "literal_error",
    "too_short",
}  # and all that end in _type


class Translator:
    """Turns pydantic's error details about one scene into findings."""

    def __init__(self, root: Node):
        self.root = root
        self.data = plain(root)
        self.expectations = Expectations(json_schema)
        self.hints = 0

    def findings(self, errors: list[Mapping[str, Any]]) -> list[Finding]:
        found: list[Finding] = []
        for error in _causes(errors):
            cause = error.get("ctx", {}).get("error")
            if isinstance(cause, FileFaultsError):
                found += self._in_file(error, cause)
            else:
                found.append(self._finding(error))
        return found

    def _in_file(self, error: Mapping[str, Any], cause: FileFaultsError) -> list[Finding]:
        """Faults of a file that the scene names, each at its place in that file."""
        rank = self.root.mark.source.rank
        return [
            Finding(
                _mark_in_file(rank, fault.where),
                (*self._path(error["loc"], error["type"]), fault.path),
                shown(fault.found, 300),
                shown(fault.expected, 300),
                fault.cure,
            )
            for fault in cause.faults
        ]

    def _finding(self, error: Mapping[str, Any]) -> Finding:
        kind = error["type"]
        path = self._path(error["loc"], kind)
        if kind in ("union_tag_invalid", "union_tag_not_found"):
            path = (*path, error["ctx"]["discriminator"].strip("'"))
            kind = "missing" if kind == "union_tag_not_found" else "literal_error"
        if kind == "missing" and isinstance(path[-1], int):  # an item of a list of fixed length
            kind, path = "too_long", path[:-1]
        node, key_mark = at(self.root, path)
        mark = key_mark if kind in _AT_KEY else node.mark
        if kind == "extra_forbidden":
            words = self._unknown_key(path)
        elif kind == "missing":
            words = self._missing_key(path)
        elif kind in _SIZES:
            words = self._wrong_size(node, path)
        elif kind in _VALUES or kind.endswith("_type"):
            words = self._wrong_value(node, path, kind)
        else:
            words = self._refused(error, path)
        return Finding(mark, path, *words)

    def _path(self, location: tuple[str | int, ...], kind: str) -> Path:
        """Location without the names of union members, which are no keys of the data."""
        path: list[str | int] = []
        node = self.root
        for number, key in enumerate(location):
            if TAGGED and number == 1 and location[0] == "cam":
                continue
            child = node.child(key)
            if child is None and not (kind == "missing" and number == len(location) - 1):
                continue
            path.append(key)
            node = child or node
        return tuple(path)

    def _unknown_key(self, path: Path) -> tuple[str, str, str]:
        key = str(path[-1])
        known = list(self.expectations.at(path[:-1], self.data).get("properties", {}))
        expected = "expected one of " + ", ".join(known)
        if key == "<<":
            return "found a merge key '<<'", expected, "write the keys out, merging is not read"
        return f"found the unknown key '{shown(key)}'", expected, self._hint(key, known, path)

    def _hint(self, key: str, known: list[str], path: Path) -> str:
        if self.hints >= MAX_HINTS or len(key) > 40:
            return "remove it"
        self.hints += 1
        longer = [name for name in known if name.startswith(f"{key}_")]
        if longer:
            return f"did you mean '{longer[0]}'?"
        elsewhere = [p for p in self.expectations.dotted_paths(key) if p != dotted(path)]
        if elsewhere:
            return f"did you mean {' or '.join(elsewhere)}?"
        near = _nearest(key, known)
        return f"did you mean '{near}'?" if near else "remove it"

    def _missing_key(self, path: Path) -> tuple[str, str, str]:
        schema = self.expectations.at(path, self.data)
        key, about = path[-1], _about(schema)
        if schema.get("type") == "object":
            return f"no section '{key}'", f"expected {in_words(schema)}", "add the section"
        return f"no key '{key}'", f"expected {in_words(schema)}", f"add '{key}: ...'{about}"

    def _refused(self, error: Mapping[str, Any], path: Path) -> tuple[str, str, str]:
        """A check of its own refused the value; its message says what and how much."""
        cause = error.get("ctx", {}).get("error")
        if isinstance(cause, RefusedError):
            return shown(cause.found, 300), cause.expected, cause.cure
        message = str(cause or error["msg"])
        return shown(message, 400), "", f"change the values of {dotted(path) or 'the scene'}"

    def _wrong_size(self, node: Node, path: Path) -> tuple[str, str, str]:
        """A list of the wrong length, or a text of the wrong length or form."""
        schema = self.expectations.at(path, self.data)
        size = len(node.value) if isinstance(node.value, list | str) else 0
        kind = "a list" if isinstance(node.value, list) else f"'{shown(str(node.value))}'"
        unit = "values" if isinstance(node.value, list) else "characters"
        found = f"found {kind} of {size} {unit}"
        return found, f"expected {in_words(schema)}", f"change {_name(path)}{_about(schema)}"

    def _wrong_value(self, node: Node, path: Path, kind: str) -> tuple[str, str, str]:
        schema = self.expectations.at(path, self.data)
        expected = f"expected {in_words(schema)}"
        return f"found {_found(node)}", expected, _cure(node, path, kind, schema)


def _mark_in_file(rank: int, where: str) -> Mark:
    """`file`, `file:line` or `file:line:column` as a mark, so that faults come in order."""
    name, line, column = re.fullmatch(r"(.*?)(?::(\d+))?(?::(\d+))?", where, re.DOTALL).groups()
    return Mark(Source(rank, shown(name, 500), True), int(line or 0), int(column or 1))


def _found(node: Node) -> str:
    value = node.value
    if isinstance(value, dict):
        return "a map" if value else "an empty map"
    if isinstance(value, list):
        return "a list" if value else "an empty list"
    if value is None:
        return "nothing" if not node.text else shown(node.text)
    if isinstance(value, str):
        return f"'{shown(value)}'"
    return shown(node.text or str(value))


def _cure(node: Node, path: Path, kind: str, schema: dict[str, Any]) -> str:
    value, name = node.value, _name(path)
    wanted = schema.get("type")
    if wanted == "object" or (isinstance(value, dict) and wanted == "array"):
        return _shape_cure(value, str(name), wanted)
    if isinstance(value, list) and wanted == "array":
        return f"name at least one in {name}"
    if isinstance(value, list | dict):
        return f"give {name} a single value{_about(schema)}"
    if wanted == "array":
        return f"write it in brackets: {name}: [{_found(node).strip(chr(39))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return f"give {name} a finite number{_about(schema)}"
    if kind in _RANGES:
        return f"give {name} a value in this range{_about(schema)}"
    if "enum" in schema or "const" in schema:
        near = _nearest(str(value), [str(c) for c in schema.get("enum", [schema.get("const")])])
        return f"did you mean '{near}'?" if near else "choose one of these"
    return _scalar_cure(value, path, wanted) + _about(schema)


def _scalar_cure(value: object, path: Path, wanted: str | None) -> str:
    """What to do about a single value of the wrong type."""
    name = _name(path)
    if value is None:
        return f"give {name} a value, or remove the line"
    if isinstance(value, bool):
        return "true and false are neither numbers nor text here"
    if isinstance(value, str) and wanted in ("number", "integer"):
        swept = "a range of speeds stands in sweep.rpm; " if path[-2:] == ("run", "rpm") else ""
        return (swept if ":" in value else "") + (oddity(value) or f"give {name} as a number")
    if isinstance(value, float) and wanted == "integer":
        return "round it"
    return f"put {name} in quotes" if wanted == "string" else f"change {name}"


def _name(path: Path) -> str:
    """What a cure calls the value: its key, or the place in a list and the list's key."""
    if not path:
        return "the scene"
    if isinstance(path[-1], int) and len(path) > 1:
        return f"value {path[-1] + 1} of {shown(str(path[-2]), 40)}"
    return shown(str(path[-1]), 40)


def _shape_cure(value: object, name: str, wanted: str) -> str:
    if wanted == "array":
        return f"write {name} as a list: [...]"
    if isinstance(value, list):
        return f"write 'key: value' lines below {name}, without dashes or brackets"
    return f"write 'key: value' lines below {name}"


def _about(schema: dict[str, Any]) -> str:
    """` (mass of the follower, kg)`: the unit is in the description."""
    return f" ({schema['description']})" if schema.get("description") else ""


def _nearest(word: str, known: list[str]) -> str:
    import difflib  # only after a mistake

    near = difflib.get_close_matches(word[:40].lower(), known, n=1, cutoff=0.6)
    return near[0] if near else ""


def _causes(errors: list[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The errors without a list too short only because its bad items do not count."""

    def is_bad(loc: tuple) -> bool:
        return any(e["loc"][: len(loc)] == loc and len(e["loc"]) > len(loc) for e in errors)

    return [e for e in errors if e["type"] != "too_short" or not is_bad(e["loc"])]
