"""The sections of one motion: `follower`, `run` and its `start`; the range of speeds of a study.

Every constant has a range far beyond any machine, inside which squares and quotients of constants
stay finite numbers and a turn of any speed has an end.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from camcli.scene.fields import Number, Section, Speed, Whole

MOST_TURNS = 10**9
MOST_SPEEDS = 10_000_000
LARGEST = 1e15  # of a constant of the follower, SI
FARTHEST, QUICKEST = 1e9, 1e12  # of a start: m and m/s
Constant = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]


class Follower(Section):
    """A mass on a spring and a damper; q is its height, zero where the cam's offset puts it."""

    mass: Number = Field(ge=1e-15, le=LARGEST, description="mass of the follower, kg")
    stiffness: Number = Field(ge=0, le=LARGEST, description="stiffness of the spring, N/m")
    damping: Number = Field(0.0, ge=0, le=LARGEST, description="damping to the frame, N s/m")
    gravity: Constant = Field(0.0, description="gravity, positive towards the cam, m/s2")
    preload: Constant = Field(0.0, description="spring force at q = 0, positive towards the cam, N")
    restitution: Number = Field(ge=0, le=1, description="coefficient of restitution, 0..1")


class Start(Section):
    """State at the first instant; without q and v the follower rests on the cam."""

    q: Annotated[Number, Field(ge=-FARTHEST, le=FARTHEST)] | None = Field(
        None, description="height of the follower, m; null: on the cam"
    )
    v: Annotated[Number, Field(ge=-QUICKEST, le=QUICKEST)] | None = Field(
        None, description="velocity of the follower, m/s; null: the cam's"
    )
    theta_deg: Number = Field(0.0, ge=-1e9, le=1e9, description="angle of the cam, deg")


class Run(Section):
    """One simulation: its speed, start and length, and what bounds its error and cost."""

    rpm: Speed = Field(700.0, description="speed of the cam, turns per minute")
    start: Start = Field(default_factory=Start, description="state at the first instant")
    transient: Whole = Field(600, ge=0, le=MOST_TURNS, description="turns before recording")
    record: Whole = Field(400, ge=1, le=MOST_TURNS, description="turns recorded")
    strobe_deg: Number = Field(0.0, ge=0, lt=360, description="phase of the strobe, deg")
    chatter_tolerance: Number = Field(
        1e-9,
        ge=1e-13,
        le=1e-3,
        description="largest error of the accumulation phase, fraction of a turn",
    )
    impact_budget: Whole = Field(
        1_000_000, ge=1, le=10**15, description="impacts in one turn before the run is given up"
    )


class RpmRange(Section):
    """Equally spaced speeds, ascending or descending; one speed (num: 1) is the start."""

    start: Speed = Field(660.0, description="first speed, turns per minute")
    stop: Speed = Field(760.0, description="last speed, turns per minute")
    num: Whole = Field(401, ge=1, le=MOST_SPEEDS, description="number of speeds")
