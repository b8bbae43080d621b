"""Numbers that `cam init` makes up: odd ones, by which a scene that is not filled in is known."""

from math import isclose

from camcli.scene.schema import Scene

MADE_UP = {
    "follower.mass": 0.12345,
    "follower.stiffness": 41234.5,
    "follower.preload": 245.67,
    "cam.lift": 0.010123,
}


def made_up(scene: Scene) -> list[str]:
    """The keys whose numbers are still those of `cam init`, whatever the comments say.

    A third of a spring that was added to the mass is taken off again.
    """
    spring = getattr(scene.spring, "mass", None) or 0.0
    found = []
    for key, value in MADE_UP.items():
        section, _, name = key.partition(".")
        number = getattr(getattr(scene, section), name, None)
        if not isinstance(number, float):  # of another kind of cam; a unit of a table
            continue
        third = spring / 3.0 if key == "follower.mass" else 0.0
        if number == value or (third and isclose(number - third, value, rel_tol=1e-12)):
            found.append(key)
    return found
