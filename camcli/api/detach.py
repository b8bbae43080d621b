"""camcli.detach: where contact is lost, where chatter ends, and the spring that holds contact."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import degrees, inf, isnan, radians
from typing import TYPE_CHECKING, Any, BinaryIO

from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.bursts import LiftOff
from camcli.analysis.contact_loss.detachment import CriticalSpeed, NoStatement
from camcli.analysis.contact_loss.force import Force, ForceCurve, Hertz
from camcli.analysis.contact_loss.hold import Hold
from camcli.analysis.contact_loss.spread import Spread
from camcli.analysis.contact_loss.study import ContactLoss, motion_past, past_motions
from camcli.analysis.contact_loss.study import detach as run
from camcli.analysis.grid import rpm_grid
from camcli.analysis.lobe import Face, Lobe, lobe_of
from camcli.analysis.speeds import Speed
from camcli.analysis.surge import LIMIT, Surge, surge
from camcli.api.command import Command, Drawing, Size, fewer, sample
from camcli.api.lift_table import accel_errors, with_ranges
from camcli.api.machine import (
    Machine,
    machine_of,
    refuse_an_oscillator,
    with_arguments,
    with_values,
)
from camcli.api.proof_files import proof_files
from camcli.api.result import Progress, Result, budget_of, drawn_by, ticks
from camcli.api.rows import SPEEDS, WITH_LASH, seat_names, speed_row
from camcli.api.seating import seating_ranges
from camcli.api.tolerances import TOLERANCE, tolerances, tolerated
from camcli.cams.compile import lift_range
from camcli.errors import Fault, SceneError, Status, plural, worst_status
from camcli.kernel.backend import stopwatch
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.output.tables import Table
from camcli.parallel import Work
from camcli.piece_faults import gathering, piece
from camcli.quantities import CORNER, FORCE, PRESSURE, REGION, RPM, THETA, Head, Quantity
from camcli.scene import Scene
from camcli.system import System, omega_of, units_of
from camcli.words import plan
from camcli.words.detach import (
    burst_ranges,
    proof_name,
    proved_words,
    sentences,
    spring,
    unresolved_notes,
)
from camcli.words.loads import load
from camcli.words.simulate import pressure_notes
from camcli.words.statuses import status_notes, trouble
from camcli.words.surge import NOT_SIMULATED, surge_words

if TYPE_CHECKING:
    from camcli.plots.mechanism import Outline

LEFT_OPEN = "end of its bracket, of a measured cam of what the error of its table leaves"
DETACH = Head(
    "detach",
    "the critical speeds",
    (
        Quantity("quantity", "", "quantity", "which critical speed", "first_detachment, ..."),
        REGION, THETA, RPM._replace(entries="inf where contact is never lost"),
        Quantity("omega_rad_per_s", "rad/s", r"$\omega$", "angular velocity of the cam"),
        Quantity("rpm_low", "rpm", "lower end", f"lower {LEFT_OPEN}", "empty: not known"),
        Quantity("rpm_high", "rpm", "upper end", f"upper {LEFT_OPEN}", "empty: not known"),
    ),
)  # fmt: skip
ACCUMULATION = Head(
    "accumulation",
    "where a complete chatter ends; with cam.lash one that begins where the lobe loses the "
    "follower, none that begins with the opening blow or on the seat",
    (RPM, THETA),
)
CORNER_HITS = Head(
    "corner_hits",
    "speeds at which an impact after lift-off lands on a corner",
    (Quantity("impact", "", "impact", "number of the impact after lift-off"), CORNER, RPM),
)
REPORT_SPEEDS = 200  # past the loss of contact, of the curves of a report
AT_WORK_ON_SEAT = ("seat_velocity_m_per_s", "seat_bounces_per_turn", "seat_bounce_height_m")
ROWS = (8, 6, 5, 4, 3)  # of a long table in a report: as many as there is room for
DRAWN_AT = (0.0, 180.0, 90.0, 270.0)  # deg: the first at which the follower rests on its seat
PLACES = 1440  # of a turn, at which the drawn lobe is touched
ABREAST = 2  # panels of a report side by side
FORCES = Head(
    "force",
    "a follower kept on the cam; under a rocker the force is the valve's, the pressure the lobe's, "
    "on which rocker_ratio times that force acts",
    (RPM, THETA, FORCE, PRESSURE),
)
SURGE = Head(
    "surge",
    "with spring.mass: the harmonics of the cam's lift and where they meet the spring",
    (
        Quantity("harmonic", "", "harmonic", "number of the harmonic, n"),
        Quantity("amplitude_m", "m", "amplitude", "of that harmonic of the lift"),
        RPM._replace(words="speed of the cam at which it meets the spring's own frequency"),
        Quantity(
            "resonance_factor", "", "harmonic-resonance factor",
            "n^2 times the amplitude in inches; a usual limit is 0.12",
        ),
    ),
)  # fmt: skip
PAST = SPEEDS._replace(
    words="the motion at some speeds past the first loss of contact, 20 turns from rest and 20 "
    "that are measured",
    more={WITH_LASH: SPEEDS.more[WITH_LASH]},
)


def detach(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    report: bool = False,
    prove: bool = False,
    work: Work | None = None,
) -> Result:
    """Critical speeds at which contact is lost, from the contact force, and the chatter after it.

    The contact force of the follower kept on the cam is N = k c + b c' + m g + F0 + m c''; contact
    is first lost at the speed where it falls to zero, and a chatter that follows accumulates at the
    phase found by following it from rest.

    Parameters
    ----------
    scene : Scene, optional
        The machine and the section ``detach``; the default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    report : bool
        ``detach.report``: save a page for print too, ``report.pdf`` (A4): the machine, the verdict,
        contact force, loft and landing speed, and the springs that hold to ``detach.hold_to``, or
        else to the end of the range.
    prove : bool
        ``detach.prove``: prove in ball arithmetic up to which speed contact holds, and at which
        speeds an impact after that lift-off lands on a corner; `save` writes their certificates,
        ``proof.json``.
    work : Work, optional
        How the machines of ``detach.tolerance`` are computed: threads, pieces kept on disk. It
        never changes a result.

    Returns
    -------
    Result
        Tables ``detach``, ``accumulation``, ``corner_hits``, ``force`` and ``speeds``, with
        ``detach.tolerance`` ``tolerance``, with ``spring.mass`` ``surge``; their columns are in the
        guide (`cam guide detach`).

    Examples
    --------
    A weight on an eccentric cam leaves it where the cam falls faster than the weight, at
    omega^2 e = g, with the eccentricity e half the lift:

    >>> from math import isclose, pi, sqrt
    >>> import camcli
    >>> weight = {"mass": 1.0, "stiffness": 0.0, "gravity": 9.81, "restitution": 0.5}
    >>> cam = {"kind": "eccentric", "base": 0.0, "lift": 0.02}
    >>> result = camcli.detach(camcli.load_scene({"follower": weight, "cam": cam}))
    >>> isclose(result.values.detachment.first.rpm, sqrt(9.81 / 0.01) * 30 / pi)
    True

    References
    ----------
    Chatter and its map: C. Budd and F. Dux, Phil. Trans. R. Soc. A 347 (1994) 365-389.
    """
    asked = with_arguments(scene, "detach", report=report, prove=prove)
    refuse_an_oscillator(asked, "detach")
    machine = _held_in_report(machine_of(asked))
    scene = machine.scene
    system = machine.system
    section = scene.detach
    spring = scene.spring
    waves = None if spring is None or spring.mass is None else surge(system, spring.mass)
    machines = tolerated(machine)
    rpms = rpm_grid(section.rpm.start, section.rpm.stop, section.rpm.num)
    with stopwatch() as watch, budget_of(scene, progress) as budget, gathering() as faults:
        found = run(
            system,
            rpms,
            machine.settings,
            settle=section.settle,
            impacts=section.impacts,
            force_speeds=section.force_rpm,
            hold_speed=section.hold_to,
            margin=section.margin_n,
            precompression=section.precompression_m,
            accel_error=accel_errors(scene.cam),
            solid=inf if spring is None or spring.solid_at is None else spring.solid_at,
            hertz=_hertz(machine),
            working_speed=_working_speed(scene),
            on_speed=ticks(progress, "speeds", len(rpms)),
        )
    spread: Spread | None = None
    certificate: dict[str, Any] | None = None
    with gathering() as later_faults:
        found, record = _completed(machine, found, rpms)
        tables = _tables(found, system.has_seat)
        if waves is not None:
            tables["surge"] = _surge_table(waves)
            record["surge"] = _surge(waves, found)
        if section.tolerance:
            of_tolerances = tolerances(machines, found, work or Work(), progress)
            tables["tolerance"], record["tolerance"], spread = of_tolerances
        if section.prove:
            certificate, record["proved"] = _proved(system, found)
        warnings = piece("whether the lobe is undercut", partial(_undercut, machine), [])
    notes = _notes(found, budget.status)
    result = Result(
        command="detach",
        scene=scene,
        system=system,
        values=found,
        tables=tables,
        summary={
            "status": worst_status([budget.status, *(code for _, code in found.troubled)]),
            **record,
        },
        pictures={
            "detach": drawn_by(
                "detach.draw_detach", found, system, waves, spread, _proved_speeds(certificate)
            )
        },
        cost=found.cost,
        seconds=watch.seconds,
        notes=(*notes, *warnings),
        complete=not notes,
        faults=(*faults, *later_faults),
        files=proof_files(certificate),
    )
    if not section.report:
        return result
    with gathering() as faults_of_report:
        past = past_motions(system, rpms, machine.settings, REPORT_SPEEDS)
    write = partial(_write_report, result, system, past, waves, spread)
    return replace(
        result,
        files={**result.files, "report.pdf": write},
        faults=(*result.faults, *faults_of_report),
    )


def _completed(
    machine: Machine, found: ContactLoss, rpms: Sequence[float]
) -> tuple[ContactLoss, dict[str, Any]]:
    """The study with the motions that the scene asks for beside it, and its entries of run.json.

    They are those at the speed of the run and, with a seat, at the one speed of the section. The
    brackets are those that the error of a measured cam leaves.

    Each step is a `piece`: where an unforeseen exception costs it, the last argument stands instead
    and the others go on.
    """
    system = machine.system
    found = piece("the ranges of a measured cam", partial(with_ranges, found, system), found)
    record = piece("the summary", partial(_summary, found), {})
    working = _working_speed(machine.scene)
    if working is not None:
        at_work = partial(_moved_at_work, machine, found, working)
        found = piece(f"the motion at {working!r} rpm", at_work, found)
        entry = partial(_at_work, machine, found, working)
        record["working"] = piece(f"what is told of {working!r} rpm", entry, None)
    if system.has_seat and len(rpms) == 1 and not found.past:
        as_asked = partial(_moved_as_asked, machine, found, rpms[0])
        found = piece(f"the motion at {rpms[0]!r} rpm, as asked for", as_asked, found)
    ranges = piece("the ranges of seating", partial(seating_ranges, machine, found), [])
    if ranges:
        record["seating"] = ranges
    return found, record


def _notes(found: ContactLoss, budget_status: Status) -> list[str]:
    """What of the study is not complete, in sentences; budget_status: whether the budget lasted."""
    notes = status_notes(found.troubled)
    statuses_told = [status for _, status in found.troubled]
    if budget_status not in statuses_told:
        notes += trouble(budget_status)
    return notes + unresolved_notes(found)


def _proved(
    system: System, found: ContactLoss
) -> tuple[dict[str, Any] | None, dict[str, Any] | None]:
    """(content of proof.json, entry of run.json) of what can be proved.

    The content is None where it has no statement, the entry where an exception has cost the proofs.
    """
    proofs = piece("the proofs", partial(_certificate, system, found), None)
    if proofs is None:
        return None, None
    certificate, why_not = proofs
    count = len(certificate["statements"])
    uncovered = certificate["uncovered"]
    entry = {
        "statements": count,
        "not_proved": uncovered,
        "words": proved_words(count, uncovered, why_not),
    }
    return certificate if count else None, entry


def _proved_speeds(certificate: dict[str, Any] | None) -> list[float]:
    """The speeds (rpm) of which proof.json has a statement: its lower ends, rounded."""
    if certificate is None:
        return []
    return [float(statement["low"]) for statement in certificate["statements"]]


def _certificate(system: System, found: ContactLoss) -> tuple[dict[str, Any], NoStatement | None]:
    """The content of proof.json, and why the first detachment has no statement, None if it can."""
    from camcli.analysis.contact_loss.certificate import certificate, no_statement
    from camcli.cams.formula import formula_of

    cam = formula_of(system.shape, system.follower.seat_restitution)
    content = certificate(system, found.detachment, found.hits, cam, proof_name)
    return content, no_statement(system, found.detachment, cam)


def _surge_table(waves: Surge) -> Table:
    """The table `surge`: a row for each harmonic."""
    rows = [(wave.number, wave.amplitude, wave.rpm, wave.factor) for wave in waves.harmonics]
    return Table.of_rows(SURGE.names(), lambda: rows)


def _surge(waves: Surge, found: ContactLoss) -> dict[str, Any]:
    """The entry of run.json for the surge of the spring."""
    first = found.detachment.first
    first_rpm = first.rpm if first is not None and first.finite else None
    return {
        "mass_kg": waves.mass,
        "frequency_hz": waves.hertz,
        "limit": LIMIT,
        "strong": [
            {"harmonic": wave.number, "rpm": wave.rpm, "factor": wave.factor}
            for wave in waves.strong_below(inf)
        ],
        "words": surge_words(waves, first_rpm),
    }


def _working_speed(scene: Scene) -> float | None:
    """The speed of the run where the scene states it; the default says nothing of a machine."""
    return scene.run.rpm if "rpm" in scene.run.model_fields_set else None


def _moved_at_work(machine: Machine, found: ContactLoss, rpm: float) -> ContactLoss:
    """The study with the motion at the speed of the run, which is `rpm`.

    It is as it was where contact holds at that speed and the follower has no seat.
    """
    first = found.detachment.first
    system = machine.system
    lost = first is not None and first.rpm < rpm
    if not (lost or system.has_seat):
        return found
    moved = motion_past(system, rpm, machine.settings)
    return replace(found, at_work=moved, cost=found.cost + moved.cost)


def _moved_as_asked(machine: Machine, found: ContactLoss, rpm: float) -> ContactLoss:
    """The study with the motion at the one speed that was asked for."""
    moved = motion_past(machine.system, rpm, machine.settings)
    return replace(found, at_asked=moved, cost=found.cost + moved.cost)


def _at_work(machine: Machine, found: ContactLoss, rpm: float) -> dict[str, Any] | None:
    """The entry of run.json for the speed of the run; None where no speed marks a loss.

    Landings are None where contact holds, or where the error of a measured cam leaves that open.
    With a seat, how hard the follower comes to it is told in both cases.
    """
    first = found.detachment.first
    system = machine.system
    if first is None or not first.finite:
        return None
    least_force, _, theta = Force(system).weakest(rpm)
    measured = machine.scene.cam.kind == "table"
    entry = {
        "rpm": rpm,
        "least_force_n": least_force,
        "theta_deg": degrees(theta),
        "open": measured and first.low < rpm < first.high,  # whether contact is lost
        "max_impact_m_per_s": None,
        "landing_deg": None,
        "landing_lift_m": None,
    }
    loads = None if found.at_work is None else found.at_work.loads
    if system.has_seat:
        for name in AT_WORK_ON_SEAT:
            entry[name] = None if loads is None else load(loads, name)
    if rpm <= first.rpm or entry["open"]:
        return entry
    if loads is None or loads.max_impact_m_per_s is None or loads.landing is None:
        return entry
    entry["max_impact_m_per_s"] = loads.max_impact_m_per_s
    entry["landing_deg"] = degrees(loads.landing)
    entry["landing_lift_m"] = loads.landing_lift_m
    return entry


def _held_in_report(machine: Machine) -> Machine:
    """The machine with detach.hold_to at the end of the range, where a report has no such speed.

    A report shows springs that hold contact up to a speed.
    """
    section = machine.scene.detach
    if not section.report or section.hold_to is not None:
        return machine
    fastest = max(section.rpm.start, section.rpm.stop)
    return replace(machine, scene=with_values(machine.scene, "detach", hold_to=fastest))


def _tables(found: ContactLoss, seat: bool) -> dict[str, Table]:
    """The tables that every run has, by name; seat: whether the follower has a seat."""
    forces = []  # a block of rows for each curve; two rows at a corner, one for each side
    for curve in found.forces:
        thetas = [degrees(theta) for theta in curve.theta]
        forces.append((curve.rpm, thetas, curve.force_n, curve.pressure_pa or None))
    return {
        "detach": Table.of_rows(DETACH.names(), lambda: _critical_rows(found)),
        "accumulation": Table.of_rows(ACCUMULATION.names(), lambda: _chatter_end_rows(found)),
        "corner_hits": Table.of_rows(CORNER_HITS.names(), lambda: _corner_hit_rows(found)),
        "force": Table(FORCES.names(), lambda: iter(forces)),
        "speeds": Table.of_rows(
            (*PAST.names(), *seat_names(seat)),
            lambda: (speed_row(speed, seat) for speed in found.past),
        ),
    }


def _chatter_end_rows(found: ContactLoss) -> Iterator[tuple[float, float]]:
    """The rows of accumulation.csv: speed (rpm), and phase (deg) at which a chatter ends."""
    for speed in found.speeds:
        for end in speed.ends:
            yield speed.rpm, degrees(end)


def _corner_hit_rows(found: ContactLoss) -> Iterator[tuple[int, str, float]]:
    """The rows of corner_hits.csv: number of the impact, corner, speed (rpm)."""
    for hit in found.hits:
        yield hit.impact, hit.corner, hit.rpm


def _write_report(
    result: Result,
    system: System,
    past: Sequence[Speed],
    waves: Surge | None,
    spread: Spread | None,
    file: BinaryIO,
) -> None:
    """Write report.pdf, the page of --report: the machine drawn, the verdict, tables and curves.

    past: motions past the loss of contact; waves: the surge of the spring, where its mass is known;
    spread: of the machines within their tolerances, where these were asked for.
    """
    from camcli.output.pictures import write_pages
    from camcli.plots.detach import report_panels
    from camcli.words.machine import report_title

    scene = result.scene
    cam = result.scene.cam
    warnings = [note for note in result.notes if note.startswith("warning")]
    words = "\n".join([*result.verdict, *warnings]).replace("+-", "±")
    # A verdict in which surge gives first says it in words of its own.
    if waves is not None and "not simulated" not in words:
        words += f"\n{NOT_SIMULATED.capitalize()}."
    outline = _outline(scene, system)
    form = {"width": 180.0, "height": 267.0, "panels": None, "title": True}
    page = scene.plot.model_copy(update=form)
    panels = report_panels(result.values, system, outline, past, waves, spread)
    pages = _report_pages(result, report_title(cam), words, panels, page)
    write_pages(pages, file, page, margin=15.0)


def _outline(scene: Scene, system: System) -> Outline:
    """The machine of a report: under the follower that the scene says, else under a knife edge.

    Of a contact without a face the follower is that of the Hertz pressure: a roller where it has a
    radius, else a flat face. The cam is turned to where the follower is on its seat.
    """
    from camcli.plots.mechanism import Outline

    contact = scene.contact
    cam = scene.cam
    base = getattr(contact, "base_radius", None) or getattr(cam, "base_radius", None)
    on_seat = [deg for deg in DRAWN_AT if system.has_seat and system.is_seat(radians(deg))]
    turned_by = on_seat[0] if on_seat else 0.0
    if contact is None or base is None:
        outline = replace(Outline.of_lift(system, base, cam), at_rest_deg=turned_by)
        return outline.with_lash_seen() if on_seat else outline
    roller = contact.follower_radius or 0.0
    face = Face(contact.face or (Face.ROLLER if roller else Face.FLAT))
    drawn = system.as_drawn
    touched_at = []  # (stretch of the cam, phase)
    for k in range(PLACES):
        theta = TURN * k / PLACES
        touched_at.append((stretch_at(drawn.cam, theta), theta))

    def lobe(smaller: float = 0.0) -> Lobe:
        """The lobe on a base circle that is smaller by so much, m."""
        return lobe_of(drawn, face, base - smaller, roller, touched_at)

    outline = replace(Outline.of_lobe(system, lobe()), at_rest_deg=turned_by)
    return outline.over_lash(system.lash, lobe) if on_seat else outline


def _report_pages(
    result: Result, title: str, words: str, panels: dict[str, Any], form: Any
) -> list[Any]:
    """A page with everything; where that has no room, two, the first of which says what follows.

    Long tables have as many rows as there is room for. title, words: above the panels; panels: by
    name; form: of a page.
    """
    from camcli.plots.picture import Picture
    from camcli.words.detach import on_second_page, second_page
    from camcli.words.detach_tables import lists_of_forces, lists_of_motions
    from camcli.words.machine import machine

    of_machine = machine(result)
    of_forces = lists_of_forces(result)
    for most_rows in ROWS:
        lists = [of_machine, *lists_of_motions(result, most_rows), *of_forces]
        whole = Picture(title, panels, words=words, lists=lists)
        if whole.figure(form).has_room:
            return [whole]
    names = list(panels)
    for count in (2 * ABREAST, ABREAST):  # on the first page
        first_panels = {name: panels[name] for name in names[:count]}
        second_panels = {name: panels[name] for name in names[count:]}
        what_follows = on_second_page(list(second_panels), bool(result.values.past))
        told = f"{words}\n{what_follows}"
        first = Picture(title, first_panels, words=told, lists=[of_machine, *of_forces])
        if first.figure(form).has_room:
            break
    for most_rows in ROWS:
        motions = lists_of_motions(result, most_rows)
        second = Picture(second_page(title), second_panels, lists=motions)
        if second.figure(form).has_room:
            break
    return [first, second]


def _summary(result: ContactLoss) -> dict[str, Any]:
    """The result of run.json; a speed that does not exist is infinite.

    low_rpm and high_rpm are the speeds between which a critical speed lies, null where that is not
    known; of a measured cam they are what the error of its table leaves.
    """
    return {
        "words": sentences(result),
        "critical_speeds": [_critical(speed) for speed in result.critical_speeds],
        "just_above_opening": [_lift_off(lift_off) for lift_off in result.lift_offs],
        "corner_hits": [_hit(hit) for hit in result.hits],
        "corner_hits_ended": [_hit(hit) for hit in result.ended],
        "accumulation_jumps": [_critical(speed) for speed in result.jumps],
        "bursts": [burst_range._asdict() for burst_range in burst_ranges(result)],
        "least_force": [_least_force(curve) for curve in result.forces],
        "hold": [_hold(hold) for hold in result.holds],
        "hold_margin_n": result.margin if result.holds else None,
    }


def _least_force(curve: ForceCurve) -> dict[str, Any]:
    """The entry of run.json for a force curve: least force, and largest pressure where known."""
    entry = {
        "rpm": curve.rpm,
        "force_n": curve.lowest_n,
        "theta_deg": degrees(curve.lowest_theta),
    }
    if curve.pressure_pa:
        pressure, theta = curve.highest(curve.pressure_pa)
        entry["largest_pressure_pa"] = pressure
        entry["largest_pressure_deg"] = degrees(theta)
    return entry


def _lift_off(lift_off: LiftOff) -> dict[str, Any]:
    """The entry of run.json for the lift-off just above the speed at which a region opens."""
    return {
        "region": lift_off.region,
        "kind": lift_off.kind,
        "corner": lift_off.corner,
        "rpm": lift_off.rpm,
        "release_deg": degrees(lift_off.release),
        "landing_deg": degrees(lift_off.landing),
        "rest_deg": degrees(lift_off.rest),
    }


def _hold(hold: Hold) -> dict[str, Any]:
    """The entry of run.json for a spring that holds contact; stiffness in N/m, forces in N."""
    return {
        "quantity": hold.quantity,
        "status": hold.status,
        "stiffness": hold.stiffness,
        "preload": hold.preload,
        "region": hold.region,
        "theta_deg": _degrees(hold.theta),
        "detaches_rpm": hold.detaches,
        "least_n": hold.least_n,
        "obstacle": hold.obstacle,
        "missing_n": hold.missing_n,
        "nose_n": hold.nose_n,
        "more": hold.more,
        "low_rpm": hold.low,
        "high_rpm": hold.high,
        "words": spring(hold),
    }


def _degrees(theta: float | None) -> float | None:
    """An angle in degrees; None, where there is none, stays None."""
    return None if theta is None else degrees(theta)


def _critical(speed: CriticalSpeed) -> dict[str, Any]:
    """The entry of run.json for a critical speed with its bracket."""
    entry = {
        "quantity": speed.quantity,
        "region": speed.region,
        "theta_deg": degrees(speed.theta) if speed.finite else None,
        "rpm": speed.rpm,
        "low_rpm": speed.low,
        "high_rpm": speed.high,
        "status": speed.status,
    }
    if speed.burst:
        entry["burst"] = speed.burst
    return entry


def _hit(hit: CornerHit) -> dict[str, Any]:
    """The entry of run.json for a speed at which an impact lands on a corner.

    Where the curve of these speeds ends at a jump of the impact's phase, the entry has the phases
    on both sides of the jump.
    """
    entry = {
        "impact": hit.impact,
        "corner": hit.corner,
        "rpm": hit.rpm,
        "burst": hit.burst,
        "low_rpm": hit.low,
        "high_rpm": hit.high,
        "status": hit.status,
    }
    if hit.ends is not None:
        before, after = hit.ends
        entry["before_deg"] = degrees(before)
        entry["after_deg"] = degrees(after)
    return entry


def _critical_rows(found: ContactLoss) -> Iterator[tuple]:
    """The rows of detach.csv: the critical speeds, then those to which the springs hold.

    A speed that does not exist is inf, without a phase.
    """
    for speed in found.critical_speeds:
        theta_deg = degrees(speed.theta) if speed.finite else None
        bracket = _known(speed.low, speed.high)
        yield speed.quantity, speed.region, theta_deg, speed.rpm, omega_of(speed.rpm), *bracket
    for hold in found.holds:
        rpm = hold.detaches
        if rpm is not None:
            bracket = _known(hold.low, hold.high)
            yield hold.quantity, hold.region, _degrees(hold.theta), rpm, omega_of(rpm), *bracket


def _known(*speeds: float | None) -> list[float | None]:
    """The speeds, with None for those that are not known (NaN)."""
    return [None if rpm is None or isnan(rpm) else rpm for rpm in speeds]


def _hertz(machine: Machine) -> Hertz | None:
    """The contact of cam and follower for the Hertz pressure; None where the scene has none."""
    contact = machine.scene.contact
    cam = machine.system.cam
    if contact is None or contact.width is None:
        return None
    ratio = machine.system.rocker_ratio
    lowest_c, _ = lift_range(cam)
    # The radius where c = 0, on which Hertz counts c: the base circle is where c is lowest, and
    # the lash lies between it and the follower.
    radius = _base_radius(machine.scene) - (lowest_c - machine.system.lash) / ratio
    return Hertz(contact.width, contact.modulus, radius, contact.follower_radius, ratio)


def _base_radius(scene: Scene) -> float:
    """Radius of the base circle, m.

    Raises SceneError where neither the section `contact` nor the cam has it.
    """
    of_contact = None if scene.contact is None else scene.contact.base_radius
    base = of_contact or getattr(scene.cam, "base_radius", None)
    if base is None:
        found, expected = "found no radius of the base circle", "expected it here or in the cam"
        raise SceneError(Fault("", "contact.base_radius", found, expected, "give it in m"))
    return base


def _undercut(machine: Machine) -> list[str]:
    """A warning where the lobe is undercut under the follower whose pressure is asked for.

    There its radius of curvature, on which the pressure depends, would not be positive.
    """
    contact = machine.scene.contact
    system = machine.system.as_drawn
    if contact is None or contact.width is None:
        return []
    roller = contact.follower_radius
    face = Face.FLAT if roller is None else Face.ROLLER
    first_place = (0, Force(system).starts[0])  # any one will do: single points do not matter here
    lobe = lobe_of(system, face, _base_radius(machine.scene), roller or 0.0, [first_place])
    return pressure_notes(lobe, units_of(system))


# --- the command


REPORT = 130e3  # bytes of the page for print, about


def _size(scene: Scene) -> Size:
    """What it computes and writes: a run for each speed at which a chatter is followed.

    A turn is nothing beside the search for a chatter's end, so none are counted. Bytes a speed were
    measured on the default scene.
    """
    speeds = scene.detach.rpm.num
    return Size(
        what=plural(speeds, "run"),
        pieces=speeds,
        orbits=speeds,
        turns=0.0,
        rows=speeds,
        memory=300.0 * speeds,
        tables=100.0 * speeds,
        kept=0.0,
    )


def _sample(scene: Scene, n: int) -> Scene:
    """The analysis at few speeds: one is quick, so 25 for each piece. No tolerances."""
    rpm = fewer(scene.detach, 25 * n)["rpm"]
    return sample(scene, "detach", rpm=rpm, tolerance=())


def _check(scene: Scene) -> None:
    """Raise SceneError for a tolerance on a number that the machine has not."""
    if scene.detach.tolerance:
        tolerated(machine_of(scene))


COMMAND = Command(
    run=detach,
    tables=(DETACH, ACCUMULATION, CORNER_HITS, FORCES, PAST, TOLERANCE, SURGE),
    files=("detach.png", "report.pdf", "proof.json"),
    size=_size,
    drawing=lambda scene: Drawing(file=400e3, memory=90e6, per_pixel=5.0),
    beside=lambda scene: REPORT if scene.detach.report else 0.0,
    sample=_sample,
    check=_check,
    not_foreseen=plan.detach,
    keeps_pieces=lambda scene: bool(scene.detach.tolerance),
    has_budget=True,
)  # fmt: skip
