"""The section `bench`: what `cam bench` measures."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from camcli.scene.fields import Flag, Section, Whole, items, unique

CaseName = Literal[
    "periodic", "chatter", "incomplete", "p3", "chaotic", "critical", "overdamped", "stiff",
    "eccentric",
]  # fmt: skip
MethodName = Literal["core", "rk45", "dop853", "lsoda", "radau", "heyoka", "rk4"]
CASES = CaseName.__args__
METHODS = MethodName.__args__
UNIQUE = {"uniqueItems": True}


class Bench(Section):
    """What `cam bench` measures: motions, methods and how often."""

    cases: Annotated[
        tuple[CaseName, ...], Field(min_length=1), BeforeValidator(items), AfterValidator(unique)
    ] = Field(CASES, description="motions compared by precision", json_schema_extra=UNIQUE)
    methods: Annotated[
        tuple[MethodName, ...], Field(min_length=1), BeforeValidator(items), AfterValidator(unique)
    ] = Field(METHODS, description="methods compared by precision", json_schema_extra=UNIQUE)
    repeats: Whole = Field(3, ge=1, le=1000, description="timings of a point, after a first call")
    quick: Flag = Field(False, description="a subset, within a minute")
    flights: Whole = Field(
        200, ge=0, le=10_000_000, description="random flights searched for missed impacts"
    )
