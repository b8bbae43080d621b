"""Motion of a follower on a rotating cam that can lift off, bounce, chatter and come back.

    import camcli

    scene = camcli.load_scene("scene.yaml", {"run.rpm": 700.0})
    result = camcli.sweep(scene)
    result.tables["impacts"]["theta_deg"]     # NumPy arrays, named as in the CSV files
    figure = camcli.plot(result)              # a matplotlib Figure
    result.save("out/sweep")                  # the files that the command `cam sweep` writes

Nothing is imported before it is used.
"""

TYPE_CHECKING = False  # for who checks types; `typing` takes milliseconds to import
if TYPE_CHECKING:
    from typing import Any

    from camcli.api.basins import basins
    from camcli.api.classify import classify
    from camcli.api.detach import detach
    from camcli.api.explore import explore
    from camcli.api.orbits import orbits
    from camcli.api.result import Result, plot
    from camcli.api.simulate import simulate
    from camcli.api.sweep import sweep
    from camcli.errors import Fault, SceneError
    from camcli.parallel import Work
    from camcli.scene import Scene, load_scene
    from camcli.system import Follower, System

_ANALYSES = ("basins", "classify", "detach", "explore", "orbits", "simulate", "sweep")
_PLACES = {
    **{name: f"camcli.api.{name}" for name in _ANALYSES},
    **dict.fromkeys(("Result", "plot"), "camcli.api.result"),
    **dict.fromkeys(("Fault", "SceneError"), "camcli.errors"),
    **dict.fromkeys(("Scene", "load_scene"), "camcli.scene"),
    **dict.fromkeys(("Follower", "System"), "camcli.system"),
    "Work": "camcli.parallel",
}
__all__ = [
    "Fault", "Follower", "Result", "Scene", "SceneError", "System", "Work", "__version__", "basins",
    "classify", "detach", "explore", "load_scene", "orbits", "plot", "simulate", "sweep",
]  # fmt: skip


def __getattr__(name: str) -> "Any":
    from importlib import import_module

    if name == "__version__":
        from importlib.metadata import version

        return version("camcli")
    if name not in _PLACES:
        raise AttributeError(f"module 'camcli' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return __all__
