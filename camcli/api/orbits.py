"""camcli.orbits: periodic orbits found, solved, followed, and every bifurcation on the way."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import degrees
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.one_period import periods_of
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Bifurcation, OrbitsResult, Question
from camcli.analysis.orbits.study import orbits as run
from camcli.analysis.sweep import Setup, Sweep, rpm_grid, sweep
from camcli.api.command import Command, Drawing, Size
from camcli.api.machine import Machine, machine_of, with_arguments, with_values
from camcli.api.orbit_tables import (
    BRANCHES,
    CURVE,
    EVENTS,
    Keys,
    bifurcations_table,
    branch_table,
    curve_table,
)
from camcli.api.result import Progress, Result, budget_of, drawn_by, ticks
from camcli.api.rows import (
    IMPACTS,
    STROBE,
    blocks,
)
from camcli.errors import Fault, SceneError
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.piece_faults import gather, gathering, piece
from camcli.quantities import FOLLOWER, PARAMETERS
from camcli.scene import Axis, Orbits, Scene
from camcli.system import omega_of
from camcli.words import plan
from camcli.words.border_collision import inequality_record
from camcli.words.events import event_words
from camcli.words.orbits import VERDICTS, end_words, remarks
from camcli.words.orbits import notes as notes_of
from camcli.words.statuses import trouble

if TYPE_CHECKING:
    from camcli.analysis.orbits.proofs import Proof, Proofs, Range

AROUND = 0.1  # relative range of a parameter where none is given


def orbits(
    scene: Scene | None = None, progress: Progress | None = None, *, prove: bool = False
) -> Result:
    """Find periodic orbits, follow them in a parameter, locate and classify their bifurcations.

    An orbit solves the shooting equations over its impacts and carries a certificate that no other
    contact lies between them. Branches are followed by arclength; each bifurcation is the root of
    its own test function, in a bracket.

    Parameters
    ----------
    scene : Scene, optional
        The machine and the section ``orbits``: ``rpm.start`` and ``rpm.stop`` (one speed where
        they are equal), ``at``, ``label``, ``parameter`` and ``range``, ``curve``, ``curve_in`` and
        ``curve_range``; or ``vary`` (``key``, ``start``, ``stop``, ``num``) for the speed or a
        constant of the follower instead of ``parameter`` and ``range``, and a second one for a
        curve. The default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    prove : bool
        ``orbits.prove``: prove what was found, in ball arithmetic, for the scene's numbers as they
        are: of each orbit that exactly one lies in a box, that it is a motion, that its multipliers
        lie inside or outside the unit circle; of each event its parameter in an enclosure, and its
        crossing condition; of branches that they go on from event to event. The flank circle of a
        cam of arcs is then the one that closes, of the radius base_radius + flank_center;
        ``summary["proofs"]["flank_excess_m"]`` is how much larger it is than flank_radius.

    Returns
    -------
    Result
        Tables ``branch`` and ``bifurcations``, with ``curve`` ``curve``, and with
        ``orbits.simulated`` ``impacts`` and ``strobe``; their columns are in the guide
        (`cam guide orbits`).

        A number that ``vary`` names is the first column, under its key. With ``prove`` ``summary``
        has the boxes, the step that failed, and holds_for: last-digit where an orbit is proved for
        every speed that rounds to its own, else exact-data.

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
    machine = machine_of(with_arguments(scene, "orbits", prove=prove))
    scene, system = machine.scene, machine.system
    simulated = None
    asked = _spelt_out(scene)
    section = asked.orbits
    question = _question(asked)
    keys = {_constant(axis): axis.key for axis in section.vary}
    with stopwatch() as watch, gathering() as faults:
        tick = ticks(progress, "branches", question.branches + 2)
        with budget_of(scene, progress) as budget:
            found = run(system, machine.settings, question, tick)
            if section.prove:
                from camcli.analysis.orbits.proofs import prove as proofs_of

                found = replace(found, proofs=proofs_of(system, found))
        if section.simulated and question.span is not None:
            simulated = _simulated(machine, found.question, section.simulated)
            gather(simulated.faults)
        summary = piece("the summary", lambda: _summary(found), {})
        notes = piece("the notes", lambda: notes_of(found), []) + trouble(budget.status)
        tables = _tables(found, simulated, section, keys)
        single = [] if found.branches else found.orbits
        periods = piece("the orbits in time", lambda: periods_of(single, system), [])

    pictures = {"orbits": drawn_by("orbits.draw_orbits", found, system, simulated, periods)}
    if section.curve is not None:
        pictures["curve"] = drawn_by("orbits.draw_curves", found.curves, section.curve_in)
    return Result(
        command="orbits",
        scene=scene,
        system=system,
        values=found,
        tables=tables,
        summary={"status": budget.status.text, **summary},
        pictures=pictures,
        cost=found.cost + (simulated.cost if simulated else Cost()),
        seconds=watch.seconds,
        notes=tuple(notes),
        complete=not notes,
        faults=tuple(faults),
    )


def _tables(
    found: OrbitsResult, simulated: Sweep | None, section: Orbits, keys: Keys
) -> dict[str, Table]:
    """The tables by name; one that cannot be made is left out."""
    makes = {
        "branch": partial(branch_table, found, keys),
        "bifurcations": partial(bifurcations_table, found, keys),
    }
    if simulated is not None:
        key = keys.get(simulated.key, PARAMETERS[simulated.key].column)
        for head in (IMPACTS, STROBE):
            rows = partial(blocks, simulated, head.name)
            makes[head.name] = partial(Table, head.names(key), rows)
    if section.curve is not None:
        makes["curve"] = partial(curve_table, found.curves, section, keys)
    made = {name: piece(f"{name}.csv", make) for name, make in makes.items()}
    return {name: table for name, table in made.items() if table is not None}


def _spelt_out(scene: Scene) -> Scene:
    """The scene with `orbits.vary` written out as the keys that `_question` reads.

    The first axis is what varies along a branch: parameter, range and rpm. The second axis is the
    second parameter of a curve: curve_in and curve_range. Where a curve is asked for with a single
    axis, and that axis is not the speed, it is the second parameter: the branches vary the speed.
    Raises SceneError for a number that a branch cannot vary.
    """
    section = scene.orbits
    axes = list(section.vary)
    for axis in axes:
        if _constant(axis) not in PARAMETERS:
            expected = f"rpm or a constant of the follower: {', '.join(FOLLOWER)}"
            cure = "cam sweep and cam classify vary any number"
            raise _refusal("vary", f"found {axis.key}", expected, cure)
    if section.curve is None and len(axes) > 1:
        found = f"found {axes[0].key} and {axes[1].key}"
        cure = "leave one out, or add --curve KIND"
        raise _refusal("vary", found, "one number along a branch", cure)
    changed: dict[str, Any] = {}
    if section.curve is not None and axes and (len(axes) > 1 or _constant(axes[0]) != "rpm"):
        second = axes.pop()
        changed["curve_in"] = _constant(second)
        changed["curve_range"] = tuple(sorted((second.start, second.stop)))
    for axis in axes:
        changed["parameter"] = _constant(axis)
        changed["range"] = tuple(sorted((axis.start, axis.stop)))
        if axis.path == "run.rpm":
            low, high = changed["range"]
        else:  # the orbits are looked for at the scene's speed
            low = high = scene.run.rpm
        ends = {"start": low, "stop": high, "num": axis.num}
        changed["rpm"] = section.rpm.model_copy(update=ends)
    return with_values(scene, "orbits", **changed)


def _constant(axis: Axis) -> str:
    """What an axis varies, as `parameter` names it."""
    return "rpm" if axis.path == "run.rpm" else axis.path.removeprefix("follower.")


def _question(scene: Scene) -> Question:
    """What the section `orbits` asks; raises SceneError where it contradicts itself."""
    section = scene.orbits
    parameter = section.parameter
    curve = section.curve
    low, high = sorted((section.rpm.start, section.rpm.stop))
    at = section.at
    if at is None:
        at = scene.run.rpm if low <= scene.run.rpm <= high else 0.5 * (low + high)
    label = None
    if section.label is not None:
        try:
            label = Label.parse(section.label)
        except ValueError as error:
            expected = "P(m;s1:...:sm) with one count or inf for each of the m turns"
            raise _refusal("label", str(error), expected, "quote it: 'P(3;3:3:2)'") from None
    if parameter == "rpm" and low < high and not low <= at <= high:
        found = f"found rpm = {at!r} where orbits are looked for"
        expected = f"a value from {low!r} to {high!r}, the range followed"
        raise _refusal("at", found, expected, "choose another range, or --at")
    if parameter != "rpm":
        low, high = _range(scene, parameter, "range")
    plane = None
    if curve is not None:
        second = section.curve_in
        if second in (parameter, "rpm"):
            found = f"found {second} as the second parameter"
            cure = f"another one than {parameter}"
            raise _refusal("curve_in", found, "a constant of the follower", cure)
        if low == high:
            raise _refusal("rpm", "found one speed", "a range for a curve", "give --rpm LO:HI")
        # `range` is that of the second parameter where the first one is the speed
        key = "range" if section.curve_range is None and parameter == "rpm" else "curve_range"
        ranges = (low, high), _range(scene, second, key)
        num = section.vary[1].num if len(section.vary) > 1 else section.rpm.num
        plane = Plane((parameter, second), ranges, max(2, num // 4))
    return Question(
        rpm=at,
        parameter=parameter,
        span=Span(low, high, (high - low) / max(1, section.rpm.num - 1)) if low < high else None,
        label=label,
        branches=section.branches,
        starts=section.starts,
        stable={"any": None, "stable": True, "unstable": False}[section.stability],
        curve=curve,
        plane=plane,
    )


def _simulated(machine: Machine, question: Question, count: int) -> Sweep:
    """Motions from the scene's start over the range of the parameter."""
    span = question.span
    assert span is not None
    system = machine.system
    key = question.parameter

    def setup(value: float) -> Setup:
        return system.with_follower(**{key: value}), question.rpm, machine.settings

    values = rpm_grid(span.low, span.high, count)
    if key == "rpm":
        return sweep(system, values, machine.settings, key=key)
    return sweep(system, values, machine.settings, key=key, setup=setup)


def _refusal(key: str, found: str, expected: str, cure: str) -> SceneError:
    return SceneError(Fault("", f"orbits.{key}", found, f"expected {expected}", cure))


def _range(scene: Scene, name: str, key: str) -> tuple[float, float]:
    """The range of a constant that orbits.key asks for, or one around the scene's value.

    Raises SceneError for a range without this value, and for constants that no follower has.
    """
    value = getattr(scene.follower, name)
    given = getattr(scene.orbits, key)
    if given is None:
        if value == 0.0:
            found = f"found no range for {name}, which is 0"
            raise _refusal(key, found, "LO:HI", "give one, e.g. --range 0:2")
        low, high = sorted((value * (1.0 - AROUND), value * (1.0 + AROUND)))
        return low, min(high, 1.0) if name == "restitution" else high
    low, high = given
    found = f"found {low!r} to {high!r}"
    if not low < high:
        raise _refusal(key, found, "the lower end first, two different ends", "exchange them")
    for end in given:
        try:
            type(scene.follower).model_validate({**dict(scene.follower), name: end})
        except ValidationError as error:
            expected = f"{name} as in a scene: {error.errors()[0]['msg']}"
            raise _refusal(key, found, expected, "correct the range") from None
    if not low <= value <= high:
        expected = f"a range that holds {name} = {value!r} of the scene"
        raise _refusal(key, found, expected, "choose another range")
    return given


def _summary(result: OrbitsResult) -> dict[str, Any]:
    """The result of run.json."""
    proofs = result.proofs
    return {
        "words": remarks(result),
        "orbits": [_orbit(orbit) for orbit in result.orbits],
        "continua": [
            {"label": c.label, "from_deg": degrees(c.start), "to_deg": degrees(c.end)}
            for c in result.continua
        ],
        "virtual": [_orbit(orbit) for orbit in result.virtual],
        "branches": [
            {"branch": branch.number, "origin": branch.origin, "labels": branch.labels,
             "from": branch.points[0].value, "to": branch.points[-1].value,
             "points": len(branch.points), "ends": branch.ends}
            for branch in result.branches
        ],
        "bifurcations": [_event(b) for b in result.bifurcations],
        "curves": [
            {"kind": c.kind, "label": c.label, "corner": c.corner, "points": len(c.points),
             "ends": [end_words(end) for end in c.ends], "limits": c.limits}
            for c in result.curves
        ],
        **({} if proofs is None else {"proofs": _proofs(proofs)}),
    }  # fmt: skip


def _proofs(proofs: Proofs) -> dict[str, Any]:
    """box: phase (rad) and outgoing rate (m/rad) of the impacts, or the position (m) in flight."""
    from camcli.words.proofs import FAILED, LEFT

    def proof(p: Proof) -> dict[str, Any]:
        return {
            "proved": p.proved, "holds_for": p.holds_for if p.proved else None,
            "refuted": p.refuted, "failed_step": None if p.step is None else FAILED[p.step],
            "value": p.value or None, "box": p.box,
            "signs": [(LEFT[rule], sign) for rule, sign in p.signs],
        }  # fmt: skip

    def range_(one: Range) -> dict[str, Any]:
        step = one.failed_step
        return {**vars(one), "failed_step": None if step is None else FAILED[step]}

    return {
        "orbits": [proof(p) for p in proofs.orbits],
        "bifurcations": [proof(p) for p in proofs.events],
        "ranges": [range_(one) for one in proofs.ranges],
        "flank_excess_m": proofs.flank_excess,
    }


def _orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    return {
        "label": orbit.label, "rpm": orbit.rpm, "stable": orbit.stable,
        "verdict": VERDICTS[orbit.verdict],
        "theta_deg": [degrees(theta) for theta in orbit.theta], "regions": orbit.regions,
        "u_minus_m_per_s": [u * omega_of(orbit.rpm) for u in orbit.rates],
        "multipliers": orbit.multipliers,
        "trace": orbit.trace, "det": orbit.det,
    }  # fmt: skip


def _event(b: Bifurcation) -> dict[str, Any]:
    rests_on = () if b.corner_impact is None else b.corner_impact.collision.inequalities
    return {
        "branch": b.branch, "label": b.label, "kind": b.kind, "value": b.value, "error": b.error,
        "status": b.status, "corner": b.corner, "classification": b.classification,
        "continues_as_branch": b.continues, "prediction_agrees": b.agrees, "words": event_words(b),
        "inequalities": [inequality_record(i) for i in rests_on],
    }  # fmt: skip


# --- the command


def _size(scene: Scene) -> Size:
    n = scene.orbits.starts + 1
    return Size(f"{n} runs", n, n, 0.0, n, 300.0 * n, 100.0 * n, 0.0)


COMMAND = Command(
    run=orbits,
    tables=(BRANCHES, EVENTS, CURVE, IMPACTS._replace(more={}), STROBE._replace(more={})),
    files=("orbits.png", "curve.png"),
    size=_size,
    drawing=lambda scene: Drawing(400e3, 120e6, 5.0),
    sample=None,
    not_foreseen=plan.orbits,
    has_budget=True,
)  # fmt: skip
