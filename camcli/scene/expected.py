"""What the scene expects at a path, in words, from its JSON Schema (made only on a fault)."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from camcli.scene.places import Path

_TYPES = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "null": "null",
}


class Expectations:
    """Looks up paths in a JSON Schema; unions are resolved by the data's `kind` or the like."""

    def __init__(self, make_schema):
        self._make_schema = make_schema

    @cached_property
    def _schema(self) -> dict[str, Any]:
        return self._make_schema()

    def at(self, path: Path, data: object) -> dict[str, Any]:
        """Schema of a path, {} where there is none."""
        schema, value = self._settle(self._schema, data), data
        for key in path:
            if isinstance(key, int):
                entry = _item(schema, key)
                value = value[key] if isinstance(value, list) and key < len(value) else None
            else:
                entry = schema.get("properties", {}).get(key, {})
                value = value.get(key) if isinstance(value, dict) else None
            schema = self._settle(entry, value)
        return schema

    def _settle(self, schema: dict[str, Any], value: object) -> dict[str, Any]:
        """Follow references, optional values and unions; the outermost description is kept."""
        description = schema.get("description")
        for _ in range(8):
            if "$ref" in schema:
                schema = self._schema["$defs"][schema["$ref"].rpartition("/")[2]]
            elif "anyOf" in schema:
                schema = next(s for s in schema["anyOf"] if s.get("type") != "null")
            elif "discriminator" in schema:
                schema = self._chosen(schema, value)
            elif "oneOf" in schema:
                schema = self._by_shape(schema["oneOf"], value)
        return {**schema, "description": description or schema.get("description", "")}

    def _chosen(self, union: dict[str, Any], value: object) -> dict[str, Any]:
        by = union.get("discriminator", {})
        name, models = by.get("propertyName", ""), by.get("mapping", {})
        chosen = value.get(name) if isinstance(value, dict) else None
        if isinstance(chosen, str) and chosen in models:
            return {"$ref": models[chosen]}
        return {"type": "object", "properties": {name: {"enum": list(models)}}}

    def _by_shape(self, choices: list[dict[str, Any]], value: object) -> dict[str, Any]:
        """Of a single value or a map: the one that `value` is, the single one tells of the map."""
        maps = [choice for choice in choices if "$ref" in choice]
        if isinstance(value, dict):
            return maps[0]
        keys = list(self._settle(maps[0], {}).get("properties", {}))
        return {**next(choice for choice in choices if "$ref" not in choice), "or": keys}

    def dotted_paths(self, leaf: str) -> list[str]:
        """Dotted paths of the sections' keys with this name."""
        found = []
        for name in self._schema["properties"]:
            section = self.at((name,), {})
            if leaf in section.get("properties", {}):
                found.append(f"{name}.{leaf}")
        return found


def _item(schema: dict[str, Any], number: int) -> dict[str, Any]:
    """Schema of a list's item; a list of fixed length has one for each place."""
    fixed = schema.get("prefixItems", [])
    if number >= len(fixed):
        return schema.get("items", {})
    entry = {"description": schema.get("description", ""), **fixed[number]}
    return {key: value for key, value in entry.items() if value}


def in_words(schema: dict[str, Any]) -> str:
    """`a number greater than 0`, `one of fixed, up, down`, `a map with the keys ...`."""
    choices = schema.get("enum") or ([schema["const"]] if "const" in schema else [])
    if choices:
        words = ("one of " if len(choices) > 1 else "") + ", ".join(str(c) for c in choices)
        return words + (
            f" or a map with the key {', '.join(schema['or'])}" if "or" in schema else ""
        )
    kind = schema.get("type")
    if kind == "object":
        return "a map with the keys " + ", ".join(schema.get("properties", {}))
    words = _TYPES.get(kind, "another value")
    if kind in ("number", "integer"):
        limits = _range(schema)
        return words + limits if limits or kind == "integer" else "a finite number"
    if kind == "array" and "items" in schema:
        return f"a list of {in_words(schema['items'])}"
    if kind == "array" and "prefixItems" in schema:
        return f"a list of {len(schema['prefixItems'])}, each {in_words(schema['prefixItems'][0])}"
    if kind == "string":
        return words + _length(schema)
    return words


def _length(schema: dict[str, Any]) -> str:
    """` of 1 to 200 characters`, ` that matches ...`, '' for any text."""
    low, high = schema.get("minLength", 0), schema.get("maxLength")
    size = f" of {low} to {high} characters" if high else " of some characters" if low else ""
    return size + (f" that matches {schema['pattern']}" if "pattern" in schema else "")


def _range(schema: dict[str, Any]) -> str:
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and high is not None:
        return f" from {low:.15g} to {high:.15g}"
    parts = [
        f" {words} {schema[key]:.15g}"
        for key, words in (
            ("minimum", "of at least"),
            ("exclusiveMinimum", "greater than"),
            ("maximum", "at most"),
            ("exclusiveMaximum", "less than"),
        )
        if key in schema
    ]
    return " and".join(parts)
