"""cam orbits"""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

from camcli.cli.options import VARY, Request, Values, flag, given, numbers, option, refuse_idle
from camcli.cli.report import MORE, pair, say, table
from camcli.quantities import FOLLOWER, THETA, headed

if TYPE_CHECKING:
    from camcli.analysis.orbits.curves import Curve
    from camcli.analysis.orbits.orbit import PeriodicOrbit
    from camcli.analysis.orbits.study import OrbitsResult
    from camcli.api.result import Result

SHOWN_PHASES = 6  # of an orbit
SHOWN_POINTS = 12  # of a curve, about
MOST_LABELS = 3  # of a branch
IMPACTS_AT = headed("impacts at", THETA.unit)


def orbits(
    request: Request,
    at: str | None = option("Speed at which orbits are found.", "RPM"),
    label: str | None = option("Only this orbit, e.g. 'P(3;3:3:2)'.", "LABEL"),
    parameter: str | None = option("What varies along a branch. Default: rpm.", "NAME"),
    range_: str | None = option("Range of --parameter, or of --in.", "LO:HI"),
    branches: int | None = option("Branches followed that leave from events.", "N"),
    curve: str | None = option("Continue bifurcations of this kind.", "KIND"),
    within: list[str] | None = option("Number of --curve, once or twice.", "KEY=LO:HI", "--in"),
    vary: list[str] | None = VARY,
    all_: str | None = option("All orbits of at most N impacts in M turns.", "N,M", "--all"),
    prove: bool = flag("Prove what was found: proof.json."),
    with_checker: bool = flag("Write check.py beside proof.json."),
    chaos: bool = flag("Prove chaos at one speed: chaos.csv."),
) -> int:
    """Periodic orbits, followed, and their bifurcations.

    Examples:
      cam orbits --rpm 665:745                 all orbits with one impact, followed
      cam orbits --rpm 340:400 --at 358.5 --label 'P(3;3:3:2)'   one orbit
      cam orbits --curve corner-impact --in restitution=0.6:0.9  in two parameters
      cam orbits --rpm 745 --chaos             prove chaos; or all orbits: --all 3,2

    Files:
      branch.csv       the points of each branch; bifurcations.csv: the events
      curve.csv        --curve; also codim2.csv; impacts.csv, strobe.csv: simulated
      orbits.png       branches, multipliers; curve.png, --curve; cover.png, --all
      proof.json       --prove; also check.py; chaos.csv, chaos.png: --chaos

    \b
    orbits.png        branches, multipliers, corner impacts; with --prove a yellow band along what
                      is proved, and about each impact of a stable orbit the ellipse of impacts
                      from which every motion tends to it (panel attraction); curve.png the curves;
                      cover.png, with --all, boxes of the phases of two impacts by what excludes an
                      orbit there
    impacts.csv       simulated motions behind the branches; also strobe.csv
    chaos.csv         boxes of impacts, and which covers which; chaos.png shows them

    \b
    --rpm X       the orbits at one speed; --rpm LO:HI follows them through the range, both ways
    --at X        where they are found; from the scene's start, a cloud of starts and, with one
                  impact, from the closed equation, which gives all of them
    --label L     only this orbit, 'P(3;3:3:2)'; an unstable one is sought among close returns
    --vary KEY=LO:HI  a branch in this key at the speed --rpm X, --points at least. KEY: rpm, a
                  constant of the follower as follower.restitution, or any number of the cam as
                  cam.nose_radius, whose corners move with it. With --curve once for the second
                  parameter, or twice
    --parameter NAME --range LO:HI is short for --vary follower.NAME=LO:HI, the column at the end
    --branches N  how many branches that leave from bifurcations are followed too
    --curve KIND  continue the bifurcations of a kind in two numbers: --in KEY=LO:HI once, beside
                  the speed, or twice: the branches vary the first one. A constant of the follower
                  needs no section: in rpm and --in NAME over --range, or in --parameter over
                  --range and --in NAME=LO:HI
    --all N,M     all orbits at one speed with at most N impacts in at most M turns, each proved,
                  and proved to be all that fly from impact to impact: boxes cover all phases, and
                  none but theirs holds an orbit; motions that rest are left out
    --prove       prove orbits, events, ranges of branches, and curves from point to point, in ball
                  arithmetic and for the numbers of the scene as they are; on a cam of arcs for the
                  flank circle that closes, of the radius base_radius + flank_center; proof.json has
                  the certificates of all but single grazes and fading impacts
    --with-checker  check.py is copied beside proof.json; it needs Python and python-flint only
    --chaos       at one speed: seek boxes of impacts about an unstable orbit and a chain of impacts
                  that leaves it and comes back, and prove that the impacts after those of a box
                  cover the next one; so there are infinitely many periodic orbits, and a lower
                  bound of the topological entropy. It does not say that the attractor is chaotic

    \b
    A proof is a list of boxes of numbers, and inequalities between exact numbers that show that
    each box holds exactly one orbit, that it is a motion, and whether it is stable. proof.json has
    all of them; python -m camcli.check proof.json, or the copy of that one file, which shares
    nothing with camcli, checks them again and says of each statement in words whether it holds.
    Exit code 0: all are confirmed; 1: one is not; 2: the file is no certificate; 3: it holds no
    statement.

    \b
    Kinds: period-doubling (1 + trace + det = 0); fold (the parameter turns round); corner-impact
    (an impact reaches a corner of the cam); grazing (a contact appears in a flight, or an impact
    fades); for orbits that rest: chatter-completion, departure (a departure from rest appears or
    vanishes), itinerary (an impact appears, fades or moves to another turn), detachment (contact
    is first lost). A branch ends at one of these, at end-of-range, or at no-machine, where beyond
    it the number makes no cam, or one with other parts; in run.json also at: closed, lost,
    work-budget, and fault, a fault of camcli that cost the rest of the branch alone: it ends with
    exit code 1, and piece_faults has the traceback.
    A curve goes both ways and ends, in the words of the screen and of run.json, at: end-of-range of
    a number; closed; no-machine; an impact reaches a corner; the orbit is no motion any more; the
    orbit becomes one of fewer turns; work-budget; and lost, where it could not be followed further.
    Where it ends at a point of codimension two, that is named beside it.
    Classification of a corner impact, from the traces and determinants on both sides:
    persistence, nonsmooth-fold, border-period-doubling, robust-chaos, no-attractor, dangerous,
    degenerate. The left side of a corner impact (trace_left, det_left, L) is the orbit whose impact
    lies before the corner, at a smaller phase; the right side (R) is the one behind it.
    run.json has the inequalities, and what a simulation shows on either side.
    Points of codimension two on the curves, in codim2.csv: fold-grazing, period-doubling-grazing,
    cusp, corner-impact-fold, corner-impact-period-doubling, double-corner-impact,
    corner-impact-grazing, double-grazing, corner-grazing (a graze at a corner), conservative (a
    curve ends where nothing is lost, every determinant being 1). No orbit has multipliers +1 and -1
    at once: the determinant, their product, is not negative. Both conditions are solved together in
    ball arithmetic, and run.json says what unfolds there by theory; with --prove both numbers are
    enclosed, and the orbit is shown to be the only one with both, and a motion (not yet at a cusp,
    or with two grazes at once); what unfolds is not proved.
    A root that penetrates the cam or would pull is virtual: in run.json, never in a table.
    """
    from camcli.cli.run import points_of, ranges, run
    from camcli.scene.speeds import names_a_crank

    speeds = _speeds(request)
    named_keys = _keys_of(within or [])
    _refuse_idle(
        speeds, named_keys, parameter=parameter, range_=range_, within=within, vary=vary,
        curve=curve, label=label, all_=all_, at=at, chaos=chaos, prove=prove,
        with_checker=with_checker,
    )  # fmt: skip
    if vary or named_keys:
        typed = "--vary" if vary else "--in"
        values = ranges(request, "orbits", vary or named_keys, most=2, option=typed)
    else:
        values = speeds | given("orbits.rpm", "--points", num=points_of(request)[0])
    if names_a_crank(at):
        values |= given("orbits", at=at)
    else:
        one_number = numbers(at, "--at", "one number", "700")
        values |= given("orbits", at=one_number[0] if one_number else None)
    values |= given("orbits", label=label, parameter=parameter)
    values |= given("orbits", branches=branches, curve=curve)
    if within and not named_keys:  # a constant of the follower, with its range or without
        curve_in, _, text = within[0].partition("=")
        curve_range = numbers(text or None, "--in", "two numbers LO:HI", "0.6:0.9")
        values |= given("orbits", "--in", curve_in=curve_in or None, curve_range=curve_range)
    values |= given("orbits", range=numbers(range_, "--range", "two numbers LO:HI", "0.6:0.9"))
    size = numbers(all_, "--all", "two numbers N,M", "3,2")
    if size is not None:
        impacts, turns = (int(count) if count.is_integer() else count for count in size)
        values |= given("orbits.all", "--all", impacts=impacts, turns=turns)
    values |= given("orbits", prove=prove, checker=with_checker, chaos=chaos)
    return run("orbits", request, values, show)


def _refuse_idle(
    speeds: Values, named_keys: list[str], *, parameter: str | None, range_: str | None,
    within: list[str] | None, vary: list[str] | None, curve: str | None, label: str | None,
    all_: str | None, at: str | None, chaos: bool, prove: bool, with_checker: bool,
) -> None:  # fmt: skip
    """Raise SceneError for options that mean nothing beside the others, or without one of them.

    Every row: whether it was given so, the option, what it was given with or without, what to do.
    """
    nothing_varied = not (parameter or curve)
    one_speed = bool(speeds) and speeds["orbits.rpm.start"][0] == speeds["orbits.rpm.stop"][0]
    many_speeds = bool(speeds) and not one_speed
    varied_at_many_speeds = parameter not in (None, "rpm") and many_speeds
    short_forms = (("--parameter", parameter), ("--range", range_), ("--in", within))
    other_questions = (("--vary", vary), ("--curve", curve), ("--label", label))
    proves = prove or all_ or chaos
    varies = parameter or curve or vary
    cure_of_range = "add --parameter or --curve and --in"
    rows: list[tuple[object, str, str, str]] = [
        (within and not curve, "--in", "without --curve", "add --curve KIND"),
        (range_ and nothing_varied, "--range", "without a parameter", cure_of_range),
    ]
    for name, other in short_forms:
        rows.append((vary and other, name, "with --vary", "give the one or the other"))
    for name, other in short_forms[:2]:
        beside = "with --in KEY=LO:HI"
        rows.append((named_keys and other, name, beside, "give both numbers with --in"))
    rows += [
        (varied_at_many_speeds, "--parameter", "with a range of speeds", "give one speed: --rpm X"),
        (with_checker and not proves, "--with-checker", "without --prove", "add --prove"),
    ]
    for name, other in (*short_forms, *other_questions):
        rows.append((all_ and other, name, "with --all", "leave one of them out"))
    rows += [
        (all_ and many_speeds, "--rpm", "LO:HI with --all", "give one speed: --rpm X"),
        (chaos and many_speeds, "--chaos", "without one speed", "give --rpm X"),
        (chaos and varies, "--chaos", "with a number that varies", "give --rpm X alone"),
        (at and one_speed, "--at", "with one speed", "give --rpm LO:HI, or leave --at out"),
    ]
    refuse_idle(*rows)


def _keys_of(within: list[str]) -> list[str]:
    """The axes that --in names; none where it names one constant of the follower and no range.

    A name without a section is the speed or a constant of the follower.
    """
    names = [text.partition("=")[0] for text in within]
    if len(names) == 1 and "." not in names[0]:
        return []
    return [
        f"follower.{text}" if name in FOLLOWER else text
        for name, text in zip(names, within, strict=True)
    ]


def _speeds(request: Request) -> Values:
    """The speed or the range of --rpm as keys of the scene; none without --rpm."""
    from camcli.scene import parse_rpm

    if request.rpm is None:
        return {}
    rpm = parse_rpm(request.rpm)
    low, high = rpm if isinstance(rpm, tuple) else (rpm, rpm)
    values = {"orbits.rpm.start": (low, "--rpm"), "orbits.rpm.stop": (high, "--rpm")}
    if low == high:
        values["orbits.at"] = (low, "--rpm")
    return values


def show(result: Result, verbose: bool) -> None:
    """Print orbits, branches, bifurcations and curves, then sentences."""
    from camcli.words.orbits import curve_title, orbits_title, remarks

    found = result.values
    if found.orbits:
        _show_orbits(found, orbits_title(found, result.scene.cam.kind), verbose)
    if found.branches:
        _show_branches(found, verbose)
    if found.bifurcations:
        _show_bifurcations(found, verbose)
    for number, curve in enumerate(found.curves, 1):
        _show_curve(curve, curve_title(number, curve))
    if found.codim2:
        _show_points(found, verbose)
    for line in remarks(found, verbose, result.scene.cam.kind):
        say(line, "- ")
    system: Any = result.system
    fitted = result.scene.cam.kind == "table"
    if result.scene.orbits.prove and found.orbits and fitted and system.has_seat:
        from camcli.words.proofs import NO_CERTIFICATE_OF_A_SEAT

        say(NO_CERTIFICATE_OF_A_SEAT, "- ")
    if not verbose:
        print(MORE)


def _show_orbits(found: OrbitsResult, title: str, verbose: bool) -> None:
    """Print the orbits found at one speed; verbose: with multipliers, trace and determinant."""
    heads = ["orbit", "stable", IMPACTS_AT, "multipliers", "trace", "det"]
    rows = [
        [
            orbit.label,
            "yes" if orbit.stable else "no",
            _phases(orbit),
            pair(orbit.multipliers, 7),
            f"{orbit.trace:.10g}",
            f"{orbit.det:.10g}",
        ]
        for orbit in found.orbits
    ]
    table(title, heads, rows, hidden=0 if verbose else 3)


def _show_branches(found: OrbitsResult, verbose: bool) -> None:
    """Print the branches, a line each; verbose: with how many points they have."""
    from camcli.words.orbits import stable_cell, turns_cell

    heads = ["branch", "labels", "from", "to", "stable", "turns at", "ends", "points"]
    rows = [
        [
            str(branch.number),
            ", ".join(branch.labels[:MOST_LABELS]),
            f"{branch.points[0].value:.7g}",
            f"{branch.points[-1].value:.7g}",
            stable_cell(branch, found.bifurcations),
            turns_cell(branch),
            " | ".join(branch.ends),
            str(len(branch.points)),
        ]
        for branch in found.branches
    ]
    title = f"Branches in {found.question.parameter}"
    table(title, heads, rows, hidden=0 if verbose else 1)


def _show_bifurcations(found: OrbitsResult, verbose: bool) -> None:
    """Print the events of all branches; verbose: with their errors and classes."""
    from camcli.words.orbits import in_order

    heads = ["branch", "orbit", "event", found.question.parameter, "error", "class"]
    rows = [
        [
            str(event.branch),
            event.label,
            f"{event.kind} at {event.corner}" if event.corner else event.kind,
            f"{event.value:.13g}",
            f"{event.error:.1e}",
            event.classification,
        ]
        for event in in_order(found.bifurcations)
    ]
    table("Bifurcations", heads, rows, hidden=0 if verbose else 2)


def _show_curve(curve: Curve, title: str) -> None:
    """Print some points of a curve, evenly along it."""
    every = max(1, len(curve.points) // SHOWN_POINTS)
    rows = [
        [f"{point.first:.10g}", f"{point.second:.10g}", _phases(point.orbit)]
        for point in curve.points[::every]
    ]
    table(title, [curve.first, curve.second, IMPACTS_AT], rows, cut=IMPACTS_AT)


def _show_points(found: OrbitsResult, verbose: bool) -> None:
    """Print the points of codimension two; verbose: with what meets there."""
    from camcli.words.codim2 import meets_words

    assert found.question.plane is not None
    heads = ["kind", "orbit", *found.question.plane.names, "curves", "meets"]
    rows = [
        [
            point.kind,
            point.label,
            f"{point.first:.13g}",
            f"{point.second:.13g}",
            ", ".join(str(number) for number in point.curves),
            meets_words(point),
        ]
        for point in found.codim2
    ]
    table("Points of codimension two", heads, rows, hidden=0 if verbose else 1)


def _phases(orbit: PeriodicOrbit) -> str:
    """The phases of the impacts (deg), the first SHOWN_PHASES of them."""
    words = [f"{degrees(theta):.8g}" for theta in orbit.theta[:SHOWN_PHASES]]
    more = len(orbit.theta) - len(words)
    return ", ".join(words) + (f" and {more} more" if more > 0 else "")
