"""Validation errors to findings: where it stands, what was found, what is expected, what to do."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from camcli.errors import SceneError, shown
from camcli.scene.document import Document, Finding, Mark, Path, dotted, oddity
from camcli.scene.schema import Scene

MAX_HINTS = 50  # nearest names are looked up for so many unknown keys: the search is not free
MAX_WORDS = 200  # errors put into words, in the order of the source; the others are only counted

_EXPECTED = {  # by pydantic's type of an error; others keep the message after "should be"
    "float_type": "a number",
    "finite_number": "a finite number",
    "greater_than": "a number greater than {gt:.15g}",
    "greater_than_equal": "a number of at least {ge:.15g}",
    "less_than": "a number less than {lt:.15g}",
    "less_than_equal": "a number of at most {le:.15g}",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "string_unicode": "text",
    "string_too_short": "text of at least {min_length} character(s)",
    "string_too_long": "text of at most {max_length} characters",
    "string_pattern_mismatch": "text that matches {pattern}",
    "tuple_type": "a list",
    "too_short": "a list of at least {min_length} item(s)",
    "too_long": "a list of at most {max_length} item(s)",
}
_MAP_TYPES = {"model_type", "model_attributes_type", "dict_type"}
_AT_KEY = {"extra_forbidden", "missing", "value_error"}  # the fault is the key's or the section's


def findings(document: Document, error: ValidationError) -> Iterator[Finding]:
    """A finding for each of pydantic's errors about the data of a document."""
    details = error.errors(include_url=False)
    places = [_path(document.data, detail["loc"]) for detail in details]
    order = sorted(range(len(details)), key=lambda k: document.place(places[k]).value)
    hints = 0
    for number, k in enumerate(order):
        detail = details[k]
        if number >= MAX_WORDS:
            yield Finding(document.place(places[k]).value, places[k], "")
            continue
        if detail["type"] == "too_short" and any(_is_below(d, detail) for d in details):
            continue  # too short only because its bad items do not count
        cause = detail.get("ctx", {}).get("error")
        if isinstance(cause, SceneError):
            yield from _refused(document, detail, cause)
            continue
        finding = _finding(document, detail, hints < MAX_HINTS)
        hints += detail["type"] == "extra_forbidden"
        yield finding


def _is_below(detail: Mapping[str, Any], above: Mapping[str, Any]) -> bool:
    loc = above["loc"]
    return detail["loc"][: len(loc)] == loc and len(detail["loc"]) > len(loc)


def _refused(document: Document, detail: Mapping[str, Any], cause: SceneError) -> Iterator[Finding]:
    """Findings of a check of its own; faults of a file that the scene names stand in that file."""
    path = _path(document.data, detail["loc"])
    for fault in cause.faults:
        mark = document.place(path).key
        if fault.where:
            name, line, column = _WHERE.findall(fault.where)[0]
            rank = document.place(()).value.rank
            mark = Mark(rank, shown(name, 500), int(line or 0), int(column or 1))
        whole = (*path, fault.path) if fault.path else path
        found, expected = shown(fault.found, 300), shown(fault.expected, 300)
        yield Finding(mark, whole, found, expected, fault.cure)


_WHERE = re.compile(r"\A(.*?)(?::(\d+))?(?::(\d+))?\Z", re.DOTALL)


def _finding(document: Document, detail: Mapping[str, Any], hint: bool) -> Finding:
    kind, ctx = detail["type"], detail.get("ctx", {})
    last = detail["loc"][-1] if kind in ("missing", "extra_forbidden") else None
    path = _path(document.data, detail["loc"], last)
    if kind in ("union_tag_not_found", "union_tag_invalid"):  # kind: missing, or of no cam
        path = (*path, ctx["discriminator"].strip("'"))
        kind = "missing" if kind == "union_tag_not_found" else "literal_error"
    short = kind == "missing" and isinstance(last, int)
    if short:  # a list of fixed length
        path = path[:-1]
    place = document.place(path)
    fields, field = _schema(path, document)
    about = f" ({field.description})" if field and field.description else ""
    mark = place.key if kind in _AT_KEY and not short else place.value
    if kind == "extra_forbidden":
        return Finding(mark, path, *_unknown_key(path, document, hint))
    if short or kind in ("too_short", "too_long", "string_too_short", "string_too_long"):
        value = document.value(path)
        kind_of = "values" if isinstance(value, list) else "characters"
        what = "a list" if isinstance(value, list) else _shown(document, path)
        found = f"found {what} of {len(value)} {kind_of}"
        expected = "more of them" if short else _EXPECTED[kind].format(**ctx)
        return Finding(mark, path, found, f"expected {expected}", f"change {_name(path)}{about}")
    if kind == "missing":
        key = path[-1]
        if fields and field and not _words(field.annotation) and "discriminator" not in ctx:
            return Finding(mark, path, f"no section '{key}'", f"expected {_keys(fields)}", "add it")
        choices = _choices(field)
        expected = f"expected {choices or (field and field.description) or 'a value'}"
        cure = f"add '{key}: ...'" + (about if choices else "")
        return Finding(mark, path, f"no key '{key}'", expected, cure)
    if kind == "value_error":
        message = shown(str(ctx.get("error") or detail["msg"]), 400)
        return Finding(mark, path, message, "", f"change the values of {dotted(path)}")
    if kind in _MAP_TYPES:
        expected = _keys(fields)
    elif kind == "literal_error":
        expected = _choices(field)
        if fields and "discriminator" not in ctx:
            expected += f" or {_keys(fields)}"
    elif kind in _EXPECTED:
        expected = _EXPECTED[kind].format(**ctx)
    else:
        expected = detail["msg"].partition("should be ")[2] or detail["msg"]
    found = f"found {_shown(document, path)}"
    cure = _cure(document.value(path), path, kind, expected) + about
    return Finding(mark, path, found, f"expected {expected}", cure)


def _path(data: Any, location: tuple[str | int, ...], last: str | int | None = None) -> Path:
    """A location without the names of union members, which are no keys of the data."""
    path: list[str] = []
    for number, key in enumerate(location):
        if number == 1 and location[0] == "cam" and isinstance(data, dict):
            continue  # the kind of cam
        at_end = number == len(location) - 1 and key == last
        item = isinstance(data, list) and isinstance(key, int) and key < len(data)
        if item or (isinstance(data, dict) and key in data):
            data = data[key]
        elif not at_end:
            continue
        path.append(str(key))
    return tuple(path)


def _schema(path: Path, document: Document) -> tuple[dict[str, FieldInfo], FieldInfo | None]:
    """(keys that a map at the path may have, field of its last key) from the sections' models."""
    models: list[type[BaseModel]] = [Scene]
    field = None
    for n, key in enumerate(path, 1):
        known = [m.model_fields[key] for m in models if key in m.model_fields]
        if known:
            field = known[0]
            models = [m for f in known for m in _models(f.annotation)]
        elif models or not key.isdecimal():  # an item of a list has the field of the list
            return {}, None
        if any("kind" in m.model_fields for m in models):
            kind = document.value((*path[:n], "kind"))
            chosen = [m for m in models if kind in get_args(m.model_fields["kind"].annotation)]
            if not chosen:
                return {"kind": models[0].model_fields["kind"]}, field
            models = chosen
    return {key: f for model in models for key, f in model.model_fields.items()}, field


def _models(annotation: Any) -> list[type[BaseModel]]:
    """The models in a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]


def _choices(field: FieldInfo | None) -> str:
    """`one of fixed, up, down` for a key that takes words only (or is of a kind), else ''."""
    words = _words(field.annotation) if field else []
    for model in _models(field.annotation) if field else []:
        kind = model.model_fields.get("kind")
        words += _words(kind.annotation) if kind else []
    return ("one of " if len(words) > 1 else "") + ", ".join(words)


def _words(annotation: Any) -> list[str]:
    return [
        word
        for part in get_args(annotation)
        for word in ([part] if isinstance(part, str) else _words(part))
    ]


def _keys(fields: Mapping[str, Any]) -> str:
    return f"a map with the keys {', '.join(fields)}" if fields else "a map"


def _unknown_key(path: Path, document: Document, hint: bool) -> tuple[str, str, str]:
    key, known = path[-1], list(_schema(path[:-1], document)[0])
    expected = "expected one of " + ", ".join(known)
    if key == "<<":
        return "found a merge key '<<'", expected, "write the keys out, merging is not read"
    cure = "remove it"
    if hint and len(key) <= 40:
        longer = [name for name in known if name.startswith(f"{key}_")]
        sections = [(name, _schema((name,), document)[0]) for name in Scene.model_fields]
        elsewhere = [f"{name}.{key}" for name, keys in sections if key in keys]
        elsewhere = [place for place in elsewhere if place != ".".join(path)]
        near = longer[0] if longer else "" if elsewhere else _nearest(key, known)
        if near or elsewhere:
            cure = (
                f"did you mean {' or '.join(elsewhere) if elsewhere and not near else repr(near)}?"
            )
    return f"found the unknown key '{shown(key)}'", expected, cure


def _nearest(word: str, known: list[str]) -> str:
    import difflib  # only after a mistake

    near = difflib.get_close_matches(word[:40].lower(), known, n=1, cutoff=0.6)
    return near[0] if near else ""


def _shown(document: Document, path: Path) -> str:
    """A value as a person wrote it."""
    value = document.value(path)
    if isinstance(value, dict | list):
        kind = "map" if isinstance(value, dict) else "list"
        return f"a {kind}" if value else f"an empty {kind}"
    if isinstance(value, str):
        return f"'{shown(value)}'"
    text = document.places[path].text if path in document.places else None
    return "nothing" if value is None and not text else shown(text or str(value))


def _cure(value: Any, path: Path, kind: str, expected: str) -> str:
    """What to do about a value of the wrong type or size."""
    name = _name(path)
    if kind in _MAP_TYPES:
        dashes = ", without dashes or brackets" if isinstance(value, list) else ""
        return f"write 'key: value' lines below {name}{dashes}"
    if kind == "tuple_type":
        single = not isinstance(value, dict | None)
        return f"write {name} as a list: [{value if single else '...'}]"
    if isinstance(value, list | dict):
        return f"give {name} a single value"
    if value is None:
        return f"give {name} a value, or remove the line"
    if isinstance(value, float) and not math.isfinite(value):
        return f"give {name} a finite number"
    if kind.startswith(("greater", "less")):
        return f"give {name} a value in this range"
    if kind == "literal_error":
        near = _nearest(str(value), re.findall(r"[\w.-]+", expected.partition("one of")[2]))
        return f"did you mean '{near}'?" if near else "choose one of these"
    if isinstance(value, bool):
        return "true and false are neither numbers nor text here"
    if kind.startswith(("float", "int")) and isinstance(value, str):
        swept = path[-2:] == ("run", "rpm") and ":" in value
        cure = oddity(value) or f"give {name} as a number"
        return f"a range of speeds stands in sweep.rpm; {cure}" if swept else cure
    if kind.startswith("int") and isinstance(value, float):
        return "round it"
    return f"put {name} in quotes" if kind == "string_type" else f"change {name}"


def _name(path: Path) -> str:
    """What a cure calls the value: its key, or the place in a list and the list's key."""
    if len(path) > 1 and path[-1].isdecimal():
        return f"value {int(path[-1]) + 1} of {shown(path[-2], 40)}"
    return shown(path[-1], 40) if path else "the scene"
