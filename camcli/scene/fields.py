"""What the sections of a scene are made of: their base, and the types of their keys."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    model_validator,
)

from camcli.errors import Fault, SceneError

SLOWEST, FASTEST = 1e-9, 1e9  # rpm
SWITCHES = {"yes": True, "on": True, "no": False, "off": False}


def refused(found: str, expected: str, cure: str) -> SceneError:
    """The error of a check of its own; validation adds the place."""
    return SceneError(Fault("", "", found, expected, cure))


def whole(value: Any) -> Any:
    """600.0 is a whole number; anything else is left to the validation."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _switch(value: Any) -> Any:
    """`yes`, `on`, `no` and `off` where true or false is asked for."""
    return SWITCHES.get(value.lower(), value) if isinstance(value, str) else value


def items(value: Any) -> Any:
    """A list as a tuple; anything else is left to the validation."""
    return tuple(value) if isinstance(value, list) else value


def _unique(values: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(values)) < len(values):
        twice = next(name for k, name in enumerate(values) if name in values[:k])
        found = f"found the same name twice: '{twice}'"
        raise refused(found, "expected each name once", "keep one of the two")
    return values


def _ascending(values: tuple[float, float]) -> tuple[float, float]:
    if not values[0] < values[1]:
        found = f"found [{values[0]:.15g}, {values[1]:.15g}]"
        same = values[0] == values[1]
        cure = "give a window of some width" if same else "exchange the two"
        raise refused(found, "expected [low, high], two different ends", cure)
    return values


Name = TypeVar("Name")
Names = Annotated[
    tuple[Name, ...],
    Field(min_length=1, json_schema_extra={"uniqueItems": True}),
    BeforeValidator(items),
    AfterValidator(_unique),
]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True), BeforeValidator(whole)]
Speed = Annotated[Number, Field(ge=SLOWEST, le=FASTEST)]
End = Annotated[Number, Field(ge=-1e12, le=1e12)]
Span = Annotated[tuple[End, End], BeforeValidator(items), AfterValidator(_ascending)]
Flag = Annotated[bool, Field(strict=True), BeforeValidator(_switch)]


class Section(BaseModel):
    """Base of the sections: unknown keys are faults, nothing changes after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _left_out(cls, data: Any) -> Any:
        return {} if data is None else data
