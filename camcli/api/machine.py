"""The machine of a scene, the speeds that a scene leaves open, and the numbers that are varied."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import radians
from os import PathLike
from threading import Lock
from typing import Any, NamedTuple

from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import Settings, Start
from camcli.analysis.natural_speed import Basis, Chosen, NaturalSpeed, natural_speed
from camcli.cams import AnyCam
from camcli.cams.arcs import ArcsCam
from camcli.cams.compile import phase_of
from camcli.cams.law import LawCam, SccaLaw, Widths
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import Fault, SceneError, is_given
from camcli.scene import Axis, Scene, Varying, load_scene, resolved
from camcli.scene.schema import Start as SceneStart
from camcli.system import Follower, System, omega_of

MOST_COMPILED = 256  # machines of a varied number that are kept
MOST_CAMS = 32  # compiled cams that are kept in a process


class Share(NamedTuple):
    """A range of speeds, in shares of the speed that a machine is known by."""

    low: float
    high: float


# The speeds of a section that leaves them open. They lie about the first loss of contact, a little
# below it where the motion before it is of interest; where contact is never lost, widely about the
# natural frequency.
ABOUT_FIRST_LOSS = {
    "sweep": Share(0.9, 1.5),
    "detach": Share(0.9, 1.3),
    "orbits": Share(1.0, 1.4),
    "classify": Share(1.0, 1.4),
}
ABOUT_NATURAL_FREQUENCY = Share(0.5, 2.0)
# The window of starts of basins that leave it open, at one speed past the first loss of contact: as
# high above the top of the cam as HIGH lifts, as fast as FAST times lift times omega.
PAST = 1.05  # of the speed of the first loss
HIGH, FAST = 2.0, 4.0  # lifts; lift times omega
LEAST_LIFT = 1e-12  # of |c|: a window of a smaller lift is made as if the lift were so high
ANGLE_ROUNDING = 4e-16  # relative: two roundings, of pi/180 and of the product
SLOWEST = 1e-300  # m/s, where lift times omega is no double


SceneLike = Scene | str | PathLike | Mapping[str, Any] | None  # what an API function takes


@dataclass(frozen=True)
class Machine:
    """What the analyses need of a scene."""

    scene: Scene
    system: System
    settings: Settings
    chosen: Mapping[str, Chosen] = field(default_factory=dict)  # speeds left open, by section


def machine_of(scene: SceneLike) -> Machine:
    """The compiled machine of a scene, or of what `load_scene` takes, and its runs' settings."""
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    constants = {field.name: getattr(scene.follower, field.name) for field in fields(Follower)}
    system = on_cam(scene.cam, phase_of(scene.run.strobe_deg)).with_follower(**constants)
    scene, chosen = ranged(scene, system)
    run = scene.run
    settings = Settings(
        transient=run.transient,
        record=run.record,
        chatter_tolerance=run.chatter_tolerance,
        impact_budget=run.impact_budget,
        start=start_of(scene, system, run.start, "run.start"),
        patience=run.patience,
    )
    return Machine(scene, system, settings, chosen)


_on_cams: OrderedDict[tuple[str, str], System] = OrderedDict()
_on_cams_lock = Lock()


def on_cam(cam: AnyCam, strobe: float) -> System:
    """A system on a cam, which is compiled once for each strobe (rad) in a process.

    Its follower is a made-up one, to be replaced. A cam is known by its text, in which -0.0 is not
    0.0, and a lift table by its hash. The MOST_CAMS used last are kept.
    """
    key = cam.model_dump_json(), repr(strobe)
    with _on_cams_lock:
        system = _on_cams.pop(key, None)
    if system is None:
        system = System.build(Follower(1.0, 1.0), cam, strobe)
    with _on_cams_lock:
        _on_cams[key] = system
        while len(_on_cams) > MOST_CAMS:
            _on_cams.popitem(last=False)
    return system


def start_of(scene: Scene, system: System, start: SceneStart, place: str) -> Start:
    """A start of the scene, angles in rad; place: where it stands in the scene.

    A start at the phase of the strobe has the very double of the strobe. Its degrees alone would
    not always give that one: the strobe may have been moved onto a corner next to it.
    """
    degrees = start.theta_deg % 360.0
    theta = radians(degrees)
    at_strobe = abs(theta - system.strobe) <= ANGLE_ROUNDING * system.strobe
    if at_strobe or degrees == scene.run.strobe_deg:
        theta = system.strobe
    return Start(start.q, start.v, theta, place)


def refuse_an_oscillator(scene: Scene, command: str) -> None:
    """Raise SceneError for a command that asks what one cam does at several speeds.

    The cam of an oscillator is another one at each frequency of its force.
    """
    if not isinstance(scene.cam, OscillatorCam):
        return
    found = f"found an oscillator, whose cam changes with its speed, for cam {command}"
    expected = "expected a cam that turns at any speed"
    cure = "use cam sweep, cam classify, cam basins, cam orbits or cam simulate"
    raise SceneError(Fault("", "cam.kind", found, expected, cure))


def leaves_speeds_open(scene: Scene, section: str) -> bool:
    """Whether a section has a range of speeds of which the scene gives neither end."""
    speeds = getattr(getattr(scene, section, None), "rpm", None)
    return speeds is not None and speeds.model_fields_set.isdisjoint({"start", "stop"})


def ranged(scene: Scene, system: System) -> tuple[Scene, dict[str, Chosen]]:
    """The scene with the speeds filled in that it leaves open, and these speeds by section.

    They are those of its machine: about the first loss of contact, or the natural frequency where
    contact is never or always lost. What the scene gives stays.
    """
    sections = [name for name in (*ABOUT_FIRST_LOSS, "basins") if leaves_speeds_open(scene, name)]
    natural = natural_speed(system) if sections else None
    if natural is None or natural.rpm == 0.0:
        return scene, {}
    filled: dict[str, Any] = {}
    chosen: dict[str, Chosen] = {}
    for name in sections:
        section = getattr(scene, name)
        values: dict[str, Any] = {}
        if name == "basins":
            speeds = _speed_of_basins(scene, natural)
            window = _window_of_starts(system, speeds.low)
            values = {
                key: ends for key, ends in window.items() if key not in section.model_fields_set
            }
        else:
            speeds = _speeds_about(natural, name)
        values["rpm"] = section.rpm.model_copy(update={"start": speeds.low, "stop": speeds.high})
        filled[name] = section.model_copy(update=values)
        if not getattr(section, "vary", ()):  # else the section goes over another number
            chosen[name] = speeds
    return scene.model_copy(update=filled), chosen


def _speeds_about(natural: NaturalSpeed, section: str) -> Chosen:
    """The range of speeds of a section that leaves it open, about the speed of its machine."""
    share = ABOUT_NATURAL_FREQUENCY
    if natural.basis is Basis.FIRST_LOSS:
        share = ABOUT_FIRST_LOSS[section]
    return Chosen(_round(share.low * natural.rpm), _round(share.high * natural.rpm), natural)


def _speed_of_basins(scene: Scene, natural: NaturalSpeed) -> Chosen:
    """The one speed of basins that leave it open: low and high of the result are the same.

    It is the speed of the run where the scene gives that, or where the section varies another
    number; else one past the first loss of contact.
    """
    if "rpm" in scene.run.model_fields_set or scene.basins.vary:
        return Chosen(scene.run.rpm, scene.run.rpm, None)
    rpm = _round(PAST * natural.rpm)
    return Chosen(rpm, rpm, natural)


def _window_of_starts(system: System, rpm: float) -> dict[str, tuple[float, float]]:
    """The window of starts for basins: positions q (m) and velocities v (m/s), each (low, high)."""
    bottom, lift = _lift(system)
    fastest = _round(FAST * lift * omega_of(rpm)) or SLOWEST
    low = _round(bottom)
    high = _round(bottom + (1.0 + HIGH) * lift)
    if not low < high:  # the lift is below the digits that are shown
        low = bottom
        high = bottom + (1.0 + HIGH) * max(lift, LEAST_LIFT * abs(bottom))
    return {"q": (low, high), "v": (-fastest, fastest)}


def _lift(system: System) -> tuple[float, float]:
    """(lowest c, highest minus lowest), m; 1 m where the cam is flat.

    The bounds of stretches may lie a little beyond the lift itself.
    """
    low, high = system.lift_range
    return low, (high - low) or 1.0


def _round(value: float) -> float:
    """A number to three digits, as a person would choose it."""
    return float(f"{value:.3g}")


def with_values(scene: Scene, name: str, **values: Any) -> Scene:
    """The scene with some values of a section replaced."""
    section = getattr(scene, name).model_copy(update=values)
    return scene.model_copy(update={name: section})


def with_arguments(scene: SceneLike, section: str, **values: Any) -> Scene:
    """The scene of an API function whose keyword arguments are values of its section.

    scene: what the function was given. A value that is None or False was not given.
    Raises SceneError for a value that the section does not allow.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    given = {key: value for key, value in values.items() if is_given(value)}
    if not given:
        return scene
    by_path = {f"{section}.{key}": value for key, value in given.items()}
    checked = getattr(load_scene(None, by_path), section)
    return with_values(scene, section, **{key: getattr(checked, key) for key in given})


def span_of(machine: Machine, section: Varying) -> tuple[str, list[float], Varied | None]:
    """(key, values, setup) of what a section goes over.

    key: of the scene, rpm for the speed. setup: makes the machine at a value; None where the values
    are speeds.
    """
    axis = section.axis
    values = rpm_grid(axis.start, axis.stop, section.count)
    setup = Varied(machine, section.vary) if section.vary else None
    return section.key, values, setup


def check_explainable(section: Varying, name: str) -> None:
    """Raise SceneError where a section of this name has no changes over the speed to explain."""
    if section.vary:
        found = f"found {section.key}"
        cure = "leave --explain out, or vary the speed (--rpm LO:HI)"
        raise SceneError(Fault("--explain", f"{name}.vary", found, "expected none", cure))
    if section.rpm.num < 2:
        found = f"found one speed, {section.rpm.start!r}"
        cure = "give --rpm LO:HI and --points"
        raise SceneError(Fault("--explain", f"{name}.rpm", found, "expected a range", cure))


def closed(cam: AnyCam, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of a scene, and what keeps circles closed and widths adding up to 1.

    changes: values by path. The flank circle of a cam of arcs touches the base circle where its
    radius is base_radius + flank_center: where one of the three is changed alone, flank_radius goes
    with it, and flank_center with flank_radius. Where one width of a law of motion is changed
    alone, another one goes with it (`cams.law.Widths.with_width`).
    """
    changes = dict(changes)
    if isinstance(cam, LawCam):
        return _with_widths(cam, changes)
    if not isinstance(cam, ArcsCam):
        return changes
    of_flank = ("base_radius", "flank_center", "flank_radius")
    changed = [name for name in of_flank if f"cam.{name}" in changes]
    if len(changed) != 1:
        return changes
    base_radius = changes.get("cam.base_radius", cam.base_radius)
    if changed == ["flank_radius"]:
        changes["cam.flank_center"] = changes["cam.flank_radius"] - base_radius
    else:
        flank_center = changes.get("cam.flank_center", cam.flank_center)
        changes["cam.flank_radius"] = base_radius + flank_center
    return changes


def _with_widths(cam: LawCam, changes: dict[str, Any]) -> dict[str, Any]:
    """Changes of the laws of a rise and a fall by path, with the width that goes along."""
    for motion, law in (("rise", cam.rise.law), ("fall", cam.fall.law)):
        if not isinstance(law, SccaLaw):
            continue
        section = f"cam.{motion}.law.scca"
        changed = [name for name in Widths.model_fields if f"{section}.{name}" in changes]
        if len(changed) == 1:
            name = changed[0]
            widths = law.scca.with_width(name, changes[f"{section}.{name}"])  # adding up to 1
            for other in Widths.model_fields:
                changes[f"{section}.{other}"] = getattr(widths, other)
    return changes


@dataclass
class Varied:
    """The machine of a scene at values of some of its numbers.

    axes: these numbers. option: by which they were named, for faults. whole: whether every value of
    the ranges has to be allowed. Then SceneError is raised with every fault where an axis names no
    number of the scene, or where the scene does not allow one of its ends.
    """

    machine: Machine
    axes: Sequence[Axis]
    option: str = "--vary"
    whole: bool = True
    compiled: dict[tuple, Machine] = field(default_factory=dict, repr=False)
    # the changes asked for last and the follower's system at them: a line of a map has only one
    last: tuple[tuple, System] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Load the scene at both ends of each range, unless not every value has to be allowed."""
        if not self.whole:
            return
        for axis in self.axes:
            for value in (axis.start, axis.stop):
                self.loaded({axis.path: value})

    def __call__(self, *values: float) -> tuple[System, float, Settings]:
        """(system, rpm, settings) at a value of each axis.

        The speed and constants of the follower are changed in the machine that is there; for any
        other number a machine is compiled. Up to MOST_COMPILED of these are kept, then none.
        """
        changes = dict(zip((axis.path for axis in self.axes), values, strict=True))
        rpm = changes.pop("run.rpm", None)
        of_follower = {}
        for path in list(changes):
            if path.startswith("follower."):
                of_follower[path.removeprefix("follower.")] = changes.pop(path)

        of_machine = tuple(changes.items())  # the numbers that need a machine of their own
        machine = self.compiled.get(of_machine)
        if machine is None:
            machine = machine_of(self.loaded(changes)) if changes else self.machine
            if len(self.compiled) >= MOST_COMPILED:
                self.compiled.clear()
            self.compiled[of_machine] = machine

        system = machine.system
        if of_follower:
            asked = (of_machine, tuple(of_follower.items()))
            last = self.last  # one read: other threads change it
            if last is not None and last[0] == asked:
                system = last[1]
            else:
                system = system.with_follower(**of_follower)
                self.last = asked, system
        return system, machine.scene.run.rpm if rpm is None else rpm, machine.settings

    def loaded(self, changes: dict[str, Any]) -> Scene:
        """The scene with these keys changed, checked as if a user had given them.

        changes: values by path. A cam that is allowed outside the scene's folder stays allowed.
        """
        scene = self.machine.scene
        changes = closed(scene.cam, changes)
        with_option = {path: (value, self.option) for path, value in changes.items()}
        if getattr(scene.cam, "outside", ""):
            with_option["cam.allow_outside"] = (True, self.option)
        folder = getattr(scene.cam, "folder", "")  # of a lift table, whose file is read again
        return load_scene(resolved(scene), (), with_option, folder=folder)
