"""cam sweep"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from camcli.cli.options import CLUSTER, SHARD, VARY, Request, flag, given, option
from camcli.cli.report import say, table
from camcli.errors import shown

if TYPE_CHECKING:
    from camcli.api.result import Result


def sweep(
    request: Request,
    lyapunov: bool = flag("Measure the largest exponent at each speed."),
    explain: bool = flag("Find the cause of every change."),
    vary: list[str] | None = VARY,
    zoom: list[str] | None = option("A part of the range, enlarged.", "LO:HI"),
    both: bool = flag("Carry the state up, then down."),
    adaptive: bool = flag("More values where the motion changes."),
    branches: str | None = option("A branch.csv of cam orbits, drawn over.", "FILE"),
    curves: str | None = option("Bifurcations drawn over a map.", "FILE or auto"),
    prove: bool = flag("Prove the curves of --curves auto."),
    decide: bool = flag("Follow points of a map beyond rounding, after rests."),
    shard: str | None = SHARD,
    cluster: str | None = CLUSTER,
) -> int:
    """Bifurcation diagram over speeds, or another number.

    Examples:
      cam sweep --rpm 660:760                  401 speeds, each started from rest
      cam sweep --rpm 735:672 --set sweep.direction=down   carried along
      cam sweep --rpm 660:760 --vary follower.restitution=0.6:0.9 --points 40,20

    Files:
      impacts.csv      the recorded impacts: phase, position, velocity
      strobe.csv       the state once a turn
      speeds.csv       label, loads, status of each speed; corners.csv: --explain
      map.csv          of two; curves.csv, codim2.csv, proof.json: --curves auto
      sweep.png        impact phases and stroboscopic positions; map.png the map

    \b
    *.npz        impacts and strobe with sweep.tables: npz (numpy.load); with none neither
    map.png      the kind of motion over two numbers; --panels also exponents and each column
    sweep.png    impact phases beside the cam's c, c', c''; stroboscopic positions

    \b
    --vary KEY=LO:HI varies any number of follower, cam or run, --points of its values. Speeds are
    run.rpm (--rpm LO:HI). Two make a map of --points N,M; with sweep.direction the state is carried
    along the first. --curves FILE lays the curves of cam orbits --curve over it. --curves auto
    finds them: orbits are solved along the map's four edges, and each of their bifurcations
    (period-doubling, fold, corner-impact, grazing) is followed through the map to its other edge,
    numbered in map.png as in curves.csv; codim2.csv has the points at which two meet (cam orbits),
    and the curve of the other one is followed from there. Orbits that rest on the cam have no
    curves, and one that meets neither an edge nor another curve is not found. --prove shows in ball
    arithmetic that these curves have no gap from point to point, as cam orbits --curve --prove
    does, and encloses the points: of orbits of up to sweep.prove_turns turns (4). proof.json has
    the certificates of the curves, as those of cam orbits.
    In speeds.csv, impacts counts the recorded turns. sweep.direction up or down carries the
    state from speed to speed in that order; fixed starts every speed alike.
    --zoom LO:HI gives a part of the range values of its own, 201 or M of --points N,M, and a panel;
    it may be given again.
    sweep.also: [{q: 0.5, v: 30}] starts each speed from there too, for motions side by side.
    --both carries it up, then down.
    --adaptive adds values where the motion changes, down to the width of a column of the picture.
    --branches FILE draws solved branches over the points, stable solid and unstable dashed.
    --lyapunov fills lyapunov_per_period: the largest exponent, -inf where the follower rests; a
    strip of the picture shows it.
    --explain gives every change its cause as cam classify does, numbered in sweep.png.

    \b
    Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a
    complete chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64
    turns fits, and no orbit is being approached; undecided: too few impacts to tell. At the ends of
    each chaotic range motions are followed for run.patience further turns, inwards until two in a
    row stay chaotic, and drawn and named as what they settle on (watched_turns: for how many turns
    in all; one that comes to a rest is undecided; not in a map). A motion that rests in some turns
    only is decided as cam classify does, beyond rounding (in a map with --decide, some seconds a
    point); where that fails it is undecided and grey.
    The label of a speed inside a chaotic range may depend on the other speeds of the sweep: only
    the ends of the range are watched for long. cam classify watches every speed.
    Status: ok; impact-budget, no-return, unresolved: the record ends early, exit code 3; fault: a
    fault of camcli cost this row alone, exit code 1, run.json has the traceback (piece_faults).
    """
    from camcli.cli.run import points_of, ranges, run, span_of

    zooms = [span_of(text, "--zoom", "LO:HI", "739.2:739.5") for text in zoom or ()]
    if zooms and "," in (request.points or ""):
        points, points_of_zoom = points_of(request, 2)
        request = replace(request, points=str(points))
        zooms = [{**zoom_range, "num": points_of_zoom} for zoom_range in zooms]
    values = ranges(request, "sweep", vary, most=2)
    values |= given("sweep", zoom=zooms or None, lyapunov=lyapunov, explain=explain)
    values |= given("sweep", "--both", direction="both" if both else None)
    values |= given("sweep", adaptive=adaptive, branches=branches, curves=curves, decide=decide)
    values |= given("sweep", prove=prove)
    return run("sweep", request, values, show, shard=shard, cluster=cluster)


def show(result: Result, verbose: bool) -> None:
    """Print the ranges of one label, and the explanation if there is one."""
    from camcli.api.sweep import ranges
    from camcli.cli.classify import show_explanation
    from camcli.words.classify import exponent_text
    from camcli.words.labels import motion
    from camcli.words.speeds import range_heads
    from camcli.words.sweep import sweep_title

    found, explanation = result.values
    kind = result.scene.cam.kind
    if "labels" in result.summary:
        _show_map(result)
        return
    label_ranges = ranges(found)
    with_exponents = result.scene.sweep.lyapunov  # instead of what the label means
    rows = []
    for label_range in label_ranges:
        row = [shown(label_range.label)]
        if not with_exponents:
            row.append(motion(label_range.label, kind))
        row += [f"{label_range.first:.10g}", f"{label_range.last:.10g}"]
        row += [str(way) for way in label_range.way]
        row.append(str(label_range.speeds))
        if with_exponents:
            row.append(exponent_text(label_range.exponents))
        row.append(label_range.status)
        rows.append(row)
    heads = ["label"]
    if not with_exponents:
        heads.append("motion")
    heads += range_heads(found.key)
    heads += found.way_names
    heads.append("speeds" if found.key == "rpm" else "values")
    if with_exponents:
        heads.append("exponent")
    heads.append("status")
    title = sweep_title(found, len(label_ranges), kind)
    table(title, heads, rows, "speeds.csv", cut="label")
    if explanation is not None:
        show_explanation(explanation, verbose)


def _show_map(result: Result) -> None:
    """Print how many points of a map have each label, and what is said of its curves."""
    from camcli.words.sweep import map_title

    found, _ = result.values
    commonest_first = sorted(result.summary["labels"], key=lambda row: -row["points"])
    rows = [[row["label"], str(row["points"]), row["status"]] for row in commonest_first]
    title = map_title(found, result.scene.cam.kind)
    table(title, ["label", "points", "status"], rows, "run.json", cut="label")
    for line in result.summary.get("words", ()):
        say(line, "- ")
