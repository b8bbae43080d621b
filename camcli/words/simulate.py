"""What `cam simulate` says of one motion, and of the cam alone."""

from collections.abc import Mapping
from math import degrees, floor, log10

from camcli.analysis.cam_profile import Curvature, Profile
from camcli.analysis.contact_loss.detachment import CriticalSpeed
from camcli.analysis.contact_loss.force import ForceCurve
from camcli.analysis.lobe import Face, Lobe
from camcli.analysis.simulate import Simulation
from camcli.errors import Status, plural
from camcli.quantities import Units
from camcli.system import System, units_of
from camcli.words.in_print import label_text, newtons, number_text
from camcli.words.speeds import number_range, range_words, run_speed
from camcli.words.statuses import CAUSES

CLOSED = 1e-12  # of the largest radius: an outline whose ends are nearer is closed
MANY = 12  # corners that are not named one by one
ASSUMED = (
    "what runs on the cam moves along a line through the axis, "
    "at base_radius + (c - least c)/rocker_ratio"
)


JERK_OF_A_FIT = (
    "the jerk is that of the fitted cam: where the jerk of the measured one jumps the fit "
    "goes over gradually, and a table cannot rule out a corner between its rows, where it is "
    "infinite"
)


def record_title(found: Simulation, listed: int, kind: str = "") -> str:
    """The title of the table of events.

    listed: how many of them are in the table, the last ones; kind: of the cam.
    """
    recorded = len(found.events)
    title = f"{run_speed(found.rpm, kind)}: {found.label}, {plural(recorded, 'event')} recorded"
    if listed == recorded:
        return title
    if found.repeats and listed == len(found.last_period):
        return f"{title}, those of one period"
    return f"{title}, the last {listed}"


def rounding_notes(turn: int | None) -> list[str]:
    """From which turn of the record on rounding decides; turns before the record are negative."""
    if turn is None:
        return []
    place = f"turn {turn} of the record"
    if turn < 0:
        place = f"{plural(-turn, 'turn')} before the record"
    return [
        f"from {place} on, this is one of many motions that rounding allows: an error of the last "
        "digit has grown beyond five digits of a turn (the label is that of the true motion, where "
        "that could be told)"
    ]


def end_notes(simulation: Simulation) -> list[str]:
    """What becomes of a motion whose record looks aperiodic, in a sentence; else none."""
    ends = simulation.ends
    if ends is None or ends.watched is None:
        return []
    turns = plural(ends.watched, "turn")
    if ends.orbit is not None:
        words = f"a transient: followed for {turns}, the motion has settled on {simulation.label}"
    elif ends.chatters:
        words = f"no period, and after {turns} a rest: what follows is not known"
    else:
        words = f"no period; it was followed for {turns}"
    return [f"the record shows {words}"]


def undercut_notes(profile: Profile, system: System) -> list[str]:
    """A warning where a flat face would not touch the whole cam."""
    curvature = profile.curvature
    units = units_of(system)
    if not curvature.undercut:
        return []
    least = curvature.flat_least
    return [
        f"warning: a flat-faced follower undercuts this cam: the radius of curvature would be "
        f"{units.lengths(least.value, 4)} at {degrees(least.theta):.5g} deg; the base radius must "
        f"exceed {units.lengths(curvature.least_base_radius, 4)} (knife edge and roller "
        "have other limits)"
    ]


def lobe_notes(lobe: Lobe, units: Units) -> list[str]:
    """A warning where the lobe that gives this lift cannot be made."""
    if not lobe.undercut:
        return []
    least = lobe.least
    at = f"{units.lengths(least.value, 4)} at {degrees(least.theta):.5g} deg"
    warning = f"warning: the lobe is undercut: its radius of curvature would be {at}; "
    if lobe.face is Face.FLAT:
        needed = units.lengths(lobe.least_base or 0.0, 4)
        return [f"{warning}the base radius must exceed {needed}"]
    if lobe.largest_roller is None:
        return ["warning: the lobe is undercut: the slope of the lift drops at a corner"]
    largest = units.lengths(lobe.largest_roller.value, 4)
    return [f"{warning}on this base circle a roller may have at most {largest}"]


def pressure_notes(lobe: Lobe, units: Units) -> list[str]:
    """A warning where the lobe is undercut and its Hertz pressure is asked for."""
    because = "where it is undercut the Hertz pressure is infinite"
    return [f"{warning}; {because}" for warning in lobe_notes(lobe, units)]


def closing_words(lobe: Lobe, units: Units) -> str:
    """Whether the outline closes."""
    lift = max(touch.along for touch in lobe.touches)
    if lobe.closing <= CLOSED * lift:
        return "closes to rounding"
    return f"does not close: {units.lengths(lobe.closing)} are missing"


def lobe_title(lobe: Lobe, units: Units) -> str:
    """What runs on the lobe."""
    if lobe.face is Face.ROLLER:
        return f"roller of {units.lengths(lobe.roller, 4)}"
    return "knife edge" if lobe.face is Face.KNIFE else "flat face"


def radius_title(lobe: Lobe, units: Units) -> str:
    """The least radius of the lobe, and what follows for the roller or the base circle."""
    least = units.lengths(lobe.least.value, 4)
    title = f"undercut, {least}" if lobe.undercut else f"least {least}"
    if lobe.face is Face.FLAT:
        return f"{title}; needs a base radius above {units.lengths(lobe.least_base or 0.0, 4)}"
    if lobe.hollow is not None:
        title += f", hollow {units.lengths(lobe.hollow.value, 4)}"
    if lobe.largest_roller is not None:
        title += f", largest roller {units.lengths(lobe.largest_roller.value, 4)}"
    return title


def beside_title(lobe: Lobe, units: Units) -> str:
    """The extremes of the pressure angle, or of a flat face those of the eccentricity."""
    least, largest = lobe.beside
    if lobe.face is Face.FLAT:
        low = least.value * units.per_m
        high = largest.value * units.per_m
        title = f"{number_range(low, high, 4)} {units.length}"
    else:
        title = f"{number_range(degrees(least.value), degrees(largest.value), 4)} deg"
    return title.replace("-", "−")


def jerk_title(corners: Mapping[str, float]) -> str:
    """Where the jerk is infinite: the corners of the cam."""
    if not corners:
        return "infinite nowhere"
    if len(corners) > MANY:
        return f"infinite at {len(corners)} corners"
    return f"infinite at {', '.join(corners)}"


def fitted_jerk_title(error: float, units: Units) -> str:
    """How surely the jerk of a fit is known; error: the largest estimate, m/rad3."""
    return f"of the fit; its error estimated up to {units.lengths(error, 2)}/rad³, but for jumps"


# --- beside the pictures


def motion_title(found: Simulation, kind: str) -> str:
    """The speed and the label; kind: of the cam."""
    speed = f"{number_text(found.rpm)} rpm" if kind != "oscillator" else run_speed(found.rpm, kind)
    return f"{speed}, {label_text(found.label)}"


def stopped(found: Simulation) -> str:
    """Why the record ends early; empty where it does not."""
    status = Status(found.status)
    return "" if status == Status.OK else f"stopped ({status.text}): {CAUSES[status]}"


def cam_words(first: CriticalSpeed | None, measured: bool, ratio: float) -> str:
    """Where contact is first lost on a cam, and which side of a rocker is drawn."""
    words = "no speed marks a first detachment"
    if first is not None and first.finite:
        digits = 4 if measured else 6
        at = f"{degrees(first.theta):.{digits}g} deg"
        words = f"first detachment at {first.rpm:.{digits}g} rpm, {at}"
        if measured:
            words += f" ({range_words(first.low, first.high)} by the error of the table)"
    if ratio != 1.0:
        words += f"; outline and curvature are those of the lobe under a rocker of {ratio:.6g}"
    return words


def cam_title(lift: float, units: Units) -> str:
    """The title of a cam."""
    return f"Cam with a lift of {units.lengths(lift, 4)}"


def force_title(curve: ForceCurve) -> str:
    """The speed of a contact force, and its least value, to the fourth digit of the largest."""
    largest = max(map(abs, curve.force_n), default=0.0)
    places = 3 - floor(log10(largest)) if largest > 0.0 else 0
    least = round(curve.lowest_n, places)
    return f"at {number_text(curve.rpm)} rpm, least {newtons(least, 4)}"


def flat_face_title(bent: Curvature, units: Units) -> str:
    """What a flat face needs of the cam."""
    face = "flat face: undercut" if bent.undercut else "flat face"
    return f"{face}, needs a base radius above {units.lengths(bent.least_base_radius, 4)}"


def roller_title(bent: Curvature, units: Units) -> str:
    """What a knife edge or a roller sees of the cam."""
    largest = "" if bent.roller is None else f" of at most {units.lengths(bent.roller.value, 4)}"
    return f"knife, or roller{largest}: pitch curve"


def slowed(rpm: float, seconds: float, near: float = 1.0) -> str:
    """How an animation whose turns take so many seconds compares with the machine.

    near: how many times slower than elsewhere it is near impacts.
    """
    factor = seconds * rpm / 60.0
    text = f"{factor:.3g} times slower" if factor >= 1.0 else f"{1.0 / factor:.3g} times faster"
    return text if near == 1.0 else f"{text}, {near:.3g} times that near impacts"
