"""camcli.orbits: periodic orbits found, solved, followed, and every bifurcation on the way."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import degrees
from typing import TYPE_CHECKING, Any

from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import BudgetSpentError, Cost, Setup
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.one_period import periods_of
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import Shooter, with_machine
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsQuestion, OrbitsResult
from camcli.analysis.orbits.study import orbits as run
from camcli.analysis.sweep import Sweep, sweep
from camcli.api.command import Command, Drawing, Size
from camcli.api.machine import Machine, machine_of, with_arguments
from camcli.api.orbit_question import question_of, varied_by, with_families
from camcli.api.orbit_tables import (
    BRANCHES,
    CHAOS,
    CODIM2,
    CURVE,
    EVENTS,
    Keys,
    bifurcations_table,
    branch_table,
    chaos_table,
    codim2_table,
    curve_table,
)
from camcli.api.proof_files import proof_files
from camcli.api.result import Progress, Result, budget_of, drawn_by, ticks
from camcli.api.rows import (
    IMPACTS,
    STROBE,
    blocks,
    form,
)
from camcli.errors import Fault, SceneError, plural
from camcli.kernel.backend import stopwatch
from camcli.output.tables import SharedRows, Table
from camcli.piece_faults import gather, gathering, piece
from camcli.quantities import PARAMETERS
from camcli.scene import Scene
from camcli.system import System, omega_of
from camcli.words import plan
from camcli.words.border_collision import inequality_record
from camcli.words.events import event_words
from camcli.words.orbits import VERDICTS, end_words, points_at_ends, remarks
from camcli.words.orbits import notes as notes_of
from camcli.words.statuses import trouble

if TYPE_CHECKING:
    from camcli.analysis.chaos.section import Chaos, ChaosView
    from camcli.analysis.orbits.all_orbits import AllOrbits
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.curve_proofs import CurveRange
    from camcli.analysis.orbits.curves import Curve
    from camcli.analysis.orbits.proofs import Proof, Proofs
    from camcli.analysis.orbits.starts import Starts
    from camcli.plots.picture import Picture


def orbits(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    at: float | None = None,
    all: tuple[int, int] | None = None,
    prove: bool = False,
    checker: bool = False,
    chaos: bool = False,
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
        ``curve_range``; or ``vary`` (``key``, ``start``, ``stop``, ``num``) for the speed, a
        constant of the follower or a number of the cam instead of ``parameter`` and ``range``, and
        a second one for a curve. The default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    at : float
        ``orbits.at``: the speed (rpm) at which orbits are looked for. Branches go on from there;
        `all` and `chaos` are about this speed alone. If left out, ``run.rpm``.
    all : (impacts, turns)
        ``orbits.all``: all orbits at one speed with at most so many impacts in at most so many
        turns, each proved, and proved to be all that do not rest.
    prove : bool
        ``orbits.prove``: prove what was found, in ball arithmetic, for the scene's numbers as they
        are: of each orbit that exactly one lies in a box, that it is a motion, that its multipliers
        lie inside or outside the unit circle; of each event its parameter in an enclosure, and its
        crossing condition; of branches that they go on from event to event. The flank circle of a
        cam of arcs is then the one that closes, of the radius base_radius + flank_center;
        ``summary["proofs"]["flank_excess_m"]`` is how much larger it is than flank_radius. `save`
        then writes ``proof.json`` too, the certificate of each proof.
    checker : bool
        ``orbits.checker``: `save` also writes ``check.py``, which confirms or refuses each
        statement of ``proof.json`` by itself, without camcli.
    chaos : bool
        ``orbits.chaos``: prove chaos at one speed. ``values.chaos`` has boxes of impacts, and which
        of them the impacts after those of a box cover; ``summary["chaos"]`` has the lower bound of
        the topological entropy. It does not say that the attractor is chaotic.

    Returns
    -------
    Result
        Tables ``branch`` and ``bifurcations``, with ``curve`` ``curve`` and ``codim2``, with
        ``chaos`` ``chaos``, and with ``orbits.simulated`` ``impacts`` and ``strobe``; their columns
        are in the guide (`cam guide orbits`).

        A number that ``vary`` names is the first column, under its key. With ``prove`` ``summary``
        has the boxes, the step that failed, and holds_for: last-digit where an orbit is proved for
        every speed that rounds to its own, else exact-data.

    Raises
    ------
    SceneError
        If a range does not hold the value at which orbits are looked for, or leaves what a
        follower can have.

    Examples
    --------
    >>> import camcli
    >>> result = camcli.orbits(at=745.0, chaos=True)
    >>> result.summary["chaos"]["proved"]
    True
    >>> found = camcli.orbits(at=700.0, all=(1, 1))
    >>> [orbit["label"] for orbit in found.summary["orbits"]]
    ['P(1;1)', 'P(1;1)']

    References
    ----------
    Continuation: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods.
    Corner impacts: G. Osorio, M. di Bernardo and S. Santini, arXiv:0711.1008. Border collisions: M.
    di Bernardo, C. J. Budd, A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical Systems
    (2008).
    """
    given = with_arguments(
        scene, "orbits", at=at, all=_up_to(all), prove=prove, checker=checker, chaos=chaos
    )
    machine = machine_of(given)
    scene = machine.scene
    section = scene.orbits
    varied = varied_by(scene)
    question = question_of(scene, varied)
    system = with_families(machine, varied)
    keys = {number.name: number.key for number in varied if number.key}
    simulated: Sweep | None = None
    certificate: dict[str, Any] | None = None
    view: ChaosView | None = None
    with stopwatch() as watch, gathering() as faults:
        on_step = ticks(progress, *_steps(question))
        with budget_of(scene, progress) as budget:
            found = run(system, machine.settings, question, on_step)
            if question.plane is not None:
                found = replace(found, codim2=_points(system, found, question.plane, section.prove))
            if section.prove or section.all is not None:
                found, certificate = _proved(scene, system, found)
            if section.chaos:
                found, certificate = _with_chaos(machine, found, certificate)
                with suppress(BudgetSpentError):  # then there is no picture
                    view = piece("the impacts of chaos.png", lambda: _view(machine, found), None)
        if section.simulated and question.span is not None:
            simulated = _simulated(replace(machine, system=system), found, section.simulated)
            gather(simulated.faults)
        summary = piece("the summary", lambda: _summary(found, scene.cam.kind), {})
        notes = piece("the notes", lambda: notes_of(found), []) + trouble(budget.status)
        tables = _tables(system, found, simulated, keys)
        pictures = _pictures(system, found, simulated, view)
    return Result(
        command="orbits",
        scene=scene,
        system=system,
        values=found,
        tables=tables,
        summary={"status": budget.status.text, **summary},
        pictures=pictures,
        files=proof_files(certificate, section.checker),
        cost=found.cost + (simulated.cost if simulated else Cost()),
        seconds=watch.seconds,
        notes=tuple(notes),
        complete=not notes,
        faults=tuple(faults),
    )


def _pictures(
    system: System, found: OrbitsResult, simulated: Sweep | None, view: ChaosView | None
) -> dict[str, Callable[[], Picture]]:
    """Functions that draw the pictures, by name.

    simulated: motions over the range of the parameter; view: of chaos; None: not asked for.
    """
    of_one_speed = [] if found.branches else found.orbits
    periods = piece("the orbits in time", lambda: periods_of(of_one_speed, system), [])
    pictures = {"orbits": drawn_by("orbits.draw_orbits", found, system, simulated, periods)}
    if view is not None:
        pictures["chaos"] = drawn_by("chaos.draw_chaos", found.chaos, view)
    plane = found.question.plane
    if plane is not None:
        ranges = () if found.proofs is None else found.proofs.curve_ranges
        pictures["curve"] = drawn_by(
            "orbits.draw_curves", found.curves, plane.names, found.codim2, ranges
        )
    if found.every is not None and any(cover.drawn for cover in found.every.covers):
        from camcli.words.all_orbits import cover_heading  # it imports ball arithmetic

        heading = cover_heading(found, found.every)
        pictures["cover"] = drawn_by("cover.draw_cover", found.every, system, *heading)
    return pictures


def _up_to(given: tuple[int, int] | None) -> dict[str, int] | None:
    """The argument `all` as the key orbits.all takes it; raises SceneError for no pair."""
    if given is None:
        return None
    try:
        impacts, turns = given
    except (TypeError, ValueError):
        expected = "expected two numbers (impacts, turns)"
        fault = Fault("", "orbits.all", f"found {given!r}", expected, "write e.g. all=(3, 2)")
        raise SceneError(fault) from None
    return {"impacts": impacts, "turns": turns}


def _steps(question: OrbitsQuestion) -> tuple[str, int]:
    """What the progress counts, and how many there may be.

    How many orbits are found is not known before, so this is a guess: a branch through each of two,
    and then as many as are wanted from their events.
    """
    if question.all_of is None:
        through_orbits = 2
        return "branches", through_orbits + question.branches
    impacts, turns = question.all_of
    return "covers", impacts * turns


def _points(system: System, found: OrbitsResult, plane: Plane, proved: bool) -> list[CodimTwo]:
    """The points of codimension two on the curves; a budget that is spent ends the list.

    proved: each with its proof.
    """
    from camcli.analysis.orbits.codim2 import PointProof, add_points, prove  # balls: imported here
    from camcli.exact.shooting import ProofStep

    points: list[CodimTwo] = []
    with suppress(BudgetSpentError):
        add_points(system, found.curves, plane, points)
    if not proved:
        return points
    with_proofs = []
    for point in points:
        name = f"the proof of the {point.kind} at {point.first!r}, {point.second!r}"
        proof = piece(name, partial(prove, point), PointProof(ProofStep.FAULT))
        with_proofs.append(replace(point, proof=proof))
    return with_proofs


def _proved(
    scene: Scene, system: System, found: OrbitsResult
) -> tuple[OrbitsResult, dict[str, Any] | None]:
    """The study with its proofs, and the content of proof.json; None where that fails."""
    from camcli.analysis.orbits.certificate import certificate
    from camcli.analysis.orbits.proofs import prove
    from camcli.cams.formula import formula_of
    from camcli.words.proofs import named

    proofs = prove(system, found)
    with_starts = []
    for orbit, proof in zip(found.orbits, proofs.orbits, strict=True):
        with_starts.append(replace(proof, starts=_starts(scene, system, orbit, proof)))
    proofs = replace(proofs, orbits=with_starts, curve_ranges=_curve_ranges(system, found))
    found = replace(found, proofs=proofs)

    def certified() -> dict[str, Any]:
        """The content of proof.json."""
        formula = formula_of(system.shape, system.follower.seat_restitution)
        return certificate(found, formula, scene.run.strobe_deg, named)

    content = piece("proof.json", certified, None)
    if scene.orbits.all is not None and content is not None and not content["statements"]:
        content = None  # no file: there would be nothing in it to check
    return replace(found, proofs=proofs.without_evidence()), content


def _curve_ranges(system: System, found: OrbitsResult) -> list[CurveRange]:
    """The parts of all curves between their points, proved or not."""
    from camcli.analysis.orbits.curve_proofs import prove_curve

    ranges: list[CurveRange] = []
    plane = found.question.plane
    if plane is None:
        return ranges
    for number, curve in enumerate(found.curves, 1):
        proof = partial(prove_curve, system, curve, number, plane)
        ranges += piece(f"the proof that curve {number} has no gap", proof, [])
    return ranges


def _starts(scene: Scene, system: System, orbit: PeriodicOrbit, proof: Proof) -> Starts | None:
    """How many of the starts of `cam basins` certainly tend to an orbit; None where not shown."""
    from camcli.analysis.orbits.proofs import DIGITS
    from camcli.analysis.orbits.starts import starts
    from camcli.cams.balls import precision

    evidence = proof.evidence
    section = scene.basins
    if not proof.axes or evidence is None:
        return None

    def counted() -> Starts | None:
        """The area and the share, in the digits of the proof."""
        with precision(DIGITS[0]):
            return starts(evidence, proof.axes, orbit.rpm, system.strobe, section.q, section.v)

    return piece(f"the area of starts that tend to {orbit.label}", counted, None)


def _with_chaos(
    machine: Machine, found: OrbitsResult, certificate: dict[str, Any] | None
) -> tuple[OrbitsResult, dict[str, Any] | None]:
    """The study with chaos proved or not, and the content of proof.json with it."""
    from camcli.analysis.chaos.section import Chaos
    from camcli.analysis.chaos.study import chaos_at
    from camcli.analysis.orbits.certificate import FORMAT
    from camcli.cams.formula import formula_of
    from camcli.exact.shooting import ProofStep

    system = machine.system
    rpm = found.question.rpm
    cam = formula_of(system.shape, system.follower.seat_restitution)
    chaos, statement = piece(
        "the proof of chaos",
        lambda: chaos_at(system, machine.settings, found.orbits, rpm, cam is not None),
        (Chaos(rpm, step=ProofStep.FAULT), None),
    )
    found = replace(found, chaos=chaos)
    if statement is None:
        return found, certificate
    if certificate is None:
        certificate = {"format": FORMAT, "cam": cam, "statements": [], "uncovered": []}
    return found, {**certificate, "statements": [*certificate["statements"], statement]}


def _view(machine: Machine, found: OrbitsResult) -> ChaosView | None:
    """What the picture of chaos shows beside the boxes."""
    from camcli.analysis.chaos.study import view_of

    assert found.chaos is not None
    return view_of(machine.system, machine.settings, found.chaos)


def _tables(
    system: System, result: OrbitsResult, simulated: Sweep | None, keys: Keys
) -> dict[str, Table]:
    """The tables by name; one that an unforeseen exception has cost is left out."""
    makers = {
        "branch": partial(branch_table, result, keys),
        "bifurcations": partial(bifurcations_table, result, keys),
    }
    if simulated is not None:
        key = keys.get(simulated.key) or PARAMETERS[simulated.key].column
        rows = SharedRows(partial(blocks, simulated), partial(form, simulated))
        for head in (IMPACTS, STROBE):
            makers[head.name] = partial(rows.table, head.name, head.names(key))
    plane = result.question.plane
    if plane is not None:
        ranges = None if result.proofs is None else result.proofs.curve_ranges
        makers["curve"] = partial(curve_table, result.curves, plane, keys, result.proofs, ranges)
        proved = result.proofs is not None
        makers["codim2"] = partial(codim2_table, result.codim2, plane, keys, proved)
    if result.chaos is not None:
        makers["chaos"] = partial(chaos_table, result.chaos, system.region_names)
    tables = {}
    for name, make in makers.items():
        table = piece(f"{name}.csv", make)
        if table is not None:
            tables[name] = table
    return tables


def _simulated(machine: Machine, found: OrbitsResult, count: int) -> Sweep:
    """Motions from the scene's start at `count` values of the parameter.

    The values lie in the range that was followed, as far as there are machines.
    """
    question = found.question
    system = machine.system
    parameter = question.parameter
    low, high = found.reach
    values = rpm_grid(low, high, count)
    if parameter == "rpm":
        return sweep(system, values, machine.settings, key=parameter)
    shooter = Shooter(system, question.rpm, parameter)

    def setup(value: float) -> Setup:
        """(system, rpm, settings) with the parameter at a value."""
        changed_system, rpm = with_machine(system, shooter.at(value))
        return changed_system, rpm, machine.settings

    return sweep(system, values, machine.settings, key=parameter, setup=setup)


def _summary(result: OrbitsResult, kind: str) -> dict[str, Any]:
    """What run.json keeps: sentences, orbits, branches, bifurcations, curves and proofs.

    kind: of the cam.
    """
    summary: dict[str, Any] = {
        "words": remarks(result, kind=kind),
        "orbits": [_orbit(orbit) for orbit in result.orbits],
        "continua": [
            {
                "label": continuum.label,
                "from_deg": degrees(continuum.start),
                "to_deg": degrees(continuum.end),
            }
            for continuum in result.continua
        ],
        "virtual": [_orbit(orbit) for orbit in result.virtual],
    }
    if result.limits:
        summary["limits"] = [vars(limit) for limit in result.limits]
    summary["branches"] = [_branch(branch, result.bifurcations) for branch in result.branches]
    summary["bifurcations"] = [_event(event) for event in result.bifurcations]
    kinds_at_ends = points_at_ends(result.curves, result.codim2)
    summary["curves"] = [
        _curve(curve, kinds) for curve, kinds in zip(result.curves, kinds_at_ends, strict=True)
    ]
    if result.question.plane is not None:
        summary["codim2"] = [_point(point) for point in result.codim2]
    if result.proofs is not None:
        summary["proofs"] = _proofs(result.proofs)
    if result.every is not None:
        summary["all"] = _all(result.every)
    if result.chaos is not None:
        summary["chaos"] = _chaos(result.chaos)
    return summary


def _branch(branch: Branch, bifurcations: list[Bifurcation]) -> dict[str, Any]:
    """The entry of run.json for a branch; bifurcations: of the whole study."""
    return {
        "branch": branch.number,
        "origin": branch.origin,
        "labels": branch.labels,
        "from": branch.points[0].value,
        "to": branch.points[-1].value,
        "points": len(branch.points),
        "ends": branch.ends,
        "stable_ranges": branch.stable_ranges(bifurcations),
        "turning_points": branch.turning_points,
    }


def _curve(curve: Curve, kinds_at_ends: tuple[str, str]) -> dict[str, Any]:
    """The entry of run.json for a curve.

    kinds_at_ends: of the points of codimension two at its first and its last end; empty: none.
    """
    return {
        "kind": curve.kind,
        "label": curve.label,
        "corner": curve.corner,
        "points": len(curve.points),
        "ends": [end_words(end) for end in curve.ends],
        "limits": curve.limits,
        "end_points": kinds_at_ends,
    }


def _all(found: AllOrbits) -> dict[str, Any]:
    """The entry of run.json for all orbits up to a size: boxes of each cover, and why empty."""
    from camcli.words.all_orbits import failure_words

    return {
        "impacts": found.impacts,
        "turns": found.turns,
        "failed": None if found.failure is None else failure_words(found.failure),
        "covers": [
            {
                "impacts": cover.impacts,
                "turns": cover.turns,
                "boxes": cover.boxes,
                "around_orbits": len(cover.known),
                "empty": cover.counts,
            }
            for cover in found.covers
        ],
    }


def _chaos(chaos: Chaos) -> dict[str, Any]:
    """The entry of run.json for chaos: the bound of its entropy, or the step that failed."""
    from camcli.words.proofs import FAILED

    return {
        "proved": chaos.proved,
        "failed_step": None if chaos.step is None else FAILED[chaos.step],
        "about": chaos.label,
        "boxes": len(chaos.boxes),
        "coverings": [[box + 1, covered + 1] for box, covered in chaos.coverings],
        "growth_per_impact": chaos.growth if chaos.proved else None,
        "entropy_per_impact": chaos.per_impact if chaos.proved else None,
        "entropy_per_turn": chaos.per_turn if chaos.proved else None,
        "entropy_per_second": chaos.per_second if chaos.proved else None,
        "flank_excess_m": chaos.flank_excess,
    }


def _point(point: CodimTwo) -> dict[str, Any]:
    """The entry of run.json for a point of codimension two, with its proof where there is one."""
    from camcli.words.codim2 import UNFOLDS  # it imports ball arithmetic
    from camcli.words.proofs import FAILED

    entry = {
        "kind": point.kind,
        "label": point.label,
        "first": point.first,
        "second": point.second,
        "corners": point.corners,
        "curves": point.curves,
        "unfolds": UNFOLDS[point.kind],
    }
    if point.proof is not None:
        step = point.proof.step
        entry["proved"] = step is None
        entry["failed_step"] = None if step is None else FAILED[step]
    return entry


def _proofs(proofs: Proofs) -> dict[str, Any]:
    """The entry of run.json for the proofs, see `_proof`."""
    from camcli.words.proofs import range_record

    return {
        "orbits": [_proof(proof) for proof in proofs.orbits],
        "bifurcations": [_proof(proof) for proof in proofs.events],
        "ranges": [range_record(part) for part in proofs.ranges],
        "curves": [[_proof(proof) for proof in of_curve] for of_curve in proofs.curves],
        "curve_ranges": [range_record(part) for part in proofs.curve_ranges],
        "flank_excess_m": proofs.flank_excess,
    }


def _proof(proof: Proof) -> dict[str, Any]:
    """The entry of run.json for a proof: whether it holds, for which machines, and what failed.

    box: phase (rad) and outgoing rate (m/rad) of the impacts, or the position (m) in flight.
    ellipses: of a stable orbit, for each impact the entries a, b, c, d of the axes [[a, b], [c, d]]
    of an ellipse about it (rad, m/rad). area_m2_per_s, share_of_window: least area of the states at
    the strobe that come from these ellipses, and its share of the window of starts of `cam basins`.
    """
    from camcli.words.proofs import FAILED, LEFT

    starts = proof.starts
    return {
        "proved": proof.proved,
        "holds_for": proof.holds_for if proof.proved else None,
        "refuted": proof.refuted,
        "failed_step": None if proof.step is None else FAILED[proof.step],
        "value": proof.value or None,
        "box": proof.box,
        "ellipses": proof.axes or None,
        "area_m2_per_s": None if starts is None else starts.area,
        "share_of_window": None if starts is None else starts.share,
        "signs": [(LEFT[rule], sign) for rule, sign in proof.signs],
    }


def _orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    """The entry of run.json for an orbit: phases in degrees, speeds of its impacts in m/s."""
    omega = omega_of(orbit.rpm)
    return {
        "label": orbit.label,
        "rpm": orbit.rpm,
        "stable": orbit.stable,
        "verdict": VERDICTS[orbit.verdict],
        "theta_deg": [degrees(theta) for theta in orbit.theta],
        "regions": orbit.regions,
        "u_minus_m_per_s": [rate * omega for rate in orbit.rates],
        "multipliers": orbit.multipliers,
        "trace": orbit.trace,
        "det": orbit.det,
    }


def _event(event: Bifurcation) -> dict[str, Any]:
    """The entry of run.json for a bifurcation, with the inequalities that its class rests on."""
    impact = event.corner_impact
    inequalities = () if impact is None else impact.collision.inequalities
    return {
        "branch": event.branch,
        "label": event.label,
        "kind": event.kind,
        "value": event.value,
        "error": event.error,
        "status": event.status,
        "corner": event.corner,
        "classification": event.classification,
        "continues_as_branch": event.continues,
        "prediction_agrees": event.agrees,
        "words": event_words(event),
        "inequalities": [inequality_record(inequality) for inequality in inequalities],
    }


# --- the command


def _size(scene: Scene) -> Size:
    """Each start for the search is a run; how long branches are is not known before.

    Raises SceneError for what cannot be followed.
    """
    question_of(scene, varied_by(scene))
    runs = scene.orbits.starts + 1  # with the scene's own start
    return Size(
        what=plural(runs, "run"),
        pieces=runs,
        orbits=runs,
        turns=0.0,
        rows=runs,
        memory=300.0 * runs,
        tables=100.0 * runs,
        kept=0.0,
    )


COMMAND = Command(
    run=orbits,
    tables=(
        BRANCHES, EVENTS, CURVE, CODIM2, CHAOS,
        IMPACTS._replace(more={}), STROBE._replace(more={}),
    ),
    files=("orbits.png", "curve.png", "cover.png", "chaos.png", "proof.json", "check.py"),
    size=_size,
    drawing=lambda scene: Drawing(file=400e3, memory=120e6, per_pixel=5.0),
    sample=None,
    not_foreseen=plan.orbits,
    has_budget=True,
)  # fmt: skip
