"""The sections `basins` and `classify`: many starts, at one speed or at many."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from camcli.scene.fields import RefusedError, Section, Span, Speed, Whole, items, whole
from camcli.scene.machine import MOST_SPEEDS, RpmRange

MOST_CELLS = 16_384  # along one side of a window
MOST_MOTIONS = MOST_SPEEDS  # speeds times starts


class BasinsRange(RpmRange):
    """Equally spaced speeds; one where start and stop are equal."""

    start: Speed = Field(358.5, description="first speed, turns per minute")
    stop: Speed = Field(358.5, description="last speed, turns per minute")
    num: Whole = Field(41, ge=1, le=100_000, description="number of speeds, if they differ")


Side = Annotated[int, Field(strict=True, ge=1, le=MOST_CELLS), BeforeValidator(whole)]


class Basins(Section):
    """The window of starts at the strobe phase, and how `cam basins` follows them."""

    rpm: BasinsRange = Field(default_factory=BasinsRange, description="range of speeds")
    q: Span = Field((0.1, 0.9), description="[low, high] of the starts' position, m")
    v: Span = Field((-50.0, 50.0), description="[low, high] of the starts' velocity, m/s")
    cells: Annotated[tuple[Side, Side], BeforeValidator(items)] = Field(
        (200, 200), description="cells along q and along v"
    )
    method: Literal["orbit", "simple"] = Field(
        "orbit", description="follow every cell, or simple cell mapping: fast and approximate"
    )
    budget: Whole = Field(
        4000, ge=1, le=10_000_000, description="turns after which a cell is left undecided"
    )
    refine: Whole = Field(
        0, ge=0, le=10, description="times that cells at boundaries are cut in four"
    )
    boundary: Annotated[bool, Field(strict=True)] = Field(
        False, description="measure the uncertainty exponent of the boundary"
    )
    exponents: Annotated[bool, Field(strict=True)] = Field(
        False, description="multipliers and Lyapunov exponents of the attractors"
    )


class ClassifyRange(RpmRange):
    """Equally spaced speeds to classify."""

    num: Whole = Field(101, ge=1, le=MOST_SPEEDS, description="number of speeds")


class Classify(Section):
    """What `cam classify` names, measures and explains."""

    rpm: ClassifyRange = Field(default_factory=ClassifyRange, description="range of speeds")
    starts: Whole = Field(0, ge=0, le=1_000_000, description="further starts at each speed")
    seed: Whole = Field(0, ge=0, le=10**9, description="which cloud of starts")
    explain: Annotated[bool, Field(strict=True)] = Field(
        False, description="find the cause of every change"
    )

    @model_validator(mode="after")
    def _few_enough(self) -> Classify:
        motions = self.rpm.num * (self.starts + 1)
        if motions > MOST_MOTIONS:
            raise RefusedError(
                f"found {self.rpm.num} speeds x {self.starts + 1} starts, {motions} motions",
                f"expected at most {MOST_MOTIONS}",
                "ask for fewer speeds or starts",
            )
        return self
