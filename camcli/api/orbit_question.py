"""What the section `orbits` of a scene asks, as the analysis takes it.

What is varied may be said in two ways: `vary` names keys of the scene, `parameter` and `range`, and
of a curve `curve_in` and `curve_range`, name constants of the follower. Both become the same
`VariedNumber`: from there on only the columns of the tables depend on which way it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from pydantic import ValidationError

from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.study import OrbitsQuestion
from camcli.api.family import check_ends, check_followed, in_family, why_no_constant
from camcli.api.machine import Machine
from camcli.cams.oscillator import OscillatorCam
from camcli.errors import Fault, SceneError
from camcli.quantities import FOLLOWER, PARAMETERS
from camcli.scene import Axis, Scene
from camcli.scene.faults import wanted
from camcli.scene.schema import OrbitsRange
from camcli.system import System
from camcli.words.followed import cure_of

AROUND = 0.1  # relative range of a constant where none is given
VALUES_A_STEP = 4  # of a number: a step along a curve crosses about so many of them


@dataclass(frozen=True)
class VariedNumber:
    """A number and its range: along a branch, or the second one of a curve.

    name: rpm, a constant of the follower, or the key of a number of the cam. num: values across the
    range, at least. key: the key of the scene where `vary` names it, which is then the name of the
    first column; else empty.
    """

    name: str
    low: float
    high: float
    num: int
    key: str = ""

    @property
    def of_the_cam(self) -> bool:
        """Whether this number belongs to the cam, so that another value of it makes another cam."""
        return self.name not in PARAMETERS

    @property
    def axis(self) -> Axis:
        """The number and its range as an axis of the scene."""
        return Axis(key=self.key, start=self.low, stop=self.high, num=self.num)


def varied_by(scene: Scene) -> list[VariedNumber]:
    """What the section `orbits` varies: along a branch, and of a curve its second number.

    Raises SceneError for a number that a branch cannot vary, and for a range that no follower has.
    """
    section = scene.orbits
    if not section.vary:
        first = _first_by_name(scene)
        return [first] if section.curve is None else [first, _second_by_name(scene, first)]
    numbers = [_by_key(scene, axis) for axis in section.vary]
    if section.curve is None and len(numbers) > 1:
        found = f"found {numbers[0].key} and {numbers[1].key}"
        cure = "leave one out (--rpm X is one speed), or add --curve KIND"
        raise _refusal("vary", found, "one number along a branch", cure)
    if section.curve is not None and len(numbers) == 1:
        only = numbers[0]
        if only.name == "rpm":
            numbers = [only, _second_by_name(scene, only)]
        else:  # the branches vary the speed
            numbers = [_speeds(scene), replace(only, num=section.rpm.num)]
    for number in numbers:
        is_constant = number.name != "rpm" and not number.of_the_cam
        if number.key and is_constant:
            _check(scene, number, "vary")
    return numbers


def with_families(machine: Machine, varied: list[VariedNumber]) -> System:
    """The machine, as a member of a family where numbers of its cam vary.

    Raises SceneError for a range beyond the limits of a number.
    """
    axes = [number.axis for number in varied if number.of_the_cam]
    for axis in axes:
        check_ends(machine, axis)
    return in_family(machine, axes)


def question_of(scene: Scene, varied: list[VariedNumber]) -> OrbitsQuestion:
    """What the section `orbits` asks; raises SceneError where it contradicts itself."""
    section = scene.orbits
    first = varied[0]
    if section.chaos:
        _check_chaos(scene, varied)
    at = _speed_of_orbits(scene, first)
    label = None if section.label is None else _label(section.label)
    at_one_speed = section.chaos or section.all is not None
    follows = first.low < first.high and not at_one_speed
    if first.name == "rpm" and follows and not first.low <= at <= first.high:
        found = f"found rpm = {at!r} where orbits are looked for"
        expected = f"a value from {first.low!r} to {first.high!r}, the range followed"
        raise _refusal("at", found, expected, "choose another range, or --at")
    span = None
    if follows:
        step = (first.high - first.low) / max(1, first.num - 1)
        span = Span(first.low, first.high, step)
    stable_by_word = {"any": None, "stable": True, "unstable": False}
    return OrbitsQuestion(
        rpm=at,
        parameter=first.name,
        span=span,
        label=label,
        branches=section.branches,
        starts=section.starts,
        stable=stable_by_word[section.stability],
        curve=section.curve,
        plane=_plane(scene, first, varied[1]) if len(varied) > 1 else None,
        all_of=None if section.all is None else (section.all.impacts, section.all.turns),
    )


def _label(text: str) -> Label:
    """The label that orbits.label asks for; raises SceneError where the text is none."""
    try:
        return Label.parse(text)
    except ValueError as error:
        expected = "P(m;s1:...:sm) with one count or inf for each of the m turns"
        raise _refusal("label", str(error), expected, "quote it: 'P(3;3:3:2)'") from None


def _plane(scene: Scene, first: VariedNumber, second: VariedNumber) -> Plane:
    """The plane of a curve in two numbers; raises SceneError where the first has no range."""
    if first.low == first.high:
        cure = "give --rpm LO:HI"
        if isinstance(scene.cam, OscillatorCam):
            cure = "add another number of the oscillator: --vary cam.frequency=LO:HI"
        raise _refusal("rpm", "found one speed", "a range for a curve", cure)
    names = (first.name, second.name)
    ranges = ((first.low, first.high), _ends(second))
    return Plane(names, ranges, max(2, second.num // VALUES_A_STEP))


def _check_chaos(scene: Scene, varied: list[VariedNumber]) -> None:
    """Raise SceneError where chaos is to be proved and it is not said at which one speed.

    The range of speeds that every scene has, where it says none, is no contradiction.
    """
    section = scene.orbits
    expected = "one speed, and no other number that varies"
    if section.vary or varied[0].name != "rpm" or len(varied) > 1:
        cure = "leave out what varies, or chaos"
        raise _refusal("chaos", "found a number that varies", expected, cure)
    speeds = _speeds(scene)
    default = OrbitsRange()
    is_default = (speeds.low, speeds.high) == (default.start, default.stop)
    holds_speed = speeds.low <= scene.run.rpm <= speeds.high
    if section.at is None and speeds.low < speeds.high and not is_default and not holds_speed:
        raise _refusal("chaos", "found a range", expected, "give --rpm X, or leave chaos out")


def _ends(varied: VariedNumber) -> tuple[float, float]:
    """Both ends of the range."""
    return varied.low, varied.high


def _speed_of_orbits(scene: Scene, first: VariedNumber) -> float:
    """The speed at which orbits are looked for, rpm.

    It is `orbits.at`, else that of the run where it lies in the range, else the middle of the
    range. All orbits of one speed and chaos need no range: it is then that of the run, unless
    `orbits.rpm` is a single speed.
    """
    section = scene.orbits
    if section.at is not None:
        if isinstance(scene.cam, OscillatorCam) and section.at != scene.run.rpm:
            expected = f"{scene.run.rpm!r}, as the frequency of the oscillator says"
            raise _refusal("at", f"found {section.at!r} rpm", expected, "leave it out")
        return section.at
    if first.key and first.name != "rpm":
        return scene.run.rpm
    speeds = first if first.name == "rpm" else _speeds(scene)
    at_one_speed = section.chaos or section.all is not None
    if at_one_speed and speeds.low < speeds.high:
        return scene.run.rpm
    if speeds.low <= scene.run.rpm <= speeds.high:
        return scene.run.rpm
    return 0.5 * (speeds.low + speeds.high)


def _speeds(scene: Scene) -> VariedNumber:
    """The speeds `orbits.rpm` of the scene, the lower end first."""
    section = scene.orbits.rpm
    low, high = sorted((section.start, section.stop))
    return VariedNumber("rpm", low, high, section.num)


def _by_key(scene: Scene, axis: Axis) -> VariedNumber:
    """What an entry of `orbits.vary` names; raises SceneError for what no branch can vary."""
    name = "rpm" if axis.path == "run.rpm" else axis.path.removeprefix("follower.")
    if axis.path.startswith("follower.") and name not in FOLLOWER:
        expected = f"a constant of the follower: {', '.join(FOLLOWER)}"
        raise _refusal("vary", f"found {axis.key}", expected, "name one of these")
    if name not in PARAMETERS:
        check_followed(scene, axis)
        name = axis.key
    elif name != "rpm":
        _refuse_what_is_not_there(scene, name, axis.key, "vary")
    low, high = sorted((axis.start, axis.stop))
    return VariedNumber(name=name, low=low, high=high, num=axis.num, key=axis.key)


def _first_by_name(scene: Scene) -> VariedNumber:
    """What `parameter` and `range` vary along a branch; the speed has its range in `rpm`."""
    speeds = _speeds(scene)
    name = scene.orbits.parameter
    return speeds if name == "rpm" else _constant(scene, name, "range", speeds.num)


def _second_by_name(scene: Scene, first: VariedNumber) -> VariedNumber:
    """The second number of a curve, by `curve_in` and `curve_range`.

    Where that is left out and the first number is the speed, `range` is that of the second one.
    """
    section = scene.orbits
    _refuse_as_second(section.curve_in, first, "curve_in")
    key = "range" if section.curve_range is None and first.name == "rpm" else "curve_range"
    return _constant(scene, section.curve_in, key, first.num)


def _refuse_as_second(name: str, first: VariedNumber, key: str) -> None:
    """Raise SceneError for what cannot be the second number of a curve."""
    if name in (first.name, "rpm"):
        found = f"found {name} as the second parameter"
        cure = f"another one than {first.name}"
        raise _refusal(key, found, "a constant of the follower", cure)


def _constant(scene: Scene, name: str, key: str, num: int) -> VariedNumber:
    """A constant of the follower over the range orbits.KEY, or else around the scene's value."""
    named_by = "parameter" if name == scene.orbits.parameter else "curve_in"
    _refuse_what_is_not_there(scene, name, name, named_by)
    given = getattr(scene.orbits, key)
    if given is not None:
        low, high = given
        varied = VariedNumber(name, low, high, num)
        _check(scene, varied, key)
        return varied
    value = getattr(scene.follower, name)
    if value == 0.0:
        found = f"found no range for {name}, which is 0"
        raise _refusal(key, found, "LO:HI", "give one, e.g. --range 0:2")
    low, high = sorted((value * (1.0 - AROUND), value * (1.0 + AROUND)))
    if name == "restitution":
        high = min(high, 1.0)
    return VariedNumber(name, low, high, num)


def _refuse_what_is_not_there(scene: Scene, name: str, written: str, key: str) -> None:
    """Raise SceneError for a constant of the follower that the scene does not have.

    written: how the user names it; key: of the section, where the name stands.
    """
    reason = why_no_constant(scene, name)
    if reason:
        found, expected = f"found {written}", f"a number to follow: {reason}"
        raise _refusal(key, found, expected, cure_of(reason))


def _check(scene: Scene, varied: VariedNumber, key: str) -> None:
    """Raise SceneError for a range without the scene's value, or that no follower has.

    key: of the section, where the range stands.
    """
    value = getattr(scene.follower, varied.name)
    found = f"found {varied.low!r} to {varied.high!r}"
    if not varied.low < varied.high:
        cure = "give a range LO:HI" if varied.low == varied.high else "exchange them"
        raise _refusal(key, found, "the lower end first, two different ends", cure)
    for end in _ends(varied):
        try:
            type(scene.follower).model_validate({**dict(scene.follower), varied.name: end})
        except ValidationError as error:
            expected = f"of {varied.name} {wanted(error.errors()[0])}"
            raise _refusal(key, found, expected, "correct the range") from None
    if not varied.low <= value <= varied.high:
        expected = f"a range that holds {varied.name} = {value!r} of the scene"
        raise _refusal(key, found, expected, "choose another range")


def _refusal(key: str, found: str, expected: str, cure: str) -> SceneError:
    """A fault of the key orbits.KEY; expected: what should stand there."""
    return SceneError(Fault("", f"orbits.{key}", found, f"expected {expected}", cure))
