"""Speeds as they are written: `3000` in rpm of the cam, or `6000 crank`, which is the same."""

import re
from typing import Any

from camcli.quantities import SHAFTS
from camcli.scene.document import scalar

CRANK = "crank"
_OF_A_SHAFT = re.compile(rf"(\S+?)\s*(?:rpm)?\s*(?:of the)?\s*({'|'.join(SHAFTS)})")
MOST_CHARACTERS = 60  # characters of a speed
SECTIONS = ("run", "sweep", "detach", "orbits", "classify", "basins")  # that have speeds
OF_THE_SPEED = ("rpm", "run.rpm")  # keys of an axis that is one


def of_a_shaft(text: Any) -> tuple[float, str] | None:
    """The number and the shaft of a text such as `6000 crank`; None of anything else."""
    if not isinstance(text, str) or len(text) > MOST_CHARACTERS:
        return None
    match = _OF_A_SHAFT.fullmatch(text.strip())
    number = None if match is None else scalar(match[1])
    if match is None or isinstance(number, bool) or not isinstance(number, int | float):
        return None
    return float(number), match[2]


def of_the_cam(value: Any) -> Any:
    """A speed of a shaft in rpm of the cam; anything else is left to the validation."""
    written = of_a_shaft(value)
    if written is None:
        return value
    number, shaft = written
    return number * SHAFTS[shaft]


def with_speeds(data: Any, keys: tuple[str, ...]) -> Any:
    """A map with the speeds at these keys in rpm of the cam; anything else as it is."""
    if not isinstance(data, dict):
        return data
    return {key: of_the_cam(value) if key in keys else value for key, value in data.items()}


def names_a_crank(data: Any) -> bool:
    """Whether a speed in these maps and lists is written as one of a crank."""
    if isinstance(data, dict):
        return any(map(names_a_crank, data.values()))
    if isinstance(data, list | tuple):
        return any(map(names_a_crank, data))
    written = of_a_shaft(data)
    return written is not None and written[1] == CRANK
