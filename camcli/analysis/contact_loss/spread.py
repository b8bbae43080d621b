"""The spread of machines within their tolerances, as values for sentences and a picture."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Spread:
    """Speeds (rpm) to which machines hold that are drawn at random, and the worst of all.

    numbers: by how many percent each number of the worst machine is off, of the error of a table
    percent of its bound. shares: of the variance of the speeds, by the number that explains it;
    empty where that cannot be told.
    """

    speeds: Sequence[float]
    worst: float
    numbers: Mapping[str, float]
    shares: Mapping[str, float]
