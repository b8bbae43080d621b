"""cam classify, and its calculator of border collisions, which needs no scene"""

from __future__ import annotations

from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from camcli.cli.options import Request, Vary
from camcli.errors import Fault, SceneError

if TYPE_CHECKING:
    from camcli.analysis.border_collision import Collision, Cycle, Side
    from camcli.analysis.classify import Motion
    from camcli.analysis.explain.changes import Explanation
    from camcli.analysis.explain.events import Event
    from camcli.api.result import Result

SHOWN = 40  # rows of a table on stdout
LONG = 60  # characters of a cell


def classify(
    request: Request,
    starts: Annotated[
        int | None, Option("--starts", help="Further starts at each speed.", metavar="N")
    ] = None,
    seed: Annotated[
        int | None, Option("--seed", help="Another cloud of starts.", metavar="N")
    ] = None,
    explain: Annotated[bool, Option("--explain", help="Find the cause of every change.")] = False,
    vary: Vary = None,
    trace: Annotated[
        str | None, Option("--trace", help="Traces of two linear maps.", metavar="L,R")
    ] = None,
    det: Annotated[str | None, Option("--det", help="Their determinants.", metavar="L,R")] = None,
) -> int:
    """Name the motion at each speed, measure its exponents, explain where it changes.

    \b
    classify.csv  rpm, label, period, impacts, chatter, stable, lyapunov_per_period, status,
                  holds_for
    corners.csv   corner impacts of the solved branches (--explain), columns as bifurcations.csv
    classify.png  labels and largest exponent against speed

    \b
    period: turns, 0 where the motion does not repeat. impacts: in one period, inf with a complete
    chatter; of an aperiodic motion the mean per turn. chatter: complete, incomplete (8 impacts in a
    row, each weaker, that do not accumulate) or none. stable: 1, 0, empty where no orbit is solved.
    lyapunov_per_period: largest exponent per turn of the cam; -inf where the follower rests: both
    are then, since every difference is forgotten. run.json has the second one, the error bar, and
    the sum rule (sum = 2 ln r impacts per turn - b T/m) as a check.

    \b
    Labels: P(m;s1:...:sm) where Newton's iteration from the end of the record converges to an
    admissible, attracting orbit of up to 64 turns that the record approaches; contact; aperiodic
    where none does and the largest exponent is positive by three standard errors; undecided where
    neither can be shown, or where a cycle through a rest is an accident of rounding.
    holds_for: after a rest whose motion doubles forget, the label is decided in ball arithmetic,
    and this says for which machines. last-digit: proved for every speed that rounds to this one;
    exact-data: for the data as they are, not for every speed within the last digit; sampled: for
    three speeds within the last digit that agree, the data themselves may do otherwise. Empty
    where doubles tell, or nothing does.
    --vary KEY=LO:HI varies any number of follower, cam or run, at the speed --rpm; the first column
    then bears the KEY.
    --starts N classifies N more starts at each speed (Halton points, --seed): a row per attractor.

    \b
    --explain goes through the range, follows every attracting orbit found, and gives each change
    its cause, solved: period-doubling, fold, corner-impact (with its border-collision class),
    grazing, accumulation-at-corner, corner-hit, chatter-completion, first-detachment,
    interior-crisis, boundary-crisis, basin (both attractors live on, the start changes basins),
    itinerary (impacts of a resting orbit change), or unexplained with what was tried.
    --trace L,R --det L,R needs no machine: it names the border collision of two linear maps.
    """
    from camcli.cli.run import given, ranges, run

    if seed is not None and starts is None:
        found, cure = "found it without --starts", "add --starts N"
        raise SceneError(Fault("--seed", "", found, "it means nothing there", cure))
    if trace is not None or det is not None:
        return _border_collision(request, trace, det)
    values = ranges(request, "classify", vary) | given(
        {
            "classify.starts": (starts, "--starts"),
            "classify.seed": (seed, "--seed"),
            "classify.explain": (explain, "--explain"),
        }
    )
    return run("classify", request, values, show)


def show(result: Result) -> None:
    """Print ranges of one label, the explanation, and the check."""
    from camcli.api.classify import remarks
    from camcli.cli.report import plural, table

    (motions, explanation), key = result.values, result.scene.classify.key
    groups = _ranges(motions)
    rows = [_range_row(group) for group in groups]
    title = f"{plural(len(motions), 'motion')}, {plural(len(groups), 'range')} of one label"
    if len(rows) > SHOWN:
        title += f", the first {SHOWN} (all of them in classify.csv)"
    columns = [
        "label",
        f"from ({key})",
        f"to ({key})",
        "impacts",
        "chatter",
        "exponent",
        "transient",
    ]
    table(title, columns, rows[:SHOWN])
    if explanation is not None:
        show_explanation(explanation)
    for line in remarks(motions, key):
        print(f"- {line}")


def _ranges(motions: list[Motion]) -> list[list[Motion]]:
    key = lambda m: (m.label, m.status)  # noqa: E731 - used once
    return [list(group) for _, group in groupby(motions, key)]


def _range_row(group: list[Motion]) -> list[str]:
    a, b = group[0], group[-1]
    transients = [m.transient for m in group if m.transient is not None]
    turns = f"{min(transients)} to {max(transients)}" if transients else ""
    return [
        _short(a.label), f"{a.value:.10g}", f"{b.value:.10g}", f"{a.impacts:.4g}", a.chatter,
        _exponent(group), turns,
    ]  # fmt: skip


def _exponent(group: list[Motion]) -> str:
    found = [m.exponents for m in group if m.exponents is not None]
    if not found:
        return ""
    if len(found) == 1:
        e = found[0]
        return f"{e.largest:.6g}" + (f" +- {e.spread:.1g}" if e.spread > 0.0 else "")
    values = [e.largest for e in found]
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    return low if low == high else f"{low} to {high}"


def _short(text: str) -> str:
    return text if len(text) <= LONG else text[: LONG - 3] + "..."


def show_explanation(explanation: Explanation) -> None:
    """Print the events, the changes and a sentence for each."""
    from camcli.cli.report import table
    from camcli.output.explanations import change_sentence

    rows = [
        [_digits(e.rpm, e.error), f"{e.error:.0e}", _kind(e), _short(e.label), e.classification]
        for e in explanation.events
    ]
    table("Critical speeds of attractors", ["rpm", "error", "event", "motion", "class"], rows)
    rows = [
        [f"{c.low:.10g} - {c.high:.10g}", _short(c.before), _short(c.after), c.cause]
        for c in explanation.changes
    ]
    table("Changes of the diagram", ["rpm", "from", "to", "cause"], rows)
    for c in explanation.changes:
        sentence = change_sentence(c, explanation.events)
        print(f"- {c.low:.10g} to {c.high:.10g} rpm, {c.cause}: {sentence}")


def _digits(rpm: float, error: float) -> str:
    """A speed with the digits its error allows, ten at most."""
    if not 0.0 < error < 1.0:
        return f"{rpm:.10g}"
    decimals = min(max(0, 1 - int(f"{error:e}".split("e")[1])), 9)
    return f"{float(f'{rpm:.{decimals}f}'):.10g}"


def _kind(event: Event) -> str:
    return f"{event.kind} {event.corner}".strip()


def _border_collision(request: Request, trace: str | None, det: str | None) -> int:
    """Print the class, the inequalities and what attracts on each side."""
    from camcli.analysis.border_collision import Side, classify
    from camcli.output.run_record import to_text

    traces, dets = _pair(trace, "--trace"), _pair(det, "--det")
    left, right = (Side(t, d) for t, d in zip(traces, dets, strict=True))
    result = classify(left, right)
    if request.json:
        print(to_text(_record(left, right, result)), end="")
    else:
        _show_collision(left, right, result)
    return 0


def _pair(text: str | None, option: str) -> list[float]:
    cure = "e.g. --trace 1.64,1.37 --det 0.64,0.64"
    if text is None:
        found = f"found no {option}"
        raise SceneError(Fault(option, "", found, "expected both --trace and --det", cure))
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 2 or not all(isfinite(value) for value in values):
        found = f"found '{text}'"
        raise SceneError(Fault(option, "", found, "expected two numbers L,R", cure))
    return values


def _show_collision(left: Side, right: Side, result: Collision) -> None:
    from camcli.cli.report import table
    from camcli.plots.event_words import collision_words

    rows = [
        [name, f"{s.trace:.10g}", f"{s.det:.10g}", _multipliers(s.multipliers), s.kind]
        for name, s in (("L", left), ("R", right))
    ]
    table(f"Border collision: {result.kind}", ["side", "trace", "det", "multipliers", "is"], rows)
    rows = [
        [i.text, f"{i.left:.9g}", f"{i.right:.9g}", "holds" if i.holds else "fails"]
        for i in result.inequalities
    ]
    table("Inequalities", ["inequality", "left", "right", ""], rows)
    table(
        "Fixed points and the 2-cycle",
        ["word", "exists for", "stable", "multipliers"],
        [_cycle(cycle) for cycle in result.cycles],
    )
    for line in collision_words(result):
        print(f"- {line}")


def _cycle(cycle: Cycle) -> list[str]:
    where = {1: "parameter > 0", -1: "parameter < 0", 0: "never"}[cycle.exists_for]
    return [cycle.word, where, "yes" if cycle.stable else "no", _multipliers(cycle.multipliers)]


def _multipliers(pair) -> str:
    first, second = pair
    if isinstance(first, complex) and first.imag:
        return f"{first.real:.9g} +- {abs(first.imag):.9g} i"
    return f"{complex(first).real:.9g}, {complex(second).real:.9g}"


def _record(left: Side, right: Side, result: Collision) -> dict[str, Any]:
    from camcli.plots.event_words import collision_words

    return {
        "kind": result.kind,
        "sides": {
            name: {"trace": s.trace, "det": s.det, "kind": s.kind, "stable": s.stable,
                   "multipliers": list(map(complex, s.multipliers))}
            for name, s in (("L", left), ("R", right))
        },
        "inequalities": [{**vars(i), "holds": i.holds} for i in result.inequalities],
        "cycles": [
            {"word": c.word, "stable": c.stable, "exists_for_mu": c.exists_for,
             "multipliers": list(map(complex, c.multipliers)), "points": c.points}
            for c in result.cycles
        ],
        "below": vars(result.below), "above": vars(result.above), "words": collision_words(result),
    }  # fmt: skip
