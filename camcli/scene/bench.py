"""The section `bench`: what `cam bench` measures."""

from __future__ import annotations

from typing import Literal, get_args

from pydantic import Field

from camcli.scene.fields import Flag, Names, Section, Whole

CaseName = Literal[
    "periodic", "chatter", "incomplete", "p3", "chaotic", "critical", "overdamped", "stiff",
    "eccentric",
]  # fmt: skip
MethodName = Literal["core", "rk45", "dop853", "lsoda", "radau", "heyoka", "rk4"]
CASES = get_args(CaseName)
METHODS = get_args(MethodName)


class Bench(Section):
    """What `cam bench` measures: motions, methods and how often."""

    cases: Names[CaseName] = Field(CASES, description="motions compared by precision")
    methods: Names[MethodName] = Field(METHODS, description="methods compared by precision")
    repeats: Whole = Field(3, ge=1, le=1000, description="timings of a point, after a first call")
    quick: Flag = Field(False, description="a subset, within a minute")
