"""Every limit of the scene: the last number within it passes, the first one beyond it is refused.

The limits are those of the shipped configs/schema.json, which editors read; the scenes go through
`load_scene`, as a user's do. A number at its limit may be refused for another reason, as a circle
of 1e6 m that touches no other one, but never for its size.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from copy import deepcopy
from math import inf, nextafter
from pathlib import Path
from typing import Any

import pytest
import yaml

from camcli.errors import Fault, SceneError
from camcli.scene import load_scene

CONFIGS = Path(__file__).parents[2] / "configs"
SCHEMA = json.loads((CONFIGS / "schema.json").read_text())
CAMS = {
    "arcs": yaml.safe_load((CONFIGS / "chapter.yaml").read_text())["cam"],
    "eccentric": {"kind": "eccentric", "base": 0.0, "lift": 0.01},
    "law": {
        "kind": "law", "base": 0.0, "lift": 0.01, "top_dwell_deg": 5,
        "rise": {"start_deg": 90, "length_deg": 60,
                 "law": {"scca": {"b": 0.25, "c": 0.5, "d": 0.25}}},
        "fall": {"length_deg": 60, "law": "harmonic"},
    },
    "oscillator": {"kind": "oscillator", "mass": 1.0, "stiffness": 1.0, "damping": 0.1,
                   "damping_ratio": None, "amplitude": 1.0, "frequency": 0.5, "clearance": 0.1},
    "table": yaml.safe_load((CONFIGS / "lift-table.yaml").read_text())["cam"],
}  # fmt: skip
WHOLE = {  # what has to be there for a number below it
    "follower": {"mass": 1.0, "stiffness": 1000.0, "restitution": 0.5},
    "cam": CAMS["eccentric"],
    "spring": {},
    "contact": {"width": 0.01},
    "run": {"start": {}},
    "sweep": {"rpm": {}, "zoom": [{"start": 670, "stop": 680}], "also": [{}],
              "vary": [{"key": "rpm", "start": 600, "stop": 800}],
              "phases_deg": [149, 172], "positions_m": [0.1, 0.2]},
    "detach": {"rpm": {}, "tolerance": [{"key": "follower.mass", "percent": 5}],
               "force_rpm": [600.0]},
    "orbits": {"rpm": {}, "range": [1, 2], "curve_range": [1, 2],
               "vary": [{"key": "rpm", "start": 600, "stop": 800}]},
    "basins": {"rpm": {}, "q": [0.1, 0.9], "v": [-1, 1], "cells": [10, 10],
               "vary": [{"key": "rpm", "start": 600, "stop": 800}]},
    "classify": {"rpm": {}, "vary": [{"key": "rpm", "start": 600, "stop": 800}]},
    "figure": {"title": "t", "command": "sweep"},
}  # fmt: skip
ELEMENTS = {  # different ones, for lists that are as long as they may be or longer
    "vary": [{"key": f"follower.{name}", "start": 0.1, "stop": 0.2}
             for name in ("mass", "stiffness", "restitution")],
    "zoom": [{"start": 670 + k, "stop": 680} for k in range(5)],
    "also": [{"q": 1.0 + k} for k in range(17)],
    "tolerance": [{"key": f"follower.{name}", "percent": 5}
                  for name in ("mass", "stiffness", "damping", "gravity", "preload",
                               "restitution")] + [{"key": "cam.lift", "percent": 5}],
    "beside": [CAMS["eccentric"]] * 3,
    "phases_deg": [0.1, 0.2, 0.3], "positions_m": [0.1, 0.2, 0.3],
    "q": [0.1, 0.2, 0.3], "v": [0.1, 0.2, 0.3], "cells": [1, 2, 3],
    "range": [0.1, 0.2, 0.3], "curve_range": [0.1, 0.2, 0.3],
    "formats": ["png"], "panels": ["motion"], "cases": ["p3"], "methods": ["core"],
    "sections": ["impacts"],
}  # fmt: skip
KEYWORDS = (
    "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minLength", "maxLength",
    "minItems", "maxItems",
)  # fmt: skip
Place = tuple[str, ...]


def limits(node: dict[str, Any], path: Place = ()) -> Iterator[tuple[Place, str, Any, bool]]:
    """(path, keyword, value, whether it is of whole numbers) of every limit below a node."""
    if "$ref" in node:
        node = SCHEMA["$defs"][node["$ref"].rpartition("/")[2]]
    whole = node.get("type") == "integer"
    yield from ((path, word, node[word], whole) for word in KEYWORDS if word in node)
    for one in node.get("anyOf", ()):
        yield from limits(one, path)
    for name, inner in node.get("properties", {}).items():
        yield from limits(inner, (*path, name))
    for k, inner in enumerate(node.get("prefixItems", ())):
        yield from limits(inner, (*path, str(k)))
    if "items" in node:
        yield from limits(node["items"], (*path, "0"))


LIMITS = [("eccentric", *limit) for limit in limits(SCHEMA)] + [
    (kind, *limit)
    for kind, reference in SCHEMA["properties"]["cam"]["discriminator"]["mapping"].items()
    for limit in limits({"$ref": reference}, ("cam",))
]


def faults(kind: str, path: Place, value: Any) -> list[Fault]:
    """What is said of a scene with one value, about that value."""
    scene = deepcopy({**WHOLE, "cam": CAMS[kind]})
    if kind == "oscillator":  # it allows nothing beside it that follows from it
        scene = deepcopy({"cam": CAMS[kind], "follower": {"restitution": 0.5}})
    *sections, last = path
    if sections == ["spring"] and last != "solid_at":  # loads stand in the place of a stiffness
        del scene["follower"]["stiffness"]
    place: Any = scene
    for name in sections:
        place = place[int(name)] if name.isdigit() else place.setdefault(name, {})
    place[int(last) if last.isdigit() else last] = value
    try:
        load_scene(scene, folder=CONFIGS)
    except SceneError as error:
        return [fault for fault in error.faults if fault.path == ".".join(path)]
    return []


def within_and_beyond(name: str, keyword: str, limit: Any, whole: bool) -> tuple[Any, Any, str]:
    """The last value within a limit, the first one beyond it, and how the limit is told."""
    low = keyword.lower().endswith("minimum") or keyword.startswith("min")
    way = -inf if low else inf
    if keyword in ("minimum", "maximum"):
        beyond = limit + (-1 if low else 1) if whole else nextafter(limit, way)
        return limit, beyond, f"expected a number of at {'least' if low else 'most'} {limit:.15g}"
    if keyword.startswith("exclusive"):
        said = f"expected a number {'greater' if low else 'less'} than {limit:.15g}"
        return nextafter(limit, -way), limit, said
    things, beyond = ELEMENTS.get(name, "x" * 4001), limit + (-1 if low else 1)
    said = f"expected at {'least' if low else 'most'} {limit} "
    if (keyword, limit) == ("minItems", 2):  # of a list of two
        said = "expected 2 values"
    return things[:limit], things[:beyond], said


@pytest.mark.parametrize(
    ("kind", "path", "keyword", "limit", "whole"),
    LIMITS,
    ids=[f"{kind}-{'.'.join(path)}-{word}" for kind, path, word, *_ in LIMITS],
)
def test_every_limit_of_the_schema(kind, path, keyword, limit, whole):
    within, beyond, said = within_and_beyond(path[-1], keyword, limit, whole)
    assert not any(said in fault.expected for fault in faults(kind, path, within))
    (found,) = faults(kind, path, beyond)
    assert found.expected.startswith(said)


def test_the_limits_are_all_there():
    """So that a walk that finds too few is noticed: numbers, texts and lists in every section."""
    assert len(LIMITS) > 250
    found = {(kind if path[0] == "cam" else "", path[0]) for kind, path, *_ in LIMITS}
    assert {kind for kind, _ in found} == {"", *CAMS}
    assert {section for _, section in found} == {"cam", "plot", "simulate", "bench", *WHOLE}


def test_a_zoom_may_reach_the_ends_of_the_range_and_no_further():
    for low, high, inside in ((660, 760, True), (700, 660, True), (659.999, 700, False),
                              (700, 760.001, False), (700, 700, False)):  # fmt: skip
        asked = {"sweep.rpm": {"start": 760.0, "stop": 660.0, "num": 3},
                 "sweep.zoom": [{"start": float(low), "stop": float(high), "num": 3}]}  # fmt: skip
        if inside:
            load_scene(None, asked)
        else:
            with pytest.raises(SceneError, match="within 660 to 760"):
                load_scene(None, asked)
