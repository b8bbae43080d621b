"""Quantities, one row each: column, unit and words; and how their units convert.

Heads of tables, the reference of the guide, axes, tables on the screen and the descriptions of the
JSON Schema are made from these rows. Which table has which of them stands beside the command, in
`camcli/api`; a quantity of a single table has its row there. Numbers in a table are in SI, beside
degrees and turns per minute, and the columns of a cam sheet in mm and degrees; a unit is written as
one says it: `m/s2`, `N s/m`, `1/turn`.

Angles are converted by `math.degrees` and `math.radians`, speeds by `omega_of` and `rpm_of` of
`camcli/system.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

MM = 1e3  # in a metre
UM = 1e6  # in a metre
MPA = 1e-6  # in a pascal
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "inch": 0.0254, "thou": 0.0254e-3}  # in m
SHAFTS = {"cam": 1.0, "crank": 0.5}  # turns of the cam in one of the shaft
MM_PER_INCH = 25.4
PAPER = {"mm": 1.0, "cm": 10.0, "in": MM_PER_INCH, "pt": MM_PER_INCH / 72.0}  # of pictures, in mm
OF_LENGTH = ("m", "m/rad", "m/rad2", "m/rad3")  # shown in the length of the machine


class Quantity(NamedTuple):
    """What is known of a quantity beside its values.

    column
        Its name in a table, which ends in its unit.
    unit
        Of the numbers in a table; empty for a bare number and for a text.
    name
        What an axis calls it.
    words
        What it is, in full; where left out, its name says so.
    entries
        What may stand in its column, where that is not any number.
    head
        What a column on the screen is called.
    varied
        Whether it stands for what a run varies: the table of a run bears the key there.
    numbered
        Whether there is a column for each impact: `theta_deg_1`, `theta_deg_2`.
    symbol
        In formulas, as TeX: `k`, `\\rho_2`. An axis shows it behind the name.
    """

    column: str
    unit: str
    name: str
    words: str = ""
    entries: str = ""
    head: str = ""
    varied: bool = False
    numbered: bool = False
    symbol: str = ""

    @property
    def label(self) -> str:
        """An axis over it, in the unit of the table: name, symbol and unit."""
        return labelled(f"{self.name} ${self.symbol}$" if self.symbol else self.name, self.unit)

    def columns(self, impacts: int) -> list[str]:
        """The names of its columns where there is one for each impact."""
        return [f"{self.column}_{k + 1}" for k in range(impacts)]

    @property
    def heading(self) -> str:
        """The head of its column on the screen, in the unit of the table."""
        return headed(self.head or self.name, self.unit)

    @property
    def meaning(self) -> str:
        """What the quantity is, for a list of columns."""
        words = self.words or self.name
        return f"{words} ({self.entries})" if self.entries else words

    @property
    def description(self) -> str:
        """What it is, for a key of a scene: words, and unit or range."""
        return ", ".join(filter(None, (self.words or self.name, self.entries or self.unit)))


class Units(NamedTuple):
    """In which lengths and stiffnesses the numbers of a machine are shown."""

    length: str
    per_m: float
    stiffness: str

    def lengths(self, metres: float, digits: int = 3) -> str:
        """A length in m as it is shown, with its unit."""
        return f"{metres * self.per_m:.{digits}g} {self.length}"

    def stiffnesses(self, newtons_per_m: float, digits: int = 4) -> str:
        """A stiffness in N/m as it is shown, with its unit."""
        rounded = float(f"{newtons_per_m / self.per_m:.{digits}g}")
        return f"{rounded:.12g} {self.stiffness}"  # 10710, and not 1.071e+04

    def shown(self, unit: str) -> tuple[str, float]:
        """(the unit in which numbers of a unit are shown, the factor from one to the other)."""
        if unit in OF_LENGTH:
            return self.length + unit.removeprefix("m"), self.per_m
        if unit == "N/m":
            return self.stiffness, 1.0 / self.per_m
        if unit == "Pa":
            return "MPa", MPA
        return unit, 1.0

    def head(self, quantity: Quantity) -> str:
        """The head of a column on the screen: `loft (mm)`; of a rate only what is counted."""
        name = quantity.head or quantity.name
        if quantity.unit.startswith("1/"):
            return name
        unit, _ = self.shown(quantity.unit)
        return headed(name, unit)


METRES = Units("m", 1.0, "N/m")
MILLIMETRES = Units("mm", MM, "N/mm")


def ending(unit: str) -> str:
    """A unit as the name of a column ends: `m_per_s2` of `m/s2`, `per_turn` of `1/turn`."""
    return unit.lower().replace("1/", "per_").replace("/", "_per_").replace(" ", "_")


def drawn(unit: str) -> str:
    """A unit in a picture: `m/s²`."""
    return unit.replace("2", "²").replace("3", "³").replace("um", "µm")


def headed(name: str, unit: str) -> str:
    """The head of a column on the screen with its unit."""
    return f"{name} ({unit})" if unit else name


def labelled(name: str, unit: str) -> str:
    """The name of an axis with its unit in a picture."""
    return headed(name, drawn(unit))


# --- what a run can vary: the speed and the constants of the follower, by their keys in a scene

RPM = Quantity("rpm", "rpm", "cam speed", "speed of the cam", entries="turns per minute")
FOLLOWER = {  # in the order of `kernel.flow`
    "mass": Quantity("mass_kg", "kg", "mass", "mass of the follower", symbol="m"),
    "stiffness": Quantity(
        "stiffness_n_per_m", "N/m", "stiffness", "stiffness of the spring", head="rate", symbol="k"
    ),
    "damping": Quantity(
        "damping_n_s_per_m", "N s/m", "damping", "damping to the frame", symbol="b"
    ),
    "gravity": Quantity(
        "gravity_m_per_s2", "m/s2", "gravity", "gravity, positive towards the cam", symbol="g"
    ),
    "preload": Quantity(
        "preload_n", "N", "preload", "spring force at q = 0, positive towards the cam", symbol="F_0"
    ),
    "restitution": Quantity(
        "restitution", "", "coefficient of restitution", entries="0..1", head="restitution",
        symbol="r",
    ),
    "seat_restitution": Quantity(
        "seat_restitution",
        "",
        "restitution on the seat",
        "coefficient of restitution on the seat of a cam with lash; null: that of the cam",
        entries="0..1",
    ),
}  # fmt: skip
PARAMETERS = {"rpm": RPM, **FOLLOWER}

# --- other numbers of a scene that a run can vary, by their keys: what an axis over them says

CAM = {  # below `cam`; the symbols are those of the drawing of the cam's geometry
    "lash": Quantity("lash_m", "m", "lash"),
    "base_radius": Quantity("base_radius_m", "m", "base circle radius", symbol=r"\rho_0"),
    "flank_center": Quantity(
        "flank_center_m", "m", "distance of the flank's centre", symbol=r"\kappa_1"
    ),
    "flank_radius": Quantity("flank_radius_m", "m", "flank radius", symbol=r"\rho_1"),
    "nose_center": Quantity(
        "nose_center_m", "m", "distance of the nose's centre", symbol=r"\kappa_2"
    ),
    "nose_radius": Quantity("nose_radius_m", "m", "nose radius", symbol=r"\rho_2"),
    "top_dwell_deg": Quantity("top_dwell_deg", "deg", "top dwell"),
    "offset": Quantity("offset_m", "m", "length subtracted from the radius"),
    "base": Quantity("base_m", "m", "lowest position of the cam"),
    "lift": Quantity("lift_m", "m", "lift of the cam"),
    "rise.start_deg": Quantity("start_deg", "deg", "start of the rise"),
    "rise.length_deg": Quantity("length_deg", "deg", "length of the rise"),
    "fall.length_deg": Quantity("length_deg", "deg", "length of the fall"),
    "subtract": Quantity("subtract", "", "number of the table at zero lift"),
    "max_lift": Quantity("max_lift_m", "m", "largest lift of the table"),
    "lift_scale": Quantity("lift_scale", "", "factor on the lift of the table"),
    "rocker_ratio": Quantity("rocker_ratio", "", "ratio of the rocker"),
    "zero_deg": Quantity("zero_deg", "deg", "cam angle at the table's zero"),
    "smoothing": Quantity("smoothing_m", "m", "rms deviation from the table"),
    "mass": Quantity("mass_kg", "kg", "mass of the oscillator", symbol="m"),
    "stiffness": Quantity(
        "stiffness_n_per_m", "N/m", "stiffness of the oscillator", symbol="k"
    ),
    "damping": Quantity("damping_n_s_per_m", "N s/m", "damping of the oscillator", symbol="b"),
    "damping_ratio": Quantity("damping_ratio", "", "damping ratio", symbol=r"\zeta"),
    "amplitude": Quantity("amplitude_n", "N", "amplitude of the force"),
    "frequency": Quantity("frequency_rad_per_s", "rad/s", "circular frequency of the force"),
    "clearance": Quantity("clearance_m", "m", "clearance to the stop"),
    **{
        f"{motion}.law.scca.{letter}": Quantity(
            letter, "", f"{part} share of the {motion}", symbol=letter
        )
        for motion in ("rise", "fall")
        for letter, part in (("b", "sine"), ("c", "constant"), ("d", "cosine"))
    },
}  # fmt: skip
RUN = {  # below `run`
    "start.q": Quantity("q_m", "m", "position at the start", symbol="q"),
    "start.v": Quantity("v_m_per_s", "m/s", "velocity at the start", symbol="v"),
    "start.theta_deg": Quantity("theta_deg", "deg", "cam angle at the start", symbol=r"\theta"),
    "transient": Quantity("transient", "turns", "turns before the record"),
    "record": Quantity("record", "turns", "recorded turns"),
    "patience": Quantity("patience", "turns", "turns until a motion is called aperiodic"),
    "strobe_deg": Quantity("strobe_deg", "deg", "phase of the strobe"),
    "chatter_tolerance": Quantity("chatter_tolerance", "turns", "error of the accumulation"),
    "impact_budget": Quantity("impact_budget", "", "impacts in a turn, at most"),
    "work_budget": Quantity("work_budget", "", "gap evaluations, at most"),
}
VARIABLE = {  # every number that a run can vary, by its key in a scene
    "rpm": RPM,
    "run.rpm": RPM,
    **{f"follower.{name}": one for name, one in FOLLOWER.items()},
    **{f"cam.{name}": one for name, one in CAM.items()},
    **{f"run.{name}": one for name, one in RUN.items()},
}

# --- the lift, its derivatives by the cam angle, and the forces

THETA = Quantity("theta_deg", "deg", r"cam angle $\theta$", "angle of the cam", head="theta")
LIFTS = {  # by the names that a summary has for them
    "c": Quantity("c_m", "m", "$c$", "lift of the cam"),
    "c_theta": Quantity("c_theta_m_per_rad", "m/rad", r"$c_\theta$", "slope of the lift"),
    "c_thetatheta": Quantity(
        "c_thetatheta_m_per_rad2", "m/rad2", r"$c_{\theta\theta}$", "second derivative of the lift"
    ),
}
JERK = Quantity(
    "c_thetathetatheta_m_per_rad3", "m/rad3", r"$c_{\theta\theta\theta}$",
    "third derivative of the lift, on either side of where it jumps; of a measured cam that of the "
    "fit, an estimate",
)  # fmt: skip
LIFT_RANGES = {**LIFTS, "c_thetathetatheta": JERK}
PER_DEGREE = (  # as a cam sheet has them: mm and degrees of the cam
    Quantity("lift_mm", "mm", "lift", "lift above the lowest"),
    Quantity("velocity_mm_per_deg", "mm/deg", "velocity", "slope of the lift"),
    Quantity("acceleration_mm_per_deg2", "mm/deg2", "acceleration", "second derivative"),
    Quantity("jerk_mm_per_deg3", "mm/deg3", "jerk", "third derivative"),
)
FORCE = Quantity("force_n", "N", "contact force")
PRESSURE = Quantity("pressure_pa", "Pa", "Hertz pressure", head="Hertz")

# --- the motion

TIME = Quantity("t_s", "s", "time", "time from the first recorded turn")
Q = Quantity("q_m", "m", "position $q$", "position of the follower", head="q")
V = Quantity("v_m_per_s", "m/s", "velocity $v$", "velocity of the follower", head="v")
U = Quantity(
    "u_m_per_s", "m/s", r"relative velocity $u = v - \dot c$", "velocity relative to the cam"
)
U_MINUS = Quantity(
    "u_minus_m_per_s", "m/s", "landing velocity", "velocity relative to the cam just before",
    head="u-",
)  # fmt: skip
U_PLUS = Quantity(
    "u_plus_m_per_s", "m/s", "rebound velocity", "velocity relative to the cam just after",
    head="u+",
)  # fmt: skip
EXPONENT = Quantity(
    "lyapunov_per_period", "1/turn", "largest exponent", "largest Lyapunov exponent",
    head="exponent",
)  # fmt: skip

EXPONENT_ERROR = Quantity(
    "lyapunov_error_per_period", "1/turn", "standard error",
    "standard error of the largest Lyapunov exponent, from 20 parts of the record; 0 of a solved "
    "orbit",
)  # fmt: skip

# --- what an engineer reads off a record: columns of speeds.csv and map.csv, panels of a map

LOADS = {
    one.column: one
    for one in (
        Quantity("max_gap_m", "m", "largest gap", "largest distance from the cam", head="loft"),
        Quantity("airborne_fraction", "", "share of the time in the air"),
        Quantity("max_impact_m_per_s", "m/s", "hardest impact", "hardest landing", head="lands"),
        Quantity(
            "min_contact_force_n", "N", "least contact force", "least force while on the cam"
        ),
        Quantity(
            "max_contact_force_n", "N", "largest contact force", "largest force while on the cam",
            head="force",
        ),
        Quantity(
            "contact_lost_deg", "deg", "contact first lost",
            "first phase after the strobe at which contact is lost from rest",
        ),
        Quantity(
            "contact_regained_deg", "deg", "contact last regained",
            "last phase after the strobe at which the follower comes to rest on the cam",
        ),
        Quantity("landing_deg", "deg", "phase of the hardest impact", head="at"),
        Quantity(
            "landing_lift_m", "m", "lift at the hardest impact",
            "lift of the cam above its lowest at the hardest impact", head="at lift",
        ),
        Quantity(
            "shut_bounces_per_turn", "1/turn", "bounces on the shut cam",
            "impacts, a tenth as hard as the hardest or harder, within a hundredth of the lift",
            head="bounces",
        ),
    )
}  # fmt: skip

# --- of a cam with lash: what an engineer reads off the seat; more columns of the same tables

SEAT = {
    one.column: one
    for one in (
        Quantity(
            "seat_velocity_m_per_s", "m/s", "seating velocity", "hardest impact on the seat",
            head="seats",
        ),
        Quantity(
            "seat_ramp_velocity_m_per_s", "m/s", "velocity of the closing ramp",
            "velocity with which a follower that never leaves the lobe comes to its seat",
            head="ramp",
        ),
        Quantity(
            "seat_opening_velocity_m_per_s", "m/s", "opening blow",
            "hardest impact with which the lobe meets a follower that comes from its seat",
            head="blow",
        ),
        Quantity(
            "seat_bounces_per_turn", "1/turn", "impacts on the seat",
            "impacts on the seat, a tenth as hard as the hardest one there or harder",
            head="bounces",
        ),
        Quantity(
            "seat_bounce_height_m", "m", "height of the bounces",
            "highest flight after an impact on the seat, above the seat", head="bounce",
        ),
        Quantity(
            "seat_lift_lost_m", "m", "lift lost to lash",
            "largest lift of the cam as it is drawn less that of a follower on it", head="lost",
        ),
        Quantity(
            "seat_open_deg", "deg", "open angle",
            "angle of the cam in a turn over which the follower is not at rest on its seat",
            head="open",
        ),
        Quantity(
            "seat_open_lash_deg", "deg", "open angle with lash",
            "the same of a follower that never leaves the lobe: from one corner to the other",
            head="with lash",
        ),
        Quantity(
            "seat_open_drawn_deg", "deg", "open angle as drawn",
            "the same without lash: the angle of the cam that is no base circle; of a table where "
            "the lift is above its last digit, or three standard deviations of its rows",
            head="as drawn",
        ),
        Quantity(
            "seat_lobe_fraction", "", "share of the turn on the lobe",
            "share of the time at rest on the lobe", head="on lobe",
        ),
    )
}  # fmt: skip

# --- what tables say of a motion, in words and counts

LABEL = Quantity("label", "", "label", "name of the motion", "P(m;s1:...:sm), contact, aperiodic")
STATUS = Quantity("status", "", "status", "whether the row may be used", "ok, or what happened")
PERIOD = Quantity("period", "turns", "period", "turns after which the motion repeats")
TURN = Quantity("period", "", "turn", "recorded turn", "from 0")
HOLDS_FOR = Quantity(
    "holds_for", "", "holds for", "of which machines the label is shown after a rest",
    "last-digit, exact-data, rounding, or empty",
)  # fmt: skip
WATCHED = Quantity(
    "watched_turns", "turns", "watched turns",
    "turns for which what is, or first looked, aperiodic was followed in all",
)  # fmt: skip
REGION = Quantity("region", "", "region", "part of the cam between two corners", "A1, A2, ...")
CORNER = Quantity("corner", "", "corner", "corner of the cam", "a, b, c, ...")
BRANCH = Quantity("branch", "", "branch", "number of the branch")
STABLE = Quantity("stable", "", "stable", "whether the orbit attracts", "0 or 1")
MULTIPLIERS = tuple(
    Quantity(f"multiplier_{k}_{part}", "", "multiplier", f"{words} part of multiplier {k}")
    for k in (1, 2)
    for part, words in (("re", "real"), ("im", "imaginary"))
)
PROVED = Quantity("proved", "", "proved", "whether it is proved in ball arithmetic", "yes, no")

# --- what a run varies: the table of a run bears the key

VARIED = Quantity(
    "rpm", "rpm", "what is varied", "cam speed, or under its key another number that is varied",
    varied=True,
)  # fmt: skip
FIRST = Quantity("KEY", "", "first number", "first number that is varied", varied=True)
SECOND = Quantity("KEY", "", "second number", "second number that is varied", varied=True)


class Head(NamedTuple):
    """A table of a command: its name, what a row is, and its columns.

    more: columns that only some runs have, by what makes them have it.
    """

    name: str
    words: str
    columns: tuple[Quantity, ...]
    more: Mapping[str, tuple[Quantity, ...]] = {}

    def names(self, *keys: str, impacts: int = 1) -> tuple[str, ...]:
        """The names of the columns that every run has.

        keys
            Of what is varied, in the order of the columns; without them `rpm`.
        impacts
            How many columns a numbered quantity has.
        """
        keys_left = iter(keys)
        names: list[str] = []
        for quantity in self.columns:
            if quantity.numbered:
                names += quantity.columns(impacts)
            elif quantity.varied:
                names.append(next(keys_left, quantity.column))
            else:
                names.append(quantity.column)
        return tuple(names)
