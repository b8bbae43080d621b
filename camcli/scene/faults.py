"""Validation errors to findings: where it stands, what was found, what is expected, what to do.

What is expected are pydantic's own words, what a key means those of the scene's JSON Schema.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from pydantic import ValidationError

from camcli.errors import SceneError, plural, shown
from camcli.scene.document import Document, Finding, Mark, Path, dotted, oddity
from camcli.scene.schema import Scene

MAX_HINTS = 50  # nearest names are looked up for so many unknown keys: the search is not free
MAX_WORDS = 200  # errors put into words, in the order of the source; the others are only counted

_WHERE = re.compile(r"\A(.*?)(?::(\d+))?(?::(\d+))?\Z", re.DOTALL)
_EXPECTED = {  # where YAML has another word than Python, and bounds as they were written
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "tuple_type": "a list",
    "bool_type": "true or false",
    "string_type": "text",
    "greater_than": "a number greater than {gt:.15g}",
    "greater_than_equal": "a number of at least {ge:.15g}",
    "less_than": "a number less than {lt:.15g}",
    "less_than_equal": "a number of at most {le:.15g}",
}
_SIZES = {  # of a value that has a right type
    "greater_than", "greater_than_equal", "less_than", "less_than_equal", "string_too_short",
}  # fmt: skip
_CURES = {  # of a value of the wrong type
    "tuple_type": "write {name} as a list: [{value}]",
    "string_type": "put {name} in quotes",
}

Schema = Mapping[str, Any]


def findings(document: Document, error: ValidationError) -> Iterator[Finding]:
    """A finding for each of pydantic's errors about the data of a document.

    They come in the order of the source. Some errors follow from others, and have no finding: that
    a key is missing which is misspelt; that a value of the wrong size is of none of the other types
    it might be of; that a list is too short without its bad items.
    """
    errors = [(_path(document.data, each), each) for each in error.errors(include_url=False)]
    errors.sort(key=lambda path_and_detail: document.place(path_and_detail[0]).value)
    missing = [path for path, detail in errors if detail["type"] == "missing"]
    unknown = [path for path, detail in errors if detail["type"] == "extra_forbidden"]
    misspelt = {path for path in missing if _is_misspelt(path, unknown[:MAX_HINTS])}
    of_wrong_size = {path for path, detail in errors if detail["type"] in _SIZES}
    with_bad_items = {path[:-1] for path, _ in errors}
    hints_left = MAX_HINTS
    for number, (path, detail) in enumerate(errors):
        kind = detail["type"]
        if path in misspelt:
            continue
        if path in of_wrong_size and kind not in _SIZES:
            continue
        cause = detail.get("ctx", {}).get("error")
        if number >= MAX_WORDS:
            yield Finding(document.place(path).value, path, "")
        elif isinstance(cause, SceneError):
            yield from _refused(document, path, cause)
        elif kind == "extra_forbidden":
            found, expected, cure = _unknown_key(path, document, hint=hints_left > 0)
            yield Finding(document.place(path).key, path, found, expected, cure)
            hints_left -= 1
        elif kind != "too_short" or path not in with_bad_items:
            yield _finding(document, path, detail)


def _is_misspelt(path: Path, unknown: Sequence[Path]) -> bool:
    """Whether a key that is missing is there misspelt: an unknown key of its section is like it."""
    *section, missing_key = path
    return any(
        list(other[:-1]) == section and _nearest(other[-1], [missing_key]) for other in unknown
    )


def _refused(document: Document, path: Path, cause: SceneError) -> Iterator[Finding]:
    """Findings of a SceneError that a validator of the scene raised, not pydantic itself.

    path: of the section that was being validated; a fault may name a key below it. A fault with a
    place of its own (`where`, NAME:LINE:COLUMN) is about a file that the scene names, as a lift
    table: it keeps that place, and has the rank of the scene itself.
    """
    for fault in cause.faults:
        below = fault.path.split(".") if fault.path else []
        full_path = (*path, *below)
        mark = document.place(full_path).key
        if fault.where:
            name, line, column = _WHERE.findall(fault.where)[0]
            rank = document.place(()).value.rank
            mark = Mark(rank, shown(name, 500), int(line or 0), int(column or 1))
        found = shown(fault.found, 300)
        expected = shown(fault.expected, 300)
        yield Finding(mark, full_path, found, expected, fault.cure)


def wanted(detail: Mapping[str, Any]) -> str:
    """What a value should have been, by an error of pydantic: a number of at least 0."""
    if detail["type"] in _EXPECTED:
        return _EXPECTED[detail["type"]].format(**detail.get("ctx", {}))
    words = re.split("should (?:be |have )", detail["msg"], maxsplit=1)[-1]
    return words.replace("a valid ", "a ").partition(" after validation")[0]


def _finding(document: Document, path: Path, detail: Mapping[str, Any]) -> Finding:
    """What one error of pydantic means to who wrote the scene: place, found, expected, cure.

    path: of the key it is about. detail: the error as `ValidationError.errors` gives it: `type`,
    `loc`, `msg`, and in `ctx` what the type knows more.
    """
    kind = detail["type"]
    ctx = detail.get("ctx", {})
    if kind == "missing" and isinstance(detail["loc"][-1], int):  # in a list of fixed length
        path = path[:-1]
        kind = "too_short"
    if ctx.get("discriminator") == "'kind'":
        path = (*path, "kind")
        kind = "missing" if kind == "union_tag_not_found" else kind
    if kind == "missing":
        return _missing(document, path)
    place = document.place(path)
    if kind == "value_error":
        message = shown(str(ctx.get("error") or detail["msg"]), 400)
        return Finding(place.key, path, message, "", f"change the values of {dotted(path)}")
    schemas = _schemas(path, document)
    keys = _keys_of(schemas)
    words = _words_of(schemas)
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        kind = "map"
        expected = _map(keys)
    elif kind in ("literal_error", "union_tag_invalid"):
        kind = "word"
        expected = f"one of {', '.join(words)}"
        if keys:
            expected += f" or {_map(keys)}"
    else:
        expected = wanted(detail)
        if expected == "Field required":  # of an item, see above
            lengths = [schema["minItems"] for schema in schemas if "minItems" in schema]
            expected = plural(lengths[0], "value")
    found = f"found {_shown(document, path)}"
    cure = _cure(document.value(path), path, kind, words)
    meaning = _meaning(schemas)
    if meaning:
        cure += f" ({meaning})"
    return Finding(place.value, path, found, f"expected {expected}", cure)


def _missing(document: Document, path: Path) -> Finding:
    """A key, or a section, that has to be there."""
    mark = document.place(path).key
    schemas = _schemas(path, document)
    keys = _keys_of(schemas)
    words = _words_of(schemas)
    if keys and not words:
        return Finding(mark, path, f"no section '{path[-1]}'", f"expected {_map(keys)}", "add it")
    meaning = _meaning(schemas)
    cure = f"add '{path[-1]}: ...'"
    if not words:
        expected = meaning or "a value"
    else:
        expected = f"one of {', '.join(words)}"
        if meaning:
            cure += f" ({meaning})"
    return Finding(mark, path, f"no key '{path[-1]}'", f"expected {expected}", cure)


def _path(data: Any, detail: Mapping[str, Any]) -> Path:
    """The path of an error: its location without the names of union members, which are no keys.

    data: of the document. pydantic says of a cam ("cam", its kind, key, ...), and names models of
    other unions likewise.
    """
    path: list[str] = []
    location = detail["loc"]
    last = len(location) - 1
    last_may_be_absent = detail["type"] == "missing"
    for number, key in enumerate(location):
        if number == 1 and location[0] == "cam" and isinstance(data, dict):
            continue  # the kind of cam
        is_item = isinstance(data, list) and isinstance(key, int) and key < len(data)
        is_key = isinstance(data, dict) and key in data
        if is_item or is_key:
            data = data[key]
            path.append(str(key))
        elif last_may_be_absent and number == last:
            path.append(str(key))
    return tuple(path)


# -- what the scene's JSON Schema says of a path ------------------------------------------------


@cache
def _root() -> Schema:
    """The JSON Schema of a whole scene."""
    return Scene.model_json_schema()


def _alternatives(schema: Schema) -> list[Schema]:
    """A schema and what it allows instead of itself, references followed."""
    reference = schema.get("$ref", "").rpartition("/")[2]
    whole = {**_root()["$defs"][reference], **schema} if reference else schema
    alternatives = [whole]
    for option in (*whole.get("anyOf", ()), *whole.get("oneOf", ())):
        alternatives += _alternatives(option)
    return alternatives


def _schemas(path: Path, document: Document) -> list[Schema]:
    """What the value at a path may follow; empty where no such key is known."""
    schemas = _alternatives(_root())
    for depth, key in enumerate(path, 1):
        with_key = [schema for schema in schemas if key in schema.get("properties", ())]
        below: list[Schema] = [schema["properties"][key] for schema in with_key]
        if key.isdecimal():
            below += _schemas_of_items(schemas)
        schemas = []
        for schema in below:
            schemas += _alternatives(schema)
        schemas = _of_kind(schemas, document.value((*path[:depth], "kind")))
    return schemas


def _schemas_of_items(schemas: Sequence[Schema]) -> list[Schema]:
    """What an item of a list may follow; it has the description of its list where it has none."""
    meaning = _meaning(schemas)
    described = {"description": meaning} if meaning else {}
    return [{**described, **schema["items"]} for schema in schemas if "items" in schema]


def _of_kind(schemas: list[Schema], kind: Any) -> list[Schema]:
    """The schemas of this kind of cam; where there are none, one that only lists the kinds.

    All of them, where they have no key `kind`.
    """
    with_kind = [schema for schema in schemas if "kind" in schema.get("properties", ())]
    if not with_kind:
        return schemas
    of_this_kind = []
    all_kinds: list[str] = []
    for schema in with_kind:
        kinds = _words(schema["properties"]["kind"])
        all_kinds += kinds
        if kind in kinds:
            of_this_kind.append(schema)
    return of_this_kind or [{**schemas[0], "properties": {"kind": {"enum": all_kinds}}}]


def _words(schema: Schema) -> list[str]:
    """The words that a key takes."""
    values = (*schema.get("enum", ()), schema.get("const"))
    return [value for value in values if isinstance(value, str)]


def _words_of(schemas: Sequence[Schema]) -> list[str]:
    """The words that a key takes by any of its schemas."""
    return [word for schema in schemas for word in _words(schema)]


def _keys_of(schemas: Sequence[Schema]) -> list[str]:
    """The keys that a section has by any of its schemas."""
    return [key for schema in schemas for key in schema.get("properties", ())]


def _meaning(schemas: Sequence[Schema]) -> str:
    """What a key means, '' where no schema says it."""
    return next((schema["description"] for schema in schemas if "description" in schema), "")


def _map(keys: list[str]) -> str:
    """What is expected where a section belongs."""
    return f"a map with the keys {', '.join(keys)}" if keys else "a map"


def _unknown_key(path: Path, document: Document, hint: bool) -> tuple[str, str, str]:
    """(found, expected, cure) for a key that its section has not.

    hint: whether to look for the name that may have been meant: a longer one, the same in another
    section, or one that is spelt alike.
    """
    key = path[-1]
    known = _keys_of(_schemas(path[:-1], document))
    expected = "expected one of " + ", ".join(known)
    if key == "<<":
        return "found a merge key '<<'", expected, "write the keys out, merging is not read"
    cure = "remove it"
    if hint and len(key) <= 40:
        near = _meant(path, known, document)
        if near:
            cure = f"did you mean {near}?"
    return f"found the unknown key '{shown(key)}'", expected, cure


def _meant(path: Path, known: list[str], document: Document) -> str:
    """The key that was probably meant by the unknown one at a path; empty where none is like it.

    known: the keys of its section.
    """
    key = path[-1]
    longer = [name for name in known if name.startswith(f"{key}_")]
    if longer:
        return repr(longer[0])
    elsewhere = [
        f"{section}.{key}"
        for section in Scene.model_fields
        if key in _keys_of(_schemas((section,), document))
    ]
    return " or ".join(elsewhere) or _nearest(key, known)


# -- words -------------------------------------------------------------------------------------


def _nearest(word: str, known: list[str]) -> str:
    """The known word that is most like the one found, in quotes; '' where none is."""
    import difflib  # only after a mistake

    near = difflib.get_close_matches(word[:40].lower(), known, n=1, cutoff=0.6)
    return repr(near[0]) if near else ""


def _shown(document: Document, path: Path) -> str:
    """A value as a fault names it: as a person wrote it, or what kind of thing it is."""
    value = document.value(path)
    if isinstance(value, dict):
        return "a map" if value else "an empty map"
    if isinstance(value, list):
        return f"a list of {plural(len(value), 'value')}" if value else "an empty list"
    if isinstance(value, str):
        return f"'{shown(value)}'"
    as_written = document.places[path].text if path in document.places else None
    if value is None and not as_written:
        return "nothing"
    return shown(as_written or str(value))


def _cure(value: Any, path: Path, kind: str, words: list[str]) -> str:
    """What to do about a value of the wrong type or size.

    kind: of the error: `map` or `word` where one is expected, else the `type` of pydantic's error;
    words: those that the key takes.
    """
    name = shown(path[-1], 40) if path else "the scene"
    if len(path) > 1 and name.isdecimal():
        name = f"value {int(name) + 1} of {shown(path[-2], 40)}"
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if is_number and path[-1:] == ("rpm",) and kind == "map":
        return f"write one speed as rpm: {{start: {value}, stop: {value}}}"
    if is_number and path[-1:] == ("cells",) and kind == "tuple_type":
        return f"write cells along both sides: [{value}, {value}]"
    if kind == "map":
        return f"write 'key: value' lines below {name}"
    if value is None:
        return f"give {name} a value, or remove the line"
    if kind in _CURES:
        return _CURES[kind].format(name=name, value=shown(str(value), 40))
    is_range = (isinstance(value, dict) and "start" in value) or (
        isinstance(value, str) and ":" in value
    )
    if is_range and path[-2:] == ("run", "rpm"):
        return "a range of speeds stands in sweep.rpm; give rpm a single value"
    if isinstance(value, list | dict):
        return f"give {name} a single value" if kind.endswith("type") else f"change {name}"
    if kind == "word":
        near = _nearest(str(value), words)
        return f"did you mean {near}?" if near else "choose one of these"
    if isinstance(value, str) and kind.startswith(("float", "int")):
        return oddity(value) or f"give {name} as a number"
    if isinstance(value, bool):
        return "true and false are neither numbers nor text here"
    if isinstance(value, float) and kind.startswith(("int", "finite")):
        return "round it" if math.isfinite(value) else f"give {name} a finite number"
    return f"change {name}"
