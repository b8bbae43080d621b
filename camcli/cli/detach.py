"""cam detach"""

from __future__ import annotations

from math import degrees, isnan
from typing import TYPE_CHECKING, Any

from camcli.cli.options import Request, flag, given, option
from camcli.cli.report import MORE, say, table
from camcli.errors import Fault, SceneError, shown
from camcli.quantities import RPM, THETA, headed

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.detachment import CriticalSpeed
    from camcli.analysis.contact_loss.study import ContactLoss
    from camcli.api.result import Result


def detach(
    request: Request,
    hold_to: str | None = option("Find the spring that holds to this speed, as of --rpm.", "RPM"),
    tolerance: list[str] | None = option("How far numbers may be off. Repeatable.", "KEY=5%,..."),
    report: bool = flag("Also write a page for print, report.pdf."),
    prove: bool = flag("Prove where contact is lost, and corner hits."),
) -> int:
    """Where contact is lost, and which spring would hold.

    Examples:
      cam detach                               where contact is lost, and how
      cam detach --hold-to 200                 three springs that hold up to 200 rpm
      cam detach -c configs/lift-table.yaml --report    one page for print

    Files:
      detach.csv       the critical speeds, with their brackets
      accumulation.csv where a complete chatter ends, against speed
      corner_hits.csv  the speeds at which the n-th impact lands on a corner
      force.csv        contact force of a follower kept on the cam; Hertz pressure
      speeds.csv       the motion at some speeds past the first loss of contact
      tolerance.csv    machines within their tolerances (--tolerance)
      surge.csv        harmonics that meet the spring (spring.mass)
      detach.png       all of it as a picture; report.pdf a page (--report)
      proof.json       certificates of --prove

    \b
    report.pdf        with --report a page: machine, verdict, forces, loft, landing, springs; with
                      surge and tolerances it may take two, and the first says what is on the second
    detach.png        impacts with accumulation curve and corner hits; the contact force; with
                      spring.mass the harmonics of the cam where they meet the spring, with
                      --tolerance the spread of machines and which number matters most

    \b
    --prove writes proof.json: boxes and inequalities that show, in ball arithmetic, up to which
    speed contact holds, and at which speed the n-th impact after that lift-off lands on a corner.
    python -m camcli.check proof.json checks them again by itself (cam guide proofs).

    \b
    On the screen "at lift" is the lift at the hardest landing, "bounces" the impacts a turn, a
    tenth as hard or harder, within a hundredth of the lift. With cam.lash "at lift" may say seat,
    or blow: the opening blow of the lobe. Of "on the seat" the row of run.rpm has a star, and a
    single speed of --rpm has a row though contact holds there.
    Regions A1, A2, ... lie between the cam's corners a, b, c, ... Quantities of detach.csv:
    first_detachment        lowest speed at which the contact force reaches zero anywhere
    opens, fills            contact begins to be lost in a region; is lost all over it (inf: never)
    accumulation_at_corner  a burst ends exactly on the corner `region`; looked for between the
                            speeds of the range (--points), from rest at each lift-off
    completion_loss         its end reaches, one turn later, the phase of the next lift-off
    hold_stiffness          first detachment with the spring that --hold-to found (in run.json);
    hold_preload            of the same stiffness;
    hold_both               of another stiffness and preload

    \b
    Every critical speed has a bracket and a status in run.json, of a measured cam what the error
    of its table leaves: ok; never; at-standstill; jump
    (the end of the chatter jumps over a corner); unresolved, exit code 3. A curve of corner hits
    may end where its impact ceases to exist: run.json says where. Status of speeds.csv: as of cam
    sweep. Where a fault of camcli costs a speed, a region, a curve or a machine (empty in
    tolerance.csv), the exit code is 1 and run.json has the traceback (piece_faults).
    """
    from camcli.cli.run import ranges, run
    from camcli.scene import parse_rpm

    values = ranges(request, "detach")
    if request.rpm is not None and ":" not in request.rpm:
        values["detach.force_rpm"] = ([parse_rpm(request.rpm)], "--rpm")
    fastest = None if hold_to is None else parse_rpm(hold_to, "--hold-to")
    if isinstance(fastest, tuple):
        cure = "e.g. --hold-to 3500, or --hold-to 7000crank"
        found = f"found the range '{shown(hold_to or '')}'"
        raise SceneError(Fault("--hold-to", "", found, "expected one speed", cure))
    tolerances = []
    for text in tolerance or ():
        tolerances += [_tolerance(entry) for entry in text.split(",")]
    values |= given("detach", hold_to=fastest, tolerance=tolerances or None)
    values |= given("detach", report=report, prove=prove)
    return run("detach", request, values, show)


def _tolerance(text: str) -> dict[str, Any]:
    """An entry of detach.tolerance from a text KEY=5%; raises SceneError for another text."""
    from camcli.scene.document import scalar

    key, _, share = text.partition("=")
    percent = scalar(share.strip().removesuffix("%"))
    if not share.strip().endswith("%") or type(percent) not in (int, float):
        found = f"found '{shown(text)}'"
        cure = "e.g. follower.mass=5%,follower.stiffness=3%"
        raise SceneError(Fault("--tolerance", "", found, "expected KEY=PERCENT%", cure))
    return {"key": key.strip(), "percent": percent}


def show(result: Result, verbose: bool) -> None:
    """Print what an engineer asks; the theory behind it only where it is asked for."""
    from camcli.words.detach import plainly, theory
    from camcli.words.detach_tables import answers

    for title, heads, rows in answers(result):
        table(title, heads, rows)
    if verbose:
        _show_theory(result)
    for line in plainly(result.values) + (theory(result.values) if verbose else []):
        say(line, "- ")
    if "proved" in result.summary:
        say(result.summary["proved"]["words"], "- ")
    if not verbose:
        print(MORE)


def _show_theory(result: Result) -> None:
    """Print the critical speeds, the impacts on corners and the bursts with all their digits."""
    from camcli.words.detach import burst_ranges

    loss: ContactLoss = result.values
    digits = _digits_of_a_table if result.scene.cam.kind == "table" else _digits_of_a_law
    critical = []
    for speed in loss.critical_speeds:
        if speed.finite:
            name = speed.quantity.replace("accumulation", "accumulates").replace("_", " ")
            critical.append([name, speed.region, *digits(speed), speed.status])
    hits = [
        [str(hit.impact), hit.corner, f"{hit.rpm:.9f}", f"{hit.high - hit.low:.1e}", hit.status]
        for hit in loss.hits
    ]
    bursts = [
        [alike.bursts, f"{alike.from_rpm:.10g}", f"{alike.to_rpm:.10g}", str(alike.speeds)]
        for alike in burst_ranges(loss)
    ]
    bracket, *ends = (headed(what, RPM.unit) for what in ("bracket", "from", "to"))
    for title, columns, rows in (
        ("Critical speeds", ["speed", "region", THETA.heading, "rpm", bracket, "status"], critical),
        ("Impacts on corners", ["impact", "corner", "rpm", bracket, "status"], hits),
        ("Bursts after settling", ["chattering", *ends, "speeds"], bursts),
    ):
        if rows:
            table(title, columns, rows)


def _digits_of_a_law(speed: CriticalSpeed) -> list[str]:
    """Phase, speed, and the width of its bracket."""
    width = speed.high - speed.low
    return [f"{degrees(speed.theta):.8f}", f"{speed.rpm:.9f}", f"{width:.1e}"]


def _digits_of_a_table(speed: CriticalSpeed) -> list[str]:
    """Phase, speed, and the bracket that the error of the table leaves, where that is known."""
    from camcli.words.speeds import range_words

    bracket = ""
    if not isnan(speed.low):
        bracket = range_words(speed.low, speed.high).removesuffix(" rpm")
    return [f"{degrees(speed.theta):.4g}", f"{speed.rpm:.4g}", bracket]
