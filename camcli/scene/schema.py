"""The scene: every section, its units, ranges and defaults (those of configs/chapter.yaml).

Sections and keys are optional, except `follower` and `cam`: a scene without a cam is a mistake.
An empty section counts as left out. Text and booleans are never numbers, NaN and infinities
never pass. Every constant has a range far beyond any machine, inside which squares and quotients of
constants stay finite numbers and a turn of any speed has an end.
"""

from __future__ import annotations

import shlex
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from camcli.cams import AnyCam
from camcli.errors import Fault, SceneError

SLOWEST, FASTEST = 1e-9, 1e9  # rpm
SWITCHES = {"yes": True, "on": True, "no": False, "off": False}
MOST_TURNS = 10**9
MOST_SPEEDS = 10_000_000
MOST_MOTIONS = MOST_SPEEDS  # speeds times starts
MOST_CELLS = 16_384  # along one side of a window
LARGEST = 1e16  # of a constant of the follower, SI
FARTHEST, QUICKEST = 1e9, 1e12  # of a start: m and m/s
SPRING = ("rate", "preload", "seat_load", "nose_load")


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

    # A validator is built for the whole scene, none for a section alone before it is asked for.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _left_out(cls, data: Any) -> Any:
        return {} if data is None else data


Constant = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]
Side = Annotated[int, Field(strict=True, ge=1, le=MOST_CELLS), BeforeValidator(whole)]
SectionName = Literal["impacts", "strobe"]
ParameterName = Literal["rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution"]
CurveKind = Literal["period-doubling", "fold", "corner-impact", "grazing"]
PanelName = Literal[
    "motion", "gap", "phase", "section", "passage",  # of simulate
    "mechanism", "outline", "turned", "lift", "velocity", "acceleration", "force", "curvature",
    "impacts", "enlarged", "strobe",  # of sweep
    "kind", "max_gap_m", "airborne_fraction", "max_impact_m_per_s", "min_contact_force_n",
    "max_contact_force_n", "contact_lost_deg", "contact_regained_deg", "landing_deg",
    "landing_lift_m", "shut_bounces_per_turn",  # of its map
    "phases", "forces", "springs",  # of detach, and of orbits and classify
    "positions", "plane", "multipliers", "event", "orbit", "curves",  # of orbits
    "basins", "fractions", "attractors",  # of basins
    "exponents", "labels",  # of classify
]  # fmt: skip
Cam = Annotated[AnyCam, Field(discriminator="kind")]


class Follower(Section):
    """A mass on a spring and a damper; q is its height, zero where the cam's offset puts it."""

    mass: Number = Field(ge=1e-15, le=LARGEST, description="mass of the follower, kg")
    stiffness: Number = Field(ge=0, le=LARGEST, description="stiffness of the spring, N/m")
    damping: Number = Field(0.0, ge=0, le=LARGEST, description="damping to the frame, N s/m")
    gravity: Constant = Field(0.0, description="gravity, positive towards the cam, m/s2")
    preload: Constant = Field(0.0, description="spring force at q = 0, positive towards the cam, N")
    restitution: Number = Field(ge=0, le=1, description="coefficient of restitution, 0..1")


class Spring(Section):
    """The spring as its maker measures it: two of SPRING, no follower.stiffness."""

    rate: Annotated[Number, Field(ge=0, le=LARGEST)] | None = Field(None, description="N/m")
    preload: Constant | None = Field(None, description="force at q = 0, N")
    seat_load: Constant | None = Field(None, description="force at the lowest lift, N")
    nose_load: Constant | None = Field(None, description="force at the highest lift, N")
    solid_at: End | None = Field(
        None, description="height q at which the spring is solid, m; null: not known"
    )


class Contact(Section):
    """What presses where the follower touches: with it the Hertz pressure is computed."""

    width: Number = Field(gt=0, le=1e6, description="width of the contact line, m")
    follower_radius: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="radius of the roller, m; null: a flat face"
    )
    base_radius: Annotated[Number, Field(gt=0, le=1e6)] | None = Field(
        None, description="radius of the base circle, m; null: cam.base_radius"
    )
    modulus: Number = Field(
        1.154e11, gt=0, le=LARGEST,
        description="E*, Pa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; the default is steel on steel",
    )  # fmt: skip


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
    work_budget: Whole = Field(
        1_000_000_000,  # some minutes
        ge=1,
        le=10**15,
        description="gap evaluations, or work that takes as long, of what cannot be foreseen "
        "(detach, orbits, --explain) before the rest is left out",
    )


class RpmRange(Section):
    """Equally spaced speeds, ascending or descending; one speed (num: 1) is the start."""

    start: Speed = Field(660.0, description="first speed, turns per minute")
    stop: Speed = Field(760.0, description="last speed, turns per minute")
    num: Whole = Field(401, ge=1, le=MOST_SPEEDS, description="number of speeds")


class Axis(Section):
    """A number of the scene, and the equally spaced values it takes instead of a speed's."""

    key: Annotated[str, Field(max_length=200)] = Field(
        description="path of the number, as in --set: follower.restitution; rpm is run.rpm"
    )
    start: Number = Field(ge=-LARGEST, le=LARGEST, description="first value")
    stop: Number = Field(ge=-LARGEST, le=LARGEST, description="last value")
    num: Whole = Field(101, ge=1, le=MOST_SPEEDS, description="number of values")

    @model_validator(mode="after")
    def _of_the_machine(self) -> Axis:
        if self.key != "rpm" and self.key.partition(".")[0] not in ("follower", "cam", "run"):
            expected = "expected a number of follower, cam or run"
            raise refused(f"found the key '{self.key}'", expected, "e.g. follower.restitution")
        return self

    @property
    def path(self) -> str:
        """The path of the number in the scene."""
        return "run.rpm" if self.key == "rpm" else self.key


class Zoom(Section):
    """A part of the range, with values of its own."""

    start: Number = Field(ge=-LARGEST, le=LARGEST, description="first value")
    stop: Number = Field(ge=-LARGEST, le=LARGEST, description="last value")
    num: Whole = Field(201, ge=2, le=MOST_SPEEDS, description="number of values")


Axes = Annotated[tuple[Axis, ...], BeforeValidator(items)]
Zooms = Annotated[tuple[Zoom, ...], BeforeValidator(items)]


class Varying(Section):
    """What goes over a range of speeds, or over the values of another number instead."""

    rpm: RpmRange = Field(default_factory=RpmRange, description="range of speeds")
    vary: Axes = Field((), max_length=1, description="another number to vary instead")

    @property
    def axis(self) -> Axis | RpmRange:
        """The first of what is varied: start, stop and num."""
        return self.vary[0] if self.vary else self.rpm

    @property
    def count(self) -> int:
        """How many values it takes."""
        return 1 if self.axis.start == self.axis.stop else self.axis.num

    @property
    def key(self) -> str:
        """Its name, as a column bears it."""
        return self.vary[0].key if self.vary else "rpm"


class Simulate(Section):
    """What `cam simulate` writes and draws."""

    samples: Whole = Field(360, ge=1, le=100_000, description="points per turn in trajectory.csv")
    plot_turns: Whole = Field(
        3, ge=1, le=MOST_TURNS, description="turns drawn, counted from the end"
    )
    beside: Annotated[tuple[Cam, ...], BeforeValidator(items)] = Field(
        (), max_length=2, description="further cams, drawn beside this one (--profile-only)"
    )


class Plot(Section):
    """How pictures are drawn, and in which forms."""

    formats: Names[Literal["png", "pdf", "svg"]] = Field(("png",), description="forms of pictures")
    width: Number = Field(170.0, ge=40, le=1000, description="width, mm")
    height: Annotated[Number, Field(ge=30, le=1000)] | None = Field(
        None, description="height, mm; null: as the panels need, at most 230"
    )
    font: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="name of an installed font; null: DejaVu Sans"
    )
    style: Annotated[str, Field(min_length=1, max_length=4000)] | None = Field(
        None, description="a matplotlib style: its name, or a file; null: ours"
    )
    title: Flag = Field(True, description="title and notes above the panels")
    panels: Names[PanelName] | None = Field(
        None, description="panels, from top to bottom; null: the usual ones of the command"
    )


class Sweep(Varying):
    """What `cam sweep` does at each speed of a range."""

    vary: Axes = Field((), max_length=2, description="numbers varied instead; two make a map")
    zoom: Zooms = Field(
        (), max_length=4, description="parts of the range: values of their own, a panel each"
    )
    direction: Literal["fixed", "up", "down", "both"] = Field(
        "fixed", description="start every speed alike, or carry the state up, down, or up and down"
    )
    also: Annotated[tuple[Start, ...], BeforeValidator(items)] = Field(
        (), max_length=16, description="further starts; their rows come after those of run.start"
    )
    adaptive: Flag = Field(False, description="more values where the motion changes (fixed)")
    decide: Flag = Field(False, description="follow points of a map beyond rounding after a rest")
    sections: Names[SectionName] = Field(("impacts", "strobe"), description="sections recorded")
    tables: Literal["csv", "npz", "none"] = Field(
        "csv", description="form of the sections' tables: text, binary columns, or left out"
    )
    branches: Annotated[str, Field(max_length=4000)] | None = Field(
        None, description="a branch.csv of cam orbits, drawn over the points"
    )
    curves: Annotated[str, Field(max_length=4000)] | None = Field(
        None, description="a curve.csv of cam orbits, drawn over a map"
    )
    lyapunov: Flag = Field(False, description="measure the largest exponent at each speed")
    explain: Flag = Field(False, description="find the cause of every change (direction: fixed)")

    @field_validator("zoom")
    @classmethod
    def _zooms_inside(cls, zoom: Zooms, info: ValidationInfo) -> Zooms:
        vary, rpm = (info.data.get(name) for name in ("vary", "rpm"))
        if vary is None or rpm is None:  # a fault of its own
            return zoom
        axis = vary[0] if vary else rpm
        low, high = sorted((axis.start, axis.stop))
        for part in zoom:
            first, last = sorted((part.start, part.stop))
            if len(vary) == 2 or not low <= first < last <= high:
                found = f"found a zoom from {part.start:.15g} to {part.stop:.15g}"
                expected = f"expected two ends within {low:.15g} to {high:.15g}, and no map"
                raise refused(found, expected, "choose another part, or leave it out")
        return zoom


class Tolerance(Section):
    """By how much a number of the machine may be off."""

    key: Annotated[str, Field(max_length=200)] = Field(
        description="path of the number, as in --set: follower.mass"
    )
    percent: Number = Field(gt=0, le=90, description="largest deviation, percent of the number")


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
    margin_n: Annotated[Number, Field(ge=0, le=LARGEST)] | None = Field(
        None, description="least contact force up to hold_to, N; null: a tenth of the force needed"
    )
    precompression_m: Annotated[Number, Field(ge=0, le=1e6)] | None = Field(
        None, description="preload per stiffness where hold_to chooses both, m; null: as it is"
    )
    tolerance: Annotated[tuple[Tolerance, ...], BeforeValidator(items)] = Field(
        (), max_length=6, description="numbers of the machine that may be off"
    )
    machines: Whole = Field(
        100, ge=1, le=100_000, description="machines sampled within the tolerances"
    )


class OrbitsRange(RpmRange):
    """Speeds over which branches are followed; num: the least number of points across them."""

    start: Speed = Field(672.0, description="first speed, turns per minute")
    stop: Speed = Field(756.0, description="last speed, turns per minute")
    num: Whole = Field(201, ge=1, le=100_000, description="points across the range, at least")


class Orbits(Varying):
    """What `cam orbits` finds, follows and locates.

    `vary` says what `rpm`, `parameter` and `range`, and of a curve `curve_in` and `curve_range`,
    say, by keys of the scene.
    """

    rpm: OrbitsRange = Field(default_factory=OrbitsRange, description="range of speeds")
    vary: Axes = Field((), max_length=2, description="rpm or constants of the follower varied")
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
    simulated: Whole = Field(
        0, ge=0, le=100_000, description="values of the parameter simulated, drawn behind branches"
    )
    parameter: ParameterName = Field("rpm", description="parameter varied along a branch")
    range: Annotated[tuple[Constant, Constant] | None, BeforeValidator(items)] = Field(
        None, description="range of the parameter, or of curve_in; null: around its value"
    )
    curve: CurveKind | None = Field(
        None, description="kind of bifurcation to continue in two parameters"
    )
    curve_in: ParameterName = Field("restitution", description="second parameter of the curve")
    curve_range: Annotated[tuple[Constant, Constant] | None, BeforeValidator(items)] = Field(
        None, description="range of curve_in; null: orbits.range if rpm is the first parameter"
    )


class BasinsRange(RpmRange):
    """Equally spaced speeds; one where start and stop are equal."""

    start: Speed = Field(358.5, description="first speed, turns per minute")
    stop: Speed = Field(358.5, description="last speed, turns per minute")
    num: Whole = Field(41, ge=1, le=100_000, description="number of speeds, if they differ")


class Basins(Varying):
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
    boundary: Flag = Field(False, description="measure the uncertainty exponent of the boundary")
    exponents: Flag = Field(
        False, description="multipliers and Lyapunov exponents of the attractors"
    )
    saddles: Flag = Field(False, description="find the saddles on the boundaries")

    @model_validator(mode="after")
    def _one_size_of_cells(self) -> Basins:
        if self.method == "simple" and self.refine:
            raise refused(
                f"found basins.refine = {self.refine} with the method simple",
                "expected the method orbit: a cell map has one size of cells",
                "use --method orbit, or more --cells",
            )
        return self


class ClassifyRange(RpmRange):
    """Equally spaced speeds to classify."""

    num: Whole = Field(101, ge=1, le=MOST_SPEEDS, description="number of speeds")


class Classify(Varying):
    """What `cam classify` names, measures and explains."""

    rpm: ClassifyRange = Field(default_factory=ClassifyRange, description="range of speeds")
    starts: Whole = Field(0, ge=0, le=1_000_000, description="further starts at each speed")
    seed: Whole = Field(0, ge=0, le=10**9, description="which cloud of starts")
    explain: Flag = Field(False, description="find the cause of every change")

    @model_validator(mode="after")
    def _few_enough(self) -> Classify:
        motions = self.count * (self.starts + 1)
        if motions > MOST_MOTIONS:
            raise refused(
                f"found {self.count} speeds x {self.starts + 1} starts, {motions} motions",
                f"expected at most {MOST_MOTIONS}",
                "ask for fewer speeds or starts",
            )
        return self


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


def _splits(text: str) -> str:
    """The text, or ValueError where a shell could not split it into words."""
    try:
        words = shlex.split(text)
    except ValueError as error:
        found = f"found {text!r}: {str(error).lower()}"
        raise refused(found, "expected words as in a shell", "close the quotes") from None
    if not words or "--" in words:
        found = f"found '--' in {text!r}" if words else "found no command"
        raise refused(found, "expected a command of cam and its options", "name one, without '--'")
    return text


class Figure(Section):
    """A figure: what it shows, and the command that draws it from this scene."""

    title: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        description="what the figure shows, in one line"
    )
    command: Annotated[str, Field(max_length=1000), AfterValidator(_splits)] = Field(
        description="command and options that draw it, as after `cam`; -c and -o are added"
    )
    shows: Annotated[str, Field(max_length=2000)] = Field(
        "",
        description="caption, also for who cannot see it; {NAME|.2f} is a number of the run, by "
        "its name in the reference",
    )
    printed: dict[str, float] = Field(
        {}, description="numbers of the run, by their names in the reference, as printed elsewhere"
    )

    @property
    def words(self) -> list[str]:
        """The command and its options."""
        return shlex.split(self.command)


class Scene(Section):
    """Everything a run depends on."""

    follower: Follower = Field(description="the follower, its spring and its restitution")
    cam: Cam = Field(description="the cam, by kind")
    spring: Spring | None = Field(None, description="another way to give the spring")
    contact: Contact | None = Field(None, description="for the Hertz pressure")
    run: Run = Field(default_factory=Run, description="one simulation")
    plot: Plot = Field(default_factory=Plot, description="form of pictures")
    simulate: Simulate = Field(default_factory=Simulate, description="cam simulate")
    sweep: Sweep = Field(default_factory=Sweep, description="cam sweep")
    detach: Detach = Field(default_factory=Detach, description="cam detach")
    orbits: Orbits = Field(default_factory=Orbits, description="cam orbits")
    classify: Classify = Field(default_factory=Classify, description="cam classify")
    basins: Basins = Field(default_factory=Basins, description="cam basins")
    bench: Bench = Field(default_factory=Bench, description="cam bench")
    figure: Figure | None = Field(None, description="cam figures: what this scene draws")

    @model_validator(mode="before")
    @classmethod
    def _room_for_a_spring(cls, data: Any) -> Any:
        """The follower may leave out its stiffness where the loads of the spring are given."""
        follower, spring = ((data or {}).get(name) for name in ("follower", "spring"))
        if not isinstance(follower, dict) or not isinstance(spring, dict):
            return data
        if all(spring.get(name) is None for name in SPRING):
            return data
        if twice := [name for name in ("stiffness", "preload") if name in follower]:
            found = f"found follower.{twice[0]} beside loads of the spring"
            raise SceneError(Fault("", "spring", found, "expected one of them", "leave one out"))
        return {**data, "follower": {**follower, "stiffness": 0.0}}

    @model_validator(mode="after")
    def _spring_of_loads(self) -> Scene:
        """Stiffness and preload in the place of loads: k c + F0 at the lowest and highest c."""
        loads = {name: getattr(self.spring, name, None) for name in SPRING}
        given = {name: float(value) for name, value in loads.items() if value is not None}
        if self.spring is None or not given:
            return self
        if len(given) != 2:
            expected, cure = f"expected two of {', '.join(SPRING)}", "leave out, or add, the others"
            raise SceneError(Fault("", "spring", f"found {', '.join(given)}", expected, cure))
        from camcli.cams.compile import build, lift_range

        low, high = lift_range(build(self.cam.parts(), 0.0))
        sums = {"rate": (1.0, 0.0), "preload": (0.0, 1.0),
                "seat_load": (low, 1.0), "nose_load": (high, 1.0)}  # fmt: skip
        (a, b, x), (d, e, y) = ((*sums[name], value) for name, value in given.items())
        size = a * e - b * d
        rate = (x * e - b * y) / size if size else -1.0
        preload = (a * y - x * d) / size if size else 0.0
        if not 0.0 <= rate <= LARGEST or not abs(preload) <= LARGEST:
            found = " and ".join(f"{name} {value:.6g} N" for name, value in given.items())
            lift = f"expected a spring that presses harder at {high:.4g} m than at {low:.4g} m"
            raise SceneError(Fault("", "spring", f"found {found}", lift, "check both loads"))
        spring = {"stiffness": rate, "preload": preload}
        object.__setattr__(self, "follower", self.follower.model_copy(update=spring))
        object.__setattr__(self, "spring", Spring(solid_at=self.spring.solid_at))
        return self


def json_schema() -> dict[str, Any]:
    """JSON Schema of a scene file, for editors: sections that may be left out may be null."""
    schema = Scene.model_json_schema()
    for model in (schema, *schema["$defs"].values()):
        for key, entry in model.get("properties", {}).items():
            if "$ref" in entry and key not in model.get("required", ()):
                entry["anyOf"] = [{"$ref": entry.pop("$ref")}, {"type": "null"}]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
