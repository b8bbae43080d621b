"""The scene: a YAML file, validated as a whole, with `--set` and options on top of it."""

from camcli.scene.files import default_scene_path
from camcli.scene.load import load_scene, resolved, scene_hash, scene_of
from camcli.scene.machine import Follower, RpmRange, Run, Start
from camcli.scene.overrides import parse_rpm
from camcli.scene.schema import Cam, Detach, Scene, Simulate, Sweep, json_schema

__all__ = [
    "Cam",
    "Detach",
    "Follower",
    "RpmRange",
    "Run",
    "Scene",
    "Simulate",
    "Start",
    "Sweep",
    "default_scene_path",
    "json_schema",
    "load_scene",
    "parse_rpm",
    "resolved",
    "scene_hash",
    "scene_of",
]
