"""The scene: a YAML file or a dict, validated as a whole, with overrides on top of it."""

from camcli.scene.document import scalar
from camcli.scene.load import (
    default_scene_path,
    here_or_shipped,
    load_scene,
    parse_rpm,
    resolved,
    scene_hash,
)
from camcli.scene.schema import MORE_THAN_THE_LIFT, Axis, Cam, Orbits, Scene, Varying, json_schema

__all__ = [
    "MORE_THAN_THE_LIFT", "Axis", "Cam", "Orbits", "Scene", "Varying", "default_scene_path",
    "here_or_shipped", "json_schema", "load_scene", "parse_rpm", "resolved", "scalar", "scene_hash",
]  # fmt: skip
