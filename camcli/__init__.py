"""Motion of a follower on a rotating cam that can lift off, bounce, chatter and come back.

    import camcli

    scene = camcli.load_scene("scene.yaml", {"run.rpm": 700.0})
    result = camcli.sweep(scene)
    result.tables["impacts"]["theta_deg"]     # NumPy arrays, named as in the CSV files
    figure = camcli.plot(result)              # a matplotlib Figure
    result.save("out/sweep")                  # the files that the command `cam sweep` writes

Nothing is imported before it is used.
"""

from camcli.api import ANALYSES

TYPE_CHECKING = False  # for who checks types; `typing` takes milliseconds to import
if TYPE_CHECKING:  # one line each: names of the library, as it is imported
    from typing import Any

    from camcli.api.basins import basins as basins
    from camcli.api.classify import classify as classify
    from camcli.api.detach import detach as detach
    from camcli.api.explore import explore as explore
    from camcli.api.orbits import orbits as orbits
    from camcli.api.result import Result as Result
    from camcli.api.result import plot as plot
    from camcli.api.simulate import simulate as simulate
    from camcli.api.sweep import sweep as sweep
    from camcli.errors import Fault as Fault
    from camcli.errors import SceneError as SceneError
    from camcli.parallel import Work as Work
    from camcli.scene import Scene as Scene
    from camcli.scene import load_scene as load_scene
    from camcli.system import Follower as Follower
    from camcli.system import System as System


_PLACES = {
    **{name: f"camcli.api.{name}" for name in ANALYSES},
    **dict.fromkeys(("Result", "plot"), "camcli.api.result"),
    **dict.fromkeys(("Fault", "SceneError"), "camcli.errors"),
    **dict.fromkeys(("Scene", "load_scene"), "camcli.scene"),
    **dict.fromkeys(("Follower", "System"), "camcli.system"),
    "Work": "camcli.parallel",
}
__all__ = ["__version__", *_PLACES]


def __getattr__(name: str) -> "Any":
    """A public name, imported when it is first asked for; raises AttributeError for another one."""
    from importlib import import_module

    if name == "__version__":
        from camcli.installed import version

        return version("camcli")
    if name not in _PLACES:
        raise AttributeError(f"module 'camcli' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return __all__
