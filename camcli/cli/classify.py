"""cam classify, and its calculator of border collisions, which needs no scene"""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any

from camcli.cli.options import VARY, Request, flag, given, numbers, option, refuse_idle
from camcli.cli.report import MORE, pair, say, table
from camcli.errors import Fault, SceneError, shown

if TYPE_CHECKING:
    from camcli.analysis.border_collision import Collision, Side
    from camcli.analysis.classify import ClassifiedMotion
    from camcli.analysis.explain.changes import Explanation
    from camcli.api.result import Result

NARROW = 32  # characters of a label beside others


def classify(
    request: Request,
    starts: int | None = option("Further starts at each speed.", "N"),
    seed: int | None = option("Another cloud of starts.", "N"),
    explain: bool = flag("Find the cause of every change."),
    vary: list[str] | None = VARY,
    trace: str | None = option("Traces of two linear maps.", "L,R"),
    det: str | None = option("Their determinants.", "L,R"),
) -> int:
    """The motion at each speed, its exponents, why it changes.

    Examples:
      cam classify --rpm 660:760 --points 21   labels and exponents
      cam classify --explain                   the cause of every change
      cam classify --trace 0.5,-1.6 --det 0.2,0.3   border collision of two maps

    Files:
      classify.csv     label, impacts, exponents and status, a row for each motion
      corners.csv      corner impacts of the solved branches (--explain)
      classify.png     labels and largest exponent against speed

    \b
    classify.png  labels and largest exponent against speed

    \b
    lyapunov_per_period: largest exponent per turn of the cam; -inf where the follower rests: both
    are then, since every difference is forgotten. run.json has the second one, the error bar, and
    the sum rule (sum = 2 ln r impacts per turn - b T/m) as a check.

    \b
    Labels: P(m;s1:...:sm) where Newton's iteration from the end of the record converges to an
    admissible, attracting orbit of up to 64 turns that the record approaches; contact; aperiodic
    where none does, the largest exponent is positive by three standard errors, and the motion
    neither settles nor rests in run.patience further turns; undecided where neither can be shown,
    or where a cycle through a rest is an accident of rounding. watched_turns: for how many turns in
    all what is, or first looked, aperiodic was followed.
    Status: as of cam sweep; fault: a fault of camcli cost this row alone, exit code 1, run.json has
    the traceback (piece_faults).
    --vary KEY=LO:HI varies any number of follower, cam or run, at the speed --rpm.
    --starts N classifies N more starts at each speed (Halton points, --seed): a row per attractor.

    \b
    --explain goes through the range, follows every attracting orbit found, and gives each change
    its cause, solved: period-doubling, fold, corner-impact (with its border-collision class),
    grazing, accumulation-at-corner, corner-hit, chatter-completion, first-detachment,
    interior-crisis, boundary-crisis, basin (both attractors are seen to live on, the start changes
    basins),
    itinerary (impacts of a resting orbit change), or unexplained with what was tried.
    --trace L,R --det L,R needs no machine: it names the border collision of two linear maps,
    and writes border_collision.json into the DIR of -o.
    """
    from camcli.cli.run import ranges, run

    idle = seed is not None and starts is None
    refuse_idle((idle, "--seed", "without --starts", "add --starts N"))
    if trace is not None or det is not None:
        names = "-c", "--set", "--rpm", "--vary", "--starts", "--explain"
        given_too = request.config, request.sets, request.rpm, vary, starts, explain
        why = "with --trace", "leave it out: no machine"
        beside = zip(names, given_too, strict=True)
        refuse_idle(*((x not in (None, False), name, *why) for name, x in beside))
        return _border_collision(request, trace, det)
    values = ranges(request, "classify", vary)
    values |= given("classify", starts=starts, seed=seed, explain=explain)
    return run("classify", request, values, show)


def show(result: Result, verbose: bool) -> None:
    """Print ranges of one label, the explanation, and the check."""
    from camcli.words.classify import motions_title, remarks
    from camcli.words.speeds import range_heads

    (motions, explanation), key = result.values, result.scene.classify.key
    alike = groupby(motions, lambda m: (m.label, m.status))
    kind = result.scene.cam.kind
    rows = [_range_row(list(group), verbose, kind) for _, group in alike]
    title = motions_title(motions, key, len(rows), kind)
    more = ["chatter", "transient"] if verbose else []
    words = [] if verbose else ["motion"]
    columns = ["label", *words, *range_heads(key), "impacts", "exponent", *more]
    table(title, columns, rows, "classify.csv", cut="label")
    if explanation is not None:
        show_explanation(explanation, verbose)
    for line in remarks(motions, key, verbose):
        say(line, "- ")
    if not verbose:
        print(MORE)


def _range_row(group: list[ClassifiedMotion], verbose: bool, kind: str) -> list[str]:
    """The line on the screen for consecutive motions of one label and status.

    verbose: chatter and transient instead of what the label means; kind: of the cam.
    """
    from camcli.words.classify import exponent_text
    from camcli.words.labels import motion

    a, b = group[0], group[-1]
    measured = [m.exponents for m in group if m.exponents is not None]
    transients = [m.transient for m in group if m.transient is not None]
    turns = f"{min(transients)} to {max(transients)}" if transients else ""
    words, more = ([], [a.chatter, turns]) if verbose else ([motion(a.label, kind)], [])
    return [
        shown(a.label), *words, f"{a.value:.10g}", f"{b.value:.10g}",
        "" if a.fault is not None else f"{a.impacts:.4g}",
        exponent_text([(e.largest, e.spread) for e in measured]), *more,
    ]  # fmt: skip


def show_explanation(explanation: Explanation, verbose: bool) -> None:
    """Print the events, the changes and a sentence for each."""
    from camcli.words.explanations import change_line
    from camcli.words.speeds import speed_text

    rows = [
        [speed_text(e.rpm, e.error), f"{e.kind} {e.corner}".strip(), shown(e.label, NARROW),
         f"{e.error:.0e}", e.classification]
        for e in explanation.events
    ]  # fmt: skip
    columns = ["rpm", "event", "motion", "error", "class"]
    hidden = 0 if verbose else 2
    table("Critical speeds of attractors", columns, rows, hidden=hidden)
    rows = [
        [f"{c.low:.10g} - {c.high:.10g}", *(shown(x, NARROW) for x in (c.before, c.after)), c.cause]
        for c in explanation.changes
    ]
    table("Changes of the diagram", ["rpm", "from", "to", "cause"], rows)
    for c in explanation.changes:
        say(change_line(c, explanation.events, verbose), "- ")


def _border_collision(request: Request, trace: str | None, det: str | None) -> int:
    """Print the class, the inequalities and what attracts on each side."""
    from camcli.analysis.border_collision import Side, classify
    from camcli.output.run_folder import run_folder
    from camcli.output.run_record import to_text

    pairs = []
    for name, text, example in (("--trace", trace, "1.64,1.37"), ("--det", det, "0.64,0.64")):
        two = numbers(text, name, "two numbers L,R", example)
        if two is None:
            expected, cure = "expected both --trace and --det", f"e.g. {name} {example}"
            raise SceneError(Fault(name, "", f"found no {name}", expected, cure))
        pairs.append(two)
    left, right = (Side(*side) for side in zip(*pairs, strict=True))
    result = classify(left, right)
    text = to_text(_record(left, right, result))
    if request.out is not None and not request.dry_run:
        with run_folder(request.out) as store:
            store.write_text("border_collision.json", [text])
            store.commit()
    if request.json:
        print(text, end="")
    else:
        _show_collision(left, right, result)
    return 0


def _show_collision(left: Side, right: Side, result: Collision) -> None:
    """Print both sides, the inequalities, fixed points and 2-cycle, and what follows."""
    from camcli.words.border_collision import collision_words, inequality_text

    rows = [
        [name, f"{s.trace:.10g}", f"{s.det:.10g}", pair(s.multipliers, 9), s.kind]
        for name, s in (("L", left), ("R", right))
    ]
    table(f"Border collision: {result.kind}", ["side", "trace", "det", "multipliers", "is"], rows)
    rows = [
        [inequality_text(i), f"{i.left:.9g}", f"{i.right:.9g}", "holds" if i.holds else "fails"]
        for i in result.inequalities
    ]
    table("Inequalities", ["inequality", "left", "right", ""], rows)
    where = {1: "parameter > 0", -1: "parameter < 0", 0: "never"}
    rows = [
        [c.word, where[c.exists_for], "yes" if c.stable else "no", pair(c.multipliers, 9)]
        for c in result.cycles
    ]
    table("Fixed points and the 2-cycle", ["word", "exists for", "stable", "multipliers"], rows)
    for line in collision_words(result):
        print(f"- {line}")


def _record(left: Side, right: Side, result: Collision) -> dict[str, Any]:
    """The content of border_collision.json."""
    from camcli.words.border_collision import collision_words, inequality_record

    return {
        "kind": result.kind,
        "sides": {
            name: {"trace": s.trace, "det": s.det, "kind": s.kind, "stable": s.stable,
                   "multipliers": list(map(complex, s.multipliers))}
            for name, s in (("L", left), ("R", right))
        },
        "inequalities": [inequality_record(i) for i in result.inequalities],
        "cycles": [
            {"word": c.word, "stable": c.stable, "exists_for_mu": c.exists_for,
             "multipliers": list(map(complex, c.multipliers)), "points": c.points}
            for c in result.cycles
        ],
        "below": vars(result.below), "above": vars(result.above), "words": collision_words(result),
    }  # fmt: skip
