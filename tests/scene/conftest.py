"""A valid scene as text, and what is said of scene texts."""

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene

VALID = """\
follower: {mass: 1.221, stiffness: 1430.8, restitution: 0.8}
cam:
  kind: arcs
  base_radius: 0.4
  flank_center: 0.45
  flank_radius: 0.85
  nose_center: 0.40393320723821
  nose_radius: 0.15
  top_dwell_deg: 40
  offset: 0.3
"""


@pytest.fixture
def valid():
    """Text of a scene with nothing but its two required sections (10 lines)."""
    return VALID


@pytest.fixture
def load(tmp_path):
    """Load scene text from a file."""

    def load_text(text, overrides=(), options=None):
        path = tmp_path / "scene.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_scene(path, overrides, options)

    return load_text


@pytest.fixture
def faults(load):
    """Faults of scene text."""

    def faults_of(text, overrides=(), options=None):
        with pytest.raises(SceneError) as caught:
            load(text, overrides, options)
        return caught.value.faults

    return faults_of


@pytest.fixture
def places(faults):
    """(line:column or source, path) of each fault."""

    def places_of(text, overrides=(), options=None):
        return [
            (fault.where.partition("scene.yaml:")[2] or fault.where, fault.path)
            for fault in faults(text, overrides, options)
        ]

    return places_of
