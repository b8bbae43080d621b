"""The answer in a sentence or two, before any table: does contact hold, up to where, what then."""

from collections.abc import Iterator, Mapping
from math import ceil, degrees
from typing import Any, NamedTuple

import camcli.analysis.contact_loss.detachment as loss
from camcli.analysis.contact_loss.hold import Hold, HoldStatus
from camcli.quantities import Units
from camcli.system import decimals, units_of
from camcli.words.detach import way
from camcli.words.detach_tables import spacing
from camcli.words.machine import crank_of


def verdict(
    result: Any, found: loss.Detachment | None, lift_table: Mapping[str, Any] | None
) -> list[str]:
    """Sentences on a `Result`.

    found: where contact is lost, None where only one motion is told; lift_table: what run.json says
    of the error of a measured cam.
    """
    crank = crank_of(result.scene)
    if found is None:
        return [_at_one_speed(result, crank)]
    if found.always:
        kink = found.always[0].reason is loss.Reason.KINK
        why = "the cam's slope drops" if kink else "the spring does not press even at standstill"
        return [
            f"Contact is lost at every speed: {why} at {degrees(found.always[0].theta):.4g} deg."
        ]
    if found.first is None:
        return ["Contact holds at every speed."]
    low, high = lift_table["first_detachment_rpm"] if lift_table else (None, None)
    holds = f"Contact holds up to {_speed(found.first.rpm, low, high, crank)}"
    surge = result.summary.get("surge", {}).get("words", [])
    sentences = [holds + "".join(_past(result)), *_springs(result), *_tolerances(result), *surge]
    return [f"{sentence}." for sentence in sentences]


def _speed(rpm: float, low: float | None, high: float | None, crank: float) -> str:
    """3347 +- 36 rpm of the cam (6693 of the crank); as many digits as the data deserve."""
    form, error = ".6g", ""
    if low is not None and high is not None:
        width = max(high - rpm, rpm - low)
        digits = decimals(width)
        form, error = f".{digits}f", f" +- {ceil(width * 10**digits) / 10**digits:g}"
    elif low is not None:
        error = f" (from {low:.4g} on, or never)"
    beside = f" ({crank * rpm:{form}} of the crank)" if crank else ""
    return f"{rpm:{form}}{error} rpm of the cam{beside}"


def _at_one_speed(result: Any, crank: float) -> str:
    """The sentence on one motion: whether contact holds, and how hard the follower lands.

    crank: turns of the crank in one of the cam, 0 where there is none.
    """
    speed = _speed(result.scene.run.rpm, None, None, crank)
    if "events" not in result.tables:
        return f"This is the cam alone, with the contact force at {speed}."
    landing = max((-u for u in result.tables["events"]["u_minus_m_per_s"] if u < 0.0), default=0.0)
    if landing == 0.0:
        flies = "flight" in result.tables["trajectory"]["contact"]
        seen = "is lost: the follower does not land" if flies else "holds"
        return f"At {speed} contact {seen} in the turns recorded."
    return f"At {speed} contact is lost: the follower lands at up to {landing:.2g} m/s."


class _Landing(NamedTuple):
    """Columns of speeds.csv, of a speed at which the follower lands; compared by the first."""

    max_impact_m_per_s: float
    landing_deg: float
    landing_lift_m: float
    max_gap_m: float
    rpm: float
    shut_bounces_per_turn: float


def _past(result: Any) -> Iterator[str]:
    """Clauses on what was seen past the loss of contact, none where nothing was."""
    table = result.tables.get("speeds")
    if table is None or not {"rpm", "max_impact_m_per_s"} <= set(table.columns):
        return
    columns = table.arrays(*_Landing._fields)
    rows = [_Landing(*row) for row in zip(*columns.values(), strict=True)]
    landings = [row for row in rows if row.max_impact_m_per_s > 0.0]
    if not landings:
        return
    hardest = max(landings)
    gap = max(row.max_gap_m for row in landings)
    bounces = max(row.shut_bounces_per_turn for row in landings)
    slowest, fastest = min(row.rpm for row in landings), max(row.rpm for row in landings)
    where = f"at {fastest:.6g} rpm"
    if slowest < fastest:
        digits = decimals(spacing(columns["rpm"]))
        where = f"from {round(slowest, digits):.10g} to {round(fastest, digits):.10g} rpm"
    u, lengths = hardest.max_impact_m_per_s, units_of(result.system).lengths
    speed = f"{u:.0f}" if u >= 10.0 else f"{u:.2g}"
    place = f"{hardest.landing_deg:.4g} deg, {lengths(hardest.landing_lift_m)} above its lowest"
    yield f"; past it, {where}, the follower lands at up to {speed} m/s"
    yield f" ({place}), flies up to {lengths(gap)} off the cam"
    yield f", and bounces on the shut cam ({bounces:.2g} a turn at most)" if bounces else ""


def _springs(result: Any) -> Iterator[str]:
    """Sentences on the springs that --hold-to asked for."""
    holds, units = getattr(result.values, "holds", ()), units_of(result.system)
    if not holds:
        return
    rpm, margin = result.scene.detach.hold_to, result.values.margin
    asked = f"up to {rpm:g} rpm of the cam with {margin:.3g} N to spare"
    if any(h.quantity is loss.CriticalQuantity.HOLD_PRELOAD and not h.more for h in holds):
        yield f"The present spring holds {asked}"
        return
    springs = [
        f"{way(hold)}: {spring_words(hold, units)}"
        for hold in holds
        if hold.status is HoldStatus.OK
    ]
    yield f"To hold {asked}: {'; or '.join(springs) or 'no spring can be named, see below'}"
    if result.scene.spring is not None and result.scene.spring.solid_at is not None:
        yield "Where a spring of another rate is solid is not known: solid_at is the present one's"


def _tolerances(result: Any) -> Iterator[str]:
    """The chance and the worst case within the tolerances."""
    summary = result.summary.get("tolerance")
    if summary is None:
        return
    off = ", ".join(f"{t.key} {t.percent:g} %" for t in result.scene.detach.tolerance)
    off += ", the error of the table" if result.scene.cam.kind == "table" else ""
    yield (
        f"Within the tolerances ({off}) contact holds up to {summary['median_rpm']:.4g} rpm of the "
        f"cam in half of the machines, up to {summary['worst_rpm']:.4g} in the worst"
    )
    for hold in result.values.holds:
        spring = summary["springs"].get(hold.quantity)
        if spring is None or hold.status is not HoldStatus.OK:
            continue
        yield (
            f"With {way(hold)} {100.0 * spring['chance']:.3g} % of them hold "
            f"up to {result.scene.detach.hold_to:g}, the worst up to {spring['worst_rpm']:.4g}"
        )


def spring_words(hold: Hold, units: Units) -> str:
    """Stiffness and preload of a spring, as far as they are not those of the present one."""
    stiffness, preload = units.stiffnesses(hold.stiffness or 0.0), f"{hold.preload:.4g} N"
    if hold.quantity is loss.CriticalQuantity.HOLD_BOTH:
        return f"{stiffness} with {preload} of preload"
    return preload if hold.quantity is loss.CriticalQuantity.HOLD_PRELOAD else stiffness
