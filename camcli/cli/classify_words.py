"""What `cam classify` says: tables for people, and the same as plain values for run.json."""

from __future__ import annotations

from itertools import groupby
from math import inf, isfinite
from typing import Any

from camcli.analysis.classify import Motion
from camcli.analysis.explain.changes import Explanation
from camcli.analysis.explain.events import Event
from camcli.analysis.exponents import Exponents
from camcli.analysis.sweep import status_name
from camcli.cli.report import table
from camcli.output.explanations import change_sentence, explained

SHOWN = 40  # rows of a table on stdout
LONG = 60  # characters of a cell


def show(motions: list[Motion], explanation: Explanation | None) -> None:
    """Print ranges of one label, the explanation, and the check."""
    groups = _ranges(motions)
    rows = [_range_row(group) for group in groups]
    title = f"{len(motions)} motions, {len(groups)} ranges of one label"
    if len(rows) > SHOWN:
        title += f", the first {SHOWN} (all of them in classify.csv)"
    columns = ["label", "from (rpm)", "to (rpm)", "impacts", "chatter", "exponent", "transient"]
    table(title, columns, rows[:SHOWN])
    if explanation is not None:
        show_explanation(explanation)
    for line in remarks(motions):
        print(f"- {line}")


def _ranges(motions: list[Motion]) -> list[list[Motion]]:
    key = lambda m: (m.label, m.status)  # noqa: E731 - used once
    return [list(group) for _, group in groupby(motions, key)]


def _range_row(group: list[Motion]) -> list[str]:
    a, b = group[0], group[-1]
    transients = [m.transient for m in group if m.transient is not None]
    turns = f"{min(transients)} to {max(transients)}" if transients else ""
    return [
        _short(a.label), f"{a.rpm:.10g}", f"{b.rpm:.10g}", f"{a.impacts:.4g}", a.chatter,
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
        print(
            f"- {c.low:.10g} to {c.high:.10g} rpm, {c.cause}: "
            f"{change_sentence(c, explanation.events)}"
        )


def _digits(rpm: float, error: float) -> str:
    """A speed with the digits its error allows, ten at most."""
    if not 0.0 < error < 1.0:
        return f"{rpm:.10g}"
    decimals = min(max(0, 1 - int(f"{error:e}".split("e")[1])), 9)
    return f"{float(f'{rpm:.{decimals}f}'):.10g}"


def _kind(event: Event) -> str:
    return f"{event.kind} {event.corner}".strip()


def remarks(motions: list[Motion]) -> list[str]:
    """Sentences: the sum rule, sticking, what is undecided."""
    said = []
    defects = [abs(m.exponents.defect) for m in motions if m.exponents and _finite(m.exponents)]
    if defects:
        said.append(
            "sum of the exponents minus (2 ln r) impacts per turn + b T/m: at most "
            f"{max(defects):.1g} over {len(defects)} motions"
        )
    if any(m.exponents and m.exponents.largest == -inf for m in motions):
        said.append(
            "where the follower rests on the cam both exponents are -inf: every difference between "
            "two motions is forgotten"
        )
    undecided = [m for m in motions if m.label == "undecided"]
    if undecided:
        rpms = ", ".join(f"{m.rpm:.10g}" for m in undecided[:5])
        more = ", ..." if len(undecided) > 5 else ""
        said.append(
            f"undecided at {len(undecided)} speeds ({rpms}{more}): no orbit up to 64 turns could "
            "be solved and no positive exponent shown, or a rest is forgotten before the next one"
        )
    return said


def _finite(e: Exponents) -> bool:
    return isfinite(e.largest) and isfinite(e.second)


def summary(motions: list[Motion], explanation: Explanation | None) -> dict[str, Any]:
    """The result of run.json."""
    result: dict[str, Any] = {
        "words": remarks(motions),
        "motions": [_motion(m) for m in motions],
    }
    if explanation is not None:
        result |= explained(explanation)
    return result


def _motion(m: Motion) -> dict[str, Any]:
    e = m.exponents
    return {
        "rpm": m.rpm, "label": m.label, "period": m.period, "impacts": _plain(m.impacts),
        "chatter": m.chatter, "stable": m.stable, "transient_turns": m.transient,
        "status": status_name(m.status), "start": vars(m.start),
        "multipliers": None if m.orbit is None else [[z.real, z.imag] for z in m.orbit.multipliers],
        "exponents": None if e is None else {
            "largest": _plain(e.largest), "second": _plain(e.second), "standard_error": e.spread,
            "sum_rule": _plain(e.rule), "defect": _plain(e.defect),
        },
    }  # fmt: skip


def _plain(value: float) -> float | str | None:
    """JSON has no infinities: they are words, and nan is null."""
    if isfinite(value):
        return value
    return None if value != value else ("inf" if value > 0.0 else "-inf")
