"""The scene: every section, its units, ranges and defaults (those of configs/chapter.yaml).

Sections and keys are optional, except `follower` and `cam`: a scene without a cam is a mistake.
An empty section counts as left out. Text and booleans are never numbers, NaN and infinities
never pass.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Union, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field

from camcli.cams import CAMS
from camcli.scene.bench import Bench
from camcli.scene.fields import Flag, Number, Section, Speed, Whole, items, unique
from camcli.scene.figure import Figure
from camcli.scene.machine import (
    LARGEST,
    MOST_SPEEDS,
    MOST_TURNS,
    Constant,
    Follower,
    RpmRange,
    Run,
)
from camcli.scene.studies import Basins, Classify


def cam_union(cams: tuple[type[BaseModel], ...]) -> Any:
    """Type of the cam section: the model that `kind` names."""
    if len(cams) == 1:  # a discriminator needs at least two models
        return cams[0]
    return Annotated[Union[cams], Field(discriminator="kind")]  # noqa: UP007 - made at run time


SectionName = Literal["impacts", "strobe"]
ParameterName = Literal["rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution"]
CurveKind = Literal["period-doubling", "fold", "corner-impact", "grazing"]
PanelName = Literal["branches", "multipliers", "events"]
ProfilePanel = Literal["lift", "velocity", "acceleration", "force", "curvature"]
Cam = cam_union(CAMS)
TAGGED = len(CAMS) > 1  # pydantic then names the kind in the location of an error


class Simulate(Section):
    """What `cam simulate` writes and draws."""

    samples: Whole = Field(360, ge=1, le=100_000, description="points per turn in trajectory.csv")
    plot_turns: Whole = Field(
        3, ge=1, le=MOST_TURNS, description="turns drawn, counted from the end"
    )
    profile_panels: Annotated[
        tuple[ProfilePanel, ...],
        Field(min_length=1),
        BeforeValidator(items),
        AfterValidator(unique),
    ] = Field(
        get_args(ProfilePanel),
        description="panels of profile.png (--profile-only)",
        json_schema_extra={"uniqueItems": True},
    )


class Sweep(Section):
    """What `cam sweep` does at each speed of a range."""

    rpm: RpmRange = Field(default_factory=RpmRange, description="range of speeds")
    direction: Literal["fixed", "up", "down"] = Field(
        "fixed", description="start every speed alike, or carry the state up or down"
    )
    sections: Annotated[
        tuple[SectionName, ...],
        Field(min_length=1),
        BeforeValidator(items),
        AfterValidator(unique),
    ] = Field(
        ("impacts", "strobe"),
        description="sections recorded",
        json_schema_extra={"uniqueItems": True},
    )
    tables: Literal["csv", "npz", "none"] = Field(
        "csv", description="form of the sections' tables: text, binary columns, or left out"
    )
    lyapunov: Flag = Field(False, description="measure the largest exponent at each speed")
    explain: Flag = Field(False, description="find the cause of every change (direction: fixed)")


class DetachRange(RpmRange):
    """Equally spaced speeds of the accumulation curve."""

    start: Speed = Field(110.0, description="first speed, turns per minute")
    stop: Speed = Field(200.0, description="last speed, turns per minute")
    num: Whole = Field(181, ge=1, le=MOST_SPEEDS, description="number of speeds")


class Detach(Section):
    """What `cam detach` looks for; it always starts from rest."""

    rpm: DetachRange = Field(default_factory=DetachRange, description="range of speeds")
    settle: Whole = Field(
        3, ge=0, le=MOST_TURNS, description="turns from rest before a speed is looked at"
    )
    impacts: Whole = Field(
        8, ge=0, le=1000, description="corner hits are followed for impacts 1 to this"
    )
    force_rpm: Annotated[tuple[Speed, ...] | None, BeforeValidator(items)] = Field(
        None, description="speeds of the force curves, turns per minute; null: a telling few"
    )
    hold_to: Speed | None = Field(
        None, description="speed up to which a spring shall hold contact; null: not asked"
    )
    margin_n: Number = Field(
        0.0, ge=0, le=LARGEST, description="least contact force up to hold_to, N"
    )
    precompression_m: Number = Field(
        0.05, ge=0, le=1e6, description="preload per stiffness where hold_to chooses both, m"
    )


class OrbitsRange(RpmRange):
    """Speeds over which branches are followed; num: the least number of points across them."""

    start: Speed = Field(672.0, description="first speed, turns per minute")
    stop: Speed = Field(756.0, description="last speed, turns per minute")
    num: Whole = Field(201, ge=1, le=100_000, description="points across the range, at least")


class Orbits(Section):
    """What `cam orbits` finds, follows and locates."""

    rpm: OrbitsRange = Field(default_factory=OrbitsRange, description="range of speeds")
    at: Speed | None = Field(
        None, description="speed at which orbits are found; null: run.rpm, or the range's middle"
    )
    label: Annotated[str, Field(max_length=400)] | None = Field(
        None, description="only orbits with this label, P(m;s1:...:sm)"
    )
    starts: Whole = Field(
        24, ge=0, le=100_000, description="motions simulated beside the scene's start"
    )
    stability: Literal["any", "stable", "unstable"] = Field(
        "any", description="which of the orbits found are followed"
    )
    branches: Whole = Field(
        3, ge=0, le=1000, description="branches followed that leave from bifurcations"
    )
    parameter: ParameterName = Field("rpm", description="parameter varied along a branch")
    range: Annotated[tuple[Constant, Constant] | None, BeforeValidator(items)] = Field(
        None, description="range of the parameter, or of curve_in; null: around its value"
    )
    curve: CurveKind | None = Field(
        None, description="kind of bifurcation to continue in two parameters"
    )
    curve_in: ParameterName = Field("restitution", description="second parameter of the curve")
    panels: Annotated[
        tuple[PanelName, ...],
        Field(min_length=1),
        BeforeValidator(items),
        AfterValidator(unique),
    ] = Field(
        ("branches", "multipliers", "events"),
        description="parts of the picture, where branches are followed",
        json_schema_extra={"uniqueItems": True},
    )


class Scene(Section):
    """Everything a run depends on."""

    follower: Follower = Field(description="the follower, its spring and its restitution")
    cam: Cam = Field(description="the cam, by kind")  # type: ignore[valid-type]
    run: Run = Field(default_factory=Run, description="one simulation")
    simulate: Simulate = Field(default_factory=Simulate, description="cam simulate")
    sweep: Sweep = Field(default_factory=Sweep, description="cam sweep")
    detach: Detach = Field(default_factory=Detach, description="cam detach")
    orbits: Orbits = Field(default_factory=Orbits, description="cam orbits")
    classify: Classify = Field(default_factory=Classify, description="cam classify")
    basins: Basins = Field(default_factory=Basins, description="cam basins")
    bench: Bench = Field(default_factory=Bench, description="cam bench")
    figure: Figure | None = Field(None, description="cam figures: what this scene draws")


def json_schema() -> dict[str, Any]:
    """JSON Schema of a scene file, for editors: sections that may be left out may be null."""
    schema = Scene.model_json_schema()
    for model in (schema, *schema["$defs"].values()):
        for key, entry in model.get("properties", {}).items():
            if "$ref" in entry and key not in model.get("required", ()):
                entry["anyOf"] = [{"$ref": entry.pop("$ref")}, {"type": "null"}]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
