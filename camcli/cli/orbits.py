"""cam orbits"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.locate import LOST, UNRESOLVED
from camcli.analysis.orbits.search import RECORD
from camcli.analysis.orbits.study import OrbitsResult, Question, orbits
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request
from camcli.cli.orbits_words import show, summary
from camcli.cli.plan_starts import starts_planned
from camcli.cli.progress import bar
from camcli.cli.report import finish
from camcli.cli.setup import Setup, set_up, timed
from camcli.errors import Fault, SceneError
from camcli.output.orbits import bifurcations_csv, branch_csv, curve_csv
from camcli.output.run_folder import RunFolder, run_folder
from camcli.scene import parse_rpm

NAME = "orbits"
NATURAL = {"restitution": (0.0, 1.0)}
AROUND = 0.1  # relative range of a parameter where none is given
OPTIONS = ("label", "parameter", "branches", "curve")


def run(request: Request) -> int:
    """Find, follow and classify periodic orbits; returns the exit code."""
    setup = set_up(request, _options(request))
    question = _question(request, setup)
    run = replace(setup.settings, record=RECORD)
    rpms = [question.rpm] * (setup.scene.orbits.starts + 1)
    if starts_planned(NAME, request, setup, rpms, run, "orbits.starts"):
        return DONE
    with run_folder(request.folder(NAME)) as store:
        progress = nullcontext() if request.quiet else bar("branches", question.branches + 2)
        with timed(request) as watch, progress as tick:
            result = orbits(setup.system, setup.settings, question, tick or (lambda: None))
        seconds = watch.seconds
        _write(request, setup, store, result)
        if not request.json:
            show(result)
        finish(NAME, request, setup, store, result.cost, seconds, summary(result))
        return _verdict(result)


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    """Scene values of the options."""
    values: dict[str, tuple[Any, str]] = {}
    if request.rpm is not None:
        rpm = parse_rpm(request.rpm)
        low, high = rpm if isinstance(rpm, tuple) else (rpm, rpm)
        values["orbits.rpm.start"] = (low, "--rpm")
        values["orbits.rpm.stop"] = (high, "--rpm")
    if request.points is not None:
        values["orbits.rpm.num"] = (request.points, "--points")
    for name in OPTIONS:
        if request.extra[name] is not None:
            values[f"orbits.{name}"] = (request.extra[name], f"--{name}")
    if request.extra["at"] is not None:
        at = _numbers(request.extra["at"], "--at", 1)[0]
        values["orbits.at"] = (at, "--at")
        if values.get("orbits.rpm.start", (0.0,))[0] == values.get("orbits.rpm.stop", (1.0,))[0]:
            found = f"found one speed with --rpm and {at!r} with --at"
            cure = "give --rpm LO:HI, or leave --at out"
            raise SceneError(Fault("--at", "", found, "expected a range around it", cure))
    if request.extra["second"] is not None:
        values["orbits.curve_in"] = (request.extra["second"], "--in")
    if request.extra["range"] is not None:
        values["orbits.range"] = (_numbers(request.extra["range"], "--range", 2), "--range")
    _refuse_idle(request)
    return values


def _refuse_idle(request: Request) -> None:
    """Options that would mean nothing together are said, not passed over."""
    extra = request.extra
    speeds = parse_rpm(request.rpm) if request.rpm is not None else 0.0
    faults = [
        (extra["parameter"] and extra["curve"], "--parameter", "with --curve", "use --in"),
        (extra["second"] and not extra["curve"], "--in", "without --curve", "add --curve KIND"),
        (
            extra["range"] and not (extra["parameter"] or extra["curve"]), "--range",
            "without a parameter", "add --parameter or --curve and --in",
        ),
        (
            extra["parameter"] not in (None, "rpm") and isinstance(speeds, tuple), "--parameter",
            "with a range of speeds", "give one speed: --rpm X",
        ),
    ]  # fmt: skip
    found = [
        Fault(name, "", f"found {name} {what}", "it means nothing there", cure)
        for wrong, name, what, cure in faults
        if wrong
    ]
    if found:
        raise SceneError(*found)


def _numbers(text: str, option: str, count: int) -> list[float]:
    """One number, or LO:HI."""
    try:
        values = [float(word) for word in text.split(":")]
    except ValueError:
        values = []
    if len(values) != count or any(value != value for value in values):
        expected = "expected one number" if count == 1 else "expected two numbers LO:HI"
        raise SceneError(Fault(option, "", f"found '{text}'", expected, "e.g. 0.6:0.9"))
    return values


def _question(request: Request, setup: Setup) -> Question:
    section, parameter = setup.scene.orbits, setup.scene.orbits.parameter
    low, high = sorted((section.rpm.start, section.rpm.stop))
    at = section.at
    if at is None:
        inside = low <= setup.scene.run.rpm <= high
        at = setup.scene.run.rpm if inside else 0.5 * (low + high)
    span = None
    if parameter != "rpm" and section.curve is None:
        low, high = _range(setup, parameter)
    if low < high:
        span = Span(low, high, (high - low) / max(1, section.rpm.num - 1))
        _check_inside(setup, parameter if section.curve is None else "rpm", at, span)
    return Question(
        rpm=at, parameter=parameter if section.curve is None else "rpm", span=span,
        label=_label(section.label), branches=section.branches, starts=section.starts,
        curve=section.curve, plane=_plane(setup, span),
        stable={"any": None, "stable": True, "unstable": False}[section.stability],
    )  # fmt: skip


def _check_inside(setup: Setup, parameter: str, rpm: float, span: Span) -> None:
    """Orbits are found at a value that lies in the range followed."""
    value = rpm if parameter == "rpm" else getattr(setup.scene.follower, parameter)
    if span.holds(value):
        return
    path = "orbits.at" if parameter == "rpm" else "orbits.range"
    found = f"found {parameter} = {value!r} where orbits are looked for"
    expected = f"expected a value from {span.low!r} to {span.high!r}, the range followed"
    raise SceneError(Fault("", path, found, expected, "choose another range, or --at"))


def _label(text: str | None) -> Label | None:
    if text is None:
        return None
    try:
        return Label.parse(text)
    except ValueError as error:
        expected = "expected P(m;s1:...:sm) with one count or inf for each of the m turns"
        cure = "quote it for the shell: 'P(3;3:3:2)'"
        raise SceneError(Fault("", "orbits.label", str(error), expected, cure)) from None


def _range(setup: Setup, name: str) -> tuple[float, float]:
    """The range asked for, or one around the scene's value."""
    given = setup.scene.orbits.range
    if given is not None:
        if not given[0] < given[1]:
            found = f"found {given[0]!r} to {given[1]!r}"
            expected = "expected the lower end first, and two different ends"
            raise SceneError(Fault("", "orbits.range", found, expected, "exchange them"))
        _check_range(name, given)
        return given
    value = getattr(setup.scene.follower, name)
    if value == 0.0:
        found = f"found no range for {name}, which is 0 in the scene"
        cure = "give one, e.g. --range 0:2"
        raise SceneError(Fault("", "orbits.range", found, "expected LO:HI", cure))
    low, high = sorted((value * (1.0 - AROUND), value * (1.0 + AROUND)))
    least, most = NATURAL.get(name, (low, high))
    return max(low, least), min(high, most)


def _check_range(name: str, given: tuple[float, float]) -> None:
    """No constant outside what a scene may hold."""
    least = {"mass": 0.0, "stiffness": 0.0, "damping": 0.0, "restitution": 0.0}.get(name)
    bad = (least is not None and given[0] < least) or (name == "mass" and given[0] == 0.0)
    if bad or (name == "restitution" and given[1] > 1.0):
        found = f"found {given[0]!r} to {given[1]!r}"
        expected = {
            "restitution": "expected values from 0 to 1",
            "mass": "expected a positive mass",
        }.get(name, f"expected {name} of 0 or more")
        raise SceneError(Fault("", "orbits.range", found, expected, "correct the range"))


def _plane(setup: Setup, span: Span | None) -> Plane | None:
    """The plane of a two-parameter curve, if one is asked for."""
    section = setup.scene.orbits
    if section.curve is None:
        return None
    if section.curve_in == "rpm":
        found = "found rpm as the second parameter"
        cure = "the first one is rpm already"
        expected = "expected another constant of the follower"
        raise SceneError(Fault("", "orbits.curve_in", found, expected, cure))
    if span is None:
        found = "found one speed"
        cure = "give --rpm LO:HI"
        raise SceneError(Fault("", "orbits.rpm", found, "expected a range for a curve", cure))
    second = _range(setup, section.curve_in)
    value = getattr(setup.scene.follower, section.curve_in)
    if not second[0] <= value <= second[1]:
        found = f"found {section.curve_in} = {value!r} in the scene"
        expected = f"expected a value within the curve's range, {second[0]!r} to {second[1]!r}"
        raise SceneError(Fault("", "orbits.range", found, expected, "choose another range"))
    ranges = (span.low, span.high), second
    return Plane(("rpm", section.curve_in), ranges, max(2, section.rpm.num // 4))


def _write(request: Request, setup: Setup, store: RunFolder, result: OrbitsResult) -> None:
    store.write_text("branch.csv", branch_csv(result))
    store.write_text("bifurcations.csv", bifurcations_csv(result))
    if setup.scene.orbits.curve is not None:
        store.write_text("curve.csv", curve_csv(result.curves, setup.scene.orbits.curve_in))
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.orbits import draw_curves, draw_orbits

    figure = draw_orbits(result, setup.system, setup.scene.orbits.panels)
    store.write("orbits.png", partial(write_png, figure))
    if setup.scene.orbits.curve is not None:
        figure = draw_curves(result.curves, setup.scene.orbits.curve_in)
        store.write("curve.png", partial(write_png, figure))


def _verdict(result: OrbitsResult) -> int:
    """Exit code 3 and a note for what has no safe bracket, or could not be followed."""
    open_ = [b for b in result.bifurcations if b.status == UNRESOLVED]
    for b in open_:
        note(f"{UNRESOLVED}: {b.kind} of {b.label} near {b.value:.10g} has no safe bracket")
    lost = [branch for branch in result.branches if LOST in branch.ends]
    for branch in lost:
        value = branch.points[0 if branch.ends[0] == LOST else -1].value
        note(f"branch {branch.number} could not be followed beyond {value:.10g}: unresolved there")
    return NUMERICS if open_ or lost else DONE
