"""Why a number of a scene cannot be followed along a branch."""

from typing import Any

from camcli.errors import shown

RUN = "it says how motions are simulated and recorded, no orbit depends on it"
NO_SEAT = "without cam.lash the follower has no seat, no orbit depends on it"
LEFT_OUT = "the scene leaves it out, so that a branch has nowhere to begin"
NO_NUMBERS_OF_A_MOTION = {  # kind of cam and path: numbers that no orbit depends on as a number
    ("table", "cam.base_radius"): "only pictures of the lobe need it, no orbit depends on it",
    (
        "table",
        "cam.smoothing",
    ): "it says how the table is smoothed, which is no number of a machine",
}


def why_not_followed(path: str, kind: str, value: Any, known: bool) -> str:
    """Why the number at a path cannot be followed; empty where it can.

    kind: of the cam; value: the scene's, None where it has none; known: whether the scene may have
    such a key.
    """
    if path.startswith("run."):
        return RUN
    if (kind, path) in NO_NUMBERS_OF_A_MOTION:
        return NO_NUMBERS_OF_A_MOTION[kind, path]
    if isinstance(value, bool):
        return "it is a switch"
    if isinstance(value, str):
        return f"it is a text, '{shown(value)}'"
    if isinstance(value, dict):
        return "it is a section, name a number in it"
    if isinstance(value, int):
        return "it is a whole number"
    if value is None and known:
        return LEFT_OUT
    return ""


def cure_of(reason: str) -> str:
    """What to do where a number cannot be followed for a reason."""
    if reason == LEFT_OUT:
        return "give it a value in the scene, or with --set"
    return "follow a number of follower or cam, or run.rpm"
