"""The scene: every section, its units, ranges and defaults (those of configs/chapter.yaml).

Sections and keys are optional, except `follower` and `cam`: a scene without a cam is a mistake.
An empty section counts as left out. Text and booleans are never numbers, NaN and infinities
never pass. Every constant has a range far beyond any machine, inside which squares and quotients of
constants stay finite numbers and a turn of any speed has an end.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

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

from camcli.cams import CAMS, AnyCam
from camcli.cams.lash import LashedCam, comes_to_its_seat, rises_off_its_seat
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import Fault, SceneError, plural, shown
from camcli.quantities import FOLLOWER, LOADS, PARAMETERS, RPM, SEAT
from camcli.scene.speeds import OF_THE_SPEED, SECTIONS, names_a_crank, of_the_cam, with_speeds

SLOWEST, FASTEST = 1e-9, 1e9  # rpm
SWITCHES = {"yes": True, "on": True, "no": False, "off": False}
MOST_TURNS = 10**9
MOST_SPEEDS = 10_000_000
MOST_MOTIONS = MOST_SPEEDS  # speeds times starts
MOST_CELLS = 16_384  # along one side of a window
LARGEST = 1e16  # of a constant of the follower, SI
FARTHEST, QUICKEST = 1e9, 1e12  # of a start: m and m/s
ROUNDING = 1e-12  # of the lift: a difference below is none
SMALL_LASH = 1e-6  # m: a smaller one is held against the rounding of the cam's heights
MORE_THAN_THE_LIFT = "expected less than the lift: the follower would never leave its seat"
BOTH = ["follower.stiffness", "follower.preload"]
SPRING = {  # numbers of a spring, and those of the follower that are worked out from them
    "rate": BOTH[:1], "preload": BOTH[1:], "seat_load": BOTH, "nose_load": BOTH,
}  # fmt: skip
VARYING = ("sweep", "orbits", "basins", "classify")  # sections that go over a range of speeds
AROUND_FREQUENCY = (0.8, 1.2)  # shares of an oscillator's frequency where no range is given
RPM_OF_ONE_RADIAN = 30.0 / pi  # rpm of 1 rad/s
OSCILLATOR_CURE = "write it under cam; a range is --vary cam.frequency=LO:HI"


def refused(found: str, expected: str, cure: str) -> SceneError:
    """The error of a check of its own; validation adds the place."""
    return SceneError(Fault("", "", found, expected, cure))


def entry(words: str, default: Any = ..., **more: Any) -> Any:
    """An entry of a section: what it means, its default, its limits."""
    return Field(default, description=words, **more)


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
    """The values as they are; raises where a value is there twice."""
    if len(set(values)) < len(values):
        twice = next(name for k, name in enumerate(values) if name in values[:k])  # the first
        found = f"found the same name twice: '{twice}'"
        raise refused(found, "expected each name once", "keep one of the two")
    return values


def _each_once(sections: tuple[Any, ...]) -> tuple[Any, ...]:
    """Sections, each with the key of a number of the scene; raises where one is there twice."""
    _unique(tuple("run.rpm" if one.key == "rpm" else one.key for one in sections))
    return sections


def _ascending(values: tuple[float, float]) -> tuple[float, float]:
    """The two ends; refused where the first is not below the second."""
    low, high = values
    if not low < high:
        found = f"found [{low:.15g}, {high:.15g}]"
        cure = "give a window of some width" if low == high else "exchange the two"
        raise refused(found, "expected [low, high], two different ends", cure)
    return values


Name = TypeVar("Name")
Names = Annotated[
    tuple[Name, ...],
    Field(min_length=1, json_schema_extra={"uniqueItems": True}),
    BeforeValidator(items),
    AfterValidator(_unique),
]
Items = Annotated[tuple[Name, ...], BeforeValidator(items)]
Keyed = Annotated[tuple[Name, ...], BeforeValidator(items), AfterValidator(_each_once)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Whole = Annotated[int, Field(strict=True), BeforeValidator(whole)]
NumberOfASpeed = Annotated[Number, Field(ge=SLOWEST, le=FASTEST)]
CrankSpeed = Annotated[str, Field(pattern=r"^[0-9.eE+-]+ *(rpm)? *(of the)? *(crank|cam)$")]
Speed = Annotated[
    NumberOfASpeed, BeforeValidator(of_the_cam, json_schema_input_type=NumberOfASpeed | CrankSpeed)
]
End = Annotated[Number, Field(ge=-1e12, le=1e12)]
Span = Annotated[tuple[End, End], BeforeValidator(items), AfterValidator(_ascending)]
Phase = Annotated[Number, Field(ge=0, le=360)]
Phases = Annotated[tuple[Phase, Phase], BeforeValidator(items), AfterValidator(_ascending)]
Flag = Annotated[bool, Field(strict=True), BeforeValidator(_switch)]


class Section(BaseModel):
    """Base of the sections: unknown keys are faults, nothing changes after validation."""

    # A validator is built for the whole scene, none for a section alone before it is asked for.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _left_out(cls, data: Any) -> Any:
        """A section with nothing in it counts as left out."""
        return {} if data is None else data


Constant = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]
Ends = Annotated[tuple[Constant, Constant], BeforeValidator(items)]
Side = Annotated[int, Field(strict=True, ge=1, le=MOST_CELLS), BeforeValidator(whole)]
Sides = Annotated[tuple[Side, Side], BeforeValidator(items)]
PictureFormat = Literal["png", "pdf", "svg"]
SectionName = Literal["impacts", "strobe"]
if TYPE_CHECKING:
    ParameterName = str
else:
    ParameterName = Literal[tuple(PARAMETERS)]
CurveKind = Literal["period-doubling", "fold", "corner-impact", "grazing"]
PANELS: dict[str, dict[str, tuple[str, ...]]] = {  # of each command, by what it draws
    "simulate": {
        "motion": ("motion", "gap", "phase", "section", "passage"),
        "profile": (
            "mechanism", "outline", "turned", "geometry", "angle", "lift", "velocity",
            "acceleration", "jerk", "force", "radius", "curvature",
        ),
    },
    "sweep": {
        "diagram": ("impacts", "enlarged", "strobe", "exponents"),
        "map": (
            "kind", "exponents", *LOADS, *SEAT,
        ),
    },
    "detach": {"loss": ("phases", "enlarged", "forces", "springs", "surge", "machines", "shares")},
    "orbits": {
        "branches": ("phases", "positions", "plane", "multipliers", "attraction", "event"),
        "orbits": (
            "motion", "orbit", "plane", "attraction", "lift", "velocity", "acceleration", "section",
        ),
        "curve": ("curves",),
        "cover": ("cover",),
        "chaos": ("boxes", "coverings"),
    },
    "basins": {"window": ("basins",), "range": ("fractions", "attractors")},
    "classify": {"motions": ("phases", "exponents", "labels")},
}  # fmt: skip


def panels_of(command: str = "") -> list[str]:
    """The names of the panels that a command can draw; of all commands where none is named."""
    pictures_of_commands = [PANELS[command]] if command in PANELS else list(PANELS.values())
    names: dict[str, None] = {}
    for pictures in pictures_of_commands:
        for panels in pictures.values():
            names |= dict.fromkeys(panels)
    return list(names)


def no_panel(name: str, known: Sequence[str]) -> tuple[str, str, str]:
    """(found, expected, cure) for a panel that is none of those known, the nearest first."""
    from difflib import get_close_matches

    near = get_close_matches(name[:40].lower(), known, n=1, cutoff=0.6)
    ordered = dict.fromkeys([*near, *known])
    cure = f"did you mean '{near[0]}'?" if near else "choose some of these"
    return f"found '{shown(name)}'", f"expected one of {', '.join(ordered)}", cure


def _panel(name: str, info: ValidationInfo) -> str:
    """The name of a panel of any command; a fault names those of the command that is asked for."""
    if name not in panels_of():
        command = (info.context or {}).get("command", "")
        raise refused(*no_panel(name, panels_of(command)))
    return name


PanelName = Annotated[
    str, Field(json_schema_extra={"enum": panels_of()}), AfterValidator(_panel)
]  # fmt: skip
Cam = Annotated[AnyCam, Field(discriminator="kind")]


class Follower(Section):
    """A mass on a spring and a damper; q is its height, zero where the cam's offset puts it."""

    mass: Number = entry(FOLLOWER["mass"].description, ge=1e-15, le=LARGEST)
    stiffness: Number = entry(FOLLOWER["stiffness"].description, ge=0, le=LARGEST)
    damping: Number = entry(FOLLOWER["damping"].description, 0.0, ge=0, le=LARGEST)
    gravity: Constant = entry(FOLLOWER["gravity"].description, 0.0)
    preload: Constant = entry(FOLLOWER["preload"].description, 0.0)
    restitution: Number = entry(FOLLOWER["restitution"].description, ge=0, le=1)
    seat_restitution: Number | None = entry(
        FOLLOWER["seat_restitution"].description, None, ge=0, le=1
    )


class Spring(Section):
    """The spring as its maker measures it: two of SPRING, no follower.stiffness; and its mass."""

    rate: Number | None = entry("N/m", None, ge=0, le=LARGEST)
    preload: Constant | None = entry("force at q = 0, N", None)
    seat_load: Constant | None = entry("force at the lowest lift, N", None)
    nose_load: Constant | None = entry("force at the highest lift, N", None)
    solid_at: End | None = entry("height q at which the spring is solid, m; null: not known", None)
    mass: Number | None = entry(
        "of the spring, kg, for its surge; a third of it is added to follower.mass",
        None, gt=0, le=LARGEST,
    )  # fmt: skip
    in_follower: Flag = entry("follower.mass holds that third already", False)

    @model_validator(mode="after")
    def _of_a_mass(self) -> Spring:
        """Refuse in_follower without a mass."""
        if self.in_follower and self.mass is None:
            found, expected = "found in_follower without mass", "expected the mass of the spring"
            raise refused(found, expected, "give spring.mass in kg, or leave in_follower out")
        return self


class Contact(Section):
    """What touches the cam: with a face the lobe is worked out, with a width the Hertz pressure."""

    face: Literal["knife", "roller", "flat"] | None = entry(
        "what runs on the lobe, of which the cam sheet is made; null: no sheet of the lobe", None
    )
    width: Number | None = entry(
        "width of the contact line, m, for the Hertz pressure; may be left out beside a face",
        None, gt=0, le=1e6,
    )  # fmt: skip
    follower_radius: Number | None = entry("of the roller, m; null: flat face", None, gt=0, le=1e6)
    base_radius: Number | None = entry("of the base circle, m; null: the cam's", None, gt=0, le=1e6)
    modulus: Number = entry(
        "E*, Pa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; the default is steel on steel",
        1.154e11, gt=0, le=LARGEST,
    )  # fmt: skip

    @model_validator(mode="after")
    def _one_follower(self) -> Contact:
        """Refuse a width or a radius that the face does not go with, and the lack of both."""
        expected, cure = "", ""
        found = f"found face: {self.face}"
        if self.face == "roller" and self.follower_radius is None:
            found += " without follower_radius"
            expected, cure = "expected the radius of the roller, m", "give contact.follower_radius"
        elif self.face in ("knife", "flat") and self.follower_radius is not None:
            found += f" with follower_radius {self.follower_radius:.6g}"
            expected, cure = "expected no radius: only a roller has one", "leave one of them out"
        elif self.face == "knife" and self.width is not None:
            found += f" with width {self.width:.6g}"
            expected = "expected no width: a Hertz pressure needs a roller or a flat face"
            cure = "leave one of them out"
        elif self.face is None and self.width is None:
            found = "found neither face nor width"
            expected = "expected what runs on the lobe, or the width of the contact line"
            cure = "give face: knife, roller or flat, or width in m"
        if expected:
            raise refused(found, expected, cure)
        return self


class Start(Section):
    """State at the first instant; without q and v the follower rests on the cam."""

    q: Number | None = entry("height, m; null: on the cam", None, ge=-FARTHEST, le=FARTHEST)
    v: Number | None = entry("velocity, m/s; null: the cam's", None, ge=-QUICKEST, le=QUICKEST)
    theta_deg: Number = entry("angle of the cam, deg", 0.0, ge=-1e9, le=1e9)


class Run(Section):
    """One simulation: its speed, start and length, and what bounds its error and cost."""

    rpm: Speed = entry(RPM.description, 700.0)
    start: Start = entry("state at the first instant", default_factory=Start)
    crank: Flag = entry(
        "a crank turns twice as fast as the cam, and speeds are told of both; so it is where one "
        "is written as `6000 crank`",
        False,
    )
    transient: Whole = entry("turns before recording", 600, ge=0, le=MOST_TURNS)
    record: Whole = entry("turns recorded", 400, ge=1, le=MOST_TURNS)
    patience: Whole = entry(
        "turns that a motion which looks aperiodic is followed on before it is called so",
        20_000,
        ge=0,
        le=MOST_TURNS,
    )
    strobe_deg: Number = entry("phase of the strobe, deg", 0.0, ge=0, lt=360)
    chatter_tolerance: Number = entry(
        "largest error of the accumulation phase, fraction of a turn", 1e-9, ge=1e-15, le=1e-3
    )
    impact_budget: Whole = entry(
        "impacts in a turn at which a run is given up", 1_000_000, ge=1, le=10**15
    )
    work_budget: Whole = entry(
        "gap evaluations, or work that takes as long, of what cannot be foreseen "
        "(detach, orbits, --explain) before the rest is left out",
        1_000_000_000,
        ge=1,
        le=10**15,
    )


class RpmRange(Section):
    """Equally spaced speeds, ascending or descending; one speed (num: 1) is the start."""

    start: Speed = entry("first speed, turns per minute", 660.0)
    stop: Speed = entry("last speed, turns per minute", 760.0)
    num: Whole = entry("number of speeds", 401, ge=1, le=MOST_SPEEDS)


def _refuse_other_sections(key: str, sections: Sequence[str], example: str) -> None:
    """Raise SceneError, with the nearest key, where a key is not one of these sections.

    sections: of follower, cam and run; example: a key, for the fault where none is near.
    """
    if key.partition(".")[0] in sections:
        return
    near = " or ".join(_keys_like(key, sections))
    cure = f"did you mean {near}?" if near else f"e.g. {example}"
    expected = f"expected a number of {', '.join(sections[:-1])} or {sections[-1]}"
    raise refused(f"found the key '{key}'", expected, cure)


def _keys_like(key: str, sections: Sequence[str]) -> list[str]:
    """The keys of these sections whose last name is that of a key, or else nearly that."""
    from difflib import get_close_matches  # only after a mistake

    models = {"follower": (Follower,), "cam": CAMS, "run": (Run,)}
    paths_of: dict[str, list[str]] = {}  # by last name
    for section in sections:
        for model in models[section]:
            for name in model.model_fields:
                if section == "cam" and name in Follower.model_fields and "follower" in sections:
                    continue  # of an oscillator; elsewhere it is the follower's
                paths_of.setdefault(name, []).append(f"{section}.{name}")
    last_name = key.rpartition(".")[2][:40].lower()
    if key.startswith("spring.") and last_name in SPRING:
        paths_of[last_name] = SPRING[last_name]
    if last_name in paths_of:
        names = [last_name]
    else:
        names = get_close_matches(last_name, paths_of, n=1, cutoff=0.6)
    return list(dict.fromkeys(path for name in names for path in paths_of[name]))


class Axis(Section):
    """A number of the scene, and the equally spaced values it takes instead of a speed's."""

    key: str = entry("path as in --set: follower.restitution; rpm is run.rpm", max_length=200)
    start: Constant = entry("first value")
    stop: Constant = entry("last value")
    num: Whole = entry("number of values", 101, ge=1, le=MOST_SPEEDS)

    @model_validator(mode="before")
    @classmethod
    def _speeds_of_a_crank(cls, data: Any) -> Any:
        """Ends that are speeds of a crank in rpm of the cam."""
        is_speed = isinstance(data, dict) and data.get("key") in OF_THE_SPEED
        return with_speeds(data, ("start", "stop")) if is_speed else data

    @model_validator(mode="after")
    def _of_the_machine(self) -> Axis:
        """Refuse a key of another section: only numbers of the machine and of its run vary."""
        if self.key != "rpm":
            _refuse_other_sections(self.key, ("follower", "cam", "run"), "follower.restitution")
        return self

    @property
    def path(self) -> str:
        """The path of the number in the scene."""
        return "run.rpm" if self.key == "rpm" else self.key


class Zoom(Section):
    """A part of the range, with values of its own."""

    start: Constant = entry("first value")
    stop: Constant = entry("last value")
    num: Whole = entry("number of values", 201, ge=2, le=MOST_SPEEDS)


class Varying(Section):
    """A section with a range of speeds, or of values of another number in its place."""

    rpm: RpmRange = entry("range of speeds", default_factory=RpmRange)
    vary: Keyed[Axis] = entry("another number to vary instead", (), max_length=1)

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

    samples: Whole = entry("points per turn in trajectory.csv", 360, ge=1, le=100_000)
    plot_turns: Whole = entry("turns drawn, counted from the end", 3, ge=1, le=MOST_TURNS)
    profile_only: Flag = entry("write and draw the cam, simulate nothing", False)
    base_radius: Number | None = entry(
        "of the base circle with profile_only, m; null: the cam's", None, gt=0, le=1e6
    )
    beside: Items[Cam] = entry("further cams, drawn beside it (profile_only)", (), max_length=2)
    animate: Flag = entry("also write the machine in motion", False)

    @model_validator(mode="after")
    def _of_a_motion_or_of_a_cam(self) -> Simulate:
        """Refuse base_radius without profile_only, and animate with it."""
        if self.base_radius is not None and not self.profile_only:
            found, cure = "found it without profile_only", "add --profile-only"
            raise SceneError(Fault("", "base_radius", found, "it means nothing there", cure))
        if self.animate and self.profile_only:
            found, cure = "found it with profile_only", "leave one of them out"
            raise SceneError(Fault("", "animate", found, "it means nothing there", cure))
        return self


class Plot(Section):
    """How pictures are drawn, and in which forms."""

    formats: Names[PictureFormat] = entry("forms of pictures", ("png",))
    width: Number = entry("width, mm", 170.0, ge=40, le=1000)
    height: Number | None = entry("mm; null: as the panels need, at most 230", None, ge=30, le=1000)
    font: str | None = entry("a font's name; null: DejaVu Sans", None, min_length=1, max_length=200)
    style: str | None = entry(
        "a matplotlib style: its name, or a file; null: ours", None, min_length=1, max_length=4000
    )
    title: Flag = entry("title and notes above the panels", True)
    panels: Names[PanelName] | None = entry("panels from top to bottom; null: the usual ones", None)


class Sweep(Varying):
    """What `cam sweep` does at each speed of a range."""

    vary: Keyed[Axis] = entry("numbers varied instead; two make a map", (), max_length=2)
    zoom: Items[Zoom] = entry("parts of the range with values and a panel each", (), max_length=4)
    phases_deg: Phases | None = entry("impact phases drawn, deg; null: all there are", None)
    positions_m: Span | None = entry("positions drawn, m; null: all there are", None)
    direction: Literal["fixed", "up", "down", "both"] = entry(
        "start every speed alike, or carry the state up, down, or up and down", "fixed"
    )
    also: Items[Start] = entry("further starts; their rows follow run.start's", (), max_length=16)
    adaptive: Flag = entry("more values where the motion changes (fixed)", False)
    decide: Flag = entry("follow points of a map beyond rounding after a rest", False)
    sections: Names[SectionName] = entry("sections recorded", ("impacts", "strobe"))
    tables: Literal["csv", "npz", "none"] = entry(
        "form of the sections' tables: text, binary columns, or left out", "csv"
    )
    branches: str | None = entry("a branch.csv of cam orbits, drawn over it", None, max_length=4000)
    curves: str | None = entry(
        "a curve.csv of cam orbits, drawn over a map; auto: found from the map's edges", None,
        max_length=4000,
    )  # fmt: skip
    prove: Flag = entry("prove the curves that curves: auto finds, in ball arithmetic", False)
    prove_turns: Whole = entry(
        "most turns of an orbit whose curves are proved: longer ones take longer", 4,
        ge=1, le=MOST_TURNS,
    )  # fmt: skip
    lyapunov: Flag = entry("measure the largest exponent at each speed", False)
    explain: Flag = entry("find the cause of every change (direction: fixed)", False)

    @model_validator(mode="before")
    @classmethod
    def _zooms_of_a_crank(cls, data: Any) -> Any:
        """Zooms of a range of speeds that are written as `6000 crank`, in rpm of the cam.

        Anything else in the data is left to the validation.
        """
        if not isinstance(data, dict) or not isinstance(data.get("zoom"), list | tuple):
            return data
        axes = data.get("vary") or ({"key": "rpm"},)
        first = axes[0] if isinstance(axes, list | tuple) else None
        if not isinstance(first, dict) or first.get("key") not in OF_THE_SPEED:
            return data
        zooms = [with_speeds(zoom, ("start", "stop")) for zoom in data["zoom"]]
        return {**data, "zoom": zooms}

    @field_validator("zoom")
    @classmethod
    def _zooms_inside(cls, zoom: Items[Zoom], info: ValidationInfo) -> Items[Zoom]:
        """Refuse a zoom that leaves the range, and any zoom of a map."""
        vary = info.data.get("vary")
        rpm = info.data.get("rpm")
        if vary is None or rpm is None:  # it has a fault of its own
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

    key: str = entry("path of the number, as in --set: follower.mass", max_length=200)
    percent: Number = entry("largest deviation, percent of the number", gt=0, le=90)

    @model_validator(mode="after")
    def _of_the_machine(self) -> Tolerance:
        """Refuse a key that is no number of the machine."""
        _refuse_other_sections(self.key, ("follower", "cam"), "follower.mass")
        return self


class DetachRange(RpmRange):
    """Equally spaced speeds of the accumulation curve."""

    start: Speed = entry("first speed, turns per minute", 110.0)
    stop: Speed = entry("last speed, turns per minute", 200.0)
    num: Whole = entry("number of speeds", 181, ge=1, le=MOST_SPEEDS)


class Detach(Section):
    """What `cam detach` looks for; it always starts from rest."""

    rpm: DetachRange = entry("range of speeds", default_factory=DetachRange)
    settle: Whole = entry("turns from rest before a speed is looked at", 3, ge=0, le=MOST_TURNS)
    impacts: Whole = entry("corner hits are followed for impacts 1 to this", 8, ge=0, le=1000)
    force_rpm: Items[Speed] | None = entry(
        "speeds of force curves, rpm; null: a telling few, and run.rpm if stated, up to "
        "detach.rpm.stop; with contact.width standstill too, where the nose is pressed hardest",
        None,
    )
    hold_to: Speed | None = entry("speed up to which a spring shall hold; null: not asked", None)
    margin_n: Number | None = entry(
        "least contact force up to hold_to, N; null: a tenth of the force needed",
        None,
        ge=0,
        le=LARGEST,
    )
    precompression_m: Number | None = entry(
        "preload per stiffness where hold_to chooses both, m; null: as it is", None, ge=0, le=1e6
    )
    tolerance: Keyed[Tolerance] = entry("numbers of the machine that may be off", (), max_length=6)
    machines: Whole = entry("machines sampled within the tolerances", 100, ge=1, le=100_000)
    report: Flag = entry("also write a page for print; hold_to is then the end of rpm", False)
    prove: Flag = entry("prove the first detachment and the corner hits after it", False)


class OrbitsRange(RpmRange):
    """Speeds over which branches are followed; num: the least number of points across them."""

    start: Speed = entry("first speed, turns per minute", 672.0)
    stop: Speed = entry("last speed, turns per minute", 756.0)
    num: Whole = entry("points across the range, at least", 201, ge=1, le=100_000)


class AllOrbits(Section):
    """Up to which size `cam orbits` finds all orbits at one speed, and shows that they are all."""

    impacts: Whole = entry("impacts in the period, at most", 3, ge=1, le=9)
    turns: Whole = entry("turns of the period, at most", 2, ge=1, le=9)


class Orbits(Varying):
    """What `cam orbits` finds, follows and locates.

    `vary` says what `rpm`, `parameter` and `range`, and of a curve `curve_in` and `curve_range`,
    say, by keys of the scene.
    """

    rpm: OrbitsRange = entry("range of speeds", default_factory=OrbitsRange)
    vary: Keyed[Axis] = entry("numbers of the machine varied", (), max_length=2)
    at: Speed | None = entry("speed where orbits are found; null: run.rpm, or the middle", None)
    label: str | None = entry("only orbits with this label, P(m;s1:...:sm)", None, max_length=400)
    starts: Whole = entry("motions simulated beside the scene's start", 24, ge=0, le=100_000)
    stability: Literal["any", "stable", "unstable"] = entry("which orbits are followed", "any")
    branches: Whole = entry("branches followed that leave from bifurcations", 3, ge=0, le=1000)
    simulated: Whole = entry("values simulated and drawn behind the branches", 0, ge=0, le=100_000)
    parameter: ParameterName = entry("parameter varied along a branch", "rpm")
    range: Ends | None = entry("range of the parameter, or curve_in; null: around its value", None)
    curve: CurveKind | None = entry("kind of bifurcation to continue in two parameters", None)
    curve_in: ParameterName = entry(
        "second parameter of the curve; one of the cam by its key, as cam.nose_radius",
        "restitution",
    )
    curve_range: Ends | None = entry("range of curve_in; null: orbits.range beside rpm", None)
    all: AllOrbits | None = entry("all orbits up to a size at one speed, proved to be all", None)
    prove: Flag = entry("prove what was found, in ball arithmetic", False)
    checker: Flag = entry("also write check.py, which checks proof.json by itself", False)
    chaos: Flag = entry(
        "prove chaos at one speed, by boxes of impacts that cover one another", False
    )

    @model_validator(mode="after")
    def _something_to_check(self) -> Orbits:
        """Refuse a checker without the proofs that it checks."""
        if self.checker and not (self.prove or self.chaos) and self.all is None:
            raise refused(
                "found checker: true without prove",
                "expected a proof that it can check",
                "write prove: true, or leave checker out",
            )
        return self

    @model_validator(mode="after")
    def _all_alone(self) -> Orbits:
        """Refuse, beside all orbits of one speed, what asks for some of them or for branches."""
        beside = [
            name
            for name in ("label", "curve", "vary", "simulated")
            if self.all is not None and getattr(self, name)
        ]
        if beside:
            raise refused(
                f"found {beside[0]} beside all",
                "expected all orbits at one speed, or some and their branches",
                f"leave out {beside[0]}, or all",
            )
        return self


class BasinsRange(RpmRange):
    """Equally spaced speeds; one where start and stop are equal."""

    start: Speed = entry("first speed, turns per minute", 358.5)
    stop: Speed = entry("last speed, turns per minute", 358.5)
    num: Whole = entry("number of speeds, if they differ", 41, ge=1, le=100_000)


class Basins(Varying):
    """The window of starts at the strobe phase, and how `cam basins` follows them."""

    rpm: BasinsRange = entry("range of speeds", default_factory=BasinsRange)
    q: Span = entry("[low, high] of the starts' position, m", (0.1, 0.9))
    v: Span = entry("[low, high] of the starts' velocity, m/s", (-50.0, 50.0))
    cells: Sides = entry("cells along q and v", (200, 200))
    budget: Whole = entry("turns after which a cell is left undecided", 4000, ge=1, le=10_000_000)
    refine: Whole = entry("times that cells at boundaries are cut in four", 0, ge=0, le=10)
    boundary: Flag = entry("measure the uncertainty exponent of the boundary", False)
    exponents: Flag = entry("multipliers and Lyapunov exponents of the attractors", False)
    saddles: Flag = entry("find the saddles on the boundaries", False)


class ClassifyRange(RpmRange):
    """Equally spaced speeds to classify."""

    num: Whole = entry("number of speeds", 101, ge=1, le=MOST_SPEEDS)


class Classify(Varying):
    """What `cam classify` names, measures and explains."""

    rpm: ClassifyRange = entry("range of speeds", default_factory=ClassifyRange)
    starts: Whole = entry("further starts at each speed", 0, ge=0, le=1_000_000)
    seed: Whole = entry("which cloud of starts", 0, ge=0, le=10**9)
    explain: Flag = entry("find the cause of every change", False)

    @model_validator(mode="after")
    def _few_enough(self) -> Classify:
        """Refuse more motions than can be held at once."""
        motions = self.count * (self.starts + 1)
        if motions > MOST_MOTIONS:
            one = "value" if self.vary else "speed"
            raise refused(
                f"found {plural(self.count, one)} x {plural(self.starts + 1, 'start')}, "
                f"{motions} motions",
                f"expected at most {MOST_MOTIONS}",
                f"ask for fewer {one}s or starts",
            )
        return self


class Explore(Section):
    """What `cam explore` shows beside the motions of a sweep; its speeds are those of sweep.rpm."""

    basins: Flag = entry("the basins at basins.rpm, and motions from a grid of starts", False)
    map: Flag = entry("the map over sweep.vary, and motions at a grid of its points", False)
    source: str = entry("options that name the scene, in the page's commands", "-c SCENE.yaml")


CaseName = Literal[
    "periodic", "chatter", "incomplete", "p3", "chaotic", "critical", "overdamped", "stiff",
    "eccentric",
]  # fmt: skip
MethodName = Literal["core", "rk45", "dop853", "lsoda", "radau", "heyoka", "rk4"]
CASES = get_args(CaseName)
METHODS = get_args(MethodName)


class Bench(Section):
    """What `cam bench` measures: motions, methods and how often."""

    part: Literal["precision", "stability", "scale", "validation"] | None = entry(
        "null: all of them", None
    )
    cases: Names[CaseName] = entry("motions compared by precision", CASES)
    methods: Names[MethodName] = entry("methods compared by precision", METHODS)
    repeats: Whole = entry("timings of a point, after a first call", 3, ge=1, le=1000)
    quick: Flag = entry("a subset: about a minute on an idle machine", False)


def _command_alone(text: str) -> str:
    """The name of a command; what it is asked for stands in the scene."""
    name, _, options = text.strip().partition(" ")
    if options:
        found, expected = f"found options in {text!r}", f"expected {name} alone"
        cure = "write them into the scene: each option of a command is a key of its section"
        raise refused(found, expected, cure)
    if not name:
        raise refused("found no command", "expected the name of a command of cam", "name one")
    return name


class Figure(Section):
    """A figure: what it shows, and the command that draws it from this scene."""

    title: str = entry("what the figure shows, in one line", min_length=1, max_length=200)
    command: Annotated[str, Field(max_length=1000), AfterValidator(_command_alone)] = entry(
        "command that draws it from this scene"
    )
    shows: str = entry(
        "caption, also for who cannot see it; {NAME|.2f} is a number of the run, by "
        "its name in the reference",
        "",
        max_length=2000,
    )
    printed: dict[str, float] = entry("numbers of the run as printed elsewhere, by their names", {})


class Scene(Section):
    """Everything a run depends on.

    Examples
    --------
    >>> import camcli
    >>> scene = camcli.load_scene(None, ["run.rpm=700"])
    >>> scene.run.rpm
    700.0
    >>> scene.cam.kind
    'arcs'
    """

    follower: Follower = entry("the follower, its spring and its restitution")
    cam: Cam = entry("the cam, by kind")
    spring: Spring | None = entry("another way to give the spring", None)
    contact: Contact | None = entry(
        "what touches the cam, for the cam sheet and the Hertz pressure", None
    )
    run: Run = entry("one simulation", default_factory=Run)
    plot: Plot = entry("form of pictures", default_factory=Plot)
    simulate: Simulate = entry("cam simulate", default_factory=Simulate)
    sweep: Sweep = entry("cam sweep", default_factory=Sweep)
    detach: Detach = entry("cam detach", default_factory=Detach)
    orbits: Orbits = entry("cam orbits", default_factory=Orbits)
    classify: Classify = entry("cam classify", default_factory=Classify)
    basins: Basins = entry("cam basins", default_factory=Basins)
    explore: Explore = entry("cam explore", default_factory=Explore)
    bench: Bench = entry("cam bench", default_factory=Bench)
    figure: Figure | None = entry("cam figures: what this scene draws", None)

    @model_validator(mode="before")
    @classmethod
    def _crank_of_speeds(cls, data: Any) -> Any:
        """Where a speed is written as one of a crank there is a crank."""
        sections = {name: (data or {}).get(name) for name in SECTIONS}
        if not names_a_crank(sections):
            return data
        run = data.get("run")
        return {**data, "run": {**(run if isinstance(run, dict) else {}), "crank": True}}

    @model_validator(mode="before")
    @classmethod
    def _room_for_a_spring(cls, data: Any) -> Any:
        """The follower may leave out its stiffness where the loads of the spring are given."""
        follower = (data or {}).get("follower")
        spring = (data or {}).get("spring")
        if not isinstance(follower, dict) or not isinstance(spring, dict):
            return data
        if all(spring.get(name) is None for name in SPRING):
            return data
        given_twice = [name for name in ("stiffness", "preload") if name in follower]
        if given_twice:
            found = f"found follower.{given_twice[0]} beside loads of the spring"
            raise SceneError(Fault("", "spring", found, "expected one of them", "leave one out"))
        return {**data, "follower": {**follower, "stiffness": 0.0}}

    @model_validator(mode="before")
    @classmethod
    def _complete_an_oscillator(cls, data: Any) -> Any:
        """Refuse constants of the follower, and put in what a follower must have.

        Every constant of an oscillator but the restitution is a key of its cam. The mass and the
        stiffness that are put in only pass the validation: `_speed_of_an_oscillator` replaces them.
        """
        cam = (data or {}).get("cam")
        if not isinstance(cam, dict) or cam.get("kind") != "oscillator":
            return data
        follower = data.get("follower")
        seat = follower.get("seat_restitution") if isinstance(follower, dict) else None
        path = ""
        if cam.get("lash") is not None:
            path = "cam.lash"
        elif seat is not None:
            path = "follower.seat_restitution"
        if path:
            found = f"found {path.rpartition('.')[2]} beside an oscillator"
            expected = "expected neither lash nor seat: its stop is where its clearance puts it"
            raise SceneError(Fault("", path, found, expected, "leave it out"))
        allowed_keys = {
            "follower": {"restitution"},
            "run": set(Run.model_fields) - {"rpm"},
            "spring": set(),
        }
        for name, allowed in allowed_keys.items():
            section = data.get(name)
            keys = section if isinstance(section, dict) else ()
            refused_keys = [key for key in keys if key not in allowed]
            if refused_keys:
                found = f"found {refused_keys[0]} beside an oscillator"
                expected = "expected every constant of an oscillator, and its frequency, under cam"
                raise SceneError(Fault("", name, found, expected, OSCILLATOR_CURE))
        if not isinstance(follower, dict):
            return data
        return {**data, "follower": {**follower, "mass": 1.0, "stiffness": 0.0}}

    @model_validator(mode="after")
    def _speed_of_an_oscillator(self) -> Scene:
        """The follower and the speed that an oscillator is; over a range its frequency varies."""
        cam = self.cam
        if not isinstance(cam, OscillatorCam):
            return self
        rpm = cam.frequency * RPM_OF_ONE_RADIAN
        constants = {
            "mass": cam.mass,
            "stiffness": cam.stiffness,
            "damping": cam.follower_damping,
        }
        changes: dict[str, Section] = {
            "follower": self.follower.model_copy(update=constants),
            "run": self.run.model_copy(update={"rpm": rpm}),
        }
        for name in (*VARYING, "detach"):
            section = getattr(self, name)
            _refuse_speeds_of_an_oscillator(section, name)
            speeds = section.rpm.model_copy(update={"start": rpm, "stop": rpm})
            update: dict[str, Any] = {"rpm": speeds}
            if name in ("sweep", "classify") and not section.vary:
                low, high = AROUND_FREQUENCY
                frequencies = Axis(
                    key="cam.frequency",
                    start=low * cam.frequency,
                    stop=high * cam.frequency,
                    num=section.rpm.num,
                )
                update["vary"] = (frequencies,)
            changes[name] = section.model_copy(update=update)
        for name, section in changes.items():
            object.__setattr__(self, name, section)
        return self

    @model_validator(mode="after")
    def _has_a_seat(self) -> Scene:
        """Refuse a lash that is lost in rounding or that the lobe never takes up.

        A restitution on the seat is refused where there is no lash, and so no seat.
        """
        lash = getattr(self.cam, "lash", None)
        on_seat = self.follower.seat_restitution
        if lash is None and on_seat is not None:
            found = f"found {on_seat!r} without cam.lash"
            expected = "expected it beside cam.lash: a follower without lash has no seat"
            cure = "add cam.lash, or leave it out"
            raise SceneError(Fault("", "follower.seat_restitution", found, expected, cure))
        if not isinstance(self.cam, LashedCam) or lash is None:
            return self
        from camcli.cams.compile import build, lift_range

        if not comes_to_its_seat(self.cam):
            found = f"found {lash!r}, and a cam that stays nowhere on its base circle"
            expected = "expected a lash above 0, or a dwell on the base circle, which is the seat"
            cure = "leave it out: without lash the follower rests on its cam"
            raise SceneError(Fault("", "cam.lash", found, expected, cure))
        if 0.0 < lash < SMALL_LASH:
            low, high = lift_range(build(self.cam.as_drawn()))
            least = ROUNDING * max(abs(low), abs(high))
            if lash < least:
                found = f"found {lash!r}, which is lost in the rounding of the cam's heights"
                expected = f"expected {least:.2g} or more"
                cure = "leave it out: without lash the follower rests on its cam"
                raise SceneError(Fault("", "cam.lash", found, expected, cure))
        if not rises_off_its_seat(self.cam):
            low, high = lift_range(build(self.cam.as_drawn()))
            found = f"found {lash!r}, and a cam that lifts {high - low:.6g} m"
            cure = "give it in m, at the follower (behind a rocker: at the valve)"
            raise SceneError(Fault("", "cam.lash", found, MORE_THAN_THE_LIFT, cure))
        return self

    @model_validator(mode="after")
    def _spring_of_loads(self) -> Scene:
        """Stiffness and preload in the place of two loads of the spring.

        A load is k c + F0, at the lowest c on the seat and at the highest on the nose. With the
        stiffness and the preload themselves these are four sums a k + b F0, of which two are given:
        two linear equations for k and F0, solved by Cramer's rule.
        """
        loads = {name: getattr(self.spring, name, None) for name in SPRING}
        given = {name: float(value) for name, value in loads.items() if value is not None}
        if self.spring is None or not given:
            return self
        if len(given) != 2:
            expected = f"expected two of {', '.join(SPRING)}"
            cure = "leave out, or add, the others"
            raise SceneError(Fault("", "spring", f"found {', '.join(given)}", expected, cure))
        from camcli.cams.compile import build, lift_range

        low, high = lift_range(build(self.cam))
        factors = {  # (a, b) of each sum
            "rate": (1.0, 0.0),
            "preload": (0.0, 1.0),
            "seat_load": (low, 1.0),
            "nose_load": (high, 1.0),
        }
        first, second = given
        a1, b1 = factors[first]
        a2, b2 = factors[second]
        determinant = a1 * b2 - b1 * a2
        alike = abs(determinant) <= ROUNDING * max(abs(low), abs(high))  # both at q = 0
        rate = -1.0
        preload = 0.0
        if not alike:
            rate = (given[first] * b2 - b1 * given[second]) / determinant
            preload = (a1 * given[second] - given[first] * a2) / determinant
        if not 0.0 <= rate <= LARGEST or not abs(preload) <= LARGEST:
            found = " and ".join(f"{name} {value:.6g} N" for name, value in given.items())
            at = f"{high:.4g} m than at {round(low, 12) + 0.0:.4g} m"
            cure = "both are at q = 0 here, give another" if alike else "check both loads"
            lift = f"expected a spring that presses harder at {at}"
            raise SceneError(Fault("", "spring", f"found {found}", lift, cure))
        spring = {"stiffness": rate, "preload": preload}
        object.__setattr__(self, "follower", self.follower.model_copy(update=spring))
        without_loads = Spring(
            solid_at=self.spring.solid_at,
            mass=self.spring.mass,
            in_follower=self.spring.in_follower,
        )
        object.__setattr__(self, "spring", without_loads)
        return self

    @model_validator(mode="after")
    def _third_of_the_spring(self) -> Scene:
        """A third of the spring moves with the follower; once it is added the scene says so."""
        spring = self.spring
        if spring is None or spring.mass is None:
            return self
        if self.follower.stiffness == 0.0:
            found, expected = "found a mass of a spring", "expected a stiffness above 0 beside it"
            raise SceneError(Fault("", "spring.mass", found, expected, "give follower.stiffness"))
        if not spring.in_follower:
            mass = self.follower.mass + spring.mass / 3.0
            object.__setattr__(self, "follower", self.follower.model_copy(update={"mass": mass}))
            added = spring.model_copy(update={"in_follower": True})
            object.__setattr__(self, "spring", added)
        return self


def _refuse_speeds_of_an_oscillator(section: Any, name: str) -> None:
    """Raise SceneError where a section of this name gives a speed, or varies what follows from it.

    The speed of an oscillator is its frequency.
    """
    for axis in getattr(section, "vary", ()):
        _refuse_what_an_oscillator_follows_from(axis, name)
    expected = "expected none: its speed is its frequency"
    if not section.rpm.model_fields_set.isdisjoint({"start", "stop"}):
        low = section.rpm.start
        speeds = f"{low!r} rpm" if low == section.rpm.stop else "a range of speeds"
        found = f"found {speeds} for an oscillator"
        raise SceneError(Fault("", f"{name}.rpm", found, expected, OSCILLATOR_CURE))
    at = getattr(section, "at", None)
    if at is not None:
        found = f"found {at!r} rpm for an oscillator"
        raise SceneError(Fault("", f"{name}.at", found, expected, OSCILLATOR_CURE))


def _refuse_what_an_oscillator_follows_from(axis: Axis, section: str) -> None:
    """Raise SceneError where an axis is a constant of the follower, or the speed.

    Both follow from the oscillator's own numbers, except for the restitution. section: its name.
    """
    is_own_number = axis.path.startswith("cam.") or axis.path == "follower.restitution"
    is_of_the_run = axis.path.startswith("run.") and axis.path != "run.rpm"
    if is_own_number or is_of_the_run:
        return
    found = f"found {axis.key} beside an oscillator"
    expected = "expected a number of its cam, or follower.restitution"
    raise SceneError(Fault("", f"{section}.vary", found, expected, OSCILLATOR_CURE))


def json_schema() -> dict[str, Any]:
    """JSON Schema of a scene file, for editors: sections that may be left out may be null."""
    schema = Scene.model_json_schema()
    for model in (schema, *schema["$defs"].values()):
        if "description" in model:  # examples are for who calls the class
            model["description"], _, _ = model["description"].partition("\n\nExamples\n")
        for key, property_ in model.get("properties", {}).items():
            may_be_left_out = key not in model.get("required", ())
            if "$ref" in property_ and may_be_left_out:
                property_["anyOf"] = [{"$ref": property_.pop("$ref")}, {"type": "null"}]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
