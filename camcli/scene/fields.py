"""What the sections of a scene are made of: their base, and the types of their keys."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    model_validator,
)

SLOWEST, FASTEST = 1e-9, 1e9  # rpm


class RefusedError(ValueError):
    """A value refused by a check of its own, in the three parts of a fault."""

    def __init__(self, found: str, expected: str, cure: str):
        self.found, self.expected, self.cure = found, expected, cure
        super().__init__(f"{found}, {expected}, {cure}")


def whole(value: Any) -> Any:
    """600.0 is a whole number; anything else is left to the validation."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def items(value: Any) -> Any:
    """A list as a tuple; anything else is left to the validation."""
    return tuple(value) if isinstance(value, list) else value


def unique(values: tuple[str, ...]) -> tuple[str, ...]:
    """The values, or ValueError where one stands twice."""
    if len(set(values)) < len(values):
        seen: set[str] = set()
        twice = next(name for name in values if name in seen or seen.add(name))
        found = f"found the same name twice: '{twice}'"
        raise RefusedError(found, "expected each name once", "keep one of the two")
    return values


def _ascending(values: tuple[float, float]) -> tuple[float, float]:
    if not values[0] < values[1]:
        same = values[0] == values[1]
        raise RefusedError(
            f"found [{values[0]:.15g}, {values[1]:.15g}]",
            "expected [low, high], two different ends",
            "give a window of some width" if same else "exchange the two",
        )
    return values


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True), BeforeValidator(whole)]
Speed = Annotated[Number, Field(ge=SLOWEST, le=FASTEST)]
End = Annotated[Number, Field(ge=-1e12, le=1e12)]
Span = Annotated[
    tuple[End, End],
    BeforeValidator(items),
    AfterValidator(_ascending),
]
Flag = Annotated[bool, Field(strict=True)]


class Section(BaseModel):
    """Base of the sections: unknown keys are faults, nothing changes after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _left_out(cls, data: Any) -> Any:
        return {} if data is None else data
