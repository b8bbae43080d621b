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
    spring_mass = getattr(scene.spring, "mass", None) or 0.0
    still_made_up = []
    for key, made_up_number in MADE_UP.items():
        section, _, name = key.partition(".")
        number = getattr(getattr(scene, section), name, None)
        if not isinstance(number, float):  # of another kind of cam; a unit of a table
            continue
        is_made_up = number == made_up_number
        if spring_mass and key == "follower.mass":
            without_third = number - spring_mass / 3.0
            is_made_up = is_made_up or isclose(without_third, made_up_number, rel_tol=1e-12)
        if is_made_up:
            still_made_up.append(key)
    return still_made_up
