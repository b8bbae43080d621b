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


def _whole(value: Any) -> Any:
    """600.0 is a whole number; anything else is left to the validation."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def items(value: Any) -> Any:
    """A list as a tuple; anything else is left to the validation."""
    return tuple(value) if isinstance(value, list) else value


def unique(values: tuple[str, ...]) -> tuple[str, ...]:
    """The values, or ValueError where one stands twice."""
    if len(set(values)) < len(values):
        raise ValueError("found the same name twice")
    return values


def _ascending(values: tuple[float, float]) -> tuple[float, float]:
    if not values[0] < values[1]:
        raise ValueError(f"found [{values[0]:g}, {values[1]:g}], expected [low, high]")
    return values


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True), BeforeValidator(_whole)]
Speed = Annotated[Number, Field(ge=SLOWEST, le=FASTEST)]
Span = Annotated[
    tuple[Number, Number],
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
