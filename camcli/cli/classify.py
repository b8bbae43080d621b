"""cam classify, and its calculator of border collisions, which needs no scene"""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any

from camcli.cli.options import VARY, Request, flag, given, numbers, option, refuse_idle
from camcli.cli.report import MORE, pair, say, table
from camcli.errors import Fault, SceneError, is_given, shown

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
        refuse_idle(*((is_given(x), name, *why) for name, x in beside))
        return _border_collision(request, trace, det)
    values = ranges(request, "classify", vary)
    values |= given("classify", starts=starts, seed=seed, explain=explain)
    return run("classify", request, values, show)


def show(result: Result, verbose: bool) -> None:
    """Print ranges of one label, the explanation, and the check."""
    from camcli.words.classify import motions_title, remarks
    from camcli.words.speeds import range_heads

    motions, explanation = result.values
    key = result.scene.classify.key
    kind = result.scene.cam.kind
    by_label = groupby(motions, lambda motion: (motion.label, motion.status))
    rows = [_range_row(list(group), verbose, kind) for _, group in by_label]
    title = motions_title(motions, key, len(rows), kind)
    if verbose:
        heads = ["label", *range_heads(key), "impacts", "exponent", "chatter", "transient"]
    else:
        heads = ["label", "motion", *range_heads(key), "impacts", "exponent"]
    table(title, heads, rows, "classify.csv", cut="label")
    if explanation is not None:
        show_explanation(explanation, verbose)
    for line in remarks(motions, key, verbose):
        say(line, "- ")
    if not verbose:
        print(MORE)


def _range_row(motions: list[ClassifiedMotion], verbose: bool, kind: str) -> list[str]:
    """The line on the screen for consecutive motions of one label and status.

    verbose: chatter and transient instead of what the label means; kind: of the cam.
    """
    from camcli.words.classify import exponent_text
    from camcli.words.labels import motion as motion_words

    first = motions[0]
    last = motions[-1]
    impacts = "" if first.fault is not None else f"{first.impacts:.4g}"
    exponents = [motion.exponents for motion in motions if motion.exponents is not None]
    exponent = exponent_text([(each.largest, each.spread) for each in exponents])
    common = [f"{first.value:.10g}", f"{last.value:.10g}", impacts, exponent]
    label = shown(first.label)
    if not verbose:
        return [label, motion_words(first.label, kind), *common]
    transients = [motion.transient for motion in motions if motion.transient is not None]
    turns = f"{min(transients)} to {max(transients)}" if transients else ""
    return [label, *common, first.chatter, turns]


def show_explanation(explanation: Explanation, verbose: bool) -> None:
    """Print the events, the changes and a sentence for each."""
    from camcli.words.explanations import change_line
    from camcli.words.speeds import speed_text

    rows = [
        [
            speed_text(event.rpm, event.error),
            f"{event.kind} {event.corner}".strip(),
            shown(event.label, NARROW),
            f"{event.error:.0e}",
            event.classification,
        ]
        for event in explanation.events
    ]
    heads = ["rpm", "event", "motion", "error", "class"]
    table("Critical speeds of attractors", heads, rows, hidden=0 if verbose else 2)
    rows = [
        [
            f"{change.low:.10g} - {change.high:.10g}",
            shown(change.before, NARROW),
            shown(change.after, NARROW),
            change.cause,
        ]
        for change in explanation.changes
    ]
    table("Changes of the diagram", ["rpm", "from", "to", "cause"], rows)
    for change in explanation.changes:
        say(change_line(change, explanation.events, verbose), "- ")


def _border_collision(request: Request, trace: str | None, det: str | None) -> int:
    """Print the class, the inequalities and what attracts on each side."""
    from camcli.analysis.border_collision import Side, classify
    from camcli.output.run_folder import run_folder
    from camcli.output.run_record import to_text

    left_trace, right_trace = _left_and_right("--trace", trace, "1.64,1.37")
    left_det, right_det = _left_and_right("--det", det, "0.64,0.64")
    left = Side(left_trace, left_det)
    right = Side(right_trace, right_det)
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


def _left_and_right(option: str, text: str | None, example: str) -> list[float]:
    """The numbers L,R of an option; raises SceneError where it is not given."""
    values = numbers(text, option, "two numbers L,R", example)
    if values is None:
        expected = "expected both --trace and --det"
        raise SceneError(
            Fault(option, "", f"found no {option}", expected, f"e.g. {option} {example}")
        )
    return values


def _show_collision(left: Side, right: Side, result: Collision) -> None:
    """Print both sides, the inequalities, fixed points and 2-cycle, and what follows."""
    from camcli.words.border_collision import collision_words, inequality_text

    rows = [
        [
            name,
            f"{side.trace:.10g}",
            f"{side.det:.10g}",
            pair(side.multipliers, 9),
            side.kind,
        ]
        for name, side in (("L", left), ("R", right))
    ]
    table(f"Border collision: {result.kind}", ["side", "trace", "det", "multipliers", "is"], rows)
    rows = [
        [
            inequality_text(inequality),
            f"{inequality.left:.9g}",
            f"{inequality.right:.9g}",
            "holds" if inequality.holds else "fails",
        ]
        for inequality in result.inequalities
    ]
    table("Inequalities", ["inequality", "left", "right", ""], rows)
    exists_for = {1: "parameter > 0", -1: "parameter < 0", 0: "never"}
    rows = [
        [
            cycle.word,
            exists_for[cycle.exists_for],
            "yes" if cycle.stable else "no",
            pair(cycle.multipliers, 9),
        ]
        for cycle in result.cycles
    ]
    table("Fixed points and the 2-cycle", ["word", "exists for", "stable", "multipliers"], rows)
    for line in collision_words(result):
        say(line, "- ")


def _record(left: Side, right: Side, result: Collision) -> dict[str, Any]:
    """The content of border_collision.json."""
    from camcli.words.border_collision import collision_words, inequality_record

    return {
        "kind": result.kind,
        "sides": {
            name: {
                "trace": side.trace,
                "det": side.det,
                "kind": side.kind,
                "stable": side.stable,
                "multipliers": [complex(multiplier) for multiplier in side.multipliers],
            }
            for name, side in (("L", left), ("R", right))
        },
        "inequalities": [inequality_record(inequality) for inequality in result.inequalities],
        "cycles": [
            {
                "word": cycle.word,
                "stable": cycle.stable,
                "exists_for_mu": cycle.exists_for,
                "multipliers": [complex(multiplier) for multiplier in cycle.multipliers],
                "points": cycle.points,
            }
            for cycle in result.cycles
        ],
        "below": vars(result.below),
        "above": vars(result.above),
        "words": collision_words(result),
    }
