"""camcli.orbits: periodic orbits found, solved, followed, and every bifurcation on the way."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curves import Curve, Plane
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult, Question
from camcli.analysis.orbits.study import orbits as run
from camcli.api.result import Machine, Progress, Result, machine_of, ticks
from camcli.errors import Fault, SceneError
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.plots.event_words import event_words
from camcli.scene import Scene
from camcli.system import omega_of

DEG = 180.0 / pi
NATURAL = {"restitution": (0.0, 1.0)}
AROUND = 0.1  # relative range of a parameter where none is given
MULTIPLIERS = ("multiplier_1_re", "multiplier_1_im", "multiplier_2_re", "multiplier_2_im")
UNITS = {
    "mass": "mass_kg",
    "stiffness": "stiffness_n_per_m",
    "damping": "damping_n_s_per_m",
    "gravity": "gravity_m_per_s2",
    "preload": "preload_n",
    "restitution": "restitution",
}
BIFURCATIONS = (
    "branch", "label", "kind", "rpm", "rpm_error", "corner", "trace_left", "det_left",
    "trace_right", "det_right", "classification",
)  # fmt: skip
CURVE = ("theta_deg", "trace_left", "det_left", "trace_right", "det_right")


def orbits(scene: Scene | None = None, progress: Progress | None = None) -> Result:
    """Find periodic orbits, follow them in a parameter, locate and classify their bifurcations.

    An orbit solves the shooting equations over its impacts and carries a certificate that no other
    contact lies between them. Branches are followed by arclength; each bifurcation is the root of
    its own test function, in a bracket.

    Parameters
    ----------
    scene : Scene, optional
        The machine and the section ``orbits``: ``rpm.start`` and ``rpm.stop`` (one speed where
        they are equal), ``at``, ``label``, ``parameter`` and ``range``, ``curve`` and ``curve_in``.
        The default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.

    Returns
    -------
    Result
        Table ``branch``, a row per point (of one speed, a row per orbit): branch, label, rpm,
        stable, region, theta_deg_1 and so on (phases of the impacts), q_m and v_m_per_s at the
        strobe, multiplier_1_re to multiplier_2_im, trace, det.
        Table ``bifurcations``: branch, label, kind, rpm, rpm_error, corner, trace_left, det_left,
        trace_right, det_right, classification.
        With ``orbits.curve`` also ``curve``, a bifurcation in two parameters.

    Raises
    ------
    SceneError
        If a range does not hold the value at which orbits are looked for, or leaves what a
        follower can have.

    References
    ----------
    Continuation: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods.
    Corner impacts: G. Osorio, M. di Bernardo and S. Santini, arXiv:0711.1008. Border collisions: M.
    di Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical Systems
    (2008).
    """
    machine = machine_of(scene)
    scene, section, system = machine.scene, machine.scene.orbits, machine.system
    question = _question(machine)
    with stopwatch() as watch:
        tick = ticks(progress, "branches", question.branches + 2)
        found = run(system, machine.settings, question, tick)
    tables = {
        "branch": _branch_table(found),
        "bifurcations": _bifurcations_table(found),
    }

    def draw():
        from camcli.plots.orbits import draw_orbits

        return draw_orbits(found, system, section.panels)

    def draw_curve():
        from camcli.plots.orbits import draw_curves

        return draw_curves(found.curves, section.curve_in)

    pictures = {"orbits": draw}
    if section.curve is not None:
        tables["curve"] = _curve_table(found.curves, section.curve_in)
        pictures["curve"] = draw_curve
    notes = _notes(found)
    return Result(
        command="orbits",
        scene=scene,
        system=system,
        values=found,
        tables=tables,
        summary=_summary(found),
        pictures=pictures,
        cost=found.cost,
        seconds=watch.seconds,
        notes=tuple(notes),
        complete=not notes,
    )


def _notes(found: OrbitsResult) -> list[str]:
    """What has no safe bracket, or could not be followed."""
    notes = [
        f"{Bracket.UNRESOLVED}: {b.kind} of {b.label} near {b.value:.10g} has no safe bracket"
        for b in found.bifurcations
        if b.status == Bracket.UNRESOLVED
    ]
    for branch in found.branches:
        if Kind.LOST in branch.ends:
            value = branch.points[0 if branch.ends[0] == Kind.LOST else -1].value
            beyond = f"beyond {value:.10g}: unresolved there"
            notes.append(f"branch {branch.number} could not be followed {beyond}")
    return notes


def _question(machine: Machine) -> Question:
    section, parameter = machine.scene.orbits, machine.scene.orbits.parameter
    low, high = sorted((section.rpm.start, section.rpm.stop))
    at = section.at
    if at is None:
        inside = low <= machine.scene.run.rpm <= high
        at = machine.scene.run.rpm if inside else 0.5 * (low + high)
    span = None
    if parameter != "rpm" and section.curve is None:
        low, high = _range(machine, parameter)
    if low < high:
        span = Span(low, high, (high - low) / max(1, section.rpm.num - 1))
        _check_inside(machine, parameter if section.curve is None else "rpm", at, span)
    return Question(
        rpm=at, parameter=parameter if section.curve is None else "rpm", span=span,
        label=_label(section.label), branches=section.branches, starts=section.starts,
        curve=section.curve, plane=_plane(machine, span),
        stable={"any": None, "stable": True, "unstable": False}[section.stability],
    )  # fmt: skip


def _check_inside(machine: Machine, parameter: str, rpm: float, span: Span) -> None:
    """Orbits are found at a value that lies in the range followed."""
    value = rpm if parameter == "rpm" else getattr(machine.scene.follower, parameter)
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


def _range(machine: Machine, name: str) -> tuple[float, float]:
    """The range asked for, or one around the scene's value."""
    given = machine.scene.orbits.range
    if given is not None:
        if not given[0] < given[1]:
            found = f"found {given[0]!r} to {given[1]!r}"
            expected = "expected the lower end first, and two different ends"
            raise SceneError(Fault("", "orbits.range", found, expected, "exchange them"))
        _check_range(name, given)
        return given
    value = getattr(machine.scene.follower, name)
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


def _plane(machine: Machine, span: Span | None) -> Plane | None:
    """The plane of a two-parameter curve, if one is asked for."""
    section = machine.scene.orbits
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
    second = _range(machine, section.curve_in)
    value = getattr(machine.scene.follower, section.curve_in)
    if not second[0] <= value <= second[1]:
        found = f"found {section.curve_in} = {value!r} in the scene"
        expected = f"expected a value within the curve's range, {second[0]!r} to {second[1]!r}"
        raise SceneError(Fault("", "orbits.range", found, expected, "choose another range"))
    ranges = (span.low, span.high), second
    return Plane(("rpm", section.curve_in), ranges, max(2, section.rpm.num // 4))


def _branch_table(found: OrbitsResult) -> Table:
    """A row per point; of one speed only, a row per orbit found, branch 0."""
    other = found.question.parameter
    rows = [(0, orbit) for orbit in found.orbits] if found.question.span is None else []
    rows += [(branch.number, orbit) for branch in found.branches for orbit in branch.points]
    most = max((len(orbit.theta) for _, orbit in rows), default=1)
    thetas = [f"theta_deg_{k}" for k in range(1, max(most, 1) + 1)]
    columns = [
        "branch", "label", "rpm", "stable", "region", *thetas, "q_m", "v_m_per_s", *MULTIPLIERS,
        "trace", "det", *([UNITS[other]] if other != "rpm" else []),
    ]  # fmt: skip
    return Table.of_rows(
        columns, lambda: (_point(number, orbit, len(thetas), other) for number, orbit in rows)
    )


def _bifurcations_table(found: OrbitsResult) -> Table:
    """Another parameter than rpm appends its value and error."""
    other = found.question.parameter
    more = (UNITS[other], f"{UNITS[other]}_error") if other != "rpm" else ()
    return Table.of_rows(
        (*BIFURCATIONS, *more), lambda: (bifurcation_row(b, other) for b in found.bifurcations)
    )


def _curve_table(curves: list[Curve], second: str) -> Table:
    """A bifurcation in two parameters, a row per point."""

    def rows() -> Iterator[tuple]:
        for number, one in enumerate(curves, 1):
            for point in one.points:
                own = (point.orbit.trace, point.orbit.det)
                theta = ":".join(repr(x * DEG) for x in point.orbit.theta)
                at = (number, one.kind, one.label, one.corner, point.first, point.second)
                yield (*at, theta, *(point.left or own), *(point.right or own))

    return Table.of_rows(("curve", "kind", "label", "corner", "rpm", UNITS[second], *CURVE), rows)


def _point(number: int, orbit: PeriodicOrbit, most: int, parameter: str) -> list:
    q, w = orbit.states[0]
    thetas = [theta * DEG for theta in orbit.theta]
    return [
        number, orbit.label, orbit.rpm, int(orbit.stable), ":".join(orbit.regions),
        *thetas, *[None] * (most - len(thetas)), q, w * omega_of(orbit.rpm),
        *(part for z in orbit.multipliers for part in (z.real + 0.0, z.imag + 0.0)),
        orbit.trace, orbit.det, *([orbit.value] if parameter != "rpm" else []),
    ]  # fmt: skip


def bifurcation_row(b: Bifurcation, parameter: str) -> list:
    """A row of bifurcations.csv, with value and error of another parameter at the end."""
    error = b.error if parameter == "rpm" else 0.0
    row = [b.branch, b.label, b.kind, b.orbit.rpm, error, b.corner, *_sides(b)]
    return [*row, b.classification, *([b.value, b.error] if parameter != "rpm" else [])]


def _sides(b: Bifurcation) -> list:
    """One-sided traces and determinants; of a smooth event both sides are the same."""
    if b.kind == Kind.CORNER_IMPACT and b.left is not None and b.right is not None:
        return [b.left.trace, b.left.det, b.right.trace, b.right.det]
    own = [b.orbit.trace, b.orbit.det]
    one_sided = b.kind in (Kind.GRAZING, Kind.CORNER_IMPACT) or b.orbit.resting
    return [*own, None, None] if one_sided else [*own, *own]


def remarks(result: OrbitsResult) -> list[str]:
    """Sentences: absent labels, virtual orbits, corner impacts, what is impossible."""
    said = _absence(result)
    if result.virtual:
        said.append(
            f"{len(result.virtual)} further roots at {result.question.rpm:.10g} rpm are virtual: "
            "they penetrate the cam or would pull (run.json)"
        )
    told = set()
    for b in result.bifurcations:
        key = (b.kind, b.label, f"{b.value:.10g}")
        words = event_words(b)
        if words and key not in told:
            told.add(key)
            said.append(f"{b.kind} of {b.label} at {b.value:.10g}: {' '.join(words)}{_rests_on(b)}")
    if result.branches:
        said.append(_no_torus(result))
    if result.question.curve and not result.curves:
        said.append(f"no {result.question.curve} was located, so there is no curve to continue")
    said += [f"curve {n} ends: {c.ends[0]}; {c.ends[1]}" for n, c in enumerate(result.curves, 1)]
    return said


def _rests_on(b: Bifurcation) -> str:
    """The two inequalities that decide between the classes, with their numbers."""
    if not b.inequalities:
        return ""
    told = [
        f"{i.text} {'holds' if i.holds else 'fails'} ({i.left:.6g})" for i in b.inequalities[:2]
    ]
    return f" Rests on: {'; '.join(told)}."


def _no_torus(result: OrbitsResult) -> str:
    largest = max(orbit.det for branch in result.branches for orbit in branch.points)
    if largest < 1.0:
        return (
            f"Neimark-Sacker bifurcations are impossible: det = r^(2 impacts) exp(-b T/m) is at "
            f"most {largest:.6g} on these branches, below 1"
        )
    return (
        "det reaches 1 where nothing dissipates: there orbits are centres or saddles, none attracts"
    )


def _absence(result: OrbitsResult) -> list[str]:
    absent = result.absent
    if absent is None:
        at = result.question.rpm
        return [] if result.orbits else [f"no periodic orbit found at {at:.10g} rpm"]
    text = f"{result.question.label} was not found at {absent.rpm:.10g} rpm"
    if absent.nearest is None:
        return [f"{text}, nor at 24 speeds from {absent.low:.10g} to {absent.high:.10g} rpm"]
    value, cause = absent.nearest[0], absent.nearest[1].replace("-", " ")
    return [f"{text}; the nearest speed at which it was found is {value:.13g} rpm ({cause})"]


def _summary(result: OrbitsResult) -> dict[str, Any]:
    """The result of run.json."""
    return {
        "words": remarks(result),
        "orbits": [_orbit(orbit) for orbit in result.orbits],
        "virtual": [_orbit(orbit) for orbit in result.virtual],
        "branches": [_branch(branch) for branch in result.branches],
        "bifurcations": [_event(b) for b in result.bifurcations],
        "curves": [
            {"kind": c.kind, "label": c.label, "corner": c.corner, "points": len(c.points),
             "ends": list(c.ends)}
            for c in result.curves
        ],
    }  # fmt: skip


def _orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    return {
        "label": orbit.label, "rpm": orbit.rpm, "stable": orbit.stable, "verdict": orbit.verdict,
        "theta_deg": [theta * DEG for theta in orbit.theta], "regions": list(orbit.regions),
        "multipliers": [[z.real, z.imag] for z in orbit.multipliers],
        "trace": orbit.trace, "det": orbit.det,
    }  # fmt: skip


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "branch": branch.number, "origin": branch.origin, "labels": branch.labels,
        "from": branch.points[0].value, "to": branch.points[-1].value,
        "points": len(branch.points), "ends": list(branch.ends),
    }  # fmt: skip


def _event(b: Bifurcation) -> dict[str, Any]:
    return {
        "branch": b.branch, "label": b.label, "kind": b.kind, "value": b.value, "error": b.error,
        "status": b.status, "corner": b.corner, "classification": b.classification,
        "continues_as_branch": b.continues, "prediction_agrees": b.agrees, "words": event_words(b),
        "inequalities": [
            {"text": i.text, "left": i.left, "right": i.right, "holds": i.holds}
            for i in b.inequalities
        ],
    }  # fmt: skip
