"""Cams that are one wave compile from cosine and sine, to the same table as any other cam."""

from dataclasses import replace
from random import Random

from camcli import load_scene
from camcli.cams.compile import build


class AsAnyOther:
    """A cam whose parts do not say that they are waves."""

    def __init__(self, shape):
        self.shape = shape

    def parts(self):
        return [replace(part, wave=None) for part in self.shape.parts()]


def cams():
    """Oscillators near resonance and far, without damping, pressed hard and hardly."""
    random = Random(5)
    for clearance in (0.0, -0.5, 1e5, 10 ** random.uniform(-3, 3)):
        for damping, frequency in ((0.0, 2.0), (0.1, 1.0), (0.3, random.uniform(0.3, 6.0))):
            section = {"kind": "oscillator", "damping": damping, "frequency": frequency}
            section |= {"amplitude": 10 ** random.uniform(-3, 3), "clearance": clearance}
            yield load_scene({"follower": {"restitution": 0.8}, "cam": section}).cam
    follower = {"mass": 1, "stiffness": 1, "restitution": 0.8}
    yield load_scene(
        {"follower": follower, "cam": {"kind": "eccentric", "base": 0.1, "lift": 0.3}}
    ).cam


def test_a_wave_has_the_table_of_any_other_cam():
    for cam in cams():
        assert any(part.wave is not None for part in cam.parts())
        for strobe in (0.0, 1.0):
            assert build(cam, strobe) == build(AsAnyOther(cam), strobe)
